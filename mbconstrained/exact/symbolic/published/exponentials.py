"""The formulas for e^{J t} of Moysis et al., section 2.2, as matrices of expressions: as printed there and corrected.

Here the zeros and the exponents of the minimal polynomial are exact, so that none of the three formulas loses anything: they are
the same functions written differently. ``jordan.exponential_forms`` has them in numbers, and says why the engine uses none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import sympy

from ....checks import whole_number
from ....errors import InputError
from ..algebra.matrix import S
from ..field.fields import field_of
from ..response.modes import modes
from ..response.principal_parts import principal_parts
from ..response.solution import functions_of
from .annihilators import check_annihilated, checked_expression, square_matrix, time_apart


def exponential_of_jordan_block(zero, size: int, t: sympy.Expr) -> sympy.ImmutableMatrix:
    """G(t) = e^{J t}, g_kj = e^{zero t} t^(j-k) / (j-k)!, shape (size, size), of one Jordan block (Lemma 2.11, Eqs. 30-33).

    The lemma holds for ONE block; the n_i x n_i matrix of a zero with several blocks is their direct sum.

    Args:
        zero: an expression, real or complex.
        size: at least 1.
        t: the time.

    Raises:
        InputError: a size below 1, or the zero depends on the time.

    >>> a, t = sympy.symbols("a t")
    >>> exponential_of_jordan_block(a, 2, t)
    Matrix([
    [exp(a*t), t*exp(a*t)],
    [       0,   exp(a*t)]])
    """
    zero, size = checked_expression(zero), whole_number(size, "size", minimum=1)
    t = time_apart(t, [zero])
    return (sympy.exp(zero * t) * _shifts(size, t)).as_immutable()


def exponential_of_real_jordan_block(real, imaginary, size: int, t: sympy.Expr) -> sympy.ImmutableMatrix:
    """e^{J t}, shape (2 size, 2 size), of one real block of the pair real +- i imaginary (Eqs. 38-41).

    J has D = [[a, b], [-b, a]] on its diagonal and I_2 beside it. Corrected: M in (40) is the rotation of (41) alone, which is
    e^{D t} without its factor e^{a t}; the pair has multiplicity m_i in a block of size 2 m_i.

    Raises:
        InputError: a size below 1, or the zero depends on the time.

    >>> w, t = sympy.symbols("w t")
    >>> exponential_of_real_jordan_block(0, w, 1, t)
    Matrix([
    [ cos(t*w), sin(t*w)],
    [-sin(t*w), cos(t*w)]])
    """
    real, imaginary, size = checked_expression(real), checked_expression(imaginary), whole_number(size, "size", minimum=1)
    t = time_apart(t, [real, imaginary])
    c, s = sympy.cos(imaginary * t), sympy.sin(imaginary * t)
    return (sympy.exp(real * t) * sympy.kronecker_product(_shifts(size, t), sympy.Matrix([[c, s], [-s, c]]))).as_immutable()


def exponential_by_interpolation(J: sympy.MatrixBase, exponents: Mapping[sympy.Expr, int], t: sympy.Expr) -> sympy.ImmutableMatrix:
    """e^{J t} = sum of J^k f_k(t), k < m, with the f_k of the confluent Vandermonde system (Lemma 2.12, Eqs. 34-35).

    The system is not solved as one: f_k is the inverse transform of p_k(s) / M(s) with M(s) = sum of c_j s^j the minimal
    polynomial and p_k(s) = sum of c_j s^(j-1-k), j > k, because (s I - J)^-1 = sum of J^k p_k(s) / M(s).

    Args:
        J: square; it need not be in Jordan form.
        exponents: the distinct zeros of J with their exponents m_j in the minimal polynomial, conjugates included. With larger
            exponents (the multiplicities) the formula holds as well.
        t: the time.

    Raises:
        InputError: no zeros, an exponent that is no whole number of at least 1, J is not square, or the product of the
            (J - zero I)^exponent is not 0: a zero is missing, or an exponent is too small.

    >>> t = sympy.Symbol("t")
    >>> exponential_by_interpolation(sympy.zeros(2, 2), {sympy.S.Zero: 1}, t)
    Matrix([
    [1, 0],
    [0, 1]])
    """
    J = square_matrix(J, "J")
    functions = interpolation_functions(exponents, t)
    t = time_apart(t, J)
    check_annihilated(J, {checked_expression(zero): exponent for zero, exponent in exponents.items()}, "J")
    total, power = sympy.zeros(*J.shape), sympy.eye(J.rows)
    for f in functions:
        total, power = total + power * f, power * J
    return total.as_immutable()


def interpolation_functions(exponents: Mapping[sympy.Expr, int], t: sympy.Expr) -> list[sympy.Expr]:
    """f_0(t) ... f_(m-1)(t) of (35), for zeros that are distinct expressions.

    Raises:
        InputError: as ``exponential_by_interpolation``.
    """
    if not isinstance(exponents, Mapping) or not exponents:
        raise InputError(f"exponents: found {exponents!r}; expected at least one zero, each with an exponent of at least 1")
    names = {sympy.Dummy(f"zero{i}"): checked_expression(zero) for i, zero in enumerate(exponents)}
    t = time_apart(t, names.values())
    field = field_of(list(names))
    factors = [
        (sympy.Poly(S - name, S, domain=field), whole_number(exponent, "exponent", minimum=1))
        for name, exponent in zip(names, exponents.values(), strict=True)
    ]
    return [f.xreplace(names) for f in functions_of_factors(factors, t)]


def functions_of_factors(factors: Sequence[tuple[sympy.Poly, int]], t: sympy.Expr) -> list[sympy.Expr]:
    """f_0(t) ... f_(m-1)(t) of (35) for the minimal polynomial that is the product of q^k: real for real factors q."""
    field, gen = factors[0][0].domain, factors[0][0].gen
    coefficients = sympy.prod((q**k for q, k in factors), sympy.Poly(1, gen, domain=field)).rep.to_list()
    numerators = [sympy.Poly(coefficients[: len(coefficients) - 1 - k], gen, domain=field) for k in range(len(coefficients) - 1)]
    total = [sympy.S.Zero] * len(numerators)
    for (q, _), parts in zip(factors, principal_parts(numerators, list(factors)), strict=True):
        roots = modes(q)
        for j, column in enumerate(zip(*parts, strict=True)):
            found = functions_of(roots, j, [{sympy.S.One: c} for c in column], t)
            total = [before + part for before, part in zip(total, found, strict=True)]
    return total


def exponential_by_blocks(
    blocks: Sequence[sympy.MatrixBase], zeros: Sequence[sympy.Expr], exponents: Sequence[int], t: sympy.Expr
) -> sympy.ImmutableMatrix:
    """e^{J t} as the direct sum of sum of f_ij(t) J_i^j, j < m_i, one term for each zero (Lemma 2.13, Eqs. 36-37).

    Corrected: (37) is meant for i = 1 ... l and j = 0 ... m_i - 1, J_i collects ALL blocks of the zero i, and 0^0 = 1.

    Args:
        blocks: J_i, square, with no other zero than zeros[i].
        zeros: distinct, one for each block.
        exponents: m_i of the minimal polynomial, the size of the largest Jordan block of the zero.
        t: the time.

    Raises:
        InputError: not one zero and exponent for each block, a zero twice, a block that is not square or has
            (J_i - zero I)^exponent other than 0.

    >>> t = sympy.Symbol("t")
    >>> exponential_by_blocks([sympy.Matrix([[0, 1], [0, 0]])], [sympy.S.Zero], [2], t)
    Matrix([
    [1, t],
    [0, 1]])
    """
    if any(isinstance(each, str) or not isinstance(each, Sequence) for each in (blocks, zeros, exponents)):
        raise InputError("blocks, zeros, exponents: expected three lists, with one entry each for each zero")
    zeros = [checked_expression(zero) for zero in zeros]
    if not len(blocks) == len(zeros) == len(exponents) == len(set(zeros)):
        raise InputError(f"expected one zero and one exponent for each of {len(blocks)} blocks, each zero once")
    blocks = [square_matrix(block, "J_i") for block in blocks]
    exponents = [whole_number(m, "exponent", minimum=1) for m in exponents]
    t = time_apart(t, [*zeros, *(entry for block in blocks for entry in block)])
    for block, zero, m in zip(blocks, zeros, exponents, strict=True):
        check_annihilated(block, {zero: m}, "J_i")
    parts = [_of_zero(block, zero, m, t) for block, zero, m in zip(blocks, zeros, exponents, strict=True)]
    return sympy.diag(*parts).as_immutable()


def block_functions(zero: sympy.Expr, exponent: int, t: sympy.Expr) -> list[sympy.Expr]:
    """f_i0(t) ... of (37) without the factor e^{zero t}."""
    return [
        sympy.Add(*((-zero) ** (n - j) * t**n / sympy.factorial(n - j) for n in range(j, exponent))) / sympy.factorial(j)
        for j in range(exponent)
    ]


def _of_zero(block, zero, exponent, t) -> sympy.Matrix:
    total, power = sympy.zeros(*block.shape), sympy.eye(block.rows)
    for f in block_functions(zero, exponent, t):
        total, power = total + power * f * sympy.exp(zero * t), power * block
    return total


def _shifts(size, t) -> sympy.Matrix:
    """The upper triangular Toeplitz matrix of t^k / k!."""
    return sympy.Matrix(size, size, lambda k, j: t ** (j - k) / sympy.factorial(j - k) if j >= k else sympy.S.Zero)
