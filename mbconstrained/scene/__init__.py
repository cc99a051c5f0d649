"""Scene files: read, checked, planned, run."""

from .plan import Plan, Stage
from .result import Result
from .scene import Scene, read_scene

__all__ = ["Plan", "Result", "Scene", "Stage", "read_scene"]
