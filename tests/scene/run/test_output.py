"""What is written: CSV, npz, page; and what is not lost when something goes wrong."""

import csv
import re
import zipfile

import numpy as np
import pytest

from mbconstrained.ground.errors import MbconstrainedError, SceneError
from mbconstrained.ground.files import Replacements, replacing
from mbconstrained.scene.coordinates import OutputUnits, output_units
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import EXAMPLES, MATRICES, OSCILLATOR, scene_of

W = 2.0  # sqrt(8/2), rad/s, of OSCILLATOR


def read_csv(path):
    with open(path, encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    return head, np.array(rows, dtype=float)


def test_csv_has_names_units_and_every_digit(tmp_path):
    text = OSCILLATOR + '[output]\nplots = ["velocity", "acceleration", "energy"]\n'
    result = scene_of(tmp_path, text).run(tmp_path / "out")
    head, rows = read_csv(tmp_path / "out" / "scene.csv")
    assert head[:4] == ["time (s)", "cart displacement (m)", "cart velocity (m/s)", "cart acceleration (m/s^2)"]
    assert head[-1] == "total energy (J)"
    t = np.linspace(0, 5, 11)
    assert np.array_equal(rows[:, 0], t)
    assert np.array_equal(rows[:, 1], result.values[0])
    assert rows[:, 1:4].T == pytest.approx(0.1 * np.array([np.cos(W * t), -W * np.sin(W * t), -W * W * np.cos(W * t)]), abs=1e-15)
    assert rows[:, -1] == pytest.approx(np.full(11, 0.5 * 8 * 0.1**2), rel=1e-14)


def test_npz_holds_the_answer_without_pickle(tmp_path):
    result = read_scene(EXAMPLES / "rigid_link.toml").run(tmp_path)
    with np.load(tmp_path / "rigid_link.npz", allow_pickle=False) as found:
        assert found["coordinates"].tolist() == ["q1", "q2", "lambda"]
        assert np.array_equal(found["displacement"], result.values)
        assert found["impulses"][1] == pytest.approx([0, 0, -0.5])
        assert found["initial"][0].tolist() == [1, 0, 0]
        s = 0.3 + 0.8j  # A(s)^-1 = C (s I - J)^-1 B + C (I - s J)^-1 B, Theorem 2.8 of Moysis et al.
        C, J, B = (found[f"finite_{name}"] for name in "CJB")
        inverse = C @ np.linalg.solve(s * np.eye(len(J)) - J, B)
        C, J, B = (found[f"infinite_{name}"] for name in "CJB")
        inverse = inverse + C @ np.linalg.solve(np.eye(len(J)) - s * J, B)
    A = result.scene.equations.polynomial_matrix
    assert A(s) @ inverse == pytest.approx(np.eye(3), abs=1e-14)


def test_columns_are_called_what_they_are(tmp_path):
    read_scene(EXAMPLES / "gear_train.toml").run(tmp_path)
    assert read_csv(tmp_path / "gear_train.csv")[0][1:8:3] == [
        "motor angle (rad)",
        "motor angular velocity (rad/s)",
        "teeth reaction (N m)",
    ]
    read_scene(EXAMPLES / "rigid_link.toml").run(tmp_path)
    assert read_csv(tmp_path / "rigid_link.csv")[0][1:] == ["q1 displacement (m)", "q2 displacement (m)", "lambda value (N)"]


def test_reactions_are_written_where_asked_for(tmp_path):
    text = MATRICES.replace("[time]", '[[model.constraint]]\nname = "tie"\nrows = { a = 1, b = -1 }\n[time]')
    scene_of(tmp_path, text + "[output]\nreactions = true\n").run(tmp_path)
    head, _ = read_csv(tmp_path / "scene.csv")
    assert head == ["time (s)", "a displacement (m)", "b displacement (m)", "tie reaction (N)"]
    with np.load(tmp_path / "scene.npz") as found:
        assert found["constraints"].tolist() == ["tie"]


def test_the_same_scene_gives_the_same_bytes(tmp_path):
    for folder in ("one", "two"):
        read_scene(EXAMPLES / "two_masses.toml").run(tmp_path / folder)
    for ending in ("csv", "npz"):
        one, two = (tmp_path / folder / f"two_masses.{ending}" for folder in ("one", "two"))
        assert one.read_bytes() == two.read_bytes(), ending
    with zipfile.ZipFile(tmp_path / "one" / "two_masses.npz") as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_texts_are_escaped_on_the_page(tmp_path):
    text = OSCILLATOR.replace("[model]", 'title = "<script>alert(1)</script>"\nsource = "a < b & c"\n[model]', 1)
    page = scene_of(tmp_path, text).run().write_page(tmp_path / "a.html").read_text("utf-8")
    assert "<script>alert" not in page
    assert "&lt;script&gt;alert(1)&lt;/script&gt;" in page and "a &lt; b &amp; c" in page


def test_an_unfinished_file_leaves_the_earlier_one(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("earlier")
    with pytest.raises(KeyboardInterrupt), replacing(path) as beside:
        beside.write_text("half")
        raise KeyboardInterrupt
    assert path.read_text() == "earlier"
    assert list(tmp_path.iterdir()) == [path]


def test_several_files_are_replaced_together_or_not_at_all(tmp_path):
    first, second = tmp_path / "a", tmp_path / "b"
    first.write_text("earlier")
    with Replacements() as files:
        files.temporary(first).write_text("new")
        files.temporary(second).write_text("new")
        assert first.read_text() == "earlier" and not second.exists()
    assert first.read_text() == second.read_text() == "new"
    with pytest.raises(OSError, match="no space"), Replacements() as files:
        files.temporary(first).write_text("newer")
        raise OSError("no space")
    assert first.read_text() == "new" and sorted(tmp_path.iterdir()) == [first, second]


def test_an_answer_beyond_the_range_of_numbers_leaves_earlier_output(tmp_path):
    scene_of(tmp_path, MATRICES).run(tmp_path / "out")
    before = {path: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    growing = MATRICES.replace("[[1, 0], [0, 4]]", "[[-1, 0], [0, 4]]").replace(
        "end = 1", "end = 1e6\n[initial]\ndisplacement = [1, 1]"
    )
    with pytest.raises(MbconstrainedError, match="beyond the range of float64"):
        scene_of(tmp_path, growing.replace("points = 5", "")).run(tmp_path / "out")
    assert {path: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


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
        ("m", "mm", 1e3), ("m/s", "mm/s", 1e3), ("m/s^2", "m/s^2", 1), ("rad", "deg", 180 / np.pi), ("rad/s", "rev/min", 30 / np.pi),
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
    chosen = output_units(units)
    assert chosen.of("m/s^2") == (shown[0], pytest.approx(shown[1], rel=1e-15)) and chosen.of("m")[0] == "mm"
    assert chosen.of("kg") == ("kg", 1.0)


def test_quantities_and_results_have_units_of_their_own(tmp_path):
    """Hand: 0.1 m is 10 cm and 3.937 in; an acceleration of -k x / m = -40 m/s^2 is -4.0789 g of 9.80665 m/s^2."""
    units = '{ displacement = "cm", acceleration = "g", force = "kN", "velocity of cart" = "in/s", "force of spring ground-cart" = "lbf" }'
    text = OSCILLATOR + OUTPUT.format("X").replace('"X"', units)
    shown = scene_of(tmp_path, text).equations.coordinates.shown
    assert shown.of("m", "cart") == ("cm", 100.0) and shown.of("m/s", "cart") == ("in/s", pytest.approx(1 / 0.0254, rel=1e-15))
    assert shown.of("m/s^2", "cart") == ("g", pytest.approx(1 / 9.80665, rel=1e-15)) and shown.of("m/s", "other")[0] == "cm/s"
    assert (
        shown.of("N", "spring ground-cart") == ("lbf", pytest.approx(1 / 4.4482216152605, rel=1e-15))
        and shown.of("N", "cart")[0] == "kN"
    )
    assert shown.of_ratio("m/s^2/N", "cart", "spring ground-cart") == ("g/lbf", pytest.approx(4.4482216152605 / 9.80665, rel=1e-15))
    assert shown.of("N/m") == ("kN/cm", pytest.approx(1e-5)) and shown.of("N s/m")[0] == "kN s/cm"
    assert shown.of("m/s^3") == ("m/s^3", 1.0)  # as accelerations: mm of displacements says nothing of them


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ('{ acceleration = "mm" }', 'acceleration: found "mm"; expected a unit of acceleration'),
        ('{ accelaration = "g" }', 'there is no quantity or result "accelaration"; did you mean "acceleration"?'),
        ('{ displacement = "mm", length = "cm" }', 'found "mm" and "cm", which measure the same'),
        ('{ cart = "mm, cm" }', 'cart: found "mm" and "cm", which measure the same'),
        ('{ "force of nobody" = "kN" }', 'there is no quantity or result "nobody"'),
        ("{ force = 2 }", "force: found 2; expected units"),
    ],
)
def test_units_of_nothing_are_refused(tmp_path, units, message):
    with pytest.raises(SceneError, match=re.escape(message)):
        scene_of(tmp_path, OSCILLATOR + OUTPUT.format("X").replace('"X"', units))


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
