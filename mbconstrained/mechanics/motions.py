"""Many motions of one mechanical system at once, of several initial values or forces, by one decomposition (``response.solve``)."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..ground.checks import counted, item_of, real_array
from ..ground.errors import InputError
from ..ground.named_arrays import named_array
from ..response.choose import Request
from ..response.solve import Responses, solve_many
from ..signals.impulsive import ImpulsiveSmooth
from .equations import EquationsOfMotion
from .motion import Motion, SystemMotion, motion_of


@dataclass(frozen=True, repr=False, eq=False, kw_only=True)
class Motions(SystemMotion, Responses):
    """S motions x_s(t): ``xs(t)`` has shape (S, n), ``xs(times)`` (S, n, T), ``xs[3]`` is one ``Motion``.

    Attributes:
        system: the system that moves.
        applied: all forces on its n coordinates, S of them, its own included.
    """

    system: EquationsOfMotion
    applied: tuple[ImpulsiveSmooth, ...]

    _coordinate_axis = 1

    def _summary(self) -> str:
        return f"{counted(len(self), 'motion')} of {counted(self.system.size, 'coordinate')}"

    def __getitem__(self, index: int | slice) -> Motion | Any:
        if isinstance(index, slice):
            return replace(self, initial=self.initial[index], forces=self.forces[index], applied=self.applied[index])
        place = item_of(index, len(self), "motion")
        return motion_of(self.system, self.initial[place], self.applied[place], self.rank_tolerance, self.request)

    def reaction(self, times) -> np.ndarray:
        """The multipliers lambda at a time (-> (S, k)) or at times (T,) (-> (S, k, T)), as ``Motion.reaction``."""
        system, G = self.system, self.system.multiplier_map
        terms = ((system.stiffness, self), (system.damping, self.velocity), (system.mass, self.acceleration))
        total = sum(np.einsum("kn,sn...->sk...", G @ matrix, of(times)) for matrix, of in terms)
        forces = {id(force): G @ force(times) for force in self.applied}
        values = total - np.array([forces[id(force)] for force in self.applied])
        return named_array(values, (), tuple(row.name for row in system.rows))


def motions_of(
    system: EquationsOfMotion, displacement, velocity, forces: list[ImpulsiveSmooth], rank_tolerance, request: Request
) -> Motions:
    """The motions from displacements and velocities of shape (S, n), or (n,) for all motions, and from S forces or one."""
    states = [_rows(displacement, "displacement", system), _rows(velocity, "velocity", system)]
    counts = {"displacement": len(states[0]), "velocity": len(states[1]), "force": len(forces)}
    count = max(counts.values()) if all(counts.values()) else 0
    if not count or set(counts.values()) - {1, count}:
        given = ", ".join(f"{number} of {name}" for name, number in counts.items())
        raise InputError(f"several motions: found {given}; give as many of each, or one for all")
    start = np.stack([np.broadcast_to(rows, (count, system.size)) for rows in states], axis=1)
    form = system.constrained_form()
    sides = {id(force): form.force(force) for force in forces}
    right = [sides[id(force)] for force in forces]
    responses = solve_many(form.polynomial_matrix, start, right if len(right) > 1 else right * count, rank_tolerance, request)
    fields = {one.name: getattr(responses, one.name) for one in dataclasses.fields(responses)}
    return Motions(system=system, applied=tuple(forces) if len(forces) > 1 else tuple(forces) * count, **fields)


def _rows(values, what: str, system: EquationsOfMotion) -> np.ndarray:
    """Values of shape (S, n), with S = 1 where they are common to all motions."""
    if np.ndim(values) == 2:
        return real_array(values, what, shape=(None, system.size))
    return system._vector(values, what)[None]
