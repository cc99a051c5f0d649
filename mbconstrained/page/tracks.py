"""Tracks: numbers over time as 16-bit codes with their lowest value and a step, where a picture shows no difference."""

from __future__ import annotations

import numpy as np

from .packing import packed

#: The largest code.
STEPS = 2**16 - 1

#: The largest value of s² (1 - s), by which a rate that is off moves a cubic between its ends, for either end.
SWAY = 4 / 27


def track(rows: np.ndarray, errors: np.ndarray) -> dict | None:
    """Rows (k, T) as codes, number by number in the order of time; None where a row would be off by more than its error (k,).

    >>> found = track(np.array([[1.0, 2.0, 4.0]]), np.array([1e-4]))
    >>> found["low"], found["codes"] == packed(np.array([0, 21845, 65535]), "<u2")
    ([1.0], True)
    """
    low, step = rows.min(axis=1), np.ptp(rows, axis=1) / STEPS
    if not (step / 2 <= errors).all():
        return None
    return {"low": low.tolist(), "step": step.tolist(), "codes": packed(_codes(rows).T, "<u2")}


def read_back(rows: np.ndarray) -> np.ndarray:
    """What the page reads of rows (k, T) that are tracks."""
    return rows.min(axis=1)[:, None] + np.ptp(rows, axis=1)[:, None] / STEPS * _codes(rows)


def _codes(rows: np.ndarray) -> np.ndarray:
    step = np.ptp(rows, axis=1)[:, None] / STEPS
    return np.round((rows - rows.min(axis=1)[:, None]) / np.where(step > 0, step, 1.0))
