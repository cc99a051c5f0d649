"""Quantities: numbers in SI, texts with units, and everything that only looks like one."""

import math

import pint
import pytest

from mbconstrained.ground.errors import InputError
from mbconstrained.ground.quantities import count_texts, expected, quantity
from mbconstrained.ground.units import AMBIGUOUS, UNITS, instead_of, is_accepted, unit_in_si
from mbconstrained.scene.file import shown

# Definitions: 1 in = 25.4 mm, 1 lbf = 4.4482216152605 N, 1 t = 1000 kg, 1 rev = 2 pi rad.
CONVERSIONS = [
    ("10 kg", "kg", 10.0),
    ("2.5 t", "kg", 2500.0),
    ("3 N/mm", "N/m", 3000.0),
    ("2 kN/mm", "N/m", 2e6),
    ("1 lbf/in", "N/m", 4.4482216152605 / 0.0254),
    ("100 mm", "m", 0.1),
    ("-9.81 m/s^2", "m/s^2", -9.81),
    ("-9.81 m/s²", "m/s^2", -9.81),
    ("-9.81 m/s**2", "m/s^2", -9.81),
    ("30 deg", "rad", math.pi / 6),
    ("30°", "rad", math.pi / 6),
    ("300 rpm", "rad/s", 10 * math.pi),
    ("300 rpm", "Hz", 5.0),  # a turn is a cycle
    ("3 rev/s", "Hz", 3.0),
    ("120 turns/minute", "Hz", 2.0),
    ("1_200 rpm", "Hz", 20.0),
    ("2 Hz", "Hz", 2.0),
    ("4 N s/m", "N*s/m", 4.0),
    ("4 N·s/m", "N*s/m", 4.0),
    ("0.02 kg*m^2", "kg*m^2", 0.02),
    ("20 N*m", "N*m/rad", 20.0),
    ("20 N*m/deg", "N*m/rad", 3600 / math.pi),
    ("50 ms", "s", 0.05),
    ("-0.5 1/s", "1/s", -0.5),
    ("1e3 m", "m", 1000.0),
    ("20 Nm", "N*m", 20.0),
    ("2 kNm/rad", "N*m/rad", 2000.0),
    ("500 Nmm", "N*m", 0.5),
    ("3 Ns", "N*s", 3.0),
    ("3 N*s^2", "N*s^2", 3.0),
    ("300 rev/min", "rad/s", 10 * math.pi),
    ("5 turns/s", "rad/s", 10 * math.pi),
    ("36 km/h", "m/s", 10.0),
    ("0.5 gn", "m/s^2", 4.903325),
    ("0.5 g", "m/s^2", 4.903325),
    ("0.5 g", "kg", 5e-4),
    ("12 millimetres", "m", 0.012),
    ("5 N*m*s/rad", "N*m*s/rad", 5.0),
    ("50 N/µm", "N/m", 5e7),
]


@pytest.mark.parametrize(("text", "unit", "value"), CONVERSIONS)
def test_text_with_a_unit_is_converted_to_si(text, unit, value):
    assert quantity(text, unit) == pytest.approx(value, rel=4e-16)


@pytest.mark.parametrize("value", [0, 3, -2.5, 1e100, -1e-100])
def test_number_is_taken_in_si(value):
    assert quantity(value, "kg") == value


@pytest.mark.parametrize(
    ("value", "unit", "message"),
    [
        ("10 N/mm", "kg", r'found "10 N/mm", a stiffness; expected a mass, e.g. "10 kg", or a number in kg'),
        ("3 Hz", "rad/s", r'an angular frequency is 2 pi times the frequency: write "18.8496 rad/s", or frequency = "3 Hz"$'),
        ("3 rad/s", "Hz", r'divided by 2 pi: write "0.477465 Hz", or angular_frequency = "3 rad/s"$'),
        ("3 rev/s^2", "Hz", r"expected a frequency"),
        ("3 deg/s", "Hz", r"divided by 2 pi"),
        ("0.3 kg", "m/s^2", r'found "0.3 kg", a mass; .*write "0.3 gn"'),
        ("3 kg", "N", r"found .3 kg., a mass; .*the weight of a mass is given in N, lbf or kgf"),
        ("5 Nms", "N*m", r'found "5 Nms", but "Nms" may be read as N\*ms or N\*m\*s; write one of them; expected a torque'),
        ("5 kgm", "kg", r'"kgm" may be read as kg\*m; write it with the \*'),
        ("10 gr", "kg", r'"gr" may be read as a gram, "g", or a grain, "0.0648 g"; write one of them'),
        ("1 ton", "kg", r'"ton" may be read as a tonne, "t" \(1000 kg\), or a short ton, "907.185 kg"'),
        ("2 tons", "kg", r'"tons" may be read as a tonne'),
        ("2 rads", "rad", r'"rads" may be read as radians, "rad", or radian seconds'),
        ("3 PS", "W", r"metric horsepower"),
        ("3 kgs", "kg", r'"kgs" may be read as kg\*s; write it with the \*'),
        ("300 RPM", "rad/s", r'there is no unit "RPM"; did you mean "rpm"\?'),
        ("3 fox", "m", r'there is no unit "fox"'),
        ("2 kg/s^2/m", "m", r"which is another kind of quantity; expected a length"),
        ("10 Kg", "kg", r'there is no unit "Kg"; did you mean "kg"\?'),
        ("10 KN", "N", r'there is no unit "KN"; did you mean "kN"\?'),
        ("10 newtons_", "N", r"write one number, then a unit"),
        ("10", "kg", r"write its unit too, or the number without quotes, which is then in SI"),
        ("0,5 kg", "kg", r'found "0,5 kg"; .*decimals have a point: "0.5 kg"'),
        ("5 S", "s", r'found "5 S", .*; did you mean "5 s"\?'),
        ("kg", "kg", r"write one number, then a unit"),
        ("", "kg", r'found ""'),
        ("1 N/m s", "N/m", r"write one number, then a unit"),
        ("3 m", "1", r'found "3 m"; expected a plain number'),
        (float("nan"), "m", r"found nan; expected a finite number"),
        (float("-inf"), "m", r"found -inf; expected a finite number"),
        ("1e999 m", "m", r'found "1e999 m"; expected a finite number'),
        (10**400, "m", r"found a whole number of more than 18 digits; expected a finite number"),
        (1e300, "m", r"found 1e\+300; expected 0 or a size between 1e-100 and 1e\+100"),
        ("1e-120 kg", "kg", r'found "1e-120 kg"; expected 0 or a size'),
        (True, "m", r"found true; expected a length"),
        ([1, 2], "m", r"found an array of 2; expected a length"),
        ({}, "s", r"found a table; expected a time"),
        (None, "s", r"found None; expected a time"),
    ],
)
def test_message_says_what_was_found_and_what_was_expected(value, unit, message):
    with pytest.raises(InputError, match=message):
        quantity(value, unit)


@pytest.mark.parametrize(
    "text",
    [
        "9**9**9**9",
        "9**9**9 kg",
        "1 kg^99999999",
        "1 kg**(9**9)",
        "5 __import__('os').system('true')",
        "5 kg; import os",
        "(5) kg",
        "5 kg + 3 kg",
        "1 " + "m*" * 1000 + "m",
        "1" * 100_000 + " kg",
        "5 \x1b[31mkg",
        "5 kg\n6 kg",
        "٣ kg",
        "1__000 kg",
        "_1 kg",
        "0x10 kg",
    ],
)
def test_hostile_text_is_refused_before_any_parser_sees_it(text):
    with pytest.raises(InputError, match=r"write one number, then a unit made of names") as caught:
        quantity(text, "kg")
    assert len(str(caught.value)) < 400
    assert "\x1b" not in str(caught.value)


@pytest.fixture(scope="module")
def reference():
    """The default registry of pint with its own definitions; it lacks rev and joins no symbols."""
    units = pint.UnitRegistry(on_redefinition="ignore")
    for definition in ("rev = turn", "gn = g_0", "Nm = newton*meter", "Nmm = newton*millimeter", "Ns = newton*second"):
        units.define(definition)
    return units


@pytest.mark.parametrize("unit", UNITS, ids=lambda unit: unit.symbols)
def test_every_accepted_unit_is_that_of_pint_itself(unit, reference):
    for name in (*unit.symbols.split(), *unit.names.split(), *unit.irregular.split()):
        for prefix in ("", *unit.prefixes.split()) if name == unit.symbols.split()[0] else ("",):
            assert is_accepted(prefix + name)
            assert float(unit_in_si(prefix + name)[0]) == pytest.approx(
                (1 * reference.parse_units(prefix + name)).to_base_units().magnitude, rel=1e-8
            )


@pytest.mark.parametrize("name", AMBIGUOUS)
def test_an_ambiguous_spelling_is_no_unit(name):
    assert not is_accepted(name)
    assert " or " in instead_of(name)


def test_a_kind_without_a_name_is_told_by_its_unit():
    assert expected("N/s^2") == 'a quantity in N/s^2, e.g. "2 N/s^2", or a number in N/s^2'


def test_shown_values_are_short_and_printable():
    assert shown("a\x07b") == '"a\\x07b"'
    assert len(shown("x" * 10**6)) < 70


def test_texts_that_look_like_quantities_are_counted():
    assert count_texts({"a": "3 N/mm", "b": ["2 m", 4, {"c": "spring"}], "d": "ground"}) == 2
