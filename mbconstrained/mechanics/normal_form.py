"""The mechanical normal form of a state-space system (Mayet and Kammermeier, corrected).

Views for comparison: they succeed for fewer systems than the method "extension" of ``mb.mechanical_normal_form``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
import scipy

from ..ground.checks import counted, nearest, real_array, whole_number
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import IllConditioned, InputError
from ..ground.notices import Evidence, Notice, NoticeKind
from ..ground.tolerances import DEFECTIVE_CONDITION, EPS, NOISE_SAFETY, PAIRED_EIGENVALUES, SINGULAR_CONDITION
from ..linalg.arrays import block_diag
from ..linalg.blocks import decoupled, eigenvalues
from ..signals.inputs import ImpulsiveSmooth, step
from .energy import EnergyParts
from .normal_form_existence import (
    NO_CONDITIONS,
    NormalFormExistence,
    ScaledPencil,
    StateSpaceData,
    existence,
    scaled_pencil,
    state_space_data,
)
from .normal_form_parts import DOUBT, InfinitePart, StatePart, descriptor_parts, regular_part
from .system import MechanicalSystem

if TYPE_CHECKING:
    from ..control.state_space import StateSpace

#: Unknowns n^2 of the Kronecker system up to which it is solved; its singular values take n^6 operations.
MOST_UNKNOWNS = 1600

#: Combinations tried of the null space of the Kronecker system.
TRIES = 40

ADVICE = 'use method="extension", which finds a transformation wherever there is one'


def null_space_rows(A: np.ndarray, F: np.ndarray, driven: np.ndarray) -> np.ndarray:
    """X^T by Eqs. 9-14: X = U_B2 [U_K1, U_K2 Z], with Z from appendix C, corrected: the eigenvalues of G in pairs.

    A complex pair makes a column by itself (C.1), two different real eigenvalues make one (C.2, with the value
    (lambda_1 - lambda_2)/2). Real ones are paired across the middle of their order, which separates a multiple eigenvalue if
    anything among the real ones does.
    """
    A, B = np.linalg.solve(F, A), driven
    n, p = B.shape
    U_B = np.linalg.svd(B)[0] if p else np.eye(n)
    U_K = np.linalg.svd(U_B[:, p:].T @ A @ U_B[:, :p])[0] if p else np.eye(n)
    U_K1, U_K2 = U_B[:, p:] @ U_K[:, :p], U_B[:, p:] @ U_K[:, p:]
    X = np.hstack([U_K2 @ _appendix_c(U_K2.T @ A @ U_K2), U_K1])
    return np.linalg.solve(F.T, _unified(X.T, A, B).T).T


def kronecker_rows(A: np.ndarray, F: np.ndarray, B: np.ndarray) -> np.ndarray:
    """X^T by the linear system (15) for all entries of T, and (16) for a descriptor form, where F^T stands in place of F.

    The solution of least norm is regular by luck only. Combinations of it with the null space are tried, and the one with
    the least sum of cosines between its columns is chosen. It needs n^6 operations.
    """
    n, p = B.shape
    if n * n > MOST_UNKNOWNS:
        raise InputError(f'method: found "kronecker" for {n} states; its {n * n} unknowns take n^6 operations: {ADVICE}')
    upper, lower = np.eye(n // 2, n), np.eye(n // 2, n, k=n // 2)
    L = np.vstack([np.kron(A.T, upper) - np.kron(F.T, lower), np.kron(B.T, np.eye(n))])
    right = np.concatenate([np.zeros(n * n // 2), np.eye(n, p, k=p - n).ravel(order="F")])
    U, values, rows = np.linalg.svd(L)
    rank = n * n - (n // 2) * (n - 2 * p)  # the solutions have this dimension wherever rank [B, A B] = 2 p
    least = rows[:rank].T @ ((U[:, :rank].T @ right) / values[:rank])
    random, size = np.random.default_rng(n), max(1.0, float(np.linalg.norm(least)))
    tried = [least, *(least + size * rows[rank:].T @ random.standard_normal(len(rows) - rank) / n for _ in range(TRIES))]
    T = min((vector.reshape(n, n, order="F") for vector in tried), key=_cosines)
    if np.linalg.cond(T) > SINGULAR_CONDITION:
        raise InputError(f'method: found "kronecker", but every solution of the Kronecker system tried is singular; {ADVICE}')
    return T[: n // 2]


def _appendix_c(G) -> np.ndarray:
    """Z, shape (N, N/2), with Z^T G Z_perp regular."""
    values, vectors = scipy.linalg.eig(G)
    if len(G) and np.linalg.cond(vectors) > DEFECTIVE_CONDITION:
        raise InputError(
            f'method: found "null space", but G is defective and appendix C does not cover all Jordan blocks; {ADVICE}'
        )
    real = sorted(np.flatnonzero(values.imag == 0), key=lambda place: values[place].real)
    half = len(real) // 2
    left = np.linalg.inv(vectors).conj().T if len(G) else vectors  # columns: V^-T
    columns = [left[:, place].real for place in np.flatnonzero(values.imag > 0)]
    for one, other in zip(real[:half], real[half:]):
        if abs(values[one] - values[other]) <= PAIRED_EIGENVALUES * np.linalg.norm(G):
            raise InputError(
                f'method: found "null space", but G has the eigenvalue {values[one].real:.6g} too often to pair it with others; '
                f"Eq. 11 leaves out the transformations that mix U_K1 and U_K2, and appendix C those of such blocks; {ADVICE}"
            )
        columns.append(left[:, one].real / np.linalg.norm(left[:, one]) + left[:, other].real / np.linalg.norm(left[:, other]))
    return np.array(columns).T.reshape(len(G), len(G) // 2)


def _unified(rows, A, B) -> np.ndarray:
    """W_1 X^T with W_1 X^T A B = [0; I_p] (Eq. 14)."""
    p, inputs = B.shape[1], rows @ A @ B
    rest = np.linalg.svd(inputs)[0][:, p:] if p else np.eye(len(rows))
    return np.linalg.solve(np.hstack([rest, inputs]), rows)


def _cosines(T) -> float:
    """The paper's cost: the sum of the cosines between columns; infinite for a singular T."""
    if not np.isfinite(T).all() or np.linalg.cond(T) > SINGULAR_CONDITION:
        return np.inf
    unit = T / np.linalg.norm(T, axis=0)
    return float(np.abs(unit.T @ unit).sum())


# X^T of a transformation T = [X^T F; X^T A] that takes the inputs to [0; I_p], of small condition.
#
# B extended by n/2 - p columns B_2 to B_e with [B_e, A B_e] regular gives X^T = [0 I] [B_e, A B_e]^-1 at once. Seen from X^T these
# are the solutions of X^T B = 0 and X^T A B = [0; I_p]: one of them, and any multiple of the (n - 2 p) rows N^T that
# annihilate [B, A B], in each of the n/2 rows. Almost every choice is regular where a normal form exists, and the
# (n/2) (n - 2 p) free numbers serve to make the condition of T small. With a descriptor matrix F the rows multiply the equations:
# X^T B = 0 and X^T A F^-1 B = [0; I_p], and only F^-1 B has to be solved for.

#: Random starting points, and steps from the best of them: local minima are near each other, and a minimum is flat.
STARTS, STEPS = 4, 100

#: For more states than this fewer: each step costs the inverse of a full matrix.
LARGE, STARTS_OF_LARGE, STEPS_OF_LARGE = 60, 2, 30

#: By how much the logarithm of the condition must become smaller for a system in normal form to change its coordinates.
WORTH = 1e-3

#: The logarithm of the condition where T is singular, beyond that of any regular matrix.
SINGULAR = 1e3


@dataclass(frozen=True, eq=False)
class TransformationFamily:
    """All rows X^T = particular + free @ null^T of the transformations of a pencil."""

    A: np.ndarray  # A, F: shape (n, n)
    F: np.ndarray
    particular: np.ndarray  # shape (n/2, n); its last p rows belong to the inputs
    null: np.ndarray  # N, shape (n, n - 2 p), orthonormal, N^T [B, A B] = 0

    def rows(self, free) -> np.ndarray:
        """X^T for the free parameters (n/2, n - 2 p)."""
        return self.particular + free.reshape(len(self.particular), -1) @ self.null.T

    def transformation(self, free) -> np.ndarray:
        """T, shape (n, n)."""
        rows = self.rows(free)
        return np.vstack([rows @ self.F, rows @ self.A])


def family(pair: ScaledPencil) -> TransformationFamily:
    """The solutions of X^T [B, A F^-1 B] = [0, [0; I_p]]."""
    n, p = pair.B.shape
    both = np.hstack([pair.B, pair.A @ pair.input_space])
    Q, R = np.linalg.qr(both, mode="complete") if p else (np.eye(n), np.zeros((n, 0)))
    particular = np.zeros((n // 2, n))
    if p:
        coordinates = np.eye(p) if pair.explicit else np.linalg.inv(pair.input_space.T @ pair.through)
        right = np.vstack([np.zeros((p, p)), coordinates.T])
        particular[n // 2 - p :] = (Q[:, : 2 * p] @ scipy.linalg.solve_triangular(R[: 2 * p], right, trans="T")).T
    return TransformationFamily(pair.A, pair.F, particular, Q[:, 2 * p :])


def well_conditioned_rows(pair: ScaledPencil) -> np.ndarray:
    """X^T in the given units, shape (n/2, n): solutions in those of the pair, improved in the given ones.

    A system that is in normal form keeps its coordinates, the first half of its states.
    """
    solutions = family(pair)
    n, p = pair.B.shape
    coordinates = np.concatenate([np.full(n // 2 - p, pair.rate), pair.input / pair.rate])
    units = np.concatenate([coordinates / pair.rate, coordinates])[:, None], 1 / pair.state
    own = (np.eye(n // 2, n) / (coordinates[:, None] * pair.equation) - solutions.particular) @ solutions.null
    free = _best(solutions, own, units) if 2 * p < n else own
    return coordinates[:, None] * _without_rounding(solutions.rows(free)) * pair.equation


def _best(solutions: TransformationFamily, own, units) -> np.ndarray:
    """The free parameters of the best start, improved; ``own`` where the gain is too small."""
    starts, steps = (STARTS, STEPS) if len(solutions.A) < LARGE else (STARTS_OF_LARGE, STEPS_OF_LARGE)
    start = min([own, *_starts(solutions, starts)], key=lambda free: _condition(free.ravel(), solutions)[0])
    best = _improved(_improved(start, solutions, steps), solutions, steps, *units)
    before, after = (_condition(free.ravel(), solutions, *units)[0] for free in (own, best))
    return own if before <= after + WORTH else best


def _without_rounding(rows) -> np.ndarray:
    """Entries below the noise of their row and column set to zero, so that sparse systems stay sparse."""
    size = np.abs(rows)
    noise = NOISE_SAFETY * EPS * np.minimum(size.max(axis=1, keepdims=True), size.max(axis=0, initial=0.0))
    return np.where(size <= noise, 0.0, rows)


def _starts(solutions: TransformationFamily, count: int) -> Iterator[np.ndarray]:
    """Orthonormal rows for the coordinates, also for those with inputs, without which T may be singular (Eq. 11 as printed)."""
    half, free = len(solutions.particular), solutions.null.shape[1]
    random = np.random.default_rng(half)
    lengths = np.linalg.norm(solutions.particular, axis=1, keepdims=True)
    for _ in range(count):
        start = lengths * random.standard_normal((half, free)) / free**0.5
        start[: free // 2] = np.linalg.qr(random.standard_normal((free, free // 2)))[0].T
        yield start


def _improved(free, solutions: TransformationFamily, steps: int, left=1.0, right=1.0) -> np.ndarray:
    """Quasi-Newton steps on the logarithm of |T| |T^-1| in the Frobenius norm; a worse result is rejected."""
    from scipy.optimize import minimize  # takes half a second

    before = _condition(free.ravel(), solutions, left, right)[0]
    answer = minimize(_condition, free.ravel(), (solutions, left, right), method="L-BFGS-B", jac=True, options={"maxiter": steps})
    return answer.x.reshape(free.shape) if answer.fun < before else free


def _condition(free, solutions: TransformationFamily, left=1.0, right=1.0) -> tuple[float, np.ndarray]:
    """log of |left T right| |(left T right)^-1|, and its gradient by the free numbers."""
    T = left * solutions.transformation(free) * right
    try:
        inverse = np.linalg.inv(T)
    except np.linalg.LinAlgError:
        return SINGULAR, np.zeros(free.shape)
    size, inverse_size = np.linalg.norm(T), np.linalg.norm(inverse)
    if not np.isfinite(size) or not np.isfinite(inverse_size):
        return SINGULAR, np.zeros(free.shape)
    unit = inverse / inverse_size
    gradient = left * (T / size**2 - unit.T @ unit @ inverse.T) * right
    half = len(solutions.particular)
    by_rows = gradient[:half] @ solutions.F.T + gradient[half:] @ solutions.A.T
    return float(np.log(size) + np.log(inverse_size)), (by_rows @ solutions.null).ravel()


@dataclass(frozen=True, repr=False, eq=False)
class NormalForm(Displayed):
    """x^ = T x of a system F x' = A x + B u, y = C x + D u, in which it reads q'' - A^_22 q' - A^_21 q = B^_2 u, x^ = (q, q').

    Where F is singular this is the form of the n_f finite states, and the others, z, follow the inputs at once: x = T^+ x^ + Q z. Then T and L
    are rectangular, L F = T, L A = A^ T and L B = B^.

    Attributes:
        transformation: T, shape (n, n); (n_f, n) of a singular F.
        left_transformation: L = T F^-1, the multiplier of the equations of a descriptor form; T itself without one.
        state_matrix: A^ = T F^-1 A T^-1 = [0, I; A^_21, A^_22], zeros and ones exact.
        input_matrix: B^ = T F^-1 B = [0; I_p], shape (n, p): the inputs are the forces on the last p coordinates. Of a singular F
            it is [0; R], and R of fewer rows where only some combinations of the inputs act on the finite states.
        output_matrix, feedthrough: C T^-1, shape (m, n), and D; None where no outputs were given. Of a singular F, D_0 = D + C Q B_z.
        freedom: the dimension (n/2) (n - 2 p) of the family of all transformations; none of them is better than others but
            for its condition.
        evidence: condition, residuals, margins of the conditions of existence.
        notices: warnings; a doubtful one where rounding decides whether the form exists.
        uncertainty: bounds of the rounding errors of [stiffness, damping], shape (n/2, n).
        inverse: T^+, shape (n, n_f), with T T^+ = I, of a form of fewer coordinates than half the states; None for T^-1.
        infinite: the infinite part z = N z' + B_z u of a singular F; None of a regular one.
        part: the finite part in states of x, which ``reduced`` divides further.
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
    inverse: np.ndarray | None = field(default=None, repr=False)
    infinite: InfinitePart | None = None
    part: StatePart | None = field(default=None, repr=False)

    def _summary(self) -> str:
        family = "unique" if self.is_unique else f"one of a family of {counted(self.freedom, 'dimension')}"
        text = f"{counted(self.size, 'coordinate')}, {counted(self.inputs, 'input')}, condition {self.condition:.2g}, {family}"
        return text + (f", infinite part: {self.infinite._summary()}" if self.infinite else "")

    def _tables(self) -> tuple[TextTable, ...]:
        rows = ((item.name, f"{item.value:.2g}", item.text) for item in self.evidence)
        return TextTable("Evidence", ("quantity", "value", "meaning"), tuple(rows)), notice_table(self.notices)

    @property
    def size(self) -> int:
        """n/2, the number of coordinates q."""
        return len(self.state_matrix) // 2

    @property
    def inputs(self) -> int:
        """Number p of inputs."""
        return self.input_matrix.shape[1]

    @property
    def stiffness(self) -> np.ndarray:
        """-A^_21, shape (n/2, n/2), of unit mass, not symmetric in general."""
        return -self.state_matrix[self.size :, : self.size]

    @property
    def damping(self) -> np.ndarray:
        """-A^_22, shape (n/2, n/2), of unit mass, not symmetric in general."""
        return -self.state_matrix[self.size :, self.size :]

    @property
    def condition(self) -> float:
        """The condition number of T in the 2-norm."""
        return _condition_number(self.transformation)

    @property
    def freedom(self) -> int:
        """Dimension (n/2) (n - 2 p) of the changes of T by Q_1 that keep the inputs."""
        return self.size * (2 * self.size - 2 * int(self.input_matrix.any(axis=1).sum()))

    @property
    def is_unique(self) -> bool:
        """True for p = n/2: T is unique."""
        return self.freedom == 0

    @property
    def polynomial(self) -> tuple[np.ndarray, ...]:
        """D_0, D_1, ... of the transfer function C^ (s I - A^)^-1 B^ + D_0 + D_1 s + ..., each of shape (m, p); D alone of a regular F.

        The impulse response has D_i times the i-th derivative of Dirac's delta. Empty without outputs.
        """
        if self.feedthrough is None:
            return ()
        return (self.feedthrough, *(self.infinite.polynomial[1:] if self.infinite else ()))

    def system(self, names: Sequence[str] | None = None, units=None) -> MechanicalSystem:
        """The second-order model with mass I; its force is ``force(u)``.

        Its coordinates are combinations of the machine's with unit masses: the energies of the model are not those of the
        machine, and its modes have no energy shares. Of a singular F it has the states z of the infinite part as massless coordinates
        after q, z - N z' = B_z u: its mass diag(I, 0) is singular, and its motion has all jumps and Dirac impulses of the
        descriptor system.

        Args:
            names: names of the n/2 coordinates; q1, q2, ... by default. Those of z are z1, z2, ... unless given as well.
            units: units of each, "m", "rad" or "1", by name or in order; "1" by default.

        Returns:
            The model.

        >>> from mbconstrained import mechanical_normal_form
        >>> form = mechanical_normal_form([[0.0, 1.0], [-4.0, 0.0]], [[0.0], [1.0]])
        >>> form.system().modes().natural_frequencies.tolist()
        [2.0]
        """
        massless = self.infinite.size if self.infinite else 0
        names = [f"q{place + 1}" for place in range(self.size)] if names is None else list(names)
        if len(names) == self.size:
            names += [f"z{place + 1}" for place in range(massless)]
        units = ["1"] * (self.size + massless) if units is None else units
        if not isinstance(units, Mapping) and len(units) == self.size:
            units = [*units, *["1"] * massless]
        doubt = {"stiffness": self.uncertainty[:, : self.size], "damping": self.uncertainty[:, self.size :]}
        M, C, K = np.eye(self.size), self.damping, self.stiffness
        if self.infinite:
            N, noise = self.infinite.nilpotent, self.infinite.noise
            M, C, K = (
                block_diag(M, 0.0 * N),
                block_diag(C, -N),
                block_diag(K, np.eye(massless)),
            )
            doubt = {key: block_diag(doubt[key], own) for key, own in (("stiffness", 0.0 * noise), ("damping", noise))}
        return MechanicalSystem(M, C, K, names=names, units=units, uncertainty=doubt, energy_parts=EnergyParts({}, {}))

    def state_space(self) -> StateSpace:
        """The system in the coordinates (q, q'), of a singular F (q, q', z): the same inputs, outputs and transfer function.

        Its solution from ``coordinates(x0)`` has the same outputs, jumps and Dirac impulses as the given system from x0.

        Returns:
            E = diag(I, N), A = diag(A^, I), B = [B^; -B_z], C = [C^, C Q], D; without outputs the states x are those.

        >>> import numpy as np
        >>> from mbconstrained import mechanical_normal_form
        >>> F, A = np.diag([1.0, 1.0, 0.0]), [[0.0, 1.0, 0.0], [-4.0, 0.0, 1.0], [0.0, 0.0, 1.0]]  # x3 = -u drives the oscillator
        >>> form = mechanical_normal_form(A, [[0.0], [0.0], [1.0]], [[1.0, 0.0, 0.0]], descriptor=F)
        >>> form, form.state_space()(1.0).round(12).tolist()
        (NormalForm(1 coordinate, 1 input, condition 1, unique, infinite part: 1 state, index 1), [[-0.2]])
        """
        from ..control.state_space import StateSpace

        states = [f"{rate}{place + 1}" for rate in ("q", "q'") for place in range(self.size)]
        C = self._inverse if self.output_matrix is None else self.output_matrix
        if self.infinite is None:
            return StateSpace(self.state_matrix, self.input_matrix, C, self.feedthrough, states=states)
        part = self.infinite
        own = part.states if part.output_matrix is None else part.output_matrix
        m = part.size
        return StateSpace(
            block_diag(self.state_matrix, np.eye(m)),
            np.vstack([self.input_matrix, -part.input_matrix]),
            np.hstack([C, own]),
            part.feedthrough,
            descriptor=block_diag(np.eye(2 * self.size), part.nilpotent),
            states=[*states, *(f"z{place + 1}" for place in range(m))],
        )

    def coordinates(self, x0) -> np.ndarray:
        """(q, q'), of a singular F (q, q', z), of a state x, shape (n,), or of states in columns, shape (n, T)."""
        n, state = self.transformation.shape[1], real_array(x0, "x0")
        if state.ndim not in (1, 2) or len(state) != n:
            raise InputError(f"x0: expected {n} states, found shape {' x '.join(map(str, state.shape)) or 'a single number'}")
        rows = self.transformation if self.infinite is None else np.vstack([self.transformation, self.infinite.rows])
        return rows @ state

    def displacement_velocity(self, x0) -> tuple[np.ndarray, np.ndarray]:
        """q and q', each of shape (n/2,), of a state x, shape (n,): the start of ``system().solve`` for x(0-) = x0.

        For states in columns, shape (n, T), both have shape (n/2, T). Of a singular F they are (q, z) and (q', 0): what the rates of
        massless coordinates are at 0- does not matter.
        """
        q, rates, z = np.split(self.coordinates(x0), [self.size, 2 * self.size])
        return np.concatenate([q, z]), np.concatenate([rates, 0.0 * z])

    def state(self, displacement, velocity) -> np.ndarray:
        """x = T^-1 (q, q'), of a singular F T^+ (q, q') + Q z.

        Args:
            displacement, velocity: q and q', shape (n/2,) or, at many times, (n/2, T); of a singular F with those of z after them, as
                the motion of ``system()`` has them.

        Returns:
            x, shape (n,) or (n, T).
        """
        count = self.size + (self.infinite.size if self.infinite else 0)
        parts = [real_array(value, what) for value, what in ((displacement, "displacement"), (velocity, "velocity"))]
        for part, what in zip(parts, ("displacement", "velocity")):
            if part.ndim not in (1, 2) or len(part) != count or part.shape != parts[0].shape:
                raise InputError(f"{what}: found shape {part.shape}; expected {count} coordinates, alike in both")
        if self.inverse is None:
            return np.linalg.solve(self.transformation, np.concatenate(parts))
        x = self.inverse @ np.concatenate([part[: self.size] for part in parts])
        return x + self.infinite.states @ parts[0][self.size :] if self.infinite else x

    def force(self, u) -> ImpulsiveSmooth:
        """Force of the inputs u on the coordinates; u is an ImpulsiveSmooth with p rows or a constant vector (p,)."""
        if not isinstance(u, ImpulsiveSmooth):
            u = step(real_array(u, "u", shape=(self.inputs,)))
        if u.size != self.inputs:
            raise InputError(f"u: it has {u.size} rows; expected one for each of the {self.inputs} inputs")
        forces = self.input_matrix[self.size :]
        return u.mapped(np.vstack([forces, self.infinite.input_matrix]) if self.infinite else forces)

    def reduced(self, coordinates: int) -> NormalForm:
        """The normal form of the slowest modes: a second-order model with so many coordinates, and the static response of the others.

        2 r of the finite eigenvalues, those of least modulus, are kept exactly, with their motion from every start; the others
        follow the inputs at once, so that the transfer function is exact at s = 0. The infinite part stays.
        The evidence "truncation" is the largest change of the omitted part of G(i w) from its value at w = 0, at 64 frequencies up to
        the highest kept one, of each entry relative to the largest value of this entry there.

        Args:
            coordinates: r, from 1 to the number of coordinates; of a singular F from 0.

        Returns:
            A form with rectangular T: L F = T, L A = A^ T, L B = B^ hold, and x = T^+ (q, q') without the other modes.

        Raises:
            InputError: r out of range, or so many eigenvalues divide a complex pair or a cluster; a mode that is free or grows is omitted.
            NoNormalForm: the kept modes have no normal form.

        >>> import numpy as np
        >>> from mbconstrained import mechanical_normal_form
        >>> K = np.array([[2.0, -1.0], [-1.0, 30.0]])
        >>> A = np.block([[np.zeros((2, 2)), np.eye(2)], [-K, -0.1 * np.eye(2)]])
        >>> form = mechanical_normal_form(A, [[0.0], [0.0], [0.0], [1.0]], [[1.0, 0.0, 0.0, 0.0]])
        >>> small = form.reduced(1)
        >>> small.system().modes().natural_frequencies.round(6).tolist(), small.state_space()(0.0).round(12).tolist()
        ([1.401546], [[0.016949152542]])
        """
        return _reduced(self, whole_number(coordinates, "coordinates"))

    @property
    def _inverse(self) -> np.ndarray:
        return np.linalg.inv(self.transformation) if self.inverse is None else self.inverse


def _condition_number(T: np.ndarray) -> float:
    return float(np.linalg.cond(T)) if len(T) else 1.0


def _assembled(data: StateSpaceData, rows: np.ndarray, existence: NormalFormExistence) -> NormalForm:
    """The form from X^T, shape (n/2, n), which multiplies the equations and whose last p rows hold the inputs."""
    A, half, p = data.A, len(rows), data.B.shape[1]
    T = np.vstack([rows if data.F is None else rows @ data.F, rows @ A])
    lower, doubt = rows @ A, EPS * np.abs(rows) @ np.abs(A)  # X^T A F^-1 and its rounding error
    if data.F is not None:
        lower = np.linalg.solve(data.F.T, lower.T).T
        doubt = (doubt + EPS * np.abs(lower) @ np.abs(data.F)) @ np.abs(np.linalg.inv(data.F))
    left = np.vstack([rows, lower])
    scale = 1 / np.exp2(np.round(np.log2(np.linalg.norm(T, axis=0))))  # columns alike: fewer digits lost in the solution
    inverse = scale[:, None] * np.linalg.inv(T * scale)
    bottom = _refined(lower @ A, T, inverse)
    state = np.vstack([np.eye(half, 2 * half, k=half), bottom])
    inputs = np.eye(2 * half, p, k=p - 2 * half)
    C = None if data.C is None else _refined(data.C, T, inverse)
    noise = doubt @ np.abs(A) + EPS * (np.abs(lower) @ np.abs(A) + np.abs(bottom) @ np.abs(T))
    evidence = _evidence(data, left, T, state, inputs, existence)
    return NormalForm(T, left, state, inputs, C, data.D, evidence, existence.notices, noise @ np.abs(inverse))


def _refined(right, T, inverse) -> np.ndarray:
    """right T^-1, with one step of iterative refinement."""
    solution = right @ inverse
    return solution + (right - solution @ T) @ inverse


def _evidence(data, left, T, state, inputs, existence) -> tuple[Evidence, ...]:
    A, B = data.A, data.B
    size = (np.abs(left) @ np.abs(A) + np.abs(state) @ np.abs(T)).max(axis=0, initial=0.0)
    residual = np.abs(left @ A - state @ T) / np.where(size > 0, size, 1.0)
    of_inputs = np.abs(left @ B - inputs) / np.maximum(np.abs(left) @ np.abs(B), 1.0)
    of_A, of_B = ("L A = A^ T", "L B = B^") if data.has_infinite_part else ("T F^-1 A = A^ T", "T F^-1 B = [0; I]")
    return (
        Evidence("condition", _condition_number(T), "of the transformation T, in the units of the states"),
        Evidence("residual", float(residual.max(initial=0.0)), f"largest relative residual of {of_A}"),
        Evidence("input residual", float(of_inputs.max(initial=0.0)), f"largest relative residual of {of_B}"),
        Evidence(
            "input margin", existence.inputs.ratio, "distance to rank [B, A B] < 2 p, in units of the bound of rounding errors"
        ),
        Evidence(
            "eigenvalue margin",
            existence.eigenvalues.ratio,
            "least distance to rank [A - lambda I, B] < n/2 + p over real lambda, in the same units",
        ),
    )


# Transformation of (A, B, C, D) to the normal form.

OUT_OF_RANGE = "the normal form leaves the range of float64; choose units of time and of inputs in which A and B are near 1"


def mechanical_normal_form(A, B, C=None, D=None, descriptor=None, method: str = "extension") -> NormalForm:
    """Transform F x' = A x + B u, y = C x + D u into second-order equations of motion by x^ = T x.

    x^ = (q, q') obeys q'' = A^_21 q + A^_22 q' + [0; I_p] u: unit masses, -A^_21 is the stiffness, -A^_22 the damping, and the
    inputs are forces on the last p coordinates. T exists if and only if rank [B, A B] = 2 p and rank [A - lambda I, B] >= n/2 + p
    for every real lambda (F^-1 A and F^-1 B in place of A and B for a descriptor form). This corrects Theorem 2.1 of Mayet and
    Kammermeier, *Mechanical normal form of first order state-space systems*, which is wrong in both directions.

    Where F is singular and det(s F - A) is not zero for every s, the infinite part is split off by the Jordan pairs: n_f finite states have
    the normal form, and the others, z = N z' + B_z u with nilpotent N, are ``infinite``. The form exists if and only if n_f is
    even, rank [B_f, J B_f] = 2 p_f and rank [J - lambda I, B_f] >= n_f/2 + p_f for every real lambda, where J and B_f are those of the finite
    part and p_f = rank B_f; in the data themselves, rank [H_-1 B, H_-2 B] = 2 rank H_-1 B and
    rank [A - lambda F, B] >= n - n_f/2 + rank H_-1 B with the Laurent coefficients H_i of (s F - A)^-1.

    Args:
        A: shape (n, n), n even where F is regular.
        B: shape (n, p), p <= n/2, independent columns; None or no columns for a system without inputs.
        C, D: shape (m, n) and (m, p), where there are outputs.
        descriptor: F, shape (n, n), singular or not, not symmetric in general; the identity when not given. A regular one is not
            inverted: X^T multiplies the equations, T = [X^T F; X^T A], and T F^-1 is the left multiplier of Eq. 16 (corrected: F^T
            where F is printed).
        method: "extension" extends B to B_e with [B_e, A B_e] regular, X^T = [0 I] [B_e, A B_e]^-1 and T = [X^T; X^T A]; of
            the family of all T it takes one of small condition. "null space" (Eqs. 9-14 and appendix C, corrected) and
            "kronecker" (Eqs. 15-16) are the paper's routes. Both fail for some systems that have a normal form: the first
            where it needs what Eq. 11 leaves out or where G is defective, the second where no combination of solutions tried is
            regular, and for many states. Neither makes the condition of T small.

    Returns:
        The form with its evidence.

    Raises:
        NoNormalForm: a condition fails; the text names it, with the ranks and the eigenvalue. Or det(s F - A) = 0 for every s: the text
            names the equations and the states.
        IllConditioned: units so far from the system's own that the form leaves the range of float64.
        InputError: shapes, n odd, p > n/2, dependent inputs, entries that are not finite, a method that fails.

    >>> form = mechanical_normal_form([[1.0, -2.0], [3.0, -2.0]], [[1.0], [1.0]])
    >>> form.stiffness.round(12).tolist(), form.damping.round(12).tolist(), form.is_unique
    ([[4.0]], [[1.0]], True)
    """
    if method not in METHODS:
        expected = ", ".join(f'"{name}"' for name in METHODS)
        raise InputError(f"method: found {method!r}{nearest(method, METHODS)}; expected one of {expected}")
    data = state_space_data(A, B, C, D, descriptor)
    try:
        with np.errstate(over="ignore", under="ignore", invalid="ignore", divide="ignore"):
            form = _of_descriptor(data, METHODS[method]) if data.has_infinite_part else _of_regular(data, METHODS[method])
    except np.linalg.LinAlgError:
        raise IllConditioned(OUT_OF_RANGE) from None
    if not (np.isfinite(form.state_matrix).all() and form.condition < np.inf):
        raise IllConditioned(OUT_OF_RANGE)
    return form


def _of_regular(data: StateSpaceData, rows_of: Callable[[ScaledPencil], np.ndarray]) -> NormalForm:
    pair = scaled_pencil(data)
    exists = existence(pair)
    form = _assembled(data, rows_of(pair), exists)
    doubts = (DOUBT,) if data.rank is not None and not data.rank.clear else ()
    return replace(form, notices=(*form.notices, *doubts), part=regular_part(data))


def _of_descriptor(data: StateSpaceData, rows_of: Callable[[ScaledPencil], np.ndarray]) -> NormalForm:
    """The form of the finite part, in the states of the whole."""
    parts = descriptor_parts(data)
    form = _in_states(parts.finite, rows_of)
    return replace(
        form,
        feedthrough=None if data.C is None else parts.infinite.polynomial[0],
        evidence=(*form.evidence, *parts.evidence),
        notices=(*form.notices, *parts.notices),
        infinite=parts.infinite if parts.infinite.size else None,
    )


def _in_states(part: StatePart, rows_of: Callable[[ScaledPencil], np.ndarray]) -> NormalForm:
    """The form of a part in the states of the whole, with the evidence of T in these."""
    own, exists = _of_part(part, rows_of)
    T, left = own.transformation @ part.start, own.transformation @ part.rows
    inputs = own.input_matrix @ part.inputs
    return replace(
        own,
        transformation=T,
        left_transformation=left,
        input_matrix=inputs,
        evidence=_evidence(part.data, left, T, own.state_matrix, inputs, exists),
        inverse=part.columns @ own.inverse,
        part=part,
    )


def _of_part(part: StatePart, rows_of: Callable[[ScaledPencil], np.ndarray]) -> tuple[NormalForm, NormalFormExistence]:
    """The form of a part in its own states, and the margins of its existence."""
    data, noise = part.independent, part.noise[0]
    if not part.size:
        nothing, inputs = np.zeros((0, 0)), np.zeros((0, data.B.shape[1]))
        return NormalForm(nothing, nothing, nothing, inputs, data.C, data.D, (), (), nothing, nothing), NO_CONDITIONS
    pair = part.pencil()
    exists = existence(pair)
    form = _assembled(data, rows_of(pair), exists)
    inverse = np.linalg.inv(form.transformation)
    X, lower = np.split(np.abs(form.transformation), 2)
    doubt = X @ noise @ np.abs(data.A) + lower @ noise + np.abs(form.damping) @ X @ noise
    return replace(form, inverse=inverse, uncertainty=form.uncertainty + doubt @ np.abs(inverse)), exists


def _reduced(form: NormalForm, coordinates: int) -> NormalForm:
    if coordinates > form.size:
        raise InputError(f"coordinates: found {coordinates}; expected at most {form.size}, which the form has")
    least = 0 if form.infinite else 1
    if coordinates < least:
        raise InputError("coordinates: found 0; expected at least 1 for a system that has no infinite part")
    part, modes = form.part, decoupled(form.part.explicit.A)
    rates = [eigenvalues(block) for block in modes.blocks]
    order = sorted(range(len(rates)), key=lambda place: float(np.abs(rates[place]).max()))
    sizes = np.cumsum([0, *(len(rates[place]) for place in order)])
    if 2 * coordinates not in sizes:
        possible = ", ".join(str(size // 2) for size in sizes if not size % 2 and size >= 2 * least)
        raise InputError(
            f"coordinates: {coordinates} would divide a complex pair or a cluster of eigenvalues; possible are {possible}"
        )
    count = int(np.searchsorted(sizes, 2 * coordinates))
    if count == len(order):
        return form
    noise = NOISE_SAFETY * (np.abs(modes.inverse) @ part.noise[0] @ np.abs(modes.basis)).max(initial=0.0)
    omitted = np.concatenate([rates[place] for place in order[count:]])
    for rate in omitted:
        if rate.real > noise or abs(rate) <= noise:
            motion = "is free" if abs(rate) <= noise else "grows"
            raise InputError(f"coordinates: {coordinates} leaves out the eigenvalue {rate:.6g}, whose motion {motion}; keep more")
    slow, fast = (part.divided(modes, places) for places in (order[:count], order[count:]))
    own = _in_states(slow, well_conditioned_rows)
    static, truncation = _truncated(fast, form, max((float(np.abs(rates[place]).max()) for place in order[:count]), default=0.0))
    text = "largest change of the omitted part of an entry of G(i w) from w = 0 on, at 64 w up to the highest kept eigenvalue, relative to this entry"
    notice = f"{counted(len(omitted), 'eigenvalue')} from {np.abs(omitted).min():.6g} 1/s on follow the inputs at once, as at rest"
    infinite, D = form.infinite, form.feedthrough
    if infinite is not None:
        direct = static if infinite.feedthrough is None else infinite.feedthrough + static
        infinite = replace(infinite, feedthrough=direct, polynomial=(infinite.polynomial[0] + static, *infinite.polynomial[1:]))
    return replace(
        own,
        feedthrough=None if D is None else D + static,
        evidence=(*own.evidence, Evidence("truncation", truncation, text)),
        notices=(*form.notices, *own.notices, Notice(NoticeKind.OMITTED, notice)),
        infinite=infinite,
    )


#: Frequencies at which the omitted part is evaluated, and their step as a part of the band, an irrational one.
FREQUENCIES, GOLDEN = 64, (5**0.5 - 1) / 2


def _truncated(fast: StatePart, form: NormalForm, highest: float) -> tuple[np.ndarray, float]:
    """G_o(0) of the omitted part, and the largest |G_o(i w) - G_o(0)| of an entry relative to its largest |G(i w)|, 0 < w < highest."""
    J, B = fast.explicit.A, fast.explicit.B
    C = fast.columns if fast.explicit.C is None else fast.explicit.C
    static, whole = -C @ np.linalg.solve(J, B), form.state_space()
    s = 1j * highest * (np.arange(1, FREQUENCIES + 1) * GOLDEN % 1.0)
    if not highest:
        return static, 0.0
    inverse = np.linalg.inv(s[:, None, None] * np.eye(fast.size) - J)
    change, terms = np.abs(C @ inverse @ B - static), np.abs(C) @ np.abs(inverse) @ np.abs(B)
    size = np.abs([whole(value) for value in s]).max(axis=0, initial=0.0)
    change = np.where(change > NOISE_SAFETY * EPS * terms, change, 0.0).max(axis=0, initial=0.0)
    return static, float((change / np.where(size > 0, size, 1.0)).max(initial=0.0))


def _in_given_units(pair: ScaledPencil, rows: np.ndarray) -> np.ndarray:
    """The rows X^T in the given units, from those in the units of the pair."""
    rows[len(rows) - len(pair.input) :] *= pair.input[:, None] / pair.rate
    return rows * pair.equation


METHODS: dict[str, Callable[[ScaledPencil], np.ndarray]] = {
    "extension": well_conditioned_rows,
    "null space": lambda pair: _in_given_units(pair, null_space_rows(pair.A, pair.F, pair.through)),
    "kronecker": lambda pair: _in_given_units(pair, kronecker_rows(pair.A, pair.F, pair.B)),
}
