"""The models of the speed benchmarks as a user would give them: matrices and constraint rows, nothing reduced.

The chain has n masses between two walls. Every tenth mass is made of two halves, each with a coordinate of its own, which a
constraint row ties together; in every tenth link there is a massless joint between two springs, and every second joint has a
damper too. Constants vary along the chain, so that the damping is not proportional and no two links are alike.
"""

from dataclasses import dataclass

import numpy as np

#: Places within each ten masses: the one with two halves, and the link that has a joint.
TIED, JOINTED = 4, 8

#: Of a joint with a damper, N s/m: with its springs its place follows within some seconds.
JOINT_DAMPING = 5.0

#: Bits that a step of time has, so that its multiples are float64 numbers exactly.
BITS = 24


@dataclass(frozen=True)
class Chain:
    """M x'' + C x' + K x = f with rows x = 0, of N coordinates: masses, second halves, joints.

    Attributes:
        mass, damping, stiffness: shape (N, N), kg, N s/m, N/m.
        rows: shape (k, N), zero at all times.
        start: a smooth shape at rest that breaks no equation, shape (N,), m.
        count: the number n of masses, which come first.
        halves: coordinates of second halves, and of the masses that they belong to, shape (k, 2).
        joints: coordinates of the joints without damper.
        damped_joints: coordinates of those with one.
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    rows: np.ndarray
    start: np.ndarray
    count: int
    halves: np.ndarray
    joints: np.ndarray
    damped_joints: np.ndarray

    @property
    def size(self) -> int:
        """The number N of coordinates."""
        return len(self.mass)

    @property
    def states(self) -> int:
        """Two for each mass, one for each joint with a damper."""
        return 2 * self.count + len(self.damped_joints)


def chain(count: int, damped: bool = True, damped_joints: bool = True) -> Chain:
    """The chain of so many masses, with n/10 ties and n/10 joints.

    Args:
        count: n.
        damped: whether links have dampers.
        damped_joints: whether every second joint has one.
    """
    tens = count // 10
    size = count + 2 * tens
    halves = np.array([[count + ten, 10 * ten + TIED] for ten in range(tens)], dtype=int).reshape(-1, 2)
    joints = count + tens + np.arange(tens)
    with_damper = joints[1::2] if damped_joints else joints[:0]
    mass = np.diag(_masses(count, halves, size))
    damping, stiffness = np.zeros((2, size, size))
    for link in range(count + 1):
        _add_link(stiffness, damping, link, halves, joints, damped)
    for joint in with_damper:
        ten = joint - count - tens
        _between(damping, 10 * ten + JOINTED - 1, joint, JOINT_DAMPING)
    rows = np.zeros((tens, size))
    rows[np.arange(tens), halves[:, 0]], rows[np.arange(tens), halves[:, 1]] = -1.0, 1.0
    start = _shape(stiffness, count, halves, joints)
    return Chain(mass, damping, stiffness, rows, start, count, halves, np.setdiff1d(joints, with_damper), with_damper)


def even_times(end: float, count: int = 1000) -> np.ndarray:
    """Times from 0 to about the end, exact multiples of one step, shape (count,), s.

    >>> times = even_times(50.0)
    >>> bool((times == times[1] * np.arange(1000)).all()), round(times[-1], 4)
    (True, 50.0)
    """
    step = end / (count - 1)
    unit = 2.0 ** (np.floor(np.log2(step)) - BITS)
    return unit * np.round(step / unit) * np.arange(count)


def forty_periods(count: int) -> float:
    """About 40 periods of the slowest oscillation of a chain whose waves move one mass a second, s."""
    return 40 * 2.0 * (count + 1)


def _masses(count: int, halves: np.ndarray, size: int) -> np.ndarray:
    masses = np.zeros(size)
    masses[:count] = 1.0 + 0.2 * np.cos(1.7 * np.arange(count))
    for half, owner in halves:
        masses[half] = masses[owner] = masses[owner] / 2
    return masses


def _add_link(stiffness, damping, link: int, halves, joints, damped: bool) -> None:
    """Link i joins mass i - 1, or its second half, and mass i; walls stand at both ends."""
    count = len(stiffness) - len(halves) - len(joints)
    left, right = link - 1 if link else None, link if link < count else None
    ten, place = divmod(link, 10)
    constant = 1.0 + 0.3 * np.sin(link)
    if ten < len(halves) and place == TIED + 1:
        left = halves[ten, 0]
    if ten < len(joints) and place == JOINTED:
        _between(stiffness, left, joints[ten], 2.0 * constant)
        _between(stiffness, joints[ten], right, 3.0 * constant)
        return
    _between(stiffness, left, right, constant)
    if damped:
        _between(damping, left, right, 0.01 * (1.0 + 0.5 * np.sin(2.3 * link)))


def _between(matrix: np.ndarray, left: int | None, right: int | None, constant: float) -> None:
    """An element between two coordinates, None for a wall."""
    ends = [end for end in (left, right) if end is not None]
    for one in ends:
        for other in ends:
            matrix[one, other] += constant if one == other else -constant


def _shape(stiffness, count: int, halves, joints) -> np.ndarray:
    """Half a sine; each joint where its springs hold each other."""
    start = np.zeros(len(stiffness))
    start[:count] = np.sin(np.pi * np.arange(1, count + 1) / (count + 1))
    start[halves[:, 0]] = start[halves[:, 1]]
    for joint in joints:
        start[joint] = -(stiffness[joint, :count] @ start[:count]) / stiffness[joint, joint]
    return start
