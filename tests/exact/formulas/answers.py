"""Formulas that several tests print: hand-made ones, and answers with symbols."""

import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import sympy

from mbconstrained.exact.closed_form import ClosedForm, FormulaParameter
from mbconstrained.exact.source_code import c_source, python_source
from mbconstrained.exact.symbolic.fields import exact_expression
from mbconstrained.exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix
from mbconstrained.exact.symbolic.symbolic_response import solve_symbolically

t = sympy.Symbol("t", real=True)
m, k, c = sympy.symbols("m k c", positive=True)
HOSTILE = ("lambda", "I", "left joint", "θ'", "a</math><script>", "x*/", '"""', "π")


def damped(**defaults) -> ClosedForm:
    """m x'' + c x' + k x = 0 from x = 1."""
    x = solve_symbolically(SymbolicPolynomialMatrix([[[k]], [[c]], [[m]]]), [[1], [0]], time=t)
    return with_values(ClosedForm.of(x), {sympy.Symbol(name, positive=True): value for name, value in defaults.items()})


def with_values(form: ClosedForm, values: dict) -> ClosedForm:
    """The formula with default values by symbol."""
    return replace(
        form, parameters=tuple(FormulaParameter(s, s.name, exact_expression(value, s.name)) for s, value in values.items())
    )


def hostile() -> ClosedForm:
    """Coordinates and parameters with names that mean something elsewhere."""
    symbols = [sympy.Symbol(name, positive=True) for name in HOSTILE]
    values = tuple(symbol * t + number for number, symbol in enumerate(symbols))
    return with_values(ClosedForm(HOSTILE, values, t), {symbol: number + 2 for number, symbol in enumerate(symbols)})


def python_values(form: ClosedForm, times, *arguments) -> np.ndarray:
    """What the Python source computes."""
    scope: dict = {}
    exec(compile(python_source(form), "formula.py", "exec"), scope)  # our own text, which is what is tested
    return scope["x"](times, *arguments)


def c_values(form: ClosedForm, times, folder: Path, standard: str = "c99") -> np.ndarray:
    """What the C source computes with the default values."""
    count = len(form.values)
    call = "x_default(t, v)" if form.parameters else "x(t, v)"
    main = f"""
#include <stdio.h>
int main(void)
{{
    double t, v[{count}];
    while (scanf("%lf", &t) == 1) {{
        {call};
        for (int i = 0; i < {count}; i++) printf("%.17g ", v[i]);
    }}
    return 0;
}}
"""
    (folder / "formula.c").write_text(c_source(form) + main, encoding="utf-8")
    command = ["gcc", f"-std={standard}", "-O1", "-Wall", "-Wextra", "-pedantic", "-Werror", "formula.c", "-o", "formula", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    said = subprocess.run(
        [folder / "formula"], input=" ".join(map(repr, map(float, times))), capture_output=True, text=True, check=True
    )
    return np.array(said.stdout.split(), dtype=float).reshape(len(times), count).T
