"""The algebra of A(s) over a field K, written once: root polynomials, Jordan chains, both Jordan pairs, structure, Laurent coefficients.

Two fields offer the names of ``PolynomialRing``: the rationals by FLINT (``exact.rational``), and rational functions of symbols by SymPy
(``exact.symbolic``). Imports neither of them.

At the zeros of an irreducible p the principal part of A(s)^-1 is a sum of columns times rows phi psi^T / p^k, one for each elementary
divisor p^k: p^k divides A phi and psi^T A (Gohberg, Lancaster and Rodman, Matrix Polynomials, section 1.5).
"""

from __future__ import annotations

import numbers
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import count
from math import comb, prod
from typing import Any, Protocol

from ..ground.errors import InputError
from ..polynomial.structure import Structure

#: An element of K, a polynomial over K (with +, -, *, **, //, %, divmod and degree(); false where it is zero), and a matrix as users
#: read it: an array of Fractions or a matrix of sympy.
Element = Any
Polynomial = Any
Matrix = Any


class PolynomialRing(Protocol):
    """K[s] of a field K; users read exported polynomials, and matrices."""

    zero: Element
    one: Element

    # Coefficients stand with the lowest power first; the monic irreducible factors with their multiplicities, low degrees first.
    def polynomial(self, coefficients: Sequence[Element]) -> Polynomial: ...
    def coefficients(self, p: Polynomial, count: int) -> list[Element]: ...
    def inverse(self, p: Polynomial, modulus: Polynomial) -> Polynomial: ...
    def factors(self, p: Polynomial) -> list[tuple[Polynomial, int]]: ...
    def weight(self, p: Polynomial) -> int: ...  # of possible pivots the one of least weight is taken
    def text(self, p: Polynomial) -> str: ...  # in short, for representations
    def exported(self, p: Polynomial) -> Any: ...
    def chain(self, term: RootPolynomials) -> JordanChain: ...
    def finite_zeros(self, divisors: Sequence[tuple[Polynomial, int, tuple[int, ...]]]) -> tuple: ...  # p, multiplicity, exponents
    def matrix(self, rows: Sequence[Sequence[Element]]) -> Matrix: ...
    def joined(self, matrices: Sequence[Matrix], axis: int) -> Matrix: ...  # below each other (axis 0) or side by side (1)
    def diagonal(self, matrices: Sequence[Matrix]) -> Matrix: ...  # block diagonal


class ExactMatrix(Protocol):
    """A regular A(s) over K by its determinant and its adjugate; root polynomials by elimination modulo powers of p."""

    coefficients: Sequence[Any]
    size: int

    @property
    def degree(self) -> int:
        """The declared degree q (the number of coefficients less one)."""
        return len(self.coefficients) - 1

    @property
    def ring(self) -> Any: ...

    @property
    def determinant(self) -> Polynomial: ...

    @property
    def adjugate(self) -> Sequence[Sequence[Polynomial]]: ...

    def root_polynomials(self, p: Polynomial, multiplicity: int) -> list[RootPolynomials]:
        """Root polynomials at the zeros of a monic irreducible p, given with its multiplicity in det A(s), ascending lengths."""
        return eliminated(self.ring, self.adjugate, self.determinant, p, multiplicity) if multiplicity else []

    def infinite_root_polynomials(self) -> list[RootPolynomials]:
        """Root polynomials of s^q A(1/s) at s = 0, q = max(degree, 1), ascending lengths, with an entry of each row psi 1 (Moysis et al., Eq. 97)."""
        ring, r, q = self.ring, self.size, max(self.degree, 1)
        s, multiplicity = ring.polynomial([ring.zero, ring.one]), q * r - self.determinant.degree()
        if not multiplicity:
            return []

        def mirrored(p: Polynomial, degree: int) -> Polynomial:
            return ring.polynomial(ring.coefficients(p, degree + 1)[::-1])

        transposed = [[mirrored(entry, q * (r - 1)) for entry in column] for column in zip(*self.adjugate)]
        terms = eliminated(ring, transposed, mirrored(self.determinant, q * r), s, multiplicity)
        return [RootPolynomials(ring, s, t.length, t.left, lambda t=t: t.right, t.pivot) for t in terms]


@dataclass(frozen=True, repr=False)
class RootPolynomials:
    """One term phi psi^T / p^k of the principal part of A(s)^-1 at the zeros of p."""

    ring: PolynomialRing  # K[s]
    divisor: Polynomial  # p, irreducible and monic
    length: int  # k
    right: tuple[Polynomial, ...]  # phi, r polynomials modulo p^k
    # returns psi; over the rationals its coefficients have many more digits than those of phi
    compute_left: Callable[[], tuple[Polynomial, ...]] = field(compare=False)
    pivot: Polynomial | None = None  # the divisor of the elimination, where there is one: a polynomial not divisible by p

    def __repr__(self) -> str:
        return f"RootPolynomials({self.ring.text(self.divisor)}, length={self.length})"

    @cached_property
    def left(self) -> tuple[Polynomial, ...]:
        """psi, r polynomials modulo p^k."""
        return self.compute_left()


# Elimination modulo p^k: K[s] modulo p^k is a local ring, in which every element is a power of p times a unit.
#
# Pivots of least valuation give P = sum over j of p^a_j phi_j psi_j^T modulo p^k, a_1 <= a_2 <= ... < k, with phi_j independent
# modulo p, and psi_j too. Where P = p^k A(s)^-1, the elementary divisors of A(s) are p^(k - a_j), and phi_j and psi_j are root
# polynomials. Pivots are short, and the assumptions on symbols are their factors.


def eliminated(ring: PolynomialRing, adjugate, determinant: Polynomial, p: Polynomial, multiplicity: int) -> list[RootPolynomials]:
    """The terms of adjugate / determinant at the zeros of p, ascending lengths; one entry of each right column is 1."""
    common = 0 if multiplicity == 1 else min(valuation(e, p) for row in adjugate for e in row if e)
    k = multiplicity - common
    others = ring.inverse(determinant // p**multiplicity % p**k, p**k)
    rows = [[entry // p**common % p**k * others % p**k for entry in row] for row in adjugate]
    steps = list(_elimination(ring, rows, p, k))
    return [RootPolynomials(ring, p, k - a, right, lambda left=left: left, pivot) for a, right, left, pivot in reversed(steps)]


def local_exponents(ring: PolynomialRing, rows, p: Polynomial, bound: int) -> tuple[int, ...]:
    """The exponents of p among the elementary divisors of a matrix of polynomials, ascending, zeros too; all are below a bound."""
    return tuple(a for a, *_ in _elimination(ring, [[entry % p**bound for entry in row] for row in rows], p, bound))


def _elimination(ring: PolynomialRing, rows, p: Polynomial, k: int) -> Iterator[tuple[int, tuple, tuple, Polynomial]]:
    """a_j, phi_j and psi_j of rows modulo p^k, and the unit of each pivot modulo p."""
    while place := _pivot(ring, rows, p):
        a, i, j = place
        modulus, below = p ** (k - a), p**a
        unit = rows[i][j] // below
        inverse = ring.inverse(unit, modulus)
        right = tuple(row[j] // below * inverse % modulus for row in rows)
        left = tuple(entry // below for entry in rows[i])
        rows = [[entry - c * d % modulus * below for entry, d in zip(row, left)] for row, c in zip(rows, right)]
        yield a, right, left, unit % p


def valuation(entry: Polynomial, p: Polynomial) -> int:
    """The highest power of p that divides an entry other than zero."""
    power = 0
    while True:
        quotient, rest = divmod(entry, p)
        if rest:
            return power
        entry, power = quotient, power + 1


def _pivot(ring: PolynomialRing, rows, p: Polynomial) -> tuple[int, int, int] | None:
    """(a, i, j) of an entry of least valuation a, the simplest of them."""
    best = None
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            if entry:
                a = valuation(entry, p)
                unit = entry // p**a
                key = (a, (unit % p).degree(), ring.weight(unit), i, j)
                best = key if best is None or key < best else best
    return None if best is None else (best[0], best[-2], best[-1])


# Power series over K[x]/q, and series at infinity.


class PowerSeries:
    """A power series in h with coefficients in K[x]/q, q irreducible: polynomials modulo q, as many as are given."""

    def __init__(self, ring: PolynomialRing, q: Polynomial, coefficients: Sequence[Polynomial]):
        self.ring, self.q, self.coefficients = ring, q, list(coefficients)

    def __mul__(self, other: PowerSeries) -> PowerSeries:
        one, two, zero = self.coefficients, other.coefficients, self.ring.polynomial([])
        terms = [sum((one[i] * two[j - i] for i in range(j + 1)), zero) % self.q for j in range(len(one))]
        return PowerSeries(self.ring, self.q, terms)

    def __pow__(self, exponent: int) -> PowerSeries:
        zeros = [self.ring.polynomial([])] * (len(self.coefficients) - 1)
        return prod([self] * exponent, start=PowerSeries(self.ring, self.q, [self.ring.polynomial([self.ring.one]), *zeros]))

    @property
    def inverse(self) -> PowerSeries:
        """The reciprocal series; the first coefficient is not zero modulo q."""
        first = self.ring.inverse(self.coefficients[0], self.q)
        total = [first]
        for j in range(1, len(self.coefficients)):
            known = sum((self.coefficients[i] * total[j - i] for i in range(1, j + 1)), self.ring.polynomial([]))
            total.append(-known * first % self.q)
        return PowerSeries(self.ring, self.q, total)


def taylor(ring: PolynomialRing, e: Polynomial, q: Polynomial, length: int) -> PowerSeries:
    """e(x + h) at a zero x of an irreducible polynomial q."""
    c = ring.coefficients(e, e.degree() + 1) if e and length > 1 else []
    further = (ring.polynomial([c[n] * comb(n, j) for n in range(j, len(c))]) % q for j in range(1, length))
    return PowerSeries(ring, q, [e % q, *further])


def slopes(ring: PolynomialRing, q: Polynomial, length: int) -> PowerSeries:
    """q(x + h) / h at a zero x of an irreducible polynomial q: q'(x) + q''(x) h / 2 + ..."""
    return PowerSeries(ring, q, taylor(ring, q, q, length + 1).coefficients[1:])


def series_at_infinity(ring: PolynomialRing, numerator: Polynomial, denominator: Polynomial, highest: int) -> Iterator[Element]:
    """h_highest, h_(highest - 1), ... of numerator / denominator = sum of h_i s^i: d_n h_i = b_(n+i) - sum over j < n of d_j h_(n+i-j)."""
    n = denominator.degree()
    *lower, leading = ring.coefficients(denominator, n + 1)
    above = ring.coefficients(numerator, numerator.degree() + 1) if numerator else []
    known: deque = deque(maxlen=n)  # h_(i+n), ..., h_(i+1), as far as they are not zero by definition
    for i in count(highest, -1):
        total = above[n + i] if 0 <= n + i < len(above) else ring.zero
        for d, h in zip(reversed(lower), reversed(known)):
            if d and h:
                total = total - d * h
        h = total / leading
        known.append(h)
        yield h


# Jordan chains, and the blocks (C, J, B) of both pairs.


class _OfOneDivisor:
    """Part of A(s)^-1 that belongs to one elementary divisor, p^k with p monic: polynomial and length."""

    def __init__(self, term: RootPolynomials):
        self.term, self.length = term, term.length
        self.polynomial = term.ring.exported(term.divisor)

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.term.ring.text(self.term.divisor)}, length={self.length})"


class JordanChain(_OfOneDivisor):
    """A Jordan chain of A(s) for every zero z of an irreducible polynomial p at once.

    A(s) (v_0 + v_1 (s - z) + ... + v_(k-1) (s - z)^(k-1)) = O((s - z)^k), v_0 not zero (Moysis et al., Eqs. 19-20), and with the
    left chain A(s)^-1 = sum over i <= j of v_i b_j^T / (s - z)^(j - i + 1) + ...: the v_i are the columns of C and the b_j the rows
    of B at a Jordan block of size k. They are the same polynomials in z at all zeros of p.
    """

    @cached_property
    def right(self) -> tuple[tuple[Polynomial, ...], ...]:
        """v_0 ... v_(k-1), each r polynomials in the zero, of lower degree than p."""
        ring, p, k = self.term.ring, self.term.divisor, self.length
        return tuple(zip(*(taylor(ring, entry, p, k).coefficients for entry in self.term.right)))

    @cached_property
    def left(self) -> tuple[tuple[Polynomial, ...], ...]:
        """b_0 ... b_(k-1): b_(k-1-i) from psi(z + h) h^k / p(z + h)^k."""
        ring, p, k = self.term.ring, self.term.divisor, self.length
        weight = (slopes(ring, p, k) ** k).inverse
        return tuple(zip(*((taylor(ring, entry, p, k) * weight).coefficients for entry in self.term.left)))[::-1]

    @property
    def vectors(self) -> tuple[Matrix, ...]:
        """v_0 ... v_(k-1) as matrices of shape (r, deg p): column j multiplies z^j."""
        ring, d = self.term.ring, self.term.divisor.degree()
        return tuple(ring.matrix([ring.coefficients(entry, d) for entry in vector]) for vector in self.right)


class HypercompanionBlock(_OfOneDivisor):
    """The part C (s I - J)^-1 B = phi psi^T / p^k of A(s)^-1 that belongs to one elementary divisor p^k.

    J is the hypercompanion matrix of p^k (Jacobson): multiplication by s on K[s]/p^k with the basis p^i s^j. Where p = s - z it is
    the Jordan block, and the columns of C are the Jordan chain.
    """

    kind = "hypercompanion"
    zero = None

    @property
    def degree(self) -> int:
        return self.term.divisor.degree()

    @cached_property
    def C(self) -> Matrix:
        """Shape (r, k deg p): the digits of phi to the base p, each by its coefficients."""
        ring, p = self.term.ring, self.term.divisor
        return ring.matrix([digits(ring, entry, p, self.length) for entry in self.term.right])

    @cached_property
    def J(self) -> Matrix:
        """Shape (k deg p, k deg p)."""
        return hypercompanion(self.term.ring, self.term.divisor, self.length)

    @cached_property
    def B(self) -> Matrix:
        """Shape (k deg p, r): the coefficient of s^(-1-j) in psi / p^(k-i) at the basis element p^i s^j."""
        ring, p, d = self.term.ring, self.term.divisor, self.degree
        shift = ring.polynomial([ring.zero] * d + [ring.one])
        rows = []
        for i in range(self.length):
            modulus = p ** (self.length - i)
            columns = [ring.coefficients(entry % modulus * shift // modulus, d) for entry in self.term.left]
            rows += [[column[j] for column in columns] for j in reversed(range(d))]
        return ring.matrix(rows)


class NilpotentBlock:
    """The part C (I - s J)^-1 B of A(s)^-1 that an infinite elementary divisor adds (Moysis et al., Eqs. 23-24).

    With root polynomials at w = 1/s = 0 it is phi psi^T / w^(n-1) up to w^0, n the length.
    """

    kind = "nilpotent"

    def __init__(self, term: RootPolynomials, length: int):
        self.length, ring = length, term.ring
        self.C = ring.matrix([ring.coefficients(entry, length) for entry in term.right])
        self.J = hypercompanion(ring, term.divisor, length)
        self.B = ring.matrix(list(zip(*(ring.coefficients(entry, length)[::-1] for entry in term.left))))

    def __repr__(self) -> str:
        return f"NilpotentBlock(length={self.length})"


def digits(ring: PolynomialRing, entry: Polynomial, p: Polynomial, count: int) -> list[Element]:
    """The coefficients of the first digits of a polynomial to the base p, the lowest digit first."""
    row: list[Element] = []
    for _ in range(count):
        entry, digit = divmod(entry, p)
        row += ring.coefficients(digit, p.degree())
    return row


def hypercompanion(ring: PolynomialRing, p: Polynomial, exponent: int) -> Matrix:
    """Hypercompanion matrix of monic p, d = deg p: ones above the diagonal, coefficients of s^d - p(s) in every d-th row."""
    d = p.degree()
    lower = ring.coefficients(p, d)
    rows = [[ring.one if j == i + 1 else ring.zero for j in range(exponent * d)] for i in range(exponent * d)]
    for last in range(d - 1, exponent * d, d):
        for j in range(d):
            rows[last][last - d + 1 + j] = rows[last][last - d + 1 + j] - lower[j]
    return ring.matrix(rows)


class ExactPair:
    """C, J and B of several blocks: C side by side, J on the diagonal, B below each other, computed on demand.

    Attributes:
        blocks: each with C, J, B and the length of its chain.
    """

    def __init__(self, ring: PolynomialRing, size: int, blocks: Sequence):
        self.ring, self.size, self.blocks = ring, size, tuple(blocks)

    def __repr__(self) -> str:
        names = sorted({block.kind for block in self.blocks})
        return f"ExactPair(size={self.size}, {len(self.blocks)} blocks{': ' if names else ''}{', '.join(names)})"

    @property
    def lengths(self) -> tuple[int, ...]:
        return tuple(block.length for block in self.blocks)

    @cached_property
    def C(self) -> Matrix:
        """Shape (r, n)."""
        return self.ring.joined([self.ring.matrix([[]] * self.size), *(block.C for block in self.blocks)], 1)

    @cached_property
    def J(self) -> Matrix:
        """Shape (n, n)."""
        return self.ring.diagonal([self.ring.matrix([]), *(block.J for block in self.blocks)])

    @cached_property
    def B(self) -> Matrix:
        """Shape (n, r)."""
        return self.ring.joined([self.ring.matrix([[]] * self.size).T, *(block.B for block in self.blocks)], 0)


# The structure of A(s), both pairs and the Laurent coefficients.


@dataclass(frozen=True, repr=False)
class ElementaryDivisor:
    """The powers p^k of one irreducible polynomial p among the elementary divisors of A(s)."""

    ring: PolynomialRing = field(compare=False)
    divisor: Polynomial
    exponents: tuple[int, ...]  # the k > 0, ascending: the partial multiplicities of each of the zeros of p

    @property
    def polynomial(self) -> Any:
        """p, monic, irreducible over the field: Fractions, the lowest power first, or a Poly in s."""
        return self.ring.exported(self.divisor)

    def __repr__(self) -> str:
        return f"ElementaryDivisor({self.ring.text(self.divisor)}, exponents {self.exponents})"

    @property
    def degree(self) -> int:
        """The degree of p: the number of distinct zeros."""
        return self.divisor.degree()

    @property
    def multiplicity(self) -> int:
        """The multiplicity of p in det A(s)."""
        return sum(self.exponents)


@dataclass(frozen=True, repr=False, kw_only=True)
class ExactStructure(Structure):
    """Zeros of A(s), finite and infinite, and the polynomials of the finite ones; nothing is rounded.

    With symbols it holds for generic positive values of them. The finite zeros are those of ``polynomial.structure.FiniteZero``
    with the nearest float64 numbers, or ``SymbolicZero`` with expressions where zeros have a closed form.

    Of an A(s) that is not regular the exact sum of all indices proves that the vectors of both kernels have the least possible degrees.

    Attributes:
        determinant: det A(s), zero where A(s) is square and not regular; None where it is not square.
        elementary_divisors: by degree, then by coefficients.
        assumptions: expressions in the symbols that must not vanish: the leading coefficient of det A(s), pivots, differences of
            zeros. Expressions that have one sign for all positive symbols are left out.

    >>> import mbconstrained as mb
    >>> A = mb.PolynomialMatrix([[[0.5, 0], [0, 0.5]], [[0, 1], [0, 0]], [[1, 0], [0, 1]]])
    >>> structure = mb.exact.structure(A)
    >>> structure.elementary_divisors, structure.infinite_divisors
    ((ElementaryDivisor(s^2 + 0.5, exponents (2,)),), (0, 0))
    >>> [len(polynomial) - 1 for polynomial in structure.invariant_polynomials]
    [0, 4]
    """

    determinant: object = field(repr=False)
    elementary_divisors: tuple[ElementaryDivisor, ...]
    ring: PolynomialRing = field(repr=False, compare=False)
    assumptions: tuple = ()

    @property
    def invariant_polynomials(self) -> tuple:
        """f_1, ..., f_r of the Smith form, r the rank, monic; each divides the next (Moysis et al., Eq. 5)."""
        polynomials = [self.ring.polynomial([self.ring.one])] * self.rank
        for each in self.elementary_divisors:
            for place, exponent in enumerate(reversed(each.exponents), start=1):
                polynomials[-place] = polynomials[-place] * each.divisor**exponent
        return tuple(map(self.ring.exported, polynomials))

    @property
    def notices(self) -> tuple:
        """No notices: no decision is in doubt."""
        return ()


class ExactJordanPairs:
    """Finite and infinite Jordan pair of a regular A(s) without rounding errors, computed on demand.

    >>> import mbconstrained as mb
    >>> pairs = mb.exact.jordan_pairs(mb.PolynomialMatrix([[[1, 0], [0, 1]], [[2, 1], [0, 0]], [[1, 0], [0, 0]]]))
    >>> print(pairs.finite.J.astype(int).tolist(), pairs.finite.C.astype(int).tolist(), pairs.finite.B.astype(int).tolist())
    [[-1, 1], [0, -1]] [[1, 0], [0, 0]] [[0, -1], [1, 1]]
    >>> pairs.laurent(0).astype(int).tolist(), pairs.laurent(-1).astype(int).tolist()
    ([[0, 0], [0, 1]], [[0, -1], [0, 0]])
    """

    matrix: Any
    ring: Any

    def __init__(self, matrix: ExactMatrix):
        self.matrix, self.ring = matrix, matrix.ring
        self._local: dict[int, list[RootPolynomials]] = {}

    def __repr__(self) -> str:
        return f"{type(self).__name__}({self.matrix!r})"

    @cached_property
    def factors(self) -> list[tuple[Polynomial, int]]:
        """The monic irreducible factors of det A(s) with their multiplicities."""
        return self.ring.factors(self.matrix.determinant)

    def root_polynomials(self, place: int) -> list[RootPolynomials]:
        """Root polynomials at the zeros of one of the factors, of ascending lengths; computed once."""
        if place not in self._local:
            self._local[place] = self.matrix.root_polynomials(*self.factors[place])
        return self._local[place]

    @cached_property
    def infinity(self) -> list[RootPolynomials]:
        """The root polynomials at infinity: those of s^max(q, 1) A(1/s) at s = 0, ascending lengths."""
        return self.matrix.infinite_root_polynomials()

    @cached_property
    def structure(self) -> ExactStructure:
        """Zeros with their multiplicities, finite and infinite, elementary divisors, invariant polynomials."""
        A, ring = self.matrix, self.ring
        divisors = []
        for place, (p, multiplicity) in enumerate(self.factors):
            lengths = [1] if multiplicity == 1 else [term.length for term in self.root_polynomials(place)]
            divisors.append((p, multiplicity, tuple(lengths)))
        at_infinity = [term.length - max(A.degree, 1) + A.degree for term in self.infinity]
        return ExactStructure(
            shape=(A.size, A.size),
            degree=A.degree,
            finite_zeros=ring.finite_zeros(divisors),
            infinite_divisors=(*(0,) * (A.size - len(at_infinity)), *at_infinity),
            determinant=ring.exported(A.determinant),
            elementary_divisors=tuple(ElementaryDivisor(ring, p, exponents) for p, _, exponents in divisors),
            ring=ring,
            assumptions=self.structure_assumptions(),
        )

    def structure_assumptions(self) -> tuple:
        """Expressions that must not vanish for the structure to hold; none over the rationals."""
        return ()

    @property
    def terms(self) -> list[RootPolynomials]:
        """The root polynomials of all finite elementary divisors."""
        return [term for place in range(len(self.factors)) for term in self.root_polynomials(place)]

    @cached_property
    def chains(self) -> tuple[JordanChain, ...]:
        """The Jordan chains, one for each elementary divisor p^k, as polynomials in the zeros of p."""
        return tuple(map(self.ring.chain, self.terms))

    @cached_property
    def rational(self) -> ExactPair:
        """The finite pair with entries in the field: one hypercompanion block for each elementary divisor, by p and then by k.

        Over the rationals C, J and the chains take seconds where det A(s) has an irreducible factor of degree 160. The entries
        of B have 2 deg(p^k) times as many digits as the coefficients of det A(s): of float64 data they take seconds for a factor
        of degree 40, minutes for one of degree 80. With eleven symbols a factor of degree 6 takes minutes.
        """
        return ExactPair(self.ring, self.matrix.size, [HypercompanionBlock(term) for term in self.terms])

    @property
    def finite(self) -> ExactPair:
        """(C, J, B): the strictly proper part of A(s)^-1 is C (s I - J)^-1 B (Moysis et al., Theorem 2.8)."""
        return self.rational

    @cached_property
    def infinite(self) -> ExactPair:
        """(C, J, B): the polynomial part of A(s)^-1 is C (I - s J)^-1 B, of the minimal size (Theorem 2.8, sizes corrected).

        J has a nilpotent Jordan block of size |q_i| + 1 for every q_i <= 0 (Eqs. 23-24, corrected), the smallest first.
        """
        least = max(self.matrix.degree, 1)
        terms = [term for term in self.infinity if term.length >= least]
        return ExactPair(self.ring, self.matrix.size, [NilpotentBlock(term, term.length - least + 1) for term in terms])

    @cached_property
    def laurent(self) -> Laurent:
        """laurent(i) is H_i of A(s)^-1 = sum over i of H_i s^i near infinity (Eqs. 18, 27), shape (r, r), for every whole i."""
        return Laurent(self.matrix)


class Laurent:
    """A(s)^-1 = adj A / det A = sum over i <= highest of H_i s^i near infinity (Moysis et al., Eq. 18), by long division.

    Coefficients are computed from the highest down and kept.
    """

    def __init__(self, matrix: ExactMatrix):
        self.ring, self.size, below = matrix.ring, matrix.size, matrix.determinant
        entries = [entry for row in matrix.adjugate for entry in row]
        self.highest = max((entry.degree() for entry in entries if entry), default=0) - below.degree()
        self._series = [series_at_infinity(self.ring, entry, below, self.highest) for entry in entries]
        self._known: list[list[list[Element]]] = []

    def __repr__(self) -> str:
        return f"Laurent(size={self.size}, highest={self.highest})"

    def __call__(self, index: int) -> Matrix:
        """H_i, shape (r, r).

        Raises:
            InputError: the index is not a whole number.
        """
        if isinstance(index, bool) or not isinstance(index, numbers.Integral):
            raise InputError(f"index: found {index!r}; expected a whole number")
        return self.ring.matrix(self.elements(int(index)))

    def elements(self, index: int) -> list[list[Element]]:
        """The rows of H_i, elements of the field."""
        r = self.size
        if index > self.highest:
            return [[self.ring.zero] * r for _ in range(r)]
        while len(self._known) <= self.highest - index:
            entries = [next(each) for each in self._series]
            self._known.append([entries[i : i + r] for i in range(0, r * r, r)])
        return self._known[self.highest - index]
