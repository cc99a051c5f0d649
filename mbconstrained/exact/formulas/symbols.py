"""Parameters as symbols: what was written as numbers or as expressions of parameters, exactly, in sympy's terms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import sympy

from .closed_form import ClosedForm, Parameter, exact

#: Of pi, where it is a number among rational ones.
PI_DIGITS = 45

#: Ends the names that parameters have in the engine: no name of a user, nor s, t or a value at 0- (x1_0), ends with it.
MARK = "·"


class Symbols:
    """The symbols of named parameters, or their default values, and the way from entries to expressions.

    To the engine all symbols are positive, with names of their own, so that a parameter may be called s or x1_0. A parameter
    whose default value is negative is minus one there, and pi, which is no rational number, is a symbol; ``finished`` puts
    back what they stand for.

    Args:
        values: default values by name.
        units: in which they are, by name.
        numbers: whether the parameters are their default values from the start.

    >>> from mbconstrained.scene.expressions import read_expression
    >>> symbols = Symbols({"k": 2.0, "g": -9.81})
    >>> symbols.of(0.1), symbols.expression(read_expression("2*k*g"))
    (1/10, -2*g·*k·)
    >>> symbols.plain("k· is 0")
    'k is 0'
    """

    def __init__(self, values: Mapping[str, float], units: Mapping[str, str] | None = None, numbers: bool = False):
        self.time = sympy.Symbol("t", real=True)
        self.numbers = numbers
        self.pi = sympy.Symbol("π", positive=True)
        self._engine: dict[str, sympy.Expr] = {}
        self._back: dict[sympy.Symbol, sympy.Expr] = {self.pi: sympy.pi}
        self.parameters: list[Parameter] = []
        for name, value in values.items():
            self._add(name, value, (units or {}).get(name, ""))
        if numbers:
            self.pi = sympy.Rational(str(sympy.pi.evalf(PI_DIGITS)))

    def _add(self, name: str, value: float, unit: str) -> None:
        if self.numbers:
            self._engine[name] = exact(value)
            return
        inner = sympy.Symbol(f"{name}{MARK}", positive=True)
        shown = sympy.Symbol(name, negative=True) if value < 0 else sympy.Symbol(name, positive=True)
        self._engine[name], self._back[inner] = (-inner, -shown) if value < 0 else (inner, shown)
        self.parameters.append(Parameter(shown, name, exact(value), unit))

    def of(self, entry) -> sympy.Expr:
        """A number as the decimal that it is written as, an expression of parameters as such."""
        tree = getattr(entry, "tree", None)
        return exact(entry) if tree is None else self.expression(tree)

    def expression(self, tree) -> sympy.Expr:
        """A tree of operations, numbers and names."""
        return tree.value(sympy.Rational, {**self._engine, "pi": self.pi})

    def all_of(self, entries) -> np.ndarray:
        """An array of entries as an array of expressions."""
        entries = np.asarray(entries, dtype=object)
        found = np.empty(entries.shape, dtype=object)
        for place in np.ndindex(found.shape):
            found[place] = self.of(entries[place])
        return found

    @staticmethod
    def plain(text: str) -> str:
        """A message of the engine with the names that the user gave."""
        return text.replace(MARK, "")

    def finished(self, form: ClosedForm) -> ClosedForm:
        """The formula with what the symbols of the engine stand for, and the parameters that are left in it."""

        def back(expression):
            return expression.xreplace(self._back) if isinstance(expression, sympy.Basic) else expression

        found = replace(
            form,
            values=tuple(map(back, form.values)),
            impulses=tuple(replace(each, factor=back(each.factor), time=back(each.time)) for each in form.impulses),
            jumps=tuple(replace(each, size=back(each.size)) for each in form.jumps),
            **{kind: tuple(map(back, getattr(form, kind))) for kind in ("admissible", "continuous", "assumptions")},
        )
        found = replace(found, assumptions=tuple(each for each in found.assumptions if not each.is_number))
        used = set().union(*(each.free_symbols for each in found.everything))
        return replace(found, parameters=tuple(p for p in self.parameters if p.symbol in used))
