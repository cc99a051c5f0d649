"""Samples of parameters against SciPy's distributions; what cannot be sampled is a message."""

import numpy as np
import pytest
import scipy.stats

import mbconstrained as mb
from mbconstrained.analyses.sweep.samples import ParameterSamples
from mbconstrained.scene.schema.analysis_tables import VaryTable
from mbconstrained.scene.variations import variation_of


def samples(parameters: dict, **options) -> ParameterSamples:
    return ParameterSamples({name: variation_of(given) for name, given in parameters.items()}, VaryTable(**options))


def test_a_grid_combines_all_values():
    own = samples({"k": "1..3 N/mm:3", "n": [2, 5]})
    assert len(own) == 6 and own.shape == (3, 2, 1)
    assert own.column("k").tolist() == [1000.0, 1000.0, 2000.0, 2000.0, 3000.0, 3000.0]
    assert own.column("n").tolist() == [2, 5] * 3
    assert own.rows(slice(1, 2)) == [{"k": 1000.0, "n": 5}]


@pytest.mark.parametrize("method", ["random", "latin hypercube", "sobol"])
@pytest.mark.parametrize(
    ("text", "distribution"),
    [
        ("normal(10 kg, 2 %)", scipy.stats.norm(10, 0.2)),
        ("uniform(1 kg, 3 kg)", scipy.stats.uniform(1, 2)),
        ("lognormal(10 kg, 2 %)", scipy.stats.lognorm(np.sqrt(np.log1p(4e-4)), scale=10 / np.sqrt(1 + 4e-4))),
    ],
)
def test_distributions_are_those_of_scipy(method, text, distribution):
    """Kolmogorov and Smirnov's test of 1024 points; the same seed gives the same points."""
    own = samples({"m": text}, method=method, samples=1024, seed=3).column("m")
    assert scipy.stats.kstest(own, distribution.cdf).pvalue > 1e-3
    assert np.array_equal(own, samples({"m": text}, method=method, samples=1024, seed=3).column("m"))
    assert not np.array_equal(own, samples({"m": text}, method=method, samples=1024, seed=4).column("m"))


def test_correlated_normal_parameters_have_their_correlation():
    own = samples(
        {"a": "normal(1, 0.1)", "b": "normal(2 kg, 0.3 kg)"}, method="latin hypercube", samples=4096, correlation=[["a", "b", -0.7]]
    )
    assert np.corrcoef(own.column("a"), own.column("b"))[0, 1] == pytest.approx(-0.7, abs=0.03)
    assert own.column("b").std() == pytest.approx(0.3, rel=0.03)


def test_one_at_a_time_moves_each_parameter_to_its_ends():
    own = samples({"a": "1..3:3", "b": "10..20:2"}, method="one at a time")
    assert list(zip(own.column("a").tolist(), own.column("b").tolist())) == [(2, 20), (1, 20), (3, 20), (2, 10), (2, 20)]


@pytest.mark.parametrize(
    ("parameters", "options", "message"),
    [
        ({}, {}, "no parameter is varied"),
        ({"a": "normal(1, 0.1)"}, {"method": "sobol", "samples": 1000}, "give 1024 or 512"),
        ({"a": "normal(1, 0.1)", "b": [1, 2]}, {"method": "saltelli", "samples": 8}, "b has given values"),
        ({"a": [1, 2]}, {"method": "sobol", "samples": 8}, "only given values are varied"),
        ({"a": "normal(1, 0.1)"}, {"correlation": [["a", "c", 0.5]]}, '"c" is no varied parameter'),
        (
            dict.fromkeys("abc", "normal(1, 0.1)"),
            {"correlation": [["a", "b", 0.9], ["b", "c", 0.9], ["a", "c", -0.9]]},
            "not positive definite",
        ),
    ],
)
def test_what_cannot_be_sampled_is_a_message(parameters, options, message):
    with pytest.raises(mb.InputError, match=message):
        samples(parameters, **options).rows(slice(None))


@pytest.mark.parametrize(
    "text",
    [
        "normal(10 kg, 0)",
        "normal(10 kg, -1 kg)",
        "3..1 N/mm:5",
        "1..3 N/mm:0",
        "",
        "uniform(2, 1)",
        "normal(1 kg, 2 m)",
        "1..x:3",
        [],
    ],
)
def test_wrong_variations_are_messages(text):
    with pytest.raises(mb.InputError):
        variation_of(text)
