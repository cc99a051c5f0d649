"""The matrices and names of E x' = A x + B u, y = C x + D u, with E singular or not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from numbers import Number

import numpy as np

from ..ground.checks import counted, names_of, nearest, real_array
from ..ground.display import Displayed
from ..ground.errors import InputError
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.impulsive import ImpulsiveSmooth


class StateEquations(Displayed):
    """Data of a ``StateSpace``, without the answers to questions about it."""

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
        self.B = _fixed(np.zeros((n, _width(D))) if B is None else real_array(B, "B", shape=(n, None)))
        p = self.B.shape[1]
        self.C = _fixed(np.zeros((_height(D), n)) if C is None else real_array(C, "C", shape=(None, n)))
        q = len(self.C)
        self.D = _fixed(np.zeros((q, p)) if D is None else real_array(D, "D", shape=(q, p)))
        self.is_descriptor = descriptor is not None
        self.E = _fixed(np.eye(n) if descriptor is None else real_array(descriptor, "descriptor", shape=(n, n)))
        self.states, self.inputs = names_of(states, n, "states", "x"), names_of(inputs, p, "inputs", "u")
        self.outputs = names_of(outputs, q, "outputs", "y")
        names_of((*self.states, *self.outputs), n + q, "states and outputs", "x")  # unknowns of one problem
        self.units = _units(units, (*self.states, *self.inputs, *self.outputs))

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
        names = names_of((*self.states, *self.outputs), n + q, "states and outputs", "x")
        rows = [f"row {i + 1}" for i in range(n)] + [f"output {name}" for name in self.outputs]
        constant = np.block([[-self.A, np.zeros((n, q))], [-self.C, np.eye(q)]])
        return PolynomialMatrix([constant, np.pad(self.E, (0, q))], names, rows)

    def start(self, initial) -> np.ndarray:
        """x(0-), shape (n,), from an array, a mapping from names, or None for zeros."""
        if not isinstance(initial, Mapping):
            return np.zeros(len(self.A)) if initial is None else real_array(initial, "initial", shape=(len(self.A),))
        for name in initial:
            if name not in self.states:
                raise InputError(f'initial: there is no state "{name}"{nearest(name, self.states)}')
        return np.array([float(real_array(initial.get(name, 0.0), f"initial {name}", shape=())) for name in self.states])

    def start_with_outputs(self, start: np.ndarray) -> np.ndarray:
        """[x(0-); C x(0-)] as the only row, shape (1, n + q), the sums rounded once."""
        exact = [Fraction(value) for value in start.tolist()]
        outputs = [float(sum((Fraction(c) * x for c, x in zip(row, exact)), Fraction(0))) for row in self.C.tolist()]
        return np.array([[*start, *outputs]])

    def force_with_outputs(self, u: ImpulsiveSmooth) -> ImpulsiveSmooth:
        """[B; D] u, n + q rows."""
        return u.mapped(np.vstack([self.B, self.D]))


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
