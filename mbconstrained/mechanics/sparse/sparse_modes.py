"""The modes of lowest frequency of sparse matrices with their evidence: residuals, orthogonality, and a count of missing modes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from ...ground.checks import counted
from ...ground.display import TextTable, notice_table
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, NOISE_SAFETY, TRUST_LIMIT
from ..modes import Kind, Mode, Modes
from .damped_modes import DampedModes, damped_modes
from .pencil import ReducedPencil
from .sparse_matrices import times
from .undamped_modes import UndampedModes, undamped_modes


@dataclass(frozen=True, repr=False, eq=False)
class SparseModes(Modes):
    """Modes of lowest frequency of M x'' + C x' + K x = 0 with A x = 0, each Re(u e^{s t}); ascending by |s|.

    The shapes u satisfy the constraints. Those of undamped modes are real with X^T M X = I, those of damped modes complex with
    x^T (2 s M + C) x = 2 i |Im s|, which is x^T M x = 1 without damping.

    Attributes:
        vectors: the shapes of all modes, one a column, shape (n, m).
        residuals: |s^2 M u + s C u + K u| of each mode without constraint forces, relative to the sizes of its terms, shape (m,).
        bounds: the part of the residuals that rounding errors and the stopping rule explain, in the same measure, shape (m,).
        orthogonality: the largest entry of X^T M X - I; of damped modes that of the corresponding bilinear form.
        counted_below: the frequency in rad/s below which Sylvester's law of inertia counted the undamped modes; None where it
            could not.
        none_missed: whether the count agrees with the modes below that frequency.
        complete: whether the system has no other finite undamped modes.
        notices: modes that may be missing, residuals beyond their bound, redundant rows.
    """

    vectors: np.ndarray
    residuals: np.ndarray = field()
    bounds: np.ndarray
    orthogonality: float
    counted_below: float | None
    none_missed: bool
    complete: bool
    notices: tuple[Notice, ...] = ()

    def __getitem__(self, index):
        """A ``Mode``; for a slice ``Modes``, whose evidence stays here."""
        return Modes(self.modes[index], self.names) if isinstance(index, slice) else self.modes[index]

    def _summary(self) -> str:
        return f"{super()._summary()}, {'none missed' if self.none_missed else 'not counted'}"

    def _tables(self) -> tuple[TextTable, ...]:
        return *super()._tables(), notice_table(self.notices)

    @property
    def shapes(self) -> np.ndarray:
        """The shapes of the oscillating modes, one a column."""
        return self.vectors[:, self.eigenvalues.imag != 0]

    def table(self) -> list[dict[str, str]]:
        """A row of texts per mode, as ``Modes.table``, with the residual."""
        return [{**row, "residual": f"{residual:.2g}"} for row, residual in zip(super().table(), self.residuals)]


def sparse_modes(pencil: ReducedPencil, count: int, damped: bool) -> SparseModes:
    """The modes of lowest frequency of a system of sparse matrices."""
    undamped = undamped_modes(pencil, count)
    if damped:
        return _damped(pencil, undamped, damped_modes(pencil, undamped), count)
    X, w2 = undamped.vectors, undamped.values
    values = np.where(w2 < 0, np.abs(w2) ** 0.5, 1j * np.abs(w2) ** 0.5)
    kinds = ["rigid body" if not value else "growth" if value < 0 else "oscillation" for value in w2]
    orthogonality = float(np.abs(X.T @ times(pencil.mass, X) - np.eye(X.shape[1])).max(initial=0.0))
    evidence = undamped.residuals, undamped.bounds
    notices = (
        *_count_notices(undamped, count),
        *_residual_notices(evidence[0] > evidence[1]),
        *_rounding_notices(pencil, undamped),
    )
    return _modes(pencil, undamped, values, X, kinds, evidence, orthogonality, notices)


def _damped(pencil: ReducedPencil, undamped: UndampedModes, modes: DampedModes, count: int) -> SparseModes:
    chosen = np.flatnonzero(modes.converged)[:count]
    values, X = modes.values[chosen], modes.vectors[:, chosen]
    inertia, damping = X.T @ times(pencil.mass, X), X.T @ times(pencil.damping, X)
    own = 2 * values * np.diag(inertia) + np.diag(damping)
    target = np.where(values.imag != 0, 2j * values.imag, np.where(np.abs(own) > 0, own, 1.0))
    unit = (target / np.where(own != 0, own, target)) ** 0.5
    X *= unit
    coupling = _coupling(values, (values[:, None] + values) * inertia + damping, unit)
    kinds = [_kind(value, resting) for value, resting in zip(values, modes.resting[chosen])]
    notices = [*_count_notices(undamped, count), *_rounding_notices(pencil, undamped)]
    if lost := int((~modes.converged).sum()):
        text = f"{counted(lost, 'eigenvalue')} of strongly damped motion did not converge from the undamped modes and are left out"
        notices.append(Notice(NoticeKind.OMITTED, text, doubtful=True))
    return _modes(pencil, undamped, values, X, kinds, (modes.residuals[chosen], modes.bounds[chosen]), coupling, notices)


def _modes(pencil, undamped: UndampedModes, values, X, kinds: list[Kind], evidence, orthogonality, notices) -> SparseModes:
    """The modes on all coordinates from their vectors X on the free ones."""
    vectors = times(pencil.basis, X)
    modes = (Mode(kind, complex(value), 1, vectors[:, [i]]) for i, (kind, value) in enumerate(zip(kinds, values)))
    return SparseModes(
        tuple(modes),
        pencil.names,
        vectors,
        *evidence,
        orthogonality,
        counted_below=None if undamped.counted is None else max(undamped.below, 0.0) ** 0.5,
        none_missed=undamped.counted is not None and undamped.counted == undamped.computed_below,
        complete=undamped.complete,
        notices=(*pencil.notices, *notices),
    )


def _coupling(values, form, unit) -> float:
    """The largest entry off the diagonal of (s_i + s_j) x_i^T M x_j + x_i^T C x_j, relative to |s_i + s_j|."""
    sizes = np.abs(values[:, None] + values)
    relative = np.abs(form * unit * unit[:, None]) / np.where(sizes > 0, sizes, 1.0)
    np.fill_diagonal(relative, 0.0)
    return float(relative.max(initial=0.0))


def _kind(value: complex, resting: bool) -> Kind:
    if not value:
        return "rigid body" if resting else "offset"
    if value.real > NOISE_SAFETY * EPS * abs(value):
        return "growth"
    return "oscillation" if value.imag else "decay"


def _count_notices(undamped: UndampedModes, count: int) -> Iterator[Notice]:
    size = len(undamped.values)
    if undamped.complete and size < count:
        yield Notice(
            NoticeKind.OMITTED, f"the system has {counted(size, 'finite undamped mode')}, fewer than the {count} requested"
        )
    if undamped.counted is None:
        yield Notice(NoticeKind.ACCURACY, "whether modes of low frequency are missing could not be counted", doubtful=True)
    elif undamped.counted != undamped.computed_below:
        limit = max(undamped.below, 0.0) ** 0.5
        text = f"{undamped.counted} modes lie below {limit:.6g} rad/s, of which {undamped.computed_below} were computed"
        yield Notice(NoticeKind.ACCURACY, text, doubtful=True)
    elif undamped.computed_below < size:
        text = (
            f"the last {counted(size - undamped.computed_below, 'mode')} belong to a larger group of equal frequencies; "
            "increase count to have all of it"
        )
        yield Notice(NoticeKind.OMITTED, text)
    if growing := int((undamped.values < 0).sum()):
        yield Notice(NoticeKind.UNSTABLE, f"{counted(growing, 'growing mode')}: the stiffness is negative there")


def _residual_notices(beyond) -> Iterator[Notice]:
    if beyond.any():
        listed = ", ".join(str(place + 1) for place in np.flatnonzero(beyond)[:5])
        text = f"{counted(int(beyond.sum()), 'mode')} (number {listed}) did not converge to the accuracy of the others"
        yield Notice(NoticeKind.ACCURACY, text, doubtful=True)


def _rounding_notices(pencil: ReducedPencil, undamped: UndampedModes) -> Iterator[Notice]:
    """Frequencies that rounding errors of the entries of K may change noticeably."""
    stiffness, X = abs(pencil.stiffness), np.abs(undamped.vectors)
    terms = EPS * (X * times(stiffness, X)).sum(axis=0)
    uncertain = (undamped.values != 0) & (terms > TRUST_LIMIT * np.abs(undamped.values))
    if uncertain.any():
        affected = counted(int(uncertain.sum()), "frequency", "frequencies")
        text = (
            f"{affected} may be rounding error of the stiffness matrix, in whose entries stiff and soft parts are added; "
            "replace stiff links by constraints"
        )
        yield Notice(NoticeKind.ACCURACY, text, doubtful=True)
