"""Maxima and minima of functions of time in closed form, by branch and bound: none is missed, each is as accurate as the function.

On a panel of width h the third derivative of f = C e^{J t} v is at most B_3 = sum over blocks |c J^3| |v(t_0)| e^{max(mu, 0) h}, mu the
logarithmic norm of the block. A panel is left out where no value on it exceeds the best one known, f <= max(f_0, f_1) + B_2 h^2 / 8; it has at
most one extremum, which is refined, where f'' keeps its sign, |f''| at the middle > B_3 h / 2; all others are halved. Sources: logarithmic norm,
Dahlquist, Trans. Royal Inst. of Technology Stockholm 130 (1959); branch and bound, Piyavskii, USSR Comput. Math. 12 (1972).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ...ground.tolerances import EPS
from ...linalg.blocks import block_slices
from ...signals.bohl import BohlFunction

#: Most steps that refine the time of an extremum.
STEPS = 60

#: Panels that are evaluated at once, times the number of states and rows.
CHUNK = 1 << 18

#: Panels are not halved beyond this share of the time at which they are.
NARROWEST = 8 * EPS

#: Rounding errors of a value, relative to the largest of its function, and to the terms that it is the sum of.
NOISE = 16 * EPS


@dataclass(frozen=True, eq=False)
class Extrema:
    """The largest and the smallest value of each of r functions, and their times.

    Attributes:
        maximum, minimum: shape (r,).
        maximum_time, minimum_time: in s, shape (r,); that of a limit from the left is the last float64 number before the jump.
    """

    maximum: np.ndarray
    minimum: np.ndarray
    maximum_time: np.ndarray
    minimum_time: np.ndarray

    @property
    def largest(self) -> np.ndarray:
        """max |f|, shape (r,)."""
        return np.maximum(self.maximum, -self.minimum)


def extrema(function: BohlFunction, start: float, end: float) -> Extrema:
    """The extrema of f(t) on [start, end].

    Args:
        function: f, of r rows; at its knots f and its derivatives may jump, and the limits from both sides count.
        start, end: in s.

    Returns:
        Values and times.

    >>> from mbconstrained.signals.inputs import harmonic
    >>> wave = extrema(harmonic([1.0], angular_frequency=1.0, phase=-np.pi / 2).smooth, 0.0, 3.0)  # sin t
    >>> wave.maximum_time.round(12), abs(wave.minimum) < 1e-15
    (array([1.57079633]), array([ True]))
    """
    search = _Search(getattr(function, "rough", function), start, end)
    search.run()
    times = search.times.ravel()
    row = np.tile(np.arange(function.size), 2)
    maximum, minimum = function(times)[row, np.arange(len(row))].reshape(2, -1) if len(row) else np.zeros((2, 0))
    noise = NOISE * np.maximum(np.abs(maximum), np.abs(minimum))
    maximum, minimum = (np.where(np.abs(one) > noise, one, 0.0) for one in (maximum, minimum))
    return Extrema(maximum, minimum, *search.times)


class _Search:
    """The work of one call. Signs: all is done for f and for -f."""

    def __init__(self, function: BohlFunction, start: float, end: float):
        self.functions = (function, function.derivative(1), function.derivative(2))
        knots = function.restarts.knots
        self.edges = np.unique([start, *knots[(knots > start) & (knots < end)], end])
        slices, J = block_slices(function.blocks), function.blocks
        self.first = np.array([at.start for at in slices], dtype=int)
        scales, growth = [np.ones(0)], []
        for block in J:
            balanced, (scale, _) = scipy.linalg.matrix_balance(block, permute=False, separate=True)
            scales.append(scale)
            growth.append(np.linalg.eigvalsh((balanced + balanced.T) / 2)[-1])
        self.scale, self.growth = np.concatenate(scales), np.maximum(np.array(growth), 0.0)
        self.states = BohlFunction(np.eye(len(self.scale)) / self.scale[:, None], J, function.start)
        own = BohlFunction(function.coefficients, J, function.start)  # derivatives of a response may have other states
        self.bounds = tuple(self._row_norms(own.derivative(order).coefficients) for order in (0, 2, 3))
        self.best = np.full((2, function.size), -np.inf)
        self.times = np.full((2, function.size), float(start))

    def _row_norms(self, coefficients: np.ndarray) -> np.ndarray:
        """|c D| of each block, shape (r, number of blocks)."""
        squares = np.square(coefficients * self.scale)
        return np.sqrt(np.add.reduceat(squares, self.first, axis=1)) if len(self.first) else np.zeros((len(squares), 0))

    def _sizes(self, times: np.ndarray) -> np.ndarray:
        """|D^-1 v| of each block, shape (number of blocks, P)."""
        squares = np.square(self.states(times))
        return np.sqrt(np.add.reduceat(squares, self.first, axis=0)) if len(self.first) else np.zeros((0, len(times)))

    def run(self) -> None:
        """Search all panels."""
        a = self.edges[:-1]
        b = np.nextafter(self.edges[1:], a)  # the limits from the left
        b[-1:] = self.edges[-1]
        panels = self._panels(a, b, *self._ends(a), *self._ends(b), self._sizes(a))
        for times, values in ((panels["a"], panels["fa"]), (panels["b"], panels["fb"])):
            self._note(times, values)
        if not len(a):
            self._note(self.edges, self.functions[0](self.edges))
        waiting, most = [panels], max(1, CHUNK // max(len(self.scale) + 4 * self.best.shape[1], 1))
        while waiting:
            panels = waiting.pop()
            if panels["a"].shape[-1] > most:
                waiting += [_part(panels, slice(most, None)), _part(panels, slice(0, most))]
            elif panels["a"].shape[-1]:
                waiting.append(self._halved(panels))

    @staticmethod
    def _panels(a, b, fa, da, fb, db, sizes) -> dict[str, np.ndarray]:
        return {"a": a, "b": b, "fa": fa, "da": da, "fb": fb, "db": db, "sizes": sizes}

    def _ends(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.functions[0](times), self.functions[1](times)

    def _note(self, times: np.ndarray, values: np.ndarray, rows: np.ndarray | None = None) -> None:
        """Keep values (r, P) at times (P,), or values (P,) of single rows, where they are better."""
        if not values.size:
            return
        for side, signed in enumerate((values, -values)):
            if rows is None:
                place = signed.argmax(axis=1)
                candidates, at, own = signed[np.arange(len(signed)), place], times[place], np.arange(len(signed))
            else:
                order = np.argsort(signed, kind="stable")  # the best of each row is written last
                own, candidates, at = rows[order], signed[order], times[order]
            better = candidates > self.best[side, own]
            self.best[side, own[better]], self.times[side, own[better]] = candidates[better], at[better]

    def _halved(self, panels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
        """Halves of the panels that may have a better value."""
        a, b, sizes = panels["a"], panels["b"], panels["sizes"]
        h, middle = b - a, a + (b - a) / 2
        f, slope, bend = (function(middle) for function in self.functions)
        self._note(middle, f)
        with np.errstate(over="ignore", invalid="ignore"):
            grown = sizes * np.exp(np.minimum(np.multiply.outer(self.growth, h), 700.0))
            second, third = (bound @ grown for bound in self.bounds[1:])
            second = np.minimum(np.nan_to_num(second, nan=np.inf), np.abs(bend) + np.nan_to_num(third, nan=np.inf) * h / 2)
            reach, is_bent = second * h**2 / 8, np.abs(bend) > third * h / 2
        noise = NOISE * np.maximum(
            self.best.max(axis=0)[:, None], self.bounds[0] @ sizes
        )  # terms that cancel have rounding errors of their own size
        open_ = np.zeros(f.shape, dtype=bool)
        for side, sign in enumerate((1.0, -1.0)):
            hope = np.maximum(sign * panels["fa"], sign * panels["fb"]) + reach > self.best[side][:, None] + noise
            row, place = np.nonzero(hope & is_bent & (sign * panels["da"] > 0) & (sign * panels["db"] < 0))
            if len(row):
                self._refine(row, a[place], b[place], panels["da"][row, place], panels["db"][row, place])
            open_ |= hope & ~is_bent
        kept = open_.any(axis=0) & (h > NARROWEST * np.abs(b))
        left = _part(panels, kept)
        middle, own = middle[kept], (f[:, kept], slope[:, kept])
        first = left | {"b": middle, "fb": own[0], "db": own[1]}
        other = left | {"a": middle, "fa": own[0], "da": own[1], "sizes": self._sizes(middle)}
        return {name: np.concatenate([first[name], other[name]], axis=-1) for name in first}

    def _refine(self, row, low, high, above, below) -> None:
        """The extrema between these times, one each."""
        at = np.arange(len(row))
        times = falling_root(lambda t: np.sign(above) * self.functions[1](t)[row, at], low, high, np.abs(above), -np.abs(below))
        self._note(times, self.functions[0](times)[row, at], row)


def _part(panels: dict[str, np.ndarray], chosen) -> dict[str, np.ndarray]:
    return {name: values[..., chosen] for name, values in panels.items()}


def falling_root(rate: Callable, low, high, above, below, is_enough: Callable | None = None) -> np.ndarray:
    """Where functions change from positive to negative, by the rule of Illinois: an end that stays twice counts half.

    Args:
        rate: the functions, each at its own time, shape (K,).
        low, high: ends of the intervals, shape (K,).
        above, below: values there, positive and negative.
        is_enough: of the values at the last times and the widths of the intervals, whether more steps gain nothing.

    Returns:
        Shape (K,).
    """
    last, middle = np.zeros(len(low)), low
    for _ in range(STEPS):
        with np.errstate(invalid="ignore"):
            share = np.nan_to_num(above / (above - below), nan=0.5)
        middle = low + (high - low) * share
        now = rate(middle)
        side = np.sign(now)
        above, below = (
            np.where(side > 0, now, np.where(last < 0, above / 2, above)),
            np.where(side > 0, np.where(last > 0, below / 2, below), now),
        )
        low, high, last = np.where(side > 0, middle, low), np.where(side > 0, high, middle), side
        narrow = high - low <= np.spacing(np.abs(high))
        if (narrow | (now == 0)).all() or (is_enough is not None and is_enough(now, high - low)):
            break
    return middle
