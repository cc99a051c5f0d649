"""H(i w) of K + C s + M s^2 with symmetric K and M > 0 as a sum over modes, for many lines of full matrices.

The undamped modes, K phi = M phi w^2, are coordinates in which the equations are graded by their frequencies; the damped modes are
eigenvectors in these. Their errors are relative to each frequency, not to the largest, which those of eigenvalues of A(s) itself are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..ground.tolerances import EPS


@dataclass(frozen=True, eq=False)
class ModalSum:
    """C_e (s I - diag(poles))^-1 B_e.

    Attributes:
        poles: shape (2 r,).
        outputs, inputs: C_e and B_e, shapes (p, 2 r) and (2 r, m).
    """

    poles: np.ndarray
    outputs: np.ndarray
    inputs: np.ndarray

    @classmethod
    def of(cls, coefficients, inputs, outputs) -> ModalSum | None:
        """The modal sum, or None where the matrices do not have that form.

        Args:
            coefficients: K, C, M, shape (3, r, r), K real or complex.
            inputs: B, shape (r, m).
            outputs: C, shape (p, r).

        Returns:
            The sum.
        """
        if len(coefficients) != 3 or any((matrix != matrix.T).any() for matrix in (coefficients[0], coefficients[2])):
            return None
        K, C, M = coefficients
        try:
            squares, modes = scipy.linalg.eigh(K.real, M.real, check_finite=False)
        except np.linalg.LinAlgError:  # M is not positive definite
            return None
        w = np.sqrt(np.abs(squares))
        elastic = w[w > EPS**0.5 * w.max(initial=0.0)]
        w = np.maximum(w, elastic.min(initial=np.inf) if len(elastic) else 1.0)  # free motion in the unit of the lowest oscillation
        r, order = len(w), np.argsort(-np.repeat(w, 2), kind="stable")  # each displacement next to its velocity
        place = np.arange(2 * r).reshape(2, r).T.reshape(-1)[order]
        J = np.zeros((2 * r, 2 * r), dtype=coefficients.dtype)
        J[:r, r:], J[r:, r:] = np.diag(w), -modes.T @ C.real @ modes
        J[r:, :r] = -(np.diag(squares) + 1j * modes.T @ K.imag @ modes if np.iscomplexobj(K) else np.diag(squares)) / w
        try:
            poles, right = np.linalg.eig(J[np.ix_(place, place)])
            back = np.linalg.solve(right, np.pad(modes.T @ inputs, ((r, 0), (0, 0)))[place])
        except np.linalg.LinAlgError:  # no convergence, or a basis that is singular
            return None
        return cls(poles, np.hstack([outputs @ modes / w, np.zeros(outputs.shape)])[:, place] @ right, back)

    def values(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sum, and the scales of its errors, both of shape (p, m, S).

        Args:
            s: shape (S,).

        Returns:
            Values and sizes.
        """
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            inverse = 1 / np.subtract.outer(s, self.poles)
            size = np.abs(inverse)
            size = size * (1 + np.abs(self.poles) * size)
        pairs = [(C[:, None] * self.inputs).T for C in self.outputs]
        total = np.array([pair @ inverse.T for pair in pairs])
        return total, np.array([np.abs(pair) @ size.T for pair in pairs])


def largest_nearby(values: np.ndarray, places: np.ndarray, rank: np.ndarray) -> np.ndarray:
    """The largest of the values at the four nearest places around each rank; infinite values do not count.

    >>> largest_nearby(np.array([1.0, 2.0, 5.0, 1.0]), np.array([0, 10, 20, 30]), np.array([1, 15]))
    array([5., 5.])
    """
    padded = np.pad(np.where(np.isfinite(values), values, 0.0), 2, mode="edge")
    return np.max([padded[np.searchsorted(places, rank) + k] for k in range(4)], axis=0)
