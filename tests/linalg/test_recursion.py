"""Exponentials and steps at many times, and the scalars of a decoupled matrix: against exponentials and one step after the other."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import csr_array

from mbconstrained.linalg.blocks import block_diagonalize
from mbconstrained.linalg.exponential import block_states
from mbconstrained.linalg.recursion import ModalBasis, recursion, scanned, shared_gaps, values_of_steps

BLOCKS = [
    np.array([[-0.5]]),
    np.array([[0.1, 2.0], [-3.0, 0.1]]),
    np.eye(4, k=1),
    np.array([[-1.0, 1.0, 0.5], [0.0, -1.0, 1.0], [0.0, 0.0, -1.1]]),
    np.array([[0.0]]),
]
SIZE = sum(map(len, BLOCKS))
RANDOM = np.random.default_rng(0)


def exponential(time) -> np.ndarray:
    with mpmath.workdps(40):
        J = mpmath.matrix(scipy.linalg.block_diag(*BLOCKS))
        return np.array(mpmath.expm(J * mpmath.mpf(time)).tolist(), dtype=float)


@pytest.mark.parametrize("gaps", [np.full(7, 0.3), RANDOM.uniform(0.0, 2.0, 7), np.zeros(3)], ids=["equal", "different", "none"])
def test_it_is_the_recursion(gaps):
    start, gained = RANDOM.normal(size=SIZE), RANDOM.normal(size=(SIZE, len(gaps)))
    known = [start]
    for gap, g in zip(gaps, gained.T):
        known.append(exponential(gap) @ known[-1] + g)
    assert np.allclose(recursion(BLOCKS, start, gained, gaps), np.array(known).T, rtol=1e-13, atol=1e-13)


def test_growth_that_is_not_excited_stays_out_however_long_the_gap():
    blocks = [np.array([[1.0]]), np.array([[-1.0]]), np.eye(3) + np.eye(3, k=1)]
    states = recursion(blocks, np.array([0.0, 1.0, 0, 0, 0]), np.zeros((5, 2)), np.array([1e4, 1.0]))
    assert not states[:, 1:].any()


@pytest.mark.parametrize("few", [1, 3], ids=["equal gaps", "three lengths of gaps"])
@pytest.mark.parametrize("count", [63, 64, 200, 401])
def test_many_steps_are_taken_in_groups_without_losing_digits(few, count):
    lengths = RANDOM.uniform(0.01, 0.1, few)
    matrices = [exponential(gap) for gap in lengths]
    which = RANDOM.integers(few, size=count)
    start, gained = RANDOM.normal(size=SIZE), RANDOM.normal(size=(SIZE, count))
    known = [start]
    for place, g in zip(which, gained.T):
        known.append(matrices[place] @ known[-1] + g)
    known = np.array(known).T
    size = np.abs(known).max(axis=1, keepdims=True)
    assert (np.abs(recursion(BLOCKS, start, gained, lengths[which]) - known) <= 1e-12 * size).all()


def test_groups_that_would_leave_the_range_are_taken_step_by_step():
    gaps = np.full(200, 400.0)
    states = recursion([np.array([[1.0]]), np.array([[-1.0]])], np.array([0.0, 1.0]), np.zeros((2, 200)), gaps)
    assert not states[0].any() and states[1, 1] == np.exp(-400.0) and not states[1, 5:].any()


def test_gaps_that_creep_apart_are_not_taken_for_the_same():
    gaps = 1.0 + 2.0**-45 * np.arange(2000)  # each differs from the next by less than the rounding of the last time
    assert np.array_equal(shared_gaps(np.append(0.0, np.cumsum(gaps))), np.diff(np.append(0.0, np.cumsum(gaps))))


def one_by_one(output, step, drive, start, inputs):
    """In fractions, rounded once."""
    exact = [np.array([[Fraction(x) for x in row] for row in np.atleast_2d(part)]) for part in (output, step, drive, inputs)]
    output, step, drive, inputs = exact
    z, found = np.array([Fraction(x) for x in start]), []
    for v in inputs.T:
        found.append(output @ z)
        z = step @ z + drive @ v
    return np.array([*found, output @ z], dtype=float).T


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.integers(0, 3), st.integers(0, 40), st.booleans())
def test_it_is_one_step_after_the_other(seed, rows, driven, count, sparse):
    random = np.random.default_rng(seed)
    step = np.linalg.qr(random.normal(size=(4, 4)))[0]
    drive, start, inputs = random.normal(size=(4, driven)), random.normal(size=4), random.normal(size=(driven, count))
    output = np.round(random.normal(size=(rows, 4)))
    known = one_by_one(output, step, drive, start, inputs) if count and driven else None
    found = values_of_steps(csr_array(output) if sparse else output, step, drive, start, inputs)
    assert found.shape == (rows, count + 1)
    if known is not None:
        assert np.allclose(found, known, rtol=0, atol=1e-13 * (1 + np.abs(known).max()))


def test_unused_states_are_not_made_and_the_values_are_the_same():
    random = np.random.default_rng(0)
    step, drive = 0.2 * random.normal(size=(9, 9)), random.normal(size=(9, 2))
    start, inputs = random.normal(size=9), random.normal(size=(2, 50))
    output = np.zeros((40, 9))
    output[:, 3] = random.normal(size=40)
    found = values_of_steps(csr_array(output), step, drive, start, inputs)
    assert np.allclose(found, output @ values_of_steps(np.eye(9), step, drive, start, inputs), rtol=0, atol=1e-13)


@given(st.integers(0, 2**32 - 1), st.integers(0, 60), st.booleans())
def test_scalars_side_by_side(seed, count, same):
    random = np.random.default_rng(seed)
    factors = np.exp(1j * random.normal(size=(1 if same else max(count, 1), 3)))
    states = random.normal(size=(count + 1, 3)) + 1j * random.normal(size=(count + 1, 3))
    known = [states[0]]
    for j in range(count):
        known.append(factors[j % len(factors)] * known[-1] + states[j + 1])
    scanned(states, factors)
    assert np.allclose(states, known, rtol=0, atol=1e-12)


# Complex scalars of a decoupled matrix, and what is left of it, against its exponential.

#: A defective pair at 0, a defective triple, simple zeros, and pairs of which one is far from a rotation.
MATRICES = {
    "simple": np.random.default_rng(2).normal(size=(7, 7)),
    "one": np.array([[-0.3]]),
    "drifting": scipy.linalg.block_diag([[0.0, 1.0], [0.0, 0.0]], [[0.1, 2.0], [-3.0, 0.4]], [[-1.0]]),
    "together": scipy.linalg.block_diag(-0.5 * np.eye(3) + np.eye(3, k=1), [[0.0, 1e3], [-1e-3, 0.0]]),
    "nothing simple": np.eye(4, k=1),
}


def modes_of(S: np.ndarray) -> ModalBasis:
    T, Q = scipy.linalg.schur(S)
    found = block_diagonalize(T)
    return ModalBasis.of(type(found)(Q @ found.basis, found.inverse @ Q.T, found.blocks, found.coupling))


@pytest.mark.parametrize("name", MATRICES)
def test_scalars_and_the_rest_make_the_states_and_move_as_they_do(name):
    S = MATRICES[name]
    modes, start = modes_of(S), np.arange(1.0, len(S) + 1)
    scalars, rest = modes.split(modes.decoupled.coordinates(start))
    assert (modes.rates.imag >= 0).all() and len(modes.rates) + len(rest) <= len(S)
    assert np.allclose(modes.states(scalars, rest), start, rtol=1e-12, atol=1e-12)
    scalars, rest = np.exp(0.7 * modes.rates) * scalars, block_states(modes.blocks, rest, np.array([0.7]))[:, 0]
    known = scipy.linalg.expm(0.7 * S) @ start
    assert np.allclose(modes.states(scalars, rest), known, rtol=0, atol=1e-12 * np.abs(known).max())


@pytest.mark.parametrize("order", [0, 1, 3])
@pytest.mark.parametrize("name", MATRICES)
def test_derivatives_of_an_output(name, order):
    S = MATRICES[name]
    modes, start, output = modes_of(S), np.ones(len(S)), RANDOM.normal(size=(2, len(S)))
    scalars, rest = modes.split(modes.decoupled.coordinates(start))
    own, others = modes.modal_output(output, order)
    known = output @ np.linalg.matrix_power(S, order) @ start
    size = (np.abs(output) @ np.linalg.matrix_power(np.abs(S), order) @ start).max()
    assert np.allclose(own @ scalars.view(float) + others @ rest, known, rtol=0, atol=1e-12 * size)
