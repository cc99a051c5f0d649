"""Discrete time: state spaces (discretized ones, those of other packages) with responses, frequency responses and zeros; transfer functions.

The response of every rational b(z)/a(z) from rest is the discrete counterpart of Hauksdottir. Sigurdsson and Hauksdottir, "Closed form
expressions of linear discrete time system responses" (IFAC World Congress 2017), derive it from the fundamental solution of the difference
equation; here it is the partial fractions of Y(z) over certified poles, so that nothing cancels that the sum does not cancel itself.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from math import comb
from numbers import Number
from typing import TYPE_CHECKING

import numpy as np

from ..exact import structure
from ..exact.enclosure.discretization import DiscretizedSystem, Hold, discretized
from ..exact.enclosure.exact_response import RationalResponse
from ..exact.enclosure.sequences import ForceSums, rows_before, transform_of
from ..exact.rational import RationalMatrix, polynomial
from ..ground.checks import counted, names_of, optional_package, real_array, real_number
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError, SingularPolynomialMatrix
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EPS, rounding_radius
from ..linalg.double_double import DoubleDouble
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..response.discrete import DiscreteForce, DiscreteFunction, DiscreteResponse, Force, discrete_force, from_start, growth_notices
from ..response.sample_recursion import ShiftRecursion
from ..signals.sequences import sample_numbers
from .conversions import arguments_of, through
from .rational import RationalFunction, rational_function
from .state_equations import (
    StateEquations,
    channel_matrix,
    channel_place,
    channel_places,
    delays_of_inputs,
    roots_of,
    state_matrices,
    state_values,
    transfer_of,
    values_with_sizes,
)

if TYPE_CHECKING:
    from ..polynomial.structure import FiniteZero


@dataclass(frozen=True, repr=False, eq=False)
class DiscreteStateSpaceResponse(Displayed):
    """x_k and y_k of a ``DiscreteStateSpace`` in closed form: ``response(k)`` are the states, ``response.output(k)`` the outputs.

    Attributes:
        system: the state space.
        together: x and y, one below the other.
    """

    system: DiscreteStateSpace
    together: DiscreteResponse = field(repr=False)

    def _summary(self) -> str:
        return f"{self.system._summary()}, step {self.system.step:g} s"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def __call__(self, k) -> np.ndarray:
        """The states x_k at a whole number k (-> (n,)) or at numbers (T,) (-> (n, T))."""
        return self.together(k)[: len(self.system.A)]

    def output(self, k) -> np.ndarray:
        """The outputs y_k at a whole number k (-> (q,)) or at numbers (T,) (-> (q, T))."""
        return self.together(k)[len(self.system.A) :]

    def times(self, k) -> np.ndarray:
        """The times k step in s."""
        return sample_numbers(k) * self.system.step

    def error_estimate(self, k) -> float:
        """An estimate of max |error| / max |x_k, y_k| over the numbers k, for the matrices as they are."""
        return self.together.error_estimate(k)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the system and of the solution."""
        return (*self.system.notices, *self.together.notices)


@dataclass(frozen=True, repr=False, eq=False)
class DiscreteFrequencyResponse(Displayed):
    """G(e^(i w h)) = C (e^(i w h) I - A)^-1 B + D for frequencies up to the Nyquist frequency.

    Attributes:
        frequencies_hz: shape (F,).
        values: complex, shape (outputs, inputs, F); at a pole on the unit circle infinite.
        error_estimate: relative error of each value, of the same shape.
        nyquist_hz: half of the sampling frequency.
    """

    frequencies_hz: np.ndarray
    values: np.ndarray
    error_estimate: np.ndarray
    #: Names of the inputs.
    inputs: tuple[str, ...]
    #: Names of the outputs.
    outputs: tuple[str, ...]
    nyquist_hz: float

    def _summary(self) -> str:
        return f"{counted(len(self.outputs), 'output')}, {counted(len(self.inputs), 'input')}, {counted(len(self.frequencies_hz), 'frequency', 'frequencies')}"


@dataclass(frozen=True)
class SampledZero:
    """A zero of the transfer function from one input to one output.

    Attributes:
        value: z; of a complex pair the one above the real axis.
        multiplicity: how often.
        error: an estimate of the error of z that rounding errors of A, B, C and D leave; half a unit in the last place for exact zeros.
        origin: "plant": the image e^(s h) of a zero s of the continuous system, near it; "sampling": there is no such zero;
            "" where the continuous system is not known.
        limit: of a zero of sampling its limit for step -> 0, a root of an Euler-Frobenius polynomial; of one of the plant e^(s h); None
            where neither is known.
    """

    value: complex
    multiplicity: int
    error: float
    origin: str
    limit: complex | None

    @property
    def condition(self) -> float:
        """By how much relative errors of A, B, C and D are magnified in z; infinite for z = 0."""
        return self.error / (EPS * abs(self.value)) if self.value else np.inf


@dataclass(frozen=True, eq=False)
class SampledOrigin:
    """The continuous system of a discretized one."""

    system: StateEquations  # the continuous system
    form: DiscretizedSystem  # the discretized equations and the map of its start
    hold: Hold  # how inputs continue between samples
    is_delayed: bool  # whether an input is


class DiscreteStateSpace(Displayed):
    """x_(k+1) = A x_k + B u_k, y_k = C x_k + D u_k, real, at the times k step.

    Args:
        A: shape (n, n); n may be 0.
        B, C, D: shapes (n, p), (q, n), (q, p); no inputs, no outputs and zero by default.
        step: the time between samples in s.
        states, inputs, outputs: names; x1, ..., u1, ..., y1, ... by default.

    Raises:
        InputError: shapes that do not match, entries that are not finite real numbers, names used twice, a step that is not positive.

    >>> low_pass = DiscreteStateSpace([[0.5]], [[0.5]], [[1.0]], step=0.1)
    >>> low_pass.solve(input=[[1.0]] * 3).output([0, 1, 2, 3]).tolist()
    [[0.0, 0.5, 0.75, 0.875]]
    """

    origin: SampledOrigin | None = None

    def __init__(
        self,
        A,
        B=None,
        C=None,
        D=None,
        step: float = 1.0,
        states: Sequence[str] | None = None,
        inputs: Sequence[str] | None = None,
        outputs: Sequence[str] | None = None,
    ):
        self.step = real_number(step, "step", positive=True)
        self.A, self.B, self.C, self.D = A, B, C, D = state_matrices(A, B, C, D)
        n = len(A)
        self.states, self.inputs = names_of(states, n, "states", "x"), names_of(inputs, B.shape[1], "inputs", "u")
        self.outputs = names_of(outputs, len(C), "outputs", "y")
        self.notices: tuple[Notice, ...] = growth_notices(np.linalg.eigvals(A)) if n else ()

    @classmethod
    def of_continuous(
        cls, system: StateEquations, step: float, hold: Hold, delays: Mapping[str, float] | None
    ) -> DiscreteStateSpace:
        """The states and outputs of a continuous system at t = k step under a hold of its input (``StateSpace.discretize``).

        Args:
            system: the continuous system.
            step, hold, delays: as in ``StateSpace.discretize``.

        Returns:
            The state space with its ``origin``.
        """
        form = discretized_system(system, step, hold, delays)
        count = len(form.A) - len(form.delayed)
        names = list(system.states) if count == len(system.A) else [f"state {i + 1}" for i in range(count)]
        names += [f"{system.inputs[j]} {samples} before" for j, samples in form.delayed]
        result = cls(form.A, form.B, form.C, form.D, step, names, list(system.inputs), list(system.outputs))
        result.notices = (*form.notices, *result.notices)
        result.origin = SampledOrigin(system, form, hold, bool(delays and any(delays.values())))
        return result

    def _summary(self) -> str:
        named = ((self.states, "state"), (self.inputs, "input"), (self.outputs, "output"))
        return ", ".join(counted(len(names), what) for names, what in named)

    @property
    def nyquist_hz(self) -> float:
        """Half of the sampling frequency, 1/(2 step), in Hz."""
        return 0.5 / self.step

    def __call__(self, z: complex) -> np.ndarray:
        """G(z) = C (z I - A)^-1 B + D at a finite number z, shape (q, p).

        Raises:
            InputError: z is a pole.
        """
        if not isinstance(z, Number) or not np.isfinite(z):
            raise InputError(f"z: found {z!r}; expected a finite number, real or complex")
        try:
            return self.C @ np.linalg.solve(z * np.eye(len(self.A)) - self.A, self.B) + self.D
        except np.linalg.LinAlgError:
            raise InputError(f"z: found {z:g}, where z I - A is singular; G(z) has no value there") from None

    def solve(self, initial=None, input: Force = None) -> DiscreteStateSpaceResponse:
        """Solve for x_k and y_k in closed form.

        Args:
            initial: x_0, shape (n,), or a mapping from names of states to numbers; of a discretized system x(0-) of the continuous
                one, its states by shape or name, inputs zero before t = 0. None for zeros.
            input: u_0, u_1, ... as rows, shape (N, p), zero afterwards; a function k -> (p,); a sequence in closed form
                (``mb.geometric``); or a signal, sampled at t = k step. None for zero.

        Returns:
            The response, a function of whole numbers k.

        Raises:
            InputError: shapes that do not match, unknown names.

        >>> import mbconstrained as mb
        >>> ramp = mb.StateSpace([[0.0]], [[1.0]], [[1.0]]).discretize(0.5, hold=1)  # an integrator
        >>> ramp.solve(input=mb.step([1.0])).output([0, 1, 2]).tolist()
        [[0.0, 0.5, 1.0]]
        """
        n, q = len(self.A), len(self.C)
        force = discrete_force(input, len(self.inputs), "input", self.step)
        start = np.concatenate([self._start(initial, force(0)), np.zeros(q)])
        constant = np.block([[-self.A, np.zeros((n, q))], [-self.C, np.eye(q)]])
        states, outputs = [f"state {name}" for name in self.states], list(self.outputs)
        if set(states) & set(outputs):
            outputs = [f"output {name}" for name in outputs]
        A = PolynomialMatrix([constant, np.diag([1.0] * n + [0.0] * q)], states + outputs)
        return DiscreteStateSpaceResponse(self, from_start(A, start[None, :], force.times(np.vstack([self.B, self.D]))))

    def _start(self, initial, first: np.ndarray) -> np.ndarray:
        if self.origin is None:
            return state_values(initial, self.states)
        given, values = self.origin.form, state_values(initial, self.origin.system.states)
        start = np.zeros(len(self.A))
        start[: len(given.start_map)] = given.start_map @ values
        return start + given.start_input @ first

    def frequency_response(self, frequencies_hz, inputs=None, outputs=None) -> DiscreteFrequencyResponse:
        """Return G(e^(i w h)), w = 2 pi f, h the step, at frequencies up to the Nyquist frequency 1/(2 h).

        Above it samples cannot tell an oscillation from a slower one, and a response there is refused.

        Args:
            frequencies_hz: in Hz, a number or shape (F,).
            inputs, outputs: names or numbers from 0; all by default.

        Returns:
            A ``DiscreteFrequencyResponse``.

        Raises:
            InputError: unknown names, frequencies that are negative, not finite or above the Nyquist frequency.

        >>> low_pass = DiscreteStateSpace([[0.5]], [[0.5]], [[1.0]], step=0.1)
        >>> low_pass.frequency_response([0.0, 5.0]).values.round(6).tolist()
        [[[(1+0j), (-0.333333+0j)]]]
        """
        f = np.atleast_1d(real_array(frequencies_hz, "frequencies_hz"))
        if f.ndim > 1 or (f.size and f.min() < 0):
            raise InputError("frequencies_hz: expected numbers of at least 0 Hz, in a list")
        if f.size and f.max() > self.nyquist_hz * (1 + 4 * EPS):
            raise InputError(
                f"frequencies_hz: found {f.max():g} Hz; with a step of {self.step:g} s the Nyquist frequency is {self.nyquist_hz:g} Hz, "
                "and samples cannot tell oscillations above it from slower ones"
            )
        rows, columns = channel_places(outputs, self.outputs, "output"), channel_places(inputs, self.inputs, "input")
        values = np.zeros((len(rows), len(columns), len(f)), dtype=complex)
        errors = np.zeros(values.shape)
        B, C, D = self.B[:, columns], self.C[rows], self.D[np.ix_(rows, columns)]
        for place, frequency in enumerate(f):
            values[..., place], errors[..., place] = _line(self.A, B, C, D, 2 * frequency * self.step)
        names = tuple(self.inputs[j] for j in columns), tuple(self.outputs[i] for i in rows)
        return DiscreteFrequencyResponse(f, values, errors, *names, self.nyquist_hz)

    def poles(self) -> np.ndarray:
        """The eigenvalues of A with their conjugates, ascending by modulus, shape (n,)."""
        if not len(self.A):
            return np.zeros(0, dtype=complex)
        return roots_of(self._equations.polynomial_matrix().jordan_pairs().structure.finite_zeros)

    def zeros(self, output: int | str = 0, input: int | str = 0, *, exact: bool = False) -> tuple[SampledZero, ...]:
        """Return the zeros from one input to one output, and which of them sampling adds.

        A zero s of the continuous system has a zero near e^(s h). Of m poles more than zeros sampling adds m - 1 zeros with hold=0, m
        with hold=1; for step -> 0 they tend to the roots of the Euler-Frobenius polynomials B_m and B_(m+1) (Astrom, Hagander and
        Sternby, "Zeros of sampled systems", Automatica 20, 1984), from B_3 = z^2 + 4 z + 1 on with one outside the unit circle.
        A delay that is no multiple of the step adds one more.

        Args:
            output, input: names or numbers from 0.
            exact: whether the numbers in A, B, C and D count as exact: then each zero is the nearest float64 number, and multiplicities are
                certain.

        Returns:
            The zeros, each with an estimate of its error, its origin and its limit.

        Raises:
            InputError: unknown names.
            IllConditioned: rounding errors hide the zeros; a larger step has them.

        >>> import mbconstrained as mb
        >>> double = mb.StateSpace.from_transfer_function([1.0], [1.0, 0.0, 0.0]).discretize(0.1, hold=0)
        >>> [(round(zero.value.real, 9), zero.origin) for zero in double.zeros()]
        [(-1.0, 'sampling')]
        """
        output, input = channel_place(output, self.outputs, "output"), channel_place(input, self.inputs, "input")
        if not len(self.A):
            return ()
        matrix = channel_matrix(self._equations, output, input)
        if exact:
            own = [(complex(zero.value), zero.multiplicity, EPS / 2 * abs(zero.value)) for zero in exact_zeros(matrix)]
        else:
            zeros = transfer_of(self._equations, output, input).zeros
            own = [(complex(zero.value), zero.multiplicity, zero_error(matrix, zero)) for zero in zeros]
        if self.origin is None:
            return tuple(SampledZero(*zero, "", None) for zero in own)
        plant = transfer_of(self.origin.system, output, input)
        values = roots_of(plant.zeros)
        images = list(np.exp(values[values.imag >= 0] * self.step))
        excess = len(roots_of(plant.poles)) - len(values)
        single = [value for value, count, _ in own for _ in range(count)]
        errors = [error for _, count, error in own for _ in range(count)]
        near: dict[int, complex] = {}
        while images and len(near) < len(single):
            distances = {(i, j): abs(z - e) for i, z in enumerate(single) if i not in near for j, e in enumerate(images)}
            i, j = min(distances, key=distances.__getitem__)
            near[i] = images.pop(j)
        hold = self.origin.hold
        order = 0 if self.origin.is_delayed or isinstance(hold, str) else excess + hold
        limits = sorted(np.roots(euler_frobenius(order)).real) if order > 0 else []
        result = []
        for i, value in enumerate(single):
            limit = near.get(i)
            if limit is None and limits:
                limit = limits.pop(int(np.argmin(np.abs(np.log(np.abs(np.array(limits))) - np.log(abs(value) or EPS)))))
            origin = "plant" if i in near else "sampling"
            result.append(SampledZero(value, 1, errors[i], origin, None if limit is None else complex(limit)))
        return tuple(result)

    @cached_property
    def _equations(self) -> StateEquations:
        return StateEquations(
            self.A, self.B, self.C, self.D, None, None, list(self.inputs), [f"output {name}" for name in self.outputs]
        )

    def to_scipy(self):
        """Return the ``scipy.signal`` state space in discrete time (``dlti``) with dt = step."""
        import scipy.signal  # takes half a second

        return scipy.signal.StateSpace(self.A, self.B, self.C, self.D, dt=self.step)

    def to_control(self):
        """Return the python-control state space with dt = step and the names of states, inputs and outputs.

        Raises:
            InputError: no inputs or no outputs.
            MissingPackage: python-control is not installed.
        """
        if not self.inputs or not self.outputs:
            raise InputError(
                f"the system has {counted(len(self.inputs), 'input')} and {counted(len(self.outputs), 'output')}; expected at least one of each"
            )
        control = optional_package("control", "to_control")
        names = {"inputs": list(self.inputs), "outputs": list(self.outputs)}
        names |= {"states": list(self.states)} if self.states else {}
        return control.ss(self.A, self.B, self.C, self.D, self.step, **names)

    @classmethod
    def from_scipy(cls, system, step: float | None = None) -> DiscreteStateSpace:
        """Return the state space of a ``scipy.signal`` system in discrete time: ``StateSpace``, ``TransferFunction`` or ``ZerosPolesGain``.

        Args:
            system: with its step as dt.
            step: in s; required where dt is True, which leaves it open.

        Returns:
            The state space.

        Raises:
            InputError: a continuous system, an open step, a numerator of higher degree than the denominator.

        >>> import scipy.signal
        >>> DiscreteStateSpace.from_scipy(scipy.signal.TransferFunction([1.0], [1.0, -0.5], dt=0.1))(1).item()
        2.0
        """
        if not hasattr(system, "dt"):
            raise InputError(f"found {type(system).__name__}; expected a system of scipy.signal or python-control in discrete time")
        own = system.dt
        if own is None or (not isinstance(own, bool) and own == 0):
            raise InputError(
                f"found a continuous system (dt = {own}); expected one in discrete time: mb.StateSpace reads it, and .discretize samples it"
            )
        if isinstance(own, bool) and step is None:
            raise InputError("dt: the system leaves its step open (dt = True); give step in s")
        given = arguments_of(system)
        n = len(given["A"])
        E = given.pop("descriptor", None)
        if E is not None and not np.array_equal(E, np.eye(n)):
            if not np.any(E):  # a constant gain
                given = {
                    "A": np.zeros((0, 0)),
                    "D": given["C"] @ np.linalg.solve(-given["A"], given["B"]) + (0 if given.get("D") is None else given["D"]),
                }
            else:
                raise InputError(
                    "the numerator has a higher degree than the denominator: the output would precede the input; mb.solve_discrete solves such equations"
                )
        return cls(**given, step=own if step is None else step)

    @classmethod
    def from_control(cls, system, step: float | None = None) -> DiscreteStateSpace:
        """Return the state space of a python-control system in discrete time with its names, as ``from_scipy``.

        Args:
            system: a ``StateSpace`` or ``TransferFunction`` with its step as dt.
            step: in s; required where dt is True, which leaves it open.

        Returns:
            The state space.
        """
        return cls.from_scipy(system, step)


def exact_zeros(matrix: PolynomialMatrix) -> tuple[FiniteZero, ...]:
    """The zeros of a matrix of exact numbers; none where it is singular for every z."""
    try:
        return structure(matrix).finite_zeros
    except SingularPolynomialMatrix:
        return ()


def zero_error(matrix: PolynomialMatrix, zero: FiniteZero) -> float:
    """The displacement of a zero by relative rounding errors of the entries, to first order; of a multiple one its usual scatter.

    With P(z) x = 0 and y^H P(z) = 0 it is y^H dP x / (y^H P' x).
    """
    P0, P1 = matrix.coefficients
    value = complex(zero.value)
    left, _, right = np.linalg.svd(P0 + value * P1)
    y, x = left[:, -1], right[-1].conj()
    below = abs(y.conj() @ P1 @ x)
    moved = EPS * len(P0) * float(np.abs(y) @ (np.abs(P0) + abs(value) * np.abs(P1)) @ np.abs(x))
    if zero.multiplicity == 1:
        return float(moved / below) if below else np.inf
    return float(max(abs(value), np.abs(P0).max()) * rounding_radius(zero.multiplicity))


def euler_frobenius(order: int) -> list[int]:
    """The coefficients of B_m, whose roots are the zeros of the sampled m-fold integrator for step -> 0, highest power first.

    >>> euler_frobenius(3), euler_frobenius(4)
    ([1, 4, 1], [1, 11, 11, 1])
    """
    m = order
    return [sum((-1) ** (k - i) * i**m * comb(m + 1, k - i) for i in range(1, k + 1)) for k in range(1, m + 1)]


def _line(A, B, C, D, half_turns: float) -> tuple[np.ndarray, np.ndarray]:
    """G(e^(i pi half_turns)) and the relative errors of its entries."""
    turn = np.longdouble(half_turns) * np.arctan(np.longdouble(1)) * 4
    pencil = complex(np.cos(turn), np.sin(turn)) * np.eye(len(A)) - A
    try:
        values, size = values_with_sizes(pencil, B, C, D)
    except np.linalg.LinAlgError:
        infinite = np.full(D.shape, np.inf)
        return infinite.astype(complex), infinite
    errors = np.divide(4 * EPS * (len(A) + 1) * size, np.abs(values), out=np.full(D.shape, np.inf), where=values != 0)
    return values, np.where(size == 0, 0.0, errors)


# Discretization of state spaces with E singular or not: which inputs may be constant or linear between samples.

HOLDS = (0, 1, "impulse")

#: Each step of a delay is a state.
MOST_DELAYED = 2000


def discretized_system(
    system: StateEquations, step, hold: Hold = 1, delays: Mapping[str, float] | None = None
) -> DiscretizedSystem:
    """Discretize E x' = A x + B u, y = C x + D u; where E is singular, its finite Jordan pair and the polynomial part of G(s)."""
    step = Fraction(real_number(step, "step", positive=True))
    if isinstance(hold, bool) or hold not in HOLDS:
        raise InputError(f"hold: found {hold!r}; expected 0 (constant between samples), 1 (linear between samples) or 'impulse'")
    late = _delays(system, delays, step)
    n, nothing = len(system.A), np.zeros(system.D.shape)
    is_ordinary = bool((system.E == np.eye(n)).all())
    pairs = None if is_ordinary else system.polynomial_matrix().jordan_pairs()
    if pairs is None or not any(pairs.structure.infinite_divisors):
        _refuse_feedthrough(system, system.D, hold)
        E = None if is_ordinary else system.E
        return discretized(system.A, system.B, system.C, system.D, nothing, late, step, hold, E)
    polynomial = [through(system, order) for order in range(pairs.structure.highest_impulse + 1)] or [nothing]
    for order in range(len(polynomial) - 1, 0, -1):
        _refuse_impulses(system, polynomial[order], order, hold)
    D, slopes = system.D + polynomial[0], polynomial[1] if len(polynomial) > 1 else nothing
    _refuse_feedthrough(system, D, hold)
    finite = pairs.finite
    result = discretized(finite.J, finite.B @ system.B, system.C @ finite.C, D, slopes, late, step, hold)
    texts = (
        f'{system.outputs[i]}: the part that follows the derivative of "{system.inputs[j]}" is that just before each sample'
        for i, j in np.argwhere(slopes)
    )
    return replace(result, start_map=finite.B @ system.E, notices=tuple(Notice(NoticeKind.KINK, text) for text in texts))


def _refuse_impulses(system: StateEquations, factors: np.ndarray, order: int, hold) -> None:
    """Refuse outputs that follow a derivative of an input that is not smooth enough between samples."""
    if factors.any() and (hold != 1 or order > 1):
        i, j = np.argwhere(factors)[0]
        which = {1: "derivative", 2: "second derivative"}.get(order, f"derivative of order {order}")
        remedy = "give hold=1, or leave this output out" if order == 1 else "leave this output out"
        raise InputError(
            f'hold={hold!r}: the output "{system.outputs[i]}" follows the {which} of the input "{system.inputs[j]}", which has '
            f"Dirac impulses at the samples there; {remedy}"
        )


def _refuse_feedthrough(system: StateEquations, D: np.ndarray, hold) -> None:
    if hold == "impulse" and D.any():
        i, j = np.argwhere(D)[0]
        text = f'hold="impulse": the output "{system.outputs[i]}" follows the input "{system.inputs[j]}" itself'
        raise InputError(f"{text}, which is a train of Dirac impulses; leave this output out")


def _delays(system: StateEquations, delays: Mapping[str, float] | None, step: Fraction) -> list[Fraction]:
    """The delay of each input in s."""
    late = [Fraction(delay) for delay in delays_of_inputs(system, delays)]
    for name, delay in zip(system.inputs, late):
        if delay > MOST_DELAYED * step:
            raise InputError(
                f"delay of {name}: found {float(delay):g} s, which is more than {MOST_DELAYED} steps of {float(step):g} s, a state for each; "
                "give a larger step, or delay the input itself"
            )
    return late


# Transfer functions b(z)/a(z).

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
