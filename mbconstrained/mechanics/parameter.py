"""Parameters of a mechanical system, each with the derivatives of M, C, K, of the constraint rows and of the static force."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from ..ground.by_name import Public, answering
from ..ground.checks import nearest, real_array, real_number
from ..ground.errors import InputError
from ..ground.tolerances import DIFFERENCE_STEP, EPS
from ..linalg.division import is_symmetric
from .constraints import ConstraintRow

#: Parameters that a message lists.
MOST_NAMES = 12

MATRICES = ("stiffness", "damping", "mass", "force")

#: Factors of central differences of order 8 (Fornberg 1988): f' = sum of w_i (f(p + i h) - f(p - i h)) / h.
CENTRAL_WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)

#: Weights of the central difference of order 6.
LOWER_WEIGHTS = (3 / 4, -3 / 20, 1 / 60, 0.0)

#: Factors of the eighth difference, of f(p) and of f(p + i h) + f(p - i h): what is left of a smooth function is noise, which is larger
#: than the noise of the first derivative by 1 / 0.01 (More and Wild 2011); ten times that, because it is one sample.
EIGHTH_DIFFERENCE, NOISE_OF_DIFFERENCE = (70.0, -56.0, 28.0, -8.0, 1.0), 0.1


class Assembled(Protocol):
    """The numbers of a system of arrays, in which its parameters are."""

    mass: Any
    damping: Any
    stiffness: Any
    static_force: np.ndarray
    names: tuple[str, ...]

    @property
    def size(self) -> int: ...

    @property
    def rows(self) -> tuple[ConstraintRow, ...]: ...


@answering
@dataclass(frozen=True, eq=False)
class Parameter(Public):
    """A parameter of a system, with the derivatives of its equations; omitted ones are zero.

    Attributes:
        name: name of the parameter.
        value: p in its unit.
        stiffness, damping, mass: dK/dp, dC/dp, dM/dp, shape (n, n).
        force: derivative of the static force, shape (n,).
        rows: derivatives of the coefficients, shape (n,), and of the value of constraint rows, by name.
        unit: unit of p.
        error: estimates of the errors of these derivatives, as a parameter of the same form; None: rounding errors.
    """

    name: str
    value: float
    stiffness: np.ndarray | float = 0.0
    damping: np.ndarray | float = 0.0
    mass: np.ndarray | float = 0.0
    force: np.ndarray | float = 0.0
    rows: Mapping[str, tuple[np.ndarray, float]] = field(default_factory=dict)
    unit: str = ""
    error: Parameter | None = None

    @staticmethod
    def of_function(name: str, value: float, build: Callable[[float], Assembled], unit: str = "") -> Parameter:
        """Return the derivatives of a function that returns a system, such as a robot whose equilibrium depends on the parameter.

        Central differences of order 8 of the matrices: where these are smooth their errors are near 1e-13. Their estimates
        are the distance to differences of order 6 and the noise in the eighth difference. Whatever is computed from them is in closed form.

        Args:
            name: name of the parameter.
            value: p.
            build: makes the system at a value of p near this one.
            unit: unit of p.

        Returns:
            The parameter.

        Raises:
            InputError: systems of different coordinates or rows; no system at a value near p.

        >>> from mbconstrained import MechanicalSystem
        >>> lengths = Parameter.of_function("l", 2.0, lambda l: MechanicalSystem([[3 * l**2]], stiffness=[[9.81 * l]]))
        >>> lengths.mass.round(9).tolist(), lengths.stiffness.round(9).tolist()
        ([[12.0]], [[9.81]])
        """
        step = DIFFERENCE_STEP * abs(real_number(value, f"value of {name}")) or DIFFERENCE_STEP
        step, pairs = _pairs(build, float(value), step)
        center = _parts(build(value))
        shapes = {key: part.shape for key, part in center.items()}
        if any({key: part.shape for key, part in one.items()} != shapes for pair in pairs for one in pair):
            raise InputError(f"{name}: coordinates or constraint rows of the system change near {value:g}; there is no derivative")
        slopes, errors = {}, {}
        for key, middle in center.items():
            odd, even = (np.array([above[key] + sign * below[key] for above, below in pairs]) for sign in (-1, 1))
            slopes[key] = np.tensordot(CENTRAL_WEIGHTS, odd, 1) / step
            truncation = np.abs(np.tensordot(np.subtract(CENTRAL_WEIGHTS, LOWER_WEIGHTS), odd, 1))
            noise = EIGHTH_DIFFERENCE[0] * middle + np.tensordot(EIGHTH_DIFFERENCE[1:], even, 1)
            rounding = EPS * np.abs(middle) * odd.any(axis=0)
            errors[key] = (truncation + NOISE_OF_DIFFERENCE * np.abs(noise) + rounding) / step
        return replace(_of_parts(name, float(value), slopes), unit=unit, error=_of_parts(name, float(value), errors))

    def matrices(self, size: int) -> np.ndarray:
        """dK/dp, dC/dp, dM/dp as one array, shape (3, n, n)."""
        return np.array([np.zeros((size, size)) + matrix for matrix in (self.stiffness, self.damping, self.mass)])

    def constraint_rows(self, system: Assembled) -> tuple[np.ndarray, np.ndarray]:
        """The derivatives of the independent rows, shape (k, n), and of their values, shape (k,)."""
        zero = (np.zeros(system.size), 0.0)
        rows = [self.rows.get(row.name, zero) for row in system.rows]
        return np.array([row for row, _ in rows]).reshape(len(rows), system.size), np.array([value for _, value in rows])

    def with_damping(self, mass: float, stiffness: float) -> Parameter:
        """Return the parameter with C + a M + b K in the place of C.

        Args:
            mass, stiffness: a in 1/s and b in s.

        Returns:
            A parameter of the same name.
        """
        error = self.error and self.error.with_damping(abs(mass), abs(stiffness))
        return replace(self, damping=self.damping + mass * self.mass + stiffness * self.stiffness, error=error)


def _pairs(build: Callable[[float], Assembled], value: float, step: float, again: int = 2) -> tuple[float, list]:
    """A step for which the system exists on both sides of p, and the parts of the systems above and below p."""
    try:
        return step, [[_parts(build(value + sign * i * step)) for sign in (1, -1)] for i in range(1, 1 + len(CENTRAL_WEIGHTS))]
    except InputError:  # as where a robot collapses under a tenth more mass
        if not again:
            raise
        return _pairs(build, value, step / 10, again - 1)


def _parts(system: Assembled) -> dict[str, np.ndarray]:
    """The entries of the equations by name; each row with its value."""
    parts = {"stiffness": system.stiffness, "damping": system.damping, "mass": system.mass, "force": system.static_force}
    return parts | {row.name: np.append(row.coefficients, row.value) for row in system.rows}


def _of_parts(name: str, value: float, parts: Mapping[str, np.ndarray]) -> Parameter:
    """A parameter from derivatives of the entries of the equations."""
    K, C, M, force = (parts[key] for key in MATRICES)
    return Parameter(name, value, K, C, M, force, {key: (row[:-1], row[-1]) for key, row in parts.items() if key not in MATRICES})


def parameter_named(parameters: Sequence[Parameter], name: str) -> Parameter:
    """The parameter of this name, or an InputError."""
    known = {one.name: one for one in parameters}
    if name not in known:
        names = ", ".join(list(known)[:MOST_NAMES]) or "none"
        raise InputError(f'there is no parameter "{name}"{nearest(str(name), list(known))}; there are {names}')
    return known[name]


def ascending(values, what: str, wanted: str) -> np.ndarray:
    """Two or more ascending numbers; ``wanted`` ends the message of the InputError for others."""
    values = real_array(values, what, shape=(None,))
    if len(values) < 2 or not (np.diff(values) > 0).all():
        raise InputError(f"{what}: found {len(values)} values; expected two or more, ascending{wanted}")
    return values


def entry_parameters(system: Assembled) -> Iterator[Parameter]:
    """Parameters for the nonzero entries of M, C and K; for symmetric matrices one for each pair."""
    for what in ("stiffness", "damping", "mass"):
        matrix = getattr(system, what)
        symmetric = is_symmetric(matrix)
        for i, j in np.argwhere(np.triu(matrix) if symmetric else matrix):
            slope = np.zeros_like(matrix)
            slope[i, j] = 1.0
            if symmetric:
                slope[j, i] = 1.0
            yield Parameter(f"{what}[{system.names[i]}, {system.names[j]}]", float(matrix[i, j]), **{what: slope})
