"""The modes of a scene: its eigenvalues and, for a mechanical system, shapes and energy shares."""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ....ground.errors import SceneError
from ....ground.files import Replacements
from ....ground.notices import Notice, NoticeKind, distinct
from ....response.response_notices import pair_notices
from ..result import Result
from ..scene_data import SceneData
from .mode_summary import ModeLine

if TYPE_CHECKING:
    from ....mechanics.modes import Mode
    from ....mechanics.system import MechanicalSystem
    from ....mechanics.vibration.effective_masses import EffectiveMasses


class SceneModes:
    """The modes of a scene.

    Attributes:
        scene: the scene.
        files: written files.
    """

    def __init__(self, scene: SceneData):
        self.scene = scene
        self.files: list[Path] = []

    @property
    def system(self) -> MechanicalSystem | None:
        """The mechanical system; None where A(s) was given by coefficients, whose physical meaning is unknown."""
        return self.scene.equations.system

    @cached_property
    def lines(self) -> tuple[ModeLine, ...]:
        """One line for each shape, and one for each eigenvalue without shapes, in the order of the eigenvalues."""
        result = Result(self.scene)
        cells = result.eigenvalue_rows
        if self.system is None:
            zeros = enumerate(zip(cells, result.finite_pair.zeros), 1)
            return tuple(ModeLine(number, row, complex(zero.value), zero.multiplicity) for number, (row, zero) in zeros)
        wanted = ((row | _times(mode, place), mode, place) for row, mode in zip(cells, result.modes) for place in _places(mode))
        return tuple(
            ModeLine(number, row, complex(mode.eigenvalue), mode.multiplicity, mode, place)
            for number, (row, mode, place) in enumerate(wanted, 1)
        )

    @cached_property
    def effective_masses(self) -> EffectiveMasses | None:
        """Effective masses of a robot under motions of its base along x, y, z; None without oscillating, orthogonal modes."""
        robot = self.scene.equations.robot_scene
        if robot is None or any(notice.kind is NoticeKind.UNSYMMETRIC for notice in robot.system.notices):
            return None
        masses = robot.system.effective_masses()
        return masses if len(masses.frequencies_hz) else None

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Growth, removed rows, and doubts about the modes."""
        unused = self.scene.notices
        if self.system is None:
            return (*unused, *pair_notices(self.scene.equations.polynomial_matrix.jordan_pairs()))
        of_pairs = pair_notices(self.system.position_form().polynomial_matrix.jordan_pairs())
        return distinct(unused, self.scene.equations.form_notices, self.system.notices, of_pairs)

    @property
    def is_trusted(self) -> bool:
        """False where a notice warns that the modes may be wrong."""
        return not any(notice.doubtful for notice in self.notices)

    def write_page(self, folder: Path) -> Path:
        """Write NAME.modes.html, which animates the modes, into a folder."""
        if self.system is None:
            place = "model" if self.scene.equations.control else "model.coefficients"
            raise SceneError(
                f"{self.scene.path.name}: {place}: a page of modes needs mass, damping and stiffness; leave out --page"
            )
        from ....page.html import write_page
        from .mode_pages import modes_content

        path = folder / f"{self.scene.name}.modes.html"
        folder.mkdir(parents=True, exist_ok=True)
        with Replacements() as files:
            write_page(path, modes_content(self), self.scene.table.output.viewer, files)
        self.files += files.paths
        return path


def _times(mode: Mode, place: int | None) -> dict[str, str]:
    """The cell of the multiplicity; for an eigenvalue with several shapes also the number of the shape."""
    shapes = mode.shapes.shape[1]
    if shapes < 2 or place is None:
        return {}
    among = f"{place + 1} of {shapes}"
    return {"multiplicity": among if shapes == mode.multiplicity else f"{mode.multiplicity}, {among}"}


def _places(mode: Mode) -> list[int | None]:
    return list(range(mode.shapes.shape[1])) or [None]
