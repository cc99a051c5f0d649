"""Existence: the verdict in floating point against rational arithmetic, for data as it is, rotated, scaled and near the noise."""

import json
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.mechanics.normal_form_existence import StateSpaceData, existence, scaled_pencil
from tests.oracles.normal_forms import (
    exists_by_criterion,
    exists_by_definition,
    exists_in_the_paper,
    jordan,
    matrix_of,
    random_system,
    unimodular,
    zero_one_matrix,
)

ORACLES = Path(__file__).parents[1] / "oracles"
CASES = json.loads((ORACLES / "mayet.json").read_text(encoding="utf-8"))

#: Those of the 65,536 matrices of size 4 with entries 0 and 1, B = e_4, where the printed theorem is wrong.
PAPER_WRONG = json.loads((ORACLES / "zero_one_matrices.json").read_text(encoding="utf-8"))
LAST = np.array([[0], [0], [0], [1]])

#: Jordan blocks (eigenvalue, size) of a system without inputs, and whether it has a normal form.
BLOCKS = [
    (((5, 1), (5, 1)), False),
    (((5, 2),), True),
    (((5, 3), (5, 1)), True),
    (((5, 1), (5, 1), (7, 2)), True),
    (((5, 1), (5, 1), (5, 1), (7, 1)), False),
    (((5, 1), (5, 1), (0, 1), (0, 1)), True),
    (((0, 2), (0, 2)), True),
    (((0, 3), (0, 1)), True),
    (((0, 2), (0, 1), (0, 1)), False),
    (((2, 1), (2, 1), (2, 1), (2, 3)), False),
    (((2, 1), (2, 1), (2, 2), (2, 2)), False),
    (((2, 2), (2, 2), (2, 2)), True),
    (((3, 4), (3, 1), (3, 1)), True),
    (((3, 1),) * 5 + ((1, 1), (2, 1), (4, 1)), False),
    (((3, 1),) * 4 + ((1, 1), (2, 1), (4, 1), (6, 1)), True),
]


def verdict(A, B, clear=True):
    """Whether the package finds a form; it must be sure of that unless told otherwise."""
    try:
        form = mb.mechanical_normal_form(np.asarray(A, dtype=float), None if B is None else np.asarray(B, dtype=float))
    except mb.NoNormalForm as error:
        assert not (clear and error.doubtful), error
        return False
    assert not (clear and form.notices), form.notices
    return True


def exists(A, B):
    """The verdict alone, without the transformation."""
    data = StateSpaceData(np.asarray(A, dtype=float), np.asarray(B, dtype=float))
    try:
        return not existence(scaled_pencil(data)).notices or None
    except mb.NoNormalForm as error:
        return False if not error.doubtful else None


def rotated(random, A, B):
    Q = np.linalg.qr(random.standard_normal(A.shape))[0]
    return Q @ A @ Q.T, Q @ B


def scaled(random, A, B):
    d, c = 10.0 ** random.uniform(-6, 6, len(A)), 10.0 ** random.uniform(-6, 6, B.shape[1])
    return d[:, None] * A / d, d[:, None] * B * c


def mixed(random, A, B):
    S = random.standard_normal(A.shape)
    return S @ A @ np.linalg.inv(S), S @ B


def rotated_and_scaled(random, A, B):
    return scaled(random, *rotated(random, A, B))


CHANGES = (rotated, scaled, mixed, rotated_and_scaled)


@pytest.mark.parametrize("name", CASES)
def test_flags_of_the_worked_examples(name):
    case = {key: matrix_of(text).astype(float) for key, text in CASES[name].items() if text}
    wanted = not name.startswith(("F1", "F2", "F3"))
    if "F" not in case:
        assert verdict(case["A"], case["B"]) == wanted
        assert exists_by_definition(case["A"].astype(int), case["B"].astype(int)) == wanted


@pytest.mark.parametrize(
    "name, condition, rank, needed, eigenvalue",
    [
        ("F1", "rank [B, A B]", 1, 2, None),
        ("F2", "rank [A - lambda I, B]", 2, 3, 0.0),
        ("F3", "rank [A - lambda I, B]", 2, 3, 5.0),
    ],
)
def test_the_failing_condition_is_named(name, condition, rank, needed, eigenvalue):
    key = next(key for key in CASES if key.startswith(name))
    A, B = (matrix_of(CASES[key][part]).astype(float) for part in "AB")
    for change in (lambda _, A, B: (A, B), rotated, mixed):
        with pytest.raises(mb.NoNormalForm) as caught:
            mb.mechanical_normal_form(*change(np.random.default_rng(0), A, B))
        error = caught.value
        assert (error.condition, error.rank, error.needed) == (condition, rank, needed)
        assert error.eigenvalue is eigenvalue is None or abs(error.eigenvalue - eigenvalue) < 1e-13
        assert f"{condition} = {rank}" in str(error) and str(needed) in str(error)


@pytest.mark.long
def test_where_the_paper_is_wrong_the_verdict_is_right():
    """2,016 of all 2,528 that it denies a form they have, 512 that it promises one they do not have; the verdict on every fourth."""
    promised = 0
    for place, number in enumerate(PAPER_WRONG):
        A = zero_one_matrix(number)
        truth = exists_by_criterion(A, LAST)
        assert exists_in_the_paper(A, LAST) != truth
        assert place % 4 or exists(A, LAST) == truth, number
        promised += not truth
    assert (len(PAPER_WRONG), promised) == (2528, 512)


@pytest.mark.long
def test_a_sample_of_all_zero_one_matrices():
    for number in np.random.default_rng(65536).choice(65536, 600, replace=False):
        A = zero_one_matrix(int(number))
        truth = exists_by_criterion(A, LAST)
        assert exists(A, LAST) == truth, number
        assert exists_in_the_paper(A, LAST) == truth or number in PAPER_WRONG


def test_all_matrices_of_size_two():
    """n = 2, p = 0 with entries from -2 to 1: all but the multiples of the identity have a form."""
    for number in range(256):
        A = np.array([(number >> 2 * place & 3) - 2 for place in range(4)]).reshape(2, 2)
        truth = bool(A[0, 1] or A[1, 0] or A[0, 0] != A[1, 1])
        assert exists_by_definition(A, np.zeros((2, 0), dtype=int)) == exists_by_criterion(A, np.zeros((2, 0), dtype=int)) == truth
        assert verdict(A, None) == truth


@pytest.mark.parametrize("blocks, truth", BLOCKS)
def test_jordan_blocks_without_inputs(blocks, truth):
    A, none = jordan(*blocks), np.zeros((sum(size for _, size in blocks), 0), dtype=int)
    assert exists_by_definition(A, none) == exists_by_criterion(A, none) == truth
    assert verdict(A, none) == truth
    random = np.random.default_rng(len(blocks))
    for _ in range(10):
        S, inverse = unimodular(random, len(A), 3 * len(A))
        assert verdict(S.dot(A).dot(inverse), none) == truth
        for change in (rotated, mixed):
            assert verdict(*change(random, A.astype(float), none), clear=False) == truth


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.data())
def test_verdicts_are_exact_and_survive_similarity(seed, half, data):
    p = data.draw(st.integers(0, half))
    random = np.random.default_rng(seed)
    A, B = random_system(random, 2 * half, p)
    truth = exists_by_definition(A, B)
    assert exists_by_criterion(A, B) == truth
    A, B = A.astype(float), B.astype(float)
    assert verdict(A, B) == verdict(A / 3, B / 7) == truth
    if not p and (A == A[0, 0] * np.eye(len(A))).all():
        return  # its rotation is rounding and nothing else, see below
    for change in CHANGES:
        assert verdict(*change(random, A, B), clear=False) == truth


@pytest.mark.parametrize("n, p", [(20, 0), (20, 3), (60, 10), (60, 29), pytest.param(200, 0, marks=pytest.mark.long)])
def test_large_systems_without_a_form(n, p):
    """Beside a controllable part, n/2 - p + 1 times the same eigenvalue, one of them in a block of size two if there is room."""
    random = np.random.default_rng(n + p)
    rest = n - 2 * p
    repeated = np.diag(np.r_[np.full(rest // 2 + 1, 5.0), -1.0 - np.arange(rest // 2 - 1)])
    if rest > 2:
        repeated[0, -1], repeated[-1, -1] = 1, 5
    A = scipy.linalg.block_diag(random.standard_normal((2 * p, 2 * p)), repeated)
    A[: 2 * p, 2 * p :] = random.standard_normal((2 * p, rest))
    B = np.vstack([random.standard_normal((2 * p, p)), np.zeros((rest, p))])
    for change in (rotated, scaled, mixed):
        with pytest.raises(mb.NoNormalForm) as caught:
            mb.mechanical_normal_form(*change(random, A, B))
        assert abs(caught.value.eigenvalue - 5) < 1e-9
        assert caught.value.needed - caught.value.rank == 1


def test_scalar_matrices_that_were_rotated():
    """5 I through rounding: no, or a yes that is told to rest on tiny entries."""
    random = np.random.default_rng(9)
    for _ in range(30):
        n = 2 * int(random.integers(1, 4))
        A, none = rotated(random, 5.0 * np.eye(n), np.zeros((n, 0)))
        assert not verdict(A, none, clear=False)
        A, none = scaled(random, A, none)
        try:
            assert any(notice.doubtful for notice in mb.mechanical_normal_form(A, none).notices)
        except mb.NoNormalForm as error:
            assert error.margin < 1e-12


@pytest.mark.parametrize("exponent", range(-16, -4))
def test_how_near_is_told(exponent):
    """diag(5, 5 + d) has a form for d > 0; what rounding may have made is no, or in doubt."""
    distance = 10.0**exponent
    A = np.array([[5.0, distance], [distance, 5.0]])
    try:
        form = mb.mechanical_normal_form(A, None)
    except mb.NoNormalForm as error:
        assert distance < 1e-12 and error.margin < 1e-12
        return
    assert distance > 1e-13
    assert any(notice.doubtful for notice in form.notices) == (distance < 1e-10)


def test_a_narrow_input_margin_is_told():
    A = np.array([[0, 0, 1, 0], [0, 0, 0, 0], [-1, 2, 0, 1], [3, -1, 1, 0]], dtype=float)
    B = np.array([[0, 0], [0, 0], [1, 0], [0, 1]], dtype=float)
    with pytest.raises(mb.NoNormalForm, match=r"rank \[B, A B\] = 3, but 2 p = 4"):
        mb.mechanical_normal_form(A, B)
    random = np.random.default_rng(0)
    Q = np.linalg.qr(random.standard_normal((4, 4)))[0]
    A[1, 3] = 1e-12
    form = mb.mechanical_normal_form(Q @ A @ Q.T, Q @ B)
    assert [notice.doubtful for notice in form.notices] == [True]
    assert "rank [B, A B] = 2 p holds by a narrow margin" in form.notices[0].text


def test_a_stiff_chain_has_a_form():
    """Twelve orders of magnitude between its springs."""
    k = np.array([1e-3, 1e9, 1.0, 1e5, 1e-2, 1e7])
    K = np.diag(k + np.r_[k[1:], 0]) - np.diag(k[1:], 1) - np.diag(k[1:], -1)
    A = np.block([[np.zeros((6, 6)), np.eye(6)], [-K, -1e-4 * K]])
    for p in (0, 1, 6):
        assert verdict(A, np.vstack([np.zeros((6, p)), np.eye(6, p)]))


def test_units_do_not_decide():
    """States, inputs and time in other units: the same verdict, by about the same margin."""
    random = np.random.default_rng(8)
    A, B = random.standard_normal((8, 8)), random.standard_normal((8, 2))
    d, c = 2.0 ** random.integers(-20, 20, 8), 2.0 ** random.integers(-20, 20, 2)
    one = mb.mechanical_normal_form(A, B).evidence
    other = mb.mechanical_normal_form(1024 * d[:, None] * A / d, d[:, None] * B * c).evidence
    margins = [{item.name: item.value for item in found if "margin" in item.name} for found in (one, other)]
    assert all(0.1 < margins[0][name] / margins[1][name] < 10 for name in margins[0])


def test_scaling_does_not_hide_entries():
    """J3(5) + J2(5) + 3 J1(5), rotated and scaled over twelve orders of magnitude: entries far below others belong to it."""
    A, none = jordan((5, 3), (5, 1), (5, 1), (5, 2), (5, 1)).astype(float), np.zeros((8, 0))
    for seed in range(100):
        assert verdict(*rotated_and_scaled(np.random.default_rng(seed), A, none), clear=False) is False


@pytest.mark.parametrize("condition", [1e2, 1e6, 1e10])
def test_an_ill_conditioned_descriptor_does_not_decide(condition):
    random = np.random.default_rng(1)
    for n, p in ((4, 1), (8, 2), (8, 0)):
        L, R = (np.linalg.qr(random.standard_normal((n, n)))[0] for _ in range(2))
        F = L @ np.diag(np.r_[np.ones(n - 1), 1 / condition]) @ R
        form = mb.mechanical_normal_form(random.standard_normal((n, n)), random.standard_normal((n, p)), descriptor=F)
        assert not form.notices
        left, T = form.left_transformation, form.transformation
        assert np.abs(left @ F - T).max() <= 1e-13 * (np.abs(left) @ np.abs(F)).max()


@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.data())
def test_verdicts_of_descriptor_forms(seed, half, data):
    """F A, F B and F have the verdict of A and B, for integer F, dense F and F of other units in each equation."""
    p = data.draw(st.integers(0, half))
    random = np.random.default_rng(seed)
    A, B = random_system(random, 2 * half, p)
    truth, A, B = exists_by_definition(A, B), A.astype(float), B.astype(float)
    dense = random.standard_normal(A.shape)
    for F in (unimodular(random, 2 * half, 4 * half)[0].astype(float), dense, 10.0 ** random.uniform(-4, 4, (len(A), 1)) * dense):
        try:
            existence(scaled_pencil(StateSpaceData(F @ A, F @ B, F=F)))
            found = True
        except mb.NoNormalForm:
            found = False
        assert found == truth
