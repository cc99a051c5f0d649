"""A small robot that tests write into a folder and change: a crank on a pivot, a slider, a loop between them."""

from pathlib import Path

ROBOTS = Path(__file__).parents[2] / "robots"

URDF = """<?xml version="1.0"?>
<robot name="press">
  <link name="base"><visual><geometry><box size="0.2 0.1 0.02"/></geometry></visual></link>
  <link name="crank">
    <inertial><origin xyz="0.1 0 0"/><mass value="1"/><inertia ixx="0.001" ixy="0" ixz="0" iyy="0.004" iyz="0" izz="0.004"/></inertial>
    <visual><origin xyz="0.1 0 0"/><geometry><box size="0.2 0.02 0.02"/></geometry></visual>
  </link>
  <link name="ram">
    <inertial><mass value="2"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
  </link>
  <joint name="pivot" type="continuous"><parent link="base"/><child link="crank"/><axis xyz="0 -1 0"/></joint>
  <joint name="slide" type="prismatic">
    <parent link="base"/><child link="ram"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="100" velocity="1"/>
  </joint>
</robot>
"""

TOML = """
title = "Press"
source = "tests"
licence = "MIT"
urdf = "press.urdf"
joint_stiffness = { pivot = "40 N*m/rad", slide = "3 N/mm" }
joint_rest = { pivot = 0, slide = 0 }
joint_damping = { pivot = "0.1 N*m*s/rad", slide = "4 N*s/m" }

[[spring]]
name = "tie"
body1 = "crank"
point1 = ["20 cm", 0, 0]
body2 = "ram"
point2 = [0, 0, 0]
stiffness = "1 N/mm"
preload = "5 N"

[posture]
guess = { pivot = "5 deg", slide = "2 cm" }
"""

SCENE = """
[model]
kind = "robot"
robot = "robots/press"

[initial]
displacement = { pivot = "1 deg" }

[time]
end = "1 s"
points = 21
"""


def press(folder: Path, toml: str = TOML, urdf: str = URDF) -> Path:
    """The folder of the robot, written into another."""
    robot = folder / "robots" / "press"
    robot.mkdir(parents=True, exist_ok=True)
    (robot / "robot.toml").write_text(toml, encoding="utf-8")
    (robot / "press.urdf").write_text(urdf, encoding="utf-8")
    return robot
