"""The equations of a mechanical system under harmonic loads and prescribed motions, [P(s), A^T; A s^level, 0] (x, -lambda) = (f, b).

P(s) = M s^2 + C s + K, with structural damping K + i H for w > 0. Coordinates and reactions are unknowns of one regular matrix, M singular
or not, so that reactions have their own elimination and no difference of large forces. So are forces F of springs and dampers, F - (k + c s) a x = 0. Quantities with a prescribed motion for a load
(dynamic stiffness, ...) are responses of [A(s), -B; C, 0]: the forces that move the outputs by one unit each.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..frequency.frequency_response import FrequencyResponse, evaluated
from ..frequency.harmonic import Harmonic
from ..ground.by_name import named_array
from ..ground.checks import counted, nearest, real_array, real_number, whole_number
from ..ground.coordinate_units import force_unit, rate_unit, ratio_unit
from ..ground.display import Displayed, TextTable, number_text
from ..ground.errors import InputError
from ..ground.tolerances import SAME_FREQUENCY
from ..linalg.arrays import full
from ..polynomial.delayed_terms import DelayedTerm
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.impulsive import ExactInput, ExactRecord, ExactTerm, ImpulsiveSmooth
from .channels import Channel, channels, chosen_by_name, coordinate_channels, reference, row_channels
from .constraints import with_multipliers
from .element_matrix import ElementMatrix
from .element_matrix import modal_damping as modal_damping_elements
from .equations import EquationsOfMotion

if TYPE_CHECKING:
    from .equations import ElementForce
    from .motion import Motion


#: Modes of sparse matrices, where their number is not given.
MODES = 50

#: Rounding errors of the entries of a damping matrix from modes, in units of those of its terms.
MODE_ROUNDING = 16.0


class Quantity(NamedTuple):
    """Quantity of a frequency response."""

    order: int  # order of the derivative of the outputs: 0 displacement, 1 velocity, 2 acceleration
    inverse: bool = False  # whether forces by motions are given


QUANTITIES = {
    "receptance": Quantity(0),
    "mobility": Quantity(1),
    "accelerance": Quantity(2),
    "dynamic stiffness": Quantity(0, inverse=True),
    "impedance": Quantity(1, inverse=True),
    "apparent mass": Quantity(2, inverse=True),
    "transmissibility": Quantity(0),
    "reaction": Quantity(0),
    "force": Quantity(0),
}


def frequency_response(
    system: EquationsOfMotion,
    frequencies_hz="auto",
    inputs: Sequence[str] | str | None = None,
    outputs: Sequence[str] | str | None = None,
    quantity: str = "receptance",
    modal_damping=None,
    loss_factor=None,
    relative_to: str | None = None,
    count: int | None = None,
) -> FrequencyResponse:
    """``MechanicalSystem.frequency_response``."""
    harmonic = harmonic_equations(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to, count)
    return evaluated(replace(harmonic, notices=system.notices), frequencies_hz)


def harmonic_equations(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to=None, count=None) -> Harmonic:
    """The matrices of one response; the arguments are those of ``frequency_response``."""
    if not isinstance(quantity, str) or quantity not in QUANTITIES:
        raise InputError(
            f"quantity: found {quantity!r}; expected one of {', '.join(QUANTITIES)}{nearest(str(quantity), QUANTITIES)}"
        )
    if system.is_sparse:
        return _of_modes(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to, count)
    if count is not None:
        raise InputError("count: the response of a system given by arrays has all its modes; leave count out")
    chosen, rows = QUANTITIES[quantity], system.rows
    elements = element_channels(system)
    default = {"reaction": row_channels(system), "force": list(elements.values())}.get(quantity, coordinate_channels(system))
    known_inputs = chosen_by_name("inputs", inputs, channels(system, "inputs"), coordinate_channels(system))
    known = channels(system, "outputs")
    known = known | elements if quantity == "force" else elements | known
    known_outputs = chosen_by_name("outputs", outputs, known, default)
    _check(quantity, known_inputs, known_outputs)
    levels = [0 if quantity == "transmissibility" else row.order for row in rows]
    own = saddle_point(system, levels, modal_damping, loss_factor)
    (coefficients, imaginary, sizes), B, C = with_channels(system, own, known_inputs, known_outputs, loss_factor, relative_to)
    forces = [one.name for one in known_outputs if one.element is not None]
    names = (*system.names, *(row.name for row in rows), *(f"force of {name}" for name in forces))
    equations = [f"motion of {name}" for name in system.names] + [f"constraint {row.name}" for row in rows]
    equations += [f"force of {name}" for name in forces]
    input_names, output_names = (tuple(channel.name for channel in own) for own in (known_inputs, known_outputs))
    unit = cache(partial(_unit, quantity=chosen, levels=tuple(levels)))
    kinds = [[(one.unit, one.row, one.element is not None) for one in own] for own in (known_outputs, known_inputs)]
    table = np.array([[unit(output, input) for input in kinds[1]] for output in kinds[0]])
    if not chosen.inverse:
        distinct = names if len(set(names)) == len(names) else equations
        A = PolynomialMatrix(coefficients, distinct, equations)
        delayed = delayed_unknowns(system, A.size)
        return Harmonic(A, B, C, chosen.order, imaginary, sizes, input_names, output_names, table, quantity, delayed=delayed)
    m, size = B.shape[1], len(B)
    wide = [np.pad(matrix, ((0, m), (0, m))) for matrix in coefficients]
    wide[0][:size, size:], wide[chosen.order][size:, :size] = -B, C
    A = PolynomialMatrix(wide)
    pad = ((0, m), (0, m))
    imaginary = None if imaginary is None else np.pad(imaginary, pad)
    sizes = None if sizes is None else np.array([np.pad(matrix, pad) for matrix in sizes])
    select, delayed = np.eye(size + m)[size:], delayed_unknowns(system, size + m)
    return Harmonic(A, select.T, select, 0, imaginary, sizes, output_names, input_names, table.T, quantity, delayed=delayed)


def delayed_unknowns(system: EquationsOfMotion, size: int) -> tuple[DelayedTerm, ...]:
    """The delayed terms among so many unknowns, of which the coordinates are the first."""
    pad = ((0, 0), (0, size - system.size), (0, size - system.size))
    return tuple(replace(term, coefficients=np.pad(term.coefficients, pad)) for term in system.delayed)


def with_channels(system, equations, inputs: Sequence[Channel], outputs: Sequence[Channel], loss_factor, relative_to):
    """The equations, with the forces of elements among the outputs as more unknowns, B of the inputs and C of the outputs."""
    B = np.array([channel.unknowns(system) for channel in inputs]).T
    C = np.array([channel.unknowns(system) for channel in outputs]).reshape(len(outputs), len(B))
    C[:, system.size :] *= -1.0  # the unknowns are -lambda
    if forces := {one.name: one for one in outputs if one.element is not None}:
        equations = _with_element_forces(system, equations, {name: one.element for name, one in forces.items()}, loss_factor)
        whole = len(equations[0][0])
        B, C = np.pad(B, ((0, len(forces)), (0, 0))), np.pad(C, ((0, 0), (0, len(forces))))
        for place, one in enumerate(forces.values(), whole - len(forces)):
            C[[other is one for other in outputs]] = np.eye(1, whole, place)
    if relative_to is not None:
        other = reference(system, relative_to)
        moving = [one.row is None and one.element is None and one.unit == other.unit for one in outputs]
        C[:, : system.size] -= np.outer(moving, other.direction)
    return equations, B, C


def element_channels(system: EquationsOfMotion) -> dict[str, Channel]:
    return {name: Channel(name, one.elongation, one.unit, element=one) for name, one in system.elements.items()}


def _with_element_forces(system, equations, elements: Mapping[str, ElementForce], loss_factor):
    """Equations with the forces F of springs and dampers as more unknowns, F - (k (1 + i eta) + c s) a x = 0."""
    coefficients, imaginary, sizes = equations
    n, size, count = system.size, len(coefficients[0]), len(elements)
    rows = np.array([[one.stiffness * one.elongation for one in elements.values()]])
    rows = np.vstack([rows, [[one.damping * one.elongation for one in elements.values()]]])
    wide = np.pad(np.array(coefficients), ((0, 0), (0, count), (0, count)))
    wide[:2, size:, :n], wide[0, size:, size:] = -rows, np.eye(count)
    if sizes is not None:
        sizes = np.maximum(np.pad(sizes, ((0, 0), (0, count), (0, count))), np.abs(wide))
    if imaginary is not None:
        imaginary = np.pad(imaginary, (0, count))
        given = {**system.loss_factors, **loss_factor} if isinstance(loss_factor, Mapping) else system.loss_factors
        factors = [given.get(name, 0.0) if isinstance(loss_factor, (Mapping, type(None))) else loss_factor for name in elements]
        imaginary[size:, :n] = -np.array(factors, dtype=float)[:, None] * rows[0]
    return list(wide), imaginary, sizes


def _of_modes(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to, count) -> Harmonic:
    """The harmonic equations of sparse matrices, in their modes."""
    from .sparse.sparse_response import sparse_harmonic

    chosen = QUANTITIES[quantity]
    if chosen.inverse or quantity in ("transmissibility", "reaction", "force"):
        raise InputError(
            f"{quantity}: not available for sparse matrices, which have receptance, mobility and accelerance; give arrays, as mass.toarray()"
        )
    if relative_to is not None or isinstance(loss_factor, Mapping):
        raise InputError(
            f"{'loss_factor by springs' if relative_to is None else 'relative_to'}: not available for sparse matrices; give arrays"
        )
    eta = None if loss_factor is None else real_number(loss_factor, "loss_factor", minimum=0.0)
    number = MODES if count is None else whole_number(count, "count", minimum=1)
    return sparse_harmonic(system, inputs, outputs, chosen.order, quantity, modal_damping, eta, number)


def _check(quantity: str, inputs: Sequence[Channel], outputs: Sequence[Channel]) -> None:
    """Raise an InputError for quantities that do not fit their inputs or outputs."""
    if not inputs or not outputs:
        missing = "springs and dampers with names" if quantity == "force" else "constraint rows"
        raise InputError(f"{quantity}: this system has no {missing}")
    loads, coordinates = ([one.name for one in some if one.row is None] for some in (inputs, outputs))
    rows = [one.name for one in outputs if one.row is not None]
    elements, others = ([one.name for one in outputs if (one.element is None) == none] for none in (False, True))
    has_forces = quantity in ("force", "receptance", "transmissibility")
    for refused, names, text in (
        (quantity == "transmissibility", loads, 'the input "{}" is a force; expected constraint rows, whose motion is prescribed'),
        (quantity == "reaction", coordinates, "found the coordinate {!r}; expected constraint rows"),
        (quantity == "force", others, '"{}" is no spring or damper; a coordinate has a receptance, a constraint row a reaction'),
        (not has_forces, elements, 'the output "{}" is a spring or damper; its force is the quantity "force"'),
        (quantity != "reaction", rows, 'the output "{}" is a constraint row; its force is the quantity "reaction"'),
    ):
        if refused and names:
            raise InputError(f"{quantity}: {text.format(names[0])}")
    if QUANTITIES[quantity].inverse and (len(loads) < len(inputs) or len(inputs) != len(outputs)):
        raise InputError(
            f"{quantity}: it is the inverse of a matrix of responses to forces; expected as many forces on coordinates as outputs"
        )


def _unit(output: tuple, input: tuple, quantity: Quantity, levels: Sequence[int]) -> str:
    """The unit of an output, or its derivative, by an input; of each the unit, the constraint row and whether it is an element."""
    (above, row, is_element), (below, motion, _) = output, input
    above = rate_unit(above, quantity.order) if row is None and not is_element else force_unit(above)
    below = force_unit(below) if motion is None else rate_unit(below, levels[motion])
    return ratio_unit(below, above) if quantity.inverse else ratio_unit(above, below)


def saddle_point(
    system: EquationsOfMotion, levels: Sequence[int], modal_damping=None, loss_factor=None
) -> tuple[list[np.ndarray], np.ndarray | None, np.ndarray | None]:
    """K, C, M with the constraint rows, the imaginary part of K, and sizes of terms where damping is computed from modes."""
    n, A = system.size, system.constraint_matrix
    damping, damping_sizes = system.damping, None
    if modal_damping is not None:
        modes = system.modes(damped=False)
        parts = modal_damping_elements(system.mass, system.stiffness, A, modes.natural_frequencies, modes.shapes, modal_damping)
        directions = np.abs(parts.directions)
        damping, damping_sizes = damping + parts.matrix, MODE_ROUNDING * (directions.T * np.abs(parts.constants)) @ directions
    coefficients = with_multipliers((system.stiffness, damping, system.mass), A, levels, sign=1)
    sizes = None
    if damping_sizes is not None:
        sizes = np.abs(coefficients)
        sizes[1, :n, :n] += damping_sizes
    H = structural_damping(system, loss_factor)
    return coefficients, None if H is None else np.pad(H, (0, len(A))), sizes


def structural_damping(system: EquationsOfMotion, loss_factor) -> np.ndarray | None:
    """H in K + i H, shape (n, n); None without structural damping."""
    if loss_factor is not None and not isinstance(loss_factor, Mapping):
        return real_number(loss_factor, "loss_factor", minimum=0.0) * system.stiffness
    loss_factor = {**system.loss_factors, **(loss_factor or {})}
    if not loss_factor:
        return None
    springs = system.energy_parts.strain  # none by coordinate
    H = np.zeros((system.size, system.size))
    for name, value in loss_factor.items():
        if name not in springs:
            known = f"expected one of: {', '.join(springs)}" if springs else "this system has no named springs; give energy_parts"
            raise InputError(f"loss_factor: there is no spring {name!r}{nearest(str(name), springs)}; {known}")
        part = springs[name]
        matrix = part.matrix if isinstance(part, ElementMatrix) else full(part)
        H += real_number(value, f"loss factor of {name}", minimum=0.0) * matrix
    return H


# The steady state under constant and harmonic loads, or under a periodic record: amplitude and phase of every coordinate and reaction.
#
#     f(t) = Re sum of F_l e^{i w_l t}  gives  x(t) = Re sum of H(i w_l) F_l e^{i w_l t}
#
# A record that is linear between its samples and repeated with a period has the Fourier coefficients of its corners and jumps in closed
# form; each harmonic is exact, and so is its answer. Their sum converges slowly where loads jump: values in time are those of the motion
# in one period that ends as it begins, z(T) = Phi z(0) + g, z(0) = (1 - Phi)^-1 g, in closed form.


@dataclass(frozen=True, repr=False, eq=False)
class SteadyState(Displayed):
    """Steady state x(t) = Re sum of displacement_amplitudes e^{i w t}, after all free motion has decayed; lambda likewise.

    Attributes:
        names: of the coordinates.
        rows: names of the constraint rows.
        frequencies_hz: w / (2 pi), ascending, shape (L,); 0 for the mean.
        displacement_amplitudes: complex, shape (n, L).
        reaction_amplitudes: complex, shape (k, L).
        error_estimate: the largest relative error of the amplitudes at each frequency, relative to the largest of them, shape (L,).
        units: units of the coordinates and of the reactions, by name.
        period: T in s of records; None for harmonic loads.
        motion: the motion in one period in closed form, where all loads repeat with it; None where values in time are sums of harmonics.

    The amplitudes and phases are ``abs`` and ``numpy.angle`` of the complex ones.

    >>> import mbconstrained as mb
    >>> system = mb.MechanicalSystem([[1.0]], [[0.5]], [[4.0]])
    >>> steady = system.steady_state(mb.harmonic([3.0], angular_frequency=2.0))  # at resonance c w x = 3
    >>> bool(np.isclose(abs(steady.displacement_amplitudes[0, 0]), 3.0)), bool(np.isclose(steady.displacement(np.pi / 4)[0], 3.0))
    (True, True)
    """

    names: tuple[str, ...]
    rows: tuple[str, ...]
    frequencies_hz: np.ndarray
    displacement_amplitudes: np.ndarray
    reaction_amplitudes: np.ndarray
    error_estimate: np.ndarray
    units: dict[str, str]
    period: float | None = None
    motion: Motion | None = None

    def _summary(self) -> str:
        lines = counted(len(self.frequencies_hz), "frequency", "frequencies")
        return f"{counted(len(self.names), 'coordinate')}, {lines}"

    def _tables(self) -> tuple[TextTable, ...]:
        cells = []
        for names, amplitudes in ((self.names, self.displacement_amplitudes), (self.rows, self.reaction_amplitudes)):
            for name, row in zip(names, amplitudes):
                for f, z in zip(self.frequencies_hz, row):
                    cells.append((name, number_text(f), f"{abs(z):.6g} {self.units[name]}", f"{np.degrees(np.angle(z)):.2f}"))
        return (TextTable("Steady state", ("of", "frequency (Hz)", "amplitude", "phase (°)"), tuple(cells)),)

    @property
    def angular_frequencies(self) -> np.ndarray:
        """w in rad/s, shape (L,)."""
        return 2 * np.pi * self.frequencies_hz

    def displacement(self, times) -> np.ndarray:
        """x at times in s, shape (n,) or (n, T)."""
        return self._values("displacement", self.displacement_amplitudes, times)

    def velocity(self, times) -> np.ndarray:
        """x' at times in s, shape (n,) or (n, T)."""
        return self._values("velocity", 1j * self.angular_frequencies * self.displacement_amplitudes, times)

    def reaction(self, times) -> np.ndarray:
        """The reactions of the constraint rows at times in s, shape (k,) or (k, T), without their Dirac impulses."""
        return self._values("reaction", self.reaction_amplitudes, times)

    def deflection_shape(self, frequency_hz: float) -> np.ndarray:
        """The operating deflection shape at one of the frequencies: complex amplitudes of all coordinates, shape (n,).

        Args:
            frequency_hz: one of ``frequencies_hz``, in Hz.

        Returns:
            x(t) = Re(shape e^{i w t}); of a robot ``linear.output_matrix @ shape`` has that of its points.

        Raises:
            InputError: no load has this frequency.
        """
        f = real_number(frequency_hz, "frequency_hz", minimum=0.0)
        near = np.flatnonzero(np.abs(self.frequencies_hz - f) <= SAME_FREQUENCY * f)
        if not len(near):
            known = ", ".join(number_text(one) for one in self.frequencies_hz[:6])
            raise InputError(
                f"frequency_hz: no load has {f:g} Hz; expected one of {known}{', ...' * (len(self.frequencies_hz) > 6)}"
            )
        return named_array(self.displacement_amplitudes[:, near[0]], self.names)

    def _values(self, quantity: str, amplitudes: np.ndarray, times) -> np.ndarray:
        times = real_array(times, "times")
        if self.motion is not None:
            return getattr(self.motion, quantity)(np.mod(times, self.period))
        values = np.real(amplitudes @ np.exp(np.multiply.outer(1j * self.angular_frequencies, times)))
        return named_array(values, self.rows if quantity == "reaction" else self.names)


def steady_state(
    system: EquationsOfMotion,
    force: ImpulsiveSmooth | None = None,
    period: float | None = None,
    harmonics: int = 50,
    modal_damping=None,
    loss_factor=None,
) -> SteadyState:
    """``MechanicalSystem.steady_state``."""
    if system.is_sparse:
        raise InputError("steady_state: not available for sparse matrices; give arrays, as mass.toarray()")
    if period is not None:
        period, harmonics = real_number(period, "period", positive=True), whole_number(harmonics, "harmonics", minimum=1)
    n, rows = system.size, system.rows
    loads: dict[float, np.ndarray] = defaultdict(lambda: np.zeros(n + len(rows), dtype=complex))
    for omega, amplitude in _spectrum(system._applied(force), period, harmonics):
        loads[omega][:n] += amplitude
    for place, row in enumerate(rows, start=n):
        loads[0.0][place] += row.value
        for omega, amplitude in _spectrum(row.signal, period, harmonics) if getattr(row, "signal", None) is not None else ():
            loads[omega][place] += amplitude[0]
    omegas = sorted(omega for omega, load in loads.items() if load.any())
    coefficients, imaginary, sizes = saddle_point(system, [row.order for row in rows], modal_damping, loss_factor)
    names = (*system.names, *(row.name for row in rows))
    A, C = PolynomialMatrix(coefficients, names), np.diag(np.repeat([1.0, -1.0], [n, len(rows)]))
    answers, errors = np.zeros((len(C), len(omegas)), dtype=complex), np.zeros(len(omegas))
    for line, omega in enumerate(omegas):
        parts = np.stack([loads[omega].real, loads[omega].imag], axis=1)
        structural = imaginary if omega else None
        table = np.full((len(C), 2), "")
        delayed = delayed_unknowns(system, A.size)
        own = Harmonic(A, parts, C, 0, structural, sizes, ("real part", "imaginary part"), names, table, delayed=delayed)
        H = evaluated(own, [omega / (2 * np.pi)])
        if H.poles_on_lines:
            raise InputError(
                f"force: at {number_text(omega / (2 * np.pi))} Hz it acts on an undamped motion of this frequency, which grows; "
                "there is no steady state without damping"
            )
        answers[:, line] = H.values[..., 0] @ [1.0, 1j]
        size = np.abs(H.values[..., 0])
        errors[line] = (H.error_estimate[..., 0] * size).max() / max(size.max(), np.finfo(float).tiny)
    units = {**system.units, **{row.name: force_unit(row.unit) for row in rows}}
    f = np.array(omegas) / (2 * np.pi)
    motion = None
    turns = np.array(omegas) * (period or 0.0) / (2 * np.pi)
    repeats = (np.abs(turns - np.rint(turns)) <= SAME_FREQUENCY * np.maximum(turns, 1.0)).all()
    if period is not None and not (loss_factor or system.loss_factors or system.delayed) and repeats:
        damped = system if modal_damping is None else system.with_modal_damping(modal_damping)
        motion = _periodic_motion(damped, force, period)
    amplitudes = named_array(answers[:n], system.names), named_array(answers[n:], names[n:])
    return SteadyState(system.names, names[n:], f, *amplitudes, errors, units, period, motion)


def _periodic_motion(system: EquationsOfMotion, force: ImpulsiveSmooth | None, period: float) -> Motion | None:
    """The motion whose values just before the end of a period equal those at its start; None where it is not determined."""
    n = system.size
    forced = system.solve(force=force)
    end = np.array([forced.displacement(period), forced.velocity(period)])
    before = end - sum(
        (one.jump[:2] for one in forced.events if abs(one.time - period) <= SAME_FREQUENCY * period), np.zeros((2, n))
    )
    starts = np.concatenate([np.eye(n), np.zeros((n, n))]), np.concatenate([np.zeros((n, n)), np.eye(n)])
    several = system.solve(*starts, force=force)
    transition = np.hstack([several.displacement(period), several.velocity(period)]) - end.reshape(-1)
    try:
        start = np.linalg.solve(np.eye(2 * n) - transition.T, before.reshape(-1))
    except np.linalg.LinAlgError:
        return None
    return system.solve(start[:n], start[n:], force=force)


def _spectrum(signal: ImpulsiveSmooth, period: float | None, harmonics: int) -> Iterator[tuple[float, np.ndarray]]:
    """Angular frequencies w and amplitudes F of f(t) = Re sum of F e^{i w t}, F of shape (r,)."""
    for part in signal.exact_parts:
        data = part.data
        if part.derivatives == 0 and isinstance(data, ExactTerm) and not data.power and not data.rate:
            turn = np.exp(1j * (data.phase - data.angular_frequency * part.rounded_time()))
            vector = _mapped(part, data.vector) / data.divisor
            negative = data.angular_frequency < 0
            yield abs(data.angular_frequency), vector * (turn.conj() if negative else turn if data.angular_frequency else turn.real)
        elif part.derivatives == 0 and isinstance(data, ExactRecord) and period is not None:
            times = data.times + part.rounded_time()
            if times[0] < 0 or times[-1] > period * (1 + np.finfo(float).eps):
                raise InputError(
                    f"period: found {period:g} s; the samples of a record reach from {times[0]:g} s to {times[-1]:g} s"
                )
            for k in range(harmonics + 1):
                yield 2 * np.pi * k / period, _mapped(part, fourier_coefficient(times, data.values, period, k))
        else:
            raise InputError(
                "force: a steady state needs constant and harmonic loads (mb.step, mb.harmonic), or records (mb.sampled) with a period"
            )


def _mapped(part: ExactInput, vector: np.ndarray) -> np.ndarray:
    for factor in part.maps:
        vector = factor @ vector if np.ndim(factor) else factor * vector
    return vector


def fourier_coefficient(times, values, period: float, order: int) -> np.ndarray:
    """F_k of f(t) = Re sum of F_k e^{2 pi i k t / T}, of samples joined by straight lines, zero outside them, repeated with T.

    Over a line from a to b the integral of f e^{-i w t} is h e^{-i w m} ((a + b)/2 even(y) - i (b - a)/2 odd(y)), m its middle; the
    functions of w h / 2 are taken without cancellation.
    """
    from scipy.special import spherical_jn

    h, w = np.diff(times), 2 * np.pi * order / period
    middle, mean, half = (times[1:] + times[:-1]) / 2, (values[:, 1:] + values[:, :-1]) / 2, np.diff(values, axis=1) / 2
    y = w * h / 2  # on the line f = mean + half u, u from -1 to 1: the integrals of cos(y u) and u sin(y u)
    even, odd = np.sinc(y / np.pi), spherical_jn(1, y)
    total = ((mean * even - 1j * half * odd) * (h * np.exp(-1j * w * middle))).sum(axis=1)
    return total / period * (1 if order == 0 else 2)
