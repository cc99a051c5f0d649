"""A problem is what its scene asks, and is solved from scratch each time."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.study_problem import StudyProblem, again, mechanical_problem, problem_of
from mbconstrained.polynomial import polynomial_matrix
from mbconstrained.scene.run.scene import read_scene


@pytest.mark.parametrize(
    ("example", "name"),
    [("two_masses", "reduction_of"), ("rigid_link", "jordan_pairs")],
)
def test_nothing_that_was_found_before_is_used_again(monkeypatch, example, name):
    """Reduced equations or pairs are formed anew in each run: otherwise set-up times would be those of a dictionary."""
    problem = problem_of(read_scene(f"examples/{example}.toml"))
    problem.solve()
    formed, form = [], getattr(polynomial_matrix, name)
    monkeypatch.setattr(polynomial_matrix, name, lambda *arguments: formed.append(1) or form(*arguments))
    problem.solve()
    assert formed


def test_a_mechanical_problem_is_what_its_system_solves():
    system = mb.MechanicalSystem(
        np.diag([2.0, 1.0]), stiffness=[[3, -1], [-1, 1]], constraints=[mb.Constraint([1, -1], level="velocity")], force=[0, 1]
    )
    force = mb.harmonic([1.0, 0.0], angular_frequency=2.0)
    times = np.linspace(0, 4, 9)
    problem = mechanical_problem("pair", system, times, [1, 1], None, force)
    expected = system.solve([1, 1], force=force)(times)
    assert np.array_equal(problem.solve()(times), expected)
    # the equations alone, without the system, have the same answer
    plain = StudyProblem("pair", problem.polynomial_matrix, problem.initial, problem.force, times)
    assert np.abs(plain.solve()(times) - expected).max() <= 1e-14 * np.abs(expected).max()
    assert np.array_equal(problem.at([1.0, 2.0]).solve()([1.0, 2.0]), expected[:, [2, 4]])


def test_again_keeps_all_that_a_system_was_given():
    elements = mb.ElementMatrix([[1, 0], [-1, 1]], [1e12, 1.0])
    doubt = {"mass": np.full((2, 2), 1e-9)}
    system = mb.MechanicalSystem(
        np.eye(2),
        0.1 * np.eye(2),
        elements,
        [mb.Constraint([1, 0])],
        ["a", "b"],
        static_force=[0, 2.0],
        units={"b": "rad"},
        uncertainty=doubt,
    )
    found = again(system)
    assert found is not system and found.given[0] is elements and found.names == system.names and found.units == system.units
    assert [row.name for row in found.rows] == [row.name for row in system.rows]
    assert np.array_equal(found.uncertainty[2], doubt["mass"]) and np.array_equal(found.static_force, [0, 2.0])
