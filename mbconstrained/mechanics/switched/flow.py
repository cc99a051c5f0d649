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

#: Panels that are searched at once, at first and at most.
PANELS, MOST_PANELS = 16, 512

#: Rates on panels of the next width are less than the fastest by this factor or more.
LEVEL_RATIO = 6.0

#: Rounding errors of a value, relative to the sum of the moduli of its terms.
NOISE = 64 * EPS

#: Rounding errors of a time, relative to it.
TIME_NOISE = 4 * EPS

#: Derivatives that decide on the sign just after a zero.
ORDERS = TERMS - 1

#: Zeros at the begin up to this order are divided by; guards with others count as soon as they are more than rounding errors.
DIVIDED = 6

#: A zero is bisected until the panel is so narrow, relative to the first.
NARROWEST = 2.0**-26

#: A minimum belongs to a point that touches zero if it is so near.
NEAR = 2.0**-18

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
    """The first time at which guards vanish."""

    time: float  # in s, since the begin of the flow
    state: np.ndarray  # y there
    guards: np.ndarray  # their places; none where guards of unknown sign have become more than rounding errors
    grazing: bool = False  # whether the guard only touches zero


@dataclass(frozen=True, eq=False)
class _Level:
    """Panels of one width."""

    width: float  # h in s
    slow: np.ndarray  # the states that are expanded
    taylor: np.ndarray  # c J^k h^k / k! of guards on these states, shape (p, TERMS, m)
    bernstein: np.ndarray  # the coefficients in the Bernstein basis, shape (p TERMS, m)
    steps: np.ndarray  # e^{J j h}, j = 0 ... PANELS, shape (PANELS + 1, n, n)
    fast: np.ndarray  # bounds of the fast states' part by |y|, shape (p, n)


class PhaseFlow:
    """y(t) = e^{J t} y_0 by the blocks of J, up to a longest time in s, with guards g = c y - b by p rows c and values b."""

    def __init__(self, blocks: Sequence[np.ndarray], rows: np.ndarray, values: np.ndarray, longest: float):
        self.blocks, self.rows, self.values, self.longest = tuple(blocks), rows, values, longest
        self.size = len(rows)
        self.J = block_matrix(self.blocks)
        self.slices = block_slices(self.blocks)
        self.rates = np.array([_rate(block) for block in self.blocks])
        self.bounds = [_bound(block) for block in self.blocks]

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
        return widths if widths and widths[-1] * LEVEL_RATIO > self.longest else [*widths, self.longest]

    @cached_property
    def _levels(self) -> list[_Level | None]:
        return [None] * len(self._widths)

    def _level(self, number: int) -> _Level:
        if self._levels[number] is None:
            self._levels[number] = self._new_level(number)
        return self._levels[number]

    def _new_level(self, number: int) -> _Level:
        h, n = self._widths[number], len(self.J)
        slow = np.flatnonzero(self._rate_of_state * h <= REACH * (1 + EPS))
        part, power = self.J[np.ix_(slow, slow)] * h, self.rows[:, slow]
        taylor = np.empty((self.size, TERMS, len(slow)))
        for k in range(TERMS):
            taylor[:, k] = power
            power = power @ part / (k + 1)
        bernstein = np.einsum("jk,pkn->pjn", _bernstein()[0], taylor).reshape(self.size * TERMS, len(slow))
        units, times = np.tile(np.eye(n), PANELS + 1), np.repeat(h * np.arange(PANELS + 1), n)
        steps = block_states(self.blocks, units, times).reshape(n, PANELS + 1, n).transpose(1, 0, 2)
        fast = np.zeros((self.size, n))
        for at, bound, rate in zip(self.slices, self.bounds, self.rates):
            if rate * h > REACH * (1 + EPS):
                fast[:, at] = np.linalg.norm(self.rows[:, at], axis=1)[:, None] * _largest(bound, h)
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

    def sizes_of(self, rows: np.ndarray) -> np.ndarray:
        """Bounds of the terms of rows by the moduli of the states: errors turn within a block, but for polynomials."""
        sizes = np.abs(rows)
        for at, rate in zip(self.slices, self.rates):
            if rate:
                sizes[:, at] = np.linalg.norm(rows[:, at], axis=1)[:, None]
        return sizes

    # Signs at the begin.

    @cached_property
    def _derivatives(self) -> tuple[np.ndarray, np.ndarray]:
        """c J^k h^k / k!, shape (p, ORDERS, n), and bounds of their errors by those of y: the blocks of J have errors by their norms."""
        h, n = self._widths[0], len(self.J)
        rate = np.zeros((n, n))
        for at, own in zip(self.slices, self.rates):
            rate[at, at] = np.abs(self.J[at, at]) if not own else own * np.eye(at.stop - at.start)
        parts = np.empty((2, self.size, ORDERS, n))
        for part, power, matrix in zip(parts, (self.rows, self.sizes_of(self.rows)), (self.J * h, rate * h)):
            for k in range(ORDERS):
                part[:, k] = power
                power = power @ matrix / (k + 1)
        return parts[0], parts[1]

    def orders(self, y: np.ndarray, size: np.ndarray, known: np.ndarray, time: float) -> tuple[np.ndarray, np.ndarray]:
        """The order of the zero of each guard at the begin, 0 where it does not vanish, and its sign just after it.

        The state y has rounding errors of a size relative to NOISE, the time of the begin has one, too. So many derivatives of each guard,
        its value among them, are known to vanish, whatever their rounding error. Where none decides the order is ORDERS, the sign 0.
        """
        if not self.size:
            return np.zeros(0, int), np.zeros(0)
        rows, moduli = self._derivatives
        values, noise = rows @ y, NOISE * (moduli @ size)
        values[:, 0] -= self.values
        noise[:, 0] += NOISE * np.abs(self.values)
        noise[:, :-1] += TIME_NOISE * time / self._widths[0] * np.arange(1, ORDERS) * np.abs(values[:, 1:])
        counts = (np.abs(values) > noise) & (np.arange(ORDERS) >= known[:, None])
        order = np.where(counts.any(axis=1), counts.argmax(axis=1), ORDERS)
        sign = np.where(order < ORDERS, np.sign(values[np.arange(self.size), np.minimum(order, ORDERS - 1)]), 0.0)
        return order, sign

    # The first zero.

    def first_crossing(
        self, y: np.ndarray, size: np.ndarray, order: np.ndarray, sign: np.ndarray, horizon: float
    ) -> Crossing | None:
        """The first time in (0, horizon] at which a guard that is positive just after the begin falls to zero.

        Guards without sign are followed, too, until they are more than rounding errors: there the search ends, without a guard. Negative
        ones are left out. State, size, orders and signs are as of ``orders``.
        """
        if not self.size or not (sign >= 0).any() or horizon <= 0:
            return None
        search = _ZeroSearch(self, order, sign, NOISE * (np.abs(self.rows) @ size))
        return search.scan(y, horizon)


def _rate(block: np.ndarray) -> float:
    """The largest rate of a block; zero where its Taylor series ends."""
    if len(block) <= TERMS and not np.tril(block).any():
        return 0.0
    with np.errstate(invalid="ignore"):
        return float(np.linalg.norm(scipy.linalg.matrix_balance(block, permute=False)[0], 2))


def _bound(block: np.ndarray) -> tuple[float, float]:
    """c and a with |e^{J t}| <= c e^{a t}: for two states by the norm in which a spiral is a circle, else by the logarithmic norm."""
    if len(block) == 2 and block[0, 0] == block[1, 1] and block[0, 1] * block[1, 0] < 0:
        ratio = abs(block[0, 1] / block[1, 0])
        return max(ratio, 1 / ratio) ** 0.5, float(block[0, 0])
    return 1.0, float(np.linalg.eigvalsh((block + block.T) / 2)[-1])


def _largest(bound: tuple[float, float], time: float) -> float:
    """The bound over a time."""
    return bound[0] * exp(min(max(bound[1], 0.0) * time, 700.0))


class _ZeroSearch:
    """One search for the first zero."""

    def __init__(self, flow: PhaseFlow, order: np.ndarray, sign: np.ndarray, least: np.ndarray):
        self.flow, self.order, self.active = flow, order, (sign > 0) & (order <= DIVIDED)
        self.undecided = (sign >= 0) & ~self.active
        self.moduli = np.abs(flow.rows)
        #: Guards without sign have one once they are larger.
        self.least = 2 * (least + NOISE * np.abs(flow.values))

    def can_vanish(self, y: np.ndarray, time: float) -> bool:
        """Whether bounds of the states allow that a guard vanishes within a time, or gets a sign."""
        flow = self.flow
        constant, varying = -flow.values, np.zeros(flow.size)
        for at, block, bound, rate in zip(flow.slices, flow.blocks, flow.bounds, flow.rates):
            rows = flow.rows[:, at]
            if len(block) == 1 and not rate:
                constant = constant + rows @ y[at]
            elif rate:
                varying += np.linalg.norm(rows, axis=1) * np.linalg.norm(y[at]) * _largest(bound, time)
            else:  # polynomials
                varying[rows.any(axis=1) & y[at].any()] = np.inf
        noise = NOISE * (self.moduli @ np.abs(y) + np.abs(flow.values))
        lasts = np.where(self.undecided, np.abs(constant) + varying <= self.least, constant - (1 + NOISE) * varying > noise)
        return bool((~lasts & (self.active | self.undecided)).any())

    def scan(self, y: np.ndarray, horizon: float) -> Crossing | None:
        """Search [0, horizon] on panels that are wider where nothing is found and narrower where fast states decide."""
        flow, number, done, most, highest = self.flow, 0, 0.0, PANELS, len(self.flow._widths) - 1
        while done < horizon:
            level = flow._level(number)
            h = level.width
            count = min(most, int(np.ceil((horizon - done) / h * (1 - 4 * EPS))) or 1)
            Y = level.steps[: min(count, PANELS)] @ y
            while len(Y) < count:
                Y = np.vstack([Y, Y[-PANELS:][: count - len(Y)] @ level.steps[PANELS].T])
            crossing, divided = self._batch(number, level, Y, done, horizon)
            if crossing is not None:
                return crossing
            if divided is not None:
                number, most = number - 1, PANELS if divided else min(2 * most, MOST_PANELS)
                y, done = Y[divided], done + divided * h
                continue
            first, done = not done, done + count * h
            if done < horizon:
                y = level.steps[1] @ Y[-1]
                if first and not self.can_vanish(y, horizon - done):
                    return None
                number, most = (number, min(2 * most, MOST_PANELS)) if number == highest else (number + 1, most)
        return None

    def _batch(self, number: int, level: _Level, Y: np.ndarray, begin: float, end: float) -> tuple[Crossing | None, int | None]:
        """The first zero in some panels, and the panel that is to be divided; None without."""
        flow, p = self.flow, self.flow.size
        coefficients = (level.bernstein @ Y[:, level.slow].T).reshape(p, TERMS, len(Y))
        size = self.moduli @ np.abs(Y).T
        noise = NOISE * (size + np.abs(flow.values)[:, None]) / 8
        rest = level.fast @ np.abs(Y).T if number else np.zeros_like(noise)
        values = flow.values[:, None]
        doubtful = (coefficients.min(axis=1) - values <= noise + rest) & self.active[:, None]
        if begin == 0.0:
            doubtful[:, 0] |= (self.order > 0) & self.active
        if self.undecided.any():
            largest = np.maximum(coefficients.max(axis=1) - values, values - coefficients.min(axis=1))
            doubtful |= (largest + rest > np.maximum(self.least[:, None], 16 * noise)) & self.undecided[:, None]
        for panel in np.flatnonzero(doubtful.any(axis=0)):
            own = np.flatnonzero(doubtful[:, panel])
            at = begin + panel * level.width
            if at >= end:
                break
            if (rest[own, panel] > noise[own, panel]).any():
                return None, int(panel)
            crossing = self._in_panel(level, Y[panel], own, noise[:, panel], at, end)
            if crossing is not None:
                return crossing, None
        return None, None

    def _in_panel(
        self, level: _Level, y: np.ndarray, guards: np.ndarray, noise: np.ndarray, begin: float, end: float
    ) -> Crossing | None:
        """The first zero of some guards in one panel."""
        to, slow = _bernstein()[0], y[level.slow]
        shares, touching, decided = {}, {}, {}
        for guard in guards:
            taylor = level.taylor[guard] @ slow
            taylor[0] -= self.flow.values[guard]
            if self.undecided[guard]:
                share = first_excess(taylor, max(self.least[guard], 16 * noise[guard]))
                if share is not None:
                    decided[guard] = share
                continue
            order = int(self.order[guard]) if begin == 0.0 else 0
            own = noise[guard]
            if order:  # divided by its zero at the begin
                taylor = np.append(taylor[order:], np.zeros(order))
                own = NOISE * float((np.abs(level.taylor[guard, order:]) @ np.abs(slow)).max(initial=0.0)) / 8
            share, touches = first_root(to @ taylor, taylor, own)
            if share is not None:
                (touching if touches else shares)[guard] = share
        best, kind = min(((min(part.values(), default=np.inf), name) for name, part in enumerate((shares, touching, decided))))
        time = begin + best * level.width
        if not time <= end:
            return None
        state = self.flow.states(y, best * level.width)
        if kind == 2:
            return Crossing(time, state, np.zeros(0, int))
        if kind == 1:
            return Crossing(time, state, np.array([guard for guard, share in touching.items() if share == best]), True)
        near = [guard for guard, share in shares.items() if (share - best) * level.width <= 4 * EPS * max(time, level.width * best)]
        return Crossing(time, state, np.array(near))


def first_excess(taylor: np.ndarray, size: float) -> float | None:
    """The first of some points in [0, 1] at which the modulus of a polynomial is above a size, None where there is none."""
    shares = np.linspace(0.0, 1.0, 4 * TERMS + 1)
    significant = np.flatnonzero(np.abs(np.polynomial.polynomial.polyval(shares, taylor)) > size)
    return float(shares[significant[0]]) if len(significant) else None


def first_root(bernstein: np.ndarray, taylor: np.ndarray, noise: float) -> tuple[float | None, bool]:
    """The first zero in [0, 1] of a polynomial that is positive at first and known up to a noise, if any; and whether it only touches zero."""
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
        if width <= NARROWEST or np.abs(b).max() <= noise:
            if b[-1] < -noise or b[0] - b[-1] > 4 * noise:  # it falls: a zero at the end of the panel
                return _refined(taylor, low, min(low + 2 * width, 1.0)), False
            touched = low + width / 2 if touched is None else touched
            continue
        half = width / 2
        waiting.append((right @ b, low + half, half))
        waiting.append((left @ b, low, half))
    return (None, False) if touched is None else (_lowest(taylor, touched), True)


def _lowest(taylor: np.ndarray, share: float) -> float:
    """The place of the minimum near a point at which a polynomial touches zero, by Newton's method; the point where there is none near."""
    slope, bend = (np.polynomial.polynomial.polyder(taylor, order) for order in (1, 2))
    best = share
    for _ in range(STEPS):
        own = float(np.polynomial.polynomial.polyval(best, bend))
        step = float(np.polynomial.polynomial.polyval(best, slope)) / own if own > 0 else 0.0
        if not abs(best - step - share) <= NEAR:
            return share
        best -= step
        if abs(step) <= EPS * best:
            break
    return min(max(best, 0.0), 1.0)


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
