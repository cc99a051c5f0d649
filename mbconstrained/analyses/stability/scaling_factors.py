"""Scaling factors of a scene, on its masses, dampers, springs, coefficients and horizon, and sweeps over them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial

import numpy as np

from ...mechanics.element_matrix import ElementMatrix
from ...polynomial.coefficients import Factors
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...scene.build.equations import equations_of
from ...scene.run.scene import Scene
from ..study_problem import StudyProblem, again, chosen_places, given_of, mechanical_problem, problem_of
from .point import Point

#: Most elements of a lumped model that are scaled one by one; those of larger models only all together.
MOST_ELEMENTS = 12

#: Number of times of the scene at which a problem is solved.
TIMES = 25

#: The tables of a lumped model and the scaled parameter of their entries.
ELEMENTS = {
    "mass": "mass",
    "inertia": "inertia",
    "damper": "damping",
    "torsion_damper": "damping",
    "spring": "stiffness",
    "torsion_spring": "stiffness",
}

#: Names of all elements of a kind.
ALL = {"mass": "all masses", "inertia": "all inertias", "damping": "all dampers", "stiffness": "all springs"}


Scaled = Callable[[float], StudyProblem]


def scaling_factors(scene: Scene) -> dict[str, Scaled]:
    """The problem as a function of a factor, for each parameter of the model that can be scaled and for the horizon.

    >>> from mbconstrained import read_scene
    >>> list(scaling_factors(read_scene("examples/stiff_stack.toml")))[-1]
    'horizon'
    """
    whole = problem_of(scene)
    problem = whole.at(whole.times[chosen_places(len(whole.times), TIMES)])
    if scene.equations.model is not None:
        factors = _lumped_factors(scene, problem)
    elif problem.system is not None:
        factors = _system_factors(problem)
    elif problem.respond is not None:
        factors = _transfer_factors(scene, problem)
    else:
        factors = _coefficient_factors(problem)
    return {**dict(factors), "horizon": lambda factor: problem.at(problem.times * factor)}


def _lumped_factors(scene: Scene, problem: StudyProblem) -> Iterator[tuple[str, Scaled]]:
    """All masses, all dampers, all springs; and each separately where there are several, but not too many."""
    entries = [(table, place) for table in ELEMENTS for place in range(len(getattr(scene.table.model, table)))]
    for kind, all_of_them in ALL.items():
        mine = [entry for entry in entries if ELEMENTS[entry[0]] == kind]
        if mine:
            name = all_of_them if len(mine) > 1 else _title(scene, mine[0])
            yield name, partial(_with_elements, scene, problem, mine)
        if 1 < len(mine) and len(entries) <= MOST_ELEMENTS:
            yield from ((_title(scene, entry), partial(_with_elements, scene, problem, [entry])) for entry in mine)


def _title(scene: Scene, entry: tuple[str, int]) -> str:
    """Title of an entry: its name or its two ends, with a number for several without a name between the same ends."""
    table, place = entry
    names = [entry.name or f"{entry.start} to {entry.end}" for entry in getattr(scene.table.model, table)]
    name = names[place]
    number = f" ({names[: place + 1].count(name)})" if names.count(name) > 1 else ""
    return f"{ELEMENTS[table]} of {name}{number}"


def _with_elements(scene: Scene, problem: StudyProblem, entries: list[tuple[str, int]], factor: float) -> StudyProblem:
    model = scene.table.model
    for table, place in entries:
        rows, key = list(getattr(model, table)), ELEMENTS[table]
        rows[place] = rows[place].model_copy(update={key: float(getattr(rows[place], key)) * factor})
        model = model.model_copy(update={table: rows})
    return _with_model(scene, problem, model)


def _with_model(scene: Scene, problem: StudyProblem, model) -> StudyProblem:
    table = scene.table.model_copy(update={"model": model})
    equations = equations_of(table, scene.folder, scene.file_name)
    return problem_of(replace(scene, table=table, equations=equations)).at(problem.times)


def _transfer_factors(scene: Scene, problem: StudyProblem) -> Iterator[tuple[str, Scaled]]:
    """The denominator, with the method of ``run``: from rest."""
    model = scene.table.model
    given = [float(coefficient) for coefficient in model.denominator]

    def scaled(place: int, factor: float) -> StudyProblem:
        denominator = [*given[:place], given[place] * factor, *given[place + 1 :]]
        return _with_model(scene, problem, model.model_copy(update={"denominator": denominator}))

    for place, coefficient in reversed(list(enumerate(given))):
        if coefficient:
            yield f"denominator's coefficient of s^{len(given) - 1 - place}", partial(scaled, place)


def _system_factors(problem: StudyProblem) -> Iterator[tuple[str, Scaled]]:
    for place, name in ((2, "mass"), (1, "damping"), (0, "stiffness")):
        given = problem.system.given[place]
        if np.any(given.matrix if isinstance(given, ElementMatrix) else given):
            yield name, partial(_with_matrix, problem, place)


def _with_matrix(problem: StudyProblem, place: int, factor: float) -> StudyProblem:
    """The problem with K, C or M (place 0, 1, 2) multiplied."""
    given, doubt = list(problem.system.given), list(problem.system.uncertainty)
    matrix = given[place]
    scaled = ElementMatrix(matrix.directions, matrix.constants * factor) if isinstance(matrix, ElementMatrix) else matrix * factor
    given[place], doubt[place] = scaled, doubt[place] * factor
    system = again(problem.system, given, doubt)
    return mechanical_problem(problem.title, system, problem.times, *problem.initial, force=problem.applied)


def _coefficient_factors(problem: StudyProblem) -> Iterator[tuple[str, Scaled]]:
    for power, matrix in enumerate(problem.polynomial_matrix.coefficients):
        if np.any(matrix):
            yield f"coefficient of s^{power}", partial(_with_coefficient, problem, power)


def _with_coefficient(problem: StudyProblem, power: int, factor: float) -> StudyProblem:
    A = problem.polynomial_matrix
    given = given_of(A)
    matrix = given[power]
    given[power] = replace(matrix, values=matrix.values * factor) if isinstance(matrix, Factors) else matrix * factor
    return replace(problem, polynomial_matrix=PolynomialMatrix(given, A.coordinates, A.equations), respond=None)


@dataclass(frozen=True)
class ScalingSweep:
    """Points over one parameter."""

    name: str  # name of the scaling factor, or of the system of the gallery
    title: str  # for headings
    theme: str  # chapter of the gallery
    difficulty: str  # of a system of the gallery, in a sentence
    source: str  # source of a system of the gallery
    parameter: str  # with its unit if it has one
    points: tuple[Point, ...]  # in the order of the parameter
    broken: tuple[str, ...] = ()  # declared properties of a system of the gallery that exact arithmetic does not confirm

    def count(self, verdict: str) -> int:
        """Number of points with a verdict: right, warned, refused, not judged or wrong."""
        return sum(point.verdict == verdict for point in self.points)

    @property
    def answers(self) -> tuple[Point, ...]:
        """The points whose answer was compared with exact arithmetic."""
        return tuple(point for point in self.points if point.right is not None)

    def to_dict(self) -> dict:
        texts = {name: value for name, value in asdict(replace(self, points=())).items() if isinstance(value, str)}
        return {**texts, "broken": list(self.broken), "points": [point.to_dict() for point in self.points]}
