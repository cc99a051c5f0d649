"""The equations of a mechanical system under harmonic loads and prescribed motions, [P(s), A^T; A s^level, 0] (x, -lambda) = (f, b).

P(s) = M s^2 + C s + K, with structural damping K + i H for w > 0. Coordinates and reactions are unknowns of one regular matrix, M singular
or not, so that reactions have their own elimination and no difference of large forces. So are forces F of springs and dampers, F - (k + c s) a x = 0. Quantities with a prescribed motion for a load
(dynamic stiffness, ...) are responses of [A(s), -B; C, 0]: the forces that move the outputs by one unit each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...frequency.frequency_response import FrequencyResponse, evaluated
from ...frequency.harmonic import Harmonic
from ...ground.checks import nearest, real_number, whole_number
from ...ground.coordinate_units import force_unit, rate_unit, ratio_unit
from ...ground.errors import InputError
from ...linalg.arrays import full
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..channels import Channel, channels, chosen_by_name, coordinate_channels, reference, row_channels
from ..element_matrix import ElementMatrix
from ..element_matrix import modal_damping as modal_damping_elements
from ..energy import CoordinatePart
from ..equations import EquationsOfMotion

if TYPE_CHECKING:
    from ..equations import ElementForce


#: Modes of sparse matrices, where their number is not given.
MODES = 50

#: Rounding errors of the entries of a damping matrix from modes, in units of those of its terms.
MODE_ROUNDING = 16.0


@dataclass(frozen=True)
class Quantity:
    """Quantity of a frequency response.

    Attributes:
        order: order of the derivative of the outputs: 0 displacement, 1 velocity, 2 acceleration.
        inverse: whether forces by motions are given.
    """

    order: int
    inverse: bool = False


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
    """The steady answer to harmonic loads: f e^{+i w t} gives H(i w) f e^{+i w t}, entry by entry with an error estimate.

    >>> from mbconstrained import Constraint, MechanicalSystem
    >>> isolated = MechanicalSystem([[1.0, 0.0], [0.0, 0.0]], [[0.1, -0.1], [-0.1, 0.1]], [[4.0, -4.0], [-4.0, 4.0]],
    ...     [Constraint([0, 1], names="base")], names=["machine", "floor"])
    >>> T = isolated.frequency_response([np.sqrt(8) / (2 * np.pi)], ["base"], ["machine"], quantity="transmissibility")
    >>> bool(np.isclose(abs(T.values.item()), 1.0)), T.units.item()  # at sqrt(2) times the natural frequency
    (True, '1')
    """
    harmonic = harmonic_equations(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to, count)
    return evaluated(replace(harmonic, notices=system.notices), frequencies_hz)


def harmonic_equations(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to=None, count=None) -> Harmonic:
    """The matrices of one response; the arguments are those of ``frequency_response``."""
    if quantity not in QUANTITIES:
        raise InputError(
            f"quantity: found {quantity!r}; expected one of {', '.join(QUANTITIES)}{nearest(str(quantity), QUANTITIES)}"
        )
    if system.is_sparse:
        return _of_modes(system, inputs, outputs, quantity, modal_damping, loss_factor, relative_to, count)
    if count is not None:
        raise InputError("count: the response of a system given by arrays has all its modes; leave count out")
    chosen, rows = QUANTITIES[quantity], system.rows
    elements = {name: Channel(name, one.elongation, one.unit, element=one) for name, one in system.elements.items()}
    default = {"reaction": row_channels(system), "force": list(elements.values())}.get(quantity, coordinate_channels(system))
    known_inputs = chosen_by_name("inputs", inputs, channels(system, "inputs"), coordinate_channels(system))
    known = channels(system, "outputs")
    known = known | elements if quantity == "force" else elements | known
    known_outputs = chosen_by_name("outputs", outputs, known, default)
    _check(quantity, known_inputs, known_outputs)
    levels = [0 if quantity == "transmissibility" else row.order for row in rows]
    coefficients, imaginary, sizes = saddle_point(system, levels, modal_damping, loss_factor)
    B = np.array([channel.unknowns(system) for channel in known_inputs]).T
    C = np.array([channel.unknowns(system) for channel in known_outputs])
    C[:, system.size :] *= -1.0  # the unknowns are -lambda
    if forces := {one.name: one for one in known_outputs if one.element is not None}:
        coefficients, imaginary, sizes = with_element_forces(
            system, (coefficients, imaginary, sizes), {name: one.element for name, one in forces.items()}, loss_factor
        )
        whole = len(coefficients[0])
        B, C = np.pad(B, ((0, len(forces)), (0, 0))), np.pad(C, ((0, 0), (0, len(forces))))
        for place, one in enumerate(forces.values(), whole - len(forces)):
            C[[other is one for other in known_outputs]] = np.eye(1, whole, place)
    if relative_to is not None:
        other = reference(system, relative_to)
        moving = [one.row is None and one.element is None and one.unit == other.unit for one in known_outputs]
        C[:, : system.size] -= np.outer(moving, other.direction)
    names = (*system.names, *(row.name for row in rows), *(f"force of {name}" for name in forces))
    equations = [f"motion of {name}" for name in system.names] + [f"constraint {row.name}" for row in rows]
    equations += [f"force of {name}" for name in forces]
    input_names, output_names = (tuple(channel.name for channel in own) for own in (known_inputs, known_outputs))
    table = np.array([[_unit(output, input, chosen, levels) for input in known_inputs] for output in known_outputs])
    if not chosen.inverse:
        distinct = names if len(set(names)) == len(names) else equations
        A = PolynomialMatrix(coefficients, distinct, equations)
        return Harmonic(A, B, C, chosen.order, imaginary, sizes, input_names, output_names, table, quantity)
    m, size = B.shape[1], len(B)
    wide = [np.pad(matrix, ((0, m), (0, m))) for matrix in coefficients]
    wide[0][:size, size:], wide[chosen.order][size:, :size] = -B, C
    A = PolynomialMatrix(wide)
    pad = ((0, m), (0, m))
    imaginary = None if imaginary is None else np.pad(imaginary, pad)
    sizes = None if sizes is None else np.array([np.pad(matrix, pad) for matrix in sizes])
    select = np.eye(size + m)[size:]
    return Harmonic(A, select.T, select, 0, imaginary, sizes, output_names, input_names, table.T, quantity)


def with_element_forces(system, equations, elements: Mapping[str, ElementForce], loss_factor):
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
    from ..sparse.sparse_response import sparse_harmonic

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
    loads = [channel.name for channel in inputs if channel.row is None]
    motions = [channel.name for channel in outputs if channel.row is None]
    forces = [channel.name for channel in outputs if channel.element is not None]
    no_forces = [channel.name for channel in outputs if channel.element is None]
    reactions = [channel.name for channel in outputs if channel.row is not None]
    chosen = QUANTITIES[quantity]
    if quantity == "transmissibility" and loads:
        raise InputError(
            f'transmissibility: the input "{loads[0]}" is a force; expected constraint rows, whose motion is prescribed'
        )
    if quantity == "reaction" and motions:
        raise InputError(f"reaction: found the coordinate {motions[0]!r}; expected constraint rows")
    if quantity == "force" and no_forces:
        raise InputError(
            f'force: "{no_forces[0]}" is no spring or damper; a coordinate has a receptance, a constraint row a reaction'
        )
    if forces and quantity not in ("force", "receptance", "transmissibility"):
        raise InputError(f'{quantity}: the output "{forces[0]}" is a spring or damper; its force is the quantity "force"')
    if quantity != "reaction" and reactions:
        raise InputError(f'{quantity}: the output "{reactions[0]}" is a constraint row; its force is the quantity "reaction"')
    if chosen.inverse and (len(loads) < len(inputs) or len(inputs) != len(outputs)):
        raise InputError(
            f"{quantity}: it is the inverse of a matrix of responses to forces; expected as many forces on coordinates as outputs"
        )


def _unit(output: Channel, input: Channel, quantity: Quantity, levels: Sequence[int]) -> str:
    """The unit of an output, or its derivative, by an input."""
    is_motion = output.row is None and output.element is None
    above = rate_unit(output.unit, quantity.order) if is_motion else force_unit(output.unit)
    below = force_unit(input.unit) if input.row is None else rate_unit(input.unit, levels[input.row])
    return ratio_unit(below, above) if quantity.inverse else ratio_unit(above, below)


def saddle_point(
    system: EquationsOfMotion, levels: Sequence[int], modal_damping=None, loss_factor=None
) -> tuple[list[np.ndarray], np.ndarray | None, np.ndarray | None]:
    """K, C, M with the constraint rows, the imaginary part of K, and sizes of terms where damping is computed from modes."""
    n, A, k = system.size, system.constraint_matrix, len(system.rows)
    damping, damping_sizes = system.damping, None
    if modal_damping is not None:
        modes = system.modes(damped=False)
        parts = modal_damping_elements(system.mass, system.stiffness, A, modes.natural_frequencies, modes.shapes, modal_damping)
        directions = np.abs(parts.directions)
        damping, damping_sizes = damping + parts.matrix, MODE_ROUNDING * (directions.T * np.abs(parts.constants)) @ directions
    coefficients = [np.pad(matrix, ((0, k), (0, k))) for matrix in (system.stiffness, damping, system.mass)]
    coefficients[0][:n, n:] = A.T
    for place, level in enumerate(levels):
        coefficients[level][n + place, :n] = A[place]
    sizes = None
    if damping_sizes is not None:
        sizes = np.abs(coefficients)
        sizes[1, :n, :n] += damping_sizes
    H = structural_damping(system, loss_factor)
    return coefficients, None if H is None else np.pad(H, ((0, k), (0, k))), sizes


def structural_damping(system: EquationsOfMotion, loss_factor) -> np.ndarray | None:
    """H in K + i H, shape (n, n); None without structural damping."""
    if loss_factor is not None and not isinstance(loss_factor, Mapping):
        return real_number(loss_factor, "loss_factor", minimum=0.0) * system.stiffness
    loss_factor = {**system.loss_factors, **(loss_factor or {})}
    if not loss_factor:
        return None
    springs = {name: part for name, part in system.energy_parts.strain.items() if not isinstance(part, CoordinatePart)}
    H = np.zeros((system.size, system.size))
    for name, value in loss_factor.items():
        if name not in springs:
            known = f"expected one of: {', '.join(springs)}" if springs else "this system has no named springs; give energy_parts"
            raise InputError(f"loss_factor: there is no spring {name!r}{nearest(str(name), springs)}; {known}")
        part = springs[name]
        matrix = part.matrix if isinstance(part, ElementMatrix) else full(part)
        H += real_number(value, f"loss factor of {name}", minimum=0.0) * matrix
    return H
