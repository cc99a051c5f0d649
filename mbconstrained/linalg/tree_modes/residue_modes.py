"""A symmetric system of second order decoupled by the vectors of its coordinates, without an inverse of twice their number.

For symmetric M, C, K a zero s of P(s) = M s^2 + C s + K with P(s) x = 0 has x^T P(s) = 0 too. With x^T P'(s) x = 1 or -1 the states
w = (x_m, x_m', x_d) are sums of (x_m, s x_m, x_d) with coefficients x^T ((s M + C) (x_m, x_d) + M x_m'), by residues of P(s)^-1
(Lancaster 1966, chapter 4). Half of the entries of the vectors are all that is stored.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..arrays import Matrix


@dataclass(frozen=True, eq=False)
class ResidueModes:
    """Modes by residues in the form of a ``BlockDiagonal``, with basis and inverse computed on demand.

    Attributes:
        M, C: coefficients, of shape (m, m) and (m + d, m + d).
        shapes: x, real and imaginary parts of pairs side by side, then those of real zeros, shape (m + d, n).
        upper, real: s of pairs, above the real axis, and real ones.
        signs: x^T P'(s) x of real zeros, 1 or -1.
        coupling: the largest sum of |y| |w| over the states, y being the row of the inverse for the vector w.
        exact_blocks: 0: no block is known exactly.
    """

    M: Matrix
    C: Matrix
    shapes: np.ndarray
    upper: np.ndarray
    real: np.ndarray
    signs: np.ndarray
    coupling: float
    exact_blocks: int = 0

    @cached_property
    def blocks(self) -> tuple[np.ndarray, ...]:
        """[[a, b], [-b, a]] of pairs a + i b, then real zeros."""
        a, b = self.upper.real, self.upper.imag
        return (*np.stack([a, b, -b, a], axis=1).reshape(-1, 2, 2), *self.real[:, None, None])

    @cached_property
    def basis(self) -> np.ndarray:
        """Shape (n, n)."""
        m = self.M.shape[0]
        return np.concatenate([self.shapes[:m], self._velocities(self.shapes[:m]), self.shapes[m:]])

    @cached_property
    def inverse(self) -> np.ndarray:
        """Inverse of the basis, shape (n, n)."""
        return self.coordinates(np.eye(self.shapes.shape[1]))

    def modal_output(self, output: Matrix) -> np.ndarray:
        """output @ basis, for an output of shape (r, n)."""
        m = self.M.shape[0]
        velocities = output[:, m : 2 * m]
        result = output[:, :m] @ self.shapes[:m]
        if self.shapes.shape[0] > m:
            result += output[:, 2 * m :] @ self.shapes[m:]
        if abs(velocities).max() > 0:
            result += self._velocities(velocities @ self.shapes[:m])
        return result

    def coordinates(self, states: np.ndarray) -> np.ndarray:
        """inverse @ states, of shape (n, any) or (n,), with one step of refinement."""
        result = self.residues(states)
        return result + self.residues(states - self.states(result))

    def residues(self, states: np.ndarray) -> np.ndarray:
        """inverse @ states by the formula."""
        m = self.M.shape[0]
        places, velocities = np.concatenate([states[:m], states[2 * m :]]), states[m : 2 * m]
        loads, momenta = self.C @ places, self.M @ places[:m]
        loads[:m] += self.M @ velocities
        one, two = self.shapes.T @ loads, self.shapes[:m].T @ momenta
        count = 2 * len(self.upper)
        s, turned = self.upper.reshape(-1, *[1] * (states.ndim - 1)), _complex(one[:count]) + 0j
        turned += s * _complex(two[:count])
        result = np.empty_like(one)
        result[0:count:2], result[1:count:2] = 2 * turned.real, -2 * turned.imag
        signs, real = (part.reshape(-1, *[1] * (states.ndim - 1)) for part in (self.signs, self.real))
        result[count:] = signs * (one[count:] + real * two[count:])
        return result

    def states(self, coordinates: np.ndarray) -> np.ndarray:
        """basis @ coordinates."""
        m = self.M.shape[0]
        rates = np.empty_like(coordinates)
        count, extra = 2 * len(self.upper), [1] * (coordinates.ndim - 1)
        a, b = self.upper.real.reshape(-1, *extra), self.upper.imag.reshape(-1, *extra)
        even, odd = coordinates[0:count:2], coordinates[1:count:2]
        rates[0:count:2], rates[1:count:2] = a * even + b * odd, a * odd - b * even
        rates[count:] = self.real.reshape(-1, *extra) * coordinates[count:]
        places = self.shapes @ coordinates
        return np.concatenate([places[:m], self.shapes[:m] @ rates, places[m:]])

    def _velocities(self, columns: np.ndarray) -> np.ndarray:
        """columns @ diag(blocks)."""
        result, count = columns.copy(), 2 * len(self.upper)
        a, b = self.upper.real, self.upper.imag
        even, odd = columns[:, 0:count:2], columns[:, 1:count:2]
        result[:, 0:count:2], result[:, 1:count:2] = even * a - odd * b, even * b + odd * a
        result[:, count:] *= self.real
        return result


def _complex(rows: np.ndarray) -> np.ndarray:
    return rows[0::2] + 1j * rows[1::2]
