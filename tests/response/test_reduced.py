"""Large plain problems: the reduced equations against the Jordan pairs, closed forms and enclosures, and which way is taken."""

import mpmath
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.errors import Overflow
from mbconstrained.polynomial.reduced_equations import NotReducible, Reduction
from mbconstrained.response.choose import serving_reduction
from mbconstrained.response.methods.reduced_solution import ReducedSolution
from mbconstrained.response.response import Response
from mbconstrained.signals.inputs import zero
from tests.oracles.ball_exponential import motion

from .plain_models import difference, fitting_start, general, plain_system

EVEN = np.linspace(0.0, 40.0, 150)
TIMES = {
    "even from 0": EVEN,
    "even from later": 3.0 + 0.25 * np.arange(100),
    "uneven": np.sort(np.random.default_rng(0).uniform(0.0, 40.0, 30)),
    "not sorted, some twice": np.array([7.0, 1.0, 7.0, 0.0, 30.0]),
    "early": np.array([1e-9, 1e-4, 0.1, 0.4]),
}
MODELS = {
    "chain": plain_system("chain"),
    "tree, proportional damping": plain_system("tree", damping="proportional"),
    "grid, some dampers": plain_system("grid", damping="some"),
    "chain with joints of springs": plain_system("chain", static=4),
    "tree with joints of springs and of dampers": plain_system("tree", static=3, damped=3, damping="some"),
    "grid with ties": plain_system("grid", ties=4, values=0.25),
    "chain with all of them": plain_system("chain", static=3, damped=3, ties=3, damping="some", values=0.25),
}


def forces(size: int) -> dict[str, mb.ImpulsiveSmooth | None]:
    F, record = np.random.default_rng(5).normal(size=(6, size)), np.zeros((size, 5))
    record[[3, size // 2]] = np.random.default_rng(6).normal(size=(2, 5))
    return {
        "none": None,
        "sum": mb.step(F[0]) + mb.harmonic(F[1], angular_frequency=0.8, phase=0.3) + 0.1 * mb.ramp(F[2]),
        "late": mb.step(F[3]).delayed(7.25) + mb.harmonic(F[4], angular_frequency=2.0).delayed(1e-3),
        "record": mb.sampled(np.linspace(0.0, 10.0, 5), record),
    }


def is_reduced(x) -> bool:
    return isinstance(x.solution, ReducedSolution)


def same_events(found, expected) -> None:
    assert [event.time for event in found] == [event.time for event in expected]
    for one, two in zip(found, expected):
        assert np.array_equal(one.jump != 0, two.jump != 0)
        assert np.abs(one.jump - two.jump).max() <= 1e-12 * np.abs(two.jump).max()
        assert one.impulses == two.impulses == ()


@pytest.fixture(scope="module")
def answers():
    """The general answers, each found once."""
    found, pairs = {}, {model: system.polynomial_matrix().jordan_pairs() for model, system in MODELS.items()}

    def answer(model: str, force: str):
        if (model, force) not in found:
            system = MODELS[model]
            x = system.solve(*fitting_start(system), forces(system.size)[force])
            found[model, force] = (x, Response._by_pairs(pairs[model], x.initial, x.force))
        return found[model, force]

    return answer


@pytest.mark.parametrize(
    ("model", "force"),
    [
        *((model, force) for model in MODELS for force in ("none", "sum", "late")),
        ("chain", "record"),
        ("chain with all of them", "record"),
    ],
)
def test_values_velocities_and_jumps_are_those_of_the_jordan_pairs(answers, model, force):
    x, expected = answers(model, force)
    assert is_reduced(x)
    for times in TIMES.values():
        for order in (0, 1, 2):
            assert difference(x.derivative(order)(times), expected.derivative(order)(times)) <= 2e-12
    assert np.array_equal(x.jump != 0, expected.jump != 0)
    assert np.abs(x.jump - expected.jump).max() <= 1e-12
    same_events(x.events, expected.events)
    assert x.impulses == ()


@pytest.mark.parametrize("model", MODELS)
def test_mechanics_read_off_it(answers, model):
    x, expected = answers(model, "sum")
    other = type(x)(expected.problem, expected.solution, x.system, x.applied)
    times = TIMES["uneven"]
    for quantity in ("velocity", "acceleration", *(["reaction"] if x.system.rows else [])):
        assert difference(getattr(x, quantity)(times), getattr(other, quantity)(times)) <= 2e-12
    assert np.abs(x.energy(times).total - other.energy(times).total).max() <= 1e-12 * np.abs(other.energy(times).total).max()


def tied_to(time_function_jumps: bool):
    """A chain whose last mass is moved: its row of A(s) is x = s(t), and some of its mass goes with the last but one."""
    system = plain_system("chain", size=30)
    K, C, M = (np.array(matrix) for matrix in (system.stiffness, system.damping, system.mass))
    K[29], M[29], M[28, 29] = np.eye(30)[29], 0.0, 0.125
    smooth = mb.harmonic(np.eye(30)[29], angular_frequency=0.7, phase=-np.pi / 2)  # sin 0.7 t
    force = smooth + mb.step(np.eye(30)[29]).delayed(5.0) if time_function_jumps else smooth
    initial = np.zeros((2, 30))
    initial[1, 29] = 0.7
    return mb.solve(mb.PolynomialMatrix([K, C, M]), initial, force)


def test_a_mass_that_is_moved():
    x = tied_to(time_function_jumps=False)
    assert is_reduced(x)
    assert not x.jump.any()
    expected = general(x)
    for order in (0, 1, 2):
        assert difference(x.derivative(order)(EVEN), expected.derivative(order)(EVEN)) <= 2e-12
    assert np.allclose(x(EVEN)[29], np.sin(0.7 * EVEN), rtol=0, atol=1e-13)
    assert not is_reduced(tied_to(time_function_jumps=True))


def test_a_knot_earlier_than_anything_moves():
    """Beyond it the Taylor series of the start says nothing."""
    system = MODELS["chain"]
    F = np.ones(system.size)
    x = system.solve(force=mb.step(F) + mb.step(1e3 * F).delayed(1e-3))
    times = np.array([5e-4, 1e-3, 2e-3, 0.05, 0.2])
    assert difference(x.derivative(2)(times), general(x).derivative(2)(times)) <= 1e-12


@pytest.mark.parametrize("power", [0, 1, 3, 8])
@pytest.mark.parametrize("time", [1e-6, 1e-3, 0.1, 0.7, 1.0, 3.0])
def test_a_motion_from_rest_keeps_its_digits_from_the_first_moment_on(power, time):
    """x = sum over j of (-K)^j F p! t^(p + 2 + 2 j) / (p + 2 + 2 j)!, in whole numbers."""
    K = 2 * np.eye(24, dtype=int) - np.eye(24, k=1, dtype=int) - np.eye(24, k=-1, dtype=int)
    x = mb.solve(mb.PolynomialMatrix([K, 0 * K, np.eye(24)]), force=mb.term(np.eye(24)[0], power=power))
    assert is_reduced(x)
    vector, exact = np.eye(24, dtype=int)[0].astype(object), 0
    with mpmath.workdps(40):
        for j in range(40):
            degree = power + 2 + 2 * j
            exact = exact + vector * (mpmath.mpf(time) ** degree * mpmath.factorial(power) / mpmath.factorial(degree))
            vector = -K.astype(object) @ vector
    assert difference(x(time), exact.astype(float)) <= 2e-13


@pytest.mark.parametrize("model", ["chain", "tree, proportional damping", "grid, some dampers"])
def test_energy_only_goes_where_dampers_take_it(model):
    system = MODELS[model]
    energy = system.solve(*fitting_start(system)).energy(EVEN).total
    if system.damping.any():
        assert (np.diff(energy) < 0).all()
    else:
        assert np.abs(energy / energy[0] - 1).max() <= 1e-12


@pytest.mark.long
def test_the_estimate_covers_the_error_and_is_not_far_above_it():
    for model in ("chain", "grid, some dampers"):
        system = MODELS[model]
        x = system.solve(*fitting_start(system), forces(system.size)["sum"])
        times = np.array([3.0, 20.0, 200.0])
        box = x.enclose(times, 20)
        error = np.array(box.error_bounds(x(times)), dtype=float).max() / np.abs(x(times)).max()
        assert error <= x.error_estimate(times) <= 1e3 * error


@pytest.mark.parametrize("damper", [-2.0, -1e-3])
def test_growth_is_told(damper):
    system = MODELS["chain"]
    C = np.zeros((36, 36))
    C[3, 3] = damper
    x = mb.solve(mb.PolynomialMatrix([system.stiffness, C, system.mass]), np.ones((2, 36)))
    assert is_reduced(x)
    (told,) = [notice for notice in x.notices if notice.kind == "unstable"]
    (expected,) = [notice for notice in general(x).notices if notice.kind == "unstable"]
    assert told == expected


def test_growth_out_of_range_is_told_with_its_time():
    system = MODELS["chain"]
    K = system.stiffness - 3.0 * np.eye(36)
    x = mb.solve(mb.PolynomialMatrix([K, np.zeros((36, 36)), system.mass]), np.ones((2, 36)))
    for times in (1e4, np.linspace(0.0, 1e4, 100), np.array([1.0, 1e9])):
        with pytest.raises(Overflow, match="beyond the range of float64"):
            x(times)
    assert np.isfinite(x(np.linspace(0.0, 50.0, 100))).all()


@pytest.mark.parametrize("model", ["grid with ties", "tree with joints of springs and of dampers", "chain with all of them"])
def test_other_units_of_each_coordinate_and_each_equation_give_the_same_answer(model):
    system, random = MODELS[model], np.random.default_rng(0)
    coordinates, equations = 10.0 ** random.integers(-9, 10, (2, 36))
    x = system.solve(*fitting_start(system), mb.harmonic(np.ones(36), angular_frequency=0.8))
    scaled = [matrix * coordinates * equations[:, None] for matrix in x.polynomial_matrix.coefficients]
    force = system.constrained_form().force(mb.harmonic(np.ones(36), angular_frequency=0.8)).mapped(np.diag(equations))
    found = mb.solve(mb.PolynomialMatrix(scaled), x.initial / coordinates, force)
    assert is_reduced(found)
    assert np.array_equal(found.jump != 0, x.jump != 0)
    for times in TIMES.values():
        assert difference(found(times) * coordinates[:, None], x(times)) <= 1e-12


@pytest.mark.parametrize("size", [30, 70])
def test_rates_beyond_the_range_are_not_for_the_reduced_equations(size):
    masses = np.where(np.arange(size) % 2, 1e-200, 1.0)
    A = mb.PolynomialMatrix([1e200 * np.eye(size), np.zeros((size, size)), np.diag(masses)])
    assert isinstance(A.reduction, Reduction)
    with pytest.raises(NotReducible, match="leave the range of float64|stiffness spread"):
        serving_reduction(A, zero(size))


def test_masses_from_a_gram_to_a_ton():
    random, size = np.random.default_rng(8), 36
    M = np.diag(10.0 ** random.uniform(-3, 3, size))
    x = mb.solve(mb.PolynomialMatrix([MODELS["chain"].stiffness, np.zeros((size, size)), M]), random.normal(size=(2, size)))
    times = np.array([0.5, 3.0])
    box = x.enclose(times, 15)
    own, other = (np.array(box.error_bounds(y(times)), dtype=float).max() for y in (x, general(x)))
    assert is_reduced(x)
    assert own <= 10 * other
    assert own <= x.error_estimate(times) * np.abs(x(times)).max()


@pytest.mark.long
@pytest.mark.parametrize(("stiff", "damping"), [(1e12, 0.0), (1e9, 0.01)])
def test_bodies_of_stiff_links_on_soft_springs_keep_their_digits_whatever_the_unit_of_time(stiff, damping):
    """Fifteen pairs of masses move as bodies: their springs are remainders of sums of rows, a billionth of the entries."""
    n = 30
    springs = np.where(np.arange(n + 1) % 2, stiff, 1.0)
    K = np.diag(springs[:-1] + springs[1:]) - np.diag(springs[1:-1], 1) - np.diag(springs[1:-1], -1)
    C = damping * (np.diag(np.arange(n) % 7 + 1.0) + np.eye(n))
    exact = np.array(motion([K, C, np.eye(n)], np.ones((2, n)), 100.0), dtype=float)
    for unit in (2.0**-20, 1.0, 2.0**20):
        x = mb.solve(mb.PolynomialMatrix([K, unit * C, unit**2 * np.eye(n)]), [np.ones(n), np.ones(n) / unit])
        error = np.abs(x(100.0 * unit) - exact).max() / np.abs(exact).max()
        assert is_reduced(x) and error <= 1e-11 and error <= 10 * x.error_estimate(100.0 * unit)


def test_pairs_notices_and_evidence_are_there():
    system = MODELS["chain"]
    x = system.solve(*fitting_start(system))
    assert len(x.pairs.finite.zeros) > 0
    assert x.notices == ()
    assert [item.name for item in x.evidence] == ["condition"]
    assert x._coupling >= 0
