"""References are found once: what was found before for the very same data, by the same program, is read from a file."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import wraps
from pathlib import Path

import numpy as np

from mbconstrained.ground.files import replacing
from tests.benchmarks.speed.reductions import Equations

Reference = Callable[..., np.ndarray]


class Memory:
    """Where references are kept; nowhere until a folder is given."""

    def __init__(self):
        self.folder: Path | None = None

    def __call__(self, find: Reference) -> Reference:
        """The same function, which remembers."""

        @wraps(find)
        def found(equations: Equations, *arrays: np.ndarray) -> np.ndarray:
            if self.folder is None:
                return find(equations, *arrays)
            given = (equations.S, equations.E, equations.start, equations.b, *arrays)
            path = self.folder / f"{find.__name__}-{fingerprint(find, given)}.npy"
            if not path.exists():
                self.folder.mkdir(parents=True, exist_ok=True)
                with replacing(path) as beside, beside.open("wb") as file:
                    np.save(file, find(equations, *arrays))
            return np.load(path)

        return found


def fingerprint(find: Reference, arrays) -> str:
    """Of the data to the last bit, and of the file in which the function stands."""
    digest = hashlib.sha256(Path(find.__code__.co_filename).read_bytes())
    for array in map(np.asarray, arrays):
        digest.update(str((array.shape, array.dtype)).encode())
        for part in _parts(array):
            digest.update(part)
    return digest.hexdigest()[:24]


def _parts(array: np.ndarray) -> list[bytes]:
    """Long doubles in two halves: between their numbers there are bytes that mean nothing."""
    if array.dtype == object:
        return [str([str(value) for value in array.ravel()]).encode()]
    upper = array.astype(float)
    return [upper.tobytes(), (array - upper).astype(float).tobytes()]


memory = Memory()
