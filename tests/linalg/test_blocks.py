"""Block diagonal form of real Schur forms: exact similarity, bounded decoupling, clusters together."""

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mbconstrained.linalg.blocks import block_diagonalize, block_eigenvalues, coupled


def schur(eigenvalue_list, coupling=1.0, seed=0) -> np.ndarray:
    """A real Schur form with these zeros (a complex number stands for its pair) and random entries above."""
    random = np.random.default_rng(seed)
    blocks = [[[z.real, z.imag], [-z.imag, z.real]] if isinstance(z, complex) else [[z]] for z in eigenvalue_list]
    T = scipy.linalg.block_diag(*blocks) if blocks else np.zeros((0, 0))
    mask = scipy.linalg.block_diag(*[np.ones_like(b) for b in blocks]) if blocks else np.zeros((0, 0))
    return T + coupling * np.triu(random.normal(size=T.shape), 1) * (1 - mask)


ZEROS = {
    "none": [],
    "one": [-1.0],
    "apart": [-1.0, 2.0, -3.0, -1 + 2j, 0.5],
    "equal": [-1.0, -1.0, -1.0],
    "equal but not neighbours": [-1.0, 5.0, -1.0, 5.0],
    "equal complex pairs": [-1 + 2j, 3.0, -1 + 2j],
    "close": [-1.0, 4.0, -1.0 - 1e-9, -1.0 + 1e-6],
    "stiff": [-1.0, -1e6, -1e12, -1e-6, -1e3 + 1e6j],
    "at the origin": [0.0, -1.0, 0.0, 2j, 0.0],
}


@pytest.mark.parametrize("name", ZEROS)
@pytest.mark.parametrize("coupling", [0.0, 1.0, 100.0])
def test_blocks_are_similar_to_the_schur_form(name, coupling):
    T = schur(ZEROS[name], coupling)
    result = block_diagonalize(T)
    J = scipy.linalg.block_diag(*result.blocks) if result.blocks else np.zeros((0, 0))
    size = np.abs(result.inverse) @ np.abs(T) @ np.abs(result.basis)
    assert (np.abs(result.inverse @ T @ result.basis - J) <= 1e-13 * (size.max(initial=0.0))).all()
    assert np.allclose(result.inverse @ result.basis, np.eye(len(T)), atol=1e-12 * max(1.0, result.coupling**2))


def test_coupled_equal_zeros_share_a_block_even_from_afar():
    sizes = sorted(len(b) for b in block_diagonalize(schur(ZEROS["equal but not neighbours"])).blocks)
    assert sizes == [2, 2]
    assert sorted(len(b) for b in block_diagonalize(schur(ZEROS["equal complex pairs"])).blocks) == [1, 4]


@given(
    st.lists(st.one_of(st.integers(-3, 1).map(float), st.builds(complex, st.integers(-2, 0), st.integers(1, 3))), max_size=6),
    st.integers(0, 5),
)
def test_any_schur_form_is_decoupled(zeros, seed):
    T = schur(zeros, seed=seed)
    result = block_diagonalize(T)
    assert sum(len(block) for block in result.blocks) == len(T)
    J = scipy.linalg.block_diag(*result.blocks) if result.blocks else np.zeros((0, 0))
    assert np.abs(T @ result.basis - result.basis @ J).max(initial=0.0) <= 1e-10 * (1 + result.coupling) ** 2
    for block in result.blocks:
        assert not np.tril(block, -2).any()


@given(st.integers(0, 9), st.integers(0, 12), st.floats(0.0, 0.5), st.integers(0, 10**6))
def test_components_are_those_of_the_graph_of_rows_and_columns(rows, columns, density, seed):
    """Against SciPy's connected components; in the order of their first rows, each with all that belongs to it."""
    pattern = np.random.default_rng(seed).random((rows, columns)) < density
    i, j = np.nonzero(pattern)
    graph = coo_array((np.ones(len(i)), (i, rows + j)), shape=(rows + columns,) * 2)
    labels = connected_components(graph, directed=False)[1] if rows + columns else np.zeros(0)
    known = [np.flatnonzero(labels == label) for label in dict.fromkeys(labels[:rows][pattern.any(axis=1)])]
    found = [np.concatenate([own, rows + others]).tolist() for own, others in coupled(pattern)]
    assert found == [members.tolist() for members in known]


def test_eigenvalues_of_pairs_that_are_coupled_alike():
    """Of [[a, b], [-b, a]] blocks those of complex numbers a + i b; couplings of 1e-26 next to them keep LAPACK from converging."""
    pair, coupling = np.array([[-0.07, 1.7], [-1.7, -0.07]]), np.array([[1e-26, 3.65e-11], [-3.65e-11, 1e-26]])
    block = np.block([[pair, coupling], [coupling, pair]])
    found = block_eigenvalues(block)
    expected = [-0.07 + (1.7 + sign * 3.65e-11) * 1j for sign in (1, -1)]
    for value in expected:
        assert np.abs(found - value).min() <= 1e-15
        assert np.abs(found - value.conjugate()).min() <= 1e-15
    assert np.array_equal(block_eigenvalues(np.array([block, block])), [found, found])
