"""A chain of masses between walls, large enough for the reduced equations, and its equations of first order by hand."""

import numpy as np

import mbconstrained as mb

COUNT = 30


def chain(damping: float = 0.05, count: int = COUNT) -> mb.PolynomialMatrix:
    """M x'' + C x' + K x = f with unlike masses."""
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    C = damping * np.diag(np.arange(count) % 3.0)
    return mb.PolynomialMatrix([K, C, np.diag(masses(count))])


def masses(count: int = COUNT) -> np.ndarray:
    """In kg."""
    return 1 + 0.3 * np.cos(np.arange(count))


def first_order(A: mb.PolynomialMatrix) -> np.ndarray:
    """S with (x, x')' = S (x, x')."""
    K, C, M = A.coefficients
    return np.block([[np.zeros_like(K), np.eye(len(K))], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
