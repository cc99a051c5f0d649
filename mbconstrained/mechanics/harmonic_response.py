"""The equations of a mechanical system under harmonic loads and prescribed motions, [P(s), A^T; A s^level, 0] (x, -lambda) = (f, b).

P(s) = M s^2 + C s + K, with structural damping K + i H for w > 0. Coordinates and reactions are unknowns of one regular matrix, M singular
or not, so that reactions have their own elimination and no difference of large forces. So are forces F of springs and dampers,
F - (k + c s) a x = 0, and other outputs that are no plain motions of one order. Quantities with a prescribed motion for a load
(dynamic stiffness, ...) are responses of [A(s), -B; C, 0]: the forces that move the outputs by one unit each.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ..frequency.frequency_response import FrequencyResponse, evaluated
from ..frequency.harmonic import Harmonic
from ..ground.checks import check_known, counted, nearest, real_array, real_number, whole_number
from ..ground.display import Displayed, TextTable, number_text
from ..ground.errors import InputError
from ..ground.named_arrays import named_array
from ..ground.tolerances import EPS, FLOAT64_DIGITS, SAME_FREQUENCY
from ..ground.units import force_unit, rate_unit, ratio_unit
from ..linalg.arrays import full
from ..polynomial.coefficients import Factors
from ..polynomial.delayed_terms import DelayedTerm
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..signals.impulsive import ExactInput, ExactRecord, ExactTerm, ImpulsiveSmooth
from .channels import (
    FORCES,
    MOTIONS,
    ON_GROUND,
    REACTION,
    Channel,
    Output,
    OutputNames,
    channels,
    chosen_by_name,
    coordinate_channels,
    reference,
    row_channels,
    support_of,
)
from .constraints import with_multipliers
from .element_matrix import ElementMatrix
from .element_matrix import modal_damping as modal_damping_elements
from .equations import EquationsOfMotion

if TYPE_CHECKING:
    from .motion import Motion


#: Modes of sparse matrices, where their number is not given.
MODES = 50

#: Rounding errors of the entries of a damping matrix from modes, in units of those of its terms.
MODE_ROUNDING = 16.0


class Quantity(NamedTuple):
    """Quantity of a frequency response."""

    kind: str  # of outputs that are named alone, as in the names of outputs
    inverse: bool = False  # whether forces by motions are given

    @property
    def order(self) -> int:
        """Order of the derivative of the outputs: 0 displacement, 1 velocity, 2 acceleration."""
        return MOTIONS.get(self.kind, 0)


FORCE_TRANSMISSIBILITY = "force transmissibility"
QUANTITIES = {
    "receptance": Quantity("displacement"),
    "mobility": Quantity("velocity"),
    "accelerance": Quantity("acceleration"),
    "dynamic stiffness": Quantity("displacement", inverse=True),
    "impedance": Quantity("velocity", inverse=True),
    "apparent mass": Quantity("acceleration", inverse=True),
    "transmissibility": Quantity("displacement"),
    FORCE_TRANSMISSIBILITY: Quantity("force"),
    "reaction": Quantity("reaction"),
    "force": Quantity("force"),
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
    system.last_harmonic = harmonic = replace(harmonic, notices=system.notices).known(system.last_harmonic)
    return evaluated(harmonic, frequencies_hz)


def harmonic_equations(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to=None, count=None) -> Harmonic:
    """The matrices of one response; the arguments are those of ``frequency_response``."""
    check_known(quantity, QUANTITIES, "quantity")
    if system.is_sparse:
        return _of_modes(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to, count)
    if count is not None:
        raise InputError("count: the response of a system given by arrays has all its modes; leave count out")
    chosen, rows = QUANTITIES[quantity], system.rows
    known_inputs = chosen_by_name("inputs", inputs, channels(system, "inputs"), coordinate_channels(system))
    if inputs is not None:  # a force on a support that moves changes its reaction alone
        moving = [channel for channel, row in zip(row_channels(system), rows) if row.signal is not None]
        known_inputs = [support_of(one, moving) for one in known_inputs]
    known_outputs = _outputs(system, outputs, quantity, known_inputs)
    _check(quantity, known_inputs, known_outputs)
    levels = [0 if quantity == "transmissibility" else row.order for row in rows]
    own = saddle_point(system, levels, modal_damping, loss_factor)
    (coefficients, imaginary, sizes), B, C, power = with_outputs(system, own, known_inputs, known_outputs, loss_factor, relative_to)
    further = [f"output {number}" for number in range(1, len(B) - system.size - len(rows) + 1)]
    names = (*system.names, *(row.name for row in rows), *further)
    equations = [f"motion of {name}" for name in system.names] + [f"constraint {row.name}" for row in rows] + further
    input_names, output_names = (tuple(channel.name for channel in own) for own in (known_inputs, known_outputs))
    below = [force_unit(one.unit) if one.row is None else rate_unit(one.unit, levels[one.row]) for one in known_inputs]
    ratio = cache(ratio_unit)
    table = np.array([[ratio(one.unit, other) for other in below] for one in known_outputs])
    kinds = tuple(quantity_of(one, quantity) for one in known_outputs)
    if not chosen.inverse:
        distinct = names if len(set(names)) == len(names) else equations
        A = PolynomialMatrix(coefficients, distinct, equations)
        delayed = delayed_unknowns(system, A.size)
        arrays = A, B, C, power, imaginary, sizes, input_names, output_names, table, quantity
        return Harmonic(*arrays, delayed=delayed, output_quantities=kinds, elements=_by_elements(system, coefficients))
    table = np.array([[ratio(other, one.unit) for other in below] for one in known_outputs])
    m, size = B.shape[1], len(B)
    wide = [np.pad(matrix, ((0, m), (0, m))) for matrix in coefficients]
    wide[0][:size, size:], wide[chosen.order][size:, :size] = -B, C
    A = PolynomialMatrix(wide)
    pad = ((0, m), (0, m))
    imaginary = None if imaginary is None else np.pad(imaginary, pad)
    sizes = None if sizes is None else np.array([np.pad(matrix, pad) for matrix in sizes])
    select, delayed = np.eye(size + m)[size:], delayed_unknowns(system, size + m)
    arrays = A, select.T, select, 0, imaginary, sizes, output_names, input_names, table.T, quantity
    return Harmonic(*arrays, delayed=delayed, elements=_by_elements(system, wide))


def delayed_unknowns(system: EquationsOfMotion, size: int) -> tuple[DelayedTerm, ...]:
    """The delayed terms among so many unknowns, of which the coordinates are the first."""
    pad = ((0, 0), (0, size - system.size), (0, size - system.size))
    return tuple(replace(term, coefficients=np.pad(term.coefficients, pad)) for term in system.delayed)


def with_outputs(
    system, equations, inputs: Sequence[Channel], outputs: Sequence[Output], loss_factor, relative_to=None
) -> tuple[tuple, np.ndarray, np.ndarray, int]:
    """The equations, B of the inputs, C of the outputs, and the order p of the derivative in s^p C.

    Outputs that are no plain motions or reactions of this order, such as forces of springs, are further unknowns y with the equations
    y - (rows[0] (1 + i eta) + rows[1] s + rows[2] s^2) x - multipliers lambda = 0.
    """
    if relative_to is not None:
        outputs = [one.relative(reference(system, relative_to)) for one in outputs]
    B = np.array([channel.unknowns(system) for channel in inputs]).T
    orders = {one.order for one in outputs if not one.is_zero}
    power = orders.pop() if len(orders) == 1 and None not in orders else 0
    C = np.array([np.concatenate([one.rows[power], -one.multipliers(system.rows)]) for one in outputs]).reshape(
        len(outputs), len(B)
    )
    further = {place: one for place, one in enumerate(outputs) if one.order != power and not one.is_zero}
    if further:
        equations = _with_unknowns(system, equations, list(further.values()), loss_factor)
        B, C = np.pad(B, ((0, len(further)), (0, 0))), np.pad(C, ((0, 0), (0, len(further))))
        C[list(further)] = np.eye(len(further), C.shape[1], C.shape[1] - len(further))
    return equations, B, C, power


def _with_unknowns(system, equations, outputs: Sequence[Output], loss_factor):
    """The equations with those of outputs that are unknowns themselves."""
    coefficients, imaginary, sizes = equations
    n, size, count = system.size, len(coefficients[0]), len(outputs)
    rows = np.array([one.rows for one in outputs]).transpose(1, 0, 2)
    balances = np.array([np.zeros(n) if one.balance is None else one.balance for one in outputs])
    rows[1] += balances @ (coefficients[1][:n, :n] - system.damping)  # damping of modes
    wide = np.pad(np.array(coefficients), ((0, 0), (0, count), (0, count)))
    wide[:, size:, :n], wide[0, size:, size:] = -rows, np.eye(count)
    wide[0, size:, n:size] = [one.multipliers(system.rows) for one in outputs]  # the unknowns are -lambda
    if sizes is not None:
        sizes = np.maximum(np.pad(sizes, ((0, 0), (0, count), (0, count))), np.abs(wide))
    if imaginary is not None:
        structural = balances @ imaginary[:n, :n]
        eta = element_loss_factors(system, loss_factor)
        for place, one in enumerate(outputs):
            parts = ((system.elements[name], factor * eta(name)) for name, factor in one.elements.items())
            structural[place] += sum((factor * part.stiffness * part.elongation for part, factor in parts), np.zeros(n))
        imaginary = np.pad(imaginary, (0, count))
        imaginary[size:, :n] = -structural
    return list(wide), imaginary, sizes


def element_loss_factors(system: EquationsOfMotion, loss_factor) -> Callable[[str], float]:
    """eta of structural damping by the name of a spring."""
    if loss_factor is not None and not isinstance(loss_factor, Mapping):
        return lambda name: float(loss_factor)
    given = {**system.loss_factors, **(loss_factor or {})}
    return lambda name: given.get(name, 0.0)


def _outputs(system: EquationsOfMotion, outputs, quantity: str, inputs: Sequence[Channel]) -> list[Output]:
    """The named outputs, or those that a quantity has by default."""
    names = OutputNames.of(system)
    if quantity == FORCE_TRANSMISSIBILITY:
        default = list(dict.fromkeys(ON_GROUND.get(one.unit, ON_GROUND["m"]) for one in inputs))
    else:
        default = list({"reaction": names.rows, "force": names.elements}.get(quantity, system.names))
    return names.chosen("outputs", outputs, QUANTITIES[quantity].kind, default)


def quantity_of(output: Output, quantity: str) -> str:
    """The quantity of the response where an output is of the kind that it has by default, or else that of the output."""
    kind, own = QUANTITIES[quantity].kind, output.quantity
    if kind in MOTIONS:
        return quantity if own in MOTIONS and MOTIONS[own] == MOTIONS[kind] else own
    return quantity if own == kind or (quantity == FORCE_TRANSMISSIBILITY and own in (*FORCES, REACTION)) else own


def _of_modes(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to, count) -> Harmonic:
    """The harmonic equations of sparse matrices, in their modes."""
    from .sparse.sparse_response import sparse_harmonic

    chosen = QUANTITIES[quantity]
    if chosen.inverse or quantity in ("transmissibility", FORCE_TRANSMISSIBILITY, "reaction", "force"):
        raise InputError(
            f"{quantity}: not available for sparse matrices, which have receptance, mobility and accelerance; give arrays, as mass.toarray()"
        )
    if relative_to is not None or isinstance(loss_factor, Mapping):
        raise InputError(
            f"{'loss_factor by springs' if relative_to is None else 'relative_to'}: not available for sparse matrices; give arrays"
        )
    eta = None if loss_factor is None else real_number(loss_factor, "loss_factor", minimum=0.0)
    number = MODES if count is None else whole_number(count, "count", minimum=1)
    for what, given in (("inputs", inputs), ("outputs", outputs)):
        if given is None:
            raise InputError(f"{what}: a response of sparse matrices needs names of coordinates, such as {system.names[0]!r}")
    named = OutputNames.of(system).chosen("outputs", outputs, chosen.kind, ())
    harmonic = sparse_harmonic(system, inputs, named, quantity, modal_damping, eta, number)
    return replace(harmonic, output_quantities=tuple(quantity_of(one, quantity) for one in named))


def _check(quantity: str, inputs: Sequence[Channel], outputs: Sequence[Output]) -> None:
    """Raise an InputError for quantities that do not fit their inputs or outputs."""
    if not inputs or not outputs:
        missing = "springs and dampers with names" if quantity == "force" else "constraint rows"
        raise InputError(f"{quantity}: this system has no {missing}")
    loads, rows = ([one.name for one in inputs if (one.row is None) == is_load] for is_load in (True, False))
    if quantity == "transmissibility" and loads:
        raise InputError(
            f'{quantity}: the input "{loads[0]}" is a force; expected supports, whose motion a constraint row prescribes, in scenes [[motion]]'
        )
    if quantity == FORCE_TRANSMISSIBILITY and rows:
        raise InputError(f'{quantity}: the input "{rows[0]}" is a prescribed motion; expected forces on coordinates')
    if not (chosen := QUANTITIES[quantity]).inverse:
        return
    if other := next((one.name for one in outputs if one.order != chosen.order or one.reactions), None):
        raise InputError(f'{quantity}: the output "{other}" is no {chosen.kind}; expected coordinates')
    if rows or len(inputs) != len(outputs):
        raise InputError(
            f"{quantity}: it is the inverse of a matrix of responses to forces; expected as many forces on coordinates as outputs"
        )


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


def _by_elements(system: EquationsOfMotion, coefficients: Sequence[np.ndarray]) -> Callable[[], PolynomialMatrix] | None:
    """A(s) with the elements of the system in the place of its assembled matrices; None where it has none."""
    return partial(_of_elements, system, coefficients) if any(isinstance(one, ElementMatrix) for one in system.given) else None


def _of_elements(system: EquationsOfMotion, coefficients: Sequence[np.ndarray]) -> PolynomialMatrix:
    n, size, result = system.size, len(coefficients[0]), list[np.ndarray | Factors](coefficients)
    for order, (whole, matrix) in enumerate(zip(coefficients, system.given)):
        if isinstance(matrix, ElementMatrix) and (whole[:n, :n] == matrix.matrix).all():  # not with damping of modes
            directions, rest = np.pad(matrix.directions, ((0, 0), (0, size - n))), whole.copy()
            rest[:n, :n] = 0.0
            values = np.append(matrix.constants, np.ones(size))
            result[order] = Factors(np.hstack([directions.T, np.eye(size)]), values, np.vstack([directions, rest]))
    return PolynomialMatrix(result)


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
        outputs, output_amplitudes: names and complex amplitudes, shape (m, L), of requested outputs; their units are among ``units``.
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
    output_amplitudes: np.ndarray = field(default_factory=lambda: np.zeros((0, 0), dtype=complex))
    _outputs: tuple[Output, ...] = ()

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the requested outputs."""
        return tuple(one.name for one in self._outputs)

    def _summary(self) -> str:
        lines = counted(len(self.frequencies_hz), "frequency", "frequencies")
        return f"{counted(len(self.names), 'coordinate')}, {lines}"

    def _tables(self) -> tuple[TextTable, ...]:
        cells = []
        parts = (
            (self.names, self.displacement_amplitudes),
            (self.rows, self.reaction_amplitudes),
            (self.outputs, self.output_amplitudes),
        )
        for names, amplitudes in parts:
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

    def output(self, times) -> np.ndarray:
        """The requested outputs at times in s, shape (m,) or (m, T)."""
        if self.motion is None:
            return self._values("", self.output_amplitudes, times)
        since = np.mod(real_array(times, "times"), self.period)
        return np.array([one.values(self.motion, since) for one in self._outputs])

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
    outputs: Sequence[str] | str = (),
    quantity: str = "displacement",
) -> SteadyState:
    """``MechanicalSystem.steady_state``."""
    if system.is_sparse:
        raise InputError("steady_state: not available for sparse matrices; give arrays, as mass.toarray()")
    if period is not None:
        period, harmonics = real_number(period, "period", positive=True), whole_number(harmonics, "harmonics", minimum=1)
    n, rows = system.size, system.rows
    loads: dict[float, np.ndarray] = defaultdict(lambda: np.zeros(n + len(rows), dtype=complex))
    for omega, amplitude in harmonics_of(system._applied(force), period, harmonics):
        loads[omega][:n] += amplitude
    for place, row in enumerate(rows, start=n):
        loads[0.0][place] += row.value
        for omega, amplitude in harmonics_of(row.signal, period, harmonics) if row.signal is not None else ():
            loads[omega][place] += amplitude[0]
    further = OutputNames.of(system).chosen("outputs", outputs, quantity, ()) if len(outputs) else []
    constants = np.array([one.constant for one in further])
    omegas = sorted({omega for omega, load in loads.items() if load.any()} | ({0.0} if constants.any() else set()))
    own = saddle_point(system, [row.order for row in rows], modal_damping, loss_factor)
    names, inputs = (*system.names, *(row.name for row in rows)), [*coordinate_channels(system), *row_channels(system)]
    (coefficients, imaginary, sizes), B, of_outputs, power = with_outputs(system, own, inputs, further, loss_factor)
    A = PolynomialMatrix(coefficients, [*names, *(f"output {number}" for number in range(1, len(B) - len(names) + 1))])
    C = np.vstack([np.diag(np.repeat([1.0, -1.0], [n, len(rows)])) @ np.eye(len(names), len(B)), of_outputs])
    answers, errors = np.zeros((len(C), len(omegas)), dtype=complex), np.zeros(len(omegas))
    labels, outputs = ("real part", "imaginary part"), (*names, *(one.name for one in further))
    elements = _by_elements(system, coefficients)
    delayed, count, f = delayed_unknowns(system, A.size), len(names), np.array(omegas) / (2 * np.pi)
    for columns, weights, lines in _alike([B @ loads[omega] for omega in omegas], f):
        m = columns.shape[1]
        of_lines = Harmonic(
            A, columns, C, 0, imaginary if f[lines[0]] else None, sizes, labels[:m], outputs, np.full((len(C), m), "")
        )
        H = evaluated(replace(of_lines, delayed=delayed, elements=elements), f[lines])
        if H.poles_on_lines:
            if not (at := H.poles_on_lines[0].frequency_hz):
                raise InputError(
                    "force: its constant part moves a body that nothing restores away without end; there is no steady state"
                )
            raise InputError(
                f"force: at {number_text(at)} Hz it acts on an undamped motion of this frequency, which grows; "
                "there is no steady state without damping"
            )
        answers[:, lines] = np.einsum("pml,ml->pl", H.values, weights)
        size = np.abs(H.values[:count])
        largest = np.maximum(size.max(axis=(0, 1)), np.finfo(float).tiny)
        errors[lines] = (H.error_estimate[:count] * size).max(axis=(0, 1)) / largest
    answers[count:] *= (1j * np.array(omegas)) ** power
    if omegas and not omegas[0]:
        answers[count:, 0] += constants
    units = {**system.units, **{row.name: force_unit(row.unit) for row in rows}}
    motion = None
    turns = np.array(omegas) * (period or 0.0) / (2 * np.pi)
    repeats = (np.abs(turns - np.rint(turns)) <= SAME_FREQUENCY * np.maximum(turns, 1.0)).all()
    if period is not None and not (loss_factor or system.loss_factors or system.delayed) and repeats:
        damped = system if modal_damping is None else system.with_modal_damping(modal_damping)
        motion = _periodic_motion(damped, force, period)
        further = [OutputNames.of(damped).output(one.name, quantity) for one in further]
    units |= {one.name: one.unit for one in further}
    amplitudes = named_array(answers[:n], system.names), named_array(answers[n:count], names[n:])
    further_values = answers[count:], tuple(further)
    return SteadyState(system.names, names[n:], f, *amplitudes, errors, units, period, motion, *further_values)


def _alike(loads: Sequence[np.ndarray], frequencies: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, list[int]]]:
    """Lines whose loads are multiples of each other: real columns (r, m), the factors of these (m, L), and the L lines."""
    groups: dict[tuple, tuple[np.ndarray, list[list[complex]], list[int]]] = {}
    for line, (load, frequency) in enumerate(zip(loads, frequencies)):
        factor = load[np.abs(load).argmax()] or 1.0
        columns, weights = (load / factor)[:, None], [factor]
        if (np.abs(columns.imag) > 4 * EPS).any():
            columns, weights = np.stack([load.real, load.imag], axis=1), [1.0, 1j]
        key = bool(frequency), np.round(columns.real, FLOAT64_DIGITS - 2).tobytes()
        _, factors, lines = groups.setdefault(key, (columns.real, [], []))
        factors.append(weights)
        lines.append(line)
    return ((columns, np.array(factors).T, lines) for columns, factors, lines in groups.values())


def _periodic_motion(system: EquationsOfMotion, force: ImpulsiveSmooth | None, period: float) -> Motion | None:
    """The motion whose values just before the end of a period equal those at its start; None where it is not determined."""
    n = system.size
    forced, starts = system.solve(force=force), np.eye(2 * n + 1, 2 * n, -1)  # from rest, and from each unit value
    several = system.solve(starts[:, :n], starts[:, n:], force=force)
    ends = np.hstack([several.displacement(period), several.velocity(period)])
    end, transition = ends[0].reshape(2, n), ends[1:] - ends[0]
    before = end - sum(
        (one.jump[:2] for one in forced.events if abs(one.time - period) <= SAME_FREQUENCY * period), np.zeros((2, n))
    )
    sizes = np.repeat([1.0, 2 * np.pi / period], n)  # of displacements and velocities
    difference = (np.eye(2 * n) - transition.T) * sizes / sizes[:, None]
    if not np.linalg.cond(difference) < EPS**-0.5:  # a free body may be anywhere
        return None
    start = sizes * np.linalg.solve(difference, before.reshape(-1) / sizes)
    return system.solve(start[:n], start[n:], force=force)


def harmonics_of(signal: ImpulsiveSmooth, period: float | None, harmonics: int) -> Iterator[tuple[float, np.ndarray]]:
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
