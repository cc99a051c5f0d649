"""Conditions on the values at 0-, as row-reduced linear equations: without impulses, and without jumps."""

from __future__ import annotations

from collections.abc import Iterable

import sympy
from sympy.polys.domains import Domain
from sympy.polys.matrices import DomainMatrix

from ..algebra.matrix import SymbolicPolynomialMatrix
from .solution import Combination, combined, laurent_of, quotients
from .sources import Source, field_with, initial_sources, initial_symbols


def impulse_equations(A: SymbolicPolynomialMatrix, force: Iterable[Source] = ()) -> tuple[sympy.Eq, ...]:
    """Equations in ``initial_symbols(A)`` that hold exactly where no impulse arises (Moysis et al., Eq. 58).

    Corrected: the force enters by f^(j)(0+), not by f^(j)(0-); Dirac impulses of the force itself act whatever the start is and
    are left out. The equations are the polynomial part of X(s), row reduced: each gives one value in terms of later ones.

    Args:
        force: ``force_sources`` that start at 0.

    >>> A = SymbolicPolynomialMatrix([[[1, 0], [0, 1]], [[0, -1], [0, 0]]])  # x1 = x2', x2 = 0
    >>> impulse_equations(A)
    (Eq(x2_0, 0),)
    """
    field, series = _series(A, force)
    rows = [entry for power, row in series.items() if power >= 0 for entry in row]
    return _reduced(A, field, rows)


def continuity_equations(A: SymbolicPolynomialMatrix, force: Iterable[Source] = ()) -> tuple[sympy.Eq, ...]:
    """Equations in ``initial_symbols(A)`` that hold exactly where x^(i)(0+) = x^(i)(0-), i < q (Eq. 60).

    Corrected: the right-hand side of (60) is block Toeplitz, its block (k, c) is H_{c-k} with the H of negative index too,
    which are what the derivatives of the convolution leave at 0+. They imply that there are no impulses.
    """
    field, series = _series(A, force)
    symbols = initial_symbols(A)
    rows = []
    for i in range(A.degree):
        for j, entry in enumerate(series[-1 - i]):
            before = symbols[i, j]
            rows.append({**entry, before: entry.get(before, field.zero) - field.one})
    return _reduced(A, field, rows)


def _series(A, force):
    """The Laurent coefficients at infinity of X for general values at 0-."""
    smooth = [source for source in force if source.start == 0 and not source.is_impulse]
    sources = initial_sources(A, initial_symbols(A)) + smooth
    field = field_with(A, sources)
    return field, laurent_of(A, quotients(A, sources, field), field)


def _reduced(A, field: Domain, rows: list[Combination]) -> tuple[sympy.Eq, ...]:
    """The rows = 0 solved for the earliest values they have."""
    values = list(initial_symbols(A))
    others = sorted({g for row in rows for g in row} - set(values), key=sympy.default_sort_key)
    columns = [*values, *others]
    if not rows or not columns:
        return ()
    matrix = DomainMatrix([[row.get(g, field.zero) for g in columns] for row in rows], (len(rows), len(columns)), field)
    reduced, pivots = matrix.rref()
    return tuple(_equation(field, dict(zip(columns, row)), columns[pivot]) for row, pivot in zip(reduced.to_list(), pivots))


def _equation(field, row: Combination, unknown) -> sympy.Eq:
    rest = {generator: -factor for generator, factor in row.items() if factor and generator != unknown}
    return sympy.Eq(unknown, combined(field, rest), evaluate=False)
