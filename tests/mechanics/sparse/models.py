"""Sparse models for the tests: chains with ties and massless joints, rings, membranes, random ones."""

import numpy as np
import scipy.sparse as sp

import mbconstrained as mb


def line(n, ends=(1.0, 1.0)):
    """Stiffness of unit springs between n neighbours, and to walls at both ends with these stiffnesses."""
    K = sp.lil_array(sp.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1]))
    K[0, 0], K[n - 1, n - 1] = 1 + ends[0], 1 + ends[1]
    return sp.csc_array(K)


def ring(n):
    """Stiffness of a closed chain."""
    K = sp.lil_array(line(n))
    K[0, n - 1] = K[n - 1, 0] = -1.0
    return sp.csc_array(K)


def membrane(n):
    """Stiffness of an n x n square of unit springs, held at its rim."""
    return sp.csc_array(sp.kron(line(n), sp.eye_array(n)) + sp.kron(sp.eye_array(n), line(n)))


def tied_chain(n, damped=False, walls=True):
    """M, C, K and tie rows of n masses: every tenth is doubled and tied, beside every tenth is a massless joint."""
    extra = n // 10
    size = n + 2 * extra
    springs = {"left": [], "right": [], "k": [], "c": []}

    def spring(i, j, k, c):
        for name, value in zip(springs, (i, j, k, c)):
            springs[name].append(value)

    for i in range(n - 1):
        left = n + i // 10 if i % 10 == 5 and i // 10 < extra else i
        if i % 10 == 2 and i // 10 < extra:
            joint = n + extra + i // 10
            spring(left, joint, 2.0, 0.02 * (i // 10 % 2 == 0))
            spring(joint, i + 1, 2.0, 0.0)
        else:
            spring(left, i + 1, 1.0, 0.01 * (i % 7 == 0))
    left, right = np.array(springs["left"]), np.array(springs["right"])
    count = len(left)
    incidence = sp.csr_array(
        (np.repeat([1.0, -1.0], count), (np.tile(np.arange(count), 2), np.concatenate([left, right]))), shape=(count, size)
    )
    K = incidence.T @ sp.diags_array(np.array(springs["k"])) @ incidence
    C = incidence.T @ sp.diags_array(np.array(springs["c"])) @ incidence
    if walls:
        K = K + sp.diags_array(np.isin(np.arange(size), [0, n - 1]).astype(float))
    mass = np.zeros(size)
    mass[:n] = 1 + 0.1 * np.sin(np.arange(n))
    rows = ties(5 + 10 * np.arange(extra), n + np.arange(extra), size)
    return sp.csc_array(sp.diags_array(mass)), sp.csc_array(C) if damped else None, sp.csc_array(K), rows


def ties(one, other, size):
    """Rows that hold pairs of coordinates together."""
    count = len(one)
    place = np.tile(np.arange(count), 2)
    return sp.csr_array((np.repeat([1.0, -1.0], count), (place, np.concatenate([one, other]))), shape=(count, size))


def start(M, K, rows, seed=0):
    """Random values that fit: ties obeyed, massless joints where the springs hold them."""
    n = M.shape[0] - 2 * rows.shape[0]
    random = np.random.default_rng(seed)
    values = np.zeros((2, M.shape[0]))
    values[:, :n] = random.standard_normal((2, n))
    values[:, n : n + rows.shape[0]] = values[:, 5 : 5 + 10 * rows.shape[0] : 10]
    joints, others = np.arange(n + rows.shape[0], M.shape[0]), np.arange(n + rows.shape[0])
    if len(joints):
        K = K.toarray()
        values[:, joints] = -np.linalg.solve(K[np.ix_(joints, joints)], K[np.ix_(joints, others)] @ values[:, others].T).T
    return values


def dense(M, C, K, rows=None):
    """The same system as arrays."""
    held = [] if rows is None or not rows.shape[0] else [mb.Constraint(rows.toarray())]
    return mb.MechanicalSystem(M.toarray(), None if C is None else C.toarray(), K.toarray(), held)


def random_tied(random, n, rows):
    """Masses, some of them zero, a connected frame of random springs, and sparse rows, with the same as arrays."""
    left, right = np.arange(n - 1), np.arange(1, n)
    more = random.integers(0, n, (2, n // 2))
    left, right = np.concatenate([left, more[0]]), np.concatenate([right, more[1]])
    kept = left != right
    left, right = left[kept], right[kept]
    incidence = sp.csr_array(
        (np.repeat([1.0, -1.0], len(left)), (np.tile(np.arange(len(left)), 2), np.concatenate([left, right]))), shape=(len(left), n)
    )
    K = sp.csc_array(incidence.T @ sp.diags_array(random.uniform(0.5, 2.0, len(left))) @ incidence + 0.1 * sp.eye_array(n))
    mass = np.where(random.random(n) < 0.3, 0.0, random.uniform(0.5, 2.0, n))
    A = np.zeros((rows, n))
    for row in A:
        places = random.choice(n, size=min(n, 3), replace=False)
        row[places] = random.integers(-2, 3, len(places))
    return sp.csc_array(sp.diags_array(mass)), K, sp.csr_array(A)
