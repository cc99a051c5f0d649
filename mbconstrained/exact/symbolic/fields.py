"""The field of the entries: rational functions of the symbols and of pi, with rational or quadratic numbers in them.

Entries become exact expressions here, once, when the matrix is made; from then on all arithmetic happens in the field,
where equal things are equal without any simplification. Signs and square roots of its elements follow, and numbers u + v sqrt(g).
"""

from __future__ import annotations

import numbers
from collections.abc import Iterable
from decimal import Decimal
from fractions import Fraction
from functools import reduce
from itertools import pairwise

import sympy
from sympy.polys.domains.domain import Domain
from sympy.polys.polyerrors import CoercionFailed

from ...ground.checks import counted
from ...ground.errors import InputError

#: Different square roots that one matrix may have: the primitive element of more of them takes long to find.
MOST_ROOTS = 2

#: Digits of a double: a sympy.Float of no more stands for a Python float.
DOUBLE = 53


def exact_expression(entry, what: str) -> sympy.Expr:
    """An entry as an exact expression; floats become their shortest decimals."""
    if isinstance(entry, sympy.Expr):
        if entry.atoms(sympy.nan, sympy.oo, -sympy.oo, sympy.zoo, sympy.I):
            raise InputError(f"{what}: found {entry}; every entry must be finite and real")
        floats = {f: _decimal(float(f) if f._prec <= DOUBLE else Decimal(str(f)), what) for f in entry.atoms(sympy.Float)}
        return entry.xreplace(floats) if floats else entry
    if isinstance(entry, numbers.Rational) and not isinstance(entry, bool):
        return sympy.Rational(int(entry.numerator), int(entry.denominator))
    if isinstance(entry, (numbers.Real, Decimal)) and not isinstance(entry, bool):
        return _decimal(entry, what)
    given = repr(entry) if isinstance(entry, (str, bool, complex)) else f"an object of type {type(entry).__name__}"
    raise InputError(f"{what}: found {given}; expected a number or an expression, a rational function of sympy symbols")


def _decimal(number, what: str) -> sympy.Rational:
    if not sympy.Float(number).is_finite:
        raise InputError(f"{what}: found {number}; every entry must be a finite number")
    fraction = Fraction(repr(float(number)) if not isinstance(number, Decimal) else number)
    return sympy.Rational(fraction.numerator, fraction.denominator)


def exact_rows(matrix, what: str) -> list[list[sympy.Expr]]:
    """A square matrix, given as sympy matrix, array or nested lists, as rows of exact expressions."""
    rows = matrix.tolist() if hasattr(matrix, "tolist") else matrix
    if isinstance(rows, str) or not isinstance(rows, Iterable):
        raise InputError(f"{what}: found {rows!r}; expected a square matrix")
    rows = [list(row) if isinstance(row, Iterable) and not isinstance(row, str) else row for row in rows]
    if not rows or any(not isinstance(row, list) or len(row) != len(rows) for row in rows):
        lengths = " or ".join(map(str, sorted({len(row) if isinstance(row, list) else 0 for row in rows})))
        shape = f"{counted(len(rows), 'row')} of {lengths} entries" if rows else "no rows"
        raise InputError(f"{what}: found {shape}; expected a square matrix")
    return [[exact_expression(entry, f"{what} at ({i}, {j})") for j, entry in enumerate(row)] for i, row in enumerate(rows)]


def symbols_of(expressions: Iterable[sympy.Expr]) -> tuple[sympy.Symbol, ...]:
    """The symbols in them, sorted by name."""
    symbols = set().union(*(e.free_symbols for e in expressions))
    return tuple(sorted(symbols, key=lambda symbol: (symbol.name, str(symbol.assumptions0))))


def generators_of(expressions: Iterable[sympy.Expr]) -> tuple[sympy.Expr, ...]:
    """The symbols in expressions, and pi, which as a transcendental number counts as one in rational functions."""
    expressions = list(expressions)
    return (*symbols_of(expressions), *([sympy.pi] if any(e.has(sympy.pi) for e in expressions) else []))


def check_positive(symbols: Iterable[sympy.Symbol]) -> None:
    for symbol in symbols:
        if symbol.is_positive is False or not symbol.is_commutative:
            raise InputError(f"symbol {symbol}: it is declared not to be positive; every symbol here stands for a positive number")


def field_of(expressions: list[sympy.Expr]) -> Domain:
    """The smallest of Q, Q(symbols, pi) and the same with square roots of rationals that has all the expressions."""
    generators = generators_of(expressions)
    for one, other in pairwise(generators):
        if str(one) == str(other):
            raise InputError(f'two different symbols are called "{one}" (declared with different assumptions); use one of them')
    check_positive(symbols_of(expressions))
    roots = sorted({root for e in expressions for root in e.atoms(sympy.Pow) if _is_square_root(root)}, key=sympy.default_sort_key)
    if len(roots) > MOST_ROOTS:
        listed = f"{counted(len(roots), 'square root')}, {', '.join(map(str, roots))}"
        raise InputError(f"found {listed}; expected {MOST_ROOTS} at most: write a symbol for each and put in its value afterwards")
    numbers_field = sympy.QQ.algebraic_field(*roots) if roots else sympy.ZZ if generators else sympy.QQ
    return numbers_field.frac_field(*generators) if generators else numbers_field


def element(field: Domain, expression: sympy.Expr, what: str):
    """An exact expression as an element of the field."""
    try:
        return field.from_sympy(expression)
    except (CoercionFailed, ValueError, NotImplementedError):
        odd = next((part for part in sympy.preorder_traversal(expression) if not _is_rational_step(part)), expression)
        raise InputError(
            f"{what}: found {odd}; expected a rational function of symbols: write a symbol for it and put in its value afterwards"
        ) from None
    except ZeroDivisionError:
        raise InputError(f"{what}: the denominator of {expression} is zero") from None


def _is_square_root(power: sympy.Pow) -> bool:
    return bool(power.base.is_Rational and power.base > 0 and power.exp.is_Rational and power.exp.q == 2)


def _is_rational_step(part) -> bool:
    if part.is_Pow:
        return bool(part.exp.is_Integer or _is_square_root(part))
    return bool(part.is_Symbol or part.is_Rational or part.is_Add or part.is_Mul or part is sympy.pi)


def expression_of(field: Domain, value) -> sympy.Expr:
    """An element as an expression, its numerator and denominator in factors."""
    if not field.is_FractionField:
        return field.to_sympy(value)
    ring, value = field.get_ring(), in_one_form(field, value)
    (front, above), (under, below) = (_factored(ring, part) for part in (field.numer(value), field.denom(value)))
    return sympy.Mul(front / under, above, 1 / below)  # numbers together: 2 / (2 a + 2 b) would stay as it is


def _factored(ring, polynomial) -> tuple[sympy.Expr, sympy.Expr]:
    """The leading number, and the product of the factors."""
    if polynomial == 0:
        return sympy.S.Zero, sympy.S.One
    constant, factors = polynomial.factor_list()
    return ring.domain.to_sympy(constant), sympy.Mul(*(ring.to_sympy(factor) ** power for factor, power in factors))


def in_one_form(field: Domain, value):
    """The element with 1 in front of its denominator, to which fractions over algebraic numbers are not reduced otherwise."""
    if not field.is_FractionField or not field.domain.is_Algebraic:
        return value
    factor = field.domain.one / value.denom.LC
    return field.field.raw_new(value.numer.mul_ground(factor), value.denom.mul_ground(factor))


def integers(field: Domain) -> Domain:
    """The ring whose fractions are the field; the field itself without one."""
    return field.get_ring() if field.has_assoc_Ring else field


def common_denominator(field: Domain, values: Iterable):
    """The least multiple of all denominators, an element of the field."""
    if not field.has_assoc_Ring:
        return field.one
    ring = field.get_ring()
    return field.convert(reduce(ring.lcm, map(field.denom, values), ring.one), ring)


def coefficients(p: sympy.Poly, count: int) -> list:
    """The first coefficients, the lowest power first."""
    given = p.rep.to_list()[::-1][:count]
    return given + [p.domain.zero] * (count - len(given))


# The names of symbols: one symbol for each, and the time and the values at 0- are not among the parameters.
#
# Symbols of one name and different assumptions are different to sympy, and the same to everybody who reads a formula.

#: The time, where the user names none.
TIME = sympy.Symbol("t", real=True)

#: The variable of every A(s) and of all transforms.
VARIABLE = "s"


def checked_time(time, others: Iterable[sympy.Symbol], of: str, what: str = "time") -> sympy.Symbol:
    """The symbol of the time, with a unique name."""
    time = TIME if time is None else time
    if not isinstance(time, sympy.Symbol):
        raise InputError(f"{what}: found {time!r}; expected a sympy.Symbol, e.g. sympy.Symbol('t', real=True)")
    if time.name in {symbol.name for symbol in others}:
        raise InputError(f"{what}: the symbol {time} is also one of {of}; name the time otherwise")
    return time


def check_one_each(symbols: Iterable[sympy.Symbol]) -> None:
    """Check that each name has one symbol, different from the variable of A(s)."""
    names: dict[str, sympy.Symbol] = {}
    for symbol in symbols:
        if symbol.name == VARIABLE:
            raise InputError(f'the symbol "{symbol}" is the variable of A(s); name parameters of values and forces otherwise')
        if names.setdefault(symbol.name, symbol) != symbol:
            raise InputError(
                f'found two symbols "{symbol}" of different assumptions; use the same one in A, values, force and time'
            )


def check_start_names(coordinates: Iterable[str], degree: int, parameters: Iterable[sympy.Symbol]) -> None:
    """Check that no parameter has the name of a value at 0-."""
    names = {parameter.name for parameter in parameters}
    for coordinate in coordinates:
        for order in range(degree):
            name = f"{coordinate}_{order}"
            if name in names:
                value = f"the value of {coordinate}" if order == 0 else f"derivative {order} of {coordinate}"
                raise InputError(f"coordinate {coordinate} and parameter {name}: {value} at 0- is called {name} too; rename one")


def as_positive(symbols: Iterable) -> dict[sympy.Symbol, sympy.Symbol]:
    """Positive symbols with the same names for those not declared so: sqrt(k/m) is sqrt(k)/sqrt(m) for positive ones only."""
    others = (symbol for symbol in symbols if isinstance(symbol, sympy.Symbol) and not symbol.is_positive)
    return {symbol: sympy.Symbol(symbol.name, positive=True) for symbol in others}


# Signs and square roots of elements, for all positive values of the symbols.


def sign(field: Domain, value) -> int | None:
    """Sign (1, -1 or 0) for all positive values of the symbols, by coefficients and discriminants of factors; None where it is undecided."""
    if not value:
        return 0
    if not field.is_FractionField:
        return _sign_of_number(field, value)
    return _times(_sign_of_polynomial(field.numer(value)), _sign_of_polynomial(field.denom(value)))


def sign_with_root(field: Domain, rational, factor, radicand) -> int | None:
    """The sign of rational + factor sqrt(radicand)."""
    one, two = sign(field, rational), sign(field, factor)
    if one is None or two is None:
        return None
    if one * two >= 0:
        return one or two
    return _times(one, sign(field, rational**2 - factor**2 * radicand))


def _sign_of_number(domain: Domain, number) -> int:
    return 1 if domain.to_sympy(number).is_positive else -1


def _sign_of_polynomial(p) -> int | None:
    constant, factors = p.factor_list()
    total: int | None = _sign_of_number(p.ring.domain, constant)
    for factor, power in factors:
        total = _times(total, 1 if power % 2 == 0 else _sign_of_factor(factor))
    return total


def _sign_of_factor(p) -> int | None:
    signs = {_sign_of_number(p.ring.domain, c) for c in p.coeffs()}
    if len(signs) == 1:
        return signs.pop()
    if (number := p.as_expr()).is_number:  # pi is one of the symbols of the ring
        return 1 if number.is_positive else -1
    for symbol in p.ring.gens:
        if p.degree(symbol) == 2:
            zeroth, first, second = (p.coeff_wrt(symbol, power) for power in range(3))
            discriminant = first**2 - 4 * zeroth * second
            if zeroth and discriminant and _sign_of_polynomial(discriminant) == -1:
                return _sign_of_polynomial(second)
    return None


def _times(one: int | None, two: int | None) -> int | None:
    return None if one is None or two is None else one * two


def square_root(field: Domain, value) -> tuple:
    """f and g, elements of the field, with value = f^2 g, g free of squares."""
    if not value or not field.is_FractionField:
        return _square_root_of_number(field, value)
    ring, outside, inside = field.get_ring(), field.one, field.one
    for part, exponent in ((field.numer(value), 1), (field.denom(value), -1)):
        constant, factors = part.factor_list()
        for factor, power in factors:
            outside *= field.convert(factor, ring) ** (exponent * (power // 2))
            inside *= field.convert(factor, ring) ** (exponent * (power % 2))
        number, rest = (field.convert_from(c, ring.domain) for c in _square_root_of_number(ring.domain, constant))
        outside, inside = outside * number**exponent, inside * rest**exponent
    return outside, inside


def _square_root_of_number(domain: Domain, number) -> tuple:
    if not (domain.is_ZZ or domain.is_QQ) or not number:
        return domain.one, number
    value = domain.to_sympy(number)
    outside, inside = sympy.sqrt(abs(value.p * value.q)).as_coeff_Mul()
    squarefree = domain.from_sympy(sympy.sign(value) * inside**2)
    return domain.from_sympy(outside if domain.is_ZZ else outside / value.q), squarefree


def root_expression(field: Domain, value) -> sympy.Expr:
    """The square root of an element as an expression, squares in front: sqrt(5) sqrt(k/m), not sqrt(5 k m)/m."""
    f, g = square_root(field, value)
    if not field.is_FractionField:
        return field.to_sympy(f) * sympy.sqrt(field.to_sympy(g))
    content = sympy.S.One
    if field.get_ring().domain.is_ZZ:
        above, below = abs(field.numer(g).content()), abs(field.denom(g).content())
        content, g = sympy.Rational(int(above), int(below)), g * field.convert(below) / field.convert(above)
    return expression_of(field, f) * sympy.sqrt(content) * sympy.sqrt(expression_of(field, g))
