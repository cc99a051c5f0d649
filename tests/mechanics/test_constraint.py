"""Constraint rows at the door: shapes, levels, values, names, units."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained import ContradictoryConstraints, InputError
from mbconstrained.ground.tolerances import EPS
from mbconstrained.mechanics.constraints import NULL_SPACE_LIMIT, Constraint, ConstraintRow, independent_rows
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


# Dependent rows, contradictory rows, the null space and the left inverse.


def row(name, coefficients, level="position", value=0.0):
    return ConstraintRow(name, np.array(coefficients, float), level, value, "m")


def names(found):
    return [kept.name for kept in found.rows]


def test_no_rows_leave_everything_free():
    found = independent_rows([], 3)
    assert found.matrix.shape == (0, 3)
    assert (found.null_space == np.eye(3)).all()
    assert found.left_inverse.shape == (0, 3)


def test_as_many_rows_as_coordinates_leave_nothing_free():
    found = independent_rows([row("a", [1, 1]), row("b", [1, -1])], 2)
    assert found.null_space.shape == (2, 0)
    assert np.allclose(found.left_inverse @ found.matrix.T, np.eye(2), rtol=0, atol=4 * EPS)


def test_null_space_of_the_paper_example():
    # span of the columns of V in Moysis et al., Eq. 81
    found = independent_rows([row("link", [1, -1, 0])], 3)
    assert found.null_space.tolist() == [[1, 0], [1, 0], [0, 1]]
    assert found.motions == (1, 2)


def test_a_repeated_row_is_left_out_and_named():
    found = independent_rows([row("first", [1, -1, 0], value=0.5), row("again", [-2, 2, 0], value=-1.0)], 3)
    assert names(found) == ["first"]
    (notice,) = found.notices
    assert notice.kind == "redundant"
    assert notice.text.startswith('constraint "again" (position level) is redundant')
    assert '"first"' in notice.text


def test_a_sum_of_rows_is_left_out_and_only_its_parts_are_named():
    rows = [row("a", [1, -1, 0, 0]), row("b", [0, 1, -1, 0]), row("other", [0, 0, 0, 1]), row("loop", [1, 0, -1, 0])]
    found = independent_rows(rows, 4)
    assert names(found) == ["a", "b", "other"]
    assert '"a"' in found.notices[0].text and '"b"' in found.notices[0].text and '"other"' not in found.notices[0].text


def test_combinations_with_cancellation_are_still_dependent():
    random = np.random.default_rng(5)
    for _ in range(50):
        rows, factors = random.normal(size=(8, 12)), random.normal(size=7)
        rows[3] = rows[2] + 1e-4 * rows[3]
        factors[2:4] = [1e4, -1e4]
        rows[7] = factors @ rows[:7]
        found = independent_rows([row(str(i), line) for i, line in enumerate(rows)], 12)
        assert names(found) == [str(i) for i in range(7)]


@pytest.mark.parametrize("scale", [1e-12, 1.0, 1e12])
def test_the_decision_does_not_depend_on_units(scale):
    dependent = independent_rows([row("a", [1, -scale]), row("b", [3e7, -3e7 * scale])], 2)
    assert names(dependent) == ["a"]
    independent = independent_rows([row("a", [1, -scale]), row("b", [1, -scale * (1 + 1e-10)])], 2)
    assert names(independent) == ["a", "b"]


def test_the_strongest_level_stays():
    found = independent_rows([row("slow", [1, -1], "acceleration"), row("tie", [2, -2], "position", 0.6)], 2)
    assert names(found) == ["tie"]
    assert '"slow" (acceleration level)' in found.notices[0].text
    assert '"tie" (position level)' in found.notices[0].text


def test_weaker_rows_of_a_held_combination_must_be_zero():
    tie = row("tie", [1, -1], "position", 0.6)
    assert names(independent_rows([tie, row("rate", [1, -1], "velocity", 0.0)], 2)) == ["tie"]
    with pytest.raises(
        ContradictoryConstraints,
        match=r'"rate" \(velocity level\) has the value 0.1 m/s, but it follows from "tie" \(position level\), with the value 0 m/s',
    ):
        independent_rows([tie, row("rate", [1, -1], "velocity", 0.1)], 2)


def test_a_combination_across_levels_counts_only_its_own_level():
    # a'' = 0 (from position) and b'' = 3 imply (a + b)'' = 3
    rows = [row("a", [1, 0], value=5.0), row("b", [0, 1], "acceleration", 3.0)]
    assert names(independent_rows([*rows, row("sum", [1, 1], "acceleration", 3.0)], 2)) == ["a", "b"]
    with pytest.raises(ContradictoryConstraints, match="has the value 8 m/s.2, .* with the value 3 m/s.2"):
        independent_rows([*rows, row("sum", [1, 1], "acceleration", 8.0)], 2)


def test_a_stronger_row_is_not_implied_by_weaker_ones():
    # the rates of a and b are held; that their sum is also held in position is new, and the later of the rates becomes redundant
    rows = [row("a", [1, 0], "velocity"), row("b", [0, 1], "velocity"), row("sum", [1, 1])]
    assert names(independent_rows(rows, 2)) == ["sum", "a"]


def test_contradictory_values_of_the_same_row():
    with pytest.raises(
        ContradictoryConstraints,
        match=r'constraint "b" \(position level\) has the value 0.3 m, but it follows from "a" \(position level\), with the value 0.2 m',
    ):
        independent_rows([row("a", [1, -1], value=0.2), row("b", [1, -1], value=0.3)], 2)


def test_a_narrow_decision_is_told():
    found = independent_rows([row("a", [1, 1, 1]), row("b", [1, 1, 1 + 2e-13])], 3)
    assert names(found) == ["a", "b"]
    (notice,) = found.notices
    assert notice.doubtful
    assert notice.text.startswith('constraint "b" (position level) is almost a combination of other rows')
    assert not independent_rows([row("a", [1, 1, 1]), row("b", [1, 1, 1 + 1e-9])], 3).notices


def test_rows_without_coefficients():
    found = independent_rows([row("nothing", [0, 0])], 2)
    assert not found.rows
    assert "all its coefficients are zero" in found.notices[0].text
    with pytest.raises(ContradictoryConstraints, match="has the value 1 m, but all its coefficients are zero"):
        independent_rows([row("impossible", [0, 0], value=1.0)], 2)


def test_an_orthonormal_basis_where_the_simple_one_has_huge_entries():
    # Wilkinson's growth: x_i = sum of all that follow, so the entries of X double from row to row
    count = 12
    rows = [row(str(i), line) for i, line in enumerate(np.eye(count, count + 1) - np.triu(np.ones((count, count + 1)), 1))]
    found = independent_rows(rows, count + 1)
    assert 2.0 ** (count - 1) > NULL_SPACE_LIMIT
    assert found.motions == (None,)
    assert np.isclose(np.linalg.norm(found.null_space), 1.0)
    assert np.abs(found.matrix @ found.null_space).max() < 16 * EPS


@st.composite
def integer_rows(draw):
    size = draw(st.integers(1, 6))
    count = draw(st.integers(0, 7))
    entries = st.lists(st.integers(-3, 3), min_size=size, max_size=size)
    levels = st.sampled_from(["position", "velocity", "acceleration"])
    return [row(str(i), draw(entries), draw(levels)) for i in range(count)], size


@given(integer_rows())
def test_rank_null_space_and_left_inverse(rows_and_size):
    rows, size = rows_and_size
    found = independent_rows(rows, size)
    every = np.array([r.coefficients for r in rows]).reshape(-1, size)
    rank = np.linalg.matrix_rank(every) if len(rows) else 0
    assert len(found.rows) == rank
    assert len(found.notices) == len(rows) - rank
    assert found.null_space.shape == (size, size - rank)
    assert np.linalg.matrix_rank(found.null_space) == size - rank
    assert np.abs(every @ found.null_space).max(initial=0) < 1e-12 * max(1, np.abs(found.null_space).max(initial=0))
    assert np.allclose(found.left_inverse @ found.matrix.T, np.eye(rank), atol=1e-11)
    # the rows that stay reach the strongest levels: no row below could take the place of a kept weaker one
    for level in (0, 1, 2):
        strong = np.array([r.coefficients for r in rows if r.order <= level]).reshape(-1, size)
        kept = sum(r.order <= level for r in found.rows)
        assert kept == (np.linalg.matrix_rank(strong) if len(strong) else 0)


@pytest.mark.parametrize("units, doubtful", [(0, False), (8, True)])
def test_a_row_that_follows_to_rounding_errors_only_is_doubtful(units, doubtful):
    near = 1 + units * np.finfo(float).eps
    rows = [row("a", [1.0, -1.0, 0.0]), row("b", [0.0, 1.0, -1.0]), row("c", [near, 0.0, -1.0])]
    (notice,) = independent_rows(rows, 3).notices
    assert notice.doubtful == doubtful and "is redundant and was left out" in notice.text
