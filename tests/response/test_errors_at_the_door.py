"""What solve and its answer refuse, and the words they use."""

from __future__ import annotations

import numpy as np
import pytest

import mbconstrained as mb

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
        (mb.step([1.0]), "force: it has 1 rows, but A\\(s\\) has 2"),
        ([1.0, 2.0], "force: found list; make it with mb.step, mb.ramp, mb.harmonic, mb.term or mb.impulse"),
        (np.sin, "force: found ufunc; make it with"),
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
        ("1 s", "time: found .*'1 s'.*; expected numbers"),
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
