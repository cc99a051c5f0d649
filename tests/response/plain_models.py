"""Models of 30 masses and more whose structure is plain: chains, trees and grids with ties, massless joints and dampers."""

import numpy as np

import mbconstrained as mb
from mbconstrained.response.response import Response
from tests.linalg.few_couplings import assembled


def edges(kind: str, size: int, random) -> list[tuple[int, int]]:
    """Which nodes are connected; -1 is the ground."""
    if kind == "chain":
        return [(node - 1, node) for node in range(size)]
    if kind == "tree":
        return [(int(random.integers(-1, node)) if node else -1, node) for node in range(size)]
    width = int(size**0.5)
    across = [(node - 1, node) for node in range(size) if node % width]
    return [(-1, 0), *across, *((node - width, node) for node in range(width, size))]


def plain_system(
    kind: str, seed: int = 0, size: int = 36, static: int = 0, damped: int = 0, ties: int = 0, damping: str = "none", values=0.0
) -> mb.MechanicalSystem:
    """Masses from 0.5 to 2 kg and springs from 0.5 to 2 N/m on a graph.

    Args:
        static, damped: how many nodes have neither mass nor damper, or a damper to the ground and no mass.
        ties: how many pairs of masses are tied, x_a = ratio x_b + value.
        damping: "none", "proportional", or "some" (a damper along each fourth link of masses).
    """
    random = np.random.default_rng(seed)
    order = random.permutation(size)
    dampers = order[static : static + damped]
    links = edges(kind, size, random)
    masses = random.uniform(0.5, 2.0, size)
    masses[order[: static + damped]] = 0.0
    K = assembled(links, random.uniform(0.5, 2.0, len(links)), size) + np.diag(random.uniform(0.0, 0.2, size))
    C = np.zeros((size, size))
    C[dampers, dampers] = random.uniform(0.5, 2.0, damped)
    if damping == "proportional":
        C += 0.05 * K + 0.02 * np.diag(masses)
    elif damping == "some":
        heavy = [link for link in links if masses[link[1]] and (link[0] < 0 or masses[link[0]])][::4]
        C += assembled(heavy, random.uniform(0.01, 0.5, len(heavy)), size)
    tied = order[static + damped : static + damped + 2 * ties].reshape(-1, 2)
    rows = np.zeros((ties, size))
    rows[range(ties), tied[:, 0]], rows[range(ties), tied[:, 1]] = 1.0, -random.uniform(0.5, 2.0, ties)
    constraints = [mb.Constraint(row, level="position", value=values) for row in rows]
    return mb.MechanicalSystem(np.diag(masses), C, K, constraints)


def fitting_start(system: mb.MechanicalSystem, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Random displacements and velocities that obey the ties."""
    x, v = np.random.default_rng(seed).normal(size=(2, system.size))
    rows = system.constraint_matrix
    if len(rows):
        values = np.array([row.value for row in system.rows])
        x, v = x - np.linalg.pinv(rows) @ (rows @ x - values), v - np.linalg.pinv(rows) @ (rows @ v)
    return x, v


def general(x: Response) -> Response:
    """The answer to the same problem through the pencil of A(s)."""
    return Response._by_pairs(x.polynomial_matrix.jordan_pairs(), x.initial, x.force)


def difference(found, expected) -> float:
    """The largest difference, relative to the largest value."""
    return float(np.abs(found - expected).max() / np.abs(expected).max())
