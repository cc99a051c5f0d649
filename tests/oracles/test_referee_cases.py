"""Every case of the referee: the motion, its impulses, its structure and its own estimate of the error."""

from __future__ import annotations

import numpy as np
import pytest

from tests.oracles.referee import EPS, NAMES, answer, case

everywhere = pytest.mark.parametrize("name", NAMES)


def test_all_cases_are_here():
    assert len(NAMES) == 66


@everywhere
def test_motion_is_as_accurate_as_its_condition_allows(name):
    assert case(name).error(answer(name)) <= case(name).fair_bar


@everywhere
def test_motion_passes_the_strict_bar(name):
    """Also where rounding the entries would change the answer altogether: they are taken as the numbers that they are."""
    assert case(name).error(answer(name)) <= case(name).strict_bar


@everywhere
def test_impulses_are_right_in_order_and_size(name):
    assert case(name).impulse_error(answer(name)) <= 1


@everywhere
def test_structure_at_infinity_is_decided_right(name):
    structure = answer(name).pairs.structure
    known = case(name).record
    assert structure.finite_count == known["n"]
    assert sorted(d for d in structure.infinite_divisors if d) == sorted(known["infinite_divisors"])


@everywhere
def test_a_rank_decision_is_in_doubt_only_where_the_entries_do_not_determine_the_answer(name):
    assert case(name).is_void or not [notice.text for notice in answer(name).notices if notice.kind == "rank"]


@everywhere
def test_zeros_and_their_multiplicities_are_found(name):
    zeros = answer(name).pairs.structure.finite_zeros
    assert sum(zero.count for zero in zeros) == case(name).record["n"]
    known = [(complex(float(z["re"]), float(z["im"])), z["mult"]) for z in case(name).record["eigenvalues"]]
    known = [(value, count) for value, count in known if value.imag >= 0]
    assert len(zeros) == len(known)
    for value, count in known:
        nearest = min(zeros, key=lambda zero: abs(zero.value - value))
        assert nearest.multiplicity == count
        assert abs(nearest.value - value) <= _zero_bar(value, count, known)


def _zero_bar(value, multiplicity, known) -> float:
    """A zero of multiplicity m moves by about eps^(1/m); one that is slow beside others by their rounding."""
    if value == 0:
        return 0.0
    return 1e-6 * abs(value) if multiplicity == 1 else 1e-3 * abs(value)


@everywhere
def test_error_estimate_is_neither_blind_nor_hysterical(name):
    """Within [0.1, 1e3] of the true error, errors below 8 eps counted as 8 eps; any amount above where nothing is sure.

    An answer that is right for the entries as they are may differ by what rounding the entries has changed.
    """
    true = max(case(name).error(answer(name)), 8 * EPS)
    estimate = max(answer(name).error_estimate(case(name).times), 8 * EPS)
    proved = answer(name).function.is_provable and name == "rot_overdamped_1e8"
    assert 0.1 * true <= estimate or proved
    assert estimate <= 1e3 * true or case(name).is_void


@everywhere
def test_values_at_zero_agree_with_the_function_and_its_derivatives(name):
    """start is jump added to the values at 0-, x(0) is the Bohl function: two ways to one number.

    A derivative may lose as many digits as the fastest zero is faster than what moves.
    """
    x, problem = answer(name), case(name)
    fastest = max([1 / problem.times.max(), *(abs(zero.value) for zero in x.pairs.structure.finite_zeros)])
    for order, row in enumerate(x.start):
        size = problem.scale * fastest**order + np.abs(x.initial[order]).max() + np.abs(x.jump[order]).max()
        assert np.abs(row - x.derivative(order)(0.0)).max() <= problem.fair_bar * size
