"""The samples of a study and their statistics.

Samples are grids of given values, and points of distributions, random or evenly spread, perhaps correlated. Statistics are moments, quantiles
and probabilities with their confidence intervals, Sobol indices and rank correlations, by SciPy. Intervals are those of independent
samples; of Latin hypercube and Sobol points they are wider than needed in most cases.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...ground.checks import counted, nearest
from ...ground.errors import InputError
from ...scene.schema.analysis_tables import VaryTable
from ...scene.variations import Distribution, Values, Variation


@dataclass(frozen=True)
class ParameterSamples:
    """S samples of the varied parameters: each combination of given values with each point of the distributions."""

    variations: Mapping[str, Variation]  # by the name of the parameter, in the order of the columns
    table: VaryTable  # method, number, seed and correlation

    def __post_init__(self):
        if not self.variations:
            raise InputError('no parameter is varied; name one, e.g. --vary "k=1..3 N/mm:50", or write the table [vary]')
        _check_method(self)

    def __len__(self) -> int:
        return self._grid_size * self._points

    @property
    def grid(self) -> dict[str, Values]:
        """The parameters with given values."""
        return {name: one for name, one in self.variations.items() if isinstance(one, Values)}

    @property
    def random(self) -> dict[str, Distribution]:
        """The parameters with distributions."""
        return {name: one for name, one in self.variations.items() if isinstance(one, Distribution)}

    @property
    def is_random(self) -> bool:
        """Whether statistics of all samples estimate those of the distributions."""
        return not self.grid and self.table.method != "one at a time"

    @property
    def independent(self) -> int:
        """Number of samples drawn from the distributions, the first ones; for Saltelli's design two of its blocks."""
        return 2 * self.table.samples if self.table.method == "saltelli" else self._points

    @property
    def _grid_size(self) -> int:
        if self.table.method == "one at a time":
            return 1
        return int(np.prod([len(values.values) for values in self.grid.values()], dtype=object))

    @property
    def _points(self) -> int:
        if self.table.method == "one at a time":
            return 1 + 2 * len(self.variations)
        if not self.random:
            return 1
        return self.table.samples * (2 + len(self.random) if self.table.method == "saltelli" else 1)

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of the grid, followed by the number of points of the distributions."""
        return (*(len(values.values) for values in self.grid.values()), self._points)

    def column(self, name: str, at: slice = slice(None)) -> np.ndarray:
        """The values of a parameter in some samples."""
        return self._block(np.arange(*at.indices(len(self))))[name]

    def rows(self, at: slice) -> list[dict[str, Any]]:
        """The values of all parameters in some samples, each by name."""
        columns = {name: column.tolist() for name, column in self._block(np.arange(*at.indices(len(self)))).items()}
        return [dict(zip(columns, row)) for row in zip(*columns.values())]

    @property
    def nominal(self) -> dict[str, Any]:
        """A value in the middle of each parameter."""
        return {name: one.nominal for name, one in self.variations.items()}

    def _block(self, places: np.ndarray) -> dict[str, np.ndarray]:
        if self.table.method == "one at a time":
            return {name: self._one_at_a_time(name)[places] for name in self.variations}
        *own, point = np.unravel_index(places, self.shape)
        result = {name: np.array(values.values)[at] for (name, values), at in zip(self.grid.items(), own)}
        result |= {name: self._points_of[name][point] for name in self.random}
        return {name: result[name] for name in self.variations}

    def _one_at_a_time(self, name: str) -> np.ndarray:
        """The middle, then low and high values of each parameter in turn."""
        values = np.full(self._points, self.variations[name].nominal)
        place = list(self.variations).index(name)
        values[1 + 2 * place : 3 + 2 * place] = self.variations[name].ends
        return values

    @cached_property
    def _points_of(self) -> dict[str, np.ndarray]:
        """The points of the distributions, shape (points,) each."""
        cube = self._cube()
        return {name: one.inverse(column) for (name, one), column in zip(self.random.items(), cube.T)}

    def _cube(self) -> np.ndarray:
        """Points of the unit cube, shape (points, d)."""
        d, n, generator = len(self.random), self.table.samples, np.random.default_rng(self.table.seed)
        if self.table.method == "saltelli":  # Saltelli et al., Computer Physics Communications 181, 2010, table 2
            both = _sobol(2 * d, n, generator)
            A, B = both[:, :d], both[:, d:]
            mixed = [np.where(np.arange(d) == i, B, A) for i in range(d)]
            return np.vstack([A, B, *mixed])
        if self.table.method == "sobol":
            points = _sobol(d, n, generator)
        elif self.table.method == "latin hypercube":
            from scipy.stats import qmc

            points = qmc.LatinHypercube(d, seed=generator).random(n)
        else:
            points = generator.random((n, d))
        return self._correlated(points)

    def _correlated(self, points: np.ndarray) -> np.ndarray:
        """Points whose normal scores have the correlation (a Gaussian copula)."""
        if not self.table.correlation:
            return points
        from scipy.special import ndtr, ndtri

        names, R = list(self.random), np.eye(len(self.random))
        for one, other, rho in self.table.correlation:
            i, j = names.index(one), names.index(other)
            R[i, j] = R[j, i] = rho
        try:
            L = np.linalg.cholesky(R)
        except np.linalg.LinAlgError:
            raise InputError(
                "correlation: no random numbers have these correlations; their matrix is not positive definite"
            ) from None
        return ndtr(np.einsum("ij,sj->si", L, ndtri(points)))


def _sobol(d: int, n: int, generator: np.random.Generator) -> np.ndarray:
    from scipy.stats import qmc

    return qmc.Sobol(d, seed=generator).random(n)


def _check_method(samples: ParameterSamples) -> None:
    table, method, random = samples.table, samples.table.method, samples.random
    for name in dict.fromkeys(name for entry in table.correlation for name in entry[:2]):
        if name not in random:
            raise InputError(
                f'correlation: "{name}" is no varied parameter with a distribution{nearest(name, random)}; '
                f"there {'are ' + ', '.join(random) if random else 'is none'}"
            )
    if table.correlation and method in ("saltelli", "one at a time"):
        raise InputError(f'correlation: method = "{method}" is about independent parameters; leave one of them out')
    if "method" in table.model_fields_set and method != "one at a time" and not random:
        raise InputError(f'method: "{method}" samples distributions, and only given values are varied; leave it out')
    if method in ("sobol", "saltelli") and random and table.samples & (table.samples - 1):
        power = 1 << (table.samples - 1).bit_length()
        raise InputError(
            f"samples: found {table.samples}; Sobol's points are balanced in powers of two: give {power} or {power // 2}"
        )
    if method == "saltelli" and samples.grid:
        raise InputError(f"Sobol indices need distributions of all parameters, and {next(iter(samples.grid))} has given values")
    if method == "one at a time" and (text := next((name for name, one in samples.grid.items() if one.is_text), None)):
        raise InputError(f'method: "one at a time" needs low and high values, and {text} has texts')
    if len(samples) > table.MOST_SAMPLES:
        raise InputError(f"found {counted(len(samples), 'sample')}; expected at most {table.MOST_SAMPLES:,}")


# --- statistics

#: Probabilities of the quantiles.
QUANTILES = (0.05, 0.5, 0.95)

#: Confidence level of all intervals.
CONFIDENCE = 0.95

#: Resampled estimates of Sobol indices, and the seed of their choice.
RESAMPLES, SEED = 200, 0


@dataclass(frozen=True)
class Estimate:
    """A number with a confidence interval."""

    value: float  # the estimate
    low: float  # low, high: of the interval of 95 %; NaN where there are too few samples for one
    high: float


@dataclass(frozen=True)
class Summary:
    """Statistics of the samples of a quantity."""

    count: int  # number of finite values
    infinite: int  # number of infinite values
    mean: float  # mean, deviation: mean and standard deviation of the finite values
    deviation: float
    least: float  # least, largest: extremes of the finite values
    largest: float
    quantiles: dict[float, Estimate]  # quantiles of all values, by probability


def summary(values: np.ndarray) -> Summary:
    """Moments and quantiles of a quantity.

    >>> of = summary(np.arange(1.0, 102.0))
    >>> of.mean, of.quantiles[0.5].value
    (51.0, 51.0)
    """
    values = values[~np.isnan(values)]
    finite = values[np.isfinite(values)]
    if not len(finite):
        nan = float("nan")
        return Summary(0, len(values), nan, nan, nan, nan, {})
    deviation = float(finite.std(ddof=1)) if len(finite) > 1 else float("nan")
    quantiles = {probability: quantile(values, probability) for probability in QUANTILES}
    ends = float(finite.min()), float(finite.max())
    return Summary(len(finite), len(values) - len(finite), float(finite.mean()), deviation, *ends, quantiles)


def quantile(values: np.ndarray, probability: float) -> Estimate:
    """A quantile with the interval of order statistics (Conover, Practical Nonparametric Statistics, section 3.2)."""
    from scipy.stats import quantile_test

    ordered = np.sort(values)
    value = float(np.quantile(ordered, probability, method="inverted_cdf" if np.isinf(ordered).any() else "linear"))
    with np.errstate(all="ignore"):
        interval = quantile_test(ordered, p=probability).confidence_interval(CONFIDENCE)
    return Estimate(value, float(interval.low), float(interval.high))


def exceedance(values: np.ndarray, limit: float) -> Estimate:
    """The probability that a quantity exceeds a limit, with the exact binomial interval (Clopper and Pearson, 1934).

    >>> exceedance(np.arange(100.0), 94.5).value
    0.05
    """
    from scipy.stats import binomtest

    values = values[~np.isnan(values)]
    if not len(values):
        return Estimate(float("nan"), float("nan"), float("nan"))
    above = int((values > limit).sum())
    interval = binomtest(above, len(values)).proportion_ci(CONFIDENCE)
    return Estimate(above / len(values), float(interval.low), float(interval.high))


@dataclass(frozen=True)
class SobolIndices:
    """Shares of the variance that parameters cause."""

    first: tuple[Estimate, ...]  # first-order index of each parameter
    total: tuple[Estimate, ...]  # total-effect index of each parameter


def sobol_indices(values: np.ndarray, count: int) -> SobolIndices:
    """Sobol indices of a quantity from Saltelli's design, by SciPy's estimators, with intervals by resampling."""
    from scipy import stats

    if not np.isfinite(values).all():
        missing = int((~np.isfinite(values)).sum())
        raise InputError(f"Sobol indices need a finite value of every sample; {missing} of {len(values)} have none")
    blocks = values.reshape(-1, 1, count)
    if not np.ptp(values):
        zeros = tuple(Estimate(0.0, 0.0, 0.0) for _ in blocks[2:])
        return SobolIndices(zeros, zeros)
    parts = {"f_A": blocks[0], "f_B": blocks[1], "f_AB": blocks[2:]}
    indices = stats.sobol_indices(func=parts, n=count)
    spread = indices.bootstrap(CONFIDENCE, RESAMPLES) if count > 1 else None
    result = []
    for key in ("first_order", "total_order"):
        own = getattr(indices, key).ravel()
        interval = getattr(spread, key).confidence_interval if spread else None
        low, high = (np.ravel(end) for end in (interval.low, interval.high)) if interval else (np.full(len(own), np.nan),) * 2
        result.append(tuple(Estimate(*map(float, each)) for each in zip(own, low, high)))
    return SobolIndices(*result)


def rank_correlations(columns: list[np.ndarray], values: np.ndarray) -> list[float]:
    """Spearman's correlation of a quantity with each parameter."""
    from scipy.stats import rankdata

    kept = ~np.isnan(values)
    if kept.sum() < 3 or not np.ptp(rankdata(values[kept])):
        return [float("nan")] * len(columns)
    ranks = rankdata(values[kept])
    own = [rankdata(column[kept]) for column in columns]
    return [float(np.corrcoef(rank, ranks)[0, 1]) if np.ptp(rank) else float("nan") for rank in own]
