"""Derivatives of eigenvalues and shapes with respect to parameters, in the equations with multipliers.

With the rows at position level, L(s) = [K + C s + M s^2, -A^T; A, 0] and L(s) x = 0, x = (u, lambda), the derivatives of a simple eigenvalue
and of its shape, the entry j of which stays 1, are the solution of one bordered system, regular whatever M and the rows are:

    [L(s), L'(s) x; e_j^T, 0] [x_p; s_p] = [-L_p(s) x; 0]

(Nelson 1976; Lee and Jung 1997). Of g independent shapes of a semisimple eigenvalue the derivatives are the eigenvalues of
-Y^T L_p X with Y^T L' X = I (Lancaster 1964); defective ones split by fractional powers (``exact.splitting``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
import scipy.linalg

from ...exact.splitting import Branch, Splitting, splitting
from ...ground.tolerances import EPS, REFINEMENT_STEPS, SPLITTING_ROUNDING, noise_of
from ..equations import EquationsOfMotion
from ..modes import Mode
from .parameter import Parameter

STAYS = Branch(Fraction(1), 0j)


@dataclass(frozen=True, eq=False)
class MultiplierForm:
    """L(s) of a system and the L_p(s) of parameters, with rows scaled to the size of the stiffness.

    Attributes:
        base: L_0, L_1, L_2, shape (3, n + k, n + k).
        size: n.
        scale: by which the rows are multiplied; multipliers are divided by it.
    """

    base: np.ndarray
    size: int
    scale: float

    @staticmethod
    def of(system: EquationsOfMotion) -> MultiplierForm:
        """The multiplier form of a system with every row at position level."""
        scale = float(max(np.abs(system.stiffness).max(), np.abs(system.mass).max()))
        rows = scale * system.constraint_matrix
        matrices = np.array([system.stiffness, system.damping, system.mass])
        return MultiplierForm(_bordered_by(matrices, rows), system.size, scale)

    def slope(self, system: EquationsOfMotion, parameter: Parameter) -> Slope:
        """The derivatives of the multiplier form with respect to a parameter."""
        rows, _ = parameter.constraint_rows(system)
        matrices = _bordered_by(parameter.matrices(system.size), self.scale * rows)
        power, row, column = np.nonzero(matrices)
        return Slope(power, row, column, matrices[power, row, column], len(matrices[0]))

    def vectors(self, system: EquationsOfMotion, value: complex, shapes: np.ndarray) -> np.ndarray:
        """(u, lambda) of shapes with the constraint forces that they need."""
        if len(self.base[0]) == self.size:
            return shapes
        forces = self.at(value)[: self.size, : self.size] @ shapes
        return np.vstack([shapes, system.multiplier_map @ forces / self.scale])

    def at(self, value) -> np.ndarray:
        """L(s)."""
        return _value(self.base, value)

    def derivative(self, value) -> np.ndarray:
        """L'(s)."""
        return self.base[1] + 2 * value * self.base[2]


@dataclass(frozen=True, eq=False)
class Slope:
    """L_p(s) of one parameter by its few nonzero entries.

    Attributes:
        power: power of s, shape (e,).
        row, column, entry: indices and value of each.
        size: n + k.
    """

    power: np.ndarray
    row: np.ndarray
    column: np.ndarray
    entry: np.ndarray
    size: int

    @property
    def absolute(self) -> Slope:
        """The slope with absolute values of the entries."""
        return replace(self, entry=np.abs(self.entry))

    @property
    def matrices(self) -> np.ndarray:
        """Shape (3, n + k, n + k)."""
        result = np.zeros((3, self.size, self.size))
        result[self.power, self.row, self.column] = self.entry
        return result

    def form(self, left: np.ndarray, value, right: np.ndarray) -> np.ndarray:
        """Y^T L_p(s) X."""
        return left[self.row].T @ ((self.entry * value**self.power)[:, None] * right[self.column])

    def product(self, value, vector: np.ndarray) -> np.ndarray:
        """L_p(s) x."""
        result = np.zeros(self.size, dtype=vector.dtype)
        np.add.at(result, self.row, self.entry * value**self.power * vector[self.column])
        return result


def _bordered_by(matrices: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """[P, -A^T; A, 0] of each matrix, the rows with the first alone."""
    result = np.pad(matrices, [(0, 0), (0, len(rows)), (0, len(rows))])
    size = matrices.shape[1]
    result[0, size:, :size], result[0, :size, size:] = rows, -rows.T
    return result


def _value(coefficients: np.ndarray, value) -> np.ndarray:
    return coefficients[0] + value * (coefficients[1] + value * coefficients[2])


class Eigenspace:
    """A simple or semisimple eigenvalue with its g shapes and the bordered system of their derivatives.

    Newton's method in long double: [L(s), L'(s) X; E^T, 0] [dX; D] = [-L(s) X; 0], where E^T X = I, moves s by the mean of the
    diagonal of D (block Newton methods, Kressner 2009).

    Args:
        form: L(s).
        mode: the mode, with as many shapes as its multiplicity g.
        shapes: (u, lambda) as columns, shape (n + k, g).

    Attributes:
        value, vectors: s and X, in the basis of the given shapes; a single one has the largest entry 1.
        left: Y with Y^T L'(s) X = I.
        correction: the last step relative to s and to X, which estimates their errors from above.
        left_error: estimates of the errors of Y.
    """

    def __init__(self, form: MultiplierForm, mode: Mode, shapes: np.ndarray):
        self.form, count = form, shapes.shape[1]
        self.places = scipy.linalg.qr(shapes[: form.size].T, mode="r", pivoting=True)[1][:count]
        basis = shapes[self.places] if count > 1 else np.ones((1, 1))
        self.value = np.clongdouble(mode.eigenvalue)
        self.vectors = shapes.astype(np.clongdouble) @ np.linalg.inv(shapes[self.places])
        self._factor()
        for _ in range(REFINEMENT_STEPS):
            step, _ = self.solved(np.pad(-_value(form.base, self.value) @ self.vectors, [(0, count), (0, 0)]))
            self.vectors, change = self.vectors + step[:-count], step[-count:]
            self.value = self.value + change.trace() / count
            self._factor()
            self.correction = float(max(np.abs(change).max() / (abs(self.value) or 1.0), np.abs(step[: form.size]).max()))
            if self.correction <= EPS:
                break
        solution, change = self.solved(np.eye(len(self.matrix))[:, -count:], transposed=True)
        back = np.linalg.inv(basis).T
        self.left, self.left_error = solution[:-count] @ back, self._left_error(solution[:-count], change[:-count]) @ np.abs(back)
        self.vectors = self.vectors @ basis

    def _left_error(self, left: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Error of Y: its last refinement, and the effect of errors of s and X on the matrix of its equations."""
        moved = self.form.derivative(self.value).T @ left
        border = np.full((left.shape[1],) * 2, (np.abs(moved) * np.abs(self.vectors).max()).sum(axis=0))
        amplified, _ = self.solved(np.vstack([self.value * moved, border]), transposed=True)
        return np.abs(change) + self.correction * np.abs(amplified[: -left.shape[1]])

    def _factor(self) -> None:
        border, count = self.form.derivative(self.value) @ self.vectors, self.vectors.shape[1]
        self.matrix = np.zeros((len(border) + count,) * 2, dtype=np.clongdouble)
        self.matrix[:-count, :-count], self.matrix[:-count, -count:] = self.form.at(self.value), border
        self.matrix[np.arange(-count, 0), self.places] = 1.0
        self.factors = scipy.linalg.lu_factor(self.matrix.astype(complex), check_finite=False)

    def solved(self, right: np.ndarray, transposed: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """The solution of the bordered system, refined to the digits of long double as far as its condition allows."""
        matrix = self.matrix.T if transposed else self.matrix
        result = np.zeros(right.shape, dtype=np.clongdouble)
        for _ in range(1 + REFINEMENT_STEPS):
            rest = (right - matrix @ result).astype(complex)
            correction = scipy.linalg.lu_solve(self.factors, rest, trans=int(transposed), check_finite=False)
            result = result + correction
        return result, correction

    def slopes(self, slope: Slope) -> np.ndarray:
        """ds/dp: the eigenvalues of -Y^T L_p(s) X, shape (g,)."""
        return _eigenvalues(-slope.form(self.left, self.value, self.vectors).astype(complex), self._phase)

    def error(self, slope: Slope, doubt: Slope | None) -> float:
        """An estimate of the largest error of ds/dp (Bauer and Fike 1960)."""
        left, right, value = np.abs(self.left), np.abs(self.vectors), abs(self.value)
        sizes, matrix = slope.absolute, -slope.form(self.left, self.value, self.vectors).astype(complex)
        doubtful = EPS * right + self.correction * right.max(axis=0)
        total = sizes.form(left, value, doubtful) + sizes.form(self.left_error, value, right)
        if doubt is not None:
            total += doubt.absolute.form(left, value, right)
        return float(np.linalg.norm(total.astype(float), 2) * _condition(matrix, self._phase))

    @property
    def _phase(self) -> complex:
        """s / |s|, by which the derivatives of undamped modes are real."""
        return complex(self.value / abs(self.value)) if self.value else 1.0

    def shape_slope(self, slope: Slope) -> np.ndarray:
        """du/dp of a single shape, the largest entry of u being 1, shape (n,)."""
        right = -slope.product(self.value, self.vectors[:, 0])
        return self.solved(np.append(right, 0.0)[:, None])[0][: self.form.size, 0].astype(complex)


def _is_hermitian(matrix: np.ndarray) -> bool:
    return bool((np.abs(matrix - matrix.conj().T) <= noise_of(np.abs(matrix).max(initial=0.0), len(matrix))).all())


def _eigenvalues(matrix: np.ndarray, phase: complex) -> np.ndarray:
    """Eigenvalues of a matrix, along the phase where matrix / phase is Hermitian."""
    if len(matrix) == 1:
        return matrix[0]
    turned = matrix / phase
    values = phase * np.linalg.eigvalsh(turned) if _is_hermitian(turned) else np.linalg.eigvals(matrix)
    return np.array(sorted(values, key=lambda z: (z.imag, z.real)))


def _condition(matrix: np.ndarray, phase: complex) -> float:
    """Condition number of the eigenvectors."""
    return 1.0 if len(matrix) == 1 or _is_hermitian(matrix / phase) else float(np.linalg.cond(np.linalg.eig(matrix)[1]))


@dataclass(frozen=True, eq=False)
class ModeDerivatives:
    """Derivatives of the eigenvalue of one mode with respect to each parameter.

    Attributes:
        mode: the mode.
        branches: for each parameter as many branches as the multiplicity.
        splittings: splittings of a defective eigenvalue, by the index of the parameter.
        errors: for each parameter an estimate of the largest error of the coefficients of its branches.
    """

    mode: Mode
    branches: tuple[tuple[Branch, ...], ...]
    splittings: dict[int, Splitting]
    errors: tuple[float, ...]


def mode_derivatives(
    system: EquationsOfMotion, mode: Mode, form: MultiplierForm, slopes: Sequence[Slope], doubts: Sequence[Slope | None]
) -> ModeDerivatives:
    """The derivatives of one mode."""
    count, shapes = mode.multiplicity, mode.shapes
    if not shapes.shape[1]:
        return ModeDerivatives(mode, ((STAYS,) * count,) * len(slopes), {}, (0.0,) * len(slopes))
    vectors = form.vectors(system, mode.eigenvalue, shapes)
    if count == shapes.shape[1]:
        space = Eigenspace(form, mode, vectors)
        if count == 1 or space.correction < EPS**0.5:
            branches = tuple(tuple(Branch(Fraction(1), complex(value)) for value in space.slopes(slope)) for slope in slopes)
            return ModeDerivatives(mode, branches, {}, tuple(map(space.error, slopes, doubts)))
    return _defective(mode, form, slopes, doubts, vectors)


def _defective(mode: Mode, form: MultiplierForm, slopes, doubts, vectors) -> ModeDerivatives:
    """The splitting of a defective eigenvalue by each parameter."""
    rate = float(np.sqrt(np.abs(form.base[0]).max() / (np.abs(form.base[2]).max() or 1.0))) or 1.0
    size, branches, splittings = np.abs(form.base).max(axis=(1, 2)) @ rate ** np.arange(3), [], {}
    left = scipy.linalg.svd(form.at(mode.eigenvalue).T)[2][-vectors.shape[1] :].conj().T
    errors = [0.0] * len(slopes)
    for place, slope in enumerate(each.matrices for each in slopes):
        effect = np.abs(slope).max(axis=(1, 2)) @ rate ** np.arange(3)
        still = not mode.eigenvalue and np.abs(slope[:2] @ vectors).max() <= noise_of(effect, len(slope[0]))
        if not effect or still:  # free motions stay free
            branches.append((STAYS,) * mode.multiplicity)
            continue
        step = float(size / effect)
        splittings[place] = branching = splitting([*form.base], [*slope], mode.eigenvalue, mode.multiplicity, rate, step)
        branches.append(branching.branches)
        doubt = _relative_doubt(slopes[place], doubts[place], mode.eigenvalue, left, vectors)
        rounding = EPS if branching.is_exact else SPLITTING_ROUNDING
        errors[place] = (rounding + doubt) * max(abs(branch.coefficient) for branch in branching.branches)
    return ModeDerivatives(mode, tuple(branches), splittings, tuple(errors))


def _relative_doubt(slope: Slope, doubt: Slope | None, value: complex, left: np.ndarray, right: np.ndarray) -> float:
    """Errors of Y^T L_p X, on which the leading coefficients of a defective eigenvalue depend, relative to it."""
    size = np.abs(slope.form(left, value, right)).max()
    error = np.abs(left), abs(value), np.abs(right)
    return (
        float((slope.absolute.form(*error) * EPS if doubt is None else doubt.absolute.form(*error)).max() / size) if size else 0.0
    )
