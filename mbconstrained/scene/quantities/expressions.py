"""Expressions of parameters, such as "=k1 + k2": sums, products, quotients and whole powers of numbers and names.

Python's own parser reads them (``ast.parse``); of its tree only these operations are admitted, and nothing is ever executed.
"""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ...ground.errors import InputError, quoted, shown

LONGEST_EXPRESSION = 200  # characters
LARGEST_EXPONENT = 20

_NAME = re.compile(r"(?<![\w.])[^\W\d_]\w*")
_NUMBER = re.compile(r"(\d+\.?\d*|\.\d+)([eE][+-]?\d{1,2})?", re.ASCII)
_FOREIGN = re.compile(r"[^\w\s.+\-*/^()]|(?<!\w)_")
_BINARY = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv}
_UNARY = {ast.UAdd: operator.pos, ast.USub: operator.neg}


@dataclass(frozen=True)
class Expression:
    """An expression of parameters."""

    tree: ast.expr  # of Python's parser; a Name has the name of a parameter, a Constant the text of a number

    def value(self, number: Callable[[str], Any], names: Mapping[str, Any]) -> Any:
        """The value of the expression."""

        def of(node: ast.expr) -> Any:
            if isinstance(node, ast.Constant):
                return number(node.value)
            if isinstance(node, ast.Name):
                return names[node.id]
            if isinstance(node, ast.UnaryOp):
                return _UNARY[type(node.op)](of(node.operand))
            assert isinstance(node, ast.BinOp)  # others were refused when the text was read
            if isinstance(node.op, ast.Pow):
                return of(node.left) ** int(ast.unparse(node.right))
            return _BINARY[type(node.op)](of(node.left), of(node.right))

        return of(self.tree)

    @property
    def names(self) -> tuple[str, ...]:
        """The distinct names of its parameters."""
        return tuple(dict.fromkeys(node.id for node in ast.walk(self.tree) if isinstance(node, ast.Name)))

    @property
    def size(self) -> int:
        """The number of numbers, names and operations in it."""
        return sum(isinstance(node, ast.expr) for node in ast.walk(self.tree))

    def replaced(self, expressions: Mapping[str, Expression]) -> Expression:
        """The expression with expressions in place of names."""

        def of(node: ast.expr) -> ast.expr:
            if isinstance(node, ast.Name):
                return expressions[node.id].tree if node.id in expressions else node
            if isinstance(node, ast.UnaryOp):
                return ast.UnaryOp(node.op, of(node.operand))
            if isinstance(node, ast.BinOp):
                return ast.BinOp(of(node.left), node.op, node.right if isinstance(node.op, ast.Pow) else of(node.right))
            return node

        return Expression(of(self.tree))


def read_expression(text: str) -> Expression:
    """Read an expression.

    >>> expression = read_expression("2*(k1 + k2)/m^2")
    >>> expression.value(float, {"k1": 1.0, "k2": 3.0, "m": 2.0}), sorted(expression.names)
    (2.0, ['k1', 'k2', 'm'])
    """
    if len(text) > LONGEST_EXPRESSION:
        raise InputError(f"found an expression of {len(text)} characters; expected at most {LONGEST_EXPRESSION}")
    if foreign := _FOREIGN.search(text):
        raise _refusal(text, f"with {quoted(foreign[0])} in it")
    names: list[str] = []  # stand as n0, n1, … in what Python reads: a parameter may have the name of a keyword

    def numbered(match: re.Match) -> str:
        if not match[0].isidentifier():
            raise _refusal(text, f"with {quoted(match[0])} in it")
        names.append(match[0])
        return f"n{len(names) - 1}"

    source = " ".join(_NAME.sub(numbered, text).split()).replace("^", "**")
    try:
        tree = ast.parse(source, mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise _refusal(text, "which cannot be read") from None
    return Expression(_admitted(tree, source, names, text))


def _admitted(node: ast.expr, source: str, names: list[str], text: str) -> ast.expr:
    """The parsed tree with the names of the parameters and the texts of the numbers."""
    if isinstance(node, ast.Name):
        return ast.Name(names[int(node.id[1:])])
    if isinstance(node, ast.Constant):
        number = ast.get_source_segment(source, node) or ""
        if not _NUMBER.fullmatch(number):
            raise _refusal(text, f"with {quoted(number)} in it")
        return ast.Constant(number)
    if isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY:
        return ast.UnaryOp(node.op, _admitted(node.operand, source, names, text))
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        exponent = ast.get_source_segment(source, node.right) or ""
        if not re.fullmatch(r"[+-]?\s*\d{1,3}", exponent, re.ASCII) or abs(int(exponent.replace(" ", ""))) > LARGEST_EXPONENT:
            raise InputError(f"found {shown('=' + text)}; expected a whole number up to {LARGEST_EXPONENT} behind ^")
        return ast.BinOp(_admitted(node.left, source, names, text), node.op, node.right)
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return ast.BinOp(_admitted(node.left, source, names, text), node.op, _admitted(node.right, source, names, text))
    raise _refusal(text, "with something else in it")


def _refusal(text: str, what: str) -> InputError:
    return InputError(f"found {shown('=' + text)}, {what}; an expression has numbers, names, + - * / ^ and parentheses")
