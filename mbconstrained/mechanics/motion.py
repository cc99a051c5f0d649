"""The motion of a mechanical system: a response that knows its coordinates, units, reactions and energy."""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..checks import nearest, whole_number
from ..errors import InputError
from ..notices import Notice
from ..response.estimate import error_estimate
from ..response.response import Response
from ..response.solve import solve
from ..signals.bohl import BohlFunction
from ..signals.impulsive import Blow, ImpulsiveSmooth
from .energy import Energy, energy_of
from .reaction import later_reaction_impulses, reaction_function, reaction_impulses

if TYPE_CHECKING:
    from ..exact.enclosure import Enclosure, ExactResponse
    from .system import MechanicalSystem

Quantity = Literal["displacement", "velocity", "acceleration", "reaction"]

#: What a motion has of the response, in order; the events beside it.
TAKEN = tuple(field.name for field in fields(Response) if not field.kw_only)


@dataclass(frozen=True, repr=False)
class Motion(Response):
    """x(t) of a mechanical system, a ``Response`` to the constrained form; t = 0 means 0+ everywhere,
    the time of an event its right limit.

    Attributes:
        system: the system that moves.
        applied: all forces f on its n coordinates, its own included.
    """

    system: MechanicalSystem
    applied: ImpulsiveSmooth

    @property
    def names(self) -> tuple[str, ...]:
        """The coordinates, in the order of the rows of x."""
        return self.system.names

    def velocity(self, times) -> np.ndarray:
        """x' at a time (-> (n,)) or at times (T,) (-> (n, T)), in m/s or rad/s."""
        return self.derivative(1)(times)

    def acceleration(self, times) -> np.ndarray:
        """x'' at a time (-> (n,)) or at times (T,) (-> (n, T)), in m/s^2 or rad/s^2."""
        return self.derivative(2)(times)

    def reaction(self, times) -> np.ndarray:
        """The multipliers lambda at a time (-> (k,)) or at times (T,) (-> (k, T)), one per row of ``system.rows``.

        M x'' + C x' + K x = f + A^T lambda: lambda_i is the force along the i-th row, in N for a row in metres and
        in N m for a row in radians. What happens at t = 0 itself is in ``constraint_impulses``, what happens at later
        times in ``later_constraint_impulses``.
        """
        return self.reaction_function(times)

    @cached_property
    def reaction_function(self) -> BohlFunction:
        """lambda for t > 0 in closed form, k rows."""
        return self.reaction_of(self)

    def reaction_of(self, response: Response) -> BohlFunction:
        """The same for another response of the system to the same forces."""
        return reaction_function(self.system, response, self.applied)

    @cached_property
    def constraint_impulses(self) -> tuple[np.ndarray, ...]:
        """Arrays (k,); the p-th multiplies the p-th derivative of Dirac's delta in lambda (N s for p = 0, N s^2, ...)."""
        return reaction_impulses(self.system, self, self.applied)

    @cached_property
    def later_constraint_impulses(self) -> tuple[Blow, ...]:
        """The same after t = 0: for each time at which lambda has impulses a ``Blow``, whose arrays have k rows."""
        return later_reaction_impulses(self.system, self, self.applied)

    def energy(self, times) -> Energy:
        """Kinetic, strain and static energy at a time or at times (T,), in J."""
        return energy_of(self.system, self(times), self.velocity(times))

    @cached_property
    def exact(self) -> ExactResponse:
        """The exact motion of the system as it was given, n rows; its null space is not rounded, there is none."""
        from .exact_motion import exact_motion

        return exact_motion(self)

    @cached_property
    def exact_reaction(self) -> ExactResponse:
        """The exact multipliers lambda, one row per row of ``system.rows``; they have no values at 0- and so no jump."""
        n = self.system.size
        return self.exact.with_rows(range(n, n + len(self.system.rows)))

    def enclose(self, times, digits: int = 15, *, of: Quantity = "displacement", order: int = 0) -> Enclosure:
        """Intervals that are sure to contain a quantity of the motion, as ``Response.enclose``.

        Args:
            times: in s, a number or shape (T,).
            digits: of each value, relative to itself.
            of: displacement, velocity, acceleration or reaction.
            order: of a derivative of it, if any.

        Raises:
            InputError, SingularPolynomialMatrix, Overflow: as ``Response.enclose``; another word for a quantity.
        """
        order = whole_number(order, "order")
        if isinstance(of, str) and of == "reaction":
            return self.exact_reaction.enclose(times, digits, order=order)
        orders = {"displacement": 0, "velocity": 1, "acceleration": 2}
        if not isinstance(of, str) or of not in orders:
            raise InputError(f"of: found {of!r}{nearest(str(of), (*orders, 'reaction'))}; expected {', '.join(orders)} or reaction")
        return super().enclose(times, digits, order=orders[of] + order)

    def error_estimate(self, times, of: Quantity = "displacement", *, order: int = 0) -> float:
        """Estimate of max |error| / max |value| over the times, of displacement, velocity, acceleration or reaction.

        Args:
            times: in s, a number or shape (T,).
            of: the quantity.
            order: of the derivative of it that is meant, if any.

        Raises:
            InputError: another word; times that are negative or not finite; an order that is no whole number of at least 0.
        """
        views = {
            "displacement": lambda x: x.function,
            "velocity": lambda x: x.derivative(1),
            "acceleration": lambda x: x.derivative(2),
            "reaction": self.reaction_of,
        }
        if not isinstance(of, str) or of not in views:
            raise InputError(f"of: found {of!r}{nearest(str(of), views)}; expected one of {', '.join(views)}")
        view, order = views[of], whole_number(order, "order")
        return error_estimate(self, times, lambda x: view(x).derivative(order) if order else view(x))

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """What the user should know, with names and units: broken rows, jumps, impulses, drift, doubtful decisions."""
        from .motion_notices import motion_notices

        return motion_notices(self)


def motion_of(
    system: MechanicalSystem, start: np.ndarray, applied: ImpulsiveSmooth, rank_tolerance: float | None = None
) -> Motion:
    """Solve the constrained form from x(0-), x'(0-) in the rows of start, shape (2, n)."""
    form = system.constrained_form()
    response = solve(form.polynomial_matrix, start, form.force(applied), rank_tolerance)
    return Motion(*(getattr(response, name) for name in TAKEN), events=response.events, system=system, applied=applied)
