"""Elementary divisors of random A(s) against ranks in rational arithmetic."""

from __future__ import annotations

import numpy as np
from hypothesis import given

import mbconstrained as mb
from tests.oracles.smith import partial_multiplicities
from tests.properties.matrices import Sample, samples


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
