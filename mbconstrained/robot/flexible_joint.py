"""Motors of joints: rigid gears, flexible joints (Spong's model), and the equations of these without motors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import real_number
from ..ground.errors import InputError
from ..ground.tolerances import noise_of
from ..mechanics.equations import EquationsOfMotion
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.response import Response
from ..response.solve import solve
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import step


def _check_numbers(part: Motor | FlexibleJoint, what: str, positive: tuple[str, ...]) -> None:
    """Check the fields of a part: some are positive, none is negative."""
    for name, value in vars(part).items():
        limits = {"positive": True} if name in positive else {"minimum": 0.0}
        object.__setattr__(part, name, real_number(value, f"{what}: {name.replace('_', ' ')}", **limits))


@dataclass(frozen=True)
class Motor(Public):
    """A motor that drives a joint through a rigid gear.

    It adds to the joint's mass, stiffness and damping

        armature + gear_ratio^2 rotor_inertia,        position_gain,        velocity_gain

    The joint keeps the guess, since its control carries the load, where there is a position gain. For a joint that slides read N for
    N m and m for rad. Of the rotor only the inertia about its own axis enters; its mass belongs to the link that carries it.

    Attributes:
        armature: inertia at the joint's side (kg m^2).
        rotor_inertia: of the rotor, in front of the gear (kg m^2).
        gear_ratio: turns of the motor for one of the joint.
        position_gain, velocity_gain: of the motor's control, at the joint's side (N m/rad, N m s/rad).

    >>> Motor(rotor_inertia=1e-4, gear_ratio=100, position_gain=500.0).reflected_inertia
    1.0
    """

    armature: float = 0.0
    rotor_inertia: float = 0.0
    gear_ratio: float = 1.0
    position_gain: float = 0.0
    velocity_gain: float = 0.0

    def __post_init__(self):
        _check_numbers(self, "motor", ("gear_ratio",))

    @property
    def reflected_inertia(self) -> float:
        """The inertia at the joint's side (kg m^2)."""
        return self.armature + self.rotor_inertia * self.gear_ratio**2


@dataclass(frozen=True)
class FlexibleJoint(Public):
    """A motor that drives a joint through an elastic gear, its angle theta measured behind the gear:

        B theta'' + (k + c d/dt) (theta - q) + k_d theta' + k_p theta = tau,        B = gear_ratio^2 motor_inertia

    theta and q being deviations from the equilibrium; on the joint acts (k + c d/dt) (theta - q). Only the rotor's
    inertia about its own axis enters; its mass belongs to the link that carries it. For a joint that slides
    read N for N m and m for rad.

    Attributes:
        stiffness: k (N m/rad), greater than zero.
        damping: c (N m s/rad).
        motor_inertia: of the rotor, in front of the gear (kg m^2).
        gear_ratio: turns of the motor for one of the joint.
        proportional_gain, derivative_gain: k_p and k_d of the motor's position control, at the joint's side
            (N m/rad, N m s/rad).

    >>> FlexibleJoint(stiffness=8000.0, motor_inertia=1e-4, gear_ratio=100).reflected_inertia
    1.0
    """

    stiffness: float
    damping: float = 0.0
    motor_inertia: float = 0.0
    gear_ratio: float = 1.0
    proportional_gain: float = 0.0
    derivative_gain: float = 0.0

    def __post_init__(self):
        _check_numbers(self, "flexible joint", ("stiffness", "gear_ratio"))

    @property
    def reflected_inertia(self) -> float:
        """B, the rotor inertia reflected to the joint (kg m^2)."""
        return self.motor_inertia * self.gear_ratio**2


# Elimination of the motors: a polynomial matrix of degree 4 in the coordinates of the links.
#
# With R(s) = M s^2 + D s + K of the links (their gears included), S = c s + k of each gear and
# Z = B s^2 + (k_d + c) s + k_p + k of each motor, the doubled equations
#
# R q - S theta - J^T lambda = f,     Z theta - S q = tau,     J q = 0
#
# become, the rows of flexible joints multiplied by Z and theta put in from the second,
#
# (Z R - S^2) q - Z J^T lambda = Z f + S tau,     J q = 0.
#
# Loops keep their multipliers as coordinates: Z does not commute with a basis of null(J).


class WithoutMotors:
    """A linearized robot in the coordinates of its links, followed by the multipliers of its loops.

    Attributes:
        system: the linearized robot with its motors.
        flexible_joints: with the places of their links' coordinates.
        names: names of the links' coordinates, then of the rows of the loops.
    """

    def __init__(self, system: EquationsOfMotion, flexible_joints: tuple[tuple[int, FlexibleJoint], ...]):
        self.system, self.flexible_joints = system, flexible_joints
        self._links = system.size - len(flexible_joints)
        self._motors = {link: (self._links + motor, joint) for motor, (link, joint) in enumerate(flexible_joints)}
        self.names = (*system.names[: self._links], *(row.name for row in system.rows))

    @cached_property
    def polynomial_matrix(self) -> PolynomialMatrix:
        """[Z R - S^2, -Z J^T; J s^level, 0], its degree 4 where a joint is flexible."""
        system, n = self.system, self._links
        count = len(self.names)
        coefficients = np.zeros((5, count, count))
        R = np.array([matrix[:n, :n] for matrix in (system.stiffness, system.damping, system.mass)])
        J = system.constraint_matrix[:, :n]
        for link in range(n):
            Z, S = self._gear(link)
            for power, factor in enumerate(Z):
                coefficients[power : power + 3, link, :n] += factor * R[:, link]
                coefficients[power, link, n:] -= factor * J[:, link]
            square = np.convolve(S, S)
            coefficients[: len(square), link, link] -= square
        for place, row in enumerate(system.rows):
            coefficients[row.order, n + place, :n] = J[place]
        while len(coefficients) > 1 and not coefficients[-1].any():
            coefficients = coefficients[:-1]
        return PolynomialMatrix(coefficients, coordinates=self.names)

    def solve(self, displacement=None, velocity=None, force=None) -> Response:
        """The motion; the arguments are those of the linearized robot's ``solve``, motors included.

        The values of the second and third derivatives at 0- are those of the motion without force.

        Args:
            displacement, velocity: at 0-, shape (n,) or by name (m, rad; m/s, rad/s).
            force: a constant vector (n,), a mapping or a signal with n rows (N, N m).

        Returns:
            The motion, a row for each of ``names``.

        Raises:
            InputError: the masses do not determine the accelerations, so that there are no such values.
        """
        system = self.system
        start = [system._vector(displacement, "displacement"), system._vector(velocity, "velocity")]
        return solve(self.polynomial_matrix, self._initial(*start), self._force(force))

    def _gear(self, link: int) -> tuple[np.ndarray, np.ndarray]:
        """Coefficients of Z and S in ascending powers; 1 and 0 for a joint without a motor."""
        if link not in self._motors:
            return np.ones(1), np.zeros(1)
        at, joint = self._motors[link]
        Z = [matrix[at, at] for matrix in (self.system.stiffness, self.system.damping, self.system.mass)]
        return np.array(Z), np.array([joint.stiffness, joint.damping])

    def _force(self, force) -> ImpulsiveSmooth:
        """Z f + S tau, for derivatives in the sense of distributions."""
        system = self.system
        total = system.force
        if force is not None:
            total = total + (force if isinstance(force, ImpulsiveSmooth) else step(system._vector(force, "force")))
        maps = np.zeros((3, len(self.names), system.size))
        for link in range(self._links):
            Z, S = self._gear(link)
            maps[: len(Z), link, link] = Z
            if link in self._motors:
                maps[: len(S), link, self._motors[link][0]] = S
        first = total.distribution_derivative()
        return total.mapped(maps[0]) + first.mapped(maps[1]) + first.distribution_derivative().mapped(maps[2])

    def _initial(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """q and its derivatives up to the third, lambda and its first, as the motion without force has them; shape (q, r)."""
        a, multipliers = self._free_motion(x, v)
        jerk, rates = self._free_motion(v, a)
        n, nothing = self._links, np.zeros_like(multipliers)
        rows = [(x, multipliers), (v, rates), (a, nothing), (jerk, nothing)]
        degree = self.polynomial_matrix.degree
        return np.array([np.concatenate([motion[:n], force]) for motion, force in rows])[:degree]

    def _free_motion(self, x: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """x'' and lambda from M x'' - J^T lambda = -C x' - K x, J x'' = 0."""
        system, J = self.system, self.system.constraint_matrix
        matrix = np.block([[system.mass, -J.T], [J, np.zeros((len(J), len(J)))]])
        load = np.concatenate([-system.damping @ v - system.stiffness @ x, np.zeros(len(J))])
        scale = np.abs(matrix).max(axis=1)
        if not scale.all():
            raise self._undetermined()
        solution, _, rank, values = np.linalg.lstsq(matrix / scale[:, None], load / scale, rcond=None)
        if rank < len(matrix) or not np.isfinite(solution).all() or values[-1] < noise_of(values[0], len(matrix)):
            raise self._undetermined()
        return solution[: system.size], solution[system.size :]

    def _undetermined(self) -> InputError:
        return InputError(
            "without_motors: the masses and motor inertias do not determine the accelerations, so that values of higher "
            "derivatives at the start are not known; solve the doubled system, or give every motor and link an inertia"
        )
