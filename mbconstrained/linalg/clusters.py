"""e^{J t} v for a block J that is a cluster of close or defective zeros.

It is shifted by the mean of its zeros, which leaves a small, nearly nilpotent rest whose Taylor series ends quickly; what is left
of its size is halved away and squared back (Moler and Van Loan 2003, method 3). The block is never handed to a Pade code: those
lose digits on triangular matrices with close diagonal entries.
"""

from __future__ import annotations

import numpy as np
import scipy.linalg

from ..errors import IllConditioned
from .blocks import CHUNK_ENTRIES
from .oscillations import MODERATE

#: The Taylor polynomial of e^X of this degree is exact to rounding for |X| <= 1 (1/19! < 1e-17).
TAYLOR_DEGREE = 18

#: Up to so many doublings the Taylor polynomial is applied to the vectors, 2^doublings times; beyond that it is
#: cheaper to square the matrices.
APPLIED_DOUBLINGS = 4

#: Units of states down to this leave room for the states themselves in the range of float64.
LEAST_UNIT = 2.0**-500

TOO_FAR_APART = (
    "the force or the motion changes within times too short beside the others, by more than 150 powers of ten, for float64 to "
    "follow both; check the units of time, or leave out samples that lie that close"
)


def cluster_states(block, start, times) -> np.ndarray:
    """Shifted by the middle of its zeros; where these have turned about it by then, the two halves each by their own middle.

    Before that the halves are large and cancel: zeros a +- i w with a chain between them have not come apart at w t < 1.
    """
    shift, half = np.trace(block) / len(block), _upper_half(block)
    if half is None:
        return _shifted_states(block - shift * np.eye(len(block)), shift, start, times)
    basis, triangle, rows = half
    middle = np.trace(triangle) / len(triangle)
    turned = middle.imag * times > 1.0
    start, states = np.broadcast_to(start, (len(block), len(times))), np.empty((len(block), len(times)))
    if not turned.all():
        states[:, ~turned] = _shifted_states(block - shift * np.eye(len(block)), shift, start[:, ~turned], times[~turned])
    if turned.any():
        rest, later = triangle - middle * np.eye(len(triangle)), times[turned]
        is_pair = len(rest) == 2 and np.abs(rest[0, 0].real) * later.max() < MODERATE
        parts = (_pair_states if is_pair else _shifted_states)(rest, middle, rows @ start[:, turned], later)
        states[:, turned] = 2 * (basis @ parts).real
    return states


def _pair_states(rest, shift, start, times) -> np.ndarray:
    """e^{(rest + shift) t} start for a triangle of two complex zeros: rest^2 = d^2 I, a motion and a force near resonance."""
    turned = rest[0, 0] * times
    safe = np.where(turned == 0, 1.0, turned)
    odd = np.where(turned == 0, 1.0, np.sinh(safe) / safe) * times
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):  # the caller sees and reports what is not finite
        return (start * np.cosh(turned) + (rest @ start) * odd) * np.exp(shift * times)


def _upper_half(block):
    """The invariant part of the zeros above the real axis, where these stand apart from their conjugates.

    A real block with the zeros near a + i w and near a - i w would be shifted by a alone, leaving a large
    rotation w; the part above the axis can be shifted by a + i w, and the other half is its conjugate.
    """
    values = np.linalg.eigvals(block)
    above = values[values.imag > 0]
    if 2 * len(above) != len(values):
        return None
    spread = np.abs(above - above.mean()).max()
    if above.imag.min() <= 2 * spread:
        return None
    triangle, basis, count = scipy.linalg.schur(block, output="complex", sort=lambda value: value.imag > 0)
    top, corner, bottom = triangle[:count, :count], triangle[:count, count:], triangle[count:, count:]
    coupling = scipy.linalg.solve_sylvester(top, -bottom, -corner)
    adjoint = basis.conj().T
    return basis[:, :count], top, adjoint[:count] - coupling @ adjoint[count:]


def _shifted_states(rest, shift, start, times) -> np.ndarray:
    """e^{(rest + shift) t} start for every t, by Taylor in the rest and doubling, as often as each t needs."""
    size = len(start)
    start = np.broadcast_to(start, (size, len(times)))
    if shift == 0 and not np.tril(rest).any():  # a polynomial in t, which ends by itself
        return _applied(rest, shift, start, times, size - 1)
    units = _units(rest, times)
    rest, start = rest * units / units[:, None], start / units[:, None]
    states = np.empty((size, len(times)), dtype=np.result_type(rest, start))
    norm = np.abs(rest).sum(axis=0).max()
    with np.errstate(over="ignore"):
        angles = norm * times
    if not np.isfinite(angles).all():
        raise IllConditioned(TOO_FAR_APART)
    doublings = np.ceil(np.log2(np.maximum(angles, 1.0))).astype(int)
    for count in np.unique(doublings):
        at, degree = np.flatnonzero(doublings == count), TAYLOR_DEGREE + size - 1
        if count <= APPLIED_DOUBLINGS:
            states[:, at] = start[:, at]
            for _ in range(2**count):
                states[:, at] = _applied(rest, shift, states[:, at], times[at] / 2.0**count, degree)
        else:
            states[:, at] = _squared(rest, shift, start[:, at], times[at], count)
    return states * units[:, None]


def _units(rest, times) -> np.ndarray:
    """Powers of two for the states of a quasi-triangular matrix in which no coupling is larger than its zeros.

    A coupling that is, such as that of a slow decay with the fast unit of time that it came with, would have the
    exponential doubled more often than anything moves, and each doubling doubles the rounding errors too.

    Raises:
        IllConditioned: no such units are in the range of float64.
    """
    units, latest = np.ones(len(rest)), times.max(initial=0.0)
    if not latest:
        return units
    target, at = max(np.abs(np.linalg.eigvals(rest)).max(), 1 / latest), 1
    while at < len(rest):
        begin = at - 1 if rest[at, at - 1] else at  # the two states of a pair have one unit
        with np.errstate(over="ignore"):
            coupling = (np.abs(rest[:begin, begin : at + 1]).max(axis=1, initial=0.0) / units[:begin]).max(initial=0.0)
        if coupling > target:
            if target / coupling < LEAST_UNIT:
                raise IllConditioned(TOO_FAR_APART)
            units[begin : at + 1] = 2.0 ** np.floor(np.log2(target / coupling))
        at += 1
    return units


def _applied(rest, shift, start, times, degree) -> np.ndarray:
    """The Taylor polynomial of e^{rest t}, applied to the vectors, and e^{shift t}."""
    total = term = start
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):  # the caller sees and reports what is not finite
        for power in range(1, degree + 1):
            term = (rest @ term) * (times / power)
            total = total + term
        return total * np.exp(shift * times)


def _squared(rest, shift, start, times, doublings) -> np.ndarray:
    states, size = np.empty_like(start, dtype=np.result_type(rest, start)), len(start)
    chunk = max(1, CHUNK_ENTRIES // size**2)
    for part in np.split(np.arange(len(times)), range(chunk, len(times), chunk)):
        matrices = _taylor_exponential(rest, shift, times[part] / 2.0**doublings, doublings)
        states[:, part] = np.einsum("tij,jt->it", matrices, start[:, part])
    return states


def _taylor_exponential(rest, shift, times, doublings) -> np.ndarray:
    """e^{(rest + shift) t 2^doublings}; the shift is in before the squaring, so that a decay keeps it in range.

    A chain of n states needs n - 1 powers to be there at all: the degree grows with the size.
    """
    steps = rest[None] * times[:, None, None]
    identity = np.eye(len(rest))
    degree = TAYLOR_DEGREE + len(rest) - 1
    total = identity + steps / degree
    for power in range(degree - 1, 0, -1):
        total = identity + steps @ total / power
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):  # the caller sees and reports what is not finite
        total = total * np.exp(shift * times)[:, None, None]
        for _ in range(doublings):
            total = total @ total
    return total
