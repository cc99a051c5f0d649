"""Exact discretization: matrix exponentials of held inputs in ball arithmetic, delays of any length as extra states.

Between samples x' = A x + B u is driven by v + m s, s the time since the sample. The exponential of [[A, B, 0], [0, 0, I], [0, 0, 0]] t
has Phi(t) = e^(A t), Gamma_1 = integral of Phi(t - s) B ds and Gamma_2 = integral of Phi(t - s) B s ds in its first row (Van Loan 1978).
An input that is late by m steps and a part rho of a step switches within the step: the state passes through two such pieces.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import flint
import numpy as np
import scipy.linalg

from ..exact.rational import rational, working_precision
from ..ground.checks import nearest, real_number
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind
from .conversions import OrdinaryForm, _through

if TYPE_CHECKING:
    from .state_equations import StateEquations

#: Bits of the exponentials, and the size up to which they are computed so; larger ones in float64.
BITS, LARGEST_BALLS = 320, 120

HOLDS = (0, 1, "impulse")


class Pieces(NamedTuple):
    """x_(k+1) = Phi x_k + before u_(k-1) + now u_k + after u_(k+1) of one input, and its part of y_k."""

    before: list
    now: list
    after: list


@dataclass(frozen=True, eq=False)
class Sampled:
    """The matrices of a discretized system, and what connects it with the continuous one.

    Attributes:
        A, B, C, D: of the discrete system; the states are those of the ordinary form, then delayed inputs.
        start_map: the discrete states that belong to the states x(0-) of the continuous system, shape (n, N).
        start_input: their change by u_0, shape (n, p).
        delayed: names of the added states.
        notices: remarks.
    """

    A: np.ndarray
    B: np.ndarray
    C: np.ndarray
    D: np.ndarray
    start_map: np.ndarray
    start_input: np.ndarray
    delayed: tuple[str, ...]
    notices: tuple[Notice, ...]


def sampled(system: StateEquations, step, hold=1, delays: Mapping[str, float] | None = None) -> Sampled:
    """Discretize E x' = A x + B u, y = C x + D u."""
    step = real_number(step, "step", positive=True)
    if isinstance(hold, bool) or hold not in HOLDS:
        raise InputError(f"hold: found {hold!r}; expected 0 (constant between samples), 1 (linear between samples) or 'impulse'")
    form, start_map, derivative, is_exact = _ordinary(system)
    rates = _derivative_terms(system, hold, derivative)
    late = _delays(system, delays)
    form = OrdinaryForm(*(np.asarray(matrix, dtype=object if is_exact else float) for matrix in form))
    with working_precision(BITS):
        A, B, C, D, start_input, delayed = _assembled(system, form, rates, late, Fraction(step), hold)
    notices = tuple(
        Notice(
            NoticeKind.KINK,
            f'{system.outputs[i]}: its part that follows the derivative of "{system.inputs[j]}" is that just before each sample',
        )
        for i, j in np.argwhere(rates)
    )
    return Sampled(A, B, C, D, start_map, start_input, delayed, notices)


def _ordinary(system: StateEquations) -> tuple[OrdinaryForm, np.ndarray, dict[int, np.ndarray], bool]:
    """The ordinary form (exact numbers where E is regular), the map of the start, and what follows derivatives of u by their order."""
    n = len(system.A)
    A, B, C, D = (
        np.vectorize(rational, [object])(m) if m.size else m.astype(object) for m in (system.A, system.B, system.C, system.D)
    )
    if (system.E == np.eye(n)).all():
        return OrdinaryForm(A, B, C, D), np.eye(n), {}, True
    pairs = system.polynomial_matrix().jordan_pairs()
    if not any(pairs.structure.infinite_divisors):
        E = flint.fmpq_mat([[rational(v) for v in row] for row in system.E.tolist()])
        both = E.solve(flint.fmpq_mat([[*a, *b] for a, b in zip(A.tolist(), B.tolist())])).tolist()
        solution = np.array(both, dtype=object).reshape(n, n + B.shape[1])
        return OrdinaryForm(solution[:, :n], solution[:, n:], C, D), np.eye(n), {}, True
    finite, highest = pairs.finite, pairs.structure.highest_impulse
    derivative = {i: _through(system, i) for i in range(1, highest + 1)}
    D0 = system.D + _through(system, 0)
    own = OrdinaryForm(finite.J, finite.B @ system.B, system.C @ finite.C, D0)
    return own, finite.B @ system.E, {i: G for i, G in derivative.items() if G.any()}, False


def _derivative_terms(system: StateEquations, hold, derivative: Mapping[int, np.ndarray]) -> np.ndarray:
    """G_1, shape (q, p), of outputs that follow the derivative of an input; those that a held input does not have are refused."""
    for order, G in sorted(derivative.items(), reverse=True):
        if hold != 1 or order > 1:
            i, j = np.argwhere(G)[0]
            which = {1: "derivative", 2: "second derivative"}.get(order, f"derivative of order {order}")
            remedy = "give hold=1, or leave this output out" if order == 1 else "leave this output out"
            raise InputError(
                f'hold={hold!r}: the output "{system.outputs[i]}" follows the {which} of the input "{system.inputs[j]}", which has '
                f"Dirac impulses at the samples there; {remedy}"
            )
    return derivative.get(1, np.zeros((len(system.C), system.B.shape[1])))


def _delays(system: StateEquations, delays: Mapping[str, float] | None) -> list[Fraction]:
    given = {} if delays is None else delays
    if not isinstance(given, Mapping):
        raise InputError(f"delays: found {type(given).__name__}; expected a mapping from names of inputs to delays in s")
    for name in given:
        if name not in system.inputs:
            raise InputError(f'delays: there is no input "{name}"{nearest(name, system.inputs)}')
    return [Fraction(real_number(given.get(name, 0.0), f"delay of {name}", minimum=0.0)) for name in system.inputs]


def _assembled(system, form: OrdinaryForm, rates, late: Sequence[Fraction], step: Fraction, hold):
    n, p, q = len(form.A), len(system.inputs), len(system.C)
    Phi = _exponential(form.A, np.zeros((n, 0), dtype=object), step)[0]
    C = _balls(form.C, q, n)
    columns, memories, chains = [], [], []
    for j in range(p):
        count, rho = divmod(late[j], step)
        if step - rho < step * Fraction(1, 2**44) or rho < step * Fraction(
            1, 2**44
        ):  # a multiple of the step but for rounding errors
            count, rho = round(late[j] / step), Fraction(0)
        b, d = (
            form.B[:, j : j + 1],
            np.array([[rational(v) if not isinstance(v, flint.fmpq) else v] for v in form.D[:, j]], dtype=object).reshape(q, 1),
        )
        before, now, after, direct_before, direct_now = _pieces(form.A, b, d, C, rho, step, hold, system, j)
        follow = _balls(np.array([[rational(float(g)) / rational(step)] for g in rates[:, j]], dtype=object).reshape(q, 1), q, 1)
        direct_before, direct_now = direct_before - follow, direct_now + follow
        columns.append((before, Phi * after + now, after, direct_before, C * after + direct_now))
        memories.append(any(not _vanishes(part) for part in (before, direct_before)))
        chains.append(int(count))
    return _joined(system, Phi, C, columns, memories, chains)


def _pieces(A, b, d, C, rho: Fraction, step: Fraction, hold, system, j: int):
    """What u_(k-1), u_k and u_(k+1) add to x_(k+1), and u_(k-1), u_k to y_k."""
    n, q = len(A), len(d)
    share = _ball(rho / step)
    nothing, none = flint.arb_mat(n, 1), flint.arb_mat(q, 1)
    D, h = _balls(d, q, 1), _ball(step)
    Phi, G1, G2 = _exponential(A, b, step - rho)
    _, F1, F2 = _exponential(A, b, rho)
    if hold == 0:
        return Phi * F1, G1, nothing, D if rho else none, none if rho else D
    if hold == 1:
        first = F1 * share - F2 * (1 / h)
        second = F1 * (1 - share) + F2 * (1 / h)
        return Phi * first, G1 - G2 * (1 / h) + Phi * second, G2 * (1 / h), D * share, D * (1 - share)
    if not _vanishes(D):
        raise InputError(
            f'hold="impulse": an output follows the input "{system.inputs[j]}" itself, which is a train of Dirac impulses'
        )
    B = _balls(b, n, 1)
    return nothing, Phi * B, nothing, none, none if rho else C * B


def _joined(system, Phi, C, columns, memories, chains):
    """All inputs together, with the states u_(k-1) and chains of delays, rounded to float64."""
    n, p, q = Phi.nrows(), len(columns), C.nrows()
    names = []
    extra = [memory + chain for memory, chain in zip(memories, chains)]
    N = n + sum(extra)
    A, B, CC, D = np.zeros((N, N)), np.zeros((N, p)), np.zeros((q, N)), np.zeros((q, p))
    start_input = np.zeros((N, p))
    A[:n, :n], CC[:, :n] = _floats(Phi), _floats(C)
    place = n
    for j, (column, memory, count) in enumerate(zip(columns, memories, chains)):
        before, now, after, direct_before, direct_now = map(_floats, column)
        source = place + count - 1  # the end of the chain, which holds u_(k-m)
        for i in range(count):
            if i:
                A[place + i, place + i - 1] = 1.0
            else:
                B[place, j] = 1.0
            names.append(f"{system.inputs[j]} {i + 1} before")
        into, through = (A, CC) if count else (B, D)
        at = source if count else j
        into[:n, at], through[:, at] = now[:, 0], direct_now[:, 0]
        if not count:
            start_input[:n, j] = -after[:, 0]
        place += count
        if memory:
            into[place, at] = 1.0
            A[:n, place], CC[:, place] = before[:, 0], direct_before[:, 0]
            names.append(f"{system.inputs[j]} {count + 1} before")
            place += 1
    return A, B, CC, D, start_input, tuple(names)


def _exponential(A, b, time: Fraction):
    """Phi, Gamma_1 and Gamma_2 of one input after a time."""
    n, p = len(A), b.shape[1]
    size = n + 2 * p
    table = [[0] * size for _ in range(size)]
    for i in range(n):
        table[i][: n + p] = [*A[i], *b[i]]
    for j in range(p):
        table[n + j][n + p + j] = 1
    t = _ball(time)
    if size > LARGEST_BALLS:
        result = scipy.linalg.expm(np.array([[float((flint.arb(_number(v)) * t).mid()) for v in row] for row in table]))
        rows = [[flint.arb(float(v)) for v in row] for row in result[:n]]
    else:
        rows = (flint.arb_mat([[flint.arb(_number(v)) * t for v in row] for row in table]).exp().tolist() if size else [])[:n]
    ends = ((0, n), (n, n + p), (n + p, size))
    return tuple(flint.arb_mat(n, end - begin, [v for row in rows for v in row[begin:end]]) for begin, end in ends)


def _number(value) -> flint.fmpq:
    return value if isinstance(value, flint.fmpq) else rational(value)


def _ball(number: Fraction) -> flint.arb:
    return flint.arb(rational(number))


def _balls(matrix, rows: int, columns: int) -> flint.arb_mat:
    return flint.arb_mat(rows, columns, [flint.arb(_number(v)) for row in np.asarray(matrix).tolist() for v in row])


def _vanishes(matrix: flint.arb_mat) -> bool:
    return all(entry == 0 for entry in matrix.entries())


def _floats(matrix: flint.arb_mat) -> np.ndarray:
    values = [0.0 if entry.contains(0) else float(entry.mid()) for entry in matrix.entries()]
    return np.array(values).reshape(matrix.nrows(), matrix.ncols())
