"""Trajectories at the times of a scene, with names and units."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...exchange.trajectories import Curves
from ...frequency.shock.extrema import (
    Extrema,
    RootMeanSquares,
    extrema,
    fastest_rate,
    positive_times,
    root_mean_squares,
    sampled_extrema,
)
from ...ground.coordinate_units import derivative_name, force_unit, rate_unit
from ...ground.tolerances import NOT_DRAWN
from ..quantities.output_units import OutputUnits
from .report.element_quantities import element_quantities

if TYPE_CHECKING:
    from ...page.content import TimeFunctions
    from ...signals.bohl import BohlFunction
    from .answer import SceneAnswer

ORDERS = {"displacement": 0, "velocity": 1, "acceleration": 2}
PARTS = {  # curves that are made of others
    "energy": ("displacement", "velocity"),
    "output": ("displacement",),
    "phase": ("displacement", "velocity"),
    "quantity": ("displacement", "velocity"),
    "ground_reaction": ("displacement", "velocity", "reaction"),
}

#: Errors of trajectories, relative to the largest value of a kind, that are assumed at least and at most.
LEAST_NOISE, MOST_NOISE = 1e-13, 0.1

#: Curves of each kind whose largest values are listed.
MOST_LARGEST = 40

ENERGIES = ("kinetic", "strain", "static", "total")


def curves_of(result: SceneAnswer, kind: str) -> Curves:
    """The trajectories of a kind at the times of a scene."""
    equations, values = result.scene.equations, functions_of(result, kind)(result.times)
    if kind in ORDERS:
        order, coordinates = ORDERS[kind], equations.coordinates
        titles = tuple(derivative_name(unit, order) for unit in coordinates.units)
        return Curves(kind, coordinates.names, titles, tuple(rate_unit(unit, order) for unit in coordinates.units), values)
    if kind == "quantity":
        quantities = element_quantities(result.scene.table.output.quantity, equations)
        names, titles, units = zip(*((each.name, each.title, each.unit) for each in quantities))
        return Curves(kind, names, titles, units, values)
    if kind == "reaction":
        rows = equations.system.rows
        names, units = tuple(row.name for row in rows), tuple(force_unit(row.unit) for row in rows)
    elif kind == "output":
        names, units = equations.outputs.names, equations.outputs.units
    elif kind == "ground_reaction":
        forces = equations.robot_scene.system.connection_forces
        titles = tuple(f"{'force' if unit == 'N' else 'torque'} in ground axes" for unit in forces.units)
        return Curves(kind, forces.names, titles, forces.units, values)
    else:
        names, units = ENERGIES, ("J",) * len(ENERGIES)
    return Curves(kind, names, (kind,) * len(names), units, values)


def extrema_of(result: SceneAnswer, kind: str, rows: Sequence[int] | None = None) -> Extrema:
    """The largest and the smallest values of a kind between the first and the last time, exact extrema of the closed form."""
    start, end = float(result.times[0]), float(result.times[-1])
    at, (linear, constants) = functions_of(result, kind), _linear(result, kind)
    if linear is not None:
        chosen = list(range(linear.size) if rows is None else rows)
        extremes = extrema(linear.rows(chosen), start, end)
        return extremes.with_values(lambda times: at(times)[chosen]) if constants is None else extremes.shifted(constants[chosen])
    return sampled_extrema_of(result, at if rows is None else lambda times: at(times)[list(rows)])


def rms_of(result: SceneAnswer, kind: str, rows: Sequence[int]) -> RootMeanSquares:
    """The RMS values of some curves of a kind from the first to the last time, by integrals of the closed form."""
    at, (linear, constants) = functions_of(result, kind), _linear(result, kind)
    added = None if constants is None else constants[list(rows)]
    ends = float(result.times[0]), float(result.times[-1])
    return root_mean_squares(linear.rows(rows), *ends, added, lambda times: at(times)[list(rows)])


@dataclass(frozen=True)
class Largest:
    """The largest modulus of a curve between the first and the last time, of the closed form.

    Attributes:
        name, title, unit: name, title and unit of the curve, in SI.
        value: with its sign.
        time: in s.
        margin: bound of the excess of the maximum over this value; 0 except for motions of very many periods.
    """

    name: str
    title: str
    unit: str
    value: float
    time: float
    margin: float


def largest_values(result: SceneAnswer) -> list[Largest]:
    """The largest moduli of the requested curves, of each kind the first ``MOST_LARGEST``."""
    values: list[Largest] = []
    wanted = result.scene.table.output.coordinates
    for kind in (kind for kind in result.kinds if kind != "phase"):
        own = result.curves(kind)
        rows = [i for i, name in enumerate(own.names) if kind not in ORDERS or wanted is None or name in wanted][:MOST_LARGEST]
        extremes = extrema_of(result, kind, rows) if len(rows) < len(own.names) else result.extrema(kind)
        signs = np.where(extremes.maximum >= -extremes.minimum, 1.0, -1.0)
        for row, *ends in zip(rows, signs * extremes.largest, extremes.largest_time, extremes.margin):
            values.append(Largest(own.names[row], own.titles[row], own.units[row], *map(float, ends)))
    return values


def sampled_extrema_of(result: SceneAnswer, at: Callable[[np.ndarray], np.ndarray]) -> Extrema:
    """Extrema of functions with squares of the motion, such as energies, by ``sampled_extrema``."""
    rate = 2 * fastest_rate(result.motion.function)
    return sampled_extrema(at, _breaks(result), rate, float(result.times[0]), float(result.times[-1]))


def positive_times_of(result: SceneAnswer, at: Callable[[np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Times at which functions with squares or ratios of the motion are largest, and first positive, by ``positive_times``."""
    rate, breaks = 2 * fastest_rate(result.motion.function), _breaks(result)
    return positive_times(at, breaks, rate, float(result.times[0]), float(result.times[-1]))


def _linear(result: SceneAnswer, kind: str) -> tuple[BohlFunction | None, np.ndarray | None]:
    """A kind of curves in closed form, without constants, and the constants; None for energies."""
    equations, motion = result.scene.equations, result.motion
    if kind in ORDERS:
        return (motion.derivative(ORDERS[kind]) if ORDERS[kind] else motion.function), None
    if kind == "reaction":
        return motion.reaction_function, None
    if kind == "output" and equations.control is not None:
        control = equations.control
        count = len(control.outputs.names)
        function = control.response.output_function if control.form is not None else motion.function
        return function.rows(range(function.size - count, function.size)), None
    if kind == "output":
        return motion.function.mapped(equations.robot_scene.system.output_matrix), None
    if kind == "quantity":
        quantities = tuple(element_quantities(result.scene.table.output.quantity, equations))
        matrices = np.array([each.rows for each in quantities]).transpose(1, 0, 2)
        return motion.function.differential(*matrices), np.array([each.constant for each in quantities])
    if kind == "ground_reaction":
        forces = equations.robot_scene.system.connection_forces
        function = motion.function.differential(forces.displacement, forces.velocity)
        return function + motion.reaction_function.mapped(forces.multipliers) if equations.system.rows else function, forces.rest
    return None, None


def functions_of(result: SceneAnswer, kind: str) -> Callable[[np.ndarray], np.ndarray]:
    """Trajectories of a kind as functions of time."""
    equations, motion = result.scene.equations, result.motion
    if kind in ORDERS:
        return motion.derivative(ORDERS[kind]) if ORDERS[kind] else motion
    if kind == "reaction":
        return motion.reaction
    if kind == "ground_reaction":
        forces, rate = equations.robot_scene.system.connection_forces, motion.derivative(1)
        reaction = motion.reaction if equations.system.rows else lambda times: np.zeros((0, len(times)))
        return lambda times: forces.values(motion(times), rate(times), reaction(times))
    if kind == "output":
        return lambda times: equations.output_values(times, motion(times))
    if kind == "quantity":
        quantities = tuple(element_quantities(result.scene.table.output.quantity, equations))
        return lambda times: np.array([each.values(motion, times) for each in quantities])
    return lambda times: np.array([getattr(motion.energy(times), name) for name in ENERGIES])


def time_functions(result: SceneAnswer, kind: str) -> TimeFunctions:
    """Trajectories as stored in the page: in the units of [output], with the times of possible jumps and kinks, and their estimated
    error.
    """
    from ...page.content import TimeFunctions

    parts, breaks = PARTS.get(kind, (kind,)), _breaks(result)
    estimates = [result.error_estimates.get(part, 0.0) for part in (kind, *parts)]
    noise = min(max(LEAST_NOISE, *estimates), MOST_NOISE)
    values, shown = drawn_functions(result, kind), result.scene.equations.coordinates.shown
    factors = np.array([[shown.of(unit)[1]] for unit in result.curves(kind).units])
    return TimeFunctions(lambda times: factors * values(times), breaks, noise, result.record_response)


def drawn_functions(result: SceneAnswer, kind: str) -> Callable[[np.ndarray], np.ndarray]:
    """The functions without proof of their values, which takes long, where no visible difference results at the times of the scene."""
    linear, constants = _linear(result, kind)
    if linear is None:
        return functions_of(result, kind)
    rough, proved = getattr(linear, "rough", linear), result.curves(kind).values
    added = 0.0 if constants is None else constants[:, None]
    near = np.abs(rough(result.times) + added - proved).max(axis=1) <= NOT_DRAWN * np.abs(proved).max(axis=1)
    return (lambda times: rough(times) + added) if near.all() else functions_of(result, kind)


def _breaks(result: SceneAnswer) -> np.ndarray:
    """Times at which the motion or a derivative of it may jump."""
    return np.unique([*result.motion.force.knots, *(event.time for event in result.motion.events)])


def in_units(curves: Curves, units: OutputUnits) -> Curves:
    """Curves in the units of page and CSV."""
    if not units.units:
        return curves
    names, factors = zip(*map(units.of, curves.units))
    return replace(curves, units=names, values=np.array(factors)[:, None] * curves.values)


def visible(values: np.ndarray, units: tuple[str, ...]) -> np.ndarray:
    """Range of the coordinates by unit, which decides what is visible."""
    reach = np.ptp(values, axis=1)
    furthest = {unit: max(own for own, other in zip(reach, units) if other == unit) for unit in units}
    return np.array([max(furthest[unit] / 2, NOT_DRAWN * np.abs(values).max()) for unit in units])[:, None]
