"""Damped cosines and sines at many times, against NumPy's one by one and against mpmath."""

import mpmath
import numpy as np
import pytest

from mbconstrained.linalg.exponential import Lasting, Oscillations, even_step, of_phasors

PAIRS = 40


def oscillations(growth, frequency) -> Oscillations:
    every = np.arange(len(frequency))
    return Oscillations(np.broadcast_to(growth, len(frequency)).astype(float), frequency, every, every)


def direct(found: Oscillations, times) -> np.ndarray:
    size = np.exp(np.multiply.outer(found.growth, times))
    angle = np.multiply.outer(found.frequency, times)
    return np.vstack([(size * np.cos(angle))[found.cosines], (size * np.sin(angle))[found.sines]])


TIMES = {
    "none": np.zeros(0),
    "one": np.array([2.0]),
    "two": np.array([0.5, 2.0]),
    "even": np.linspace(0.0, 30.0, 1501),
    "even from later": 17.0 + 0.02 * np.arange(1500),
    "a square number": np.linspace(0.0, 30.0, 1600),
    "uneven": np.sort(np.random.default_rng(0).uniform(0, 30, 1500)),
    "descending": np.linspace(30.0, 0.0, 1501),
    "all the same": np.full(1500, 3.0),
}


@pytest.mark.parametrize("name", TIMES)
@pytest.mark.parametrize("growth", [0.0, -0.3, 0.2])
def test_values_are_those_of_the_functions_themselves(name, growth):
    found, times = oscillations(growth, np.random.default_rng(1).uniform(0.1, 9.0, PAIRS)), TIMES[name]
    values, expected = found(times), direct(found, times)
    assert values.shape == expected.shape
    bound = 1e-15 * (1 + 9.0 * times) * np.exp(growth * times)
    assert (np.abs(values - expected) <= bound).all()


@pytest.mark.parametrize("first", [0.0, 1e4])
def test_at_late_times_the_phase_is_as_right_as_that_of_a_product(first):
    """Phases of 1e5 rad: w t is rounded, and so is a sum of two angles; not worse than four times the former."""
    frequency = np.array([np.pi, np.sqrt(2.0), 7.1])
    times = first + np.linspace(0.0, 2e4, 20_001)
    shown = np.random.default_rng(2).integers(0, len(times), 60)
    found = oscillations(0.0, frequency)(times)[:3, shown]
    with mpmath.workdps(40):
        exact = [[mpmath.cos(mpmath.mpf(w) * mpmath.mpf(t)) for t in times[shown]] for w in frequency]
        errors, plain = (
            np.array([[abs(float(mpmath.mpf(a) - b)) for a, b in zip(*rows)] for rows in zip(values, exact)])
            for values in (found, np.cos(np.multiply.outer(frequency, times[shown])))
        )
    assert errors.max() <= 4 * plain.max()


@pytest.mark.parametrize("growth", [-1.0, -40.0])
@pytest.mark.parametrize("count", [5, 5000])
def test_what_has_decayed_is_zero_and_never_a_denormal_number(growth, count):
    found = oscillations(growth, np.linspace(1.0, 5.0, PAIRS))(np.linspace(0.0, 3000.0, count))
    assert np.isfinite(found).all()
    assert not found[:, -1].any()
    assert (np.abs(found[found != 0]) >= np.finfo(float).tiny).all()
    assert (np.abs(found) < 1e-290).any()


def test_even_times_are_known():
    assert even_step(np.linspace(3.0, 4.0, 1001)) == pytest.approx(1e-3)
    assert even_step(np.arange(100) * 0.1) == pytest.approx(0.1)
    for uneven in ([], [1.0], [1.0, 1.0], [2.0, 1.0], [0.0, 1.0, 2.0 + 1e-9], [0.0, 2.0, 1.0, 3.0]):
        assert even_step(np.array(uneven)) is None


def rows_of(found: Oscillations, rows: int) -> np.ndarray:
    """Coefficients of so many rows."""
    return np.random.default_rng(3).standard_normal((rows, len(found.cosines) + len(found.sines)))


@pytest.mark.parametrize("name", TIMES)
@pytest.mark.parametrize("growth", [0.0, -0.3, 0.2])
@pytest.mark.parametrize("rows", [1, 5, 60])
@pytest.mark.parametrize("pairs", [2, PAIRS])
def test_rows_are_sums_of_the_functions_however_they_are_made(name, growth, rows, pairs):
    """By a table, by parts of one or by coarse and fine times: the rounding is that of the terms that are added."""
    found, times = oscillations(growth, np.random.default_rng(1).uniform(0.1, 9.0, pairs)), TIMES[name]
    coefficients = rows_of(found, rows)
    values, expected = found.combined(coefficients, times), coefficients @ direct(found, times)
    bound = 2e-15 * (1 + 9.0 * times) * np.exp(growth * times) * np.abs(coefficients).sum(axis=1)[:, None]
    assert values.shape == expected.shape and values.flags.c_contiguous
    assert (np.abs(values - expected) <= bound).all()


@pytest.mark.parametrize("rows", [1, 60])
def test_beside_growing_ones_decayed_ones_are_nothing(rows):
    """Half of the pairs grow by e^600, half have decayed by e^-1200: no overflow, no NaN, no denormal factor."""
    growth = np.where(np.arange(PAIRS) % 2, 600.0, -1200.0)
    every = np.arange(PAIRS)
    found = Oscillations(growth, np.linspace(1.0, 9.0, PAIRS), every, every)
    times, coefficients = np.linspace(0.0, 1.0, 2000), rows_of(found, rows)
    with np.errstate(over="raise", invalid="raise"):
        values = found.combined(coefficients, times)
    bound = 1e-14 * np.abs(coefficients) @ np.exp(np.multiply.outer(np.tile(growth, 2), times) * (1 + 4e-16)) * 600
    assert (np.abs(values - coefficients @ direct(found, times)) <= bound).all()


@pytest.mark.parametrize("name", ["even", "uneven", "descending"])
def test_what_has_decayed_beside_others_is_left_out_without_a_digit_lost(name):
    """Half of the pairs live a hundred times shorter; the eleventh row has none of the others and keeps its own to the end."""
    growth, times = -np.where(np.arange(PAIRS) % 2, 10.0, 0.1), TIMES[name]
    every = np.arange(PAIRS)
    found = Oscillations(growth, np.random.default_rng(1).uniform(0.5, 9.0, PAIRS), every, every)
    coefficients = rows_of(found, 80)
    lasting = Lasting.of(found, coefficients)
    assert not lasting.at(np.array([10.0])).all()
    everything = found.combined(coefficients, times)
    size = np.abs(coefficients) @ np.exp(np.multiply.outer(np.tile(growth, 2), times))
    assert (np.abs(found.combined(coefficients, times, lasting) - everything) <= 1e-15 * size).all()
    coefficients[10, np.tile(growth, 2) > -1] = 0.0
    lasting = Lasting.of(found, coefficients)
    values, everything = found.combined(coefficients, times, lasting)[10], found.combined(coefficients, times)[10]
    assert np.allclose(values, everything, rtol=1e-12, atol=1e-300)


def by_phasors(found: Oscillations, coefficients, times) -> np.ndarray:
    """The same sums, every pair there with cosine and sine."""
    z = coefficients[:, : len(found.growth)] + 1j * coefficients[:, len(found.growth) :]
    return of_phasors(z, found.growth + 1j * found.frequency, times, even_step(times))


@pytest.mark.parametrize("name", ["two", "even", "even from later", "a square number"])
@pytest.mark.parametrize("growth", [0.0, -0.3, 0.2])
@pytest.mark.parametrize("rows", [0, 1, 5])
def test_phasors_are_turned_to_the_sums_of_cosines_and_sines(name, growth, rows):
    found, times = oscillations(growth, np.random.default_rng(1).uniform(0.1, 9.0, PAIRS)), TIMES[name]
    coefficients = rows_of(found, rows)
    values, expected = by_phasors(found, coefficients, times), coefficients @ direct(found, times)
    bound = 2e-15 * (1 + 9.0 * times) * np.exp(growth * times) * np.abs(coefficients).sum(axis=1)[:, None]
    assert values.shape == expected.shape and values.flags.c_contiguous
    assert (np.abs(values - expected) <= bound).all()
