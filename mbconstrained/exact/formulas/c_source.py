"""A formula as a C function."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

import sympy
from sympy.printing.c import C99CodePrinter

from .closed_form import ClosedForm
from .source import Source, default_text, source_of, told

WIDTH = 100


class _Printer(C99CodePrinter):
    """Steps as conditions; all numbers as doubles, and none of the constants that are not in the standard (M_SQRT2)."""

    def __init__(self):
        super().__init__({"math_macros": {}})

    def _print_Heaviside(self, expr) -> str:
        return f"(({self._print(expr.args[0])}) >= 0.0 ? 1.0 : 0.0)"

    def _print_Float(self, expr) -> str:
        return repr(float(expr))

    def _print_Exp1(self, expr) -> str:
        return "exp(1.0)"

    def _print_Pi(self, expr) -> str:
        return repr(float(sympy.pi))


def c_source(x, names: Sequence[str] | None = None) -> str:
    """x(t) as the source of a C function void x(double t, double m, ..., double values[r]), C99 and later.

    Dirac impulses are told in the comment; they are not in the values. Default values of parameters stand in a second
    function, x_default(t, values).

    Args:
        x: a ``SymbolicResponse`` or a ``ClosedForm``.
        names: of the coordinates, where they are not to be called as in x.

    >>> t, k = sympy.symbols("t k", positive=True)
    >>> print(c_source(ClosedForm(("x1",), (k * t,), t)))
    /*
     * The motion in closed form.
     *
     * values[0]: x1
     * k: parameter
     */
    #include <math.h>
    <BLANKLINE>
    void x(double t, double k, double values[1]);
    <BLANKLINE>
    void x(double t, double k, double values[1])
    {
        values[0] = k*t;
    }
    <BLANKLINE>
    """
    form = ClosedForm.of(x, names)
    source, printer = source_of(form), _Printer()
    count = len(form.values)
    arguments = ", ".join(["double t", *(f"double {name}" for name in source.parameters.values()), f"double values[{count}]"])
    lines = [f"    const double {symbol.name} = {_wrapped(printer.doprint(value))};" for symbol, value in source.steps]
    lines += [f"    values[{row}] = {_wrapped(printer.doprint(value))};" for row, value in enumerate(source.values)]
    used = set().union(*(v.free_symbols for v in source.values), *(v.free_symbols for _, v in source.steps))
    names_used = {symbol.name for symbol in used}
    unused = [f"    (void){name};" for name in ("t", *source.parameters.values()) if name not in names_used]
    parts = [_comment(source), "#include <math.h>\n", f"void x({arguments});"]
    defaults = _with_defaults(source, count)
    if defaults:
        parts.append(f"void x_default(double t, double values[{count}]);")
    parts += ["", f"void x({arguments})\n{{", *unused, *lines, "}", *defaults]
    return "\n".join(parts) + "\n"


def _with_defaults(source: Source, count: int) -> list[str]:
    values = [p.value for p in source.form.parameters]
    if not values or None in values:
        return []
    call = ", ".join(["t", *map(default_text, values), "values"])
    return ["", f"void x_default(double t, double values[{count}])\n{{\n    x({call});\n}}"]


def _comment(source: Source) -> str:
    form = source.form
    lines = [form.title or "The motion in closed form.", ""]
    lines += [f"values[{row}]: {name}" for row, name in enumerate(form.names)]
    for p in form.parameters:
        unit = f" {p.unit}" if p.unit else ""
        default = f", {default_text(p.value)}{unit}" if p.value is not None else unit
        lines.append(f"{source.parameters[p.name]}: {p.name if p.name != source.parameters[p.name] else 'parameter'}{default}")
    notes = told(form)
    lines += ["", *notes] if notes else []
    wrapped = [part for line in lines for part in textwrap.wrap(line, WIDTH, subsequent_indent="    ") or [""]]
    return "\n".join(["/*", *(f" * {_quotable(line)}".rstrip() for line in wrapped), " */"])


def _quotable(text: str) -> str:
    """A text that cannot end the comment, nor join lines."""
    return text.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").replace("??", "? ?")


def _wrapped(text: str) -> str:
    if len(text) + 24 <= WIDTH:
        return text
    return "\n        ".join(textwrap.wrap(text, WIDTH - 8, break_long_words=False, break_on_hyphens=False))
