"""Guaranteed intervals that contain s^p C A(s)^-1 B at s = 2 pi f i, for exact data."""

from __future__ import annotations

from fractions import Fraction

import flint
import numpy as np

from ...ground.checks import whole_number
from ...ground.errors import InputError
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..rational.flint_numbers import rational, working_precision
from .intervals import Enclosure, bits_of, has_digits

#: Working precision in bits beyond the digits, in turn; the last is a sign of a pole.
GUARDS = (64, 256, 1024, 4096)


def enclosed_transfer(A: PolynomialMatrix, imaginary, inputs, outputs, power: int, frequency_hz: float, digits: int) -> Enclosure:
    """s^p C (A(s) + i H)^-1 B at one frequency."""
    digits = whole_number(digits, "digits", minimum=1)
    exact = [matrix.tolist() for matrix in A.exact_coefficients]
    for guard in GUARDS:
        with working_precision(bits_of(digits) + guard):
            values = _transfer(exact, imaginary, inputs, outputs, power, frequency_hz)
            if values is not None and all(_is_known(value, digits) for value in values):
                return Enclosure.of([[v.real for v in values], [v.imag for v in values]], np.zeros(len(values)), digits)
    raise InputError(f"frequency_hz: found {frequency_hz:g} Hz, where the response has a pole; enclose it at another frequency")


def _is_known(value: flint.acb, digits: int) -> bool:
    if not value.is_finite():
        return False
    size = value.abs_upper()
    limit = size * flint.arb(10) ** -digits
    return all(part == 0 or has_digits(part, digits) or bool(part.abs_upper() < limit) for part in (value.real, value.imag))


def _transfer(exact, imaginary, inputs, outputs, power: int, frequency_hz: float) -> list[flint.acb] | None:
    omega = 2 * flint.arb.pi() * flint.arb(rational(Fraction(frequency_hz)))
    s = flint.acb(0, omega)
    matrix = None
    for coefficient in exact[::-1]:
        own = flint.acb_mat([[flint.acb(flint.arb(rational(entry))) for entry in row] for row in coefficient])
        matrix = own if matrix is None else matrix * s + own
    if imaginary is not None:
        matrix = matrix + flint.acb_mat([[flint.acb(0, flint.arb(rational(entry))) for entry in row] for row in imaginary.tolist()])
    try:
        X = matrix.solve(flint.acb_mat(inputs.tolist()))
    except ZeroDivisionError:
        return None
    H = flint.acb_mat(outputs.tolist()) * X * s**power
    return [H[i, j] for i in range(H.nrows()) for j in range(H.ncols())]
