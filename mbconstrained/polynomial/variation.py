"""Eigenvalues of A(s) over a speed or a parameter: branches, their derivatives, break points and limits of stability."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import scipy

from ..ground.errors import InputError
from ..ground.tolerances import (
    BRANCH_RESOLUTION,
    CLEAR_ASSIGNMENT,
    CLUSTER_SAFETY,
    DIVISOR_CONDITION,
    EPS,
    NEWTON_STEP,
    SAME_BRANCH,
    STIFFNESS_CONDITION,
    noise_of,
)
from ..linalg.arrays import lapack
from ..linalg.blocks import coupled_rows
from ..linalg.division import condition, is_symmetric
from ..linalg.rank import Noisy, null_columns
from ..linalg.symmetric import refined_modes
from .polynomial_matrix import PolynomialMatrix

# Eigenvalues of A(s) = M s^2 + C s + K with right and left vectors, and their derivatives with respect to a parameter.
# A(s)^-1 = sum over i of x_i y_i^T / (s - s_i), so that y_i^T A'(s_i) x_i = 1 and ds_i/dp = - y_i^T A_p(s_i) x_i (Lancaster 1964). Of an
# eigenvalue that is double with two shapes the derivatives are the eigenvalues of the matrix - Y^T A_p(s) X of its group.


@dataclass(frozen=True, eq=False)
class VariedSpectrum:
    """The finite eigenvalues of A(s), conjugates included, with vectors that are normalized by A(s)^-1.

    Attributes:
        values: s, shape (m,).
        right, left: x as columns, shape (n, m), and y^T as rows, shape (m, n).
        velocity: s x, also where s = 0 and x is the motion of a free body at constant velocity.
        states, rows: vectors of the first-order equations, rows @ states = I, shape (k, m) and (m, k).
        noise: changes of the eigenvalues by rounding errors (1/s).
        parameter: p, where A(s) depends on one.
        coupling: - y_i^T A_p(s_j) x_j, shape (m, m), its diagonal the derivatives of simple eigenvalues.
    """

    values: np.ndarray
    right: np.ndarray
    velocity: np.ndarray
    left: np.ndarray
    states: np.ndarray
    rows: np.ndarray
    noise: float
    parameter: float = np.nan
    coupling: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))

    @property
    def slopes(self) -> np.ndarray:
        """ds/dp, shape (m,)."""
        return self.coupling.diagonal()

    def ordered(self, order: np.ndarray) -> VariedSpectrum:
        """The spectrum in another order, shape (m,)."""
        columns = {name: getattr(self, name)[:, order] for name in ("right", "velocity", "states")}
        rows = {name: getattr(self, name)[order] for name in ("values", "left", "rows")}
        return replace(self, **columns, **rows, coupling=self.coupling[np.ix_(order, order)])

    def varied(self, parameter: float, slope: np.ndarray) -> VariedSpectrum:
        """The spectrum with its couplings at p, vectors of equal eigenvalues combined so that they are limits of those for p + dp."""
        motions, change = (self.right, self.velocity, self.velocity * self.values), np.zeros_like(self.right, order="C")
        for matrix, motion in zip(slope, motions):
            if matrix.any():  # real and imaginary parts at once
                change = change + (matrix @ np.ascontiguousarray(motion).view(float)).view(complex)
        coupling = -self.left @ change
        result, groups = replace(self, parameter=parameter, coupling=coupling), equal_groups(self.values, self.noise)
        if not groups:
            return result
        turn = np.eye(len(self.values), dtype=complex)
        for group in groups:
            place = np.ix_(group, group)
            if np.isfinite(coupling[place]).all():
                turn[place] = np.linalg.eig(coupling[place])[1]
        if not np.linalg.cond(turn) < 1 / EPS**0.5:  # a defective derivative: the vectors stay
            return result
        back = np.linalg.inv(turn)
        columns = {name: getattr(self, name) @ turn for name in ("right", "velocity", "states")}
        return replace(result, **columns, left=back @ self.left, rows=back @ self.rows, coupling=back @ coupling @ turn)


def equal_groups(values: np.ndarray, radius: float) -> list[np.ndarray]:
    """The places of eigenvalues that are within a radius of others, each group of two or more."""
    near = np.abs(values[:, None] - values) <= radius
    if near.sum() == len(values):
        return []
    return [group for group in coupled_rows(near) if len(group) > 1]


def modal_coordinates(M: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Phi and k with Phi^T M Phi = I and Phi^T K Phi = diag(k), k exactly 0 for free motions."""
    if not (is_symmetric(M) and is_symmetric(K)) or not (M.diagonal() > 0).all():
        return None
    root = np.sqrt(M.diagonal())
    if not condition(M / np.multiply.outer(root, root), np.inf) <= STIFFNESS_CONDITION:
        return None
    try:
        stiffness, shapes = scipy.linalg.eigh((K + K.T) / 2, (M + M.T) / 2)
    except np.linalg.LinAlgError:
        return None
    free = len(null_columns(Noisy.rounded(K)).null.data)
    if not free and (refined := refined_modes(M, np.zeros_like(M), K, shapes)) is not None:
        shapes, stiffness, _ = refined
    noise = noise_of(float(np.abs(stiffness).max(initial=0.0)), len(M))
    if (stiffness[free:] <= 0).any() or (np.abs(stiffness[:free]) > noise).any():
        return None
    stiffness[:free] = 0.0
    return shapes, stiffness


def spectrum_of(coefficients: Sequence[np.ndarray]) -> VariedSpectrum:
    """All finite eigenvalues of A(s) with both vectors.

    The states are (w x, x'), w^2 = K_ii / M_ii, so that nothing is larger than the fastest rate. Displacements without stiffness, those of
    columns of K that are exactly zero, are no states: their velocities are.
    """
    K, C, M = coefficients
    n, unit = len(K), (M == np.eye(len(M))).all()
    if not unit:
        row = np.abs(M).max(axis=1, initial=0.0)
        if not ((row > 0).all() and condition(M / row[:, None], np.inf) <= DIVISOR_CONDITION):
            return _by_pairs(PolynomialMatrix(coefficients))
        K, C = np.hsplit(np.linalg.solve(M, np.hstack([K, C])), 2)
    elastic, diagonal = np.flatnonzero(K.any(axis=0)), np.abs(K.diagonal())
    rates = np.sqrt(np.where(diagonal > 0, diagonal, diagonal.max(initial=0.0) or 1.0))[elastic]
    m, stiff = len(elastic), K[:, elastic]
    S = np.zeros((m + n, m + n))
    S[range(m), m + elastic] = rates
    S[m:, :m], S[m:, m:] = (
        (-S[:m, m:].T if np.count_nonzero(stiff) == m and (stiff[elastic].diagonal() > 0).all() else -stiff / rates),
        -C,
    )
    values, states, rows, noise = _decoupled(S)
    velocity = states[m:]
    right = velocity / np.where(np.abs(values) > noise, values, 1.0)
    right[elastic] = states[:m] / rates[:, None]
    left = rows[:, m:] if unit else np.linalg.solve(M.T, rows[:, m:].T).T
    return VariedSpectrum(values, right, velocity, left, states, rows, noise)


def _decoupled(S: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """Eigenvalues, vectors, the inverse of these, and the size of rounding errors of eigenvalues; a skew-symmetric S exactly imaginary."""
    if (S == -S.T).all():
        values, states = np.linalg.eigh(1j * S)
        return -1j * values, states, states.conj().T, CLUSTER_SAFETY * EPS * float(np.abs(values).max(initial=0.0))
    real, imaginary, _, packed, failed = lapack.dgeev(S, compute_vl=0)
    if failed:
        raise np.linalg.LinAlgError("the eigenvalues did not converge")
    try:
        inverse = np.linalg.inv(packed)
    except np.linalg.LinAlgError:  # defective to the last digit: the nearest that has an inverse
        inverse = np.linalg.pinv(packed)
    values, states, rows, upper = (
        real + 1j * imaginary,
        packed.astype(complex),
        inverse.astype(complex),
        np.flatnonzero(imaginary > 0),
    )
    states.imag[:, upper] = packed[:, upper + 1]
    states[:, upper + 1] = states[:, upper].conj()
    rows[upper] = (inverse[upper] - 1j * inverse[upper + 1]) / 2
    rows[upper + 1] = rows[upper].conj()
    return values, states, rows, CLUSTER_SAFETY * EPS * float(np.abs(values).max(initial=0.0))


def _by_pairs(A: PolynomialMatrix) -> VariedSpectrum:
    """Spectrum by the finite Jordan pair (C, J, B), which exists for singular M: right vectors C V, left ones V^-1 B."""
    pair = A.jordan_pairs().finite
    values, states, rows, noise = _decoupled(pair.J)
    right = pair.C @ states
    return VariedSpectrum(values, right, right * values, rows @ pair.B, states, rows, noise)


def refined_values(coefficients: Sequence[np.ndarray], values: np.ndarray, right: np.ndarray, left: np.ndarray) -> np.ndarray:
    """s - y^T A(s) x / (y^T A'(s) x), summed in long double, in which cancelling terms of K x keep their digits.

    The error is of the second order in those of both vectors (Lancaster 1961, the generalized Rayleigh quotient).
    """
    s = values.astype(np.clongdouble)
    x, y = right.astype(np.clongdouble), left.T.astype(np.clongdouble)
    forms = [(y * (np.asarray(matrix).astype(np.clongdouble) @ x)).sum(axis=0) for matrix in coefficients]
    for _ in range(2):
        value = sum(form * s**power for power, form in enumerate(forms))
        slope = sum(power * form * s ** (power - 1) for power, form in enumerate(forms) if power)
        s = s - np.where(slope != 0, value / np.where(slope != 0, slope, 1), 0)
    return s.astype(complex)


# Eigenvalues followed over a parameter, through crossings and veerings.
# Between two values of the parameter each eigenvalue is predicted from both sides at the middle, by its derivative; the assignment of
# least distance connects the branches. Where it is not clear the interval is halved. Two branches that change places are a crossing
# where nothing couples them; coupled ones come no nearer than 2 sqrt(c_ij c_ji) |s_i - s_j| / |s_i' - s_j'|, c the couplings of the
# first order (Leissa 1974, Perkins and Mote 1986), so that their interval is halved until they are seen to turn away from each other.


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
        """A_0 + p A_1 of constant matrices."""
        return MatrixFamily(lambda p: base + p * slope, lambda p: slope, (base != 0).any(axis=0) | (slope != 0).any(axis=0))

    @property
    def parts(self) -> list[np.ndarray]:
        """The coordinates in parts that no matrix couples."""
        return coupled_rows(self.pattern)


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

    def chain(self, parameters: np.ndarray) -> list[VariedSpectrum]:
        """A point for each parameter, with every branch at its index."""
        points = [self.point(float(parameters[0]))]
        if self.is_constant:
            return points * len(parameters)
        resolution = BRANCH_RESOLUTION * float(np.ptp(parameters))
        for p in parameters[1:].tolist():
            following = self.point(p)
            points.append(following.ordered(self._connected(points[-1], following, resolution)))
        return points

    def point(self, parameter: float) -> VariedSpectrum:
        """The spectrum at p."""
        self.evaluations += 1
        coefficients, slope = (self.block(matrices(parameter)) for matrices in (self.family.at, self.family.slope))
        if self.basis is not None:
            K, M = np.diag(self.stiffness), np.eye(len(self.basis))
            coefficients = np.array([K, _congruent(coefficients[1], self.basis), M])
            slope = np.array([_congruent(matrix, self.basis) if matrix.any() else matrix for matrix in slope])
        return spectrum_of(list(coefficients)).varied(parameter, slope)

    @property
    def is_conservative(self) -> bool:
        """Whether M and K are symmetric and do not depend on p, M positive definite and K positive semidefinite."""
        return self.basis is not None

    def refined(self, point: VariedSpectrum, branch: int) -> complex:
        """An eigenvalue, refined by ``refined_values``."""
        right, left = point.right[:, [branch]], point.left[[branch]]
        if self.basis is not None:
            right, left = self.basis @ right, left @ self.basis.T
        return complex(refined_values(list(self.block(self.family.at(point.parameter))), point.values[[branch]], right, left)[0])

    def shapes(self, point: VariedSpectrum) -> np.ndarray:
        """Shapes in the coordinates of the family, shape (n, m)."""
        return point.right if self.basis is None else self.basis @ point.right

    def _connected(self, a: VariedSpectrum, b: VariedSpectrum, resolution: float) -> np.ndarray:
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


def _assigned(a: VariedSpectrum, b: VariedSpectrum) -> tuple[np.ndarray, bool]:
    """The indices at b of the branches at a, and whether the assignment is unique."""
    half, noise = (b.parameter - a.parameter) / 2, a.noise + b.noise
    with np.errstate(invalid="ignore", over="ignore"):
        distance = np.abs((a.values + half * a.slopes)[:, None] - (b.values - half * b.slopes))
    if not np.isfinite(distance).all():  # derivatives of defective eigenvalues
        distance = np.abs(a.values[:, None] - b.values)
    places, unlike = np.arange(len(a.values)), np.zeros(())
    for _ in range(2):  # equal eigenvalues by their states, too
        order = scipy.optimize.linear_sum_assignment(distance + noise * unlike)[1]
        others = distance.copy()
        others[places, order] = np.inf
        least = np.minimum(others.min(axis=1), others.min(axis=0)[order])
        if not (equal := least <= noise).any():
            break
        unlike = 1 - np.minimum(np.abs(a.rows @ b.states), 1.0)
    likeness = np.abs((a.rows * b.states.T[order]).sum(axis=1))
    clear = (distance[places, order] <= CLEAR_ASSIGNMENT * least) & (np.abs(likeness - 1) <= SAME_BRANCH)
    return order, bool((clear | equal).all()) and not _may_veer(a, b, order, noise)


def _may_veer(a: VariedSpectrum, b: VariedSpectrum, order: np.ndarray, noise: float) -> bool:
    """Whether two coupled branches are exchanged between both points, at the second in this order."""
    first, last = (values[:, None] - values for values in (a.values, b.values[order]))
    i, j = np.nonzero(first.real * last.real + first.imag * last.imag < 0)
    i, j = i[i < j], j[i < j]
    if not len(i):
        return False
    gaps = []
    for point, k, m, distance in ((a, i, j, first), (b, order[i], order[j], last)):
        slopes, coupled = point.slopes[k] - point.slopes[m], np.sqrt(np.abs(point.coupling[k, m] * point.coupling[m, k]))
        gaps.append(2 * coupled * np.abs(distance[i, j]) / np.maximum(np.abs(slopes), np.finfo(float).tiny))
    return bool((np.maximum(*gaps) > noise).any())


# Special values of the parameter on branches of eigenvalues: roots of a condition on s, and coalescence of two eigenvalues.
# A break point is a defective double eigenvalue. With vectors b and c of the smallest singular value of A(s; p),
#     [A  b; c^H  0] [x; g] = [0; 1],  [y^H  g] [A  b; c^H  0] = [0  1]
# defines a smooth g(s, p) that is zero where A is singular, with g_s = -y^H A_s x; the break point is the zero of (g, g_s), by Newton's
# method with second derivatives from the same matrix (Griewank and Reddien 1984; Govaerts, Numerical Methods for Bifurcations of
# Dynamical Equilibria, 2000, chapter 3). It is as well conditioned as the data, while the eigenvalues around it have half their digits.

#: Most steps of Newton's method.
STEPS = 30

#: Eigenvalues that come no nearer than this, relative and squared, do not coalesce: rounding errors are far smaller.
COALESCENCE = EPS**0.75


@dataclass(frozen=True, eq=False)
class BreakPoint:
    """A value of the parameter at which two eigenvalues coalesce in a chain: the branches of a root locus meet and part there.

    Attributes:
        parameter: p.
        eigenvalue: s, double and defective, Im s >= 0 (1/s).
        shape: x of the only mode, shape (n,), the largest entry 1.
        residual: |g| + |g_s|, without dimension; near rounding errors.
    """

    parameter: float
    eigenvalue: complex
    shape: np.ndarray
    residual: float


def located(
    part: FamilyPart,
    parameter: float,
    value: complex,
    residual: Callable[[complex, float], float],
    derivative: Callable[[complex], float],
    span: float = 0.0,
) -> tuple[float, complex, np.ndarray] | None:
    """Parameter, eigenvalue and shape where a residual of the branch is zero, by Newton's method."""
    for _ in range(STEPS):
        point = part.point(parameter)
        nearest = int(np.abs(point.values - value).argmin())
        slope = point.slopes[nearest]
        value = part.refined(point, nearest)
        change = residual(value, parameter) / derivative(slope)
        if not np.isfinite(change):
            return None
        size = max(abs(parameter), span)
        if abs(change) <= 4 * EPS * size:
            return parameter - change, value - slope * change, part.shapes(point)[:, nearest]
        change = np.clip(change, -0.5 * size, 0.5 * size)
        parameter, value = parameter - change, value - slope * change
    return None


def stability_limits(family: MatrixFamily, parameters: np.ndarray, values: np.ndarray) -> tuple[float, ...]:
    """The parameters at which the real part of an eigenvalue changes its sign, by Newton's method on its branch."""
    part, limits, span = FamilyPart(family, None, parameters), [], float(np.ptp(parameters))
    noise = noise_of(float(np.abs(values).max(initial=0.0)), len(family.pattern))
    for column in values.T:
        real = column.real
        for first, last in pairwise(np.flatnonzero(np.abs(real) > noise)):
            if real[first] * real[last] < 0:
                share = real[first] / (real[first] - real[last])
                start, value = (ends[first] + share * (ends[last] - ends[first]) for ends in (parameters, column))
                limit = located(part, float(start), complex(value), lambda s, _: s.real, lambda slope: slope.real, span)
                limits += [] if limit is None else [limit[0]]
    return tuple(sorted(limits))


def break_points(family: MatrixFamily, branches: Branches) -> tuple[BreakPoint, ...]:
    """The break points between the parameters of branches.

    Near one (s_i - s_j)^2 is a smooth function of p that changes its sign; at a crossing of two modes it does not. Two chains of one
    eigenvalue are found in parts that no matrix couples, each its own; in coupled coordinates they are not.
    """
    points = []
    for places in family.parts:
        own = np.flatnonzero(branches.shapes[:, places].any(axis=(0, 1)))
        for point in _of_part(_part(family, places), branches.parameters, branches.values[:, own]):
            shape = np.zeros(len(family.pattern), dtype=complex)
            shape[places] = point.shape
            points.append(replace(point, shape=shape))
    return tuple(sorted(points, key=lambda point: point.parameter))


def _part(family: MatrixFamily, places: np.ndarray) -> MatrixFamily:
    rows = places[:, None]
    return MatrixFamily(
        lambda p: family.at(p)[:, rows, places], lambda p: family.slope(p)[:, rows, places], family.pattern[rows, places]
    )


def _of_part(family: MatrixFamily, parameters: np.ndarray, values: np.ndarray) -> list[BreakPoint]:
    """Break points of coupled coordinates."""
    points: list[BreakPoint] = []
    for i, j in zip(*np.triu_indices(values.shape[1], 1)):
        squares, middles = (values[:, i] - values[:, j]) ** 2, (values[:, i] + values[:, j]) / 2
        clear = np.flatnonzero(np.abs(squares) > EPS * np.abs(values).max(axis=1, initial=0.0) ** 2)
        for first, last in pairwise(clear):
            a, b = squares[first], squares[last]
            if (a * b.conjugate()).real >= 0 or middles[first].imag < -(abs(a) ** 0.5):
                continue
            share = float((a / (a - b)).real)
            start = [ends[first] + share * (ends[last] - ends[first]) for ends in (parameters, middles)]
            point = _break_point(family, float(start[0].real), complex(start[1]))
            if point is None or not parameters[first] <= point.parameter <= parameters[last]:
                continue
            if not any(
                abs(point.parameter - one.parameter) <= NEWTON_STEP * abs(one.parameter)
                and abs(point.eigenvalue - one.eigenvalue) <= NEWTON_STEP * abs(point.eigenvalue)
                for one in points
            ):
                points.append(point)
    return points


def _break_point(family: MatrixFamily, p: float, s: complex) -> BreakPoint | None:
    """Newton's method on (g, g_s) over Re s, Im s and p, all real, from four real rows, which are consistent at a break point."""
    if abs(s.imag) <= NEWTON_STEP * abs(s):
        s = complex(s.real)
    K, C, M = family.at(p)
    left, _, right = np.linalg.svd(K + s * C + s * s * M)
    scale = np.abs(K).max() + abs(s) * np.abs(C).max() + abs(s) ** 2 * np.abs(M).max()
    for _ in range(STEPS):
        equations = _bordered(family.at(p), family.slope(p), s, scale * left[:, -1:], scale * right[-1:])
        if equations is None:
            return None
        rows, rest, x = equations
        sizes = np.array([abs(s), abs(s), abs(p)])
        sizes[sizes == 0] = 1.0
        weights = np.abs(rows * sizes).max(axis=1)
        weights[weights <= EPS * weights.max()] = weights.max() or 1.0
        change = sizes * np.linalg.lstsq(rows * sizes / weights[:, None], -rest / weights, rcond=None)[0]
        s, p, residual = s + complex(*change[:2]), p + float(change[2]), float((np.abs(rest) / weights).sum())
        if (np.abs(change) <= 16 * EPS * sizes).all():
            break
    if not residual <= COALESCENCE:
        return None
    return BreakPoint(p, complex(s.real, abs(s.imag)) + 0.0, x / x[np.abs(x).argmax()], residual)


def _bordered(at: np.ndarray, slope: np.ndarray, s: complex, column: np.ndarray, row: np.ndarray):
    """The derivatives of (Re g, Re g_s, Im g, Im g_s), shape (4, 3), their values, and x, for b and c; None of a singular matrix."""
    (K, C, M), (K1, C1, M1) = at, slope
    A, A_s, A_p, A_sp = K + s * C + s * s * M, C + 2 * s * M, K1 + s * C1 + s * s * M1, C1 + 2 * s * M1
    try:
        inverse = np.linalg.inv(np.block([[A, column], [row, np.zeros((1, 1))]]))
    except np.linalg.LinAlgError:
        return None
    x, y, g = inverse[:-1, -1], inverse[-1, :-1], inverse[-1, -1]
    x_s, x_p = (-(inverse[:-1, :-1] @ (matrix @ x)) for matrix in (A_s, A_p))
    g_s, g_p = -(y @ A_s @ x), -(y @ A_p @ x)
    g_ss, g_sp = -2 * (y @ M @ x + y @ A_s @ x_s), -(y @ A_sp @ x + y @ A_s @ x_p + y @ A_p @ x_s)
    rows, values = np.array([[g_s, 1j * g_s, g_p], [g_ss, 1j * g_ss, g_sp]]), np.array([g, g_s])
    if not (np.isfinite(rows).all() and np.isfinite(values).all()):
        return None
    return np.vstack([rows.real, rows.imag]), np.concatenate([values.real, values.imag]), x
