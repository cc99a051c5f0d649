"""Figures of a rotor over its speed: Campbell diagram, damping, unbalance response, and a waterfall of a run-up."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...analyses.figures import Picture, power_of_ten
from ...page.animation.figure import PALETTE
from ...page.plots.images import INK, LINE, MUTED, RED

if TYPE_CHECKING:
    from ...mechanics.rotating import Campbell, CriticalSpeed, UnbalanceResponse
    from ...scene.quantities.output_units import OutputUnits

#: rad/s in rev/min.
PER_MINUTE = 30 / np.pi

#: Lines of a waterfall, and the height of the highest in distances between them.
LINES, HIGHEST = 36, 7.0

#: Half the width of a line of a spectrum, of the whole axis.
HALF_WIDTH = 0.012

#: Amplitudes below this part of the largest are not shown on logarithmic axes.
SMALLEST = 1e-6

#: Styles of modes.
DASHES = {"forward": "-", "backward": "--", "mixed": "-.", "planar": ":"}


class RotorPictures:
    """The figures of a rotor.

    Attributes:
        diagram: eigenvalues over the speed.
        critical: speeds, of all orders.
        responses: by order, the steady states under unbalance.
        orders: orders of excitations.
        shown: the units of the output.
    """

    def __init__(
        self,
        diagram: Campbell,
        critical: Sequence[CriticalSpeed],
        responses: Mapping[float, UnbalanceResponse],
        orders: Sequence[float],
        shown: OutputUnits,
    ):
        self.diagram, self.critical, self.responses, self.orders, self.shown = diagram, critical, responses, orders, shown
        self.turns = diagram.speeds * PER_MINUTE

    def all(self) -> list[Picture]:
        """All figures with data."""
        pictures = [self._campbell()]
        if self.diagram.damping_ratios.any():
            pictures.append(self._damping())
        if self.responses:
            pictures += [self._amplitudes(unit) for unit in dict.fromkeys(self.diagram.system.units.values())]
            pictures.append(self._waterfall())
        return pictures

    def _modes(self, axes, values: np.ndarray) -> None:
        """A line for each mode, in the style of its whirl."""
        for number, (column, whirl) in enumerate(zip(values.T, self.diagram.directions)):
            label = f"{number + 1} {whirl}"
            axes.plot(self.turns, column, color=PALETTE[number % len(PALETTE)], linestyle=DASHES[whirl], label=label)
        axes.set_xlim(self.turns[0], self.turns[-1])
        axes.set_xlabel("speed in rev/min")

    def _campbell(self) -> Picture:
        frequencies = self.diagram.damped_frequencies / (2 * np.pi)
        top = 1.08 * float(frequencies.max(initial=0.0)) or 1.0

        def draw(figure) -> None:
            axes = figure.add_subplot()
            self._modes(axes, frequencies)
            for order in self.orders:
                axes.plot(self.turns, order * self.turns / 60, color=MUTED, linewidth=0.9)
                end = min(self.turns[-1], 0.97 * top * 60 / order)
                axes.annotate(f"{order:g}×", (end, order * end / 60), ha="right", va="bottom", color=MUTED)
            points = [(one.speed * PER_MINUTE, one.eigenvalue.imag / (2 * np.pi)) for one in self.critical]
            axes.plot(
                *np.reshape(points, (-1, 2)).T, "o", markersize=4.5, markerfacecolor="white", color=INK, label="critical speed"
            )
            for limit in self.diagram.stability_limits:
                axes.axvline(limit * PER_MINUTE, color=RED, linewidth=1.0, label="limit of stability")
            axes.set_ylim(0.0, top)
            axes.set_ylabel("damped frequency in Hz")
            figure.legend(loc="outside lower left", ncols=5)

        note = "Solid lines whirl forward, dashed ones backward, dotted ones are planar; a mode keeps its colour through crossings."
        return Picture("Campbell diagram", "Frequencies of all modes over the speed, with lines of the orders", 4.2, draw, note)

    def _damping(self) -> Picture:
        def draw(figure) -> None:
            axes = figure.add_subplot()
            self._modes(axes, self.diagram.damping_ratios)
            axes.axhline(0.0, color=RED, linewidth=0.9)
            axes.set_ylabel("damping ratio")
            figure.legend(loc="outside lower left", ncols=5)

        return Picture("Damping over the speed", "Damping ratios of all modes over the speed", 3.0, draw, "Below 0 a motion grows.")

    def _amplitudes(self, unit: str) -> Picture:
        """Amplitudes of the coordinates in m, or of those in rad."""
        text, factor = self.shown.of(unit)
        response = self.responses[self.orders[0]]
        names = response.system.names
        columns = [j for j, name in enumerate(names) if response.system.units[name] == unit]
        values = factor * response.amplitudes
        largest = float(values[:, columns][np.isfinite(values[:, columns])].max(initial=0.0)) or 1.0
        columns = [j for j in columns if values[:, j].max() > SMALLEST * largest]
        what = "Displacements" if unit == "m" else "Angles"

        def draw(figure) -> None:
            axes = figure.add_subplot()
            for number, j in enumerate(columns):
                own = np.where(values[:, j] > SMALLEST * largest, values[:, j], np.nan)
                dashes = "-" if number < len(PALETTE) else "--"
                axes.plot(response.speeds * PER_MINUTE, own, color=PALETTE[number % len(PALETTE)], label=names[j], linestyle=dashes)
                peaks = [(one.speed * PER_MINUTE, factor * one.amplitude) for one in response.peaks if one.coordinate == names[j]]
                marks = np.reshape([one for one in peaks if np.isfinite(one[1])], (-1, 2)).T
                axes.plot(*marks, "o", markersize=3.5, markerfacecolor="white", color=PALETTE[number % len(PALETTE)])
            axes.set_yscale("log")
            axes.yaxis.set_major_formatter(lambda value, place: power_of_ten(value))
            axes.set(xlabel="speed in rev/min", ylabel=f"amplitude in {text}", xlim=self.turns[[0, -1]])
            figure.legend(loc="outside lower left", ncols=5)

        note = f"The steady state at each constant speed, order {self.orders[0]:g}; circles are peaks."
        return Picture(f"{what} under unbalance", f"Amplitudes of {what.lower()} over the speed", 3.4, draw, note)

    def _waterfall(self) -> Picture:
        """Spectra of steady states at increasing speeds, in a waterfall diagram."""
        response = next(iter(self.responses.values()))
        units = [response.system.units[name] for name in response.system.names]
        largest = [np.nan_to_num(one.amplitudes, posinf=0.0) for one in self.responses.values()]
        place = int(np.argmax(np.where(np.array(units) == units[0], np.max(largest, axis=(0, 1)), -1.0)))
        name, (unit, factor) = response.system.names[place], self.shown.of(units[place])
        even = np.linspace(response.speeds[0], response.speeds[-1], min(LINES, len(self.turns)))
        steps = np.unique(np.searchsorted(response.speeds, even).clip(max=len(response.speeds) - 1))
        turns = response.speeds[steps] * PER_MINUTE
        heights = np.array([one.amplitudes[steps, place] for one in self.responses.values()])
        top = float(heights[np.isfinite(heights)].max(initial=0.0)) or 1.0
        heights = np.minimum(heights, top)
        unit_height = HIGHEST * (turns[-1] - turns[0]) / max(len(turns) - 1, 1) / top
        right = 1.06 * max(self.orders) * turns[-1] / 60

        def draw(figure) -> None:
            axes = figure.add_subplot()
            for line in range(len(turns) - 1, -1, -1):
                x, y = _spectrum(
                    [order * turns[line] / 60 for order in self.responses], heights[:, line], HALF_WIDTH * right, right
                )
                axes.fill_between(x, turns[line], turns[line] + unit_height * y, color="white", linewidth=0, zorder=2 - line / 1e3)
                axes.plot(x, turns[line] + unit_height * y, color=PALETTE[0], linewidth=0.9, zorder=2 - line / 1e3)
            for order in self.responses:
                axes.plot(order * turns / 60, turns, color=LINE, linewidth=0.8, zorder=1)
            axes.set(xlabel="frequency in Hz", ylabel="speed in rev/min", xlim=(0.0, right))
            axes.grid(False)

        note = f"Each line is the spectrum of the steady state at one constant speed, the highest peak {factor * top:.3g} {unit}: a run-up so slow"
        note += " that every speed has its steady state. The motion while the speed rises at a finite rate is another one."
        if set(self.orders) != {1.0}:
            note += " Orders other than 1 have a force of the size of the unbalance's, at their multiple of the speed."
        return Picture(
            f"Waterfall of a run-up: {name}", f"Spectra of {name} at rising speeds, one behind the other", 4.2, draw, note
        )


def _spectrum(lines: Sequence[float], heights: Sequence[float], half: float, right: float) -> tuple[np.ndarray, np.ndarray]:
    """Triangles of these heights at the lines, above 0."""
    x = np.unique([0.0, right, *(np.clip(line + shift, 0.0, right) for line in lines for shift in (-half, 0.0, half))])
    y = sum(height * np.maximum(1 - np.abs(x - line) / half, 0.0) for line, height in zip(lines, heights))
    return x, np.asarray(y)
