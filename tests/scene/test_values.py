"""Starts and constraint values: the numbers that reach the equations."""

import math

import numpy as np
import pytest

from tests.scene.scenes import COEFFICIENTS, MATRICES, scene_of


@pytest.mark.parametrize(
    ("initial", "rows"),
    [
        ('displacement = { b = "20 mm" }', [[0, 0.02], [0, 0]]),
        ('displacement = [1, "20 mm"]\nvelocity = { a = "1 km/h" }', [[1, 0.02], [1 / 3.6, 0]]),
        ("derivatives = [[1, 2], [3, 4]]", [[1, 2], [3, 4]]),
        ("derivatives = [[1, 2]]", [[1, 2], [0, 0]]),
        ("displacement = {}", [[0, 0], [0, 0]]),
        ("acceleration = {}\njerk = []", [[0, 0], [0, 0]]),
        ("", [[0, 0], [0, 0]]),
    ],
)
def test_start(tmp_path, initial, rows):
    scene = scene_of(tmp_path, MATRICES.replace("[time]", f"[initial]\n{initial}\n[time]"))
    assert scene.equations.initial == pytest.approx(np.array(rows, dtype=float), rel=1e-15)


def test_start_of_equations_of_degree_four_and_one(tmp_path):
    four = COEFFICIENTS.replace("[[1]]]", "[[1]], [[0]], [[1]]]")
    values = 'displacement = { q = "180 deg" }\nvelocity = { q = 1 }\nacceleration = [2]\njerk = { q = "3 rad/s^3" }'
    scene = scene_of(tmp_path, four.replace("[time]", f"[initial]\n{values}\n[time]"))
    assert scene.equations.initial.tolist() == [[math.pi], [1.0], [2.0], [3.0]]
    one = COEFFICIENTS.replace("[[0]], [[1]]", "[[1]]").replace("[time]", "[initial]\ndisplacement = [5]\n[time]")
    result = scene_of(tmp_path, one).run()  # q' + 4 q = 0
    assert result.values[0] == pytest.approx(5 * np.exp(-4 * result.times), rel=1e-13)


@pytest.mark.parametrize(
    ("level", "value", "expected"),
    [("position", '"20 cm"', 0.2), ("velocity", '"3.6 km/h"', 1.0), ("acceleration", '"2 m/s^2"', 2.0), ("position", "-1", -1.0)],
)
def test_constraint_value_has_the_unit_of_its_level(tmp_path, level, value, expected):
    entry = f'[[model.constraint]]\nname = "row"\nrows = {{ a = 1, b = -2 }}\nlevel = "{level}"\nvalue = {value}\n[time]'
    (row,) = scene_of(tmp_path, MATRICES.replace("[time]", entry)).equations.system.rows
    assert (row.name, row.level, row.coefficients.tolist()) == ("row", level, [1.0, -2.0])
    assert row.value == pytest.approx(expected, rel=1e-15)
