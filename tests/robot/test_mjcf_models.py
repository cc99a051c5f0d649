"""MJCF files are what MuJoCo compiles: constructs with known values, random models against MuJoCo, files, hostile files."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.robot import linear_range
from mbconstrained.robot.description import mjcf
from tests.robot import linkages
from tests.robot.linkages import null_space
from tests.robot.mjcf_models import Generator, Oracle, compiled_here
from tests.robot.mjcf_models import text as text_of

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install 'mbconstrained[mjcf]')")


def body(name: str, joint: str = "", inside: str = "", place: str = "", inertial: str = "") -> str:
    mass = inertial or '<inertial mass="2" pos="0.1 0.02 -0.3" diaginertia="0.02 0.03 0.04"/>'
    return f'<body name="{name}" {place}>{joint}{mass}{inside}</body>'


def hinge(name: str, more: str = "") -> str:
    return f'<joint name="{name}" axis="0 1 0" {more}/>'


def chain(before: str = "", a: str = "", b: str = "", place: str = "", inside: str = "", after: str = "") -> str:
    """Two links of 2 kg on a base: the second at ``place``, ``inside`` next to it in the first."""
    second = body("link2", hinge("b", b), place=f'pos="0 0 -0.5" {place}')
    first = body("link1", hinge("a", a), inside + second, 'pos="0.1 0 1"')
    return f'<mujoco>{before}<worldbody><body name="base">{first}</body></worldbody>{after}</mujoco>'


def read(tmp_path: Path, text: str, name: str = "m.xml", **options) -> mb.Robot:
    (tmp_path / name).write_text(text)
    return mb.Robot(tmp_path / name, **options)


@pytest.fixture
def here(monkeypatch):
    """Compiled in this process; ``test_a_process_of_its_own`` has the other."""
    monkeypatch.setattr(mjcf, "_compiled", compiled_here)


EXTRA = body(
    "extra",
    hinge("c", 'stiffness="7"'),
    place='pos="0.2 0 0"',
    inertial='<inertial mass="1" pos="0 0 -0.1" diaginertia="0.01 0.02 0.03"/>',
)
LINK = '<inertial mass="1" pos="0.05 0 -0.1" diaginertia="0.01 0.011 0.012"/>'
MESHED = '<mujoco>{}<asset><mesh class="mm" name="c" file="{}"/></asset><worldbody>{}</worldbody></mujoco>'
MESH_BODY = body(
    "a", hinge("j"), '<geom type="mesh" mesh="c"/>', inertial='<inertial mass="1" pos="0 0 -0.3" diaginertia="0.01 0.01 0.01"/>'
)
CUBE = "v 0 0 0\nv 100 0 0\nv 0 100 0\nv 0 0 100\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


LINKAGE = """<mujoco model="four-bar with a gear"><option gravity="0.3 0 -5"/>
<default><joint damping="0.3"/><default class="soft"><joint stiffness="20" springref="10"/></default></default>
<worldbody><body name="frame"><geom type="box" size="0.3 0.02 0.02" mass="1"/>
<body name="crank"><joint name="j1" class="soft" axis="0 1 0" armature="0.01"/>
 <geom type="capsule" size="0.02" fromto="0 0 0 0.1 0 0.2" mass="0.5"/>
 <body name="coupler" pos="0.1 0 0.2"><joint name="j2" axis="0 1 0"/><geom type="box" size="0.2 0.02 0.02" pos="0.2 0 0" mass="0.7"/></body>
</body>
<body name="rocker" pos="0.5 0 0"><joint name="j3" axis="0 1 0"/><geom type="ellipsoid" size="0.02 0.03 0.1" pos="0 0 0.1" mass="0.4"/></body>
<body name="wheel" pos="-0.3 0 0"><joint name="j4" axis="0 1 0" stiffness="3"/><geom type="cylinder" size="0.1 0.02" pos="0.05 0 0" mass="0.2"/></body>
</body></worldbody>
<equality><connect name="pin" body1="coupler" body2="rocker" anchor="0.4 0 0"/>
<joint name="mesh" joint1="j4" joint2="j1" polycoef="0.1 -2 0 0 0"/></equality>
<keyframe><key name="leaning" qpos="0.2 -0.1 0.15 -0.3"/></keyframe></mujoco>"""


def linkage(second: str, inside: str, joint2: str = "") -> str:
    """The four-bar of two files of a client of the first kind: a ``connect`` of ``second`` to the body d."""
    c = body("c", hinge("j2", joint2), inside, 'pos="0.05 0 -0.3"', LINK)
    a = body("a", hinge("j1", 'stiffness="20"'), c, 'pos="0 0 1"', LINK)
    d = body("d", hinge("j3", 'stiffness="5"'), "", 'pos="0.5 0 1.1"', LINK)
    equality = f'<equality><connect name="k" body1="{second}" body2="d" anchor="0.1 0 -0.1"/></equality>'
    return f'<mujoco><option gravity="0 0 -9.81"/><worldbody><body name="base">{a}{d}</body></worldbody>{equality}</mujoco>'


def frequencies(robot: mb.Robot, **options) -> np.ndarray:
    return robot.linearize(robot.equilibrium(**options)).modes().frequencies_hz


@pytest.mark.parametrize(
    ("polynomial", "value"),
    [
        ('joint2="a" polycoef="0.1 -2 0 0 0"', np.radians(-20) + 0.1 + 2 * np.radians(30)),  # b - b0 = 0.1 - 2 (a - a0)
        ('polycoef="0.2"', np.radians(-20) + 0.2),
    ],
)
def test_equalities_of_joints_are_relative_to_the_references(tmp_path, here, polynomial, value):
    equality = f'<equality><joint joint1="b" {polynomial}/></equality>'
    robot = read(tmp_path, chain(a='ref="30"', b='ref="-20"', after=equality))
    posture = robot.equilibrium({"a": 0.0}, hold=["a"])
    assert posture["b"] == pytest.approx(value, abs=1e-12)
    assert len(robot.linearize(posture).modes()) == 1


def test_the_linear_coefficient_of_polynomial_damping(tmp_path, here):
    robot = read(tmp_path, chain(a='damping="0.5 0.1"'))
    assert robot.linearize(robot.equilibrium()).damping[0, 0] == 0.5
    assert any("of polynomial damping the linear part is read: a" in notice.text for notice in robot.description_notices)


@pytest.mark.parametrize(
    "text",
    [
        chain(inside=f'<frame pos="0 0 -0.1" euler="0 30 0">{EXTRA}</frame>'),
        chain(inside=f'<replicate count="3" euler="0 0 30">{EXTRA}</replicate>'),
        chain().replace('name="a" ', 'stiffness="20" ', 1),
        chain(a='springdamper="0.1 0.5"'),
        chain('<option><flag spring="disable" damper="disable"/></option>', a='stiffness="50" damping="3"'),
        chain().replace('name="link2"', 'name="link2" gravcomp="1"'),
        chain('<compiler settotalmass="10"/>'),
        chain().replace('<joint name="a" axis="0 1 0" />', '<joint name="a" axis="0 1 0"/><joint name="a2" axis="1 0 0"/>'),
        chain().replace("</worldbody>", '</worldbody><worldbody><light pos="0 0 3"/></worldbody>'),
        chain(
            after='<tendon><fixed name="t" stiffness="100" damping="2"><joint joint="a" coef="1"/><joint joint="b" coef="-2"/></fixed></tendon>'
        ),
        chain().replace(
            "</worldbody>",
            '<body name="other" pos="1 0 0"><joint name="o" axis="1 0 0" stiffness="3"/><geom size="0.1" pos="0 0.2 0"/></body></worldbody>',
        ),
        chain().replace(
            '<joint name="a" axis="0 1 0" />', '<joint name="a" type="ball" stiffness="40" damping="2" armature="0.1"/>'
        ),
        chain(place='axisangle="1 2 3 40"'),
        chain('<compiler eulerseq="ZYX"/>', place='euler="20 30 40"'),
        chain('<default><default class="c"><joint pos="0 0 0.1"/></default></default>', a='class="c"'),
        chain('<compiler inertiafromgeom="true"/>').replace(
            '0.04"/></body>', '0.04"/><geom type="box" size="0.1 0.2 0.3" pos="0.1 0 -0.3" mass="2.5"/></body>'
        ),
    ],
    ids="frame replicate unnamed springdamper flags gravcomp settotalmass two-joints two-worlds tendon two-bodies ball axisangle "
    "eulerseq pos-by-class inertiafromgeom".split(),
)
def test_mass_stiffness_and_damping_are_those_of_mujoco(tmp_path, here, text):
    robot = read(tmp_path, text)
    expect_of_mujoco(robot, tmp_path / "m.xml")


def expect_of_mujoco(robot: mb.Robot, path: Path, seed: int = 0) -> None:
    """M, C and the derivatives of all forces without loops, about a random posture, entry by entry, in MuJoCo's own coordinates."""
    rng, oracle = np.random.default_rng(seed), Oracle(path)
    qpos = oracle.moved(oracle.model.qpos0, rng.uniform(-0.6, 0.6, oracle.model.nv))
    oracle.without_forces_at(qpos)
    values = robot.tangent.values(_configuration(oracle.model, qpos))
    posture = robot.equilibrium(values, hold=robot.coordinates)
    system, balance = robot.linearize(posture), posture.balance
    turn = _rates(oracle.model, qpos)

    def force(step):
        moved = oracle.moved(qpos, turn @ step)
        return _rates(oracle.model, moved).T @ oracle.force(moved)

    one_branch = robot.tree.moves_axis | robot.tree.moves_axis.T  # MuJoCo's M has no other entries
    K = np.sum(balance.stiffnesses, axis=0) + np.diag(robot.position_gains)
    for ours, theirs, tolerance in (
        (system.mass * one_branch, turn.T @ oracle.mass(qpos) @ turn * one_branch, 1e-10),
        (system.damping, turn.T @ oracle.damping(qpos) @ turn, 1e-7),
        (K, oracle.derivative(force, 5e-4), 2e-7),
    ):
        scale = max(np.abs(theirs).max(), np.abs(balance.force).max() * 1e-3)
        assert np.abs(ours - theirs).max() <= tolerance * scale, path.read_text()
    left = balance.force - turn.T @ oracle.force(qpos)
    assert np.abs(left).max() <= 1e-10 * max(np.abs(part).max() for part in balance.forces) + 1e-12


def _configuration(model, qpos) -> np.ndarray:
    """Quaternions w, x, y, z become x, y, z, w."""
    q = np.array(qpos)
    for kind, at in zip(model.jnt_type, model.jnt_qposadr):
        if kind in (0, 1):
            start = at + 3 * (kind == 0)
            q[start : start + 4] = np.roll(q[start : start + 4], -1)
    return q


def _rates(model, qpos) -> np.ndarray:
    """The origin of a free body moves along its own axes here, and along those of the ground in MuJoCo."""
    turn = np.eye(model.nv)
    for kind, at, dof in zip(model.jnt_type, model.jnt_qposadr, model.jnt_dofadr):
        if kind == 0:
            R = np.empty(9)
            mujoco.mju_quat2Mat(R, qpos[at + 3 : at + 7])
            turn[dof : dof + 3, dof : dof + 3] = R.reshape(3, 3)
    return turn


def without_equalities(text: str) -> str:
    return text.split("<equality>")[0] + ("" if "<equality>" not in text else "</mujoco>")


@pytest.mark.parametrize("seed", range(80))
def test_random_models(tmp_path, here, seed):
    text = without_equalities(Generator(seed).model())
    (tmp_path / "m.xml").write_text(text)
    expect_of_mujoco(mb.Robot(tmp_path / "m.xml"), tmp_path / "m.xml", seed)


@pytest.mark.parametrize("seed", range(60))
def test_loops_of_random_models(tmp_path, here, seed):
    generator = Generator(seed)
    generator.loops = True
    robot = read(tmp_path, generator.model())
    expect_loops_of_mujoco(robot, tmp_path / "m.xml", seed)


def on_a_fixed_body() -> str:
    """The linkage with a loop at a body that is fixed in another one."""
    mass = '<inertial mass="0.1" pos="0 0 0" diaginertia="0.01 0.01 0.01"/>'
    return linkage("e", body("e", place='pos="0.1 0 0.1" euler="0 20 0"', inertial=mass))


def rigid_pair(place: str, equality: str) -> str:
    """A body with another one fixed in it, of which the site s2 is 0.1 m from s1 less ``place``."""
    inside = body("tip", "", '<site name="s2"/>', f'pos="{place}"')
    arm = body("arm", hinge("j"), '<site name="s1" pos="0.3 0 0"/>' + inside)
    return f"<mujoco><worldbody>{arm}</worldbody><equality>{equality}</equality></mujoco>"


@pytest.mark.parametrize("kind", ["connect", "weld"])
def test_loops_within_a_rigid_body_are_closed_or_refused(tmp_path, here, kind):
    equality = f'<{kind} name="k" site1="s1" site2="s2"/>'
    robot = read(tmp_path, rigid_pair("0.3 0 0", equality))
    assert not robot.loops and len(robot.linearize(robot.equilibrium()).modes()) == 1  # MuJoCo's rows are zero
    assert np.abs(Oracle(tmp_path / "m.xml").rows([0.1])).max(initial=0.0) < 1e-15
    with pytest.raises(
        mb.InputError, match='the equality "k" joins "arm" and "tip", between which there is no joint.* never closed'
    ):
        read(tmp_path, rigid_pair("0.2 0 0", equality))


def test_loops_of_a_pivot_whose_rows_are_dependent_to_rounding(tmp_path, here):
    """A point of a body on a ball joint is fixed in the parent: rows r x of rank 2, whose third singular value is noise in both programs."""
    generator = Generator(3)
    for seed in range(60):
        rng = np.random.default_rng(seed)
        place, anchor = generator.vector(), text_of(*rng.uniform(-0.2, 0.2, 3))
        ball = body("b", '<joint type="ball" pos="0.03 -0.02 0.05"/>', "", f'pos="{place}" {generator.turn()}')
        arm = body("a", "<freejoint/>", body("c", hinge("j", 'stiffness="9"'), ball, generator.turn()))
        text = f'<mujoco><worldbody>{arm}</worldbody><equality><connect body1="b" body2="c" anchor="{anchor}"/></equality></mujoco>'
        text = text.replace("<mujoco>", f'<mujoco><compiler angle="{"degree" if generator.degrees else "radian"}"/>')
        robot = read(tmp_path, text)
        linear = robot.linearize(robot.equilibrium(hold=robot.coordinates))
        assert len(linear.constraint_matrix) == 2


@pytest.mark.parametrize("text", [linkage("c", "", 'pos="0.02 0 0.05"'), on_a_fixed_body()], ids=["pos-of-a-joint", "fixed-body"])
def test_loops_next_to_a_displaced_joint_and_on_a_fixed_body(tmp_path, here, text):
    expect_loops_of_mujoco(read(tmp_path, text), tmp_path / "m.xml", 0)


def expect_loops_of_mujoco(robot: mb.Robot, path: Path, seed: int) -> None:
    """Equalities are closed where MuJoCo has computed their anchors, at the references: the same motions are left, which have the
    same stiffness N^T (K - d(J^T lambda)/dq) N under loop forces of the same effect."""
    oracle = Oracle(path)
    qpos = oracle.model.qpos0.copy()
    posture = robot.equilibrium(robot.tangent.values(_configuration(oracle.model, qpos)), hold=robot.coordinates)
    robot.linearize(posture)
    turn, J = _rates(oracle.model, qpos), oracle.rows(qpos)
    ours = posture.balance.jacobian
    N = null_space(J @ turn) if len(J) else np.eye(oracle.model.nv)
    assert np.linalg.matrix_rank(ours, tol=1e-9) == np.linalg.matrix_rank(J, tol=1e-9)
    assert np.abs(ours @ N).max(initial=0.0) < 1e-9
    if not len(J):
        return
    theirs = np.random.default_rng(seed).normal(size=len(J)) * 3
    loads, *_ = np.linalg.lstsq(ours.T, turn.T @ J.T @ theirs, rcond=None)
    assert np.abs(ours.T @ loads - turn.T @ J.T @ theirs).max() < 1e-8

    def loop_force(step):
        moved = oracle.moved(qpos, turn @ step)
        return _rates(oracle.model, moved).T @ oracle.rows(moved).T @ theirs

    changed = oracle.derivative(loop_force, 1e-3)
    geometric = np.sum(posture.balance.geometric(loads), axis=0) if robot.loops else np.zeros_like(changed)
    own, other = (N.T @ part @ N for part in (geometric, changed))
    assert np.abs((own + own.T) / 2 - (other + other.T) / 2).max(initial=0.0) <= 1e-6 * (np.abs(other).max(initial=0.0) + 1.0)


def test_a_linkage_rests_by_the_forces_of_mujoco_in_a_state_of_its_file(tmp_path, here):
    robot, oracle = read(tmp_path, LINKAGE), Oracle(tmp_path / "m.xml")
    assert robot.states["leaning"] == pytest.approx({"j1": 0.2, "j2": -0.1, "j3": 0.15, "j4": -0.3})
    assert [loop.kind for loop in robot.loops] == ["point"] and [row.name for row in robot.mimic_rows] == ["j4 follows j1"]
    posture = robot.equilibrium("leaning")
    N = null_space(oracle.rows(posture.configuration))
    force = oracle.force(posture.configuration)
    assert N.shape == (4, 1) and np.abs(robot.linearize(posture).constraint_matrix @ N).max() < 1e-12
    assert np.abs(N.T @ force).max() < 1e-10 * np.abs(force).max()


def test_four_bar_simulated_with_stiff_connections():
    # MuJoCo holds loops by stiff springs and its own integrator: frequencies agree as the step goes to zero, 4e-6 here
    p = linkages.given("four-bar")
    robot, guess = linkages.four_bar(p)
    posture = robot.equilibrium(guess)
    _, coupler, rocker = p["lengths"]
    text = linkages.four_bar_text(p)
    specification = mujoco.MjSpec.from_string(text)
    specification.option.gravity, specification.option.timestep = np.array(linkages.PLANE), 1e-3
    equality = specification.add_equality()
    equality.type, equality.objtype = mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtObj.mjOBJ_BODY
    equality.name1, equality.name2 = "coupler", "rocker"
    equality.solref = [0.002, 1.0]
    equality.data[:3] = (coupler, 0, 0)
    model = specification.compile()
    number = model.joint("j1").id
    model.jnt_stiffness.reshape(model.njnt, -1)[number, 0] = p["stiffness"]  # later entries: powers of the deflection
    model.qpos_spring[model.joint("j1").qposadr[0]] = p["rest"]
    model.eq_data[0, 3:6] = (rocker, 0, 0)  # MuJoCo put it where the coupler ends at zero angles: elsewhere
    data = mujoco.MjData(model)
    for name, value in posture.joints.items():
        data.qpos[model.joint(name).qposadr[0]] = value
    mujoco.mj_forward(model, data)
    mujoco.mj_step(model, data, 400)
    data.qvel[:] = 0
    A = np.zeros((2 * model.nv, 2 * model.nv))
    mujoco.mjd_transitionFD(model, data, 1e-6, True, A, None, None, None)
    values = np.log(np.linalg.eigvals(A).astype(complex)) / model.opt.timestep
    slow = min(values[np.abs(values.imag) > 1e-3], key=lambda s: abs(s))
    assert abs(slow) == pytest.approx(linkages.known_frequencies("four-bar")[0], rel=2e-5)
    assert abs(slow) == pytest.approx(robot.linearize(posture).modes().natural_frequencies[0], rel=2e-5)


def test_geoms_are_shapes(tmp_path, here):
    robot = read(tmp_path, LINKAGE)
    shapes = {visual.link: visual for visual in robot.visuals()}
    kinds = {"frame": "box", "crank": "cylinder", "coupler": "box", "rocker": "mesh", "wheel": "cylinder"}
    assert {name: visual.kind for name, visual in shapes.items()} == kinds
    assert shapes["coupler"].placement[:3, 3] == pytest.approx([0.2, 0, 0]) and shapes["coupler"].size == (0.4, 0.04, 0.04)
    assert np.ptp(shapes["rocker"].vertices, axis=0) == pytest.approx([0.04, 0.06, 0.2])
    collision = {shape.link: shape for shape in robot.visuals(collision=True)}  # MJCF uses the same geoms for both
    assert collision.keys() == shapes.keys() and all(shapes[name].has_shape_of(collision[name]) for name in shapes)


def test_a_robot_file_names_an_mjcf_file(tmp_path, here):
    (tmp_path / "m.xml").write_text(LINKAGE)
    (tmp_path / "robot.toml").write_text(
        'urdf = "m.xml"\n[joint_damping]\nj2 = "1 N*m*s/rad"\n[posture]\nguess = { j1 = "10 deg" }'
    )
    assert mb.read_robot(tmp_path)[0].joint_damping.tolist() == pytest.approx([0.3, 1.3, 0.3, 0.3])
    (tmp_path / "scene.toml").write_text('[model]\nkind = "robot"\nrobot = "."\n[time]\nend = 1')
    mb.read_scene(tmp_path / "scene.toml").run().write_page(tmp_path / "page.html")
    assert "coupler" in (tmp_path / "page.html").read_text()


def test_a_planar_base(tmp_path, here):
    """Slides and a hinge in one body, as of hopper and cheetah: w^2 = k / m, k / J."""
    joints = (
        '<joint name="x" type="slide" axis="1 0 0" stiffness="400"/><joint name="z" type="slide" axis="0 0 1" stiffness="900"/>'
    )
    torso = body(
        "torso", joints + hinge("turn", 'stiffness="25"'), inertial='<inertial pos="0 0 0" mass="4" diaginertia="0.1 0.2 0.3"/>'
    )
    robot = read(tmp_path, f'<mujoco><option gravity="0 0 0"/><worldbody>{torso}</worldbody></mujoco>')
    assert robot.bodies == ("torso (x)", "torso (z)", "torso")
    assert 2 * np.pi * frequencies(robot) == pytest.approx(sorted([10.0, 15.0, np.sqrt(25 / 0.2)]), rel=1e-12)
    (tmp_path / "robot.toml").write_text('urdf = "m.xml"\n[joint_stiffness]\nx = "1600 N/m"')
    with_more, _ = mb.read_robot(tmp_path)
    assert 2 * np.pi * frequencies(with_more)[-1] == pytest.approx(20.0, rel=1e-12)


def test_gears_of_tendons(tmp_path, here):
    """c1 a + c2 b keeps its value: b follows a with -c1 / c2; three joints are named."""
    tendon = '<tendon><fixed name="t"><joint joint="a" coef="1"/><joint joint="b" coef="-2"/></fixed></tendon>'
    robot = read(tmp_path, chain(after=f'{tendon}<equality><tendon tendon1="t"/></equality>'))
    system = robot.linearize(robot.equilibrium({"a": 0.2}, hold=["a"]))
    (row,) = system.constraint_matrix
    assert row[0] / row[1] == pytest.approx(-0.5, rel=1e-12)


def test_gains_of_actuators_are_motors(tmp_path, here):
    text = chain(
        after='<actuator><position joint="a" kp="50" kv="3" gear="2"/><velocity joint="b" kv="4"/><motor name="idle" joint="b"/></actuator>'
    )
    robot = read(tmp_path, text)
    assert robot.motors == {"a": mb.Motor(position_gain=200.0, velocity_gain=12.0), "b": mb.Motor(velocity_gain=4.0)}
    posture = robot.equilibrium({"a": 0.4}, hold=["b"])
    assert posture["a"] == pytest.approx(0.4, abs=1e-15)  # its control carries the load
    assert any("actuators without feedback exert no force: idle" in notice.text for notice in robot.description_notices)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ('<option viscosity="0.1"/>', "the viscosity 0.1 Pa s of the medium"),
        (
            '<equality><joint joint1="b" joint2="a" polycoef="0 1 0.5"/></equality>',
            'coupling of the joint "b", which is not linear',
        ),
        ('<actuator><muscle joint="a" lengthrange="0.1 1"/></actuator>', 'the kind muscle of the actuator "actuator 0"'),
        ('<actuator><adhesion body="link2" name="glue" ctrlrange="0 1"/></actuator>', ""),
        (
            '<tendon><fixed name="t"><joint joint="a" coef="1"/><joint joint="b" coef="1"/><joint joint="c" coef="1"/></fixed></tendon>'
            '<equality><tendon name="e" tendon1="t"/></equality>',
            '<equality> tendon "e" of 3 joints',
        ),
    ],
    ids="viscosity coupling muscle adhesion three-joints".split(),
)
def test_what_is_not_read_is_named(tmp_path, here, more, message):
    robot = read(tmp_path, chain(inside=EXTRA, after=more))
    doubts = [notice.text for notice in robot.description_notices if notice.doubtful]
    assert [message in text for text in doubts] == [True] * bool(message)
    robot.linearize(robot.equilibrium(hold="all"))  # the rest is MuJoCo's


def test_a_tendon_around_a_geom_is_refused(tmp_path, here):
    geom = '<geom name="roller" type="cylinder" size="0.05 0.1"/><site name="s1" pos="0.3 0 0"/>'
    text = chain(inside=geom + EXTRA.replace("<inertial", '<site name="s2"/><inertial'))
    tendon = '<tendon><spatial name="belt" stiffness="5"><site site="s1"/><geom geom="roller"/><site site="s2"/></spatial></tendon>'
    with pytest.raises(mb.InputError, match='the tendon "belt" with stiffness, damping or inertia is wrapped around a geom'):
        read(tmp_path, text.replace("</mujoco>", tendon + "</mujoco>"))


# Files.


def test_a_missing_mesh_is_a_note_and_the_rest_is_drawn(tmp_path, here):
    text = MESHED.format("", "missing.obj", MESH_BODY.replace("</body>", '<geom type="box" size="0.1 0.1 0.1" mass="0"/></body>'))
    robot = read(tmp_path, text)
    assert [visual.kind for visual in robot.visuals()] == ["box"]
    (notice,) = robot.description_notices
    assert not notice.doubtful and "1 mesh not drawn: there is no file 'missing.obj'" in notice.text


def test_a_missing_mesh_that_carries_mass_is_refused(tmp_path, here):
    text = MESHED.format("", "missing.obj", '<body name="a"><joint/><geom type="mesh" mesh="c"/></body>')
    with pytest.raises(mb.InputError, match=r'mass of the body "a" is that of a mesh whose file is missing \(missing.obj\)'):
        read(tmp_path, text)


def test_the_scale_of_a_mesh_by_class(tmp_path, here):
    (tmp_path / "cube.obj").write_text(CUBE)
    scale = '<default><default class="mm"><mesh scale="0.001 0.001 0.001"/><geom rgba="1 0 0 0.5"/></default></default>'
    (visual,) = read(tmp_path, MESHED.format(scale, "cube.obj", MESH_BODY.replace("<geom", '<geom class="mm"'))).visuals()
    assert np.ptp(visual.vertices, axis=0) == pytest.approx([0.1] * 3, rel=1e-6) and visual.color == (1.0, 0.0, 0.0, 0.5)
    corners = visual.vertices @ visual.placement[:3, :3].T + visual.placement[:3, 3]
    assert corners.min(axis=0) == pytest.approx(np.zeros(3), abs=1e-7)  # where the file has them


def test_included_files_and_those_next_to_the_folder(tmp_path, here):
    for folder in ("robots/arm", "robots/common", "other"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "robots/common/defaults.xml").write_text(
        '<mujoco><default><joint armature="0.5" damping="2"/><geom density="100"/></default></mujoco>'
    )
    arm = '<body name="a"><joint name="j1" axis="0 1 0"/><geom type="box" size="0.05 0.05 0.5" pos="0 0 -0.5"/></body>'
    (tmp_path / "robots/arm/arm.xml").write_text(
        f'<mujoco><include file="../common/defaults.xml"/><worldbody>{arm}</worldbody></mujoco>'
    )
    scene = '<mujoco><include file="arm.xml"/><worldbody><light pos="0 0 3"/><geom type="plane" size="1 1 .1" pos="0 0 -3"/></worldbody></mujoco>'
    robot = read(tmp_path / "robots/arm", scene, "scene.xml")
    system = robot.linearize(robot.equilibrium())
    mass = 100 * 0.1 * 0.1 * 1.0
    assert system.mass[0, 0] == pytest.approx(0.5 + mass * (0.25 + (1.0 + 0.01) / 12), rel=1e-12) and system.damping[0, 0] == 2.0
    (tmp_path / "other/defaults.xml").write_text("<mujoco/>")
    text = scene.replace("arm.xml", "../../other/defaults.xml").replace("<light", f"{arm}<light")
    with pytest.raises(mb.InputError, match="lies outside of the folder of the MJCF, the one above it and its package"):
        read(tmp_path / "robots/arm", text, "outside.xml")
    assert read(tmp_path / "robots/arm", text, "outside.xml", package_dirs=[tmp_path / "other"]).coordinates == ("j1",)
    (tmp_path / "package.xml").write_text("<package/>")
    assert read(tmp_path / "robots/arm", text, "outside.xml").coordinates == ("j1",)


def test_a_model_in_a_model(tmp_path, here):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/cube.obj").write_text(CUBE)
    elbow = hinge("e", 'stiffness="3"')
    link = f'<body name="link" pos="0 0 -1">{elbow}<geom type="mesh" mesh="c" density="1"/></body>'
    asset = '<asset><mesh name="c" file="cube.obj" scale="0.001 0.001 0.001"/></asset>'
    (tmp_path / "sub/arm.xml").write_text(f"<mujoco>{asset}<worldbody>{link}</worldbody></mujoco>")
    attached = '<attach model="arm" body="link" prefix="{}"/>'
    text = (
        f'<mujoco><asset><model name="arm" file="sub/arm.xml"/></asset><worldbody><body name="base">{hinge("j")}<geom size="0.1" pos="0 0 -0.2"/>'
        f'{attached.format("left ")}</body><frame pos="1 0 0">{attached.format("right ")}</frame></worldbody></mujoco>'
    )
    robot = read(tmp_path, text)
    assert robot.coordinates == ("j", "left e", "right e") and robot.joint_stiffness.tolist() == [0, 3, 3]
    robot.linearize(robot.equilibrium(hold="all"))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco><default>" + "<default>" * 40_000 + "</default>" * 40_000 + "</default></mujoco>", "more than 300 deep"),
        ('<mujoco><asset><mesh file="/etc/hosts"/></asset></mujoco>', "lies outside"),
        ('<mujoco><include file="/etc/hosts"/></mujoco>', "lies outside"),
        (chain(place='pos="nan 0 0"').replace('pos="0 0 -0.5" ', ""), 'body_pos of "link2": found nan'),
        (chain(a='damping="1e308"'), "dof_damping: found 1e[+]308"),
        ("<mujoco><worldbody/></mujoco>", "found no body in m.xml"),
        ("<mujoco><worldbody><body/></worldbody></mujoco>", "found no joint that moves in m.xml"),
        ("<!DOCTYPE x><mujoco/>", "mjcf: found a document type"),
        ("<mujoco>", "mjcf: not XML"),
        ('<mujoco><include file="nothing.xml"/></mujoco>', "there is no such MJCF file"),
        ('<mujoco><include file="m.xml"/></mujoco>', "include each other more than 5 deep"),
    ],
    ids="nested outside include nan large empty rigid entity cut nothing circle".split(),
)
def test_hostile_files(tmp_path, here, text, message):
    with pytest.raises(mb.InputError, match=message):
        read(tmp_path, text)


#: Elements whose attributes are listed one by one.
LISTED = {
    "option": "option",
    "option/flag": "flag",
    "equality/connect": "connect",
    "equality/weld": "weld",
    "equality/joint": "equality joint",
    "equality/tendon": "equality tendon",
    "tendon/fixed": "fixed",
    "tendon/spatial": "spatial",
    "actuator/general": "general",
}


def test_every_element_of_mujoco_has_a_verdict():
    """The schema of the installed MuJoCo, element by element, against the table of the reference."""
    page = (Path(mb.__file__).parent / "docs/reference/mjcf.md").read_text()
    rows = [line.split("|")[1] for line in page.splitlines() if line.startswith("| ") and "`" in line]
    words = {word.strip() for row in rows for name in re.findall("`([^`]+)`", row) for word in [name, *name.split()]}
    path: list[str] = []
    elements: dict[str, list[str]] = {}
    for line in mujoco.mj_printSchema(False, False).splitlines():
        if found := re.match(r"( *)(\w+) \(.\)(.*)", line):
            path = [*path[: len(found[1]) // 3], found[2]]
            elements["/".join(path[1:])] = found[3].split()
        else:
            elements["/".join(path[1:])] += line.split()
    assert len(elements) > 100
    missing = [name for name in elements if name and not name.startswith("sensor/") and name.split("/")[-1] not in words]
    for name, row in LISTED.items():
        known = {
            word
            for text in rows
            if f"`{row}`" in text or ("equalities" in text and "equality" in name)
            for word in re.findall("`([^`]+)`", text)
        }
        missing += [f"{name} {attribute}" for attribute in elements[name] if attribute not in known]
    joint = {word for text in rows if "`joint`" in text for word in re.findall("`([^`]+)`", text)}
    missing += [
        f"joint {attribute}"
        for attribute in elements.get("asset/joint", elements.get("worldbody/joint", []))
        if attribute not in joint
    ]
    assert missing == []


def test_a_process_of_its_own(tmp_path, monkeypatch, capfd):
    """MuJoCo has no limits of memory and time, and its warnings go to the terminal and to a file."""
    mjcf._compiled.cache_clear()
    monkeypatch.chdir(tmp_path)
    robot = read(tmp_path, chain('<compiler settotalmass="10"/>'))  # MuJoCo warns of it
    robot.linearize(robot.equilibrium(hold="all"))
    large = '<mujoco><asset><hfield name="h" nrow="100000" ncol="100000" size="1 1 1 1"/></asset></mujoco>'
    with pytest.raises(mb.InputError, match="it needs more than 4 GB of memory, or is damaged"):
        read(tmp_path, large, "large.xml")
    with pytest.raises(mb.InputError, match=r"\(XML Error: bad format in attribute 'damping' .* at <joint name=\"a\""):
        read(tmp_path, chain(a='damping="soft"'), "wrong.xml")
    monkeypatch.setattr(mjcf, "LONGEST_COMPILATION", 0.01)
    with pytest.raises(mb.InputError, match="does not compile this model within 0.01 s"):
        read(tmp_path, chain(a='armature="1"'), "other.xml")
    assert capfd.readouterr() == ("", "") and {path.suffix for path in tmp_path.iterdir()} == {".xml"}


@pytest.mark.parametrize("count", [250, 20_000])
def test_nested_default_classes_are_read_or_refused_early(tmp_path, here, count):
    """MuJoCo's time for them grows with their square or worse, without an end in sight for thousands."""
    nested = "".join(f'<default class="c{number}">' for number in range(count)) + "</default>" * count
    text = chain(f"<default>{nested}</default>")
    if count < mjcf.DEEPEST_ELEMENT:
        assert read(tmp_path, text).model.nv == 2
        return
    with pytest.raises(mb.InputError, match="elements contain each other more than 300 deep"):
        read(tmp_path, text)


def test_without_mujoco_a_file_asks_for_it(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(mb.InputError, match=r"MuJoCo, which is not installed: pip install 'mbconstrained\[mjcf\]'"):
        read(tmp_path, chain(a='armature="2"'))


def test_a_difference_from_mujoco_is_an_error(tmp_path, here):
    robot = read(tmp_path, chain(a='stiffness="20"'))
    twin = linear_range._Twin(robot, robot.tangent.configuration({}))
    twin.model.dof_damping[1] = 0.3  # as a construct that is not read
    with pytest.raises(mb.InputError, match='the damping of "b" is 0 here and 0.3 in MuJoCo'):
        linear_range._agree("damping", np.zeros((2, 2)), twin.damping(), robot.coordinates, 1e-6, 0.0)
