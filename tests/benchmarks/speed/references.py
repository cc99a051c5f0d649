"""What is true: ball arithmetic for up to some 40 states, Taylor steps in long doubles for the long chains.

Ball arithmetic (Arb) keeps a bound of the error in every number. The steps in long doubles keep 64 bits where the machine has them, which leaves an
error of 1e-15 or so of the largest value, as the balls of the shortest chain confirm.

Neither uses the package or float64 on the way: the equations are reduced anew from the data in fractions or long doubles.
"""

import math

import numpy as np
import scipy.sparse

from tests.benchmarks.speed.models import Equations

#: Bits of the balls, and how often e^{S dt / 2^k} is squared at least: where S dt is 1e14, some 800 bits are lost on the way.
BALL_BITS, SQUARINGS = 1500, 8

#: The reference must be better than this, relative to the largest value.
GOOD = 1e-17

#: A Taylor step h is so long that |S| h is at most this: longer ones need fewer products, and lose digits to cancellation.
REACH = 6.0

#: Terms of the series are taken until they are smaller than this.
LAST_TERM = 1e-20

#: |S| is that of a power with so many factors, |S^16|^(1/16) and somewhat more: near the largest rate, not above all of it.
SQUARINGS_OF_NORM, MORE = 4, 1.1


def by_balls(equations: Equations, times: np.ndarray) -> np.ndarray:
    """x at multiples of one step, by powers of e^{S step} with the error kept in every number, shape (N, T)."""
    import flint

    before, flint.ctx.prec = flint.ctx.prec, BALL_BITS
    try:
        S, E = _ball_matrix(equations.S), _ball_matrix(equations.E)
        step = flint.arb(flint.fmpq(*float(times[1]).as_integer_ratio()))
        power, states = _propagator(S * step), [_ball_matrix(equations.start[:, None])]
        while len(states) < len(times):
            states += [power * state for state in states]
            power = power * power
        answers = [(E * state).entries() for state in states[: len(times)]]
        columns = [[float(value.mid()) for value in answer] for answer in answers]
        radius = max(float(value.rad()) for answer in answers for value in answer)
    finally:
        flint.ctx.prec = before
    found = np.array(columns).T
    if not radius <= GOOD * np.abs(found).max():
        raise ArithmeticError(f"the balls grew to {radius:.0e}; give them more than {BALL_BITS} bits")
    return found


def _propagator(matrix):
    """e^matrix, by squaring: Arb's own gives up where the matrix is large."""
    import flint

    largest = max(abs(float(entry.mid())) for entry in matrix.entries())
    squarings = SQUARINGS + max(0, math.ceil(math.log2(largest)))
    power = (matrix * flint.arb(2) ** -squarings).exp()
    for _ in range(squarings):
        power = power * power
    return power


def _ball_matrix(array):
    import flint

    entries = [[flint.arb(flint.fmpq(entry.numerator, entry.denominator)) for entry in row] for row in array]
    return flint.arb_mat(entries)


def by_taylor(equations: Equations, times: np.ndarray) -> np.ndarray:
    """x at multiples of one step, each step divided as the series needs it, shape (N, T)."""
    S, step = _sparse(equations.S), np.longdouble(times[1])
    parts, terms = steps_of(S, float(step))
    found = np.empty((len(equations.E), len(times)))
    E, state = _sparse(equations.E), equations.start.astype(np.longdouble)
    for place in range(len(times)):
        found[:, place] = E @ state
        for _ in range(parts if place < len(times) - 1 else 0):
            state = _taylor_step(S, state, step / parts, terms)
    return found


def record_by_taylor(equations: Equations, times: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The same under a force b u(t), u straight between its values at the times."""
    m, b = len(equations.S), equations.b.astype(np.longdouble)[:, None]
    corner = np.array([[0, 1], [0, 0]], dtype=np.longdouble)
    left = np.vstack([equations.S, np.zeros((2, m), dtype=np.longdouble)])
    whole = np.hstack([left, np.vstack([np.hstack([b, b * 0]), corner])])
    S, step = _sparse(whole), np.longdouble(times[1])
    parts, terms = steps_of(S, float(step))
    found, E = np.empty((len(equations.E), len(times))), _sparse(equations.E)
    state, u = np.append(equations.start.astype(np.longdouble), [0, 0]), values.astype(np.longdouble)
    for place in range(len(times)):
        found[:, place] = E @ state[:m]
        if place < len(times) - 1:
            state[m], state[m + 1] = u[place], (u[place + 1] - u[place]) / step
            for _ in range(parts):
                state = _taylor_step(S, state, step / parts, terms)
    return found


def steps_of(S, step: float) -> tuple[int, int]:
    """Into how many parts a step is divided, and how many terms each takes."""
    power = S.astype(float)
    for _ in range(SQUARINGS_OF_NORM):
        power = power @ power
    size = MORE * float(abs(power).sum(axis=1).max()) ** (0.5**SQUARINGS_OF_NORM) * step
    parts = max(1, math.ceil(size / REACH))
    reach, term, count = size / parts, 1.0, 0
    while term > LAST_TERM:
        count += 1
        term *= reach / count
    return parts, count + 2


def _taylor_step(S, state: np.ndarray, step, terms: int) -> np.ndarray:
    term, total = state, state.copy()
    for order in range(1, terms + 1):
        term = S @ term
        term *= step / order
        total += term
    return total


def _sparse(matrix):
    return scipy.sparse.csr_array(np.asarray(matrix, dtype=np.longdouble))
