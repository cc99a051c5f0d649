"""Parts as data for the page: each mesh is stored once, however many parts show it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .packing import packed
from .parts import Part


@dataclass(frozen=True)
class Meshes:
    """The meshes met so far; two of the same numbers are one."""

    data: list[dict] = field(default_factory=list)
    known: dict[tuple[str, str], int] = field(default_factory=dict)

    def number(self, part: Part) -> int:
        """The place of the part's mesh in the data."""
        texts = packed(part.vertices), packed(part.faces, "<u4")
        if texts not in self.known:
            self.known[texts] = len(self.data)
            self.data.append({"vertices": texts[0], "faces": texts[1]})
        return self.known[texts]


def parts_data(parts: tuple[Part, ...], color: str, meshes: Meshes) -> list[dict]:
    """The parts that show something; those without a colour have that of the body."""
    shown = [part for part in parts if part.opacity > 0 and part.corners.size]
    return [
        {
            "kind": part.kind,
            "size": list(part.size),
            "matrix": _column_by_column(part.placement),
            "color": part.color or color,
            "opacity": part.opacity,
            "mesh": meshes.number(part) if part.kind == "mesh" else None,
        }
        for part in shown
    ]


def _column_by_column(matrix: np.ndarray) -> list[float]:
    return [float(f"{number:.9g}") for number in matrix.T.ravel()]
