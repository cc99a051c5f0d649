"""The largest responses |H(i w)| of S models of one structure in a range of frequencies, from their poles and residues.

Each model has lines of its own, as dense about its poles as those of a single response (``frequency.features``); where d log|H| / dw
changes its sign between two of them, the peak is refined to rounding error, all peaks at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..frequency.features import BEYOND, EACH_DECADE, FIRST, MOST, RATIO
from ..frequency.shock.extrema import falling_root
from ..ground.tolerances import AUTO_DISTANCE, EPS, LINE_ACCURACY
from .stacked_poles import StackedTransfer


@dataclass(frozen=True, eq=False)
class LargestResponses:
    """The largest |H| of each entry with its frequency in Hz, shape (S, p, m) each; NaN where there is none."""

    amplitudes: np.ndarray
    frequencies_hz: np.ndarray
    serve: np.ndarray  # models whose values are as accurate as those of a single response, shape (S,)


def largest_responses(transfer: StackedTransfer, limits: tuple[float, float], ends: Sequence[float]) -> LargestResponses:
    """The largest |H| at peaks between limits in Hz, 0 and infinite where the range is open, and at given ends of the range."""
    poles, given = transfer.poles, 2 * np.pi * np.array(ends, dtype=float)
    present = poles.weights > 0
    damped = np.where(present, poles.values.real < -LINE_ACCURACY * np.abs(poles.values), True).all(axis=1)
    serve = poles.serve & damped
    present = present & serve[:, None]
    sums, shape = _Sums.of(transfer, present), (len(serve), len(transfer.outputs), transfer.motions.shape[1])
    with np.errstate(all="ignore"):
        omega = _lines(np.where(present, poles.values, -1.0), 2 * np.pi * limits[0], 2 * np.pi * limits[1])
        slopes = sums.slopes(omega)
        model, entry, at = np.nonzero((slopes[..., :-1] > 0) & (slopes[..., 1:] <= 0))
        own = sums.of_entries(model, entry)
        brackets = (omega[model, at], omega[model, at + 1], slopes[model, entry, at], slopes[model, entry, at + 1])
        peaks = falling_root(lambda w: own.slopes(w[:, None])[:, 0, 0], *brackets)
        rank = np.arange(len(model)) - np.searchsorted(model, model)
        count = int(rank.max(initial=-1)) + 1
        places = np.hstack([np.repeat(omega[:, :1], count, axis=1), np.broadcast_to(given, (len(omega), len(given)))])
        places[model, rank] = peaks
        values, errors = (each.reshape(len(omega), -1, places.shape[1]) for each in transfer(1j * places))
        sizes, w = np.abs(values), places[:, None, :]
        errors = errors + EPS * np.where(w > 0, sizes * np.abs(w * sums.slopes(places)), 0.0)  # w has a rounding error
        chosen = np.zeros(sizes.shape, dtype=bool)
        chosen[model, entry, rank], chosen[..., count:] = True, True
        sizes = np.where(chosen, sizes, -np.inf)
        best = sizes.argmax(axis=2)[..., None] if places.shape[1] else np.zeros((*sizes.shape[:2], 0), dtype=int)
        largest, where = np.take_along_axis(sizes, best, axis=2), np.take_along_axis(np.broadcast_to(w, sizes.shape), best, axis=2)
        serve = serve & (~chosen | (errors <= LINE_ACCURACY * largest)).all(axis=(1, 2))
    some = chosen.any(axis=2)
    amplitudes, frequencies = (np.full(sizes.shape[:2], np.nan) for _ in range(2))
    amplitudes[some], frequencies[some] = largest[some, 0], where[some, 0] / (2 * np.pi)
    return LargestResponses(amplitudes.reshape(shape), frequencies.reshape(shape), serve)


def _lines(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Ascending angular frequencies of each model in a range, from a decade below all poles to a decade above where it is open, (S, L)."""
    moduli, w = np.abs(values), values.imag
    low = low or float(moduli.min(initial=1.0)) / BEYOND
    high = max(low, high if np.isfinite(high) else float(moduli.max(initial=1.0)) * BEYOND)
    common = np.geomspace(low, high, int(EACH_DECADE * np.log10(high / low)) + 2)
    scale = np.maximum(np.abs(values.real), AUTO_DISTANCE * w)
    reach = np.log((w / scale).max(initial=RATIO) / FIRST) / np.log(RATIO)
    offsets = np.multiply.outer(scale, FIRST * RATIO ** np.arange(min(MOST, int(reach) + 1)))
    near = np.concatenate([w[..., None] - offsets, w[..., None], w[..., None] + offsets], axis=2).reshape(len(values), -1)
    return np.sort(np.hstack([np.broadcast_to(common, (len(values), len(common))), np.clip(near, low, high)]), axis=1)


@dataclass(frozen=True, eq=False)
class _Sums:
    """E entries of H of N models: s^power times the sum over k of s^k times residues over s - s_k and a constant."""

    values: np.ndarray  # s_k and their conjugates, shape (N, P)
    parts: tuple[tuple[np.ndarray, np.ndarray], ...]  # residues and constant for each k, shapes (N, E, P) and (N, E)
    powers: np.ndarray  # shape (N, E)

    @classmethod
    def of(cls, transfer: StackedTransfer, present: np.ndarray) -> _Sums:
        poles, parts = transfer.poles, []
        counted = np.concatenate([present, present & (poles.weights == 2)], axis=1)[:, None]
        values = np.where(present, poles.values, -1.0)
        for k, (residues, _, constant) in enumerate(transfer.terms()):
            R = residues.reshape(len(present), -1, residues.shape[3])
            D = (constant + transfer.outputs @ transfer.motions if not k else constant).reshape(len(present), -1)
            parts.append((np.where(counted, np.concatenate([R, R.conj()], axis=2), 0.0), D))
        powers = np.broadcast_to(
            transfer.order - transfer.levels, (*present.shape[:1], len(transfer.outputs), len(transfer.levels))
        )
        return cls(np.concatenate([values, values.conj()], axis=1), tuple(parts), powers.reshape(len(present), -1))

    def of_entries(self, model: np.ndarray, entry: np.ndarray) -> _Sums:
        """Some entries, each as a model with one."""
        parts = tuple((R[model, entry][:, None], D[model, entry][:, None]) for R, D in self.parts)
        return _Sums(self.values[model], parts, self.powers[model, entry][:, None])

    def slopes(self, omega: np.ndarray) -> np.ndarray:
        """d log|H| / dw at angular frequencies of each model, shape (N, F) -> (N, E, F)."""
        s = 1j * omega[:, None, :]
        each = 1 / (s - self.values[:, :, None])
        total, rate, squares = 0.0, 0.0, each * each
        for k, (residues, constant) in enumerate(self.parts):
            part = residues @ each + constant[..., None]
            total = total + part * s**k
            rate = rate - residues @ squares * s**k + (k * part * s ** (k - 1) if k else 0.0)
        return np.real(1j * (rate / total + self.powers[..., None] / s))
