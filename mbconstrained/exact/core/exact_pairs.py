"""The structure of A(s), both Jordan pairs and the Laurent coefficients of A(s)^-1, over any field."""

from __future__ import annotations

import numbers
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

from ...ground.errors import InputError
from ...polynomial.structure import Structure
from .jordan_blocks import ExactPair, HypercompanionBlock, JordanChain, NilpotentBlock, RootPolynomials
from .ring import Element, Matrix, Polynomial, PolynomialRing, series_at_infinity


class ExactMatrix(Protocol):
    """A regular A(s) over a field, with its determinant, adjugate and root polynomials."""

    @property
    def ring(self) -> Any: ...

    @property
    def size(self) -> int: ...

    @property
    def degree(self) -> int: ...

    @property
    def determinant(self) -> Polynomial: ...

    @property
    def adjugate(self) -> Sequence[Sequence[Polynomial]]: ...

    def root_polynomials(self, factor: tuple[Any, int]) -> list[RootPolynomials]: ...

    def infinite_root_polynomials(self) -> list[RootPolynomials]: ...


@dataclass(frozen=True, repr=False)
class ElementaryDivisor:
    """The powers p^k of one irreducible polynomial p among the elementary divisors of A(s).

    Attributes:
        polynomial: p, monic, irreducible over the field: Fractions, the lowest power first, or a Poly in s.
        exponents: the k > 0, ascending: the partial multiplicities of each of the zeros of p.
    """

    polynomial: object
    exponents: tuple[int, ...]
    ring: PolynomialRing = field(compare=False)
    divisor: Polynomial = field(compare=False)

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


@dataclass(frozen=True, repr=False)
class ExactStructure(Structure):
    """Zeros of A(s), finite and infinite, and the polynomials of the finite ones; nothing is rounded.

    With symbols it holds for generic positive values of them. The finite zeros are those of ``polynomial.structure.FiniteZero``
    with the nearest float64 numbers, or ``SymbolicZero`` with expressions where zeros have a closed form.

    Attributes:
        determinant: det A(s).
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
        """f_1, ..., f_r of the Smith form, monic; each divides the next (Moysis et al., Eq. 5)."""
        polynomials = [self.ring.polynomial([self.ring.one])] * self.size
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

    Args:
        matrix: A(s) with its determinant, adjugate and root polynomials.

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
            self._local[place] = self.matrix.root_polynomials(self.factors[place])
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
            size=A.size,
            degree=A.degree,
            finite_zeros=ring.finite_zeros(divisors),
            infinite_divisors=(*(0,) * (A.size - len(at_infinity)), *at_infinity),
            determinant=ring.exported(A.determinant),
            elementary_divisors=tuple(ElementaryDivisor(ring.exported(p), exponents, ring, p) for p, _, exponents in divisors),
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
