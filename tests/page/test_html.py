"""The file: reproducible, closed to the outside, with nothing in it that is not needed, every text a text."""

import base64
import gzip
import hashlib
import json
import os
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

from mbconstrained.ground.display import TextTable
from mbconstrained.ground.errors import InputError, MbconstrainedError
from mbconstrained.page.animation import Animation
from mbconstrained.page.content import Curve, PageContent, Plot, typeset
from mbconstrained.page.drawing import Drawing, DrawnBody
from mbconstrained.page.html import _ANIMATION, _ASSETS, _PLOTS, VIEWER_FILE, page_html, script_json, viewer_script, write_page
from tests.page.contents import HOSTILE, hostile_content, two_masses_content
from tests.page.mode_pages import hostile_modes, two_modes
from tests.page.models import gallery


def data_of(page: str) -> dict:
    return json.loads(re.search(r'<script type="application/json" id="motion-data">(.*?)</script>', page, re.S)[1])


def several_pages() -> list[str]:
    contents = [two_masses_content(), two_modes(), *(PageContent(name, animation=each) for name, each in gallery().items())]
    return list(map(page_html, contents))


def test_another_process_gives_the_same_bytes_and_reads_the_viewer_without_an_import():
    code = (
        "import hashlib, sys\n"
        "from mbconstrained.page.html import page_html\n"
        "from tests.page.contents import two_masses_content\n"
        "page_html(two_masses_content())\n"
        "print(*{'meshcat', 'zmq', 'tornado', 'matplotlib', 'pydantic', 'pinocchio', 'sympy'} & set(sys.modules))\n"
        "from tests.page.test_html import several_pages\n"
        "print(*(hashlib.sha256(page.encode()).hexdigest() for page in several_pages()))\n"
    )
    environment = os.environ | {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo"}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    imported, hashes = run.stdout.splitlines()
    assert hashes.split() == [hashlib.sha256(page.encode()).hexdigest() for page in several_pages()]
    assert imported == ""


def test_a_missing_viewer_is_one_clear_message(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(MbconstrainedError, match='needs the package "meshcat", which is not installed: pip install meshcat'):
        page_html(two_masses_content())


PAGES = pytest.mark.parametrize("content", [two_masses_content(), two_modes()], ids=["run", "modes"])


@PAGES
def test_only_the_two_scripts_of_the_page_may_run(content):
    page = page_html(content)
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)[1]
    scripts = re.findall(r"<script>(.*?)</script>", page, re.S)
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    assert len(scripts) == 2
    assert re.findall(r"'sha256-([^']*)'", policy) == hashes
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe-eval" not in policy and "http" not in policy


@PAGES
def test_the_page_names_no_place_to_load_from(content):
    page = page_html(content).replace(viewer_script(), "")
    assert re.findall(r"<(?:link|img|iframe|object|embed|base|form)\b|\ssrc=|\shref=|url\(|@import", page) == []


@pytest.mark.parametrize("text", [HOSTILE, "</SCRIPT >", "<!--<script>", "\u2028\u2029", "\x00\ud800"])
def test_json_in_a_script_cannot_end_it(text):
    written = script_json({text: text})
    assert not set("<>&\u2028\u2029") & set(written)
    assert json.loads(written) == {text: text}


class Texts(HTMLParser):
    """Elements and texts as a browser sees them."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.texts, self.attributes = [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.attributes += [name for name, _ in attributes]

    def handle_data(self, data):
        self.texts.append(data)


@pytest.mark.parametrize(
    "content, scripts, titles",  # the data of the plots and of the motion, the viewer, the page's own; title, heading and source
    [(hostile_content(), 4, 3), (hostile_modes(), 3, 2)],
    ids=["run", "modes"],
)
def test_hostile_texts_come_out_as_texts(content, scripts, titles):
    page = Texts(page_html(content))
    assert page.tags.count("script") == scripts
    assert not {"img", "b2"} & set(page.tags)
    assert not [name for name in page.attributes if name.startswith("on")]
    assert page.texts.count(content.title) == titles
    assert page.texts.count(HOSTILE) >= 6
    assert page.texts.count("W" * 10_000) >= 6


def test_the_data_are_the_values():
    frames = data_of(page_html(two_masses_content()))["frames"]
    values = two_masses_content().animation.values
    assert frames["names"] == ["x1", "q1", "q2"]
    assert np.array_equal([np.frombuffer(base64.b64decode(row)) for row in frames["values"]], values)
    assert frames["times"] == {"start": 0, "end": 50, "count": 401}


@pytest.mark.parametrize("plotted, size", [(True, 95_000), (False, 24_000)])
def test_without_an_animation_there_is_no_viewer_and_without_plots_too_no_script(plotted, size):
    page = page_html(replace(two_masses_content(), animation=None, **({} if plotted else {"plots": ()})))
    assert len(page) < size
    assert page.count("<script>") == plotted
    left_out = ("MeshCat", "<details>", 'id="stage"', *(() if plotted else ("<button", "<script")))
    assert not [word for word in left_out if word in page]


def test_compressed_the_page_is_a_third_and_holds_the_same():
    page, plain = (page_html(two_masses_content(), viewer) for viewer in ("compressed", "inside"))
    held = re.findall(r'data-content="([^"]*)">([^<]*)<', page)
    texts = {name: gzip.decompress(base64.b64decode(packed)).decode() for name, packed in held}
    assert texts["viewer"] == viewer_script()
    assert json.loads(texts["motion-data"]) == data_of(plain)
    assert all(text in plain for text in texts.values())
    assert len(page) < 450_000 and page == page_html(two_masses_content(), "compressed")
    hashes = {f"'sha256-{base64.b64encode(hashlib.sha256(texts[k].encode()).digest()).decode()}'" for k in ("viewer", "own")}
    assert all(value in page for value in hashes)


def test_beside_its_viewer_a_page_holds_its_own_data_only():
    page = page_html(two_masses_content(), "separate")
    assert len(page) < 225_000
    assert re.findall(r'<script src="([^"]*)"></script>', page) == [VIEWER_FILE]
    assert "script-src 'sha256-" in page_html(replace(two_masses_content(), animation=None), "separate")


def test_a_folded_table_shows_its_title_only():
    table = TextTable("Plan <1>", ("stage",), (("solve",),), "a note", folded=True)
    page = page_html(PageContent("t", tables=(table,)))
    inside = re.search(r"<details><summary><h2>Plan &lt;1&gt;</h2></summary>(.*?)</details>", page, re.DOTALL)[1]
    assert "<td>solve</td>" in inside and "a note" in inside
    assert "<details>" not in page_html(PageContent("t", tables=(replace(table, folded=False),)))


@pytest.mark.parametrize("last", ["run", "modes", "frequency"])
def test_scripts_of_one_page_have_different_names_at_the_top(last):
    """All scripts of a page share one scope, in which the later of two functions of one name is taken."""
    scripts = ["theme", "numbers", *_PLOTS, *_ANIMATION, "overlay", "posing", "switching", "rotors", last]
    text = "\n".join((_ASSETS / f"{name}.js").read_text(encoding="utf-8") for name in scripts)
    names = re.findall(r"^(?:async )?(?:function\*?|const|let|class) (\w+)", text, re.M)
    assert sorted(name for name in set(names) if names.count(name) > 1) == []


EMPTY = Drawing(())


@pytest.mark.parametrize(
    "make, message",
    [
        (lambda: Animation(EMPTY, ("x",), [0, 1], [[0, np.nan]]), "animation, values: the entry at .* is nan"),
        (lambda: Animation(EMPTY, ("x",), [0, 1], [[0, 1, 2]]), "animation, values: expected shape 1 x 2, found 1 x 3"),
        (lambda: Animation(EMPTY, ("x", "y"), [0, 1], [[0, 1]]), "animation, values: expected shape 2 x 2, found 1 x 2"),
        (lambda: Animation(EMPTY, ("x",), [0, 1], [[0, 1]], [[0]]), "animation, rates: expected shape 1 x 2, found 1 x 1"),
        (lambda: Animation(EMPTY, ("x",), [0, 1], [[0, 1e300]]), "found 1e.300, which is too large to draw; give an earlier end"),
        (lambda: Animation(EMPTY, (), [], np.zeros((0, 0))), "animation, times: no times found"),
        (lambda: Plot("p", "m", [0, 2, 1], ()), 'plot "p", times: 2 s is followed by 1 s; times must ascend'),
        (lambda: Plot("p", "m", [0, 0], ()), "0 s is followed by 0 s"),
        (lambda: Plot("p", "m", [0, 1], (Curve("c", [0, np.inf]),)), 'plot "p", curve "c": the entry at .* is inf'),
        (lambda: Plot("p", "m", [0, 1], (Curve("c", [0]),)), 'plot "p", curve "c": expected shape 2, found 1'),
        (lambda: TextTable("t", ("a", "b"), (("1", "2"), ("1",))), 'table "t": row 2 has 1 entries for 2 columns'),
    ],
)
def test_what_cannot_be_shown_is_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_the_file_is_the_page(tmp_path):
    content = PageContent("Größe × 2")
    path = write_page(tmp_path / "page.html", content)
    assert path.read_bytes() == page_html(content).encode("utf-8")
    assert os.listdir(tmp_path) == ["page.html"]


def test_a_failure_leaves_the_earlier_file(tmp_path):
    path = tmp_path / "page.html"
    path.write_text("earlier")
    wrong = Animation(Drawing((DrawnBody("b", moves={"x": (1, 0, 0)}),)), ("x",), [0, 1], [[0, 1e200]])
    with pytest.raises(InputError, match='body "b" is drawn up to 1e'):
        write_page(path, PageContent("t", animation=wrong))
    assert path.read_text() == "earlier"
    assert os.listdir(tmp_path) == ["page.html"]


def test_a_failure_while_writing_leaves_the_earlier_file(tmp_path, monkeypatch):
    path = tmp_path / "page.html"
    path.write_text("earlier")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(InputError, match="cannot be written: No space left on device; give another path"):
        write_page(path, PageContent("t"))
    assert path.read_text() == "earlier"
    assert os.listdir(tmp_path) == ["page.html"]


@pytest.mark.parametrize("place", ["missing/page.html", "."])
def test_a_place_that_cannot_be_written_is_named(tmp_path, place):
    with pytest.raises(InputError, match=r'the page ".*" cannot be written: .*; give another path'):
        write_page(tmp_path / place, PageContent("t"))
    assert os.listdir(tmp_path) == []


@pytest.mark.parametrize(
    "text, shown",
    [
        ("", ""),
        ("m/s^2", "m/s²"),
        ("kg m^2/s^-10", "kg m²/s⁻¹⁰"),
        ("x^2", "x^2"),
        ("x_m^2", "x_m^2"),
        ("δ^(4)", "δ^(4)"),
        ("m^2a", "m^2a"),
        ("± 1 i", "±\xa01\xa0i"),
        ("-1 ± 1e-05 i", "-1\xa0±\xa01e-05\xa0i"),
        ("at 3 in all", "at 3 in all"),
        ("a ± b", "a ± b"),
        ("<b>", "&lt;b&gt;"),
    ],
)
def test_a_text_is_typeset(text, shown):
    assert typeset(text) == shown
