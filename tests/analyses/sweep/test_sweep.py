"""Studies of a scene: each sample is what a single run of the scene gives, whoever computes it."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.sweep.sweep import MOST_VARIANTS
from tests.scene.scenes import EXAMPLES

SCENE = """
title = "Two masses"
[parameters]
k = "2 N/mm"
m = "10 kg"
unused = "1 s"
[model]
kind = "lumped"
[[model.mass]]
name = "cart"
mass = "=m"
[[model.mass]]
name = "load"
mass = "2 kg"
[[model.spring]]
between = ["ground", "cart"]
stiffness = "=k"
[[model.spring]]
between = ["cart", "load"]
stiffness = "500 N/m"
[[model.damper]]
between = ["cart", "load"]
damping = "3 N s/m"
[initial]
displacement = { cart = "1 cm" }
[time]
end = "5 s"
"""


@pytest.fixture
def path(tmp_path):
    file = tmp_path / "scene.toml"
    file.write_text(SCENE)
    return file


KEPT = ["frequencies", "load at 2 s", "peak load"]


def test_each_sample_is_a_run_of_its_own(path):
    result = mb.read_scene(path).sweep({"k": "1..3 N/mm:3", "m": [8.0, 10.0]}, keep=KEPT).run()
    assert len(result) == 6 and result.answered.all()
    for number, (k, m) in enumerate(zip(result.parameter("k"), result.parameter("m"))):
        alone = mb.read_scene(path, {"k": f"{float(k)!r} N/m", "m": f"{float(m)!r} kg"})
        modes = alone.equations.system.modes()
        np.testing.assert_allclose(result.values("frequency")[number], modes.frequencies_hz, rtol=1e-12)
        motion = alone.run().motion
        assert result.values("load at 2 s")[number].item() == pytest.approx(motion.of("load")(2.0)[0], rel=1e-11)
        curve = np.abs(motion.of("load")(np.linspace(0, 5, 20001))).max()
        assert result.values("peak load")[number].item() == pytest.approx(curve, rel=1e-5)  # none is missed between the times
        assert result.values("peak load")[number].item() >= curve * (1 - 1e-12)


def test_rms_values_are_integrals_and_curves_follow_the_motion(path):
    path.write_text(SCENE.replace("5 s", "50 s") + '[[output.quantity]]\nname = "shift"\nbetween = ["cart", "load"]\n')
    keep = ["RMS load", "RMS velocity of load", "RMS quantity of shift", "curve load"]
    result = mb.read_scene(path).sweep({"k": "1..3 N/mm:3"}, keep=keep).run()
    times = result.variables[-1].labels
    assert len(times) > 401  # which are fewer than three in a period of the fastest visible motion
    nodes, weights = np.polynomial.legendre.leggauss(20)
    edges = np.linspace(0, 50, 2001)
    at = (edges[:-1, None] + np.diff(edges)[:, None] * (nodes + 1) / 2).ravel()
    for number, k in enumerate(result.parameter("k")):
        motion = mb.read_scene(path, {"k": f"{float(k)!r} N/m"}).run().motion
        own = [motion.of("load")(at)[0], motion.of("load").derivative(1)(at)[0], (motion.of("load")(at) - motion.of("cart")(at))[0]]
        for name, values in zip(keep, own):
            right = np.sqrt(np.tile(weights, 2000) @ values**2 / 4000)
            assert result.values(name)[number].item() == pytest.approx(right, rel=1e-10)
        assert result.values("curve load")[number] == pytest.approx(motion.of("load")(np.array(times))[0], rel=1e-9, abs=1e-12)


@pytest.mark.long
def test_workers_give_the_same_bits(path, tmp_path):
    study = mb.read_scene(path).sweep({"k": "normal(2 N/mm, 5 %)"}, samples=40, keep=KEPT, chunk=8)
    alone, shared = study.run(), study.run(store=tmp_path / "k.zarr", workers=2)
    again = study.run(store=tmp_path / "k.zarr")  # read, not computed
    for name in ("frequency", "load at 2 s", "peak load"):
        assert np.array_equal(alone.values(name), shared.values(name))
        assert np.array_equal(alone.values(name), again.values(name))


def test_a_store_of_another_study_is_refused(path, tmp_path):
    scene = mb.read_scene(path)
    scene.sweep({"k": "1..3 N/mm:3"}).run(store=tmp_path / "k.zarr")
    with pytest.raises(mb.InputError, match="k"):
        scene.sweep({"k": "1..4 N/mm:3"}).run(store=tmp_path / "k.zarr")
    path.write_text(SCENE.replace("500 N/m", "600 N/m"))
    with pytest.raises(mb.InputError, match="scene"):
        mb.read_scene(path).sweep({"k": "1..3 N/mm:3"}).run(store=tmp_path / "k.zarr")


def test_samples_without_an_answer_have_their_reason(path):
    result = mb.read_scene(path).sweep({"m": [1.0, 2.0, -1.0]}).run()
    assert result.answered.tolist() == [True, True, False]
    assert "mass" in result.failures[2]
    assert np.isnan(result.values("frequency")[2]).all()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"kk": "1..3 N/mm:3"}, "k"),
        ({"unused": "1..3 s:3"}, "unused"),
        ({"k": "1..3 kg:3"}, "kg"),
        ({"k": []}, "k"),
        ({"k": "normal(2 N/mm, 0 %)"}, "k"),
    ],
)
def test_wrong_parameters_are_messages(path, parameters, message):
    with pytest.raises((mb.InputError, mb.SceneError), match=message):
        mb.read_scene(path).sweep(parameters)


@pytest.mark.long
def test_the_page_animates_samples_at_quantiles(tmp_path):
    """At most 25 variants, from the least to the largest first frequency, each named with its parameters."""
    scene = mb.read_scene(EXAMPLES / "gear_tolerances.toml")
    result = scene.sweep(samples=60).run()
    content = result.answer().page().animation
    assert content.word == "variant"
    assert len(content.modes) == MOST_VARIANTS
    values = [float(dict(variant.facts)["frequency 1"].split()[0]) for variant in content.modes]
    assert values == sorted(values)
    assert [values[0], values[-1]] == pytest.approx(
        [result.values("frequency 1").min(), result.values("frequency 1").max()], rel=1e-5
    )
    for variant, frequency in zip(content.modes, values):
        assert 1 / variant.period == pytest.approx(frequency, rel=1e-5)
    assert {name for name, _ in content.modes[0].facts} == {*result.samples.variations, "frequency 1"}
    # one sample cannot be chosen from, and coefficients have no shapes
    assert scene.sweep(samples=1).run().answer().page().animation is None


def test_a_limit_may_be_any_figure_that_can_be_kept(tmp_path):
    """The velocity of a sample of a normal stiffness: the limit keeps its own figure; "response peaks" are a figure where there is one."""
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    scene = mb.read_scene(tmp_path / "scene.toml")
    options = {"keep": ["frequencies"], "samples": 16, "limits": {"largest velocity of cart": "1 mm/s", "frequency 2": "900 Hz"}}
    result = scene.sweep({"k": "normal(2 N/mm, 5 %)"}, **options).run()
    assert result.limits == {"largest velocity of cart": 1e-3, "frequency 2": 900.0}
    assert (result.values("largest velocity of cart") > 1e-3).all()
    assert [result.exceedance(name, limit).value for name, limit in result.limits.items()] == [1.0, 0.0]
    with pytest.raises(mb.InputError, match='limits: there is no figure "largest velocity of card"'):
        scene.sweep({"k": "normal(2 N/mm, 5 %)"}, limits={"largest velocity of card": 1})
    with pytest.raises(mb.InputError, match='limits: "frequencies" is several numbers; name one of frequency 1, frequency 2'):
        scene.sweep({"k": "normal(2 N/mm, 5 %)"}, limits={"frequencies": 1})
