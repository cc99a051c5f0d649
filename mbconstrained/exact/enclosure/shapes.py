"""Scalar functions of time by their Laplace transforms, which are rational: t^k e^{at} cos wt, Dirac's delta and its derivatives."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import factorial

import flint

from ..rational.arithmetic import rational

ONE = flint.fmpq_poly([1])
S = flint.fmpq_poly([0, 1])


@dataclass(frozen=True)
class Shape:
    """A function of time, zero before t = 0, with the transform numerator / denominator."""

    numerator: flint.fmpq_poly
    denominator: flint.fmpq_poly = field(default_factory=lambda: flint.fmpq_poly([1]))

    def derivative(self, order: int) -> Shape:
        """In the sense of distributions, jumps and impulses at t = 0 included."""
        return Shape(self.numerator * S**order, self.denominator) if order else self

    @property
    def key(self) -> tuple:
        """Equal for equal transforms."""
        return tuple(map(str, self.numerator.coeffs())), tuple(map(str, self.denominator.coeffs()))


def delta(order: int) -> Shape:
    """The derivative of this order of Dirac's delta."""
    return Shape(S**order)


def power(k: int) -> Shape:
    """t^k / k!."""
    return Shape(ONE, S ** (k + 1))


def turning_powers(k: int, rate: float, angular_frequency: float) -> tuple[Shape, Shape]:
    """t^k e^{at} cos wt and t^k e^{at} sin wt: real and imaginary part of k! / (s - a - i w)^(k + 1) for real s."""
    moved, w = S - rational(rate), flint.fmpq_poly([rational(angular_frequency)])
    real, imaginary = flint.fmpq_poly([factorial(k)]), flint.fmpq_poly([0])
    for _ in range(k + 1):
        real, imaginary = real * moved - imaginary * w, real * w + imaginary * moved
    below = (moved**2 + w**2) ** (k + 1)
    return Shape(real, below), Shape(imaginary, below)


def decaying_power(k: int, rate: float) -> Shape:
    """t^k e^{at}."""
    return Shape(flint.fmpq_poly([factorial(k)]), (S - rational(rate)) ** (k + 1))
