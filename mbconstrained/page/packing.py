"""Arrays as short texts for the page's script: base64 of little-endian numbers."""

from __future__ import annotations

import base64

import numpy as np


def packed(array: np.ndarray, kind: str = "<f4") -> str:
    """The numbers of an array, row by row, as base64 of 4-byte floats (or of another NumPy type).

    >>> packed(np.array([[1.0, -2.0]]))
    'AACAPwAAAMA='
    """
    return base64.b64encode(np.ascontiguousarray(array, dtype=np.dtype(kind)).tobytes()).decode("ascii")
