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

from mbconstrained.ground.errors import MbconstrainedError
from mbconstrained.page.content import PageContent
from mbconstrained.page.html import _ANIMATION, _ASSETS, _PLOTS, VIEWER_FILE, page_html, script_json, viewer_script
from tests.page.contents import HOSTILE, hostile_content, two_masses_content


def data_of(page: str) -> dict:
    return json.loads(re.search(r'<script type="application/json" id="motion-data">(.*?)</script>', page, re.S)[1])


@pytest.mark.parametrize("seed", ["0", "7"])
def test_the_same_content_gives_the_same_bytes_in_every_process(seed):
    code = (
        "import hashlib\n"
        "from mbconstrained.page.content import PageContent; from mbconstrained.page.html import page_html\n"
        "from tests.page.contents import two_masses_content\n"
        "from tests.page.models import gallery\n"
        "pages = [page_html(two_masses_content()), *(page_html(PageContent(k, animation=a)) for k, a in gallery().items())]\n"
        "print(*(hashlib.sha256(page.encode()).hexdigest() for page in pages))\n"
    )
    environment = os.environ | {"PYTHONHASHSEED": seed, "TZ": "Asia/Tokyo" if seed == "7" else "UTC"}
    run = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=True)
    from tests.page.models import gallery

    pages = [page_html(two_masses_content()), *(page_html(PageContent(k, animation=a)) for k, a in gallery().items())]
    assert run.stdout.split() == [hashlib.sha256(page.encode()).hexdigest() for page in pages]


def test_meshcat_is_read_but_not_imported():
    code = (
        "import sys\n"
        "from mbconstrained.page.html import page_html\n"
        "from tests.page.contents import two_masses_content\n"
        "page_html(two_masses_content())\n"
        "print(*sorted({'meshcat', 'zmq', 'tornado', 'matplotlib', 'pydantic', 'pinocchio', 'sympy'} & set(sys.modules)))\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == []


def test_a_missing_viewer_is_one_clear_message(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(MbconstrainedError, match='needs the package "meshcat", which is not installed: pip install meshcat'):
        page_html(two_masses_content())


def test_only_the_two_scripts_of_the_page_may_run():
    page = page_html(two_masses_content())
    policy = re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)[1]
    scripts = re.findall(r"<script>(.*?)</script>", page, re.S)
    hashes = [base64.b64encode(hashlib.sha256(script.encode()).digest()).decode() for script in scripts]
    assert len(scripts) == 2
    assert re.findall(r"'sha256-([^']*)'", policy) == hashes
    assert policy.startswith("default-src 'none'; script-src 'sha256-")
    assert "unsafe-eval" not in policy and "http" not in policy


def test_the_page_names_no_place_to_load_from():
    page = page_html(two_masses_content()).replace(viewer_script(), "")
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


def test_hostile_texts_come_out_as_texts():
    content = hostile_content()
    page = Texts(page_html(content))
    assert page.tags.count("script") == 4  # the data of the plots and of the motion, the viewer, the page's own
    assert not {"img", "b2"} & set(page.tags)
    assert not [name for name in page.attributes if name.startswith("on")]
    assert page.texts.count(content.title) == 3  # title, heading and source
    assert page.texts.count(HOSTILE) >= 6
    assert page.texts.count("W" * 10_000) >= 6


def test_the_data_are_the_values():
    frames = data_of(page_html(two_masses_content()))["frames"]
    values = two_masses_content().animation.values
    assert frames["names"] == ["x1", "q1", "q2"]
    assert np.array_equal([np.frombuffer(base64.b64decode(row)) for row in frames["values"]], values)
    assert frames["times"] == {"start": 0, "end": 50, "count": 401}


@pytest.mark.parametrize("plotted, size", [(True, 80_000), (False, 20_000)])
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
    assert len(page) < 200_000
    assert re.findall(r'<script src="([^"]*)"></script>', page) == [VIEWER_FILE]
    assert "script-src 'sha256-" in page_html(replace(two_masses_content(), animation=None), "separate")


def test_without_plots_tables_notices_and_facts_there_is_no_trace_of_them():
    page = page_html(PageContent("t", animation=two_masses_content().animation))
    for word in (
        '<div class="plots"',
        "<figure",
        "<svg",
        "<table",
        'class="notices"',
        "<footer>\n<dl",
        "<header>\n<h1>t</h1>\n<p",
    ):
        assert word not in page


@pytest.mark.parametrize("last", ["run.js", "modes.js", "frequency.js"])
def test_scripts_of_one_page_have_different_names_at_the_top(last):
    """All scripts of a page share one scope, in which the later of two functions of one name is taken."""
    scripts = ["theme.js", "numbers.js", *_PLOTS, *_ANIMATION, "overlay.js", "posing.js", last]
    text = "\n".join((_ASSETS / name).read_text(encoding="utf-8") for name in scripts)
    names = re.findall(r"^(?:async )?(?:function\*?|const|let|class) (\w+)", text, re.M)
    assert sorted(name for name in set(names) if names.count(name) > 1) == []
