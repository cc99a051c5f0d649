"""What can go wrong, in the user's words. Every error of this package is one of these."""

from __future__ import annotations


class MbconstrainedError(Exception):
    """Base of all errors of this package; its text is one plain message that ends with what to do."""


class InputError(MbconstrainedError, ValueError):
    """A value given by the user cannot be used: what was found, what was expected, what to do."""


class SceneError(InputError):
    """A scene file cannot be used; the text names the file, the place in it and the nearest known name."""


class SingularPolynomialMatrix(MbconstrainedError, ValueError):
    """det A(s) = 0 for every s: some equations depend on each other, or some coordinates are free.

    Attributes:
        equations: indices of the rows that depend on each other.
        coordinates: indices of the coordinates that the equations leave undetermined.
    """

    def __init__(self, message: str, equations: tuple[int, ...] = (), coordinates: tuple[int, ...] = ()):
        super().__init__(message)
        self.equations = equations
        self.coordinates = coordinates


class ContradictoryConstraints(InputError):
    """Dependent constraint rows ask for different values; the text names the rows."""


class NotUnique(MbconstrainedError, ValueError):
    """The acceleration is not determined: rank [M; A] < n (Udwadia and Phohomsiri's test)."""


class Overflow(MbconstrainedError, OverflowError):
    """The answer grows beyond the range of float64; the text names the time from which on it does."""


class IllConditioned(MbconstrainedError, ArithmeticError):
    """The data spans so many orders of magnitude that float64 arithmetic cannot give an answer."""
