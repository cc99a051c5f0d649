"""The motion of a system of sparse matrices in its modes of lowest frequency, with a bound on the rest."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse
from scipy.sparse.linalg import splu

from ...ground.checks import counted, places_of
from ...ground.display import Displayed, TextTable, notice_table
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, NOISE_SAFETY, ROUNDED_FREE, noise_of
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import step
from ..equations import EquationsOfMotion
from ..motion import SystemMotion
from ..reaction import FunctionSum
from .modal_space import Amplitudes, ModeSpace, mode_space
from .pencil import ReducedPencil
from .sparse_matrices import times
from .static_correction import Remainder, StaticCorrection, remainder
from .undamped_modes import undamped_modes


@dataclass(frozen=True, repr=False, eq=False)
class SparseMotion(SystemMotion, Displayed):
    """x(t) = W a(t) + X z(t) + x_0 + x_rest(t): kept modes, static correction, constrained displacement, and a bounded rest.

    W, a: shapes and amplitudes of the kept modes; z: states of the force, z' = J z; X: the response of all other modes to it. The
    values leave out x_rest, a free motion of the other modes, whose energy E is bounded: sqrt(2 E) <= ``rest_norm``.

    Attributes:
        system: the system that moves.
        applied: all forces f on its n coordinates.
        amplitudes: a and z in closed form.
        shapes: W and X side by side, shape (n, w + s).
        offset: x_0, a displacement with the values of all constraint rows, shape (n,).
        rest_norm: (2 E)^(1/2) in J^(1/2), an upper bound of the energy norm of x_rest for all times.
        truncation: the bound relative to the energy norm of the whole motion.
        bounded: whether the bound is valid for all times, as damping and stiffness supply no energy; otherwise at t = 0 only.
        notices: the size of the rest, jumps of massless coordinates, redundant rows.
    """

    system: EquationsOfMotion
    applied: ImpulsiveSmooth
    amplitudes: BohlFunction
    shapes: np.ndarray
    offset: np.ndarray
    rest_norm: float
    truncation: float
    bounded: bool
    notices: tuple[Notice, ...]
    space: ModeSpace
    left: StaticCorrection

    def _summary(self) -> str:
        kept, size = counted(len(self.space.blocks), "mode"), counted(self.system.size, "coordinate")
        return f"{kept} of {size}, truncation {self.truncation:.2g}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def __call__(self, times) -> np.ndarray:
        """x at a time (-> (n,)) or at times (T,) (-> (n, T)), in m or rad; t >= 0, t = 0 means 0+."""
        values = self.shapes @ self.amplitudes(times)
        return values + (self.offset if values.ndim == 1 else self.offset[:, None])

    def _rate(self, order: int, times) -> np.ndarray:
        return self.shapes @ self.amplitudes.derivative(order)(times) if order else self(times)

    def of(self, *coordinates: str | int) -> BohlFunction:
        """The function of some coordinates only, by name or number from 0, a row for each: no other is computed."""
        places = places_of(coordinates, self.names, "coordinate")
        function = self.amplitudes.mapped(self.shapes[places])
        offset = self.offset[places]
        return function + step(offset).smooth if offset.any() else function

    @property
    def row_names(self) -> tuple[str, ...]:
        """The independent constraint rows, in the order of the multipliers."""
        pencil = self.system.pencil
        return tuple(pencil.constraints.names[place] for place in pencil.independent)

    def reaction(self, times) -> np.ndarray:
        """The multipliers lambda of the independent constraint rows, M x'' + C x' + K x = f + A^T lambda; without those of x_rest."""
        return self.reaction_function(times)

    @cached_property
    def reaction_function(self) -> BohlFunction:
        """lambda for t > 0 in closed form, k rows."""
        pencil, system, force = self.system.pencil, self.system, self.applied.smooth
        A = pencil.constraints.matrix[pencil.independent]
        gram = splu(scipy.sparse.csc_array(A @ A.T)) if A.shape[0] else None

        def multipliers(columns) -> np.ndarray:
            forces = np.asarray(A @ columns)
            return forces if gram is None else gram.solve(forces)

        matrices = (system.stiffness, system.damping, system.mass)
        inertial = self.amplitudes.differential(*(multipliers(matrix @ self.shapes) for matrix in matrices))
        return FunctionSum([inertial, BohlFunction(-multipliers(force.coefficients), force.blocks, force.start)])

    def error_estimate(self, times) -> float:
        """Estimate of the rounding error, max |error| / max |x|; x_rest, which is left out, has its own ``bound``.

        Rounding errors of M, C, K change the eigenvalues, and so the phases by their error times t, and what the springs of a free
        body leave of their sums moves it in the end; sums and shapes add their own.
        """
        times = np.atleast_1d(times)
        parts, own = np.abs(self.amplitudes(times)), len(self.space.places)
        parts[:own] *= self.space.relative_errors(times)
        parts[own:] *= NOISE_SAFETY * EPS
        largest = np.abs(self(times)).max(initial=0.0)
        return float((np.abs(self.shapes) @ parts).max(initial=0.0) / largest) if largest else 0.0

    def bound(self, *coordinates: str | int) -> np.ndarray:
        """An upper bound of |x_rest| at each of some coordinates, by name or number from 0, for all times, shape (p,).

        |x_i| <= (e_i^T F e_i)^(1/2) rest_norm, F the flexibility that the kept modes leave (all of it where damping couples them):
        one sparse solution for each coordinate.
        """
        places = places_of(coordinates, self.names, "coordinate")
        return np.array([self._flexibility(place) ** 0.5 * self.rest_norm for place in places])

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


def sparse_motion(system: EquationsOfMotion, start: np.ndarray, applied: ImpulsiveSmooth, count: int) -> SparseMotion:
    """The motion from x(0-), x'(0-) in the rows of start, shape (2, n)."""
    if any(impulse.any() for impulse in applied.impulses) or applied.later:
        raise InputError(
            "force: Dirac impulses are not available for sparse matrices; give the velocity that the impulse causes, or a pulse"
        )
    pencil = system.pencil
    offset = _constrained_displacement(pencil)
    if offset.any():
        applied = applied + step(-(system.stiffness @ offset))
    displacement, velocity = _free_start(pencil, start, offset)
    undamped = undamped_modes(pencil, count)
    space = mode_space(pencil, undamped)
    left = StaticCorrection(pencil, undamped, space)
    smooth = applied.smooth
    forces = np.asarray(pencil.basis.T @ smooth.coefficients)
    followed = left.followed(forces, smooth.blocks)
    amplitudes = Amplitudes(space, space.initial_states(pencil, displacement, velocity), space.modal_forces(forces), smooth)
    rest = remainder(left, displacement, velocity, amplitudes, followed, smooth)
    shapes = times(pencil.basis, np.hstack([space.shapes, followed]))
    notices = (*system.notices, *_notices(rest, space, count))
    return SparseMotion(
        system, applied, amplitudes.function, shapes, offset, rest.norm, rest.relative, rest.passive, notices, space, left
    )


def _constrained_displacement(pencil: ReducedPencil) -> np.ndarray:
    """A displacement with the values of all constraint rows."""
    if not pencil.row_values.any():
        return pencil.offset
    rows = pencil.rows
    return pencil.offset + pencil.basis @ (rows.T @ np.linalg.solve((rows @ rows.T).toarray(), pencil.row_values))


def _notices(rest: Remainder, space: ModeSpace, count: int):
    if rest.jumps:
        yield Notice(NoticeKind.JUMP, "massless coordinates jump at t = 0 to their equilibrium between the springs")
    if space.left_out:
        yield Notice(NoticeKind.ACCURACY, f"{space.left_out} damped modes did not converge and count as part of the rest")
    if (support := space.supports.max(initial=0.0)) > 0:
        since = (2 * ROUNDED_FREE / support) ** 0.5
        text = (
            "the springs on a free body cancel up to rounding errors of their sums, which count as zero; if they are the support that "
            f"they are, x differs by {ROUNDED_FREE:g} of itself and more from t = {since:.3g} s on"
        )
        yield Notice(NoticeKind.RANK, text)
    if rest.norm:
        when = "for all times" if rest.passive else "at t = 0; later it may grow, as damping or stiffness supply energy"
        text = (
            f"the motion outside of these modes has an energy of at most {rest.norm**2 / 2:.3g} J, {rest.relative:.2g} of all in "
            f"the energy norm, {when}; increase count above {count} to include more of it"
        )
        yield Notice(NoticeKind.OMITTED, text, doubtful=not rest.passive)


def _free_start(pencil: ReducedPencil, start: np.ndarray, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x - x_0 and x' at 0- on the free coordinates."""
    A, names = pencil.constraints.matrix, pencil.constraints.names
    free = []
    for what, given, constant, values in (
        ("displacement", start[0], offset, pencil.constraints.values),
        ("velocity", start[1], np.zeros(len(offset)), np.zeros(len(names))),
    ):
        violation = A @ given - values
        largest = np.abs(given).max(
            initial=0.0
        )  # a vector projected on the constraints has the rounding error of its largest entry
        size = abs(A) @ (largest + np.abs(constant)) + np.abs(values)
        beyond = np.abs(violation) > noise_of(size, int(np.diff(A.indptr).max(initial=1)))
        if beyond.any():
            worst = int(np.argmax(np.abs(violation) * beyond))
            raise InputError(
                f'{what}: constraint "{names[worst]}" has the value {values[worst]:.6g}, the values at 0- give '
                f"{values[worst] + violation[worst]:.6g}; give consistent values, as the motion of sparse matrices has no jumps"
            )
        free.append((given - constant)[pencil.free])
    return free[0], free[1]
