"""A system of the gallery: a family of problems with one difficulty that grows with a parameter, and helpers to build them."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ....mechanics.element_matrix import ElementMatrix
from ....mechanics.system import MechanicalSystem
from ....polynomial.polynomial_matrix import PolynomialMatrix
from ....signals.impulsive import ImpulsiveSmooth
from ....signals.inputs import zero
from ...study_problem import StudyProblem, mechanical_problem


@dataclass(frozen=True)
class System:
    """A family of problems, in the manner of NLEVP (Betcke, Higham, Mehrmann, Schroeder and Tisseur 2013).

    Attributes:
        theme: the chapter of the gallery.
        parameter: with its unit if it has one.
        values: values of the parameter, from harmless to extreme, most of them over decades; 0 is the limit itself.
        problem: the problem for a value of the parameter. Its docstring has the title, the difficulty in one sentence, and the
            source, a section of a paper or a referee case, or without one "made for this gallery".
        declared: known properties, by the names of ``properties``: a value, or a function of the parameter.
    """

    theme: str
    parameter: str
    values: tuple[float, ...]
    problem: Callable[[float], StudyProblem] = field(repr=False)
    declared: Mapping[str, object] = field(repr=False)

    @property
    def name(self) -> str:
        """Name for the command line: that of the function."""
        return self.problem.__name__

    @property
    def texts(self) -> list[str]:
        """Title, difficulty and source."""
        parts = [" ".join(part.split()) for part in inspect.getdoc(self.problem).split("\n\n")]
        title, difficulty, source = parts if len(parts) == 3 else (*parts, "made for this gallery")
        return [title.rstrip("."), difficulty, source.removeprefix("Source: ").rstrip(".")]

    def build(self, value: float) -> StudyProblem:
        """The problem for a value of the parameter, with the title of the system."""
        return replace(self.problem(value), title=self.texts[0])

    def declared_at(self, parameter: float) -> dict[str, object]:
        """The properties for a value of the parameter."""
        return {name: value(parameter) if callable(value) else value for name, value in self.declared.items()}


#: All systems, in the order of their definitions.
SYSTEMS: list[System] = []


def family(theme: str, parameter: str, values: tuple[float, ...], unit: str = ""):
    """Decorator that adds a function that builds a problem to the gallery."""

    def entered(problem: Callable[[float], StudyProblem]) -> Callable[[float], StudyProblem]:
        named = f"{parameter} in {unit}" if unit else parameter
        SYSTEMS.append(System(theme, named, values, problem, getattr(problem, "declared", {})))
        return problem

    return entered


def declares(**properties):
    """Decorator with the known properties of a system, by the names of ``properties``: values, or functions of the parameter."""

    def declared(problem: Callable[[float], StudyProblem]) -> Callable[[float], StudyProblem]:
        problem.declared = properties  # type: ignore[attr-defined]
        return problem

    return declared


def decades(first: int, last: int, step: int = 1) -> tuple[float, ...]:
    """Powers of ten.

    >>> decades(-4, 0, 2), decades(0, -2)
    ((0.0001, 0.01, 1.0), (1.0, 0.1, 0.01))
    """
    step = step if last >= first else -step
    return tuple(float(f"1e{power}") for power in range(first, last + (1 if step > 0 else -1), step))


#: A spring or damper: its two ends, bodies by number from 1, the ground is 0; its constant.
Link = tuple[int, int, float]


def spaced(first: float, last: float, count: int = 10) -> np.ndarray:
    """Times in geometric progression."""
    return np.array([first * (last / first) ** (place / (count - 1)) for place in range(count)])


def _elements(size: int, links: Sequence[Link]) -> ElementMatrix:
    """B^T diag(k) B of springs or dampers."""
    directions = np.zeros((len(links), size + 1))
    for row, (start, end, _) in zip(directions, links):
        row[start], row[end] = -1.0, 1.0
    return ElementMatrix(directions[:, 1:], [constant for *_, constant in links])


def bodies(masses: Sequence[float], springs: Sequence[Link], dampers: Sequence[Link] = (), constraints=()) -> MechanicalSystem:
    """Bodies along one axis, by their elements, so that soft ones keep their digits next to stiff ones."""
    n = len(masses)
    damping = _elements(n, dampers) if dampers else None
    return MechanicalSystem(ElementMatrix(np.eye(n), masses), damping, _elements(n, springs), constraints)


def assembled(system: MechanicalSystem) -> MechanicalSystem:
    """The system with assembled float64 matrices."""
    return MechanicalSystem(system.mass, system.damping, system.stiffness, system.constraints)


def chain(*constants: float) -> list[Link]:
    """Links from the ground to body 1, to body 2, and so on."""
    return [(place, place + 1, constant) for place, constant in enumerate(constants)]


def moving(system: MechanicalSystem, times, start, force: ImpulsiveSmooth | None = None) -> StudyProblem:
    """The problem of a mechanical system."""
    return mechanical_problem("", system, times, *start, force=force)


def equations(coefficients, start, times, force: ImpulsiveSmooth | None = None) -> StudyProblem:
    """The problem A(d/dt) x = f."""
    A = PolynomialMatrix([np.asarray(matrix, dtype=float) for matrix in coefficients])
    initial = np.asarray(start, dtype=float).reshape(A.degree, A.size)
    return StudyProblem("", A, initial, zero(A.size) if force is None else force, np.asarray(times, dtype=float))
