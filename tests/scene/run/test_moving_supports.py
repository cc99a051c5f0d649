"""Base motion by a record: relative Rayleigh damping, kinks, weights; oracles are matrices by hand and SciPy's integrator."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import mbconstrained as mb
from mbconstrained.ground.errors import InputError
from mbconstrained.ground.notices import NoticeKind
from tests.scene.scenes import scene_of

TWO = """[model]
kind = "lumped"
rayleigh_damping = {{ mass = "0.7 1/s", stiffness = "3 ms"{velocity} }}
mass = [{{ name = "a", mass = "2 kg" }}, {{ name = "b", mass = "1 kg" }}]
node = [{{ name = "left" }}, {{ name = "right" }}]
spring = [{{ between = ["left", "a"], stiffness = "90 N/m" }}, {{ between = ["a", "b"], stiffness = "50 N/m" }},
          {{ between = ["b", "right"], stiffness = "20 N/m" }}]
[[motion]]
coordinate = "left"
kind = "sampled"
times = [0, 0.5, 1.0, 3.0]
values = [0, 0.1, 0.05, 0]
[[motion]]
coordinate = "right"
kind = "{kind}"
{value}
[time]
end = "3 s"
"""
RIGHT = "times = [0, 1.25, 3.0]\nvalues = [0, -0.08, 0]"

K = np.array([[140.0, -50.0], [-50.0, 70.0]])
B = np.array([[90.0, 0.0], [0.0, 20.0]])
M = np.diag([2.0, 1.0])


def supports(t):
    left = np.interp(t, [0, 0.5, 1, 3], [0, 0.1, 0.05, 0])
    right = np.interp(t, [0, 1.25, 3], [0, -0.08, 0])
    slopes = [(0.2, -0.1, -0.025)[np.searchsorted([0.5, 1], t, side="right")], (-0.064, 0.08 / 1.75)[int(t >= 1.25)]]
    return np.array([left, right]), np.array(slopes)


def expected(relative):
    """x at 3 s: M x'' + 0.7 M (x' - T s') + 0.003 (K x' - B s') + K x = B s with T = K^-1 B, or without T."""
    T = np.linalg.solve(K, B) * relative

    def rates(t, z):
        s, ds = supports(t)
        x, v = z[:2], z[2:]
        force = B @ s - K @ x + 0.003 * (B @ ds - K @ v) - 0.7 * M @ (v - T @ ds)
        return np.concatenate([v, np.linalg.solve(M, force)])

    z = np.zeros(4)
    for start, end in ((0, 0.5), (0.5, 1.0), (1.0, 1.25), (1.25, 3.0)):
        z = solve_ivp(rates, (start, end - 1e-15), z, rtol=1e-12, atol=1e-14, method="DOP853").y[:, -1]
    return z[:2]


@pytest.mark.parametrize(("velocity", "relative"), [("", True), (", relative = true", True), (", relative = false", False)])
def test_supports_that_move_differently(tmp_path, velocity, relative):
    scene = scene_of(tmp_path, TWO.format(velocity=velocity, kind="sampled", value=RIGHT))
    result = scene.run()
    assert result.motion(3.0 - 1e-12)[:2] == pytest.approx(expected(relative), rel=1e-9)
    texts = [notice.text for notice in result.notices if notice.kind == NoticeKind.DAMPING]
    assert len(texts) == 1 and ("relative to the static response" in texts[0]) == relative


def test_other_analyses_have_the_damping_of_the_run(tmp_path):
    scene = scene_of(tmp_path, TWO.format(velocity="", kind="sampled", value=RIGHT) + "[frequency]\nfrequencies = [0.3]\n")
    w, T = 2j * np.pi * 0.3, np.linalg.solve(K, B)
    exact = np.linalg.solve(M * w**2 + (0.7 * M + 0.003 * K) * w + K, 0.7 * w * M @ T + (1 + 0.003 * w) * B)
    system = scene.equations.system
    H = system.frequency_response([0.3], [row.name for row in system.rows], ["a", "b"])
    assert H.values[:, :, 0] == pytest.approx(exact, rel=1e-10)


def test_relative_damping_resists_no_common_motion():
    system = mb.MechanicalSystem(np.diag([0.0, 3.0]), stiffness=[[4.0, -4.0], [-4.0, 4.0]])
    moved = system.with_constraints(mb.Constraint([1.0, 0.0], value=mb.ramp([1.0])))
    damped = moved.with_rayleigh_damping(0.5, 0.1, relative=True)
    assert damped.damping @ np.ones(2) == pytest.approx([0, 0], abs=1e-14)
    assert damped.damping == pytest.approx(damped.damping.T)
    assert damped.damping[1, 1] == pytest.approx(0.5 * 3 + 0.1 * 4)


def test_a_step_of_the_support_keeps_the_absolute_velocity_and_says_so(tmp_path):
    scene = scene_of(tmp_path, TWO.format(velocity="", kind="ramp", value='value = "0.1 m/s"').replace('kind = "sampled"', 'kind = "ramp"', 1)
                     .replace("times = [0, 0.5, 1.0, 3.0]\nvalues = [0, 0.1, 0.05, 0]", 'value = "0.1 m/s"'))  # fmt: skip
    assert "absolute" in next(notice.text for notice in scene.run().notices if notice.kind == NoticeKind.DAMPING)


def test_kinks_are_one_sentence_and_steps_of_the_record_stay(tmp_path):
    text = TWO.format(velocity="", kind="sampled", value=RIGHT)
    smooth = scene_of(tmp_path, text).run()
    assert [notice.kind for notice in smooth.notices if notice.kind == NoticeKind.KINK] == [NoticeKind.KINK]
    assert not [event for event in smooth.later if event.jump[0].any()]
    stepped = scene_of(tmp_path, text.replace("[0, 0.5, 1.0, 3.0]", "[0, 0.5, 0.5, 3.0]")).run()
    jumps = [notice.text for notice in stepped.notices if notice.kind == NoticeKind.JUMP]
    assert any("left: its displacement jumps at t = 0.5 s" in one for one in jumps)
    assert len([notice for notice in stepped.notices if notice.kind == NoticeKind.KINK]) == 1


@pytest.mark.parametrize("tilts", [False, True])
def test_a_rotor_sags_by_its_weight_in_one_plane(tilts):
    model = mb.LumpedModel()
    model.gravity(-9.81)
    more = {"diametral_inertia": 1.0, "polar_inertia": 0.5, "points": {"l": -1.0, "r": 1.0}} if tilts else {}
    model.rotor("disc", 20.0, **more)
    for point in ("l", "r") if tilts else ("disc",):
        model.bearing("ground", point, stiffness=4e6 / (1 + tilts))
    system = model.assemble()
    sag = dict(zip(system.names, system.static_force))
    assert sag["disc z"] == -20 * 9.81 and sag["disc y"] == 0 and sum(map(abs, sag.values())) == 20 * 9.81
    parameter = next(one for one in system.parameters() if one.name in ("disc", "disc.mass"))
    assert parameter.force[system.names.index("disc z")] == pytest.approx(-9.81)


def test_several_spectra_are_refused_with_what_to_do():
    system = mb.MechanicalSystem(np.diag([0.0, 3.0]), stiffness=[[4.0, -4.0], [-4.0, 4.0]])
    moved = system.with_constraints(mb.Constraint([1.0, 0.0], names="base"))
    with pytest.raises(InputError, match="each support by itself.*sum of squares"):
        moved.modal_combination({"base": lambda f: 1.0})
