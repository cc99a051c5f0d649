"""Zeros, poles and gains of single inputs and outputs."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.control.rational import rational_function
from mbconstrained.control.state_equations import rational_transfer, roots_of
from mbconstrained.control.state_space import StateSpace


def values(zeros):
    return sorted(((complex(z.value), z.multiplicity) for z in zeros), key=lambda pair: (pair[0].real, pair[0].imag))


def test_zeros_poles_and_gains_of_two_outputs():
    system = StateSpace([[0, 1], [-2, -3]], [[0], [1]], [[1, 0], [3, 2]], [[0], [0]], outputs=["place", "mix"])
    place, mix = system.transfer("place"), system.transfer("mix", "u1")  # 1/(s+1)(s+2), (2 s + 3)/(s+1)(s+2)
    assert place.zeros == () and [z for z, _ in values(place.poles)] == pytest.approx([-2, -1], rel=1e-14)
    assert [z for z, _ in values(mix.zeros)] == pytest.approx([-1.5], rel=1e-14)
    assert (place.gain, mix.gain, place.dc_gain, mix.dc_gain) == pytest.approx((1, 2, 0.5, 1.5), rel=1e-14)
    assert mix.numerator == pytest.approx([2, 3], rel=1e-14) and mix.denominator == pytest.approx([1, 3, 2], rel=1e-14)


def test_complex_and_repeated_roots():
    system = StateSpace.from_transfer_function(3 * np.poly([-1 + 2j, -1 - 2j]).real, np.poly([-4, -4, -1j, 1j]).real)
    found = system.transfer()
    assert values(found.zeros) == [(pytest.approx(-1 + 2j, rel=1e-13), 1)]
    assert [multiplicity for _, multiplicity in values(found.poles)] == [2, 1]
    assert found.gain == pytest.approx(3, rel=1e-12) and found.dc_gain == pytest.approx(15 / 16, rel=1e-13)
    assert len(roots_of(found.poles)) == 4


def test_poles_at_zero_have_no_dc_gain_unless_a_zero_lies_there():
    assert StateSpace([[0.0]], [[1.0]], [[1.0]]).transfer().dc_gain is None
    # s/(s (s + 1)): the pole at 0 is not seen, G(0) = 1
    assert StateSpace([[0, 1], [0, -1.0]], [[0.0], [1.0]], [[0.0, 1.0]]).transfer().dc_gain == pytest.approx(1, rel=1e-14)
    assert StateSpace([[-1.0]], [[1.0]], [[-1.0]], [[1.0]]).transfer().dc_gain == 0.0  # s/(s + 1)


def test_what_the_input_does_not_reach():
    found = StateSpace(np.diag([-1.0, -2.0]), [[1.0], [0.0]], [[0.0, 1.0]]).transfer()
    assert (found.zeros, found.gain, found.dc_gain) == ((), 0.0, 0.0)
    assert found.numerator.tolist() == [0.0]


def test_zero_is_told_from_rounding_of_the_states():
    """(s E - A) x = B has x1 = 0: [[-2, s], [-s - 2, s]] (0, 1/s) = (1, 1); solving leaves a rounding of x1."""
    found = StateSpace([[2, 0], [2, 0]], [[1], [1]], [[-1, 0]], descriptor=[[0, 1], [-1, 1]]).transfer()
    assert (found.zeros, found.gain, found.dc_gain) == ((), 0.0, 0.0)
    assert [zero.value for zero in found.poles] == [0] and found.poles[0].multiplicity == 2


def test_more_zeros_than_poles():
    # y = u' + u/(s + 1)
    system = StateSpace(
        [[1, 0, 0], [0, 1, 0], [0, 0, -1]], [[0], [1], [1]], [[-1, 0, 1]], descriptor=[[0, 1, 0], [0, 0, 0], [0, 0, 1]]
    )
    found = system.transfer()  # s + 1/(s + 1) = (s^2 + s + 1)/(s + 1)
    assert found.numerator == pytest.approx([1, 1, 1], rel=1e-13) and found.denominator == pytest.approx([1, 1], rel=1e-14)


def test_zeros_hidden_by_rounding_are_not_invented():
    """Relative degree 5 behind a random change of states: C A^4 B = 3 is 1e-17 of what it is the sum of."""
    import scipy.signal

    matrices = scipy.signal.zpk2ss([-1, -2 + 1j, -2 - 1j], [-3, -4, -5, -0.1 + 2j, -0.1 - 2j, -7, -8, -1], 3.0)
    Q = np.random.default_rng(0).normal(size=(8, 8))
    system = StateSpace(np.linalg.solve(Q, matrices[0] @ Q), np.linalg.solve(Q, matrices[1]), matrices[2] @ Q, matrices[3])
    with pytest.raises(mb.IllConditioned, match="from u1 to y1: rounding of A, B, C and D hides the zeros"):
        system.transfer()


@pytest.mark.parametrize("masses", [6, 10, pytest.param(30, marks=pytest.mark.long)])
def test_zeros_are_right_or_refused(masses):
    """A chain of unit masses, 100 N/m and 0.5 N s/m between: from the last to the first (0.5 s + 100)^(n - 1) stands above."""
    K = 2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    A = np.block([[np.zeros((masses, masses)), np.eye(masses)], [-100 * K, -0.5 * K]])
    Q, _ = np.linalg.qr(np.random.default_rng(masses).normal(size=A.shape))
    for S in (np.eye(2 * masses), Q):
        system = StateSpace(S @ A @ S.T, S[:, -1:], S[:, :1].T)
        try:
            found = system.transfer()
        except mb.IllConditioned:
            continue
        assert sum(zero.count for zero in found.zeros) == masses - 1
        assert found.gain == pytest.approx(0.5 ** (masses - 1), rel=1e-4)
        assert found.dc_gain == pytest.approx(1 / (100 * (masses + 1)), rel=1e-12)


def test_a_gain_beyond_the_poles_at_zero():
    found = StateSpace([[0.0, 1.0], [0.0, 0.0]], [[0.0], [3.0]], [[1.0, 0.0]]).transfer()  # 3/s^2
    assert found.gain == pytest.approx(3, rel=1e-14) and found.dc_gain is None and found.zeros == ()


@pytest.mark.parametrize("key", ["z1", 2, -1, True, 0.0])
def test_unknown_inputs_and_outputs(key):
    with pytest.raises(mb.InputError, match="output: found .*; expected one of y1, or a number from 0"):
        StateSpace([[-1.0]], [[1.0]], [[1.0]]).transfer(key)


def test_fractions_of_polynomials():
    found = rational_transfer(rational_function([2, 2, 0], [1, 6, 5, 0]))  # 2 s (s + 1) / s (s + 1)(s + 5)
    assert found.zeros == () and values(found.poles) == [(-5, 1)]
    assert (found.gain, found.dc_gain) == (2.0, 0.4)
    assert rational_transfer(rational_function([1], [1, 0])).dc_gain is None
    assert rational_transfer(rational_function([0], [1, 1])).gain == 0.0
