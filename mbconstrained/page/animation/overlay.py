"""Forces, jumps and impulses as plain data for the page's script, with the extent of their arrows."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from ..drawing.paths import Path, rotated
from ..typeset import raised
from .animation import Arrow, ForceArrows, Overlay
from .keyframes import BodyPoses, KeyFrames

#: Length of the longest arrow, in drawing units; a mass is 0.8 wide.
LONGEST = 1.5

#: Radius of the arrow around an axis that stands for a moment, with its head, in drawing units.
MOMENT_RADIUS = 0.75

#: A body that moves or turns less than this in the picture (drawing units, rad) has no visible jump.
VISIBLE_JUMP = 1e-3


def overlay_data(
    overlay: Overlay, frames: KeyFrames, poses: BodyPoses, event_poses: Sequence[BodyPoses], unit: float
) -> tuple[dict, list[np.ndarray]]:
    """Forces, jumps and impulses for the page's script, with the extent of their arrows."""
    numbers = {name: i for i, name in enumerate(poses)}
    forces, events, points = [], [], []
    lengths = _lengths(_largest_forces(overlay.forces))
    for force in overlay.forces:
        arrows, first = [], frames.names.index(force.names[0])
        values = frames.values[first : first + len(force.names)]
        for arrow, factor in force.arrows:
            arrows.append({**_arrow_data(arrow, numbers, lengths), "factor": factor})
            points.append(_reached(arrow, poses[arrow.body], factor * lengths[arrow.unit] * values, unit))
        forces.append({"name": force.name, "rows": len(force.names), "arrows": arrows})
    lengths = _lengths(_largest((arrow, size) for event in overlay.events for arrow, size, _ in event.impulses))
    for event, pairs in zip(overlay.events, event_poses):
        ghosts, impulses = [], []
        for name, pair in pairs.items():
            distance = np.linalg.norm(np.ptp(pair.positions, axis=1)) / unit
            if max(distance, 2 * np.linalg.norm(np.ptp(pair.quaternions, axis=1))) > VISIBLE_JUMP:
                ghosts.append([numbers[name], *pair.positions[:, 0].tolist(), *pair.quaternions[:, 0].tolist()])
        for arrow, size, label in event.impulses:
            data = _arrow_data(arrow, numbers, lengths)
            impulses.append({**data, "size": np.asarray(size).tolist(), "label": _typeset(label)})
            values = lengths[arrow.unit] * np.repeat(np.reshape(size, (-1, 1)), 2, axis=1)
            points.append(_reached(arrow, pairs[arrow.body], values, unit))
        lines = [_typeset(line) for line in event.lines]
        events.append({"time": float(event.time), "lines": lines, "ghosts": ghosts, "impulses": impulses})
    return {"events": events, "forces": forces}, points


def _arrow_data(arrow: Arrow, numbers: dict[str, int], lengths: dict[str, float]) -> dict:
    return {
        "body": numbers[arrow.body],
        "direction": None if arrow.direction is None else arrow.unit_direction.tolist(),
        "turns": arrow.turns,
        "unit": arrow.unit,
        "point": list(arrow.point),
        "length": lengths[arrow.unit],
    }


def force_scale(forces: Sequence[ForceArrows]) -> str:
    """The size of the longest arrow of each unit, such as "longest arrow 12.5 N"; an empty string without forces."""
    sizes = [f"{size:.3g} {unit}" for unit, size in _largest_forces(forces).items() if size]
    return f"longest arrow {' or '.join(sizes)}" if sizes else ""


def _largest_forces(forces: Sequence[ForceArrows]) -> dict[str, float]:
    """The largest magnitude of all forces over all times, by unit."""
    sizes = ((force, np.linalg.norm(np.atleast_2d(force.values), axis=0).max()) for force in forces)
    return _largest((arrow, factor * size) for force, size in sizes for arrow, factor in force.arrows)


def _largest(sizes) -> dict[str, float]:
    largest: dict[str, float] = {}
    for arrow, size in sizes:
        largest[arrow.unit] = max(largest.get(arrow.unit, 0.0), float(np.linalg.norm(size)))
    return largest


def _lengths(largest: dict[str, float]) -> dict[str, float]:
    """Drawing units per unit of a force or impulse."""
    return {unit: LONGEST / (size or 1.0) for unit, size in largest.items()}


def _typeset(text: str) -> str:
    """A text with raised powers of units and true minus signs."""
    return re.sub(r"(?<![\w.])-(?=\d)", "−", raised(text))


def _reached(arrow: Arrow, poses: Path, values: np.ndarray, unit: float) -> np.ndarray:
    """The tips of a force with values (1, T) or (3, T) in drawing units; the corners of a box around a moment."""
    points = poses.of_points(np.array(arrow.point)[:, None])[:, 0] / unit
    if arrow.turns:
        return (points[:, :, None] + MOMENT_RADIUS * np.array([-1.0, 1.0])).reshape(3, -1)
    if arrow.direction is not None:
        return points + arrow.unit_direction[:, None] * values
    return points + np.einsum("ikt,kt->it", rotated(poses.quaternions, np.eye(3)), values)
