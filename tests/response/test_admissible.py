"""Admissibility (58) and continuity (60), corrected, against counter-examples, the structure and solve itself."""

import numpy as np
import pytest

import mbconstrained as mb

RIGID_LINK = [[[1, 0, -1], [0, 0, 1], [1, -1, 0]], np.zeros((3, 3)), np.diag([1, 1, 0])]
MASSLESS_JOINTS = [[[9, 0, -3], [0, 0, 0], [-3, 0, 3]], [[0, 0, 0], [0, 12, -4], [0, -4, 4]], np.diag([0, 0, 10])]


def test_the_force_counts_at_0_plus_not_at_0_minus():
    # A(s) = [[1, -s], [0, 1]], f = (0, 1) for t >= 0: x2 = f2, x1 = f2' (worked by hand)
    A = mb.PolynomialMatrix([np.eye(2), [[0, -1], [0, 0]]])
    rest = mb.admissible(A, [[0, 0]], mb.step([0, 1]))
    assert not rest.is_impulse_free
    np.testing.assert_allclose(rest.residuals, [[1, 0]])  # x1 = delta
    loaded = mb.admissible(A, [[0, 1]], mb.step([0, 1]))
    assert loaded.is_impulse_free and loaded.is_continuous


def test_equilibrium_under_a_step_is_continuous():
    # A(s) = diag(s^2, s + 1), f = (0, 1): (0, 1) at rest is the equilibrium; with velocity -1 its velocity jumps to 0
    A = mb.PolynomialMatrix([np.diag([0, 1]), np.diag([0, 1]), np.diag([1, 0])])
    assert mb.admissible(A, [[0, 1], [0, 0]], mb.step([0, 1])).is_continuous
    moving = mb.admissible(A, [[0, 1], [0, -1]], mb.step([0, 1]))
    assert moving.is_impulse_free and not moving.is_continuous
    np.testing.assert_allclose(moving.jump, [[0, 0], [0, 1]], atol=1e-15)


def test_the_three_sets_have_the_dimensions_that_the_structure_at_infinity_says():
    # rigid link with multiplier: det = 2 s^2 + 1, one infinite zero of order 2; massless joints: n = 3, none
    assert mb.admissible(mb.PolynomialMatrix(RIGID_LINK)).dimensions == (2, 4, 6)
    assert mb.admissible(mb.PolynomialMatrix(MASSLESS_JOINTS)).dimensions == (3, 6, 6)


def test_impulse_free_is_not_continuous():
    # the published example with massless joints, from (1, 1, 2) and (0, 1, 0): jumps, no impulse
    found = mb.admissible(mb.PolynomialMatrix(MASSLESS_JOINTS), [[1, 1, 2], [0, 1, 0]])
    assert found.is_impulse_free and not found.is_continuous
    assert np.array_equal(found.nearest, [[1, 1, 2], [0, 1, 0]])


@pytest.mark.parametrize("coefficients", [RIGID_LINK, MASSLESS_JOINTS])
@pytest.mark.parametrize("seed", range(5))
def test_the_nearest_values_are_what_they_are_called_and_reach_no_further_than_any_other(coefficients, seed):
    A, random = mb.PolynomialMatrix(coefficients), np.random.default_rng(seed)
    values, force = random.normal(size=(2, 3)), mb.ramp(random.normal(size=3)) + mb.step(random.normal(size=3))
    found = mb.admissible(A, values, force)
    free = mb.solve(A, found.nearest, force)
    assert max((np.abs(c).max() for c in free.impulses), default=0.0) <= 1e-13
    still = mb.solve(A, found.nearest_continuous, force)
    assert np.abs(still.jump).max() <= 1e-13 and not still.impulses
    # x(0+) is a continuous start too: the nearest one is at most as far, in the solver's units
    scaling = A.jordan_pairs().form.companion.scaling

    def distance(other):
        return np.linalg.norm((other - values) / scaling.columns * scaling.time ** -np.arange(2.0)[:, None])

    assert distance(found.nearest) <= distance(found.nearest_continuous) * (1 + 1e-12)
    assert distance(found.nearest_continuous) <= distance(mb.solve(A, values, force).start) * (1 + 1e-12)


def test_a_system_without_algebraic_equations_admits_all():
    found = mb.admissible(mb.PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]]), [[1.0], [2.0]])
    assert found.is_continuous and found.residuals == () and found.dimensions == (2, 2, 2)
    assert np.array_equal(found.nearest_continuous, [[1.0], [2.0]])


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
