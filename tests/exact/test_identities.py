"""The identities between A(s), its exact pairs and H_i (Moysis et al., sections 2 and 3, corrected), over both fields and for every value of the symbols."""

from functools import cache, cached_property
from math import comb

import numpy as np
import pytest
import sympy
from sympy.polys.matrices import DomainMatrix

import mbconstrained as mb
from mbconstrained.exact.engine import HypercompanionBlock
from tests.exact.rational.products import MATRICES
from tests.exact.symbolic.gallery import MODELS

NAMES = [*MATRICES, *(f"with symbols: {name}" for name in MODELS)]
every = pytest.mark.parametrize("name", NAMES)


class Known:
    """A matrix, its pairs, and block matrices of the paper, over its field: equal entries are equal, whatever they are written as."""

    def __init__(self, matrix):
        self.matrix, self.pairs = matrix, mb.exact.jordan_pairs(matrix)
        self.field = matrix.field if isinstance(matrix, mb.SymbolicPolynomialMatrix) else sympy.QQ
        self.A = [self.over_field(coefficient) for coefficient in matrix.coefficients]
        self.q, self.r, self.structure = matrix.degree, matrix.size, self.pairs.structure
        self.n, self.highest = self.structure.finite_count, self.structure.highest_impulse
        self.C, self.J, self.B = self.parts(self.pairs.rational)

    def over_field(self, matrix) -> DomainMatrix:
        """A matrix of expressions, of Fractions or of floats, which are the exact numbers that they are."""
        number = self.field.from_sympy if isinstance(matrix, sympy.MatrixBase) else lambda x: sympy.QQ(*x.as_integer_ratio())
        return DomainMatrix([[number(entry) for entry in row] for row in matrix.tolist()], matrix.shape, self.field)

    def parts(self, pair) -> tuple[DomainMatrix, ...]:
        return tuple(self.over_field(matrix) for matrix in (pair.C, pair.J, pair.B))

    def zero(self, *shape) -> DomainMatrix:
        return DomainMatrix.zeros(shape or (self.r, self.r), self.field).to_dense()

    def identity(self, size: int) -> DomainMatrix:
        return DomainMatrix.eye(size, self.field).to_dense()

    def H(self, index: int) -> DomainMatrix:
        return self.over_field(self.pairs.laurent(index))

    def powers(self, J: DomainMatrix, count: int) -> list[DomainMatrix]:
        """I, J, ..., J^(count - 1)."""
        found = [self.identity(J.shape[0])]
        while len(found) < count:
            found.append(found[-1] * J)
        return found[:count]

    def row(self, first: int) -> DomainMatrix:
        """[H_first ... H_(first + q - 1)]."""
        return self.zero(self.r, 0).hstack(*(self.H(first + k) for k in range(self.q)))

    def _blocks(self, block) -> DomainMatrix:
        """q x q blocks (a, c), None for a zero one."""
        rows = []
        for a in range(self.q):
            found = (block(a, c) for c in range(self.q))
            rows.append(self.zero(self.r, 0).hstack(*(self.zero() if entry is None else entry for entry in found)))
        return self.zero(0, self.q * self.r).vstack(*rows)

    @cached_property
    def M1(self) -> DomainMatrix:
        """The block A_(q-a+c) at (a, c), a >= c."""
        return self._blocks(lambda a, c: self.A[self.q - a + c] if a >= c else None)

    @cached_property
    def M0(self) -> DomainMatrix:
        """The block A_(c-a) at (a, c), c >= a."""
        return self._blocks(lambda a, c: self.A[c - a] if c >= a else None)

    @cached_property
    def toeplitz(self) -> DomainMatrix:
        """The block H_(c-a) at (a, c)."""
        return self._blocks(lambda a, c: self.H(c - a))

    @cached_property
    def observed(self) -> DomainMatrix:
        """col(C, ..., C J^(q-1))."""
        return self.zero(0, self.n).vstack(*(self.C * power for power in self.powers(self.J, self.q)))

    @cached_property
    def steered(self) -> DomainMatrix:
        """[J^(q-1) B ... B]."""
        return self.zero(self.n, 0).hstack(*(power * self.B for power in reversed(self.powers(self.J, self.q))))


@cache
def known(name: str) -> Known:
    """The matrix with this name."""
    if name in MATRICES:
        return Known(mb.PolynomialMatrix(MATRICES[name]))
    return Known(MODELS[name.partition(": ")[2]])


def same(one: DomainMatrix, two: DomainMatrix) -> bool:
    """Equal entries: their differences vanish in the field."""
    assert one.shape == two.shape
    return not any(entry for row in (one - two).to_list() for entry in row)


def nilpotent(sizes) -> np.ndarray:
    """Jordan blocks of zero."""
    starts = np.cumsum([0, *sizes])
    J = np.eye(starts[-1], k=1)
    J[:, [start for start in starts[:-1] if start]] = 0
    return J


@every
def test_degrees_add_up(name):
    x = known(name)
    assert x.n == sum(d.degree * d.multiplicity for d in x.structure.elementary_divisors) == x.J.shape[0]
    assert x.n + sum(x.structure.infinite_divisors) == x.r * x.q


@every
def test_laurent_coefficients_convolve_with_a_to_the_identity(name):
    """sum of H_(k-j) A_j = sum of A_j H_(k-j) = delta_k I, and H_i = 0 above the highest zero at infinity (28)."""
    x = known(name)
    for k in range(-2, x.highest + x.q + 1):
        expected = x.identity(x.r) if k == 0 else x.zero()
        assert same(sum((x.H(k - j) * matrix for j, matrix in enumerate(x.A)), x.zero()), expected)
        assert same(sum((matrix * x.H(k - j) for j, matrix in enumerate(x.A)), x.zero()), expected)
    assert same(x.H(x.highest + 1), x.zero())
    assert not x.highest or not same(x.H(x.highest), x.zero())


@every
def test_both_pairs_give_the_laurent_coefficients(name):
    """C J^(i-1) B = H_-i, i >= 1; C_inf J_inf^i B_inf = H_i, i >= 0 (27), J_inf with blocks of the sizes |q_i| + 1 for q_i <= 0 (23-24, corrected)."""
    x = known(name)
    for i, power in enumerate(x.powers(x.J, 4)):
        assert same(x.C * power * x.B, x.H(-1 - i))
    C, J, B = x.parts(x.pairs.infinite)
    assert same(J, x.over_field(nilpotent(x.structure.infinite_chains)))
    for i, power in enumerate(x.powers(J, x.highest + 2)):
        assert same(C * power * B, x.H(i))


@every
def test_finite_pair_is_a_minimal_pair_of_a(name):
    """sum of A_j C J^j = 0, sum of J^j B A_j = 0, and [J^(q-1) B ... B] M1 col(C ... C J^(q-1)) = I_n."""
    x = known(name)
    powers = x.powers(x.J, x.q + 1)
    assert same(sum((A * x.C * power for A, power in zip(x.A, powers)), x.zero(x.r, x.n)), x.zero(x.r, x.n))
    assert same(sum((power * x.B * A for A, power in zip(x.A, powers)), x.zero(x.n, x.r)), x.zero(x.n, x.r))
    assert same(x.steered * x.M1 * x.observed, x.identity(x.n))


@every
def test_jump_projector(name):
    """P = col(C ...) [...] M1 is a projector of rank n, and P + [H_(c-k)] M0 = I ((61) corrected)."""
    x = known(name)
    P = x.observed * x.steered * x.M1
    assert same(P * P, P)
    assert P.rank() == x.n
    assert same(P + x.toeplitz * x.M0, x.identity(x.r * x.q))
    if isinstance(x.matrix, mb.SymbolicPolynomialMatrix):
        assert same(x.over_field(x.pairs.jump_projector), P)


@every
def test_impulses_of_values_before_row_by_row(name):
    """[H_(p-q+1) ... H_p] M1 = -[H_(p+1) ... H_(p+q)] M0 for p >= 0 (29); the rank of all of them is the sum of the orders of infinite zeros."""
    x = known(name)
    maps = [x.row(p + 1) * x.M0 for p in range(x.q + x.highest)]
    for p, impulses in enumerate(maps):
        assert same(x.row(p - x.q + 1) * x.M1, -impulses)
    whole = x.zero(0, x.r * x.q).vstack(*maps)
    assert whole.rank() == sum(max(0, -order) for order in x.structure.at_infinity)


@every
def test_infinite_pairs_are_chains_of_the_dual(name):
    """sum of A_(q-j) C_b J_b^j = 0 for the minimal pair and for the whole one of the dual at 0, which fills the space with the finite pair."""
    x = known(name)
    dual = mb.exact.jordan_pairs(x.matrix.dual)
    s = dual.ring.polynomial([dual.ring.zero, dual.ring.one])
    places = [place for place, (p, _) in enumerate(dual.factors) if p == s]
    blocks = [HypercompanionBlock(term) for place in places for term in dual.root_polynomials(place)]
    assert [block.length for block in blocks] == [degree for degree in x.structure.infinite_divisors if degree]
    whole = x.zero(x.r, 0).hstack(*(x.over_field(block.C) for block in blocks)), x.over_field(nilpotent([b.length for b in blocks]))
    minimal = x.parts(x.pairs.infinite)[:2]
    for C, J in (whole, minimal) if x.q else ():
        total = sum((x.A[x.q - j] * C * power for j, power in enumerate(x.powers(J, x.q + 1))), x.zero(*C.shape))
        assert same(total, x.zero(*C.shape))
    C, J = whole
    both = x.observed.hstack(x.zero(0, J.shape[0]).vstack(*(C * power for power in reversed(x.powers(J, x.q)))))
    assert both.shape == (x.r * x.q, x.r * x.q)
    assert both.rank() == x.r * x.q


@every
def test_chains_solve_their_equations_at_every_root(name):
    """A(s) (v_0 + v_1 (s - z) + ...) = O((s - z)^k) at every zero z of p, as polynomials in z modulo p; one chain for each elementary divisor."""
    x = known(name)
    ring, matrix = x.pairs.ring, x.pairs.matrix
    entries = matrix.polynomials if isinstance(x.matrix, mb.SymbolicPolynomialMatrix) else matrix.entries

    def derivative(p, order):  # divided by order!
        c = ring.coefficients(p, p.degree() + 1) if p else []
        return ring.polynomial([c[n] * comb(n, order) for n in range(order, len(c))])

    for chain in x.pairs.chains:
        for order in range(chain.length):
            for row in entries:
                terms = (derivative(row[l], i) * chain.right[order - i][l] for i in range(order + 1) for l in range(x.r))
                assert not sum(terms, ring.polynomial([])) % chain.term.divisor
        assert any(chain.right[0])
    found = [(chain.polynomial, chain.length) for chain in x.pairs.chains]
    assert found == [(d.polynomial, k) for d in x.structure.elementary_divisors for k in d.exponents]
