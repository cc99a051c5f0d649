"""A formula as plain data."""

from __future__ import annotations

from dataclasses import replace

from .closed_form import ClosedForm
from .latex import latex
from .layout import laid_out
from .plain_text import derivative_name, equation_text, plain_text, text_printer


def records(form: ClosedForm, digits: int | None = None) -> dict:
    """Texts, lists and numbers only.

    >>> import sympy
    >>> t = sympy.Symbol("t")
    >>> records(ClosedForm(("x1",), (2 * t,), t))["formulas"]["x1"]["text"]
    'x1(t) = 2 t'
    """
    layout, printer = laid_out(form, digits), text_printer(form)
    bare = replace(form, impulses=(), jumps=(), admissible=(), continuous=(), assumptions=(), positive=())

    def tell(expression) -> str:
        return printer.doprint(layout.number(expression))

    return {
        "title": form.title,
        "parameters": {p.name: {"value": None if p.value is None else float(p.value), "unit": p.unit} for p in form.parameters},
        "formulas": {
            name: {"text": plain_text(bare.only([name]), digits=digits), "latex": latex(bare.only([name]), digits=digits)}
            for name in form.names
        },
        "impulses": [
            {"of": each.name, "order": each.order, "time": tell(each.time), "factor": tell(each.factor)} for each in form.impulses
        ],
        "jumps": [{"of": derivative_name(each.name, each.order), "size": tell(each.size)} for each in form.jumps],
        "no_impulses_if": [equation_text(each, printer) for each in form.admissible],
        "no_jumps_if": [equation_text(each, printer) for each in form.continuous],
        "not_zero": [printer.doprint(each) for each in form.assumptions],
        "positive": [printer.doprint(each) for each in form.positive],
    }
