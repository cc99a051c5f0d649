"""[output] units: page, tables and CSV in the chosen units, npz in SI."""

import re

import numpy as np
import pytest

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.quantities.output_units import OutputUnits, output_units
from tests.scene.scenes import OSCILLATOR, scene_of

OUTPUT = '\n[output]\nunits = "{}"\nplots = ["displacement", "velocity", "energy", "phase"]\nanimation = false\n'


def test_csv_and_page_have_the_units_and_npz_is_in_si(tmp_path):
    result = scene_of(tmp_path, OSCILLATOR + OUTPUT.format("mm, kJ")).run(tmp_path)
    head, first, *_ = (tmp_path / "scene.csv").read_text(encoding="utf-8").splitlines()
    assert head.startswith("time (s),cart displacement (mm),cart velocity (mm/s),kinetic energy (kJ)")
    assert [float(entry) for entry in first.split(",")][:2] == pytest.approx([0, 100]) and float(
        first.split(",")[4]
    ) == pytest.approx(4e-5)
    with np.load(tmp_path / "scene.npz") as arrays:
        assert arrays["displacement"][0, 0] == pytest.approx(0.1)
    page = (tmp_path / "scene.html").read_text(encoding="utf-8")
    assert "displacement in mm" in page and "velocity in mm/s" in page and not re.search(r"in m<", page)
    assert "cart (mm)" in result.summary()


def test_jumps_impulses_and_constraints_have_the_units(tmp_path):
    row = '\n[[model.constraint]]\nname = "stop"\nrows = { cart = 1 }\nvalue = 0.02\n\n[time]'
    text = OSCILLATOR.replace("\n[time]", row) + OUTPUT.format("mm, kN").replace(', "energy", "phase"', "")
    result = scene_of(tmp_path, text).run()
    cells = [cell for table in result.tables for line in table.rows for cell in line]
    assert {"100 mm", "20 mm", "-80 mm"} <= set(cells)
    assert any(re.fullmatch(r"-?[\d.e-]+ kN s\^?2?", cell) for cell in cells)


@pytest.mark.parametrize(
    ("unit", "name", "factor"),
    [
        ("m", "mm", 1e3), ("m/s", "mm/s", 1e3), ("m/s^2", "m/s^2", 1), ("rad", "deg", 180 / np.pi), ("rad/s", "rpm", 30 / np.pi),
        ("rad/s^2", "deg/s^2", 180 / np.pi), ("N", "kN", 1e-3), ("N m", "kN m", 1e-3), ("N s^2", "kN s^2", 1e-3),
        ("J", "J", 1), ("1", "1", 1), ("1/s", "1/s", 1), ("V", "V", 1),
    ],
)  # fmt: skip
def test_derivatives_and_products_follow(unit, name, factor):
    assert OutputUnits(("mm", "deg", "rpm", "kN")).of(unit) == (name, pytest.approx(factor, rel=1e-14))


@pytest.mark.parametrize(
    ("units", "shown"), [("mm, g", ("g", 1 / 9.80665)), ("mm, mm/s^2", ("mm/s^2", 1e3)), ("mm", ("m/s^2", 1.0))]
)
def test_accelerations_have_the_unit_that_is_meant_for_them(units, shown):
    """1 g = 9.80665 m/s^2 (3rd General Conference on Weights and Measures, 1901); a gram is no unit of any result of a motion."""
    chosen = OutputUnits(output_units(units))
    assert chosen.of("m/s^2") == (shown[0], pytest.approx(shown[1], rel=1e-15)) and chosen.of("m")[0] == "mm"
    assert chosen.of("kg") == ("kg", 1.0)


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ("mm, cm", 'output.units: found "mm" and "cm", which measure the same; give one of them'),
        ("mm, ton", 'output.units: found "ton", but "ton" may be read as'),
        ("", 'output.units: found ""; expected a unit'),
    ],
)
def test_what_is_no_choice_of_units_is_refused(tmp_path, units, message):
    with pytest.raises(SceneError, match=message):
        scene_of(tmp_path, OSCILLATOR + OUTPUT.format(units))
