"""Geometric stiffness and a linkage against MuJoCo, which reads the same URDF by itself."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.robot import linkages
from tests.robot.linkages import PLANE, given, joint, known_frequencies, link, null_space, urdf

mujoco = pytest.importorskip("mujoco", reason="MuJoCo is not installed (pip install 'mbconstrained[mjcf]')")

# MuJoCo leaves out links without inertia and joins links without joints; every link here has both
AXES = [(0, 0, 1), (1, 0, 0.4), (0.2, 1, 0), (0, 1, 0), (1, 1, 1), (0, 0.3, 1)]


def spatial_arm(rng) -> str:
    """Six joints, hinges and a slide, on a base that is fixed."""
    parts = [link("root")]
    for i, axis in enumerate(AXES):
        a, b, c = rng.uniform(0.01, 0.1, 3)
        parts.append(
            link(f"body {i}", rng.uniform(0.3, 2), rng.uniform(-0.2, 0.2, 3), (a + b, b + c, a + c), rng.uniform(-1, 1, 3))
        )
        parent, kind = (f"body {i - 1}" if i else "root"), "prismatic" if i == 3 else "revolute"
        place = {"at": rng.uniform(-0.4, 0.4, 3), "turned": rng.uniform(-1, 1, 3)}
        parts.append(joint(f"j{i}", parent, f"body {i}", kind, axis=axis, **place))
    return urdf(*parts)


def loaded(text: str, gravity):
    """(model, data) of MuJoCo."""
    specification = mujoco.MjSpec.from_string(text)
    specification.option.gravity = np.array(gravity, float)
    model = specification.compile()
    return model, mujoco.MjData(model)


def set_joints(model, data, values: dict) -> None:
    for name, value in values.items():
        data.qpos[model.joint(name).qposadr[0]] = value
    data.qvel[:] = 0
    mujoco.mj_forward(model, data)


@pytest.mark.parametrize("seed", range(4))
def test_stiffness_with_a_loop_by_differences_of_its_forces(seed):
    # weight, joint springs and the force of a loop on points: J^T lambda with MuJoCo's Jacobians of points
    rng = np.random.default_rng(seed)
    text, gravity = spatial_arm(rng), rng.normal(size=3) * 5
    guess = {f"j{i}": float(x) for i, x in enumerate(rng.uniform(-1, 1, 6))}
    stiffness = dict(zip(guess, rng.uniform(20, 60, 6)))
    point = rng.uniform(-0.3, 0.3, 3)
    loop = mb.Loop("body 5", point, "ground", name="tip")
    robot = mb.Robot(text, gravity=gravity, loops=[loop], joint_stiffness=stiffness, joint_rest=guess)
    posture = robot.equilibrium(guess)
    system = robot.linearize(posture)
    model, data = loaded(text, gravity)
    names = [model.joint(i).name for i in range(model.nv)]
    k, rest = np.array([stiffness[n] for n in names]), np.array([guess[n] for n in names])

    def jacobian():
        J, place = np.zeros((3, model.nv)), data.body("body 5")
        mujoco.mj_jac(model, data, J, None, place.xpos + place.xmat.reshape(3, 3) @ point, model.body("body 5").id)
        return J

    def forces(q, pull):
        data.qpos[:], data.qvel[:] = q, 0
        mujoco.mj_forward(model, data)
        return data.qfrc_bias + k * (q - rest) + jacobian().T @ pull  # the pull is on the ground

    q = np.array([posture.joints[n] for n in names])
    load = forces(q, np.zeros(3))
    pull = np.linalg.lstsq(jacobian().T, -load, rcond=None)[0]
    N = null_space(jacobian())
    assert np.abs(forces(q, pull)).max() < 1e-10
    h = 1e-3
    columns = [
        (8 * (forces(q + u, pull) - forces(q - u, pull)) - (forces(q + 2 * u, pull) - forces(q - 2 * u, pull))) / (12 * h)
        for u in np.eye(model.nv) * h
    ]
    expected = N.T @ np.array(columns).T @ N
    places = [robot.coordinates.index(n) for n in names]
    actual = N.T @ system.stiffness[np.ix_(places, places)] @ N
    assert np.abs(actual - expected).max() <= 1e-9 * np.abs(expected).max()


def test_four_bar_simulated_with_stiff_connections():
    # MuJoCo holds loops by stiff springs and its own integrator: frequencies agree as the step goes to zero, 4e-6 here
    p = given("four-bar")
    robot, guess = linkages.four_bar(p)
    posture = robot.equilibrium(guess)
    _, coupler, rocker = p["lengths"]
    text = linkages.four_bar_text(p)
    specification = mujoco.MjSpec.from_string(text)
    specification.option.gravity, specification.option.timestep = np.array(PLANE), 1e-3
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
    set_joints(model, data, posture.joints)
    mujoco.mj_step(model, data, 400)
    data.qvel[:] = 0
    A = np.zeros((2 * model.nv, 2 * model.nv))
    mujoco.mjd_transitionFD(model, data, 1e-6, True, A, None, None, None)
    values = np.log(np.linalg.eigvals(A).astype(complex)) / model.opt.timestep
    slow = min(values[np.abs(values.imag) > 1e-3], key=lambda s: abs(s))
    assert abs(slow) == pytest.approx(known_frequencies("four-bar")[0], rel=2e-5)
    assert abs(slow) == pytest.approx(robot.linearize(posture).modes().natural_frequencies[0], rel=2e-5)
