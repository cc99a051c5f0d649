"""A factor of 1 is the scene itself; at another factor it is the scene with that number in the file."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.analyses.stability import scaling_factors
from mbconstrained.analyses.study_problem import problem_of
from mbconstrained.scene.run.scene import read_scene

#: Elements, matrices with constraint rows, coefficients, a robot, a transfer function.
KINDS = ("quarter_car", "two_masses", "flexible_joint", "four_bar", "transfer_function")

SCENE = """
[model]
kind = "lumped"
gravity = "-9.81 m/s^2"
[[model.mass]]
name = "cart"
mass = "{mass} kg"
[[model.mass]]
name = "load"
mass = "1 kg"
[[model.spring]]
name = "soft"
between = ["ground", "cart"]
stiffness = "{stiffness} N/m"
rest_length = "0.2 m"
[[model.spring]]
between = ["cart", "load"]
stiffness = "5 N/m"
[[model.damper]]
between = ["cart", "load"]
damping = "{damping} N*s/m"
[initial]
displacement = {{ cart = "0.1 m" }}
[time]
end = "3 s"
points = 31
"""


def scene(tmp_path, **numbers):
    path = tmp_path / "scene.toml"
    path.write_text(SCENE.format(**({"mass": 2, "stiffness": 8, "damping": 0.5} | numbers)))
    return read_scene(path)


@pytest.mark.parametrize("name", KINDS)
def test_a_factor_of_one_is_the_scene_itself(name):
    found = read_scene(f"examples/{name}.toml")
    expected = problem_of(found)
    factors = scaling_factors(found)
    assert list(factors)[-1] == "horizon"
    for scaled in factors.values():
        problem = scaled(1.0)
        assert np.array_equal(problem.polynomial_matrix.coefficients, expected.polynomial_matrix.coefficients)
        assert np.array_equal(problem.initial, expected.initial)
        assert set(problem.times) <= set(expected.times) and len(problem.times) <= 25
        assert np.array_equal(problem.force(problem.times), expected.force(problem.times))


@pytest.mark.parametrize(
    "name, number, factor",
    [
        ("mass of cart", {"mass": 200}, 100.0),
        ("stiffness of soft", {"stiffness": 8e6}, 1e6),
        ("damping of cart to load", {"damping": 0.005}, 0.01),
    ],
)
def test_an_element_is_turned_as_if_the_file_said_so(tmp_path, name, number, factor):
    turned = scaling_factors(scene(tmp_path))[name](factor)
    expected = problem_of(scene(tmp_path, **number)).at(turned.times)
    assert np.abs(turned.solve()(turned.times) - expected.solve()(turned.times)).max() <= 1e-14
    assert np.array_equal(turned.force(turned.times), expected.force(turned.times))  # weight and rest length with it


def test_elements_without_a_name_between_the_same_ends_are_counted(tmp_path):
    text = SCENE.format(mass=2, stiffness=8, damping=0.5) + '[[model.spring]]\nbetween = ["cart", "load"]\nstiffness = "7 N/m"\n'
    parts = text.partition("[initial]")
    model, spring = parts[2].split("[[model.spring]]")
    path = tmp_path / "twins.toml"
    path.write_text(f"{parts[0]}[[model.spring]]{spring}[initial]{model}")
    found = scaling_factors(read_scene(path))
    K = found["stiffness of cart to load (2)"](10.0).system.stiffness
    assert "stiffness of cart to load (1)" in found and -K[0, 1] == 5 + 70


def test_a_transfer_function_is_turned_as_it_is_answered(tmp_path):
    """From rest, by the same method, the numerator as it is."""
    path = tmp_path / "fraction.toml"
    model = 'kind = "transfer-function"\nnumerator = [1, 2]\ndenominator = [1, 3, 0, 4]\ngamma = 1'
    path.write_text(f"[model]\n{model}\n[time]\nend = 2\n")
    found = scaling_factors(read_scene(path))
    assert list(found) == [*(f"denominator's coefficient of s^{power}" for power in (0, 2, 3)), "horizon"]
    problem = found["denominator's coefficient of s^2"](100.0)
    truth = mb.PolynomialMatrix([[[4.0]], [[0.0]], [[300.0]], [[1.0]]])
    assert np.array_equal(problem.polynomial_matrix.coefficients, truth.coefficients) and problem.respond is not None


def test_all_of_a_kind_are_turned_together_and_each_alone(tmp_path):
    names = list(scaling_factors(scene(tmp_path)))
    assert names == [
        "all masses", "mass of cart", "mass of load", "damping of cart to load", "all springs", "stiffness of soft", "stiffness of cart to load",
        "horizon",
    ]  # fmt: skip
    together = scaling_factors(scene(tmp_path))["all masses"](10.0)
    assert np.array_equal(np.diag(together.system.mass), [20.0, 10.0])


def test_the_horizon_is_longer_at_the_same_number_of_times(tmp_path):
    problem = scaling_factors(scene(tmp_path))["horizon"](1e6)
    assert problem.times[-1] == 3e6 and len(problem.times) == 25


def test_matrices_are_turned_as_wholes_with_what_they_may_be_wrong_by():
    robot = read_scene("examples/four_bar.toml")
    before = problem_of(robot).system
    turned = {name: scaled(1e3) for name, scaled in scaling_factors(robot).items()}
    assert np.array_equal(turned["stiffness"].system.stiffness, before.stiffness * 1e3)
    assert np.array_equal(turned["stiffness"].system.uncertainty[0], before.uncertainty[0] * 1e3)
    assert np.array_equal(turned["mass"].system.stiffness, before.stiffness)
    assert [row.name for row in turned["mass"].system.rows] == [row.name for row in before.rows]


def test_coefficients_are_turned_one_by_one():
    found = scaling_factors(read_scene("examples/flexible_joint.toml"))
    before = problem_of(read_scene("examples/flexible_joint.toml")).polynomial_matrix
    after = found["coefficient of s^2"](7.0).polynomial_matrix
    assert np.array_equal(after.coefficients[2], 7.0 * before.coefficients[2])
    assert np.array_equal(after.coefficients[4], before.coefficients[4])


def test_a_large_lumped_model_is_turned_as_a_whole_only(tmp_path):
    chain = ['[model]\nkind = "lumped"']
    chain += [f'[[model.mass]]\nname = "m{i}"\nmass = 1' for i in range(10)]
    chain += [f'[[model.spring]]\nbetween = ["{f"m{i - 1}" if i else "ground"}", "m{i}"]\nstiffness = 1' for i in range(10)]
    path = tmp_path / "chain.toml"
    path.write_text("\n".join([*chain, "[time]\nend = 1"]))
    assert list(scaling_factors(read_scene(path))) == ["all masses", "all springs", "horizon"]
