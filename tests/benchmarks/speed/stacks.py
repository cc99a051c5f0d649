"""W6: ten pairs of masses between walls, soft springs between pairs and a stiff one within each, given as elements."""

from fractions import Fraction
from itertools import pairwise

import numpy as np

from mbconstrained import LumpedModel
from tests.benchmarks.speed.reductions import Equations, as_fractions

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
        _between(S[size:, :size], left, right, number(stiffness))
        if damping and stiffness == 1.0:
            _between(S[size:, size:], left, right, number(damping))
    start = np.concatenate([stack_start(), np.zeros(size)])
    E = np.eye(size, 2 * size)
    mass, K = (None, None) if damping or exactly else (np.eye(size), -S[size:, :size])
    return Equations(S, as_fractions(E) if exactly else E, as_fractions(start) if exactly else start, start * 0, mass, K)


def _between(matrix, left: int | None, right: int | None, constant) -> None:
    ends = [end for end in (left, right) if end is not None]
    for one in ends:
        for other in ends:
            matrix[one, other] -= constant if one == other else -constant
