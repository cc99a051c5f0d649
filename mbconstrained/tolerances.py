"""The one tolerance policy.

A computed number counts as zero when it is no larger than the rounding noise that it was made with. The
noise is carried along with the data (``linalg.rank``, ``linalg.staircase``) from its start, half a unit in
the last place of every entry, so that no decision needs an absolute threshold and none depends on units.
The few constants of the package's algorithms are here, each with its reason.
"""

import numpy as np

EPS = float(np.finfo(float).eps)

#: Carried noise counts roundings to first order, one each; over several steps of a staircase true errors were seen
#: to reach ten times that. A number below this many times its noise counts as zero.
NOISE_SAFETY = 16.0

#: A rank decision is clear when the smallest kept value stands this far above that bound, and the largest dropped
#: one this far below it, near its noise itself; closer ones are told.
CLEAR_KEPT, CLEAR_DROPPED = 1e3, 0.1

#: Largest entry norm of a decoupling transformation between two blocks of J. A larger bound separates closer
#: zeros, a smaller one loses fewer digits; clusters up to this bound are evaluated as one block instead.
DECOUPLING_LIMIT = 1e3

#: Two zeros are one zero of higher multiplicity when they differ by less than this many noise radii.
CLUSTER_SAFETY = 1e3

#: The error estimate compares the answer with answers from data moved by this many units in the last place.
PROBE_SIZE = 1.0

#: Least estimate of the relative error where a rank decision is not clear: if it is wrong, so is all that follows.
UNCLEAR_ERROR = 0.1

#: An answer with a larger estimated relative error than this cannot be trusted (exit code 3).
TRUST_LIMIT = 1e-3


def noise_of(size, count: int = 1):
    """Rounding noise of a sum of ``count`` terms of magnitude ``size``."""
    return NOISE_SAFETY * EPS * max(count, 1) ** 0.5 * size


def rounding_radius(multiplicity: int) -> float:
    """How far, relative to its size, rounding may move the parts of a zero of this multiplicity."""
    return (CLUSTER_SAFETY * EPS) ** (1 / multiplicity)
