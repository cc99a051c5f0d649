"""The motion of A(d/dt) x = f with symbols in A, in the values at 0- and in the force, in closed form."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import sympy
from sympy.polys.matrices import DomainMatrix

from ...ground.checks import counted, whole_number
from ...ground.display import Displayed
from ...ground.errors import InputError
from .fields import TIME, as_positive, check_one_each, check_start_names, checked_time, exact_expression, generators_of
from .inverse_transform import (
    Combination,
    ResponseTransform,
    SymbolicSource,
    delta,
    divisors_of,
    entries_with,
    force_sources,
    initial_sources,
    initial_symbols,
)
from .symbolic_matrix import SymbolicPolynomialMatrix, checked_matrix


@dataclass(frozen=True, repr=False, eq=False)
class SymbolicResponse(Displayed):
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
        assumptions: expressions that must not vanish: where one vanishes, two zeros meet (resonance is one case), and x(t) is
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
    force_sources: tuple[SymbolicSource, ...] = field(repr=False)

    def _summary(self) -> str:
        free = ", ".join(sorted(map(str, self.regular.free_symbols)))
        return f"{counted(len(self.coordinates), 'coordinate')} in {free or 'no symbols'}"

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
        """Return the response for values of some or all symbols, solved again with these in A, start and force.

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
    """Solve X(s) = A(s)^-1 (X_in(s) + F(s)) in closed form (Moysis et al., Eqs. 46-48; one-sided from 0-).

    The exact principal part of X at every root of det A and of the force's denominators, transformed back term by term, gives
    the regular part; the Laurent coefficients of X at infinity give impulses and values at 0+. Nothing is a limit, and nothing
    is simplified by trial. Symbols are positive and generic (``assumptions`` of the result); where the sign of a discriminant
    such as c^2 - 4 k m is not decided by that, the oscillating form is given: it holds for both signs, and for 0 as a limit.

    Args:
        A: degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r), expressions or numbers; "symbols" for ``initial_symbols(A)``; None for zeros.
        force: r expressions in the time: sums and products of constants, t^k, exp, cos, sin, cosh, sinh,
            Heaviside(t - t0) and DiracDelta(t - t0, k), with symbols as rates, frequencies, phases and times, all
            positive; None for zeros.
        time: its symbol; None for the one called t in the force, or a real one.

    Returns:
        The response: regular part, impulses, values at 0+, and the assumptions under which they hold.

    Raises:
        InputError: shapes; a force of other functions, or of functions without the time; a parameter called like the time or
            like a value at 0- (x1_0); det A has a factor without roots in closed form.
        SingularPolynomialMatrix: det A(s) = 0 for every s.

    >>> m, k, x0, v0 = sympy.symbols("m k x0 v0", positive=True)
    >>> x = solve_symbolically(SymbolicPolynomialMatrix([[[k]], [[0]], [[m]]]), [[x0], [v0]])
    >>> x.regular[0]
    x0*cos(sqrt(k)*t/sqrt(m)) + sqrt(m)*v0*sin(sqrt(k)*t/sqrt(m))/sqrt(k)
    """
    X0, f = checked_initial(checked_matrix(A), initial), _checked_force(A, force)
    time = _time_of(A, X0, f, time)
    sources = tuple(force_sources(A, f, time))
    names = as_positive(generators_of(entries_with(A, sources)))
    solution = _solution(A.with_positive_symbols, X0.xreplace(names), f.xreplace(names), time)
    own = {positive: symbol for symbol, positive in names.items()}
    later = [start for start in {source.start for source in sources} if not (start.is_positive or start == 0)]
    return SymbolicResponse(
        polynomial_matrix=A,
        initial=X0,
        force=f,
        time=time,
        force_sources=sources,
        assumptions=(*(each.xreplace(own) for each in solution.pop("assumptions")), *later),
        **{name: _renamed(value, own) for name, value in solution.items()},
    )


def _solution(A, X0, f, time) -> dict[str, Any]:
    """The fields of the response; roots of symbols are short only where these are declared positive."""
    sources = initial_sources(A, X0) + force_sources(A, f, time)
    whole = ResponseTransform(A, sources)
    parts: dict[sympy.Expr, list[SymbolicSource]] = {sympy.S.Zero: []}
    for source in sources:
        parts.setdefault(source.start, []).append(source)
    later = {start: ResponseTransform(A, group, whole.field) for start, group in parts.items()}
    now = later.pop(sympy.S.Zero)
    regular = sympy.Matrix(now.regular(time))
    for t0, transform in later.items():
        regular += transform.regular(time).xreplace({time: time - t0}) * sympy.Heaviside(time - t0)
    divisors = divisors_of([*X0, *f, *(entry for matrix in A.coefficients for entry in matrix)], time)
    return {
        "regular": regular.as_immutable(),
        "impulses": now.impulses,
        "later_impulses": tuple((t0, transform.impulses) for t0, transform in later.items() if transform.impulses),
        "start": now.start,
        "assumptions": whole.assumptions(divisors),
    }


def _renamed(value, names: Mapping):
    """Matrices in tuples with other symbols."""
    return tuple(_renamed(each, names) for each in value) if isinstance(value, tuple) else value.xreplace(names)


# Validation of the values at 0-, the force and the symbol of the time.

#: Functions of time, the argument of which must be known to be time or not.
FUNCTIONS = (sympy.sin, sympy.cos, sympy.sinh, sympy.cosh, sympy.exp, sympy.Heaviside, sympy.DiracDelta)


def checked_initial(A: SymbolicPolynomialMatrix, initial) -> sympy.ImmutableMatrix:
    """The values at 0- as exact expressions."""
    if isinstance(initial, str):
        if initial != "symbols":
            raise InputError(f'initial: found {initial!r}; expected rows of values, "symbols" or None')
        return initial_symbols(A)
    if initial is None:
        return sympy.zeros(A.degree, A.size).as_immutable()
    rows = [_listed(row) for row in _listed(initial) or ()]
    if len(rows) != A.degree or any(row is None or len(row) != A.size for row in rows):
        wanted = f"expected {A.degree} rows of {A.size} values, row i the i-th derivatives at 0-"
        raise InputError(f"initial: {wanted}, [[x(0-), ...], [x'(0-), ...], ...]; found {initial!r}")
    return sympy.Matrix(A.degree, A.size, [exact_expression(value, "initial") for row in rows for value in row]).as_immutable()


def _checked_force(A: SymbolicPolynomialMatrix, force) -> sympy.ImmutableMatrix:
    """The force as exact expressions, shape (r, 1)."""
    if force is None:
        return sympy.zeros(A.size, 1).as_immutable()
    rows = _listed(force)
    if rows is None:
        raise InputError(
            f"force: found {force!r}; expected a list of {counted(A.size, 'sympy expression')} in the time, such as F*sin(w*t), "
            "exp(-a*t), Heaviside(t - t0) (mb.step and others like it are forces of mb.solve)"
        )
    rows = [row[0] if isinstance(row, list) and len(row) == 1 else row for row in rows]
    if len(rows) != A.size:
        raise InputError(f"force: found {len(rows)} entries; expected {A.size}, one expression in the time for each equation")
    return sympy.Matrix([exact_expression(value, "force") for value in rows]).as_immutable()


def _listed(value) -> list | None:
    """A list or a matrix as a list; None for anything else."""
    rows = value.tolist() if hasattr(value, "tolist") else value
    return list(rows) if isinstance(rows, Sequence) and not isinstance(rows, str) else None


def _time_of(A: SymbolicPolynomialMatrix, initial: sympy.Matrix, force: sympy.Matrix, time) -> sympy.Symbol:
    """The symbol of the time, which may occur in the force only."""
    if time is None:
        named = [symbol for symbol in force.free_symbols if symbol.name == TIME.name]
        odd = {function for function in force.atoms(*FUNCTIONS) if function.free_symbols}
        if odd and not named:
            function = min(odd, key=sympy.default_sort_key)
            symbol = min(function.free_symbols, key=str)
            raise InputError(
                f"force: found {function}, but no time t; if {symbol} is the time, pass time={symbol}; if the force is constant, pass "
                "time=sympy.Symbol('t', real=True)"
            )
        time = named[0] if named else TIME
    others = {*A.symbols, *initial.free_symbols}
    time = checked_time(time, others, "A or of the values at 0-")
    check_one_each([*others, *force.free_symbols, time])
    started = {value for value, own in zip(initial, initial_symbols(A)) if value == own}
    check_start_names(A.coordinates, A.degree, force.free_symbols - started)
    return time


# Conditions on the values at 0-, as row-reduced linear equations: without impulses, and without jumps.


def impulse_equations(A: SymbolicPolynomialMatrix, force: Iterable[SymbolicSource] = ()) -> tuple[sympy.Eq, ...]:
    """Equations in ``initial_symbols(A)`` equivalent to the absence of impulses (Moysis et al., Eq. 58).

    Corrected: the force enters by f^(j)(0+), not by f^(j)(0-); Dirac impulses of the force itself act whatever the start is and
    are left out. The equations are the polynomial part of X(s), row reduced: each gives one value in terms of later ones.
    """
    general = _general(A, force)
    return _reduced(general, [entry for power, row in general.laurent.items() if power >= 0 for entry in row])


def continuity_equations(A: SymbolicPolynomialMatrix, force: Iterable[SymbolicSource] = ()) -> tuple[sympy.Eq, ...]:
    """Equations in ``initial_symbols(A)`` equivalent to x^(i)(0+) = x^(i)(0-), i < q (Eq. 60).

    Corrected: the right-hand side of (60) is block Toeplitz, its block (k, c) is H_{c-k} with the H of negative index too,
    which are what the derivatives of the convolution leave at 0+. They imply that there are no impulses.
    """
    general, symbols, rows = _general(A, force), initial_symbols(A), []
    for i in range(A.degree):
        for j, entry in enumerate(general.laurent[-1 - i]):
            before = symbols[i, j]
            rows.append({**entry, before: entry.get(before, general.field.zero) - general.field.one})
    return _reduced(general, rows)


def _general(A: SymbolicPolynomialMatrix, force: Iterable[SymbolicSource]) -> ResponseTransform:
    """X for general values at 0-."""
    smooth = [source for source in force if source.start == 0 and not source.is_impulse]
    return ResponseTransform(A, initial_sources(A, initial_symbols(A)) + smooth)


def _reduced(general: ResponseTransform, rows: list[Combination]) -> tuple[sympy.Eq, ...]:
    """The equations rows = 0 solved for their earliest values."""
    field, values = general.field, list(initial_symbols(general.A))
    others = sorted({g for row in rows for g in row} - set(values), key=sympy.default_sort_key)
    columns = [*values, *others]
    if not rows or not columns:
        return ()
    matrix = DomainMatrix([[row.get(g, field.zero) for g in columns] for row in rows], (len(rows), len(columns)), field)
    reduced, pivots = matrix.rref()
    equations = []
    for row, pivot in zip(reduced.to_list(), pivots):
        rest = {generator: -factor for place, (generator, factor) in enumerate(zip(columns, row)) if factor and place != pivot}
        equations.append(sympy.Eq(columns[pivot], general.combined(rest), evaluate=False))
    return tuple(equations)
