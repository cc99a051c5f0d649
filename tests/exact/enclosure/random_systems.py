"""Random problems of many kinds, each with times: for the error estimate and the exact engine to be held against each other."""

import numpy as np

import mbconstrained as mb

KINDS = ("damped chain", "undamped chain", "constrained", "first order", "dense", "singular leading", "stiff", "defective")


def random_problem(seed: int) -> tuple[mb.Response, np.ndarray, str]:
    """A response, ten times, and what kind of problem it is."""
    random = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    A = _matrix(kind, random)
    initial = random.standard_normal((A.degree, A.size))
    x = mb.solve(A, initial, _force(A.size, random))
    return x, 10.0 ** random.uniform(-1, 2) * np.linspace(0.1, 1.0, 10), kind


def _matrix(kind: str, random) -> mb.PolynomialMatrix:
    n = int(random.integers(2, 8))
    if kind == "first order":
        return mb.PolynomialMatrix([random.standard_normal((n, n)) + 2 * n**0.5 * np.eye(n), np.eye(n)])
    if kind == "dense":
        return mb.PolynomialMatrix([random.standard_normal((n, n)) + 2 * n**0.5 * np.eye(n), 2 * n**0.5 * np.eye(n), np.eye(n)])
    if kind == "singular leading":
        leading = np.diag((random.random(n) < 0.6).astype(float))
        return mb.PolynomialMatrix([_chain(n, random), 0.5 * _chain(n, random), leading])
    if kind == "defective":
        zero = float(random.integers(1, 4))
        block = np.eye(n) + np.eye(n, k=1)
        return mb.PolynomialMatrix([zero**2 * np.eye(n), 2 * zero * np.eye(n), block])
    M, K = np.diag(10.0 ** random.uniform(-1, 1, n)), _chain(n, random, 6.0 if kind == "stiff" else 0.0)
    C = np.zeros((n, n)) if kind == "undamped chain" else 0.1 * _chain(n, random)
    if kind != "constrained":
        return mb.PolynomialMatrix([K, C, M])
    row = np.eye(n)[0] - np.eye(n)[1]
    system = mb.MechanicalSystem(M, C, K, [mb.Constraint(row, level=["position", "velocity", "acceleration"][random.integers(3)])])
    return system.polynomial_matrix()


def _chain(n: int, random, decades: float = 0.0) -> np.ndarray:
    """Springs between neighbours, the first to the ground."""
    ends = np.eye(n) - np.eye(n, k=-1)
    return ends.T @ np.diag(10.0 ** random.uniform(0, max(decades, 1.0), n)) @ ends


def _force(r: int, random) -> mb.ImpulsiveSmooth:
    vector = random.standard_normal(r)
    choices = (
        mb.zero(r),
        mb.step(vector),
        mb.harmonic(vector, angular_frequency=random.uniform(0.1, 5), phase=random.uniform(-3, 3)),
        mb.term(vector, power=1, rate=-random.random()),
        mb.impulse(vector),
        mb.pulse(vector, start=random.random(), duration=random.uniform(0.5, 3)),
        mb.sampled(np.linspace(0, 10, 21), random.standard_normal((r, 21))),
    )
    return choices[random.integers(len(choices))]
