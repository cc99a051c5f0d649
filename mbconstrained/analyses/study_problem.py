"""The problem of a study: equations, initial values, force and times; and exact numbers of its answers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from ..control.rational import scalar_matrix
from ..mechanics.system import MechanicalSystem
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.response import Response
from ..response.solve import solve
from ..signals.impulsive import ImpulsiveSmooth

if TYPE_CHECKING:
    from ..exact.enclosure.intervals import Enclosure
    from ..mechanics.switched.switched_motion import SwitchedMotion
    from ..mechanics.switched.switched_system import SwitchedSystem
    from ..scene.run.scene import Scene


@dataclass(frozen=True, eq=False)  # a problem is equal to itself only, so that values can be kept for it
class StudyProblem:
    """A(d/dt) x = f with values at 0-, and the times of the solution."""

    title: str  # for reports
    polynomial_matrix: PolynomialMatrix  # A(s), for a mechanical system that of its constrained form
    initial: np.ndarray  # x^(i)(0-) as row i, shape (q, r)
    force: ImpulsiveSmooth  # f, r rows: the whole right-hand side, constraint values included
    times: np.ndarray  # shape (T,), ascending, in s
    system: MechanicalSystem | None = None  # mass, damping, stiffness and constraint rows, where there are any
    applied: ImpulsiveSmooth | None = None  # the forces on the coordinates of the system beyond its own; None for none
    respond: Callable[[], Response] | None = None  # the closed form by a method of its own, as for a transfer function; else None

    def solve(self) -> Response:
        """Solve the problem in closed form, without earlier results."""
        return self.respond() if self.respond else self.solve_equations()

    def solve_equations(self) -> Response:
        """Solve the equations in closed form, from reduced ones or the Jordan pairs of A(s)."""
        if self.system is not None:
            return again(self.system).solve(*self.initial, force=self.applied)
        A = self.polynomial_matrix
        return solve(PolynomialMatrix(given_of(A), A.coordinates, A.equations, A.uncertainty), self.initial, self.force)

    def at(self, times) -> StudyProblem:
        return replace(self, times=np.asarray(times, dtype=float))


@dataclass(frozen=True, eq=False)
class SwitchedProblem(StudyProblem):
    """The problem of a switched system; the polynomial matrix and the system are those of its first phase."""

    machine: SwitchedSystem = None
    penetration: bool = False

    def solve(self) -> SwitchedMotion:
        x, v = self.initial
        return self.machine.solve(x, v, self.applied, end=float(self.times[-1]), penetration=self.penetration)


def mechanical_problem(title: str, system: MechanicalSystem, times, displacement=None, velocity=None, force=None) -> StudyProblem:
    motion_start = [
        np.zeros(system.size) if value is None else np.asarray(value, dtype=float) for value in (displacement, velocity)
    ]
    applied = system.force if force is None else system.force + force
    right = system.constrained_form().force(applied)
    return StudyProblem(title, system.polynomial_matrix(), np.array(motion_start), right, np.asarray(times, float), system, force)


def problem_of(scene: Scene) -> StudyProblem:
    """The problem of a scene, with its own times.

    >>> from mbconstrained import read_scene
    >>> problem = problem_of(read_scene("examples/two_masses.toml"))
    >>> problem.title, problem.polynomial_matrix.size, len(problem.times)
    ('Two masses with a redundant coordinate', 3, 1001)
    """
    equations, switching = scene.equations, scene.equations.switching
    common: dict = {"title": scene.heading, "initial": equations.initial, "force": equations.right_hand_side}
    common |= {"times": scene.times, "applied": equations.force}
    if switching is not None:
        first = switching.begin.solution.sequence.segments[-1].phase.system
        common |= {"system": first, "machine": switching.machine, "penetration": switching.penetration}
        return SwitchedProblem(polynomial_matrix=first.undelayed_form().polynomial_matrix, **common)
    respond = _transfer_response(equations.control)
    return StudyProblem(polynomial_matrix=equations.polynomial_matrix, system=equations.system, respond=respond, **common)


def _transfer_response(control) -> Callable[[], Response] | None:
    """The response of a transfer function from rest, with its poles recomputed; None for other models."""
    if control is None or control.transfer_function is None or control.transfer_function.start is not None:
        return None

    def respond() -> Response:
        scalar_matrix.cache_clear()
        return control.transfer_function.response()

    return respond


def again(system: MechanicalSystem, given=None, uncertainty=None) -> MechanicalSystem:
    """A system from the same data, without any results."""
    stiffness, damping, mass = given or system.given
    uncertainty = dict(zip(("stiffness", "damping", "mass"), uncertainty or system.uncertainty))
    return MechanicalSystem(
        mass,
        damping,
        stiffness,
        system.constraints,
        system.names,
        force=system.excitation,
        static_force=system.static_force,
        units=system.units,
        energy_parts=None if given else system.energy_parts,
        uncertainty=uncertainty,
        delayed=system.delayed,
    )


def given_of(A: PolynomialMatrix) -> list:
    """The given coefficients: by their factors, where they have any."""
    return [matrix if factors is None else factors for matrix, factors in zip(A.coefficients, A.factors)]


def chosen_places(count: int, most: int) -> np.ndarray:
    """Some of the indices 0 ... count - 1, evenly spaced, including the first and the last."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(int))


def values_of(box: Enclosure) -> np.ndarray:
    """The middles of the intervals as Fractions, of the shape of x."""
    return (fractions_of(box.lower) + fractions_of(box.upper)) / 2


#: Floats, or decimal strings, as the exact numbers that they are.
fractions_of = np.vectorize(Fraction, otypes=[object])
