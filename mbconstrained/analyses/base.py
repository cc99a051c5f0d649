"""Declaration of an analysis, and the common answer: printed, written as page, CSV, npz and pictures, or returned as plain data."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from inspect import Parameter, Signature, getdoc, signature
from keyword import iskeyword
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Any, ClassVar, Literal

import numpy as np

from ..exchange.trajectories import csv_of, write_arrays
from ..ground.by_name import answering
from ..ground.checks import check_known, listed, nearest, optional_package
from ..ground.display import WIDTH, Pictured, TextTable, finite_or_none
from ..ground.errors import InputError
from ..ground.files import Replacements
from ..ground.notices import Notice
from ..scene.file import at
from ..scene.schema.entry_types import Table, validated

if TYPE_CHECKING:
    from ..page.content import PageContent, Plot
    from ..page.html import Delivery
    from ..scene.run.scene_data import SceneData
    from ..scene.schema.scene_schema import OutputTable

#: Rows of a table for a terminal, and on the page.
MOST_ROWS, MOST_ROWS_OF_PAGE = 16, 200

#: What ``Answer.write`` writes.
FORMATS = ("page", "csv", "npz", "pictures", "images", "json", "text")

#: Formats of pictures of plots.
PICTURES: tuple[Literal["svg", "png"], ...] = ("svg", "png")


@dataclass(frozen=True, eq=False, repr=False)
class Answer(Pictured):
    """The answer to one question.

    Attributes:
        kind: name of the analysis, part of the names of files.
        name: name of the model, the first part of the names of files; empty for several models.
        title, source: title and source of the model.
        facts: pairs of a label and a text.
        tables: for terminal and page, in the units shown.
        notices: notices on the answer, and doubts about it.
        data: everything as plain data, numbers in SI.
        plots: a function, since only pages and pictures need them.
        columns: columns of each CSV file by their heads, the files by the text before their ending, such as ".peaks".
        arrays: arrays of the npz file, in SI.
        heading: for the terminal; by default the title.
        texts: for the terminal, after the tables.
        most_rows: rows of each table on the terminal; None for all.
        on_page: parts of the page that differ or are not here, such as a motion or shapes to draw, a function as the plots.
        keys: parts of the plain data besides title and data.
        machine: processor and packages, on the page, and on the terminal with all that ``verbose`` shows.
        text: the whole answer as a text of its own, such as source code, in the place of files.
        kept: resolved paths of the files that were read, which results never replace.
    """

    kind: str
    name: str
    title: str
    source: str
    facts: tuple[tuple[str, str], ...]
    tables: tuple[TextTable, ...]
    notices: tuple[Notice, ...]
    data: Mapping[str, Any]
    plots: Callable[[], Iterable[Plot]] = tuple
    columns: Callable[[], Mapping[str, Mapping[str, Any]]] = dict
    arrays: Callable[[], Mapping[str, np.ndarray]] = dict
    heading: str = ""
    texts: tuple[str, ...] = ()
    most_rows: int | None = MOST_ROWS
    on_page: Callable[[], Mapping[str, Any]] = dict
    keys: tuple[str, ...] = ("notices", "trusted", "files")
    machine: Mapping[str, str] = field(default_factory=dict)
    text: str = ""
    kept: frozenset[Path] = frozenset()

    @property
    def is_trusted(self) -> bool:
        """False where a notice warns that values may be wrong."""
        return not any(notice.doubtful for notice in self.notices)

    def blocks(self, files: Sequence[Path] = (), *, verbose: bool = False) -> list[str | TextTable]:
        """Texts and tables for a terminal of 80 columns.

        Args:
            files: the files that were written, to be listed.
            verbose: with the tables that are folded on the page, all rows, and the machine.

        Returns:
            Texts and tables in their order.
        """
        head = "\n".join(line for text in (self.heading or self.title, self.source) for line in wrap(text, WIDTH))
        facts = (*self.facts, *(self.machine.items() if verbose else ()))
        about = "\n".join(_indented(f"{label}: {text}", "") for label, text in facts)
        lists = {"Notices": [_indented(str(notice), "  ") for notice in self.notices], "Written": [f"  {path}" for path in files]}
        shown = [limited(table, None if verbose else self.most_rows) for table in self.tables if verbose or not table.folded]
        return [
            head,
            *filter(None, [about]),
            *shown,
            *self.texts,
            *("\n".join([title, *lines]) for title, lines in lists.items() if lines),
        ]

    def __getitem__(self, name: str) -> Any:
        """A part of the data, numbers in SI, such as ``answer["modes"]``; of a run also the displacement of a coordinate at its times.

        Raises:
            InputError: no part and no coordinate has this name.

        >>> import mbconstrained as mb
        >>> run = mb.read_scene("examples/two_masses.toml").run()
        >>> run["x1"].shape
        (1001,)
        """
        if name not in self.data:
            raise InputError(
                f'there is no "{name}"{nearest(str(name), self._entries())}; there are {listed([*self._entries()], 20)}'
            )
        return self.data[name]

    def _entries(self) -> Iterable[str]:
        return self.data

    def to_dict(self, files: Sequence[Path] = ()) -> dict:
        """The answer as plain data, numbers in SI: title, data, notices, whether it is to be trusted, files."""
        end = {
            "notices": [notice.to_dict() for notice in self.notices],
            "trusted": self.is_trusted,
            "files": [str(path) for path in files],
        }
        title = {"title": self.title} if self.name else {}  # runs of several models have titles of their own
        return {**title, **json_value(self.data), **{key: end[key] for key in self.keys}}

    def to_xarray(self):
        """The columns of the CSV files, or else the arrays of the npz file, as an ``xarray.Dataset`` with units as attributes.

        Columns are over the first of their file, such as the frequency; where two files share a name, their endings are added.

        Raises:
            MissingPackage: xarray is not installed.

        >>> import mbconstrained as mb
        >>> answer = mb.read_scene("examples/tuned_mass_damper.toml").frequency()
        >>> answer.to_xarray().sizes["frequency"] == len(answer.to_xarray().frequency)
        True
        """
        xarray = optional_package("xarray", "to_xarray")
        variables: dict[str, Any] = {}
        for part, columns in self.columns().items():
            heads = [(name.strip() + part, unit) for name, unit in map(_name_and_unit, columns)]
            for (name, unit), values in zip(heads, columns.values()):
                variables[name] = (heads[0][0], np.asarray(values), {"units": unit} if unit else {})
        if not variables:
            variables = {
                name: (tuple(f"{name}_{axis}" for axis in range(np.ndim(array))), array) for name, array in self.arrays().items()
            }
        return xarray.Dataset(variables, attrs={"title": self.title, "source": self.source})

    def page(self) -> PageContent:
        """Plots, tables, notices and facts as a page."""
        from ..page.content import PageContent

        own: dict[str, Any] = {"tables": self.tables, "plots": tuple(self.plots()), "notices": self.notices, "facts": self.facts}
        own |= self.on_page()
        own["facts"] = (*own["facts"], *self.machine.items())
        own["tables"] = tuple(limited(table, MOST_ROWS_OF_PAGE) for table in own["tables"])
        return PageContent(self.title, self.source, **own)

    def write(
        self,
        folder: str | Path,
        formats: str | Iterable[str] = ("page", "csv", "npz"),
        viewer: Delivery = "inside",
        files: Replacements | None = None,
    ) -> list[Path]:
        """Write NAME.KIND.html, .csv, .npz, .png and .json, all of them or none.

        Args:
            folder: is created if it does not exist.
            formats: one or some of "page", "csv", "npz", "pictures" (each plot as SVG and PNG by its title), "images" (all plots as
                PNG by their numbers), "json".
            viewer: location of the script of the 3-D viewer, see ``mbconstrained.page.html``.
            files: take their places together with others; None for these alone.

        Returns:
            The paths.

        Raises:
            InputError: an unknown format.
            OSError: they cannot be written; files that were there are unchanged.
        """
        folder, formats = Path(folder), [formats] if isinstance(formats, str) else list(formats)
        for one in formats:
            check_known(one, FORMATS, "formats")
        if files is None:
            with Replacements(lambda: self.kept) as files:
                return Answer.write(self, folder, formats, viewer, files)
        from ..page.html import write_page
        from ..page.plots import image_groups, plot_image

        stem, chosen, before = ".".join(filter(None, (self.name, self.kind))), set(formats), len(files.paths)
        content = self.page() if chosen & {"page", "pictures", "images"} else None
        folder.mkdir(parents=True, exist_ok=True)
        for part, columns in self.columns().items() if "csv" in chosen else ():
            files.temporary(folder / f"{stem}{part}.csv").write_text(csv_of(columns), encoding="utf-8")
        if "npz" in chosen:
            write_arrays(files.temporary(folder / f"{stem}.npz"), dict(self.arrays()), ".npz")
        if content and "pictures" in chosen:
            write_pictures(content.plots, folder, stem, files)
        if content and "page" in chosen:
            write_page(folder / f"{stem}.html", content, viewer, files)
        if content and "images" in chosen:
            for number, panels in enumerate(image_groups(content.plots), 1):
                files.temporary(folder / f"{stem}{f'-{number}' * (number > 1)}.png").write_bytes(plot_image(panels, "png"))
        if "json" in chosen:
            data = {key: value for key, value in self.to_dict().items() if key != "files"}
            text = json.dumps(data, indent=2, allow_nan=False) + "\n"
            files.temporary(folder / f"{stem}.json").write_text(text, encoding="utf-8")
        return files.paths[before:]

    def _summary(self) -> str:
        return f"{self.kind} of {self.name}"

    def _tables(self) -> tuple[TextTable, ...]:
        return self.tables


class Analysis:
    """A question: a name, a sentence of help, settings, and a function from a scene to an answer."""

    name: ClassVar[str]  # name of the command and of the table in a scene
    settings: ClassVar[type[Table] | None] = None  # a table of the scene, whose entries are the options of the command
    # names of options that differ from their entries, by entry; None for entries without an option. Lists and tables are options,
    # which may be repeated, where they are named here
    options: ClassVar[Mapping[str, str | None]] = {}
    replaced: ClassVar[Mapping[str, tuple[str, ...]]] = {}  # entries of the table that a given one replaces, by its name
    # written formats; none for those of [output] in the scene; "text" alone for a text that is printed as it is
    formats: ClassVar[tuple[str, ...]] = ()
    # what a bar counts, such as "generations"; "steps" for a line with the name of each step; empty for short work
    progress: ClassVar[str] = ""
    without_scene: ClassVar[tuple[str, ...]] = ()  # options of the answer without a scene, given by ``answer_without_scene``
    writes: ClassVar[bool] = True  # whether the command writes files without being asked
    handles_delays: ClassVar[bool] = False  # whether it has an answer for systems with delays
    switches: ClassVar[Literal["all", "phase", "none"]] = "phase"  # whether it follows models that switch, or takes one phase
    # whether it has one for equations with free coordinates once these are chosen: of the motion, not of modes
    handles_choices: ClassVar[bool] = False

    @classmethod
    def solve(cls, scene: Any, settings: Any) -> Answer:
        """The answer; a pure function of the scene and of the settings, whose types each analysis states."""
        raise NotImplementedError

    @classmethod
    def of(cls, scene: Any, **fields: Any) -> Answer:
        """An answer with these fields, and the name, title, source and notices of the scene where no others are given."""
        own = {"title": scene.title, "source": scene.table.source, "facts": (), "tables": (), "notices": scene.notices}
        return Answer(kind=cls.name, name=scene.name, **{**own, **fields})

    @classmethod
    def of_file(cls, path: Path, source: str, **fields: Any) -> Answer:
        """An answer with these fields on a file that is no scene."""
        return Answer(kind=cls.name, name=path.stem, title=path.name, source=source, **fields)

    @classmethod
    def answer(cls, scene: Any, progress: Callable | None = None, **given) -> Answer:
        """The answer of a scene with some settings in the place of those in its table, by the names of its entries."""
        if scene.table.time.step_domain == "discrete" and scene.equations.are_bare:
            with at(scene.file_name, "time.step_domain"):
                raise InputError(
                    f"{cls.name}: the coefficients are those of the shift in discrete time, not of d/dt; only a run has them"
                )
        if scene.equations.solvability is not None and not cls.handles_choices:
            from ..scene.build.model import no_modes

            with at(scene.file_name, "model.coefficients"):
                raise InputError(no_modes(cls.name))
        if not cls.handles_delays and (system := scene.equations.system) is not None:
            with at(scene.file_name, "model"):
                system._refuse_delays(cls.name)
        own = getattr(scene.table, cls.name, None)
        reported = {"progress": progress} if progress else {}
        settings = cls.changed(own, given, scene.file_name) if given else own
        if scene.equations.switching is None or cls.switches == "all":
            answer = cls.solve(scene, settings, **reported)
            return replace(answer, kept=scene.files_read) if type(answer) is Answer else answer  # a run keeps them itself
        if cls.switches == "none":
            with at(scene.file_name, "model"):
                raise InputError(
                    f"{cls.name}: not available for models that switch, such as those with contacts or friction; a run has their motion, "
                    "modes and frequency the linear answers for one phase"
                )
        answer = cls.solve(scene.in_phase(), settings, **reported)
        return replace(answer, keys=tuple(dict.fromkeys((*answer.keys, "notices"))), kept=scene.files_read)

    @classmethod
    def answer_without_scene(cls, progress: Callable | None = None, **given) -> Answer:
        """The answer without a scene, by the options of ``without_scene``."""
        raise NotImplementedError

    @classmethod
    @cache
    def method(cls) -> Callable[..., Answer]:
        """The method of a ``Scene`` that gives the answer; its signature and its documentation follow from the settings."""
        from ..scene.schema.scene_schema import SceneFile

        schema = cls.settings.model_json_schema()["properties"] if cls.settings else {}
        fields = {field.alias or name: field for name, field in cls.settings.model_fields.items()} if cls.settings else {}
        names = {f"{key}_" if iskeyword(key) else key: key for key in fields}

        def ask(scene: SceneData, **given) -> Answer:
            return cls.answer(scene, **{names.get(key, key): _scene_value(value) for key, value in given.items()})

        parameters = [one for one in signature(cls.answer).parameters.values() if one.kind is Parameter.KEYWORD_ONLY]
        entries = []
        for name, key in names.items():
            parameters.append(Parameter(name, Parameter.KEYWORD_ONLY, default=fields[key].get_default()))
            unit = re.search(r"'unit': '(.+?)'", str(schema[key]))
            entries.append(
                f"    {name}: {fields[key].description}{f' In {unit[1]}, or a text with a unit.' if unit and unit[1] != '1' else ''}"
            )
        ask.__signature__ = Signature([Parameter("self", Parameter.POSITIONAL_ONLY), *parameters])  # type: ignore[attr-defined]
        ask.__name__, ask.__qualname__, ask.__module__ = cls.name, f"Scene.{cls.name}", cls.__module__
        table = (
            [f"What is not given is taken from the table [{cls.name}] of the scene.", ""]
            if cls.name in SceneFile.model_fields
            else []
        )
        given = [*table, "Args:", *entries, ""] if entries else []
        ask.__doc__ = "\n".join([getdoc(cls) or "", "", *given, "Returns:", "    The ``Answer``."])
        return answering(ask)

    @classmethod
    def changed(cls, own: Table | None, given: Mapping[str, Any], file_name: str) -> Table:
        """The settings with other values; those that a given one replaces are left out."""
        base = own.model_dump(exclude_unset=True, by_alias=True) if own else {}
        for key in given:
            for other in cls.replaced.get(key, ()):
                base.pop(other, None)
        only = type("Only", (Table,), {"__annotations__": {cls.name: cls.settings}})
        return getattr(validated({cls.name: {**base, **given}}, file_name, only), cls.name)


def _scene_value(value):
    """A value as it could stand in a scene file: arrays and tuples as lists, numbers of NumPy as those of Python."""
    if isinstance(value, (np.ndarray, np.generic)):
        return value.tolist()
    if isinstance(value, (list, tuple)):
        return [_scene_value(one) for one in value]
    return {key: _scene_value(one) for key, one in value.items()} if isinstance(value, Mapping) else value


def _name_and_unit(head: str) -> tuple[str, str]:
    """Name and unit of a column.

    >>> _name_and_unit("frequency (Hz)"), _name_and_unit("f(x)")
    (('frequency ', 'Hz'), ('f(x)', ''))
    """
    name, bracket, unit = head.rpartition(" (")
    return (f"{name} ", unit.removesuffix(")")) if bracket and unit.endswith(")") else (head, "")


def json_value(value):
    """Arrays and tuples as lists, infinite numbers as None, as JSON takes them.

    >>> json_value({"a": np.array([1.0, np.inf]), "b": ("x", 2)})
    {'a': [1.0, None], 'b': ['x', 2]}
    """
    if isinstance(value, Mapping):
        return {key: json_value(one) for key, one in value.items()}
    if isinstance(value, np.ndarray):
        return json_value(value.tolist())
    if isinstance(value, (list, tuple)):
        return [json_value(one) for one in value]
    return finite_or_none(value) if isinstance(value, (float, np.floating)) else value


def write_pictures(plots: Iterable[Plot], folder: Path, stem: str, files: Replacements) -> None:
    """Each plot as SVG and PNG, named after its title."""
    from ..page.plots import plot_image, plot_images

    for name, plot in plot_images(plots).items():
        for kind in PICTURES:
            files.temporary(folder / f"{stem}.{name}.{kind}").write_bytes(plot_image(plot, kind))


def formats_of(output: OutputTable) -> list[str]:
    """The formats that the table [output] requests."""
    requested = {"page": output.page, "csv": output.csv, "npz": output.npz, "pictures": output.plot_images}
    return [name for name, wanted in requested.items() if wanted]


def limited(table: TextTable, most: int | None) -> TextTable:
    """The first rows, and how many more there are."""
    if most is None or len(table.rows) <= most:
        return table
    note = "; ".join(filter(None, [f"and {len(table.rows) - most} more", table.note]))
    return replace(table, rows=table.rows[:most], note=note)


def _indented(text: str, indent: str) -> str:
    return "\n".join(wrap(text, WIDTH, initial_indent=indent, subsequent_indent=indent + "  "))
