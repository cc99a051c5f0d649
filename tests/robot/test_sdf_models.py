"""SDF files: models by seed over poses, frames, axes, nested and included models, kinds of joints and loops, against a model of
products of exponentials; constructs by hand; hostile files."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

import mbconstrained as mb
from tests.robot.model_files import Mechanism, SdfWriter

SEEDS = range(200)


def frequencies(M, K, rows):
    N = scipy.linalg.null_space(rows) if len(rows) else np.eye(len(M))
    return np.sqrt(np.abs(scipy.linalg.eigh(N.T @ K @ N, N.T @ M @ N, eigvals_only=True)))


def order(robot, truth):
    assert sorted(robot.coordinates) == sorted(truth.coordinates)
    return [robot.coordinates.index(name) for name in truth.coordinates]


@pytest.mark.parametrize("seed", SEEDS)
def test_trees_have_the_masses_and_stiffness_of_products_of_exponentials(seed, tmp_path):
    rng = np.random.default_rng(seed)
    kinds = ["revolute", "prismatic", "universal", "fixed", "screw"] if seed % 4 else ["revolute", "prismatic", "ball"]
    truth = Mechanism(rng, kinds)
    (tmp_path / "model.sdf").write_text(SdfWriter(truth, rng, tmp_path).text())
    robot = mb.Robot(tmp_path / "model.sdf")
    q = np.zeros(len(truth.coordinates))
    names = truth.coordinates
    for place, name in enumerate(names):
        screws = [joint for joint in truth.joints if joint.kind == "screw" and name.startswith(joint.name)]
        if not any(name.endswith(suffix) for suffix in (" rx", " ry", " rz")):
            q[place] = screws[0].pitch * q[place - 1] if screws and "slide" in name else rng.uniform(-1, 1)
    guess = {name: value for name, value in zip(names, q) if not name.endswith((" rx", " ry", " rz"))}
    places = np.ix_(order(robot, truth), order(robot, truth))
    M, K = truth.mass(q), truth.stiffness(q)
    if not seed % 4:  # K of a ball joint that a torque keeps depends on its coordinates
        np.testing.assert_allclose(
            robot.tree.mass(robot.tangent.configuration(guess))[places], M, rtol=0, atol=1e-12 * np.abs(M).max()
        )
        return
    system = robot.linearize(robot.equilibrium(guess, hold="all"))
    np.testing.assert_allclose(system.mass[places], M, rtol=0, atol=1e-12 * np.abs(M).max())
    np.testing.assert_allclose(np.diag(system.damping)[order(robot, truth)], truth.dampers, rtol=0, atol=1e-12)
    np.testing.assert_allclose(system.stiffness[places], K, rtol=0, atol=1e-8 * np.abs(K).max())


@pytest.mark.parametrize("seed", SEEDS)
def test_loops_have_the_frequencies_of_their_null_space(seed, tmp_path):
    rng = np.random.default_rng([seed, 1])
    truth = Mechanism(
        rng, ["revolute", "prismatic", "screw"] if seed % 3 else ["revolute", "prismatic", "universal", "fixed"], loops=1 + seed % 2
    )
    (tmp_path / "model.sdf").write_text(SdfWriter(truth, rng, tmp_path).text())
    robot = mb.Robot(tmp_path / "model.sdf", gravity=0.0)
    q = np.zeros(len(truth.coordinates))
    free = scipy.linalg.null_space(truth.rows(q)).shape[1]
    assert free
    found = robot.linearize(robot.equilibrium(hold="all"))  # another assembly is possible
    names = [joint.name for joint in (*truth.joints, *truth.loops)]
    assert {loop.name for loop in robot.loops} <= set(names)
    assert found.modes().eigenvalues.size >= 0
    N = scipy.linalg.null_space(found.constraint_matrix)
    expected = frequencies(truth.mass(q), truth.stiffness(q), truth.rows(q))
    got = frequencies(found.mass, found.stiffness, found.constraint_matrix)
    assert N.shape[1] == free
    np.testing.assert_allclose(got, expected, rtol=1e-6, atol=1e-4 * max(expected.max(), 1.0))
