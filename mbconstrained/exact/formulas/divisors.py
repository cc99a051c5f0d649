"""What a formula divides by, and which of the assumptions it needs for that."""

from __future__ import annotations

from dataclasses import replace

import sympy

from .closed_form import ClosedForm


def divisors(form: ClosedForm) -> list[sympy.Expr]:
    """What the coordinates, their impulses and their jumps divide by, as far as symbols are in it.

    >>> a, b, t = sympy.symbols("a b t", positive=True)
    >>> divisors(ClosedForm(("x",), (b * sympy.exp(-t / a) / sympy.sqrt(a - b) + 1 / t,), t))
    [a, a - b]
    """
    parts = [*form.values, *(each.factor for each in form.impulses), *(each.time for each in form.impulses)]
    parts += [each.size for each in form.jumps]
    powers = set().union(*(sympy.sympify(part).atoms(sympy.Pow) for part in parts))
    below = {power.base for power in powers if power.exp.could_extract_minus_sign() and not power.base.has(form.time)}
    return sorted((base for base in below if base.free_symbols), key=sympy.default_sort_key)


def with_needed_assumptions(form: ClosedForm) -> ClosedForm:
    """The formula without the assumptions that only coordinates need that are not in it.

    For values of the parameters where A(s) stays regular, X(s) = A(s)^-1 b(s) is continuous in them, and so is the transform
    of a formula that does not divide by the assumption: they stay equal there.

    >>> a, b, t = sympy.symbols("a b t", positive=True)
    >>> form = ClosedForm(("x",), (t / (a - b),), t, assumptions=(a - b, a - 2 * b))
    >>> with_needed_assumptions(form).assumptions
    (a - b,)
    """
    below = divisors(form)
    return replace(form, assumptions=tuple(each for each in form.assumptions if any(_meets(each, other) for other in below)))


def _meets(assumption: sympy.Expr, divisor: sympy.Expr) -> bool:
    """Whether the divisor may vanish where the assumption does: they share a factor, or there are roots in it, which is not told."""
    if not assumption.free_symbols & divisor.free_symbols:
        return False
    if any(not power.exp.is_Integer for power in divisor.atoms(sympy.Pow)):
        return True
    return bool(sympy.gcd(assumption, divisor).free_symbols)
