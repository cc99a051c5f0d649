"""The equations of a mechanical system under harmonic loads and prescribed motions, [P(s), A^T; A s^level, 0] (x, -lambda) = (f, b).

P(s) = M s^2 + C s + K, with structural damping K + i H for w > 0. Coordinates and reactions are unknowns of one regular matrix, M singular
or not, so that reactions have their own elimination and no difference of large forces. Quantities with a prescribed motion for a load
(dynamic stiffness, ...) are responses of [A(s), -B; C, 0]: the forces that move the outputs by one unit each.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ...frequency.frequency_response import FrequencyResponse, evaluated
from ...frequency.harmonic import Harmonic
from ...ground.checks import nearest, real_number
from ...ground.coordinate_units import force_unit, rate_unit
from ...ground.errors import InputError
from ...linalg.arrays import full
from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..element_matrix import ElementMatrix
from ..element_matrix import modal_damping as modal_damping_elements
from ..energy import CoordinatePart

if TYPE_CHECKING:
    from ..system import MechanicalSystem


#: Rounding errors of the entries of a damping matrix from modes, in units of those of its terms.
MODE_ROUNDING = 16.0


@dataclass(frozen=True)
class Quantity:
    """What a response gives.

    Attributes:
        order: of the derivative of the outputs: 0 displacement, 1 velocity, 2 acceleration.
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
}


def frequency_response(
    system: MechanicalSystem,
    frequencies_hz="auto",
    inputs: Sequence[str] | str | None = None,
    outputs: Sequence[str] | str | None = None,
    quantity: str = "receptance",
    modal_damping=None,
    loss_factor=None,
) -> FrequencyResponse:
    """The steady answer to harmonic loads: f e^{+i w t} gives H(i w) f e^{+i w t}, entry by entry with an error estimate.

    Args:
        system: of arrays.
        frequencies_hz: shape (F,); "auto" places them by the poles, so that no peak is missed.
        inputs: names of coordinates, each a force on it (N, N m), or of constraint rows, each its prescribed motion b at the
            level of the row; all coordinates by default.
        outputs: names of coordinates, of constraint rows for reactions; all by default.
        quantity: "receptance" x/f, "mobility" x'/f, "accelerance" x''/f; their inverses "dynamic stiffness", "impedance" and
            "apparent mass", the forces at the inputs for a unit motion of one output, the other outputs at rest and all other
            coordinates free (shape (inputs, outputs, F)); "transmissibility" x by a prescribed motion of a row, both
            displacements; "reaction" of constraint rows.
        modal_damping: damping ratios in addition to C: one for all modes, or one for each, ascending by frequency.
        loss_factor: eta of structural damping, K (1 + i eta), of the whole model or by name of the springs. It exists for
            harmonic motion only: in time it would answer before the load.

    Returns:
        A ``FrequencyResponse``: ``values`` (outputs, inputs, F), ``error_estimate``, ``poles``, ``residues``, ``peaks``, ...

    Raises:
        InputError: unknown names, a quantity that does not fit, frequencies that are negative; sparse matrices.
        SingularPolynomialMatrix: the motion is not determined.

    >>> from mbconstrained import Constraint, MechanicalSystem
    >>> isolated = MechanicalSystem([[1.0, 0.0], [0.0, 0.0]], [[0.1, -0.1], [-0.1, 0.1]], [[4.0, -4.0], [-4.0, 4.0]],
    ...     [Constraint([0, 1], names="base")], names=["machine", "floor"])
    >>> T = isolated.frequency_response([np.sqrt(8) / (2 * np.pi)], ["base"], ["machine"], quantity="transmissibility")
    >>> bool(np.isclose(abs(T.values.item()), 1.0)), T.units.item()  # at sqrt(2) times the natural frequency
    (True, '1')
    """
    harmonic = harmonic_equations(system, inputs, outputs, quantity, modal_damping, loss_factor)
    return evaluated(harmonic, frequencies_hz)


def harmonic_equations(system, inputs, outputs, quantity, modal_damping, loss_factor) -> Harmonic:
    """The matrices of one response; arguments as of ``frequency_response``.

    Args:
        system, inputs, outputs, quantity, modal_damping, loss_factor: as there.

    Returns:
        The matrices.
    """
    if system.is_sparse:
        raise InputError("frequency_response: not available for sparse matrices yet; give arrays, as mass.toarray()")
    if quantity not in QUANTITIES:
        raise InputError(
            f"quantity: found {quantity!r}; expected one of {', '.join(QUANTITIES)}{nearest(str(quantity), QUANTITIES)}"
        )
    chosen, n, rows = QUANTITIES[quantity], system.size, system.rows
    row_names = tuple(row.name for row in rows)
    names = _unambiguous(system.names, row_names)
    known_inputs = _places(inputs, names, system.names, "input")
    default = row_names if quantity == "reaction" else system.names
    known_outputs = _places(outputs, names, default, "output")
    _check(quantity, known_inputs, known_outputs, names, n)
    levels = [0 if quantity == "transmissibility" else row.order for row in rows]
    coefficients, imaginary, sizes = saddle_point(system, levels, modal_damping, loss_factor)
    unit = np.eye(n + len(rows))
    B = unit[:, [names.index(name) for name in known_inputs]]
    C = unit[[names.index(name) for name in known_outputs]]
    C[:, n:] *= -1.0  # the unknowns are -lambda
    units = _Units(system, levels)
    equations = [f"motion of {name}" for name in system.names] + [f"constraint {name}" for name in row_names]
    if not chosen.inverse:
        table = [[units.of(output, input, chosen.order) for input in known_inputs] for output in known_outputs]
        A = PolynomialMatrix(coefficients, names, equations)
        return Harmonic(A, B, C, chosen.order, imaginary, sizes, known_inputs, known_outputs, np.array(table), quantity)
    m = len(known_inputs)
    wide = [np.pad(matrix, ((0, m), (0, m))) for matrix in coefficients]
    wide[0][: len(unit), len(unit) :], wide[chosen.order][len(unit) :, : len(unit)] = -B, C
    A = PolynomialMatrix(wide)
    pad = ((0, m), (0, m))
    imaginary = None if imaginary is None else np.pad(imaginary, pad)
    sizes = None if sizes is None else np.array([np.pad(matrix, pad) for matrix in sizes])
    select = np.eye(len(unit) + m)[len(unit) :]
    table = [[units.of(output, input, chosen.order, inverse=True) for output in known_outputs] for input in known_inputs]
    return Harmonic(A, select.T, select, 0, imaginary, sizes, known_outputs, known_inputs, np.array(table), quantity)


def _unambiguous(coordinates: Sequence[str], rows: Sequence[str]) -> list[str]:
    both = set(coordinates) & set(rows)
    if both:
        raise InputError(f'the name "{min(both)}" is that of a coordinate and of a constraint row; rename one of them')
    return [*coordinates, *rows]


def _places(chosen, names: Sequence[str], default: Sequence[str], what: str) -> tuple[str, ...]:
    """The names of the inputs or outputs, each a coordinate or a constraint row."""
    result = tuple(default if chosen is None else [chosen] if isinstance(chosen, str) else chosen)
    if not result:
        raise InputError(f"{what}s: none was named; give one or several of {', '.join(names[:6])}{', ...' * (len(names) > 6)}")
    for name in result:
        if name not in names:
            raise InputError(f"{what}s: there is no coordinate or constraint row {name!r}{nearest(str(name), names)}")
    if len(set(result)) < len(result):
        raise InputError(f"{what}s: a name is given twice; names must differ")
    return result


def _check(quantity: str, inputs, outputs, names, n: int) -> None:
    """Quantities that do not fit their inputs or outputs."""
    prescribed = [name for name in inputs if names.index(name) >= n]
    reactions = [name for name in outputs if names.index(name) >= n]
    chosen = QUANTITIES[quantity]
    if quantity == "transmissibility" and len(prescribed) < len(inputs):
        loads = [name for name in inputs if name not in prescribed]
        raise InputError(
            f'transmissibility: the input "{loads[0]}" is a force; expected constraint rows, whose motion is prescribed'
        )
    if quantity == "reaction" and len(reactions) < len(outputs):
        raise InputError(
            f"reaction: found the coordinate {next(o for o in outputs if o not in reactions)!r}; expected constraint rows"
        )
    if quantity != "reaction" and reactions:
        raise InputError(f'{quantity}: the output "{reactions[0]}" is a constraint row; its force is the quantity "reaction"')
    if chosen.inverse and (prescribed or len(inputs) != len(outputs)):
        raise InputError(
            f"{quantity}: it is the inverse of a matrix of responses to forces; expected as many forces on coordinates as outputs"
        )


@dataclass(frozen=True)
class _Units:
    """Units of entries."""

    system: MechanicalSystem
    levels: list[int]

    def of(self, output: str, input: str, order: int, inverse: bool = False) -> str:
        """The unit of an output, or its derivative, by an input."""
        units, rows = self.system.units, {row.name: row for row in self.system.rows}
        level = {row.name: own for row, own in zip(self.system.rows, self.levels)}
        above = force_unit(rows[output].unit) if output in rows else rate_unit(units[output], order)
        below = rate_unit(rows[input].unit, level[input]) if input in rows else force_unit(units[input])
        return _ratio(below, above) if inverse else _ratio(above, below)


def _ratio(above: str, below: str) -> str:
    if above == below:
        return "1"
    if below == "1":
        return above
    return f"{above}/{below}" if not any(sign in below for sign in " /") else f"{above}/({below})"


def saddle_point(
    system: MechanicalSystem, levels: Sequence[int], modal_damping=None, loss_factor=None
) -> tuple[list[np.ndarray], np.ndarray | None, np.ndarray | None]:
    """K, C, M with the constraint rows, the imaginary part of K, and sizes of terms where damping is computed from modes.

    Args:
        system: with n coordinates and k rows.
        levels: the order of the derivative in each row.
        modal_damping, loss_factor: as of ``frequency_response``.

    Returns:
        Coefficients of shape (n + k, n + k), and None where there is no imaginary part, or no such sizes.
    """
    n, A, k = system.size, system.constraint_matrix, len(system.rows)
    damping, damping_sizes = system.damping, None
    if modal_damping is not None:
        parts = modal_damping_elements(system.mass, system.stiffness, A, system.modes(damped=False), modal_damping)
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


def structural_damping(system: MechanicalSystem, loss_factor) -> np.ndarray | None:
    """H in K + i H, shape (n, n); None without structural damping.

    Args:
        system: with stiffness and its parts.
        loss_factor: of the whole stiffness, or by name of its parts (springs); those that are not named have none.

    Returns:
        The matrix, or None.
    """
    if loss_factor is None:
        return None
    if not isinstance(loss_factor, Mapping):
        return real_number(loss_factor, "loss_factor", minimum=0.0) * system.stiffness
    springs = {name: part for name, part in system.energy_parts.strain.items() if not isinstance(part, CoordinatePart)}
    H = np.zeros((system.size, system.size))
    for name, value in loss_factor.items():
        if name not in springs:
            known = f"expected of {', '.join(springs)}" if springs else "this system has no named springs; give energy_parts"
            raise InputError(f"loss_factor: there is no spring {name!r}{nearest(str(name), springs)}; {known}")
        part = springs[name]
        matrix = part.matrix if isinstance(part, ElementMatrix) else full(part)
        H += real_number(value, f"loss factor of {name}", minimum=0.0) * matrix
    return H
