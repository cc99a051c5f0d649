"""The modes of a large sparse system with what is known of them: residuals, orthogonality, and whether any is missing."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ...checks import counted as in_words
from ...notices import Notice

Kind = Literal["oscillation", "decay", "growth", "rigid body", "offset"]


@dataclass(frozen=True, repr=False)
class SparseModes:
    """Some modes of lowest frequency of M x'' + C x' + K x = 0 with A x = 0, x = Re(shape e^{value t}).

    Attributes:
        values: the zeros s of A(s) in 1/s, above or on the real axis; 0 for a rigid body. By ascending |s|.
        vectors: their shapes, one a column, shape (n, m), all coordinates, constraints obeyed: real with X^T M X = I for
            undamped modes, complex with x^T (2 s M + C) x = 2 i |Im s| for damped ones (x^T M x = 1 without damping).
        kinds: "oscillation", "rigid body", "growth"; for damped modes "decay" and "offset" too.
        residuals: |s^2 M x + s C x + K x| of each, constraint forces apart, relative to the sum of the sizes of its terms.
        bounds: what rounding of the matrices' entries and the stopping rule explain of the residual, in the same measure.
        names: of the coordinates, in the order of the rows of the shapes.
        orthogonality: the largest entry of X^T M X - I; for damped modes that of the corresponding bilinear form.
        counted_below: the angular frequency in rad/s up to which the undamped modes were counted by Sylvester's law of
            inertia; None where that was not possible.
        none_missed: whether the count says that no undamped mode below that frequency is missing here.
        complete: whether the system has no other finite undamped modes.
        notices: what is worth knowing: modes that may be missing, residuals beyond their bound, dependent rows.
    """

    values: np.ndarray
    vectors: np.ndarray
    kinds: tuple[Kind, ...]
    residuals: np.ndarray
    bounds: np.ndarray
    names: tuple[str, ...]
    orthogonality: float
    counted_below: float | None
    none_missed: bool
    complete: bool
    notices: tuple[Notice, ...] = ()

    def __len__(self) -> int:
        return len(self.values)

    def __repr__(self) -> str:
        sure = "none missed" if self.none_missed else "not counted"
        rigid = f", {self.rigid} rigid" if self.rigid else ""
        return f"SparseModes({in_words(len(self), 'mode')} of {in_words(len(self.names), 'coordinate')}{rigid}, {sure})"

    @property
    def oscillating(self) -> np.ndarray:
        """The places of those with an imaginary part, ascending by angular frequency."""
        return np.flatnonzero(self.values.imag)

    @property
    def angular_frequencies(self) -> np.ndarray:
        """|s| of the oscillating ones in rad/s, as ``Modes`` of small systems has them."""
        return np.abs(self.values[self.oscillating])

    @property
    def frequencies_hz(self) -> np.ndarray:
        """The same in Hz."""
        return self.angular_frequencies / (2 * np.pi)

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s / |s| of the same."""
        return -self.values[self.oscillating].real / self.angular_frequencies

    @property
    def shapes(self) -> np.ndarray:
        """The shapes of the same, one a column."""
        return self.vectors[:, self.oscillating]

    @property
    def rigid(self) -> int:
        """How many are rigid body motions."""
        return self.kinds.count("rigid body")

    def table(self) -> list[dict[str, str]]:
        """One row of text for each: kind, zero, frequency in Hz and rad/s, damping ratio, residual."""
        return [_row(*mode) for mode in zip(self.kinds, self.values, self.residuals)]


def _row(kind: Kind, value: complex, residual: float) -> dict[str, str]:
    frequency = abs(value) if value.imag else 0.0
    return {
        "kind": kind,
        "zero (1/s)": f"{value.real:.6g} ± {value.imag:.6g} i" if value.imag else f"{value.real:.6g}",
        "frequency (Hz)": f"{frequency / (2 * np.pi):.6g}",
        "angular frequency (rad/s)": f"{frequency:.6g}",
        "damping ratio": f"{-value.real / abs(value) if value else 0.0:.4g}",
        "residual": f"{residual:.2g}",
    }
