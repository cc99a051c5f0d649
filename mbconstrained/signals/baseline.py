"""Baselines of records: polynomials of time, fitted by least squares to the record or to its integral, and removed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..ground.checks import check_known
from ..ground.errors import InputError

#: Degrees by name.
DEGREES = {"constant": 0, "linear": 1, "quadratic": 2, "cubic": 3}

FITS = ("record", "integral")

#: Points and weights of Gauss's rule on an interval, exact to degree 5: the square of the integral of a record has degree 4.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True, eq=False)
class Baseline:
    """p(t) = sum of coefficients[k] (t - start)^k."""

    start: float  # time of the first sample
    coefficients: np.ndarray  # ascending powers, in the unit of the record by s^k

    def __call__(self, times) -> np.ndarray:
        """p at times."""
        return np.polynomial.polynomial.polyval(np.asarray(times) - self.start, self.coefficients)


def baseline(times: np.ndarray, values: np.ndarray, degree: str = "linear", fit: str = "record") -> Baseline:
    """The baseline p(t) of a record a(t), linear between its samples, from its first time 0 to its last T.

    Of the fit "record" the integral of (a - p)^2 over [0, T] is smallest, of "integral" that of (v - w)^2 with v and w the integrals
    of a and p from 0: the velocities, if a is an acceleration. Sources: Berg and Housner, Integrated velocity and displacement of strong
    earthquake ground motion, Bulletin of the Seismological Society of America 51 (1961), for "integral" with a quadratic p; Boore and
    Bommer, Processing of strong-motion accelerograms, Soil Dynamics and Earthquake Engineering 25 (2005), on both.
    """
    check_known(degree, DEGREES, "baseline")
    check_known(fit, FITS, "baseline_fit")
    duration = float(times[-1] - times[0]) if len(times) else 0.0
    if not duration > 0:
        raise InputError("baseline: found a record without a duration; expected samples at several times")
    h, slopes = _steps(times, values)
    inside = h[:, None] * (_NODES + 1) / 2  # times after the sample before
    u, root = ((times[:-1] - times[0])[:, None] + inside).ravel() / duration, np.sqrt(h[:, None] * _WEIGHTS).ravel()
    aims, powers = values[:-1, None] + slopes[:, None] * inside, np.arange(DEGREES[degree] + 1)
    basis = u[:, None] ** powers
    if fit == "integral":
        aims = integrals(times, values)[0][:-1, None] + inside * (values[:-1, None] + slopes[:, None] * inside / 2)
        basis = duration * u[:, None] ** (powers + 1) / (powers + 1)
    coefficients = np.linalg.lstsq(root[:, None] * basis, root * aims.ravel(), rcond=None)[0]
    return Baseline(float(times[0]), coefficients / duration**powers)


def integrals(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The first and the second integral of a record at its samples, from 0."""
    h, slopes = _steps(times, values)
    first = np.append(0.0, np.cumsum(h * (values[:-1] + slopes * h / 2)))
    second = np.append(0.0, np.cumsum(h * (first[:-1] + h * (values[:-1] / 2 + slopes * h / 6))))
    return first, second


def _steps(times: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    h = np.diff(times)
    return h, np.divide(np.diff(values), h, out=np.zeros(len(h)), where=h > 0)
