"""Unbalance response: the Jeffcott rotor in closed form, rotors on their resonances, other orders, speed tables."""

import numpy as np
import pytest

import mbconstrained as mb

MASS, STIFFNESS, ECCENTRICITY = 2.0, 800.0, 1e-3
NATURAL = 20.0


def jeffcott(damping_ratio, stiffness=STIFFNESS, **more):
    """A mass in the middle of an elastic shaft."""
    model = mb.LumpedModel()
    model.rotor("disc", MASS, **more)
    model.bearing("ground", "disc", stiffness, damping=2 * damping_ratio * MASS * NATURAL)
    model.unbalance("disc", MASS * ECCENTRICITY, angle=0.4)
    return model.assemble()


@pytest.mark.parametrize("zeta", [0.01, 0.1, 0.5])
def test_the_jeffcott_rotor(zeta):
    """x = e r^2 / (1 - r^2 + 2 i zeta r), its largest at r = 1 / sqrt(1 - 2 zeta^2) (Genta 2005, section 2.4)."""
    speeds = np.linspace(0.0, 80.0, 9)
    response = jeffcott(zeta).unbalance_response(speeds)
    r = speeds / NATURAL
    expected = ECCENTRICITY * r**2 / (1 - r**2 + 2j * zeta * r) * np.exp(0.4j)
    np.testing.assert_allclose(response.values, np.outer(expected, [1.0, -1j]), rtol=1e-12)
    assert [peak.coordinate for peak in response.peaks] == ["disc y", "disc z"]
    for peak in response.peaks:
        np.testing.assert_allclose(peak.speed, NATURAL / np.sqrt(1 - 2 * zeta**2), rtol=1e-7)
        np.testing.assert_allclose(peak.amplitude, ECCENTRICITY / (2 * zeta * np.sqrt(1 - zeta**2)), rtol=1e-12)


def test_a_narrow_peak_between_distant_speeds():
    """zeta = 1e-5, ten speeds: the search begins near the critical speeds."""
    (peak, _) = jeffcott(1e-5).unbalance_response(np.linspace(1.0, 100.0, 10)).peaks
    np.testing.assert_allclose(peak.amplitude, ECCENTRICITY / 2e-5, rtol=1e-8)


def test_an_undamped_resonance_has_no_bound():
    response = jeffcott(0.0, [STIFFNESS, 1.44 * STIFFNESS]).unbalance_response([5.0, NATURAL, 50.0])
    assert [(peak.coordinate, peak.amplitude) for peak in response.peaks] == [("disc y", np.inf), ("disc z", np.inf)]
    np.testing.assert_allclose([peak.speed for peak in response.peaks], [NATURAL, 1.2 * NATURAL], rtol=1e-9)


def test_unbalance_on_equal_springs_excites_no_backward_whirl():
    """The couple of unbalances at both ends of a rotor excites its tilts forwards: one peak of each, at the forward critical speed."""
    model, d = mb.LumpedModel(), 0.3
    model.rotor("disc", 5.0, diametral_inertia=0.2, polar_inertia=0.1, points={"a": -d, "b": d})
    for point, angle in (("a", 0.0), ("b", np.pi)):
        model.bearing("ground", point, 1e4, damping=0.2)
        model.unbalance(point, 1e-4, angle=angle)
    rotor = model.assemble()
    backward, forward = (np.sqrt(2e4 * d * d / (0.2 + sign * 0.1)) for sign in (1, -1))
    peaks = [one for one in rotor.unbalance_response(np.linspace(1.0, 200.0, 30)).peaks if "angle" in one.coordinate]
    np.testing.assert_allclose([peak.speed for peak in peaks], [forward] * 2, rtol=1e-4)
    assert min(abs(point - backward) for point in rotor.critical_speeds()) < 1e-3 * backward


def test_other_orders_and_other_unbalance():
    """W^2 u e^{2 i W t} is the frequency response at 2 W times W^2 u."""
    rotor = jeffcott(0.05, diametral_inertia=0.1, polar_inertia=0.15)
    rotor = rotor.with_constraints(mb.Constraint([0.0, 1.0, -1.0, 0.0]))
    given = {"disc y": 1e-3, "disc z": 2e-3j}
    speeds = np.array([3.0, 8.0])
    response = rotor.unbalance_response(speeds, given, order=2.0)
    for W, values in zip(speeds, response.values):
        H = rotor.at_speed(W).frequency_response(frequencies_hz=[2 * W / (2 * np.pi)], inputs=list(given), outputs=rotor.names)
        np.testing.assert_allclose(values, H.values[:, :, 0] @ (W**2 * np.array(list(given.values()))), rtol=1e-9)


def test_bearings_of_the_speed():
    model = mb.LumpedModel()
    model.rotor("disc", 1.0)
    model.bearing("ground", "disc", speeds=[0.0, 50.0], stiffness=[100.0, 5100.0], damping=[1.0, 3.0])
    model.unbalance("disc", 1.0)
    W = 20.0
    values = model.assemble().unbalance_response([0.0, W, 50.0]).values[1]
    np.testing.assert_allclose(values[0], W**2 / (2100.0 + 1j * W * 1.8 - W**2), rtol=1e-13)


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda rotor: rotor.unbalance_response([1.0]), "two or more"),
        (lambda rotor: rotor.unbalance_response([-1.0, 1.0]), "at least 0"),
        (lambda rotor: rotor.unbalance_response([1.0, np.nan]), "finite"),
        (lambda rotor: rotor.unbalance_response([1.0, 2.0], {"disk y": 1.0}), 'did you mean "disc y"'),
        (lambda rotor: rotor.unbalance_response([1.0, 2.0], [1.0]), "unbalance"),
        (lambda rotor: rotor.unbalance_response([1.0, 2.0], order=0), "order"),
        (lambda rotor: mb.MechanicalSystem(np.eye(2), gyroscopic=np.zeros((2, 2))).unbalance_response([1.0, 2.0]), "has none"),
        (lambda rotor: mb.MechanicalSystem(np.eye(2)).unbalance_response([1.0, 2.0]), "does not depend on a speed"),
    ],
)
def test_what_is_wrong_is_named(call, message):
    with pytest.raises(mb.InputError, match=message):
        call(jeffcott(0.1))


def test_a_free_rotor_has_no_position_at_rest():
    free = mb.MechanicalSystem(np.eye(2), gyroscopic=np.zeros((2, 2)))
    with pytest.raises(mb.InputError, match="free rotor"):
        free.unbalance_response([0.0, 1.0], [1.0, -1j])
    np.testing.assert_allclose(free.unbalance_response([1.0, 2.0], [1.0, -1j]).values, [[-1.0, 1j]] * 2, rtol=1e-14)
