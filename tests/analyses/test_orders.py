"""Excitation by orders of a speed: against matrices written by hand, sums of cosines sampled densely, and closed forms of one mass."""

import numpy as np
import pytest

from mbconstrained import read_scene
from mbconstrained.ground.errors import SceneError
from mbconstrained.mechanics.harmonic_sums import common_rate, largest_modulus, root_mean_square

RPM = np.pi / 30

ONE = """
[parameters]
zeta = 0.05
[model]
kind = "lumped"
[[model.mass]]
name = "machine"
mass = "100 kg"
[[model.spring]]
name = "mount"
between = ["ground", "machine"]
stiffness = "=100*(2*pi*10)^2"
[[model.damper]]
name = "oil"
between = ["ground", "machine"]
damping = "=2*zeta*100*2*pi*10"
[time]
end = 1
[orders]
from = "60 rpm"
to = "1800 rpm"
[[orders.excitation]]
on = "machine"
order = 1
unbalance = "50 kg*mm"
"""

FREE = """
[model]
kind = "lumped"
[[model.inertia]]
name = "engine"
inertia = 1
[[model.inertia]]
name = "load"
inertia = 3
[[model.torsion_spring]]
name = "shaft"
between = ["engine", "load"]
stiffness = 300
[time]
end = 1
[orders]
from = 0
to = 15
points = 31
quantity = "force"
[[orders.excitation]]
on = "engine"
order = 1
amplitude = 4
"""


@pytest.fixture
def orders(tmp_path):
    """The answer to a scene of a text."""

    def answer(text, **given):
        (tmp_path / "scene.toml").write_text(text, encoding="utf-8")
        return read_scene(tmp_path / "scene.toml").orders(**given)

    return answer


def test_unbalance_on_one_mass_has_its_textbook_magnification(orders):
    """x = (u / m) r^2 / sqrt((1 - r^2)^2 + (2 zeta r)^2), largest at r = 1 / sqrt(1 - 2 zeta^2): u / m / (2 zeta sqrt(1 - zeta^2))."""
    answer, zeta = orders(ONE), 0.05
    arrays = answer.arrays()
    r = arrays["speeds"] / (2 * np.pi * 10)
    expected = 5e-4 * r**2 / (1 - r**2 + 2j * zeta * r)
    np.testing.assert_allclose(arrays["amplitudes"][0, 0], expected, rtol=1e-11)
    np.testing.assert_allclose(arrays["rms"][0], np.abs(expected) / np.sqrt(2), rtol=1e-11)
    (top,) = answer.data["largest"]
    assert top["value"] == pytest.approx(5e-4 / (2 * zeta * np.sqrt(1 - zeta**2)), rel=1e-12)
    assert top["speed"] == pytest.approx(2 * np.pi * 10 / np.sqrt(1 - 2 * zeta**2), rel=1e-5)
    (point,) = answer.data["resonances"]
    assert point["speed"] == pytest.approx(2 * np.pi * 10 * np.sqrt(1 - zeta**2), rel=1e-13)


def test_the_force_that_a_mount_passes_on_and_the_law_of_the_speed(orders):
    """F = k x, and an amplitude at a speed with the law speed^2 is an unbalance amplitude / speed^2."""
    mount = orders(ONE, quantity="force", outputs=["mount"]).arrays()
    k = 100 * (2 * np.pi * 10) ** 2
    np.testing.assert_allclose(mount["amplitudes"][0], k * orders(ONE).arrays()["amplitudes"][0], rtol=1e-10)
    at_speed = f'amplitude = {0.05 * 100.0**2!r}\nlaw = "speed^2"\nat = 100'
    other = orders(ONE.replace('unbalance = "50 kg*mm"', at_speed)).arrays()
    np.testing.assert_allclose(other["amplitudes"], orders(ONE).arrays()["amplitudes"], rtol=1e-13)


def test_a_free_driveline_has_torques_down_to_rest_and_no_bound_at_its_resonance(orders):
    """The shaft accelerates the load, 4 * 3 / (1 + 3) at rest; resonance at sqrt(300 (1 + 1/3)) = 20 rad/s lies above, then within."""
    answer = orders(FREE)
    assert np.abs(answer.arrays()["amplitudes"][0, 0, 0]) == pytest.approx(3.0, rel=1e-12)
    assert not any("without end" in notice.text for notice in answer.notices)
    beyond = orders(FREE, to=30, points=31)
    assert (
        beyond.tables[0].rows[0][1] == "unbounded" and np.isinf(beyond.arrays()["amplitudes"]).any()
    )  # 20 rad/s is one of the speeds
    assert [one["speed"] for one in beyond.data["resonances"]] == pytest.approx([20.0])
    assert any("no steady state at a resonance" in notice.text for notice in beyond.notices)
    angles = orders(FREE, quantity="displacement", outputs=["load"])
    assert angles.tables[0].rows[0][1:3] == ("unbounded", "0") and any("without end" in one.text for one in angles.notices)


def test_the_unbalance_of_a_rotor_is_an_excitation_of_order_one():
    scene = read_scene("examples/rotor.toml")
    arrays = scene.orders(to="4000 rpm", points=9, outputs=["A y", "B z"]).arrays()
    rotor = scene.equations.rotor
    response = rotor.unbalance_response(np.maximum(arrays["speeds"], 1e-9))
    places = [rotor.names.index(name) for name in ("A y", "B z")]
    np.testing.assert_allclose(arrays["amplitudes"][0, :, 1:], response.values[1:, places].T, rtol=1e-9)


def test_sums_of_harmonics():
    generator, rates = np.random.default_rng(3), np.array([0.0, 0.5, 1.5, 2.0, 7.0])
    c = generator.normal(size=(5, 40)) + 1j * generator.normal(size=(5, 40))
    c[0] = c[0].real
    t = np.linspace(0, 4 * np.pi, 40001)
    values = np.einsum("lk,lt->kt", c, np.exp(1j * np.outer(rates, t))).real
    found = largest_modulus(rates, c)
    assert (found >= np.abs(values).max(axis=1)).all()
    np.testing.assert_allclose(found, np.abs(values).max(axis=1), rtol=1e-6)
    np.testing.assert_allclose(root_mean_square(rates, c), np.sqrt(np.mean(values[:, :-1] ** 2, axis=1)), rtol=1e-10)
    assert common_rate([41 / 17, 1.0]) == pytest.approx(1 / 17) and common_rate([1.0, np.pi]) is None


@pytest.mark.parametrize(
    "old, new, message",
    [
        ('on = "machine"', 'on = "machin"', 'did you mean "machine"'),
        ("order = 1", "order = -1", "expected orders of at least 0"),
        ("order = 1", "order = nan", "expected a finite number"),
        ("order = 1", "order = 0", "found 0 alone"),
        ("order = 1", "order = [1, 2]", "found 2 in order and 1 in unbalance"),
        ('unbalance = "50 kg*mm"', "", "give either amplitude or unbalance"),
        ('unbalance = "50 kg*mm"', 'amplitude = "5 N*m"', "expected a force"),
        ('unbalance = "50 kg*mm"', 'amplitude = 5\nlaw = "speed^2"', "belong together"),
        ('from = "60 rpm"', 'from = "-60 rpm"', "expected at least 0"),
        ('from = "60 rpm"', 'from = "6000 rpm"', "expected a range that ascends"),
        (ONE[ONE.index("[[orders") :], "", "there is no excitation"),
    ],
)
def test_wrong_orders_are_named(orders, old, new, message):
    with pytest.raises(SceneError, match=message):
        orders(ONE.replace(old, new))


def test_page_files_and_interference_diagram(command, tmp_path):
    """Lines of the orders, constant frequencies, and a critical speed of each pair."""
    (tmp_path / "one.toml").write_text(
        ONE.replace("order = 1\nunbalance", "order = [1, 2]\nphase = 0\nunbalance"), encoding="utf-8"
    )
    text = (tmp_path / "one.toml").read_text().replace('"50 kg*mm"', '["50 kg*mm", "10 kg*mm"]')
    (tmp_path / "one.toml").write_text(text)
    code, output, _ = command("orders", "one.toml", "--out", "out")
    assert code == 0 and "Resonances" in output
    page = (tmp_path / "out" / "one.orders.html").read_text(encoding="utf-8")
    assert all(title in page for title in ("Interference diagram", "Run-up of machine", "machine by order"))
    head = (tmp_path / "out" / "one.orders.csv").read_text().splitlines()[0]
    assert head.startswith("speed (rev/min),largest machine (m),RMS machine (m),order 1 machine (m)")
    code, output, _ = command("campbell", "one.toml", "--out", "out")
    rows = [line.split()[:2] for line in output.splitlines() if line.split()[:1] in (["1"], ["2"])]
    damped = 600 * np.sqrt(1 - 0.05**2)
    assert code == 0 and rows[:2] == [["1", f"{damped:.6g}"], ["2", f"{damped / 2:.6g}"]]


def test_outputs_have_the_names_of_all_analyses(orders):
    """Force on the ground k x + c x', velocity i n W x and a stress F / A, each of its own quantity, in plots of their own."""
    stress = '[output]\nquantity = [{ name = "stress", of = "mount", divided_by = "20 mm^2" }]\n'
    answer = orders(ONE + stress, outputs=["machine", "velocity of machine", "force on ground", "stress"])
    arrays = answer.arrays()
    x, velocity, force, sigma = arrays["amplitudes"][0]
    w, k, c = 1j * arrays["speeds"], 100 * (2 * np.pi * 10) ** 2, 2 * 0.05 * 100 * 2 * np.pi * 10
    np.testing.assert_allclose(velocity, w * x, rtol=1e-12)
    np.testing.assert_allclose(force, (k + c * w) * x, rtol=1e-10)
    np.testing.assert_allclose(sigma, k * x / 20e-6, rtol=1e-10)
    assert arrays["units"].tolist() == ["m", "m/s", "N", "Pa"] and answer.data["quantities"][1:] == ["velocity", "force", "stress"]
    titles = [plot.title for plot in answer.plots()]
    assert titles[:4] == [f"{one}, largest over a cycle" for one in ("displacement", "velocity", "force", "stress")]


SUPPORT = ONE.replace('between = ["ground"', 'between = ["floor"').replace(
    "[[model.spring]]", '[[model.node]]\nname = "floor"\n[[model.spring]]', 1
)
MOVED = (
    SUPPORT[: SUPPORT.index("[[orders.excitation]]")]
    + """
[[orders.excitation]]
on = "floor"
order = [0, 2]
amplitude = ["1 mm", "0.2 mm"]
[[motion]]
coordinate = "floor"
"""
)


def test_a_support_that_moves_by_orders(orders):
    """Transmissibility (k + c s) / (k + c s + m s^2) at s = 2 i W, and the mean as given; a unit of force is refused there."""
    arrays = orders(MOVED, outputs=["machine", "machine - floor"]).arrays()
    s, k, c = 2j * arrays["speeds"], 100 * (2 * np.pi * 10) ** 2, 2 * 0.05 * 100 * 2 * np.pi * 10
    T = (k + c * s) / (k + c * s + 100 * s**2)
    np.testing.assert_allclose(arrays["amplitudes"][1], [2e-4 * T, 2e-4 * (T - 1)], rtol=1e-9)
    np.testing.assert_allclose(arrays["amplitudes"][0, 0], 1e-3, rtol=1e-12)
    with pytest.raises(SceneError, match="expected a length"):
        orders(MOVED.replace('"1 mm", "0.2 mm"', '"1 N", "2 N"'))
    with pytest.raises(SceneError, match="a prescribed motion; give amplitude"):
        orders(MOVED.replace("amplitude = [", "unbalance = ["))


def test_a_rotor_whose_shaft_damps_has_its_mean_at_each_speed(tmp_path):
    """(K + W N) x = f under the order 0: internal damping c_i turns a static deflection, N = c_i [[0, 1], [-1, 0]]."""
    text = """
[model]
kind = "matrices"
coordinates = ["y", "z"]
mass = [[2, 0], [0, 2]]
damping = [[30, 0], [0, 30]]
stiffness = [[2e4, 0], [0, 2e4]]
circulatory = [[0, 5], [-5, 0]]
[time]
end = 1
[orders]
from = 0
to = "3000 rpm"
points = 5
[[orders.excitation]]
on = "y"
order = [0, 1]
amplitude = [10, 0]
"""
    (tmp_path / "shaft.toml").write_text(text, encoding="utf-8")
    arrays = read_scene(tmp_path / "shaft.toml").orders().arrays()
    W = arrays["speeds"]
    expected = np.array([np.linalg.solve([[2e4, 5 * one], [-5 * one, 2e4]], [10.0, 0.0]) for one in W]).T
    np.testing.assert_allclose(arrays["amplitudes"][0], expected, rtol=1e-10, atol=1e-16)
    with pytest.raises(SceneError, match="no springs and dampers with names"):
        read_scene(tmp_path / "shaft.toml").orders(quantity="force")
