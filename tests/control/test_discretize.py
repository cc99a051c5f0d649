"""Discretization against scipy.signal, python-control, the continuous solution under the held input, and published zeros."""

import control
import numpy as np
import pytest
import scipy.signal

import mbconstrained as mb


def random_system(seed: int, n: int = 4, p: int = 2, q: int = 2) -> mb.StateSpace:
    random = np.random.default_rng(seed)
    return mb.StateSpace(*(random.standard_normal(shape) for shape in ((n, n), (n, p), (q, n), (q, p))))


@pytest.mark.parametrize("hold", [0, 1])
def test_matrices_agree_with_scipy(hold):
    for seed in range(5):
        system = random_system(seed)
        own = system.discretize(0.3, hold=hold)
        given = (system.A, system.B, system.C, system.D)
        for matrix, reference in zip((own.A, own.B, own.C, own.D), scipy.signal.cont2discrete(given, 0.3, ["zoh", "foh"][hold])):
            assert np.allclose(matrix, reference, rtol=1e-11, atol=1e-12)


def test_impulse_hold_agrees_with_scipy():
    random = np.random.default_rng(0)
    A, B, C = random.standard_normal((3, 3)), random.standard_normal((3, 1)), random.standard_normal((1, 3))
    own = mb.StateSpace(A, B, C).discretize(0.2, hold="impulse")
    ad, bd, _, dd, _ = scipy.signal.cont2discrete((A, B, C, np.zeros((1, 1))), 0.2, "impulse")
    assert np.allclose(own.A, ad) and np.allclose(own.B * 0.2, bd) and np.allclose(own.D * 0.2, dd)


@pytest.mark.parametrize("delay", [0.0, 0.4, 0.25, 1.1, 0.2000000000000001])
@pytest.mark.parametrize("hold", [0, 1])
def test_samples_are_those_of_the_continuous_system_under_the_held_and_delayed_input(hold, delay):
    h, u = 0.2, np.array([1.0, -2.0, 0.5, 3.0, 0.0, 1.0, 0.0, 0.0])
    u[0] *= 1 - hold  # a linear hold rises to u_0 from zero at k = -1: the delayed input would begin with that
    system = random_system(7, p=1)
    own = system.discretize(h, hold=hold, delays={"u1": delay})
    y = own.solve([0.3, -0.1, 0.2, 1.0], u[:, None])
    times = h * np.arange(len(u))
    if hold:
        signal = mb.sampled(times, u[None])
    else:
        signal = sum((mb.step([b - a]).delayed(t) for a, b, t in zip(np.append(0.0, u), u, times) if b != a), mb.zero(1))
    reference = system.solve([0.3, -0.1, 0.2, 1.0], signal.delayed(delay))
    k = np.arange(1, len(u))
    jumps = system.D[:, 0] * 1.0
    for number in k:
        expected = reference.output(float(times[number]))
        if (hold == 0 and abs(delay / h - round(delay / h)) > 1e-3) or hold == 1 or not jumps.any():
            assert np.allclose(y.output(int(number)), expected, rtol=1e-10, atol=1e-10)
        state = reference(float(times[number]))
        if hold == 0:
            assert np.allclose(y(int(number))[:4], state, rtol=1e-10, atol=1e-10)


def test_stiff_systems_are_exact():
    system = mb.StateSpace([[-1e6, 1e6], [0.0, -1e-3]], [[0.0], [1.0]], [[1.0, 0.0]])
    own = system.discretize(1.0, hold=0)
    a, b = -1e6, -1e-3
    e = np.exp(b)
    assert np.isclose(own.A[0, 1], 1e6 * e / (b - a), rtol=1e-15)
    assert np.isclose(own.B[1, 0], np.expm1(b) / b, rtol=1e-15)


def test_a_mechanical_system_with_a_massless_coordinate_and_a_constraint():
    system = mb.MechanicalSystem(
        np.diag([2.0, 0.0, 1.0]),
        [[0.5, -0.5, 0.0], [-0.5, 0.5, 0.0], [0.0, 0.0, 0.0]],
        [[3.0, -1.0, 0.0], [-1.0, 2.0, 0.0], [0.0, 0.0, 4.0]],
        constraints=[mb.Constraint([1.0, 0.0, -1.0])],
        names=["a", "b", "c"],
    )
    h = 0.1
    own = system.discretize(h, hold=0, inputs=["force on a", "force on b"])
    u = np.array([[1.0, 0.0], [0.0, 2.0], [-1.0, 1.0], [0.0, 0.0]])
    force = mb.zero(3)
    for column, place in enumerate((0, 1)):
        unit = np.eye(3)[place]
        for k in range(len(u)):
            change = u[k, column] - (u[k - 1, column] if k else 0.0)
            force = force + mb.step(change * unit).delayed(k * h)
    motion = system.solve(force=force)
    k = np.arange(8)
    assert np.allclose(own.solve(input=u).output(k), motion.displacement(k * h), atol=1e-12)


def test_reactions_that_follow_a_derivative_are_refused_or_represented():
    system = mb.StateSpace(
        [[1.0, 0.0], [0.0, 1.0]], [[0.0], [-1.0]], [[1.0, 0.0]], descriptor=[[0.0, 1.0], [0.0, 0.0]]
    )  # x1 = x2' = u'
    with pytest.raises(mb.InputError, match='the output "y1" follows the derivative of the input "u1"'):
        system.discretize(0.1, hold=0)
    own = system.discretize(0.5, hold=1)
    assert own.notices and "derivative" in own.notices[0].text
    assert own.solve(input=[[1.0], [3.0], [2.0]]).output([1, 2]).tolist() == [[4.0, -2.0]]
    twice = mb.StateSpace(np.eye(3), [[0.0], [0.0], [-1.0]], [[1.0, 0.0, 0.0]], descriptor=np.eye(3, k=1))
    with pytest.raises(mb.InputError, match="second derivative"):
        twice.discretize(0.5, hold=1)


def test_an_inconsistent_start_jumps_as_in_continuous_time():
    system = mb.StateSpace([[-1.0, 0.0], [1.0, -1.0]], [[1.0], [0.0]], np.eye(2), descriptor=np.diag([1.0, 0.0]))
    own = system.discretize(0.1, hold=0)
    assert np.allclose(own.solve([2.0, 5.0]).output([0, 3]), system.solve([2.0, 5.0]).output([0.0, 0.3]))


def test_zeros_of_sampling_tend_to_the_roots_of_euler_frobenius_polynomials():
    for order, limits in ((2, [-1.0]), (3, [-2 - 3**0.5, -2 + 3**0.5]), (4, [-5 - 24**0.5, -1.0, -5 + 24**0.5])):
        plant = mb.StateSpace.from_transfer_function([1.0], np.poly(-np.arange(1.0, order + 1)))
        zeros = plant.discretize(0.02, hold=0).zeros()
        assert [zero.origin for zero in zeros] == ["sampling"] * (order - 1)
        assert np.allclose(sorted(zero.value.real for zero in zeros), limits, rtol=0.1)
        for zero in zeros:
            assert abs(zero.value - zero.limit) < 0.1 * abs(zero.limit)
    plant = mb.StateSpace.from_transfer_function([1.0, 0.5], [1.0, 3.0, 2.0, 1.0])
    zeros = plant.discretize(0.05, hold=0).zeros()
    assert sorted(zero.origin for zero in zeros) == ["plant", "sampling"]
    own = next(zero for zero in zeros if zero.origin == "plant")
    assert abs(own.value - np.exp(-0.5 * 0.05)) < 1e-3 and np.isclose(own.limit, np.exp(-0.025))
    foh = mb.StateSpace.from_transfer_function([1.0], [1.0, 0.3, 1.0]).discretize(0.02, hold=1).zeros()
    assert np.allclose(sorted(zero.value.real for zero in foh), [-2 - 3**0.5, -2 + 3**0.5], rtol=0.02)


def test_frequency_response_agrees_with_scipy_and_ends_at_nyquist():
    system = random_system(3, p=1, q=1)
    own = system.discretize(0.1, hold=0)
    f = np.linspace(0.0, 5.0, 20)
    H = own.frequency_response(f)
    _, reference = scipy.signal.dfreqresp(own.to_scipy(), 2 * np.pi * f * 0.1)
    assert np.allclose(H.values[0, 0], reference, rtol=1e-9)
    assert H.error_estimate.max() < 1e-10
    with pytest.raises(mb.InputError, match="Nyquist frequency is 5 Hz"):
        own.frequency_response([5.1])
    with pytest.raises(mb.InputError):
        own.frequency_response([np.nan])


def test_conversions_there_and_back():
    own = random_system(4).discretize(0.25, hold=1)
    for back in (mb.DiscreteStateSpace.from_control(own.to_control()), mb.DiscreteStateSpace.from_scipy(own.to_scipy())):
        assert back.step == 0.25
        for name in "ABCD":
            assert np.array_equal(getattr(back, name), getattr(own, name))
    assert own.to_control().dt == 0.25 and isinstance(own.to_scipy(), scipy.signal.dlti)
    assert mb.DiscreteStateSpace.from_control(own.to_control()).inputs == own.inputs
    assert mb.DiscreteStateSpace.from_control(control.tf([1.0, 0.5], [1.0, -0.2], 0.5))(2.0).item() == 2.5 / 1.8
    assert mb.DiscreteStateSpace.from_scipy(scipy.signal.ZerosPolesGain([0.1], [0.5, 0.2], 2.0, dt=0.5))(
        2.0
    ).item() == pytest.approx(2 * 1.9 / (1.5 * 1.8))
    gain = mb.DiscreteStateSpace.from_scipy(scipy.signal.TransferFunction([3.0], [1.0], dt=0.5))
    assert gain.A.shape == (0, 0) and gain.solve(input=[[1.0], [2.0]]).output([0, 1]).tolist() == [[3.0, 6.0]]
    assert gain.zeros() == () and not len(gain.poles())


def test_refusals():
    system = random_system(1)
    for given, text in (
        ({"step": 0.0}, "step"),
        ({"step": np.nan}, "step"),
        ({"step": 0.1, "hold": 2}, "hold: found 2"),
        ({"step": 0.1, "hold": True}, "hold: found True"),
        ({"step": 0.1, "delays": {"u3": 1.0}}, 'there is no input "u3"'),
        ({"step": 0.1, "delays": {"u1": -1.0}}, "delay of u1"),
        ({"step": 0.1, "delays": 0.1}, "expected a mapping"),
        ({"step": 0.1, "hold": "impulse"}, "follows the input"),
    ):
        with pytest.raises(mb.InputError, match=text):
            system.discretize(**given)
    with pytest.raises(mb.InputError, match="continuous system"):
        mb.DiscreteStateSpace.from_scipy(system.to_scipy())
    with pytest.raises(mb.InputError, match="leaves its step open"):
        mb.DiscreteStateSpace.from_scipy(scipy.signal.TransferFunction([1.0], [1.0, 0.5], dt=True))
    with pytest.raises(mb.InputError, match="discrete-time system"):
        mb.StateSpace.from_scipy(system.discretize(0.1).to_scipy())
    with pytest.raises(mb.InputError, match='there is no state "x9"'):
        system.discretize(0.1).solve({"x9": 1.0})
    with pytest.raises(mb.InputError, match="square"):
        mb.DiscreteStateSpace([[1.0, 2.0]])


def test_growth_outside_the_circle_is_reported():
    assert "unit circle" in mb.DiscreteStateSpace([[1.5]], [[1.0]], [[1.0]]).notices[0].text
    assert not mb.DiscreteStateSpace([[1.0]], [[1.0]], [[1.0]]).notices


def test_zeros_agree_with_exact_ones_within_their_errors():
    random = np.random.default_rng(0)
    systems = [
        mb.DiscreteStateSpace(*(random.standard_normal(shape) for shape in ((n, n), (n, 1), (1, n), (1, 1)))) for n in (1, 3, 5)
    ]
    chain = mb.StateSpace.from_transfer_function([1.0, 0.5], np.poly(-np.arange(1.0, 6)))
    systems += [chain.discretize(h, hold) for h in (0.01, 0.1) for hold in (0, 1)]
    for system in systems:
        zeros, exact = system.zeros(), system.zeros(exact=True)
        assert len(zeros) == len(exact) and [zero.origin for zero in zeros] == [zero.origin for zero in exact]
        for zero in zeros:
            nearest = min(exact, key=lambda other: abs(other.value - zero.value))
            assert abs(nearest.value - zero.value) <= zero.error and 1 <= zero.condition < 1e6
            assert nearest.error <= 2.0**-53 * abs(nearest.value)


def test_rounding_errors_of_the_matrices_move_zeros_by_no_more_than_their_errors():
    system = mb.StateSpace.from_transfer_function([1.0, 0.5], np.poly(-np.arange(1.0, 5))).discretize(0.1, 0)
    random = np.random.default_rng(1)
    for _ in range(20):
        moved = [M * (1 + random.uniform(-1, 1, M.shape) * 2.0**-53) for M in (system.A, system.B, system.C, system.D)]
        others = mb.DiscreteStateSpace(*moved).zeros(exact=True)
        for zero in system.zeros():
            assert min(abs(other.value - zero.value) for other in others) <= zero.error


def test_a_channel_that_is_zero_has_no_zeros():
    system = mb.DiscreteStateSpace([[0.5]], [[0.0]], [[1.0]])
    assert system.zeros() == system.zeros(exact=True) == ()


def test_more_refusals():
    system = random_system(1)
    with pytest.raises(mb.InputError, match="delay of u1: found 1e.09 s, which is more than 2000 steps"):
        system.discretize(0.1, delays={"u1": 1e9})
    with pytest.raises(mb.InputError, match="found int; expected a system of scipy.signal"):
        mb.DiscreteStateSpace.from_scipy(3)
    with pytest.raises(mb.InputError, match="at most 2.53"):
        system.discretize(0.1).solve([1.0, 0.0, 0.0, 0.0])(10**19)


def test_states_and_outputs_of_like_names():
    system = mb.DiscreteStateSpace([[0.5]], [[1.0]], [[2.0]], states=["a"], outputs=["state a"])
    assert system.solve([1.0]).output(2).tolist() == [0.5]
