"""Ranking of sensitivities on the page of the modes."""

from itertools import pairwise

import pytest

import mbconstrained as mb
from mbconstrained.analyses.modes import ModalAnalysis
from mbconstrained.analyses.sensitivity import MOST_ROWS, influence_tables
from tests.scene.scenes import EXAMPLES, scene_of

CHAIN = """
[model]
kind = "lumped"
mass = [{masses}]
spring = [{springs}]
[time]
end = 1
"""


def chain(count):
    """Masses and springs in a row."""
    masses = ", ".join(f'{{ name = "m{i}", mass = "1 kg" }}' for i in range(count))
    ends = ["ground", *(f"m{i}" for i in range(count))]
    springs = ", ".join(
        f'{{ name = "k{i}", between = ["{a}", "{b}"], stiffness = "9 N/m" }}' for i, (a, b) in enumerate(pairwise(ends))
    )
    return CHAIN.format(masses=masses, springs=springs)


def test_parameters_and_elements_sorted():
    """Of the tuned mass damper the frequencies follow "natural" one to one (all stiffnesses do, and no mass)."""
    parameters, elements = influence_tables(mb.read_scene(EXAMPLES / "tuned_mass_damper.toml"))
    assert parameters.title == "Sensitivities to parameters"
    assert parameters.rows[0] == ("natural", "+1.000", "+1.000", "0", "0")
    assert elements.title == "Sensitivities to elements"
    largest = [max(abs(float(cell)) for cell in row[1:]) for row in elements.rows]
    assert largest == sorted(largest, reverse=True)


def test_tornado_plots_show_the_changes_by_one_per_cent():
    """Against modes with a parameter that is 0.5 % larger and smaller: central differences, of second order."""
    path = EXAMPLES / "tuned_mass_damper.toml"
    scene = mb.read_scene(path)
    frequency, damping = scene.sensitivity().plots()
    for name in ("tuning", "zeta", "ratio"):
        value = scene.parameters.values[name]
        low, high = (mb.read_scene(path, {name: float(value) * share}).equations.system.modes() for share in (0.995, 1.005))
        changes = (
            100 * (high.natural_frequencies - low.natural_frequencies) / low.natural_frequencies,
            high.damping_ratios - low.damping_ratios,
        )
        for plot, expected in zip((frequency, damping), changes):
            row = len(plot.marks[-1].texts) - plot.marks[-1].texts.index(name)
            shown = [float(x) for marks in plot.marks[:2] for x, y in marks.points if y == row]
            assert shown == pytest.approx(expected, rel=2e-2, abs=1e-5)


@pytest.mark.parametrize("count", [2, MOST_ROWS])
def test_the_tables_are_on_the_page_and_long_ones_are_folded(tmp_path, count):
    scene = scene_of(tmp_path, chain(count))
    (table,) = influence_tables(scene)
    assert len(table.rows) == 2 * count and table.folded == (count == MOST_ROWS)
    assert table in ModalAnalysis.solve(scene).page().tables


@pytest.mark.parametrize("name", ["seven_joint_arm.toml", "two_masses.toml"])
def test_no_tables_of_robots_and_of_matrices_without_parameters(name):
    """A robot is assembled again for each; matrices are known by their entries only."""
    assert influence_tables(mb.read_scene(EXAMPLES / name)) == ()


def test_no_tables_of_modal_damping_and_of_large_models(tmp_path):
    assert influence_tables(scene_of(tmp_path, chain(2).replace("[time]", "modal_damping = 0.02\n[time]"))) == ()
    assert influence_tables(scene_of(tmp_path, chain(60))) == ()
