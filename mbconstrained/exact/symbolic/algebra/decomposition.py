"""A matrix over K[s] modulo a power of an irreducible polynomial, as a sum of columns times rows.

K[s] modulo p^k is a local ring: every element is a power of p times a unit. Elimination with pivots of least valuation gives

    P = sum over j of p^a_j phi_j psi_j^T  modulo p^k,    a_1 <= a_2 <= ... < k,

with phi_j independent modulo p, and psi_j too. Where P = p^k A(s)^-1, the elementary divisors of A(s) are p^(k - a_j), and the
columns phi_j and rows psi_j are root polynomials: A phi_j and psi_j^T A vanish modulo p^(k - a_j).
"""

from __future__ import annotations

from dataclasses import dataclass

import sympy

from ..field.factoring import described, inverse_modulo


@dataclass(frozen=True, repr=False)
class RootPolynomials:
    """One term phi psi^T / p^length of the principal part of A(s)^-1 at the zeros of p.

    Attributes:
        divisor: p, a monic irreducible Poly in s.
        length: its power.
        right, left: phi and psi, r Polys each, modulo p^length.
        pivot: what was divided by, a Poly modulo p that is no multiple of it.
    """

    divisor: sympy.Poly
    length: int
    right: tuple[sympy.Poly, ...]
    left: tuple[sympy.Poly, ...]
    pivot: sympy.Poly

    def __repr__(self) -> str:
        return f"RootPolynomials({described(self.divisor)}, length={self.length})"


def decompose(rows: list[list[sympy.Poly]], p: sympy.Poly, k: int) -> list[RootPolynomials]:
    """The terms of P modulo p^k, the longest first; one entry of each right column is 1."""
    terms: list[RootPolynomials] = []
    rows = [[entry.rem(p**k) for entry in row] for row in rows] if k > 0 else []
    while found := _pivot(rows, p):
        a, i, j = found
        modulus, below = p ** (k - a), p**a
        unit = rows[i][j].quo(below)
        inverse = inverse_modulo(unit, modulus)
        right = [(row[j].quo(below) * inverse).rem(modulus) for row in rows]
        left = [entry.quo(below) for entry in rows[i]]
        rows = [[entry - (c * d).rem(modulus) * below for entry, d in zip(row, left)] for row, c in zip(rows, right)]
        terms.append(RootPolynomials(p, k - a, tuple(right), tuple(left), unit.rem(p)))
    return terms


def valuation(entry: sympy.Poly, p: sympy.Poly) -> int:
    """The highest power of p that divides an entry other than zero."""
    count = 0
    while True:
        quotient, rest = entry.div(p)
        if not rest.is_zero:
            return count
        entry, count = quotient, count + 1


def _pivot(rows, p) -> tuple[int, int, int] | None:
    """(a, i, j) of an entry of least valuation a, the simplest of them."""
    best = None
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            if not entry.is_zero:
                a = valuation(entry, p)
                unit = entry.quo(p**a)
                key = (a, unit.rem(p).degree(), _weight(unit), i, j)
                best = key if best is None or key < best else best
    return None if best is None else (best[0], best[-2], best[-1])


def _weight(entry: sympy.Poly) -> int:
    """How long an entry is written: its number of terms in s and in the symbols."""
    field = entry.domain
    if not field.is_FractionField:
        return len(entry.terms())
    return sum(len(field.numer(c)) + len(field.denom(c)) for c in entry.rep.to_list())
