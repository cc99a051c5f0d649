"""One look for all pictures: the same bytes always, texts as texts, nothing of matplotlib's that others see."""

import io
import subprocess
import sys
import warnings
from xml.etree import ElementTree

import pytest

from mbconstrained.analyses.figures import HEADING, WIDTH, Picture, nothing_to_show, power_of_ten, powers
from mbconstrained.page.content import shortened
from mbconstrained.page.plots import DPI
from tests.analyses.pictures import HOSTILE, HOSTILE_SHOWN, texts
from tests.page.svg import checked_svg


def labelled(text: str, title: str = "A title") -> Picture:
    def draw(figure):
        axes = figure.add_subplot()
        axes.plot([0, 1], [0, 1], "o")
        axes.set_title(text)

    return Picture(title, "A line.", 1.5, draw)


def size(png: bytes) -> tuple[int, int]:
    from matplotlib.image import imread

    return imread(io.BytesIO(png)).shape[1::-1]


def test_the_svg_is_one_element_that_takes_the_size_and_the_font_of_the_page():
    picture = labelled("x")
    root = ElementTree.fromstring(picture.svg)
    assert picture.svg.startswith("<svg ") and picture.svg.endswith("</svg>")
    assert (
        root.get("viewBox") == f"0 0 {72 * WIDTH:.1f} 108".replace(".0 ", " ") and root.get("width") is root.get("height") is None
    )
    assert "system-ui" in root.get("style") and "DejaVu" not in picture.svg
    assert not {"style", "metadata", "image"} & {element.tag.rsplit("}")[-1] for element in root.iter()}
    checked_svg(picture.svg)


def test_every_name_in_the_svg_is_referred_to():
    root = ElementTree.fromstring(labelled("x").svg)
    names = [element.get("id") for element in root.iter() if element.get("id")]
    assert names and len(set(names)) == len(names)
    assert all(f"#{name}" in labelled("x").svg for name in names)


def test_the_file_has_the_title_and_the_svg_leaves_it_to_the_page(tmp_path):
    picture, path = labelled("x", "Some title"), tmp_path / "picture.png"
    image = picture.png(path)
    assert path.read_bytes() == image and [file.name for file in tmp_path.iterdir()] == ["picture.png"]
    assert size(image) == (round(DPI * WIDTH), int(DPI * (1.5 + HEADING)))
    assert image != labelled("x", "Another title").png()
    assert "Some title" not in texts(picture)


def test_names_are_shown_as_they_are_and_are_no_formulas():
    assert HOSTILE_SHOWN in texts(labelled(shortened(HOSTILE)))
    assert labelled(shortened(HOSTILE), title=HOSTILE).png()[1:4] == b"PNG"


def test_long_names_are_shortened():
    assert shortened("W" * 10_000) == "W" * 39 + "…" and len(shortened("a b " * 100, 7)) <= 7


def test_letters_that_the_font_does_not_have_are_left_to_the_browser_without_a_complaint():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert "質量 🪀" in texts(labelled("質量 🪀"))
        labelled("質量 🪀").png()


@pytest.mark.parametrize(
    "setting", [{"text.usetex": True}, {"svg.fonttype": "path"}, {"font.size": 30}, {"axes.facecolor": "black"}]
)
def test_what_the_user_has_set_changes_no_picture_and_stays_set(setting):
    import matplotlib

    plain = labelled("x").svg
    with matplotlib.rc_context(setting):
        before = dict(matplotlib.rcParams)
        assert labelled("x").svg == plain
        assert dict(matplotlib.rcParams) == before


@pytest.mark.long
@pytest.mark.parametrize("seed", ["0", "7"])
def test_the_same_content_gives_the_same_bytes_in_every_process(seed, monkeypatch):
    code = (
        "import hashlib\n"
        "from tests.analyses.test_figures import labelled\n"
        "print(hashlib.sha256(labelled('x').svg.encode()).hexdigest(), hashlib.sha256(labelled('x').png()).hexdigest())\n"
    )
    monkeypatch.setenv("PYTHONHASHSEED", seed)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", seed)
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    import hashlib

    picture = labelled("x")
    assert run.stdout.split() == [hashlib.sha256(part).hexdigest() for part in (picture.svg.encode(), picture.png())]


@pytest.mark.long
def test_matplotlib_comes_when_a_picture_is_drawn_and_its_global_figures_never():
    code = (
        "import sys\n"
        "import mbconstrained.analyses.figures, mbconstrained.analyses.figures\n"
        "import mbconstrained.analyses.accuracy.accuracy, mbconstrained.analyses.stability.stability\n"
        "print('matplotlib' in sys.modules)\n"
        "from tests.analyses.test_figures import labelled\n"
        "labelled('x').svg, labelled('x').png()\n"
        "print('matplotlib' in sys.modules, 'matplotlib.pyplot' in sys.modules)\n"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.split() == ["False", "True", "False"]


def test_nothing_to_show_says_so():
    picture = nothing_to_show("Empty", "Digits right")
    assert texts(picture) == ["nothing was measured"]
    assert picture.description == "Digits right: nothing was measured."
    assert picture.on_page().title == "Empty"


def test_powers_are_raised_but_in_names_they_stay():
    assert powers("rtol 1e-06, h 2e+03, be1e5, 1.0e2") == "rtol 10⁻⁶, h 2·10³, be1e5, 10²"
    assert [power_of_ten(10.0**power) for power in (-17, -1, 0, 1, 2)] == ["10⁻¹⁷", "10⁻¹", "1", "10", "10²"]
