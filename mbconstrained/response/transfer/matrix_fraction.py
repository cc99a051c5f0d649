"""Responses of systems with several inputs and outputs that are given as a fraction of polynomial matrices."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ...checks import real_array
from ...errors import InputError
from ...polynomial.matrix import PolynomialMatrix
from ...signals.impulsive import ImpulsiveSmooth
from ..response import Response
from ..solve import solve
from .engine import checked_input, operated


def matrix_fraction_response(denominator, numerator, input: ImpulsiveSmooth) -> Response:
    """y with D(d/dt) y = N(d/dt) u from rest, transfer matrix D(s)^-1 N(s), through the Jordan pairs of D(s).

    D and N may have any degrees and common left factors, the leading coefficient of D may be singular: poles of
    D(s)^-1 N(s) at infinity are Dirac impulses. A common left factor with zeros in the right half plane is not found and
    left out, as that of a scalar transfer function is: its rounding grows, which ``error_estimate`` tells.

    Args:
        denominator: D_0, D_1, ..., ascending powers, each of shape (r, r); or a ``PolynomialMatrix``.
        numerator: N_0, N_1, ..., ascending powers, each of shape (r, p).
        input: u with p rows, see ``mbconstrained.signals``.

    Raises:
        InputError: shapes that do not fit, values that are not finite, an input that is none.
        SingularPolynomialMatrix: det D(s) = 0 for every s.

    >>> from ...signals.inputs import step
    >>> y = matrix_fraction_response([np.diag([1.0, 2.0]), np.eye(2)], [[[1.0], [4.0]]], step([1.0]))
    >>> bool(np.allclose(y(1.0), [1 - np.exp(-1), 2 - 2 * np.exp(-2)]))  # 1 / (s + 1) and 4 / (s + 2)
    True
    """
    D = denominator if isinstance(denominator, PolynomialMatrix) else PolynomialMatrix(denominator)
    N = _checked_numerator(numerator, D.size)
    return solve(D, force=operated(N, checked_input(input, N[0].shape[1], "input")))


def _checked_numerator(numerator, rows: int) -> list[np.ndarray]:
    if not isinstance(numerator, Iterable):
        raise InputError(f"numerator: found {numerator!r}; expected a list of matrices [N_0, N_1, ...]")
    matrices = [real_array(matrix, f"N_{power}", shape=(rows, None)) for power, matrix in enumerate(numerator)]
    if not matrices:
        raise InputError("numerator: it needs at least one coefficient, N_0; none was given")
    for power, N in enumerate(matrices):
        if N.shape != matrices[0].shape:
            raise InputError(f"N_{power} has shape {N.shape}, but N_0 has {matrices[0].shape}; all must agree")
    return matrices
