"""Impulses, values at 0+ and intervals against rational arithmetic and mpmath, which share nothing with them."""

from concurrent.futures import ThreadPoolExecutor
from fractions import Fraction

import flint
import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.exact.enclosure.exact_response import ExactResponse
from mbconstrained.exact.enclosure.exact_sources import ExactSource, harmonic_powers, phase_factors
from mbconstrained.exact.rational import RationalMatrix
from tests.oracles import exact as oracle

whole = st.integers(-3, 3)


@st.composite
def problems(draw):
    """A(s) = U diag(d_i) V with whole numbers, a start, a force with an impulse: singular A_q and impulses are common."""
    r, q = draw(st.integers(1, 3)), draw(st.integers(1, 3))
    A = [np.array(draw(st.lists(st.lists(whole, min_size=r, max_size=r), min_size=r, max_size=r)), float) for _ in range(q + 1)]
    if draw(st.booleans()):
        A[-1][0] = 0
    initial = np.array(draw(st.lists(st.lists(whole, min_size=r, max_size=r), min_size=q, max_size=q)), float)
    power, rate, w = draw(st.integers(0, 2)), draw(st.sampled_from([0.0, -1.0, 0.5])), draw(st.sampled_from([0.0, 1.0, 2.0]))
    vector = np.array(draw(st.lists(whole, min_size=r, max_size=r)), float)
    load = np.array(draw(st.lists(whole, min_size=r, max_size=r)), float)
    return A, initial, (vector, power, rate, w), load


@given(problems())
def test_impulses_and_values_at_0_are_those_of_rational_arithmetic(problem):
    A, initial, (vector, power, rate, w), load = problem
    R = oracle.rational(A)
    if not oracle.determinant(R):
        return
    force = mb.term(vector, power=power, rate=rate, angular_frequency=w) + mb.impulse(load)
    x = mb.solve(mb.PolynomialMatrix(A), initial, force).exact
    terms = [([Fraction(v) for v in vector], power, Fraction(rate), Fraction(w), "cos")]
    start = [[Fraction(v) for v in row] for row in initial]
    truth = oracle.ExactResponse(R, start, terms, [[Fraction(v) for v in load]], count=12)
    assert [list(impulse) for impulse in x.impulses] == truth.impulses
    assert x.start.tolist() == truth.derivatives[: len(initial)]
    assert x.jump.tolist() == [[a - b for a, b in zip(*rows)] for rows in zip(truth.derivatives, start)]
    for order in range(8):
        box = x.enclose(0.0, order=order)
        assert box.contains(np.array(truth.derivatives[order], dtype=object))


OSCILLATOR = mb.PolynomialMatrix([[[4.0]], [[0.0]], [[1.0]]])


def enclosed(x, times, values) -> bool:
    """Whether mpmath's values, good to 40 digits, lie between bounds of 30."""
    strings = np.array([[mpmath.nstr(v, 45) for v in values]], dtype=object)
    return bool(x.enclose(times, 30).contains(strings))


def test_resonance_at_a_double_zero():
    """x'' + 4 x = cos 2t from rest: x = t sin(2t) / 4."""
    times = [0.0, 1e-9, 0.5, 3.0, 1e4]
    x = mb.solve(OSCILLATOR, force=mb.harmonic([1.0], angular_frequency=2.0))
    with mpmath.workdps(50):
        assert enclosed(x, times, [mpmath.mpf(t) * mpmath.sin(2 * mpmath.mpf(t)) / 4 for t in times])


@pytest.mark.parametrize("phase", [0.3, -2.5, 7.0])
def test_a_phase_is_the_number_that_was_given(phase):
    """x'' + 4 x = cos(t + p) from rest, the cosine of p never rounded."""
    times = [0.0, 0.5, 100.0]
    x = mb.solve(OSCILLATOR, force=mb.harmonic([1.0], angular_frequency=1.0, phase=phase))
    with mpmath.workdps(50):
        p = mpmath.mpf(phase)
        values = [
            (mpmath.cos(t + p) - mpmath.cos(p) * mpmath.cos(2 * t) + mpmath.sin(p) * mpmath.sin(2 * t) / 2) / 3
            for t in map(mpmath.mpf, times)
        ]
        assert enclosed(x, times, values)


def test_with_a_phase_impulses_are_intervals():
    """[[0, 1], [1, -s]] x = [f, 0] has x2 = f, x1 = f', which has the impulse f(0+) = cos p; p = 0.25 is a float."""
    A = mb.PolynomialMatrix([[[0.0, 1.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, -1.0]]])
    x = mb.solve(A, force=mb.harmonic([1.0, 0.0], angular_frequency=1.0, phase=0.25))
    with pytest.raises(mb.InputError, match="enclose_impulses"):
        x.exact.impulses
    (box,) = x.exact.enclose_impulses(20)
    with mpmath.workdps(40):
        assert box.contains([mpmath.nstr(mpmath.cos(mpmath.mpf(1) / 4), 35), "0"])


def test_powers_are_divided_by_factorials_exactly():
    """x = I_5 = t^4 / 24 at t = 1."""
    x = mb.solve(mb.PolynomialMatrix([[[1.0]]]), force=mb.power([1.0], 5))
    low, high = (Fraction(bound[0]) for bound in (x.enclose(1.0, 30).lower, x.enclose(1.0, 30).upper))
    assert low <= Fraction(1, 24) <= high < low + Fraction(1, 10**30)


def test_a_record_is_linear_between_its_samples():
    """x = f, its samples no sums of powers of two; zero after the last, exactly."""
    f = mb.sampled([0.1, 0.3, 0.3, 0.7], [[1.0, 2.0, -1.0, 0.1]])
    x = mb.solve(mb.PolynomialMatrix([[[1.0]]]), force=f)
    F = Fraction
    middle = F(1) + (F(0.2) - F(0.1)) / (F(0.3) - F(0.1))
    assert x.enclose([0.0, 0.1, 0.2, 0.3, 0.9]).contains(np.array([[0, 1, middle, -1, 0]], dtype=object))
    assert x.enclose(0.9).lower[0] == "0" == x.enclose(0.9).upper[0]


def test_a_record_under_an_oscillator_is_its_restart():
    """From sample to sample by the exact solution of x'' + 4 x = a + b t with mpmath."""
    times, values = [0.0, 0.7, 1.9, 2.2], [0.5, -1.25, 3.0, 0.0]
    x = mb.solve(OSCILLATOR, [[1.0], [0.0]], mb.sampled(times, [values]))
    with mpmath.workdps(50):
        state = mpmath.matrix([1, 0])
        for (t0, v0), (t1, v1) in zip(zip(times, values), zip(times[1:], values[1:])):
            h, slope = mpmath.mpf(t1) - mpmath.mpf(t0), (mpmath.mpf(v1) - v0) / (mpmath.mpf(t1) - t0)
            c, s = mpmath.cos(2 * h), mpmath.sin(2 * h)
            free = mpmath.matrix([state[0] - mpmath.mpf(v0) / 4, state[1] - slope / 4])
            state = mpmath.matrix([free[0] * c + free[1] * s / 2 + mpmath.mpf(v1) / 4, -2 * free[0] * s + free[1] * c + slope / 4])
        assert enclosed(x, [times[-1]], [state[0]])


def test_an_approximated_force_is_the_polynomials_that_it_became():
    """x = f: between its knots the polynomial whose float coefficients the states are, to the last digit of float64."""
    f = mb.approximated(lambda t: np.abs(np.sin(3 * t)), 2.0)
    x = mb.solve(mb.PolynomialMatrix([[[1.0]]]), force=f)
    times = np.linspace(0.0, 2.5, 41)
    assert x.enclose(times).error_bounds(f(times)).max() < 4e-15


def test_delays_of_mapped_sums_are_those_of_the_numeric_engine():
    force = (2.0 * (mb.step([1.0]) + mb.harmonic([1.0], angular_frequency=2.0)).delayed(0.3)).mapped([[0.5], [1.5]]).delayed(0.4)
    x = mb.solve(mb.PolynomialMatrix([4 * np.eye(2), 0.1 * np.eye(2), np.eye(2)]), force=force)
    times = np.array([0.0, 0.69, 0.7, 0.71, 2.0, 50.0])
    assert x.enclose(times).error_bounds(x(times)).max() < 1e-13
    assert x.events == () and x.enclose(0.69).contains([0, 0])


def test_derivatives_belong_together():
    """A(d/dt) x = f holds for the bounds: 4 x + x'' - f contains 0."""
    x = mb.solve(OSCILLATOR, [[1.0], [2.0]], mb.term([1.0], power=1, rate=-0.5, angular_frequency=2.0))
    boxes = [x.enclose(1.25, 25, order=k) for k in (0, 2)]
    with mpmath.workdps(40):
        t = mpmath.mpf(1.25)
        force = t * mpmath.exp(-t / 2) * mpmath.cos(2 * t)
        low = 4 * mpmath.mpf(boxes[0].lower[0]) + mpmath.mpf(boxes[1].lower[0]) - force
        high = 4 * mpmath.mpf(boxes[0].upper[0]) + mpmath.mpf(boxes[1].upper[0]) - force
        assert low <= 0 <= high and high - low < 1e-22


def test_a_value_that_is_zero_has_an_interval_about_zero():
    """x' = -1 from 1 is zero at 1, by rational arithmetic; sin 2t at t near pi/2 is not, and has its digits."""
    drift = mb.solve(mb.PolynomialMatrix([[[0.0]], [[1.0]]]), [[1.0]], mb.step([-1.0]))
    assert drift.enclose(1.0).lower[0] == "0" == drift.enclose(1.0).upper[0]
    x = mb.solve(OSCILLATOR, [[0.0], [2.0]])
    with mpmath.workdps(60):
        assert enclosed(x, [np.pi / 2], [mpmath.sin(2 * mpmath.mpf(np.pi / 2))])
    A = mb.PolynomialMatrix([[[1.0, 0.0], [1.0, -1.0]], [[1.0, 0.0], [0.0, 0.0]]])  # x1' + x1 = 0, x2 = x1
    box = mb.solve(A, [[1.0, 0.0]]).enclose(2.0)
    assert box.lower[0] == box.lower[1] and box.upper[0] == box.upper[1]


def test_growth_beyond_what_can_be_written_is_told():
    x = mb.solve(mb.PolynomialMatrix([[[-1.0]], [[1.0]]]), [[1.0]])
    with pytest.raises(mb.Overflow, match="right half plane"):
        x.enclose(1e9)
    box = x.enclose(1e5, 20)
    assert box.lower[0].endswith("E+43429")
    decay = mb.solve(mb.PolynomialMatrix([[[1.0]], [[1.0]]]), [[1.0]]).enclose(1e9)
    assert (decay.lower[0], decay.upper[0]) == ("0", "1E-100000")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([-1.0],), "time"),
        (([np.nan],), "time"),
        ((1.0, 0), "digits"),
        ((1.0, 10**6), "digits"),
        ((1.0, 2.5), "digits"),
        (([[1.0]],), "time"),
    ],
)
def test_questions_that_make_no_sense_are_refused(arguments, message):
    with pytest.raises(mb.InputError, match=message):
        mb.solve(OSCILLATOR, [[1.0], [0.0]]).enclose(*arguments)


def test_shapes_are_those_of_x():
    x = mb.solve(mb.PolynomialMatrix([np.eye(2), np.eye(2)]), [[1.0, 2.0]])
    for times in (0.5, [0.5], [], [0.5, 1.0, 2.0]):
        assert x.enclose(times).lower.shape == x(times).shape == x.enclose(times).error_bounds(x(times)).shape
    with pytest.raises(mb.InputError, match="shape"):
        x.enclose(0.5).contains([1.0])
    with pytest.raises(mb.InputError, match="finite"):
        x.enclose(0.5).contains([np.nan, 1.0])


def test_a_float_stands_for_what_rounds_to_it():
    """The nearest float of e^-1 is contained, its neighbours are not; the number that it is, taken exactly, is not either."""
    box = mb.solve(mb.PolynomialMatrix([[[1.0]], [[1.0]]]), [[1.0]]).enclose([1.0], 25)
    near = float(np.exp(-1.0))
    assert box.contains([[near]]) and box.contains(np.array([[near]]))
    assert not box.contains([[Fraction(near)]])
    assert not box.contains([[np.nextafter(near, 1)]]) and not box.contains([[np.nextafter(near, 0)]])


def test_hundreds_of_frequencies_do_not_mix_up_their_modes():
    """x' + x = sum of cos(w t + p), 300 frequencies: each mode belongs to its own root, however many there were before."""
    phases = [(k / 8, 0.3 + k / 100) for k in range(1, 301)]
    force = [ExactSource(shape, (flint.fmpq(1),), flint.fmpq(0), factor) for w, p in phases for shape, factor in _harmonic(w, p)]
    x = ExactResponse(RationalMatrix([[[1]], [[1]]]), [[0]], force)
    times = [0.75, 2.0]
    with mpmath.workdps(40):
        values = [
            sum(
                (mpmath.cos(w * t + p) + w * mpmath.sin(w * t + p) - mpmath.exp(-t) * (mpmath.cos(p) + w * mpmath.sin(p)))
                / (1 + w * w)
                for w, p in ((mpmath.mpf(w), mpmath.mpf(p)) for w, p in phases)
            )
            for t in map(mpmath.mpf, times)
        ]
        assert x.enclose(times, 20).contains([[mpmath.nstr(v, 35) for v in values]])


def _harmonic(w, p):
    cosine, sine = harmonic_powers(0, 0.0, w)
    return (cosine, phase_factors(p)[0]), (sine, phase_factors(p)[1] * flint.fmpq(-1))


def test_what_does_not_grow_keeps_its_digits_beside_what_does():
    """x1' = -x1 beside x2'' = 2e6 x2: the residue of the growing mode in x1 is zero, not a ball."""
    A = mb.PolynomialMatrix([np.diag([1.0, -2e6]), np.diag([1.0, 0.0]), np.diag([0.0, 1.0])])
    box = mb.solve(A, [[1.0, 1.0], [0.0, 0.0]]).enclose(10.0, 25)
    with mpmath.workdps(40):
        assert box.contains([mpmath.nstr(mpmath.exp(-10), 35), mpmath.nstr(mpmath.cosh(10 * mpmath.sqrt(2000000)), 35)])


@pytest.mark.parametrize(("b", "a", "gamma"), [([1], [1, 0], 1), ([1], [1, 1, 0], 1), ([1], [1, 1], -1), ([1], [1, 0, 0], -1)])
def test_poles_at_0_are_no_other_structure(b, a, gamma):
    y = mb.transfer_function_response(b, a, gamma)
    assert y.enclose(1.0).notices == () and y.enclose(1.0).error_bounds(y(1.0)).max() < 1e-15
    assert y.exact.start.shape == y.start.shape


def test_derivatives_of_inputs_are_those_of_the_numbers_given():
    """The derivative of t^4 / 4! is t^3 / 3!, though 1 / 4! is rounded in the input: by a fraction of matrices and of polynomials."""
    one = mb.matrix_fraction_response([[[0.0]], [[1.0]]], [[[1.0]], [[1.0]]], mb.power([1.0], 5))
    other = mb.transfer_function_response([1, 0], [1, 1], mb.power([1.0], 5))
    assert one.enclose(1.0, 25).lower[0] == other.enclose(1.0, 25).lower[0]


@pytest.mark.parametrize("phase", [3.3e15, 4200000000000004.0, 1e16, 1e8])
def test_large_phases_are_no_quarter_turns(phase):
    x = mb.solve(mb.PolynomialMatrix([[[1.0]]]), force=mb.harmonic([1.0], angular_frequency=0.0, phase=phase))
    with mpmath.workdps(60):
        assert enclosed(x, [0.0], [mpmath.cos(mpmath.mpf(phase))])
    assert x(0.0)[0] == pytest.approx(np.cos(phase), abs=1e-15)


def test_a_phase_that_does_not_reach_the_start_leaves_it_rational():
    x = mb.solve(
        mb.PolynomialMatrix([[[1.0]], [[0.0]], [[1.0]]]), [[1.0], [0.0]], mb.harmonic([1.0], angular_frequency=2.0, phase=0.3)
    )
    assert x.exact.impulses == () and x.exact.start.tolist() == [[1], [0]] and not x.exact.jump.any()


def test_irrational_factors_cancel_exactly():
    h = mb.harmonic([1.0, 0.0], angular_frequency=2.0, phase=0.3)
    A = mb.PolynomialMatrix([[[0.0, 1.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, -1.0]]])
    for force in (h - h, h + mb.harmonic([-1.0, 0.0], angular_frequency=2.0, phase=0.3)):
        x = mb.solve(A, force=force).exact
        assert x.enclose([0.0, 1.0]).contains(np.zeros((2, 2), dtype=int)) and x.enclose(1.0).lower.tolist() == ["0", "0"]
        assert x.enclose_impulses() == ()


def test_the_working_precision_is_nobody_elses():
    """Threads take turns, and the precision is what it was."""
    x, before = mb.solve(OSCILLATOR, [[1.0], [0.0]]), flint.ctx.prec
    with ThreadPoolExecutor(5) as pool:
        boxes = list(pool.map(lambda digits: x.enclose([0.5, 7.0], digits), [15, 300, 40, 120, 15, 60, 250] * 4))
    assert flint.ctx.prec == before
    assert all((exact(box.upper) - exact(box.lower) <= Fraction(1, 10**box.digits)).all() for box in boxes)


def exact(strings):
    return np.vectorize(Fraction, otypes=[object])(strings)


def test_other_numbers_and_other_shapes():
    box = mb.solve(mb.PolynomialMatrix([np.eye(2), np.eye(2)]), [[1.0, 2.0]]).enclose(0.0)
    assert box.contains([1.0, "2"]) and box.contains(np.array([1.0, 2.0], dtype=np.float32)) and box.contains([1, Fraction(2)])
    for wrong in ([0.1, [1]], [[1.0, 2.0]], ["a", 1]):
        with pytest.raises(mb.InputError, match="values"):
            box.contains(wrong)
