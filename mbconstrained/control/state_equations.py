"""The matrices and names of E x' = A x + B u, y = C x + D u, with E singular or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from numbers import Number
from typing import ClassVar

import numpy as np

from ..ground.checks import counted, names_of, nearest, places_of, real_array, real_number
from ..ground.display import Displayed
from ..ground.errors import IllConditioned, InputError, SingularPolynomialMatrix
from ..ground.tolerances import GAIN_AGREEMENT, noise_of
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..polynomial.structure import FiniteZero
from ..signals.impulsive import ImpulsiveSmooth
from .rational import RationalFunction, scalar_matrix


class StateEquations(Displayed):
    """Data of a ``StateSpace``, without the answers to questions about it."""

    _instead: ClassVar = {
        "bode": "frequency_response(...).plot",
        **dict.fromkeys(("eigenvalues", "poles"), "frequency_response(...).poles"),
        **dict.fromkeys(("impulse_response", "simulate", "step_response"), "solve"),
        **dict.fromkeys(
            ("closed_loop", "feedback", "series"), "connect systems with python-control: to_control, then StateSpace.from_control"
        ),
    }

    def __init__(
        self,
        A,
        B=None,
        C=None,
        D=None,
        descriptor=None,
        states: Sequence[str] | None = None,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
        units: Mapping[str, str] | None = None,
    ):
        if not real_array(A, "A").size:
            raise InputError("A: found no entries; a state space needs at least one state")
        self.A, self.B, self.C, self.D = map(_fixed, state_matrices(A, B, C, D))
        n, p, q = len(self.A), self.B.shape[1], len(self.C)
        self.is_descriptor = descriptor is not None
        self.E = _fixed(np.eye(n) if descriptor is None else real_array(descriptor, "descriptor", shape=(n, n)))
        self.states, self.inputs = names_of(states, n, "states", "x"), names_of(inputs, p, "inputs", "u")
        self.outputs = names_of(outputs, q, "outputs", "y")
        names_of((*self.states, *self.outputs), n + q, "states and outputs", "x")  # unknowns of one problem
        names = (*self.states, *self.inputs, *self.outputs)
        for name in units or {}:
            if name not in names:
                raise InputError(f'units: there is no state, input or output "{name}"{nearest(name, names)}')
        self.units = {name: str((units or {}).get(name, "1")) for name in names}

    def _summary(self) -> str:
        named = ((self.states, "state"), (self.inputs, "input"), (self.outputs, "output"))
        return ", ".join(counted(len(names), what) for names, what in named)

    def __call__(self, s: complex) -> np.ndarray:
        """G(s) = C (s E - A)^-1 B + D at a finite number s, shape (q, p).

        Raises:
            InputError: s is a pole.
            SingularPolynomialMatrix: det (s E - A) = 0 for every s.
        """
        if not isinstance(s, Number) or not np.isfinite(s):
            raise InputError(f"s: found {s!r}; expected a finite number, real or complex")
        if not self._is_regular:
            self._pencil.jordan_pairs()  # raises the error that names rows and states
        try:
            return self.C @ np.linalg.solve(s * self.E - self.A, self.B) + self.D
        except np.linalg.LinAlgError:
            raise InputError(f"s: found {s:g}, where s E - A is singular; G(s) has no value there") from None

    def polynomial_matrix(self) -> PolynomialMatrix:
        """s E - A, degree 1, size n: its zeros are the poles of the system."""
        return self._pencil

    def polynomial_matrix_with_outputs(self) -> PolynomialMatrix:
        """[[s E - A, 0], [-C, I]], size n + q: with the force [B; D] u it gives x and y together."""
        return self._pencil_with_outputs

    @cached_property
    def _pencil(self) -> PolynomialMatrix:
        return PolynomialMatrix([-self.A, self.E], self.states, [f"row {i + 1}" for i in range(len(self.A))])

    @cached_property
    def _is_regular(self) -> bool:
        return not self.is_descriptor or self._pencil.is_regular

    @cached_property
    def _pencil_with_outputs(self) -> PolynomialMatrix:
        n, q = len(self.A), len(self.C)
        rows = [f"row {i + 1}" for i in range(n)] + [f"output {name}" for name in self.outputs]
        constant = np.block([[-self.A, np.zeros((n, q))], [-self.C, np.eye(q)]])
        return PolynomialMatrix([constant, np.pad(self.E, (0, q))], (*self.states, *self.outputs), rows)

    def start(self, initial) -> np.ndarray:
        """x(0-), shape (n,), from an array, a mapping from names, or None for zeros."""
        return state_values(initial, self.states)

    def start_with_outputs(self, start: np.ndarray) -> np.ndarray:
        """[x(0-); C x(0-)] as the only row, shape (1, n + q), the sums rounded once."""
        exact = [Fraction(value) for value in start.tolist()]
        outputs = [float(sum((Fraction(c) * x for c, x in zip(row, exact)), Fraction(0))) for row in self.C.tolist()]
        return np.array([[*start, *outputs]])

    def force_with_outputs(self, u: ImpulsiveSmooth) -> ImpulsiveSmooth:
        """[B; D] u, n + q rows."""
        return u.mapped(np.vstack([self.B, self.D]))


def state_matrices(A, B, C, D) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C and D of matching shapes; no inputs, no outputs and zero where they are not given."""
    A = real_array(A, "A")
    A = real_array(A, "A", shape=(None, None)) if A.size else A.reshape(0, 0)
    if A.shape[0] != A.shape[1]:
        raise InputError(f"A: expected a square matrix, found {A.shape[0]} x {A.shape[1]}")
    n = len(A)
    q, p = (0, 0) if D is None else real_array(D, "D", shape=(None, None)).shape
    B = real_array(B, "B", shape=(n, None)) if B is not None and (n or np.size(B)) else np.zeros((n, p))
    C = real_array(C, "C", shape=(None, n)) if C is not None and (n or np.size(C)) else np.zeros((q, n))
    D = np.zeros((len(C), B.shape[1])) if D is None else real_array(D, "D", shape=(len(C), B.shape[1]))
    return A, B, C, D


def state_values(initial, states: Sequence[str], what: str = "initial") -> np.ndarray:
    """The values of states, from an array, a mapping from names, zero for the others, or None for zeros."""
    if not isinstance(initial, Mapping):
        return np.zeros(len(states)) if initial is None else real_array(initial, what, shape=(len(states),))
    for name in initial:
        if name not in states:
            raise InputError(f'{what}: there is no state "{name}"{nearest(name, states)}')
    return np.array([float(real_array(initial.get(name, 0.0), f"{what} {name}", shape=())) for name in states])


def delays_of_inputs(system: StateEquations, delays: Mapping[str, float] | None) -> list[float]:
    """The delay of each input in s, 0 where none is given."""
    given = {} if delays is None else delays
    if not isinstance(given, Mapping):
        raise InputError(f"delays: found {type(given).__name__}; expected a mapping from names of inputs to delays in s")
    for name in given:
        if name not in system.inputs:
            raise InputError(f'delays: there is no input "{name}"{nearest(name, system.inputs)}')
    return [real_number(given.get(name, 0.0), f"delay of {name}", minimum=0.0) for name in system.inputs]


def channel_places(chosen, names: Sequence[str], what: str) -> list[int]:
    """The indices of inputs or outputs that are chosen by name or number; None for all."""
    if chosen is None:
        return list(range(len(names)))
    return places_of([chosen] if isinstance(chosen, (str, int)) else chosen, names, what)


def _fixed(matrix: np.ndarray) -> np.ndarray:
    matrix.flags.writeable = False
    return matrix


# Zeros, poles and gain from one input to one output, from the Jordan pairs of polynomial matrices.
#
# The poles are the zeros of s E - A; the zeros those of [[s E - A, -B], [C, D]], whose determinant is det(s E - A) G(s)
# (Rosenbrock 1970). An uncontrollable or unobservable eigenvalue is a zero and a pole alike.

#: G(s) is evaluated for s in this direction, somewhat larger than poles: far from all but strongly unstable ones.
DIRECTION = 1.7 * np.exp(0.9j)


@dataclass(frozen=True, repr=False)
class Transfer(Displayed):
    """G(s) = gain prod(s - zeros)/prod(s - poles)."""

    # with their multiplicities; of a complex pair the one above the real axis stands for both
    zeros: tuple[FiniteZero, ...]
    poles: tuple[FiniteZero, ...]
    gain: float  # the factor; 0 where G(s) = 0 for every s
    dc_gain: float | None  # G(0), common zeros and poles at 0 left out; None where G has a pole at 0

    def _summary(self) -> str:
        zeros, poles = (sum(root.count for root in roots) for roots in (self.zeros, self.poles))
        return f"{counted(zeros, 'zero')}, {counted(poles, 'pole')}, gain {self.gain:.6g}"

    @property
    def numerator(self) -> np.ndarray:
        """gain prod(s - zeros), the highest power first."""
        return self.gain * np.atleast_1d(np.real(np.poly(roots_of(self.zeros))))

    @property
    def denominator(self) -> np.ndarray:
        """prod(s - poles), the highest power first."""
        return np.atleast_1d(np.real(np.poly(roots_of(self.poles))))


def roots_of(zeros: Sequence[FiniteZero]) -> np.ndarray:
    """All roots with their conjugates, repeated by multiplicity, shape (k,).

    >>> roots_of([FiniteZero(1j, 1), FiniteZero(-2 + 0j, 2)]).tolist()
    [1j, -1j, (-2+0j), (-2+0j)]
    """
    roots: list[complex] = []
    for zero in zeros:
        value = complex(zero.value)
        roots += ([value, value.conjugate()] if value.imag else [value]) * zero.multiplicity
    return np.array(roots, dtype=complex)


def transfer_of(system: StateEquations, output: int | str = 0, input: int | str = 0) -> Transfer:
    """Zeros, poles and gain from one input to one output."""
    poles = system.polynomial_matrix().jordan_pairs().structure.finite_zeros
    channel = _Channel(system, channel_place(output, system.outputs, "output"), channel_place(input, system.inputs, "input"))
    samples = _samples(channel, roots_of(poles))
    try:
        pairs = channel.polynomial_matrix().jordan_pairs()
    except SingularPolynomialMatrix:
        if any(abs(G) > noise_of(size, len(system.A)) for _, G, size in samples):
            raise channel.hidden() from None
        return Transfer((), poles, 0.0, 0.0)
    zeros = pairs.structure.finite_zeros
    gain, disagreement = _gain(samples, roots_of(zeros), roots_of(poles))
    if not (disagreement <= GAIN_AGREEMENT and all(decision.clear for decision in pairs.form.decisions)):
        raise channel.hidden()
    return Transfer(zeros, poles, gain, _value_at_zero(channel, zeros, poles, gain))


def channel_matrix(system: StateEquations, output: int, input: int) -> PolynomialMatrix:
    """[[s E - A, -b], [c, d]], whose zeros are those from the input to the output."""
    return _Channel(system, output, input).polynomial_matrix()


def channel_place(key, names: Sequence[str], what: str) -> int:
    if isinstance(key, str) and key in names:
        return names.index(key)
    if isinstance(key, (int, np.integer)) and not isinstance(key, bool) and 0 <= key < len(names):
        return int(key)
    hint = nearest(key, names) if isinstance(key, str) else ""
    raise InputError(f"{what}: found {key!r}{hint}; expected one of {', '.join(names) or 'none'}, or a number from 0")


@dataclass(frozen=True)
class _Channel:
    """The channel from one input to one output of a state space."""

    system: StateEquations
    output: int
    input: int

    def __call__(self, s: complex) -> tuple[complex, float]:
        """G(s), and the size of its terms."""
        system = self.system
        b, c, d = system.B[:, self.input], system.C[self.output], system.D[self.output, self.input]
        value, size = values_with_sizes(s * system.E - system.A, b, c, d)
        return value, float(size)

    def polynomial_matrix(self) -> PolynomialMatrix:
        """[[s E - A, -B], [C, D]] of the channel."""
        system, input, output = self.system, slice(self.input, self.input + 1), slice(self.output, self.output + 1)
        constant = np.block([[-system.A, -system.B[:, input]], [system.C[output], system.D[output, input]]])
        return PolynomialMatrix([constant, np.pad(system.E, (0, 1))])

    def hidden(self) -> IllConditioned:
        """The error for zeros hidden by rounding errors."""
        return IllConditioned(
            f"from {self.system.inputs[self.input]} to {self.system.outputs[self.output]}: rounding of A, B, C and D hides the "
            "zeros of G(s), which is not zero; choose states in which fewer digits cancel, or give the transfer function"
        )


def values_with_sizes(pencil: np.ndarray, B: np.ndarray, C: np.ndarray, D) -> tuple:
    """C P^-1 B + D, and the sizes of its terms, with those of P^-1 B that cause its rounding errors (Skeel 1979)."""
    states = np.linalg.solve(pencil, B)
    sensitivity = np.abs(np.linalg.inv(pencil)) @ (np.abs(pencil) @ np.abs(states))
    return C @ states + D, np.abs(C) @ sensitivity + np.abs(D)


def rational_transfer(fraction: RationalFunction) -> Transfer:
    """Poles, zeros and gain of b(s)/a(s) without its common factor, with exact coefficients.

    >>> from mbconstrained.control.rational import rational_function
    >>> transfer = rational_transfer(rational_function([2.0, 4.0], [1.0, 4.0, 3.0]))
    >>> [zero.value.real for zero in transfer.zeros], transfer.gain, round(transfer.dc_gain, 12)
    ([-2.0], 2.0, 1.333333333333)
    """
    reduced = fraction.reduced
    b, a = reduced.numerator, reduced.denominator
    poles = scalar_matrix(a, reduced.rounded).structure().finite_zeros
    if not b:
        return Transfer((), poles, 0.0, 0.0)
    zeros = scalar_matrix(b, reduced.rounded).structure().finite_zeros
    return Transfer(zeros, poles, float(b[-1] / a[-1]), float(b[0] / a[0]) if a[0] else None)


def _samples(channel: _Channel, poles: np.ndarray) -> list[tuple[complex, complex, float]]:
    """Sample points s, G(s) and the size of its terms, for some s near the poles in size, away from both axes."""
    sizes = np.abs(poles)[np.abs(poles) > 0]
    places = np.quantile(sizes if sizes.size else np.ones(1), [0.0, 0.25, 0.5, 0.75, 1.0]) * DIRECTION
    return [(s, *channel(s)) for s in map(complex, places) if not np.isin(s, poles)]


def _gain(samples, zeros: np.ndarray, poles: np.ndarray) -> tuple[float, float]:
    """The gain from G at the s of least cancellation, and its largest relative difference at other s."""
    gains = []
    for s, G, size in samples:
        if abs(G) > noise_of(size, len(poles)) / GAIN_AGREEMENT and not np.isin(s, zeros):
            logarithm = np.log(s - poles).sum() - np.log(s - zeros).sum()
            gains.append((abs(G) / size, np.log(G) + logarithm))
    if not gains:
        return 0.0, float("inf")
    best = max(gains, key=lambda pair: pair[0])[1]
    gain = np.exp(best)
    return float(gain.real), max(abs(np.expm1(other - best)) for _, other in gains)


def _value_at_zero(channel: _Channel, zeros, poles, gain: float) -> float | None:
    at_zero = [sum(zero.multiplicity for zero in roots if not zero.value) for roots in (zeros, poles)]
    if at_zero[1] != at_zero[0]:
        return None if at_zero[1] > at_zero[0] else 0.0
    if not at_zero[1]:
        return float(channel(0.0)[0].real)
    above, below = (roots_of([zero for zero in roots if zero.value]) for roots in (zeros, poles))
    return float(gain * np.real(np.prod(-above) / np.prod(-below)))
