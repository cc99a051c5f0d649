"""A drawing for a system of which only equations are known: every coordinate is a box on a rail of its own."""

from __future__ import annotations

import math

import numpy as np

from ...checks import names_of, real_array
from ..drawing import Body, Drawing
from .magnification import displacement_scale

PITCH, WIDTH = 0.95, 5.6  # from rail to rail, downwards and across


def coordinate_drawing(names, values=None) -> Drawing:
    """Boxes on rails, one below the other, in several columns when there are many.

    Args:
        names: r coordinate names.
        values: typical values, shape (r,) or (r, T), by which the magnification is chosen; None for 1.

    Raises:
        InputError: repeated names, values of another shape, NaN or infinity.

    >>> [body.shape for body in coordinate_drawing(["x1"], [0.01]).bodies]
    ['rail', 'box']
    """
    names = names_of(names, len(names), "drawing, names", "x")
    values = rows_of(values, len(names))
    scale = displacement_scale(dict(zip(names, values)), ())
    rows = max(6, math.ceil(1.3 * math.sqrt(len(names))))
    bodies = []
    for i, name in enumerate(names):
        column, row = divmod(i, rows)
        place = (WIDTH * column, 0.0, -PITCH * row)
        rail = (place[0], 0.0, place[2] - 0.24)
        bodies.append(Body(f"rail of {name}", "rail", rail, size=(5.0, 0.3, 0.05)))
        bodies.append(Body(name, "box", place, {name: (1.0, 0.0, 0.0)}, size=(0.42, 0.42, 0.42)))
    return Drawing(tuple(bodies), scale=scale)


def rows_of(values, count: int) -> np.ndarray:
    """Typical values as an array (count, T)."""
    if values is None:
        return np.zeros((count, 1))
    values = real_array(values, "drawing, typical values")
    return real_array(values[:, None] if values.ndim == 1 else values, "drawing, typical values", shape=(count, None))
