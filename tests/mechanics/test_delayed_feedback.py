"""Delayed feedback in lumped models and systems: equations at all times, exact intervals, closed forms of chatter, and refusals."""

import mpmath
import numpy as np
import pytest

import mbconstrained as mb


@pytest.fixture
def machine():
    model = mb.LumpedModel()
    _ = model.mass("base", 2.0), model.mass("tool", 1.0), model.node("tip")
    _ = model.spring("ground", "base", 300.0), model.spring("base", "tool", 100.0)
    _ = model.damper("base", "tool", 2.0), model.damper("ground", "base", 1.0)
    model.rigid_tie("tool", "tip", distance=0.0)
    model.delayed_feedback("ground", "tip", "0.1 s", displacement_gain=5.0, velocity_gain="3 N*s/m", measured_end="base")
    return model.assemble()


def test_matrices_of_the_element(machine):
    (term,) = machine.delayed
    assert term.delay == 0.1 and term.coefficients[0].tolist() == [[0, 0, 0], [0, 0, 0], [5, 0, 0]]
    assert term.coefficients[1].tolist() == [[0, 0, 0], [0, 0, 0], [3, 0, 0]]
    shaft = mb.LumpedModel()
    _ = shaft.inertia("a", 1.0), shaft.inertia("b", 1.0)
    shaft.delayed_torsion_feedback("a", "b", 0.2, displacement_gain=2.0)
    assert shaft.assemble().delayed[0].coefficients[0].tolist() == [[2, -2], [-2, 2]]


def test_motion_and_reactions_satisfy_the_equations_at_all_times(machine):
    motion = machine.solve(
        {"tool": 0.1, "tip": 0.1}, force={"tip": mb.pulse([4.0], start=0.05, duration=0.2) + mb.impulse([0.3]).delayed(0.42)}
    )
    times = np.linspace(0.0007, 5, 693)
    x, v, a, reaction = motion(times), motion.velocity(times), motion.acceleration(times), motion.reaction(times)
    late = np.maximum(times - 0.1, 0.0)
    force = np.zeros((3, len(times)))
    force[2] = 4.0 * ((times >= 0.05) & (times < 0.25)) - (times >= 0.1) * (5 * motion(late)[0] + 3 * motion.velocity(late)[0])
    left = machine.mass @ a + machine.damping @ v + machine.stiffness @ x
    np.testing.assert_allclose(left, force + machine.constraint_matrix.T @ reaction, atol=1e-12)
    assert motion.later_constraint_impulses[0].impulses[0] == pytest.approx([-0.3])
    at = [0.3, 0.45, 0.6]
    assert motion.enclose(at, 18).error_bounds(motion(at)).max() < 1e-15
    assert motion.enclose(at, 18, of="reaction").error_bounds(motion.reaction(at)).max() < 1e-13
    fine = np.linspace(0, 2, 20001)
    assert motion.peaks(2.0).maximum == pytest.approx(motion(fine).max(axis=1), abs=1e-8)


def test_the_history_of_a_system_enters(machine):
    motion = machine.solve(history=[1.0, 0.0, 0.0])
    assert motion.enclose(0.05, 18).error_bounds(motion(0.05)).max() < 1e-15
    assert motion.acceleration(0.05)[1] == pytest.approx(
        (-5.0 - 100 * (motion(0.05)[1] - motion(0.05)[0]) - 2 * (motion.velocity(0.05)[1] - motion.velocity(0.05)[0])), rel=1e-12
    )


def test_steady_state_is_the_frequency_response_and_what_the_motion_tends_to(machine):
    load = mb.harmonic([0.0, 0.0, 1.0], frequency_hz=1.0)
    steady = machine.steady_state(load)
    H = machine.frequency_response([1.0], ["tip"])
    np.testing.assert_allclose(steady.displacement_amplitudes[:, 0], H.values[:, 0, 0], rtol=1e-12)
    assert machine.characteristic_roots(1).stability_margin > 0.6
    times = np.linspace(50, 51, 20)
    np.testing.assert_allclose(machine.solve(force=load)(times), steady.displacement(times), atol=1e-12)


@pytest.mark.parametrize("turns", [1, 2, 3])
@pytest.mark.parametrize("chatter_hz", [255.0, 280.0])
def test_the_limit_of_chatter_is_that_of_tobias_and_fishwick(turns, chatter_hz):
    m, k = 2.0, 2 * (2 * np.pi * 250) ** 2
    c, w = 0.06 * np.sqrt(k * m), 2 * np.pi * chatter_hz
    G = 1 / (k - m * w * w + 1j * w * c)
    cutting = -1 / (2 * G.real)
    delay = (-np.angle(1 + 1 / (cutting * G)) % (2 * np.pi) + 2 * np.pi * turns) / w
    roots = mb.MechanicalSystem([[m]], [[c]], [[k + cutting]], delayed={delay: [[-cutting]]}).characteristic_roots(8)
    assert roots.is_complete
    assert abs(roots.eigenvalues - 1j * w).min() < 1e-9 * w


def test_modes_are_the_rightmost_roots(machine):
    modes, roots = machine.modes(4), machine.characteristic_roots(4)
    assert sorted(modes.eigenvalues, key=abs) == pytest.approx(sorted(roots.eigenvalues, key=abs))
    assert any("infinitely many" in notice.text for notice in modes.notices)


QUESTIONS = {
    "sensitivities": lambda s: s.sensitivities(),
    "state space": lambda s: s.to_state_space(),
    "discretize": lambda s: s.discretize(0.1),
    "polynomial matrix": lambda s: s.polynomial_matrix(),
    "constrained form": lambda s: s.constrained_form(),
    "root locus": lambda s: s.root_locus("base", [1.0, 2.0]),
    "acceleration": lambda s: s.acceleration([0, 0, 0], [0, 0, 0]),
    "campbell": lambda s: s.campbell([1.0, 2.0]),
    "critical speeds": lambda s: s.critical_speeds(),
    "unbalance": lambda s: s.unbalance_response([1.0, 2.0]),
    "speed": lambda s: s.at_speed(1.0),
    "modal damping": lambda s: s.with_modal_damping(0.01),
    "modal damping of a response": lambda s: s.frequency_response([1.0], modal_damping=0.1),
    "undamped modes": lambda s: s.modes(damped=False),
    "effective masses": lambda s: s.effective_masses(),
    "modal combination": lambda s: s.modal_combination(lambda f: 1.0),
    "matrices": lambda s: s.to_dict(),
    "several motions": lambda s: s.solve(np.zeros((3, 3))),
    "boundary values": lambda s: mb.boundary_solve(s, start={"base": 0.0}, end={"base": 1.0}, duration=1.0),
    "least energy": lambda s: mb.least_energy_input(s, ["tip"], end={"base": 1.0}, duration=1.0),
}


@pytest.mark.parametrize("question", QUESTIONS)
def test_what_rests_on_finitely_many_modes_is_refused_by_name(machine, question):
    with pytest.raises(mb.InputError, match=r"not available with delays \(0.1 s\)"):
        QUESTIONS[question](machine)


@pytest.mark.parametrize(
    "values, text",
    [
        ({"delay": 0.0, "velocity_gain": 1.0}, "delay"),
        ({"delay": "1 m", "velocity_gain": 1.0}, "delay"),
        ({"delay": 0.1}, "found no gain"),
        ({"delay": 0.1, "velocity_gain": np.nan}, "velocity gain"),
        ({"delay": 0.1, "velocity_gain": 1.0, "measured_end": "carts"}, "carts"),
        ({"delay": 0.1, "velocity_gain": 1.0, "measured_start": "cart"}, "relative to itself"),
    ],
)
def test_wrong_elements_are_refused_in_words(values, text):
    model = mb.LumpedModel()
    model.mass("cart", 1.0)
    with pytest.raises(mb.InputError, match=text):
        model.delayed_feedback("ground", "cart", **values)


def test_large_sparse_models_and_neutral_feedback_are_refused():
    model = mb.LumpedModel()
    _ = model.mass("cart", 1.0), model.node("tip"), model.spring("cart", "tip", 10.0)
    model.delayed_feedback("cart", "tip", 0.1, displacement_gain=1.0)
    with pytest.raises(mb.InputError, match="neutral"):
        model.assemble().solve()
    with pytest.raises(mb.InputError, match="delayed"):
        model.assemble(sparse=True)


@pytest.mark.parametrize("analysis", ["shock", "sensitivity", "locus", "formula", "campbell", "accuracy"])
def test_other_analyses_of_a_scene_refuse_delays(analysis):
    scene = mb.read_scene("examples/chatter.toml")
    with pytest.raises(mb.InputError, match="delays"):
        getattr(scene, analysis)()


def late_damper(gain: float, delay: float) -> mb.MechanicalSystem:
    """x'' + 0.1 x' + 4 x + gain x'(t - delay) = f."""
    return mb.MechanicalSystem([[1.0]], [[0.1]], [[4.0]], delayed={delay: [[[0.0]], [[gain]]]})


def test_the_random_response_is_the_integral_over_the_frequency_response():
    G = mb.psd([0.05, 1.0, 20.0], [1.0, 1.0, 0.01], of="force", unit="N^2/Hz")
    R = late_damper(0.6, 0.2).random_response({"x1": G})
    exponent = mpmath.log(0.01) / mpmath.log(20)

    def density(f):
        s = 2j * mpmath.pi * f
        return (1 if f <= 1 else f**exponent) / abs(s**2 + 0.1 * s + 4 + 0.6 * s * mpmath.exp(-0.2 * s)) ** 2

    places = [0.05, 0.2, 0.3, 0.4, 0.6, 1, 2, 5, 20]
    for order in (0, 2):
        exact = float(mpmath.quad(lambda f, k=order: f**k * density(f), places))
        assert R.moment(order)[0] == pytest.approx(exact, rel=1e-12)
    assert R.error_estimate[0] < 1e-12
    assert np.square(R.rms_in_bands([0.0, 0.3, 1.0, 20.0])).sum() == pytest.approx(R.covariance[0, 0], rel=1e-12)


def test_random_responses_with_delays_that_do_not_exist_or_are_not_known_are_reported():
    G = mb.psd([0.05, 20.0], [1.0, 1.0], of="force", unit="N^2/Hz")
    unstable = late_damper(3.0, 0.6).random_response({"x1": G})
    assert "unstable and grows" in unstable.infinite["x1"] and np.isinf(unstable.rms[0])
    stable = late_damper(0.6, 0.2)
    with pytest.raises(mb.InputError, match="need a highest frequency"):
        stable.random_response({"x1": mb.white_noise(1.0)}).rms
    with pytest.raises(mb.InputError, match="loss factors"):
        stable.random_response({"x1": G}, loss_factor=0.1).rms
    with pytest.raises(mb.InputError, match="with delays"):
        stable.random_response({"x1": G}).enclose()


def test_sweeps_and_optima_of_a_scene_refuse_delays():
    scene = mb.read_scene("examples/chatter.toml")
    with pytest.raises(mb.InputError, match="delays"):
        scene.sweep({"width": mb.linspace("0.1 mm", "0.4 mm", 3)})
