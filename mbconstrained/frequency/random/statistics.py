"""Rates, extremes and fatigue of a stationary Gaussian process, from its spectral moments m_k = integral of f^k G(f) df.

Sources: Rice, Bell System Technical Journal 24 (1945); Davenport, Proc. Institution of Civil Engineers 28 (1964); Dirlik, thesis, University of
Warwick (1985), as quoted by Bishop and Sherratt, Finite Element Based Fatigue Calculations (2000).
"""

from __future__ import annotations

import numpy as np
from scipy.special import gamma

from ...ground.checks import nearest, real_number
from ...ground.errors import InputError

METHODS = ("dirlik", "narrow-band")


def octave_bands(low: float, high: float) -> np.ndarray:
    """Edges of octaves around 1000 Hz times a power of two, as in IEC 61260-1 with base two.

    Args:
        low, high: in Hz; the bands cover what is between them.

    Returns:
        Ascending, in Hz, for ``RandomResponse.rms_in_bands``.

    Raises:
        InputError: frequencies that are not positive or do not ascend.

    >>> octave_bands(20.0, 80.0).round(3)
    array([11.049, 22.097, 44.194, 88.388])
    """
    low, high = (real_number(one, name, positive=True) for one, name in ((low, "low"), (high, "high")))
    if not low < high:
        raise InputError(f"high: found {high:g} Hz; expected more than low, {low:g} Hz")
    first, last = (np.log2(one / 1000.0) + 0.5 for one in (low, high))
    return 1000.0 * 2.0 ** (np.arange(np.floor(first), np.ceil(last) + 1) - 0.5)


def crossing_rate(moments: dict[int, np.ndarray], level=0.0) -> np.ndarray:
    """Upward crossings of a level per second, sqrt(m_2 / m_0) e^{-level^2 / 2 m_0} (Rice).

    >>> crossing_rate({0: np.array([1.0]), 2: np.array([4.0])})
    array([2.])
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = _root_of_ratio(moments[2], moments[0]) * np.exp(-np.square(level) / (2 * moments[0]))
    return np.where(moments[0] > 0, rate, 0.0)


def peak_rate(moments: dict[int, np.ndarray]) -> np.ndarray:
    """Maxima per second, sqrt(m_4 / m_2) (Rice).

    >>> peak_rate({2: np.array([4.0]), 4: np.array([36.0])})
    array([3.])
    """
    return _root_of_ratio(moments[4], moments[2])


def irregularity(moments: dict[int, np.ndarray]) -> np.ndarray:
    """Upward zero crossings by maxima, m_2 / sqrt(m_0 m_4): 1 for a narrow band.

    >>> irregularity({0: np.array([1.0]), 2: np.array([4.0]), 4: np.array([16.0])})
    array([1.])
    """
    return _root_of_ratio(moments[2], moments[0]) / np.maximum(_root_of_ratio(moments[4], moments[2]), np.finfo(float).tiny)


def expected_maximum(moments: dict[int, np.ndarray], duration: float) -> np.ndarray:
    """The mean of the largest |y| over a duration, sigma (g + 0.5772 / g), g = sqrt(2 ln(2 n T)), n the rate of upward zero crossings (Davenport)."""
    T = real_number(duration, "duration", positive=True)
    cycles = 2 * crossing_rate(moments) * T
    if (cycles[np.isfinite(cycles) & (moments[0] > 0)] < np.e).any():
        raise InputError(f"duration: found {T:g} s, about {cycles.min() / 2:.2g} periods; the formula holds for many periods")
    with np.errstate(divide="ignore", invalid="ignore"):
        g = np.sqrt(2 * np.log(np.maximum(cycles, np.e)))
    return np.where(np.isinf(moments[0]), np.inf, np.sqrt(moments[0]) * (g + np.euler_gamma / g))


def damage_rate(moments: dict[int, np.ndarray], exponent: float, strength: float = 1.0, method: str = "dirlik") -> np.ndarray:
    """Fatigue damage per second by Miner's rule, cycles of the amplitude a taking N(a) = (strength / a)^exponent of them.

    Narrow band: n (sqrt(2) sigma / strength)^k Gamma(1 + k / 2); Dirlik's formula counts the ranges of a broad band. Where m_4 is infinite its limit
    stands, which is the formula of the narrow band with the mean frequency m_1 / m_0 in the place of n, for k > 1.

    >>> narrow = {k: np.array([10.0**k]) for k in (0, 1, 2, 4)}
    >>> rate = damage_rate(narrow, 4.0, 100.0, "narrow-band")
    >>> bool(np.isclose(rate[0], 10 * (np.sqrt(2) / 100) ** 4 * 2))
    True
    """
    k, strength = real_number(exponent, "exponent", positive=True), real_number(strength, "strength", positive=True)
    if method not in METHODS:
        raise InputError(f"method: found {method!r}; expected one of {', '.join(METHODS)}{nearest(str(method), METHODS)}")
    sigma = np.sqrt(moments[0]) / strength
    each = (np.sqrt(2.0) * sigma) ** k * gamma(1 + k / 2)
    if method == "narrow-band":
        return crossing_rate(moments) * each
    ratio, rate = np.minimum(irregularity(moments), 1.0), peak_rate(moments)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = moments[1] / moments[0] * _root_of_ratio(moments[2], moments[4])
        first = np.clip(2 * (mean - ratio**2) / (1 + ratio**2), 0.0, 1.0)
        R = np.where(ratio < 1, (ratio - mean - first**2) / (1 - ratio - first + first**2), 0.0)
        second = np.where(R != 1, (1 - ratio - first + first**2) / (1 - R), 0.0)
        third = 1 - first - second
        Q = np.where(first > 0, 1.25 * (ratio - third - second * R) / first, 0.0)
        shape = first * np.abs(Q) ** k * gamma(1 + k) + np.sqrt(2.0) ** k * gamma(1 + k / 2) * (second * np.abs(R) ** k + third)
        damage, limit = rate * sigma**k * shape, moments[1] / moments[0] * each if k > 1 else np.inf
    damage = np.where(np.isinf(moments[4]), np.where(np.isinf(moments[2]), np.inf, limit), damage)
    return np.where(moments[0] > 0, damage, 0.0)


def _root_of_ratio(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    """sqrt(above / below): 0 for 0 / 0, infinite where above is infinite."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.isinf(above), np.inf, np.where(np.asarray(below) > 0, np.sqrt(np.asarray(above) / below), 0.0))
