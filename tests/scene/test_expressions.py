"""Expressions of parameters, against Python's own arithmetic, and the refusal of everything else."""

from contextlib import suppress
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.ground.errors import InputError
from mbconstrained.scene.parameters import LONGEST_EXPRESSION, read_expression

NAMES = {"k": Fraction(2), "m": Fraction(-3, 7), "ω1": Fraction(5)}


def value(text, names=NAMES):
    return read_expression(text).value(Fraction, names)


atoms = st.sampled_from(["k", "m", "ω1", "2", "0.5", "3e2", ".25", "5e-1"])


def joined(inner):
    binary = st.tuples(inner, st.sampled_from([" + ", "-", "*", " / "]), inner).map("".join)
    return st.one_of(
        inner.map("({})".format),
        inner.map("-({})".format),
        binary,
        st.tuples(atoms, st.integers(-3, 3)).map(lambda p: f"{p[0]}^{p[1]}"),
    )


@given(st.recursive(atoms, joined, max_leaves=8).filter(lambda text: len(text) <= LONGEST_EXPRESSION))
def test_the_value_is_that_of_python(text):
    """Our own texts, made of what the grammar has; Python reads ^ as ** and numbers as Fractions."""
    import re

    python = re.sub(
        r"(?<![\w.])(\d*\.?\d+(?:e-?\d+)?)(?![\w.])", r"Fraction('\1')", re.sub(r"\^(-?\d+)", lambda p: f"**({p[1]})", text)
    )
    python = re.sub(
        r"\*\*\(Fraction\('(\d+)'\)\)|\*\*\(-Fraction\('(\d+)'\)\)", lambda p: f"**{p[1]}" if p[1] else f"**-{p[2]}", python
    )
    try:
        known = eval(python, {"Fraction": Fraction}, dict(NAMES))
    except ZeroDivisionError:
        with pytest.raises(ZeroDivisionError):
            value(text)
        return
    assert value(text) == known


@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("-2*k^2", -8),
        ("2^-1", Fraction(1, 2)),
        ("--k", 2),
        ("8/2/2", 2),
        ("8-2-2", 4),
        ("k*-m", Fraction(6, 7)),
        ("+k", 2),
        ("2 * ( k+1 )", 6),
    ],
)
def test_signs_and_the_order_of_operations(text, known):
    assert value(text) == known


@pytest.mark.parametrize(
    ("text", "known"),
    [
        ("3 N/mm", 3000),
        ("2*k*1.5 kN", 6000),
        ("1_000.5 mm + k", Fraction("3.0005")),
        ("100 N / 2 mm", 50000),  # each number has its own unit
        ("5 N/mm*k", 10000),  # k is no unit
        ("5 N/mm/k", 2500),
        ("2 kg m^2/k", 1),
        ("-3 mm^2", Fraction("-0.000003")),
        ("2 m^-1*k", 4),
        ("1e3 g", 1),
        ("2 s^2", 2),
        ("2*1 m/(4 s)*k", 1),
    ],
)
def test_numbers_may_have_units(text, known):
    """Hand: the sizes of the units in SI."""
    assert value(text, {"k": Fraction(2)}) == known


@pytest.mark.parametrize(("text", "other"), [("2 k m", "2*m"), ("2 m", "2*m"), ("5 kg*m", "(5 kg)*m"), ("5 N/m", "(5 N)/m")])
def test_a_unit_that_is_also_a_parameter_is_ambiguous(text, other):
    with pytest.raises(InputError) as problem:
        read_expression(text, ("m",))
    assert ("there is no unit" if " k " in text else f'"m" may be the unit or the parameter: write "{other}"') in str(problem.value)


@pytest.mark.parametrize("name", ["lambda", "if", "µ", "n0"])
def test_a_parameter_may_have_any_name(name):
    assert value(f"2*{name} + k", {**NAMES, name: Fraction(3)}) == 8


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "which cannot be read; an expression has numbers, perhaps with units, names, + - * / ^ and parentheses"),
        *((text, "which cannot be read") for text in ("k +", "(k", "k)", "k if m", "0777")),
        *((text, f'there is no unit "k": for a product write "{text[0]}*k"') for text in ("2 k", "5k", "2 k*m")),
        *((f"k^{exponent}", "expected a whole number up to 20 behind ^") for exponent in ("m", "2.5", "99", "2^2")),
        *((text, "with something else in it") for text in ("k.real", "k//2", "k(2)(m)")),
        ("sqrt(k)", "with the function sqrt(…) in it"),
        ("3 N/mm + k 2", "which cannot be read"),
        ("2 kg*m*", "which cannot be read"),
        ("__import__('os')", 'with "_" in it'),
        ("k; m", 'with ";" in it'),
        ("k\n#", 'with "#" in it'),
        ("1__000", "which cannot be read"),
        ("1j", 'there is no unit "j"'),
        ("²", 'with "²" in it'),
        ("k+" * 200 + "k", "found an expression of 401 characters"),
    ],
)
def test_other_texts_are_refused(text, says):
    with pytest.raises(InputError) as problem:
        read_expression(text)
    assert says in str(problem.value)


@pytest.mark.long
@given(st.text(max_size=60))
def test_any_text_is_read_or_refused(text):
    with suppress(InputError):
        read_expression(text)
