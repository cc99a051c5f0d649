"""Participation factors and effective masses of modes under a moving base."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...ground.checks import counted, nearest
from ...ground.display import Displayed, TextTable, number_text
from ...ground.errors import InputError
from ...ground.tolerances import noise_of
from ..element_matrix import check_orthogonal, mass_normalized, static_response
from ..equations import EquationsOfMotion


@dataclass(frozen=True, repr=False, eq=False)
class EffectiveMasses(Displayed):
    """Shares of the modes without damping in the motion under a base that moves along each of d directions.

    Attributes:
        directions, units: directions and units of the base's motion, and of its masses ("kg"; "kg m^2" of a base that turns).
        frequencies_hz: frequencies of the modes, shape (m,).
        participation_factors: Gamma = u^T h with u^T M u = 1, shape (m, d).
        masses: Gamma^2, shape (m, d).
        totals: totals of all motions relative to the base, shape (d,), including those of free and unstable motions.
    """

    directions: tuple[str, ...]
    units: tuple[str, ...]
    frequencies_hz: np.ndarray
    participation_factors: np.ndarray
    totals: np.ndarray

    @property
    def masses(self) -> np.ndarray:
        """The effective masses."""
        return self.participation_factors**2

    def _summary(self) -> str:
        return f"{counted(len(self.directions), 'direction')}, {counted(len(self.frequencies_hz), 'mode')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (self.table(),)

    def table(self) -> TextTable:
        """The masses of every mode, with the share of all modes up to it in the total."""
        scale = np.where(self.totals > 0, self.totals, 1.0)
        masses = np.where(self.masses > noise_of(scale, len(self.masses)), self.masses, 0.0)
        shares = 100 * np.cumsum(masses, axis=0) / scale
        rows = [
            (str(number), number_text(f), *(f"{mass:.4g} ({share:.1f} %)" for mass, share in zip(own, sums)))
            for number, (f, own, sums) in enumerate(zip(self.frequencies_hz, masses, shares), start=1)
        ]
        rows.append(("all", "", *(f"{total:.4g}" for total in self.totals)))
        titles = (f"{name} ({unit})" for name, unit in zip(self.directions, self.units))
        note = "oscillations without damping, by frequency; all: of all motions relative to the base; in brackets: the share up to here"
        return TextTable("Effective modal masses", ("mode", "Hz", *titles), tuple(rows), note)

    def as_json(self) -> dict:

        return {
            "directions": list(self.directions),
            "units": list(self.units),
            "frequencies_hz": self.frequencies_hz.tolist(),
            "masses": self.masses.tolist(),
            "totals": self.totals.tolist(),
        }


def effective_masses(
    system: EquationsOfMotion, directions: Sequence[str], units: Sequence[str], loads: np.ndarray
) -> EffectiveMasses:
    """Effective masses from the inertial loads h of unit accelerations of the base.

    sum of Gamma_i^2 = h^T V (V^T M V)^+ V^T h,      V a basis of the motions that the constraint rows allow
    """
    check_orthogonal("effective masses", system.mass, system.stiffness)
    modes = system.modes(damped=False)
    w = modes.natural_frequencies
    V = system.constrained_form().null_space
    reduced = V.T @ loads
    totals = np.einsum("id,id->d", reduced, np.linalg.pinv(V.T @ system.mass @ V, hermitian=True) @ reduced)
    factors = mass_normalized(system.mass, modes.shapes.real, w).T @ loads
    return EffectiveMasses(tuple(directions), tuple(units), w / (2 * np.pi), factors, totals)


def loads_of_rows(system: EquationsOfMotion, base) -> tuple[tuple[str, ...], list[str], np.ndarray]:
    """The inertial loads M r of unit motions r of rows."""
    rows = [row.name for row in system.rows]
    names = rows if base is None else base if isinstance(base, Iterable) and not isinstance(base, str) else [base]
    groups = {name: [name] for name in names} if not isinstance(names, Mapping) else names
    groups = {name: [group] if isinstance(group, str) else list(group) for name, group in groups.items()}
    for name in (name for group in groups.values() for name in group):
        if name not in rows:
            raise InputError(f"base: there is no constraint row {name!r}{nearest(str(name), rows)}")
    if not all(groups.values()) or not groups:
        raise InputError("base: the system has no constraint rows; expected rows that prescribe the motion of the supports")
    influence = static_response(system.stiffness, system.constraint_matrix)
    chosen = [[rows.index(name) for name in group] for group in groups.values()]
    units = ["kg m^2" if system.rows[places[0]].unit == "rad" else "kg" for places in chosen]
    loads = system.mass @ np.array([influence[:, places].sum(axis=1) for places in chosen]).T
    return tuple(groups), units, loads
