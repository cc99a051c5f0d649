"""Responses of transfer functions as sums of modes with residues, by the formulas of Hauksdottir and Sigurdsson, corrected.

A view for study and comparison. The modes cancel where the response is small: in their example (47) with I_3 no digit is
left at t = 0.01. ``mb.transfer_function_response`` computes the same responses without this cancellation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import comb, factorial

import numpy as np
import scipy.linalg

from ..ground.checks import real_array
from ..ground.errors import InputError
from ..polynomial.structure import FiniteZero


@dataclass(frozen=True, eq=False)
class ResidueSum:
    """y(t) = Re(transient^T E(t)) + sum of forced[k] I_(k+1)(t), for t > 0, and impulses at t = 0 (Theorems 1 and 2).

    Attributes:
        form: the closed form that it belongs to.
        transient: the row in front of E(t), Eq. (48), shape (n,), complex.
        forced: the factors of I_1, I_2, ..., Eq. (49).
        impulses: the factors of Dirac's delta and of its derivatives, Eq. (50), corrected: I_0, I_-1, ...
    """

    form: ResidueForm
    transient: np.ndarray
    forced: np.ndarray
    impulses: np.ndarray

    def __call__(self, times) -> np.ndarray:
        """The regular part at a time (-> a number) or at times (T,) (-> (T,))."""
        times = real_array(times, "time")
        powers = sum((c * times**k / factorial(k) for k, c in enumerate(self.forced)), np.zeros(times.shape))
        return (self.transient @ self.form.exponentials(times)).real + powers


@dataclass(frozen=True, eq=False)
class ResidueForm:
    """Poles, kappa, J, E(t) of a(s) and what responses are made of them.

    Attributes:
        numerator: b_0 ... b_m, divided by a_n, shape (m + 1,).
        poles: the different poles other than 0, complex, those of a pair side by side.
        multiplicities: d_i of each.
        zero_poles: n0, the order of the pole at s = 0 (Eq. 34).

    >>> form = ResidueForm(np.array([1.0]), np.array([-1.0, -2.0]), (1, 1), 0)  # 1 / ((s + 1)(s + 2))
    >>> form.kappa.real.tolist(), float(form.fundamental_solution(0.0)), form.general_response(1).forced.round(12).tolist()
    ([1.0, -1.0], 0.0, [0.5])
    """

    numerator: np.ndarray
    poles: np.ndarray
    multiplicities: tuple[int, ...]
    zero_poles: int

    @staticmethod
    def of(numerator: np.ndarray, zeros: Sequence[FiniteZero], zero_poles: int) -> ResidueForm:
        """The form of b(s)/a(s).

        Args:
            numerator: b_0 ... b_m over a_n.
            zeros: zeros of a(s) other than s = 0.
            zero_poles: n0, the order of the pole at s = 0.

        Returns:
            The form.
        """
        pairs = [(value, zero.multiplicity) for zero in zeros for value in sorted({zero.value, np.conj(zero.value)}, key=np.imag)]
        poles, multiplicities = zip(*pairs) if pairs else ((), ())
        return ResidueForm(np.asarray(numerator, dtype=float), np.array(poles, dtype=complex), tuple(multiplicities), zero_poles)

    @property
    def order(self) -> int:
        """n, the number of poles other than 0."""
        return sum(self.multiplicities)

    @cached_property
    def kappa(self) -> np.ndarray:
        """kappa_ij of 1/a(s) = sum of kappa_ij / (s - lambda_i)^j, Eqs. (36), (37), shape (n,).

        The Taylor coefficients at lambda_i of the product of (s - lambda_k)^-d_k over the other poles.
        """
        parts = [np.zeros(0, dtype=complex)]
        for i, d in enumerate(self.multiplicities):
            series = np.eye(1, d, dtype=complex)[0]
            for k, power in enumerate(self.multiplicities):
                if k != i:
                    distance = self.poles[i] - self.poles[k]
                    factor = [comb(power + j - 1, j) * (-1 / distance) ** j for j in range(d)]
                    series = np.convolve(series, np.array(factor) * distance**-power)[:d]
            parts.append(series[::-1])
        return np.concatenate(parts)

    @cached_property
    def J(self) -> np.ndarray:
        """The Jordan matrix of Eqs. (41), (42), shape (n, n), complex."""
        blocks = [pole * np.eye(d) + np.eye(d, k=1) for pole, d in zip(self.poles, self.multiplicities)]
        return scipy.linalg.block_diag(*blocks) if blocks else np.zeros((0, 0))

    def exponentials(self, times) -> np.ndarray:
        """E(t) of Eqs. (38), (39): t^(j-1)/(j-1)! e^(lambda_i t), shape (n,) or (n, T); E' = J^T E (43)."""
        times = real_array(times, "time")
        rows = [
            times**j / factorial(j) * np.exp(pole * times) for pole, d in zip(self.poles, self.multiplicities) for j in range(d)
        ]
        return np.array(rows, dtype=complex).reshape(self.order, *times.shape)

    def rows(self, first: int, count: int) -> np.ndarray:
        """K of Eq. (45): the rows (J^j kappa)^T for j = first ... first + count - 1.

        Downward each row is that before times J^T. Upward it is v with v J^T = u, in the notation of the paper u / J^T (printed:
        the other division).

        Args:
            first: any whole number.
            count: the number of rows.

        Returns:
            Shape (count, n).
        """
        v = self.kappa
        for _ in range(abs(first)):
            v = self.J @ v if first > 0 else scipy.linalg.solve_triangular(self.J, v)
        K = np.zeros((count, self.order), dtype=complex)
        for k in range(count):
            K[k], v = v, self.J @ v
        return K

    def fundamental_solution(self, times, order: int = 0) -> np.ndarray:
        """y_f^(order)(t) = (J^order kappa)^T E(t), Eqs. (40) (its left side is y_f), (44).

        Args:
            times: a number or shape (T,).
            order: below zero the integral without polynomial part.

        Returns:
            A number or shape (T,).
        """
        return (self.rows(order, 1) @ self.exponentials(times).reshape(self.order, -1)).real.reshape(np.shape(times))

    def at_zero(self, first: int, count: int) -> np.ndarray:
        """y_f^(j)(0) for j = first ... first + count - 1, Eq. (29) at t = 0; those of Eq. (13) exactly.

        Args:
            first: any whole number.
            count: the number of values.

        Returns:
            Shape (count,).
        """
        values = (self.rows(first, count) @ self.exponentials(0.0)).real
        orders = np.arange(first, first + count)
        known = (orders >= 0) & (orders <= self.order - 1)
        return np.where(known, orders == self.order - 1, values) if self.order else values

    def basic_response(self, gamma: int) -> ResidueSum:
        """y_b,gamma of Theorem 1, Eq. (28), with n0 added to gamma: at most one of its two sums is there."""
        return _modal_sum(ResidueForm(np.ones(1), self.poles, self.multiplicities, self.zero_poles), gamma)

    def general_response(self, gamma: int) -> ResidueSum:
        """y_gamma of Theorem 2, Eq. (31); Eq. (35) where there are no poles other than 0."""
        return _modal_sum(self, gamma)

    def forced_matrix(self, gamma: int) -> np.ndarray:
        """The Hankel matrix of Eq. (49), shape (g, g), g = gamma + n0: -(b_0 ... b_(g-1)) times it are the factors of I_1 ... I_g."""
        g = max(self._total(gamma), 0)
        return scipy.linalg.hankel(self.at_zero(-g, g)) if g else np.zeros((0, 0))

    def noncausal_matrix(self, gamma: int) -> np.ndarray:
        """The matrix of Eq. (50), square of size m - g - n + 1: (b_(n+g) ... b_m) times it are the factors of I_-(m-g-n) ... I_0.

        Its bottom left entry is (J^(n-1) kappa)^T E(0) = 1, not 0 as printed: entry (i, j) is y_f^(n-1+k)(0) with
        k = i + j - (m - g - n), zero for k < 0.
        """
        count = max(len(self.numerator) - self._total(gamma) - self.order, 0)
        if not count:
            return np.zeros((0, 0))
        values = self.at_zero(self.order - 1, count)
        return scipy.linalg.hankel(np.append(np.zeros(count - 1), values[0]), values)

    def _total(self, gamma) -> int:
        if isinstance(gamma, bool) or not isinstance(gamma, (int, np.integer)):
            raise InputError(f"gamma: found {gamma!r}; expected a whole number")
        return int(gamma) + self.zero_poles


def _modal_sum(form: ResidueForm, gamma: int) -> ResidueSum:
    b, g, n = form.numerator, form._total(gamma), form.order
    if not n:
        return _powers(form, g)
    forced = -_padded(b, 0, g) @ form.forced_matrix(gamma)
    noncausal = form.noncausal_matrix(gamma)
    return ResidueSum(form, b @ form.rows(-g, len(b)), forced, (_padded(b, n + g, len(noncausal)) @ noncausal)[::-1])


def _powers(form: ResidueForm, g: int) -> ResidueSum:
    """Eq. (35): the sum of b_i I_(g - i)."""
    forced, impulses = np.zeros(max(g, 0)), np.zeros(max(len(form.numerator) - g, 0))
    for i, b in enumerate(form.numerator):
        if g - i > 0:
            forced[g - i - 1] = b
        else:
            impulses[i - g] = b
    return ResidueSum(form, np.zeros(0, dtype=complex), forced, impulses)


def _padded(b: np.ndarray, first: int, count: int) -> np.ndarray:
    """B of Eq. (30): b_first, b_(first+1), ..., zero outside of 0 ... m."""
    return np.array([b[i] if 0 <= i < len(b) else 0.0 for i in range(first, first + count)])
