"""The sensitivities of a system: derivatives of its modes and responses with respect to its parameters, in closed form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
import scipy

from ..exact.splitting import Branch, Splitting, splitting
from ..ground.checks import counted
from ..ground.display import Displayed, TextTable, notice_table
from ..ground.errors import InputError
from ..ground.named_arrays import named_array
from ..ground.notices import Notice, doubts_of
from ..ground.threads import short_work
from ..ground.tolerances import EPS, REFINEMENT_STEPS, SHOWN_INFLUENCE, SPLITTING_ROUNDING, noise_of
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import step
from .constraints import Constraint, with_multipliers
from .equations import EquationsOfMotion
from .harmonic_response import frequency_response
from .modes import Mode, Modes
from .parameter import Parameter, parameter_named
from .random_excitation import random_response

if TYPE_CHECKING:
    from ..frequency.frequency_response import FrequencyResponse
    from .motion import Motion


# Derivatives of eigenvalues and shapes with respect to parameters, in the equations with multipliers.
#
# With the rows at position level, L(s) = [K + C s + M s^2, -A^T; A, 0] and L(s) x = 0, x = (u, lambda), the derivatives of a simple eigenvalue
# and of its shape, the entry j of which stays 1, are the solution of one bordered system, regular whatever M and the rows are:
#
#     [L(s), L'(s) x; e_j^T, 0] [x_p; s_p] = [-L_p(s) x; 0]
#
# (Nelson 1976; Lee and Jung 1997). Of g independent shapes of a semisimple eigenvalue the derivatives are the eigenvalues of
# -Y^T L_p X with Y^T L' X = I (Lancaster 1964); defective ones split by fractional powers (``exact.splitting``).

STAYS = Branch(Fraction(1), 0j)


@dataclass(frozen=True, eq=False)
class MultiplierForm:
    """L(s) of a system and the L_p(s) of parameters, with rows scaled to the size of the stiffness."""

    base: np.ndarray  # L_0, L_1, L_2, shape (3, n + k, n + k)
    size: int  # n
    scale: float  # by which the rows are multiplied; multipliers are divided by it

    @staticmethod
    def of(system: EquationsOfMotion) -> MultiplierForm:
        """The multiplier form of a system with every row at position level."""
        scale = float(max(np.abs(system.stiffness).max(), np.abs(system.mass).max()))
        rows = scale * system.constraint_matrix
        matrices = system.stiffness, system.damping, system.mass
        return MultiplierForm(np.array(with_multipliers(matrices, rows, [0] * len(rows))), system.size, scale)

    def slope(self, system: EquationsOfMotion, parameter: Parameter) -> Slope:
        """The derivatives of the multiplier form with respect to a parameter."""
        rows, _ = parameter.constraint_rows(system)
        matrices = np.array(with_multipliers([*parameter.matrices(system.size)], self.scale * rows, [0] * len(rows)))
        power, row, column = np.nonzero(matrices)
        return Slope(power, row, column, matrices[power, row, column], len(matrices[0]))

    def vectors(self, system: EquationsOfMotion, value: complex, shapes: np.ndarray) -> np.ndarray:
        """(u, lambda) of shapes with the constraint forces that they need."""
        if len(self.base[0]) == self.size:
            return shapes
        forces = self.at(value)[: self.size, : self.size] @ shapes
        return np.vstack([shapes, system.multiplier_map @ forces / self.scale])

    def at(self, value) -> np.ndarray:
        """L(s)."""
        return self.base[0] + value * (self.base[1] + value * self.base[2])

    def derivative(self, value) -> np.ndarray:
        """L'(s)."""
        return self.base[1] + 2 * value * self.base[2]


@dataclass(frozen=True, eq=False)
class Slope:
    """L_p(s) of one parameter by its few nonzero entries."""

    power: np.ndarray  # power of s, shape (e,)
    row: np.ndarray  # row, column, entry: indices and value of each
    column: np.ndarray
    entry: np.ndarray
    size: int  # n + k

    @property
    def absolute(self) -> Slope:
        """The slope with absolute values of the entries."""
        return replace(self, entry=np.abs(self.entry))

    @property
    def matrices(self) -> np.ndarray:
        """Shape (3, n + k, n + k)."""
        result = np.zeros((3, self.size, self.size))
        result[self.power, self.row, self.column] = self.entry
        return result

    def form(self, left: np.ndarray, value, right: np.ndarray) -> np.ndarray:
        """Y^T L_p(s) X."""
        return left[self.row].T @ ((self.entry * value**self.power)[:, None] * right[self.column])

    def product(self, value, vector: np.ndarray) -> np.ndarray:
        """L_p(s) x."""
        result = np.zeros(self.size, dtype=vector.dtype)
        np.add.at(result, self.row, self.entry * value**self.power * vector[self.column])
        return result


class Eigenspace:
    """A simple or semisimple eigenvalue with its g shapes and the bordered system of their derivatives.

    Newton's method in long double: [L(s), L'(s) X; E^T, 0] [dX; D] = [-L(s) X; 0], where E^T X = I, moves s by the mean of the
    diagonal of D (block Newton methods, Kressner 2009).

    From the shapes (u, lambda), shape (n + k, g), follow ``value`` and ``vectors``, s and X in their basis (of a single one the largest entry
    is 1); ``left``, Y with Y^T L'(s) X = I, and ``left_error``; ``correction``, the last step relative to s and X, estimates their errors.
    """

    def __init__(self, form: MultiplierForm, mode: Mode, shapes: np.ndarray):
        self.form, count = form, shapes.shape[1]
        self.places = scipy.linalg.qr(shapes[: form.size].T, mode="r", pivoting=True)[1][:count]
        basis = shapes[self.places] if count > 1 else np.ones((1, 1))
        self.value = np.clongdouble(mode.eigenvalue)
        self.vectors = shapes.astype(np.clongdouble) @ np.linalg.inv(shapes[self.places])
        self._factor()
        for _ in range(REFINEMENT_STEPS):
            step, _ = self.solved(np.pad(-form.at(self.value) @ self.vectors, [(0, count), (0, 0)]))
            self.vectors, change = self.vectors + step[:-count], step[-count:]
            self.value = self.value + change.trace() / count
            self._factor()
            self.correction = float(max(np.abs(change).max() / (abs(self.value) or 1.0), np.abs(step[: form.size]).max()))
            if self.correction <= EPS:
                break
        solution, change = self.solved(np.eye(len(self.matrix))[:, -count:], transposed=True)
        back = np.linalg.inv(basis).T
        self.left, self.left_error = solution[:-count] @ back, self._left_error(solution[:-count], change[:-count]) @ np.abs(back)
        self.vectors = self.vectors @ basis

    def _left_error(self, left: np.ndarray, change: np.ndarray) -> np.ndarray:
        """Error of Y: its last refinement, and the effect of errors of s and X on the matrix of its equations."""
        moved = self.form.derivative(self.value).T @ left
        border = np.full((left.shape[1],) * 2, (np.abs(moved) * np.abs(self.vectors).max()).sum(axis=0))
        amplified, _ = self.solved(np.vstack([self.value * moved, border]), transposed=True)
        return np.abs(change) + self.correction * np.abs(amplified[: -left.shape[1]])

    def _factor(self) -> None:
        border, count = self.form.derivative(self.value) @ self.vectors, self.vectors.shape[1]
        self.matrix = np.zeros((len(border) + count,) * 2, dtype=np.clongdouble)
        self.matrix[:-count, :-count], self.matrix[:-count, -count:] = self.form.at(self.value), border
        self.matrix[np.arange(-count, 0), self.places] = 1.0
        self.factors = scipy.linalg.lu_factor(self.matrix.astype(complex), check_finite=False)

    def solved(self, right: np.ndarray, transposed: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """The solution of the bordered system, refined to the digits of long double as far as its condition allows."""
        matrix = self.matrix.T if transposed else self.matrix
        result = np.zeros(right.shape, dtype=np.clongdouble)
        for _ in range(1 + REFINEMENT_STEPS):
            rest = (right - matrix @ result).astype(complex)
            correction = scipy.linalg.lu_solve(self.factors, rest, trans=int(transposed), check_finite=False)
            result = result + correction
        return result, correction

    def slopes(self, slope: Slope) -> np.ndarray:
        """ds/dp: the eigenvalues of -Y^T L_p(s) X, shape (g,)."""
        return _eigenvalues(-slope.form(self.left, self.value, self.vectors).astype(complex), self._phase)

    def error(self, slope: Slope, doubt: Slope | None) -> float:
        """An estimate of the largest error of ds/dp (Bauer and Fike 1960)."""
        left, right, value = np.abs(self.left), np.abs(self.vectors), abs(self.value)
        sizes, matrix = slope.absolute, -slope.form(self.left, self.value, self.vectors).astype(complex)
        doubtful = EPS * right + self.correction * right.max(axis=0)
        total = sizes.form(left, value, doubtful) + sizes.form(self.left_error, value, right)
        if doubt is not None:
            total += doubt.absolute.form(left, value, right)
        return float(np.linalg.norm(total.astype(float), 2) * _condition(matrix, self._phase))

    @property
    def _phase(self) -> complex:
        """s / |s|, by which the derivatives of undamped modes are real."""
        return complex(self.value / abs(self.value)) if self.value else 1.0

    def shape_slope(self, slope: Slope) -> np.ndarray:
        """du/dp of a single shape, the largest entry of u being 1, shape (n,)."""
        right = -slope.product(self.value, self.vectors[:, 0])
        return self.solved(np.append(right, 0.0)[:, None])[0][: self.form.size, 0].astype(complex)


def _is_hermitian(matrix: np.ndarray) -> bool:
    return bool((np.abs(matrix - matrix.conj().T) <= noise_of(np.abs(matrix).max(initial=0.0), len(matrix))).all())


def _eigenvalues(matrix: np.ndarray, phase: complex) -> np.ndarray:
    """Eigenvalues of a matrix, along the phase where matrix / phase is Hermitian."""
    if len(matrix) == 1:
        return matrix[0]
    turned = matrix / phase
    values = phase * np.linalg.eigvalsh(turned) if _is_hermitian(turned) else np.linalg.eigvals(matrix)
    return np.array(sorted(values, key=lambda z: (z.imag, z.real)))


def _condition(matrix: np.ndarray, phase: complex) -> float:
    return 1.0 if len(matrix) == 1 or _is_hermitian(matrix / phase) else float(np.linalg.cond(np.linalg.eig(matrix)[1]))


@dataclass(frozen=True, eq=False)
class ModeDerivatives:
    """Derivatives of the eigenvalue of one mode with respect to each parameter."""

    mode: Mode  # the mode
    branches: tuple[tuple[Branch, ...], ...]  # for each parameter as many branches as the multiplicity
    splittings: dict[int, Splitting]  # splittings of a defective eigenvalue, by the index of the parameter
    errors: tuple[float, ...]  # for each parameter an estimate of the largest error of the coefficients of its branches


def mode_derivatives(
    system: EquationsOfMotion, mode: Mode, form: MultiplierForm, slopes: Sequence[Slope], doubts: Sequence[Slope | None]
) -> ModeDerivatives:
    count, shapes = mode.multiplicity, mode.shapes
    if not shapes.shape[1]:
        return ModeDerivatives(mode, ((STAYS,) * count,) * len(slopes), {}, (0.0,) * len(slopes))
    vectors = form.vectors(system, mode.eigenvalue, shapes)
    if count == shapes.shape[1]:
        space = Eigenspace(form, mode, vectors)
        if count == 1 or space.correction < EPS**0.5:
            branches = tuple(tuple(Branch(Fraction(1), complex(value)) for value in space.slopes(slope)) for slope in slopes)
            return ModeDerivatives(mode, branches, {}, tuple(map(space.error, slopes, doubts)))
    return _defective(mode, form, slopes, doubts, vectors)


def _defective(mode: Mode, form: MultiplierForm, slopes, doubts, vectors) -> ModeDerivatives:
    """The splitting of a defective eigenvalue by each parameter."""
    rate = float(np.sqrt(np.abs(form.base[0]).max() / (np.abs(form.base[2]).max() or 1.0))) or 1.0
    size, branches, splittings = np.abs(form.base).max(axis=(1, 2)) @ rate ** np.arange(3), [], {}
    left = scipy.linalg.svd(form.at(mode.eigenvalue).T)[2][-vectors.shape[1] :].conj().T
    errors = [0.0] * len(slopes)
    for place, slope in enumerate(each.matrices for each in slopes):
        effect = np.abs(slope).max(axis=(1, 2)) @ rate ** np.arange(3)
        still = not mode.eigenvalue and np.abs(slope[:2] @ vectors).max() <= noise_of(effect, len(slope[0]))
        if not effect or still:  # free motions stay free
            branches.append((STAYS,) * mode.multiplicity)
            continue
        step = float(size / effect)
        splittings[place] = branching = splitting([*form.base], [*slope], mode.eigenvalue, mode.multiplicity, rate, step)
        branches.append(branching.branches)
        doubt = _relative_doubt(slopes[place], doubts[place], mode.eigenvalue, left, vectors)
        rounding = EPS if branching.is_exact else SPLITTING_ROUNDING
        errors[place] = (rounding + doubt) * max(abs(branch.coefficient) for branch in branching.branches)
    return ModeDerivatives(mode, tuple(branches), splittings, tuple(errors))


def _relative_doubt(slope: Slope, doubt: Slope | None, value: complex, left: np.ndarray, right: np.ndarray) -> float:
    """Errors of Y^T L_p X, on which the leading coefficients of a defective eigenvalue depend, relative to it."""
    size, sizes = np.abs(slope.form(left, value, right)).max(), (np.abs(left), abs(value), np.abs(right))
    error = slope.absolute.form(*sizes) * EPS if doubt is None else doubt.absolute.form(*sizes)
    return float(error.max() / size) if size else 0.0


#: Number of modes with a column in a table, and of parameters with a line.
MOST_COLUMNS, MOST_LINES = 4, 30

#: Decimals of a table, unless a smaller number would be 0.
DECIMALS = 3


@dataclass(frozen=True)
class DefectiveEigenvalue:
    """An eigenvalue with fewer shapes than its multiplicity, which has no derivative: s + c e^r for a small change e.

    Attributes:
        mode: its place among the modes, from 0.
        parameter: the name of what changes by e > 0.
        splitting: exponents r and coefficients c of its branches, and whether the given numbers have it exactly.
    """

    mode: int
    parameter: str
    splitting: Splitting

    @property
    def text(self) -> str:
        """The branches as one line of text.

        >>> from mbconstrained import MechanicalSystem
        >>> critical = MechanicalSystem([[1.0]], [[4.0]], [[4.0]])  # s = -2 twice: d^2 = -e
        >>> print(critical.sensitivities(["stiffness[x1, x1]"]).defective[0].text)
        s = -2 with stiffness[x1, x1] + e: -2 + (0 + 1 i) e^1/2, -2 + (0 - 1 i) e^1/2
        """
        s = _complex_text(self.splitting.eigenvalue)
        listed = ", ".join(
            f"{s} + ({_complex_text(branch.coefficient, True)}) e^{branch.exponent}" if branch.coefficient else s
            for branch in self.splitting.branches
        )
        near = "" if self.splitting.is_exact else " (to rounding errors of the data)"
        return f"s = {s}{near} with {self.parameter} + e: {listed}"


def _complex_text(value: complex, always: bool = False) -> str:
    real = f"{value.real:.6g}" if abs(value.real) > noise_of(abs(value)) or not value else "0"
    if abs(value.imag) <= noise_of(abs(value)) and not always:
        return real
    return f"{real} {'-' if value.imag < 0 else '+'} {abs(value.imag):.6g} i"


@dataclass(frozen=True, repr=False, eq=False)
class Sensitivities(Displayed):
    """Derivatives with respect to the parameters of a system.

    Attributes:
        system: the system.
        modes: its modes.
        parameters: parameters with the derivatives of the equations.

    >>> from mbconstrained import LumpedModel
    >>> model = LumpedModel()
    >>> _ = model.mass("cart", 2.0), model.spring("ground", "cart", 8.0, name="mount")
    >>> d = model.assemble().sensitivities()
    >>> d.names, (d.natural_frequencies.ravel() + 0).round(12).tolist(), d.logarithmic.ravel().round(12).tolist()
    (('cart', 'mount', 'mount.rest_length'), [-0.5, 0.125, 0.0], [-0.5, 0.5, 0.0])
    """

    system: EquationsOfMotion
    modes: Modes
    parameters: tuple[Parameter, ...]

    def _summary(self) -> str:
        return f"{counted(len(self.parameters), 'parameter')}, {counted(len(self.modes), 'mode')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (self.table(), *((notice_table(self.notices),) if self.notices else ()))

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on inaccurate derivatives."""
        return doubts_of("the derivatives", self.error_estimate)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the P parameters, in the order of the rows of all derivatives."""
        return tuple(parameter.name for parameter in self.parameters)

    def parameter(self, name: str) -> Parameter:
        """A parameter by its name.

        Raises:
            InputError: an unknown name.
        """
        return parameter_named(self.parameters, name)

    @cached_property
    def _form(self) -> MultiplierForm:
        return MultiplierForm.of(self.system)

    @cached_property
    def of_modes(self) -> tuple[ModeDerivatives, ...]:
        """Derivatives of the eigenvalue of each mode with respect to each parameter; exponents and coefficients for defective ones."""
        slopes = [self._form.slope(self.system, parameter) for parameter in self.parameters]
        doubts = [None if one.error is None else self._form.slope(self.system, one.error) for one in self.parameters]
        with short_work(2 * self.system.size):
            return tuple(mode_derivatives(self.system, mode, self._form, slopes, doubts) for mode in self.modes)

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """ds/dp in the order of ``modes.eigenvalues``, shape (P, m); infinite where s is defective (``defective``)."""
        columns = [
            [branch.coefficient if branch.exponent == 1 else 0.0 if branch.exponent > 1 else np.inf for branch in branches]
            for each in self.of_modes
            for branches in zip(*each.branches)
        ]
        return named_array(np.array(columns, dtype=complex).reshape(-1, len(self.parameters)).T, self.names)

    @property
    def defective(self) -> tuple[DefectiveEigenvalue, ...]:
        """Eigenvalues without derivatives, with the exponents and coefficients in their place."""
        return tuple(
            DefectiveEigenvalue(number, self.names[place], splitting)
            for number, each in enumerate(self.of_modes)
            for place, splitting in each.splittings.items()
            if any(branch.exponent < 1 for branch in splitting.branches)
        )

    @property
    def errors(self) -> np.ndarray:
        """Estimates of the absolute errors of ``eigenvalues``, shape (P, m); for defective ones those of the coefficients.

        The given matrices are taken as exact; the derivatives of parameters have rounding errors, or their own ``error``.
        """
        columns = [each.errors for each in self.of_modes for _ in range(each.mode.multiplicity)]
        return named_array(np.array(columns, dtype=float).reshape(-1, len(self.parameters)).T, self.names)

    @property
    def error_estimate(self) -> float:
        """Largest error relative to the largest derivative by the same parameter, for coefficients to them; at least EPS."""
        columns = [[abs(branch.coefficient) for branch in branches] for each in self.of_modes for branches in zip(*each.branches)]
        sizes = np.array(columns, dtype=float).reshape(-1, len(self.parameters)).T
        defective = np.isinf(self.eigenvalues)
        largest = np.max(sizes, axis=1, where=~defective, initial=0.0, keepdims=True)
        scale = np.where(defective, sizes, largest)
        moving = scale > self.errors  # others do not depend on the parameter
        return float(max(EPS, (self.errors[moving] / scale[moving]).max(initial=0.0)))

    @cached_property
    def _oscillating(self) -> np.ndarray:
        """Indices of the eigenvalues of ``modes.natural_frequencies``."""
        return np.flatnonzero(self.modes.eigenvalues.imag)

    @property
    def natural_frequencies(self) -> np.ndarray:
        """d|s|/dp in rad/s per unit, shape (P, m), in the order of ``modes.natural_frequencies``."""
        s, slopes = self.modes.eigenvalues[self._oscillating], self.eigenvalues[:, self._oscillating]
        with np.errstate(invalid="ignore"):
            values = (s.conj() * slopes).real / np.abs(s)
        return named_array(np.where(np.isfinite(slopes), values, np.inf) + 0.0, self.names)

    @property
    def frequencies_hz(self) -> np.ndarray:
        """Derivatives of the natural frequencies, in Hz per unit of the parameter."""
        return named_array(self.natural_frequencies / (2 * np.pi), self.names)

    @property
    def damping_ratios(self) -> np.ndarray:
        """d(-Re s / |s|)/dp, shape (P, m)."""
        s, slopes = self.modes.eigenvalues[self._oscillating], self.eigenvalues[:, self._oscillating]
        with np.errstate(invalid="ignore"):
            values = -(slopes.real + (-s.real / np.abs(s)) * self.natural_frequencies) / np.abs(s)
        return named_array(np.where(np.isfinite(slopes), values, np.inf), self.names)

    @property
    def logarithmic(self) -> np.ndarray:
        """Logarithmic derivatives (p / w) dw/dp of the natural frequencies, per cent per per cent, shape (P, m)."""
        values = np.array([parameter.value for parameter in self.parameters])
        return named_array(self.natural_frequencies * values[:, None] / self.modes.natural_frequencies, self.names)

    def shapes(self, name: str) -> np.ndarray:
        """du/dp of the oscillating modes, shape (n, m); the largest entry of each u is 1 and stays 1.

        Args:
            name: name of the parameter.

        Raises:
            InputError: an unknown name; a multiple eigenvalue, whose shapes are not unique.
        """
        slope = self._form.slope(self.system, self.parameter(name))
        columns = []
        for mode in self.modes.oscillating:
            if mode.multiplicity > 1:
                raise InputError(f"the eigenvalue {_complex_text(mode.eigenvalue)} is multiple: its shapes have no derivatives")
            vectors = self._form.vectors(self.system, mode.eigenvalue, mode.shapes)
            columns.append(Eigenspace(self._form, mode, vectors).shape_slope(slope))
        return np.array(columns).reshape(-1, self.system.size).T

    def table(self, names: Sequence[str] | None = None) -> TextTable:
        """Ranking of the parameters: change of natural frequencies (%) and damping ratios (0.01) per 1 % of a parameter, largest
        first.

        Args:
            names: names of the parameters; all by default.
        """
        chosen = [self.names.index(self.parameter(name).name) for name in (self.names if names is None else names)]
        shown = min(MOST_COLUMNS, len(self._oscillating))
        percent = self.logarithmic[chosen]
        damping = self.damping_ratios[chosen] * np.array([[self.parameters[i].value] for i in chosen]).reshape(-1, 1)
        influence = np.maximum(np.abs(percent), np.abs(damping)).max(axis=1, initial=0.0)
        order = [i for i in np.argsort(-influence, kind="stable") if influence[i] > SHOWN_INFLUENCE]
        hz = self.modes.frequencies_hz
        heads = [f"{hz[k]:.4g} Hz" for k in range(shown)] + [f"damping {k + 1}" for k in range(shown) if damping[:, k].any()]
        damped = [k for k in range(shown) if damping[:, k].any()]
        rows = tuple(
            (self.names[chosen[i]], *(_entry(percent[i, k]) for k in range(shown)), *(_entry(damping[i, k]) for k in damped))
            for i in order[:MOST_LINES]
        )
        left = len(chosen) - len(rows)
        more = f"; {counted(left, 'further parameter')} with less or no influence" if left else ""
        note = f"per cent of the frequency, and hundredths of the damping ratio, per cent of the parameter{more}"
        return TextTable("Sensitivities", ("parameter", *heads), rows, note)

    # Responses.

    def motion(self, name: str, displacement=None, velocity=None, force=None) -> Motion:
        """dx/dp of a motion from given values at 0-, in closed form: A(s) x_p = f_p - A_p(s) x, whose right-hand side is a Bohl function.

        Args:
            name: name of the parameter.
            displacement, velocity, force: as in ``MechanicalSystem.solve``; they do not depend on the parameter.

        Returns:
            A ``Motion`` of 2 n coordinates: those of the system, then their derivatives, named "d(x1)/d(k)".

        >>> from mbconstrained import MechanicalSystem
        >>> d = MechanicalSystem([[1.0]], stiffness=[[4.0]]).sensitivities()
        >>> motion = d.motion("stiffness[x1, x1]", displacement=[1.0])  # x = cos(sqrt(k) t)
        >>> bool(np.isclose(motion(3.0)[1], -3 / 4 * np.sin(2 * 3.0), rtol=1e-13))
        True
        """
        dual = dual_system(self.system, self.parameter(name))
        start = self.system._start(displacement, velocity)
        if force is not None:
            force = shifted(force if isinstance(force, ImpulsiveSmooth) else step(self.system._vector(force, "force")))
        return dual.solve(*np.pad(start, [(0, 0), (0, self.system.size)]), force=force)

    def frequency_response(self, name: str, frequencies_hz="auto", inputs=None, outputs=None, **options) -> FrequencyResponse:
        """dH/dp = -H A_p H of a frequency response.

        Args:
            name: name of the parameter.
            frequencies_hz, inputs, outputs, options: as in ``MechanicalSystem.frequency_response``, but for inverse quantities.

        Returns:
            A ``FrequencyResponse`` whose ``values`` are dH/dp, with an error estimate.

        >>> from mbconstrained import MechanicalSystem
        >>> d = MechanicalSystem([[1.0]], [[0.5]], [[4.0]]).sensitivities()
        >>> H = d.frequency_response("stiffness[x1, x1]", [1 / (2 * np.pi)])  # at 1 rad/s
        >>> bool(np.isclose(H.values.item(), -1 / (3 + 0.5j) ** 2))
        True
        """
        parameter = self.parameter(name)
        forces = [_moved(key, self.system, parameter) for key in _names(inputs, self.system.names)]
        _, derived = self._outputs(outputs, parameter, options.get("quantity", ""))
        return frequency_response(dual_system(self.system, parameter), frequencies_hz, forces, derived, **options)

    def rms(self, name: str, excitation: Mapping, outputs=None, quantity: str = "displacement", **options) -> np.ndarray:
        """The derivatives of RMS values under random excitation, E[x x_p] / RMS, by the same exact integrals.

        Args:
            name: name of the parameter.
            excitation, outputs, quantity, options: as in ``MechanicalSystem.random_response``.

        Returns:
            Shape (p,), one for each output.

        >>> from mbconstrained import MechanicalSystem, white_noise
        >>> d = MechanicalSystem([[1.0]], [[0.5]], [[2.0]]).sensitivities()  # RMS = sqrt(G / (4 c k))
        >>> bool(np.isclose(d.rms("stiffness[x1, x1]", {"x1": white_noise(4.0)})[0], -1 / (2 * 2.0)))
        True
        """
        parameter = self.parameter(name)
        own, derived = self._outputs(outputs, parameter, quantity)
        moved = {_moved(key, self.system, parameter): spectrum for key, spectrum in excitation.items()}
        R = random_response(dual_system(self.system, parameter), moved, [*own, *derived], quantity, **options)
        covariance, count = R.covariance, len(own)
        return covariance[:count, count:].diagonal() / np.sqrt(covariance.diagonal()[:count])

    def _outputs(self, given, parameter: Parameter, quantity: str) -> tuple[list[str], list[str]]:
        """The outputs and their derivatives in the system of twice the size; for reactions the rows change places."""
        is_reaction = quantity == "reaction"
        own = _names(given, [row.name for row in self.system.rows] if is_reaction else self.system.names)
        derived = [*derivative_names(own, parameter)]
        return (derived, own) if is_reaction else (own, derived)


def _names(given, every: Sequence[str]) -> list[str]:
    return list(every) if given is None else [given] if isinstance(given, str) else list(given)


def _moved(key, system: EquationsOfMotion, parameter: Parameter):
    """An input of the system as one of the system of twice the size, in which forces act on the second half of the coordinates."""
    if isinstance(key, tuple):
        return tuple(_moved(one, system, parameter) for one in key)
    is_force = key in system.names and key not in [row.name for row in system.rows]
    return derivative_names([key], parameter)[0] if is_force else key


def _entry(value: float) -> str:
    if np.isinf(value) or abs(value) <= SHOWN_INFLUENCE:
        return "infinite" if np.isinf(value) else "0"
    return f"{value:+.{DECIMALS}f}" if round(value, DECIMALS) else f"{value:+.1e}"


def sensitivities(system: EquationsOfMotion, parameters=None) -> Sensitivities:
    system._refuse_sparse("sensitivities")
    given = [parameters] if isinstance(parameters, (str, Parameter)) else parameters
    own = [one for one in given or () if isinstance(one, Parameter)]
    if given is not None and len(own) == len(given):
        return Sensitivities(system, system.modes(), tuple(own))
    every = Sensitivities(system, system.modes(), tuple(system.parameters()))
    if given is None:
        return every
    chosen = [one if isinstance(one, Parameter) else every.parameter(one) for one in given]
    return Sensitivities(system, every.modes, tuple(chosen))


# The derivatives of motions and responses, as those of one system of twice the size.
#
# With y = dx/dp the equations and their derivatives with respect to p are together
#
#     [M_p M; M 0] [x; y]'' + [C_p C; C 0] [x; y]' + [K_p K; K 0] [x; y] = [f_p; f] + [A A_p; 0 A]^T [l_p; l],
#     A x^(level) = b,  A_p x^(level) + A y^(level) = b_p:
#
# a mechanical system again, symmetric where the first one is. Its motions, frequency responses and random responses are therefore exact
# derivatives: A(s) y = f_p - A_p(s) x has a Bohl function on the right, H_p = -H A_p H, and E[x y^T] is the derivative of half the
# covariance. Forces act on the second half of the coordinates.


def dual_system(system: EquationsOfMotion, parameter: Parameter) -> EquationsOfMotion:
    """The system of the coordinates x, named as before, and dx/dp, named "d(x)/d(p)"."""
    slopes = parameter.matrices(system.size)
    K, C, M = (
        np.block([[slope, matrix], [matrix, np.zeros_like(matrix)]])
        for slope, matrix in zip(slopes, (system.stiffness, system.damping, system.mass))
    )
    names = (*system.names, *derivative_names(system.names, parameter))
    static = np.concatenate([np.zeros(system.size) + parameter.force, system.static_force])
    force = None if system.excitation is None else shifted(system.excitation)
    units = [*system.units.values()] * 2
    return system.base_class(M, C, K, _rows(system, parameter), names, force, static, units)


def derivative_names(names: Sequence[str], parameter: Parameter) -> tuple[str, ...]:
    return tuple(f"d({name})/d({parameter.name})" for name in names)


def shifted(force: ImpulsiveSmooth) -> ImpulsiveSmooth:
    """[0; f] from f."""
    return force.mapped(np.eye(2 * force.size)[:, force.size :])


def _rows(system: EquationsOfMotion, parameter: Parameter) -> list[Constraint]:
    slopes, values = parameter.constraint_rows(system)
    zero = np.zeros(system.size)
    derived = derivative_names([row.name for row in system.rows], parameter)
    first, second = [], []
    for row, name, slope, value in zip(system.rows, derived, slopes, values):
        right = row.value if row.signal is None else row.signal
        first.append(Constraint(np.concatenate([row.coefficients, zero]), row.level, right, row.name, row.unit))
        second.append(Constraint(np.concatenate([slope, row.coefficients]), row.level, float(value), name, row.unit))
    return first + second
