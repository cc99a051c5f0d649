"""Energy: its parts by hand, and what keeps it."""

import numpy as np
import pytest

from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import massless_joints, two_masses

TIMES = np.linspace(0, 40, 81)


def test_the_parts_by_hand():
    system = MechanicalSystem([[2.0]], stiffness=[[3.0]], static_force=[5.0])
    energy = system.solve([4.0], [1.0]).energy(0.0)
    assert (energy.kinetic, energy.strain, energy.static, energy.total) == pytest.approx((1.0, 24.0, -20.0, 5.0))


def test_a_spring_with_a_rest_length_stores_what_its_elongation_says():
    # 1/2 k (x - l)^2 = strain + static + 1/2 k l^2
    k, length = 3.0, 0.4
    motion = MechanicalSystem([[2.0]], stiffness=[[k]], static_force=[k * length]).solve([1.0])
    energy = motion.energy(TIMES)
    assert np.allclose(energy.strain + energy.static + k * length**2 / 2, k * (motion(TIMES)[0] - length) ** 2 / 2)


@pytest.mark.parametrize("level, value", [("acceleration", 0.0), ("velocity", 0.0), ("position", -0.4)])
def test_it_is_kept_without_dampers(level, value):
    total = two_masses(level, value=value).solve([0.8, 1.2, 2.0]).energy(TIMES).total
    assert np.allclose(total, 4.64, rtol=1e-12)  # 1/2 k (0.8^2 + 2^2)


def test_it_is_kept_with_constant_forces_and_ties():
    system = MechanicalSystem(
        np.diag([1.0, 2.0, 0.5]),
        stiffness=[[2, -1, 0], [-1, 4, -3], [0, -3, 3]],
        constraints=Constraint([2, 0, -1]),
        static_force=[-9.81, 1.0, 0.3],
    )
    total = system.solve([0.1, 0.5, 0.2], [1, 0, 2]).energy(TIMES).total
    assert np.allclose(total, total[0], rtol=0, atol=1e-11 * np.abs(total).max())


def test_dampers_take_it_at_the_rate_of_their_power():
    motion = massless_joints().solve([2 / 3, 1, 2])
    total = motion.energy(TIMES).total
    assert (np.diff(total) < 0).all()
    times = np.linspace(0, 2, 4001)
    velocity = motion.velocity(times)
    power = np.einsum("it,ij,jt->t", velocity, motion.system.damping, velocity)
    lost = np.trapezoid(power, times)
    assert np.isclose(motion.energy(0.0).total - motion.energy(2.0).total, lost, rtol=1e-6)


def test_gyroscopic_forces_do_no_work():
    spin = MechanicalSystem(np.eye(2), [[0, 3], [-3, 0]], np.diag([1.0, 2.0]))
    total = spin.solve([1, 0], [0, 1]).energy(TIMES).total
    assert np.allclose(total, total[0], rtol=1e-12)
