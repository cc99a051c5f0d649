"""A formula in the form that is real with the default values: cos(w t) with w^2 < 0 is written as cosh.

Symbols are positive and otherwise free, so that the sign of a discriminant such as 4 k m - c^2 may be open. The formula holds for
both signs, but with roots of negative numbers in it; programs need the one without.
"""

from __future__ import annotations

from dataclasses import replace

import sympy

from ...errors import InputError
from .closed_form import DIGITS, ClosedForm
from .divisors import divisors, with_needed_assumptions
from .plain_text import text_printer
from .terms import decimal, terms_of

ADVICE = "insert numbers for the symbols (mbconstrained formula --numbers), or give other default values"


#: When the formula is looked at with the default values: any t > 0 does.
SOME_TIME = sympy.Rational(7, 10)

_INFINITE = (sympy.nan, sympy.zoo, sympy.oo, -sympy.oo)


def real_form(form: ClosedForm) -> ClosedForm:
    """The same formula, free of roots of numbers that are negative with the default values, and what must stay positive.

    Raises:
        InputError: with the default values an assumption fails, so that the formula does not hold for them, or it is not
            finite there, or a root is complex.

    >>> t, k, c = sympy.symbols("t k c", positive=True)
    >>> form = ClosedForm.of(ClosedForm(("x",), (sympy.cos(sympy.sqrt(k - c) * t),), t), parameters={k: 1, c: 2})
    >>> real_form(form).values, real_form(form).positive
    ((exp(t*sqrt(c - k))/2 + exp(-t*sqrt(c - k))/2,), (c - k,))
    """
    form = with_needed_assumptions(form)
    _check_defaults(form)
    turned = _turned([*form.values, *(each.factor for each in form.impulses), *(each.size for each in form.jumps)], form)
    changed = replace(
        form,
        values=tuple(_real(value, turned) for value in form.values),
        impulses=tuple(replace(each, factor=_real(each.factor, turned)) for each in form.impulses),
        jumps=tuple(replace(each, size=_real(each.size, turned)) for each in form.jumps),
    )
    changed = replace(changed, positive=_open_signs(changed))
    return replace(changed, values=tuple(_decaying(value, changed) for value in changed.values)) if turned else changed


def _check_defaults(form: ClosedForm) -> None:
    """Whether the formula holds and is finite with the default values, as far as all symbols have one."""
    tell = text_printer(form).doprint
    for expression in form.assumptions:
        if _vanishes(form.at_defaults(expression)):
            raise InputError(
                f"with the default values {tell(expression)} is 0, where the formula with symbols does not hold (zeros coincide, "
                f"or the equations change their structure); {ADVICE}"
            )
    for expression in divisors(form):
        if _vanishes(form.at_defaults(expression)):
            raise InputError(f"with the default values {tell(expression)} is 0, by which the formula divides; {ADVICE}")
    later = {form.time: SOME_TIME}
    numbers = [form.at_defaults(value).xreplace(later) for value in form.values]
    numbers += [form.at_defaults(each) for each in (*(i.factor for i in form.impulses), *(j.size for j in form.jumps))]
    if any(number.has(*_INFINITE) or number.evalf(DIGITS).has(*_INFINITE) for number in numbers):
        raise InputError(f"with the default values the formula is not finite; {ADVICE}")


def _vanishes(value: sympy.Expr) -> bool:
    return decimal(value, DIGITS) == 0


def _roots(expressions, form: ClosedForm) -> list[sympy.Pow]:
    """Square roots of what depends on symbols and is not positive for all."""
    found = set().union(*(expression.atoms(sympy.Pow) for expression in expressions))
    odd = [root for root in found if root.exp.is_Rational and root.exp.q == 2 and not root.base.is_positive]
    return sorted((root for root in odd if not root.base.has(form.time)), key=sympy.default_sort_key)


def _turned(expressions, form: ClosedForm) -> dict[sympy.Expr, sympy.Expr]:
    """Roots of what is negative with the default values, as i times the root of minus that."""
    found = {}
    for root in _roots(expressions, form):
        value = form.at_defaults(root.base)
        if not value.is_number:
            continue
        real, imaginary = value.evalf(DIGITS).as_real_imag()
        if abs(imaginary) > abs(real) * sympy.Float(10) ** -(DIGITS - 10):
            raise InputError(
                f"with the default values the root of {root.base} is complex, which this formula is not made for; {ADVICE}"
            )
        if real < 0:
            found[root] = (sympy.I * sympy.sqrt(-root.base)) ** (2 * root.exp)
    return found


def _real(expression: sympy.Expr, turned: dict) -> sympy.Expr:
    if not turned:
        return expression
    found = expression.xreplace(turned)
    if found.has(sympy.I):
        found = sympy.expand_mul(found)
    if found.has(sympy.I):
        found = sympy.expand(found)
    if found.has(sympy.I):
        raise InputError(f"with the default values the formula has complex parts; {ADVICE}")
    return found


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
