"""Root loci: the eigenvalues of a system over one parameter, with break points, limits of stability and lines of equal damping."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from ..ground.checks import counted
from ..ground.display import Pictured, TextTable, number_text
from ..ground.errors import InputError, named
from ..ground.threads import short_work
from ..ground.tolerances import NEWTON_STEP, noise_of
from ..polynomial.variation import BreakPoint, MatrixFamily, break_points, followed, stability_limits
from .equations import EquationsOfMotion
from .parameter import Parameter, ascending, parameter_named

#: Parts of the range at which matrices are compared with linear ones, nowhere symmetric.
INNER = (0.29, 0.53, 0.83)


@dataclass(frozen=True, repr=False, eq=False)
class RootLocus(Pictured):
    """The eigenvalues over a parameter p; a column belongs to one branch.

    Attributes:
        name, unit: name and unit of the parameter.
        values: p, ascending, shape (P,).
        eigenvalues: s in 1/s, conjugates included, shape (P, m).
        slopes: ds/dp, shape (P, m).
        break_points: points of coalescence of two eigenvalues: ``parameter``, ``eigenvalue`` and ``shape``.
        stability_limits: p at which the real part of an eigenvalue changes its sign.
    """

    name: str
    unit: str
    values: np.ndarray
    eigenvalues: np.ndarray
    slopes: np.ndarray = field(repr=False)
    break_points: tuple[BreakPoint, ...]
    stability_limits: tuple[float, ...]

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s / |s|, 0 for an eigenvalue 0, shape (P, m)."""
        size = np.abs(self.eigenvalues)
        return -self.eigenvalues.real / np.where(size > 0, size, 1.0) + 0.0

    def _summary(self) -> str:
        return f"{self.name}, {counted(len(self.values), 'value')}, {counted(len(self.break_points), 'break point')}"

    def table(self) -> TextTable:
        """A row for each break point."""
        rows = (
            (number_text(one.parameter), number_text(one.eigenvalue.real), number_text(one.eigenvalue.imag), f"{one.residual:.1g}")
            for one in self.break_points
        )
        heads = (f"{self.name} {self.unit}".strip(), "real part 1/s", "imaginary part 1/s", "residual")
        return TextTable("Break points", heads, tuple(rows))

    def _tables(self) -> tuple[TextTable, ...]:
        return (self.table(),)


def root_locus(system: EquationsOfMotion, parameter: str | Parameter, values) -> RootLocus:
    """The root locus of a system over a parameter on which its matrices depend linearly."""
    system._refuse_sparse("root_locus")
    if not isinstance(parameter, Parameter):
        with named("root_locus"):
            parameter = parameter_named(system.parameters(), parameter)
    slope = parameter.matrices(system.size)
    base = np.array([system.stiffness, system.damping, system.mass]) - parameter.value * slope
    V = _basis(system, parameter)
    return locus_of(parameter.name, parameter.unit, values, MatrixFamily.linear(V.T @ base @ V, V.T @ slope @ V))


def root_locus_of(
    name: str, unit: str, values, build: Callable[[float], EquationsOfMotion], slope: Callable[[float], Parameter]
) -> RootLocus:
    """The root locus of systems that depend on a parameter in any smooth way."""
    values = ascending(values, "values", ", e.g. numpy.linspace(0, 100, 101)")
    first = build(float(values[0]))
    V = _basis(first, slope(float(values[0])))

    @cache
    def at(p: float) -> np.ndarray:
        system = build(p)
        if not np.array_equal(system.constraint_matrix, first.constraint_matrix):
            raise InputError(f"{name}: constraint rows change with it; a root locus needs constant rows")
        return V.T @ np.array([system.stiffness, system.damping, system.mass]) @ V

    @cache
    def derivative(p: float) -> np.ndarray:
        return V.T @ slope(p).matrices(first.size) @ V

    linear = _linear(at, float(values[0]), float(values[-1]))
    return locus_of(name, unit, values, linear or MatrixFamily(at, derivative, np.ones((V.shape[1],) * 2, dtype=bool)))


def _linear(at: Callable[[float], np.ndarray], low: float, high: float) -> MatrixFamily | None:
    """The family of matrices, where they depend linearly on the parameter according to values between both ends; None otherwise."""
    first, last = at(low), at(high)
    noise = noise_of(np.abs([first, last]).max(axis=(0, 2, 3), initial=0.0))[:, None, None]
    for share in INNER:
        if (np.abs(at(low + share * (high - low)) - (1 - share) * first - share * last) > noise).any():
            return None
    slope = (last - first) / (high - low)
    return MatrixFamily.linear(first - low * slope, np.where(np.abs(last - first) > noise, slope, 0.0))


def locus_of(name: str, unit: str, values, family: MatrixFamily) -> RootLocus:
    values = ascending(values, "values", ", e.g. numpy.linspace(0, 100, 101)")
    with short_work(2 * len(family.pattern)):
        branches = followed(family, values)
        limits = stability_limits(family, values, branches.values)
        once = [one for one, before in zip(limits, (-np.inf, *limits)) if one - before > NEWTON_STEP * np.ptp(values)]  # of pairs
        return RootLocus(name, unit, values, branches.values, branches.slopes, break_points(family, branches), tuple(once))


def _basis(system: EquationsOfMotion, parameter: Parameter) -> np.ndarray:
    """V of coordinates that satisfy the rows, which must not depend on the parameter."""
    if any(row.any() for row, _ in parameter.rows.values()):
        raise InputError(f"{parameter.name}: constraint rows change with it; a root locus needs constant rows")
    return system.position_form().null_space
