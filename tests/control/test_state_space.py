"""State spaces, with descriptors singular or not, against closed forms that are written down here."""

import mpmath
import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.control.state_space import StateSpace

T = np.array([0.0, 1e-3, 0.3, 1.0, 4.0])
LAG = {"A": [[-2.0]], "B": [[2.0]], "C": [[1.0]]}


def test_a_lag_follows_a_step():
    x = StateSpace(**LAG).solve(input=mb.step([3.0]))
    assert x(T)[0] == pytest.approx(3 * (1 - np.exp(-2 * T)), rel=1e-14)
    assert np.array_equal(x.output(T), x(T))
    assert not x.output_jump.any() and not x.output_impulses and not x.output_events


def test_what_goes_straight_through_jumps_and_impulse_arrows():
    # y = x + 3 u with u = 2 + 5 delta: x jumps by B 5 = 10, y from C x(0-) = 1 to 1 + 10 + 3 * 2, and has 3 * 5 delta.
    x = StateSpace(**LAG, D=[[3.0]]).solve([1.0], mb.step([2.0]) + mb.impulse([5.0]))
    assert x.output_initial.tolist() == [1.0]
    assert x.output_jump == pytest.approx([16.0], rel=1e-15)
    assert [impulse.tolist() for impulse in x.output_impulses] == [[15.0]]
    assert x.output(T)[0] == pytest.approx(11 * np.exp(-2 * T) + 2 * (1 - np.exp(-2 * T)) + 6, rel=1e-14)


def test_outputs_have_the_events_of_later_inputs():
    x = StateSpace(**LAG, D=[[3.0]]).solve(input=mb.pulse([2.0], start=1.0, duration=0.5))
    assert [(event.time, event.jump.tolist()) for event in x.output_events] == [(1.0, [[6.0]]), (1.5, [[-6.0]])]
    assert not x.events[0].jump.any() if x.events else True


def test_an_output_that_nothing_reaches_stays_exactly_zero():
    x = StateSpace([[-1.0, 0.0], [0.0, -2.0]], [[1.0], [0.0]], [[0.0, 1.0]]).solve(input=mb.step([1.0]))
    assert not x.output(T).any()


def test_a_capacitor_at_a_source():
    """C1 v1' = i - (v1 - v2)/R, C2 v2' = (v1 - v2)/R, v1 = u: i = C1 u' + (u - v2)/R."""
    C1, C2, R = 0.1, 0.25, 2.0
    A = [[-1 / R, 1 / R, 1], [1 / R, -1 / R, 0], [1, 0, 0]]
    circuit = StateSpace(A, [[0], [0], [-1]], [[0, 0, 1]], descriptor=np.diag([C1, C2, 0]))
    x = circuit.solve(input=mb.step([5.0]))
    assert x.output(T)[0] == pytest.approx(5 / R * np.exp(-T / (R * C2)), rel=1e-14)
    assert x.output_impulses[0] == pytest.approx([5 * C1], rel=1e-15) and len(x.output_impulses) == 1
    assert x.output_jump == pytest.approx([5 / R], rel=1e-15)
    from_charged = circuit.solve({"x1": 5.0}, mb.step([5.0]))
    assert not from_charged.output_impulses
    assert from_charged.jump[0].tolist() == [0, 0, pytest.approx(2.5)]


def test_a_differentiator():
    # x2' = x1, 0 = x2 + u: x1 = -u'. u = t^2/2 from x2(0-) = 1: x2 jumps by -1, x1 = -t - delta.
    x = StateSpace(np.eye(2), [[0], [1]], [[1, 0]], descriptor=[[0, 1], [0, 0]]).solve([0, 1], mb.power([1.0], 3))
    assert x.output(T)[0] == pytest.approx(-T, abs=1e-15)
    assert [impulse.tolist() for impulse in x.output_impulses] == [[-1.0]]


SMALL = st.integers(-3, 3)


@given(st.data())
def test_descriptor_systems_in_any_coordinates(data):
    """W (s E - A) V = diag(s - J, s N - I): x = V (x1; x2), x1' = J x1 + B1 u, x2 = -sum N^i B2 u^(i)."""
    n, m = data.draw(st.integers(0, 2)), data.draw(st.integers(1, 3))
    J, B1 = np.diag(data.draw(st.lists(SMALL, min_size=n, max_size=n))), np.ones((n, 1))
    N, B2 = np.diag(np.ones(m - 1), 1), np.array(data.draw(st.lists(SMALL, min_size=m, max_size=m)), dtype=float)[:, None]
    random = np.random.default_rng(data.draw(st.integers(0, 10**6)))
    W, V = (scipy.linalg.qr(random.normal(size=(n + m, n + m)))[0] for _ in range(2))
    E = W.T @ scipy.linalg.block_diag(np.eye(n), N) @ V.T
    A = W.T @ scipy.linalg.block_diag(J, np.eye(m)) @ V.T
    C = random.normal(size=(2, n + m))
    system = StateSpace(A, W.T @ np.vstack([B1, B2]), C, [[1.0], [0.0]], descriptor=E)
    start = random.normal(size=n)
    x = system.solve(V @ np.concatenate([start, np.zeros(m)]), mb.step([2.0]) + mb.ramp([1.0]))
    # x2(0-) = 0: the jump of N x2 makes the impulses; u = 2 + t, u' = 1 + 2 delta, u'' = delta + 2 delta'
    slow = np.array([[_step_and_ramp(rate, x0, t) for t in T] for rate, x0 in zip(np.diag(J), start)]).reshape(n, len(T))
    fast = -B2 * (2 + T) - (N @ B2) * 1.0
    expected = V @ np.vstack([slow, fast])
    assert np.abs(x(T) - expected).max() <= 1e-10 * np.abs(expected).max()
    y = C @ expected + np.outer([1, 0], 2 + T)
    assert np.abs(x.output(T) - y).max() <= 1e-10 * np.abs(y).max()
    impulses = [-2 * N @ B2 - N @ N @ B2, -2 * N @ N @ B2]
    for order, impulse in enumerate(impulses):
        found = x.output_impulses[order] if order < len(x.output_impulses) else np.zeros(2)
        assert found == pytest.approx((C @ V[:, n:] @ impulse)[:, 0], abs=1e-11)


def _step_and_ramp(rate, start, t):
    """x' = rate x + 2 + t from a start."""
    if rate == 0:
        return start + 2 * t + t**2 / 2
    return start * np.exp(rate * t) + 2 * np.expm1(rate * t) / rate + (np.expm1(rate * t) - rate * t) / rate**2


def test_an_output_far_from_the_input_is_accurate_at_once():
    """Four equal lags in a row behind a rotation: y = 1 - e^-t (1 + t + t^2/2 + t^3/6) = t^4/24 - t^5/30 + t^6/72 - ..."""
    Q, _ = scipy.linalg.qr(np.random.default_rng(0).normal(size=(4, 4)))
    A, B, C = np.diag(np.ones(3), -1) - np.eye(4), np.eye(4)[:, :1], np.eye(4)[3:]
    t = np.array([1e-3, 1e-2])
    expected = t**4 / 24 - t**5 / 30 + t**6 / 72 - t**7 / 252 + t**8 / 1152
    assert StateSpace(A, B, C).solve(input=mb.step([1.0])).output(t)[0] == pytest.approx(expected, rel=1e-13)
    rotated = StateSpace(Q.T @ A @ Q, Q.T @ B, C @ Q).solve(input=mb.step([1.0])).output(t)[0]
    assert rotated == pytest.approx(expected, abs=1e-15)  # what a rotation has rounded is not known better


def test_a_consistent_start_makes_no_jump_of_the_output():
    random = np.random.default_rng(3)
    A, C = random.normal(size=(6, 6)), random.normal(size=(3, 6))
    x = StateSpace(A, np.ones((6, 1)), C).solve(random.normal(size=6), mb.step([1.0]))
    assert not x.output_jump.any() and not x.jump.any()
    assert x.output_initial == pytest.approx(C @ x.initial[0], rel=1e-13)


def test_the_value_of_the_transfer_function():
    system = StateSpace([[0, 1], [-2, -3]], [[0], [1]], [[1, 0], [0, 1]], [[0], [1]])
    s = 0.7 + 1.1j
    assert system(s) == pytest.approx(np.array([[1 / (s * s + 3 * s + 2)], [s / (s * s + 3 * s + 2) + 1]]), rel=1e-14)
    with pytest.raises(mb.InputError, match="s: found -1, where s E - A is singular"):
        StateSpace([[-1.0]], [[1.0]], [[1.0]])(-1.0)


def test_names_and_units_are_kept():
    system = StateSpace([[-1.0]], [[1.0]], [[1.0]], states=["speed"], inputs=["volts"], outputs=["tacho"], units={"volts": "V"})
    assert system.units == {"speed": "1", "volts": "V", "tacho": "1"}
    assert system.solve({"speed": 2.0}).initial.tolist() == [[2.0]]
    assert system.polynomial_matrix_with_outputs().coordinates == ("speed", "tacho")
    assert repr(system) == "StateSpace(1 state, 1 input, 1 output)"


def test_without_inputs_or_outputs():
    free = StateSpace([[-1.0]]).solve([1.0])
    assert free(T)[0] == pytest.approx(np.exp(-T)) and free.output(T).shape == (0, len(T))
    assert StateSpace([[-1.0]], C=[[2.0]]).solve([1.0]).output(1.0) == pytest.approx([2 * np.exp(-1)])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"A": [[1.0, 2.0]]}, r"A: expected a square matrix, found 1 x 2"),
        ({"A": np.zeros((0, 0))}, r"A: found no entries; a state space needs at least one state"),
        ({"B": [[1.0], [2.0]]}, r"B: expected shape 1 x any, found 2 x 1"),
        ({"B": [1.0]}, r"B: expected shape 1 x any, found 1"),
        ({"C": [[1.0, 2.0]]}, r"C: expected shape any x 1, found 1 x 2"),
        ({"D": [[1.0, 2.0]]}, r"D: expected shape 1 x 1, found 1 x 2"),
        ({"D": [[np.nan]]}, r"D: the entry at \(0, 0\) is nan"),
        ({"A": [[1j]]}, r"A: complex numbers found"),
        ({"descriptor": [[1.0, 0.0]]}, r"descriptor: expected shape 1 x 1, found 1 x 2"),
        ({"states": ["a", "b"]}, r"states: 2 names given for 1"),
        ({"states": ["v"], "outputs": ["v"]}, r'states and outputs: the name "v" is used twice'),
        ({"outputs": "y"}, r'outputs: found the text "y"; expected a list of names'),
        ({"units": {"y": "V"}}, r'units: there is no state, input or output "y"; did you mean "y1"\?'),
    ],
)
def test_errors_at_the_door(arguments, message):
    with pytest.raises(mb.InputError, match=message):
        StateSpace(**{**LAG, **arguments})


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"initial": [1.0, 2.0]}, r"initial: expected shape 1, found 2"),
        ({"initial": {"x11": 1.0}}, r'initial: there is no state "x11"; did you mean "x1"\?'),
        ({"input": 1.0}, r"input: found float; make it with mb\.step"),
        ({"input": mb.step([1.0, 2.0])}, r"input: it has 2 rows; expected 1, one for each input"),
    ],
)
def test_errors_when_it_is_solved(arguments, message):
    with pytest.raises(mb.InputError, match=message):
        StateSpace(**LAG).solve(**arguments)


def test_a_singular_pencil_is_refused():
    with pytest.raises(mb.SingularPolynomialMatrix):
        StateSpace([[0.0]], [[1.0]], descriptor=[[0.0]]).solve()


@pytest.mark.parametrize("s", [0.0, 1.3, 0.1 + 0.7j, -1e6])
def test_a_singular_pencil_has_no_transfer_function(s):
    """det (s E - A) = (s - 2)(s + 1) - (-s - 1)(-s + 2) = 0; rounding makes some number of it at most s."""
    system = StateSpace([[2, 1], [-2, -1]], [[1], [0]], [[1, 0]], descriptor=[[1, -1], [-1, 1]])
    with pytest.raises(mb.SingularPolynomialMatrix, match='the equations "row 1", "row 2" are dependent'):
        system(s)


def test_notices_and_text_count_states_and_outputs():
    # x' = -2 x + 2 u, y = x + 3 u with u = 2 + 5 delta: both jump, y has an impulse too.
    x = StateSpace(**LAG, D=[[3.0]], states=["v"], outputs=["w"]).solve([1.0], mb.step([2.0]) + mb.impulse([5.0]))
    assert [(n.kind, n.text[:2]) for n in x.notices if n.kind in ("jump", "impulse")] == [
        ("jump", "v:"),
        ("jump", "w:"),
        ("impulse", "w:"),
    ]
    assert str(x) == "StateSpaceResponse(2 coordinates: v, w; 2 jumps and 1 impulse at t = 0; 0 events later)"


def test_without_outputs_the_notices_are_of_the_states():
    x = StateSpace([[1.0]], [[1.0]]).solve(input=mb.impulse([1.0]))
    assert [n.kind for n in x.notices] == ["jump", "unstable"]
    assert str(x) == "StateSpaceResponse(1 coordinate: x1; 1 jump and 0 impulses at t = 0; 0 events later)"


def test_the_error_estimate_of_the_outputs_covers_the_error():
    random = np.random.default_rng(5)
    S = random.normal(size=(3, 3))
    A = S @ np.diag([-1.0, -2.0, -3.0]) @ np.linalg.inv(S)
    x = StateSpace(A, S @ np.ones((3, 1)), np.ones((1, 3)) @ np.linalg.inv(S)).solve(input=mb.step([1.0]))
    expected = sum((1 - np.exp(-k * T)) / k for k in (1, 2, 3))
    assert np.abs(x.output(T)[0] - expected).max() <= x.output_error_estimate(T) * expected.max() < 1e-11


def test_at_a_pole_the_finite_part_has_the_dead_time_too():
    """e^(-s/2) / (s^2 (s^2 + 4)) at its double pole 0 and at 2 i: its Laurent series, by mpmath."""
    integrators = mb.StateSpace.from_transfer_function([1.0], [1.0, 0.0, 4.0, 0.0, 0.0])
    f = np.array([0.0, 1 / np.pi])
    H = integrators.frequency_response(f, delays={"u1": 0.5})
    at_zero = mpmath.taylor(lambda s: mpmath.exp(-s / 2) / (s**2 + 4), 0, 2)
    at_pole = mpmath.taylor(lambda s: mpmath.exp(-s / 2) / (s**2 * (s + 2j)), 2j, 1)
    assert np.abs(H.values[0, 0] - np.array([complex(at_zero[2]), complex(at_pole[1])])).max() < 1e-12
    residues = [one.pole.residues[:, 0, 0] for one in H.poles_on_lines]
    assert residues[0] == pytest.approx([float(at_zero[1]), float(at_zero[0])], abs=1e-14)
    assert np.abs(residues[1] - complex(at_pole[0])).max() < 1e-13
    (peak,) = H.peaks
    assert peak.phase == pytest.approx(np.angle(np.exp(1j * (np.angle(1j * residues[1][0])))), abs=1e-9)
    box = integrators.frequency_response([0.1], delays={"u1": 0.5}).enclose(0.1)
    s = 0.2j * np.pi
    exact = np.exp(-s / 2) / (s**2 * (s**2 + 4))
    assert box.middle.ravel() == pytest.approx([exact.real, exact.imag], rel=1e-11)
