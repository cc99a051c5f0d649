"""Terms with dead time in the equations A(d/dt) x + sum of A_j(d/dt) x(t - delay_j) = f."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from ..ground.checks import real_array, real_number
from ..ground.errors import InputError
from ..ground.tolerances import noise_of
from .coefficients import PolynomialCoefficients
from .jordan_pairs import JordanPairs


@dataclass(frozen=True, eq=False)
class DelayedTerm:
    """coefficients[0] x(t - delay) + coefficients[1] x'(t - delay) + ...

    Attributes:
        delay: in s, positive.
        coefficients: shape (k, r, r).
    """

    delay: float
    coefficients: np.ndarray

    def __call__(self, s: complex) -> np.ndarray:
        """e^(-s delay) A_j(s), shape (r, r)."""
        total = sum(matrix * s**power for power, matrix in enumerate(self.coefficients))
        return np.exp(-s * self.delay) * total

    @property
    def decimal(self) -> Fraction:
        """The delay as the decimal number that it was written as: three times 0.1 s are 0.3 s."""
        return Fraction(repr(self.delay))

    def mapped(self, left: np.ndarray) -> DelayedTerm:
        """The term with its equations multiplied from the left."""
        return replace(self, coefficients=np.array([left @ matrix for matrix in self.coefficients]))

    @property
    def sizes(self) -> np.ndarray:
        """The moduli of the coefficients, added up, shape (r, r)."""
        return np.abs(self.coefficients).sum(axis=0)


def delayed_terms(given: Mapping | Sequence[DelayedTerm] | None, size: int) -> tuple[DelayedTerm, ...]:
    """The terms of a mapping from delays to A_j(s), ascending by delay, those that are zero left out.

    A_j(s) is a polynomial matrix, a list of its coefficients, or one matrix.

    >>> [(term.delay, term.coefficients.shape) for term in delayed_terms({0.5: [[2.0]], 0.1: [[[0.0]], [[1.0]]]}, 1)]
    [(0.1, (2, 1, 1)), (0.5, (1, 1, 1))]
    """
    if given is None:
        return ()
    if isinstance(given, tuple) and all(isinstance(term, DelayedTerm) for term in given):
        return given
    if not isinstance(given, Mapping):
        raise InputError(
            f"delayed: found {type(given).__name__}; expected a mapping from delays in s to matrices, such as {{0.1: [[2.0]]}}"
        )
    terms = []
    for delay, value in given.items():
        delay = real_number(delay, "delayed: delay", minimum=0.0)
        what = f"delayed: matrix at {delay:g} s"
        if not delay:
            raise InputError("delayed: found a delay of 0 s; what acts at once belongs to A(s)")
        matrices = value.coefficients if isinstance(value, PolynomialCoefficients) else real_array(value, what)
        matrices = matrices[None] if matrices.ndim == 2 else matrices
        if matrices.ndim != 3 or matrices.shape[1:] != (size, size):
            shape = " x ".join(map(str, matrices.shape))
            raise InputError(f"{what}: expected {size} x {size}, or a list of such matrices, found shape {shape}")
        if matrices.any():
            terms.append(DelayedTerm(delay, matrices[: int(np.flatnonzero(matrices.any(axis=(1, 2))).max()) + 1]))
    return tuple(sorted(terms, key=lambda term: term.delay))


# The delayed terms by the states w of the Jordan pairs: w' = J w + B u, x = C w + sum of H_k u^(k), u = f - sum of A_j(d/dt) x(t - delay_j).


def measured_states(pairs: JordanPairs, terms: Sequence[DelayedTerm]) -> list[np.ndarray]:
    """C_j of A_j(d/dt) x = C_j w + ..., the sum of A_ji C J^i, shape (r, n)."""
    rates = [np.asarray(pairs.finite.C, dtype=float)]
    for _ in range(max(len(term.coefficients) for term in terms) - 1):
        rates.append(rates[-1] @ pairs.finite.J)
    return [sum(matrix @ rate for matrix, rate in zip(term.coefficients, rates)) for term in terms]


def feedthrough(pairs: JordanPairs, term: DelayedTerm, order: int) -> np.ndarray:
    """The factor of u^(order) in A_j(d/dt) x, the polynomial part of A_j(s) A(s)^-1, shape (r, r)."""
    return sum(matrix @ pairs.laurent(order - power) for power, matrix in enumerate(term.coefficients))


def check_retarded(pairs: JordanPairs, terms: Sequence[DelayedTerm]) -> None:
    """Raise an InputError for terms of neutral or advanced type: what they measure follows what they act on without any delay of its own."""
    A, highest = pairs.polynomial_matrix, pairs.form.highest_impulse
    for measuring in terms:
        for order in reversed(range(highest + len(measuring.coefficients))):  # the highest derivative names the type
            D = feedthrough(pairs, measuring, order)
            for acting in terms:
                for matrix in acting.coefficients:
                    product, size = D @ matrix, np.abs(D) @ np.abs(matrix)
                    if (np.abs(product) > noise_of(size, len(D))).any():
                        raise InputError(_neutral(A, measuring, acting, order))


def _neutral(A: PolynomialCoefficients, measuring: DelayedTerm, acting: DelayedTerm, order: int) -> str:
    """The message on equations of neutral type, or of advanced type where a derivative follows."""
    rows = np.flatnonzero(acting.sizes.any(axis=1))
    columns = np.flatnonzero(measuring.sizes.any(axis=0))
    equations, coordinates = (
        ", ".join(f'"{names[k]}"' for k in places) for names, places in ((A.equations, rows), (A.coordinates, columns))
    )
    kind = "advanced" if order else "neutral"
    return (
        f"delayed: the term with the delay {acting.delay:g} s acts in the equation {equations}, and what is measured of {coordinates} "
        f"(delay {measuring.delay:g} s) follows it at once, without mass or damping in between: the equations are of {kind} type, in "
        "which every jump returns after each delay; give the coordinate a mass, or measure its displacement instead of its velocity"
    )
