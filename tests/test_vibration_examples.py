"""Examples of vibration in the frequency domain, and of prescribed motion, against closed forms and published optima."""

import itertools
import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.linalg import eigh, expm
from scipy.signal import lsim

from mbconstrained.analyses.frequency import Frequency
from mbconstrained.analyses.random import random_response
from mbconstrained.analyses.shock import Shock
from mbconstrained.scene.run.scene import read_scene

EXAMPLES = Path(__file__).parents[1] / "examples"


def frequency(name, settings=None) -> Frequency:
    return Frequency(read_scene(EXAMPLES / f"{name}.toml", settings))


def amplitudes(own: Frequency, output: str) -> list[float]:
    return [peak.amplitude for peak in own.peaks if peak.output == output]


def test_the_tuned_mass_damper_has_the_peaks_of_den_hartog_and_of_the_exact_optimum():
    """Peaks by the static deflection: Den Hartog (1956) sqrt(1 + 2/ratio) nearly, Nishihara and Asami (2002) exactly; 40 digits used here."""
    static = 1 / (100 * (2 * math.pi * 5) ** 2)
    best = amplitudes(frequency("tuned_mass_damper"), "machine")
    assert np.array(best) / static == pytest.approx([6.4079207680046215] * 2, rel=1e-12)
    settings = {"tuning": 1 / 1.05, "zeta": math.sqrt(3 * 0.05 / (8 * 1.05))}
    rules = amplitudes(frequency("tuned_mass_damper", settings), "machine")
    assert max(rules) / static == pytest.approx(6.408443169703712, rel=1e-12)
    for wrong in ({"tuning": 0.97}, {"zeta": 0.10}, {"zeta": 0.17}):
        assert max(amplitudes(frequency("tuned_mass_damper", wrong), "machine")) > max(best)


@pytest.mark.parametrize("zeta", [0.02, 0.1, 0.3, 1.0])
def test_isolation_begins_at_the_square_root_of_two_for_every_damping(zeta):
    own = frequency("vibration_isolation", {"zeta": zeta})
    T = own.response([3 * math.sqrt(2) * (1 - 1e-6), 3 * math.sqrt(2), 3 * math.sqrt(2) * (1 + 1e-6)]).values[0, 0]
    assert abs(T[1]) == pytest.approx(1.0, rel=1e-13) and abs(T[0]) > 1 > abs(T[2])
    r = own.response.frequencies_hz / 3
    assert own.response.values[0, 0] == pytest.approx((1 + 2j * zeta * r) / (1 - r**2 + 2j * zeta * r), rel=1e-12)


def test_the_isolated_machine_settles_at_the_amplitude_of_its_transmissibility():
    own = frequency("vibration_isolation")
    T, motion = own.response([12.0]).values[0, 0, 0], own.scene.run().motion
    late = 3.0 + np.linspace(0, 1 / 12, 13)  # the free motion has decayed to e^(-0.1 * 2 pi 3 * 3) = 0.35 %
    place = own.scene.equations.coordinates.names.index("machine")
    expected = 1e-3 * np.abs(T) * np.sin(2 * math.pi * 12 * late + np.angle(T))
    assert motion(late)[place] == pytest.approx(expected, abs=0.02 * 1e-3)


def test_the_quarter_car_answers_a_wavy_road_as_its_closed_form():
    own = frequency("quarter_car")
    s = 2j * math.pi * own.response.frequencies_hz
    body, wheel, spring, tyre = 300 * s**2, 40 * s**2, 20e3 + 1200 * s, 180e3
    ratio = spring / (body + spring)  # of the body by the wheel
    hub = tyre / (wheel + tyre + spring - spring * ratio)
    values = dict(zip(own.response.outputs, own.response.values[:, 0]))
    assert values["wheel"] == pytest.approx(hub, rel=1e-12) and values["body"] == pytest.approx(hub * ratio, rel=1e-12)


def test_three_storeys_drift_as_those_of_a_simulation_relative_to_the_ground():
    """z'' + ... = -1 a of the storeys relative to the ground, by the first-order hold of SciPy: exact for a record of straight lines."""
    result = frequency("three_storeys").scene.run()
    record = np.loadtxt(EXAMPLES / "records" / "ground_acceleration.csv", delimiter=",", skiprows=1)
    M, storeys = np.diag([20e3, 20e3, 15e3]), np.array([[2.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
    lower = -np.linalg.solve(M, np.hstack([20e6 * storeys, 80e3 * storeys]))
    A, B = np.vstack([np.hstack([np.zeros((3, 3)), np.eye(3)]), lower]), np.r_[np.zeros(3), -np.ones(3)][:, None]
    C = np.array([[1.0, 0, 0, 0, 0, 0], [0, -1, 1, 0, 0, 0]])
    times = np.arange(0.0, 12.01, 0.02)
    _, drifts, _ = lsim((A, B, C, np.zeros((2, 1))), 9.80665 * record[:, 1], times)
    assert result.curves("quantity").values[:, :601] == pytest.approx(drifts.T, abs=1e-10)
    T = Frequency(result.scene).response  # at rest the building moves with the ground, without drift
    assert T.inputs == ("earthquake",) and T([1e-3]).values.real.ravel() == pytest.approx([1, 1, 1, 0, 0], abs=1e-5)


def test_the_machine_on_rubber_is_a_chain_of_dynamic_stiffnesses():
    own = frequency("machine_on_foundation")
    s = 2j * math.pi * own.response.frequencies_hz
    mount = 2e6 + 1 / (1 / 3e6 + 1 / (20e3 * s))  # the massless joint: spring and damper in series
    soil = 150e6 + 200e3 * s
    foundation = mount / (2000 * s**2 + soil + mount)  # by the machine
    machine = 1 / (500 * s**2 + mount * (1 - foundation))
    assert own.response.values[0, 0] == pytest.approx(s * machine, rel=1e-11)
    assert own.response.values[1, 0] == pytest.approx(s * machine * foundation, rel=1e-11)


def test_the_stretched_arm_is_softer_and_slower():
    """Both postures against full complex solutions of the linearized equations; motors and gears in series at rest."""
    stretched = {"model.guess.j4": "-20 deg", "model.guess.j6": "20 deg"}
    found = []
    for settings in ({}, stretched):
        own = frequency("arm_compliance", settings)
        system, f = own.system, np.array([0.5, 5.0, 50.0])
        b, C = system.inputs["force on the tool"], system.output_matrix
        for line, value in zip(f, np.moveaxis(own.response(f).values[:, 0], 1, 0)):
            s = 2j * math.pi * line
            full = C @ np.linalg.solve(system.mass * s**2 + system.damping * s + system.stiffness, b)
            assert value == pytest.approx(full, rel=1e-8)
        resonance = min(peak.frequency_hz for peak in own.peaks if peak.output == "tool upwards")
        found.append((abs(own.response([0.5]).values[0, 0, 0]), resonance))
    (soft, fast), (softer, slower) = found
    assert softer > 1.2 * soft and slower < 0.95 * fast


def test_electronics_box():
    """RMS acceleration by adaptive quadrature of (w_n^4 + (2 z w_n w)^2) / |D|^2 times the straight lines of the table."""
    name = "electronics_box"
    response = random_response(read_scene(EXAMPLES / f"{name}.toml"))
    wn, z = 2 * np.pi * 30.0, 0.05
    corners, values = np.array([20.0, 80.0, 350.0, 2000.0]), np.array([0.01, 0.04, 0.04, 0.007])

    def density(f):
        w = 2 * np.pi * f
        G = np.exp(np.interp(np.log(f), np.log(corners), np.log(values)))
        return G * (wn**4 + (2 * z * wn * w) ** 2) / ((wn**2 - w**2) ** 2 + (2 * z * wn * w) ** 2)

    edges = [20.0, 29.0, 31.0, 80.0, 350.0, 2000.0]
    total = sum(quad(density, a, b, epsabs=0, epsrel=1e-13)[0] for a, b in itertools.pairwise(edges))
    assert np.isclose(response.rms[0], 9.80665 * np.sqrt(total), rtol=1e-11)


def rms_by_quadrature(transfer, density, edges) -> float:
    """The root of the integral of |H|^2 G by adaptive quadrature between edges in Hz."""
    pieces = itertools.pairwise(edges)
    return math.sqrt(
        sum(
            quad(lambda f: abs(transfer(2 * np.pi * f)) ** 2 * density(f), a, b, epsabs=0, epsrel=1e-11, limit=400)[0]
            for a, b in pieces
        )
    )


def test_building_in_earthquake():
    """Floors relative to the soil: -M 1 times the filtered acceleration of the rock (Kanai 1957, Tajimi 1960)."""
    response = random_response(read_scene(EXAMPLES / "building_in_earthquake.toml"))
    masses = np.array([20e3, 20e3, 15e3])
    chain = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])

    def soil(f):
        r = f / 2.5
        return 0.01 * (1 + (1.2 * r) ** 2) / ((1 - r**2) ** 2 + (1.2 * r) ** 2)

    frequencies = np.sqrt(np.linalg.eigvals(20e6 / masses[:, None] * chain).real) / (2 * np.pi)
    edges = [1e-6, *np.sort(frequencies), 20.0, 200.0, 2000.0]
    for floor in range(3):

        def drift(w, floor=floor):
            return np.linalg.solve(np.diag(-(w**2) * masses) + (20e6 + 80e3j * w) * chain, -masses.astype(complex))[floor]

        assert np.isclose(response.rms[floor], rms_by_quadrature(drift, soil, edges), rtol=1e-8)


def test_car_on_road():
    """Both axles follow one road, the rear 0.135 s later; ISO 8608 class C: G(n) = 256e-6 (n / 0.1)^-2 m^3 at n = f / v."""
    response = random_response(read_scene(EXAMPLES / "car_on_road.toml"))
    k, c, arms, m, J, delay = np.array([35e3, 30e3]), 1.5e3, np.array([-1.5, 1.2]), 1200.0, 1500.0, 2.7 / 20.0

    def accelerations(w):
        z = k + 1j * w * c
        road = np.array([np.exp(-1j * w * delay), 1.0])
        stiffness = np.array([[z.sum(), z @ arms], [z @ arms, z @ arms**2]])  # of height and of the angle that raises the front
        return -(w**2) * np.linalg.solve(stiffness - w**2 * np.diag([m, J]), [z @ road, (z * arms) @ road])

    def road(f):
        return 256e-6 * (f / 20.0 / 0.1) ** -2 / 20.0

    edges = [0.011 * 20.0, 1.0, 2.0, 5.0, 20.0, 2.83 * 20.0]  # the spatial frequencies of the standard
    for output in range(2):
        expected = rms_by_quadrature(lambda w, output=output: accelerations(w)[output], road, edges)
        assert np.isclose(response.rms[output], expected, rtol=1e-9)


def test_arm_on_shaking_base():
    """RMS of the tool's acceleration by quadrature of the transfer function from M, C, K and the row of the floor."""
    scene = read_scene(EXAMPLES / "arm_on_shaking_base.toml")
    own, system = random_response(scene), scene.equations.system
    n, A = system.size, system.constraint_matrix
    floor = [row.name for row in system.rows].index("floor")
    up = system.outputs["tool upwards"]
    corners, values = np.log([2.0, 10.0, 100.0]), np.log([1e-4, 1e-3, 1e-3])

    def transfer(w):  # of accelerations
        D = system.stiffness - w**2 * system.mass + 1j * w * system.damping
        saddle = np.block([[D, A.T], [A, np.zeros((len(A), len(A)))]])
        return up @ np.linalg.solve(saddle, np.eye(len(saddle))[n + floor])[:n]

    edges = np.unique([2.0, 10.0, 100.0, *(f for f in system.modes().frequencies_hz if 2.0 < f < 100.0)])
    expected = rms_by_quadrature(transfer, lambda f: np.exp(np.interp(np.log(f), corners, values)), edges)
    assert np.isclose(own.rms[0], 9.80665 * expected, rtol=1e-8)


def test_half_sine_drop():
    """The mounts' force by Duhamel's integral of the half sine: the largest acceleration of the instrument."""
    shock = Shock.answer(read_scene(EXAMPLES / "half_sine_drop.toml"))
    w, z, A, T = 2 * np.pi * 12.0, 0.1, 50 * 9.80665, 11e-3
    W = np.pi / T
    # states: relative displacement and velocity, sin W t, cos W t
    S = np.array([[0, 1, 0, 0], [-(w**2), -2 * z * w, -A, 0], [0, 0, 0, W], [0, 0, -W, 0]])
    times = np.linspace(0, 0.05, 5001)
    step = expm(S * times[1])
    states, accelerations = np.array([0.0, 0.0, 0.0, 1.0]), []
    for time in times:
        if time > T:
            states[2:] = 0.0
        accelerations.append(-(w**2) * states[0] - 2 * z * w * states[1])
        states = step @ states
    (largest,) = (row["maximum"] for row in shock.data["peaks"] if (row["quantity"], row["of"]) == ("acceleration", "instrument"))
    assert largest == pytest.approx(max(accelerations), rel=1e-5)
    assert largest >= max(accelerations) * (1 - 1e-12)


@pytest.mark.long
def test_the_gear_train_scatters_as_the_closed_form_of_each_specimen():
    """J2 reduced by i^2 = (r2 / r1)^2: w^2 of three inertias on two springs are roots of a quadratic; tolerances of first order."""
    result = read_scene(EXAMPLES / "gear_tolerances.toml").sweep(samples=400).run()
    J1, J2, J3, k1, k2 = (result.parameter(name) for name in ("motor", "gears", "load", "fast", "slow"))
    ratio = (result.parameter("wheel") / result.parameter("pinion")) ** 2
    J2, J3, k2 = J2 / ratio, J3 / ratio, k2 / ratio
    a, b, c = J1 * J2 * J3, -(k1 * J3 * (J1 + J2) + k2 * J1 * (J2 + J3)), k1 * k2 * (J1 + J2 + J3)
    root = np.sqrt(b**2 - 4 * a * c)
    expected = np.sqrt([2 * c / (root - b), (root - b) / (2 * a)]) / (2 * np.pi)
    for number, frequencies in enumerate(expected, 1):
        assert result.values(f"frequency {number}") == pytest.approx(frequencies, rel=1e-12)
    share = (expected[0] > 14.8).mean()
    estimate = result.exceedance("frequency 1", 14.8)
    assert estimate.value == share and estimate.low < share < estimate.high
    slopes = result.scene.sensitivities(["fast", "slow", "load", "motor", "gears"]).logarithmic[:, 0]
    spread = np.sqrt((slopes**2 * np.array([0.06, 0.06, 0.03, 0.02, 0.04]) ** 2).sum())  # independent tolerances
    assert np.std(expected[0]) / np.mean(expected[0]) == pytest.approx(spread, rel=0.15)


def rotor_matrices():
    """m, Jd, Jp and the stiffness over z = y + i z and the tilt of rotor.toml: of a cylinder, from its parameters."""
    mass = 7810 * math.pi / 4 * 0.2**2 * 0.5
    stiffness = np.array([[2.3e6, 0.3e6 * 0.25], [0.3e6 * 0.25, 2.3e6 * 0.25**2]])
    return mass, mass * (0.2**2 / 16 + 0.5**2 / 12), mass * 0.2**2 / 8, stiffness


def test_the_rotor_has_the_critical_speeds_of_its_quadratic_equations():
    """(kT - m W^2) (kR - (Jd -+ Jp) W^2) = kC^2 without damping (Friswell et al. 2010, chapter 3)."""
    scene = read_scene(EXAMPLES / "rotor.toml", {"c": 1e-90})
    mass, diametral, polar, K = rotor_matrices()
    expected = []
    for inertia in (diametral - polar, diametral + polar):
        expected += np.roots([mass * inertia, -(K[0, 0] * inertia + K[1, 1] * mass), np.linalg.det(K)]).tolist()
    critical = scene.equations.rotor.critical_speeds()
    assert critical == pytest.approx(np.sqrt(np.sort(expected)), rel=1e-9)
    diagram = scene.equations.rotor.campbell(np.linspace(0.0, 400.0, 5))
    assert sorted(diagram.directions) == ["backward", "backward", "forward", "forward"]


def test_the_unbalance_response_of_the_rotor():
    """(K + i W (C - W G') - W^2 M) (z, tilt) = W^2 u with the forward unbalance at the end A alone."""
    rotor = read_scene(EXAMPLES / "rotor.toml").equations.rotor
    mass, diametral, polar, K = rotor_matrices()
    M, C = np.diag([mass, diametral]), 600 * np.diag([2.0, 2 * 0.25**2])
    speeds = np.linspace(0.0, 400.0, 21)
    response = rotor.unbalance_response(speeds)

    def expected(W):
        A = K + 1j * W * C - W**2 * (M - np.diag([0.0, polar]))
        return np.linalg.solve(A, W**2 * 2e-3 * np.array([1.0, -0.25]))

    names = list(rotor.names)
    found = response.values[:, [names.index("rotor y"), names.index("rotor y angle")]]
    assert found == pytest.approx(np.array([expected(W) for W in speeds]), rel=1e-10, abs=1e-18)
    for peak in response.peaks:
        if peak.coordinate == "A y":
            near = [abs(np.dot([1.0, -0.25], expected(peak.speed * (1 + step)))) for step in (-1e-4, 0.0, 1e-4)]
            assert near[1] == max(near) == pytest.approx(peak.amplitude, rel=1e-12)
    assert sum(peak.coordinate == "A y" for peak in response.peaks) == 2  # one of each forward mode


def test_the_driveline_of_the_examples_is_that_of_matrices_written_by_hand():
    """Angles of engine, flywheel, pinion and load, the last two as seen from the pinion through the ratio 2."""
    answer = read_scene(EXAMPLES / "driveline.toml").orders(points=40)
    M = np.diag([0.15, 0.9, 0.05 + 0.4 / 4, 6.0 / 4])
    spring = np.array([[1, -1, 0, 0], [0, 1, -1, 0], [0, 0, 1, -1]])
    K = spring.T @ np.diag([120e3, 3e3, 60e3 / 4]) @ spring
    C = spring.T @ np.diag([8.0, 6.0, 0.0]) @ spring + np.diag([0, 0, 0, 15.0 / 4])
    arrays = answer.arrays()
    W, n = arrays["speeds"], arrays["orders"]
    np.testing.assert_array_equal(n, [0.5, 1, 2, 4, 6])
    torque = np.array([12, 15, 180, 60, 20])[:, None] * np.exp(1j * np.radians([0, 40, 0, -30, -60]))[:, None] * np.ones(len(W))
    torque[2] -= 25 * (W / (3000 * np.pi / 30)) ** 2
    expected = np.zeros((5, 2, len(W)), dtype=complex)
    for i, j in np.ndindex(5, len(W)):
        w = n[i] * W[j]
        x = np.linalg.solve(K - w**2 * M + 1j * w * C, torque[i, j] * np.array([1, 0, 0, 0]))
        expected[i, :, j] = 3e3 * (x[2] - x[1]), 60e3 / 2 * (x[3] - x[2])  # the shaft turns half as far, at the wheel
    sign = np.sign((arrays["amplitudes"][0, 1, 0] / expected[0, 1, 0]).real)  # the wheel turns backwards
    expected[:, 1] *= sign
    np.testing.assert_allclose(arrays["amplitudes"], expected, rtol=1e-9)
    angle = np.linspace(0, 4 * np.pi, 20001)  # two turns of the crankshaft
    for j in range(0, len(W), 7):
        cycle = (expected[:, 0, j, None] * np.exp(1j * n[:, None] * angle)).sum(axis=0).real
        assert arrays["largest"][0, j] == pytest.approx(np.abs(cycle).max(), rel=1e-6)
        assert arrays["rms"][0, j] == pytest.approx(np.sqrt(np.mean(cycle[:-1] ** 2)), rel=1e-9)
    state = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    damped = sorted({round(s.imag, 6) for s in np.linalg.eigvals(state) if s.imag > 1})
    found = sorted({round(one["order"] * one["speed"], 6) for one in answer.data["resonances"]})
    assert found == pytest.approx(damped, rel=1e-8)


def test_the_floor_feels_a_washing_machine_as_the_formula_says():
    """Cramer's rule for tub and cabinet: F = f kf ks / D and tub - cabinet = f (kf - mc W^2) / D, k with i W c, D = a b - ks^2."""

    def by_hand(W):
        suspension, feet = 10e3 + 220j * W, 400e3 + 600j * W
        determinant = (suspension - 45 * W**2) * (suspension + feet - 30 * W**2) - suspension**2
        return np.array([feet * suspension, feet - 30 * W**2, suspension]) / determinant

    scene = read_scene(EXAMPLES / "washing_machine.toml")
    response = Frequency(scene).response
    np.testing.assert_allclose(response.values[0, 0], by_hand(2 * np.pi * response.frequencies_hz)[0], rtol=1e-11)
    answer = scene.orders(points=60)
    arrays, unbalance = answer.arrays(), 0.35 * 0.24
    expected = unbalance * arrays["speeds"] ** 2 * by_hand(arrays["speeds"])
    np.testing.assert_allclose(arrays["amplitudes"][0], expected, rtol=1e-11)
    dense = np.linspace(30, 1400, 100_001) * np.pi / 30
    top = np.abs(unbalance * dense**2 * by_hand(dense)).max(axis=1)
    assert [one["value"] for one in answer.data["largest"]] == pytest.approx(top, rel=1e-8)
    assert [one["output"] for one in answer.data["largest"]] == ["force on ground", "travel of the tub", "cabinet"]
    result, W = scene.run(), 1000 * np.pi / 30  # the free motion decays with 2.3 1/s and 13.7 1/s
    late = result.scene.equations.solve()
    times = 12 + np.linspace(0, 2 * np.pi / W, 50)
    steady = (unbalance * W**2 * by_hand(np.array([W]))[:2] * np.exp(1j * W * times)).real
    curves = np.array([one.values(late, times) for one in scene.system.quantities.values()])
    np.testing.assert_allclose(curves, steady, atol=1e-9 * np.abs(steady).max())
    assert list(scene.system.quantities) == list(result.curves("quantity").names) == ["force on ground", "travel of the tub"]


def spindle_matrices():
    """M, C, K and the polar inertias of spindle.toml in one plane: displacements and slopes of shaft and tool; rows of tip and nose."""
    places = {"rear": (0, -0.18), "front": (0, 0.12), "deep": (0, 0.13), "nose": (0, 0.2), "end": (1, -0.09), "flange": (1, -0.02)}
    places["tip"] = (1, 0.13)
    row = {name: np.eye(2)[body].repeat(2) * [1.0, s, 1.0, s] for name, (body, s) in places.items()}
    springs = np.array([row["rear"], row["front"], row["deep"] - row["end"], row["nose"] - row["flange"]])
    K, C = (springs.T @ np.diag(values) @ springs for values in ([120e6, 180e6, 150e6, 300e6], [2e3, 3e3, 1e3, 1.5e3]))
    return np.diag([16.0, 0.28, 1.4, 0.006]), C, K, np.diag([0.0, 0.012, 0.0, 0.0008]), row["tip"], row["nose"]


def test_the_spindle_yields_at_its_tip_as_matrices_written_by_hand():
    """Forward and backward motion y + i z and its conjugate have (K + i w C - w^2 M +- w W G) (y, slopes) = f; at 0 Hz levers suffice."""
    scene = read_scene(EXAMPLES / "spindle.toml")
    M, C, K, G, tip, nose = spindle_matrices()
    found = scene.frequency().arrays()
    W, w = 6000 * math.pi / 30, 2 * np.pi * found["frequencies_hz"]

    def compliance(row, w, W):
        return np.array([row @ np.linalg.solve(K + 1j * one * C - one**2 * M + one * W * G, tip) for one in w])

    forward, backward = ([compliance(row, w, sign * W) for row in (tip, nose)] for sign in (1, -1))
    expected = [(forward[0] + backward[0]) / 2, (forward[1] + backward[1]) / 2, (forward[0] - backward[0]) / 2j]
    assert found["values"][:, 0] == pytest.approx(np.array(expected), rel=1e-8, abs=1e-13)
    static = scene.system.frequency_response([0.0], ["tip y"], ["tip y"]).values[0, 0, 0]
    levers = (530 / 300) ** 2 / 180e6 + (230 / 300) ** 2 / 120e6 + (220 / 70) ** 2 / 300e6 + (150 / 70) ** 2 / 150e6
    assert static == pytest.approx(levers, rel=1e-12)
    resting = scene.equations.rotor.modes(damped=False).natural_frequencies  # each in both planes
    assert resting == pytest.approx(np.sqrt(eigh(K, M, eigvals_only=True)).repeat(2), rel=1e-10)
    limit = -1 / (2 * 800e6 * found["values"][0, 0].real.min())  # steel: 800 N by mm^2
    assert 0.5e-3 < limit < 2e-3


def test_the_spindle_over_its_speed_under_teeth_and_unbalance():
    """Order 1 turns forward and is that of 64 g mm; of the order 4 a force along y is half a forward and half a backward one."""
    answer = read_scene(EXAMPLES / "spindle.toml").orders(points=30, outputs=["tip y"])
    M, C, K, G, tip, _ = spindle_matrices()
    arrays = answer.arrays()
    np.testing.assert_array_equal(arrays["orders"], [0, 1, 4, 8])

    def response(load, w, W):
        return tip @ np.linalg.solve(K + 1j * w * C - w**2 * M + w * W * G, load)

    for speed, amplitudes in zip(arrays["speeds"][::9], arrays["amplitudes"][:, 0, ::9].T):
        expected = [300 * response(tip, 0, 0), response([64e-6 * speed**2, 0, 0, 0], speed, speed)]
        expected += [size * sum(response(tip, n * speed, W) for W in (speed, -speed)) / 2 for n, size in ((4, 140), (8, 30))]
        assert amplitudes == pytest.approx(np.array(expected), rel=1e-8)


@pytest.mark.long
def test_the_optimum_of_the_tuned_mass_damper_is_that_of_its_scene():
    """tuned_mass_damper_optimum varies what tuned_mass_damper.toml has exactly (Nishihara and Asami 2002)."""
    optimum = read_scene(EXAMPLES / "tuned_mass_damper_optimum.toml").optimise()
    exact = read_scene(EXAMPLES / "tuned_mass_damper.toml").parameters.values
    assert [optimum.parameters[name] for name in ("tuning", "zeta")] == pytest.approx([exact["tuning"], exact["zeta"]], abs=1e-5)


def test_chatter_grows_between_two_lobes_and_decays_on_one():
    """The limit of the cutting stiffness whatever the speed is 2 k zeta (1 + zeta); between the lobes more is stable (Altintas, 4.3)."""
    k, pressure = 2 * (2 * math.pi * 250) ** 2, 1.2e9
    safe = 2 * k * 0.03 * 1.03 / pressure
    growing = read_scene(EXAMPLES / "chatter.toml").run()
    assert growing.is_trusted and max(mode.eigenvalue.real for mode in growing.modes) == pytest.approx(6.96, abs=0.01)
    largest = [abs(growing.motion(np.linspace(t, t + 0.05, 500))[0] - 20 / k).max() for t in (0.1, 0.2)]
    assert largest[1] > largest[0] > 0
    for settings in ({"width": 0.999 * safe}, {"turn": 0.012}):
        modes = read_scene(EXAMPLES / "chatter.toml", settings).system.modes()
        assert max(modes.eigenvalues.real) < 0
    peak = next(one for one in frequency("chatter", {"turn": 0.012}).peaks if one.frequency_hz > 240)
    s = 2j * math.pi * peak.frequency_hz
    own = 2 * s * s + 4 * math.pi * 0.03 * 2 * 250 * s + k + pressure * 4e-4 * (1 - np.exp(-0.012 * s))
    assert peak.amplitude == pytest.approx(1 / abs(own), rel=1e-10)
    ratios = [
        next(one for one in frequency("chatter", own).peaks if one.frequency_hz > 240).damping_ratio
        for own in ({}, {"turn": 0.012})
    ]
    root = next(mode.eigenvalue for mode in growing.modes if mode.eigenvalue.real > 0)
    assert ratios[0] == pytest.approx(-root.real / abs(root), rel=0.01) and ratios[1] > 0  # the peak of a motion that grows


def test_the_bicycle_steers_itself_between_the_published_speeds():
    """Meijaard et al. (2007): speeds of double root, weave and capsize (section 6), eigenvalues at 5 m/s (table 2)."""
    locus = read_scene(EXAMPLES / "bicycle.toml").root_locus("v", np.linspace(0.0, 8.0, 81))
    assert [one.parameter for one in locus.break_points] == pytest.approx([0.68428307889246], rel=1e-12)
    assert locus.stability_limits == pytest.approx([4.29238253634111, 6.02426201538837], rel=1e-12)
    published = [-14.07838969279822, -0.77534188219585 + 4.46486771378823j, -0.32286642900409]
    values = [mode.eigenvalue for mode in read_scene(EXAMPLES / "bicycle.toml").run().modes]
    assert sorted(values, key=lambda value: value.real) == pytest.approx(published, rel=1e-13)


def test_the_crane_with_a_shaper_stops_without_swing_and_the_other_one_swings_as_its_closed_form():
    """Modes of the double pendulum; the swing after a versed sine of the velocity by its Fourier integral (Duhamel)."""
    hook, load, upper, lower, speed, T = 200.0, 1000.0, (1200 * 9.81) / 6, (1000 * 9.81) / 2, 1.0, 4.0
    M, K = np.diag([hook, load]), np.array([[upper + lower, -lower], [-lower, lower]])
    squares, shapes = eigh(K, M)
    w, excited = np.sqrt(squares), shapes.T @ M @ [1.0, 1.0]
    result = read_scene(EXAMPLES / "crane.toml").run()
    place = result.scene.equations.coordinates.names.index
    t = np.linspace(4.0, 20.0, 65)
    forced = 2 * math.pi / T
    integral = speed * math.pi / T * forced * (1 - np.exp(-1j * w * T)) / (forced**2 - squares)
    swing = shapes @ (-(excited / w)[:, None] * np.imag(np.exp(1j * np.outer(w, t)) * integral[:, None]))
    rear = [place("rear hook"), place("rear load")]
    assert result.motion(t)[rear] == pytest.approx(2.0 + swing, abs=1e-12)
    [shaper] = result.to_dict()["shapers"]
    halves = math.pi / w
    times = np.add.outer(halves[0] * np.arange(3), halves[1] * np.arange(3)).ravel()
    weights = np.multiply.outer([0.25, 0.5, 0.25], [0.25, 0.5, 0.25]).ravel()
    order = np.argsort(times)
    assert shaper["on"] == "motion of front trolley" and len(shaper["modes"]) == 2
    assert shaper["times"] == pytest.approx(times[order], rel=1e-12) and shaper["amplitudes"] == pytest.approx(
        weights[order], rel=1e-14
    )
    after = T + times.max() + np.linspace(1e-9, 5.0, 21)
    front = [place("front trolley"), place("front hook"), place("front load")]
    assert np.abs(result.motion(after)[front] - 2.0).max() < 1e-13
    assert np.abs(result.motion.derivative()(after)[front]).max() < 1e-13 < 0.1 < np.abs(swing).max()
    assert not any(notice.doubtful for notice in result.notices)


def _columns(name: str) -> np.ndarray:
    """The first two columns of a logger's file with decimal commas, read by NumPy."""
    lines = [line.replace(",", ".") for line in (EXAMPLES / "records" / name).read_text().splitlines() if line[:1].isdigit()]
    return np.loadtxt(lines, delimiter=";", usecols=(0, 1)).T


def test_the_car_meets_the_bump_with_both_axles():
    """scipy.signal.lsim, exact for inputs of linear pieces, of equations written by hand; the rear axle 2.7 m / (30 km/h) = 0.324 s later."""
    result = read_scene(EXAMPLES / "car_over_bump.toml").run()
    x, height = _columns("speed_bump.csv")
    step = 0.05 / (30 / 3.6)  # s between samples; a wheelbase is 54 of them
    t = step * np.arange(200)
    road = np.array([np.interp(t, own, height / 1000, right=0.0) for own in (x / (30 / 3.6), x / (30 / 3.6) + 54 * step)]).T
    m, J, a, b = 1200.0, 1500.0, 1.2, 1.5  # body, and its centre behind the front and before the rear axle
    springs, dampers, tyre = np.array([30e3, 35e3]), np.array([2400.0, 2800.0]), 380e3
    ends = np.array([[1, a, -1, 0], [1, -b, 0, -1]])  # elongations by body, angle (front up), front and rear wheel
    K = ends.T @ np.diag(springs) @ ends + np.diag([0, 0, tyre, tyre])
    C, M = ends.T @ np.diag(dampers) @ ends, np.diag([m, J, 80.0, 70.0])
    A = np.block([[np.zeros((4, 4)), np.eye(4)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    B = np.vstack([np.zeros((6, 2)), np.diag([tyre / 80, tyre / 70])])
    y = lsim((A, B, np.eye(8)[:4], np.zeros((4, 2))), road, t)[1]
    names = result.scene.equations.coordinates.names
    found = result.motion.displacement(t)
    for name, expected in zip(("body", "front wheel", "rear wheel"), y[:, [0, 2, 3]].T):
        assert found[names.index(name)] == pytest.approx(expected, abs=1e-12)
    assert np.abs(y[:, 3]).max() > 0.03 and np.abs(y[:54, 3]).max() < 0.01  # the rear wheel waits for its bump


def test_the_bridge_on_two_piers_stretches_as_the_wave_passes():
    """scipy.signal.lsim with both grounds as double integrators of their accelerations, the later one by 120 m / (400 m/s) = 15 samples."""
    scene = read_scene(EXAMPLES / "bridge_in_earthquake.toml")
    result = scene.run()
    times, g = _columns("ground_logger.csv")
    a = 9.80665 * g
    a = a - np.sum((a[1:] + a[:-1]) / 2 * np.diff(times)) / times[-1]  # the mean of the linear pieces
    t = 0.02 * np.arange(801)
    ground = np.zeros((801, 2))
    ground[: len(a), 0], ground[15 : len(a) + 15, 1] = a, a
    k, c, girder, M = np.array([60e6, 40e6]), np.array([700e3, 500e3]), 90e6, np.array([900e3, 700e3])
    K, C = np.diag(k) + girder * np.array([[1, -1], [-1, 1]]), np.diag(c)
    Z, E = np.zeros((2, 2)), np.eye(2)
    top = np.hstack([-K / M[:, None], -C / M[:, None], np.diag(k / M), np.diag(c / M)])
    A = np.vstack([np.hstack([Z, E, Z, Z]), top, np.hstack([Z, Z, Z, E]), np.zeros((2, 8))])
    y = lsim((A, np.vstack([np.zeros((6, 2)), E]), np.eye(8), np.zeros((8, 2))), ground, t)[1]
    within = t < times[-1] - 0.01  # samples beyond the last one of the record are a ramp to zero in lsim
    names = scene.equations.coordinates.names
    found = result.motion.displacement(t[within])
    size = np.abs(y[within]).max()
    for name, expected in (("west deck", y[within, 0]), ("east deck", y[within, 1]), ("east ground", y[within, 5])):
        assert found[names.index(name)] == pytest.approx(expected, abs=2e-8 * size)  # lsim's errors grow with its integrators
    (notice,) = (one for one in result.notices if one.kind == "record")
    assert (
        "a constant baseline of at most 0.118 m/s^2" in notice.text and "displacement 8.47 m, now " in notice.text
    )  # 0.012 g (12 s)^2 / 2
    stretch = result.motion.peaks(
        12.0, "displacement", [[-1.0 if n == "west deck" else 1.0 if n == "east deck" else 0.0 for n in names]]
    )
    together = read_scene(EXAMPLES / "bridge_in_earthquake.toml", {"span": "0 m"}).run().motion
    same = together.peaks(12.0, "displacement", [[-1.0 if n == "west deck" else 1.0 if n == "east deck" else 0.0 for n in names]])
    assert stretch.largest[0] > 2 * same.largest[0]  # the wave loads the girder more than an earthquake of both grounds at once
