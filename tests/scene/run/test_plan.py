"""The plan: what is listed as taken runs, what is left out does not."""

from itertools import pairwise

import numpy as np
import pytest

from mbconstrained.mechanics.system import MechanicalSystem
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import EXAMPLES, MATRICES, OSCILLATOR, scene_of

CONSTRAINT = '[[model.constraint]]\nrows = { a = 1, b = -1 }\nlevel = "LEVEL"\n[time]'


def stages(scene) -> dict[str, bool]:
    return {stage.name: stage.needed for stage in scene.plan().stages}


def constrained(folder, level, extra=""):
    return scene_of(folder, MATRICES.replace("[time]", CONSTRAINT.replace("LEVEL", level)).replace("[time]", f"{extra}\n[time]"))


def test_a_free_oscillator_needs_little(tmp_path):
    plain = OSCILLATOR.replace('"2 kg"', "2").replace('"8 N/m"', "8").replace('"5 s"', "5")
    taken = [stage.name for stage in scene_of(tmp_path, plain + "\n[output]\npage = false\nnpz = false\n").plan().needed]
    assert taken == [
        "read the scene",
        "assemble the model",
        "response",
        "displacements",
        "modes",
        "error estimate",
        "proof",
        "CSV",
    ]


@pytest.mark.parametrize(
    ("key", "stage"),
    [
        ("page = false", "page"),
        ("page = false", "animation"),
        ("animation = false", "animation"),
        ("csv = false", "CSV"),
        ("npz = false", "npz"),
        ("animation = false", "velocities"),
        ('plots = ["acceleration"]', "accelerations"),
        ('plots = ["energy"]', "energy"),
    ],
)
def test_output_decides(tmp_path, key, stage):
    default = stages(scene_of(tmp_path, OSCILLATOR))
    changed = stages(scene_of(tmp_path, OSCILLATOR + f"\n[output]\n{key}\n"))
    assert changed[stage] is not default[stage]


@pytest.mark.parametrize(
    ("level", "extra", "taken"),
    [  # A_2 is singular below acceleration level (Moysis et al., section 4.1: free and admissible needs no infinite pair)
        ("acceleration", "", False),
        ("acceleration", '[[force]]\ncoordinate = "a"\nkind = "step"\nvalue = 1', False),
        ("position", "", False),
        ("position", "[initial]\ndisplacement = [1, 1]", False),
        ("position", "[initial]\ndisplacement = [1, 0]", True),
        ("velocity", "[initial]\nvelocity = [1, 0]", True),
        ("position", '[[force]]\ncoordinate = "a"\nkind = "step"\nvalue = 1', True),
        ("position", '[[force]]\ncoordinate = "a"\nkind = "impulse"\nvalue = 1', True),
    ],
)
def test_infinite_pair_only_where_it_matters(tmp_path, level, extra, taken):
    assert stages(constrained(tmp_path, level, extra))["infinite pair"] is taken


def test_what_is_taken_is_called(tmp_path, monkeypatch):
    called = []
    original = MechanicalSystem.modes
    monkeypatch.setattr(MechanicalSystem, "modes", lambda self: called.append("modes") or original(self))
    order = []
    text = OSCILLATOR + '[output]\nplots = ["displacement", "velocity", "energy"]\n'
    result = scene_of(tmp_path, text).run(tmp_path, progress=lambda stage: order.append(stage.name))
    assert called == ["modes"]
    assert order == [stage.name for stage in result.plan.needed if stage.name not in PREPARED]
    assert all(stage.seconds is not None for stage in result.plan.needed if stage.name in order)
    assert all(stage.seconds is None for stage in result.plan.left_out)


PREPARED = (
    "read the scene",
    "units",
    "assemble the model",
    "dependent constraint rows",
    "constrained form",
    "proof",  # part of the error estimate
)


def test_planning_solves_nothing(monkeypatch):
    monkeypatch.setattr(MechanicalSystem, "solve", None)
    monkeypatch.setattr(MechanicalSystem, "modes", None)
    assert read_scene(EXAMPLES / "two_masses.toml").plan().needed


def chain(masses: int, more: str = "") -> str:
    """A scene of masses in a row between two walls."""
    names = ["ground", *(f"m{i}" for i in range(masses)), "ground"]
    springs = [
        f'[[model.spring]]\nbetween = ["{a}", "{b}"]\nstiffness = {100 + 7 * (k % 3)}' for k, (a, b) in enumerate(pairwise(names))
    ]
    bodies = [f'[[model.mass]]\nname = "{name}"\nmass = {1 + 0.1 * k}' for k, name in enumerate(names[1:-1])]
    start, time = "[initial]\ndisplacement = { m0 = 0.1 }", '[time]\nend = "5 s"\npoints = 501'
    return "\n".join(['[model]\nkind = "lumped"', *bodies, *springs, more, start, time])


DAMPER = '[[model.damper]]\nbetween = ["ground", "m2"]\ndamping = 3'


@pytest.mark.parametrize(
    ("masses", "more", "way"),
    [
        (3, "", "by eigenvectors: 6 states are few"),
        (30, "", "by a symmetric eigenproblem: powers of e^(S h) cost about"),
        (30, DAMPER, "by powers of e^(S h): they cost about"),
    ],
)
def test_the_way_to_find_values_is_told_with_its_cost(tmp_path, masses, more, way):
    scene = scene_of(tmp_path, chain(masses, more))
    (reason,) = (stage.reason for stage in scene.plan().stages if stage.name == "response")
    assert reason.startswith("from the values at 0-, with jumps and impulses; values ") and way in reason
    assert np.isfinite(scene.run().values).all()


def test_the_plan_names_the_method_of_the_run(tmp_path):
    """A start that fits and an impulse on a mass go by the reduced equations, jumps of constraints by the pairs; the plan says so before."""
    hit = OSCILLATOR + '[[force]]\ncoordinate = "cart"\nkind = "impulse"\nvalue = "1 N*s"\n'
    link = (EXAMPLES / "rigid_link.toml").read_text(encoding="utf-8")
    reduced = "the eigenvalues; the motion comes from"
    for text, pair in ((OSCILLATOR, reduced), (hit, reduced), (link, "the motion for t > 0")):
        scene = scene_of(tmp_path, text)
        reasons = {stage.name: stage.reason for stage in scene.plan().stages}
        assert reasons["finite pair"].startswith(pair)
        assert reasons["response"].endswith(scene.run().motion.method.reason)
