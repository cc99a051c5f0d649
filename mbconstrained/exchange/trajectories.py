"""Trajectories with names and units, and the files that they are written to."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Curves:
    """Values of one kind over time.

    Attributes:
        kind: "displacement", "velocity", "acceleration", "reaction", "energy" or "output".
        names, titles, units: of the rows; a title names the quantity, e.g. "angle".
        values: shape (rows, T).
    """

    kind: str
    names: tuple[str, ...]
    titles: tuple[str, ...]
    units: tuple[str, ...]
    values: np.ndarray
