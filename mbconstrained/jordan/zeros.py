"""Zeros with multiplicities, read off the finite part in real Schur form."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse.csgraph import connected_components

from ..linalg.blocks import block_diagonalize, eigenvalues
from ..polynomial.structure import FiniteZero
from ..tolerances import CLUSTER_SAFETY, EPS, rounding_radius
from .multiplicities import Divisors, ZeroParts
from .weierstrass import WeierstrassForm

#: Up to such multiplicities zeros are tried to be joined (zeros close to each other in one block are so anyway).
JOINED_MULTIPLICITIES = range(2, 7)


def finite_zeros(form: WeierstrassForm) -> tuple[FiniteZero, ...]:
    """The zeros of A(s) in 1/s, ascending by modulus; of each complex pair the one above the real axis.

    A defective zero of multiplicity m is computed as m zeros around it, at a distance of about eps^(1/m). Zeros of
    one block are therefore one zero, at their mean, where no decoupling separates them that a rounding error of the
    data could not undo. Zeros of different blocks are one if they differ by a few units in the last place, or if they
    are close and rank decisions make them one within the noise of the data. Zeros at s = 0 were split off by rank decisions and have the
    exact value 0.
    """
    moving = form.T[: form.nonzero_count, : form.nonzero_count]
    groups = [zero for block in block_diagonalize(moving).blocks for zero in _merged(_zeros_of_block(block), rounding_radius(2))]
    parts, scale = ZeroParts(form), form.companion.scaling.time
    told = [_with_divisors(zero, parts) for zero in _joined(_merged(sorted(groups, key=_order), rounding_radius(1)), parts)]
    zeros = [replace(zero, value=complex(scale * zero.value)) for zero in told]
    if count := len(form.T) - form.nonzero_count:
        zeros.append(FiniteZero(0j, count, form.zero_divisors, all(decision.clear for decision in form.decisions)))
    return in_order(zeros)


def _with_divisors(zero: FiniteZero, parts: ZeroParts) -> FiniteZero:
    """With its partial multiplicities: one chain, in doubt, where no rank decisions make it a single zero."""
    found = parts.divisors(zero.value, zero.multiplicity) or Divisors((zero.multiplicity,), within_noise=False, clear=False)
    return replace(zero, partial_multiplicities=found.degrees, clear=found.clear)


def _joined(zeros, parts: ZeroParts) -> list[FiniteZero]:
    """Close zeros become one where they are a single zero within the noise of the data.

    The radius within which zeros are tried grows as for higher and higher multiplicities: what is slow beside other zeros
    is moved by the rounding of those, and further than by that of its own size.
    """
    for multiplicity in JOINED_MULTIPLICITIES:
        radius, joined = rounding_radius(multiplicity), []
        for run in _clusters(zeros, radius):
            whole = _whole(run, radius)
            tried = (len(run) > 1 or whole != run[0]) and whole.multiplicity <= 2 * JOINED_MULTIPLICITIES[-1]
            found = parts.divisors(whole.value, whole.multiplicity) if tried else None
            joined += [whole] if found and found.within_noise else run
        zeros = joined
    return list(zeros)


def _clusters(zeros, radius) -> list[list[FiniteZero]]:
    """The zeros in groups; each member is within the radius times its size of another."""
    values = np.array([zero.value for zero in zeros])
    near = np.abs(values[:, None] - values) <= radius * np.abs(values)
    count, labels = connected_components(near, directed=False) if len(values) else (0, values)
    return [[zeros[i] for i in np.flatnonzero(labels == label)] for label in range(count)]


def _whole(run, radius) -> FiniteZero:
    """One zero for all at their mean; real, with the conjugates, where all are near the real axis."""
    real = all(zero.value.imag <= radius * abs(zero.value) for zero in run)
    weights = [zero.count if real else zero.multiplicity for zero in run]
    mean = np.average([zero.value for zero in run], weights=weights)
    return FiniteZero(complex(mean.real) if real else complex(mean), sum(weights))


def _zeros_of_block(block) -> list[FiniteZero]:
    """Zeros of one cluster: split where a decoupling below the limit for its size does, or where they are far apart."""
    values = eigenvalues(block)
    above = values[values.imag > 0]
    pairs = 2 * len(above) == len(values) and above.imag.min() > _spread(above)
    multiplicity = len(above) if pairs else len(values)
    if pairs and multiplicity == 1:
        return [_pair_or_double(complex(above[0]))]
    parts = block_diagonalize(block, _separation_limit(multiplicity)).blocks
    if len(parts) > 1:
        return [zero for part in parts for zero in _zeros_of_block(part)]
    group = above if pairs else values
    if _spread(group) > rounding_radius(multiplicity) * np.abs(group).max():
        return [
            _pair_or_double(complex(value)) if value.imag else FiniteZero(complex(value), 1) for value in values if value.imag >= 0
        ]
    return [FiniteZero(complex(above.mean()) if pairs else complex(values.mean().real), multiplicity)]


def _pair_or_double(value: complex) -> FiniteZero:
    """A pair a +- i w, or the double zero a where w is within what rounding makes of one."""
    if value.imag <= rounding_radius(2) * abs(value.real):
        return FiniteZero(complex(value.real), 2)
    return FiniteZero(value, 1)


def _separation_limit(multiplicity) -> float:
    """Decoupling norm that the zeros around a zero of this multiplicity have, moved apart by rounding errors."""
    return 0.5 * (CLUSTER_SAFETY * EPS) ** (1 / multiplicity - 1)


def _spread(values) -> float:
    return float(np.abs(values - values.mean()).max())


def _merged(zeros, radius) -> list[FiniteZero]:
    """Zeros that differ by less than radius times their size become one, at their mean."""
    merged: list[FiniteZero] = []
    for zero in zeros:
        for place, other in enumerate(merged):
            if abs(zero.value - other.value) <= radius * abs(zero.value):
                total = zero.multiplicity + other.multiplicity
                mean = (zero.multiplicity * zero.value + other.multiplicity * other.value) / total
                merged[place] = FiniteZero(mean, total)
                break
        else:
            merged.append(zero)
    return merged


def _order(zero: FiniteZero):
    return abs(zero.value), zero.value.real, zero.value.imag


def in_order(zeros) -> tuple[FiniteZero, ...]:
    """By modulus, real and imaginary part; what agrees to rounding is equal, so that rounding cannot turn the order."""
    return tuple(
        zero
        for ring in _runs(zeros, lambda zero: abs(zero.value))
        for line in _runs(ring, lambda zero: zero.value.real)
        for zero in sorted(line, key=lambda zero: zero.value.imag)
    )


def _runs(zeros, key) -> list[list[FiniteZero]]:
    """Ascending by the key, cut where it grows by more than rounding moves the parts of a double zero."""
    runs: list[list[FiniteZero]] = []
    for zero in sorted(zeros, key=key):
        if runs and key(zero) - key(runs[-1][-1]) <= rounding_radius(2) * abs(zero.value):
            runs[-1].append(zero)
        else:
            runs.append([zero])
    return runs
