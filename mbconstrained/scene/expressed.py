"""A number that was written as an expression of parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .dimensions import Dimension
    from .expressions import Expression


class Expressed(float):
    """The value of an expression with the default values of its parameters, in SI; it calculates as the number that it is.

    Attributes:
        text: the expression as it stands in the scene, with its "=".
        tree: the expression.
        dimension: its kind of quantity, None where the parameters do not tell.

    >>> Expressed(4.0, "=2*k", None, None) + 1.0
    5.0
    """

    text: str
    tree: Expression
    dimension: Dimension | None

    def __new__(cls, value: float, text: str, tree: Expression, dimension: Dimension | None):
        """The number with where it comes from."""
        found = super().__new__(cls, value)
        found.text, found.tree, found.dimension = text, tree, dimension
        return found
