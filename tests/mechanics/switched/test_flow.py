"""The first zeros of guards: against references in 40 digits, whose other zeros are excluded by bounds of the second derivative."""

from functools import cache

import mpmath
import numpy as np
import pytest

from mbconstrained.mechanics.switched.flow import NOISE, PhaseFlow

EPS = np.finfo(float).eps
HORIZON, GRID = 12.0, 6001


class Sum:
    """g(t) = sum over a of e^{s t} (c1 cos w t + c2 sin w t) - b, exactly as given by floats."""

    def __init__(self, seed: int):
        r = np.random.default_rng(seed)
        count = r.integers(1, 4)
        self.s, self.w = -r.uniform(0.0, 0.3, count) * r.integers(0, 2, count), r.uniform(0.2, 6.0, count)
        self.c = r.normal(size=(count, 2))
        self.y = r.normal(size=(count, 2))

    def flow(self, b: float) -> PhaseFlow:
        blocks = [np.array([[s, w], [-w, s]]) for s, w in zip(self.s, self.w)]
        return PhaseFlow(blocks, self.c.reshape(1, -1), np.array([b]), HORIZON)

    def derivative(self, t, order: int):
        """Of g + b, vectorized in float64."""
        z = (self.s + 1j * self.w)[:, None]
        a = (self.c[:, 0] * self.y[:, 0] + self.c[:, 1] * self.y[:, 1])[:, None]
        d = (self.c[:, 0] * self.y[:, 1] - self.c[:, 1] * self.y[:, 0])[:, None]
        return np.sum(((a - 1j * d) * z**order * np.exp(z * np.atleast_1d(t))).real, axis=0)

    def exact(self, t, order: int = 0):
        """The same in 40 digits."""
        total = mpmath.mpf(0)
        for s, w, (c1, c2), (y1, y2) in zip(self.s, self.w, self.c, self.y):
            c1, c2, y1, y2 = map(mpmath.mpf, (c1, c2, y1, y2))
            z = mpmath.mpc(s, w)
            total += mpmath.re((c1 * y1 + c2 * y2 - mpmath.j * (c1 * y2 - c2 * y1)) * z**order * mpmath.exp(z * t))
        return total

    def minimum(self):
        """The place of the least value on the horizon, in 40 digits; None where it is at an end or not clearly the only one."""
        t = np.linspace(0.0, HORIZON, GRID)
        g, h = self.derivative(t, 0), t[1]
        curvature = np.abs(self.c).sum(axis=1) * np.abs(self.y).sum(axis=1) @ (self.s**2 + self.w**2)
        below = np.minimum(g[:-1], g[1:]) - curvature * h**2 / 8
        at = int(np.argmin(g))
        near = np.flatnonzero(below <= g[at] + 2e-3)
        if not 20 < at < GRID - 20 or (np.diff(near) > 1).any() or (self.derivative(t[near[0] : near[-1] + 2], 2) < 0.01).any():
            return None  # another minimum may be as deep
        place = mpmath.mpf(t[at])
        for _ in range(8):
            place -= self.exact(place, 1) / self.exact(place, 2)
        return place

    def first_crossing(self, b: float):
        flow, y = self.flow(b), self.y.ravel()
        order, sign = flow.orders(y, np.abs(y), np.zeros(1, int), 0.0)
        assert order[0] == 0 and sign[0] > 0
        return flow.first_crossing(y, np.abs(y), order, sign, HORIZON)

    @property
    def noise(self) -> float:
        return NOISE * float(np.abs(self.c.ravel()) @ np.abs(self.y.ravel()) * 2)


@cache
def sums_with_a_minimum():
    """Sums with the place and the value of their least one and the curvature there."""
    places = ((g, g.minimum()) for g in map(Sum, range(150)))
    return [(seed, g, place, g.exact(place), g.exact(place, 2)) for seed, (g, place) in enumerate(places) if place is not None]


@pytest.mark.parametrize("depth", [1e-3, 1e-6, 1e-9, 1e-12, 1e-13, 1e-14, 1e-15, 0.0])
@mpmath.workdps(40)
def test_none_missed_and_none_invented(depth):
    checked = 0
    for seed, g, place, least, curvature in sums_with_a_minimum():
        for side in (1, -1) if depth else (1,):
            b = float(least) + side * depth
            below = mpmath.mpf(b) - least  # how far the guard falls below zero, b as it is stored
            crossing = g.first_crossing(b)
            checked += 1
            if below < -g.noise:
                assert crossing is None, seed
            elif below > g.noise:
                assert crossing is not None and not crossing.grazing, seed
                low = place - 2 * mpmath.sqrt(2 * below / curvature)
                exact = mpmath.findroot(lambda t: g.exact(t) - b, (low, place), solver="anderson", tol=1e-60)
                slope = abs(float(g.exact(exact, 1)))
                assert abs(float(crossing.time - exact)) <= g.noise / slope + 4 * EPS * float(exact), seed
            elif crossing is not None:
                reach = float(mpmath.sqrt(4 * g.noise / curvature))
                assert abs(float(crossing.time - place)) <= (1e-9 if crossing.grazing else reach), seed
            else:  # only where it does not reach zero by more than rounding errors
                assert below < 0, seed
    assert checked > 36


def test_a_guard_that_touches_zero_is_reported_at_its_minimum():
    flow = PhaseFlow([np.array([[0.0, 3.0], [-3.0, 0.0]])], np.array([[1.0, 0.0]]), np.array([-1.0]), 10.0)
    y = np.array([np.cos(1.0), np.sin(1.0)])  # cos(3 t - 1), at -1 where 3 t = pi + 1
    order, sign = flow.orders(y, np.abs(y), np.zeros(1, int), 0.0)
    crossing = flow.first_crossing(y, np.abs(y), order, sign, 10.0)
    assert crossing.grazing and abs(crossing.time - (np.pi + 1) / 3) <= 4 * EPS


@pytest.mark.parametrize("power", [1, 2, 3, 5, 8, 13, 20])
def test_signs_after_zeros_of_any_order(power):
    # g = t^p / p! is positive just after 0 though all derivatives but one vanish
    J = np.diag(np.ones(power), 1)
    flow = PhaseFlow([J], np.eye(power + 1)[:1], np.zeros(1), 1.0)
    for sign in (1.0, -1.0):
        y = sign * np.eye(power + 1)[-1]
        order, own = flow.orders(y, np.abs(y), np.zeros(1, int), 0.0)
        assert order[0] == power and own[0] == sign


@pytest.mark.parametrize("rate", [1e3, 1e6, 1e9])
def test_fast_decaying_states_do_not_make_panels_narrow(rate):
    # g = cos t + e^{-rate t}; the fast part is gone long before the zero at pi / 2
    blocks = [np.array([[0.0, 1.0], [-1.0, 0.0]]), np.array([[-rate]])]
    flow = PhaseFlow(blocks, np.array([[1.0, 0.0, 1.0]]), np.zeros(1), 100.0)
    y = np.array([1.0, 0.0, 1.0])
    order, sign = flow.orders(y, np.abs(y), np.zeros(1, int), 0.0)
    crossing = flow.first_crossing(y, np.abs(y), order, sign, 100.0)
    exact = mpmath.findroot(lambda t: mpmath.cos(t) + mpmath.exp(-rate * t), mpmath.pi / 2)
    assert abs(crossing.time - float(exact)) <= 4 * EPS


def test_a_million_periods_are_excluded_by_a_bound():
    flow = PhaseFlow([np.array([[0.0, 1.0], [-1.0, 0.0]])], np.array([[1.0, 0.0]]), np.array([-1.0 - 1e-9]), 1e7)
    y = np.array([1.0, 0.0])
    order, sign = flow.orders(y, np.abs(y), np.zeros(1, int), 0.0)
    assert flow.first_crossing(y, np.abs(y), order, sign, 2e6 * np.pi) is None
