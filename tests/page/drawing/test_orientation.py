"""Bodies that move along, or turn about, directions of their own in drawings that are made for models."""

import numpy as np
import pytest

from mbconstrained.models.lumped import LumpedModel
from mbconstrained.page.animation import Animation, body_poses, key_frames
from mbconstrained.page.automatic_drawing import lumped_drawing
from mbconstrained.page.content import PageContent
from mbconstrained.page.drawing import quaternions_of, rotated
from mbconstrained.page.html import write_page
from tests.page.browser import needs_chromium
from tests.page.contents import positions


def frame_of(body):
    return quaternions_of(np.array(body.rest_turn)[:, None])


def mixed():
    model = LumpedModel()
    for name in ("a", "b", "c"):
        model.mass(name, 1.0)
    model.inertia("wheel", 1.0)
    model.inertia("disc", 1.0)
    model.spring("ground", "a", stiffness=1.0, name="ka")
    model.spring("a", "b", stiffness=1.0, name="kb")
    model.spring("ground", "c", stiffness=1.0, name="kc")
    model.torsion_spring("ground", "wheel", stiffness=1.0, name="kw")
    model.gear("wheel", "disc", 20.0, 40.0)
    return model


WAYS = {"b": (0.0, 0.0, 1.0), "c": (1.0, 1.0, 0.0), "wheel": (0.0, 0.0, 1.0), "disc": (0.0, 0.0, 1.0)}


def test_bodies_go_ways_of_their_own_and_what_holds_them_is_turned_with_them():
    model = mixed()
    usual = lumped_drawing(model.elements, model.coordinates)
    drawing = lumped_drawing(model.elements, model.coordinates, directions=WAYS)
    found, before = ({body.name: body for body in each.bodies} for each in (drawing, usual))
    for name, way in WAYS.items():
        motion = {**found[name].moves, **found[name].turns}[name]
        assert motion == pytest.approx(np.array(way) / np.linalg.norm(way), abs=1e-12)
        old = {**before[name].moves, **before[name].turns}[name]
        turned = rotated(frame_of(found[name]), rotated(inverse(frame_of(before[name])), np.array(old)[:, None])[:, :, 0])
        assert turned[:, 0, 0] == pytest.approx(motion, abs=1e-12)  # the body itself as well: a wheel's axis is its motion's
    assert found["a"].moves == before["a"].moves and found["a"].rest_turn == (0.0, 0.0, 0.0)
    for one, other in (("ground left of c", "c"), ("ground at wheel", "wheel"), ("wheel", "disc")):
        was, now = (np.subtract(each[other].rest, each[one].rest) for each in (before, found))
        local = rotated(inverse(frame_of(found[one])), now[:, None]), rotated(inverse(frame_of(before[one])), was[:, None])
        assert local[0] == pytest.approx(local[1], abs=1e-12)
    assert {link.name: any(link.turn) for link in drawing.links} == {"ka": False, "kb": False, "kc": True, "kw": True}


def inverse(quaternion):
    return quaternion * np.array([[-1.0], [-1.0], [-1.0], [1.0]])


def test_a_body_rests_at_its_natural_place_whichever_way_it_goes():
    model = LumpedModel()
    model.mass("lift", 1.0)
    model.spring("ground", "lift", stiffness=1.0, rest_length=0.3)
    values = np.array([[0.2, 0.4]])
    ends = []
    for directions in (None, {"lift": (0.0, 0.0, 1.0)}):
        drawing = lumped_drawing(model.elements, ["lift"], values, directions=directions)
        wall, lift = drawing.bodies
        ends.append(np.linalg.norm(positions(drawing, lift, ["lift"], values) - np.array(wall.rest)[:, None], axis=0))
    assert ends[1] == pytest.approx(ends[0])


@needs_chromium
def test_wheels_about_an_axis_of_their_own_turn_about_it_and_their_spring_winds(browser, tmp_path):
    model = LumpedModel()
    model.inertia("a", 1.0)
    model.inertia("b", 1.0)
    model.torsion_spring("ground", "a", stiffness=1.0)
    model.torsion_spring("a", "b", stiffness=1.0)
    values = np.array([[0.0, 0.9], [0.0, -0.4]])
    drawing = lumped_drawing(model.elements, ["a", "b"], values, directions={"a": (1, 1, 0), "b": (1, 1, 0)})
    content = PageContent("t", animation=Animation(drawing, ("a", "b"), [0, 1], values))
    state = browser.open(write_page(tmp_path / "page.html", content), "#t=1").state()
    assert (browser.messages, state["errors"]) == ([], [])
    frames = key_frames(Animation(drawing, ("a", "b"), [0, 1], values))
    for name, pose in body_poses(drawing, frames).items():
        assert state["nodes"][name]["position"] == pytest.approx(pose.positions[:, 1])
        assert state["nodes"][name]["quaternion"] == pytest.approx(pose.quaternions[:, 1])
    link = 'window.mbconstrained.viewer.scene_tree.find(["mbconstrained", "links", "link 0"])'
    turn = quaternions_of(np.array(drawing.links[0].turn)[:, None])[:, 0]
    assert browser.evaluate(f"{link}.object.quaternion.toArray()") == pytest.approx(turn)
