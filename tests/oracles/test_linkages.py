"""The referee of the robots is checked before it judges: closed forms, SymPy, and the forces that pinocchio's tree gives."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from tests.oracles import linkages
from tests.robot.linkages import BUILDERS, TABLE, given, known, known_frequencies, null_space

SYMPY = json.loads(Path(__file__).with_name("linkages_sympy.json").read_text())
RIGID = ("rx", "ry", "rz")


@pytest.fixture(autouse=True)
def all_digits():
    """The precision of mpmath is one for all modules, and others may have changed it."""
    with linkages.mp.workdps(80):
        yield


def test_closed_forms():
    linkages.closed_forms()


@pytest.mark.parametrize("name", ["four-bar", "sagging string"])
def test_table_is_what_the_generator_finds(name):
    assert linkages.known(linkages.linkage(name)) == known(name)


@pytest.mark.parametrize("name", SYMPY)
def test_lagranges_method_of_sympy_agrees(name):
    (own,) = known(name)["angular_frequencies"]
    assert abs(linkages.mpf(own) - linkages.mpf(SYMPY[name])) < linkages.mpf(10) ** -29


@pytest.mark.parametrize("name", [name for name in TABLE if "flexible" not in name])
def test_differences_of_forces_agree(name):
    # tests/models/robot/reference.py, from the URDF: multipliers, Jacobians, everything that the table does without
    reference = BUILDERS[name](given(name)).reference()
    posture = {key: float(x) for key, x in known(name)["posture"].items()}
    base = None
    if reference.base == "free":
        turn = pin.Quaternion(pin.exp3(np.array([posture[f"base {axis}"] for axis in RIGID])))
        base = [*(posture[f"base {axis}"] for axis in "xyz"), *turn.coeffs()]
    if name == "four-bar with a pin":
        posture["j4"] = posture["j3"] - posture["j1"] - posture["j2"]
    q = reference.configuration(posture, base)
    J, load = reference.rows(q), reference.applied(q)
    pull = np.linalg.lstsq(J.T, -load, rcond=1e-9)[0]
    N = null_space(J) if len(J) else np.eye(len(load))
    assert np.abs(reference.gaps(q)).max(initial=0) < 1e-14 and np.abs(load + J.T @ pull).max() < 1e-12
    M, K = (N.T @ matrix @ N for matrix in (reference.mass(q), reference.stiffness(q, pull)))
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(M, K)).real)
    assert np.abs(squares - known_frequencies(name) ** 2).max() <= 1e-11 * squares.max()
