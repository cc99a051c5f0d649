"""Texts in the typography of a page: raised powers of units, complex numbers on one line, long names shortened."""

from __future__ import annotations

import html
import re

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

#: A unit with a power, but not a name such as "x^2".
_POWER = re.compile(r"\b(kg|m|s|A|K|mol|cd|rad|N|J)\^(-?\d+)\b")


def typeset(text: str) -> str:
    """HTML for a text of the user or of a table, escaped; no line ends within "-0.5 ± 0.25 i".

    >>> typeset("5 N s^2 < 1")
    '5 N s² &lt; 1'
    """
    return html.escape(re.sub(r"(?<=\d) (?=±|i\b)|(?<=±) (?=\d)", "\N{NO-BREAK SPACE}", raised(text)))


def raised(text: str) -> str:
    """Units with raised powers.

    >>> raised("m/s^2")
    'm/s²'
    """
    return _POWER.sub(lambda power: power[1] + superscript(int(power[2])), text)


def superscript(number: int) -> str:
    """A whole number as an exponent.

    >>> superscript(-12)
    '⁻¹²'
    """
    return str(number).translate(_SUPERSCRIPT)


def shortened(text: object, length: int = 40) -> str:
    """A text on one line, without characters that cannot be printed, cut off where it is longer.

    >>> shortened("a\\nb"), shortened("abcdefgh", 5)
    ('a b', 'abcd…')
    """
    text = "".join(letter if letter.isprintable() else " " for letter in str(text)[: 8 * length])
    text = " ".join(text.split())
    return text if len(text) <= length else text[: length - 1].rstrip() + "…"
