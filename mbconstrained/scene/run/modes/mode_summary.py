"""The modes of a scene as text of 80 columns and as plain data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Protocol

import numpy as np

from ....ground.display import WIDTH, TextTable, with_unit
from ....ground.notices import Notice
from ....ground.tolerances import noise_of
from ...build.robot_model import posture_json, posture_tables
from ...quantities.coordinates import Coordinates
from ..report.summary import notices_json
from ..scene_data import SceneData

if TYPE_CHECKING:
    from ....mechanics.energy import EnergyShares
    from ....mechanics.modes import Mode
    from ....mechanics.system import MechanicalSystem
    from ....mechanics.vibration.effective_masses import EffectiveMasses

MOST_ENTRIES = 6  # listed entries of a shape or of shares of energy; JSON has all
LEAST_SHARE = 0.0005  # what is less is printed as 0.0 %
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


@dataclass(frozen=True)
class ModeLine:
    """One line of the list of modes: an eigenvalue, or one of its shapes where it has any.

    Attributes:
        number: from 1 on, the order of the list.
        cells: texts by column (``Modes.table``).
        value, multiplicity: the eigenvalue in 1/s.
        mode: its meaning; None where A(s) was given by coefficients.
        place: index of the shape among those of the eigenvalue, from 0; None where it has none.
    """

    number: int
    cells: dict[str, str]
    value: complex
    multiplicity: int
    mode: Mode | None = None
    place: int | None = None

    @property
    def shape(self) -> np.ndarray | None:
        """The shape, (n,), its largest entry 1."""
        return None if self.place is None else self.mode.shapes[:, self.place]

    @property
    def shares(self) -> EnergyShares | None:
        """The energies of the shape by part."""
        return None if self.place is None else self.mode.shares[self.place]

    @property
    def shape_count(self) -> int:
        """Number of shapes of the eigenvalue."""
        return self.mode.shapes.shape[1] if self.mode else 0

    @property
    def name(self) -> str:
        """Kind of the mode, with the number of the shape among several."""
        return self.cells["kind"] + self._among

    @property
    def heading(self) -> str:
        """Meaning of the mode, with its number."""
        return f"Mode {self.number}{self._among}: {self.cells['meaning']}"

    @property
    def _among(self) -> str:
        return f" (shape {self.place + 1} of {self.shape_count})" if self.shape_count > 1 else ""


class ListedModes(Protocol):
    """The modes of a scene, attributes as of ``SceneModes``."""

    scene: SceneData
    files: list[Path]

    @property
    def system(self) -> MechanicalSystem | None: ...

    @property
    def lines(self) -> tuple[ModeLine, ...]: ...

    @property
    def effective_masses(self) -> EffectiveMasses | None: ...

    @property
    def notices(self) -> tuple[Notice, ...]: ...

    @property
    def is_trusted(self) -> bool: ...


def blocks(modes: ListedModes) -> list[str | TextTable]:
    """Printed blocks: the table of all modes, then each with its energy shares and shape."""
    scene = modes.scene
    heading = "\n".join(line for text in (scene.title, scene.table.source) for line in wrap(text, WIDTH))
    robot = scene.equations.robot_scene
    joints = posture_tables(robot)[:1] if robot else []
    return [heading, *joints, table(modes), *mass_tables(modes), *_details(modes), *_notes(modes), *_notices(modes), *_files(modes)]


def mass_tables(modes: ListedModes) -> list[TextTable]:
    """The effective modal masses of a robot; none for other models."""
    return [modes.effective_masses.table()] if modes.effective_masses else []


def table(modes: ListedModes) -> TextTable:
    """Table of all eigenvalues, a line for each shape."""
    rows = tuple((str(line.number), *(line.cells[column] for column in COLUMNS)) for line in modes.lines)
    several = "; 1 of 2: the first of the two shapes of a double one" if any(line.shape_count > 1 for line in modes.lines) else ""
    note = f"damping: damping ratio; times: multiplicity of the eigenvalue{several}" if rows else NO_MODES
    return TextTable("Modes", ("no.", *COLUMNS.values()), rows, note)


def _details(modes: ListedModes) -> list[str]:
    if modes.system is None:
        meant = [f"  {line.number}  {line.cells['meaning']}" for line in modes.lines if line.cells["meaning"]]
        return ["\n".join(["Meaning", *meant])] if meant else []
    return [_detail(line, modes.scene.equations.coordinates) for line in modes.lines]


def _detail(line: ModeLine, coordinates: Coordinates) -> str:
    """One mode: its meaning, its energy shares, its shape."""
    text = wrap(line.heading, WIDTH, subsequent_indent="  ")
    if line.shape is not None:
        text += _packed("kinetic energy", share_entries(line.shares.kinetic))
        text += _packed("strain energy", share_entries(line.shares.strain))
        text += _packed("shape", shape_entries(line.shape, coordinates))
    return "\n".join(text)


def share_entries(shares: Mapping[str, float] | None, most: int = MOST_ENTRIES) -> list[str]:
    """The largest shares in per cent, and the sum of the others.

    >>> share_entries({"cart": 0.25, "load": 0.75}), share_entries(None)
    (['load 75.0 %', 'cart 25.0 %'], ['none'])
    """
    if shares is None:
        return ["none"]
    largest = sorted(shares.items(), key=lambda entry: descending(entry[1]))
    listed = [(name, share) for name, share in largest[:most] if abs(share) >= LEAST_SHARE]
    rest = [share for _, share in largest[len(listed) :]]
    others = [f"{len(rest)} more {_percent(sum(rest))}"] if np.abs(rest).sum() >= LEAST_SHARE else []
    return [f"{name} {_percent(share)}" for name, share in listed] + others


def descending(value: complex) -> float:
    """A sort key that keeps the order of values that differ by rounding errors only."""
    return -float(f"{abs(value):.9g}")


def _percent(share: float) -> str:
    return f"{round(100 * share, 1) + 0.0:.1f} %"


def shape_entries(shape: np.ndarray, coordinates: Coordinates) -> list[str]:
    """The largest entries with their units; with amplitude and phase where they are neither in phase nor in antiphase.

    >>> shape_entries(np.array([1.0, -0.5]), Coordinates(("cart", "crank"), ("m", "rad")))
    ['cart 1 m', 'crank -0.5 rad']
    >>> shape_entries(np.array([1.0, -0.5j]), Coordinates(("cart", "load"), ("m", "m")))
    ['cart 1 m', 'load 0.5 m at -90 deg']
    """
    cells = shape_cells(shape, coordinates)
    listed = [f"{name} {entry}" for name, entry in cells[:MOST_ENTRIES]]
    return listed + [f"{len(cells) - len(listed)} more"] * (len(cells) > len(listed))


def shape_cells(shape: np.ndarray, coordinates: Coordinates) -> list[tuple[str, str]]:
    """Names and amplitudes of all coordinates that move, in descending order."""
    moving = np.flatnonzero(np.abs(shape) > noise_of(1.0, len(shape)))
    order = sorted(moving, key=lambda i: descending(shape[i]))
    return [(coordinates.names[i], _entry(shape[i], coordinates.units[i])) for i in order]


def _entry(value: complex, unit: str) -> str:
    phase = round(float(np.degrees(np.angle(value))), PHASE_DIGITS)
    if abs(phase) in (0.0, 180.0):
        return with_unit(float(f"{-abs(value) if phase else abs(value):.4g}"), unit)
    return f"{with_unit(float(f'{abs(value):.4g}'), unit)} at {phase:g} deg"


def _packed(label: str, entries: Iterable[str]) -> list[str]:
    """A label followed by its entries, in lines of limited length; no entry is broken."""
    lines = [f"  {label:14}"]
    for entry in (f"{entry}," for entry in entries):
        if len(lines[-1]) + 1 + len(entry) > WIDTH and lines[-1].strip():
            lines.append(" " * 16)
        lines[-1] += f" {entry}"
    return [*lines[:-1], lines[-1].removesuffix(",")]


def _notes(modes: ListedModes) -> list[str]:
    if modes.system is None:
        texts = [NO_ENERGIES]
    else:
        shapes = [line.shape for line in modes.lines if line.shape is not None]
        texts = [SHAPES] if shapes else []
        texts += [PHASES] if any(map(np.iscomplexobj, shapes)) else []
        texts += [BY_COORDINATE] if shapes and modes.system.energy_parts.is_by_coordinate else []
    return ["\n".join(row for text in texts for row in wrap(text, WIDTH))] if texts else []


def _notices(modes: ListedModes) -> list[str]:
    lines = [line for notice in modes.notices for line in wrap(f"  {notice}", WIDTH, subsequent_indent="    ")]
    return ["\n".join(["Notices", *lines])] if lines else []


def _files(modes: ListedModes) -> list[str]:
    return ["Written\n" + "\n".join(f"  {path}" for path in modes.files)] if modes.files else []


def as_json(modes: ListedModes) -> dict:

    scene = modes.scene
    return {
        "title": scene.title,
        "source": scene.table.source,
        **(posture_json(scene.equations.robot_scene) if scene.equations.robot_scene else {}),
        "coordinates": scene.equations.coordinates.as_json(),
        "modes": [_line(line) for line in modes.lines],
        **({"effective_masses": modes.effective_masses.as_json()} if modes.effective_masses else {}),
        "notices": notices_json(modes.notices),
        "trusted": modes.is_trusted,
        "files": [str(path) for path in modes.files],
    }


def _line(line: ModeLine) -> dict:
    size, shape = abs(line.value), line.shape
    frequency = size if line.value.imag else None
    return {
        "number": line.number,
        "kind": line.cells["kind"],
        "meaning": line.cells["meaning"],
        "real": line.value.real,
        "imaginary": line.value.imag,
        "frequency_hz": None if frequency is None else frequency / (2 * np.pi),
        "angular_frequency": frequency,
        "damping_ratio": None if frequency is None else -line.value.real / size + 0.0,
        "multiplicity": line.multiplicity,
        "shape_of_zero": None if line.place is None else line.place + 1,
        "shape": None if shape is None else {"real": shape.real.tolist(), "imaginary": shape.imag.tolist()},
        "kinetic_shares": line.shares.kinetic and dict(line.shares.kinetic) if line.shares else None,
        "strain_shares": line.shares.strain and dict(line.shares.strain) if line.shares else None,
    }
