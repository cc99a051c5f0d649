"""Which equations and coordinates make a polynomial matrix singular."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..linalg.staircase import GENERIC
from ..tolerances import EPS, NOISE_SAFETY
from .companion import scaled_companion
from .matrix import PolynomialMatrix


def singular_message(A: PolynomialMatrix) -> tuple[str, tuple[int, ...], tuple[int, ...]]:
    """A sentence on why det A(s) = 0 for every s, with the indices of the equations and coordinates involved."""
    scaled = scaled_companion(A).coefficients
    involved_rows, involved_columns = np.zeros(A.size, bool), np.zeros(A.size, bool)
    for s in GENERIC:
        value = sum(matrix * s**power for power, matrix in enumerate(scaled))
        u, sizes, vh = np.linalg.svd(value)
        null = sizes <= NOISE_SAFETY * EPS * A.size * max(sizes[0], EPS)
        null[-1] = True  # singular at every s: the least one belongs to it
        involved_rows |= _support(u[:, null])
        involved_columns |= _support(vh[null].conj().T)
    equations, coordinates = (tuple(map(int, np.flatnonzero(side))) for side in (involved_rows, involved_columns))
    return singular_sentence([A.equations[i] for i in equations], [A.coordinates[i] for i in coordinates]), equations, coordinates


def singular_sentence(equations: Sequence[str], coordinates: Sequence[str]) -> str:
    """What is wrong with equations that depend on each other, and with coordinates that are free, and what to do."""
    return (
        f"det A(s) is zero for every s, so the motion is not determined: the equations {_quoted(equations)} are dependent or empty, "
        f"and the coordinates {_quoted(coordinates)} can move without any force. Attach what is free (by a mass, spring, damper or "
        "constraint; in a state space by an equation), or take out what is said twice."
    )


def _support(vectors) -> np.ndarray:
    size = np.abs(vectors).max(axis=1, initial=0.0)
    return size > EPS**0.5 * size.max(initial=0.0)


def _quoted(names) -> str:
    return ", ".join(f'"{name}"' for name in names)
