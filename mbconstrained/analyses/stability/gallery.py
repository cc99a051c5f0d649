"""The gallery of stiff and extreme systems, by themes: families of problems with one difficulty that grows with a parameter.

Those of the theme "small next to large" are solved for times at which the small quantity decides the answer: after the strong part has decayed,
or after long growth. Each system declares its properties, which exact arithmetic checks.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import comb
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import nearest
from ...ground.errors import InputError, MbconstrainedError
from ...ground.notices import NoticeKind
from ...mechanics.constraints import Constraint
from ...mechanics.element_matrix import ElementMatrix
from ...mechanics.system import MechanicalSystem
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import harmonic, pulse, ramp, step, term, zero
from ..study_problem import StudyProblem, mechanical_problem

if TYPE_CHECKING:
    from ...exact.core.exact_pairs import ExactStructure
    from ...exact.enclosure.exact_response import ExactResponse

#: The chapters in their order.
THEMES = (
    "stiffness",
    "mass",
    "damping",
    "constraints",
    "time",
    "units and scale",
    "structure",
    "forces",
    "size",
    "small next to large",
)


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
    def texts(self) -> tuple[str, str, str]:
        """Title, difficulty and source."""
        title, *rest = inspect.getdoc(self.problem).split("\n")
        difficulty, _, source = " ".join(rest).partition(" Source: ")
        return title.rstrip("."), difficulty, source.rstrip(".") or "made for this gallery"

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


# --- the systems

#: Displacements and velocities at 0-.
CHAIN_START = ([1.75, 0.0, 0.75, -0.25], [-0.25, 2.0, -0.75, -0.25])


PENALTY_START = ([-1.75, 0.75, -2.0, -0.25], [-0.5, -0.5, -0.5, -1.75])


@family("stiffness", "stiffness ratio", decades(0, 16, 2))
@declares(finite_zeros=8, symmetric=True, stiffness_ratio=lambda ratio: max(ratio, 3.0), growing_zeros=0, infinite_divisors=())
def stiff_chain(ratio: float) -> StudyProblem:
    """Four masses, springs of ratio r, by their elements.
    Modes from 0.4 rad/s to sqrt(r) rad/s move together, and the slow ones need springs that are below the rounding errors of the
    stiff.
    Source: referee case stiff_ratio_1e14, as elements."""
    # Springs 1, sqrt(ratio), ratio and 3 N/m, dampers that follow them.
    middle = ratio**0.5
    springs, dampers = chain(1.0, middle, ratio, 3.0), chain(0.1, middle**0.5, middle, 0.2)
    system = bodies([1.0, 2.0, 1.5, 0.5], springs, dampers)
    return moving(system, spaced(1e-3 * ratio**-0.25, 40.0), CHAIN_START)


@family("stiffness", "stiffness ratio", (*decades(0, 14, 2), 1e15, 1e16))
@declares(finite_zeros=8, symmetric=True, infinite_divisors=())
def stiff_chain_assembled(ratio: float) -> StudyProblem:
    """Four masses, springs of ratio r, assembled into matrices.
    The sum r + 3 keeps only the digits of 3 that float64 has left: the soft spring cannot be recovered from the matrices.
    Source: referee case stiff_ratio_1e14."""
    problem = stiff_chain(ratio)
    return moving(assembled(problem.system), problem.times, CHAIN_START)


@family("stiffness", "penalty stiffness", (*decades(0, 14, 2), 1e15, 1e16, 1e17), "N/m")
@declares(symmetric=True, finite_zeros=6, infinite_divisors=(1, 1), mass_ratio=2.0)
def penalty_link(stiffness: float) -> StudyProblem:
    """A penalty spring in place of a rigid link, at a joint without mass, assembled.
    The stiffer the penalty the better the model and the worse its matrix; the joint has no inertia, only a zero near -2 k.
    Source: referee case penalty_massless."""
    springs = [*chain(3.0, stiffness, 2.0, 1.5)]
    dampers = [(0, 1, 0.1), (2, 3, 0.5), (0, 4, 0.75)]
    system = assembled(bodies([1.0, 0.0, 2.0, 0.0], springs, dampers))
    return moving(system, spaced(0.01, 40.0), PENALTY_START)


@family("stiffness", "penalty stiffness", (*decades(0, 14, 2), 1e15, 1e16, 1e17), "N/m")
@declares(symmetric=True, infinite_divisors=(2,), longest_chain=lambda s: 1 if s < 1e17 else 2)
def penalty_joint(stiffness: float) -> StudyProblem:
    """A mass tied by a penalty spring to a joint without mass, assembled.
    The motion is that of 5 N/m, the sum of what the penalty leaves of 3 and of 2; up to 1e15 N/m it leaves them whole."""
    system = assembled(bodies([1.0, 0.0], [(0, 1, 3.0), (1, 2, stiffness), (0, 2, 2.0)]))
    return moving(system, spaced(0.01, 40.0), ([1.0, 1.0], [0.0, 0.0]))


@family("stiffness", "coupling stiffness", (*decades(0, -14, 2), 1e-15, 1e-16), "N/m")
@declares(symmetric=True, undamped=True, finite_zeros=4, longest_chain=1, stiffness_ratio=lambda e: 1 / e)
def weak_coupling(coupling: float) -> StudyProblem:
    """Two equal oscillators, weakly coupled.
    Two pairs of zeros come as near as the coupling, but the energy still crosses over, after pi / coupling seconds."""
    system = bodies([1.0, 1.0], [(0, 1, 1.0), (0, 2, 1.0), (1, 2, coupling)])
    return moving(system, spaced(1.0, min(3.0 / coupling, 1e6)), ([1.0, 0.0], [0.0, 0.0]))


START = ([1.75, 0.0, 0.75], [-0.25, 2.0, -0.75])


@family("mass", "mass of the joint", decades(0, -20, 2), "kg")
@declares(symmetric=True, finite_zeros=6, infinite_divisors=(), mass_ratio=lambda m: 1 / m if m < 1 else 2.0)
def nearly_massless_joint(mass: float) -> StudyProblem:
    """A joint of mass m between two bodies, with a damper.
    Within a time of order m the joint forgets its velocity; the zero that does it lies at -0.1 / m.
    Source: referee case near_massless_1e14."""
    system = bodies([1.0, mass, 0.5], chain(2.0, 3.0, 1.0), chain(0.05, 1e-6, 0.1))
    return moving(system, spaced(mass**0.5, 5.0), START)


@family("mass", "mass of the tip", decades(0, -14, 2), "kg")
@declares(symmetric=True, undamped=True, finite_zeros=4, mass_ratio=lambda m: 1 / m)
def light_tip(mass: float) -> StudyProblem:
    """A light tip that rings undamped.
    The tip turns through 10 / sqrt(m) rad: its phase costs as many digits as that number has, and nothing dies out."""
    system = bodies([1.0, mass], chain(1.0, 1.0))
    return moving(system, spaced(0.01, 10.0), ([1.0, 0.0], [0.0, 1.0]))


@family("damping", "damping ratio", (0.0, 1e-6, 1e-3, 0.5, 1.0, 2.0, 1e2, 1e4, 1e6, 1e8))
@declares(finite_zeros=2, longest_chain=lambda ratio: 2 if ratio == 1 else 1, undamped=lambda ratio: ratio == 0)
def damping_ratio(ratio: float) -> StudyProblem:
    """An oscillator from undamped to overdamped.
    At ratio 1 the two zeros are one with a chain of length 2: formulas that divide by their difference divide by zero.
    Source: referee case crit_exact."""
    # x'' + 4 ratio x' + 4 x = 0.
    return equations([[[4.0]], [[4.0 * ratio]], [[1.0]]], [[1.0], [-3.0]], spaced(0.01, 12.0))


@family("damping", "distance from critical", (1e-2, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12, 1e-14, 1e-15, 0.0))
@declares(finite_zeros=4, growing_zeros=0, longest_chain=lambda distance: 1 if distance else 2)
def near_critical(distance: float) -> StudyProblem:
    """Two coupled oscillators at critical damping minus d.
    Four zeros lie 2 sqrt(2 d) from -2, in four directions: far enough to be two in float64, and too near to be decoupled.
    Source: referee case crit_near_1e9."""
    # s^2 + 4 (1 + d) s + 4 and s^2 + 4 (1 - d) s + 4, mixed by matrices of whole numbers with determinant 1.
    one, two = 4.0 * (1 + distance), 4.0 * (1 - distance)
    damping = [[one - two, one], [one - 2 * two, one]]
    return equations([[[0, 4], [-4, 4]], damping, [[0, 1], [-1, 1]]], [[1.0, -2.0], [0.5, 3.0]], spaced(0.01, 12.0))


@family("damping", "damping", (3.0, *decades(1, 10)), "N s/m")
@declares(finite_zeros=2, longest_chain=1, symmetric=True, decades=lambda c: round(2 * np.log10(c)) if c > 3 else 1)
def heavy_damper(damping: float) -> StudyProblem:
    """A heavy damper against a soft spring.
    Zeros at -c and -1/c are c^2 apart; the soft one is what is left of a difference of two numbers near c.
    Source: referee case rot_overdamped_1e8, not rotated."""
    # x'' + c x' + x = 0, from the first moments of the fast zero to long after the slow one.
    return equations([[[1.0]], [[damping]], [[1.0]]], [[1.0], [1.0]], spaced(1 / damping, 5 * damping))


@family("damping", "rate of turn", decades(-4, 6), "rad/s")
@declares(finite_zeros=4, symmetric=False, growing_zeros=0)
def gyroscope(rate: float) -> StudyProblem:
    """A rotating vibratory gyroscope.
    The damping matrix is not symmetric, and 2 s are 2e4 turns under a force at the first mode.
    Source: referee case mems_gyro."""
    mass, coriolis = 1e-9, 2e-9 * rate
    stiffness = np.diag([mass * 60000.0**2, mass * 62000.0**2])
    damping = [[1e-8, -coriolis], [coriolis, 1e-8]]
    force = harmonic([1e-7, 0.0], angular_frequency=60000.0)
    coefficients = [stiffness, damping, mass * np.eye(2)]
    return equations(coefficients, [[1e-6, 0.0], [0.0, 1e-3]], spaced(1e-6, 2.0), force)


@family("size", "masses", (2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 40.0))
@declares(finite_zeros=lambda n: 2 * int(n), symmetric=True, mass_ratio=1.0, jumps=False, impulses=0)
def chain_of_masses(count: float) -> StudyProblem:
    """Chains of 2 to 40 masses.
    Errors must not grow with the size faster than the size."""
    n = int(count)
    system = bodies([1.0] * n, chain(*[1.0] * n), [(0, 1, 0.25)])
    return moving(system, spaced(0.1, 100.0, 6), (np.eye(n)[-1], np.zeros(n)))


#: Two directions at right angles in the space of three coordinates, along no axis, and rounded.
ONE, OTHER = np.array([2.0, -1.0, 2.0]) / 3, np.array([2.0, 2.0, -1.0]) / 3


def _parallel_rows(angle: float, level: str) -> StudyProblem:
    rows = [ONE, np.cos(angle) * ONE + np.sin(angle) * OTHER]
    constraints = [Constraint(row, level=level, names=f"row {number}") for number, row in enumerate(rows, start=1)]
    system = MechanicalSystem(np.diag([1.0, 2.0, 3.0]), stiffness=np.diag([4.0, 5.0, 7.0]), constraints=constraints)
    return moving(system, spaced(0.1, 20.0), ([1.0, -0.5, 2.0], [0.0, 1.0, 0.0]))


@family("constraints", "angle between the rows", decades(0, -16), "rad")
@declares(jumps=True, redundant_rows=lambda angle: int(angle < 1e-14))
def parallel_rows_position(angle: float) -> StudyProblem:
    """Two constraint rows turn parallel, position level.
    The difference of the second row from the first has a relative rounding error of eps / angle."""
    return _parallel_rows(angle, "position")


@family("constraints", "angle between the rows", decades(0, -16), "rad")
@declares(jumps=False, impulses=0, finite_zeros=6, redundant_rows=lambda angle: int(angle < 1e-14))
def parallel_rows_acceleration(angle: float) -> StudyProblem:
    """Two constraint rows turn parallel, acceleration level.
    The same, and each row leaves a double zero at 0 along which rounding drifts."""
    return _parallel_rows(angle, "acceleration")


@family("constraints", "scale of the third row", decades(-8, 8, 2))
@declares(finite_zeros=4, redundant_rows=1, jumps=False, impulses=0, growing_zeros=0)
def redundant_rows(factor: float) -> StudyProblem:
    """A loop of ties, one of which is redundant within rounding error, in other units.
    Taken literally the third row forbids the motion: its coefficients 0.3 f, 0.4 f, -0.7 f do not quite cancel."""
    ties = [[1.0, -1.0, 0.0, 0.0], [0.0, 1.0, -1.0, 0.0]]
    third = factor * (0.3 * np.array(ties[0]) + 0.7 * np.array(ties[1]))
    constraints = [Constraint(row, names=f"tie {number}") for number, row in enumerate([*ties, third], start=1)]
    system = bodies([1.0, 2.0, 3.0, 4.0], [(0, 1, 1.0), (3, 4, 2.0)], [(0, 4, 0.5)], constraints)
    return moving(system, spaced(0.1, 30.0), ([1.0, 1.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]))


@family("constraints", "stiffness", (2e-16, 2e-12, 2e-8, 2e-4, 2.0, 2e4, 2e8, 2e12), "N/m")
@declares(finite_zeros=6, zeros_at_0=2, longest_chain=2, undamped=True, impulses=0, jumps=False)
def two_masses(stiffness: float) -> StudyProblem:
    """Two masses with a redundant coordinate, acceleration level.
    A double zero at 0 with one chain (the drift of the constraint) with slow or fast oscillations.
    Source: Moysis et al., section 5.1."""
    system = MechanicalSystem(
        [[10.0, 0.0, 0.0], [0.0, 10.0, 10.0], [0.0, 10.0, 10.0]],
        stiffness=np.diag([stiffness, 0.0, stiffness]),
        constraints=[Constraint([1.0, -1.0, 0.0], level="acceleration")],
        names=["x1", "q1", "q2"],
    )
    return moving(system, spaced(0.1, 50.0), ([0.8, 1.2, 2.0], [0.0, 0.0, 0.0]))


@family("constraints", "size of the violation", (0.0, *decades(-14, 6, 2), 1e8))
@declares(finite_zeros=4, undamped=True, infinite_divisors=(2,), impulses=0, jumps=lambda size: size > 0)
def inconsistent_start(size: float) -> StudyProblem:
    """A start that violates a position constraint.
    A violation near rounding must not become a jump that is not there, nor a large one be smeared.
    Source: referee case two_mass_pos_incons (Moysis et al., section 5.1, position level)."""
    coefficients = [[[2, 0, 0], [0, 0, 2], [1, -1, 0]], np.zeros((3, 3)), [[10, 10, 10], [0, 10, 10], [0, 0, 0]]]
    start = [[0.8, 0.8 + (1.2 - 0.8) * size, 2.0], [1.0, 1.0 - size, -0.5]]
    return equations(coefficients, start, spaced(0.1, 60.0))


#: log2 of the units of length and force for log2 of the unit of time: from micrometres to megametres.
UNITS = {-20: (-20, -30), -10: (-10, -15), 0: (0, 0), 6: (5, 20), 12: (10, 40)}


#: Powers of two, of rows and of columns, that are made larger and larger.
ROWS, COLUMNS = np.array([1.0, -1.0, 0.5]), np.array([-0.5, 1.0, -1.0])


@family("units and scale", "unit of force", decades(-12, 12, 3), "N")
@declares(finite_zeros=6, infinite_divisors=(), growing_zeros=0, decades=2)
def unit_of_force(unit: float) -> StudyProblem:
    """Three bodies, forces in powers of ten.
    A threshold that is not relative to the data works in one unit and fails in another.
    Source: referee case huge_units."""
    stiffness = [[3001000.0, -3000000.0, 0.0], [-3000000.0, 3020000.0, -20000.0], [0.0, -20000.0, 20000.0]]
    damping = [[11.0, -10.0, 0.0], [-10.0, 12.0, -2.0], [0.0, -2.0, 2.0]]
    coefficients = [unit * np.array(matrix) for matrix in (stiffness, damping, np.diag([1.0, 0.4, 2.0]))]
    return equations(coefficients, [[1.75, 0.0, 0.75], [-0.25, 2.0, -0.75]], spaced(1e-4, 30.0))


@family("units and scale", "unit of time", tuple(2.0**power for power in UNITS), "s")
@declares(finite_zeros=4, longest_chain=4, infinite_divisors=(), growing_zeros=0)
def small_to_huge(time: float) -> StudyProblem:
    """A chain of length 4 from MEMS to giga units.
    Powers of two change no digit of the data: no digit of the answer may change either, nor may its structure.
    Source: referee cases mems_jordan4_qep and giga_jordan4_qep."""
    length, force = (2.0**power for power in UNITS[round(np.log2(time))])
    base = [[[5, 6], [-1, -1]], [[-2, -4], [4, 6]], [[-1, -2], [2, 3]]]
    coefficients = [force / length * time**power * np.array(matrix) for power, matrix in enumerate(base)]
    start = length * np.array([[1.0, 2.0], [-1.0 / time, 0.5 / time]])
    acting = harmonic([force, -force], angular_frequency=1 / time)
    return equations(coefficients, start, time * spaced(0.02, 20.0), acting)


@family("units and scale", "unit of time", tuple(2.0**power for power in range(-40, 41, 10)), "s")
@declares(finite_zeros=2, infinite_order=2, infinite_divisors=(4,), impulses=2, jumps=True)
def unit_of_time(time: float) -> StudyProblem:
    """An infinite zero of order 2 in any unit of time.
    An impulse has the unit of x times time, its derivative times time squared: which of them is zero may not depend on units.
    Source: referee case inf_order2."""
    base = [[[0, 5, -5], [-2, -3, 5], [3, 3, -5]], [[0, 2, -2], [0, -2, 2], [0, 2, -2]], [[0, 1, -1], [0, -1, 1], [-1, 2, -1]]]
    coefficients = [time**power * np.array(matrix, dtype=float) for power, matrix in enumerate(base)]
    start = np.array([[1.5, -0.5, -1.5], [-2.0, -0.5, -0.25]]) / np.array([[1.0], [time]])
    return equations(coefficients, start, time * spaced(0.05, 12.0))


@family("units and scale", "power of two", (0.0, 2.0, 4.0, 8.0, 12.0, 16.0, 20.0))
@declares(finite_zeros=6, infinite_divisors=(), growing_zeros=0, longest_chain=1)
def scattered_scales(power: float) -> StudyProblem:
    """Rows and columns scaled by 2^k and 2^-k.
    Nothing but units has changed, yet entries of one matrix differ by 2^(4 k).
    Source: made for this gallery, as the referee cases of the family scattered."""
    rows, columns = 2.0 ** np.round(power * ROWS), 2.0 ** np.round(power * COLUMNS)
    base = [[[5, -2, 0], [-2, 4, -1], [0, -1, 3]], np.diag([0.5, 0.0, 0.25]), np.diag([1, 2, 1])]
    coefficients = [rows[:, None] * np.array(matrix, dtype=float) * columns for matrix in base]
    start = np.array([[1.0, -1.0, 0.5], [0.0, 2.0, 0.0]]) / columns
    acting = harmonic(rows * [1.0, 0.0, -1.0], angular_frequency=1.5)
    return equations(coefficients, start, spaced(0.05, 40.0), acting)


#: rad/s, of the double zero of ``resonance``.
NATURAL = 3.0


@family("forces", "detuning of the force", (*decades(-1, -15), 0.0))
@declares(finite_zeros=4, longest_chain=2, undamped=True)
def resonance(detuning: float) -> StudyProblem:
    """Resonance approached at a double zero.
    Near resonance the answer is the difference of two large oscillations; at resonance a chain of length 3 with the force.
    Source: referee case resonance_double."""
    # Two oscillators one after the other, both at 3 rad/s, under a sine near it: x grows like t^2.
    coefficients = [[[18.0, -9.0], [-47.0, 28.0]], np.zeros((2, 2)), [[2.0, -1.0], [-5.0, 3.0]]]
    force = term([1.0, 1.0], angular_frequency=NATURAL * (1 + detuning), phase=-np.pi / 2)
    return equations(coefficients, [[1.0, 1.0], [0.0, 2.0]], spaced(0.05, 60.0), force)


@family("forces", "stiffness ratio", decades(0, 16, 2))
@declares(finite_zeros=4, symmetric=True, stiffness_ratio=lambda ratio: ratio, growing_zeros=0, jumps=False)
def ramp_on_stiff_pair(ratio: float) -> StudyProblem:
    """A ramp on a stiff pair.
    The stretch of the stiff spring is 1 / r of the motion, and its ringing is sqrt(r) times as fast."""
    system = bodies([1.0, 2.0], [(0, 1, 1.0), (1, 2, ratio)], [(1, 2, 0.1 * ratio**0.5)])
    return moving(system, spaced(0.1, 100.0), ([0.0, 0.0], [1.0, 1.0]), ramp([0.5, 1.0]))


@family("forces", "stiffness of the mount", decades(0, -16, 2), "1/s^2")
@declares(finite_zeros=4, undamped=True, growing_zeros=0, zeros_at_0=0)
def soft_mount(stiffness: float) -> StudyProblem:
    """A load on a soft mount.
    The load's answer is the difference of a large static deflection and a slow oscillation, until they separate."""
    # (s^2 + k) (s^2 + 4) x = a step: a slow and an ordinary mode under a constant load.
    coefficients = [4 * stiffness, 0.0, 4 + stiffness, 0.0, 1.0]
    return equations([[[c]] for c in coefficients], [0.0] * 4, np.linspace(0.0, 5.0, 11), step([1.0]))


@family("forces", "stiffness of the mounts", decades(0, -12, 2), "1/s^2")
@declares(finite_zeros=6, zeros_at_0=0)
def slow_pair(stiffness: float) -> StudyProblem:
    """Two slow modes and an ordinary one.
    The two slow motions cancel but for a small remainder until they separate, long after the times asked for."""
    # (s^2 + k) (s^2 + 2 k) (s^2 + 4) x = a step: two slow modes and an ordinary one.
    k = stiffness
    coefficients = [8 * k**2, 0.0, 2 * k**2 + 12 * k, 0.0, 4 + 3 * k, 0.0, 1.0]
    return equations([[[c]] for c in coefficients], [0.0] * 6, np.linspace(0.0, 5.0, 11), step([1.0]))


@family("forces", "rate r", decades(0, 16, 2), "1/s")
@declares(finite_zeros=1, growing_zeros=0, zeros_at_0=0, jumps=False)
def prothero_robinson(rate: float) -> StudyProblem:
    """A smooth motion and a fast decay.
    The answer is cos t at any rate; steps that are long relative to 1 / r lose the order of most methods.
    Source: Prothero and Robinson, Math. Comp. 28 (1974) 145-162."""
    # x' = -r (x - cos t) - sin t from x = 1, whose answer is cos t at any rate r.
    force = term([rate], angular_frequency=1.0) + term([-1.0], angular_frequency=1.0, phase=-np.pi / 2)
    return equations([[[rate]], [[1.0]]], [1.0], spaced(0.01, 100.0), force)


@family("time", "end", (*decades(1, 6), 5e6, 1e8, 1e10), "s")
@declares(finite_zeros=4, undamped=True, symmetric=True, longest_chain=1)
def long_horizon(end: float) -> StudyProblem:
    """Undamped, to a million periods.
    An error of eps in a frequency is an error of eps w t in the phase: with the horizon all lose digits, and should say so.
    Source: referee case long_1e6."""
    # Two undamped oscillators up to a million periods.
    coefficients = [[[3.0, -1.0], [-1.0, 2.5]], np.zeros((2, 2)), np.diag([1.0, 1.25])]
    return equations(coefficients, [[1.0, 0.5], [0.0, -1.0]], spaced(1.0, end))


@family("time", "end", decades(0, 8), "s")
@declares(finite_zeros=14, zeros_at_0=2, longest_chain=2, symmetric=True, growing_zeros=0)
def free_chain(end: float) -> StudyProblem:
    """An unconstrained chain under a constant force.
    A double zero at 0 with one chain: x grows like t^2, and a zero at 1e-9 instead would oscillate.
    Source: referee case rigid7."""
    springs = [(body, body + 1, 4.0 + body) for body in range(1, 7)]
    dampers = [(body, body + 1, 0.125) for body in range(1, 7)]
    system = bodies([1.0, 1.5, 2.0, 1.0, 1.5, 2.0, 1.0], springs, dampers)
    start = ([0.5, 2.0, -2.0, 0.0, -1.0, -0.5, 0.0], [-1.5, -0.75, 0.75, 0.75, 0.25, -1.0, 0.5])
    return moving(system, spaced(0.1, end), start, step([0.5, 0, 0, 0, 0, 0, 0]))


@family("time", "end", (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 250.0), "s")
@declares(finite_zeros=6, growing_zeros=1, symmetric=True)
def unstable_growth(end: float) -> StudyProblem:
    """Growth up to e^300 and beyond the range of float64.
    What grows hides all else; beyond 1e308 there is no answer, which is to be said.
    Source: referee case unstable300."""
    springs = [(0, 1, 4.0), (1, 2, 3.0), (2, 3, 2.0), (0, 3, -12.0)]
    dampers = [(0, 1, 0.5), (2, 3, 0.25)]
    system = bodies([1.0, 1.0, 1.0], springs, dampers)
    return moving(system, np.linspace(1.0, end, 10), ([1.0, -1.0, 0.5], [0.0, 0.0, 1.0]))


@family("time", "end", decades(1, -10), "s")
@declares(finite_zeros=6, undamped=True, jumps=False, impulses=0)
def first_moments(end: float) -> StudyProblem:
    """The first moments after rest.
    Sums over modes cancel to t^7: at t = 1e-4 all 16 digits of each term, and 12 more.
    Source: made for this gallery: the closed form of Hauksdottir and Sigurdsson, section 5, at small t."""
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


@family("structure", "order of the infinite zero", (1.0, 2.0, 3.0, 4.0, 5.0))
@declares(
    finite_zeros=1,
    infinite_order=lambda order: int(order),
    impulses=lambda order: int(order),
    infinite_divisors=lambda order: (int(order) + 1,),
    jumps=True,
)
def infinite_order(order: float) -> StudyProblem:
    """Infinite zeros of order 1 to 5, with as many impulses.
    The answer holds delta, delta', ... up to one less than the order; a rank decided wrong adds or loses one."""
    # s N - I with N nilpotent of size order + 1, and a zero at -1, mixed; the start fits nothing.
    size = int(order) + 2
    first, last = np.eye(size), np.eye(size, k=1)
    last[-2, -1], last[-1, -1] = 0.0, 1.0
    lower = np.tril(np.ones((size, size)))
    upper = lower.T + np.triu(np.ones((size, size)), 2)
    coefficients = [lower @ matrix @ upper for matrix in (first, last)]
    start = np.arange(1.0, size + 1) * (-1.0) ** np.arange(size)
    return equations(coefficients, [start], spaced(0.05, 12.0), harmonic(np.ones(size), angular_frequency=2.0))


@family("structure", "frequency of the force", (0.0, 0.1, 2.0, 10.0, *decades(2, 8)), "rad/s")
@declares(finite_zeros=1, infinite_order=4, infinite_divisors=(5,), impulses=4, jumps=True)
def differentiated_force(frequency: float) -> StudyProblem:
    """A force differentiated four times.
    A chain of length 5 at infinity differentiates: at high frequencies the answer is w^4 times the force.
    Source: referee case nilpotent5."""
    vector, start = [1.0, 0.0, 0.0, 0.0, 2.0, 1.0], [[0.0, -0.25, 1.5, 1.5, -1.75, -1.25]]
    force = term(vector, rate=-0.5, angular_frequency=frequency, phase=-np.pi / 2)
    return equations(NILPOTENT_5, start, spaced(0.05, 12.0), force)


@family("structure", "length of the chain", (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0))
@declares(finite_zeros=lambda n: int(n), longest_chain=lambda n: int(n), growing_zeros=0)
def chain_length(length: float) -> StudyProblem:
    """A Jordan chain of increasing length, with a force at its zero.
    Rounding parts n equal zeros by eps^(1/n), a percent at n = 8; their sum must not show it.
    Source: referee case jordan3_scalar."""
    # (s + 3/2)^length with a force at the same zero.
    n = int(length)
    coefficients = [[[comb(n, power) * 1.5 ** (n - power)]] for power in range(n + 1)]
    start = [[1.0], [0.0], [-2.0], *[[0.0]] * n][:n]
    return equations(coefficients, start, spaced(0.02, 15.0), term([2.0], power=1, rate=-1.5))


@family("structure", "width of the cluster", (0.25, *decades(-1, -12)), "1/s")
@declares(finite_zeros=4, growing_zeros=0, infinite_divisors=())
def cluster_of_zeros(width: float) -> StudyProblem:
    """A cluster of four zeros.
    At a width of 1e-4 they are four and look like one: neither their eigenvectors nor one chain describe them."""
    # (s + 1) (s + 1 + d) (s + 1 - d) (s + 1 + 2 d), multiplied out and rounded.
    polynomial = np.poly(-1.0 - width * np.array([0.0, 1.0, -1.0, 2.0]))
    return equations([[[value]] for value in polynomial[::-1]], [[1.0], [0.0], [-1.0], [2.0]], spaced(0.02, 20.0))


@family("structure", "coupling", decades(-2, 4), "1/s")
@declares(finite_zeros=10, growing_zeros=0, longest_chain=1)
def transient_growth(coupling: float) -> StudyProblem:
    """Ten decays in series, each exciting the next.
    All motions decay, but not before they have grown: the eigenvectors are nearly parallel.
    Source: made for this gallery, after Trefethen and Embree, Spectra and Pseudospectra (2005)."""
    # x_i' = -(1 + i / 10) x_i + c x_(i+1): before it decays, what begins in the last grows by powers of c.
    size = 10
    rates = np.diag(1 + np.arange(size) / 10) - coupling * np.eye(size, k=1)
    return equations([rates, np.eye(size)], np.eye(size)[-1], spaced(0.01, 50.0))


@family("structure", "number of zeros", (2.0, 5.0, 8.0, 11.0, 14.0, 17.0, 20.0))
@declares(finite_zeros=lambda n: int(n), growing_zeros=0, zeros_at_0=0)
def wilkinson(count: float) -> StudyProblem:
    """The zeros -1, -2, ..., -n.
    At n = 20 the last digit of a coefficient moves zeros by more than their distance; the motion moves by less.
    Source: Wilkinson, Rounding Errors in Algebraic Processes (1963)."""
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


@family("small next to large", "coupling stiffness", decades(-3, -18, 3), "N/m")
@declares(finite_zeros=4, symmetric=True, growing_zeros=0)
def decayed_partner(coupling: float) -> StudyProblem:
    """Two equal oscillators, one of them damped, weakly coupled by a spring.
    The damped one starts. Once it has come to rest, all that is left is the motion of the other, as small as the coupling."""
    stiffness = [[1.0 + coupling, -coupling], [-coupling, 1.0 + coupling]]
    return equations([stiffness, np.diag([1.0, 0.0]), np.eye(2)], [[1.0, 0.0], [0.0, 0.0]], [100.0])


@family("small next to large", "coupling stiffness", decades(-4, -19, 3), "N/m")
@declares(finite_zeros=12, symmetric=True)
def groups_coupled_by_stiffness(coupling: float) -> StudyProblem:
    """Two groups of bodies, one of them damped, weakly coupled by a spring.
    The eigenvalues of the groups are well separated, so that all of the coupling's effect is in small entries of the shapes."""
    return _two_groups(0, coupling)


@family("small next to large", "coupling damping", decades(-4, -19, 3), "N s/m")
@declares(finite_zeros=12, symmetric=True)
def groups_coupled_by_damping(coupling: float) -> StudyProblem:
    """Two groups of bodies, one of them damped, weakly coupled by a damper.
    The same with an entry of the damping matrix."""
    return _two_groups(1, coupling)


@family("small next to large", "coupling mass", decades(-4, -19, 3), "kg")
@declares(finite_zeros=12, symmetric=True)
def groups_coupled_by_mass(coupling: float) -> StudyProblem:
    """Two groups of bodies, one of them damped, weakly coupled by a mass.
    The same with an entry of the mass matrix, which a solution with the mass matrix may lose."""
    return _two_groups(2, coupling)


@family("small next to large", "entry", decades(-2, -22, 4), "N/m")
@declares(finite_zeros=4, growing_zeros=1, symmetric=False)
def growth_through_a_tiny_entry(entry: float) -> StudyProblem:
    """A part that grows, driven through a tiny entry by one that does not.
    Growth by e^60 makes the only motion of the second body; without the entry it rests."""
    return equations([[[4.0, 0.0], [entry, -1.0]], np.zeros((2, 2)), np.eye(2)], [[1.0, 0.0], [0.0, 0.0]], [60.0])


@family("small next to large", "force", decades(0, -20, 4), "N")
@declares(finite_zeros=4, growing_zeros=1, symmetric=True)
def small_force(force: float) -> StudyProblem:
    """A small force on a part that grows, next to a force of 1 N on one that does not.
    Relative to the large force the small one may be a rounding error; the rows have nothing in common."""
    coefficients = [np.diag([4.0, -1.0]), np.zeros((2, 2)), np.eye(2)]
    return equations(coefficients, np.zeros((2, 2)), [60.0], step([1.0, force]))


@family("small next to large", "input", decades(0, -20, 4))
@declares(finite_zeros=2, growing_zeros=1)
def small_input(size: float) -> StudyProblem:
    """A small input of a state that grows, next to one of 1 of a state that decays.
    The same for equations of first order."""
    return equations([np.diag([1.0, -1.0]), np.eye(2)], np.zeros((1, 2)), [60.0], step([1.0, size]))


def _free_chain(count: int, ground: np.ndarray) -> StudyProblem:
    stiffness = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    stiffness[0, 0] = stiffness[-1, -1] = 1.0
    start = np.ones(count), np.zeros(count)
    return moving(MechanicalSystem(np.eye(count), stiffness=stiffness + np.diag(ground)), [1e7], start)


@family("small next to large", "power of two of the ground springs", tuple(map(float, range(-17, -62, -10))))
@declares(finite_zeros=24, undamped=True, symmetric=True)
def nearly_free_chain(power: float) -> StudyProblem:
    """Twelve masses, each on a very soft spring to the ground, after 1e7 s.
    The whole chain swings as one body; as a rigid-body motion it would stay where it is."""
    return _free_chain(12, np.full(12, 2.0**power))


@family("small next to large", "stiffness to the ground", decades(-10, -15), "N/m")
@declares(finite_zeros=24, undamped=True, symmetric=True)
def chain_grounded_at_one_end(stiffness: float) -> StudyProblem:
    """Twelve masses, the first on a very soft spring to the ground, after 1e7 s.
    The stiffness of the ground is known to the rounding error of 1 plus it."""
    return _free_chain(12, stiffness * np.eye(12)[0])


@family("small next to large", "softness", (1e-9, 1e-11, 1e-13, 2.1e-14, 1.4e-14, 7e-15, 1e-15), "N/m")
@declares(symmetric=True, jumps=False)
def link_over_a_spring(softness: float) -> StudyProblem:
    """A rigid link in parallel to a stiff spring, after 1e7 s.
    What is left of the stiffness in the direction of the motion is the rounded sum of its entries."""
    constraints = [Constraint([1.0, -1.0], level="position")]
    system = MechanicalSystem(np.eye(2), stiffness=[[1 + softness, -1.0], [-1.0, 1.0]], constraints=constraints)
    return moving(system, [1e7], ([1.0, 1.0], [0.0, 0.0]))


@family("small next to large", "duration", decades(-1, -13, 2), "s")
@declares(finite_zeros=4, symmetric=True, jumps=False)
def late_short_pulse(duration: float) -> StudyProblem:
    """A pulse of given impulse after 1000 s, of decreasing duration.
    Its duration is not the difference of its two times, which are rounded."""
    force = pulse([0.0, 1.0 / duration], start=1000.0, duration=duration)
    system = MechanicalSystem(np.eye(2), [[0.01, 0.0], [0.0, 0.02]], [[3.0, -1.0], [-1.0, 2.0]])
    return moving(system, [1000.5, 1003.0, 1010.0], np.zeros((2, 2)), force)


@family("small next to large", "elements", (2.0, 4.0, 8.0, 12.0, 16.0))
@declares(finite_zeros=lambda n: 4 * int(n), growing_zeros=0, symmetric=True)
def clamped_beam(elements: float) -> StudyProblem:
    """A clamped beam with Rayleigh damping, of increasing refinement.
    The fastest modes are overdamped and 1e5 times as fast as the slowest, which is all that is seen."""
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


@family("size", "coordinates", (2.0, 4.0, 8.0, 12.0, 16.0, 24.0))
@declares(finite_zeros=lambda n: 2 * int(n), growing_zeros=0, symmetric=True, infinite_divisors=())
def dense_damped(count: float) -> StudyProblem:
    """Dense symmetric matrices, not proportionally damped, at even times.
    Powers of one exponential take the place of modes; their errors grow with the number of steps."""
    n = int(count)
    factors = np.random.default_rng(n).standard_normal((2, n, n))
    damping, stiffness = (factor @ factor.T / n for factor in factors)
    system = MechanicalSystem(np.eye(n), 0.05 * damping, stiffness + np.eye(n))
    return moving(system, np.linspace(0.0, 20.0, 41), (np.eye(n)[0], np.zeros(n)))


GALLERY: tuple[System, ...] = tuple(sorted(SYSTEMS, key=lambda one: THEMES.index(one.theme)))


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
        """Exact structure of A(s), with finite and infinite zeros."""
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
    problem = facts.problem
    matrices = problem.polynomial_matrix.coefficients
    if problem.system is not None:
        matrices = (problem.system.stiffness, problem.system.damping, problem.system.mass)
    return all(np.array_equal(matrix, matrix.T) for matrix in matrices)


#: By name; each is a function of the facts.
PROPERTIES: dict[str, Callable[[Facts], object]] = {
    "finite_zeros": lambda facts: facts.exact.matrix.determinant.degree(),
    "infinite_divisors": lambda facts: tuple(degree for degree in facts.structure.infinite_divisors if degree),
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
