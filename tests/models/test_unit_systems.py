"""One model in SI, in mm-N-tonne, in the units of MEMS and in giga units: one motion."""

import numpy as np
import pytest

import mbconstrained as mb

#: Length in m, force in N, time in s of each system of units.
SYSTEMS = {
    "mm-N-tonne": (1e-3, 1.0, 1.0),  # a mass of 1 N s^2/mm is a tonne
    "MEMS: um-uN-us": (1e-6, 1e-6, 1e-6),
    "giga: km-GN-ks": (1e3, 1e9, 1e3),
    "geology: km-GN-Ms": (1e3, 1e9, 1e6),
}
TIMES = np.array([0.0, 0.1, 1.0, 7.0, 60.0])


def machine(length: float, force: float, time: float) -> mb.Motion:
    """A press: stiff frame, soft mount, massless joint between damper and spring, lever, a force that resonates."""
    mass, stiffness, damping = length / force / time**2, length / force, length / force / time
    model = mb.LumpedModel()
    model.mass("frame", 2000.0 * mass)
    model.mass("ram", 150.0 * mass)
    model.node("joint")
    model.mass("rocker", 3.0 * mass)
    model.spring("ground", "frame", stiffness=4e4 * stiffness, rest_length=0.3 / length)
    model.damper("ground", "frame", damping=900.0 * damping)
    model.spring("frame", "ram", stiffness=6e7 * stiffness)
    model.damper("ram", "joint", damping=50.0 * damping)
    model.spring("joint", "frame", stiffness=2e3 * stiffness)
    model.lever("ram", "rocker", 1.0, 3.0)
    model.force("ram", mb.harmonic([20.0 / force], angular_frequency=4.0 * time))
    return model.assemble().solve({"frame": 0.31 / length, "joint": 0.305 / length}, {"rocker": 0.02 / length * time})


SI = machine(1.0, 1.0, 1.0)


@pytest.mark.parametrize("units", SYSTEMS.values(), ids=SYSTEMS)
def test_the_motion_does_not_depend_on_units(units):
    """The difference is no larger than the two errors together, each no more than ten times its estimate."""
    length, force, time = units
    other = machine(*units)
    for mine, others, factor, of in [
        (SI(TIMES), other(TIMES / time), length, "displacement"),
        (SI.velocity(TIMES), other.velocity(TIMES / time), length / time, "velocity"),
        (SI.acceleration(TIMES), other.acceleration(TIMES / time), length / time**2, "acceleration"),
        (SI.reaction(TIMES), other.reaction(TIMES / time), force, "reaction"),
    ]:
        bound = 10 * (SI.error_estimate(TIMES, of) + other.error_estimate(TIMES / time, of))
        assert np.abs(factor * others - mine).max() <= bound * np.abs(mine).max()


@pytest.mark.parametrize("units", SYSTEMS.values(), ids=SYSTEMS)
def test_what_happens_at_the_start_does_not_depend_on_units(units):
    length, force, time = units
    other = machine(*units)
    assert (other.jump != 0).tolist() == (SI.jump != 0).tolist()
    assert np.allclose(other.jump * length, SI.jump * [[1], [time]], rtol=1e-9, atol=0)
    assert [notice.kind for notice in other.notices] == [notice.kind for notice in SI.notices]
    assert len(other.constraint_impulses) == len(SI.constraint_impulses)
    for mine, others in zip(SI.constraint_impulses, other.constraint_impulses):
        assert np.allclose(others * force * time, mine, rtol=1e-9, atol=0)
