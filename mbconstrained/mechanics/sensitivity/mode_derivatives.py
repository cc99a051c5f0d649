"""Derivatives of eigenvalues and shapes with respect to parameters, in the equations with multipliers.

With the rows at position level, L(s) = [K + C s + M s^2, -A^T; A, 0] and L(s) x = 0, x = (u, lambda), the derivatives of a simple eigenvalue
and of its shape, the entry j of which stays 1, are the solution of one bordered system, regular whatever M and the rows are:

    [L(s), L'(s) x; e_j^T, 0] [x_p; s_p] = [-L_p(s) x; 0]

(Nelson 1976; Lee and Jung 1997). Of g independent shapes of a semisimple eigenvalue the derivatives are the eigenvalues of
-(Y^T L' X)^-1 Y^T L_p X (Lancaster 1964); defective ones split by fractional powers (``exact.splitting``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

from ...exact.splitting import Branch, Splitting, splitting
from ...ground.tolerances import EPS, REFINEMENT_STEPS, noise_of
from ..modes import Mode
from .parameter import Parameter

if TYPE_CHECKING:
    from ..system import MechanicalSystem

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
    def of(system: MechanicalSystem) -> MultiplierForm:
        """With every row at position level."""
        scale = float(max(np.abs(system.stiffness).max(), np.abs(system.mass).max()))
        rows = scale * system.constraint_matrix
        matrices = np.array([system.stiffness, system.damping, system.mass])
        return MultiplierForm(_bordered_by(matrices, rows), system.size, scale)

    def slope(self, system: MechanicalSystem, parameter: Parameter) -> Slope:
        """The derivatives of the same with respect to a parameter.

        Args:
            system: the same.
            parameter: of it.

        Returns:
            L_p(s).
        """
        rows, _ = parameter.constraint_rows(system)
        matrices = _bordered_by(parameter.matrices(system.size), self.scale * rows)
        power, row, column = np.nonzero(matrices)
        return Slope(power, row, column, matrices[power, row, column], len(matrices[0]))

    def vectors(self, system: MechanicalSystem, value: complex, shapes: np.ndarray) -> np.ndarray:
        """(u, lambda) of shapes: the forces of the rows are those that the shapes need.

        Args:
            system: the same.
            value: s.
            shapes: u as columns, shape (n, m).

        Returns:
            Shape (n + k, m).
        """
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
    """L_p(s) of one parameter by its entries, which are few.

    Attributes:
        power: of s, shape (e,).
        row, column, entry: of each.
        size: n + k.
    """

    power: np.ndarray
    row: np.ndarray
    column: np.ndarray
    entry: np.ndarray
    size: int

    @property
    def matrices(self) -> np.ndarray:
        """Shape (3, n + k, n + k)."""
        result = np.zeros((3, self.size, self.size))
        result[self.power, self.row, self.column] = self.entry
        return result

    def form(self, left: np.ndarray, value, right: np.ndarray) -> complex:
        """y^T L_p(s) x.

        Args:
            left, right: y and x, shape (n + k,).
            value: s.

        Returns:
            A number.
        """
        return complex((left[self.row] * self.entry * value**self.power * right[self.column]).sum())

    def product(self, value, vector: np.ndarray) -> np.ndarray:
        """L_p(s) x.

        Args:
            value: s.
            vector: x, shape (n + k,).

        Returns:
            Shape (n + k,).
        """
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


class SimpleMode:
    """A simple eigenvalue with the bordered system of its derivatives.

    Args:
        form: L(s).
        mode: the mode, of multiplicity 1.
        vector: (u, lambda).

    Attributes:
        value, vector: s and x, refined by Newton's method in long double.
        left: y^T with y^T L'(s) x = 1.
        correction: the last step of the refinement, relative to s or to the scale of eigenvalues, and to x.
    """

    def __init__(self, form: MultiplierForm, mode: Mode, vector: np.ndarray):
        self.form, self.place = form, int(np.abs(vector[: form.size]).argmax())
        self.value, self.vector = np.clongdouble(mode.eigenvalue), vector.astype(np.clongdouble) / vector[self.place]
        self._factor()
        for _ in range(REFINEMENT_STEPS):
            step = self.solved(np.append(-_value(form.base, self.value) @ self.vector, 0.0))
            self.vector, self.value = self.vector + step[:-1], self.value + step[-1]
            self._factor()
            self.correction = float(max(abs(step[-1]) / (abs(self.value) or 1.0), np.abs(step[: form.size]).max()))
            if self.correction <= EPS:
                break
        self.left = self.solved(np.eye(1, len(self.matrix), len(self.matrix) - 1)[0], transposed=True)[:-1]

    def _factor(self) -> None:
        border = self.form.derivative(self.value) @ self.vector
        self.matrix = np.zeros((len(border) + 1,) * 2, dtype=np.clongdouble)
        self.matrix[:-1, :-1], self.matrix[:-1, -1] = self.form.at(self.value), border
        self.matrix[-1, self.place] = 1.0
        self.factors = scipy.linalg.lu_factor(self.matrix.astype(complex), check_finite=False)

    def solved(self, right: np.ndarray, transposed: bool = False) -> np.ndarray:
        """The solution of the bordered system, refined to the digits of long double as far as its condition allows.

        Args:
            right: its right-hand side, shape (n + k + 1,).
            transposed: whether the matrix is transposed.

        Returns:
            Shape (n + k + 1,).
        """
        matrix = self.matrix.T if transposed else self.matrix
        result = np.zeros(len(right), dtype=np.clongdouble)
        for _ in range(1 + REFINEMENT_STEPS):
            rest = (right - matrix @ result).astype(complex)
            result = result + scipy.linalg.lu_solve(self.factors, rest, trans=int(transposed), check_finite=False)
        return result

    def slope(self, slope: Slope) -> complex:
        """ds/dp = -y^T L_p(s) x."""
        return -slope.form(self.left, self.value, self.vector)

    def shape_slope(self, slope: Slope) -> np.ndarray:
        """du/dp, the largest entry of u being 1, shape (n,)."""
        right = -slope.product(self.value, self.vector)
        return self.solved(np.append(right, 0.0))[: self.form.size].astype(complex)


@dataclass(frozen=True, eq=False)
class ModeDerivatives:
    """How the eigenvalue of one mode moves with each parameter.

    Attributes:
        mode: the mode.
        branches: for each parameter one branch for each of the multiplicity.
        splittings: of a defective eigenvalue for each parameter that moves it, by the place of the parameter.
        correction: see ``SimpleMode``; 0 of multiple eigenvalues.
    """

    mode: Mode
    branches: tuple[tuple[Branch, ...], ...]
    splittings: dict[int, Splitting]
    correction: float = 0.0


def mode_derivatives(system: MechanicalSystem, mode: Mode, form: MultiplierForm, slopes: Sequence[Slope]) -> ModeDerivatives:
    """The derivatives of one mode.

    Args:
        system: to which the mode belongs.
        mode: any but drift, which stays.
        form: L(s).
        slopes: L_p of each parameter.

    Returns:
        The branches of its eigenvalue.
    """
    count, shapes = mode.multiplicity, mode.shapes
    if not shapes.shape[1]:
        return ModeDerivatives(mode, ((STAYS,) * count,) * len(slopes), {})
    vectors = form.vectors(system, mode.eigenvalue, shapes)
    if count == 1:
        simple = SimpleMode(form, mode, vectors[:, 0])
        branches = tuple((Branch(Fraction(1), simple.slope(slope)),) for slope in slopes)
        return ModeDerivatives(mode, branches, {}, simple.correction)
    if count == shapes.shape[1]:
        left = scipy.linalg.svd(form.at(mode.eigenvalue).T)[2][-count:].conj().T
        inner = left.T @ form.derivative(mode.eigenvalue) @ vectors
        if np.linalg.cond(inner) < 1 / EPS**0.5:
            return ModeDerivatives(mode, tuple(_semisimple(mode, slope, left, vectors, inner) for slope in slopes), {})
    return _defective(mode, form, slopes, vectors)


def _semisimple(mode: Mode, slope: Slope, left, vectors, inner) -> tuple[Branch, ...]:
    matrix = -np.linalg.solve(inner, left.T @ _value(slope.matrices, mode.eigenvalue) @ vectors)
    if (np.abs(matrix - matrix.conj().T) <= noise_of(np.abs(matrix).max(initial=0.0), len(matrix))).all():
        values = np.linalg.eigvalsh(matrix).astype(complex)
    else:
        values = np.linalg.eigvals(matrix)
    return tuple(Branch(Fraction(1), complex(value)) for value in sorted(values, key=lambda z: (z.imag, z.real)))


def _defective(mode: Mode, form: MultiplierForm, slopes, vectors) -> ModeDerivatives:
    """The splitting by each parameter."""
    rate = float(np.sqrt(np.abs(form.base[0]).max() / (np.abs(form.base[2]).max() or 1.0))) or 1.0
    size, branches, splittings = np.abs(form.base).max(axis=(1, 2)) @ rate ** np.arange(3), [], {}
    for place, slope in enumerate(each.matrices for each in slopes):
        effect = np.abs(slope).max(axis=(1, 2)) @ rate ** np.arange(3)
        still = not mode.eigenvalue and np.abs(slope[:2] @ vectors).max() <= noise_of(effect, len(slope[0]))
        if not effect or still:  # free motions stay free
            branches.append((STAYS,) * mode.multiplicity)
            continue
        step = float(size / effect)
        splittings[place] = splitting([*form.base], [*slope], mode.eigenvalue, mode.multiplicity, rate, step)
        branches.append(splittings[place].branches)
    return ModeDerivatives(mode, tuple(branches), splittings)
