"""The mechanical normal form with singular F against exact arithmetic: verdicts, transformations, motions with impulses, reduction."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import block_diag

import mbconstrained as mb
from tests.oracles.normal_forms import exists_by_criterion, exists_by_definition, random_system, rank, unimodular

#: Random systems with planted parts; each seed is one.
SYSTEMS = 400

#: Of these so many are compared in the default run; the others are long.
SOME = 80


def nilpotent(*degrees):
    """Jordan blocks of zero."""
    return block_diag(np.zeros((0, 0)), *(np.eye(degree, k=1) for degree in degrees)).astype(int)


def assembled(random, J, B_1, N, B_2, steps=None):
    """W diag(s I - J, s N - I) Z with the inputs W [B_1; B_2], unimodular W and Z: F, A, B of integers."""
    n, m = len(J), len(N)
    F = block_diag(np.eye(n, dtype=int), N).reshape(n + m, n + m).astype(object)
    A = block_diag(J.astype(float), np.eye(m)).reshape(n + m, n + m).astype(int).astype(object)
    steps = n + m if steps is None else steps
    (W, _), (Z, _) = unimodular(random, n + m, steps), unimodular(random, n + m, steps)
    return W.dot(F).dot(Z), W.dot(A).dot(Z), W.dot(np.vstack([B_1, B_2]).astype(object))


def planted(seed):
    """(F, A, B, J, B_1): integers, of index 0 to 3, where B_1 are the independent ones among the inputs of the finite part."""
    random = np.random.default_rng(seed)
    n = 2 * int(random.integers(0, 4)) - int(random.random() < 0.1)
    n, k = max(n, 0), int(random.integers(0, max(n, 0) // 2 + 1))
    degrees = [int(degree) for degree in random.integers(1, 4, int(random.integers(n == 0, 4)))]
    N = nilpotent(*degrees)
    J, B_1 = random_system(random, n, k) if n else (np.zeros((0, 0)), np.zeros((0, 0)))
    p = k + int(random.integers(0, len(N) + 1) if len(N) else 0) * int(random.random() < 0.3)
    R = np.hstack([np.eye(k, dtype=int), random.integers(-1, 2, (k, p - k))])
    B = B_1.dot(R)
    while True:
        B_2 = random.integers(-2, 3, (len(N), p))
        if rank(np.vstack([B, B_2])) == p:
            break
    return *assembled(random, J, B, N, B_2, int(random.choice([0, 2, n + len(N)]))), J, B_1


def outcome(function, *arguments, **names):
    """The form, or the exception that says that there is none."""
    try:
        return function(*arguments, **names)
    except mb.NoNormalForm as problem:
        return problem
    except mb.InputError as problem:
        assert "even number" in str(problem)  # a regular F
        return mb.NoNormalForm(str(problem), condition="descriptor")


def exactly(matrix):
    return np.array([[Fraction(entry) for entry in row] for row in matrix], dtype=object).reshape(np.shape(matrix))


def compare(seed):
    """The verdicts agree with the planted ones, and the transformations satisfy their equations, in rational arithmetic."""
    F, A, B, J, B_1 = planted(seed)
    wanted = len(J) % 2 == 0 and (not len(J) or exists_by_definition(J, B_1))
    if len(J) % 2 == 0 and len(J):
        assert wanted == exists_by_criterion(J, B_1)
    exact = outcome(mb.exact.mechanical_normal_form, A, B, descriptor=F)
    assert isinstance(exact, mb.NoNormalForm) != wanted, seed
    if wanted:
        T, L = exact.transformation, exact.left_transformation
        assert (L @ F == T).all() and (L @ A == exact.state_matrix @ T).all() and (L @ B == exact.input_matrix).all()
        assert (T @ exact.inverse == np.eye(len(J), dtype=int)).all()
        half = len(J) // 2
        assert (exact.state_matrix[:half] == np.eye(half, 2 * half, k=half)).all() and not exact.input_matrix[
            : 2 * half - B_1.shape[1]
        ].any()
    floats = (np.array(matrix, dtype=float) for matrix in (A, B, F))
    A_, B_, F_ = floats
    form = outcome(mb.mechanical_normal_form, A_, B_, descriptor=F_)
    if isinstance(form, mb.NoNormalForm):
        assert not wanted or form.doubtful, (seed, form)
        if not wanted and not form.doubtful:
            assert form.condition == exact.condition, (seed, form, exact)
        return form.doubtful
    doubtful = any(notice.doubtful for notice in form.notices)
    assert wanted or doubtful, seed
    if wanted:
        check_transformation(form, F, A, B)
    return doubtful


def check_transformation(form, F, A, B, tolerance=1e-9):
    """L F = T, L A = A^ T and L B = B^ in rational arithmetic, relative to the terms."""
    T, L, state, inputs = map(exactly, (form.transformation, form.left_transformation, form.state_matrix, form.input_matrix))
    for value, wanted, size in (
        (L @ F, T, abs(L) @ abs(F)),
        (L @ A, state @ T, abs(L) @ abs(A) + abs(state) @ abs(T)),
        (L @ B, inputs, abs(L) @ abs(B) + 1),
    ):
        if value.size:
            assert float(abs(value - wanted).max()) <= tolerance * float(size.max())


@pytest.mark.parametrize("first", [0, *(pytest.param(at, marks=pytest.mark.long) for at in range(SOME, SYSTEMS, SOME))])
def test_random_exact_systems(first):
    doubtful = sum(compare(seed) for seed in range(first, first + SOME))
    assert doubtful <= SOME // 50


def mechanical(degrees, n=4, k=1, p=1, seed=0):
    """(A, B, C, D, F) with a finite part of n states that has a normal form, and nilpotent blocks of these degrees."""
    random = np.random.default_rng(seed)
    J, N = random.integers(-2, 3, (n, n)), nilpotent(*degrees)
    B_1, B_2 = np.zeros((n, p), dtype=int), random.integers(-2, 3, (len(N), p))
    B_1[n - k :, :k] = np.eye(k, dtype=int)
    B_2[-1:, k:] = 1
    F, A, B = assembled(random, J, B_1, N, B_2)
    size = len(F)
    return (*(np.array(M, dtype=float) for M in (A, B, random.integers(-2, 3, (2, size)), random.integers(-2, 3, (2, p)), F)),)


SHAPES = {
    "index 1": ((1,), 4, 1, 1),
    "index 2": ((2, 1), 4, 1, 1),
    "index 3": ((3, 2), 4, 2, 2),
    "no finite part": ((2, 1), 0, 0, 1),
    "no inputs": ((2,), 4, 0, 0),
    "an input of the infinite part alone": ((2,), 4, 1, 2),
    "one infinite state alone": ((1,), 0, 0, 1),
}


@pytest.mark.parametrize("shape", SHAPES)
def test_motion_transfer_function_and_impulses_are_those_of_the_descriptor_system(shape):
    degrees, n, k, p = SHAPES[shape]
    A, B, C, D, F = mechanical(degrees, n, k, p)
    form, given = mb.mechanical_normal_form(A, B, C, D, descriptor=F), mb.StateSpace(A, B, C, D, F)
    assert (2 * form.size, form.infinite.size, form.infinite.index) == (n, sum(degrees), max(degrees))
    assert int(form.input_matrix.any(axis=1).sum()) == k
    for s in (0.3 + 2j, -1.7):
        value = form.output_matrix @ np.linalg.solve(s * np.eye(n) - form.state_matrix, form.input_matrix)
        value = value + sum(s**power * matrix for power, matrix in enumerate(form.polynomial))
        assert np.abs(value - given(s)).max(initial=0) <= 1e-10 * max(1.0, np.abs(given(s)).max(initial=0))
        assert np.abs(form.state_space()(s) - given(s)).max(initial=0) <= 1e-10 * max(1.0, np.abs(given(s)).max(initial=0))
    x0, u = np.arange(1.0, len(A) + 1), mb.step(np.ones(p)) + mb.harmonic(np.ones(p), angular_frequency=2.0) if p else mb.zero(0)
    wanted, found = given.solve(x0, u), form.state_space().solve(form.coordinates(x0), u)
    times = np.array([0.0, 0.1, 0.7, 2.0])
    assert found.output(times) == pytest.approx(wanted.output(times), rel=1e-9, abs=1e-9 * np.abs(wanted.output(times)).max())
    assert len(found.output_impulses) == len(wanted.output_impulses)
    for one, other in zip(found.output_impulses, wanted.output_impulses):
        assert one == pytest.approx(other, abs=1e-9 * max(1.0, np.abs(other).max()))
    motion = form.system().solve(*form.displacement_velocity(x0), force=form.force(u))
    x = form.state(motion(times), motion.velocity(times))
    assert x == pytest.approx(wanted(times), rel=1e-9, abs=1e-9 * np.abs(wanted(times)).max())


def test_the_state_follows_from_its_coordinates():
    A, B, _, _, F = mechanical((2, 1))
    form = mb.mechanical_normal_form(A, B, descriptor=F)
    x = np.arange(1.0, len(A) + 1)
    assert form.state(*form.displacement_velocity(x)) == pytest.approx(x, rel=1e-10)
    with pytest.raises(mb.InputError, match="expected 7 states"):
        form.displacement_velocity([1.0])


@pytest.mark.parametrize("method", ["extension", "null space", "kronecker"])
def test_all_methods_serve_the_finite_part(method):
    A, B, _, _, F = mechanical((1,), n=4, k=2, p=2)
    form = mb.mechanical_normal_form(A, B, descriptor=F, method=method)
    check_transformation(form, *(exactly(matrix) for matrix in (F, A, B)))


@pytest.mark.parametrize("kind", ["orthogonal", "scaled"])
def test_verdicts_survive_a_change_of_equations_and_states(kind):
    for seed in range(30):
        F, A, B, J, B_1 = planted(seed)
        random, n = np.random.default_rng(seed), len(F)
        wanted = len(J) % 2 == 0 and (not len(J) or exists_by_definition(J, B_1))
        W, Z = (
            np.linalg.qr(random.standard_normal((n, n)))[0] if kind == "orthogonal" else np.diag(10.0 ** random.uniform(-4, 4, n))
            for _ in range(2)
        )
        A_, B_, F_ = W @ A.astype(float) @ Z, W @ B.astype(float), W @ F.astype(float) @ Z
        form = outcome(mb.mechanical_normal_form, A_, B_, descriptor=F_)
        if isinstance(form, mb.NoNormalForm):
            assert not wanted or form.doubtful, seed
        else:
            assert wanted or any(notice.doubtful for notice in form.notices), seed


def chain():
    """Six masses in a row with an acceleration among the outputs: a descriptor form of 18 states."""
    model = mb.LumpedModel()
    for i in range(6):
        model.mass(f"m{i}", 1.0 + i / 3)
        start = "ground" if not i else f"m{i - 1}"
        model.spring(start, f"m{i}", stiffness=100.0 * (i + 1)), model.damper(start, f"m{i}", 0.2)
    return model.assemble()


@pytest.mark.parametrize("count", [0, 1, 2, 3, 5, 6])
def test_reduction_keeps_the_slowest_modes_and_the_static_response(count):
    model = chain()
    given = model.to_state_space(["m5"], ["m0", "m5", "m5 acceleration"])
    form = mb.mechanical_normal_form(given.A, given.B, given.C, given.D, descriptor=given.E).reduced(count)
    T, L = form.transformation, form.left_transformation
    assert T.shape == (2 * count, 18)
    assert np.abs(L @ given.E - T).max(initial=0) <= 1e-9 * np.abs(T).max(initial=1)
    assert np.abs(L @ given.A - form.state_matrix @ T).max(initial=0) <= 1e-9 * np.abs(form.state_matrix @ T).max(initial=1)
    assert np.abs(L @ given.B - form.input_matrix).max(initial=0) <= 1e-9
    assert form.system().modes().natural_frequencies == pytest.approx(model.modes().natural_frequencies[:count], rel=1e-8)
    assert form.state_space()(0.0) == pytest.approx(given(0.0), rel=1e-9, abs=1e-9)
    if count < 6:
        (bound,) = (item.value for item in form.evidence if item.name == "truncation")
        s = 1j * (model.modes().natural_frequencies[count - 1] if count else 0.0) * np.linspace(0.01, 0.99, 40)
        errors = [np.abs(form.state_space()(value) - given(value)).max() for value in s]
        assert max(errors) <= 3 * bound * max(np.abs(given(value)).max() for value in s) + 1e-9
        assert any(notice.kind == "omitted" for notice in form.notices)


def test_reduction_refuses_what_it_cannot_divide_or_leave_out():
    given = chain().to_state_space(["m5"], ["m0"])
    form = mb.mechanical_normal_form(given.A, given.B, given.C, given.D, descriptor=given.E)
    for count, match in ((7, "at most 6"), (-1, "at least 0"), (1.5, "whole number")):
        with pytest.raises(mb.InputError, match=match):
            form.reduced(count)
    growing = mb.mechanical_normal_form(block_diag([[0.0, 1.0], [-1.0, -1.0]], [[0.0, 1.0], [-4.0, 1.0]]), None)
    with pytest.raises(mb.InputError, match="grows; keep more"):
        growing.reduced(1)
    free = mb.mechanical_normal_form(block_diag([[0.0, 1.0], [0.0, 0.0]], [[-1.0]]), None, descriptor=np.diag([1.0, 1.0, 0.0]))
    with pytest.raises(mb.InputError, match="is free; keep more"):
        free.reduced(0)
    with pytest.raises(mb.InputError, match="at least 1 for a system that has no infinite part"):
        growing.reduced(0)
    divided = mb.mechanical_normal_form(block_diag([[-1.0]], [[0.0, 9.0], [-9.0, -1.0]], [[-20.0]]), None)
    with pytest.raises(mb.InputError, match="possible are 2"):
        divided.reduced(1)


def test_the_truncation_does_not_depend_on_the_units_of_inputs_and_outputs():
    given, values = chain().to_state_space(["m5", "m2"], ["m0", "m5 acceleration"]), []
    for outputs, inputs in (([1.0, 1.0], [1.0, 1.0]), ([1e9, 1e-3], [1e-6, 1e6])):
        form = mb.mechanical_normal_form(
            given.A, given.B * inputs, np.diag(outputs) @ given.C, np.diag(outputs) @ given.D * inputs, descriptor=given.E
        )
        values += [item.value for item in form.reduced(2).evidence if item.name == "truncation"]
    assert values[0] > 0 and values[1] == pytest.approx(values[0], rel=1e-9)


def test_a_reduced_form_is_reduced_further():
    given = chain().to_state_space(["m5"], ["m0"])
    form = mb.mechanical_normal_form(given.A, given.B, given.C, given.D, descriptor=given.E)
    once, twice = form.reduced(2), form.reduced(4).reduced(2)
    assert twice.state_space()(0.3j) == pytest.approx(once.state_space()(0.3j), rel=1e-9)
    assert [len(each.notices) for each in (once, twice)] == [1, 2]


def test_conditions_of_the_finite_part_are_named_as_its_own():
    A, F = block_diag([[0.0, 1.0], [0.0, 0.0]], np.eye(3)), np.diag([1.0, 1.0, 0.0, 0.0, 0.0])
    for function in (mb.mechanical_normal_form, mb.exact.mechanical_normal_form):
        with pytest.raises(mb.NoNormalForm, match=r"of the finite part, x' = A x \+ B u with 2 of 5 states: rank \[B, A B\] = 1"):
            function(A, [[1.0], [0.0], [0.0], [0.0], [0.0]], descriptor=F)


def test_more_inputs_than_states_are_refused_and_as_many_may_act_on_the_infinite_part():
    with pytest.raises(mb.InputError, match="3 inputs for 2 states; at most 2 of them can be independent"):
        mb.mechanical_normal_form(np.eye(2), np.eye(2, 3), descriptor=np.zeros((2, 2)))
    form = mb.mechanical_normal_form(np.eye(2), np.eye(2), np.eye(2), descriptor=np.zeros((2, 2)))
    assert (form.size, form.infinite.index, form.polynomial[0].tolist()) == (0, 1, [[-1.0, 0.0], [0.0, -1.0]])


def test_a_descriptor_between_singular_and_regular_is_doubtful_or_refused():
    """F of rank n to within rounding errors, in coordinates that do not show it: never a verdict without a doubt, never a traceback."""
    for seed in (775, *range(60)):  # 775: singular in its own units, regular in those of the pencil
        random = np.random.default_rng(seed)
        n = int(random.integers(1, 7))
        sizes = np.where(random.random(n) < 0.4, 10.0 ** random.uniform(-20, -11, n), 1.0)
        W, Z = (np.linalg.qr(random.standard_normal((n, n)))[0] @ np.diag(10.0 ** random.uniform(-5, 5, n)) for _ in range(2))
        F, A, B = W @ np.diag(sizes) @ Z, W @ random.integers(-2, 3, (n, n)) @ Z, W @ random.integers(-1, 2, (n, 1))
        try:
            form = mb.mechanical_normal_form(A, B, np.eye(n), descriptor=F)
        except (mb.NoNormalForm, mb.InputError, mb.IllConditioned):
            continue
        wanted, found = np.linalg.solve(0.7 * F - A, B), form.state_space()(0.7)
        error = np.abs(found - wanted).max() / np.abs(wanted).max()
        assert any(notice.doubtful for notice in form.notices) or error <= 1e-6, seed


@pytest.mark.parametrize(
    "arguments, error, match",
    [
        ({"A": [[1, 2]], "B": None}, mb.InputError, "square"),
        ({"A": np.zeros((0, 0)), "B": None}, mb.InputError, "at least one state"),
        ({"A": [[float("nan"), 1], [1, 1]], "B": None}, mb.InputError, "finite rational"),
        ({"A": np.eye(2), "B": [[1, 2], [1, 2]]}, mb.InputError, "independent"),
        ({"A": np.eye(3), "B": None}, mb.InputError, "even number"),
        ({"A": [[0, 1], [0, 0]], "B": None, "descriptor": [[0, 1], [0, 0]]}, mb.NoNormalForm, "row 2"),
        ({"A": np.eye(2), "B": None, "descriptor": np.eye(3)}, mb.InputError, "expected shape 2 x 2"),
        ({"A": np.eye(2), "B": [1, 1], "D": [[1]]}, mb.InputError, "feedthrough without outputs"),
    ],
)
def test_the_exact_form_checks_its_arguments(arguments, error, match):
    with pytest.raises(error, match=match):
        mb.exact.mechanical_normal_form(**arguments)


def test_the_exact_form_takes_a_single_output_as_a_row():
    form = mb.exact.mechanical_normal_form([[0, 1], [-4, -1]], [0, 1], [1, 0])
    assert (form.output_matrix.tolist(), form.polynomial[0].tolist()) == ([[1, 0]], [[0]])
