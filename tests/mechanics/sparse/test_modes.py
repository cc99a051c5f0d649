"""Modes of large sparse systems against formulas, dense decompositions, and each other."""

import numpy as np
import pytest
import scipy.linalg
import scipy.sparse as sp
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.mechanics.sparse import sparse_modes as quadratic
from mbconstrained.mechanics.sparse import undamped_modes as undamped
from tests.mechanics.sparse.models import dense, line, membrane, random_tied, ring, tied_chain, ties


@pytest.fixture(params=[undamped.DENSE, 0], ids=["dense", "lanczos"])
def both_ways(request, monkeypatch):
    """The dense decomposition of small systems, and Lanczos's method for them too."""
    monkeypatch.setattr(undamped, "DENSE", request.param)


def holds(modes):
    """What every answer must show: residuals below their bounds, orthogonality, no mode missing."""
    assert (modes.residuals <= modes.bounds).all()
    assert modes.orthogonality < 1e-10
    assert modes.none_missed
    return True


def rigid(modes):
    return sum(mode.kind == "rigid body" for mode in modes)


@pytest.mark.parametrize("n", [1, 2, 3, 10, 60])
def test_chain_between_walls(n, both_ways):
    """w_i = 2 sin(i pi / (2 (n + 1))) for unit masses and springs (Lagrange)."""
    K = line(n) if n > 1 else sp.csc_array([[2.0]])
    modes = mb.MechanicalSystem(sp.eye_array(n), stiffness=K).modes(count=7)
    exact = 2 * np.sin(np.arange(1, min(n, 7) + 1) * np.pi / (2 * (n + 1)))
    assert np.allclose(modes.natural_frequencies, exact, rtol=1e-12) and holds(modes)
    assert np.allclose(modes.frequencies_hz, exact / (2 * np.pi), rtol=1e-12)
    assert np.allclose(modes.shapes.T @ modes.shapes, np.eye(len(modes)), atol=1e-12)
    assert modes.complete == (n <= 7) and (modes.damping_ratios == 0).all()


@pytest.mark.parametrize("n", [4, 25, 60])
def test_free_chain_has_one_rigid_body(n, both_ways):
    """w_i = 2 sin(i pi / (2 n)), i = 0, 1, ..."""
    modes = mb.MechanicalSystem(sp.eye_array(n), stiffness=line(n, (0.0, 0.0))).modes(count=4)
    assert np.allclose(modes.natural_frequencies, 2 * np.sin(np.arange(1, 4) * np.pi / (2 * n)), rtol=1e-10, atol=0)
    assert holds(modes) and [mode.kind for mode in modes] == ["rigid body", "oscillation", "oscillation", "oscillation"]
    assert np.allclose(modes.vectors[:, 0], modes.vectors[0, 0], rtol=1e-9) and modes.shapes.shape == (n, 3)


@pytest.mark.parametrize("n, count", [(30, 7), (1500, 12)])
def test_ring_has_pairs_of_equal_frequencies(n, count):
    """w_i = 2 sin(i pi / n), each but the first twice."""
    modes = mb.MechanicalSystem(sp.eye_array(n), stiffness=ring(n)).modes(count=count)
    exact = 2 * np.sin((np.arange(1, count) + 1) // 2 * np.pi / n)
    assert rigid(modes) == 1 and np.allclose(modes.natural_frequencies, exact, rtol=1e-9) and holds(modes)


def test_square_membrane():
    """w_ij^2 = 4 sin^2(i pi / (2 (n + 1))) + 4 sin^2(j pi / (2 (n + 1)))."""
    n, count = 40, 25
    modes = mb.MechanicalSystem(sp.eye_array(n * n), stiffness=membrane(n)).modes(count=count)
    squares = 4 * np.sin(np.arange(1, n + 1) * np.pi / (2 * (n + 1))) ** 2
    exact = np.sort(np.add.outer(squares, squares).ravel())[:count] ** 0.5
    assert np.allclose(modes.natural_frequencies, exact, rtol=1e-11) and holds(modes)


def test_equal_parts_that_do_not_touch(both_ways):
    """Forty equal free chains: forty rigid bodies, then each frequency forty times, more often than a block is wide."""
    part, copies = line(12, (0.0, 0.0)), 40
    system = mb.MechanicalSystem(sp.eye_array(12 * copies), stiffness=sp.block_diag([part] * copies))
    modes = system.modes(count=copies + 5)
    assert rigid(modes) == copies and modes.none_missed
    assert np.allclose(modes.natural_frequencies, 2 * np.sin(np.pi / 24), rtol=1e-9)
    assert any("larger group of equal frequencies" in notice.text for notice in modes.notices)


@pytest.mark.parametrize("n", [10, 20, 60])
@pytest.mark.parametrize("damped", [False, True])
def test_ties_and_massless_joints_against_the_dense_engine(n, damped, both_ways):
    M, C, K, rows = tied_chain(n, damped)
    modes = mb.MechanicalSystem(M, C, K, rows).modes(count=8)
    expected = np.array([mode.eigenvalue for mode in dense(M, C, K, rows).modes().oscillating[:8]])
    assert np.abs(modes.eigenvalues - expected).max() < 1e-12 * np.abs(expected).max() and holds(modes)
    assert np.abs(rows @ modes.shapes).max() == 0.0
    A = dense(M, C, K, rows).polynomial_matrix()
    for value, shape in zip(modes.eigenvalues, modes.vectors.T):
        assert np.linalg.norm(A(value) @ shape) < 1e-12 * np.linalg.norm(shape)


def test_modal_damping_needs_no_other_shapes():
    """s^2 + (a + b w^2) s + w^2 = 0 for C = a M + b K (Rayleigh)."""
    M, _, K, rows = tied_chain(40)
    modes, free = (mb.MechanicalSystem(M, C, K, rows).modes(count=10) for C in (0.02 * M + 0.03 * K, None))
    w = free.natural_frequencies
    half = (0.02 + 0.03 * w**2) / 2
    assert np.allclose(modes.eigenvalues, -half + 1j * np.sqrt(w**2 - half**2), rtol=1e-11)
    assert np.allclose(modes.damping_ratios, half / w, rtol=1e-11)
    assert np.allclose(mb.MechanicalSystem(M, 0.1 * M, K, rows).modes(count=10, damped=False).natural_frequencies, w, rtol=1e-12)


def test_overdamped_modes_decay():
    """All zeros are real where (a / 2)^2 > w^2."""
    n = 30
    w = 2 * np.sin(np.arange(1, n + 1) * np.pi / (2 * (n + 1)))
    modes = mb.MechanicalSystem(sp.eye_array(n), 5 * sp.eye_array(n), line(n)).modes(count=n)
    slow = -(w**2) / (2.5 + np.sqrt(2.5**2 - w**2))
    assert np.allclose(modes.eigenvalues, np.sort(np.concatenate([slow, -5 - slow]))[::-1][:n], rtol=1e-10)
    assert {mode.kind for mode in modes} == {"decay"}


def membrane_with_dampers():
    """A square membrane, whose frequencies come in pairs, with dampers that hardly tell them apart."""
    n = 20
    C = sp.diags_array(1e-3 * (np.arange(n * n) % 7 == 0))
    return sp.csc_array(sp.eye_array(n * n)), sp.csc_array(C), membrane(n)


def test_dampers_tell_modes_of_equal_frequencies_apart():
    """All zeros are found, and those of a dense decomposition, though pairs of them differ by 1e-11 of themselves."""
    M, C, K = membrane_with_dampers()
    modes = mb.MechanicalSystem(M, C, K).modes(count=13)
    states = sp.block_array([[None, M], [-K, -C]], format="csc")
    exact = scipy.linalg.eigvals(states.toarray())
    exact = sorted(exact[exact.imag > 0], key=abs)[:13]
    assert len(modes) == 13 and modes.notices == () and (modes.residuals <= modes.bounds).all()
    assert np.abs(np.sort(np.abs(modes.eigenvalues)) - np.abs(exact)).max() < 1e-12
    assert np.linalg.matrix_rank(modes.vectors, tol=1e-3 * np.linalg.norm(modes.vectors, 2)) == 13


@pytest.mark.parametrize("narrow", [0, 8], ids=["mixed", "banded"])
@pytest.mark.parametrize("size", [1e-3, 1.0, 100.0])
@pytest.mark.parametrize("walls", [True, False])
def test_both_ways_to_damped_modes_agree_with_the_dense_engine(narrow, size, walls, both_ways, monkeypatch):
    """Corrections with one factorization, and Newton's method with banded factors for each zero."""
    monkeypatch.setattr(quadratic, "NARROW", narrow)
    M, C, K, rows = tied_chain(40, damped=True, walls=walls)
    modes = mb.MechanicalSystem(M, size * C, K, rows).modes(count=8)
    expected = np.array([mode.eigenvalue for mode in dense(M, size * C, K, rows).modes().oscillating[:8]])
    expected = expected[: len(modes.oscillating)]
    assert np.abs(modes.eigenvalues[modes.eigenvalues.imag > 0] - expected).max() < 1e-11 * np.abs(expected).max()
    assert (modes.residuals <= modes.bounds).all() and rigid(modes) == (not walls)


def test_zeros_that_do_not_converge_are_told():
    """A damper that swallows waves leaves no mode near an undamped one: what is returned is right, and the rest is told."""
    n = 300
    system = mb.MechanicalSystem(sp.eye_array(n), sp.diags_array(np.eye(n)[0]), line(n, (0.0, 0.0)))
    modes = system.modes(count=6)
    assert next(mode.kind for mode in modes) == "offset" and (modes.residuals <= modes.bounds).all()
    assert any(notice.doubtful and "did not converge" in notice.text for notice in modes.notices)


@given(st.integers(0, 10**6))
def test_random_systems_against_a_dense_null_space(seed):
    """Massless coordinates, rows that may depend on each other: eigenvalues of V^T K V, V^T M V with an orthonormal V."""
    random = np.random.default_rng(seed)
    M, K, A = random_tied(random, int(random.integers(4, 20)), int(random.integers(0, 4)))
    V = scipy.linalg.null_space(A.toarray()) if A.shape[0] else np.eye(M.shape[0])
    inverse = np.sort(scipy.linalg.eigvalsh(V.T @ M.toarray() @ V, V.T @ K.toarray() @ V))[::-1]
    finite = np.linalg.matrix_rank(V.T @ M.toarray() @ V)
    expected = 1 / inverse[: min(finite, 5)]
    system = mb.MechanicalSystem(M, None, K, A)
    modes = system.modes(count=5)
    assert np.allclose(modes.natural_frequencies**2, expected, rtol=1e-9) and holds(modes)
    assert len(system.notices) == A.shape[0] - (np.linalg.matrix_rank(A.toarray()) if A.shape[0] else 0)
    assert np.abs(A @ modes.shapes).max(initial=0.0) < 1e-12


@given(st.integers(0, 10**6))
def test_the_count_is_that_of_all_eigenvalues(seed):
    """Sylvester's law: the pivots' signs at any shift say how many eigenvalues lie below."""
    random = np.random.default_rng(seed)
    M, K, A = random_tied(random, int(random.integers(4, 25)), int(random.integers(0, 4)))
    pencil = mb.MechanicalSystem(M, None, K, A).pencil
    values = 1 / np.linalg.eigvals(np.linalg.solve(pencil.stiffness.toarray(), pencil.mass.toarray())).real.clip(1e-12)
    for shift in random.uniform(0, 5, 4):
        if np.abs(values - shift).min() > 1e-6:
            assert pencil.shifted(shift).negative in (None, int((values < shift).sum()))


@pytest.mark.parametrize("n", [100, 900])
def test_a_long_row_is_not_eliminated(n):
    """The mean is held: eigenvalues on the null space of a row of ones, and a multiple of the row is told."""
    ones = sp.csr_array(np.ones((1, n)))
    system = mb.MechanicalSystem(sp.eye_array(n), stiffness=line(n), constraints=[ones, 2 * ones])
    modes = system.modes(count=4)
    V = scipy.linalg.null_space(np.ones((1, n)))
    exact = scipy.linalg.eigvalsh(V.T @ line(n).toarray() @ V, subset_by_index=(0, 3)) ** 0.5
    assert np.allclose(modes.natural_frequencies, exact, rtol=1e-9) and holds(modes)
    assert np.abs(ones @ modes.shapes).max() < 1e-10 and len(system.notices) == 1


def test_negative_stiffness_grows():
    n = 500
    modes = mb.MechanicalSystem(sp.eye_array(n), stiffness=line(n) - 0.5 * sp.eye_array(n)).modes(count=4)
    exact = 0.5 - 4 * np.sin(np.arange(1, 5) * np.pi / (2 * (n + 1))) ** 2
    assert (
        np.allclose(modes.eigenvalues, exact**0.5, rtol=1e-10) and {mode.kind for mode in modes} == {"growth"} and modes.none_missed
    )
    assert any(notice.kind == "unstable" for notice in modes.notices)


def test_stiff_links_that_drown_the_soft_ones_are_told():
    """1e12 beside 1: an entry's rounding is more than the lowest w^2. The same links as rows lose nothing."""
    n, at = 200, np.arange(0, 190, 10)
    links = ties(at, at + 1, n)
    stiff = mb.MechanicalSystem(sp.eye_array(n), stiffness=line(n) + 1e12 * links.T @ links).modes(count=3)
    assert any(notice.doubtful and "rounding" in notice.text for notice in stiff.notices) and rigid(stiff) == 0
    tied = mb.MechanicalSystem(sp.eye_array(n), stiffness=line(n), constraints=links).modes(count=3)
    V = scipy.linalg.null_space(links.toarray())
    exact = scipy.linalg.eigvalsh(V.T @ line(n).toarray() @ V, subset_by_index=(0, 2)) ** 0.5
    assert np.allclose(tied.natural_frequencies, exact, rtol=1e-10) and tied.notices == ()


def test_ten_thousand_masses():
    """12000 coordinates, 1000 rows: residuals, count, and frequencies by Sturm's method on the condensed chain."""
    n = 10_000
    M, C, K, rows = tied_chain(n, damped=True)
    system = mb.MechanicalSystem(M, C, K, rows)
    modes, damped = system.modes(count=20, damped=False), system.modes(count=20)
    diagonal, mass = 2 * np.ones(n), 1 + 0.1 * np.sin(np.arange(n))
    exact = scipy.linalg.eigvalsh_tridiagonal(
        diagonal / mass, -1 / np.sqrt(mass[1:] * mass[:-1]), select="i", select_range=(0, 19), tol=1e-30
    )  # two springs of stiffness 2 in a row are one of stiffness 1
    assert np.allclose(modes.natural_frequencies**2, exact, rtol=1e-6) and holds(modes)
    assert modes.counted_below > modes.natural_frequencies[-1] and (modes.residuals < 1e-7).all()
    assert (damped.residuals <= damped.bounds).all() and (damped.residuals < 1e-7).all()
    assert (damped.damping_ratios > 0).all() and np.allclose(damped.natural_frequencies, modes.natural_frequencies, rtol=1e-3)


@pytest.mark.parametrize("mass, count", [(np.zeros(4), 0), (np.array([1.0, 0, 0, 2.0]), 2), (np.ones(4), 4)])
def test_fewer_modes_than_asked_for(mass, count, both_ways):
    modes = mb.MechanicalSystem(sp.diags_array(mass), stiffness=line(4)).modes(count=9)
    assert len(modes) == count and modes.complete and modes.none_missed and modes.shapes.shape == (4, count)
    assert any("fewer than" in notice.text for notice in modes.notices)


def test_dense_systems_take_a_count_too():
    system = mb.MechanicalSystem(np.eye(5), stiffness=line(5).toarray())
    assert np.array_equal(system.modes(count=2).natural_frequencies, system.modes().natural_frequencies[:2])
    assert len(system.modes(count=99)) == 5
    with pytest.raises(mb.InputError, match="count"):
        system.modes(count=0)
