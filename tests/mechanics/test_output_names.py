"""Quantities by name in every analysis, against (K - w^2 M + i w C) x = f solved by NumPy and forces written out by hand."""

import numpy as np
import pytest

import mbconstrained as mb
from tests.scene.scenes import EXAMPLES, scene_of

HERTZ = np.array([0.0, 0.3, 1.7, 2.4, 9.0])


def machine(**further):
    """A machine on springs, on a frame on the ground."""
    model = mb.LumpedModel()
    model.mass("frame", 3.0)
    model.mass("machine", 2.0)
    model.spring("ground", "frame", stiffness=900.0, name="feet", **further)
    model.damper("ground", "frame", damping=7.0, name="rubber")
    model.spring("frame", "machine", stiffness=300.0, name="mount")
    model.damper("frame", "machine", damping=2.0, name="absorber")
    return model.assemble()


def motion_of(system, load, stiffness=None):
    """Complex amplitudes under a unit load at each frequency, shape (n, F)."""
    K = system.stiffness if stiffness is None else stiffness
    each = (2 * np.pi * HERTZ)[:, None, None]
    return np.linalg.solve(K - each**2 * system.mass + 1j * each * system.damping, np.array(load, dtype=float)).T


def test_one_response_has_quantities_of_all_kinds():
    system, s = machine(), 2j * np.pi * HERTZ
    frame, top = motion_of(system, [0.0, 1.0])
    wanted = {
        "machine": top,
        "velocity of machine": s * top,
        "acceleration of frame": s**2 * frame,
        "machine - frame": top - frame,
        "machine relative to frame": top - frame,
        "velocity of machine - frame": s * (top - frame),
        "acceleration of frame - ground": s**2 * frame,
        "mount": 300 * (top - frame),
        "force of absorber": 2 * s * (top - frame),
        "elongation of mount": top - frame,
        "rate of mount": s * (top - frame),
        "force on ground": (900 + 7 * s) * frame,
    }
    H = system.frequency_response(HERTZ, ["machine"], list(wanted))
    for place, (name, right) in enumerate(wanted.items()):
        np.testing.assert_allclose(H.values[place, 0], right, rtol=1e-11, atol=1e-16, err_msg=name)
    units = ["m/N", "m/s/N", "m/s^2/N", "m/N", "m/N", "m/s/N", "m/s^2/N", "1", "1", "m/N", "m/s/N", "1"]
    assert H.units[:, 0].tolist() == units
    assert H.harmonic.output_quantities[:4] == ("receptance", "velocity", "acceleration", "relative displacement")


@pytest.mark.parametrize(
    ("name", "kind"),
    [("machine", "displacement"), ("velocity of machine", "velocity"), ("force of mount", "force"), ("machine - frame", "")],
)
def test_alone_and_among_others_a_quantity_has_the_same_values(name, kind):
    """Plain motions of one order are no further unknowns; next to others they are."""
    system = machine()
    alone = system.frequency_response(HERTZ, ["machine"], [name])
    among = system.frequency_response(HERTZ, ["machine"], ["force on ground", "acceleration of frame", name])
    np.testing.assert_allclose(alone.values[0], among.values[2], rtol=1e-12, atol=0)
    assert not kind or among.harmonic.output_quantities[2] in (kind, "receptance")


def test_force_transmissibility_with_structural_and_modal_damping():
    """What the ground feels by the force on a mass: 1 at 0 Hz; with structural damping k (1 + i eta) of the feet; with modal damping of
    free masses on one spring (k + 2 zeta w0 m s) x, since the modal damper stands on the ground as the spring does."""
    system = machine()
    losses = {"feet": 0.3}
    K = system.stiffness + 0.3j * np.diag([900.0, 0.0]) * (HERTZ > 0)[:, None, None]
    frame, _ = motion_of(system, [0.0, 1.0], K)
    H = system.frequency_response(HERTZ, ["machine"], quantity="force transmissibility", loss_factor=losses)
    assert H.outputs == ("force on ground",) and H.units.tolist() == [["1"]]
    right = (900 * (1 + 0.3j * (HERTZ > 0)) + 7 * 2j * np.pi * HERTZ) * frame
    np.testing.assert_allclose(H.values[0, 0], right, rtol=1e-12)
    assert H.values[0, 0, 0] == pytest.approx(1.0, rel=1e-14)

    model = mb.LumpedModel()
    model.mass("m", 2.0)
    model.spring("ground", "m", stiffness=50.0, name="k")
    s = 2j * np.pi * HERTZ
    T = model.assemble().frequency_response(HERTZ, ["m"], quantity="force transmissibility", modal_damping=0.1).values[0, 0]
    np.testing.assert_allclose(T, (50 + 2 * s) / (2 * s**2 + 2 * s + 50), rtol=1e-12)  # 2 zeta w0 m = 2 * 0.1 * 5 * 2


def test_torques_on_the_ground_and_pinned_points():
    """A shaft between a driven disc and a clamped end: the clamp carries what the shaft does."""
    model = mb.LumpedModel()
    model.inertia("disc", 0.5)
    model.inertia("end", 0.1)
    model.torsion_spring("disc", "end", stiffness=200.0, name="shaft")
    model.torsion_damper("ground", "disc", damping=0.4, name="bearing")
    model.prescribe("end", mb.step(0.0), name="clamp")
    system = model.assemble()
    H = system.frequency_response(HERTZ, ["disc"], ["torque on ground", "reaction of clamp"])
    s = 2j * np.pi * HERTZ
    x = 1 / (0.5 * s**2 + 0.4 * s + 200)
    np.testing.assert_allclose(H.values[:, 0], [(200 + 0.4 * s) * x, -200 * x], rtol=1e-12)
    with pytest.raises(mb.InputError, match="force on ground: no coordinate is in m"):
        system.frequency_response([1.0], ["disc"], ["force on ground"])


def test_free_bodies_at_rest():
    """A chain that nothing holds, pushed at its first body: all accelerate with 1/M, and each spring carries the mass behind it."""
    rng = np.random.default_rng(1)
    masses, model = rng.uniform(0.1, 30, 6), mb.LumpedModel()
    for i, mass in enumerate(masses):
        model.mass(f"b{i}", mass)
    for i, stiffness in enumerate(10 ** rng.uniform(2, 7, 5)):
        model.spring(f"b{i}", f"b{i + 1}", stiffness=stiffness, name=f"k{i}")
        model.damper(f"b{i}", f"b{i + 1}", damping=20.0, name=f"c{i}")
    forces = [f"force of k{i}" for i in range(5)]
    names = [*forces, "acceleration of b3", "force on ground", "force of c2", "b4", "velocity of b3"]
    H = model.assemble().frequency_response([0.0], ["b0"], names)
    carried = -np.cumsum(masses[::-1])[::-1][1:] / masses.sum()
    np.testing.assert_allclose(H.values[:7, 0, 0], [*carried, 1 / masses.sum(), 0], rtol=1e-11, atol=1e-14)
    assert np.isinf(H.error_estimate[8:, 0, 0]).all() and (H.error_estimate[:6, 0, 0] < 1e-11).all()
    assert not H.poles_on_lines[0].pole.residues[:, :8].any()
    alone = model.assemble().frequency_response([0.0], ["b0"], ["b1", "b5"], "accelerance")
    np.testing.assert_allclose(alone.values[:, 0, 0], 1 / masses.sum(), rtol=1e-11)
    assert not alone.poles_on_lines


def test_motions_and_random_vibration_know_the_same_names():
    system = machine()
    names = ["force on ground", "velocity of machine - frame", "mount", "acceleration of machine"]
    motion = system.solve([0.0, 0.01], force=mb.step([0.0, 5.0]))
    peaks, t = motion.peaks(6.0, names), np.linspace(0.0, 6.0, 60_001)
    x, v, a = motion(t), motion.derivative(1)(t), motion.derivative(2)(t)
    curves = [900 * x[0] + 7 * v[0], v[1] - v[0], 300 * (x[1] - x[0]), a[1]]
    np.testing.assert_allclose(peaks.maximum, np.max(curves, axis=1), rtol=1e-6)
    np.testing.assert_allclose(peaks.minimum, np.min(curves, axis=1), rtol=1e-6)
    assert [row["quantity"] for row in peaks.rows()] == ["force", "relative velocity", "force", "acceleration"]
    noise = system.random_response({"machine": mb.psd([0.1, 50.0], [3.0, 3.0])}, names)
    lines = np.linspace(0.1, 50.0, 50_001)
    H = system.frequency_response(lines, ["machine"], names).values[:, 0]
    assert list(noise.units) == ["N", "m/s", "N", "m/s^2"]
    np.testing.assert_allclose(noise.rms, np.sqrt(np.trapezoid(3.0 * np.abs(H) ** 2, lines, axis=1)), rtol=1e-5)


def test_rest_lengths_count_in_motions():
    """A force of a spring is k (x - its rest length); at rest the ground carries both loads, whatever that length is."""
    motion = machine(rest_length=0.2).solve(force=mb.step([30.0, 20.0]))
    feet, t = motion.peaks(2.0, ["force of feet", "force on ground"]), np.linspace(0.0, 2.0, 80_001)
    x, v = motion(t)[0], motion.derivative(1)(t)[0]
    np.testing.assert_allclose(feet.maximum, [(900 * (x - 0.2)).max(), (900 * (x - 0.2) + 7 * v).max()], rtol=1e-6)
    assert 900 * (motion([400.0])[0, 0] - 0.2) == pytest.approx(50.0, abs=1e-6)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("machin", 'did you mean "machine"'),
        ("velocity of machin", 'did you mean "velocity of machine"'),
        ("force of mout", 'did you mean "force of mount"'),
        ("force on grond", 'did you mean "force on ground"'),
        ("torque on ground", "no coordinate is in rad"),
        ("elongation of frame", '"frame" has no elongation: it is a coordinate'),
        ("reaction of mount", '"mount" has no reaction: it is a spring or damper'),
        ("something else", 'known are, among others, .*"velocity of x"'),
        ("", 'there is no ""'),
    ],
)
def test_names_that_are_none(name, message):
    with pytest.raises(mb.InputError, match=message):
        machine().frequency_response([1.0], ["machine"], [name])


def test_the_ground_feels_modal_damping_in_a_steady_state():
    """Sums of harmonics and the periodic motion in closed form have the same force; the balance of forces M x'' = f - F holds."""
    system, load, t = machine(), mb.harmonic([3.0, 1.0], frequency_hz=0.5), np.linspace(0.0, 2.0, 9)
    names = ["force on ground", "acceleration of frame", "acceleration of machine", "velocity of machine - frame"]
    sums = system.steady_state(load, modal_damping=0.05, outputs=names).output(t)
    closed = system.steady_state(load, period=2.0, modal_damping=0.05, outputs=names).output(t)
    np.testing.assert_allclose(closed, sums, atol=1e-12 * np.abs(sums).max())
    np.testing.assert_allclose(sums[0], 4 * np.cos(np.pi * t) - 3 * sums[1] - 2 * sums[2], atol=1e-12)


@pytest.mark.parametrize("name", ["dropped_crate", "hopper", "stick_slip", "gear_rattle", "lifted_load"])
def test_the_force_on_the_ground_balances_contacts_friction_and_ropes(name, tmp_path):
    """w M x'' = w f - F in every phase: forces of contacts and friction are reactions, which act on the ground as springs do."""
    text = (EXAMPLES / f"{name}.toml").read_text(encoding="utf-8")
    what = "torque on ground" if name == "gear_rattle" else "force on ground"
    scene = scene_of(tmp_path, f'{text}\n[[output.quantity]]\nof = "{what}"\n')
    motion, system = scene.run().motion, scene.system
    times = np.linspace(0.0, 0.98 * motion.end, 200) + 1e-4
    force = system.quantities[what].values(motion, times)
    along = np.array([float(unit == ("rad" if name == "gear_rattle" else "m")) for unit in system.units.values()])
    loads = system.force if scene.equations.force is None else system.force + scene.equations.force
    inertia = along @ system.mass @ motion.derivative(2)(times)
    np.testing.assert_allclose(inertia, along @ loads(times) - force, atol=1e-9 * np.abs(force).max())
    assert np.ptp(force) > 0.1 * np.abs(force).max()
    assert motion.peaks(0.9 * motion.end, what).maximum[0] >= force[times <= 0.9 * motion.end].max() * (1 - 1e-9)


def test_phases_with_equations_of_their_own_have_no_common_force_on_the_ground():
    free = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]])
    stiff = mb.MechanicalSystem([[1.0]], stiffness=[[9.0]])
    machine = mb.SwitchedSystem({"free": free, "stiff": stiff}, [mb.Transition("free", "stiff", when={"x1": 1.0}, above=0.5)])
    with pytest.raises(mb.InputError, match="phases with equations of their own"):
        machine.solve(velocity=[2.0], end=3.0).peaks(1.0, "force on ground")


# Forces of springs and dampers.


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
