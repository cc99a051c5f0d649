"""The values of a function that a user gives: called with many times or one by one, and checked, with the time told."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..errors import InputError
from .chebyshev import CHECKS, NODES, Fit, fitted

#: Larger values leave the range of float64 when the coefficients of polynomials are made of them.
LARGEST_VALUE = 1e280

EXPECTED = "expected a number or a list of r numbers for each time"


class Values:
    """The function at any times, as an array (r, ...), with its largest value and the number of times so far."""

    def __init__(self, function: Callable, tolerance: float):
        if not callable(function):
            raise InputError(f"function: found {function!r}; expected a function of time, e.g. lambda t: np.sin(3 * t)")
        self.function, self.tolerance = function, tolerance
        self.points, self.largest, self.by_array = 0, 0.0, True
        self.rows: int | None = None

    def __call__(self, times: np.ndarray) -> np.ndarray:
        flat = times.ravel()
        with np.errstate(all="ignore"):  # what is not finite is told, with the time
            found = self._together(flat)
            found = self._one_by_one(flat) if found is None else found
        self._check(flat, found)
        self.points += len(flat)
        self.largest = max(self.largest, float(np.abs(found).max(initial=0.0)))
        return found.reshape(-1, *times.shape)

    def fit(self, begins: np.ndarray, lengths: np.ndarray) -> Fit:
        """Polynomials on the intervals, and whether they follow the function to the tolerance."""
        places = np.concatenate([NODES, CHECKS])
        found = self(begins[:, None] + lengths[:, None] * places)
        return fitted(found, self.largest, self.tolerance)

    def _check(self, times, found) -> None:
        fits = (np.abs(found) <= LARGEST_VALUE).all(axis=0)
        if not fits.all():
            at = int(np.argmin(fits))
            what = "larger than can be used" if np.isfinite(found[:, at]).all() else "not finite"
            raise InputError(f"function: it is {what} at t = {times[at]:.17g} s; expected values of a size up to {LARGEST_VALUE:g}")
        self.rows = len(found) if self.rows is None else self.rows
        if len(found) != self.rows:
            raise InputError(f"function: it has {len(found)} rows near t = {times[0]:.17g} s and {self.rows} elsewhere; {EXPECTED}")

    def _together(self, times) -> np.ndarray | None:
        """All at once, or None where the function takes one time only."""
        if self.by_array:
            try:
                found = np.asarray(self.function(times.copy()))
            except Exception:  # one time alone, in the next step, tells what is wrong and where
                found = np.zeros(())
            if found.dtype.kind in "biuf" and found.ndim in (1, 2) and found.size and found.shape[-1] == len(times):
                return found.reshape(-1, len(times)).astype(float)
            self.by_array = False
        return None

    def _one_by_one(self, times) -> np.ndarray:
        found = [self._at(float(t)) for t in times]
        for t, value in zip(times, found):
            if len(value) != len(found[0]):
                raise InputError(
                    f"function: it has {len(value)} rows at t = {t:.17g} s and {len(found[0])} at t = {times[0]:.17g} s; {EXPECTED}"
                )
        return np.array(found).T

    def _at(self, t: float) -> np.ndarray:
        try:
            value = self.function(t)
        except ArithmeticError as problem:
            raise InputError(f"function: it is not finite at t = {t:.17g} s ({problem}); give one that always is") from problem
        except Exception as problem:
            raise InputError(
                f"function: its call with t = {t:.17g} s fails with {type(problem).__name__}: {problem}; {EXPECTED}"
            ) from problem
        return _row(value, t)


def _row(value, t: float) -> np.ndarray:
    """A value as an array (r,)."""
    try:
        array = np.asarray(value)
        if array.dtype.kind == "O":  # numbers of other kinds, such as fractions
            array = np.array([float(item) for item in array.ravel()]).reshape(array.shape)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"function: found {_shown(value)} at t = {t:.17g} s; {EXPECTED}") from None
    if array.dtype.kind == "c":
        raise InputError(f"function: found the complex {_shown(value)} at t = {t:.17g} s; expected real numbers, e.g. real parts")
    if array.dtype.kind not in "biuf" or array.ndim > 1 or not array.size:
        raise InputError(f"function: found {_shown(value)} at t = {t:.17g} s; {EXPECTED}")
    return np.atleast_1d(array).astype(float)


def _shown(value) -> str:
    if isinstance(value, np.ndarray) and value.ndim:
        return f"array of shape {value.shape}"
    text = repr(value.item() if isinstance(value, np.generic) else value)
    return text if len(text) <= 60 else text[:57] + "..."
