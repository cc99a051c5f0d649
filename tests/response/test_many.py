"""Many starts and forces at once: each as it is solved alone, and one decomposition for all."""

import tracemalloc

import numpy as np
import pytest

import mbconstrained as mb
from tests.response.chains import COUNT, chain

RANDOM = np.random.default_rng(8)
TIED = mb.PolynomialMatrix(
    [[[3.0, -1, 1], [-1, 2, -1], [1, -1, 0]], np.diag([0.2, 0, 0]), np.diag([1.0, 2, 0])], coordinates=["a", "b", "force"]
)
TIMES = np.concatenate([[0.0, 1e-9, 1e-4, 1e-2], np.linspace(0.1, 40.0, 80)])
FORCES = [
    None,
    mb.harmonic([1.0, 0, 0], angular_frequency=0.7),
    mb.impulse([0.0, 1, 0]) + mb.pulse([0.0, 0, 1], start=1.0, duration=2.0),
]


def starts(A, count):
    return RANDOM.normal(size=(count, A.degree, A.size))


def assert_same_as_alone(xs, times, accuracy=1e-13):
    for one, other in ((xs, list(xs)), (xs.derivative(1), [x.derivative(1) for x in xs])):
        known = np.array([x(times) for x in other])
        assert np.abs(one(times) - known).max() <= accuracy * np.abs(known).max()


def assert_same_beginnings_as_alone(xs):
    """To rounding errors, which sums of several columns and of one have in another order; what is zero is zero in both."""
    known = np.array([x.jump for x in xs])
    assert np.array_equal(xs.jump != 0, known != 0)
    assert np.abs(xs.jump - known).max() <= 1e-13 * np.abs(known).max()
    for one, x in zip(xs.impulses, xs):
        assert len(one) == len(x.impulses)
        for part, other in zip(one, x.impulses):
            assert np.array_equal(part != 0, other != 0) and np.allclose(part, other, rtol=0, atol=1e-13 * np.abs(other).max())
    assert [len(events) for events in xs.events] == [len(x.events) for x in xs]
    for events, x in zip(xs.events, xs):
        assert all(np.array_equal(one.jump, other.jump) for one, other in zip(events, x.events))


@pytest.mark.parametrize("force", FORCES, ids=["free", "harmonic", "impulse and pulse"])
@pytest.mark.parametrize("count", [1, 8])
def test_small_models(force, count):
    xs = mb.solve(TIED, starts(TIED, count), force)
    assert len(xs.function.groups) == (1 if count > 6 else count)
    assert_same_as_alone(xs, TIMES)
    assert_same_beginnings_as_alone(xs)


def test_starts_that_fit_do_not_jump():
    fit = np.array([[[1.0, 1.0, -1.0], [0.5, 0.5, 0]]]) * np.linspace(-2, 2, 30)[:, None, None]
    fit[:, 0, 2] = [mb.solve(TIED, start).start[0, 2] for start in fit]
    fit[:, 1, 2] = [mb.solve(TIED, start).start[1, 2] for start in fit]
    xs = mb.solve(TIED, fit)
    assert_same_beginnings_as_alone(xs)
    assert xs.impulses == ((),) * 30
    assert not xs.jump[:, :, :2].any()


@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("count", [3, pytest.param(32, marks=pytest.mark.long)])  # fewer and more than coordinates
@pytest.mark.parametrize("kind", ["free", "harmonic", "record"])
def test_large_models(damping, count, kind):
    A = chain(damping)
    force = {
        "free": None,
        "harmonic": mb.harmonic(np.eye(COUNT)[4], angular_frequency=0.7),
        "record": mb.sampled([0.0, 0.02, 3.0, 8.0], np.outer(np.eye(COUNT)[2], [1.0, -1.0, 2.0, 0.5])),
    }[kind]
    xs = mb.solve(A, starts(A, count), force)
    assert_same_as_alone(xs, TIMES)
    order, values = RANDOM.permutation(len(TIMES)), xs(TIMES)
    assert np.abs(xs(TIMES[order]) - values[:, :, order]).max() <= 1e-13 * np.abs(values).max()
    assert not xs.jump.any()


def test_a_coordinate_far_from_a_start_keeps_its_own_digits_just_after_it():
    A = mb.PolynomialMatrix([[[1.0, 0, 0], [-1.0, 1, 0], [0, -1, 1]], np.eye(3)])
    xs = mb.solve(A, np.outer(np.arange(1.0, 9.0), [1.0, 0, 0])[:, None])
    times = np.array([1e-6, 1e-4])
    known = np.multiply.outer(np.arange(1.0, 9.0), times**2 / 2 * np.exp(-times))
    assert np.allclose(xs(times)[:, 2], known, rtol=1e-14, atol=0)


def test_starts_of_a_large_model_that_do_not_fit_are_among_the_others():
    """The last coordinate, which has mass, is held to the one before."""
    K, C, M = chain().coefficients.copy()
    K[-1], M[-1], C[-1] = np.eye(COUNT)[-1] - np.eye(COUNT)[-2], 0.0, 0.0
    M[-2, -1] = 1.0
    A = mb.PolynomialMatrix([K, C, M])
    X = starts(A, 6)
    X[::2, :, -1] = X[::2, :, -2]
    xs = mb.solve(A, X)
    assert [method.name for method in xs.methods] == ["modes"] * 6
    assert_same_as_alone(xs, TIMES, 1e-11)
    assert_same_beginnings_as_alone(xs)
    assert np.array_equal(xs.jump.any(axis=(1, 2)), [False, True] * 3)
    assert "values jump at t = 0 in 3 of 6 solutions" in [notice.text for notice in xs.notices]


def test_forces_of_their_own():
    forces = [*FORCES[1:], mb.step([1.0, 0, 0]), FORCES[1], None]
    xs = mb.solve(TIED, force=forces)
    assert len(xs) == 5
    assert_same_as_alone(xs, TIMES)
    one_each = mb.solve(TIED, starts(TIED, 5), tuple(forces))
    assert_same_as_alone(one_each, TIMES)
    assert_same_beginnings_as_alone(one_each)
    common = mb.solve(TIED, starts(TIED, 1)[0], forces)
    assert np.array_equal(common.initial[0], common.initial[4])
    assert_same_as_alone(common, TIMES)


def test_motions_that_grow_out_of_range_do_not_spoil_those_that_do_not():
    A = mb.PolynomialMatrix([np.diag([-1.0] + [1.0] * 24), np.zeros((25, 25)), np.eye(25)])
    X = starts(A, 40)
    X[:, :, 0] = 0.0
    xs = mb.solve(A, X)
    assert_same_as_alone(xs, np.array([0.5, 800.0]), 1e-12)
    X[7, 0, 0] = 1.0
    with pytest.raises(mb.Overflow, match="values of member 7"):
        mb.solve(A, X)(800.0)


def test_shapes_rows_and_items():
    xs = mb.solve(TIED, starts(TIED, 9))
    assert xs(1.0).shape == (9, 3) and xs(TIMES).shape == (9, 3, len(TIMES)) and xs([]).shape == (9, 3, 0)
    assert np.allclose(xs.of("force", 0)(TIMES), xs(TIMES)[:, [2, 0]], rtol=1e-14, atol=1e-13)
    assert np.array_equal(xs[3:5](2.0), np.array([xs[3](2.0), xs[4](2.0)])) and np.array_equal(xs[-1].initial, xs.initial[-1])
    (_, first), *rest = xs.chunks(TIMES)
    assert not rest and np.array_equal(first, xs(TIMES)) and np.array_equal(xs.start, xs.initial + xs.jump)
    boxes, frame, table = xs[:2].enclose(2.0), xs[:2].to_xarray(TIMES), xs[:2].to_pandas(TIMES)
    assert all(np.allclose(np.array(box.lower, dtype=float), x(2.0)) for box, x in zip(boxes, xs))
    assert np.allclose(frame.transpose("member", "coordinate", "time"), xs(TIMES)[:2]) and np.allclose(table.loc[1].T, xs[1](TIMES))
    assert repr(xs) == "Responses(9 solutions of 3 coordinates)" and len(list(xs)) == 9
    with pytest.raises(IndexError):
        xs[9]
    with pytest.raises(mb.InputError, match='there is no coordinate "forc"; did you mean "force"?'):
        xs.of("forc")


@pytest.mark.parametrize(
    "initial, force, text",
    [
        (np.zeros((4, 2, 2)), None, "initial: expected shape 2 x 3, or S x 2 x 3 for S starts, found 4 x 2 x 2"),
        (np.zeros((4, 2, 3)), FORCES[1:] * 2 + FORCES[1:2], "force: found 5 forces for 4 starts; give as many, or one for all"),
        (np.zeros((0, 2, 3)), None, "initial and force: found none"),
        (None, [FORCES[1], 3.0], "force: found float; make it with"),
        (None, [FORCES[1], mb.step([1.0])], "force: it has 1 row, but A(s) has 3"),
        (np.full((2, 2, 3), np.nan), None, "initial: the entry at (0, 0, 0) is nan"),
    ],
)
def test_what_does_not_match_is_told(initial, force, text):
    with pytest.raises(mb.InputError) as told:
        mb.solve(TIED, initial, force)
    assert text in str(told.value)


@pytest.mark.parametrize("times, text", [([-1.0], "found -1 s"), ([[1.0]], "found an array of shape"), ([np.nan], "nan")])
def test_what_are_no_times_is_told(times, text):
    with pytest.raises(mb.InputError) as told:
        mb.solve(TIED, starts(TIED, 9))(times)
    assert text in str(told.value)


@pytest.mark.long
@pytest.mark.parametrize("make", [lambda: TIED, lambda: chain()], ids=["small", "large"])
def test_all_need_little_more_memory_than_their_values(make, monkeypatch):
    A = make()
    xs = mb.solve(A, starts(A, 100))
    xs(1.0)
    for place in (
        "signals.bohl",
        "response.methods.pair_solution",
        "response.flow",
        "response.solve",
    ):
        monkeypatch.setattr(f"mbconstrained.{place}.CHUNK_ENTRIES", 20_000)
    times = RANDOM.uniform(0.0, 40.0, 1000)
    times.sort()
    tracemalloc.start()
    values = xs(times)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak <= 1.2 * values.nbytes + 20 * 8 * 20_000


@pytest.mark.parametrize("back", [1e-5, 1e-7, 1e-9])
def test_like_parts_of_which_one_drives_the_other_are_as_accurate_together_as_alone(back):
    """Sums of modes that cancel do not serve, but for the starts that excite one mode alone."""
    A = mb.PolynomialMatrix([[[1.0, -(back**2)], [-1.0, 1.0]], np.zeros((2, 2)), np.eye(2)])
    X = np.zeros((8, 2, 2))
    X[:, 0, 0] = np.linspace(0.5, 4.0, 8)
    X[::2, 0, 1] = X[::2, 0, 0] / back  # one mode alone
    xs, times = mb.solve(A, X), np.array([0.1, 1.0, 5.0, 10.0, 100.0])
    half_sum = np.sqrt([1 + back, 1 - back]).mean()
    for x, found, start in zip(xs, xs(times), X[:, 0]):
        limit = x.error_estimate(times) * np.abs(found).max()
        assert np.abs(found - x(times)).max() <= max(limit, 1e-12 * np.abs(found).max())
        if not start[1]:  # x2 = (cos w2 t - cos w1 t) / (2 back) x1(0)
            expected = np.sin(half_sum * times) * np.sin(back / half_sum / 2 * times) / back * start[0]
            assert np.abs(found[1] - expected).max() <= max(limit, 1e-14 * np.abs(found).max()) <= 1e-5 * np.abs(expected).max()
