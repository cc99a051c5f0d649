"""A scene: a validated file with its equations, that can be planned and run."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from types import MethodType
from typing import TYPE_CHECKING, Any, ClassVar

from ...analyses import ANALYSES, load
from ...ground.by_name import answering
from ...ground.checks import nearest
from ...ground.errors import InputError, SingularPolynomialMatrix, shown
from ...ground.files import path_of
from ...ground.quantities import count_texts
from ...ground.units import unit_in_si
from ..build.equations import equations_of
from ..build.model import Equations, named_quantities, output_names, quantities_by_name
from ..coordinates import QUANTITIES, OutputUnits
from ..file import SceneFolder, SceneName, Setting, at, read_tables, with_robot_file, with_settings, with_values
from ..parameters import Parameters, with_parameters
from ..schema.entry_types import validated
from ..schema.scene_schema import SceneFile
from .plan import Costs
from .scene_data import SceneData
from .stages import plan_of

if TYPE_CHECKING:
    from ...analyses.base import Answer
    from ...mechanics.parameter import Parameter
    from ...mechanics.root_locus import RootLocus
    from ...mechanics.sensitivities import Sensitivities
    from ...mechanics.system import MechanicalSystem
    from .plan import Plan


@answering
@dataclass(frozen=True, repr=False)
class Scene(SceneData):
    """A scene that was read, validated and assembled, but not solved; ``read_scene`` gives one.

    Every analysis is a method: ``scene.modes()``, ``scene.frequency(...)``, ``scene.shock(...)``. It takes the entries of its table in
    scene files by name, numbers in SI or texts with units, and gives an ``Answer``; what is not given stands in the table.

    >>> scene = read_scene("examples/two_masses.toml")
    >>> scene.modes()
    Answer(modes of two_masses)

    Attributes:
        path: the file.
        table: the validated content, in SI.
        equations: its equations.
        unit_texts: number of quantities written with a unit.
        costs: costs of the stages of reading, from the file to the staircase, by name.
        parameters: the named quantities, which everywhere else stand with their values.
        settings: values set from outside.
        file_name: of the file, in messages; it knows what comes from other files.
    """

    _instead: ClassVar = {
        "eigenvalues": "system.modes().eigenvalues",
        "frequency_response": "system.frequency_response",
        "motion": "run().motion",
        "names": "equations.coordinates.names",
        "random_response": "system.random_response",
        "simulate": "run",
        "solve": "run",
        "steady_state": "system.steady_state",
    }
    _factory: ClassVar = 'mb.read_scene("FILE.toml")'

    if TYPE_CHECKING:

        def __getattr__(self, name: str) -> Callable[..., Answer]:
            """The methods ``modes``, ``frequency``, ``shock`` ... of the analyses, which are set below."""

    @property
    def system(self) -> MechanicalSystem:
        """The mechanical system of the model.

        Raises:
            InputError: the model is a state space or a transfer function.
        """
        if self.equations.system is None:
            raise InputError("there is no mechanical system: that is a model of kind lumped, matrices or robot")
        return self.equations.system

    def plan(self) -> Plan:
        """The possible stages of this scene, needed or not, each with its reason."""
        return plan_of(self)

    def named_parameters(self) -> Iterator[Parameter]:
        """The [parameters] with the derivatives of the equations, for ``MechanicalSystem.sensitivities``.

        Raises:
            InputError: the scene has no mechanical system.
        """
        from ..build.symbolic_scene import scene_parameters

        before = {setting.name: setting.value for setting in self.settings}
        return scene_parameters(self, lambda scene, name, value: read_scene(scene.path, {**before, name: value}, self.data_folders))

    def sensitivities(self, parameters: Sequence[str] | None = None) -> Sensitivities:
        """Derivatives of eigenvalues, motions and responses with respect to the [parameters], or to elements and entries by name.

        Args:
            parameters: names; all [parameters] by default, all elements or entries where there are none.

        Returns:
            See ``MechanicalSystem.sensitivities``.

        Raises:
            InputError: the scene has no mechanical system, an unknown name.

        >>> scene = read_scene("examples/two_masses.toml")
        >>> scene.sensitivities(["stiffness[x1, x1]"]).natural_frequencies.shape
        (1, 2)
        """
        named = {one.name: one for one in self.named_parameters()}
        chosen = list(named) or None if parameters is None else parameters
        return self.equations.system.sensitivities(chosen and [named.get(name, name) for name in chosen])

    def root_locus(self, name: str, values) -> RootLocus:
        """The eigenvalues over one of the [parameters], or over an element or entry by name.

        Args:
            name: name of the parameter.
            values: in SI, ascending, two or more.

        Returns:
            See ``MechanicalSystem.root_locus``.

        Raises:
            InputError: the scene has no mechanical system, an unknown name.

        >>> scene = read_scene("examples/tuned_mass_damper.toml")
        >>> len(scene.root_locus("zeta", [0.1, 1.0, 2.0]).break_points)
        1
        """
        from ...mechanics.root_locus import root_locus_of

        if name not in self.parameters.values:
            if self.equations.system is None:
                raise InputError("a root locus needs mass, damping and stiffness: a model of kind lumped, matrices or robot")
            return self.equations.system.root_locus(name, values)
        before = {setting.name: setting.value for setting in self.settings}
        with_value = lru_cache(maxsize=None)(lambda value: read_scene(self.path, {**before, name: value}, self.data_folders))

        def slope(value: float) -> Parameter:
            return next(one for one in with_value(value).named_parameters() if one.name == name)

        unit = self.parameters.units[name]
        return root_locus_of(name, unit, values, lambda value: with_value(value).equations.system, slope)

    def sweep(self, parameters: Mapping[str, Any] | None = None, **options) -> Any:
        """A study of many samples of parameters, which its method ``run`` computes.

        Args:
            parameters: values, ranges or distributions by name, added to those of the table [vary].
            options: other entries of the table [vary] by name.

        Returns:
            The ``Sweep``.

        Raises:
            InputError: a parameter that the scene does not use, an unknown quantity to keep.

        >>> import mbconstrained as mb
        >>> scene = mb.read_scene("examples/tuned_mass_damper.toml")
        >>> study = scene.sweep({"zeta": mb.linspace(0.1, 0.2, 3)}, keep=["response peaks"])
        >>> study, study.run().values("response peak")[:, 0].round(7).tolist()
        (Sweep(tuned_mass_damper, 3 samples of zeta), [7.13e-05, 6.64e-05, 8.38e-05])
        """
        return load("sweep").study(self, parameters, **options)

    def optimise(self, parameters: Mapping[str, Any] | None = None, **options) -> Any:
        """Minimise or maximise a scalar quantity over parameters between bounds.

        Args:
            parameters: ranges by name, added to those of the table [vary].
            options: ``minimise`` or ``maximise``, the name of the quantity; ``seed`` of the random numbers.

        Returns:
            The ``Optimum``.

        Raises:
            InputError: no quantity or several, a parameter without a range.

        >>> import mbconstrained as mb
        >>> scene = mb.read_scene("examples/tuned_mass_damper.toml")
        >>> round(scene.optimise({"zeta": "0.1..0.2"}, minimise="response peak machine by machine").parameters["zeta"], 4)
        0.1339
        """
        return load("optimise").optimum(self, parameters, **options)

    def run(self, folder: str | Path | None = None, progress=None) -> Any:
        """Solve the scene by the stages of its plan, each of which is measured.

        On Linux the highest resident memory of the process, as the system keeps it, is set back at the start of each stage.

        Args:
            folder: folder of the requested page, CSV and npz; None writes nothing.
            progress: called with each stage as it begins.

        Returns:
            The ``RunAnswer`` with curves, evidence, notices and the plan with its costs.

        Raises:
            MbconstrainedError: the equations have no answer, or none within the range of float64.
        """
        return load("run").answer(self, progress, folder=None if folder is None else path_of(folder, "folder"))


@dataclass(frozen=True)
class Question:
    """The method of a scene that answers an analysis, whose module is imported when the method is first used."""

    name: str

    def __get__(self, scene: Scene | None, owner: type):
        function = load(self.name).method()
        return function if scene is None else MethodType(function, scene)


#: Names of methods that differ from those of their analyses: the attribute ``path`` is the file.
METHOD_NAMES = {"path": "robot_path"}

for _name in ANALYSES:
    if not hasattr(Scene, METHOD_NAMES.get(_name, _name)):
        setattr(Scene, METHOD_NAMES.get(_name, _name), Question(_name))


@answering
def read_scene(path: str | Path, settings: Mapping[str, Any] | None = None, data_folders: Sequence[str | Path] = ()) -> Scene:
    """Read and validate a scene file, assemble its equations and check that they determine a motion, without solving.

    Args:
        path: a TOML file in UTF-8.
        settings: values to take instead of those in the file, numbers or texts with units: by the name of a parameter, or by
            place, such as "time.end" or "model.mass.cart.mass"; "robot.gravity" changes the robot.toml of a robot.
        data_folders: folders from which records and matrices may be read in addition to the folder of the scene.

    Returns:
        The ``Scene``, ready to be planned and run.

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
    path = path_of(path)
    if not isinstance(settings or {}, Mapping):
        raise InputError(f'settings: found {settings!r}; expected values by name, such as {{"time.end": "50 s"}}')
    folders = tuple(map(path_of, [data_folders] if isinstance(data_folders, (str, Path)) else data_folders))
    for folder in folders:
        if not folder.is_dir():
            raise InputError(f"data_folders: there is no folder {folder}")
    costs = Costs()
    scene = assembled(path, *read_tables(path), settings or {}, costs, folders)
    if scene.table.drawing:
        from .drawing import check_drawing

        check_drawing(scene)
    costs.lap("assemble the model")
    try:
        scene.equations.polynomial_matrix.check_regular()
    except SingularPolynomialMatrix as problem:
        raise SingularPolynomialMatrix(f"{problem}{_choices(scene.equations)}", problem.equations, problem.coordinates) from None
    costs.lap("scaling and staircase")
    return scene


def _choices(equations: Equations) -> str:
    """Advice on free coordinates of a mechanical system with the report on its equations; empty for other models."""
    from ...response.solvability import solvability

    if equations.system is None or not equations.polynomial_matrix.is_square:
        return ""
    report = solvability(equations.polynomial_matrix, equations.initial, equations.right_hand_side)
    names = [name for name in report.may_be_chosen if name in equations.coordinates.names]
    choices = "; or ".join(f'[[motion]] with coordinate = "{name}"' for name in names)
    return f"\nA motion may be chosen by {choices}\n{report.summary()}" if names else ""


def assembled(
    path: Path,
    data: dict,
    name: SceneName,
    settings: Mapping[str, Any],
    costs: Costs | None = None,
    data_folders: tuple[Path, ...] = (),
) -> Scene:
    """The scene of tables that were read; whether its equations determine a motion is not checked yet."""
    costs = costs or Costs()
    of_robot = {key: value for key, value in settings.items() if key.startswith("robot.")}
    overrides: tuple[Setting, ...] = ()
    if settings:
        name, overrides = with_settings(data, name, {key: value for key, value in settings.items() if key not in of_robot})
    name = with_robot_file(data, name, path.parent)
    if of_robot:
        name, changes = with_settings(data, name, of_robot)
        overrides += changes
    unit_texts = count_texts({key: data[key] for key in data if key not in ("title", "source", "robot")})
    costs.lap("read the scene")
    if unit_texts:
        unit_in_si("m")  # makes the table of all spellings
        costs.lap("units")
    data, parameters = with_parameters(data, name)
    if overrides:
        name = with_values(name, overrides, parameters.places)
    table = validated(data, name, SceneFile)
    costs.lap("read the scene")
    equations = equations_of(table, SceneFolder(path.parent, data_folders), name, costs.lap)
    if table.output.units != OutputUnits():
        coordinates = replace(equations.coordinates, shown=table.output.units)
        equations = replace(equations, coordinates=coordinates)
    if table.output.units.named:
        with at(name, "output.units"):
            _check_results(table.output, equations, parameters)
    check_output(table.output, equations, name, getattr(table.model, "modal_damping", None) is not None)
    for system in (equations.system, equations.rotor) if table.output.quantity else ():
        if system is not None:
            system.quantities = quantities_by_name(table.output.quantity, output_names(equations))
    if table.time.step_domain == "discrete":
        check_discrete(table, equations, name)
    return Scene(path, table, equations, unit_texts, costs.by_name, parameters, overrides, name, data_folders=data_folders)


def _check_results(output, equations: Equations, parameters: Parameters) -> None:
    """Check that what has a unit of its own is a result or a parameter."""
    known = [*equations.coordinates.names, *parameters.values, *(load.name for load in equations.loads)]
    for several in (
        equations.outputs,
        equations.control and equations.control.inputs,
        equations.control and equations.control.outputs,
    ):
        known += several.names if several else ()
    if (system := equations.system) is not None:
        known += [*(row.name for row in system.rows), *system.elements, *system.named_directions("outputs")]
    if equations.has_connections:
        known += equations.robot_scene.system.connection_forces.names
    known += [one.name for one in named_quantities(output.quantity, output_names(equations))]
    for name, _ in output.units.named:
        if name not in known:
            hint = nearest(name, (*QUANTITIES, *known))
            raise InputError(
                f"there is no quantity or result {shown(name)}{hint}; quantities are {', '.join(QUANTITIES)}; "
                f"results are {', '.join(dict.fromkeys(known))}"
            )


def check_output(output, equations: Equations, file_name: str, modal_damping: bool = False) -> None:
    """Check that the equations have the quantities that [output] requests."""
    with at(file_name, "output.certify"):
        for name in output.certify if isinstance(output.certify, list) else ():
            equations.coordinates.number(name)
    for number, table in enumerate(output.quantity, 1):
        with at(file_name, f"output.quantity[{number}]"):
            list(named_quantities([table], output_names(equations)))
    if output.quantity:
        with at(file_name, "output.quantity"):
            quantities_by_name(output.quantity, output_names(equations))
    with at(file_name, "output.coordinates"):
        for name in output.coordinates or ():
            equations.coordinates.number(name)
    with at(file_name, "output.formula"):
        if output.formula and (model := equations.without_formula(modal_damping)):
            raise InputError(f"there is no formula with symbols for {model}; leave it out")
    with at(file_name, "output.arrows"):
        if output.arrows and not equations.has_reactions:
            raise InputError("found reaction, but there are no constraint rows; leave it out")
    with at(file_name, "output.plots"):
        if "output" in output.plots and equations.outputs is None:
            raise InputError(
                "found output, but no outputs are named; name them as [[model.output]] of a robot, give C of a state space, "
                "or leave it out"
            )
        if "energy" in output.plots and equations.without_energy:
            raise InputError(equations.without_energy)
        if "force" in output.plots and not equations.has_forces:
            raise InputError("found force, but nothing acts that has a name: give a [[force]] or [least_energy], or leave it out")
        if "ground_reaction" in output.plots and not equations.has_connections:
            raise InputError("found ground_reaction, but there is no robot with loops, springs or bushings; leave it out")
        if "reaction" in output.plots and not equations.has_reactions:
            raise InputError("found reaction, but there are no constraint rows; leave it out")


#: Entries of [output] that need a motion between the samples.
CONTINUOUS = ("certify", "formula", "still", "quantity", "formats", "arrows", "reactions")

#: Plots of samples.
SAMPLED = ("displacement", "output")


def check_discrete(table, equations: Equations, file_name: str) -> None:
    """Check that a scene in discrete time asks for nothing between its samples."""
    with at(file_name, "output"):
        for name in CONTINUOUS:
            if getattr(table.output, name):
                raise InputError(f'{name}: it needs a motion between samples, which step_domain = "discrete" has not; leave it out')
    with at(file_name, "output.plots"):
        if others := [name for name in table.output.plots if name not in SAMPLED]:
            raise InputError(f'found {", ".join(others)}; step_domain = "discrete" has plots of {" and ".join(SAMPLED)}')
    if equations.are_bare and "hold" in table.time.model_fields_set:
        with at(file_name, "time.hold"):
            raise InputError("coefficients of the shift are no continuous model that could be discretized; leave hold out")
