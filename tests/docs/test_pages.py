"""The documentation is true: every block of code of every page runs, and its outputs are those that are printed."""

import doctest
import re
import shlex
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest

import mbconstrained as mb
from mbconstrained.docs.pictures import pictures
from tests.docs.test_pictures import check_pictures

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "mbconstrained" / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
GUIDES = [page for room in ("tutorials", "howto") for page in sorted((DOCS / room).glob("*.md")) if page.stem != "index"]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
LANGUAGES = {"python", "sh", "toml", "text", "console"}

#: Studies of half a minute and more, which other tests run: the golden corpus, and tests/analyses/sweep/test_optimisation.py.
ELSEWHERE = ("sweep examples/arm_workspace.toml", "optimise examples/tuned_mass_damper.toml --vary tuning=")

#: Random samples of the documented sweeps: enough for every figure of the page and the plots.
SAMPLES = "16"


def shortened(arguments: list[str]) -> list[str]:
    """The arguments of a command, of a random study those of one with few samples."""
    line = " ".join(arguments)
    if arguments[0] == "sweep" and ("--samples" in arguments or "gear_tolerances" in line):
        return [*arguments, "--samples", SAMPLES]  # the last one counts
    return arguments


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of the blocks of a page, in order, without directives of Sphinx."""
    pairs = re.findall(r"^```([^\n`]*)\n(.*?)^```$", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
    return [(language, text) for language, text in pairs if not language.startswith("{")]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder in which the examples and robots are at hand."""
    for name in ("examples", "robots"):
        (tmp_path / name).symlink_to(ROOT / name)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def check_python(text: str, names: dict, page: str) -> None:
    test = doctest.DocTestParser().get_doctest(text, {}, page, page, 0)
    assert test.examples, "a block of Python shows its outputs: begin its lines with >>>"
    test.globs = names
    report: list[str] = []
    doctest.DocTestRunner(optionflags=FLAGS, verbose=False).run(test, out=report.append, clear_globs=False)
    assert not report, "".join(report)


def check_toml(text: str, folder: Path) -> None:
    """A block that begins with the name of a file is a whole scene; one that begins with # fragment a part of one."""
    title = text.splitlines()[0].removeprefix("#").strip()
    tomllib.loads(text)
    if title != "fragment":
        (folder / title).write_text(text, encoding="utf-8")
        mb.read_scene(folder / title)


def check_excerpt(text: str, printed: str) -> None:
    """A block of text after a command is a part of what it prints; lines of three dots stand for others."""
    assert doctest.OutputChecker().check_output(f"...{text.strip()}...", printed, FLAGS), f"not printed:\n{text}\nbut\n{printed}"


@pytest.mark.long
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.relative_to(DOCS).as_posix())
def test_the_blocks_of_a_page_run_in_order_and_draw_its_pictures(page, folder, command, monkeypatch):
    monkeypatch.chdir(folder)
    names: dict = {}
    printed, pairs, made = "", blocks(page), {}
    shown = {tuple(shlex.split(line)): line for line, file in pictures(page) if file.endswith(".svg")}
    for (language, text), (following, _) in pairwise([*pairs, ("", "")]):
        assert language in LANGUAGES, f"{page.name}: a block of {language or 'no language'}"
        if language == "python":
            check_python(text, names, page.name)
        elif language == "toml":
            check_toml(text, folder)
        elif language == "sh":
            for line in text.splitlines():
                program, *arguments = shlex.split(line, comments=True) or ["", ""]
                is_quoted = following == "text"
                if program == "mbconstrained" and (is_quoted or not " ".join(arguments).startswith(ELSEWHERE)):
                    given = arguments if is_quoted else shortened(arguments)
                    if tuple(given) in shown:
                        out = made[shown[tuple(given)]] = folder / f"pictures {len(made)}"
                        given = [*given, "--plots", "--out", str(out)]
                    code, printed, errors = command(*given)
                    assert code == 0, f"{line}: {errors}"
        elif language == "text" and printed:
            check_excerpt(text, printed)
    check_pictures(page, made)


def without_blocks(page: Path) -> str:
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)


def test_links_between_pages_and_to_files_lead_somewhere():
    missing = [
        f"{page.relative_to(DOCS)}: {target}"
        for page in PAGES
        for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", without_blocks(page))
        if not (page.parent / target).exists()
    ]
    assert not missing


def headings(page: Path) -> set[str]:
    """Anchors of the headings of a page, as GitHub makes them."""
    titles = re.findall(r"^#+ (.+)$", without_blocks(page), re.M)
    return {re.sub(r"[^\w -]", "", title).lower().replace(" ", "-") for title in titles}


def test_links_to_headings_lead_to_one():
    missing = [
        f"{page.name}: {target}#{anchor}"
        for page in [*PAGES, ROOT / "README.md"]
        for target, anchor in re.findall(r"\]\(([^)#:\s]*\.md)#([^)\s]+)\)", page.read_text(encoding="utf-8"))
        if anchor not in headings(page.parent / target)
    ]
    assert not missing


#: Words of systems theory that a mechanical engineer may not know, and their places in the glossary.
THEORY = {
    "eigenvalue": "eigenvalue",
    "transfer function": "transfer-function",
    "state space": "state-space",
    "descriptor (?:system|form)": "descriptor-system",
    "pole": "pole",
    "residue": "residue",
    "Jordan pair": "jordan-pair",
    "Dirac": "dirac-impulse",
    "polynomial matri": "polynomial-matrix",
    "Bohl function": "bohl-function",
    "Laurent": "laurent-coefficient",
    "staircase": "staircase",
    "saltation": "saltation-matrix",
    "Floquet": "floquet-multiplier",
}


@pytest.mark.parametrize("page", [*GUIDES, ROOT / "README.md"], ids=lambda page: page.name)
def test_words_of_systems_theory_are_linked_to_the_glossary(page):
    text = page.read_text(encoding="utf-8")
    prose = re.sub(r"^```.*?^```$|`[^`\n]*`|^#.*?$|^!.*?$|\([^()\s]*\)", "", text, flags=re.M | re.S)
    named = {anchor for word, anchor in THEORY.items() if re.search(rf"\b{word}", prose)}
    assert named - set(re.findall(r"glossary\.md#([\w-]+)\)", text)) == set()


def test_every_page_is_in_a_table_of_contents():
    listed = {
        (page.parent / f"{name}.md").resolve()
        for page in PAGES
        for body in re.findall(r"^```{toctree}\n(.*?)^```$", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
        for name in body.split("\n")
        if name and not name.startswith(":")
    }
    assert {page.resolve() for page in PAGES} - listed == {(DOCS / "index.md").resolve()}


def test_index_pages_link_each_page_of_their_table_of_contents():
    """Readers of the repository do not see the tables of contents of Sphinx."""
    for page in DOCS.glob("*/index.md"):
        text = page.read_text(encoding="utf-8")
        (body,) = re.findall(r"^```{toctree}\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)
        assert [name for name in body.split() if not name.startswith(":") and f"({name}.md)" not in text] == [], page


def test_files_that_the_development_pages_name_exist():
    named = {
        name
        for page in (DOCS / "development").glob("*.md")
        for name in re.findall(r"`([a-z_]+/[\w/]+\.py|(?:tests|robots)/[\w/]+\.(?:py|md))`", page.read_text(encoding="utf-8"))
    }
    missing = [name for name in named if not (ROOT / name).exists() and not (DOCS.parent / name).exists()]
    assert not missing
