"""What is printed of results is one short line, whatever is in them."""

import pytest
import sympy

from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from tests.exact.symbolic.models import MASSLESS_JOINTS, RIGID_LINK, c, k1, k2, m
from tests.exact.symbolic.test_long_coefficients import DAMPED_LINK

K = sympy.Matrix([[k1, -k1], [-k2, k1 + k2]])


@pytest.mark.parametrize("A", [MASSLESS_JOINTS, RIGID_LINK, DAMPED_LINK], ids=["5.2", "rigid link", "damped link"])
def test_they_are_short(A):
    pairs = A.jordan_pairs()
    shown = [pairs, pairs.finite, pairs.rational, pairs.infinite, pairs.laurent, *pairs.chains, *pairs.finite.blocks]
    shown += [*pairs.structure.elementary_divisors, *pairs.infinity]
    for thing in shown:
        text = repr(thing)
        assert text.startswith(type(thing).__name__) and "\n" not in text and "object at" not in text
        assert len(text) <= 300


def test_long_polynomials_are_shown_by_their_degree():
    A = SymbolicPolynomialMatrix([K + k1 * sympy.eye(2), c * K, m * sympy.eye(2)])
    (divisor,) = [d for d in A.structure().elementary_divisors if len(str(d.polynomial.as_expr())) > 60]
    assert repr(divisor) == "ElementaryDivisor(of degree 4 in s, exponents (1,))"
