"""Zeros with multiplicities, read off the diagonal blocks of J."""

from __future__ import annotations

import numpy as np

from ..linalg.blocks import eigenvalues
from ..linalg.staircase import split_pencil
from ..polynomial.structure import FiniteZero
from ..tolerances import CLUSTER_SAFETY, EPS
from .weierstrass import WeierstrassForm


def finite_zeros(form: WeierstrassForm, blocks: tuple[np.ndarray, ...]) -> tuple[FiniteZero, ...]:
    """The zeros of A(s) in 1/s, ascending by modulus; of each complex pair the one above the real axis.

    A defective zero of multiplicity m is computed as m zeros around it, at a distance of about eps^(1/m): within
    one block such zeros are one zero, at their mean. Zeros of different blocks are one if they differ by a few
    units in the last place. How many zeros are exactly 0 is decided by a staircase at s = 0, not by their size.
    """
    groups = [group for block in blocks for group in _groups_in_block(block)]
    at_origin, others = _split_at_origin(groups, zero_multiplicity(form))
    merged = _merge_equal(others)
    scale = form.companion.scaling.time
    zeros = [FiniteZero(complex(scale * value), count) for value, count in merged if value.imag >= 0]
    if at_origin:
        zeros.append(FiniteZero(0j, at_origin))
    return tuple(sorted(zeros, key=lambda zero: (abs(zero.value), zero.value.real, zero.value.imag)))


def zero_multiplicity(form: WeierstrassForm) -> int:
    """The multiplicity of s = 0 as a zero of A(s): the zero at infinity of the reversed pencil."""
    companion = form.companion
    return sum(split_pencil(companion.F, companion.E).infinite_divisors)


def _groups_in_block(block) -> list[tuple[complex, int]]:
    values = eigenvalues(block)
    size = len(values)
    if size == 1:
        return [(complex(values[0]), 1)]
    scale = max(np.abs(values).max(), np.abs(np.triu(block, 1)).max())
    radius = (CLUSTER_SAFETY * EPS) ** (1 / size) * scale if scale > 0 else 0.0
    return [(_mean(group), len(group)) for group in _connected(values, radius)]


def _connected(values, radius) -> list[np.ndarray]:
    """Single linkage: values in one group are joined by steps of at most the radius."""
    groups: list[list[complex]] = []
    for value in values:
        near = [group for group in groups if min(abs(value - other) for other in group) <= radius]
        groups = [group for group in groups if group not in near] + [sum(near, []) + [value]]
    return [np.array(group) for group in groups]


def _mean(values) -> complex:
    mean = complex(values.mean())
    closed = np.isclose(np.sort(values.imag), np.sort(-values.imag), rtol=EPS**0.5, atol=0).all()
    return complex(mean.real) if closed else mean


def _split_at_origin(groups, multiplicity):
    """Take the groups nearest to 0 away until the known multiplicity of the zero at 0 is reached."""
    groups = sorted(groups, key=lambda group: abs(group[0]))
    taken = 0
    while groups and taken + groups[0][1] <= multiplicity:
        taken += groups.pop(0)[1]
    if taken < multiplicity and groups:
        value, count = groups[0]
        groups[0] = (value, count - (multiplicity - taken))
        taken = multiplicity
    return taken, groups


def _merge_equal(groups) -> list[tuple[complex, int]]:
    merged: list[tuple[complex, int]] = []
    for value, count in groups:
        for place, (other, known) in enumerate(merged):
            if abs(value - other) <= CLUSTER_SAFETY * EPS * abs(value):
                merged[place] = (other, known + count)
                break
        else:
            merged.append((value, count))
    return merged
