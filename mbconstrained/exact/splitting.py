"""Splitting of a multiple eigenvalue under a change of a parameter: exponents and coefficients of its Puiseux series.

Near a root s of multiplicity m, det A(s + d; p + e) = sum over i, j of a_ij d^i e^j with a_i0 = 0 for i < m. The lower edges of the
Newton polygon of the points (j, i) are the exponents of the branches d = c e^r, and the roots of the polynomials on the edges their
coefficients c. A defective eigenvalue with one shape splits as e^(1/m) (Lidskii 1966; Moro, Burke and Overton 1997).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ..ground.tolerances import EXACT_DIGITS, SPLITTING_DIGITS, SPLITTING_ROUNDING

#: Steps of Newton's method to the multiple root; each doubles the digits.
STEPS = 12


@dataclass(frozen=True)
class Branch:
    """Branch of the eigenvalues into which s splits: s + c e^r for a small positive change e of the parameter."""

    exponent: Fraction  # r; 1 for a derivative, less where the eigenvalue is defective
    coefficient: complex  # c, in 1/s per unit of the parameter to the power r; 0 for a constant branch


@dataclass(frozen=True)
class Splitting:
    """Branches of a multiple eigenvalue."""

    eigenvalue: complex  # s, refined
    branches: tuple[Branch, ...]  # as many as the multiplicity
    is_exact: bool  # whether the given numbers have this multiple eigenvalue; False where rounding errors separate its parts


def splitting(base: Sequence, slope: Sequence, value: complex, multiplicity: int, rate: float, step: float) -> Splitting:
    """The branches of a multiple eigenvalue, from det A in arithmetic of hundreds of digits."""
    from flint import acb, acb_mat, acb_poly, arb, ctx

    from .rational import value_at

    with ctx.workdps(SPLITTING_DIGITS):
        count, radius = multiplicity + 2, arb(10) ** -(SPLITTING_DIGITS // 10)
        roots = [(acb(2 * k) / count).exp_pi_i() for k in range(count)]

        def scaled(matrices, factor: float) -> list:
            powers = [arb(rate) ** k * arb(factor) for k in range(len(matrices))]
            return [acb_mat([[acb(arb(float(x)) * f) for x in row] for row in matrix]) for matrix, f in zip(matrices, powers)]

        own, changes = scaled(base, 1.0), scaled(slope, step)

        def determinant(s, change):
            return value_at([matrix + varied * change for matrix, varied in zip(own, changes)], s).det()

        def taylor(values: list) -> list:
            """Coefficients of the powers, from the values at radius times the roots of unity."""
            terms = acb_poly.interpolate([radius * root for root in roots], values).coeffs()
            return terms + [acb(0)] * (count - len(terms))

        center = acb(value.real, value.imag) / acb(rate)
        for _ in range(STEPS):
            a = taylor([determinant(center + radius * root, acb(0)) for root in roots])
            change = -a[multiplicity - 1] / (a[multiplicity] * multiplicity)
            center = (center + change).mid()
            if abs(complex(change)) < 10.0**-EXACT_DIGITS:
                break
        columns = [taylor([determinant(center + radius * root, radius * other) for root in roots]) for other in roots]
        table = [taylor([column[i] for column in columns]) for i in range(count)]
        leading = table[multiplicity][0]
        relative = [[complex(entry / leading) for entry in row] for row in table]
        is_exact = all(abs(relative[i][0]) < 10.0**-EXACT_DIGITS for i in range(multiplicity))
        root = complex(center) * rate
    noise = 10.0**-EXACT_DIGITS if is_exact else SPLITTING_ROUNDING
    points = {
        (i, j): relative[i][j]
        for i in range(multiplicity + 1)
        for j in range(multiplicity + 2)
        if (j or i == multiplicity) and abs(relative[i][j]) > noise
    }
    branches = tuple(
        Branch(exponent, coefficient * rate / step ** float(exponent))
        for exponent, coefficient in newton_branches(points, multiplicity)
    )
    return Splitting(root, branches, is_exact)


def newton_branches(points: dict[tuple[int, int], complex], multiplicity: int) -> list[tuple[Fraction, complex]]:
    """The leading terms c e^r of the roots d of sum of a_ij d^i e^j = 0 near 0, by Newton's polygon."""
    result: list[tuple[Fraction, complex]] = []
    i, j = multiplicity, 0
    while i:
        slopes = {(k, q): Fraction(q - j, i - k) for k, q in points if k < i and q >= j}
        if not slopes:
            return result + [(Fraction(1), 0j)] * i
        exponent = min(slopes.values())
        edge = [point for point, slope in slopes.items() if slope == exponent]
        end = min(edge)
        coefficients = np.zeros(i - end[0] + 1, dtype=complex)
        for k, q in [(i, j), *edge]:
            coefficients[i - k] = points[k, q]
        roots = sorted(np.roots(coefficients), key=lambda root: (-round(root.imag, 9), -root.real))
        result += [(exponent, complex(root)) for root in roots]
        i, j = end
    return result
