"""Samples whose parameters are numbers of the elements of a lumped model: their matrices in stacks, without a scene for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from ...ground.quantities import LARGEST, LEAST
from ...ground.tolerances import noise_of
from ...linalg.precise import is_worthwhile
from ...mechanics.family import BY_POLES, Family, family, stacked_transfers
from ...mechanics.stacked_equations import projected
from ...mechanics.stacked_poles import LargestResponses, largest_responses
from ...models.lumped import coordinate_row, exact_elements, incidence_of
from ...scene.run.scene import Scene
from ..frequency import Frequency


class Sampled(NDArrayOperatorsMixin):
    """A number of each sample, shape (S,), with which expressions and elements calculate."""

    def __init__(self, values: np.ndarray):
        self.values = values

    def __array_ufunc__(self, ufunc, method, *inputs):
        return Sampled(getattr(ufunc, method)(*(getattr(one, "values", one) for one in inputs)))


class SampledNumbers:
    """The numbers of a scene with the values of its parameters in S samples.

    Attributes:
        used: how many of them depend on the varied parameters.
        valid: samples in which each of these is in range and has the sign that it has in the scene, shape (S,).
    """

    def __init__(self, scene: Scene, columns: Mapping[str, np.ndarray]):
        values = {name: np.longdouble(value) for name, value in scene.parameters.values.items()}
        self.columns = columns
        self.values: dict[str, Any] = {
            **values,
            "pi": np.longdouble(np.pi),
            **{name: Sampled(one) for name, one in columns.items()},
        }
        self.used, self.valid = 0, np.all([_in_range(one) for one in columns.values()], axis=0)

    def of(self, entry: float) -> Any:
        """A number, or that of each sample."""
        tree = getattr(entry, "tree", None)
        if tree is None or not self.columns.keys() & set(tree.names):
            return float(entry)
        result = tree.value(np.longdouble, self.values)
        self.used += 1
        self.valid &= _in_range(result.values) & (np.sign(result.values) == np.sign(float(entry)))
        return result


def _in_range(values: np.ndarray) -> np.ndarray:
    size = np.abs(values)
    return (values == 0) | ((size >= LEAST) & (size <= LARGEST))


def stacked_samples(scene: Scene, rows: Sequence[Mapping[str, Any]]) -> tuple[np.ndarray, Family] | None:
    """The places of the samples that differ from the scene only in numbers of elements, and their family.

    Its coordinates are those that the constraint rows leave free. The scene is a sample as well, whose matrices must be those that it
    has. None where a parameter enters something else, such as a constraint row or a force; samples with numbers
    that an element could refuse, or of such a spread that they need more digits, are left out.
    """
    model, system, parameters = scene.equations.model, scene.equations.system, scene.parameters
    places = [place for place, names in parameters.places.items() if names & rows[0].keys()]
    in_elements = all(place[0] == "model" and len(place) > 3 and "teeth" not in place for place in places)
    if (
        model is None
        or system is None
        or system.is_sparse
        or scene.equations.switching
        or not (in_elements and rows[0].keys() <= parameters.values.keys())
    ):
        return None
    if any(isinstance(value, str) for row in rows for value in row.values()):
        return None
    columns = {name: np.array([parameters.values[name], *(row[name] for row in rows)], np.longdouble) for name in rows[0]}
    numbers = SampledNumbers(scene, columns)
    factors = incidence_of(exact_elements(model.elements, numbers.of), system.names, object)
    count, valid = len(rows) + 1, numbers.valid
    if numbers.used != len(places):
        return None
    matrices = [_stack(np.diag(factors.masses), count)]
    for branches in (factors.dampers, factors.springs):
        B, k = _stack(branches.incidence, count), _stack(branches.constants, count)
        matrix = B.transpose(0, 2, 1) @ (k[:, :, None] * B)
        matrices.append((matrix + matrix.transpose(0, 2, 1)) / 2)
        spread = k.max(axis=1, initial=0.0) / k.min(axis=1, initial=np.inf)
        valid &= [not is_worthwhile(each, 2 * system.size) for each in spread]
    for tie in factors.ties:
        if any(isinstance(each, Sampled) for each in (*coordinate_row(tie.row, system.names, object), tie.row_value)):
            return None  # free motions of such samples differ, and their rows may depend on each other
    given = (system.mass, system.damping, system.stiffness)
    if not all((np.abs(stack[0] - own) <= noise_of(np.abs(own))).all() for stack, own in zip(matrices, given)):
        return None
    V = system.position_form().null_space
    for i, matrix in enumerate(matrices):
        matrices[i], clear = projected(matrix, V)
        valid &= clear
    own = np.flatnonzero(valid[1:])
    M, C, K = (matrix[own + 1] for matrix in matrices)
    return (own, family(M, C, K)) if len(own) else None


def _stack(entries: np.ndarray, count: int) -> np.ndarray:
    """Numbers, some of which are those of each sample, in an array (S, ...)."""
    result = np.empty((count, *entries.shape))
    for place, entry in np.ndenumerate(entries):
        result[(slice(None), *place)] = getattr(entry, "values", entry)
    return result


def stacked_peaks(frequency: Frequency, systems: Family, is_reduced: bool = False) -> LargestResponses | None:
    """The largest responses of systems with the inputs and outputs of a response; None where poles do not give them.

    Reduced systems have the coordinates that the constraint rows of its system leave free.
    """
    harmonic, system = frequency.empty.harmonic, frequency.system
    if system is None or harmonic.quantity not in BY_POLES or harmonic.sizes is not None or any(row.order for row in system.rows):
        return None
    if harmonic.left_out or harmonic.delayed or harmonic.input_delays:
        return None
    if is_reduced:
        n, V = system.size, system.position_form().null_space
        if len(harmonic.inputs) != n + len(system.rows) or harmonic.inputs[n:].any() or harmonic.outputs[:, n:].any():
            return None
        harmonic = replace(harmonic, inputs=V.T @ harmonic.inputs[:n], outputs=harmonic.outputs[:, :n] @ V)
    parts = [
        largest_responses(transfer, *frequency.searched)
        for _, transfer in stacked_transfers(systems, harmonic, np.zeros(harmonic.inputs.shape[1]))
    ]
    joined = (np.concatenate([getattr(part, each.name) for part in parts]) for each in fields(LargestResponses)) if parts else ()
    return LargestResponses(*joined) if parts else None
