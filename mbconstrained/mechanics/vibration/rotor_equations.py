"""The equations of a rotor at constant speed W, M x'' + (C + W G) x' + (K + W N) x = f, with speed-dependent bearings."""

from __future__ import annotations

from copy import copy
from itertools import pairwise, product
from typing import TYPE_CHECKING, TypeVar

import numpy as np

from ...ground.checks import real_number
from ...ground.errors import InputError
from ..equations import EquationsOfMotion
from ..sensitivity.parameter import Parameter

if TYPE_CHECKING:
    from ...polynomial.variation import MatrixFamily


Rotor = TypeVar("Rotor", bound=EquationsOfMotion)


def at_speed(system: Rotor, speed: float) -> Rotor:
    """The rotor at a constant speed."""
    speed = real_number(speed, "speed")
    check_rotor(system, speed)
    stiffness, damping, mass = system.given
    result, rest = copy(system), (system.stiffness, system.damping)
    now, slope = rotor_matrices(system, speed), rotor_slopes(system, speed)
    if (now[0] != rest[0]).any():
        result.stiffness = stiffness = system._matrix(now[0], "stiffness", system.size)
    if (now[1] != rest[1]).any():
        result.damping = damping = system._matrix(now[1], "damping", system.size)
    result.given, result._forms = (stiffness, damping, mass), {}
    result.gyroscopic = result.circulatory = result.unbalance = None
    result.speed_tables = ()
    own = Parameter("speed", speed, stiffness=slope[0], damping=slope[1], unit="rad/s")
    result.parameter_source = lambda: (*system.parameters(), own)
    return result


def check_rotor(system: EquationsOfMotion, *speeds: float) -> None:
    """Raise an InputError unless the system has dense arrays and depends on a speed."""
    system._refuse_sparse("rotation")
    if not system.turns:
        raise InputError(
            "speed: this system does not depend on a speed of rotation; give MechanicalSystem(..., gyroscopic=G) or circulatory=N, "
            "or a rotor of a lumped model"
        )
    for table, speed in product(system.speed_tables, speeds):
        low, high = table.speeds[[0, -1]]
        if not low <= speed <= high:
            raise InputError(
                f'speed: found {speed:g} rad/s; the table of the bearing "{table.name}" is from {low:g} to {high:g} rad/s, '
                "and is not continued beyond"
            )


def unbalance_of(first: int, second: int, moment: float, angle: float, size: int) -> np.ndarray:
    """The unbalance u of an eccentric mass, whose force is W^2 Re(u e^{i W t}) = moment W^2 (cos(W t + angle), sin(W t + angle))."""
    u = np.zeros(size, dtype=complex)
    u[[first, second]] = np.array([1.0, -1j]) * moment * np.exp(1j * angle)
    return u


def rotor_matrices(system: EquationsOfMotion, speed: float) -> np.ndarray:
    """K, C and M at a speed."""
    zero = np.zeros((system.size,) * 2)
    N, G = (zero if matrix is None else matrix for matrix in (system.circulatory, system.gyroscopic))
    total = np.array([system.stiffness + speed * N, system.damping + speed * G, system.mass])
    for table in system.speed_tables:
        total[:2] += table.at(speed)
    return total


def rotor_slopes(system: EquationsOfMotion, speed: float) -> np.ndarray:
    """The derivatives of K, C and M with respect to the speed."""
    zero = np.zeros((system.size,) * 2)
    total = np.array([zero if matrix is None else matrix for matrix in (system.circulatory, system.gyroscopic, None)])
    for table in system.speed_tables:
        total[:2] += table.slope(speed)
    return total


def speed_ranges(system: EquationsOfMotion) -> list[tuple[float, float]]:
    """The intervals in which the matrices are linear in the speed: all speeds without tables, else those that all tables cover."""
    if not system.speed_tables:
        return [(0.0, np.inf)]
    low, high = (pick(table.speeds[end] for table in system.speed_tables) for pick, end in ((max, 0), (min, -1)))
    return [(a, b) for a, b in pairwise(_knots(system)) if low <= a and b <= high]


def _knots(system: EquationsOfMotion) -> np.ndarray:
    return np.unique([speed for table in system.speed_tables for speed in table.speeds])


def rotor_family(system: EquationsOfMotion, within: float | None = None) -> tuple[MatrixFamily, np.ndarray]:
    """The equations over the speed, in coordinates that satisfy all constraint rows."""
    from ...polynomial.variation import MatrixFamily

    check_rotor(system)
    V = system.position_form().null_space

    def reduced(matrices: np.ndarray) -> np.ndarray:
        return np.array([V.T @ matrix @ V for matrix in matrices])

    if within is not None or not system.speed_tables:
        at = within or 0.0
        slope = rotor_slopes(system, at)
        return MatrixFamily.linear(reduced(rotor_matrices(system, at) - at * slope), reduced(slope)), V
    knots = _knots(system)
    pattern = (np.array([reduced(rotor_matrices(system, knot)) for knot in knots]) != 0).any(axis=(0, 1))
    return MatrixFamily(lambda W: reduced(rotor_matrices(system, W)), lambda W: reduced(rotor_slopes(system, W)), pattern, knots), V
