"""Zeros with multiplicities, read off the finite part in real Schur form."""

from __future__ import annotations

import numpy as np

from ..linalg.blocks import block_diagonalize, eigenvalues
from ..polynomial.structure import FiniteZero
from ..tolerances import CLUSTER_SAFETY, EPS, rounding_radius
from .weierstrass import WeierstrassForm


def finite_zeros(form: WeierstrassForm) -> tuple[FiniteZero, ...]:
    """The zeros of A(s) in 1/s, ascending by modulus; of each complex pair the one above the real axis.

    A defective zero of multiplicity m is computed as m zeros around it, at a distance of about eps^(1/m). Zeros of
    one block are therefore one zero, at their mean, where no decoupling separates them that a rounding error of the
    data could not undo. Zeros of different blocks are one if they differ by a few units in the last place. Zeros at
    s = 0 were split off by rank decisions and have the exact value 0.
    """
    scale = form.companion.scaling.time
    parts = block_diagonalize(form.T[: form.nonzero_count, : form.nonzero_count]).blocks
    groups = [zero for block in parts for zero in _merged(_zeros_of_block(block), rounding_radius(2))]
    merged = _merged(sorted(groups, key=_order), rounding_radius(1))
    zeros = [FiniteZero(complex(scale * zero.value), zero.multiplicity) for zero in merged]
    if form.nonzero_count < len(form.T):
        zeros.insert(0, FiniteZero(0j, len(form.T) - form.nonzero_count))
    return tuple(sorted(zeros, key=_order))


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
        return [_pair_or_double(complex(value)) if value.imag else FiniteZero(complex(value), 1) for value in values if value.imag >= 0]
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
