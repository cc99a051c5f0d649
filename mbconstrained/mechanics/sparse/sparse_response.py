"""Frequency responses of sparse systems: the modes of lowest frequency and static corrections, with a bound on what is left out.

The equations are reduced to W = [X, V], X the modes and V the part of (K - shift M)^-1 [B, C^T] outside of them, with the deflections
that its inertia causes (a Galerkin method). With
the residuals r_x of A(i w)^-1 B and r_z of A(i w)^-T C^T, which act on left-out modes alone, the error of an entry is

    |r_z^T A^-1 r_x| <= |r_z| |r_x| (W^2 - shift) / (W^2 - w^2),   |r|^2 = r^H (K - shift M)^-1 r,   w < W,

W the lowest frequency that is left out: the real part K - w^2 M of A is positive definite there, and symmetric damping only makes the
inverse smaller. It is a bound where damping does not couple the modes with others, as proportional damping; an estimate where it does.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...frequency.harmonic import Harmonic, LeftOut
from ...ground.checks import real_array
from ...ground.errors import InputError
from ...ground.tolerances import EPS
from ...ground.units import force_unit, ratio_unit
from ...linalg.division import accurate_product
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..channels import Output, chosen_by_name
from ..equations import EquationsOfMotion
from .pencil import asymmetry, times
from .undamped_modes import UndampedModes, undamped_modes

#: Corrections of a force: its static deflection, that of the inertia of this one, and so on.
ORDERS = 3

#: Rounding errors of a sum in extended precision, in units of EPS and of its terms.
SUM_ROUNDING = 4 * float(np.finfo(np.longdouble).eps) / EPS

#: Number of columns and rows multiplied at a time in extended precision, without a second array as large as all vectors.
COLUMNS, ROWS = 16, 8192

#: Static corrections whose part outside of the others is smaller than this, relative to them, are rounding errors.
DEPENDENT = EPS**0.5


def sparse_harmonic(
    system: EquationsOfMotion, inputs, outputs: Sequence[Output], quantity: str, modal_damping, loss_factor, count: int
) -> Harmonic:
    """The reduced equations with the bound of the remainder."""
    into = np.array(chosen_by_name("inputs", inputs, {name: i for i, name in enumerate(system.names)}, ()))
    order = outputs[0].order
    if order is None or any(one.order != order for one in outputs):
        names = ", ".join(f'"{one.name}"' for one in outputs)
        raise InputError(
            f"outputs: found {names}; of sparse matrices expected motions or elongations, all of them displacements, velocities or "
            "accelerations; or give arrays, as mass.toarray()"
        )
    if asymmetry(system.damping)[0]:
        raise InputError("damping: frequency responses of sparse matrices need a symmetric one; give arrays, as damping.toarray()")
    undamped, basis = undamped_modes(system.pencil, count), system.pencil.basis
    sources = np.hstack([basis[into].toarray().T, basis.T @ np.array([one.rows[order] for one in outputs]).T])
    reduced = _Reduced(system.pencil, undamped, sources)
    coefficients = reduced.coefficients
    coefficients[1] += reduced.modal_damping(modal_damping)
    m, forces = len(into), reduced.forces
    imaginary = None if loss_factor is None else loss_factor * coefficients[0]
    of_inputs, of_outputs = tuple(system.names[place] for place in into), tuple(one.name for one in outputs)
    below = [force_unit(system.units[name]) for name in of_inputs]
    units = np.array([[ratio_unit(one.unit, other) for other in below] for one in outputs])
    left_out = None if undamped.complete else _Residuals(reduced, coefficients, imaginary, m)
    A, B, C = PolynomialMatrix(coefficients), forces[:, :m], forces[:, m:].T
    return Harmonic(A, B, C, order, imaginary, reduced.sizes, of_inputs, of_outputs, units, quantity, left_out)


def _projected(matrix, W: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """W^T A W, accumulated in extended precision and rounded once, and the sizes of the terms of its entries.

    Lanczos vectors are no eigenvectors, and K V is not quite what V was solved for: only with these products the method is Galerkin's, whose
    error is of second order. In float64 the terms of a chain of soft and stiff springs would hide its softest modes.
    """
    extended, total = matrix.astype(np.longdouble), np.zeros((W.shape[1], W.shape[1]), dtype=np.longdouble)
    for first in range(0, W.shape[1], COLUMNS):
        at = slice(first, first + COLUMNS)
        product = np.column_stack([extended @ column.astype(np.longdouble) for column in W[:, at].T])
        high = product.astype(float)
        both = np.hstack([high, (product - high).astype(float)])
        for begin in range(0, len(W), ROWS):
            value, rest = accurate_product(W[begin : begin + ROWS].T, both[begin : begin + ROWS])
            total[:, at] += sum(np.hsplit(value.astype(np.longdouble) + rest, 2))
    terms = np.abs(W).T @ times(abs(matrix), np.abs(W))
    return ((total + total.T) / 2).astype(float), (terms + terms.T) / 2


def _remainder(matrix, columns: np.ndarray, right: np.ndarray) -> np.ndarray:
    """A S - B, in extended precision."""
    extended = matrix.astype(np.longdouble)
    parts = [(extended @ own.astype(np.longdouble) - other).astype(float) for own, other in zip(columns.T, right.T)]
    return np.column_stack(parts)


class _Reduced:
    """W^T A(s) W."""

    def __init__(self, pencil, undamped: UndampedModes, forces: np.ndarray):
        self.undamped, X, shift = undamped, undamped.vectors, undamped.shift
        self.shifted = pencil.stiffness - shift * pencil.mass
        sources = [forces - times(pencil.mass, X @ (X.T @ forces))]  # what acts on the left-out modes
        solutions: list[np.ndarray] = []
        for order in range(ORDERS):
            columns = undamped.factors.solve(sources[order])
            solutions.append(columns - X @ (X.T @ times(pencil.mass, columns)))
            sources.append(times(pencil.mass, solutions[-1]))
        self.sources, solved = np.hstack(sources[:ORDERS]), np.hstack(solutions)
        sizes = np.sqrt(np.maximum(np.einsum("ij,ij->j", solved, times(pencil.mass, solved)), 0.0))
        unit = np.where(sizes > 0, sizes, 1.0)
        gram = (solved / unit).T @ times(pencil.mass, solved / unit)
        values, turn = np.linalg.eigh((gram + gram.T) / 2)
        kept = values > DEPENDENT
        self.turn = turn[:, kept] / np.sqrt(values[kept]) / unit[:, None]  # V = solved turn, orthonormal in M
        self.static = solved @ self.turn
        self.inertia = times(pencil.mass, self.static)
        self.damped = times(pencil.damping, np.hstack([X, self.static])) if pencil.damping.nnz else None
        W = np.hstack([X, self.static])
        projected = [_projected(matrix, W) for matrix in (pencil.stiffness, pencil.damping, pencil.mass)]
        self.coefficients = np.array([own for own, _ in projected])
        rounding = SUM_ROUNDING if pencil.basis.shape[0] == pencil.size else SUM_ROUNDING + pencil.rounding / EPS
        self.sizes = 2 * np.abs(self.coefficients) + rounding * np.array([terms for _, terms in projected])
        self.forces = W.T @ forces
        others = np.hstack([times(pencil.mass, X) * undamped.values, self.sources @ self.turn + shift * self.inertia])
        self.unequal = _remainder(pencil.stiffness, W, others)

    def modal_damping(self, ratios) -> np.ndarray:
        """2 zeta w of the modes on the diagonal."""
        rates = np.zeros(len(self.forces))
        if ratios is not None:
            w = np.sqrt(np.maximum(self.undamped.values, 0.0))
            zeta = real_array(ratios, "modal_damping")
            if (zeta.ndim and zeta.shape != (len(w),)) or (zeta < 0).any():
                raise InputError(f"modal_damping: expected 0 or a positive number, or one for each of the {len(w)} modes")
            rates[: len(w)] = 2 * zeta * w
        return np.diag(rates)


@dataclass(frozen=True, eq=False)
class _Residuals(LeftOut):
    """Norms of residuals by the Gram matrix of the vectors that they combine."""

    reduced: _Reduced
    coefficients: np.ndarray
    imaginary: np.ndarray | None
    input_count: int

    @cached_property
    def limit(self) -> float:
        """W^2 in 1/s^2: no omitted mode lies below."""
        undamped, last = self.reduced.undamped, float(self.reduced.undamped.values[-1])
        return max(last, undamped.below or last) if undamped.computed_below == len(undamped.values) else last

    @property
    def highest_hz(self) -> float:
        """W / (2 pi)."""
        return float(np.sqrt(max(self.limit, 0.0)) / (2 * np.pi))

    @cached_property
    def _gram(self) -> tuple[np.ndarray, np.ndarray]:
        """The Gram matrix in (K - shift M)^-1, corrected to second order by residuals, and the sizes of its terms."""
        reduced, X = self.reduced, self.reduced.undamped.vectors
        parts = [reduced.inertia] if reduced.damped is None else [reduced.inertia, reduced.damped]
        columns = np.hstack([reduced.sources, *parts, reduced.unequal])
        solved = reduced.undamped.factors.solve(columns)
        left = _remainder(reduced.shifted, solved, columns) if not reduced.undamped.factors.is_bordered else 0.0 * columns
        inner = columns.T @ X  # along the modes there is nothing to leave out
        along = inner / (reduced.undamped.values - reduced.undamped.shift)
        gram = columns.T @ solved - solved.T @ left - along @ inner.T
        return (gram + gram.T) / 2, np.abs(columns).T @ np.abs(solved) + np.abs(along) @ np.abs(inner).T

    def bound(self, omega: np.ndarray) -> np.ndarray:
        """Bound of |C A^-1 B| without the factor (i w)^p, shape (p, m, F)."""
        reduced, sizes, (gram, terms) = self.reduced, [], self._gram
        modes, shift = len(reduced.undamped.values), reduced.undamped.shift
        structural = 1.0 if self.imaginary is None else 1 + 1j * self.imaginary[0, 0] / self.coefficients[0, 0, 0]
        K = self.coefficients[0] if self.imaginary is None else self.coefficients[0] + 1j * self.imaginary
        for w in np.asarray(omega, dtype=float):
            y = np.linalg.solve(K + 1j * w * self.coefficients[1] - w * w * self.coefficients[2], reduced.forces)
            along, sources = y[modes:], structural * (reduced.turn @ y[modes:])
            damped = [] if reduced.damped is None else [-1j * w * y]
            c = np.vstack([np.eye(*sources.shape) - sources, (w * w - structural * shift) * along, *damped, -structural * y])
            square = np.real(np.einsum("ij,ik,kj->j", c.conj(), gram, c))
            rounding = EPS * np.einsum("ij,ik,kj->j", np.abs(c), terms, np.abs(c))
            sizes.append(np.sqrt(np.maximum(square, rounding)) * np.sqrt((self.limit - shift) / (self.limit - w * w)))
        norms = np.array(sizes).reshape(len(sizes), reduced.forces.shape[1]).T
        return norms[self.input_count :, None] * norms[: self.input_count]
