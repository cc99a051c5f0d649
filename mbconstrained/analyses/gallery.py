"""The gallery of stiff and extreme systems: families of problems with one difficulty that grows with a parameter, and their properties.

The systems are data in ``gallery.toml``, which names and describes the functions below. Those of the theme "small next to large" are solved
for times at which the small quantity decides the answer: after the strong part has decayed, or after long growth.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import comb
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..ground.checks import nearest
from ..ground.errors import InputError, MbconstrainedError
from ..ground.notices import NoticeKind
from ..mechanics.constraints import Constraint
from ..mechanics.element_matrix import ElementMatrix
from ..mechanics.system import MechanicalSystem
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import harmonic, pulse, ramp, step, term, zero
from .study_problem import StudyProblem, mechanical_problem

if TYPE_CHECKING:
    from ..exact.enclosure.exact_response import ExactResponse
    from ..exact.engine import ExactStructure


@dataclass(frozen=True)
class System:
    """A family of problems, in the manner of NLEVP (Betcke, Higham, Mehrmann, Schroeder and Tisseur 2013)."""

    name: str  # for the command line; that of its function
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
        return replace(globals()[self.name](value), title=self.title)

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
        from ..exact import structure

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


# --- parts of problems

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


# --- their problems, functions of the parameter

#: Displacements and velocities at 0-.
CHAIN_START = ([1.75, 0.0, 0.75, -0.25], [-0.25, 2.0, -0.75, -0.25])


PENALTY_START = ([-1.75, 0.75, -2.0, -0.25], [-0.5, -0.5, -0.5, -1.75])


def stiff_chain(ratio: float) -> StudyProblem:
    # Springs 1, sqrt(ratio), ratio and 3 N/m, dampers that follow them.
    middle = ratio**0.5
    springs, dampers = chain(1.0, middle, ratio, 3.0), chain(0.1, middle**0.5, middle, 0.2)
    system = bodies([1.0, 2.0, 1.5, 0.5], springs, dampers)
    return moving(system, spaced(1e-3 * ratio**-0.25, 40.0), CHAIN_START)


def stiff_chain_assembled(ratio: float) -> StudyProblem:
    problem = stiff_chain(ratio)
    return moving(assembled(problem.system), problem.times, CHAIN_START)


def penalty_link(stiffness: float) -> StudyProblem:
    springs = [*chain(3.0, stiffness, 2.0, 1.5)]
    dampers = [(0, 1, 0.1), (2, 3, 0.5), (0, 4, 0.75)]
    system = assembled(bodies([1.0, 0.0, 2.0, 0.0], springs, dampers))
    return moving(system, spaced(0.01, 40.0), PENALTY_START)


def penalty_joint(stiffness: float) -> StudyProblem:
    system = assembled(bodies([1.0, 0.0], [(0, 1, 3.0), (1, 2, stiffness), (0, 2, 2.0)]))
    return moving(system, spaced(0.01, 40.0), ([1.0, 1.0], [0.0, 0.0]))


def weak_coupling(coupling: float) -> StudyProblem:
    system = bodies([1.0, 1.0], [(0, 1, 1.0), (0, 2, 1.0), (1, 2, coupling)])
    return moving(system, spaced(1.0, min(3.0 / coupling, 1e6)), ([1.0, 0.0], [0.0, 0.0]))


START = ([1.75, 0.0, 0.75], [-0.25, 2.0, -0.75])


def nearly_massless_joint(mass: float) -> StudyProblem:
    system = bodies([1.0, mass, 0.5], chain(2.0, 3.0, 1.0), chain(0.05, 1e-6, 0.1))
    return moving(system, spaced(mass**0.5, 5.0), START)


def light_tip(mass: float) -> StudyProblem:
    system = bodies([1.0, mass], chain(1.0, 1.0))
    return moving(system, spaced(0.01, 10.0), ([1.0, 0.0], [0.0, 1.0]))


def damping_ratio(ratio: float) -> StudyProblem:
    # x'' + 4 ratio x' + 4 x = 0.
    return equations([[[4.0]], [[4.0 * ratio]], [[1.0]]], [[1.0], [-3.0]], spaced(0.01, 12.0))


def near_critical(distance: float) -> StudyProblem:
    # s^2 + 4 (1 + d) s + 4 and s^2 + 4 (1 - d) s + 4, mixed by matrices of whole numbers with determinant 1.
    one, two = 4.0 * (1 + distance), 4.0 * (1 - distance)
    damping = [[one - two, one], [one - 2 * two, one]]
    return equations([[[0, 4], [-4, 4]], damping, [[0, 1], [-1, 1]]], [[1.0, -2.0], [0.5, 3.0]], spaced(0.01, 12.0))


def heavy_damper(damping: float) -> StudyProblem:
    # x'' + c x' + x = 0, from the first moments of the fast zero to long after the slow one.
    return equations([[[1.0]], [[damping]], [[1.0]]], [[1.0], [1.0]], spaced(1 / damping, 5 * damping))


def gyroscope(rate: float) -> StudyProblem:
    mass, coriolis = 1e-9, 2e-9 * rate
    stiffness = np.diag([mass * 60000.0**2, mass * 62000.0**2])
    damping = [[1e-8, -coriolis], [coriolis, 1e-8]]
    force = harmonic([1e-7, 0.0], angular_frequency=60000.0)
    coefficients = [stiffness, damping, mass * np.eye(2)]
    return equations(coefficients, [[1e-6, 0.0], [0.0, 1e-3]], spaced(1e-6, 2.0), force)


def chain_of_masses(count: float) -> StudyProblem:
    n = int(count)
    system = bodies([1.0] * n, chain(*[1.0] * n), [(0, 1, 0.25)])
    return moving(system, spaced(0.1, 100.0, 6), (np.eye(n)[-1], np.zeros(n)))


#: Two directions at right angles in the space of three coordinates, along no axis, and rounded.
ONE, OTHER = np.array([2.0, -1.0, 2.0]) / 3, np.array([2.0, 2.0, -1.0]) / 3


def _parallel_rows(level: Literal["position", "acceleration"], angle: float) -> StudyProblem:
    rows = [ONE, np.cos(angle) * ONE + np.sin(angle) * OTHER]
    constraints = [Constraint(row, level=level, names=f"row {number}") for number, row in enumerate(rows, start=1)]
    system = MechanicalSystem(np.diag([1.0, 2.0, 3.0]), stiffness=np.diag([4.0, 5.0, 7.0]), constraints=constraints)
    return moving(system, spaced(0.1, 20.0), ([1.0, -0.5, 2.0], [0.0, 1.0, 0.0]))


parallel_rows_position = partial(_parallel_rows, "position")
parallel_rows_acceleration = partial(_parallel_rows, "acceleration")


def redundant_rows(factor: float) -> StudyProblem:
    ties = [[1.0, -1.0, 0.0, 0.0], [0.0, 1.0, -1.0, 0.0]]
    third = factor * (0.3 * np.array(ties[0]) + 0.7 * np.array(ties[1]))
    constraints = [Constraint(row, names=f"tie {number}") for number, row in enumerate([*ties, third], start=1)]
    system = bodies([1.0, 2.0, 3.0, 4.0], [(0, 1, 1.0), (3, 4, 2.0)], [(0, 4, 0.5)], constraints)
    return moving(system, spaced(0.1, 30.0), ([1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]))


def two_masses(stiffness: float) -> StudyProblem:
    system = MechanicalSystem(
        [[10.0, 0.0, 0.0], [0.0, 10.0, 10.0], [0.0, 10.0, 10.0]],
        stiffness=np.diag([stiffness, 0.0, stiffness]),
        constraints=[Constraint([1.0, -1.0, 0.0], level="acceleration")],
        names=["x1", "q1", "q2"],
    )
    return moving(system, spaced(0.1, 50.0), ([0.8, 1.2, 2.0], [0.0, 0.0, 0.0]))


def inconsistent_start(size: float) -> StudyProblem:
    coefficients = [[[2, 0, 0], [0, 0, 2], [1, -1, 0]], np.zeros((3, 3)), [[10, 10, 10], [0, 10, 10], [0, 0, 0]]]
    start = [[0.8, 0.8 + (1.2 - 0.8) * size, 2.0], [1.0, 1.0 - size, -0.5]]
    return equations(coefficients, start, spaced(0.1, 60.0))


#: log2 of the units of length and force for log2 of the unit of time: from micrometres to megametres.
UNITS = {-20: (-20, -30), -10: (-10, -15), 0: (0, 0), 6: (5, 20), 12: (10, 40)}


#: Powers of two, of rows and of columns, that are made larger and larger.
ROWS, COLUMNS = np.array([1.0, -1.0, 0.5]), np.array([-0.5, 1.0, -1.0])


def unit_of_force(unit: float) -> StudyProblem:
    stiffness = [[3001000.0, -3000000.0, 0.0], [-3000000.0, 3020000.0, -20000.0], [0.0, -20000.0, 20000.0]]
    damping = [[11.0, -10.0, 0.0], [-10.0, 12.0, -2.0], [0.0, -2.0, 2.0]]
    coefficients = [unit * np.array(matrix) for matrix in (stiffness, damping, np.diag([1.0, 0.4, 2.0]))]
    return equations(coefficients, [[1.75, 0.0, 0.75], [-0.25, 2.0, -0.75]], spaced(1e-4, 30.0))


def small_to_huge(time: float) -> StudyProblem:
    length, force = (2.0**power for power in UNITS[round(np.log2(time))])
    base = [[[5, 6], [-1, -1]], [[-2, -4], [4, 6]], [[-1, -2], [2, 3]]]
    coefficients = [force / length * time**power * np.array(matrix) for power, matrix in enumerate(base)]
    start = length * np.array([[1.0, 2.0], [-1.0 / time, 0.5 / time]])
    acting = harmonic([force, -force], angular_frequency=1 / time)
    return equations(coefficients, start, time * spaced(0.02, 20.0), acting)


def unit_of_time(time: float) -> StudyProblem:
    base = [[[0, 5, -5], [-2, -3, 5], [3, 3, -5]], [[0, 2, -2], [0, -2, 2], [0, 2, -2]], [[0, 1, -1], [0, -1, 1], [-1, 2, -1]]]
    coefficients = [time**power * np.array(matrix, dtype=float) for power, matrix in enumerate(base)]
    start = np.array([[1.5, -0.5, -1.5], [-2.0, -0.5, -0.25]]) / np.array([[1.0], [time]])
    return equations(coefficients, start, time * spaced(0.05, 12.0))


def scattered_scales(power: float) -> StudyProblem:
    rows, columns = 2.0 ** np.round(power * ROWS), 2.0 ** np.round(power * COLUMNS)
    base = [[[5, -2, 0], [-2, 4, -1], [0, -1, 3]], np.diag([0.5, 0.0, 0.25]), np.diag([1, 2, 1])]
    coefficients = [rows[:, None] * np.array(matrix, dtype=float) * columns for matrix in base]
    start = np.array([[1.0, -1.0, 0.5], [0.0, 2.0, 0.0]]) / columns
    acting = harmonic(rows * [1.0, 0.0, -1.0], angular_frequency=1.5)
    return equations(coefficients, start, spaced(0.05, 40.0), acting)


#: rad/s, of the double zero of ``resonance``.
NATURAL = 3.0


def resonance(detuning: float) -> StudyProblem:
    # Two oscillators one after the other, both at 3 rad/s, under a sine near it: x grows like t^2.
    coefficients = [[[18.0, -9.0], [-47.0, 28.0]], np.zeros((2, 2)), [[2.0, -1.0], [-5.0, 3.0]]]
    force = term([1.0, 1.0], angular_frequency=NATURAL * (1 + detuning), phase=-np.pi / 2)
    return equations(coefficients, [[1.0, 1.0], [0.0, 2.0]], spaced(0.05, 60.0), force)


def ramp_on_stiff_pair(ratio: float) -> StudyProblem:
    system = bodies([1.0, 2.0], [(0, 1, 1.0), (1, 2, ratio)], [(1, 2, 0.1 * ratio**0.5)])
    return moving(system, spaced(0.1, 100.0), ([0.0, 0.0], [1.0, 1.0]), ramp([0.5, 1.0]))


def soft_mount(stiffness: float) -> StudyProblem:
    # (s^2 + k) (s^2 + 4) x = a step: a slow and an ordinary mode under a constant load.
    coefficients = [4 * stiffness, 0.0, 4 + stiffness, 0.0, 1.0]
    return equations([[[c]] for c in coefficients], [0.0] * 4, np.linspace(0.0, 5.0, 11), step([1.0]))


def slow_pair(stiffness: float) -> StudyProblem:
    # (s^2 + k) (s^2 + 2 k) (s^2 + 4) x = a step: two slow modes and an ordinary one.
    k = stiffness
    coefficients = [8 * k**2, 0.0, 2 * k**2 + 12 * k, 0.0, 4 + 3 * k, 0.0, 1.0]
    return equations([[[c]] for c in coefficients], [0.0] * 6, np.linspace(0.0, 5.0, 11), step([1.0]))


def prothero_robinson(rate: float) -> StudyProblem:
    # x' = -r (x - cos t) - sin t from x = 1, whose answer is cos t at any rate r.
    force = term([rate], angular_frequency=1.0) + term([-1.0], angular_frequency=1.0, phase=-np.pi / 2)
    return equations([[[rate]], [[1.0]]], [1.0], spaced(0.01, 100.0), force)


def long_horizon(end: float) -> StudyProblem:
    # Two undamped oscillators up to a million periods.
    coefficients = [[[3.0, -1.0], [-1.0, 2.5]], np.zeros((2, 2)), np.diag([1.0, 1.25])]
    return equations(coefficients, [[1.0, 0.5], [0.0, -1.0]], spaced(1.0, end))


def free_chain(end: float) -> StudyProblem:
    springs = [(body, body + 1, 4.0 + body) for body in range(1, 7)]
    dampers = [(body, body + 1, 0.125) for body in range(1, 7)]
    system = bodies([1.0, 1.5, 2.0, 1.0, 1.5, 2.0, 1.0], springs, dampers)
    start = ([0.5, 2.0, -2.0, 0.0, -1.0, -0.5, 0.0], [-1.5, -0.75, 0.75, 0.75, 0.25, -1.0, 0.5])
    return moving(system, spaced(0.1, end), start, step([0.5, 0, 0, 0, 0, 0, 0]))


def unstable_growth(end: float) -> StudyProblem:
    springs = [(0, 1, 4.0), (1, 2, 3.0), (2, 3, 2.0), (0, 3, -12.0)]
    dampers = [(0, 1, 0.5), (2, 3, 0.25)]
    system = bodies([1.0, 1.0, 1.0], springs, dampers)
    return moving(system, np.linspace(1.0, end, 10), ([1.0, -1.0, 0.5], [0.0, 0.0, 1.0]))


def first_moments(end: float) -> StudyProblem:
    # The last of three masses in a row, from rest, while a ramp pulls at the first: (s^6 + 5 s^4 + 6 s^2 + 1) x = 1 / s^2.
    coefficients = [[[value]] for value in (1.0, 0.0, 6.0, 0.0, 5.0, 0.0, 1.0)]
    return equations(coefficients, np.zeros((6, 1)), spaced(end / 10, end), ramp([1.0]))


#: Referee case nilpotent5: a nilpotent block of size 5 and a zero at -1, mixed by matrices of whole numbers with determinant 1.
NILPOTENT_5 = [
    [
        [1, 0, -1, 0, 0, 0],
        [0, 1, -1, 0, 4, -2],
        [0, 0, 1, 0, 0, 0],
        [-1, -1, 1, 1, -3, 1],
        [1, 1, -1, -1, 4, -1],
        [1, 1, 0, -1, 2, 0],
    ],
    [[0, 1, 0, 0, 3, -1], [0, 0, 0, 0, 1, -1], [0, 0, 0, 1, 0, 0], [0, -1, -1, 0, -2, 1], [0, 1, 1, 0, 2, -1], [0, 1, 2, 0, 1, 0]],
]


def infinite_order(order: float) -> StudyProblem:
    # s N - I with N nilpotent of size order + 1, and a zero at -1, mixed; the start fits nothing.
    size = int(order) + 2
    first, last = np.eye(size), np.eye(size, k=1)
    last[-2, -1], last[-1, -1] = 0.0, 1.0
    lower = np.tril(np.ones((size, size)))
    upper = lower.T + np.triu(np.ones((size, size)), 2)
    coefficients = [lower @ matrix @ upper for matrix in (first, last)]
    start = np.arange(1.0, size + 1) * (-1.0) ** np.arange(size)
    return equations(coefficients, [start], spaced(0.05, 12.0), harmonic(np.ones(size), angular_frequency=2.0))


def differentiated_force(frequency: float) -> StudyProblem:
    vector, start = [1.0, 0.0, 0.0, 0.0, 2.0, 1.0], [[0.0, -0.25, 1.5, 1.5, -1.75, -1.25]]
    force = term(vector, rate=-0.5, angular_frequency=frequency, phase=-np.pi / 2)
    return equations(NILPOTENT_5, start, spaced(0.05, 12.0), force)


def chain_length(length: float) -> StudyProblem:
    # (s + 3/2)^length with a force at the same zero.
    n = int(length)
    coefficients = [[[comb(n, power) * 1.5 ** (n - power)]] for power in range(n + 1)]
    start = [[1.0], [0.0], [-2.0], *[[0.0]] * n][:n]
    return equations(coefficients, start, spaced(0.02, 15.0), term([2.0], power=1, rate=-1.5))


def cluster_of_zeros(width: float) -> StudyProblem:
    # (s + 1) (s + 1 + d) (s + 1 - d) (s + 1 + 2 d), multiplied out and rounded.
    polynomial = np.poly(-1.0 - width * np.array([0.0, 1.0, -1.0, 2.0]))
    return equations([[[value]] for value in polynomial[::-1]], [[1.0], [0.0], [-1.0], [2.0]], spaced(0.02, 20.0))


def transient_growth(coupling: float) -> StudyProblem:
    # x_i' = -(1 + i / 10) x_i + c x_(i+1): before it decays, what begins in the last grows by powers of c.
    size = 10
    rates = np.diag(1 + np.arange(size) / 10) - coupling * np.eye(size, k=1)
    return equations([rates, np.eye(size)], np.eye(size)[-1], spaced(0.01, 50.0))


def wilkinson(count: float) -> StudyProblem:
    # (s + 1) (s + 2) ... (s + n) x = 0: the polynomial whose zeros Wilkinson found to hang on its last digits.
    coefficients = np.poly(-np.arange(1.0, count + 1))[::-1]
    start = np.eye(int(count))[-1]
    return equations([[[c]] for c in coefficients], start, spaced(0.05, 20.0))


def _two_groups(power: int, coupling: float) -> StudyProblem:
    """Three damped and three undamped bodies, coupled by one pair of entries of K, C or M (power 0, 1, 2)."""
    stiffness = (
        np.diag([2.0, 3.0, 2.5, 1.5, 2.0, 3.5]) - np.diag([1.0, 0.5, 0.0, 0.75, 1.0], 1) - np.diag([1.0, 0.5, 0.0, 0.75, 1.0], -1)
    )
    coefficients = [stiffness, np.diag([1.0, 1.5, 1.25, 0.0, 0.0, 0.0]), np.diag([1.0, 2.0, 1.5, 1.0, 2.0, 0.5])]
    coefficients[power][2, 3] += coupling
    coefficients[power][3, 2] += coupling
    return equations(coefficients, [[1.0, -0.5, 0.25, 0.0, 0.0, 0.0], np.zeros(6)], [200.0])


def decayed_partner(coupling: float) -> StudyProblem:
    stiffness = [[1.0 + coupling, -coupling], [-coupling, 1.0 + coupling]]
    return equations([stiffness, np.diag([1.0, 0.0]), np.eye(2)], [[1.0, 0.0], [0.0, 0.0]], [100.0])


groups_coupled_by_stiffness, groups_coupled_by_damping, groups_coupled_by_mass = (partial(_two_groups, power) for power in range(3))


def growth_through_a_tiny_entry(entry: float) -> StudyProblem:
    return equations([[[4.0, 0.0], [entry, -1.0]], np.zeros((2, 2)), np.eye(2)], [[1.0, 0.0], [0.0, 0.0]], [60.0])


def small_force(force: float) -> StudyProblem:
    coefficients = [np.diag([4.0, -1.0]), np.zeros((2, 2)), np.eye(2)]
    return equations(coefficients, np.zeros((2, 2)), [60.0], step([1.0, force]))


def small_input(size: float) -> StudyProblem:
    return equations([np.diag([1.0, -1.0]), np.eye(2)], np.zeros((1, 2)), [60.0], step([1.0, size]))


def _free_chain(count: int, ground: np.ndarray) -> StudyProblem:
    stiffness = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    stiffness[0, 0] = stiffness[-1, -1] = 1.0
    start = np.ones(count), np.zeros(count)
    return moving(MechanicalSystem(np.eye(count), stiffness=stiffness + np.diag(ground)), [1e7], start)


def nearly_free_chain(power: float) -> StudyProblem:
    return _free_chain(12, np.full(12, 2.0**power))


def chain_grounded_at_one_end(stiffness: float) -> StudyProblem:
    return _free_chain(12, stiffness * np.eye(12)[0])


def link_over_a_spring(softness: float) -> StudyProblem:
    constraints = [Constraint([1.0, -1.0], level="position")]
    system = MechanicalSystem(np.eye(2), stiffness=[[1 + softness, -1.0], [-1.0, 1.0]], constraints=constraints)
    return moving(system, [1e7], ([1.0, 1.0], [0.0, 0.0]))


def late_short_pulse(duration: float) -> StudyProblem:
    force = pulse([0.0, 1.0 / duration], start=1000.0, duration=duration)
    system = MechanicalSystem(np.eye(2), [[0.01, 0.0], [0.0, 0.02]], [[3.0, -1.0], [-1.0, 2.0]])
    return moving(system, [1000.5, 1003.0, 1010.0], np.zeros((2, 2)), force)


def clamped_beam(elements: float) -> StudyProblem:
    n, length = int(elements), 1.0 / elements
    stiffness, mass = np.zeros((2, 2 * n + 2, 2 * n + 2))
    a, b = 6.0 / length, 12.0 / length**2
    element = np.array([[b, a, -b, a], [a, 4.0, -a, 2.0], [-b, -a, b, -a], [a, 2.0, -a, 4.0]]) / length
    inertia = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) * length / 420
    scale = np.array([1.0, length, 1.0, length])
    for first in range(0, 2 * n, 2):
        stiffness[first : first + 4, first : first + 4] += element
        mass[first : first + 4, first : first + 4] += inertia * np.outer(scale, scale)
    stiffness, mass = stiffness[2:, 2:], mass[2:, 2:]
    system = MechanicalSystem(mass, 1e-3 * stiffness + 0.1 * mass, stiffness)
    return moving(system, [1.0, 3.0], (np.zeros(2 * n), np.zeros(2 * n)), step(np.eye(2 * n)[-2]))


def dense_damped(count: float) -> StudyProblem:
    n = int(count)
    factors = np.random.default_rng(n).standard_normal((2, n, n))
    damping, stiffness = (factor @ factor.T / n for factor in factors)
    system = MechanicalSystem(np.eye(n), 0.05 * damping, stiffness + np.eye(n))
    return moving(system, np.linspace(0.0, 20.0, 41), (np.eye(n)[0], np.zeros(n)))
