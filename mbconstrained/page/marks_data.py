"""What is drawn over the model, as plain data for the page's script."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import numpy as np

from ..checks import nearest, real_number
from ..errors import InputError
from .drawing import Drawing
from .keyframes import KeyFrames
from .marks import LastingForce, Marks, Moment
from .poses import body_poses
from .typeset import raised

#: Length of the longest arrow, in drawing units; a mass is 0.8 wide.
LONGEST = 1.5

#: A body that moves or turns less than this in the picture (drawing units, rad) is not said to jump.
SEEN = 1e-3


def moment_frames(drawing: Drawing, frames: KeyFrames, moment: Moment) -> KeyFrames:
    """Two key frames: just before the moment, and just after it."""
    values = np.zeros((len(frames.names), 2))
    values[: len(moment.before)] = np.column_stack([moment.before, moment.after])
    near = int(np.argmin(np.abs(frames.times - moment.time)))
    there = (path and (path if path.count == 1 else path.thinned([near, near])) for path in frames.paths)
    paths = tuple(moment.paths.get(body.name, path) for body, path in zip(drawing.bodies, there))
    return KeyFrames(frames.names, np.array([moment.time, moment.time]), values, np.zeros_like(values), paths=paths)


def marks_data(marks: Marks, drawing: Drawing, frames: KeyFrames, unit: float) -> dict:
    """For the page's script; empty lists where there is nothing of a kind.

    Args:
        unit: length of a drawing unit in the drawing.

    Raises:
        InputError: an arrow at an unknown body.
    """
    numbers = {body.name: i for i, body in enumerate(drawing.bodies)}
    arrows = [arrow for force in marks.forces for arrow, _ in force.arrows]
    arrows += [arrow for moment in marks.moments for arrow, _, _ in moment.strikes]
    for arrow in arrows:
        if arrow.body not in numbers:
            raise InputError(f'arrow: "{arrow.body[:60]}" is no body{nearest(arrow.body, numbers)}')
    struck = largest_strikes(marks.moments)
    return {
        "moments": [_moment_data(moment, drawing, frames, numbers, struck, unit) for moment in marks.moments],
        "forces": _forces_data(marks.forces, numbers),
    }


def told_scale(forces: Sequence[LastingForce]) -> str:
    """How large the forces are that arrows show, such as "longest arrow 12.5 N"; an empty string where there are none."""
    told = [f"{size:.3g} {unit}" for unit, size in largest_forces(forces).items() if size]
    return f"longest arrow {' or '.join(told)}" if told else ""


def largest_forces(forces: Sequence[LastingForce]) -> dict[str, float]:
    """Of all forces at all times, by unit."""
    return _largest((arrow, factor * force.largest) for force in forces for arrow, factor in force.arrows)


def largest_strikes(moments: Sequence[Moment]) -> dict[str, float]:
    """Of all impulses, by unit."""
    return _largest((arrow, size) for moment in moments for arrow, size, _ in moment.strikes)


def _forces_data(forces: Sequence[LastingForce], numbers: Mapping[str, int]) -> list[dict]:
    largest = largest_forces(forces)
    return [
        {
            "name": force.name,
            "rows": len(force.names),
            "arrows": [
                {**arrow.as_data(numbers[arrow.body]), "factor": factor, "length": LONGEST / (largest[arrow.unit] or 1.0)}
                for arrow, factor in force.arrows
            ],
        }
        for force in forces
    ]


def _largest(sized) -> dict[str, float]:
    """The largest of all sizes by unit."""
    largest: dict[str, float] = {}
    for arrow, size in sized:
        largest[arrow.unit] = max(largest.get(arrow.unit, 0.0), float(np.linalg.norm(size)))
    return largest


def _moment_data(moment: Moment, drawing: Drawing, frames: KeyFrames, numbers, struck, unit: float) -> dict:
    strikes = [
        {
            **arrow.as_data(numbers[arrow.body]),
            "size": np.asarray(size).tolist(),
            "length": LONGEST / (struck[arrow.unit] or 1.0),
            "told": _typeset(told),
        }
        for arrow, size, told in moment.strikes
    ]
    ghosts = _ghosts(drawing, moment_frames(drawing, frames, moment), unit)
    return {
        "time": real_number(moment.time, "moment, time"),
        "told": [_typeset(line) for line in moment.told],
        "ghosts": ghosts,
        "strikes": strikes,
    }


def _typeset(text: str) -> str:
    """With raised powers of units and true minus signs."""
    return re.sub(r"(?<![\w.])-(?=\d)", "−", raised(text))


def _ghosts(drawing: Drawing, pair: KeyFrames, unit: float) -> list[list[float]]:
    """Number, position and quaternion just before of each body that is seen to jump."""
    found = []
    for number in range(len(drawing.bodies)):
        poses = body_poses(drawing, (pair,), number)
        way = np.linalg.norm(np.ptp(poses.positions, axis=1)) / unit
        turn = np.linalg.norm(np.ptp(poses.quaternions, axis=1))
        if max(way, 2 * turn) > SEEN:
            found.append([number, *poses.positions[:, 0].tolist(), *poses.quaternions[:, 0].tolist()])
    return found
