"""The modes of a scene: its eigenvalues and, of a mechanical system, shapes and shares of energy; on a page each of them moves."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from textwrap import wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from ..ground.display import WIDTH, TextTable, with_unit
from ..ground.errors import SceneError
from ..ground.notices import Notice, NoticeKind, distinct
from ..ground.tolerances import noise_of
from ..page.animation import ModePicture, Shapes, Share, cycle
from ..response.response_notices import pair_notices
from ..scene.build.robot_model import posture_json, posture_tables, robot_fact
from ..scene.coordinates import Coordinates
from ..scene.run.drawing import ShapeDrawing
from ..scene.run.result import Result
from .base import Analysis, Answer
from .motion_report import descending, share_entries
from .sensitivity import influence_tables

if TYPE_CHECKING:
    from ..mechanics.energy import EnergyShares
    from ..mechanics.modes import Mode
    from ..mechanics.peaks import EffectiveMasses
    from ..page.content import PageContent
    from ..scene.run.scene_data import SceneData
    from ..scene.schema.entry_types import Table

MOST_ENTRIES = 6  # listed entries of a shape; JSON has all
PHASE_DIGITS = 1  # of degrees, after the point

COLUMNS = {
    "frequency (Hz)": "Hz",
    "damping ratio": "damping",
    "kind": "kind",
    "eigenvalue (1/s)": "eigenvalue (1/s)",
    "natural frequency (rad/s)": "rad/s",
    "multiplicity": "times",
}

NO_MODES = "none: the model is static, without dynamic modes"
NO_ENERGIES = (
    "Mass, damping and stiffness are not given, only the coefficients of A(s): "
    "the zeros are listed without kinetic and strain energies."
)
BY_COORDINATE = (
    "Shares of energy are by coordinate, x_i (M x)_i and x_i (K x)_i: of masses and springs nothing "
    "is known. They sum to 100 %; one alone may be negative."
)
SHAPES = "The largest entry of a shape is 1; its amplitude is free."
PHASES = "Phases are ahead of the first entry; shares of energy are averages over a cycle, growth and decay left out."

Facts = tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class ModeLine:
    """One line of the list of modes: an eigenvalue, or one of its shapes where it has any."""

    number: int  # from 1 on, the order of the list
    cells: dict[str, str]  # texts by column (``Modes.table``)
    value: complex  # value, multiplicity: the eigenvalue in 1/s
    multiplicity: int
    mode: Mode | None = None  # its meaning; None where A(s) was given by coefficients
    place: int | None = None  # index of the shape among those of the eigenvalue, from 0; None where it has none

    @property
    def shape(self) -> np.ndarray | None:
        """The shape, (n,), its largest entry 1."""
        return None if self.place is None else self.mode.shapes[:, self.place]

    @property
    def shares(self) -> EnergyShares | None:
        """The energies of the shape by part."""
        return None if self.place is None else self.mode.shares[self.place]

    @property
    def among(self) -> str:
        """The number of the shape among several of the eigenvalue."""
        count = self.mode.shapes.shape[1] if self.mode else 0
        return f" (shape {self.place + 1} of {count})" if count > 1 else ""

    def text(self, coordinates: Coordinates) -> str:
        """Meaning, energy shares and shape, for a terminal."""
        lines = wrap(f"Mode {self.number}{self.among}: {self.cells['meaning']}", WIDTH, subsequent_indent="  ")
        if self.shape is not None:
            lines += _packed("kinetic energy", share_entries(self.shares.kinetic))
            lines += _packed("strain energy", share_entries(self.shares.strain))
            lines += _packed("shape", shape_entries(self.shape, coordinates))
        return "\n".join(lines)

    def picture(self, swinging: ShapeDrawing, facts: Facts, name: str = "", **parts: Any) -> ModePicture:
        """The shape as it moves in a drawing."""
        factor = swinging.amplitude(self.shape)
        period = 2 * np.pi / self.value.imag if self.value.imag else None
        name, paths = name or self.cells["kind"] + self.among, swinging.paths(self.shape, factor)
        return ModePicture(name, facts, values=cycle(self.shape), paths=paths, period=period, scale=factor, **parts)

    def picture_of_page(self, swinging: ShapeDrawing, coordinates: Coordinates) -> ModePicture:
        """The picture with the shares of energy and the shape."""
        meaning = self.cells["meaning"]
        facts = tuple((label, text) for label, text in self.cells.items() if label not in ("kind", "meaning"))
        if self.shape is None:
            return ModePicture(self.cells["kind"] + self.among, facts, note=meaning, is_zero=not self.value)
        if not self.value.imag:
            meaning += "; drawn as if its shape swung"
        elif self.value.real:
            meaning += f"; drawn without {'growth' if self.value.real > 0 else 'decay'}"
        shape = tuple(shape_cells(self.shape, coordinates))
        return self.picture(swinging, facts, shares=self._shares_by_part(), shape=shape, note=meaning, is_zero=not self.value)

    def _shares_by_part(self) -> tuple[Share, ...]:
        """(part, kinetic share, strain share) of every part with either, in descending order; None for a missing one."""
        kinetic, strain = self.shares.kinetic or {}, self.shares.strain or {}
        rows = ((name, kinetic.get(name), strain.get(name)) for name in dict.fromkeys((*kinetic, *strain)))
        return tuple(sorted(rows, key=lambda row: descending(max(abs(row[1] or 0.0), abs(row[2] or 0.0)))))

    def data(self) -> dict:
        size, shape, shares = abs(self.value), self.shape, self.shares
        frequency = size if self.value.imag else None
        return {
            "number": self.number,
            "kind": self.cells["kind"],
            "meaning": self.cells["meaning"],
            "real": self.value.real,
            "imaginary": self.value.imag,
            "frequency_hz": None if frequency is None else frequency / (2 * np.pi),
            "angular_frequency": frequency,
            "damping_ratio": None if frequency is None else -self.value.real / size + 0.0,
            "multiplicity": self.multiplicity,
            "shape_of_zero": None if self.place is None else self.place + 1,
            "shape": None if shape is None else {"real": shape.real, "imaginary": shape.imag},
            "kinetic_shares": shares.kinetic if shares else None,
            "strain_shares": shares.strain if shares else None,
        }


class ModalAnalysis(Analysis):
    """List the modes: frequencies, damping, meaning, shares of kinetic and strain energy, shape.

    No motion is solved for, so that neither a start nor forces matter; a page is written only with --page.
    """

    name = "modes"
    writes = False
    handles_delays = True

    def __init__(self, scene: SceneData):
        self.scene = scene
        self.system = scene.equations.system  # None where A(s) was given by coefficients, whose physical meaning is unknown
        self.coordinates = scene.equations.coordinates

    @classmethod
    def solve(cls, scene: SceneData, settings: Table | None = None) -> Answer:
        """The answer of any scene; a page needs mass, damping and stiffness."""
        self, robot = cls(scene), scene.equations.robot_scene
        masses = self.effective_masses
        tables = (masses.table(),) if masses else ()
        return cls.of(
            scene,
            tables=(*(posture_tables(robot)[:1] if robot else ()), self.table(), *tables),
            notices=self.notices,
            data={
                "source": scene.table.source,
                **(posture_json(robot) if robot else {}),
                "coordinates": self.coordinates.to_list(),
                "modes": [line.data() for line in self.lines],
                **({"effective_masses": masses.to_dict()} if masses else {}),
            },
            texts=tuple(self._texts()),
            most_rows=None,
            on_page=lambda: {
                "animation": self.shapes(),
                "tables": (*tables, *influence_tables(scene)),
                "facts": tuple(self._facts()),
            },
        )

    @cached_property
    def lines(self) -> tuple[ModeLine, ...]:
        """One line for each shape, and one for each eigenvalue without shapes, in the order of the eigenvalues."""
        result = Result(self.scene)
        cells = result.eigenvalue_rows
        if self.system is None:
            zeros = enumerate(zip(cells, result.finite_pair.zeros), 1)
            return tuple(ModeLine(number, row, complex(zero.value), zero.multiplicity) for number, (row, zero) in zeros)
        lines: list[ModeLine] = []
        for row, mode in zip(cells, result.modes):
            count = mode.shapes.shape[1]
            for place in range(count) if count else (None,):
                several = f"{place + 1} of {count}" if count > 1 else ""
                times = several if count == mode.multiplicity else f"{mode.multiplicity}, {several}"
                own = row | ({"multiplicity": times} if several else {})
                lines.append(ModeLine(len(lines) + 1, own, complex(mode.eigenvalue), mode.multiplicity, mode, place))
        return tuple(lines)

    @cached_property
    def effective_masses(self) -> EffectiveMasses | None:
        """Effective masses of a robot under motions of its base along x, y, z; None without oscillating, orthogonal modes."""
        robot = self.scene.equations.robot_scene
        if robot is None or any(notice.kind is NoticeKind.UNSYMMETRIC for notice in robot.system.notices):
            return None
        masses = robot.system.effective_masses()
        return masses if len(masses.frequencies_hz) else None

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Growth, removed rows, and doubts about the modes."""
        unused = self.scene.notices
        if self.system is None:
            return (*unused, *pair_notices(self.scene.equations.polynomial_matrix.jordan_pairs()))
        if self.system.delayed:
            return distinct(unused, self.scene.equations.form_notices, self.system.notices, Result(self.scene).modes.notices)
        of_pairs = pair_notices(self.system.position_form().polynomial_matrix.jordan_pairs())
        return distinct(unused, self.scene.equations.form_notices, self.system.notices, of_pairs)

    def table(self) -> TextTable:
        """All eigenvalues, a line for each shape."""
        rows = tuple((str(line.number), *(line.cells[column] for column in COLUMNS)) for line in self.lines)
        several = "; 1 of 2: the first of the two shapes of a double one" if any(line.among for line in self.lines) else ""
        note = f"damping: damping ratio; times: multiplicity of the eigenvalue{several}" if rows else NO_MODES
        return TextTable("Modes", ("no.", *COLUMNS.values()), rows, note)

    def _texts(self) -> Iterator[str]:
        """Each mode with its meaning, energy shares and shape, and remarks on all."""
        shapes = [line.shape for line in self.lines if line.shape is not None]
        if self.system is None:
            if meant := [f"  {line.number}  {line.cells['meaning']}" for line in self.lines if line.cells["meaning"]]:
                yield "\n".join(["Meaning", *meant])
            notes = [NO_ENERGIES]
        else:
            yield from (line.text(self.coordinates) for line in self.lines)
            by_coordinate = bool(shapes) and self.system.energy_parts.is_by_coordinate
            remarks = {SHAPES: bool(shapes), PHASES: any(map(np.iscomplexobj, shapes)), BY_COORDINATE: by_coordinate}
            notes = [text for text, holds in remarks.items() if holds]
        if notes:
            yield "\n".join(row for text in notes for row in wrap(text, WIDTH))

    def shapes(self) -> Shapes:
        """A picture for each line of the list, all with the same drawing."""
        if self.system is None:
            place = "model" if self.scene.equations.control else "model.coefficients"
            raise SceneError(
                f"{self.scene.path.name}: {place}: a page of modes needs mass, damping and stiffness; leave out --page"
            )
        swinging = ShapeDrawing(self.scene, [line.shape for line in self.lines if line.shape is not None])
        pictures = (line.picture_of_page(swinging, self.coordinates) for line in self.lines)
        return Shapes(swinging.drawing, self.coordinates.names, tuple(pictures))

    def _facts(self) -> Iterator[tuple[str, str]]:
        yield "coordinates", ", ".join(f"{name} ({unit})" for name, unit in zip(self.coordinates.names, self.coordinates.units))
        yield "shapes", "their amplitude is free"
        if self.scene.equations.robot_scene:
            yield robot_fact(self.scene.equations.robot_scene)
        if self.system.energy_parts.is_by_coordinate:
            yield "shares of energy", BY_COORDINATE


def shape_entries(shape: np.ndarray, coordinates: Coordinates) -> list[str]:
    """The largest entries with their units; with amplitude and phase where they are neither in phase nor in antiphase.

    >>> shape_entries(np.array([1.0, -0.5]), Coordinates(("cart", "crank"), ("m", "rad")))
    ['cart 1 m', 'crank -0.5 rad']
    >>> shape_entries(np.array([1.0, -0.5j]), Coordinates(("cart", "load"), ("m", "m")))
    ['cart 1 m', 'load 0.5 m at -90°']
    """
    cells = shape_cells(shape, coordinates)
    listed = [f"{name} {entry}" for name, entry in cells[:MOST_ENTRIES]]
    return listed + [f"{len(cells) - len(listed)} more"] * (len(cells) > len(listed))


def shape_cells(shape: np.ndarray, coordinates: Coordinates) -> list[tuple[str, str]]:
    """Names and amplitudes of all coordinates that move, in descending order."""
    sizes = np.abs(shape)
    moving = np.flatnonzero(sizes > noise_of(1.0, len(shape)))
    order = sorted(moving, key=lambda i: descending(float(sizes[i])))
    return [(coordinates.names[i], _entry(shape[i], coordinates.units[i])) for i in order]


def _entry(value: complex, unit: str) -> str:
    phase = round(float(np.degrees(np.angle(value))), PHASE_DIGITS)
    if abs(phase) in (0.0, 180.0):
        return with_unit(float(f"{-abs(value) if phase else abs(value):.4g}"), unit)
    return f"{with_unit(float(f'{abs(value):.4g}'), unit)} at {phase:g}°"


def _packed(label: str, entries: Iterable[str]) -> list[str]:
    """A label followed by its entries, in lines of limited length; no entry is broken."""
    lines = [f"  {label:14}"]
    for entry in (f"{entry}," for entry in entries):
        if len(lines[-1]) + 1 + len(entry) > WIDTH and lines[-1].strip():
            lines.append(" " * 16)
        lines[-1] += f" {entry}"
    return [*lines[:-1], lines[-1].removesuffix(",")]


def variants_content(scenes: Sequence[tuple[str, Facts, SceneData]], content: PageContent) -> PageContent | None:
    """A page on which each variant of a scene moves in the shape of its lowest oscillating mode."""
    lines = [(name, facts, scene, _lowest(scene)) for name, facts, scene in scenes]
    moving = [(name, facts, scene, line) for name, facts, scene, line in lines if line is not None]
    names = moving[0][2].equations.coordinates.names if moving else ()
    if len(moving) < 2 or any(scene.equations.coordinates.names != names for _, _, scene, _ in moving):
        return None
    shapes = [line.shape for *_, line in moving]
    middle = ShapeDrawing(moving[len(moving) // 2][2], shapes)
    pictures = (
        line.picture(ShapeDrawing(scene, shapes) if middle.robot else middle, facts, name) for name, facts, scene, line in moving
    )
    return replace(content, animation=Shapes(replace(middle.drawing, posing=None), names, tuple(pictures), "variant"))


def _lowest(scene: SceneData) -> ModeLine | None:
    """The oscillating mode of the lowest frequency."""
    lines = [line for line in ModalAnalysis(scene).lines if line.shape is not None and line.value.imag > 0]
    return min(lines, key=lambda line: abs(line.value), default=None)
