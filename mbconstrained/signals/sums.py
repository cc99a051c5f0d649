"""Sums of Bohl functions: summands with the same generator share their states where possible."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ..ground.tolerances import EPS

#: Vectors whose entries agree to so many binary digits are compared; those that have one direction share their states.
COMPARED_DIGITS = 48


class Summand(NamedTuple):
    """A diagonal block of J, its states and their jumps at K knots, shape (2, m, K), and its columns of C, shape (r, m)."""

    block: np.ndarray
    values: np.ndarray
    coefficients: np.ndarray


def merged(summands: Sequence[Summand]) -> list[Summand]:
    """Fewer summands with the same sum, in a time that grows with their number only; all have the same knots."""
    kept: list[Summand] = []
    candidates: dict[tuple[bytes, bytes], int] = {}
    for summand in sorted(summands, key=lambda summand: -len(summand.block)):
        for key in (*_state_keys(summand, 1), *_direction_keys(summand, len(summand.block))):
            place = candidates.get(key)
            total = None if place is None else _sum(kept[place], summand)
            if total is not None:
                kept[place] = total
                break
        else:
            for key in (*_state_keys(summand, len(summand.block)), *_direction_keys(summand, 1)):
                candidates.setdefault(key, len(kept))
            kept.append(summand)
    return _by_rows(kept)


def _state_keys(summand: Summand, count: int) -> Iterator[tuple[bytes, bytes]]:
    """Keys of its last states, from all of them downwards."""
    for skip in range(count):
        yield summand.block[skip:, skip:].tobytes(), summand.values[:, skip:].tobytes()


def _direction_keys(summand: Summand, least: int) -> Iterator[tuple[bytes, bytes]]:
    """Keys of its first columns, from all of them down to the least number."""
    for size in range(len(summand.block), least - 1, -1):
        columns = summand.coefficients[:, :size]
        if columns.any():
            mantissa, exponent = np.frexp(columns / columns.flat[np.abs(columns).argmax()] + 0.0)
            yield (
                summand.block[:size, :size].tobytes(),
                np.round(np.ldexp(mantissa, COMPARED_DIGITS)).tobytes() + exponent.tobytes(),
            )


def _sum(larger: Summand, summand: Summand) -> Summand | None:
    """The sum of two as one summand, or None."""
    skip, size = len(larger.block) - len(summand.block), len(summand.block)
    same_tail = np.array_equal(larger.block[skip:, skip:], summand.block) and not larger.block[skip:, :skip].any()
    if same_tail and np.array_equal(larger.values[:, skip:], summand.values):
        total = larger.coefficients.copy()
        total[:, skip:] += summand.coefficients
        return larger._replace(coefficients=total)
    factor = _factor(summand, larger) if summand.values.shape[2] > 1 else None
    if factor is None:
        return None
    values = larger.values.copy()
    values[:, :size] += factor * summand.values
    return larger._replace(values=values)


def _factor(summand: Summand, larger: Summand) -> float | None:
    """The factor by which the leading columns of a larger summand give those of this one, or None.

    Delayed steps of one vector, or the slopes and jumps of a record, then need one chain of states for all.
    """
    size = len(summand.block)
    columns = larger.coefficients[:, :size]
    if not np.array_equal(larger.block[:size, :size], summand.block) or larger.block[size:, :size].any() or not columns.any():
        return None
    place = np.unravel_index(np.abs(columns).argmax(), columns.shape)
    with np.errstate(over="ignore", invalid="ignore"):  # no factor
        factor = summand.coefficients[place] / columns[place]
        same = np.abs(summand.coefficients - factor * columns) <= EPS * np.abs(summand.coefficients)
    return float(factor) if np.isfinite(factor) and same.all() else None


def _by_rows(summands: list[Summand]) -> list[Summand]:
    """Summands with one for each row of f, where several have one block and only its first state is read."""
    groups: dict[bytes, list[Summand]] = {}
    for summand in summands:
        groups.setdefault(summand.block.tobytes(), []).append(summand)
    total = []
    for group in groups.values():
        rows = np.flatnonzero(np.any([one.coefficients.any(axis=1) for one in group], axis=0))
        turn = _quarter_turn(group[0].block)
        readable = not any(one.coefficients[:, 1 if turn is None else 2 :].any() for one in group)
        if len(group) <= len(rows) or not readable or group[0].values.shape[2] == 1:
            total += group
            continue
        values = np.zeros((len(rows), *group[0].values.shape))
        for one in group:
            values += one.coefficients[rows, 0, None, None, None] * one.values
            if turn is not None:
                values += one.coefficients[rows, 1, None, None, None] * (turn @ one.values)
        for row, own in zip(rows, values):
            columns = np.zeros(group[0].coefficients.shape)
            columns[row, 0] = 1.0
            total.append(Summand(group[0].block, own, columns))
    return total


def _quarter_turn(block: np.ndarray) -> np.ndarray | None:
    """N with e_1^T N = e_2^T that commutes with the block of an oscillation; None for other blocks."""
    if len(block) % 2 or block[1, 0] == 0:
        return None
    turn = np.kron(np.eye(len(block) // 2), [[0.0, 1.0], [-1.0, 0.0]])
    return turn if np.array_equal(turn @ block, block @ turn) else None
