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
    rows = [{"body": body, "damper": damper} for body, damper in ((300.0, 1500.0), (-1.0, 1500.0), (300.0, 0.0), (1e-300, 1500.0))]
    stacked = evaluation.evaluate(study.job, rows)
    monkeypatch.setattr(evaluation, "stacked_samples", lambda scene, rows: None)
    given = evaluation.evaluate(study.job, rows)
    assert stacked["status"].tolist() == given["status"].tolist() == [1, 2, 2, 2]
    assert stacked["reason"].tolist() == given["reason"].tolist()
