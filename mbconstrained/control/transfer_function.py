"""Responses of b(s)/a(s) to the inputs I_gamma of Hauksdottir and Sigurdsson, for every integer gamma, and to any other input.

A view for study and comparison. The modes cancel where the response is small: in their example (47) with I_3 no digit is
left at t = 0.01. ``mb.transfer_function_response`` computes the same responses without this cancellation.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property, lru_cache
from math import ceil, comb, factorial
from typing import TYPE_CHECKING

import numpy as np
import scipy.linalg

from ..frequency.frequency_response import FrequencyResponse, evaluated
from ..frequency.harmonic import Harmonic
from ..ground.by_name import answering
from ..ground.checks import real_array, real_number
from ..ground.errors import InputError, Overflow
from ..ground.notices import Notice, NoticeKind
from ..ground.tolerances import EARLY_ERROR, EPS, PROBE_SIZE, rounding_radius
from ..linalg.arrays import block_diag
from ..linalg.blocks import eigenvalues
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..polynomial.structure import FiniteZero, polynomial_text
from ..response.estimate import TRIALS
from ..response.methods.pair_solution import ResponseFunction
from ..response.problem import MOVES, Problem
from ..response.response import Response, moved_responses
from ..response.response_notices import response_notices
from ..response.solve import solve
from ..signals.impulsive import ImpulsiveSmooth
from .rational import ONE, Polynomial, RationalFunction, checked_input, rational_function, scalar_force, scalar_matrix

if TYPE_CHECKING:
    from ..exact.enclosure.exact_response import ExactResponse


@dataclass(frozen=True, eq=False)
class ResidueSum:
    """y(t) = Re(transient^T E(t)) + sum of forced[k] I_(k+1)(t), for t > 0, and impulses at t = 0 (Theorems 1 and 2)."""

    form: ResidueForm  # the closed form that it belongs to
    transient: np.ndarray  # the row in front of E(t), Eq. (48), shape (n,), complex
    forced: np.ndarray  # the factors of I_1, I_2, ..., Eq. (49)
    impulses: np.ndarray  # the factors of Dirac's delta and of its derivatives, Eq. (50), corrected: I_0, I_-1, ...

    def __call__(self, times) -> np.ndarray:
        """The regular part at a time (-> a number) or at times (T,) (-> (T,))."""
        times = real_array(times, "time")
        powers = sum((c * times**k / factorial(k) for k, c in enumerate(self.forced)), np.zeros(times.shape))
        return (self.transient @ self.form.exponentials(times)).real + powers


@dataclass(frozen=True, eq=False)
class ResidueForm:
    """Poles, kappa, J, E(t) of a(s) and what responses are made of them.

    >>> form = ResidueForm(np.array([1.0]), np.array([-1.0, -2.0]), (1, 1), 0)  # 1 / ((s + 1)(s + 2))
    >>> form.kappa.real.tolist(), float(form.fundamental_solution(0.0)), form.general_response(1).forced.round(12).tolist()
    ([1.0, -1.0], 0.0, [0.5])
    """

    numerator: np.ndarray  # b_0 ... b_m, divided by a_n, shape (m + 1,)
    poles: np.ndarray  # the different poles other than 0, complex, those of a pair side by side
    multiplicities: tuple[int, ...]  # d_i of each
    zero_poles: int  # n0, the order of the pole at s = 0 (Eq. 34)

    @staticmethod
    def of(numerator: np.ndarray, zeros: Sequence[FiniteZero], zero_poles: int) -> ResidueForm:
        """The form of b(s)/a(s) from b/a_n, the zeros of a(s) other than 0, and the order n0 of the pole at s = 0."""
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
        return block_diag(*blocks)

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
        """y_f^(order)(t) = (J^order kappa)^T E(t), Eqs. (40), (44); below order 0 the integral without polynomial part."""
        return (self.rows(order, 1) @ self.exponentials(times).reshape(self.order, -1)).real.reshape(np.shape(times))

    def at_zero(self, first: int, count: int) -> np.ndarray:
        """y_f^(j)(0) for j = first ... first + count - 1, Eq. (29) at t = 0, shape (count,); those of Eq. (13) exactly."""
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


# A response from rest while it is small: by the exact engine, where its modes cancel beyond the digits of float64.

#: The least normal number of float64.
TINY = float(np.finfo(float).tiny)

#: After b(s)/a(s) has begun like t^p it stays far below its modes for a while: |s| t, s the largest pole, up to which it may.
REACH = 90.0

#: The errors of the sum of modes are measured at so many times per factor of two, over at most so many factors of two.
PLACES, OCTAVES = 2, 24


@lru_cache(maxsize=64)
def exact_response(fraction: RationalFunction, gamma: int) -> ExactResponse:
    """The exact response of b(s)/a(s) to I_gamma, kept for further times."""
    from ..exact.enclosure.exact_response import exact_fraction_response

    return exact_fraction_response(fraction.numerator, fraction.denominator, gamma)


@dataclass(frozen=True, repr=False)
class ExactStart(ResponseFunction):
    """The response of b(s)/a(s) to I_gamma, or a derivative of it, evaluated with as many digits as its smallness requires."""

    fraction: RationalFunction  # b(s)/a(s)
    gamma: int
    order: int = 0  # of the derivative

    def _values(self, times) -> np.ndarray:
        """Values, from the exact engine where the modes cancel."""
        values = super()._values(times)
        at = np.flatnonzero((times > 0) & (times <= self._reach))
        if len(at):
            at = at[self._errors(times[at]) > EARLY_ERROR * np.abs(values[0, at])]
            values[:, at] = self._exact(times[at])
        return values

    @property
    def summed_from(self) -> np.ndarray:
        """First time of evaluation by modes alone."""
        return np.maximum(self.switch, self._reach)

    def derivative(self, order: int = 1) -> ExactStart:
        """The classical derivative."""
        return with_exact_start(super().derivative(order), self.fraction, self.gamma, self.order + order)

    def _errors(self, times) -> np.ndarray:
        """Approximate errors without the exact engine: the noise of the float64 series, then the measured errors of the modes."""
        by_series = times < self.switch[0]
        noise = self.series.noise_at(np.where(by_series, times, 0.0))[0]
        places, errors = self._measured
        after = np.searchsorted(places, times).clip(1, len(places) - 1)
        return np.where(by_series, noise, np.maximum(errors[after - 1], errors[after]))

    @cached_property
    def _measured(self) -> tuple[np.ndarray, np.ndarray]:
        """Times, ascending, and the errors of the sum of modes there."""
        octaves = np.log2(self._reach / max(self.switch[0], self._reach / 2**OCTAVES))
        places = self._reach * 2.0 ** -(np.arange(ceil(octaves * PLACES), -1, -1) / PLACES)
        with np.errstate(over="ignore", invalid="ignore"):  # what leaves the range is no number that could be compared
            errors = np.nan_to_num(np.abs(super()._values(places) - self._exact(places))[0], nan=0.0, posinf=np.inf)
        return np.append(0.0, places), np.append(errors[0], errors)

    def _exact(self, times) -> np.ndarray:
        return exact_response(self.fraction, self.gamma).rounded(times, self.order)[0]

    @cached_property
    def _reach(self) -> float:
        """In s; zero without poles other than s = 0, whose modes are powers of t."""
        largest = max((float(np.abs(eigenvalues(block)).max()) for block in self.blocks), default=0.0)
        return REACH / largest if largest else 0.0


def with_exact_start(function: ResponseFunction, fraction: RationalFunction, gamma: int, order: int = 0) -> ExactStart:
    """A function of modes whose values are exact where they cancel."""
    return ExactStart(function.coefficients, function.blocks, function.start, function.series, fraction, int(gamma), order)


def exact_start(fraction: RationalFunction, gamma: int) -> tuple[np.ndarray, tuple[np.ndarray, ...], bool]:
    """Values at 0+ as rows and impulses of a response, and whether float64 has them all."""
    x = exact_response(fraction, gamma)
    given = x.start, *x.impulses
    try:
        start, *impulses = (part.astype(float) for part in given)
    except OverflowError:
        raise Overflow("the jumps or impulses at t = 0 are beyond the range of float64; choose another unit of time") from None
    in_range = all((np.abs(part) >= TINY)[exact != 0].all() for part, exact in zip((start, *impulses), given))
    return start, tuple(impulses), in_range


#: With more impulses than this in its force a response is computed from its values at 0+: Laurent coefficients take long.
MOST_IMPULSES = 24


@dataclass(frozen=True, repr=False, eq=False)
class TransferFunctionResponse(Response):
    """y with a(d/dt) y = b(d/dt) u from rest, a ``Response`` with the one row y.

    The objects of Hauksdottir and Sigurdsson belong to it: ``fundamental_solution`` y_f, ``basic_response`` y_b,gamma,
    ``with_input`` for other gamma, and ``residue_form``, their sums of modes. They are computed when first used; y itself comes from
    ``mb.solve``, and while it is small, where the sums of modes cancel, from the exact engine.

    Attributes:
        fraction: b(s)/a(s), exactly.
        gamma: of the input I_gamma, or the input itself.
    """

    fraction: RationalFunction = field(kw_only=True)
    gamma: int | ImpulsiveSmooth = field(kw_only=True)

    @property
    def numerator(self) -> Polynomial:
        """b as given, Fractions, the highest power first; (0,) where it is zero."""
        return self.fraction.numerator[::-1] or (0 * ONE[0],)

    @property
    def denominator(self) -> Polynomial:
        """a as given, Fractions, the highest power first."""
        return self.fraction.denominator[::-1]

    def frequency_response(self, frequencies_hz="auto", *, delay: float = 0.0) -> FrequencyResponse:
        """Return the frequency response b(i w) / a(i w), without the common factor, with poles, residues, peaks and antiresonances.

        Args:
            frequencies_hz: in Hz, shape (F,), or "auto", placed by the poles.
            delay: dead time of the input in s, a factor e^(-i w delay); the response over time has it in a delayed input.

        Returns:
            A ``FrequencyResponse`` of one output and one input.

        Raises:
            InputError: a negative delay, frequencies that are negative or not finite.

        >>> transfer_function_response([1], [1, 2, 1]).frequency_response([0.0]).values.item()
        (1+0j)
        """
        reduced = self.fraction.reduced
        b, a = ([float(c) for c in polynomial] for polynomial in (reduced.numerator, reduced.denominator))
        coefficients = np.zeros((max(len(a), len(b), 1), 2, 2))  # a y = b v, v = u
        coefficients[: len(a), 0, 0], coefficients[: len(b), 0, 1], coefficients[0, 1, 1] = a, np.negative(b), 1.0
        A, names = PolynomialMatrix(coefficients), dict(input_names=("u",), output_names=("y",))
        late = real_number(delay, "delay", minimum=0.0)
        harmonic = Harmonic(A, np.eye(2)[:, 1:], np.eye(2)[:1], **names, quantity="transfer function")
        return evaluated(replace(harmonic, input_delays=(late,) if late else ()), frequencies_hz)

    @property
    def common_factor(self) -> Polynomial:
        """The common factor of b and a, the highest power first; (1,) if there is none.

        It leaves the response from rest exactly, and so it is left out of what is computed: the rounding error of a growing common
        factor would not. ``notices`` reports it.
        """
        return self.fraction.common_factor[::-1]

    def with_input(self, gamma: int | ImpulsiveSmooth) -> TransferFunctionResponse:
        """Return the response y_gamma of the system to another input; by (8) y_(gamma+1)' = y_gamma."""
        return _response(self.fraction, gamma)

    def basic_response(self, gamma: int | ImpulsiveSmooth | None = None) -> TransferFunctionResponse:
        """Return y_b,gamma of Theorem 1, Eq. (28): numerator one, denominator divided by a_n, this gamma by default.

        >>> y = transfer_function_response([3.0], [2.0, 2.0])  # 2 y' + 2 y = 3, y_b' + y_b = 1
        >>> y(1.0) / y.basic_response()(1.0)
        array([1.5])
        """
        a = self.fraction.denominator
        return _response(RationalFunction((a[-1],), a, rounded=self.fraction.rounded), self.gamma if gamma is None else gamma)

    @cached_property
    def basic_responses(self) -> tuple[TransferFunctionResponse, ...]:
        """y_b,(gamma - l) for l = 0 ... m: y is the sum of b_l / a_n times these (Eq. 32).

        Raises:
            InputError: the input is none of the I_gamma.
        """
        gamma = self._gamma("the basic responses belong to")
        return tuple(self.basic_response(gamma - l) for l in range(len(self.numerator)))

    @cached_property
    def fundamental_solution(self) -> Response:
        """y_f with a(d/dt) y_f = 0 from zeros and y_f^(n-1)(0) = 1 (Eqs. 12, 13), poles at s = 0 left out of a (Eq. 34).

        It and its derivatives are accurate just after t = 0 too. Integrals y_f^(-gamma) have no polynomial part; they are in
        ``residue_form``.

        Raises:
            InputError: a(s) has no other poles than s = 0: there is nothing fundamental, the response is Eq. (35).
        """
        a = self.fraction.denominator[self.fraction.zero_poles :]
        if len(a) == 1:
            raise InputError("denominator: it has no poles but s = 0; a fundamental solution needs others (see Eq. 35)")
        return solve(scalar_matrix(a), np.eye(1, len(a) - 1, len(a) - 2).T)

    @cached_property
    def residue_form(self) -> ResidueForm:
        """kappa, J, E(t) and the sums of modes of the paper, Eqs. (28)-(53): for study, and for times that are not small."""
        fraction = self.fraction
        a = fraction.denominator[fraction.zero_poles :]
        zeros = scalar_matrix(a, fraction.rounded).structure().finite_zeros if len(a) > 1 else ()
        return ResidueForm.of(np.array([float(b / a[-1]) for b in fraction.numerator] or [0.0]), zeros, fraction.zero_poles)

    def expression(self, t=None):
        """y(t) for t >= 0 as a SymPy expression, its impulses as DiracDelta; for t < 0 it is zero.

        Sums of t^k e^{at} (cos wt, sin wt). Rational poles and pairs of quadratic factors are exact, others numbers of 30
        digits. A float stands for the shortest decimal that it is written as: 0.1 for 1/10.

        Args:
            t: a sympy.Symbol; None for a real one called t.

        Returns:
            A sympy.Expr.

        Raises:
            InputError: the input is none of the I_gamma; add expressions for a sum of them.
        """
        from ..exact.symbolic.symbolic_response import time_expression

        fraction = self.fraction.written_reduced
        return time_expression(fraction.numerator, fraction.denominator, self._gamma("an expression is made for"), t)

    @cached_property
    def exact(self) -> ExactResponse:
        """The exact answer for b and a as given, without their common factor."""
        fraction, gamma = self.fraction.reduced, self.gamma
        if not isinstance(gamma, ImpulsiveSmooth):
            return exact_response(*fraction.without_zero_poles(gamma))
        from ..exact.enclosure.exact_response import exact_fraction_response

        return exact_fraction_response(fraction.numerator, fraction.denominator, gamma)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on omitted coefficients, and those of the response."""
        return (*self.fraction.notices, *_growth_left_out(self.fraction), *response_notices(self))

    @cached_property
    def _moved(self) -> tuple[Response, ...]:
        """Solutions of the problem with data perturbed by about a rounding error, exact where modes cancel, too."""
        if isinstance(self.gamma, ImpulsiveSmooth):
            return moved_responses(self)
        trials = [_moved(self.fraction.reduced, np.random.default_rng(seed)) for seed in range(TRIALS)]
        return tuple(_response(fraction, self.gamma) for fraction in trials)

    def _gamma(self, what: str) -> int:
        if isinstance(self.gamma, ImpulsiveSmooth):
            raise InputError(f"gamma: {what} the inputs I_gamma, gamma a whole number; this response has another input")
        return self.gamma


@answering
def transfer_function_response(numerator, denominator, gamma: int | ImpulsiveSmooth = 1) -> TransferFunctionResponse:
    """Solve a(d/dt) y = b(d/dt) u from rest, u = I_gamma (Hauksdottir and Sigurdsson, Theorem 2).

    I_1 is the step, I_2 the ramp, I_3 the parabola t^2/2, I_0 Dirac's impulse and I_-k its k-th derivative. Poles may be
    real, complex, repeated, zero or unstable, b may be of any degree: where y has Dirac impulses they are in ``impulses``. A
    factor that b and a have in common exactly leaves the response, as in (2), and is reported in ``notices``; its zeros are not in ``pairs``. For I_gamma powers of s in a and b are taken into the input, gamma + n0 as in (34): what of them cancels is gone
    exactly, and ``polynomial_matrix`` has no zeros at 0. The engine solves A(s) = a(s) with the force b(d/dt) u, and no modes
    cancel where y is small.

    Args:
        numerator, denominator: b and a, highest power first as in scipy.signal. Whole numbers, Fractions and Decimals are taken
            exactly, other floats as known to a rounding error.
        gamma: a whole number, or an input with one row (``mb.harmonic``, sums of ``mb.power``, ...).

    Returns:
        y, one row.

    Raises:
        InputError: coefficients that are missing, not real or not finite, a denominator that is zero, an input that is none.

    >>> y = transfer_function_response([1], [1, 2, 1])  # step response of 1 / (s + 1)^2
    >>> bool(np.isclose(y(2.0)[0], 1 - 3 * np.exp(-2)))
    True
    >>> transfer_function_response([1, 0, 0], [1, 1], 0).impulses  # s^2 / (s + 1) = s - 1 + 1 / (s + 1)
    (array([-1.]), array([1.]))
    """
    return _response(rational_function(numerator, denominator), gamma)


def _response(fraction: RationalFunction, gamma) -> TransferFunctionResponse:
    u, reduced = _checked_gamma(gamma), fraction.reduced
    if isinstance(u, ImpulsiveSmooth):
        x = solve(scalar_matrix(reduced.denominator), force=scalar_force(reduced.numerator, u))
    else:
        x = _from_exact_start(*reduced.without_zero_poles(u))
    return TransferFunctionResponse(x.problem, x.solution, fraction=fraction, gamma=u)


def _from_exact_start(fraction: RationalFunction, gamma: int) -> Response:
    """The response with exact effects of the force's impulses at 0, and the resulting states of each mode.

    The values at 0+ are sums over all modes: those of fast modes would hide the digits of slow ones.
    """
    A, force = scalar_matrix(fraction.denominator), scalar_force(fraction.numerator, gamma)
    jump, impulses, in_range = exact_start(fraction, gamma)
    many = len(force.impulses) > MOST_IMPULSES
    x = solve(A, jump, ImpulsiveSmooth(force.smooth)) if many and in_range else solve(A, force=force)
    own = x.solution.function
    function = with_exact_start(own, fraction, gamma) if fraction.numerator else own
    solution = replace(x.solution, function=function, jump=jump, impulses=impulses)
    return Response(Problem(A, np.zeros_like(jump), force), solution)


def _growth_left_out(fraction: RationalFunction) -> Iterator[Notice]:
    """Growth of the cancelled common factor, absent from a response from rest."""
    factor = fraction.common_factor
    zeros = scalar_matrix(factor, fraction.rounded).structure().finite_zeros if len(factor) > 1 else ()
    if any(zero.value.real > rounding_radius(zero.multiplicity) * abs(zero.value) for zero in zeros):
        text = "has a zero in the right half plane: from any start but rest that motion grows"
        yield Notice(NoticeKind.UNSTABLE, f"the common factor {polynomial_text(factor)} {text}")


def _checked_gamma(gamma) -> int | ImpulsiveSmooth:
    if isinstance(gamma, ImpulsiveSmooth):
        return checked_input(gamma, 1, "gamma")
    if isinstance(gamma, bool) or not isinstance(gamma, (int, np.integer)):
        raise InputError(f"gamma: found {gamma!r}; expected a whole number, of the input I_gamma, or an input with one row")
    return int(gamma)


def _moved(fraction: RationalFunction, random) -> RationalFunction:
    """All coefficients perturbed by about a unit in the last place."""
    numerator, denominator = (
        tuple(c * (1 + Fraction(PROBE_SIZE * EPS * random.choice(MOVES))) for c in polynomial)
        for polynomial in (fraction.numerator, fraction.denominator)
    )
    return RationalFunction(numerator, denominator, rounded=fraction.rounded)
