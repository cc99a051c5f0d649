"""What every method of a report is given: equations, start, force and times."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ..mechanics import MechanicalSystem
from ..polynomial import PolynomialMatrix
from ..response import Response, solve
from ..response.transfer.engine import scalar_matrix
from ..signals import ImpulsiveSmooth

if TYPE_CHECKING:
    from ..scene import Scene


@dataclass(frozen=True)
class Problem:
    """A(d/dt) x = f with values at 0-, and times at which x is wanted.

    Attributes:
        title: what it is called in reports.
        polynomial_matrix: A(s), for a mechanical system that of its constrained form.
        initial: x^(i)(0-) as row i, shape (q, r).
        force: f, r rows: the whole right-hand side, constraint values included.
        times: shape (T,), ascending, in s.
        system: mass, damping, stiffness and constraint rows, where there are any.
        applied: the forces on the coordinates of the system beyond its own; None for none.
        respond: the closed form from scratch where it has a way of its own, as a transfer function has; else None.
    """

    title: str
    polynomial_matrix: PolynomialMatrix
    initial: np.ndarray
    force: ImpulsiveSmooth
    times: np.ndarray
    system: MechanicalSystem | None = None
    applied: ImpulsiveSmooth | None = None
    respond: Callable[[], Response] | None = None

    def solve(self) -> Response:
        """The closed form from scratch: whatever was found out about the equations before is found out again."""
        return self.respond() if self.respond else self.solve_equations()

    def solve_equations(self) -> Response:
        """The same by the equations, from reduced ones or the Jordan pairs of A(s)."""
        if self.system is not None:
            return again(self.system).solve(*self.initial, force=self.applied)
        A = self.polynomial_matrix
        return solve(PolynomialMatrix(given_of(A), A.coordinates, A.equations, A.uncertainty), self.initial, self.force)

    def at(self, times) -> Problem:
        """The same with other times."""
        return replace(self, times=np.asarray(times, dtype=float))


def mechanical_problem(title: str, system: MechanicalSystem, times, displacement=None, velocity=None, force=None) -> Problem:
    """The problem of a mechanical system; arguments as those of ``MechanicalSystem.solve``."""
    motion_start = [
        np.zeros(system.size) if value is None else np.asarray(value, dtype=float) for value in (displacement, velocity)
    ]
    applied = system.force if force is None else system.force + force
    right = system.constrained_form().force(applied)
    return Problem(title, system.polynomial_matrix(), np.array(motion_start), right, np.asarray(times, float), system, force)


def problem_of(scene: Scene) -> Problem:
    """What a scene asks to be solved, with its own times.

    >>> from mbconstrained.scene import read_scene
    >>> problem = problem_of(read_scene("examples/two_masses.toml"))
    >>> problem.title, problem.polynomial_matrix.size, len(problem.times)
    ('Two masses with a redundant coordinate', 3, 1001)
    """
    equations, time = scene.equations, scene.table.time
    return Problem(
        title=scene.heading,
        polynomial_matrix=equations.polynomial_matrix,
        initial=equations.initial,
        force=equations.right_hand_side,
        times=np.linspace(0.0, time.end, time.points),
        system=equations.system,
        applied=equations.force,
        respond=_transfer_response(equations.control),
    )


def _transfer_response(control) -> Callable[[], Response] | None:
    """How a transfer function is answered from rest, its poles found anew."""
    if control is None or control.transfer_function is None or control.transfer_function.start is not None:
        return None

    def respond() -> Response:
        scalar_matrix.cache_clear()
        return control.transfer_function.response()

    return respond


def again(system: MechanicalSystem, given=None, uncertainty=None) -> MechanicalSystem:
    """A system that knows nothing yet but what it was given.

    Args:
        given, uncertainty: of K, C and M, where others take their place.
    """
    stiffness, damping, mass = given or system.given
    uncertainty = dict(zip(("stiffness", "damping", "mass"), uncertainty or system.uncertainty))
    return MechanicalSystem(
        mass,
        damping,
        stiffness,
        system.constraints,
        system.names,
        force=system.drive,
        static_force=system.static_force,
        units=system.units,
        energy_parts=None if given else system.energy_parts,
        uncertainty=uncertainty,
    )


def given_of(A: PolynomialMatrix) -> list:
    """The coefficients as they were given: by their factors, where they have any."""
    return [matrix if factors is None else factors for matrix, factors in zip(A.coefficients, A.factors)]
