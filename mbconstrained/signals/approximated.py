"""A function of time known by its values: piecewise polynomials through Chebyshev points, to a stated tolerance.

First its edges are found, kinks and jumps. Then the stretches between them are divided evenly, as finely as needed. All
pieces so have nearly the same length, and one chain of states for t^k, in units of this length, serves all of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..checks import real_number
from ..errors import InputError
from ..notices import Notice
from ..tolerances import EPS
from .bohl import BohlFunction
from .chebyshev import DEGREE, Fit
from .edges import FIRST_HALVINGS, MOST_HALVINGS, REMEDY, edges_of
from .impulsive import ImpulsiveSmooth
from .restarts import Restarts
from .values import Values

#: The tolerance when none is asked for: a little above what rounding leaves of polynomials of this degree.
TOLERANCE = 1e-12

#: A tolerance below this many roundings of the largest value cannot be reached.
LEAST_TOLERANCE = 64 * EPS

#: One over the length of a piece, and its products with the values, must stay within the range of float64.
SHORTEST_END = 1e-280


@dataclass(frozen=True, repr=False)
class Approximation(ImpulsiveSmooth):
    """An input that stands for a function known by its values.

    Attributes:
        points: how many times the function was evaluated.
        pieces: how many polynomials stand for it.
        error: estimate of max |error| / max |value|, from the polynomials' last coefficients and from values between
            the points that they go through.
    """

    points: int = 0
    pieces: int = 0
    error: float = 0.0


def approximated(function: Callable, end: float, *, tolerance: float = TOLERANCE) -> Approximation:
    """The function for 0 <= t < end, zero from then on, by piecewise polynomials of degree 10.

    Kinks and jumps of the function are found to rounding; a feature shorter than a hundredth of the whole between two
    smooth stretches may be missed. Derivatives of the answer that need derivatives of the force lose digits with each.

    Args:
        function: takes times of shape (T,) and returns values (r, T) or (T,); or takes one time and returns (r,) or
            a number. It is evaluated at times between 0 and end only.
        end: in s.
        tolerance: of the error relative to the largest value.

    Raises:
        InputError: values that are not real, not finite, of different shapes or not reached to the tolerance, a call that
            fails; the text says where.

    >>> f = approximated(lambda t: np.abs(np.sin(3 * t)), 2.0)
    >>> float(abs(f(1.0)[0] - abs(np.sin(3.0)))) < 1e-12, f.error < 1e-12
    (True, True)
    """
    end, tolerance = real_number(end, "end", positive=True), real_number(tolerance, "tolerance", positive=True)
    if tolerance < LEAST_TOLERANCE:
        raise InputError(f"tolerance: found {tolerance:g}; rounding allows at least {LEAST_TOLERANCE:.2g}")
    values = Values(function, tolerance)
    if end < SHORTEST_END:
        raise InputError(f"end: found {end:g} s; expected at least {SHORTEST_END:g} s, so that slopes stay in the range of float64")
    knots, fit = _even_pieces(values, edges_of(values, end), end)
    error = float(fit.error.max() / values.largest) if values.largest else 0.0
    text = f"the force is approximated by {len(knots) - 1} polynomials from {values.points} values, to {error:.2g} of its largest"
    smooth = _function(knots, fit, tolerance * values.largest)
    return Approximation(smooth, (), (), (Notice("accuracy", text),), values.points, len(knots) - 1, error)


def _even_pieces(values: Values, edges: np.ndarray, end: float) -> tuple[np.ndarray, Fit]:
    """Knots and polynomials, the stretches between the edges divided evenly."""
    borders = np.concatenate([[0.0], edges, [end]])
    for halvings in range(FIRST_HALVINGS, MOST_HALVINGS + 1):
        counts = np.ceil(np.diff(borders) / end * 2**halvings - EPS**0.5).astype(int).clip(1)
        stretches = [np.linspace(a, b, n, endpoint=False) for a, b, n in zip(borders, borders[1:], counts)]
        knots = np.append(np.concatenate(stretches), end)
        fit = values.fit(knots[:-1], np.diff(knots))
        if fit.follows.all():
            return knots, fit
    place, error = knots[np.argmin(fit.follows)], fit.error[np.argmin(fit.follows)] / values.largest
    raise InputError(
        f"function: near t = {place:.6g} s {2**MOST_HALVINGS} polynomials follow it only to {error:.2g} of its largest value, "
        f"not to {values.tolerance:g}; {REMEDY}"
    )


def _function(knots: np.ndarray, fit: Fit, error: float) -> BohlFunction:
    """The pieces as one function: the states of a row are p^(k) / (k! u^k), u one over the longest piece."""
    lengths = np.diff(knots)
    ratio = lengths.max() / lengths
    powers = ratio[:, None] ** np.arange(DEGREE + 1.0)
    jumps = np.zeros((fit.size, len(knots), DEGREE + 1))
    jumps[:, 0] = fit.begins_from_zero(error)[:, 0] * powers[0]
    jumps[:, -1] = -fit.ends_at_zero(error)[:, -1] * powers[-1]
    jumps[:, 1:-1] = fit.jumps(error, ratio) * powers[1:]
    states = np.concatenate([fit.powers * powers, np.zeros((fit.size, 1, DEGREE + 1))], axis=1)
    count = max(int(np.flatnonzero(states.any(axis=(0, 1))).max(initial=0)), 0) + 1
    generator = np.diag(np.arange(1.0, count), k=1) / lengths.max()
    rows = np.kron(np.eye(fit.size), np.eye(1, count)[0])
    start = Restarts(knots, _by_state(states[..., :count]), _by_state(jumps[..., :count]))
    return BohlFunction(rows, (generator,) * fit.size, start)


def _by_state(values: np.ndarray) -> np.ndarray:
    """(r, K, m) as (r m, K)."""
    return values.transpose(0, 2, 1).reshape(-1, values.shape[1])
