"""Damping of modes and proportional damping: the modes of the damped system against their definition."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

import mbconstrained as mb


def machine():
    """A massless joint, a rack and a free body: M is singular, one row constrains, one motion is free."""
    model = mb.LumpedModel()
    model.mass("a", 2.0)
    model.node("joint")
    model.mass("b", 3.0)
    model.inertia("wheel", 0.5)
    model.mass("c", 1.0)
    model.spring("a", "joint", 5.0)
    model.spring("joint", "b", 7.0)
    model.rack("wheel", "b", 0.3)
    model.spring("b", "c", 100.0)
    return model.assemble()


@example([0.875, 0.001])  # of which rounding errors would damp the rigid-body motion
@given(st.lists(st.floats(0.001, 0.9), min_size=1, max_size=2))
def test_each_mode_has_its_ratio_and_keeps_its_frequency(ratios):
    """Eigenvalues -zeta w +- i w sqrt(1 - zeta^2): the definition of the ratio; the rigid-body motion is not damped."""
    free, damped = machine().modes(damped=False), machine().with_modal_damping(ratios).modes()
    w, zeta = free.natural_frequencies, np.pad(ratios, (0, 2 - len(ratios)))
    assert damped.natural_frequencies == pytest.approx(w, rel=1e-9)
    assert damped.damping_ratios == pytest.approx(zeta, abs=1e-9)
    assert [mode.multiplicity for mode in damped if mode.eigenvalue == 0] == [2]


def test_modes_of_one_frequency_have_their_own_ratios():
    system = mb.MechanicalSystem(np.diag([1.0, 2.0, 3.0]), stiffness=4 * np.diag([1.0, 2.0, 3.0]))
    assert np.sort(system.with_modal_damping([0.1, 0.2, 0.3]).modes().damping_ratios) == pytest.approx([0.1, 0.2, 0.3])


@given(st.floats(0.001, 0.5), st.floats(0.001, 0.05))
def test_rayleigh_damping_has_the_ratios_of_the_textbook(a, b):
    """zeta = a / (2 w) + b w / 2 (Inman, Engineering Vibration, 4.1), constraint and massless joint included."""
    w = machine().modes(damped=False).natural_frequencies
    damped = machine().with_rayleigh_damping(a, b).modes()
    assert damped.damping_ratios == pytest.approx(a / (2 * w) + b * w / 2, abs=1e-9)


def test_damping_adds_to_that_of_the_dampers_and_leaves_the_system_as_it_was():
    system = mb.MechanicalSystem(np.eye(2), [[1.0, 0], [0, 0]], np.diag([4.0, 9.0]))
    damped = system.with_modal_damping(0.1)
    assert damped.damping == pytest.approx(np.diag([1.4, 0.6])) and np.array_equal(system.damping, [[1, 0], [0, 0]])
    assert damped.solve([1.0, 0.0])(1.0)[0] != system.solve([1.0, 0.0])(1.0)[0]


def test_the_motion_relative_to_a_moving_support_is_damped():
    """m x'' + c (x' - s') + k (x - s) = 0 with c = 2 zeta w m, of a mass on a support that is prescribed."""
    support = mb.Constraint([0, 1], value=0.0)
    system = mb.MechanicalSystem(np.diag([2.0, 0.0]), stiffness=8 * np.array([[1, -1], [-1, 1]]), constraints=[support])
    assert system.with_modal_damping(0.1).damping == pytest.approx(0.8 * np.array([[1, -1], [-1, 1]]))


def test_elements_keep_their_digits():
    """A spring of 1 N/m next to one of 1e16 N/m: the damper b k of each is in C."""
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.mass("b", 1.0)
    model.spring("ground", "a", 1.0)
    model.spring("a", "b", 1e16)
    modes = model.assemble().with_rayleigh_damping(stiffness=0.01).modes()
    w = np.sqrt(0.5)
    assert modes.natural_frequencies[0] == pytest.approx(w, rel=1e-12)
    assert modes.damping_ratios[0] == pytest.approx(0.005 * w, rel=1e-9)


def test_sparse_matrices_have_rayleigh_damping():
    import scipy.sparse

    K = scipy.sparse.diags_array([-np.ones(19), 2 * np.ones(20), -np.ones(19)], offsets=[-1, 0, 1])
    system = mb.MechanicalSystem(scipy.sparse.eye_array(20), stiffness=K).with_rayleigh_damping(0.02, 0.01)
    assert system.damping.toarray() == pytest.approx(0.02 * np.eye(20) + 0.01 * K.toarray())
    with pytest.raises(mb.InputError, match="modal damping: not available for sparse matrices"):
        system.with_modal_damping(0.1)


@pytest.mark.parametrize(
    ("stiffness", "ratios", "message"),
    [
        ([[4.0, 1.0], [0.0, 9.0]], 0.1, "the stiffness matrix is not symmetric"),
        (np.diag([4.0, 9.0]), [0.1] * 3, "found 3; there are 2 oscillating modes"),
        (np.diag([4.0, 9.0]), -0.1, "found -0.1; expected 0 or a positive number"),
    ],
)
def test_what_is_no_modal_damping_is_refused(stiffness, ratios, message):
    with pytest.raises(mb.InputError, match=message):
        mb.MechanicalSystem(np.eye(2), stiffness=stiffness).with_modal_damping(ratios)


def building(relative, supports=("base",)):
    """Two storeys on supports that move by records; a M acts on absolute or on relative velocities."""
    model = mb.LumpedModel()
    for name in supports:
        model.node(name)
    model.mass("first", 2.0)
    model.mass("second", 1.0)
    model.spring("first", "second", 300.0)
    times = np.linspace(0.0, 2.0, 21)
    for k, name in enumerate(supports):
        model.spring(name, "first", 200.0 + 100.0 * k)
        model.prescribe(name, mb.sampled(times, [(k + 1) * np.sin(3 * times) * times]))
    return model.assemble().with_rayleigh_damping(0.7, 0.01, relative)


@pytest.mark.parametrize("supports", [("base",), ("left", "right")])
def test_relative_damping_acts_on_the_motion_relative_to_the_static_response(supports):
    """M y'' + (a M + b K) y' + K y = -M R u'', x = y + R u: solved by SciPy in the relative coordinates y; R = -K_ff^-1 K_fs."""
    from scipy.integrate import solve_ivp

    system = building(True, supports)
    s = len(supports)
    K, M = system.stiffness, system.mass[s:, s:]
    R = -np.linalg.solve(K[s:, s:], K[s:, :s])
    C = 0.7 * M + 0.01 * K[s:, s:]
    knots = np.linspace(0.0, 2.0, 21)
    records = np.array([(k + 1) * np.sin(3 * knots) * knots for k in range(s)])
    slopes = np.diff(records) / np.diff(knots)
    y, v, last = np.zeros(2), np.zeros(2), np.zeros(s)
    for k in range(20):  # u'' is an impulse at each kink: y' jumps by -R times the jump of u'
        v, last = v - R @ (slopes[:, k] - last), slopes[:, k]
        done = solve_ivp(
            lambda _, z: [*z[2:], *np.linalg.solve(M, -C @ z[2:] - K[s:, s:] @ z[:2])],
            knots[k : k + 2],
            [*y, *v],
            "DOP853",
            rtol=1e-12,
            atol=1e-14,
        )
        y, v = done.y[:2, -1], done.y[2:, -1]
    motion = system.solve()
    assert np.allclose(motion(2.0 - 1e-12)[s:], y + R @ records[:, -1], rtol=1e-9, atol=1e-10)


def test_which_velocity_is_damped_is_reported():
    texts = [str(notice) for relative in (False, True) for notice in building(relative).solve().notices if notice.kind == "damping"]
    assert "absolute velocities" in texts[0] and "relative to the static response" in texts[1] and len(texts) == 2


def test_relative_damping_is_the_same_where_nothing_moves():
    """A fixed base: (I - R A)^T M (I - R A) is M on all motions with A x = 0."""
    system = mb.MechanicalSystem(np.diag([2.0, 1.0, 0.0]), None, [[5, -2, -3], [-2, 2, 0], [-3, 0, 3]], [mb.Constraint([0, 0, 1])])
    modes = [system.with_rayleigh_damping(0.2, 0.01, relative).modes() for relative in (False, True)]
    assert np.allclose(modes[0].eigenvalues, modes[1].eigenvalues, rtol=1e-12)
