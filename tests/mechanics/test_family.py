"""Families of systems: everything that stacks of matrices give agrees with the systems one by one, which take other algorithms."""

import tracemalloc

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained import Constraint, InputError, family
from mbconstrained.analyses.sweep.evaluation import SampleFamily
from tests.oracles.ball_exponential import motion

SEED = np.random.default_rng(20)
TIMES = np.linspace(0.0, 8.0, 41)
LINES = np.linspace(0.05, 2.0, 30)


def chains(count, size=5, damping=0.1, spread=0.05):
    """Grounded chains with scattered masses, dampers and springs."""
    i = np.arange(size)

    def assembled(values):
        matrix = np.zeros((count, size, size))
        matrix[:, i, i] += values
        matrix[:, i[:-1], i[:-1]] += values[:, 1:]
        matrix[:, i[1:], i[:-1]] -= values[:, 1:]
        matrix[:, i[:-1], i[1:]] -= values[:, 1:]
        return matrix

    m, c, k = (value * (1 + spread * SEED.normal(size=(count, size))) for value in (2.0, damping, 30.0))
    return m[:, :, None] * np.eye(size), assembled(c), assembled(k)


def condensed():
    """Chains with a massless node between springs, and one with a damper."""
    M, C, K = chains(4)
    M[:, 2, 2], C[:, 2], C[:, :, 2] = 0.0, 0.0, 0.0
    M[:, 4, 4] = 0.0
    return family(M, C, K)


def gyroscopic():
    """Unsymmetric damping and stiffness."""
    M, C, K = chains(4)
    G = SEED.normal(size=C.shape)
    K[:, 0, 1] += 1.0
    return family(M, C + 0.3 * (G - G.transpose(0, 2, 1)), K)


def moved_base():
    """A row that ties two masses, and a prescribed motion."""
    M, C, K = chains(4)
    base = mb.harmonic([0.3], angular_frequency=2.0, phase=-np.pi / 2)
    rows = [Constraint([1.0, -1.0, 0, 0, 0], names="tie"), Constraint([0, 0, 0, 0, 1.0], value=base, names="base")]
    return family(M, C, K, rows, force=mb.step([0, 0, 1.0, 0, 0]))


FAMILIES = {
    "damped": lambda: family(*chains(4)),
    "undamped": lambda: family(*chains(4, damping=0.0)),
    "overdamped": lambda: family(*chains(4, damping=40.0)),
    "consistent mass": lambda: family(*(lambda M, C, K: (M + 0.1 * np.ones((5, 5)), C, K))(*chains(4))),
    "massless": condensed,
    "gyroscopic": gyroscopic,
    "moved base": moved_base,
}


@pytest.fixture(params=FAMILIES, ids=str)
def systems(request):
    return FAMILIES[request.param]()


def test_modes_are_those_of_each_system(systems):
    modes = systems.modes()
    assert not len(modes.alone)
    for place, system in enumerate(systems):
        own = system.modes()
        values = modes.eigenvalues[place][: len(own.eigenvalues)]
        assert np.abs(values - own.eigenvalues).max() <= 1e-12 * np.abs(values).max()
        assert (np.abs(values - own.eigenvalues) <= 1e-11 * np.abs(values)).all()
        m = len(own.natural_frequencies)
        assert np.allclose(modes.natural_frequencies[place][:m], own.natural_frequencies, rtol=1e-12)
        assert np.allclose(modes.damping_ratios[place][:m], own.damping_ratios, rtol=1e-10, atol=1e-13)
        oscillating = values.imag != 0
        shapes = modes.shapes[place][:, : len(values)][:, oscillating]
        assert np.abs(shapes - own.shapes).max(initial=0.0) <= 1e-11


def test_motions_are_those_of_each_system(systems):
    start = np.zeros(5)
    velocity = np.zeros(5)
    if systems.base.rows:
        velocity[4] = 0.6  # of the prescribed motion
    force = mb.step([0.0, 1.0, 0, 0, 0]) + mb.harmonic([0, 0, 2.0, 0, 0], angular_frequency=3.0)
    for late in (0.0, 0.7):  # a force that starts later restarts its states
        motions = systems.solve(start, velocity, force.delayed(late))
        values, estimates, alone = motions.evaluate(TIMES)
        rates = motions.velocity(TIMES[::3])
        assert not len(alone)
        for place in range(len(systems)):
            own = motions[place]
            exact = own(TIMES)
            assert np.abs(values[place] - exact).max() <= max(1e-13, estimates[place]) * np.abs(exact).max()
            exact = own.velocity(TIMES[::3])
            assert np.abs(rates[place] - exact).max() <= 1e-12 * np.abs(exact).max()


def test_responses_are_those_of_each_system(systems):
    inputs = ["x1", "base"] if systems.base.rows else ["x1", "x3"]
    responses = systems.frequency_response(LINES, inputs, ["x1", "x2", "x4"], "mobility")
    for place, system in enumerate(systems):
        own = system.frequency_response(LINES, inputs, ["x1", "x2", "x4"], "mobility")
        sizes = np.abs(own.values).max(axis=2, keepdims=True)
        assert (np.abs(responses.values[place] - own.values) <= 1e-11 * sizes).all()
    assert responses.units.tolist() == own.units.tolist()


def test_a_record_and_uneven_times():
    systems = family(*chains(3))
    record = mb.sampled(np.linspace(0.0, 2.0, 21), SEED.normal(size=(5, 21)))
    times = np.sort(SEED.uniform(0.0, 4.0, 17))[::-1]
    motions = systems.solve(None, None, record)
    values, _, alone = motions.evaluate(times)
    assert not len(alone)
    for place in range(3):
        assert np.allclose(values[place], motions[place](times), rtol=0, atol=1e-13 * np.abs(values[place]).max())
    assert np.array_equal(motions.of("x2")(times)[:, 0], values[:, 1])


def test_systems_of_another_structure_are_solved_one_by_one():
    M, C, K = chains(6, size=2)
    M[1, 1, 1] = 0.0  # massless
    K[2] = [[1.0, -1.0], [-1.0, 1.0]]  # a free body
    C[2] = 0.0
    M[3], C[3], K[3] = np.eye(2), 2 * np.eye(2), np.eye(2)  # critical damping, defective
    C[4] = 400.0 * C[4]  # overdamped
    systems = family(M, C, K)
    modes, motions = systems.modes(), systems.solve([1.0, 0.0], [0.0, 0.5], mb.step([1.0, 0.0]))
    assert {1, 2, 3} <= set(modes.alone.tolist()) and 0 not in modes.alone
    assert "solved one by one" in modes.notices[0].text
    values = motions(TIMES)
    for place, system in enumerate(systems):
        own = system.modes().eigenvalues
        assert np.abs(modes.eigenvalues[place][: len(own)] - own).max() <= 1e-12 * np.abs(own).max()
        exact = motions[place](TIMES)
        assert np.abs(values[place] - exact).max() <= 1e-12 * np.abs(exact).max()


def test_inconsistent_starts_jump_as_in_each_system():
    systems = moved_base()
    motions = systems.solve([1.0, 0, 0, 0, 0], None)
    values, _, alone = motions.evaluate([0.0, 1.0])
    assert alone.tolist() == list(range(len(systems)))
    assert np.array_equal(values[1], motions[1]([0.0, 1.0]))


def test_stiff_systems_keep_their_slow_digits_or_are_solved_one_by_one():
    k = np.array([1.0, 1e6, 1e12])
    K = np.array([[[1 + each, -each], [-each, each]] for each in k])
    modes = family(np.eye(2), None, K).modes()
    for place in range(3):
        own = family(np.eye(2), None, K)[place].modes().natural_frequencies
        assert np.allclose(modes.natural_frequencies[place], own, rtol=1e-12)


def test_static_forces_of_each_system():
    weights = np.array([[1.0], [2.0]])
    systems = family([[1.0]], [[0.1]], [[4.0]], static_force=weights)
    each = systems.solve()
    assert np.allclose(each(500.0), weights / 4, rtol=1e-9)
    assert np.array_equal(each[1].system.static_force, weights[1])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(mass=np.eye(2)), "found no matrix of shape"),
        (dict(mass=np.ones((2, 1, 1)), stiffness=np.ones((3, 1, 1))), "mass of 2 systems, stiffness of 3 systems"),
        (dict(mass=np.ones((0, 1, 1))), "at least 1"),
        (dict(mass=np.ones((2, 1, 1)), damping=np.ones((2, 2))), "damping: expected shape"),
        (dict(mass=[[[1.0]], [[np.nan]]]), "mass"),
    ],
)
def test_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        family(**arguments)
    systems = family(np.ones((2, 1, 1)), stiffness=np.ones((2, 1, 1)))
    with pytest.raises(InputError, match="displacement"):
        systems.solve(np.zeros((3, 1)))
    with pytest.raises(InputError, match="inputs"):
        systems.frequency_response([1.0], ["force"])
    with pytest.raises(IndexError):
        systems[2]


def supported(count=4):
    """Chains on a moving base, in absolute coordinates."""
    M, C, K = chains(count)
    M[:, 4, 4] = 0.0
    return family(M, C, K, [Constraint([0, 0, 0, 0, 1.0], names="base")])


@pytest.mark.parametrize("quantity", ["displacement", "velocity", "acceleration"])
def test_rms_values_are_those_of_each_system(quantity):
    base = mb.psd([0.01, 0.1, 0.5, 3.0], [1e-3, 0.2, 0.2, 0.01], of="acceleration")
    force = mb.psd([0.05, 2.0, 5.0], [1.0, 0.5, 0.1], of="force")
    options = dict(relative_to="x5") if quantity == "displacement" else {}
    for systems, excitation in (
        (supported(2), {"base": base}),
        (family(*chains(2)), {"x1": force, "x3": force}),
        (family(*chains(2)), {"x2": mb.white_noise(0.3)}),
    ):
        if quantity == "acceleration" and "x2" in excitation:
            continue  # infinite
        responses = systems.random_response(excitation, ["x1", "x4"], quantity, **options)
        assert not len(responses.alone)
        for place, system in enumerate(systems):
            own = system.random_response(excitation, ["x1", "x4"], quantity, **options).rms
            assert (np.abs(responses.rms[place] - own) <= np.maximum(1e-12, responses.error_estimate[place]) * own).all()
            assert np.allclose(responses.rms[place], own, rtol=1e-10)


def test_infinite_and_undamped_variances_are_those_of_each_system():
    M, C, K = chains(3)
    C[1] = 0.0
    systems = family(M, C, K)
    responses = systems.random_response({"x1": mb.white_noise(1.0)}, ["x2"])
    assert responses.alone.tolist() == [1] and np.isinf(responses.rms[1]).all() and np.isfinite(responses.rms[::2]).all()
    assert np.isinf(systems.random_response({"x1": mb.white_noise(1.0)}, ["x1"], "acceleration").rms).all()
    assert responses[2].rms == pytest.approx(responses.rms[2], rel=1e-12)


def test_memory_is_that_of_the_answer_and_of_what_is_kept():
    """Chunks bound the rest: 2000 systems of 8 states need no more for each than 1000 do, and a motion is not held twice."""

    def highest(count, question):
        scattered = 1 + 0.05 * np.random.default_rng(0).normal(size=(count, 1, 1))
        K = (3 * np.eye(4) - np.eye(4, k=1) - np.eye(4, k=-1)) * scattered
        systems = mb.family(np.eye(4), 0.02 * K, K)
        tracemalloc.start()
        try:
            answer = question(systems)
            return tracemalloc.get_traced_memory()[1], answer.nbytes
        finally:
            tracemalloc.stop()

    times = np.linspace(0.0, 5.0, 500)
    for question in (lambda one: one.modes().eigenvalues, lambda one: one.solve(np.ones(4))(times)):
        (small, own), (large, answer) = highest(1000, question), highest(2000, question)
        assert large - answer <= 2.1 * (small - own)
    assert large <= 1.5 * answer  # the last of them, a motion


@pytest.mark.parametrize("ratio", [1e4, 1e6, 1e8, 1e10])
def test_estimates_of_motions_contain_the_error_of_stiff_directions(ratio):
    """Against exponentials in ball arithmetic of the exact data; squarings leave soft directions fewer digits than their data have."""
    root, start = 0.3 * np.sqrt(ratio), [0.0, 1.0]
    for K in ([[ratio, root], [root, 1.0]], [[1 + ratio, -ratio], [-ratio, ratio]], [[ratio + 1, -1.0], [-1.0, 1.0]]):
        C = 1e-3 * np.array(K) + 0.01 * np.eye(2)
        times = np.array([1.0, 10.0, 100.0])
        values, estimates, _ = family(np.eye(2), C, [K, np.multiply(K, 1.1)]).solve(start).evaluate(times)
        exact = np.array([list(map(float, motion([K, C, np.eye(2)], [start, [0.0, 0.0]], time))) for time in times]).T
        assert np.abs(values[0] - exact).max() <= max(estimates[0], 1e-15) * np.abs(exact).max()
        assert estimates[0] <= 1e-12


@pytest.mark.parametrize("seed", range(6))
def test_estimates_of_motions_contain_the_error_of_graded_and_unsymmetric_models(seed):
    rng = np.random.default_rng(seed)
    n, times, models = int(rng.integers(2, 5)), np.array([1.0, 30.0, 1000.0]), []
    for _ in range(3):
        L = rng.standard_normal((n, n))
        K = L @ L.T + 0.1 * np.eye(n)
        if seed % 3 == 1:
            K = np.diag(10.0 ** rng.uniform(-4, 4, n))
            K[0, 1] = K[1, 0] = 0.5 * np.sqrt(K[0, 0] * K[1, 1])
        if seed % 3 == 2:
            K += 0.1 * (L - L.T)
        models.append((np.diag(rng.uniform(0.5, 2, n)), (0.1 if seed % 3 == 2 else 1e-3) * np.eye(n), K))
    start = rng.standard_normal(n)
    values, estimates, _ = family(*map(np.array, zip(*models))).solve(start).evaluate(times)
    for place, (M, C, K) in enumerate(models):
        exact = np.array([list(map(float, motion([K, C, M], [start, np.zeros(n)], time))) for time in times]).T
        assert np.abs(values[place] - exact).max() <= 3 * max(estimates[place], 1e-15) * np.abs(exact).max()  # an estimate


def driveline(stiffness, *, ground_spring=0.0, ground_damper=0.0, damped=True, branch=False):
    """Six inertias, a gear between them; free, on a damper or on a spring; with a second free body."""
    model = mb.LumpedModel()
    for name, inertia in {"a": 0.8, "b": 2.5, "c": 6.0, "d": 0.4, "e": 3.0, "f": 20.0}.items():
        model.inertia(name, inertia)
    for start, end, k in (("a", "b", 3e5), ("b", "c", 2e6), ("c", "d", stiffness), ("e", "f", 5e5)):
        model.torsion_spring(start, end, k)
    model.gear("d", "e", 21, 63)
    for start, end, c in (("a", "b", 200.0), ("c", "d", 60.0)) if damped else ():
        model.torsion_damper(start, end, c)
    if ground_damper:
        model.torsion_damper("ground", "f", ground_damper)
    if ground_spring:
        model.torsion_spring("ground", "f", ground_spring)
    if branch:
        model.mass("u", 2.0), model.mass("v", 3.0), model.spring("u", "v", 7.0 * stiffness)
    return model.assemble()


FREE = {
    "free": ({}, True),
    "free, undamped": ({"damped": False}, True),
    "two free bodies": ({"branch": True}, True),
    "on a damper": ({"ground_damper": 40.0}, True),
    "on a soft damper": ({"ground_damper": 1e-9}, False),
    "one of two on a damper": ({"branch": True, "ground_damper": 40.0}, False),
    "on a soft spring": ({"ground_spring": 1e-9}, False),
}


@pytest.mark.parametrize("options, together", FREE.values(), ids=FREE)
def test_free_systems_are_solved_together_with_the_zeros_of_each(options, together):
    systems = [driveline(k, **options) for k in (11e3, 12e3, 13e3)]
    modes = SampleFamily.of(systems).modes()
    assert len(modes.alone) == (0 if together else 3)
    for system, values, errors, shapes in zip(systems, modes.eigenvalues, modes.error_estimate, modes.shapes):
        single = system.modes()  # by Jordan pairs in precise arithmetic
        size = np.abs(single.eigenvalues)
        assert (values[size == 0] == 0).all()
        assert (np.abs(values - single.eigenvalues) <= 10 * np.maximum(errors, 1e-15) * size).all() and errors.max() < 1e-12
        for i, s in enumerate(values):  # each shape solves its equations
            terms = (system.mass, s**2), (system.damping, s), (system.stiffness, 1.0)
            left = system.position_form().null_space.T
            residual = left @ sum(factor * matrix for matrix, factor in terms) @ shapes[:, i]
            sizes = np.abs(left) @ sum(abs(factor) * np.abs(matrix) for matrix, factor in terms) @ np.abs(shapes[:, i])
            assert np.abs(residual).max() <= 1e-12 * sizes.max()


def test_free_and_supported_samples_of_one_family():
    systems = [driveline(12e3, ground_spring=k) for k in (0.0, 50.0, 0.0, 100.0)]
    M, C, K = (np.stack([getattr(one, name) for one in systems]) for name in ("mass", "damping", "stiffness"))
    modes = family(M, C, K, systems[0].constraints).modes()
    assert (np.sum(modes.eigenvalues == 0, axis=1) == [2, 0, 2, 0]).all()
    for system, frequencies in zip(systems, modes.frequencies_hz):
        assert frequencies[~np.isnan(frequencies)] == pytest.approx(system.modes().frequencies_hz, rel=1e-12)


def test_elements_show_that_a_soft_spring_holds_a_stiff_body():
    """Next to 1e16 N/m the assembled matrix has lost the 4 N/m to the ground; the springs themselves have it."""
    model = mb.LumpedModel()
    model.mass("plate", 1.0), model.mass("sensor", 2.0)
    model.spring("ground", "plate", stiffness=4.0)
    model.spring("plate", "sensor", stiffness=1e16)
    systems, together = [model.assemble(), model.assemble()], np.ones((2, 1))
    family = SampleFamily.of(systems)
    assert not family._is_free(together, "stiffness").any() and family._is_free(together, "damping").all()
    assert super(SampleFamily, family)._is_free(together, "stiffness").all()
