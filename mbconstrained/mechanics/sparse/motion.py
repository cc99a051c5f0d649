"""The motion of a large sparse system in its modes of lowest frequency, and a bound on what the others carry."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...notices import Notice
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import step
from .amplitudes import Amplitudes
from .carried import LeftOut
from .energy import Remainder, remainder
from .matrices import times
from .space import ModeSpace, mode_space
from .starts import checked_start

if TYPE_CHECKING:
    from .system import SparseSystem


@dataclass(frozen=True, repr=False)
class SparseMotion:
    """x(t) = W a(t) + X z(t) + x_held + x_rest(t): kept modes, what follows the force, held values, and what is left out.

    W, a: shapes and amplitudes of the kept modes; z: states of the force, z' = J z; X: how all other modes follow it. What is
    evaluated is without x_rest, a free motion of the other modes, whose energy is bounded: sqrt(2 E) <= ``rest_norm``.

    Attributes:
        system: the system that moves.
        applied: all forces f on its n coordinates.
        amplitudes: a and z in closed form.
        shapes: W and X side by side, shape (n, w + s).
        held: x_held, shape (n,), the values that constraints hold.
        rest_norm: (2 E)^(1/2) in J^(1/2), an upper bound of the energy norm of x_rest for all times.
        truncation: the same, relative to the energy norm of all that moves.
        bounded: whether the bound holds for all times, as damping and stiffness put no energy in; otherwise at t = 0 alone.
        notices: what is left out, and what the modes had to tell.
    """

    system: SparseSystem
    applied: ImpulsiveSmooth
    amplitudes: BohlFunction
    shapes: np.ndarray
    held: np.ndarray
    rest_norm: float
    truncation: float
    bounded: bool
    notices: tuple[Notice, ...]
    space: ModeSpace
    left: LeftOut

    def __repr__(self) -> str:
        return f"SparseMotion({len(self.space.blocks)} modes of {self.system.size} coordinates, left out {self.truncation:.2g})"

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates, in the order of the rows of x."""
        return self.system.names

    def __call__(self, times, of=None) -> np.ndarray:
        """x at a time (-> (p,)) or at times (T,) (-> (p, T)); t >= 0, t = 0 means 0+.

        Args:
            times: in s.
            of: names or numbers (from 0) of p coordinates; all n when not given.

        Raises:
            InputError: negative times, unknown coordinates.
        """
        places = self._places(of)
        held = self.held[places]
        found = self._shown(self.amplitudes, times, places)
        return found + (held if found.ndim == 1 else held[:, None])

    def velocity(self, times, of=None) -> np.ndarray:
        """x' at a time or at times, as for displacements."""
        return self._shown(self.amplitudes.derivative(1), times, self._places(of))

    def acceleration(self, times, of=None) -> np.ndarray:
        """x'' at a time or at times, as for displacements."""
        return self._shown(self.amplitudes.derivative(2), times, self._places(of))

    def bound(self, of) -> np.ndarray:
        """An upper bound of |x_rest| at each of some coordinates, for all times, shape (p,).

        |x_i| <= (e_i^T F e_i)^(1/2) rest_norm, F the flexibility that the kept modes leave (all of it where damping couples them):
        one sparse solution for each coordinate.

        Args:
            of: names or numbers (from 0) of p coordinates.
        """
        return np.array([self._flexibility(place) ** 0.5 * self.rest_norm for place in np.atleast_1d(self._places(of))])

    def _flexibility(self, place) -> float:
        """e_i^T F e_i."""
        if not self.rest_norm:
            return 0.0
        pencil, space = self.system.pencil, self.space
        unit = pencil.basis[[int(place)], :].toarray()[0]
        if space.modal:
            unit = unit - pencil.mass @ (space.shapes @ (space.shapes.T @ unit))
            return max(float(unit @ self.left.solved(0j, unit.astype(complex)).real), 0.0)
        if (self.left.undamped.values <= 0).any():
            return np.inf
        return max(float(unit @ self.left.quadratic.factors(0.0).solve(unit).real), 0.0)

    def _shown(self, amplitudes: BohlFunction, times, places) -> np.ndarray:
        return self.shapes[places] @ amplitudes(times)

    def _places(self, of):
        if of is None:
            return slice(None)
        size = self.system.size
        found = []
        for item in [of] if isinstance(of, (str, int, np.integer)) else of:
            if isinstance(item, (int, np.integer)) and not isinstance(item, bool):
                if not 0 <= item < size:
                    raise InputError(f"of: found coordinate number {item}; expected one from 0 to {size - 1}")
                found.append(int(item))
            else:
                found.append(self.system.place(item, "of"))
        return np.array(found, dtype=int)


def sparse_motion(system: SparseSystem, start: np.ndarray, applied: ImpulsiveSmooth, count: int) -> SparseMotion:
    """The motion from x(0-), x'(0-) in the rows of start, shape (2, n)."""
    if any(impulse.any() for impulse in applied.impulses) or applied.later:
        raise InputError(
            "force: Dirac impulses are not taken by large sparse systems; give the velocity that a blow causes, or a short pulse"
        )
    pencil = system.pencil
    held = _held(system)
    if held.any():
        applied = applied + step(-(system.stiffness @ held))
    displacement, velocity = checked_start(system, start, held)
    undamped = system.undamped(count)
    space = mode_space(pencil, undamped)
    left = LeftOut(pencil, undamped, space)
    smooth = applied.smooth
    forces = np.asarray(pencil.basis.T @ smooth.coefficients)
    followed = left.followed(forces, smooth.blocks)
    amplitudes = Amplitudes(space, space.started(pencil, displacement, velocity), space.drive(forces), smooth)
    rest = remainder(left, displacement, velocity, amplitudes, followed, smooth)
    shapes = times(pencil.basis, np.hstack([space.shapes, followed]))
    notices = (*system.notices, *_notices(rest, space, count))
    return SparseMotion(
        system, applied, amplitudes.function, shapes, held, rest.norm, rest.relative, rest.passive, notices, space, left
    )


def _held(system: SparseSystem) -> np.ndarray:
    """A displacement that has the values of all constraint rows."""
    pencil = system.pencil
    if not pencil.row_values.any():
        return pencil.offset
    rows = pencil.rows
    return pencil.offset + pencil.basis @ (rows.T @ np.linalg.solve((rows @ rows.T).toarray(), pencil.row_values))


def _notices(rest: Remainder, space: ModeSpace, count: int):
    if rest.jumps:
        yield Notice("jump", "coordinates without mass jump at t = 0 to where the springs hold them")
    if space.left_out:
        yield Notice("accuracy", f"{space.left_out} damped modes did not converge and are counted as left out")
    if rest.norm:
        when = "for all times" if rest.passive else "at t = 0; later it may grow, as damping or stiffness put energy in"
        text = (
            f"what is not in these modes moves with an energy of at most {rest.norm**2 / 2:.3g} J, {rest.relative:.2g} of all in "
            f"the energy norm, {when}; ask for more than {count} modes to have more of it"
        )
        yield Notice("left out", text, doubtful=not rest.passive)


