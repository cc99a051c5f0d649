"""The formula of an answer: an expression in t for each coordinate, with what the symbols in it stand for."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import sympy

from ...ground.checks import names_of
from ...ground.errors import InputError
from ..symbolic.field.fields import exact_expression

#: Digits that values are computed with where a decision or an output needs numbers.
DIGITS = 40

#: Of the sum of its terms, a coefficient this small is the zero that exact arithmetic would have given.
VANISHING = sympy.Float(10) ** -30


@dataclass(frozen=True)
class FormulaParameter:
    """A symbol with its name and its default value.

    Attributes:
        symbol: in the expressions.
        name: as the user wrote it.
        value: the default, an exact number; None where there is none.
        unit: unit of SI, or an empty text.
    """

    symbol: sympy.Symbol
    name: str
    value: sympy.Expr | None = None
    unit: str = ""


@dataclass(frozen=True)
class Impulse:
    """factor times the derivative of this order of Dirac's delta at a time, in a coordinate."""

    name: str
    order: int
    factor: sympy.Expr
    time: sympy.Expr = sympy.S.Zero


@dataclass(frozen=True)
class Jump:
    """Jump of the derivative of this order of a coordinate at t = 0."""

    name: str
    order: int
    size: sympy.Expr


@dataclass(frozen=True)
class ClosedForm:
    """x(t) for t > 0, one expression for each coordinate; what the printers of this folder print.

    Attributes:
        names: names of the r coordinates, as the user wrote them.
        values: r expressions in the time.
        time: the symbol t.
        parameters: the other symbols.
        impulses, jumps: jumps and impulses at t = 0, and later impulses.
        admissible, continuous: equations in the values at 0- without which there are impulses, or jumps.
        assumptions: expressions that must not vanish for the formula to hold.
        positive: expressions that must be positive for the formula to be real in this form.
        title: a line about where it comes from.
    """

    names: tuple[str, ...]
    values: tuple[sympy.Expr, ...]
    time: sympy.Symbol
    parameters: tuple[FormulaParameter, ...] = ()
    impulses: tuple[Impulse, ...] = ()
    jumps: tuple[Jump, ...] = ()
    admissible: tuple[sympy.Eq, ...] = ()
    continuous: tuple[sympy.Eq, ...] = ()
    assumptions: tuple[sympy.Expr, ...] = ()
    positive: tuple[sympy.Expr, ...] = ()
    title: str = ""

    @classmethod
    def of(cls, x, names: Sequence[str] | None = None, parameters: Mapping[sympy.Symbol, object] | None = None) -> ClosedForm:
        """The formula of a symbolic response.

        Args:
            x: a ``SymbolicResponse``, or a ClosedForm, which is returned as it is unless names or parameters are given.
            names: names of the coordinates; those of the response when not given.
            parameters: default values by symbol, numbers.

        Returns:
            The formula.

        Raises:
            InputError: not as many names as coordinates, or a name used twice.
        """
        if isinstance(x, cls):
            form = x
        else:
            form = cls(tuple(x.coordinates), tuple(x.regular), x.time, **_jumps_and_impulses(x))
        form = replace(form, names=names_of(names if names is not None else form.names, len(form.values), "names", "x"))
        given = parameters if parameters is not None else {p.symbol: p.value for p in form.parameters}
        known = {p.symbol: p for p in form.parameters}
        symbols = [*given, *sorted(form.symbols - set(given), key=lambda symbol: symbol.name)]
        values = {s: exact_expression(value, s.name) for s, value in given.items() if value is not None}
        named = tuple(known.get(s) or FormulaParameter(s, s.name, values.get(s)) for s in symbols)
        return replace(form, parameters=named)

    @property
    def symbols(self) -> set[sympy.Symbol]:
        """All symbols except the time."""
        return set().union(*(value.free_symbols for value in self.values)) - {self.time}

    @property
    def quantities(self) -> list[sympy.Expr]:
        """The expressions of the coordinates, their impulses and their jumps."""
        impulses = [part for each in self.impulses for part in (each.factor, each.time)]
        return [*map(sympy.sympify, (*self.values, *impulses, *(each.size for each in self.jumps)))]

    def mapped(self, change: Callable[[sympy.Expr], sympy.Expr]) -> ClosedForm:
        """The formula with another expression for each coordinate, factor of an impulse and jump."""
        return replace(
            self,
            values=tuple(map(change, self.values)),
            impulses=tuple(replace(each, factor=change(each.factor)) for each in self.impulses),
            jumps=tuple(replace(each, size=change(each.size)) for each in self.jumps),
        )

    @property
    def defaults(self) -> dict[sympy.Symbol, sympy.Expr]:
        """Default values by symbol, of those that have one."""
        return {p.symbol: p.value for p in self.parameters if p.value is not None}

    @property
    def step_note(self) -> str:
        """Definition of H, where it is used."""
        return "H(t) is the unit step: 0 before t = 0, 1 after." if any(v.has(sympy.Heaviside) for v in self.values) else ""

    def at_defaults(self, expression: sympy.Expr) -> sympy.Expr:
        """An expression with the default values put in, exactly."""
        return expression.xreplace(self.defaults)

    def only(self, names: Sequence[str]) -> ClosedForm:
        """The formula of some of the coordinates, in this order.

        Raises:
            InputError: no such coordinate.
        """
        if unknown := [name for name in names if name not in self.names]:
            raise InputError(f'there is no coordinate "{unknown[0]}"; the coordinates are {", ".join(self.names)}')
        values = tuple(self.values[self.names.index(name)] for name in names)
        kept = {kind: tuple(each for each in getattr(self, kind) if each.name in names) for kind in ("impulses", "jumps")}
        return replace(self, names=tuple(names), values=values, **kept)


def _jumps_and_impulses(x) -> dict:
    """Impulses, jumps and conditions of a symbolic response."""
    times = ((sympy.S.Zero, x.impulses), *x.later_impulses)
    impulses = tuple(
        Impulse(name, order, factor, time)
        for time, rows in times
        for order, row in enumerate(rows)
        for name, factor in zip(x.coordinates, row)
        if factor != 0
    )
    jumps = tuple(
        Jump(name, order, size) for order in range(x.jump.rows) for name, size in zip(x.coordinates, x.jump.row(order)) if size != 0
    )
    return {
        "impulses": impulses,
        "jumps": jumps,
        "admissible": tuple(x.admissible_conditions),
        "continuous": tuple(x.continuity_conditions),
        "assumptions": tuple(getattr(x, "assumptions", ())),
    }
