"""Prescribed motion A x^(level) = b(t): supports that move, against minimal coordinates and against numerical integration."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.sparse
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import mbconstrained as mb

MASS, DAMPING, STIFFNESS = 2.0, 0.3, 50.0
RATE = 3.0
TIMES = np.linspace(0.0, 5.0, 41)
SINE = mb.harmonic([0.1], angular_frequency=RATE, phase=-np.pi / 2)


def quarter_car(signal, level="position", **options) -> mb.MechanicalSystem:
    """A mass on a spring and a damper, whose other end is the road."""
    branch = np.array([[1.0, -1.0], [-1.0, 1.0]])
    road = mb.Constraint([1.0, 0.0], level=level, value=signal, names="base")
    return mb.MechanicalSystem(np.diag([0.0, MASS]), DAMPING * branch, STIFFNESS * branch, [road], ["road", "car"], **options)


def test_a_moving_base_is_a_force_of_its_spring_and_damper():
    """m x'' + c x' + k x = k u + c u' with u = 0.1 sin(3 t), whose force in closed form is a harmonic of its own."""
    force = STIFFNESS * SINE + DAMPING * mb.harmonic([0.1 * RATE], angular_frequency=RATE)
    alone = mb.MechanicalSystem([[MASS]], [[DAMPING]], [[STIFFNESS]], force=force).solve()
    x = quarter_car(SINE).solve()
    assert np.abs(x(TIMES)[1] - alone(TIMES)[0]).max() <= 1e-13
    assert np.abs(x(TIMES)[0] - 0.1 * np.sin(RATE * TIMES)).max() <= 1e-15
    assert x.error_estimate(TIMES) <= 1e-12


def test_the_reaction_is_the_force_that_the_shaker_supplies():
    """k (u - x) + c (u' - x'), and its impulses are those of the support's mass, here none."""
    x = quarter_car(SINE).solve()
    road, car = x(TIMES)
    road_rate, car_rate = x.velocity(TIMES)
    expected = STIFFNESS * (road - car) + DAMPING * (road_rate - car_rate)
    assert np.abs(x.reaction(TIMES)[0] - expected).max() <= 1e-12 * np.abs(expected).max()
    assert x.constraint_impulses == ()


def test_an_earthquake_by_acceleration_is_that_of_an_integrator():
    """Level "acceleration": against DOP853 with the record as a piecewise linear function, one integration per sample interval."""
    times, values = np.linspace(0.0, 1.0, 11), np.r_[0.0, np.random.default_rng(0).normal(size=9), 0.0]
    x = quarter_car(mb.sampled(times, [values]), "acceleration").solve()

    def rates(t, y):
        return [y[2], y[3], np.interp(t, times, values), (STIFFNESS * (y[0] - y[1]) + DAMPING * (y[2] - y[3])) / MASS]

    state = np.zeros(4)
    for start, end in pairwise(times):
        state = solve_ivp(rates, (start, end), state, rtol=1e-12, atol=1e-14, method="DOP853").y[:, -1]
        assert np.abs(np.r_[x(end), x.velocity(end)] - state).max() <= 1e-10


@pytest.mark.parametrize("level, order", [("position", 0), ("velocity", 1), ("acceleration", 2)])
def test_a_step_jumps_at_its_level(level, order):
    """The prescribed derivative jumps by the step, at the time of the step; above position level the road's lower ones are continuous."""
    x = quarter_car(mb.step([0.5]).delayed(1.0), level).solve()
    jumps = x.events[0].jump if x.events else np.zeros((2, 2))
    assert [jumps[k, 0] for k in range(2)] == [0.5 * (k == order) for k in range(2)]
    assert abs(x.derivative(order)(1.5)[0] - 0.5) <= 1e-15
    # The damper passes a jump of the road on: the impulse c times the jump changes the momentum of the car.
    assert jumps[1, 1] == pytest.approx(DAMPING * 0.5 / MASS if order == 0 else 0.0, abs=1e-15)
    impulses = [load.impulses[0][0] for load in x.later_constraint_impulses]
    assert impulses == pytest.approx([DAMPING * 0.5] if order == 0 else [], rel=1e-14)


def test_the_start_of_a_sine_is_reported_as_a_jump_of_the_velocity():
    texts = [notice.text for notice in quarter_car(SINE).solve().notices]
    assert texts[0] == (
        'prescribed motion "base" (position level) starts with the velocity 0.3 m/s, which is 0 m/s at 0-: it jumps at t = 0'
    )
    assert "road: its velocity jumps at t = 0 by 0.3 m/s" in texts[1]
    assert quarter_car(SINE).solve(velocity=[0.3, 0.0]).notices == ()


def test_what_remains_after_a_record_is_reported_with_its_size():
    """A triangle of acceleration of 1 m/s^2 over 2 s leaves 1 m/s and 1 m."""
    record = mb.sampled([0.0, 1.0, 2.0], [[0.0, 1.0, 0.0]])
    (notice,) = quarter_car(record, "acceleration").solve().notices
    assert (
        notice.kind == "drift" and "at the end of the record, t = 2 s, the support is at 1 m and moves on at 1 m/s" in notice.text
    )
    balanced = mb.sampled([0.0, 1.0, 2.0, 3.0, 4.0], [[0.0, 1.0, 0.0, -1.0, 0.0]])
    (notice,) = quarter_car(balanced, "acceleration").solve().notices
    assert "moves on" not in notice.text


def test_the_displacement_after_a_pulse_is_the_one_intended_a_velocity_is_reported():
    move = mb.pulse([1.0], duration=4.0, shape="versed-sine")  # of the velocity: 2 m
    motion = quarter_car(move, "velocity").solve()
    assert motion.notices == () and motion.of("road")(5.0) == pytest.approx(2.0, abs=1e-14)
    (notice,) = quarter_car(move, "acceleration").solve().notices
    assert "at the end of the input, t = 4 s, the support is at 4 m and moves on at 2 m/s" in notice.text
    assert "baseline" not in notice.text


def test_rows_that_repeat_a_motion_are_redundant_at_every_level():
    rows = [
        mb.Constraint([1.0, 0.0], value=SINE, names="base"),
        mb.Constraint([2.0, 0.0], value=2 * SINE, names="twice"),
        mb.Constraint([1.0, 0.0], level="velocity", value=mb.harmonic([0.1 * RATE], angular_frequency=RATE), names="rate"),
    ]
    system = mb.MechanicalSystem(np.diag([1.0, MASS]), constraints=rows)
    assert [row.name for row in system.rows] == ["base"]
    assert [notice.kind for notice in system.notices] == ["redundant", "redundant"]


@pytest.mark.parametrize(
    "other, when",
    [
        (1.1 * SINE, "at t = 0 s its derivative of order 1 is 0.33 instead of 0.3"),
        (SINE + mb.step([0.01]).delayed(2.0), "at t = 2 s its value is"),
        (0.0, "at t = 0 s its derivative of order 1 is 0 instead of 0.3"),
    ],
)
def test_rows_that_prescribe_different_motions_contradict_each_other(other, when):
    rows = [mb.Constraint([1.0, 0.0], value=SINE, names="base"), mb.Constraint([1.0, 0.0], value=other, names="other")]
    with pytest.raises(mb.ContradictoryConstraints) as error:
        mb.MechanicalSystem(np.eye(2), constraints=rows)
    assert 'constraint "other" (position level)' in str(error.value) and '"base" (position level)' in str(error.value)
    assert when in str(error.value)


def test_a_signal_of_another_number_of_rows_is_refused():
    with pytest.raises(mb.InputError, match="found a signal with 3 rows; expected one row, or one for each of the 2 rows"):
        mb.Constraint(np.eye(2), value=mb.step([1.0, 2.0, 3.0]))


def test_sparse_matrices_refuse_a_prescribed_motion():
    with pytest.raises(mb.InputError, match="found a prescribed motion; sparse matrices accept constant values only"):
        mb.MechanicalSystem(scipy.sparse.eye_array(2), constraints=[mb.Constraint([1.0, 0.0], value=SINE)])


def test_proved_values_and_reactions_contain_the_motion():
    x = quarter_car(SINE).solve()
    for box, value in [(x.enclose(TIMES[1:9:2]), x(TIMES[1:9:2])), (x.enclose(1.0, of="reaction"), x.reaction(1.0))]:
        assert np.abs(value - np.array(box.lower, dtype=float)).max() <= 1e-13 * np.abs(value).max()


def test_the_explicit_acceleration_takes_the_prescribed_one():
    """At t = 0.2 s the road's acceleration is -0.1 w^2 sin(w t), whatever its level."""
    expected = -0.1 * RATE**2 * np.sin(RATE * 0.2)
    system = mb.MechanicalSystem(np.eye(2), constraints=[mb.Constraint([1.0, 0.0], value=SINE)])
    assert system.acceleration([0, 0], [0, 0], time=0.2)[0] == pytest.approx(expected, rel=1e-13)


def test_relative_motion_is_that_to_a_row_or_a_coordinate():
    x = quarter_car(SINE).solve()
    for rate, order in ((x.displacement, 0), (x.velocity, 1), (x.acceleration, 2)):
        values = rate(TIMES)
        expected = values - values[0]
        assert (rate(TIMES, relative_to="base") == expected).all() and (rate(TIMES, relative_to="road") == expected).all(), order
    assert (x.displacement(TIMES, relative_to="ground") == x(TIMES)).all()
    both = quarter_car(SINE).solve(displacement=[[0.0, 0.0], [0.0, 1.0]])
    assert both.displacement(TIMES, relative_to="base").shape == (2, 2, len(TIMES))
    assert (both.displacement(1.0, relative_to="base")[:, 0] == 0.0).all()
    with pytest.raises(mb.InputError, match='relative_to: there is no "bse"; did you mean "base"'):
        x.displacement(TIMES, relative_to="bse")


@given(
    st.integers(2, 6),
    st.integers(0, 10**6),
    st.sampled_from(["position", "velocity", "acceleration"]),
)
def test_a_chain_on_a_moving_support_is_that_in_relative_coordinates(count, seed, level):
    """y = x - u(t) of a chain between a moving support and nothing: M y'' + C y' + K y = -M 1 u''."""
    random = np.random.default_rng(seed)
    springs, masses = random.uniform(0.5, 2.0, count), random.uniform(0.5, 2.0, count)
    B = np.eye(count, count + 1, 1) - np.eye(count, count + 1)
    K = B.T @ np.diag(springs) @ B
    rates = [mb.harmonic([0.1], angular_frequency=1.7), mb.harmonic([-0.17], angular_frequency=1.7, phase=-np.pi / 2)]
    rates.append(mb.harmonic([-0.289], angular_frequency=1.7))
    order = ["position", "velocity", "acceleration"].index(level)
    road = mb.Constraint(np.eye(1, count + 1)[0], level=level, value=rates[order])
    whole = mb.MechanicalSystem(np.diag(np.r_[0.0, masses]), 0.02 * K, K, [road])
    start = np.full(count + 1, 0.1)
    x = whole.solve(displacement=start)
    relative = mb.MechanicalSystem(np.diag(masses), 0.02 * K[1:, 1:], K[1:, 1:], force=rates[2].mapped(-masses[:, None]))
    y = relative.solve()
    size = np.abs(y(TIMES)).max()
    assert np.abs(x(TIMES)[1:] - x(TIMES)[0] - y(TIMES)).max() <= 1e-11 * max(size, 1.0)
