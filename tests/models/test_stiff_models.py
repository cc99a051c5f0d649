"""Stiff models keep their soft elements: errors stay near the floor that the condition of the motion sets.

A frequency known to a unit in the last place moves the phase by w t eps: no answer in float64 can be better. The
floor of a motion is that of the fastest zero that takes part in it.
"""

import mpmath
import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.tolerances import EPS, PRECISE_STATES
from tests.oracles.stiff import motion as exact_motion

FLOORS = 100


def chain(ratio: float, damped: bool, count: int = 8) -> mb.LumpedModel:
    """Unit masses, soft and stiff springs in turn, the first one at the ground."""
    model, before = mb.LumpedModel(), "ground"
    for i in range(count):
        model.mass(f"m{i}", 1.0)
        stiffness = ratio if i % 2 else 1.0
        model.spring(before, f"m{i}", stiffness=stiffness)
        if damped:
            model.damper(before, f"m{i}", damping=1e-3 * stiffness**0.5)
        before = f"m{i}"
    return model


def network(ratio: float, damped: bool, count: int = 6) -> mb.LumpedModel:
    """A chain with as many springs across it, all of random stiffness in 1 ... ratio, masses in 1 ... 2."""
    random, model = np.random.default_rng(5), mb.LumpedModel()
    for i in range(count):
        model.mass(f"m{i}", 1.0 + random.random())
    ends = [(i - 1, i) for i in range(count)] + [tuple(random.choice(count, 2, replace=False)) for _ in range(count)]
    for start, end in ends:
        names = ("ground" if start < 0 else f"m{start}", f"m{end}")
        model.spring(*names, stiffness=float(ratio ** random.random()))
        if damped:
            model.damper(*names, damping=float(1e-3 * ratio ** (random.random() / 2)))
    return model


def smooth(model: mb.LumpedModel) -> np.ndarray:
    """The static shape under a unit force on every mass of the chain: slow motions alone."""
    constants = model.incidence().springs.constants
    return np.cumsum([(len(constants) - i) / constant for i, constant in enumerate(constants)])


@pytest.mark.parametrize(
    "ratio", [1e4, pytest.param(1e8, marks=pytest.mark.long), pytest.param(1e12, marks=pytest.mark.long), 1e16]
)
@pytest.mark.parametrize("damped", [False, True])
def test_slow_motion_of_a_stiff_chain_over_1000_periods(ratio, damped):
    """Only slow zeros take part: the floor is theirs, however stiff the rest is."""
    model = chain(ratio, damped)
    times = 1000 * 2 * np.pi / 0.2455756 * np.linspace(0, 1, 7)
    truth, moduli = exact_motion(model, smooth(model), times)
    x = model.assemble().solve(displacement=smooth(model))
    error = np.abs(x(times) - truth).max() / np.abs(truth).max()
    assert error <= FLOORS * moduli[0] * times[-1] * EPS
    assert x.error_estimate(times) >= 0.1 * error


@pytest.mark.parametrize("ratio", [pytest.param(1e4, marks=pytest.mark.long), pytest.param(1e10, marks=pytest.mark.long), 1e16])
@pytest.mark.parametrize("damped", [False, True])
@pytest.mark.parametrize("make", [chain, network])
def test_any_motion_of_a_stiff_model(make, ratio, damped):
    """All zeros take part: the floor is that of the fastest."""
    model = make(ratio, damped)
    start = np.random.default_rng(0).normal(size=len(model.coordinates))
    times = 1000 * np.linspace(0, 1, 7)
    truth, moduli = exact_motion(model, start, times)
    x = model.assemble().solve(displacement=start)
    error = np.abs(x(times) - truth).max() / np.abs(truth).max()
    assert error <= max(FLOORS * EPS, moduli[-1] * times[-1] * EPS)
    assert 0.1 * error <= x.error_estimate(times)


def test_zeros_of_a_stiff_model_are_right_to_the_last_digits():
    model = chain(1e16, damped=False)
    _, moduli = exact_motion(model, np.ones(8), [])
    found = model.assemble().modes().natural_frequencies
    assert np.abs(found / moduli[::2] - 1).max() <= 10 * EPS


def test_a_rigid_body_stays_one_among_stiff_springs():
    """Without the ground the chain moves freely: exactly two zeros at 0, and the rest where it belongs."""
    model, before = mb.LumpedModel(), None
    for i, stiffness in enumerate([None, 1e16, 1.0, 1e15, 3.0]):
        model.mass(f"m{i}", 1.0)
        if before:
            model.spring(before, f"m{i}", stiffness=stiffness)
        before = f"m{i}"
    system = model.assemble()
    zeros = system.polynomial_matrix().structure().finite_zeros
    assert [(zero.value, zero.multiplicity) for zero in zeros if zero.value == 0] == [(0, 2)]
    x = system.solve(velocity=np.ones(5))
    times = np.array([0.0, 1.0, 1e6])
    assert np.abs(x(times) - times).max() <= 1e-9  # 1e6 m in steps of 1e-10 m


def test_massless_joints_in_a_stiff_model():
    """Springs 1e14 and 2 in series over a joint are one spring of 2e14 / (1e14 + 2), beside a spring of 1e-3."""
    with_joint, without = mb.LumpedModel(), mb.LumpedModel()
    for model in (with_joint, without):
        model.mass("cart", 3.0)
        model.mass("load", 1.0)
        model.spring("ground", "cart", stiffness=1e-3)
        model.spring("cart", "load", stiffness=1e13)
    with_joint.node("joint")
    with_joint.spring("ground", "joint", stiffness=1e14)
    with_joint.spring("joint", "cart", stiffness=2.0)
    without.spring("ground", "cart", stiffness=2e14 / (1e14 + 2.0))
    times = np.linspace(0.0, 1e4, 9)
    truth, _ = exact_motion(without, [0.5, 0.5], times)
    x = with_joint.assemble().solve(displacement={"cart": 0.5, "load": 0.5, "joint": 0.5 * 2.0 / (1e14 + 2.0)})
    assert np.abs(x(times)[:2] - truth).max() <= FLOORS * EPS * 1e4
    assert not x.impulses


def test_rigid_ties_and_levers_in_a_stiff_model():
    """A lever of ratio 2 to a stiff spring: the cart feels four times its stiffness; a soft spring sets the slow motion."""
    tied, plain = mb.LumpedModel(), mb.LumpedModel()
    for model in (tied, plain):
        model.mass("cart", 1.0)
        model.mass("load", 2.0)
        model.spring("cart", "load", stiffness=4e15)
        model.spring("ground", "load", stiffness=1.0)
    tied.mass("arm", 1.0)
    tied.lever("cart", "arm", 1.0, 2.0)  # x_arm = -2 x_cart
    tied.spring("ground", "arm", stiffness=0.25)
    tied.spring("load", "arm", stiffness=0.125)
    # in the coordinates cart, load the tied model has mass 1 + 4, stiffness 4 * 0.25 and 0.125 (load + 2 cart)^2
    with mpmath.workdps(60):
        K = mpmath.matrix([[4e15 + 1, -4e15], [-4e15, 4e15 + 1]])
        K[0, 0] = mpmath.mpf("4e15") + 1 + mpmath.mpf("0.5")
        K[1, 1] = mpmath.mpf("4e15") + 1 + mpmath.mpf("0.125")
        K[0, 1] = K[1, 0] = -mpmath.mpf("4e15") + mpmath.mpf("0.25")
        M = mpmath.matrix([[5, 0], [0, 2]])
        truth = sorted(float(mpmath.sqrt(value)) for value in mpmath.eig(M**-1 * K, left=False, right=False))
    found = tied.assemble().modes().natural_frequencies
    assert np.abs(found / truth - 1).max() <= 10 * EPS


def test_elements_and_matrices_agree_where_nothing_is_lost():
    """The same system as elements and assembled, all constants whole numbers."""
    B, k = [[1, 0, 0], [-1, 1, 0], [0, -1, 1]], [1.0, 1000.0, 5.0]
    elements = mb.ElementMatrix(B, k)
    start, times = [1.0, 0.0, -1.0], np.linspace(0, 20, 5)
    by_elements = mb.MechanicalSystem(np.eye(3), stiffness=elements).solve(start)
    assembled = mb.MechanicalSystem(np.eye(3), stiffness=elements.matrix).solve(start)
    assert by_elements.pairs.polynomial_matrix.factors[0] is not None
    assert assembled.pairs.polynomial_matrix.factors[0] is None
    assert np.abs(by_elements(times) - assembled(times)).max() < 1e-11


@pytest.mark.parametrize(
    "directions, constants, words",
    [([[1, 0]], [1.0, 2.0], "directions"), ([[1, np.nan]], [1.0], "directions"), ([[1, 0]], ["stiff"], "constants")],
)
def test_elements_that_cannot_be_used(directions, constants, words):
    with pytest.raises(mb.InputError, match=words):
        mb.ElementMatrix(directions, constants)


def test_a_ratio_that_no_arithmetic_here_can_bear_is_refused():
    springs = mb.ElementMatrix([[1, 0], [1, -1]], [1.0, 1e70])
    with pytest.raises(mb.IllConditioned, match="1e\\+70 times the softest"):
        mb.MechanicalSystem(mass=np.eye(2), stiffness=springs).solve(displacement=[1.0, 1.0])


def stiff_chain(count: int):
    """Unit masses, springs of 1 N/m, and one of 1e13 N/m in the middle."""
    model, before = mb.LumpedModel(), "ground"
    for i in range(count):
        model.mass(f"m{i}", 1.0)
        model.spring(before, f"m{i}", stiffness=1e13 if i == count // 2 else 1.0)
        before = f"m{i}"
    return model.assemble()


@pytest.mark.long
def test_a_stiff_chain_of_more_than_sixty_masses_keeps_its_digits():
    """The two masses of the stiff spring move as one: the model with both in one mass of 2 kg differs by 1e-13 of its frequencies."""
    count, times = 64, np.linspace(0.0, 30.0, 7)
    motion = stiff_chain(count).solve(np.ones(count))
    K = np.diag(np.full(count - 1, 2.0)) - np.eye(count - 1, k=1) - np.eye(count - 1, k=-1)
    K[-1, -1] = 1.0
    M = np.eye(count - 1)
    M[count // 2 - 1, count // 2 - 1] = 2.0
    rigid = mb.MechanicalSystem(M, stiffness=K).solve(np.ones(count - 1))(times)
    values = np.delete(motion(times), count // 2, axis=0)
    assert motion.pairs.form.companion.is_precise and not [notice for notice in motion.notices if notice.doubtful]
    assert np.abs(values - rigid).max() < 1e-11


@pytest.mark.long
def test_larger_stiff_models_report_that_they_were_assembled():
    count = PRECISE_STATES // 2 + 1
    notices = stiff_chain(count).solve(np.ones(count)).notices
    assert [notice for notice in notices if notice.doubtful and "assembled in float64" in notice.text]


@pytest.mark.parametrize("stiffness", [1e8, 3e10, 1e12, 1e15])
def test_the_jump_after_the_derivative_of_an_impulse_does_not_depend_on_stiff_springs(stiffness):
    """A tie at velocity level carries an impulse delta': the jumps are those of the soft parts, 1/8 m and -1/64 m/s, for any k."""
    D = [[1, 0, 0], [-1, 1, 0], [0, -1, 1]]
    system = mb.MechanicalSystem(
        mass=np.diag([3.0, 0, 1]),
        stiffness=mb.ElementMatrix(D, [1, 4, stiffness]),
        damping=mb.ElementMatrix(D, [0.5, 0.1, 2]),
        constraints=[mb.Constraint([1, 0, -1], level="velocity")],
    )
    jump = system.solve(force=mb.impulse([0.5, 0, 0], order=1)).jump
    assert np.allclose(jump, [[0.125] * 3, [-0.015625] * 3], rtol=1e-6, atol=0)


def test_an_entry_beyond_the_range_is_told():
    for make in (
        lambda: mb.ElementMatrix([[1e200]], [1e200]).matrix,
        lambda: mb.MechanicalSystem(mass=mb.ElementMatrix([[1e200]], [1e200])),
        lambda: mb.PolynomialMatrix([mb.ElementMatrix([[1e200]], [1e200])]),
    ):
        with pytest.raises(mb.InputError, match="an entry beyond the range of float64"):
            make()


@pytest.mark.parametrize(
    ("constants", "spread"), [([], 1.0), ([0.0], 1.0), ([2.0, 0.0, -8.0], 4.0), ([1e-300, 1e300], np.finfo(float).max)]
)
def test_the_spread_is_a_finite_number(constants, spread):
    assert mb.ElementMatrix(np.ones((len(constants), 1)), constants).spread == spread


def test_a_polynomial_matrix_takes_elements_and_keeps_their_digits():
    springs = mb.ElementMatrix([[1, 0], [-1, 1]], [1.0, 1e16])
    A = mb.PolynomialMatrix([springs, np.zeros((2, 2)), np.eye(2)])
    assert A.exact_coefficients[0][0, 0] == 10**16 + 1
    slow = min(abs(zero.value) for zero in A.structure().finite_zeros)
    assert slow == pytest.approx(0.5**0.5, rel=1e-14)
