"""What the plan leaves out is not run and its libraries are not imported; what it takes is. Scenes run in processes of their own."""

import functools
from typing import NamedTuple

import pytest

from mbconstrained.scene.run import stages
from tests.scene.build.test_control_scenes import STATES
from tests.scene.robots import SCENE, TOML, URDF, press
from tests.scene.scenes import COEFFICIENTS, EXAMPLES, MATRICES, OSCILLATOR
from tests.scene.watched import Watched, watched

pytestmark = pytest.mark.long  # a process for each scene, every call in it noted

#: Packages, and large parts of them, that a run may need or not.
LIBRARIES = (
    "pinocchio", "coal", "collada", "trimesh", "meshcat", "sympy", "matplotlib", "scipy.optimize", "scipy.signal", "scipy.io",
    "xarray", "pandas", "control", "typer", "rich", "IPython", "mbconstrained.page.html", "mbconstrained.scene.run.animation",
    "mbconstrained.exact", "mbconstrained.robot", "mbconstrained.studies", "mbconstrained.mechanics.switched.sequence",
)  # fmt: skip

NOTHING_WRITTEN = "[output]\npage = false\ncsv = false\nnpz = false\n"
ALL = """
[output]
plots = ["displacement", "velocity", "acceleration", "energy", "reaction"]
formula = true
certify = true
"""
HELD = "[[model.constraint]]\nrows = { a = 1, b = -1 }\n[[model.constraint]]\nrows = { a = 2, b = -2 }\n"
PUSHED = '[[force]]\ncoordinate = "a"\nkind = "step"\nvalue = "1 N"\n'
MISSING = '<geometry><mesh filename="missing.stl"/></geometry>'
MESHES = URDF.replace('<geometry><box size="0.2 0.02 0.02"/></geometry></visual>', f"{MISSING}</visual>")
COLLISIONS = URDF.replace("</visual>\n  </link>", f"</visual>\n<collision>{MISSING}</collision>\n  </link>")

PICTURES = ("matplotlib",)
MESHES_BY = ("trimesh", "scipy.optimize")  # which trimesh imports

SCENES = {
    "plain": MATRICES + NOTHING_WRITTEN,
    "all": MATRICES.replace("[time]", f"{HELD}{PUSHED}[time]") + ALL,
    "certified": MATRICES + "[output]\npage = false\ncsv = false\nnpz = false\ncertify = true\n",
    "lumped": OSCILLATOR,
    "quantities": OSCILLATOR + NOTHING_WRITTEN + '[[output.quantity]]\nbetween = ["ground", "cart"]\nquantity = "displacement"\n',
    "frequency": OSCILLATOR + NOTHING_WRITTEN + "[frequency]\n",
    "frequency page": OSCILLATOR + "[frequency]\n",
    "pictures": MATRICES + NOTHING_WRITTEN + "plot_images = true\n",
    "coefficients": COEFFICIENTS + NOTHING_WRITTEN,
    "still page": MATRICES + "[output]\nanimation = false\n",
    "free and held": MATRICES.replace("[time]", f"{HELD}[time]") + NOTHING_WRITTEN,
    "states": STATES + NOTHING_WRITTEN,
    "states alone": STATES.replace("C = [[1, 0]]\n", "").replace('y1 = "m", ', ""),
    "normal form": STATES.replace("units =", "normal_form = true\nunits =") + '[output]\nplots = ["output"]\n',
    "normal form alone": STATES.replace("units =", "normal_form = true\nunits =") + '[output]\nplots = ["displacement"]\n',
    "robot": SCENE,
    "robot with unread meshes": SCENE + "[output]\npage = false\n",
    "robot with collisions": SCENE,
    "robot with forces": SCENE + NOTHING_WRITTEN + "reactions = true\n",
}
ROBOTS = {"robot": URDF, "robot with unread meshes": MESHES, "robot with collisions": COLLISIONS, "robot with forces": URDF}
FILES = {
    "robot with meshes": EXAMPLES / "seven_joint_arm.toml",
    "formula": EXAMPLES / "two_masses_formula.toml",
    "friction": EXAMPLES / "stick_slip.toml",
}


class Work(NamedTuple):
    """A scene that takes a stage and one that leaves it out (None: there is none), its work, its libraries."""

    takes: str | None
    leaves: str | None
    called: str | None
    libraries: tuple[str, ...] = ()


def computed(kind: str) -> str:
    return f"scene/run/result.py:Result.curves({kind})"


WORK = {
    "read the scene": Work("plain", None, "scene/file.py:parse"),
    "units": Work("all", "plain", "ground/units.py:unit_in_si"),
    "robot model (pinocchio)": Work("robot", "lumped", "scene/build/robot_file.py:robot_of", ("pinocchio", "coal")),
    "equilibrium": Work("robot", "lumped", "robot/posture_search.py:find_posture", ("mbconstrained.robot",)),
    "robot meshes": Work("robot with meshes", "robot with unread meshes", "robot/description/meshes.py:read_mesh", MESHES_BY),
    "collision geometry": Work("robot with collisions", "robot with unread meshes", "scene/run/drawing.py:RobotPicture._collision"),
    "assemble the model": Work("plain", None, "scene/build/equations.py:equations_of"),
    "mechanical normal form": Work("normal form", "states", "mechanics/normal_form.py:mechanical_normal_form"),
    "dependent constraint rows": Work("all", "plain", "mechanics/constraints.py:_reduced"),
    "constrained form": Work("all", "plain", "mechanics/constrained_form.py:_projected"),
    "scaling and staircase": Work("coefficients", "plain", "linalg/staircase.py:split_pencil"),
    "finite pair": Work("coefficients", "plain", "polynomial/jordan_pairs.py:JordanPairs.finite"),
    "infinite pair": Work("all", "free and held", "polynomial/jordan_pairs.py:JordanPairs.infinite"),
    "response": Work("plain", None, "response/response.py:Response._solved"),
    "switches": Work(
        "friction", "lumped", "mechanics/switched/sequence.py:PhaseSequence.run", ("mbconstrained.mechanics.switched.sequence",)
    ),
    "displacements": Work("plain", None, computed("displacement")),
    "outputs": Work("normal form", "normal form alone", computed("output")),
    "velocities": Work("lumped", "plain", computed("velocity")),
    "accelerations": Work("all", "lumped", computed("acceleration")),
    "reactions": Work("all", "free and held", "mechanics/motion.py:Motion.reaction"),
    "forces of loops and springs": Work("robot with forces", "robot", computed("ground_reaction")),
    "energy": Work("all", "lumped", "mechanics/energy.py:energy_of"),
    "element quantities": Work("quantities", "lumped", computed("quantity")),
    "modes": Work("plain", "coefficients", "mechanics/modes.py:modes_of"),
    "transfer functions": Work("states", "states alone", "scene/build/control_model.py:ControlScene._transfer"),
    "error estimate": Work("plain", None, "response/estimate.py:error_estimate"),
    "proof (python-flint)": Work(
        "plain", "robot", "response/methods/proved.py:ProvedFunction.is_provable", ("mbconstrained.exact",)
    ),
    "certificate (python-flint)": Work("all", "lumped", "scene/run/certificate.py:certificate_of", ("mbconstrained.exact",)),
    "symbols (sympy)": Work("formula", "lumped", "analyses/formula.py:formula_of", ("sympy", "mbconstrained.exact")),
    "frequency response": Work("frequency", "lumped", "frequency/frequency_response.py:evaluated"),
    "frequency page and files": Work("frequency page", "frequency", "analyses/frequency.py:Frequency.to_answer"),
    "animation": Work("lumped", "still page", "page/animation.py:key_frames", ("mbconstrained.scene.run.animation",)),
    "CSV": Work("lumped", "plain", "analyses/run.py:RunAnswer.write_csv"),
    "npz": Work("lumped", "plain", "analyses/run.py:RunAnswer.write_npz"),
    "page": Work("still page", "plain", "page/html.py:page_html", ("mbconstrained.page.html",)),
    "other formats": Work(None, "all", "analyses/run.py:RunAnswer.write_formats"),
    "plots as images (matplotlib)": Work("pictures", "all", "page/plots.py:plot_images", PICTURES),
    "still picture (Chromium)": Work(None, "all", "page/photograph.py:photograph", ("mbconstrained.page.html",)),
}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Run the scene of a name, once."""

    @functools.cache
    def once(name: str) -> Watched:
        folder = tmp_path_factory.mktemp("watched")
        if name in FILES:
            return watched(FILES[name], folder / "out")
        if name in ROBOTS:
            press(folder, TOML, ROBOTS[name])
        (folder / "scene.toml").write_text(SCENES[name], encoding="utf-8")
        return watched(folder / "scene.toml", folder / "out")

    return once


def loaded(found: Watched, libraries) -> set[str]:
    return set(libraries) & found.loaded


def test_every_stage_is_here_and_no_other():
    following = [step for steps in (*stages.CONTROL_NEXT.values(), *stages.ROBOT_NEXT.values()) for step in steps]
    steps = (*stages.FILE_STEPS, *stages.ROBOT_STEPS, *stages.NO_ROBOT_STEPS, *stages.STEPS, *following)
    assert {step.name for step in steps} == set(WORK)


@pytest.mark.parametrize("stage", [stage for stage, work in WORK.items() if work.takes])
def test_what_is_taken_is_run(run, stage):
    work = WORK[stage]
    found = run(work.takes)
    assert stage in found.taken
    assert work.called in found.called
    assert loaded(found, work.libraries) == set(work.libraries)


@pytest.mark.parametrize("stage", [stage for stage, work in WORK.items() if work.leaves])
def test_what_is_left_out_is_not_run_and_its_libraries_are_not_imported(run, stage):
    work = WORK[stage]
    found = run(work.leaves)
    assert stage not in found.taken
    assert work.called not in found.called
    needed = {library for other in found.taken for library in WORK[other].libraries}
    assert not loaded(found, set(work.libraries) - needed)


@pytest.mark.parametrize("name", [*SCENES, *FILES.keys() - {"friction"}])  # each of its phases is solved by Jordan pairs of its own
def test_every_scene_runs_what_its_plan_says_and_nothing_else(run, name):
    found = run(name)
    assert {stage for stage, work in WORK.items() if work.called in found.called} == found.taken


@pytest.mark.parametrize("name", [*SCENES, *FILES])
def test_every_scene_imports_the_libraries_of_its_stages_and_no_other(run, name):
    found = run(name)
    needed = {library for stage in found.taken for library in WORK[stage].libraries}
    assert loaded(found, LIBRARIES) == needed
