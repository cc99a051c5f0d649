"""Closed forms of b(z)/a(z) from rest against exact recursions and scipy.signal."""

from fractions import Fraction
from math import comb

import numpy as np
import pytest
import scipy.signal

import mbconstrained as mb
from mbconstrained.ground.notices import NoticeKind


def basic_input(gamma: int, k: int) -> int:
    if k < 0:
        return 0
    return comb(k, gamma - 1) if gamma > 0 else (-1) ** k * comb(-gamma, k)


def recursion(b, a, u, first: int, last: int) -> dict[int, Fraction]:
    """y of a(sigma) y = b(sigma) u, highest power first, from rest before ``first``."""
    n, m = len(a) - 1, len(b) - 1
    y: dict[int, Fraction] = {}
    for k in range(first, last + 1):  # the equation at k - n gives y_k
        total = sum((Fraction(c) * u(k - n + m - j) for j, c in enumerate(b)), Fraction(0))
        total -= sum((Fraction(c) * y.get(k - j, 0) for j, c in enumerate(a) if j), Fraction(0))
        y[k] = total / Fraction(a[0])
    return y


@pytest.mark.parametrize("gamma", [-3, -1, 0, 1, 2, 4])
def test_random_transfer_functions_of_any_degrees_agree_with_the_exact_recursion(gamma):
    random = np.random.default_rng(gamma + 10)
    for _ in range(12):
        a = [float(x) for x in random.integers(-4, 5, random.integers(1, 5)) / 4]
        a[0] = a[0] or 1.0
        b = [float(x) for x in random.integers(-4, 5, random.integers(1, 6)) / 2]
        b[0] = b[0] or 1.0
        y = mb.discrete_transfer_function_response(b, a, gamma)
        truth = recursion(b, a, lambda k: basic_input(gamma, k), -8, 25)
        for k in (0, 1, 2, 5, 25):
            assert abs(y(k)[0] - truth[k]) <= 1e-14 * abs(truth[k]), (a, b, k)
        for place, value in enumerate(y.before):
            assert abs(value - truth[-1 - place]) <= 1e-14 * abs(truth[-1 - place])


def test_a_repeated_pole_agrees_with_scipy():
    b, a = [1.0, 0.2], np.poly([0.9, 0.9, 0.9, 0.3 + 0.4j, 0.3 - 0.4j]).real
    k = np.arange(50)
    y = mb.discrete_transfer_function_response(b, a, 1)
    _, (reference,) = scipy.signal.dstep((b, a, 1.0), n=50)
    assert np.allclose(y(k)[0], reference[:, 0], rtol=1e-9, atol=1e-12)


def test_other_inputs_and_the_terms_of_the_closed_form():
    u = np.random.default_rng(2).standard_normal(20)
    y = mb.discrete_transfer_function_response([1.0, 0.5], [1.0, -0.2, 0.5], u)
    _, reference = scipy.signal.dlsim(([1.0, 0.5], [1.0, -0.2, 0.5], 1.0), u)
    assert np.allclose(y(np.arange(20))[0], reference[:, 0], rtol=1e-13)
    z = mb.discrete_transfer_function_response([1.0, 0.5], [1.0, -0.2, 0.5], mb.geometric(1.0, -0.5))
    k = np.arange(30)
    total = sum(np.real(term.vector[0] * term.pole ** (k - term.order)) for term in z.terms)
    assert np.allclose(z(k)[0], total, rtol=1e-13)


def test_a_common_factor_outside_the_circle_does_not_act():
    y = mb.discrete_transfer_function_response([1.0, -1.1], [1.0, -1.4, 0.33])
    assert np.allclose(y(10**4), 1 / 0.7)
    assert any(notice.kind == NoticeKind.OMITTED for notice in y.notices)


def test_growth_is_reported_and_a_million_samples_are_no_matter():
    y = mb.discrete_transfer_function_response([1.0], [1.0, -(1 + 2.0**-20)], 1)
    assert any(notice.kind == NoticeKind.UNSTABLE for notice in y.notices)
    assert np.isclose(y(10**6)[0], 2.0**20 * np.expm1(1e6 * np.log1p(2.0**-20)), rtol=1e-14)


@pytest.mark.parametrize(
    ("b", "a", "gamma"),
    [([], [1.0], 1), ([1.0], [0.0], 1), ([np.nan], [1.0], 1), ([1.0], [1.0], True), ([1.0], [1.0, 2.0], "ramp")],
)
def test_bad_input_is_refused(b, a, gamma):
    with pytest.raises(mb.InputError):
        mb.discrete_transfer_function_response(b, a, gamma)
