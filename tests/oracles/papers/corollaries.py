"""The free motion by the three corollaries of Moysis et al., section 4.1, as expressions in symbols.

All start from x(t) = C e^{J t} x_s(0), Eq. (65), with x_s(0) of Eq. (43): for values at 0- that cause impulses or jumps it is the
motion for t > 0.
"""

from __future__ import annotations

import sympy

from mbconstrained.exact.symbolic.symbolic_matrix import Block, SymbolicPolynomialMatrix
from tests.oracles.papers.matrix_exponentials import (
    block_functions,
    exponential_of_jordan_block,
    exponential_of_real_jordan_block,
    functions_of_factors,
)


def free_motion_by_jordan_blocks(A: SymbolicPolynomialMatrix, X0: sympy.Matrix, time: sympy.Symbol) -> sympy.Matrix:
    """x(t) = sum over zeros i and blocks j of C_ij G_ij(t) x_s,ij(0) (Corollary 4.2, Eq. 70, with Lemma 2.11).

    Corrected: (69) and (70) print direct sums, whose dimensions do not fit; the columns C_ij stand side by side, so that their
    products are summed, and there is one G_ij for each Jordan block, of size n_ij. Complex pairs have real blocks, Eqs. (38)-(41).
    """
    blocks = A.jordan_pairs().finite.blocks
    return motion_of_blocks(A, blocks, [start_of(A, block, X0) for block in blocks], time)


def free_motion_by_interpolation(A: SymbolicPolynomialMatrix, X0: sympy.Matrix, time: sympy.Symbol) -> sympy.Matrix:
    """x(t) = sum of C J^k f_k(t) x_s(0), k < m (Corollary 4.3, Eq. 71, with Lemma 2.12).

    The f_k belong to the minimal polynomial of J, the last invariant polynomial of A(s); as the formula holds for every J
    similar to the Jordan form, J is the one with entries rational in the symbols, and everything is real.
    """
    pair = A.jordan_pairs().rational
    divisors = [(divisor.polynomial, divisor.exponents[-1]) for divisor in A.structure().elementary_divisors]
    total = sympy.zeros(A.size, 1)
    if divisors:
        state = start_of(A, pair, X0)
        for f in functions_of_factors(divisors, time):
            total, state = total + (pair.C * state).applyfunc(sympy.factor) * f, pair.J * state
    return total


def free_motion_by_zeros(A: SymbolicPolynomialMatrix, X0: sympy.Matrix, time: sympy.Symbol) -> sympy.Matrix:
    """x(t) = sum over zeros i of C_i sum of f_ij(t) J_i^j x_s,i(0), j < m_i (Corollary 4.4, Eq. 72, with Lemma 2.13).

    Corrected: (72) prints a direct sum of r x n_i matrices, meant are their products with x_s,i(0) summed; i and j of (37) are
    exchanged. Of a complex pair the zero above the real axis stands for both, with twice the real part of its term.
    """
    blocks = A.jordan_pairs().finite.blocks
    exponents: dict[sympy.Expr, int] = {}
    for block in blocks:
        exponents[block.zero] = max(exponents.get(block.zero, 0), block.length)
    total = sympy.zeros(A.size, 1)
    for block in blocks:
        term = _of_pair if block.kind == "real jordan" else _of_real_zero
        total += term(block, start_of(A, block, X0), exponents[block.zero], time)
    return total


def start_of(A: SymbolicPolynomialMatrix, pair, initial: sympy.MatrixBase) -> sympy.Matrix:
    """x_s(0) = [J^(q-1) B ... B] M1 X0 (Eq. 43), block (a, c) of M1 being A_(q-a+c), a >= c."""
    q, state = A.degree, sympy.zeros(pair.J.rows, 1)
    for a in range(q):
        above = sum((A.coefficients[q - a + c] * initial[c, :].T for c in range(a + 1)), sympy.zeros(A.size, 1))
        state = pair.J * state + pair.B * above
    return state


def motion_of_blocks(A, blocks: tuple[Block, ...], starts: list[sympy.Matrix], time) -> sympy.Matrix:
    """The sum of C_ij G_ij(t) x_s,ij(0)."""
    total = sympy.zeros(A.size, 1)
    for block, start in zip(blocks, starts, strict=True):
        if block.kind == "real jordan":
            exponential = exponential_of_real_jordan_block(block.J[0, 0], block.J[0, 1], block.length, time)
        else:
            exponential = exponential_of_jordan_block(block.J[0, 0], block.length, time)
        total += block.C * exponential * start
    return total


def _of_real_zero(block, start, exponent, time) -> sympy.Matrix:
    total, state, zero = sympy.zeros(block.C.rows, 1), start, block.J[0, 0]
    for f in block_functions(zero, exponent, time):
        total, state = total + block.C * state * f, block.J * state
    return total * sympy.exp(zero * time)


def _of_pair(block, start, exponent, time) -> sympy.Matrix:
    """Twice the real part of the term of a + i b: columns u, v of a real block are the complex one u + i v with the state (x_u - i x_v)/2."""
    a, b = block.J[0, 0], block.J[0, 1]
    name = sympy.Dummy("zero")
    C, state = (block.C[:, ::2], block.C[:, 1::2]), (start[::2, :], -start[1::2, :])
    J = (block.J[::2, ::2], sympy.eye(block.length) * b)
    total = (sympy.zeros(block.C.rows, 1),) * 2
    for f in block_functions(name, exponent, time):
        factor = (sympy.S.Zero, sympy.S.Zero)  # f at a + i b, by Horner's rule
        for c in sympy.Poly(f, name).all_coeffs():
            real, imaginary = _product(factor, (a, b))
            factor = (real + c, imaginary)
        total = tuple(before + after for before, after in zip(total, _product(_product(C, state), factor)))
        state = _product(J, state)
    return sympy.exp(a * time) * (total[0] * sympy.cos(b * time) - total[1] * sympy.sin(b * time))


def _product(one, two) -> tuple:
    """Product of complex numbers or matrices as pairs of real ones."""
    return one[0] * two[0] - one[1] * two[1], one[0] * two[1] + one[1] * two[0]
