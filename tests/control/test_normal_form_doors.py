"""What cannot be turned into a normal form is refused at the door, and the text says what was found."""

import numpy as np
import pytest

import mbconstrained as mb

SPRING = [[0.0, 1.0], [-4.0, 0.0]]
FORCE = [[0.0], [1.0]]
FOUR = np.diag([1.0, 2.0, 3.0, 4.0])


@pytest.mark.parametrize(
    "arguments, match",
    [
        ({"A": np.eye(3), "B": None}, "3 states; a mechanical system has an even number"),
        ({"A": np.zeros((0, 0)), "B": None}, "no states"),
        ({"A": [[1, 2, 3]], "B": None}, "square matrix, found 1 x 3"),
        ({"A": [[np.nan, 1], [1, 1]], "B": None}, "finite"),
        ({"A": SPRING, "B": [[np.inf], [1]]}, "finite"),
        ({"A": [[1j, 1], [1, 1]], "B": None}, "complex"),
        ({"A": FOUR, "B": np.eye(4)[:, :3]}, "at most 2 independent forces"),
        ({"A": FOUR, "B": [[1], [2]]}, "expected shape 4 x p"),
        ({"A": FOUR, "B": np.zeros((4, 1, 1))}, "expected shape 4 x p"),
        ({"A": FOUR, "B": [[1, 2], [2, 4], [0, 0], [1, 2]]}, "columns 1 and 2 depend on each other"),
        (
            {"A": np.eye(6), "B": np.c_[np.eye(6)[:, 0], np.eye(6)[:, 3], np.eye(6)[:, 0] * 3]},
            "columns 1 and 3 depend on each other",
        ),
        ({"A": FOUR, "B": [[1, 0], [2, 0], [0, 0], [1, 0]]}, "column 2 is zero"),
        ({"A": SPRING, "B": FORCE, "C": [[1, 0, 0]]}, "expected shape m x 2"),
        ({"A": SPRING, "B": FORCE, "D": [[1]]}, "without outputs"),
        ({"A": SPRING, "B": FORCE, "C": [[1, 0]], "D": [[1, 0]]}, "D: expected shape 1 x 1"),
        ({"A": SPRING, "B": FORCE, "descriptor": np.eye(3)}, "descriptor: expected shape 2 x 2"),
        ({"A": SPRING, "B": FORCE, "method": "kroneker"}, 'did you mean "kronecker"'),
    ],
)
def test_arguments_are_checked(arguments, match):
    with pytest.raises(mb.InputError, match=match):
        mb.mechanical_normal_form(**arguments)


def test_dependent_inputs_are_found_in_rotated_and_scaled_data():
    random = np.random.default_rng(3)
    B = random.standard_normal((8, 2)) @ random.standard_normal((2, 3)) * 10.0 ** random.uniform(-6, 6, (8, 1))
    with pytest.raises(mb.InputError, match="columns 1, 2 and 3 depend on each other"):
        mb.mechanical_normal_form(random.standard_normal((8, 8)), B)


def test_without_outputs_there_are_none():
    form = mb.mechanical_normal_form(SPRING, FORCE)
    assert form.output_matrix is None and form.feedthrough is None
    assert mb.mechanical_normal_form(SPRING, FORCE, [1.0, 0.0]).feedthrough.tolist() == [[0.0]]


def test_an_odd_finite_part_is_refused_with_its_size():
    F = np.diag([1.0, 2.0, 3.0, 0.0, 0.0])
    with pytest.raises(mb.NoNormalForm, match="the finite part of s F - A has 3 of the 5 states") as caught:
        mb.mechanical_normal_form(np.diag(np.arange(1.0, 6.0)), None, descriptor=F)
    assert (caught.value.condition, caught.value.rank) == ("descriptor", 3)


def test_a_singular_pencil_is_refused_with_the_names_of_its_rows_and_states():
    with pytest.raises(mb.NoNormalForm, match="zero for every s.*row 2.*x1") as caught:
        mb.mechanical_normal_form([[0, 1], [0, 0]], FORCE, descriptor=[[0, 1], [0, 0]])
    assert caught.value.condition == "descriptor"


def test_a_descriptor_that_is_not_finite_is_refused():
    with pytest.raises(mb.InputError, match="descriptor"):
        mb.mechanical_normal_form(SPRING, FORCE, descriptor=[[1.0, np.nan], [0.0, 1.0]])


def test_the_methods_of_a_form_check_what_they_get():
    form = mb.mechanical_normal_form(SPRING, FORCE)
    for call, match in (
        (lambda: form.displacement_velocity([1.0]), "expected 2 states"),
        (lambda: form.state([1.0, 2.0], [1.0]), "displacement"),
        (lambda: form.state([1.0], [1.0, 2.0]), "velocity"),
        (lambda: form.force([1.0, 2.0]), "u: expected shape 1"),
        (lambda: form.force(mb.step([1.0, 2.0])), "it has 2 rows"),
    ):
        with pytest.raises(mb.InputError, match=match):
            call()


@pytest.mark.parametrize("of_A, of_B", [(1e150, 1), (1e200, 1), (1e-200, 1), (1, 1e-200)])
def test_units_out_of_range_are_told(of_A, of_B):
    random = np.random.default_rng(0)
    with pytest.raises(mb.IllConditioned, match="choose units"):
        mb.mechanical_normal_form(of_A * random.standard_normal((4, 4)), of_B * random.standard_normal((4, 1)))
