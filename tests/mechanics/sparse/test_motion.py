"""The motion in some modes against the motion of the dense engine, and its bounds against what is really left out."""

import numpy as np
import pytest
import scipy.sparse as sp

import mbconstrained as mb
from tests.mechanics.sparse.models import dense, line, start, tied_chain

TIMES = np.linspace(0.0, 20.0, 21)


def damping(kind, M, K):
    """None, proportional, or dampers here and there."""
    if kind == "general":
        return tied_chain((M.shape[0] * 10) // 12, damped=True)[1]
    return {"none": None, "proportional": 0.01 * M + 0.02 * K}[kind]


def forces(size):
    """One of each kind, two that start or end later."""
    v = np.zeros(size)
    v[[3, size // 2]] = 1.0, -0.5
    return {
        "none": None,
        "step": mb.step(v),
        "ramp": mb.ramp(v),
        "harmonic": mb.harmonic(v, angular_frequency=0.3, phase=0.4),
        "term": mb.term(v, power=2, rate=-0.2, angular_frequency=0.5),
        "pulse": mb.step(v) - mb.step(v).delayed(3.0),
        "late": mb.harmonic(v, angular_frequency=2.0).delayed(1.5) + mb.step(2 * v),
    }


def energy_norm(M, K, x, v):
    return np.sqrt(np.maximum((v * (M @ v)).sum(axis=0) + (x * (K @ x)).sum(axis=0), 0.0))


@pytest.mark.parametrize("kind", ["none", "proportional", "general"])
@pytest.mark.parametrize("force", ["none", "step", "ramp", "harmonic", "term", "pulse", "late"])
def test_what_is_left_out_stays_below_its_bound(kind, force):
    """For all times, in the energy norm and coordinate by coordinate; equal to it at t = 0 if the force does not change later."""
    M, _, K, rows = tied_chain(20)
    C, values, applied = damping(kind, M, K), start(M, K, rows), forces(M.shape[0])[force]
    motion = mb.MechanicalSystem(M, C, K, rows).solve(*values, applied, count=6)
    exact = dense(M, C, K, rows).solve(*values, applied)
    x, v = exact(TIMES) - motion(TIMES), exact.velocity(TIMES) - motion.velocity(TIMES)
    rest = energy_norm(M, K, x, v)
    assert (rest <= motion.rest_norm * (1 + 1e-9)).all() and motion.bounded
    assert np.isclose(rest[0], motion.rest_norm, rtol=1e-9) or force in ("pulse", "late")
    assert (np.abs(x).max(axis=1) <= motion.bound(*range(M.shape[0])) * (1 + 1e-9)).all()
    assert 0 < motion.truncation < 1 and any(notice.kind == "omitted" for notice in motion.notices)


@pytest.mark.parametrize("kind", ["none", "proportional"])
@pytest.mark.parametrize("force", ["none", "step", "ramp", "harmonic", "term", "pulse", "late"])
def test_all_modes_give_the_whole_motion(kind, force):
    M, _, K, rows = tied_chain(20)
    C, values, applied = damping(kind, M, K), start(M, K, rows, seed=3), forces(M.shape[0])[force]
    motion = mb.MechanicalSystem(M, C, K, rows).solve(*values, applied)
    exact = dense(M, C, K, rows).solve(*values, applied)
    assert motion.rest_norm == 0 and motion.truncation == 0 and (motion.bound(0, 3) == 0).all()
    for ours, theirs in ((motion, exact), (motion.velocity, exact.velocity), (motion.acceleration, exact.acceleration)):
        assert np.abs(ours(TIMES) - theirs(TIMES)).max() < 1e-11 * np.abs(theirs(TIMES)).max()


@pytest.mark.parametrize("kind", ["none", "proportional", "general"])
def test_static_force_has_its_whole_deflection(kind):
    """From K^-1 f at rest nothing moves, though one mode alone would show a fraction of it."""
    M, _, K, rows = tied_chain(30)
    force = np.zeros(M.shape[0])
    force[4] = 1.0
    A = rows.toarray()
    whole = np.block([[K.toarray(), A.T], [A, np.zeros((len(A), len(A)))]])
    deflection = np.linalg.solve(whole, np.append(force, np.zeros(len(A))))[: M.shape[0]]
    motion = mb.MechanicalSystem(M, damping(kind, M, K), K, rows).solve(deflection, force=force, count=1)
    assert np.abs(motion(TIMES) - deflection[:, None]).max() < 1e-11 * np.abs(deflection).max()
    assert motion.truncation < 1e-10


@pytest.mark.parametrize("count", [3, 30])
def test_resonance_grows_in_proportion_to_time(count):
    """x_1 of x'' + w_1^2 x = cos(w_1 t) is t sin(w_1 t) / (2 w_1): the force along the first shape, at its frequency."""
    n = 30
    shape = np.sin(np.arange(1, n + 1) * np.pi / (n + 1))
    w = 2 * np.sin(np.pi / (2 * (n + 1)))
    system = mb.MechanicalSystem(sp.eye_array(n), stiffness=line(n))
    motion = system.solve(force=mb.harmonic(shape, angular_frequency=w), count=count)
    times = np.array([0.0, 1.0, 100.0, 1e4])
    assert np.abs(motion(times) - shape[:, None] * times * np.sin(w * times) / (2 * w)).max() < 1e-8 * 1e4


def test_free_body_under_a_step():
    """The centre of mass moves by F t^2 / (2 m), the rest as the dense engine says."""
    n = 40
    force = np.eye(n)[0]
    motion = mb.MechanicalSystem(sp.eye_array(n), stiffness=line(n, (0.0, 0.0))).solve(force=force, count=n)
    assert np.allclose(motion(TIMES).mean(axis=0), TIMES**2 / (2 * n), rtol=1e-10, atol=1e-13)
    exact = mb.MechanicalSystem(np.eye(n), stiffness=line(n, (0.0, 0.0)).toarray()).solve(force=force)
    assert np.abs(motion(TIMES) - exact(TIMES)).max() < 1e-11 * np.abs(exact(TIMES)).max()


def test_rigid_bodies_that_are_left_out_are_refused():
    """Two free chains, of which only one rigid motion is found: the force on the other has no static deflection."""
    K = sp.block_diag([line(5, (0.0, 0.0))] * 2)
    with pytest.raises(mb.InputError, match="count"):
        mb.MechanicalSystem(sp.eye_array(10), stiffness=K).solve(force={"x1": 1.0, "x10": -2.0}, count=1)


@pytest.mark.parametrize("long", [False, True])
def test_values_that_constraints_hold(long):
    """A x = b with b not zero, the row short or long."""
    n = 80
    row = np.ones((1, n)) if long else np.eye(n)[:1] - np.eye(n)[1:2]
    held = mb.Constraint(sp.csr_array(row), value=0.5)
    x0 = np.random.default_rng(1).standard_normal(n)
    x0 += row[0] * (0.5 - row[0] @ x0) / (row[0] @ row[0])
    x0[0] += 0.5 - row[0] @ x0
    motion = mb.MechanicalSystem(sp.eye_array(n), stiffness=line(n), constraints=[held]).solve(x0, count=n)
    exact = mb.MechanicalSystem(np.eye(n), stiffness=line(n).toarray(), constraints=[mb.Constraint(row, value=0.5)]).solve(x0)
    assert np.abs(motion(TIMES) - exact(TIMES)).max() < 1e-11 and np.abs(row @ motion(TIMES) - 0.5).max() < 1e-11


def test_massless_coordinates_jump_to_their_place():
    """A joint between two springs follows its neighbours wherever it is put at 0-, and that is told."""
    M, K = sp.diags_array([1.0, 0.0, 2.0]), line(3)
    motion = mb.MechanicalSystem(M, stiffness=K).solve([1.0, 5.0, 0.0])
    exact = dense(M, None, K).solve([1.0, 5.0, 0.0])
    assert np.abs(motion(TIMES) - exact(TIMES)).max() < 1e-13
    assert any(notice.kind == "jump" for notice in motion.notices)


def test_energy_put_in_by_dampers_voids_the_bound():
    motion = mb.MechanicalSystem(sp.eye_array(50), -0.01 * sp.eye_array(50), line(50)).solve({"x3": 1.0}, count=5)
    assert not motion.bounded and any(notice.doubtful for notice in motion.notices)


def test_own_force_counts():
    system = mb.MechanicalSystem(sp.eye_array(3), stiffness=line(3), force=[1.0, 0, 0], static_force=[0, 0, 2.0])
    other = mb.MechanicalSystem(sp.eye_array(3), stiffness=line(3))
    assert np.allclose(system.solve()(TIMES), other.solve(force=[1.0, 0, 2.0])(TIMES), atol=1e-14)
    driven = mb.MechanicalSystem(sp.eye_array(3), stiffness=line(3), force=mb.ramp([1.0, 0, 0]), static_force=[0, 0, 2.0])
    expected = other.solve(force=mb.ramp([1.0, 0, 0]) + mb.step([0, 0, 2.0]))
    assert np.allclose(driven.solve()(TIMES), expected(TIMES), atol=1e-14)


def test_ten_thousand_masses_few_coordinates():
    """12000 coordinates: the middle of a chain that is let go from its first shape, and the bound on what is left out."""
    M, _, K, rows = tied_chain(10_000)
    system = mb.MechanicalSystem(M, None, K, rows)
    modes = system.modes(count=20)
    motion = system.solve(modes.shapes[:, 0] + 0.1 * modes.shapes[:, 15], count=20)
    w = modes.natural_frequencies
    times = np.linspace(0, 1e6, 50)
    exact = modes.shapes[[5000], [0]] * np.cos(w[0] * times) + 0.1 * modes.shapes[[5000], [15]] * np.cos(w[15] * times)
    assert np.abs(motion.of(5000)(times)[0] - exact).max() < 1e-9 * np.abs(exact).max()
    assert motion.truncation < 1e-6


@pytest.mark.parametrize("seed", range(8))
def test_a_start_may_be_off_by_the_rounding_of_its_projection(seed):
    """Of x - A^+ A x an entry near zero has the rounding of x, not its own."""
    row, x = np.array([[1.0, -0.7, 0.0]]), np.random.default_rng(seed).normal(size=3)
    x[0] = -x[1] / 0.7 + 1e-6 * seed  # nearly along the row: little is left of the first two
    projected = x - np.linalg.pinv(row) @ (row @ x)
    unit = sp.eye_array(3, format="csr")
    system = mb.MechanicalSystem(unit, stiffness=unit, constraints=[mb.Constraint(row)])
    assert np.allclose(system.solve(projected)(0.0), projected, rtol=0, atol=1e-14)
    with pytest.raises(mb.InputError, match="has the value 0, the values at 0- give"):
        system.solve(projected + [1e-12, 0, 0])


@pytest.mark.parametrize("kind", ["none", "proportional", "general"])
def test_reactions_of_all_modes_are_those_of_the_dense_engine(kind):
    M, _, K, rows = tied_chain(20)
    C, values, applied = damping(kind, M, K), start(M, K, rows), forces(M.shape[0])["late"]
    redundant = sp.vstack([rows, rows[[0]] - rows[[1]]], format="csr")
    motion = mb.MechanicalSystem(M, C, K, redundant).solve(*values, applied, count=M.shape[0])
    expected = dense(M, C, K, rows).solve(*values, applied).reaction(TIMES)
    assert motion.row_names == tuple(f"constraint {i + 1}" for i in range(rows.shape[0]))
    assert np.abs(motion.reaction(TIMES) - expected).max() <= 1e-9 * np.abs(expected).max()
    assert motion.reaction(1.0).shape == (rows.shape[0],)


def test_a_static_load_has_its_whole_reaction_whatever_the_number_of_modes():
    """A chain that hangs from a row on its first mass: in equilibrium the row carries the weight."""
    weights = np.linspace(1.0, 2.0, 50)
    K = line(50, ends=(0.0, 0.0))
    system = mb.MechanicalSystem(sp.diags_array(weights), None, K, sp.csr_array(np.eye(1, 50)), static_force=weights)
    rest = np.zeros(50)
    rest[1:] = np.linalg.solve(K.toarray()[1:, 1:], weights[1:])
    assert np.isclose(system.solve(rest, count=3).reaction(7.0)[0], -weights.sum(), rtol=1e-9)
    assert mb.MechanicalSystem(sp.eye_array(3), None, K[:3][:, :3]).solve(count=2).reaction(TIMES).shape == (0, len(TIMES))


@pytest.mark.parametrize("time", [1.0, 1e4, 1e8])
def test_the_rounding_error_is_estimated(time):
    """Against the closed form of one undamped mode of a chain between two walls."""
    n, j = 60, 7
    shape, w = np.sin(np.arange(1, n + 1) * j * np.pi / (n + 1)), 2 * np.sin(j * np.pi / (2 * (n + 1)))
    motion = mb.MechanicalSystem(sp.eye_array(n), None, line(n)).solve(shape, count=20)
    times = time * np.linspace(0.9, 1.1, 50)
    error = np.abs(motion(times) - np.outer(shape, np.cos(w * times))).max()
    assert error / 10 <= motion.error_estimate(times) * np.abs(shape).max() <= max(1e3 * error, 1e-12 * time)


@pytest.mark.parametrize("n, place, stiffness", [(30, slice(None), 2.0**-47), (100, 0, 4e-14), (200, 0, 1e-13)])
def test_a_tiny_ground_spring_of_a_free_chain_counts(n, place, stiffness):
    """All masses move together on the sum of the ground springs, as given in float64, the elastic deflection below 1e-11."""
    K = line(n, ends=(0.0, 0.0)).toarray()
    K[np.arange(n)[place], np.arange(n)[place]] += stiffness
    ground, K = float(K.astype(np.longdouble).sum()), sp.csc_array(K)
    system = mb.MechanicalSystem(sp.eye_array(n), None, K)
    assert np.isclose(system.modes(count=3).natural_frequencies[0], (ground / n) ** 0.5, rtol=1e-9)
    assert np.allclose(system.solve(np.ones(n), count=3)(1e7), np.cos((ground / n) ** 0.5 * 1e7), atol=1e-8)


@pytest.mark.parametrize("n", [2, 3, 40, 500])
def test_a_free_chain_of_any_springs_is_free(n):
    springs = np.random.default_rng(n).uniform(0.1, 3.0, n - 1)
    B = sp.diags_array([-np.ones(n - 1), np.ones(n - 1)], offsets=[0, 1], shape=(n - 1, n))
    modes = mb.MechanicalSystem(sp.eye_array(n), None, B.T @ sp.diags_array(springs) @ B).modes(count=2)
    assert [mode.kind for mode in modes] == ["rigid body", "oscillation"]
