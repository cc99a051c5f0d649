"""Identities between A(s), its Jordan pairs and the Laurent coefficients H_i (Moysis et al., section 2, corrected)."""

from __future__ import annotations

import numpy as np
from hypothesis import assume, given
from hypothesis import strategies as st

from tests.properties.matrices import Sample, relative, samples

#: Rounding is amplified by the condition of the zeros; a wrong decision costs more than a per mille.
BAR = 1e-7

points = st.builds(complex, st.floats(-2, 2, width=16), st.floats(0.25, 3, width=16))


@given(samples(), points)
def test_both_pairs_together_are_the_inverse(sample: Sample, s: complex):
    """A(s)^-1 = C (s I - J)^-1 B + C_inf (I - s J_inf)^-1 B_inf at any s that is no zero."""
    assume(all(abs(s - zero) > 0.3 for zero in sample.zeros))
    finite, infinite = sample.pairs.finite, sample.pairs.infinite
    inverse = finite.C @ np.linalg.solve(s * np.eye(len(finite.J)) - finite.J, finite.B)
    inverse = inverse + infinite.C @ np.linalg.solve(np.eye(len(infinite.J)) - s * infinite.J, infinite.B)
    known = np.linalg.inv(sample.matrix(s))
    assert np.abs(inverse - known).max() <= BAR * max(1.0, np.abs(known).max())


@given(samples())
def test_laurent_coefficients_are_those_of_exact_division(sample: Sample):
    for index in range(-2 * sample.degree - 2, sample.highest_impulse + 2):
        assert relative(sample.H(index), sample.H_exact(index)) <= BAR


@given(samples())
def test_laurent_coefficients_come_from_the_pairs(sample: Sample):
    """C_inf J_inf^i B_inf = H_i for i >= 0, C J^(i-1) B = H_-i for i >= 1, H_i = 0 beyond qh and H_qh is not."""
    finite, infinite, highest = sample.pairs.finite, sample.pairs.infinite, sample.highest_impulse
    for index in range(highest + 2):
        found = infinite.C @ np.linalg.matrix_power(infinite.J, index) @ infinite.B
        assert relative(found, sample.H_exact(index)) <= BAR
    for index in range(1, 2 * sample.degree + 2):
        assert relative(finite.C @ np.linalg.matrix_power(finite.J, index - 1) @ finite.B, sample.H_exact(-index)) <= BAR
    assert not sample.H(highest + 1).any()
    if highest:
        assert sample.H(highest).any()


@given(samples())
def test_finite_pair_annihilates_a(sample: Sample):
    """sum A_j C J^j = 0 and sum J^j B A_j = 0."""
    C, J, B = sample.pairs.finite.C, sample.pairs.finite.J, sample.pairs.finite.B
    powers = [np.linalg.matrix_power(J, j) for j in range(sample.degree + 1)]
    right = [A @ C @ power for A, power in zip(sample.coefficients, powers)]
    left = [power @ B @ A for A, power in zip(sample.coefficients, powers)]
    for terms in (right, left):
        size = max((np.abs(term).max(initial=0.0) for term in terms), default=0.0)
        assert np.abs(sum(terms)).max(initial=0.0) <= BAR * size


@given(samples(least_degree=1))
def test_finite_pair_is_normalized(sample: Sample):
    """[J^(q-1) B ... B] M1 col(C, CJ, ..., CJ^(q-1)) = I_n."""
    n = sample.finite_count
    product = reachability(sample) @ upper_values(sample) @ observability(sample)
    assert product.shape == (n, n)
    assert relative(product, np.eye(n)) <= BAR


@given(samples(least_degree=1))
def test_projector_on_consistent_values_is_a_projector_of_rank_n(sample: Sample):
    """P = col(C..) [..B] M1: P^2 = P, trace n, and P + [H_(c-k)] M0 = I, Eq. (61) corrected."""
    P = projector(sample)
    q, identity = sample.degree, np.eye(sample.size * sample.degree)
    assert relative(P @ P, P) <= BAR * max(1.0, np.abs(P).max())
    assert abs(np.trace(P) - sample.finite_count) <= BAR * max(1.0, np.abs(P).max())
    toeplitz = np.block([[sample.H(c - k) for c in range(q)] for k in range(q)])
    size = max(1.0, np.abs(toeplitz).max() * np.abs(sample.coefficients).max())
    assert np.abs(P + toeplitz @ lower_values(sample) - identity).max() <= BAR * size


@given(samples(least_degree=1))
def test_decoupled_pencil_spans_the_whole_space(sample: Sample):
    """sum A_j C2 N^(q-j) = 0 for the full infinite pair, and finite and infinite columns together are a basis."""
    form = sample.pairs.form
    A, C2, N = form.companion.coefficients, form.C2.data, form.nilpotent.data
    terms = [A[j] @ C2 @ np.linalg.matrix_power(N, len(A) - 1 - j) for j in range(len(A))]
    size = np.abs(A).max() * np.abs(form.infinite_columns.data).max(initial=0.0)
    assert np.abs(sum(terms)).max(initial=0.0) <= BAR * size
    assert np.linalg.matrix_rank(np.hstack([form.finite_columns, form.infinite_columns.data])) == sample.size * sample.degree


def observability(sample: Sample) -> np.ndarray:
    """col(C, CJ, ..., CJ^(q-1))."""
    C, J = sample.pairs.finite.C, sample.pairs.finite.J
    return np.vstack([C @ np.linalg.matrix_power(J, k) for k in range(sample.degree)])


def reachability(sample: Sample) -> np.ndarray:
    """[J^(q-1) B, ..., J B, B]."""
    B, J = sample.pairs.finite.B, sample.pairs.finite.J
    return np.hstack([np.linalg.matrix_power(J, k) @ B for k in reversed(range(sample.degree))])


def upper_values(sample: Sample) -> np.ndarray:
    """M1, block (a, c) = A_(q-a+c) for a >= c."""
    q, A = sample.degree, sample.coefficients
    return np.block([[A[q - a + c] if a >= c else np.zeros_like(A[0]) for c in range(q)] for a in range(q)])


def lower_values(sample: Sample) -> np.ndarray:
    """M0, block (a, c) = A_(c-a) for c >= a."""
    q, A = sample.degree, sample.coefficients
    return np.block([[A[c - a] if c >= a else np.zeros_like(A[0]) for c in range(q)] for a in range(q)])


def projector(sample: Sample) -> np.ndarray:
    """P with stack(0+) = P stack(0-) for a free system."""
    return observability(sample) @ reachability(sample) @ upper_values(sample)
