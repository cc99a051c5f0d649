"""The matrices of a frequency response: s^p C A(s)^-1 B, with names and units of its inputs and outputs."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..ground.errors import InputError
from ..ground.notices import Notice
from ..ground.tolerances import LARGEST_POWER
from ..polynomial.polynomial_matrix import PolynomialMatrix
from .pole_residue_form import PoleResidueForm
from .structured_solve import StructuredSolver


class LeftOut:
    """Part of the response that a reduced model omits."""

    @property
    def highest_hz(self) -> float:
        """The highest frequency up to which the errors are bounded."""
        raise NotImplementedError

    def bound(self, omega: np.ndarray) -> np.ndarray:
        """Bounds of the absolute errors of C A^-1 B at w in rad/s, shape (p, m, F)."""
        raise NotImplementedError


@dataclass(frozen=True, eq=False)
class Harmonic:
    """s^p C A(s)^-1 B, the matrices of a frequency response; A(s) may have a constant imaginary part, of structural damping.

    Attributes:
        A: the real polynomial matrix.
        inputs: B, shape (r, m).
        outputs: C, shape (p, r).
        power: p.
        imaginary: the imaginary part of A_0, shape (r, r); None for none. It holds for w > 0 and changes its sign with w.
        sizes: sizes of the terms that coefficients are sums of, shape (q + 1, r, r); None for those of the coefficients.
        input_names, output_names: texts.
        units: units of the entries of H, shape (p, m), "" where unknown.
        quantity: its name.
        left_out: bound of the omitted part of a model that these matrices reduce; None for the model itself.
        notices: notices on the model.
    """

    A: PolynomialMatrix
    inputs: np.ndarray
    outputs: np.ndarray
    power: int = 0
    imaginary: np.ndarray | None = None
    sizes: np.ndarray | None = None
    input_names: tuple[str, ...] = ()
    output_names: tuple[str, ...] = ()
    units: np.ndarray = field(default_factory=lambda: np.array([[""]]))
    quantity: str = "response"
    left_out: LeftOut | None = None
    notices: tuple[Notice, ...] = ()

    @property
    def coefficients(self) -> np.ndarray:
        """A_0, A_1, ..., A_0 with its imaginary part."""
        if self.imaginary is None:
            return self.A.coefficients
        return self.A.coefficients + 1j * np.array([self.imaginary, *np.zeros_like(self.A.coefficients[1:])])

    @cached_property
    def solver(self) -> StructuredSolver:
        """Solutions at given lines."""
        return StructuredSolver(self.coefficients, self.inputs, self.outputs, self.sizes)

    def check(self, frequencies: np.ndarray) -> None:
        """Raise an InputError for frequencies beyond the range of the computation.

        Args:
            frequencies: in Hz, shape (F,).
        """
        highest = frequencies.max(initial=0.0)
        if self.left_out is not None and highest >= self.left_out.highest_hz:
            raise InputError(
                f"frequencies_hz: found {highest:g} Hz; the computed modes reach {self.left_out.highest_hz:.6g} Hz: increase count, "
                "the number of modes, or leave out the higher frequencies"
            )
        limit = self.solver.time * LARGEST_POWER ** (1 / max(self.A.degree, 1)) / (2 * np.pi)
        if highest > limit:
            raise InputError(
                f"frequencies_hz: found {highest:g} Hz; powers of it leave the range of float64, expected at most {limit:.3g} Hz"
            )

    @cached_property
    def real(self) -> tuple[PolynomialMatrix, np.ndarray, np.ndarray]:
        """A real A(s) with B and a C, complex where A(s) is complex.

        [[A, -H], [H, A]] (u, v) = (b, 0) has the solution u + i v of (A + i H) x = b.
        """
        if self.imaginary is None:
            return self.A, self.inputs, self.outputs
        H = [self.imaginary, *np.zeros_like(self.A.coefficients[1:])]
        doubled = [np.block([[own, -other], [other, own]]) for own, other in zip(self.A.coefficients, H)]
        inputs = np.vstack([self.inputs, 0 * self.inputs])
        return PolynomialMatrix(doubled), inputs, np.hstack([self.outputs, 1j * self.outputs])

    @cached_property
    def form(self) -> PoleResidueForm:
        """Poles, residues and polynomial part."""
        A, inputs, outputs = self.real
        return PoleResidueForm(A.jordan_pairs(), inputs, outputs, self.power)
