"""What of a scene can be turned up and down by factors: its masses, dampers, springs, coefficients and its horizon."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from ...mechanics import ElementMatrix
from ...polynomial import PolynomialMatrix
from ...polynomial.factors import Factors
from ...scene import Scene
from ...scene.equations import equations_of
from ..problem import Problem, again, given_of, mechanical_problem, problem_of
from ..truth import chosen_places

#: So many elements of a lumped model are turned one by one; those of larger models only all together.
MOST_ELEMENTS = 12

#: The times at which a problem is solved; so many of those of the scene.
TIMES = 25

#: The tables of a lumped model and what each entry of them is turned by.
ELEMENTS = {
    "mass": "mass",
    "inertia": "inertia",
    "damper": "damping",
    "torsion_damper": "damping",
    "spring": "stiffness",
    "torsion_spring": "stiffness",
}

#: What all of a kind are called together.
ALL = {"mass": "all masses", "inertia": "all inertias", "damping": "all dampers", "stiffness": "all springs"}


@dataclass(frozen=True)
class Knob:
    """One thing that is turned.

    Attributes:
        name: such as "stiffness of soft".
        turned: the problem with it multiplied by a factor.
    """

    name: str
    turned: Callable[[float], Problem]


def knobs_of(scene: Scene) -> tuple[Knob, ...]:
    """All that a scene has: what its model is made of, and its horizon.

    >>> from mbconstrained.scene import read_scene
    >>> [knob.name for knob in knobs_of(read_scene("examples/stiff_stack.toml"))][-1]
    'horizon'
    """
    whole = problem_of(scene)
    problem = whole.at(whole.times[chosen_places(len(whole.times), TIMES)])
    return (*_model_knobs(scene, problem), Knob("horizon", lambda factor: problem.at(problem.times * factor)))


def _model_knobs(scene: Scene, problem: Problem) -> Iterator[Knob]:
    if scene.equations.model is not None:
        yield from _lumped_knobs(scene, problem)
    elif problem.system is not None:
        yield from _system_knobs(problem)
    elif problem.respond is not None:
        yield from _transfer_knobs(scene, problem)
    else:
        yield from _coefficient_knobs(problem)


def _lumped_knobs(scene: Scene, problem: Problem) -> Iterator[Knob]:
    """All masses, all dampers, all springs; and each by itself where there are several, but not too many."""
    entries = [(table, place) for table in ELEMENTS for place in range(len(getattr(scene.table.model, table)))]
    for what, all_of_them in ALL.items():
        mine = [entry for entry in entries if ELEMENTS[entry[0]] == what]
        if mine:
            yield _lumped_knob(scene, problem, all_of_them if len(mine) > 1 else _title(scene, mine[0]), mine)
        if 1 < len(mine) and len(entries) <= MOST_ELEMENTS:
            for entry in mine:
                yield _lumped_knob(scene, problem, _title(scene, entry), [entry])


def _title(scene: Scene, entry: tuple[str, int]) -> str:
    """By name or by the two ends; of several without a name between the same ends also which of them it is."""
    table, place = entry
    called = [found.name or " to ".join(found.between) for found in getattr(scene.table.model, table)]
    mine = called[place]
    number = f" ({called[: place + 1].count(mine)})" if called.count(mine) > 1 else ""
    return f"{ELEMENTS[table]} of {mine}{number}"


def _lumped_knob(scene: Scene, problem: Problem, name: str, entries: list[tuple[str, int]]) -> Knob:
    def turned(factor: float) -> Problem:
        model = scene.table.model
        for table, place in entries:
            found, key = list(getattr(model, table)), ELEMENTS[table]
            found[place] = found[place].model_copy(update={key: float(getattr(found[place], key)) * factor})
            model = model.model_copy(update={table: found})
        return _read_again(scene, scene.table.model_copy(update={"model": model})).at(problem.times)

    return Knob(name, turned)


def _transfer_knobs(scene: Scene, problem: Problem) -> Iterator[Knob]:
    """The denominator, answered as ``run`` answers it: from rest, in its own way."""
    given = scene.table.model.denominator
    for place, coefficient in reversed(list(enumerate(given))):
        if float(coefficient):
            yield _transfer_knob(scene, problem, f"denominator's coefficient of s^{len(given) - 1 - place}", place)


def _transfer_knob(scene: Scene, problem: Problem, name: str, place: int) -> Knob:
    def turned(factor: float) -> Problem:
        denominator = [float(each) * factor if i == place else each for i, each in enumerate(scene.table.model.denominator)]
        table = scene.table.model_copy(update={"model": scene.table.model.model_copy(update={"denominator": denominator})})
        return _read_again(scene, table).at(problem.times)

    return Knob(name, turned)


def _read_again(scene: Scene, table) -> Problem:
    equations = equations_of(table, scene.path.parent, scene.path.name)
    return problem_of(replace(scene, table=table, equations=equations))


def _system_knobs(problem: Problem) -> Iterator[Knob]:
    for place, name in ((2, "mass"), (1, "damping"), (0, "stiffness")):
        given = problem.system.given[place]
        if np.any(given.matrix if isinstance(given, ElementMatrix) else given):
            yield Knob(name, lambda factor, place=place: _with_system(problem, place, factor))


def _with_system(problem: Problem, place: int, factor: float) -> Problem:
    """The problem with K, C or M (place 0, 1, 2) multiplied."""
    given, doubt = list(problem.system.given), list(problem.system.uncertainty)
    found = given[place]
    given[place] = ElementMatrix(found.directions, found.constants * factor) if isinstance(found, ElementMatrix) else found * factor
    doubt[place] = doubt[place] * factor
    return mechanical_problem(
        problem.title, again(problem.system, given, doubt), problem.times, *problem.initial, force=problem.applied
    )


def _coefficient_knobs(problem: Problem) -> Iterator[Knob]:
    for power, matrix in enumerate(problem.polynomial_matrix.coefficients):
        if np.any(matrix):
            yield Knob(f"coefficient of s^{power}", lambda factor, power=power: _with_coefficient(problem, power, factor))


def _with_coefficient(problem: Problem, power: int, factor: float) -> Problem:
    A = problem.polynomial_matrix
    given = given_of(A)
    found = given[power]
    given[power] = replace(found, values=found.values * factor) if isinstance(found, Factors) else found * factor
    return replace(problem, polynomial_matrix=PolynomialMatrix(given, A.coordinates, A.equations), respond=None)
