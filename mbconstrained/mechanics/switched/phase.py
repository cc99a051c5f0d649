"""One phase of a switched system: its equations with those of the force, the maps from values at 0- to its states, and impacts of contacts.

The force is w' = J_f w, f = C_f w, and [[A(s), -C_f], [0, s I - J_f]] has the motion under the force as its free motion: from its Jordan
pairs follow the states just after a switch, the jumps and the impulses, whatever the index of the phase (Moysis et al., Eqs. 42-45).

Impacts follow Newton's law of restitution for all rigid contacts that touch at one time: 0 <= u+ + e u- complementary to p >= 0 with
u+ = u- + W p, W the inverse effective masses of the contacts (Pfeiffer and Glocker, Multibody Dynamics with Unilateral Contacts, 1996,
chapter 8). Lemke's method solves it; for positive semidefinite W it ends in a solution where there is one (Cottle, Pang and Stone, The
Linear Complementarity Problem, 1992, section 4.4).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy

from ...ground.errors import MbconstrainedError, NotUnique
from ...ground.notices import Notice, distinct
from ...ground.tolerances import EPS
from ...linalg.blocks import block_diagonalize, block_matrix
from ...linalg.exponential import block_states
from ...polynomial.jordan_pairs import JordanPairs
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...response.events import starts_of
from ...response.response_notices import pair_notices
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import step, zero
from ..energy import energy_of
from .flow import NOISE, PhaseFlow
from .switches import functional

if TYPE_CHECKING:
    from ..system import MechanicalSystem
    from .switches import ForceBranch, Functional, Guard, UnilateralContact

#: An entry of the state that differs from that before a switch by less than this part of its terms does not jump.
STILL = 16 * NOISE

#: Rounding errors of a state at the begin of a phase, relative to the sum of the moduli of its terms.
START_NOISE = 4 * EPS


class Source:
    """All that acts from outside: the force on the coordinates, those of some phases, the signals of constraint rows, and the constant 1."""

    def __init__(self, applied: ImpulsiveSmooth, signals: Sequence[ImpulsiveSmooth]):
        self.size, self.signals = applied.size, list(signals)
        self.ends = np.cumsum([applied.size, *(signal.size for signal in signals)]).tolist()
        unit = np.eye(self.ends[-1] + 1)
        total = applied.mapped(unit[:, : self.size]) + step(unit[-1])
        for signal, begin, end in zip(signals, self.ends, self.ends[1:]):
            total = total + signal.mapped(unit[:, begin:end])
        self.total = total
        smooth = total.smooth
        self.coefficients, self.blocks, self.restarts = smooth.coefficients, smooth.blocks, smooth.restarts
        self.loads = {0.0: total.impulses, **{load.time: load.impulses for load in total.later}}

    @cached_property
    def generator(self) -> np.ndarray:
        """J_f."""
        return block_matrix(self.blocks)

    @property
    def knots(self) -> np.ndarray:
        """Times at which the force starts, stops, changes or has impulses, in s."""
        return self.total.knots

    def place(self, signal: ImpulsiveSmooth) -> slice:
        """The rows of a signal."""
        number = next(i for i, own in enumerate(self.signals) if own is signal)
        return slice(self.ends[number], self.ends[number + 1])

    def force_rows(self, system: MechanicalSystem) -> np.ndarray:
        """The force on a phase as rows on (f, signals, 1), shape (n, ...): that in all phases, and its own."""
        rows = np.eye(self.size, self.ends[-1] + 1)
        rows[:, -1] = system.static_force
        if system.excitation is not None:
            rows[:, self.place(system.excitation)] = np.eye(self.size)
        return rows

    def at(self, time: float) -> np.ndarray:
        """The states w at a time, at a knot just after it."""
        piece, since = self.restarts.located(np.array([time]))
        states = self.restarts.states[:, piece]
        return states[:, 0] if not since.any() else block_states(self.blocks, states, since)[:, 0]

    def of_rows(self, system: MechanicalSystem) -> np.ndarray:
        """S with [V^T f; b] = S (f, signals, 1) for the constrained form of a phase."""
        form, n = system.undelayed_form(), self.size
        S = np.zeros((n, self.ends[-1] + 1))
        free = form.null_space.shape[1]
        S[:free] = form.null_space.T @ self.force_rows(system)
        for place, row in enumerate(system.rows, free):
            S[place, -1] = row.value
            if row.signal is not None:
                S[place, self.place(row.signal)] += 1.0
        return S


@dataclass(frozen=True, eq=False)
class PhaseEntry:
    """The states of a phase just after a switch."""

    state: np.ndarray  # y
    size: np.ndarray  # its rounding errors relative to NOISE
    jump: np.ndarray  # of x and x', shape (2, n); exactly zero where they are continuous
    impulses: tuple[np.ndarray, ...]  # of x, shape (n,) each, the k-th multiplies the k-th derivative of Dirac's delta
    reactions: tuple[np.ndarray, ...]  # those of the multipliers, shape (k,) each, in the order of the rows

    @property
    def is_smooth(self) -> bool:
        """Whether nothing jumps and there is no impulse."""
        return not (self.jump.any() or self.impulses or self.reactions)


class Phase:
    """The equations of one phase with the force."""

    def __init__(
        self,
        key: tuple[str, ...],  # the states of all switches
        name: str,  # for messages
        system: MechanicalSystem,
        branches: Sequence[ForceBranch],  # those among the equations, whose forces at x = 0 are in addition to the source
        source: Source,
        guards: Sequence[Guard],  # by which it may end
        longest: float,  # time of interest, s
    ):
        self.key, self.name, self.system, self.source, self.guards = key, name, system, source, tuple(guards)
        self.constant = sum((branch.load for branch in branches), np.zeros(system.size))
        potentials = [branch.potential for branch in branches]
        self.potential_force = system.static_force + sum((force for force, _ in potentials), np.zeros(system.size))
        self.offset = sum(energy for _, energy in potentials)
        form, n, m = system.undelayed_form(), system.size, len(source.coefficients.T)
        S = source.of_rows(system)
        self.load_map = S
        loads = S @ source.coefficients
        loads[: form.null_space.shape[1]] += np.outer(form.null_space.T @ self.constant, source.coefficients[-1])
        self.generator = source.generator
        A0, A1, A2 = (np.pad(matrix, (0, m)) for matrix in form.polynomial_matrix.coefficients)
        A0[:n, n:], A0[n:, n:], A1[n:, n:] = -loads, -self.generator, np.eye(m)
        names = [f"force {i + 1}" for i in range(m)]
        A = PolynomialMatrix(
            [A0, A1, A2], [*system.names, *names], [*form.polynomial_matrix.equations, *(f"of {name}" for name in names)]
        )
        try:
            self.pairs: JordanPairs = A.jordan_pairs()
        except MbconstrainedError as problem:
            raise type(problem)(*(f'phase "{name}": {problem}', *problem.args[1:])) from None
        self._set_maps(n, m)
        self._set_outputs(n, longest)

    def _set_maps(self, n: int, m: int) -> None:
        form = self.pairs.form
        parts, companion, scaling = block_diagonalize(form.T), form.companion, form.companion.scaling
        blocks, scales = [], [np.ones(0)]
        for block in parts.blocks:
            balanced, (scale, _) = scipy.linalg.matrix_balance(block, permute=False, separate=True)
            blocks.append(scaling.time * balanced)
            scales.append(scale)
        scale = np.concatenate(scales)
        self.blocks, self.J = tuple(blocks), block_matrix(blocks)
        outputs = scaling.columns[:, None] * (form.C @ parts.basis) * scale
        self.C, self.of_force = outputs[:n], outputs[n:]
        self.V = self.C @ self.J
        self.outputs = np.vstack([self.C, self.V])
        units = np.zeros((2, n + m, 2 * n + m))  # of x, x' and w
        for order in (0, 1):
            units[order, :n, order * n : (order + 1) * n] = np.eye(n)
        units[0, n:, 2 * n :], units[1, n:, 2 * n :] = np.eye(m), self.generator
        stack = companion.scaled_stack(units)
        self.start = (parts.inverse @ (form.finite_start @ stack)) / scale[:, None]
        self.begin = self.start[:, : 2 * n]  # of x and x' alone
        self.input = scaling.time * (parts.inverse @ form.B)[:, :n] * scaling.rows[:n] / scale[:, None]
        self._start_size = np.abs(self.start) * (START_NOISE / NOISE)
        infinite = form.infinite_start.data @ stack
        self.inconsistency, self._inconsistency_size = infinite, np.abs(infinite)

    def _set_outputs(self, n: int, longest: float) -> None:
        """The outputs that guards read, and their flow."""
        rows, values = np.zeros((len(self.guards), len(self.J))), np.zeros(len(self.guards))
        for place, guard in enumerate(self.guards):
            rows[place] = guard.displacement @ self.C + guard.velocity @ self.V
            for row, factor in guard.reactions.items():
                rows[place] += factor * self.reaction_row(row)
            values[place] = guard.value
        self.flow = PhaseFlow(self.blocks, rows, values, longest)
        self.C_size = self.flow.sizes_of(self.C)
        own = EPS / NOISE * self.flow.rates.max(initial=0.0)  # rounding errors of J: states at rest move by it
        self.V_size = self.flow.sizes_of(self.V) + own * self.C_size

    # Outputs.

    @cached_property
    def static(self) -> np.ndarray:
        """Rows of the force, with that of the elements of the phase, on the states."""
        loads = self.source.force_rows(self.system) @ self.source.coefficients
        return (loads + np.outer(self.constant, self.source.coefficients[-1])) @ self.of_force

    @cached_property
    def reactions(self) -> np.ndarray:
        """Rows of the multipliers lambda = G (M x'' + C x' + K x - f) on the states, shape (k, N)."""
        system = self.system
        inertia = system.mass @ (self.V @ self.J) + system.damping @ self.V + system.stiffness @ self.C
        return system.multiplier_map @ (inertia - self.static)

    @cached_property
    def row_places(self) -> Mapping[str, int]:
        """Places of the constraint rows by name."""
        return {row.name: place for place, row in enumerate(self.system.rows)}

    @cached_property
    def zeros(self) -> dict[Functional, int]:
        """The outputs of constant constraint rows, each with the number of derivatives, the value among them, that are exactly zero."""
        zeros_of_rows = {}
        for row in self.system.rows:
            a, none = row.coefficients, np.zeros(self.system.size)
            if row.signal is None and row.level == "position":
                zeros_of_rows[functional(a, none, row.value)] = 2
            elif row.signal is None and row.level == "velocity":
                zeros_of_rows[functional(none, a, row.value)] = 1
        return zeros_of_rows

    def reaction_row(self, name: str) -> np.ndarray:
        """The row of one multiplier; zero for a row that others make redundant."""
        place = self.row_places.get(name)
        if place is None:
            return np.zeros(len(self.J))
        return self.reactions[place]

    def force_states(self, y: np.ndarray) -> np.ndarray:
        """w."""
        return self.of_force @ y

    def energy(self, x: np.ndarray, v: np.ndarray) -> float:
        """Kinetic, strain and static energy, J."""
        return float(energy_of(self.system.given, self.potential_force, x, v).total) + self.offset

    # PhaseEntry from values just before a switch.

    def enter(
        self, x: np.ndarray, v: np.ndarray, w: np.ndarray, loads: Sequence[np.ndarray] = (), before: np.ndarray | None = None
    ) -> PhaseEntry:
        """The states just after a switch, from x, x' before it, the states of the force after it, and its impulses there.

        ``before`` are moduli of values from which x and x' were computed, and whose rounding errors they have.
        """
        n, stack = self.system.size, np.concatenate([x, v, w])
        sizes = np.abs(stack)
        if before is not None:
            sizes[: 2 * n] = np.maximum(sizes[: 2 * n], before)
        y = self.start @ stack
        size = np.abs(y) + self._start_size @ sizes
        if not loads and (np.abs(self.inconsistency @ stack) <= STILL * (self._inconsistency_size @ sizes)).all():
            return PhaseEntry(y, size, np.zeros((2, n)), (), ())
        impulses = [np.concatenate([self.load_map @ load, np.zeros(len(w))]) for load in loads]
        initial = np.zeros((2, n + len(w)))
        initial[0], initial[1] = np.concatenate([x, w]), np.concatenate([v, self.generator @ w])
        force = ImpulsiveSmooth(zero(n + len(w)).smooth, tuple(impulses))
        begin = starts_of(self.pairs.form, initial[..., None], force)[0]
        for order, load in enumerate(impulses):
            change = np.linalg.matrix_power(self.J, order) @ (self.input @ load[:n])
            y, size = y + change, size + np.abs(change)
        jump = self._jump(x, v, y, size)
        least = NOISE * float(np.abs(initial).max(initial=0.0)) / self.pairs.form.companion.scaling.time
        own = _without_noise([impulse[:n] for impulse in begin.impulses], least)
        return PhaseEntry(y, size, jump, own, self._reactions(jump, own, loads))

    def entry_map(self) -> np.ndarray:
        """The derivative of (x, x') at the begin with respect to those just before it."""
        return self.outputs @ self.begin

    def start_jump(self, initial: np.ndarray, y: np.ndarray) -> np.ndarray:
        """x and x' at t = 0 from y less the initial ones, shape (2, n), zero within rounding errors."""
        sizes = np.abs(np.concatenate([*initial, self.source.at(0.0)]))
        return self._jump(initial[0], initial[1], y, np.abs(y) + self._start_size @ sizes)

    def _jump(self, x: np.ndarray, v: np.ndarray, y: np.ndarray, size: np.ndarray) -> np.ndarray:
        """x and x' from y, which was computed from terms of this size, less those before, zero within rounding errors."""
        jump = np.array([self.C @ y - x, self.V @ y - v])
        sizes = np.array([np.abs(self.C) @ size + np.abs(x), np.abs(self.V) @ size + np.abs(v)])
        jump[np.abs(jump) <= STILL * sizes.max(axis=1, keepdims=True)] = 0.0
        return jump

    def _reactions(self, jump: np.ndarray, impulses: Sequence[np.ndarray], loads: Sequence[np.ndarray]) -> tuple[np.ndarray, ...]:
        """Impulses of the multipliers, as ``mechanics.motion.reaction_impulses``."""
        system = self.system
        if not system.rows:
            return ()
        x = [jump[1], jump[0], *impulses]  # factors of delta in M x'' from here on
        parts = [(system.mass, x), (system.damping, x[1:]), (system.stiffness, x[2:]), (-self.source.force_rows(system), loads)]
        total, size = [], 0.0
        for order in range(max(len(factors) for _, factors in parts)):
            terms = [matrix @ factors[order] for matrix, factors in parts if order < len(factors)]
            size = max(size, *(float(np.abs(term).max(initial=0.0)) for term in terms))
            total.append(system.multiplier_map @ sum(terms))
        return _without_noise(total, STILL * size)

    def impulse_response(self, row: np.ndarray) -> np.ndarray:
        """The change of the states by a unit impulse of force along a row over the coordinates."""
        form = self.system.undelayed_form()
        load = np.concatenate([form.null_space.T @ row, np.zeros(len(form.rows))])
        return self.input @ load

    def has_massless(self, row: np.ndarray) -> bool:
        """Whether an impulse of force along a row would move the coordinates at once, as those without mass."""
        b, n = self.impulse_response(row), self.system.size
        form, time = self.system.undelayed_form(), self.pairs.form.companion.scaling.time
        at_once = self.pairs.laurent(0)[:n, : form.null_space.shape[1]] @ (form.null_space.T @ row)
        by_mass = np.abs(row) @ (np.abs(self.V) @ np.abs(b))
        return bool(max(time * np.abs(self.C @ b).max(), time**2 * abs(row @ at_once)) > STILL * by_mass)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Doubtful decisions and redundant rows of the phase."""
        return distinct(self.system.notices, (notice for notice in pair_notices(self.pairs) if notice.doubtful))


def _without_noise(impulses: Sequence[np.ndarray], size: float) -> tuple[np.ndarray, ...]:
    """Impulses up to the last order with one that is more than a rounding error."""
    cleaned = [np.where(np.abs(impulse) > size, impulse, 0.0) for impulse in impulses]
    while cleaned and not cleaned[-1].any():
        cleaned.pop()
    return tuple(cleaned)


def checked_source(systems: Sequence[MechanicalSystem], force) -> Source:
    """A user's force in all phases, the excitations of each, and the signals of constraint rows."""
    signals: list[ImpulsiveSmooth] = []
    for signal in (one for system in systems for one in (system.excitation, *(row.signal for row in system.rows))):
        if signal is not None and not any(signal is own for own in signals):
            signals.append(signal)
    without = copy(systems[0])
    without.excitation, without.static_force = None, np.zeros(without.size)
    return Source(without._applied(force), signals)


# Impacts of rigid contacts.

#: Contacts depend on each other where the least eigenvalue of their scaled mobility is below this part of the largest, by number.
DEPENDENT = 16 * NOISE

#: Most pivots by the number of contacts.
PIVOTS = 50


class ContactSet:
    """Rigid contacts that touch, and what their impulses do to a phase without them, in which bounded forces slip."""

    def __init__(self, phase: Phase, contacts: Sequence[UnilateralContact]):
        self.phase = phase
        self.massless = [phase.has_massless(contact.row) for contact in contacts]
        self.rows = np.array([contact.row for contact in contacts])
        self.restitution = np.array([contact.restitution for contact in contacts])
        #: Of the states and of the velocities along the contacts to unit impulses.
        self.response = np.array([phase.impulse_response(contact.row) for contact in contacts]).T
        self.mobility = self.rows @ phase.V @ self.response

    @cached_property
    def is_dependent(self) -> bool:
        """Whether impulses of the contacts are not unique."""
        scale = np.sqrt(np.maximum(np.diag(self.mobility), np.finfo(float).tiny))
        values = np.linalg.eigvalsh(self.mobility / scale / scale[:, None])
        return bool(values[0] <= DEPENDENT * len(values) * values[-1])

    def solve(self, before: np.ndarray, restitution: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The impulses of contacts, and which are at rest afterwards, from their velocities before, whose terms have the moduli ``size``."""
        p = impulses_of_contacts(self.mobility, before, restitution)
        p[p <= 4 * EPS * p.max(initial=0.0)] = 0.0
        after = before + self.mobility @ p
        noise = NOISE * (size + np.abs(self.mobility) @ p)
        return p, np.where(p > 0, restitution * before == 0, np.abs(after) <= noise)

    def row_impulses(self, p: np.ndarray, moved: np.ndarray, gained: np.ndarray) -> dict[str, float]:
        """The impulses of the constraint rows of the phase, by name, from the changes of x and x'."""
        return row_impulses(self.phase.system, self.rows.T @ p, moved, gained)

    def derivative(self, restitution: np.ndarray, p: np.ndarray) -> np.ndarray:
        """The derivative of (x, x') after the impact with respect to those before it."""
        n = self.phase.system.size
        total, own = np.eye(2 * n), np.flatnonzero(p > 0)
        if len(own):
            by = np.linalg.solve(self.mobility[np.ix_(own, own)], (1 + restitution[own])[:, None] * self.rows[own])
            total[:, n:] -= self.phase.outputs @ self.response[:, own] @ by
        return total


def row_impulses(system: MechanicalSystem, other: np.ndarray, moved: np.ndarray, gained: np.ndarray) -> dict[str, float]:
    """The impulses of the constraint rows of a system that are more than rounding errors, next to other ones, from the changes of x and x'."""
    if not system.rows:
        return {}
    terms = [system.mass @ gained, system.damping @ moved, -other]
    total = system.multiplier_map @ sum(terms)
    noise = 16 * NOISE * (np.abs(system.multiplier_map) @ sum(map(np.abs, terms)))
    return {row.name: float(own) for row, own, least in zip(system.rows, total, noise) if abs(own) > least}


def impulses_of_contacts(W: np.ndarray, before: np.ndarray, restitution: np.ndarray) -> np.ndarray:
    """p >= 0 with W p + (1 + e) u- >= 0, complementary, shape (k,), from W, velocities by unit impulses; NotUnique where there is none.

    >>> W, u = np.array([[2.0, -1.0], [-1.0, 2.0]]), np.array([-1.0, 0.0])  # a ball meets one that touches a wall
    >>> impulses_of_contacts(W, u, np.zeros(2)).round(12).tolist()
    [0.666666666667, 0.333333333333]
    """
    return complementary(W, before + restitution * before)  # 1 + e would be rounded in all impacts alike


def complementary(M: np.ndarray, q: np.ndarray) -> np.ndarray:
    """z >= 0 with w = M z + q >= 0 and w z = 0, by Lemke's method with lexicographic ratios."""
    k = len(q)
    if (q >= 0).all():
        return np.zeros(k)
    if k == 1 and M[0, 0] > 0:
        return -q / M[0, 0]
    table = np.hstack([np.eye(k), -M, -np.ones((k, 1)), q[:, None]])  # w - M z - z0 = q
    right = np.hstack([q[:, None], np.eye(k)])
    basis = list(range(k))
    row = int(min(range(k), key=lambda i: tuple(right[i])))
    entering = 2 * k
    size = np.abs(table).max()
    for _ in range(PIVOTS * k):
        pivot = table[row, entering]
        factor = table[:, entering] / pivot
        factor[row] = 0.0
        own, its = table[row] / pivot, right[row] / pivot
        table, right = table - np.outer(factor, table[row]), right - np.outer(factor, right[row])
        table[row], right[row] = own, its
        leaving, basis[row] = basis[row], entering
        if leaving == 2 * k:
            z = np.zeros(2 * k + 1)
            z[basis] = table[:, -1]
            return np.maximum(z[k : 2 * k], 0.0)
        entering = leaving + k if leaving < k else leaving - k
        column = table[:, entering]
        candidates = np.flatnonzero(column > EPS * size * k)
        if not len(candidates):
            break
        row = int(min(candidates, key=lambda i: (*(right[i] / column[i]), basis[i] != 2 * k)))
        first = right[candidates, 0] / column[candidates]
        if 2 * k in basis:  # z0 leaves where it may
            place = basis.index(2 * k)
            if place in candidates and right[place, 0] / column[place] <= first.min() * (1 + EPS):
                row = place
    raise NotUnique(
        "the impulses of contacts that touch at one time have no solution; look for contacts that press against each other"
    )
