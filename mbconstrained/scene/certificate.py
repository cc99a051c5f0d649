"""How many digits of the numeric answer are proved: its values held against intervals of exact arithmetic."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..errors import Overflow
from ..mechanics.motion import Motion
from ..notices import Notice
from ..tolerances import TRUST_LIMIT
from .curves import ORDERS
from .happenings import sized
from .text_table import TextTable

if TYPE_CHECKING:
    from .result import Result

#: At most so many of the times are certified, evenly chosen, the first and the last among them.
MOST_TIMES = 101

#: A number times this does not become less when it is rounded to three digits.
ROUNDED_UP = 1.005

#: Exact determinants of more states (coordinates and multipliers times the degree) take minutes.
MOST_STATES = 400


@dataclass(frozen=True)
class Certified:
    """One curve of the numeric answer.

    Attributes:
        name, kind, unit: of the curve.
        bound: its error is at most this at the certified times.
        largest: its largest value there.
        scale: the largest value there of all curves of its kind and unit: what is nothing but rounding beside the others has no
            digits of its own.
    """

    name: str
    kind: str
    unit: str
    bound: float
    largest: float
    scale: float

    @property
    def relative(self) -> float:
        """The bound relative to the scale."""
        return 0.0 if self.bound == 0 else self.bound / self.scale if self.scale else math.inf

    @property
    def digits(self) -> str:
        """How many digits are proved, relative to the scale."""
        if self.relative == 0:
            return "all"
        return f"{max(math.floor(-math.log10(self.relative) * 10) / 10, 0.0):g}" if self.relative < math.inf else "0"

    @property
    def error_at_most(self) -> str:
        """The bound with its unit, to three digits, rounded up."""
        return sized(float(f"{self.bound * ROUNDED_UP:.3g}"), self.unit)


@dataclass(frozen=True)
class Certificate:
    """What is proved of an answer.

    Attributes:
        curves: one for each curve of the coordinates that were chosen.
        count, of: at how many of how many times.
        notices: what stands in the way of a proof, or what it found.
    """

    curves: tuple[Certified, ...]
    count: int
    of: int
    notices: tuple[Notice, ...] = ()

    @property
    def table(self) -> TextTable:
        """For the terminal and the page; without rows where nothing could be proved."""
        times = f"{self.count} times" if self.count == self.of else f"{self.count} of {self.of} times"
        note = (
            f"By exact rational and ball arithmetic at {times}, the data taken as the numbers that they are. "
            "Digits are relative to the largest value of all of that kind and unit."
        )
        cells = tuple((c.name, c.kind, c.digits, c.error_at_most, sized(c.largest, c.unit)) for c in self.curves)
        return TextTable("Proved digits", ("coordinate", "of its", "digits", "error at most", "largest value"), cells, note)

    def as_json(self) -> dict:
        """As plain data."""
        curves = [
            {"name": c.name, "kind": c.kind, "digits": c.digits, "error_bound": c.bound, "largest": c.largest} for c in self.curves
        ]
        return {"times": self.count, "of": self.of, "curves": curves}


def certificate_of(result: Result) -> Certificate:
    """Certify the curves of a result: displacements, velocities, accelerations and reactions, as far as it has them."""
    chosen = np.unique(np.linspace(0, len(result.times) - 1, MOST_TIMES).round().astype(int))
    if (states := _states(result)) > MOST_STATES:
        text = f"nothing is certified: exact arithmetic with {states} states takes too long, {MOST_STATES} is the most"
        return Certificate((), 0, len(result.times), (Notice("left out", text),))
    try:
        found = [_certified(result, kind, chosen) for kind in result.kinds if kind in ORDERS or kind == "reaction"]
    except Overflow as problem:
        notice = Notice("accuracy", f"nothing is certified: {problem}", doubtful=True)
        return Certificate((), 0, len(result.times), (notice,))
    curves = tuple(curve for curves, _ in found for curve in curves)
    told = dict.fromkeys(notice for _, notices in found for notice in notices)
    return Certificate(curves, len(chosen), len(result.times), (*told, *_wrong(curves)))


def _states(result: Result) -> int:
    rows = len(result.system.rows) if result.system else 0
    A = result.scene.equations.polynomial_matrix
    return (A.size + rows) * max(A.degree, 1)


def _certified(result: Result, kind: str, chosen: np.ndarray) -> tuple[list[Certified], tuple[Notice, ...]]:
    curves, times = result.curves(kind), result.times[chosen]
    if isinstance(result.motion, Motion):
        box = result.motion.enclose(times, of=kind)
    else:
        box = result.motion.enclose(times, order=ORDERS[kind])
    values = curves.values[:, chosen]
    bounds, wanted = box.error_bounds(values).max(axis=1), result.scene.table.output.certify
    largest = np.abs(values).max(axis=1)
    scale = {unit: max(value for value, own in zip(largest, curves.units) if own == unit) for unit in curves.units}
    found = [
        Certified(name, title, unit, *map(float, (bounds[row], largest[row], scale[unit])))
        for row, (name, title, unit) in enumerate(zip(curves.names, curves.titles, curves.units))
        if kind == "reaction" or wanted is True or name in wanted
    ]
    return found, box.notices


def _wrong(curves) -> tuple[Notice, ...]:
    """Curves of which the proof shows that they are not to be trusted."""
    return tuple(
        Notice("accuracy", f"the {c.kind} of {c.name} is not proved to more than {c.digits} digits", doubtful=True)
        for c in curves
        if not c.relative <= TRUST_LIMIT
    )
