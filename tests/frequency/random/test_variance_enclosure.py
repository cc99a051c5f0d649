"""Enclosed variances between corner frequencies: partial fractions against certified quadrature (Johansson 2018)."""

import flint
import mpmath as mp
import pytest

import mbconstrained as mb
from mbconstrained.exact.rational import polynomial, working_precision
from mbconstrained.frequency.random import variance_enclosure
from mbconstrained.frequency.random.spectra import Line, PowerLaw

LINE = Line(0.25, 3.0, 0.5, 2.0)
PIECES = [LINE, *(PowerLaw(0.25, 3.0, 0.5, exponent) for exponent in (-2.0, -1.0, -0.3, 0.0, 1.0, 1.0 + 1e-15, 2.7))]
# An oscillator, with a pole at zero, whose output follows its input, and two that are close: (39 + s / 4 + s^2) (39 + 2^-10 + s / 4 + s^2).
FRACTIONS = [
    ([1.0], [39.0, 0.1, 1.0]),
    ([1.0, 2.0], [0.0, 39.0, 0.1, 1.0]),
    ([1.0, 0.0, 0.0, 2.0], [10.0, 3.0, 0.2, 1.0]),
    ([1.0, 1.0], [39.0 * (39 + 2**-10), (78 + 2**-10) / 4, 78 + 2**-10 + 2**-4, 0.5, 1.0]),
]


@pytest.mark.parametrize("above, below", FRACTIONS)
@pytest.mark.parametrize("piece", PIECES, ids=lambda piece: f"{type(piece).__name__} {getattr(piece, 'exponent', '')}")
def test_partial_fractions_are_the_integral(piece, above, below):
    N, D = polynomial(above), polynomial(below)
    with working_precision(300):
        ball = variance_enclosure._Fraction(N, D).integral(piece, 0.25, 3.0)
        assert ball.rel_accuracy_bits() > 150
    N, D = flint.acb_poly(N), flint.acb_poly(D)
    with working_precision(128):
        turn = flint.acb(0, 2) * flint.acb.pi()

        def density(f, analytic):
            s, part = turn * f, (f - flint.acb(0.25)) / flint.acb(2.75)
            if piece is LINE:
                G = 0.5 + 1.5 * part
            else:
                G = 0.5 * (4 * f).pow(flint.acb(piece.exponent), analytic=analytic)
            return N(s) * N(-s) / (D(s) * D(-s)) * G

        expected = flint.acb.integral(density, flint.acb(0.25), flint.acb(3), eval_limit=10**6).real
    assert expected.rel_accuracy_bits() > 40
    assert expected.overlaps(ball)


def test_multiple_poles_are_left_to_quadrature():
    double = polynomial([2.0, 1.0]) ** 2
    assert variance_enclosure._Fraction(polynomial([1.0]), double).integral(LINE, 0.25, 3.0) is None
    system = mb.MechanicalSystem([[1.0]], [[4.0]], [[4.0]])  # critically damped: |H|^2 = 1 / (4 + w^2)^2
    variance = system.random_response({"x1": mb.psd([0.25, 3.0], [0.5, 0.5])}).rms
    a, b = (mp.mpf(2) * mp.pi * f for f in (0.25, 3))
    whole = [(w / (8 * (4 + w**2)) + mp.atan(w / 2) / 16) / (2 * mp.pi) / 2 for w in (a, b)]
    assert float(variance[0]) ** 2 == pytest.approx(float(whole[1] - whole[0]), rel=1e-14)
    assert flint.ctx.prec == 53
