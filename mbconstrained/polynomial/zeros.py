"""Zeros with multiplicities, from the finite part in real Schur form."""

from __future__ import annotations

from contextlib import nullcontext
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.linalg import lapack
from scipy.sparse.csgraph import connected_components

from ..ground.tolerances import CLUSTER_SAFETY, EPS, JOINED_MULTIPLICITIES, NOISE_SAFETY, RANK_TRIALS, rounding_radius
from ..linalg.blocks import block_diagonalize, eigenvalues
from ..linalg.precise import floats, is_precise, precise_arithmetic, product, unit
from ..linalg.rank import RankDecision
from .decoupling import WeierstrassForm
from .structure import FiniteZero


def finite_zeros(form: WeierstrassForm) -> tuple[FiniteZero, ...]:
    """The zeros of A(s) in 1/s, ascending by modulus; of each complex pair the one above the real axis.

    A defective zero of multiplicity m is computed as m zeros around it, at a distance of about eps^(1/m). Zeros of
    one block are therefore one zero, at their mean, where no decoupling separates them that a rounding error of the
    data could not undo. Zeros of different blocks are one if they differ by a few units in the last place, or if they
    are close and rank decisions make them one within the noise of the data. Zeros at s = 0 were split off by rank decisions and
    have the exact value 0.
    """
    moving = form.T[: form.nonzero_count, : form.nonzero_count]
    groups = [zero for block in block_diagonalize(moving).blocks for zero in _merged(_zeros_of_block(block), rounding_radius(2))]
    parts, scale = ZeroParts(form), form.companion.scaling.time
    with_multiplicities = [
        _with_divisors(zero, parts) for zero in _joined(_merged(sorted(groups, key=_order), rounding_radius(1)), parts)
    ]
    zeros = [replace(zero, value=complex(scale * zero.value)) for zero in with_multiplicities]
    if count := len(form.T) - form.nonzero_count:
        zeros.append(FiniteZero(0j, count, form.zero_divisors, all(decision.clear for decision in form.decisions)))
    return in_order(zeros)


def _with_divisors(zero: FiniteZero, parts: ZeroParts) -> FiniteZero:
    """The zero with its partial multiplicities: one doubtful chain where no rank decisions make it a single zero."""
    result = parts.divisors(zero.value, zero.multiplicity) or Divisors((zero.multiplicity,), within_noise=False, clear=False)
    return replace(zero, partial_multiplicities=result.degrees, clear=result.clear)


def _joined(zeros, parts: ZeroParts) -> list[FiniteZero]:
    """Close zeros become one where they are a single zero within the noise of the data.

    The radius within which zeros are tried grows as for higher and higher multiplicities: a zero that is slow relative to others
    is moved by rounding errors of those, and further than by those of its own size.
    """
    for multiplicity in JOINED_MULTIPLICITIES:
        radius, joined = rounding_radius(multiplicity), []
        for run in _clusters(zeros, radius):
            whole = _whole(run, radius)
            tried = (len(run) > 1 or whole != run[0]) and whole.multiplicity <= 2 * JOINED_MULTIPLICITIES[-1]
            result = parts.divisors(whole.value, whole.multiplicity) if tried else None
            joined += [whole] if result and result.within_noise else run
        zeros = joined
    return list(zeros)


def _clusters(zeros, radius) -> list[list[FiniteZero]]:
    """The zeros in groups; each member is within the radius times its size of another."""
    values = np.array([zero.value for zero in zeros])
    near = np.abs(values[:, None] - values) <= radius * np.abs(values)
    count, labels = connected_components(near, directed=False) if len(values) else (0, values)
    return [[zeros[i] for i in np.flatnonzero(labels == label)] for label in range(count)]


def _whole(run, radius) -> FiniteZero:
    """One zero for all at their mean; real, including conjugates, where all are near the real axis."""
    real = all(zero.value.imag <= radius * abs(zero.value) for zero in run)
    weights = [zero.count if real else zero.multiplicity for zero in run]
    mean = np.average([zero.value for zero in run], weights=weights)
    return FiniteZero(complex(mean.real) if real else complex(mean), sum(weights))


def _zeros_of_block(block) -> list[FiniteZero]:
    """Zeros of one cluster: separate where a decoupling below the limit for its size separates them, or they are well separated."""
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
    """A pair a +- i w, or the double zero a where w is within the rounding error of a double zero."""
    if value.imag <= rounding_radius(2) * abs(value.real):
        return FiniteZero(complex(value.real), 2)
    return FiniteZero(value, 1)


def _separation_limit(multiplicity) -> float:
    """Decoupling norm of the zeros around a zero of this multiplicity, separated by rounding errors."""
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
    """Zeros by modulus, real and imaginary part; values that agree to rounding errors count as equal, for a robust order."""
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


# The partial multiplicities of a zero: the degrees of its elementary divisors, the lengths of its Jordan chains.
#
# They are rank decisions on the part of the pencil that belongs to the zero. With left and right bases L and R of that
# part, taken from the Schur form, J = (L E R)^-1 L F R is formed again from the given coefficients: errors of the bases
# enter only as their product, so that what remains is the noise of the data, and that is known. J less the mean of its
# zeros, which is known far better than each of them, is nilpotent to within that noise, and a staircase of orthogonal
# transformations counts its chains (Kublanovskaya 1966, Kagstrom and Ruhe 1980). The zeros themselves, scattered by
# eps^(1/m), are never looked at.


@dataclass(frozen=True)
class Divisors:
    """The degrees of the elementary divisors of one zero, ascending, and their reliability.

    Attributes:
        within_noise: it is a single zero within the noise of the data, not only within a multiple of it.
        clear: and all decisions behind that were clear.
    """

    degrees: tuple[int, ...]
    within_noise: bool
    clear: bool


@dataclass(frozen=True)
class ZeroParts:
    """The parts of a decoupled pencil for its zeros, computed on demand."""

    form: WeierstrassForm

    @cached_property
    def _schur(self) -> tuple[np.ndarray, np.ndarray]:
        return scipy.linalg.rsf2csf(self.form.T, np.eye(len(self.form.T)))

    def divisors(self, value: complex, multiplicity: int) -> Divisors | None:
        """Divisors of this number of zeros nearest to a value (scaled); None where they are no single zero within the noise."""
        if multiplicity == 1:
            return Divisors((1,), True, True)
        N, noise = self._nilpotent(value, multiplicity)
        for factor in RANK_TRIALS:
            degrees, decisions = _chains(N, factor * noise)
            if sum(degrees) == multiplicity:
                within = factor == 1.0
                return Divisors(degrees, within, within and all(decision.clear for decision in decisions))
        return None

    def _nilpotent(self, value, multiplicity) -> tuple[np.ndarray, float]:
        """J less the mean of its zeros, and its noise (Frobenius norm)."""
        E, F = self.form.companion.pencil
        L, R = self._bases(value, multiplicity)
        balance = np.sqrt(np.linalg.norm(L, axis=1) / np.linalg.norm(R, axis=0))  # alike noise in all directions
        L, R = L / balance[:, None], R * balance
        inverse = np.linalg.inv(_between(L, E.data, R))
        J = inverse @ _between(L, F.data, R)
        mean = np.trace(J) / multiplicity
        square = (F.noise**2 + (unit(F.data) * F.size) ** 2) + abs(mean) ** 2 * (E.noise**2 + (unit(E.data) * E.size) ** 2)
        noise = np.sqrt(np.abs(inverse @ L) ** 2 @ square @ np.abs(R) ** 2)
        rounding = EPS * abs(mean) * multiplicity**0.5  # J is formed in float64 in the end
        return J - mean * np.eye(multiplicity), float(np.hypot(np.linalg.norm(noise), rounding))

    def _bases(self, value, multiplicity) -> tuple[np.ndarray, np.ndarray]:
        """Left (m, g r) and right (g r, m) bases of the m zeros nearest to the value."""
        T, Q = self._schur
        chosen = np.zeros(len(T), dtype=np.int32)
        chosen[np.argsort(np.abs(np.diag(T) - value), kind="stable")[:multiplicity]] = 1
        T, Q, *_ = lapack.ztrsen(chosen, T, Q, job="N")
        first, rest = slice(multiplicity), slice(multiplicity, None)
        rows = Q.conj().T
        left = rows[first]
        if len(T) > multiplicity:
            coupling, scale, _ = lapack.ztrsyl(T[first, first], T[rest, rest], -T[first, rest], isgn=-1)
            left = left - coupling / scale @ rows[rest]
        return left @ self.form.finite_rows, self.form.finite_columns @ Q[:, first]


def _between(L, matrix, R) -> np.ndarray:
    """L @ matrix @ R for a real matrix, float64 or precise, the sums in its arithmetic."""
    with precise_arithmetic() if is_precise(matrix) else nullcontext():
        left, right = np.vstack([L.real, L.imag]), np.hstack([R.real, R.imag])
        value, m = product(left, matrix, right), len(L)
        return floats(value[:m, :m] - value[m:, m:]) + 1j * floats(value[:m, m:] + value[m:, :m])


def _chains(N, noise) -> tuple[tuple[int, ...], list[RankDecision]]:
    """Chain lengths of a matrix that is nilpotent to within its noise, ascending; their sum is less where it is not.

    The null space of N is taken out, then that of what is left, and so on: each time one link of every chain. A null space is
    known to the noise over the smallest singular value kept, and turns what is left by as much.
    """
    links, decisions = [], []
    while len(N):
        values, rows = np.linalg.svd(N)[1:]
        bound = NOISE_SAFETY * noise
        rank = int((values > bound).sum())
        smallest, largest = (values[rank - 1] if rank else np.inf), (values[rank] if rank < len(N) else 0.0)
        decisions.append(RankDecision(rank, float(smallest / bound), float(largest / bound)))
        if rank == len(N):
            break
        links.append(len(N) - rank)
        N = rows[:rank] @ N @ rows[:rank].conj().T
        noise = noise * float(np.hypot(1.0, values[0] / smallest))
    longer = [*links[1:], 0]
    return tuple(k + 1 for k, link in enumerate(links) for _ in range(link - longer[k])), decisions
