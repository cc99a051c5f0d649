"""Motions that are measured: each with its problem, its reference, the methods that a user would take instead, and the ratios that are wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy.linalg
import scipy.signal

import mbconstrained as mb
from tests.benchmarks.speed.models import (
    PAIRS,
    SLOWEST,
    STARTS,
    Chain,
    Equations,
    chain,
    even_times,
    example_equations,
    example_system,
    forty_periods,
    reduced_chain,
    stack_equations,
    stack_model,
    stack_start,
    with_oscillator,
)
from tests.benchmarks.speed.references import by_balls, by_taylor, record_by_taylor

Evaluate = Callable[[np.ndarray], np.ndarray]

#: Of the harmonic force, within the chain's band, rad/s.
ANGULAR_FREQUENCY = 0.375

#: How many samples a record has.
SAMPLES = 10_000

#: Columns that a propagator takes forward at once, where it is used by blocks.
COLUMNS = 32

#: Periods of the stiff stack, stiffness ratio and dampers of its second version (N s/m).
PERIODS, RATIO, STACK_DAMPING = 1000, 1e12, 1e-4


@dataclass(frozen=True)
class Problem:
    """One question, as we are asked and as peers are.

    Attributes:
        solve: model and solution by the public names of the package, to what evaluates it.
        equations: reduced by hand, float64.
        times: even ones from 0 on, s.
        truth: gives x at the times, shape (N, T).
        angular_frequency: of a harmonic force, or None.
        record: the force at the times, or None.
    """

    solve: Callable[[], Evaluate]
    equations: Equations
    times: np.ndarray
    truth: Callable[[], np.ndarray]
    angular_frequency: float | None = None
    record: np.ndarray | None = None

    @property
    def is_free(self) -> bool:
        """Whether no force acts."""
        return self.angular_frequency is None and self.record is None

    @property
    def augmented(self) -> Equations:
        """With an oscillator for a harmonic force."""
        return self.equations if self.angular_frequency is None else with_oscillator(self.equations, self.angular_frequency)


@dataclass(frozen=True)
class Motion:
    """A row of the tables.

    Attributes:
        name: in words.
        states: of the reduced equations.
        make: the problem.
        one_run, further: at most so many times lsim's time is wanted, or the fastest peer's where lsim is not as right; or None.
        seconds: at most this time is wanted for one run and for a further evaluation, where no peer is right; or None.
        is_integrated: whether solve_ivp is tried, which takes seconds or hours for the others.
    """

    name: str
    states: int
    make: Callable[[], Problem]
    one_run: float | None = None
    further: float | None = None
    seconds: tuple[float, float] | None = None
    is_integrated: bool = False


def chain_system(given: Chain) -> mb.MechanicalSystem:
    """The chain as the package takes it."""
    damping = given.damping if given.damping.any() else None
    constraints = [mb.Constraint(given.rows)] if len(given.rows) else []
    return mb.MechanicalSystem(given.mass, damping, given.stiffness, constraints)


def example(name: str) -> Problem:
    """Examples 5.1 and 5.2 of Moysis et al."""
    times, exact = even_times(50.0), example_equations(name)
    return Problem(
        lambda: example_system(name).solve(STARTS[name]),
        as_floats(exact),
        times,
        lambda: by_balls(exact, times),
    )


def as_floats(equations: Equations) -> Equations:
    """Rounded once."""
    return Equations(*(np.array(array, dtype=float) for array in (equations.S, equations.E, equations.start, equations.b)))


def free_chain(count: int, damped: bool = True) -> Problem:
    """From its shape at rest."""
    given, times = chain(count, damped, damped_joints=damped), even_times(forty_periods(count))
    return Problem(
        lambda: chain_system(given).solve(given.start),
        reduced_chain(given),
        times,
        lambda: by_taylor(reduced_chain(given, np.longdouble), times),
    )


def harmonic_chain(count: int) -> Problem:
    """From rest under a harmonic force on the mass in the middle."""
    given, times, at = chain(count, damped_joints=False), even_times(forty_periods(count)), count // 2

    def solve() -> Evaluate:
        force = mb.harmonic(np.eye(given.size)[at], angular_frequency=ANGULAR_FREQUENCY)
        return chain_system(given).solve(force=force)

    def truth() -> np.ndarray:
        exact = at_rest(reduced_chain(given, np.longdouble, pushed=at))
        return by_taylor(with_oscillator(exact, np.longdouble(ANGULAR_FREQUENCY)), times)

    return Problem(solve, at_rest(reduced_chain(given, pushed=at)), times, truth, ANGULAR_FREQUENCY)


def recorded_chain(count: int) -> Problem:
    """From rest under a record of that force, linear between its samples, at all of which x is asked."""
    given, times, at = chain(count, damped_joints=False), even_times(forty_periods(count), SAMPLES), count // 2
    record = np.random.default_rng(4).standard_normal(SAMPLES)
    record[[0, -1]] = 0.0

    def solve() -> Evaluate:
        values = np.zeros((given.size, SAMPLES))
        values[at] = record
        return chain_system(given).solve(force=mb.sampled(times, values))

    def truth() -> np.ndarray:
        return record_by_taylor(at_rest(reduced_chain(given, np.longdouble, pushed=at)), times, record)

    return Problem(solve, at_rest(reduced_chain(given, pushed=at)), times, truth, record=record)


def at_rest(equations: Equations) -> Equations:
    """From zero."""
    return Equations(equations.S, equations.E, equations.start * 0, equations.b)


def stack(damping: float) -> Problem:
    """A thousand periods of the slowest oscillation."""
    times = even_times(PERIODS * 2 * np.pi / SLOWEST)
    names = [f"mass {at + 1}" for at in range(2 * PAIRS)]
    start = dict(zip(names, stack_start().tolist()))
    exact = stack_equations(RATIO, damping, exactly=True)

    def solve() -> Evaluate:
        return stack_model(RATIO, damping).assemble().solve(start)

    return Problem(solve, stack_equations(RATIO, damping, exactly=False), times, lambda: by_balls(exact, times))


@dataclass(frozen=True)
class Method:
    """One way to the answer from reduced equations.

    Attributes:
        name: as it is called in the tables.
        prepare: the set-up, from a problem to what evaluates it.
        suits: whether it can be tried on a problem.
        keeps: whether the set-up is worth keeping: a further evaluation at other times does without it.
    """

    name: str
    prepare: Callable[[Problem], Evaluate]
    suits: Callable[[Problem], bool] = lambda problem: problem.record is None
    keeps: bool = False


def lsim(problem: Problem) -> Evaluate:
    """scipy.signal.lsim; a record is one input, linear between its samples."""
    equations = problem.equations
    system = (equations.S, equations.b[:, None], equations.E, np.zeros((len(equations.E), 1)))

    def evaluate(times):
        inputs = None if problem.record is None else problem.record
        return scipy.signal.lsim(system, inputs, times, equations.start)[1].reshape(len(times), -1).T

    return evaluate


def steps(columns: int) -> Callable[[Problem], Evaluate]:
    """Powers of e^{S dt}, applied to so many columns at once."""

    def prepare(problem: Problem) -> Evaluate:
        equations = problem.augmented

        def evaluate(times):
            power, states = flushed(scipy.linalg.expm(equations.S * times[1])), equations.start[:, None]
            while states.shape[1] < min(columns, len(times)):
                states = np.hstack([states, power @ states])
                power = flushed(power @ power)
            blocks = [states]
            for _ in range(1, -(-len(times) // states.shape[1])):
                blocks.append(power @ blocks[-1])
            return equations.E @ np.hstack(blocks)[:, : len(times)]

        return evaluate

    return prepare


def flushed(matrix: np.ndarray) -> np.ndarray:
    """Zero for denormal numbers, which make products slow and have no correct digit."""
    return np.where(np.abs(matrix) < np.finfo(float).tiny, 0.0, matrix)


def eigenvectors(problem: Problem) -> Evaluate:
    """The plain closed form: scipy.linalg.eig, and a sum over all pairs."""
    equations = problem.augmented
    values, vectors = scipy.linalg.eig(equations.S)
    coefficients = (equations.E @ vectors) * scipy.linalg.solve(vectors, equations.start.astype(complex))
    return lambda times: (coefficients @ np.exp(np.outer(values, times))).real


def modes(problem: Problem) -> Evaluate:
    """What a careful user writes without damping: scipy.linalg.eigh(K, M) and cosines."""
    equations = problem.equations
    n = len(equations.mass)
    squares, vectors = scipy.linalg.eigh(equations.stiffness, equations.mass)
    coefficients = (equations.E[:, :n] @ vectors) * (vectors.T @ (equations.mass @ equations.start[:n]))
    frequencies = np.sqrt(np.maximum(squares, 0.0))
    return lambda times: coefficients @ np.cos(np.outer(frequencies, times))


def integrated(tolerance: float) -> Callable[[Problem], Evaluate]:
    """solve_ivp by DOP853 with a sparse matrix; absolute tolerance 1e-3 of the relative one."""

    def prepare(problem: Problem) -> Evaluate:
        from scipy.integrate import solve_ivp
        from scipy.sparse import csr_array

        equations = problem.augmented
        S = csr_array(equations.S)

        def evaluate(times):
            options = {"method": "DOP853", "t_eval": times, "rtol": tolerance, "atol": 1e-3 * tolerance}
            return equations.E @ solve_ivp(lambda _, z: S @ z, (0.0, times[-1]), equations.start, **options).y

        return evaluate

    return prepare


#: In the order in which they take their turns.
PEERS = (
    Method("lsim", lsim, lambda problem: problem.angular_frequency is None),
    Method("expm blocks", steps(COLUMNS)),
    Method("expm doubling", steps(1 << 20)),
    Method("eigh modes", modes, lambda problem: problem.equations.mass is not None and problem.is_free, keeps=True),
    Method("eig pairs", eigenvectors, keeps=True),
)

INTEGRATORS = (Method("DOP853 1e-12", integrated(1e-12)),)

#: By ascending size.
MOTIONS = (
    Motion("two masses, published example 5.1", 6, partial(example, "5.1"), 0.4, 0.06),
    Motion("massless joints, published example 5.2", 3, partial(example, "5.2"), 0.4, 0.06),
    Motion("damped chain, 10 masses", 20, partial(free_chain, 10), 1.0, 0.15),
    Motion("stack, stiffness ratio 1e12, undamped", 40, partial(stack, 0.0), seconds=(0.05, 0.002)),
    Motion("stack, stiffness ratio 1e12, damped", 40, partial(stack, STACK_DAMPING), seconds=(0.05, 0.002)),
    Motion("damped chain, 100 masses", 205, partial(free_chain, 100), 0.9, 0.1),
    Motion("harmonic force, 100 masses", 200, partial(harmonic_chain, 100), is_integrated=True),
    Motion(f"record of {SAMPLES} points, 100 masses", 200, partial(recorded_chain, 100), 0.4, 0.1),
    Motion("undamped chain, 500 masses", 1000, partial(free_chain, 500, damped=False), 1.2, 1.0),
    Motion("damped chain, 500 masses", 1025, partial(free_chain, 500), 0.9, 0.1),
)
