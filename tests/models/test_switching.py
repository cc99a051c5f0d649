"""Elements with several states against closed forms of textbooks: momentum, energy, periods."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.mechanics.switched.switches import rigid_contact

EPS = np.finfo(float).eps


def model_of(**masses):
    model = mb.LumpedModel()
    for name, mass in masses.items():
        model.mass(name, mass)
    return model


def times(x):
    return np.array([event.time for event in x.events])


def close(value, exact, units=64):
    return np.allclose(value, exact, rtol=units * EPS, atol=units * EPS)


# Clutches and brakes.


def test_rigid_clutch():
    model = mb.LumpedModel()
    model.inertia("engine", 2.0), model.inertia("gearbox", 3.0)
    model.clutch("engine", "gearbox", engaged=0.5)
    x = model.assemble().solve(velocity={"engine": 10.0, "gearbox": 1.0}, end=2.0)
    (event,) = x.events
    assert event.time == 0.5 and close(x.velocity(2.0), (2 * 10 + 3 * 1) / 5)
    assert close(abs(event.impulses["clutch engine-gearbox"]), 2 * 3 / 5 * 9)
    assert close(event.energy_lost, 2 * 3 / 5 * 9**2 / 2) and event.momentum_residual <= 8 * EPS


def test_slipping_clutch():
    # relative speed falls by T (1/J1 + 1/J2) t; the heat is T times the mean relative angle
    model = mb.LumpedModel()
    model.inertia("engine", 2.0), model.inertia("gearbox", 3.0)
    model.clutch("engine", "gearbox", torque=6.0, engaged=0.5)
    x = model.assemble().solve(velocity={"engine": 10.0, "gearbox": 1.0}, end=4.0)
    slip = 9 / (6 * (1 / 2 + 1 / 3))
    assert close(times(x), [0.5, 0.5 + slip]) and close(x.velocity(3.0), 23 / 5)
    assert close(x.energy(0.0).total - x.energy(4.0).total, 6.0 * 9 * slip / 2)
    assert [event.after for event in x.events] == ["backward", "stuck"]


def test_clutch_slips_above_its_torque():
    # driven by T = 10 t, the stuck pair needs J2 / (J1 + J2) T from the clutch
    model = mb.LumpedModel()
    model.inertia("engine", 2.0), model.inertia("gearbox", 3.0)
    model.clutch("engine", "gearbox", torque=6.0)
    x = model.assemble().solve(force=mb.ramp([10.0, 0.0]), end=2.0)
    (event,) = x.events
    assert close(event.time, 1.0) and "slips" in event.text
    assert close(x.velocity(2.0), [1.0 + (15.0 - 6.0) / 2, 1.0 + 6.0 / 3])


def test_brake_until_it_is_released():
    model = mb.LumpedModel()
    model.inertia("wheel", 2.0)
    model.brake("ground", "wheel", torque=4.0, engaged=1.0, released=2.0)
    x = model.assemble().solve(velocity={"wheel": 3.0}, end=3.0)
    assert close(x.velocity(np.array([0.5, 1.5, 3.0]))[0], [3.0, 2.0, 1.0]) and close(times(x), [1.0, 2.0])


# Friction.


def belt(static):
    model = model_of(block=1.0, belt=1.0)
    model.prescribe("belt", mb.ramp([0.5]))
    model.spring("ground", "block", stiffness=4.0)
    model.dry_friction("belt", "block", normal_force=10.0, coefficient=0.2, static_coefficient=static)
    return model.assemble()


def test_stick_and_slip():
    k, w, v, low, high = 4.0, 2.0, 0.5, 0.2 * 10 / 4.0, 0.4 * 10 / 4.0
    x = belt(0.4).solve(velocity={"block": v, "belt": v}, end=30.0)
    first = high / v  # it moves with the belt until the spring pulls with the static force
    slip = 2 * (np.pi - np.arctan(w * (high - low) / v)) / w  # from where on x' = v again
    stick = 2 * (high - low) / v  # from 2 low - high to high
    exact = np.cumsum([first, *[slip, stick] * 8])
    assert close(times(x), exact[exact < 30.0], 256)
    middle = first + slip / 2  # the outermost point is on the other side of the kinetic force
    assert close(x(first + slip)[0], 2 * low - high, 256) and x(middle)[0] < high
    assert close(x.reaction(first / 2)[-1], k * v * first / 2) or close(x.reaction(first / 2)[-1], -k * v * first / 2)


def test_coulomb_decay():
    # each half period takes 2 mu N / k from the amplitude; it sticks where the spring pulls with less than mu N
    model = model_of(block=1.0)
    model.spring("ground", "block", stiffness=1.0)
    model.dry_friction("ground", "block", normal_force=1.0, coefficient=0.1)
    x = model.assemble().solve({"block": 1.05}, end=30.0)
    assert close(times(x), np.pi * np.arange(1, 6)) and x.events[-1].after == "stuck"
    assert close([x(t)[0] for t in times(x)], [-0.85, 0.65, -0.45, 0.25, -0.05])
    assert close(x.reaction(30.0), [0.05]) or close(x.reaction(30.0), [-0.05])


# Stops.


def test_housner_rocking_block():
    # small angles: I0 theta'' = m g R (theta - alpha), quarter period acosh(1 / (1 - theta0 / alpha)) / p, r = 1 - 3/2 sin^2 alpha
    b, h, m, g = 0.25, 1.0, 2.0, 9.81
    inertia = m * (b**2 + h**2) / 3
    block = mb.MechanicalSystem(
        mass=np.diag([m, inertia + m * h**2]),
        stiffness=np.diag([0.0, -m * g * h]),
        static_force=[-m * g, 0.0],
        names=["y", "theta"],
    )
    feet = [rigid_contact(name, np.array([1.0, side * b]), 0.0, 0.0) for name, side in (("left", 1.0), ("right", -1.0))]
    x = mb.SwitchedSystem.of_switches(block, feet).solve({"y": b * 0.1, "theta": 0.1}, end=2.5)
    alpha, p = b / h, np.sqrt(m * g * h / (inertia + m * (h**2 + b**2)))
    r = 1 - 1.5 * b**2 / (b**2 + h**2)
    quarter = np.arccosh(1 / (1 - 0.1 / alpha)) / p
    impact = x.events[0]
    assert close(impact.time, quarter) and close(x.velocity(quarter)[1] / (x.velocity(quarter * (1 - 1e-9))[1]), r, 1e8)
    speed = p * np.sqrt(alpha**2 - (alpha - 0.1) ** 2)
    assert close(impact.jump[1, 1], (1 - r) * speed)
    assert close(impact.energy_lost, (1 - r**2) * (inertia + m * (h**2 + b**2)) * speed**2 / 2)
    # the next amplitude from the energy, the next quarter twice from it
    amplitude = alpha - np.sqrt(alpha**2 - (r * speed / p) ** 2)
    assert close(x.events[1].time, quarter + 2 * np.arccosh(1 / (1 - amplitude / alpha)) / p, 256)


def test_bilinear_oscillator():
    model = model_of(a=2.0)
    model.spring("ground", "a", stiffness=8.0)
    model.one_sided_spring("ground", "a", stiffness=10.0)
    x = model.assemble().solve(velocity={"a": 1.0}, end=40.0)
    w1, w2 = 2.0, 3.0
    assert close(times(x), np.cumsum([np.pi / w1, np.pi / w2] * 20)[: len(x.events)], 256) and len(x.events) == 30
    assert close(x.energy(np.linspace(0, 40, 300)).total, 1.0, 1000)
    assert close(x(np.pi / 4)[0], 1 / w1) and close(x(np.pi / w1 + np.pi / w2 / 2)[0], -1 / w2)


def test_backlash_in_a_drive_of_two_inertias():
    # the relative angle crosses the play at constant speed and turns within half a period of the mesh
    model = mb.LumpedModel()
    model.inertia("motor", 1.0), model.inertia("load", 4.0)
    model.backlash("motor", "load", gap=0.01, stiffness=1e4)
    x = model.assemble().solve(velocity={"motor": 2.0}, end=0.5)
    half, speed = np.pi / np.sqrt(1e4 * (1 + 1 / 4)), 2.0
    exact = np.cumsum([0.005 / speed, *[half, 0.01 / speed] * 20])
    assert close(times(x), exact[exact < 0.5], 512)
    assert close([1.0, 4.0] @ x.velocity(np.linspace(0, 0.5, 40)), 2.0) and close(x.energy(0.5).total, 2.0, 512)


@pytest.mark.parametrize("stiffness", [None, 400.0])
def test_cable(stiffness):
    model = model_of(a=1.0, b=3.0)
    model.cable("a", "b", length=0.5, stiffness=stiffness)
    x = model.assemble().solve(velocity={"b": 2.0}, end=2.0)
    if stiffness is None:  # taut without rebound: one speed from momentum
        (event,) = x.events
        assert close(event.time, 0.25) and close(x.velocity(1.0), 1.5)
        assert close(event.impulses["cable a-b"], 1 * 3 / 4 * 2.0) and close(event.energy_lost, 1.5)
    else:  # half a period of 400 N/m with the reduced mass, then apart again with the relative velocity reversed
        assert close(times(x), [0.25, 0.25 + np.pi / np.sqrt(400 / 0.75), 0.25 + np.pi / np.sqrt(400 / 0.75) + 0.5][:2], 256)
        assert close(x.velocity(0.5), [3.0, 1.0], 256)


def test_piecewise_spring_conserves_energy():
    breaks, k = [-0.3, -0.05, 0.1, 0.4], [900.0, 20.0, 100.0, 400.0, 50.0]
    model = model_of(a=1.5)
    model.piecewise_spring("ground", "a", breakpoints=breaks, stiffnesses=k)
    x = model.assemble().solve(velocity={"a": 7.0}, end=6.0)
    edges = np.array([-2.0, *breaks, 2.0])

    def energy(e):  # the integral of the force, piece by piece
        grid = np.sort([0.0, e, *breaks])
        grid = grid[(grid >= min(0.0, e)) & (grid <= max(0.0, e))]
        stiffness = lambda s: k[np.searchsorted(breaks, s)]  # noqa: E731
        force = total = 0.0
        for s, t in zip(*(grid[:-1], grid[1:]) if e > 0 else (grid[:0:-1], grid[-2::-1])):
            own = stiffness((s + t) / 2)
            total, force = total + (t - s) * (force + own * (t - s) / 2), force + own * (t - s)
        return total

    t = np.linspace(0.0, 6.0, 200)
    exact = [1.5 * v**2 / 2 + energy(e) for e, v in zip(x(t)[0], x.velocity(t)[0])]
    assert close(exact, 1.5 * 49 / 2, 1000) and close(x.energy(t).total, 1.5 * 49 / 2, 1000)
    assert len(x.events) > 20 and all(np.isclose(edges, x(event.time)[0], rtol=0, atol=1e-13).any() for event in x.events)
    assert all(abs(event.energy_lost) <= 1000 * EPS * 40 for event in x.events)


# Latches and releases.


def test_latch_of_two_spacecraft_with_flexible_appendages():
    model = model_of(hub=100.0, panel=10.0, target=60.0, boom=5.0)
    model.spring("hub", "panel", stiffness=40.0, name="panel root")
    model.spring("target", "boom", stiffness=90.0, name="boom root")
    model.latch("hub", "target", distance=0.0, name="latch")
    machine = model.assemble()
    x = machine.solve({"target": 1.0, "boom": 1.0}, {"hub": 0.2, "panel": 0.2, "target": -0.05, "boom": -0.05}, end=60.0)
    (event,) = x.events
    common = (100 * 0.2 - 60 * 0.05) / 160
    assert close(event.time, 1.0 / 0.25) and event.after == "closed"
    assert close(event.jump[1], [common - 0.2, 0.0, common + 0.05, 0.0])
    assert close(abs(event.impulses["latch"]), 100 * 60 / 160 * 0.25)
    assert close(event.energy_lost, 100 * 60 / 160 * 0.25**2 / 2)
    momentum = np.array([100.0, 10.0, 60.0, 5.0]) @ x.velocity(np.linspace(0, 60, 50))
    assert close(momentum, 100 * 0.2 + 10 * 0.2 - 65 * 0.05, 1000)
    own = np.sqrt([40 * (1 / 100 + 1 / 10), 90 * (1 / 60 + 1 / 5)])
    assert np.allclose(machine.phase(event.before).modes().natural_frequencies, np.sort(own), rtol=1e-13)
    K = np.array([[130.0, -40.0, -90.0], [-40.0, 40.0, 0.0], [-90.0, 0.0, 90.0]])
    joined = np.sqrt(np.sort(np.linalg.eigvals(np.diag([1 / 160, 1 / 10, 1 / 5]) @ K).real)[1:])
    assert np.allclose(machine.phase("closed").modes().natural_frequencies, joined, rtol=1e-12)
    # afterwards both hubs move as one
    assert np.allclose(x(np.linspace(5, 60, 30))[0], x(np.linspace(5, 60, 30))[2], rtol=0, atol=1e-13)


def test_latch_at_a_time_and_release():
    model = model_of(a=1.0, b=1.0)
    model.latch("a", "b", at=1.0, name="latch")
    model.release("latch", at=2.0)
    model.spring("b", "ground", stiffness=np.pi**2)
    x = model.assemble().solve(velocity={"a": 2.0}, end=3.0)
    assert close(times(x), [1.0, 2.0]) and close(x.velocity(1.0), 1.0)
    w = np.pi / np.sqrt(2)  # both on the spring, then b alone
    assert close(x.velocity(2.5)[0], np.cos(w)) and close(x(2.5)[1], x.velocity(2.0)[1] / np.pi, 128)


@pytest.mark.parametrize("how, elongation", [({"force": 30.0}, 0.3), ({"above": 0.2}, 0.2)])
def test_release_by_force_and_by_elongation(how, elongation):
    model = model_of(a=1.0)
    model.spring("ground", "a", stiffness=100.0, name="spring")
    model.release("spring", **how)
    x = model.assemble().solve(velocity={"a": 5.0}, end=1.0)
    assert close(times(x), [np.arcsin(elongation / 0.5) / 10.0])
    assert close(x.velocity(1.0)[0], np.sqrt(25 - 100 * elongation**2))
    assert close(x.events[0].energy_lost, 50 * elongation**2)  # that of the spring is gone


def test_release_of_a_rigid_tie_by_its_force():
    model = model_of(a=1.0, b=2.0)
    model.constrain({"a": 1.0, "b": -1.0}, name="bolt")
    model.release("bolt", force=4.0)
    x = model.assemble().solve(force=mb.ramp([0.0, 3.0]), end=5.0)  # the bolt takes a third of 3 t
    assert close(times(x), [4.0]) and close(x.velocity(5.0)[0], 1.0 * 16 / 2)


# Whole phases.


def test_two_capacitors_are_joined():
    # C v' = i without inductance: charge is conserved, the current is an impulse
    c1, c2, v1, v2 = 2.0, 3.0, 10.0, 0.0
    circuit = mb.MechanicalSystem(mass=np.zeros((2, 2)), damping=np.diag([c1, c2]), stiffness=np.zeros((2, 2)), names=["v1", "v2"])
    joined = circuit.with_constraints(mb.Constraint([1.0, -1.0], names="switch"))
    machine = mb.SwitchedSystem({"open": circuit, "closed": joined}, [mb.Transition("open", "closed", at=1.0)])
    x = machine.solve([v1, v2], end=2.0)
    (event,) = x.events
    common = (c1 * v1 + c2 * v2) / (c1 + c2)
    assert close(x(2.0), common) and close(event.jump[0], [common - v1, common - v2])
    assert close(abs(event.impulses["switch"]), c1 * c2 / (c1 + c2) * (v1 - v2))
    assert event.momentum_residual <= 8 * EPS


def test_a_switch_opens_an_inductive_circuit_at_zero_current():
    # L q'' + q / C = 0 from q0: the diode opens at q' = 0, after half a period, with the charge reversed
    on = mb.MechanicalSystem([[0.5]], stiffness=[[8.0]])
    off = mb.MechanicalSystem([[0.5]], damping=[[0.0]], stiffness=[[0.0]])
    machine = mb.SwitchedSystem(
        {"on": on, "off": off}, [mb.Transition("on", "off", when={"x1": 1.0}, above=0.0, quantity="velocity")]
    )
    x = machine.solve([1.0], [-1e-3], end=3.0)
    amplitude, phase = np.hypot(1.0, 1e-3 / 4), np.arctan(1e-3 / 4)
    assert close(times(x), [(np.pi - phase) / 4]) and close(x(3.0), -amplitude)


def test_dwell():
    # x = t above 0.5 for 0.25 s, unless it comes back
    a = mb.MechanicalSystem([[1.0]], stiffness=[[0.0]])
    b = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]])
    change = mb.Transition("a", "b", when={"x1": 1.0}, above=0.5, dwell=0.25)
    machine = mb.SwitchedSystem({"a": a, "b": b}, [change])
    x = machine.solve(velocity=[1.0], end=2.0)
    assert close(times(x), [0.75]) and x.events[0].text == "to b" and close(x(2.0), 0.75 * np.cos(2.5) + np.sin(2.5) / 2)
    # x = v t - t^2 / 2 is above 0.5 for 2 sqrt(v^2 - 1), in the second case a shorter time
    assert close(times(machine.solve(velocity=[1.01], force=mb.step([-1.0]), end=3.0)), [1.01 - np.sqrt(1.01**2 - 1) + 0.25], 1000)
    assert not machine.solve(velocity=[1.005], force=mb.step([-1.0]), end=3.0).events


# Energy.


def test_springs_that_do_not_act_have_no_strain_energy_and_others_that_of_their_stretch():
    model = mb.LumpedModel()
    model.mass("a", 2.0), model.mass("b", 1.0), model.gravity(-3.0)
    model.backlash("a", "b", gap=0.04, stiffness=300.0)
    x = model.assemble().solve(velocity={"a": 0.5}, end=2.0)
    times = np.linspace(0.0, 2.0, 401)
    stretch = np.maximum(np.abs(x(times)[1] - x(times)[0]) - 0.02, 0.0)
    energy = x.energy(times)
    assert np.allclose(energy.strain, 150.0 * stretch**2, atol=1e-13) and energy.strain.max() > 1e-3
    assert (energy.strain[stretch == 0.0] == pytest.approx(0.0, abs=1e-15)) and (stretch == 0.0).any()
    assert np.allclose(energy.static, 3.0 * np.array([2.0, 1.0]) @ x(times), rtol=1e-12, atol=1e-13)
    assert np.allclose(energy.total, energy.total[0], rtol=1e-12)


def test_the_energy_at_events_is_that_of_the_motion_on_both_sides():
    model = mb.LumpedModel()
    model.mass("ball", 1.0), model.gravity(-9.81), model.contact("ground", "ball", restitution=0.8)
    x = model.assemble().solve({"ball": 1.0}, end=2.0)
    for event in x.events:
        before, after = x.energy(np.array([np.nextafter(event.time, 0.0), event.time])).total
        assert (before, after) == pytest.approx((event.energy_before, event.energy_after), rel=1e-12)
        assert before - after == pytest.approx(event.energy_lost, rel=1e-9)
        assert event.energy_lost == pytest.approx((1 - 0.8**2) * event.energy_before, rel=1e-9)
