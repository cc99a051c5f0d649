"""Input that is wrong, degenerate, stiff, long, or at the border between two answers."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.errors import InputError, MbconstrainedError, NotUnique

EPS = np.finfo(float).eps
G = 9.81


def falling(gravity=-G, **contact):
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.gravity(gravity)
    model.contact("ground", "a", **contact)
    return model


def times(x):
    return np.array([event.time for event in x.events])


@pytest.mark.parametrize(
    "contact, text",
    [
        ({"gap": -0.5}, "gap: found -0.5"),
        ({"restitution": 1.5}, "restitution: found 1.5; expected a number from 0"),
        ({"restitution": -0.1}, "restitution: found -0.1"),
        ({"restitution": float("nan")}, "restitution: found nan"),
        ({"gap": float("inf")}, "gap: found inf"),
        ({"stiffness": 0.0}, "stiffness: found 0"),
        ({"stiffness": 10.0, "restitution": 0.5}, "found stiffness and restitution"),
        ({"damping": 1.0}, "damping without stiffness"),
    ],
)
def test_contacts_that_cannot_be(contact, text):
    with pytest.raises(InputError, match=text):
        falling(**contact)


@pytest.mark.parametrize("end", [0.0, -1.0, np.nan, np.inf])
def test_end_must_be_a_positive_number(end):
    with pytest.raises(InputError, match="end: found"):
        falling().assemble().solve({"a": 1.0}, end=end)


def test_start_in_penetration():
    machine = falling(gap=0.5).assemble()
    with pytest.raises(InputError, match=r"penetrated by 0.25 m; closing it there would need an impulse of 0.25 N s\^2"):
        machine.solve({"a": -0.75}, end=1.0)
    x = machine.solve({"a": -0.75}, end=1.0, penetration=True)
    assert x(0.0)[0] == -0.5 and np.isclose(x.events[0].higher_impulses["contact ground-a"][0], 0.25)


def test_unknown_names_and_phases():
    a = mb.MechanicalSystem([[1.0]], names=["lid"])
    for change, text in (
        (mb.Transition("a", "b", when={"lidd": 1.0}, above=0.1), 'no coordinate "lidd"; did you mean "lid"'),
        (mb.Transition("a", "c", when={"lid": 1.0}, above=0.1), 'no phase "c"'),
        (mb.Transition("a", "b", when={"stop": 1.0}, above=0.1, quantity="reaction"), 'no constraint row "stop"'),
    ):
        with pytest.raises(InputError, match=text):
            mb.SwitchedSystem({"a": a, "b": a}, [change])


def test_singular_phases_are_named_with_their_coordinate():
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.node("tip")
    model.spring("a", "tip", stiffness=1.0, name="s")
    model.spring("tip", "ground", stiffness=2.0, name="t")
    model.release("s", at=1.0)
    model.release("t", at=2.0)
    with pytest.raises(MbconstrainedError, match='phase "s released, t released".*coordinates "tip" can move'):
        model.assemble().solve({"a": 1.0}, end=3.0)


def test_closed_and_released_at_once():
    model = mb.LumpedModel()
    model.mass("a", 1.0), model.mass("b", 1.0)
    model.latch("a", "b", at=1.0, name="latch")
    with pytest.raises(InputError, match="closed and released at once"):
        model.release("latch", at=1.0)


def test_phases_that_fight_are_named():
    a, b = mb.MechanicalSystem([[1.0]]), mb.MechanicalSystem([[1.0]], stiffness=[[1.0]])
    changes = [mb.Transition("a", "b", when={"x1": 1.0}, above=0.5), mb.Transition("b", "a", when={"x1": 1.0}, above=0.2)]
    with pytest.raises(NotUnique, match='t = 0.5 s.*"phase" alternate without end'):
        mb.SwitchedSystem({"a": a, "b": b}, changes).solve(velocity=[1.0], end=2.0)


def test_too_many_events_end_with_a_message():
    with pytest.raises(NotUnique, match="more than 20 times"):
        falling(restitution=1.0).assemble().solve({"a": 1e-6}, end=1.0, most_events=20)


@pytest.mark.parametrize("gravity, lifts", [(-G, False), (0.0, False), (G, True)])
def test_start_exactly_on_the_stop(gravity, lifts):
    x = falling(gravity, restitution=0.5).assemble().solve(end=2.0)
    assert not x.events and np.isclose(x(2.0)[0], 2 * G if lifts else 0.0)


@pytest.mark.parametrize("power", [0, 1, 3, 8, 15])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_force_that_begins_slowly(power, sign):
    # t^p lifts off at once, or never
    x = falling(0.0).assemble().solve(force=mb.term([sign], power=power), end=1.5)
    exact = 1.5 ** (power + 2) / ((power + 1) * (power + 2))
    assert np.isclose(x(1.5)[0], exact if sign > 0 else 0.0, rtol=1e-12, atol=0) and not x.events


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_far_end_of_a_chain(sign):
    # the force on the first of ten masses reaches the last one in the order t^20
    n, model = 10, mb.LumpedModel()
    for i in range(n):
        model.mass(f"m{i}", 1.0)
    for i in range(n - 1):
        model.spring(f"m{i}", f"m{i + 1}", stiffness=1.0)
    model.contact(f"m{n - 1}", "ground")
    force = mb.step(sign * np.eye(n)[0])
    x = model.assemble().solve(force=force, end=12.0)
    K = np.diag([1.0, *[2.0] * (n - 2), 1.0]) - np.eye(n, k=1) - np.eye(n, k=-1)
    wall = mb.Constraint(np.eye(n)[-1]) if sign > 0 else None
    alone = mb.MechanicalSystem(np.eye(n), stiffness=K, constraints=[wall] if wall else [])
    t = np.linspace(0.0, 12.0, 49)
    assert not x.events and np.allclose(x(t), alone.solve(force=force)(t), rtol=0, atol=1e-12)


@pytest.mark.parametrize("part, lifts", [(1 - 1e-9, False), (1.0, None), (1 + 1e-6, True)])
def test_shaken_just_below_and_above_lift_off(part, lifts):
    w = 10.0
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.gravity(-G)
    model.node("table")
    amplitude = part * G / w**2
    model.prescribe("table", mb.harmonic([amplitude], angular_frequency=w, phase=-np.pi / 2))
    model.contact("table", "a")
    x = model.assemble().solve({}, {"a": amplitude * w, "table": amplitude * w}, end=3.0)
    if lifts:  # off the table where its acceleration is -g
        assert np.isclose(times(x)[0], np.arcsin(1 / part) / w, rtol=1e-12) and "opens" in x.events[0].text
    else:
        assert all(event.grazing for event in x.events) and bool(x.events) == (lifts is None)
        if x.events:
            assert np.allclose(times(x), (np.pi / 2 + 2 * np.pi * np.arange(len(x.events))) / w, rtol=1e-9)


def test_very_light_mass_at_the_stop():
    for mass in (1e-6, 1e-10, 1e-14, 0.0):
        model = mb.LumpedModel()
        model.mass("a", 1.0)
        _ = model.mass("tip", mass) if mass else model.node("tip")
        model.spring("tip", "a", stiffness=10.0)
        model.contact("ground", "tip")
        x = model.assemble().solve({"a": 1.0, "tip": 1.0}, {"a": -1.0, "tip": -1.0}, end=4.0)
        # the spring is pressed for half a period, then all moves on; the impulse is that of the tip
        assert np.allclose(times(x), [1.0, 1.0 + np.pi / np.sqrt(10.0)], rtol=1e-12)
        assert np.isclose(x.velocity(4.0)[0], 1.0, rtol=0, atol=1e-3 if mass == 1e-6 else 1e-6)
        assert np.isclose(x.events[0].impulses.get("contact ground-tip", 0.0), mass, rtol=1e-6)


def test_massless_point_keeps_no_restitution_and_says_so():
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.node("tip")
    model.spring("tip", "a", stiffness=10.0)
    model.contact("ground", "tip", restitution=0.5)
    x = model.assemble().solve({"a": 1.0, "tip": 1.0}, {"a": -1.0, "tip": -1.0}, end=4.0)
    assert np.allclose(times(x), [1.0, 1.0 + np.pi / np.sqrt(10.0)], rtol=1e-14)
    assert any("has no mass" in notice.text for notice in x.notices)


@pytest.mark.parametrize("stiffness", [1e4, 1e8, 1e12])
def test_stiff_stop(stiffness):
    # in contact m x'' + k x = -m g from x = 0 with -v: half an oscillation about -m g / k
    x = falling(stiffness=stiffness).assemble().solve({"a": 1.0}, end=5.0)
    w, v, fall = np.sqrt(stiffness), np.sqrt(2 * G), np.sqrt(2 / G)
    contact = (np.pi + 2 * np.arctan2(G / w, v)) / w
    exact = np.cumsum([fall, *[contact, 2 * fall] * 6])
    assert np.allclose(times(x), exact[exact < 5.0], rtol=1e-13) and np.isclose(x.energy(5.0).total, G, rtol=1e-12)


def test_stop_with_damping_never_pulls():
    x = falling(stiffness=1e4, damping=60.0).assemble().solve({"a": 1.0}, end=2.0)
    closes, separates, opens = x.events[:3]
    assert [event.after for event in x.events[:3]] == ["closed", "separating", "open"]
    # the force k x + c x' is zero where it separates; under gravity alone it leaves the stop
    assert abs(1e4 * x(separates.time)[0] + 60.0 * x.velocity(separates.time)[0]) < 1e-9
    t = np.linspace(closes.time, separates.time, 50)[1:-1]
    assert (1e4 * x(t) + 60.0 * x.velocity(t) < 0).all() and np.isclose(x(opens.time)[0], 0.0, atol=1e-15)


def test_slow_growth_reaches_the_stop_at_last():
    # e^{1e-4 t} cos t reaches 1.5 from below near t = 4054.65; the reference by bisection between extrema
    import mpmath

    system = mb.MechanicalSystem([[1.0]], damping=[[-2e-4]], stiffness=[[1.0 + 1e-8]])
    stop = system.with_constraints(mb.Constraint([1.0], value=1.5, names="stop"))
    machine = mb.SwitchedSystem({"free": system, "held": stop}, [mb.Transition("free", "held", when={"x1": 1.0}, above=1.5)])
    x = machine.solve([1.0], [1e-4], end=5000.0)
    with mpmath.workdps(40):
        c, k = mpmath.mpf(-2e-4), mpmath.mpf(1.0 + 1e-8)
        a = -c / 2
        w = mpmath.sqrt(k - a**2)
        b = (mpmath.mpf(1e-4) - a) / w
        f = lambda t: mpmath.exp(a * t) * (mpmath.cos(w * t) + b * mpmath.sin(w * t)) - 1.5  # noqa: E731
        peaks = [2 * mpmath.pi * i / w for i in range(900)]
        first = next(p for p in peaks if max(f(p + d) for d in (0, mpmath.mpf(1e-4), mpmath.mpf(2e-4))) > 0)
        exact = mpmath.findroot(f, (first - 0.5, first + mpmath.mpf(1e-4)), solver="anderson")
    assert abs(float(x.events[0].time - exact)) <= x.events[0].time_error
    assert x.events[0].time_error < 1e-6


def test_unstable_systems():
    # an inverted pendulum between stops: cosh
    pendulum = mb.MechanicalSystem([[1.0]], stiffness=[[-1.0]])
    bounce = mb.Transition("free", "free", when={"x1": 1.0}, above=1.0, restitution=1.0)
    x = mb.SwitchedSystem({"free": pendulum}, [bounce]).solve([0.5], end=20.0)
    quarter = np.arccosh(2.0)
    assert np.allclose(times(x)[:4], quarter * np.array([1, 3, 5, 7]), rtol=1e-10)
    assert (np.diff([event.time_error for event in x.events]) > 0).all()


def test_events_at_knots_of_the_force():
    # it lands at the instant at which a force begins that lifts it: it opens at once
    model = falling()
    x = model.assemble().solve({"a": G / 2}, force=mb.step([20.0]).delayed(1.0), end=2.0)
    assert np.allclose(times(x), 1.0, rtol=4 * EPS) and x.events[-1].after == "open"
    assert np.isclose(x(2.0)[0], (20.0 - G) / 2)


def test_several_thousand_knots():
    r, knots = np.random.default_rng(1), np.linspace(0.0, 10.0, 2001)
    values = r.normal(size=(1, 2001))
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.spring("ground", "a", stiffness=100.0)
    model.damper("ground", "a", damping=0.2)
    alone = model.assemble().solve(force=mb.sampled(knots, values))
    t = np.linspace(0.0, 10.0, 20001)
    model.contact("ground", "a", gap=0.003, restitution=0.7)
    x = model.assemble().solve(force=mb.sampled(knots, values), end=10.0)
    first = t[np.argmax(alone(t)[0] < -0.003)]
    assert abs(times(x)[0] - first) <= 5e-4 and len(x.events) < 60 and x(t).min() >= -0.003 - 1e-15
    before = t[t < times(x)[0]]
    assert np.allclose(x(before), alone(before), rtol=0, atol=1e-14)


def chain(order, unit=1.0):
    """Three masses with stops, in an order of the coordinates and a unit of length."""
    masses, start = {"a": 1.0, "b": 2.5, "c": 0.7}, {"a": 0.03, "b": -0.2, "c": 0.1}
    model = mb.LumpedModel()
    for name in order:
        model.mass(name, masses[name])
    model.spring("ground", "a", stiffness=300.0), model.spring("a", "b", stiffness=200.0), model.spring("b", "c", stiffness=150.0)
    model.contact("a", "b", gap=0.1 * unit, restitution=0.6)
    model.contact("b", "c", gap=0.05 * unit, restitution=0.9)
    model.contact("ground", "a", gap=0.08 * unit, restitution=0.3)
    return model.assemble().solve(velocity={name: 20 * unit * start[name] for name in order}, end=0.8)


def test_order_of_coordinates_and_units_do_not_matter():
    x, others = chain("abc"), [chain("cab"), chain("bca"), chain("abc", unit=1e6), chain("abc", unit=1e-9)]
    assert 5 < len(x.events) < 100
    for other in others:
        assert len(other.events) == len(x.events)
        assert all(abs(p.time - q.time) <= p.time_error + q.time_error and p.text == q.text for p, q in zip(x.events, other.events))


def test_impact_of_a_resting_column():
    # ten balls on each other fall onto the ground without rebound and stay; each carries those above it
    model = mb.LumpedModel()
    for i in range(10):
        model.mass(f"m{i}", 1.0 + 0.1 * i)
    model.gravity(-G)
    model.contact("ground", "m0")
    for i in range(9):
        model.contact(f"m{i}", f"m{i + 1}")
    heights = {f"m{i}": 1.0 + 0.1 * i for i in range(10)}
    x = model.assemble().solve(heights, end=2.0)
    falls = np.sqrt(2 * (1.0 + 0.1 * np.arange(10)) / G)
    assert np.allclose(times(x), falls, rtol=64 * EPS) and not np.any(x.velocity(2.0))
    masses = 1.0 + 0.1 * np.arange(10)
    assert np.allclose(x.reaction(2.0), G * np.cumsum(masses[::-1])[::-1], rtol=1e-13)
    # each impulse passes through all balls below
    assert all(np.allclose(list(event.impulses.values()), masses[i] * G * falls[i], rtol=1e-12) for i, event in enumerate(x.events))


def test_two_bouncing_balls_on_each_other_come_to_rest():
    model = mb.LumpedModel()
    model.mass("low", 2.0), model.mass("high", 1.0)
    model.gravity(-G)
    model.contact("ground", "low", restitution=0.5), model.contact("low", "high", restitution=0.5)
    x = model.assemble().solve({"low": 1.0, "high": 1.1}, end=6.0)
    assert len(x.events) < 200 and not np.any(x.velocity(6.0)) and not np.any(x(6.0))
    lost = sum(event.energy_lost for event in x.events)
    assert np.isclose(lost, 2.0 * G + 1.1 * G, rtol=1e-9)


def test_each_phase_has_its_own_force():
    """Free fall until t = 1 s, then a thrust of twice the weight and a harmonic force: x'' = -g, then g + cos(3 t)."""
    fall = mb.MechanicalSystem([[1.0]], force=[-9.81])
    thrust = mb.MechanicalSystem([[1.0]], force=mb.harmonic([1.0], angular_frequency=3.0), static_force=[9.81])
    x = mb.SwitchedSystem({"fall": fall, "thrust": thrust}, [mb.Transition("fall", "thrust", at=1.0)]).solve(end=2.0)
    assert x.acceleration([0.5, 1.5])[0] == pytest.approx([-9.81, 9.81 + np.cos(4.5)], rel=1e-13)
    assert x.velocity(2.0)[0] == pytest.approx((np.sin(6.0) - np.sin(3.0)) / 3, rel=1e-12)
