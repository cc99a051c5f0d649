"""Degrees and multiplicities of random A(s) with known zeros, against determinants and minors in rational arithmetic."""

from __future__ import annotations

import numpy as np
from hypothesis import given

import mbconstrained as mb
from tests.oracles import exact
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


@given(samples(over_declared=False))
def test_dual_exchanges_zero_and_infinity(sample: Sample):
    """The zero at 0 of s^q A(1/s) has the multiplicity of the infinite elementary divisors of A, and the other way round."""
    structure, dual = sample.matrix.structure(), sample.matrix.dual.structure()
    assert _at_origin(dual) == sum(structure.infinite_divisors)
    assert sum(dual.infinite_divisors) == _at_origin(structure) == sample.zeros[0]
    assert np.array_equal(sample.matrix.dual.dual.coefficients, sample.coefficients)


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


def _at_origin(structure) -> int:
    return sum(zero.multiplicity for zero in structure.finite_zeros if zero.value == 0)
