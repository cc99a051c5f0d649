"""The three formulas for e^{J t} with symbols, against the equations that define them and each other."""

import pytest
import sympy

import mbconstrained as mb
from tests.oracles.papers.matrix_exponentials import (
    exponential_by_blocks,
    exponential_by_interpolation,
    exponential_of_jordan_block,
    exponential_of_real_jordan_block,
    interpolation_functions,
)

t, u = sympy.symbols("t u")
a, b, w = sympy.symbols("a b w", positive=True)
I = sympy.I

# (zero, sizes of its Jordan blocks) of each; derogatory: more than one block for a zero
STRUCTURES = [
    [(a, (1,))],
    [(sympy.S.Zero, (1, 1))],
    [(sympy.S.Zero, (3,))],
    [(sympy.S.Zero, (1, 2)), (-a, (2, 2))],
    [(a, (3,)), (b, (1,))],
    [(-a + I * w, (2,)), (-a - I * w, (2,))],
    pytest.param([(sympy.S.Zero, (2,)), (I * w, (1, 1)), (-I * w, (1, 1)), (-b, (1,))], marks=pytest.mark.long),
    pytest.param([(sympy.sqrt(5) * a, (1,)), (-sympy.sqrt(5) * a, (1,)), (b, (2,))], marks=pytest.mark.long),
]
structures = pytest.mark.parametrize("structure", STRUCTURES)


def jordan_block(zero, size):
    return zero * sympy.eye(size) + sympy.Matrix(size, size, lambda i, j: int(j == i + 1))


def collected(structure):
    """J_i with all blocks of a zero, for each zero."""
    return [sympy.diag(*[jordan_block(zero, size) for size in sizes]) for zero, sizes in structure]


def by_lemma_2_11(structure, t):
    return sympy.diag(*[exponential_of_jordan_block(zero, size, t) for zero, sizes in structure for size in sizes])


def by_lemma_2_12(structure, t):
    return exponential_by_interpolation(sympy.diag(*collected(structure)), {zero: max(sizes) for zero, sizes in structure}, t)


def by_lemma_2_13(structure, t):
    zeros, sizes = zip(*structure, strict=True)
    return exponential_by_blocks(collected(structure), zeros, [max(s) for s in sizes], t)


formulas = pytest.mark.parametrize("formula", [by_lemma_2_11, by_lemma_2_12, by_lemma_2_13])


def is_zero(matrix) -> bool:
    return all(sympy.simplify(sympy.expand(entry)) == 0 for entry in matrix)


@formulas
@structures
def test_each_is_the_solution_of_its_differential_equation(formula, structure):
    """E' = J E and E(0) = I determine E: no exponential of a matrix is needed to know it."""
    J, E = sympy.diag(*collected(structure)), formula(structure, t)
    assert is_zero(E.diff(t) - J * E) and is_zero(E.subs(t, 0) - sympy.eye(J.rows))


@structures
def test_the_functions_solve_the_confluent_vandermonde_system(structure):
    """(35): the sum over k of binomial(k, i) zero^(k-i) f_k(t) is t^i/i! e^{zero t}."""
    exponents = {zero: max(sizes) for zero, sizes in structure}
    f = interpolation_functions(exponents, t)
    assert len(f) == sum(exponents.values())
    for zero, m in exponents.items():
        for i in range(m):
            left = sum(sympy.binomial(k, i) * zero ** (k - i) * f[k] for k in range(i, len(f)))
            assert sympy.simplify(sympy.expand(left - t**i / sympy.factorial(i) * sympy.exp(zero * t))) == 0


def test_larger_exponents_than_those_of_the_minimal_polynomial_are_right_too():
    J = sympy.diag(a, a, b)
    assert is_zero(
        exponential_by_interpolation(J, {a: 2, b: 1}, t) - sympy.diag(sympy.exp(a * t), sympy.exp(a * t), sympy.exp(b * t))
    )


@pytest.mark.parametrize("size", [1, 2, 3])
def test_a_real_block_of_a_pair(size):
    """E' = J E and E(0) = I with (38): as printed, with M = e^{D t} in (41), the factor e^{a t} would stand twice."""
    D = sympy.Matrix([[a, w], [-w, a]])
    J = sympy.kronecker_product(sympy.eye(size), D) + sympy.kronecker_product(jordan_block(0, size), sympy.eye(2))
    E = exponential_of_real_jordan_block(a, w, size, t)
    assert is_zero(E.diff(t) - J * E) and E.subs(t, 0) == sympy.eye(2 * size)
    pair = {a + I * w: size, a - I * w: size}
    values = {a: sympy.Rational(1, 3), w: sympy.Rational(7, 5), t: sympy.Rational(3, 2)}
    difference = (exponential_by_interpolation(J, pair, t) - E).subs(values)
    assert all(abs(sympy.N(entry, 30)) < 1e-28 for entry in difference)


@structures
@pytest.mark.parametrize("wrong", ["exponent", "zero"])
def test_zeros_and_exponents_that_are_not_those_of_the_matrix_are_refused(structure, wrong):
    """A larger exponent is right (the terms beyond are zero), a smaller one or another zero gives another function."""
    *rest, (zero, sizes) = sorted(structure, key=lambda pair: max(pair[1]))
    if wrong == "exponent" and max(sizes) == 1:
        return
    taken = (zero, max(sizes) - 1) if wrong == "exponent" else (zero + 1, max(sizes))
    J = sympy.diag(*collected(structure))
    with pytest.raises(mb.InputError, match="is not 0; expected every zero of J"):
        exponential_by_interpolation(J, dict([*((each, max(its)) for each, its in rest), taken]), t)
    with pytest.raises(mb.InputError, match="is not 0; expected every zero of J_i"):
        exponential_by_blocks(collected([(zero, sizes)]), [taken[0]], [taken[1]], t)


def test_two_times_multiply():
    one = exponential_of_jordan_block(a, 3, t) * exponential_of_jordan_block(a, 3, u)
    assert is_zero(one - exponential_of_jordan_block(a, 3, t + u))


@pytest.mark.parametrize(
    ("ask", "text"),
    [
        (lambda: exponential_of_jordan_block(a, 0, t), "size: found 0"),
        (lambda: exponential_of_jordan_block("a", 1, t), "zeros: found 'a'"),
        (lambda: exponential_by_interpolation(sympy.eye(2), {}, t), "exponents: found {}"),
        (lambda: exponential_by_interpolation(sympy.eye(2), {a: 0}, t), "exponent: found 0"),
        (lambda: exponential_by_blocks([sympy.eye(1)] * 2, [a, a], [1, 1], t), "each zero once"),
        (lambda: exponential_by_blocks([sympy.eye(1)], [a], [1, 2], t), "one zero and one exponent"),
        (lambda: exponential_by_blocks(3, [a], [1], t), "expected three lists"),
        (lambda: exponential_by_blocks([[[a, 1]]], [a], [1], t), r"J_i: found shape \(1, 2\)"),
        (lambda: exponential_by_interpolation([[a, 0]], {a: 1}, t), r"J: found shape \(1, 2\)"),
        (lambda: exponential_by_interpolation("J", {a: 1}, t), "J: found 'J'"),
        (lambda: exponential_by_interpolation([[a]], {a: 1}, "t"), "t: found 't'"),
        (lambda: exponential_by_blocks([[[a]]], [a], [1], "t"), "t: found 't'"),
        (lambda: exponential_of_jordan_block(a, 1, "t"), "t: found 't'"),
        (lambda: exponential_of_jordan_block(sympy.Symbol("t", real=True), 1, t), "t: the symbol t is also one of J"),
        (lambda: exponential_of_real_jordan_block(a, t, 1, t), "t: the symbol t is also one of J"),
        (lambda: exponential_by_interpolation([[a, t], [0, a]], {a: 2}, t), "t: the symbol t is also one of J"),
        (lambda: exponential_by_blocks([[[t]]], [t], [1], t), "t: the symbol t is also one of J"),
        (lambda: interpolation_functions({t: 1}, t), "t: the symbol t is also one of J"),
    ],
)
def test_what_is_asked_is_checked(ask, text):
    with pytest.raises(mb.InputError, match=text):
        ask()
