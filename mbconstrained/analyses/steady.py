"""The steady state of a scene: the cycle that remains after all free motion has decayed, as values, amplitudes, orbits and a motion."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..frequency.extrema import Extrema, extrema, root_mean_squares
from ..ground.display import TextTable, number_text, with_unit
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind, distinct
from ..ground.tolerances import NOT_DRAWN, SAME_FREQUENCY
from ..ground.units import derivative_name, force_unit, rate_unit
from ..mechanics.channels import FORCES, MOTIONS, REACTION, Output, closed_form
from ..mechanics.harmonic_response import harmonics_of
from ..mechanics.harmonic_sums import common_rate
from ..mechanics.switched.periodic import find_periodic
from ..page.animation import Animation
from ..page.content import Curve, Marks, Plot, curve_with_gaps
from ..scene.build.model import output_names
from ..scene.file import at
from ..scene.run.animation import animation_of
from ..scene.run.drawing import RobotPicture, drawing_of, drawing_of_robot
from ..scene.run.result import Result
from ..scene.run.stages import is_animated
from ..scene.schema.analysis_tables import SteadyTable
from ..signals.inputs import harmonic, step
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..mechanics.harmonic_response import SteadyState
    from ..mechanics.switched.periodic import PeriodicMotion
    from ..scene.run.scene import Scene
    from ..signals.bohl import BohlFunction

#: Times in a cycle, and in a period of the highest frequency; the most of them.
TIMES, TIMES_OF_PERIOD, MOST_TIMES = 721, 24, 20_001

#: Periods of the lowest frequency that are shown where the frequencies have no common period.
STRETCH = 20

#: Amplitudes below this share of the largest of their output are not listed; files have all.
SMALLEST = 1e-3

#: Orbits and phase planes, at most; events that are listed.
MOST_ORBITS, MOST_EVENTS = 6, 200

#: Kinds of [[force]] that can repeat for ever.
REPEATING = ("step", "harmonic", "sampled", "term")

#: The coordinates of a point in a plane end with these.
PLANES = (("y", "z"), ("x", "y"), ("x", "z"))


class Steady(Analysis):
    """The steady state: the cycle that remains after all free motion has decayed.

    Under constant and harmonic loads or prescribed motions, or a record that repeats with a period; of a model that switches the periodic
    motion, which a load or the model itself maintains, with its Floquet multipliers. Extreme and RMS values over the cycle, amplitude and phase
    at each frequency, orbits and phase planes, and the cycle as an animation. Writes NAME.steady.html, .csv and .npz.
    """

    name = "steady"
    settings = SteadyTable
    options: ClassVar = {"outputs": "--output"}
    switches = "all"
    handles_delays = True

    @classmethod
    def solve(cls, scene: Scene, settings: SteadyTable | None) -> Answer:
        with at(scene.file_name, "steady"):
            if scene.equations.system is None or scene.equations.control is not None:
                raise InputError("a steady state needs a model with mass, damping and stiffness: of kind lumped, matrices or robot")
            kind = _LinearCycle if scene.equations.switching is None else _SwitchedCycle
            own = kind(scene, settings or SteadyTable())
            tables = tuple(own.tables())
        return cls.of(
            scene,
            title=f"{scene.heading}: steady state",
            facts=tuple(own.facts()),
            tables=tables,
            notices=distinct(scene.notices, own.notices()),
            data=own.data(),
            plots=own.plots,
            columns=own.columns,
            arrays=own.arrays,
            on_page=lambda: {"animation": own.animation() if is_animated(scene) else None},
        )


class _Cycle:
    """The outputs over one cycle: functions of time without their constants."""

    motion: Any = None  # the motion over one period from t = 0 on, where there is one
    period: float | None  # in s; None of frequencies without a common one
    length: float  # of what is shown, in s
    outputs: list[Output]
    function: BohlFunction
    highest: float = 0.0  # highest frequency in Hz

    def __init__(self, scene: Scene, table: SteadyTable):
        self.scene, self.table = scene, table
        self.shown = scene.equations.coordinates.shown

    def _chosen(self) -> list[Output]:
        """The outputs that are named, or all that have the quantity."""
        table, system, names = self.table, self.scene.equations.system, output_names(self.scene.equations)
        prescribed = self.scene.table.prescribed.values()
        if table.quantity in MOTIONS:
            moving = [name for name in system.names if name not in prescribed] or list(system.names)
            default = [*(system.named_directions("outputs") or moving), *(name for name in names.own if name not in moving)]
        else:
            default = list({**dict.fromkeys(FORCES, names.elements), REACTION: names.rows}[table.quantity])
            if not default:
                missing = "constraint rows" if table.quantity == REACTION else "springs and dampers with names"
                raise InputError(f"quantity: {table.quantity} is that of {missing}, and there are none")
        return names.chosen("outputs", table.outputs, table.quantity, default)

    @cached_property
    def constants(self) -> np.ndarray:
        """The constant parts of the outputs, shape (m,)."""
        return np.array([one.constant for one in self.outputs])

    @cached_property
    def times(self) -> np.ndarray:
        """Times of one cycle, with both sides of each jump."""
        knots = self.function.restarts.knots
        inside = knots[(knots > 0) & (knots < self.length)]
        count = max(TIMES, min(int(TIMES_OF_PERIOD * self.highest * self.length), MOST_TIMES))
        return np.unique([*np.linspace(0.0, self.length, count), *inside, *np.nextafter(inside, 0.0)])

    @cached_property
    def values(self) -> np.ndarray:
        """The outputs at the times in SI, shape (m, T)."""
        return self.function(self.times) + self.constants[:, None]

    @cached_property
    def extremes(self) -> Extrema:
        """The extreme values of the closed form."""
        return extrema(self.function, 0.0, self.length).shifted(self.constants)

    @cached_property
    def rms(self) -> np.ndarray:
        """RMS values of the closed form, shape (m,)."""
        return root_mean_squares(self.function, 0.0, self.length, self.constants).values

    def of_coordinates(self, order: int, times: np.ndarray) -> np.ndarray:
        """The coordinates or their rates."""
        raise NotImplementedError  # by the kind of cycle

    # The answer.

    def facts(self) -> Iterator[tuple[str, str]]:
        """The period and the outputs."""
        if self.period is None:
            yield "period", f"none: the frequencies have no common one; values are those of {number_text(self.length)} s"
        else:
            yield "period", f"{number_text(self.period)} s, {number_text(1 / self.period)} Hz"
        yield "outputs", ", ".join(one.name for one in self.outputs)

    def notices(self) -> Iterator[Notice]:
        """Whether the steady state is reached."""
        raise NotImplementedError  # by the kind of cycle

    def tables(self) -> Iterator[TextTable]:
        """Extreme and RMS values."""
        rows = []
        for one, low, high, rms in zip(self.outputs, self.extremes.minimum, self.extremes.maximum, self.rms):
            rows.append((one.name, *(self._text(one, value) for value in (low, high, (high - low) / 2, rms))))
        columns = ("output", "smallest", "largest", "half range", "RMS")
        yield TextTable("Values over a cycle", columns, tuple(rows), "Of the closed form: none between times is missed.")

    def _text(self, output: Output, value: float) -> str:
        unit, factor = self.shown.of(output.unit)
        return with_unit(float(f"{factor * value:.5g}"), unit)

    def data(self) -> dict[str, Any]:
        each = zip(self.outputs, self.extremes.minimum.tolist(), self.extremes.maximum.tolist(), self.rms.tolist())
        entries = [
            {"output": one.name, "quantity": one.quantity, "unit": one.unit, "smallest": low, "largest": high, "rms": rms}
            for one, low, high, rms in each
        ]
        return {"period": self.period, "length": self.length, "values": entries}

    def columns(self) -> dict[str, dict[str, np.ndarray]]:
        """The outputs over time in the units shown."""
        shown = [self.shown.of(one.unit) for one in self.outputs]
        heads = (f"{one.name} ({unit})" for one, (unit, _) in zip(self.outputs, shown))
        return {"": {"time (s)": self.times, **dict(zip(heads, self.values * np.array([[factor] for _, factor in shown])))}}

    def arrays(self) -> dict[str, np.ndarray]:
        """Times and values in SI."""
        names, units = (np.array([getattr(one, key) for one in self.outputs]) for key in ("name", "unit"))
        return {"times": self.times, "values": self.values, "outputs": names, "units": units, "rms": self.rms}

    def animation(self) -> Animation:
        """The model through one cycle."""
        if self.motion is not None:
            time = self.scene.table.time.model_copy(update={"start": 0.0, "end": self.length, "step": None, "points": TIMES})
            equations = replace(self.scene.equations, response=self.motion)
            table = self.scene.table.model_copy(update={"time": time})
            return animation_of(Result(replace(self.scene, equations=equations, table=table)))
        times = np.linspace(0.0, self.length, TIMES)
        values, rates = (self.of_coordinates(order, times) for order in (0, 1))
        equations, table = self.scene.equations, self.scene.table.drawing
        if equations.robot_scene is not None:
            drawing = drawing_of_robot(RobotPicture(equations.robot_scene, table), values, table)
        else:
            scales = {key: getattr(table, key) for key in ("scale", "turn_scale") if table and key in table.model_fields_set}
            drawing = replace(drawing_of(self.scene, values, **scales), revolution=None)  # orbits are those of the whole cycle
        return Animation(drawing, equations.coordinates.names, times, values, rates)

    # Plots.

    def plots(self) -> Iterator[Plot]:
        """The outputs over time by quantity and unit, then amplitudes, and orbits, or else phase planes."""
        kinds = list(dict.fromkeys((one.quantity, one.unit) for one in self.outputs))
        for quantity, unit in kinds:
            text, factor = self.shown.of(unit)
            rows = [i for i, one in enumerate(self.outputs) if (one.quantity, one.unit) == (quantity, unit)]
            curves = tuple(Curve(self.outputs[i].name, factor * self.values[i], i) for i in rows)
            title = f"{quantity} ({text})" if [one for one, _ in kinds].count(quantity) > 1 else quantity
            phases = getattr(self.motion, "phases", ())
            yield Plot(title, text, self.times, curves, quantity=quantity, phases=phases)
        yield from self._spectra()
        yield from list(self._orbits()) or self._phase_planes()

    def _spectra(self) -> Iterator[Plot]:
        """Amplitudes over the frequency; none of a motion that switches."""
        yield from ()

    def _orbits(self) -> Iterator[Plot]:
        """The paths of points whose displacements along two axes are outputs, as of the points of a rotor."""
        places = {one.name: i for i, one in enumerate(self.outputs)}
        pairs = [
            (name[:-2], i, places[f"{name[:-1]}{up}"])
            for along, up in PLANES
            for name, i in places.items()
            if name.endswith(f" {along}") and f"{name[:-1]}{up}" in places
        ]
        for name, i, j in [one for one in pairs if self.outputs[one[1]].unit == self.outputs[one[2]].unit][:MOST_ORBITS]:
            text, factor = self.shown.of(self.outputs[i].unit)
            across = Curve(f"{self.outputs[i].quantity} of {self.outputs[i].name}", factor * self.values[i])
            curve = Curve(name, factor * self.values[j], j)
            yield Plot(
                f"orbit of {name}",
                text,
                self.times,
                (curve,),
                across=across,
                across_unit=text,
                quantity=f"{self.outputs[j].quantity} of {self.outputs[j].name}",
                marks=(Marks("t = 0", np.array([[across.values[0], curve.values[0]]]), ("t = 0",)),),
            )

    def _phase_planes(self) -> Iterator[Plot]:
        """The velocity over the displacement of coordinates that are outputs."""
        coordinates = self.scene.equations.coordinates
        names = [one.name for one in self.outputs if one.name in coordinates.names and one.order == 0]
        both = [self.of_coordinates(order, self.times) for order in (0, 1)]
        moving = [name for name in names if np.ptp(both[0][coordinates.number(name)]) > NOT_DRAWN * np.abs(both[0]).max()]
        for name in moving[:MOST_ORBITS]:
            i = coordinates.number(name)
            titles = [derivative_name(coordinates.units[i], order) for order in (0, 1)]
            shown = [self.shown.of(rate_unit(coordinates.units[i], order)) for order in (0, 1)]
            along, up = (factor * own[i] for (_, factor), own in zip(shown, both))
            yield Plot(
                f"phase plane of {name}",
                shown[1][0],
                self.times,
                (Curve(name, up, i),),
                across=Curve(titles[0], along),
                across_unit=shown[0][0],
                quantity=titles[1],
            )


class _LinearCycle(_Cycle):
    """The steady state under constant and harmonic loads, or a record that repeats."""

    def __init__(self, scene: Scene, table: SteadyTable):
        super().__init__(scene, table)
        system, force = scene.equations.system, scene.equations.force
        tables = {"force": scene.table.force, "motion": scene.table.motion}
        loads = [(f"{key}[{i}]", one) for key, own in tables.items() for i, one in enumerate(own, 1)]
        for place, load in loads:
            if load.kind not in REPEATING:
                raise InputError(
                    f"{place} is of the kind {load.kind}, which does not repeat; expected constant and harmonic loads, or a record over "
                    "one period; a run has the motion"
                )
            if load.kind == "sampled" and table.period is None:
                raise InputError(f'period: {place} is a record; give the time after which it repeats, e.g. period = "2 s"')
        self.outputs = self._chosen()
        names = [one.name for one in self.outputs]
        self.steady: SteadyState = system.steady_state(force, table.period, table.harmonics, outputs=names, quantity=table.quantity)
        rates = self.steady.angular_frequencies
        base = common_rate(rates)
        if base == 0.0:
            raise InputError(
                "no load or prescribed motion varies with the time; expected a harmonic one, or a record and its period"
            )
        self.has_record = any(load.kind == "sampled" for _, load in loads)
        turns = (table.period or 0.0) * (base or 0.0) / (2 * np.pi)
        if table.period is not None and not self.has_record and abs(turns - round(turns)) > SAME_FREQUENCY * max(turns, 1.0):
            raise InputError(
                f"period: found {table.period:g} s; the loads repeat after {number_text(2 * np.pi / base)} s; leave it out, or give a multiple"
                if base
                else "period: the frequencies of the loads have no common one; leave it out"
            )
        self.motion = self.steady.motion
        self.period = self.table.period if self.motion is not None else 2 * np.pi / base if base else None
        self.length = self.period or STRETCH * 2 * np.pi / rates[rates > 0].min()
        self.highest = float(self.steady.frequencies_hz[-1])
        self.function = self._harmonics() if self.motion is None else closed_form(self.outputs, self.motion)

    def _harmonics(self) -> BohlFunction:
        """The sum of the harmonics, without the constants."""
        total = step(np.zeros(len(self.outputs)))
        for rate, amplitudes in zip(self.steady.angular_frequencies, self.steady.output_amplitudes.T):
            if rate:
                total += harmonic(amplitudes.real, angular_frequency=rate)
                total += harmonic(amplitudes.imag, angular_frequency=rate, phase=np.pi / 2)
            else:
                total += step(amplitudes.real - self.constants)
        return total.smooth

    def of_coordinates(self, order: int, times: np.ndarray) -> np.ndarray:
        return (self.steady.velocity if order else self.steady.displacement)(times)

    def facts(self) -> Iterator[tuple[str, str]]:
        yield from super().facts()
        frequencies = self.steady.frequencies_hz
        listed = ", ".join(number_text(f) for f in frequencies[:8]) + (
            f" … ({len(frequencies)} in all)" if len(frequencies) > 8 else ""
        )
        yield "frequencies", f"{listed} Hz"
        yield "error estimate", f"{self.steady.error_estimate.max(initial=0.0):.2g} of the largest amplitude"

    def notices(self) -> Iterator[Notice]:
        system = self.scene.equations.system
        yield from system.damping_notices()
        modes = list(system.modes())
        if any(mode.kind == "growth" for mode in modes):
            yield Notice(NoticeKind.UNSTABLE, "a free motion grows: the steady state is not reached", doubtful=True)
        elif not system.loss_factors and any(mode.kind == "oscillation" and not mode.eigenvalue.real for mode in modes):
            text = "an undamped free motion remains: the steady state is the part that repeats with the loads"
            yield Notice(NoticeKind.DAMPING, text)
        if self.has_record and self.motion is None:
            text = f"values over time are sums of {self.table.harmonics} harmonics of the record: harmonics sets another number"
            yield Notice(NoticeKind.ACCURACY, text)
        if self.period is None:
            text = "the frequencies have no common period: other times than those shown may have larger values"
            yield Notice(NoticeKind.ACCURACY, text)

    def tables(self) -> Iterator[TextTable]:
        yield from super().tables()
        rows = []
        for one, amplitudes in zip(self.outputs, self.steady.output_amplitudes):
            least = SMALLEST * np.abs(amplitudes).max(initial=0.0)
            for f, value in zip(self.steady.frequencies_hz, amplitudes):
                if np.abs(value) > least and f:
                    rows.append((one.name, number_text(f), self._text(one, abs(value)), f"{np.degrees(np.angle(value)):.2f}"))
                elif np.abs(value) > least:
                    rows.append((one.name, "0", self._text(one, value.real), "mean"))
        note = f"Those of at least {SMALLEST:g} of the largest of their output."
        yield TextTable("Amplitudes and phases", ("output", "Hz", "amplitude", "phase (°)"), tuple(rows), note)

    def data(self) -> dict[str, Any]:
        own = {"frequencies_hz": self.steady.frequencies_hz, "amplitudes": np.abs(self.steady.output_amplitudes)}
        return {**super().data(), **own, "phases": np.angle(self.steady.output_amplitudes)}

    def arrays(self) -> dict[str, np.ndarray]:
        own = {"frequencies_hz": self.steady.frequencies_hz, "amplitudes": self.steady.output_amplitudes}
        return {**super().arrays(), **own}

    def columns(self) -> dict[str, dict[str, np.ndarray]]:
        columns = {"frequency (Hz)": self.steady.frequencies_hz}
        for one, amplitudes in zip(self.outputs, self.steady.output_amplitudes):
            unit, factor = self.shown.of(one.unit)
            columns[f"amplitude of {one.name} ({unit})"] = factor * np.abs(amplitudes)
            columns[f"phase of {one.name} (deg)"] = np.degrees(np.angle(amplitudes))
        return {**super().columns(), ".amplitudes": columns}

    @property
    def _is_one_harmonic(self) -> bool:
        return bool((self.steady.frequencies_hz > 0).sum() == 1)

    def _phase_planes(self) -> Iterator[Plot]:
        """Phase planes of several frequencies: of one alone they are ellipses."""
        return iter(()) if self._is_one_harmonic else super()._phase_planes()

    def _spectra(self) -> Iterator[Plot]:
        """The amplitudes over the frequency as bars, where there are several, of the outputs and of what excites them."""
        if self._is_one_harmonic:
            return
        f = self.steady.frequencies_hz
        bars = np.repeat(f, 3)
        shown = zip((one.name for one in self.outputs), (one.unit for one in self.outputs), self.steady.output_amplitudes)
        every = [*shown, *self._excitation()]
        for unit in dict.fromkeys(unit for _, unit, _ in every):
            text, factor = self.shown.of(unit)
            chosen = [i for i, (_, own, _) in enumerate(every) if own == unit]
            heights = factor * np.abs([every[i][2] for i in chosen])
            curves, marks = [], []
            for place, (i, own) in enumerate(zip(chosen, heights)):
                name, kept = every[i][0], own > SMALLEST * heights.max(initial=0.0)
                rising = np.array([np.zeros(len(f)), np.where(kept, own, 0.0), np.full(len(f), np.nan)]).T.ravel()
                curves.append(curve_with_gaps(name, rising, i, along=bars))
                texts = tuple(
                    f"{name}: {with_unit(float(f'{y:.4g}'), text)} at {number_text(x)} Hz" for x, y in zip(f[kept], own[kept])
                )
                marks.append(Marks("", np.array([f[kept], own[kept]]).T, texts, curve=place))
            yield Plot(
                f"amplitudes ({text})" if len({own for _, own, _ in every}) > 1 else "amplitudes",
                text,
                np.arange(float(len(bars))),
                tuple(curves),
                across=Curve("frequency", bars),
                across_unit="Hz",
                variable="place",
                quantity="amplitude",
                marks=tuple(marks),
                includes=(0.0,),
            )

    def _excitation(self) -> Iterator[tuple[str, str, np.ndarray]]:
        """Names, units and amplitudes of the forces, and of the prescribed motions in the quantity of the outputs."""
        system, force = self.scene.equations.system, self.scene.equations.force
        rates = self.steady.angular_frequencies
        if force is not None:
            forces = np.zeros((system.size, len(rates)), dtype=complex)
            for rate, amplitudes in harmonics_of(system._applied(force), self.table.period, self.table.harmonics):
                forces[:, np.abs(rates - rate).argmin()] += amplitudes
            for i in np.flatnonzero(forces.any(axis=1)):
                yield f"input: force on {system.names[i]}", force_unit(system.units[system.names[i]]), forces[i]
        order = MOTIONS.get(self.table.quantity)
        prescribed = self.scene.table.prescribed.values()
        for name in (one for one in system.names if one in prescribed and order is not None):
            amplitudes = (1j * rates) ** order * self.steady.displacement_amplitudes[system.names.index(name)]
            yield f"input: {name}", rate_unit(system.units[name], order), amplitudes


class _SwitchedCycle(_Cycle):
    """The periodic motion of a model that switches."""

    def __init__(self, scene: Scene, table: SteadyTable):
        super().__init__(scene, table)
        equations = scene.equations
        self.cycle: PeriodicMotion = find_periodic(
            equations.switching.machine, table.period, None, equations.force, begin=np.ravel(equations.initial[:2])
        )
        self.motion, self.period = self.cycle.motion, self.cycle.period
        self.length = self.cycle.period
        self.outputs = self._chosen()
        self.function = closed_form(self.outputs, self.motion)

    def of_coordinates(self, order: int, times: np.ndarray) -> np.ndarray:
        return self.motion.derivative(order)(times) if order else self.motion(times)

    def facts(self) -> Iterator[tuple[str, str]]:
        yield from super().facts()
        yield "stability", "small disturbances decay" if self.cycle.is_stable else "small disturbances do not decay"
        yield "residual", f"{self.cycle.residual:.2g} of the range of each coordinate and velocity"

    def notices(self) -> Iterator[Notice]:
        in_table = (NoticeKind.SWITCH, NoticeKind.JUMP, NoticeKind.IMPULSE)
        yield from (one for one in self.motion.notices if one.kind not in in_table)
        if not self.cycle.is_stable:
            text = "small disturbances do not decay: a motion stays near this cycle for some time only"
            yield Notice(NoticeKind.UNSTABLE, text, doubtful=True)
        if self.cycle.drift.any():
            moving = [name for name, one in zip(self.cycle.names, self.cycle.drift) if one]
            yield Notice(NoticeKind.RIGID_BODY, f"{', '.join(moving)}: moves on in each period")

    def tables(self) -> Iterator[TextTable]:
        yield from super().tables()
        multipliers, _ = self.cycle._tables()
        yield self.motion.event_table(self.shown.text, MOST_EVENTS)
        yield multipliers

    def data(self) -> dict[str, Any]:
        return {**super().data(), **self.cycle.to_dict()}

    def arrays(self) -> dict[str, np.ndarray]:
        return {**super().arrays(), "multipliers": self.cycle.multipliers}
