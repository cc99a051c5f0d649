"""Extrema of closed forms against dense samples, stationary points by SciPy and closed forms, singly and in families."""

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

import mbconstrained as mb
from mbconstrained.frequency.extrema import EXTREMA_ACCURACY, extrema, positive_times, root_mean_squares, sampled_extrema
from mbconstrained.ground.errors import InputError
from mbconstrained.signals.bohl import BohlFunction
from mbconstrained.signals.inputs import harmonic, sampled

KINDS = ("displacement", "velocity", "acceleration")


def chain(rng, count=1):
    """Masses of one decade, stiffnesses of up to eight, each damper from none to overdamped; ``count`` of them, 10 % different."""
    n = int(rng.integers(1, 5))
    m, k = 10 ** rng.uniform(-1, 1, n), 10 ** rng.uniform(1, 9 if rng.random() < 0.5 else 3, n)
    damping = rng.choice([0.0, 1e-3, 0.05, 1.0, 2.0], n)
    links = np.eye(n) - np.eye(n, k=-1)
    stiffness = k * rng.uniform(0.9, 1.1, (count, n))
    K = np.array([links.T * own @ links for own in stiffness])
    C = np.array([links.T * (2 * damping * np.sqrt(own * m)) @ links for own in stiffness])
    return np.diag(m), C, K


def load(rng, n, end):
    """Sinusoids, also in resonance or decaying, delayed steps, records, impulses, ramps."""
    v = rng.normal(size=n)
    kinds = [
        lambda: None,
        lambda: mb.harmonic(v, angular_frequency=10 ** rng.uniform(0, 2.5), phase=rng.uniform(0, 6)),
        lambda: mb.step(v).delayed(end * rng.uniform(0.1, 0.9)),
        lambda: mb.sampled(np.linspace(0, end, 12), np.outer(v, rng.normal(size=12))),
        lambda: mb.impulse(v).delayed(end / 3) + mb.impulse(-v),
        lambda: mb.ramp(v) + mb.harmonic(v, angular_frequency=20.0).delayed(end / 3),
        lambda: mb.term(v, rate=rng.uniform(-3, 0.5), angular_frequency=rng.uniform(0, 30)),
    ]
    return kinds[rng.integers(len(kinds))]()


@pytest.mark.parametrize("seed", range(8))
def test_no_dense_sample_lies_beyond(seed):
    """Samples also near the start and the knots, where the fast parts live; and what is reported is attained at its time."""
    rng = np.random.default_rng(seed)
    M, C, K = chain(rng)
    end = 10 ** rng.uniform(-1, 1)
    x = mb.MechanicalSystem(M, C[0], K[0]).solve(rng.normal(size=len(M)), rng.normal(size=len(M)), load(rng, len(M), end))
    for kind in KINDS:
        found, function = x.peaks(end, kind), x.derivative(KINDS.index(kind)) if kind != "displacement" else x.function
        knots = getattr(function, "rough", function).restarts.knots
        knots = knots[knots <= end]
        near = [np.minimum(knot + end * np.geomspace(1e-9, 1, 100), end) for knot in knots]
        values = function(np.unique(np.concatenate([np.linspace(0, end, 8001), *near])))
        size, margin = np.abs(values).max(axis=1), found.extrema.margin
        assert (values.max(axis=1) <= found.maximum + margin + 2 * EXTREMA_ACCURACY * size).all()
        assert (values.min(axis=1) >= found.minimum - margin - 2 * EXTREMA_ACCURACY * size).all()
        for times, expected in ((found.extrema.maximum_time, found.maximum), (found.extrema.minimum_time, found.minimum)):
            assert np.allclose(function(times).diagonal(), expected, rtol=0, atol=1e-9 * size.max())


@pytest.mark.parametrize("seed", range(8))
def test_families_and_single_runs_agree(seed):
    rng = np.random.default_rng(100 + seed)
    M, C, K = chain(rng, 3)
    end, start = 10 ** rng.uniform(-1, 0.7), rng.normal(size=len(M))
    motions = mb.family(M, C, K).solve(start, None, load(rng, len(M), end))
    for order, kind in enumerate(KINDS):
        for own, motion in zip(motions.extrema((0.0, end), order), motions):
            single = motion.peaks(end, kind)
            size = single.largest.max()
            assert np.allclose(own.largest, single.largest, rtol=0, atol=1e-11 * size)  # the accuracy of families is 1e-12


def test_combinations_of_families():
    """The elongation between two masses has its own extremum."""
    K = np.array([[[3.0, -1.0], [-1.0, 2.0]], [[5.0, -2.0], [-2.0, 2.0]]])
    motions = mb.family(np.eye(2), None, K).solve([1.0, -0.5])
    elongations = motions.extrema((0.0, 30.0), combinations=[[-1.0, 1.0]])
    t = np.linspace(0, 30, 30001)
    for own, x in zip(elongations, motions(t)):
        drift = x[1] - x[0]
        assert 0 <= own.maximum[0] - drift.max() < 1e-5 and 0 <= drift.min() - own.minimum[0] < 1e-5


@pytest.mark.parametrize("ratio", [1.0, 1.01, np.sqrt(2), 7.3])
def test_beats_against_stationary_points(ratio):
    """cos t + cos(r t) - 1/2 over 200 s: SciPy refines every hump of a dense sample."""
    wave = (mb.harmonic([1.0], angular_frequency=1.0, phase=0.3) + mb.harmonic([1.0], angular_frequency=ratio)).smooth
    found = extrema(wave, 0.0, 200.0)
    t = np.linspace(0, 200, 40001)

    def f(x):
        return np.cos(x + 0.3) + np.cos(ratio * x)

    for sign, value in ((1, found.maximum[0]), (-1, -found.minimum[0])):
        y = sign * f(t)
        tops = [i for i in np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] >= y[2:])) + 1 if y[i] > y.max() - 1e-3]
        refined = [
            -minimize_scalar(lambda x: -sign * f(x), bounds=(t[i - 1], t[i + 1]), method="bounded", options={"xatol": 1e-12}).fun
            for i in tops
        ]
        assert value == pytest.approx(max([*refined, y[0], y[-1]]), abs=1e-11)


def test_motions_of_a_million_periods_keep_an_honest_margin():
    """x = cos a + cos b of incommensurate phases comes as near to 2 as one likes: the value found and its margin contain it."""
    wave = (mb.harmonic([1.0], angular_frequency=1e6, phase=1.0) + mb.harmonic([1.0], angular_frequency=np.sqrt(2) * 1e6)).smooth
    found = extrema(wave, 0.0, 10.0)
    assert 1.99 < found.maximum[0] <= 2 <= found.maximum[0] + found.margin[0] + 1e-9
    assert found.margin[0] < 0.01
    single = extrema(
        mb.harmonic([3.0], angular_frequency=1e6).smooth, 0.0, 10.0
    )  # the sum of its amplitudes is reached: nothing is open
    assert single.largest[0] == pytest.approx(3.0, rel=1e-12) and single.margin[0] <= 1e-12 * 3


@pytest.mark.parametrize(
    ("signal", "end", "largest", "smallest"),
    [
        (lambda: mb.step([0.0]), 5.0, 0.0, 0.0),  # nothing moves
        (lambda: mb.step([-2.0]), 5.0, -2.0, -2.0),
        (lambda: mb.term([1.0], rate=2.0), 3.0, np.exp(6.0), 1.0),  # the last value of what grows
        (lambda: mb.step([1.0]).delayed(5.0), 5.0, 1.0, 0.0),  # a jump at the very end, right limit
        (
            lambda: mb.ramp([1.0]) - mb.ramp([1.0]).delayed(2.0) - mb.step([2.0]).delayed(2.0),
            4.0,
            2.0,
            0.0,
        ),  # the limit before a jump
        (lambda: mb.term([1.0], power=2, rate=-1e5), 10.0, 4e-10 * np.exp(-2.0), 0.0),  # over after 1e-4 of 10 s
    ],
)
def test_closed_forms(signal, end, largest, smallest):
    found = extrema(signal().smooth, 0.0, end)
    assert found.maximum[0] == pytest.approx(largest, rel=1e-12, abs=1e-300)
    assert found.minimum[0] == pytest.approx(smallest, rel=1e-12, abs=1e-12 * abs(largest))
    assert not found.margin.any()


def test_squares_are_sampled_and_refined():
    """An energy 4.5 sin^2 w t over 100 periods, with a jump."""
    w = 2 * np.pi * 10

    def energy(t):
        return np.array([np.where(t < 7.77, 4.5, 4.0) * np.sin(w * t) ** 2])

    found = sampled_extrema(energy, np.array([7.77]), 2 * w, 0.0, 10.0)
    assert found.maximum[0] == pytest.approx(4.5, rel=1e-12) and found.minimum[0] == pytest.approx(0.0, abs=1e-12)


def test_states_of_very_different_sizes():
    """SciPy casts the scales that balance a block to whole numbers, with a warning beyond 2^63; here b t with b = 1e40."""
    line = BohlFunction(np.array([[1.0, 0.0]]), (np.array([[0.0, 1e40], [1e-60, 0.0]]),), np.array([0.0, 1.0]))
    found = extrema(line, 0.0, 2.0)
    assert found.maximum[0] == pytest.approx(2e40, rel=1e-12) and found.minimum[0] == 0.0


def exact_mean_square(rates, factors, end):
    """Of the real part of a sum of exponentials over [0, end], term by term in 60 digits."""
    mp = pytest.importorskip("mpmath")
    with mp.workdps(60):
        terms = [(mp.mpmathify(complex(a)) / 2, mp.mpmathify(complex(s))) for a, s in zip(factors, rates)]
        terms += [(mp.conj(a), mp.conj(s)) for a, s in terms]
        total = mp.mpf(0)
        for a, s in terms:
            for b, r in terms:
                total += a * b * (mp.expm1((s + r) * end) / (s + r) if s + r else mp.mpf(end))
        return float(mp.sqrt(total.real / end))


RATES = {
    "one period": ([2j], [1.0], np.pi),
    "many periods": ([2000j, -3 + 1999j], [1.0, 0.5j], 40.0),
    "millions of periods": ([1e7j, 1e3j], [1.0, 2.0], 60.0),
    "a fast start": ([-1e9, -1 + 5j], [3.0, 1.0], 3.0),
    "growth": ([0.3 + 7j, -0.1], [1e-3, 2.0], 20.0),
    "beats": ([100j, 100.01j], [1.0, -1.0], 1.0),
}


@pytest.mark.parametrize(("rates", "factors", "end"), RATES.values(), ids=RATES)
def test_rms_values_are_the_integrals(rates, factors, end):
    blocks = tuple(np.array([[s.real, -s.imag], [s.imag, s.real]]) if s.imag else np.array([[s.real]]) for s in map(complex, rates))
    row = [part for a, s in zip(map(complex, factors), map(complex, rates)) for part in ([a.real, -a.imag] if s.imag else [a.real])]
    start = [part for s in map(complex, rates) for part in ([1.0, 0.0] if s.imag else [1.0])]
    rms = root_mean_squares(BohlFunction(np.array([row]), blocks, np.array(start)), 0.0, end)
    right = exact_mean_square(rates, factors, end)
    assert abs(rms.values[0] - right) <= max(rms.error_estimate[0], 1e-15 * right)
    assert rms.error_estimate[0] <= (1e-9 if len(factors) > 1 and factors[1] == -1.0 else 1e-12) * right


def test_rms_of_a_record_with_a_constant_and_its_kinks():
    knots = np.array([0.0, 0.3, 1.0, 1.1, 2.0])
    record = sampled(knots, [[0.0, 3.0, -1.0, 5.0, 0.0]]).smooth
    values = np.array([0.0, 3.0, -1.0, 5.0, 0.0]) + 2.0
    parts = np.diff(knots) * (values[:-1] ** 2 + values[:-1] * values[1:] + values[1:] ** 2) / 3  # Simpson's rule is exact
    assert root_mean_squares(record, 0.0, 2.0, np.array([2.0])).values[0] == pytest.approx(np.sqrt(parts.sum() / 2), rel=1e-14)
    assert root_mean_squares(0.0 * record, 0.0, 2.0).values[0] == 0


def test_rms_of_more_accurate_values():
    wave = harmonic([1.0], angular_frequency=3.0).smooth
    accurate = lambda times: np.cos(3.0 * np.atleast_1d(times))[None]  # noqa: E731
    assert root_mean_squares(1.001 * wave, 0.0, 2 * np.pi, accurate=accurate).values[0] == pytest.approx(0.5**0.5, rel=1e-14)
    with pytest.raises(InputError, match="too many periods"):
        root_mean_squares(1.001 * wave, 0.0, 1e7, accurate=accurate)


def test_first_and_largest_positive_values_between_samples():
    at = lambda times: np.array([np.cos(40 * times) - 0.999, np.sin(times) - 2.0, times - 0.123456789])  # noqa: E731
    largest, positive = positive_times(at, np.zeros(0), 40.0, 0.05, 1.0)
    first = 2 * np.pi / 40 - np.arccos(0.999) / 40
    assert positive == pytest.approx([first, np.inf, 0.123456789], abs=1e-12)
    assert np.cos(40 * largest[0]) == pytest.approx(1.0, abs=1e-12) and largest[1:].tolist() == [np.inf, 1.0]
    assert np.isinf(positive_times(at, np.zeros(0), 40.0, 0.05, 0.1)).all()
