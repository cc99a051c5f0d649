"""From modes on the free coordinates to those of the system, with the notices that they bring."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...checks import counted as in_words
from ...notices import Notice
from ...tolerances import EPS, NOISE_SAFETY, TRUST_LIMIT
from .damped import DampedModes, damped_modes
from .matrices import times
from .modes import SparseModes
from .undamped import UndampedModes

if TYPE_CHECKING:
    from .system import SparseSystem


def found_modes(system: SparseSystem, undamped: UndampedModes, count: int, damped: bool) -> SparseModes:
    """The modes of a system with what is known of them."""
    if damped:
        return _damped(system, undamped, damped_modes(system.pencil, undamped), count)
    pencil, X, w2 = system.pencil, undamped.vectors, undamped.values
    values = np.where(w2 < 0, np.abs(w2) ** 0.5, 1j * np.abs(w2) ** 0.5)
    kinds = tuple("rigid body" if not value else "growth" if value < 0 else "oscillation" for value in w2)
    orthogonality = float(np.abs(X.T @ times(pencil.mass, X) - np.eye(X.shape[1])).max(initial=0.0))
    evidence = undamped.residuals, undamped.bounds
    beyond = _residual_notices(evidence[0] > evidence[1])
    notices = (*_count_notices(undamped, count), *beyond, *_rounding_notices(pencil, undamped))
    return _modes(system, values, times(pencil.basis, X), kinds, evidence, undamped, orthogonality, notices)


def _modes(system, values, shapes, kinds, evidence, undamped: UndampedModes, orthogonality, notices) -> SparseModes:
    below = None if undamped.counted is None else max(undamped.below, 0.0) ** 0.5
    return SparseModes(
        values,
        shapes,
        kinds,
        *evidence,
        system.names,
        orthogonality,
        below,
        undamped.counted is not None and undamped.counted == undamped.found_below,
        undamped.complete,
        (*system.notices, *notices),
    )


def _damped(system: SparseSystem, undamped: UndampedModes, found: DampedModes, count: int) -> SparseModes:
    pencil, take = system.pencil, np.flatnonzero(found.converged)[:count]
    values, X = found.values[take], found.vectors[:, take]
    inertia, damping = X.T @ times(pencil.mass, X), X.T @ times(pencil.damping, X)
    own = 2 * values * np.diag(inertia) + np.diag(damping)
    wanted = np.where(values.imag != 0, 2j * values.imag, np.where(np.abs(own) > 0, own, 1.0))
    unit = (wanted / np.where(own != 0, own, wanted)) ** 0.5
    X *= unit
    coupling = _coupling(values, (values[:, None] + values) * inertia + damping, unit)
    kinds = tuple(_kind(value, resting) for value, resting in zip(values, found.resting[take]))
    notices = [*_count_notices(undamped, count), *_rounding_notices(pencil, undamped)]
    if lost := int((~found.converged).sum()):
        text = f"{in_words(lost, 'zero')} of strongly damped motion did not converge from the undamped modes and are left out"
        notices.append(Notice("left out", text, doubtful=True))
    evidence = found.residuals[take], found.bounds[take]
    return _modes(system, values, times(pencil.basis, X), kinds, evidence, undamped, coupling, notices)


def _coupling(values, form, unit) -> float:
    """The largest entry off the diagonal of (s_i + s_j) x_i^T M x_j + x_i^T C x_j, relative to |s_i + s_j|."""
    sizes = np.abs(values[:, None] + values)
    relative = np.abs(form * unit * unit[:, None]) / np.where(sizes > 0, sizes, 1.0)
    np.fill_diagonal(relative, 0.0)
    return float(relative.max(initial=0.0))


def _kind(value: complex, resting: bool):
    if not value:
        return "rigid body" if resting else "offset"
    if value.real > NOISE_SAFETY * EPS * abs(value):
        return "growth"
    return "oscillation" if value.imag else "decay"


def _count_notices(undamped: UndampedModes, count: int):
    found = len(undamped.values)
    if undamped.complete and found < count:
        yield Notice("left out", f"the system has {in_words(found, 'finite undamped mode')}, fewer than the {count} asked for")
    if undamped.counted is None:
        yield Notice("accuracy", "whether modes of low frequency are missing could not be counted", doubtful=True)
    elif undamped.counted != undamped.found_below:
        limit = max(undamped.below, 0.0) ** 0.5
        text = f"{undamped.counted} modes lie below {limit:.6g} rad/s, of which {undamped.found_below} were found"
        yield Notice("accuracy", text, doubtful=True)
    elif undamped.found_below < found:
        text = (
            f"the last {in_words(found - undamped.found_below, 'mode')} belong to a group of equal frequencies that goes on; "
            "ask for more modes to have all of it"
        )
        yield Notice("left out", text)
    if growing := int((undamped.values < 0).sum()):
        yield Notice("unstable", f"{in_words(growing, 'growing mode')}: the stiffness is negative there")


def _residual_notices(beyond):
    if beyond.any():
        listed = ", ".join(str(place + 1) for place in np.flatnonzero(beyond)[:5])
        text = f"{in_words(int(beyond.sum()), 'mode')} (number {listed}) did not converge to the accuracy of the others"
        yield Notice("accuracy", text, doubtful=True)


def _rounding_notices(pencil, undamped: UndampedModes):
    """Where a rounding of each entry of K may change w^2 by a part that counts."""
    stiffness, X = abs(pencil.stiffness), np.abs(undamped.vectors)
    terms = EPS * (X * times(stiffness, X)).sum(axis=0)
    unsure = (undamped.values != 0) & (terms > TRUST_LIMIT * np.abs(undamped.values))
    if unsure.any():
        found = in_words(int(unsure.sum()), "frequency", "frequencies")
        text = (
            f"beside the stiffest parts {found} may be rounding of the entries of the stiffness matrix, where stiff and soft are "
            "added; hold stiff links by constraints instead"
        )
        yield Notice("accuracy", text, doubtful=True)
