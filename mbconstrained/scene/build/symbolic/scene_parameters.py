"""The [parameters] of a scene as parameters of its mechanical system, with the derivatives of the equations.

The expressions of the scene are evaluated with p + i h in the place of p (``models.lumped``). The equations of robots and
of modal damping come from an equilibrium or from modes, those of a rotor depend on its speed: these are assembled for values around p (``Parameter.of_function``).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from ....ground.errors import InputError
from ....ground.tolerances import COMPLEX_STEP
from ....mechanics.constraints import row_names
from ....mechanics.parameter import Parameter
from ....models.lumped import complex_parameter, exact_elements
from ...quantities.coordinates import constraint_row
from ...run.scene_data import SceneData
from ..data_files import entries_of


class ComplexNumbers:
    """Entries of a scene as numbers, with p + i h in place of one parameter.

    Args:
        values: values of all parameters.
        name: name of p.
        step: h.
    """

    def __init__(self, values: Mapping[str, float], name: str, step: float):
        self.values: dict[str, Any] = {**values, "pi": np.pi, name: complex(values[name], step)}

    def of(self, entry) -> Any:
        """A number unchanged, an expression by its value."""
        tree = getattr(entry, "tree", None)
        return float(entry) if tree is None else tree.value(float, self.values)

    def slope(self, entries, step: float) -> np.ndarray:
        """The derivatives of an array of entries."""
        return np.array([complex(self.of(entry)).imag / step for entry in np.asarray(entries, dtype=object).flat]).reshape(
            np.shape(entries)
        )


def scene_parameters(scene: SceneData, assembled: Callable[[SceneData, str, float], SceneData]) -> Iterator[Parameter]:
    """The parameters on which the equations depend."""
    if scene.equations.system is None:
        raise InputError("sensitivities need mass, damping and stiffness: a model of kind lumped, matrices or robot")
    model, values = scene.table.model, scene.parameters.values
    for name, value in values.items():
        unit = scene.parameters.units[name]
        follows = model.modal_damping is not None or getattr(scene.equations.system, "mass_damping", None) == "relative"
        if model.kind not in ("lumped", "matrices") or follows or scene.equations.rotor:
            yield Parameter.of_function(name, value, partial(_system, scene, assembled, name), unit)
            continue
        step = COMPLEX_STEP * (abs(value) or 1.0)
        numbers = ComplexNumbers(values, name, step)
        parameter = (
            _of_elements(scene, name, value, numbers, step) if model.kind == "lumped" else _of_matrices(scene, name, numbers, step)
        )
        yield replace(_with_rayleigh(scene, parameter, numbers, step), unit=unit)


def _system(scene: SceneData, assembled, name: str, value: float):
    return assembled(scene, name, value).equations.system


def _of_elements(scene: SceneData, name: str, value: float, numbers: ComplexNumbers, step: float) -> Parameter:
    model, gravity = scene.equations.model, scene.table.model.gravity
    elements = exact_elements(model.elements, numbers.of)
    pull = numbers.of(0.0 if gravity is None else gravity)
    return complex_parameter(name, value, elements, model.coordinates, step, "", pull)


def _of_matrices(scene: SceneData, name: str, numbers: ComplexNumbers, step: float) -> Parameter:
    model, coordinates = scene.table.model, scene.equations.coordinates
    slopes: dict[str, Any] = {}
    for key in ("stiffness", "damping", "mass"):
        source = getattr(model, key)
        slopes[key] = 0.0 if source is None else numbers.slope(entries_of(source, scene.path.parent), step)
    rows = {}
    for row, own in zip(model.constraint, row_names(scene.equations.system.constraints)):
        factors, value, _ = constraint_row(row, coordinates)
        slope = numbers.slope([factors.get(one, 0.0) for one in coordinates.names], step)
        rows[own] = (slope, float(numbers.slope(value, step)))
    return Parameter(name, scene.parameters.values[name], **slopes, rows=rows)


def _with_rayleigh(scene: SceneData, parameter: Parameter, numbers: ComplexNumbers, step: float) -> Parameter:
    """C + a M + b K with a and b depending on the parameter."""
    rayleigh, system = scene.table.model.rayleigh_damping, scene.equations.system
    if rayleigh is None:
        return parameter
    a, b = (complex(numbers.of(factor)).imag / step for factor in (rayleigh.mass, rayleigh.stiffness))
    own = parameter.with_damping(float(rayleigh.mass), float(rayleigh.stiffness))
    return replace(own, damping=own.damping + a * system.mass + b * system.stiffness)
