"""Models of few couplings: M, C and K of springs, dampers and beam elements."""

import numpy as np


def assembled(pairs, values, count) -> np.ndarray:
    """The sum of value d d^T, d = 1 at one end and -1 at the other; -1 is the ground."""
    matrix = np.zeros((count, count))
    for (one, other), value in zip(pairs, values):
        pull = np.zeros(count)
        pull[other] = 1.0
        if one >= 0:
            pull[one] = -1.0
        matrix += value * np.outer(pull, pull)
    return matrix


def of_pairs(pairs, seed, damping=0.05, ground=()):
    """Masses of which these pairs are coupled by springs and dampers, some on the ground."""
    random, count = np.random.default_rng(seed), 1 + max(map(max, pairs))
    stiffness, dampers = random.uniform([0.5, 0.0], [2.0, 1.0], (len(pairs), 2)).T
    K, C = assembled(pairs, stiffness, count), assembled(pairs, damping * dampers, count)
    K[list(ground), list(ground)] += 1.0
    return np.diag(random.uniform(0.5, 2.0, count)), C, K


def tree(parents, stiffness, damping, mass, ground=1.0, ground_damping=0.0):
    """Coordinates 1, 2, ... each on a spring and a damper to its parent, the first coordinate to the ground."""
    pairs = [(-1, 0), *((parent, child) for child, parent in enumerate(parents, start=1))]
    C, K = (assembled(pairs, values, len(mass)) for values in ([ground_damping, *damping], [ground, *stiffness]))
    return np.diag(mass), C, K


def random_tree(seed, count, reach=None):
    """Parents, constants of springs, dampers and masses, and the source of further numbers."""
    random = np.random.default_rng(seed)
    parents = [int(random.integers(max(0, child - (reach or child)), child)) for child in range(1, count)]
    return parents, random.uniform(0.5, 2.0, (3, count)), random


def chain_between_walls(count, damping=0.0):
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    return np.eye(count), damping * K, K


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
