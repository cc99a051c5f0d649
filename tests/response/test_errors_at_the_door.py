"""What solve and its answer refuse, and the words they use."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.response.estimate import error_estimate

A = mb.PolynomialMatrix([np.eye(2), np.zeros((2, 2)), np.eye(2)])


@pytest.mark.parametrize(
    "initial, text",
    [
        ([1.0, 2.0], "initial: expected shape 2 x 2, found 2$"),
        ([[1.0, 2.0]], "initial: expected shape 2 x 2, found 1 x 2"),
        (np.ones((2, 3)), "initial: expected shape 2 x 2, found 2 x 3"),
        ([[1.0, 2.0], [3.0]], "initial: the rows have different lengths"),
        ([[0.0, np.nan], [0.0, 0.0]], r"initial: the entry at \(0, 1\) is nan; every entry must be a finite number"),
        ([[0.0, 1j], [0.0, 0.0]], "initial: complex numbers found; only real data is accepted"),
        ("rest", "initial: found .*'rest'.*; expected numbers"),
    ],
)
def test_values_at_zero_are_checked(initial, text):
    with pytest.raises(mb.InputError, match=text):
        mb.solve(A, initial)


@pytest.mark.parametrize(
    "force, text",
    [
        (mb.step([1.0]), "force: it has 1 row, but A\\(s\\) has 2"),
        ([1.0, 2.0], "force: found list; make it with mb.step, .*mb.pulse, mb.sampled or mb.approximated$"),
        (np.sin, "force: found ufunc; an input is made of a function of time by mb.approximated"),
    ],
)
def test_forces_are_checked(force, text):
    with pytest.raises(mb.InputError, match=text):
        mb.solve(A, force=force)


@pytest.mark.parametrize("matrix", [[np.eye(2)], np.eye(2), None])
def test_the_matrix_must_be_one(matrix):
    with pytest.raises(mb.InputError, match="expected a PolynomialMatrix"):
        mb.solve(matrix)


@pytest.mark.parametrize(
    "times, text",
    [
        (-1.0, "time: found -1 s; the function is defined for t >= 0"),
        (np.nan, "time: found nan; expected a finite number"),
        ([1.0, np.inf], r"time: the entry at \(1,\) is inf"),
        ([[1.0, 2.0]], r"time: expected a number or a list of numbers, found an array of shape \(1, 2\)"),
        (1 + 0j, "time: complex numbers found"),
        ("1 s", "time: found '1 s'; expected a number in SI units without quotes"),
    ],
)
def test_times_are_checked(times, text):
    x = mb.solve(A, np.ones((2, 2)))
    for ask in (x, x.derivative(), x.error_estimate):
        with pytest.raises(mb.InputError, match=text):
            ask(times)


def test_a_singular_matrix_is_found_when_asked_to_solve():
    with pytest.raises(mb.SingularPolynomialMatrix, match='the equations "equation 2" .* the coordinates "x2"'):
        mb.solve(mb.PolynomialMatrix([np.diag([1.0, 0.0]), np.diag([1.0, 0.0])]))


@pytest.mark.parametrize("exponent", [150, 300])
def test_zeros_too_far_apart_for_float64_take_more_digits(exponent):
    """Masses 1 kg, 10^-e kg and 10^e kg joined by unit springs: no scaling of units helps. Zeros 0, -1/2 and -2 10^e."""
    A = mb.PolynomialMatrix([[[1.0, 1, 0], [1, 2, 1], [0, 1, 1]], np.diag([1.0, 10.0**-exponent, 10.0**exponent])])
    found = [zero.value for zero in A.structure().finite_zeros]
    assert found[0] == 0 and np.allclose(found[1:], [-0.5, -2 * 10.0**exponent], rtol=1e-14, atol=0)


@pytest.mark.parametrize("force", [3, "a", [1.0, 2.0], np.sin, mb.step([1.0])])
def test_admissible_refuses_the_same_forces_in_the_same_words(force):
    with pytest.raises(mb.InputError) as of_solve:
        mb.solve(A, force=force)
    with pytest.raises(mb.InputError) as found:
        mb.admissible(A, force=force)
    assert str(found.value) == str(of_solve.value)


def test_admissible_needs_a_matrix():
    with pytest.raises(mb.InputError, match="A: found int; expected a PolynomialMatrix"):
        mb.admissible(3)


@pytest.mark.parametrize("order", [-1, 1.5, "a", True])
def test_the_order_of_an_error_estimate_is_a_whole_number(order):
    with pytest.raises(mb.InputError, match="order: found .*; expected a whole number of at least 0"):
        mb.solve(A, np.ones((2, 2))).error_estimate(1.0, order=order)


def test_an_error_estimate_of_a_derivative():
    x = mb.solve(A, np.ones((2, 2)))
    assert x.error_estimate([0.0, 1.0], order=0) == x.error_estimate([0.0, 1.0])
    for order in (1, 2):
        expected = error_estimate(x, [0.0, 1.0], lambda response, k=order: response.derivative(k))
        assert x.error_estimate([0.0, 1.0], order=order) == expected


@pytest.mark.parametrize("value", [True, np.True_])
def test_a_tolerance_is_no_truth_value(value):
    with pytest.raises(mb.InputError, match="rank_tolerance: found True; expected a number"):
        mb.solve(A, rank_tolerance=value)


@pytest.mark.parametrize("exponent", [200, 300, 307])
def test_times_that_float64_cannot_hold_together_are_told(exponent):
    oscillator = mb.PolynomialMatrix([[[1.0]], [[0.5]], [[1.0]]])
    with pytest.raises(mb.IllConditioned, match="changes within times too short relative to the others"):
        mb.solve(oscillator, force=mb.sampled([0.0, 10.0**-exponent, 1.0], [[0.0, 1.0, 0.0]]), rank_tolerance=1e-12)


@pytest.mark.parametrize("exponent", [100, 300, 307])
def test_a_small_model_has_its_motion_whatever_the_times_are(exponent):
    """The rise within so short a time is none; the exact engine has the rest."""
    oscillator = mb.PolynomialMatrix([[[1.0]], [[0.5]], [[1.0]]])
    x = mb.solve(oscillator, force=mb.sampled([0.0, 10.0**-exponent, 1.0], [[0.0, 1.0, 0.0]]))
    y = mb.solve(oscillator, force=mb.step([1.0]) - mb.ramp([1.0]) + mb.ramp([1.0]).delayed(1.0))
    times = np.array([0.5, 1.0, 2.0, 10.0])
    assert x(times) == pytest.approx(y(times), rel=1e-13)


@given(st.integers(0, 10**6))
def test_data_of_any_size_give_an_answer_or_a_reason(seed):
    """No warning of NumPy, no error of its algorithms, no value that is not finite."""
    random = np.random.default_rng(seed)
    n, span = random.integers(1, 4), random.choice([1, 10, 100, 300])

    def data(*shape):
        return random.normal(size=shape) * 10.0 ** random.uniform(-span, span, shape)

    forces = [mb.zero(n), mb.step(data(n)), mb.pulse(data(n), start=random.uniform(0, 9), duration=0.1), mb.impulse(data(n))]
    try:
        A = mb.PolynomialMatrix([data(n, n), data(n, n) * random.integers(0, 2), data(n, n) * (random.random((n, n)) > 0.3)])
        x = mb.solve(A, data(2, n), forces[random.integers(len(forces))])
        assert np.isfinite(x([0.1, 1.0])).all() and np.isfinite(x.derivative(1)(0.5)).all()
        assert isinstance(x.notices, tuple) and isinstance(x.evidence, tuple)
    except mb.MbconstrainedError as reason:
        assert str(reason)
