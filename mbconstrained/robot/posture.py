"""Postures: equilibria of a robot."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..ground.checks import nearest
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError
from ..ground.notices import Notice
from .mechanism import Attached
from .robot_model import RobotModel
from .statics.balance import Balance


@dataclass(frozen=True, repr=False, eq=False)
class Posture(Displayed):
    """An equilibrium of a robot.

    Attributes:
        robot: the robot.
        configuration: q, shape (nq,).
        joints: configuration by joint: a number (rad, m), or the numbers of a joint with several degrees of freedom.
        multipliers: of the rows of all loops and mimic joints, of least norm where they are not determined (torques over the
            size of the robot), shape (m,) (N, N m).
        reactions: by loop, spring and bushing: force (N) and torque (N m) on its second body, in the frame on the first, shape (6,).
        torques: by joint that keeps the guess: the load that keeps it in place, besides springs with a rest (N m, N).
        residual: largest unbalanced force relative to the largest force.
        loop_error: largest opening of a loop (m, rad).
        notices: notices on redundant rows, and on parts of the description that were left out.
    """

    robot: RobotModel
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
        """Force and torque of each loop, spring and bushing."""
        reactions, start = {}, 0
        for item, G in zip(self.loops, self.balance.gradients):
            reactions[item.connection.name] = G.T @ self.multipliers[start : start + len(G)]
            start += len(G)
        springs = zip(self.balance.load.springs, self.balance.elastic)
        return reactions | {item.connection.name: own.wrench for item, own in springs}

    @property
    def ground_reactions(self) -> dict[str, np.ndarray]:
        """Reactions in the directions of the ground, about the same point, shape (6,) (N, N m)."""
        items = {item.connection.name: item for item in (*self.loops, *self.balance.load.springs)}
        return {name: items[name].pose(self.balance.kinematics).directions @ own for name, own in self.reactions.items()}

    def __getitem__(self, joint: str):
        if joint not in self.joints:
            raise InputError(f'posture: there is no joint "{joint}"{nearest(str(joint), self.joints)}')
        return self.joints[joint]

    def _summary(self) -> str:
        values = ", ".join(f"{name}: {value:.6g}" for name, value in self.joints.items() if isinstance(value, float))
        return f"{values}; residual {self.residual:.1e}, loops open by {self.loop_error:.1e}"

    def _tables(self) -> tuple[TextTable, ...]:
        rows = ((name, ", ".join(f"{part:.6g}" for part in np.atleast_1d(value))) for name, value in self.joints.items())
        return TextTable("Joints", ("joint", "value (rad, m)"), tuple(rows)), notice_table(self.notices)
