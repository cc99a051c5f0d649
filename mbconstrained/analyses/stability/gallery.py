"""The gallery of stiff and extreme systems: families of problems with one difficulty that grows with a parameter, and their properties.

The systems are data in ``gallery.toml``, their equations in ``problems``. Those of the theme "small next to large" are solved for times at
which the small quantity decides the answer: after the strong part has decayed, or after long growth.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import nearest
from ...ground.errors import InputError, MbconstrainedError
from ...ground.notices import NoticeKind
from ...mechanics.element_matrix import ElementMatrix
from ..study_problem import StudyProblem
from . import problems

if TYPE_CHECKING:
    from ...exact.enclosure.exact_response import ExactResponse
    from ...exact.engine import ExactStructure


@dataclass(frozen=True)
class System:
    """A family of problems, in the manner of NLEVP (Betcke, Higham, Mehrmann, Schroeder and Tisseur 2013)."""

    name: str  # for the command line; that of the function in ``problems``
    theme: str  # the chapter of the gallery
    title: str  # what it is
    difficulty: str  # in one sentence
    parameter: str  # with its unit if it has one
    values: tuple[float, ...]  # values of the parameter, from harmless to extreme, most of them over decades; 0 is the limit itself
    source: str = "made for this gallery"  # a section of a paper or a referee case
    declared: Mapping[str, object] = field(default_factory=dict, repr=False)  # known properties, by the names of ``PROPERTIES``
    #: those that depend on the parameter, one for each of its values
    declared_by_value: Mapping[str, list] = field(default_factory=dict, repr=False)

    def build(self, value: float) -> StudyProblem:
        """The problem for a value of the parameter, with the title of the system."""
        return replace(getattr(problems, self.name)(value), title=self.title)

    def declared_at(self, value: float) -> dict[str, object]:
        """The properties for one of the values."""
        place = self.values.index(value)
        return {**self.declared, **{name: each[place] for name, each in self.declared_by_value.items()}}


#: All systems, by themes.
GALLERY: tuple[System, ...] = tuple(
    System(name, **{**table, "values": tuple(table["values"])})
    for name, table in tomllib.loads(Path(__file__).with_name("gallery.toml").read_text(encoding="utf-8")).items()
)


def system(name: str) -> System:
    """The system with this name.

    >>> system("resonance").parameter
    'detuning of the force'
    """
    systems = {one.name: one for one in GALLERY}
    if name not in systems:
        raise InputError(f"gallery: there is no system {name!r}{nearest(str(name), systems)}; known are {', '.join(systems)}")
    return systems[name]


# --- declared properties, by exact arithmetic

#: Ratios are quotients of rounded numbers.
RATIO = 1e-12


class Facts:
    """Exact properties of a problem, computed on demand."""

    def __init__(self, problem: StudyProblem):
        self.problem = problem

    @cached_property
    def structure(self) -> ExactStructure:
        from ...exact import structure

        return structure(self.problem.polynomial_matrix)

    @cached_property
    def exact(self) -> ExactResponse:
        """The answer, with the constraint rows as given."""
        return self.problem.solve().exact

    @property
    def zeros(self) -> list[complex]:
        """All finite zeros except 0, one of each conjugate pair."""
        return [zero.value for zero in self.structure.finite_zeros if zero.value]

    def elements_of(self, power: int) -> np.ndarray:
        """The constants of the elements of K, C or M that are not zero, or the diagonal of a matrix."""
        given = self.problem.system.given[power]
        constants = given.constants if isinstance(given, ElementMatrix) else np.diag(given)
        return np.abs(constants[constants != 0])


def _ratio(values) -> float:
    return float(max(values) / min(values))


def _symmetric(facts: Facts) -> bool:
    system, A = facts.problem.system, facts.problem.polynomial_matrix
    matrices = list(A.coefficients) if system is None else [system.stiffness, system.damping, system.mass]
    return all(np.array_equal(matrix, matrix.T) for matrix in matrices)


#: By name; each is a function of the facts.
PROPERTIES: dict[str, Callable[[Facts], object]] = {
    "finite_zeros": lambda facts: facts.exact.matrix.determinant.degree(),
    "infinite_divisors": lambda facts: [degree for degree in facts.structure.infinite_divisors if degree],
    "infinite_order": lambda facts: facts.structure.highest_impulse,
    "longest_chain": lambda facts: max(max(zero.partial_multiplicities) for zero in facts.structure.finite_zeros),
    "zeros_at_0": lambda facts: sum(zero.multiplicity for zero in facts.structure.finite_zeros if zero.value == 0),
    "growing_zeros": lambda facts: sum(value.real > 0 for value in facts.zeros),
    "undamped": lambda facts: all(value.real == 0 for value in facts.zeros),
    "decades": lambda facts: round(math.log10(_ratio([abs(value) for value in facts.zeros]))),
    "symmetric": _symmetric,
    "jumps": lambda facts: bool(np.any(facts.exact.jump != 0)),
    "impulses": lambda facts: len(facts.exact.impulses),
    "stiffness_ratio": lambda facts: _ratio(facts.elements_of(0)),
    "mass_ratio": lambda facts: _ratio(facts.elements_of(2)),
    "redundant_rows": lambda facts: sum(notice.kind == NoticeKind.REDUNDANT for notice in facts.problem.system.notices),
}


def broken_promises(system: System, parameter: float) -> tuple[str, ...]:
    """The declared properties that exact arithmetic refutes."""
    place, broken = f"{system.name} at {parameter:g}", []
    try:
        facts = Facts(system.build(parameter))
    except MbconstrainedError as refusal:
        return (f"{place}: there is no problem ({refusal})",)
    for name, declared in system.declared_at(parameter).items():
        try:
            value = PROPERTIES[name](facts)
        except MbconstrainedError as refusal:
            value = f"not known ({refusal})"
        if not _same(value, declared):
            broken.append(f"{place}: {name} is {value}, declared {declared}")
    return tuple(broken)


def _same(value, declared) -> bool:
    if isinstance(value, float) and isinstance(declared, float):
        return math.isclose(value, declared, rel_tol=RATIO)
    return value == declared
