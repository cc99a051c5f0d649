"""The result of a scene, whose parts are computed at their first use; the plan lists them."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cached_property
from operator import methodcaller
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...exchange.trajectories import write_arrays, write_csv, write_trajectories
from ...ground.checks import counted
from ...ground.display import Displayed, TextTable
from ...ground.errors import InputError, MbconstrainedError
from ...ground.files import Replacements
from ...ground.notices import Notice, NoticeKind, distinct, doubts_of
from ...response.estimate import error_estimate
from ...response.response_notices import without_kinks
from .aliasing import aliasing_notices, following_times
from .curves import ORDERS, PARTS, Curves, curves_of, extrema_of, in_units, time_functions
from .decisions import connection_forces, still, too_large_for_formula
from .plan import Plan
from .report.force_report import forces_notices
from .report.jumps import ReportedImpulse, ReportedJump, forces_of_rows, impulses_of, jumps_of, with_units
from .report.robot_report import limit_notices
from .report.tables import notices_of, tables_of
from .scene_data import SceneData

if TYPE_CHECKING:
    from ...analyses.frequency import Frequency
    from ...exact.formulas.closed_form import ClosedForm
    from ...exchange.universal import Geometry
    from ...frequency.shock.extrema import Extrema
    from ...mechanics.modes import Modes
    from ...mechanics.motion import Motion
    from ...mechanics.system import MechanicalSystem
    from ...page.animation.animation import Animation
    from ...page.content import Formulas, RecordResponse, TimeFunctions
    from ...polynomial.jordan_pairs import FinitePair, InfinitePair
    from ...response.events import Event
    from ...robot.linearization.linear_range import LinearRange
    from ...signals.impulsive import ImpulsiveLoad
    from .certificate import Certificate

NOTHING_MOVES = "nothing moves: zero initial conditions and no excitation"


class Result(Displayed):
    """The answer to a scene.

    Attributes:
        scene: the scene that was run.
        plan: its stages with their costs.
        files: written files, in this order.
        system: mass, damping, stiffness and constraint rows; None where A(s) was given itself.
        times: times of the scene, shape (T,), in s.
    """

    def __init__(self, scene: SceneData, plan: Plan, folder: Path | None = None):
        self.scene = scene
        self.system: MechanicalSystem | None = scene.equations.system
        self.plan = plan
        self.folder = folder
        self.files: list[Path] = []
        self.still_problem = ""
        self._together: Replacements | None = None
        self.formula_problem = ""
        self._curves: dict[str, Curves] = {}
        self._extrema: dict[str, Extrema] = {}
        self._functions: dict[str, TimeFunctions] = {}

    def _summary(self) -> str:
        names = self.scene.equations.coordinates.names
        return f"{self.scene.name}: {counted(len(names), 'coordinate')} at {counted(len(self.times), 'time')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return self.tables

    @cached_property
    def finite_pair(self) -> FinitePair:
        """(C, J, B) of the finite zeros."""
        return self.scene.equations.polynomial_matrix.jordan_pairs().finite

    @cached_property
    def infinite_pair(self) -> InfinitePair:
        """(C, J, B) of the zeros at infinity."""
        return self.scene.equations.polynomial_matrix.jordan_pairs().infinite

    @cached_property
    def times(self) -> np.ndarray:
        """Times of the scene; without a given number, enough for the fastest visible motion."""
        return following_times(self) if self.scene.table.time.is_automatic else self.scene.times

    @cached_property
    def motion(self) -> Motion | Any:
        """x as a function of time, with jumps and impulses; a Motion where there is a mechanical system."""
        return self.scene.equations.solve()

    @property
    def values(self) -> np.ndarray:
        """The coordinates at the times, shape (r, T)."""
        return self.curves("displacement").values

    def curves(self, kind: str) -> Curves:
        """Trajectories of a kind: displacement, velocity, acceleration, reaction, energy or output."""
        if kind not in self._curves:
            self._curves[kind] = curves_of(self, kind)
        return self._curves[kind]

    def extrema(self, kind: str) -> Extrema:
        """The largest and the smallest values of a kind of curves with their times, exact ones between the times of the scene, too."""
        if kind not in self._extrema:
            self._extrema[kind] = extrema_of(self, kind)
        return self._extrema[kind]

    def shown_curves(self, kind: str) -> Curves:
        """Curves in the units of [output], for page and CSV."""
        return in_units(self.curves(kind), self.scene.equations.coordinates.shown)

    def time_functions(self, kind: str) -> TimeFunctions:
        """Trajectories as stored in the page, as functions of time."""
        if kind not in self._functions:
            self._functions[kind] = time_functions(self, kind)
        return self._functions[kind]

    @cached_property
    def record_response(self) -> RecordResponse | None:
        """The motion from which the curves are computed, where a force restarts; at its knots all values up to the degree of A(s)."""
        from ...page.content import RecordResponse

        restarts, degree = self.motion.force.smooth.restarts, self.scene.equations.polynomial_matrix.degree
        views = [self.motion, *(self.motion.derivative(order) for order in range(1, degree))]
        states = lambda times: np.vstack([view(times) for view in views])  # noqa: E731
        return RecordResponse(restarts.knots, restarts.states, states) if len(restarts.knots) > 1 else None

    @property
    def kinds(self) -> list[str]:
        """The kinds of curves that the scene requests, the coordinates first."""
        output = self.scene.table.output
        plots = [part for kind in output.plots for part in (PARTS[kind] if kind == "phase" else (kind,))]
        requested = [
            "displacement",
            *plots,
            *(["reaction", "ground_reaction"] if output.reactions else []),
            *(["quantity"] if output.quantity else []),
        ]
        outputs = not self.scene.equations.has_outputs_among_coordinates
        available = {"reaction": self._has_rows, "ground_reaction": self.scene.equations.has_connections, "output": outputs}
        return [kind for kind in dict.fromkeys(requested) if available.get(kind, True)]

    @property
    def _has_rows(self) -> bool:
        return self.system is not None and bool(self.system.rows)

    @cached_property
    def jumps(self) -> list[ReportedJump]:
        """The jumps of the coordinates at t = 0."""
        return jumps_of(self.motion, self.scene.equations.coordinates)

    @cached_property
    def impulses(self) -> list[ReportedImpulse]:
        """The impulses at t = 0 in the coordinates, then in the constraint forces."""
        impulses = impulses_of(self.motion.impulses, self.scene.equations.coordinates)
        return impulses + (
            impulses_of(self.motion.constraint_impulses, forces_of_rows(self.system, shown=self.scene.equations.coordinates.shown))
            if self._has_rows
            else []
        )

    @cached_property
    def later(self) -> list[Event | ImpulsiveLoad]:
        """The events of the motion, except kinks, and the impulses of its constraint forces after t = 0, by time."""
        events = [*without_kinks(self.motion), *getattr(self.motion, "later_constraint_impulses", ())]
        return sorted(events, key=lambda event: event.time)

    @cached_property
    def tables(self) -> tuple[TextTable, ...]:
        """The tables of the summary and of the page."""
        return tables_of(self)

    @cached_property
    def table_notices(self) -> tuple[Notice, ...]:
        """The notices of the summary and of the page, in which tables contain the jumps and impulses."""
        return notices_of(self)

    @cached_property
    def modes(self) -> Modes:
        """The finite zeros of the mechanical system with their meaning."""
        return self.system.modes()

    @property
    def error_estimate(self) -> float:
        """Estimate of max |error| / max |x| over the times."""
        return self.error_estimates["displacement"]

    @cached_property
    def error_estimates(self) -> dict[str, float]:
        """Error estimates of each requested kind of curve; energies depend on x and x', outputs of a robot on x."""
        watched = ["ground_reaction"] if connection_forces(self.scene)[0] else []
        parts = (part for kind in (*self.kinds, *watched) for part in PARTS.get(kind, (kind,)))
        kinds = [kind for kind in dict.fromkeys(parts) if kind != "reaction" or self._has_rows]
        views = {kind: methodcaller("derivative", order) for kind, order in ORDERS.items()}
        views["reaction"] = getattr(self.motion, "reaction_of", None)
        estimates = {kind: error_estimate(self.motion, self.times, views[kind]) for kind in kinds}
        if "output" in self.kinds and self.scene.equations.control:
            estimates["output"] = self.scene.equations.control.response.output_error_estimate(self.times)
        return estimates

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on the answer, and doubts about it."""
        notices = self.motion.equation_notices if self.system else with_units(self.motion, self.scene.equations.coordinates)
        robot_scene = self.scene.equations.robot_scene
        limits = (*limit_notices(robot_scene, self._furthest), *forces_notices(self)) if robot_scene else ()
        robot = (*(self.linear_range.notices if self.linear_range else ()), *limits)
        accuracy = (one for kind, estimate in self.error_estimates.items() for one in doubts_of(f"the {kind}", estimate))
        proved = self.certificate.notices if self.certificate else ()
        moves = np.ptp(self.values, axis=1).any() or any(notice.kind in (NoticeKind.JUMP, NoticeKind.IMPULSE) for notice in notices)
        first = (*self.scene.notices, *self._omissions(), *proved, *(self.frequency.response.notices if self.frequency else ()))
        of_motion = (*(() if moves else (Notice(NoticeKind.AT_REST, NOTHING_MOVES),)), *aliasing_notices(self))
        return distinct(first, self.scene.equations.form_notices, notices, of_motion, robot, accuracy)

    @cached_property
    def linear_range(self) -> LinearRange | None:
        """Linear range of the motion of a robot; None for other models."""
        robot_scene = self.scene.equations.robot_scene
        return robot_scene.system.linear_range(self.motion, self.times) if robot_scene else None

    @property
    def _furthest(self) -> np.ndarray:
        """The smallest and the largest displacement of each coordinate, shape (r, 2)."""
        ends = self.extrema("displacement")
        return np.column_stack([ends.minimum, ends.maximum])

    def _omissions(self) -> list[Notice]:
        """The reasons why the page lacks a requested formula, and why a requested still picture is missing."""
        output, texts = self.scene.table.output, []
        if output.formula and output.page and (reason := too_large_for_formula(self.scene) or self.formula_problem):
            texts.append(f"the formula is left out: {reason}")
        if output.still is not None:
            available, reason = still(self.scene)
            problem = self.still_problem if available else f"left out: {reason}"
            texts += [f"still picture: {problem.removeprefix('still picture: ')}"] if problem else []
        return [Notice(NoticeKind.OMITTED, text) for text in texts]

    @property
    def is_trusted(self) -> bool:
        """False where a notice states that the answer may be wrong."""
        return not any(notice.doubtful for notice in self.notices)

    @cached_property
    def animation(self) -> Animation:
        """The drawing of the model with its motion."""
        from .picture.result_animation import animation_of

        return animation_of(self)

    @cached_property
    def certificate(self) -> Certificate | None:
        """The proved digits; None where not requested."""
        if not self.scene.table.output.certify:
            return None
        from .certificate import certificate_of

        return certificate_of(self)

    @cached_property
    def formula(self) -> ClosedForm | None:
        """The formula of each coordinate; None, with a notice, where there is none."""
        from .formula import PAGE_SECONDS, formula_of

        control = self.scene.equations.control
        wanted = None if control and control.form else self.scene.table.output.coordinates  # of a normal form: its states
        try:
            return formula_of(self.scene, coordinates=wanted, seconds=PAGE_SECONDS)
        except InputError as problem:
            self.formula_problem = str(problem)
            return None

    @cached_property
    def frequency(self) -> Frequency | None:
        """The frequency response; None where the scene has no [frequency]."""
        if self.scene.table.frequency is None:
            return None
        from ...analyses.frequency import Frequency

        return Frequency(self.scene)

    @property
    def peak_tables(self) -> tuple[TextTable, ...]:
        """The peaks of the frequency response; none without it."""
        return (self.frequency.peak_table(),) if self.frequency else ()

    def write_frequency(self) -> list[Path]:
        """Write the page, CSV and npz of the frequency response into the folder of the run, as far as [output] requests them."""
        from ...analyses.base import formats_of

        output = self.scene.table.output
        with self.writing_together() as files:
            written = self.frequency.to_answer().write(self.folder or Path(), formats_of(output), output.viewer, files)
        self.files += written
        return written

    @property
    def formulas(self) -> Formulas | None:
        """The section of the page with the formula; None where there is none."""
        if not self.scene.table.output.formula or self.formula is None:
            return None
        from .formula import formulas_on_page

        return formulas_on_page(self.formula)

    def summary(self) -> str:
        """The answer in words and tables, as it is printed."""
        from .report.summary import summary

        return summary(self)

    def as_json(self) -> dict:

        from .report.summary import as_json

        return as_json(self)

    def write_page(self, path: str | Path | None = None) -> Path:
        """Write the page, with the viewer's script next to it where [output] viewer requests that.

        Args:
            path: path of the page; None for the folder of the run, named after the scene.

        Returns:
            The path written.
        """
        from ...page.html import write_page
        from .report.page_report import page_content

        content, viewer = page_content(self), self.scene.table.output.viewer
        with self.writing_together() as files:
            count = len(files.paths)
            page = write_page(self._prepared("html", path), content, viewer, files)
            self.files += files.paths[count:]
        return page

    def write_csv(self, path: str | Path | None = None) -> Path:
        """Write the curves as CSV, one line for each time, in the units of [output]; the path is that of ``write_page``."""
        return self._written("csv", path, lambda path: write_csv(path, self.times, self._all_shown_curves))

    def write_npz(self, path: str | Path | None = None) -> Path:
        """Write curves, jumps, impulses and the Jordan pairs as NumPy arrays; the path is that of ``write_page``."""
        return self._written("npz", path, lambda path: write_arrays(path, arrays_of_result(self), ".npz"))

    def write(self, path: str | Path, *, excel: bool = False, geometry: Geometry | None = None, binary: bool = True) -> Path:
        """Write the curves in the format that the ending of the path names: .csv, .npz, .mat, .nc, .zarr, .uff or .unv.

        Args:
            path: path of the file.
            excel, geometry, binary: as in ``Motion.write``.

        Returns:
            The path.

        Raises:
            InputError: another ending, or an option of another format.
            MissingPackage: xarray for .nc, xarray and zarr for .zarr, pyuff for universal files.
        """
        if Path(path).suffix.lower() == ".npz":
            return self.write_npz(path)
        arrays = more_arrays(self)
        curves = self._all_shown_curves if Path(path).suffix.lower() == ".csv" else self._all_curves
        with self.writing_together() as files:
            path = write_trajectories(path, self.times, curves, arrays, excel=excel, geometry=geometry, binary=binary, files=files)
        self.files.append(path)
        return path

    def write_formats(self) -> list[Path]:
        """Write the files that [output] formats requests, next to the others."""
        names = {"excel": ".excel.csv", "mat": ".mat", "netcdf": ".nc", "zarr": ".zarr", "uff": ".uff"}
        formats = self.scene.table.output.formats
        paths = {kind: (self.folder or Path()) / f"{self.scene.name}{names[kind]}" for kind in formats}
        return [self.write(path, excel=kind == "excel") for kind, path in paths.items()]

    @property
    def _all_curves(self) -> list[Curves]:
        return [self.curves(kind) for kind in self.kinds]

    @property
    def _all_shown_curves(self) -> list[Curves]:
        return [self.shown_curves(kind) for kind in self.kinds]

    def write_plots(self, folder: str | Path | None = None) -> list[Path]:
        """Write each plot of the page as SVG and PNG, named after scene and plot; by default into the folder of the run."""
        from ...page.plots.images import plot_image, plot_images
        from .report.page_report import plots_of

        folder = Path(folder) if folder is not None else self.folder or Path()
        with self.writing_together():
            return [
                self._written(kind, folder / f"{self.scene.name}.{name}.{kind}", _of_bytes(plot_image(plot, kind)))
                for name, plot in plot_images(plots_of(self)).items()
                for kind in ("svg", "png")
            ]

    def write_still(self, path: str | Path | None = None, time: float | None = None) -> Path:
        """Write a picture of the model at a time as PNG, taken by an installed Chromium or Chrome.

        Args:
            path: path of the picture; None for the folder of the run, named after the scene.
            time: in s; None for the one in [output] still, or 0.

        Returns:
            The path written.

        Raises:
            InputError: a time that is not within the run.
            MbconstrainedError: no browser is installed, or it takes no picture.
        """
        from ...page.photograph import photograph

        time = time if time is not None else self.scene.table.output.still or 0.0
        return self._written("still.png", path, _of_bytes(photograph(self.animation, time)))

    def try_still(self) -> None:
        """Write the still picture; if the browser fails, a notice has the reason and all else is written."""
        try:
            self.write_still()
        except MbconstrainedError as problem:
            self.still_problem = str(problem)

    def _written(self, ending: str, path, write) -> Path:
        path = self._prepared(ending, path)
        with self.writing_together() as files:
            write(files.temporary(path))
        self.files.append(path)
        return path

    def _prepared(self, ending: str, path) -> Path:
        """The path of a file, in a folder that exists."""
        path = Path(path) if path is not None else (self.folder or Path()) / f"{self.scene.name}.{ending}"
        path.parent.mkdir(parents=True, exist_ok=True)
        return path

    @contextmanager
    def writing_together(self) -> Iterator[Replacements]:
        """A context in which written files replace their targets at the end of the outermost block, all or none."""
        if self._together is not None:
            yield self._together
            return
        try:
            with Replacements() as self._together:
                yield self._together
        finally:
            self._together = None


def _of_bytes(content: bytes):
    return lambda path: path.write_bytes(content)


# The arrays of a result, for NumPy, MATLAB, netCDF and Zarr.


def arrays_of_result(result: Result) -> dict[str, np.ndarray]:
    """Times, names, curves, start, jump, impulses, events, finite and infinite pair."""
    arrays = {"times": result.times, "coordinates": np.array(result.scene.equations.coordinates.names)}
    for kind in result.kinds:
        arrays[kind] = result.curves(kind).values
    return arrays | more_arrays(result)


def more_arrays(result: Result) -> dict[str, np.ndarray]:
    """Further arrays of ``arrays_of_result``: all that are not curves."""
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
