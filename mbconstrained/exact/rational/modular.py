"""Where the pivots of a local Smith form are: an elimination modulo a prime number, quick and almost surely right.

Modulo a prime at which the irreducible polynomial p has a root a, the localization of Q[s] at p becomes the power series in s - a
over the field of that prime, and A(s) a matrix of such series. Only the places of the pivots are taken from here; what is
computed with them is exact, and shows whether the prime was a lucky one (``local_smith``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import comb

import flint

#: Primes are tried from here on. Arithmetic modulo numbers of this size takes one word; few of them divide anything that matters.
FIRST_NUMBER = 2**61 + 1


@dataclass(frozen=True)
class Pivots:
    """The pivots of one exponent: p^exponent divides all that is left, and no higher power divides the minor of these.

    Attributes:
        exponent: k.
        rows, columns: indices, as many of the one as of the other.
    """

    exponent: int
    rows: tuple[int, ...]
    columns: tuple[int, ...]


def rooted_primes(p: flint.fmpz_poly) -> Iterator[tuple[int, int]]:
    """Primes with a root of p modulo each of them: by Chebotarev's theorem at least every (deg p)-th prime has one."""
    number = FIRST_NUMBER
    while True:
        if flint.fmpz(number).is_prime():
            reduced = flint.nmod_poly([int(c) % number for c in p.coeffs()], number)
            if reduced.degree() == p.degree() and (roots := reduced.roots()):
                yield number, min(int(root) for root, _ in roots)
        number += 2


def pivots(whole, root: int, prime: int, multiplicity: int) -> list[Pivots] | None:
    """The pivots by ascending exponents, least row and column indices first; None where these do not add up to the multiplicity.

    Args:
        whole: coefficients of A(s), matrices of whole numbers.
        root: modulo the prime, of the polynomial with this multiplicity in det A(s).
    """
    series, missing = _taylor(whole, root, prime), multiplicity  # missing: what exponents are still above the present one, summed
    rows, columns = list(range(whole[0].nrows())), list(range(whole[0].nrows()))
    found, exponent = [], 0
    while rows:
        leading = next((k for k, matrix in enumerate(series) if matrix.rank()), missing + 1)
        exponent, series, missing = exponent + leading, series[leading:], missing - leading * len(rows)
        if missing < 0:
            return None
        own_rows, own_columns = _independent(series[0].transpose()), _independent(series[0])
        found.append(Pivots(exponent, tuple(rows[i] for i in own_rows), tuple(columns[j] for j in own_columns)))
        other_rows, other_columns = _others(rows, own_rows), _others(columns, own_columns)
        if other_rows:
            series = _schur(series, (own_rows, other_rows), (own_columns, other_columns), missing + 1)
        rows, columns = [rows[i] for i in other_rows], [columns[j] for j in other_columns]
    return found if missing == 0 else None


def _taylor(whole, root: int, prime: int) -> list[flint.nmod_mat]:
    """The coefficients of A(root + e) in powers of e."""
    reduced = [flint.nmod_mat(matrix, prime) for matrix in whole]
    found = []
    for order in range(len(reduced)):
        terms = [reduced[k] * flint.nmod(comb(k, order) * pow(root, k - order, prime), prime) for k in range(order, len(reduced))]
        found.append(sum(terms[1:], terms[0]))
    return found


def _independent(matrix: flint.nmod_mat) -> list[int]:
    """The columns that do not depend on those before them."""
    reduced, rank = matrix.rref()
    return [next(j for j in range(reduced.ncols()) if int(reduced[i, j])) for i in range(rank)]


def _others(indices, chosen) -> list[int]:
    return [i for i in range(len(indices)) if i not in chosen]


def _schur(series, rows, columns, precision: int) -> list[flint.nmod_mat]:
    """d - c a^-1 b of the power series [[a, b], [c, d]], a invertible, up to the precision."""
    prime = series[0].modulus()
    (a, b), (c, d) = [[[_part(matrix, i, j, prime) for matrix in series] for j in columns] for i in rows]
    inverse, quotient, found = a[0].inv(), [], []
    for order in range(precision):
        rest = _difference(b, [(a[i], quotient[order - i]) for i in range(1, min(order + 1, len(a)))], order)
        quotient.append(inverse * rest)
        found.append(_difference(d, [(c[i], quotient[order - i]) for i in range(min(order + 1, len(c)))], order))
    return found


def _difference(given, products, order: int) -> flint.nmod_mat:
    """The coefficient of that order, less the products."""
    total = given[order] if order < len(given) else given[0] - given[0]
    for left, right in products:
        total = total - left * right
    return total


def _part(matrix, rows, columns, prime: int):
    entries = [int(matrix[i, j]) for i in rows for j in columns]
    return flint.nmod_mat(len(rows), len(columns), entries, prime)
