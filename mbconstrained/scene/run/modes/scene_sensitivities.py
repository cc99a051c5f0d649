"""The sensitivities of a scene to its [parameters] and to its elements, as tables and as plain data."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import chain
from textwrap import wrap
from typing import TYPE_CHECKING

from ....ground.checks import nearest
from ....ground.display import WIDTH, TextTable, finite_or_none
from ....ground.errors import InputError
from ....mechanics.parameter import Parameter
from ....mechanics.sensitivities import Sensitivities
from ..report.summary import notices_json
from ..scene_data import SceneData

if TYPE_CHECKING:
    from ....ground.notices import Notice

NO_INFLUENCE = "No oscillating mode depends on {}; --json has the derivatives of all eigenvalues."


#: Coordinates up to which the page of the modes has these tables, within about a second, and rows above which it folds them.
MOST_COORDINATES, MOST_ROWS = 48, 8


class SceneSensitivities:
    """Sensitivities to parameters and elements: changes per per cent of each.

    Args:
        scene: a scene with a mechanical system.
        names: names of the parameters and elements; all by default.

    Raises:
        InputError: no mechanical system, an unknown name.
    """

    def __init__(self, scene: SceneData, names: Sequence[str] = ()):
        self.scene, own = scene, scene.parameters.values
        named = tuple(scene.named_parameters())
        system = scene.equations.system
        elements = () if getattr(scene.table.model, "modal_damping", None) is not None else system.parameters()
        if not named and not elements:
            raise InputError(
                "there is nothing to vary: name quantities of the scene in a table [parameters]; elements are not varied with modal damping"
            )
        known = {one.name: one for one in (*elements, *named)}
        for name in names:
            if name not in known:
                raise InputError(f'there is no parameter or element "{name}"{nearest(name, known)}; there are {", ".join(known)}')
        self.groups = {
            title: tuple(one for one in group if not names or one.name in names)
            for title, group in (("parameters", named), ("elements", [one for one in elements if one.name not in own]))
        }

    @cached_property
    def sensitivities(self) -> Sensitivities:
        """Sensitivities to all selected parameters and elements."""
        return self.scene.equations.system.sensitivities(list(chain.from_iterable(self.groups.values())))

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices of the scene."""
        return self.scene.notices

    def tables(self) -> Iterator[TextTable]:
        """One table for the parameters and one for the elements, in descending order of influence; defective eigenvalues."""
        for title, group in self.groups.items():
            if group and (title == "parameters" or not self.groups["parameters"] or self._matter(group)):
                table = self.sensitivities.table([one.name for one in group])
                yield TextTable(f"Sensitivities to {title}", table.columns if table.rows else (), table.rows, _note(table, group))
        if rows := tuple((str(one.mode + 1), one.text) for one in self.sensitivities.defective):
            note = "of an eigenvalue with fewer shapes than its multiplicity there is no derivative; e is a small change"
            yield TextTable("Defective eigenvalues", ("mode", "how it splits"), rows, note)

    def _matter(self, group: Sequence[Parameter]) -> bool:
        return bool(self.sensitivities.table([one.name for one in group]).rows)

    def blocks(self) -> list[str | TextTable]:
        """Printed blocks."""
        heading = "\n".join(line for text in (self.scene.heading, self.scene.table.source) for line in wrap(text, WIDTH))
        notices = ["\n".join(wrap(str(notice), WIDTH)) for notice in self.notices]
        return [heading, *self.tables(), *notices]

    def as_json(self) -> dict:
        """Derivatives by parameter, None where they are infinite; complex numbers as pairs."""
        d = self.sensitivities
        rows = [
            {
                "name": parameter.name,
                "value": parameter.value,
                "unit": parameter.unit,
                "eigenvalues": [[finite_or_none(value.real), finite_or_none(value.imag)] for value in d.eigenvalues[i]],
                "frequencies_hz": [*map(finite_or_none, d.frequencies_hz[i])],
                "damping_ratios": [*map(finite_or_none, d.damping_ratios[i])],
                "logarithmic": [*map(finite_or_none, d.logarithmic[i])],
            }
            for i, parameter in enumerate(d.parameters)
        ]
        return {
            "title": self.scene.title,
            "eigenvalues": [[value.real, value.imag] for value in d.modes.eigenvalues],
            "frequencies_hz": d.modes.frequencies_hz.tolist(),
            "sensitivities": rows,
            "defective": [_splitting_json(one) for one in d.defective],
            "error_estimate": float(d.error_estimate),
            "notices": notices_json(self.notices),
        }


def influence_tables(scene: SceneData) -> tuple[TextTable, ...]:
    """Ranking of parameter sensitivities for the page of the modes: elements of lumped models and [parameters], where it is cheap."""
    model, system = scene.table.model, scene.equations.system
    elements = model.kind == "lumped" or (model.kind == "matrices" and scene.parameters.values)
    if not elements or model.modal_damping is not None or system.is_sparse or system.size > MOST_COORDINATES:
        return ()
    tables = SceneSensitivities(scene).tables()
    return tuple(replace(table, folded=len(table.rows) > MOST_ROWS) for table in tables if table.rows)


def _note(table: TextTable, group: Sequence[Parameter]) -> str:
    return table.note if table.rows else NO_INFLUENCE.format(", ".join(one.name for one in group))


def _splitting_json(one) -> dict:
    branches = [
        {"exponent": str(branch.exponent), "coefficient": [branch.coefficient.real, branch.coefficient.imag]}
        for branch in one.splitting.branches
    ]
    return {"mode": one.mode + 1, "parameter": one.parameter, "exact": one.splitting.is_exact, "branches": branches}
