"""The examples with contacts, backlash, friction, clutches and cables against closed forms and time stepping."""

import math
from pathlib import Path

import numpy as np
import pytest
import scipy.integrate

import mbconstrained as mb
from mbconstrained.scene.run.scene import read_scene

EXAMPLES = Path(__file__).parents[1] / "examples"
G = 9.81


def motion_of(name):
    result = read_scene(EXAMPLES / f"{name}.toml").run()
    assert result.is_trusted
    return result.motion


def test_the_crate_strikes_after_free_fall_with_its_own_momentum_and_comes_to_rest():
    x = motion_of("dropped_crate")
    speed = math.sqrt(2 * G * 0.8)
    first = x.events[0]
    assert first.time == pytest.approx(speed / G, rel=1e-14)
    assert first.impulses == pytest.approx({"floor": 1.4 * 2 * speed}, rel=1e-13)
    assert first.energy_lost == pytest.approx((1 - 0.4**2) * 2 * speed**2 / 2, rel=1e-12)
    closing = [event for event in x.events if event.after == "closed"]
    assert closing and closing[-1].rest_time is not None
    at, sag = closing[-1].rest_time, -5 * G / 8000
    w, decay, t = math.sqrt(8000 / 5 - 16), 4.0, 2.5 - at  # from then on the instrument oscillates on its springs alone
    (_, begin), (_, rate) = x(at), x.velocity(at)
    own = sag + math.exp(-decay * t) * ((begin - sag) * math.cos(w * t) + (rate + decay * (begin - sag)) / w * math.sin(w * t))
    assert x(2.5) == pytest.approx([0.0, own], abs=1e-10)
    assert x.reaction(2.5) == pytest.approx([2 * G - 8000 * own - 40 * x.velocity(2.5)[1]], rel=1e-9)
    assert all(event.momentum_residual < 1e-12 and event.energy_lost > -1e-10 for event in x.events)


def test_the_gear_rattles_as_time_stepping_has_it():
    """A spring with damper beyond +-2 mrad that never pulls, by an implicit method with a tolerance of 1e-11."""
    x = motion_of("gear_rattle")
    w, k, c, drag, J, half = 2 * math.pi * 25, 5e4, 10.0, 0.01, 0.002, 0.002

    def rates(t, y):
        e, rate = y[0] - 0.01 * math.sin(w * t), y[1] - 0.01 * w * math.cos(w * t)
        torque = max(0.0, -(k * (e + half) + c * rate)) if e < -half else -max(0.0, k * (e - half) + c * rate) if e > half else 0.0
        return [y[1], (torque - drag * y[1]) / J]

    end = 0.4
    found = scipy.integrate.solve_ivp(rates, (0, end), [0.0, 0.0], "LSODA", rtol=1e-11, atol=1e-13, max_step=2e-4)
    assert [x(end)[1], x.velocity(end)[1]] == pytest.approx(found.y[:, -1], rel=1e-6, abs=1e-8)
    assert sum(event.time <= end for event in x.events) > 10


def test_the_clutch_conserves_angular_momentum_and_its_sides_have_one_speed_from_then_on():
    x = motion_of("slipping_clutch")
    inertias, times = np.array([0.3, 0.05, 1.2]), np.linspace(0, 1, 200)
    total = 0.3 * 1500 * 2 * math.pi / 60
    assert inertias @ x.velocity(times) == pytest.approx(total, rel=1e-12)
    engaged, sticks = x.events
    assert engaged.time == 0.1 and sticks.after == "stuck"
    after = x.velocity(np.linspace(sticks.time, 1, 50))
    assert after[0] == pytest.approx(after[1], rel=1e-12)
    assert inertias @ after / inertias.sum() == pytest.approx(np.full(50, total / inertias.sum()), rel=1e-12)
    while_slipping = 0.2
    assert x.velocity(while_slipping)[0] == pytest.approx(1500 * 2 * math.pi / 60 - 200 * (while_slipping - 0.1) / 0.3, rel=1e-13)
    lost = x.energy(0.0).total - x.energy(sticks.time).total
    slip = 200 * (x(sticks.time)[0] - x(0.1)[0] - x(sticks.time)[1])  # the work of the clutch
    damped = lost - slip
    assert 0 < damped < 0.1 * lost and np.abs(x.reaction(times)).max() <= 200


def test_the_block_sticks_and_slips_in_the_times_of_the_closed_form():
    x = motion_of("stick_slip")
    v, w, D = 0.1, 2.0, (0.4 - 0.3) * 10 / 4
    slip, stick = 2 * (math.pi - math.atan(D * w / v)) / w, 2 * D / v
    times = [0.4 * 10 / 4 / v]
    while times[-1] < 40:
        times += [times[-1] + slip, times[-1] + slip + stick]
    assert [event.time for event in x.events] == pytest.approx([time for time in times if time < 40], rel=1e-13)


def test_the_load_leaves_the_floor_at_its_weight_and_overloads_the_rope_by_v_sqrt_k_m():
    x = motion_of("lifted_load")
    v, k, m = 0.5, 4e5, 500.0
    assert [event.time for event in x.events[:2]] == pytest.approx([0.1 / v, 0.1 / v + m * G / (k * v)], rel=1e-13)
    stretch = x.peaks(0.35, combinations=[[1.0, -1.0]]).maximum[0] - 0.1
    assert k * stretch == pytest.approx(m * G + v * math.sqrt(k * m), rel=1e-12)


def test_the_foot_lands_with_its_own_momentum_and_leaves_where_the_ground_would_pull():
    x = motion_of("hopper")
    landing, leaving = x.events[:2]
    speed = math.sqrt(2 * G * 0.3)
    assert landing.time == pytest.approx(speed / G, rel=1e-14)
    assert landing.impulses == pytest.approx({"ground contact": speed}, rel=1e-13)

    def rates(t, y):  # of the body on the leg, the foot at rest
        return [y[1], (-4000 * y[0] - 10 * y[1]) / 8 - G]

    lifting = lambda t, y: 4000 * y[0] + 10 * y[1] - G  # noqa: E731
    lifting.terminal, lifting.direction = True, 1
    found = scipy.integrate.solve_ivp(rates, (0, 2), [0.0, -speed], rtol=1e-12, atol=1e-14, events=lifting)
    assert leaving.time - landing.time == pytest.approx(found.t_events[0][0], rel=1e-9)
    assert x.reaction(leaving.time - 1e-9)[0] == pytest.approx(0.0, abs=1e-4)


def test_peaks_of_the_shock_are_those_of_the_motion_through_all_phases_and_end_with_it(tmp_path):
    scene = read_scene(EXAMPLES / "dropped_crate.toml")
    peaks = {(row["quantity"], row["of"]): row for row in scene.shock().data["peaks"]}
    assert peaks["displacement", "crate"]["minimum"] == 0.0  # the floor
    speed = math.sqrt(2 * G * 0.8)
    assert peaks["velocity", "crate"]["minimum"] == pytest.approx(-speed, rel=1e-13)
    with pytest.raises(mb.InputError, match=r"known up to 2\.5 s"):
        scene.run().motion(2.6)
