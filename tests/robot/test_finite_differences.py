"""K of random robots, on the motions that the loops allow, against central differences of all forces (reference.py)."""

from functools import cache

import numpy as np
import pytest

from tests.robot.linkages import allowed, null_space
from tests.robot.random_robots import random_case

CASES = {
    "chain": {},
    "planar chain": {"planar": True},
    "chain on springs": {"springs": 4, "fixed": False},
    "planar loop": {"kinds": ["point"], "planar": True, "joints": 4},
    "two planar loops": {"kinds": ["point", "point"], "planar": True, "joints": 7},
    "planar hinge": {"kinds": ["hinge"], "planar": True, "joints": 4},
    "point": {"kinds": ["point"]},
    "two points": {"kinds": ["point", "point"], "joints": 8},
    "hinge": {"kinds": ["hinge"], "joints": 8},
    "rigid": {"kinds": ["rigid"], "joints": 9},
    "rod": {"kinds": ["rod"]},
    "two rods, not fixed": {"kinds": ["rod", "rod"], "joints": 4, "fixed": False},
    "cylindrical": {"kinds": ["cylindrical"], "joints": 7},
    "prismatic, not fixed": {"kinds": ["prismatic"], "joints": 8, "fixed": False},
    "universal": {"kinds": ["universal"], "joints": 7},
    "universal, not fixed": {"kinds": ["universal"], "joints": 7, "fixed": False},
    "rigid and point": {"kinds": ["rigid", "point"], "joints": 12},
    "point, not fixed": {"kinds": ["point"], "fixed": False},
    "hinge, not fixed": {"kinds": ["hinge"], "joints": 8, "fixed": False},
    "rigid, not fixed": {"kinds": ["rigid"], "joints": 9, "fixed": False},
    "rigid on springs": {"kinds": ["rigid"], "joints": 9, "fixed": False, "springs": 5},
    "free base on springs": {"base": "free", "springs": 8, "joints": 3, "fixed": False},
    "free base on a foot": {"base": "free", "kinds": ["rigid"], "joints": 4, "fixed": False},
    "free base on two feet": {"base": "free", "kinds": ["rigid", "rigid"], "joints": 9},
    "free base on points and springs": {"base": "free", "kinds": ["point"], "springs": 6, "joints": 4, "fixed": False},
}
SEEDS = range(3)


@cache
def solved(name: str, seed: int):
    """(case, posture, system, q of the referee)."""
    case = random_case(seed, **CASES[name])
    posture = case.robot.equilibrium(case.guess, hold=case.hold)
    base = posture.configuration[:7] if case.reference.base == "free" else None
    q = case.reference.configuration(posture.joints, base)
    return case, posture, case.robot.linearize(posture), q


def order(case) -> list[int]:
    """Where the robot's coordinates stand among those of the referee."""
    return [case.reference.coordinates.index(name) for name in case.robot.coordinates]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", CASES)
def test_equilibrium_is_one(name, seed):
    # all forces, reactions and torques of the motors add up to nothing; what is not fixed is not touched by motors
    case, posture, _, q = solved(name, seed)
    f = case.reference.applied(q)
    if len(case.reference.loops):
        assert np.abs(case.reference.gaps(q)).max() < 1e-10
        f = f + case.reference.rows(q).T @ case.reference.multipliers(q, posture.ground_reactions)
    for joint, torque in posture.torques.items():
        f[case.reference.coordinates.index(joint)] += torque
    assert np.abs(f).max() < 1e-8
    assert set(posture.torques) == (set(case.reference.angles(q)) if case.hold == "all" else set())


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", CASES)
def test_stiffness_is_the_derivative_of_all_forces(name, seed):
    case, posture, system, q = solved(name, seed)
    places = order(case)
    J = case.reference.rows(q)[:, places]
    N = null_space(J) if len(J) else np.eye(len(places))
    same = allowed(system)
    assert same.shape == N.shape and np.abs(same - N @ (N.T @ same)).max(initial=0) < 1e-9
    assert N.shape[1], "this case does not move: choose more joints"
    if case.hold == "all":  # motors and loops share the load: the share is the robot's choice
        multipliers = case.reference.multipliers(q, posture.ground_reactions)
    else:
        multipliers = np.linalg.lstsq(case.reference.rows(q).T, -case.reference.applied(q), rcond=1e-9)[0]
    expected = N.T @ case.reference.stiffness(q, multipliers)[np.ix_(places, places)] @ N
    actual = N.T @ system.stiffness @ N
    assert np.abs(actual - expected).max() <= 1e-9 * np.abs(expected).max()
    assert np.abs(actual - actual.T).max() <= 1e-10 * np.abs(actual).max()


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("name", CASES)
def test_mass_and_damping(name, seed):
    case, _, system, q = solved(name, seed)
    places = np.ix_(order(case), order(case))
    M, D = case.reference.mass(q)[places], case.reference.damping(q)[places]
    assert np.abs(system.mass - M).max() <= 1e-12 * np.abs(M).max()
    assert np.abs(system.damping - D).max() <= 1e-11 * np.abs(D).max()
    assert np.abs(system.damping - system.damping.T).max() <= 1e-14 * np.abs(D).max()
