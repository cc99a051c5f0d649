"""Objects of Python as they are shown: pages, plots and views of motions and modes by an equivalent scene, and pictures in notebooks."""

from __future__ import annotations

import base64
import html
import tempfile
import webbrowser
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import singledispatch
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from ..frequency.frequency_response import FrequencyResponse
from ..frequency.plots import principal_phase
from ..frequency.random.random_response import RandomResponse
from ..frequency.shock_spectrum import PARTS, ShockResponseSpectrum
from ..ground.by_name import answering
from ..ground.checks import check_known, real_number, whole_number
from ..ground.display import with_unit
from ..ground.errors import InputError, MbconstrainedError
from ..ground.files import path_of
from ..mechanics.equations import EquationsOfMotion
from ..mechanics.harmonic_response import frequency_response
from ..mechanics.modes import Modes
from ..mechanics.motion import Motion
from ..mechanics.root_locus import RootLocus
from ..mechanics.switched import is_switched
from ..page.content import Curve, Plot, Scale, curve_with_gaps
from ..page.plots import axis_titles, image_groups, new_axes, plot_image
from ..response.response import Response
from ..scene.build.data_files import Record
from ..scene.build.model import Equations
from ..scene.build.robot_model import RobotEquations, RobotScene
from ..scene.coordinates import Coordinates
from ..scene.file import SceneName
from ..scene.run.drawing import check_drawing
from ..scene.run.scene import Scene, check_output
from ..scene.run.scene_data import UNWRITTEN
from ..scene.run.stages import plan_of
from ..scene.schema.entry_types import Table, validated
from ..scene.schema.model_tables import MatricesTable
from ..scene.schema.scene_schema import DrawingTable, InitialTable, OutputTable, SceneFile, TimeTable
from .base import Answer
from .locus import locus_plot
from .motion_plots import plots_of
from .random import response_plots
from .run import RunAnswer

if TYPE_CHECKING:
    from ..mechanics.system import MechanicalSystem
    from ..robot.robot import Robot
    from ..robot.statics import Posture

#: So many periods of the slowest oscillation, or time constants of the slowest decay, are shown where no end is given.
PERIODS, TIME_CONSTANTS = 8.0, 5.0

#: More than so many periods of the fastest oscillation are not shown by default: curves would be bands.
MOST_PERIODS = 200.0

KINDS = ("displacement", "velocity", "acceleration", "reaction", "energy", "phase", "output")


def result_of(
    motion: Response,
    end: float | None = None,
    points: int = 401,
    title: str = "",
    plots: Sequence[str] = ("displacement",),
    drawing: Mapping[str, Any] | None = None,
    slow_events: bool = False,
) -> RunAnswer:
    """The result of an equivalent scene."""
    for kind in plots:
        check_known(kind, KINDS, "plots")
    last = _last_time(motion) if end is None else real_number(end, "end", positive=True)
    if is_switched(motion) and last > motion.end:
        raise InputError(f"end: found {last:g} s; the motion is known up to {motion.end:g} s: solve it with a later end")
    times = TimeTable.model_construct(
        end=last,
        points=whole_number(points, "points", minimum=2),
    )
    system = motion.system if isinstance(motion, Motion) else None
    kinds: list[Any] = list(dict.fromkeys(plots))
    output = OutputTable(plots=kinds, csv=False, npz=False, slow_events=slow_events)
    scene = _scene(system, motion, title, drawing, times, output)
    check_output(output, scene.equations, "write_page")
    return RunAnswer(scene, plan_of(scene))


def _scene(
    system: EquationsOfMotion | None,
    motion: Response | None,
    title: str,
    drawing: Mapping[str, Any] | None,
    times: TimeTable,
    output: OutputTable,
) -> Scene:
    A = motion.polynomial_matrix if motion is not None else system.polynomial_matrix()
    units = tuple(system.units.values()) if system is not None else ("1",) * A.size
    coordinates = Coordinates(tuple(A.coordinates), units)
    initial = motion.initial if motion is not None else np.zeros((A.degree, A.size))
    origin = getattr(system, "origin", None)
    mechanical = cast("MechanicalSystem | None", system)  # a motion knows it by its equations alone
    known = coordinates, A, initial, None, mechanical, origin
    robot = _robot_scene(system)
    equations = Equations(*known, response=motion) if robot is None else RobotEquations(*known, robot, response=motion)
    coefficients = None if system is not None else list(A.coefficients)
    model = MatricesTable.model_construct(kind="matrices", coefficients=coefficients)
    drawn = validated({} if drawing is None else {"drawing": drawing}, "write_page", _DrawnAnswer).drawing
    table = SceneFile.model_construct(title=title, model=model, time=times, output=output, initial=InitialTable(), drawing=drawn)
    scene = Scene(Path("motion"), table, equations, 0, {}, file_name=SceneName("write_page"))
    if scene.table.drawing:
        check_drawing(scene)
    return scene


class _DrawnAnswer(Table):
    """The part of a scene file that corresponds to the options of a page."""

    drawing: DrawingTable | None = None


def _robot_scene(system: EquationsOfMotion | None) -> RobotScene | None:
    """The robot behind a linearized one, in the form of a scene without robot.toml."""
    from ..scene.build.robot_file import RobotData, UrdfNames
    from ..scene.schema.robot_tables import RobotFile

    posture: Posture | None = getattr(system, "posture", None)
    if posture is None:
        return None
    robot = cast("Robot", posture.robot)
    names = UrdfNames(Path(robot.name), robot.bodies, dict(zip(robot.coordinates, robot.units)), (), ())
    table = RobotFile.model_construct(title=robot.name, urdf=robot.name, base=robot.base)
    linearized: Any = system
    return RobotScene(RobotData(Path(robot.name) / "robot.toml", table, names, robot.semantics, ()), robot, posture, linearized, {})


def _last_time(motion: Response) -> float:
    """The end of a switched motion; else some periods of the slowest oscillation, or time constants of the slowest decay, after the last restart of the force."""
    if is_switched(motion):
        return motion.end
    zeros = np.array([zero.value for zero in motion.pairs.finite.zeros] or [0.0], dtype=complex)
    oscillating, decaying = np.abs(zeros[zeros.imag > 0]), -zeros[(zeros.imag == 0) & (zeros.real < 0)].real
    last = float(motion.problem.force.knots[-1])
    if not (oscillating.size or decaying.size):
        return last + 1.0 if not last else 1.25 * last
    lengths = [*(PERIODS * 2 * np.pi / oscillating), *(TIME_CONSTANTS / decaying)]
    length = min(max(lengths), MOST_PERIODS * min(lengths) / PERIODS)
    return float(f"{last + length:.2g}")


def write_page(answer: Response | Modes | Answer | Scene, path, **options) -> Path:
    """Write the static page of a motion, of modes, of an answer, or of the run of a scene."""
    path = path_of(path)
    if isinstance(answer, Response):
        return result_of(answer, **options).write_page(path)
    if isinstance(answer, Modes):
        from .modes import ModalAnalysis

        answer = ModalAnalysis.solve(_scene_of_modes(answer, **options))
    elif options:
        raise InputError(f"{next(iter(options))}: a page of an answer takes no options; give them in its scene")
    if isinstance(answer, Scene):
        answer = answer.with_output(**UNWRITTEN).run()
    if not isinstance(answer, Answer):
        expected = "expected a motion, modes, an answer or a scene, such as system.solve(...) or scene.frequency()"
        raise InputError(f"found an object of type {type(answer).__name__}; {expected}")
    from ..page.html import write_page as write

    path.parent.mkdir(parents=True, exist_ok=True)
    write(path, answer.page(), "inside")
    return path


def _scene_of_modes(modes: Modes, title: str = "", drawing: Mapping[str, Any] | None = None) -> Scene:
    if modes.system is None:
        raise InputError(
            "write_page: these modes belong to no system of arrays; call system.modes() of a MechanicalSystem of arrays"
        )
    return _scene(modes.system, None, title, drawing, TimeTable.model_construct(end=1.0, points=2), OutputTable())


def plot(motion: Response, axes=None, quantity: str = "displacement", **options) -> Any:
    """Draw the curves of a quantity into axes of Matplotlib."""
    result = result_of(motion, plots=[quantity], **options)
    curves = result.curves(quantity)
    if not (axes is None or hasattr(axes, "plot")):
        raise InputError(f"axes: found {axes!r}; expected axes of Matplotlib; the last time has a name: plot(end=10)")
    axes = new_axes() if axes is None else axes
    for name, values in zip(curves.names, curves.values):
        axes.plot(result.times, values, label=name)
    axes.set_xlabel("time (s)")
    axes.set_ylabel(" / ".join(dict.fromkeys(f"{title} ({unit})" for title, unit in zip(curves.titles, curves.units))))
    axes.legend()
    return axes


@dataclass(frozen=True)
class PageView:
    """A static page inside a notebook."""

    page: str  # the HTML
    height: int  # height of the frame, in pixels

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{html.escape(self.page)}" width="100%" height="{self.height}" frameborder="0"></iframe>'


def view(answer: Response | Modes, height: int = 700, **options) -> PageView:
    """The page in a frame, for notebooks."""
    with tempfile.TemporaryDirectory() as folder:
        return PageView(write_page(answer, Path(folder) / "view.html", **options).read_text(encoding="utf-8"), height)


@answering
def show(answer: Response | Modes | Answer | Scene, **options) -> Path:
    """Write the page of a motion, of modes, of an answer or of the run of a scene to a temporary file and open it in the browser.

    Args:
        answer: a ``Motion``, ``Response``, ``Modes``, ``Answer`` or ``Scene``.
        options: of motions and modes, as of their ``write_page``.

    Returns:
        The path of the page.

    Raises:
        InputError: an object of another class.
    """
    path = write_page(answer, Path(tempfile.mkdtemp(prefix="mbconstrained-")) / "view.html", **options)
    webbrowser.open(path.as_uri())
    return path


# --- pictures in notebooks: plots as SVG without a script

#: The receptances of so many coordinates of a system are drawn.
MOST_COORDINATES = 12

#: Pictures below one object; a notebook is not the page.
MOST_PICTURES = 6


def pictures(shown) -> str:
    """The plots of an object as HTML that a notebook shows; each picture is closed in itself and runs no script."""
    try:
        groups = image_groups(plots(shown))
    except MbconstrainedError:  # what is shown has no such answer, or none within float64
        return ""
    more = f"<p>and {len(groups) - MOST_PICTURES} further pictures on the page</p>" if len(groups) > MOST_PICTURES else ""
    return "".join(map(_picture, groups[:MOST_PICTURES])) + more


def _picture(group: tuple[Plot, ...]) -> str:
    across, up = axis_titles(group[0])
    text = html.escape(f"{', '.join(plot.title for plot in group)}: {up} over {across}")
    data = base64.b64encode(plot_image(group, "svg")).decode()
    return f'<img alt="{text}" style="max-width: 100%" src="data:image/svg+xml;base64,{data}"/>'


@singledispatch
def plots(shown) -> Iterable[Plot]:
    """The plots of an object."""
    raise NotImplementedError(type(shown).__name__)  # each type with pictures is registered below


@plots.register
def _(answer: Answer) -> Iterable[Plot]:
    return answer.plots()


@plots.register
def _(scene: Scene) -> Iterable[Plot]:
    """The plots of its run."""
    return scene.with_output(**UNWRITTEN).run().plots()


@plots.register
def _(system: EquationsOfMotion) -> Iterator[Plot]:
    """The receptance of each coordinate under a force on it; of a large model those of the first coordinates."""
    if system.is_sparse:
        return
    names = system.names[:MOST_COORDINATES]
    H = frequency_response(system, inputs=names, outputs=names)
    for unit in dict.fromkeys(H.units.diagonal()):
        own = [i for i in range(len(names)) if H.units[i, i] == unit]
        curves = tuple(curve_with_gaps(names[i], np.abs(H.values[i, i])) for i in own)
        scales: tuple[Scale, Scale] = ("log", "log")
        yield Plot("receptance", unit, H.frequencies_hz, curves, across_unit="Hz", variable="frequency", scales=scales)


@plots.register
def _(motion: Response) -> Iterable[Plot]:
    return plots_of(result_of(motion))


@plots.register
def _(response: FrequencyResponse) -> Iterator[Plot]:
    """Amplitudes and phases at the frequencies of the response, those of one unit side by side."""
    f, is_log = response.frequencies_hz, bool((response.frequencies_hz > 0).all())
    several = len(response.inputs) > 1
    groups: dict[str, list[tuple[str, np.ndarray]]] = {}
    for i, j in np.ndindex(len(response.outputs), len(response.inputs)) if len(f) > 1 else ():
        name = f"{response.outputs[i]} by {response.inputs[j]}" if several else str(response.outputs[i])
        groups.setdefault(str(response.units[i, j]), []).append((name, np.asarray(response.values)[i, j]))
    for unit, entries in groups.items():
        amplitudes, phases = (tuple(curve_with_gaps(name, part(H)) for name, H in entries) for part in (np.abs, principal_phase))
        scale: Scale = "log" if is_log else "linear"
        up: Scale = "log" if any((curve.values > 0).any() for curve in amplitudes) else "linear"
        more: dict[str, Any] = {"across_unit": "Hz", "variable": "frequency", "image": f"{response.quantity} {unit}"}
        yield Plot(response.quantity, unit, f, amplitudes, scales=(scale, up), **more)
        yield Plot("phase", "°", f, phases, scales=(scale, "linear"), **more)


@plots.register
def _(response: RandomResponse) -> Iterable[Plot]:
    return response_plots(response)


@plots.register
def _(spectrum: ShockResponseSpectrum) -> Iterator[Plot]:
    curves = tuple(Curve(part, getattr(spectrum, part)) for part in PARTS)
    positive = any((curve.values > 0).any() for curve in curves)
    yield Plot(
        f"shock response spectrum, {spectrum.quantity}", spectrum.unit, spectrum.frequencies_hz, curves, across_unit="Hz",
        quantity=spectrum.quantity, variable="frequency", scales=("log", "log" if positive else "linear"),
    )  # fmt: skip


@plots.register
def _(record: Record) -> Iterator[Plot]:
    if len(record.times):
        name, jumps = record.name or "record", np.append(np.diff(record.times) == 0, False)
        yield Plot(
            name, record.unit, np.where(jumps, np.nextafter(record.times, -np.inf), record.times), (Curve(name, record.values),)
        )


@plots.register
def _(locus: RootLocus) -> Iterator[Plot]:
    low, high = (with_unit(value, locus.unit) for value in locus.values[[0, -1]])
    yield locus_plot(locus, low, high)
