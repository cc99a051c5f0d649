"""The modes of a family of systems: eigenvalues and shapes from the stacked poles, of some systems one by one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import counted
from ...ground.display import Displayed, TextTable, notice_table
from ...ground.notices import Notice, NoticeKind, doubts_of
from ...ground.tolerances import EPS, PROVED_ACCURACY
from ..modes import Modes
from .stacked_poles import StackedPoles

if TYPE_CHECKING:
    from .family import Family


@dataclass(frozen=True, repr=False, eq=False)
class FamilyModes(Displayed):
    """The modes of S systems; ``modes[3]`` are the ``Modes`` of one, with kinds, energies and tables.

    Attributes:
        family: the systems.
        eigenvalues: in 1/s as ``Modes.eigenvalues``, ascending by modulus, shape (S, P); NaN where a system has fewer.
        shapes: the largest entry of each 1, shape (S, n, P).
        error_estimate: of the eigenvalues, relative, shape (S, P).
        alone: places of the systems that were solved one by one.
    """

    family: Family
    eigenvalues: np.ndarray
    shapes: np.ndarray
    error_estimate: np.ndarray
    alone: np.ndarray

    def _summary(self) -> str:
        return f"modes of {counted(len(self.family), 'system')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def __len__(self) -> int:
        return len(self.family)

    def __getitem__(self, index: int) -> Modes:
        return self.family[index].modes()

    @property
    def notices(self) -> tuple[Notice, ...]:
        """How many systems were solved one by one, and eigenvalues that are not accurate."""
        worst = np.nanmax(self.error_estimate, initial=0.0)
        return (*one_by_one(self.alone, len(self.family)), *doubts_of("the eigenvalues of a system", worst))

    @property
    def natural_frequencies(self) -> np.ndarray:
        """|s| of the oscillating modes in rad/s, ascending, shape (S, m); NaN where a system has fewer."""
        return self._oscillating(np.abs(self.eigenvalues))

    @property
    def frequencies_hz(self) -> np.ndarray:
        """``natural_frequencies`` / (2 pi), in Hz."""
        return self.natural_frequencies / (2 * np.pi)

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s / |s| of the oscillating modes, shape (S, m)."""
        moduli = np.abs(self.eigenvalues)
        return self._oscillating(-self.eigenvalues.real / np.where(moduli > 0, moduli, 1.0))

    def _oscillating(self, values: np.ndarray) -> np.ndarray:
        oscillates = np.nan_to_num(self.eigenvalues.imag) != 0
        order = np.argsort(~oscillates, axis=1, kind="stable")
        chosen = np.take_along_axis(np.where(oscillates, values, np.nan), order, axis=1)
        return chosen[:, : int(oscillates.sum(axis=1).max(initial=0))]


def family_modes(family: Family) -> FamilyModes:
    """The modes of all systems.

    Args:
        family: the systems.

    Returns:
        ``FamilyModes``.
    """
    poles, count = family.poles, len(family)
    serve = np.zeros(count, dtype=bool)
    if poles is not None:
        serve = poles.serve & (poles.value_errors <= PROVED_ACCURACY).all(axis=1)
    alone = {place: family[place].modes() for place in np.flatnonzero(~serve).tolist()}
    drift = sum(row.order for row in family.base.rows)
    width = max([0, *(len(modes.eigenvalues) for modes in alone.values())])
    if poles is not None and serve.any():
        width = max(width, poles.values.shape[1] + drift)
    values = np.full((count, width), np.nan, dtype=complex)
    errors, shapes = np.full((count, width), np.nan), np.full((count, family.base.size, width), np.nan, dtype=complex)
    if poles is not None and serve.any():
        _sort_into(values, errors, shapes, poles, serve, drift)
    for place, modes in alone.items():
        own = modes.eigenvalues
        values[place, : len(own)], errors[place, : len(own)] = (
            own,
            np.repeat(np.maximum(modes.residuals, EPS), [mode.multiplicity for mode in modes]),
        )
        repeated = [
            mode.shapes[:, [min(i, mode.shapes.shape[1] - 1)]] if mode.shapes.size else np.full((family.base.size, 1), np.nan)
            for mode in modes
            for i in range(mode.multiplicity)
        ]
        if repeated:
            shapes[place, :, : len(own)] = np.hstack(repeated)
    return FamilyModes(family, values, shapes, errors, np.array(sorted(alone), dtype=int))


def _sort_into(values, errors, shapes, poles: StackedPoles, serve: np.ndarray, drift: int) -> None:
    """The poles of the systems that serve, ascending by modulus after eigenvalues 0 of drift, their shapes with largest entry 1."""
    own = np.where(poles.weights > 0, poles.values, np.inf)
    order = np.argsort(np.abs(own), axis=1, kind="stable")
    ordered = np.take_along_axis(own, order, axis=1)
    absent = ~np.isfinite(ordered.real)
    ordered[absent] = np.nan
    sizes = np.take_along_axis(poles.value_errors, order, axis=1)
    sizes[absent] = np.nan
    X = np.take_along_axis(poles.shapes, order[:, None, :], axis=2)
    largest = np.take_along_axis(X, np.abs(X).argmax(axis=1)[:, None, :], axis=1)
    with np.errstate(all="ignore"):
        X = np.where(absent[:, None, :], np.nan, X / largest)
    columns = slice(drift, drift + ordered.shape[1])
    values[serve, :drift], errors[serve, :drift] = 0.0, 0.0
    values[serve, columns], errors[serve, columns] = ordered[serve], sizes[serve]
    shapes[serve, :, columns] = X[serve].transpose(0, 1, 2)


def one_by_one(places: np.ndarray, count: int, limit: float = PROVED_ACCURACY) -> tuple[Notice, ...]:
    """A notice of systems that stacks of matrices do not serve.

    Args:
        places: of those systems.
        count: of all.
        limit: of the estimate.

    Returns:
        One notice, or none.
    """
    if not len(places):
        return ()
    text = f"{counted(len(places), 'system')} of {count} solved one by one: another structure than the first, or an estimate above {limit:g}"
    return (Notice(NoticeKind.ACCURACY, text),)
