"""What a problem is, by exact arithmetic: against this the gallery's declared properties are checked."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ....errors import MbconstrainedError
from ....mechanics import ElementMatrix
from ...problem import Problem

if TYPE_CHECKING:
    from ....exact.enclosure import ExactResponse
    from ....exact.rational.structure import ExactStructure
    from .system import System

#: Ratios are quotients of rounded numbers.
RATIO = 1e-12


class Facts:
    """A problem as exact arithmetic sees it; what is not asked for is not computed."""

    def __init__(self, problem: Problem):
        self.problem = problem

    @cached_property
    def structure(self) -> ExactStructure:
        """Of A(s), zeros finite and infinite."""
        return self.problem.polynomial_matrix.structure(exact=True)

    @cached_property
    def exact(self) -> ExactResponse:
        """The answer, with the constraint rows as they were given."""
        return self.problem.solve().exact

    @property
    def zeros(self) -> list[complex]:
        """All finite zeros but 0, one of each conjugate pair."""
        return [zero.value for zero in self.structure.finite_zeros if zero.value]

    def elements_of(self, power: int) -> np.ndarray:
        """The constants of the elements of K, C or M that are not zero, or the diagonal of a matrix."""
        given = self.problem.system.given[power]
        constants = given.constants if isinstance(given, ElementMatrix) else np.diag(given)
        return np.abs(constants[constants != 0])


def _ratio(values) -> float:
    return float(max(values) / min(values))


def _decades(facts: Facts) -> int:
    return round(math.log10(_ratio([abs(value) for value in facts.zeros])))


def _symmetric(facts: Facts) -> bool:
    problem = facts.problem
    matrices = problem.polynomial_matrix.coefficients
    if problem.system is not None:
        matrices = (problem.system.stiffness, problem.system.damping, problem.system.mass)
    return all(np.array_equal(matrix, matrix.T) for matrix in matrices)


def _redundant(facts: Facts) -> int:
    system = facts.problem.system
    return sum(notice.kind == "redundant" for notice in system.notices)


#: By name; each is a function of the facts.
PROPERTIES: dict[str, Callable[[Facts], object]] = {
    "finite_zeros": lambda facts: facts.exact.matrix.determinant.degree(),
    "infinite_divisors": lambda facts: tuple(degree for degree in facts.structure.infinite_divisors if degree),
    "infinite_order": lambda facts: facts.structure.highest_impulse,
    "longest_chain": lambda facts: max(max(zero.partial_multiplicities) for zero in facts.structure.finite_zeros),
    "zeros_at_0": lambda facts: sum(zero.multiplicity for zero in facts.structure.finite_zeros if zero.value == 0),
    "growing_zeros": lambda facts: sum(value.real > 0 for value in facts.zeros),
    "undamped": lambda facts: all(value.real == 0 for value in facts.zeros),
    "decades": _decades,
    "symmetric": _symmetric,
    "jumps": lambda facts: bool(np.any(facts.exact.jump != 0)),
    "impulses": lambda facts: len(facts.exact.impulses),
    "stiffness_ratio": lambda facts: _ratio(facts.elements_of(0)),
    "mass_ratio": lambda facts: _ratio(facts.elements_of(2)),
    "redundant_rows": _redundant,
}


def broken_promises(system: System, parameter: float) -> tuple[str, ...]:
    """The declared properties that exact arithmetic does not find, in sentences; none where all hold.

    Raises:
        KeyError: a property that nobody knows.
    """
    place, broken = f"{system.name} at {parameter:g}", []
    try:
        facts = Facts(system.build(parameter))
    except MbconstrainedError as refusal:
        return (f"{place}: there is no problem ({refusal})",)
    for name, declared in system.declared_at(parameter).items():
        try:
            found = PROPERTIES[name](facts)
        except MbconstrainedError as refusal:
            found = f"not known ({refusal})"
        if not _same(found, declared):
            broken.append(f"{place}: {name} is {found}, declared {declared}")
    return tuple(broken)


def _same(found, declared) -> bool:
    if isinstance(found, float) and isinstance(declared, float):
        return math.isclose(found, declared, rel_tol=RATIO)
    return found == declared
