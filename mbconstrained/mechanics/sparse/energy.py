"""The energy of what the kept modes do not carry: a free motion of the whole system, so that it never grows.

x_rest = x - W a - X z solves M x'' + C x' + K x = 0 between the times at which the force changes, exactly, and there it gains the
jump of -X z. With x'^T C x' >= 0 its energy is at most that of its starts: sqrt(2 E) <= sum of sqrt(2 E_j), as this is a norm.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse
from scipy.sparse.linalg import splu

from ...errors import MbconstrainedError
from ...signals.bohl import BohlFunction
from ...tolerances import EPS, NOISE_SAFETY
from .amplitudes import Amplitudes
from .carried import LeftOut
from .factorization import factorize
from .matrices import times
from .pencil import ReducedPencil


@dataclass(frozen=True)
class Remainder:
    """A bound of what is left out.

    Attributes:
        norm: of its energy norm sqrt(2 E).
        relative: the same, relative to all that moves.
        passive: whether it holds for all times.
        jumps: whether coordinates without mass jump at the start.
    """

    norm: float
    relative: float
    passive: bool
    jumps: bool


def remainder(left: LeftOut, displacement, velocity, amplitudes: Amplitudes, followed, smooth: BohlFunction) -> Remainder:
    """The bound for a start, and a force that changes at knots."""
    pencil, space, restarts = left.pencil, left.space, smooth.restarts
    generator = smooth.generator
    z, jumps = restarts.states[:, 0], restarts.jumps[:, 1:]
    states = amplitudes.start[:, None]
    driven = space.drive(np.asarray(_forces(left, smooth)) @ z[:, None])
    kept = space.shown(states)[:, 0], space.shown(space.turned(states) + driven)[:, 0]
    forced = followed @ z, followed @ (generator @ z)
    rest, jumped = _relaxed(pencil, displacement - kept[0] - forced[0])
    terms = [(displacement, velocity), kept, forced]
    first = _norm(pencil, rest, velocity - kept[1] - forced[1])
    sizes = [_norm(pencil, *term) for term in terms]
    if first <= NOISE_SAFETY * EPS * sum(_rough(pencil, *term) for term in terms):
        first = 0.0
    changes = _norms(pencil, followed, generator, jumps)
    norm = 0.0 if left.undamped.complete and space.modal else float(first + changes.sum())
    whole = max(sizes[0], sizes[1]) + sizes[2] + changes.sum()
    relative = min(norm / np.hypot(norm, whole), 1.0) if norm else 0.0
    return Remainder(norm, float(relative), _is_passive(left), jumped)


def _forces(left: LeftOut, smooth: BohlFunction) -> np.ndarray:
    return left.pencil.basis.T @ smooth.coefficients


def _norm(pencil: ReducedPencil, x, v) -> float:
    """(v^T M v + x^T K x)^(1/2)."""
    return max(float(v @ (pencil.mass @ v) + x @ (pencil.stiffness @ x)), 0.0) ** 0.5


def _rough(pencil: ReducedPencil, x, v) -> float:
    """The same of the sizes: rounding errors are this times the rounding of a number."""
    x, v = np.abs(x), np.abs(v)
    return float(v @ (abs(pencil.mass) @ v) + x @ (abs(pencil.stiffness) @ x)) ** 0.5


def _norms(pencil: ReducedPencil, followed, generator, jumps) -> np.ndarray:
    """The energy norm of X dz at each of the later changes of the force, shape (K - 1,)."""
    if not jumps.size:
        return np.zeros(0)
    turned = followed @ generator
    square = followed.T @ times(pencil.stiffness, followed) + turned.T @ times(pencil.mass, turned)
    return np.maximum((jumps * (square @ jumps)).sum(axis=0), 0.0) ** 0.5


def _relaxed(pencil: ReducedPencil, rest: np.ndarray) -> tuple[np.ndarray, bool]:
    """With coordinates that have neither mass nor damping where the springs hold them, and whether that moved them."""
    empty = np.diff(pencil.mass.indptr) + np.diff(pencil.damping.indptr) == 0
    if not empty.any() or pencil.rows.shape[0]:
        return rest, False
    stiffness = scipy.sparse.csr_array(pencil.stiffness)[empty]
    own, forces = scipy.sparse.csc_array(stiffness[:, empty]), stiffness @ rest
    noise = NOISE_SAFETY * EPS * (abs(stiffness) @ np.abs(rest))
    if (np.abs(forces) <= noise).all():
        return rest, False
    found = rest.copy()
    found[empty] -= splu(own).solve(forces)
    moved = np.abs(found - rest).max()
    return found, bool(moved > EPS**0.5 * np.abs(rest).max())


def _is_passive(left: LeftOut) -> bool:
    """Whether stiffness and damping cannot put energy into what is left out."""
    values = left.undamped.values
    if len(values) and values[-1] < 0 or left.undamped.factors.negative != 0:
        return False
    if not left.space.modal and (values < 0).any():
        return False
    C = left.pencil.damping
    diagonal = C.diagonal()
    if (diagonal >= 0).all() and (2 * diagonal >= abs(C).sum(axis=0) * (1 - NOISE_SAFETY * EPS)).all():
        return True
    try:
        lifted = C + scipy.sparse.diags_array(NOISE_SAFETY * EPS * np.where(diagonal > 0, diagonal, np.abs(C.data).max()))
        return factorize(lifted, scipy.sparse.csr_array((0, C.shape[0])), left.pencil.described).negative == 0
    except MbconstrainedError:
        return False
