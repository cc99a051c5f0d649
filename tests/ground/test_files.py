"""Files that replace others."""

from concurrent.futures import ThreadPoolExecutor

from mbconstrained.ground.files import Replacements


def test_threads_may_write_the_same_file(tmp_path):
    """Each content is whole, the last one stands; nothing else is left."""

    def write(number):
        for _ in range(30):
            with Replacements() as files:
                files.temporary(tmp_path / "answer.txt").write_text(str(number) * 1000)

    with ThreadPoolExecutor(4) as threads:
        list(threads.map(write, range(4)))
    text = (tmp_path / "answer.txt").read_text()
    assert text == text[0] * 1000 and [path.name for path in tmp_path.iterdir()] == ["answer.txt"]
