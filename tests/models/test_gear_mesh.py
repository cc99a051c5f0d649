"""The elastic mesh of two gears, against hand-derived frequencies, SciPy's eigenvalues, and the rigid gear as its limit."""

import copy
import pickle

import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb
from mbconstrained.scene.run.scene import read_scene
from mbconstrained.scene.schema.scene_schema import scene_schema
from tests.scene.scenes import EXAMPLES, scene_of

J, K, R = (4e-4, 3.6e-3), 5e5, (0.02, 0.06)
BY_TEETH = {"start_teeth": 20, "end_teeth": 60, "module": "2 mm"}


def two_gears(**mesh):
    model = mb.LumpedModel()
    model.inertia("pinion", J[0])
    model.inertia("wheel", J[1])
    return model, model.gear_mesh("pinion", "wheel", K, **mesh)


@pytest.mark.parametrize("internal", [False, True])
def test_both_gears_oscillate_against_each_other(internal):
    model, _ = two_gears(start_radius="20 mm", end_radius="60 mm", internal=internal)
    modes = model.assemble().modes()
    expected = np.sqrt(K * (R[0] ** 2 / J[0] + R[1] ** 2 / J[1]))
    assert modes.natural_frequencies == pytest.approx([expected], rel=1e-14)
    free = np.array([R[1], R[0] if internal else -R[0]])
    assert model.assemble().stiffness @ free == pytest.approx([0, 0], abs=1e-12)  # both together rotate freely


def test_teeth_and_module_give_the_base_circles():
    _, mesh = two_gears(**BY_TEETH)
    base = [0.002 * teeth * np.cos(np.pi / 9) / 2 for teeth in (20, 60)]
    assert list(mesh.row.values()) == pytest.approx(base, rel=1e-15)
    _, mesh = two_gears(**BY_TEETH, pressure_angle="14.5 deg")
    assert mesh.row["pinion"] == pytest.approx(0.02 * np.cos(np.radians(14.5)), rel=1e-15)


def train():
    """A motor and a drum on elastic shafts with two stages of gears."""
    model = mb.LumpedModel()
    for name, inertia in (("motor", 0.02), ("a", 0.001), ("b", 0.01), ("c", 0.002), ("d", 0.03), ("drum", 0.2)):
        model.inertia(name, inertia)
    model.torsion_spring("motor", "a", 400.0)
    model.gear_mesh("a", "b", 2e6, damping=30.0, start_radius=0.02, end_radius=0.06)
    model.torsion_spring("b", "c", 900.0)
    model.gear_mesh("c", "d", 3e6, damping=20.0, start_radius=0.03, end_radius=0.08, internal=True)
    model.torsion_spring("d", "drum", 2000.0)
    return model


def test_a_train_has_the_frequencies_of_scipy():
    rows = np.array(
        [[-1, 1, 0, 0, 0, 0], [0, 0.02, 0.06, 0, 0, 0], [0, 0, -1, 1, 0, 0], [0, 0, 0, 0.03, -0.08, 0], [0, 0, 0, 0, -1, 1]]
    )
    stiffness = rows.T @ np.diag([400, 2e6, 900, 3e6, 2000]) @ rows
    damping = rows.T @ np.diag([0, 30, 0, 20, 0]) @ rows
    system = train().assemble()
    assert system.stiffness == pytest.approx(stiffness, rel=1e-14) and system.damping == pytest.approx(damping, rel=1e-14)
    squares = scipy.linalg.eigh(stiffness, np.diag([0.02, 0.001, 0.01, 0.002, 0.03, 0.2]), eigvals_only=True)
    undamped = mb.MechanicalSystem(system.mass, stiffness=system.stiffness)
    assert undamped.modes().natural_frequencies == pytest.approx(np.sqrt(squares[1:]), rel=1e-11)


def test_a_stiff_mesh_is_a_gear():
    frequencies = []
    for stiff in (True, False):
        model, load = mb.LumpedModel(), 0.18
        model.inertia("motor", 0.02), model.inertia("pinion", 1e-3), model.inertia("wheel", load)
        model.torsion_spring("motor", "pinion", 40.0)
        radii = {"start_radius": 0.02, "end_radius": 0.06}
        model.gear_mesh("pinion", "wheel", 1e15, **radii) if stiff else model.gear("pinion", "wheel", **radii)
        frequencies.append(model.assemble().modes().natural_frequencies[0])
    assert frequencies[0] == pytest.approx(frequencies[1], rel=1e-9)


@pytest.mark.parametrize(
    ("mesh", "field", "change"),
    [
        ({"start_radius": R[0], "end_radius": R[1]}, "gear mesh pinion-wheel", {}),
        ({"start_radius": R[0], "end_radius": R[1]}, "gear mesh pinion-wheel.end_radius", {"end_radius": R[1] * 1.00001}),
        ({"start_radius": R[0], "end_radius": R[1]}, "gear mesh pinion-wheel.damping", {"damping": 0.001}),
        ({**BY_TEETH, "pressure_angle": 0.3}, "gear mesh pinion-wheel.module", {"module": 0.002 * 1.00001}),
        ({**BY_TEETH, "pressure_angle": 0.3}, "gear mesh pinion-wheel.pressure_angle", {"pressure_angle": 0.3 * 1.00001}),
    ],
)
def test_parameters_have_the_derivatives_of_the_assembled_matrices(mesh, field, change):
    model, _ = two_gears(**mesh)
    (parameter,) = (own for own in model.assemble().parameter_source() if own.name == field)
    if not change:
        assert parameter.stiffness * K == pytest.approx(model.assemble().stiffness, rel=1e-14)
        return
    changed = two_gears(**{**mesh, **change})[0].assemble()
    (step,) = change.values()
    what = "damping" if "damping" in change else "stiffness"
    difference = (getattr(changed, what) - getattr(model.assemble(), what)) / (step - parameter.value)
    assert getattr(parameter, what) == pytest.approx(difference, rel=1e-4)


@pytest.mark.parametrize(
    ("mesh", "message"),
    [
        (
            {},
            'gear mesh "gear mesh pinion-wheel": expected both radii of the base circles, or both numbers of teeth and the module',
        ),
        ({"start_radius": 0.02}, "expected both radii"),
        ({"start_radius": 0.02, "end_radius": 0.06, "module": 0.002}, "expected both radii"),
        ({"start_teeth": 20, "end_teeth": 60}, "expected both radii"),
        ({**BY_TEETH, "start_teeth": 20.5}, "start teeth: found 20.5; expected a whole number"),
        ({**BY_TEETH, "module": "2 kg"}, 'module: found "2 kg", a mass; expected a length'),
        ({"start_radius": -0.02, "end_radius": 0.06}, "start radius: found -0.02; expected a number greater than zero"),
    ],
)
def test_errors_name_what_is_wrong(mesh, message):
    with pytest.raises(mb.InputError, match=message):
        two_gears(**mesh)


SCENE = """
[model]
kind = "lumped"
inertia = [{ name = "pinion", inertia = 4e-4 }, { name = "wheel", inertia = 3.6e-3 }]
[[model.gear_mesh]]
between = ["pinion", "wheel"]
stiffness = "500 N/mm"
damping = 5
teeth = [20, 60]
module = "2 mm"
[time]
end = 1
"""


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("", ""),
        ('between = ["pinion", "wheel"]', 'start = "pinion"\nend = "wheel"'),
        ("teeth = [20, 60]", "start_teeth = 20\nend_teeth = 60"),
    ],
)
def test_a_scene_has_the_mesh_of_python(tmp_path, old, new):
    model, _ = two_gears(damping=5, **BY_TEETH)
    assert scene_of(tmp_path, SCENE.replace(old, new)).equations.model.elements == model.elements


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "teeth = [20, 60]",
            "teeth = [20, 60.5]",
            r"model\.gear_mesh\[1\]\.teeth\[2\]: found 60.5; expected a whole number of teeth",
        ),
        ("damping = 5", 'start = "pinion"', r"model\.gear_mesh\[1\]: between and start say the same thing; give one of them"),
        ('between = ["pinion", "wheel"]\n', "", r"model\.gear_mesh\[1\]: give either between, or start and end"),
    ],
)
def test_errors_of_scenes_name_the_entry(tmp_path, old, new, message):
    with pytest.raises(mb.SceneError, match=message):
        scene_of(tmp_path, SCENE.replace(old, new))


def test_elements_of_parameters_are_pickled():
    elements = read_scene(EXAMPLES / "gear_mesh.toml").equations.model.elements
    assert pickle.loads(pickle.dumps(elements)) == copy.deepcopy(elements) == elements


def test_the_schema_follows_from_the_class():
    table = scene_schema()["$defs"]["GearMeshTable"]
    assert table["properties"]["stiffness"]["unit"] == "N/m" and table["properties"]["module"]["examples"][0] == "0.2 m"
    assert {"anyOf": [{"required": ["between"]}, {"required": ["start", "end"]}]} in table["allOf"]
