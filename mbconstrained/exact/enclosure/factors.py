"""Real factors of inputs: rational ones, and those that are known as balls of any precision, such as the cosine of a phase."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import flint

from ...signals.origins import beyond_noise
from ..rational.arithmetic import rational


@dataclass(frozen=True)
class Turned:
    """amount times the cosine or the sine of a phase other than 0, which is no rational number."""

    amount: flint.fmpq
    phase: flint.fmpq
    sine: bool

    def __mul__(self, factor: flint.fmpq) -> Turned:
        return Turned(self.amount * factor, self.phase, self.sine)

    def ball(self) -> flint.arb:
        """At the working precision."""
        phase = flint.arb(self.phase)
        return flint.arb(self.amount) * (phase.sin() if self.sine else phase.cos())


@dataclass(frozen=True)
class Carried:
    """amount times one entry of e^{J t} v: what the states of a piece have become at its end."""

    amount: flint.fmpq
    generator: tuple[tuple[flint.fmpq, ...], ...]
    start: tuple[flint.fmpq, ...]
    time: flint.fmpq
    entry: int

    def __mul__(self, factor: flint.fmpq) -> Carried:
        return Carried(self.amount * factor, self.generator, self.start, self.time, self.entry)

    def ball(self) -> flint.arb:
        """At the working precision."""
        return flint.arb(self.amount) * _carried(self.generator, self.start, self.time, flint.ctx.prec)[self.entry]


@lru_cache(maxsize=4096)
def _carried(generator, start, time, precision: int) -> list[flint.arb]:
    """e^{J t} v at the working precision."""
    moved = flint.arb_mat([[flint.arb(entry * time) for entry in row] for row in generator]).exp()
    return (moved * flint.arb_mat([[flint.arb(value)] for value in start])).entries()


Factor = flint.fmpq | Turned | Carried


def ball(factor: Factor) -> flint.arb:
    """A ball that contains it, at the working precision."""
    return flint.arb(factor) if isinstance(factor, flint.fmpq) else factor.ball()


def added(calls: Iterable[tuple[flint.fmpq, Factor]]) -> tuple[tuple[flint.fmpq, Factor], ...]:
    """Times and factors, equal kinds of factors at equal times added: what cancels exactly is gone."""
    total: dict[tuple, Factor] = {}
    for time, factor in calls:
        key = time, None if isinstance(factor, flint.fmpq) else replace(factor, amount=flint.fmpq(1))
        total[key] = factor if key not in total else _sum(total[key], factor)
    return tuple((time, factor) for (time, _), factor in total.items() if _amount(factor))


def _sum(one: Factor, two: Factor) -> Factor:
    """Of one kind."""
    return one + two if isinstance(one, flint.fmpq) else replace(one, amount=one.amount + two.amount)


def _amount(factor: Factor) -> flint.fmpq:
    return factor if isinstance(factor, flint.fmpq) else factor.amount


def turned(phase: float) -> Sequence[Factor]:
    """cos p and sin p; a phase that is a quarter turn to rounding is meant as one (``signals.origins``)."""
    found, values = [], (math.cos(phase), math.sin(phase))
    for sine, value in enumerate(values):
        other = values[1 - sine]
        if beyond_noise(value, phase) == 0:
            found.append(flint.fmpq(0))
        elif beyond_noise(other, phase) == 0:
            found.append(flint.fmpq(round(value)))
        else:
            found.append(Turned(flint.fmpq(1), rational(phase), bool(sine)))
    return found
