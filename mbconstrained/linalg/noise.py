"""Arrays with an estimate of the rounding noise in each entry, carried through sums and products.

Noise adds in quadrature, as independent errors do: bounds by absolute values would grow with every step of a
staircase by more than the errors themselves, and call regular matrices singular.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..tolerances import EPS, NOISE_SAFETY


@dataclass
class Noisy:
    """An array whose entries have errors of about ``noise`` (same shape, >= 0); those with noise zero are exact.

    >>> product = Noisy.exact(np.array([[1.0, -1.0]])) @ Noisy.rounded(np.array([1.0, 1.0]))
    >>> product.data, bool(product.noise[0] > 0), product.cleaned()
    (array([0.]), True, array([0.]))
    """

    data: np.ndarray
    noise: np.ndarray

    @staticmethod
    def exact(data: np.ndarray) -> Noisy:
        """Numbers that are what they are meant to be."""
        return Noisy(data, np.zeros_like(data))

    @staticmethod
    def rounded(data: np.ndarray) -> Noisy:
        """Numbers known up to a unit in the last place, as given data is."""
        return Noisy(data, EPS * np.abs(data))

    def __matmul__(self, other: Noisy) -> Noisy:
        noise = self.data**2 @ other.noise**2 + self.noise**2 @ (other.data**2 + other.noise**2)
        return Noisy(self.data @ other.data, np.sqrt(noise + _rounding(self.data, other.data) ** 2))

    def __add__(self, other: Noisy) -> Noisy:
        data = self.data + other.data
        rounds = (self.data != 0) & (other.data != 0)
        return Noisy(data, np.sqrt(self.noise**2 + other.noise**2 + (EPS * rounds * data) ** 2))

    def __neg__(self) -> Noisy:
        return Noisy(-self.data, self.noise)

    def __getitem__(self, key) -> Noisy:
        return Noisy(self.data[key], self.noise[key])

    def __setitem__(self, key, value: Noisy) -> None:
        self.data[key], self.noise[key] = value.data, value.noise

    def copy(self) -> Noisy:
        """A copy that can be changed in place."""
        return Noisy(self.data.copy(), self.noise.copy())

    def cleaned(self) -> np.ndarray:
        """The array, entries within their noise set to zero."""
        return np.where(np.abs(self.data) <= NOISE_SAFETY * self.noise, 0.0, self.data)

    @property
    def T(self) -> Noisy:
        """The transpose."""
        return Noisy(self.data.T, self.noise.T)


def stacked(*parts: Noisy) -> Noisy:
    """The parts, one below the other."""
    return Noisy(np.concatenate([part.data for part in parts]), np.concatenate([part.noise for part in parts]))


def columnwise(matrix: np.ndarray) -> Noisy:
    """A result of orthogonal transformations: each column is known up to a rounding of its largest entry."""
    return Noisy(matrix, EPS * np.abs(matrix).max(axis=0, initial=0.0) + np.zeros_like(matrix))


def _rounding(left, right) -> np.ndarray:
    """Rounding of left @ right; a sum with one term that copies or scales by a power of two rounds at most once."""
    terms = (left != 0).astype(float) @ (right != 0).astype(float)
    return EPS * np.where(terms > 1, np.sqrt(left**2 @ right**2), 0.0)
