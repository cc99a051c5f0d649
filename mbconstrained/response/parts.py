"""What happens at t = 0, and the regular part after it, from the decoupled pencil in its scaled units.

The finite state starts at y_1(0+) = P_1 E z0, the infinite one is -sum N^i B2 f^(i). The vector
g = P_2 F z0 + sum N^i B2 f^(i)(0+) is the inconsistency of the values at 0- : the states jump by -Q_2 g, and
-C2 N^(p+1) g multiplies delta^(p) (the impulses of Moysis et al., Eq. 42 with (45) taken at 0+; g = 0 is
condition (60), corrected). Its rounding noise is bounded along with it, so that a consistent start has g = 0.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ..errors import Overflow
from ..jordan.weierstrass import WeierstrassForm
from ..linalg.blocks import block_diagonalize
from ..linalg.noise import Noisy, columnwise
from ..signals.bohl import BohlFunction
from ..signals.inputs import ImpulsiveSmooth


@dataclass(frozen=True)
class Start:
    """State and jump at t = 0.

    Attributes:
        finite: y_1(0+) in scaled units, shape (n,).
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r), in the user's units.
        impulses: arrays (r,), the k-th multiplies delta^(k), in the user's units.
    """

    finite: np.ndarray
    jump: np.ndarray
    impulses: tuple[np.ndarray, ...]


@dataclass(frozen=True)
class ScaledForce:
    """f in the units of the scaled pencil: coefficients C_f, generator J_f, start v, and Dirac impulses."""

    coefficients: np.ndarray
    generator: np.ndarray
    start: np.ndarray
    impulses: tuple[np.ndarray, ...]

    def divided(self, size: float) -> ScaledForce:
        """f / size."""
        return replace(self, coefficients=self.coefficients / size, impulses=tuple(g / size for g in self.impulses))

    def derivatives(self, count: int) -> list[np.ndarray]:
        """C_f J_f^i for i = 0 .. count - 1: f^(i) = C_f J_f^i e^{J_f t} v."""
        found = [self.coefficients]
        for _ in range(count - 1):
            found.append(found[-1] @ self.generator)
        return found[:count]


def scaled_force(form: WeierstrassForm, force: ImpulsiveSmooth) -> ScaledForce:
    """f' = rows * f as a function of t' = time * t, its states measured so that chains have couplings near their rates."""
    scaling = form.companion.scaling
    smooth = force.smooth
    size = np.concatenate([np.ones(0), *(_chain_units(block / scaling.time) for block in smooth.blocks)])
    return ScaledForce(
        scaling.rows[:, None] * smooth.coefficients * size,
        smooth.generator / scaling.time * size / size[:, None],
        smooth.start / size,
        tuple(scaling.rows * g * scaling.time ** (k + 1.0) for k, g in enumerate(force.impulses)),
    )


def _chain_units(block) -> np.ndarray:
    """Powers of two for the states of t^k e^{a t} (cos, sin), k descending, that bring the couplings near the rates.

    Where the rates are zero, near 1: the pencil's own unit of time.
    """
    level = 2 if len(block) > 1 and block[1, 0] != 0 else 1
    units, rate = np.ones(len(block)), np.abs(block[:level, :level]).max() or 1.0
    for at in range(level, len(block), level):
        coupling = np.abs(block[at - level : at, at : at + level]).max() / rate
        units[at:] = units[at - 1] / 2.0 ** np.round(np.log2(coupling)) if coupling > 0 else units[at - 1]
    return units


def scaled_data(form: WeierstrassForm, initial: np.ndarray, force: ImpulsiveSmooth) -> tuple[np.ndarray, ScaledForce, float]:
    """The stacked values at 0- and the force, both divided by a power of two near their size, and that power.

    All at t = 0 is linear in them; their size shall not take the squares of noise out of range.
    """
    stack, f = form.companion.scaled_stack(initial), scaled_force(form, force)
    size = _power_of_two_of(np.concatenate([stack, f.coefficients.ravel(), *f.impulses]))
    return stack / size, f.divided(size), size


def start_of(form: WeierstrassForm, initial: np.ndarray, force: ImpulsiveSmooth) -> Start:
    """The state at 0+, the jumps and the impulses at t = 0.

    Raises:
        Overflow: one of them leaves the range of float64.
    """
    stack, f, size = scaled_data(form, initial, force)
    finite = form.finite_rows @ (form.companion.E @ stack)
    for order, g in enumerate(f.impulses):
        finite = finite + np.linalg.matrix_power(form.T, order) @ (form.B @ g)
    inconsistency = inconsistency_of(form, stack, f)
    with np.errstate(over="ignore", invalid="ignore"):  # reported below
        jump = size * _jump(form, inconsistency, f, len(initial))
        start = Start(size * finite, jump, tuple(size * c for c in _impulses(form, inconsistency, f)))
    if not all(np.isfinite(values).all() for values in (start.finite, start.jump, *start.impulses)):
        raise Overflow("the jumps or impulses at t = 0 grow beyond the range of float64; choose other units or smaller values")
    return start


def regular_part(form: WeierstrassForm, start: Start, force: ImpulsiveSmooth) -> tuple[BohlFunction, float]:
    """x(t) for t > 0 as a Bohl function in the user's units, and the largest decoupling entry.

    The force's generator is appended to the finite part: [[T, B C_f], [0, J_f]]. Its zeros are clustered
    together with those of A(s), so that resonance needs no special case.
    """
    f = scaled_force(form, force)
    size = _power_of_two_of(f.coefficients)  # taken out and put back: squares of noise must not leave the range
    drive = size * (columnwise(form.B.T).T @ Noisy.rounded(f.divided(size).coefficients)).cleaned()
    n, m = len(form.T), len(f.start)
    through = np.zeros_like(f.coefficients)
    for index, derivative in enumerate(f.derivatives(form.highest_impulse + 1)):
        through = through + form.laurent(index).cleaned() @ derivative
    amplitude = _amplitudes(np.vstack([drive, through]), force.smooth.blocks)
    augmented = np.zeros((n + m, n + m))
    augmented[:n, :n], augmented[:n, n:], augmented[n:, n:] = form.T, drive / amplitude, f.generator
    output = np.hstack([form.C, through / amplitude])
    parts = block_diagonalize(augmented)
    scaling = form.companion.scaling
    function = BohlFunction(
        scaling.columns[:, None] * (output @ parts.basis),
        tuple(scaling.time * block for block in parts.blocks),
        parts.inverse @ np.concatenate([start.finite, amplitude * f.start]),
    )
    return function, parts.coupling


def _amplitudes(columns, blocks) -> np.ndarray:
    """Powers of two, one for all states of a block, that bring the largest entry of its columns near 1.

    Each term of the force is measured by itself: a small one must not be lost beside a large one.
    """
    ends = np.cumsum([0, *map(len, blocks)])
    parts = [np.full(end - begin, _power_of_two_of(columns[:, begin:end])) for begin, end in zip(ends, ends[1:])]
    return np.concatenate([np.ones(0), *parts])


def inconsistency_of(form, stack, f) -> Noisy:
    """g = P_2 F z0 + sum N^i B2 f^(i)(0+) in scaled units, entries below their rounding noise set to zero."""
    total = form.infinite_rows @ (Noisy.rounded(form.companion.F) @ Noisy.rounded(stack))
    power = form.B2
    for derivative in f.derivatives(len(form.split.deficiencies)):  # so many powers of N are not zero
        total = total + power @ (Noisy.rounded(derivative) @ Noisy.rounded(f.start))
        power = form.nilpotent @ power
    return Noisy(total.cleaned(), total.noise)


def _jump(form, inconsistency, f, q) -> np.ndarray:
    """x^(i)(0+) - x^(i)(0-): -Q_2 g, and H_(-i-l-1) g_l for each impulse delta^(l) of the force."""
    scaling, r = form.companion.scaling, form.companion.size
    by_state = -form.infinite_columns @ inconsistency
    rows = np.zeros((q, r))
    for i in range(q):
        total = by_state[i * r : (i + 1) * r]
        for order, g in enumerate(f.impulses):
            total = total + form.laurent(-i - order - 1) @ Noisy.rounded(g)
        rows[i] = scaling.columns * total.cleaned() * scaling.time ** float(i)
    return rows


def _impulses(form, inconsistency, f) -> tuple[np.ndarray, ...]:
    scaling, r = form.companion.scaling, form.companion.size
    highest = form.highest_impulse
    totals = [Noisy.exact(np.zeros(r)) for _ in range(highest + len(f.impulses))]
    state = inconsistency
    for order in range(highest):
        state = form.nilpotent @ state
        totals[order] = totals[order] + -form.C2 @ state
    for order, g in enumerate(f.impulses):
        for k in range(len(totals)):
            totals[k] = totals[k] + form.laurent(k - order) @ Noisy.rounded(g)
    impulses = [scaling.columns * total.cleaned() * scaling.time ** -(k + 1.0) for k, total in enumerate(totals)]
    while impulses and not impulses[-1].any():
        impulses.pop()
    return tuple(impulses)


def _power_of_two_of(matrix) -> float:
    size = np.abs(matrix).max(initial=0.0)
    return float(np.exp2(np.round(np.log2(size)))) if size > 0 else 1.0
