"""Eigenvalues followed over a parameter, through crossings and veerings.

Between two values of the parameter each eigenvalue is predicted from both sides at the middle, by its derivative; the assignment of
least distance connects the branches. Where it is not clear the interval is halved. Two branches that change places are a crossing
where nothing couples them; coupled ones come no nearer than 2 sqrt(c_ij c_ji) |s_i - s_j| / |s_i' - s_j'|, c the couplings of the
first order (Leissa 1974, Perkins and Mote 1986), so that their interval is halved until they are seen to turn away from each other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import linear_sum_assignment
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from ...ground.errors import InputError
from ...ground.tolerances import BRANCH_RESOLUTION, CLEAR_ASSIGNMENT, SAME_BRANCH
from .spectrum import VariedSpectrum, modal_coordinates, refined_values, spectrum_of


@dataclass(frozen=True, eq=False)
class MatrixFamily:
    """A(s; p) = A(s; 0) + p A_p(s), or any other function of p with its derivative.

    Attributes:
        at: K, C, M at p, shape (3, n, n).
        slope: their derivatives with respect to p, shape (3, n, n).
        pattern: the entries that are not zero for all p, shape (n, n).
        knots: values of p where the derivative jumps, if A is linear between them.
    """

    at: Callable[[float], np.ndarray]
    slope: Callable[[float], np.ndarray]
    pattern: np.ndarray
    knots: np.ndarray = field(default_factory=lambda: np.zeros(0))

    @staticmethod
    def linear(base: np.ndarray, slope: np.ndarray) -> MatrixFamily:
        """A_0 + p A_1 of constant matrices.

        Args:
            base, slope: A_0 and A_1, each K, C, M, shape (3, n, n).

        Returns:
            The family.
        """
        return MatrixFamily(lambda p: base + p * slope, lambda p: slope, (base != 0).any(axis=0) | (slope != 0).any(axis=0))

    @property
    def parts(self) -> list[np.ndarray]:
        """The coordinates in parts that no matrix couples."""
        count, labels = connected_components(csr_array(self.pattern), directed=False)
        return [np.flatnonzero(labels == label) for label in range(count)]


@dataclass(frozen=True, eq=False)
class Branches:
    """Eigenvalues over a parameter, conjugates included, each branch a column.

    Attributes:
        parameters: p, shape (P,).
        values, slopes: s and ds/dp, shape (P, m).
        shapes: x, shape (P, n, m).
        evaluations: number of computed spectra.
    """

    parameters: np.ndarray
    values: np.ndarray
    slopes: np.ndarray
    shapes: np.ndarray
    evaluations: int


@dataclass(frozen=True, eq=False)
class SpectrumPoint:
    """A spectrum at p, with all couplings of the first order."""

    parameter: float
    spectrum: VariedSpectrum
    coupling: np.ndarray

    @property
    def values(self) -> np.ndarray:
        """s, shape (m,)."""
        return self.spectrum.values

    @property
    def slopes(self) -> np.ndarray:
        """ds/dp, shape (m,)."""
        return self.coupling.diagonal()

    def ordered(self, order: np.ndarray) -> SpectrumPoint:
        """The point with its eigenvalues in another order, shape (m,)."""
        return SpectrumPoint(self.parameter, self.spectrum.ordered(order), self.coupling[np.ix_(order, order)])


def followed(family: MatrixFamily, parameters: np.ndarray) -> Branches:
    """The branches of all eigenvalues over ascending values of the parameter."""
    parts = [FamilyPart(family, at, parameters) for at in family.parts]
    chains = [part.chain(parameters) for part in parts]
    shapes = np.zeros((len(parameters), len(family.pattern), sum(chain[0].values.size for chain in chains)), dtype=complex)
    begin = 0
    for part, chain in zip(parts, chains):
        end = begin + chain[0].values.size
        for place, point in enumerate(chain):
            shapes[place][part.places, begin:end] = part.shapes(point)
        begin = end
    values, slopes = (
        np.hstack([[getattr(point, name) for point in chain] for chain in chains]).reshape(len(parameters), -1)
        for name in ("values", "slopes")
    )
    return Branches(parameters, values, slopes, shapes, sum(part.evaluations for part in parts))


class FamilyPart:
    """Coordinates of a family that are coupled to no others, in modal coordinates where M and K do not depend on p.

    Args:
        family: A(s; p).
        places: of the coordinates; None for all.
        parameters: p, shape (P,); the first and the last, and the knots of the family, are compared.

    Attributes:
        basis, stiffness: of ``modal_coordinates``, where they are used.
        evaluations: number of computed spectra.
    """

    def __init__(self, family: MatrixFamily, places: np.ndarray | None, parameters: np.ndarray):
        places = np.arange(len(family.pattern)) if places is None else places
        self.family, self.places, self.evaluations = family, places, 0
        first, *others = (self.block(family.at(float(p))) for p in (*parameters[[0, -1]], *family.knots))
        is_same = (first == np.array(others)).all(axis=(0, 2, 3))
        self.is_constant = is_same.all() and not self.block(family.slope(float(parameters[0]))).any()
        self.basis: np.ndarray | None = None
        self.stiffness: np.ndarray | None = None
        if is_same[[0, 2]].all() and (modal := modal_coordinates(first[2], first[0])) is not None:
            self.basis, self.stiffness = modal

    def block(self, matrices: np.ndarray) -> np.ndarray:
        """The rows and columns of this part, shape (3, k, k)."""
        return matrices[:, self.places[:, None], self.places]

    def chain(self, parameters: np.ndarray) -> list[SpectrumPoint]:
        """A point for each parameter, with every branch at its index."""
        points = [self.point(float(parameters[0]))]
        if self.is_constant:
            return points * len(parameters)
        resolution = BRANCH_RESOLUTION * float(np.ptp(parameters))
        for p in parameters[1:].tolist():
            following = self.point(p)
            points.append(following.ordered(self._connected(points[-1], following, resolution)))
        return points

    def point(self, parameter: float) -> SpectrumPoint:
        """The spectrum at p."""
        self.evaluations += 1
        coefficients, slope = (self.block(matrices(parameter)) for matrices in (self.family.at, self.family.slope))
        if self.basis is not None:
            K, M = np.diag(self.stiffness), np.eye(len(self.basis))
            coefficients = np.array([K, _congruent(coefficients[1], self.basis), M])
            slope = np.array([_congruent(matrix, self.basis) for matrix in slope])
        return SpectrumPoint(parameter, *spectrum_of(list(coefficients)).turned(slope))

    @property
    def is_conservative(self) -> bool:
        """Whether M and K are symmetric and do not depend on p, M positive definite and K positive semidefinite."""
        return self.basis is not None

    def refined(self, point: SpectrumPoint, branch: int) -> complex:
        """An eigenvalue, refined by ``refined_values``."""
        s = point.spectrum
        right, left = s.right[:, [branch]], s.left[[branch]]
        if self.basis is not None:
            right, left = self.basis @ right, left @ self.basis.T
        return complex(refined_values(list(self.block(self.family.at(point.parameter))), s.values[[branch]], right, left)[0])

    def shapes(self, point: SpectrumPoint) -> np.ndarray:
        """Shapes in the coordinates of the family, shape (n, m)."""
        return point.spectrum.right if self.basis is None else self.basis @ point.spectrum.right

    def _connected(self, a: SpectrumPoint, b: SpectrumPoint, resolution: float) -> np.ndarray:
        """The indices at b of the branches at a."""
        if a.values.size != b.values.size:
            raise InputError(
                f"the number of finite eigenvalues changes from {a.values.size} to {b.values.size} between the values "
                f"{a.parameter:g} and {b.parameter:g} of the parameter; follow each side by itself"
            )
        order, is_clear = _assigned(a, b)
        if is_clear or b.parameter - a.parameter <= resolution:
            return order
        middle = self.point((a.parameter + b.parameter) / 2)
        middle = middle.ordered(self._connected(a, middle, resolution))
        return self._connected(middle, b, resolution)


def _congruent(matrix: np.ndarray, basis: np.ndarray) -> np.ndarray:
    """Phi^T A Phi, symmetric or skew-symmetric where A is."""
    result = basis.T @ matrix @ basis
    for sign in (1.0, -1.0):
        if (matrix == sign * matrix.T).all():
            return (result + sign * result.T) / 2
    return result


def _assigned(a: SpectrumPoint, b: SpectrumPoint) -> tuple[np.ndarray, bool]:
    """The indices at b of the branches at a, and whether the assignment is unique."""
    half, noise = (b.parameter - a.parameter) / 2, a.spectrum.noise + b.spectrum.noise
    with np.errstate(invalid="ignore", over="ignore"):
        distance = np.abs((a.values + half * a.slopes)[:, None] - (b.values - half * b.slopes))
    if not np.isfinite(distance).all():  # derivatives of defective eigenvalues
        distance = np.abs(a.values[:, None] - b.values)
    likeness = np.abs(a.spectrum.rows @ b.spectrum.states)
    order = linear_sum_assignment(distance + noise * (1 - np.minimum(likeness, 1.0)))[1]
    places = np.arange(len(order))
    own = distance[places, order]
    others = distance.copy()
    others[places, order] = np.inf
    least = np.minimum(others.min(axis=1), others.min(axis=0)[order])
    equal = least <= noise
    same = np.abs(likeness[places, order] - 1) <= SAME_BRANCH
    clear = (own <= CLEAR_ASSIGNMENT * least) & same
    return order, bool((clear | equal).all()) and not _may_veer(a, b.ordered(order), noise)


def _may_veer(a: SpectrumPoint, b: SpectrumPoint, noise: float) -> bool:
    """Whether two coupled branches are exchanged between both points."""
    first, last = (point.values[:, None] - point.values for point in (a, b))
    places = np.argwhere(np.triu((first * last.conj()).real < 0, 1))
    if not len(places):
        return False
    i, j = places.T
    gaps = []
    for point, distance in ((a, first), (b, last)):
        slopes, coupled = point.slopes[i] - point.slopes[j], np.sqrt(np.abs(point.coupling[i, j] * point.coupling[j, i]))
        gaps.append(2 * coupled * np.abs(distance[i, j]) / np.maximum(np.abs(slopes), np.finfo(float).tiny))
    return bool((np.maximum(*gaps) > noise).any())
