"""Models have the sizes that they are said to have, hand reductions the motions of the package; references agree with one another and with formulas."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb
from tests.benchmarks.speed.models import (
    SLOWEST,
    STARTS,
    Equations,
    as_fractions,
    chain,
    even_times,
    example_equations,
    example_system,
    forty_periods,
    reduced_chain,
    stack_equations,
    stack_model,
    stack_start,
    with_oscillator,
)
from tests.benchmarks.speed.motions import (
    INTEGRATORS,
    MOTIONS,
    PEERS,
    Method,
    chain_system,
    free_chain,
    harmonic_chain,
    recorded_chain,
)
from tests.benchmarks.speed.references import by_balls, by_taylor, record_by_taylor
from tests.benchmarks.tables import Measured, fastest, relative_error
from tests.oracles.models import table

EXTENDED = np.finfo(np.longdouble).nmant > 60


def test_balls_of_an_oscillator_over_a_million_radians():
    """x'' = -x."""
    equations = Equations(*map(as_fractions, ([[0, 1], [-1, 0]], [[1, 0]], [1, 0], [0, 0])))
    times = even_times(2.0**20, 5)
    np.testing.assert_allclose(by_balls(equations, times)[0], np.cos(times), rtol=0, atol=1e-15)


def test_a_record_that_is_constant_is_a_step():
    """x'' = -x + 1 from rest: 1 - cos t."""
    equations = Equations(*(np.array(array, dtype=np.longdouble) for array in ([[0, 1], [-1, 0]], [[1, 0]], [0, 0], [0, 1])))
    times = even_times(40.0, 50)
    np.testing.assert_allclose(record_by_taylor(equations, times, np.ones(50))[0], 1 - np.cos(times), atol=1e-15)


def suitable(problem) -> list[Method]:
    return [method for method in PEERS if method.suits(problem)]


@pytest.mark.parametrize("make", [lambda: free_chain(10), lambda: free_chain(10, damped=False), lambda: harmonic_chain(10)])
def test_peers_are_right(make):
    problem = make()
    truth, methods = problem.truth(), suitable(problem)
    assert len(methods) >= 3
    for method in methods:
        assert relative_error(method.prepare(problem)(problem.times), truth) < 1e-11, method.name


def test_lsim_is_right_about_a_record():
    problem = recorded_chain(10)
    (lsim,) = suitable(problem)
    assert relative_error(lsim.prepare(problem)(problem.times), problem.truth()) < 1e-12


def test_solve_ivp_reaches_its_tolerance():
    problem = MOTIONS[0].make()
    (integrator,) = INTEGRATORS
    assert relative_error(integrator.prepare(problem)(problem.times), problem.truth()) < 1e-10


def test_a_faster_method_is_bold():
    rival = Measured("lsim", 1e-15, 2e-3, 1e-3)
    assert fastest(rival, "one_run", 1e-3) == "2 ms (lsim)" and fastest(rival, "further", 2e-3) == "**1 ms (lsim)**"
    assert fastest(None, "one_run", 1.0) == "no correct digit"


@pytest.mark.parametrize("motion", [one for one in MOTIONS if one.states <= 250], ids=lambda motion: motion.name)
def test_every_small_model_has_its_number_of_states(motion):
    assert motion.make().equations.S.shape == (motion.states,) * 2


def close(found, known, digits: float) -> bool:
    return bool(np.abs(found - known).max() <= digits * np.abs(known).max())


@pytest.mark.parametrize(("count", "size", "rows", "states"), [(10, 12, 1, 20), (100, 120, 10, 205), (1000, 1200, 100, 2050)])
def test_sizes_of_the_damped_chain(count, size, rows, states):
    given = chain(count)
    assert (given.size, len(given.rows), given.states) == (size, rows, states)
    assert len(given.joints) + len(given.damped_joints) == count // 10
    assert reduced_chain(given).S.shape == (states, states)


def test_sizes_of_the_undamped_chain():
    given = chain(500, damped=False, damped_joints=False)
    assert given.states == 1000 and not given.damping.any() and reduced_chain(given).mass.shape == (500, 500)


def test_the_package_finds_as_many_zeros_as_there_are_states():
    for count in (10, 20):
        motion = chain_system(chain(count)).solve()
        assert len(motion.pairs.finite.J) == chain(count).states


@pytest.mark.parametrize("damped", [True, False])
def test_the_start_breaks_no_equation(damped):
    given = chain(60, damped, damped_joints=damped)
    assert not (given.rows @ given.start).any()
    massless = [*given.joints, *given.damped_joints]
    assert np.abs(given.stiffness[massless] @ given.start).max() < 1e-14


def test_matrices_are_those_of_passive_elements():
    given = chain(30)
    for matrix in (given.mass, given.damping, given.stiffness):
        assert (matrix == matrix.T).all() and np.linalg.eigvalsh(matrix).min() > -1e-14


def test_forty_periods_are_about_forty_periods():
    equations = reduced_chain(chain(100, damped=False, damped_joints=False))
    roots = np.sqrt(np.diag(equations.mass))
    slowest = np.sqrt(np.linalg.eigvalsh(equations.stiffness / np.outer(roots, roots))[0])
    assert 35 < forty_periods(100) * slowest / (2 * np.pi) < 45


def test_fractions_and_floats_are_reduced_alike():
    given = chain(20)
    exact, rounded = reduced_chain(given, as_fractions, pushed=3), reduced_chain(given, pushed=3)
    for name in ("S", "E", "start", "b"):
        np.testing.assert_allclose(getattr(rounded, name), getattr(exact, name).astype(float), rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize(("count", "damped"), [(10, True), (20, True), (20, False)])
def test_the_free_chain_moves_as_the_package_balls_and_taylor_steps_say(count, damped):
    given, times = chain(count, damped, damped_joints=damped), even_times(forty_periods(count), 16)
    known = by_balls(reduced_chain(given, as_fractions), times)
    assert close(chain_system(given).solve(given.start)(times), known, 1e-12)
    assert close(by_taylor(reduced_chain(given, np.longdouble), times), known, 1e-15 if EXTENDED else 1e-11)


def test_the_chain_under_a_harmonic_force_moves_as_the_package_says():
    given, times = chain(10), even_times(60.0, 16)
    equations = with_oscillator(reduced_chain(given, np.longdouble, pushed=5), np.longdouble(0.375))
    force = mb.harmonic(np.eye(given.size)[5], angular_frequency=0.375)
    assert close(chain_system(given).solve(given.start, force=force)(times), by_taylor(equations, times), 1e-12)


def test_the_chain_under_a_record_moves_as_the_package_says():
    given, times = chain(10), even_times(30.0, 16)
    record = np.random.default_rng(1).standard_normal(16)
    record[-1] = 0.0
    known = record_by_taylor(reduced_chain(given, np.longdouble, pushed=5), times, record)
    values = np.zeros((given.size, 16))
    values[5] = record
    assert close(chain_system(given).solve(given.start, force=mb.sampled(times, values))(times), known, 1e-12)


@pytest.mark.parametrize(
    ("name", "example", "columns"), [("5.1", "ex51", ("x1bar", "q1", "q2bar")), ("5.2", "ex52", ("u1", "u2", "u3"))]
)
def test_the_examples_are_those_of_the_paper(name, example, columns):
    """Their tables have the times 0, 0.5, ..., 50."""
    times, known = table(example, "t"), np.array([table(example, column) for column in columns])
    assert close(example_system(name).solve(STARTS[name])(times), known, 1e-12)
    found = by_balls(example_equations(name), 0.5 * np.arange(101))[:, (2 * times).astype(int)]
    assert close(found, known, 1e-14)


@pytest.mark.long
@pytest.mark.parametrize("damping", [0.0, 1e-2])
def test_the_stack_moves_as_the_package_says(damping):
    times, names = even_times(80.0, 9), [f"mass {place + 1}" for place in range(20)]
    start = dict(zip(names, stack_start().tolist()))
    known = by_balls(stack_equations(1e6, damping, exactly=True), times)
    assert close(stack_model(1e6, damping).assemble().solve(start)(times), known, 1e-11)


def test_the_slowest_oscillation_of_the_stack():
    equations = stack_equations(1e6, 0.0, exactly=False)
    slowest = np.sqrt(np.linalg.eigvalsh(equations.stiffness)[0])
    assert abs(slowest / SLOWEST - 1) < 1e-5
