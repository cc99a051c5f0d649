"""A time stepping of Moreau's kind for masses with springs, stops and dry friction: one complementarity problem per step by projection."""

from dataclasses import dataclass, field

import numpy as np

import mbconstrained as mb


@dataclass
class Machine:
    """Masses with elements between them, of which both models are made."""

    masses: list
    springs: list = field(default_factory=list)  # (i, j, k, c), j None for the ground
    contacts: list = field(default_factory=list)  # (row, gap, e)
    frictions: list = field(default_factory=list)  # (row, limit)
    gravity: float = 0.0
    force: tuple = (0.0, 1.0)  # amplitude and angular frequency on the first mass

    def matrices(self):
        n = len(self.masses)
        K, C = np.zeros((n, n)), np.zeros((n, n))
        for i, j, k, c in self.springs:
            row = np.eye(n)[i] - (0 if j is None else np.eye(n)[j])
            K, C = K + k * np.outer(row, row), C + c * np.outer(row, row)
        return np.diag(self.masses), C, K

    def model(self):
        model = mb.LumpedModel()
        name = lambda i: "ground" if i is None else f"m{i}"  # noqa: E731
        for i, mass in enumerate(self.masses):
            model.mass(f"m{i}", mass)
        for i, j, k, c in self.springs:
            model.spring(name(j), name(i), stiffness=k)
            if c:
                model.damper(name(j), name(i), damping=c)
        for row, gap, e in self.contacts:
            start, end = ends(row)
            model.contact(name(start), name(end), gap=gap, restitution=e)
        for row, limit in self.frictions:
            start, end = ends(row)
            model.dry_friction(name(start), name(end), normal_force=limit, coefficient=1.0)
        if self.gravity:
            model.gravity(-self.gravity)
        return model.assemble()

    def signal(self):
        return mb.harmonic(self.force[0] * np.eye(len(self.masses))[0], angular_frequency=self.force[1])

    def solve(self, x, v, end):
        return self.model().solve(x, v, self.signal(), end=end)

    def step(self, x, v, end, count):
        """x at the end by steps of midpoints (Acary and Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008, section 10.1)."""
        M, C, K = self.matrices()
        h, weight = end / count, -self.gravity * np.diag(M)
        first = np.eye(len(M))[0] * self.force[0]
        inverse = np.linalg.inv(M + h / 2 * C + h * h / 4 * K)
        A = np.array([row for row, _, _ in self.contacts] + [row for row, _ in self.frictions]).reshape(-1, len(M))
        gaps, e = np.array([gap for _, gap, _ in self.contacts]), np.array([own for _, _, own in self.contacts])
        limits = np.array([limit for _, limit in self.frictions]) * h
        x, v, k = np.array(x, float), np.array(v, float), len(self.contacts)
        W, p = A @ inverse @ A.T, np.zeros(len(A))
        for i in range(count):
            f = weight + first * np.cos(self.force[1] * (i + 0.5) * h)
            free = v + inverse @ (h * (f - C @ v - K @ (x + h / 2 * v)))
            near = np.r_[A[:k] @ (x + h / 2 * v) + gaps <= 0, np.ones(len(limits), bool)] if len(A) else np.zeros(0, bool)
            p[~near] = 0.0
            target = np.r_[-e * np.minimum(A[:k] @ v, 0.0), np.zeros(len(limits))]
            for _ in range(400):
                old = p.copy()
                for j in np.flatnonzero(near):
                    own = p[j] - (A[j] @ free + W[j] @ p - target[j]) / W[j, j]
                    p[j] = max(own, 0.0) if j < k else min(max(own, -limits[j - k]), limits[j - k])
                if np.abs(p - old).max(initial=0.0) <= 1e-13 * np.abs(p).max(initial=1e-300):
                    break
            new = free + inverse @ (A.T @ p)
            x, v = x + h / 2 * (v + new), new
        return x


def ends(row):
    """The start and the end of a row of -1 and 1."""
    below, above = np.flatnonzero(np.array(row) < 0), np.flatnonzero(np.array(row) > 0)
    return (int(below[0]) if len(below) else None), (int(above[0]) if len(above) else None)


def random_machine(seed: int) -> tuple[Machine, np.ndarray, np.ndarray]:
    """A chain with stops and friction, and a start outside the stops."""
    r = np.random.default_rng(seed)
    n = int(r.integers(1, 5))
    eye = np.eye(n)
    machine = Machine(list(r.uniform(0.5, 3.0, n)), gravity=float(r.choice([0.0, 9.81])))
    machine.springs = [(0, None, float(r.uniform(5, 50)), float(r.uniform(0, 1)))]
    machine.springs += [(i, i - 1, float(r.uniform(5, 80)), float(r.uniform(0, 1))) for i in range(1, n)]
    rows = [eye[0], -eye[n - 1], *(eye[i] - eye[i - 1] for i in range(1, n))]
    for row in rows:
        if not machine.contacts or r.random() < 0.6:
            machine.contacts.append((row, float(r.uniform(0.05, 0.4)), float(r.choice([0.0, 0.4, 0.7]))))
    for i in range(n):
        if r.random() < 0.4:
            machine.frictions.append((eye[i], float(r.uniform(0.5, 4.0))))
    machine.force = (float(r.uniform(0, 10)), float(r.uniform(1, 8)))
    return machine, np.zeros(n), r.normal(size=n)
