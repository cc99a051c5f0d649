"""The motion of A(d/dt) x = f with symbols in A, in the values at 0- and in the force, in closed form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import sympy

from ....checks import whole_number
from ....errors import InputError
from ..algebra.matrix import SymbolicPolynomialMatrix, checked_matrix
from ..field.fields import exact_expression, generators_of
from ..field.names import as_positive
from .conditions import continuity_equations, impulse_equations
from .given import checked_force, checked_initial, time_of
from .principal_parts import delta
from .solution import Solution, assumptions_of, divisors_of, solution_of
from .sources import Source, entries_with, field_with, force_sources, initial_sources


@dataclass(frozen=True)
class SymbolicResponse:
    """x(t), t > 0, and its impulses, as expressions.

    Where the sign of a discriminant such as 4 k m - c^2 is open, cos(w t) and sin(w t)/w hold for both, but w may be the root of
    a negative number (a function that ``sympy.lambdify`` makes of it needs complex numbers then: c=10+0j), and w = 0 is a limit
    that putting in values gives as nan. ``at`` puts in values by solving again.

    Attributes:
        regular: x(t) for t > 0, without impulses, a matrix (r, 1); what starts later is in it with Heaviside(t - t0).
        impulses: matrices (r, 1), the k-th multiplies the k-th derivative of Dirac's delta at 0.
        later_impulses: (t0, matrices (r, 1)) for each later time at which the force makes impulses.
        start: x^(i)(0+) as row i, shape (q, r).
        initial: the values at 0-, shape (q, r).
        force: f as a matrix (r, 1).
        time: the symbol t.
        assumptions: expressions that are taken as not zero: where one vanishes, two zeros meet (resonance is one case), and x(t) is
            the limit of the expression; where the leading coefficient of det A vanishes, A has another structure. With what
            the given expressions are divided by, and with start times of which it is not declared that they are positive.
        polynomial_matrix: A(s).
    """

    polynomial_matrix: SymbolicPolynomialMatrix
    initial: sympy.ImmutableMatrix
    force: sympy.ImmutableMatrix
    time: sympy.Symbol
    regular: sympy.ImmutableMatrix
    impulses: tuple[sympy.ImmutableMatrix, ...]
    later_impulses: tuple[tuple[sympy.Expr, tuple[sympy.ImmutableMatrix, ...]], ...]
    start: sympy.ImmutableMatrix
    assumptions: tuple[sympy.Expr, ...]
    force_sources: tuple[Source, ...] = field(repr=False)

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the coordinates."""
        return tuple(self.polynomial_matrix.coordinates)

    @cached_property
    def expression(self) -> sympy.ImmutableMatrix:
        """x with its impulses as DiracDelta terms, a matrix (r, 1)."""
        total = sympy.Matrix(self.regular)
        for t0, impulses in ((sympy.S.Zero, self.impulses), *self.later_impulses):
            for k, impulse in enumerate(impulses):
                total += impulse * delta(self.time - t0, k)
        return total.as_immutable()

    @property
    def jump(self) -> sympy.ImmutableMatrix:
        """x^(i)(0+) - x^(i)(0-), shape (q, r)."""
        return (self.start - self.initial).applyfunc(sympy.expand).as_immutable()

    def derivative(self, order: int = 1) -> sympy.ImmutableMatrix:
        """The derivative of x for t > 0 (away from later steps), a matrix (r, 1)."""
        order = whole_number(order, "order", minimum=0)
        return self.regular.diff(self.time, order).replace(sympy.DiracDelta, lambda *_: sympy.S.Zero) if order else self.regular

    def at(self, values: Mapping[sympy.Symbol, object]) -> SymbolicResponse:
        """The response for values of some of the symbols, or of all: they are put into A, start and force, which are solved again.

        So it holds where zeros meet (the critical damping, resonance) and where A has another structure, too.

        Args:
            values: numbers of any sign, or expressions, by symbol.

        Raises:
            InputError: a key is none of the symbols, a value no number, or an entry infinite for it; as ``solve_symbolically``.
            SingularPolynomialMatrix: det A(s) = 0 for every s with these values.

        >>> m, c, k = sympy.symbols("m c k", positive=True)
        >>> x = solve_symbolically(SymbolicPolynomialMatrix([[[k]], [[c]], [[m]]]), [[1], [0]])
        >>> x.at({m: 1, c: 2, k: 1}).regular
        Matrix([[t*exp(-t) + exp(-t)]])
        """
        A = self.polynomial_matrix
        known = {*A.symbols, *self.initial.free_symbols, *self.force.free_symbols} - {self.time}
        if not isinstance(values, Mapping) or not set(values) <= known:
            names = ", ".join(sorted(symbol.name for symbol in known))
            raise InputError(f"values: found {values!r}; expected a dictionary with values by symbol, of {names or 'none here'}")
        put = {symbol: exact_expression(value, str(symbol)) for symbol, value in values.items()}
        matrices = [matrix.xreplace(put) for matrix in A.coefficients]
        changed = SymbolicPolynomialMatrix(matrices, A.coordinates, A.equations)
        return solve_symbolically(changed, self.initial.xreplace(put), self.force.xreplace(put), self.time)

    @cached_property
    def admissible_conditions(self) -> tuple[sympy.Eq, ...]:
        """Equations in ``initial_symbols(A)`` that hold where there are no impulses at 0 (Moysis et al., Eq. 58, with f^(j)(0+))."""
        return impulse_equations(self.polynomial_matrix, self.force_sources)

    @cached_property
    def continuity_conditions(self) -> tuple[sympy.Eq, ...]:
        """Equations in ``initial_symbols(A)`` that hold where x, ..., x^(q-1) are continuous at 0 (Eq. 60, corrected)."""
        return continuity_equations(self.polynomial_matrix, self.force_sources)


def solve_symbolically(
    A: SymbolicPolynomialMatrix, initial=None, force: Sequence | None = None, time: sympy.Symbol | None = None
) -> SymbolicResponse:
    """The response X(s) = A(s)^-1 (X_in(s) + F(s)) in closed form (Moysis et al., Eqs. 46-48; one-sided from 0-).

    The exact principal part of X at every root of det A and of the force's denominators, transformed back term by term, gives
    the regular part; the Laurent coefficients of X at infinity give impulses and values at 0+. Nothing is a limit, and nothing
    is simplified by trial. Symbols are positive and generic (``assumptions`` of the result); where the sign of a discriminant
    such as c^2 - 4 k m is not decided by that, the oscillating form is given: it holds for both signs, and for 0 as a limit.

    Args:
        A: degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r), expressions or numbers; "symbols" for ``initial_symbols(A)``; None for zeros.
        force: r expressions in the time: sums and products of constants, t^k, exp, cos, sin, cosh, sinh,
            Heaviside(t - t0) and DiracDelta(t - t0, k), with symbols as rates, frequencies, phases and times, all taken as
            positive; None for zeros.
        time: its symbol; None for the one called t in the force, or a real one.

    Raises:
        InputError: shapes; a force of other functions, or of functions without the time; a parameter called like the time or
            like a value at 0- (x1_0); det A has a factor without roots in closed form.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> m, k, x0, v0 = sympy.symbols("m k x0 v0", positive=True)
    >>> x = solve_symbolically(SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]), [[x0], [v0]])
    >>> x.regular[0]
    x0*cos(sqrt(k)*t/sqrt(m)) + sqrt(m)*v0*sin(sqrt(k)*t/sqrt(m))/sqrt(k)
    """
    X0, f = checked_initial(checked_matrix(A), initial), checked_force(A, force)
    time = time_of(A, X0, f, time)
    sources = tuple(force_sources(A, f, time))
    names = as_positive(generators_of(entries_with(A, sources)))
    found = _found(A.with_positive_symbols, X0.xreplace(names), f.xreplace(names), time)
    own = {positive: symbol for symbol, positive in names.items()}
    later = [start for start in {source.start for source in sources} if not (start.is_positive or start == 0)]
    return SymbolicResponse(
        polynomial_matrix=A,
        initial=X0,
        force=f,
        time=time,
        force_sources=sources,
        assumptions=(*(each.xreplace(own) for each in found.pop("assumptions")), *later),
        **{name: _renamed(value, own) for name, value in found.items()},
    )


def _found(A, X0, f, time) -> dict[str, object]:
    """What the response consists of; roots of symbols are written short only where these are declared to be positive."""
    sources = initial_sources(A, X0) + force_sources(A, f, time)
    K = field_with(A, sources)
    parts: dict[sympy.Expr, list[Source]] = {sympy.S.Zero: []}
    for source in sources:
        parts.setdefault(source.start, []).append(source)
    solutions = {start: solution_of(A, group, K, time) for start, group in parts.items()}
    now = solutions.pop(sympy.S.Zero)
    divisors = divisors_of([*X0, *f, *(entry for matrix in A.coefficients for entry in matrix)], time)
    return {
        "regular": _added(now, solutions, time),
        "impulses": now.impulses,
        "later_impulses": tuple((t0, solution.impulses) for t0, solution in solutions.items() if solution.impulses),
        "start": now.start,
        "assumptions": assumptions_of(A, sources, K, divisors),
    }


def _renamed(value, names: Mapping):
    """Matrices in tuples with other symbols."""
    return tuple(_renamed(each, names) for each in value) if isinstance(value, tuple) else value.xreplace(names)


def _added(now: Solution, later: dict[sympy.Expr, Solution], time) -> sympy.ImmutableMatrix:
    """The regular parts, those that start later moved to their start."""
    total = sympy.Matrix(now.regular)
    for t0, solution in later.items():
        total += solution.regular.xreplace({time: time - t0}) * sympy.Heaviside(time - t0)
    return total.as_immutable()
