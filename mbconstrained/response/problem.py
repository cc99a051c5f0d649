"""The initial value problem A(d/dt) x = f with validated data, and the problem with data perturbed by a rounding error."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..ground.checks import OF_FUNCTION, counted, real_array
from ..ground.errors import InputError
from ..ground.tolerances import EPS, PROBE_SIZE
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction
from ..signals.impulsive import ImpulsiveLoad, ImpulsiveSmooth
from ..signals.inputs import zero

#: The functions that make a force.
FORCE_FUNCTIONS = "mb.step, mb.ramp, mb.harmonic, mb.term, mb.impulse, mb.pulse, mb.sampled or mb.approximated"

#: By how many units in the last place entries are moved: not all by the same, or their ratios would stay as they are.
MOVES = (-2.0, -1.0, 1.0, 2.0)


@dataclass(frozen=True, eq=False)
class Problem:
    """A(d/dt) x = f on t >= 0 with values at 0-.

    Attributes:
        polynomial_matrix: A(s), degree q, size r.
        initial: x^(i)(0-) as row i, shape (q, r).
        force: f, r rows.
        rank_tolerance: as given to ``solve``; None for rounding errors of float64.
    """

    polynomial_matrix: PolynomialMatrix
    initial: np.ndarray
    force: ImpulsiveSmooth
    rank_tolerance: float | None = None

    @classmethod
    def checked(cls, A: PolynomialMatrix, initial=None, force=None, rank_tolerance: float | None = None) -> Problem:
        """The problem of a user's data, None standing for zeros.

        Args:
            A: the polynomial matrix, degree q, size r.
            initial: shape (q, r).
            force: f with r rows.
            rank_tolerance: as in ``solve``.

        Returns:
            A ``Problem``.

        Raises:
            InputError: shapes that do not fit, values that are not finite.
        """
        shape = checked_matrix(A).degree, A.size
        initial = np.zeros(shape) if initial is None else real_array(initial, "initial", shape=shape)
        return cls(A, initial, checked_force(force, A.size), rank_tolerance)

    def moved(self, seed: int) -> Problem:
        """The problem with all data perturbed, entry by entry, by about a rounding error."""
        random = np.random.default_rng(seed)
        A = self.polynomial_matrix.moved(random, lambda entries, uncertainty: _moved(entries, random, uncertainty))
        return Problem(A, _moved(self.initial, random), _moved_force(self.force, random), self.rank_tolerance)


def checked_matrix(A) -> PolynomialMatrix:
    """A(s), or an InputError."""
    if not isinstance(A, PolynomialMatrix):
        raise InputError(f"A: found {type(A).__name__}; expected a PolynomialMatrix, e.g. mb.PolynomialMatrix([A0, A1, A2])")
    return A


def checked_force(force, size: int) -> ImpulsiveSmooth:
    """A force with so many rows, zero for None, or an InputError."""
    if force is None:
        return zero(size)
    if not isinstance(force, ImpulsiveSmooth):
        advice = OF_FUNCTION if callable(force) else f"; make it with {FORCE_FUNCTIONS}"
        raise InputError(f"force: found {type(force).__name__}{advice}")
    if force.size != size:
        raise InputError(f"force: it has {counted(force.size, 'row')}, but A(s) has {size}")
    return force


def _moved_force(force: ImpulsiveSmooth, random) -> ImpulsiveSmooth:
    smooth = BohlFunction(_moved(force.smooth.coefficients, random), force.smooth.blocks, force.smooth.start)
    later = tuple(ImpulsiveLoad(load.time, _all_moved(load.impulses, random)) for load in force.later)
    return replace(force, smooth=smooth, impulses=_all_moved(force.impulses, random), later=later)


def _all_moved(arrays, random) -> tuple[np.ndarray, ...]:
    return tuple(_moved(array, random) for array in arrays)


def _moved(array, random, uncertainty=0.0) -> np.ndarray:
    """Each entry perturbed by a unit in the last place, or by its uncertainty where that is larger; zeros are kept."""
    size = np.abs(array)
    share = np.maximum(EPS, uncertainty / np.where(size > 0, size, np.inf))
    return array * (1 + PROBE_SIZE * share * random.choice(MOVES, size=np.shape(array)))
