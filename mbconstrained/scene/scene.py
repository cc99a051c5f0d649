"""A scene: a checked file with its equations, that can be planned and run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import InputError
from ..notices import Notice
from .dimensions import load_units
from .equations import Equations, equations_of
from .free_motions import free_motion_notices
from .includes import read_tables
from .parameters import Parameters, with_parameters
from .plan import Plan
from .problems import at, validated
from .result import Result
from .settings import Setting, with_settings, with_values
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
        settings: what was set from outside.
        file_name: of the file, in messages; it knows what comes from other files.
    """

    path: Path
    table: object
    equations: Equations
    unit_texts: int
    costs: dict[str, Cost]
    parameters: Parameters = Parameters()
    settings: tuple[Setting, ...] = ()
    file_name: str = ""

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

    @property
    def heading(self) -> str:
        """The title with what was set from outside."""
        made = ", ".join(map(str, self.settings))
        return f"{self.title}, with {made}" if made else self.title

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """What is known before anything is solved: what was set from outside, unused parameters, bodies that nothing holds."""
        free = free_motion_notices(self.equations.system) if self._has_elements else ()
        return (*(setting.notice for setting in self.settings), *self.parameters.notices, *free)

    @property
    def _has_elements(self) -> bool:
        return self.equations.system is not None and self.table.model.kind in ("lumped", "matrices")

    def certified(self) -> Scene:
        """The same scene with certify = true, where it does not say itself what to certify."""
        output = self.table.output
        return self._with_output(certify=output.certify or output.coordinates or True)

    def with_viewer(self, viewer: str) -> Scene:
        """The same scene with the viewer's script "inside" its page, "beside" it, or "compressed"."""
        return self._with_output(viewer=viewer)

    def with_plot_images(self) -> Scene:
        """The same scene with its plots as pictures too."""
        return self._with_output(plot_images=True)

    def with_still(self, time: float) -> Scene:
        """The same scene with a still picture of its model at a time in s.

        Raises:
            InputError: a time that the scene does not reach.
        """
        end = self.table.time.end
        if not 0 <= time <= end:
            raise InputError(f"still picture: found {time:g} s; expected a time from 0 to {end:g} s, where the scene ends")
        return self._with_output(still=float(time))

    def unwritten(self) -> Scene:
        """The same scene without page, CSV, npz and pictures."""
        return self._with_output(page=False, csv=False, npz=False, plot_images=False, still=None)

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


def read_scene(path: str | Path, settings: Mapping[str, Any] | None = None) -> Scene:
    """Read a scene file, check it, assemble its equations and see that they determine a motion; solve nothing.

    Args:
        path: a TOML file in UTF-8.
        settings: values to take instead of those in the file, numbers or texts with units: by the name of a parameter, or by
            place, such as "time.end" or "model.mass.cart.mass".

    Raises:
        SceneError: the file cannot be read or something in it is wrong; the text names file, place, what was
            found and what was expected.
        SingularPolynomialMatrix: det A(s) = 0 for every s: dependent equations or free coordinates.

    >>> read_scene("examples/two_masses.toml", {"time.end": "1 min"}).table.time.end
    60.0
    >>> scene = read_scene("examples/two_masses.toml")
    >>> scene.title
    'Two masses with a redundant coordinate'
    """
    path = Path(path)
    costs = Costs()
    data, name = read_tables(path)
    name, made = with_settings(data, name, settings or {})
    unit_texts = count_texts({key: data[key] for key in data if key not in ("title", "source")})
    costs.lap("read the scene")
    if unit_texts:
        load_units()
        costs.lap("units")
    data, parameters = with_parameters(data, name)
    name = with_values(name, made, parameters.places)
    table = validated(data, name)
    costs.lap("read the scene")
    equations = equations_of(table, path.parent, name, costs.lap)
    _check_output(table.output, equations, name)
    if equations.robot_scene and table.output.page and table.output.animation:
        equations.robot_scene.data.check_meshes()
    scene = Scene(path, table, equations, unit_texts, costs.by_name, parameters, made, name)
    if table.drawing and (table.drawing.body or table.drawing.link or equations.robot):
        from .drawing_check import check_drawing

        check_drawing(scene)
    costs.lap("assemble the model")
    equations.polynomial_matrix.jordan_pairs()
    costs.lap("scaling and staircase")
    return scene


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
    with at(file_name, "output.arrows"):
        if output.arrows and not (system and system.rows):
            raise InputError("found reaction, but there are no constraint rows; leave it out")
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
