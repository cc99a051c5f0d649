"""The models of the speed benchmarks as a user would give them, and what peers are given for nothing.

The chain has n masses between two walls. Every tenth mass is made of two halves, each with a coordinate of its own, which a
constraint row ties together; in every tenth link there is a massless joint between two springs, and every second joint has a
damper too. Constants vary along the chain, so that the damping is not proportional and no two links are alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from mbconstrained import Constraint, LumpedModel, MechanicalSystem

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


def _between(matrix: np.ndarray, left: int | None, right: int | None, constant) -> None:
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


# Reductions by hand, z' = S z + b u, x = E z, without anything of the package. Second halves are added to the masses that they are tied to,
# joints without damper are condensed one by one, joints with one become states of the first order. The same steps run in float64, in
# long doubles or in fractions, as the entries are.


@dataclass(frozen=True)
class Equations:
    """z' = S z, x = E z.

    Attributes:
        S: shape (m, m).
        E: shape (N, m).
        start: z(0), shape (m,).
        b: what a unit force does to z', shape (m,); zero where there is none.
        mass, stiffness: of the reduced coordinates, where x'' = -M^-1 K x is all that happens; or None.
    """

    S: np.ndarray
    E: np.ndarray
    start: np.ndarray
    b: np.ndarray
    mass: np.ndarray | None = None
    stiffness: np.ndarray | None = None


def as_fractions(array) -> np.ndarray:
    """The same numbers as fractions, in an array of objects."""
    return np.array([Fraction(value) for value in np.ravel(array).tolist()], dtype=object).reshape(np.shape(array))


def reduced_chain(given: Chain, convert=np.asarray, pushed: int | None = None) -> Equations:
    """The chain with states x and x' of the masses and the places of damped joints.

    Args:
        given: the chain.
        convert: what entries become before anything is done with them.
        pushed: the mass on which a force acts.
    """
    matrices = [np.array(convert(matrix)) for matrix in (given.mass, given.damping, given.stiffness)]
    for matrix in matrices:
        for half, owner in given.halves:
            _moved(matrix, half, owner)
    mass, damping, stiffness = matrices
    held = [(joint, _condensed(stiffness, joint)) for joint in given.joints]
    x, damped = np.arange(given.count), given.damped_joints
    S = _first_order(np.diag(mass)[x], damping, stiffness, x, damped)
    E = _coordinates(given, held, S)
    start = np.concatenate([np.array(convert(given.start))[x], S[0, x] * 0, np.array(convert(given.start))[damped]])
    b = S[0] * 0
    if pushed is not None:
        b[given.count + pushed] = 1 / mass[pushed, pushed]
    plain = not given.damping.any()
    pair = (mass[np.ix_(x, x)], stiffness[np.ix_(x, x)]) if plain else (None, None)
    return Equations(S, E, start, b, *pair)


def with_oscillator(equations: Equations, angular_frequency) -> Equations:
    """With the force cos w t as two more states, the output of an oscillator."""
    m, w = len(equations.S), angular_frequency
    S = np.zeros((m + 2, m + 2), dtype=equations.S.dtype)
    S[:m, :m], S[:m, m] = equations.S, equations.b
    S[m, m + 1], S[m + 1, m] = -w, w
    more = np.array([1, 0], dtype=equations.S.dtype)
    E = np.hstack([equations.E, np.zeros((len(equations.E), 2), dtype=equations.E.dtype)])
    return Equations(S, E, np.concatenate([equations.start, more]), np.append(equations.b, more * 0))


def _moved(matrix: np.ndarray, half: int, owner: int) -> None:
    """What hangs on a second half hangs on its owner."""
    matrix[owner] += matrix[half]
    matrix[:, owner] += matrix[:, half]
    matrix[half] = matrix[:, half] = 0


def _condensed(stiffness: np.ndarray, joint: int) -> dict[int, object]:
    """Take a joint out; gives by which factors it follows its neighbours."""
    beside = [int(at) for at in np.flatnonzero(stiffness[joint]) if at != joint]
    factors = {at: -stiffness[joint, at] / stiffness[joint, joint] for at in beside}
    for one in beside:
        for other in beside:
            stiffness[one, other] += stiffness[one, joint] * factors[other]
    return factors


def _first_order(masses, damping, stiffness, x, damped) -> np.ndarray:
    """Rows x' = v, then M v' = -K x - K g - C v - C g', then C g' = -K g - K x - C v of damped joints g."""
    n, m = len(x), 2 * len(x) + len(damped)
    S = np.zeros((m, m), dtype=damping.dtype)
    S[x, n + x] = 1
    joint = range(2 * n, m)
    for row, at in zip(joint, damped):
        beside = [int(place) for place in np.flatnonzero(damping[at]) if place != at]
        S[row, x] = -stiffness[at, x] / damping[at, at]
        S[row, row] = -stiffness[at, at] / damping[at, at]
        S[row, n + np.array(beside)] = -damping[at, beside] / damping[at, at]
    block = S[n : 2 * n]
    block[:, x], block[:, n : 2 * n] = -stiffness[np.ix_(x, x)], -damping[np.ix_(x, x)]
    for row, at in zip(joint, damped):
        block[x, row] -= stiffness[x, at]
        for mass in np.flatnonzero(damping[x, at]):
            block[mass] -= damping[mass, at] * S[row]
    block /= masses[:, None]
    return S


def _coordinates(given: Chain, held, S) -> np.ndarray:
    """All N coordinates of z."""
    n, E = given.count, np.zeros((given.size, len(S)), dtype=S.dtype)
    E[np.arange(n), np.arange(n)] = 1
    E[given.halves[:, 0], given.halves[:, 1]] = 1
    E[given.damped_joints, 2 * n + np.arange(len(given.damped_joints))] = 1
    for joint, factors in held:
        for at, factor in factors.items():
            E[joint, at] = factor
    return E


# Examples 5.1 and 5.2 of Moysis et al.: as they are given, and by hand as first-order equations in fractions.

#: Places at rest, m.
STARTS = {"5.1": (0.8, 1.2, 2.0), "5.2": (float(Fraction(2, 3)), 1.0, 2.0)}


def example_system(name: str) -> MechanicalSystem:
    """Two masses held at acceleration level (5.1); massless joints between springs and dampers (5.2)."""
    if name == "5.1":
        return MechanicalSystem(
            mass=[[10, 0, 0], [0, 10, 10], [0, 10, 10]],
            stiffness=np.diag([2.0, 0.0, 2.0]),
            constraints=[Constraint([1, -1, 0], level="acceleration")],
        )
    return MechanicalSystem(
        mass=np.diag([0.0, 0.0, 10.0]), damping=[[0, 0, 0], [0, 12, -4], [0, -4, 4]], stiffness=[[9, 0, -3], [0, 0, 0], [-3, 0, 3]]
    )


def example_equations(name: str) -> Equations:
    """5.1: six states, x'' from 10 x1'' + 10 q1'' + 10 q2'' = -2 x1, 10 q1'' + 10 q2'' = -2 q2, x1'' = q1''.

    5.2: 9 u1 = 3 u3, 12 u2' = 4 u3', 10 u3'' = 3 u1 - 3 u3 + 4 u2' - 4 u3'; three states.
    """
    start = as_fractions(STARTS[name])
    if name == "5.1":
        acceleration = as_fractions([[-1, 0, 1], [-1, 0, 1], [1, 0, -2]]) / 5
        S = as_fractions(np.zeros((6, 6)))
        S[:3, 3:], S[3:, :3] = as_fractions(np.eye(3)), acceleration
        return Equations(S, as_fractions(np.eye(3, 6)), np.concatenate([start, start * 0]), S[0] * 0)
    S = as_fractions(np.zeros((3, 3)))
    S[0, 2], S[1, 2], S[2, 1], S[2, 2] = Fraction(1, 3), Fraction(1), Fraction(-1, 5), Fraction(-4, 15)
    E = as_fractions([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
    E[0, 1] = Fraction(1, 3)
    return Equations(S, E, np.array([start[1], start[2], start[0] * 0]), S[0] * 0)


# W6: ten pairs of masses between walls, soft springs between pairs and a stiff one within each, given as elements.

PAIRS = 10

#: The slowest oscillation: pairs of 2 kg on springs of 1 N/m between walls, rad/s.
SLOWEST = 2.0 * np.sqrt(0.5) * np.sin(np.pi / (2 * (PAIRS + 1)))


def springs(ratio: float) -> list[tuple[int | None, int | None, float]]:
    """Ends, None for a wall, and stiffness in N/m, along the chain."""
    places = [None, *range(2 * PAIRS), None]
    return [(left, right, float(ratio) if at % 2 else 1.0) for at, (left, right) in enumerate(pairwise(places))]


def stack_start() -> np.ndarray:
    """Half a sine over the pairs, whose two masses move alike, m."""
    return np.repeat(np.sin(np.pi * np.arange(1, PAIRS + 1) / (PAIRS + 1)), 2)


def stack_model(ratio: float, damping: float) -> LumpedModel:
    """As a user builds it; each soft spring has a damper beside it where there is damping (N s/m)."""
    model = LumpedModel()
    names = {None: "ground", **{at: f"mass {at + 1}" for at in range(2 * PAIRS)}}
    for at in range(2 * PAIRS):
        model.mass(names[at], 1.0)
    for left, right, stiffness in springs(ratio):
        model.spring(names[left], names[right], stiffness=stiffness)
        if damping and stiffness == 1.0:
            model.damper(names[left], names[right], damping=damping)
    return model


def stack_equations(ratio: float, damping: float, exactly: bool) -> Equations:
    """z = (x, x'); in fractions nothing is lost, in float64 the assembled matrix is what every peer starts from."""
    size = 2 * PAIRS
    S = as_fractions(np.zeros((2 * size, 2 * size))) if exactly else np.zeros((2 * size, 2 * size))
    number = Fraction if exactly else float
    S[np.arange(size), size + np.arange(size)] = number(1)
    for left, right, stiffness in springs(ratio):
        _between(S[size:, :size], left, right, -number(stiffness))
        if damping and stiffness == 1.0:
            _between(S[size:, size:], left, right, -number(damping))
    start = np.concatenate([stack_start(), np.zeros(size)])
    E = np.eye(size, 2 * size)
    mass, K = (None, None) if damping or exactly else (np.eye(size), -S[size:, :size])
    return Equations(S, as_fractions(E) if exactly else E, as_fractions(start) if exactly else start, start * 0, mass, K)
