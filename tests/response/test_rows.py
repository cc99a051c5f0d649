"""Only what is asked for: some coordinates, and long answers piece by piece."""

import tracemalloc

import numpy as np
import pytest

import mbconstrained as mb
from tests.response.chains import COUNT, chain

SMALL = mb.PolynomialMatrix([np.diag([1.0, 4.0, 9.0]), np.zeros((3, 3)), np.eye(3)], coordinates=["left", "middle", "right"])
TIMES = np.concatenate([[0.0, 1e-9, 1e-3], np.linspace(0.5, 30.0, 50)])


@pytest.fixture(params=["general", "reduced", "record"])
def x(request) -> mb.Response:
    start = np.zeros((2, COUNT))
    start[0, 4] = 1.0
    if request.param == "general":
        return mb.solve(SMALL, [[1.0, 0.0, 2.0], [0.0, 3.0, 0.0]], mb.harmonic([1.0, 0, 0], angular_frequency=0.7))
    if request.param == "reduced":
        return mb.solve(chain(), start)
    samples = np.outer(np.eye(COUNT)[3], np.random.default_rng(0).normal(size=40))
    return mb.solve(chain(), start, mb.sampled(np.linspace(0, 20, 40), samples))


def test_chosen_coordinates_are_rows_of_all(x):
    names = x.polynomial_matrix.coordinates
    chosen = x.of(names[2], 0, names[2])
    assert chosen.size == 3
    for one, all_of_them in ((chosen, x), (chosen.derivative(2), x.derivative(2)), (chosen.rows([1]), x.function.rows([0]))):
        known = all_of_them(TIMES)
        known = known[[2, 0, 2]] if len(known) > 1 else known
        assert np.abs(one(TIMES) - known).max() <= 1e-14 * np.abs(x.derivative(2)(TIMES)).max()
    assert chosen(1.0).shape == (3,)


def test_a_row_keeps_its_own_digits_just_after_the_start():
    """x' = -k x beside a coordinate a million times larger: the series of the row alone."""
    A = mb.PolynomialMatrix([[[1.0, 0, 0], [-1.0, 1, 0], [0, -1, 1]], np.eye(3)])
    x = mb.solve(A, [[1.0, 0.0, 0.0]])
    times = np.array([1e-6, 1e-4])
    assert np.allclose(x.of("x3")(times)[0], times**2 / 2 * np.exp(-times), rtol=1e-14, atol=0)  # (d/dt + 1)^3 x3 = 0


@pytest.mark.parametrize(
    "chosen, text",
    [
        (("midle",), 'there is no coordinate "midle"; did you mean "middle"?'),
        ((3,), "coordinate: found 3; expected a name, or a whole number from 0 to 2"),
        ((-1,), "found -1"),
        ((True,), "found True"),
        ((1.0,), "found 1.0"),
        ((), "none was named; give one or several of left, middle, right"),
    ],
)
def test_what_is_not_a_coordinate_is_told(chosen, text):
    with pytest.raises(mb.InputError) as told:
        mb.solve(SMALL).of(*chosen)
    assert text in str(told.value)


def test_pieces_are_the_whole_in_order(x, monkeypatch):
    monkeypatch.setattr("mbconstrained.signals.bohl.CHUNK_ENTRIES", 7 * x.polynomial_matrix.size)
    pieces = list(x.chunks(TIMES))
    assert [len(times) for times, _ in pieces] == [7] * 7 + [4]
    assert np.array_equal(np.concatenate([times for times, _ in pieces]), TIMES)
    whole = x(TIMES)
    assert np.abs(np.hstack([values for _, values in pieces]) - whole).max() <= 1e-13 * np.abs(whole).max()


def test_even_times_are_made_piece_by_piece_too(monkeypatch):
    monkeypatch.setattr("mbconstrained.signals.bohl.CHUNK_ENTRIES", 3 * 10)
    x = mb.solve(SMALL, [[1.0, 0, 0], [0, 0, 0]])
    times = np.concatenate([times for times, _ in x.chunks((1.0, 4.0), count=101)])
    assert times[0] == 1.0 and times[-1] == 4.0 and np.allclose(times, np.linspace(1.0, 4.0, 101), rtol=1e-15)
    first = next(iter(mb.solve(SMALL).chunks((0.0, 1e6), count=10**12)))  # nobody has room for all of them
    assert first[1].shape == (3, 10)


@pytest.mark.parametrize(
    "times, count, text",
    [
        ([[0.0, 1.0]], None, "times: expected shape any, found 1 x 2"),
        ((0.0, 1.0), 1, "count: found 1; expected a whole number of at least 2"),
        ((1.0, 0.5), 3, "times: found 1 s to 0.5 s; expected"),
        ((0.0, 1.0, 2.0), 3, "the first and the last one: expected shape 2, found 3"),
    ],
)
def test_what_are_no_times_is_told_at_once(times, count, text):
    with pytest.raises(mb.InputError) as told:
        mb.solve(SMALL).chunks(times, count)
    assert text in str(told.value)


@pytest.mark.parametrize("at_samples", [True, False])
def test_an_answer_needs_little_more_memory_than_itself(x, at_samples, monkeypatch):
    for place in ("signals.bohl", "response.methods.pair_solution", "response.flow"):
        monkeypatch.setattr(f"mbconstrained.{place}.CHUNK_ENTRIES", 10_000)
    times = np.repeat(np.linspace(0, 20, 40), 500) if at_samples else np.random.default_rng(1).uniform(0, 20, 20_000)
    float64 = x.solution.function
    float64(times[:10])
    tracemalloc.start()
    values = float64(times)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= 1.5 * values.nbytes + 8 * times.nbytes + 20 * 8 * 10_000


def test_early_times_need_little_more_memory_than_the_answer(x, monkeypatch):
    for place in ("signals.bohl", "response.methods.pair_solution", "response.flow"):
        monkeypatch.setattr(f"mbconstrained.{place}.CHUNK_ENTRIES", 10_000)
    times, float64 = np.linspace(0.0, 1e-3, 20_001)[1:] ** 1.1, x.solution.function
    float64(times[:10])
    tracemalloc.start()
    values = float64(times)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= 1.5 * values.nbytes + 10 * times.nbytes + 20 * 8 * 10_000
