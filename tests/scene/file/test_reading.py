"""Files that are no scene: each gives one message."""

import os
import random

import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.file import DEEPEST_NAME, LARGEST_SCENE
from mbconstrained.scene.run.scene import read_scene

RNG = random.Random(20)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "scene.toml: the file is empty; a scene has at least"),
        (b" \n\t\r\n", "the file is empty"),
        (b"\xff\xfet\x00i\x00", "line 1 is not UTF-8 text; save the file with the encoding UTF-8"),
        ("title = 'a'\nsource = 'M\u00fcller'".encode("latin-1"), "line 2 is not UTF-8"),
        (RNG.randbytes(10_000_000), f"more than {LARGEST_SCENE:,} bytes, which is no scene; keep large matrices in"),
        (b"a" * 900_000, "not a TOML file"),
        (b"x = " + b"[" * 400_000, "nested too deeply"),
        (b"x = " + b"{a=" * 200_000, "nested too deeply"),
        (b"a." * 200_000 + b"a = 1", f"a name of more than {DEEPEST_NAME} parts"),
        (b"x = { " + b"'a' . " * 100_000 + b"a = 1 }", f"a name of more than {DEEPEST_NAME} parts"),
        (b"x = " + b"9" * 100_000, "far too many digits"),
        (b"[time]\nend = 1\nend = 2\n[model]", 'a key is given twice; at line 3.*near "end = 2"'),
        (b"[time]\nend = 1\n[time]\nend = 2", r"the table \[time\] stands there twice; write it once; at line 3"),
        (b"[time]\nend = 3 s", 'a text such as "3 N/mm" needs quotes; at line 2, column 9, near "end = 3 s"'),
        (b"[time]\nend = fast", 'this is no value.* needs quotes.*near "end = fast"'),
        (b"[time]\nend = 0,5", 'decimals have a point, as in 0.5; at line 2, column 8, near "end = 0,5"'),
        ("[time]\nend = \u201c5 s\u201d".encode(), "quotes must be straight.*at line 2"),
        (b"[time\nend = 1", r"with as many brackets as it begins with, \[time\], \[\[model.mass\]\]; at line 1"),
        (b"[[model.mass]\nmass = 1", r"with as many brackets as it begins with.*at line 1"),
        (b'title = "two\nlines"', "a text ends with the quote that it begins with, on the same line; at line 1"),
        (b"model:\n  kind: lumped\n", 'expected = between a key and its value, as in end = "5 s"; at line 1.*near "model:"'),
        (b'{"model": {"kind": "lumped"}}', "it looks like JSON or XML; a scene has tables"),
        (b"<?xml version='1.0'?><robot/>", "it looks like JSON or XML"),
        (b"just some words", "expected = between a key and its value"),
        (b"\x00\x01\x02", "not a TOML file"),
        (b"title = 'a\x1b[31m'", "not a TOML file"),
    ],
    ids=lambda value: repr(value)[:40],
)
def test_one_message(tmp_path, content, message):
    path = tmp_path / "scene.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=message) as caught:
        read_scene(path)
    assert str(caught.value).startswith("scene.toml: ")
    assert "\n" not in str(caught.value)
    assert str(caught.value).isprintable()


def test_missing_file_names_the_nearest(tmp_path):
    (tmp_path / "bridge.toml").write_text("")
    with pytest.raises(SceneError, match=r'there is no such file; did you mean "bridge.toml"\?'):
        read_scene(tmp_path / "brigde.toml")
    with pytest.raises(SceneError, match=r"there is no such file$"):
        read_scene(tmp_path / "no" / "folder.toml")


def test_directory_names_a_scene_in_it(tmp_path):
    (tmp_path / "bridge.toml").write_text("")
    with pytest.raises(SceneError, match=f"^{tmp_path.name}: this is a directory; give the scene file in it, e.g. bridge.toml$"):
        read_scene(tmp_path)


def test_special_files_are_not_read(tmp_path):
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(SceneError, match="^pipe.toml: this is not a file; give a scene file$"):
        read_scene(tmp_path / "pipe.toml")
    with pytest.raises(SceneError, match="null: this is not a file"):
        read_scene("/dev/null")


@pytest.mark.parametrize("name", ["a\0b.toml", "x" * 5000 + ".toml"])
def test_names_that_no_file_can_have(name):
    with pytest.raises(SceneError, match="the file cannot be read"):
        read_scene(name)


@pytest.mark.skipif(os.geteuid() == 0, reason="the superuser may read every file")
def test_unreadable_file(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("x = 1")
    path.chmod(0)
    with pytest.raises(SceneError, match="cannot be read .*ermission"):
        read_scene(path)


@pytest.mark.parametrize(("start", "end"), [(b"\xef\xbb\xbf", b"\n"), (b"", b"\r\n"), (b"\t", b"\t# a comment\n")])
def test_byte_order_marks_line_ends_and_tabs_are_no_error(tmp_path, start, end):
    path = tmp_path / "scene.toml"
    path.write_bytes(start + end.join((b"[model]", b"kind = 'matrices'", b"mass = [[1]]", b"[time]", b"end = 1", b"")))
    assert read_scene(path).name == "scene"
