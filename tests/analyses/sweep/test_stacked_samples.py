"""Samples of elements' numbers in stacks against the scenes of single samples, for any chunks."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.sweep import evaluation
from tests.scene.scenes import EXAMPLES

VARIED = {
    "tuned_mass_damper": {"m": "uniform(90 kg, 110 kg)", "ratio": "uniform(0.03, 0.08)", "zeta": "uniform(0.05, 0.2)"},
    "quarter_car": {"body": "uniform(250 kg, 350 kg)", "damper": "uniform(1 kN*s/m, 2 kN*s/m)"},
    "gear_tolerances": {},
}


@pytest.mark.parametrize("name", VARIED)
def test_samples_in_stacks_are_those_of_their_scenes_in_any_chunks(name, monkeypatch):
    study = mb.read_scene(EXAMPLES / f"{name}.toml").sweep(VARIED[name], keep=["frequencies"], samples=20)
    rows = study.samples.rows(slice(0, 20))
    together = evaluation.evaluate(study.job, rows)
    parts = [evaluation.evaluate(study.job, rows[begin : begin + 7]) for begin in range(0, 20, 7)]
    monkeypatch.setattr(evaluation, "stacked_samples", lambda scene, rows: None)
    single = [evaluation.evaluate(study.job, [row]) for row in rows]
    for key in ("frequency", "damping ratio", "status"):
        expected = np.concatenate([one[key] for one in single])
        np.testing.assert_allclose(together[key], expected, rtol=1e-10, atol=1e-14)
        np.testing.assert_allclose(np.concatenate([one[key] for one in parts]), expected, rtol=1e-10, atol=1e-14)


def test_numbers_that_elements_refuse_have_the_same_reason(monkeypatch):
    study = mb.read_scene(EXAMPLES / "quarter_car.toml").sweep(VARIED["quarter_car"], keep=["frequencies"], samples=2)
    rows = [
        {"body": body, "damper": damper} for body, damper in ((300.0, 1500.0), (-1.0, 1500.0), (300.0, -1500.0), (1e-300, 1500.0))
    ]
    stacked = evaluation.evaluate(study.job, rows)
    monkeypatch.setattr(evaluation, "stacked_samples", lambda scene, rows: None)
    given = evaluation.evaluate(study.job, rows)
    assert stacked["status"].tolist() == given["status"].tolist() == [1, 2, 2, 2]
    assert stacked["reason"].tolist() == given["reason"].tolist()


@pytest.mark.parametrize(
    "table", [{}, {"from": "3 Hz", "to": "8 Hz"}, {"to": "4.5 Hz", "quantity": "accelerance", "outputs": ["machine"]}]
)
def test_largest_responses_in_stacks_are_those_of_single_scenes(table, monkeypatch, tmp_path):
    text = (EXAMPLES / "tuned_mass_damper.toml").read_text().replace('from = "3 Hz"\nto = "8 Hz"\n', "")
    own = "".join(f"{key} = {value!r}\n" for key, value in table.items())
    (tmp_path / "scene.toml").write_text(text.replace("[frequency]\n", f"[frequency]\n{own}"))
    study = mb.read_scene(tmp_path / "scene.toml").sweep(VARIED["tuned_mass_damper"], keep=["response peaks"], samples=20)
    assert study.chunk == 256
    rows = study.samples.rows(slice(0, 20))
    stacked = evaluation.evaluate(study.job, rows)
    monkeypatch.setattr(evaluation, "stacked_samples", lambda scene, rows: None)
    grouped, single = evaluation.evaluate(study.job, rows), [evaluation.evaluate(study.job, [row]) for row in rows]
    for key in ("response peak", "response peak frequency", "status"):
        expected = np.concatenate([one[key] for one in single])
        assert np.isfinite(expected).all()
        np.testing.assert_allclose(stacked[key], expected, rtol=1e-11)
        np.testing.assert_allclose(grouped[key], expected, rtol=1e-11)


def test_largest_responses_of_prescribed_motions_and_of_undamped_models_are_those_of_single_scenes(tmp_path):
    text = (EXAMPLES / "tuned_mass_damper.toml").read_text()
    damper = text[text.index("[[model.damper]]") : text.index("[[force]]")]
    (tmp_path / "undamped.toml").write_text(text.replace(damper, "").replace("\nzeta = ", "\n# "))
    undamped = mb.read_scene(tmp_path / "undamped.toml").sweep({"ratio": "0.03..0.08:4"}, keep=["response peaks"])
    driven = mb.read_scene(EXAMPLES / "quarter_car.toml").sweep(VARIED["quarter_car"], keep=["response peaks"], samples=4)
    for study, is_finite in ((undamped, False), (driven, True)):
        rows = study.samples.rows(slice(0, 4))
        together = evaluation.evaluate(study.job, rows)
        single = [evaluation.evaluate(study.job, [row]) for row in rows]
        assert np.isfinite(together["response peak"]).all() == is_finite
        for key in ("response peak", "response peak frequency", "status"):
            np.testing.assert_allclose(together[key], np.concatenate([one[key] for one in single]), rtol=1e-11)


def test_postures_of_an_arm_in_a_stack_are_those_of_single_scenes():
    study = mb.read_scene(EXAMPLES / "arm_workspace.toml").sweep()
    rows = study.samples.rows(slice(0, 6))
    together, single = evaluation.evaluate(study.job, rows), [evaluation.evaluate(study.job, [row]) for row in rows]
    for key in ("frequency", "damping ratio", "status"):
        np.testing.assert_allclose(together[key], np.concatenate([one[key] for one in single]), rtol=1e-11)
