"""Partial fractions in balls: the sum over the roots z of D of c_j t^(j-1)/(j-1)! e^{z t}, each root isolated for certain."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import flint


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
            factors: whole polynomials with simple roots other than 0, and to what power each divides D.
            denominator: D.
            numerators: N.
        """
        found = []
        for factor, power in factors:
            taylor = [_balls(p) for p in _taylor(denominator, 2 * power)[power:]]
            above = [[_balls(p) for p in _taylor(numerator, power)] for numerator in numerators]
            for root, weight in _roots(tuple(map(int, factor.coeffs())), flint.ctx.prec):
                below = [p(root) for p in taylor]
                rows = [_divided([p(root) for p in own], below) for own in above]
                found.append(Pole(root, weight, [[row[power - 1 - j] for row in rows] for j in range(power)]))
        return cls(found)

    def derivative(self, order: int) -> PartialFractions:
        """Of the function of time."""
        poles = self.poles
        for _ in range(order):
            poles = [Pole(pole.value, pole.weight, _differentiated(pole)) for pole in poles]
        return PartialFractions(poles)

    def values(self, times: Sequence[flint.fmpq]) -> flint.acb_mat:
        """Shape (r, len(times)); the real part is meant."""
        rows = [[] for _ in self.poles[0].columns[0]] if self.poles else []
        functions = []
        for pole in self.poles:
            powers = [[_exponential(pole.value, time) * pole.weight for time in times]]
            for j in range(1, len(pole.columns)):
                powers.append([value * flint.arb(time / j) for value, time in zip(powers[-1], times)])
            functions += powers
            for column in pole.columns:
                for row, entry in zip(rows, column):
                    row.append(entry)
        return flint.acb_mat(rows) * flint.acb_mat(functions)


def _exponential(root: flint.acb, time: flint.fmpq) -> flint.acb:
    return (root * flint.arb(time)).exp()


def _differentiated(pole: Pole) -> list[list[flint.acb]]:
    """d/dt of sum of c_j t^(j-1)/(j-1)! e^{zt}: z c_j + c_(j+1)."""
    after = [*pole.columns[1:], [flint.acb(0)] * len(pole.columns[0])]
    return [[pole.value * a + b for a, b in zip(one, two)] for one, two in zip(pole.columns, after)]


@lru_cache(maxsize=256)
def _roots(coefficients: tuple[int, ...], precision: int) -> list[tuple[flint.acb, int]]:
    """Real roots and those above the real axis; FLINT certifies them, and real ones as real."""
    found = [flint.acb(root) for root, _ in flint.fmpz_poly(list(coefficients)).complex_roots()]
    return [(root, 1 if root.imag == 0 else 2) for root in found if root.imag == 0 or root.imag > 0]


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
