"""What leaving out saves: for each example scene, what doing the left-out stages all the same would take.

    python tests/benchmarks/leaving_out.py [name of an example ...]

Every scene runs in fresh processes: as planned, and then with the left-out stages done after it one by one, each measured
with its imports. What has no sense for a scene (constraint rows or energy where there are none) is not counted; of a
robot or a formula where there can be none the import of its library is. Of a few repetitions the one with the least time is
told, as noise only adds to it; time and memory are those of ``stage_costs``.
"""

from __future__ import annotations

import copy
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

from mbconstrained.analyses.run import RunAnswer as Result
from mbconstrained.ground.errors import MbconstrainedError
from mbconstrained.response.estimate import error_estimate
from mbconstrained.scene.run.plan import Costs
from mbconstrained.scene.run.result import PARTS
from mbconstrained.scene.run.scene import read_scene

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
REPETITIONS = 2
LONGEST = 600  # s, that one process may take


def main(names: list[str]) -> None:
    scenes = [EXAMPLES / f"{name}.toml" for name in names] or sorted(EXAMPLES.glob("*.toml"))
    print(f"{'example':<24} {'run takes':>16} {'leaving out saves':>18} {'ratio':>6}   largest")
    sums = [0.0, 0.0]
    for scene in scenes:
        run, left_out = min((in_a_process(scene) for _ in range(REPETITIONS)), key=lambda found: whole(found[1].values()))
        sums = [sums[0] + run["seconds"], sums[1] + whole(left_out.values())]
        print(line(scene.stem, run, left_out), flush=True)
    print(f"{'all':<24} {sums[0]:6.2f} s {sums[1]:17.2f} s {sums[1] / sums[0]:15.1f}")


def whole(costs) -> float:
    return sum(cost["seconds"] for cost in costs)


def line(name: str, run: dict, left_out: dict[str, dict]) -> str:
    saved = {"seconds": whole(left_out.values()), "memory": sum(cost["memory"] or 0 for cost in left_out.values())}
    largest = sorted(left_out, key=lambda stage: -left_out[stage]["seconds"])[:3]
    told = ", ".join(f"{stage} {shown(left_out[stage])}" for stage in largest)
    return f"{name:<24} {shown(run):>16} {shown(saved):>18} {saved['seconds'] / run['seconds']:6.1f}   {told}"


def shown(cost: dict) -> str:
    memory = "–" if cost["memory"] is None else f"{cost['memory'] / 1e6:.0f}"
    return f"{cost['seconds']:.2f} s {memory:>3} MB"


def in_a_process(scene: Path) -> tuple[dict, dict[str, dict]]:
    """What the run took, and each left-out stage after it."""
    command = [sys.executable, str(Path(__file__).resolve()), "--once", str(scene)]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=LONGEST)
    return json.loads(done.stdout)


def once(path: str) -> None:
    """In the other process."""
    with tempfile.TemporaryDirectory() as folder:
        result = read_scene(path).run(folder)
        left_out = {stage.name: all_the_same(stage.name, result) for stage in result.plan.left_out if stage.name in ALL_THE_SAME}
    run = {"seconds": result.plan.seconds, "memory": result.plan.memory}
    print(json.dumps([run, {name: cost for name, cost in left_out.items() if cost}]))


def all_the_same(stage: str, result: Result) -> dict:
    """What a stage takes that was left out; nothing where it has no sense for the scene."""
    costs = Costs()
    try:
        ALL_THE_SAME[stage](result)
    except (MbconstrainedError, NotImplementedError):
        return {}
    cost = costs.lap("")
    return {"seconds": cost.seconds, "memory": cost.memory}


def with_output(result: Result, **changes) -> Result:
    """The same answer, asked for certificate or formula too."""
    found = copy.copy(result)
    found.scene = result.scene._with_output(**changes)
    for name in ("certificate", "formula"):
        vars(found).pop(name, None)
    return found


def imported(*names: str) -> Callable[[Result], object]:
    return lambda result: [import_module(name) for name in names]


def curves(kind: str) -> Callable[[Result], object]:
    """The curves and their error estimate."""

    def work(result: Result) -> object:
        if kind in ("energy", "reaction") and not (result.system and (kind == "energy" or result.system.rows)):
            raise NotImplementedError
        if kind == "output" and result.scene.equations.outputs is None:
            raise NotImplementedError
        result.curves(kind)
        return None if kind in PARTS else error_estimate(result.motion, result.times, result._view(kind))

    return work


def modes(result: Result) -> object:
    if result.system is None:
        raise NotImplementedError
    return result.modes


def animation(result: Result) -> object:
    if result.scene.equations.has_outputs_among_coordinates:
        raise NotImplementedError
    from mbconstrained.page.animation import key_frames

    return key_frames(result.animation)


def normal_form(result: Result) -> object:
    from mbconstrained.mechanics.normal_form import mechanical_normal_form

    system = result.scene.equations.control.system
    E = system.E if system.is_descriptor else None
    return mechanical_normal_form(system.A, system.B, system.C, system.D, descriptor=E)


def images(result: Result) -> object:
    """Every curve as one PNG file, by matplotlib without a window."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    for kind in result.kinds:
        found, figure = result.curves(kind), Figure()
        canvas = FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        axes.plot(result.times, found.values.T, label=found.names)
        axes.legend()
        canvas.print_png(str(result.folder / f"{kind}.png"))
    return None


def certificate(result: Result) -> object:
    return with_output(result, certify=True).certificate


def formula(result: Result) -> object:
    """For as long as a page would wait; sympy alone where no formula is looked for."""
    from mbconstrained.scene.run.stages import too_large_for_formula

    if result.scene.equations.robot or too_large_for_formula(result.scene):
        return imported("sympy")(result)
    return with_output(result, formula=True).formula


#: Left-out stages that could be done all the same, by name.
ALL_THE_SAME: dict[str, Callable[[Result], object]] = {
    "units": lambda result: import_module("mbconstrained.ground.quantities").registry(),
    "robot model (pinocchio)": imported("pinocchio", "mbconstrained.robot"),
    "robot meshes": lambda result: result.scene.equations.robot.visuals(),
    "collision geometry": lambda result: result.scene.equations.robot.visuals(collision=True),
    "mechanical normal form": normal_form,
    "infinite pair": lambda result: result.infinite_pair,
    "velocities": curves("velocity"),
    "accelerations": curves("acceleration"),
    "reactions": curves("reaction"),
    "forces of loops and springs": curves("ground_reaction"),
    "outputs": curves("output"),
    "energy": curves("energy"),
    "modes": modes,
    "transfer functions": lambda result: result.scene.equations.control.transfers,
    "certificate (python-flint)": certificate,
    "symbols (sympy)": formula,
    "animation": animation,
    "page": lambda result: result.write_page(),
    "CSV": lambda result: result.write_csv(),
    "npz": lambda result: result.write_npz(),
    "plots as images (matplotlib)": images,
}

if __name__ == "__main__":
    once(sys.argv[2]) if sys.argv[1:2] == ["--once"] else main(sys.argv[1:])
