"""What is measured: each workload with its problem, its reference and the ratios that are wanted."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

import mbconstrained as mb
from mbconstrained.response.choose import Evaluations
from tests.benchmarks.speed.examples import example_equations, example_system
from tests.benchmarks.speed.models import Chain, chain, even_times, forty_periods
from tests.benchmarks.speed.reductions import Equations, reduced_chain, with_oscillator
from tests.benchmarks.speed.references import by_balls, by_taylor, record_by_taylor
from tests.benchmarks.speed.stacks import PAIRS, SLOWEST, stack_equations, stack_model, stack_start

Evaluate = Callable[[np.ndarray], np.ndarray]

#: Of the harmonic force, within the chain's band, rad/s.
ANGULAR_FREQUENCY = 0.375

#: How many samples a record has.
SAMPLES = 10_000

#: Periods of the stiff stack, stiffness ratio and dampers of its second version (N s/m).
PERIODS, RATIO, STACK_DAMPING = 1000, 1e12, 1e-4


@dataclass(frozen=True)
class Problem:
    """One question, as we are asked and as peers are.

    Attributes:
        solve: model and solution by the public names of the package, for one or many evaluations, to what evaluates it.
        equations: reduced by hand, float64.
        times: even ones from 0 on, s.
        truth: gives x at the times, shape (N, T).
        angular_frequency: of a harmonic force, or None.
        record: the force at the times, or None.
        is_integrated: whether solve_ivp is tried, which takes seconds or hours for the others.
    """

    solve: Callable[[Evaluations], Evaluate]
    equations: Equations
    times: np.ndarray
    truth: Callable[[], np.ndarray]
    angular_frequency: float | None = None
    record: np.ndarray | None = None
    is_integrated: bool = False

    @property
    def is_free(self) -> bool:
        """Whether no force acts."""
        return self.angular_frequency is None and self.record is None

    @property
    def augmented(self) -> Equations:
        """With an oscillator for a harmonic force."""
        return self.equations if self.angular_frequency is None else with_oscillator(self.equations, self.angular_frequency)


@dataclass(frozen=True)
class Target:
    """What is wanted.

    Attributes:
        one_run, further: at most so many times the fastest peer's time, or None.
        error: at most this one.
        beside: beginning of the names of the peers that are meant, where not all are.
    """

    one_run: float | None = None
    further: float | None = None
    error: float | None = None
    beside: str = ""


@dataclass(frozen=True)
class Workload:
    """A row of the report.

    Attributes:
        key: W1, W2, ...
        name: in words.
        coordinates, states: how many the answer has, and how many the reduced equations have.
        make: the problem.
        family: workloads of one kind and several sizes, so that what was slow is not tried when it is larger; its name if none.
    """

    key: str
    name: str
    coordinates: int
    states: int
    make: Callable[[], Problem]
    target: Target = Target()
    family: str = ""


def chain_system(given: Chain) -> mb.MechanicalSystem:
    """The chain as the package takes it."""
    damping = given.damping if given.damping.any() else None
    constraints = [mb.Constraint(given.rows)] if len(given.rows) else []
    return mb.MechanicalSystem(given.mass, damping, given.stiffness, constraints)


def only(motion: mb.Motion, chosen) -> Evaluate:
    """Some coordinates of a motion."""
    rows = np.eye(len(motion.names))[chosen]
    return lambda times: motion.function.mapped(rows)(times)


def example(name: str) -> Problem:
    """W1."""
    from tests.benchmarks.speed.examples import STARTS

    times, exact = even_times(50.0), example_equations(name)
    return Problem(
        lambda evaluations: example_system(name).solve(STARTS[name], evaluations=evaluations),
        as_floats(exact),
        times,
        lambda: by_balls(exact, times),
        is_integrated=True,
    )


def as_floats(equations: Equations) -> Equations:
    """Rounded once."""
    return Equations(*(np.array(array, dtype=float) for array in (equations.S, equations.E, equations.start, equations.b)))


def free_chain(count: int, damped: bool = True, chosen: tuple[int, ...] | None = None) -> Problem:
    """W2: from its shape at rest."""
    given, times = chain(count, damped, damped_joints=damped), even_times(forty_periods(count))
    equations = reduced_chain(given)

    def solve(evaluations: Evaluations) -> Evaluate:
        motion = chain_system(given).solve(given.start, evaluations=evaluations)
        return motion if chosen is None else only(motion, list(chosen))

    def truth() -> np.ndarray:
        found = _free_truth(count, damped)
        return found if chosen is None else found[list(chosen)]

    return Problem(solve, equations if chosen is None else equations.rows(list(chosen)), times, truth)


@cache
def _free_truth(count: int, damped: bool) -> np.ndarray:
    given = chain(count, damped, damped_joints=damped)
    return by_taylor(reduced_chain(given, np.longdouble), even_times(forty_periods(count)))


def harmonic_chain(count: int) -> Problem:
    """W4: from rest under a harmonic force on the mass in the middle."""
    given, times, at = chain(count, damped_joints=False), even_times(forty_periods(count)), count // 2

    def solve(evaluations: Evaluations) -> Evaluate:
        force = mb.harmonic(np.eye(given.size)[at], angular_frequency=ANGULAR_FREQUENCY)
        return chain_system(given).solve(force=force, evaluations=evaluations)

    def truth() -> np.ndarray:
        exact = at_rest(reduced_chain(given, np.longdouble, pushed=at))
        return by_taylor(with_oscillator(exact, np.longdouble(ANGULAR_FREQUENCY)), times)

    return Problem(solve, at_rest(reduced_chain(given, pushed=at)), times, truth, ANGULAR_FREQUENCY, is_integrated=True)


def recorded_chain(count: int) -> Problem:
    """W4: from rest under a record of that force, linear between its samples, at all of which x is asked."""
    given, times, at = chain(count, damped_joints=False), even_times(forty_periods(count), SAMPLES), count // 2
    record = np.random.default_rng(4).standard_normal(SAMPLES)
    record[[0, -1]] = 0.0

    def solve(evaluations: Evaluations) -> Evaluate:
        values = np.zeros((given.size, SAMPLES))
        values[at] = record
        return chain_system(given).solve(force=mb.sampled(times, values), evaluations=evaluations)

    def truth() -> np.ndarray:
        return record_by_taylor(at_rest(reduced_chain(given, np.longdouble, pushed=at)), times, record)

    return Problem(solve, at_rest(reduced_chain(given, pushed=at)), times, truth, record=record)


def at_rest(equations: Equations) -> Equations:
    """From zero."""
    return Equations(equations.S, equations.E, equations.start * 0, equations.b)


def stack(damping: float) -> Problem:
    """W6: a thousand periods of the slowest oscillation."""
    times = even_times(PERIODS * 2 * np.pi / SLOWEST)
    names = [f"mass {at + 1}" for at in range(2 * PAIRS)]
    start = dict(zip(names, stack_start().tolist()))
    exact = stack_equations(RATIO, damping, exactly=True)

    def solve(evaluations: Evaluations) -> Evaluate:
        return stack_model(RATIO, damping).assemble().solve(start, evaluations=evaluations)

    return Problem(solve, stack_equations(RATIO, damping, exactly=False), times, lambda: by_balls(exact, times))


def _chain_row(count: int, damped: bool = True, target: Target = Target()) -> Workload:
    sizes = chain(count, damped, damped_joints=damped)
    kind = "damped" if damped else "undamped"
    make = partial(free_chain, count, damped)
    return Workload("W2", f"{kind} chain, n = {count}", sizes.size, sizes.states, make, target, f"{kind} chain")


#: By ascending size, so that what takes longest comes last.
WORKLOADS = (
    Workload("W1", "example 5.1", 3, 6, partial(example, "5.1"), Target(0.5, 0.05)),
    Workload("W1", "example 5.2", 3, 3, partial(example, "5.2"), Target(0.5, 0.05)),
    Workload("W6", "stiffness 1e12, undamped", 20, 40, partial(stack, 0.0), Target(error=1e-11)),
    Workload("W6", "stiffness 1e12, damped", 20, 40, partial(stack, STACK_DAMPING)),
    _chain_row(10),
    _chain_row(100, target=Target(1.0, 0.06)),
    Workload("W4", "harmonic force, n = 100", 120, 200, partial(harmonic_chain, 100), Target(0.01, 0.001, 1e-11, "DOP853")),
    Workload("W4", f"record of {SAMPLES} points, n = 100", 120, 200, partial(recorded_chain, 100), Target(0.2, 0.06)),
    _chain_row(500, damped=False, target=Target(0.1, 0.02)),
    _chain_row(500),
    Workload(
        "W2",
        "8 coordinates of the damped chain, n = 500",
        8,
        1025,
        partial(free_chain, 500, chosen=tuple(range(30, 500, 60))),
        Target(1.0, 0.005),
        "chosen coordinates",
    ),
    _chain_row(1000, target=Target(0.4, 0.02)),
)
