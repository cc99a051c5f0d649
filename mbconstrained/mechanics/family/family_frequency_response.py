"""The frequency responses of a family of systems from the stacked poles and residues, of some systems one by one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...ground.checks import counted, real_array
from ...ground.display import Displayed, TextTable, notice_table
from ...ground.notices import Notice, doubts_of
from ...ground.tolerances import EPS, LINE_ACCURACY
from .family_modes import one_by_one
from .stacked_poles import TOGETHER
from .stacked_transfer import StackedTransfer
from .system_stack import SystemStack

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
        quantity: quantity of the response.
        units: units of the entries, shape (outputs, inputs).
        alone: places of the systems that were solved one by one.
    """

    family: SystemStack
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
        """Notices on systems solved one by one and on inaccurate values; values at a pole on the imaginary axis are infinite."""
        worst = self.error_estimate.max(initial=0.0, where=np.isfinite(self.error_estimate))
        return (*one_by_one(self.alone, len(self.family), LINE_ACCURACY), *doubts_of("the responses of a system", worst))


def family_frequency_response(
    family: SystemStack, frequencies_hz, inputs, outputs, quantity: str, relative_to: str | None
) -> FamilyFrequencyResponse:
    """The frequency responses of all systems."""
    frequencies = np.atleast_1d(real_array(frequencies_hz, "frequencies_hz"))
    first = family[0].frequency_response(frequencies, inputs, outputs, quantity, relative_to=relative_to)  # checks the arguments
    names = (first.inputs, first.outputs)
    values = np.empty((len(family), len(names[1]), len(names[0]), len(frequencies)), dtype=complex)
    errors = np.full((len(family), len(names[1]), len(names[0])), np.inf)
    at_level = quantity in BY_POLES and not any(row.order for row in family.base.rows)
    for begin in range(0, len(family) if at_level else 0, TOGETHER):
        at = slice(begin, begin + TOGETHER)
        transfer = StackedTransfer.of(family, at, first.harmonic, np.zeros(len(first.inputs)))
        if transfer is not None:
            values[at], absolute = transfer(2j * np.pi * frequencies)
            errors[at] = np.where(transfer.poles.serve[:, None, None], _relative(values[at], absolute), np.inf)
    alone = np.flatnonzero(~(errors <= LINE_ACCURACY).all(axis=(1, 2)))
    for place in alone.tolist():
        H = first if not place else family[place].frequency_response(frequencies, *names, quantity, relative_to=relative_to)
        values[place] = H.values
        errors[place] = _relative(H.values, np.where(H.values == 0, 0.0, np.abs(H.values) * H.error_estimate))
    return FamilyFrequencyResponse(family, frequencies, values, errors, *names, quantity, first.units, alone)


def _relative(values: np.ndarray, absolute: np.ndarray) -> np.ndarray:
    """Errors relative to the largest value of each row; infinite where one is not finite."""
    sizes = np.abs(values).max(axis=-1, initial=0.0)
    relative = absolute.max(axis=-1, initial=0.0) / np.where(sizes > 0, sizes, 1.0) + EPS
    return np.where(np.isfinite(relative) & np.isfinite(sizes), relative, np.inf)
