"""The report of a rotor: Campbell diagram, critical speeds, stability, unbalance response; as text, page and data."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...analyses.figures import Picture
from ...analyses.timing import machine
from ...ground.checks import counted
from ...ground.display import TextTable, finite_or_none, number_text, with_unit
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS
from ...mechanics.rotating import (
    Campbell,
    CriticalSpeed,
    UnbalancePeak,
    UnbalanceResponse,
    campbell,
    critical_points,
    direction,
    speed_ranges,
    unbalance_response,
    with_resonances,
)
from ..study_report import StudyReport
from .rotor_pictures import RotorPictures

if TYPE_CHECKING:
    from ...mechanics.system import MechanicalSystem
    from ...scene.run.scene import Scene
    from ...scene.schema.analyses.campbell_table import CampbellTable

#: The highest speed by default: this many times the highest critical speed of order 1.
BEYOND = 1.25

#: Coordinates whose largest peak is printed.
MOST_PEAKS = 12

#: rev/min in rad/s.
RPM = np.pi / 30


class RotorReport(StudyReport):
    """Behaviour of a rotor over its speed.

    Attributes:
        scene: scene of the rotor.
        system: the rotor at rest.
        orders: orders of excitation.
        diagram: eigenvalues over the speed.
        responses: steady states under the unbalance by order; none without unbalance.
    """

    def __init__(self, scene: Scene, table: CampbellTable):
        self.scene, self.orders = scene, table.orders
        system = scene.equations.rotor
        if system is None:
            raise InputError(
                "nothing of this model turns; give it a rotor, or a gyroscopic or circulatory matrix, below [model], to compute a "
                "Campbell diagram"
            )
        self.system, self.machine = system, machine()
        speeds = np.linspace(*speed_range(system, table), table.points)
        self.diagram: Campbell = campbell(system, speeds)
        self.responses: dict[float, UnbalanceResponse] = {}
        if system.unbalance is not None and system.unbalance.any():
            for order in self.orders:
                near = with_resonances(speeds, critical_points(system, order))
                self.responses[order] = unbalance_response(system, near, order=order)

    @property
    def heading(self) -> str:
        """Title of the scene and the values set from outside."""
        return f"{self.scene.heading}: over the speed"

    @cached_property
    def critical(self) -> list[CriticalSpeed]:
        """The critical speeds of all orders within the range, by order."""
        return [point for order in self.orders for point in self.diagram.critical_speeds(order)]

    @property
    def sentences(self) -> tuple[str, ...]:
        """The range, and whether the rotor is stable in it."""
        low, high = self.diagram.speeds[[0, -1]] / RPM
        modes = counted(self.diagram.eigenvalues.shape[1], "mode")
        count = "" if self.critical else f"; no critical speed of {'these orders' if len(self.orders) > 1 else 'this order'}"
        return (f"{modes} from {low:.6g} to {high:.6g} rev/min{count}; {self._stability()}.",)

    def _stability(self) -> str:
        margins, limits = self.diagram.stability_margins, self.diagram.stability_limits
        if limits:
            return f"a motion begins to grow, or ceases to, at {', '.join(f'{limit / RPM:.8g} rev/min' for limit in limits)}"
        if not self.is_stable:
            return f"a motion grows at {'all' if (margins < 0).all() else 'some'} speeds"
        least = int(margins.argmin())
        if not margins.any():
            return "no motion grows, none decays"
        return f"no motion grows; the least decay rate is {number_text(float(margins[least]))} 1/s, at {self.diagram.speeds[least] / RPM:.6g} rev/min"

    @property
    def is_stable(self) -> bool:
        """Whether no eigenvalue has a positive real part at any of the speeds, except rounding errors."""
        noise = EPS**0.5 * np.abs(self.diagram.eigenvalues).max(initial=0.0)
        return bool((self.diagram.stability_margins >= -noise).all())

    @property
    def tables(self) -> tuple[TextTable, ...]:
        """Critical speeds, modes, peaks of the unbalance response."""
        critical = tuple(
            (
                f"{point.order:g}",
                number_text(point.speed / RPM),
                number_text(abs(point.eigenvalue.imag) / (2 * np.pi)),
                direction(point.whirl),
                number_text(point.damping_ratio),
            )
            for point in self.critical
        )
        heads = ("order", "rev/min", "Hz", "whirl", "damping ratio")
        tables = (TextTable("Critical speeds", heads, critical), self._modes(), self._peaks(MOST_PEAKS))
        return tuple(table for table in tables if table.rows)

    def _modes(self) -> TextTable:
        first, last = self.diagram.frequencies_hz[[0, -1]]
        columns = zip(
            self.diagram.directions,
            first,
            last,
            self.diagram.damping_ratios.min(axis=0),
            (-self.diagram.eigenvalues.real).min(axis=0),
        )
        rows = [
            (str(number), whirl, *(number_text(float(value) + 0.0) for value in values))
            for number, (whirl, *values) in enumerate(columns, 1)
        ]
        low, high = self.diagram.speeds[[0, -1]] / RPM
        heads = ("no.", "whirl", f"Hz at {low:.6g}", f"Hz at {high:.6g}", "least ratio", "least decay 1/s")
        return TextTable("Modes over the speed in rev/min", heads, tuple(rows))

    @property
    def page_tables(self) -> tuple[TextTable, ...]:
        """Table of all peaks, where the other table has only the largest."""
        count = sum(len(response.peaks) for response in self.responses.values())
        return (self._peaks(),) if count > MOST_PEAKS else ()

    def _peaks(self, most: int | None = None) -> TextTable:
        """All peaks, or only the largest of each unit."""
        shown = self.scene.equations.coordinates.shown
        rows = []
        for order, response in self.responses.items():
            for peak in _largest(response, most):
                unit, factor = shown.of(peak.unit)
                size = with_unit(factor * peak.amplitude, unit) if np.isfinite(peak.amplitude) else "unbounded"
                rows.append((f"{order:g}", peak.coordinate, number_text(peak.speed / RPM), size))
        title = "Largest peaks of the unbalance response" if most else "All peaks of the unbalance response"
        return TextTable(title, ("order", "coordinate", "rev/min", "amplitude"), tuple(rows))

    def pictures(self) -> list[Picture]:
        """Campbell diagram, damping, unbalance response, waterfall."""
        return RotorPictures(self.diagram, self.critical, self.responses, self.orders, self.scene.equations.coordinates.shown).all()

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the scene, on growing motions, and on unbounded amplitudes."""
        notices = list(self.scene.notices)
        if not self.is_stable:
            notices.append(Notice(NoticeKind.UNSTABLE, self.sentences[0]))
        if any(not np.isfinite(peak.amplitude) for response in self.responses.values() for peak in response.peaks):
            text = "without damping there is no steady state at a critical speed: the amplitude has no bound"
            notices.append(Notice(NoticeKind.UNSTABLE, text))
        return tuple(notices)

    @property
    def is_trusted(self) -> bool:
        """True: values are computed, none is estimated from a grid."""
        return True

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """The scene, how many spectra were computed, then the machine."""
        return (("scene", self.scene.path.name), ("spectra", str(self.diagram.evaluations)), *super().facts)

    def as_json(self) -> dict:
        """The rotor as plain data, in SI; eigenvalues as [real, imaginary], unbounded amplitudes as null."""
        diagram = self.diagram
        return {
            "title": self.scene.heading,
            "speeds": diagram.speeds.tolist(),
            "modes": [
                {
                    "direction": whirl,
                    "eigenvalues": np.array([values.real, values.imag]).T.tolist(),
                    "damping_ratios": ratios.tolist(),
                }
                for whirl, values, ratios in zip(diagram.directions, diagram.eigenvalues.T, diagram.damping_ratios.T)
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
            "stability_margins": diagram.stability_margins.tolist(),
            "stability_limits": list(diagram.stability_limits),
            "unbalance_response": [
                {
                    "order": order,
                    "speeds": response.speeds.tolist(),
                    "amplitudes": {
                        name: [finite_or_none(value) for value in column]
                        for name, column in zip(response.system.names, response.amplitudes.T.tolist())
                    },
                    "peaks": [
                        {
                            "coordinate": peak.coordinate,
                            "speed": peak.speed,
                            "amplitude": finite_or_none(peak.amplitude),
                            "unit": peak.unit,
                        }
                        for peak in response.peaks
                    ],
                }
                for order, response in self.responses.items()
            ],
        }


def _largest(response: UnbalanceResponse, most: int | None) -> list[UnbalancePeak]:
    """The largest peak of each coordinate, at most so many; all peaks without a limit."""
    if most is None:
        return list(response.peaks)
    highest: dict[str, UnbalancePeak] = {}
    for peak in response.peaks:
        if peak.coordinate not in highest or peak.amplitude > highest[peak.coordinate].amplitude:
            highest[peak.coordinate] = peak
    return list(highest.values())[:most]


def speed_range(system: MechanicalSystem, table: CampbellTable) -> tuple[float, float]:
    """The lowest and the highest speed in rad/s."""
    ranges = speed_ranges(system)
    if not ranges:
        raise InputError("the speed tables of the bearings have no speed in common")
    low = max(ranges[0][0], 0.0) if table.lowest is None else table.lowest
    high = table.highest
    if high is None:
        critical = [point.speed for point in critical_points(system)]
        if not critical and not np.isfinite(ranges[-1][1]):
            raise InputError("there is no critical speed of order 1 from which a range follows; give --to or [campbell] to")
        high = min(BEYOND * max(critical, default=np.inf), ranges[-1][1])
    if not low < high:
        raise InputError(f"campbell: found a range from {low:g} to {high:g} rad/s; expected one that ascends")
    return low, high
