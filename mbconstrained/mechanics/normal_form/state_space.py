"""The matrices of a state-space system, checked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...checks import counted, real_array
from ...errors import InputError, NoNormalForm, SingularPolynomialMatrix
from ...linalg.noise import Noisy
from ...linalg.rank import compress_rows, null_columns
from ...polynomial.matrix import PolynomialMatrix


@dataclass(frozen=True)
class StateSpaceData:
    """F x' = A x + B u, y = C x + D u as it was given.

    Attributes:
        A, B: shape (n, n) and (n, p).
        C, D: shape (m, n) and (m, p); None where no outputs are given.
        F: shape (n, n); None for the identity.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray | None = None
    D: np.ndarray | None = None
    F: np.ndarray | None = None


def state_space_data(A, B, C, D, descriptor) -> StateSpaceData:
    """Check the matrices at the door.

    Raises:
        InputError: shapes, n odd, p > n/2, dependent columns of B, entries that are not finite.
        NoNormalForm: a singular descriptor matrix.
    """
    A = real_array(A, "A", shape=(None, None))
    n = len(A)
    if n != A.shape[1]:
        raise InputError(f"A: expected a square matrix, found {n} x {A.shape[1]}")
    if n % 2 or not n:
        found = f"found {counted(n, 'state')}" if n else "found no states"
        raise InputError(
            f"A: {found}; a mechanical system has an even number of them, a displacement and a velocity for each coordinate"
        )
    B = _inputs(B, n)
    C, D = _outputs(C, D, n, B.shape[1])
    F = None
    if descriptor is not None:
        F = real_array(descriptor, "descriptor", shape=(n, n))
        _check_regular(F, A)
    return StateSpaceData(A, B, C, D, F)


def _inputs(B, n) -> np.ndarray:
    B = real_array(np.zeros((n, 0)) if B is None else B, "B")
    B = B[:, None] if B.ndim == 1 else B
    if B.ndim != 2 or len(B) != n:
        raise InputError(f"B: expected shape {n} x p, one row for each of the {n} states, found {' x '.join(map(str, B.shape))}")
    if 2 * B.shape[1] > n:
        raise InputError(
            f"B: found {counted(B.shape[1], 'input')} for {n} states; a mechanical system of {counted(n // 2, 'coordinate')} takes "
            f"at most {n // 2} independent forces: leave inputs out, or combine them"
        )
    found = null_columns(Noisy.rounded(B))
    if found.decision.rank < B.shape[1]:
        raise InputError(f"B: {_dependence(found.null.data[0])}; the inputs must be independent: leave one out, or combine them")
    return B


def _dependence(combination) -> str:
    involved = [str(place + 1) for place in np.flatnonzero(combination)]
    if len(involved) == 1:
        return f"column {involved[0]} is zero"
    return f"columns {', '.join(involved[:-1])} and {involved[-1]} depend on each other"


def _outputs(C, D, n, p):
    if C is None:
        if D is not None:
            raise InputError("D: found a feedthrough without outputs; give C as well")
        return None, None
    C = np.atleast_2d(real_array(C, "C"))
    if C.ndim != 2 or C.shape[1] != n:
        raise InputError(f"C: expected shape m x {n}, one column for each of the {n} states, found {' x '.join(map(str, C.shape))}")
    shape = (len(C), p)
    return C, np.zeros(shape) if D is None else real_array(D, "D", shape=shape)


def _check_regular(F, A) -> None:
    """F must have full rank: what its null space determines has no derivative."""
    rank, n = compress_rows(Noisy.rounded(F)).decision.rank, len(F)
    if rank == n:
        return
    text = f"the descriptor matrix is singular, rank {rank} of {n}: "
    try:
        infinite = sum(PolynomialMatrix([-A, F]).structure().infinite_divisors)
        text += (
            f"{infinite} of the {n} states belong to the infinite part of s F - A, they follow the inputs at once and have no "
            "motion of their own, so that no transformation of all states is mechanical; solve those equations for their states "
            "and give the system of the others, or solve the descriptor system as it is, by mb.solve"
        )
    except SingularPolynomialMatrix:
        text += "det(s F - A) is zero for every s, the equations do not determine the states; check them"
    raise NoNormalForm(text, condition="descriptor", rank=rank, needed=n)
