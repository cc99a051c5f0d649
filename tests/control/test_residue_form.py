"""The formulas of Hauksdottir and Sigurdsson, as corrected, against exact rational arithmetic and a matrix exponential."""

from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from tests.oracles.transfer import descending, factors, multiplied, residues

#: Poles, well apart: what partial fractions lose where they are close is not the matter here.
places = [Fraction(-1), Fraction(-2), Fraction(1, 2), (Fraction(-1), Fraction(1)), (Fraction(1, 4), Fraction(2))]
poles = st.lists(st.sampled_from(places), min_size=1, max_size=4)
numerators = st.lists(st.integers(-5, 5), min_size=1, max_size=7).filter(lambda b: b[-1] != 0)
orders = st.integers(-7, 5)
TIMES = np.array([0.5, 1.0, 3.0])


def respond(b, a, gamma=1):
    return mb.transfer_function_response(b[::-1], a[::-1], gamma)


def ascending(b, a, count):
    """Taylor coefficients of b/a at s = 0."""
    found = []
    for k in range(count):
        known = sum(a[i] * found[k - i] for i in range(1, min(k, len(a) - 1) + 1))
        found.append((Fraction(b[k] if k < len(b) else 0) - known) / a[0])
    return found


@given(poles, numerators, orders, st.integers(0, 2))
def test_theorem_2_against_exact_arithmetic(poles, b, gamma, n0):
    """Eq. (31): its sums are the Taylor coefficients of b/a at 0 and its polynomial part, exactly; the rest are modes."""
    a = multiplied(*factors(poles))
    y = respond(b, [Fraction(0)] * n0 + a, gamma).residue_form.general_response(gamma)
    g = gamma + n0
    forced, exact = ascending(b, a, max(g, 0))[::-1], descending(b, a, g, 60)
    assert y.forced == pytest.approx([float(c) for c in forced], rel=1e-9, abs=1e-9)
    assert y.impulses == pytest.approx([float(exact.get(k, 0)) for k in range(max(len(b) - len(a) - g + 1, 0))], rel=1e-9, abs=1e-9)
    values = [residues(b, [*poles, *[Fraction(0)] * n0], gamma, t) for t in TIMES]
    assert y(TIMES) == pytest.approx(values, rel=1e-8, abs=1e-8)


@given(poles, orders)
def test_at_most_one_sum_of_theorem_1_is_there(poles, gamma):
    a = multiplied(*factors(poles))
    y = respond([1], a).residue_form.basic_response(gamma)
    assert len(y.forced) == max(gamma, 0)
    assert len(y.impulses) == max(-gamma - (len(a) - 1) + 1, 0)
    assert y(TIMES) == pytest.approx([residues([1], poles, gamma, t) for t in TIMES], rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("poles", [places, [Fraction(-1)] * 3 + [Fraction(-3)], [(Fraction(-1), Fraction(1))] * 2])
def test_fundamental_solution_its_derivatives_and_integrals(poles):
    """(12), (13), (26), (36), (43), (44): y_f^(j)' = y_f^(j+1) for every j, also below zero."""
    a = multiplied(*factors(poles))
    form, n = respond([1], a).residue_form, len(a) - 1
    assert form.order == n and form.J.shape == (n, n)
    assert [float(form.fundamental_solution(0.0, k)) for k in range(n)] == pytest.approx([0.0] * (n - 1) + [1.0], abs=1e-12)
    assert form.at_zero(0, n).tolist() == [0.0] * (n - 1) + [1.0]
    step = 1e-5
    for j in range(-3, 3):
        slope = (form.fundamental_solution(1.0 + step, j) - form.fundamental_solution(1.0 - step, j)) / (2 * step)
        assert form.fundamental_solution(1.0, j + 1) == pytest.approx(slope, rel=1e-6, abs=1e-8)
    for s in (1.7, 0.3 + 2j):
        resolvent = np.linalg.solve(s * np.eye(n) - form.J.T, form.exponentials(0.0))  # the transform of E(t)
        assert form.kappa @ resolvent == pytest.approx(1 / np.polyval([float(c) for c in a[::-1]], s), rel=1e-12)
    E, later = form.exponentials(np.array([0.0, 1.0])).T
    assert scipy.linalg.expm(form.J.T) @ E == pytest.approx(later, rel=1e-12)


@pytest.mark.parametrize("poles", [places, [Fraction(-1)] * 2 + [Fraction(-3)]])
def test_the_rows_of_eq_45_go_up_and_down(poles):
    form = respond([1], multiplied(*factors(poles))).residue_form
    rows = form.rows(-4, 7)
    assert rows[4] == pytest.approx(form.kappa)
    assert rows[:-1] @ form.J.T == pytest.approx(rows[1:], rel=1e-10)
    for k in range(7):
        assert form.fundamental_solution(0.7, k - 4) == pytest.approx((rows[k] @ form.exponentials(0.7)).real, rel=1e-10)


def test_the_matrices_of_eqs_49_and_50():
    """(50) has a one in the bottom left corner; it is printed as 0."""
    b, a = [1, 2, 3, 4, 5, 6], [Fraction(c) for c in (2, 3, 1)]
    form = respond(b, a).residue_form
    forced, noncausal = form.forced_matrix(3), form.noncausal_matrix(-1)
    assert forced.shape == (3, 3) and forced[1:, 2].tolist() == [0.0, 0.0]
    assert -np.array(b[:3]) @ forced == pytest.approx([float(c) for c in ascending(b, a, 3)[::-1]])
    assert noncausal.shape == (5, 5) and noncausal[-1, 0] == 1.0 and noncausal[0, :4].tolist() == [0.0] * 4
    exact = descending(b, a, -1, 5)
    assert np.array(b[1:]) @ noncausal == pytest.approx([float(exact[k]) for k in range(4, -1, -1)])


def test_impulse_step_and_ramp_as_printed():
    """Eqs. (51)-(53), m < n."""
    b, a = [3.0, 1.0, 2.0], [Fraction(c) for c in (4, 8, 5, 1)]
    form = respond(b, a).residue_form
    E, E0, t = form.exponentials(1.5), form.exponentials(0.0), 1.5
    K = {j: form.rows(j, 1)[0] for j in range(-2, 3)}
    impulse = sum(b[l] * K[l] for l in range(3)) @ E
    step = sum(b[l] * K[l - 1] for l in (1, 2)) @ E + b[0] * K[-1] @ (E - E0)
    ramp = b[2] * K[0] @ E + (b[0] * K[-2] + b[1] * K[-1]) @ (E - E0) - b[0] * K[-1] @ E0 * t
    for gamma, value in ((0, impulse), (1, step), (2, ramp)):
        assert value.imag == pytest.approx(0.0, abs=1e-14)
        assert respond(b, a, gamma)(t)[0] == pytest.approx(value.real, rel=1e-12)


@pytest.mark.parametrize("gamma", [1, 2, 4])
def test_modes_and_an_augmented_matrix_exponential_agree(gamma):
    """a(s) s^gamma as one companion matrix: nothing is decoupled."""
    b, a = [2, 0, 1], [Fraction(c) for c in (3, 5, 4, 1)]
    whole = [0.0] * gamma + [float(c) for c in a]
    n = len(whole) - 1
    companion = np.eye(n, k=1)
    companion[-1] = -np.array(whole[:-1])
    row = np.zeros(n)
    row[: len(b)] = b
    for t in (0.5, 2.0, 10.0):
        value = row @ scipy.linalg.expm(companion * t)[:, -1]
        assert respond(b, a, gamma)(t)[0] == pytest.approx(value, rel=1e-11)
        assert respond(b, a).residue_form.general_response(gamma)(t) == pytest.approx(value, rel=1e-10)


def test_only_zero_poles_and_no_poles():
    """Eq. (35)."""
    form = mb.transfer_function_response([1, 2, 3], [4, 0]).residue_form
    assert form.order == 0 and form.zero_poles == 1 and form.kappa.shape == (0,)
    y = form.general_response(1)  # (s^2 + 2 s + 3) / (4 s^2)
    assert y.forced.tolist() == [0.5, 0.75] and y.impulses.tolist() == [0.25] and y(2.0) == 2.0
    assert mb.transfer_function_response([5], [2]).residue_form.general_response(0).impulses.tolist() == [2.5]


def test_gamma_is_a_whole_number():
    with pytest.raises(mb.InputError, match="gamma: found 0.5"):
        mb.transfer_function_response([1], [1, 1]).residue_form.general_response(0.5)
