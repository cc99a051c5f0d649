"""Starts, forces and constraint values: the numbers that reach the equations."""

import math

import numpy as np
import pytest

from tests.scene.scenes import COEFFICIENTS, MATRICES, scene_of


def force_scene(folder, entry, coordinate="a", units=""):
    text = MATRICES.replace("[time]", f'{units}\n[[force]]\ncoordinate = "{coordinate}"\n{entry}\n[time]')
    return scene_of(folder, text).equations.force


T = np.array([0.3, 1.7])


@pytest.mark.parametrize(
    ("entry", "function"),
    [  # closed forms as the schema states them
        ('kind = "step"\nvalue = "2 kN"', lambda t: 2000 + 0 * t),
        ('kind = "ramp"\nvalue = "2 N/ms"', lambda t: 2000 * t),
        ('kind = "power"\ngamma = 4\nvalue = "6 N/s^3"', lambda t: t**3),
        ('kind = "harmonic"\nvalue = 3\nangular_frequency = "60 rpm"', lambda t: 3 * np.cos(2 * math.pi * t)),
        ('kind = "harmonic"\nvalue = 3\nfrequency = "1 Hz"\nphase = "90 deg"', lambda t: -3 * np.sin(2 * math.pi * t)),
        (
            'kind = "term"\nvalue = "2 N/s^2"\npower = 2\nrate = "-0.5 1/s"\nangular_frequency = 3\nphase = 0.1',
            lambda t: 2 * t**2 * np.exp(-0.5 * t) * np.cos(3 * t + 0.1),
        ),
        ('kind = "term"\nvalue = 2', lambda t: 2 + 0 * t),
    ],
)
def test_force_is_the_function_that_its_kind_says(tmp_path, entry, function):
    force = force_scene(tmp_path, entry)
    assert force(T) == pytest.approx(np.array([function(T), 0 * T]), rel=1e-14, abs=1e-15)
    assert not any(impulse.any() for impulse in force.impulses)


@pytest.mark.parametrize(
    ("entry", "order"),
    [
        ('kind = "impulse"\nvalue = "3 N*s"', 0),
        ('kind = "impulse"\nvalue = "3 N*s^2"\norder = 1', 1),
        ('kind = "power"\ngamma = -1\nvalue = "3 N*s^2"', 1),
        ('kind = "impulse"\nvalue = "3000 N*ms"', 0),
    ],
)
def test_impulse_is_told_by_its_order(tmp_path, entry, order):
    force = force_scene(tmp_path, entry)
    assert not force(T).any()
    assert [impulse.tolist() for impulse in force.impulses] == [[0, 0]] * order + [[pytest.approx(3), 0]]


def test_forces_on_one_coordinate_add_up(tmp_path):
    both = 'kind = "step"\nvalue = 1\n[[force]]\ncoordinate = "a"\nkind = "ramp"\nvalue = 2'
    assert force_scene(tmp_path, both)(T) == pytest.approx(np.array([1 + 2 * T, 0 * T]))


def test_force_on_an_angle_is_a_torque(tmp_path):
    force = force_scene(tmp_path, 'kind = "step"\nvalue = "2 Nm"', units='[model.units]\na = "rad"')
    assert force(1.0).tolist() == [2.0, 0.0]


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
