"""The proved bound of small models is carried from knot to knot of a force, against exponentials in ball arithmetic."""

from fractions import Fraction

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.tolerances import PROVED_RESTARTS
from mbconstrained.response.methods.proved import ProvedFunction
from tests.oracles.ball_exponential import motion

TIMES = np.array([0.4, 1.0, 1.3, 2.0, 2.5, 4.0, 9.0, 30.0])


def model(kind: str, random) -> list[np.ndarray]:
    """K, C and M of two or three coordinates."""
    n = 3 if kind == "chain" else 2
    K = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    C = {"chain": 0.1 * K, "undamped": 0 * K, "free": 0 * K, "coupled": np.diag(random.uniform(0.1, 1.0, n))}[kind]
    return [0 * K if kind == "free" else K, C, np.diag(random.uniform(0.5, 2.0, n))]


def solved(kind: str, count: int):
    """The response to so many steps, and its exact values."""
    random = np.random.default_rng(count)
    coefficients = model(kind, random)
    n = len(coefficients[0])
    starts = np.sort(random.uniform(0.0, 3.0, count))
    loads = random.normal(size=(count, n)) * 10 ** random.uniform(-3, 0, (count, 1))
    initial = random.normal(size=(2, n))
    x = mb.solve(
        mb.PolynomialMatrix(coefficients),
        initial,
        sum((mb.step(v).delayed(t) for t, v in zip(starts, loads)), mb.step(np.zeros(n))),
    )
    exact = []
    for time in TIMES.tolist():
        total = motion(coefficients, initial, time)
        for begin, load in zip(starts.tolist(), loads):
            if begin < time:
                since = Fraction(time) - Fraction(begin)
                total = [a + b for a, b in zip(total, motion(coefficients, 0 * initial, since, load))]
        exact.append([float(value) for value in total])
    return x, np.array(exact).T


@pytest.mark.parametrize("count", [1, 2, 7])
@pytest.mark.parametrize("kind", ["chain", "undamped", "free", "coupled"])
def test_the_bound_is_above_the_error_and_near_it(kind, count):
    x, exact = solved(kind, count)
    assert isinstance(x.function, ProvedFunction) and x.function.defect is not None
    rough = x.function.rough.by_modes(TIMES)
    error, size, defect = np.abs(rough - exact).max(axis=0), np.abs(exact).max(axis=0), x.function.defect
    noise = np.finfo(float).eps * size  # of the exact values themselves
    bounds = defect.errors(x.function.rough.place, 0, TIMES, np.zeros(len(TIMES)))
    assert (bounds > error - noise)[error > 2 * noise].all() and (bounds <= 1e-11 * size).all()
    assert np.abs(x(TIMES) - exact).max() <= 1e-12 * size.max()


def test_what_follows_no_exact_force_is_not_sure():
    """The states of a harmonic force are rounded at its knots; the values are those of the exact engine then."""
    coefficients = model("chain", np.random.default_rng(0))
    x = mb.solve(
        mb.PolynomialMatrix(coefficients),
        force=mb.harmonic([1.0, 0.0, 0.0], angular_frequency=2.0) + mb.step([0.0, 1.0, 0.0]).delayed(1.0),
    )
    assert not x.function.defect.follows_force
    assert (x.function.defect.errors(x.function.rough.place, 0, TIMES[TIMES > 1], np.zeros(6)) == np.inf).all()
    assert x.error_estimate(TIMES) < 1e-12


@pytest.mark.parametrize("restarts, proved", [(PROVED_RESTARTS, True), (PROVED_RESTARTS + 1, False)])
def test_more_restarts_than_are_proved_are_evidence(restarts, proved):
    steps = sum((mb.step([1.0 + k]).delayed(0.1 * k) for k in range(1, restarts)), mb.step([1.0]).delayed(0.1 * restarts))
    x = mb.solve(mb.PolynomialMatrix([[[4.0]], [[0.5]], [[1.0]]]), force=steps)
    assert len(x.force.knots) == restarts + 1
    assert x.is_proved == proved
    assert [item.value for item in x.evidence if item.name == "restarts"] == ([] if proved else [restarts])
