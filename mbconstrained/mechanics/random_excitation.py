"""Mechanical systems under random forces and random motions of their supports: the equations of a ``RandomResponse``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..frequency.harmonic import Harmonic
from ..frequency.random.random_response import RandomResponse
from ..frequency.random.spectra import KINDS
from ..frequency.random.spectral_matrix import SpectralMatrix, spectral_matrix
from ..ground.checks import nearest
from ..ground.coordinate_units import force_unit, rate_unit
from ..ground.errors import InputError
from ..polynomial.polynomial_matrix import PolynomialMatrix
from .channels import Channel, channels, chosen_by_name, coordinate_channels, row_channels
from .equations import EquationsOfMotion
from .harmonic_response import delayed_unknowns, element_channels, saddle_point, with_channels

#: Quantities of outputs, and their orders of derivative of the displacements; None for forces.
QUANTITIES = {"displacement": 0, "velocity": 1, "acceleration": 2, "reaction": None, "force": None}


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
    if quantity not in QUANTITIES:
        raise InputError(
            f"quantity: found {quantity!r}; expected one of {', '.join(QUANTITIES)}{nearest(str(quantity), QUANTITIES)}"
        )
    spectra, order = spectral_matrix(excitation, coherence, delays), QUANTITIES[quantity]
    inputs, levels = _inputs(system, spectra)
    equations = saddle_point(system, levels, modal_damping, loss_factor)
    if order is None and relative_to is not None:
        raise InputError("relative_to: forces are not relative; expected a displacement, velocity or acceleration")
    chosen = _outputs(system, outputs, quantity)
    (coefficients, imaginary, sizes), B, C = with_channels(system, equations, inputs, chosen, loss_factor, relative_to)
    names = tuple(one.name for one in chosen)
    units = [force_unit(one.unit) if order is None else rate_unit(one.unit, order) for one in chosen]
    unknowns = [f"x {name}" for name in system.names] + [f"reaction {row.name}" for row in system.rows]
    A = PolynomialMatrix(coefficients, [*unknowns, *(f"force {name}" for name in names)][: len(B)])
    harmonic = Harmonic(
        A,
        B,
        C,
        order or 0,
        imaginary,
        sizes,
        spectra.names,
        names,
        np.array(units),
        quantity,
        notices=system.notices,
        delayed=delayed_unknowns(system, A.size),
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


def _outputs(system: EquationsOfMotion, outputs, quantity: str) -> list[Channel]:
    if quantity == "force":
        elements = element_channels(system)
        if not (chosen := chosen_by_name("outputs", outputs, elements, list(elements.values()))):
            raise InputError("force: the system has no springs and dampers with names; expected one of a lumped model or a robot")
        return chosen
    default = row_channels(system) if quantity == "reaction" else coordinate_channels(system)
    chosen = chosen_by_name("outputs", outputs, channels(system, "outputs"), default)
    for one in chosen:
        if (one.row is not None) != (quantity == "reaction"):
            actual, expected = ("a coordinate", "a constraint row") if one.row is None else ("a constraint row", "a coordinate")
            raise InputError(f'{quantity}: the output "{one.name}" is {actual}; expected {expected}')
    return chosen


def _input(system: EquationsOfMotion, name: str, of: str) -> Channel:
    """The channel of a random input: a force along a direction, or the motion that a constraint row prescribes."""
    channel = chosen_by_name("excitation", name, channels(system, "inputs"), ())[0]
    if of == "force":
        if channel.row is not None:
            raise InputError(
                f'excitation of "{name}": a constraint row has a prescribed motion; expected a spectrum of="acceleration", "velocity" or "displacement"'
            )
        return channel
    if channel.row is not None:
        return channel
    rows = [row for row in row_channels(system) if (row.direction == channel.direction).all()]
    if not rows:
        raise InputError(
            f'excitation of "{name}": no constraint row prescribes its motion; expected a spectrum of="force", or a row such as mb.Constraint({{"{name}": 1}})'
        )
    return rows[0]
