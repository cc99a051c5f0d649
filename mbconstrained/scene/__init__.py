"""Scene files: read, checked, planned, run."""

from .plan import Plan, Stage
from .result import Result
from .robot_file import RobotData, read_robot
from .scene import Scene, read_scene

__all__ = ["Plan", "Result", "RobotData", "Scene", "Stage", "read_robot", "read_scene"]
