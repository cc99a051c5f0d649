"""Excitation by orders of a speed: amplitudes, RMS and largest values of the outputs over the speed, resonances, and maps of a run-up."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..frequency.frequency_response import FrequencyResponse
from ..ground.display import TextTable, number_text, with_unit
from ..ground.errors import InputError, named
from ..ground.notices import Notice, NoticeKind, distinct
from ..ground.quantities import quantity
from ..ground.tolerances import EPS
from ..ground.units import rate_unit
from ..mechanics.channels import OutputNames, channels, chosen_by_name
from ..mechanics.harmonic_sums import common_rate, largest_modulus, root_mean_square
from ..mechanics.rotating import NEAR_POLE, NEAR_RESONANCE, CriticalSpeed
from ..page.content import Cells, Curve, Marks, Plot, curve_with_gaps
from ..scene.coordinates import FORCE_UNITS
from ..scene.file import at
from ..scene.schema.analysis_tables import CampbellTable, FrequencyTable, OrdersTable
from .base import Analysis, Answer
from .campbell import RPM, SMALLEST, SpeedDiagram
from .frequency import Frequency

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

#: Numbers of all amplitudes, and of those in one evaluation of the response.
MOST_NUMBERS, CHUNK = 10_000_000, 1 << 21

#: Speeds near resonances, besides the even ones.
MOST_NEAR = 2000

#: Outputs with plots of their orders and a map; orders with curves in such a plot that are shown at first.
MOST_OUTPUTS, MOST_CURVES = 4, 6

#: Columns and rows of a map, and how far below the largest amplitude it reaches, in dB.
COLUMNS, ROWS, DECIBELS = 72, 54, 60.0

#: Steps of the search for a maximum between two speeds, each of which leaves the golden section of the interval.
STEPS, GOLDEN = 32, (5**0.5 - 1) / 2

#: Distance from a resonance, as a part of its speed, and the growth from there to the resonance itself that only a pole has.
OFFSET, GROWTH = 1e-3, 1e5

#: The quantity of the frequency response by that of the outputs.
RESPONSES = {"displacement": "receptance", "velocity": "mobility", "acceleration": "accelerance", "torque": "force"}


class Orders(Analysis):
    """The steady response to excitations that are multiples of a speed, such as the torques of an engine, over the speed.

    At the speed W an excitation of the order n has the frequency n W. Amplitudes by order, RMS and largest values over a cycle, a table of
    resonances, an interference (Campbell) diagram and maps of a run-up so slow that every speed has its steady state. The unbalance of a
    rotor is part of the excitation. Writes NAME.orders.html, .csv and .npz.
    """

    name = "orders"
    settings = OrdersTable
    options: ClassVar = {"outputs": "--output"}

    @classmethod
    def solve(cls, scene: Scene, settings: OrdersTable | None) -> Answer:
        with at(scene.file_name, "orders"):
            own = _RunUp(scene, settings or OrdersTable())
        return cls.of(
            scene,
            title=f"{scene.heading}: orders over the speed",
            facts=tuple(own.facts()),
            tables=tuple(own.tables()),
            notices=distinct(scene.notices, own.notices()),
            data=own.data(),
            plots=own.plots,
            columns=lambda: {"": own.columns()},
            arrays=own.arrays,
        )


@dataclass(frozen=True)
class _Excitation:
    """The load Re((constant + W^2 square) e^(i n W t)) on an input."""

    on: str
    order: float
    constant: complex
    square: complex


def _excitations(scene: Scene, table: OrdersTable) -> Iterator[_Excitation]:
    """The excitations of the table, and the unbalance of a rotor."""
    system, rotor = scene.equations.system, scene.equations.rotor
    known = channels(system, "inputs")
    prescribed = {coordinate: row for row, coordinate in scene.table.prescribed.items()}
    for number, one in enumerate(table.excitation, 1):
        with named(f"excitation[{number}]"):
            (channel,) = chosen_by_name("on", prescribed.get(one.on, one.on), known, ())
            unit = FORCE_UNITS.get(channel.unit, "1")
            if channel.row is not None:
                if one.unbalance is not None:
                    raise InputError(f'unbalance is a force, and "{one.on}" a prescribed motion; give amplitude')
                unit = rate_unit(channel.unit, system.rows[channel.row].order)
            elif one.unbalance is not None:
                unit = {"m": "kg*m", "rad": "kg*m^2"}.get(channel.unit, "1")
            phases = one.phase * len(one.order) if len(one.phase) == 1 else one.phase
            key = "amplitude" if one.unbalance is None else "unbalance"
            for order, value, phase in zip(one.order, getattr(one, key), phases):
                with named(key):
                    size = quantity(value, unit) * np.exp(1j * phase)
                if one.law == "speed^2" or one.unbalance is not None:
                    yield _Excitation(channel.name, order, 0.0, size / (one.at or 1.0) ** 2)
                else:
                    yield _Excitation(channel.name, order, size, 0.0)
    if rotor is not None and rotor.unbalance is not None:
        for place in np.flatnonzero(rotor.unbalance):
            yield _Excitation(rotor.names[place], 1.0, 0.0, complex(rotor.unbalance[place]))


class _RunUp:
    """A model under excitations by order at all speeds of a range, each with its steady state."""

    def __init__(self, scene: Scene, table: OrdersTable):
        self.scene, self.table, equations = scene, table, scene.equations
        self.shown = equations.coordinates.shown
        if equations.system is None or equations.control is not None:
            raise InputError("orders need a model with mass, damping and stiffness: of kind lumped, matrices or robot")
        self.excitations = list(_excitations(scene, table))
        if not self.excitations:
            raise InputError(
                'there is no excitation; give [[orders.excitation]] with on, order and amplitude, e.g. on = "engine", order = [0.5, 1], '
                'amplitude = ["20 N*m", "90 N*m"]'
            )
        self.orders = np.array(sorted({one.order for one in self.excitations}))
        self.inputs = list(dict.fromkeys(one.on for one in self.excitations))
        self.constant, self.square = np.zeros((2, len(self.orders), len(self.inputs)), dtype=complex)
        for one in self.excitations:
            place = np.searchsorted(self.orders, one.order), self.inputs.index(one.on)
            self.constant[place] += one.constant
            self.square[place] += one.square
        positive = self.orders[self.orders > 0].tolist()
        if not positive:
            raise InputError("order: found 0 alone, a mean value at every speed; give the orders that vary with the speed, too")
        given = {"from": table.lowest, "to": table.highest, "orders": positive[:12], "points": table.points}
        limits = CampbellTable.model_validate({key: one for key, one in given.items() if one is not None})
        self.diagram = SpeedDiagram(scene, limits, positive)
        low, high = self.diagram.diagram.speeds[[0, -1]]
        base = np.linspace(low, high, table.points)
        self.speeds = self._with_resonances(base)
        self.outputs = self.fixed.outputs
        chosen = OutputNames.of(equations.system).chosen("outputs", self.outputs, table.quantity, ())
        self.units, self.quantities = [one.unit for one in chosen], [one.quantity for one in chosen]
        size = len(self.orders) * len(self.outputs) * len(self.speeds)
        if size > MOST_NUMBERS:
            raise InputError(
                f"found {len(self.orders)} orders, {len(self.outputs)} outputs and {len(self.speeds)} speeds; expected at most "
                f"{MOST_NUMBERS:g} amplitudes: name the outputs of interest in outputs, or give fewer points"
            )

    def _with_resonances(self, base: np.ndarray) -> np.ndarray:
        """The even speeds, and further ones where amplitudes change fast, those of the largest excitations first."""
        near: list[float] = []
        sizes = np.abs(self.constant + base[-1] ** 2 * self.square).max(axis=1)
        for one in sorted(self.critical, key=lambda one: -sizes[np.searchsorted(self.orders, one.order)]):
            if len(near) < MOST_NEAR:
                near += (one.speed * (1 + (one.damping_ratio * NEAR_RESONANCE if _is_damped(one) else NEAR_POLE))).tolist()
        inside = [speed for speed in near if base[0] < speed < base[-1]]
        return np.unique([*base, *inside])

    @property
    def critical(self) -> list[CriticalSpeed]:
        """The resonances within the range, by order."""
        return self.diagram.critical

    # The response.

    def _response(self, system=None) -> FrequencyResponse:
        """H of the inputs, of the rotor at a speed or of a model that does not depend on it."""
        table = self.table
        given = {"inputs": self.inputs, "quantity": RESPONSES.get(table.quantity, table.quantity)}
        given |= {key: own for key in ("outputs", "relative_to") if (own := getattr(table, key)) is not None}
        scene = self.scene
        if system is not None:
            scene = replace(scene, equations=replace(scene.equations, system=system))
        return Frequency(scene, FrequencyTable.model_validate(given)).empty

    @cached_property
    def fixed(self) -> FrequencyResponse:
        """H of the model as it is."""
        return self._response()

    def at(self, places: np.ndarray, speeds: np.ndarray) -> np.ndarray:
        """Complex amplitudes at pairs of an order, by its place, and a speed, shape (outputs, F); infinite at an undamped resonance."""
        loads = self.constant[places] + np.square(speeds)[:, None] * self.square[places]
        loads[self.orders[places] == 0] = loads[self.orders[places] == 0].real
        frequencies = self.orders[places] * speeds / (2 * np.pi)
        rotor = self.scene.equations.rotor
        if rotor is None:
            return self._amplitudes(self.fixed, frequencies, loads)
        values = np.zeros((len(self.outputs), len(places)), dtype=complex)
        has_one_stiffness = rotor.circulatory is None and not rotor.speed_tables
        resting = (frequencies == 0) & has_one_stiffness
        values[:, resting] = self._amplitudes(self.fixed, frequencies[resting], loads[resting])
        for speed in np.unique(speeds[~resting]):
            own = np.flatnonzero((speeds == speed) & ~resting)
            values[:, own] = self._amplitudes(self._response(rotor.at_speed(float(speed))), frequencies[own], loads[own])
        return values

    def _amplitudes(self, response: FrequencyResponse, frequencies: np.ndarray, loads: np.ndarray) -> np.ndarray:
        numbers = len(response.outputs) * len(self.inputs)
        parts = np.array_split(np.arange(len(frequencies)), max(1, len(frequencies) * numbers // CHUNK))
        return np.hstack([_products(_values(response(frequencies[part])), loads[part].T) for part in parts])

    @cached_property
    def values(self) -> np.ndarray:
        """Complex amplitudes in SI, shape (orders, outputs, speeds)."""
        places = np.repeat(np.arange(len(self.orders)), len(self.speeds))
        values = self.at(places, np.tile(self.speeds, len(self.orders)))
        return values.reshape(len(self.outputs), len(self.orders), -1).swapaxes(0, 1)

    @cached_property
    def rms(self) -> np.ndarray:
        """RMS values over a cycle, shape (outputs, speeds)."""
        return root_mean_square(self.orders, self.values)

    @cached_property
    def largest(self) -> np.ndarray:
        """The largest moduli over a cycle, shape (outputs, speeds)."""
        return self._largest(self.values)

    def _largest(self, values: np.ndarray) -> np.ndarray:
        return largest_modulus(self.orders, values.reshape(len(self.orders), -1)).reshape(values.shape[1:])

    @cached_property
    def has_cycle(self) -> bool:
        """Whether all orders have a common period."""
        return common_rate(self.orders) is not None

    def _at_own(self, speeds: np.ndarray) -> np.ndarray:
        """Complex amplitudes of each output at a speed of its own, shape (orders, outputs)."""
        each, orders = np.arange(len(self.outputs)), np.arange(len(self.orders))
        values = self.at(np.repeat(orders, len(each)), np.tile(speeds, len(orders))).reshape(len(each), len(orders), len(each))
        return values[each, :, each].T

    @cached_property
    def maxima(self) -> tuple[np.ndarray, np.ndarray]:
        """The largest moduli of all speeds and the speeds where they are, shape (outputs,) each, between the speeds by golden sections."""
        known = self.largest
        best = known.argmax(axis=1)
        low, high = (self.speeds[np.clip(best + step, 0, len(self.speeds) - 1)] for step in (-1, 1))

        def of(speeds: np.ndarray) -> np.ndarray:
            return largest_modulus(self.orders, self._at_own(speeds))

        tops, places = known.max(axis=1), self.speeds[best]
        inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)]
        heights = [of(speeds) for speeds in inner]
        for _ in range(STEPS):
            left = heights[0] > heights[1]
            low, high = np.where(left, low, inner[0]), np.where(left, inner[1], high)
            new = np.where(left, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
            height = of(new)
            inner = [np.where(left, new, inner[1]), np.where(left, inner[0], new)]
            heights = [np.where(left, height, heights[1]), np.where(left, heights[0], height)]
        for speeds, own in zip(inner, heights):
            better = (own > tops) & np.isfinite(own)
            tops, places = np.where(better, own, tops), np.where(better, speeds, places)
        return tops, places

    @cached_property
    def resonant(self) -> np.ndarray:
        """Amplitudes of the order at each resonance, shape (outputs, resonances); infinite where they have no bound."""
        if not self.critical:
            return np.zeros((len(self.outputs), 0))
        places = np.searchsorted(self.orders, [one.order for one in self.critical])
        speeds = np.array([one.speed for one in self.critical])
        values, near = (np.abs(self.at(places, factor * speeds)) for factor in (1.0, 1.0 + OFFSET))
        undamped = np.array([not _is_damped(one) for one in self.critical])
        return np.where(undamped & ~(values <= GROWTH * near), np.inf, values)

    # The answer.

    def facts(self) -> Iterator[tuple[str, str]]:
        """Speeds, orders, excitations and outputs."""
        turns = self.speeds[[0, -1]] / RPM
        yield "speeds", f"{turns[0]:.6g} to {turns[1]:.6g} rev/min, {len(self.speeds)} of them"
        listed = ", ".join(f"{order:.6g}" for order in self.orders[:12])
        yield "orders", listed + (f" … ({len(self.orders)} in all)" if len(self.orders) > 12 else "")
        yield "excitation", f"on {', '.join(self.inputs)}"
        yield "outputs", ", ".join(self.outputs)
        yield "stability", self.diagram.stability_text

    def notices(self) -> Iterator[Notice]:
        """Resonances without damping, instability, missing steady states, and orders without a common cycle."""
        if not self.diagram.is_stable:
            yield Notice(NoticeKind.UNSTABLE, f"{self.diagram.stability_text}: there steady states are not reached", doubtful=True)
        if np.isinf(self.resonant).any():
            text = "without damping there is no steady state at a resonance: the amplitude has no bound"
            yield Notice(NoticeKind.UNSTABLE, text)
        without = ~np.isfinite(self.values)
        at_zero = without[:, :, self.speeds == 0].any(axis=(0, 2)) | without[self.orders == 0].any(axis=(0, 2))
        if at_zero.any():
            names = ", ".join(name for name, one in zip(self.outputs, at_zero) if one)
            text = f"a constant load moves {names} away without end, so that there is no steady state at rest or under an order 0"
            yield Notice(NoticeKind.RIGID_BODY, text)
        if not self.has_cycle:
            text = "the orders have no common cycle: the largest value is the sum of all amplitudes, which the motion approaches in time"
            yield Notice(NoticeKind.ACCURACY, text)
        if self.scene.equations.force is not None and self.scene.table.force:
            text = "forces of [[force]] are no part of the excitation by orders"
            yield Notice(NoticeKind.OMITTED, text)

    def tables(self) -> Iterator[TextTable]:
        """The largest values of each output, and the resonances."""
        tops, places = self.maxima
        rows, at_top = [], self._at_own(places)
        for i, name in enumerate(self.outputs):
            own = at_top[:, i]
            bound = [one for one, size in zip(self.critical, self.resonant[i]) if np.isinf(size)]
            if bound or not np.isfinite(tops[i]):
                place, order = (bound[0].speed, f"{bound[0].order:g}") if bound else (places[i], "–")
                rows.append((name, "unbounded", number_text(place / RPM), "–", order, "–"))
                continue
            first = int(np.abs(own).argmax())
            rms = float(root_mean_square(self.orders, own[:, None])[0])
            sizes = [self._text(i, value) for value in (tops[i], rms, np.abs(own[first]))]
            rows.append((name, sizes[0], number_text(places[i] / RPM), sizes[1], f"{self.orders[first]:g}", sizes[2]))
        heads = ("output", "largest", "rev/min", "RMS there", "order", "its amplitude")
        title = f"Largest values: {', '.join(dict.fromkeys(self.quantities))}"
        note = "largest: modulus over a cycle" if self.has_cycle else "largest: sum of the amplitudes"
        yield TextTable(title, heads, tuple(rows), f"{note}; order: the largest one there")
        if self.critical:
            named_outputs = self.outputs[:MOST_OUTPUTS]
            cells = (
                (
                    f"{one.order:g}",
                    *map(number_text, (one.speed / RPM, abs(one.eigenvalue.imag) / (2 * np.pi), one.damping_ratio)),
                    *(self._text(i, float(self.resonant[i, k])) for i in range(len(named_outputs))),
                )
                for k, one in enumerate(self.critical)
            )
            columns = ("order", "rev/min", "Hz", "damping", *named_outputs)
            yield TextTable("Resonances, with the amplitudes of the order there", columns, tuple(cells))

    def _text(self, output: int, value: float) -> str:
        unit, factor = self.shown.of(self.units[output])
        return with_unit(float(f"{factor * value:.5g}"), unit) if np.isfinite(value) else "unbounded"

    def data(self) -> dict[str, Any]:
        tops, places = self.maxima
        return {
            "speeds": {"from": self.speeds[0], "to": self.speeds[-1], "count": len(self.speeds)},
            "orders": self.orders,
            "quantities": self.quantities,
            "outputs": self.outputs,
            "units": self.units,
            "has_common_cycle": self.has_cycle,
            "largest": [
                {"output": name, "value": top, "speed": place}
                for name, top, place in zip(self.outputs, tops.tolist(), places.tolist())
            ],
            "resonances": [
                {
                    "order": one.order,
                    "speed": one.speed,
                    "frequency_hz": abs(one.eigenvalue.imag) / (2 * np.pi),
                    "damping_ratio": one.damping_ratio,
                    "amplitudes": dict(zip(self.outputs, self.resonant[:, k])),
                }
                for k, one in enumerate(self.critical)
            ],
        }

    def columns(self) -> dict[str, np.ndarray]:
        """Largest and RMS values and the amplitude of each order over the speed, in the units shown."""
        result = {"speed (rev/min)": self.speeds / RPM}
        for i, (name, unit) in enumerate(zip(self.outputs, self.units)):
            text, factor = self.shown.of(unit)
            result[f"largest {name} ({text})"], result[f"RMS {name} ({text})"] = factor * self.largest[i], factor * self.rms[i]
            for order, own in zip(self.orders, self.values[:, i]):
                result[f"order {order:g} {name} ({text})"] = factor * np.abs(own)
        return result

    def arrays(self) -> dict[str, np.ndarray]:
        """Speeds, orders, complex amplitudes, RMS and largest values in SI."""
        own = {"speeds": self.speeds, "orders": self.orders, "amplitudes": self.values, "rms": self.rms, "largest": self.largest}
        return {**own, "outputs": np.array(self.outputs), "units": np.array(self.units)}

    # Plots.

    def plots(self) -> Iterator[Plot]:
        """Largest and RMS values by unit, the interference diagram, and of the first outputs amplitudes by order and a map."""
        for title, values in (("largest over a cycle", self.largest), ("RMS over a cycle", self.rms)):
            for kind in dict.fromkeys(zip(self.quantities, self.units)):
                yield from self._over_speed(*kind, title, values)
        yield self.diagram.campbell_plot()
        for i in range(min(MOST_OUTPUTS, len(self.outputs))):
            yield from self._by_order(i)
            yield from self._map(i)

    def _over_speed(self, quantity: str, unit: str, title: str, values: np.ndarray) -> Iterator[Plot]:
        text, factor = self.shown.of(unit)
        rows = [i for i, own in enumerate(zip(self.quantities, self.units)) if own == (quantity, unit)]
        curves = tuple(curve_with_gaps(self.outputs[i], factor * _finite(values[i]), i) for i in rows)
        if any(curve.values.any() for curve in curves):
            yield self._plot(f"{quantity}, {title}", quantity, text, curves)

    def _plot(self, title: str, quantity: str, unit: str, curves: Sequence[Curve], **more) -> Plot:
        axes: dict[str, Any] = {"across_unit": "rev/min", "variable": "speed", "quantity": quantity}
        return Plot(title, unit, self.speeds / RPM, tuple(curves), **axes, **more)

    def _by_order(self, output: int) -> Iterator[Plot]:
        """The amplitude of each order over the speed, the largest first, and the RMS value of all."""
        (unit, factor), name = self.shown.of(self.units[output]), self.outputs[output]
        sizes = factor * _finite(np.abs(self.values[:, output]))
        least = SMALLEST * np.nanmax(sizes, initial=0.0)
        sizes = np.where(sizes > least, sizes, np.nan)
        ranked = sorted(np.flatnonzero(np.nanmax(sizes, axis=1, initial=0.0) > 0), key=lambda k: -np.nanmax(sizes[k]))
        if not ranked:
            return
        strongest = sorted(ranked[:MOST_CURVES])
        chosen = [*strongest, *sorted(set(ranked[: 4 * MOST_CURVES]) - set(strongest))]
        rms = factor * _finite(self.rms[output])
        curves = [curve_with_gaps("RMS of all orders", np.where(rms > least, rms, np.nan), 0)]
        curves += [curve_with_gaps(f"order {self.orders[k]:g}", sizes[k], 1 + place) for place, k in enumerate(chosen)]
        points = [(one.speed / RPM, factor * size, one) for one, size in zip(self.critical, self.resonant[output])]
        marks = []
        for place, k in enumerate(chosen, 1):
            own = [(x, y, one) for x, y, one in points if one.order == self.orders[k] and np.isfinite(y)]
            texts = tuple(f"order {one.order:g} at {x:.6g} rev/min: {with_unit(float(f'{y:.4g}'), unit)}" for x, y, one in own)
            marks += [Marks("", np.array([point[:2] for point in own]), texts, curve=place)] if own else []
        note = "Circles: resonances, where the line of an order crosses that of a mode."
        more: dict[str, Any] = {"shown": 1 + len(strongest), "marks": tuple(marks), "note": note if marks else ""}
        yield self._plot(f"{name} by order", self.quantities[output], unit, curves, scales=("linear", "log"), **more)

    def _map(self, output: int) -> Iterator[Plot]:
        """Amplitudes over the speed and the frequency: that of the largest order in each cell, in dB below the largest of all."""
        (unit, factor), name = self.shown.of(self.units[output]), self.outputs[output]
        turns = np.linspace(self.speeds[0] / RPM, self.speeds[-1] / RPM, COLUMNS + 1)
        columns = np.clip(np.searchsorted(turns, self.speeds / RPM, side="right") - 1, 0, COLUMNS - 1)
        lines = np.linspace(0.0, 1.02 * self.orders[-1] * turns[-1] / 60, ROWS + 1)
        sizes, orders = np.full((ROWS, COLUMNS), np.nan), np.zeros((ROWS, COLUMNS))
        for k in np.flatnonzero(self.orders > 0):
            rows = np.clip(np.searchsorted(lines, self.orders[k] * self.speeds / (2 * np.pi), side="right") - 1, 0, ROWS - 1)
            for row, column, size in zip(rows, columns, _finite(np.abs(self.values[k, output]))):
                if not size <= sizes[row, column] and np.isfinite(size):
                    sizes[row, column], orders[row, column] = size, self.orders[k]
        top = np.nanmax(sizes, initial=0.0)
        if not top > 0:
            return
        levels = 20 * np.log10(np.maximum(sizes, top * 10 ** (-DECIBELS / 20)) / top)
        texts = [
            [
                f"order {order:g}, {with_unit(float(f'{factor * size:.4g}'), unit)}" if np.isfinite(size) else ""
                for order, size in zip(*row)
            ]
            for row in zip(orders, sizes)
        ]
        note = f"0 dB: {with_unit(float(f'{factor * top:.4g}'), unit)}. A run-up so slow that every speed has its steady state."
        yield Plot(
            f"Run-up of {name}",
            "Hz",
            turns,
            (),
            across_unit="rev/min",
            quantity="frequency",
            variable="speed",
            cells=Cells(turns, lines, levels, texts, "dB"),
            note=note,
        )


def _is_damped(one: CriticalSpeed) -> bool:
    return abs(one.damping_ratio) > EPS**0.5


def _finite(values: np.ndarray) -> np.ndarray:
    """Values with gaps where they are infinite."""
    return np.where(np.isfinite(values), values, np.nan)


def _products(values: np.ndarray, loads: np.ndarray) -> np.ndarray:
    """H (p, m, F) times loads (m, F): infinite where a load acts on a pole, whatever its phase."""
    with np.errstate(invalid="ignore"):
        total = np.where(loads == 0, 0.0, values * loads).sum(axis=1)
    return np.where(np.isfinite(total), total, np.inf)


def _values(response: FrequencyResponse) -> np.ndarray:
    """H, infinite at a pole on the axis that an entry has; entries without it keep their value, as elastic torques of a free driveline at 0."""
    values = response.values
    if not response.poles_on_lines:
        return values
    values, rates = values.copy(), np.abs(response.poles)
    slowest = rates[rates > 0].min(initial=np.inf)
    for one in response.poles_on_lines:
        rate = abs(one.pole.value) or (slowest if np.isfinite(slowest) else 1.0)
        sizes = [np.abs(own) / rate ** (power + 1) for power, own in enumerate(one.pole.residues)]
        has_pole = np.max(sizes, axis=0) > EPS**0.5 * np.abs(values[..., one.line])
        values[..., one.line] = np.where(has_pole, np.inf, values[..., one.line])
    return values
