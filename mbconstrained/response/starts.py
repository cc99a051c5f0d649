"""Functions of time of many starts at once: what they share is evaluated once, and one matrix product makes all of them.

The motion is linear in the values at 0-: x_s = x_0 + Phi(t) z_s, x_0 that from rest. Phi(t) is either the answers to unit values,
each with its own digits just after t = 0, or P e^{S t} of reduced equations, and z_s the states; then, just after t = 0,
the Taylor series of all of them together.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..linalg.blocks import CHUNK_ENTRIES, block_slices
from ..linalg.kinds import Matrix
from ..linalg.recursion import propagators
from ..signals.bohl import BohlFunction
from .flow import TERMS, Flow

#: Products are added in parts so many times smaller than other chunks: they are still at hand in the cache.
IN_CACHE = 16


@dataclass(frozen=True)
class Alone:
    """Functions that are evaluated one by one.

    Attributes:
        functions: S of them, with r rows each.
    """

    functions: tuple[BohlFunction, ...]

    def values_into(self, found: np.ndarray, times: np.ndarray) -> None:
        """The values, into an array (S, r, T)."""
        for values, function in zip(found, self.functions):
            values[...] = function(times)

    def derivative(self, order: int) -> Alone:
        """The classical derivatives."""
        return Alone(tuple(function.derivative(order) for function in self.functions))

    def rows(self, indices) -> Alone:
        """Some of the rows of each."""
        return Alone(tuple(function.rows(indices) for function in self.functions))


@dataclass(frozen=True)
class UnitStarts:
    """x_0 + sum over j of weights[j] Phi_j(t).

    Attributes:
        base: x_0, from rest.
        units: Phi_j, from unit values at 0-, m of them.
        weights: shape (m, S).
    """

    base: BohlFunction
    units: tuple[BohlFunction, ...]
    weights: np.ndarray

    def values_into(self, found: np.ndarray, times: np.ndarray) -> None:
        """The values, into an array (S, r, T)."""
        found[...] = self.base(times)
        for at in parts(len(times) if self.units else 0, len(self.units) * found.shape[1]):
            _add_products(found[:, :, at], self.weights, np.array([unit(times[at]) for unit in self.units]))

    def derivative(self, order: int) -> UnitStarts:
        """The classical derivatives."""
        units = tuple(unit.derivative(order) for unit in self.units)
        return replace(self, base=self.base.derivative(order), units=units)

    def rows(self, indices) -> UnitStarts:
        """Some of the rows of each."""
        return replace(self, base=self.base.rows(indices), units=tuple(unit.rows(indices) for unit in self.units))


@dataclass(frozen=True)
class FlowStarts:
    """x_0 + P e^{S t} w_s of reduced equations.

    Attributes:
        base: x_0, from w = 0.
        flow: the equations without force.
        output: P, shape (r, n).
        starts: the states w_s at 0+, shape (n, S).
    """

    base: BohlFunction
    flow: Flow
    output: Matrix
    starts: np.ndarray

    def values_into(self, found: np.ndarray, times: np.ndarray) -> None:
        """The values, into an array (S, r, T)."""
        found[...] = self.base(times)
        early = np.flatnonzero(times * self.flow.rate <= 1)
        late = np.setdiff1d(np.arange(len(times)), early)
        if late.size:
            self._add_modes(found, times, late)
        if early.size:
            self._add_series(found, times, early)

    def _add_modes(self, found, times, chosen) -> None:
        free = self.flow.reduction.decoupled
        coefficients, own = self.output @ free.basis, free.inverse @ self.starts
        n, rows, count = len(own), len(coefficients), own.shape[1]
        for at in parts(len(chosen), n * min(rows, count)):
            places = chosen[at]
            in_order = places[-1] - places[0] == len(places) - 1
            part = found[:, :, places[0] : places[-1] + 1] if in_order else found[:, :, places]
            table = _moved(free.blocks, coefficients.T, times[places], adjoint=True) if rows < count else None
            if table is not None and np.isfinite(table).all():
                _add_products(part, own, table)
            else:
                states = _moved(free.blocks, own, times[places])
                part += (coefficients @ states.reshape(n, -1)).reshape(rows, count, -1).transpose(1, 0, 2)
            if not in_order:
                found[:, :, places] = part

    def _add_series(self, found, times, chosen) -> None:
        powers = np.power.outer(self.flow.rate * times[chosen], np.arange(TERMS)).T
        for members in parts(self.starts.shape[1], self.output.shape[0] * TERMS + len(self.starts)):
            term, terms = self.starts[:, members], []
            for k in range(TERMS):
                terms.append(self.output @ term)
                term = self.flow.generator @ term / (self.flow.rate * (k + 1)) if self.flow.rate else 0 * term
            part = found[members]
            part[:, :, chosen] += np.einsum("krs,kt->srt", terms, powers)

    def derivative(self, order: int) -> FlowStarts:
        """The classical derivatives."""
        output = self.output
        for _ in range(order):
            output = output @ self.flow.generator
        return replace(self, base=self.base.derivative(order), output=output)

    def rows(self, indices) -> FlowStarts:
        """Some of the rows of each."""
        return replace(self, base=self.base.rows(indices), output=self.output[np.asarray(indices, dtype=int)])


def parts(count: int, each: int) -> Iterator[slice]:
    """Slices of so many items, each of so many numbers, that stay below CHUNK_ENTRIES.

    >>> list(parts(5, CHUNK_ENTRIES // 3))
    [slice(0, 3, None), slice(3, 5, None)]
    """
    width = max(1, CHUNK_ENTRIES // max(each, 1))
    return (slice(begin, min(begin + width, count)) for begin in range(0, count, width))


def _add_products(found, weights, table) -> None:
    """found (S, r, T) += weights (m, S)^T table (m, r, T), some members at a time."""
    m, rows, times = table.shape
    flat = table.reshape(m, -1)
    for members in parts(weights.shape[1], rows * times * IN_CACHE):
        found[members] += (weights[:, members].T @ flat).reshape(-1, rows, times)


def _moved(blocks, vectors: np.ndarray, times: np.ndarray, adjoint: bool = False) -> np.ndarray:
    """e^{J t} V, or e^{J^T t} V, shape (n, m, T), for J = diag(blocks), V (n, m); one exponential for all of V."""
    found = np.empty((*vectors.shape, len(times)))
    begins = np.array([at.start for at in block_slices(blocks)], dtype=int)
    for size in {len(block) for block in blocks}:
        group = [i for i, block in enumerate(blocks) if len(block) == size]
        at = begins[group][:, None] + np.arange(size)
        steps = propagators([blocks[i] for i in group], times)
        steps = steps.transpose(1, 3, 2, 0) if adjoint else steps.transpose(1, 2, 3, 0)  # (blocks, size, size, T)
        own, finite = vectors[at][..., None], bool(np.isfinite(steps).all())
        for i in range(size):
            products = (own[:, k] * steps[:, i, k, None, :] for k in range(size))
            if not finite:  # what is zero stays zero, however fast it would grow
                products = (np.where(own[:, k] == 0, 0.0, product) for k, product in enumerate(products))
            found[at[:, i]] = sum(products)
    return found
