"""A run in discrete time: the samples of a scene whose [time] has step_domain = "discrete"; nothing is said between samples."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..control.discrete_time import DiscreteStateSpaceResponse
from ..control.state_space import StateSpace
from ..exchange.trajectories import csv_of
from ..ground.checks import counted, listed
from ..ground.display import TextTable, number_text
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind, distinct, doubts_of
from ..ground.tolerances import EPS, SAME_HOLD
from ..mechanics.constraints import with_right_sides
from ..page.animation import MOST_FRAMES, MOST_POSES, Animation
from ..page.content import Curve, Marks, Plot
from ..response.discrete import DiscreteResponse, discrete_force, from_start
from ..scene.build.model import Equations
from ..scene.coordinates import Coordinates
from ..scene.file import at
from ..scene.run.drawing import drawing_of
from ..scene.run.result import start_notices
from ..signals.impulsive import ImpulsiveSmooth
from ..signals.inputs import power, zero
from .base import Answer
from .run import RunAnswer

if TYPE_CHECKING:
    from ..scene.build.robot_model import RobotScene

#: The part of a step in which the animation shows a sample; then it jumps to the next one.
SHOWN_PART = 0.98

#: Parts of a step at which a pose of a robot is repeated, and most samples of a robot that are shown.
POSE_PARTS, MOST_SAMPLED_POSES = (0.0, 0.02, 0.04, 0.94, 0.96, 0.98), 500


class DiscreteRunAnswer(RunAnswer):
    """The samples of a scene at k = 0, 1, ...: of difference equations, or of a discretized continuous model."""

    @property
    def heading(self) -> str:
        """Title, source, coordinates and samples."""
        return self._headed(self._called, self._coordinates, self._samples_text)

    @property
    def _called(self) -> str:
        equations = self.scene.equations
        has_outputs_alone = self._coordinates is not equations.coordinates and self._further_outputs is None
        return "outputs" if has_outputs_alone else equations.coordinates_called

    @property
    def _samples_text(self) -> str:
        k, time = self.numbers, self.scene.table.time
        return f"samples k = {k[0]} to {k[-1]}, step {time.step:g} s"

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """The model, how it became discrete, and its samples."""
        return (
            *self.scene.equations.facts,
            (self._called, self._coordinates.listed),
            ("discrete time", self.domain_text),
            ("samples", f"{self._samples_text}, in closed form"),
        )

    @property
    def domain_text(self) -> str:
        """Text on the origin of the discrete equations."""
        if self.scene.equations.are_bare:
            return f"difference equations, sigma the shift by one sample, degree {self.scene.equations.polynomial_matrix.degree}"
        hold = self.scene.table.time.hold
        return f"discretized exactly, forces {'linear' if hold else 'constant'} between samples (hold = {hold})"

    @cached_property
    def numbers(self) -> np.ndarray:
        """The numbers k of the samples, shape (T,)."""
        time = self.scene.table.time
        return np.arange(time.points) + round(time.start / time.step)

    @cached_property
    def times(self) -> np.ndarray:
        """The times of the samples in s, k step."""
        return self.numbers * self.scene.table.time.step

    @cached_property
    def _coordinates(self) -> Coordinates:
        """Names and units of the samples."""
        equations, control = self.scene.equations, self.scene.equations.control
        if control is None or equations.system is not None:
            own, outputs = equations.coordinates, self._further_outputs
            return own if outputs is None else replace(own, names=own.names + outputs.names, units=own.units + outputs.units)
        if control.system is None or control.outputs.names:
            return control.outputs
        return self.scene.equations.coordinates

    @property
    def _further_outputs(self) -> Coordinates | None:
        """Outputs next to the coordinates: of a robot, and of a state space in its normal form."""
        equations = self.scene.equations
        return equations.outputs if equations.robot_scene is not None or equations.original is not None else None

    @cached_property
    def sequence(self) -> DiscreteResponse | DiscreteStateSpaceResponse:
        """The sequence in closed form."""
        with at(self.scene.file_name, "time.step_domain"):
            time, equations = self.scene.table.time, self.scene.equations
            if self.scene.equations.are_bare:
                A = equations.polynomial_matrix
                force = zero(A.size) if equations.force is None else equations.force
                return from_start(
                    A, equations.initial, discrete_force(force, A.size, "force", time.step), is_given=bool(equations.initial.any())
                )
            if equations.original is not None:
                return _normal_form(equations, time.step, time.hold)
            if equations.system is not None:
                return _mechanical(equations, time.step, time.hold)
            return _control(equations, time.step, time.hold)

    @cached_property
    def values(self) -> np.ndarray:
        """The samples in SI, shape (n, T)."""
        x, equations = self.sequence, self.scene.equations
        values = x.output(self.numbers) if isinstance(x, DiscreteStateSpaceResponse) else x(self.numbers)
        is_robot = equations.robot_scene is not None and equations.outputs is not None
        return np.vstack([values, equations.output_values(self.times, values)]) if is_robot else values

    @cached_property
    def error_estimates(self) -> dict[str, float]:
        """The estimate of max |error| / max |value| over the samples."""
        return {"displacement": self.sequence.error_estimate(self.numbers)}

    @cached_property
    def _eigenvalues_z(self) -> np.ndarray:
        """The eigenvalues z of the difference equations, of complex pairs the one above the real axis."""
        x = self.sequence
        z = x.system.poles() if isinstance(x, DiscreteStateSpaceResponse) else self.scene.equations.polynomial_matrix.eigenvalues
        return z[z.imag >= 0]

    @cached_property
    def tables(self) -> tuple[TextTable, ...]:
        """Eigenvalues, and the largest samples."""
        rows = []
        h = self.scene.table.time.step
        for z in self._eigenvalues_z:
            hz = number_text(abs(np.angle(z)) / (2 * np.pi * h)) if z.imag or z.real < 0 else "–"
            change = "grows" if abs(z) > 1 + EPS**0.5 else "stays" if abs(z) > 1 - EPS**0.5 else "decays"
            rows.append((_complex_text(z), number_text(abs(z)), hz, change))
        shown = self._coordinates.shown
        largest = [
            (name, shown.text(row[k := int(np.abs(row).argmax())], unit, name), str(self.numbers[k]))
            for name, unit, row in zip(self._coordinates.names, self._coordinates.units, self.values)
        ]
        return (
            TextTable("Eigenvalues", ("z", "|z|", "frequency (Hz)", "per sample"), tuple(rows)),
            TextTable("Largest samples", ("name", "value", "k"), tuple(largest)),
        )

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        equations = self.scene.equations
        start = () if equations.are_bare or equations.has_outputs_among_coordinates else start_notices(equations)
        doubts = doubts_of("the samples", self.error_estimate)
        return distinct(self.scene.notices, start, self.sequence.notices, self._own_notices(), self._robot_notices, doubts)

    def _own_notices(self) -> Iterator[Notice]:
        """Frequencies above the Nyquist frequency, forces that differ from their hold, what is left out, and rest."""
        if isinstance(self.sequence, DiscreteStateSpaceResponse):
            yield from self._aliasing(self.sequence)
            yield from self._deviations(self.sequence)
        if self.scene.table.frequency is not None:
            text = "[frequency] is left out of a run in discrete time; the command frequency answers it for the continuous model"
            yield Notice(NoticeKind.OMITTED, text)
        if not np.ptp(self.values, axis=1).any():
            yield Notice(NoticeKind.AT_REST, "all samples are equal: the start is one of rest, and no force changes")

    @staticmethod
    def _aliasing(x: DiscreteStateSpaceResponse) -> Iterator[Notice]:
        """Whether the continuous model vibrates above the Nyquist frequency."""
        if x.system.origin is None:
            return
        nyquist = x.system.nyquist_hz
        poles = x.system.origin.system.polynomial_matrix().eigenvalues
        above = sorted({f"{hz:.4g}" for hz in np.abs(poles.imag) / (2 * np.pi) if hz > nyquist * (1 + EPS**0.5)}, key=float)
        if above:
            text = (
                f"the model vibrates at {listed(above)} Hz, above the Nyquist frequency of {number_text(nyquist)} Hz: the samples are "
                f"right, but look like those of a lower frequency (aliasing); a step below {0.5 / float(above[-1]):.3g} s shows it"
            )
            yield Notice(NoticeKind.ALIASING, text)

    def _deviations(self, x: DiscreteStateSpaceResponse) -> Iterator[Notice]:
        """Whether forces between samples differ from their hold."""
        u, time = _forces(self.scene.equations), self.scene.table.time
        ends = u(time.step * np.arange(self.numbers[-1] + 1))
        middle = u(time.step * (np.arange(self.numbers[-1]) + 0.5))
        by_hold = (ends[:, :-1] + ends[:, 1:]) / 2 if time.hold else ends[:, :-1]
        deviation = np.abs(middle - by_hold).max(axis=1, initial=0.0)
        size = np.maximum(np.abs(ends).max(axis=1), np.abs(middle).max(axis=1, initial=0.0))
        part = np.divide(deviation, size, out=np.zeros(len(size)), where=size > 0)
        if part.max(initial=0.0) > SAME_HOLD:
            text = (
                f"{x.system.inputs[int(part.argmax())]}: between samples the given signal is up to {100 * part.max():.3g} % of its largest "
                f"value off its hold (hold = {time.hold}); the samples are those of the hold, a smaller step brings them nearer"
            )
            yield Notice(NoticeKind.ALIASING, text)

    @property
    def _robot_notices(self) -> tuple[Notice, ...]:
        """Notices on the range of a robot's joints and of its linear equations."""
        robot_scene = self.scene.equations.robot_scene
        if robot_scene is None:
            return ()
        from ..scene.build.robot_model import limit_notices

        joints = self.values[: len(self.scene.equations.coordinates.names)]
        limits = limit_notices(robot_scene, np.column_stack([joints.min(axis=1), joints.max(axis=1)]))
        return (*(self.linear_range.notices if self.linear_range else ()), *limits)

    @property
    def table_notices(self) -> tuple[Notice, ...]:
        return self.notices

    @property
    def data(self) -> dict[str, Any]:
        return {
            "source": self.source,
            "step_domain": "discrete",
            "step": self.scene.table.time.step,
            "hold": None if self.scene.equations.are_bare else self.scene.table.time.hold,
            "coordinates": self._coordinates.to_list(),
            "eigenvalues": [{"real": z.real, "imaginary": z.imag, "modulus": abs(z)} for z in self._eigenvalues_z],
            "samples": self.numbers,
            "final": self.values[:, -1],
            "error_estimate": self.error_estimate,
        }

    def _summary(self) -> str:
        return f"{self.name}: {counted(len(self._coordinates.names), 'coordinate')} at {counted(len(self.numbers), 'sample')}"

    def plots(self) -> Iterable[Plot]:
        """The samples as points over k, one plot for each unit; no line joins them."""
        wanted, coordinates = self.scene.table.output.coordinates, self._coordinates
        outputs = len(self._further_outputs.names) if self._further_outputs else 0
        plotted, own = self.scene.table.output.plots, len(coordinates.names) - outputs
        chosen = [i for i, name in enumerate(coordinates.names[:own]) if wanted is None or name in wanted]
        parts = [("", chosen)] if "displacement" in plotted or not outputs else []
        parts += [("output", list(range(own, own + outputs)))] if outputs and "output" in plotted else []
        for title, rows in parts:
            for unit, shown in dict.fromkeys((coordinates.units[i], self._units[i]) for i in rows):
                chosen = [i for i in rows if (coordinates.units[i], self._units[i]) == (unit, shown)]
                yield self._plot(chosen, unit, shown, title)

    @property
    def _units(self) -> list[tuple[str, float]]:
        """The units shown of the values, each with its factor."""
        return list(map(self._coordinates.shown.of, self._coordinates.units, self._coordinates.names))

    def _plot(self, rows: list[int], unit: str, in_unit: tuple[str, float], title: str = "") -> Plot:
        shown, factor = in_unit
        hidden, curves, marks = np.zeros(len(self.numbers), dtype=bool), [], []
        for number, i in enumerate(rows):
            values, name = factor * self.values[i], self._coordinates.names[i]
            texts = tuple(f"{name}, k = {k}: {number_text(value)} {shown}" for k, value in zip(self.numbers, values))
            curves.append(Curve(name, values, drawn=hidden))
            marks.append(Marks("", np.column_stack([self.numbers, values]), texts, curve=number))
        title = title or ("output" if self._called == "outputs" else "displacement" if unit == "m" else "samples")
        return Plot(
            f"{title}, sample by sample",
            shown,
            self.numbers.astype(float),
            tuple(curves),
            across_unit="",
            quantity=title,
            variable="sample k",
            marks=tuple(marks),
            note=f"Points are the values at k, a time of k times {self.scene.table.time.step:g} s; there are none between them.",
        )

    @cached_property
    def animation(self) -> Animation:
        """The model at rest at each sample until the next one, to which it jumps."""
        scene, h = self.scene, self.scene.table.time.step
        if scene.equations.robot_scene is not None:
            return self._robot_animation(scene.equations.robot_scene)
        table, count = scene.table.drawing, max(1, MOST_FRAMES // 2)
        scales = {key: getattr(table, key) for key in ("scale", "turn_scale") if table and key in table.model_fields_set}
        values, times = self.values[:, :count], self.times[:count]
        frames = np.repeat(values, 2, axis=1)
        moments = np.column_stack([times, times + SHOWN_PART * h]).ravel()
        return Animation(drawing_of(scene, self.values, **scales), self._coordinates.names, moments, frames, 0.0 * frames)

    def _robot_animation(self, robot_scene: RobotScene) -> Animation:
        """The poses of a robot, loops closed; the page takes rates of poses from five neighbours, which agree but next to the jumps."""
        from ..scene.run.drawing import RobotPicture, drawing_of_robot

        picture, parts = RobotPicture(robot_scene, self.scene.table.drawing), np.array(POSE_PARTS)
        moving, names = max(1, len(picture.solids)), self.scene.equations.coordinates.names
        count = max(1, min(MOST_SAMPLED_POSES, MOST_POSES // (moving * len(parts))))
        values = np.repeat(self.values[: len(names), :count], len(parts), axis=1)
        moments = np.add.outer(self.times[:count], parts * self.scene.table.time.step).ravel()
        drawing = drawing_of_robot(picture, values, self.scene.table.drawing)
        return Animation(drawing, names, moments, values, 0.0 * values)

    def arrays(self) -> dict[str, np.ndarray]:
        """Sample numbers, times, names and values in SI, for NumPy; the matrices of a discretized model."""
        x = self.sequence
        arrays = {
            "samples": self.numbers,
            "times": self.times,
            "coordinates": np.array(self._coordinates.names),
            "values": self.values,
        }
        return arrays | ({name: getattr(x.system, name) for name in "ABCD"} if isinstance(x, DiscreteStateSpaceResponse) else {})

    def columns(self) -> dict[str, dict[str, np.ndarray]]:
        """Sample number, time, and values in the units of [output], as in the CSV file."""
        units = self._units
        values = {
            f"{name} ({unit})": factor * row for name, (unit, factor), row in zip(self._coordinates.names, units, self.values)
        }
        return {"": {"k": self.numbers, "time (s)": self.times, **values}}

    def write_csv(self, path: str | Path | None = None) -> Path:
        """Write the samples as CSV, one line for each k."""
        return self._written("csv", path, lambda path: path.write_text(csv_of(self.columns()[""]), encoding="utf-8"))

    def to_xarray(self):
        """The samples over k, as an ``xarray.Dataset`` with units."""
        return Answer.to_xarray(self)

    def write(self, path, formats=None, **options):
        """Write the samples, as ``Answer.write``; a path with the ending .csv or .npz names one file."""
        ending = Path(path).suffix.lower()
        if formats is not None:
            return Answer.write(self, path, formats)
        if ending not in (".csv", ".npz"):
            raise InputError(f"{path}: samples are written as .csv or .npz")
        return self.write_csv(path) if ending == ".csv" else self.write_npz(path)


def _mechanical(equations: Equations, h: float, hold: int) -> DiscreteStateSpaceResponse:
    """Displacements under all forces and prescribed motions, with a hold between samples."""
    system = equations.system
    rows = [f"value of {row.name}" for row in system.rows]
    forces = [f"force on {name}" for name in system.names]
    space = system.to_state_space([*forces, *rows], list(system.names))
    n = system.size
    start = np.zeros(len(space.A))
    start[: 2 * n] = np.concatenate([equations.initial[0], equations.initial[1]])
    return space.discretize(h, hold).solve(start, _forces(equations))


def _normal_form(equations: Equations, h: float, hold: int) -> DiscreteStateSpaceResponse:
    """Coordinates of a mechanical normal form, then the outputs of the state space, under a hold of its inputs."""
    control, coordinates = equations.original, equations.coordinates.names
    own, size = control.form.state_space(), control.form.size
    C = np.eye(len(own.A))[[*range(size), *range(2 * size, len(own.A))]]
    D = np.zeros((len(C), len(own.inputs)))
    if control.outputs.names:
        C, D = np.vstack([C, own.C]), np.vstack([D, own.D])
    names = {"inputs": control.inputs.names, "outputs": [*coordinates, *control.outputs.names]}
    states = [f"state {name} of the normal form" for name in own.states]  # its own names may be those of outputs
    space = StateSpace(own.A, own.B, C, D, own.E if own.is_descriptor else None, states=states, **names)
    return space.discretize(h, hold, delays=control.delays).solve(control.form.coordinates(control.start), control.input)


def _control(equations: Equations, h: float, hold: int) -> DiscreteStateSpaceResponse:
    """Outputs, or else states, of a transfer function or state space under a hold of its input."""
    control = equations.control
    if control.transfer_function is None:
        given = control.system
        names = {"inputs": given.inputs, "outputs": control.outputs.names or [f"sample of {name}" for name in given.states]}
        C, D = (given.C, given.D) if control.outputs.names else (np.eye(len(given.A)), None)
        space = StateSpace(given.A, given.B, C, D, given.E if given.is_descriptor else None, states=given.states, **names)
        return space.discretize(h, hold, delays=control.delays).solve(control.start, _forces(equations))
    own = control.transfer_function
    if own.start is not None:
        raise InputError("a transfer function in discrete time starts from rest; give a state space for other starts")
    space = StateSpace.from_transfer_function(own.numerator, own.denominator, inputs=control.inputs.names)
    return space.discretize(h, hold, delays=control.delays).solve(input=_forces(equations))


def _forces(equations: Equations) -> ImpulsiveSmooth:
    """The inputs of the continuous model: forces and values of constraint rows, or those of a state space or transfer function."""
    system = equations.system
    if system is not None and equations.original is None:
        return with_right_sides(system.force if equations.force is None else system.force + equations.force, system.rows)
    own = equations.control.transfer_function
    if own is None:
        return equations.control.input
    return power([1.0], own.input) if isinstance(own.input, int) else own.input


def _complex_text(z: complex) -> str:
    return f"{z.real:.4g}" if not z.imag else f"{z.real:.4g} ± {z.imag:.4g} i"
