"""Expressions of parameters, such as "=k1 + k2": a small grammar of its own, read by recursive descent.

    sum     = product {("+" | "-") product}
    product = sign {("*" | "/") sign}
    sign    = ("+" | "-") sign | power
    power   = atom ["^" whole number with its sign]
    atom    = number | name | "(" sum ")"

What is read is a tree of the four operations and whole powers. Nothing else can be said in it, and nothing in it is ever
handed to an interpreter.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from ..errors import InputError
from .units import quoted, shown

LONGEST_EXPRESSION = 200  # characters
DEEPEST_EXPRESSION = 20  # parentheses and signs inside each other
LARGEST_EXPONENT = 20

_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]{1,2})?)|(?P<name>[^\W\d_]\w*)|(?P<sign>[-+*/^()]))"
)
_WHOLE = re.compile(r"[0-9]{1,3}")


@dataclass(frozen=True)
class Number:
    """A number as it was written."""

    text: str

    def value(self, number: Callable[[str], Any], names: Mapping[str, Any]) -> Any:
        """The number, of the kind that ``number`` makes."""
        return number(self.text)

    def names(self) -> Iterator[str]:
        """The names in it: none."""
        return iter(())

    def replaced(self, names: Mapping[str, Expression]) -> Expression:
        """Itself."""
        return self

    @property
    def size(self) -> int:
        """How many numbers, names and operations it is made of."""
        return 1


@dataclass(frozen=True)
class Name:
    """A parameter."""

    text: str

    def value(self, number: Callable[[str], Any], names: Mapping[str, Any]) -> Any:
        """What the name stands for."""
        return names[self.text]

    def names(self) -> Iterator[str]:
        """The name."""
        yield self.text

    def replaced(self, names: Mapping[str, Expression]) -> Expression:
        """What the name stands for."""
        return names.get(self.text, self)

    @property
    def size(self) -> int:
        """How many numbers, names and operations it is made of."""
        return 1


@dataclass(frozen=True)
class Operation:
    """Two expressions joined by + - * or /; a power has a whole number for its second."""

    sign: str
    left: Expression
    right: Expression | int

    def value(self, number: Callable[[str], Any], names: Mapping[str, Any]) -> Any:
        """The operation done on values of any kind that has it."""
        left = self.left.value(number, names)
        if self.sign == "^":
            return left**self.right
        return _OPERATIONS[self.sign](left, self.right.value(number, names))

    def names(self) -> Iterator[str]:
        """The names in both."""
        yield from self.left.names()
        if not isinstance(self.right, int):
            yield from self.right.names()

    def replaced(self, names: Mapping[str, Expression]) -> Expression:
        """The same with expressions instead of names."""
        right = self.right if isinstance(self.right, int) else self.right.replaced(names)
        return Operation(self.sign, self.left.replaced(names), right)

    @property
    def size(self) -> int:
        """How many numbers, names and operations it is made of."""
        return 1 + self.left.size + (1 if isinstance(self.right, int) else self.right.size)


Expression = Number | Name | Operation
_OPERATIONS = {
    "+": lambda one, two: one + two,
    "-": lambda one, two: one - two,
    "*": lambda one, two: one * two,
    "/": lambda one, two: one / two,
}
_MINUS_ONE = Number("-1")


def read_expression(text: str) -> Expression:
    """The tree of an expression, given without its "=".

    Raises:
        InputError: too long, too deep, or not of the grammar; the text says where.

    >>> tree = read_expression("2*(k1 + k2)/m^2")
    >>> tree.value(float, {"k1": 1.0, "k2": 3.0, "m": 2.0}), sorted(set(tree.names()))
    (2.0, ['k1', 'k2', 'm'])
    """
    if len(text) > LONGEST_EXPRESSION:
        raise InputError(f"found an expression of {len(text)} characters; expected at most {LONGEST_EXPRESSION}")
    return _Reader(text).whole()


class _Reader:
    """The tokens of an expression, and how far they have been read."""

    def __init__(self, text: str):
        self.text = text
        self.tokens = list(self._tokens())
        self.place = 0
        self.depth = 0

    def whole(self) -> Expression:
        found = self.sum()
        if self._next():
            raise self._unexpected("an operation + - * / ^ or the end")
        return found

    def sum(self) -> Expression:
        found = self.product()
        while sign := self._taken("+", "-"):
            found = Operation(sign, found, self.product())
        return found

    def product(self) -> Expression:
        found = self.signed()
        while sign := self._taken("*", "/"):
            found = Operation(sign, found, self.signed())
        return found

    def signed(self) -> Expression:
        if sign := self._taken("+", "-"):
            found = self._deeper(self.signed)
            return Operation("*", _MINUS_ONE, found) if sign == "-" else found
        return self.power()

    def power(self) -> Expression:
        found = self.atom()
        if not self._taken("^"):
            return found
        sign = -1 if self._taken("+", "-") == "-" else 1
        kind, text = self._next() or ("", "")
        if kind != "number" or not _WHOLE.fullmatch(text) or int(text) > LARGEST_EXPONENT:
            raise self._unexpected(f"a whole number up to {LARGEST_EXPONENT} behind ^")
        self.place += 1
        return Operation("^", found, sign * int(text))

    def atom(self) -> Expression:
        kind, text = self._next() or ("", "")
        if kind not in ("number", "name") and text != "(":
            raise self._unexpected("a number, a name or (")
        self.place += 1
        if text != "(":
            return Number(text) if kind == "number" else Name(text)
        found = self._deeper(self.sum)
        if not self._taken(")"):
            raise self._unexpected("an operation or )")
        return found

    def _deeper(self, read: Callable[[], Expression]) -> Expression:
        self.depth += 1
        if self.depth > DEEPEST_EXPRESSION:
            raise InputError(
                f"found {shown('=' + self.text)}, nested more than {DEEPEST_EXPRESSION} deep; write it in a simpler way"
            )
        found = read()
        self.depth -= 1
        return found

    def _taken(self, *signs: str) -> str:
        """The next token, left behind, if it is one of these signs."""
        kind, text = self._next() or ("", "")
        if kind != "sign" or text not in signs:
            return ""
        self.place += 1
        return text

    def _next(self) -> tuple[str, str] | None:
        return self.tokens[self.place] if self.place < len(self.tokens) else None

    def _tokens(self) -> Iterator[tuple[str, str]]:
        text, place = self.text.rstrip(), 0
        while place < len(text):
            match = _TOKEN.match(text, place)
            if match is None or (match.lastgroup == "name" and not match["name"].isidentifier()):  # a raised ² is no letter
                wrong = text[place:].lstrip()[0]
                raise InputError(
                    f"found {shown('=' + self.text)}, with {quoted(wrong)} in it; "
                    "an expression is made of numbers, names, + - * / ^ ( )"
                )
            yield str(match.lastgroup), match[str(match.lastgroup)]
            place = match.end()

    def _unexpected(self, expected: str) -> InputError:
        token = self._next()
        found = f"{quoted(token[1])} stands there" if token else "it ends there"
        before = " ".join(text for _, text in self.tokens[: self.place])
        where = f"after {quoted(before[-30:])} " if before else ""
        return InputError(f"found {shown('=' + self.text)}: {where}{found}; expected {expected}")
