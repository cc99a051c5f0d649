"""Eigenvalues of A(s) = M s^2 + C s + K with right and left vectors, and their derivatives with respect to a parameter.

A(s)^-1 = sum over i of x_i y_i^T / (s - s_i), so that y_i^T A'(s_i) x_i = 1 and ds_i/dp = - y_i^T A_p(s_i) x_i (Lancaster 1964). Of an
eigenvalue that is double with two shapes the derivatives are the eigenvalues of the matrix - Y^T A_p(s) X of its group.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from scipy.linalg import lapack
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from ...ground.tolerances import CLUSTER_SAFETY, DIVISOR_CONDITION, EPS, STIFFNESS_CONDITION, noise_of
from ...linalg.division import condition, is_symmetric
from ...linalg.rank import null_columns
from ...linalg.rounding import Noisy
from ...linalg.symmetric.mode_refinement import refined_modes
from ..polynomial_matrix import PolynomialMatrix


@dataclass(frozen=True, eq=False)
class VariedSpectrum:
    """The finite eigenvalues of A(s), conjugates included, with vectors that are normalized by A(s)^-1.

    Attributes:
        values: s, shape (m,).
        right, left: x as columns, shape (n, m), and y^T as rows, shape (m, n).
        velocity: s x, also where s = 0 and x is the motion of a free body at constant velocity.
        states, rows: vectors of the first-order equations, rows @ states = I, shape (k, m) and (m, k).
        noise: changes of the eigenvalues by rounding errors (1/s).
    """

    values: np.ndarray
    right: np.ndarray
    velocity: np.ndarray
    left: np.ndarray
    states: np.ndarray
    rows: np.ndarray
    noise: float

    def derivative_matrix(self, slope: np.ndarray) -> np.ndarray:
        """- y_i^T A_p(s_j) x_j, shape (m, m), its diagonal the derivatives of simple eigenvalues.

        Args:
            slope: A_p, the derivatives of K, C, M, shape (3, n, n).

        Returns:
            In 1/s for each unit of p.
        """
        motions = (self.right, self.velocity, self.velocity * self.values)
        zero = np.zeros_like(self.right)
        return -self.left @ sum((matrix @ motion for matrix, motion in zip(slope, motions) if matrix.any()), zero)

    def mapped(self, states: np.ndarray, rows: np.ndarray) -> VariedSpectrum:
        """The vectors combined.

        Args:
            states: factor of right vectors, shape (m, m).
            rows: factor of left vectors.

        Returns:
            The spectrum with these vectors.
        """
        right, velocity = (matrix @ states for matrix in (self.right, self.velocity))
        return VariedSpectrum(self.values, right, velocity, rows @ self.left, self.states @ states, rows @ self.rows, self.noise)

    def ordered(self, order: np.ndarray) -> VariedSpectrum:
        """The spectrum in another order, shape (m,)."""
        right, velocity, states = (matrix[:, order] for matrix in (self.right, self.velocity, self.states))
        return VariedSpectrum(self.values[order], right, velocity, self.left[order], states, self.rows[order], self.noise)

    def turned(self, slope: np.ndarray) -> tuple[VariedSpectrum, np.ndarray]:
        """The vectors of equal eigenvalues combined so that they are limits of those for p + dp, and all couplings.

        Args:
            slope: as in ``derivative_matrix``.

        Returns:
            The spectrum, and the couplings, their diagonal the derivatives.
        """
        coupling = self.derivative_matrix(slope)
        groups = equal_groups(self.values, self.noise)
        if not groups:
            return self, coupling
        turn = np.eye(len(self.values), dtype=complex)
        for group in groups:
            place = np.ix_(group, group)
            if np.isfinite(coupling[place]).all():
                turn[place] = np.linalg.eig(coupling[place])[1]
        if not np.linalg.cond(turn) < 1 / EPS**0.5:  # a defective derivative: the vectors stay
            return self, coupling
        back = np.linalg.inv(turn)
        return self.mapped(turn, back), back @ coupling @ turn


def equal_groups(values: np.ndarray, radius: float) -> list[np.ndarray]:
    """The places of eigenvalues that are within a radius of others, each group of two or more."""
    near = np.abs(values[:, None] - values) <= radius
    if near.sum() == len(values):
        return []
    count, labels = connected_components(csr_array(near), directed=False)
    return [group for label in range(count) if len(group := np.flatnonzero(labels == label)) > 1]


def modal_coordinates(M: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Phi and k with Phi^T M Phi = I and Phi^T K Phi = diag(k), k exactly 0 for free motions."""
    if not (is_symmetric(M) and is_symmetric(K)) or not (M.diagonal() > 0).all():
        return None
    root = np.sqrt(M.diagonal())
    if not condition(M / np.multiply.outer(root, root), np.inf) <= STIFFNESS_CONDITION:
        return None
    try:
        stiffness, shapes = scipy.linalg.eigh((K + K.T) / 2, (M + M.T) / 2)
    except np.linalg.LinAlgError:
        return None
    free = len(null_columns(Noisy.rounded(K)).null.data)
    if not free and (refined := refined_modes(M, np.zeros_like(M), K, shapes)) is not None:
        shapes, stiffness, _ = refined
    noise = noise_of(float(np.abs(stiffness).max(initial=0.0)), len(M))
    if (stiffness[free:] <= 0).any() or (np.abs(stiffness[:free]) > noise).any():
        return None
    stiffness[:free] = 0.0
    return shapes, stiffness


def spectrum_of(coefficients: Sequence[np.ndarray]) -> VariedSpectrum:
    """All finite eigenvalues of A(s) with both vectors.

    The states are (w x, x'), w^2 = K_ii / M_ii, so that nothing is larger than the fastest rate. Displacements without stiffness, those of
    columns of K that are exactly zero, are no states: their velocities are.
    """
    K, C, M = coefficients
    n, unit = len(K), (M == np.eye(len(M))).all()
    if not unit:
        row = np.abs(M).max(axis=1, initial=0.0)
        if not ((row > 0).all() and condition(M / row[:, None], np.inf) <= DIVISOR_CONDITION):
            return _by_pairs(PolynomialMatrix(coefficients))
        K, C = np.hsplit(np.linalg.solve(M, np.hstack([K, C])), 2)
    elastic, diagonal = np.flatnonzero(K.any(axis=0)), np.abs(K.diagonal())
    rates = np.sqrt(np.where(diagonal > 0, diagonal, diagonal.max(initial=0.0) or 1.0))[elastic]
    m, stiff = len(elastic), K[:, elastic]
    S = np.zeros((m + n, m + n))
    S[range(m), m + elastic] = rates
    S[m:, :m], S[m:, m:] = (
        (-S[:m, m:].T if np.count_nonzero(stiff) == m and (stiff[elastic].diagonal() > 0).all() else -stiff / rates),
        -C,
    )
    values, states, rows, noise = _decoupled(S)
    velocity = states[m:]
    right = velocity / np.where(np.abs(values) > noise, values, 1.0)
    right[elastic] = states[:m] / rates[:, None]
    left = rows[:, m:] if unit else np.linalg.solve(M.T, rows[:, m:].T).T
    return VariedSpectrum(values, right, velocity, left, states, rows, noise)


def _decoupled(S: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Eigenvalues, vectors, the inverse of these, and the size of rounding errors of eigenvalues; a skew-symmetric S exactly imaginary."""
    if (S == -S.T).all():
        values, states = np.linalg.eigh(1j * S)
        return -1j * values, states, states.conj().T, CLUSTER_SAFETY * EPS * float(np.abs(values).max(initial=0.0))
    real, imaginary, _, packed, failed = lapack.dgeev(S, compute_vl=0)
    if failed:
        raise np.linalg.LinAlgError("the eigenvalues did not converge")
    states = packed.astype(complex)
    upper = np.flatnonzero(imaginary > 0)
    states[:, upper] += 1j * packed[:, upper + 1]
    states[:, upper + 1] = states[:, upper].conj()
    values = real + 1j * imaginary
    try:
        rows = np.linalg.inv(states)
    except np.linalg.LinAlgError:  # defective to the last digit: the nearest that has an inverse
        rows = np.linalg.pinv(states)
    return values, states, rows, CLUSTER_SAFETY * EPS * float(np.abs(values).max(initial=0.0))


def _by_pairs(A: PolynomialMatrix) -> VariedSpectrum:
    """Spectrum by the finite Jordan pair (C, J, B), which exists for singular M: right vectors C V, left ones V^-1 B."""
    pair = A.jordan_pairs().finite
    values, states, rows, noise = _decoupled(pair.J)
    right = pair.C @ states
    return VariedSpectrum(values, right, right * values, rows @ pair.B, states, rows, noise)


def refined_values(coefficients: Sequence[np.ndarray], values: np.ndarray, right: np.ndarray, left: np.ndarray) -> np.ndarray:
    """s - y^T A(s) x / (y^T A'(s) x), summed in long double, in which cancelling terms of K x keep their digits.

    The error is of the second order in those of both vectors (Lancaster 1961, the generalized Rayleigh quotient).
    """
    s = values.astype(np.clongdouble)
    x, y = right.astype(np.clongdouble), left.T.astype(np.clongdouble)
    forms = [(y * (np.asarray(matrix).astype(np.clongdouble) @ x)).sum(axis=0) for matrix in coefficients]
    for _ in range(2):
        value = sum(form * s**power for power, form in enumerate(forms))
        slope = sum(power * form * s ** (power - 1) for power, form in enumerate(forms) if power)
        s = s - np.where(slope != 0, value / np.where(slope != 0, slope, 1), 0)
    return s.astype(complex)
