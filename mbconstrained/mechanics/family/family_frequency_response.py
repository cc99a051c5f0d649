"""The frequency responses of a family of systems from the stacked poles and residues, of some systems one by one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ...ground.checks import counted, real_array
from ...ground.display import Displayed, TextTable, notice_table
from ...ground.notices import Notice
from ...ground.tolerances import EPS, FORM_ROUNDING, LINE_ACCURACY
from ..channels import channels, chosen_by_name, reference
from ..vibration.harmonic_equations import QUANTITIES
from .family_modes import one_by_one
from .stacked_poles import TOGETHER

if TYPE_CHECKING:
    from .family import Family

#: Quantities that are computed from the poles of a stack.
BY_POLES = ("receptance", "mobility", "accelerance", "transmissibility")


@dataclass(frozen=True, repr=False, eq=False)
class FamilyFrequencyResponse(Displayed):
    """H(i w) of S systems.

    Attributes:
        family: the systems.
        frequencies_hz: shape (F,).
        values: complex, shape (S, outputs, inputs, F).
        error_estimate: relative to the largest value of each row, shape (S, outputs, inputs).
        inputs, outputs: names.
        quantity: what is given.
        units: of the entries, shape (outputs, inputs).
        alone: places of the systems that were solved one by one.
    """

    family: Family
    frequencies_hz: np.ndarray
    values: np.ndarray
    error_estimate: np.ndarray
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    quantity: str
    units: np.ndarray
    alone: np.ndarray

    def _summary(self) -> str:
        return f"{self.quantity} of {counted(len(self.family), 'system')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """How many systems were solved one by one."""
        return one_by_one(self.alone, len(self.family), LINE_ACCURACY)


def family_frequency_response(
    family: Family, frequencies_hz, inputs, outputs, quantity: str, relative_to: str | None
) -> FamilyFrequencyResponse:
    """The frequency responses of all systems.

    Args:
        family: the systems.
        frequencies_hz, inputs, outputs, quantity, relative_to: as of ``Family.frequency_response``.

    Returns:
        A ``FamilyFrequencyResponse``.
    """
    frequencies = np.atleast_1d(real_array(frequencies_hz, "frequencies_hz"))
    first = family[0].frequency_response(frequencies, inputs, outputs, quantity, relative_to=relative_to)  # checks the arguments
    names = (first.inputs, first.outputs)
    values = np.empty((len(family), len(names[1]), len(names[0]), len(frequencies)), dtype=complex)
    errors = np.full((len(family), len(names[1]), len(names[0])), np.inf)
    if family.poles is not None and quantity in BY_POLES and not any(row.order for row in family.base.rows):
        arguments = _harmonic(family, names, quantity, relative_to)
        for begin in range(0, len(family), TOGETHER):
            at = slice(begin, begin + TOGETHER)
            values[at], errors[at] = _sums(family, at, *arguments, 2j * np.pi * frequencies, QUANTITIES[quantity].order)
    alone = np.flatnonzero(~(errors <= LINE_ACCURACY).all(axis=(1, 2)))
    for place in alone.tolist():
        H = first if not place else family[place].frequency_response(frequencies, *names, quantity, relative_to=relative_to)
        sizes = np.abs(H.values).max(axis=2, initial=0.0)
        absolute = np.where(H.values == 0, 0.0, np.abs(H.values) * H.error_estimate).max(axis=2, initial=0.0)
        values[place], errors[place] = H.values, absolute / np.where(sizes > 0, sizes, 1.0)
    return FamilyFrequencyResponse(family, frequencies, values, errors, *names, quantity, first.units, alone)


def _harmonic(family: Family, names, quantity: str, relative_to: str | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Forces by inputs (n, i), prescribed motions by inputs (n, i), outputs (o, n)."""
    base = family.base
    loads = chosen_by_name("inputs", names[0], channels(base, "inputs"), ())
    observed = chosen_by_name("outputs", names[1], channels(base, "outputs"), ())
    nothing = np.zeros(base.size)
    forces = np.array([one.direction if one.row is None else nothing for one in loads]).T
    motions = np.array([nothing if one.row is None else base.multiplier_map[one.row] for one in loads]).T
    outputs = np.array([one.direction for one in observed])
    if relative_to is not None:
        other = reference(base, relative_to)
        outputs = outputs - np.outer([one.unit == other.unit for one in observed], other.direction)
    return forces, motions, outputs


def _sums(family: Family, at: slice, forces, motions, outputs, s, order: int) -> tuple[np.ndarray, np.ndarray]:
    """Values and error estimates of some systems at s, shapes (S, o, i, F) and (S, o, i)."""
    poles = family.poles
    assert poles is not None
    M, C, K = family.matrices(at)
    loads = [forces - K @ motions] + [-(C @ motions), -(M @ motions)] * bool(motions.any())
    values, weights, left, direct = (getattr(poles, name)[at] for name in ("values", "weights", "left", "direct"))
    X = outputs @ poles.shapes[at]
    with np.errstate(all="ignore"):
        each = 1 / (s - values[:, :, None])
        mirrored = np.where(weights[:, :, None] == 2, 1 / (s - values[:, :, None].conj()), 0.0)
        each[weights == 0] = 0.0
        sizes = np.abs(each) + np.abs(mirrored)
        doubt = (2 * poles.shape_errors[at] + FORM_ROUNDING * EPS)[:, :, None] * sizes + (poles.value_errors[at] * np.abs(values))[
            :, :, None
        ] * sizes**2
        total: Any = (outputs @ motions)[:, :, None]
        error: Any = 0.0
        largest = np.abs(outputs) @ np.abs(poles.shapes[at]).max(axis=1, keepdims=True).repeat(family.base.size, axis=1)
        for power, load in enumerate(loads):
            rows = left @ load  # (S, P, i)
            residues = X[:, :, None, :] * rows.transpose(0, 2, 1)[:, None]  # (S, o, i, P)
            shape = (len(M), -1, residues.shape[3])
            part = residues.reshape(shape) @ each + residues.conj().reshape(shape) @ mirrored
            part = part.reshape(*residues.shape[:3], len(s)) + (outputs @ direct @ load)[..., None]
            total = total + part * s**power
            bound = largest[:, :, None, :] * np.abs(rows).transpose(0, 2, 1)[:, None]
            error = error + (bound.reshape(shape) @ doubt).reshape(*residues.shape[:3], len(s)) * np.abs(s) ** power
    total, error = total * s**order, error * np.abs(s) ** order
    peak = np.abs(total).max(axis=3, initial=0.0)
    relative = error.max(axis=3, initial=0.0) / np.where(peak > 0, peak, 1.0)
    served = poles.serve[at][:, None, None] & np.isfinite(total).all(axis=3)
    return total, np.where(served, relative + EPS, np.inf)
