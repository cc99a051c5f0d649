"""Proved bounds of variances under random excitation, for exact data.

With H = N / D in lowest terms, white or filtered noise of intensity G gives a rational number: G x_(n-1) / (2 d_n), where X of degree below n is
the solution of D(s) X(-s) + D(-s) X(s) = N(s) N(-s) (Newton, Gould and Kaiser, Analytical Design of Linear Feedback Controls, 1957, appendix E,
by one linear system). Between corner frequencies the integral of |H|^2 G is the sum over the poles p of H(s) H(-s) of its partial fractions r / (s - p)
times the integrals of f^a / (f - p / (2 pi i)): logarithms for whole a, else hypergeometric functions (NIST Digital Library of Mathematical Functions,
15.6.1). Multiple poles and coherent inputs take certified quadrature (Johansson, Mathematical Software, ICMS 2018). The variance is infinite where D, without what cancels in N, has a zero on the axis that the noise reaches, or to the right of it, and where
the degrees of N and D say so.
"""

from __future__ import annotations

import itertools
from functools import cached_property

import flint
import numpy as np

from ...exact.enclosure.intervals import Enclosure, bits_of, has_digits
from ...exact.rational import enclosed_roots, known_matrix, polynomial, rational, working_precision
from ...ground.checks import whole_number
from ...ground.errors import InputError
from ..harmonic import Harmonic
from .spectra import Line, PowerLaw, Rational, SpectralMatrix

#: Working precision in bits beyond the digits, in turn.
GUARDS = (96, 384, 1536)

#: Working precision in bits for covariances over time, in turn.
ROUNDED_BITS = (256, 512, 1024, 2048, 4096)

#: Evaluations of an integrand at most, for each piece.
EVALUATIONS = 200_000

#: Exponents of frequencies of at most this size have hypergeometric functions of few terms.
STEEPEST = 100

ZERO = flint.fmpq_poly([0])


def enclosed_variances(harmonic: Harmonic, spectra: SpectralMatrix, digits: int) -> Enclosure:
    """E[y^2] of each output."""
    digits, exact = whole_number(digits, "digits", minimum=1), ExactVariance(harmonic, spectra)
    balls = [exact.enclosed(output, digits) for output in range(len(harmonic.outputs))]
    for name, ball in zip(harmonic.output_names, balls):
        if ball is None:
            raise InputError(f'the variance of "{name}" is infinite; expected outputs of finite variance, see ``infinite``')
    return Enclosure.of(balls, np.array(0.0), digits)


class ExactVariance:
    """The variances of one random response."""

    def __init__(self, harmonic: Harmonic, spectra: SpectralMatrix):
        if harmonic.imaginary is not None:
            raise InputError(
                "enclose: not available with structural damping, which is no rational function of s; give viscous damping"
            )
        self.spectra, self.power = spectra, flint.fmpq_poly([0, 1]) ** harmonic.power
        matrix = known_matrix(harmonic.A)
        self.denominator = matrix.determinant
        self.outputs = [[rational(entry) for entry in row] for row in harmonic.outputs.tolist()]
        self.solutions = [matrix.numerators([polynomial([entry]) for entry in column]) for column in harmonic.inputs.T.tolist()]

    def numerators(self, output: int) -> list[flint.fmpq_poly]:
        """det A(s) H(s) from each input."""
        row = self.outputs[output]
        return [self.power * sum((c * N for c, N in zip(row, own) if c), ZERO) for own in self.solutions]

    def initial_numerators(self, harmonic: Harmonic, size: int) -> list[list[flint.fmpq_poly]]:
        """det A(s) times the transforms of the outputs from displacements, then velocities, of 1 at 0-, for each output a column."""
        matrix, columns = known_matrix(harmonic.A), []
        for order in range(2):
            for i in range(size):
                b = [
                    polynomial([A[row, i] for A in matrix.coefficients[order + 1 :]]) for row in range(matrix.size)
                ]  # the sum of A_j s^(j - 1 - order)
                solution = matrix.numerators(b)
                columns.append([self.power * sum((c * N for c, N in zip(row, solution) if c), ZERO) for row in self.outputs])
        return columns

    def enclosed(self, output: int, digits: int) -> flint.arb | None:
        """A ball with the requested digits; None where the variance is infinite."""
        numerators = self.numerators(output)
        for guard in GUARDS:
            with working_precision(bits_of(digits) + guard):
                parts = [self._of_group(group, numerators) for group in self.spectra.groups]
                if None in parts:
                    return None
                total = sum(parts, flint.arb(0))
                if has_digits(total, digits) or total == 0:
                    return total
        raise InputError(f"enclose: {digits} digits are not reached with {GUARDS[-1]} bits more; ask for fewer digits")

    def _of_group(self, group: list[int], numerators) -> flint.arb | None:
        """Contribution of coherent inputs."""
        spectra = self.spectra
        pieces = [spectra.spectra[i].pieces for i in group]
        is_delayed = any(i in group for pair in spectra.delayed_pairs for i in pair)
        if not is_delayed and all(own == pieces[0] for own in pieces) and (spectra.coherence[np.ix_(group, group)] == 1).all():
            first, total = group[0], sum((numerators[i] for i in group), ZERO)
            group, numerators = [first], [*numerators[:first], total, *numerators[first + 1 :]]
        corners = sorted({corner for i in group for corner in spectra.spectra[i].corners})
        if not corners or np.isfinite(corners[-1]):
            return self._of_tables(group, numerators, corners)
        if len(group) > 1 or len(pieces[0]) > 1:
            raise InputError(
                "enclose: coherent noise without a highest frequency is covered where its coherence is 1, without delays"
            )
        return self._of_filter(numerators[group[0]], pieces[0][0])

    def _of_filter(self, N: flint.fmpq_poly, piece: Rational | PowerLaw) -> flint.arb | None:
        if isinstance(piece, Rational):
            above, below, intensity = polynomial(piece.numerator[::-1]), polynomial(piece.denominator[::-1]), piece.intensity
        else:
            above, below, intensity = flint.fmpq_poly([1]), flint.fmpq_poly([1]), complex(piece.level).real
        own = _white_variance(N * above, self.denominator * below)
        return None if own is None else flint.arb(rational(float(intensity)) / 2 * own)

    def _of_tables(self, group: list[int], numerators, corners) -> flint.arb | None:
        total = flint.arb(0)
        fractions = {i: _Fraction(numerators[i], self.denominator) for i in group}
        for low, high in itertools.pairwise(corners):
            middle = (low + high) / 2
            pieces = {i: self.spectra.spectra[i].piece_at(middle) for i in group if fractions[i].N}
            chosen = {i: piece for i, piece in pieces.items() if piece is not None}
            if any(fractions[i].is_unstable or fractions[i].has_pole_between(low, high) for i in chosen):
                return None
            if chosen:
                total += self._integral(fractions, chosen, middle, low, high)
        return total

    def _integral(self, fractions: dict[int, _Fraction], chosen, middle: float, low: float, high: float) -> flint.arb:
        used = list(chosen)
        if not any(self._are_coherent(i, j) for i, j in itertools.combinations(used, 2)):
            each = [fractions[i].integral(chosen[i], low, high) for i in used]
            if None not in each:
                return sum(each, flint.arb(0))
        pairs = {i: (flint.acb_poly(fractions[i].N), flint.acb_poly(fractions[i].D)) for i in used}
        turn = flint.acb(0, 2) * flint.acb.pi()

        def integrand(f, analytic):
            s = turn * f
            values = {i: (pairs[i][0](s) / pairs[i][1](s), pairs[i][0](-s) / pairs[i][1](-s)) for i in used}
            own = {i: _density(chosen[i], f, analytic) for i in used}
            result = flint.acb(0)
            for i in used:
                result += values[i][0] * values[i][1] * own[i]
                for j in used[: used.index(i)]:
                    given = self._cross(i, j, own, f, middle, analytic)
                    if given is not None:
                        result += values[i][0] * values[j][1] * given[0] + values[j][0] * values[i][1] * given[1]
            return result

        ends = flint.acb(flint.arb(rational(low))), flint.acb(flint.arb(rational(high)))
        return flint.acb.integral(integrand, *ends, eval_limit=EVALUATIONS).real

    def _are_coherent(self, i: int, j: int) -> bool:
        return bool(self.spectra.coherence[i, j]) or (i, j) in self.spectra.cross or (j, i) in self.spectra.cross

    def _cross(self, i: int, j: int, own, f, middle: float, analytic):
        """S_ij and S_ji, or None where they vanish."""
        spectra = self.spectra
        given = spectra.cross.get((j, i))
        if given is not None:
            piece = given.piece_at(middle)
            return None if piece is None else (_density(piece, f, analytic, conjugate=True), _density(piece, f, analytic))
        if not spectra.coherence[i, j]:
            return None
        alike = spectra.spectra[i].pieces == spectra.spectra[j].pieces
        size = own[i] if alike else own[i].sqrt(analytic=analytic) * own[j].sqrt(analytic=analytic)
        shift = flint.arb(rational(float(spectra.delays[i]))) - flint.arb(rational(float(spectra.delays[j])))
        angle = (flint.acb(0, 2) * flint.acb.pi() * f * shift).exp()
        size *= flint.arb(rational(float(spectra.coherence[i, j])))
        return size / angle, size * angle


def covariances_over_time(
    harmonic: Harmonic, spectra: SpectralMatrix, times: np.ndarray, initial, terms: np.ndarray
) -> tuple[np.ndarray, np.ndarray] | None:
    """E[y y^T] after white or filtered noise is switched on, each entry to all digits of sqrt(E[y_a^2] E[y_b^2]).

    All transfer functions have one denominator D: h = c e^{A t} e_N with one companion matrix A, so that all covariances are those of one chain of
    integrators, c W c^T, W the integral of e^{A t} e_N e_N^T e^{A^T t}. It is computed as in ``frequency.random.nonstationary``, in balls.
    """
    exact, filters = ExactVariance(harmonic, spectra), [_filter(spectrum.pieces) for spectrum in spectra.spectra]
    common = flint.fmpq_poly([1])
    for _, below, _ in filters:
        common *= below // common.gcd(below)
    denominator = exact.denominator * common
    count = range(len(harmonic.outputs))
    rows = [[N * above * (common // below) for N, (above, below, _) in zip(exact.numerators(output), filters)] for output in count]
    if any(N.degree() >= denominator.degree() for row in rows for N in row):
        return None
    starts = [] if initial is None else exact.initial_numerators(harmonic, len(initial) // 2)
    free = [[N * common % denominator for N in row] for row in zip(*starts)]
    chain = _Chain(denominator)
    values, errors = np.zeros((2, len(times), len(count), len(count)))
    for place, time in enumerate(times.tolist()):
        for bits in ROUNDED_BITS:
            with working_precision(bits):
                C, F = chain.rows(rows), chain.rows(free)
                amplitudes = [flint.arb(rational(float(intensity))).sqrt() for *_, intensity in filters]
                S = [
                    [flint.arb(rational(float(spectra.coherence[i, j]))) * one * two / 2 for j, two in enumerate(amplitudes)]
                    for i, one in enumerate(amplitudes)
                ]
                total = flint.arb_mat(len(count), len(count))
                for number, (factor, rate) in enumerate(terms.tolist()):
                    E, W = chain.step(rational(time), rational(rate))
                    for i, j in itertools.product(range(len(filters)), repeat=2):
                        if S[i][j] != 0 and factor:
                            total += chain.of_input(C, i) * W * chain.of_input(C, j).transpose() * (S[i][j] * flint.arb(factor))
                    if not number and free:
                        given = flint.arb_mat(np.asarray(initial, dtype=float).tolist())
                        last = flint.arb_mat([[E[k, chain.size - 1]] for k in range(chain.size)])
                        T = flint.arb_mat([[(row * last)[0, 0] * flint.arb(chain.rate) for row in own] for own in F])
                        total += T * given * T.transpose()
                sizes = [total[k, k].abs_lower().sqrt() for k in count]
                certain = all(total[a, b].rad() * 2**56 <= sizes[a] * sizes[b] for a in count for b in count)
                if certain or bits == ROUNDED_BITS[-1]:
                    for a, b in itertools.product(count, repeat=2):
                        values[place, a, b] = float(total[a, b])
                        errors[place, a, b] = float((total[a, b] - values[place, a, b]).abs_upper())
                    break
    return values, errors


def _filter(pieces) -> tuple[flint.fmpq_poly, flint.fmpq_poly, float]:
    """Numerator, denominator and intensity of the filter that shapes a spectrum from white noise."""
    if not pieces:
        return flint.fmpq_poly([1]), flint.fmpq_poly([1]), 0.0
    if isinstance(pieces[0], PowerLaw):
        return flint.fmpq_poly([1]), flint.fmpq_poly([1]), complex(pieces[0].level).real
    return polynomial(pieces[0].numerator[::-1]), polynomial(pieces[0].denominator[::-1]), pieces[0].intensity


class _Chain:
    """x^(N) + d_(N-1) x^(N-1) + ... + d_0 x = w, D of degree N, in a unit of time without large coefficients."""

    def __init__(self, denominator: flint.fmpq_poly):
        self.size = denominator.degree()
        self.lead = denominator[self.size]
        own = [denominator[k] / self.lead for k in range(self.size)]
        exponents = [(abs(int(d.p)).bit_length() - int(d.q).bit_length() + 1) / (self.size - k) for k, d in enumerate(own) if d]
        self.rate = flint.fmpq(2) ** int(np.ceil(max(exponents, default=0.0)))
        self.coefficients = [d / self.rate ** (self.size - k) for k, d in enumerate(own)]

    def rows(self, numerators: list[list[flint.fmpq_poly]]) -> list[list[flint.arb_mat]]:
        """c of each N / D, at the working precision: states are derivatives in the own unit of time."""
        powers = [self.rate ** (k - self.size) for k in range(self.size)]
        return [
            [flint.arb_mat([[flint.arb(N[k] / self.lead * power) for k, power in enumerate(powers)]]) for N in own]
            for own in numerators
        ]

    @staticmethod
    def of_input(rows: list[list[flint.arb_mat]], number: int) -> flint.arb_mat:
        """c of all outputs from one input, shape (p, N)."""
        return flint.arb_mat([own[number].entries() for own in rows])

    def step(self, time: flint.fmpq, decay: flint.fmpq) -> tuple[flint.arb_mat, flint.arb_mat]:
        """e^{A t} in the scaled unit of time, and W with the modulation e^{-decay s}, both about the time t in s."""
        N, t, b = self.size, time * self.rate, decay / self.rate
        doublings = max(0, int(t).bit_length() + int(abs(b)).bit_length() + 2)
        h = t / flint.fmpq(2) ** doublings
        A = [[flint.fmpq(int(j == i + 1)) for j in range(N)] for i in range(N - 1)] + [[-d for d in self.coefficients]]
        shifted = [[a + (b / 2 if i == j else 0) for j, a in enumerate(row)] for i, row in enumerate(A)]
        rows = [row + [flint.fmpq(0)] * N for row in shifted]
        rows += [[flint.fmpq(0)] * N + [-shifted[j][i] for j in range(N)] for i in range(N)]
        rows[N - 1][2 * N - 1] = flint.fmpq(1)
        whole = (flint.arb_mat(flint.fmpq_mat(rows)) * flint.arb(h)).exp().tolist()
        E = flint.arb_mat([row[:N] for row in whole[:N]])
        W = flint.arb_mat([row[N:] for row in whole[:N]]) * E.transpose() * flint.arb(-b * h).exp()
        E = E * flint.arb(-b * h / 2).exp()
        for _ in range(doublings):
            W = W * flint.arb(-b * h).exp() + E * W * E.transpose()
            E, h = E * E, 2 * h
        return E, W * flint.arb(self.rate)


def _density(piece, f: flint.acb, analytic: bool, conjugate: bool = False) -> flint.acb:
    """G of a piece at a complex frequency, or the function that is its conjugate on the axis."""

    def number(value) -> flint.acb:
        return flint.acb(complex(value).conjugate() if conjugate else complex(value))  # exact

    if isinstance(piece, PowerLaw):
        if not piece.exponent:
            return number(piece.level)
        return number(piece.level) * (f / number(piece.lower)).pow(number(float(piece.exponent)), analytic=analytic)
    if isinstance(piece, Rational):
        s = flint.acb(0, 2) * flint.acb.pi() * f
        above, below = (flint.acb_poly(polynomial(part[::-1])) for part in (piece.numerator, piece.denominator))
        return number(piece.intensity) * above(s) * above(-s) / (below(s) * below(-s))
    part = (f - number(piece.lower)) / (number(piece.upper) - number(piece.lower))
    return number(piece.level) * (1 - part) + number(piece.end) * part


class _Fraction:
    """N / D in lowest terms, whose poles are enclosed once, at the working precision of the first use."""

    def __init__(self, N: flint.fmpq_poly, D: flint.fmpq_poly):
        common = N.gcd(D) if N else D
        self.N, self.D = N // common, D // common

    @cached_property
    def is_unstable(self) -> bool:
        """Whether a pole is to the right of the axis; those on the axis and their mirror images are common with D(-s)."""
        for factor in _factors(self.D):
            bits, undecided = 64, True
            while undecided:
                roots = enclosed_roots(factor, bits)
                if any(root.real > 0 for root in roots):
                    return True
                bits, undecided = 2 * bits, not all(root.real < 0 or root.real == 0 for root in roots)
        return False

    @cached_property
    def _on_axis(self) -> list[flint.arb]:
        """The poles on the axis as frequencies in Hz."""
        roots = (root for factor in _factors(self.D.gcd(_mirrored(self.D))) for root in enclosed_roots(factor, 256))
        return [root.imag / (2 * flint.arb.pi()) for root in roots if root.real == 0]

    def has_pole_between(self, low: float, high: float) -> bool:
        """Whether a pole is on the axis between two frequencies in Hz."""
        return any(f >= flint.arb(rational(low)) and f <= flint.arb(rational(high)) for f in self._on_axis)

    @cached_property
    def _expansion(self) -> tuple[int, flint.fmpq_poly, list[tuple[flint.acb, flint.acb]]] | None:
        """|N / D|^2 in f: the order of a pole at zero, the polynomial part, and poles with residues; None where others are multiple."""
        at_zero = next(k for k, coefficient in enumerate(self.D.coeffs()) if coefficient)
        D = self.D // flint.fmpq_poly([0, 1]) ** at_zero
        opposite, slope = _mirrored(D), D.derivative()
        if D.gcd(slope).degree() > 0 or D.gcd(opposite).degree() > 0:
            return None
        whole, rest = divmod(self.N * _mirrored(self.N), D * opposite)
        above, below, turn = (
            flint.acb_poly(rest),
            flint.acb_poly(slope) * flint.acb_poly(opposite),
            flint.acb(0, 2) * flint.acb.pi(),
        )
        poles = [p for factor in _factors(D) for p in enclosed_roots(factor, flint.ctx.prec)]
        return at_zero, whole, [(p / turn, above(p) / (below(p) * turn)) for p in poles]

    def integral(self, piece, low: float, high: float) -> flint.arb | None:
        """The integral of |N / D|^2 G between two frequencies; None for multiple poles off zero, rational spectra and steep edges."""
        if isinstance(piece, Rational) or abs(getattr(piece, "exponent", 0.0)) > STEEPEST or self._expansion is None:
            return None
        (at_zero, whole, poles), turn = self._expansion, flint.acb(0, 2) * flint.acb.pi()
        a, b = (flint.arb(rational(end)) for end in (low, high))
        powers = [(c / turn.imag ** (2 * at_zero), e - 2 * at_zero) for c, e in _powers(piece)]
        total = flint.arb(0)
        for k, coefficient in enumerate(whole.coeffs()):  # zero for odd k
            total += (turn**k * coefficient).real * sum((c * _of_power(e + k, a, b) for c, e in powers), flint.arb(0))
        for pole, residue in poles:
            total += 2 * (residue * sum((c * _of_fraction(e, pole, a, b) for c, e in powers), flint.acb(0))).real
        return total if total.is_finite() else None


def _powers(piece: PowerLaw | Line) -> list[tuple[flint.arb, flint.fmpq]]:
    """Coefficients c and exponents e of G = sum of c f^e."""
    lower, level = rational(float(piece.lower)), rational(float(complex(piece.level).real))
    if isinstance(piece, PowerLaw):
        exponent = rational(float(piece.exponent))
        return [(flint.arb(level) / (flint.arb(lower) ** flint.arb(exponent) if exponent else 1), exponent)]
    slope = (rational(float(complex(piece.end).real)) - level) / (rational(float(piece.upper)) - lower)
    return [(flint.arb(level - slope * lower), flint.fmpq(0)), (flint.arb(slope), flint.fmpq(1))]


def _of_power(exponent: flint.fmpq, a: flint.arb, b: flint.arb) -> flint.arb:
    """The integral of f^e from a to b."""
    if exponent == -1:
        return (b / a).log()
    return (b ** flint.arb(exponent + 1) - a ** flint.arb(exponent + 1)) / flint.arb(exponent + 1)


def _of_fraction(exponent: flint.fmpq, pole: flint.acb, a: flint.arb, b: flint.arb) -> flint.acb:
    """The integral of f^e / (f - pole) from a to b for a pole off the way; its angle seen from the pole is below pi."""
    if exponent.q == 1:
        n = int(exponent.p)
        between = sum((pole ** (n - 1 - k) * _of_power(flint.fmpq(k), a, b) for k in range(min(n, 0), max(n, 0))), flint.acb(0))
        return pole**n * ((b - pole) / (a - pole)).log() + (between if n > 0 else -between)
    e = flint.acb(exponent)
    ends = [flint.acb(f) ** (e + 1) * (f / pole).hypgeom_2f1(flint.acb(1), e + 1, e + 2) for f in (a, b)]
    return (ends[0] - ends[1]) / ((e + 1) * pole)


def _mirrored(p: flint.fmpq_poly) -> flint.fmpq_poly:
    return flint.fmpq_poly([(-1) ** k * c for k, c in enumerate(p.coeffs())])


def _factors(p: flint.fmpq_poly) -> list[flint.fmpz_poly]:
    """The distinct irreducible factors."""
    return [factor for factor, _ in flint.fmpz_poly([int(c.p) for c in (p * p.denom()).coeffs()]).factor()[1]]


def _white_variance(N: flint.fmpq_poly, D: flint.fmpq_poly) -> flint.fmpq | None:
    """The integral of |N / D|^2 over -infinity < f < infinity; None where it is infinite."""
    fraction = _Fraction(N, D)
    N, D = fraction.N, fraction.D
    n = D.degree()
    if not N:
        return flint.fmpq(0)
    if N.degree() >= n or D.gcd(_mirrored(D)).degree() > 0 or fraction.is_unstable:
        return None
    below, square = D.coeffs(), (N * _mirrored(N)).coeffs()
    rows = [[flint.fmpq(0)] * n for _ in range(n)]
    for k in range(n):  # the coefficients of s^(2 k)
        for j in range(n):
            if 0 <= 2 * k - j <= n:
                rows[k][j] = 2 * (-1) ** j * below[2 * k - j]
    right = [[square[2 * k] if 2 * k < len(square) else flint.fmpq(0)] for k in range(n)]
    X = flint.fmpq_mat(rows).solve(flint.fmpq_mat(right))
    return X[n - 1, 0] / below[n]
