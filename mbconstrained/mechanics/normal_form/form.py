"""The mechanical normal form of a state-space system."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ...checks import counted, real_array
from ...errors import InputError
from ...jordan.evidence import Evidence
from ...notices import Notice
from ...signals.inputs import ImpulsiveSmooth, step
from ...tolerances import EPS
from ..energy_parts import EnergyParts
from ..system import MechanicalSystem
from .existence import Existence
from .state_space import StateSpaceData


@dataclass(frozen=True)
class NormalForm:
    """x^ = T x of a system F x' = A x + B u, y = C x + D u, in which it reads q'' - A^_22 q' - A^_21 q = B^_2 u, x^ = (q, q').

    Attributes:
        transformation: T, shape (n, n).
        left_transformation: T F^-1, the multiplier of the equations of a descriptor form; T itself without one.
        state_matrix: A^ = T F^-1 A T^-1 = [0, I; A^_21, A^_22], zeros and ones exact.
        input_matrix: B^ = T F^-1 B = [0; I_p], shape (n, p): the inputs are the forces on the last p coordinates.
        output_matrix, feedthrough: C T^-1, shape (m, n), and D; None where no outputs were given.
        freedom: the dimension (n/2) (n - 2 p) of the family of all transformations; none of them is better than others but
            for its condition.
        evidence: what shows how far the form can be trusted: condition, residuals, margins of the conditions of existence.
        notices: warnings; a doubtful one where rounding decides whether the form exists.
        uncertainty: by how much entries of [stiffness, damping] may be wrong by rounding, shape (n/2, n).
    """

    transformation: np.ndarray
    left_transformation: np.ndarray
    state_matrix: np.ndarray
    input_matrix: np.ndarray
    output_matrix: np.ndarray | None
    feedthrough: np.ndarray | None
    evidence: tuple[Evidence, ...] = ()
    notices: tuple[Notice, ...] = ()
    uncertainty: np.ndarray = field(default=None, repr=False)

    @property
    def size(self) -> int:
        """n/2, the number of coordinates q."""
        return len(self.state_matrix) // 2

    @property
    def inputs(self) -> int:
        """p."""
        return self.input_matrix.shape[1]

    @property
    def stiffness(self) -> np.ndarray:
        """-A^_21, shape (n/2, n/2), of unit mass, not symmetric in general."""
        return -self.state_matrix[self.size :, : self.size]

    @property
    def damping(self) -> np.ndarray:
        """-A^_22, likewise."""
        return -self.state_matrix[self.size :, self.size :]

    @property
    def condition(self) -> float:
        """The condition of T in the 2-norm."""
        return float(np.linalg.cond(self.transformation))

    @property
    def freedom(self) -> int:
        """(n/2) (n - 2 p): T may be changed by Q_1 that keeps the inputs, and by more."""
        return self.size * (2 * self.size - 2 * self.inputs)

    @property
    def is_unique(self) -> bool:
        """True for p = n/2: there is no other T."""
        return self.freedom == 0

    def system(self, names: Sequence[str] | None = None, units=None) -> MechanicalSystem:
        """The second-order model with mass I; its force is ``force(u)``.

        Its coordinates are combinations of the machine's with unit masses: the energies of the model are not those of the
        machine, and so modes share none out.

        Args:
            names: of the n/2 coordinates, q1, q2, ... when not given.
            units: of each, "m", "rad" or "1", by name or in order; "1" when not given.

        >>> from mbconstrained import mechanical_normal_form
        >>> form = mechanical_normal_form([[0.0, 1.0], [-4.0, 0.0]], [[0.0], [1.0]])
        >>> form.system().modes().angular_frequencies.tolist()
        [2.0]
        """
        names = [f"q{place + 1}" for place in range(self.size)] if names is None else names
        doubt = {"stiffness": self.uncertainty[:, : self.size], "damping": self.uncertainty[:, self.size :]}
        units = ["1"] * self.size if units is None else units
        matrices = np.eye(self.size), self.damping, self.stiffness
        return MechanicalSystem(*matrices, names=names, units=units, uncertainty=doubt, energy_parts=EnergyParts({}, {}))

    def displacement_velocity(self, x0) -> tuple[np.ndarray, np.ndarray]:
        """q and q', each of shape (n/2,), of a state x, shape (n,): the start of ``system().solve`` for x(0-) = x0.

        For states in columns, shape (n, T), both have shape (n/2, T).
        """
        state = real_array(x0, "x0")
        if state.ndim not in (1, 2) or len(state) != 2 * self.size:
            raise InputError(
                f"x0: expected {2 * self.size} states, found shape {' x '.join(map(str, state.shape)) or 'a single number'}"
            )
        found = self.transformation @ state
        return found[: self.size], found[self.size :]

    def state(self, displacement, velocity) -> np.ndarray:
        """x = T^-1 (q, q') of displacements and velocities, each of shape (n/2,) or, at many times, (n/2, T)."""
        parts = [real_array(value, what) for value, what in ((displacement, "displacement"), (velocity, "velocity"))]
        for part, what in zip(parts, ("displacement", "velocity")):
            if part.ndim not in (1, 2) or len(part) != self.size or part.shape != parts[0].shape:
                raise InputError(f"{what}: found shape {part.shape}; expected {self.size} coordinates, alike in both")
        return np.linalg.solve(self.transformation, np.concatenate(parts))

    def force(self, u) -> ImpulsiveSmooth:
        """The force on the n/2 coordinates that the inputs u are, an ImpulsiveSmooth with p rows or a constant vector (p,)."""
        if not isinstance(u, ImpulsiveSmooth):
            u = step(real_array(u, "u", shape=(self.inputs,)))
        if u.size != self.inputs:
            raise InputError(f"u: it has {u.size} rows; expected one for each of the {self.inputs} inputs")
        return u.mapped(self.input_matrix[self.size :])

    def __str__(self) -> str:
        family = "unique" if self.is_unique else f"one of a family of {counted(self.freedom, 'dimension')}"
        sizes = f"{counted(self.size, 'coordinate')}, {counted(self.inputs, 'input')}"
        lines = [f"mechanical normal form: {sizes}, condition {self.condition:.3g}, {family}"]
        lines += [f"  {item.name}: {item.value:.3g} ({item.text})" for item in self.evidence]
        return "\n".join([*lines, *map(str, self.notices)])


def assembled(data: StateSpaceData, rows: np.ndarray, existence: Existence) -> NormalForm:
    """The form from X^T, shape (n/2, n), which multiplies the equations and whose last p rows hold the inputs."""
    A, half, p = data.A, len(rows), data.B.shape[1]
    T = np.vstack([rows if data.F is None else rows @ data.F, rows @ A])
    lower, doubt_of_lower = _lower_multiplier(data, rows)
    left = np.vstack([rows, lower])
    scale = 1 / np.exp2(np.round(np.log2(np.linalg.norm(T, axis=0))))  # columns alike: fewer digits lost in the solution
    inverse = scale[:, None] * np.linalg.inv(T * scale)
    bottom = _refined(lower @ A, T, inverse)
    state = np.vstack([np.eye(half, 2 * half, k=half), bottom])
    inputs = np.eye(2 * half, p, k=p - 2 * half)
    C = None if data.C is None else _refined(data.C, T, inverse)
    noise = doubt_of_lower @ np.abs(A) + EPS * (np.abs(lower) @ np.abs(A) + np.abs(bottom) @ np.abs(T))
    evidence = _evidence(data, left, T, state, inputs, existence)
    return NormalForm(T, left, state, inputs, C, data.D, evidence, existence.notices, noise @ np.abs(inverse))


def _lower_multiplier(data: StateSpaceData, rows) -> tuple[np.ndarray, np.ndarray]:
    """X^T A F^-1 and its rounding."""
    lower = rows @ data.A
    doubt = EPS * np.abs(rows) @ np.abs(data.A)
    if data.F is None:
        return lower, doubt
    found = np.linalg.solve(data.F.T, lower.T).T
    return found, (doubt + EPS * np.abs(found) @ np.abs(data.F)) @ np.abs(np.linalg.inv(data.F))


def _refined(right, T, inverse) -> np.ndarray:
    """right T^-1, with one step of iterative refinement."""
    found = right @ inverse
    return found + (right - found @ T) @ inverse


def _evidence(data, left, T, state, inputs, existence) -> tuple[Evidence, ...]:
    A, B = data.A, data.B
    size = (np.abs(left) @ np.abs(A) + np.abs(state) @ np.abs(T)).max(axis=0)
    residual = np.abs(left @ A - state @ T) / np.where(size > 0, size, 1.0)
    of_inputs = np.abs(left @ B - inputs) / np.maximum(np.abs(left) @ np.abs(B), 1.0)
    return (
        Evidence("condition", float(np.linalg.cond(T)), "of the transformation T, in the units of the states"),
        Evidence("residual", float(residual.max()), "largest relative residual of T F^-1 A = A^ T"),
        Evidence("input residual", float(of_inputs.max(initial=0.0)), "largest relative residual of T F^-1 B = [0; I]"),
        Evidence("input margin", existence.inputs.ratio, "distance to rank [B, A B] < 2 p, in units of what counts as rounding"),
        Evidence(
            "eigenvalue margin",
            existence.eigenvalues.ratio,
            "least distance found to rank [A - lambda I, B] < n/2 + p over real lambda, in the same units",
        ),
    )
