"""H(f) with refined poles: the real part of a pole near the axis is the damping, and needs its own relative accuracy."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...ground.tolerances import CLUSTER_SAFETY, EPS, LIGHT_DAMPING, NOISE_SAFETY, UNDAMPED
from ...linalg import precise
from ...polynomial.structure import FiniteZero
from ..frequency_response import NOISE
from ..harmonic import Harmonic
from ..pole_residue_form import Pole, is_on_axis


@dataclass(frozen=True, eq=False)
class RefinedPole:
    """A pole p = sigma + i w of H(s), with sigma accurate relative to itself.

    Attributes:
        value: p in 1/s.
        residues: R_0, R_1, ... of 1 / (s - p), 1 / (s - p)^2, ..., shape (order, p, m).
        on_axis: whether sigma is zero.
        sizes: of the terms that residues are sums of, shape (order, p, m); some of their rounding errors are errors of the residues.
    """

    value: complex
    residues: np.ndarray
    on_axis: bool
    sizes: np.ndarray

    @property
    def frequency(self) -> complex:
        """p / (2 pi i): a complex frequency in Hz, above the real axis where the pole is stable."""
        return complex(self.value.imag, -self.value.real) / (2 * np.pi)

    @property
    def order(self) -> int:
        """The highest power of 1 / (s - p)."""
        return len(self.residues)


class SpectralTransfer:
    """The values, poles and residues of s^p C A(s)^-1 B on the positive frequency axis."""

    def __init__(self, harmonic: Harmonic):
        """Create the transfer function from the matrices of one response."""
        self.harmonic = harmonic

    @cached_property
    def poles(self) -> tuple[RefinedPole, ...]:
        """All poles with their conjugates; the real parts of lightly damped ones are refined by Newton's method.

        One step from p with the null vectors x and y of A(p), y^T A'(p) x = 1, is -y^T A(p) x: its error is a product of the errors of both vectors
        where the sum is computed in extended precision.
        """
        form = self.harmonic.form
        own = list(form.poles)
        light = [
            k
            for k, pole in enumerate(own)
            if pole.order == 1 and pole.value and abs(pole.value.real) < LIGHT_DAMPING * abs(pole.value)
        ]
        steps, doubts = self._newton_steps([own[k].value for k in light]) if light else ([], [])
        values = {k: own[k].value + step for k, step in zip(light, steps)}
        limits = {k: max(UNDAMPED * abs(own[k].value), doubt) for k, doubt in zip(light, doubts)}
        result = []
        for k, pole in enumerate(own):
            value = values.get(k, pole.value)
            on_axis = not value or (abs(value.real) <= limits[k] if k in values else is_on_axis(pole))
            sizes = self._sizes(pole)
            residues = _without_noise(pole.residues, sizes) if on_axis else pole.residues
            result.append(RefinedPole(complex(0.0 if on_axis else value.real, value.imag), residues, on_axis, sizes))
        return tuple(result)

    @cached_property
    def _zeros(self) -> dict[complex, FiniteZero]:
        zeros = {}
        for zero in self.harmonic.form.pairs.finite.zeros:
            zeros[zero.value], zeros[zero.value.conjugate()] = zero, zero
        return zeros

    def _zero_at(self, value: complex) -> FiniteZero:
        """The eigenvalue of A(s) that equals this pole, or its conjugate."""
        return self._zeros.get(value) or self._zeros[min(self._zeros, key=lambda one: abs(one - value))]

    def _sizes(self, pole: Pole) -> np.ndarray:
        """Scales of residues, attained by modes whose largest entries are at input and output, shape (order, p, m)."""
        form = self.harmonic.form
        pair, scaling = form.pairs.finite, form.pairs.form.companion.scaling
        at, right, J, left = form.subspace(self._zero_at(pole.value), pole.value)
        X, Y = np.abs(pair.C[:, at] @ right) / scaling.columns[:, None], np.abs(left @ pair.B[at]) / scaling.rows
        front, N = np.linalg.matrix_power(J, form.power), J - pole.value * np.eye(len(J))
        powers = [np.abs(front @ np.linalg.matrix_power(N, j)) for j in range(pole.order)]
        size = np.array([X.max(axis=0) @ middle @ Y.max(axis=1) for middle in powers])
        limit = np.outer(np.abs(form.outputs) @ scaling.columns, scaling.rows @ np.abs(form.inputs))
        return size[:, None, None] * limit

    def _newton_steps(self, values: list[complex]) -> tuple[list[complex], list[float]]:
        """Newton steps -mean(diag Y^T A(p) X) of poles with vectors X and Y, and the effect of rounding errors of A on real parts.

        An entry of A_k adds Re(p^k y_i x_j) times its error: those of mass and stiffness nothing to an undamped motion.
        """
        form = self.harmonic.form
        pair, coefficients = form.pairs.finite, self.harmonic.real[0].coefficients
        columns, rows, at, owner = [], [], [], []
        for number, value in enumerate(values):
            places, right, _, left = form.subspace(self._zero_at(value), value)
            X, Y = pair.C[:, places] @ right, left @ pair.B[places]
            for i in range(X.shape[1]):
                columns.append(X[:, i])
                rows.append(Y[i])
                at.append(value)
                owner.append(number)
        with precise.precise_arithmetic():
            residuals = _bilinear(coefficients, np.array(columns).T, np.array(rows), np.array(at))
        of = np.array(owner)
        sizes = self.harmonic.sizes if self.harmonic.imaginary is None else None
        used = np.abs(coefficients) if sizes is None else sizes
        doubts = EPS * np.array(
            [
                sum((A * np.abs(np.real(p**k * np.outer(y, x)))).sum() for k, A in enumerate(used))
                for x, y, p in zip(columns, rows, at)
            ]
        )
        means = [residuals[of == number].mean() for number in range(len(values))]
        return [-mean for mean in means], [float(doubts[of == number].max()) for number in range(len(values))]

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


def _without_noise(residues: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    return np.where(np.abs(residues) > CLUSTER_SAFETY * EPS * sizes, residues, 0.0)


def _bilinear(coefficients: np.ndarray, X: np.ndarray, Y: np.ndarray, p: np.ndarray) -> np.ndarray:
    """y_k^T A(p_k) x_k in extended precision, shape (K,)."""
    real, imaginary = precise.precise(X.real), precise.precise(X.imag)
    pr, pi = precise.precise(p.real), precise.precise(p.imag)
    yr, yi = precise.precise(Y.real.T), precise.precise(Y.imag.T)
    total_real, total_imaginary = precise.precise(np.zeros(len(p))), precise.precise(np.zeros(len(p)))
    for A in coefficients:
        matrix = precise.precise(A)
        u, v = precise.product(matrix, real), precise.product(matrix, imaginary)
        total_real, total_imaginary = total_real + (yr * u - yi * v).sum(axis=0), total_imaginary + (yr * v + yi * u).sum(axis=0)
        real, imaginary = real * pr - imaginary * pi, real * pi + imaginary * pr
    return precise.floats(total_real) + 1j * precise.floats(total_imaginary)
