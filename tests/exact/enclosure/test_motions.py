"""Motions of mechanical systems: the multiplier form encloses what the constrained form answers."""

import json
from pathlib import Path

import numpy as np
import pytest

import mbconstrained as mb
from examples.simulators import example_47

KNOWN = json.loads((Path(__file__).parents[2] / "oracles" / "hauksdottir.json").read_text())

TIMES = np.array([0.0, 0.3, 2.0, 17.0])


def value(motion, of, times):
    """The numeric answer."""
    return motion(times) if of == "displacement" else getattr(motion, of)(times)


@pytest.mark.parametrize("level", ["position", "velocity", "acceleration"])
@pytest.mark.parametrize("of", ["displacement", "velocity", "acceleration", "reaction"])
def test_the_numeric_answer_is_right_to_its_digits(level, of):
    """A null space with entries 1/3, an inconsistent start, a force with a phase that stops."""
    rows = mb.Constraint([3.0, -1.0, 0.1], level=level, value=0.25)
    system = mb.MechanicalSystem(np.diag([1.0, 2.0, 0.0]), 0.1 * np.eye(3), np.diag([2.0, 1.0, 5.0]) + 0.5, [rows])
    force = mb.harmonic([1.0, 0.0, 2.0], angular_frequency=1.3, phase=0.3) + mb.pulse([0.0, 1.0, 0.0], start=0.2, duration=1.0)
    motion = system.solve([1.0, 0.5, -1.0], [0.0, 1.0, 0.0], force)
    box = motion.enclose(TIMES, of=of)
    values = value(motion, of, TIMES)
    assert box.error_bounds(values).max() <= 1e-12 * np.abs(values).max()


def test_elements_are_taken_as_they_are():
    """Two springs whose sum is no float64 number: x'' + (1e16 + 1) x from the elements, not from their rounded sum."""
    elements = mb.ElementMatrix(np.ones((2, 1)), [1e16, 1.0])
    motion = mb.MechanicalSystem([[1.0]], stiffness=elements).solve([1.0])
    assembled = mb.MechanicalSystem([[1.0]], stiffness=[[1e16]]).solve([1.0])
    exact = (motion.exact.matrix.determinant, assembled.exact.matrix.determinant)
    assert [int(p[0]) for p in exact] == [10**16 + 1, 10**16]


def test_without_rows_there_are_no_reactions_to_enclose():
    motion = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]]).solve([1.0])
    assert motion.enclose([0.0, 1.0], of="reaction").lower.shape == (0, 2)
    assert motion.enclose(0.0).contains([1.0])


def test_transfer_functions_are_enclosed_with_their_input():
    y = mb.transfer_function_response([1, 2], [1, 3, 3, 1], mb.harmonic([1.0], angular_frequency=2.0))
    assert y.enclose(TIMES).error_bounds(y(TIMES)).max() < 1e-14
    improper = mb.transfer_function_response([1, 0, 0], [1, 1], 0)
    assert [list(map(int, impulse)) for impulse in improper.exact.impulses] == [[-1], [1]]


@pytest.mark.parametrize("gamma", [0, 1, 2, 3])
def test_example_47(gamma):
    """Hauksdottir and Sigurdsson: values of 30 digits by ball arithmetic and residues of others (tests/oracles/README.md)."""
    y = mb.transfer_function_response(*example_47(), gamma)
    assert y.enclose([1.0, 10.0, 100.0], 25).contains([[KNOWN[f"I{gamma}({time})"] for time in (1, 10, 100)]])


def test_a_growing_common_factor_leaves_the_exact_answer_too():
    y = mb.transfer_function_response([1, -3], [1, -2, -3])  # (s - 3) / ((s - 3)(s + 1))
    assert y.enclose(50.0).error_bounds(y(50.0)).max() < 1e-15


def test_what_is_exactly_singular_is_named():
    """Elements of rank one in three coordinates: rounding hides it from a numeric engine that is told to trust every bit."""
    M = mb.ElementMatrix([[0.3, 0.7, 1.1]], [3.0])
    motion = mb.MechanicalSystem(M, stiffness=M).solve(np.ones(3), rank_tolerance=0.0)
    with pytest.raises(mb.SingularPolynomialMatrix, match='coordinates "x1", "x2", "x3"'):
        motion.enclose(1.0)


@pytest.mark.parametrize("of", [["velocity"], np.array(["velocity"]), None])
def test_a_quantity_is_a_word(of):
    with pytest.raises(mb.InputError, match="expected"):
        mb.MechanicalSystem([[1.0]]).solve([1.0]).enclose(1.0, of=of)


def test_outputs_of_a_state_space():
    """E x' = A x + B u with a singular E: y has an impulse, which is exact, and values, which are enclosed."""
    system = mb.StateSpace([[-1.0, 0.0], [0.0, 1.0]], [[1.0], [-1.0]], [[1.0, 1.0]], [[0.5]], descriptor=[[1.0, 0.0], [0.0, 0.0]])
    answer = system.solve(input=mb.harmonic([1.0], angular_frequency=3.0) + mb.impulse([2.0]))
    assert answer.enclose_output(TIMES).error_bounds(answer.output(TIMES)).max() < 1e-14
    assert [list(map(float, impulse)) for impulse in answer.exact_output.impulses] == [list(i) for i in answer.output_impulses]
