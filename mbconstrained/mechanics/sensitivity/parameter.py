"""Parameters of a mechanical system, each with the derivatives of M, C, K, of the constraint rows and of the static force."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ...ground.checks import real_number
from ...ground.errors import InputError
from ...ground.tolerances import DIFFERENCE_STEP
from ...linalg.division import is_symmetric

if TYPE_CHECKING:
    from ..system import MechanicalSystem

#: Factors of central differences of order 8 (Fornberg 1988): f' = sum of w_i (f(p + i h) - f(p - i h)) / h.
CENTRAL_WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


@dataclass(frozen=True, eq=False)
class Parameter:
    """A number of a system, with the derivatives of its equations; those left out are zero.

    Attributes:
        name: of the parameter.
        value: p in its unit.
        stiffness, damping, mass: dK/dp, dC/dp, dM/dp, shape (n, n).
        force: of the static force, shape (n,).
        rows: by the names of constraint rows the derivatives of the coefficients, shape (n,), and of the value.
        unit: of p.
    """

    name: str
    value: float
    stiffness: np.ndarray | float = 0.0
    damping: np.ndarray | float = 0.0
    mass: np.ndarray | float = 0.0
    force: np.ndarray | float = 0.0
    rows: Mapping[str, tuple[np.ndarray, float]] = field(default_factory=dict)
    unit: str = ""

    @staticmethod
    def of_function(name: str, value: float, build: Callable[[float], MechanicalSystem], unit: str = "") -> Parameter:
        """The derivatives of a function that makes a system, as of a robot whose equilibrium moves with the parameter.

        Central differences of order 8 of the matrices: where these are smooth their errors are near 1e-13. Whatever is computed from
        them is in closed form.

        Args:
            name: of the parameter.
            value: p.
            build: makes the system at a value of p near this one.
            unit: of p.

        Returns:
            The parameter.

        Raises:
            InputError: systems of different coordinates or rows.

        >>> from mbconstrained import MechanicalSystem
        >>> lengths = Parameter.of_function("l", 2.0, lambda l: MechanicalSystem([[3 * l**2]], stiffness=[[9.81 * l]]))
        >>> lengths.mass.round(9).tolist(), lengths.stiffness.round(9).tolist()
        ([[12.0]], [[9.81]])
        """
        step = DIFFERENCE_STEP * abs(real_number(value, f"value of {name}")) or DIFFERENCE_STEP
        total: dict[str, np.ndarray] = {}
        for i, weight in enumerate(CENTRAL_WEIGHTS, 1):
            above, below = (_parts(build(value + sign * i * step)) for sign in (1, -1))
            if above.keys() != below.keys() or any(np.shape(above[key]) != np.shape(below[key]) for key in above):
                raise InputError(
                    f"{name}: coordinates or constraint rows of the system change near {value:g}; there is no derivative"
                )
            change = {key: weight / step * (above[key] - below[key]) for key in above}
            total = {key: total.get(key, 0.0) + change[key] for key in change}
        matrices = {key: total.pop(key) for key in ("stiffness", "damping", "mass", "force")}
        return Parameter(name, float(value), **matrices, rows={key: (row[:-1], row[-1]) for key, row in total.items()}, unit=unit)

    def matrices(self, size: int) -> np.ndarray:
        """dK/dp, dC/dp, dM/dp as one array, shape (3, n, n)."""
        return np.array([np.zeros((size, size)) + matrix for matrix in (self.stiffness, self.damping, self.mass)])

    def constraint_rows(self, system: MechanicalSystem) -> tuple[np.ndarray, np.ndarray]:
        """The derivatives of the independent rows, shape (k, n), and of their values, shape (k,)."""
        zero = (np.zeros(system.size), 0.0)
        rows = [self.rows.get(row.name, zero) for row in system.rows]
        return np.array([row for row, _ in rows]).reshape(len(rows), system.size), np.array([value for _, value in rows])

    def with_damping(self, mass: float, stiffness: float) -> Parameter:
        """The same with C + a M + b K in the place of C.

        Args:
            mass, stiffness: a in 1/s and b in s.

        Returns:
            A parameter of the same name.
        """
        return replace(self, damping=self.damping + mass * self.mass + stiffness * self.stiffness)


def _parts(system: MechanicalSystem) -> dict[str, np.ndarray]:
    """All numbers of the equations by name; each row with its value."""
    parts = {"stiffness": system.stiffness, "damping": system.damping, "mass": system.mass, "force": system.static_force}
    return parts | {row.name: np.append(row.coefficients, row.value) for row in system.rows}


def entry_parameters(system: MechanicalSystem) -> Iterator[Parameter]:
    """The entries of M, C and K that are not zero; of a symmetric matrix both of a pair together.

    Args:
        system: of arrays.

    Returns:
        One parameter for each, named as "stiffness[x1, x2]".
    """
    for what in ("stiffness", "damping", "mass"):
        matrix = getattr(system, what)
        symmetric = is_symmetric(matrix)
        for i, j in np.argwhere(np.triu(matrix) if symmetric else matrix):
            slope = np.zeros_like(matrix)
            slope[i, j] = 1.0
            if symmetric:
                slope[j, i] = 1.0
            yield Parameter(f"{what}[{system.names[i]}, {system.names[j]}]", float(matrix[i, j]), **{what: slope})
