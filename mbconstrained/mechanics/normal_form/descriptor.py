"""The matrices of a state-space system, checked."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse.csgraph import connected_components

from ...ground.checks import counted, real_array
from ...ground.errors import InputError, NoNormalForm, SingularPolynomialMatrix
from ...ground.tolerances import EPS, NOISE_SAFETY, ROUNDED_COUPLING
from ...linalg.rank import Noisy, compress_rows, null_columns
from ...linalg.scaling import joint_scaling
from ...polynomial.polynomial_matrix import PolynomialMatrix


@dataclass(frozen=True, eq=False)
class StateSpaceData:
    """F x' = A x + B u, y = C x + D u as given.

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
    """Validate the matrices."""
    A = real_array(A, "A", shape=(None, None))
    n = len(A)
    if n != A.shape[1]:
        raise InputError(f"A: expected a square matrix, found {n} x {A.shape[1]}")
    if n % 2 or not n:
        states = f"found {counted(n, 'state')}" if n else "found no states"
        raise InputError(
            f"A: {states}; a mechanical system has an even number of them, a displacement and a velocity for each coordinate"
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
    columns = null_columns(Noisy.rounded(B))
    if columns.decision.rank < B.shape[1]:
        raise InputError(f"B: {_dependence(columns.null.data[0])}; the inputs must be independent: leave one out, or combine them")
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
    """Check that F has full rank: equations of its null space have no derivative."""
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


# The pencil s F - A with its inputs B scaled: equations, states, inputs and time by powers of two. A change of units changes the
# data by such factors, so they follow from a rule that is invariant under it. Without
# a descriptor matrix F, A is transformed by similarity: the least-squares fit of log2|a_ij| - d_i + d_j - t and
# log2|b_ij| - d_i + c_j to zero over all nonzero entries. With one, equations and states are scaled separately, jointly for A and F.


@dataclass(frozen=True, eq=False)
class ScaledPencil:
    """A_s = e A d, F_s = rate e F d, B_s = e B c: with x = d x_s, u = c u_s and t = t_s / rate the same equations.

    Attributes:
        A, F, B: the scaled matrices, entries known to a unit in the last place; an identity F is known exactly.
        through: F_s^-1 B_s, shape (n, p), and ``input_space``, a basis W_1 of the same space, orthonormal where there is an F:
            that space, the states that the inputs act on, is known far better than F^-1 where F is ill-conditioned.
        input_space_noise: its uncertainty, as an angle.
        equation, state, input, rate: e and d, shape (n,), c, shape (p,), and rate: powers of two.
        explicit: True where F is the identity.
        dropped: the number of entries of A and B that count as rounding errors and are zero here.
        weak: shape (n, n), True for small entries of A on no cycle: units could make them of any size, so that they cannot be distinguished from rounding errors.
        known: uncertainty of A and F, relative to their size.
    """

    A: np.ndarray
    F: np.ndarray
    B: np.ndarray
    through: np.ndarray
    input_space: np.ndarray
    input_space_noise: float
    equation: np.ndarray
    state: np.ndarray
    input: np.ndarray
    rate: float
    explicit: bool
    dropped: int
    weak: np.ndarray
    known: float = EPS

    @property
    def solved(self) -> ScaledPencil:
        """The pencil with its equations solved for F x': more accurate where F makes equations nearly dependent."""
        inverse = np.linalg.inv(self.F)
        A, F, B = (inverse @ matrix for matrix in (self.A, self.F, self.B))
        loss = [
            np.linalg.norm(np.abs(inverse) @ np.abs(one)) / (np.linalg.norm(other) or 1.0)
            for one, other in ((self.A, A), (self.F, F))
        ]
        known = EPS * float(max(1.0, *loss))
        B = B / np.linalg.norm(B, axis=0)
        input_space, noise = _input_space(F, B, known)
        return replace(self, A=A, F=F, B=B, input_space=input_space, input_space_noise=noise, known=known)

    @property
    def without_weak(self) -> ScaledPencil:
        """The pencil with the weak entries set to zero."""
        return replace(self, A=np.where(self.weak, 0.0, self.A), weak=np.zeros_like(self.weak))


def scaled_pencil(data: StateSpaceData) -> ScaledPencil:
    """Choose the units; without F, set entries to zero that are rounding errors relative to others of their row and column."""
    return _explicit(data.A, data.B) if data.F is None else _descriptor(data.A, data.B, data.F)


def _explicit(A, B) -> ScaledPencil:
    kept_A, kept_B = _without_rounding(A, B)
    state, inputs, rate = _fitted(kept_A, kept_B)
    equation = 1 / (state * rate)
    scaled_B = equation[:, None] * kept_B * inputs
    dropped = int((kept_A != A).sum() + (kept_B != B).sum())
    scaled_A = equation[:, None] * kept_A * state
    return ScaledPencil(
        scaled_A, np.eye(len(A)), scaled_B, scaled_B, scaled_B, EPS, equation, state, inputs, rate, True, dropped, _weak(kept_A)
    )


def _descriptor(A, B, F) -> ScaledPencil:
    scaling = joint_scaling(np.array([A, F]))
    scaled_A, scaled_F = scaling.apply(np.array([A, F]))
    scaled_B = scaling.rows[:, None] * B
    inputs = np.exp2(-np.round(np.log2(np.linalg.norm(scaled_B, axis=0))))
    scaled_B = scaled_B * inputs
    input_space, noise = _input_space(scaled_F, scaled_B)
    through = np.linalg.solve(scaled_F, scaled_B)
    units = scaling.rows, scaling.columns, inputs, scaling.time
    return ScaledPencil(scaled_A, scaled_F, scaled_B, through, input_space, noise, *units, False, 0, np.zeros(A.shape, dtype=bool))


def _input_space(F, B, known: float = EPS) -> tuple[np.ndarray, float]:
    """An orthonormal basis of the states w with F w in the span of B, and its accuracy."""
    n, p = B.shape
    if not p:
        return B, 0.0
    U, lengths, _ = np.linalg.svd(B)
    _, values, rows = np.linalg.svd(U[:, p:].T @ F)
    return rows[n - p :].T, float(known * (lengths[0] / lengths[-1]) * np.linalg.norm(F) / values[-1])


def _weak(A) -> np.ndarray:
    size = np.abs(A)
    small = size <= ROUNDED_COUPLING * np.minimum(size.max(axis=1, keepdims=True), size.max(axis=0))
    return (size > 0) & small & _on_no_cycle(A)


def _without_rounding(A, B):
    """Matrices with entries set to zero that are rounding errors of their row and column in both the given and the fitted units.

    What is on no cycle of A the fit would bring near 1 whatever it is: there the given units decide alone.
    """
    n, (state, inputs, _) = len(A), _fitted(A, B)
    both, units = np.hstack([A, B]), np.concatenate([state, inputs])
    on_no_cycle = np.hstack([_on_no_cycle(A), np.zeros(B.shape, dtype=bool)])
    drop = _is_rounding(both) & (_is_rounding(both * units / state[:, None]) | on_no_cycle)
    kept = np.where(drop, 0.0, both)
    return kept[:, :n], kept[:, n:]


def _is_rounding(both) -> np.ndarray:
    size = np.abs(both)
    rows, columns = size.max(axis=1, keepdims=True), size.max(axis=0)
    return size <= NOISE_SAFETY * EPS * np.minimum(rows, columns)


def _on_no_cycle(A) -> np.ndarray:
    """Which entries couple parts of A in one direction only."""
    part = connected_components(A != 0, directed=True, connection="strong")[1]
    return part[:, None] != part


def _fitted(A, B):
    """Powers of two (d, c, rate): the minimum-norm least-squares exponents by the normal equations."""
    n, p = B.shape
    both = np.hstack([A, B])
    i, j = np.nonzero(both)
    of_A = (j < n).astype(float)
    size = n + p + 1
    normal, right, logs = np.zeros((size, size)), np.zeros(size), np.log2(np.abs(both[i, j]))
    places, weights = np.stack([i, j, np.full(len(i), n + p)]), np.stack([np.ones(len(i)), -np.ones(len(i)), of_A])
    for a in range(3):
        np.add.at(right, places[a], weights[a] * logs)
        for b in range(3):
            np.add.at(normal, (places[a], places[b]), weights[a] * weights[b])
    fit = np.exp2(np.round(np.linalg.lstsq(normal, right, rcond=None)[0]))
    return fit[:n], fit[n : n + p], float(fit[-1])
