"""Records on large models, in all places where they may be asked: against oscillators in forty digits and the general route."""

from functools import cache

import mpmath
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.ground.errors import Overflow
from mbconstrained.polynomial.jordan_pairs import JordanPairs
from mbconstrained.response.flow import FEWEST_KNOTS as FEW_PIECES
from mbconstrained.response.methods import reduced_solution as even_pieces
from mbconstrained.response.methods.reduced_solution import record_of
from mbconstrained.response.response import Response
from mbconstrained.signals.bohl import FreeRestarts
from tests.response.chains import COUNT, chain, first_order, masses

RANDOM = np.random.default_rng(8)

#: Oscillators that know nothing of each other: slow and fast, without, with little and with much damping; kg, N s/m, N/m.
MASSES = RANDOM.uniform(0.5, 2.0, 30)
STIFFNESSES = MASSES * np.geomspace(1e-3, 2.0, 30) ** 2
DAMPINGS = 2 * np.sqrt(MASSES * STIFFNESSES) * np.resize([0.0, 0.02, 0.3, 1.7], 30)

GAPS = {"even": np.full(90, 0.5), "uneven": RANDOM.uniform(0.05, 1.0, 90), "short": np.full(90, 2.0**-10)}


def oscillators(dampings=DAMPINGS) -> mb.PolynomialMatrix:
    return mb.PolynomialMatrix([np.diag(STIFFNESSES), np.diag(dampings), np.diag(MASSES)])


def samples_on(rows, knots, size=COUNT, seed=1):
    values = np.zeros((size, len(knots)))
    values[list(rows)] = np.random.default_rng(seed).normal(size=(len(list(rows)), len(knots)))
    return values


@cache
def chain_with_pairs() -> tuple[mb.PolynomialMatrix, JordanPairs]:
    return chain(), chain().jordan_pairs()


def exact_oscillator(at: int, knots, samples, times, dampings=DAMPINGS) -> np.ndarray:
    """From rest: with zeros s1, s2 of m s^2 + c s + k the sum over knots of e^{s u} times the change of slope or value there."""
    with mpmath.workdps(60):
        m, c, k = (mpmath.mpf(float(part[at])) for part in (MASSES, dampings, STIFFNESSES))
        root = mpmath.sqrt(mpmath.mpc(c * c - 4 * m * k))
        zeros = (-c + root) / (2 * m), (-c - root) / (2 * m)
        t, f = ([mpmath.mpf(float(x)) for x in given] for given in (knots, samples))
        slopes = [0, *((f[j + 1] - f[j]) / (t[j + 1] - t[j]) for j in range(len(t) - 1)), 0]
        jumps = [f[0], *([0] * (len(t) - 2)), -f[-1]]

        def ramp_and_step(u):
            e = [mpmath.exp(s * u) for s in zeros]
            step = sum((e[i] - 1) / s / (m * (s - zeros[1 - i])) for i, s in enumerate(zeros))
            ramp = sum((e[i] - 1 - s * u) / s**2 / (m * (s - zeros[1 - i])) for i, s in enumerate(zeros))
            return ramp, step

        found = []
        for time in times:
            total = mpmath.mpf(0)
            for j, knot in enumerate(t):
                if knot < time:
                    ramp, step = ramp_and_step(mpmath.mpf(float(time)) - knot)
                    total += (slopes[j + 1] - slopes[j]) * ramp + jumps[j] * step
            found.append(float(mpmath.re(total)))
        return np.array(found)


@pytest.mark.parametrize("gaps", GAPS.values(), ids=GAPS)
@pytest.mark.parametrize("begin", [0.0, 40.0], ids=["at once", "late"])
def test_oscillators_follow_a_record_as_forty_digits_say(gaps, begin):
    knots = begin + np.append(0.0, np.cumsum(gaps))
    values = samples_on(range(30), knots, 30)
    x = mb.solve(oscillators(), force=mb.sampled(knots, values))
    middles = knots[:-1] + 0.37 * np.diff(knots)
    beside, late = np.nextafter(knots[50], [0, 99]), knots[-1] + [0.1, 7.0, 900.0]
    asked = np.concatenate([[0.0, begin / 2], knots[[1, 40, -1]], middles[::31], beside, late])
    for found in (x(knots), x(np.sort(asked))):
        assert np.isfinite(found).all()
    found = x(asked)
    for at in (0, 5, 14, 28):
        known = exact_oscillator(at, knots, values[at], asked)
        assert np.abs(found[at] - known).max() <= 2e-13 * np.abs(known).max()


@pytest.mark.parametrize("gaps", [np.full(70, 12.0), RANDOM.uniform(0.5, 40.0, 70)], ids=["even", "uneven"])
def test_oscillators_that_turn_often_within_a_gap_follow_a_record_as_forty_digits_say(gaps):
    dampings, knots = DAMPINGS * (DAMPINGS**2 < 2 * MASSES * STIFFNESSES), np.append(0.0, np.cumsum(gaps))
    values = samples_on(range(30), knots, 30)
    x = mb.solve(oscillators(dampings), force=mb.sampled(knots, values))
    assert record_of(x.function.flow).parts > 5
    asked = np.concatenate([knots[[1, 40, -1]], knots[:-1:9] + RANDOM.uniform(0, 1, 8) * gaps[::9], [knots[-1] + 7.0]])
    for at in (0, 14, 29):
        known = exact_oscillator(at, knots, values[at], asked, dampings)
        assert np.abs(x(asked)[at] - known).max() <= 2e-13 * np.abs(known).max()


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_values_and_derivatives_are_those_of_the_general_route(order):
    A, knots = chain(), np.append(0.0, np.cumsum(RANDOM.uniform(0.1, 0.7, 150)))
    steady = mb.step(np.eye(COUNT)[7]) + mb.harmonic(np.eye(COUNT)[4], angular_frequency=0.9)
    force = mb.sampled(knots, samples_on((3, 20), knots)) + steady
    start = RANDOM.normal(size=(2, COUNT))
    asked = np.sort(RANDOM.uniform(0.0, 1.3 * knots[-1], 300))
    ways = mb.solve(A, start, force), Response._by_pairs(A.jordan_pairs(), start, force)
    found, known = (x.derivative(order)(asked) for x in ways)
    assert np.abs(found - known).max() <= 1e-12 * np.abs(known).max()


def test_steps_and_modes_give_the_same_values_at_the_knots():
    knots = 0.4 * np.arange(700)
    force = mb.sampled(knots, samples_on((2, 9), knots))
    for chosen in (slice(None), slice(0, 200)):
        A = tangled_chain()
        x, start = mb.solve(A, RANDOM.normal(size=(2, COUNT)), force), knots[chosen]
        stepped = x(start)
        assert "decoupled" not in vars(A.reduction)
        by_modes = mb.solve(A, x.initial, force, evaluations="many")(start)
        assert "decoupled" in vars(A.reduction)
        assert np.abs(stepped - by_modes).max() <= 1e-12 * np.abs(by_modes).max()


def tangled_chain() -> mb.PolynomialMatrix:
    """A chain with springs between masses apart: neither symmetric modes nor those of a tree serve."""
    K, C, M = chain().coefficients.copy()
    K[3, 17] = K[17, 3] = -0.4
    return mb.PolynomialMatrix([K, C, M])


def test_coordinates_without_mass_follow_a_record_too():
    """One that only springs hold takes part of the force at once, one that a damper holds follows by its own rate."""
    K, C, M = chain().coefficients.copy()
    M[-2, -2] = M[5, 5] = C[5, 5] = 0.0
    C[-2, -2] = 0.8
    A, knots = mb.PolynomialMatrix([K, C, M]), 0.3 * np.arange(200)
    force = mb.sampled(knots, samples_on((5, COUNT - 2), knots))
    asked = np.concatenate([knots, knots[:-1] + 0.11, [70.0]])
    x, known = mb.solve(A, force=force), Response._by_pairs(A.jordan_pairs(), np.zeros((2, COUNT)), force)(asked)
    for _ in range(2):
        assert np.abs(x(knots) - known[:, :200]).max() <= 1e-12 * np.abs(known).max()
        assert np.abs(x(asked) - known).max() <= 1e-12 * np.abs(known).max()


@pytest.mark.parametrize("gap, parts", [(30.0, 20), (4000.0, None)])
def test_a_record_that_is_coarse_beside_the_motion_is_evaluated_in_parts_of_its_gaps_or_by_the_general_formula(gap, parts):
    A, knots = chain(), gap * np.arange(100)
    force = mb.sampled(knots, samples_on((2,), knots))
    x, asked = mb.solve(A, force=force), np.append(np.linspace(0.0, 101 * gap, 77), knots)
    pieces = record_of(x.function.flow)
    assert (pieces and pieces.parts) == parts
    known = Response._by_pairs(A.jordan_pairs(), np.zeros((2, COUNT)), force)(asked)
    assert np.abs(x(asked) - known).max() <= 1e-11 * np.abs(known).max()


@pytest.mark.parametrize("kept", [0, even_pieces.KEPT])
def test_of_even_samples_the_modes_at_every_sixteenth_give_all_others(kept, monkeypatch):
    monkeypatch.setattr(even_pieces, "KEPT", kept)
    knots = 0.25 * np.arange(1001)
    force = mb.sampled(knots, samples_on((2, 9), knots))
    x, uneven = (mb.solve(chain(), force=given) for given in (force, force + 0.0 * mb.step(np.eye(COUNT)[2]).delayed(0.1)))
    asked = np.sort(RANDOM.uniform(0.0, 260.0, 100))
    assert record_of(x.function.flow).states[0].shape == (63, COUNT) and record_of(uneven.function.flow).states[0].shape == (
        1002,
        COUNT,
    )
    for times in (asked, knots, knots[5:90], knots[::-7]):
        assert np.abs(x(times) - uneven(times)).max() <= 1e-12 * np.abs(x(knots)).max()
    assert (record_of(x.function.flow)._every is None) == (kept == 0)


@pytest.mark.parametrize("gap", [0.25, 3.0])
def test_what_would_grow_stays_at_rest_where_nothing_pushes_it(gap):
    K, C, M = chain().coefficients.copy()
    K[-1], K[:, -1], C[-1], C[:, -1], K[-1, -1] = 0.0, 0.0, 0.0, 0.0, -2.0
    knots = gap * np.arange(3000)
    x = mb.solve(mb.PolynomialMatrix([K, C, M]), force=mb.sampled(knots, samples_on((2,), knots)))
    for times in (knots, knots + 0.1):
        assert np.isfinite(x(times)).all() and not x(times)[-1].any()


def test_a_free_chain_is_pushed_along():
    """Its zeros at 0 are together in a block: its middle moves on like t^2 and t^3 within each gap."""
    K, C, M = chain(0.0).coefficients.copy()
    K[0, 0] = K[-1, -1] = 1.0
    A, knots = mb.PolynomialMatrix([K, C, M]), 0.3 * np.arange(150)
    force, start = mb.sampled(knots, samples_on((2,), knots)), np.zeros((2, COUNT))
    start[1] = 0.3
    x, asked = mb.solve(A, start, force), np.concatenate([knots, knots[:-1] + 0.11, [70.0]])
    if hasattr(x.function, "flow"):
        assert len(record_of(x.function.flow).modes.rest) == 2
    for known in (Response._by_pairs(A.jordan_pairs(), start, force)(asked), x(asked)):
        assert np.abs(x(asked) - known).max() <= 1e-11 * np.abs(known).max()
        assert np.allclose(np.diag(M) @ known, (0.3 * np.diag(M).sum() * asked) + momentum(force, asked), rtol=1e-10, atol=1e-9)


def momentum(force, times) -> np.ndarray:
    """Of the sum of all rows the integral over time, twice, by Gauss with two points between the knots: the rows are linear."""
    found, knots = [], force.knots
    for time in times:
        ends = np.append(knots[knots < time], time)
        points = np.array([-1, 1]) / 3**0.5
        at = (ends[:-1, None] + np.diff(ends)[:, None] * (points + 1) / 2).ravel()
        weights = np.repeat(np.diff(ends) / 2, 2)
        found.append(((time - at) * force(at).sum(axis=0)) @ weights if len(ends) > 1 else 0.0)
    return np.array(found)


def test_a_motion_that_grows_out_of_range_is_told():
    K, C, M = chain().coefficients.copy()
    A, knots = mb.PolynomialMatrix([K, -40.0 * C, M]), 0.1 * np.arange(300)
    x = mb.solve(A, force=mb.sampled(knots, samples_on((2,), knots)))
    assert np.isfinite(x(knots[:100] + 0.05)).all()
    with pytest.raises(Overflow):
        x([5.0, 4000.0])


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-6, 3.0]), st.booleans())
def test_any_knots_any_times(seed, begin, jumps):
    random = np.random.default_rng(seed)
    knots = begin + np.append(0.0, np.cumsum(random.choice([0.01, 0.25, 0.5, 0.7], FEW_PIECES + 5)))
    values = samples_on((4,), knots, seed=seed)
    times = knots
    if jumps:
        times, values = np.insert(knots, 9, knots[9]), np.insert(values, 9, 3.0 * np.eye(COUNT)[4], axis=1)
    (A, pairs), force = chain_with_pairs(), mb.sampled(times, values)
    before, after = (np.nextafter(knots[9:12], end) for end in (0, 99))
    asked = np.concatenate([random.uniform(0, 1.2 * knots[-1], 20), knots[::7], before, after])
    x, general = mb.solve(A, force=force), Response._by_pairs(pairs, np.zeros((2, COUNT)), force)
    assert record_of(x.function.flow) is not None
    assert np.abs(x(asked) - general(asked)).max() <= 1e-12 * np.abs(general(asked)).max()


# A chain under a record on one mass, against steps with the matrix exponential of the motion and its force together.

PUSHED = 11


def record(times, rows=(PUSHED,), size=COUNT):
    """Random samples on some coordinates, and the force."""
    samples = RANDOM.normal(size=(len(rows), len(times)))
    values = np.zeros((size, len(times)))
    values[list(rows)] = samples
    return samples[0], mb.sampled(times, values)


def by_steps(A, times, samples) -> np.ndarray:
    """x at the samples from rest: (z, f, f') by e^{...h}."""
    n, S = A.size, first_order(A)
    joint = np.zeros((2 * n + 2, 2 * n + 2))
    joint[: 2 * n, : 2 * n], joint[n + PUSHED, 2 * n], joint[2 * n, 2 * n + 1] = S, 1 / masses()[PUSHED], 1.0
    steps = {gap: scipy.linalg.expm(joint * gap) for gap in set(np.diff(times))}
    z, found = np.zeros(2 * n), [np.zeros(n)]
    for gap, slope, value in zip(np.diff(times), np.diff(samples) / np.diff(times), samples):
        z = (steps[gap] @ np.concatenate([z, [value, slope]]))[: 2 * n]
        found.append(z[:n])
    return np.array(found).T


@pytest.mark.parametrize(
    "gaps", [np.full(700, 0.5), np.tile([0.25, 0.5, 1.0], 200), np.full(900, 2.0**-7)], ids=["even", "three", "short"]
)
def test_a_record_is_followed_as_steps_follow_it(gaps):
    A, times = chain(), np.append(0.0, np.cumsum(gaps))
    samples, force = record(times)
    x = mb.solve(A, force=force)
    known = by_steps(A, times, samples)
    assert np.abs(x(times) - known).max() <= 1e-11 * np.abs(known).max()


def test_at_samples_in_any_order_the_values_are_those_of_each_alone():
    A, times = chain(), np.linspace(0.0, 20.0, 301)
    x = mb.solve(A, force=record(times)[1])
    chosen = times[RANDOM.permutation(301)[:40]]
    assert np.allclose(x(chosen), np.array([x(time) for time in chosen]).T, rtol=0, atol=1e-14)
    beside = np.nextafter(times[1:], 0)
    assert np.allclose(x(beside), x(times[1:]), rtol=0, atol=1e-13)


def test_rows_of_a_record_that_stay_zero_have_no_states():
    force = record(np.linspace(0, 1, 20), (3, 7))[1]
    assert force.smooth.coefficients.shape == (COUNT, 4)
    nothing = mb.sampled([0.0, 1.0], np.zeros((2, 2)))
    assert nothing.is_zero and nothing([0.0, 0.5]).tolist() == [[0.0, 0.0], [0.0, 0.0]]


def test_jumps_of_the_states_are_what_the_pieces_leave():
    A = chain()
    x = mb.solve(A, force=record(np.linspace(0.0, 3.0, 7))[1])
    start = x.function.start
    assert isinstance(start, FreeRestarts)
    J = x.function.generator
    for k in range(1, len(start.knots)):
        before = scipy.linalg.expm(J * (start.knots[k] - start.knots[k - 1])) @ start.states[:, k - 1]
        assert np.allclose(start.jumps[:, k], start.states[:, k] - before, rtol=0, atol=1e-12 * np.abs(start.states).max())
    assert np.array_equal(start.jumps[:, 0], start.states[:, 0])
    late = x.function.delayed(2.0)
    assert not late(1.0).any() and np.allclose(late([2.0, 3.3]), x([0.0, 1.3]), rtol=0, atol=1e-13)


def test_jumps_of_the_force_make_accelerations_jump_and_nothing_else_of_a_mass():
    A = chain()
    x = mb.solve(A, force=mb.pulse(np.eye(COUNT)[PUSHED], start=1.0, duration=1.0))
    assert x.events == ()
    jump = x.derivative(2)(1.0) - x.derivative(2)(np.nextafter(1.0, 0))
    assert np.allclose(jump, np.eye(COUNT)[PUSHED] / masses(), rtol=0, atol=1e-12)


def test_a_damper_alone_that_is_pushed_by_a_jump_changes_its_velocity():
    """K x + C x' + M x'' = f, the last coordinate without mass: x' jumps there by the jump of f over the damping."""
    K, C, M = chain().coefficients.copy()
    M[-1, -1], C[-1, -1] = 0.0, 0.5
    A = mb.PolynomialMatrix([K, C, M])
    x = mb.solve(A, force=mb.step(3.0 * np.eye(COUNT)[-1]).delayed(2.0))
    assert [event.time for event in x.events] == [2.0]
    assert np.allclose(x.events[0].jump[1], 6.0 * np.eye(COUNT)[-1], rtol=0, atol=1e-12) and not x.events[0].jump[0].any()
