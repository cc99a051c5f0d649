"""The derivatives of motions and responses, as those of one system of twice the size.

With y = dx/dp the equations and their derivatives with respect to p are together

    [M_p M; M 0] [x; y]'' + [C_p C; C 0] [x; y]' + [K_p K; K 0] [x; y] = [f_p; f] + [A A_p; 0 A]^T [l_p; l],
    A x^(level) = b,  A_p x^(level) + A y^(level) = b_p:

a mechanical system again, symmetric where the first one is. Its motions, frequency responses and random responses are therefore exact
derivatives: A(s) y = f_p - A_p(s) x has a Bohl function on the right, H_p = -H A_p H, and E[x y^T] is the derivative of half the
covariance. Forces act on the second half of the coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...signals.impulsive import ImpulsiveSmooth
from ..constraints import Constraint
from ..equations import EquationsOfMotion
from .parameter import Parameter


def dual_system(system: EquationsOfMotion, parameter: Parameter) -> EquationsOfMotion:
    """The system of the coordinates x, named as before, and dx/dp, named "d(x)/d(p)"."""
    slopes = parameter.matrices(system.size)
    K, C, M = (
        np.block([[slope, matrix], [matrix, np.zeros_like(matrix)]])
        for slope, matrix in zip(slopes, (system.stiffness, system.damping, system.mass))
    )
    names = (*system.names, *derivative_names(system.names, parameter))
    static = np.concatenate([np.zeros(system.size) + parameter.force, system.static_force])
    force = None if system.excitation is None else shifted(system.excitation)
    units = [*system.units.values()] * 2
    return system.base_class(M, C, K, _rows(system, parameter), names, force, static, units)


def derivative_names(names: Sequence[str], parameter: Parameter) -> tuple[str, ...]:
    """The names of the derivatives."""
    return tuple(f"d({name})/d({parameter.name})" for name in names)


def shifted(force: ImpulsiveSmooth) -> ImpulsiveSmooth:
    """[0; f] from f."""
    return force.mapped(np.eye(2 * force.size)[:, force.size :])


def _rows(system: EquationsOfMotion, parameter: Parameter) -> list[Constraint]:
    slopes, values = parameter.constraint_rows(system)
    zero = np.zeros(system.size)
    derived = derivative_names([row.name for row in system.rows], parameter)
    first, second = [], []
    for row, name, slope, value in zip(system.rows, derived, slopes, values):
        right = row.value if row.signal is None else row.signal
        first.append(Constraint(np.concatenate([row.coefficients, zero]), row.level, right, row.name, row.unit))
        second.append(Constraint(np.concatenate([slope, row.coefficients]), row.level, float(value), name, row.unit))
    return first + second
