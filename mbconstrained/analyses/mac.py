"""The modal assurance criterion: which mode of one scene is which mode of another."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from ..ground.display import TextTable, number_text
from ..ground.errors import InputError
from ..ground.notices import Notice, NoticeKind, distinct
from ..page.content import Cells, Plot
from ..scene.file import at
from ..scene.run.scene import read_scene
from ..scene.schema.entry_types import Table, Text
from .base import Analysis, Answer

if TYPE_CHECKING:
    from ..scene.run.scene import Scene

#: Modes with a criterion below this are not the same mode (Ewins, Modal Testing, section 5.3.2).
SAME_MODE = 0.9

#: Modes of either scene in the plot.
MOST_MODES = 40


class ModesOfTwoScenes(Table):
    """The modes of another scene, compared with those of this one."""

    other: Text = Field(description="The other scene file, a .toml.")


class ModalAssurance(Analysis):
    """The modal assurance criterion of the mode shapes of two scenes, in the coordinates that both have.

        MAC_ij = |a_i^H b_j|^2 / ((a_i^H a_i) (b_j^H b_j))

    1 for the same shape, 0 for orthogonal ones (Allemang and Brown 1982). Each mode of the scene is paired with the mode of the other
    one that has the largest criterion. Writes NAME.mac.html, .csv and .npz.
    """

    name = "mac"
    settings = ModesOfTwoScenes

    @classmethod
    def solve(cls, scene: Scene, settings: ModesOfTwoScenes | None) -> Answer:
        with at(scene.file_name, "mac"):
            if settings is None:
                raise InputError("there is no other scene; give it as --other SCENE")
            other = read_scene(settings.other)
            common = [name for name in scene.equations.coordinates.names if name in other.equations.coordinates.names]
            if not common:
                raise InputError(f"{scene.name} and {other.name} have no coordinate in common; give equal names to equal motions")
            (f, A), (g, B) = (_oscillations(one, common) for one in (scene, other))
        mac = modal_assurance(A, B)
        partners = mac.argmax(axis=1)
        rows = [
            (str(i + 1), number_text(f[i]), str(j + 1), number_text(g[j]), f"{100 * (g[j] / f[i] - 1):+.3g} %", f"{mac[i, j]:.4f}")
            for i, j in enumerate(partners.tolist())
        ]
        columns = ("mode", f"{scene.name} (Hz)", "mode", f"{other.name} (Hz)", "change", "MAC")
        doubts = [i + 1 for i, j in enumerate(partners) if mac[i, j] < SAME_MODE]
        text = f"no mode of {other.name} has the shape of mode {', '.join(map(str, doubts))}: the criterion is below {SAME_MODE:g}"
        own = (Notice(NoticeKind.ACCURACY, text),) if doubts else ()

        def plots() -> Iterator[Plot]:
            shown, texts = mac[:MOST_MODES, :MOST_MODES], []
            for i, row in enumerate(shown):
                name = f"mode {i + 1} ({number_text(f[i])} Hz)"
                texts.append([f"{name} and {j + 1} ({number_text(g[j])} Hz): {value:.4f}" for j, value in enumerate(row)])
            across, up = (np.arange(count + 1) + 0.5 for count in shown.shape[::-1])
            yield Plot(
                f"modal assurance criterion with the modes of {other.name}", "", across, (), across_unit="", variable=f"mode of {other.name}",
                quantity=f"mode of {scene.name}", cells=Cells(across, up, shown, texts), is_large=True,
            )  # fmt: skip

        arrays = {"frequencies_hz": f, "other_frequencies_hz": g, "mac": mac, "coordinates": np.array(common)}
        shapes = {f"{other.name}, {number_text(g[j])} Hz, mode {j + 1}": mac[:, j] for j in range(len(g))}
        return cls.of(
            scene,
            title=f"{scene.title} and {other.title}",
            facts=(("coordinates", ", ".join(common)),),
            tables=(TextTable("Modes of both scenes", columns, tuple(rows)),),
            notices=distinct(scene.notices, other.notices, own),
            data={**arrays, "pairs": partners + 1},
            plots=plots,
            columns=lambda: {"": {"frequency (Hz)": f, **shapes}},
            arrays=lambda: arrays,
        )


def modal_assurance(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """MAC of the columns of A (n, p) and B (n, q), shape (p, q); 0 of shapes that vanish in the common coordinates.

    >>> modal_assurance(np.array([[1.0, 1.0], [1.0, -1.0]]), np.array([[2.0], [2.0]])).round(12).ravel().tolist()
    [1.0, 0.0]
    """
    sizes = np.outer(np.linalg.norm(A, axis=0) ** 2, np.linalg.norm(B, axis=0) ** 2)
    return np.divide(np.abs(A.conj().T @ B) ** 2, sizes, out=np.zeros(sizes.shape), where=sizes > 0)


def _oscillations(scene: Scene, common: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies (Hz) of the oscillating modes, ascending, and their shapes in the common coordinates, one a column."""
    system = scene.equations.system
    if system is None:
        raise InputError(f"{scene.name}: modes belong to models with mass and stiffness")
    modes = system.modes()
    if not len(modes.frequencies_hz):
        raise InputError(f"{scene.name}: nothing oscillates")
    return modes.frequencies_hz, modes.shapes[[system.names.index(name) for name in common]]
