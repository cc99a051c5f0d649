"""Data files of a scene: only those in its folder, or in folders inside it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import InputError
from ..models.matrices import read_matrix
from .units import LARGEST, LEAST, shown


def data_file(folder: Path, name: str) -> Path:
    """The path of a data file named in a scene.

    Raises:
        InputError: an absolute path, or one that leads out of the folder of the scene, also by a symbolic link.
    """
    rule = "data files must lie in the folder of the scene, or in a folder inside it"
    if not name or "\n" in name:
        raise InputError(f"found {shown(name)}; expected the name of a .npz, .mtx or .csv file")
    if Path(name).is_absolute():
        raise InputError(f"found {shown(name)}, an absolute path; {rule}")
    folder = folder.resolve()
    try:
        path = (folder / name).resolve()
    except (OSError, RuntimeError):  # Python before 3.13 has the second for a circle of links
        raise InputError(f"found {shown(name)}, which is a link that leads in a circle; name the file itself") from None
    if not path.is_relative_to(folder):
        raise InputError(f"found {shown(name)}, which leads out of the folder; {rule}")
    return path


def matrix_of(source, folder: Path) -> np.ndarray:
    """A matrix written in the scene, or read from the file that the scene names."""
    if isinstance(source, np.ndarray):
        return source
    matrix = read_matrix(data_file(folder, source.file), source.array)
    sizes = np.abs(matrix[matrix != 0])
    if sizes.size and not (LEAST <= sizes.min() and sizes.max() <= LARGEST):
        raise InputError(f"{source.file}: entries must be 0 or of a size between {LEAST:g} and {LARGEST:g}")
    return matrix
