"""Baselines: the polynomials of least squares, found by another method, and what their removal does to velocities."""

import numpy as np
import pytest

from mbconstrained.exchange.samples import DEGREES, baseline, integrals
from mbconstrained.ground.errors import InputError

RNG = np.random.default_rng(36)
TIMES = np.cumsum(RNG.uniform(0.005, 0.02, 400)) + 3.0  # uneven, and not from 0 on
VALUES = np.sin(5 * TIMES) + 0.3 * RNG.normal(size=400) + 0.1 * (TIMES - 3) ** 2


@pytest.mark.parametrize("degree", DEGREES)
def test_the_record_and_its_baseline_have_the_same_moments(degree):
    """The normal equations of least squares: integral of t^k (a - p) = 0, by Simpson's rule in each of many parts of the steps."""
    fitted = baseline(TIMES, VALUES, degree)
    dense = np.unique(np.concatenate([TIMES, np.linspace(TIMES[0], TIMES[-1], 200_001)]))
    middle = (dense[1:] + dense[:-1]) / 2
    ends, mid = (np.interp(t, TIMES, VALUES) - fitted(t) for t in (dense, middle))
    for k in range(DEGREES[degree] + 1):
        f, g = ends * (dense - 3) ** k, mid * (middle - 3) ** k
        assert np.sum(np.diff(dense) * (f[1:] + 4 * g + f[:-1]) / 6) == pytest.approx(0, abs=1e-10)


@pytest.mark.parametrize("degree", DEGREES)
def test_the_fit_of_the_integral_is_that_of_a_dense_velocity(degree):
    """By np.linalg.lstsq over the velocity at 100,000 times, whose sums differ from integrals by their spacing."""
    fitted = baseline(TIMES, VALUES, degree, "integral")
    dense = np.linspace(TIMES[0], TIMES[-1], 100_001)
    a = np.interp(dense, TIMES, VALUES)
    velocity = np.concatenate([[0], np.cumsum((a[1:] + a[:-1]) / 2 * np.diff(dense))])
    basis = np.array([(dense - TIMES[0]) ** (k + 1) / (k + 1) for k in range(DEGREES[degree] + 1)]).T
    expected = np.linalg.lstsq(basis, velocity, rcond=None)[0]
    assert fitted.coefficients == pytest.approx(expected, rel=2e-4)


@pytest.mark.parametrize("fit", ["record", "integral"])
def test_a_linear_drift_of_the_logger_is_removed_to_rounding(fit):
    drift = 0.4 + 0.07 * TIMES
    clean, drifted = (values - baseline(TIMES, values, "linear", fit)(TIMES) for values in (VALUES, VALUES + drift))
    assert drifted == pytest.approx(clean, abs=1e-13)


def test_integrals_of_linear_pieces():
    """a = t between 0 and 1 and 1 between 1 and 2: v = t^2/2 and t - 1/2, x = t^3/6 and t^2/2 - t/2 + 1/6, by hand."""
    first, second = integrals(np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0, 1.0]))
    assert first == pytest.approx([0, 1 / 2, 3 / 2], rel=1e-15)
    assert second == pytest.approx([0, 1 / 6, 7 / 6], rel=1e-15)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("qadratic",), "baseline: found 'qadratic'; expected one of constant, .*; did you mean \"quadratic\""),
        (("linear", "velocity"), "baseline_fit: found 'velocity'; expected one of record, integral"),
    ],
)
def test_other_words_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        baseline(TIMES, VALUES, *arguments)


def test_one_sample_has_no_baseline():
    with pytest.raises(InputError, match="a record without a duration"):
        baseline(np.array([1.0]), np.array([2.0]))
