"""Times of events over hundreds of impacts against exact arithmetic and 60 digits, and their error estimates."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest

import mbconstrained as mb

EPS = np.finfo(float).eps
G = 9.81


def dropped(restitution: float, end: float, height: float = 1.0):
    model = mb.LumpedModel()
    model.mass("ball", 1.0)
    model.gravity(-G)
    model.contact("ground", "ball", restitution=restitution)
    return model.assemble().solve({"ball": height}, end=end)


def assert_times(x, exact, relative=1e-13, loosest=1e4):
    """Times within a relative error, and error estimates that hold and are not far above the largest error so far."""
    errors = [abs(float(mpmath.mpf(event.time) - time)) for event, time in zip(x.events, exact)]
    times = np.array([event.time for event in x.events])
    estimates = np.array([event.time_error for event in x.events])
    assert len(times) == len(exact) and (errors <= relative * times).all()
    assert (errors <= estimates).all()
    largest = np.maximum.accumulate(np.maximum(errors, EPS * times / 8))
    assert (estimates <= loosest * largest).all()


@pytest.mark.parametrize("restitution, end", [(1.0, 903.0), (0.999, 570.0), (0.99, 80.0), (0.8, 4.0)])
def test_bouncing_ball(restitution, end):
    with mpmath.workdps(60):
        e, first = mpmath.mpf(restitution), mpmath.sqrt(2 / mpmath.mpf(G))
        times, flight = [first], 2 * e * first
        while times[-1] + flight < end:
            times.append(times[-1] + flight)
            flight *= e
        x = dropped(restitution, end)
        assert_times(x, times)
    assert restitution < 1 or len(times) == 1000


@pytest.mark.parametrize("restitution", [0.8, 0.5, 0.1])
def test_infinitely_many_bounces_are_summed(restitution):
    x = dropped(restitution, 10.0)
    with mpmath.workdps(60):
        e, first = mpmath.mpf(restitution), mpmath.sqrt(2 / mpmath.mpf(G))
        rest = first * (1 + e) / (1 - e)
    last = x.events[-1]
    assert abs(float(last.rest_time - rest)) <= 1e-13 * float(rest) and last.time == last.rest_time
    if restitution == 0.8:
        assert abs(last.time - 4.0637127688715781) <= 4e-13
    assert last.after == "closed" and not x(np.linspace(last.time, 10.0, 7)).any()
    # all the energy is lost; the impulses add up to gravity over the time up to the first bounce that is summed, then there is a force
    assert np.isclose(sum(event.energy_lost for event in x.events), G, rtol=1e-13)
    summed = x.solution.sequence.records[-1].time
    assert np.isclose(sum(event.impulses["contact ground-ball"] for event in x.events), G * summed, rtol=1e-13)
    assert x.reaction(summed + 1e-9)[0] == pytest.approx(G, rel=1e-13)


def test_ball_on_a_table_that_moves_harmonically():
    # each impact: y = a sin(w t), v -> -e v + (1 + e) a w cos(w t); the times in 60 digits
    a, w, e, end = 0.1, 12.0, 0.75, 20.0
    model = mb.LumpedModel()
    model.mass("ball", 1.0)
    model.gravity(-G)
    model.node("table")
    model.prescribe("table", mb.harmonic([a], angular_frequency=w, phase=-np.pi / 2))
    model.contact("table", "ball", restitution=e)
    x = model.assemble().solve({"ball": 0.3}, {"table": a * w}, end=end)
    with mpmath.workdps(60):
        a, w, e, g, phase = map(mpmath.mpf, (a, w, e, G, -np.pi / 2))
        table = lambda t: a * mpmath.cos(w * t + phase)  # noqa: E731
        speed = lambda t: -a * w * mpmath.sin(w * t + phase)  # noqa: E731
        t, height, v, errors, growth = mpmath.mpf(0), mpmath.mpf(0.3), mpmath.mpf(0), [], []
        for event in x.events:
            if event.time_error > 1e-6:
                break  # hardly any digits are left
            gap = lambda s, t=t, height=height, v=v: height + v * (s - t) - g * (s - t) ** 2 / 2 - table(s)  # noqa: E731
            # no zero before the event: the gap is positive on a fine grid
            grid = mpmath.linspace(t, mpmath.mpf(event.time), 40)[1:-1]
            assert all(gap(s) > 0 for s in grid)
            at = mpmath.findroot(gap, mpmath.mpf(event.time))
            errors.append(abs(float(at - event.time)))
            growth.append(event.time_error)
            height, v, t = table(at), -e * (v - g * (at - t)) + (1 + e) * speed(at), at
    # a chaotic motion: errors grow, and the estimates with them
    assert 25 < len(errors) < len(x.events) and all(error <= estimate for error, estimate in zip(errors, growth))
    assert all(error <= 1e-13 for error in errors[:5]) and growth[4] < 1e-11
    assert any("has lost its digits" in notice.text and notice.doubtful for notice in x.notices)


def test_two_masses_between_stops():
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.mass("b", 3.0)
    model.contact("ground", "a", gap=1.0, restitution=1.0)
    model.contact("a", "b", gap=0.5, restitution=1.0)
    model.contact("b", "ground", gap=2.0, restitution=1.0)
    x = model.assemble().solve(velocity={"a": 1.0, "b": -0.3}, end=1770.0)
    (xa, xb, va, vb, t), times = map(Fraction, (0, 0, 1, -0.3, 0)), []
    while True:
        waits = []
        if va < 0:
            waits.append(((-1 - xa) / va, "left"))
        if vb > 0:
            waits.append(((2 - xb) / vb, "right"))
        if vb < va:
            waits.append(((xb - xa + Fraction(1, 2)) / (va - vb), "both"))
        wait, kind = min(waits)
        t, xa, xb = t + wait, xa + va * wait, xb + vb * wait
        if t > 1770:
            break
        times.append(mpmath.mpf(t.numerator) / t.denominator)
        if kind == "both":
            common = (va + 3 * vb) / 4
            va, vb = 2 * common - va, 2 * common - vb
        va, vb = -va if kind == "left" else va, -vb if kind == "right" else vb
    assert len(times) >= 990
    assert_times(x, times)
    assert np.isclose(x.energy(1770.0).total, 0.5 + 1.5 * 0.09, rtol=1e-12)
