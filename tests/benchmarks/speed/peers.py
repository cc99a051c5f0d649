"""What a user would take instead, given the reduced equations for nothing."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.signal

from tests.benchmarks.speed.workloads import Problem

#: x at times, shape (N, T).
Evaluate = Callable[[np.ndarray], np.ndarray]

#: Columns that a propagator takes forward at once, where it is used by blocks.
COLUMNS = 32


@dataclass(frozen=True)
class Method:
    """One way to the answer.

    Attributes:
        name: as it is called in the report.
        prepare: the set-up, from a problem to what evaluates it.
        suits: whether it can be tried on a problem.
        keeps: whether the set-up is worth keeping: a further evaluation at other times does without it.
        prepare_many: the set-up for further evaluations, where that is another one.
        once: whether it takes so long that it runs a single time.
    """

    name: str
    prepare: Callable[[Problem], Evaluate]
    suits: Callable[[Problem], bool] = lambda problem: True
    keeps: bool = False
    once: bool = False
    prepare_many: Callable[[Problem], Evaluate] | None = None


def lsim(problem: Problem) -> Evaluate:
    """scipy.signal.lsim; a record is one input, linear between its samples."""
    equations = problem.equations
    system = (equations.S, equations.b[:, None], equations.E, np.zeros((len(equations.E), 1)))

    def evaluate(times):
        inputs = None if problem.record is None else problem.record
        return scipy.signal.lsim(system, inputs, times, equations.start)[1].reshape(len(times), -1).T

    return evaluate


def steps(columns: int) -> Callable[[Problem], Evaluate]:
    """Powers of e^{S dt}: as many columns at once as there are, up to a limit; one by one for 1."""

    def prepare(problem: Problem) -> Evaluate:
        equations = problem.augmented

        def evaluate(times):
            power, states = scipy.linalg.expm(equations.S * times[1]), equations.start[:, None]
            while states.shape[1] < min(columns, len(times)):
                states = np.hstack([states, power @ states])
                power = power @ power
            blocks = [states]
            for _ in range(1, -(-len(times) // states.shape[1])):
                blocks.append(power @ blocks[-1])
            return equations.E @ np.hstack(blocks)[:, : len(times)]

        return evaluate

    return prepare


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
    Method("expm steps", steps(1), lambda problem: problem.record is None),
    Method("expm blocks", steps(COLUMNS), lambda problem: problem.record is None),
    Method("expm doubling", steps(1 << 20), lambda problem: problem.record is None),
    Method("eigh modes", modes, lambda problem: problem.equations.mass is not None and problem.is_free, keeps=True),
    Method("eig pairs", eigenvectors, lambda problem: problem.record is None, keeps=True),
    Method("DOP853 1e-12", integrated(1e-12), lambda problem: problem.is_integrated, once=True),
    Method("DOP853 3e-14", integrated(3e-14), lambda problem: problem.is_integrated, once=True),
)
