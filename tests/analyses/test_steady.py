"""The steady state of scenes: against closed forms of one mass, SciPy's lsim over many periods, and unbalance responses of a rotor."""

from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lsim

from mbconstrained import read_scene
from mbconstrained.ground.errors import SceneError

EXAMPLES = Path(__file__).parents[2] / "examples"

DAMPER = """[[model.damper]]
name = "oil"
between = ["ground", "machine"]
damping = 4
"""
ONE = (
    """
[model]
kind = "lumped"
[[model.mass]]
name = "machine"
mass = 2
[[model.spring]]
name = "mount"
between = ["ground", "machine"]
stiffness = 800
"""
    + DAMPER
    + """[[force]]
coordinate = "machine"
kind = "harmonic"
value = 6
angular_frequency = 30
phase = "20 deg"
[time]
end = 1
"""
)
UNDAMPED = ONE.replace(DAMPER, "")
CONSTANT = """
[[force]]
coordinate = "machine"
kind = "step"
value = 8
"""
SECOND = """
[[force]]
coordinate = "machine"
kind = "harmonic"
value = 5
angular_frequency = %s
"""
SQUARE = """
[[force]]
coordinate = "machine"
kind = "sampled"
times = [0, 0.1, 0.1000000001, 0.3]
values = [3, 3, 0, 0]
"""


@pytest.fixture
def steady(tmp_path):
    """The answer to a scene of a text."""

    def answer(text, **given):
        (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
        return read_scene(tmp_path / "scene.toml").steady(**given)

    return answer


def compliance(w):
    return 1 / (800 - 2 * w**2 + 4j * w)


def test_a_harmonic_and_a_constant_force(steady):
    """x = 8 / k + Re(H F e^(i w t)); the ground takes k x + c x', the mount k x."""
    answer = steady(ONE + CONSTANT, outputs=["machine", "velocity of machine", "mount", "force on ground"])
    x = compliance(30) * 6 * np.exp(1j * np.radians(20))
    arrays = answer.arrays()
    np.testing.assert_allclose(arrays["frequencies_hz"], [0, 30 / (2 * np.pi)], rtol=1e-14)
    expected = [[0.01, x], [0, 30j * x], [8, 800 * x], [8, (800 + 120j) * x]]
    np.testing.assert_allclose(arrays["amplitudes"], expected, rtol=1e-12, atol=1e-15)
    assert answer.data["period"] == pytest.approx(2 * np.pi / 30, rel=1e-14)
    for entry, (mean, c) in zip(answer.data["values"], expected):
        size, middle = abs(c), complex(mean).real
        assert [entry["smallest"], entry["largest"]] == pytest.approx([middle - size, middle + size], rel=1e-9)
        assert entry["rms"] == pytest.approx(np.sqrt(middle**2 + size**2 / 2), rel=1e-10)
    time = arrays["times"]
    np.testing.assert_allclose(arrays["values"][0], 0.01 + (x * np.exp(30j * time)).real, rtol=1e-11)
    assert answer.is_trusted and arrays["units"].tolist() == ["m", "m/s", "N", "N"]


def test_a_rest_length_is_part_of_the_mean_force(steady):
    """A spring of rest length 0.5 m, stretched by 8 N: x = 0.5 + 8 / k, force 8 N; nothing moves it otherwise."""
    text = (ONE + CONSTANT).replace("stiffness = 800", "stiffness = 800\nrest_length = 0.5")
    answer = steady(text, outputs=["machine", "mount", "elongation of mount"])
    assert answer.arrays()["amplitudes"][:, 0].real == pytest.approx([0.51, 8, 0.01], rel=1e-11)


def test_a_structural_loss_factor_and_two_frequencies(steady):
    """(k (1 + i eta) - m w^2) x = F; the cycle of 30 and 45 rad/s is that of 15 rad/s."""
    text = UNDAMPED.replace("stiffness = 800", "stiffness = 800\nloss_factor = 0.2")
    arrays = steady(text + SECOND % 45, outputs=["machine", "mount"]).arrays()
    w, F = np.array([30, 45]), np.array([6 * np.exp(1j * np.radians(20)), 5])
    x = F / (800 * (1 + 0.2j) - 2 * w**2)
    np.testing.assert_allclose(arrays["amplitudes"], [x, 800 * (1 + 0.2j) * x], rtol=1e-12)
    assert arrays["times"][-1] == pytest.approx(2 * np.pi / 15)
    values = (x[:, None] * np.exp(1j * np.outer(w, arrays["times"]))).sum(axis=0).real
    np.testing.assert_allclose(arrays["values"][0], values, atol=1e-12 * abs(values).max())
    apart = steady(ONE + SECOND % 44.721359549995796)
    assert apart.data["period"] is None and any("no common period" in one.text for one in apart.notices)


def test_a_record_that_repeats(steady):
    """After 60 periods the motion that SciPy computes from rest is that of the answer."""
    text = ONE[: ONE.index("[[force]]")] + "[time]\nend = 1\n" + SQUARE
    answer = steady(text, period="0.3 s", outputs=["machine", "mount"])
    arrays = answer.arrays()
    time = np.linspace(0, 18.0, 60 * 3000 + 1)
    force = np.where(np.mod(np.arange(len(time)), 3000) < 1000, 3.0, 0.0)
    expected = lsim(([1.0], [2.0, 4.0, 800.0]), force, time, interp=False)[1][-3001:]
    np.testing.assert_allclose(np.interp(time[:3001], arrays["times"], arrays["values"][0]), expected, atol=2e-4 * expected.max())
    assert answer.data["values"][1]["largest"] == pytest.approx(800 * expected.max(), rel=1e-4)
    assert np.abs(arrays["amplitudes"][0, 0] - 1.0 / 800) < 1e-9  # a third of 3 N


def test_the_orbit_of_a_rotor_is_its_unbalance_response():
    scene = read_scene(EXAMPLES / "rotor.toml")
    answer, rotor = scene.steady(outputs=["A y", "A z"]), scene.equations.rotor
    speed = 1000 * np.pi / 30
    expected = rotor.unbalance_response([speed, 2 * speed]).values[0]
    places = [rotor.names.index(name) for name in ("A y", "A z")]
    np.testing.assert_allclose(answer.arrays()["amplitudes"][:, 0], expected[places], rtol=1e-10)
    assert [plot.title for plot in answer.plots()] == ["displacement", "orbit of A"]


def test_the_limit_cycle_of_a_block_that_sticks_and_slips(command, tmp_path):
    """It sticks for 2 D / v and slips for 2 (pi - atan(D w / v)) / w, D the difference of both friction forces by the stiffness."""
    answer = read_scene(EXAMPLES / "stick_slip.toml").steady(outputs=["block", "velocity of block"])
    k, v, kinetic, static = 4.0, 0.1, 3.0, 4.0  # of a block of 1 kg
    w, D = np.sqrt(k), (static - kinetic) / k
    block, velocity = answer.data["values"]
    assert answer.data["period"] == pytest.approx(2 * D / v + 2 * (np.pi - np.arctan(D * w / v)) / w, rel=1e-12)
    size = np.hypot(D, v / w)
    assert [block["smallest"], block["largest"]] == pytest.approx([kinetic / k - size, kinetic / k + size], rel=1e-12)
    assert velocity["smallest"] == pytest.approx(-w * size, rel=1e-12)
    assert len(answer.data["events"]) == 2 and answer.data["is_stable"] and answer.is_trusted
    code, output, _ = command("steady", str(EXAMPLES / "stick_slip.toml"), "--out", str(tmp_path))
    assert code == 0 and "Floquet multipliers" in output
    page = (tmp_path / "stick_slip.steady.html").read_text(encoding="utf-8")
    assert "phase plane of block" in page


@pytest.mark.parametrize(
    "change, given, message",
    [
        (
            ('kind = "harmonic"\nvalue = 6\nangular_frequency = 30\nphase = "20 deg"', 'kind = "pulse"\nvalue = 6\nduration = 0.5'),
            {},
            "kind pulse",
        ),
        (
            ('kind = "harmonic"\nvalue = 6\nangular_frequency = 30\nphase = "20 deg"', 'kind = "step"\nvalue = 6'),
            {},
            "varies with the time",
        ),
        (("", ""), {"period": "3 m"}, "expected a time"),
        (("", ""), {"period": -1}, "more than 0"),
        (("", ""), {"outputs": ["machin"]}, 'did you mean "machine"'),
        (("", ""), {"quantity": "reaction"}, "there are none"),
        (("[time]", SQUARE + "[time]"), {}, "is a record; give the time after which it repeats"),
        (("[time]", SQUARE + "[time]"), {"period": 0.2}, "the samples of a record reach"),
    ],
)
def test_what_has_no_steady_state_is_named(steady, change, given, message):
    with pytest.raises(SceneError, match=message):
        steady(ONE.replace(*change), **given)


def test_an_undamped_resonance_that_is_hit_exactly_is_reported(steady):
    text = UNDAMPED.replace("angular_frequency = 30", "angular_frequency = 20")
    with pytest.raises(SceneError, match="no steady state without damping"):
        steady(text)
    beside = steady(UNDAMPED)
    assert beside.is_trusted and any("an undamped free motion remains" in one.text for one in beside.notices)
    assert abs(beside.arrays()["amplitudes"][0, 0]) == pytest.approx(6 / (2 * 30**2 - 800), rel=1e-12)
    matrices = '[model]\nkind = "matrices"\nmass = [[2]]\ndamping = [[-4]]\nstiffness = [[800]]\ncoordinates = ["machine"]\n'
    growing = steady(matrices + ONE[ONE.index("[[force]]") :])
    assert not growing.is_trusted and any("a free motion grows" in one.text for one in growing.notices)
