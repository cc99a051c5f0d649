"""The mechanical energy of a motion over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import log2
from typing import NamedTuple

import numpy as np
import scipy

from ..ground.by_name import Public
from ..ground.checks import NamedNumbers, ReadOnly, counted, real_array
from ..ground.display import Displayed
from ..ground.errors import InputError
from ..ground.tolerances import noise_of
from ..linalg.arrays import Matrix as AnyMatrix
from ..linalg.arrays import kept, product
from .element_matrix import ElementMatrix


@dataclass(frozen=True, eq=False)
class Energy(Public):
    """Energies in joules, each a number or shape (T,).

    Not included: the energy dissipated by dampers, and the work of forces that vary in time, of impulses and of
    constraint rows with a value at velocity or acceleration level. Without those the total is constant for t > 0.

    Attributes:
        kinetic: 1/2 x'^T M x'.
        strain: 1/2 x^T K x, from the symmetric part of K; zero at x = 0.
        static: -f_0^T x, the potential of the constant forces f_0 (rest lengths, weight) of the system; zero at
            x = 0. Strain and static energy together differ from the energy stored in springs of a given rest length
            and in heights only by a constant.
        total: the sum.
    """

    kinetic: np.ndarray
    strain: np.ndarray
    static: np.ndarray

    @property
    def total(self) -> np.ndarray:
        """kinetic + strain + static."""
        return self.kinetic + self.strain + self.static


def energy_of(given: Sequence, static_force: np.ndarray, displacement: np.ndarray, velocity: np.ndarray) -> Energy:
    """The energies at states of a system with K, C, M as given."""
    stiffness, _, mass = given
    return Energy(
        kinetic=_half_square(mass, velocity),
        strain=_half_square(stiffness, displacement),
        static=-np.tensordot(static_force, displacement, 1),
    )


def _half_square(matrix, vectors):
    """1/2 v^T A v, element by element where A is given so: the difference of products of stiff springs would be rounding error."""
    columns = vectors.reshape(len(vectors), -1)
    if isinstance(matrix, ElementMatrix):
        squares = matrix.constants @ (kept(matrix.directions) @ columns) ** 2
    else:
        matrix = kept(matrix) if isinstance(matrix, np.ndarray) else matrix
        squares = np.einsum("ij,ij->j", columns, matrix @ columns)
    return squares.reshape(vectors.shape[1:]) / 2


# Energy shares of modes: which part of a machine has how much of the kinetic and strain energy, by name.

EnergyPart = np.ndarray | ElementMatrix


@dataclass(frozen=True)
class EnergyShares:
    """Shares of the energies of one shape by part; each of the two sums to 1.

    Attributes:
        kinetic: shares of the kinetic energy; None where the shape has none.
        strain: shares of the strain energy; None where the shape has none (a rigid body) or only rounding errors.
    """

    kinetic: Mapping[str, float] | None
    strain: Mapping[str, float] | None


@dataclass(frozen=True, repr=False)
class EnergyParts(Displayed):
    """Energies by part: M and K as sums of named parts, and the energy of a shape as a sum of shares.

    The share of the part P in the shape u is Re(u^H P u) over the sum of the same over all parts. For a real shape that is its
    share of 1/2 u^T M u or of 1/2 u^T K u; for a complex one, Re(u e^(i w t)), of the average over a cycle, the decay
    left out.

    Args:
        kinetic: parts of M by name: matrices (n, n), in kg or kg m^2, or ``ElementMatrix``. Their sum is M.
        strain: parts of K by name, in N/m or N m/rad. A part may be negative (gravity that pulls a pendulum over):
            then other shares are above 1.

    Raises:
        InputError: a part of another shape, or with entries that are not finite.

    >>> springs = {"soft": ElementMatrix([[1, 0]], [2.0]), "stiff": ElementMatrix([[-1, 1]], [6.0])}
    >>> parts = EnergyParts({"cart": np.diag([1.0, 0.0]), "load": np.diag([0.0, 3.0])}, springs)
    >>> parts.shares([1.0, 0.0])
    EnergyShares(kinetic={'cart': 1.0, 'load': 0.0}, strain={'soft': 0.25, 'stiff': 0.75})
    """

    kinetic: Mapping[str, EnergyPart]
    strain: Mapping[str, EnergyPart]

    def __post_init__(self):
        for kind in ("kinetic", "strain"):
            parts = {str(name): _checked(part, f'{kind} part "{name}"') for name, part in getattr(self, kind).items()}
            object.__setattr__(self, kind, ReadOnly(parts))
        sizes = {_size(part) for part in (*self.kinetic.values(), *self.strain.values())}
        if len(sizes) > 1:
            raise InputError(f"energy parts: found parts of {' and '.join(map(str, sorted(sizes)))} coordinates; expected one size")

    def _summary(self) -> str:
        kinetic, strain = (len(products.names) for products in self._products)
        return f"{counted(kinetic, 'kinetic part')}, {counted(strain, 'strain part')}"

    @property
    def size(self) -> int | None:
        """Number n of coordinates; None without parts."""
        return next((_size(part) for part in (*self.kinetic.values(), *self.strain.values())), None)

    @property
    def is_by_coordinate(self) -> bool:
        """Whether the parts are those of single coordinates, with shares that may be negative."""
        return isinstance(self, CoordinateParts)

    def shares(self, shape, eigenvalue: complex | None = None) -> EnergyShares:
        """Return the energy shares of one shape, independent of its length and phase.

        Args:
            shape: u, shape (n,), real or complex.
            eigenvalue: s of the mode (1/s). With it, an energy that is rounding error relative to the other counts as zero:
                |s|^2 u^H M u relative to u^H K u, and conversely; at s = 0 no spring is stretched.

        Returns:
            The shares by name, each without unit.

        Raises:
            InputError: a shape of another length, with entries that are not finite, or zero.
        """
        return self.shares_of(np.asarray(shape)[..., None], None if eigenvalue is None else [eigenvalue])[0]

    def shares_of(self, shapes, eigenvalues: Sequence[complex] | None = None) -> tuple[EnergyShares, ...]:
        """Return the energy shares of several shapes.

        Args:
            shapes: one a column, shape (n, g), real or complex.
            eigenvalues: eigenvalues of their modes (1/s), shape (g,), as in ``shares``.

        Returns:
            The shares of each shape.

        Raises:
            InputError: as in ``shares``.

        >>> parts = EnergyParts({"a": np.diag([1.0, 0.0]), "b": np.diag([0.0, 3.0])}, {})
        >>> [shares.kinetic for shares in parts.shares_of(np.array([[1.0, 1.0], [1.0, 0.0]]))]
        [{'a': 0.25, 'b': 0.75}, {'a': 1.0, 'b': 0.0}]
        """
        shapes = np.asarray(shapes)
        for part in [shapes.real, shapes.imag] if np.iscomplexobj(shapes) else [shapes]:
            real_array(part, "shape", shape=(self.size, None))
        if not (shapes != 0).any(axis=0).all():
            raise InputError("shape: found zeros only; a shape has at least one entry that is not zero")
        return self._shares_of(shapes, eigenvalues)

    def _shares_of(self, shapes: np.ndarray, eigenvalues: Sequence[complex] | None) -> tuple[EnergyShares, ...]:
        """The energy shares of shapes that are known to be shapes, in any unit."""
        if shapes.dtype.kind == "c" and (imaginary := shapes.imag).any():
            shapes = shapes / np.maximum(np.abs(shapes.real).max(axis=0), np.abs(imaginary).max(axis=0))
        else:
            shapes = shapes.real / np.abs(shapes.real).max(axis=0)
        (kinetic, in_motion), (strain, in_springs) = (products.energies(shapes) for products in self._products)
        if eigenvalues is not None:
            size = np.abs(eigenvalues)
            moving, strained = self._products
            both = (in_motion != 0) & (in_springs != 0) & (size > 0)
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = np.log2(np.abs(in_motion / in_springs)) + 2 * np.log2(size) + (moving.unit - strained.unit)
            in_motion = np.where(both & (ratio <= log2(noise_of(1.0, len(moving.names)))), 0.0, in_motion)
            in_springs = np.where((size == 0) | (both & (-ratio <= log2(noise_of(1.0, len(strained.names))))), 0.0, in_springs)
        named = (
            [
                NamedNumbers(products.names, own) if known else None
                for own, known in zip((energies / np.where(total, total, 1.0)).T, total.tolist())
            ]
            for products, energies, total in zip(self._products, (kinetic, strain), (in_motion, in_springs))
        )
        return tuple(map(EnergyShares, *named))

    @cached_property
    def _products(self) -> tuple[_Products | _CoordinateProducts, _Products | _CoordinateProducts]:
        return _Products.of(self.kinetic), _Products.of(self.strain)


class CoordinateParts(EnergyParts):
    """Energies along single coordinates, x_i (M x)_i and x_i (K x)_i, where masses and springs are not known.

    Such shares may be negative: they are the work along a coordinate, part of which a neighbour may return.

    >>> parts = CoordinateParts(["a", "b"], np.eye(2), np.array([[2.0, -1.0], [-1.0, 2.0]]))
    >>> parts.shares([4.0, 1.0]).strain
    {'a': 1.0769230769230769, 'b': -0.07692307692307693}
    """

    def __init__(self, names: Sequence[str], mass: EnergyPart, stiffness: EnergyPart):
        sizes = [whole.constants if isinstance(whole, ElementMatrix) else whole for whole in (mass, stiffness)]
        units = [int(np.frexp(np.abs(size).max(initial=0.0))[1]) for size in sizes]
        products = tuple(_CoordinateProducts(tuple(names), whole, unit) for whole, unit in zip((mass, stiffness), units))
        self.__dict__.update(kinetic={}, strain={}, _products=products)

    @property
    def size(self) -> int:
        return len(self._products[0].names)


class _CoordinateProducts(NamedTuple):
    """The energies u_i (P u)_i of one matrix P along each coordinate, in units of 2^unit as those of ``_Products``."""

    names: tuple[str, ...]
    whole: EnergyPart
    unit: int

    def energies(self, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        size = np.abs(shapes)
        if isinstance(self.whole, ElementMatrix):
            rows, constants = kept(self.whole.directions), np.ldexp(self.whole.constants, -self.unit)[:, None]
            stretch = rows @ shapes
            stretch = np.where(np.abs(stretch) <= noise_of(abs(rows) @ size, len(shapes)), 0.0, constants * stretch)
            forces, terms = rows.T @ stretch, abs(rows).T @ np.abs(stretch)
        else:
            forces, terms = product(kept(np.ldexp(self.whole, -self.unit)), shapes, size)
        values = (shapes.conj() * forces).real
        return values, _clear_sums(values, size * terms)


def _clear_sums(values: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Sums of the energies of all parts, 0 where those are rounding errors of the terms."""
    totals = values.sum(axis=0)
    return np.where(np.abs(totals) > noise_of(terms.sum(axis=0), len(values)), totals, 0.0)


@dataclass(frozen=True, eq=False)
class _Products:
    """The energies of all parts as sums of products c (L u)^* (R u), one product a row, in units of 2^unit.

    That unit lies above all entries, so that no product leaves the range of float64. Elongations of elements that are rounding
    errors of u are zero, so that these do not strain stiff springs.
    """

    names: tuple[str, ...]
    left: AnyMatrix
    constants: np.ndarray
    right: AnyMatrix
    of_element: np.ndarray
    sums: scipy.sparse.csr_array
    unit: int

    @classmethod
    def of(cls, parts: Mapping[str, EnergyPart]) -> _Products:
        rows = [_rows(part) for part in parts.values()] or [(np.zeros((0, 0)), np.zeros(0), np.zeros((0, 0)), False)]
        left, constants, right = (np.concatenate(each) for each in list(zip(*rows))[:3])
        counts = [len(each) for _, each, _, _ in rows]
        sizes = constants if all(of_element for *_, of_element in rows) else constants * np.abs(right).max(axis=1, initial=0.0)
        unit = int(np.frexp(np.abs(sizes).max(initial=0.0))[1])
        of_element = np.repeat([of_element for *_, of_element in rows], counts)
        sums = scipy.sparse.csr_array(
            (np.ones(len(constants)), np.arange(len(constants)), np.cumsum([0, *counts])), shape=(len(rows), len(constants))
        )
        return cls(tuple(parts), kept(left), np.ldexp(constants, -unit), kept(right), of_element, sums, unit)

    def energies(self, shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Re(u^H P u) / 2^unit of each part P and column u, shape (p, g), and their sums, 0 where those are rounding errors, shape (g,)."""
        if not len(self.constants):
            return np.zeros((len(self.names), shapes.shape[1])), np.zeros(shapes.shape[1])
        a, b, size = self.left @ shapes, self.right @ shapes, abs(self.right) @ np.abs(shapes)
        of_element, constants = self.of_element[:, None], self.constants[:, None]
        b = np.where(of_element & (np.abs(b) <= noise_of(size, len(shapes))), 0.0, b)
        values = self.sums @ (a.conj() * constants * b).real
        return values, _clear_sums(values, np.abs(a) * np.abs(constants) * np.where(of_element, np.abs(b), size))


def _rows(part: EnergyPart) -> tuple[np.ndarray, np.ndarray, np.ndarray, bool]:
    """L, c, R and whether the rows of R are elongations of elements."""
    if isinstance(part, ElementMatrix):
        return part.directions, part.constants, part.directions, True
    return np.eye(len(part)), np.ones(len(part)), part, False


def _checked(part, what: str) -> EnergyPart:
    if isinstance(part, ElementMatrix):
        return part
    matrix = real_array(part, what, shape=(None, None))
    if matrix.shape[0] != matrix.shape[1]:
        raise InputError(f"{what}: expected a square matrix, found {matrix.shape[0]} x {matrix.shape[1]}")
    matrix.flags.writeable = False
    return matrix


def _size(part: EnergyPart) -> int:
    return part.size if isinstance(part, ElementMatrix) else len(part)


def checked_parts(parts: EnergyParts, size: int) -> EnergyParts:
    """The parts, if they are those of a system with so many coordinates."""
    if not isinstance(parts, EnergyParts) or parts.size not in (size, None):
        kind = f"parts of {parts.size} coordinates" if isinstance(parts, EnergyParts) else f"a {type(parts).__name__}"
        raise InputError(f"energy_parts: found {kind}; expected EnergyParts of {counted(size, 'coordinate')}")
    return parts
