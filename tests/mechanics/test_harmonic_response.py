"""Quantities with their units, prescribed motions, and damping as engineers give it, against closed forms and published values."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import minimize

import mbconstrained as mb

VIBRATION = json.loads((Path(__file__).parents[1] / "oracles" / "vibration.json").read_text(encoding="utf-8"))


def row_of_eight():
    """Code_Aster V2.01.021 (SDLD21): eight masses of 10 kg, springs of 1e5 N/m and dampers of 50 N s/m, fixed at both ends."""
    model = mb.LumpedModel()
    bodies = [f"P{i}" for i in range(1, 9)]
    for body in bodies:
        model.mass(body, 10.0)
    for start, end in zip(["ground", *bodies], [*bodies, "ground"]):
        model.spring(start, end, 1e5, name=f"{start}-{end}")
        model.damper(start, end, 50.0)
    return model.assemble()


def test_published_row_of_eight_masses():
    rows = VIBRATION["SDLD21"]["rows"]
    H = row_of_eight().frequency_response([row["f"] for row in rows], ["P4"], ["P4", "P1"])
    for line, row in enumerate(rows):
        for place, name in enumerate(("P4", "P1")):
            reference = complex(float(row[f"{name}_re"]), float(row[f"{name}_im"]))
            assert abs(H.values[place, 0, line] - reference) <= 1e-13 * abs(reference)


def tuned_mass_damper(ratio, zeta, mu=0.05):
    """Unit main mass and frequency; a damper of mass mu, tuned to a frequency ratio, with a damping ratio (Den Hartog)."""
    model = mb.LumpedModel()
    model.mass("main", 1.0)
    model.mass("damper", mu)
    model.spring("ground", "main", 1.0)
    model.spring("main", "damper", mu * ratio**2)
    model.damper("main", "damper", 2 * zeta * mu * ratio)
    return model.assemble().frequency_response([0.1], ["main"], ["main"])


def highest(parameters):
    return max(peak.amplitude for peak in tuned_mass_damper(*parameters).peaks)


@pytest.mark.long
def test_tuned_mass_damper_of_den_hartog_and_the_exact_optimum():
    values = VIBRATION["tuned_mass_damper"]
    np.testing.assert_allclose(
        highest((values["den_hartog"]["f"], values["den_hartog"]["zeta"])), values["den_hartog"]["peak"], rtol=1e-12
    )
    best = values["hinf"]
    np.testing.assert_allclose(highest((best["f"], best["zeta"])), best["peak"], rtol=1e-9)
    found = minimize(highest, (0.95, 0.13), method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-10, "maxiter": 80})
    assert best["peak"] * (1 - 1e-9) <= found.fun <= best["peak"] * (1 + 1e-4)


def isolated(zeta):
    """A machine of 1 kg on a spring of 4 N/m; the floor is moved."""
    model = mb.LumpedModel()
    model.node("floor")
    model.mass("machine", 1.0)
    model.spring("floor", "machine", 4.0)
    model.damper("floor", "machine", 4.0 * zeta)
    model.constrain({"floor": 1.0}, name="base")
    return model.assemble()


@pytest.mark.parametrize("zeta", [0.01, 0.1, 0.7])
def test_transmissibility_is_one_at_sqrt_2_times_the_natural_frequency_for_every_damping(zeta):
    f = np.array([0.2, np.sqrt(2) / np.pi, 3.0])
    T = isolated(zeta).frequency_response(f, ["base"], ["machine"], quantity="transmissibility")
    s = 2j * np.pi * f
    np.testing.assert_allclose(T.values[0, 0], (4 * zeta * s + 4) / (s**2 + 4 * zeta * s + 4), rtol=1e-13)
    np.testing.assert_allclose(abs(T.values[0, 0, 1]), 1.0, rtol=1e-14)
    assert T.units.tolist() == [["1"]]


def test_relative_motion_of_an_isolated_machine_is_that_of_a_seismometer():
    """x - u = -s^2 / (s^2 + 2 zeta w s + w^2) u; the machine relative to the ground is its absolute motion."""
    f, system = np.array([0.01, 0.3, 5.0]), isolated(0.1)
    s = 2j * np.pi * f
    get = lambda other: system.frequency_response(f, ["base"], ["machine", "floor"], "transmissibility", relative_to=other)  # noqa: E731
    relative, absolute = get("base"), get("ground")
    np.testing.assert_allclose(relative.values[0, 0], -(s**2) / (s**2 + 0.4 * s + 4), rtol=1e-10)
    assert not relative.values[1].any() and (absolute.values == get(None).values).all()


def test_the_reaction_at_a_moved_support_is_the_apparent_stiffness_of_what_it_carries():
    f = np.array([0.1, 1.0])
    R = isolated(0.1).frequency_response(f, ["base"], quantity="reaction")
    s = 2j * np.pi * f
    spring = 4 + 0.4 * s
    np.testing.assert_allclose(R.values[0, 0], spring * s**2 / (s**2 + spring), rtol=1e-13)
    assert R.units.tolist() == [["N/m"]]


@pytest.mark.parametrize("level, power", [("position", 0), ("velocity", 1), ("acceleration", 2)])
def test_a_row_is_an_input_at_its_level(level, power):
    system = mb.MechanicalSystem(
        np.diag([0.0, 1.0]),
        None,
        [[4.0, -4.0], [-4.0, 4.0]],
        [mb.Constraint([1, 0], level=level, names="base")],
        ["floor", "machine"],
    )
    f = 0.5
    H = system.frequency_response([f], ["base"], ["machine"])
    s = 2j * np.pi * f
    np.testing.assert_allclose(H.values.item(), 4 / (s**2 + 4) / s**power, rtol=1e-13)
    assert H.units.item() == ("1", "m/(m/s)", "m/(m/s^2)")[power]


def test_quantities_are_derivatives_and_inverses_of_each_other():
    system, f = row_of_eight(), np.array([1.0, 12.0, 40.0])
    s, names = 2j * np.pi * f, ["P2", "P5"]
    get = lambda quantity: system.frequency_response(f, names, names, quantity)  # noqa: E731
    receptance = get("receptance")
    for power, (quantity, inverse, unit) in enumerate(
        [
            ("receptance", "dynamic stiffness", "N/m"),
            ("mobility", "impedance", "N/(m/s)"),
            ("accelerance", "apparent mass", "N/(m/s^2)"),
        ]
    ):
        H, Z = get(quantity), get(inverse)
        np.testing.assert_allclose(H.values, receptance.values * s**power, rtol=1e-13)
        product = np.einsum("ijf,jkf->fik", H.values, Z.values)
        np.testing.assert_allclose(product, np.broadcast_to(np.eye(2), (3, 2, 2)), atol=1e-12)
        assert Z.units.tolist() == [[unit] * 2] * 2


def test_structural_damping_of_the_model_and_of_single_springs():
    system, f = row_of_eight(), 7.0
    w = 2 * np.pi * f
    H = system.frequency_response([f], ["P1"], ["P8"], loss_factor=0.04)
    exact = np.linalg.inv(system.stiffness * (1 + 0.04j) + 1j * w * system.damping - w**2 * system.mass)
    np.testing.assert_allclose(H.values.item(), exact[7, 0], rtol=1e-11)
    part = np.zeros((8, 8))
    part[:2, :2] = 1e5 * np.array([[1, -1], [-1, 1]])
    H = system.frequency_response([f], ["P1"], ["P8"], loss_factor={"P1-P2": 0.5})
    exact = np.linalg.inv(system.stiffness + 0.5j * part + 1j * w * system.damping - w**2 * system.mass)
    np.testing.assert_allclose(H.values.item(), exact[7, 0], rtol=1e-11)
    total = sum(R[0, 0, 0] / (1j * w - pole) for pole, R in zip(H.poles, H.residues))
    np.testing.assert_allclose(H.values.item(), total, rtol=1e-7)


def test_springs_of_a_lumped_model_have_loss_factors_of_their_own():
    """Against the same by name; a value by name goes before, one of the whole model replaces all; in time it is refused."""

    def model(*etas):
        built = mb.LumpedModel()
        built.mass("a", 1.0)
        built.inertia("b", 2.0)
        built.spring("ground", "a", 100.0, name="k", loss_factor=etas[0])
        built.torsion_spring("ground", "b", 50.0, name="t", loss_factor=etas[1])
        built.rack("b", "a", radius=0.5)
        return built.assemble()

    f, bare, lossy = [0.5, 1.3], model(0.0, 0.0), model(0.1, 0.2)
    get = lambda system, eta=None: system.frequency_response(f, ["a"], ["a"], loss_factor=eta).values  # noqa: E731
    s = 2j * np.pi * np.array(f)
    np.testing.assert_allclose(get(lossy)[0, 0], 1 / (9 * s**2 + 100 * (1 + 0.1j) + 200 * (1 + 0.2j)), rtol=1e-12)
    assert (get(lossy) == get(bare, {"k": 0.1, "t": 0.2})).all()
    assert (get(lossy, {"k": 0.3}) == get(bare, {"k": 0.3, "t": 0.2})).all()
    assert (get(lossy, 0.05) == get(bare, 0.05)).all()
    with pytest.raises(mb.InputError, match='the spring "k" has a loss factor.*harmonic motion only'):
        lossy.solve([1.0, 0.0])
    with pytest.raises(mb.InputError, match="loss factor"):
        model(-0.1, 0.0)


def test_modal_damping_gives_each_mode_its_ratio():
    system = mb.MechanicalSystem(np.diag([1.0, 2.0, 0.0]), None, [[5.0, -3.0, 0.0], [-3.0, 4.0, -1.0], [0.0, -1.0, 1.5]])
    ratios = [0.01, 0.03]
    H = system.frequency_response([0.1], modal_damping=ratios)
    above = H.poles[H.poles.imag > 0]
    np.testing.assert_allclose(-above.real / np.abs(above), ratios, rtol=1e-12)
    np.testing.assert_allclose(np.abs(above), system.modes().natural_frequencies, rtol=1e-12)


@pytest.mark.parametrize(
    "arguments, message",
    [
        (dict(inputs=["P9"]), 'did you mean "P8"|P'),
        (dict(inputs=[]), "none was named"),
        (dict(quantity="receptence"), "receptance"),
        (dict(quantity="transmissibility"), "is a force"),
        (dict(quantity="reaction", outputs=["P1"]), "expected constraint rows"),
        (dict(quantity="impedance", inputs=["P1"]), "as many forces"),
        (dict(modal_damping=-0.01), "expected 0 or a positive"),
        (dict(loss_factor={"spring": 0.1}), "no spring"),
        (dict(loss_factor=-0.1), "at least 0"),
        (dict(inputs=["P1", "P1"]), "twice"),
    ],
)
def test_what_does_not_fit_is_refused(arguments, message):
    with pytest.raises(mb.InputError, match=message):
        row_of_eight().frequency_response([1.0], **arguments)


def test_a_next_grid_has_what_the_first_has_computed_and_the_same_bits():
    system, lines = row_of_eight(), np.linspace(1.0, 30.0, 40)
    first, following = (system.frequency_response(f, ["P4"], ["P1"]) for f in (lines, lines + 0.1))
    assert following.harmonic is first.harmonic
    alone = row_of_eight().frequency_response(lines + 0.1, ["P4"], ["P1"])
    np.testing.assert_array_equal(following.values, alone.values)
    np.testing.assert_array_equal(following.error_estimate, alone.error_estimate)


def test_a_changed_system_or_question_is_computed_anew():
    system = row_of_eight()
    of_forces = system.frequency_response([10.0], ["P4"], ["P1"])
    tied = system.with_constraints(mb.Constraint(np.eye(8)[0])).frequency_response([10.0], ["P4"], ["P1"])
    assert tied.values.item() == 0.0 != of_forces.values.item()
    damped = system.frequency_response([10.0], ["P4"], ["P1"], loss_factor=0.1)
    assert abs(damped.values.item()) != abs(of_forces.values.item())
    accelerance = system.frequency_response([10.0], ["P4"], ["P1"], "accelerance")
    np.testing.assert_allclose(accelerance.values, -((20 * np.pi) ** 2) * of_forces.values, rtol=1e-14)
