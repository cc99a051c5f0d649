"""The arrays of a result, for NumPy, MATLAB, netCDF and Zarr."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .result import Result


def arrays_of_result(result: Result) -> dict[str, np.ndarray]:
    """Times, names, curves, start, jump, impulses, events, finite and infinite pair."""
    arrays = {"times": result.times, "coordinates": np.array(result.scene.equations.coordinates.names)}
    for kind in result.kinds:
        arrays[kind] = result.curves(kind).values
    return arrays | more_arrays(result)


def more_arrays(result: Result) -> dict[str, np.ndarray]:
    """Those of ``arrays_of_result`` that are no curves."""
    arrays = {}
    if "reaction" in result.kinds:
        arrays["constraints"] = np.array(result.curves("reaction").names)
    if "ground_reaction" in result.kinds:
        arrays["ground_reactions"] = np.array(result.curves("ground_reaction").names)
    if result.scene.equations.has_outputs_among_coordinates:
        arrays["outputs"] = np.array(result.scene.equations.control.outputs.names)
    if "quantity" in result.kinds:
        arrays["quantities"] = np.array(result.curves("quantity").names)
    if "output" in result.kinds:
        arrays["outputs"] = np.array(result.curves("output").names)
    arrays |= result.motion.start_arrays()
    for name, pair in _pairs(result):
        arrays |= {f"{name}_C": pair.C, f"{name}_J": pair.J, f"{name}_B": pair.B}
    return arrays


def _pairs(result: Result):
    yield "finite", result.finite_pair
    if any(stage.name == "infinite pair" and stage.needed for stage in result.plan.stages):
        yield "infinite", result.infinite_pair
