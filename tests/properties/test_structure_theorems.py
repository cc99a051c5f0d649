"""Degrees, multiplicities and elementary divisors of random A(s) with known zeros, against rational arithmetic."""

from __future__ import annotations

import numpy as np
from hypothesis import given

import mbconstrained as mb
from tests.oracles import exact
from tests.oracles.smith import partial_multiplicities
from tests.properties.matrices import Sample, samples


@given(samples())
def test_n_is_the_degree_of_the_determinant(sample: Sample):
    assert len(exact.determinant(sample.exact)) - 1 == sample.finite_count  # the generator is right
    assert sample.matrix.structure().finite_count == sample.finite_count
    assert len(sample.pairs.finite.J) == sample.finite_count


@given(samples())
def test_orders_at_infinity_are_those_of_the_minors(sample: Sample):
    """q_1 + ... + q_i is the highest degree of an i x i minor."""
    assert list(sample.matrix.structure().at_infinity) == sample.orders_at_infinity


@given(samples())
def test_finite_and_infinite_zeros_add_up_to_r_q(sample: Sample):
    structure = sample.matrix.structure()
    assert structure.finite_count + sum(structure.infinite_divisors) == sample.size * sample.degree
    assert sum(zero.count for zero in structure.finite_zeros) == structure.finite_count
    assert list(structure.infinite_divisors) == sorted(structure.infinite_divisors)


@given(samples())
def test_zeros_have_their_values_and_multiplicities(sample: Sample):
    zeros = sample.matrix.structure().finite_zeros
    known = {value: count for value, count in sample.zeros.items() if value.imag >= 0}
    assert len(zeros) == len(known)
    for value, count in known.items():
        nearest = min(zeros, key=lambda zero: abs(zero.value - value))
        assert nearest.multiplicity == count
        assert abs(nearest.value - value) <= (1e-7 if count == 1 else 1e-4)
        assert (nearest.value == 0) == (value == 0)


@given(samples())
def test_pairs_have_the_sizes_of_the_theorem(sample: Sample):
    """J_inf has the size sum of |q_i| + 1 over q_i <= 0, is strictly upper triangular, and J_inf^(qh+1) = 0."""
    J, highest = sample.pairs.infinite.J, sample.highest_impulse
    expected = sum(1 - order for order in sample.orders_at_infinity if order <= 0)
    assert J.shape == (expected, expected)
    assert sample.matrix.structure().highest_impulse == highest
    assert not np.tril(J).any()
    size = np.abs(J).sum(axis=1).max(initial=0.0) ** (highest + 1)
    assert np.abs(np.linalg.matrix_power(J, highest + 1)).max(initial=0.0) <= 1e-10 * size


@given(samples())
def test_declared_degree_only_adds_infinite_divisors(sample: Sample):
    """One more zero coefficient: every infinite elementary divisor grows by one, q_i and the zeros stay."""
    more = np.concatenate([sample.coefficients, np.zeros((1, sample.size, sample.size))])
    structure, raised = sample.matrix.structure(), mb.PolynomialMatrix(more).structure()
    assert raised.at_infinity == structure.at_infinity
    assert [d - 1 for d in raised.infinite_divisors] == list(structure.infinite_divisors)
    assert sorted(z.count for z in raised.finite_zeros) == sorted(z.count for z in structure.finite_zeros)


# Elementary divisors.


def divisors(structure) -> list[tuple[complex, tuple[int, ...]]]:
    return [(zero.value, zero.partial_multiplicities) for zero in structure.finite_zeros]


@given(samples())
def test_partial_multiplicities_are_those_of_the_exact_smith_form(sample: Sample):
    zeros = sample.matrix.structure().finite_zeros
    for value, multiplicity in sample.zeros.items():
        if value.imag >= 0:
            nearest = min(zeros, key=lambda zero: abs(zero.value - value))
            assert list(nearest.partial_multiplicities) == partial_multiplicities(sample.exact, value, multiplicity)
            assert nearest.clear


@given(samples(over_declared=False))
def test_the_dual_has_at_zero_what_the_matrix_has_at_infinity(sample: Sample):
    """And the other way round, degree by degree."""
    structure, dual = sample.matrix.structure(), sample.matrix.dual.structure()
    for one, other in ((structure, dual), (dual, structure)):
        at_zero = [degree for value, degrees in divisors(one) if value == 0 for degree in degrees]
        assert at_zero == [degree for degree in other.infinite_divisors if degree]
    assert np.array_equal(sample.matrix.dual.dual.coefficients, sample.coefficients)


@given(samples())
def test_the_transpose_has_the_same_divisors(sample: Sample):
    transposed = mb.PolynomialMatrix(sample.coefficients.transpose(0, 2, 1)).structure()
    for (value, degrees), (other, others) in zip(divisors(sample.matrix.structure()), divisors(transposed), strict=True):
        assert abs(value - other) <= 1e-4 * abs(value)
        assert degrees == others


@given(samples(largest_size=2))
def test_a_twin_doubles_every_divisor(sample: Sample):
    """diag(A, A)."""
    twins = mb.PolynomialMatrix([np.kron(np.eye(2), matrix) for matrix in sample.coefficients]).structure()
    for (_, degrees), (_, doubled) in zip(divisors(sample.matrix.structure()), divisors(twins), strict=True):
        assert doubled == tuple(sorted(2 * degrees))
