"""Shock response spectra: the largest answers of oscillators to a motion of their support."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from ..ground.by_name import answering
from ..ground.checks import check_known, counted, optional_package, real_array, real_number
from ..ground.display import Pictured
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS, STEP_AGREEMENT
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.solve import solve
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ExactRecord, ImpulsiveSmooth
from .extrema import extrema, falling_root

# Response of an oscillator to a record: y'' + 2 z w y' + w^2 y = a(t), a linear between samples, exact at all times.
# In the triangular form u' = l1 u + a, y' = l2 y + u, with l1, l2 = -z w +- sqrt(z^2 - 1) w, every damping ratio is treated alike: at critical damping
# the divided difference (e^{l1 h} - e^{l2 h}) / (l1 - l2) in the exponential of the step is h e^{l h}. Each recursion is a digital filter of first
# order. Source: the ramp-invariant filter of Smallwood, Shock and Vibration Bulletin 51 (1981), here without its coefficients of second order.

#: Steps that differ by so many units in the last place of the last time are equal.
EQUAL = 8.0

#: So many steps of equal length are one product of matrices, and the ends of so many blocks another one.
BLOCK, GROUP = 32, 64

#: So many intervals of an oscillator are searched at once, those with the highest bounds first; then twice as many each time, up to the
#: most. Oscillators are searched together once they have so many intervals.
TOGETHER, MOST_TOGETHER, ALL_TOGETHER = 64, 4096, 1 << 17

#: Up to this damping ratio the conjugate roots are so far from each other that u alone has y.
LIGHT = 0.9

#: Intervals of more radians than LONG are searched at their ends: see ``_ends``. The free motion has decayed after so many time constants.
LONG, DECAYED = 100.0, 40.0

#: Steps of more radians have their exponentials in closed form, in which nothing cancels then.
CLOSED = 20.0

#: Roots that are closer, in units of w, are treated as those of critical damping.
CLOSE = 0.1

#: Up to this damping ratio the extrema of successive cycles are ordered.
ORDERED = 0.35

#: Steps shorter than this, in units of the fastest rate, take Taylor's series, after the slope of so many terms at most: 1 / 20! is below
#: rounding error.
SHORT, DEGREE = 1.0, 20


def _taylor(derivatives: list, tau) -> np.ndarray:
    """sum of derivatives[k] tau^k / k! by Horner's rule."""
    total = np.zeros(np.broadcast(derivatives[0], tau).shape)
    for k in range(len(derivatives) - 1, -1, -1):
        total = derivatives[k] + total * tau / (k + 1)
    return total


class ShockRecord:
    """Samples, with what all oscillators share."""

    def __init__(self, times: np.ndarray, values: np.ndarray):
        """Create the record from its samples (N,)."""
        self.times, self.values, self.h = times, values, np.diff(times)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.slopes = np.where(self.h > 0, np.diff(values) / self.h, 0.0)  # 0 where the record jumps
        # The largest moduli, and the length of all intervals, None where they differ.
        self.longest, self.load, self.steepest = (np.abs(one).max(initial=0.0) for one in (self.h, values, self.slopes))
        is_even = len(self.h) > 0 and np.ptp(self.h) <= EQUAL * EPS * np.abs(times).max() and self.h[0] > 0
        self.step = (times[-1] - times[0]) / len(self.h) if is_even else None

    @cached_property
    def blocks(self) -> np.ndarray:
        """The values of ``BLOCK`` intervals with both ends, and two columns for the start of the filter, shape (number, BLOCK + 3)."""
        count = -(-len(self.h) // BLOCK)
        padded = np.pad(self.values, (0, count * BLOCK + 1 - len(self.values)))
        return np.column_stack([padded[:-1].reshape(count, BLOCK), padded[BLOCK::BLOCK], np.zeros((count, 2))])

    @property
    def room(self) -> np.ndarray:
        """Room for two functions at the samples, and at those that fill the last block, shape (2, N or more)."""
        return np.zeros((2, len(self.blocks) * BLOCK + 1))

    def filtered(self, rate: complex, constant: complex, rising: complex, shares: np.ndarray, room: np.ndarray) -> np.ndarray:
        """Sums shares @ (Re z, Im z) of z_(k+1) = e^(rate step) z_k + constant a_k + rising (a_(k+1) - a_k), z_0 = 0, in the room for them.

        Blocks are products of matrices, and so are their starts.
        """
        powers = np.exp(rate * self.step * np.arange(BLOCK + 1))
        # A sample adds rising at its own time, and from the next one on:
        later = (constant - rising + powers[1] * rising) * powers[:-2]
        gains = np.vstack([(constant - rising) * powers[:-1], _toeplitz(np.append(rising, later)), powers[1:]])
        inputs = self.blocks
        inputs[:, -2:] = _accumulated(rate * self.step * BLOCK, inputs[:, :-2] @ gains[:-1, [-1]].view(float)).view(float)
        for own, (real, imaginary) in zip(room, shares):
            part = complex(real, -imaginary) * gains
            np.matmul(inputs, np.vstack([part.real, -part.imag[-1:]]), out=own[1:].reshape(len(inputs), BLOCK))
        return room[:, : len(self.values)]


def _toeplitz(row: np.ndarray) -> np.ndarray:
    """The upper triangle with this first row and equal entries on each diagonal."""
    places = np.arange(len(row))
    return np.triu(row[places - places[:, None]])


def _accumulated(rate: complex, ends: np.ndarray) -> np.ndarray:
    """z_(k+1) = e^rate z_k + e_k, z_0 = 0, of complex e as real and imaginary parts (K, 2): all z but the last, shape (K, 1)."""
    count = -(-len(ends) // GROUP)
    groups = np.zeros((count, GROUP), dtype=complex)
    groups.view(float).reshape(-1, 2)[: len(ends)] = ends
    powers = np.exp(rate * np.arange(GROUP + 1))
    within = groups @ _toeplitz(powers[:-1])
    starts = itertools.accumulate(within[:-1, -1].tolist(), lambda z, end: powers[-1] * z + end, initial=0j)
    states = np.multiply.outer(np.array(list(starts)), powers[:-1])
    states[:, 1:] += within[:, :-1]
    return states.reshape(-1, 1)[: len(ends)]


def _phi(order: int, x: np.ndarray) -> np.ndarray:
    """phi_1 = (e^x - 1) / x or phi_2 = (e^x - 1 - x) / x^2 for x <= 0."""
    near = _taylor([1 / math.perm(k + order, order) for k in range(DEGREE)], np.where(np.abs(x) < 1, x, 0.0))
    far = np.where(np.abs(x) < 1, -1.0, x)
    value = np.expm1(far) / far if order == 1 else (np.expm1(far) - far) / far**2
    return np.where(np.abs(x) < 1, near, value)


@dataclass(frozen=True)
class Oscillator:
    """y'' + 2 z w y' + w^2 y = a."""

    w: Any  # natural angular frequency in rad/s; of several oscillators an array
    zeta: float  # damping ratio

    def __getitem__(self, places) -> Oscillator:
        """Some of several oscillators."""
        return Oscillator(self.w[places], self.zeta)

    @property
    def roots(self) -> tuple[Any, Any]:
        """l1 and l2, without cancellation for heavy damping; of two real ones l2 is the slower."""
        w, z = self.w, self.zeta
        if z <= 1:
            l1 = complex(-z, np.sqrt((1 - z) * (1 + z))) * w
            return l1, l1.conjugate()
        fast = -(z + np.sqrt((z - 1) * (z + 1))) * w
        return fast + 0j, w**2 / fast + 0j

    def steps(self, h: np.ndarray) -> np.ndarray:
        """The exponentials of steps h of (y, u, a, a'), complex, shape (H, 4, 4); of several oscillators one each."""
        unit, radians = Oscillator(1.0, self.zeta), np.atleast_1d(h * self.w)
        units = np.power.outer(self.w * np.ones(len(radians)), np.arange(4.0))  # y w^2, u w, a, a' / w have one size
        l1, l2 = unit.roots
        J = np.array([[l2, 1, 0, 0], [0, l1, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]], dtype=complex)
        is_long, close = radians > CLOSED, abs(l1 - l2) < CLOSE
        if close:  # SciPy takes differences of the diagonal of a triangle: (y, y', a, a') has none
            J = np.array([[0, 1, 0, 0], [-1, -2 * self.zeta, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]], dtype=float)
        result = scipy.linalg.expm(np.multiply.outer(np.where(is_long, 0.0, radians), J)).astype(complex)
        if close:
            change = np.eye(4, dtype=complex)
            change[1, 0] = -l2
            result = change @ result @ (2 * np.eye(4) - change)
            result[:, 1, 0] = 0.0  # u' = l1 u + a is without y: what the change of variables leaves there is rounding error
        if is_long.any():
            result[is_long] = unit._long_steps(radians[is_long])
        return result * units[:, :, None] / units[:, None, :]

    def _long_steps(self, h: np.ndarray) -> np.ndarray:
        """Exponentials of long steps in closed form: squaring loses the phase, SciPy's recurrence loses values near underflow."""
        l1, l2 = self.roots
        e1, e2, result = np.exp(l1 * h), np.exp(l2 * h), np.tile(np.eye(4, dtype=complex), (len(h), 1, 1))
        gap = l1 - l2
        x = gap * h / 2  # (e^(l1 h) - e^(l2 h)) / (l1 - l2) = h e^((l1 + l2) h / 2) sinh(x) / x
        series = 1 + x**2 / 6 * (1 + x**2 / 20 * (1 + x**2 / 42 * (1 + x**2 / 72)))
        mixed = h * np.exp((l1 + l2) / 2 * h) * series if abs(gap) * np.max(h) < CLOSE else (e1 - e2) / gap if gap else h * e1
        more = (mixed - e1 / l1) / l2  # (e1 / l1 - e2 / l2) / (l1 - l2)
        result[:, 0, 0], result[:, 1, 1], result[:, 0, 1], result[:, 2, 3] = e2, e1, mixed, h
        result[:, 1, 2], result[:, 1, 3] = (e1 - 1) / l1, (e1 - 1 - l1 * h) / l1**2
        result[:, 0, 2] = (mixed - (e2 - 1) / l2) / l1
        result[:, 0, 3] = (1 / (l1 * l2) + more - ((e2 - 1) / l2 - h) / l2) / l1
        return result

    def under(self, signal: ImpulsiveSmooth, output) -> tuple[BohlFunction, float, tuple[float, float]]:
        """c_0 y + c_1 y' under a signal that is zero after its last knot, that time, and y and y' then."""
        end, (c0, c1) = signal_end(signal), output
        y = solve(PolynomialMatrix([[[self.w**2]], [[2 * self.zeta * self.w]], [[1.0]]]), force=signal)
        last = float(y(end)[0]), float(y.derivative(1)(end)[0])
        return y.function.differential(np.array([[c0]]), np.array([[c1]])), end, last

    def states(self, record: ShockRecord) -> tuple[np.ndarray, np.ndarray]:
        """y and y' at the samples, from rest before the first."""
        y, v = self.combinations(record, np.eye(2))
        return y, v

    def combinations(self, record: ShockRecord, weights: np.ndarray, step=None, room: np.ndarray | None = None) -> np.ndarray:
        """Two sums weights @ (y, y') at the samples, shape (2, N); those of an even record, whose exponential may be given, in the room for them."""
        if record.step is None or self.zeta > LIGHT:
            return weights @ self._states(record)
        l1, E = self.roots[0], self.steps(np.array([record.step]))[0] if step is None else step
        shares = np.array([[0.0, 1 / l1.imag], [1.0, l1.real / l1.imag]])  # u = (d/dt - l2) y with l2 the conjugate of l1
        return record.filtered(l1, E[1, 2], E[1, 3] / record.step, weights @ shares, record.room if room is None else room)

    def _states(self, record: ShockRecord) -> np.ndarray:
        (l1, l2), h, values = self.roots, record.h, record.values
        if record.step is not None:
            E = self.steps(np.array([record.step]))[0]
            real, imaginary = record.filtered(l1, E[1, 2], E[1, 3] / record.step, np.eye(2), record.room)
            from scipy.signal import lfilter  # scipy.signal takes a second to import

            u, y = real + 1j * imaginary, np.zeros(len(values), dtype=complex)
            y[1:] = lfilter(
                [1.0], [1.0, -E[0, 0]], E[0, 2] * values[:-1] + E[0, 3] / record.step * np.diff(values) + E[0, 1] * u[:-1]
            )
        else:
            own, where = np.unique(h, return_inverse=True)
            E = self.steps(own)[where]
            from_u = E[:, 1, 2] * values[:-1] + E[:, 1, 3] * record.slopes
            from_y = E[:, 0, 2] * values[:-1] + E[:, 0, 3] * record.slopes
            decay, keep, mix = E[:, 1, 1].tolist(), E[:, 0, 0].tolist(), E[:, 0, 1].tolist()
            now_y, now_u, ys, us = 0j, 0j, [0j], [0j]
            for p, q, r, a, b in zip(decay, keep, mix, from_u.tolist(), from_y.tolist()):
                now_y, now_u = q * now_y + r * now_u + b, p * now_u + a
                ys.append(now_y)
                us.append(now_u)
            y, u = np.array(ys), np.array(us)
        return np.array([y.real, (l2 * y + u).real])

    def inside(self, y, v, a, slope, tau) -> tuple[np.ndarray, np.ndarray]:
        """y and y' at times tau after samples with y, v = y', a and the slope of a; all of shape (K,) or broadcast to it."""
        w, z = self.w, self.zeta
        x = float(np.max(tau * w, initial=0.0)) * (1 + 2 * z)
        if x < SHORT:  # Taylor's series, in which no particular solution cancels
            degree = 3 + next(
                n for n in range(2, DEGREE + 1) if x**n * math.factorial(DEGREE) <= math.factorial(n)
            )  # a slope begins at t^3
            terms = [y, v, a - 2 * z * w * v - w**2 * y]
            terms.append(slope - 2 * z * w * terms[2] - w**2 * v)
            while len(terms) < degree:
                terms.append(-2 * z * w * terms[-1] - w**2 * terms[-2])
            return _taylor(terms, tau), _taylor(terms[1:], tau)
        if z >= 1:  # u' = l1 u + a with the fast root first: its particular solution does not cancel
            l1, l2 = (root.real for root in self.roots)
            k, start = -slope / l1, -a / l1 - slope / l1**2
            rest = v - l2 * y - start
            u = start + k * tau + rest * np.exp(l1 * tau)
            moved = (
                np.exp(l2 * tau) * y + tau * _phi(1, l2 * tau) * start + tau**2 * _phi(2, l2 * tau) * k + rest * self._mixed(tau)
            )
            return moved, l2 * moved + u
        # y = p + s tau + g(tau), the free motion g from y - p, v - s.
        s = slope / w**2
        p = a / w**2 - 2 * z * s / w
        position, rate = self.free(y - p, v - s, tau)
        return p + s * tau + position, s + rate

    def free(self, y, v, tau) -> tuple[np.ndarray, np.ndarray]:
        """Free motion from y and v."""
        w, z = self.w, self.zeta
        l1, l2 = self.roots
        if z < 1:
            wd = l1.imag
            decay, cosine, sine = np.exp(-z * w * tau), np.cos(wd * tau), tau * np.sinc(wd * tau / np.pi)
            return decay * (y * cosine + (v + z * w * y) * sine), decay * (v * cosine - (w**2 * y + z * w * v) * sine)
        first, mixed = np.exp(l2.real * tau), self._mixed(tau)
        rate = v - l2.real * y
        return y * first + rate * mixed, l2.real * y * first + rate * (l1.real * mixed + first)

    def _mixed(self, tau) -> np.ndarray:
        """(e^{l2 tau} - e^{l1 tau}) / (l2 - l1) of real roots."""
        l1, l2 = (root.real for root in self.roots)
        first, gap = np.exp(l2 * tau), l2 - l1
        return first * -np.expm1(-gap * tau) / gap if self.zeta > 1 else tau * first

    def peaks(self, record: ShockRecord, output) -> np.ndarray:
        """max and min of c_0 y + c_1 y' during the record, and after it, shape (4,); of F oscillators (4, F)."""
        each = Oscillator(np.atleast_1d(self.w), self.zeta)
        outputs = np.array([np.broadcast_to(one, each.w.shape) for one in output])
        best, last = np.zeros((len(each.w), 2)), np.zeros((2, len(each.w)))  # the largest known r and -r, and the last y and y'
        is_even, waiting = record.step is not None, []
        room, steps = (record.room, each.steps(record.step)) if is_even else (None, [None] * len(each.w))
        for place, w in enumerate(each.w.tolist()):
            c0, c1 = outputs[:, place].tolist()
            weights = np.array([[c0, c1], [0.0, 1.0] if c0 else [1.0, 0.0]])  # r, and what is not in it
            own, back = Oscillator(w, self.zeta), np.linalg.inv(weights)
            both = own.combinations(record, weights, steps[place], room)
            last[:, place] = back @ both[:, -1]
            waiting += own._candidates(record, both, back, (c0, c1), best[place], 2 * place)
            if sum(map(len, waiting)) > ALL_TOGETHER:
                each._search(waiting, outputs, best)
                waiting = []
        each._search(waiting, outputs, best)
        high, low = best.T
        return np.array([high, -low, *each.residual(last[0], last[1], outputs)]).reshape(4, *np.shape(self.w))

    def _candidates(
        self, record: ShockRecord, both: np.ndarray, back: np.ndarray, output, best: np.ndarray, which: int
    ) -> list[_Intervals]:
        """The intervals in which r = c_0 y + c_1 y' or -r may exceed its largest sample, which is put into ``best``.

        y and y' are back @ both, the first of which is r.
        """
        (c0, c1), r = output, both[0]
        largest, least = both.max(axis=1), both.min(axis=1)
        best[:] = max(largest[0], 0.0), max(-least[0], 0.0)
        # A bound of the free motions in all intervals, by their energy; a curve leaves its chord by an eighth of its curvature times h^2.
        whole = (abs(c0) + abs(c1) * self.w) * (1 + 2 * self.zeta) ** 2
        speed, load = record.steepest / self.w**2, record.load / self.w**2
        far, fast = np.abs(back) @ np.maximum(largest, -least)
        most = whole * (far + load + fast / self.w + (1 + 2 * self.zeta) * speed / self.w)
        bend, result = most * min(2.0, (self.w * record.longest) ** 2 / 8), []
        for place, sign in enumerate((1.0, -1.0)):
            near = r > best[place] - bend if sign > 0 else r < bend - best[place]
            chosen = np.flatnonzero(near[:-1] | near[1:])  # an end of each interval may exceed the best
            (y, v), a, slope, h = back @ both[:, chosen], record.values[chosen], record.slopes[chosen], record.h[chosen]
            limit = self._limits(y, v, a, slope, h, np.maximum(sign * r[chosen], sign * r[chosen + 1]), (sign * c0, sign * c1))
            result.append(_Intervals(np.full(len(h), which + place), y, v, a, slope, h, limit)[limit > best[place]])
        return result

    def _search(self, waiting: Sequence[_Intervals], outputs: np.ndarray, best: np.ndarray) -> None:
        """Raise the largest values of r and of -r to those inside intervals, of each oscillator those with the highest limits first."""
        if not waiting:
            return
        every, highest = _Intervals(*map(np.concatenate, zip(*(vars(one).values() for one in waiting)))), best.reshape(-1)
        every = every[np.lexsort((-every.limit, every.which))]
        oscillators, signed = self[every.which // 2], outputs[:, every.which // 2] * np.where(every.which % 2, -1.0, 1.0)
        radians = every.h * oscillators.w
        is_short, is_long = radians * (1 + 2 * self.zeta) < SHORT, (radians > LONG) & (self.zeta < 1)
        left, limit, together = np.arange(len(every)), every.limit.copy(), TOGETHER
        while len(left := left[limit[left] > highest[every.which[left]]]):
            now = left[np.arange(len(left)) - np.searchsorted(every.which[left], every.which[left]) < together]
            for kind in (is_short, ~is_short & ~is_long, is_long):
                if len(at := now[kind[now]]):
                    own, one = oscillators[at], every[at]
                    for motion in own._ends(*one.motion) if kind is is_long else (one.motion,):
                        own._raise(*motion, signed[:, at], highest, one.which)
            limit[now], together = -np.inf, min(2 * together, MOST_TOGETHER)

    def _rates(self, y, v, a, slope, output) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """The second and third derivative of y, and the first three of r = c_0 y + c_1 y', at one time."""
        w, z = self.w, self.zeta
        c0, c1 = output
        bend = a - 2 * z * w * v - w**2 * y
        twist = slope - 2 * z * w * bend - w**2 * v
        return bend, twist, c0 * v + c1 * bend, c0 * bend + c1 * twist, c0 * twist - c1 * (2 * z * w * twist + w**2 * bend)

    def _most(self, g, rate) -> np.ndarray:
        """A bound of |g| of free motions from g and g': by their energy, of real roots also by both ends of g e^{-l2 t}."""
        most = np.hypot(g, rate / self.w)
        if self.zeta <= 1:
            return most
        l1, l2 = (root.real for root in self.roots)
        return np.minimum(most, np.maximum(np.abs(g), np.abs((rate - l1 * g) / (l2 - l1))))

    def _limits(self, y, v, a, slope, h, highest, output) -> np.ndarray:
        """Bounds of r = c_0 y + c_1 y' inside intervals: r'' is a free motion, and so is r without a straight line."""
        c0, c1 = output
        _, _, rate, curve, turn = self._rates(y, v, a, slope, output)
        s = slope / self.w**2
        start = c0 * (a / self.w**2 - 2 * self.zeta * s / self.w) + c1 * s
        line = start + np.maximum(c0 * s * h, 0.0) + self._most(c0 * y + c1 * v - start, rate - c0 * s)
        return np.minimum(line, highest + self._most(curve, turn) * h**2 / 8)

    def _ends(self, y, v, a, slope, h) -> list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]]:
        """The parts of long intervals that have their extrema, as y, v, a, slope and length; zeta < 1.

        r = p + s tau + g, g a damped cosine. At a maximum r' = 0 >= r'', so that g >= 2 z s / w. From cycle to cycle s tau is even and a positive g
        convex: the largest of the values a cycle apart is the first or the last. A negative g, with s < 0, is smaller than what s tau gains one
        cycle before, while 2 z (e^{2 pi z / sqrt(1 - z^2)} - 1) < 2 pi / sqrt(1 - z^2), which holds up to z = 0.35. With more damping, only
        the line is left after some cycles.
        """
        length = DECAYED / -self.roots[1].real if self.zeta > ORDERED else 2 * np.pi / self.roots[0].imag
        length = np.minimum(length * (1 + STEP_AGREEMENT), h)
        late = h - length
        y_late, v_late = self.inside(y, v, a, slope, late)
        return [(y, v, a, slope, length), (y_late, v_late, a + slope * late, slope, length)]

    def _zero(self, g, rate) -> np.ndarray:
        """The first nonnegative time at which a free motion from g and g' is zero; infinity without one."""
        l1, l2 = self.roots
        with np.errstate(divide="ignore", invalid="ignore"):
            if self.zeta < 1:
                return np.arctan2(-g * l1.imag, rate + self.zeta * self.w * g) % np.pi / l1.imag
            share, gap = -g / (rate - l2.real * g), (l2 - l1).real
            return np.where((share >= 0) & (gap * share < 1), -np.log1p(-gap * share) / gap if self.zeta > 1 else share, np.inf)

    def _raise(self, y, v, a, slope, h, output, highest: np.ndarray, which: np.ndarray) -> None:
        """Raise the highest known values to those of r = c_0 y + c_1 y' inside these intervals.

        The curvature r'' is a free motion, whose zeros are known. Between them r' is monotone: r has one maximum at most there, where r' falls from
        positive to negative, and lies below the tangents at both ends.
        """
        c0, c1 = output
        bend, twist, _, *curvature = self._rates(y, v, a, slope, output)
        zero, more = self._zero(*curvature)[:, None], np.zeros((len(h), 1))
        if self.zeta < 1:
            half = np.pi / self.roots[0].imag
            more = half[:, None] * np.arange(np.ceil((h / half).max()))
        grid = np.minimum(np.hstack([np.zeros((len(h), 1)), zero + more, h[:, None]]), h[:, None])

        def curve(row, tau):
            """r and r'; y'' is a free motion as well."""
            now_y, now_v = self[row].inside(y[row], v[row], a[row], slope[row], tau)
            now_bend = self[row].free(bend[row], twist[row], tau)[0] if c1.any() else 0.0
            return c0[row] * now_y + c1[row] * now_v, c0[row] * now_v + c1[row] * now_bend

        values, rates = curve(np.arange(len(h))[:, None], grid)
        np.maximum.at(highest, which, values.max(axis=1))
        length, best = np.diff(grid, axis=1), highest[which][:, None]
        reach = np.minimum(values[:, :-1] + rates[:, :-1] * length, values[:, 1:] - rates[:, 1:] * length)
        row, place = np.nonzero((rates[:, :-1] > 0) & (rates[:, 1:] < 0) & (reach > best))
        if not len(row):
            return
        top = falling_root(
            lambda tau: curve(row, tau)[1],
            grid[row, place],
            grid[row, place + 1],
            rates[row, place],
            rates[row, place + 1],
            lambda now, width: (np.abs(now) * width <= EPS * best[row, 0]).all(),  # no more is left to gain
        )
        np.maximum.at(highest, which[row], curve(row, top)[0])

    def residual(self, y, v, output) -> tuple[np.ndarray, np.ndarray]:
        """The extrema of the free motion after the record: at its start or where its rate is zero, the first two times."""
        c0, c1 = output
        first = self._zero(*self._rates(np.asarray(y, dtype=float), v, 0.0, 0.0, output)[2:4])
        start = np.zeros(np.shape(first))
        times = np.array([start, first, first + np.pi / self.roots[0].imag if self.zeta < 1 else start])
        later_y, later_v = self.free(y, v, np.where(np.isfinite(times), times, 0.0))
        values = c0 * later_y + c1 * later_v
        return np.maximum(values.max(axis=0), 0.0), np.minimum(values.min(axis=0), 0.0)


@dataclass(frozen=True, eq=False)
class _Intervals:
    """Intervals of a record with the motions of oscillators at their starts, y, v = y', the value a of the record and its slope."""

    which: np.ndarray  # twice the place of the oscillator, and one more for the opposite of its function, shape (K,) as all others
    y: np.ndarray
    v: np.ndarray
    a: np.ndarray
    slope: np.ndarray
    h: np.ndarray  # length of the intervals
    limit: np.ndarray  # bound of the function inside

    def __len__(self) -> int:
        return len(self.which)

    def __getitem__(self, places: np.ndarray) -> _Intervals:
        return _Intervals(*(one[places] for one in vars(self).values()))

    @property
    def motion(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """y, v, a, slope and h."""
        return self.y, self.v, self.a, self.slope, self.h


# Shock response spectra: the peaks of single oscillators on a base that follows a signal, over their natural frequency.

#: Quantities as (c_0, c_1) of c_0 y + c_1 y', where -y is the displacement relative to the base.
QUANTITIES = {
    "absolute acceleration": lambda o: (o.w**2, 2 * o.zeta * o.w),
    "relative displacement": lambda o: (-1.0, 0.0),
    "relative velocity": lambda o: (0.0, -1.0),
    "pseudo-velocity": lambda o: (-o.w, 0.0),
    "pseudo-acceleration": lambda o: (-(o.w**2), 0.0),
}
UNITS = dict(zip(QUANTITIES, ("m/s^2", "m", "m/s", "m/s", "m/s^2")))

INTERPOLATIONS = ("linear", "band-limited")

#: The spectra that a shock response spectrum has.
PARTS = ("maximax", "positive", "negative", "primary", "residual")

#: A band-limited record is resampled so that a period of the highest frequency of the spectrum has so many samples, at most so many times.
SAMPLES_OF_PERIOD, MOST_SAMPLES = 40, 64

#: A signal has ended where it is smaller than so many rounding errors of its largest value.
ENDED = 1e3


@dataclass(frozen=True, repr=False, eq=False)
class ShockResponseSpectrum(Pictured):
    """Peaks of oscillators z'' + 2 zeta w z' + w^2 z = -a(t) on a base with the acceleration a.

    Attributes:
        frequencies_hz: natural frequencies, shape (F,).
        damping_ratio: zeta.
        quantity: quantity of the peaks.
        primary_positive, primary_negative: largest values and moduli of the smallest ones during the shock, shape (F,).
        residual_positive, residual_negative: largest positive and negative peak after its end.
        notices: notices on the interpretation of the signal.

    >>> import mbconstrained as mb
    >>> step = mb.pulse([1.0], duration=1000.0)  # a step doubles: an undamped oscillator has the peak 2
    >>> float(mb.shock_response_spectrum(step, [1.0], damping_ratio=0.0).maximax[0].round(9))
    2.0
    """

    frequencies_hz: np.ndarray
    damping_ratio: float
    quantity: str
    primary_positive: np.ndarray
    primary_negative: np.ndarray
    residual_positive: np.ndarray
    residual_negative: np.ndarray
    notices: tuple[Notice, ...] = field(default=())

    def _summary(self) -> str:
        return f"{self.quantity}, {counted(len(self.frequencies_hz), 'frequency', 'frequencies')}, damping ratio {self.damping_ratio:g}"

    @property
    def unit(self) -> str:
        """Unit of the values, for a base acceleration in m/s^2."""
        return UNITS[self.quantity]

    @property
    def positive(self) -> np.ndarray:
        """Largest values at any time, shape (F,)."""
        return np.maximum(self.primary_positive, self.residual_positive)

    @property
    def negative(self) -> np.ndarray:
        """Moduli of the smallest values at any time, shape (F,)."""
        return np.maximum(self.primary_negative, self.residual_negative)

    @property
    def primary(self) -> np.ndarray:
        """Largest moduli during the shock, shape (F,)."""
        return np.maximum(self.primary_positive, self.primary_negative)

    @property
    def residual(self) -> np.ndarray:
        """Largest moduli after the shock, shape (F,)."""
        return np.maximum(self.residual_positive, self.residual_negative)

    @property
    def maximax(self) -> np.ndarray:
        """Largest moduli at any time, shape (F,)."""
        return np.maximum(self.primary, self.residual)

    def to_xarray(self):
        """Return all parts as a ``DataArray`` with the dimensions part and frequency (Hz).

        Returns:
            An ``xarray.DataArray``; its attributes are the unit and the damping ratio.

        Raises:
            MissingPackage: xarray is not installed.
        """
        xarray = optional_package("xarray", "to_xarray")
        coords = {"part": list(PARTS), "frequency": ("frequency", self.frequencies_hz, {"units": "Hz"})}
        attributes = {"units": self.unit, "damping_ratio": self.damping_ratio}
        values = [getattr(self, part) for part in PARTS]
        return xarray.DataArray(values, coords, ("part", "frequency"), self.quantity, attributes)


@answering
def shock_response_spectrum(
    signal: ImpulsiveSmooth,
    frequencies_hz,
    damping_ratio: float = 0.05,
    quantity: str = "absolute acceleration",
    interpolation: str = "linear",
    quality_factor: float | None = None,
) -> ShockResponseSpectrum:
    """The shock response spectrum of a base acceleration, from the true extrema of the closed-form motion.

    Args:
        signal: acceleration of the base in one row: ``mb.sampled`` records (piecewise linear, any spacing), ``mb.pulse``, or sums of other inputs with
            an end, such as half sines.
        frequencies_hz: natural frequencies of the oscillators, shape (F,).
        damping_ratio: zeta >= 0, of any size.
        quantity: "absolute acceleration", "relative displacement", "relative velocity", "pseudo-velocity" or "pseudo-acceleration".
        interpolation: of a record: "linear" between samples, or "band-limited" (evenly spaced samples of a signal without frequencies above half of
            their rate, resampled by the Fourier transform).
        quality_factor: Q = 1 / (2 zeta), in the place of the damping ratio.

    Returns:
        A ``ShockResponseSpectrum``: ``maximax``, ``positive``, ``negative``, ``primary``, ``residual``.

    Raises:
        InputError: several rows, frequencies that are not positive, a signal without an end.

    A half sine of 1 m/s^2; its largest peak is 1.76846 at f T = 0.80994:

    >>> import mbconstrained as mb
    >>> half = mb.harmonic([1.0], angular_frequency=np.pi, phase=-np.pi / 2)  # sin(pi t), T = 1 s
    >>> peak = mb.shock_response_spectrum(half + half.delayed(1.0), [0.80993678585149450784], damping_ratio=0.0)
    >>> float(peak.maximax[0].round(12))
    1.768457653994
    """
    f, zeta = checked_oscillators(frequencies_hz, damping_ratio, quality_factor)
    check_known(quantity, QUANTITIES, "quantity")
    check_known(interpolation, INTERPOLATIONS, "interpolation")
    samples, notices = record_of_signal(signal), []
    if samples is not None:
        times, values = samples
        if interpolation == "band-limited":
            times, values = _resampled(times, values, float(f.max()))
            text = f"the record is read as band-limited, resampled to {counted(len(times), 'sample')}"
        else:
            text = 'the record is read as linear between its samples; interpolation "band-limited" reads it without frequencies above half of its rate'
        notices.append(Notice(NoticeKind.ACCURACY, text))
    if samples is None:
        each = [Oscillator(2 * np.pi * own, zeta) for own in f.tolist()]
        peaks = np.array([_closed_form_peaks(signal, one, QUANTITIES[quantity](one)) for one in each]).reshape(-1, 4).T
    else:
        oscillators = Oscillator(2 * np.pi * f, zeta)
        peaks = oscillators.peaks(ShockRecord(times, values), QUANTITIES[quantity](oscillators))
    high, low, after_high, after_low = peaks
    return ShockResponseSpectrum(f, zeta, quantity, high, 0.0 - low, after_high, 0.0 - after_low, tuple(notices))


def checked_oscillators(frequencies_hz, damping_ratio, quality_factor) -> tuple[np.ndarray, float]:
    """Frequencies in Hz and the damping ratio."""
    f = np.atleast_1d(real_array(frequencies_hz, "frequencies_hz"))
    if f.ndim != 1 or not (f > 0).all():
        raise InputError("frequencies_hz: expected a list of positive natural frequencies in Hz")
    if quality_factor is not None:
        return f, 1 / (2 * real_number(quality_factor, "quality_factor", positive=True))
    return f, real_number(damping_ratio, "damping_ratio", minimum=0.0)


def record_of_signal(signal: ImpulsiveSmooth) -> tuple[np.ndarray, np.ndarray] | None:
    """Times and values of a signal that is one record, None for another signal of one row."""
    if not isinstance(signal, ImpulsiveSmooth):
        hint = "; give its .signal" if hasattr(signal, "signal") else ""
        raise InputError(
            f"signal: found an object of type {type(signal).__name__}; expected an input such as mb.sampled(times, values){hint}"
        )
    if signal.size != 1:
        raise InputError(f"signal: found {signal.size} rows; expected the acceleration of the base in one row")
    parts = signal.exact_parts
    if len(parts) != 1 or not isinstance(parts[0].data, ExactRecord) or parts[0].derivatives:
        return None
    values = parts[0].data.values
    for factor in parts[0].maps:
        values = factor @ values if np.ndim(factor) else factor * values
    return parts[0].data.times + parts[0].rounded_time(), values[0]


def _resampled(times: np.ndarray, values: np.ndarray, highest: float) -> tuple[np.ndarray, np.ndarray]:
    """A band-limited record with more samples, zeros around it."""
    from scipy.signal import resample

    h = np.diff(times)
    if np.ptp(h) > STEP_AGREEMENT * h.max():
        raise InputError('interpolation: "band-limited" expects evenly spaced samples; those of this record are uneven')
    step = (times[-1] - times[0]) / len(h)
    factor = int(np.clip(np.ceil(SAMPLES_OF_PERIOD * highest * step), 1, MOST_SAMPLES))
    padded = np.pad(values, (0, len(values)))
    fine = resample(padded, factor * len(padded))[: factor * (len(values) - 1) + 1]
    return times[0] + step / factor * np.arange(len(fine)), fine


def signal_end(signal: ImpulsiveSmooth) -> float:
    """The time after which a signal is zero."""
    knots = np.asarray(signal.knots, dtype=float)
    end = float(knots[-1]) if len(knots) else 0.0
    later = np.abs(signal(end + np.linspace(0.0, max(end, 1.0), 9)[1:])).max()
    during = np.abs(signal(np.linspace(0.0, end, 257))).max() if end else 0.0
    if not end or later > ENDED * EPS * during:
        raise InputError("signal: it does not end; expected a record or a pulse, which is zero after some time")
    return end


def _closed_form_peaks(signal: ImpulsiveSmooth, oscillator: Oscillator, output) -> tuple[float, float, float, float]:
    """Peaks during and after a signal that is zero after its last knot."""
    function, end, last = oscillator.under(signal, output)
    peaks = extrema(function, 0.0, end)
    high, low = oscillator.residual(*last, output)
    return max(float(peaks.maximum[0]), 0.0), min(float(peaks.minimum[0]), 0.0), float(high), float(low)
