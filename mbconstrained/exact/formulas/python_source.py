"""A formula as a Python function of NumPy."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence

from sympy.printing.numpy import NumPyPrinter

from .closed_form import ClosedForm
from .source import Source, default_text, source_of, told

WIDTH = 100


class _Printer(NumPyPrinter):
    """numpy is called np; sums are written term by term."""

    _module = "np"

    def __init__(self):
        super().__init__({"fully_qualified_modules": True})
        self.known_functions = {name: path.replace("numpy.", "np.", 1) for name, path in self.known_functions.items()}
        self.known_constants = {name: path.replace("numpy.", "np.", 1) for name, path in self.known_constants.items()}

    def _print_Heaviside(self, expr) -> str:
        return f"np.heaviside({self._print(expr.args[0])}, 1.0)"

    def _print_Float(self, expr) -> str:
        return repr(float(expr))


def python_source(x, names: Sequence[str] | None = None) -> str:
    """x(t) as the source of a module with one function x(t, m=10.0, ...) -> array (r, T), (r,) for a number t.

    Dirac impulses are told in the docstring; they are not in the values.

    Args:
        x: a ``SymbolicResponse`` or a ``ClosedForm``. Parameters without a default value come first and without one.
        names: of the coordinates, where they are not to be called as in x.

    >>> import sympy
    >>> t, k = sympy.symbols("t k", positive=True)
    >>> scope = {}
    >>> exec(python_source(ClosedForm(("x1",), (k * t,), t)), scope)
    >>> scope["x"]([0.0, 2.0], 3.0)
    array([[0., 6.]])
    """
    form = ClosedForm.of(x, names)
    source, printer = source_of(form), _Printer()
    lines = [f"    {symbol.name} = {_wrapped(printer.doprint(value), 4)}" for symbol, value in source.steps]
    values = [
        f"        {_wrapped(printer.doprint(value), 8)},  # {_comment(name)}" for name, value in zip(form.names, source.values)
    ]
    body = [
        "    t = np.asarray(t, dtype=float)",
        *lines,
        "    values = [",
        *values,
        "    ]",
        "    return np.array([value + np.zeros_like(t) for value in values])",
    ]
    head = f'"""{_quotable(form.title or "The motion in closed form.")}"""\n\nimport numpy as np\n\n\n'
    return head + "\n".join([f"def x({', '.join(_arguments(source))}):", _docstring(source), *body]) + "\n"


def _arguments(source: Source) -> list[str]:
    without = [source.parameters[p.name] for p in source.form.parameters if p.value is None]
    given = [f"{source.parameters[p.name]}={default_text(p.value)}" for p in source.form.parameters if p.value is not None]
    return ["t", *without, *given]


def _docstring(source: Source) -> str:
    form = source.form
    rows = ", ".join(form.names)
    lines = [f"The coordinates at t > 0, one row each: {rows}."]
    parameters = [f"{source.parameters[p.name]}: {_described(p, source)}" for p in form.parameters]
    if parameters:
        lines += ["", *parameters]
    notes = told(form)
    if notes:
        lines += ["", *notes]
    wrapped = [part for line in lines for part in textwrap.wrap(line, WIDTH, subsequent_indent="    ") or [""]]
    text = "\n".join(f"    {_quotable(line)}".rstrip() for line in wrapped)
    return f'    """{text.lstrip()}\n    """'


def _described(parameter, source: Source) -> str:
    called = f"{parameter.name}" if parameter.name != source.parameters[parameter.name] else "parameter"
    return f"{called}, in {parameter.unit}" if parameter.unit else called


def _quotable(text: str) -> str:
    """A text that can stand in a docstring: it cannot end it."""
    return text.replace("\\", "/").replace('"', "'")


def _comment(text: str) -> str:
    return " ".join(text.split())


def _wrapped(text: str, indent: int) -> str:
    """A long sum in parentheses, broken at its blanks."""
    if len(text) + indent <= WIDTH:
        return text
    inner = textwrap.wrap(text, WIDTH - indent - 4, break_long_words=False, break_on_hyphens=False)
    between = "\n" + " " * (indent + 4)
    return f"({between}{between.join(inner)}\n{' ' * indent})"
