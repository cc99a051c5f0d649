"""H(s) = s^p C A(s)^-1 B as poles, residues and a polynomial part, from the finite and the infinite Jordan pair of A(s).

A(s)^-1 = C_F (s I - J)^-1 B_F + sum of H_k s^k (Moysis et al., Theorem 2.8) gives

    H(s) = sum over poles and j of R_j / (s - pole)^(j + 1) + sum of D_k s^k,  D_k = C H_(k - p) B.

A sum of these terms is right to some rounding errors of the largest of them: where |H| is much smaller it is no value of H any more.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from ..ground.tolerances import CLUSTER_SAFETY, EPS, NOISE_SAFETY, rounding_radius
from ..linalg.arrays import block_diag
from ..linalg.blocks import block_slices
from ..linalg.rank import Noisy
from ..polynomial.jordan_pairs import JordanPairs
from ..polynomial.structure import FiniteZero


@dataclass(frozen=True, eq=False)
class Pole:
    """A pole of H(s)."""

    value: complex  # in 1/s
    residues: np.ndarray  # R_0, R_1, ... with the terms R_j / (s - value)^(j + 1), shape (order, p, m)
    zero: FiniteZero | None  # the eigenvalue of A(s) that it is, or whose conjugate; None where residues are unknown

    @property
    def order(self) -> int:
        """The highest power of 1 / (s - value)."""
        return len(self.residues)


@dataclass(frozen=True)
class PoleOnLine:
    """A requested frequency at which H has a pole on the imaginary axis."""

    line: int  # its number
    frequency_hz: float  # in Hz
    pole: Pole  # with order and residues; entries of ``values`` are the finite part there, H without the terms of the pole


#: Terms that are summed at once: they stay near the processor, and larger arrays would be new pages of memory each time.
TERMS = 1 << 15


# H(i w) of K + C s + M s^2 with symmetric K and M > 0 as a sum over modes, for many lines of full matrices.
# The undamped modes, K phi = M phi w^2, are coordinates in which the equations are graded by their frequencies; the damped modes are
# eigenvectors in these. Their errors are relative to each frequency, not to the largest, which those of eigenvalues of A(s) itself are.


@dataclass(frozen=True, eq=False)
class ModalSum:
    """C_e (s I - diag(poles))^-1 B_e."""

    poles: np.ndarray  # shape (2 r,)
    outputs: np.ndarray  # C_e, shape (p, 2 r)
    inputs: np.ndarray  # B_e, shape (2 r, m)

    @classmethod
    def of(cls, coefficients, inputs, outputs) -> ModalSum | None:
        """The modal sum, or None where the matrices do not have that form."""
        if len(coefficients) != 3 or any((matrix != matrix.T).any() for matrix in (coefficients[0], coefficients[2])):
            return None
        K, C, M = coefficients
        try:
            squares, modes = scipy.linalg.eigh(K.real, M.real, check_finite=False)
        except np.linalg.LinAlgError:  # M is not positive definite
            return None
        w = np.sqrt(np.abs(squares))
        elastic = w[w > EPS**0.5 * w.max(initial=0.0)]
        w = np.maximum(w, elastic.min(initial=np.inf) if len(elastic) else 1.0)  # free motion in the unit of the lowest oscillation
        r, order = len(w), np.argsort(-np.repeat(w, 2), kind="stable")  # each displacement next to its velocity
        place = np.arange(2 * r).reshape(2, r).T.reshape(-1)[order]
        J = np.zeros((2 * r, 2 * r), dtype=coefficients.dtype)
        J[:r, r:], J[r:, r:] = np.diag(w), -modes.T @ C.real @ modes
        J[r:, :r] = -(np.diag(squares) + 1j * modes.T @ K.imag @ modes if np.iscomplexobj(K) else np.diag(squares)) / w
        try:
            poles, right = np.linalg.eig(J[np.ix_(place, place)])
            back = np.linalg.solve(right, np.pad(modes.T @ inputs, ((r, 0), (0, 0)))[place])
        except np.linalg.LinAlgError:  # no convergence, or a basis that is singular
            return None
        return cls(poles, np.hstack([outputs @ modes / w, np.zeros(outputs.shape)])[:, place] @ right, back)

    def values(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sum, and the scales of its errors, both of shape (p, m, S)."""
        shape = (len(self.outputs), self.inputs.shape[1], len(s))
        terms = (self.outputs[:, None] * self.inputs.T).reshape(-1, len(self.poles))
        total, scales, moduli = np.empty((len(terms), len(s)), dtype=complex), np.empty((len(terms), len(s))), np.abs(terms)
        count = max(1, TERMS // max(len(self.poles), 1))
        for begin in range(0, len(s), count):
            at = slice(begin, begin + count)
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                inverse = 1 / (s[at] - self.poles[:, None])
                size = np.abs(inverse)
                size *= 1 + np.abs(self.poles)[:, None] * size
            total[:, at], scales[:, at] = terms @ inverse, moduli @ size
        return total.reshape(shape), scales.reshape(shape)


@dataclass(frozen=True, eq=False)
class PoleResidueForm:
    """Poles, residues and polynomial part of s^p C A(s)^-1 B."""

    pairs: JordanPairs  # pairs of A(s)
    inputs: np.ndarray  # B, shape (r, m)
    outputs: np.ndarray  # C, shape (p, r), real or complex
    power: int = 0  # p

    @cached_property
    def poles(self) -> tuple[Pole, ...]:
        """The poles, ascending by modulus, conjugates next to each other; eigenvalues with zero residues are no poles."""
        result = []
        for zero in self.pairs.finite.zeros:
            one, other = self._residues(zero)
            if len(one):
                result.append(Pole(zero.value if zero.value.imag else complex(zero.value.real), one, zero))
            if zero.value.imag and len(other):
                result.append(Pole(zero.value.conjugate(), other, zero))
        return tuple(result)

    @cached_property
    def polynomial(self) -> np.ndarray:
        """D_0, D_1, ..., shape (K, p, m); none where H(s) vanishes at infinity."""
        highest = self.pairs.form.highest_impulse + self.power
        terms = [self._through(k - self.power) for k in range(highest + 1)]
        while terms and not terms[-1].any():
            terms.pop()
        shape = (len(terms), len(self.outputs), self.inputs.shape[1])
        return np.array(terms).reshape(shape) + 0.0  # no negative zeros

    def _through(self, index: int) -> np.ndarray:
        """C H_index B, zero where it is rounding error."""
        form = self.pairs.form
        scaling = form.companion.scaling
        middle = form.laurent(index) @ Noisy.exact(scaling.rows[:, None] * self.inputs)
        parts = [(Noisy.exact(C * scaling.columns) @ middle).cleaned() for C in _parts(self.outputs)]
        least = EPS**4 * middle.size.max(initial=0.0)  # a remainder of rounding errors that have cancelled
        return _joined([np.where(np.abs(part) > least, part, 0.0) for part in parts]) / scaling.time ** float(index)

    def _residues(self, zero: FiniteZero) -> tuple[np.ndarray, np.ndarray]:
        """The coefficients at a zero and at its conjugate, without those that are rounding errors."""
        pair, value = self.pairs.finite, zero.value if zero.value.imag else zero.value.real
        at, right, J, left = self.subspaces[zero]
        C = pair.C[:, at]
        C_size = _at_least(C, axis=1)
        C, C_size = C @ right, C_size @ np.abs(right)
        unknowns, rows = self._defined
        powers = [np.linalg.matrix_power(J, k) for k in range(len(rows))]
        C[unknowns] = sum(row @ C @ power for row, power in zip(rows, powers))
        C_size[unknowns] = sum(np.abs(row) @ C_size @ np.abs(power) for row, power in zip(rows, powers))
        order = max(zero.partial_multiplicities, default=1)
        front, sizes = np.linalg.matrix_power(J, self.power), []
        N, terms = J - value * np.eye(len(J)), []
        B = left @ (pair.B[at] @ self.inputs)
        B_size = np.abs(left) @ _at_least(np.abs(pair.B[at]) @ np.abs(self.inputs), axis=0)
        for _ in range(order):
            terms.append([part @ C @ front @ B for part in _parts(self.outputs)])
            sizes.append(sum(np.abs(part) @ C_size for part in _parts(self.outputs)) @ np.abs(front) @ B_size)
            front = front @ N
        noise = (
            EPS * max(pair.coupling, 1.0) * len(pair.B) ** 0.5 * max(CLUSTER_SAFETY, NOISE_SAFETY * self._sensitivity(zero, order))
        )
        limits, shape = noise * np.array(sizes), (order, len(self.outputs), self.inputs.shape[1])
        turned = [[_joined([turn(part) for part in own]) for own in terms] for turn in (np.array, np.conj)]
        one, conjugate = (_cleaned(np.array(each).reshape(shape), limits) for each in turned)
        return one, conjugate

    @cached_property
    def _defined(self) -> tuple[np.ndarray, np.ndarray]:
        """Unknowns y = R(s) x that only their own equation has, such as the force of a spring, shape (d,), and R_k, shape (K, d, r)."""
        coefficients = np.array(self.pairs.polynomial_matrix.coefficients)
        pattern = np.any(coefficients, axis=0)
        unknowns = np.flatnonzero((pattern.sum(axis=0) == 1) & ~np.any(coefficients[1:], axis=(0, 1)))
        rows = pattern[:, unknowns].argmax(axis=0)
        result = -coefficients[:, rows] / coefficients[0, rows, unknowns][:, None]
        result[:, np.arange(len(rows)), unknowns] = 0.0
        return unknowns, result

    @property
    def is_singular_at_rest(self) -> bool:
        """Whether A(0) is singular to working precision."""
        return any(zero.value == 0 for zero in self.pairs.finite.zeros)

    @cached_property
    def subspaces(self) -> dict[FiniteZero, tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """The states of the blocks that contain each eigenvalue, with its right vectors, matrix and left vectors."""
        blocks, result = self.pairs.finite.blocks, {}
        for zero in self.pairs.finite.zeros:
            chosen = np.unique(self._eigenvalues[1][self._nearest(zero)])
            at = np.concatenate([np.arange(self._slices[i].start, self._slices[i].stop) for i in chosen])
            J = blocks[chosen[0]] if len(chosen) == 1 else block_diag(*(blocks[i] for i in chosen))
            result[zero] = at, *invariant_vectors(J, zero.value, zero.multiplicity)
        return result

    def _sensitivity(self, zero: FiniteZero, order: int) -> float:
        """The growth of errors in the vectors of a chain: a power of its distance from the next zero, in the unit of time."""
        if order == 1:
            return 1.0
        others = np.delete(np.abs(self._eigenvalues[0] - zero.value), self._nearest(zero))
        with np.errstate(divide="ignore"):
            return (self.pairs.form.companion.scaling.time / others.min(initial=np.inf)) ** order

    def _nearest(self, zero: FiniteZero) -> np.ndarray:
        return np.argsort(np.abs(self._eigenvalues[0] - zero.value), kind="stable")[: zero.multiplicity]

    @cached_property
    def _slices(self) -> list[slice]:
        return block_slices(self.pairs.finite.blocks)

    @cached_property
    def _eigenvalues(self) -> tuple[np.ndarray, np.ndarray]:
        """All eigenvalues, and the indices of their blocks."""
        blocks = self.pairs.finite.blocks
        values = np.concatenate([np.linalg.eigvals(block) for block in blocks] or [np.zeros(0)])
        return values, np.repeat(np.arange(len(blocks)), [len(block) for block in blocks])

    # Values as sums.

    def values(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """s^p times the sum of all terms, and the scales of its errors, both of shape (p, m, S).

        The size of a term is what its residue is made of, next to the pole times its relative distance.
        """
        p, m = len(self.outputs), self.inputs.shape[1]
        total, size = np.zeros((p, m, len(s)), dtype=complex), np.zeros(len(s))
        form, scaling = self.pairs.form, self.pairs.form.companion.scaling
        C, B = self.outputs @ self.pairs.finite.C, self.pairs.finite.B @ self.inputs
        C_size = np.abs(self.pairs.finite.C / scaling.columns[:, None]).max(axis=0, initial=0.0)
        B_size = np.abs(self.pairs.finite.B / scaling.rows).max(axis=1, initial=0.0)
        for at, block in zip(self._slices, self.pairs.finite.blocks):
            own, inverse_size = _block_values(C[:, at], block, B[at], s)
            total += own
            spread = (C_size[at] @ np.abs(np.eye(len(block)))).max() * B_size[at].max()
            size += spread * inverse_size * (1 + np.linalg.norm(block) * inverse_size)
        polynomial = [self._term(k) for k in range(form.highest_impulse + 1)]
        for k, D in enumerate(polynomial):
            total += D[:, :, None] * s**k
        scales = np.abs(self.outputs) @ scaling.columns, scaling.rows @ np.abs(self.inputs)
        powers = s**self.power
        sizes = np.multiply.outer(np.multiply.outer(*scales), size) + sum(
            np.abs(D)[:, :, None] * np.abs(s) ** k for k, D in enumerate(polynomial)
        )
        return total * powers, sizes * np.abs(powers)

    def _term(self, index: int) -> np.ndarray:
        parts = [part @ self.pairs.laurent(index) @ self.inputs for part in _parts(self.outputs)]
        return _joined(parts)

    def finite_part(self, s: complex, pole: Pole | None = None) -> tuple[np.ndarray, np.ndarray]:
        """H(s) without the terms of a pole, and the sum of the sizes of its terms, both of shape (p, m)."""
        shape = (len(self.outputs), self.inputs.shape[1])
        terms = [np.zeros(shape, dtype=complex), *(D * s**k for k, D in enumerate(self.polynomial))]
        for other in self.poles:
            if other is not pole:
                terms += [R / (s - other.value) ** (j + 1) for j, R in enumerate(other.residues)]
        return np.sum(terms, axis=0), np.abs(terms).sum(axis=0)

    def pole_at(self, s: complex) -> Pole | None:
        """The pole that equals s to rounding errors; None without one."""
        near = [pole for pole in self.poles if abs(s - pole.value) <= _radius(pole)]
        return min(near, key=lambda pole: abs(s - pole.value), default=None)


def _radius(pole: Pole) -> float:
    return NOISE_SAFETY * EPS * abs(pole.value) if pole.order == 1 else rounding_radius(pole.order) * abs(pole.value)


def _block_values(C, J, B, s) -> tuple[np.ndarray, np.ndarray]:
    """C (s I - J)^-1 B, shape (p, m, S), and the size of (s I - J)^-1."""
    if len(J) == 1:
        inverse = 1 / (s - J[0, 0])
        return (C @ B)[:, :, None] * inverse, np.abs(inverse)
    if len(J) == 2:
        (a, b), (c, d) = J
        inverse = 1 / ((s - a) * (s - d) - b * c)
        constant = C @ np.array([[-d, b], [c, -a]]) @ B
        return ((C @ B)[:, :, None] * s + constant[:, :, None]) * inverse, (np.abs(s) + np.linalg.norm(J)) * np.abs(inverse)
    matrices = s[:, None, None] * np.eye(len(J)) - J
    inverses = np.linalg.inv(matrices)
    return np.einsum("pi,sij,jm->pms", C, inverses, B), np.linalg.norm(inverses, axis=(1, 2))


def invariant_vectors(J: np.ndarray, value: complex, count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Right vectors, matrix and left vectors of the ``count`` eigenvalues of J nearest to one: J right = right M, left J = M left."""
    if count == len(J):
        return np.eye(len(J)), J, np.eye(len(J))
    if len(J) == 2 and (pair := _simple_vectors(J, value)) is not None:
        return pair
    distance = np.sort(np.abs(np.linalg.eigvals(J) - value))
    limit = (distance[count - 1] + distance[count]) / 2
    T, Q, _ = scipy.linalg.schur(J, output="complex", sort=lambda root: abs(root - value) <= limit)
    X = scipy.linalg.solve_sylvester(T[:count, :count], -T[count:, count:], -T[:count, count:])
    left = Q.conj().T
    return Q[:, :count], T[:count, :count], left[:count] - X @ left[count:]


def _simple_vectors(J: np.ndarray, value: complex) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """The vectors of one of a complex pair of eigenvalues of two real rows, in closed form; None of real eigenvalues."""
    (a, b), (c, d) = J.tolist()
    half, middle = (a - d) / 2, (a + d) / 2
    square = half * half + b * c
    if not square < 0 or isinstance(b, complex):
        return None
    own = complex(middle, math.copysign(math.sqrt(-square), value.imag))
    # (J - own) (b, own - a) = 0 = (c, own - a) (J - own); |b|, |c| > 0
    right, left = np.array([[b], [own - a]]), np.array([[c, own - a]])
    right /= np.linalg.norm(right)
    return right, np.array([[own]]), left / (left @ right)


def _parts(outputs: np.ndarray) -> list[np.ndarray]:
    """A real matrix, or the real and the imaginary part of a complex one."""
    return [outputs.real, outputs.imag] if np.iscomplexobj(outputs) else [outputs]


def _at_least(array: np.ndarray, axis: int) -> np.ndarray:
    """Moduli with the rounding errors among the states of several blocks."""
    return np.maximum(np.abs(array), np.abs(array).max(axis=axis, keepdims=True, initial=0.0))


def _joined(parts: list[np.ndarray]) -> np.ndarray:
    return parts[0] if len(parts) == 1 else parts[0] + 1j * parts[1]


def _cleaned(terms: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Terms with rounding errors set to zero, without the last ones that vanish."""
    terms = np.where(np.abs(terms) > limits, terms, 0)
    return terms[: max((k + 1 for k, term in enumerate(terms) if term.any()), default=0)]


def poles_on_axis(poles: tuple[Pole, ...]) -> Iterator[Pole]:
    """Poles on the imaginary axis to rounding errors, at zero and above."""
    for pole in poles:
        if pole.value.imag >= 0 and is_on_axis(pole):
            yield pole


def is_on_axis(pole: Pole) -> bool:
    """Whether the real part of a pole is zero to rounding errors."""
    return abs(pole.value.real) <= _radius(pole)
