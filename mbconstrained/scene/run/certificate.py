"""Proved digits: the values of the answer compared with intervals of exact arithmetic."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ...ground.display import TextTable, with_unit
from ...ground.errors import Overflow
from ...ground.notices import Notice, NoticeKind, distinct
from ...ground.tolerances import TRUST_LIMIT
from ...mechanics.motion import Motion
from .plan import OutOfTime, time_limit
from .result import ORDERS, Result
from .stages import without_certificate

#: At most so many of the times are certified, evenly chosen, the first and the last among them.
MOST_TIMES = 101

#: A number times this does not become less when it is rounded to three digits.
ROUNDED_UP = 1.005

#: After so many seconds it is broken off: page and data wait for it.
SECONDS = 60.0


@dataclass(frozen=True)
class Certified:
    """Certified accuracy of one curve of the numeric answer."""

    # name, kind and unit of the curve
    name: str
    kind: str
    unit: str
    bound: float  # its error is at most this at the certified times
    largest: float  # its largest value there
    others: float  # the largest value there of all curves of its kind and unit

    @property
    def relative(self) -> float:
        """The bound relative to the largest value; for a curve of rounding error, relative to the other curves."""
        if self.bound == 0:
            return 0.0
        scale = self.largest if self.bound <= TRUST_LIMIT * self.largest else self.others
        return self.bound / scale if scale else math.inf

    @property
    def digits(self) -> str:
        """Number of proved digits."""
        if self.relative == 0:
            return "all"
        return f"{max(math.floor(-math.log10(self.relative) * 10) / 10, 0.0):g}" if self.relative < math.inf else "0"

    @property
    def error_at_most(self) -> str:
        """The bound with its unit, to three digits, rounded up."""
        return with_unit(float(f"{self.bound * ROUNDED_UP:.3g}"), self.unit)


@dataclass(frozen=True)
class Certificate:
    """Certified accuracy of an answer."""

    curves: tuple[Certified, ...]  # one entry for each curve of the selected coordinates
    # number of certified times, and of all times
    count: int
    of: int
    notices: tuple[Notice, ...] = ()  # obstacles to a proof, or its results

    @property
    def table(self) -> TextTable:
        """Table for the terminal and the page, without rows where nothing was proved."""
        times = f"{self.count} times" if self.count == self.of else f"{self.count} of {self.of} times"
        note = (
            f"By exact rational and ball arithmetic at {times}, with the data as exact numbers. "
            "Digits are relative to the largest value; where this is rounding error relative to others of its kind and unit, to theirs."
        )
        cells = tuple((c.name, c.kind, c.digits, c.error_at_most, with_unit(c.largest, c.unit)) for c in self.curves)
        return TextTable("Proved digits", ("coordinate", "of its", "digits", "error at most", "largest value"), cells, note)

    def to_dict(self) -> dict:
        curves = [
            {"name": c.name, "kind": c.kind, "digits": c.digits, "error_bound": c.bound, "largest": c.largest} for c in self.curves
        ]
        return {"times": self.count, "of": self.of, "curves": curves}


def certificate_of(result: Result) -> Certificate:
    """Certify the available curves of a result: displacements, velocities, accelerations and reactions."""
    chosen = np.unique(np.linspace(0, len(result.times) - 1, MOST_TIMES).round().astype(int))
    if reason := without_certificate(result.scene.equations):
        return _nothing(result, Notice(NoticeKind.OMITTED, f"nothing is certified: {reason}"))
    try:
        with time_limit(SECONDS):
            certified = [_certified(result, kind, chosen) for kind in result.kinds if kind in ORDERS or kind == "reaction"]
    except Overflow as problem:
        return _nothing(result, Notice(NoticeKind.ACCURACY, f"nothing is certified: {problem}", doubtful=True))
    except OutOfTime:
        return _nothing(result, Notice(NoticeKind.OMITTED, f"nothing is certified: exact arithmetic took more than {SECONDS:g} s"))
    curves = tuple(curve for curves, _ in certified for curve in curves)
    notices_of_proof = distinct(*(notices for _, notices in certified))
    text = "the {0.kind} of {0.name} is not proved to more than {0.digits} digits"
    wrong = (Notice(NoticeKind.ACCURACY, text.format(one), doubtful=True) for one in curves if not one.relative <= TRUST_LIMIT)
    return Certificate(curves, len(chosen), len(result.times), (*notices_of_proof, *wrong))


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
    curve_bounds = [
        Certified(name, title, unit, *map(float, (bounds[row], largest[row], scale[unit])))
        for row, (name, title, unit) in enumerate(zip(curves.names, curves.titles, curves.units))
        if kind == "reaction" or wanted is True or name in wanted
    ]
    return curve_bounds, box.notices
