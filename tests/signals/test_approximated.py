"""Functions known by their values: reached to the tolerance, kinks and jumps found, and refused where they cannot be."""

import math

import numpy as np
import pytest
from numpy.polynomial import chebyshev

import mbconstrained as mb
from mbconstrained.signals.approximated import DEGREE, NODES, TO_CHEBYSHEV, TO_POWERS, TO_POWERS_AT_END

TIMES = np.random.default_rng(0).uniform(0, 10, 20_000)
FUNCTIONS = {
    "polynomial": lambda t: 1 - t + t**3,
    "harmonic": lambda t: np.sin(7 * t),
    "two rows": lambda t: np.array([np.exp(-t), np.cos(t) ** 2]),
    "narrow": lambda t: np.exp(-((t - 3) ** 2) / 2e-4),
    "steep": lambda t: np.tanh(200 * (t - 3)),
    "kinks": lambda t: np.abs(np.sin(3 * t)),
    "a jump": lambda t: np.where(t < 1 / 3, 1.0, 2.0) * np.cos(t),
    "a jump in the middle": lambda t: np.where(t < 5.0, 1.0, 2.0) * np.cos(t),
    "a jump of the curvature": lambda t: np.maximum(t - math.pi, 0.0) ** 2,
    "many jumps": lambda t: np.sign(np.sin(20 * t)),
    "saw": lambda t: 1.3 * t % 1,
    "nothing": lambda t: 0 * t,
    "huge": lambda t: 1e250 * np.sin(t),
    "tiny": lambda t: 1e-250 * np.sin(t),
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_function_is_reached_to_the_tolerance(name):
    f = mb.approximated(FUNCTIONS[name], 10.0)
    known = np.atleast_2d(FUNCTIONS[name](TIMES))
    assert f(TIMES).shape == known.shape
    assert np.abs(f(TIMES) - known).max() <= 2e-12 * np.abs(known).max()
    assert f.error <= 1e-12 and f.points > 0
    assert not f([10.0, 11.0, 1e6]).any()


def test_a_function_of_one_time_will_do():
    f = mb.approximated(lambda t: math.sin(t) if t < 4.4 else 0.0, 10.0)
    assert f([1.0, 5.0])[0] == pytest.approx([math.sin(1.0), 0.0], abs=1e-12)
    g = mb.approximated(lambda t: [math.sin(t), 2.0], 10.0)
    assert g(1.0) == pytest.approx([math.sin(1.0), 2.0], abs=1e-12)


@pytest.mark.parametrize(
    ("name", "orders", "places"),
    [
        ("kinks", (1,), np.arange(1, 10) * np.pi / 3),
        ("a jump", (0,), [1 / 3]),
        ("a jump in the middle", (0,), [5.0]),
        ("a jump of the curvature", (2,), [math.pi]),
        ("harmonic", (0, 1, 2), []),
    ],
)
def test_kinks_and_jumps_are_located_and_nothing_else(name, orders, places):
    """Within the interval; at its ends the input itself begins and stops."""
    restarts = mb.approximated(FUNCTIONS[name], 10.0).smooth.restarts
    at = restarts.knots[restarts.jumps[list(orders)].any(axis=0)]
    assert at[(at > 0) & (at < 10)] == pytest.approx(np.array(places), abs=1e-11)


def test_the_response_is_that_to_the_closed_form():
    wave = mb.harmonic([1.0], angular_frequency=7.0)
    exact = wave - mb.harmonic([1.0], angular_frequency=7.0, phase=70.0).delayed(10.0)
    f = mb.approximated(lambda t: np.cos(7 * t), 10.0)
    t = np.linspace(0, 20, 301)
    for coefficients in ([0, 0, 1], [4, 0.1, 1], [1e-6, 1e-4, 1], [49, 0, 1], [1e6, 1e6, 1], [1, 1], [1]):
        A = mb.PolynomialMatrix([[[float(c)]] for c in coefficients])
        known = mb.solve(A, force=exact)(t)
        assert np.abs(mb.solve(A, force=f)(t) - known).max() <= 1e-11 * np.abs(known).max()


def test_the_notice_reports_values_and_pieces():
    f = mb.approximated(lambda t: np.array([np.sin(t)]), 3.0)
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[1.0]]]), force=2 * f.delayed(1.0) + mb.step([1.0]))
    (notice,) = [notice for notice in x.notices if notice.kind == "accuracy"]
    assert f"{f.pieces} polynomials from {f.points} values" in notice.text and "may lie between them" in notice.text
    assert not notice.doubtful


@pytest.mark.parametrize(
    ("function", "keys", "text"),
    [
        (np.sqrt, {}, "near t = 0 s 16384 polynomials follow it only to"),
        (lambda t: np.sin(1e9 * t), {}, "too rough to be followed"),
        (lambda t: np.where(t > 3.0, np.nan, t), {}, r"not finite at t = 3\."),
        (np.sin, {"tolerance": 1e-17}, "tolerance: found 1e-17; rounding allows at least"),
        (np.sin, {"end": -1.0}, "end: found -1"),
    ],
)
def test_what_cannot_be_followed_is_said_with_its_place(function, keys, text):
    with pytest.raises(mb.InputError, match=text):
        mb.approximated(function, **({"end": 10.0} | keys))


def test_the_maps_between_values_and_coefficients():
    """Of a polynomial with known coefficients c_j of T_j(2 t - 1); the powers of t cancel digits, at most |maps| |c| in units of eps."""
    c = np.random.default_rng(2).normal(size=DEGREE + 1)
    values = chebyshev.chebval(2 * NODES - 1, c)
    assert TO_CHEBYSHEV @ values == pytest.approx(c, abs=1e-14)
    rounding = (DEGREE + 1) * np.finfo(float).eps * (np.abs(TO_POWERS) @ np.abs(c)).sum()
    for t in (0.0, 0.3, 1.0):
        known = chebyshev.chebval(2 * t - 1, c)
        assert (TO_POWERS @ c) @ t ** np.arange(DEGREE + 1) == pytest.approx(known, abs=rounding)
        assert (TO_POWERS_AT_END @ c) @ (t - 1) ** np.arange(DEGREE + 1) == pytest.approx(known, abs=rounding)


@pytest.mark.parametrize(
    ("function", "text"),
    [
        (5, "function: found 5; expected a function of time"),
        (None, "function: found None; expected a function of time"),
        (lambda: 1, r"its call with t = \S+ s fails with TypeError: .*; expected a number or a list of r numbers"),
        (lambda t: {}["x"], r"its call with t = \S+ s fails with KeyError: 'x'"),
        (lambda t: {1: 2}, r"found {1: 2} at t = \S+ s; expected a number or a list"),
        (lambda t: None, r"found None at t = \S+ s; expected a number or a list"),
        (lambda t: "a", r"found 'a' at t = \S+ s; expected a number or a list"),
        (lambda t: [], r"found \[\] at t = \S+ s; expected a number or a list"),
        (lambda t: [1, [2, 3]], r"found \[1, \[2, 3\]\] at t = \S+ s; expected a number or a list"),
        (lambda t: np.ones((2, 2, 2)), r"found array of shape \(2, 2, 2\) at t = \S+ s; expected a number or a list"),
        (lambda t: [1.0] * (1 + int(t > 0.5)), r"it has 2 rows at t = 0\.5\S+ s and 1 at t = \S+ s"),
        (lambda t: np.exp(1j * t), r"found the complex \S+ at t = \S+ s; expected real numbers"),
        (lambda t: 1j * float(t), r"found the complex \S+ at t = \S+ s; expected real numbers"),
        (lambda t: math.exp(1000 * t), r"it is not finite at t = 0\.70\d+ s \(math range error\)"),
        (lambda t: np.exp(2000 * t), r"it is (not finite|too large) at t = 0\.3\d+ s"),
        (lambda t: 1e300 + 0 * t, r"it is too large at t = \S+ s; expected values of a size up to"),
        (lambda t: 1 / 0, r"it is not finite at t = \S+ s \(division by zero\)"),
    ],
)
def test_what_is_no_real_function_of_time_is_refused(function, text):
    with pytest.raises(mb.InputError, match=text):
        mb.approximated(function, 1.0)


def test_a_shortest_end():
    with pytest.raises(mb.InputError, match="end: found 1e-307 s; expected at least"):
        mb.approximated(np.sin, 1e-307)
