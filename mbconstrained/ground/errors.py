"""The exceptions of the package, every error that a user sees is one of them, and values as messages quote them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

import numpy as np


class MbconstrainedError(Exception):
    """The base of all errors of this package; its text is one message that ends with the remedy."""


class InputError(MbconstrainedError, ValueError):
    """An invalid value of an argument; the text states what was found, what was expected and the remedy."""


class UnknownIndex(InputError, IndexError):
    """A place beyond the end of a sequence."""


class WrongCall(InputError, TypeError):
    """A call with an unknown argument, without a necessary one or with too many; the text names it and the nearest one."""


class UnknownAttribute(MbconstrainedError, AttributeError):
    """A name that a public object does not have, with the nearest one; the text is made when it is read: ``hasattr`` needs none."""

    def __init__(self, name: str, message: Callable[[str], str]):
        super().__init__(name, message)
        self.name = name  # Python adds a suggestion of its own where this is not set

    def __str__(self) -> str:
        name, message = self.args
        return message(name)


class SceneError(InputError):
    """Unusable scene file; the text names the file, the location in it and the nearest known name."""


class SingularPolynomialMatrix(MbconstrainedError, ValueError):
    """A(s) is not regular: some equations depend on each other, or some coordinates are free.

    Either det A(s) = 0 for every s, or there are more equations than coordinates, or fewer.

    Attributes:
        equations: indices of the rows that depend on each other.
        coordinates: indices of the coordinates that the equations leave undetermined.
    """

    def __init__(self, message: str, equations: tuple[int, ...] = (), coordinates: tuple[int, ...] = ()):
        super().__init__(message)
        self.equations = equations
        self.coordinates = coordinates


class NotSolvable(SingularPolynomialMatrix):
    """No motion satisfies the equations: a combination of them has no coordinate left, but a force or an impulse.

    Attributes:
        conditions: ``Condition`` of each such combination, satisfied or not, from ``mb.solvability``.
    """

    def __init__(self, message: str, conditions: tuple = ()):
        super().__init__(message)
        self.conditions = conditions


class ContradictoryConstraints(InputError):
    """Dependent constraint rows with different right-hand sides; the text names the rows."""


class NotUnique(MbconstrainedError, ValueError):
    """Acceleration not determined: rank [M; A] < n (Udwadia and Phohomsiri's test)."""


class NoNormalForm(MbconstrainedError, ValueError):
    """No transformation of the states makes the system mechanical; the text names the violated condition and its margin.

    Attributes:
        condition: "rank [B, A B]" or "rank [A - lambda I, B]", of a singular F those of the finite part; "descriptor" where
            det(s F - A) is zero for every s, or the finite part has an odd number of states.
        rank, needed: the actual rank, and the necessary one; of "descriptor" that of F, or an odd number of states and the next even one.
        eigenvalue: lambda in 1/s, where the second condition fails.
        margin: distance of the data to a system that clearly fails, relative to A; a margin near rounding error counts as failure.
        doubtful: True where rounding errors of the data may decide.
    """

    def __init__(
        self,
        message: str,
        condition: str = "",
        rank: int = 0,
        needed: int = 0,
        eigenvalue: float | None = None,
        margin: float = 0.0,
        doubtful: bool = False,
    ):
        super().__init__(message)
        self.condition, self.rank, self.needed = condition, rank, needed
        self.eigenvalue, self.margin, self.doubtful = eigenvalue, margin, doubtful


class Overflow(MbconstrainedError, OverflowError):
    """The answer grows beyond the range of float64; the text names the first such time."""


class IllConditioned(MbconstrainedError, ArithmeticError):
    """Data over too many orders of magnitude for float64 arithmetic."""


class MissingPackage(MbconstrainedError, ImportError):
    """Missing optional package; the text names it with the command that installs it."""


#: Remedy for data whose products exceed the range of float64.
OUT_OF_RANGE = (
    "products of the data leave the range of float64, or their inverses do; choose other units, in which they are nearer to 1"
)


@contextmanager
def within_float64() -> Iterator[None]:
    """A context without warnings of floating-point arithmetic: what is not finite is reported where it is evaluated.

    >>> with within_float64():
    ...     np.float64(1e300) * 1e300
    np.float64(inf)
    """
    try:
        with np.errstate(all="ignore"):
            yield
    except MbconstrainedError:
        raise
    except (np.linalg.LinAlgError, ValueError, ArithmeticError):
        raise IllConditioned(OUT_OF_RANGE) from None


@contextmanager
def named(name: object) -> Iterator[None]:
    """A context that adds a name to the message of an InputError about its value."""
    try:
        yield
    except InputError as problem:
        raise InputError(f"{name}: {problem}") from None


def shown(value, longest: int = 60) -> str:
    """A value as quoted in messages."""
    text = getattr(value, "text", value)  # an expression of parameters shows as written
    if isinstance(text, str):
        text = quoted(text[: longest + 1])
    elif isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, dict):
        text = "a table"
    elif isinstance(value, list):
        text = f"an array of {len(value)}"
    elif isinstance(value, int) and abs(value) > 10**18:
        text = "a whole number of more than 18 digits"
    else:
        text = str(value)
    return text if len(text) <= longest + 2 else text[:longest] + "..."


def quoted(text: str) -> str:
    """The text in double quotes with every unprintable character escaped."""
    return '"' + "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text) + '"'
