"""The motions of a family of systems, functions of time, by stacked matrix exponentials, of some systems one by one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from ...frequency.shock.extrema import Extrema, RootMeanSquares, extrema, root_mean_squares
from ...ground.checks import counted, evaluation_times, places_of, real_array
from ...ground.display import Displayed
from ...ground.errors import MbconstrainedError, Overflow
from ...ground.tolerances import EPS, FORM_ROUNDING, LOCATED, MOVED_DATA, PROVED_ACCURACY, noise_of
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import step
from ..constraints import right_sides
from ..motion import Motion
from .stacked_equations import stacked_equations
from .stacked_motion import StackedFlow, stacked_flow
from .stacked_poles import TOGETHER
from .system_stack import SystemStack

#: Times at which moved data are compared, about.
TRIAL_TIMES = 32

#: The generator is moved by so many rounding errors of squarings, with so many patterns of signs: one alone may by chance leave the motion as it is.
SQUARED, TRIALS = 2.0, 2


@dataclass(frozen=True, repr=False, eq=False)
class FamilyMotion(Displayed):
    """The motions of S systems: ``motions(t)`` has shape (S, n), ``motions(times)`` (S, n, T), ``motions[3]`` is one ``Motion``.

    Attributes:
        family: the systems.
        initial: x and x' at 0-, shape (S, 2, n).
        force: in addition to the static force, common to all.
        outputs: places of the coordinates that are given.
    """

    family: SystemStack
    initial: np.ndarray
    force: ImpulsiveSmooth
    outputs: tuple[int, ...] | None = field(default=None)

    def _summary(self) -> str:
        return f"motions of {counted(len(self.family), 'system')}"

    def __len__(self) -> int:
        return len(self.family)

    def __getitem__(self, index: int) -> Motion:
        place = range(len(self))[index]
        system = self.family[place]
        added = self.force if system.excitation is None else self.force - system.excitation
        return system.solve(self.initial[place, 0], self.initial[place, 1], added)

    def of(self, *coordinates: str | int) -> FamilyMotion:
        """Return the function of some coordinates, by name or index from 0."""
        places = places_of(coordinates, self.family.base.names, "coordinate")
        return FamilyMotion(self.family, self.initial, self.force, tuple(int(place) for place in places))

    def __call__(self, times) -> np.ndarray:
        """x at a time (-> (S, n)) or at times (T,) (-> (S, n, T)); t = 0 means 0+.

        Raises:
            InputError: negative or not finite times.
            Overflow: a value leaves the range of float64.
        """
        return self.evaluate(times)[0]

    def velocity(self, times) -> np.ndarray:
        """x' at a time or at times."""
        return self.evaluate(times, 1)[0]

    def error_estimate(self, times) -> np.ndarray:
        """Estimates of max |error| / max |x| over the times, shape (S,)."""
        return self.evaluate(times)[1]

    def evaluate(self, times, order: int = 0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Values, their error estimates, and which systems were solved one by one.

        The estimate is a multiple of the differences, at some times, that moving each entry of M, C and K by its rounding error makes, and moving the
        generator by the rounding errors of squarings: stiff directions leave the others fewer digits.

        Args:
            times: in s, a number or shape (T,).
            order: 0 for x, 1 for x'.

        Returns:
            Shapes (S, n, T) or (S, n), (S,), and places.
        """
        times = evaluation_times(times)
        own, count = np.unique(times.reshape(-1)), len(self)
        places = list(range(self.family.base.size)) if self.outputs is None else list(self.outputs)
        values, errors = np.empty((count, len(places), len(own))), np.full(count, np.inf)
        served, every = self._served, max(1, len(own) // TRIAL_TIMES)
        some = slice((len(own) - 1) % every if len(own) else 0, None, every)  # the last time among them
        for begin in range(0, count if served is not None and len(own) else 0, TOGETHER):
            at = slice(begin, begin + TOGETHER)
            with np.errstate(all="ignore"):
                values[at] = self._flow(at).derivative(order)(own)[:, places]
                size = np.abs(values[at]).max(axis=(1, 2))
                trials = [flow.derivative(order)(own[some])[:, places] for flow in self._moved_flows(at)]
                difference = sum(np.abs(values[at][:, :, some] - trial).max(axis=(1, 2)) for trial in trials)
                difference = difference / np.where(size > 0, size, 1.0)
            errors[at] = np.where(served[at] & np.isfinite(difference), FORM_ROUNDING * (difference + EPS), np.inf)
        alone = np.flatnonzero(~(errors <= PROVED_ACCURACY))
        for place in alone.tolist():
            motion = self[place]
            exact = motion(own) if not order else motion.velocity(own)
            values[place], errors[place] = exact[places], motion.error_estimate(own) if len(own) else 0.0
        if not np.isfinite(values).all():
            raise Overflow("values of a system lie beyond the range of float64; choose earlier times")
        given = values if np.array_equal(own, times) else values[:, :, np.searchsorted(own, times)]
        return given, errors, alone

    def extrema(self, span: tuple[float, float], order: int = 0, combinations: np.ndarray | None = None) -> list[Extrema]:
        """The largest and the smallest values of each system over a span of time, none missed (``frequency.shock.extrema``).

        Each system's flow is decoupled; where its values are not those of the family at some times, the system is solved by itself.

        Args:
            span: first and last time in s.
            order: 0 for x, 1 for x', 2 for x''.
            combinations: of the coordinates, shape (p, n); by default each one.

        Returns:
            One for each system.

        Raises:
            Overflow: a value leaves the range of float64.

        >>> from mbconstrained import family
        >>> motions = family([[1.0]], None, [[[4.0]], [[9.0]]]).solve(velocity=[6.0])
        >>> [float(one.maximum[0].round(12)) for one in motions.extrema((0.0, 2.0))]
        [3.0, 2.0]
        """
        return self._of_each(
            span, order, combinations, lambda f, at: extrema(f, *span) if at is None else extrema(f, *span).with_values(at)
        )

    def root_mean_squares(
        self, span: tuple[float, float], order: int = 0, combinations: np.ndarray | None = None
    ) -> list[RootMeanSquares]:
        """The RMS values of each system over a span of time, by integrals of the closed form.

        Args:
            span, order, combinations: as in ``extrema``.

        Returns:
            One for each system.

        >>> from mbconstrained import family
        >>> motions = family([[1.0]], None, [[[4.0]], [[9.0]]]).solve(velocity=[6.0])
        >>> [float(one.values[0].round(12)) for one in motions.root_mean_squares((0.0, np.pi))]  # 3 / sqrt(2), 2 / sqrt(2)
        [2.12132034356, 1.414213562373]
        """
        return self._of_each(span, order, combinations, lambda f, at: root_mean_squares(f, *span, accurate=at))

    def _of_each(
        self, span: tuple[float, float], order: int, combinations: np.ndarray | None, what: Callable[..., Any]
    ) -> list[Any]:
        """A functional of the functions of each system and of their more accurate values, or None where these have it themselves."""
        count, served = len(self), self._served
        own = np.eye(self.family.base.size) if self.outputs is None else np.eye(self.family.base.size)[list(self.outputs)]
        matrix = own if combinations is None else real_array(combinations, "combinations", shape=(None, self.family.base.size))
        result: list[Any] = [None] * count
        some = np.linspace(*span, TRIAL_TIMES)
        for begin in range(0, count if served is not None else 0, TOGETHER):
            at = slice(begin, begin + TOGETHER)
            with np.errstate(all="ignore"):
                flow, *moved = (one.derivative(order).mapped(matrix) for one in (self._flow(at), *self._moved_flows(at)))
                values = flow(some)
                change = sum(np.abs(one(some) - values).max(axis=(1, 2)) for one in moved)
            size = np.abs(values).max(axis=(1, 2))
            close = served[at] & (FORM_ROUNDING * (change + EPS * size) <= PROVED_ACCURACY * size)
            for place in np.flatnonzero(close).tolist():
                one = flow.of(place)
                try:
                    function = one.function()
                    if np.abs(function(some) - values[place]).max() <= LOCATED * size[place]:
                        result[begin + place] = what(function, lambda times, one=one: one(times)[0])
                except MbconstrainedError:
                    continue  # solved by itself, which has its own reasons
        for place in [place for place, own in enumerate(result) if own is None]:
            motion = self[place]
            function = motion.derivative(order) if order else motion.function
            result[place] = what(function.mapped(matrix), None)
        return result

    @cached_property
    def _signal(self) -> BohlFunction:
        """The common force, then b of the constraint rows."""
        base = self.family.base
        n, k = base.size, len(base.rows)
        total = self.force.mapped(np.eye(n + k, n))
        constant = np.array([row.value for row in base.rows])
        motion = right_sides(base.rows)
        if constant.any():
            total = total + step(np.concatenate([np.zeros(n), constant]))
        return (total if motion is None else total + motion.mapped(np.eye(n + k, k, -n))).smooth

    @cached_property
    def _served(self) -> np.ndarray | None:
        """Which systems have the common structure and a consistent start; None where stacks serve no system."""
        base, equations = self.family.base, self.family.equations
        moving = [row.signal for row in base.rows if row.signal is not None]
        if equations is None or any(row.order for row in base.rows):
            return None
        if any(signal.impulses or signal.later for signal in (self.force, *moving)) or any(len(one.knots) > 1 for one in moving):
            return None
        A, n = base.constraint_matrix, base.size
        signal = self._signal
        b = np.array([signal(0.0)[n:], signal.derivative()(0.0)[n:]])
        gap, size = np.abs(self.initial @ A.T - b), np.abs(self.initial) @ np.abs(A.T) + np.abs(b)
        return equations.serve & (gap <= noise_of(size, n)).all(axis=(1, 2))

    def _moved_flows(self, at: slice) -> list[StackedFlow]:
        """Flows of some systems with perturbed entries, and with perturbed generators."""
        return [self._flow(at, MOVED_DATA), *(replace(self._flow(at), moved=SQUARED, trial=trial) for trial in range(TRIALS))]

    def _flow(self, at: slice, moved: float = 0.0) -> StackedFlow:
        """The flow of some systems, with entries perturbed by a factor where one is given."""
        base = self.family.base
        matrices = self.family.matrices(at)
        equations: Any = self.family.equations
        own, V = equations.of(at), base.position_form().null_space
        if moved:
            M, C, K = (_moved(matrix, moved) for matrix in matrices)
            matrices, changed = (M, C, K), stacked_equations(M, C, K, V)
            own = own if changed is None else changed
        starts, multipliers = self._starts[at][:, :, own.free], base.multiplier_map.T
        return stacked_flow(own, matrices, starts, self._signal, self.family.static_force[at], multipliers)

    @cached_property
    def _starts(self) -> np.ndarray:
        """z and z' with x = V z + G^T b at 0-, shape (S, 2, r)."""
        base = self.family.base
        V, shape = base.position_form().null_space, self.initial.shape
        if V.shape[0] == V.shape[1]:
            return self.initial
        signal = self._signal
        b = np.array([signal(0.0), signal.derivative()(0.0)])[:, base.size :]
        free = (self.initial - b @ base.multiplier_map).reshape(-1, shape[2])
        return np.linalg.lstsq(V, free.T, rcond=None)[0].T.reshape(len(self.family), 2, V.shape[1])


def _moved(matrix: np.ndarray, units: float) -> np.ndarray:
    """The stack with each entry perturbed by a multiple of its rounding error, symmetric where the entries are."""
    signs = np.random.default_rng(0).choice([-1.0, 1.0], matrix.shape[1:])
    return matrix * (1.0 + units * EPS * (np.triu(signs) + np.triu(signs, 1).T))
