"""Many motions of one mechanical system at once: other starts, other forces, the same decomposition (``response.many``)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..checks import counted, real_array
from ..errors import InputError
from ..notices import Notice
from ..response.many import ManyFunctions, Responses, solve_many
from ..signals.impulsive import ImpulsiveSmooth
from .motion import Motion, motion_of

if TYPE_CHECKING:
    from .system import MechanicalSystem


@dataclass(frozen=True, repr=False)
class Motions:
    """S motions x_s(t): ``xs(t)`` has shape (S, n), ``xs(times)`` (S, n, T), ``xs[3]`` is one ``Motion``, as it is solved alone.

    Attributes:
        system: the system that moves.
        responses: the answers to its constrained form.
        applied: all forces on its n coordinates, S of them, its own included.
        rank_tolerance: as given.
    """

    system: MechanicalSystem
    responses: Responses
    applied: tuple[ImpulsiveSmooth, ...]
    rank_tolerance: float | None = None

    def __repr__(self) -> str:
        return f"{type(self).__name__}({counted(len(self), 'motion')} of {counted(self.system.size, 'coordinate')})"

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates."""
        return self.system.names

    def __len__(self) -> int:
        return len(self.applied)

    def __getitem__(self, index: int | slice) -> Motion | Motions:
        if isinstance(index, slice):
            return Motions(self.system, self.responses[index], self.applied[index], self.rank_tolerance)
        place = range(len(self))[index]  # IndexError where there is none
        return motion_of(self.system, self.responses.initial[place], self.applied[place], self.rank_tolerance)

    def __iter__(self) -> Iterator[Motion]:
        return (self[index] for index in range(len(self)))

    def __call__(self, times) -> np.ndarray:
        """x at a time (-> (S, n)) or at times (T,) (-> (S, n, T)); t = 0 means 0+."""
        return self.responses(times)

    def velocity(self, times) -> np.ndarray:
        """x' at a time (-> (S, n)) or at times (T,) (-> (S, n, T)), in m/s or rad/s."""
        return self.responses.derivative(1)(times)

    def acceleration(self, times) -> np.ndarray:
        """x'' at a time (-> (S, n)) or at times (T,) (-> (S, n, T)), in m/s^2 or rad/s^2."""
        return self.responses.derivative(2)(times)

    def derivative(self, order: int = 1) -> ManyFunctions:
        """The classical derivatives for t > 0, called like this itself."""
        return self.responses.derivative(order)

    def of(self, *coordinates: str | int) -> ManyFunctions:
        """Some coordinates only, by name or number from 0."""
        return self.responses.of(*coordinates)

    @property
    def jumps(self) -> np.ndarray:
        """Of x and x' at t = 0, shape (S, 2, n)."""
        return self.responses.jumps

    @property
    def notices(self) -> tuple[Notice, ...]:
        """What all have in common, and how many of them jump."""
        return self.responses.notices


def motions_of(system: MechanicalSystem, displacement, velocity, forces: list[ImpulsiveSmooth], rank_tolerance) -> Motions:
    """The motions from displacements and velocities of shape (S, n) or (n,), which S motions have in common, as forces may be.

    Raises:
        InputError: not as many of one as of another.
    """
    given = [_rows(displacement, "displacement", system), _rows(velocity, "velocity", system)]
    counts = {"displacement": len(given[0]), "velocity": len(given[1]), "force": len(forces)}
    count = max(counts.values()) if all(counts.values()) else 0
    if not count or set(counts.values()) - {1, count}:
        found = ", ".join(f"{number} of {name}" for name, number in counts.items())
        raise InputError(f"several motions: found {found}; give as many of each, or one for all")
    start = np.stack([np.broadcast_to(rows, (count, system.size)) for rows in given], axis=1)
    form = system.constrained_form()
    held = {id(force): form.force(force) for force in forces}
    right = [held[id(force)] for force in forces]
    responses = solve_many(form.polynomial_matrix, start, right if len(right) > 1 else right * count, rank_tolerance)
    return Motions(system, responses, tuple(forces) if len(forces) > 1 else tuple(forces) * count, rank_tolerance)


def _rows(values, what: str, system: MechanicalSystem) -> np.ndarray:
    """Of shape (S, n), S = 1 where they are common to all."""
    if np.ndim(values) == 2:
        return real_array(values, what, shape=(None, system.size))
    return system._vector(values, what)[None]
