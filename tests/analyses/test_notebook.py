"""Public objects in a notebook: well-formed HTML without scripts, whose pictures have the curves that the solver has computed."""

import base64
import re
from xml.etree import ElementTree

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.frequency.random.spectra import white_noise
from tests.scene.scenes import EXAMPLES

F = np.geomspace(0.1, 10.0, 41)


def system():
    return mb.MechanicalSystem([[1.0]], [[0.2]], [[40.0]], names=["cart"])


def scene(name):
    return mb.read_scene(EXAMPLES / f"{name}.toml")


SHOWN = {
    "system": (system, "receptance"),
    "scene": (lambda: scene("two_masses"), "displacement"),
    "motion": (lambda: system().solve([0.1]), "displacement"),
    "frequency response": (lambda: system().frequency_response(F), "receptance"),
    "random response": (lambda: system().random_response({"cart": white_noise(2.0)}), "density"),
    "shock response spectrum": (lambda: mb.shock_response_spectrum(mb.pulse([1.0], duration=0.1), F), "maximax"),
    "record": (lambda: mb.read_record(EXAMPLES / "records" / "ground_acceleration.csv"), "time in s"),
    "root locus": (lambda: scene("tuned_mass_damper").root_locus("zeta", np.linspace(0.05, 0.2, 9)), "branch 1"),
    "run": (lambda: scene("two_masses").run(), "displacement"),
    "answer": (lambda: scene("electronics_box").random(), "density"),
    "answer without plots": (lambda: scene("two_masses").modes(), ""),
}


def pictures_of(text: str) -> list[str]:
    return [base64.b64decode(data).decode() for data in re.findall(r"data:image/svg\+xml;base64,([^\"]+)", text)]


@pytest.mark.parametrize("make, word", SHOWN.values(), ids=SHOWN)
def test_a_notebook_shows_plots_as_closed_pictures(make, word):
    text = make()._repr_html_()
    tree = ElementTree.fromstring(f"<div>{text}</div>")
    assert "<script" not in text and all(image.get("alt") for image in tree.iter("img"))
    pictures = pictures_of(text)
    assert bool(pictures) == bool(word) and (not word or word in pictures[0])
    for picture in pictures:
        ElementTree.fromstring(picture)
        assert "<script" not in picture and "NaN" not in picture and "nan " not in picture


def test_the_curve_of_a_frequency_response_is_the_receptance():
    """|H| = 1 / |40 - w^2 + 0.2 i w| of one mass, in points of the picture along both logarithmic axes."""
    picture = pictures_of(system().frequency_response(F)._repr_html_())[0]
    path = re.search(r'<g id="line2d_\d+">\s*<path d="([^"]+)" clip-path[^>]*stroke: #0', picture)[1]
    x, y = np.array([[float(part) for part in point.split()] for point in re.findall(r"[ML] ([-\d.]+ [-\d.]+)", path)]).T
    w = 2 * np.pi * F
    expected = -np.log(np.abs(40 - w**2 + 0.2j * w))
    slope = np.polyfit(expected, -y, 1)
    assert slope[0] > 0 and np.abs(np.polyval(slope, expected) + y).max() < 0.1  # in pt, of a picture 3 inches high
    assert np.abs(np.polyval(np.polyfit(np.log(F), x, 1), np.log(F)) - x).max() < 0.1


def test_many_plots_are_not_all_shown():
    text = scene("rotor").campbell()._repr_html_()
    assert 1 <= text.count("<img") <= 6


def test_texts_of_users_are_escaped():
    record = mb.Record(np.array([0.0, 1.0, 1.0, 2.0]), np.array([0.0, 1.0, 2.0, 3.0]), "m/s^2", '"><script>alert(1)</script>')
    assert "<b>" not in mb.MechanicalSystem([[1.0]], names=["<b>"])._repr_html_()
    assert "<script" not in record._repr_html_() and "<script" not in pictures_of(record._repr_html_())[0]
