"""E x' = A x + B u, y = C x + D u, with E singular or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from numbers import Number

import numpy as np

from ..checks import counted, names_of, nearest, real_array
from ..errors import InputError
from ..polynomial import PolynomialMatrix
from ..signals import ImpulsiveSmooth
from .ordinary import OrdinaryForm, ordinary_form
from .realization import factored_realization, rational_realization
from .state_space_response import StateSpaceResponse, state_space_response
from .transfer import Transfer, transfer_of


class StateSpace:
    """E x' = A x + B u, y = C x + D u, real, in continuous time, with E singular or not.

    Args:
        A: shape (n, n), n >= 1.
        B, C, D: shapes (n, p), (q, n), (q, p); without inputs, without outputs, zero where None.
        descriptor: E, shape (n, n); the identity where None.
        states, inputs, outputs: names; x1, ..., u1, ..., y1, ... where None.
        units: of states, inputs and outputs by name; "1" where nothing is said.

    Raises:
        InputError: shapes that do not fit, entries that are not finite real numbers, names used twice.

    >>> motor = StateSpace([[-2.0]], [[2.0]], [[1.0]], outputs=["speed"], units={"speed": "rad/s"})
    >>> motor
    StateSpace(1 state, 1 input, 1 output)
    >>> from ..signals import step
    >>> bool(np.isclose(motor.solve(input=step([1.0])).output(0.5)[0], 1 - np.exp(-1)))
    True
    """

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
        self.A = _square(A)
        n = len(self.A)
        self.B = _fixed(np.zeros((n, _width(D))) if B is None else _matrix(B, "B", (n, None)))
        p = self.B.shape[1]
        self.C = _fixed(np.zeros((_height(D), n)) if C is None else _matrix(C, "C", (None, n)))
        q = len(self.C)
        self.D = _fixed(np.zeros((q, p)) if D is None else _matrix(D, "D", (q, p)))
        self.is_descriptor = descriptor is not None
        self.E = _fixed(np.eye(n) if descriptor is None else _matrix(descriptor, "descriptor", (n, n)))
        self.states, self.inputs = names_of(states, n, "states", "x"), names_of(inputs, p, "inputs", "u")
        self.outputs = names_of(outputs, q, "outputs", "y")
        names_of((*self.states, *self.outputs), n + q, "states and outputs", "x")  # they are solved for together
        self.units = _units(units, (*self.states, *self.inputs, *self.outputs))

    def __repr__(self) -> str:
        named = ((self.states, "state"), (self.inputs, "input"), (self.outputs, "output"))
        return f"StateSpace({', '.join(counted(len(names), what) for names, what in named)})"

    def __call__(self, s: complex) -> np.ndarray:
        """G(s) = C (s E - A)^-1 B + D at a finite number s, shape (q, p).

        Raises:
            InputError: s is a pole.
            SingularPolynomialMatrix: det (s E - A) = 0 for every s.
        """
        if not isinstance(s, Number) or not np.isfinite(s):
            raise InputError(f"s: found {s!r}; expected a finite number, real or complex")
        if not self._is_regular:
            self._pencil.jordan_pairs()  # raises, and says which rows and states
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
        names = names_of((*self.states, *self.outputs), n + q, "states and outputs", "x")
        rows = [f"row {i + 1}" for i in range(n)] + [f"output {name}" for name in self.outputs]
        constant = np.block([[-self.A, np.zeros((n, q))], [-self.C, np.eye(q)]])
        return PolynomialMatrix([constant, np.pad(self.E, (0, q))], names, rows)

    def solve(self, initial=None, input: ImpulsiveSmooth | None = None, rank_tolerance: float | None = None) -> StateSpaceResponse:
        """x and y on t >= 0 in closed form, from any x(0-), also where E is singular and x(0-) does not fit.

        Args:
            initial: x(0-), shape (n,), or a mapping from names of states to numbers, zero for the others; None for zeros.
            input: u with p rows, see ``mbconstrained.signals``; it acts from t = 0 on. None for zero.
            rank_tolerance: see ``mbconstrained.solve``.

        Raises:
            InputError: shapes that do not fit, unknown names.
            SingularPolynomialMatrix: det (s E - A) = 0 for every s.
        """
        return state_space_response(self, self.start(initial), input, rank_tolerance)

    def start(self, initial) -> np.ndarray:
        """x(0-), shape (n,), from an array, a mapping from names, or None for zeros."""
        if not isinstance(initial, Mapping):
            return np.zeros(len(self.A)) if initial is None else real_array(initial, "initial", shape=(len(self.A),))
        for name in initial:
            if name not in self.states:
                raise InputError(f'initial: there is no state "{name}"{nearest(name, self.states)}')
        return np.array([float(real_array(initial.get(name, 0.0), f"initial {name}", shape=())) for name in self.states])

    def transfer(self, output: int | str = 0, input: int | str = 0) -> Transfer:
        """From an input to an output, by name or number from 0: zeros, poles, gain, numerator and denominator."""
        return transfer_of(self, _place(output, self.outputs, "output"), _place(input, self.inputs, "input"))

    def dc_gains(self) -> np.ndarray | None:
        """G(0), shape (q, p); None where s E - A has a zero at 0."""
        if any(not zero.value for zero in self.polynomial_matrix().jordan_pairs().structure.finite_zeros):
            return None
        return self(0.0)

    def ordinary(self) -> OrdinaryForm:
        """A, B, C, D without descriptor and with the same G(s) (``models.ordinary``).

        Raises:
            InputError: G(s) has a pole at infinity: there are none.
        """
        return ordinary_form(self)

    @classmethod
    def from_transfer_function(cls, numerator, denominator, **names) -> StateSpace:
        """A realization of b(s)/a(s), coefficients with the highest power first as in scipy.signal (``models.realization``).

        Args:
            numerator, denominator: of one input and output; or of each, as lists of lists: numerator[output][input].
            names: states, inputs, outputs, units, as for the class.

        >>> double = StateSpace.from_transfer_function([2.0, 1.0], [1.0, 0.0, 0.0])  # (2 s + 1)/s^2
        >>> double(2.0).item()
        1.25
        """
        E, *matrices = rational_realization(numerator, denominator)
        return cls(*matrices, descriptor=E, **names)

    @classmethod
    def from_zeros_poles_gain(cls, zeros, poles, gain: float, **names) -> StateSpace:
        """A realization of gain prod(s - zeros)/prod(s - poles) as a chain of sections of second order.

        >>> bool(np.isclose(StateSpace.from_zeros_poles_gain([], [-1 + 1j, -1 - 1j], 4.0)(0).item(), 2.0))
        True
        """
        E, *matrices = factored_realization(zeros, poles, gain)
        return cls(*matrices, descriptor=E, **names)

    @classmethod
    def from_scipy(cls, system) -> StateSpace:
        """Of a scipy.signal ``StateSpace``, ``TransferFunction`` or ``ZerosPolesGain`` (``models.conversions``)."""
        from .conversions import state_space_of

        return state_space_of(system)

    @classmethod
    def from_control(cls, system) -> StateSpace:
        """Of a python-control ``StateSpace`` or ``TransferFunction``, with its names (``models.conversions``)."""
        from .conversions import state_space_of

        return state_space_of(system)

    def to_scipy(self, form: str = "state space", output: int | str | None = None, input: int | str | None = None):
        """As scipy.signal ``StateSpace``, or as "transfer function" or "zeros poles gain" of one input and output."""
        from .conversions import to_scipy

        return to_scipy(self, form, output, input)

    def to_control(self, form: str = "state space"):
        """As a python-control system with the same names: "state space", or "transfer function" of all inputs and outputs.

        Raises:
            MissingPackage: python-control is not installed.
        """
        from .conversions import to_control

        return to_control(self, form)


def _matrix(value, what: str, shape) -> np.ndarray:
    return real_array(value, what, shape=shape)


def _square(A) -> np.ndarray:
    matrix = real_array(A, "A", shape=(None, None))
    if matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"A: expected a square matrix, found {matrix.shape[0]} x {matrix.shape[1]}")
    if not len(matrix):
        raise InputError("A: found no entries; a state space needs at least one state")
    return _fixed(matrix)


def _width(D) -> int:
    return 0 if D is None else real_array(D, "D", shape=(None, None)).shape[1]


def _height(D) -> int:
    return 0 if D is None else len(real_array(D, "D", shape=(None, None)))


def _fixed(matrix: np.ndarray) -> np.ndarray:
    matrix.flags.writeable = False
    return matrix


def _units(units, names) -> dict[str, str]:
    for name in units or {}:
        if name not in names:
            raise InputError(f'units: there is no state, input or output "{name}"{nearest(name, names)}')
    return {name: str((units or {}).get(name, "1")) for name in names}


def _place(key, names: Sequence[str], what: str) -> int:
    if isinstance(key, str) and key in names:
        return names.index(key)
    if isinstance(key, (int, np.integer)) and not isinstance(key, bool) and 0 <= key < len(names):
        return int(key)
    hint = nearest(key, names) if isinstance(key, str) else ""
    raise InputError(f"{what}: found {key!r}{hint}; expected one of {', '.join(names) or 'none'}, or a number from 0")
