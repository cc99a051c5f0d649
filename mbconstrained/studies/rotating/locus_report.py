"""The report of a root locus: break points, limits of stability, and the picture with lines of equal damping."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...analyses.figures import Picture
from ...analyses.timing import machine
from ...ground.checks import counted
from ...ground.display import TextTable, number_text, with_unit
from ...ground.errors import InputError, named
from ...ground.notices import Notice
from ...ground.quantities import quantity, unit_name
from ...mechanics.root_locus import RootLocus
from ...page.animation.figure import PALETTE
from ...page.plots.images import INK, LINE, MUTED, RED
from ...scene.quantities.variations import Distribution, variation_of
from ..study_report import StudyReport

if TYPE_CHECKING:
    from ...scene.run.scene import Scene

#: Damping ratios of the lines in the picture.
DAMPING_LINES = (0.1, 0.2, 0.3, 0.5, 0.7)

_LISTED = f"{', '.join(map(str, DAMPING_LINES[:-1]))} and {DAMPING_LINES[-1]}"

#: Their labels are at least this part of the width apart.
LABEL_WIDTH = 0.04


#: Values of a range whose number is not given.
COUNT = 101


def locus_values(scene: Scene, name: str, given) -> np.ndarray:
    """The values of a parameter given by a range or a list."""
    variation = variation_of(given)
    if isinstance(variation, Distribution) and variation.kind == "uniform":
        values = np.linspace(variation.first, variation.second, COUNT)
    elif isinstance(variation, Distribution) or variation.is_text:
        raise InputError(f'{name}: found {given!r}; expected a range such as "1..50 N*s/m:101", or a list of numbers')
    else:
        values = np.sort(variation.values)
    system = scene.equations.system
    others = {} if system is None or name in scene.parameters.units else {one.name: one.unit for one in system.parameters()}
    unit = scene.parameters.units.get(name) or others.get(name)
    if variation.unit and unit:
        with named(name):
            quantity(f"1 {variation.unit}", unit_name(unit))
    return values


class LocusReport(StudyReport):
    """The eigenvalues of a scene over a parameter.

    Attributes:
        scene: of the system.
        locus: its eigenvalues.
    """

    def __init__(self, scene: Scene, locus: RootLocus):
        self.scene, self.locus, self.machine = scene, locus, machine()

    @property
    def heading(self) -> str:
        """Title of the scene and the parameter."""
        return f"{self.scene.heading}: root locus over {self.locus.name}"

    @property
    def sentences(self) -> tuple[str, ...]:
        """The range, break points and limits of stability."""
        low, high = (self._value(value) for value in self.locus.values[[0, -1]])
        points = counted(len(self.locus.break_points), "break point")
        limits = ", ".join(self._value(limit) for limit in self.locus.stability_limits)
        stability = f"; a motion begins to grow, or ceases to, at {limits}" if limits else ""
        return (f"{self.locus.name} from {low} to {high}: {points}{stability}.",)

    def _value(self, value: float) -> str:
        return with_unit(value, self.locus.unit)

    @property
    def tables(self) -> tuple[TextTable, ...]:
        """Break points; eigenvalues at both ends of the range."""
        first, last = self.locus.eigenvalues[[0, -1]]
        least = self.locus.damping_ratios.min(axis=0)
        upper = np.flatnonzero((first.imag >= 0) | (last.imag > 0))
        rows = tuple((*(_complex(values[i]) for values in (first, last)), number_text(float(least[i]))) for i in upper)
        branches = TextTable("Branches in 1/s", ("first", "last", "least damping ratio"), rows)
        return (*([self.locus.table()] if self.locus.break_points else []), branches)

    def pictures(self) -> list[Picture]:
        """The branches in the complex plane."""
        return [Picture(f"Root locus over {self.locus.name}", "Eigenvalues in the complex plane", 4.2, self._draw, self._note)]

    @property
    def _note(self) -> str:
        low, high = (self._value(value) for value in self.locus.values[[0, -1]])
        return f"Crosses: {low}; circles: {high}; diamonds: break points. Grey lines: damping ratios {_LISTED}."

    def _draw(self, figure) -> None:
        axes, values = figure.add_subplot(), self.locus.eigenvalues
        for number, column in enumerate(self._curves()):
            color = PALETTE[number % len(PALETTE)]
            axes.plot(column.real, column.imag, color=color)
            axes.plot(column[0].real, column[0].imag, "x", color=color)
            axes.plot(column[-1].real, column[-1].imag, "o", color=color, markerfacecolor="white")
        for point in self.locus.break_points:
            s = point.eigenvalue
            axes.plot([s.real] * 2, [s.imag, -s.imag], "D", color=INK, markersize=4.5, linestyle="none", zorder=4)
        left, right = axes.get_xlim()
        top = 1.05 * float(np.abs(values.imag).max()) or 1.0
        labelled = np.inf
        for ratio in reversed(DAMPING_LINES):
            steepness = np.sqrt(1 - ratio**2) / ratio
            x = max(left, -top / steepness)
            for sign in (1, -1):
                axes.plot([0.0, x], [0.0, -sign * steepness * x], color=LINE, linewidth=0.8, zorder=1)
            if x < 0 and (labelled == np.inf or x - labelled > LABEL_WIDTH * (right - left)):
                labelled = x
                axes.annotate(f"{ratio:g}", (x, -steepness * x), color=MUTED, ha="right", va="bottom")
        axes.axvline(0.0, color=RED, linewidth=0.9, zorder=1)
        axes.set(xlim=(left, right), ylim=(-top, 1.06 * top), xlabel="real part in 1/s", ylabel="imaginary part in rad/s")

    def _curves(self) -> list[np.ndarray]:
        """The branches with their break points."""
        values, curves = self.locus.eigenvalues, [list(column) for column in self.locus.eigenvalues.T]
        for point in reversed(self.locus.break_points):
            place = int(np.searchsorted(self.locus.values, point.parameter))
            before, after = values[max(place - 1, 0)], values[min(place, len(values) - 1)]
            for s in {point.eigenvalue, point.eigenvalue.conjugate()}:
                for branch in np.argsort(np.abs(before - s) + np.abs(after - s))[:2]:
                    curves[branch].insert(place, s)
        return [np.array(curve) for curve in curves]

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the scene."""
        return self.scene.notices

    @property
    def is_trusted(self) -> bool:
        """True: break points have residuals."""
        return True

    def as_json(self) -> dict:
        locus = self.locus
        return {
            "title": self.scene.heading,
            "parameter": locus.name,
            "unit": locus.unit,
            "values": locus.values.tolist(),
            "branches": [[[s.real, s.imag] for s in column] for column in locus.eigenvalues.T.tolist()],
            "break_points": [
                {"value": one.parameter, "eigenvalue": [one.eigenvalue.real, one.eigenvalue.imag], "residual": one.residual}
                for one in locus.break_points
            ],
            "stability_limits": list(locus.stability_limits),
        }


def _complex(value: complex) -> str:
    real, imaginary = number_text(float(value.real)), number_text(abs(float(value.imag)))
    return f"{real} {'-' if value.imag < 0 else '+'} {imaginary} i" if value.imag else real
