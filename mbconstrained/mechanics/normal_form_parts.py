"""A descriptor system F x' = A x + B u with singular F in its finite and its infinite part, for its normal form.

With the Jordan pairs of s F - A (Moysis et al., Theorem 2.8)

    (s F - A)^-1 = V (s I - J)^-1 P + Q (I - s N)^-1 R,

J for the finite and the nilpotent N for the infinite zeros, every state is x = V x_f + Q z with x_f' = J x_f + P B u and
z = N z' + R B u. The finite part has the normal form, the infinite part follows the inputs and their derivatives at once.

The basis of the finite part is not that of the pairs: rows of C are chosen so that x_f are states of x, those which the finite motion
alone would have. A system whose other states follow algebraically keeps its coordinates so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

from ..ground.checks import counted
from ..ground.display import Displayed
from ..ground.errors import NoNormalForm, SingularPolynomialMatrix
from ..ground.notices import Evidence, Notice, NoticeKind
from ..ground.tolerances import EPS
from ..linalg.blocks import BlockDiagonal, block_matrix, block_slices
from ..linalg.rank import Noisy, null_columns
from ..polynomial.jordan_pairs import JordanPairs
from .normal_form_existence import ScaledPencil, StateSpaceData, scaled_pencil

if TYPE_CHECKING:
    from ..control.state_equations import StateEquations


#: Where rounding decides whether F is singular, or which states belong to the infinite part.
DOUBT = Notice(
    NoticeKind.RANK,
    "rounding errors of F and A may decide which states belong to the infinite part; the normal form may be an artefact of them",
    doubtful=True,
)


@dataclass(frozen=True, repr=False, eq=False)
class InfinitePart(Displayed):
    """The states z of a descriptor system that follow its inputs at once: z = N z' + B_z u, x = (finite part) + Q z.

    From values z(0-) the answer is

        z(t) = sum_i N^i B_z u^(i)(t) - sum_(i >= 1) N^i z(0-) delta^(i-1)(t),    i below the index.

    Attributes:
        nilpotent: N, shape (m, m), strictly upper triangular, in s.
        input_matrix: B_z, shape (m, p).
        states: Q, shape (n, m).
        rows: z = rows x, shape (m, n).
        index: the least k with N^k = 0.
        output_matrix, feedthrough: C Q, shape (k, m), and D; None where no outputs were given.
        polynomial: the matrices D_0, D_1, ... of the polynomial part of the transfer function, D_0 + D_1 s + ...; the impulse
            response contains D_i times the i-th derivative of Dirac's delta. Without outputs those to the states.
    """

    nilpotent: np.ndarray
    input_matrix: np.ndarray
    states: np.ndarray
    rows: np.ndarray
    index: int
    output_matrix: np.ndarray | None
    feedthrough: np.ndarray | None
    polynomial: tuple[np.ndarray, ...]
    noise: np.ndarray = field(repr=False)  # of N, shape (m, m)

    def _summary(self) -> str:
        return f"{counted(self.size, 'state')}, index {self.index}"

    @property
    def size(self) -> int:
        """Number m of states."""
        return len(self.nilpotent)


@dataclass(frozen=True, eq=False)
class StatePart:
    """x_f' = J x_f + B u, y = C x_f, with x = columns x_f + ..., x_f = start x, of the finite part of a system or of some of its modes."""

    name: str  # which part of the system it is, for texts
    data: StateSpaceData  # the whole
    explicit: StateSpaceData  # J, B and C; C is None where no outputs were given
    noise: tuple[np.ndarray, np.ndarray]  # of J and of B
    columns: np.ndarray  # V, shape (n, n_f)
    rows: np.ndarray  # P, shape (n_f, n)
    start: np.ndarray  # P F, shape (n_f, n)

    @cached_property
    def _inputs(self) -> tuple[np.ndarray, Noisy]:
        return _independent_inputs(Noisy(self.explicit.B, self.noise[1]))

    @property
    def inputs(self) -> np.ndarray:
        """R with B = B_1 R, shape (k, p), the identity where all inputs act on this part independently."""
        return self._inputs[0]

    @property
    def own(self) -> Noisy:
        """B_1, the independent columns of B."""
        return self._inputs[1]

    @property
    def independent(self) -> StateSpaceData:
        """The part with B_1 in place of B."""
        return replace(self.explicit, B=self.own.data)

    @property
    def size(self) -> int:
        """Number n_f of states."""
        return len(self.explicit.A)

    def pencil(self) -> ScaledPencil:
        """The independent form in scaled units, known up to its noise."""
        pair, (of_A, of_B) = scaled_pencil(self.independent), (self.noise[0], self.own.noise)
        of_A, of_B = pair.equation[:, None] * of_A * pair.state, pair.equation[:, None] * of_B * pair.input
        known = [
            np.linalg.norm(of_A) / (np.linalg.norm(pair.A) or 1.0),
            *(np.linalg.norm(of_B, axis=0) / np.linalg.norm(pair.B, axis=0)),
        ]
        part = f" of {self.name}, x' = A x + B u with {self.size} of {counted(len(self.data.A), 'state')}"
        return replace(pair, known=max(EPS, *map(float, known)), part=part)

    def divided(self, modes: BlockDiagonal, places: Sequence[int]) -> StatePart:
        """The part of the modes of some blocks of J."""
        slices = block_slices(modes.blocks)
        at = np.concatenate([np.arange(0), *(np.r_[slices[place]] for place in places)])
        rows, columns = modes.inverse[at], modes.basis[:, at]
        own, (of_J, of_B) = self.explicit, self.noise
        J = block_matrix([modes.blocks[place] for place in places])
        explicit = StateSpaceData(J, rows @ own.B, None if own.C is None else own.C @ columns)
        noise = np.abs(rows) @ of_J @ np.abs(columns), np.abs(rows) @ of_B
        return StatePart(
            "the modes that stay", self.data, explicit, noise, self.columns @ columns, rows @ self.rows, rows @ self.start
        )


def regular_part(data: StateSpaceData) -> StatePart:
    """All states of a system with regular F."""
    n = len(data.A)
    if data.F is None:
        noise = EPS * np.abs(data.A), EPS * np.abs(data.B)
        return StatePart("the system", data, data, noise, np.eye(n), np.eye(n), np.eye(n))
    inverse = np.linalg.inv(data.F)
    J, size = inverse @ data.A, np.abs(inverse)
    noise = EPS * (size @ np.abs(data.A) + size @ np.abs(data.F) @ np.abs(J)), EPS * (size @ np.abs(data.B))
    return StatePart("the system", data, StateSpaceData(J, inverse @ data.B, data.C), noise, np.eye(n), inverse, np.eye(n))


@dataclass(frozen=True, eq=False)
class DescriptorParts:
    """Both parts of a descriptor system, with evidence and notices of their decoupling."""

    finite: StatePart
    infinite: InfinitePart
    evidence: tuple[Evidence, ...]
    notices: tuple[Notice, ...]


def descriptor_parts(data: StateSpaceData) -> DescriptorParts:
    """The finite and the infinite part, decoupled."""
    from ..control.state_equations import StateEquations

    A, B, F = data.A, data.B, data.F
    outputs = (np.eye(len(A)), None) if data.C is None else (data.C, data.D)
    system = StateEquations(A, B, outputs[0], outputs[1], F)
    try:
        pairs = system.polynomial_matrix().jordan_pairs()
    except SingularPolynomialMatrix as problem:
        text = f"no mechanical normal form, A(s) = s F - A: {problem}"
        raise NoNormalForm(text, condition="descriptor", rank=data.rank.rank, needed=len(A)) from None
    columns, rows, noisy_rows = _finite_bases(pairs)
    n = columns.shape[1]
    if n % 2:
        raise NoNormalForm(
            f"no mechanical normal form: the finite part of s F - A has {n} of the {counted(len(A), 'state')}, the others follow the inputs at "
            "once; a mechanical system has an even number of finite states, a displacement and a velocity for each coordinate. Work with "
            "the first-order system as it is, mb.StateSpace",
            condition="descriptor",
            rank=n,
            needed=n + 1,
        )
    of_A, of_F = (np.abs(rows) @ np.abs(matrix) @ np.abs(columns) for matrix in (A, F))
    J = rows @ A @ columns
    J = Noisy(J - (rows @ F @ columns - np.eye(n)) @ J, EPS * of_A)
    J = Noisy(J.cleaned(), J.noise + EPS * np.abs(J.data) @ of_F)
    infinite = _infinite_part(data, system, pairs)
    of_inputs = noisy_rows @ Noisy.rounded(B)
    mixed = _mixing(data, J.size, columns, rows, infinite) @ np.abs(infinite.input_matrix)
    C = None if data.C is None else data.C @ columns
    noise = J.noise, of_inputs.noise + mixed
    finite = StatePart("the finite part", data, StateSpaceData(J.data, of_inputs.data, C), noise, columns, rows, rows @ F)
    inputs = finite.inputs
    if 2 * len(inputs) > n:
        raise NoNormalForm(
            f"no mechanical normal form: {counted(len(inputs), 'independent input')} for {counted(n, 'finite state')}; a mechanical system "
            f"of {counted(n // 2, 'coordinate')} takes at most {counted(n // 2, 'independent force')}",
            condition="rank [B, A B]",
            rank=min(n, 2 * len(inputs)),
            needed=2 * len(inputs),
        )
    residual = max(
        _residual(rows, F, columns, np.eye(n)),
        _residual(rows, F, infinite.states, 0.0),
        _residual(rows, A, infinite.states, 0.0),
        _residual(infinite.rows, infinite.states, None, np.eye(infinite.size)),
        _residual(infinite.rows, columns, None, 0.0),
    )
    condition = float(np.linalg.cond(np.hstack([columns, infinite.states])))
    evidence = (
        Evidence("decoupling residual", residual, "largest relative residual of the decoupled finite and infinite part"),
        Evidence("decoupling condition", condition, "of [V, Q], x = V x_f + Q z, in the units of the states"),
    )
    is_clear = infinite.size > 0 and all(decision.clear for decision in pairs.form.split.decisions)
    return DescriptorParts(finite, infinite, evidence, () if is_clear else (DOUBT,))


def _finite_bases(pairs: JordanPairs) -> tuple[np.ndarray, np.ndarray, Noisy]:
    """V and P in the given units, with V the identity in chosen rows, and P with its rounding errors."""
    form, scaling = pairs.form, pairs.form.companion.scaling
    n = form.C.shape[1]
    chosen = np.sort(scipy.linalg.qr(form.C.T, mode="r", pivoting=True)[1][:n])
    basis = form.C[chosen]
    columns = np.linalg.solve(basis.T, form.C.T).T
    columns[chosen] = np.eye(n)
    rows = Noisy.rounded(basis) @ form.noisy_B
    own, left = scaling.columns[chosen], scaling.time * scaling.rows
    columns = Noisy(columns, EPS * np.abs(form.C) @ np.abs(np.linalg.inv(basis))).cleaned()
    columns = scaling.columns[:, None] * columns / own
    return columns, own[:, None] * rows.cleaned() * left, Noisy(own[:, None] * rows.data * left, own[:, None] * rows.noise * left)


def _mixing(data: StateSpaceData, J: np.ndarray, columns: np.ndarray, rows: np.ndarray, infinite: InfinitePart) -> np.ndarray:
    """The mixing of rows of the infinite part into P by rounding errors of F and A: Y = (errors of P A Q - J P F Q) + J Y N, by size."""
    of_A, of_F = (np.abs(rows) @ np.abs(matrix) @ np.abs(infinite.states) for matrix in (data.A, data.F))
    term = total = EPS * (of_A + J @ of_F)
    for _ in range(infinite.index - 1):
        term = J @ term @ np.abs(infinite.nilpotent)
        total = total + term
    return total


def _independent_inputs(B: Noisy) -> tuple[np.ndarray, Noisy]:
    """R and B_1 with B = B_1 R, independent columns B_1 of B; inputs of one column of B_1 alone are exact."""
    compression, p = null_columns(B), B.data.shape[1]
    pivots = np.sort(compression.pivots)
    others, null = np.setdiff1d(np.arange(p), pivots), compression.null.cleaned()
    R = np.zeros((len(pivots), p))
    R[:, pivots] = np.eye(len(pivots))
    R[:, others] = -np.linalg.solve(null[:, others], null[:, pivots]).T
    own = B[:, pivots]
    return R, Noisy(own.cleaned(), own.noise)


def _infinite_part(data: StateSpaceData, system: StateEquations, pairs: JordanPairs) -> InfinitePart:
    from ..control.conversions import through

    form, scaling = pairs.form, pairs.form.companion.scaling
    states, N = scaling.columns[:, None] * form.C2.cleaned(), form.nilpotent.cleaned() / scaling.time
    rows = form.B2.cleaned() * scaling.rows
    index, m = max(pairs.structure.infinite_divisors, default=0), len(N)
    terms = [through(system, order) for order in range(max(index, 1))]
    while len(terms) > 1 and not terms[-1].any():
        terms.pop()
    return InfinitePart(
        nilpotent=N,
        input_matrix=(-(form.B2 @ Noisy.rounded(scaling.rows[:, None] * data.B)).cleaned()).reshape(m, data.B.shape[1]) + 0.0,
        states=states,
        rows=rows @ data.A,
        index=index,
        output_matrix=None if data.C is None else data.C @ states,
        feedthrough=data.D,
        polynomial=(system.D + terms[0], *terms[1:]),
        noise=form.nilpotent.noise / scaling.time,
    )


def _residual(left, matrix, right, wanted) -> float:
    """|left matrix right - wanted| relative to the terms of each entry's row and column."""
    size = np.abs(left) @ np.abs(matrix)
    value = left @ matrix
    if right is not None:
        value, size = value @ right, size @ np.abs(right)
    scale = np.maximum(size.max(axis=1, keepdims=True, initial=0.0), np.abs(wanted))
    return float((np.abs(value - wanted) / np.where(scale > 0, scale, 1.0)).max(initial=0.0))
