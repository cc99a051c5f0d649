"""Rigid bars are drawn as one body that stays on its points, with its supports below where they act."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.page.automatic_drawing import lumped_drawing
from tests.page.contents import positions


def bar(points, *, by_rows=False) -> mb.LumpedModel:
    """A bar with a spring and a damper to the ground under each point; as an element, or made by constraint rows."""
    model = mb.LumpedModel()
    if by_rows:
        model.inertia("pitch", 2.0)
        model.mass("bounce", 3.0)
        for point, distance in points.items():
            model.node(point)
            model.constrain({point: 2.0, "bounce": -2.0, "pitch": -2.0 * distance})
    else:
        model.rigid_bar("bounce", 3.0, inertia=2.0, points=points)
    for point in points:
        model.spring("ground", point, 4.0)
        model.damper(point, "ground", 1.0)
    return model


@pytest.mark.parametrize("by_rows", [False, True])
@pytest.mark.parametrize("points", [{"rear": -1.5, "front": 1.2}, {"a": -0.1, "b": 0.4, "c": 0.2}, {"only": 0.5}])
def test_a_bar_stays_on_its_points(points, by_rows):
    model = bar(points, by_rows=by_rows)
    names, angle = model.coordinates, "pitch" if by_rows else "bounce angle"
    state = {"bounce": 0.02, angle: 1e-4} | {name: 0.02 + 1e-4 * d for name, d in points.items()}
    values = np.array([[0.0, state[name]] for name in names])
    drawing = lumped_drawing(model.elements, names, values)
    (drawn,) = [body for body in drawing.bodies if body.shape == "solids"]
    assert drawn.name == "bounce" and not drawing.note
    turn = drawing.turn_scale * drawn.turns[angle][1] * 1e-4  # about y, clockwise for the viewer
    middle = positions(drawing, drawn, names, values)
    for body in drawing.bodies:
        if body.name in points:
            moved = np.diff(positions(drawing, body, names, values) - middle).ravel()
            arm = body.rest[0] - drawn.rest[0]
            assert moved == pytest.approx([0, 0, -arm * np.sin(turn)], abs=1e-6)
    grounds = [body for body in drawing.bodies if body.shape == "ground"]
    places = {body.name: body.rest for body in drawing.bodies}
    assert [ground.rest[0] for ground in grounds] == pytest.approx([places[name][0] for name in points])
    assert all(ground.rest[2] < drawn.rest[2] - 1 for ground in grounds)
    joined = {link.start for link in drawing.links} | {link.end for link in drawing.links} | {"bounce"}
    assert joined == {body.name for body in drawing.bodies}


def shaft(*, common=False) -> mb.LumpedModel:
    """Two rotors in two bearings with a disc that does not tilt between them; on request with the bearings in one housing."""
    model = mb.LumpedModel()
    model.rotor("compressor", 3.0, diametral_inertia=2.0, polar_inertia=1.0, points={"left": -0.3, "inner": 0.2})
    model.rotor("disc", 1.0)
    model.rotor("turbine", 3.0, diametral_inertia=2.0, points={"near": -0.2, "right": 0.3})
    model.bearing("inner", "disc", stiffness=2.0), model.bearing("disc", "near", stiffness=2.0)
    support = "ground"
    if common:
        support = "housing"
        model.mass("housing y", 9.0), model.mass("housing z", 9.0)
        model.bearing("ground", "housing", stiffness=5.0)
    for point in ("left", "right"):
        model.bearing(support, point, stiffness=[4.0, 3.0], damping=1.0)
    return model


@pytest.mark.parametrize("common", [False, True])
def test_a_rotor_is_one_shaft_that_stays_on_its_points_in_both_planes(common):
    model = shaft(common=common)
    names = model.coordinates
    state = dict.fromkeys(names, 0.0)
    for plane, centre, tilt in (("y", 0.02, 1e-4), ("z", -0.01, -3e-4)):
        state |= {f"compressor {plane}": centre, f"compressor {plane} angle": tilt, f"disc {plane}": centre}
        state |= {f"left {plane}": centre - 0.3 * tilt, f"inner {plane}": centre + 0.2 * tilt}
    values = np.array([[0.0, state[name]] for name in names])
    drawing = lumped_drawing(model.elements, names, values)
    drawn = {body.name: body for body in drawing.bodies}
    assert [body.name for body in drawing.bodies if body.shape == "solids"] == ["compressor", "disc", "turbine"]
    assert {name for body in drawing.bodies for name in (*body.moves, *body.turns)} == set(names) and not drawing.note
    rotor = drawn["compressor"]
    middle = positions(drawing, rotor, names, values)
    turn = drawing.turn_scale * sum(np.multiply(vector, state[name]) for name, vector in rotor.turns.items())
    for point in ("left y", "left z", "inner y", "inner z"):
        moved = np.diff(positions(drawing, drawn[point], names, values) - middle).ravel()
        arm = np.array([drawn[point].rest[0] - rotor.rest[0], 0.0, 0.0])
        assert moved == pytest.approx(np.cross(turn, arm), abs=1e-12)  # a rotation to first order, as the model's
    places = [drawn[name].rest[0] for name in ("left z", "compressor", "inner z", "disc z", "near z", "turbine", "right z")]
    assert places == sorted(places) and len({drawn[name].rest[1:] for name in ("compressor", "disc", "turbine")}) == 1
    assert all(
        drawn[f"{name} y"].rest[1] > rotor.rest[1] and drawn[f"{name} z"].rest[2] < rotor.rest[2] for name in ("left", "disc")
    )
    grounds = np.array([body.rest for body in drawing.bodies if body.shape == "ground"]) - rotor.rest
    assert ((grounds[:, 1] > 1) != (grounds[:, 2] < -1)).all() and len(grounds) == 2 * (1 if common else 2)


def test_rotors_on_flexible_parts_are_one_bent_shaft_through_all_their_points():
    model = shaft()
    drawing = lumped_drawing(model.elements, model.coordinates, np.zeros((len(model.coordinates), 1)))
    drawn = {body.name: body for body in drawing.bodies}
    (bent,) = [link for link in drawing.links if link.kind == "shaft"]
    places = [drawn[body].rest[0] + point[0] for body, point, _ in bent.stations]
    assert places == sorted(places)
    through = [drawn[f"{name} z"].rest[0] for name in ("left", "inner", "disc", "near", "right")]
    assert set(np.round(through, 9)) <= set(np.round(places, 9))
    assert {body for body, _, tilts in bent.stations if not tilts} == {"disc"}  # it has no diametral inertia
    assert places[0] < drawn["left z"].rest[0] and places[-1] > drawn["right z"].rest[0]
    rotors = ("compressor", "disc", "turbine")
    assert not [link for link in drawing.links if link is not bent and "ground" not in link.start + link.end]
    assert {name for name, body in drawn.items() if body.traced} == set(rotors) and not drawing.note
    assert [point[0] for point in drawn["compressor"].traced] == pytest.approx(
        [0, drawn["left z"].rest[0] - drawn["compressor"].rest[0]]
    )


def test_the_disc_of_a_rotor_is_the_cylinder_with_its_moments_of_inertia():
    """A steel cylinder of 0.2 m radius and 0.3 m length between bearings at -0.5 m and 0.5 m: J_p = m r^2 / 2."""
    mass, radius, length = 30.0, 0.2, 0.3
    model = mb.LumpedModel()
    inertias = {"polar_inertia": mass * radius**2 / 2, "diametral_inertia": mass * (3 * radius**2 + length**2) / 12}
    model.rotor("rotor", mass, **inertias, points={"A": -0.5, "B": 0.5})
    for point in ("A", "B"):
        model.bearing("ground", point, stiffness=1e6)
    drawing = lumped_drawing(model.elements, model.coordinates, np.zeros((len(model.coordinates), 1)))
    drawn = {body.name: body for body in drawing.bodies}
    scale = (drawn["B z"].rest[0] - drawn["A z"].rest[0]) / 1.0
    disc, *bearings = drawn["rotor"].solids
    assert disc.size == pytest.approx((radius * scale, length * scale))
    assert sorted({round(solid.placement[0, 3] / scale, 9) for solid in bearings}) == [-0.5, 0.5]
