"""Where the motion of a robot is more than the small one that its equations are made for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..notices import Notice
from .happenings import sized

if TYPE_CHECKING:
    from .robot import RobotScene

#: Angles from the posture (rad) beyond which it is said that the equations are linear: sin(x) is off by 4 % there.
SMALL = 0.5


def motion_notices(found: RobotScene | None, values: np.ndarray) -> tuple[Notice, ...]:
    """On large angles and on joints that leave their limits, from the deviations (n, T); nothing without a robot."""
    if found is None:
        return ()
    count = len(found.robot.coordinates)
    lowest, highest = values[:count].min(axis=1), values[:count].max(axis=1)
    return (*_large(found, np.maximum(-lowest, highest)), *_beyond_limits(found, lowest, highest))


def _large(found: RobotScene, furthest: np.ndarray) -> list[Notice]:
    angles = np.where(np.array(found.robot.units) == "rad", furthest, 0.0)
    most = int(angles.argmax())
    if angles[most] <= SMALL:
        return []
    where = f"{found.robot.coordinates[most]} goes {sized(float(angles[most]), 'rad')} from the posture"
    return [
        Notice("large motion", f"{where}: the equations are linear about it, and a robot that moves so far does not follow them")
    ]


def _beyond_limits(found: RobotScene, lowest: np.ndarray, highest: np.ndarray) -> list[Notice]:
    notices, robot = [], found.robot
    for name, (low, high) in robot.limits.items():
        place, rest = robot.coordinates.index(name), found.posture.joints[name]
        for reached in {rest + lowest[place], rest + highest[place]}:
            if not low <= reached <= high:
                unit = robot.units[place]
                text = f"{name} reaches {sized(float(reached), unit)}, beyond its limits {low:.6g} ... {high:.6g} {unit}"
                notices.append(Notice("large motion", f"{text}: what happens there is not in the equations"))
    return notices
