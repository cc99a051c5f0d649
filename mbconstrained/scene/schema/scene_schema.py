"""The schema of a scene file with its [drawing], a description of every key, and JSON Schemas for editors."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from typing import Annotated, Any, ClassVar, Literal, cast

import numpy as np
from pydantic import BaseModel, BeforeValidator, Field, SkipValidation, WithJsonSchema, field_validator, model_validator

from ...ground.checks import nearest
from ...ground.errors import InputError, shown
from ...ground.quantities import KINDS, Dimension, any_quantity
from ...ground.tolerances import noise_of
from ..coordinates import DERIVATIVES, QUANTITIES, OutputUnits, output_units
from ..file import EntryError
from .entry_types import (
    MISSING_TIME,
    NUMBER_SCHEMA,
    SIGNALS,
    Angle,
    LateTable,
    Name,
    Number,
    Pair,
    Quantity,
    Table,
    TablesByKind,
    Teeth,
    Text,
    Time,
    Values,
    Vector,
)

Shape = Literal["box", "sphere", "disc", "gear", "ring", "mark", "rail", "ground", "base"]
LinkKind = Literal["spring", "damper", "strut", "rod", "bushing", "loop", "torsion spring", "torsion damper", "belt"]
PlainVector = Annotated[list[Number], Field(min_length=3, max_length=3)]


def _color(value):
    if not isinstance(value, str) or not re.fullmatch(r"#[0-9a-fA-F]{6}", value):
        raise InputError(f'found {shown(value)}; expected a colour such as "#1f77b4"')
    return value


VIEWS = {
    "front": (0.0, 0.0),
    "back": (math.pi, 0.0),
    "right": (math.pi / 2, 0.0),
    "left": (-math.pi / 2, 0.0),
    "top": (0.0, math.pi / 2),
}


class ViewTable(Table):
    """The view of the model."""

    yaw: Angle = Field(0.0, description='How far round to the right, e.g. "30 deg"; 0 is in front.')
    pitch: Angle = Field(0.0, description='How far up, e.g. "20 deg"; 0 is level.')
    zoom: Number = Field(1.0, gt=0, description="Magnification relative to the view of the whole motion.")

    def _check(self) -> None:
        if max(abs(self.yaw), abs(self.pitch)) > 2 * math.pi:
            raise InputError(
                f'found yaw {self.yaw:g} rad and pitch {self.pitch:g} rad, more than once round; write degrees as "30 deg"'
            )


def _view(value):
    if isinstance(value, str):
        if value not in VIEWS:
            known = f"""{", ".join(VIEWS)} or e.g. {{ yaw = "30 deg", pitch = "20 deg" }}"""
            raise InputError(f"found {shown(value)}; expected {known}{nearest(value, VIEWS)}")
        return dict(zip(("yaw", "pitch"), VIEWS[value]))
    return value


_View = Annotated[
    ViewTable, BeforeValidator(_view, json_schema_input_type=Literal["front", "back", "right", "left", "top"] | ViewTable)
]


class BodyTable(Table):
    """A body at rest + the sum of moves times coordinate, turned by the sum of turns times coordinate."""

    name: Name = Field(description="The name that links refer to; it is shown next to the body.")
    shape: Shape | None = Field(
        None, description="box: a mass; sphere: a joint; disc, gear, ring: an inertia; mark: a point; ground: a wall."
    )
    rest: Vector | None = Field(None, description="Position with all coordinates 0: x right, y back, z up.")
    moves: dict[Name, PlainVector] | None = Field(
        None, description="Displacement by unit of a coordinate, e.g. { x1 = [1, 0, 0] }."
    )
    turns: dict[Name, PlainVector] | None = Field(None, description="Rotation vector by rad; [0, -1, 0] is counter-clockwise.")
    along: PlainVector | None = Field(
        None, description="Direction of positive displacements in the automatic drawing, e.g. [1, 1, 0]; [0, 0, 1] is up."
    )
    about: PlainVector | None = Field(
        None, description="About what positive angles of this body turn counter-clockwise in the automatic drawing."
    )
    label: Text | None = Field(None, description="Label next to it; by default its name.")
    size: Vector | None = Field(None, description="Extent along x, y, z.")
    color: Annotated[str, BeforeValidator(_color)] | None = Field(None, description='Its colour, e.g. "#1f77b4".')
    teeth: Teeth | None = Field(None, ge=3, le=400, description="Number of teeth of a gear.")

    def _check(self) -> None:
        _check_axes(self)
        for name in ("along", "about"):
            if getattr(self, name) is not None and (self.moves or self.turns):
                raise InputError(f"{name}, and moves or turns, say the same thing; leave out one of them")
        if self.along and self.about:
            raise InputError("along is for a body that is displaced, about for one that turns; leave out one of them")


class LinkTable(Table):
    """Something stretched between two bodies."""

    name: Name | None = Field(None, description="A name for messages; by default of kind and ends.")
    kind: LinkKind = Field(description="Kind of symbol.")
    start: Name = Field(description="The body it starts at.")
    end: Name = Field(description="The body it ends at.")
    offset: Vector = Field([0.0, 0.0, 0.0], description="Moves it aside, so that parallel links are distinct.")
    over: Name | None = Field(None, description="The wheel that a belt runs over.")


class DrawingTable(Table):
    """The drawing of the model: bodies with shapes, or changes of the automatic drawing."""

    body: list[BodyTable] = Field([], description="Bodies; one without a shape is that of the automatic drawing, changed.")
    link: list[LinkTable] = Field([], description="Links.")
    automatic: bool | None = Field(None, description="true: these bodies and links are added to the automatic drawing.")
    view: _View | None = Field(
        None, description='From where it is looked at: front, back, left, right, top, or { yaw = "30 deg", pitch = "20 deg" }.'
    )
    along: PlainVector | None = Field(
        None, description="Direction of positive displacements in the automatic drawing; [0, 0, 1] is up."
    )
    about: PlainVector | None = Field(
        None, description="About what positive angles turn counter-clockwise in the automatic drawing."
    )
    stack: Literal["vertical", "horizontal"] | None = Field(
        None,
        description="vertical: displacements are those of the storeys of a building, upwards; horizontal: in a row. Left out: by names.",
    )
    scale: Number = Field(1.0, description="By how much displacements are magnified, 1 is true; of a robot all motion in a run.")
    turn_scale: Number = Field(1.0, description="By how much angles are magnified, 1 is true.")
    note: Text = Field("", description="A sentence under the drawing.")
    full_meshes: bool = Field(
        False, description="true: meshes of a robot with more than 20 000 triangles are drawn with all of them."
    )

    @property
    def is_own(self) -> bool:
        """Whether it is complete, so that nothing is drawn automatically."""
        if self.automatic is not None:
            return not self.automatic
        return bool(self.body or self.link) and all(body.shape is not None for body in self.body)

    def _check(self) -> None:
        _check_axes(self)
        if self.along and self.about:
            product = sum(a * b for a, b in zip(self.along, self.about))
            if abs(product) > 1e-9 * math.hypot(*self.along) * math.hypot(*self.about):
                raise EntryError("along and about are not at right angles; leave out one of them", "about", "along")
        if self.is_own and self.stack:
            raise EntryError("stack is for the automatic drawing; here the bodies have places of their own, rest", "stack")
        if self.is_own and (self.along or self.about or any(body.along or body.about for body in self.body)):
            raise InputError("along and about turn the automatic drawing; here moves and turns of the bodies say where they go")


def _check_axes(table: BodyTable | DrawingTable) -> None:
    for name in ("along", "about"):
        if getattr(table, name) is not None and not any(getattr(table, name)):
            raise InputError(f"{name} is [0, 0, 0]; give a direction, e.g. [0, 0, 1]")


CONTROL = ("transfer-function", "state-space")


Parameters = Annotated[  # their values are checked by ``with_parameters``, before the schema sees the scene
    dict[str, Any], WithJsonSchema({"title": "quantities by name", "type": "object", "additionalProperties": NUMBER_SCHEMA})
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
    penetration: bool = Field(
        False,
        description="true: contacts that are penetrated at the start close at once, with a jump and impulses, instead of an error.",
    )

    def _check(self) -> None:
        if self.follow and not all(isinstance(row, dict) for row in self.rows):
            raise InputError("follow needs values by name, e.g. displacement = { x1 = 0.1 }: nothing is left out of an array")
        named = [key for key in DERIVATIVES if key in self.model_fields_set]
        if self.derivatives is not None and named:
            raise InputError(f"derivatives and {named[0]} say the same thing; give one of them")

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
    step_domain: Literal["continuous", "discrete"] = Field(
        "continuous",
        description='"discrete": samples k = 0, 1, … alone. Coefficients are those of the shift by one sample, other models are discretized.',
    )
    hold: Literal[0, 1] = Field(1, description="In discrete time, forces between samples: 0 constant, 1 linear.")

    def __getattr__(self, name: str):
        """Without a table the last time is an InputError."""
        if name == "end":
            raise InputError(MISSING_TIME)
        return super().__getattr__(name)

    @property
    def is_given(self) -> bool:
        """Whether the scene has the table: modes and frequency responses need none."""
        return "end" in vars(self)

    def _check(self) -> None:
        if not self.end > 0:
            raise InputError(f"end is {self.end:g} s; expected a time after 0")
        if not 0 <= self.start < self.end:
            raise InputError(f"start is {self.start:g} s; expected a time from 0 to before the end, which is {self.end:g} s")
        if self.step_domain == "discrete":
            self._check_samples()
        elif "hold" in self.model_fields_set:
            raise InputError('hold belongs to step_domain = "discrete"; leave it out')
        if self.step is not None:
            self._count_steps()

    def _check_samples(self) -> None:
        if "points" in self.model_fields_set:
            raise InputError('points: with step_domain = "discrete" give step, the time between samples')
        if self.step is None:
            raise InputError(
                'step_domain = "discrete" needs step, the time between samples; 1 s makes times the numbers of samples'
            )
        number = self.start / self.step if self.step > 0 else 0.0
        if abs(number - round(number)) > noise_of(max(number, 1.0)):
            raise InputError(f"start is {self.start:g} s; expected a multiple of step, {self.step:g} s, where a sample is")

    def _count_steps(self) -> None:
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


Curve = Literal["displacement", "velocity", "acceleration", "reaction", "ground_reaction", "energy", "output", "force", "phase"]


def _flag_or_names(value):
    if not isinstance(value, bool | list):
        raise InputError(f'found {shown(value)}; expected true, false or a list of coordinates, e.g. ["x1"]')
    return value


QuantityKind = Literal["force", "elongation", "rate", "displacement", "velocity", "acceleration"]


class QuantityTable(Table):
    """A force, elongation, reaction, relative motion or stress, by a name that all analyses know."""

    name: Name | None = Field(None, description="Name; by default that of the element, or of both coordinates.")
    of: Text | None = Field(
        None, description='A spring or damper by its name, of a robot a spring or a joint; or another quantity, e.g. "velocity of x", '
        '"reaction of pin", "force on ground"; or else between.'
    )  # fmt: skip
    between: Pair | None = Field(None, description='Two coordinates, e.g. ["wheel", "body"]: the second relative to the first.')
    quantity: QuantityKind | None = Field(
        None, description="Force (default), elongation or rate of an element; displacement (default) … of and between coordinates."
    )
    factor: Quantity | None = Field(None, description='A factor, e.g. "0.2 m" for the moment of a force with this arm.')
    divided_by: Quantity | None = Field(
        None, description='Alternatively or in addition, a divisor: an area or a section modulus for a stress, e.g. "40 mm^2".'
    )

    @property
    def multipliers(self) -> Iterator[tuple[float, Dimension | None]]:
        """The factor and the inverse of the divisor in SI, each with its kind."""
        if self.factor is not None:
            yield any_quantity(self.factor)
        if self.divided_by is not None:
            value, kind = any_quantity(self.divided_by)
            if not value:
                raise InputError("divided_by: found 0; expected another number")
            yield 1 / value, None if kind is None else kind.power(-1)

    def _check(self) -> None:
        if (self.of is None) == (self.between is None):
            raise InputError('give either of, the name of a spring or damper, or between, e.g. ["wheel", "body"]')
        if self.name is None and (self.factor, self.divided_by) != (None, None):
            raise InputError('name: missing; a quantity with a factor or a divisor needs one, such as "stress of the bar"')


_UNITS = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}
_UNITS_SCHEMA = {
    "examples": ["mm, deg, rpm, kN, g"],
    "anyOf": [
        *_UNITS["anyOf"],
        {"type": "object", "properties": dict.fromkeys(QUANTITIES, _UNITS), "additionalProperties": _UNITS},
    ],
}


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
    plots: list[Curve] = Field(
        ["displacement"],
        description="Plots of the page; force is that of the loads, phase the velocity over the displacement. Left out: the displacement, "
        "and first that relative to a moving support.",
    )
    coordinates: list[Name] | None = Field(None, description="Only these coordinates are plotted; left out: all.")
    quantity: list[QuantityTable] = Field([], description="Forces, elongations and relative motions for plots, CSV and npz.")
    reactions: bool = Field(False, description="Forces of constraints, and of a robot's springs, in files.")
    arrows: list[Literal["reaction"]] = Field([], description="Forces that the animation shows as arrows.")
    slow_events: bool = Field(False, description="true: the animation is slower around jumps, impulses and switches.")
    units: Annotated[OutputUnits, BeforeValidator(output_units), WithJsonSchema(_UNITS_SCHEMA)] = Field(
        OutputUnits(),
        description='Units of page, tables and CSV, e.g. "mm, deg, rpm, kN, g", or by quantity and result, e.g. '
        '{ displacement = "mm", acceleration = "g", "force of clutch" = "kN" }. Velocities and products follow; accelerations are in m/s^2 '
        "unless they have a unit of their own. SI when left out, and always in the npz file and the JSON.",
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


def _model_table(kind: str) -> Any:
    if kind == "lumped":
        from .element_tables import lumped_table

        return lumped_table()
    module = ".robot_tables" if kind == "robot" else ".model_tables"
    return LateTable(f"{kind.title().replace('-', '')}Table", module).table


def _force_table(kind: str) -> Any:
    from .force_tables import FORCES

    return FORCES[kind]


def _motion_table(kind: str) -> Any:
    from .force_tables import motion_table

    return motion_table(kind)


ForceTable = Annotated[Any, TablesByKind(_force_table, SIGNALS)]
MotionTable = Annotated[Any, TablesByKind(_motion_table, SIGNALS, "step")]
Model = Annotated[Any, TablesByKind(_model_table, ("lumped", "matrices", "robot", *CONTROL))]
Changes = Annotated[Annotated[Any, LateTable("RobotChanges", ".robot_tables")] | None, SkipValidation]
Frequency = Annotated[Any, LateTable("FrequencyTable")]
Random = Annotated[Any, LateTable("RandomTable")]
Shock = Annotated[Any, LateTable("ShockTable")]
Fatigue = Annotated[Any, LateTable("FatigueTable")]
Vary = Annotated[Any, LateTable("VaryTable")]
Boundary = Annotated[Any, LateTable("BoundaryTable", ".force_tables")]
LeastEnergy = Annotated[Any, LateTable("LeastEnergyTable", ".force_tables")]
Campbell = Annotated[Any, LateTable("CampbellTable")]
Orders = Annotated[Any, LateTable("OrdersTable")]
Steady = Annotated[Any, LateTable("SteadyTable")]
RobotPath = Annotated[Any, LateTable("PathTable")]


class SceneFile(Table):
    """A scene: a model, its initial values, the forces, the times and the output."""

    title: Text = Field("", description="Heading of the page; by default the name of the file.")
    source: Text = Field("", description="Source of the example or the data.")
    include: list[Text] | Text = Field([], description="Scene files whose tables are part of this one, relative to it.")
    parameters: Parameters = Field({}, description='Quantities by name, e.g. m = "10 kg"; "=2*m" may stand wherever a number does.')
    model: Model = Field(description="The equations.")
    robot: Changes = Field(
        None, description="Changes of the robot.toml for this scene, e.g. its gravity, stiffness, damping or payloads."
    )
    initial: InitialTable = Field(InitialTable.model_construct(), description="The values just before t = 0.")
    force: list[ForceTable] = Field([], description="Forces from t = 0 or from their delays on; entries on one coordinate add up.")
    motion: list[MotionTable] = Field([], description="Prescribed motions of coordinates: supports that move.")
    boundary: Boundary | None = Field(None, description="Values at both ends of the motion, instead of [initial]; left out: none.")
    least_energy: LeastEnergy | None = Field(
        None, description="The input of least energy from [initial] to another state; left out: none."
    )
    time: TimeTable = Field(
        cast("Any", TimeTable).model_construct(),
        description="Times of the answer; a motion needs them, modes and frequency responses do not.",
    )
    frequency: Frequency | None = Field(None, description="The frequency response that is computed, too; left out: none.")
    random: Random | None = Field(None, description="Random vibration, by the command random; left out: none.")
    shock: Shock | None = Field(None, description="Peaks under a shock, by the command shock; left out: the defaults.")
    fatigue: Fatigue | None = Field(None, description="Cycles and damage, by the command fatigue; left out: none.")
    vary: Vary | None = Field(None, description="Parameters that the commands sweep and optimise vary; left out: named there.")
    campbell: Campbell | None = Field(None, description="Speeds and orders of the command campbell; left out: the defaults.")
    orders: Orders | None = Field(
        None, description="Excitations by orders of a speed, for the commands orders and campbell; left out: none."
    )
    steady: Steady | None = Field(None, description="Period and outputs of the command steady; left out: the defaults.")
    path: RobotPath | None = Field(None, description="Path of a point of a robot, along which the command path computes its modes.")
    output: OutputTable = Field(OutputTable.model_construct(), description="Files to write, and contents of the page.")
    drawing: DrawingTable | None = Field(None, description="Drawing of the model; automatic by default.")

    @property
    def prescribed(self) -> dict[str, str]:
        """The coordinates of [[motion]] by the names of the constraint rows that prescribe them."""
        return {name: coordinate for motion in self.motion for name, (coordinate, _) in motion.rows.items()}

    @classmethod
    def _hint(cls, key: str) -> str:
        if key not in _model_table("lumped").model_fields:
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

    def _check(self) -> None:
        if self.robot is not None and self.model.kind != "robot":
            raise InputError('robot changes the robot.toml of kind = "robot"; leave it out')
        if self.output.still is not None and self.time.is_given and not self.time.start <= self.output.still <= self.time.end:
            still, end = f"{self.output.still:g} s", f"{self.time.end:g} s"
            raise InputError(f"output.still is {still}; expected a time from {self.time.start:g} to time.end, which is {end}")
        if self.boundary is not None or self.least_energy is not None:
            self._check_end()
        if self.initial.state and self.model.kind not in CONTROL:
            raise InputError('initial.state belongs to kind = "state-space"; give displacement and velocity')

    def _check_end(self) -> None:
        if self.boundary is not None and self.least_energy is not None:
            raise InputError("boundary and least_energy both decide the end of the motion; leave out one of them")
        own = "boundary" if self.least_energy is None else "least_energy"
        if self.boundary is not None and self.initial.model_fields_set:
            raise EntryError(
                "initial: boundary has the values at both ends; write those at the start as [boundary.start]", "initial"
            )
        if self.time.step_domain == "discrete":
            raise InputError(f'{own} needs a motion between samples, which step_domain = "discrete" has not; leave it out')
        if self.model.kind == "transfer-function" or getattr(self.model, "normal_form", False):
            kind = "a transfer function" if self.model.kind == "transfer-function" else "a normal form"
            raise InputError(f"{own} needs coordinates or states, and {kind} has others; write a state space")


#: Location of the schema of a scene, and of a robot.toml: in the same folder, under this name.
SCHEMA_FILE, ROBOT_SCHEMA_FILE = "mbconstrained.schema.json", "robot.schema.json"
EDITORS = """{file} is written. An editor with TOML support (in VS Code the extension Even Better TOML) uses it for a
{what} in the same folder that begins with the line

#:schema ./{name}"""


def schema_text(*, robot: bool = False) -> str:
    return json.dumps(robot_schema() if robot else scene_schema(), indent=2, ensure_ascii=False)


def scene_schema() -> dict:
    """The schema as plain data: JSON Schema 2020-12, with title and description of every key, with the unit of quantities.

    >>> stiffness = scene_schema()["$defs"]["SpringTable"]["properties"]["stiffness"]
    >>> stiffness["unit"], stiffness["examples"][0]
    ('N/m', '3 N/mm')
    """
    schema = _schema(SceneFile, "A scene of mbconstrained")
    whole = schema.pop("required")
    return {**schema, "anyOf": [{"required": whole}, {"required": ["include"]}]}  # an included file may have the model


def robot_schema() -> dict:
    """The schema of a robot.toml, as plain data.

    >>> robot_schema()["required"]
    ['urdf']
    """
    from .robot_tables import RobotFile

    return _schema(RobotFile, "A robot.toml of mbconstrained")


def _schema(of: type[BaseModel], title: str) -> dict:
    schema = of.model_json_schema()
    for table in (schema, *schema["$defs"].values()):
        for key, entry in table.get("properties", {}).items():
            _complete(key, entry)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema, "title": title}


def _complete(key: str, entry: dict) -> None:
    """Add a title to a key, and the kind of quantity to its description."""
    entry.setdefault("title", key.replace("_", " ").capitalize())
    alternatives = [entry, *entry.get("anyOf", ())]
    quantity = next((each for each in (*alternatives, *(each.get("items", {}) for each in alternatives)) if each.get("unit")), None)
    if quantity is None:
        return
    unit = quantity["unit"]
    entry |= {"unit": unit, "examples": quantity["examples"]}
    what = "A plain number" if unit == "1" else f"In {unit}, or a text with a unit of {KINDS[unit][0]}, such as {KINDS[unit][1]}"
    if "description" in entry:
        entry["description"] += f" {what}."
