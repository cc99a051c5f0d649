"""The published models of Moysis et al., section 5, as coefficients of A(s), and the table of their trajectories."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

TABLES = json.loads(Path(__file__).with_name("moysis.json").read_text())


def table(example: str, column: str) -> np.ndarray:
    """One column of the trajectories of "ex51" or "ex52"."""
    return np.array([float(row[column]) for row in TABLES[example]])


def two_masses(level: int) -> np.ndarray:
    """Section 5.1, Eq. (84), m = 10, k = 2; the row x1 - q1 stands in A_level (0 position, 1 velocity, 2 acceleration)."""
    m, k = 10.0, 2.0
    A = np.zeros((3, 3, 3))
    A[0, :2] = [[0, 0, k], [k, 0, 0]]
    A[2, :2] = [[0, m, m], [m, m, m]]
    A[level, 2] = [1, -1, 0]
    return A


def two_masses_with_multiplier(level: int) -> np.ndarray:
    """Section 5.1 as [M s^2 + K, -row^T; row s^level, 0], with the multiplier as fourth coordinate (Eq. 77, 78)."""
    A = np.zeros((3, 4, 4))
    A[2, :3, :3] = [[10, 0, 0], [0, 10, 10], [0, 10, 10]]
    A[0, :3, :3] = np.diag([2, 0, 2])
    A[0, :3, 3] = [-1, 1, 0]
    A[level, 3, :3] += [1, -1, 0]
    return A


def massless_joints() -> np.ndarray:
    """Section 5.2, Eq. (92), m = 10, k1 = 6, k2 = 3, c1 = 8, c2 = 4."""
    k1, k2, c1, c2, m = 6.0, 3.0, 8.0, 4.0, 10.0
    return np.array(
        [
            [[k1 + k2, 0, -k2], [0, 0, 0], [-k2, 0, k2]],
            [[0, 0, 0], [0, c1 + c2, -c2], [0, -c2, c2]],
            [[0, 0, 0], [0, 0, 0], [0, 0, m]],
        ]
    )


def rigid_link() -> np.ndarray:
    """Two unit masses, a unit spring on the first, held together by a rigid link with a multiplier (position level)."""
    A = np.zeros((3, 3, 3))
    A[0] = [[1, 0, -1], [0, 0, 1], [1, -1, 0]]
    A[2] = np.diag([1, 1, 0])
    return A


def close(found, known, digits: float = 1e-12) -> bool:
    """Equal to the given relative accuracy of the largest known value."""
    found, known = np.asarray(found, float), np.asarray(known, float)
    assert found.shape == known.shape
    return bool(np.abs(found - known).max(initial=0.0) <= digits * max(np.abs(known).max(initial=0.0), 1e-300))
