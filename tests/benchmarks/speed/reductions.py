"""What peers are given for nothing: z' = S z + b u, x = E z, reduced by hand without anything of the package.

Second halves are added to the masses that they are tied to, joints without damper are condensed one by one, joints with one
become states of the first order. The same steps run in float64, in long doubles or in fractions, as the entries are.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from tests.benchmarks.speed.models import Chain


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
