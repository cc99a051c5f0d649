"""What acts on a system: vectors by place or by name, forces that are constant or functions of time."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..checks import nearest, real_array, real_number
from ..errors import InputError
from ..signals.inputs import ImpulsiveSmooth, step, zero


class Loaded:
    """A system with ``size`` coordinates and their ``names``, and what acts on it.

    Attributes:
        static_force: constant vector (n,).
        drive: what acts besides, None where nothing does.
    """

    size: int
    names: tuple[str, ...]
    static_force: np.ndarray
    drive: ImpulsiveSmooth | None

    @property
    def force(self) -> ImpulsiveSmooth:
        """All that acts from t = 0 on without being asked: the static force as a step, and the drive."""
        static = step(self.static_force) if self.static_force.any() else zero(self.size)
        return static if self.drive is None else static + self.drive

    def place(self, name, what: str) -> int:
        """The number of a coordinate given by name.

        Raises:
            InputError: there is none of this name.
        """
        if name not in self.names:
            raise InputError(f'{what}: there is no coordinate "{name}"{nearest(name, self.names)}')
        return self.names.index(name)

    def _load(self, force, static_force) -> None:
        """Keep a force that is constant or a function of time, and a constant one."""
        self.static_force, self.drive = self._vector(static_force, "static_force"), None
        if isinstance(force, ImpulsiveSmooth):
            self.drive = self._signal(force, "force")
        else:
            self.static_force = self.static_force + self._vector(force, "force")
        self.static_force.flags.writeable = False

    def _applied(self, force) -> ImpulsiveSmooth:
        """The system's own force and another, as a function of time or a constant vector."""
        if force is None:
            return self.force
        if not isinstance(force, ImpulsiveSmooth):
            force = step(self._vector(force, "force"))
        return self.force + self._signal(force, "force")

    def _signal(self, signal: ImpulsiveSmooth, what: str) -> ImpulsiveSmooth:
        if signal.size != self.size:
            raise InputError(f"{what}: it has {signal.size} rows; expected one for each of the {self.size} coordinates")
        return signal

    def _vector(self, value, what: str) -> np.ndarray:
        if value is None:
            return np.zeros(self.size)
        if not isinstance(value, Mapping):
            return real_array(value, what, shape=(self.size,))
        vector = np.zeros(self.size)
        for name, number in value.items():
            vector[self.place(name, what)] = real_number(number, f"{what} of {name}")
        return vector
