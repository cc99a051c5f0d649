"""The modes of a family of systems: eigenvalues and shapes from the stacked poles, of some systems one by one."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...ground.checks import counted
from ...ground.display import Displayed, TextTable, notice_table
from ...ground.notices import Notice, NoticeKind, doubts_of
from ...ground.tolerances import EPS, PROVED_ACCURACY
from ..mode_computation import rest_shapes
from ..modes import Modes
from .stacked_poles import StackedPoles, stacked_poles
from .system_stack import SystemStack


@dataclass(frozen=True, repr=False, eq=False)
class FamilyModes(Displayed):
    """The modes of S systems; ``modes[3]`` are the ``Modes`` of one, with kinds, energies and tables.

    Attributes:
        family: the systems.
        eigenvalues: in 1/s as ``Modes.eigenvalues``, ascending by modulus, shape (S, P); NaN where a system has fewer.
        shapes: the largest entry of each 1, shape (S, n, P).
        error_estimate: error estimate of the eigenvalues, relative, shape (S, P).
        alone: places of the systems that were solved one by one.
    """

    family: SystemStack
    eigenvalues: np.ndarray
    shapes: np.ndarray
    error_estimate: np.ndarray
    alone: np.ndarray

    def _summary(self) -> str:
        return f"modes of {counted(len(self.family), 'system')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def __len__(self) -> int:
        return len(self.family)

    def __getitem__(self, index: int) -> Modes:
        return self.family[index].modes()

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on systems that were solved one by one and on inaccurate eigenvalues."""
        worst = np.nanmax(self.error_estimate, initial=0.0)
        return (*one_by_one(self.alone, len(self.family)), *doubts_of("the eigenvalues of a system", worst))

    @property
    def natural_frequencies(self) -> np.ndarray:
        """|s| of the oscillating modes in rad/s, ascending, shape (S, m); NaN where a system has fewer."""
        return self._oscillating(np.abs(self.eigenvalues))

    @property
    def frequencies_hz(self) -> np.ndarray:
        """``natural_frequencies`` / (2 pi), in Hz."""
        return self.natural_frequencies / (2 * np.pi)

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s / |s| of the oscillating modes, shape (S, m)."""
        moduli = np.abs(self.eigenvalues)
        return self._oscillating(-self.eigenvalues.real / np.where(moduli > 0, moduli, 1.0))

    def _oscillating(self, values: np.ndarray) -> np.ndarray:
        oscillates = np.nan_to_num(self.eigenvalues.imag) != 0
        order = np.argsort(~oscillates, axis=1, kind="stable")
        chosen = np.take_along_axis(np.where(oscillates, values, np.nan), order, axis=1)
        return chosen[:, : int(oscillates.sum(axis=1).max(initial=0))]


def family_modes(family: SystemStack) -> FamilyModes:
    """The modes of all systems."""
    count, stacks = len(family), [one for one in (_regular_stack(family),) if one]
    waiting = ~np.any([np.zeros(count, dtype=bool), *(one.serve for one in stacks)], axis=0)
    if waiting.sum() > 1 and (freed := _free_stack(family, waiting)):
        stacks.append(freed)
        waiting &= ~freed.serve
    alone = {place: family[place].modes() for place in np.flatnonzero(waiting).tolist()}
    drift = sum(row.order for row in family.base.rows)
    width = max([0, *(len(modes.eigenvalues) for modes in alone.values())])
    width = max([width, *(one.count + drift for one in stacks if one.serve.any())])
    values = np.full((count, width), np.nan, dtype=complex)
    errors, shapes = np.full((count, width), np.nan), np.full((count, family.base.size, width), np.nan, dtype=complex)
    for one in stacks:
        if one.serve.any():
            _sort_into(values, errors, shapes, one, drift)
    for place, modes in alone.items():
        own = modes.eigenvalues
        values[place, : len(own)], errors[place, : len(own)] = (
            own,
            np.repeat(np.maximum(modes.residuals, EPS), [mode.multiplicity for mode in modes]),
        )
        repeated = [
            mode.shapes[:, [min(i, mode.shapes.shape[1] - 1)]] if mode.shapes.size else np.full((family.base.size, 1), np.nan)
            for mode in modes
            for i in range(mode.multiplicity)
        ]
        if repeated:
            shapes[place, :, : len(own)] = np.hstack(repeated)
    return FamilyModes(family, values, shapes, errors, np.array(sorted(alone), dtype=int))


@dataclass(frozen=True, eq=False)
class _Stack:
    """Poles of systems that the stacked method serves, and the shapes of their eigenvalues 0, one for each."""

    poles: StackedPoles
    serve: np.ndarray
    zeros: np.ndarray

    @property
    def count(self) -> int:
        """The largest number of their eigenvalues."""
        return int((self.poles.weights[self.serve] > 0).sum(axis=1).max()) + len(self.zeros)


def _regular_stack(family: SystemStack) -> _Stack | None:
    """The systems without eigenvalues 0 but those of drift."""
    poles = family.poles
    if poles is None:
        return None
    return _Stack(poles, poles.serve & (poles.value_errors <= PROVED_ACCURACY).all(axis=1), np.zeros((0, family.base.size)))


def _free_stack(family: SystemStack, waiting: np.ndarray) -> _Stack | None:
    """Systems with the free motions of the first of those that wait: free bodies, or one motion that dampers alone resist.

    Whether a motion is free is a decision on rank, which is made for that system; for the others it is seen whether springs
    and dampers act against it. A pole of theirs that is not clearly none of the zeros leaves a system out.
    """
    if family.poles is None:
        return None
    reference = family[int(waiting.argmax())]
    free, staying = rest_shapes(reference.position_form().polynomial_matrix)
    if np.iscomplexobj(free) or np.iscomplexobj(staying):
        return None
    if free.shape[1] and not staying.shape[1]:
        waiting = waiting & family.is_free(free, "stiffness") & family.is_free(free, "damping")
        equations = family.equations.without_rigid_motions(free)
        if not (waiting & equations.serve).any():
            return None
        poles = stacked_poles(equations, *family.matrices(slice(None)))
        serve = waiting & poles.serve & (poles.value_errors <= PROVED_ACCURACY).all(axis=1)
        bodies = free.shape[1]
        return _Stack(poles, serve, np.array([free[:, min(i, bodies - 1)] for i in range(2 * bodies)]))
    if staying.shape[1] != 1 or free.shape[1]:
        return None
    resting = family.equations.with_resting_motion(staying)
    if resting is None:
        return None
    equations, doubt = resting
    units = np.broadcast_to(np.eye(equations.K.shape[1]), equations.K.shape)
    poles = stacked_poles(replace(equations, T=units), equations.M, equations.C, equations.K)
    zero = ((poles.values == 0) | (poles.value_errors >= 1.0)) & (poles.weights == 1)  # not farther from 0 than their errors
    errors = poles.value_errors + doubt[:, None]
    clear = (errors <= PROVED_ACCURACY) | zero
    serve = waiting & family.is_free(staying, "stiffness") & poles.serve & clear.all(axis=1) & (zero.sum(axis=1) == 1)
    weights, shapes = np.where(zero, 0.0, poles.weights), equations.T @ poles.shapes
    poles = replace(poles, value_errors=errors, weights=weights, shapes=shapes)
    return _Stack(poles, serve, staying.T)


def _sort_into(values, errors, shapes, stack: _Stack, drift: int) -> None:
    """The poles of the systems that serve, ascending by modulus after eigenvalues 0, their shapes with largest entry 1."""
    poles, serve = stack.poles, stack.serve
    own = np.where(poles.weights > 0, poles.values, np.inf)
    order = np.argsort(np.abs(own), axis=1, kind="stable")
    ordered = np.take_along_axis(own, order, axis=1)
    absent = ~np.isfinite(ordered.real)
    ordered[absent] = np.nan
    sizes = np.take_along_axis(poles.value_errors, order, axis=1)
    sizes[absent] = np.nan
    X = np.take_along_axis(poles.shapes, order[:, None, :], axis=2)
    largest = np.take_along_axis(X, np.abs(X).argmax(axis=1)[:, None, :], axis=1)
    with np.errstate(all="ignore"):
        X = np.where(absent[:, None, :], np.nan, X / largest)
    begin = drift + len(stack.zeros)
    columns, present = slice(begin, drift + stack.count), stack.count - len(stack.zeros)
    values[serve, :begin], errors[serve, :drift], errors[serve, drift:begin] = 0.0, 0.0, EPS
    values[serve, columns], errors[serve, columns] = ordered[serve, :present], sizes[serve, :present]
    shapes[serve, :, drift:begin] = stack.zeros.T
    shapes[serve, :, columns] = X[serve][:, :, :present]


def one_by_one(places: np.ndarray, count: int, limit: float = PROVED_ACCURACY) -> tuple[Notice, ...]:
    """A notice of systems that stacks of matrices do not serve."""
    if not len(places):
        return ()
    text = f"{counted(len(places), 'system')} of {count} solved one by one: another structure than the first, or an estimate above {limit:g}"
    return (Notice(NoticeKind.ACCURACY, text),)
