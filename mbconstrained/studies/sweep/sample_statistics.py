"""Statistics of samples: moments, quantiles and probabilities with their confidence intervals, Sobol indices, rank correlations.

Intervals are those of independent samples; of Latin hypercube and Sobol points they are wider than needed in most cases. All are SciPy's.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...ground.errors import InputError

#: Probabilities of the quantiles.
QUANTILES = (0.05, 0.5, 0.95)

#: Confidence level of all intervals.
CONFIDENCE = 0.95

#: Resampled estimates of Sobol indices, and the seed of their choice.
RESAMPLES, SEED = 200, 0


@dataclass(frozen=True)
class Estimate:
    """A number with a confidence interval.

    Attributes:
        value: the estimate.
        low, high: of the interval of 95 %; NaN where there are too few samples for one.
    """

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Summary:
    """Statistics of the samples of a quantity.

    Attributes:
        count: number of finite values.
        infinite: number of infinite values.
        mean, deviation: mean and standard deviation of the finite values.
        least, largest: extremes of the finite values.
        quantiles: quantiles of all values, by probability.
    """

    count: int
    infinite: int
    mean: float
    deviation: float
    least: float
    largest: float
    quantiles: dict[float, Estimate]


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
    """Shares of the variance that parameters cause.

    Attributes:
        first: first-order index of each parameter.
        total: total-effect index of each parameter.
    """

    first: tuple[Estimate, ...]
    total: tuple[Estimate, ...]


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
