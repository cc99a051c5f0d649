"""Special values of the parameter on branches of eigenvalues: roots of a condition on s, and coalescence of two eigenvalues.

A break point is a defective double eigenvalue. With vectors b and c of the smallest singular value of A(s; p),

    [A  b; c^H  0] [x; g] = [0; 1],  [y^H  g] [A  b; c^H  0] = [0  1]

defines a smooth g(s, p) that is zero where A is singular, with g_s = -y^H A_s x; the break point is the zero of (g, g_s), by Newton's
method with second derivatives from the same matrix (Griewank and Reddien 1984; Govaerts, Numerical Methods for Bifurcations of
Dynamical Equilibria, 2000, chapter 3). It is as well conditioned as the data, while the eigenvalues around it have half their digits.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from ...ground.tolerances import EPS, NEWTON_STEP, noise_of
from .branches import Branches, FamilyPart, MatrixFamily

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
            if point is not None and parameters[first] <= point.parameter <= parameters[last] and not _known(point, points):
                points.append(point)
    return points


def _known(point: BreakPoint, points: list[BreakPoint]) -> bool:
    size = abs(point.eigenvalue)
    return any(
        abs(point.parameter - one.parameter) <= NEWTON_STEP * abs(one.parameter)
        and abs(point.eigenvalue - one.eigenvalue) <= NEWTON_STEP * size
        for one in points
    )


def _break_point(family: MatrixFamily, p: float, s: complex) -> BreakPoint | None:
    """Newton's method on (g, g_s) over Re s, Im s and p, all real, from four real rows, which are consistent at a break point."""
    if abs(s.imag) <= NEWTON_STEP * abs(s):
        s = complex(s.real)
    border = _Border(family, p, s)
    for _ in range(STEPS):
        equations = border.equations(p, s)
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


class _Border:
    """b and c, the vectors of the smallest singular value of A(s; p), and with them (g, g_s) and their derivatives."""

    def __init__(self, family: MatrixFamily, p: float, s: complex):
        K, C, M = family.at(p)
        left, _, right = np.linalg.svd(K + s * C + s * s * M)
        scale = np.abs(K).max() + abs(s) * np.abs(C).max() + abs(s) ** 2 * np.abs(M).max()
        self.family, self.column, self.row = family, scale * left[:, -1:], scale * right[-1:]

    def equations(self, p: float, s: complex) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
        """The derivatives of (Re g, Re g_s, Im g, Im g_s), shape (4, 3), their values, and x; None of a singular matrix."""
        (K, C, M), (K1, C1, M1) = self.family.at(p), self.family.slope(p)
        A, A_s, A_p, A_sp = K + s * C + s * s * M, C + 2 * s * M, K1 + s * C1 + s * s * M1, C1 + 2 * s * M1
        try:
            inverse = np.linalg.inv(np.block([[A, self.column], [self.row, np.zeros((1, 1))]]))
        except np.linalg.LinAlgError:
            return None
        x, y, g = inverse[:-1, -1], inverse[-1, :-1], inverse[-1, -1]
        x_s, x_p = (-(inverse[:-1, :-1] @ (slope @ x)) for slope in (A_s, A_p))
        g_s, g_p = -(y @ A_s @ x), -(y @ A_p @ x)
        g_ss, g_sp = -2 * (y @ M @ x + y @ A_s @ x_s), -(y @ A_sp @ x + y @ A_s @ x_p + y @ A_p @ x_s)
        rows, values = np.array([[g_s, 1j * g_s, g_p], [g_ss, 1j * g_ss, g_sp]]), np.array([g, g_s])
        if not (np.isfinite(rows).all() and np.isfinite(values).all()):
            return None
        return np.vstack([rows.real, rows.imag]), np.concatenate([values.real, values.imag]), x
