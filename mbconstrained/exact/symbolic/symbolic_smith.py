"""Root polynomials over a field of symbols, from adj A and det A; local Smith forms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy

from ...ground.errors import InputError
from ..core.jordan_blocks import RootPolynomials
from .field.fields import element, exact_expression
from .symbolic_ring import SymbolicRing, inverse_modulo

if TYPE_CHECKING:
    from .symbolic_matrix import SymbolicPolynomialMatrix


@dataclass(frozen=True, eq=False)
class LocalSmithForm:
    """U_L(s) A(s) U_R(s) = diag((s - zero)^k_1, ..., (s - zero)^k_r), U_L and U_R regular at the zero (Moysis et al., Eq. 9).

    Attributes:
        zero: where.
        exponents: k_1 <= ... <= k_r.
        matrix: the form.
        terms: the root polynomials of every k_j > 0.
    """

    zero: sympy.Expr
    exponents: tuple[int, ...]
    matrix: sympy.ImmutableMatrix
    terms: tuple[RootPolynomials, ...]


def local_smith_form(A: SymbolicPolynomialMatrix, zero) -> LocalSmithForm:
    """See ``SymbolicPolynomialMatrix.local_smith_form``."""
    zero, p = _zero_of(A, zero)
    det, multiplicity = A.determinant, 0
    while det.rem(p).is_zero:
        det, multiplicity = det.quo(p), multiplicity + 1
    terms = root_polynomials(A, p, multiplicity)
    exponents = (0,) * (A.size - len(terms)) + tuple(term.length for term in terms)
    matrix = sympy.diag(*((A.variable - zero) ** k for k in exponents)).as_immutable()
    return LocalSmithForm(zero, exponents, matrix, tuple(terms))


def _zero_of(A: SymbolicPolynomialMatrix, zero) -> tuple[sympy.Expr, sympy.Poly]:
    """The zero as an expression, and the irreducible polynomial over the field that has it."""
    if isinstance(zero, sympy.Expr):
        for p, _ in A.jordan_pairs().factors:
            if any(zero in (root.value, root.real - sympy.I * root.imaginary) for root in A.ring.roots(p) or ()):
                return zero, p
    zero = exact_expression(zero, "zero")
    if not zero.free_symbols <= set(A.symbols):
        raise InputError(f"zero: found {zero}; expected a rational function of the symbols of A(s) or one of its zeros")
    return zero, A.ring.polynomial([-element(A.field, zero, "zero"), A.field.one])


def root_polynomials(A: SymbolicPolynomialMatrix, p: sympy.Poly, multiplicity: int) -> list[RootPolynomials]:
    """The root polynomials at the zeros of p, ascending lengths."""
    return _terms(A, A.adjugate, A.determinant, p, multiplicity)


def infinite_root_polynomials(A: SymbolicPolynomialMatrix) -> list[RootPolynomials]:
    """Those of D(s) = s^q A(1/s) at s = 0, with q = 1 where it is 0: adj D and det D have the coefficients of adj A and det A in reverse.

    Those of the transposed matrix are computed, so that an entry of each row psi is 1, as in Moysis et al., Eq. 97.
    """
    r, q = A.size, max(A.degree, 1)
    transposed = [[_reversed(A, entry, q * (r - 1)) for entry in column] for column in zip(*A.adjugate)]
    determinant = _reversed(A, A.determinant, q * r)
    s = A.ring.polynomial([A.field.zero, A.field.one])
    terms = _terms(A, transposed, determinant, s, q * r - A.determinant.degree())
    return [RootPolynomials(t.ring, s, t.length, t.left, lambda t=t: t.right, t.pivot) for t in terms]


def _terms(A, adjugate, determinant: sympy.Poly, p: sympy.Poly, multiplicity: int) -> list[RootPolynomials]:
    """The terms of adjugate / determinant at the zeros of p."""
    if multiplicity == 0:
        return []
    common = 0 if multiplicity == 1 else min(_valuation(e, p) for row in adjugate for e in row if not e.is_zero)
    k = multiplicity - common
    others = inverse_modulo(determinant.quo(p**multiplicity).rem(p**k), p**k)
    return decompose(A.ring, [[entry.quo(p**common).rem(p**k) * others for entry in row] for row in adjugate], p, k)[::-1]


def _reversed(A: SymbolicPolynomialMatrix, p: sympy.Poly, degree: int) -> sympy.Poly:
    """s^degree p(1/s)."""
    return sympy.Poly.from_dict({degree - power: c for (power,), c in p.rep.to_dict().items()}, A.variable, domain=A.field)


# Elimination modulo p^k: K[s] modulo p^k is a local ring, in which every element is a power of p times a unit.
#
# Pivots of least valuation give P = sum over j of p^a_j phi_j psi_j^T modulo p^k, a_1 <= a_2 <= ... < k, with phi_j independent
# modulo p, and psi_j too. Where P = p^k A(s)^-1, the elementary divisors of A(s) are p^(k - a_j), and phi_j and psi_j are root
# polynomials. Unlike minors (``rational.rational_smith``) this gives short pivots, and the assumptions are their factors.


def decompose(ring: SymbolicRing, rows: list[list[sympy.Poly]], p: sympy.Poly, k: int) -> list[RootPolynomials]:
    """The terms of P modulo p^k, the longest first; one entry of each right column is 1."""
    terms: list[RootPolynomials] = []
    rows = [[entry.rem(p**k) for entry in row] for row in rows] if k > 0 else []
    while place := _pivot(rows, p):
        a, i, j = place
        modulus, below = p ** (k - a), p**a
        unit = rows[i][j].quo(below)
        inverse = inverse_modulo(unit, modulus)
        right = [(row[j].quo(below) * inverse).rem(modulus) for row in rows]
        left = tuple(entry.quo(below) for entry in rows[i])
        rows = [[entry - (c * d).rem(modulus) * below for entry, d in zip(row, left)] for row, c in zip(rows, right)]
        terms.append(RootPolynomials(ring, p, k - a, tuple(right), lambda left=left: left, unit.rem(p)))
    return terms


def _valuation(entry: sympy.Poly, p: sympy.Poly) -> int:
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
                a = _valuation(entry, p)
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
