"""Just after a start from rest everything is small; the values at 0+ stay exact though the sum of modes cancels.

The transfer function is example (47) of Hauksdottir et al., order 8; the values are from ball arithmetic.
"""

from fractions import Fraction
from functools import cache
from math import factorial

import mpmath
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.response.methods.pair_solution import taylor_series, with_series

DENOMINATOR = (
    "9009004301/31250000000000 11673172709/1562500000000 18352013733/250000000000 185730207/500000000 "
    "119529049/100000000 636261/250000 17469/5000 14/5 1"
)
NUMERATOR = "348381/12500000 149571/500000 11271/10000 89/50 1"
TIMES = np.array([1.0, 10.0, 100.0])
VALUES = {
    0: [0.12814854430184174600637350439827, 6.2842390938231284146571470226272, 0.0011192169348073601338595695755866],
    1: [0.033832953263242946872566884595169, 40.795547852808303057519299818904, 96.664772697369375799832049162454],
    2: [0.0070121242560890860894757065861656, 131.18767570451995806147247349107, 8200.0345467066184141515490506938],
    3: [0.0011984660198333991121539811223399, 295.56699326741597332670554532835, 353938.78428300740487440407983976],
}


def output(gamma: int):
    """b(d/dt) x with a(d/dt) x = I_gamma, from rest."""
    a, b = ([float(Fraction(c)) for c in text.split()] for text in (DENOMINATOR, NUMERATOR))
    x = mb.solve(mb.PolynomialMatrix(np.array(a)[:, None, None]), force=mb.power([1.0], gamma))
    return sum((factor * x.derivative(k) for k, factor in enumerate(b)), mb.zero(1).smooth)


@pytest.mark.parametrize("gamma", VALUES)
def test_impulse_step_ramp_and_parabola_responses_of_order_eight(gamma):
    found = output(gamma)(TIMES)[0]
    assert np.allclose(found[1:], VALUES[gamma][1:], rtol=1e-12)
    assert found[0] == pytest.approx(VALUES[gamma][0], rel=1e-7)


@cache
def laurent_coefficients() -> list[Fraction]:
    """Those of 1 / a(s) = sum of c_j s^(-8 - j), in rational arithmetic."""
    a, found = [Fraction(float(Fraction(c))) for c in DENOMINATOR.split()], []
    for j in range(120):
        found.append((j == 0) - sum(a[8 - i] * found[j - i] for i in range(1, min(j, 8) + 1)))
    return found


def exact_output(gamma: int, time: float, order: int = 0) -> float:
    """y^(order)(t) as the sum of t^p / p! over the Laurent coefficients of b(s) / (a(s) s^gamma), in 300 digits."""
    with mpmath.workdps(300):
        b = [mpmath.mpf(float(Fraction(c))) for c in NUMERATOR.split()]
        total = mpmath.mpf(0)
        for j, coefficient in enumerate(laurent_coefficients()):
            for k, factor in enumerate(b):
                power = 7 + j - k + gamma - order
                if power >= 0:
                    own = mpmath.mpf(coefficient.numerator) / coefficient.denominator
                    total += factor * own * mpmath.mpf(time) ** power / factorial(power)
        return float(total)


def started(x: mb.Response):
    """The regular part, evaluated by its Taylor series at first."""
    return with_series(x.function, taylor_series(x.pairs.form, x.initial, x.jump, x.force))


@pytest.mark.parametrize("gamma", VALUES)
def test_small_outputs_of_order_eight_keep_their_digits(gamma):
    """y ~ t^(gamma + 3) / (gamma + 3)!, 1e-39 for I_3 at t = 1e-6; the modes sum up to 1e-13 there."""
    a, b = ([float(Fraction(c)) for c in text.split()] for text in (DENOMINATOR, NUMERATOR))
    force = sum(factor * mb.power([1.0], gamma - k) for k, factor in enumerate(b))
    y = started(mb.solve(mb.PolynomialMatrix(np.array(a)[:, None, None]), force=force))
    times = [1e-6, 0.01, 0.1, 0.5, 1.0, 2.0, 10.0]
    for order in range(3):
        known = [exact_output(gamma, t, order) for t in times]
        assert [y.derivative(order)(t)[0] for t in times] == pytest.approx(known, rel=1e-12, abs=0.0)


def test_the_estimate_knows_about_the_cancellation():
    """At t = 1/4 the answer x ~ t^8/8! is far below the modes that it is the sum of."""
    a = [float(Fraction(c)) for c in DENOMINATOR.split()]
    x = mb.solve(mb.PolynomialMatrix(np.array(a)[:, None, None]), force=mb.step([1.0]))
    time, series = Fraction(1, 4), Fraction(0)
    derivatives = [Fraction(0)] * 8 + [Fraction(1)]  # x^(8)(0+) = 1, then a(d/dt) x' = 0 downwards
    exact = [Fraction(c) for c in DENOMINATOR.split()]
    for k in range(30):
        derivatives.append(-sum(exact[i] * derivatives[k + 1 + i] for i in range(8)))
    power = Fraction(1)
    for k, value in enumerate(derivatives):
        series += value * power
        power *= time / (k + 1)
    true = abs(x(float(time))[0] / float(series) - 1)
    assert true <= 10 * x.error_estimate(float(time))


@pytest.mark.parametrize("time", [1e-9, 1e-3, 0.1])
def test_a_mass_on_a_spring_leaves_rest_like_a_free_one(time):
    """x'' + x = 1: 1 - cos t = 2 sin^2(t/2), t^2/2 at first."""
    x = mb.solve(mb.PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]]), force=mb.step([1.0]))
    assert x(time)[0] == pytest.approx(2 * np.sin(time / 2) ** 2, abs=4e-16)
