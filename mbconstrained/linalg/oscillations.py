"""e^{a t} cos w t and e^{a t} sin w t for many pairs a +- i w at many times, only those that are asked for.

For many even times they are made from few: of t = T + tau, T on a coarse grid and tau on a fine one, by the sine and cosine of
a sum, so that the square root of the number of times is all that is evaluated.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..tolerances import EPS

#: Exponents up to this size are far from the ends of the range of float64.
MODERATE = 690.0

#: So many values at even times are made as products of fewer.
MANY = 20_000


@dataclass(frozen=True, eq=False)
class Oscillations:
    """The functions e^{a t} cos w t of the pairs ``cosines`` and e^{a t} sin w t of the pairs ``sines``.

    Attributes:
        growth, frequency: a and w, shape (m,).
        cosines, sines: indices of pairs.
    """

    growth: np.ndarray
    frequency: np.ndarray
    cosines: np.ndarray
    sines: np.ndarray

    def __call__(self, times: np.ndarray) -> np.ndarray:
        """The cosines, below them the sines, shape (number of both, T); what would be a denormal number is zero.

        >>> pair = Oscillations(np.zeros(1), np.array([np.pi]), np.array([0]), np.array([0]))
        >>> pair(np.array([0.0, 1.0])).round(12).tolist()
        [[1.0, -1.0], [0.0, 0.0]]
        """
        found = np.empty((len(self.cosines) + len(self.sines), len(times)))
        step = even_step(times) if len(self.growth) * len(times) >= MANY else None
        if step is None:
            self._each(times, found)
        else:
            self._of_sums(times, step, found)
        if (self.growth * times.max(initial=0.0)).min(initial=0.0) < -MODERATE:
            rates = np.concatenate([self.growth[self.cosines], self.growth[self.sines]])
            found[np.multiply.outer(rates, times) < -MODERATE] = 0.0
        return found

    def _each(self, times, found) -> None:
        begin = 0
        for chosen, function in ((self.cosines, np.cos), (self.sines, np.sin)):
            part = found[begin : begin + len(chosen)]
            function(np.multiply.outer(self.frequency[chosen], times), out=part)
            if self.growth[chosen].any():
                part *= np.exp(np.multiply.outer(self.growth[chosen], times))
            begin += len(chosen)

    def _of_sums(self, times, step, found) -> None:
        size = len(times)
        fine = int(size**0.5)
        (c, s), (C, S) = (self._tables(grid) for grid in (step * np.arange(fine), times[::fine]))
        begin = 0
        for chosen, one, two in ((self.cosines, (C, c), (-S, s)), (self.sines, (S, c), (C, s))):
            part = one[0][chosen][:, :, None] * one[1][chosen][:, None, :]
            part += two[0][chosen][:, :, None] * two[1][chosen][:, None, :]
            found[begin : begin + len(chosen)] = part.reshape(len(chosen), C.shape[1] * fine)[:, :size]
            begin += len(chosen)

    def _tables(self, times) -> tuple[np.ndarray, np.ndarray]:
        turn, size = np.multiply.outer(self.frequency, times), np.exp(np.multiply.outer(self.growth, times))
        return size * np.cos(turn), size * np.sin(turn)


def even_step(times: np.ndarray) -> float | None:
    """h where times are t0, t0 + h, t0 + 2 h, ... to rounding, else None.

    >>> even_step(np.array([1.0, 1.5, 2.0])), even_step(np.array([0.0, 1.0, 3.0]))
    (0.5, None)
    """
    if len(times) < 2:
        return None
    step = float(times[-1] - times[0]) / (len(times) - 1)
    apart = np.abs(times - (times[0] + step * np.arange(len(times)))).max()
    return step if step > 0 and apart <= 4 * EPS * times[-1] else None
