"""Which part of a machine takes part in a mode: shares of its kinetic and strain energy, by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np

from ..checks import real_array
from ..errors import InputError
from ..tolerances import noise_of
from .element_matrix import ElementMatrix

Matrix = np.ndarray | ElementMatrix


@dataclass(frozen=True)
class CoordinatePart:
    """What of a whole matrix works along one coordinate: x_i (P x)_i. It may be negative; over all i the sum is x^T P x.

    Attributes:
        whole: P, a matrix or its elements.
        place: i, counted from 0.
    """

    whole: Matrix
    place: int


Part = Matrix | CoordinatePart


@dataclass(frozen=True)
class EnergyShares:
    """Shares of the energies of one shape by part; each of the two sums to 1.

    Attributes:
        kinetic: of the kinetic energy; None where the shape has none.
        strain: of the strain energy; None where the shape has none (a rigid body) or where it is mere rounding.
    """

    kinetic: Mapping[str, float] | None
    strain: Mapping[str, float] | None


@dataclass(frozen=True)
class EnergyParts:
    """M and K as sums of named parts, and with them the energy of a shape as a sum of shares.

    The share of the part P in the shape u is Re(u^H P u) over the sum of the same over all parts. For a real shape that is its
    share of 1/2 u^T M u or of 1/2 u^T K u; for a complex one, Re(u e^(i w t)), of the average over a cycle, the decay
    left out.

    Args:
        kinetic: parts of M by name: matrices (n, n), in kg or kg m^2, or ``ElementMatrix``. Their sum is taken to be M.
        strain: parts of K by name, in N/m or N m/rad. A part may be negative (gravity that pulls a pendulum over):
            then other shares are above 1.

    Raises:
        InputError: a part of another shape, or with entries that are not finite.

    >>> springs = {"soft": ElementMatrix([[1, 0]], [2.0]), "stiff": ElementMatrix([[-1, 1]], [6.0])}
    >>> parts = EnergyParts({"cart": np.diag([1.0, 0.0]), "load": np.diag([0.0, 3.0])}, springs)
    >>> parts.shares([1.0, 0.0])
    EnergyShares(kinetic={'cart': 1.0, 'load': 0.0}, strain={'soft': 0.25, 'stiff': 0.75})
    """

    kinetic: Mapping[str, Part]
    strain: Mapping[str, Part]

    def __post_init__(self):
        sizes = set()
        for kind in ("kinetic", "strain"):
            parts = {str(name): _checked(part, f'{kind} part "{name}"') for name, part in getattr(self, kind).items()}
            sizes |= {_size(part) for part in parts.values()}
            object.__setattr__(self, kind, MappingProxyType(parts))
        if len(sizes) > 1:
            raise InputError(f"energy parts: found parts of {' and '.join(map(str, sorted(sizes)))} coordinates; expected one size")

    @property
    def size(self) -> int | None:
        """The number n of coordinates; None where there is no part at all."""
        return next((_size(part) for part in (*self.kinetic.values(), *self.strain.values())), None)

    @property
    def is_by_coordinate(self) -> bool:
        """Whether any of them is the part along a coordinate, of which the share may be negative."""
        return any(isinstance(part, CoordinatePart) for part in (*self.kinetic.values(), *self.strain.values()))

    def shares(self, shape, zero: complex | None = None) -> EnergyShares:
        """The shares of one shape, whatever its length and phase.

        Args:
            shape: u, shape (n,), real or complex.
            zero: s of the mode (1/s). With it, the energy that is mere rounding beside the other is none: |s|^2 u^H M u beside
                u^H K u, and the other way round; at s = 0 no spring is stretched.

        Raises:
            InputError: a shape of another length, with entries that are not finite, or zero.
        """
        shape = _unit_shape(shape, self.size)
        kinetic, strain = (_energies(parts, shape, unit) for parts, unit in zip((self.kinetic, self.strain), self._units))
        if zero:
            speed = 2 * np.log2(abs(zero))
            kinetic, strain = kinetic.beside(strain, speed), strain.beside(kinetic, -speed)
        elif zero is not None:
            strain = _NOTHING
        return EnergyShares(kinetic.shares, strain.shares)

    @cached_property
    def _units(self) -> tuple[int, int]:
        """For each kind the exponent of a power of two above all entries, so that no square leaves the range of float64."""
        return tuple(max(map(_exponent, parts.values()), default=0) for parts in (self.kinetic, self.strain))


def coordinate_parts(names: Sequence[str], mass: Matrix, stiffness: Matrix) -> EnergyParts:
    """One part for each coordinate, x_i (M x)_i and x_i (K x)_i, where nothing is known of masses and springs.

    Such shares may be negative: they are the work along a coordinate, of which a neighbour may give back a part.

    >>> parts = coordinate_parts(["a", "b"], np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> parts.shares([4.0, 1.0]).strain
    {'a': 1.0769230769230769, 'b': -0.07692307692307693}
    """
    parts = [{name: CoordinatePart(whole, i) for i, name in enumerate(names)} for whole in (mass, stiffness)]
    return EnergyParts(*parts)


@dataclass(frozen=True)
class _Energies:
    """Energies by name in units of 2^unit, with the size of the terms that they are sums of."""

    values: Mapping[str, float]
    magnitude: float
    unit: int

    @property
    def total(self) -> float:
        """Their sum; 0 where it is no more than the rounding of its terms."""
        total = float(sum(self.values.values()))
        return total if abs(total) > noise_of(self.magnitude, len(self.values)) else 0.0

    @property
    def shares(self) -> Mapping[str, float] | None:
        """Each over the sum."""
        total = self.total
        return {name: value / total for name, value in self.values.items()} if total else None

    def beside(self, other: _Energies, exponent: float) -> _Energies:
        """These energies times 2^exponent, or none where they are rounding beside the other ones."""
        if not other.total or not self.total:
            return self
        ratio = np.log2(abs(self.total / other.total)) + self.unit - other.unit + exponent
        return self if ratio > np.log2(noise_of(1.0, len(self.values))) else _NOTHING


_NOTHING = _Energies({}, 0.0, 0)


def _energies(parts: Mapping[str, Part], shape: np.ndarray, unit: int) -> _Energies:
    found = {name: _energy(part, shape, unit) for name, part in parts.items()}
    return _Energies({name: value for name, (value, _) in found.items()}, sum(size for _, size in found.values()), unit)


def _checked(part, what: str) -> Part:
    if isinstance(part, (ElementMatrix, CoordinatePart)):
        return part
    matrix = real_array(part, what, shape=(None, None))
    if matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"{what}: expected a square matrix, found {matrix.shape[0]} x {matrix.shape[1]}")
    matrix.flags.writeable = False
    return matrix


def _size(part: Part) -> int:
    whole = part.whole if isinstance(part, CoordinatePart) else part
    return whole.size if isinstance(whole, ElementMatrix) else len(whole)


def _exponent(part: Part) -> int:
    """Of the power of two above the largest entry."""
    whole = part.whole if isinstance(part, CoordinatePart) else part
    row = part.place if isinstance(part, CoordinatePart) else slice(None)
    entries = whole.constants if isinstance(whole, ElementMatrix) else whole[row]
    return int(np.frexp(np.abs(entries).max(initial=0.0))[1])


def _unit_shape(shape, size: int | None) -> np.ndarray:
    """The shape divided by its largest entry."""
    shape = np.asarray(shape)
    parts = [real_array(part, "shape", shape=(size,)) for part in (shape.real, shape.imag)]
    largest = max(np.abs(part).max(initial=0.0) for part in parts)
    if not largest:
        raise InputError("shape: found zeros only; a shape has at least one entry that is not zero")
    return (parts[0] + 1j * parts[1]) / largest if parts[1].any() else parts[0] / largest


def _energy(part: Part, shape: np.ndarray, unit: int) -> tuple[float, float]:
    """Re(u^H P u) / 2^unit, and the same with absolute values throughout."""
    if isinstance(part, CoordinatePart):
        return _work(part, shape, unit)
    if isinstance(part, ElementMatrix):
        terms = np.ldexp(part.constants, -unit) * np.abs(_elongations(part, shape)) ** 2
        return float(terms.sum()), float(np.abs(terms).sum())
    matrix = np.ldexp(part, -unit)
    return float((shape.conj() @ matrix @ shape).real), float(np.abs(shape) @ np.abs(matrix) @ np.abs(shape))


def _work(part: CoordinatePart, shape: np.ndarray, unit: int) -> tuple[float, float]:
    """The same of Re(conj(u_i) (P u)_i)."""
    place, whole = part.place, part.whole
    if isinstance(whole, ElementMatrix):
        terms = whole.directions[:, place] * np.ldexp(whole.constants, -unit) * _elongations(whole, shape)
    else:
        terms = np.ldexp(whole[place], -unit) * shape
    return float((shape[place].conj() * terms.sum()).real), float(np.abs(shape[place] * terms).sum())


def _elongations(elements: ElementMatrix, shape: np.ndarray) -> np.ndarray:
    """B u; what is no more than the rounding of u is zero, so that stiff springs that move as one are not strained by it."""
    found, size = elements.directions @ shape, np.abs(elements.directions) @ np.abs(shape)
    return np.where(np.abs(found) > noise_of(size, elements.size), found, 0.0)
