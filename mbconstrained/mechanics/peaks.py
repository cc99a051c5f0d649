"""Exact peak values of motions, and peaks of buildings by combination of modes from a response spectrum."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..frequency.extrema import Extrema, extrema
from ..frequency.fatigue import CycleCount, cycles_of
from ..frequency.shock_spectrum import ShockResponseSpectrum
from ..ground.checks import check_known, counted, nearest, real_array, real_number
from ..ground.display import Displayed, TextTable, number_text
from ..ground.errors import InputError
from ..ground.named_arrays import named_array
from ..ground.tolerances import STEP_AGREEMENT, noise_of
from ..ground.units import force_unit, rate_unit
from ..signals.bohl import BohlFunction
from .channels import Output, OutputNames, closed_form
from .element_matrix import check_orthogonal, mass_normalized, static_response
from .equations import EquationsOfMotion

# Participation factors and effective masses of modes under a moving base.


@dataclass(frozen=True, repr=False, eq=False)
class EffectiveMasses(Displayed):
    """Shares of the modes without damping in the motion under a base that moves along each of d directions.

    Attributes:
        directions, units: directions and units of the base's motion, and of its masses ("kg"; "kg m^2" of a base that turns).
        frequencies_hz: frequencies of the modes, shape (m,).
        participation_factors: Gamma = u^T h with u^T M u = 1, shape (m, d).
        masses: Gamma^2, shape (m, d).
        totals: totals of all motions relative to the base, shape (d,), including those of free and unstable motions.
    """

    directions: tuple[str, ...]
    units: tuple[str, ...]
    frequencies_hz: np.ndarray
    participation_factors: np.ndarray
    totals: np.ndarray

    @property
    def masses(self) -> np.ndarray:
        return self.participation_factors**2

    def _summary(self) -> str:
        return f"{counted(len(self.directions), 'direction')}, {counted(len(self.frequencies_hz), 'mode')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (self.table(),)

    def table(self) -> TextTable:
        """The masses of every mode, with the share of all modes up to it in the total."""
        scale = np.where(self.totals > 0, self.totals, 1.0)
        masses = np.where(self.masses > noise_of(scale, len(self.masses)), self.masses, 0.0)
        shares = 100 * np.cumsum(masses, axis=0) / scale
        rows = [
            (str(number), number_text(f), *(f"{mass:.4g} ({share:.1f} %)" for mass, share in zip(own, sums)))
            for number, (f, own, sums) in enumerate(zip(self.frequencies_hz, masses, shares), start=1)
        ]
        rows.append(("all", "", *(f"{total:.4g}" for total in self.totals)))
        titles = (f"{name} ({unit})" for name, unit in zip(self.directions, self.units))
        note = "oscillations without damping, by frequency; all: of all motions relative to the base; in brackets: the share up to here"
        return TextTable("Effective modal masses", ("mode", "Hz", *titles), tuple(rows), note)

    def to_dict(self) -> dict:

        return {
            "directions": list(self.directions),
            "units": list(self.units),
            "frequencies_hz": self.frequencies_hz.tolist(),
            "masses": self.masses.tolist(),
            "totals": self.totals.tolist(),
        }


def effective_masses(
    system: EquationsOfMotion, directions: Sequence[str], units: Sequence[str], loads: np.ndarray
) -> EffectiveMasses:
    """Effective masses from the inertial loads h of unit accelerations of the base.

    sum of Gamma_i^2 = h^T V (V^T M V)^+ V^T h,      V a basis of the motions that the constraint rows allow
    """
    check_orthogonal("effective masses", system.mass, system.stiffness)
    modes = system.modes(damped=False)
    w = modes.natural_frequencies
    V = system.constrained_form().null_space
    reduced = V.T @ loads
    totals = np.einsum("id,id->d", reduced, np.linalg.pinv(V.T @ system.mass @ V, hermitian=True) @ reduced)
    factors = mass_normalized(system.mass, modes.shapes.real, w).T @ loads
    return EffectiveMasses(tuple(directions), tuple(units), w / (2 * np.pi), factors, totals)


def loads_of_rows(system: EquationsOfMotion, base) -> tuple[tuple[str, ...], list[str], np.ndarray]:
    """The inertial loads M r of unit motions r of rows."""
    rows = [row.name for row in system.rows]
    names = rows if base is None else base if isinstance(base, Iterable) and not isinstance(base, str) else [base]
    groups = {name: [name] for name in names} if not isinstance(names, Mapping) else names
    groups = {name: [group] if isinstance(group, str) else list(group) for name, group in groups.items()}
    for name in (name for group in groups.values() for name in group):
        if name not in rows:
            raise InputError(f"base: there is no constraint row {name!r}{nearest(str(name), rows)}")
    if not all(groups.values()) or not groups:
        raise InputError("base: the system has no constraint rows; expected rows that prescribe the motion of the supports")
    influence = static_response(system.stiffness, system.constraint_matrix)
    chosen = [[rows.index(name) for name in group] for group in groups.values()]
    units = ["kg m^2" if system.rows[places[0]].unit == "rad" else "kg" for places in chosen]
    loads = system.mass @ np.array([influence[:, places].sum(axis=1) for places in chosen]).T
    return tuple(groups), units, loads


#: Quantities of peaks: displacements, their derivatives, forces of constraint rows, elongations and forces of springs and dampers.
QUANTITIES = ("displacement", "velocity", "acceleration", "reaction", "elongation", "force")

COMBINATIONS = ("CQC", "SRSS")


@dataclass(frozen=True, repr=False, eq=False)
class Peaks(Displayed):
    """The largest and the smallest value of each function over a time, with the times at which they occur.

    Attributes:
        names: of the functions.
        units: of the functions, in SI.
        quantity: "displacement", "velocity", "acceleration", "reaction", "elongation" or "force"; of functions by name "quantities".
        extrema: values and times.
        kinds: of functions by name the quantity of each.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    quantity: str
    extrema: Extrema
    kinds: tuple[str, ...] = ()

    def _summary(self) -> str:
        return f"{self.quantity}, {counted(len(self.names), 'function')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (self.table(lambda unit, name: (unit, 1.0)),)

    def table(self, shown: Callable[[str, str], tuple[str, float]]) -> TextTable:
        """Both extrema of each function with their times; ``shown`` gives the displayed unit and its factor, by SI unit and name."""
        own, texts = self.extrema, []
        ends = zip(own.maximum, own.maximum_time, own.minimum, own.minimum_time, own.is_open.tolist())
        for name, unit, (a, ta, b, tb, is_open) in zip(self.names, self.units, ends):
            text, factor = shown(unit, name)
            high, low = (f"{number_text(factor * value)} {text}" if text != "1" else number_text(value) for value in (a, b))
            texts.append((name, f"{'≥ ' * is_open}{high}", number_text(ta), f"{'≤ ' * is_open}{low}", number_text(tb)))
        return TextTable(f"Peaks of the {self.quantity}", ("of", "maximum", "at (s)", "minimum", "at (s)"), tuple(texts))

    def rows(self) -> list[dict]:
        """The extrema as plain data, one row for each function, in SI."""
        keys = ("maximum", "maximum_time", "minimum", "minimum_time")
        kinds = self.kinds or (self.quantity,) * len(self.names)
        each = zip(kinds, self.names, self.units, *(getattr(self.extrema, key).tolist() for key in keys))
        return [{"quantity": kind, "of": name, "unit": unit, **dict(zip(keys, own))} for kind, name, unit, *own in each]

    @property
    def maximum(self) -> np.ndarray:
        """Largest values, shape (r,)."""
        return named_array(self.extrema.maximum, self.names)

    @property
    def minimum(self) -> np.ndarray:
        """Smallest values, shape (r,)."""
        return named_array(self.extrema.minimum, self.names)

    @property
    def largest(self) -> np.ndarray:
        """Largest moduli, shape (r,)."""
        return named_array(self.extrema.largest, self.names)


def peaks(motion, end: float, of: str | Sequence[str] = "displacement", combinations=None, names=None) -> Peaks:
    """Exact extrema of a motion on [0, end], none missed: branch and bound over the closed form (``frequency.extrema``)."""
    end = real_number(end, "end", positive=True)
    if not isinstance(of, str) or of not in QUANTITIES:
        if combinations is not None:
            raise InputError(f"of: found {of!r}; combinations are those of {', '.join(QUANTITIES)}")
        chosen = OutputNames.of_motion(motion).chosen("of", [] if of is None else of, "displacement", ())
        return peaks_of_outputs(motion, end, chosen)
    function, own, units, constant = _functions(motion, of)
    if combinations is not None:
        matrix = real_array(combinations, "combinations", shape=(None, len(own)))
        function, constant = function.mapped(matrix), matrix @ constant
        units = tuple(" or ".join(sorted({units[i] for i in np.flatnonzero(row)})) or "1" for row in matrix)
        own = tuple(names or (f"combination {i + 1}" for i in range(len(matrix))))
    return Peaks(own, units, of, extrema(function, 0.0, end).shifted(constant))


def cycles(motion, end: float, of: str = "force", outputs: Sequence[str] | None = None) -> dict[str, CycleCount]:
    """Count the cycles of a motion on [0, end] by the rainflow method, from turning points in closed form.

    Args:
        motion: a motion of a mechanical system, from ``system.solve``.
        end: in s.
        of: "force" or "elongation" of springs and dampers, "displacement", "velocity", "acceleration" of coordinates, "reaction" of rows.
        outputs: names of outputs, also such as "velocity of cart" or "cart - wall"; all with the quantity by default.

    Returns:
        A ``CycleCount`` by name, as of ``rainflow``.

    Raises:
        InputError: an unknown quantity or name, an end that is not positive, a motion of too many periods.

    >>> from mbconstrained import MechanicalSystem
    >>> free = MechanicalSystem([[1.0]], None, [[4.0]]).solve(displacement=[1.0])  # cos 2 t
    >>> cycles(free, 10.0, "displacement")
    {'x1': CycleCount(3.5 cycles, ranges up to 2)}
    """
    end = real_number(end, "end", positive=True)
    check_known(of, QUANTITIES, "of")
    if outputs is None:
        function, names, units, constant = _functions(motion, of)
    else:
        function, names, units, constant = _closed_forms(motion, OutputNames.of(motion.system).chosen("outputs", outputs, of, ()))
    counts = cycles_of(function, 0.0, end) if names else []
    return {name: replace(own, means=own.means + c, unit=unit) for name, unit, own, c in zip(names, units, counts, constant)}


def peaks_of_outputs(motion, end: float, outputs: Sequence[Output]) -> Peaks:
    """Exact extrema of outputs on [0, end]."""
    names, units, kinds = zip(*((one.name, one.unit, one.quantity) for one in outputs))
    own = extrema(closed_form(outputs, motion), 0.0, end).shifted(np.array([one.constant for one in outputs]))
    return Peaks(names, units, "quantities", own, kinds)


def _functions(motion, of: str) -> tuple[BohlFunction, tuple[str, ...], tuple[str, ...], np.ndarray]:
    """The functions with names and units, and the constants added to them."""
    system = motion.system
    if of == "reaction":
        rows = motion._reaction_rows
        names, units = tuple(row.name for row in rows), tuple(force_unit(row.unit) for row in rows)
        return motion.reaction_function, names, units, np.zeros(len(rows))
    if of in ("elongation", "force"):
        return _closed_forms(motion, OutputNames.of(system).chosen("of", list(system.elements) or None, of, ()))
    order = QUANTITIES.index(of)
    units = tuple(rate_unit(system.units[name], order) for name in system.names)
    return motion.derivative(order) if order else motion.function, system.names, units, np.zeros(system.size)


def _closed_forms(motion, outputs: Sequence[Output]) -> tuple[BohlFunction, tuple[str, ...], tuple[str, ...], np.ndarray]:
    function = closed_form(outputs, motion) if outputs else motion.function.rows([])
    names, units = tuple(one.name for one in outputs), tuple(one.unit for one in outputs)
    return function, names, units, np.array([one.constant for one in outputs])


@dataclass(frozen=True, repr=False, eq=False)
class ModalCombination(Displayed):
    """Peaks under a moving base, estimated mode by mode from a response spectrum.

    Attributes:
        names: names of the coordinates.
        base_motion: frequencies, participation factors and effective masses.
        frequencies_hz, damping_ratios: frequencies and damping ratios of the modes, shape (m,).
        participation_factors: Gamma_i = u_i^T M r with u_i^T M u_i = 1, shape (m,).
        effective_masses: Gamma_i^2, shape (m,).
        total_mass: r^T M r of all motions that the base allows: the sum of the effective masses of all modes.
        modal_displacements: Gamma_i S_a(f_i) / w_i^2 u_i, relative to the base, shape (n, m).
        correlation: correlation of the modes, shape (m, m).
    """

    names: tuple[str, ...]
    base_motion: EffectiveMasses
    damping_ratios: np.ndarray
    modal_displacements: np.ndarray
    correlation: np.ndarray

    @property
    def frequencies_hz(self) -> np.ndarray:
        return self.base_motion.frequencies_hz

    @property
    def participation_factors(self) -> np.ndarray:
        return self.base_motion.participation_factors[:, 0]

    @property
    def effective_masses(self) -> np.ndarray:
        return self.base_motion.masses[:, 0]

    @property
    def total_mass(self) -> float:
        return float(self.base_motion.totals[0])

    def _summary(self) -> str:
        return f"{counted(len(self.names), 'coordinate')}, {counted(len(self.frequencies_hz), 'mode')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (self.base_motion.table(),)

    @property
    def displacement(self) -> np.ndarray:
        """Combined peaks relative to the base, shape (n,)."""
        return self.combined(np.eye(len(self.names)))

    def combined(self, combinations) -> np.ndarray:
        """Peaks of linear combinations of the displacements relative to the base, such as storey drifts or forces of springs.

        Args:
            combinations: matrix, shape (p, n).

        Returns:
            sqrt(sum of rho_ij q_i q_j), shape (p,).
        """
        q = real_array(combinations, "combinations", shape=(None, len(self.names))) @ self.modal_displacements
        return np.sqrt(np.maximum(np.einsum("pi,ij,pj->p", q, self.correlation, q), 0.0))


def modal_combination(
    system: EquationsOfMotion,
    spectrum,
    base: Sequence[str] | str | None = None,
    damping_ratio: float = 0.05,
    combination: str = "CQC",
) -> ModalCombination:
    """Response spectrum analysis: participation factors, effective masses, peaks by SRSS or CQC."""
    together = [row.name for row in system.rows] if base is None else [base] if isinstance(base, str) else list(base)
    loads = loads_of_rows(system, {"base": together})[2]
    check_known(combination, COMBINATIONS, "combination")
    zeta = real_number(damping_ratio, "damping_ratio", minimum=0.0)
    base_motion = effective_masses(system, ["base"], ["kg"], loads)
    w = 2 * np.pi * base_motion.frequencies_hz
    U = mass_normalized(system.mass, system.modes(damped=False).shapes.real, w)
    accelerations = _spectral_accelerations(spectrum, base_motion.frequencies_hz)
    displacements = U * (base_motion.participation_factors[:, 0] * accelerations / w**2)
    return ModalCombination(system.names, base_motion, np.full(len(w), zeta), displacements, _correlation(w, zeta, combination))


def _spectral_accelerations(spectrum, f: np.ndarray) -> np.ndarray:
    """S_a in m/s^2 at frequencies in Hz."""
    if isinstance(spectrum, ShockResponseSpectrum):
        if spectrum.quantity not in ("absolute acceleration", "pseudo-acceleration"):
            raise InputError(f'spectrum: found one of "{spectrum.quantity}"; expected pseudo-acceleration or absolute acceleration')
        spectrum = spectrum.frequencies_hz, spectrum.maximax
    if isinstance(spectrum, Mapping):
        raise InputError(
            "spectrum: found several; expected one. Compute each support by itself, with base = [its rows]: the peaks of supports that "
            "move independently add as sqrt(sum of squares), those of correlated ones as a sum"
        )
    if callable(spectrum):
        return np.array([real_number(spectrum(float(one)), "spectrum") for one in f])
    table, values = (real_array(one, "spectrum", shape=(None,)) for one in spectrum)
    if len(f) and (f.min() < table.min() * (1 - STEP_AGREEMENT) or f.max() > table.max() * (1 + STEP_AGREEMENT)):
        raise InputError(
            f"spectrum: it covers {table.min():g} Hz to {table.max():g} Hz; the modes have {f.min():g} Hz to {f.max():g} Hz"
        )
    return np.exp(np.interp(np.log(f), np.log(table), np.log(values)))


def _correlation(w: np.ndarray, zeta: float, combination: str) -> np.ndarray:
    """rho_ij of modes of one damping ratio: 8 z^2 (1 + r) r^(3/2) / ((1 - r^2)^2 + 4 z^2 r (1 + r)^2), r = w_j / w_i."""
    if combination == "SRSS" or zeta == 0:
        return np.eye(len(w))
    r = w / w[:, None]
    return 8 * zeta**2 * (1 + r) * r**1.5 / ((1 - r**2) ** 2 + 4 * zeta**2 * r * (1 + r) ** 2)
