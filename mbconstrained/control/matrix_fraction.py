"""Responses of systems with several inputs and outputs that are given as a fraction of polynomial matrices."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from fractions import Fraction
from functools import lru_cache

import numpy as np

from ..ground.checks import counted, real_array
from ..ground.errors import InputError
from ..ground.tolerances import EPS
from ..polynomial.coefficients import Factors
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.problem import FORCE_FUNCTIONS
from ..response.response import Response
from ..response.solve import solve
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import power, zero
from .rational import Polynomial


def matrix_fraction_response(numerator, denominator, input: ImpulsiveSmooth) -> Response:
    """Solve D(d/dt) y = N(d/dt) u from rest, transfer matrix D(s)^-1 N(s), by the Jordan pairs of D(s).

    D and N may have any degrees and common left factors, the leading coefficient of D may be singular: poles of
    D(s)^-1 N(s) at infinity are Dirac impulses. A common left factor with zeros in the right half plane is not
    removed, as that of a scalar transfer function is: its rounding error grows, which ``error_estimate`` reports.

    Args:
        numerator: N_0, N_1, ..., ascending powers, each of shape (r, p).
        denominator: D_0, D_1, ..., ascending powers, each of shape (r, r); or a ``PolynomialMatrix``.
        input: u with p rows, see ``mbconstrained.signals``.

    Returns:
        y, r rows.

    Raises:
        InputError: shapes that do not fit, values that are not finite, an input that is none.
        SingularPolynomialMatrix: det D(s) = 0 for every s.

    >>> from mbconstrained import step
    >>> y = matrix_fraction_response([[[1.0], [4.0]]], [np.diag([1.0, 2.0]), np.eye(2)], step([1.0]))
    >>> bool(np.allclose(y(1.0), [1 - np.exp(-1), 2 - 2 * np.exp(-2)]))  # 1 / (s + 1) and 4 / (s + 2)
    True
    """
    D = denominator if isinstance(denominator, PolynomialMatrix) else PolynomialMatrix(denominator)
    N = _checked_numerator(numerator, D.size)
    return solve(D, force=operated(N, checked_input(input, N[0].shape[1], "input")))


def _checked_numerator(numerator, rows: int) -> list[np.ndarray]:
    if not isinstance(numerator, Iterable):
        raise InputError(f"numerator: found {numerator!r}; expected a list of matrices [N_0, N_1, ...]")
    matrices = [real_array(matrix, f"N_{index}", shape=(rows, None)) for index, matrix in enumerate(numerator)]
    if not matrices:
        raise InputError("numerator: it needs at least one coefficient, N_0; none was given")
    for index, N in enumerate(matrices):
        if N.shape != matrices[0].shape:
            raise InputError(f"N_{index} has shape {N.shape}, but N_0 has {matrices[0].shape}; all must agree")
    return matrices


# Transfer functions as problems of ``mb.solve``: a(s) as a polynomial matrix of size one, b(d/dt) u as its force.

#: Up to this order a(s) is decoupled with more digits than float64: it takes some tenths of a second at most.
PRECISE_ORDER = 24

#: So many float64 numbers, each what the ones before it leave, add up to an exact coefficient, to 1e-64 of it.
PARTS = 4


@lru_cache(maxsize=64)
def scalar_matrix(denominator: Polynomial, rounded: bool = True) -> PolynomialMatrix:
    """a(s), exact where its order allows, computed once for all inputs, with its zeros."""
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
    """The excitation b(d/dt) u of one equation."""
    if isinstance(u, ImpulsiveSmooth):
        return operated([np.array([[float(b)]]) for b in numerator] or [np.zeros((1, 1))], u)
    return sum((power([float(b)], u - k) for k, b in enumerate(numerator) if b), zero(1))


def operated(matrices: Sequence[np.ndarray], u: ImpulsiveSmooth) -> ImpulsiveSmooth:
    """N_0 u + N_1 u' + ..., the derivatives in the sense of distributions."""
    total = zero(len(matrices[0]))
    for index, N in enumerate(matrices):
        u = u.distribution_derivative() if index else u
        total = total + u.mapped(N) if N.any() else total
    return total


def checked_input(u, size: int, what: str) -> ImpulsiveSmooth:
    """A validated input."""
    if not isinstance(u, ImpulsiveSmooth):
        raise InputError(f"{what}: found {type(u).__name__}; make it with {FORCE_FUNCTIONS}")
    if u.size != size:
        raise InputError(f"{what}: it has {counted(u.size, 'row')}; expected {size}, one for each input")
    return u
