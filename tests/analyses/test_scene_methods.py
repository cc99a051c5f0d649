"""Every analysis is a method of a scene, and every answer has the same forms of data and files."""

import inspect
import json

import pytest

import mbconstrained as mb
from mbconstrained.analyses import ANALYSES, load
from mbconstrained.scene.run.scene import METHOD_NAMES

DAMPER = "examples/tuned_mass_damper.toml"


@pytest.fixture(scope="module")
def scene():
    return mb.read_scene(DAMPER)


@pytest.mark.parametrize("name", ANALYSES)
def test_every_analysis_is_a_method_with_its_settings(name):
    method = getattr(mb.Scene, METHOD_NAMES.get(name, name))
    assert inspect.isfunction(method) and inspect.getdoc(method)
    if name not in ("run", "sweep", "optimise") and (settings := load(name).settings):
        named = {one.rstrip("_") for one in inspect.signature(method).parameters} - {"self"}
        assert named == {field.alias or key for key, field in settings.model_fields.items()}
        assert all(f"    {one}" in method.__doc__ for one in named)


def test_the_answer_is_that_of_the_command(scene):
    given = scene.frequency(from_="0.5 Hz", to=4.0).to_xarray().frequency
    assert float(given.min()) == pytest.approx(0.5) and float(given.max()) == pytest.approx(4.0)
    assert given.attrs["units"] == "Hz"
    with pytest.raises(mb.SceneError, match="unknown key"):
        scene.frequency(until=4.0)


@pytest.mark.parametrize(
    "ask",
    [lambda scene: scene.modes(), lambda scene: scene.frequency(), lambda scene: scene.run(), lambda scene: scene.sensitivity(), lambda scene: scene.mac(other=DAMPER)],
    ids=["modes", "frequency", "run", "sensitivity", "mac"],
)  # fmt: skip
def test_every_answer_has_all_forms(scene, ask, tmp_path):
    answer = ask(scene)
    assert isinstance(answer, mb.Answer)
    json.dumps(answer.to_dict(), allow_nan=False)
    assert answer.to_xarray().attrs
    assert "<table>" in answer._repr_html_()
    assert {path.suffix for path in answer.write(tmp_path, "json")} == {".json"}
    with pytest.raises(mb.InputError, match='did you mean "csv"'):
        answer.write(tmp_path, ["cvs"])


def test_runs_are_compared_without_files(scene):
    other = mb.read_scene(DAMPER, {"zeta": 0.2})
    assert set(scene.compare(others=[other]).to_dict()["runs"]) == {"tuned_mass_damper", "tuned_mass_damper.zeta=0.2"}
