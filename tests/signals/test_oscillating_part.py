"""Sums of many oscillations, made from cosines and sines: against the states at every time, each for itself."""

import numpy as np
import pytest

from mbconstrained.ground.errors import Overflow
from mbconstrained.linalg.exponential import block_states
from mbconstrained.signals.bohl import BohlFunction

PAIRS = 60


def function(rows: int, growth: float = 0.0, seed: int = 0) -> BohlFunction:
    """Pairs in any basis of theirs, decays and a cluster."""
    random = np.random.default_rng(seed)
    blocks = []
    for w in random.uniform(0.2, 5.0, PAIRS):
        turn = np.array([[1.0, random.normal()], [0.0, random.uniform(0.5, 2.0)]])
        blocks.append(turn @ np.array([[growth, w], [-w, growth]]) @ np.linalg.inv(turn))
    blocks[3:3] = [np.array([[-0.7]]), np.array([[-0.2, 1.0, 0.0], [0.0, -0.2, 1.0], [0.0, 0.0, -0.2]])]
    n = sum(map(len, blocks))
    return BohlFunction(random.normal(size=(rows, n)), tuple(blocks), random.normal(size=n))


def one_by_one(f: BohlFunction, times) -> np.ndarray:
    return f.coefficients @ block_states(f.blocks, f.start, times)


TIMES = {
    "even": np.linspace(0.0, 40.0, 1001),
    "even from later": 3.0 + 0.01 * np.arange(1777),
    "uneven": np.sort(np.random.default_rng(1).uniform(0.0, 40.0, 900)),
    "reversed": np.linspace(40.0, 0.0, 1001),
    "repeated": np.repeat(np.linspace(0.0, 40.0, 300), 3),
}


@pytest.mark.parametrize("name", TIMES)
@pytest.mark.parametrize("rows", [1, 6, 80])
@pytest.mark.parametrize("growth", [0.0, -0.1, 0.1])
def test_values_are_those_of_all_states(name, rows, growth):
    f, times = function(rows, growth), TIMES[name]
    bound = np.abs(f.coefficients).sum(axis=1)[:, None] * np.exp(max(growth, 0.0) * times)
    assert (np.abs(f(times) - one_by_one(f, times)) <= 1e-12 * bound).all()


@pytest.mark.parametrize("rows", [1, 80])
@pytest.mark.parametrize("end", [650.0, 705.0])
def test_growth_up_to_the_end_of_the_range(rows, end):
    f, times = function(rows, 1.0), np.linspace(0.0, end, 1001)
    f = BohlFunction(1e-3 * f.coefficients, f.blocks, f.start)
    bound = np.abs(f.coefficients).sum(axis=1)[:, None] * np.exp(times)
    assert (np.abs(f(times) - one_by_one(f, times)) <= 1e-10 * bound).all()


def test_beyond_it_the_error_names_the_first_time():
    with pytest.raises(Overflow, match=r"the value at t = 70\d"):
        function(2, 1.0)(np.linspace(0.0, 900.0, 901))


@pytest.mark.parametrize("rows", [1, 80])
def test_tiny_coefficients_of_huge_states_are_ordinary_values(rows):
    """Their product alone matters: 1e-290 times 1e290, and a start that is negligible next to it."""
    reference, times = function(rows), TIMES["even"]
    size = np.tile([1e-290, 1e290, 1.0], reference.state_count)[: PAIRS + 2]
    size = np.repeat(size, [len(block) for block in reference.blocks])
    f = BohlFunction(reference.coefficients / size, reference.blocks, reference.start * size)
    assert np.allclose(f(times), reference(times), rtol=0, atol=1e-12 * np.abs(reference.coefficients).sum())


@pytest.mark.parametrize("pairs", [1, PAIRS])
@pytest.mark.parametrize("name", ["even", "uneven"])
def test_zeros_at_zero_add_straight_lines(pairs, name):
    """A drift R = [[0, c], [0, 0]] in any basis of its own and a constant: v + R v t, also of huge states and tiny coefficients."""
    reference, times = function(3), TIMES[name]
    drift = np.array([[1.0, -2.0], [0.5, -1.0]])
    blocks = (np.zeros((1, 1)), *reference.blocks[-pairs:], drift, np.array([[0.0, 3e200], [0.0, 0.0]]))
    n, random = sum(map(len, blocks)), np.random.default_rng(1)
    coefficients, start = random.normal(size=(3, n)), random.normal(size=n)
    coefficients[:, -2:] *= 1e-200
    f = BohlFunction(coefficients, blocks, start)
    size = np.abs(coefficients[:, :-2]).sum() * 4 + np.abs(coefficients[:, -2:]).sum() * 3e200
    assert (np.abs(f(times) - one_by_one(f, times)) <= 1e-13 * size * (1 + times)).all()
    lines = BohlFunction(coefficients[:, [0, -2, -1]], (blocks[0], blocks[-1]), start[[0, -2, -1]])
    expected = coefficients[:, [0]] * start[0] + coefficients[:, [-2]] * (3e200 * start[-1] * times + start[-2])
    assert np.allclose(lines(times), expected, rtol=1e-14, atol=1e-13)
