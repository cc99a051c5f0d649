"""The animation of switched motions: key frames at both sides of events, links with their engagements and limits, arrows, lists."""

import base64
from itertools import pairwise

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.python_models import result_of
from mbconstrained.page.animation import body_poses, key_frames
from mbconstrained.page.figure import figure_data
from mbconstrained.page.html import page_html
from tests.page.contents import HOSTILE, hermite
from tests.page.switched_motions import ball, driveline, hanging, rattle, stick_slip

LEVELS = {"open": 0, "closed": 2, "stuck": 2, "forward": 1, "backward": 1}


def animated(motion, **options):
    """The animation, its key frames and its figure."""
    given = result_of(motion, **options).animation
    frames = key_frames(given)
    return given, frames, figure_data(given.drawing, [frames], given.overlay)


@pytest.mark.parametrize("make, least", [(ball, 1e-12), (driveline, 1e-7), (stick_slip, 1e-5)])
def test_between_key_frames_the_picture_follows_kinks_at_events(make, least):
    motion = make()
    _, frames, _ = animated(motion)
    times = np.random.default_rng(3).uniform(0, motion.end, 300)
    near = [event.time + sign * 1e-7 for event in motion.events for sign in (-1, 1) if 1e-3 < event.time < motion.end]
    for time in (*times, *near):
        assert np.abs(hermite(frames, time) - motion(time)).max() <= least * np.abs(motion(times)).max()
    impact = next(event for event in motion.events if event.time > 0)
    at = int(np.flatnonzero(frames.times == impact.time)[0])
    assert frames.times[at - 1] == np.nextafter(impact.time, 0)
    assert np.allclose(frames.rates[:, at] - frames.rates[:, at - 1], impact.jump[1], atol=1e-9)


@pytest.mark.parametrize("make, kind", [(ball, "stop"), (stick_slip, "pad"), (hanging, "cable"), (driveline, "clutch")])
def test_links_light_up_exactly_while_the_solver_is_in_that_phase(make, kind):
    motion = make()
    _, _, figure = animated(motion)
    (link,) = (link for link in figure["links"] if link["kind"] == kind)
    begins = np.frombuffer(base64.b64decode(link["states"]["begins"]), "<f8")
    expected = [(begin, LEVELS[name]) for begin, name in motion.phases]
    expected = expected[:1] + [new for old, new in pairwise(expected) if new[1] != old[1]]
    assert list(zip(begins.tolist(), link["states"]["levels"])) == expected and len(expected) > 1


def test_both_sides_of_a_play_light_one_link_and_its_angle_is_magnified_with_a_note():
    motion = rattle()
    given, _frames, figure = animated(motion)
    (link,) = (link for link in figure["links"] if link["kind"] == "play")
    begins = np.frombuffer(base64.b64decode(link["states"]["begins"]), "<f8")
    for time in np.linspace(0.0, motion.end, 97):
        name = next(name for begin, name in reversed(motion.phases) if begin <= time)
        level = link["states"]["levels"][int(np.searchsorted(begins, time, side="right")) - 1]
        assert level == 2 * ("closed" in name)
    assert np.isclose(link["limits"][0] - link["limits"][1], 0.02 * given.drawing.turn_scale)
    assert link["magnification"] > 1 and f"drawn {link['magnification']:g} × as large" in given.drawing.note


@pytest.mark.parametrize("make, kind, side", [(ball, "stop", 0), (hanging, "cable", 1)])
def test_stops_and_cables_are_drawn_with_their_gap(make, kind, side):
    """At each event the drawn length is that at which the link closes; it is beyond while nothing acts."""
    motion = make()
    given, frames, figure = animated(motion)
    drawing = given.drawing
    number = next(i for i, link in enumerate(figure["links"]) if link["kind"] == kind)
    link, poses = figure["links"][number], body_poses(drawing, frames)
    ends = [
        poses[drawing.bodies[link[name]].name].positions + np.array(link[f"{name}_point"])[:, None] for name in ("start", "end")
    ]
    lengths, limit = np.linalg.norm(ends[1] - ends[0], axis=0), link["limits"][side]
    assert 0 < limit < lengths.max() + 1
    for event in motion.events:
        if "closed" in (event.before, event.after) or "impact" in event.text:
            assert np.interp(event.time, frames.times, lengths) == pytest.approx(limit, abs=1e-6)
    sign = 1 if side == 0 else -1
    open_frames = [
        motion.phases[np.searchsorted([t for t, _ in motion.phases], time, "right") - 1][1] == "open" for time in frames.times
    ]
    assert (sign * (lengths - limit)[open_frames] > -1e-6).all()


def test_cables_hang_down_and_masses_stand_on_their_contact_under_gravity():
    for make, upper, lower in ((hanging, "hook", "load"), (ball, "ball", "ground left of ball")):
        given, *_ = animated(make())
        rest = {body.name: np.array(body.rest) for body in given.drawing.bodies}
        from mbconstrained.page.drawing import matrix_of

        up = matrix_of(given.drawing.turn) @ (rest[upper] - rest[lower])
        assert up[2] > 0 and np.abs(up[:2]).max() < 1e-9


def test_impulses_are_arrows_with_the_solvers_sizes_and_events_are_listed_with_energies():
    motion = ball()
    given, _, _ = animated(motion)
    events = given.overlay.events
    assert [event.time for event in events] == [event.time for event in motion.events][: len(events)]
    for drawn, event in zip(events[:5], motion.events):
        (arrow,) = drawn.impulses
        assert (arrow.arrow.body, arrow.arrow.unit) == ("ball", "N s")
        assert arrow.size == event.impulses["contact ground-ball"] == pytest.approx(event.jump[1, 0], rel=1e-12)
        assert drawn.lines[0].endswith(f": {event.text}") and any("velocity of ball jumps" in line for line in drawn.lines)
        assert f"energy lost: {event.energy_lost:.6g} J" in drawn.lines
    rest = events[-1]
    assert not any("N s²" in line or line.startswith("ball jumps") for line in rest.lines), "rounding errors are no jumps"
    assert not motion.events[-1].jump[0].any() and not motion.events[-1].higher_impulses


def test_the_table_of_events_leads_to_their_times_and_its_names_are_escaped():
    model = mb.LumpedModel()
    model.mass("ball", 1.0), model.gravity(-9.81)
    model.contact("ground", "ball", gap=0.5, restitution=0.5, name=HOSTILE[:40])
    motion = model.assemble().solve({"ball": 0.5}, end=1.0)
    page = page_html(result_of(motion).page())
    assert HOSTILE[:40] not in page and "<h2>Events</h2>" in page
    for event in motion.events:
        assert f'<a href="#t={event.time!r}">{event.time:.9g}</a>' in page
    assert f"{motion.events[0].energy_lost:.6g}" in page


def test_slow_motion_at_events_is_chosen_by_the_option():
    box = '<input type="checkbox" id="slow" autocomplete="off"'
    for wanted in (False, True):
        page = page_html(result_of(ball(), slow_events=wanted).page())
        assert (f"{box} checked>" in page, f"{box}>" in page) == (wanted, not wanted)
    cart = mb.LumpedModel()
    cart.mass("cart", 1.0), cart.spring("ground", "cart", 4.0)
    page = page_html(result_of(cart.assemble().solve([1.0]), slow_events=True).page())
    assert box not in page and "class Stop" not in page, "nothing of it on pages without events"


def test_an_end_after_that_of_the_motion_is_refused():
    with pytest.raises(mb.InputError, match="known up to 2 s"):
        result_of(ball(), end=3.0)


def test_the_impulse_of_a_joint_stop_is_a_moment_about_the_joint_of_the_robot():
    from tests.robot.test_switching import pendulum

    robot = pendulum()
    motion = (
        robot.linearize(robot.equilibrium())
        .with_switches(mb.JointStop("hinge", restitution=0.7))
        .solve({"hinge": 0.02}, [1.2], end=3.0)
    )
    given, frames, _ = animated(motion)
    (first, *_), event = given.overlay.events, motion.events[0]
    (arrow,) = first.impulses
    assert (arrow.arrow.body, arrow.arrow.unit, arrow.arrow.turns) == ("rod", "N m s", True)
    assert arrow.size == pytest.approx([0.0, event.impulses["hinge stop lower"], 0.0], rel=1e-12)
    sides = np.flatnonzero(np.isclose(frames.times, event.time, rtol=1e-14, atol=0.0))
    assert len(sides) == 2, "a pose just before the stop and one just after it"
