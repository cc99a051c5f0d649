"""The choice of the method: one pure function of the problem and the request, with the condition that decided in its reason."""

import re

import numpy as np
import pytest
from scipy.linalg import block_diag

import mbconstrained as mb
from mbconstrained.ground.errors import InputError
from mbconstrained.response.choose import (
    MODES,
    PAIRS,
    POWERS,
    STEPS,
    Request,
    choose,
    decomposition_cost,
)
from mbconstrained.response.problem import Problem

from .plain_models import general, plain_system

EVEN = np.linspace(0.0, 10.0, 100)
KNOTS = 0.4 * np.arange(300)


def matrix(damping: str = "none", kind: str = "chain", size: int = 36, **more) -> mb.PolynomialMatrix:
    return plain_system(kind, size=size, damping=damping, **more).polynomial_matrix()


def record(size: int) -> mb.ImpulsiveSmooth:
    values = np.zeros((size, len(KNOTS)))
    values[2] = np.random.default_rng(3).normal(size=len(KNOTS))
    return mb.sampled(KNOTS, values)


SPRING, IDENTITY, NONE = np.array([[2.0, -1.0], [-1.0, 1.0]]), np.eye(2), np.zeros((2, 2))


def small(K=SPRING, C=NONE, M=IDENTITY, force=None, initial=((1.0, -2.0), (0.5, 3.0)), **more) -> Problem:
    return Problem.checked(mb.PolynomialMatrix([K, C, M]), np.array(initial), force, **more)


PAIR_PROBLEMS = {
    "a rank tolerance is given": small(rank_tolerance=1e-9),
    "the force contains Dirac impulses": small(force=mb.impulse([1.0, 0.0]) + mb.ramp([0.0, 1.0])),
    "the force restarts at 40 times": small(force=mb.sampled(np.arange(41.0), np.outer([1.0, 0.0], np.sin(np.arange(41.0))))),
    "A(s) has degree 3": Problem.checked(mb.PolynomialMatrix([[[1.0]]] * 4)),
    "the initial values or a jump of the force do not satisfy the algebraic equations": Problem.checked(
        mb.PolynomialMatrix([[[1.0, 0.0], [1.0, -1.0]], NONE, [[1.0, 1.0], [0.0, 0.0]]]), [[1.0, 2.0], [0.0, 0.0]]
    ),
    "the stiffness spread is 1e+10": Problem.checked(
        mb.PolynomialMatrix([block_diag(SPRING, np.eye(50)), np.zeros((52, 52)), np.diag([1.0, 1e-20, *[1.0] * 50])])
    ),
    "entries of A(s) are uncertain": Problem.checked(
        mb.PolynomialMatrix([SPRING, NONE, IDENTITY], uncertainty=[1e-3 * np.ones((2, 2)), NONE, NONE])
    ),
    "masses, dampers or algebraic equations are near-singular": small(M=np.ones((2, 2))),
    "the stiffness matrix is near-singular": small(K=np.array([[1.0, -1.0], [-1.0, 1.0]])),
    "a part is one-way coupled to an unstable part": Problem.checked(
        mb.PolynomialMatrix([block_diag([[1.0, 0.0], [-1.0, -3.0]], np.eye(50)), block_diag(IDENTITY, np.zeros((50, 50)))]),
        [[1.0, 1.0, *[0.0] * 50]],
    ),
}


@pytest.mark.parametrize("condition", PAIR_PROBLEMS)
def test_the_reason_for_the_pairs_is_the_condition_that_failed(condition):
    method = choose(PAIR_PROBLEMS[condition])
    assert method.name == PAIRS and method.flow is None
    assert method.reason.startswith(f"by the Jordan pairs: {condition}")


METHODS = [
    ("none", {"size": 10}, EVEN, MODES, "by eigenvectors: 20 states are few"),
    ("none", {}, EVEN + 1.0, MODES, "by a symmetric eigenproblem: the times are not even"),
    ("some", {}, EVEN + 1.0, MODES, "by eigenvectors: the times are not even"),
    ("some", {}, EVEN, POWERS, r"by powers of e\^\(S h\): they cost about"),
    ("some", {}, None, MODES, "by eigenvectors, and at even times by powers"),
    ("some", {"size": 320, "damped": 8}, EVEN, POWERS, r"by powers of e\^\(S h\)"),
    ("some", {"size": 320, "damped": 8}, EVEN + 1.0, MODES, "by the modes of a sparse topology"),
    ("some", {"kind": "grid", "size": 121}, EVEN + 1.0, MODES, "by eigenvectors"),
]


@pytest.mark.parametrize(("damping", "model", "times", "name", "reason"), METHODS)
def test_reduced_equations_by_what_costs_least_for_the_times(damping, model, times, name, reason):
    problem = Problem.checked(matrix(damping, **model))
    method = choose(problem, Request(times=times))
    assert method.name == name
    assert re.match(reason, method.reason)


@pytest.mark.parametrize(
    ("times", "name"), [(KNOTS, STEPS), (KNOTS[:100], STEPS), (KNOTS[1:], MODES), (KNOTS + 0.1, MODES), (KNOTS[:20], MODES)]
)
def test_a_record_by_steps_at_its_own_knots(times, name):
    A = matrix("some", kind="grid")
    problem = Problem.checked(A, force=record(36))
    assert choose(problem, Request(times=times)).name == name
    mb.solve(A, force=problem.force)(times)
    assert ("decoupled" in vars(A.reduction)) == (name == MODES)  # the chosen method is the one used


def test_the_chosen_method_is_the_one_used():
    for times, name in ((EVEN, POWERS), (EVEN + 1.0, MODES)):
        A = matrix("some")
        assert choose(Problem.checked(A, np.ones((2, 36))), Request(times=times)).name == name
        mb.solve(A, np.ones((2, 36)))(times)
        assert ("decoupled" in vars(A.reduction)) == (name == MODES)


def test_choosing_is_pure():
    """The same problem and request give the same method, whatever was evaluated between."""
    A, initial = matrix("some"), np.ones((2, 36))
    before = choose(Problem.checked(A, initial), Request(times=EVEN))
    x = mb.solve(A, initial)
    x(1.0), x(EVEN), x.derivative(2)(EVEN + 0.3)
    after = choose(x.problem, Request(times=EVEN))
    assert (after.name, after.reason) == (before.name, before.reason)


def test_members_of_a_family_have_the_method_that_each_has_alone():
    A, random = matrix(size=8), np.random.default_rng(1)
    xs = mb.solve(A, random.normal(size=(5, 2, 8)))
    assert [(m.name, m.reason) for m in xs.methods] == [(x.method.name, x.method.reason) for x in xs]


def test_other_words_are_refused():
    with pytest.raises(InputError, match='evaluations: found \'often\'; expected "once" or "many"'):
        mb.solve(matrix(), evaluations="often")


def test_a_symmetric_eigenproblem_costs_less_than_a_general_one_and_a_sparse_topology_less_than_that():
    costs = [decomposition_cost(A.reduction) for A in (matrix(), matrix("some"))]
    assert costs[0] < costs[1]
    long, grid = matrix("some", size=120, damped=8), matrix("some", kind="grid", size=121)
    assert decomposition_cost(long.reduction) < decomposition_cost(grid.reduction)


# The same call gives the same bits, whatever was asked before.

IRREGULAR = np.sort(np.random.default_rng(0).uniform(0.0, 9.0, 40))
CALLS = {
    "a time": lambda m: m(0.7),
    "even times": lambda m: m(EVEN),
    "a finer grid": lambda m: m(np.linspace(0.0, 10.0, 333)),
    "the knots of the record": lambda m: m(KNOTS[:128]),
    "irregular times": lambda m: m(IRREGULAR),
    "early times": lambda m: m(np.array([0.0, 1e-9, 1e-3])),
}
SOLUTIONS = {
    "two masses": lambda: mb.solve(mb.PolynomialMatrix([SPRING, NONE, IDENTITY]), [[1.0, -2.0], [0.5, 3.0]]),
    "two masses by the Jordan pairs": lambda: general(mb.solve(mb.PolynomialMatrix([SPRING, NONE, IDENTITY]), np.ones((2, 2)))),
    "small, harmonic force": lambda: mb.solve(matrix(size=6), None, mb.harmonic(np.ones(6), angular_frequency=0.8)),
    "small, late force": lambda: mb.solve(matrix(size=6), np.ones((2, 6)), mb.step(np.ones(6)).delayed(3.0)),
    "chain of 60 masses": lambda: mb.solve(matrix(size=60), np.ones((2, 60))),
    "damped chain of 60 masses": lambda: mb.solve(matrix("some", size=60), np.ones((2, 60))),
    "damped chain of 60 masses, many evaluations": lambda: mb.solve(matrix("some", size=60), np.ones((2, 60)), evaluations="many"),
    "damped chain of 60 masses, harmonic force": lambda: mb.solve(
        matrix("some", size=60), None, mb.harmonic(np.ones(60), angular_frequency=0.8)
    ),
    "grid under a record": lambda: mb.solve(matrix("some", kind="grid"), np.ones((2, 36)), record(36)),
    "chain under a record": lambda: mb.solve(matrix(), np.ones((2, 36)), record(36)),
    "family of starts": lambda: mb.solve(matrix("some"), np.random.default_rng(2).normal(size=(4, 2, 36))),
    "family of forces": lambda: mb.solve(matrix("some"), None, [record(36), mb.step(np.ones(36))]),
}


@pytest.mark.parametrize("solution", SOLUTIONS)
def test_evaluation_has_no_memory(solution):
    """Each call alone, on a new problem, and all calls one after another in either order on one: equal bits."""
    alone = {name: call(SOLUTIONS[solution]()) for name, call in CALLS.items()}
    shared = SOLUTIONS[solution]()
    for name in (*CALLS, *reversed(CALLS)):
        shared.derivative(1)(EVEN[:50])
        assert np.array_equal(CALLS[name](shared), alone[name]), name
