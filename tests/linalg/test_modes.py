"""Complex scalars of a decoupled matrix, and what is left of it, against its exponential."""

import numpy as np
import pytest
import scipy.linalg

from mbconstrained.linalg.blocks import block_diagonalize
from mbconstrained.linalg.exponential import block_states
from mbconstrained.linalg.recursion import ModalBasis

RANDOM = np.random.default_rng(2)

#: A defective pair at 0, a defective triple, simple zeros, and pairs of which one is far from a rotation.
MATRICES = {
    "simple": RANDOM.normal(size=(7, 7)),
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
