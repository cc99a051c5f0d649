"""The structure of A(s): zeros with multiplicities, finite and at infinity, and the kernels of an A(s) that is not regular."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from ..ground.checks import counted, listed
from ..ground.display import Displayed, TextTable, signed, table_text, wrapped
from ..ground.notices import Evidence, Notice, NoticeKind
from ..ground.tolerances import EPS, NOISE_SAFETY
from ..linalg.staircase import GENERIC
from .coefficients import PolynomialCoefficients
from .decoupling import scaled_companion


@dataclass(frozen=True)
class FiniteZero:
    """A zero of A(s), that is a root of det A(s).

    Attributes:
        value: the zero in 1/s; of a complex pair the one above the real axis stands for both.
        multiplicity: its multiplicity as a root of det A(s) (that of each of the two, for a pair).
        partial_multiplicities: the degrees of its elementary divisors (s - value)^k, ascending; they add up to the
            multiplicity. Two uncoupled oscillators that are alike have (1, 1), critical damping has (2,).
        clear: False where rounding leaves the multiplicities in doubt.
    """

    value: complex
    multiplicity: int
    partial_multiplicities: tuple[int, ...] = field(default=(), compare=False)
    clear: bool = field(default=True, compare=False)

    @property
    def count(self) -> int:
        """Number of roots of det A(s) for this entry."""
        return self.multiplicity * (2 if self.value.imag else 1)


@dataclass(frozen=True, repr=False)
class PolynomialVector(Displayed):
    """A vector v(s) = v_0 + v_1 s + ... + v_d s^d of a minimal basis of the right or of the left kernel of A(s).

    Of the right kernel, A(s) v(s) = 0: with any function z(t), x = v(d/dt) z is a motion that no force determines. Of the left kernel,
    v(s)^T A(s) = 0: the equations A(d/dt) x = f have a solution only where v(d/dt)^T f = 0. The first polynomial that is not zero has
    the leading coefficient 1.

    Attributes:
        names: of the coordinates (right kernel) or of the equations (left kernel).
        polynomials: the coefficients of each entry in ascending powers, without zeros at the end; () for an entry 0.
        residual: the largest coefficient of A(s) v(s), or of v(s)^T A(s), relative to the terms that it is the sum of; 0 where it is
            exactly zero.

    >>> from mbconstrained import PolynomialMatrix
    >>> A = PolynomialMatrix([[[4.0, -1.0]], [[0.0, 0.0]], [[2.0, 0.0]]], coordinates=["cart", "force"])  # 2 x'' + 4 x = force
    >>> (v,) = A.structure().right_kernel
    >>> v, v.degree, v(1.0).tolist()
    (PolynomialVector(cart: 1, force: 2 s^2 + 4), 2, [1.0, 6.0])
    """

    names: tuple[str, ...]
    polynomials: tuple[tuple, ...]
    residual: float = field(default=0.0, compare=False)

    @classmethod
    def of(cls, coefficients: np.ndarray, names: Sequence[str], residual: float = 0.0) -> PolynomialVector:
        """The vector with these coefficients, divided by the leading one of its first entry.

        Args:
            coefficients: v_0 ... v_d, shape (d + 1, n), floats or Fractions.
            names: of the n entries.
            residual: as the attribute.

        Returns:
            A ``PolynomialVector``.
        """
        polynomials = [tuple(column[: 1 + max(np.flatnonzero(column), default=-1)].tolist()) for column in coefficients.T]
        leading = next(polynomial[-1] for polynomial in polynomials if polynomial)
        return cls(tuple(names), tuple(tuple((c / leading + 0) for c in polynomial) for polynomial in polynomials), residual)

    @property
    def degree(self) -> int:
        """The highest power of s, a minimal index of A(s)."""
        return max(map(len, self.polynomials)) - 1

    @property
    def coefficients(self) -> np.ndarray:
        """v_0 ... v_d, shape (d + 1, n), floats or Fractions."""
        return np.array([[p[k] if k < len(p) else 0 * self.one for p in self.polynomials] for k in range(self.degree + 1)])

    @property
    def one(self):
        """The number 1 of the arithmetic of the coefficients."""
        return next(p[-1] for p in self.polynomials if p)

    @property
    def entries(self) -> tuple[str, ...]:
        """The entries that are not zero with their names, as texts with six digits."""
        return tuple(f"{name}: {polynomial_text(p)}" for name, p in zip(self.names, self.polynomials) if p)

    def __call__(self, s: complex) -> np.ndarray:
        """v(s), shape (n,)."""
        return np.polynomial.polynomial.polyval(s, self.coefficients.astype(float))

    def _summary(self) -> str:
        return listed(self.entries, 4)


@dataclass(frozen=True, repr=False)
class Structure(Displayed):
    """Zeros of A(s), finite and infinite (Moysis et al., Eqs. 5-15, with u counting q_i > 0 only), and its kernels.

    The kernels of a regular A(s) are empty. Their degrees, the minimal indices, and the degrees of all finite and infinite
    elementary divisors add up to rank times degree (De Teran, Dopico and Van Dooren 2015): see ``evidence``.

    Attributes:
        shape, degree: numbers of equations and of coordinates (m, n), and the declared q.
        finite_zeros: the zeros with multiplicities, ascending by modulus; where moduli agree to rounding, by the real
            part, then by the imaginary part.
        infinite_divisors: degrees mu_1 <= ... <= mu_r of the infinite elementary divisors (zeros included), r the rank.
        right_kernel: a minimal basis of the v(s) with A(s) v(s) = 0, ascending degrees: motions that no force determines.
        left_kernel: a minimal basis of the w(s) with w(s)^T A(s) = 0, ascending degrees: combinations of equations in which no
            coordinate is left.
        doubts: notices on rank decisions that are not clear.

    >>> from mbconstrained import PolynomialMatrix
    >>> found = PolynomialMatrix([[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]], [[0.0, -1.0, 0.0], [0.0, -2.0, 0.0]]]).structure()
    >>> found.rank, found.right_minimal_indices, found.left_minimal_indices
    (1, (0, 1), (0,))
    >>> found.right_kernel, found.free_coordinates, found.redundant_equations
    ((PolynomialVector(x3: 1), PolynomialVector(x1: s, x2: 1)), ('x2', 'x3'), ('equation 1',))
    """

    shape: tuple[int, int]
    degree: int
    finite_zeros: tuple[FiniteZero, ...]
    infinite_divisors: tuple[int, ...]
    right_kernel: tuple[PolynomialVector, ...] = ()
    left_kernel: tuple[PolynomialVector, ...] = ()
    doubts: tuple[Notice, ...] = field(default=(), compare=False)

    def _summary(self) -> str:
        m, n = self.shape
        infinite = [degree for degree in self.infinite_divisors if degree]
        at_infinity = f", infinite elementary divisors of degrees {', '.join(map(str, infinite))}" if infinite else ""
        size = f"size {n}" if m == n else f"{counted(m, 'equation')}, {counted(n, 'coordinate')}"
        kernels = [
            f", {side} minimal indices {', '.join(map(str, indices))}"
            for side, indices in (("right", self.right_minimal_indices), ("left", self.left_minimal_indices))
            if indices
        ]
        rank = f", rank {self.rank}" * any(kernels)
        return f"{size}, degree {self.degree}{rank}, {counted(self.finite_count, 'finite zero')}{at_infinity}{''.join(kernels)}"

    def _tables(self) -> tuple[TextTable, ...]:
        rows = ((str(zero.value), str(zero.multiplicity), str(zero.partial_multiplicities)) for zero in self.finite_zeros)
        zeros = TextTable("Finite zeros", ("zero (1/s)", "multiplicity", "partial multiplicities"), tuple(rows))
        kernels = (
            ("Motions that no force determines: x = v(d/dt) z(t), z any function", self.right_kernel),
            ("Equations that depend on each other: w(d/dt)^T f = 0", self.left_kernel),
        )
        return zeros, *(
            TextTable(title, ("degree", "vector"), tuple((str(vector.degree), ", ".join(vector.entries)) for vector in vectors))
            for title, vectors in kernels
            if vectors
        )

    def summary(self) -> str:
        """Sizes, zeros, kernels, evidence and notices as text of at most 80 columns."""
        evidence = TextTable(
            "Evidence", ("quantity", "value", "meaning"), tuple((e.name, f"{e.value:.2g}", e.text) for e in self.evidence)
        )
        tables = [table for table in (*self._tables(), evidence) if table.rows]
        return "\n".join([wrapped(self._summary()), *map(table_text, tables), *(wrapped(str(notice)) for notice in self.notices)])

    @property
    def size(self) -> int:
        """The number of equations, and of coordinates, where these are as many; else that of coordinates."""
        return self.shape[1]

    @property
    def rank(self) -> int:
        """The rank of A(s) at all s but its zeros."""
        return self.shape[1] - len(self.right_kernel)

    @property
    def is_regular(self) -> bool:
        """True with as many equations as coordinates, and no kernels."""
        return self.rank == self.shape[0] == self.shape[1]

    @property
    def right_minimal_indices(self) -> tuple[int, ...]:
        """The degrees of the right kernel, ascending."""
        return tuple(vector.degree for vector in self.right_kernel)

    @property
    def left_minimal_indices(self) -> tuple[int, ...]:
        """The degrees of the left kernel, ascending."""
        return tuple(vector.degree for vector in self.left_kernel)

    @cached_property
    def free_coordinates(self) -> tuple[str, ...]:
        """Names of coordinates whose motion may be any function; the others follow, with values at 0- where differential equations are left.

        One choice of several in general: first those through which the motions of the right kernel are expressed with fewest derivatives.
        """
        return _chosen(self.right_kernel)

    @cached_property
    def redundant_equations(self) -> tuple[str, ...]:
        """Names of equations that follow from the others, or contradict them, and may be left out; one choice of several in general."""
        return _chosen(self.left_kernel)

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """The theorem of the sum of indices, and the residual of the kernels."""
        excess = sum(zero.count for zero in self.finite_zeros) - self.finite_count
        kernels = (*self.right_kernel, *self.left_kernel)
        residual = max((vector.residual for vector in kernels), default=0.0)
        return (
            Evidence(
                "index sum", excess, "degrees of elementary divisors and minimal indices, less rank times degree: 0 by theorem"
            ),
            *(
                [Evidence("kernel", residual, "largest residual of the vectors of the kernels, relative to its terms")]
                if kernels
                else []
            ),
        )

    @property
    def finite_count(self) -> int:
        """n = deg det A(s) of a regular A(s), of others the degree of the product of the invariant polynomials."""
        minimal = sum(self.right_minimal_indices) + sum(self.left_minimal_indices)
        return self.rank * self.degree - sum(self.infinite_divisors) - minimal

    @property
    def at_infinity(self) -> tuple[int, ...]:
        """q_1 >= ... >= q_r of the Smith form at infinity diag(s^q_i); a negative q_i is an infinite zero (Eq. 14)."""
        return tuple(self.degree - degree for degree in self.infinite_divisors)

    @property
    def highest_impulse(self) -> int:
        """q_hat_r, the highest order of an infinite zero (0 when there is none): impulses have lower orders."""
        return max([0, *(-order for order in self.at_infinity)])

    @property
    def infinite_chains(self) -> tuple[int, ...]:
        """Chain lengths of the minimal infinite pair: |q_i| + 1 for every q_i <= 0 (Eqs. 23-24, corrected)."""
        return tuple(1 - order for order in self.at_infinity if order <= 0)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on ranks, and on zeros whose multiplicities, are uncertain by rounding errors."""
        return self.doubts + tuple(
            Notice(
                NoticeKind.RANK,
                f"zero {zero.value:.6g}: taken as one zero with the partial multiplicities {zero.partial_multiplicities}, but "
                "rounding of the data could make it simpler, or split it",
                doubtful=True,
            )
            for zero in self.finite_zeros
            if not zero.clear
        )


def _chosen(vectors: Sequence[PolynomialVector]) -> tuple[str, ...]:
    """Names of as many entries as there are vectors, at which the vectors are independent; low degrees are preferred."""
    if not vectors:
        return ()
    lengths = [max(map(len, entries)) for entries in zip(*(vector.polynomials for vector in vectors))]
    values = np.array([vector(GENERIC[0]) for vector in vectors])
    basis: list[np.ndarray] = []
    chosen = []
    for place in sorted(np.flatnonzero(lengths), key=lambda place: lengths[place]):
        rest = own = values[:, place] / np.linalg.norm(values[:, place])
        for vector in basis:
            rest = rest - vector * (vector.conj() @ own)
        if (length := np.linalg.norm(rest)) > EPS**0.5 and len(basis) < len(vectors):
            basis.append(rest / length)
            chosen.append(place)
    return tuple(vectors[0].names[place] for place in sorted(chosen))


# Which equations and coordinates make a polynomial matrix singular.


def singular_message(A: PolynomialCoefficients) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
    """A sentence on why det A(s) = 0 for every s, with the indices of the equations and coordinates involved."""
    scaled = scaled_companion(A).coefficients
    involved_rows, involved_columns = np.zeros(A.size, bool), np.zeros(A.size, bool)
    for s in GENERIC:
        value = sum(matrix * s**power for power, matrix in enumerate(scaled))
        u, sizes, vh = np.linalg.svd(value)
        null = sizes <= NOISE_SAFETY * EPS * A.size * max(sizes[0], EPS)
        null[-1] = True  # singular at every s: the least one belongs to it
        involved_rows |= _support(u[:, null])
        involved_columns |= _support(vh[null].conj().T)
    equations, coordinates = (tuple(map(int, np.flatnonzero(side))) for side in (involved_rows, involved_columns))
    return singular_sentence([A.equations[i] for i in equations], [A.coordinates[i] for i in coordinates]), equations, coordinates


def singular_sentence(equations: Sequence[str], coordinates: Sequence[str]) -> str:
    """Text on dependent equations and free coordinates, with a remedy."""
    rows, columns = (", ".join(f'"{name}"' for name in names) for names in (equations, coordinates))
    return (
        f"det A(s) is zero for every s, the motion is not determined: the equations {rows} are dependent or empty, "
        f"and the coordinates {columns} can move without any force. Attach what is free (by a mass, spring, damper or "
        "constraint; in a state space by an equation), or remove redundant equations."
    )


def _support(vectors) -> np.ndarray:
    size = np.abs(vectors).max(axis=1, initial=0.0)
    return size > EPS**0.5 * size.max(initial=0.0)


def polynomial_text(coefficients: Sequence) -> str:
    """A polynomial in s as text, with six digits."""
    text = ""
    for power, c in reversed(list(enumerate(coefficients))):
        if c:
            size = f"{float(abs(c)):.6g}"
            size = "" if size == "1" and power else size
            variable = "s" * (power > 0) + f"^{power}" * (power > 1)
            text += signed(c, size, variable, bool(text))
    return text or "0"
