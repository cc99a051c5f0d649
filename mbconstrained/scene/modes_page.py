"""From the modes of a scene to what their page shows."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..page.mode_content import ModePicture, ModesContent, Share, cycle
from .drawing import view_of
from .modes_drawing import DrawnModes
from .modes_summary import BY_COORDINATE, descending, shape_cells
from .robot_report import robot_facts

if TYPE_CHECKING:
    from .modes import ModeLine, SceneModes
    from .modes_robot import RobotModes


def modes_content(modes: SceneModes) -> ModesContent:
    """A picture for each line of the list; all move the same drawing."""
    scene = modes.scene
    stage = _stage(modes)
    units = tuple(zip(scene.equations.coordinates.names, scene.equations.coordinates.units))
    return ModesContent(
        title=scene.title,
        source=scene.table.source,
        drawing=stage.drawing,
        names=scene.equations.coordinates.names,
        modes=tuple(_picture(line, stage, units) for line in modes.lines),
        notices=modes.notices,
        facts=_facts(modes),
    )


def _stage(modes: SceneModes) -> DrawnModes | RobotModes:
    equations = modes.scene.equations
    if equations.robot_scene is None:
        return DrawnModes(modes.scene, [line.shape for line in modes.lines if line.shape is not None])
    from .modes_robot import RobotModes

    table = modes.scene.table.drawing
    return RobotModes(equations.robot_scene, note=table.note if table else "", view=view_of(table))


def _picture(line: ModeLine, stage: DrawnModes | RobotModes, units: tuple[tuple[str, str], ...]) -> ModePicture:
    facts = tuple((label, text) for label, text in line.cells.items() if label not in ("kind", "meaning"))
    if line.shape is None:
        return ModePicture(line.name, facts, note=line.cells["meaning"])
    factor = stage.amplitude(line.shape)
    return ModePicture(
        line.name,
        facts,
        shares=shares_by_part(line),
        shape=tuple(shape_cells(line.shape, units)),
        values=cycle(line.shape),
        paths=stage.paths(line.shape, factor),
        period=2 * np.pi / line.value.imag if line.value.imag else None,
        scale=factor,
        note=_note(line),
    )


def _note(line: ModeLine) -> str:
    meaning = line.cells["meaning"]
    if not line.value.imag:
        return f"{meaning}; drawn as if its shape swung"
    return f"{meaning}; drawn without {'growth' if line.value.real > 0 else 'decay'}" if line.value.real else meaning


def shares_by_part(line: ModeLine) -> tuple[Share, ...]:
    """(part, kinetic share, strain share) of every part that has either, the largest first; None where it has not the one."""
    kinetic, strain = line.shares.kinetic or {}, line.shares.strain or {}
    rows = ((name, kinetic.get(name), strain.get(name)) for name in dict.fromkeys((*kinetic, *strain)))
    return tuple(sorted(rows, key=lambda row: descending(max(abs(row[1] or 0.0), abs(row[2] or 0.0)))))


def _facts(modes: SceneModes) -> tuple[tuple[str, str], ...]:
    coordinates = modes.scene.equations.coordinates
    named = ", ".join(f"{name} ({unit})" for name, unit in zip(coordinates.names, coordinates.units))
    shares = [("shares of energy", BY_COORDINATE)] if modes.system.energy_parts.is_by_coordinate else []
    return (("coordinates", named), ("shapes", "their amplitude is free"), *robot_facts(modes.scene.equations.robot_scene), *shares)
