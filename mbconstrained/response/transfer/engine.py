"""Transfer functions as the engine takes them: a(s) as a polynomial matrix of size one, b(d/dt) u as its force."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache

import numpy as np

from ...checks import counted
from ...errors import InputError
from ...polynomial.factors import Factors
from ...polynomial.matrix import PolynomialMatrix
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import power, zero
from ...tolerances import EPS
from ..solve import MAKERS
from .polynomials import Polynomial

#: Up to this order a(s) is decoupled with more digits than float64: it takes some tenths of a second at most.
PRECISE_ORDER = 24

#: So many float64 numbers, each what the ones before it leave, add up to an exact coefficient, to 1e-64 of it.
PARTS = 4


@lru_cache(maxsize=64)
def scalar_matrix(denominator: Polynomial, rounded: bool = True) -> PolynomialMatrix:
    """a(s), exactly where its order allows, and once for all inputs: its zeros are found only once, too.

    Args:
        denominator: a, lowest power first.
        rounded: whether what is no larger than a rounding of the coefficients counts as zero all the same: poles that close
            are then one.
    """
    values = np.array([float(c) for c in denominator])[:, None, None]
    exact = len(denominator) - 1 <= PRECISE_ORDER
    coefficients = [_exactly(c) for c in denominator] if exact else values
    return PolynomialMatrix(coefficients, ["y"], ["a(d/dt) y = b(d/dt) u"], EPS * np.abs(values) if rounded else None)


def _exactly(coefficient: Fraction) -> Factors:
    parts = []
    while coefficient and len(parts) < PARTS:
        parts.append(float(coefficient))
        coefficient -= Fraction(parts[-1])
    return Factors(np.ones((1, len(parts))), np.array(parts), np.ones((len(parts), 1)))


def scalar_force(numerator: Polynomial, u: int | ImpulsiveSmooth) -> ImpulsiveSmooth:
    """b(d/dt) u for I_gamma or an input with one row."""
    if isinstance(u, ImpulsiveSmooth):
        return operated([np.array([[float(b)]]) for b in numerator] or [np.zeros((1, 1))], u)
    return sum((power([float(b)], u - k) for k, b in enumerate(numerator) if b), zero(1))


def operated(matrices: Sequence[np.ndarray], u: ImpulsiveSmooth) -> ImpulsiveSmooth:
    """N_0 u + N_1 u' + ..., the derivatives in the sense of distributions, matrices of shape (r, p), at least one."""
    total = zero(len(matrices[0]))
    for index, N in enumerate(matrices):
        u = u.distribution_derivative() if index else u
        total = total + u.mapped(N) if N.any() else total
    return total


def checked_input(u, size: int, what: str) -> ImpulsiveSmooth:
    """An input with so many rows, or an InputError."""
    if not isinstance(u, ImpulsiveSmooth):
        raise InputError(f"{what}: found {type(u).__name__}; make it with {MAKERS}")
    if u.size != size:
        raise InputError(f"{what}: it has {counted(u.size, 'row')}; expected {size}, one for each input")
    return u
