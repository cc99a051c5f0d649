"""A scene: a checked file with its equations, that can be planned and run."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ..checks import nearest
from ..errors import InputError
from .dimensions import load_units
from .equations import Equations, equations_of
from .parameters import Parameters, with_parameters
from .plan import Plan
from .problems import at, validated
from .reading import parse, read_text
from .result import Result
from .stage_costs import Cost, Costs
from .stages import plan_of, run_stages
from .units import count_texts


@dataclass(frozen=True)
class Scene:
    """A scene that was read, checked and assembled; nothing is solved yet.

    Attributes:
        path: the file.
        table: what stands in it, checked and in SI.
        equations: the equations that it asks to be solved.
        unit_texts: how many quantities were written with a unit.
        costs: what the stages of reading, from the file to the staircase, took, by name.
        parameters: the named quantities, which everywhere else stand with their values.
    """

    path: Path
    table: object
    equations: Equations
    unit_texts: int
    costs: dict[str, Cost]
    parameters: Parameters = Parameters()

    @property
    def name(self) -> str:
        """The name of the file without its ending; results are named after it."""
        return self.path.stem

    @property
    def times(self) -> np.ndarray:
        """The times asked for, shape (T,), in s."""
        return np.linspace(0.0, self.table.time.end, self.table.time.points)

    @property
    def title(self) -> str:
        """The title in the file, or else the name."""
        return self.table.title or self.name

    def certified(self) -> Scene:
        """The same scene with certify = true, where it does not say itself what to certify."""
        output = self.table.output
        return self._with_output(certify=output.certify or output.coordinates or True)

    def unwritten(self) -> Scene:
        """The same scene without page, CSV and npz."""
        return self._with_output(page=False, csv=False, npz=False)

    def _with_output(self, **changes) -> Scene:
        output = self.table.output.model_copy(update=changes)
        return replace(self, table=self.table.model_copy(update={"output": output}))

    def plan(self) -> Plan:
        """The stages that this scene needs and those it can do without, each with its reason."""
        return plan_of(self)

    def run(self, folder: str | Path | None = None, progress=None) -> Result:
        """Solve the scene by the stages of its plan, each of which is measured.

        On Linux the highest resident memory of the process, as the system keeps it, is set back at the start of each stage.

        Args:
            folder: where page, CSV and npz are written, as far as the scene asks for them; None: nowhere.
            progress: called with each stage as it begins.

        Raises:
            MbconstrainedError: the equations have no answer, or none within the range of float64.
        """
        return run_stages(self, None if folder is None else Path(folder), progress)


def read_scene(path: str | Path) -> Scene:
    """Read a scene file, check it, assemble its equations and see that they determine a motion; solve nothing.

    Args:
        path: a TOML file in UTF-8.

    Raises:
        SceneError: the file cannot be read or something in it is wrong; the text names file, place, what was
            found and what was expected.
        SingularPolynomialMatrix: det A(s) = 0 for every s: dependent equations or free coordinates.

    >>> scene = read_scene("examples/two_masses.toml")
    >>> scene.title
    'Two masses with a redundant coordinate'
    """
    path = Path(path)
    costs = Costs()
    data = parse(read_text(path), path.name)
    unit_texts = count_texts({key: data[key] for key in data if key not in ("title", "source")})
    costs.lap("read the scene")
    if unit_texts:
        load_units()
        costs.lap("units")
    data, parameters = with_parameters(data, path.name)
    table = validated(data, path.name)
    costs.lap("read the scene")
    equations = equations_of(table, path.parent, path.name, costs.lap)
    _check_output(table.output, equations, path.name)
    _check_drawing(table.drawing, equations, path.name)
    if equations.robot_scene and table.output.page and table.output.animation:
        equations.robot_scene.data.check_meshes()
    costs.lap("assemble the model")
    equations.polynomial_matrix.jordan_pairs()
    costs.lap("scaling and staircase")
    return Scene(path, table, equations, unit_texts, costs.by_name, parameters)


def _check_output(output, equations: Equations, file_name: str) -> None:
    with at(file_name, "output.certify"):
        for name in output.certify if isinstance(output.certify, list) else ():
            equations.coordinates.number(name)
    with at(file_name, "output.coordinates"):
        for name in output.coordinates or ():
            equations.coordinates.number(name)
    with at(file_name, "output.formula"):
        if output.formula and equations.robot:
            raise InputError("there is no formula with symbols for a robot; leave it out")
    system = equations.system
    with at(file_name, "output.plots"):
        if "output" in output.plots and equations.outputs is None:
            raise InputError(
                "found output, but no outputs are named; name them as [[model.output]] of a robot, give C of a state space, "
                "or leave it out"
            )
        if "energy" in output.plots and equations.control and equations.control.form:
            raise InputError(
                "found energy: the unit masses of a normal form are not those of the machine, whose energy is not known"
            )
        if "energy" in output.plots and system is None:
            raise InputError("energy is known only where mass, damping and stiffness are given, not for coefficients")
        if "reaction" in output.plots and not (system and system.rows):
            raise InputError("found reaction, but there are no constraint rows; leave it out")


def _check_drawing(drawing, equations: Equations, file_name: str) -> None:
    """Names in the drawing; it is drawn only when a page is made."""
    if drawing and equations.robot and (drawing.body or drawing.link):
        with at(file_name, "drawing"):
            raise InputError("a robot is drawn from its URDF: leave out body and link; scale and note may stand here")
    bodies = [body.name for body in drawing.body] if drawing else []
    for number, body in enumerate(drawing.body if drawing else (), 1):
        with at(file_name, f'drawing.body[{number}] (of "{body.name}")'):
            if bodies.count(body.name) > 1:
                raise InputError("this name is used twice; names must differ")
            for name in (*body.moves, *body.turns):
                equations.coordinates.number(name)
    for number, link in enumerate(drawing.link if drawing else (), 1):
        with at(file_name, f"drawing.link[{number}]"):
            if link.start == link.end:
                raise InputError(f'start and end are the same body, "{link.start}"; name two bodies')
            for name in filter(None, (link.start, link.end, link.over)):
                if name not in bodies:
                    raise InputError(f'there is no body "{name}" in the drawing{nearest(name, bodies)}')
