"""The mechanical normal form with singular F against exact arithmetic: verdicts, transformations, motions with impulses, reduction."""

from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import block_diag

import mbconstrained as mb
from tests.oracles.normal_forms import exists_by_criterion, exists_by_definition, random_system, rank, unimodular

#: Random systems with planted parts; each seed is one.
SYSTEMS = 1000

#: Of these so many are compared in the default run; the others are long.
SOME = 200


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
        assert (exact.state_matrix[:half] == np.eye(half, 2 * half, k=half)).all() and not exact.input_matrix[: 2 * half - B_1.shape[1]].any()
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
    for value, wanted, size in ((L @ F, T, abs(L) @ abs(F)), (L @ A, state @ T, abs(L) @ abs(A) + abs(state) @ abs(T)), (L @ B, inputs, abs(L) @ abs(B) + 1)):
        if value.size:
            assert float(abs(value - wanted).max()) <= tolerance * float(size.max())


@pytest.mark.parametrize("first", [0, *(pytest.param(at, marks=pytest.mark.long) for at in range(SOME, SYSTEMS, SOME))])
def test_random_exact_systems(first):
    doubtful = sum(compare(seed) for seed in range(first, first + SOME))
    assert doubtful <= SOME // 50
