"""Where the robots of example-robot-data are, if they are installed, and the postures that the tests and benchmarks use.

They are looked for in the folder that the environment variable MBCONSTRAINED_ROBOT_DATA names (the one that holds
"robots"), then next to numpy, where the wheel puts them: <site-packages>/cmeel.prefix/share/example-robot-data.
"""

from __future__ import annotations

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
