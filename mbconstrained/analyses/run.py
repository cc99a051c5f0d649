"""A run: the motion of a scene over its times, with tables, plots, notices, evidence, plan and files."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..exchange.trajectories import Curves, dataset_of, write_arrays, write_csv, write_trajectories
from ..ground.checks import counted
from ..ground.display import WIDTH, TextTable, table_text, wrapped
from ..ground.errors import InputError, MbconstrainedError
from ..ground.files import Replacements
from ..ground.notices import Notice, NoticeKind, distinct, doubts_of
from ..response.response_notices import counts
from ..scene.run.plan import Plan
from ..scene.run.result import Result, aliasing_notices, folded, with_units
from ..scene.run.scene import Scene
from ..scene.run.stages import is_animated, still, too_large_for_formula
from .base import Answer, formats_of, write_pictures
from .motion_report import LARGEST, tables_of

if TYPE_CHECKING:
    from ..exact.closed_form import ClosedForm
    from ..exchange.universal import Geometry
    from ..page.animation import Animation
    from ..page.content import Formulas, PageContent, Plot
    from ..scene.coordinates import Coordinates
    from ..scene.run.certificate import Certificate
    from .frequency import Frequency

NOTHING_MOVES = "nothing moves: zero initial conditions and no excitation"

#: Endings of the files of [output] formats.
FORMATS = {"excel": ".excel.csv", "mat": ".mat", "netcdf": ".nc", "zarr": ".zarr", "uff": ".uff"}


class RunAnswer(Result, Answer):
    """The answer to a scene, whose parts are computed at their first use; the plan lists them."""

    kind = ""

    def __init__(self, scene: Scene, plan: Plan, folder: Path | None = None):
        Result.__init__(self, scene)
        vars(self).update(title=scene.title, source=scene.table.source)  # of a frozen dataclass
        if not scene.table.output.certify:
            self.certificate = None
        if scene.table.frequency is None:
            self.frequency = None
        self.plan = plan  # the stages with their costs
        self.folder = folder  # of the files
        self.files: list[Path] = []  # written files, in this order
        self.still_problem = self.formula_problem = ""
        self._together: Replacements | None = None

    def __getitem__(self, name: str) -> Any:
        names = self.scene.equations.coordinates.names
        return self.values[names.index(name)] if name in names else super().__getitem__(name)

    def _entries(self) -> Iterable[str]:
        return (*self.scene.equations.coordinates.names, *self.data)

    @property
    def name(self) -> str:
        return self.scene.name

    @property
    def heading(self) -> str:
        """Heading of the summary: the model, its coordinates and times."""
        equations = self.scene.equations
        events = f", {counted(len(self.motion.events), 'event')}" if self.is_switched else ""
        return self._headed(equations.coordinates_called, equations.coordinates, f"t from {self.scene.table.time.text}{events}")

    def _headed(self, what: str, coordinates: Coordinates, times: str) -> str:
        """Title and source above the coordinates and their times."""
        lines = [self.title, self.source, f"{what[0].upper()}{what[1:]}: {coordinates.listed}; {times}"]
        return "\n".join(line for line in lines if line)

    @property
    def facts(self) -> tuple[tuple[str, str], ...]:
        """The model, its coordinates and the times, for the page."""
        equations, time = self.scene.equations, self.scene.table.time
        delayed = self.system is not None and self.system.delayed
        count = "infinitely many, with delays" if delayed else equations.polynomial_matrix.eigenvalue_count
        return (
            *equations.facts,
            (equations.coordinates_called, equations.coordinates.listed),
            ("degree of the equations", str(equations.polynomial_matrix.degree)),
            ("eigenvalues" if self.system else "zeros", str(count)),
            ("time", f"{time.text}, {len(self.times)} points, in closed form"),
            *(self._phase_facts() if self.is_switched else ()),
        )

    def _phase_facts(self) -> list[tuple[str, str]]:
        """The phase of the listed modes, and the number of phases and events."""
        phases, switching = counted(len({name for _, name in self.motion.phases}), "phase"), self.scene.equations.switching
        of_modes = [("modes of the phase", switching.label)] if switching else []
        return [("events", f"{len(self.motion.events)}, through {phases}"), *of_modes]

    @cached_property
    def tables(self) -> tuple[TextTable, ...]:
        """The tables of the summary and of the page."""
        return tables_of(self, self.certificate, self.frequency)

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        equations = self.scene.equations
        notices = self.motion._equation_notices if self.system else with_units(self.motion, equations.coordinates)
        accuracy = (one for kind, estimate in self.error_estimates.items() for one in doubts_of(f"the {kind}", estimate))
        proved = self.certificate.notices if self.certificate else ()
        moves = np.ptp(np.asarray(self.values), axis=1).any() or any(
            notice.kind in (NoticeKind.JUMP, NoticeKind.IMPULSE) for notice in notices
        )
        of_frequency = (*self.frequency.scene.phase_notices, *self.frequency.response.notices) if self.frequency else ()
        output = self.scene.table.output
        omissions = self._omissions() if output.formula or output.still is not None else ()
        first = (*self.scene.notices, *omissions, *proved, *of_frequency)
        at_rest = () if moves else (Notice(NoticeKind.AT_REST, NOTHING_MOVES),)
        aliased = aliasing_notices(self.scene, self.motion, len(self.times))
        of_modes = self.modes.notices if self.system is not None and self.system.delayed else ()
        return distinct(first, equations.form_notices, notices, of_modes, at_rest, aliased, equations.notices(self), accuracy)

    @cached_property
    def table_notices(self) -> tuple[Notice, ...]:
        """The notices of the summary and of the page, where tables have the jumps and impulses."""
        return folded(self.notices, len(self.jumps), len(self.impulses), counts(self.later))

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

    # Parts that only some scenes need.

    @cached_property
    def animation(self) -> Animation:
        """The drawing of the model with its motion."""
        from ..scene.run.animation import animation_of

        return animation_of(self)

    @cached_property
    def certificate(self) -> Certificate | None:
        """The proved digits; None where not requested."""
        from ..scene.run.certificate import certificate_of

        return certificate_of(self)

    @cached_property
    def formula(self) -> ClosedForm | None:
        """The formula of each coordinate; None, with a notice, where there is none."""
        from .formula import PAGE_SECONDS, formula_of

        wanted = None if self.scene.equations.original else self.scene.table.output.coordinates  # of a normal form: its states
        try:
            return formula_of(self.scene, coordinates=wanted, seconds=PAGE_SECONDS)
        except InputError as problem:
            self.formula_problem = str(problem)
            return None

    @property
    def formulas(self) -> Formulas | None:
        """The section of the page with the formula; None where there is none."""
        if not self.scene.table.output.formula or self.formula is None:
            return None
        from .formula import formulas_on_page

        return formulas_on_page(self.formula)

    @cached_property
    def frequency(self) -> Frequency | None:
        """The frequency response; None where the scene has no [frequency]."""
        from .frequency import Frequency

        return Frequency(self.scene.in_phase())

    # For the terminal, programs and the page.

    def _summary(self) -> str:
        names = self.scene.equations.coordinates.names
        return f"{self.name}: {counted(len(names), 'coordinate')} at {counted(len(self.times), 'time')}"

    def summary(self) -> str:
        """The answer in words and tables, as it is printed."""
        return _printed(self.blocks())

    def blocks(self, files: Sequence[Path] = (), *, verbose: bool = True) -> list[str | TextTable]:
        """The parts of the summary: texts, and tables that a terminal may lay out itself."""
        parts = [("Notices", self.table_notices), ("Written", self.files)]
        lists = ["\n".join([title, *(f"  {line}" for line in lines)]) for title, lines in parts if lines]
        return [self.heading, *self.tables, *lists, f"Plan: {self.plan.totals()}"]

    def to_dict(self, files: Sequence[Path] | None = None) -> dict:
        """The answer as plain data, numbers in SI, with the plan and its costs; ``files`` are those written by default."""
        end = {"plan": self.plan.to_list(), "totals": self.plan.totals_to_dict()}
        return super().to_dict(self.files if files is None else files) | end

    @property
    def data(self) -> dict[str, Any]:
        """The answer as plain data, without notices and files."""
        equations, motion = self.scene.equations, self.motion
        return {
            "source": self.source,
            **equations.to_dict(self),
            **{end.key: end.to_dict() for end in equations.ends},
            "coordinates": equations.coordinates.to_list(),
            "constraints": [
                {"name": row.name, "level": row.level, "value": row.value if row.signal is None else "prescribed"}
                for row in getattr(motion, "_constraint_rows", self.rows)
            ],
            "eigenvalues": [
                {"real": value.real, "imaginary": value.imag, "multiplicity": multiplicity, **meaning}
                for value, multiplicity, meaning in self._eigenvalues()
            ],
            "initial": motion.initial,
            "jump": motion.jump,
            "impulses": motion.impulses,
            "constraint_impulses": getattr(motion, "constraint_impulses", ()),
            "events": [event.to_dict() for event in motion.events]
            if self.is_switched
            else [{"time": one.time, "jump": one.jump, "impulses": one.impulses} for one in motion._later_events],
            "later_constraint_impulses": [
                {"time": load.time, "impulses": load.impulses} for load in getattr(motion, "later_constraint_impulses", ())
            ],
            "largest": [
                {"name": one.name, "of": one.title, "unit": one.unit, "largest": abs(one.value)}
                | {"value": one.value, "time": one.time, "margin": one.margin}
                for one in self.largest
            ],
            "final": self.values[:, -1],
            "error_estimate": self.error_estimate,
            "error_estimates": self.error_estimates,
            "evidence": [{"name": item.name, "value": item.value, "text": item.text} for item in motion.evidence],
            **({"certificate": self.certificate.to_dict()} if self.certificate else {}),
        }

    def _eigenvalues(self) -> Iterator[tuple[complex, int, dict]]:
        """Value, multiplicity and meaning."""
        if self.system is None:
            yield from ((zero.value, zero.multiplicity, {}) for zero in self.finite_pair.zeros)
        else:
            yield from ((mode.eigenvalue, mode.multiplicity, {"kind": mode.kind, "meaning": mode.text}) for mode in self.modes)

    def plots(self) -> Iterable[Plot]:
        """The requested plots, in the order of the scene."""
        from .motion_plots import plots_of

        return plots_of(self)

    def page(self) -> PageContent:
        """Animation, plots, tables, notices and facts."""
        from ..page.content import PageContent

        return PageContent(
            title=self.title,
            source=self.source,
            animation=self.animation if is_animated(self.scene) else None,
            plots=tuple(self.plots()),
            frequencies=self.tables[0],
            tables=(*self.tables[1:], self.scene.plan().page_table()),
            notices=self.table_notices,
            formulas=self.formulas,
            facts=self.facts,
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """Times, names, curves, start, jump, impulses, events, finite and infinite pair, for NumPy."""
        arrays = {"times": self.times, "coordinates": np.array(self.scene.equations.coordinates.names)}
        return arrays | {kind: self.curves(kind).values for kind in self.kinds} | self._more_arrays()

    def _more_arrays(self) -> dict[str, np.ndarray]:
        """Further arrays: all that are not curves."""
        arrays, equations = {}, self.scene.equations
        named = {"reaction": "constraints", "ground_reaction": "ground_reactions", "quantity": "quantities", "output": "outputs"}
        for kind, key in named.items():
            if kind in self.kinds:
                arrays[key] = np.array(self.curves(kind).names)
        if equations.has_outputs_among_coordinates:
            arrays["outputs"] = np.array(equations.control.outputs.names)
        arrays |= self.motion._start_arrays()
        needed = {stage.name for stage in self.plan.needed}
        pairs = {name: getattr(self, f"{name}_pair") for name in ("finite", "infinite") if f"{name} pair" in needed}
        return arrays | {f"{name}_{key}": getattr(pair, key) for name, pair in pairs.items() for key in "CJB"}

    # Files.

    def write_page(self, path: str | Path | None = None) -> Path:
        """Write the page, with the viewer's script next to it where [output] viewer requests that.

        Args:
            path: path of the page; None for the folder of the run, named after the scene.

        Returns:
            The path written.
        """
        from ..page.html import write_page

        content, viewer = self.page(), self.scene.table.output.viewer
        path = self._prepared("html", path)
        self._listed(lambda files: write_page(path, content, viewer, files))
        return path

    def write_csv(self, path: str | Path | None = None) -> Path:
        """Write the curves as CSV, one line for each time, in the units of [output]; the path is that of ``write_page``."""
        return self._written("csv", path, lambda path: write_csv(path, self.times, self._all_shown))

    def write_npz(self, path: str | Path | None = None) -> Path:
        """Write curves, jumps, impulses and the Jordan pairs as NumPy arrays; the path is that of ``write_page``."""
        return self._written("npz", path, lambda path: write_arrays(path, self.arrays(), ".npz"))

    def to_xarray(self):
        """The curves of every kind over time and name, as an ``xarray.Dataset`` with units."""
        return dataset_of(self.times, [self.curves(kind) for kind in self.kinds], self._more_arrays())

    def columns(self) -> dict[str, dict[str, np.ndarray]]:
        """The curves in the units of [output], as in the CSV file."""
        curves = {head: values for block in self._all_shown for head, values in zip(block.heads, block.values)}
        return {"": {"time (s)": self.times, **curves}}

    def write(  # type: ignore[override]  # a path names one format, as of motions; a folder with formats is that of all answers
        self,
        path: str | Path,
        formats: str | Iterable[str] | None = None,
        *,
        excel: bool = False,
        geometry: Geometry | None = None,
        binary: bool = True,
    ) -> Path | list[Path]:
        """Write the curves in the format that the ending of the path names: .csv, .npz, .mat, .nc, .zarr, .uff or .unv.

        Args:
            path: path of the file; with ``formats`` that of a folder.
            formats: as in ``Answer.write``.
            excel, geometry, binary: as in ``Motion.write``.

        Returns:
            The path; the paths of several formats.

        Raises:
            InputError: another ending, or an option of another format.
            MissingPackage: xarray for .nc, xarray and zarr for .zarr, pyuff for universal files.
        """
        if formats is not None:
            return super().write(path, formats)
        ending, arrays = Path(path).suffix.lower(), self._more_arrays()
        if ending == ".npz":
            return self.write_npz(path)
        curves = self._all_shown if ending == ".csv" else [self.curves(kind) for kind in self.kinds]
        options: dict[str, Any] = {"excel": excel, "geometry": geometry, "binary": binary}
        self._listed(lambda files: write_trajectories(path, self.times, curves, arrays, **options, files=files))
        return Path(path)

    @property
    def _all_shown(self) -> list[Curves]:
        return [self.shown_curves(kind) for kind in self.kinds]

    def write_formats(self) -> list[Path]:
        """Write the files that [output] formats requests, next to the others."""
        folder = self.folder or Path()
        return [
            self.write(folder / f"{self.name}{FORMATS[kind]}", excel=kind == "excel") for kind in self.scene.table.output.formats
        ]

    def write_plots(self, folder: str | Path | None = None) -> list[Path]:
        """Write each plot of the page as SVG and PNG, named after scene and plot; by default into the folder of the run."""
        folder = Path(folder or self.folder or Path())
        folder.mkdir(parents=True, exist_ok=True)
        return self._listed(lambda files: write_pictures(self.plots(), folder, self.name, files))

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
        from ..page.photograph import photograph

        time = time if time is not None else self.scene.table.output.still or 0.0
        image = photograph(self.animation, time)
        return self._written("still.png", path, lambda path: path.write_bytes(image))

    def try_still(self) -> None:
        """Write the still picture; if the browser fails, a notice has the reason and all else is written."""
        try:
            self.write_still()
        except MbconstrainedError as problem:
            self.still_problem = str(problem)

    def write_frequency(self) -> list[Path]:
        """Write the page, CSV and npz of the frequency response into the folder of the run, as far as [output] requests them."""
        output, answer = self.scene.table.output, self.frequency.to_answer()
        return self._listed(lambda files: answer.write(self.folder or Path(), formats_of(output), output.viewer, files))

    def _written(self, ending: str, path, write: Callable[[Path], object]) -> Path:
        path = self._prepared(ending, path)
        self._listed(lambda files: write(files.temporary(path)))
        return path

    def _listed(self, write: Callable[[Replacements], object]) -> list[Path]:
        """Write files together with others, and list them among those of the run."""
        with self.writing_together() as files:
            count = len(files.paths)
            write(files)
            self.files += files.paths[count:]
            return files.paths[count:]

    def _prepared(self, ending: str, path) -> Path:
        """The path of a file, in a folder that exists."""
        path = Path(path) if path is not None else (self.folder or Path()) / f"{self.name}.{ending}"
        path.parent.mkdir(parents=True, exist_ok=True)
        return path

    @contextmanager
    def writing_together(self) -> Iterator[Replacements]:
        """A context in which written files replace their targets at the end of the outermost block, all or none."""
        if self._together is not None:
            yield self._together
            return
        try:
            with Replacements(lambda: self.scene.files_read) as self._together:
                yield self._together
        finally:
            self._together = None


# The summary on a screen.

#: Lines of the short summary, at most: with the command above and the prompt below they fill a screen of 24.
SCREEN = 22


def _printed(parts: Sequence[str | TextTable], width: int = WIDTH) -> str:
    """Texts and tables, one below the other."""
    return "\n\n".join(table_text(part, width) if isinstance(part, TextTable) else wrapped(part, width) for part in parts)


def overview(answer: RunAnswer, width: int = WIDTH, lines: int = SCREEN) -> list[str | TextTable]:
    """The parts of the summary that fit on a screen: natural frequencies, warnings, files, and the number of omitted lines.

    Tables that do not fit are left out, but for the largest values and those of a requested end of the motion, of which the first rows are shown."""
    title = "\n".join(_first_lines(text, width, 2) for text in (answer.title, answer.source) if text)
    figures = f"Error estimate {max(answer.error_estimates.values()):.2g}; {answer.plan.totals()}"
    end = "\n".join(wrapped(text, width) for text in (_files(answer), figures, "All tables and notices: --verbose") if text)
    left = lines + 1 - _height([title, end], width)
    notices = sorted(answer.table_notices, key=_rank)
    rest = left - len(answer.tables[0].rows) - 3
    notes = _some_notices(notices, width, left // 3 if answer.scene.equations.switching else max(left // 2, rest))
    left -= _height(notes, width)
    events = [table for table in answer.tables if table.title == "Events"]
    shown = [_some_rows(table, width, max(2 * left // 3, left - len(answer.tables[0].rows) - 3)) for table in events]
    shown.append(_some_rows(answer.tables[0], width, left - _height(shown, width) - 1))
    for table in answer.tables[1:]:
        if table.title in {LARGEST, *(end.title for end in answer.scene.equations.ends)}:
            table = _some_rows(table, width, left - _height(shown, width) - 1)
        if table not in events and not table.folded and table.rows and _height([*shown, table], width) <= left:
            shown.append(table)
    return [title, *shown, *notes, end]


#: Notices on motions that the equations do not describe come first, those on what does not change them come last.
_FIRST = (NoticeKind.UNSTABLE, NoticeKind.LARGE_MOTION, NoticeKind.DISTANT_POSTURE)
_LAST = (NoticeKind.REDUNDANT, NoticeKind.OMITTED, NoticeKind.OVERRIDE)


def _rank(notice: Notice) -> int:
    return 0 if notice.doubtful else 1 if notice.kind in _FIRST else 3 if notice.kind in _LAST else 2


def _height(parts: Sequence[str | TextTable], width: int) -> int:
    return sum(_printed([part], width).count("\n") + 2 for part in parts)


def _first_lines(text: str, width: int, most: int) -> str:
    """The first lines of a user's text."""
    lines = wrapped(text, width).split("\n")
    return "\n".join([*lines[: most - 1], lines[most - 1][: width - 1] + "…"] if len(lines) > most else lines)


def _files(answer: RunAnswer) -> str:
    """The path of the first file of each folder and the names of the others in it."""
    folders: dict[Path, list[str]] = {}
    for path in sorted(answer.files, key=lambda path: path.suffix != ".html"):
        names = folders.setdefault(path.parent, [])
        names.append(path.name if names else str(path))
    return "\n".join(f"Written: {', '.join(names)}" for names in folders.values())


def _some_notices(notices: Sequence[Notice], width: int, lines: int) -> list[str]:
    """Notices on so many lines, one at least, and the number of the others."""
    if not notices:
        return []
    texts = [wrapped(f"  {notice}", width) for notice in notices]
    heights = [1 + sum(text.count("\n") + 1 for text in texts[:count]) for count in range(1, len(texts) + 1)]
    count = max(1, sum(height + (number < len(texts)) <= lines for number, height in enumerate(heights, 1)))
    more = [f"  and {counted(len(texts) - count, 'further notice')}"] if count < len(texts) else []
    return ["\n".join(["Notices", *texts[:count], *more])]


def _some_rows(table: TextTable, width: int, lines: int) -> TextTable:
    """The table with its first rows, as many as fit on so many lines, and the number of the others."""
    if table_text(table, width).count("\n") < lines:
        return table
    for count in range(len(table.rows) - 1, 0, -1):
        part = replace(table, rows=table.rows[:count], note=f"and {len(table.rows) - count} more")
        if table_text(part, width).count("\n") < lines:
            return part
    return replace(table, rows=(), note=f"{len(table.rows)} in all")
