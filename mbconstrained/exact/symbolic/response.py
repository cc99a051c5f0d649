"""The motion of A(d/dt) x = f with symbols in A, in the values at 0- and in the force, in closed form."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import sympy

from ...checks import whole_number
from ...errors import InputError
from .conditions import continuity_equations, impulse_equations
from .fields import exact_expression
from .matrix import SymbolicPolynomialMatrix
from .principal_parts import delta
from .solution import Solution, assumptions_of, solution_of
from .sources import Source, field_with, force_sources, initial_sources, initial_symbols

#: The time, where the user names none.
TIME = sympy.Symbol("t", real=True)


@dataclass(frozen=True)
class SymbolicResponse:
    """x(t), t > 0, and its impulses, as expressions.

    Attributes:
        regular: x(t) for t > 0, without impulses, a matrix (r, 1); what starts later is in it with Heaviside(t - t0).
        impulses: matrices (r, 1), the k-th multiplies the k-th derivative of Dirac's delta at 0.
        later_impulses: (t0, matrices (r, 1)) for each later time at which the force makes impulses.
        start: x^(i)(0+) as row i, shape (q, r).
        initial: the values at 0-, shape (q, r).
        force: f as a matrix (r, 1).
        time: the symbol t.
        assumptions: expressions that are taken as not zero: where one vanishes, two zeros meet (resonance is one case), and x(t) is
            the limit of the expression; where the leading coefficient of det A vanishes, A has another structure.
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
            Heaviside(t - t0) and DiracDelta(t - t0, k), with symbols as rates, frequencies, phases and times; None for zeros.
        time: its symbol; None for the one called t in the force, or a real one.

    Raises:
        InputError: shapes; a force of other functions; det A has a factor without roots in closed form.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> m, k, x0, v0 = sympy.symbols("m k x0 v0", positive=True)
    >>> x = solve_symbolically(SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]), [[x0], [v0]])
    >>> x.regular[0]
    x0*cos(sqrt(k)*t/sqrt(m)) + sqrt(m)*v0*sin(sqrt(k)*t/sqrt(m))/sqrt(k)
    """
    if not isinstance(A, SymbolicPolynomialMatrix):
        raise InputError(f"A: found an object of type {type(A).__name__}; expected a SymbolicPolynomialMatrix (or its .of(A))")
    X0, f = checked_initial(A, initial), _force(A, force)
    time = _time(A, X0, f, time)
    sources = initial_sources(A, X0) + force_sources(A, f, time)
    K = field_with(A, sources)
    parts: dict[sympy.Expr, list[Source]] = {sympy.S.Zero: []}
    for source in sources:
        parts.setdefault(source.start, []).append(source)
    solutions = {start: solution_of(A, group, K, time) for start, group in parts.items()}
    now = solutions.pop(sympy.S.Zero)
    return SymbolicResponse(
        polynomial_matrix=A,
        initial=X0,
        force=f,
        time=time,
        regular=_added(now, solutions, time),
        impulses=now.impulses,
        later_impulses=tuple((t0, solution.impulses) for t0, solution in solutions.items() if solution.impulses),
        start=now.start,
        assumptions=assumptions_of(A, sources, K),
        force_sources=tuple(force_sources(A, f, time)),
    )


def checked_initial(A, initial) -> sympy.ImmutableMatrix:
    """The values at 0- as exact expressions, shape (q, r)."""
    if isinstance(initial, str):
        if initial != "symbols":
            raise InputError(f'initial: found {initial!r}; expected rows of values, "symbols" or None')
        return initial_symbols(A)
    if initial is None:
        return sympy.zeros(A.degree, A.size).as_immutable()
    rows = _listed(initial, "initial")
    if len(rows) != A.degree or any(len(_listed(row, "initial")) != A.size for row in rows):
        raise InputError(f"initial: expected {A.degree} rows of {A.size} values, row i the i-th derivatives at 0-")
    return sympy.Matrix(A.degree, A.size, [exact_expression(value, "initial") for row in rows for value in row]).as_immutable()


def _force(A, force) -> sympy.ImmutableMatrix:
    """The force as exact expressions, shape (r, 1)."""
    if force is None:
        return sympy.zeros(A.size, 1).as_immutable()
    rows = [row[0] if isinstance(row, list) and len(row) == 1 else row for row in _listed(force, "force")]
    if len(rows) != A.size:
        raise InputError(f"force: found {len(rows)} entries; expected {A.size}, one expression in the time for each equation")
    return sympy.Matrix([exact_expression(value, "force") for value in rows]).as_immutable()


def _listed(value, what) -> list:
    found = value.tolist() if hasattr(value, "tolist") else value
    if isinstance(found, str) or not isinstance(found, Sequence):
        raise InputError(f"{what}: found {value!r}; expected a list or a matrix")
    return list(found)


def _time(A, initial, force, time) -> sympy.Symbol:
    """The symbol of the time, which nothing but the force may have."""
    if time is None:
        found = [symbol for symbol in force.free_symbols if symbol.name == TIME.name]
        time = found[0] if found else TIME
    if not isinstance(time, sympy.Symbol):
        raise InputError(f"time: found {time!r}; expected a sympy.Symbol")
    others = {*A.symbols, *initial.free_symbols}
    if time.name in {symbol.name for symbol in others}:
        raise InputError(f"time: the symbol {time} is also one of A or of the values at 0-; name the time otherwise")
    _check_names(A, [*others, *force.free_symbols, time])
    return time


def _check_names(A, symbols) -> None:
    """One symbol for each name, and none that is called like the variable of A(s)."""
    names: dict[str, sympy.Symbol] = {}
    for symbol in symbols:
        if symbol.name == A.variable.name:
            raise InputError(f'the symbol "{symbol}" is the variable of A(s); name parameters of values and forces otherwise')
        if names.setdefault(symbol.name, symbol) != symbol:
            raise InputError(
                f'found two symbols "{symbol}" of different assumptions; use the same one in A, values, force and time'
            )


def _added(now: Solution, later: dict[sympy.Expr, Solution], time) -> sympy.ImmutableMatrix:
    """The regular parts, those that start later moved to their start."""
    total = sympy.Matrix(now.regular)
    for t0, solution in later.items():
        total += solution.regular.xreplace({time: time - t0}) * sympy.Heaviside(time - t0)
    return total.as_immutable()
