"""What A(s)^-1 has at its zeros: local Smith forms, finite and at infinity, from adj A and det A."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import sympy

from ....errors import InputError
from ..field.factoring import factors_of, inverse_modulo
from ..field.fields import element, exact_expression
from ..field.radicals import roots
from .decomposition import RootPolynomials, decompose, valuation

if TYPE_CHECKING:
    from .matrix import SymbolicPolynomialMatrix


@dataclass(frozen=True)
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
    """See ``SymbolicPolynomialMatrix.local_smith_form``.

    Raises:
        InputError: the zero is neither in the field of the entries nor one of ``structure().finite_zeros``.
    """
    zero, p = _zero_of(A, zero)
    det, multiplicity = A.determinant, 0
    while det.rem(p).is_zero:
        det, multiplicity = det.quo(p), multiplicity + 1
    terms = root_polynomials(A, p, multiplicity)
    exponents = (0,) * (A.size - len(terms)) + tuple(term.length for term in reversed(terms))
    matrix = sympy.diag(*((A.variable - zero) ** k for k in exponents)).as_immutable()
    return LocalSmithForm(zero, exponents, matrix, tuple(terms))


def _zero_of(A: SymbolicPolynomialMatrix, zero) -> tuple[sympy.Expr, sympy.Poly]:
    """The zero as an expression, and the irreducible polynomial over the field that has it."""
    if isinstance(zero, sympy.Expr):
        for p, _ in factors_of(A.determinant):
            if any(zero in (root.value, root.real - sympy.I * root.imaginary) for root in roots(p) or ()):
                return zero, p
    zero = exact_expression(zero, "zero")
    if not zero.free_symbols <= set(A.symbols):
        raise InputError(f"zero: found {zero}; expected a rational function of the symbols of A(s) or one of its zeros")
    return zero, A.polynomial([-element(A.field, zero, "zero"), A.field.one])


def root_polynomials(A: SymbolicPolynomialMatrix, p: sympy.Poly, multiplicity: int) -> list[RootPolynomials]:
    """The principal part of A(s)^-1 at the zeros of p as the sum of phi psi^T / p^length, the longest first.

    Args:
        p: an irreducible factor of det A(s) over the field, monic.
        multiplicity: how often it divides det A(s).
    """
    if multiplicity == 0:
        return []
    common = 0 if multiplicity == 1 else min(valuation(e, p) for row in A.adjugate for e in row if not e.is_zero)
    k = multiplicity - common
    others = inverse_modulo(A.determinant.quo(p**multiplicity), p**k)
    return decompose([[(entry.quo(p**common).rem(p**k) * others) for entry in row] for row in A.adjugate], p, k)


@dataclass(frozen=True)
class AtInfinity:
    """A(1/w)^-1 = w^-highest times a matrix regular at w = 0, in terms of columns times rows.

    Attributes:
        highest: the largest power of s in A(s)^-1 near infinity.
        terms: phi psi^T / w^(order of growth), the columns and rows modulo w^length, for every q_j < q.
        orders: the q_j of the terms, ascending.
    """

    highest: int
    terms: tuple[RootPolynomials, ...]
    orders: tuple[int, ...]


def at_infinity(A: SymbolicPolynomialMatrix) -> AtInfinity:
    """The local Smith form at infinity from adj A and det A with their coefficients in reverse.

    Pivots are taken from A(s)^-1 itself at w = 1/s = 0, so that the least valuation belongs to the highest infinite zero; one
    entry of each row psi is 1.
    """
    w = A.polynomial([A.field.zero, A.field.one])
    top = max((entry.degree() for row in A.adjugate for entry in row if not entry.is_zero), default=0)
    highest = top - A.determinant.degree()
    k = max(highest + A.degree, highest + 1)
    if k <= 0:
        return AtInfinity(highest, (), ())
    inverse = _reversed(A, A.determinant, A.determinant.degree()).invert(w**k)
    rows = [[_reversed(A, entry, top).rem(w**k) * inverse for entry in column] for column in zip(*A.adjugate)]
    terms = [RootPolynomials(t.divisor, t.length, t.left, t.right, t.pivot) for t in decompose(rows, w, k)]
    return AtInfinity(highest, tuple(terms), tuple(k - term.length - highest for term in terms))


def _reversed(A: SymbolicPolynomialMatrix, p: sympy.Poly, degree: int) -> sympy.Poly:
    """w^degree p(1/w)."""
    return sympy.Poly.from_dict({degree - power: c for (power,), c in p.rep.to_dict().items()}, A.variable, domain=A.field)
