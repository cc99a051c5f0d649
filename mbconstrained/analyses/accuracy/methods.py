"""The compared methods in one table, those of this package first; a method computes x at the times of a problem.

The other tools step the reduced equations z' = S z + B f of ``first_order`` from one knot of the force to the next: the exponential of S and the
force together (Van Loan 1978), ``scipy.signal.lsim`` and ``control.forced_response``, which are exact for inputs that are linear between
samples, ``solve_ivp`` and ``odeint``. IDA of SUNDIALS gets the original equations, with multipliers and singular masses.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from copy import copy
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from importlib.util import find_spec
from itertools import groupby, pairwise

import numpy as np

from ...ground.tolerances import EPS
from ...linalg.blocks import block_slices
from ...mechanics.constraints import LEVELS, with_multipliers
from ...mechanics.motion import reaction_function
from ...mechanics.switched.flow import Crossing, PhaseFlow
from ...mechanics.switched.phase import Phase, complementary
from ...mechanics.switched.sequence import MOST_EVENTS, PhaseSequence
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ..study_problem import StudyProblem, SwitchedProblem, given_of
from .first_order import (
    SAME_TIME,
    Formula,
    Interval,
    Reduced,
    intervals,
    intervals_of,
    jumps_of,
    knots_of,
    reduced,
    sizes_of,
    stepped,
)

Evaluate = Callable[[], np.ndarray]

#: Digits of exact arithmetic.
DIGITS = 15

#: Steps of one length computed together as the product of one matrix with many columns, and bytes of all propagators together.
MOST_COLUMNS, MOST_BYTES = 64, 2**30

#: Most states, and most work (times by states cubed), of one exponential for each time.
MOST_STATES, MOST_WORK = 100, 2e9

#: Most numbers of samples, states and outputs together.
MOST_NUMBERS = 2e7

#: Steps from one time to the next: more than the time of any run allows.
ODEINT_STEPS, IDA_STEPS = 10**8, 10**7

#: Absolute tolerance of an unknown that is excluded from the error test, relative to its size.
UNTESTED = 1e10

#: Most unknowns for SUNDIALS' own dense factorization; LAPACK is faster for larger ones.
MOST_SMALL = 100


class Failure(Exception):
    """A method cannot solve a problem; the text is the reason."""


@dataclass(frozen=True)
class MethodSetting:
    """Setting of a method, such as a tolerance: a label such as "rtol 1e-06", and the argument of the method."""

    label: str = ""
    value: float | None = None


def tolerances(*digits: int) -> tuple[MethodSetting, ...]:
    """Relative tolerances of 10^-digits."""
    return tuple(MethodSetting(f"rtol {10.0**-count:.0e}", 10.0**-count) for count in digits)


@dataclass(frozen=True)
class ComparedMethod:
    """Method with its settings."""

    name: str  # such as "solve_ivp DOP853"
    #: the set-up for a problem with the value of a setting; returns a function that evaluates x at the times, (r, T)
    prepare: Callable[[StudyProblem, float | None], Evaluate]
    settings: tuple[MethodSetting, ...] = (MethodSetting(),)  # settings from coarse to fine
    #: the reason why it does not apply to a problem; empty where it does
    refusal: Callable[[StudyProblem], str] = lambda problem: ""
    concerns: Callable[[StudyProblem], bool] = lambda problem: True  # whether it is listed for such a problem
    is_ours: bool = False  # whether it is a method of this package
    #: whether the value of a setting has an effect on a problem; otherwise it is not run
    matters: Callable[[StudyProblem, float | None], bool] = lambda problem, value: True
    library: str = ""  # the module that it uses; loaded before run times are measured

    def settings_for(self, problem: StudyProblem) -> tuple[MethodSetting, ...]:
        """The settings with an effect on a problem; at least the coarsest."""
        some = () if self.refusal(problem) else (setting for setting in self.settings if self.matters(problem, setting.value))
        return tuple(some) or self.settings[:1]


def refusal_without_states(problem: StudyProblem) -> str:
    """The reason why stepping methods do not apply to a problem without states; else empty."""
    return "" if reduced(problem).count else "there are no states: x depends on the force at the same time only"


# --- this package


def _evaluation(solve: Callable, times) -> Evaluate:
    """Set up by solving; the first evaluation includes its own preparations."""
    response = solve()
    return lambda: response(times)


def _assembled(problem: StudyProblem, _) -> Evaluate:
    A = problem.polynomial_matrix
    matrix = PolynomialMatrix(A.coefficients, A.coordinates, A.equations)
    return _evaluation(replace(problem, polynomial_matrix=matrix, system=None).solve_equations, problem.times)


def _exact(problem: StudyProblem, _) -> Evaluate:
    exact = problem.solve().exact
    return lambda: exact.enclose(problem.times, DIGITS).lower.astype(float)


def _apostol_kolodner(problem: StudyProblem, _) -> Evaluate:
    """C e^{J t} x_s(0) with x_s(0) = [J^(q-1) B A_q ... B A_q] X_0 (Eq. 75)."""
    A = PolynomialMatrix(given_of(problem.polynomial_matrix))
    pair, power = A.jordan_pairs().finite, np.linalg.matrix_power
    parts = (power(pair.J, A.degree - 1 - i) @ (pair.B @ (A.coefficients[-1] @ x)) for i, x in enumerate(problem.initial))
    motion = BohlFunction(pair.C, pair.blocks, sum(parts, np.zeros(len(pair.J))))
    return lambda: motion(problem.times)


def _has_elements(problem: StudyProblem) -> bool:
    return any(not isinstance(given, np.ndarray) for given in given_of(problem.polynomial_matrix))


def _is_free_and_undamped(problem: StudyProblem) -> bool:
    return problem.force.is_zero and not any(np.any(matrix) for matrix in problem.polynomial_matrix.coefficients[1:-1])


# --- exponentials: exact up to rounding errors for Bohl forces


def _augmented(problem: StudyProblem, equations: Reduced) -> tuple[np.ndarray, np.ndarray]:
    """[[S, B C_f u], [0, J_f]], and w / u at each knot as columns, for f = C_f w, w' = J_f w.

    The units u, in which the input of w is about as large as S, are powers of two, one for all states of a block, so that its generator stays
    what it is.
    """
    force = problem.force.smooth.with_knots(problem.force.knots)
    input_matrix, size = equations.B @ force.coefficients, np.abs(equations.S).max(initial=0.0) or 1.0
    units = np.ones(input_matrix.shape[1])
    for at in block_slices(force.blocks):
        if largest := np.abs(input_matrix[:, at]).max(initial=0.0):
            units[at] = np.exp2(np.round(np.log2(size / largest)))
    nothing = np.zeros((input_matrix.shape[1], equations.count))
    matrix = np.block([[equations.S, input_matrix * units], [nothing, force.generator]])
    return matrix, force.restarts.states / units[:, None]


def _by_steps(problem: StudyProblem, _) -> Evaluate:
    """Set up one exponential for each length of step; the evaluation makes the steps."""
    from scipy.linalg import expm

    equations, parts = reduced(problem), intervals_of(problem)
    matrix, inputs = _augmented(problem, equations)
    steps = [np.diff(part.stops, prepend=part.begin) for part in parts]
    kinds, lengths = _lengths(np.concatenate(steps), problem.times[-1])
    kinds_of = np.split(kinds, np.cumsum([len(part) for part in steps])[:-1])
    longest = np.zeros(len(lengths), dtype=int)
    for part in kinds_of:
        for kind, count in _runs(part):
            longest[kind] = max(longest[kind], count)
    doublings = np.log2(np.minimum(longest, MOST_COLUMNS)).astype(int)
    if 8 * matrix.size * (len(lengths) + doublings.sum()) > MOST_BYTES:
        raise Failure(
            f"{np.count_nonzero(lengths)} lengths of step with {len(matrix)} states each need a matrix exponential of their own"
        )
    powers_of = [[expm(matrix * length) if length else np.eye(len(matrix))] for length in lengths]
    for powers, count in zip(powers_of, doublings):
        for _ in range(count):
            powers.append(powers[-1] @ powers[-1])

    def advance(number: int, interval: Interval, state: np.ndarray) -> np.ndarray:
        blocks = [np.concatenate([state, inputs[:, number]])[:, None]]
        for kind, count in _runs(kinds_of[number]):
            blocks.append(_steps(powers_of[kind], blocks[-1][:, -1], count))
        return np.hstack(blocks[1:])[: equations.count]

    return lambda: stepped(problem, equations, parts, advance)


def _runs(kinds: np.ndarray) -> Iterator[tuple[int, int]]:
    """Kind and number of successive equal steps."""
    return ((int(kind), len(list(steps))) for kind, steps in groupby(kinds))


def _lengths(steps: np.ndarray, end: float) -> tuple[np.ndarray, np.ndarray]:
    """Index of the length of each step, and the lengths; those that differ by rounding errors are one."""
    order = np.argsort(steps)
    is_new = np.diff(steps[order], prepend=steps[order[:1]]) > SAME_TIME * EPS * end
    kinds = np.empty(len(steps), dtype=int)
    kinds[order] = np.cumsum(is_new)
    return kinds, np.bincount(kinds, steps) / np.maximum(np.bincount(kinds), 1)


def _steps(powers: list[np.ndarray], state: np.ndarray, count: int) -> np.ndarray:
    """The states after 1, 2, ..., count steps, by P, P^2, P^4, ..."""
    block = (powers[0] @ state)[:, None]
    for power in powers[:-1]:
        block = np.hstack([block, power @ block])
    blocks = [block]
    while len(blocks) * block.shape[1] < count:
        blocks.append(powers[-1] @ blocks[-1])
    return np.hstack(blocks)[:, :count]


def _by_single_exponentials(problem: StudyProblem, _) -> Evaluate:
    """Set up nothing: no work is shared by the times."""
    from scipy.linalg import expm

    equations = reduced(problem)
    matrix, inputs = _augmented(problem, equations)
    start = np.concatenate([equations.start, inputs[:, 0]])
    together = max(1, int(MOST_BYTES / 64 / matrix.size))  # some eight temporary copies in the exponential
    chunks = [problem.times[first : first + together, None, None] for first in range(0, len(problem.times), together)]

    def evaluate() -> np.ndarray:
        states = np.vstack([expm(chunk * matrix) @ start for chunk in chunks]).T
        return equations.coordinates(states[: equations.count], problem.times)

    return evaluate


def _single_exponentials_refusal(problem: StudyProblem) -> str:
    if len(knots_of(problem.force, problem.times)) > 1:
        return "the force starts, stops, changes or has an impulse on the way; one exponential from t = 0 does not include it"
    states = reduced(problem).count + problem.force.smooth.coefficients.shape[1]
    if states > MOST_STATES or len(problem.times) * states**3 > MOST_WORK:
        return f"{len(problem.times)} exponentials of {states} states take too long"
    return refusal_without_states(problem)


# --- lsim and forced_response: even samples of the input, for other forces with steps divided by 4, 16 and 64

#: A, B, C, samples of the inputs (p, L), times, start -> C z (r, L) and the last z.
Simulate = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@lru_cache(maxsize=8)
def _samples(problem: StudyProblem, refinement: int):
    """B and C for the inputs, a unit of z, the step, and for each part of time the samples (p, L) and the impulses at its end.

    A part ends where the force jumps or has an impulse at a sample; there the samples are the limits from within, as two samples at one time
    cannot be given. The inputs are as few as B f has independent rows. In units of z in which they are about 1 and their matrix is about as large
    as S the exponential keeps its digits, and python-control, which takes inputs below 1e-8 for none, sees them.
    """
    equations, force, end = reduced(problem), problem.force, problem.times[-1]
    count = (len(problem.times) - 1) * refinement
    if (count + refinement) * (equations.S.size + equations.C.size) > MOST_NUMBERS * equations.count:
        raise Failure(f"{count + refinement} samples of all states and coordinates are too many")
    times, step = np.linspace(0.0, end, count + 1), end / count
    loads, jumps = {load.time: load.impulses for load in force.later}, jumps_of(force.smooth)
    cuts = {0: 0.0, count: float(end)}
    for knot in map(float, knots_of(force, problem.times)[1:]):
        place = round(knot / step)
        is_even = abs(knot - place * step) <= SAME_TIME * EPS * end
        if knot in loads and not is_even:
            raise Failure(f"the Dirac impulse at {knot:g} s lies between the samples; there is no input for it")
        if is_even and (knot in loads or np.any(jumps.get(knot, 0.0))):
            cuts[place] = times[place] = knot
    excitation = equations.B @ force.smooth(times)
    basis, sizes, _ = np.linalg.svd(excitation, full_matrices=False)
    matrix = basis[:, : max(1, int((sizes > max(excitation.shape) * EPS * sizes[0]).sum()))]
    size, parts = np.abs(equations.S).max() or 1.0, []
    unit = (np.abs(excitation).max() or 1.0) / size
    for first, last in pairwise(sorted(cuts)):
        inputs = excitation[:, first : last + 1].copy()
        if cuts[last] in jumps:
            inputs[:, -1] -= equations.B @ jumps[cuts[last]]
        parts.append((matrix.T @ inputs / (size * unit), loads.get(cuts[last], ())))
    return size * matrix, unit * equations.C, unit, step, parts


def _simulated(simulate: Simulate, problem: StudyProblem, refinement: int) -> Evaluate:
    """Sample the inputs; the solver has no set-up of its own. The instantaneous response is added from its formula."""
    equations = reduced(problem)
    B, C, unit, step, parts = _samples(problem, int(refinement))

    def evaluate() -> np.ndarray:
        state, blocks = equations.start / unit, []
        for inputs, impulses in parts:
            times = step * np.arange(inputs.shape[1])
            outputs, state = simulate(equations.S, B, C, inputs, times, state)
            blocks.append(outputs[:, :-1])
            state = state + equations.jump(impulses) / unit
        x = np.hstack([*blocks, (C @ state)[:, None]])[:, ::refinement]
        return x if equations.through.is_zero else x + equations.through(problem.times)

    return evaluate


def _lsim(A, B, C, inputs, times, start) -> tuple[np.ndarray, np.ndarray]:
    from scipy.signal import lsim

    system = (A, B, C, np.zeros((len(C), B.shape[1])))
    _, outputs, states = lsim(system, inputs.T if inputs.any() else None, times, start)
    return outputs.reshape(len(times), -1).T, states.reshape(len(times), -1)[-1]


def _forced_response(A, B, C, inputs, times, start) -> tuple[np.ndarray, np.ndarray]:
    from control import StateSpace, forced_response

    system = StateSpace(A, B, C, np.zeros((len(C), B.shape[1])))
    result = forced_response(system, times, inputs, start, return_states=True, squeeze=False)
    return result.outputs.reshape(len(C), -1), result.states.reshape(len(A), -1)[:, -1]


def _refinement_matters(problem: StudyProblem, refinement: float) -> bool:
    """Whether a finer step has an effect: not for a force that is linear between the times."""
    knots, last = knots_of(problem.force, problem.times), problem.times[-1]
    nearest = np.abs(knots[:, None] - problem.times).min(axis=1)
    return refinement == 1 or not problem.force.derivative(2).is_zero or bool((nearest > SAME_TIME * EPS * last).any())


def _simulation_refusal(package: str, problem: StudyProblem) -> str:
    times = problem.times
    if not find_spec(package):
        return "python-control is not installed"
    if len(times) < 2:
        return "needs at least two times"
    if np.abs(times - np.linspace(0.0, times[-1], len(times))).max() > SAME_TIME * EPS * times[-1]:
        return "needs even times that begin at t = 0"
    return refusal_without_states(problem)


# --- solve_ivp and odeint (LSODA without Python between its steps)

#: scipy refuses to go below 100 eps with the relative tolerance; finer ones than these take the implicit methods minutes.
EXPLICIT, IMPLICIT = tolerances(3, 5, 7, 9, 11, 13), tolerances(3, 5, 7, 9)

#: S, force, begin, z(begin), times, options -> z at the times, shape (n, T).
Integrate = Callable[[np.ndarray, Formula, float, np.ndarray, np.ndarray, dict], np.ndarray]


def _integrated(integrate: Integrate, problem: StudyProblem, rtol: float) -> Evaluate:
    """Set up the options.

    The absolute tolerance is rtol times the size of each state (``Reduced.sizes``): one size for all coordinates, since
    errors are measured against the largest of them, and one for their derivatives. The implicit methods are given the
    Jacobian S. The solver restarts wherever the force starts, stops, changes or has an impulse, as its order demands.
    """
    equations, parts = reduced(problem), intervals_of(problem)
    options = {"rtol": rtol, "atol": rtol * equations.sizes}

    def advance(_, interval: Interval, state: np.ndarray) -> np.ndarray:
        return integrate(equations.S, interval.force, interval.begin, state, interval.stops, options)

    return lambda: stepped(problem, equations, parts, advance)


def _by_solve_ivp(name: str, jacobian: Callable[[np.ndarray], dict], S, force, begin, state, stops, options) -> np.ndarray:
    from scipy.integrate import solve_ivp

    span, given = (begin, stops[-1]), {**options, **jacobian(S)}
    answer = solve_ivp(lambda t, z: S @ z + force(t), span, state, method=name, t_eval=stops, **given)
    if answer.status != 0:
        raise Failure(answer.message)
    return answer.y


def _by_odeint(S, force, begin, state, stops, options) -> np.ndarray:
    from scipy.integrate import odeint

    times = stops if stops[0] == begin else np.concatenate([[begin], stops])
    given = {"tfirst": True, "Dfun": lambda t, z: S, "mxstep": ODEINT_STEPS, "full_output": True, **options}
    states, information = odeint(lambda t, z: S @ z + force(t), state, times, **given)
    if information["message"] != "Integration successful.":
        raise Failure(information["message"])
    return states[len(times) - len(stops) :].T


# --- IDA of SUNDIALS by scikit-sundae: variable-order BDF


@dataclass(frozen=True, eq=False)
class Descriptor:
    """E y' + F y = g, the first-order form of A_0 u + A_1 u' + ... = force, for IDA.

    The unknowns u are the coordinates, with rows of constraints their multipliers too, and of each as many derivatives as occur in the equations,
    less one. Rows of constraints stand in the equations twice differentiated (index 1), once (index 2) or as they are (index 3).
    """

    E: np.ndarray  # E, F: shapes (N, N)
    F: np.ndarray
    force: ImpulsiveSmooth  # g, N rows
    places: tuple[tuple[int, int], ...]  # unknown and order of derivative of each y, up to the order before the highest that occurs
    function: BohlFunction  # the unknowns u, coordinates first, in closed form
    index: int  # differentiation index of the equations
    count: int  # number of unknowns that are coordinates
    times: np.ndarray  # times of the problem, in s

    @property
    def algebraic(self) -> np.ndarray:
        """Which y have no derivative in the equations."""
        return ~self.E.any(axis=0)

    @property
    def tested(self) -> np.ndarray:
        """Which y are in the error test: all coordinates; with index 2 nothing else without a derivative, with index 3 no velocity either.

        So the manual of IDA advises. scikit-sundae does not offer IDASetSuppressAlg: their tolerance is large instead; with the usual one the four-bar
        linkage, the delta robot and the quadruped of the examples fail from rtol 1e-8 or 1e-10 on with index 2, and from 1e-6 on with index 3.
        """
        requested = np.array([unknown < self.count and not order for unknown, order in self.places])
        excluded = self.algebraic & (self.index > 1) | np.array([order > 0 and self.index > 2 for _, order in self.places])
        return requested | ~excluded

    @cached_property
    def motion(self) -> tuple[BohlFunction, BohlFunction]:
        """y and y' in closed form."""
        derivatives = [self.function.derivative(order) for order in range(2 + max(order for _, order in self.places))]
        rows = (np.array([derivatives[order + more].coefficients[unknown] for unknown, order in self.places]) for more in (0, 1))
        y, rate = (BohlFunction(each, self.function.blocks, self.function.start) for each in rows)
        return y, rate

    @cached_property
    def sizes(self) -> np.ndarray:
        """Sizes of the unknowns as in ``Reduced.sizes``: common to all coordinates, all derivatives, all multipliers."""
        kinds = [(unknown < self.count, order) for unknown, order in self.places]
        values, different = self.motion[0](self.times), sorted(set(kinds))
        sizes = sizes_of([values[[kind == other for other in kinds]] for kind in different], self.times)
        return np.array([sizes[different.index(kind)] for kind in kinds])


@lru_cache(maxsize=8)
def descriptor(problem: StudyProblem, index: int) -> Descriptor:
    """The equations of a problem for IDA, excluded from run times."""
    response, force = reduced(problem).response, problem.force
    coefficients, function = np.array(problem.polynomial_matrix.coefficients), response.function
    if index:
        system, order = problem.system, 3 - index
        n, k = system.size, len(system.rows)
        matrices = (system.stiffness, system.damping, system.mass)
        coefficients = np.array(with_multipliers(matrices, system.constraint_matrix, [order] * k))
        applied = system.force if problem.applied is None else system.force + problem.applied
        force = applied.mapped(np.eye(n + k, n))
        for place, row in enumerate(system.rows):
            force = force + ImpulsiveSmooth(row.right_side(order).mapped(np.eye(n + k, 1, -n - place)))
        multipliers = reaction_function(system, response, applied)
        function = function.mapped(np.eye(n + k, n)) + multipliers.mapped(np.eye(n + k, k, -n))
    size = len(coefficients[0])
    highest = [max(np.flatnonzero(coefficients[:, :, k].any(axis=1)), default=0) for k in range(size)]
    places = tuple((k, order) for order in range(len(coefficients)) for k in range(size) if order < max(highest[k], 1))
    at = {place: number for number, place in enumerate(places)}
    E, F = np.zeros((2, len(places), len(places)))
    for k in range(size):
        for order in range(highest[k] + 1):
            inside = (k, order) in at
            (F if inside else E)[:size, at[k, order] if inside else at[k, order - 1]] += coefficients[order][:, k]
    steps = [(at[k, order], at[k, order + 1]) for k, order in places if (k, order + 1) in at]
    for row, (lower, upper) in enumerate(steps, start=size):
        E[row, lower], F[row, upper] = 1.0, -1.0
    index = index or max(PolynomialMatrix([F, E]).jordan_pairs().structure.infinite_divisors, default=0)
    count = problem.system.size if problem.system is not None and problem.system.rows else size
    return Descriptor(E, F, force.mapped(np.eye(len(places), size)), places, function, index, count, problem.times)


def _by_ida(index: int, problem: StudyProblem, rtol: float) -> Evaluate:
    """Set up the solver with the Jacobian, fitting values and derivatives at 0+ and their jumps, and tolerances as errors are measured."""
    form = descriptor(problem, index)
    jumps = [jumps_of(function) for function in form.motion]
    start, parts = [function(0.0) for function in form.motion], intervals(form.force, form.times, np.eye(len(form.places)))
    coordinates = [form.places.index((unknown, 0)) for unknown in range(form.count)]
    solve = _ida(form, rtol)

    def evaluate() -> np.ndarray:
        values, blocks = start, []
        for interval in parts:
            if interval.begin > 0:
                values = [value + jump.get(interval.begin, 0.0) for value, jump in zip(values, jumps)]
            states, values = solve(interval, values)
            blocks.append(states[:, coordinates].T)
        return np.hstack(blocks)

    return evaluate


def _ida(form: Descriptor, rtol: float):
    """A function of an interval and of y, y' at its begin, with y at its times, shape (T, N), and y, y' at its end; one solver for all of them."""
    from sksundae.ida import IDA

    both, force = np.hstack([form.F, form.E]), [lambda t: 0.0]

    def residual(t, y, yp, res):
        res[:] = both @ np.concatenate((y, yp)) - force[0](t)

    def jacobian(t, y, yp, res, cj, J):
        J[:] = form.F + cj * form.E

    solver = IDA(
        residual,
        jacfn=jacobian,
        rtol=rtol,
        atol=rtol * form.sizes * np.where(form.tested, 1.0, UNTESTED),
        algebraic_idx=np.flatnonzero(form.algebraic).tolist() or None,
        max_num_steps=IDA_STEPS,
        linsolver="dense" if len(form.E) <= MOST_SMALL else "lapackdense",
    )

    def solve(interval: Interval, values: Sequence[np.ndarray]) -> tuple[np.ndarray, Sequence[np.ndarray]]:
        if interval.end == interval.begin:
            return np.repeat(values[0][None, :], len(interval.times), axis=0), values
        force[0] = interval.force
        stops = np.union1d(interval.begin, interval.stops)
        # the solver reads two times as a request for its own steps: add the middle
        output_times = stops if len(stops) > 2 else np.insert(stops, 1, stops.mean())
        answer = solver.solve(output_times, *values)
        if not answer.success:
            raise Failure(answer.message)
        return answer.y[np.searchsorted(output_times, interval.times)], [answer.y[-1], answer.yp[-1]]

    return solve


def _has_rows(problem: StudyProblem) -> bool:
    return problem.system is not None and bool(problem.system.rows)


def _ida_refusal(index: int, problem: StudyProblem) -> str:
    weaker = [row for row in problem.system.rows if row.order > 3 - index] if index else []
    if weaker:
        row, level = weaker[0], LEVELS[3 - index]
        return f"needs rows at {level} level; {row.name} is at {row.level} level, which does not determine its {level}"
    return "" if find_spec("sksundae") else "scikit-sundae is not installed"


# --- motions with events: solve_ivp with events, phase by phase, which gets the phases in the coordinates of their Jordan pairs and the laws
# of the switches, so that it differs from the closed form only in how it steps and locates events


class _SteppedFlow(PhaseFlow):
    """The flow of one phase by an integrator, which locates the zeros of guards as its events."""

    def __init__(self, flow: PhaseFlow, method: str, rtol: float, pieces: list):
        self.__dict__.update(flow.__dict__)
        self.method, self.rtol, self.pieces = method, rtol, pieces

    def first_crossing(self, y, size, order, sign, horizon) -> Crossing | None:
        """The first event within the horizon; guards that vanish at the begin are divided by their zero."""
        from scipy.integrate import solve_ivp

        J, rows, values = self.J, self.rows, self.values
        watched = np.flatnonzero(sign > 0)

        def event(guard):
            def value(t, z):
                return (rows[guard] @ z - values[guard]) / t ** int(order[guard]) if t > 0 or not order[guard] else 1.0

            value.terminal, value.direction = True, -1.0
            return value

        atol = self.rtol * max(float(np.abs(y).max(initial=0.0)), np.finfo(float).tiny)
        stepped = solve_ivp(
            lambda t, z: J @ z,
            (0.0, horizon),
            y,
            self.method,
            events=[event(guard) for guard in watched],
            dense_output=True,
            rtol=self.rtol,
            atol=atol,
        )
        if stepped.status < 0:
            raise Failure(stepped.message)
        self.pieces.append(stepped.sol)
        if stepped.status == 0:
            return None
        hit = [number for number, times in enumerate(stepped.t_events) if len(times)]
        return Crossing(float(stepped.t[-1]), stepped.y[:, -1], watched[hit])

    def states(self, y: np.ndarray, time: float) -> np.ndarray:
        return self.pieces[-1](time)


class _SteppedSequence(PhaseSequence):
    """A sequence of phases by an integrator."""

    def __init__(self, known: PhaseSequence, method: str, rtol: float):
        super().__init__(known.machine, known.source, known.end, MOST_EVENTS)
        self.pieces: list = []
        self._method, self._known = (method, rtol), known

    def phase(self, key) -> Phase:
        if key not in self.phases:
            phase = copy(self._known.phase(key))
            phase.flow = _SteppedFlow(phase.flow, *self._method, self.pieces)
            self.phases[key] = phase
        return self.phases[key]

    def values(self, times: np.ndarray) -> np.ndarray:
        """x at the times, shape (n, T)."""
        begins = np.array([segment.time for segment in self.segments])
        places = np.searchsorted(begins, times, side="right") - 1
        result = np.empty((self.machine.system.size, len(times)))
        for place in np.unique(places):
            chosen, segment = places == place, self.segments[place]
            result[:, chosen] = segment.phase.C @ self.pieces[place](times[chosen] - segment.time)
        return result


@lru_cache(maxsize=8)
def _known_sequence(problem: SwitchedProblem) -> PhaseSequence:
    """The phases of the closed form, which no run time of an integrator includes."""
    return problem.solve().solution.sequence


def by_events(method: str, problem: SwitchedProblem, rtol: float) -> Evaluate:
    """Evaluate by integration from event to event."""
    known, (x, v) = _known_sequence(problem), problem.initial

    def evaluate() -> np.ndarray:
        sequence = _SteppedSequence(known, method, rtol)
        sequence.run(tuple(switch.start(x, v) for switch in known.machine.switches), x, v, problem.penetration)
        return sequence.values(problem.times)

    return evaluate


# --- motions with events: Moreau's time stepping, which takes all impacts of a step at its end (Acary and Brogliato, Numerical Methods for
# Nonsmooth Dynamical Systems, 2008, section 10.1)

#: Steps from 0 to the last time.
STEP_COUNTS = (1_000, 10_000, 100_000)


def _moreau_refusal(problem: SwitchedProblem) -> str:
    """The reason why there are no steps by impulses alone; else empty."""
    machine = problem.machine
    frictionless = [switch for switch in machine.switches if switch.contact is not None and len(switch.states) == 2]
    if len(frictionless) < len(machine.switches) or any(
        len(switch.states[switch.contact.closed].rows) > 1 for switch in frictionless
    ):
        return "written for rigid contacts that slide without friction only"
    system = machine.system
    if any(row.order or row.value or row.signal is not None for row in system.rows):
        return "written for constraint rows that are zero at position level"
    return "" if np.linalg.matrix_rank(system.mass) == system.size else "needs a regular mass matrix"


def _moreau(problem: SwitchedProblem, count: float) -> Evaluate:
    """Set up the inverse masses; evaluate with steps of one length: x_m = x + h v / 2, impulses at contacts whose gap at x_m is closed."""
    from scipy.linalg import null_space

    system, contacts = problem.machine.system, [switch.contact for switch in problem.machine.switches]
    V = null_space(system.constraint_matrix) if system.rows else np.eye(system.size)
    inverse = V @ np.linalg.inv(V.T @ system.mass @ V) @ V.T
    A, gaps = np.array([one.row for one in contacts]), np.array([one.gap for one in contacts])
    W, e, end = A @ inverse @ A.T, np.array([one.restitution for one in contacts]), float(problem.times[-1])
    K, C, h = system.stiffness, system.damping, end / count
    applied = system._applied(problem.applied).smooth

    def evaluate() -> np.ndarray:
        grid = np.linspace(0.0, end, int(count) + 1)
        forces, (x, v) = applied(grid[:-1] + h / 2), problem.initial
        values = np.empty((len(x), len(grid)))
        for k in range(int(count)):
            values[:, k] = x
            middle = x + h / 2 * v
            following = v + h * inverse @ (forces[:, k] - K @ middle - C @ v)
            closed = np.flatnonzero(A @ middle + gaps <= 0)
            if len(closed):
                p = complementary(W[np.ix_(closed, closed)], A[closed] @ following + e[closed] * (A[closed] @ v))
                following = following + inverse @ (A[closed].T @ p)
            x, v = middle + h / 2 * following, following
        values[:, -1] = x
        return np.array([np.interp(problem.times, grid, row) for row in values])

    return evaluate


# --- the table

#: The default first. Eqs. (73)-(76) of Moysis et al. are those of Apostol and Kolodner for free motion without damping.
OURS = (
    ComparedMethod("closed form", lambda problem, _: _evaluation(problem.solve, problem.times), is_ours=True),
    ComparedMethod("closed form, assembled matrices", _assembled, concerns=_has_elements, is_ours=True),
    ComparedMethod(
        "closed form of A(s)",
        lambda problem, _: _evaluation(problem.solve_equations, problem.times),
        concerns=lambda problem: problem.respond is not None,
        is_ours=True,
    ),
    ComparedMethod("closed form, Eqs. (73)-(76)", _apostol_kolodner, concerns=_is_free_and_undamped, is_ours=True),
    ComparedMethod(f"exact arithmetic, {DIGITS} digits", _exact, is_ours=True),
)

STEPS = ComparedMethod("expm, steps", _by_steps, refusal=refusal_without_states)
EACH = ComparedMethod("expm, each time by itself", _by_single_exponentials, refusal=_single_exponentials_refusal)

SIMULATIONS = tuple(
    ComparedMethod(
        name,
        partial(_simulated, simulate),
        (MethodSetting("", 1), *(MethodSetting(f"step / {refinement}", refinement) for refinement in (4, 16, 64))),
        partial(_simulation_refusal, package),
        matters=_refinement_matters,
        library=library,
    )
    for name, simulate, package, library in (
        ("scipy.signal.lsim", _lsim, "scipy", "scipy.signal"),
        ("control.forced_response", _forced_response, "control", "control"),
    )
)

INTEGRATORS = tuple(
    ComparedMethod(name, partial(_integrated, integrate), settings, refusal_without_states, library="scipy.integrate")
    for name, integrate, settings in (
        ("solve_ivp DOP853", partial(_by_solve_ivp, "DOP853", lambda S: {}), EXPLICIT),
        ("solve_ivp LSODA", partial(_by_solve_ivp, "LSODA", lambda S: {"jac": lambda t, z: S}), EXPLICIT),
        ("odeint", _by_odeint, EXPLICIT),
        ("solve_ivp Radau", partial(_by_solve_ivp, "Radau", lambda S: {"jac": S}), IMPLICIT),
        ("solve_ivp BDF", partial(_by_solve_ivp, "BDF", lambda S: {"jac": S}), IMPLICIT),
    )
)

#: By index of the equations; without rows there is one form, E possibly singular.
IDA_FORMS = tuple(
    ComparedMethod(
        f"IDA, index {index}" if index else "IDA",
        partial(_by_ida, index),
        tolerances(4, 6, 8, 10, 12),
        partial(_ida_refusal, index),
        concerns=_has_rows if index else lambda problem: not _has_rows(problem),
        library="sksundae.ida",
    )
    for index in (1, 2, 3, 0)
)

METHODS: tuple[ComparedMethod, ...] = (*OURS, STEPS, EACH, *SIMULATIONS, *INTEGRATORS, *IDA_FORMS)

#: Of motions with events.
SWITCHED_METHODS = (
    OURS[0],
    *(
        ComparedMethod(f"solve_ivp {name} with events", partial(by_events, name), tolerances(*digits), library="scipy.integrate")
        for name, digits in (("DOP853", (4, 6, 8, 10, 12)), ("RK45", (4, 6, 8, 10)))
    ),
    ComparedMethod(
        "Moreau's time stepping",
        _moreau,
        tuple(MethodSetting(f"{count:,} steps", float(count)) for count in STEP_COUNTS),
        refusal=_moreau_refusal,
    ),
)
