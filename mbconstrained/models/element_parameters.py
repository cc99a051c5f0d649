"""The constants of the elements of a lumped model as parameters, with the derivatives of the assembled equations.

Every entry of the equations is a rational function of the numbers of the elements. Its derivative is taken by a complex step,
Im g(p + i h) / h with h = 1e-40 p, which is exact to rounding errors: nothing cancels (Squire and Trapp 1998).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from typing import Any, Protocol

import numpy as np

from ..ground.coordinate_units import GROUND
from ..ground.tolerances import COMPLEX_STEP
from ..mechanics.parameter import Parameter
from .elements import Body, Damper, Element, Link, PrescribedMotion, Tie, TorsionDamper
from .rigid_bar import with_parts

#: Numbers of elements on which no equation depends, or none in time, or only that of one speed.
LEFT_OUT = ("position", "loss_factor", "polar_inertia", "moment", "angle")


class Assembly(Protocol):
    """A lumped model: its elements on its coordinates, with the part of gravity along them."""

    @property
    def elements(self) -> Sequence[Element]: ...

    @property
    def gravity_along(self) -> float: ...

    @property
    def coordinates(self) -> tuple[str, ...]: ...


def element_parameters(model: Assembly) -> Iterator[Parameter]:
    """One parameter for each constant of an element: named as a body or link itself, "gear 1.start_radius" for others."""
    for element in model.elements:
        if isinstance(element, PrescribedMotion):
            continue
        for field in (*element.positive, *element.nonzero, *element.nonnegative, *element.real):
            value = getattr(element, field)
            if value is not None and field not in LEFT_OUT:
                main = isinstance(element, (Body, Link)) and field == element.positive[:1][0]
                yield _parameter(model, element, field, element.name if main else f"{element.name}.{field}", float(value))
        for field in ("points", "coefficients"):
            for key, value in getattr(element, field, {}).items():
                yield _parameter(model, element, field, f"{element.name}.{key}", float(value), key)


def _parameter(model: Assembly, element: Element, field: str, name: str, value: float, key: str | None = None) -> Parameter:
    step = COMPLEX_STEP * (abs(value) or 1.0)
    number: Any = complex(value, step)
    twin = copy(element)
    object.__setattr__(twin, field, number if key is None else {**getattr(element, field), key: number})
    return complex_parameter(name, value, [twin], model, step, _unit(element, field))


def complex_parameter(
    name: str, value: float, elements: Sequence[Element], model: Assembly, step: float, unit: str, gravity: complex | None = None
) -> Parameter:
    """The derivatives from elements whose constants are those of p + i h."""
    names = model.coordinates
    place = {coordinate: i for i, coordinate in enumerate(names)}
    size, pull = len(names), model.gravity_along if gravity is None else gravity
    K, C, M, force = (np.zeros(shape, dtype=complex) for shape in [(size, size)] * 3 + [size])
    rows = {}
    for one in with_parts(elements):
        if isinstance(one, Body):
            M[place[one.name], place[one.name]] += one.constant
        elif isinstance(one, Link):
            row = _row({one.start: -1.0, one.end: 1.0}, place).real
            if isinstance(one, (Damper, TorsionDamper)):
                C += one.constant * np.outer(row, row)
            else:
                K += one.constant * np.outer(row, row)
                force += row * one.constant * one.rest
        elif isinstance(one, Tie) and not isinstance(one, PrescribedMotion):
            rows[one.name] = (_row(one.row, place).imag / step, complex(one.row_value).imag / step)
    for element in elements:
        for coordinate, mass in element.weighing.items():
            force[place[coordinate]] += pull * mass
    slopes: list[Any] = [matrix.imag / step if matrix.imag.any() else 0.0 for matrix in (K, C, M, force)]
    moving = {key: row for key, row in rows.items() if row[0].any() or row[1]}
    K, C, M, force = slopes
    return Parameter(name, value, K, C, M, force, moving, unit)


def _row(coefficients: Mapping[str, complex], place: Mapping[str, int]) -> np.ndarray:
    row = np.zeros(len(place), dtype=complex)
    for name, factor in coefficients.items():
        if name != GROUND:
            row[place[name]] = factor
    return row


def _unit(element: Element, field: str) -> str:
    turning = isinstance(element, Link) and "start" in element.turning
    units = {
        "mass": "kg",
        "inertia": "kg m^2",
        "diametral_inertia": "kg m^2",
        "stiffness": "N m/rad" if turning else "N/m",
        "damping": "N m s/rad" if turning else "N s/m",
        "rest_angle": "rad",
    }
    return units.get(field, "m")
