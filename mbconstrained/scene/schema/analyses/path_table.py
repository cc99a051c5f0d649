"""The table [path]: the positions of a point of a robot along which the command path computes its modes."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated

import numpy as np
from pydantic import Field, field_validator

from ....ground.errors import InputError
from ..entry_types import Angle, Table, Text, Vector


class PathTable(Table):
    """Straight lines from corner to corner."""

    body: Text = Field(description="A link of the URDF.")
    point: Vector = Field([0.0, 0.0, 0.0], description="Point of the body, in the link's frame.")
    corners: Annotated[list[Vector], Field(min_length=2, max_length=1000)] = Field(
        description="Places of the point in the directions of the ground: where the path starts, turns and ends."
    )
    orientation: Annotated[list[Angle], Field(min_length=3, max_length=3)] | None = Field(
        None, description="Roll, pitch, yaw of the body all along the path; left out: any."
    )
    points: int = Field(21, ge=2, le=1001, description="Number of positions, evenly spaced along the path, both ends included.")

    @field_validator("corners")
    @classmethod
    def _distinct(cls, corners):
        if any(first == second for first, second in pairwise(corners)):
            raise InputError("found the same place twice in succession; expected corners that differ")
        return corners

    @property
    def places(self) -> np.ndarray:
        """Positions (m), shape (points, 3)."""
        corners = np.array(self.corners)
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        return np.array([np.interp(np.linspace(0.0, lengths[-1], self.points), lengths, column) for column in corners.T]).T
