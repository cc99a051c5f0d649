"""A formula as the source of a function in C and in Python: identifiers, numbers, common subexpressions, and both printers."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import sympy
from sympy.printing.c import C99CodePrinter
from sympy.printing.numpy import NumPyPrinter

from ..symbolic.response.inverse_transform import divisors_of
from .closed_form import ClosedForm, FormulaParameter
from .formula_text import TextPrinter
from .identifiers import identifiers
from .printing_layout import Layout

#: Whole numbers up to this are exact in a double.
LARGEST_WHOLE = 2**53

#: Digits of decimals in a source: three more than a double holds, so that it is rounded once.
SOURCE_DIGITS = 20

TITLE = "The motion in closed form."

#: Characters in a line.
WIDTH = 100


@dataclass(frozen=True)
class SourceCode:
    """Expressions ready to be printed as a program.

    Attributes:
        form: formula of the program.
        parameters: identifiers of the parameters, in their order.
        steps: (identifier, expression) one after the other.
        values: expressions for the coordinates.
    """

    form: ClosedForm
    parameters: dict[str, str]
    steps: tuple[tuple[sympy.Symbol, sympy.Expr], ...]
    values: tuple[sympy.Expr, ...]


def _source_of(form: ClosedForm) -> SourceCode:
    """Identifiers for symbols, short numbers, common subexpressions."""
    named = identifiers([p.name for p in form.parameters])
    symbols = {p.symbol: sympy.Symbol(named[p.name], real=True) for p in form.parameters}
    time = {form.time: sympy.Symbol("t", real=True)}
    stable = {below: with_square(below) for below in divisors_of(form.quantities, form.time) if below.is_Add}
    values = [_short(value.xreplace(stable)).xreplace({**symbols, **time}) for value in form.values]
    fresh = sympy.numbered_symbols("c", exclude=[sympy.Symbol(name, real=True) for name in named.values()], real=True)
    steps, reduced = sympy.cse(values, symbols=fresh, optimizations="basic", order="none")
    return SourceCode(form, named, tuple(steps), tuple(reduced))


def _short(value: sympy.Expr) -> sympy.Expr:
    """Fractions of long numbers as decimals, which is what a double makes of them anyway."""
    long = {q: sympy.Float(q, SOURCE_DIGITS) for q in value.atoms(sympy.Rational) if max(abs(q.p), q.q) > LARGEST_WHOLE}
    floats = {f: sympy.Float(f, SOURCE_DIGITS) for f in value.atoms(sympy.Float)}
    return value.xreplace({**long, **floats})


def with_square(total: sympy.Expr) -> sympy.Expr:
    """u^2 - 2 u v + v^2 + rest as (u - v)^2 + rest, where nothing is subtracted in the rest; else as it is.

    A divisor near resonance, |k - m w^2 + i c w|^2, is small there, and its terms are not: so it keeps its digits.

    >>> k, m, c, w = sympy.symbols("k m c w", positive=True)
    >>> with_square(k**2 - 2 * k * m * w**2 + m**2 * w**4 + c**2 * w**2)
    c**2*w**2 + (-k + m*w**2)**2
    >>> with_square(k - m)
    k - m
    """
    polynomial = total.as_poly()
    if polynomial is None or not (polynomial.domain.is_QQ or polynomial.domain.is_ZZ):
        return total
    even = [(powers, sympy.sqrt(c)) for powers, c in polynomial.terms() if c > 0 and not any(power % 2 for power in powers)]
    roots = [
        sympy.Poly({tuple(power // 2 for power in powers): root}, *polynomial.gens) for powers, root in even if root.is_Rational
    ]
    for u, v in combinations(roots, 2):
        rest = polynomial - (u - v) ** 2
        if min(rest.coeffs()) >= 0:
            return (u - v).as_expr() ** 2 + rest.as_expr()
    return total


def _remarks(source: SourceCode, first: list[str]) -> list[str]:
    """Lines of a comment: the first ones, the parameters, and the jumps, impulses and assumptions."""
    printer, statements = TextPrinter(source.form), Layout(source.form, [], [], None).statements
    after = {"jumps": "", "impulses": ", which is not in the values", "assumptions": "", "positive": ""}
    notes = [printer.statement(parts) + end for kind, end in after.items() for parts in statements[kind]]
    lines = [*first, *(_described(source.parameters[p.name], p) for p in source.form.parameters), *[""] * bool(notes), *notes]
    return [part for line in lines for part in textwrap.wrap(line, WIDTH, subsequent_indent="    ") or [""]]


def _described(identifier: str, parameter: FormulaParameter) -> str:
    """k_: k-, 2.0 N/m."""
    default = "" if parameter.value is None else repr(float(parameter.value))
    value = f"{default} {parameter.unit}".strip()
    return f"{identifier}: {parameter.name if parameter.name != identifier else 'parameter'}{value and f', {value}'}"


def _wrapped(text: str, indent: int) -> list[str]:
    """A long sum, broken at its blanks."""
    return textwrap.wrap(text, WIDTH - indent, break_long_words=False, break_on_hyphens=False)


# A formula as a C function.


class _CPrinter(C99CodePrinter):
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

    Dirac impulses are listed in the comment; they are not in the values. Default values of parameters stand in a second
    function, x_default(t, values).

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
    source, printer = _source_of(form), _CPrinter()
    count = len(form.values)
    arguments = ", ".join(["double t", *(f"double {name}" for name in source.parameters.values()), f"double values[{count}]"])
    lines = [f"    const double {symbol.name} = {_in_c(printer.doprint(value))};" for symbol, value in source.steps]
    lines += [f"    values[{row}] = {_in_c(printer.doprint(value))};" for row, value in enumerate(source.values)]
    used = set().union(*(v.free_symbols for v in source.values), *(v.free_symbols for _, v in source.steps))
    names_used = {symbol.name for symbol in used}
    unused = [f"    (void){name};" for name in ("t", *source.parameters.values()) if name not in names_used]
    parts = [_comment(source), "#include <math.h>\n", f"void x({arguments});"]
    defaults = _with_defaults(source, count)
    if defaults:
        parts.append(f"void x_default(double t, double values[{count}]);")
    parts += ["", f"void x({arguments})\n{{", *unused, *lines, "}", *defaults]
    return "\n".join(parts) + "\n"


def _with_defaults(source: SourceCode, count: int) -> list[str]:
    values = [p.value for p in source.form.parameters]
    if not values or None in values:
        return []
    call = ", ".join(["t", *(repr(float(value)) for value in values), "values"])
    return ["", f"void x_default(double t, double values[{count}])\n{{\n    x({call});\n}}"]


def _comment(source: SourceCode) -> str:
    """The comment of a source; no name can end it, nor join lines."""
    form = source.form
    lines = _remarks(source, [form.title or TITLE, "", *(f"values[{row}]: {name}" for row, name in enumerate(form.names))])
    quotable = (line.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").replace("??", "? ?") for line in lines)
    return "\n".join(["/*", *(f" * {line}".rstrip() for line in quotable), " */"])


def _in_c(text: str) -> str:
    return text if len(text) + 24 <= WIDTH else "\n        ".join(_wrapped(text, 8))


# A formula as a Python function of NumPy.


class _PythonPrinter(NumPyPrinter):
    """numpy is called np; steps are 1 at their time; all numbers are doubles."""

    def doprint(self, expr) -> str:
        return super().doprint(expr).replace("numpy.", "np.")

    def _print_Heaviside(self, expr) -> str:
        return f"np.heaviside({self._print(expr.args[0])}, 1.0)"

    def _print_Float(self, expr) -> str:
        return repr(float(expr))


def python_source(x, names: Sequence[str] | None = None) -> str:
    """x(t) as the source of a module with one function x(t, m=10.0, ...) -> array (r, T), (r,) for a number t.

    Dirac impulses are listed in the docstring; they are not in the values.

    >>> import sympy
    >>> t, k = sympy.symbols("t k", positive=True)
    >>> scope = {}
    >>> exec(python_source(ClosedForm(("x1",), (k * t,), t)), scope)
    >>> scope["x"]([0.0, 2.0], 3.0)
    array([[0., 6.]])
    """
    form = ClosedForm.of(x, names)
    source, printer = _source_of(form), _PythonPrinter()
    lines = [f"    {symbol.name} = {_in_python(printer.doprint(value), 4)}" for symbol, value in source.steps]
    values = [
        f"        {_in_python(printer.doprint(value), 8)},  # {' '.join(name.split())}"
        for name, value in zip(form.names, source.values)
    ]
    body = [
        "    t = np.asarray(t, dtype=float)",
        *lines,
        "    values = [",
        *values,
        "    ]",
        "    return np.array([value + np.zeros_like(t) for value in values])",
    ]
    head = f'"""{_quotable(form.title or TITLE)}"""\n\nimport numpy as np\n\n\n'
    return head + "\n".join([f"def x({', '.join(_arguments(source))}):", _docstring(source), *body]) + "\n"


def _arguments(source: SourceCode) -> list[str]:
    without = [source.parameters[p.name] for p in source.form.parameters if p.value is None]
    return [
        "t",
        *without,
        *(f"{source.parameters[p.name]}={float(p.value)!r}" for p in source.form.parameters if p.value is not None),
    ]


def _docstring(source: SourceCode) -> str:
    rows = f"The coordinates at t > 0, one row each: {', '.join(source.form.names)}."
    lines = _remarks(source, [rows, *[""] * bool(source.parameters)])
    text = "\n".join(f"    {_quotable(line)}".rstrip() for line in lines)
    return f'    """{text.lstrip()}\n    """'


def _quotable(text: str) -> str:
    """A text that can stand in a docstring: it cannot end it."""
    return text.replace("\\", "/").replace('"', "'")


def _in_python(text: str, indent: int) -> str:
    """A long sum in parentheses."""
    if len(text) + indent <= WIDTH:
        return text
    between = "\n" + " " * (indent + 4)
    return f"({between}{between.join(_wrapped(text, indent + 4))}\n{' ' * indent})"
