"""Matrices as sums of elements, which keep their digits next to stiffer ones, and as tables over the speed; damping of modes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..ground.by_name import Public
from ..ground.checks import counted, real_array
from ..ground.errors import InputError
from ..ground.tolerances import noise_of
from ..polynomial.coefficients import Factors


class ElementMatrix(Public):
    """B^T diag(k) B: one row of B and one constant for each spring, damper or mass of a system with n coordinates.

    ``MechanicalSystem`` takes it in the place of a matrix. Assembled in float64, a spring of 1 N/m that hangs on one of 1e16
    N/m is lost (1e16 + 1 = 1e16); as elements both keep all their digits, and so do the motions.

    Args:
        directions: B, shape (m, n): the elongation of element i is B[i] @ x; entries 0, 1, -1 and lever or gear ratios.
        constants: k, shape (m,): N/m, N s/m or kg (N m/rad, N m s/rad, kg m^2).

    Raises:
        InputError: shapes that do not fit, entries that are not finite.

    >>> springs = ElementMatrix([[1, 0], [-1, 1]], [2.0, 3.0])
    >>> springs.matrix
    array([[ 5., -3.],
           [-3.,  3.]])
    """

    def __init__(self, directions, constants):
        self.constants = real_array(constants, "constants", shape=(None,))
        self.directions = real_array(directions, "directions", shape=(len(self.constants), None))

    def __repr__(self) -> str:
        return f"ElementMatrix({counted(self.size, 'coordinate')}, {counted(len(self.constants), 'element')})"

    @property
    def size(self) -> int:
        """Number n of coordinates."""
        return self.directions.shape[1]

    @cached_property
    def factors(self) -> Factors:
        """B^T, k and B."""
        return Factors(self.directions.T, self.constants, self.directions)

    @cached_property
    def matrix(self) -> np.ndarray:
        """The nearest float64 matrix, exactly symmetric, shape (n, n).

        Raises:
            InputError: an entry is beyond the range of float64.
        """
        try:
            return self.factors.matrix
        except OverflowError:
            raise InputError(
                "elements: B^T diag(k) B has an entry beyond the range of float64; expected directions near 1 and constants "
                "in units in which they are of ordinary size"
            ) from None

    @cached_property
    def spread(self) -> float:
        """Ratio of the largest to the smallest nonzero constant; at most the largest float64."""
        size = np.abs(self.constants[self.constants != 0])
        if not len(size):
            return 1.0
        with np.errstate(over="ignore"):
            return float(min(size.max() / size.min(), np.finfo(float).max))

    def __add__(self, other: ElementMatrix) -> ElementMatrix:
        """The elements of both matrices."""
        return ElementMatrix(np.vstack([self.directions, other.directions]), np.append(self.constants, other.constants))

    def __rmul__(self, factor: float) -> ElementMatrix:
        """Every element multiplied by a number."""
        return ElementMatrix(self.directions, factor * self.constants)


def modal_damping(mass: np.ndarray, stiffness: np.ndarray, rows: np.ndarray, frequencies, shapes, ratios) -> ElementMatrix:
    """C = sum over modes of 2 zeta_i w_i (M u_i)(M u_i)^T with u_i^T M u_j = delta_ij: C u_i = 2 zeta_i w_i M u_i.

    Each undamped mode keeps its shape and becomes s^2 + 2 zeta_i w_i s + w_i^2 = 0; motions in which M x = 0, and modes with the ratio 0,
    are not damped. Where constraint rows A x = b(t) move supports, the motion relative to the static response R b is damped, K R + A^T L = 0, A R = I:
    M u_i becomes (I - R A)^T M u_i, which is the same on all motions with A x = 0. Source: Géradin and Rixen, Mechanical Vibrations (2015), section 3.1.2.
    """
    check_orthogonal("modal damping", mass, stiffness)
    ratios = real_array(ratios, "damping ratios")
    if ratios.ndim > 1 or (ratios.ndim and len(ratios) > len(frequencies)):
        count = counted(len(frequencies), "oscillating mode")
        raise InputError(f"damping ratios: found {ratios.size}; there {'is' if len(frequencies) == 1 else 'are'} {count}")
    if ratios.size and ratios.min() < 0:
        raise InputError(f"damping ratios: found {ratios.min():g}; expected 0 or a positive number, e.g. 0.02")
    zeta = np.pad(ratios, (0, len(frequencies) - len(ratios))) if ratios.ndim else np.full(len(frequencies), ratios)
    damped = zeta != 0
    momenta = mass @ mass_normalized(mass, shapes.real, frequencies)
    momenta -= rows.T @ (static_response(stiffness, rows).T @ momenta)
    return ElementMatrix(momenta[:, damped].T, 2 * (zeta * frequencies)[damped])


def check_orthogonal(what: str, mass: np.ndarray, stiffness: np.ndarray) -> None:
    """Raise an InputError where M or K is not symmetric."""
    for matrix, name in ((mass, "mass"), (stiffness, "stiffness")):
        if np.abs(matrix - matrix.T).max() > noise_of(np.abs(matrix).max(), len(matrix)):
            raise InputError(f"{what}: the {name} matrix is not symmetric, so that its modes are not orthogonal")


def static_response(stiffness: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """R with K R + A^T L = 0 and A R = I, the smallest where a motion is free."""
    size, count = rows.shape[1], len(rows)
    scale = np.abs(stiffness).max(initial=0.0) or 1.0
    saddle = np.block([[stiffness / scale, rows.T], [rows, np.zeros((count, count))]])
    return np.linalg.lstsq(saddle, np.vstack([np.zeros((size, count)), np.eye(count)]), rcond=None)[0][:size]


def relative_mass(mass: ElementMatrix | np.ndarray, stiffness: np.ndarray, rows: np.ndarray) -> ElementMatrix | np.ndarray:
    """(I - R A)^T M (I - R A): the mass matrix of the motion relative to the static response R b of moving supports A x = b."""
    relative = np.eye(rows.shape[1]) - static_response(stiffness, rows) @ rows
    relative[np.abs(relative) <= noise_of(1.0, len(relative))] = 0.0  # the supports themselves do not move relative to their motion
    if isinstance(mass, ElementMatrix):
        return ElementMatrix(mass.directions @ relative, mass.constants)
    return relative.T @ mass @ relative


def mass_normalized(mass: np.ndarray, shapes: np.ndarray, frequencies: np.ndarray) -> np.ndarray:
    """The shapes with U^T M U = I, by Gram-Schmidt twice: modes of one frequency are orthogonal only after it."""
    normal = np.zeros_like(shapes)
    for i, shape in enumerate(shapes.T):
        for _ in range(2):
            shape = shape - normal[:, :i] @ (normal[:, :i].T @ (mass @ shape))
        energy = shape @ mass @ shape
        if not energy > noise_of(np.abs(shape) @ np.abs(mass) @ np.abs(shape), len(shape)):
            raise InputError(f"the mode of {frequencies[i]:.6g} rad/s has no kinetic energy of its own")
        normal[:, i] = shape / np.sqrt(energy)
    return normal


@dataclass(frozen=True, eq=False)
class SpeedTable:
    """Speed-dependent coefficients of a bearing: additions to K and C, piecewise linear in the speed."""

    name: str  # name of the bearing
    speeds: np.ndarray  # W in rad/s, ascending, shape (S,)
    stiffness: np.ndarray  # stiffness, damping: shape (S, n, n)
    damping: np.ndarray

    def _interval(self, speed: float) -> int:
        return int(np.clip(np.searchsorted(self.speeds, speed, side="right") - 1, 0, len(self.speeds) - 2))

    def slope(self, speed: float) -> np.ndarray:
        """The derivatives of K and C; at a speed of the table those above it, shape (2, n, n)."""
        i = self._interval(speed)
        step = self.speeds[i + 1] - self.speeds[i]
        return np.array([self.stiffness[i + 1] - self.stiffness[i], self.damping[i + 1] - self.damping[i]]) / step

    def at(self, speed: float) -> np.ndarray:
        """Additions to K and C, shape (2, n, n), extrapolated by the last piece beyond the table."""
        i = self._interval(speed)
        return np.array([self.stiffness[i], self.damping[i]]) + (speed - self.speeds[i]) * self.slope(speed)


def unbalance_of(first: int, second: int, moment: float, angle: float, size: int) -> np.ndarray:
    """The unbalance u of an eccentric mass, whose force is W^2 Re(u e^{i W t}) = moment W^2 (cos(W t + angle), sin(W t + angle))."""
    u = np.zeros(size, dtype=complex)
    u[[first, second]] = np.array([1.0, -1j]) * moment * np.exp(1j * angle)
    return u
