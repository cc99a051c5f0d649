"""A model over its speed: Campbell or interference diagram, critical speeds, stability; of a rotor unbalance response and a waterfall."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ..ground.checks import counted
from ..ground.display import TextTable, number_text, with_unit
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS
from ..mechanics.rotating import (
    CriticalSpeed,
    UnbalancePeak,
    UnbalanceResponse,
    campbell,
    critical_points,
    critical_points_by_order,
    direction,
    speed_ranges,
    unbalance_response,
    with_resonances,
)
from ..page.animation import ModePicture, Shapes, cycle
from ..page.content import Curve, Guide, Marks, Plot, axis_of, curve_with_gaps
from ..page.figure import PALETTE
from ..scene.run.drawing import ShapeDrawing
from ..scene.run.stages import is_animated
from ..scene.schema.analysis_tables import CampbellTable, OrdersTable
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..mechanics.system import MechanicalSystem
    from ..scene.run.scene import Scene

#: The highest speed by default: this many times the highest critical speed of order 1.
BEYOND = 1.25

#: Coordinates whose largest peak is printed.
MOST_PEAKS = 12

#: rev/min in rad/s.
RPM = np.pi / 30

#: Patterns of dashes of modes, by their whirl.
DASHES = {"forward": 0, "backward": 1, "planar": 2, "mixed": 3}

#: Amplitudes below this part of the largest are not shown on logarithmic axes.
SMALLEST = 1e-6

#: Lines of a waterfall, the height of the highest peak in distances between them, half the width of a peak as a part of the axis.
LINES, HIGHEST, HALF_WIDTH = 36, 7.0, 0.012

#: Frequencies at which it is decided which parts of a line are hidden by those before it.
HIDING = 2001


class CampbellDiagram(Analysis):
    """Eigenvalues of a rotor over its speed, each mode followed through crossings; critical speeds, limits of stability, unbalance response.

    Critical speeds come from one eigenproblem for each order, not from a search. The waterfall is a sequence of steady states. Of a
    driveline or another model of which nothing depends on the speed it is the interference diagram: constant eigenfrequencies and lines of the
    orders of [orders], or of those given. Writes NAME.campbell.html, .png and .json.
    """

    name = "campbell"
    settings = CampbellTable
    options: ClassVar = {"orders": "--order"}
    formats = ("page", "images", "json")

    @classmethod
    def solve(cls, scene: Scene, settings: CampbellTable | None) -> Answer:
        own = SpeedDiagram(scene, settings)
        notices = list(scene.notices)
        if not own.is_stable:
            notices.append(Notice(NoticeKind.UNSTABLE, f"{own.range_text}; {own.stability_text}."))
        if any(not np.isfinite(peak.amplitude) for response in own.responses.values() for peak in response.peaks):
            text = "without damping there is no steady state at a critical speed: the amplitude has no bound"
            notices.append(Notice(NoticeKind.UNSTABLE, text))
        facts = [("speeds", own.range_text), ("stability", own.stability_text)]
        if own.diagram.system.turns:
            facts.append(("spectra", str(own.diagram.evaluations)))
        return cls.of(
            scene,
            title=f"{scene.heading}: over the speed",
            facts=tuple(facts),
            tables=tuple(own.tables()),
            notices=tuple(notices),
            data={"title": scene.heading, **own.data()},
            plots=own.plots,
            most_rows=None,
            keys=(),
            on_page=lambda: own.on_page(scene),
        )


class SpeedDiagram:
    """A model at speeds of a range: its eigenvalues, and the steady states of a rotor under its unbalance by order, none without unbalance."""

    def __init__(self, scene: Scene, table: CampbellTable | None, orders: Sequence[float] | None = None):
        """At the speeds of a table; its orders are those with lines, and with critical speeds where no others are given."""
        system = scene.equations.rotor or scene.equations.system
        if table is None and scene.table.orders is None and (system is None or not system.turns):
            raise InputError(
                "nothing of this model turns; give it a rotor, or a gyroscopic or circulatory matrix, below [model], to compute a "
                "Campbell diagram, or orders of an excitation as [[orders.excitation]] or --order for an interference diagram"
            )
        if system is None:
            raise InputError("a diagram over the speed needs a model with mass, damping and stiffness")
        table = _completed(table or CampbellTable(), scene.table.orders)
        self.shown, self.orders = scene.equations.coordinates.shown, table.orders
        self._all_orders = table.orders if orders is None else orders
        speeds = np.linspace(*_speed_range(system, table), table.points)
        self.turns, self.diagram = speeds / RPM, campbell(system, speeds)

    @cached_property
    def responses(self) -> dict[float, UnbalanceResponse]:
        """The steady states under the unbalance of a rotor, by order."""
        system, speeds = self.diagram.system, self.diagram.speeds
        if not system.turns or system.unbalance is None or not system.unbalance.any():
            return {}
        near = with_resonances(speeds, [point for order in self.orders for point in critical_points(system, order)])
        return {order: unbalance_response(system, near, order=order) for order in self.orders}  # all at the same speeds

    @cached_property
    def critical(self) -> list[CriticalSpeed]:
        """The critical speeds of all orders within the range, by order."""
        low, high = self.diagram.speeds[[0, -1]]
        points = critical_points_by_order(self.diagram.system, self._all_orders)
        return [point for point in points if low <= point.speed <= high]

    @property
    def range_text(self) -> str:
        """The number of modes, the range, and whether it has critical speeds."""
        modes = counted(self.diagram.eigenvalues.shape[1], "mode")
        none = "" if self.critical else f"; no critical speed of {'these orders' if len(self.orders) > 1 else 'this order'}"
        return f"{modes} from {self.turns[0]:.6g} to {self.turns[-1]:.6g} rev/min{none}"

    @property
    def stability_text(self) -> str:
        """Where motions grow, or how slowly they decay."""
        margins, limits = self.diagram.stability_margins, self.diagram.stability_limits
        if limits:
            return f"a motion begins to grow, or ceases to, at {', '.join(f'{limit / RPM:.8g} rev/min' for limit in limits)}"
        if not self.is_stable:
            return f"a motion grows at {'all' if (margins < 0).all() else 'some'} speeds"
        if not margins.any():
            return "no motion grows, none decays"
        least = int(margins.argmin())
        where = f", at {self.diagram.speeds[least] / RPM:.6g} rev/min" if self.diagram.system.turns else ""
        return f"no motion grows; the least decay rate is {number_text(float(margins[least]))} 1/s{where}"

    @property
    def is_stable(self) -> bool:
        """Whether no eigenvalue has a positive real part at any of the speeds, except rounding errors."""
        noise = EPS**0.5 * np.abs(self.diagram.eigenvalues).max(initial=0.0)
        return bool((self.diagram.stability_margins >= -noise).all())

    def tables(self) -> Iterator[TextTable]:
        """Critical speeds, modes, peaks of the unbalance response."""
        diagram = self.diagram
        critical = tuple(
            (f"{one.order:g}", *map(number_text, (one.speed / RPM, _hz(one))), direction(one.whirl), number_text(one.damping_ratio))
            for one in self.critical
        )
        ends, rates = diagram.frequencies_hz[[0, -1]], -diagram.eigenvalues.real
        columns = zip(*ends, diagram.damping_ratios.min(axis=0), rates.min(axis=0))
        modes = tuple(
            (str(number), whirl, *(number_text(float(value) + 0.0) for value in values))
            for number, (whirl, values) in enumerate(zip(diagram.directions, columns), 1)
        )
        low, high = (f"Hz at {turns:.6g}" for turns in self.turns[[0, -1]])
        peaks = [(order, peak) for order, response in self.responses.items() for peak in response.peaks]
        largest = [(order, peak) for order, one in self.responses.items() for peak in _largest(one)]
        heads = ("order", "coordinate", "rev/min", "amplitude")
        tables = [
            TextTable("Critical speeds", ("order", "rev/min", "Hz", "whirl", "damping ratio"), critical),
            TextTable("Modes over the speed in rev/min", ("no.", "whirl", low, high, "least ratio", "least decay 1/s"), modes),
        ]
        every = (
            *(tables if diagram.system.turns else map(_without_whirl, tables)),
            TextTable("Largest peaks of the unbalance response", heads, self._rows(largest)),
            TextTable(
                "All peaks of the unbalance response", heads, self._rows(peaks if len(peaks) > MOST_PEAKS else []), folded=True
            ),
        )
        return (table for table in every if table.rows)

    def _rows(self, peaks: list[tuple[float, UnbalancePeak]]) -> tuple[tuple[str, ...], ...]:
        rows = []
        for order, peak in peaks:
            unit, factor = self.shown.of(peak.unit)
            size = with_unit(factor * peak.amplitude, unit) if np.isfinite(peak.amplitude) else "unbounded"
            rows.append((f"{order:g}", peak.coordinate, number_text(peak.speed / RPM), size))
        return tuple(rows)

    def data(self) -> dict:
        """The rotor in SI; eigenvalues as [real, imaginary], unbounded amplitudes as null."""
        diagram = self.diagram
        modes = zip(diagram.directions, diagram.eigenvalues.T, diagram.damping_ratios.T)
        return {
            "speeds": diagram.speeds,
            "modes": [
                {"direction": whirl, "eigenvalues": np.array([values.real, values.imag]).T, "damping_ratios": ratios}
                for whirl, values, ratios in modes
            ],
            "critical_speeds": [
                {
                    "order": point.order,
                    "speed": point.speed,
                    "direction": direction(point.whirl),
                    "damping_ratio": point.damping_ratio,
                    "eigenvalue": [point.eigenvalue.real, point.eigenvalue.imag],
                }
                for point in self.critical
            ],
            "stability_margins": diagram.stability_margins,
            "stability_limits": diagram.stability_limits,
            "unbalance_response": [
                {
                    "order": order,
                    "speeds": response.speeds,
                    "amplitudes": dict(zip(response.system.names, response.amplitudes.T)),
                    "peaks": [vars(peak) for peak in response.peaks],
                }
                for order, response in self.responses.items()
            ],
        }

    def plots(self) -> Iterator[Plot]:
        """Campbell diagram, damping, unbalance response by unit, waterfall."""
        yield self.campbell_plot()
        if self.diagram.damping_ratios.any():
            limit = Guide("", (self.turns[0], 0.0), (self.turns[-1], 0.0), "limit")
            more: dict[str, Any] = {"guides": (limit,), "note": "Below 0 a motion grows.", "includes": (0.0,)}
            yield self._modes("Damping over the speed", "", self.diagram.damping_ratios, "damping ratio", **more)
        if self.responses:
            for unit in dict.fromkeys(self.diagram.system.units.values()):
                yield from self._amplitudes(unit)
            yield self._waterfall()

    def on_page(self, scene: Scene) -> dict[str, Any]:
        """The shapes at the critical speeds, drawn as the model of the run, whose list is the table of these speeds."""
        names, critical, (table, *others) = scene.equations.coordinates.names, self.critical, self.tables()
        if not critical or not is_animated(scene) or tuple(self.diagram.system.names) != names:
            return {}
        swinging = ShapeDrawing(scene, [one.shape for one in critical])
        pictures = []
        for one, row in zip(critical, table.rows):
            factor, facts = swinging.amplitude(one.shape), tuple(zip(table.columns, row))
            paths, period = swinging.paths(one.shape, factor), 2 * np.pi / abs(one.eigenvalue.imag)
            name = f"{row[1]} rev/min, order {row[0]}"
            pictures.append(ModePicture(name, facts[2:], values=cycle(one.shape), paths=paths, period=period, scale=factor))
        drawing = replace(swinging.drawing, posing=None)
        return {"tables": tuple(others), "animation": Shapes(drawing, names, tuple(pictures), "critical speed")}

    def _modes(self, title: str, unit: str, values: np.ndarray, quantity: str, **more) -> Plot:
        """A curve for each mode, with the dashes of its whirl."""
        turns, colors = self.diagram.system.turns, len(PALETTE)
        rounds = [DASHES[whirl] if turns else 0 for whirl in self.diagram.directions]
        curves = tuple(
            Curve(f"{i + 1} {whirl}" if turns else f"mode {i + 1}", column, i % colors + colors * rounds[i])
            for i, (whirl, column) in enumerate(zip(self.diagram.directions, values.T))
        )
        axes: dict[str, Any] = {"across_unit": "rev/min", "quantity": quantity, "variable": "speed", "shown": len(curves)}
        return Plot(title, unit, self.turns, curves, **axes, **more)

    def campbell_plot(self) -> Plot:
        """Frequencies of the modes over the speed, with lines of the orders and marks at critical speeds."""
        frequencies = self.diagram.damped_frequencies / (2 * np.pi)
        low, high, top = self.turns[0], self.turns[-1], 10.0 * float(frequencies.max(initial=0.0)) or 1.0
        orders = (Guide(f"{order:g}×", (low, order * low / 60), (high, order * high / 60), "line") for order in self.orders)
        limits = (Guide("limit of stability", (one / RPM, 0.0), (one / RPM, top), "limit") for one in self.diagram.stability_limits)
        critical = [one for one in self.critical if one.order in self.orders]
        points = np.reshape([(one.speed / RPM, _hz(one)) for one in critical], (-1, 2))
        turns = self.diagram.system.turns
        whirls = (f", {direction(one.whirl)}" if turns else f", order {one.order:g}" for one in critical)
        texts = (f"{one.speed / RPM:.6g} rev/min, {_hz(one):.5g} Hz{whirl}" for one, whirl in zip(critical, whirls))
        marks = (Marks("critical speed", points, tuple(texts)),) if critical else ()
        note = "Solid lines whirl forward, dashed ones backward, dotted ones are planar; a mode keeps its colour through crossings."
        if not turns:
            note = "Nothing of this model depends on the speed: an order is in resonance where its line crosses that of a mode."
        more: dict[str, Any] = {"guides": (*orders, *limits), "marks": marks, "note": note, "includes": (0.0,), "is_large": True}
        return self._modes(f"{'Campbell' if turns else 'Interference'} diagram", "Hz", frequencies, "damped frequency", **more)

    def _amplitudes(self, unit: str) -> Iterator[Plot]:
        """Amplitudes of the coordinates in m, or of those in rad."""
        response, (text, factor) = self.responses[self.orders[0]], self.shown.of(unit)
        own = [j for j, name in enumerate(response.system.names) if response.system.units[name] == unit]
        values = factor * np.where(np.isfinite(response.amplitudes), response.amplitudes, np.nan)
        least = SMALLEST * float(np.nanmax(values[:, own], initial=0.0)) or SMALLEST
        own = [j for j in own if np.nanmax(values[:, j], initial=0.0) > least]
        names = [response.system.names[j] for j in own]
        curves = tuple(curve_with_gaps(name, np.where(values[:, j] > least, values[:, j], np.nan)) for name, j in zip(names, own))
        marks = []
        for number, name in enumerate(names):
            peaks = [one for one in response.peaks if one.coordinate == name and factor * one.amplitude > least]
            points = np.array([(one.speed / RPM, factor * one.amplitude) for one in peaks if np.isfinite(one.amplitude)])
            texts = (f"{name}: {with_unit(float(f'{y:.5g}'), text)} at {x:.6g} rev/min" for x, y in points)
            marks += [Marks("", points, tuple(texts), curve=number)] if len(points) else []
        note = f"The steady state at each constant speed, order {self.orders[0]:g}; circles are peaks."
        title = f"{'Displacements' if unit == 'm' else 'Angles'} under unbalance"
        axes: dict[str, Any] = {"across_unit": "rev/min", "quantity": "amplitude", "variable": "speed", "scales": ("linear", "log")}
        if curves:
            turns = response.speeds / RPM
            yield Plot(title, text, turns, curves, marks=tuple(marks), note=note, shown=len(curves), **axes)

    def _waterfall(self) -> Plot:
        """Spectra of steady states at rising speeds, one behind the other."""
        response = next(iter(self.responses.values()))
        units = [response.system.units[name] for name in response.system.names]
        largest = [np.nan_to_num(one.amplitudes, posinf=0.0) for one in self.responses.values()]
        place = int(np.argmax(np.where(np.array(units) == units[0], np.max(largest, axis=(0, 1)), -1.0)))
        name, (unit, factor) = response.system.names[place], self.shown.of(units[place])
        even = np.linspace(response.speeds[0], response.speeds[-1], min(LINES, len(self.turns)))
        steps = np.unique(np.searchsorted(response.speeds, even).clip(max=len(response.speeds) - 1))
        turns = response.speeds[steps] / RPM
        heights = np.array([one.amplitudes[steps, place] for one in self.responses.values()])
        top = float(heights[np.isfinite(heights)].max(initial=0.0)) or 1.0
        heights = np.minimum(heights, top) * (HIGHEST * (turns[-1] - turns[0]) / max(len(turns) - 1, 1) / top)
        right = axis_of(0.0, 1.06 * max(self.orders) * turns[-1] / 60).high
        x, y = _spectra(turns, np.multiply.outer(list(self.responses), turns / 60), heights, HALF_WIDTH * right, right)
        note = f"Each line is the spectrum of the steady state at one constant speed, the highest of these peaks {with_unit(float(f'{factor * top:.3g}'), unit)}: a run-up so slow"
        note += " that every speed has its steady state. The motion while the speed rises at a finite rate is another one."
        if set(self.orders) != {1.0}:
            note += " Orders other than 1 have a force of the size of the unbalance's, at their multiple of the speed."
        guides = (Guide("", (order * turns[0] / 60, turns[0]), (order * turns[-1] / 60, turns[-1])) for order in self.orders)
        return Plot(
            f"Waterfall of a run-up: {name}",
            "rev/min",
            np.arange(float(len(x))),
            (curve_with_gaps(name, y, along=x),),
            Curve("frequency", np.nan_to_num(x)),
            "Hz",
            "speed",
            "place",
            guides=tuple(guides),
            note=note,
            is_large=True,
        )


def _spectra(bases: np.ndarray, lines: np.ndarray, heights: np.ndarray, half: float, right: float) -> tuple[np.ndarray, np.ndarray]:
    """Spectra above ascending bases, with triangles at their lines: the points that those before do not hide, NaN between parts."""
    corners = (lines[..., None] + [-half, 0.0, half]).clip(0.0, right)
    x = np.unique([*np.linspace(0.0, right, HIDING), *corners.ravel()])
    horizon, points = np.full(len(x), -np.inf), []
    for base, places, sizes in zip(bases, lines.T, heights.T):
        y = base + sum(size * np.maximum(1 - np.abs(x - place) / half, 0.0) for place, size in zip(places, sizes))
        visible, slopes = y >= horizon, np.diff(y) / np.diff(x)
        horizon = np.maximum(y, horizon)
        bends = np.abs(np.diff(slopes)) > EPS**0.5 * np.abs(slopes).max(initial=1.0)
        ends = (visible[1:-1] != visible[:-2]) | (visible[1:-1] != visible[2:])
        kept = np.concatenate([[True], bends | ends, [True]])
        points.append(np.array([x, np.where(visible, y, np.nan)])[:, kept])
        points.append(np.full((2, 1), np.nan))
    return tuple(np.hstack(points[:-1]))


def _hz(point: CriticalSpeed) -> float:
    return abs(point.eigenvalue.imag) / (2 * np.pi)


def _largest(response: UnbalanceResponse) -> list[UnbalancePeak]:
    """The largest peak of each of the first coordinates that have one."""
    highest: dict[str, UnbalancePeak] = {}
    for peak in response.peaks:
        if peak.coordinate not in highest or peak.amplitude > highest[peak.coordinate].amplitude:
            highest[peak.coordinate] = peak
    return list(highest.values())[:MOST_PEAKS]


#: Lines of orders in a diagram, at most.
MOST_ORDERS = 12


def _completed(table: CampbellTable, orders: OrdersTable | None) -> CampbellTable:
    """The table with the range and the orders of [orders] where it gives none."""
    given: dict[str, Any] = {}
    if orders is not None:
        own = sorted({order for one in orders.excitation for order in one.order if order > 0})
        given = {"lowest": orders.lowest, "highest": orders.highest, "orders": own[:MOST_ORDERS]}
    return table.model_copy(update={key: one for key, one in given.items() if key not in table.model_fields_set and one})


def _without_whirl(table: TextTable) -> TextTable:
    """The table without the column of the whirl."""
    place = table.columns.index("whirl")
    columns, *rows = ((*row[:place], *row[place + 1 :]) for row in (table.columns, *table.rows))
    return replace(table, columns=columns, rows=tuple(rows))


def _speed_range(system: MechanicalSystem, table: CampbellTable) -> tuple[float, float]:
    """The lowest and the highest speed in rad/s."""
    ranges = speed_ranges(system)
    if not ranges:
        raise InputError("the speed tables of the bearings have no speed in common")
    low = max(ranges[0][0], 0.0) if table.lowest is None else table.lowest
    high = table.highest
    if high is None:
        critical = [point.speed for point in critical_points(system, 1.0 if system.turns else min(table.orders))]
        if not critical and not np.isfinite(ranges[-1][1]):
            raise InputError("there is no critical speed of order 1 from which a range follows; give --to, or to in the table")
        high = min(BEYOND * max(critical, default=np.inf), ranges[-1][1])
    if not low < high:
        raise InputError(f"campbell: found a range from {low:g} to {high:g} rad/s; expected one that ascends")
    return low, high
