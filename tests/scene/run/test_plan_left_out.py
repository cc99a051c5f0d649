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
    """The function that does the work of a stage, and the libraries that it needs."""

    called: str
    libraries: tuple[str, ...] = ()


def computed(kind: str) -> str:
    return f"scene/run/result.py:Result.curves({kind})"


WORK = {
    "read the scene": Work("scene/file.py:parse"),
    "units": Work("ground/units.py:unit_in_si"),
    "robot model (pinocchio)": Work("scene/build/robot_file.py:robot_of", ("pinocchio", "coal")),
    "equilibrium": Work("robot/posture_search.py:find_posture", ("mbconstrained.robot",)),
    "robot meshes": Work("robot/description/meshes.py:read_mesh", MESHES_BY),
    "collision geometry": Work("scene/run/drawing.py:RobotPicture._collision"),
    "assemble the model": Work("scene/build/equations.py:equations_of"),
    "mechanical normal form": Work("mechanics/normal_form.py:mechanical_normal_form"),
    "dependent constraint rows": Work("mechanics/constraints.py:_null_space"),
    "constrained form": Work("mechanics/constraints.py:_projected"),
    "scaling and staircase": Work("linalg/staircase.py:split_pencil"),
    "finite pair": Work("polynomial/jordan_pairs.py:JordanPairs.finite"),
    "infinite pair": Work("polynomial/jordan_pairs.py:JordanPairs.infinite"),
    "response": Work("response/response.py:Response._solved"),
    "switches": Work("mechanics/switched/sequence.py:PhaseSequence.run", ("mbconstrained.mechanics.switched.sequence",)),
    "displacements": Work(computed("displacement")),
    "outputs": Work(computed("output")),
    "velocities": Work(computed("velocity")),
    "accelerations": Work(computed("acceleration")),
    "reactions": Work("mechanics/motion.py:Motion.reaction"),
    "forces of loops and springs": Work(computed("ground_reaction")),
    "energy": Work("mechanics/energy.py:energy_of"),
    "element quantities": Work(computed("quantity")),
    "modes": Work("mechanics/modes.py:modes_of"),
    "transfer functions": Work("scene/build/control_model.py:ControlScene._transfer"),
    "error estimate": Work("response/estimate.py:error_estimate"),
    "proof": Work("response/methods/proved.py:ProvedFunction.evaluated"),
    "certificate (python-flint)": Work("scene/run/certificate.py:certificate_of", ("mbconstrained.exact",)),
    "symbols (sympy)": Work("analyses/formula.py:formula_of", ("sympy", "mbconstrained.exact")),
    "frequency response": Work("frequency/frequency_response.py:evaluated"),
    "frequency page and files": Work("analyses/frequency.py:Frequency.to_answer"),
    "animation": Work("page/animation.py:key_frames", ("mbconstrained.scene.run.animation",)),
    "CSV": Work("analyses/run.py:RunAnswer.write_csv"),
    "npz": Work("analyses/run.py:RunAnswer.write_npz"),
    "page": Work("page/html.py:page_html", ("mbconstrained.page.html",)),
    "other formats": Work("analyses/run.py:RunAnswer.write_formats"),
    "plots as images (matplotlib)": Work("page/plots.py:plot_images", PICTURES),
    "still picture (Chromium)": Work("page/photograph.py:photograph", ("mbconstrained.page.html",)),
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


def test_every_stage_is_here_and_no_other():
    following = [step for steps in (*stages.CONTROL_NEXT.values(), *stages.ROBOT_NEXT.values()) for step in steps]
    steps = (*stages.FILE_STEPS, *stages.ROBOT_STEPS, *stages.NO_ROBOT_STEPS, *stages.STEPS, *following)
    assert {step.name for step in steps} == set(WORK)


def test_every_stage_but_those_for_other_programs_is_taken_and_left_out_in_some_scene(run):
    taken = [run(name).taken for name in (*SCENES, *FILES)]
    always = {"read the scene", "assemble the model", "response", "displacements", "error estimate"}
    assert WORK.keys() - set().union(*taken) == {"other formats", "still picture (Chromium)"}
    assert set.intersection(*map(set, taken)) == always


@pytest.mark.parametrize("name", [*SCENES, *FILES])
def test_every_scene_runs_what_its_plan_says_and_nothing_else(run, name):
    found = run(name)
    ran = {stage for stage, work in WORK.items() if work.called in found.called}
    compared = {"switches"} if name == "friction" else WORK.keys()  # with friction each phase is solved by functions of its own
    assert ran & compared == found.taken & compared


@pytest.mark.parametrize("name", [*SCENES, *FILES])
def test_every_scene_imports_the_libraries_of_its_stages_and_no_other(run, name):
    found = run(name)
    needed = {library for stage in found.taken for library in WORK[stage].libraries}
    where_bounds_leave_a_doubt = {"mbconstrained.exact"} if "proof" in found.taken else set()
    assert needed <= found.loaded & set(LIBRARIES) <= needed | where_bounds_leave_a_doubt
