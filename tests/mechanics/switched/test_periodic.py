"""Periodic motions of switched systems against closed forms, time stepping and finite differences."""

import json
from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
import scipy
from scipy.integrate import solve_ivp

import mbconstrained as mb
from mbconstrained.mechanics.switched.periodic import find_periodic


def oscillator(c=0.1, **stop):
    """A unit mass on a unit spring with a stop at x = -gap."""
    model = mb.LumpedModel()
    model.mass("m", 1.0)
    model.spring("ground", "m", stiffness=1.0)
    if c:
        model.damper("ground", "m", damping=c)
    model.contact("ground", "m", name="stop", **stop)
    return model.assemble()


def belt(static=4.0, kinetic=2.0, speed=1.0, stiffness=4.0):
    model = mb.LumpedModel()
    model.mass("block", 1.0)
    model.spring("ground", "block", stiffness=stiffness)
    model.mass("belt", 1.0)
    model.prescribe("belt", mb.ramp([speed]))
    model.dry_friction("belt", "block", normal_force=10.0, coefficient=kinetic / 10, static_coefficient=static / 10)
    return model.assemble()


def cosine(frequency, *amplitudes):
    return mb.harmonic(list(amplitudes) or [1.0], angular_frequency=frequency)


def assert_closed(system, motion, force, tolerance=1e-10):
    """The motion over two periods, computed at once from its start, is that of the periodic continuation."""
    x = system.solve(motion(0.0), motion.velocity(0.0), force, end=2.2 * motion.period)
    times = np.linspace(0.01, 2.17, 57) * motion.period
    assert np.abs(x(times) - motion(times)).max() <= tolerance * np.abs(x(times)).max()


def assert_multipliers(motion, system, force, tolerance=1e-6):
    """Those of central differences of the motion over a period."""
    n, z = len(motion.names), motion.motion.initial[:2].ravel()
    size, columns = 1e-6 * np.abs(z).max(), []
    for unit in np.eye(2 * n):
        ends = []
        for sign in (1, -1):
            start = z + sign * size * unit * (z != 0)  # a body that is stuck remains so
            x = system.solve(start[:n], start[n:], force, end=motion.period)
            last = x.solution.sequence.segments[-1]
            y = last.phase.flow.states(last.state, last.duration)
            ends.append(np.concatenate([last.phase.C @ y, last.phase.V @ y]))
        columns.append((ends[0] - ends[1]) / (2 * size))
    expected = np.linalg.eigvals(np.array(columns).T)
    assert np.allclose(np.sort_complex(motion.multipliers), np.sort_complex(expected.astype(complex)), atol=tolerance)


# Free motions.


@pytest.mark.parametrize("stop", [3.0, 24.0])
@pytest.mark.parametrize("period", [None, 4.0])
def test_bilinear_oscillator(stop, period):
    """Half a period with each stiffness, whatever the amplitude."""
    x = oscillator(0.0, gap=0.0, stiffness=stop).periodic(period, guess=([0.7], [0.2]))
    assert x.period == pytest.approx(np.pi + np.pi / np.sqrt(1 + stop), rel=4e-15)
    assert np.abs(x.multipliers - 1).max() < 1e-12
    assert not x.is_stable  # its neighbours are periodic, too
    assert x.residual < 1e-14


@pytest.mark.parametrize("static, speed", [(4.0, 1.0), (3.0, 0.2), (2.5, 2.0)])
def test_stick_slip(static, speed):
    """Stick is linear over 2 D, slip part of a circle: T = 2 D / v + 2 (pi - atan(D w / v)) / w with D = (Fs - Fk) / k."""
    system, w = belt(static, 2.0, speed), 2.0
    D = (static - 2.0) / 4.0
    x = system.periodic(guess=({}, {"block": speed, "belt": speed}))
    assert x.period == pytest.approx(2 * D / speed + 2 / w * (np.pi - np.arctan(D * w / speed)), rel=1e-13)
    assert x.amplitude("block") == pytest.approx(np.hypot(D, speed / w), rel=1e-13)
    assert x.amplitude("belt") == pytest.approx(0.0, abs=1e-14)
    assert x.drift == pytest.approx([0.0, speed * x.period])
    assert x.multipliers == pytest.approx([1.0, 0.0, 0.0, 0.0], abs=1e-12)  # stick takes all but the shift in time away
    assert x.is_stable and len(x.events) == 2
    assert x(-0.3 * x.period)[0] == pytest.approx(x(0.7 * x.period)[0])
    assert x(5.25 * x.period)[1] - x(0.25 * x.period)[1] == pytest.approx(5 * speed * x.period)


def test_state_of_rest_is_refused():
    with pytest.raises(mb.NotUnique, match="rest"):
        oscillator(gap=0.5, stiffness=3.0).periodic()


# A mass that strikes a stop once in each period of the force (Shaw and Holmes, J. Sound Vib. 90 (1983) 129): closed form in mpmath.


class ImpactOscillator:
    """x'' + 2 z x' + x = cos(w t) with impacts at x = -gap, one in a period: (velocity after an impact, angle of the force there)."""

    def __init__(self, z, e, gap):
        self.z, self.e, self.gap = mp.mpf(z), mp.mpf(e), mp.mpf(gap)

    def flight(self, w, v, angle, t):
        """x and x' a time after an impact."""
        z, X = self.z, 1 / (1 - w**2 + 2j * self.z * w)
        d = mp.sqrt(1 - z**2)
        particular = lambda s: (mp.re(X * mp.expj(w * s + angle)), mp.re(1j * w * X * mp.expj(w * s + angle)))  # noqa: E731
        x0, v0 = particular(0)
        a = -self.gap - x0
        b = (v - v0 + z * a) / d
        decay, c, s = mp.exp(-z * t), mp.cos(d * t), mp.sin(d * t)
        x, dx = decay * (a * c + b * s), decay * ((b * d - z * a) * c - (a * d + z * b) * s)
        return x + particular(t)[0], dx + particular(t)[1]

    def next(self, w, v, angle):
        """Velocity and angle after the next impact, near one period later."""
        time = mp.findroot(lambda t: self.flight(w, v, angle, t)[0] + self.gap, 2 * mp.pi / w)
        return -self.e * self.flight(w, v, angle, time)[1], angle + w * time - 2 * mp.pi

    def periodic(self, w, guess):
        def equations(v, angle):
            x, dx = self.flight(w, v, angle, 2 * mp.pi / w)
            return x + self.gap, self.e * dx + v

        return mp.findroot(equations, guess)

    def derivative(self, w, v, angle):
        h, columns = mp.mpf(10) ** -15, []
        for dv, da in ((h, 0), (0, h)):
            high, low = self.next(w, v + dv, angle + da), self.next(w, v - dv, angle - da)
            columns.append([(p - q) / (2 * h) for p, q in zip(high, low)])
        return mp.matrix(columns).T

    def flip(self, w, guess):
        """The frequency near w at which a multiplier is -1."""

        def value(w):
            J = self.derivative(w, *self.periodic(w, guess))
            return 1 + J[0, 0] + J[1, 1] + mp.det(J)

        return mp.findroot(value, (w, w + mp.mpf("0.01")), solver="secant", tol=1e-20)


@pytest.mark.parametrize(
    "damping, e, gap, frequency", [(0.0, 0.8, 0.0, 2.3), (0.1, 0.8, 0.5, 1.5), (0.1, 0.5, 0.2, 1.2), (0.0, 0.8, 0.0, 2.9)]
)
def test_impact_oscillator(damping, e, gap, frequency):
    system, force = oscillator(damping, gap=gap, restitution=e), cosine(frequency)
    x = system.periodic(force=force)
    assert len(x.events) == 1
    event = x.events[0]
    v = event.jump[1, 0] * e / (1 + e)
    with mp.workdps(40):
        known = ImpactOscillator(damping / 2, e, gap)
        w = mp.mpf(frequency)
        exact = known.periodic(w, (v, frequency * event.time))
        multipliers = np.array([complex(one) for one in mp.eig(known.derivative(w, *exact), right=False)])
    assert v == pytest.approx(float(exact[0]), rel=1e-12)
    assert frequency * event.time == pytest.approx(float(exact[1]), rel=1e-12)
    assert np.allclose(np.sort_complex(x.multipliers), np.sort_complex(multipliers), rtol=1e-11, atol=1e-11)
    assert x.is_stable == (np.abs(multipliers).max() < 1)
    assert np.prod(x.multipliers).real == pytest.approx(e**2 * np.exp(-damping * x.period), rel=1e-12)  # contraction by Liouville


def test_flip_of_the_impact_oscillator():
    """The period doubles at the frequency of the closed form; the doubled motion exists beyond it."""
    system, e = oscillator(0.0, gap=0.0, restitution=0.8), 0.8
    curve = system.frequency_curve({"m": 1.0}, np.array([2.5, 2.72]) / (2 * np.pi))
    flip = next(one for one in curve.bifurcations if one.kind == "flip")
    event = flip.motion.events[0]
    w = 2 * np.pi / flip.motion.period
    with mp.workdps(40):
        known = ImpactOscillator(0, e, 0)
        exact = known.flip(mp.mpf(w) + mp.mpf("1e-4"), (event.jump[1, 0] * e / (1 + e), w * event.time))
    assert w == pytest.approx(float(exact), rel=1e-9)
    assert [one.kind for one in curve.bifurcations] == ["flip"]
    assert (curve.unstable == (curve.frequencies_hz > flip.motion.frequency_hz)).all()
    doubled = system.periodic(4 * np.pi / 2.67, force=cosine(2.67))
    assert doubled.is_stable and len(doubled.events) == 2
    first, second = (one.jump[1, 0] for one in doubled.events)
    assert abs(first - second) > 0.01 * first
    with pytest.raises(mb.InputError, match="does not repeat"):
        system.periodic(3.0, force=cosine(2.67))


# Against time stepping.


def test_isolator_against_shooting_with_time_stepping():
    """A harmonic force on a mass with an elastic, damped stop that separates before it would pull."""
    k, c, gap, w, F = 4.0, 0.3, 0.5, 1.1, 0.6
    system, force = oscillator(0.1, gap=gap, stiffness=k, damping=c), cosine(1.1, 0.6)
    x = system.periodic(force=force)

    def contact(x, v):
        return max(0.0, -k * (x + gap) - c * v) if x < -gap else 0.0

    def rate(t, y):
        return [y[1], F * np.cos(w * t) - y[0] - 0.1 * y[1] + contact(y[0], y[1])]

    times = [0.0, *(event.time for event in x.events), x.period]  # steps that end at the events keep the order

    def after(z):
        for a, b in pairwise(times):
            z = solve_ivp(rate, (a, b), z, method="DOP853", rtol=1e-13, atol=1e-14).y[:, -1]
        return z

    start = scipy.optimize.fsolve(lambda z: after(z) - z, [x(0.0)[0] * 1.01, x.velocity(0.0)[0]], xtol=1e-13)
    assert start == pytest.approx([x(0.0)[0], x.velocity(0.0)[0]], abs=1e-9)
    assert_closed(system, x, force)
    assert_multipliers(x, system, force)


def test_multipliers_of_elastic_stops_by_finite_differences():
    model = mb.LumpedModel()
    for name in ("a", "b"):
        model.mass(name, 1.0)
        model.spring("ground", name, stiffness=1.0)
        model.damper("ground", name, damping=0.2)
    model.backlash("a", "b", gap=0.3, stiffness=5.0, damping=0.1)
    model.contact("ground", "b", gap=0.2, restitution=0.6)
    system, force = model.assemble(), cosine(1.1, 1.0, 0.0)
    x = system.periodic(force=force)
    assert len(x.events) >= 3
    assert_closed(system, x, force)
    assert_multipliers(x, system, force)


# Forces and transitions that are repeated.


def test_stiffness_that_changes_at_times():
    """Meissner's equation: the product of two exponentials; the last transition is at the end of the period."""
    K = {"soft": 1.0, "stiff": 4.0}
    phases = {name: mb.MechanicalSystem([[1.0]], [[0.1]], [[k]]) for name, k in K.items()}
    system = mb.SwitchedSystem(phases, [mb.Transition("soft", "stiff", at=0.4), mb.Transition("stiff", "soft", at=1.0)])
    x = system.periodic(1.0, force=[1.0])
    first, second = (scipy.linalg.expm(np.array([[0.0, 1.0], [-K[name], -0.1]]) * t) for name, t in (("soft", 0.4), ("stiff", 0.6)))
    assert np.allclose(np.sort_complex(x.multipliers), np.sort_complex(np.linalg.eigvals(second @ first)), atol=1e-13)
    steady = [np.array([1 / K[name], 0.0]) for name in ("soft", "stiff")]
    A, b = second @ first, second @ (steady[0] - first @ steady[0] - steady[1]) + steady[1]
    start = np.linalg.solve(np.eye(2) - A, b)
    assert [x(0.0)[0], x.velocity(0.0)[0]] == pytest.approx(start, rel=1e-12)
    with pytest.raises(mb.InputError, match="within the period"):
        system.periodic(0.7, force=[1.0])


def test_record_of_one_period():
    """Straight lines are within (pi / 2 h)^2 / 8 = 5e-4 of the harmonic force: nearly the motion under it, and its periodic continuation repeats the record."""
    times = np.linspace(0.0, 4.0, 101)
    system = oscillator(0.1, gap=0.5, restitution=0.8)
    sampled = system.periodic(4.0, force=mb.sampled(times, np.cos(np.pi / 2 * times)[None]))
    smooth = system.periodic(force=cosine(np.pi / 2))
    assert sampled.multipliers == pytest.approx(smooth.multipliers, abs=1e-3)
    assert sampled(np.linspace(-4, 4, 33)) == pytest.approx(smooth(np.linspace(-4, 4, 33)), abs=1e-3)
    assert sampled.residual < 1e-13
    with pytest.raises(mb.InputError, match="within the period"):
        system.periodic(3.0, force=mb.sampled(times, np.cos(np.pi / 2 * times)[None]))


def test_rest_on_a_moving_table():
    """A body that bounces until it rests and is thrown off again forgets its state: all multipliers are zero."""
    model = mb.LumpedModel()
    model.mass("body", 1.0)
    model.gravity(-9.81)
    model.mass("table", 1.0)
    model.prescribe("table", cosine(13.0, 0.1))
    model.contact("table", "body", restitution=0.3)
    x = model.assemble().periodic(guess={"body": 0.3, "table": 0.1})
    thrown = next(event for event in x.events if "opens" in event.text)
    assert 16.9 * np.cos(13.0 * thrown.time) == pytest.approx(9.81, rel=1e-9)  # the table falls faster from there on
    assert np.abs(x.multipliers).max() == 0 and x.is_stable


def test_free_bodies_move_on():
    """Two free bodies with a spring between them that a harmonic force moves apart: their centre keeps its velocity."""
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.mass("b", 2.0)
    model.damper("a", "b", damping=0.3)
    model.backlash("a", "b", gap=0.2, stiffness=6.0)
    system, force = model.assemble(), cosine(2.0, 1.0, -1.0)
    x = system.periodic(force=force, guess=([0.0, 0.5], [0.3, 0.3]))
    centre = np.array([1.0, 2.0]) / 3
    assert centre @ x.drift == pytest.approx(centre @ x.velocity(0.1) * x.period, rel=1e-9)
    assert x.drift[0] == pytest.approx(x.drift[1], rel=1e-9)
    assert_closed(system, x, force)
    assert not x.is_stable


@pytest.mark.parametrize("friction, ratio", [(0.4, 1.5), (0.3, 1.2), (0.5, 0.8)])
def test_forced_vibration_with_dry_friction(friction, ratio):
    """Den Hartog, Trans. ASME 53 (1931): the amplitude where the mass stops twice in a period, each time for a moment only."""
    model = mb.LumpedModel()
    model.mass("m", 1.0)
    model.spring("ground", "m", stiffness=1.0)
    model.dry_friction("ground", "m", normal_force=1.0, coefficient=friction)
    x = model.assemble().periodic(force=cosine(ratio))
    U = np.sin(np.pi / ratio) / (ratio * (1 + np.cos(np.pi / ratio)))
    assert x.amplitude("m") == pytest.approx(np.sqrt((1 - ratio**2) ** -2 - (friction * U) ** 2), rel=1e-12)
    assert len(x.events) == 2 and x.is_stable


def test_gears_that_rattle_turn():
    """A torque turns two inertias with play between them; all but the angle itself decays, the whole with c / (J1 + J2)."""
    model = mb.LumpedModel()
    model.inertia("motor", 1.0)
    model.inertia("load", 2.0)
    model.torsion_damper("ground", "load", damping=0.5)
    model.backlash("motor", "load", gap=0.02, stiffness=100.0, damping=0.2)
    force = {"motor": mb.step([1.0]) + cosine(6.0, 5.0)}
    system = model.assemble()
    x = system.periodic(force=force)
    assert x.drift == pytest.approx(np.full(2, 2.0 * x.period), rel=1e-10)  # 1 N m / 0.5 N m s
    assert x.multipliers[0] == pytest.approx(1.0) and x.is_stable and len(x.events) == 6
    assert_closed(system, x, force, 1e-9)


def test_transition_after_a_dwell():
    """The stiffness rises some time after a limit has been passed: the time of the switch depends on the motion before it."""
    soft = mb.MechanicalSystem([[1.0]], [[0.1]], [[4.0]])
    stiff = mb.MechanicalSystem([[1.0]], [[0.3]], [[16.0]])
    rise = mb.Transition("soft", "stiff", when={"x1": 1.0}, above=0.2, dwell=0.3)
    fall = mb.Transition("stiff", "soft", when={"x1": 1.0}, below=-0.05)
    system = mb.SwitchedSystem({"soft": soft, "stiff": stiff}, [rise, fall])
    force = mb.harmonic([1.0], angular_frequency=1.7, phase=1.7 * 1.3)
    x = system.periodic(force=force)
    assert [event.after for event in x.events] == ["stiff", "soft"] and x.residual < 1e-13
    assert x(x.events[0].time - 0.3)[0] == pytest.approx(0.2, rel=1e-12)
    assert_multipliers(x, system, force)
    with pytest.raises(mb.InputError, match="dwell"):
        system.periodic(force=mb.harmonic([1.0], angular_frequency=1.7, phase=1.7 * (1.3 + x.events[0].time - 0.1)))


# Guesses and failures.


def test_forms_of_a_guess():
    system, force = oscillator(0.1, gap=0.5, restitution=0.8), cosine(1.5)
    x = system.periodic(force=force)
    z = np.array([x(0.0), x.velocity(0.0)])
    for guess in (
        x,
        z,
        z.ravel(),
        (z[0], z[1]),
        ({"m": z[0, 0]}, {"m": z[1, 0]}),
        {"displacement": z[0], "velocity": {"m": z[1, 0]}},
    ):
        assert system.periodic(force=force, guess=guess)(1.0) == pytest.approx(x(1.0), rel=1e-12)
    with pytest.raises(mb.InputError, match="guess"):
        system.periodic(force=force, guess=np.zeros(5))
    with pytest.raises(mb.InputError, match='no coordinate "x"'):
        system.periodic(force=force, guess={"x": 1.0})


def test_no_convergence_is_reported_with_the_residual():
    """Without damping at resonance there is no periodic motion."""
    model = mb.LumpedModel()
    model.mass("m", 1.0)
    model.spring("ground", "m", stiffness=1.0)
    model.contact("ground", "m", gap=1e9, restitution=0.5)
    with pytest.raises(mb.NotUnique, match="the last residual is"):
        model.assemble().periodic(force=cosine(1.0))


def test_period_is_that_of_the_force():
    system = oscillator(0.1, gap=0.5, restitution=0.8)
    two = cosine(2.0) + cosine(3.0)
    assert system.periodic(force=cosine(2.0)).period == pytest.approx(np.pi)
    assert system.periodic(force=two).period == pytest.approx(2 * np.pi, rel=1e-15)  # of both
    assert system.periodic(2 * np.pi, force=two).period == 2 * np.pi
    with pytest.raises(mb.InputError, match="give the period"):
        system.periodic(force=cosine(1.0) + cosine(2.0**0.5))
    with pytest.raises(mb.InputError, match="no coordinate"):
        system.periodic(force=cosine(2.0)).amplitude("n")


def test_plain_data():
    x = oscillator(0.1, gap=0.5, restitution=0.8).periodic(force=cosine(1.5))
    data = json.loads(json.dumps(x.to_dict()))
    assert data["amplitudes"]["m"] == x.amplitude("m") and len(data["events"]) == len(x.events)
    assert data["multipliers"] == [[one.real, one.imag] for one in x.multipliers]
    high, low = x.peaks().maximum[0], x.peaks().minimum[0]
    assert x.amplitude("m") == pytest.approx((high - low) / 2) and low == pytest.approx(-0.5)


# Curves over the frequency.


def test_curve_of_an_isolator_with_a_stop():
    """Up to the fold, back on the unstable branch, and on; at a frequency between the folds there are three motions."""
    system, hz = oscillator(0.1, gap=1.0, stiffness=4.0), 0.19
    curve = system.frequency_curve({"m": 0.3}, [0.13, hz, 0.21])
    kinds = [one.kind for one in curve.bifurcations]
    assert kinds == ["grazing", "fold", "fold", "grazing"]
    folds = [one.motion for one in curve.bifurcations if one.kind == "fold"]
    for fold in folds:
        assert np.abs(fold.multipliers - 1).min() < 1e-6
    assert curve.frequencies_hz[curve.unstable].min() >= folds[1].frequency_hz * (1 - 1e-9)
    assert curve.frequencies_hz[curve.unstable].max() <= folds[0].frequency_hz * (1 + 1e-9)
    three = curve.at(hz)
    assert [one.is_stable for one in three] == [True, False, True]
    assert [len(one.events) for one in three] == [2, 2, 0]
    for one in three:
        assert one.frequency_hz == pytest.approx(hz, rel=1e-14)
        assert_closed(system, one, cosine(2 * np.pi * hz, 0.3), 1e-9)
    linear = 0.3 / abs(1 - (2 * np.pi * hz) ** 2 + 0.1j * 2 * np.pi * hz)
    assert three[2].amplitude("m") == pytest.approx(linear, rel=1e-12)
    grazing = [one.motion for one in curve.bifurcations if one.kind == "grazing"]  # where the linear amplitude is the gap
    w2 = np.roots([1.0, 0.1**2 - 2.0, 1.0 - 0.3**2])
    assert sorted(one.frequency_hz for one in grazing) == pytest.approx(sorted(np.sqrt(w2) / (2 * np.pi)), rel=1e-6)


def test_curve_that_ends_at_a_rigid_stop():
    """Where the linear amplitude reaches the gap: the slope of the motion is infinite there."""
    system = oscillator(0.05, gap=1.0, restitution=0.8)
    curve = system.frequency_curve([1.0], [0.3, 0.2])
    w2 = np.roots([1.0, 0.05**2 - 2.0, 0.0]).max()
    assert [one.kind for one in curve.bifurcations] == ["grazing"] and "grazing" in curve.end_text
    assert curve.frequencies_hz.min() == pytest.approx(np.sqrt(w2) / (2 * np.pi), rel=1e-5)


def test_curve_as_data_and_plot():
    system = oscillator(0.1, gap=1.0, stiffness=4.0)
    curve = system.frequency_curve({"m": 0.3j}, [0.18, 0.183], start=([0.0], [0.0]))
    data = json.loads(json.dumps(curve.to_dict()))
    assert len(data["points"]) == len(curve.points) == len(curve.table().rows)
    assert data["points"][0]["force_hz"] == pytest.approx(0.18)
    axes = curve.plot()
    assert {line.get_linestyle() for line in axes.lines} >= {"-"}
    first = curve.points[0]  # the force is -0.3 sin(w t)
    force = mb.harmonic([0.3], frequency_hz=0.18, phase=np.pi / 2)
    assert_closed(system, first, force, 1e-9)
    for wrong in ([0.1], [0.1, -0.2], [0.1, 0.1]):
        with pytest.raises(mb.InputError, match="frequencies_hz"):
            system.frequency_curve({"m": 1.0}, wrong)
    with pytest.raises(mb.InputError, match='no coordinate "n"'):
        system.frequency_curve({"n": 1.0}, [0.1, 0.2])


def test_period_may_start_near_an_event():
    """Started just before and just after an impact, the motion is the same."""
    system = oscillator(0.1, gap=0.5, restitution=0.8)
    x = system.periodic(force=cosine(1.5))
    for shift in (-1e-3, 1e-3):
        time = x.events[0].time + shift
        force = mb.harmonic([1.0], angular_frequency=1.5, phase=1.5 * time)
        y = system.periodic(force=force)
        assert y(np.linspace(0.2, 4.0, 9)) == pytest.approx(x(np.linspace(0.2, 4.0, 9) + time), rel=1e-10)
        assert y.multipliers == pytest.approx(x.multipliers, rel=1e-9)


@pytest.mark.parametrize("kind", ["rigid", "elastic", "friction", "static friction", "play", "rigid and friction"])
def test_random_chains(kind):
    """A closed orbit is found for each, and its multipliers are those of finite differences."""
    rng = np.random.default_rng([1, len(kind)])
    model, n = mb.LumpedModel(), int(rng.integers(1, 4))
    for i in range(n):
        model.mass(f"m{i}", rng.uniform(0.5, 2.0))
        model.spring(f"m{i - 1}" if i else "ground", f"m{i}", stiffness=rng.uniform(1.0, 20.0))
        model.damper(f"m{i - 1}" if i else "ground", f"m{i}", damping=rng.uniform(0.05, 0.5))
    last = f"m{n - 1}"
    if "rigid" in kind:
        model.contact("ground", last, gap=rng.uniform(0.0, 0.3), restitution=rng.uniform(0.3, 0.95))
    if "elastic" in kind:
        model.contact("ground", last, gap=rng.uniform(0.0, 0.3), stiffness=rng.uniform(1.0, 100.0), damping=rng.uniform(0.0, 1.0))
    if "play" in kind:
        model.backlash("ground", last, gap=rng.uniform(0.05, 0.3), stiffness=rng.uniform(1.0, 100.0))
    if "friction" in kind:
        static = 0.5 if "static" in kind else 0.3
        model.dry_friction("ground", "m0", normal_force=1.0, coefficient=0.3, static_coefficient=static)
    force = np.zeros(n)
    force[rng.integers(n)] = rng.uniform(1.0, 3.0)
    system, load = model.assemble(), cosine(rng.uniform(0.5, 4.0), *force)
    x = system.periodic(force=load)
    assert x.residual < 1e-10
    assert_multipliers(x, system, load, 1e-4 * max(1.0, np.abs(x.multipliers).max()))


def test_a_support_that_moves_as_a_sine_is_a_force():
    """At t = 0 a sine and its second derivative vanish as those of a ramp do; its period is that of the motion all the same."""
    model = mb.LumpedModel()
    model.mass("cart", 1.0), model.node("support"), model.spring("support", "cart", stiffness=1.0)
    model.damper("ground", "cart", damping=0.1), model.contact("ground", "cart", gap=0.5, stiffness=4.0)
    model.prescribe("support", mb.harmonic([1.0], angular_frequency=1.5, phase=-np.pi / 2))
    assert model.assemble().periodic().period == pytest.approx(2 * np.pi / 1.5, rel=1e-15)


def test_rest_under_a_weight_is_no_periodic_motion():
    model = mb.LumpedModel()
    model.gravity(-9.81)
    model.mass("body", 8.0), model.mass("foot", 1.0), model.spring("foot", "body", stiffness=4000.0)
    model.damper("foot", "body", damping=10.0), model.contact("ground", "foot")
    with pytest.raises(mb.NotUnique, match="state of rest"):
        find_periodic(model.assemble(), None, None, None, begin=np.array([0.3, 0.3, 0.0, 0.0]))
