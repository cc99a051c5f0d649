"""The root locus: eigenvalues over a parameter, with the break points where two of them coalesce."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from ..ground.checks import counted
from ..ground.display import TextTable, number_text, with_unit
from ..ground.errors import InputError, named
from ..ground.quantities import quantity, unit_name
from ..mechanics.root_locus import RootLocus
from ..page.content import Curve, Guide, Marks, Plot, Shape
from ..scene.schema.entry_types import Table
from ..scene.variations import Distribution, variation_of
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

#: Damping ratios of the lines in the picture.
DAMPING_LINES = (0.1, 0.2, 0.3, 0.5, 0.7)

#: Their labels are at least this part of the picture away from each other.
LABEL_DISTANCE = 0.04

#: Values of a range whose number is not given.
COUNT = 101


#: Rounds in which values are added where a branch turns, by more radians than this times the part of the picture of the shorter step;
#: of more eigenvalues that takes long.
ROUNDS, VISIBLE_TURN, MOST_BRANCHES = 6, 4e-3, 64

#: Differences of an eigenvalue computed twice, relative to the largest.
SAME_BRANCH = 1e-6


class ParameterOfLocus(Table):
    """The parameter of a root locus."""

    vary: dict[str, Any] = Field(min_length=1, max_length=1, description='A parameter or an element, such as "c=1..50 N*s/m:101".')


class Locus(Analysis):
    """The eigenvalues over a parameter, each branch followed, with the break points where two of them coalesce.

    Break points are solved for, not found on the grid of values. Writes NAME.locus.html, .png and .json.
    """

    name = "locus"
    settings = ParameterOfLocus
    options: ClassVar = {"vary": "--vary"}
    formats = ("page", "images", "json")

    @classmethod
    def solve(cls, scene: Scene, settings: ParameterOfLocus | None) -> Answer:
        if settings is None:
            raise InputError("there is no parameter; give it as --vary NAME=VALUES")
        ((name, given),) = settings.vary.items()
        locus = scene.root_locus(name, _values(scene, name, given))
        low, high = (with_unit(value, locus.unit) for value in locus.values[[0, -1]])
        limits = ", ".join(with_unit(limit, locus.unit) for limit in locus.stability_limits)
        facts = [(name, f"from {low} to {high}: {counted(len(locus.break_points), 'break point')}")]
        facts += [("stability", f"a motion begins to grow, or ceases to, at {limits}")] if limits else []
        data = {
            "title": scene.heading,
            "parameter": locus.name,
            "unit": locus.unit,
            "values": locus.values,
            "branches": np.array([locus.eigenvalues.real, locus.eigenvalues.imag]).T,
            "break_points": [
                {"value": one.parameter, "eigenvalue": [one.eigenvalue.real, one.eigenvalue.imag], "residual": one.residual}
                for one in locus.break_points
            ],
            "stability_limits": locus.stability_limits,
        }
        return cls.of(
            scene,
            title=f"{scene.heading}: root locus over {locus.name}",
            facts=tuple(facts),
            tables=(*([locus.table()] if locus.break_points else []), _branches(locus)),
            data=data,
            plots=lambda: (locus_plot(_with_corners_resolved(scene, locus), low, high),),
            most_rows=None,
            keys=(),
        )


def _values(scene: Scene, name: str, given) -> np.ndarray:
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


def _with_corners_resolved(scene: Scene, locus: RootLocus) -> RootLocus:
    """The locus with further values between those where a branch turns visibly from one to the next."""
    finer = locus
    for _ in range(ROUNDS if locus.eigenvalues.shape[1] <= MOST_BRANCHES else 0):
        s = finer.eigenvalues
        steps = np.diff(s.real, axis=0) / (np.ptp(s.real) or 1.0) + 1j * np.diff(s.imag, axis=0) / (np.ptp(s.imag) or 1.0)
        sizes = np.abs(steps)
        turns = np.abs(np.angle(steps[1:] * steps[:-1].conj())) * np.minimum(sizes[1:], sizes[:-1])
        corners = np.flatnonzero((turns > VISIBLE_TURN).any(axis=1))
        gaps = np.unique([corners, corners + 1])
        if not len(gaps):
            break
        middles = (finer.values[gaps] + finer.values[gaps + 1]) / 2
        finer = scene.root_locus(locus.name, np.union1d(finer.values, middles))
    places = np.searchsorted(finer.values, locus.values)
    same = np.abs(finer.eigenvalues[places] - locus.eigenvalues).max() <= SAME_BRANCH * np.abs(locus.eigenvalues).max()
    return finer if same else locus  # followed otherwise with fewer values: the picture is that of the tables


def _branches(locus: RootLocus) -> TextTable:
    """Eigenvalues at both ends of the range, of pairs one."""
    first, last = locus.eigenvalues[[0, -1]]
    least = locus.damping_ratios.min(axis=0)
    upper = np.flatnonzero((first.imag >= 0) | (last.imag > 0))
    rows = tuple((*(_complex(values[i]) for values in (first, last)), number_text(float(least[i]))) for i in upper)
    return TextTable("Branches in 1/s", ("first", "last", "least damping ratio"), rows)


def _complex(value: complex) -> str:
    real, imaginary = number_text(float(value.real)), number_text(abs(float(value.imag)))
    return f"{real} {'-' if value.imag < 0 else '+'} {imaginary} i" if value.imag else real


def locus_plot(locus: RootLocus, low: str, high: str) -> Plot:
    """The branches in the complex plane, with lines of equal damping."""
    values = np.union1d(locus.values, [point.parameter for point in locus.break_points])
    s = np.array([np.interp(values, locus.values, column) for column in locus.eigenvalues.T])
    for point in locus.break_points:  # both branches meet there
        place = int(np.searchsorted(values, point.parameter))
        around = np.abs(
            s[:, [max(place - 1, 0), min(place + 1, len(values) - 1)]][..., None] - [point.eigenvalue, np.conj(point.eigenvalue)]
        )
        for pair, end in zip(around.sum(axis=1).T, (point.eigenvalue, point.eigenvalue.conjugate())):
            s[np.argsort(pair)[:2], place] = end
    curves = tuple(Curve(f"branch {number}", row.imag, along=row.real) for number, row in enumerate(s, 1))
    ends: tuple[tuple[int, str, Shape], ...] = ((0, low, "cross"), (-1, high, "circle"))
    marks = [
        Marks(
            f"{locus.name} = {end}",
            np.array([[row[place].real, row[place].imag]]),
            (f"{end}: {_complex(row[place])} 1/s",),
            shape,
            number,
        )
        for place, end, shape in ends
        for number, row in enumerate(s)
    ]
    if locus.break_points:
        points = [(one.parameter, end) for one in locus.break_points for end in {one.eigenvalue, one.eigenvalue.conjugate()}]
        texts = (f"break point: {with_unit(value, locus.unit)}, {_complex(end)} 1/s" for value, end in points)
        marks.append(Marks("break point", np.array([[end.real, end.imag] for _, end in points]), tuple(texts), "diamond"))
    across, note = Curve("real part", s[0].real), f"Lines of the grid: damping ratios {', '.join(map(str, DAMPING_LINES))}."
    plot = Plot(
        f"Root locus over {locus.name}",
        "rad/s",
        values,
        curves,
        across,
        "1/s",
        "imaginary part",
        locus.name,
        marks=tuple(marks),
        note=note,
        shown=len(curves),
        is_large=True,
        variable_unit=locus.unit,
    )
    return replace(plot, guides=_guides(plot))


def _guides(plot: Plot) -> tuple[Guide, ...]:
    """The imaginary axis, and lines of equal damping with names that do not meet."""
    across, up = plot.axes
    far = 2.0 * max(abs(up.low), abs(up.high))
    guides, last = [Guide("", (0.0, -far), (0.0, far), "limit")], None
    for ratio in reversed(DAMPING_LINES):
        left = far * ratio / np.sqrt(1 - ratio**2)
        line = Guide(f"{ratio:g}", (0.0, 0.0), (-left, far))
        if ends := line.ends(across, up):
            place = np.array(ends[1])
            is_clear = last is None or np.abs(place - last).max() > LABEL_DISTANCE
            last = place if is_clear else last
            guides += [line if is_clear else replace(line, name=""), Guide("", (0.0, 0.0), (-left, -far))]
    return tuple(guides)
