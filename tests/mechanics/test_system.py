"""MechanicalSystem at the door."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained import InputError
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import two_masses


def test_matrices_are_copied_and_frozen():
    mass = np.eye(2)
    system = MechanicalSystem(mass)
    mass[0, 0] = 9.0
    assert system.mass[0, 0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        system.mass[0, 0] = 9.0


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"mass": None}, "mass: a mechanical system needs a mass matrix"),
        ({"mass": np.zeros((0, 0))}, "mass: found no entries"),
        ({"mass": np.ones((2, 3))}, "mass: expected a square matrix, found 2 x 3"),
        ({"mass": [1.0, 2.0]}, "mass: expected shape any x any, found 2"),
        ({"mass": np.eye(2), "stiffness": np.eye(3)}, "stiffness: expected shape 2 x 2, found 3 x 3"),
        ({"mass": np.eye(2), "damping": [[0, np.inf], [0, 0]]}, r"damping: the entry at \(0, 1\) is inf"),
        ({"mass": np.eye(2), "names": ["a", "a"]}, 'the name "a" is used twice'),
        ({"mass": np.eye(2), "units": {"x3": "m"}}, 'units: there is no coordinate "x3"'),
        ({"mass": np.eye(2), "units": ["m"]}, "units: 1 given for 2 coordinates"),
        ({"mass": np.eye(2), "force": [1.0]}, "force: expected shape 2, found 1"),
        ({"mass": np.eye(2), "force": mb.step([1.0])}, "force: found 1 row; expected one for each of the 2 coordinates"),
    ],
)
def test_wrong_input_is_named(arguments, message):
    with pytest.raises(InputError, match=message):
        MechanicalSystem(**arguments)


def test_contradictory_rows_are_refused_at_once():
    with pytest.raises(mb.ContradictoryConstraints, match="make the values agree or take one of the rows out"):
        MechanicalSystem(np.eye(2), constraints=[Constraint([1, -1]), Constraint([1, -1], value=1.0)])


def test_the_level_in_force_is_printed():
    assert repr(two_masses("velocity")) == "MechanicalSystem(3 coordinates, 1 constraint row at velocity level)"
    assert repr(MechanicalSystem([[1.0]])) == "MechanicalSystem(1 coordinate)"


def test_starts_by_name():
    system = two_masses()
    by_name = system.solve({"x1": 0.8, "q1": 1.2, "q2": 2}, {"q1": 0.1})
    assert np.array_equal(by_name.initial, [[0.8, 1.2, 2.0], [0.0, 0.1, 0.0]])
    with pytest.raises(InputError, match='displacement: there is no coordinate "hook"'):
        system.solve({"hook": 1.0})
    with pytest.raises(InputError, match="velocity of q1: expected shape a single number"):
        system.solve(velocity={"q1": [1, 2]})


def test_entries_within_their_uncertainty_are_no_stiffness():
    # a free body whose stiffness is what is left of a sum that cancelled: 1e-13 N/m, known to 1e-12 N/m
    known = MechanicalSystem([[1.0]], stiffness=[[1e-13]])
    unknown = MechanicalSystem([[1.0]], stiffness=[[1e-13]], uncertainty={"stiffness": [[1e-12]]})
    assert [mode.kind for mode in known.modes()] == ["oscillation"]
    assert [(mode.kind, mode.multiplicity) for mode in unknown.modes()] == [("rigid body", 2)]


def test_rows_within_their_uncertainty_are_dependent():
    rows = [[1.0, 2.0, 0.0], [1.0, 2.0, 1e-14]]
    told = MechanicalSystem(np.eye(3), constraints=[Constraint(rows, uncertainty=np.full((2, 3), 1e-14))])
    assert len(told.rows) == 1 and len(MechanicalSystem(np.eye(3), constraints=[Constraint(rows)]).rows) == 2


@pytest.mark.parametrize(
    "uncertainty, word",
    [({"mas": np.eye(1)}, 'did you mean "mass"'), ({"mass": np.eye(2)}, "expected shape 1 x 1"), ({"mass": [[np.nan]]}, "finite")],
)
def test_uncertainty_that_makes_no_sense_is_refused(uncertainty, word):
    with pytest.raises(InputError, match=word):
        MechanicalSystem([[1.0]], uncertainty=uncertainty)
