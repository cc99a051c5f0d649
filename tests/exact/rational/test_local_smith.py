"""The parts that the exact structure is made of: root polynomials, interpolation, rounded roots."""

from __future__ import annotations

from fractions import Fraction

import flint
import mpmath
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.exact.engine import ExactMatrix
from mbconstrained.exact.rational import known_matrix, rounded_roots
from tests.exact.rational.products import MATRICES, known, product
from tests.oracles import exact


@pytest.mark.parametrize("seed", range(6))
def test_root_polynomials_of_simple_factors_are_what_elimination_gives(seed):
    """The principal part of A(s)^-1 at the zeros of every factor, by the method of every field."""
    R = known_matrix(mb.PolynomialMatrix(product(seed)))
    for p, multiplicity in R.ring.factors(R.determinant):
        ours, general = R.root_polynomials(p, multiplicity), ExactMatrix.root_polynomials(R, p, multiplicity)
        assert [term.length for term in ours] == [term.length for term in general]
        assert _principal_part(ours) == _principal_part(general)


def _principal_part(terms):
    """The sum of phi psi^T p^(K - k) modulo p^K, K the largest k."""
    if not terms:
        return []
    p, K, r = terms[-1].divisor, terms[-1].length, range(len(terms[-1].right))
    zero = flint.fmpq_poly([0])
    return [[sum((t.right[i] * t.left[j] * p ** (K - t.length) for t in terms), zero) % p**K for j in r] for i in r]


@pytest.mark.parametrize("name", MATRICES)
def test_interpolation_gives_the_determinant_and_the_adjugate(name):
    x = known(name)
    R = known_matrix(x.matrix)
    assert _fractions(R.determinant) == exact.determinant(x.A.tolist())
    adjugate = [[exact.trimmed(entry) for entry in row] for row in exact.adjugate(x.A.tolist())]
    assert [[_fractions(entry) for entry in row] for row in R.adjugate] == adjugate


def _fractions(p) -> list[Fraction]:
    return [Fraction(int(c.p), int(c.q)) for c in p.coeffs()]


@pytest.mark.parametrize(
    "coefficients",
    [
        [-2, 0, 1],
        [1, 1, 1],
        [2, 0, 0, 1],
        [1, 0, 3, 0, 1],
        [5, 0, 2, 0, 1],
        [-3, 10**6, 1],
        [1, 10**9, 10**3, 7],
        [10**40, 1, 0, 1],
    ],
)
def test_roots_are_the_nearest_numbers(coefficients):
    """Those of mpmath with 60 digits, rounded once."""
    with mpmath.workdps(60):
        roots = mpmath.polyroots(coefficients[::-1], maxsteps=500, extraprec=400)
        cut = mpmath.mpf(10) ** -50
        parts = [
            (z.real if abs(z.real) > cut * abs(z) else mpmath.mpf(0), z.imag if abs(z.imag) > cut * abs(z) else mpmath.mpf(0))
            for z in map(mpmath.mpc, roots)
        ]
        expected = {complex(float(mpmath.nstr(re, 40)), float(mpmath.nstr(im, 40))) for re, im in parts if im >= 0}
    assert set(rounded_roots(flint.fmpz_poly(coefficients))) == expected


def test_a_root_between_two_neighbours_is_rounded_to_even():
    """(s - c)^2 + 1 and (s - c)^2 - 2 shifted to the middle c of 1 and its successor."""
    c = 1 + Fraction(1, 2**53)
    p = flint.fmpz_poly([int(x * 2**106) for x in (c * c + 1, -2 * c, 1)])
    assert rounded_roots(p) == (complex(1.0, 1.0),)


def test_roots_beyond_the_range_of_float64_are_infinite():
    assert rounded_roots(flint.fmpz_poly([10**400, 1])) == (complex(-np.inf),)
    assert set(rounded_roots(flint.fmpz_poly([-(10**801), 0, 1]))) == {complex(-np.inf), complex(np.inf)}
    assert rounded_roots(flint.fmpz_poly([1, 10**400])) == (0,)
