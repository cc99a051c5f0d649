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
from .time_limit import OutOfTime, time_limit

if TYPE_CHECKING:
    from .equations import Equations
    from .result import Result

#: At most so many of the times are certified, evenly chosen, the first and the last among them.
MOST_TIMES = 101

#: A number times this does not become less when it is rounded to three digits.
ROUNDED_UP = 1.005

#: Exact arithmetic with more states (coordinates and multipliers times the degree) takes minutes.
MOST_STATES = 240

#: After so many seconds it is broken off: page and data wait for it.
SECONDS = 60.0


@dataclass(frozen=True)
class Certified:
    """One curve of the numeric answer.

    Attributes:
        name, kind, unit: of the curve.
        bound: its error is at most this at the certified times.
        largest: its largest value there.
        others: the largest value there of all curves of its kind and unit.
    """

    name: str
    kind: str
    unit: str
    bound: float
    largest: float
    others: float

    @property
    def relative(self) -> float:
        """The bound relative to the largest value; of what is nothing but rounding beside other curves, relative to these."""
        if self.bound == 0:
            return 0.0
        scale = self.largest if self.bound <= TRUST_LIMIT * self.largest else self.others
        return self.bound / scale if scale else math.inf

    @property
    def digits(self) -> str:
        """How many digits are proved."""
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
            "Digits are relative to the largest value; where that is but rounding beside others of its kind and unit, to theirs."
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
    if reason := too_large(result.scene.equations):
        return _nothing(result, Notice("left out", f"nothing is certified: {reason}"))
    try:
        with time_limit(SECONDS):
            found = [_certified(result, kind, chosen) for kind in result.kinds if kind in ORDERS or kind == "reaction"]
    except Overflow as problem:
        return _nothing(result, Notice("accuracy", f"nothing is certified: {problem}", doubtful=True))
    except OutOfTime:
        return _nothing(result, Notice("left out", f"nothing is certified: exact arithmetic took more than {SECONDS:g} s"))
    curves = tuple(curve for curves, _ in found for curve in curves)
    told = dict.fromkeys(notice for _, notices in found for notice in notices)
    return Certificate(curves, len(chosen), len(result.times), (*told, *_wrong(curves)))


def too_large(equations: Equations) -> str:
    """Why equations are not certified; an empty text where they are."""
    rows, A = len(equations.system.rows) if equations.system else 0, equations.polynomial_matrix
    states = (A.size + rows) * max(A.degree, 1)
    return f"exact arithmetic with {states} states takes too long, {MOST_STATES} is the most" if states > MOST_STATES else ""


def _nothing(result: Result, notice: Notice) -> Certificate:
    return Certificate((), 0, len(result.times), (notice,))


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
