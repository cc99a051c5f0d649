"""Responses of b(z)/a(z) from rest in closed form, for every rational transfer function: the discrete counterpart of Hauksdottir.

Sigurdsson and Hauksdottir, "Closed form expressions of linear discrete time system responses" (IFAC World Congress 2017), derive
them from the fundamental solution of the difference equation; here they are the partial fractions of Y(z) over certified poles, so
that nothing cancels that the sum does not cancel itself.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..exact.enclosure.exact_response import RationalResponse
from ..exact.enclosure.sequences import ForceSums, rows_before, transform_of
from ..exact.rational import RationalMatrix, polynomial
from ..ground.errors import InputError
from ..ground.notices import Notice
from ..linalg.double_double import DoubleDouble
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.discrete import DiscreteForce, DiscreteFunction, Force, discrete_force, growth_notices
from ..response.sample_recursion import ShiftRecursion
from .rational import RationalFunction, rational_function

#: z and z - 1.
Z, FORWARD = polynomial([0, 1]), polynomial([-1, 1])


@dataclass(frozen=True, repr=False, eq=False)
class DiscreteTransferResponse(DiscreteFunction):
    """y of a(sigma) y_k = b(sigma) u_k from rest: ``y(k)`` has shape (1,) or (1, T).

    Attributes:
        fraction: b(z)/a(z).
        gamma: the number of the input I_gamma; None for another input.
        input: another input; None for I_gamma.
    """

    fraction: RationalFunction
    gamma: int | None
    input: DiscreteForce | None

    def _summary(self) -> str:
        which = "given values" if self.gamma is None else f"I_{self.gamma}"
        return f"order {len(self.fraction.denominator) - 1}, input {which}"

    @property
    def before(self) -> tuple[float, ...]:
        """y_-1, y_-2, ...: values before k = 0 where b has a higher degree than a, which looks ahead; empty where it has not."""
        own = self._closed if self.input is None or self.input.closed is not None else None
        if own is not None:
            return tuple(float(row[0]) for row in rows_before(own))
        ahead = [row[0] for row in rows_before(self._column)]
        values = [self.input(k)[0] for k in range(len(ahead))]
        return tuple(float(sum(ahead[i] * values[i - k] for i in range(k, len(ahead)))) for k in range(1, len(ahead)))

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Coefficients without influence, and growth of the response."""
        return (*self.fraction.notices, *growth_notices([pole.value for pole in self._column.poles(0)]))

    @cached_property
    def _matrix(self) -> RationalMatrix:
        return RationalMatrix([[[c]] for c in self.fraction.reduced.denominator])

    def _over(self, above, below) -> RationalResponse:
        """b/a times a transform."""
        return RationalResponse(self._matrix, [polynomial(self.fraction.reduced.numerator) * above], below, range(1))

    @cached_property
    def _closed(self) -> RationalResponse:
        one = polynomial([1])
        if self.input is None:
            gamma = self.gamma or 0
            return self._over(one, FORWARD**gamma) if gamma > 0 else self._over(FORWARD**-gamma, Z ** (1 - gamma))
        if self.input.closed is None:
            return self._over(polynomial([0]), one)
        (above,), below = transform_of(self.input.closed)
        return self._over(above, below)

    @cached_property
    def _recursion(self) -> tuple[ShiftRecursion, float] | None:
        u, (b, a) = self.input, (self.fraction.numerator, self.fraction.denominator)
        is_rounded = any(float(c) != c for c in (*b, *a))
        if u is None or u.closed is not None or not b or is_rounded or len(self.fraction.common_factor) > 1:
            return None
        recursion = ShiftRecursion.of_rows(PolynomialMatrix([[[float(c)]] for c in a]))
        return None if recursion is None else (replace(recursion, lead=tuple(np.array([[float(c)]]) for c in b)), u.end)

    def _forces(self, count: int) -> tuple[DoubleDouble, int]:
        assert self.input is not None
        return self.input.samples(count + len(self.fraction.numerator)), 0

    @cached_property
    def _column(self) -> RationalResponse:
        return self._over(polynomial([1]), polynomial([1]))

    @cached_property
    def _sums(self) -> tuple[ForceSums, ...]:
        if self.input is None or self.input.closed is not None or not self.input.end:
            return ()
        return (ForceSums((self._column,), self.input.exact, self.input.end),)


def discrete_transfer_function_response(numerator, denominator, gamma: int | Force = 1) -> DiscreteTransferResponse:
    """Solve a(sigma) y_k = b(sigma) u_k from rest in closed form, u = I_gamma or any other input.

    I_1 is the step, I_2 the ramp k, I_3 = k (k - 1)/2, in general I_gamma = binom(k, gamma - 1); I_0 is the unit pulse at k = 0 and
    I_-1, I_-2, ... its backward differences. y_k is the sum of Re(v binom(k, j) p^(k - j)) in ``terms``, p the poles of b(z)/a(z) and
    1; poles may be repeated, zero or outside the unit circle, and b may have a higher degree than a: then y begins before k = 0
    (``before``). Common factors cancel exactly.

    Args:
        numerator, denominator: b and a, highest power first as in scipy.signal, floats taken as the exact numbers that they are.
        gamma: a whole number; or an input as the ``force`` of ``mb.solve_discrete``, with one row.

    Returns:
        y, one row, a function of whole numbers k.

    Raises:
        InputError: coefficients that are missing, not real or not finite, a denominator that is zero, an input that is none.

    >>> y = discrete_transfer_function_response([1.0], [1.0, -0.5])  # step response of 1/(z - 1/2)
    >>> y([0, 1, 2, 3]).tolist()
    [[0.0, 1.0, 1.5, 1.75]]
    >>> [(term.pole.real, float(term.vector[0].real)) for term in y.terms]
    [(1.0, 2.0), (0.5, -2.0)]
    >>> discrete_transfer_function_response([1.0, 0.0, 0.0], [1.0, -0.5], 0).before  # z^2/(z - 1/2): the pulse is seen one sample ahead
    (1.0,)
    """
    fraction = rational_function(numerator, denominator)
    if isinstance(gamma, bool) or gamma is None:
        raise InputError(f"gamma: found {gamma!r}; expected a whole number, of the input I_gamma, or an input with one row")
    if isinstance(gamma, (int, np.integer)):
        return DiscreteTransferResponse(fraction, int(gamma), None)
    return DiscreteTransferResponse(fraction, None, discrete_force(gamma, 1, "gamma"))
