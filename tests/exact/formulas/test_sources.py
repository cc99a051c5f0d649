"""The sources in Python and C: they run, they compute what the numeric engine computes, and they are clean."""

import keyword
import shutil

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.exact.closed_form import ClosedForm, Impulse
from mbconstrained.exact.source_code import C_KEYWORDS, c_source, identifiers, python_source, real_form, with_square
from tests.exact.formulas.answers import HOSTILE, c_values, damped, hostile, python_values, t, with_values

TIMES = np.linspace(0.01, 20, 50)
needs_gcc = pytest.mark.skipif(shutil.which("gcc") is None, reason="there is no C compiler")
REGIMES = {"oscillates": 0.5, "creeps": 30.0, "creeps slowly": 3000.0}


def numeric(c: float) -> np.ndarray:
    return mb.solve(mb.PolynomialMatrix([[[3.0]], [[c]], [[2.0]]]), [[1.0], [0.0]])(TIMES)


@pytest.mark.parametrize("c", REGIMES.values(), ids=REGIMES)
def test_python_computes_what_is_solved(c):
    form = real_form(damped(m=2.0, k=3.0, c=c))
    assert np.abs(python_values(form, TIMES) - numeric(c)).max() <= 1e-12
    assert len(form.positive) == 1


@needs_gcc
@pytest.mark.parametrize("c", REGIMES.values(), ids=REGIMES)
def test_c_computes_what_is_solved(c, tmp_path):
    assert np.abs(c_values(real_form(damped(m=2.0, k=3.0, c=c)), TIMES, tmp_path) - numeric(c)).max() <= 1e-12


def test_two_exponentials_do_not_overflow():
    form = real_form(damped(m=2.0, k=3.0, c=3000.0))
    values = python_values(form, np.array([1e6]))
    known = mb.solve(mb.PolynomialMatrix([[[3.0]], [[3000.0]], [[2.0]]]), [[1.0], [0.0]])(np.array([1e6]))
    assert np.isfinite(values).all() and values == pytest.approx(known, abs=1e-300)


def test_parameters_are_arguments_with_default_values():
    form = damped(m=2.0, k=3.0, c=0.5)
    other = mb.solve(mb.PolynomialMatrix([[[5.0]], [[0.25]], [[1.0]]]), [[1.0], [0.0]])(TIMES)
    assert "def x(t, m=2.0, k=3.0, c=0.5):" in python_source(form)
    assert np.abs(python_values(form, TIMES, 1.0, 5.0, 0.25) - other).max() <= 1e-12


def test_hostile_names_are_only_names(tmp_path):
    times = np.array([0.5, 2.0])
    known = np.array([(number + 2) * times + number for number in range(len(HOSTILE))])
    assert python_values(hostile(), times) == pytest.approx(known)
    if shutil.which("gcc"):
        assert c_values(hostile(), times, tmp_path) == pytest.approx(known)


def test_steps_begin_at_their_times(tmp_path):
    form = ClosedForm(("x",), (t * sympy.Heaviside(t - 2),), t)
    times = np.array([1.0, 2.0, 3.0])
    assert python_values(form, times).tolist() == [[0.0, 2.0, 3.0]]
    if shutil.which("gcc"):
        assert c_values(form, times, tmp_path).tolist() == [[0.0, 2.0, 3.0]]


@needs_gcc
@pytest.mark.parametrize("standard", ["c99", "gnu99"])
def test_c_compiles_whatever_the_headers_define(standard, tmp_path):
    names = ("M_E", "M_PI", "NAN", "INFINITY", "HUGE_VAL", "linux", "unix", "FP_NAN", "OVERFLOW", "DOMAIN")
    symbols = [sympy.Symbol(name, positive=True) for name in names]
    value = sympy.sqrt(2) * sympy.exp(t) * sympy.log(2) / sympy.pi + sum(symbols)
    form = with_values(ClosedForm(("x",), (value,), t), dict.fromkeys(symbols, 2))
    assert "M_SQRT2" not in c_source(form)
    known = np.sqrt(2) * np.exp(TIMES) * np.log(2) / np.pi + 2 * len(names)
    assert c_values(form, TIMES, tmp_path, standard)[0] == pytest.approx(known, rel=1e-14)


def test_divisors_keep_their_digits_near_resonance():
    k, m, c, w = sympy.symbols("k m c w", positive=True)
    divisor = k**2 - 2 * k * m * w**2 + m**2 * w**4 + c**2 * w**2
    form = with_values(ClosedForm(("x",), (1 / divisor,), t), {k: 3, m: 3, c: 1e-9, w: 1})
    assert python_values(form, 1.0) == pytest.approx([1e18], rel=1e-14)
    assert with_square(divisor).expand() == divisor


def test_impulses_are_told_and_not_in_the_values():
    form = ClosedForm(("x",), (t,), t, impulses=(Impulse("x", 1, sympy.Rational(-1, 2)),))
    for source in (python_source(form), c_source(form)):
        assert "x has the impulse -1/2 δ′(t), which is not in the values" in source
        assert "Dirac" not in source


@given(st.lists(st.text(max_size=8), max_size=12, unique=True))
def test_identifiers_are_valid_and_distinct(names):
    found = list(identifiers(names).values())
    assert len(set(found)) == len(names)
    for name in found:
        assert (
            name.isidentifier()
            and name.isascii()
            and not keyword.iskeyword(name)
            and name not in C_KEYWORDS | {"t", "x", "np", "values"}
        )
