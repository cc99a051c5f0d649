"""What the error estimate of the numeric engine says, held against proved errors.

The estimate is that of data known to a rounding: where an answer depends on them more than its own rounding, as with clusters of
zeros, it may be far above the error of this one answer. It must not be below it.
"""

import numpy as np
import pytest

from tests.exact.enclosure.random_systems import KINDS, random_problem

EPS = np.finfo(float).eps


@pytest.mark.parametrize("seed", range(1000, 1000 + 5 * len(KINDS)))
def test_no_estimate_is_below_a_tenth_of_the_proved_error(seed):
    x, times, kind = random_problem(seed)
    values, box = x(times), x.enclose(times)
    assert not box.notices, kind
    error = box.error_bounds(values).max() / np.abs(values).max()
    assert x.error_estimate(times) >= 0.1 * error - 8 * EPS
    assert error < 1e-9  # and the answer is right


@pytest.mark.parametrize("seed", range(2000, 2000 + 2 * len(KINDS)))
@pytest.mark.parametrize("order", [1, 2])
def test_nor_that_of_a_derivative(seed, order):
    x, times, _ = random_problem(seed)
    values, box = x.derivative(order)(times), x.enclose(times, order=order)
    error = box.error_bounds(values).max() / np.abs(values).max()
    assert x.error_estimate(times, order=order) >= 0.1 * error - 8 * EPS
