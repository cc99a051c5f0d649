"""Joints that follow others: rows of the loops that are linear in two joint values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ...checks import real_number
from ...errors import InputError
from .tangent import Tangent
from .urdf import Mimic


@dataclass(frozen=True)
class Coupling:
    """q_follower - multiplier q_leader - offset = 0.

    Attributes:
        name: of the row.
        unit: of the follower, "m" or "rad".
        follower, leader: numbers of joints in the model.
        multiplier, offset: of the leader's value, and added to it.
    """

    name: str
    unit: str
    follower: int
    leader: int
    multiplier: float
    offset: float

    def gap(self, model, configuration: np.ndarray) -> float:
        """The left side, the short way round for a joint that turns without end."""
        leader = joint_way(model.joints[self.leader], configuration, 0.0)
        return joint_way(model.joints[self.follower], configuration, self.multiplier * leader + self.offset)

    def row(self, model) -> np.ndarray:
        """Its derivative, shape (nv,)."""
        row = np.zeros(model.nv)
        row[model.joints[self.follower].idx_v] = 1.0
        row[model.joints[self.leader].idx_v] -= self.multiplier
        return row


#: Two values of a joint are the same when they differ by less (rad, m, or relative where they are larger).
SAME = 1e-9


def locked_values(locked, mimics: tuple[Mimic, ...]) -> dict[str, float]:
    """Values of joints that do not move, with those of joints that follow them.

    Raises:
        InputError: not values by joint, a joint that is locked although what it follows is not, or at another value.
    """
    if locked is not None and not isinstance(locked, Mapping):
        raise InputError(f'locked: found {type(locked).__name__}; expected values by joint, such as {{"j4": 0.3}}')
    values = {name: real_number(value, f"locked: {name}") for name, value in (locked or {}).items()}
    for mimic in mimics:
        if mimic.leader in values or mimic.leader_is_fixed:
            follows = mimic.multiplier * values.get(mimic.leader, 0.0) + mimic.offset
            if abs(values.setdefault(mimic.follower, follows) - follows) > SAME * max(1.0, abs(follows)):
                raise InputError(
                    f'locked: "{mimic.follower}" follows "{mimic.leader}" and is then at {follows:.6g}; found '
                    f"{values[mimic.follower]:.6g}: leave it out"
                )
        elif mimic.follower in values:
            raise InputError(f'locked: "{mimic.follower}" follows "{mimic.leader}", which moves; lock that joint instead')
    return values


def couplings(mimics: tuple[Mimic, ...], tangent: Tangent) -> tuple[Coupling, ...]:
    """The couplings between joints that move; one with a locked joint is left out."""
    found = []
    for mimic in mimics:
        if mimic.follower in tangent.coordinates and mimic.leader in tangent.coordinates:
            numbers = [tangent.joints.index(name) + 1 for name in (mimic.follower, mimic.leader)]
            unit = tangent.units[tangent.coordinates.index(mimic.follower)]
            found.append(Coupling(f"{mimic.follower} follows {mimic.leader}", unit, *numbers, mimic.multiplier, mimic.offset))
    return tuple(found)


def joint_way(joint, configuration: np.ndarray, rest: float) -> float:
    """How far a joint with one degree of freedom is from a value (rad, m)."""
    value = configuration[joint.idx_q : joint.idx_q + joint.nq]
    if joint.nq == 1:
        return float(value[0] - rest)
    c, s = np.cos(rest), np.sin(rest)
    return float(np.arctan2(c * value[1] - s * value[0], c * value[0] + s * value[1]))
