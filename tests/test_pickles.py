"""Answers and models go through pickle, as to other processes: the copy has the same bits."""

import pickle

import numpy as np
import pytest

import mbconstrained as mb


def system():
    model = mb.LumpedModel()
    model.mass("a", 1.0)
    model.mass("b", 2.0)
    model.rigid_bar("bar", 3.0, inertia=1.0, points={"left": -1.0, "right": 1.0})
    for ends in (("ground", "a"), ("a", "b"), ("b", "left"), ("right", "ground")):
        model.spring(*ends, stiffness=40.0)
    model.damper("a", "b", 0.3)
    return model.assemble()


def chain(count):
    K = 40.0 * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    return mb.MechanicalSystem(np.eye(count), 0.01 * K, K)


def rotor():
    G = np.array([[0.0, 1.0], [-1.0, 0.0]])
    return mb.MechanicalSystem(np.eye(2), 0.1 * np.eye(2), 4 * np.eye(2), gyroscopic=G)


MAKERS = {
    "many states": lambda: chain(40).solve([0.1] * 40),
    "rotor": lambda: rotor().at_speed(1.5).solve([0.1] * 2),
    "plain": lambda: system().solve([0.1] * 6),
    "record": lambda: system().solve(force=mb.sampled([0.0, 1.0, 2.0], np.outer(np.eye(6)[0], [0.0, 1.0, 0.0]))),
    "proportional damping": lambda: system().with_rayleigh_damping(0.1, 0.01).solve([0.1] * 6),
    "modal damping": lambda: system().with_modal_damping(0.05).solve([0.1] * 6),
    "relative damping": lambda: system().with_rayleigh_damping(0.1, 0.01, relative=True).solve([0.1] * 6),
    "equations": lambda: mb.solve(
        mb.PolynomialMatrix([np.diag([1.0, 1.0]), np.eye(2), np.diag([1.0, 0.0])]), [[1.0, 2.0], [0.0, 0.0]]
    ),
}


@pytest.mark.parametrize("used", [False, True])
@pytest.mark.parametrize("name", MAKERS)
def test_motions(name, used):
    motion, times = MAKERS[name](), np.array([0.0, 0.3, 1.0, 7.0])
    if used:
        motion(times), motion.notices, motion.error_estimate(times)
    copy = pickle.loads(pickle.dumps(motion))
    assert np.array_equal(copy(times), motion(times))
    assert [str(notice) for notice in copy.notices] == [str(notice) for notice in motion.notices]


def test_equations_of_a_rotor():
    turning = rotor().at_speed(1.5)
    copy = pickle.loads(pickle.dumps(turning))
    assert np.array_equal(copy.damping, turning.damping)
    assert [one.name for one in copy.parameters()] == [one.name for one in turning.parameters()]


def test_other_answers():
    s = system()
    H, modes = s.frequency_response([0.5, 1.0]), s.modes()
    R = s.random_response({"a": mb.white_noise(1.0)})
    copies = [pickle.loads(pickle.dumps(one)) for one in (s, H, modes, R)]
    assert np.array_equal(copies[0].stiffness, s.stiffness) and np.array_equal(copies[1].values, H.values)
    assert np.array_equal(copies[2].eigenvalues, modes.eigenvalues) and np.array_equal(copies[3].rms, R.rms)
