"""SDF files: models by seed over poses, frames, axes, nested and included models, kinds of joints and loops, against a model of
products of exponentials; constructs by hand; hostile files."""

import re

import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb
from tests.robot.model_files import Mechanism, SdfWriter

SEEDS = range(60)


def frequencies(M, K, rows):
    N = scipy.linalg.null_space(rows) if len(rows) else np.eye(len(M))
    return np.sqrt(np.abs(scipy.linalg.eigh(N.T @ K @ N, N.T @ M @ N, eigvals_only=True)))


def order(robot, truth):
    assert sorted(robot.coordinates) == sorted(truth.coordinates)
    return [robot.coordinates.index(name) for name in truth.coordinates]


@pytest.mark.parametrize("seed", SEEDS)
def test_trees_have_the_masses_and_stiffness_of_products_of_exponentials(seed, tmp_path):
    rng = np.random.default_rng(seed)
    kinds = ["revolute", "prismatic", "universal", "fixed", "screw"] if seed % 4 else ["revolute", "prismatic", "ball"]
    truth = Mechanism(rng, kinds)
    (tmp_path / "model.sdf").write_text(SdfWriter(truth, rng, tmp_path).text())
    robot = mb.Robot(tmp_path / "model.sdf")
    q = np.zeros(len(truth.coordinates))
    names = truth.coordinates
    for place, name in enumerate(names):
        screws = [joint for joint in truth.joints if joint.kind == "screw" and name.startswith(joint.name)]
        if not any(name.endswith(suffix) for suffix in (" rx", " ry", " rz")):
            q[place] = screws[0].pitch * q[place - 1] if screws and "slide" in name else rng.uniform(-1, 1)
    guess = {name: value for name, value in zip(names, q) if not name.endswith((" rx", " ry", " rz"))}
    places = np.ix_(order(robot, truth), order(robot, truth))
    M, K = truth.mass(q), truth.stiffness(q)
    if not seed % 4:  # K of a ball joint that a torque keeps depends on its coordinates
        np.testing.assert_allclose(
            robot.tree.mass(robot.tangent.configuration(guess))[places], M, rtol=0, atol=1e-12 * np.abs(M).max()
        )
        return
    system = robot.linearize(robot.equilibrium(guess, hold="all"))
    np.testing.assert_allclose(system.mass[places], M, rtol=0, atol=1e-12 * np.abs(M).max())
    np.testing.assert_allclose(np.diag(system.damping)[order(robot, truth)], truth.dampers, rtol=0, atol=1e-12)
    np.testing.assert_allclose(system.stiffness[places], K, rtol=0, atol=1e-8 * np.abs(K).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_loops_have_the_frequencies_of_their_null_space(seed, tmp_path):
    rng = np.random.default_rng([seed, 1])
    truth = Mechanism(
        rng, ["revolute", "prismatic", "screw"] if seed % 3 else ["revolute", "prismatic", "universal", "fixed"], loops=1 + seed % 2
    )
    (tmp_path / "model.sdf").write_text(SdfWriter(truth, rng, tmp_path).text())
    robot = mb.Robot(tmp_path / "model.sdf", gravity=0.0)
    q = np.zeros(len(truth.coordinates))
    free = scipy.linalg.null_space(truth.rows(q)).shape[1]
    assert free
    found = robot.linearize(robot.equilibrium(hold="all"))  # another assembly is possible
    names = [joint.name for joint in (*truth.joints, *truth.loops)]
    assert {loop.name for loop in robot.loops} <= set(names)
    assert found.modes().eigenvalues.size >= 0
    N = scipy.linalg.null_space(found.constraint_matrix)
    expected = frequencies(truth.mass(q), truth.stiffness(q), truth.rows(q))
    got = frequencies(found.mass, found.stiffness, found.constraint_matrix)
    assert N.shape[1] == free
    np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-4 * max(expected.max(), 1.0))


MASS = "<inertial><pose>0 0 -0.5 0 0 0</pose><mass>1</mass><inertia><ixx>.01</ixx><iyy>.01</iyy><izz>.01</izz></inertia></inertial>"
AXIS = "<axis><xyz>0 1 0</xyz></axis>"
W0 = np.sqrt(9.81 * 0.5 / 0.26)  # of the pendulum of this mass about its hinge


def link(name="a", more=""):
    return f'<link name="{name}">{more}{MASS}</link>'


def hinge(name="j", parent="world", child="a", more=AXIS, kind="revolute"):
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{more}</joint>'


def sdf(*parts, version="1.9", attributes=""):
    return (
        f'<sdf version="{version}" xmlns:drake="http://drake.mit.edu"><model name="m" {attributes}>{"".join(parts)}</model></sdf>'
    )


PENDULUM = link() + hinge()


@pytest.mark.parametrize(
    "text, message",
    [
        (sdf(link(more='<pose relative_to="b"/>'), link("b", '<pose relative_to="a"/>'), hinge()), "circle: a -> b -> a"),
        (sdf(link(more='<pose relative_to="j"/>'), hinge()), "circle: a -> j -> a"),
        (sdf(PENDULUM, '<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>'), "circle: f -> g -> f"),
        (sdf(PENDULUM, '<frame name="f" attached_to="h"/>'), '<frame> "f": there is no frame "h"'),
        (sdf(PENDULUM, '<frame name="f"><pose relative_to="h"/></frame>'), 'there is no frame "h"'),
        (sdf(PENDULUM, attributes='canonical_link="h"'), 'there is no frame "h"'),
        (sdf(PENDULUM, attributes='canonical_link="__model__"'), "circle"),
        (sdf(f'<model name="n" placement_frame="h">{link()}</model>', hinge(child="n::a")), 'there is no frame "h"'),
        (sdf(link(), hinge(more="<axis><xyz>0 0 0</xyz></axis>")), "axis: found 0 0 0; expected a direction"),
        (sdf(link(), hinge(more="<axis><xyz>0 nan 0</xyz></axis>")), "axis: found nan"),
        (sdf(link(more="<pose>0 0 inf 0 0 0</pose>"), hinge()), "pose: found inf"),
        (sdf(link(more='<pose units="deg">0 0 0 0 0 0</pose>'), hinge()), 'found the attribute "units"'),
        (sdf(PENDULUM.replace("<mass>1", "<mass>1 kg")), "mass: found '1 kg'; expected a number"),
        (sdf(link(), "<joint name='j' type='revolute'><parent>world</parent></joint>"), "found no <child>"),
        (sdf(link(), "<joint name='j' type='revolute'><child>a</child></joint>"), "found no <parent>"),
        (sdf(link(), hinge(kind="weld")), 'found the type "weld"'),
        (sdf(link(), hinge(kind="screw", more=f"{AXIS}<thread_pitch>0</thread_pitch>")), "thread_pitch: found 0"),
        (sdf(link(), hinge(more='<axis><xyz>0 1 0</xyz><mimic joint="k"/></axis>')), 'mimic: there is no joint "k"'),
        (sdf(PENDULUM, '<drake:joint name="k" type="planar"/>'), 'found the type "planar" of a drake:joint'),
        (sdf('<model name="n">' * 300, "</model>" * 300), "more than 12 deep"),
        (sdf(PENDULUM, version="new"), 'found the version "new"'),
        (f'<sdf version="1.9"><world name="w"/><model name="m">{PENDULUM}</model></sdf>', "a world and models outside of it"),
        (sdf(*(link(f"l{k}") + hinge(f"j{k}", child=f"l{k}") for k in range(401))), "401 degrees of freedom; at most 400"),
    ],
)
def test_what_makes_no_model_is_refused_by_name(text, message):
    with pytest.raises(mb.InputError, match=re.escape(message)):
        mb.Robot(text)


SPRING = "<dynamics><spring_stiffness>5</spring_stiffness></dynamics>"


@pytest.mark.parametrize(
    "text, part",
    [
        (sdf(link(), hinge(more=f"{AXIS}<axis2><xyz>1 0 0</xyz>{SPRING}</axis2>")), "of the revolute joint"),
        (sdf(link(), hinge(kind="ball", more=f"<axis><xyz>1 0 0</xyz>{SPRING}</axis>")), "of the ball joint"),
        (sdf(PENDULUM.replace("</joint>", '<drake:controller_gains p="9" d="1"/></joint>')), "controller_gains"),
        (sdf(PENDULUM.replace("</joint>", "<springs>4</springs></joint>")), "<springs>"),
        (sdf(PENDULUM.replace("</link>", "<gravity>false</gravity></link>")), "<gravity>"),
        (sdf(PENDULUM, version="9.1"), "its version is later"),
        (sdf(PENDULUM.replace("<mass>", '<mass unit="g">')), 'unit = "g" of <mass> of the link "a"'),
        (sdf(PENDULUM.replace("<mass>", "<mass>5</mass><mass>")), 'second <mass> of the link "a"'),
        (sdf(PENDULUM.replace("</joint>", "<axis><xyz>1 0 0</xyz></axis></joint>")), 'second <axis> of the joint "j"'),
        (sdf(PENDULUM, "<scale>2 2 2</scale>"), "<scale>"),
        (sdf(link(), hinge(kind="universal", more=f"{AXIS}<drake:rotor_inertia>1</drake:rotor_inertia>")), "rotor of the joint"),
    ],
)
def test_what_is_not_read_and_may_act_is_doubtful(text, part):
    assert [notice for notice in mb.Robot(text).description_notices if notice.doubtful and part in notice.text]


def test_a_negative_moment_of_inertia_is_doubtful():
    """J = -5 + 0.25 kg m^2 about the hinge, beside a slide of which 1 kg moves."""
    parts = [link().replace("<iyy>.01", "<iyy>-5"), hinge(), link("b"), hinge("k", child="b", kind="prismatic")]
    robot = mb.Robot(sdf(*parts))
    assert [notice for notice in robot.description_notices if notice.doubtful and "negative" in notice.text]
    np.testing.assert_allclose(robot.linearize(robot.equilibrium(hold="all")).mass, np.diag([-4.75, 1.0]), rtol=1e-14)


def test_a_joint_follows_either_axis_of_another_one():
    """q = 2 q2 of two equal pendulums side by side: w^2 = m g r (1 + 4) / (J (1 + 4)), as of one."""
    leader = hinge("u", kind="universal", more="<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>")
    mimic = '<mimic joint="u" axis="axis2"><multiplier>2</multiplier></mimic>'
    robot = mb.Robot(sdf(link(), link("b"), leader, hinge("k", child="b", more=f"<axis><xyz>0 1 0</xyz>{mimic}</axis>")))
    system = robot.linearize(robot.equilibrium())
    np.testing.assert_allclose(system.modes().natural_frequencies, [W0, W0], rtol=1e-12)
    N = scipy.linalg.null_space(system.constraint_matrix)
    follower, leader = (N[robot.coordinates.index(name)] for name in ("k", "u axis2"))
    np.testing.assert_allclose(follower, 2 * leader, atol=1e-14)


def included(folder, name, *parts):
    (folder / name).mkdir()
    (folder / name / "model.sdf").write_text(sdf(*parts))


def test_a_world_includes_lights_and_a_ground(tmp_path):
    included(tmp_path, "arm", PENDULUM)
    included(tmp_path, "plane", "<static>true</static>", link("g"))
    (tmp_path / "sun").mkdir()
    (tmp_path / "sun" / "model.sdf").write_text('<sdf version="1.6"><light type="directional" name="sun"/></sdf>')
    parts = "".join(f"<include><uri>model://{name}</uri><name>{name}</name></include>" for name in ("sun", "plane", "arm"))
    (tmp_path / "a.world").write_text(f'<sdf version="1.6"><world name="w">{parts}<gravity>0 0 -9.81</gravity></world></sdf>')
    robot = mb.Robot(tmp_path / "a.world")
    assert robot.coordinates == ("arm::j",) and not robot.description_notices
    assert robot.linearize(robot.equilibrium()).modes().natural_frequencies[0] == pytest.approx(W0, rel=1e-12)


def test_models_that_include_each_other_are_refused(tmp_path):
    for name, other in ("a", "b"), ("b", "a"):
        included(tmp_path, name, f"<include><uri>model://{other}</uri></include>")
    with pytest.raises(mb.InputError, match="contain each other more than 12 deep"):
        mb.Robot(tmp_path / "a" / "model.sdf", package_dirs=[tmp_path])


def test_includes_that_multiply_are_counted(tmp_path):
    """Four models each of which includes the next four times, ten deep: a million models without a link."""
    for number in range(10):
        parts = [f"<include><name>n{k}</name><uri>model://m{number + 1}</uri></include>" for k in range(4)]
        included(tmp_path, f"m{number}", *parts)
    included(tmp_path, "m10")
    with pytest.raises(mb.InputError, match="more than 2,000 links or models"):
        mb.Robot(tmp_path / "m0" / "model.sdf", package_dirs=[tmp_path])


@pytest.mark.parametrize("uri", ["model://nowhere", "https://fuel.gazebosim.org/x", "file:///etc/passwd", "../../etc/passwd", ""])
def test_models_that_are_not_there_are_refused(uri, tmp_path):
    included(tmp_path, "m", PENDULUM, f"<include><uri>{uri}</uri></include>")
    with pytest.raises(mb.InputError, match=re.escape(f"include {uri!r}")):
        mb.Robot(tmp_path / "m" / "model.sdf")


def test_a_scene_runs_with_an_sdf_and_draws_all_but_a_missing_mesh(tmp_path, command):
    box = "<visual name='v'><geometry><box><size>1 1 1</size></box></geometry></visual>"
    mesh = "<visual name='w'><geometry><mesh><uri>model://m/nothing.stl</uri></mesh></geometry></visual>"
    included(tmp_path, "m", PENDULUM.replace("</link>", f"{box}{mesh}</link>"))
    (tmp_path / "m" / "robot.toml").write_text('urdf = "model.sdf"')
    scene = tmp_path / "scene.toml"
    scene.write_text('[model]\nkind = "robot"\nrobot = "m"\n[initial.displacement]\nj = "0.1 rad"\n[time]\nend = "1 s"\n')
    for name in ("check", "modes", "run"):
        code, output, error = command(name, scene)
        assert code == 0 and "1 mesh not drawn" in output and not error
    page = (tmp_path / "results" / "scene" / "scene.html").read_text()
    assert f"{W0 / 2 / np.pi:.6g}" in output and "1 mesh not drawn" in page


def test_a_joint_follows_another_one_as_in_drake():
    """Attributes of a tag of Drake below the joint; k turns with 2 q of j."""
    mimic = '<drake:mimic joint="j" multiplier="2" offset="0.1"/>'
    parts = [link(), link("b"), hinge(), hinge("k", child="b", more=f"<axis><xyz>0 1 0</xyz></axis>{mimic}")]
    text = sdf(*parts)
    robot = mb.Robot(text)
    assert [(row.name, row.multiplier, row.offset) for row in robot.mimic_rows] == [("k follows j", 2.0, 0.1)]
    with pytest.raises(mb.InputError, match='sdf, joint "k", mimic: there is no joint "jj"; did you mean "j"'):
        mb.Robot(text.replace('mimic joint="j"', 'mimic joint="jj"'))
