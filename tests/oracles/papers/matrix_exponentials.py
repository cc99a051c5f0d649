"""The formulas for e^{J t} of Moysis et al., section 2.2, as printed there and corrected: views for study and comparison.

Zeros, entries and times are numbers or expressions; the result is a matrix of sympy. The engine uses none of the formulas as they
stand (``linalg.exponential``): for clusters they need the exact zeros and exponents, which rounded data do not have;
(35) is a confluent Vandermonde system whose condition grows without bound as zeros come close, and the sums (34) and (37) cancel
where |lambda t| is large. The engine takes a Taylor polynomial about the mean of a cluster instead, which is accurate however close
the zeros are. For a single block of size one, or a pair a +- i b, its closed formulas are (32) and (40).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import sympy

from mbconstrained.exact.symbolic.fields import field_of
from mbconstrained.exact.symbolic.inverse_transform import Quotient, regular_parts
from mbconstrained.exact.symbolic.symbolic_matrix import S
from mbconstrained.ground.checks import whole_number
from mbconstrained.ground.errors import InputError


def exponential_of_jordan_block(zero, size: int, t) -> sympy.ImmutableMatrix:
    """G(t) = e^{J t}, g_kj = e^{zero t} t^(j-k) / (j-k)!, shape (size, size), of one Jordan block (Lemma 2.11, Eqs. 30-33).

    The lemma holds for ONE block; the n_i x n_i matrix of a zero with several blocks is their direct sum.

    >>> a, t = sympy.symbols("a t")
    >>> exponential_of_jordan_block(a, 2, t)
    Matrix([
    [exp(a*t), t*exp(a*t)],
    [       0,   exp(a*t)]])
    """
    size = whole_number(size, "size", minimum=1)
    zero = _checked_expression(zero)
    t = _separate_time(t, [zero])
    return (sympy.exp(zero * t) * _shifts(size, t)).as_immutable()


def exponential_of_real_jordan_block(real, imaginary, size: int, t) -> sympy.ImmutableMatrix:
    """e^{J t}, shape (2 size, 2 size), of one real block of the pair real +- i imaginary (Eqs. 38-41).

    J has D = [[a, b], [-b, a]] on its diagonal and I_2 next to it. Corrected: M in (40) is the rotation of (41) alone, which is
    e^{D t} without its factor e^{a t}; the pair has multiplicity m_i in a block of size 2 m_i.

    >>> w, t = sympy.symbols("w t")
    >>> exponential_of_real_jordan_block(0, w, 1, t)
    Matrix([
    [ cos(t*w), sin(t*w)],
    [-sin(t*w), cos(t*w)]])
    """
    size = whole_number(size, "size", minimum=1)
    real, imaginary = _checked_expression(real), _checked_expression(imaginary)
    t = _separate_time(t, [real, imaginary])
    c, s = sympy.cos(imaginary * t), sympy.sin(imaginary * t)
    return (sympy.exp(real * t) * sympy.kronecker_product(_shifts(size, t), sympy.Matrix([[c, s], [-s, c]]))).as_immutable()


def exponential_by_interpolation(J, exponents: Mapping, t) -> sympy.ImmutableMatrix:
    """e^{J t} = sum of J^k f_k(t), k < m, with the f_k of the confluent Vandermonde system (Lemma 2.12, Eqs. 34-35).

    The system is not solved as one: f_k is the inverse transform of p_k(s) / M(s) with M(s) = sum of c_j s^j the
    minimal polynomial and p_k(s) = sum of c_j s^(j-1-k), j > k, because (s I - J)^-1 = sum of J^k p_k(s) / M(s).

    >>> exponential_by_interpolation(sympy.zeros(2, 2), {sympy.S.Zero: 1}, sympy.Symbol("t"))
    Matrix([
    [1, 0],
    [0, 1]])
    """
    J, functions = _square_matrix(J, "J"), interpolation_functions(exponents, t)
    _separate_time(t, J)
    _check_annihilated(J, {_checked_expression(zero): exponent for zero, exponent in exponents.items()}, "J")
    return _combination(functions, J).as_immutable()


def interpolation_functions(exponents: Mapping[sympy.Expr, int], t: sympy.Expr) -> list[sympy.Expr]:
    """f_0(t) ... f_(m-1)(t) of (35), for zeros that are distinct expressions."""
    if not isinstance(exponents, Mapping) or not exponents:
        raise InputError(f"exponents: found {exponents!r}; expected at least one zero, each with an exponent of at least 1")
    names = {sympy.Dummy(f"zero{i}"): _checked_expression(zero) for i, zero in enumerate(exponents)}
    t = _separate_time(t, names.values())
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
    return regular_parts(len(numerators), [Quotient({sympy.S.One: numerators}, list(factors))], t)


def exponential_by_blocks(blocks: Sequence, zeros: Sequence, exponents: Sequence[int], t) -> sympy.ImmutableMatrix:
    """e^{J t} as the direct sum of sum of f_ij(t) J_i^j, j < m_i, one term for each zero (Lemma 2.13, Eqs. 36-37).

    Corrected: (37) is meant for i = 1 ... l and j = 0 ... m_i - 1, J_i collects ALL blocks of the zero i, and 0^0 = 1.

    >>> exponential_by_blocks([sympy.Matrix([[0, 1], [0, 0]])], [sympy.S.Zero], [2], sympy.Symbol("t"))
    Matrix([
    [1, t],
    [0, 1]])
    """
    if any(isinstance(each, str) or not isinstance(each, Sequence) for each in (blocks, zeros, exponents)):
        raise InputError("blocks, zeros, exponents: expected three lists, one entry of each for each zero")
    zeros = [_checked_expression(zero) for zero in zeros]
    if not len(blocks) == len(zeros) == len(exponents) == len(set(zeros)):
        raise InputError(f"expected one zero and one exponent for each of {len(blocks)} blocks, each zero once")
    blocks = [_square_matrix(block, "J_i") for block in blocks]
    exponents = [whole_number(m, "exponent", minimum=1) for m in exponents]
    t, parts = _separate_time(t, [*zeros, *(entry for block in blocks for entry in block)]), []
    for block, zero, m in zip(blocks, zeros, exponents, strict=True):
        _check_annihilated(block, {zero: m}, "J_i")
        parts.append(_combination([f * sympy.exp(zero * t) for f in block_functions(zero, m, t)], block))
    return sympy.diag(*parts).as_immutable()


def _combination(functions: Sequence[sympy.Expr], J: sympy.MatrixBase) -> sympy.Matrix:
    """The sum of f_k J^k."""
    total, power = sympy.zeros(*J.shape), sympy.eye(J.rows)
    for f in functions:
        total, power = total + power * f, power * J
    return total


def block_functions(zero: sympy.Expr, exponent: int, t: sympy.Expr) -> list[sympy.Expr]:
    """f_i0(t) ... of (37) without the factor e^{zero t}."""
    return [
        sympy.Add(*((-zero) ** (n - j) * t**n / sympy.factorial(n - j) for n in range(j, exponent))) / sympy.factorial(j)
        for j in range(exponent)
    ]


def _shifts(size, t) -> sympy.Matrix:
    """The upper triangular Toeplitz matrix of t^k / k!."""
    return sympy.Matrix(size, size, lambda k, j: t ** (j - k) / sympy.factorial(j - k) if j >= k else sympy.S.Zero)


# Validation: a square J, its zeros, and exponents that make the product of (J - zero I)^exponent zero.

#: Decimal digits of the check that the exponents are those of J: a product below half of them is zero.
DIGITS = 60


def _checked_expression(value, what: str = "zeros", expected: str = "numbers or expressions") -> sympy.Expr:
    """A number or an expression as an expression, or an InputError."""
    try:
        return sympy.sympify(value, strict=True)
    except sympy.SympifyError:
        raise InputError(f"{what}: found {value!r}; expected {expected}") from None


def _separate_time(t, constants: Iterable[sympy.Expr]) -> sympy.Expr:
    """The time, an expression that shares no symbol with the constants."""
    t = _checked_expression(t, "t", "a symbol or an expression, e.g. sympy.Symbol('t', real=True)")
    known = {symbol.name for constant in constants for symbol in constant.free_symbols}
    if shared := sorted(known & {symbol.name for symbol in t.free_symbols}):
        raise InputError(f"t: the symbol {shared[0]} is also one of J; name the time otherwise")
    return t


def _square_matrix(J, what: str) -> sympy.ImmutableMatrix:
    """A square matrix of expressions."""
    try:
        matrix = sympy.ImmutableMatrix(J)
    except (TypeError, ValueError, sympy.SympifyError):
        raise InputError(f"{what}: found {J!r}; expected a square matrix of numbers or expressions") from None
    if matrix.rows != matrix.cols:
        raise InputError(f"{what}: found shape {matrix.shape}; expected a square matrix")
    return matrix


def _check_annihilated(J: sympy.ImmutableMatrix, exponents: Mapping[sympy.Expr, int], what: str) -> None:
    """The product of (J - zero I)^exponent is 0, at one value of the symbols and in many digits: a product that is zero there is zero."""
    symbols = sorted(set().union(J.free_symbols, *(zero.free_symbols for zero in exponents)), key=str)
    values = {symbol: _generic(symbol, i) for i, symbol in enumerate(symbols)}
    product, scale = sympy.eye(J.rows), sympy.S.One
    for zero, exponent in exponents.items():
        factor = (J - zero * sympy.eye(J.rows)).subs(values).evalf(DIGITS)
        product, scale = product * factor**exponent, scale * sum(map(abs, factor)) ** exponent
    if any(abs(entry.evalf(DIGITS)) > scale * sympy.Float(10) ** (-DIGITS // 2) for entry in product):
        factors = " ".join(f"({what} - ({zero}) I)^{exponent}" for zero, exponent in exponents.items())
        raise InputError(f"exponents: {factors} is not 0; expected every zero of {what}, with the length of its longest chain")


def _generic(symbol: sympy.Symbol, index: int) -> sympy.Rational:
    """A number between 1 and 2, or its negative, that no other symbol has."""
    value = 1 + sympy.Rational(sympy.prime(index + 4), sympy.prime(index + 6) + 13)
    return -value if symbol.is_negative else value
