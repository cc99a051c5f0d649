"""Arrays with an estimate of the rounding errors of each entry, propagated through sums and products.

Noise adds in quadrature, as independent errors do: bounds by absolute values would grow with every step of a
staircase by more than the errors themselves, and call regular matrices singular.

Gaussian elimination with these errors serves rank decisions (``rank``) and rows in a given order. Exact zeros stay zero,
and ratios of small whole numbers are exact, where orthogonal factors would fill them with rounding errors. A sparse kernel for
large models is ``mechanics.sparse.pencil``.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..ground.tolerances import EPS, NOISE_SAFETY, PRECISE_DECOUPLING
from .precise import floats, is_precise, magnitude, midpoints, of_kind, precise, product, squared, unit


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
        """Numbers without errors."""
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
        left, right = self.data, other.data
        data = product(left, right)
        if not (left.size and right.size):
            return Noisy.exact(data)
        own, others, noise, others_noise = squared(left), squared(right), self.noise**2, other.noise**2
        total = own.dot(others_noise) + noise.dot(others + others_noise)
        if left.shape[-1] > 1:  # a sum of one term rounds at most once, and that is part of the noise of its factors
            several = np.sign(own).dot(np.sign(others)) > 1
            total += several * (unit(data) ** 2 * own.dot(others))
        return Noisy(data, np.sqrt(total))

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

    def settled(self) -> Noisy:
        """The array with entries within their noise as exact zeros, so that products with them do not add noise."""
        data = self.cleaned()
        return Noisy(data, np.where(data != 0, self.noise, 0.0))

    def rounded_to_float(self) -> Noisy:
        """The array in float64, with the noise of that rounding."""
        if not is_precise(self.data):
            return self
        return Noisy(floats(self.data), np.hypot(self.noise, EPS * self.size))

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
    """A basis from an eigenvalue algorithm: each column is known up to the rounding error of its largest entry."""
    noise = PRECISE_DECOUPLING if is_precise(matrix) else EPS
    return Noisy(matrix, noise * magnitude(matrix).max(axis=0, initial=0.0) + np.zeros(matrix.shape))


def eliminate(work: Noisy, row: int, column: int, first: int = 0, width: int | None = None, clean: bool = True) -> float:
    """Subtract multiples of a row from others, in place, so that their entries in one column vanish.

    The rounding errors of factors, rows and differences add in quadrature.
    """
    touched = first + (work.data[first:, column] != 0).nonzero()[0]
    touched = touched[touched != row]
    if not touched.size:
        return 0.0
    top, top_noise, rest, noise = work.data[row], work.noise[row], work.data[touched], work.noise[touched]
    factor, size = rest[:, column, None] / top[column], magnitude(top)
    change, times = factor * top, magnitude(factor)
    factor_noise = np.hypot(noise[:, column, None], times * top_noise[column]) / size[column]
    data, before, subtracted = midpoints(rest - change), squared(rest), squared(change)
    rounding = (np.minimum(before, subtracted) > 0) * (unit(change) ** 2 * (before + subtracted))
    noise = np.sqrt(noise**2 + (times * top_noise) ** 2 + (factor_noise * size) ** 2 + rounding)
    data[:, column], noise[:, column] = data[:, column] * 0, 0.0
    own, own_noise = data[:, :width], noise[:, :width]
    small = magnitude(own) <= NOISE_SAFETY * own_noise
    dropped = largest_ratio(Noisy(own[small], own_noise[small]))
    if clean:
        own *= ~small
    work.data[touched], work.noise[touched] = data, noise
    return dropped


def largest_ratio(entries: Noisy) -> float:
    """The largest of these entries over the bound below which it counts as zero; 0 where all are zero."""
    if not (entries.data != 0).any():
        return 0.0
    bound = NOISE_SAFETY * entries.noise
    return float((entries.size / np.where(bound > 0, bound, 1.0)).max())


def reduce_in_order(
    work: Noisy, width: int, preferred: np.ndarray | None = None, preference: float = 1.0
) -> tuple[list[int], list[int]]:
    """Reduce the rows of a matrix in place, each by those before it; of dependent rows the first are kept.

    With pivots chosen within rows no step depends on the scale of a row, and every factor is bounded as in partial pivoting.

    >>> work = Noisy.rounded(np.array([[1.0, -1.0, 0.0], [2.0, -2.0, 0.0], [0.0, 1.0, -1.0]]))
    >>> reduce_in_order(work, 3)
    ([0, 2], [0, 1])
    """
    work.data[:] = work.cleaned()
    kept, pivots = [], []
    for place, row in enumerate(work.data[:, :width]):
        size = np.abs(row)
        if preferred is not None and (own := np.where(preferred, size, 0.0)).max(initial=0.0) * preference > size.max(initial=0.0):
            size = own
        if size.any():
            kept.append(place)
            pivots.append(int(size.argmax()))
            eliminate(work, place, pivots[-1], place + 1)
    return kept, pivots
