"""Violated conditions name the equations they come from, the coordinates, and by how much, against values by hand."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb

# two unit masses joined by a rigid link with a multiplier, a unit spring on body 1:
# q1'' + q1 - lam = 0, q2'' + lam = 0, q1 - q2 = 0; hidden: q1' - q2' = 0, 2 lam - q1 = 0, 2 lam' - q1' = 0
LINK = mb.PolynomialMatrix(
    [[[1, 0, -1], [0, 0, 1], [1, -1, 0]], np.zeros((3, 3)), np.diag([1, 1, 0])], ["q1", "q2", "lam"], ["body 1", "body 2", "tie"]
)
VALUE, VELOCITY, FORCE, FORCE_RATE = (
    (("tie", 0),),
    (("tie", 1),),
    (("tie", 2), ("body 1", 0), ("body 2", 0)),
    (("tie", 3), ("body 1", 1), ("body 2", 1)),
)


def told(A, initial, force=None) -> dict:
    return {v.equations: (v.amount, v.impulsive) for v in mb.admissible(A, initial, force).violations}


def close(found: dict, known: dict) -> bool:
    return found.keys() == known.keys() and all(
        found[key][0] == pytest.approx(known[key][0], rel=1e-12) and found[key][1] == known[key][1] for key in known
    )


@pytest.mark.parametrize(
    ("initial", "known"),
    [
        ([[1, 1, 0.5], [1, 1, 0.5]], {}),
        ([[3, 1, 1.5], [0, 0, 0]], {VALUE: (2, True)}),
        ([[0, 0, 0], [0, 5, 0]], {VELOCITY: (-5, True)}),
        ([[1, 1, 0.75], [1, 1, 0.5]], {FORCE: (0.5, False)}),
        ([[1, 1, 0.5], [1, 1, 0.75]], {FORCE_RATE: (0.5, False)}),
        ([[3, 1, 1.5], [0, 5, 0]], {VALUE: (2, True), VELOCITY: (-5, True)}),
    ],
)
def test_a_constraint_row_appears_as_itself_and_its_derivatives(initial, known):
    assert close(told(LINK, initial), known)


def test_a_force_on_the_constraint_row_is_its_right_side():
    assert close(told(LINK, [[0.5, 0.25, 0.25], [0, 0, 0]], mb.step([0, 0, 0.25])), {})
    found = told(LINK, [[0, 0, 0], [0, 0, 0]], mb.step([0, 0, 0.25]) + mb.ramp([0, 0, 2.0]))
    assert close(found, {VALUE: (-0.25, True), VELOCITY: (-2.0, True)})


def test_only_what_acts_at_zero_is_held_against_the_values():
    later = mb.step([0, 0, 0.25]).delayed(1.0) + mb.impulse([1.0, 0, 0]).delayed(2.0)
    assert told(LINK, np.zeros((2, 3)), later) == {}
    assert close(told(LINK, np.zeros((2, 3)), mb.step([0, 0, 0.5]) + later), {VALUE: (-0.5, True)})


@pytest.mark.parametrize("power", [-60, 60])
def test_amounts_are_in_the_units_of_the_equation(power):
    """Time in units of 2^power and the tie in units of 8: the first derivative of the tie is 8 * 2^-power as large."""
    unit = 2.0**power
    coefficients = np.array([matrix * unit**k for k, matrix in enumerate(LINK.coefficients)])
    coefficients[:, 2] *= 8
    A = mb.PolynomialMatrix(coefficients, LINK.coordinates, LINK.equations)
    found = told(A, [[3, 1, 1.5], [0, 5 / unit, 0]])
    assert close({key: found[key] for key in (VALUE, VELOCITY)}, {VALUE: (16, True), VELOCITY: (-40 / unit, True)})


def test_conditions_of_a_mechanical_system_are_named_as_its_rows():
    system = mb.MechanicalSystem(
        mass=np.diag([1.0, 2, 3]), stiffness=np.eye(3), names=["cart", "rod", "ball"],
        constraints=[mb.Constraint([[1, -1, 0]], level="position", value=[0.25], names=["tie"])],
    )  # fmt: skip
    A = system.polynomial_matrix()
    one, two = mb.admissible(A, [[1, 0.5, 0], [0.5, 0, 0]], mb.step([0, 0, 0.25])).violations
    assert [(one.amount, one.impulsive), (two.amount, two.impulsive)] == [(0.25, False), (0.5, False)]
    assert all("tie" in violation.text and '"cart"' in violation.text for violation in (one, two))
    assert (one.coordinates, two.coordinates) == ((("cart", 0), ("rod", 0)), (("cart", 1), ("rod", 1)))


def test_dense_conditions_name_the_largest_few_only():
    n = 8
    random = np.random.default_rng(3)
    dense = random.normal(size=(n, n))
    A = mb.PolynomialMatrix([dense, np.zeros((n, n))])
    violations = mb.admissible(A, np.ones((1, n))).violations
    assert len(violations) == n
    assert all(len(v.equations) <= 4 and len(v.coordinates) <= 4 for v in violations)
