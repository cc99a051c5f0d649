"""Mechanical systems under random forces and random motions of their supports: the equations of a ``RandomResponse``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..frequency.harmonic import Harmonic
from ..frequency.random.random_response import RandomResponse
from ..frequency.random.spectra import KINDS, SpectralMatrix, spectral_matrix
from ..ground.checks import check_known
from ..ground.errors import InputError
from ..polynomial.polynomial_matrix import PolynomialMatrix
from .channels import MOTIONS, Channel, OutputNames, channels, chosen_by_name, row_channels, support_of
from .equations import EquationsOfMotion
from .harmonic_response import by_elements, delayed_unknowns, saddle_point, with_outputs

#: Quantities of outputs that are named alone.
QUANTITIES = ("displacement", "velocity", "acceleration", "reaction", "force", "elongation")


def random_response(
    system: EquationsOfMotion,
    excitation: Mapping,
    outputs: Sequence[str] | str | None = None,
    quantity: str = "displacement",
    relative_to: str | None = None,
    modal_damping=None,
    loss_factor=None,
    coherence=None,
    delays: Mapping | None = None,
) -> RandomResponse:
    if system.is_sparse:
        raise InputError("random_response: not available for sparse matrices; give arrays, as mass.toarray()")
    check_known(quantity, QUANTITIES, "quantity")
    spectra, names = spectral_matrix(excitation, coherence, delays), OutputNames.of(system)
    inputs, levels = _inputs(system, spectra)
    equations = saddle_point(system, levels, modal_damping, loss_factor)
    if quantity not in MOTIONS and relative_to is not None:
        raise InputError("relative_to: forces are not relative; expected a displacement, velocity or acceleration")
    default = {"reaction": names.rows, **dict.fromkeys(("force", "elongation"), names.elements)}.get(quantity, system.names)
    chosen = names.chosen("outputs", outputs, quantity, list(default))
    if not chosen:
        missing = "constraint rows" if quantity == "reaction" else "springs and dampers with names"
        raise InputError(f"{quantity}: the system has no {missing}")
    (coefficients, imaginary, sizes), B, C, power = with_outputs(system, equations, inputs, chosen, loss_factor, relative_to)
    unknowns = [f"x {name}" for name in system.names] + [f"reaction {row.name}" for row in system.rows]
    A = PolynomialMatrix(coefficients, [*unknowns, *(f"output {one.name}" for one in chosen)][: len(B)])
    harmonic = Harmonic(
        A,
        B,
        C,
        power,
        imaginary,
        sizes,
        spectra.names,
        tuple(one.name for one in chosen),
        np.array([one.unit for one in chosen]),
        quantity,
        notices=system.notices,
        delayed=delayed_unknowns(system, A.size),
        output_quantities=tuple(one.quantity for one in chosen),
        elements=by_elements(system, coefficients),
    )
    return RandomResponse(harmonic, spectra)


def _inputs(system: EquationsOfMotion, spectra: SpectralMatrix) -> tuple[list[Channel], list[int]]:
    """The channels of the random inputs, and the levels of all rows; random motions have the level of their spectrum."""
    levels, inputs = [row.order for row in system.rows], []
    for name, spectrum in zip(spectra.names, spectra.spectra):
        channel = _input(system, name, spectrum.of)
        if channel.row is not None:
            if any(channel.row == other.row for other in inputs):
                raise InputError(f'excitation: "{name}" prescribes the row "{channel.name}", which has a spectrum already')
            levels[channel.row] = KINDS[spectrum.of]
        inputs.append(channel)
    return inputs, levels


def _input(system: EquationsOfMotion, name: str, of: str) -> Channel:
    """The channel of a random input: a force along a direction, or the motion that a constraint row prescribes."""
    channel = chosen_by_name("excitation", name, channels(system, "inputs"), ())[0]
    if of == "force":
        if channel.row is not None:
            raise InputError(
                f'excitation of "{name}": a constraint row has a prescribed motion; expected a spectrum of="acceleration", "velocity" or "displacement"'
            )
        return channel
    support = support_of(channel, row_channels(system))
    if support.row is None:
        raise InputError(
            f'excitation of "{name}": nothing prescribes its motion; expected a spectrum of="force", or a row such as mb.Constraint({{"{name}": 1}}), in a scene [[motion]] with coordinate = "{name}"'
        )
    return support
