"""Energy over time and shares of energy: by hand, against a symmetric eigenproblem, against the time integral over a cycle."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg
from hypothesis import assume, given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.mechanics.constraints import Constraint
from mbconstrained.mechanics.element_matrix import ElementMatrix
from mbconstrained.mechanics.energy import CoordinateParts, EnergyParts
from mbconstrained.mechanics.modes import Mode
from mbconstrained.mechanics.system import MechanicalSystem
from tests.mechanics.systems import massless_joints, two_masses

EPS = np.finfo(float).eps
numbers = st.floats(0.5, 2.0)


def chain(masses, springs, dampers=(), walls=2):
    """Masses in a row between two walls, or hanging on one, or free; springs "s0", "s1", … and dampers from left to right."""
    model = mb.LumpedModel()
    names = [f"m{i}" for i in range(len(masses))]
    for name, mass in zip(names, masses):
        model.mass(name, mass)
    places = [*(["ground"] * (walls > 0)), *names, *(["ground"] * (walls > 1))]
    for i, (ends, stiffness) in enumerate(zip(pairwise(places), springs)):
        model.spring(*ends, stiffness=stiffness, name=f"s{i}")
    for ends, damping in zip(pairwise(places), dampers):
        model.damper(*ends, damping=damping)
    return model


def values(shares):
    return np.array(list(shares.values()))


def test_torsion_springs_and_gears_count_too():
    model = mb.LumpedModel()
    model.inertia("motor", 2.0), model.inertia("wheel", 8.0)
    model.node("pinion", rotational=True)
    model.torsion_spring("motor", "pinion", 6.0, name="shaft")
    model.torsion_spring("ground", "wheel", 16.0, name="brake")
    model.gear("pinion", "wheel", start_radius=1.0, end_radius=2.0)
    # on the shaft of the motor: 2 and 8/4 kg m^2, springs 6 and 16/4 N m/rad; w^2 = 4 -+ sqrt 10
    squares, shapes = scipy.linalg.eigh([[6.0, -6.0], [-6.0, 10.0]], [[2.0, 0.0], [0.0, 2.0]])
    found = model.assemble().modes()
    assert [mode.natural_frequency**2 for mode in found] == pytest.approx(squares, rel=1e-13)
    for mode, (motor, pinion) in zip(found, shapes.T):
        kinetic, strain = 2 * np.array([motor, pinion]) ** 2, np.array([6 * (motor - pinion) ** 2, 4 * pinion**2])
        assert list(mode.shares[0].kinetic) == ["motor", "wheel"]  # the pinion has no inertia
        assert values(mode.shares[0].kinetic) == pytest.approx(kinetic / kinetic.sum(), abs=1e-13)
        assert list(mode.shares[0].strain) == ["shaft", "brake"]
        assert values(mode.shares[0].strain) == pytest.approx(strain / strain.sum(), abs=1e-13)


@given(st.integers(1, 6), st.data())
def test_shares_agree_with_the_symmetric_eigenproblem(count, data):
    masses = np.array(data.draw(st.lists(numbers, min_size=count, max_size=count)))
    springs = np.array(data.draw(st.lists(numbers, min_size=count + 1, max_size=count + 1)))
    system = chain(masses, springs).assemble()
    squares, shapes = scipy.linalg.eigh(system.stiffness, np.diag(masses))
    assume(count == 1 or np.diff(squares).min() > 0.05)  # nearer ones have shapes that rounding turns into each other
    B = np.eye(count + 1, count) - np.eye(count + 1, count, k=-1)
    modes = system.modes()
    assert len(modes) == count
    for mode, shape in zip(modes, shapes.T):
        kinetic, strain = masses * shape**2, springs * (B @ shape) ** 2
        assert np.allclose(values(mode.shares[0].kinetic), kinetic / kinetic.sum(), rtol=0, atol=1e-12)
        assert np.allclose(values(mode.shares[0].strain), strain / strain.sum(), rtol=0, atol=1e-12)


@given(st.integers(2, 4), st.data())
def test_shares_of_damped_modes_are_averages_over_a_cycle(count, data):
    def draw(size, largest=2.0):
        return np.array(data.draw(st.lists(st.floats(largest / 4, largest), min_size=size, max_size=size)))

    masses, springs = draw(count), draw(count + 1)
    system = chain(masses, springs, draw(count + 1, 0.5)).assemble()
    B = np.eye(count + 1, count) - np.eye(count + 1, count, k=-1)
    phases = np.exp(2j * np.pi * np.arange(8) / 8)  # enough points for the mean of a square of one harmonic to be exact
    for mode in system.modes().oscillating:
        for shape, shares in zip(mode.shapes.T, mode.shares):
            moving = np.outer(shape, phases).real
            velocity = np.outer(1j * shape, phases).real
            kinetic = (masses[:, None] * velocity**2).mean(axis=1)
            strain = (springs[:, None] * (B @ moving) ** 2).mean(axis=1)
            assert np.allclose(values(shares.kinetic), kinetic / kinetic.sum(), rtol=0, atol=1e-13)
            assert np.allclose(values(shares.strain), strain / strain.sum(), rtol=0, atol=1e-13)


@given(st.integers(1, 5), st.data())
def test_shares_sum_to_one_whatever_length_and_phase(count, data):
    def draw(*shape):
        flat = data.draw(st.lists(st.floats(-1, 1), min_size=int(np.prod(shape)), max_size=int(np.prod(shape))))
        return np.reshape(flat, shape)

    F, G = draw(count, count), draw(count, count)
    whole = F @ F.T + np.eye(count), G @ G.T + np.eye(count)
    parts = [
        CoordinateParts([f"x{i}" for i in range(count)], *whole),
        EnergyParts({"hub": np.eye(count), "rim": F @ F.T}, {"bed": np.eye(count), "net": ElementMatrix(G.T, np.ones(count))}),
    ]
    shape = draw(count) + 1j * draw(count)
    shape[0] += 2.0
    factor = 10.0 ** data.draw(st.integers(-250, 250)) * np.exp(1j * data.draw(st.floats(0, 6)))
    for part in parts:
        one, other = part.shares(shape), part.shares(factor * shape)
        for kind in ("kinetic", "strain"):
            shares = getattr(one, kind)
            assert sum(shares.values()) == pytest.approx(1.0, abs=1e-14)
            assert getattr(other, kind) == pytest.approx(shares, abs=1e-12)


@given(st.integers(1, 5), st.data())
def test_by_coordinate_both_energies_of_a_free_mode_are_shared_alike(count, data):
    # K u = w^2 M u row by row
    G = np.reshape(data.draw(st.lists(st.floats(-1, 1), min_size=count**2, max_size=count**2)), (count, count))
    system = MechanicalSystem(np.diag(np.arange(1.0, count + 1)), stiffness=G @ G.T + np.eye(count))
    for mode in system.modes().oscillating:
        for shares in mode.shares:
            assert shares.strain == pytest.approx(shares.kinetic, abs=1e-10)


def test_by_coordinate_a_share_may_be_negative():
    # x2 = q1 + q2: M couples q1 and q2, and in the fast mode of Moysis et al., section 5.1, q1 works against q2
    row = Constraint([1, -1, 0], level="position")
    system = MechanicalSystem([[10, 0, 0], [0, 10, 10], [0, 10, 10]], stiffness=np.diag([2, 0, 2]), constraints=row)
    assert system.energy_parts.is_by_coordinate and not chain([1], [1, 1]).assemble().energy_parts.is_by_coordinate
    slow, fast = (mode.shares[0] for mode in system.modes())
    assert values(slow.kinetic) == pytest.approx([(5 - 5**0.5) / 10, 1 / 5**0.5, (5 - 5**0.5) / 10], abs=1e-13)
    assert values(fast.kinetic) == pytest.approx([(5 + 5**0.5) / 10, -1 / 5**0.5, (5 + 5**0.5) / 10], abs=1e-13)


@pytest.mark.parametrize("gear", [1.0, 1 / 3, 1e3])
def test_a_rigid_body_strains_nothing(gear):
    model = mb.LumpedModel()
    model.inertia("a", 1.0), model.inertia("b", 2.0), model.node("c", rotational=True)
    model.torsion_spring("a", "c", 1e9)
    model.gear("c", "b", start_radius=gear, end_radius=1.0)
    rigid = model.assemble().modes()[0]
    assert (rigid.kind, rigid.shares[0].strain) == ("rigid body", None)
    assert rigid.shares[0].kinetic == pytest.approx({"a": 1 / (1 + 2 * gear**2), "b": 2 * gear**2 / (1 + 2 * gear**2)})


def test_a_massless_mode_has_no_kinetic_energy():
    model = mb.LumpedModel()
    model.node("joint"), model.mass("far", 1.0)
    model.spring("ground", "joint", stiffness=5.0, name="soft")
    model.damper("ground", "joint", damping=2.0)
    model.spring("ground", "far", stiffness=700.0, name="aside")
    decay, oscillation = model.assemble().modes()
    assert (decay.kind, decay.shares[0].kinetic) == ("decay", None)
    assert decay.shares[0].strain == pytest.approx({"soft": 1.0, "aside": 0.0}, abs=1e-15)
    assert oscillation.shares[0].kinetic == {"far": 1.0}
    assert oscillation.shares[0].strain == pytest.approx({"soft": 0.0, "aside": 1.0}, abs=1e-15)


def test_what_does_not_move_or_is_not_known_has_no_shares():
    model = mb.LumpedModel()
    model.mass("sled", 2.0)
    model.damper("ground", "sled", damping=6.0)
    offset, decay = model.assemble().modes()
    assert (offset.kind, offset.shares[0].kinetic, offset.shares[0].strain) == ("offset", None, None)
    assert (decay.shares[0].kinetic, decay.shares[0].strain) == ({"sled": 1.0}, None)
    tied = MechanicalSystem(np.eye(2), constraints=Constraint([1, -1], level="acceleration"))
    assert [len(mode.shares) for mode in tied.modes()] == [1, 0]  # rigid body, drift
    assert Mode("decay", -1.0, 1, np.ones((1, 1))).shares == ()


def test_each_shape_of_a_repeated_zero_has_its_own_shares():
    model = mb.LumpedModel()
    for name in "ab":
        model.mass(name, 2.0)
        model.spring("ground", name, stiffness=8.0, name=f"spring of {name}")
    (mode,) = model.assemble().modes()
    assert mode.multiplicity == len(mode.shares) == 2
    for shape, shares in zip(mode.shapes.T, mode.shares):
        expected = shape**2 / (shape @ shape)
        assert values(shares.kinetic) == pytest.approx(expected) and values(shares.strain) == pytest.approx(expected)


@pytest.mark.parametrize("stiff", [1e8, 1e12, 1e16, 1e20])
def test_beside_stiff_springs_the_soft_ones_keep_their_shares(stiff):
    # masses 1, 1, 2 on a spring of 1 N/m and tied by stiff ones: slow mode rigid, the stiff ones carry 3/4 and 1/2 N
    slow, *fast = chain([1, 1, 2], [1.0, stiff, 2 * stiff], walls=1).assemble().modes()
    strain = slow.shares[0].strain
    assert strain["s0"] == pytest.approx(1.0, rel=0, abs=4 * EPS + 2 / stiff)
    assert 0 <= strain["s1"] <= 2 / stiff and 0 <= strain["s2"] <= 2 / stiff
    for mode in fast:
        shares = mode.shares[0]  # 1 N/m u^2 and w^2 1 kg u^2, and as much strain energy as kinetic energy
        assert shares.strain["s0"] == pytest.approx(shares.kinetic["m0"] / mode.natural_frequency**2)


def test_an_assembled_matrix_that_has_lost_its_soft_spring_says_so():
    # 1e17 + 1 = 1e17: of the strain energy of the slow motion nothing is left but rounding
    K = np.array([[1e17, -1e17], [-1e17, 1e17]])
    assert CoordinateParts(["a", "b"], np.eye(2), K).shares([1.0, 1.0 + EPS]).strain is None
    elements = ElementMatrix([[1, 0], [-1, 1]], [1.0, 1e17])
    assert CoordinateParts(["a", "b"], np.eye(2), elements).shares([1.0, 1.0 + EPS]).strain == {"a": 1.0, "b": 0.0}


def test_gravity_may_be_a_negative_part():
    # an inverted pendulum on a spring: 5 - 9 N m/rad
    parts = EnergyParts({"bob": [[1.0]]}, {"spring": [[5.0]], "gravity": [[-9.0]]})
    pendulum = MechanicalSystem([[1.0]], stiffness=[[-4.0]], energy_parts=parts)
    assert pendulum.energy_parts is parts
    for mode in pendulum.modes():
        assert mode.shares[0].strain == pytest.approx({"spring": -1.25, "gravity": 2.25})
    balanced = EnergyParts({"bob": [[1.0]]}, {"spring": [[9.0]], "gravity": [[-9.0]]})
    assert balanced.shares([1.0]).strain is None


def test_the_parts_of_a_lumped_model_are_its_matrices():
    system = chain([1, 2, 3], [4, 5, 6, 7]).assemble()
    for parts, whole in ((system.energy_parts.kinetic, system.mass), (system.energy_parts.strain, system.stiffness)):
        assert (sum(part.matrix for part in parts.values()) == whole).all()


@pytest.mark.parametrize("size", [1e-150, 1e-300, 1e150, 1e300])
def test_no_square_leaves_the_range_of_numbers(size):
    springs = {"soft": ElementMatrix([[1, 0]], [size]), "stiff": ElementMatrix([[-1, 1]], [3 * size])}
    shares = EnergyParts({"a": size * np.diag([1, 0]), "b": size * np.diag([0, 1.0])}, springs).shares([size, -size], 1e-3j)
    assert shares.kinetic == pytest.approx({"a": 0.5, "b": 0.5})
    assert shares.strain == pytest.approx({"soft": 1 / 13, "stiff": 12 / 13})


def test_errors_at_the_door():
    with pytest.raises(mb.InputError, match="found parts of 1 and 2 coordinates"):
        EnergyParts({"a": [[1.0]]}, {"s": np.eye(2)})
    with pytest.raises(mb.InputError, match='strain part "s": expected a square matrix, found 1 x 2'):
        EnergyParts({}, {"s": [[1.0, 2.0]]})
    with pytest.raises(mb.InputError, match='kinetic part "a"'):
        EnergyParts({"a": [[np.nan]]}, {})
    with pytest.raises(mb.InputError, match="found parts of 1 coordinates; expected EnergyParts of 2 coordinates"):
        MechanicalSystem(np.eye(2), energy_parts=EnergyParts({"a": [[1.0]]}, {}))
    with pytest.raises(mb.InputError, match="found a dict; expected EnergyParts of 1 coordinate"):
        MechanicalSystem([[1.0]], energy_parts={"a": [[1.0]]})
    parts = EnergyParts({"a": [[1.0]]}, {})
    wrong = {"zeros only": [0.0], "is inf": [np.inf], "expected shape 1": [1.0, 2.0], "is nan": [1j * np.nan]}
    for words, shape in {**wrong, "expected numbers": ["a"]}.items():
        with pytest.raises(mb.InputError, match=words):
            parts.shares(shape)
    assert parts.shares([3.0]).strain is None


# Energy over time.

TIMES = np.linspace(0, 40, 81)


def test_the_parts_by_hand():
    system = MechanicalSystem([[2.0]], stiffness=[[3.0]], static_force=[5.0])
    energy = system.solve([4.0], [1.0]).energy(0.0)
    assert (energy.kinetic, energy.strain, energy.static, energy.total) == pytest.approx((1.0, 24.0, -20.0, 5.0))


def test_a_spring_with_a_rest_length_stores_what_its_elongation_says():
    # 1/2 k (x - l)^2 = strain + static + 1/2 k l^2
    k, length = 3.0, 0.4
    motion = MechanicalSystem([[2.0]], stiffness=[[k]], static_force=[k * length]).solve([1.0])
    energy = motion.energy(TIMES)
    assert np.allclose(energy.strain + energy.static + k * length**2 / 2, k * (motion(TIMES)[0] - length) ** 2 / 2)


@pytest.mark.parametrize("level, value", [("acceleration", 0.0), ("velocity", 0.0), ("position", -0.4)])
def test_it_is_kept_without_dampers(level, value):
    total = two_masses(level, value=value).solve([0.8, 1.2, 2.0]).energy(TIMES).total
    assert np.allclose(total, 4.64, rtol=1e-12)  # 1/2 k (0.8^2 + 2^2)


def test_it_is_kept_with_constant_forces_and_ties():
    system = MechanicalSystem(
        np.diag([1.0, 2.0, 0.5]),
        stiffness=[[2, -1, 0], [-1, 4, -3], [0, -3, 3]],
        constraints=Constraint([2, 0, -1]),
        static_force=[-9.81, 1.0, 0.3],
    )
    total = system.solve([0.1, 0.5, 0.2], [1, 0, 2]).energy(TIMES).total
    assert np.allclose(total, total[0], rtol=0, atol=1e-11 * np.abs(total).max())


def test_dampers_take_it_at_the_rate_of_their_power():
    motion = massless_joints().solve([2 / 3, 1, 2])
    total = motion.energy(TIMES).total
    assert (np.diff(total) < 0).all()
    times = np.linspace(0, 2, 4001)
    velocity = motion.velocity(times)
    power = np.einsum("it,ij,jt->t", velocity, motion.system.damping, velocity)
    lost = np.trapezoid(power, times)
    assert np.isclose(motion.energy(0.0).total - motion.energy(2.0).total, lost, rtol=1e-6)


def test_gyroscopic_forces_do_no_work():
    spin = MechanicalSystem(np.eye(2), [[0, 3], [-3, 0]], np.diag([1.0, 2.0]))
    total = spin.solve([1, 0], [0, 1]).energy(TIMES).total
    assert np.allclose(total, total[0], rtol=1e-12)
