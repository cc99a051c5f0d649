"""How accurate is the answer? The same problem, its data moved by about a rounding error, is solved again.

The data of A(s), of the values at 0- and of the force are moved entry by entry by a unit in the last place, and
the scaled finite part by as much as the eigenvalue algorithm's own backward error. The largest change of
the answer over a few such trials, times a safety factor, is the estimate: it sees the condition of the problem
and the rounding of the algorithm at once. Where a rank decision was not clear, the whole answer stands on it, and
the estimate is at least a tenth. The trials are seeded, so the estimate is reproducible.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..polynomial.matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction
from ..signals.inputs import ImpulsiveSmooth
from ..tolerances import EPS, PROBE_SIZE, UNCLEAR_ERROR

if TYPE_CHECKING:
    from .response import Response

TRIALS = 3
SAFETY = 4.0


def error_estimate(x: Response, times) -> float:
    """Estimate of max |error| / max |x| over the times, at least one rounding error."""
    from .solve import solve

    values = np.asarray(x(times))
    largest = np.abs(values).max(initial=0.0)
    if largest == 0:
        return EPS
    worst = 0.0 if all(decision.clear for decision in x.pairs.form.decisions) else UNCLEAR_ERROR * largest / SAFETY
    for seed in range(TRIALS):
        random = np.random.default_rng(seed)
        A = x.polynomial_matrix
        moved = PolynomialMatrix([_moved(matrix, random) for matrix in A.coefficients], A.coordinates, A.equations)
        other = solve(moved, _moved(x.initial, random), _moved_force(x.force, random))
        worst = max(worst, float(np.abs(other(times) - values).max()))
    return max(SAFETY * worst / largest, EPS)


def _moved(array, random) -> np.ndarray:
    return array * (1 + PROBE_SIZE * EPS * random.choice([-1.0, 1.0], size=np.shape(array)))


def _moved_force(force: ImpulsiveSmooth, random) -> ImpulsiveSmooth:
    smooth = force.smooth
    coefficients = _moved(smooth.coefficients, random)
    return ImpulsiveSmooth(
        BohlFunction(coefficients, smooth.blocks, smooth.start), tuple(_moved(g, random) for g in force.impulses)
    )
