"""Integrals of a transfer function over a spectrum, by residues of its poles."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...ground.errors import Overflow
from ...ground.tolerances import CLUSTER_SAFETY, EPS, FORM_ROUNDING, LIGHT_DAMPING, NOISE_SAFETY, SPECTRAL_ACCURACY, UNDAMPED
from ...ground.tolerances import STEP_AGREEMENT as MARGIN
from ...linalg import precise
from ...linalg.division import accurate_product
from ...linalg.double_double import DoubleDouble
from ...polynomial.characteristic_roots import CharacteristicRoots, rightmost_roots
from ...polynomial.structure import FiniteZero
from ..features import ROOTS
from ..frequency_response import NOISE
from ..harmonic import Harmonic
from ..pole_residue_form import Pole, is_on_axis
from .spectra import SpectralMatrix

#: Terms of rounding errors of the entries that are computed at once.
MOST_TERMS = 1 << 20

#: Slices of matrices whose small entries count next to large ones of their rows.
MOST_SLICES = 8

# H(f) with refined poles: the real part of a pole near the axis is the damping, and needs its own relative accuracy.


@dataclass(frozen=True, eq=False)
class RefinedPole(Pole):
    """A pole p = sigma + i w of H(s), with sigma accurate relative to itself."""

    on_axis: bool  # whether sigma is zero
    sizes: (
        np.ndarray
    )  # of terms that residues are sums of; some of their rounding errors are errors of the residues, shape (order, p, m)

    @property
    def frequency(self) -> complex:
        """p / (2 pi i): a complex frequency in Hz, above the real axis where the pole is stable."""
        return complex(self.value.imag, -self.value.real) / (2 * np.pi)


class SpectralTransfer:
    """The values, poles and residues of s^p C A(s)^-1 B on the positive frequency axis."""

    is_finer = False  # with True all panels are halved

    @property
    def widest(self) -> float:
        """The widest panel in Hz."""
        return np.inf

    def __init__(self, harmonic: Harmonic):
        """Create the transfer function from the matrices of one response."""
        self.harmonic = harmonic

    @cached_property
    def poles(self) -> tuple[RefinedPole, ...]:
        """All poles with their conjugates; the real parts of lightly damped ones are refined by Newton's method.

        One step from p with the null vectors x and y of A(p), y^T A'(p) x = 1, is -y^T A(p) x: its error is a product of the errors of both vectors
        where the sum is computed in extended precision.
        """
        poles = self.harmonic.form.poles
        light = (one.zero for one in poles if one.order == 1 and one.value and abs(one.value.real) < LIGHT_DAMPING * abs(one.value))
        steps, sizes, result = self._newton_steps(list(dict.fromkeys(light))), {}, []
        for pole in poles:
            value, zero = pole.value, pole.zero
            if zero not in sizes:
                sizes[zero] = self._sizes(zero)
            if pole.order == 1 and zero in steps:
                step, doubt = steps[zero]
                value += step if value == zero.value else step.conjugate()
                on_axis = not value or abs(value.real) <= max(UNDAMPED * abs(pole.value), doubt)
            else:
                on_axis = not value or is_on_axis(pole)
            own = sizes[zero][: pole.order]
            residues = _without_noise(pole.residues, own) if on_axis else pole.residues
            result.append(RefinedPole(complex(0.0 if on_axis else value.real, value.imag), residues, zero, on_axis, own))
        return tuple(result)

    def _sizes(self, zero: FiniteZero) -> np.ndarray:
        """Scales of residues, attained by modes whose largest entries are at input and output, shape (order, p, m)."""
        form = self.harmonic.form
        pair, scaling = form.pairs.finite, form.pairs.form.companion.scaling
        at, right, J, left = form.subspaces[zero]
        X, Y = np.abs(pair.C[:, at] @ right) / scaling.columns[:, None], np.abs(left @ pair.B[at]) / scaling.rows
        front, N = np.linalg.matrix_power(J, form.power), J - zero.value * np.eye(len(J))
        powers = [np.abs(front @ np.linalg.matrix_power(N, j)) for j in range(max(zero.partial_multiplicities, default=1))]
        size = np.array([X.max(axis=0) @ middle @ Y.max(axis=1) for middle in powers])
        limit = np.outer(np.abs(form.outputs) @ scaling.columns, scaling.rows @ np.abs(form.inputs))
        return size[:, None, None] * limit

    def _newton_steps(self, zeros: list[FiniteZero]) -> dict[FiniteZero, tuple[complex, float]]:
        """Newton steps -mean(diag Y^T A(p) X) of poles with vectors X and Y, and the effect of rounding errors of A on real parts.

        An entry of A_k adds Re(p^k y_i x_j) times its error: those of mass and stiffness nothing to an undamped motion.
        """
        if not zeros:
            return {}
        form = self.harmonic.form
        pair, coefficients = form.pairs.finite, self.harmonic.real[0].coefficients
        columns, rows, owner = [], [], []
        for number, zero in enumerate(zeros):
            places, right, _, left = form.subspaces[zero]
            columns += list((pair.C[:, places] @ right).T)
            rows += list(left @ pair.B[places])
            owner += [number] * zero.multiplicity
        X, Y, of = np.array(columns).T, np.array(rows), np.array(owner)
        p = np.array([zero.value for zero in zeros])[of]
        residuals = _bilinear(coefficients, X, Y, p)
        sizes = self.harmonic.sizes if self.harmonic.imaginary is None else None
        doubts = np.zeros(len(p))
        for k, A in enumerate(np.abs(coefficients) if sizes is None else sizes):
            row, column = np.nonzero(A)
            for part in np.array_split(np.arange(len(p)), -(-len(p) * len(row) // MOST_TERMS) or 1):
                doubts[part] += A[row, column] @ np.abs((p[part] ** k * Y[part].T[row] * X[column][:, part]).real)
        return {zero: (-residuals[of == k].mean(), float(EPS * doubts[of == k].max())) for k, zero in enumerate(zeros)}

    @cached_property
    def polynomial(self) -> np.ndarray:
        """The polynomial part of H without rounding errors of the transformations in zero entries, shape (K, p, m).

        D_k with k < power is C T^j B in the orthogonal basis of the finite part: rows of B that are zero there are rounding errors of the whole.
        """
        form, D = self.harmonic.form, self.harmonic.form.polynomial.copy()
        finite, scaling = form.pairs.form, form.pairs.form.companion.scaling
        largest = np.abs(finite.B).max(initial=0.0) * (scaling.rows @ np.abs(form.inputs))
        left = (np.abs(form.outputs) * scaling.columns) @ np.abs(finite.C)
        for k in range(min(form.power, len(D)) - 1, -1, -1):
            index = k - form.power
            size = left @ np.linalg.matrix_power(np.abs(finite.T), -index - 1)
            limit = NOISE_SAFETY * EPS * np.outer(size.sum(axis=1), largest) / scaling.time ** float(index)
            D[k] = np.where(np.abs(D[k]) > limit, D[k], 0.0)
        return D

    @cached_property
    def seems_zero(self) -> np.ndarray:
        """Which outputs have rounding errors as residues and no polynomial part, shape (p,)."""
        parts = [_without_noise(pole.residues, pole.sizes) for pole in self.poles] + [self.polynomial]
        return np.all([~part.any(axis=(0, 2)) for part in parts], axis=0)

    @cached_property
    def vanishes(self) -> np.ndarray:
        """Which outputs no input excites, shape (p,): decided from the data where the equations are not too large."""
        own, zero = self.harmonic, self.seems_zero
        if not zero.any() or own.imaginary is not None or np.iscomplexobj(own.outputs):
            return zero
        known = precise.zero_transfers(own.real[0].coefficients, own.inputs, own.outputs)
        return zero if known is None else zero & known.all(axis=1)

    def of_inputs(self, chosen: list[int]) -> SpectralTransfer:
        """The transfer function from some of the inputs."""
        own = self.harmonic
        names = tuple(own.input_names[i] for i in chosen)
        return SpectralTransfer(replace(own, inputs=own.inputs[:, chosen], input_names=names))

    def values(self, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """H by the sum of its terms at real frequencies in Hz, and estimates of the absolute errors, both of shape (p, m, F)."""
        H, sizes = self.harmonic.form.values(2j * np.pi * f)
        return H, NOISE * sizes

    def solved(self, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """H by solutions of A(i w) X = B, and estimates of the absolute errors, both of shape (p, m, F)."""
        omega = 8 * np.arctan(np.longdouble(1)) * f
        lines = self.harmonic.solver.solve(omega)
        powers = (1j * omega.astype(float)) ** self.harmonic.power
        return lines.values * powers, lines.errors * np.abs(powers)

    def mirrored(self, chosen: list[RefinedPole]) -> np.ndarray:
        """The conjugate of H at -conj(p) for poles p, without the conjugate of the term of p itself, shape (number, p, m).

        It is the continuation of conj(H) from the axis to p; the term that is left out is conj(R) / (2 |sigma|).
        """
        s = np.array([pole.value for pole in chosen], dtype=complex)
        itself = np.array([[pole is other for other in self.poles] for pole in chosen], dtype=bool).reshape(len(s), len(self.poles))
        total = np.zeros((len(s), len(self.harmonic.outputs), self.harmonic.inputs.shape[1]), dtype=complex)
        distances = -s[:, None] - np.array([other.value.conjugate() for other in self.poles], dtype=complex)
        for j in range(max((pole.order for pole in self.poles), default=0)):
            terms = np.where(itself, 0.0, np.where(itself, 1.0, distances) ** -(j + 1.0))
            residues = [other.residues[j] if j < other.order else np.zeros(total.shape[1:]) for other in self.poles]
            total += np.tensordot(terms, np.conj(residues), 1)
        for k, D in enumerate(self.harmonic.form.polynomial):
            total += np.multiply.outer((-s) ** k, D.conj())
        return total


class DelayedTransfer(SpectralTransfer):
    """H of equations with delays: there are no residues, and panels are narrow next to the characteristic roots instead."""

    def __init__(self, harmonic: Harmonic, roots: CharacteristicRoots | None = None, is_finer: bool = False):
        """Create the transfer function, with its rightmost characteristic roots where they are known; ``is_finer``: all panels are halved."""
        super().__init__(harmonic)
        self.roots = roots or rightmost_roots(harmonic.A, harmonic.delayed, ROOTS * harmonic.A.size)
        self.is_finer = is_finer

    @cached_property
    def poles(self) -> tuple[RefinedPole, ...]:
        """The roots with their conjugates, as poles of order two: all panels near them are halved."""
        values = self.roots.eigenvalues
        ones = np.ones((2, len(self.harmonic.outputs), self.harmonic.inputs.shape[1]))
        values = np.where(
            np.abs(values) > EPS**0.5 * np.abs(values).max(initial=0.0), values, 0.0
        )  # a double root 0 has half the digits
        upper = [RefinedPole(complex(s), ones, None, bool(abs(s.real) <= UNDAMPED * abs(s)), ones) for s in values]
        return (*upper, *(replace(pole, value=pole.value.conjugate()) for pole in upper if pole.value.imag))

    @property
    def widest(self) -> float:
        """The widest panel in Hz, on which the factors e^(-i w delay) turn little."""
        return TURN / sum(term.delay for term in self.harmonic.delayed) / (2 * np.pi)

    @property
    def polynomial(self) -> np.ndarray:
        """An array without powers of s."""
        return np.zeros((0, len(self.harmonic.outputs), self.harmonic.inputs.shape[1]))

    @cached_property
    def seems_zero(self) -> np.ndarray:
        """No output: rounding errors count as values."""
        return np.zeros(len(self.harmonic.outputs), dtype=bool)

    @property
    def vanishes(self) -> np.ndarray:
        """No output."""
        return self.seems_zero

    def of_inputs(self, chosen: list[int]) -> DelayedTransfer:
        """The transfer function from some of the inputs."""
        return DelayedTransfer(super().of_inputs(chosen).harmonic, self.roots, self.is_finer)

    def values(self, f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """H by solutions."""
        return self.solved(f)

    def mirrored(self, chosen: list[RefinedPole]) -> np.ndarray:
        """Nothing: no principal part is integrated by itself."""
        return np.zeros((len(chosen), len(self.harmonic.outputs), self.harmonic.inputs.shape[1]), dtype=complex)


def _without_noise(residues: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    return np.where(np.abs(residues) > CLUSTER_SAFETY * EPS * sizes, residues, 0.0)


def _bilinear(coefficients: np.ndarray, X: np.ndarray, Y: np.ndarray, p: np.ndarray) -> np.ndarray:
    """y_k^T A(p_k) x_k in twice the digits of float64, shape (K,)."""
    total = DoubleDouble.of(np.zeros(len(p), dtype=complex))
    for A in coefficients[::-1]:
        (real, of_real), (imaginary, of_imaginary) = (accurate_product(A, part, MOST_SLICES) for part in (X.real, X.imag))
        total = total * p + (DoubleDouble(real + 1j * imaginary, of_real + 1j * of_imaginary) * Y.T).sum()
    return total.high + total.low


# Integrals of f^k H(f) S(f) H(f)^H over all positive frequencies, in closed form near poles and exactly by Gauss's rule elsewhere.
# The integrand is analytic between corner frequencies but for the poles of H and their mirror images. Every octave is a panel. A simple pole
# f_j that is nearer to its middle than its width has the principal part
#     r / (f - f_j) + r^H / (f - conj f_j),   r = R S(f_j) H(conj f_j)^H / (2 pi i),
# whose integral is a logarithm and an arc tangent. What remains has no singularity within two half-widths of the middle: Gauss's rule with
# 16 nodes is exact to 3.7^-32 for it. Where principal parts cancel (near multiple poles) and near singularities of other kinds, panels are
# halved instead: the integrand on the diagonal is positive, so that nothing cancels. Source of the principal parts: residue theorem; of the rule and its
# error: Trefethen, Approximation Theory and Approximation Practice (2013), Theorem 19.3.

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)

#: A singularity nearer to the middle of a panel than so many half-widths counts as near.
NEAR = 2.0

#: Values of H at nodes are solved for where the estimated error of an integral by their sums exceeds this share of it.
SOLVED = 10 * SPECTRAL_ACCURACY

#: Panels whose nodes have errors of more than this share of the integral, because one is at a peak, are moved, so often at most.
MOVED, MOVES = 10 * SOLVED, 3

#: Panels are halved at most so many times: then they are as narrow as rounding errors.
HALVINGS = 60

#: Radians that e^{-i w delay} turns on a panel at most, and those that it has turned at least where the way to infinity leaves the axis.
TURN, TURNED = 3.0, 40.0

#: Gauss-Laguerre's rule; the nearest singularity is TURNED / 2 from its start.
TAIL_NODES, TAIL_WEIGHTS = np.polynomial.laguerre.laggauss(32)


@dataclass(frozen=True, eq=False)
class SpectralIntegral:
    """Integrals of f^k G(f) df over f > 0, G the one-sided spectra of p outputs."""

    values: np.ndarray  # complex, Hermitian, shape (p, p)
    errors: np.ndarray  # estimates of the absolute errors of the diagonal, shape (p,)
    parts: np.ndarray  # of the diagonal, from each edge to the next, shape (number of edges - 1, p)


@dataclass
class _IntegrationPanels:
    """P intervals of the frequency, each with the middle of its pieces of the spectra; in tail intervals the variable is 1/f."""

    lower: np.ndarray
    upper: np.ndarray
    middle: np.ndarray
    is_tail: np.ndarray

    def halves(self, chosen: np.ndarray) -> _IntegrationPanels:
        """The halves of the selected panels."""
        a, b = self.lower[chosen], self.upper[chosen]
        c = (a + b) / 2
        twice = [np.tile(one[chosen], 2) for one in (self.middle, self.is_tail)]
        return _IntegrationPanels(np.append(a, c), np.append(c, b), *twice)

    def only(self, chosen: np.ndarray) -> _IntegrationPanels:
        """The selected panels."""
        return _IntegrationPanels(self.lower[chosen], self.upper[chosen], self.middle[chosen], self.is_tail[chosen])

    def joined(self, other: _IntegrationPanels) -> _IntegrationPanels:
        """The panels followed by others."""
        return _IntegrationPanels(*(np.append(one, two) for one, two in zip(vars(self).values(), vars(other).values())))

    @property
    def nodes(self) -> np.ndarray:
        """Frequencies in Hz, shape (P, 16)."""
        own = (self.lower + self.upper)[:, None] / 2 + (self.upper - self.lower)[:, None] / 2 * NODES
        return np.where(self.is_tail[:, None], 1 / own, own)

    @property
    def weights(self) -> np.ndarray:
        """Weights of the nodes, shape (P, 16)."""
        own = (self.upper - self.lower)[:, None] / 2 * WEIGHTS
        return np.where(self.is_tail[:, None], own * self.nodes**2, own)


def spectral_integral(
    transfer: SpectralTransfer,
    spectra: SpectralMatrix,
    power: int = 0,
    outputs: np.ndarray | None = None,
    edges: np.ndarray | None = None,
) -> SpectralIntegral:
    """The integrals of f^k H S H^H df; with delays on all panels and on their halves, whose difference is an error."""
    if isinstance(transfer, DelayedTransfer) and not transfer.is_finer:
        finer = DelayedTransfer(transfer.harmonic, transfer.roots, is_finer=True)
        one, two = (_integral(own, spectra, power, outputs, edges) for own in (transfer, finer))
        return replace(two, errors=two.errors + np.abs(two.values - one.values).diagonal())
    return _integral(transfer, spectra, power, outputs, edges)


def _integral(transfer: SpectralTransfer, spectra: SpectralMatrix, power, outputs, edges) -> SpectralIntegral:
    parts = [(transfer, spectra)]
    if any(pole.on_axis for pole in transfer.poles):  # of inputs that do not reach it, it is none
        parts = [(transfer.of_inputs(group), spectra.of_inputs(group)) for group in spectra.groups]
    with np.errstate(over="ignore", invalid="ignore"):
        each = [_Integration(*part, power, outputs, edges).result() for part in parts]
        result = SpectralIntegral(*(np.sum([getattr(one, name) for one in each], axis=0) for name in ("values", "errors", "parts")))
    if not np.isfinite(result.values).all():
        raise Overflow(
            "excitation: the spectra of the outputs leave the range of float64; expected densities and frequencies of usual size"
        )
    return result


def _hermitian(matrices: np.ndarray) -> np.ndarray:
    """The Hermitian parts, (M + M^H) / 2; those of -i M are the skew parts over i."""
    return (matrices + np.conj(np.swapaxes(matrices, -1, -2))) / 2


def _diagonal(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Diagonals of the products of stacks of matrices (number, p, m) and (number, m, p): shape (number, p)."""
    return np.einsum("xai,xia->xa", left, right)


def _product_sum(left: np.ndarray, right: np.ndarray) -> np.ndarray:
    """The sum of the products over the stack, as one product."""
    count, p, m = left.shape
    return left.transpose(1, 0, 2).reshape(p, count * m) @ right.reshape(count * m, p)


def _residue_errors(poles: list[RefinedPole], sizes: np.ndarray) -> np.ndarray:
    """Errors of the residues by rounding errors of the modes, shape (number, p, m).

    An error e of the equations mixes the modes j into mode i by e |p_i| / |p_i - p_j|: modes of close poles have fewer digits than others.
    """
    values = np.array([pole.value for pole in poles], dtype=complex)
    gaps = np.maximum(np.abs(values[:, None] - values), EPS * np.abs(values)[:, None])
    mixed = np.abs(values)[:, None] / np.where(gaps > 0, gaps, 1.0) * (1.0 - np.eye(len(values)))
    roots = np.sqrt(sizes)
    return FORM_ROUNDING * EPS * (sizes + roots * np.tensordot(mixed, roots, 1))


class _Integration:
    """State of one integration."""

    def __init__(self, transfer: SpectralTransfer, spectra: SpectralMatrix, power: int, outputs, edges=None):
        self.transfer, self.spectra, self.power = transfer, spectra, power
        self.edges = np.zeros(0) if edges is None else edges
        self.outputs = np.arange(len(transfer.harmonic.outputs)) if outputs is None else outputs
        self.poles = [pole for pole in transfer.poles if pole.residues[:, self.outputs].any()]
        simple = [pole for pole in self.poles if pole.order == 1 and not pole.on_axis]
        self.frequencies = np.array([pole.frequency for pole in simple], dtype=complex)
        self.sigma = np.array([pole.value.real for pole in simple])
        shape = (len(simple), len(self.outputs), len(spectra.names))
        self.residues = np.array([pole.residues[0, self.outputs] for pole in simple]).reshape(shape)
        self.doubts = _residue_errors(simple, np.array([pole.sizes[0, self.outputs] for pole in simple]).reshape(shape))
        self.mirrored = transfer.mirrored(simple)[:, self.outputs]
        self.others = np.array([pole.frequency for pole in self.poles if pole.order > 1 or pole.on_axis], dtype=complex)

    def result(self) -> SpectralIntegral:
        """The integrals."""
        panels = self._resolved(self._octaves())
        H, errors = self._values(panels)
        sums, near, loss, doubts = self._sums(panels, H), *self._near_poles(panels)
        for _ in range(HALVINGS):
            size = np.abs((sums + near).sum(axis=0).diagonal())
            bad = (loss > 0.1 * SPECTRAL_ACCURACY * size).any(axis=1) & (panels.upper - panels.lower > 8 * EPS * panels.upper)
            if not bad.any():
                break
            halves = self._resolved(panels.halves(bad))
            panels, *parts = self._with(halves, bad, panels, H, errors, sums, near, loss, doubts)
            H, errors, sums, near, loss, doubts = parts
        if len(self.outputs):
            return self._improved(panels, H, errors, sums, near, loss, doubts)
        return SpectralIntegral(np.zeros((0, 0)), np.zeros(0), np.zeros((max(len(self.edges) - 1, 0), 0)))

    def _with(self, new: _IntegrationPanels, bad: np.ndarray, panels: _IntegrationPanels, H, errors, *parts) -> tuple:
        """Panels and values with some panels replaced by new ones."""
        keep, (new_H, new_errors) = ~bad, self._values(new)
        new_parts = self._sums(new, new_H), *self._near_poles(new)
        both = (np.concatenate([one[:, :, keep], two], axis=2) for one, two in ((H, new_H), (errors, new_errors)))
        return panels.only(keep).joined(new), *both, *(np.concatenate([one[keep], two]) for one, two in zip(parts, new_parts))

    def _centred(self, panels: _IntegrationPanels, errors: np.ndarray) -> _IntegrationPanels:
        """Three panels for each, the middle one around the peak next to the node of largest error: no node is on the peak."""
        nodes = panels.nodes[np.arange(len(errors)), errors.argmax(axis=1)]
        peaks = np.append(self.frequencies.real, np.inf)
        peak = peaks[np.abs(nodes[:, None] - peaks).argmin(axis=1)]
        low, high, middle = panels.lower, panels.upper, (panels.lower + panels.upper) / 2
        reach = np.minimum(peak - low, high - peak)
        is_inside = reach > (high - low) * MARGIN
        edges = np.array([low, np.where(is_inside, peak - reach, middle), np.where(is_inside, peak + reach, middle), high])
        parts = [_IntegrationPanels(one, two, panels.middle, panels.is_tail) for one, two in itertools.pairwise(edges)]
        new = parts[0].joined(parts[1]).joined(parts[2])
        return self._resolved(new.only(new.upper - new.lower > 8 * EPS * new.upper))

    # Panels.

    def _octaves(self) -> _IntegrationPanels:
        """Panels between the corners, none wider than an octave where the integrand is singular at 0, with ends beyond all poles."""
        sizes = np.abs([pole.frequency for pole in self.poles if pole.value] or [0.0])
        rows: list[tuple[float, float, float, bool]] = []
        corners = self.spectra.corners
        for a, b in itertools.pairwise(corners):
            middle = a + 1.0 if np.isinf(b) else (a + b) / 2
            own = [abs(one) for one in self.spectra.singularities(middle) if one] + [size for size in sizes if size]
            low, high = (min(own), max(own)) if own else (1.0, 1.0)
            if np.isinf(b):
                last = max(
                    2.0 * high,
                    2.0 * a,
                    *self.edges[np.isfinite(self.edges)][-1:],
                    *(TURNED / (2 * np.pi * one) for one in self.spectra.shifts),
                )
                rows.append((0.0, 1 / last, middle, True))
                b = last
            if a == 0:
                first = min(low / 2, b, *self.edges[self.edges > 0][:1])
                rows.append((0.0, first, middle, False))
                a = first
            inner = self.edges[(self.edges > a) & (self.edges < b)]
            for start, end in itertools.pairwise([a, *inner, b] if b > a else ()):
                edges = np.geomspace(start, end, max(int(np.ceil(np.log2(end) - np.log2(start) - MARGIN)), 1) + 1)
                edges[0], edges[-1] = start, end
                rows += [(one, two, middle, False) for one, two in itertools.pairwise(edges)]
        widest = TURN / (2 * np.pi * self.spectra.longest_delay) if self.spectra.longest_delay else np.inf
        widest = min(widest, self.transfer.widest)
        if np.isfinite(widest):
            rows = [part for row in rows for part in self._divided(row, widest)]
        lower, upper, middle, tail = (np.array(column) for column in zip(*rows)) if rows else (np.zeros(0),) * 4
        panels = _IntegrationPanels(lower, upper, middle, tail.astype(bool))
        return panels.halves(np.ones(len(lower), dtype=bool)) if self.transfer.is_finer else panels

    @staticmethod
    def _divided(row, widest: float):
        a, b, middle, tail = row
        count = 1 if tail else int(np.ceil((b - a) / widest))
        edges = np.linspace(a, b, max(count, 1) + 1)
        return [(one, two, middle, tail) for one, two in itertools.pairwise(edges)]

    def _near(self, panels: _IntegrationPanels, places: np.ndarray) -> np.ndarray:
        """Which complex frequencies are near which panels, shape (P, number)."""
        middle, half = (panels.lower + panels.upper) / 2, (panels.upper - panels.lower) / 2
        return (np.abs(middle[:, None] - places) < (1 - MARGIN) * NEAR * half[:, None]) & ~panels.is_tail[:, None]

    def _resolved(self, panels: _IntegrationPanels) -> _IntegrationPanels:
        """Panels halved until no singularity other than simple poles is near."""
        finished = None
        for _ in range(HALVINGS):
            blocked = self._near(panels, self.others).any(axis=1)
            for middle in np.unique(panels.middle):
                own = np.array(self.spectra.singularities(middle), dtype=complex)
                blocked |= (panels.middle == middle) & self._near(panels, own).any(axis=1)
            blocked &= panels.upper - panels.lower > 8 * EPS * panels.upper
            done = panels.only(~blocked)
            finished = done if finished is None else finished.joined(done)
            if not blocked.any():
                return finished
            panels = panels.halves(blocked)
        return finished.joined(panels)

    # Values and integrals.

    def _values(self, panels: _IntegrationPanels) -> tuple[np.ndarray, np.ndarray]:
        """H and its errors at all nodes, shape (p, m, P, 16)."""
        nodes = panels.nodes
        H, errors = self.transfer.values(nodes.ravel())
        shape = (len(self.outputs), H.shape[1], *nodes.shape)
        return H[self.outputs].reshape(shape), errors[self.outputs].reshape(shape)

    def _spectra_at(self, panels: _IntegrationPanels) -> np.ndarray:
        """S at the nodes, shape (m, m, P, 16)."""
        nodes, m = panels.nodes, len(self.spectra.names)
        S = np.zeros((m, m, *nodes.shape), dtype=complex)
        for middle in np.unique(panels.middle):
            own = panels.middle == middle
            S[:, :, own] = self.spectra(nodes[own].ravel(), middle).reshape(m, m, -1, len(NODES))
        return S

    def _delayed_tails(self, panels: _IntegrationPanels, total: np.ndarray) -> None:
        """Add the tails of delayed inputs from the last panel to infinity, along f - i u / (2 pi delay), u > 0 (Gauss-Laguerre)."""
        for x in np.flatnonzero(panels.is_tail) if self.spectra.longest_delay else ():
            form, last = self.transfer.harmonic.form, 1 / panels.upper[x]
            for i, j in self.spectra.delayed_pairs:
                step = -1j / (2 * np.pi * (self.spectra.delays[i] - self.spectra.delays[j]))
                f = last + step * TAIL_NODES
                one, other = (form.values(2j * np.pi * own)[0][self.outputs] for own in (f, f.conj()))
                S = self.spectra(f, panels.middle[x])[i, j] * np.exp(TAIL_NODES) * step * TAIL_WEIGHTS
                T = (one[:, i] * (S * f**self.power)) @ other[:, j].conj().T
                total[x] += T + T.conj().T

    def _sums(self, panels: _IntegrationPanels, H: np.ndarray, spectra: np.ndarray | None = None) -> np.ndarray:
        """Gauss's rule on each panel, shape (P, p, p)."""
        S = self._spectra_at(panels) if spectra is None else spectra.copy()
        for i, j in self.spectra.delayed_pairs:
            S[i, j, panels.is_tail] = S[j, i, panels.is_tail] = 0.0
        left, right = np.moveaxis(H, (2, 3), (0, 1)), np.moveaxis(H.conj(), (2, 3, 1), (0, 1, 2))
        G = left @ np.moveaxis(S, (2, 3), (0, 1)) @ right
        total = np.einsum("xn,xnab->xab", panels.weights * panels.nodes**self.power, G)
        self._delayed_tails(panels, total)
        return total

    def _near_poles(self, panels: _IntegrationPanels) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Integrals of principal parts less their sums by Gauss's rule, shape (P, p, p), and errors of the diagonals."""
        total = np.zeros((len(panels.lower), *(len(self.outputs),) * 2), dtype=complex)
        loss, doubts = np.zeros((2, *total.shape[:2]))
        x, number = np.nonzero(self._near(panels, self.frequencies))
        if not len(x):
            return total, loss, doubts
        a, b = self.frequencies[number].real, self.frequencies[number].imag
        nodes, weights = panels.nodes[x], panels.weights[x]
        distance, lower, upper = nodes - a[:, None], panels.lower[x] - a, panels.upper[x] - a
        size = distance**2 + b[:, None] ** 2
        first, second = (weights * distance / size).sum(axis=1), b * (weights / size).sum(axis=1)
        logarithm = 0.5 * np.log((upper**2 + b**2) / (lower**2 + b**2))
        angle = np.sign(b) * np.arctan2((upper - lower) * np.abs(b), b**2 + upper * lower)
        starts = np.flatnonzero(np.diff(x, prepend=-1))
        X, Y = 2 * (logarithm - first), 2 * (angle - second)
        left, (odd, even, other), doubt = self._principal_parts(number, panels.middle[x])
        right = X[:, None, None] * (odd - 1j * other) + Y[:, None, None] * (even + other)
        for panel, own in zip(x[starts], itertools.pairwise([*starts, len(x)])):
            total[panel] = _product_sum(left[slice(*own)], right[slice(*own)])
        sizes = zip((_diagonal(left, odd - 1j * other), _diagonal(left, even + other)), ((logarithm, first), (angle, second)))
        terms = sum(np.abs(one.real) * (np.abs(u) + np.abs(v))[:, None] for one, (u, v) in sizes)
        loss[x[starts]] = 2 * EPS * np.add.reduceat(terms, starts)
        doubts[x[starts]] = 2 * np.add.reduceat(doubt * np.abs(angle)[:, None], starts)
        return _hermitian(total), loss, doubts

    def _principal_parts(self, number: np.ndarray, middle: np.ndarray) -> tuple[np.ndarray, tuple, np.ndarray]:
        """Principal parts of poles: r = -i R f^k S(f) (conj R / (2 |sigma|) + rest)^T / (2 pi), with errors, shape (number, p).

        Its Hermitian part and that of -i r are those of R (odd - i other) and -R (even + other), R of shape (number, p, m) and these of shape
        (number, m, p). The term with 1 / sigma belongs to the arc tangent but for the change of S from the axis to the pole, which is taken by
        itself: far from the peak it is the small part of the logarithm that counts.
        """
        S = np.zeros((len(number), *(len(self.spectra.names),) * 2), dtype=complex)
        at = self.frequencies[number]
        for piece in np.unique(middle):
            own = middle == piece
            S[own] = np.moveaxis(self.spectra(at[own], piece), 2, 0)
        S *= (at**self.power / (2 * np.pi))[:, None, None]
        R, rest = self.residues[number], self.mirrored[number]
        conjugate = np.conj(np.swapaxes(R, 1, 2)) / (-2 * self.sigma[number])[:, None, None]
        doubt = np.einsum("xai,xij,xaj->xa", np.abs(R), np.abs(S), self.doubts[number]) / np.abs(self.sigma[number])[:, None]
        return R, (_hermitian(-1j * S) @ conjugate, _hermitian(S) @ conjugate, S @ np.swapaxes(rest, 1, 2)), doubt

    def _improved(self, panels, H, errors, sums, near, loss, doubts) -> SpectralIntegral:
        """The integral with refined panels, and with values of H by solutions where the errors of their sums matter."""
        for moves in range(MOVES + 1):
            size = np.abs((sums + near).sum(axis=0).diagonal().real)
            S = self._spectra_at(panels)
            own = self._node_errors(panels, S, H, errors)
            bad = (own.sum(axis=1) > MOVED * size).any(axis=1) & ~panels.is_tail
            if (moves or not bad.any()) and (own.sum(axis=(0, 1)) > SOLVED * size).any():
                at = (own > 0.1 * SPECTRAL_ACCURACY * size / max(own.shape[0] * own.shape[1], 1)).any(axis=2)
                solved, solved_errors = self.transfer.solved(panels.nodes[at])
                better = solved_errors[self.outputs] < errors[:, :, at]
                H[:, :, at] = np.where(better, solved[self.outputs], H[:, :, at])
                errors[:, :, at] = np.where(better, solved_errors[self.outputs], errors[:, :, at])
                sums, own = self._sums(panels, H, S), self._node_errors(panels, S, H, errors)
                bad &= (own.sum(axis=1) > MOVED * size).any(axis=1)
            if not bad.any() or moves == MOVES:
                break
            new = self._centred(panels.only(bad), own[bad].max(axis=2))
            panels, H, errors, sums, near, loss, doubts = self._with(new, bad, panels, H, errors, sums, near, loss, doubts)
        total = sums + near
        middle = np.where(panels.is_tail, np.inf, (panels.lower + panels.upper) / 2)
        parts = np.zeros((max(len(self.edges) - 1, 0), *size.shape))
        band = np.searchsorted(self.edges, middle) - 1
        inside = (band >= 0) & (band < len(parts))
        np.add.at(parts, band[inside], total[inside].diagonal(axis1=1, axis2=2).real)
        return SpectralIntegral(total.sum(axis=0), own.sum(axis=(0, 1)) + (loss + doubts).sum(axis=0) + 16 * EPS * size, parts)

    def _node_errors(self, panels: _IntegrationPanels, S: np.ndarray, H: np.ndarray, errors: np.ndarray) -> np.ndarray:
        """Errors of the diagonal by nodes, shape (P, 16, p)."""
        delta = np.einsum("ijxn,ajxn->aixn", np.abs(S), errors)
        both = ((2 * np.abs(H) + errors) * delta).sum(axis=1)
        return (panels.weights * both * panels.nodes**self.power).transpose(1, 2, 0)
