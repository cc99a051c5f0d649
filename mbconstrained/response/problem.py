"""A problem of A(s), force and values at 0-, checked, and the force of its parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import log2

import numpy as np

from ..ground.checks import OF_FUNCTION, counted, real_array
from ..ground.errors import InputError, named
from ..ground.notices import Notice
from ..ground.tolerances import EPS, PROBE_SIZE
from ..linalg.blocks import block_matrix, block_slices
from ..linalg.exponential import block_states
from ..linalg.rank import Noisy
from ..polynomial.decoupling import WeierstrassForm
from ..polynomial.delayed_terms import DelayedTerm, delayed_terms
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.bohl import BohlFunction, Restarts
from ..signals.impulsive import ImpulsiveLoad, ImpulsiveSmooth
from ..signals.inputs import named_rows, step, zero

# The initial value problem A(d/dt) x = f with validated data, and the problem with data perturbed by a rounding error.

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
        delayed: the terms with dead time, ascending by it.
        past: x before t = 0 as a function of the time since the longest delay before it; None for zero.
        subdivisions: more knots within each delay than necessary.
        notices: notices of equations that were completed to a regular system (``response.solvability``).
    """

    polynomial_matrix: PolynomialMatrix
    initial: np.ndarray
    force: ImpulsiveSmooth
    rank_tolerance: float | None = None
    delayed: tuple[DelayedTerm, ...] = ()
    past: BohlFunction | None = None
    subdivisions: int = 0
    notices: tuple[Notice, ...] = ()

    @classmethod
    def checked(
        cls, A: PolynomialMatrix, initial=None, force=None, rank_tolerance: float | None = None, delayed=None, history=None
    ) -> Problem:
        """The problem of a user's data, None standing for zeros."""
        shape = checked_matrix(A).degree, A.size
        terms = delayed_terms(delayed, A.size) if delayed else ()
        past = None if history is None else checked_history(history, A.size, terms)
        if initial is None and past is not None:
            initial = [past.derivative(order).coefficients @ states_before(past, terms[-1].delay) for order in range(A.degree)]
        initial = np.zeros(shape) if initial is None else real_array(initial, "initial", shape=shape)
        return cls(A, initial, checked_force(force, A.size, A), rank_tolerance, terms, past)

    def moved(self, seed: int) -> Problem:
        """The problem with all data perturbed, entry by entry, by about a rounding error."""
        random = np.random.default_rng(seed)
        A = self.polynomial_matrix.moved(random, lambda entries, uncertainty: _moved(entries, random, uncertainty))
        terms = tuple(replace(term, coefficients=_moved(term.coefficients, random)) for term in self.delayed)
        initial, force = _moved(self.initial, random), _moved_force(self.force, random)
        return Problem(A, initial, force, self.rank_tolerance, terms, self.past, self.subdivisions + 1 + seed)


def checked_matrix(A) -> PolynomialMatrix:
    """A(s), or an InputError."""
    if not isinstance(A, PolynomialMatrix):
        method = next((f"; it is solved by its method {name}" for name in ("solve", "run") if hasattr(type(A), name)), "")
        expected = "expected a PolynomialMatrix, e.g. mb.PolynomialMatrix([A0, A1, A2])"
        raise InputError(f"A: found {type(A).__name__}; {expected}{method}")
    return A


def checked_force(force, size: int, A: PolynomialMatrix | None = None) -> ImpulsiveSmooth:
    """A force with so many rows, zero for None, or an InputError; by the names of the equations of A(s), or of as many coordinates."""
    if force is None:
        return zero(size)
    if isinstance(force, Mapping) and A is not None:
        places = {name: place for names in (A.coordinates, A.equations) if len(names) == size for place, name in enumerate(names)}
        return named_rows(force, places, size, "force", "equation or coordinate")
    if not isinstance(force, ImpulsiveSmooth):
        advice = OF_FUNCTION if callable(force) else f"; make it with {FORCE_FUNCTIONS}"
        raise InputError(f"force: found {type(force).__name__}{advice}")
    if force.size != size:
        raise InputError(f"force: it has {counted(force.size, 'row')}, but A(s) has {size}")
    return force


def checked_history(history, size: int, terms: Sequence[DelayedTerm]) -> BohlFunction:
    """x for -longest delay <= t < 0 as a function of the time since then, or an InputError."""
    if not terms:
        raise InputError("history: these equations have no delays, and the motion before t = 0 does not enter; leave it out")
    if not isinstance(history, ImpulsiveSmooth) and not callable(history):
        history = step(real_array(history, "history", shape=(size,)))
    if not isinstance(history, ImpulsiveSmooth):
        from ..signals.approximated import approximated

        function, longest = history, terms[-1].delay
        with named("history"):
            history = approximated(lambda t: function(np.asarray(t) - longest), longest)
    if history.size != size:
        raise InputError(f"history: it has {counted(history.size, 'row')}; expected {size}, one for each coordinate")
    if history.impulses or history.later:
        raise InputError("history: it contains Dirac impulses; expected a motion without them before t = 0")
    return history.smooth


def states_before(function: BohlFunction, time: float) -> np.ndarray:
    """The states of a function just before a time, shape (n,)."""
    restarts = function.restarts
    piece = int(np.searchsorted(restarts.knots, time)) - 1
    return block_states(function.blocks, restarts.states[:, piece : piece + 1], np.array([time - restarts.knots[piece]]))[:, 0]


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


# The force and the values at 0- in the units of the scaled pencil.


@dataclass(frozen=True, eq=False)
class ScaledForce:
    """f in the units of the scaled pencil: coefficients C_f, generator J_f, start v at 0+, and Dirac impulses at t = 0.

    Attributes:
        units: units of its states: its start is that of f divided by them.
        jump: the start without the states that approximate zero.
    """

    coefficients: np.ndarray
    generator: np.ndarray
    start: np.ndarray
    impulses: tuple[np.ndarray, ...]
    units: np.ndarray
    jump: np.ndarray

    def divided(self, size: float) -> ScaledForce:
        """f / size."""
        return replace(self, coefficients=self.coefficients / size, impulses=tuple(g / size for g in self.impulses))

    def derivatives(self, count: int) -> list[np.ndarray]:
        """C_f J_f^i for i = 0 .. count - 1: f^(i) = C_f J_f^i e^{J_f t} v."""
        derivatives = [self.coefficients]
        for _ in range(count - 1):
            derivatives.append(derivatives[-1] @ self.generator)
        return derivatives[:count]


def scaled_force(form: WeierstrassForm, force: ImpulsiveSmooth) -> ScaledForce:
    """f' = rows * f as a function of t' = time * t, its states measured so that chains have couplings near their rates."""
    scaling = form.companion.scaling
    smooth = force.smooth
    size = _units(smooth, scaling.time)
    return ScaledForce(
        scaling.rows[:, None] * smooth.coefficients * size,
        block_matrix(smooth.blocks) / scaling.time * size / size[:, None],
        smooth.start_at_zero / size,
        scaled_impulses(form, force.impulses),
        size,
        smooth.restarts.jumps[:, 0] / size,
    )


def scaled_impulses(form: WeierstrassForm, impulses) -> tuple[np.ndarray, ...]:
    """Factors of delta, delta', ... as functions of t' = time * t, in the units of the scaled pencil's equations."""
    scaling = form.companion.scaling
    return tuple(scaling.rows * g * scaling.time ** (k + 1.0) for k, g in enumerate(impulses))


def _units(smooth: BohlFunction, time: float) -> np.ndarray:
    """Units of the states of the force, powers of two."""
    units = [np.ones(0)]
    for block, at in zip(smooth.blocks, block_slices(smooth.blocks)):
        pieces = units_of_pieces(smooth, block, at)
        units.append(_chain_units(block / time) if pieces is None else pieces)
    return np.concatenate(units)


def units_of_pieces(smooth: BohlFunction, block: np.ndarray, at: slice) -> np.ndarray | None:
    """Units near the size of the states of one block of pieces, powers of two; None for other blocks.

    Polynomials of short pieces have large derivatives, and states of very different size could not be distinguished
    from those of a slow zero of A(s).
    """
    largest = np.abs(smooth.restarts.states[at]).max(axis=1)
    pieces = isinstance(smooth.start, Restarts) and _level(block) == 1 and (largest > 0).all() and np.isfinite(largest).all()
    return np.exp2(np.round(np.log2(largest))) if pieces else None


def _level(block) -> int:
    """Two for the chain of a complex pair, one for that of a real rate."""
    return 2 if len(block) > 1 and block[1, 0] != 0 else 1


def _chain_units(block) -> np.ndarray:
    """Powers of two for the states of t^k e^{a t} (cos, sin), k descending, that bring the couplings near the rates.

    Where the rates are zero, near 1: the pencil's own unit of time.
    """
    level = _level(block)
    units, rate = np.ones(len(block)), np.abs(block[:level, :level]).max() or 1.0
    for at in range(level, len(block), level):
        coupling = np.abs(block[at - level : at, at : at + level]).max() / rate
        units[at:] = units[at - 1] / 2.0 ** np.round(np.log2(coupling)) if coupling > 0 else units[at - 1]
    return units


def scaled_data(form: WeierstrassForm, initial: np.ndarray, force: ImpulsiveSmooth) -> tuple[np.ndarray, ScaledForce, float]:
    """The stacked values at 0- and the force, both divided by a power of two near their size, and that power.

    All effects at t = 0 are linear in them; divided so, the squares of noise stay in range.
    """
    stack, f = form.companion.scaled_stack(initial), scaled_force(form, force)
    size = power_of_two_of(np.concatenate([stack, f.coefficients.ravel(), *f.impulses]))
    return stack / size, f.divided(size), size


def power_of_two_of(matrix) -> float:
    """A power of two near the largest entry, 1 where all are zero."""
    size = np.abs(matrix).max(initial=0.0)
    return 2.0 ** round(log2(size)) if size > 0 else 1.0


# The finite part driven by the force, in scaled units.


@dataclass(frozen=True, eq=False)
class Driven:
    """y' = T y + D w, w' = J_f w, x = C y + G w with the states w of the force.

    Attributes:
        excitation: D, shape (n, m).
        generator: J_f, shape (m, m).
        through: G, shape (r, m), the share of x by the infinite part.
        units: the states w are those of f divided by these, shape (m,).
    """

    excitation: np.ndarray
    generator: np.ndarray
    through: np.ndarray
    units: np.ndarray


def driven_form(form: WeierstrassForm, force: ImpulsiveSmooth) -> Driven:
    """The form with each term of the force in its own units: a small one must not be lost in the rounding error of a large one."""
    f = scaled_force(form, force)
    if not len(f.start):
        return Driven(np.zeros((len(form.T), 0)), f.generator, f.coefficients, f.units)
    size = power_of_two_of(f.coefficients)  # divided by and multiplied again: squares of noise stay in range
    excitation = size * (form.noisy_B.settled() @ Noisy.rounded(f.divided(size).coefficients)).cleaned()
    through = np.zeros_like(f.coefficients)
    for index, derivative in enumerate(f.derivatives(form.highest_impulse + 1)):
        through = through + form.laurent(index).cleaned() @ derivative
    amplitude = _amplitudes(np.vstack([excitation, through]), force.smooth.blocks)
    return Driven(excitation / amplitude, f.generator, through / amplitude, f.units / amplitude)


def _amplitudes(columns, blocks) -> np.ndarray:
    """Powers of two, one for all states of a block, that bring the largest entry of its columns near 1."""
    parts = [np.full(len(block), power_of_two_of(columns[:, at])) for block, at in zip(blocks, block_slices(blocks))]
    return np.concatenate([np.ones(0), *parts])
