"""Partial fractions in balls: the sum over the roots z of D of c_j t^(j-1)/(j-1)! e^{z t}, each root isolated for certain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import flint

from ..rational.roots import enclosed_roots


@dataclass(frozen=True)
class Pole:
    """A root z of D of multiplicity m.

    Attributes:
        value: a ball that contains z and no other root.
        weight: 1 for a real root, 2 for one that stands for a complex pair.
        columns: c_1 ... c_m, shape (r,) each.
    """

    value: flint.acb
    weight: int
    columns: list[list[flint.acb]]


@dataclass(frozen=True)
class PartialFractions:
    """The strictly proper part of N / D without its pole at s = 0.

    Attributes:
        poles: one for each real root of D and each complex pair.
    """

    poles: list[Pole]

    @classmethod
    def of(cls, factors, denominator: flint.fmpz_poly, numerators: Sequence[flint.fmpq_poly]) -> PartialFractions:
        """At the working precision.

        Args:
            factors: irreducible polynomials without the root 0, and to what power each divides D.
            denominator: D.
            numerators: N.
        """
        found = []
        for factor, power in factors:
            taylor = [_balls(p) for p in _taylor(denominator, 2 * power)[power:]]
            above = [[_balls(p) for p in _taylor(numerator, power)] for numerator in numerators]
            vanishing = [_order(numerator, factor, power) for numerator in numerators]
            for root, weight in _roots(tuple(map(int, factor.coeffs())), flint.ctx.prec):
                below = [p(root) for p in taylor]
                rows = [_divided(_known([p(root) for p in own], zeros), below) for own, zeros in zip(above, vanishing)]
                found.append(Pole(root, weight, [[row[power - 1 - j] for row in rows] for j in range(power)]))
        return cls(found)

    def derivative(self, order: int) -> PartialFractions:
        """Of the function of time."""
        poles = self.poles
        for _ in range(order):
            poles = [Pole(pole.value, pole.weight, _differentiated(pole)) for pole in poles]
        return PartialFractions(poles)

    def sum_of(self, calls: Sequence[tuple[flint.fmpq, flint.arb]], exponentials: Exponentials) -> list[flint.arb]:
        """The sum over calls (t, amount) of amount times the function at t, shape (r,)."""
        total = [flint.arb(0)] * len(self.poles[0].columns[0]) if self.poles else []
        for pole in self.poles:
            weighted = [amount * exponentials.at(pole.value, time) for time, amount in calls]
            for j, column in enumerate(pole.columns):
                if j:
                    weighted = [value * flint.arb(time / j) for value, (time, _) in zip(weighted, calls)]
                whole = sum(weighted, flint.acb(0)) * pole.weight
                total = [entry + (c * whole).real for entry, c in zip(total, column)]
        return total


class Exponentials:
    """e^{z t} at one working precision, each computed once."""

    def __init__(self):
        self._known: dict[tuple[int, flint.fmpq], tuple[flint.acb, flint.acb]] = {}

    def at(self, root: flint.acb, time: flint.fmpq) -> flint.acb:
        """Of a root that ``PartialFractions`` holds: equal roots are one object there."""
        key = id(root), time
        if key not in self._known:
            self._known[key] = (root * flint.arb(time)).exp(), root  # the root is held: its id names no other
        return self._known[key][0]


def _differentiated(pole: Pole) -> list[list[flint.acb]]:
    """d/dt of sum of c_j t^(j-1)/(j-1)! e^{zt}: z c_j + c_(j+1)."""
    after = [*pole.columns[1:], [flint.acb(0)] * len(pole.columns[0])]
    return [[pole.value * a + b for a, b in zip(one, two)] for one, two in zip(pole.columns, after)]


@lru_cache(maxsize=256)
def _roots(coefficients: tuple[int, ...], precision: int) -> list[tuple[flint.acb, int]]:
    """Real roots and those above the real axis; FLINT certifies them, and real ones as real."""
    found = enclosed_roots(flint.fmpz_poly(list(coefficients)), precision)
    return [(root, 1 if root.imag == 0 else 2) for root in found if root.imag == 0 or root.imag > 0]


def _order(numerator: flint.fmpq_poly, factor: flint.fmpz_poly, most: int) -> int:
    """How often an irreducible factor divides a numerator, at most so often: there is no more of it in X then."""
    order, p = 0, flint.fmpq_poly(factor)
    while order < most and not numerator % p:
        numerator, order = numerator // p, order + 1
    return order


def _known(values: list[flint.acb], zeros: int) -> list[flint.acb]:
    """The first Taylor coefficients are zero, not balls about zero: what grows with the root does not grow in this row."""
    return [flint.acb(0)] * zeros + values[zeros:]


def _taylor(p, count: int) -> list:
    """p(z + h) = sum of h^k p_k(z)."""
    found, divisor = [], 1
    for k in range(count):
        divisor *= max(k, 1)
        found.append(flint.fmpq_poly(p) / divisor)
        p = p.derivative()
    return found


def _balls(p: flint.fmpq_poly) -> flint.acb_poly:
    return flint.acb_poly([flint.acb(flint.arb(c)) for c in p.coeffs()])


def _divided(above: Sequence[flint.acb], below: Sequence[flint.acb]) -> list[flint.acb]:
    """The first coefficients of the quotient of two power series."""
    found: list[flint.acb] = []
    for k, entry in enumerate(above):
        for i in range(1, k + 1):
            entry = entry - below[i] * found[k - i]
        found.append(entry / below[0])
    return found
