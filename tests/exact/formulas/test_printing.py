"""Text, LaTeX and MathML: what people read says what the expression says."""

import re
import xml.etree.ElementTree as xml

import pytest
import sympy

from mbconstrained.exact.closed_form import ClosedForm, Impulse, Jump, terms_of
from mbconstrained.exact.formula_printers import formula_text, latex, mathml, records
from mbconstrained.exact.symbolic_equations import Symbols
from mbconstrained.ground.errors import InputError
from tests.exact.formulas.answers import HOSTILE, damped, hostile, k, m, t, with_values

w = sympy.sqrt(k / m)
OSCILLATOR = with_values(
    ClosedForm(("x1",), (sympy.cos(2 * w * t) / 2 - (1 - w) * sympy.sin(2 * w * t) + 3,), t), {m: 10.0, k: 2.5}
)


def read_back(text: str, names: dict) -> sympy.Expr:
    """Our own plain text as an expression: blanks are products, ^ powers."""
    from sympy.parsing.sympy_parser import implicit_multiplication, parse_expr, standard_transformations

    return parse_expr(text.replace("^", "**"), names, (*standard_transformations, implicit_multiplication))


def test_text_says_what_the_expression_says():
    formula, shorthand = formula_text(OSCILLATOR).split("\n\n")
    names = {"m": m, "k": k, "t": t, "w1": read_back(shorthand.partition(" = ")[2], {"m": m, "k": k})}
    found = read_back(formula.partition(" = ")[2], names)
    assert sympy.simplify(found - OSCILLATOR.values[0]) == 0
    assert formula.startswith("x1(t) = 3 + 1/2 cos(w1 t)")


@pytest.mark.parametrize("c", [0.5, 30.0])
def test_the_text_of_an_answer_says_what_the_answer_says(c):
    form = damped(m=2.0, k=3.0, c=c)
    blocks = formula_text(form).split("\n\n")
    names = {"m": m, "k": k, "t": t, "c": sympy.Symbol("c", positive=True)}
    for line in reversed(blocks[1].splitlines()):
        name, _, value = line.partition(" = ")
        names[name] = read_back(value, names)
    found = read_back(" ".join(blocks[0].split()).partition(" = ")[2], names)
    values = {**form.defaults, t: sympy.Rational(7, 5)}
    assert abs(complex((found - form.values[0]).subs(values).evalf(30))) < 1e-25


def test_numbers_are_put_in_with_so_many_digits():
    assert formula_text(OSCILLATOR, digits=4) == "x1(t) = 3 + 0.5 cos(t) - 0.5 sin(t)"
    assert formula_text(ClosedForm(("x",), (sympy.sqrt(2) * t,), t), digits=3) == "x(t) = 1.41 t"


def test_happenings_and_conditions_are_told():
    start = sympy.Symbol("x1_1", real=True)
    form = ClosedForm(
        ("x1",), (t,), t, impulses=(Impulse("x1", 0, k - m, sympy.Integer(2)),), jumps=(Jump("x1", 1, m),),
        admissible=(sympy.Eq(start, k),), continuous=(sympy.Eq(start, 0),), assumptions=(k - m,), positive=(m - 2 * k,),
    )  # fmt: skip
    text = formula_text(form)
    for line in (
        "x1' jumps at t = 0 by m",
        "x1 has the impulse (k - m) δ(t - 2)",
        "no impulses if x1'(0-) = k",
        "no jumps if x1'(0-) = 0",
        "holds where k - m is not 0",
        "real in this form where -2 k + m > 0",
    ):
        assert line in text
    found = records(form)
    assert found["impulses"] == [{"of": "x1", "order": 0, "time": "2", "factor": "k - m"}]
    assert r"\dot{x}_{1}(0^-) = k" in latex(form) and r"\delta(t - 2)" in latex(form)
    assert len(mathml(form)) == 7


@pytest.mark.parametrize("form", [OSCILLATOR, hostile(), damped(m=2.0, k=3.0, c=0.5)])
def test_mathml_is_well_formed_and_nothing_but_mathml(form):
    for line in mathml(form):
        tree = xml.fromstring(line.replace("&InvisibleTimes;", "&#x2062;"))
        kinds = {element.tag for element in tree.iter()}
        assert kinds <= {
            "math",
            "mtable",
            "mtr",
            "mtd",
            "mrow",
            "mi",
            "mn",
            "mo",
            "mfrac",
            "msqrt",
            "msup",
            "msub",
            "msubsup",
            "mtext",
            "mover",
            "mspace",
        }
    texts = "".join("".join(xml.fromstring(line.replace("&InvisibleTimes;", "")).itertext()) for line in mathml(form))
    assert all(re.sub(r"[_\d]", "", name) in texts for name in form.names if name not in ("lambda",))


def test_latex_cannot_be_broken_out_of():
    text = latex(ClosedForm((r"a}\input{b", "x_1 & y", r"50 %\\"), (t, t, t), t))
    assert r"\input{" not in text.replace(r"\backslash{}input", "")
    assert text.count("&=") == 3 and text.count("%") == text.count(r"\%") == 1
    body = text.removeprefix("\\begin{align*}").removesuffix("\\end{align*}").replace(r"\{", "").replace(r"\}", "")
    assert body.count("{") == body.count("}")


def test_matplotlib_sets_the_latex(tmp_path):
    """Its mathtext knows a part of LaTeX: each row of the environment by itself."""
    from matplotlib.mathtext import MathTextParser

    for row in latex(OSCILLATOR).removeprefix("\\begin{align*}").removesuffix("\\end{align*}").split("\\\\"):
        MathTextParser("path").parse(f"${row.replace('&', '').strip()}$")


@pytest.mark.parametrize("value", [1 / m, -1 / m, 1 / (k + m), m**-2])
def test_reciprocals_are_printed(value):
    form = ClosedForm(("x",), (value,), t)
    assert r"\frac{" in latex(form) and "<mfrac>" in mathml(form)[0]
    assert records(form)["formulas"]["x"]["text"] == formula_text(form)


def test_of_late_terms_only_the_slope_has_a_name():
    T, rate = sympy.Symbol("T", positive=True), sympy.sqrt(k / m - 1) / 4
    form = ClosedForm(("x",), (sympy.cos(rate * (t - T)) * sympy.exp(-(rate**2) * (t - T)) * sympy.Heaviside(t - T),), t)
    text = formula_text(form)
    assert text.startswith("x(t) = exp(-a1 (t - T)) H(t - T) cos(w1 (t - T))")
    assert all(" t" not in line and "(t" not in line for line in text.split("\n\n")[1].splitlines())
    assert r"\cos{\left(w_{1} \left(t - T\right) \right)}" in latex(form)


def test_late_terms_in_numbers_are_one_number_times_a_function():
    late = sympy.exp(-(t - sympy.Rational(1, 2)) / 4) * sympy.cos(7 * sympy.sqrt(3) * (t - sympy.Rational(1, 2)) / 4)
    assert formula_text(ClosedForm(("x",), (3 * late,), t), digits=4) == "x(t) = 3.399 exp(-0.25 t) cos(3.031 t - 1.516)"


@pytest.mark.parametrize("name", ["ü", "größe", "θ links", "é_1", "名"])
def test_latex_has_letters_beyond_ascii_only_as_text(name):
    text = latex(ClosedForm((name,), (sympy.Symbol(name) * t,), t))
    assert re.sub(r"\\text\{[^{}]*\}", "", text).isascii()


def test_only_some_coordinates():
    form = hostile()
    assert form.only(["I", "lambda"]).names == ("I", "lambda")
    assert form.only(["I"]).values == (form.values[HOSTILE.index("I")],)
    with pytest.raises(InputError, match='there is no coordinate "z"'):
        form.only(["z"])


def test_terms_add_up_to_the_expression():
    expression = (t + k) ** 2 * sympy.exp(-t) * (sympy.cos(m * t) + 2) - 5 * t**3 + k
    assert sympy.expand(sum(term.expression for term in terms_of(expression, t)) - expression) == 0


NAMES = ("π", "s", "s_", "x_0", "k", "k_")


def test_no_name_is_another():
    symbols = Symbols(dict.fromkeys(NAMES, 1.0))
    engine = {symbol for name in NAMES for symbol in symbols._engine[name].free_symbols}
    assert len(engine) == len(NAMES)
    assert not {symbol.name for symbol in engine} & {*NAMES, "t", "pi", symbols.pi.name}


def test_names_come_back_with_their_signs():
    symbols = Symbols({"π": 2.0, "s": -3.0})
    inner, negative = symbols._engine["π"], symbols._engine["s"]
    found = symbols.finished(ClosedForm(("x",), (inner * symbols.pi + negative * symbols.time,), symbols.time))
    values = {**found.defaults, symbols.time: sympy.Integer(5)}
    assert [p.name for p in found.parameters] == ["π", "s"]
    assert found.values[0].xreplace(values) == 2 * sympy.pi - 15
