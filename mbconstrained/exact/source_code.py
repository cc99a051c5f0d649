"""A formula as the source of a function in C and in Python: its form without complex roots, identifiers, numbers, common subexpressions, printers."""

from __future__ import annotations

import keyword
import re
import textwrap
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import combinations

import sympy
from sympy.printing.c import C99CodePrinter, reserved_words
from sympy.printing.numpy import NumPyPrinter

from ..ground.errors import InputError
from .closed_form import DIGITS, ClosedForm, FormulaParameter, Layout, decimal, terms_of
from .formula_printers import TextPrinter, ascii_letters
from .symbolic.symbolic_response import divisors_of

# The form that is real with the default values: cos(w t) with w^2 < 0 is written as cosh.
#
# Symbols are positive and otherwise free, so that the sign of a discriminant such as 4 k m - c^2 may be open. The formula holds for
# both signs, but with roots of negative numbers in it; programs need the one without.

ADVICE = "insert numbers for the symbols (mbconstrained formula --numbers), or give other default values"

#: When the formula is looked at with the default values: any t > 0 does.
SOME_TIME = sympy.Rational(7, 10)

_INFINITE = (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)


def real_form(form: ClosedForm) -> ClosedForm:
    """The formula without roots of numbers that are negative with the default values, and the expressions that must stay positive."""
    form = with_needed_assumptions(form)
    _check_defaults(form)
    turned = _turned(form)
    changed = form.mapped(lambda expression: _real(expression, turned))
    bases = dict.fromkeys(root.base for root in _roots(changed.values, changed) if root.base.free_symbols)
    changed = replace(changed, positive=tuple(base for base in bases if changed.at_defaults(base).is_number))
    return replace(changed, values=tuple(_decaying(value, changed) for value in changed.values)) if turned else changed


def _check_defaults(form: ClosedForm) -> None:
    """Whether the formula holds and is finite with the default values, as far as all symbols have one."""
    text_of = TextPrinter(form).doprint
    for expression in form.assumptions:
        if decimal(form.at_defaults(expression), DIGITS) == 0:
            raise InputError(
                f"with the default values {text_of(expression)} is 0, where the formula with symbols does not hold (zeros coincide, "
                f"or the equations change their structure); {ADVICE}"
            )
    for expression in divisors_of(form.quantities, form.time):
        if decimal(form.at_defaults(expression), DIGITS) == 0:
            raise InputError(f"with the default values {text_of(expression)} is 0, by which the formula divides; {ADVICE}")
    numbers = [form.at_defaults(each).xreplace({form.time: SOME_TIME}) for each in form.quantities]
    if any(number.has(*_INFINITE) or number.evalf(DIGITS).has(*_INFINITE) for number in numbers):
        raise InputError(f"with the default values the formula is not finite; {ADVICE}")


def _roots(expressions, form: ClosedForm) -> list[sympy.Pow]:
    """Square roots of what depends on symbols and is not positive for all."""
    powers = set().union(*(expression.atoms(sympy.Pow) for expression in expressions))
    odd = [root for root in powers if root.exp.is_Rational and root.exp.q == 2 and not root.base.is_positive]
    return sorted((root for root in odd if not root.base.has(form.time)), key=sympy.default_sort_key)


def _turned(form: ClosedForm) -> dict[sympy.Expr, sympy.Expr]:
    """Roots of what is negative with the default values, as i times the root of minus that."""
    replaced = {}
    for root in _roots(form.quantities, form):
        value = form.at_defaults(root.base)
        if not value.is_number:
            continue
        real, imaginary = value.evalf(DIGITS).as_real_imag()
        if abs(imaginary) > abs(real) * sympy.Float(10) ** -(DIGITS - 10):
            raise InputError(
                f"with the default values the root of {root.base} is complex, for which this formula does not hold; {ADVICE}"
            )
        if real < 0:
            replaced[root] = (sympy.I * sympy.sqrt(-root.base)) ** (2 * root.exp)
    return replaced


def _real(expression: sympy.Expr, turned: dict) -> sympy.Expr:
    value = expression.xreplace(turned) if turned else expression
    for expanded in (sympy.expand_mul, sympy.expand) if turned else ():
        value = expanded(value) if value.has(sympy.I) else value
    if turned and value.has(sympy.I):
        raise InputError(f"with the default values the formula has complex parts; {ADVICE}")
    return value


def _decaying(value: sympy.Expr, form: ClosedForm) -> sympy.Expr:
    """e^{r t} cosh(w t) as two exponentials: neither overflows where their sum decays, and the slow one does not cancel."""
    total = sympy.S.Zero
    for term in terms_of(value, form.time):
        hyperbolic = [part for part in sympy.Mul.make_args(term.function) if isinstance(part, (sympy.cosh, sympy.sinh))]
        alone = len(hyperbolic) == 1 and not (hyperbolic[0].args[0] / form.time).has(form.time)
        total += term.coefficient * (_exponentials(term.function, hyperbolic[0], form) if alone else term.function)
    return total


def _exponentials(function: sympy.Expr, hyperbolic: sympy.Expr, form: ClosedForm) -> sympy.Expr:
    """(e^{(r+w) t} +- e^{(r-w) t})/2, the rate nearer to 0 as (r^2 - w^2)/(r -+ w)."""
    t, w = form.time, hyperbolic.args[0] / form.time
    factors = [part for part in sympy.Mul.make_args(function) if part != hyperbolic]
    exponential = next((part for part in factors if isinstance(part, sympy.exp)), sympy.S.One)
    r = exponential.args[0] / t if exponential != 1 else sympy.S.Zero
    rest = sympy.Mul(*(part for part in factors if part != exponential))
    product = sympy.factor(sympy.expand(r**2 - w**2))
    upper, lower = r + w, r - w
    if r != 0 and (form.at_defaults(r) < 0) == (form.at_defaults(w) > 0):
        upper = -product / (w - r)
    elif r != 0:
        lower = product / upper
    sign = 1 if isinstance(hyperbolic, sympy.cosh) else -1
    return rest * (sympy.exp(upper * t) + sign * sympy.exp(lower * t)) / 2


def with_needed_assumptions(form: ClosedForm) -> ClosedForm:
    """The formula without assumptions by which it does not divide: where A(s) stays regular, X(s) is continuous in the parameters, and so is the formula."""
    below = divisors_of(form.quantities, form.time)
    return replace(form, assumptions=tuple(each for each in form.assumptions if any(_meets(each, other) for other in below)))


def _meets(assumption: sympy.Expr, divisor: sympy.Expr) -> bool:
    """Whether the divisor may vanish where the assumption does: they share a factor, or there are roots in it, where this cannot be decided."""
    if not assumption.free_symbols & divisor.free_symbols:
        return False
    if any(not power.exp.is_Integer for power in divisor.atoms(sympy.Pow)):
        return True
    return bool(sympy.gcd(assumption, divisor).free_symbols)


# Names of others as identifiers of Python and C: valid, distinct, and never more than names.

#: Words of C beyond those of sympy's printer: C99, C23, and common extensions of compilers.
C_KEYWORDS = frozenset(reserved_words) | set(
    "asm bool complex false fortran imaginary inline linux main nullptr restrict true typeof unix".split()
)
#: Names of math.h, which a variable would hide.
C_NAMES = frozenset(
    "acos asin atan atan2 cos sin tan acosh asinh atanh cosh sinh tanh exp exp2 expm1 frexp ilogb ldexp log log10 log1p log2 logb "
    "modf cbrt fabs hypot pow sqrt erf erfc lgamma tgamma ceil floor nearbyint rint round trunc fmod remainder nan fdim fmax fmin "
    "fma j0 j1 jn y0 y1 yn gamma signgam div abs labs NAN INFINITY HUGE HUGE_VAL HUGE_VALF HUGE_VALL MATH_ERRNO MATH_ERREXCEPT "
    "OVERFLOW UNDERFLOW DOMAIN SING PLOSS TLOSS MAXFLOAT X_TLOSS".split()
)
C_MACROS = re.compile(r"(M|FP)_[A-Z0-9_]+")  # M_E, M_PI, FP_NAN, … of math.h
PYTHON_NAMES = frozenset(("np", "t", "x", "value", "values"))
AMBIGUOUS = frozenset("lIO")  # which look like 1 and 0


def identifiers(names: Iterable[str], reserved: Iterable[str] = ()) -> dict[str, str]:
    """An identifier of both Python and C for each name, each different from the others and from the reserved ones."""
    names, used, chosen = list(dict.fromkeys(names)), set(reserved), {}
    for name in sorted(names, key=lambda name: identifier(name) != name):  # valid names are kept
        own = identifier(name)
        tries = (own, *(f"{own.rstrip('_')}_{number}" for number in range(2, len(names) + len(used) + 3)))
        chosen[name] = next(each for each in tries if each not in used)
        used.add(chosen[name])
    return {name: chosen[name] for name in names}


def identifier(name: str) -> str:
    text = re.sub(r"[^A-Za-z0-9]+", "_", "".join(map(ascii_letters, name))).lstrip("_")
    text = text.rstrip("_") + ("_" if name.endswith("_") and text else "")
    if not text or text[0].isdigit():
        text = f"v{text}"
    reserved = keyword.iskeyword(text) or keyword.issoftkeyword(text) or text in C_KEYWORDS | C_NAMES | PYTHON_NAMES | AMBIGUOUS
    return f"{text}_" if reserved or C_MACROS.fullmatch(text) else text


# Expressions ready to be printed as a program.

#: Whole numbers up to this are exact in a double.
LARGEST_WHOLE = 2**53

#: Digits of decimals in a source: three more than a double holds, so that it is rounded once.
SOURCE_DIGITS = 20

TITLE = "The motion in closed form."

#: Characters in a line.
WIDTH = 100


@dataclass(frozen=True)
class SourceCode:
    """The identifiers of parameters in their order, (identifier, expression) one after the other, and values of the coordinates."""

    form: ClosedForm
    parameters: dict[str, str]
    steps: tuple[tuple[sympy.Symbol, sympy.Expr], ...]
    values: tuple[sympy.Expr, ...]

    @classmethod
    def of(cls, form: ClosedForm) -> SourceCode:
        """Identifiers for symbols, short numbers, common subexpressions."""
        named = identifiers([p.name for p in form.parameters])
        symbols = {p.symbol: sympy.Symbol(named[p.name], real=True) for p in form.parameters}
        symbols[form.time] = sympy.Symbol("t", real=True)
        stable = {below: with_square(below) for below in divisors_of(form.quantities, form.time) if below.is_Add}
        values = [_short(value.xreplace(stable)).xreplace(symbols) for value in form.values]
        fresh = sympy.numbered_symbols("c", exclude=[sympy.Symbol(name, real=True) for name in named.values()], real=True)
        steps, reduced = sympy.cse(values, symbols=fresh, optimizations="basic", order="none")
        return cls(form, named, tuple(steps), tuple(reduced))

    def remarks(self, first: list[str]) -> list[str]:
        """Lines of a comment: the first ones, the parameters, and the jumps, impulses and assumptions."""
        printer, statements = TextPrinter(self.form), Layout(self.form, [], [], None).statements
        after = {"jumps": "", "impulses": ", which is not in the values", "assumptions": "", "positive": ""}
        notes = [printer.statement(parts) + end for kind, end in after.items() for parts in statements[kind]]
        lines = [*first, *(_described(self.parameters[p.name], p) for p in self.form.parameters), *[""] * bool(notes), *notes]
        return [part for line in lines for part in textwrap.wrap(line, WIDTH, subsequent_indent="    ") or [""]]


def _short(value: sympy.Expr) -> sympy.Expr:
    """Fractions of long numbers as decimals, which is what a double makes of them anyway."""
    long = {q: sympy.Float(q, SOURCE_DIGITS) for q in value.atoms(sympy.Rational) if max(abs(q.p), q.q) > LARGEST_WHOLE}
    floats = {f: sympy.Float(f, SOURCE_DIGITS) for f in value.atoms(sympy.Float)}
    return value.xreplace({**long, **floats})


def with_square(total: sympy.Expr) -> sympy.Expr:
    """u^2 - 2 u v + v^2 + rest as (u - v)^2 + rest, where nothing is subtracted in the rest: a divisor near resonance keeps its digits."""
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


def c_source(form: ClosedForm) -> str:
    """x(t) as a C function x(t, m, ..., values), C99 and later, and x_default(t, values) with default values; Dirac impulses are in the comment alone."""
    source, printer, count = SourceCode.of(form), _CPrinter(), len(form.values)

    def written(value: sympy.Expr) -> str:
        text = printer.doprint(value)
        return text if len(text) + 24 <= WIDTH else "\n        ".join(_wrapped(text, 8))

    remarks = source.remarks([form.title or TITLE, "", *(f"values[{row}]: {name}" for row, name in enumerate(form.names))])
    quotable = (line.replace("*/", "* /").replace("/*", "/ *").replace("\\", "/").replace("??", "? ?") for line in remarks)
    comment = "\n".join(["/*", *(f" * {line}".rstrip() for line in quotable), " */"])  # no name can end it, nor join lines
    arguments = ", ".join(["double t", *(f"double {name}" for name in source.parameters.values()), f"double values[{count}]"])
    lines = [f"    const double {symbol.name} = {written(value)};" for symbol, value in source.steps]
    lines += [f"    values[{row}] = {written(value)};" for row, value in enumerate(source.values)]
    used = set().union(*(v.free_symbols for v in source.values), *(v.free_symbols for _, v in source.steps))
    names_used = {symbol.name for symbol in used}
    unused = [f"    (void){name};" for name in ("t", *source.parameters.values()) if name not in names_used]
    values = [p.value for p in form.parameters]
    declarations, defaults = [f"void x({arguments});"], []
    if values and None not in values:
        head = f"void x_default(double t, double values[{count}])"
        call = ", ".join(["t", *(repr(float(value)) for value in values), "values"])
        declarations, defaults = [*declarations, f"{head};"], ["", f"{head}\n{{\n    x({call});\n}}"]
    parts = [comment, "#include <math.h>\n", *declarations, "", f"void x({arguments})\n{{", *unused, *lines, "}", *defaults]
    return "\n".join(parts) + "\n"


# A formula as a Python function of NumPy.


class _PythonPrinter(NumPyPrinter):
    """numpy is called np; steps are 1 at their time; all numbers are doubles."""

    def doprint(self, expr) -> str:
        return super().doprint(expr).replace("numpy.", "np.")

    def _print_Heaviside(self, expr) -> str:
        return f"np.heaviside({self._print(expr.args[0])}, 1.0)"

    def _print_Float(self, expr) -> str:
        return repr(float(expr))


def python_source(form: ClosedForm) -> str:
    """x(t) as a module with a function x(t, m=10.0, ...) -> array (r, T), (r,) for a number t; Dirac impulses are in its docstring alone."""
    source, printer = SourceCode.of(form), _PythonPrinter()

    def written(value: sympy.Expr, indent: int) -> str:  # a long sum in parentheses
        text = printer.doprint(value)
        if len(text) + indent <= WIDTH:
            return text
        between = "\n" + " " * (indent + 4)
        return f"({between}{between.join(_wrapped(text, indent + 4))}\n{' ' * indent})"

    def quotable(text: str) -> str:  # it cannot end a docstring
        return text.replace("\\", "/").replace('"', "'")

    named = [(source.parameters[p.name], p.value) for p in form.parameters]
    arguments = ["t", *(n for n, v in named if v is None), *(f"{n}={float(v)!r}" for n, v in named if v is not None)]
    rows = f"The coordinates at t > 0, one row each: {', '.join(form.names)}."
    remarks = source.remarks([rows, *[""] * bool(source.parameters)])
    docstring = "\n".join(f"    {quotable(line)}".rstrip() for line in remarks).lstrip()
    lines = [
        f'"""{quotable(form.title or TITLE)}"""\n\nimport numpy as np\n\n',
        f"def x({', '.join(arguments)}):",
        f'    """{docstring}\n    """',
        "    t = np.asarray(t, dtype=float)",
        *(f"    {symbol.name} = {written(value, 4)}" for symbol, value in source.steps),
        "    values = [",
        *(f"        {written(value, 8)},  # {' '.join(name.split())}" for name, value in zip(form.names, source.values)),
        "    ]",
        "    return np.array([value + np.zeros_like(t) for value in values])",
    ]
    return "\n".join(lines) + "\n"
