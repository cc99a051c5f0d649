"""Arrays with an estimate of the rounding noise in each entry, carried through sums and products.

Noise adds in quadrature, as independent errors do: bounds by absolute values would grow with every step of a
staircase by more than the errors themselves, and call regular matrices singular.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..tolerances import EPS, NOISE_SAFETY
from .precise import DECOUPLED, is_precise, magnitude, of_kind, precise, rounded_to_float, squared, unit


@dataclass(slots=True)
class Noisy:
    """An array whose entries have errors of about ``noise`` (same shape, >= 0); those with noise zero are exact.

    The data may be float64 or precise (``linalg.precise``), the noise is always float64.

    >>> product = Noisy.exact(np.array([[1.0, -1.0]])) @ Noisy.rounded(np.array([1.0, 1.0]))
    >>> product.data, bool(product.noise[0] > 0), product.cleaned()
    (array([0.]), True, array([0.]))
    """

    data: np.ndarray
    noise: np.ndarray

    @staticmethod
    def exact(data: np.ndarray) -> Noisy:
        """Numbers that are what they are meant to be."""
        return Noisy(data, np.zeros(data.shape))

    @staticmethod
    def rounded(data: np.ndarray) -> Noisy:
        """Numbers known up to a unit in the last place, as given data is."""
        return Noisy(data, EPS * magnitude(data))

    @property
    def size(self) -> np.ndarray:
        """|data| in float64."""
        return magnitude(self.data)

    def __matmul__(self, other: Noisy) -> Noisy:
        left, right = of_kind(self.data, other.data), of_kind(other.data, self.data)
        product = left.dot(right)  # less to do before it starts than @
        if not (left.size and right.size):
            return Noisy.exact(product)
        own, others, noise, others_noise = squared(left), squared(right), self.noise**2, other.noise**2
        total = own.dot(others_noise) + noise.dot(others + others_noise)
        if left.shape[-1] > 1:  # a sum of one term rounds at most once, and that is part of the noise of its factors
            several = np.sign(own).dot(np.sign(others)) > 1
            total += several * (unit(product) ** 2 * own.dot(others))
        return Noisy(product, np.sqrt(total))

    def __add__(self, other: Noisy) -> Noisy:
        data = of_kind(self.data, other.data) + of_kind(other.data, self.data)
        rounding = (unit(data) * magnitude(data)) * ((self.data != 0) & (other.data != 0))
        return Noisy(data, np.sqrt(self.noise**2 + other.noise**2 + rounding**2))

    def __neg__(self) -> Noisy:
        return Noisy(-self.data, self.noise)

    def __getitem__(self, key) -> Noisy:
        return Noisy(self.data[key], self.noise[key])

    def __setitem__(self, key, value: Noisy) -> None:
        self.data[key], self.noise[key] = of_kind(value.data, self.data), value.noise

    def copy(self) -> Noisy:
        """A copy that can be changed in place."""
        return Noisy(self.data.copy(), self.noise.copy())

    def cleaned(self) -> np.ndarray:
        """The array, entries within their noise set to zero."""
        small = self.size <= NOISE_SAFETY * self.noise
        if is_precise(self.data):  # times one would round them
            return np.where(small, self.data * 0, self.data)
        return self.data * ~small

    def rounded_to_float(self) -> Noisy:
        """In float64, with the noise of that rounding."""
        if not is_precise(self.data):
            return self
        return Noisy(rounded_to_float(self.data), np.hypot(self.noise, EPS * self.size))

    @property
    def T(self) -> Noisy:
        """The transpose."""
        return Noisy(self.data.T, self.noise.T)


def stacked(*parts: Noisy) -> Noisy:
    """The parts, one below the other."""
    data = [part.data for part in parts]
    if any(map(is_precise, data)):
        data = list(map(precise, data))
    return Noisy(np.concatenate(data), np.concatenate([part.noise for part in parts]))


def columnwise(matrix: np.ndarray) -> Noisy:
    """A basis that an eigenvalue algorithm made: each column is known up to a rounding of its largest entry."""
    noise = DECOUPLED if is_precise(matrix) else EPS
    return Noisy(matrix, noise * magnitude(matrix).max(axis=0, initial=0.0) + np.zeros(matrix.shape))

