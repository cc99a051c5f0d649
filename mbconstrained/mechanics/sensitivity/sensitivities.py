"""The sensitivities of a system: derivatives of its modes and responses with respect to its parameters, in closed form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ...exact.splitting import Splitting
from ...ground.checks import counted, nearest
from ...ground.display import Displayed, TextTable, notice_table
from ...ground.errors import InputError
from ...ground.notices import Notice, doubts_of
from ...ground.threads import short_work
from ...ground.tolerances import EPS, SHOWN_INFLUENCE, noise_of
from ...signals.impulsive import ImpulsiveSmooth
from ...signals.inputs import step
from ..constraints import Constraint
from ..equations import EquationsOfMotion
from ..modes import Modes
from ..vibration.harmonic_equations import frequency_response
from ..vibration.random_excitation import random_response
from .mode_derivatives import Eigenspace, ModeDerivatives, MultiplierForm, mode_derivatives
from .parameter import Parameter

if TYPE_CHECKING:
    from ...frequency.frequency_response import FrequencyResponse
    from ..motion import Motion

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
        if name not in self.names:
            raise InputError(
                f'there is no parameter "{name}"{nearest(str(name), self.names)}; there are {", ".join(self.names[:12])}'
            )
        return self.parameters[self.names.index(name)]

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
        return np.array(columns, dtype=complex).reshape(-1, len(self.parameters)).T

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
        return np.array(columns, dtype=float).reshape(-1, len(self.parameters)).T

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
        return np.where(np.isfinite(slopes), values, np.inf) + 0.0

    @property
    def frequencies_hz(self) -> np.ndarray:
        """Derivatives of the natural frequencies, in Hz per unit of the parameter."""
        return self.natural_frequencies / (2 * np.pi)

    @property
    def damping_ratios(self) -> np.ndarray:
        """d(-Re s / |s|)/dp, shape (P, m)."""
        s, slopes = self.modes.eigenvalues[self._oscillating], self.eigenvalues[:, self._oscillating]
        with np.errstate(invalid="ignore"):
            values = -(slopes.real + (-s.real / np.abs(s)) * self.natural_frequencies) / np.abs(s)
        return np.where(np.isfinite(slopes), values, np.inf)

    @property
    def logarithmic(self) -> np.ndarray:
        """Logarithmic derivatives (p / w) dw/dp of the natural frequencies, per cent per per cent, shape (P, m)."""
        values = np.array([parameter.value for parameter in self.parameters])
        return self.natural_frequencies * values[:, None] / self.modes.natural_frequencies

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
    """The sensitivities of a system to all parameters, or to selected ones."""
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
    """The names of the derivatives."""
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
