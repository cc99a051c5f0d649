"""Models of few couplings that are no trees: M, C and K of springs, dampers and beam elements."""

import numpy as np


def of_pairs(pairs, seed, damping=0.05, ground=()):
    """Masses of which these pairs are coupled by springs and dampers, some on the ground."""
    random, count = np.random.default_rng(seed), 1 + max(map(max, pairs))
    C, K = np.zeros((2, count, count))
    for one, other in pairs:
        pull = np.zeros(count)
        pull[[one, other]] = 1.0, -1.0
        K += random.uniform(0.5, 2.0) * np.outer(pull, pull)
        C += damping * random.uniform(0.0, 1.0) * np.outer(pull, pull)
    K[list(ground), list(ground)] += 1.0
    return np.diag(random.uniform(0.5, 2.0, count)), C, K


def ring(count, seed=0, ground=(0,)):
    return of_pairs([(at, (at + 1) % count) for at in range(count)], seed, ground=ground)


def ladder(count, seed=0):
    """Two chains with rungs, count even."""
    pairs = [(at, at + 2) for at in range(count - 2)] + [(at, at + 1) for at in range(0, count, 2)]
    return of_pairs(pairs, seed, ground=(0, 1))


def band(count, width, seed=0):
    """Each coupled to so many neighbours on both sides."""
    return of_pairs([(at, at + far) for far in range(1, width + 1) for at in range(count - far)], seed, ground=(0,))


def uniform_ring(count, damping=()):
    """Equal masses and springs, each on the ground too; dampers to the ground of some."""
    K = 2.3 * np.eye(count) - np.roll(np.eye(count), 1, 0) - np.roll(np.eye(count), -1, 0)
    C = np.zeros((count, count))
    C[list(damping), list(damping)] = 0.1 + 0.05 * np.arange(len(damping))
    return np.eye(count), C, K


def beam(elements, seed=0, foundation=0.0):
    """Elements of unit length clamped at one end, two coordinates a node, on an elastic foundation."""
    random, count = np.random.default_rng(seed), 2 * elements + 2
    stiff = np.array([[12, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]], dtype=float)
    heavy = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
    M, C, K = np.zeros((3, count, count))
    for element in range(elements):
        own = slice(2 * element, 2 * element + 4)
        K[own, own] += random.uniform(0.5, 2.0) * stiff + foundation * heavy
        M[own, own] += random.uniform(0.5, 2.0) * heavy
        C[own, own] += 0.01 * random.uniform(0.0, 1.0) * stiff
    return M[2:, 2:], C[2:, 2:], K[2:, 2:]
