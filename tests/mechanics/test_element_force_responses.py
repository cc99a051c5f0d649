"""Frequency responses of the forces of springs and dampers, against (K - w^2 M + i w C) x = f solved by NumPy."""

import numpy as np
import pytest

import mbconstrained as mb


def driveline(loss=None, modal=None):
    model = mb.LumpedModel()
    for name, inertia in (("engine", 2.5), ("flywheel", 6.0), ("pinion", 0.4)):
        model.inertia(name, inertia)
    model.torsion_spring("engine", "flywheel", stiffness=2e6, name="crank")
    model.torsion_spring("flywheel", "pinion", stiffness=12e3, name="coupling")
    model.torsion_damper("flywheel", "pinion", damping=60.0, name="rubber")
    model.torsion_damper("ground", "pinion", damping=40.0, name="load")
    return model.assemble()


@pytest.mark.parametrize("loss", [None, 0.07, {"coupling": 0.2}])
@pytest.mark.parametrize("hertz", [0.5, 11.0, 62.5, 400.0])
def test_forces_follow_from_the_motion(loss, hertz):
    system = driveline()
    H = system.frequency_response([hertz], ["engine"], quantity="force", loss_factor=loss)
    w, M, C, K = 2 * np.pi * hertz, system.mass, system.damping, system.stiffness.astype(complex)
    etas = dict.fromkeys(system.elements, loss if isinstance(loss, float) else 0.0) | (loss if isinstance(loss, dict) else {})
    for name, one in system.elements.items():
        K = K + 1j * etas[name] * one.stiffness * np.outer(one.elongation, one.elongation)
    x = np.linalg.solve(K - w**2 * M + 1j * w * C, np.eye(3)[0])
    right = [
        (one.stiffness * (1 + 1j * etas[name]) + 1j * w * one.damping) * (one.elongation @ x)
        for name, one in system.elements.items()
    ]
    values, errors = H.values[:, 0, 0], H.error_estimate[:, 0, 0]
    assert H.outputs == tuple(system.elements)
    # NumPy's own x is right to its condition times eps; a stiff crank's elongation is a small difference of two angles
    noise = np.finfo(float).eps * np.linalg.cond(K - w**2 * M + 1j * w * C)
    size = np.array([abs(one.stiffness + 1j * w * one.damping) * np.abs(x).max() for one in system.elements.values()])
    assert (np.abs(values - right) <= 2 * errors * np.abs(values) + noise * size).all()
    assert (
        errors <= 1e4 * np.finfo(float).eps * 2e6 / 12e3
    ).all()  # elongations of a stiff crank cancel: the ratio of the stiffnesses


def test_mixed_outputs_and_units():
    """A force stands next to receptances, and under a prescribed motion it is a force by a displacement."""
    model = mb.LumpedModel()
    model.mass("machine", 2.0)
    model.node("floor")
    model.spring("floor", "machine", stiffness=50.0, name="mount")
    model.prescribe("floor", mb.harmonic([0.0], angular_frequency=1.0), name="base")
    system = model.assemble()
    H = system.frequency_response([0.25], ["machine", "base"], ["machine", "mount"])
    assert H.units.tolist() == [["m/N", "1"], ["1", "N/m"]]
    w = np.pi / 2
    assert np.allclose(H.values[1, :, 0], [50 / (50 - 2 * w**2), 50 * 2 * w**2 / (50 - 2 * w**2)], rtol=1e-13, atol=0)
    peak = system.frequency_response("auto", ["machine"], ["mount"]).peaks[0]
    assert np.isclose(peak.frequency_hz, 5 / (2 * np.pi))


def test_forces_need_springs_or_dampers():
    system = driveline()
    with pytest.raises(mb.InputError, match="expected springs, dampers"):
        system.frequency_response([1.0], ["engine"], ["engine"], quantity="force")
    with pytest.raises(mb.InputError, match='did you mean "force of coupling"'):
        system.frequency_response([1.0], ["engine"], ["force of couplin"])
    with pytest.raises(mb.InputError, match="springs and dampers with names"):
        mb.MechanicalSystem([[1.0]], None, [[1.0]]).frequency_response([1.0], quantity="force")
