"""A formula in the form that is real with the default values: cos(w t) with w^2 < 0 is written as cosh.

Symbols are positive and otherwise free, so that the sign of a discriminant such as 4 k m - c^2 may be open. The formula holds for
both signs, but with roots of negative numbers in it; programs need the one without.
"""

from __future__ import annotations

from dataclasses import replace

import sympy

from ...ground.errors import InputError
from ..symbolic.response.inverse_transform import divisors_of
from .closed_form import DIGITS, ClosedForm
from .formula_text import TextPrinter
from .printing_layout import decimal, terms_of

ADVICE = "insert numbers for the symbols (mbconstrained formula --numbers), or give other default values"


#: When the formula is looked at with the default values: any t > 0 does.
SOME_TIME = sympy.Rational(7, 10)

_INFINITE = (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)


def real_form(form: ClosedForm) -> ClosedForm:
    """The formula without roots of numbers that are negative with the default values, and the expressions that must stay positive.

    >>> t, k, c = sympy.symbols("t k c", positive=True)
    >>> form = ClosedForm.of(ClosedForm(("x",), (sympy.cos(sympy.sqrt(k - c) * t),), t), parameters={k: 1, c: 2})
    >>> real_form(form).values, real_form(form).positive
    ((exp(t*sqrt(c - k))/2 + exp(-t*sqrt(c - k))/2,), (c - k,))
    """
    form = with_needed_assumptions(form)
    _check_defaults(form)
    turned = _turned(form)
    changed = form.mapped(lambda expression: _real(expression, turned))
    changed = replace(changed, positive=_open_signs(changed))
    return replace(changed, values=tuple(_decaying(value, changed) for value in changed.values)) if turned else changed


def _check_defaults(form: ClosedForm) -> None:
    """Whether the formula holds and is finite with the default values, as far as all symbols have one."""
    text_of = TextPrinter(form).doprint
    for expression in form.assumptions:
        if _vanishes(form.at_defaults(expression)):
            raise InputError(
                f"with the default values {text_of(expression)} is 0, where the formula with symbols does not hold (zeros coincide, "
                f"or the equations change their structure); {ADVICE}"
            )
    for expression in divisors_of(form.quantities, form.time):
        if _vanishes(form.at_defaults(expression)):
            raise InputError(f"with the default values {text_of(expression)} is 0, by which the formula divides; {ADVICE}")
    numbers = [form.at_defaults(each).xreplace({form.time: SOME_TIME}) for each in form.quantities]
    if any(number.has(*_INFINITE) or number.evalf(DIGITS).has(*_INFINITE) for number in numbers):
        raise InputError(f"with the default values the formula is not finite; {ADVICE}")


def _vanishes(value: sympy.Expr) -> bool:
    return decimal(value, DIGITS) == 0


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
    if not turned:
        return expression
    value = expression.xreplace(turned)
    if value.has(sympy.I):
        value = sympy.expand_mul(value)
    if value.has(sympy.I):
        value = sympy.expand(value)
    if value.has(sympy.I):
        raise InputError(f"with the default values the formula has complex parts; {ADVICE}")
    return value


def _decaying(value: sympy.Expr, form: ClosedForm) -> sympy.Expr:
    """e^{r t} cosh(w t) as two exponentials: neither overflows where their sum decays, and the slow one does not cancel."""
    total = sympy.S.Zero
    for term in terms_of(value, form.time):
        hyperbolic = [part for part in sympy.Mul.make_args(term.function) if isinstance(part, (sympy.cosh, sympy.sinh))]
        alone = len(hyperbolic) == 1 and not (hyperbolic[0].args[0] / form.time).has(form.time)
        function = _exponentials(term.function, hyperbolic[0], form) if alone else term.function
        total += term.coefficient * function
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


def _open_signs(form: ClosedForm) -> tuple[sympy.Expr, ...]:
    bases = (root.base for root in _roots(form.values, form) if root.base.free_symbols)
    return tuple(dict.fromkeys(base for base in bases if form.at_defaults(base).is_number))


def with_needed_assumptions(form: ClosedForm) -> ClosedForm:
    """The formula without the assumptions that only coordinates need that are not in it.

    For values of the parameters where A(s) stays regular, X(s) = A(s)^-1 b(s) is continuous in them, and so is the transform
    of a formula that does not divide by the assumption: they stay equal there.

    >>> a, b, t = sympy.symbols("a b t", positive=True)
    >>> form = ClosedForm(("x",), (t / (a - b),), t, assumptions=(a - b, a - 2 * b))
    >>> with_needed_assumptions(form).assumptions
    (a - b,)
    """
    below = divisors_of(form.quantities, form.time)
    return replace(form, assumptions=tuple(each for each in form.assumptions if any(_meets(each, other) for other in below)))


def _meets(assumption: sympy.Expr, divisor: sympy.Expr) -> bool:
    """Whether the divisor may vanish where the assumption does: they share a factor, or there are roots in it, where this cannot be decided."""
    if not assumption.free_symbols & divisor.free_symbols:
        return False
    if any(not power.exp.is_Integer for power in divisor.atoms(sympy.Pow)):
        return True
    return bool(sympy.gcd(assumption, divisor).free_symbols)
