"""Sensitivities of a scene to its [parameters] and to its elements: which of them matter for frequencies and damping."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from ..ground.checks import nearest
from ..ground.display import TextTable, number_text
from ..ground.errors import InputError
from ..ground.tolerances import SHOWN_INFLUENCE
from ..mechanics.parameter import Parameter
from ..mechanics.sensitivities import Sensitivities
from ..scene.schema.entry_types import Table, Text
from .base import Analysis, Answer
from .sweep.plots import row_plot

if TYPE_CHECKING:
    from ..page.content import Plot
    from ..scene.run.scene_data import SceneData

NO_INFLUENCE = "No oscillating mode depends on {}; --json has the derivatives of all eigenvalues."

#: Modes and parameters of a tornado plot.
MOST_MODES, MOST_PARAMETERS = 6, 16

#: Coordinates up to which the page of the modes has these tables, within about a second, and rows above which it folds them.
MOST_COORDINATES, MOST_ROWS = 48, 8


class VariedNames(Table):
    """The parameters and elements to which sensitivities are computed."""

    to: list[Text] | None = Field(None, description="A parameter or an element; all by default.")


class Sensitivity(Analysis):
    """Compute changes of natural frequencies and damping per 1 % of each parameter or element, sorted by influence.

    Derivatives of eigenvalues and shapes in closed form; for defective ones exponents and coefficients of their splitting.
    """

    name = "sensitivity"
    settings = VariedNames
    options: ClassVar = {"to": "--to"}
    writes = False

    def __init__(self, scene: SceneData, names: Sequence[str] = ()):
        self.scene, own = scene, scene.parameters.values
        named = tuple(scene.named_parameters())
        self.system = scene.equations.system
        elements = () if getattr(scene.table.model, "modal_damping", None) is not None else self.system.parameters()
        if not named and not elements:
            raise InputError(
                "there is nothing to vary: name quantities of the scene in a table [parameters]; elements are not varied with modal damping"
            )
        known = {one.name: one for one in (*elements, *named)}
        for name in names:
            if name not in known:
                raise InputError(f'there is no parameter or element "{name}"{nearest(name, known)}; there are {", ".join(known)}')
        self.groups: dict[str, list[Parameter]] = {
            title: [one for one in group if not names or one.name in names]
            for title, group in (("parameters", named), ("elements", [one for one in elements if one.name not in own]))
        }

    @classmethod
    def solve(cls, scene: SceneData, settings: VariedNames | None) -> Answer:
        self = cls(scene, (settings and settings.to) or ())
        return cls.of(
            scene,
            tables=tuple(self.tables()),
            data=self._data(),
            plots=self.plots,
            heading=scene.heading,
            most_rows=None,
            keys=("notices",),
        )

    @cached_property
    def sensitivities(self) -> Sensitivities:
        """Sensitivities to all selected parameters and elements."""
        return self.system.sensitivities([one for group in self.groups.values() for one in group])

    def tables(self) -> Iterator[TextTable]:
        """One table for the parameters and one for the elements, in descending order of influence; defective eigenvalues."""
        for title, group in self.groups.items():
            names = [one.name for one in group]
            table = self.sensitivities.table(names) if group else None
            if table is not None and (table.rows or title == "parameters" or not self.groups["parameters"]):
                note = table.note if table.rows else NO_INFLUENCE.format(", ".join(names))
                yield TextTable(f"Sensitivities to {title}", table.columns if table.rows else (), table.rows, note)
        if rows := tuple((str(one.mode + 1), one.text) for one in self.sensitivities.defective):
            note = "of an eigenvalue with fewer shapes than its multiplicity there is no derivative; e is a small change"
            yield TextTable("Defective eigenvalues", ("mode", "how it splits"), rows, note)

    def plots(self) -> Iterator[Plot]:
        """Tornado plots of the lowest modes: changes of frequencies and of damping ratios by 1 % more of each parameter or element."""
        d, names = self.sensitivities, self.sensitivities.names
        values = np.array([[one.value] for one in d.parameters])
        kinds = (("natural frequency", "%", d.logarithmic), ("damping ratio", "", d.damping_ratios * values / 100))
        for quantity, unit, changes in kinds:
            changes = np.nan_to_num(changes[:, :MOST_MODES])
            influence = np.abs(changes).max(axis=1, initial=0.0)
            order = np.argsort(-influence, kind="stable")[:MOST_PARAMETERS]
            order = order[influence[order] > SHOWN_INFLUENCE * influence.max(initial=0.0)]
            modes = [f"mode {k + 1}, {number_text(f)} Hz" for k, f in enumerate(d.modes.frequencies_hz[:MOST_MODES])]
            if len(order):
                groups = dict(zip(modes, changes[order].T))
                yield row_plot(
                    f"{quantity}: change by 1 % of a parameter",
                    [names[i] for i in order],
                    groups,
                    f"change of the {quantity}",
                    unit,
                )

    def _data(self) -> dict:
        """Derivatives by parameter; complex numbers as pairs."""
        d = self.sensitivities
        return {
            "eigenvalues": _pairs(d.modes.eigenvalues),
            "frequencies_hz": d.modes.frequencies_hz,
            "sensitivities": [
                {
                    "name": parameter.name,
                    "value": parameter.value,
                    "unit": parameter.unit,
                    "eigenvalues": _pairs(d.eigenvalues[i]),
                    "frequencies_hz": d.frequencies_hz[i],
                    "damping_ratios": d.damping_ratios[i],
                    "logarithmic": d.logarithmic[i],
                }
                for i, parameter in enumerate(d.parameters)
            ],
            "defective": [
                {
                    "mode": one.mode + 1,
                    "parameter": one.parameter,
                    "exact": one.splitting.is_exact,
                    "branches": [
                        {"exponent": str(branch.exponent), "coefficient": _pairs([branch.coefficient])[0]}
                        for branch in one.splitting.branches
                    ],
                }
                for one in d.defective
            ],
            "error_estimate": float(d.error_estimate),
        }


def _pairs(values) -> list[list[float]]:
    return [[value.real, value.imag] for value in values]


def influence_tables(scene: SceneData) -> tuple[TextTable, ...]:
    """Ranking of parameter sensitivities for the page of the modes: elements of lumped models and [parameters], where it is cheap."""
    model, system = scene.table.model, scene.equations.system
    elements = model.kind == "lumped" or (model.kind == "matrices" and scene.parameters.values)
    if not elements or model.modal_damping is not None or system.is_sparse or system.delayed or system.size > MOST_COORDINATES:
        return ()
    return tuple(replace(table, folded=len(table.rows) > MOST_ROWS) for table in Sensitivity(scene).tables() if table.rows)
