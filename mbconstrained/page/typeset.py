"""Plain texts as a page shows them: powers of units raised, a complex number kept on one line."""

from __future__ import annotations

import html
import re

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")

#: A unit with a power; nothing else is taken for one, so that a name such as "x^2" stays what it is.
_POWER = re.compile(r"\b(kg|m|s|A|K|mol|cd|rad|N|J)\^(-?\d+)\b")

_NO_BREAK = "\N{NO-BREAK SPACE}"


def typeset(text: str) -> str:
    """HTML for a text of the user or of a table, escaped.

    >>> typeset("5 N s^2 < 1")
    '5 N s² &lt; 1'
    """
    return html.escape(unbroken(raised(text)))


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


def unbroken(text: str) -> str:
    """No line ends within "-0.5 ± 0.25 i"."""
    text = re.sub(r"(?<=\d) (?=±)|(?<=±) (?=\d)", _NO_BREAK, text)
    return re.sub(r"(?<=\d) (?=i\b)", _NO_BREAK, text)
