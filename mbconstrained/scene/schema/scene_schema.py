"""The schema of a scene file, with a description of every key."""

from __future__ import annotations

from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import BeforeValidator, Field, SkipValidation, WithJsonSchema, field_validator, model_validator

from ...ground.errors import InputError, shown
from ...ground.tolerances import noise_of
from ..quantities.coordinates import DERIVATIVES
from ..quantities.output_units import output_units
from .analyses.campbell_table import CampbellTable
from .analyses.frequency_table import FrequencyTable
from .analyses.path_table import PathTable
from .analyses.random_table import RandomTable
from .analyses.shock_table import ShockTable
from .analyses.vary_table import VaryTable
from .drawing_tables import DrawingTable
from .entry_types import NUMBER_SCHEMA, Name, Pair, Quantity, Table, Text, Time
from .force_tables import ForceTable, MotionTable
from .lumped_tables import LumpedTable
from .model_tables import MatricesTable, StateSpaceTable, TransferFunctionTable
from .robot_tables import RobotChanges, RobotTable

CONTROL = ("transfer-function", "state-space")


def _values(value):
    if not isinstance(value, (dict, list)):
        raise InputError(f'found {shown(value)}; expected {{ x1 = "0.8 m" }} or an array with a value for every coordinate')
    return value


VALUES = [{"type": "object", "additionalProperties": NUMBER_SCHEMA}, {"type": "array", "items": NUMBER_SCHEMA}]

Values = Annotated[
    Any,
    BeforeValidator(_values),
    WithJsonSchema({"title": "values by coordinate, or an array of all", "anyOf": VALUES}),
]


Parameters = Annotated[  # their values are checked by ``with_parameters``, before the schema sees the scene
    dict[str, Any],
    WithJsonSchema(
        {
            "title": "quantities by name",
            "type": "object",
            "additionalProperties": NUMBER_SCHEMA,
        }
    ),
]


class InitialTable(Table):
    """The values just before t = 0; coordinates that are left out start at 0."""

    displacement: Values = Field({}, description="Positions or angles at 0-.")
    velocity: Values = Field({}, description="Velocities at 0-.")
    acceleration: Values = Field({}, description="Accelerations at 0-, for equations of degree 3 and above.")
    jerk: Values = Field({}, description="Third derivatives at 0-, for equations of degree 4 and above.")
    derivatives: list[list[Quantity]] | None = Field(
        None, description="Alternatively: row i has the i-th derivatives of all coordinates."
    )
    state: Values = Field({}, description="States of a state space at 0-, instead of all these, e.g. { x1 = 0.1 }.")
    follow: bool = Field(False, description="true: omitted values follow from the constraint rows instead of being 0.")

    @model_validator(mode="after")
    def _one_form(self):
        if self.follow and not all(isinstance(row, dict) for row in self.rows):
            raise InputError("follow needs values by name, e.g. displacement = { x1 = 0.1 }: nothing is left out of an array")
        named = [key for key in DERIVATIVES if key in self.model_fields_set]
        if self.derivatives is not None and named:
            raise InputError(f"derivatives and {named[0]} say the same thing; give one of them")
        return self

    @property
    def rows(self) -> list[dict | list]:
        """Values by order of derivative, without the empty ones at the end."""
        rows = self.derivatives if self.derivatives is not None else [getattr(self, key) for key in DERIVATIVES]
        while rows and not rows[-1]:
            rows = rows[:-1]
        return rows


class TimeTable(Table):
    """The times of the answer, equally spaced from start to end; the motion begins at 0 all the same."""

    FEWEST_POINTS: ClassVar[int] = 2
    MOST_POINTS: ClassVar[int] = 200_000

    end: Time = Field(description="The last time.")
    start: Time = Field(0.0, description="The first time of the answer; the values of [initial] are those at 0 all the same.")
    points: int = Field(
        401, ge=FEWEST_POINTS, le=MOST_POINTS,
        description="Number of times, start and end included; by default 401, or as many as the fastest visible motion needs, at most 20001."
    )  # fmt: skip
    step: Time | None = Field(None, description="Time step, instead of points; the last time is at most end.")

    @model_validator(mode="after")
    def _forwards(self):
        if not self.end > 0:
            raise InputError(f"end is {self.end:g} s; expected a time after 0")
        if not 0 <= self.start < self.end:
            raise InputError(f"start is {self.start:g} s; expected a time from 0 to before the end, which is {self.end:g} s")
        return self if self.step is None else self._with_step()

    def _with_step(self) -> TimeTable:
        if "points" in self.model_fields_set:
            raise InputError("give either step or points, not both")
        if not 0 < self.step <= self.end - self.start:
            raise InputError(
                f"step is {self.step:g} s; expected a time from 0 to {self.end - self.start:g} s, the length of the answer"
            )
        steps = (self.end - self.start) / self.step
        points = int(steps + noise_of(steps)) + 1  # a step that divides the length but for rounding errors
        if points > self.MOST_POINTS:
            raise InputError(f"step is {self.step:g} s, which makes {points} times; expected at most {self.MOST_POINTS}")
        object.__setattr__(self, "points", points)
        object.__setattr__(self, "end", self.start + self.step * (points - 1))
        return self

    @property
    def is_automatic(self) -> bool:
        """Whether neither points nor step are given."""
        return not {"points", "step"} & self.model_fields_set

    @property
    def times(self) -> np.ndarray:
        """All times in s, shape (points,)."""
        if self.step is None:
            return np.linspace(self.start, self.end, self.points)
        return self.start + self.step * np.arange(self.points)

    @property
    def spacing(self) -> float:
        """Step between two times in s."""
        return (self.end - self.start) / (self.points - 1)

    @property
    def text(self) -> str:
        """First and last time, for the page and the summary."""
        return f"{self.start:g} to {self.end:g} s"


Curve = Literal["displacement", "velocity", "acceleration", "reaction", "ground_reaction", "energy", "output", "phase"]


def _flag_or_names(value):
    if not isinstance(value, bool | list):
        raise InputError(f'found {shown(value)}; expected true, false or a list of coordinates, e.g. ["x1"]')
    return value


class QuantityTable(Table):
    """A force or elongation of a spring or damper, or the motion of one coordinate relative to another, over time."""

    name: Name | None = Field(None, description="Name; by default that of the element, or of both coordinates.")
    of: Text | None = Field(None, description="A spring or damper by its name, of a robot a spring or a joint; or else between.")
    between: Pair | None = Field(None, description='Two coordinates, e.g. ["wheel", "body"]: the second relative to the first.')
    quantity: Literal["force", "elongation", "rate", "displacement", "velocity", "acceleration"] | None = Field(
        None, description="Force (default), elongation or rate of an element; displacement (default) … between coordinates."
    )

    @model_validator(mode="after")
    def _one_source(self):
        if (self.of is None) == (self.between is None):
            raise InputError('give either of, the name of a spring or damper, or between, e.g. ["wheel", "body"]')
        return self


class OutputTable(Table):
    """The files to write."""

    page: bool = Field(True, description="A static HTML page with animation, plots and tables.")
    animation: bool = Field(True, description="The moving model on the page.")
    certify: Annotated[bool | list[Name], BeforeValidator(_flag_or_names)] = Field(
        False, description="true: prove digits of the answer by exact arithmetic; or a list of the coordinates to do it for."
    )
    formula: bool = Field(False, description="The formula of each coordinate on the page, with the [parameters] as symbols.")
    viewer: Literal["inside", "separate", "compressed"] = Field(
        "inside",
        description="The script of the 3-D viewer: in the page, in a separate file for many pages, or compressed in the page.",
    )
    plots: list[Curve] = Field(["displacement"], description="Plots of the page; phase is the velocity over the displacement.")
    coordinates: list[Name] | None = Field(None, description="Only these coordinates are plotted; left out: all.")
    quantity: list[QuantityTable] = Field([], description="Forces, elongations and relative motions for plots, CSV and npz.")
    reactions: bool = Field(False, description="Forces of constraints, and of a robot's springs, in files.")
    arrows: list[Literal["reaction"]] = Field([], description="Forces that the animation shows as arrows.")
    units: Annotated[
        tuple[str, ...], BeforeValidator(output_units), WithJsonSchema({"type": "string", "examples": ["mm, deg, rpm, kN"]})
    ] = Field(
        (),
        description='Units of page, tables and CSV, e.g. "mm, deg, rpm, kN"; accelerations in m/s^2, or g or mm/s^2 given here; SI when left out, and in the npz file.',
    )
    plot_images: bool = Field(False, description="The plots as pictures too, SVG and PNG, for reports.")
    still: Time | None = Field(None, description="A picture of the model at this time as PNG, taken by an installed Chromium.")
    csv: bool = Field(True, description="The trajectories as CSV.")
    npz: bool = Field(True, description="The trajectories, jumps and impulses as NumPy .npz.")
    formats: list[Literal["excel", "mat", "netcdf", "zarr", "uff"]] = Field(
        [], description="Further files: CSV with semicolons and decimal commas, MATLAB, netCDF, Zarr, a universal file."
    )

    @field_validator("plots", "coordinates", "formats")
    @classmethod
    def _once(cls, names):
        if repeated := next((name for name in names or () if names.count(name) > 1), None):
            raise InputError(f'"{repeated}" is named twice; once is enough')
        return names


Model = Annotated[LumpedTable | MatricesTable | RobotTable | TransferFunctionTable | StateSpaceTable, Field(discriminator="kind")]


class SceneFile(Table):
    """A scene: a model, its initial values, the forces, the times and the output."""

    title: Text = Field("", description="Heading of the page; by default the name of the file.")
    source: Text = Field("", description="Source of the example or the data.")
    include: list[Text] | Text = Field([], description="Scene files whose tables are part of this one, relative to it.")
    parameters: Parameters = Field({}, description='Quantities by name, e.g. m = "10 kg"; "=2*m" may stand wherever a number does.')
    model: Model = Field(description="The equations.")
    robot: Annotated[RobotChanges | None, SkipValidation] = Field(
        None, description="Changes of the robot.toml for this scene, e.g. its gravity, stiffness, damping or payloads."
    )
    initial: InitialTable = Field(InitialTable(), description="The values just before t = 0.")
    force: list[ForceTable] = Field([], description="Forces from t = 0 or from their delays on; entries on one coordinate add up.")
    motion: list[MotionTable] = Field([], description="Prescribed motions of coordinates: supports that move.")
    time: TimeTable = Field(description="Times of the answer.")
    frequency: FrequencyTable | None = Field(None, description="The frequency response that is computed, too; left out: none.")
    random: RandomTable | None = Field(None, description="Random vibration, by the command random; left out: none.")
    shock: ShockTable | None = Field(None, description="Peaks under a shock, by the command shock; left out: the defaults.")
    vary: VaryTable | None = Field(None, description="Parameters that the commands sweep and optimise vary; left out: named there.")
    campbell: CampbellTable | None = Field(None, description="Speeds and orders of the command campbell; left out: the defaults.")
    path: PathTable | None = Field(None, description="Path of a point of a robot, along which the command path computes its modes.")
    output: OutputTable = Field(OutputTable(), description="Files to write, and contents of the page.")
    drawing: DrawingTable | None = Field(None, description="Drawing of the model; automatic by default.")

    @classmethod
    def _hint(cls, key: str) -> str:
        if key not in LumpedTable.model_fields:
            return ""
        return f"; it belongs to the model: write [[model.{key}]], or {key} = … below [model]"

    @model_validator(mode="before")
    @classmethod
    def _outputs_are_plotted(cls, data):
        """Default plots of [output]: for a transfer function or state space its outputs."""
        model, output = (data.get(key, {}) for key in ("model", "output")) if isinstance(data, dict) else ({}, None)
        if not (isinstance(model, dict) and isinstance(output, dict) and model.get("kind") in CONTROL) or "plots" in output:
            return data
        has_outputs = model["kind"] != "state-space" or "C" in model or "D" in model
        plots = ["displacement"] * (not has_outputs or model.get("normal_form") is True) + ["output"] * has_outputs
        return {**data, "output": {**output, "plots": plots}}

    @model_validator(mode="after")
    def _robot_of_what(self):
        if self.robot is not None and self.model.kind != "robot":
            raise InputError('robot changes the robot.toml of kind = "robot"; leave it out')
        return self

    @model_validator(mode="after")
    def _still_in_time(self):
        if self.output.still is not None and not self.time.start <= self.output.still <= self.time.end:
            still, end = f"{self.output.still:g} s", f"{self.time.end:g} s"
            raise InputError(f"output.still is {still}; expected a time from {self.time.start:g} to time.end, which is {end}")
        return self

    @model_validator(mode="after")
    def _state_of_what(self):
        if self.initial.state and self.model.kind not in CONTROL:
            raise InputError('initial.state belongs to kind = "state-space"; give displacement and velocity')
        return self
