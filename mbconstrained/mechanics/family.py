"""``family``: many mechanical systems of one structure, solved in stacks of matrices."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, Literal

import numpy as np

from ..frequency.extrema import Extrema, RootMeanSquares, extrema, root_mean_squares
from ..frequency.harmonic import Harmonic
from ..frequency.random.random_response import RandomResponse
from ..frequency.random.spectra import KINDS, SpectralMatrix
from ..ground.by_name import answering
from ..ground.checks import counted, evaluation_times, places_of, real_array
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError, MbconstrainedError, Overflow
from ..ground.notices import Notice, NoticeKind, doubts_of
from ..ground.tolerances import EPS, FORM_ROUNDING, LINE_ACCURACY, LOCATED, MOVED_DATA, PROVED_ACCURACY, STACKED_VARIANCE, noise_of
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import step, zero
from .constraints import Constraint, right_sides
from .modes import Modes, rest_shapes
from .motion import Motion
from .stacked_equations import StackedEquations, StackedFlow, stacked_equations, stacked_flow
from .stacked_poles import StackedPoles, StackedTransfer, in_parts, stacked_poles
from .system import MechanicalSystem


@answering
def family(
    mass,
    damping=None,
    stiffness=None,
    constraints: Sequence[Constraint] = (),
    names: Sequence[str] | None = None,
    force=None,
    static_force=None,
    units=None,
) -> Family:
    """Create S mechanical systems of one structure with different constants, such as the samples of a tolerance study.

    The structure (constraints, massless coordinates, which equation has which order) is decided once, for the first system. Modes,
    motions and frequency responses are computed in stacks of matrices; each has an error estimate, and systems that fall short of
    1e-12, or of the structure, are solved one by one (``MechanicalSystem``).

    Args:
        mass, damping, stiffness: as in ``MechanicalSystem``, of shape (n, n), common to all, or (S, n, n).
        constraints: common to all.
        names, force, units: as in ``MechanicalSystem``, common to all.
        static_force: a constant force, shape (n,) or (S, n).

    Returns:
        A ``Family``, a sequence of S systems.

    Raises:
        InputError: shapes that do not match, no matrix with a leading axis.

    >>> k = np.array([4.0, 9.0, 16.0])
    >>> oscillators = family([[1.0]], stiffness=k.reshape(-1, 1, 1))
    >>> oscillators.modes().natural_frequencies.round(12).tolist()
    [[2.0], [3.0], [4.0]]
    >>> oscillators.solve([1.0])([np.pi]).round(12).tolist()
    [[[1.0]], [[-1.0]], [[1.0]]]
    """
    given = {"mass": mass, "damping": damping, "stiffness": stiffness}
    arrays = {name: real_array(value, name) for name, value in given.items() if value is not None}
    if static_force is not None:
        arrays["static_force"] = real_array(static_force, "static_force")
    counts = {name: len(array) for name, array in arrays.items() if array.ndim == (2 if name == "static_force" else 3)}
    if not counts:
        raise InputError("family: found no matrix of shape (S, n, n); expected at least one, with a matrix for each of S systems")
    if len(set(counts.values())) > 1 or not min(counts.values()):
        sizes = ", ".join(f"{name} of {counted(count, 'system')}" for name, count in counts.items())
        raise InputError(f"family: found {sizes}; expected one number of systems, at least 1")
    first = {name: array[0] if name in counts else array for name, array in arrays.items()}
    M, C, K = (first.get(name) for name in given)
    base = MechanicalSystem(M, C, K, constraints, names, force, first.get("static_force"), units)
    count, shape = next(iter(counts.values())), (base.size, base.size)
    for name, array in arrays.items():
        expected = (base.size,) if name == "static_force" else shape
        if array.shape[name in counts :] != expected:
            raise InputError(f"{name}: expected shape {expected} or ({count}, ...), found {array.shape}")
    stacks = [np.broadcast_to(arrays.get(name, np.zeros(shape)), (count, *shape)) for name in given]
    own = arrays["static_force"] - arrays["static_force"][0] if "static_force" in counts else np.zeros((count, base.size))
    return Family(base, stacks[0], stacks[1], stacks[2], base.static_force + own)


@dataclass(frozen=True, repr=False, eq=False)
class Family(Displayed):
    """S systems; ``systems[3]`` is one ``MechanicalSystem``.

    Attributes:
        base: the first system, whose structure, names, constraints and force all have.
        mass, damping, stiffness: shape (S, n, n).
        static_force: shape (S, n).
    """

    base: MechanicalSystem
    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    static_force: np.ndarray

    def _summary(self) -> str:
        return f"{counted(len(self), 'system')} of {counted(self.base.size, 'coordinate')}"

    def __len__(self) -> int:
        return len(self.mass)

    def __getitem__(self, index: int) -> MechanicalSystem:
        place = range(len(self))[index]  # IndexError where there is none
        base, (M, C, K) = self.base, self.matrices(place)
        units = list(base.units.values())
        return MechanicalSystem(M, C, K, base.constraints, base.names, base.excitation, self.static_force[place], units)

    def __iter__(self) -> Iterator[MechanicalSystem]:
        return (self[index] for index in range(len(self)))

    @cached_property
    def equations(self) -> StackedEquations | None:
        """Equations in stacks of matrices; None where the structure needs rank decisions, which are made for each system."""
        return stacked_equations(*self.matrices(slice(None)), self.base.position_form().null_space)

    @cached_property
    def poles(self) -> StackedPoles | None:
        """Poles and residues in stacks; None without stacked ``equations``."""
        return None if self.equations is None else stacked_poles(self.equations, *self.matrices(slice(None)))

    def matrices(self, at: slice | int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """M, C and K of some systems, or of one."""
        return self.mass[at], self.damping[at], self.stiffness[at]

    def _is_free(self, shapes: np.ndarray, of: Literal["stiffness", "damping"]) -> np.ndarray:
        """Which systems have no springs, or no dampers, that resist some motions, up to rounding errors of the entries, shape (S,)."""
        V, matrices = self.base.position_form().null_space, getattr(self, of)
        noise = noise_of(np.abs(V.T) @ np.abs(matrices) @ np.abs(shapes))
        return (np.abs(V.T @ (matrices @ shapes)) <= noise).all(axis=(1, 2))

    def modes(self) -> FamilyModes:
        """The modes of all systems.

        Returns:
            ``FamilyModes``.

        Raises:
            SingularPolynomialMatrix: the motion of a system is not determined.
        """
        count, n, stacks = len(self), self.base.size, []
        waiting = np.ones(count, dtype=bool)
        if (poles := self.poles) is not None:
            stacks.append(_Stack(poles, poles.serve & (poles.value_errors <= PROVED_ACCURACY).all(axis=1), np.zeros((0, n))))
            waiting &= ~stacks[0].serve
        if waiting.sum() > 1 and (freed := self._free_stack(waiting)):
            stacks.append(freed)
            waiting &= ~freed.serve
        alone = {place: self[place].modes() for place in np.flatnonzero(waiting).tolist()}
        drift = sum(row.order for row in self.base.rows)
        stacks = [one for one in stacks if one.serve.any()]
        width = max([0, *(len(modes.eigenvalues) for modes in alone.values()), *(one.count + drift for one in stacks)])
        values, errors = np.full((count, width), np.nan, dtype=complex), np.full((count, width), np.nan)
        shapes = np.full((count, n, width), np.nan, dtype=complex)
        for one in stacks:
            one.sort_into(values, errors, shapes, drift)
        for place, modes in alone.items():
            counts, own = [mode.multiplicity for mode in modes], modes.eigenvalues
            values[place, : len(own)], errors[place, : len(own)] = own, np.repeat(np.maximum(modes.residuals, EPS), counts)
            for column, (mode, i) in enumerate((mode, i) for mode, number in zip(modes, counts) for i in range(number)):
                if mode.shapes.size:
                    shapes[place, :, column] = mode.shapes[:, min(i, mode.shapes.shape[1] - 1)]
        return FamilyModes(self, errors, np.array(sorted(alone), dtype=int), values, shapes)

    def _free_stack(self, waiting: np.ndarray) -> _Stack | None:
        """Systems with the free motions of the first of those that wait: free bodies, or one motion that dampers alone resist.

        Whether a motion is free is a decision on rank, which is made for that system; for the others it is seen whether springs
        and dampers act against it. A pole of theirs that is not clearly none of the zeros leaves a system out.
        """
        if self.poles is None:
            return None
        free, staying = rest_shapes(self[int(waiting.argmax())].position_form().polynomial_matrix)
        if np.iscomplexobj(free) or np.iscomplexobj(staying):
            return None
        if free.shape[1] and not staying.shape[1]:
            waiting = waiting & self._is_free(free, "stiffness") & self._is_free(free, "damping")
            equations = self.equations.without_rigid_motions(free)
            if not (waiting & equations.serve).any():
                return None
            poles = stacked_poles(equations, *self.matrices(slice(None)))
            serve = waiting & poles.serve & (poles.value_errors <= PROVED_ACCURACY).all(axis=1)
            bodies = free.shape[1]
            return _Stack(poles, serve, np.array([free[:, min(i, bodies - 1)] for i in range(2 * bodies)]))
        if staying.shape[1] != 1 or free.shape[1] or (resting := self.equations.with_resting_motion(staying)) is None:
            return None
        equations, doubt = resting
        units = np.broadcast_to(np.eye(equations.K.shape[1]), equations.K.shape)
        poles = stacked_poles(replace(equations, T=units), equations.M, equations.C, equations.K)
        zero = ((poles.values == 0) | (poles.value_errors >= 1.0)) & (poles.weights == 1)  # not farther from 0 than their errors
        errors = poles.value_errors + doubt[:, None]
        clear = (errors <= PROVED_ACCURACY) | zero
        serve = waiting & self._is_free(staying, "stiffness") & poles.serve & clear.all(axis=1) & (zero.sum(axis=1) == 1)
        weights, shapes = np.where(zero, 0.0, poles.weights), equations.T @ poles.shapes
        return _Stack(replace(poles, value_errors=errors, weights=weights, shapes=shapes), serve, staying.T)

    def solve(self, displacement=None, velocity=None, force=None) -> FamilyMotion:
        """The motions of all systems from values at 0-, under the same force.

        Args:
            displacement, velocity: x and x' at 0-, shape (n,) or by name, common to all; or (S, n).
            force: f in addition to that of the systems, as in ``MechanicalSystem.solve``.

        Returns:
            A ``FamilyMotion``, a function of time.
        """
        base, count = self.base, len(self)
        start = np.empty((count, 2, base.size))
        for place, (value, what) in enumerate(((displacement, "displacement"), (velocity, "velocity"))):
            if value is not None and not hasattr(value, "items") and np.ndim(value) == 2:
                start[:, place] = real_array(value, what, shape=(count, base.size))
            else:
                start[:, place] = base._vector(value, what)
        added = zero(base.size) if force is None else base._signal(force)
        return FamilyMotion(self, start, added if base.excitation is None else base.excitation + added)

    def frequency_response(
        self, frequencies_hz, inputs=None, outputs=None, quantity: str = "receptance", relative_to: str | None = None
    ) -> FamilyFrequencyResponse:
        """The frequency responses of all systems from their poles and residues.

        Args:
            frequencies_hz: shape (F,).
            inputs, outputs, quantity, relative_to: as in ``MechanicalSystem.frequency_response``.

        Returns:
            A ``FamilyFrequencyResponse``.
        """
        frequencies = np.atleast_1d(real_array(frequencies_hz, "frequencies_hz"))
        first = self[0].frequency_response(frequencies, inputs, outputs, quantity, relative_to=relative_to)  # checks the arguments
        names = (first.inputs, first.outputs)
        values = np.empty((len(self), len(names[1]), len(names[0]), len(frequencies)), dtype=complex)
        errors = np.full((len(self), len(names[1]), len(names[0])), np.inf)
        at_level = quantity in BY_POLES and not any(row.order for row in self.base.rows)
        for at, transfer in stacked_transfers(self, first.harmonic, np.zeros(len(first.inputs))) if at_level else ():
            values[at], absolute = transfer(2j * np.pi * frequencies)
            errors[at] = np.where(transfer.poles.serve[:, None, None], _relative(values[at], absolute), np.inf)
        alone = np.flatnonzero(~(errors <= LINE_ACCURACY).all(axis=(1, 2)))
        for place in alone.tolist():
            H = first if not place else self[place].frequency_response(frequencies, *names, quantity, relative_to=relative_to)
            values[place] = H.values
            errors[place] = _relative(H.values, np.where(H.values == 0, 0.0, np.abs(H.values) * H.error_estimate))
        return FamilyFrequencyResponse(self, errors, alone, frequencies, values, *names, quantity, first.units)

    def random_response(self, excitation: Mapping, outputs=None, quantity: str = "displacement", **options) -> FamilyRandomResponse:
        """The RMS values of all systems under the same random excitation.

        Args:
            excitation, outputs, quantity, options: as in ``MechanicalSystem.random_response``.

        Returns:
            A ``FamilyRandomResponse``.

        >>> import mbconstrained as mb
        >>> systems = mb.family([[1.0]], [[0.5]], [[[2.0]], [[8.0]]])
        >>> systems.random_response({"x1": mb.white_noise(4.0)}).rms.round(12).tolist()  # sqrt(G / (4 c k))
        [[1.0], [0.5]]
        """
        arguments = (excitation, outputs, quantity)
        first = self[0].random_response(*arguments, **options)  # checks the arguments
        count, p = len(self), len(first.outputs)
        squares, errors = np.full((count, p), np.nan), np.full((count, p), np.inf)
        spectra = first.spectra
        if not (first.infinite or spectra.longest_delay or options.get("modal_damping") is not None):
            levels = [KINDS[spectrum.of] or 0 for spectrum in spectra.spectra]
            for at, transfer in stacked_transfers(self, first.harmonic, levels):
                squares[at], errors[at] = _variances(transfer, spectra)
        served = (errors <= STACKED_VARIANCE * squares).all(axis=1)
        with np.errstate(all="ignore"):
            rms, relative = np.sqrt(squares), errors / (2 * squares) + EPS
        relative[squares == 0] = 0.0
        alone = np.flatnonzero(~served)
        for place in alone.tolist():
            own = first if not place else self[place].random_response(*arguments, **options)
            rms[place], relative[place] = own.rms, own.error_estimate
        return FamilyRandomResponse(self, relative, alone, rms, first.outputs, first.units, (arguments, options))


def stacked_transfers(systems: Family, harmonic: Harmonic, levels) -> Iterator[tuple[slice, StackedTransfer]]:
    """Transfer functions for a harmonic response, of some systems at a time; none where poles do not give it."""
    base, n, poles = systems.base, systems.base.size, systems.poles
    B, C = harmonic.inputs, harmonic.outputs
    if poles is None or B.shape[0] != n + len(base.rows) or C[:, n:].any() or harmonic.imaginary is not None:
        return
    motions, orders = base.multiplier_map.T @ B[n:], np.asarray(levels, dtype=int)
    for at in in_parts(len(systems)):
        M, D, K = systems.matrices(at)
        loads = [B[:n] - K @ motions] + [-(D @ motions), -(M @ motions)] * bool(motions.any())
        yield at, StackedTransfer(poles.of(at), C[:, :n], motions, tuple(loads), harmonic.power, orders)


# The modes of a family of systems: eigenvalues and shapes from the stacked poles, of some systems one by one.


@dataclass(frozen=True, repr=False, eq=False)
class FamilyAnswer(Displayed):
    """Answers of S systems, with relative error estimates and the places of those that were solved one by one."""

    family: Family
    error_estimate: np.ndarray
    alone: np.ndarray

    what: ClassVar[Any]
    values_of: ClassVar[str]
    limit: ClassVar[float] = PROVED_ACCURACY

    def __len__(self) -> int:
        return len(self.family)

    def _summary(self) -> str:
        return f"{self.what} of {counted(len(self.family), 'system')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on systems that were solved one by one and on inaccurate values; values at a pole on the imaginary axis are infinite."""
        some = f"{counted(len(self.alone), 'system')} of {len(self.family)}"
        text = f"{some} solved one by one: another structure than the first, or an estimate above {self.limit:g}"
        doubts = doubts_of(f"{self.values_of} of a system", np.nanmax(self._errors, initial=0.0))
        return (*((Notice(NoticeKind.ACCURACY, text),) if len(self.alone) else ()), *doubts)

    @property
    def _errors(self) -> np.ndarray:
        return self.error_estimate


@dataclass(frozen=True, repr=False, eq=False)
class FamilyModes(FamilyAnswer):
    """The modes of S systems; ``modes[3]`` are the ``Modes`` of one, with kinds, energies and tables.

    Attributes:
        family: the systems.
        eigenvalues: in 1/s as ``Modes.eigenvalues``, ascending by modulus, shape (S, P); NaN where a system has fewer.
        shapes: the largest entry of each 1, shape (S, n, P).
        error_estimate: error estimate of the eigenvalues, relative, shape (S, P).
        alone: places of the systems that were solved one by one.
    """

    eigenvalues: np.ndarray
    shapes: np.ndarray

    what, values_of = "modes", "the eigenvalues"

    def __getitem__(self, index: int) -> Modes:
        return self.family[index].modes()

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


@dataclass(frozen=True, eq=False)
class _Stack:
    """Poles of systems that the stacked method serves, and the shapes of their eigenvalues 0, one for each."""

    poles: StackedPoles
    serve: np.ndarray
    zeros: np.ndarray

    @property
    def count(self) -> int:
        """The largest number of their eigenvalues."""
        return int((self.poles.weights[self.serve] > 0).sum(axis=1).max()) + len(self.zeros)

    def sort_into(self, values: np.ndarray, errors: np.ndarray, shapes: np.ndarray, drift: int) -> None:
        """The poles of the systems that serve, ascending by modulus after eigenvalues 0, their shapes with largest entry 1."""
        poles, serve = self.poles, self.serve
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
        begin = drift + len(self.zeros)
        columns, present = slice(begin, drift + self.count), self.count - len(self.zeros)
        values[serve, :begin], errors[serve, :drift], errors[serve, drift:begin] = 0.0, 0.0, EPS
        values[serve, columns], errors[serve, columns] = ordered[serve, :present], sizes[serve, :present]
        shapes[serve, :, drift:begin] = self.zeros.T
        shapes[serve, :, columns] = X[serve][:, :, :present]


# The motions of a family of systems, functions of time, by stacked matrix exponentials, of some systems one by one.

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

    family: Family
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
        """
        times = evaluation_times(times)
        own, count = np.unique(times.reshape(-1)), len(self)
        places = list(range(self.family.base.size)) if self.outputs is None else list(self.outputs)
        values, errors = np.empty((count, len(places), len(own))), np.full(count, np.inf)
        served, every = self._served, max(1, len(own) // TRIAL_TIMES)
        some = slice((len(own) - 1) % every if len(own) else 0, None, every)  # the last time among them
        for at in in_parts(count if served is not None and len(own) else 0):
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
        """The largest and the smallest values of each system over a span of time, none missed (``frequency.extrema``).

        Each system's flow is decoupled; where its values are not those of the family at some times, the system is solved by itself.
        The order is 0 for x, 1 for x', 2 for x''; combinations of the coordinates have the shape (p, n), by default each one.

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
        """The RMS values of each system over a span of time, by integrals of the closed form; arguments as of ``extrema``.

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
        for at in in_parts(count if served is not None else 0):
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
                        result[at.start + place] = what(function, lambda times, one=one: one(times)[0])
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


# The frequency responses of a family of systems from the stacked poles and residues, of some systems one by one.

#: Quantities that are computed from the poles of a stack.
BY_POLES = ("receptance", "mobility", "accelerance", "transmissibility")


@dataclass(frozen=True, repr=False, eq=False)
class FamilyFrequencyResponse(FamilyAnswer):
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

    frequencies_hz: np.ndarray
    values: np.ndarray
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    quantity: str
    units: np.ndarray

    what, values_of, limit = property(lambda self: self.quantity), "the responses", LINE_ACCURACY
    _errors = property(lambda self: np.where(np.isfinite(self.error_estimate), self.error_estimate, 0.0))


def _relative(values: np.ndarray, absolute: np.ndarray) -> np.ndarray:
    """Errors relative to the largest value of each row; infinite where one is not finite."""
    sizes = np.abs(values).max(axis=-1, initial=0.0)
    relative = absolute.max(axis=-1, initial=0.0) / np.where(sizes > 0, sizes, 1.0) + EPS
    return np.where(np.isfinite(relative) & np.isfinite(sizes), relative, np.inf)


# RMS values of a family of systems under random excitation, from the stacked poles, of some systems one by one.
#
#     E[y^2] = integral from 0 to infinity of H S H^H df
#
# Octaves of the frequency are the panels of all systems. A pole f_k nearer to the middle of a panel than its width has the principal part
# 2 Re r / (f - f_k), r = R_k S(f_k) H(conj f_k)^H / (2 pi i), whose integral is a logarithm and an arc tangent; what remains is integrated
# exactly by Gauss's rule, as in ``frequency.random.spectral_integral``. Nodes are common to all systems.

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)

#: A pole nearer to the middle of a panel than so many half-widths counts as near (Gauss's rule is exact to 3.7^-32 without it).
NEAR = 2.0


@dataclass(frozen=True, repr=False, eq=False)
class FamilyRandomResponse(FamilyAnswer):
    """RMS values of S systems; ``response[3]`` is the ``RandomResponse`` of one.

    Attributes:
        family: the systems.
        rms: shape (S, p); infinite where the variance is.
        error_estimate: error estimate of the RMS values, relative, shape (S, p).
        outputs: names.
        units: units of the outputs.
        alone: places of the systems that were solved one by one.
        excitation: the arguments of ``MechanicalSystem.random_response``.
    """

    rms: np.ndarray
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    excitation: tuple

    what, values_of, limit = "RMS values", "RMS values", STACKED_VARIANCE

    def __getitem__(self, index: int) -> RandomResponse:
        arguments, options = self.excitation
        return self.family[index].random_response(*arguments, **options)


def _panels(corners: np.ndarray, low: float, high: float) -> Iterator[tuple[float, float, float, bool]]:
    """Both ends of panels between corners in Hz, none wider than an octave, a frequency in the pieces of the spectra, and False.

    The first from 0 ends below all poles. The tail to infinity begins beyond them: its variable is 1/f, and it has True.
    """
    for a, b in pairwise(corners.tolist()):
        middle = a + 1.0 if np.isinf(b) else (a + b) / 2
        if np.isinf(b):
            b = max(2 * high, 2 * a)
            yield 0.0, 1 / b, middle, True
        if a == 0:
            first = min(low / 2, b)
            yield 0.0, first, middle, False
            a = first
        if b > a:
            edges = np.geomspace(a, b, int(np.ceil(np.log2(b / a) - FORM_ROUNDING * EPS)) + 1)
            yield from ((one, two, middle, False) for one, two in pairwise([a, *edges[1:-1].tolist(), b]))


def _variances(transfer: StackedTransfer, spectra: SpectralMatrix) -> tuple[np.ndarray, np.ndarray]:
    """E[y^2] and estimates of its absolute errors, shape (S, p); infinite where poles on the axis or singular spectra are near."""
    poles = transfer.poles
    present = poles.weights > 0
    count, p = len(poles.values), len(transfer.outputs)
    f = np.where(present, poles.values, np.nan) / 2j / np.pi
    sizes = np.abs(f[present & poles.serve[:, None]])
    damped = poles.serve & np.where(present, poles.values.real < -LINE_ACCURACY * np.abs(poles.values), True).all(axis=1)
    if not sizes.size or not damped.any():
        return np.full((count, p), np.nan), np.full((count, p), np.inf)
    lower, upper, inside, is_tail = map(np.array, zip(*_panels(spectra.corners, sizes.min(), sizes.max())))
    middles, halves = np.where(is_tail, np.nan, (lower + upper) / 2), (upper - lower) / 2
    own_nodes, own_weights = lower[:, None] + halves[:, None] + np.multiply.outer(halves, NODES), np.multiply.outer(halves, WEIGHTS)
    nodes = np.where(is_tail[:, None], 1 / own_nodes, own_nodes)
    weights = np.where(is_tail[:, None], own_weights / own_nodes**2, own_weights).ravel()
    for middle in set(inside.tolist()):
        others = np.array([one for one in spectra.singularities(middle) if one], dtype=complex)
        if (np.abs(middles[:, None] - others) < NEAR * halves[:, None]).any():
            return np.full((count, p), np.nan), np.full((count, p), np.inf)
    S = np.concatenate([spectra(own, middle) for own, middle in zip(nodes, inside.tolist())], axis=2)
    with np.errstate(all="ignore"):
        H, doubt = transfer(2j * np.pi * nodes.ravel())
        weighted = np.einsum("ijf,sajf->saif", S, H.conj())
        total = ((H * weighted).sum(axis=2).real * weights).sum(axis=2)
        spread = np.einsum("ijf,sajf->saif", np.abs(S), doubt)
        error = (((2 * np.abs(H) + doubt) * spread).sum(axis=2) * weights).sum(axis=2)
        mirrored = transfer(-np.where(present, poles.values, 1.0).conj())[0]  # H at conj f_k, shape (S, p, m, P)
        residues = transfer.residues() / (2j * np.pi)
        member, pole, panel = np.nonzero(np.abs(f[:, :, None] - middles) < NEAR * halves)
        at = f[member, pole]
        own = np.empty((len(S), len(S), len(at)), dtype=complex)
        for middle in set(inside.tolist()):
            chosen = (inside == middle)[panel]
            own[:, :, chosen] = spectra(at[chosen], middle)
        r = np.einsum("xai,ijx,xaj->xa", residues[member, :, :, pole], own, mirrored[member, :, :, pole].conj())
        lower, upper = lower[panel], upper[panel]
        grid = nodes[panel] - at.real[:, None]
        share = weights.reshape(nodes.shape)[panel] / (grid**2 + at.imag[:, None] ** 2)
        height = np.abs(at.imag)
        logarithm = np.log(((upper - at.real) ** 2 + height**2) / ((lower - at.real) ** 2 + height**2)) / 2
        angle = np.arctan2((upper - lower) * height, height**2 + (upper - at.real) * (lower - at.real))
        sums = (share * grid).sum(axis=1), (share * height[:, None]).sum(axis=1)
        turned = np.sign(at.imag)
        np.add.at(
            total, member, 2 * (r.real * (logarithm - sums[0])[:, None] - (r.imag * turned[:, None]) * (angle - sums[1])[:, None])
        )
        sizes = np.abs(r.real) * (np.abs(logarithm) + np.abs(sums[0]))[:, None] + np.abs(r.imag) * (angle + sums[1])[:, None]
        np.add.at(error, member, 2 * FORM_ROUNDING * EPS * sizes)
        own_errors = (2 * poles.shape_errors + poles.value_errors)[member, pole, None]
        own_errors = own_errors + (poles.value_errors * np.abs(poles.values) / np.abs(poles.values.real))[member, pole, None]
        np.add.at(error, member, 2 * own_errors * np.abs(r) * angle[:, None])
    good = damped & np.isfinite(total).all(axis=1) & np.isfinite(error).all(axis=1)
    return np.where(good[:, None], total, np.nan), np.where(good[:, None], error, np.inf)
