"""Where the robots of example-robot-data are, if they are installed, and the postures that the tests and benchmarks use.

They are looked for in the folder that the environment variable MBCONSTRAINED_ROBOT_DATA names (the one that holds
"robots"), then next to numpy, where the wheel puts them: <site-packages>/cmeel.prefix/share/example-robot-data.
"""

import os
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

import mbconstrained as mb

SOLES = ("left_sole_link", "right_sole_link")


def folder() -> Path | None:
    """The folder that holds "robots"."""
    requested = os.environ.get("MBCONSTRAINED_ROBOT_DATA")
    places = [Path(requested)] if requested else []
    places.append(Path(np.__file__).parents[1] / "cmeel.prefix/share/example-robot-data")
    return next((place for place in places if (place / "robots").is_dir()), None)


def file(name: str) -> Path:
    return folder() / "robots" / name


def half_sitting() -> dict:
    """Of the SRDF of Talos, by joint; the base as 7 numbers."""
    tree = ElementTree.parse(file("talos_data/srdf/talos.srdf"))
    state = next(item for item in tree.iter("group_state") if item.get("name") == "half_sitting")
    values = {item.get("name"): [float(x) for x in item.get("value").split()] for item in state.iter("joint")}
    return {name: value if len(value) > 1 else value[0] for name, value in values.items()}


def talos():
    """(robot, guess): on two feet, joint springs of 3000 N m/rad and dampers of 10 N m s/rad."""
    sitting = half_sitting()
    loops = [mb.Loop(sole, (0, 0, 0), "ground", kind="rigid", name=sole.split("_")[0]) for sole in SOLES]
    path = file("talos_data/robots/talos_reduced.urdf")
    guess = {name: sitting.get(name, 0.0) for name in mb.Robot(path).joints}
    stiffness, damping = dict.fromkeys(guess, 3000.0), dict.fromkeys(guess, 10.0)
    robot = mb.Robot(path, loops=loops, base="free", joint_stiffness=stiffness, joint_rest=guess, joint_damping=damping)
    return robot, {**guess, "base": sitting["root_joint"]}


UNITREE, ANYMAL = "FL_foot FR_foot RL_foot RR_foot", "LF_FOOT RF_FOOT LH_FOOT RH_FOOT"

#: Legged robots: folder, URDF, SRDF with a posture (None: all joints at 0), feet, and what each foot does to the ground.
LEGGED = {
    "anymal c": ("anymal_c_simple_description", "urdf/anymal", "srdf/anymal", ANYMAL, "point"),
    "hyq": ("hyq_description", "robots/hyq_no_sensors", "srdf/hyq", "lf_foot rf_foot lh_foot rh_foot", "point"),
    "go1": ("go1_description", "urdf/go1", "srdf/go1", UNITREE, "point"),
    "g1": ("g1_description", "urdf/g1_29dof_rev_1_0", None, "left_ankle_roll_link right_ankle_roll_link", "rigid"),
    "romeo": ("romeo_description", "urdf/romeo_small", "srdf/romeo_small", "l_sole r_sole", "rigid"),
    "a1": ("a1_description", "urdf/a1", "srdf/a1", UNITREE, "point"),
    "go2": ("go2_description", "urdf/go2", "srdf/go2", UNITREE, "point"),
    "b1": ("b1_description", "urdf/b1", "srdf/b1", UNITREE, "point"),
    "laikago": ("laikago_description", "urdf/laikago", None, UNITREE, "point"),
    "solo12": ("solo_description", "robots/solo12", "srdf/solo", "FL_FOOT FR_FOOT HL_FOOT HR_FOOT", "point"),
    "anymal": ("anymal_b_simple_description", "robots/anymal", "srdf/anymal", ANYMAL, "point"),
    "anymal-kinova": ("anymal_b_simple_description", "robots/anymal-kinova", "srdf/anymal-kinova", ANYMAL, "point"),
}


def legged_urdf(name: str) -> Path:
    folder, urdf, *_ = LEGGED[name]
    return file(f"{folder}/{urdf}.urdf")


def standing(name: str, seed: int):
    """(robot, guess): on two to four feet, or on two soles, near the posture of the SRDF; joint springs and dampers of any size."""
    rng = np.random.default_rng(seed)
    own, _, srdf, feet, kind = LEGGED[name]
    urdf, state = legged_urdf(name), ()
    if srdf:
        state = next(ElementTree.parse(file(f"{own}/{srdf}.srdf")).iter("group_state"), ())
    given = {item.get("name"): [float(x) for x in item.get("value").split()] for item in state}
    bare = mb.Robot(urdf, base="free")
    guess = {}
    for joint in bare.joints[1:]:
        low, high = bare.limits.get(joint, (-np.inf, np.inf))
        value = given.get(joint, [0.0])[0] + 0.1 * rng.standard_normal()
        guess[joint] = float(np.clip(value, low + 0.01, high - 0.01))
    standing_on = feet.split()[: 2 + seed % 3]
    loops = [mb.Loop(foot, (0, 0, 0), "ground", kind=kind, name=foot) for foot in standing_on]
    stiffness, damping = ({name: float(10 ** rng.uniform(*decades)) for name in guess} for decades in ((1.5, 3.5), (-1, 1)))
    robot = mb.Robot(urdf, loops=loops, base="free", joint_stiffness=stiffness, joint_rest=guess, joint_damping=damping)
    base = next((value for value in given.values() if len(value) == 7), [0, 0, 1, 0, 0, 0, 1])
    return robot, {**guess, "base": base}
