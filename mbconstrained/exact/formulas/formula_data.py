"""A formula as texts, lists and numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import sympy
from sympy.polys.matrices import DomainMatrix

from ..symbolic.response.symbolic_response import SymbolicResponse
from ..symbolic.response.symbolic_sources import initial_symbols
from .closed_form import ClosedForm
from .formula_text import TextPrinter, formula_text
from .markup import latex
from .printing_layout import Derivative, laid_out


def records(form: ClosedForm, digits: int | None = None) -> dict:
    """Texts, lists and numbers only.

    >>> import sympy
    >>> t = sympy.Symbol("t")
    >>> records(ClosedForm(("x1",), (2 * t,), t))["formulas"]["x1"]["text"]
    'x1(t) = 2 t'
    """
    layout, printer = laid_out(form, digits), TextPrinter(form)
    bare = replace(form, impulses=(), jumps=(), admissible=(), continuous=(), assumptions=(), positive=())

    def text_of(expression) -> str:
        return printer.doprint(layout.number(expression))

    return {
        "title": form.title,
        "parameters": {p.name: {"value": None if p.value is None else float(p.value), "unit": p.unit} for p in form.parameters},
        "formulas": {
            name: {"text": formula_text(bare.only([name]), digits=digits), "latex": latex(bare.only([name]), digits=digits)}
            for name in form.names
        },
        "impulses": [
            {"of": each.name, "order": each.order, "time": text_of(each.time), "factor": text_of(each.factor)}
            for each in form.impulses
        ],
        "jumps": [{"of": printer.part(Derivative(each.name, each.order)), "size": text_of(each.size)} for each in form.jumps],
        "no_impulses_if": [printer.part(each) for each in form.admissible],
        "no_jumps_if": [printer.part(each) for each in form.continuous],
        "not_zero": [printer.doprint(each) for each in form.assumptions],
        "positive": [printer.doprint(each) for each in form.positive],
    }


# Conditions on the start in the values at 0- that a user gives: those of inputs and outputs follow from the others.


def without_implied(
    form: ClosedForm, x: SymbolicResponse, implied: Mapping[str, Mapping[str, sympy.Expr]]
) -> dict[str, tuple[sympy.Eq, ...]]:
    """The admissible and continuous conditions without the values that follow from others.

    Where they cannot be met, since the input jumps, there are none: the jump itself is reported.
    """
    if not implied:
        return {}
    values, names = initial_symbols(x.polynomial_matrix), x.coordinates
    put = {
        row[names.index(name)]: sum((factor * row[names.index(other)] for other, factor in factors.items()), sympy.S.Zero)
        for name, factors in implied.items()
        for row in values.tolist()
    }
    given = [value for value in values if value not in put]
    return {kind: _solved([each.xreplace(put) for each in getattr(form, kind)], given) for kind in ("admissible", "continuous")}


def _solved(equations: Sequence[sympy.Eq], values: Sequence[sympy.Symbol]) -> tuple[sympy.Eq, ...]:
    """Linear equations solved for the earliest of the values; none of them where they contradict each other."""
    left = [sympy.expand(each.lhs - each.rhs) if isinstance(each, sympy.Eq) else 0 if each else 1 for each in equations]
    if not any(left) or not values:
        return ()
    A, b = sympy.linear_eq_to_matrix(left, values)
    reduced, pivots = DomainMatrix.from_Matrix(A.row_join(b)).to_field().rref()
    if len(values) in pivots:
        return ()
    return tuple(_equation(row, pivot, values) for row, pivot in zip(reduced.to_Matrix().tolist(), pivots))


def _equation(row: Sequence[sympy.Expr], pivot: int, values: Sequence[sympy.Symbol]) -> sympy.Eq:
    rest = [-factor * value for place, (factor, value) in enumerate(zip(row, values)) if place != pivot]
    return sympy.Eq(values[pivot], sympy.Add(sympy.factor(row[-1]), *rest), evaluate=False)
