"""From balls to decimal strings: rounded outwards, so that what they bound stays between them."""

from __future__ import annotations

from decimal import MAX_EMAX, MAX_PREC, MIN_EMIN, ROUND_CEILING, ROUND_FLOOR, Context, Decimal

import flint

from ...errors import Overflow
from ..rational.arithmetic import working_precision

#: Digits beyond those asked for that the strings have.
MORE_DIGITS = 3

#: Ends of balls are rounded outwards to so many bits more than the strings have.
GUARD_BITS = 24

#: The largest power of ten that is written out; what is smaller than its inverse has an interval of that size about zero.
LARGEST_POWER = 100_000


def bits_of(digits: int) -> int:
    """So many bits have at least so many decimal digits."""
    return digits * 10 // 3 + 2


def is_told(value: flint.arb, digits: int) -> bool:
    """Whether the ball has the digits, or is so small that it has not to."""
    return value.rel_accuracy_bits() >= bits_of(digits) or bool(value.abs_upper() < flint.arb(10) ** -LARGEST_POWER)


def decimal_bounds(value: flint.arb, digits: int) -> tuple[str, str]:
    """Two decimal numbers with the ball between them, of a few digits more than asked for.

    Raises:
        Overflow: it may be larger than any number that is written out.
    """
    with working_precision(bits_of(digits) + GUARD_BITS):
        return _bounds(value, digits)


def _bounds(value: flint.arb, digits: int) -> tuple[str, str]:
    largest = value.abs_upper()
    if not largest < flint.arb(10) ** LARGEST_POWER:
        raise Overflow(
            f"a value may be larger than 1e{LARGEST_POWER}: a zero of A(s) in the right half plane grows beyond; ask for earlier times"
        )
    if not largest.is_zero() and largest < flint.arb(10) ** -LARGEST_POWER:
        low, high = value.lower() < 0, value.upper() > 0
        return f"-1E-{LARGEST_POWER}" if low else "0", f"1E-{LARGEST_POWER}" if high else "0"
    return _decimal(value.lower(), digits + MORE_DIGITS, ROUND_FLOOR), _decimal(value.upper(), digits + MORE_DIGITS, ROUND_CEILING)


def _decimal(value: flint.arb, digits: int, rounding: str) -> str:
    """An exact ball, that is a number, rounded in one direction."""
    mantissa, exponent = (int(part) for part in value.man_exp())
    context = Context(prec=digits, rounding=rounding, Emax=MAX_EMAX, Emin=MIN_EMIN)
    if exponent >= 0:
        return str(context.create_decimal(Decimal(mantissa * 2**exponent)).normalize(context))
    wide = Context(prec=MAX_PREC, Emax=MAX_EMAX, Emin=MIN_EMIN)
    return str(context.divide(Decimal(mantissa), wide.create_decimal(2**-exponent)).normalize(context))
