"""The motion y' = J y of one phase over time, and the first zeros of linear functions of it: none is missed.

On a panel of width h a function g = c y - b is its Taylor polynomial about the begin of the panel, c J^k y h^k / k!, whose remainder is below
rounding errors. In the Bernstein basis its coefficients enclose it: a panel with positive coefficients has no zero, other panels are
halved until there is none or exactly one change of sign (Descartes' rule; Farouki, CAGD 29 (2012) 379). Panels are as wide as the fastest
rate allows. Fast states of small amplitude do not make them narrower: on wide panels only slow states are expanded, and the amplitudes of
the fast ones bound the rest; where these decide, the panel is divided.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import comb, exp

import numpy as np
import scipy

from ...ground.tolerances import EPS
from ...linalg.blocks import block_matrix, block_slices
from ...linalg.exponential import block_states

#: Terms of Taylor polynomials, and the width of a panel times the fastest rate: REACH^TERMS / TERMS! is below EPS / 8.
TERMS, REACH = 24, 2.0

#: Panels that are searched at once.
PANELS = 16

#: Rates on panels of the next width are less than the fastest by this factor or more.
LEVEL_RATIO = 6.0

#: Rounding errors of a value, relative to the sum of the moduli of its terms.
NOISE = 64 * EPS

#: Derivatives that decide on the sign just after a zero.
ORDERS = 6

#: A zero is bisected until the panel is so narrow, relative to the first.
NARROWEST = 2.0**-26

#: Steps of Newton's method, safeguarded by bisection.
STEPS = 80


@lru_cache(maxsize=1)
def _bernstein() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bernstein from Taylor coefficients on [0, 1], and those of both halves from Bernstein coefficients."""
    n = TERMS - 1
    to = np.array([[comb(j, k) / comb(n, k) if k <= j else 0.0 for k in range(TERMS)] for j in range(TERMS)])
    left = np.array([[comb(j, k) / 2.0**j if k <= j else 0.0 for k in range(TERMS)] for j in range(TERMS)])
    return to, left, left[::-1, ::-1]


@dataclass(frozen=True, eq=False)
class Crossing:
    """The first time at which guards vanish.

    Attributes:
        time: in s, since the begin of the flow.
        state: y there.
        guards: places of the guards that vanish there.
        grazing: whether the guard only touches zero.
    """

    time: float
    state: np.ndarray
    guards: np.ndarray
    grazing: bool = False


@dataclass(frozen=True, eq=False)
class _Level:
    """Panels of one width.

    Attributes:
        width: h in s.
        slow: the states that are expanded.
        taylor: c J^k h^k / k! of guards on these states, shape (p, TERMS, m).
        bernstein: the coefficients in the Bernstein basis, shape (p TERMS, m).
        steps: e^{J j h}, j = 0 ... PANELS, shape (PANELS + 1, n, n).
        fast: bounds of the fast states' part by |y|, shape (p, n).
    """

    width: float
    slow: np.ndarray
    taylor: np.ndarray
    bernstein: np.ndarray
    steps: np.ndarray
    fast: np.ndarray


class PhaseFlow:
    """y(t) = e^{J t} y_0 with guards g = c y - b.

    Args:
        blocks: the diagonal blocks of J.
        rows: c of p guards, shape (p, n).
        values: b, shape (p,).
        longest: the longest time of interest, s.
    """

    def __init__(self, blocks: Sequence[np.ndarray], rows: np.ndarray, values: np.ndarray, longest: float):
        self.blocks, self.rows, self.values, self.longest = tuple(blocks), rows, values, longest
        self.size = len(rows)
        self.J = block_matrix(self.blocks)
        self.slices = block_slices(self.blocks)
        self.rates = np.array([_rate(block) for block in self.blocks])
        self.growth = np.array([_growth(block) for block in self.blocks])

    @cached_property
    def _rate_of_state(self) -> np.ndarray:
        return np.repeat(self.rates, [len(block) for block in self.blocks])

    @cached_property
    def _widths(self) -> list[float]:
        """Widths of panels by level, ascending."""
        rates, widths = np.sort(self.rates[self.rates > 0])[::-1], []
        while len(rates):
            widths.append(min(REACH / rates[0], self.longest))
            rates = rates[rates * LEVEL_RATIO < rates[0]]
        return widths or [self.longest]

    @cached_property
    def _levels(self) -> list[_Level | None]:
        return [None] * len(self._widths)

    def _level(self, number: int) -> _Level:
        if self._levels[number] is None:
            self._levels[number] = self._made_level(number)
        return self._levels[number]

    def _made_level(self, number: int) -> _Level:
        h, n = self._widths[number], len(self.J)
        slow = np.flatnonzero(self._rate_of_state * h <= REACH * (1 + EPS))
        part, power = self.J[np.ix_(slow, slow)] * h, self.rows[:, slow]
        taylor = np.empty((self.size, TERMS, len(slow)))
        for k in range(TERMS):
            taylor[:, k] = power
            power = power @ part / (k + 1)
        bernstein = np.einsum("jk,pkn->pjn", _bernstein()[0], taylor).reshape(-1, len(slow))
        units, times = np.tile(np.eye(n), PANELS + 1), np.repeat(h * np.arange(PANELS + 1), n)
        steps = block_states(self.blocks, units, times).reshape(n, PANELS + 1, n).transpose(1, 0, 2)
        fast = np.zeros((self.size, n))
        for at, growth, rate in zip(self.slices, self.growth, self.rates):
            if rate * h > REACH * (1 + EPS):
                largest = np.linalg.norm(self.rows[:, at], axis=1) * exp(min(max(growth, 0.0) * h, 700.0))
                fast[:, at] = largest[:, None]
        return _Level(h, slow, taylor, bernstein, np.ascontiguousarray(steps), fast)

    @cached_property
    def _powers(self) -> np.ndarray:
        """(J h)^k / k! on panels of least width, shape (TERMS n, n)."""
        h, n = self._widths[0], len(self.J)
        power, powers = np.eye(n), np.empty((TERMS, n, n))
        for k in range(TERMS):
            powers[k] = power
            power = power @ (self.J * h) / (k + 1)
        return powers.reshape(TERMS * n, n)

    def states(self, y: np.ndarray, time: float) -> np.ndarray:
        """y at one time."""
        h = self._widths[0]
        if 0 <= time <= h:
            return (time / h) ** np.arange(TERMS) @ (self._powers @ y).reshape(TERMS, -1)
        return block_states(self.blocks, y[:, None], np.array([time]))[:, 0]

    # Signs at the begin.

    @cached_property
    def _derivatives(self) -> tuple[np.ndarray, np.ndarray]:
        """c J^k h^k / k!, shape (p, ORDERS, n), and their moduli."""
        h = self._widths[0]
        rows, power = np.empty((self.size, ORDERS, len(self.J))), self.rows
        for k in range(ORDERS):
            rows[:, k] = power
            power = power @ (self.J * h) / (k + 1)
        return rows, np.abs(rows)

    def orders(self, y: np.ndarray, known: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The order of the zero of each guard at the begin, its sign just after it, and the first coefficients.

        Args:
            y: the state.
            known: which guards are known to vanish there, whatever their rounding error.

        Returns:
            Orders (p,), 0 where a guard does not vanish and ORDERS where no derivative decides; signs (p,), 0 there; and Taylor
            coefficients times powers of the width, shape (p, ORDERS).
        """
        if not self.size:
            return np.zeros(0, int), np.zeros(0), np.zeros((0, ORDERS))
        rows, moduli = self._derivatives
        values, noise = rows @ y, NOISE * (moduli @ np.abs(y))
        values[:, 0] -= self.values
        noise[:, 0] += NOISE * np.abs(self.values)
        values[known, 0] = 0.0
        counts = np.abs(values) > np.maximum(noise, NOISE * noise.max(axis=1, initial=0.0)[:, None] * EPS)
        counts[known, 0] = False
        order = np.where(counts.any(axis=1), counts.argmax(axis=1), ORDERS)
        sign = np.where(order < ORDERS, np.sign(values[np.arange(self.size), np.minimum(order, ORDERS - 1)]), 0.0)
        return order, sign, values

    # The first zero.

    def first_crossing(self, y: np.ndarray, order: np.ndarray, horizon: float, active: np.ndarray) -> Crossing | None:
        """The first time in (0, horizon] at which an active guard falls to zero; guards are positive just after the begin.

        Args:
            y: the state at the begin.
            order: of the zero of each guard at the begin, as of ``orders``.
            horizon: in s.
            active: which guards count.
        """
        if not self.size or not active.any() or horizon <= 0:
            return None
        search = _ZeroSearch(self, order, active)
        return search.scan(0, y, 0.0, horizon, climbing=True)


def _rate(block: np.ndarray) -> float:
    """The largest rate of a block; zero where its Taylor series ends."""
    if len(block) <= ORDERS and not np.tril(block).any():
        return 0.0
    with np.errstate(invalid="ignore"):
        return float(np.linalg.norm(scipy.linalg.matrix_balance(block, permute=False)[0], 2))


def _growth(block: np.ndarray) -> float:
    """The logarithmic norm."""
    return float(np.linalg.eigvalsh((block + block.T) / 2)[-1])


class _ZeroSearch:
    """One search for the first zero."""

    def __init__(self, flow: PhaseFlow, order: np.ndarray, active: np.ndarray):
        self.flow, self.order, self.active = flow, order, active
        self.moduli = np.abs(flow.rows)

    def scan(self, number: int, y: np.ndarray, begin: float, length: float, climbing: bool) -> Crossing | None:
        """Search [begin, begin + length] from the state at its begin, on wider panels where nothing is found and that is allowed."""
        flow, done = self.flow, 0.0
        while done < length:
            level = flow._level(number)
            h = level.width
            count = min(PANELS, int(np.ceil((length - done) / h * (1 - 4 * EPS))) or 1)
            Y = level.steps[:count] @ y
            found = self._batch(number, level, Y, begin + done, begin + length)
            if found is not None:
                return found
            done += count * h
            if done < length:
                y = level.steps[count] @ y
                if climbing and number + 1 < len(flow._widths):
                    number += 1
        return None

    def _batch(self, number: int, level: _Level, Y: np.ndarray, begin: float, end: float) -> Crossing | None:
        flow, p = self.flow, self.flow.size
        coefficients = (level.bernstein @ Y[:, level.slow].T).reshape(p, TERMS, len(Y))
        size = self.moduli @ np.abs(Y).T
        noise = NOISE * (size + np.abs(flow.values)[:, None]) / 8
        rest = level.fast @ np.abs(Y).T if number else np.zeros_like(noise)
        lowest = coefficients.min(axis=1) - flow.values[:, None]
        doubtful = (lowest <= noise + rest) & self.active[:, None]
        if begin == 0.0:
            doubtful[:, 0] |= (self.order > 0) & self.active
        for panel in np.flatnonzero(doubtful.any(axis=0)):
            own = np.flatnonzero(doubtful[:, panel])
            at = begin + panel * level.width
            if at >= end:
                return None
            if (rest[own, panel] > noise[own, panel]).any():
                found = self.scan(number - 1, Y[panel], at, min(level.width, end - at), climbing=False)
            else:
                found = self._in_panel(level, Y[panel], own, noise[:, panel], at, end)
            if found is not None:
                return found
        return None

    def _in_panel(
        self, level: _Level, y: np.ndarray, guards: np.ndarray, noise: np.ndarray, begin: float, end: float
    ) -> Crossing | None:
        """The first zero of some guards in one panel."""
        to, slow = _bernstein()[0], y[level.slow]
        best, grazing, shares, touching = np.inf, False, {}, []
        for guard in guards:
            taylor = level.taylor[guard] @ slow
            taylor[0] -= self.flow.values[guard]
            order = int(self.order[guard]) if begin == 0.0 else 0
            if order >= ORDERS:
                continue
            own = noise[guard]
            if order:  # divided by its zero at the begin
                taylor = np.append(taylor[order:], np.zeros(order))
                own = NOISE * float((np.abs(level.taylor[guard, order:]) @ np.abs(slow)).max(initial=0.0)) / 8
            share, touches = first_root(to @ taylor, taylor, own)
            if touches and share is not None:
                touching.append((share, guard))
            elif share is not None:
                shares[guard] = share
                best = min(best, share)
        for share, _ in touching:
            if share < best:
                best, grazing = share, True
        time = begin + best * level.width
        if not time <= end:
            return None
        state = self._state(level, y, best)
        if grazing:
            return Crossing(time, state, np.array([guard for share, guard in touching if share == best]), True)
        near = [guard for guard, share in shares.items() if (share - best) * level.width <= 4 * EPS * max(time, level.width * best)]
        return Crossing(time, state, np.array(near))

    def _state(self, level: _Level, y: np.ndarray, share: float) -> np.ndarray:
        time = share * level.width
        return self.flow.states(y, time)


def first_root(bernstein: np.ndarray, taylor: np.ndarray, noise: float) -> tuple[float | None, bool]:
    """The first zero in [0, 1] of a polynomial that is positive at first, and whether it only touches zero.

    Args:
        bernstein, taylor: its coefficients.
        noise: its values are known to this.

    Returns:
        The zero, None where there is none.
    """
    if bernstein.min() > noise:
        return None, False
    if bernstein[0] <= -noise:
        return 0.0, False
    _, left, right = _bernstein()
    waiting = [(bernstein, 0.0, 1.0)]
    touched: float | None = None
    while waiting:
        b, low, width = waiting.pop()
        if b.min() > noise:
            continue
        if b[0] > 0 and b[-1] < 0:
            signs = np.sign(b[b != 0])
            if np.count_nonzero(np.diff(signs)) == 1:
                return _refined(taylor, low, low + width), False
        if width <= NARROWEST:
            if b[-1] < -noise or b[0] - b[-1] > 4 * noise:  # it falls: a zero at the end of the panel
                return _refined(taylor, low, min(low + 2 * width, 1.0)), False
            touched = low + width / 2 if touched is None else touched
            continue
        half = width / 2
        waiting.append((right @ b, low + half, half))
        waiting.append((left @ b, low, half))
    return touched, touched is not None


def _refined(taylor: np.ndarray, low: float, high: float) -> float:
    """The zero at which the polynomial falls, in an interval with one change of sign, by Newton's method and bisection."""
    coefficients = taylor.tolist()[::-1]
    u = (low + high) / 2
    for _ in range(STEPS):
        value = slope = 0.0
        for c in coefficients:
            slope = slope * u + value
            value = value * u + c
        if value == 0:
            return u
        if value > 0:
            low = u
        else:
            high = u
        step = u - value / slope if slope < 0 else (low + high) / 2
        if not low < step < high:
            step = (low + high) / 2
        if abs(step - u) <= EPS * u / 2 or not low < step < high:
            return step if low <= step <= high else u
        u = step
    return u
