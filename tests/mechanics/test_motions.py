"""Many motions of a system at once, each as it is solved alone."""

import numpy as np
import pytest

import mbconstrained as mb

RANDOM = np.random.default_rng(4)
TIMES = np.linspace(0.0, 6.0, 41)
SYSTEM = mb.MechanicalSystem(
    np.diag([1.0, 2, 0]),
    np.diag([0.1, 0, 0]),
    [[3.0, -1, 0], [-1, 2, -1], [0, -1, 2]],
    mb.Constraint([1, -1, 0], level="velocity"),
    names=["left", "right", "joint"],
    force=[0, 9.81, 0],
)


@pytest.mark.parametrize(
    "given, count",
    [
        ({"displacement": RANDOM.normal(size=(30, 3))}, 30),
        ({"displacement": RANDOM.normal(size=(4, 3)), "velocity": {"left": 1.0}}, 4),
        ({"displacement": [1.0, 0, 0], "velocity": RANDOM.normal(size=(12, 3)), "force": mb.ramp([0, 1.0, 0])}, 12),
        ({"force": [mb.step([1.0, 0, 0]), mb.impulse([0, 1.0, 0])]}, 2),
        ({"force": np.eye(3)}, 3),
        ({"displacement": RANDOM.normal(size=(2, 3)), "force": (mb.step([1.0, 0, 0]).delayed(1.0),) * 2}, 2),
    ],
)
def test_each_is_the_motion_solved_alone(given, count):
    xs = SYSTEM.solve(**given)
    assert len(xs) == count and xs.names == SYSTEM.names and repr(xs) == f"Motions({count} motions of 3 coordinates)"
    alone = list(xs)
    assert all(isinstance(x, mb.Motion) for x in alone)
    for many, one in ((xs, lambda x: x), (xs.velocity, lambda x: x.velocity), (xs.acceleration, lambda x: x.acceleration)):
        known = np.array([one(x)(TIMES) for x in alone])
        assert np.abs(many(TIMES) - known).max() <= 1e-13 * np.abs(known).max()
    assert np.array_equal(xs.jump, [x.jump for x in alone])
    assert [len(events) for events in xs.events] == [len(x.events) for x in alone]
    assert np.array_equal(xs.displacement(TIMES), xs(TIMES))
    known = np.array([x.reaction(TIMES) for x in alone])
    assert np.abs(xs.reaction(TIMES) - known).max() <= 1e-12 * max(np.abs(known).max(), 1.0)
    for times in (TIMES, 0.5):
        for name in ("kinetic", "strain", "static", "total"):
            known = np.array([getattr(x.energy(times), name) for x in alone])
            assert np.allclose(getattr(xs.energy(times), name), known, rtol=1e-12, atol=1e-12 * np.abs(known).max())
    assert np.allclose(xs.of("joint")(TIMES)[:, 0], xs(TIMES)[:, 2], rtol=1e-14, atol=1e-14)


def test_what_is_common_reaches_every_motion():
    velocity, force = {"left": 1.0, "right": 1.0}, mb.harmonic([0.0, 1, 0], angular_frequency=2.0)
    X = RANDOM.normal(size=(8, 3))
    xs = SYSTEM.solve(X, velocity, force)
    known = SYSTEM.solve(X[5], velocity, force)
    assert np.allclose(xs(TIMES)[5], known(TIMES), rtol=1e-13, atol=1e-13)
    assert np.array_equal(xs[5](TIMES), known(TIMES))


@pytest.mark.parametrize(
    "given, text",
    [
        ({"displacement": np.zeros((4, 3)), "velocity": np.zeros((3, 3))}, "found 4 of displacement, 3 of velocity, 1 of force"),
        ({"displacement": np.zeros((4, 2))}, "displacement: expected shape any x 3, found 4 x 2"),
        ({"displacement": np.zeros((0, 3))}, "found 0 of displacement"),
        (
            {"displacement": np.zeros((4, 3)), "force": [mb.step([1.0, 0, 0])] * 2},
            "2 of force; give as many of each, or one for all",
        ),
        ({"displacement": np.zeros((4, 3)), "velocity": {"lefd": 1.0}}, 'there is no coordinate "lefd"; did you mean "left"?'),
        ({"displacement": [[1.0, 2, 3], [1.0]]}, "displacement: the rows have different lengths"),
    ],
)
def test_what_does_not_match_is_told(given, text):
    with pytest.raises(mb.InputError) as told:
        SYSTEM.solve(**given)
    assert text in str(told.value)


def test_a_slice_is_of_the_same_kind():
    xs = SYSTEM.solve(RANDOM.normal(size=(5, 3)))
    assert len(xs[1:4]) == 3
    assert np.array_equal(xs[1:4][-1](TIMES), xs[3](TIMES))
    assert np.array_equal(xs[::2](TIMES), xs(TIMES)[::2])
