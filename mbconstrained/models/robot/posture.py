"""A robot at rest."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ...checks import nearest
from ...errors import InputError
from ...notices import Notice
from .balance import Balance
from .mechanism import Attached

if TYPE_CHECKING:
    from .robot import Robot


@dataclass(frozen=True, repr=False)
class Posture:
    """An equilibrium of a robot.

    Attributes:
        robot: the robot.
        configuration: q, shape (nq,).
        joints: the same by joint: a number (rad, m), or the numbers of a body that moves in several ways.
        multipliers: of the rows of all loops and of joints that follow others, those of least norm where they are not determined
            (torques over the size of the robot), shape (m,) (N, N m).
        reactions: the same by loop: force (N) and torque (N m) on its second body, in the frame on the first, shape (6,).
        torques: by held or flexible joint: what it needs to stay (N m, N).
        residual: largest force that is not balanced, relative to the largest that acts.
        loop_error: largest opening of a loop (m, rad).
        notices: redundant rows, what of the robot's description was left out.
    """

    robot: Robot
    configuration: np.ndarray
    multipliers: np.ndarray
    torques: dict[str, float]
    residual: float
    loop_error: float
    notices: tuple[Notice, ...]
    balance: Balance = field(repr=False)
    independent_rows: tuple[int, ...] = ()

    @property
    def joints(self) -> dict[str, float | tuple[float, ...]]:
        """Values by joint."""
        return self.robot.tangent.values(self.configuration)

    @property
    def loops(self) -> tuple[Attached, ...]:
        """The loops with their frames."""
        return self.balance.load.loops

    @property
    def reactions(self) -> dict[str, np.ndarray]:
        """Force and torque of each loop."""
        found, start = {}, 0
        for item in self.loops:
            rows = item.connection.rows
            found[item.connection.name] = rows.T @ self.multipliers[start : start + len(rows)]
            start += len(rows)
        return found

    def __getitem__(self, joint: str):
        if joint not in self.joints:
            raise InputError(f'posture: there is no joint "{joint}"{nearest(str(joint), self.joints)}')
        return self.joints[joint]

    def __repr__(self) -> str:
        values = ", ".join(f"{name}: {value:.6g}" for name, value in self.joints.items() if isinstance(value, float))
        return f"Posture({values}; residual {self.residual:.1e}, loops open by {self.loop_error:.1e})"
