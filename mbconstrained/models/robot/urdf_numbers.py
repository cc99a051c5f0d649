"""Numbers of a URDF, each found or refused with the place where it stands."""

from __future__ import annotations

from ...errors import InputError

LEAST, LARGEST = 1e-100, 1e100  # in SI; squares of what lies between stay within the range of float64


def number(text, where: str, minimum: float | None = None) -> float:
    """One number: 0 or a size that a machine can have.

    >>> number(" 2.5 ", "mass")
    2.5

    Raises:
        InputError: not a number, too large, too small or below the minimum.
    """
    return numbers(text, 1, where, minimum)[0]


def numbers(text, count: int, where: str, minimum: float | None = None) -> list[float]:
    """So many numbers between blanks.

    >>> numbers("0 0 -9.81", 3, "xyz")
    [0.0, 0.0, -9.81]
    """
    try:
        found = [float(part) for part in str(text).split()]
    except ValueError:
        found = []
    if len(found) != count:
        raise InputError(f"{where}: found {short(text)!a}; expected {f'{count} numbers' if count > 1 else 'a number'}")
    for value in found:
        if value and not LEAST <= abs(value) <= LARGEST:  # false for what is not finite, too
            raise InputError(f"{where}: found {value:g}; expected 0 or a size between {LEAST:g} and {LARGEST:g}")
        if minimum is not None and value < minimum:
            raise InputError(f"{where}: found {value:g}; expected at least {minimum:g}")
    return found


def short(text) -> str:
    """A text as it is quoted in a message: printable and never long."""
    text = "".join(c if c.isprintable() else "?" for c in str(text))
    return text if len(text) <= 60 else text[:57] + "..."
