"""Matrices by their elements: what is refused, how far apart they are, and where they are taken."""

import numpy as np
import pytest

import mbconstrained as mb


def test_an_entry_beyond_the_range_is_told():
    for make in (
        lambda: mb.ElementMatrix([[1e200]], [1e200]).matrix,
        lambda: mb.MechanicalSystem(mass=mb.ElementMatrix([[1e200]], [1e200])),
        lambda: mb.PolynomialMatrix([mb.ElementMatrix([[1e200]], [1e200])]),
    ):
        with pytest.raises(mb.InputError, match="an entry beyond the range of float64"):
            make()


@pytest.mark.parametrize(
    ("constants", "spread"), [([], 1.0), ([0.0], 1.0), ([2.0, 0.0, -8.0], 4.0), ([1e-300, 1e300], np.finfo(float).max)]
)
def test_the_spread_is_a_finite_number(constants, spread):
    assert mb.ElementMatrix(np.ones((len(constants), 1)), constants).spread == spread


def test_a_polynomial_matrix_takes_elements_and_keeps_their_digits():
    springs = mb.ElementMatrix([[1, 0], [-1, 1]], [1.0, 1e16])
    A = mb.PolynomialMatrix([springs, np.zeros((2, 2)), np.eye(2)])
    assert A.exact_coefficients[0][0, 0] == 10**16 + 1
    slow = min(abs(zero.value) for zero in A.structure().finite_zeros)
    assert slow == pytest.approx(0.5**0.5, rel=1e-14)


def test_it_is_shown_in_one_line():
    assert repr(mb.ElementMatrix([[1, 0], [-1, 1]], [2.0, 3.0])) == "ElementMatrix(2 coordinates, 2 elements)"


@pytest.mark.parametrize("of", [["velocity"], {"velocity"}, 3, "velocty", None])
def test_the_quantity_of_an_error_estimate_is_a_word(of):
    motion = mb.MechanicalSystem(mass=[[1.0]], stiffness=[[1.0]], names=["a"]).solve(displacement=[1.0])
    assert repr(motion) == "Motion(1 coordinate: a; 0 jumps and 0 impulses at t = 0; 0 events later)"
    with pytest.raises(mb.InputError, match="of: found .*; expected one of displacement, velocity, acceleration, reaction"):
        motion.error_estimate(1.0, of=of)
    assert motion.error_estimate([0.5, 1.0], order=1) == motion.error_estimate([0.5, 1.0], of="velocity")
