"""What the checks at the door let in, and the words with which they refuse."""

import numpy as np
import pytest
import scipy.sparse

import mbconstrained as mb
from mbconstrained.ground.checks import _mistakes, names_of, nearest, real_array, real_number, whole_number


@pytest.mark.parametrize(
    "value", [[[1, 2], [3, 4]], np.array([[1, 2], [3, 4]], dtype=np.int8), scipy.sparse.csr_array([[1, 2], [3, 4]])]
)
def test_integers_and_sparse_arrays_become_new_floats(value):
    array = real_array(value, "mass", shape=(2, None))
    assert array.dtype == float
    assert array.tolist() == [[1.0, 2.0], [3.0, 4.0]]


@pytest.mark.parametrize(
    "value, shape, text",
    [
        ([[1, 2], [3]], None, "mass: the rows have different lengths; give a rectangular array of numbers"),
        ([1 + 2j], None, "mass: complex numbers found; only real data is accepted"),
        (["a", "b"], None, "mass: found 'a'; expected numbers"),
        ([None], None, "mass: found None; expected numbers"),
        (object(), None, "mass: found an object of type object; expected numbers"),
        ([1.0, 2.0], (2, 2), "mass: expected shape 2 x 2, found 2$"),
        ([[1.0, 2.0]], (2, None), "mass: expected shape 2 x any, found 1 x 2"),
        ([1.0], (), "mass: expected shape a single number, found 1"),
        (3.0, (3,), "mass: expected shape 3, found a single number"),
        ([1.0, np.nan], None, r"mass: the entry at \(1,\) is nan; every entry must be a finite number"),
        ([[1.0, -np.inf]], None, r"mass: the entry at \(0, 1\) is -inf; every entry must be a finite number"),
    ],
)
def test_what_is_no_array_of_finite_real_numbers_is_refused(value, shape, text):
    with pytest.raises(mb.InputError, match=text):
        real_array(value, "mass", shape=shape)


@pytest.mark.parametrize(
    "value, rules, text",
    [
        (0, {"positive": True}, "stiffness: found 0; expected a number greater than zero"),
        (-1e-3, {"minimum": 0}, "stiffness: found -0.001; expected at least 0"),
        ("2", {}, "stiffness: found '2'; expected a number in SI units without quotes"),
        (np.nan, {}, "stiffness: found nan; expected a finite number"),
        (True, {}, "stiffness: found True; expected a number"),
        (np.False_, {}, "stiffness: found False; expected a number"),
    ],
)
def test_numbers_out_of_range_are_refused(value, rules, text):
    with pytest.raises(mb.InputError, match=text):
        real_number(value, "stiffness", **rules)


@pytest.mark.parametrize("value", [True, 1.0, -1, "1", None])
def test_what_is_no_whole_number_is_refused(value):
    with pytest.raises(mb.InputError, match="power: found .*; expected a whole number of at least 0"):
        whole_number(value, "power")


@pytest.mark.parametrize(
    "names, text",
    [
        (["a"], "coordinates: 1 names given for 2; give one each"),
        (["a", "a"], 'coordinates: the name "a" is used twice; names must differ'),
    ],
)
def test_names_must_be_one_each_and_differ(names, text):
    with pytest.raises(mb.InputError, match=text):
        names_of(names, 2, "coordinates", "x")


@pytest.mark.parametrize(
    ("word", "known", "mistakes"),
    [("ratio", "radii", 2), ("kitten", "sitting", 3), ("crat", "cart", 1), ("Mass", "mass", 0), ("", "ab", 2), ("cvs", "csv", 1)],
)
def test_mistakes_are_counted_as_by_damerau(word, known, mistakes):
    """Damerau 1964; kitten and sitting are the example of every textbook."""
    assert _mistakes(word, known) == _mistakes(known, word) == mistakes


def test_the_nearest_known_name_is_offered_only_when_it_is_near():
    assert nearest("stifness", ["damping", "stiffness"]) == '; did you mean "stiffness"?'
    assert nearest("qqq", ["damping", "stiffness"]) == ""


def test_every_error_is_an_mbconstrained_error_and_a_builtin_one():
    for error, builtin in [
        (mb.InputError, ValueError),
        (mb.SceneError, mb.InputError),
        (mb.SingularPolynomialMatrix, ValueError),
        (mb.ContradictoryConstraints, mb.InputError),
        (mb.NotUnique, ValueError),
        (mb.Overflow, OverflowError),
        (mb.IllConditioned, ArithmeticError),
    ]:
        assert issubclass(error, mb.MbconstrainedError)
        assert issubclass(error, builtin)


def test_a_notice_prints_as_note_or_warning():
    assert str(mb.Notice(mb.NoticeKind.JUMP, "x1 jumps")) == "note (jump): x1 jumps"
    assert str(mb.Notice("rank", "no clear gap", doubtful=True)) == "warning (rank): no clear gap"
