"""The partial multiplicities of a zero: the degrees of its elementary divisors, the lengths of its Jordan chains.

They are rank decisions on the part of the pencil that belongs to the zero. With left and right bases L and R of that
part, taken from the Schur form, J = (L E R)^-1 L F R is formed again from the given coefficients: errors of the bases
enter only as their product, so that what remains is the noise of the data, and that is known. J less the mean of its
zeros, which is known far better than each of them, is nilpotent to within that noise, and a staircase of orthogonal
transformations counts its chains (Kublanovskaya 1966, Kagstrom and Ruhe 1980). The zeros themselves, scattered by
eps^(1/m), are never looked at.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.linalg
from scipy.linalg import lapack

from ..linalg.precise import of_kind, precise_arithmetic, unit
from ..linalg.rank import RankDecision
from ..tolerances import CLUSTER_SAFETY, EPS, NOISE_SAFETY
from .weierstrass import WeierstrassForm

#: Where the ranks are not those of a single zero they are tried again with the noise multiplied by these.
NOISE_FACTORS = (1.0, 10.0, 100.0, CLUSTER_SAFETY)


@dataclass(frozen=True)
class Divisors:
    """The degrees of the elementary divisors of one zero, ascending, and how sure they are.

    Attributes:
        within_noise: it is a single zero within the noise of the data, not only within a multiple of it.
        clear: and all decisions behind that were clear.
    """

    degrees: tuple[int, ...]
    within_noise: bool
    clear: bool


@dataclass(frozen=True)
class ZeroParts:
    """The parts of a decoupled pencil that belong to its zeros, each made when it is asked for."""

    form: WeierstrassForm

    @cached_property
    def _schur(self) -> tuple[np.ndarray, np.ndarray]:
        return scipy.linalg.rsf2csf(self.form.T, np.eye(len(self.form.T)))

    def divisors(self, value: complex, multiplicity: int) -> Divisors | None:
        """Those of the zeros nearest to this value (scaled), so many; None where they are no single zero within the noise."""
        if multiplicity == 1:
            return Divisors((1,), True, True)
        N, noise = self._nilpotent(value, multiplicity)
        for factor in NOISE_FACTORS:
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
    with precise_arithmetic():
        left, right = np.vstack([L.real, L.imag]), np.hstack([R.real, R.imag])
        product = of_kind(left, matrix) @ matrix @ of_kind(right, matrix)
        m = len(L)
        real, imaginary = product[:m, :m] - product[m:, m:], product[:m, m:] + product[m:, :m]
        return real.astype(float) + 1j * imaginary.astype(float)


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
