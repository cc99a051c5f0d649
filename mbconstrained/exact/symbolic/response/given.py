"""What users give besides A(s): values at 0-, a force and the symbol of the time, checked at the door."""

from __future__ import annotations

from collections.abc import Sequence

import sympy

from ....checks import counted
from ....errors import InputError
from ..algebra.matrix import SymbolicPolynomialMatrix
from ..field.fields import exact_expression
from ..field.names import TIME, check_one_each, check_start_names, checked_time
from .sources import initial_symbols

#: Functions of time, the argument of which must be known to be time or not.
FUNCTIONS = (sympy.sin, sympy.cos, sympy.sinh, sympy.cosh, sympy.exp, sympy.Heaviside, sympy.DiracDelta)


def checked_initial(A: SymbolicPolynomialMatrix, initial) -> sympy.ImmutableMatrix:
    """The values at 0- as exact expressions, shape (q, r)."""
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


def checked_force(A: SymbolicPolynomialMatrix, force) -> sympy.ImmutableMatrix:
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
    """A list, None for what is no list and no matrix."""
    found = value.tolist() if hasattr(value, "tolist") else value
    return list(found) if isinstance(found, Sequence) and not isinstance(found, str) else None


def time_of(A: SymbolicPolynomialMatrix, initial: sympy.Matrix, force: sympy.Matrix, time) -> sympy.Symbol:
    """The symbol of the time, which nothing but the force may have."""
    if time is None:
        found = [symbol for symbol in force.free_symbols if symbol.name == TIME.name]
        time = found[0] if found else _without_time(force)
    others = {*A.symbols, *initial.free_symbols}
    time = checked_time(time, others, "A or of the values at 0-")
    check_one_each([*others, *force.free_symbols, time])
    started = {value for value, own in zip(initial, initial_symbols(A)) if value == own}
    check_start_names(A.coordinates, A.degree, force.free_symbols - started)
    return time


def _without_time(force) -> sympy.Symbol:
    """t, for a force that is constant, and does not look like a function of a time of another name."""
    odd = {function for function in force.atoms(*FUNCTIONS) if function.free_symbols}
    if odd:
        found = min(odd, key=sympy.default_sort_key)
        symbol = min(found.free_symbols, key=str)
        raise InputError(
            f"force: found {found}, but no time t; if {symbol} is the time, pass time={symbol}; if the force is constant, pass "
            "time=sympy.Symbol('t', real=True)"
        )
    return TIME
