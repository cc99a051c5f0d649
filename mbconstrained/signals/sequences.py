"""Sequences in closed form, sums of Re(v k^p m^k): the inputs of difference equations."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from math import factorial

import numpy as np

from ..ground.checks import counted, real_array, whole_number
from ..ground.display import Displayed
from ..ground.errors import InputError
from .impulsive import ExactTerm, ImpulsiveSmooth

#: Whole numbers up to this one are exact in float64.
LARGEST_NUMBER = 2**53


@dataclass(frozen=True, eq=False)
class GeometricTerm:
    """Re(v k^power m^k) e^(i phase) / divisor: m by real and imaginary part, or m = e^((a + i w) step) by (a, w); then k is k step."""

    vector: np.ndarray
    ratio: tuple[float, float]
    power: int = 0
    is_exponent: bool = False
    phase: float = 0.0
    divisor: int = 1
    step: float = 1.0

    def values(self, indices: np.ndarray) -> np.ndarray:
        """The term at numbers k (T,), shape (r, T), in float64."""
        k = indices.astype(float) * self.step
        exponent = complex(*self.ratio)
        base = np.exp(exponent * k) if self.is_exponent else np.power(np.full(k.shape, exponent), k)
        factor = k**self.power * base * np.exp(1j * self.phase) / self.divisor
        return np.real(np.multiply.outer(self.vector, factor))


@dataclass(frozen=True, repr=False, eq=False)
class GeometricSequence(Displayed):
    """A sum of geometric sequences f_k = Re(v k^p m^k) for k = 0, 1, ..., as ``geometric`` makes them; they add, numbers multiply them.

    Attributes:
        size: number of rows r.
        terms: the summands.
    """

    size: int
    terms: tuple[GeometricTerm, ...]

    def _summary(self) -> str:
        return f"{counted(self.size, 'row')}, {counted(len(self.terms), 'term')}"

    def __call__(self, k) -> np.ndarray:
        """f_k for a number k (-> shape (r,)) or numbers (T,) (-> (r, T))."""
        indices = sample_numbers(k)
        total = np.zeros((self.size, indices.size))
        for term in self.terms:
            total += term.values(indices.reshape(-1))
        return total if indices.ndim else total[:, 0]

    def __add__(self, other: GeometricSequence) -> GeometricSequence:
        if not isinstance(other, GeometricSequence):
            return NotImplemented
        if other.size != self.size:
            raise InputError(f"sequences of different sizes cannot be added: {self.size} and {other.size} rows")
        return GeometricSequence(self.size, self.terms + other.terms)

    def __mul__(self, factor: float) -> GeometricSequence:
        return GeometricSequence(self.size, tuple(replace(term, vector=factor * term.vector) for term in self.terms))

    def mapped(self, matrix: np.ndarray) -> GeometricSequence:
        """The product matrix @ f_k for a matrix of shape (p, r)."""
        return GeometricSequence(len(matrix), tuple(replace(term, vector=matrix @ term.vector) for term in self.terms))

    __rmul__ = __mul__

    def __sub__(self, other: GeometricSequence) -> GeometricSequence:
        return self + -1.0 * other


def geometric(vector, ratio: complex, *, power: int = 0) -> GeometricSequence:
    """The sequence f_k = Re(v k^p m^k), k = 0, 1, ..., with an exact ratio m: constants, geometric and harmonic inputs in discrete time.

    A signal sampled at t = k has it too, but ``mb.term`` takes the logarithm of the ratio, whose rounding error grows with k.

    Args:
        vector: v, shape (r,), real or complex; a number is one row.
        ratio: m, real or complex; 1 for a constant, -1 for alternating signs, e^(i w) for a harmonic.
        power: p, at least 0.

    Returns:
        A ``GeometricSequence``.

    Raises:
        InputError: numbers that are not finite, a negative power.

    >>> from mbconstrained import geometric
    >>> geometric([1.0, 2.0], 0.5)([0, 1, 2]).tolist()
    [[1.0, 0.5, 0.25], [2.0, 1.0, 0.5]]
    """
    values = np.atleast_1d(_complex(vector, "vector"))
    if values.ndim != 1:
        raise InputError(f"vector: expected a number or a list of numbers, found shape {values.shape}")
    m = _complex(ratio, "ratio")
    if m.ndim:
        raise InputError(f"ratio: expected a number, found shape {m.shape}")
    return GeometricSequence(len(values), (GeometricTerm(values, (float(m.real), float(m.imag)), whole_number(power, "power")),))


def _complex(value, what: str) -> np.ndarray:
    try:
        array = np.asarray(value)
    except ValueError:
        array = np.asarray("")
    if array.dtype.kind == "c" and np.isfinite(array).all():
        return array
    return real_array(value, what)


def sample_numbers(value) -> np.ndarray:
    """A sample number k (shape ()) or numbers (T,), whole and at least 0; otherwise an InputError.

    >>> sample_numbers([0, 3])
    array([0, 3])
    """
    numbers = real_array(value, "k")
    if numbers.ndim > 1:
        raise InputError(f"k: expected a whole number or a list of them, found an array of shape {numbers.shape}")
    if numbers.size and numbers.min() < 0:
        raise InputError(f"k: found {numbers.min():g}; samples are numbered from 0")
    if numbers.size and numbers.max() > LARGEST_NUMBER:
        raise InputError(
            f"k: found {numbers.max():g}; expected at most 2^53, from where float64 does not tell a number from the next"
        )
    whole = numbers.astype(np.int64)
    if (whole != numbers).any():
        wrong = np.atleast_1d(numbers)[np.atleast_1d(whole != numbers)][0]
        raise InputError(f"k: found {wrong:g}; in discrete time there are no values between samples, k is a whole number")
    return whole


def sampled_terms(signal: ImpulsiveSmooth, step: float = 1.0) -> GeometricSequence | None:
    """f(k step) of a signal as geometric sequences, where it is a sum of terms from t = 0 on; otherwise None."""
    terms = []
    for origin in signal.exact_parts:
        term = origin.data
        if not isinstance(term, ExactTerm) or origin.delays or origin.derivatives:
            return None
        vector, divisor = np.asarray(term.vector), term.divisor
        for change in origin.maps:
            vector = change @ vector if np.ndim(change) else change * vector
        terms.append(GeometricTerm(vector, (term.rate, term.angular_frequency), term.power, True, term.phase, divisor, step))
    return GeometricSequence(signal.size, tuple(terms))


def stirling_numbers(power: int) -> Iterator[int]:
    """S(p, 0), S(p, 1), ..., S(p, p) j!: k^p is the sum of them times the binomial coefficients of k over j."""
    row = [1]
    for n in range(1, power + 1):
        row = [0] + [(j * row[j] if j < n else 0) + row[j - 1] for j in range(1, n + 1)]
    return (number * factorial(j) for j, number in enumerate(row))
