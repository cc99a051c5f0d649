"""Rotations: vectors, quaternions and matrices say the same thing, as scipy does."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbconstrained.page.drawing import after, matrix_of, quaternions_of, vector_of

AXES = np.random.default_rng(3).standard_normal((20, 3))
ANGLES = (0.0, 1e-9, 0.5, 2.5, 2.8, 3.1, np.pi - 1e-9)


@pytest.mark.parametrize("angle", ANGLES)
def test_vectors_and_matrices_are_those_of_scipy(angle):
    for vector in angle * AXES / np.linalg.norm(AXES, axis=1)[:, None]:
        assert matrix_of(vector) == pytest.approx(Rotation.from_rotvec(vector).as_matrix(), abs=1e-14)
        assert vector_of(matrix_of(vector)) == pytest.approx(vector, abs=1e-12)


def test_one_rotation_after_another():
    first, second = (Rotation.from_rotvec(axes) for axes in (AXES[:10], AXES[10:]))
    found = after(*(quaternions_of(each.as_rotvec().T) for each in (second, first)))
    assert np.abs((found.T * (second * first).as_quat()).sum(axis=1)) == pytest.approx(1.0)  # q and -q are one orientation
