"""adj A(s) and det A(s) without any division: in the ring of polynomials in s and the symbols."""

from __future__ import annotations

from math import prod

import sympy
from sympy.polys.domains.domain import Domain
from sympy.polys.matrices import DomainMatrix

from ..field.factoring import integers


def adjugate_and_determinant(rows: list[list[sympy.Poly]]) -> tuple[list[list[sympy.Poly]], sympy.Poly]:
    """Of a square matrix of Polys in s over a field, as Polys over the field.

    Rows are multiplied by their denominators first; then the characteristic polynomial is found by Berkowitz's algorithm.

    >>> s, k = sympy.symbols("s k")
    >>> K = sympy.ZZ.frac_field(k)
    >>> adjugate_and_determinant([[sympy.Poly(s**2 + 1 / k, s, domain=K)]])[1]
    Poly(s**2 + 1/k, s, domain='ZZ(k)')
    """
    field, variable, size = rows[0][0].domain, rows[0][0].gen, len(rows)
    scales = [_common_denominator(field, [c for entry in row for c in entry.rep.to_list()]) for row in rows]
    ring = integers(field)[variable]
    whole = [[_in_ring(ring, entry, scale) for entry in row] for row, scale in zip(rows, scales)]
    adjugate, determinant = _of_ring(DomainMatrix(whole, (size, size), ring))
    total = field.one / prod(scales, start=field.one)
    factors = [total * scale for scale in scales]
    found = [[_over_field(field, variable, entry, factor) for entry, factor in zip(row, factors)] for row in adjugate.to_list()]
    return found, _over_field(field, variable, determinant, total)


def _of_ring(matrix: DomainMatrix) -> tuple[DomainMatrix, object]:
    """From the characteristic polynomial, by Cayley and Hamilton: +-adj M = M^(r-1) + c_1 M^(r-2) + ... + c_(r-1)."""
    identity = DomainMatrix.eye(matrix.shape[0], matrix.domain).to_dense()
    _, *middle, last = matrix.charpoly()
    total = identity
    for c in middle:
        total = matrix * total + identity * c
    return (-total, last) if len(middle) % 2 else (total, -last)


def _in_ring(ring: Domain, p: sympy.Poly, scale):
    """A polynomial over the field times what makes its coefficients integral, as an element of the ring of polynomials."""
    terms = p.rep.to_dict().items()
    return ring.ring.from_dict({power: ring.domain.convert(c * scale, p.domain) for power, c in terms})


def _over_field(field: Domain, variable: sympy.Symbol, p, factor) -> sympy.Poly:
    """An element of the ring of polynomials times a factor, as a Poly over the field."""
    ring = integers(field)
    terms = {power: field.convert(c, ring) * factor for power, c in p.terms()}
    return sympy.Poly.from_dict(terms, variable, domain=field)


def _common_denominator(field: Domain, values: list):
    """The least multiple of all denominators, an element of the field."""
    ring, total = integers(field), None
    for value in values if field.has_assoc_Ring else ():
        total = field.denom(value) if total is None else ring.lcm(total, field.denom(value))
    return field.one if total is None else field.convert(total, ring)
