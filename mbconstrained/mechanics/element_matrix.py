"""A mass, damping or stiffness matrix as the sum of its elements, which keep their digits next to stiffer ones; damping of modes."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from functools import cached_property, partial, reduce
from operator import add
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np

from ..ground.checks import counted, real_array, real_number
from ..ground.errors import InputError
from ..ground.tolerances import noise_of
from ..polynomial.polynomial_matrix import Factors

if TYPE_CHECKING:
    from .modes import Modes
    from .sensitivity.parameter import Parameter


class ElementMatrix:
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
        """The number n of coordinates."""
        return self.directions.shape[1]

    @cached_property
    def matrix(self) -> np.ndarray:
        """The nearest float64 matrix, exactly symmetric, shape (n, n).

        Raises:
            InputError: an entry is beyond the range of float64.
        """
        try:
            return Factors(self.directions.T, self.constants, self.directions).matrix
        except OverflowError:
            raise InputError(
                "elements: B^T diag(k) B has an entry beyond the range of float64; expected directions near 1 and constants "
                "in units in which they are of ordinary size"
            ) from None

    @cached_property
    def spread(self) -> float:
        """The largest of the constants over the smallest, those that are zero left out; at most the largest float64."""
        size = np.abs(self.constants[self.constants != 0])
        if not len(size):
            return 1.0
        with np.errstate(over="ignore"):
            return float(min(size.max() / size.min(), np.finfo(float).max))

    def __add__(self, other: ElementMatrix) -> ElementMatrix:
        """The elements of both."""
        return ElementMatrix(np.vstack([self.directions, other.directions]), np.append(self.constants, other.constants))

    def __rmul__(self, factor: float) -> ElementMatrix:
        """Every element multiplied by a number."""
        return ElementMatrix(self.directions, factor * self.constants)


def modal_damping(mass: np.ndarray, stiffness: np.ndarray, rows: np.ndarray, modes: Modes, ratios) -> ElementMatrix:
    """C = sum over modes of 2 zeta_i w_i (M u_i)(M u_i)^T with u_i^T M u_j = delta_ij: C u_i = 2 zeta_i w_i M u_i.

    Each undamped mode keeps its shape and becomes s^2 + 2 zeta_i w_i s + w_i^2 = 0; motions in which M x = 0, and modes with the ratio 0,
    are not damped. Where constraint rows A x = b(t) move supports, the motion relative to the static response R b is damped, K R + A^T L = 0, A R = I:
    M u_i becomes (I - R A)^T M u_i, which is the same on all motions with A x = 0. Source: Géradin and Rixen, Mechanical Vibrations (2015), section 3.1.2.
    """
    check_orthogonal("modal damping", mass, stiffness)
    frequencies, ratios = modes.natural_frequencies, real_array(ratios, "damping ratios")
    if ratios.ndim > 1 or (ratios.ndim and len(ratios) > len(frequencies)):
        count = counted(len(frequencies), "oscillating mode")
        raise InputError(f"damping ratios: found {ratios.size}; there {'is' if len(frequencies) == 1 else 'are'} {count}")
    if ratios.size and ratios.min() < 0:
        raise InputError(f"damping ratios: found {ratios.min():g}; expected 0 or a positive number, e.g. 0.02")
    zeta = np.pad(ratios, (0, len(frequencies) - len(ratios))) if ratios.ndim else np.full(len(frequencies), ratios)
    damped = zeta != 0
    momenta = mass @ mass_normalized(mass, modes.shapes.real, frequencies)
    momenta -= rows.T @ (static_response(stiffness, rows).T @ momenta)
    return ElementMatrix(momenta[:, damped].T, 2 * (zeta * frequencies)[damped])


def _rounding(part: ElementMatrix) -> np.ndarray:
    """Bounds of what rounding errors of computed directions change in the entries, shape (n, n)."""
    size = np.abs(part.directions)
    error = noise_of(size.max(axis=1, initial=0.0), part.size)[:, None] * size.any(axis=0)
    bound = (size.T * part.constants) @ error
    return bound + bound.T


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


class DampedSystem:
    """Copies of a mechanical system with damping of the system as a whole.

    Attributes:
        loss_factors: eta of structural damping by the name of a spring, for harmonic motion only.
        parameter_source: the parameters of a model that knows them; None for entries of the matrices.
        mass_damping: whether mass-proportional damping acts on the "absolute" velocity or on that "relative" to moving supports; None without.
    """

    mass_damping: Literal["absolute", "relative"] | None = None

    loss_factors: Mapping[str, float] = MappingProxyType({})
    parameter_source: Callable[[], Iterable[Parameter]] | None = None
    given: tuple
    mass: Any
    stiffness: Any
    constraint_matrix: Any
    modes: Callable[..., Any]
    _refuse_sparse: Callable[[str], None]
    damping: Any
    uncertainty: tuple
    is_sparse: bool
    parameters: Callable[[], Any]
    _matrix: Callable[..., Any]
    _reduced_pencil: Callable[[], Any]

    def _refuse_loss_factors(self) -> None:
        """Structural damping has no motion in time: its force would answer before the load."""
        if self.loss_factors:
            name = next(iter(self.loss_factors))
            raise InputError(
                f'solve: the spring "{name}" has a loss factor, which exists for harmonic motion only (in time its force would come '
                "before the motion that causes it); use frequency_response or steady_state, or give it a damper or modal damping"
            )

    def with_rayleigh_damping(self, mass: float = 0.0, stiffness: float = 0.0, relative: bool = False) -> Self:
        """The same system with C + a M + b K for C, proportional (Rayleigh) damping: each mode has zeta = a / (2 w) + b w / 2.

        The part a M acts on absolute velocities, as dampers between every mass and the ground at rest would: where a support
        moves it resists the motion of the whole system with it. With ``relative`` it acts on the velocities relative to the static
        response R b to the motion b of the supports, as seismic codes have it:

            C + a (I - R A)^T M (I - R A) + b K,  K R + A^T L = 0,  A R = I

        which is the same where no support moves. Source: Clough and Penzien, Dynamics of Structures (2003), section 26.

        Args:
            mass: a, at least 0, in 1/s.
            stiffness: b, at least 0, in s.
            relative: whether the part a M acts on velocities relative to moving supports; not of sparse matrices.

        Returns:
            A new system.

        >>> import mbconstrained as mb
        >>> mb.MechanicalSystem(np.eye(1), stiffness=[[4.0]]).with_rayleigh_damping(0.2, 0.1).modes().damping_ratios.round(12)
        array([0.15])
        """
        factors = (real_number(stiffness, "stiffness", minimum=0.0), real_number(mass, "mass", minimum=0.0))
        parts = [factor * self.given[place] for factor, place in zip(factors, (0, 2)) if factor]
        if relative and factors[1]:
            self._refuse_sparse("relative damping")
            parts[-1] = factors[1] * relative_mass(self.given[2], self.stiffness, self.constraint_matrix)
        system = self._with_damping(parts, factors)
        if factors[1]:
            system.mass_damping = "relative" if relative else "absolute"
        if relative and factors[1]:
            system.parameter_source = partial(
                _refuse_parameters, "relative damping follows the static response to moving supports, which"
            )
        return system

    def with_modal_damping(self, ratios) -> Self:
        """The same system with the damping ratios zeta of its undamped modes, in addition to C.

            C + sum of 2 zeta_i w_i (M u_i)(M u_i)^T,  u_i^T M u_j = delta_ij

        Args:
            ratios: one number of all oscillating modes, or those of the lowest ones, ascending by frequency; higher ones stay as they are.

        Returns:
            A new system.

        Raises:
            InputError: sparse matrices, unsymmetric M or K, negative ratios, or more of them than oscillating modes.

        >>> import mbconstrained as mb
        >>> mb.MechanicalSystem(np.eye(2), stiffness=np.diag([4.0, 9.0])).with_modal_damping([0.02, 0.05]).modes().damping_ratios.round(12)
        array([0.02, 0.05])
        """
        self._refuse_sparse("modal damping")
        modes = self.modes(damped=False)
        part = modal_damping(self.mass, self.stiffness, self.constraint_matrix, modes, ratios)
        system = self._with_damping([part])
        if any(mode.kind in ("rigid body", "offset") for mode in modes):  # which rounding errors of M u would damp
            K, C, M = system.uncertainty
            system.uncertainty = (K, C + _rounding(part), M)
        system.parameter_source = partial(_refuse_parameters, "modal damping follows the modes, which")
        return system

    def _with_damping(self, parts: Sequence, factors: tuple[float, float] = (0.0, 0.0)) -> Self:
        """The same system with further damping, whose entries have the errors of K and M times factors."""
        stiffness, own, mass = self.given
        elements = all(isinstance(part, ElementMatrix) for part in (own, *parts))
        matrices = [part if elements or not isinstance(part, ElementMatrix) else part.matrix for part in (own, *parts)]
        system: Any = copy(self)
        total = reduce(add, matrices)
        system.damping = system._matrix(total, "damping", self.mass.shape[0])
        system.given = (stiffness, total if elements else system.damping, mass)
        system._forms = {}
        if self.is_sparse:
            system.pencil = system._reduced_pencil()
        else:
            K, C, M = self.uncertainty
            system.uncertainty = (K, C + factors[0] * K + factors[1] * M, M)
            b, a = factors
            system.parameter_source = partial(_damped_parameters, self, a, b)
        return system


def _damped_parameters(system, mass: float, stiffness: float) -> Iterable[Parameter]:
    return (one.with_damping(mass, stiffness) for one in system.parameters())


def _refuse_parameters(reason: str) -> Iterable[Parameter]:
    raise InputError(
        f"sensitivities: {reason} change with every parameter; give the parameters as "
        "Parameter.of_function(name, value, build), which assembles the system for each value"
    )
