"""The formulas for e^{J t} of Moysis et al., section 2.2, as printed there and corrected; zeros and entries are numbers or expressions.

The engine uses none of the formulas as they stand (``linalg.exponential``): for clusters they need the exact zeros and exponents, which
rounded data do not have; (35) is a confluent Vandermonde system whose condition grows without bound as zeros come close, and the sums (34)
and (37) cancel where |lambda t| is large.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from mbconstrained.exact.symbolic.fields import field_of
from mbconstrained.exact.symbolic.symbolic_matrix import S
from mbconstrained.exact.symbolic.symbolic_response import Quotient, regular_parts


def exponential_of_jordan_block(zero, size: int, t) -> sympy.Matrix:
    """G(t) = e^{J t}, g_kj = e^{zero t} t^(j-k) / (j-k)!, of one Jordan block (Lemma 2.11, Eqs. 30-33).

    The lemma holds for ONE block; the n_i x n_i matrix of a zero with several blocks is their direct sum.
    """
    return sympy.exp(zero * t) * _shifts(size, t)


def exponential_of_real_jordan_block(real, imaginary, size: int, t) -> sympy.Matrix:
    """e^{J t}, shape (2 size, 2 size), of one real block of the pair real +- i imaginary (Eqs. 38-41).

    J has D = [[a, b], [-b, a]] on its diagonal and I_2 next to it. Corrected: M in (40) is the rotation of (41) alone, which is
    e^{D t} without its factor e^{a t}; the pair has multiplicity m_i in a block of size 2 m_i.
    """
    c, s = sympy.cos(imaginary * t), sympy.sin(imaginary * t)
    return sympy.exp(real * t) * sympy.kronecker_product(_shifts(size, t), sympy.Matrix([[c, s], [-s, c]]))


def exponential_by_interpolation(J: sympy.Matrix, exponents: Mapping[sympy.Expr, int], t) -> sympy.Matrix:
    """e^{J t} = sum of J^k f_k(t), k < m, with the f_k of the confluent Vandermonde system (Lemma 2.12, Eqs. 34-35).

    The system is not solved as one: f_k is the inverse transform of p_k(s) / M(s) with M(s) = sum of c_j s^j the
    minimal polynomial and p_k(s) = sum of c_j s^(j-1-k), j > k, because (s I - J)^-1 = sum of J^k p_k(s) / M(s).
    """
    names = {sympy.Dummy(f"zero{i}"): zero for i, zero in enumerate(exponents)}
    field = field_of(list(names))
    factors = [(sympy.Poly(S - name, S, domain=field), exponents[zero]) for name, zero in names.items()]
    return _combination([f.xreplace(names) for f in functions_of_factors(factors, t)], J)


def functions_of_factors(factors: Sequence[tuple[sympy.Poly, int]], t: sympy.Expr) -> list[sympy.Expr]:
    """f_0(t) ... f_(m-1)(t) of (35) for the minimal polynomial that is the product of q^k: real for real factors q."""
    field, gen = factors[0][0].domain, factors[0][0].gen
    coefficients = sympy.prod((q**k for q, k in factors), sympy.Poly(1, gen, domain=field)).rep.to_list()
    numerators = [sympy.Poly(coefficients[: len(coefficients) - 1 - k], gen, domain=field) for k in range(len(coefficients) - 1)]
    return regular_parts(len(numerators), [Quotient({sympy.S.One: numerators}, list(factors))], t)


def exponential_by_blocks(blocks: Sequence, zeros: Sequence, exponents: Sequence[int], t) -> sympy.Matrix:
    """e^{J t} as the direct sum of sum of f_ij(t) J_i^j, j < m_i, one term for each zero (Lemma 2.13, Eqs. 36-37).

    Corrected: (37) is meant for i = 1 ... l and j = 0 ... m_i - 1, J_i collects ALL blocks of the zero i, and 0^0 = 1.
    """
    return sympy.diag(
        *(
            _combination([f * sympy.exp(zero * t) for f in block_functions(zero, m, t)], block)
            for block, zero, m in zip(blocks, zeros, exponents, strict=True)
        )
    )


def _combination(functions: Sequence[sympy.Expr], J: sympy.MatrixBase) -> sympy.Matrix:
    """The sum of f_k J^k."""
    total, power = sympy.zeros(*J.shape), sympy.eye(J.rows)
    for f in functions:
        total, power = total + power * f, power * J
    return total


def block_functions(zero: sympy.Expr, exponent: int, t: sympy.Expr) -> list[sympy.Expr]:
    """f_i0(t) ... of (37) without the factor e^{zero t}."""
    zero = sympy.S(zero)
    return [
        sympy.Add(*((-zero) ** (n - j) * t**n / sympy.factorial(n - j) for n in range(j, exponent))) / sympy.factorial(j)
        for j in range(exponent)
    ]


def _shifts(size, t) -> sympy.Matrix:
    """The upper triangular Toeplitz matrix of t^k / k!."""
    return sympy.Matrix(size, size, lambda k, j: sympy.S(t) ** (j - k) / sympy.factorial(j - k) if j >= k else sympy.S.Zero)
