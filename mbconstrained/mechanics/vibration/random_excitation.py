"""Mechanical systems under random forces and random motions of their supports: the equations of a ``RandomResponse``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...frequency.harmonic import Harmonic
from ...frequency.random.random_response import RandomResponse
from ...frequency.random.spectra import KINDS
from ...frequency.random.spectral_matrix import spectral_matrix
from ...ground.checks import nearest
from ...ground.coordinate_units import force_unit, rate_unit
from ...ground.errors import InputError
from ...polynomial.polynomial_matrix import PolynomialMatrix
from .harmonic_equations import _places, _unambiguous, saddle_point

if TYPE_CHECKING:
    from ..system import MechanicalSystem

#: What the outputs may be, and the order of the derivative of the displacements.
QUANTITIES = {"displacement": 0, "velocity": 1, "acceleration": 2, "reaction": 0}


def random_response(
    system: MechanicalSystem,
    excitation: Mapping,
    outputs: Sequence[str] | str | None = None,
    quantity: str = "displacement",
    relative_to: str | None = None,
    modal_damping=None,
    loss_factor=None,
    coherence=None,
    delays: Mapping | None = None,
) -> RandomResponse:
    """The stationary response to random forces and random motions of supports.

    Args:
        system: of arrays.
        excitation: spectra (``mb.psd``, ``mb.white_noise``, ...) by the names of coordinates, for forces on them, or of constraint rows, for their
            prescribed motions; a coordinate that a row prescribes may stand for the row. Pairs of names have complex cross spectra.
        outputs: names of coordinates, or of constraint rows for reactions; all by default.
        quantity: "displacement", "velocity", "acceleration" or "reaction".
        relative_to: a coordinate, or a row that prescribes one, whose motion is subtracted from the outputs.
        modal_damping, loss_factor: as of ``frequency_response``.
        coherence: ordinary coherence of the inputs, a number or by pairs of names; they are independent by default.
        delays: in s by name of the input, for supports that follow the same process.

    Returns:
        A ``RandomResponse``: ``rms``, ``covariance``, ``moment(k)``, ``psd(f)``, ``infinite``, ...

    Raises:
        InputError: unknown names, spectra of forces on rows or of motions on free coordinates, sparse matrices.

    Base acceleration of a single oscillator, E[a^2] = pi f_n W (1 + 4 z^2) / (4 z) (Crandall and Mark 1963):

    >>> import mbconstrained as mb
    >>> wn, z, W = 20.0, 0.05, 0.3
    >>> c, k = 2 * z * wn, wn**2
    >>> system = mb.MechanicalSystem(np.diag([1.0, 0.0]), [[c, -c], [-c, c]], [[k, -k], [-k, k]], [mb.Constraint([0, 1], names="base")])
    >>> R = system.random_response({"base": mb.white_noise(W, of="acceleration")}, outputs=["x1"], quantity="acceleration")
    >>> bool(np.isclose(R.covariance.item(), wn / 2 * W * (1 + 4 * z**2) / (4 * z), rtol=1e-12))
    True
    """
    if system.is_sparse:
        raise InputError("random_response: not available for sparse matrices; give arrays, as mass.toarray()")
    if quantity not in QUANTITIES:
        raise InputError(
            f"quantity: found {quantity!r}; expected one of {', '.join(QUANTITIES)}{nearest(str(quantity), QUANTITIES)}"
        )
    spectra = spectral_matrix(excitation, coherence, delays)
    n, rows = system.size, system.rows
    row_names = tuple(row.name for row in rows)
    names = _unambiguous(system.names, row_names)
    levels, entries = [row.order for row in rows], []
    for name, spectrum in zip(spectra.names, spectra.spectra):
        place = _input_place(system, names, name, spectrum.of)
        entries.append(place)
        if place >= n:
            if place in entries[:-1]:
                raise InputError(f'excitation: "{name}" prescribes the row "{names[place]}", which has a spectrum already')
            levels[place - n] = KINDS[spectrum.of]
    known = _places(outputs, names, row_names if quantity == "reaction" else system.names, "output")
    for name in known:
        if (names.index(name) >= n) != (quantity == "reaction"):
            kind = "a coordinate" if quantity == "reaction" else "a constraint row"
            raise InputError(f'{quantity}: the output "{name}" is {kind}; expected {"a constraint row" if quantity == "reaction" else "coordinates"}')
    coefficients, imaginary, sizes = saddle_point(system, levels, modal_damping, loss_factor)
    unit = np.eye(n + len(rows))
    C = unit[[names.index(name) for name in known]]
    C[:, n:] *= -1.0  # the unknowns are -lambda
    if relative_to is not None:
        if quantity == "reaction":
            raise InputError("relative_to: reactions are not relative; expected a displacement, velocity or acceleration")
        C = C - unit[_reference(system, names, relative_to)]
    units = system.units
    own = {row.name: force_unit(row.unit) for row in rows}
    out = np.array([own[name] if quantity == "reaction" else rate_unit(units[name], QUANTITIES[quantity]) for name in known])
    A = PolynomialMatrix(coefficients, names, [f"motion of {name}" for name in system.names] + [f"constraint {name}" for name in row_names])
    harmonic = Harmonic(A, unit[:, entries], C, QUANTITIES[quantity], imaginary, sizes, spectra.names, known, out, quantity)
    return RandomResponse(harmonic, spectra)


def _input_place(system, names: list[str], name: str, of: str) -> int:
    """The place of an input among coordinates and rows."""
    if name not in names:
        raise InputError(f"excitation: there is no coordinate or constraint row {name!r}{nearest(str(name), names)}")
    place, n = names.index(name), system.size
    if of == "force":
        if place >= n:
            raise InputError(f'excitation of "{name}": a constraint row has a prescribed motion; expected a spectrum of="acceleration", "velocity" or "displacement"')
        return place
    if place >= n:
        return place
    row = _prescribing_row(system, name)
    if row is None:
        raise InputError(f'excitation of "{name}": no constraint row prescribes its motion; expected a force, or a row such as mb.Constraint({{"{name}": 1}})')
    return n + row


def _prescribing_row(system, name: str) -> int | None:
    """The number of the row that prescribes a coordinate alone, with the factor 1."""
    column = system.names.index(name)
    for number, coefficients in enumerate(system.constraint_matrix):
        if coefficients[column] == 1 and np.count_nonzero(coefficients) == 1:
            return number
    return None


def _reference(system, names: list[str], name: str) -> int:
    """The coordinate whose motion is subtracted."""
    if name in system.names:
        return system.names.index(name)
    if name in names:
        coefficients = system.constraint_matrix[names.index(name) - system.size]
        if np.count_nonzero(coefficients) == 1 and coefficients.max() == 1:
            return int(np.argmax(coefficients))
        raise InputError(f'relative_to: the row "{name}" does not prescribe one coordinate; name a coordinate')
    raise InputError(f"relative_to: there is no coordinate or constraint row {name!r}{nearest(str(name), names)}")
