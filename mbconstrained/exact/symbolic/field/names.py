"""The names of symbols: one symbol for each, and the time and the values at 0- apart from the parameters.

Symbols of one name and different assumptions are different to sympy, and the same to everybody who reads a formula.
"""

from __future__ import annotations

from collections.abc import Iterable

import sympy

from ....errors import InputError

#: The time, where the user names none.
TIME = sympy.Symbol("t", real=True)

#: The variable of every A(s) and of all transforms.
VARIABLE = "s"


def checked_time(time, others: Iterable[sympy.Symbol], of: str, what: str = "time") -> sympy.Symbol:
    """The symbol of the time, whose name no other has.

    Args:
        time: what the user gave; None for a real symbol t.
        others: the symbols of everything that does not depend on time.
        of: where those are from, for messages.
        what: the argument.

    Raises:
        InputError: no symbol, or one of the others is called like it.

    >>> checked_time(None, sympy.symbols("k m"), "A")
    t
    """
    time = TIME if time is None else time
    if not isinstance(time, sympy.Symbol):
        raise InputError(f"{what}: found {time!r}; expected a sympy.Symbol, e.g. sympy.Symbol('t', real=True)")
    if time.name in {symbol.name for symbol in others}:
        raise InputError(f"{what}: the symbol {time} is also one of {of}; name the time otherwise")
    return time


def check_one_each(symbols: Iterable[sympy.Symbol]) -> None:
    """One symbol for each name, and none that is called like the variable of A(s).

    Raises:
        InputError: otherwise.
    """
    names: dict[str, sympy.Symbol] = {}
    for symbol in symbols:
        if symbol.name == VARIABLE:
            raise InputError(f'the symbol "{symbol}" is the variable of A(s); name parameters of values and forces otherwise')
        if names.setdefault(symbol.name, symbol) != symbol:
            raise InputError(
                f'found two symbols "{symbol}" of different assumptions; use the same one in A, values, force and time'
            )


def start_name(coordinate: str, order: int) -> str:
    """What the value of a derivative of a coordinate at 0- is called."""
    return f"{coordinate}_{order}"


def check_start_names(coordinates: Iterable[str], degree: int, parameters: Iterable[sympy.Symbol]) -> None:
    """No parameter that is called like a value at 0-: it would be taken for that value.

    Raises:
        InputError: there is one.

    >>> check_start_names(["u"], 2, sympy.symbols("k u_1"))
    Traceback (most recent call last):
    ...
    mbconstrained.errors.InputError: coordinate u and parameter u_1: derivative 1 of u at 0- is called u_1 too; rename one
    """
    names = {parameter.name for parameter in parameters}
    for coordinate in coordinates:
        for order in range(degree):
            name = start_name(coordinate, order)
            if name in names:
                value = f"the value of {coordinate}" if order == 0 else f"derivative {order} of {coordinate}"
                raise InputError(f"coordinate {coordinate} and parameter {name}: {value} at 0- is called {name} too; rename one")


def as_positive(symbols: Iterable) -> dict[sympy.Symbol, sympy.Symbol]:
    """Positive symbols of the same names for those that are not declared so: sqrt(k/m) is sqrt(k)/sqrt(m) of positive ones only.

    >>> k, m = sympy.Symbol("k"), sympy.Symbol("m", positive=True)
    >>> [symbol.is_positive for symbol in as_positive([k, m]).values()]
    [True]
    """
    plain = (symbol for symbol in symbols if isinstance(symbol, sympy.Symbol) and not symbol.is_positive)
    return {symbol: sympy.Symbol(symbol.name, positive=True) for symbol in plain}
