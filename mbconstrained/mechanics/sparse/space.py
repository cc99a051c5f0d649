"""The space of the modes that are kept: x = W y, y' = B y + G^T f, exactly what the whole system does in it.

Undamped and modally damped shapes have y = (q, q') with q'' + z q' + w^2 q = x^T f. Where damping couples them, each complex
pair has y = (Re c, Im c) with c' = s c + g^T f, g = x / (x^T (2 s M + C) x), as the matrices are symmetric (Lancaster 1966).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...errors import InputError
from ...tolerances import EPS, NOISE_SAFETY
from .damped import damped_modes, is_modal
from .matrices import asymmetry, times
from .pencil import ReducedPencil
from .undamped import UndampedModes


@dataclass(frozen=True)
class ModeSpace:
    """W and B with M W B^2 + C W B + K W = 0, and what starts and drives y.

    Attributes:
        shapes: the columns of W that are not zero, shape (r, w).
        places: which of the states each of them belongs to, shape (w,).
        blocks: the diagonal blocks of B, 1 x 1 and 2 x 2.
        drivers: the columns of G that are not zero, shape (r, d), and
        driven: the states that they drive.
        modal: whether y are displacements and velocities of undamped shapes, M-orthonormal.
        left_out: how many modes that were found could not be kept.
    """

    shapes: np.ndarray
    places: np.ndarray
    blocks: tuple[np.ndarray, ...]
    drivers: np.ndarray
    driven: np.ndarray
    modal: bool
    left_out: int = 0

    @property
    def count(self) -> int:
        """Number of states."""
        return sum(map(len, self.blocks))

    def shown(self, states: np.ndarray) -> np.ndarray:
        """W y for columns of states."""
        return self.shapes @ states[self.places]

    def drive(self, forces: np.ndarray) -> np.ndarray:
        """G^T f for columns of forces."""
        found = np.zeros((self.count, forces.shape[1]))
        np.add.at(found, self.driven, self.drivers.T @ forces)
        return found

    def turned(self, states: np.ndarray) -> np.ndarray:
        """B y."""
        found, begin = np.empty_like(states), 0
        for block in self.blocks:
            at = slice(begin, begin + len(block))
            found[at] = block @ states[at]
            begin += len(block)
        return found

    def started(self, pencil: ReducedPencil, displacement, velocity) -> np.ndarray:
        """y at 0+ from x and x' at 0-: y = G^T (M x' + C x) + B G^T M x, as impulses M x' + C x and M x delta' would start it."""
        momentum = (pencil.mass @ velocity + pencil.damping @ displacement)[:, None]
        return (self.drive(momentum) + self.turned(self.drive((pencil.mass @ displacement)[:, None])))[:, 0]


def mode_space(pencil: ReducedPencil, undamped: UndampedModes) -> ModeSpace:
    """The space of undamped modes, or of the damped ones that they lead to.

    Raises:
        InputError: the damping is not symmetric.
    """
    if asymmetry(pencil.damping)[0]:
        raise InputError(
            "damping: it is not symmetric; the motion of large sparse systems needs symmetric damping; its modes can be had, and "
            "the motion of a small system given as arrays"
        )
    if is_modal(pencil, undamped):
        return _modal(pencil, undamped)
    return _of_pairs(pencil, undamped)


def _modal(pencil: ReducedPencil, undamped: UndampedModes) -> ModeSpace:
    X, count = undamped.vectors, len(undamped.values)
    rates = (X * times(pencil.damping, X)).sum(axis=0)
    sizes = (np.abs(X) * times(abs(pencil.damping), np.abs(X))).sum(axis=0)
    rates = np.where(np.abs(rates) > NOISE_SAFETY * EPS * sizes, rates, 0.0)
    blocks = tuple(np.array([[0.0, 1.0], [-w2, -rate]]) for w2, rate in zip(undamped.values, rates))
    places = 2 * np.arange(count)
    return ModeSpace(X, places, blocks, X, places + 1, True)


def _of_pairs(pencil: ReducedPencil, undamped: UndampedModes) -> ModeSpace:
    found = damped_modes(pencil, undamped)
    shapes, places, blocks, drivers, driven, begin = [], [], [], [], [], 0
    for value, x, resting, converged in zip(found.values, found.vectors.T, found.resting, found.converged):
        if not converged:
            continue
        if resting:
            x = x.real / (x.real @ (pencil.mass @ x.real)) ** 0.5
            columns, rows, own, at = [x], [x], np.array([[0.0, 1.0], [0.0, 0.0]]), ([0], [1])
        elif not value.imag:
            x = x.real
            g = x / (x @ (pencil.damping @ x + 2 * value.real * (pencil.mass @ x)))
            columns, rows, own, at = [x], [g], np.array([[value.real]]), ([0], [0])
        else:
            g = x / (x @ (pencil.damping @ x + 2 * value * (pencil.mass @ x)))
            own = np.array([[value.real, -value.imag], [value.imag, value.real]])
            columns, rows, at = [2 * x.real, -2 * x.imag], [g.real, g.imag], ([0, 1], [0, 1])
        shapes, drivers, blocks = shapes + columns, drivers + rows, [*blocks, own]
        places, driven = places + [begin + i for i in at[0]], driven + [begin + i for i in at[1]]
        begin += len(own)
    empty = np.zeros((0, pencil.size))
    return ModeSpace(
        np.array(shapes).T if shapes else empty.T,
        np.array(places, dtype=int),
        tuple(blocks),
        np.array(drivers).T if drivers else empty.T,
        np.array(driven, dtype=int),
        False,
        int((~found.converged).sum()),
    )
