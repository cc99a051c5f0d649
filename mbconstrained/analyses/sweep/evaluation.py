"""One chunk of samples: each becomes a scene; those of one structure are solved together as a family, the others one by one.

Equal chunks give equal bits in every process: computed on one thread, from plain data, without state.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.lib.mixins import NDArrayOperatorsMixin

from ...frequency.extrema import Extrema, RootMeanSquares
from ...ground.errors import InputError, MbconstrainedError
from ...ground.quantities import LARGEST, LEAST
from ...ground.threads import SMALL, one_thread
from ...ground.tolerances import PROVED_ACCURACY, noise_of
from ...linalg.precise import is_worthwhile
from ...mechanics.element_matrix import ElementMatrix
from ...mechanics.family import BY_POLES, Family, FamilyModes, family, stacked_transfers
from ...mechanics.stacked_equations import projected
from ...mechanics.stacked_poles import LargestResponses, largest_responses
from ...mechanics.system import MechanicalSystem
from ...models.lumped import coordinate_row, exact_elements, incidence_of
from ...robot.linearized import LinearizedRobot
from ...scene.file import SceneName
from ...scene.run.result import ORDERS, Result
from ...scene.run.scene import Scene, assembled
from ..frequency import Frequency
from ..random import random_arguments, random_response
from .kept_quantities import Variable, eigenvalues_of, event_figure, response_lines

#: Errors that are the answer of a sample: its equations have none, or its data are wrong.
FAILURES = (MbconstrainedError, ArithmeticError, np.linalg.LinAlgError)

#: Letters of a reason.
LONGEST_REASON = 160

#: Its array: whether a sample has an answer.
ANSWERED, FAILED, TIMED_OUT = 1, 2, 3


@dataclass(frozen=True)
class Job:
    """A scene and the kept quantities of its samples, as plain data for other processes."""

    path: str  # path of the scene file
    data: dict  # its tables
    origins: Mapping  # of the entries that come from other files
    settings: Mapping[str, Any]  # values that all samples share
    variables: tuple[Variable, ...]  # kept quantities
    data_folders: tuple[Path, ...] = ()  # of its data files, besides its own folder

    def scene(self, row: Mapping[str, Any]) -> Scene:
        path = Path(self.path)
        name = SceneName(path.name, self.origins)
        return assembled(path, copy.deepcopy(self.data), name, {**self.settings, **row}, None, self.data_folders)

    @cached_property
    def given_scene(self) -> Scene:
        """The scene with its own values of the varied parameters."""
        return self.scene({})

    def __getstate__(self) -> dict[str, Any]:
        return {field.name: getattr(self, field.name) for field in fields(self)}


class SampleFamily(Family):
    """A family whose members are the systems of scenes, with more than their matrices, such as their elements."""

    members: tuple[MechanicalSystem, ...]

    @classmethod
    def of(cls, systems: Sequence[MechanicalSystem]) -> SampleFamily:
        arrays = (np.stack([getattr(one, key) for one in systems]) for key in ("mass", "damping", "stiffness", "static_force"))
        result = cls(systems[0], *arrays)
        object.__setattr__(result, "members", tuple(systems))
        return result

    def __getitem__(self, index: int) -> MechanicalSystem:
        return self.members[index]

    def _is_free(self, shapes: np.ndarray, of: Literal["stiffness", "damping"]) -> np.ndarray:
        """Which systems have no springs, or no dampers, that resist some motions: by elements, whose soft ones keep their digits."""
        given = [one.given[("stiffness", "damping").index(of)] for one in self.members]
        if not all(isinstance(one, ElementMatrix) for one in given):
            return super()._is_free(shapes, of)
        acting = (one.directions[one.constants != 0] for one in given)
        return np.array([(np.abs(B @ shapes) <= noise_of(np.abs(B) @ np.abs(shapes))).all() for B in acting])


def evaluate(job: Job, rows: Sequence[Mapping[str, Any]]) -> dict[str, np.ndarray]:
    """Kept quantities of some samples."""
    with one_thread(SMALL), np.errstate(all="ignore"):
        return _Chunk(job, rows).arrays()


#: Kept quantities that samples of elements' numbers have without scenes.
STACKED = ("modes", "response peaks")


def is_stacked(job: Job, row: Mapping[str, Any]) -> bool:
    """Whether stacks serve all kept quantities of samples such as this one."""
    with suppress(*FAILURES):
        return all(one.source in STACKED for one in job.variables) and stacked_samples(job.given_scene, [row]) is not None
    return False


def without_answer(job: Job, reason: str) -> dict[str, np.ndarray]:
    """A sample that took too long, in the form of ``evaluate``."""
    values = {one.name: np.full((1, *one.shape), np.nan) for one in job.variables}
    return {**values, "status": np.array([TIMED_OUT], dtype=np.uint8), "reason": np.array([reason], dtype=f"<U{LONGEST_REASON}")}


class _Chunk:
    """Some samples with their scenes, and the reasons of those without an answer."""

    def __init__(self, job: Job, rows: Sequence[Mapping[str, Any]]):
        self.job, self.rows = job, rows
        self.reasons = [""] * len(rows)
        self.values = {one.name: np.full((len(rows), *one.shape), np.nan) for one in job.variables}
        self.scenes: dict[int, Scene] = {}
        self.results: dict[int, Result] = {}

    def arrays(self) -> dict[str, np.ndarray]:
        """Values, status and reasons."""
        by_source: dict[str, list[Variable]] = {}
        for variable in self.job.variables:
            by_source.setdefault(variable.source, []).append(variable)
        for source, variables in by_source.items():
            compute = getattr(self, "_" + source.lower().replace(" ", "_"))
            served = self._served(variables, source)
            for group in self._groups(served, source):
                self._together(compute, variables, group)
        failed = np.array([bool(reason) for reason in self.reasons])
        for values in self.values.values():
            values[failed] = np.nan
        texts = np.array([reason[:LONGEST_REASON] for reason in self.reasons], dtype=f"<U{LONGEST_REASON}")
        return {**self.values, "status": np.where(failed, FAILED, ANSWERED).astype(np.uint8), "reason": texts}

    def _together(self, compute, variables: list[Variable], group: list[int]) -> None:
        """Compute a group; if that fails, each of its samples separately."""
        if len(group) > 1:
            with suppress(*FAILURES):
                compute(variables, group)
                return
        for place in group:
            with self._answering(place):
                compute(variables, [place])

    @contextmanager
    def _answering(self, place: int) -> Iterator[None]:
        """A context whose failure is the reason for which a sample has no answer."""
        try:
            yield
        except FAILURES as problem:
            self.reasons[place] = self.reasons[place] or (str(problem).strip() or type(problem).__name__).replace("\n", " ")

    def _groups(self, served: Container[int], source: str) -> list[list[int]]:
        """The samples that are not served and have no reason for failure, grouped by structure where that is of use."""
        groups: list[list[int]] = []
        alike = {
            "modes": _have_similar_systems,
            "response peaks": _have_alike_responses,
            "random RMS": _alike,
            "motion": _alike,
        }.get(source)
        for place, row in enumerate(self.rows):
            if place in served or self.reasons[place]:
                continue
            with self._answering(place):
                self.scenes[place] = self.scenes.get(place) or self.job.scene(row)
            if self.reasons[place]:
                continue
            scene = self.scenes[place]
            group = next((one for one in groups if alike and alike(self.scenes[one[0]], scene)), None)
            if group is None:
                groups.append([place])
            else:
                group.append(place)
        return groups

    @cached_property
    def _stacked(self) -> tuple[np.ndarray, Family] | None:
        """The places of the samples that differ in numbers of elements only, and their family."""
        with suppress(*FAILURES):
            return stacked_samples(self.job.given_scene, self.rows)
        return None

    def _served(self, variables: list[Variable], source: str) -> frozenset[int]:
        """Store what stacks without a scene of each sample give, and return the places of the samples that are accurate."""
        with suppress(*FAILURES):
            if source in STACKED and (stacked := self._stacked) is not None:
                places, systems = stacked
                if source == "modes":
                    modes = systems.modes()
                    accurate = np.setdiff1d(np.arange(len(places)), modes.alone)
                    self._store_modes(variables, places[accurate], modes, accurate)
                else:
                    accurate = self._stacked_peaks(variables, places, systems, self.job.given_scene, is_reduced=True)
                return frozenset(places[accurate].tolist())
        return frozenset()

    def _modes(self, variables: list[Variable], group: list[int]) -> None:
        if len(group) > 1:
            self._store_modes(variables, np.array(group), SampleFamily.of(self._systems(group)).modes(), np.arange(len(group)))
            return
        own = eigenvalues_of(self.scenes[group[0]])
        own = own[own.imag > 0]
        own = own[np.argsort(np.abs(own), kind="stable")]
        modulus = np.abs(own)
        results = {"frequency": modulus / (2 * np.pi), "damping ratio": 0.0 - own.real / modulus}
        for variable in variables:
            count = min(len(own), variable.shape[0])
            self.values[variable.name][group[0], :count] = results[variable.name][:count]

    def _store_modes(self, variables: list[Variable], places: np.ndarray, modes: FamilyModes, chosen: np.ndarray) -> None:
        results = {"frequency": modes.frequencies_hz, "damping ratio": 0.0 + modes.damping_ratios}
        for variable in variables:
            own = results[variable.name][chosen, : variable.shape[0]]
            self.values[variable.name][places, : own.shape[1]] = own

    def _response_peaks(self, variables: list[Variable], group: list[int]) -> None:
        places, served = np.array(group), np.zeros(0, dtype=int)
        if len(group) > 1:
            served = self._stacked_peaks(variables, places, SampleFamily.of(self._systems(group)), self.scenes[group[0]])
        for place in np.delete(places, served).tolist():
            with self._answering(place):
                largest = Frequency(self.scenes[place]).largest
                for variable, rows in zip(variables, largest):
                    self.values[variable.name][place] = rows.ravel()

    def _stacked_peaks(self, variables: list[Variable], places: np.ndarray, systems: Family, scene: Scene, **options) -> np.ndarray:
        """Store the largest responses of systems that have those of a scene, and return the indices of those that are accurate."""
        stacked = stacked_peaks(Frequency(scene), systems, **options)
        served = np.zeros(0, dtype=int) if stacked is None else np.flatnonzero(stacked.serve)
        for variable, values in zip(variables, () if stacked is None else (stacked.amplitudes, stacked.frequencies_hz)):
            self.values[variable.name][places[served]] = values.reshape(len(values), -1)[served]
        return served

    def _response_curves(self, variables: list[Variable], group: list[int]) -> None:
        for place in group:
            frequency = Frequency(self.scenes[place])
            response = frequency.empty(response_lines(frequency))
            for variable, row in zip(variables, np.abs(response.values).reshape(len(variables), -1)):
                self.values[variable.name][place] = row

    def _random_rms(self, variables: list[Variable], group: list[int]) -> None:
        scene = self.scenes[group[0]]
        response = random_response(scene)
        if len(group) == 1:
            self.values["random RMS"][group] = response.rms
            return
        family = SampleFamily.of(self._systems(group))
        excitation, options = random_arguments(scene, scene.table.random)
        self.values["random RMS"][group] = family.random_response(*excitation, **options).rms

    def _motion(self, variables: list[Variable], group: list[int]) -> None:
        own = [one for one in variables if one.curve[0] in (*ORDERS, "output")]
        if len(group) == 1 or not own:
            for place in group:
                self._single_motion(variables, place)
            return
        scene = self.scenes[group[0]]
        start = np.array([self.scenes[place].equations.initial for place in group])
        motions = SampleFamily.of(self._systems(group)).solve(start[:, 0], start[:, 1], scene.equations.force)
        for kind, chosen in _by_kind(one for one in own if one.statistic in ("at", "curve")):
            times = _times_of(chosen)
            values = motions.evaluate(times, ORDERS.get(kind, 0))[0]
            if kind == "output":
                values = np.array([scene.equations.output_values(times, each) for each in values])
            self._store(chosen, group, values, times)
        span = float(scene.times[0]), float(scene.times[-1])
        kinds: tuple[tuple[Container, Callable, Callable], ...] = (
            (EXTREMA, self._store_extrema, motions.extrema),
            (("RMS",), self._store_rms, motions.root_mean_squares),
        )
        for statistics, store, compute in kinds:
            for kind, chosen in _by_kind(one for one in own if one.statistic in statistics):
                rows = sorted({one.curve[1] for one in chosen})
                matrix = (
                    np.eye(len(scene.equations.coordinates.names))
                    if kind != "output"
                    else scene.equations.robot_scene.system.output_matrix
                )
                for place, answer in zip(group, compute(span, ORDERS.get(kind, 0), matrix[rows])):
                    store(chosen, place, rows, answer)
        for place in group if len(own) < len(variables) else ():
            self._single_motion([one for one in variables if one not in own], place)

    def _result(self, place: int) -> Result:
        """The motion of a sample, which several kept quantities share."""
        self.results[place] = self.results.get(place) or Result(self.scenes[place])
        return self.results[place]

    def _events(self, variables: list[Variable], group: list[int]) -> None:
        for place in group:
            events = self._result(place).motion.events
            for one in variables:
                self.values[one.name][place] = event_figure(one, events)

    def _single_motion(self, variables: list[Variable], place: int) -> None:
        result = self._result(place)
        for kind, chosen in _by_kind(one for one in variables if one.statistic in ("at", "curve")):
            times = _times_of(chosen)
            self._store(chosen, [place], result.functions(kind)(times)[None], times)
        for kind, chosen in _by_kind(one for one in variables if one.statistic == "RMS"):
            rows = sorted({one.curve[1] for one in chosen})
            self._store_rms(chosen, place, rows, result.rms(kind, rows))
        for kind, chosen in _by_kind(one for one in variables if one.statistic in EXTREMA):
            rows = sorted({one.curve[1] for one in chosen})
            self._store_extrema(chosen, place, rows, result.extrema(kind, rows))

    def _store_extrema(self, variables: list[Variable], place: int, rows: list[int], extremes: Extrema) -> None:
        for one in variables:
            row = rows.index(one.curve[1])
            if extremes.margin[row] > KEPT_MARGIN * extremes.largest[row]:
                raise InputError(
                    f'"{one.name}": the motion has too many periods to search them all; choose an earlier end in [time]'
                )
            self.values[one.name][place] = getattr(extremes, EXTREMA[one.statistic])[row]

    def _store_rms(self, variables: list[Variable], place: int, rows: list[int], rms: RootMeanSquares) -> None:
        largest = rms.values.max(initial=0.0)
        for one in variables:
            value, error = (getattr(rms, name)[rows.index(one.curve[1])] for name in ("values", "error_estimate"))
            if error > KEPT_MARGIN * value and error > PROVED_ACCURACY * largest:  # next to others it may be a rounding error
                raise InputError(f'"{one.name}": the motion has too many periods for its RMS; choose an earlier end in [time]')
            self.values[one.name][place] = value

    def _store(self, variables: list[Variable], group: list[int], values: np.ndarray, times: np.ndarray) -> None:
        """Store values at times, shape (S, rows, T), which include those of each variable."""
        for one in variables:
            own = values[:, one.curve[1]][:, np.searchsorted(times, one.labels if one.statistic == "curve" else one.time)]
            self.values[one.name][group] = own

    def _systems(self, group: list[int]) -> list[MechanicalSystem]:
        return [self.scenes[place].equations.system for place in group]


#: Extrema are those of the closed form, none between the times is missed; "peak" is an older word for largest.
EXTREMA = {"largest": "largest", "maximum": "maximum", "minimum": "minimum", "peak": "largest"}

#: A sample of a motion of so many periods that its extremum may be wrong by this part has no answer.
KEPT_MARGIN = 1e-6


def _times_of(variables: Iterable[Variable]) -> np.ndarray:
    """All times of values and curves, ascending."""
    return np.unique([time for one in variables for time in (one.labels if one.statistic == "curve" else (one.time,))])


def _by_kind(variables: Iterable[Variable]) -> Iterator[tuple[str, list[Variable]]]:
    """The variables of each kind of curve."""
    chosen = list(variables)
    for kind in dict.fromkeys(one.curve[0] for one in chosen):
        yield kind, [one for one in chosen if one.curve[0] == kind]


def _have_similar_systems(one: Scene, other: Scene) -> bool:
    """Whether two scenes have systems of arrays that differ only in matrices."""
    first, second = one.equations.system, other.equations.system
    if type(first) is not type(second) or first is None or first.is_sparse or second.is_sparse or first.names != second.names:
        return False
    if type(first) is not MechanicalSystem and not (isinstance(first, LinearizedRobot) and not first.rows):
        return False
    if any(scene.equations.rotor is not None or scene.equations.control for scene in (one, other)):
        return False
    rows = list(zip(first.rows, second.rows))
    return len(first.rows) == len(second.rows) and all(
        a.level == b.level and a.value == b.value and np.array_equal(a.coefficients, b.coefficients) for a, b in rows
    )


def _alike(one: Scene, other: Scene) -> bool:
    """Whether two scenes have systems of arrays that differ only in matrices, values at 0- and static forces."""
    if type(one.equations.system) is not MechanicalSystem or not _have_similar_systems(one, other):
        return False
    if any(
        scene.equations.ends or scene.equations.switching for scene in (one, other)
    ):  # inputs, or events, depend on the matrices
        return False
    tables = (one.table.force, one.table.motion, one.table.random, one.table.time)
    return tables == (other.table.force, other.table.motion, other.table.random, other.table.time)


def _have_alike_responses(one: Scene, other: Scene) -> bool:
    """Whether the responses of two scenes have the same range, inputs and outputs."""
    return one.table.frequency == other.table.frequency and one.table.output == other.table.output and _alike(one, other)


# --- samples whose parameters are numbers of the elements of a lumped model: matrices in stacks, without a scene for each


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
