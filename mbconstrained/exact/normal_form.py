"""The mechanical normal form over the rationals: its verdict and its transformation without a rounding error."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random

import flint
import numpy as np

from ..ground.checks import counted
from ..ground.display import Displayed
from ..ground.errors import InputError, NoNormalForm, SingularPolynomialMatrix
from .engine import ExactJordanPairs
from .rational import RATIONALS, RationalMatrix, fraction, rational_matrix, regular

#: Largest entry of the first random extension of B; it doubles with every one.
FIRST_BOUND = 1

#: The condition on the uncontrolled motions, which is named where it fails.
EIGENVALUES = "rank [A - lambda I, B]"


@dataclass(frozen=True, repr=False, eq=False)
class ExactInfinitePart(Displayed):
    """z = N z' + B_z u, x = (finite part) + Q z, z = rows x, as ``mbconstrained.mechanics.normal_form_parts.InfinitePart``.

    Attributes:
        nilpotent, input_matrix, states, rows: N, B_z, Q and the rows of Fractions.
    """

    nilpotent: np.ndarray
    input_matrix: np.ndarray
    states: np.ndarray
    rows: np.ndarray

    def _summary(self) -> str:
        return counted(len(self.nilpotent), "state")


@dataclass(frozen=True, repr=False, eq=False)
class ExactNormalForm(Displayed):
    """The mechanical normal form with entries that are Fractions; names as in ``mbconstrained.NormalForm``."""

    # T, L and T^+, shapes (n_f, n), (n_f, n) and (n, n_f): L F = T, L A = A^ T, L B = B^
    transformation: np.ndarray
    left_transformation: np.ndarray
    inverse: np.ndarray
    # A^ = [0, I; A^_21, A^_22] and B^ = [0; R]
    state_matrix: np.ndarray
    input_matrix: np.ndarray
    output_matrix: np.ndarray | None  # C T^+; None where no outputs were given
    polynomial: tuple[np.ndarray, ...]  # the polynomial part D_0, D_1, ... of the transfer function; empty without outputs
    infinite: ExactInfinitePart | None  # the infinite part of a singular F, or None

    def _summary(self) -> str:
        text = f"{counted(len(self.state_matrix) // 2, 'coordinate')}, {counted(self.input_matrix.shape[1], 'input')}"
        return text + (f", infinite part: {self.infinite._summary()}" if self.infinite else "")


def normal_form(A, B, C=None, D=None, descriptor=None) -> ExactNormalForm:
    """The normal form of exact data, see ``mbconstrained.exact.mechanical_normal_form``."""
    A = _exact(A, "A", (None, None))
    n = len(A)
    if not n or A.shape[1] != n:
        raise InputError(f"A: expected a square matrix with at least one state, found {n} x {A.shape[1]}")
    B = np.zeros((n, 0), dtype=object) if B is None else _exact(B, "B", (n, None))
    if _rank(B) < B.shape[1]:
        raise InputError("B: the inputs must be independent: leave one out, or combine them")
    if C is None and D is not None:
        raise InputError("D: found a feedthrough without outputs; give C as well")
    if C is not None:
        C = _exact(C, "C", (None, n))
        D = _zero(len(C), B.shape[1]) if D is None else _exact(D, "D", (len(C), B.shape[1]))
    F = _identity(n) if descriptor is None else _exact(descriptor, "descriptor", (n, n))
    V, P, infinite = _parts(A, B, F)
    J, own = P @ A @ V, P @ B
    R, pivots = _reduced_rows(own)
    part = "" if infinite is None else f" of the finite part, x' = A x + B u with {len(J)} of {n} states"
    T, state = _transformation(J, own[:, pivots], part)
    inverse = V @ _inverse(T)
    polynomial = () if C is None else _polynomial_part(C, D, infinite)
    inputs = np.vstack([_zero(len(T) - len(R), B.shape[1]), R])
    outputs = None if C is None else C @ inverse
    return ExactNormalForm(T @ P @ F, T @ P, inverse, state, inputs, outputs, polynomial, infinite)


def _parts(A, B, F) -> tuple[np.ndarray, np.ndarray, ExactInfinitePart | None]:
    """V, P and the infinite part, with x = V x_f + Q z, x_f = P F x; V is the identity in chosen rows."""
    n = len(A)
    if _rank(F) == n:
        if n % 2:
            raise InputError(f"A: found {counted(n, 'state')}; a mechanical system has an even number of them")
        return _identity(n), _inverse(F), None
    try:
        names = [f"row {i + 1}" for i in range(n)], [f"x{i + 1}" for i in range(n)]
        pairs = ExactJordanPairs(regular(RationalMatrix([-A, F]), *names))
    except SingularPolynomialMatrix as problem:
        text = f"no mechanical normal form, A(s) = s F - A: {problem}"
        raise NoNormalForm(text, condition="descriptor", rank=_rank(F), needed=n) from None
    finite, fast = pairs.finite, pairs.infinite
    count_finite = finite.J.shape[0]
    if count_finite % 2:
        text = f"no mechanical normal form: the finite part of s F - A has {count_finite} of the {n} states, an odd number"
        raise NoNormalForm(text, condition="descriptor", rank=count_finite, needed=count_finite + 1)
    chosen = _reduced_rows(finite.C.T)[1]
    basis = finite.C[chosen]
    return finite.C @ _inverse(basis), basis @ finite.B, ExactInfinitePart(fast.J, fast.B @ B, fast.C, -fast.B @ A)


def _transformation(J, B, part: str) -> tuple[np.ndarray, np.ndarray]:
    """T = [X; X J] with X B = 0 and X J B = [0; I], and A^ = T J T^-1, for independent columns B."""
    (n, p), half = B.shape, len(B) // 2
    both = np.hstack([B, J @ B])
    if (rank := _rank(both)) < 2 * p:
        raise NoNormalForm(
            f"no mechanical normal form{part}: rank [B, A B] = {rank}, but 2 p = {2 * p} is needed",
            condition="rank [B, A B]",
            rank=rank,
            needed=2 * p,
        )
    if 2 * p < n:  # the multiplicity of other real eigenvalues than rational ones is that of their conjugates, and too small
        for factor, _ in RATIONALS.factors(rational_matrix(J).charpoly()):
            if factor.degree() > 1:
                continue
            root = fraction(-factor[0])
            rank = _rank(np.hstack([J - root * _identity(n), B]))
            if rank < half + p:
                raise NoNormalForm(
                    f"no mechanical normal form{part}: {EIGENVALUES} = {rank} at the eigenvalue lambda = {root}, but at least "
                    f"n/2 + p = {half + p} is needed",
                    condition=EIGENVALUES,
                    rank=rank,
                    needed=half + p,
                    eigenvalue=float(root),
                )
    random = Random(n)
    bound = FIRST_BOUND
    while True:
        new = np.array([random.randint(-bound, bound) for _ in range(n * (half - p))], dtype=object).reshape(n, half - p)
        extended = np.hstack([new, B])
        square = np.hstack([extended, J @ extended])
        if _rank(square) == n:
            X = _inverse(square)[half:]
            T = np.vstack([X, X @ J])
            return T, T @ J @ _inverse(T)
        bound *= 2


def _polynomial_part(C, D, infinite: ExactInfinitePart | None) -> tuple[np.ndarray, ...]:
    if infinite is None:
        return (D,)
    terms, value = [], infinite.input_matrix
    for _ in range(len(infinite.nilpotent)):
        terms.append(C @ infinite.states @ value)
        value = infinite.nilpotent @ value
    while len(terms) > 1 and not terms[-1].any():
        terms.pop()
    return (D + terms[0], *terms[1:])


def _exact(value, what: str, shape: tuple) -> np.ndarray:
    """The exact numbers of a matrix as Fractions."""
    array = np.array(value, dtype=object)
    if array.ndim == 1 and what in "BC":  # a single input, a single output
        array = array[:, None] if what == "B" else array[None, :]
    if array.ndim != 2 or any(size not in (None, own) for size, own in zip(shape, array.shape)):
        expected = " x ".join("any" if size is None else str(size) for size in shape)
        raise InputError(f"{what}: expected shape {expected}, found {' x '.join(map(str, array.shape)) or 'a single number'}")
    try:
        return _array(rational_matrix(array))
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what}: expected finite rational numbers: ints, floats or Fractions") from None


def _array(matrix: flint.fmpq_mat) -> np.ndarray:
    return RATIONALS.matrix(matrix.table()).reshape(matrix.nrows(), matrix.ncols())


def _rank(array: np.ndarray) -> int:
    return rational_matrix(array).rank()


def _inverse(array: np.ndarray) -> np.ndarray:
    return _array(rational_matrix(array).inv())


def _reduced_rows(array: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """The nonzero rows of the reduced row echelon form, and its pivot columns."""
    form, rank = rational_matrix(array).rref()
    rows = _array(form)[:rank]
    return rows, [int(np.flatnonzero(row)[0]) for row in rows]


def _zero(rows: int, columns: int) -> np.ndarray:
    return _array(flint.fmpq_mat(rows, columns))


def _identity(n: int) -> np.ndarray:
    return _array(rational_matrix(np.eye(n, dtype=int)))
