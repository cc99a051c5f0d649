"""e^{a t} cos w t and e^{a t} sin w t for many pairs a +- i w at many times, only the requested ones.

For many even times they are computed from few: of t = T + tau, T on a coarse grid and tau on a fine one, by the sine and cosine of
a sum, so that the square root of the number of times is all that is evaluated.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from ...ground.tolerances import EPS, MODERATE_EXPONENT

#: From this number of values on, those at even times are products of fewer, and decayed ones are left out; for few rows this many
#: less.
MANY, SEVERAL = 20_000, 1500

#: What is this part of something is far below its rounding. So many pairs, the slowest, are what others are compared with; they are
#: looked at so many rows at a time,and again in so many parts of the times.
NOTHING, SLOW, ROWS, PARTS = EPS / 256, 8, 32, 8

#: The number of values computed at once where they are multiplied right away; of many pairs so many that with the coefficients they
#: take three quarters of a matrix of all states.
AT_ONCE = 1 << 17


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
        """The cosines, below them the sines, shape (number of both, T); denormal numbers are replaced by zero.

        >>> pair = Oscillations(np.zeros(1), np.array([np.pi]), np.array([0]), np.array([0]))
        >>> pair(np.array([0.0, 1.0])).round(12).tolist()
        [[1.0, -1.0], [0.0, 0.0]]
        """
        step = even_step(times) if self.are_many(times) else None
        return self._each(times) if step is None else self._of_sums(times, *self._grids(times, step))

    def combined(self, coefficients: np.ndarray, times: np.ndarray, lasting: Lasting | None = None) -> np.ndarray:
        """coefficients @ self(times), shape (r, T), with no table of the functions at all times."""
        if not self.are_many(times):
            return coefficients @ self._each(times)
        step, room = even_step(times), max(AT_ONCE, 3 * len(self.growth) ** 2 - coefficients.size)
        coarse, fine = (None, np.empty(1)) if step is None else self._grids(times, step)
        result, size = np.empty((len(coefficients), len(times))), fine.shape[-1]
        width = max(1, room // max(1, coefficients.shape[1]))
        width = size * max(1, (width if lasting is None else min(width, len(times) // PARTS)) // size)
        for begin in range(0, len(times), width):
            place = slice(begin, begin + width)
            part, columns = self._remaining(coefficients, times[place], lasting)
            at = slice(begin // size, (begin + width) // size)
            table_of = part._each if step is None else partial(part._of_sums, coarse=coarse[..., at], fine=fine)
            np.matmul(
                columns, table_of(times[place]), out=result[:, place]
            )  # without a name a table is gone before the next is made
        return result

    def _remaining(self, coefficients, times, lasting) -> tuple[Oscillations, np.ndarray]:
        """The functions that have not decayed at these times, and their coefficients."""
        kept = None if lasting is None else lasting.at(times)
        if kept is None or kept.all():
            return self, coefficients
        cosines, sines = np.split(kept, [len(self.cosines)])
        return replace(self, cosines=self.cosines[cosines], sines=self.sines[sines]), coefficients[:, kept]

    def are_many(self, times: np.ndarray) -> bool:
        """Whether a table of all functions is large enough to consider alternatives."""
        return len(self.growth) * len(times) >= MANY

    def _grids(self, times, step) -> tuple[np.ndarray, np.ndarray]:
        """(cos; sin) of all pairs at coarse and at fine times, shape (m, 2, number of times)."""
        fine = int(len(times) ** 0.5)
        return self._both(times[::fine]), self._both(step * np.arange(fine))

    def _both(self, times) -> np.ndarray:
        """e^{a t} cos w t and e^{a t} sin w t of all pairs, shape (m, 2, T)."""
        turn, exponents = np.multiply.outer(self.frequency, times), np.multiply.outer(self.growth, times)
        result = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        result *= np.where(exponents < -MODERATE_EXPONENT, 0.0, np.exp(exponents))[:, None]
        return result

    def _each(self, times) -> np.ndarray:
        result, begin, last = np.empty((len(self.cosines) + len(self.sines), len(times))), 0, times.max(initial=0.0)
        for chosen, function in ((self.cosines, np.cos), (self.sines, np.sin)):
            if not len(chosen):
                continue
            part, growth = result[begin : begin + len(chosen)], self.growth[chosen]
            function(np.multiply.outer(self.frequency[chosen], times), out=part)
            if np.abs(growth).max() * last > EPS / 4:  # else e^{a t} is rounded to 1
                part *= np.exp(np.multiply.outer(growth, times))
            begin += len(chosen)
        return self._without_decayed(result, times)

    def _of_sums(self, times, coarse, fine) -> np.ndarray:
        """Values by small products: (cos T, -sin T) or (sin T, cos T), by (cos tau; sin tau)."""
        result, begin = np.empty((len(self.cosines) + len(self.sines), coarse.shape[2], fine.shape[2])), 0
        for chosen, part in ((self.cosines, _quarter_on(coarse)[:, ::-1]), (self.sines, coarse[:, ::-1])):
            right = fine if np.array_equal(chosen, np.arange(len(fine))) else fine[chosen]
            np.matmul(part[chosen].transpose(0, 2, 1), right, out=result[begin : begin + len(chosen)])
            begin += len(chosen)
        return self._without_decayed(result.reshape(len(result), coarse.shape[2] * fine.shape[2])[:, : len(times)], times)

    def _without_decayed(self, result, times) -> np.ndarray:
        """The values with zeros in place of denormal numbers."""
        last = times.max(initial=0.0)
        if self.growth.min(initial=0.0) * last < -MODERATE_EXPONENT:
            rates = np.concatenate([self.growth[self.cosines], self.growth[self.sines]])
            decayed = np.flatnonzero(rates * last < -MODERATE_EXPONENT)
            result[decayed] *= np.multiply.outer(rates[decayed], times) >= -MODERATE_EXPONENT
        return result


@dataclass(frozen=True, eq=False)
class Lasting:
    """Duration for which functions matter next to the slowest ones, until their decayed values add no digit.

    Attributes:
        rates: a of each function, shape (k,).
        logarithms: logarithms of its largest coefficient in any row relative to that of the slowest ones, times k / NOTHING.
        slowest: the smallest a of these.
        since: a time by which all of them have turned by a radian: from then on their rounding is that of their size.
    """

    rates: np.ndarray
    logarithms: np.ndarray
    slowest: float
    since: float

    @staticmethod
    def of(functions: Oscillations, coefficients: np.ndarray) -> Lasting | None:
        """The durations; None where nothing decays.

        >>> pairs = Oscillations(np.array([-1.0, -100.0]), np.array([1.0, 2.0]), np.arange(2), np.arange(0))
        >>> Lasting.of(pairs, np.array([[1.0, 5.0]])).at(np.array([1.0, 1.1])).tolist()
        [True, False]
        """
        if not (functions.growth < 0).any() or not coefficients.size:
            return None
        pairs = np.concatenate([functions.cosines, functions.sines])
        slow = np.argsort(-functions.growth, kind="stable")[: max(1, min(SLOW, len(functions.growth) // 4))]
        chosen, ratios = np.isin(pairs, slow), np.zeros(len(pairs))
        with np.errstate(divide="ignore", invalid="ignore"):
            for begin in range(0, len(coefficients), ROWS):
                size = np.abs(coefficients[begin : begin + ROWS])
                size /= size[:, chosen].max(axis=1, initial=0.0)[:, None]  # infinite in rows without slow ones
                ratios = np.fmax(ratios, np.fmax.reduce(size, axis=0))
            logarithms = np.log(ratios * (len(pairs) / NOTHING))
        since = 1 / functions.frequency[slow].min()
        return Lasting(functions.growth[pairs], logarithms, float(functions.growth[slow].min()), float(since))

    def at(self, times: np.ndarray) -> np.ndarray | None:
        """Which functions matter within these times, None for all: the others together are less than NOTHING of the slow ones."""
        first, last = times.min(), times.max()
        if first < self.since:
            return None
        largest = np.maximum(self.rates * first, self.rates * last)
        return self.logarithms + largest > min(self.slowest * first, self.slowest * last)


def _quarter_on(pairs: np.ndarray) -> np.ndarray:
    """(-sin; cos) of (cos; sin)."""
    return np.stack([-pairs[:, 1], pairs[:, 0]], axis=1)


def step_of_few_rows(rows: int, pairs: int, times: np.ndarray) -> float | None:
    """h where times are even and a table of all functions at all of them is more than ``of_phasors`` needs, else None."""
    return even_step(times) if rows**2 <= len(times) and 2 * pairs * len(times) >= SEVERAL else None


def of_phasors(phasors: np.ndarray, rates: np.ndarray, times: np.ndarray, step: float) -> np.ndarray:
    """The real part of the sum of conj(z) e^{s t}, that is of e^{a t} (c cos w t + d sin w t) for z = c + i d, s = a + i w.

    At even times t = T + tau: z e^{conj(s) T} is made for the coarse ones, and one real product takes them all to the fine ones.

    >>> of_phasors(np.array([[2.0 + 1.0j]]), np.array([0.5j * np.pi]), np.arange(4.0), 1.0).round(12).tolist()
    [[2.0, 1.0, -2.0, -1.0]]
    """
    fine, decays = int(len(times) ** 0.5), rates.real.min(initial=0.0) * times[-1] < -MODERATE_EXPONENT
    coarse = np.multiply(phasors[:, None], _exponentials(rates.conj(), times[::fine], decays), order="C")
    table = _exponentials(rates, step * np.arange(fine), decays)
    result = coarse.view(float).reshape(-1, 2 * len(rates)) @ table.view(float).T
    return np.ascontiguousarray(result.reshape(len(phasors), coarse.shape[1] * fine)[:, : len(times)])


def _exponentials(rates: np.ndarray, times: np.ndarray, decays: bool) -> np.ndarray:
    """e^{s t}, shape (T, m), with denormal numbers of decayed ones replaced by zero."""
    exponents = np.multiply.outer(times, rates)
    result = np.exp(exponents)
    if decays:
        result[exponents.real < -MODERATE_EXPONENT] = 0.0
    return result


def even_step(times: np.ndarray) -> float | None:
    """h where times are t0, t0 + h, t0 + 2 h, ... to rounding, else None.

    >>> even_step(np.array([1.0, 1.5, 2.0])), even_step(np.array([0.0, 1.0, 3.0]))
    (0.5, None)
    """
    if len(times) < 2:
        return None
    step = float(times[-1] - times[0]) / (len(times) - 1)
    deviation = np.abs(times - (times[0] + step * np.arange(len(times)))).max()
    return step if step > 0 and deviation <= 4 * EPS * times[-1] else None
