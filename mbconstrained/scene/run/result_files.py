"""Trajectories of a result as CSV and as NumPy arrays."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .result import Result


def write_csv(path: Path, result: Result) -> None:
    """Write one line for each time: time, then every requested curve, headed by name and unit, with 17 digits.

    Args:
        path: of the file.
        result: of a run.
    """
    blocks = [result.curves(kind) for kind in result.kinds]
    heads = ["time (s)"]
    for block in blocks:
        heads += [f"{name} {title} ({unit})" for name, title, unit in zip(block.names, block.titles, block.units)]
    columns = np.vstack([result.times, *(block.values for block in blocks)])
    np.savetxt(path, columns.T, fmt="%.17g", delimiter=",", header=",".join(heads), comments="", encoding="utf-8")


def write_npz(path: Path, result: Result) -> None:
    """Write arrays, readable without pickle: times, names, curves, start, jump, impulses, events, finite and infinite pair.

    Args:
        path: of the file.
        result: of a run.
    """
    motion = result.motion
    arrays = {"times": result.times, "coordinates": np.array(result.scene.equations.coordinates.names)}
    for kind in result.kinds:
        arrays[kind] = result.curves(kind).values
    if "reaction" in result.kinds:
        arrays["constraints"] = np.array(result.curves("reaction").names)
    if result.scene.equations.has_outputs_among_coordinates:
        arrays["outputs"] = np.array(result.scene.equations.control.outputs.names)
    if "output" in result.kinds:
        arrays["outputs"] = np.array(result.curves("output").names)
    arrays |= {"initial": motion.initial, "jump": motion.jump}
    arrays["impulses"] = np.array(motion.impulses).reshape(len(motion.impulses), motion.jump.shape[1])
    if motion.events:
        arrays |= _events(motion.events)
    for name, pair in _pairs(result):
        arrays |= {f"{name}_C": pair.C, f"{name}_J": pair.J, f"{name}_B": pair.B}
    with open(path, "wb") as file:  # by its name alone, np.savez would put .npz behind it
        np.savez(file, **arrays)


def _events(events) -> dict[str, np.ndarray]:
    """Times (E,), jumps (E, q, r) and impulses (E, P, r), those of an event with fewer than P filled up with zeros."""
    most = max(len(event.impulses) for event in events)
    impulses = np.zeros((len(events), most, events[0].jump.shape[1]))
    for row, event in zip(impulses, events):
        for order, impulse in enumerate(event.impulses):
            row[order] = impulse
    times, jumps = np.array([event.time for event in events]), np.array([event.jump for event in events])
    return {"event_times": times, "event_jumps": jumps, "event_impulses": impulses}


def _pairs(result: Result):
    yield "finite", result.finite_pair
    if any(stage.name == "infinite pair" and stage.needed for stage in result.plan.stages):
        yield "infinite", result.infinite_pair
