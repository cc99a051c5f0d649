"""Values at 0- on the free coordinates, if they obey the constraints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ...errors import InputError
from ...tolerances import noise_of

if TYPE_CHECKING:
    from .system import SparseSystem


def checked_start(system: SparseSystem, start: np.ndarray, held: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """x - x_held and x' at 0- on the free coordinates.

    Raises:
        InputError: they break a constraint: what would jump then is not followed here.
    """
    found = []
    for what, order, value, offset in (("displacement", 0, start[0], held), ("velocity", 1, start[1], np.zeros(system.size))):
        asked = system.constraint_values if order == 0 else np.zeros(len(system.constraint_values))
        A = system.constraint_matrix
        broken = A @ value - asked
        entries = np.diff(A.indptr).max(initial=1)
        largest = np.abs(value).max(initial=0.0)  # of that vector: whoever projected it on the constraints left its rounding
        size = abs(A) @ (largest + np.abs(offset)) + np.abs(asked)
        beyond = np.abs(broken) > noise_of(size, int(entries))
        if beyond.any():
            worst = int(np.argmax(np.abs(broken) * beyond))
            raise InputError(
                f'{what}: constraint "{system.constraint_names[worst]}" asks for {asked[worst]:.6g}, the values at 0- give '
                f"{asked[worst] + broken[worst]:.6g}; give values that fit, as jumps of large sparse systems are not followed"
            )
        found.append((value - offset)[system.pencil.free])
    return found[0], found[1]
