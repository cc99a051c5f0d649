"""A rigid bar: its coordinates and rows, against matrices by hand; its names and numbers are checked."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb

NUMBERS = st.floats(0.1, 10.0)


def vehicle() -> mb.LumpedModel:
    model = mb.LumpedModel()
    model.rigid_bar("body", 3.0, inertia=2.0, points={"rear": -1.5, "front": 1.25})
    return model


def test_coordinates_units_and_rows():
    model = vehicle()
    assert model.units == {"body": "m", "body angle": "rad", "rear": "m", "front": "m"}
    system = model.assemble()
    assert np.array_equal(system.mass, np.diag([3.0, 2.0, 0.0, 0.0]))
    assert np.array_equal(system.constraint_matrix, [[-1, 1.5, 1, 0], [-1, -1.25, 0, 1]])
    assert [row.name for row in system.rows] == ["rear on body", "front on body"]
    assert len(model.elements) == 1 and repr(model) == "LumpedModel(1 rigid bar)"


@given(mass=NUMBERS, inertia=NUMBERS, stiffness=st.tuples(NUMBERS, NUMBERS), distances=st.tuples(NUMBERS, NUMBERS))
def test_frequencies_of_two_equations_by_hand(mass, inertia, stiffness, distances):
    """A bar on two springs at -a and b: det([k1 + k2, b k2 - a k1; b k2 - a k1, a^2 k1 + b^2 k2] - w^2 diag(m, J)) = 0."""
    (k1, k2), (a, b) = stiffness, distances
    model = mb.LumpedModel()
    model.rigid_bar("bar", mass, inertia=inertia, points={"left": -a, "right": b})
    model.spring("ground", "left", k1), model.spring("ground", "right", k2)
    K = np.array([[k1 + k2, b * k2 - a * k1], [b * k2 - a * k1, a * a * k1 + b * b * k2]])
    scale = np.diag([mass**-0.5, inertia**-0.5])
    expected = np.linalg.eigvalsh(scale @ K @ scale)  # its relative errors grow with the ratio of the two
    assert model.assemble().modes().natural_frequencies ** 2 == pytest.approx(expected, abs=1e-12 * expected[-1])


def test_gravity_acts_on_its_mass():
    model = vehicle()
    model.gravity(-10.0)
    assert model.assemble().static_force.tolist() == [-30.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"points": {}}, 'rigid bar "b": points: expected distances by name'),
        ({"points": {"p": "1"}}, 'rigid bar "b": distance of "p"'),
        ({"points": {"ground": 1.0}}, 'rigid bar: the name "ground" is that of the fixed body'),
        ({"points": {"b": 1.0}}, 'its name and those of its points must differ; found "b" twice'),
        ({"points": {"m": 1.0}}, 'rigid bar: the name "m" is already in use \\(mass\\)'),
        ({"inertia": 0.0}, 'rigid bar "b": inertia: found 0'),
    ],
)
def test_what_is_wrong_is_reported_and_nothing_is_added(fields, message):
    model = mb.LumpedModel()
    model.mass("m", 1.0)
    with pytest.raises(mb.InputError, match=message):
        model.rigid_bar("b", 1.0, **{"inertia": 1.0, "points": {"p": 1.0}} | fields)
    assert model.coordinates == ("m",)
    model.rigid_bar("b", 1.0, inertia=1.0, points={"p": 1.0})
    with pytest.raises(mb.InputError, match='mass: the name "p" is already in use \\(node\\)'):
        model.mass("p", 1.0)
