"""Expressions of parameters, against Python's own arithmetic, and the refusal of everything else."""

from contextlib import suppress
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mbconstrained.ground.errors import InputError
from mbconstrained.scene.quantities.parameters import LONGEST_EXPRESSION, read_expression

NAMES = {"k": Fraction(2), "m": Fraction(-3, 7), "ω1": Fraction(5)}


def value(text, names=NAMES):
    return read_expression(text).value(Fraction, names)


atoms = st.sampled_from(["k", "m", "ω1", "2", "0.5", "3e2", ".25"])


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
        r"(?<![\w.])(\d*\.?\d+(?:e\d+)?)(?![\w.])", r"Fraction('\1')", re.sub(r"\^(-?\d+)", lambda p: f"**({p[1]})", text)
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


@pytest.mark.parametrize("name", ["lambda", "if", "µ", "n0"])
def test_a_parameter_may_have_any_name(name):
    assert value(f"2*{name} + k", {**NAMES, name: Fraction(3)}) == 8


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "which cannot be read; an expression has numbers, names, + - * / ^ and parentheses"),
        *((text, "which cannot be read") for text in ("k +", "(k", "k)", "2 k", "k if m", "5k", "0777")),
        *((f"k^{exponent}", "expected a whole number up to 20 behind ^") for exponent in ("m", "2.5", "99", "2^2")),
        *((text, "with something else in it") for text in ("k.real", "sqrt(k)", "k//2")),
        ("__import__('os')", 'with "_" in it'),
        ("k; m", 'with ";" in it'),
        ("k\n#", 'with "#" in it'),
        ("1_000", 'with "1_000" in it'),
        ("1j", 'with "1j" in it'),
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
