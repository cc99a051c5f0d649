"""Constraint rows at the door: shapes, levels, values, names, units."""

import numpy as np
import pytest

from mbconstrained import InputError
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.system import MechanicalSystem


def test_one_row_or_several():
    assert Constraint([1, -1]).rows.shape == (1, 2)
    several = Constraint([[1, -1, 0], [0, 1, -1]], value=[0.5, 2])
    assert several.rows.shape == (2, 3)
    assert several.values.tolist() == [0.5, 2.0]
    assert Constraint([[1, -1, 0], [0, 1, -1]], value=3).values.tolist() == [3.0, 3.0]


def test_wrong_input_is_named():
    with pytest.raises(InputError, match="found the level 'speed'; expected one of position, velocity, acceleration"):
        Constraint([1, -1], level="speed")
    with pytest.raises(InputError, match='did you mean "velocity"'):
        Constraint([1, -1], level="velosity")
    with pytest.raises(InputError, match=r"found an array of shape \(1, 1, 2\)"):
        Constraint([[[1, -1]]])
    with pytest.raises(InputError, match="constraint value: found shape .3,.; expected a number, or one for each of the 1 rows"):
        Constraint([1, -1], value=[1, 2, 3])
    with pytest.raises(InputError, match="every entry must be a finite number"):
        Constraint([1, np.nan])
    with pytest.raises(InputError, match="2 names given for 1"):
        Constraint([1, -1], names=["a", "b"])


def test_rows_get_names_and_units_from_the_system():
    system = MechanicalSystem(
        np.eye(3),
        constraints=[Constraint([1, -1, 0]), Constraint([0, 1, -0.1]), Constraint([0, 0, 1], level="velocity", names="shaft")],
        names=["cart", "rack", "pinion"],
        units={"pinion": "rad"},
    )
    assert [(row.name, row.level, row.unit) for row in system.rows] == [
        ("constraint 1", "position", "m"),
        ("constraint 2", "position", "m"),  # the radius turns an angle into a length
        ("shaft", "velocity", "rad"),
    ]


def test_rows_must_fit_the_system():
    with pytest.raises(InputError, match=r"found 3 entries in a row; expected one for each of the 2 coordinates \(a, b\)"):
        MechanicalSystem(np.eye(2), constraints=Constraint([1, 0, 0]), names=["a", "b"])
    with pytest.raises(InputError, match='the name "tie" is used twice'):
        MechanicalSystem(np.eye(2), constraints=[Constraint([1, 0], names="tie"), Constraint([0, 1], names="tie")])
    with pytest.raises(InputError, match="found list; expected mb.Constraint"):
        MechanicalSystem(np.eye(2), constraints=[[1, 0]])


def test_none_is_no_constraint_and_a_unit_is_checked():
    assert MechanicalSystem([[1.0]], constraints=None).rows == ()
    with pytest.raises(
        InputError, match='unit of the constraint: found .kg.; expected "m", "rad", "1", or "C", "A", "V" of circuits'
    ):
        Constraint([1.0], unit="kg")
    with pytest.raises(InputError, match="unit of b: found .kg.; expected"):
        MechanicalSystem(np.eye(2), names=["a", "b"], units=["m", "kg"])
