"""State spaces from and to scipy.signal and python-control: the same G(s) on both sides."""

import sys

import numpy as np
import pytest
import scipy.signal

import mbconstrained as mb
from mbconstrained.control.conversions import factored_realization, rational_realization
from mbconstrained.control.state_space import StateSpace

PLACES = [0.3 + 0.9j, 2.0 + 0.0j, -0.4 + 3.0j]
B, A = [2.0, 3.0, 5.0], [1.0, 4.0, 6.0, 4.0]


def rational(b, a, s):
    return np.polyval(b, s) / np.polyval(a, s)


def agrees(system, expected, rel=1e-12):
    """G(s) at three places."""
    for s in PLACES:
        assert system(s) == pytest.approx(np.atleast_2d(expected(s)), rel=rel)


@pytest.mark.parametrize(
    ("b", "a"),
    [
        (B, A),
        ([1.0], A),
        (A, A),
        ([7.0], [2.0]),
        ([1.0, 2.0, 3.0, 4.0], [1.0, 5.0]),
        ([0.0, 0.0, 1.0], [0.0, 2.0, 1.0]),
        ([0.0], A),
        ([1.0, 0.0], [3.0]),
    ],
    ids=["proper", "constant above", "as many", "constants", "improper", "leading zeros", "zero", "derivative"],
)
def test_every_transfer_function_has_a_realization(b, a):
    agrees(StateSpace.from_transfer_function(b, a), lambda s: rational(b, a, s))


def test_the_coefficients_of_improper_fractions_are_kept_as_they_are():
    E, matrix, _, C, _ = rational_realization([0.1, 0.2, 0.3], [0.7, 0.9])
    assert matrix[-1].tolist() == [0.9, 0.7, 0.0] and C.tolist() == [[0.3, 0.2, 0.1]] and np.linalg.matrix_rank(E) == 2


def test_zeros_poles_gain_are_not_multiplied_out():
    zeros, poles = [-1, -2 + 1j, -2 - 1j], [-3, -4, -5, -0.1 + 2j, -0.1 - 2j, -7, -8]
    system = StateSpace.from_zeros_poles_gain(zeros, poles, -3.0)
    agrees(system, lambda s: -3 * np.prod(s - np.array(zeros)) / np.prod(s - np.array(poles)))
    found = system.transfer()
    assert sorted(np.concatenate([[z.value] * z.count for z in found.poles]).real) == pytest.approx(
        sorted(np.real(poles)), rel=1e-12
    )


@pytest.mark.parametrize("zeros", [[], [-1.0], [-1.0, -2.0], [1j, -1j, 0.5], [-1.0, -2.0, -3.0, -4.0]])
def test_any_number_of_zeros_above_three_poles(zeros):
    poles = [-1 + 1j, -1 - 1j, -2.0]
    agrees(
        StateSpace.from_zeros_poles_gain(zeros, poles, 2.0),
        lambda s: 2 * np.prod(s - np.array(zeros)) / np.prod(s - np.array(poles)),
    )


@pytest.mark.parametrize(
    "roots", [[1j], [1j, 1j], [1 + 1j, 2 - 1j], [np.nan], "ab", ["1"], None, [[1, 2], [3]], [[1.0]], {1.0}, [object()], [10**400]]
)
def test_what_is_no_list_of_numbers_with_their_conjugates_is_refused(roots):
    with pytest.raises(mb.InputError, match="zeros: "):
        factored_realization(roots, [-1.0, -2.0, -3.0], 1.0)


@pytest.mark.parametrize(
    ("numerator", "denominator", "message"),
    [
        ([], [1.0], "numerator: found no coefficients"),
        ([1.0], [0.0, 0.0], "denominator: found zero"),
        (["a"], [1.0], "numerator: found 'a'; expected numbers"),
        ([[[1.0], [1.0]]], [[[1.0]]], "the sizes differ"),
        ([[]], [[]], "numerator: found an empty list"),
        ([[1.0], []], [1.0], "numerator: found an empty list"),
        ([[1.0]], [[]], "denominator: found an empty list"),
        ([[[1.0]], 2.0], [[[1.0]], [[1.0]]], "the sizes differ"),
        ([1.0], [[[1.0]]], "numerator: found coefficients with a matrix of denominators"),
    ],
)
def test_polynomials_are_checked(numerator, denominator, message):
    with pytest.raises(mb.InputError, match=message):
        StateSpace.from_transfer_function(numerator, denominator)


# scipy.signal


def value_of(system, s):
    """G(s) of a system of scipy, by what it holds."""
    if hasattr(system, "num"):
        return np.polyval(system.num, s) / np.polyval(system.den, s)
    if hasattr(system, "gain"):
        return system.gain * np.prod(s - system.zeros) / np.prod(s - system.poles)
    return (system.C @ np.linalg.solve(s * np.eye(len(system.A)) - system.A, system.B) + system.D).item()


@pytest.mark.parametrize("form", ["state space", "transfer function", "zeros poles gain"])
def test_to_scipy_and_back(form):
    system = StateSpace.from_transfer_function(B, A).to_scipy(form)
    assert type(system).__name__.startswith({"s": "StateSpace", "t": "TransferFunction", "z": "ZerosPolesGain"}[form[0]])
    for s in PLACES:
        assert value_of(system, s) == pytest.approx(rational(B, A, s), rel=1e-11)
    agrees(StateSpace.from_scipy(system), lambda s: rational(B, A, s), rel=1e-11)


def test_scipy_with_several_outputs():
    system = scipy.signal.TransferFunction([[1.0, 2.0], [3.0, 4.0]], [1.0, 5.0, 6.0])
    agrees(StateSpace.from_scipy(system), lambda s: np.array([[s + 2], [3 * s + 4]]) / (s * s + 5 * s + 6))


def test_one_of_several_has_to_be_named():
    system = StateSpace(np.diag([-1.0, -2.0]), np.eye(2), np.eye(2))
    with pytest.raises(mb.InputError, match=r"output: the system has 2 \(y1, y2\); give output by name or number"):
        system.to_scipy("transfer function")
    assert system.to_scipy("zeros poles gain", "y2", "u2").gain == pytest.approx(1.0)


def test_other_forms_are_refused():
    with pytest.raises(mb.InputError, match="form: found 'transfer functon'; did you mean \"transfer function\""):
        StateSpace([[-1.0]]).to_scipy("transfer functon")


# descriptors


def test_a_regular_descriptor_is_solved_for():
    E = np.array([[2.0, 1.0], [0.0, 1.0]])
    system = StateSpace([[-1, 0], [1, -3]], [[1], [2]], [[1, 1]], [[0.5]], descriptor=E)
    found = system.to_scipy()
    assert E @ found.A == pytest.approx(system.A, abs=1e-15) and E @ found.B == pytest.approx(system.B, abs=1e-15)


def test_a_singular_descriptor_without_a_pole_at_infinity_goes():
    # 0 = x1 + x2 + u, x1' = -x1 + x2: y = x1 + 3 x2 = -2 x1 - 3 u with x1' = -2 x1 - u
    system = StateSpace([[-1, 1], [1, 1]], [[0], [1]], [[1, 3]], descriptor=[[1, 0], [0, 0]])
    found = system.ordinary()
    assert found.A == pytest.approx(np.array([[-2.0]]), rel=1e-14) and found.D == pytest.approx(np.array([[-3.0]]), rel=1e-14)
    agrees(StateSpace(*found), system)


def test_a_pole_at_infinity_has_no_ordinary_form():
    system = StateSpace.from_transfer_function([1.0, 0.0, 0.0], [1.0, 1.0])
    with pytest.raises(mb.InputError, match=r"grows like s\^1: there are no A, B, C, D without descriptor"):
        system.ordinary()
    found = system.to_scipy("transfer function")
    assert found.num == pytest.approx([1, 0, 0], abs=1e-13) and found.den == pytest.approx([1, 1], abs=1e-13)


def test_infinite_poles_that_the_output_does_not_see_go():
    # x2' = x1, 0 = x2 + u: x1 = -u' is not seen in y = x2 + x3
    system = StateSpace(
        [[1, 0, 0], [0, 1, 0], [0, 0, -1]], [[0], [1], [1]], [[0, 1, 1]], descriptor=[[0, 1, 0], [0, 0, 0], [0, 0, 1]]
    )
    agrees(StateSpace(*system.ordinary()), lambda s: -1 + 1 / (s + 1))


# python-control


def test_control_state_spaces_keep_their_names():
    control = pytest.importorskip("control")
    theirs = control.ss(
        [[-1, 2], [0, -3]], [[1], [2]], [[1, 0], [1, 1]], [[0], [1]], inputs=["volts"], outputs=["p", "q"], states=["i", "w"]
    )
    ours = StateSpace.from_control(theirs)
    assert (ours.states, ours.inputs, ours.outputs) == (("i", "w"), ("volts",), ("p", "q"))
    agrees(ours, theirs)
    back = ours.to_control()
    assert (back.state_labels, back.input_labels, back.output_labels) == (["i", "w"], ["volts"], ["p", "q"])
    agrees(ours, back)


def test_control_transfer_functions_of_many_inputs_and_outputs():
    control = pytest.importorskip("control")
    theirs = control.tf([[[1.0], [1.0, 2.0]], [[2.0, 0.0, 1.0], [3.0]]], [[[1.0, 1.0], [1.0, 2.0, 1.0]], [[1.0, 3.0], [1.0]]])
    ours = StateSpace.from_control(theirs)  # one of them is improper
    agrees(ours, theirs)
    agrees(ours, ours.to_control("transfer function"), rel=1e-9)


def test_static_systems_go_there_and_back():
    control = pytest.importorskip("control")
    D = [[2.0, 3.0], [0.0, -1.0], [5.0, 0.0]]
    ours = StateSpace.from_control(control.ss([], [], [], D, inputs=["a", "b"], outputs=["p", "q", "r"]))
    assert (ours.inputs, ours.outputs) == (("a", "b"), ("p", "q", "r")) and ours(0.7j).tolist() == D
    assert ours.solve(input=mb.step([1.0, 10.0])).output(1.0).tolist() == [32.0, -10.0, 5.0]
    assert StateSpace.from_control(ours.to_control())(3.0).tolist() == D
    assert StateSpace.from_scipy(ours.to_scipy())(3.0).tolist() == D


@pytest.mark.parametrize("given", [{"B": [[1.0]]}, {"C": [[1.0]]}, {}])
def test_a_system_without_inputs_or_outputs_has_no_transfer_function(given):
    pytest.importorskip("control")
    with pytest.raises(mb.InputError, match="expected at least one input, and for a transfer function one output"):
        StateSpace([[-1.0]], **given).to_control("transfer function")


@pytest.mark.parametrize("step", [0.1, True, 1])
def test_discrete_time_is_refused(step):
    control = pytest.importorskip("control")
    with pytest.raises(mb.InputError, match=rf"found a discrete-time system \(dt = {step}\); expected one in continuous time"):
        StateSpace.from_control(control.tf([1.0], [1.0, 0.5], step))
    with pytest.raises(mb.InputError, match="found a discrete-time system"):
        StateSpace.from_scipy(scipy.signal.StateSpace([[0.5]], [[1.0]], [[1.0]], [[0.0]], dt=step))


@pytest.mark.parametrize("other", [3.0, "1/(s+1)", np.eye(2), None])
def test_other_things_are_refused(other):
    with pytest.raises(mb.InputError, match="expected a StateSpace, TransferFunction or ZerosPolesGain of scipy.signal"):
        StateSpace.from_scipy(other)


def test_a_missing_package_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "control", None)
    text = r"to_control needs the package control, which is not installed; .* pip install '.*\[exchange\]'"
    with pytest.raises(mb.MbconstrainedError, match=text) as caught:
        StateSpace([[-1.0]], [[1.0]]).to_control()
    assert isinstance(caught.value, ImportError)


def test_reading_a_system_imports_no_package(monkeypatch):
    from types import SimpleNamespace

    monkeypatch.setitem(sys.modules, "control", None)
    found = StateSpace.from_control(SimpleNamespace(A=[[-1.0]], B=[[1.0]], C=[[1.0]], D=[[0.0]], dt=0))
    assert found(0).item() == 1.0
