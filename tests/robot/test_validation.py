"""Validation: invalid arguments raise errors that name the place, what was found, and the nearest known name."""

import re
from itertools import pairwise

import numpy as np
import pytest

import mbconstrained as mb
from tests.robot import linkages
from tests.robot.linkages import GROUND, PLANE, bar, given, joint, link, urdf

P = given("four-bar")
TEXT = linkages.four_bar_text(P)
GUESS = dict(zip(("j1", "j2", "j3"), P["guess"]))
LOOP = linkages.four_bar_loop(P)
NAN = float("nan")


def swing(body=None, **options) -> str:
    """One link on one joint."""
    return urdf(GROUND, body or bar("bob", 1, 1), joint("swing", "frame", "bob", **options))


def refused(text: str):
    return pytest.raises(mb.InputError, match=f"(?s){text}")


BODIES = {
    "not XML": ('<robot name="x"><link', "not XML"),
    "something else": ("<sdf/>", "sdf.*no <link>"),
    "MJCF": ("<mujoco/>", "give the path of the file, which ends in .xml"),
    "xacro": (
        '<robot xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="a"/><link name="a"/></robot>',
        "xacro robot.xacro > robot.urdf",
    ),
    "no links": ('<robot name="x"/>', "(no <link>|0 links)"),
    "no joints": ('<robot name="x"><link name="a"/></robot>', "no joint that moves"),
    "only fixed joints": (swing(kind="fixed"), "no joint that moves"),
    "entities": ('<!DOCTYPE r [<!ENTITY a "aaaaaaaa"><!ENTITY b "&a;&a;&a;&a;">]><robot name="&b;"/>', "entity"),
    "outer entities": ('<!DOCTYPE r [<!ENTITY a SYSTEM "file:///etc/hostname">]><robot name="&a;"/>', "entity"),
    "two links of one name": (urdf(GROUND, bar("bob", 1, 1), bar("bob", 1, 1), joint("a", "frame", "bob")), '<link>.*"bob"'),
    "two joints of one name": (
        urdf(GROUND, bar("a", 1, 1), bar("b", 1, 1), joint("j", "frame", "a"), joint("j", "a", "b")),
        '<joint>.*"j"',
    ),
    "two parents": (urdf(GROUND, bar("a", 1, 1), joint("j", "frame", "a"), joint("k", "frame", "a")), '"a".*two joints'),
    "two roots": (urdf(GROUND, bar("a", 1, 1), bar("b", 1, 1), joint("j", "frame", "a")), "no parent"),
    "a circle": (urdf(bar("a", 1, 1), bar("b", 1, 1), joint("j", "a", "b"), joint("k", "b", "a")), "circle"),
    "a circle of its own": (
        urdf(GROUND, bar("a", 1, 1), *map(link, "bc"), joint("j", "frame", "a"), joint("k", "b", "c"), joint("l", "c", "b")),
        '"b", "c" go round in a circle',
    ),
    "a child that is no link": (urdf(GROUND, bar("bob", 1, 1), joint("swing", "frame", "bobb")), '"swing".*"bobb"'),
    "a kind of joint that does not exist": (swing(kind="revolut"), '"swing".*"revolut".*did you mean "revolute"'),
    "an axis of no length": (swing(axis=(0, 0, 0)), 'joint "swing".*axis'),
    "an axis that is not finite": (swing(axis=(0, 0, NAN)), 'joint "swing".*axis'),
    "a place that is not finite": (swing(at=(0, NAN, 0)), 'joint "swing".*(origin|xyz)'),
    "limits in the wrong order": (swing(limits=(1.0, -1.0)), 'joint "swing".*limit'),
    "limits that are one": (swing(limits=(0.5, 0.5)), "lock the joint"),
    "a joint that follows itself": (swing().replace("</joint>", '<mimic joint="swing"/></joint>'), '"swing".*mimic'),
    "a ratio that is not finite": (
        urdf(GROUND, bar("a", 1, 1), bar("b", 1, 1), joint("j", "frame", "a"), joint("k", "frame", "b")).replace(
            "</joint></robot>", '<mimic joint="j" multiplier="nan"/></joint></robot>'
        ),
        '"k".*mimic.*multiplier',
    ),
    "a planar joint across another axis": (swing(kind="planar", axis=(0, 1, 0)), 'joint "swing".*planar'),
    "a mass that is not finite": (swing(link("bob", NAN)), '"bob".*mass'),
    "a mass below zero": (swing(link("bob", -1.0)), '"bob".*mass'),
    "an inertia that is not finite": (swing(link("bob", 1.0, (0, 0, 0), (1, 1, np.inf))), '"bob".*inertia'),
    "a mass without inertia": (swing('<link name="bob"><inertial><mass value="1"/></inertial></link>'), '"bob".*inertia'),
    "inertia without a mass": (swing(link("bob", 1.0, (0, 0, 0), (1, 1, 1)).replace('<mass value="1.0"/>', "")), '"bob".*mass'),
    "a comma for a point": (swing().replace('xyz="0.0 0.0 0.0"', 'xyz="0,5 0 0"', 1), 'joint "swing".*0,5'),
    "a place of two numbers": (swing().replace('xyz="0.0 0.0 0.0"', 'xyz="0.5 0"', 1), 'joint "swing".*0.5 0'),
    "damping below zero": (swing(damping=-2.0), "damping"),
    "something not filled in": (TEXT.replace('"0.6"', '"${mass}"', 1), '"crank".*mass'),
    "no text": ("", "urdf"),
    "no file": ("nowhere/arm.urdf", "arm.urdf"),
}


@pytest.mark.parametrize("what", BODIES)
def test_urdf(what, capfd):
    text, message = BODIES[what]
    with refused(message):
        mb.Robot(text)
    assert capfd.readouterr() == ("", ""), "libraries below do not speak to the terminal"


def linearized(**options):
    robot = mb.Robot(TEXT, loops=[LOOP], gravity=PLANE, joint_stiffness={"j1": 25.0}, joint_rest={"j1": 1.3})
    return robot.linearize(robot.equilibrium(GUESS), **options)


PENDULUM = urdf(GROUND, link("rod", 2.0, (0, 0, -0.5), (0.1, 0.1, 0)), joint("j1", "frame", "rod", "continuous", axis=(0, 1, 0)))

REFUSED = {
    "joint_stiffness": (lambda: mb.Robot(TEXT, joint_stiffness={"j11": 1}), 'joint_stiffness.*"j11".*"j1"'),
    "joint_rest": (lambda: mb.Robot(TEXT, joint_rest={"j22": 1}), 'joint_rest.*"j22".*"j2"'),
    "joint_damping": (lambda: mb.Robot(TEXT, joint_damping={"j33": 1}), 'joint_damping.*"j33".*"j3"'),
    "locked": (lambda: mb.Robot(TEXT, locked={"j11": 1}), 'locked.*"j11".*"j1"'),
    "flexible": (lambda: mb.Robot(TEXT, flexible_joints={"j11": mb.FlexibleJoint(1)}), 'flexible.*"j11".*"j1"'),
    "guess": (lambda: mb.Robot(TEXT).equilibrium({"j11": 1}), 'guess.*"j11".*"j1"'),
    "hold": (lambda: mb.Robot(TEXT).equilibrium(hold=["j11"]), 'hold.*"j11".*"j1"'),
    "forces": (lambda: mb.Robot(TEXT).equilibrium(forces={"j11": 1}), 'forces.*"j11".*"j1"'),
    "force on a body": (lambda: mb.Robot(TEXT).equilibrium(forces={mb.PointMotion("crnk"): 1}), '"crnk".*"crank"'),
    "loop": (lambda: mb.Robot(TEXT, loops=[mb.Loop("copler", (0, 0, 0), "rocker", name="pin")]), 'loop "pin".*"copler".*"coupler"'),
    "other end": (
        lambda: mb.Robot(TEXT, loops=[mb.Loop("rocker", (0, 0, 0), "copler", name="pin")]),
        'loop "pin".*"copler".*"coupler"',
    ),
    "spring": (
        lambda: mb.Robot(TEXT, springs=[mb.BodySpring("crank", (0, 0, 0), "rckr", (0, 0, 0), stiffness=1)]),
        'spring.*"rckr".*"rocker"',
    ),
    "base": (lambda: mb.Robot(TEXT, base="fixd"), 'base.*"fixed"'),
    "kind": (lambda: mb.Loop("a", (0, 0, 0), "b", kind="hing"), '"hinge"'),
    "base of a robot that stands": (lambda: mb.Robot(TEXT).equilibrium({"base": (0,) * 6}), 'guess.*"base"'),
    "input": (lambda: linearized(inputs={"push": "j9"}), '"push".*j9'),
    "output": (lambda: linearized(outputs={"seen": mb.PointMotion("crnk")}), '"seen".*"crnk".*"crank"'),
    "level": (lambda: linearized(level="positon"), '"positon".*"position"|positon'),
    "name of a force": (lambda: linearized(inputs={"push": "j1"}).input_force({"pull": mb.step([1.0])}), '"pull"'),
    "rows of a force": (lambda: linearized(inputs={"push": "j1"}).input_force({"push": mb.step([1.0, 2.0])}), '"push".*one row'),
    "input with the name of a coordinate": (lambda: linearized(inputs={"j1": "j1"}), "name of a coordinate"),
    "joint of a posture": (lambda: linearized().posture["j11"], 'did you mean "j1"'),
    "locked joint": (lambda: mb.Robot(TEXT, locked={"j1": 0.3}, joint_stiffness={"j1": 3.0}), '"j1".*locked'),
    "posture of another robot": (lambda: mb.Robot(PENDULUM).linearize(mb.Robot(PENDULUM).equilibrium()), "posture"),
    "URDF of another kind": (lambda: mb.Robot(3), "urdf.*int"),
    "hold of another kind": (lambda: mb.Robot(PENDULUM).equilibrium(hold=5), "hold: found 5"),
    "list of flexible joints": (lambda: mb.Robot(PENDULUM, flexible_joints=[1]), "flexible_joints: found list"),
    "folders in one text": (lambda: mb.Robot(PENDULUM, package_dirs="abc"), "package_dirs"),
    "folders of another kind": (lambda: mb.Robot(PENDULUM, package_dirs=[5]), "package_dirs"),
    "body of a point": (lambda: mb.PointMotion(["b"]), "name of a link"),
    "turn of a point": (lambda: mb.PointMotion("b", turn="false"), "turn"),
    "body1": (lambda: mb.Loop(1, (0, 0, 0), "ground"), "body1"),
    "body2": (lambda: mb.Loop("rod", (0, 0, 0), None), "body2"),
    "half a frame": (lambda: mb.Loop("rod", (0, 0, 0), "ground", rotation2=(1, 0, 0)), "rotation2 without point2"),
    "displacements": (lambda: (robot := mb.Robot(PENDULUM)).poses(robot.equilibrium(), np.zeros((0, 3))), "found 0 rows"),
    "rest without a spring": (lambda: mb.Robot(PENDULUM, joint_rest={"j1": 1.0}), "no joint_stiffness"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_makes_no_sense_is_refused_in_words(what):
    call, message = REFUSED[what]
    with refused(message):
        call()


NUMBERS = {
    "gravity": lambda: mb.Robot(TEXT, gravity=(0, NAN, 0)),
    "gravity of two numbers": lambda: mb.Robot(TEXT, gravity=(0, 1)),
    "stiffness": lambda: mb.Robot(TEXT, joint_stiffness={"j1": NAN}),
    "stiffness below zero": lambda: mb.Robot(TEXT, joint_stiffness={"j1": -1}),
    "rest": lambda: mb.Robot(TEXT, joint_rest={"j1": NAN}),
    "damping": lambda: mb.Robot(TEXT, joint_damping={"j1": NAN}),
    "damping below zero": lambda: mb.Robot(TEXT, joint_damping={"j1": -1}),
    "locked": lambda: mb.Robot(TEXT, locked={"j1": NAN}),
    "point": lambda: mb.Loop("a", (0, NAN, 0), "b"),
    "point of two numbers": lambda: mb.Loop("a", (0, 0), "b"),
    "turned": lambda: mb.Loop("a", (0, 0, 0), "b", rotation1=(NAN, 0, 0)),
    "axis": lambda: mb.Loop("a", (0, 0, 0), "b", kind="hinge", axis=(0, 0, 0)),
    "one body": lambda: mb.Loop("a", (0, 0, 0), "a"),
    "spring": lambda: mb.BodySpring("a", (0, 0, 0), "b", (0, 0, 1), stiffness=NAN),
    "spring below zero": lambda: mb.BodySpring("a", (0, 0, 0), "b", (0, 0, 1), stiffness=-1),
    "rest length": lambda: mb.BodySpring("a", (0, 0, 0), "b", (0, 0, 1), stiffness=1, rest_length=-1),
    "rest length and preload": lambda: mb.BodySpring("a", (0, 0, 0), "b", (0, 0, 1), stiffness=1, rest_length=1, preload=2),
    "preload of nothing": lambda: mb.BodySpring("a", (0, 0, 0), "b", (0, 0, 1), stiffness=0, preload=2),
    "bushing": lambda: mb.Bushing("a", (0, 0, 0), "b", stiffness=(1, 2, NAN)),
    "bushing below zero": lambda: mb.Bushing("a", (0, 0, 0), "b", stiffness=(1, 2, -3)),
    "flexible joint": lambda: mb.FlexibleJoint(NAN),
    "flexible joint of no stiffness": lambda: mb.FlexibleJoint(0),
    "gear of no ratio": lambda: mb.FlexibleJoint(1, gear_ratio=0),
    "direction": lambda: mb.PointMotion("a", along=(0, 0, 0)),
    "guess": lambda: mb.Robot(TEXT).equilibrium({"j1": NAN}),
    "guess in numbers": lambda: mb.Robot(TEXT).equilibrium(np.zeros(7)),
    "force": lambda: mb.Robot(TEXT).equilibrium(forces={"j1": NAN}),
    "base of three numbers": lambda: mb.Robot(swing(), base="free").equilibrium({"base": (0, 0, 1)}),
    "base of no direction": lambda: mb.Robot(swing(), base="free").equilibrium({"base": (0,) * 7}),
    "loops of another kind": lambda: mb.Robot(TEXT, loops=[("crank", (0, 0, 0), "rocker")]),
    "one loop, not in a list": lambda: mb.Robot(TEXT, loops=LOOP) and pytest.fail("accepted: then it must be one loop"),
    "springs of another kind": lambda: mb.Robot(TEXT, springs=[LOOP]),
    "flexible joints of another kind": lambda: mb.Robot(TEXT, flexible_joints={"j1": 3.0}),
}


@pytest.mark.parametrize("what", NUMBERS)
def test_numbers_and_kinds(what):
    with pytest.raises(mb.InputError):
        NUMBERS[what]()


def test_names_that_would_be_said_twice():
    with refused('"base x"|"base"'):  # the coordinates of a free base have these names
        mb.Robot(urdf(bar("frame", 1, 1), bar("bob", 1, 1), joint("base x", "frame", "bob")), base="free")
    robot = mb.Robot(urdf(GROUND, bar("ground", 1, 1), joint("swing", "frame", "ground")))  # "ground" is what does not move
    assert robot.bodies == ("frame", "ground link")
    assert 'the link "ground" is called "ground link" here' in robot.description_notices[0].text


# ---------------------------------------------------------------- equilibrium


def test_no_equilibrium_near_the_guess():
    with refused("equilibrium.*none near"):
        mb.Robot(TEXT, gravity=PLANE).equilibrium(forces={"j1": 1000.0})
    with refused("equilibrium.*none near"):
        mb.Robot(swing(), gravity=0).equilibrium(forces={"swing": 1.0})
    with refused("equilibrium.*none near"):
        mb.Robot(swing(), base="free").equilibrium()


@pytest.mark.parametrize("angle", [-1.4, 0.0, 1e-9, -np.pi / 2, 2.0])
def test_rest_without_any_spring(angle):
    # at rest nothing acts on the joint at all: no scale for what is left but that of the weight elsewhere
    robot = mb.Robot(swing(), gravity=PLANE)
    posture = robot.equilibrium({"swing": angle})
    assert np.cos(posture.joints["swing"]) == pytest.approx(0, abs=1e-12)


def test_rest_where_no_force_acts():
    robot = mb.Robot(swing(), gravity=0)
    posture = robot.equilibrium({"swing": 0.7})
    assert posture.joints["swing"] == pytest.approx(0.7, abs=1e-15) and posture.residual == 0


def test_loops_that_cannot_close():
    short = mb.Loop("coupler", (0.1, 0, 0), "ground", (5, 0, 0), name="far away")
    with refused("far away.*open by"):
        mb.Robot(TEXT, loops=[short], gravity=PLANE).equilibrium(GUESS)
    with refused("closure.*open by"):
        mb.Robot(TEXT, loops=[LOOP], gravity=PLANE).equilibrium(GUESS, hold="all")


def test_loops_that_contradict_each_other():
    other = mb.Loop(LOOP.body1, LOOP.point1, LOOP.body2, (0.6, 0, 0), name="other")
    with refused("(closure|other).*open by"):
        mb.Robot(TEXT, loops=[LOOP, other], gravity=PLANE).equilibrium(GUESS)


@pytest.mark.parametrize(
    ("moments", "text", "doubtful"),
    [
        ((1, -1, 1), "of which one is negative", True),
        ((1, 1, 1, 3, 0, 0), "of which one is negative", True),
        ((1, -1e-8, 1), "rounded zeros below zero", False),
        ((9e-8, -4e-8, 4e-8), "too small to matter", False),  # next to the 1 kg m^2 of the frame, as antennas of 1 mg of TIAGo
        ((5e-20, 5e-21, 4e-20), None, False),
        ((-2e-41, -2e-41, -2e-41), "rounded zeros below zero", False),
        ((1, 0.4, 0.5), "exceeds the sum of the others", False),
        ((1, 0.4, 0.599), None, False),
        ((1, 0, 1), None, False),
    ],
)
def test_inertias_that_no_body_has_are_reported_for_all_links_at_once(moments, text, doubtful):
    parts = [link(name, 1.0, (0, 0, 0), moments) for name in ("first", "second", "third", "fourth")]
    names = ["frame", "first", "second", "third", "fourth"]
    joints = [joint(f"j{i}", *ends) for i, ends in enumerate(pairwise(names))]
    notices = mb.Robot(urdf(link("frame", 1.0, (0, 0, 0), (1, 1, 1)), *parts, *joints)).description_notices
    assert [(text in notice.text, "and 1 more" in notice.text, notice.doubtful) for notice in notices] == [
        (True, True, doubtful)
    ] * bool(text)


def test_a_robot_that_nothing_carries_is_told_which_force_is_without_balance():
    body = urdf(link("box", 4.0, (0, 0, 0), (1, 1, 1)))
    with refused("39.24 N on base z stay without balance"):
        mb.Robot(body, base="free").equilibrium()
    assert not mb.Robot(body, base="free", gravity=0).equilibrium().residual


def test_a_robot_without_masses_is_noted_in_these_words():
    (notice,) = mb.Robot('<robot name="r"><link name="a"/><link name="b"/>' + joint("j", "a", "b") + "</robot>").description_notices
    assert "no link has an <inertial>" in notice.text


def test_a_mimic_joint_without_its_leader_moves_by_itself():
    text = swing().replace("</joint>", '<mimic joint="nobody"/></joint>')
    robot = mb.Robot(text)
    assert not robot.mimic_rows and '"swing" (of "nobody")' in robot.description_notices[0].text


def test_coordinates_of_joints_with_several_degrees_of_freedom_have_names():
    robot = mb.Robot(
        urdf(bar("frame", 1, 1), bar("bob", 1, 1), joint("swing", "frame", "bob")), base="free", joint_damping={"base rx": 3.0}
    )
    posture = robot.equilibrium({"swing": 0.2}, hold=robot.coordinates)
    assert set(posture.torques) == set(robot.coordinates)
    assert posture.torques["base z"] == pytest.approx(2 * 9.81)
    assert robot.joint_damping[robot.coordinates.index("base rx")] == 3.0


def parallelogram(gravity):
    p = {"masses": [0.4, 1.5, 0.4], "lengths": [0.5, 1.0, 0.5], "end": [1.0, 0.0], "guess": [0.0, 0.0, np.pi]}
    described = linkages.hanging_four_bar(p)
    described.options["gravity"] = gravity
    return described


@pytest.mark.parametrize("gravity", [(9.81, 0, 0), (0, -9.81, 0), (0, 0, 0)])
@pytest.mark.parametrize(("hold", "off"), [(["j1"], 0.0), (["j1"], 0.1), ("all", 0.0)])
def test_flattened_parallelogram(gravity, hold, off):
    # with its crank along the base it can open in two ways: the linear equations know neither
    robot, guess = parallelogram(gravity)
    with refused("(?=.*singular)(?=.*hook)"):
        robot.equilibrium({**guess, "j2": off}, hold=hold)


@pytest.mark.parametrize("along", [9.81, -9.81])
def test_four_bar_stretched_to_a_line(along):
    # 0.5 + 0.7 = 1.2: it can not move at all but for the flat posture, which the linear equations call a motion
    p = {"masses": [0.4, 1.0, 0.4], "lengths": [0.5, 0.4, 0.3], "end": [1.2, 0.0], "guess": [0.0, 0.0, 0.0]}
    described = linkages.hanging_four_bar(p)
    described.options["gravity"] = (along, 0, 0)
    robot, guess = described
    with refused("(?=.*singular)(?=.*hook)"):
        robot.equilibrium(guess)


@pytest.mark.parametrize("near", [1e-6, 1e-7, 1e-8, 1e-9])
def test_no_answer_is_invented_near_a_flattened_parallelogram(near):
    # the only parallelogram with its crank at this angle has j2 = -j1; other postures close the loop to 1e-11 only
    robot, _ = parallelogram((0, -9.81, 0))
    try:
        posture = robot.equilibrium({"j1": near, "j2": -near, "j3": np.pi + near}, hold=["j1"])
    except mb.InputError as refusal:
        assert "hook" in str(refusal)
    else:
        assert any(notice.doubtful for notice in posture.notices)


def test_posture_near_a_singular_one_is_in_doubt():
    robot, _ = parallelogram((0, 0, 0))
    with pytest.raises(mb.InputError, match="posture is singular"):
        robot.equilibrium({"j1": 1e-7, "j2": -1e-7, "j3": np.pi + 1e-7}, hold=["j1"])
    posture = robot.equilibrium({"j1": 5e-5, "j2": -5e-5, "j3": np.pi + 5e-5}, hold=["j1"])
    assert [notice.kind for notice in posture.notices if notice.doubtful] == ["rank"]


# ---------------------------------------------------------------- redundant loops


def frequencies(loops):
    robot = mb.Robot(TEXT, loops=loops, gravity=PLANE, joint_stiffness={"j1": P["stiffness"]}, joint_rest={"j1": P["rest"]})
    posture = robot.equilibrium(GUESS)
    return posture, robot.linearize(posture).modes().natural_frequencies


def test_planar_loop_has_a_row_too_many():
    posture, found = frequencies([LOOP])
    (notice,) = posture.notices
    assert notice.kind == "redundant" and "closure z" in notice.text
    assert found == pytest.approx(linkages.known_frequencies("four-bar"), rel=1e-9)


@pytest.mark.parametrize(
    "again", [LOOP, mb.Loop("rocker", LOOP.point2, "coupler", LOOP.point1, name="back"), linkages.four_bar_loop(P, kind="hinge")]
)
def test_a_loop_said_twice(again):
    posture, found = frequencies([LOOP, again])
    assert {notice.kind for notice in posture.notices} == {"redundant"}
    assert found == pytest.approx(linkages.known_frequencies("four-bar"), rel=1e-9)
    names = list(posture.reactions)
    assert len(names) == len(set(names)) == 2
    total = sum(np.linalg.norm(reaction[:3]) for reaction in posture.reactions.values())
    (alone,) = frequencies([LOOP])[0].reactions.values()
    assert total == pytest.approx(np.linalg.norm(alone[:3]), rel=1e-9)  # least norm: each carries a half


def test_parallelogram_with_a_third_crank():
    # more rows than a plane mechanism can have, and it moves: w^2 = g (m + 3/2 mc) / (L (m + mc))
    mass, crank, length, places = 1.5, 0.4, 0.5, (0.0, 0.6, 1.0)
    cranks = [bar(f"crank {i}", crank, length) for i in range(3)]
    joints = [joint(f"j{i}", "frame", f"crank {i}", at=(x, 0, 0)) for i, x in enumerate(places)]
    coupler = link("coupler", mass, (0.5, 0, 0), (0.01, 0.1, 0.1))
    model = urdf(GROUND, *cranks, coupler, *joints, joint("pin", "crank 0", "coupler", at=(length, 0, 0)))
    loops = [mb.Loop(f"crank {i}", (length, 0, 0), "coupler", (places[i], 0, 0)) for i in (1, 2)]
    robot = mb.Robot(model, loops=loops, gravity=PLANE)
    posture = robot.equilibrium({"j0": -1.5, "j1": -1.5, "j2": -1.5, "pin": 1.5})
    assert {notice.kind for notice in posture.notices} == {"redundant"}
    found = robot.linearize(posture).modes().natural_frequencies
    assert found**2 == pytest.approx([9.81 * (mass + 1.5 * crank) / (length * (mass + crank))], rel=1e-9)


# ---------------------------------------------------------------- links without mass


def test_link_without_mass_on_a_spring_does_not_move_by_itself():
    robot = mb.Robot(swing(link("bob")), joint_stiffness={"swing": 2.0})
    assert len(robot.linearize(robot.equilibrium()).modes()) == 0


def test_link_without_mass_and_without_spring_is_reported():
    robot = mb.Robot(swing(link("bob")))
    with pytest.raises(mb.SingularPolynomialMatrix, match="swing"):
        robot.linearize(robot.equilibrium()).modes()


# ---------------------------------------------------------------- names, and what was given and not looked at


def test_where_a_robot_stands_does_not_matter():
    # four-bar far from its base's origin with a loop 11 mm open: still open
    for shift in (0.0, 1e4):
        robot = mb.Robot(TEXT, loops=[mb.Loop("coupler", (1.0, 0.02, 0), "ground", (shift, 5.0, 0))], gravity=PLANE)
        with pytest.raises(mb.InputError, match="do not close"):
            robot.equilibrium(GUESS, hold="all")


def test_sharing_between_fixed_joints_and_loops_is_reported():
    robot = mb.Robot(TEXT, loops=[LOOP], gravity=PLANE)
    alone = robot.equilibrium(GUESS)
    assert not any("share the load" in notice.text for notice in alone.notices)
    assert any("share the load" in notice.text for notice in robot.equilibrium(alone.joints, hold="all").notices)


def test_axis_of_a_hinge_may_be_tiny():
    assert mb.Loop("a", (0, 0, 0), "b", (0, 0, 0), kind="hinge", axis=(0, 1e-200, 0)).axis == (0, 1, 0)


def test_the_text_is_read_as_utf_8_whatever_it_declares():
    text = '<?xml version="1.0" encoding="latin-1"?>' + PENDULUM.replace("rod", "Stäb")
    assert "Stäb" in mb.Robot(text).bodies


def test_a_posture_far_from_the_guess_is_reported():
    robot = mb.Robot(PENDULUM)
    posture = robot.equilibrium({"j1": 2.0})
    assert posture["j1"] == pytest.approx(np.pi)  # Newton's method goes up, where it stands on its head
    assert [notice.kind for notice in posture.notices] == ["distant posture", "unstable"]
    assert not robot.equilibrium({"j1": 0.3}).notices


def test_impulse_on_a_floating_robot_with_a_loop_inside():
    """Its mass matrix has entries that are rounding: they must not decide in which units the equations are solved."""
    arms = [link(f"arm{i}", m, (0.3, 0, 0), (0.1, inertia, inertia)) for i, m, inertia in ((1, 9, 0.4), (2, 6, 0.3))]
    turned = {"turned": (1.1, 0.2, 0.3)}
    text = urdf(
        link("hull", 200, (0.1, 0.2, -0.1), (30, 60, 70, 1, 0, 2)), *arms, link("panel", 2, (0, -0.2, 0), (0.2, 0.1, 0.2)),
        joint("a1", "hull", "arm1", at=(0.5, 0.3, 0.1), **turned), joint("a2", "arm1", "arm2", at=(0.6, 0, 0)),
        joint("a3", "hull", "panel", at=(0.6, 0.5, 0.3), **turned),
    )  # fmt: skip
    loop = mb.Loop("arm2", (0.5, 0, 0), "panel", None)
    robot = mb.Robot(
        text, loops=[loop], base="free", gravity=0, joint_stiffness={"a1": 50.0, "a2": 20.0}, joint_rest={"a1": 0.9, "a2": 0.1}
    )
    system = robot.linearize(robot.equilibrium({"a1": 0.4, "a2": 0.3, "a3": 0.2}))
    push = np.array([float(name == "a1") for name in system.names])
    N = linkages.null_space(system.constraint_matrix)
    jump = N @ np.linalg.solve(N.T @ system.mass @ N, N.T @ push)
    motion = system.solve(force=mb.impulse(push))
    assert motion.jump[1] == pytest.approx(jump, rel=1e-9, abs=1e-12 * np.abs(jump).max())
    assert motion.velocity(1e-6) == pytest.approx(jump, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize("kind", ["point", "hinge", "rigid"])
@pytest.mark.parametrize("count", [1, 4])
def test_loops_that_cannot_close_are_named(kind, count):
    """A chain of ten links of 1 m, whose links i hang at points more than i m away: the i-th stays open by the difference at least."""
    parts = [joint(f"j{i}", f"l{i}", f"l{i + 1}", at=(1.0 if i else 0, 0, 0), axis=(0, i % 2, 1 - i % 2)) for i in range(10)]
    text = urdf(link("l0"), *(bar(f"l{i + 1}", 1.0, 1.0) for i in range(10)), *parts)
    ends = range(11 - count, 11)
    loops = [mb.Loop(f"l{i}", (1, 0, 0), "ground", (i + 2, 0, 1), kind=kind, name=f"hook {i}") for i in ends]
    with pytest.raises(
        mb.InputError, match=r"the loops do not close near the guess: hook \d+ [xyz1-3a-z ]+ stays open by"
    ) as refusal:
        mb.Robot(text, loops=loops).equilibrium({f"j{i}": 0.1 * (-1) ** i for i in range(10)})
    if kind == "point" and count == 1:
        gap = float(re.search(r"open by (\S+) m", str(refusal.value))[1])
        assert gap >= (np.hypot(12, 1) - 10) / np.sqrt(3)
