"""The descriptor form of mechanical systems: its transfer functions are those of the equations of motion with multipliers."""

import control
import numpy as np
import pytest
import scipy.io
import scipy.signal
import scipy.sparse

import mbconstrained as mb
from mbconstrained.ground.errors import InputError

M, K = np.diag([2.0, 1.0, 3.0]), np.array([[5.0, -2.0, 0.0], [-2.0, 4.0, -1.0], [0.0, -1.0, 3.0]])
C = 0.1 * K
S = 0.3 + 1.1j


def system(level="position", **changes):
    row = mb.Constraint([1.0, -1.0, 0.0], level=level, names="tie")
    arguments = dict(mass=M, damping=C, stiffness=K, constraints=[row], names=["a", "b", "c"]) | changes
    return mb.MechanicalSystem(**arguments)


@pytest.mark.parametrize(("order", "level"), list(enumerate(["position", "velocity", "acceleration"])))
@pytest.mark.parametrize("acceleration", [False, True])
@pytest.mark.parametrize("mass", [M, np.diag([2.0, 1.0, 0.0])], ids=["regular", "singular"])
def test_transfer_functions_are_those_of_the_bordered_system(order, level, acceleration, mass):
    """[M s^2 + C s + K, -A^T; s^p A, 0] [x; lambda] = [f; b], solved directly."""
    outputs = ["a", "c velocity", "tie reaction"] + ["b acceleration"] * acceleration
    space = system(level, mass=mass).to_state_space(inputs=["c", "tie"], outputs=outputs)
    A = np.array([[1.0, -1.0, 0.0]])
    bordered = np.block([[mass * S**2 + C * S + K, -A.T], [S**order * A, np.zeros((1, 1))]])
    a, b, c, reaction = np.linalg.solve(bordered, np.eye(4)[:, 2:])
    expected = [a, S * c, reaction] + [S**2 * b] * acceleration
    assert space(S) == pytest.approx(np.array(expected), rel=1e-12)
    assert space.inputs == ("force on c", "value of tie") and space.outputs == tuple(outputs)


def test_motion_and_state_space_agree():
    model, force = system(), mb.step([0.0, 0.0, 1.0])
    times = np.linspace(0, 5, 40)
    motion = model.solve(force=force)
    space = model.to_state_space(inputs=["c"], outputs=["a", "c velocity", "tie reaction"])
    expected = [motion(times)[0], motion.velocity(times)[2], motion.reaction(times)[0]]
    assert space.solve(input=mb.step([1.0])).output(times) == pytest.approx(np.array(expected), rel=1e-9, abs=1e-11)


def test_other_programs_have_the_same_transfer_functions_and_motion():
    free = mb.MechanicalSystem(M, C, K, names=["a", "b", "c"])
    for model in (free, system()):
        space = model.to_state_space(outputs=["a", "c velocity"])
        other = space.to_control()
        assert isinstance(other, control.StateSpace) and other(S) == pytest.approx(space(S), rel=1e-10)
        own = space.to_scipy()
        assert own.C @ np.linalg.solve(S * np.eye(len(own.A)) - own.A, own.B) + own.D == pytest.approx(space(S), rel=1e-10)
    times = np.linspace(0, 4, 30)
    space = free.to_state_space(inputs=["c"], outputs=["a"])
    _, y = scipy.signal.step(space.to_scipy(), T=times)
    assert y == pytest.approx(free.solve(force=mb.step([0, 0, 1.0]))(times)[0], rel=1e-8, abs=1e-10)
    assert len(space.to_scipy().A) == 6 and len(system().to_state_space().to_scipy().A) == 4


def test_matrices_by_name_build_the_same_system(tmp_path):
    model = system(units={"b": "m", "c": "rad"})
    data = model.to_dict()
    row = mb.Constraint(data["A"], level=data["levels"][0], value=data["b"])
    again = mb.MechanicalSystem(data["M"], data["C"], data["K"], [row], data["names"], units=data["units"])
    assert again.modes().eigenvalues.tolist() == model.modes().eigenvalues.tolist() and again.units == model.units
    space = model.to_state_space()
    found = space.to_dict()
    again = mb.StateSpace(
        *(found[name] for name in "ABCD"), found["E"], found["states"], found["inputs"], found["outputs"], found["units"]
    )
    assert np.array_equal(again(S), space(S)) and again.units == space.units
    scipy.io.savemat(tmp_path / "space.mat", {name: found[name] for name in "ABCDE"})
    assert np.array_equal(mb.read_matrix(tmp_path / "space.mat", "E"), space.E)


def test_sparse_matrices_stay_sparse_in_the_dictionary():
    chain = mb.MechanicalSystem(
        scipy.sparse.eye_array(50), stiffness=scipy.sparse.eye_array(50), constraints=scipy.sparse.eye_array(1, 50)
    )
    data = chain.to_dict()
    assert (
        all(scipy.sparse.issparse(data[name]) for name in "MCKA") and data["levels"] == ["position"] and data["b"].tolist() == [0.0]
    )
    with pytest.raises(InputError, match="rows: not available for sparse matrices"):
        chain.to_state_space()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"inputs": ["d"]}, r'inputs: there is no "d".*; known are, among others, .*"value of tie"'),
        ({"outputs": ["a velocty"]}, r'outputs: there is no "a velocty"; did you mean "a velocity"\?'),
        ({"outputs": 3}, r"outputs: found 3; expected a list of names, such as .*"),
        ({"outputs": ["a", "a"]}, r'the name "a" is used twice'),
    ],
)
def test_unknown_channels_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        system().to_state_space(**arguments)
