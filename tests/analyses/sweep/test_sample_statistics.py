"""Statistics of samples against closed forms."""

import numpy as np
import pytest
import scipy.stats
from scipy.stats import qmc

from mbconstrained.analyses.sweep.samples import exceedance, quantile, rank_correlations, sobol_indices, summary


def test_moments_of_known_numbers():
    own = summary(np.array([1.0, 2.0, 3.0, 4.0]))
    assert (own.count, own.infinite, own.mean, own.least, own.largest) == (4, 0, 2.5, 1.0, 4.0)
    assert own.deviation == pytest.approx(np.sqrt(5 / 3))


def test_samples_without_an_answer_do_not_count_and_infinite_ones_do():
    own = summary(np.array([1.0, np.nan, 3.0, np.inf]))
    assert (own.count, own.infinite, own.mean) == (2, 1, 2.0)


def test_an_interval_of_a_quantile_contains_it_as_often_as_it_states():
    """Of 400 medians of 50 normal numbers the interval of 95 % contains 0 in 91 % or more; binomial intervals are conservative."""
    random = np.random.default_rng(0)
    hits = [estimate.low <= 0.0 <= estimate.high for estimate in (quantile(random.normal(size=50), 0.5) for _ in range(400))]
    assert np.mean(hits) >= 0.91


def test_the_interval_of_a_probability_is_that_of_clopper_and_pearson():
    values = np.arange(100.0)
    own = exceedance(values, 94.5)
    expected = scipy.stats.binomtest(5, 100).proportion_ci(0.95, method="exact")
    assert own.value == 0.05
    assert (own.low, own.high) == pytest.approx((expected.low, expected.high))
    none = exceedance(values, 1e9)
    assert none.value == none.low == 0.0 and 0 < none.high < 0.05


@pytest.mark.long
def test_sobol_indices_of_a_sum_are_the_shares_of_its_variance():
    """y = 3 a + b with independent uniform numbers: 9/10 and 1/10; no interaction."""
    n, d = 4096, 2
    both = qmc.Sobol(2 * d, seed=0).random(n)
    A, B = both[:, :d], both[:, d:]
    points = np.vstack([A, B, *(np.where(np.arange(d) == i, B, A) for i in range(d))])
    own = sobol_indices(points @ [3.0, 1.0], n)
    for first, total, share in zip(own.first, own.total, (0.9, 0.1)):
        assert first.value == pytest.approx(share, abs=0.01)
        assert total.value == pytest.approx(share, abs=0.01)


def test_rank_correlations_are_those_of_spearman():
    random = np.random.default_rng(1)
    x, y = random.normal(size=(2, 80))
    assert rank_correlations([x, y], np.exp(x)) == pytest.approx([1.0, scipy.stats.spearmanr(y, np.exp(x)).statistic])
