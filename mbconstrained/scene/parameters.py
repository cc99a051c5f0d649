"""The [parameters] of a scene: named quantities, and the texts "=…" that use them: sums, products, quotients and whole powers.

Python's own parser reads an expression (``ast.parse``); of its tree only these operations are admitted, and nothing is ever executed.
"""

from __future__ import annotations

import ast
import math
import operator
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from graphlib import CycleError, TopologicalSorter
from typing import Any

from ..ground.checks import nearest
from ..ground.errors import InputError, SceneError, quoted, shown
from ..ground.notices import Notice, NoticeKind
from ..ground.quantities import Dimension, Expressed, OfParameters, any_quantity, described, in_range, unit_of
from ..ground.units import is_accepted
from .file import Place, place, together

LONGEST_EXPRESSION = 200  # characters
LARGEST_EXPONENT = 20

_DIGITS = r"[0-9]+(?:_[0-9]+)*"
_NUMBER_TEXT = rf"(?>(?:{_DIGITS}\.?(?:{_DIGITS})?|\.{_DIGITS})(?:[eE][+-]?[0-9]{{1,2}})?)"  # atomic: 1e-3 is no unit e
_NUMBER = re.compile(_NUMBER_TEXT)
_UNIT_NAME = r"[^\W\d_]+(?![\w.(])(?:\^-?[1-9](?!\d))?"
# a name, or a number with what may be its unit
_NAMES_IN_TEXT = re.compile(rf"(?<![\w.])(?:({_NUMBER_TEXT})\s*({_UNIT_NAME}(?:(?:\s*[*/]\s*|\s+){_UNIT_NAME})*)|[^\W\d_]\w*)")
_UNIT_PART = re.compile(rf"(\s*[*/]\s*|\s+|^)({_UNIT_NAME})")
_WORD = re.compile(r"[^\W\d]\w*")
_FOREIGN = re.compile(r"[^\w\s.+\-*/^()]|(?<!\w)_")
_BINARY: dict[Any, Any] = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv}
_UNARY: dict[Any, Any] = {ast.UAdd: operator.pos, ast.USub: operator.neg}


@dataclass(frozen=True)
class Expression:
    """An expression of parameters."""

    tree: ast.expr  # of Python's parser; a Name has the name of a parameter, a Constant the text of a number in SI

    def value(self, number: Callable[[str], Any], names: Mapping[str, Any]) -> Any:
        def of(node: Any) -> Any:
            if isinstance(node, ast.Constant):
                assert isinstance(node.value, str)
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


class _NumberInSI(str):
    """The text of a number in SI that has a unit in an expression, with its dimension."""

    dimension: Dimension


def read_expression(text: str, parameters: Collection[str] = ()) -> Expression:
    """Read an expression, whose numbers may have units; names of parameters are no units.

    >>> expression = read_expression("2*(k1 + k2)/m^2 + 3 N/mm")
    >>> expression.value(float, {"k1": 1.0, "k2": 3.0, "m": 2.0}), sorted(expression.names)
    (3002.0, ['k1', 'k2', 'm'])
    """
    if len(text) > LONGEST_EXPRESSION:
        raise InputError(f"found an expression of {len(text)} characters; expected at most {LONGEST_EXPRESSION}")
    if foreign := _FOREIGN.search(text):
        raise _refusal(text, f"with {quoted(foreign[0])} in it")
    names: list[str] = []  # stand as n0, n1, … in what Python reads: a parameter may have the name of a keyword

    def numbered(match: re.Match) -> str:
        if match[1]:
            own, rest = _number_in_si(match[1], match[2], text, parameters)
            names.append(own)
            return f"n{len(names) - 1}{_NAMES_IN_TEXT.sub(numbered, rest)}"
        if not match[0].isidentifier():
            raise _refusal(text, f"with {quoted(match[0])} in it")
        names.append(match[0])
        return f"n{len(names) - 1}"

    source = " ".join(_NAMES_IN_TEXT.sub(numbered, text).split()).replace("^", "**")
    try:
        tree = ast.parse(source, mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise _refusal(text, "which cannot be read") from None
    return Expression(_admitted(tree, source, names, text))


def _number_in_si(number: str, names: str, text: str, parameters: Collection[str]) -> tuple[_NumberInSI, str]:
    """A number with the longest unit at the start of names that are joined by * and /, and the rest."""
    end, divided = 0, False
    for part in _UNIT_PART.finditer(names):
        name, divides = part[2].partition("^")[0], part[1].strip() == "/"
        if not is_accepted(name) or (divided and end and not divides):
            break
        if name in parameters:
            other = f"({number} {names[: part.start()].strip()}){part[1].strip()}{name}" if end else f"{number}*{name}"
            raise InputError(
                f'found {shown("=" + text)}, where "{name}" may be the unit or the parameter: write "{other}", or the name of the unit in '
                'full, such as "metre"'
            )
        end, divided = part.end(), divided or divides
    if not end:
        name = names.split()[0].partition("*")[0].partition("/")[0]
        raise InputError(f'found {shown("=" + text)}; there is no unit "{name}": for a product write "{number}*{name}"')
    value, kind = any_quantity(f"{number} {names[:end]}")
    result = _NumberInSI(repr(value))
    result.dimension = kind
    return result, names[end:]


def _admitted(node: ast.expr, source: str, names: list[str], text: str) -> ast.expr:
    """The parsed tree with the names of the parameters and the texts of the numbers."""
    if isinstance(node, ast.Name):
        name = names[int(node.id[1:])]
        return ast.Constant(name) if isinstance(name, _NumberInSI) else ast.Name(name)
    if isinstance(node, ast.Constant):
        number = ast.get_source_segment(source, node) or ""
        if not _NUMBER.fullmatch(number):
            raise _refusal(text, f"with {quoted(number)} in it")
        return ast.Constant(number.replace("_", ""))
    if isinstance(node, ast.UnaryOp) and type(node.op) in _UNARY:
        return ast.UnaryOp(node.op, _admitted(node.operand, source, names, text))
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        exponent = ast.get_source_segment(source, node.right) or ""
        if not re.fullmatch(r"[+-]?\s*\d{1,3}", exponent, re.ASCII) or abs(int(exponent.replace(" ", ""))) > LARGEST_EXPONENT:
            advice = ADVICE if exponent.replace(" ", "") in ("0.5", "(1/2)") else ""
            raise InputError(f"found {shown('=' + text)}; expected a whole number up to {LARGEST_EXPONENT} behind ^{advice}")
        return ast.BinOp(_admitted(node.left, source, names, text), node.op, node.right)
    if isinstance(node, ast.BinOp) and type(node.op) in _BINARY:
        return ast.BinOp(_admitted(node.left, source, names, text), node.op, _admitted(node.right, source, names, text))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        name = names[int(node.func.id[1:])]
        raise _refusal(text, f"with the function {name}(…) in it", ADVICE if name == "sqrt" else "")
    raise _refusal(text, "with something else in it")


#: On roots: those of elements given by frequency and damping ratio are avoidable.
ADVICE = '; without roots: take w = sqrt(k/m) as the parameter, then k is "=m*w^2" and c is "=2*zeta*m*w"'


def _refusal(text: str, what: str, advice: str = "") -> InputError:
    return InputError(
        f"found {shown('=' + text)}, {what}; an expression has numbers, perhaps with units, names, + - * / ^ and parentheses{advice}"
    )


MOST_BITS = 20_000  # of a numerator or denominator: more come of powers of powers


@dataclass(frozen=True)
class Measured:
    """An exact number with its dimension: expressions calculate with it, and refuse to add kg to m."""

    value: Fraction  # in SI
    dimension: Dimension | None = None  # None where unknown: a parameter that is a plain number may be any quantity in SI
    # whether it is made of numbers in an expression: a factor without a dimension, as a summand of any kind
    is_number: bool = False

    def __post_init__(self):
        if max(self.value.numerator.bit_length(), self.value.denominator.bit_length()) > MOST_BITS:
            raise InputError("its value has far too many digits")

    def __add__(self, other: Measured) -> Measured:
        return Measured(self.value + other.value, self._common(other, "adds"), self.is_number and other.is_number)

    def __sub__(self, other: Measured) -> Measured:
        return Measured(self.value - other.value, self._common(other, "subtracts"), self.is_number and other.is_number)

    def __mul__(self, other: Measured) -> Measured:
        one, two = self.dimension, other.dimension
        if self.is_number or other.is_number:
            dimension = two if self.is_number else one
        else:
            dimension = None if one is None or two is None else one.times(two)
        return Measured(self.value * other.value, dimension, self.is_number and other.is_number)

    def __truediv__(self, other: Measured) -> Measured:
        return self * other**-1

    def __pow__(self, exponent: int) -> Measured:
        if not self.value and exponent < 0:
            raise InputError("it divides by zero with the default values of the parameters")
        if max(self.value.numerator.bit_length(), self.value.denominator.bit_length()) * abs(exponent) > MOST_BITS:
            raise InputError("its value has far too many digits")
        return Measured(self.value**exponent, self.dimension and self.dimension.power(exponent), self.is_number)

    def __neg__(self) -> Measured:
        return Measured(-self.value, self.dimension, self.is_number)

    def __pos__(self) -> Measured:
        return self

    def _common(self, other: Measured, does: str) -> Dimension | None:
        """The dimension of a sum."""
        one, two = self.dimension, other.dimension
        if one is None or two is None:
            return one or two
        if one.units != two.units:
            raise InputError(f"it {does} {described(one)} and {described(two)}")
        return one if one.radian == two.radian else Dimension(one.units, None)


MOST_PARAMETERS = 200
MOST_PARTS = 300  # of an expression in which parameters that are expressions are written out
TEXTS = ("title", "source", "note", "name", "file", "array")  # keys of texts, which no number can stand for
BY_COORDINATE = ("displacement", "velocity", "rows", "moves", "turns")  # tables whose keys are names that somebody chose
RESERVED = {"t": "t is the time", "pi": "pi is the number 3.14159…", "π": "π is the number 3.14159…"}
_NAME = re.compile(r"[^\W\d_]\w{0,39}")


@dataclass(frozen=True)
class Parameters:
    """The parameters of a scene."""

    # in SI, by name, in the order of the file; those that are expressions of others are written out everywhere
    values: dict[str, float] = field(default_factory=dict)
    # kinds of quantity by name; None for plain numbers, which may be anything in SI
    dimensions: dict[str, Dimension | None] = field(default_factory=dict)
    unused: tuple[str, ...] = ()  # the names of those that stand in no expression
    # of the expressions, with the names of the parameters in them and in those
    places: dict[Place, frozenset[str]] = field(default_factory=dict)

    @property
    def units(self) -> dict[str, str]:
        """SI units by name, an empty text where unknown."""
        return {name: "" if kind is None else unit_of(kind) for name, kind in self.dimensions.items()}

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on unused parameters."""
        text = 'the parameter "{}" is used nowhere in the scene; write "={}" where it belongs, or leave it out'
        return tuple(Notice(NoticeKind.OMITTED, text.format(name, name)) for name in self.unused)


def with_parameters(data: dict, file_name: str) -> tuple[dict, Parameters]:
    """Replace every text "=…" in the tables of a scene by its value."""
    if "parameters" not in data and not _has_expressions(data):
        return data, Parameters()
    work = _Substitution(data)
    result = {key: value if key == "parameters" else work.replaced(value, (key,)) for key, value in data.items()}
    if work.problems:
        raise SceneError(together(file_name, work.problems))
    symbols = {name: value for name, value in work.known.items() if name not in work.trees}
    values = {name: float(value.value) for name, value in symbols.items()}
    unused = tuple(name for name in work.known if name not in work.used)
    return result, Parameters(values, {name: value.dimension for name, value in symbols.items()}, unused, work.places)


class _Reported(InputError):
    """A wrong parameter that has been reported at its definition."""


class _Substitution:
    """The parameters of a scene, and the expressions evaluated with them."""

    def __init__(self, data: dict):
        self.data = data
        self.problems: list[str] = []  # messages about wrong parameters and expressions, which are reported together
        self.known: dict[str, Measured] = {}  # values by name
        # of the parameters that are expressions themselves, written out in those that are not
        self.trees: dict[str, Expression] = {}
        self.depends: dict[str, frozenset[str]] = {}  # the names on which each parameter depends, its own included
        self.used: frozenset[str] = frozenset()  # the names on which any value depends
        self.places: dict[Place, frozenset[str]] = {}  # of the expressions in the scene, each with the names on which it depends
        self.given = data.get("parameters", {})
        with self._problem_at("parameters"):
            self._read_parameters()

    def _read_parameters(self) -> None:
        if not isinstance(self.given, dict):
            given, self.given = self.given, {}
            raise InputError(f'found {shown(given)}; expected names with quantities, e.g. m = "10 kg"')
        if len(self.given) > MOST_PARAMETERS:
            raise InputError(f"found {len(self.given)} parameters; expected at most {MOST_PARAMETERS}")
        expressions: dict[str, Expression] = {}
        for name, value in self.given.items():
            with self._problem_at(f"parameters.{name}" if name.isprintable() else "parameters"):
                _check_name(name)
                if _is_expression(value):
                    expressions[name] = read_expression(value.strip()[1:], self.given)
                else:
                    number, dimension = any_quantity(value)
                    self.known[name], self.depends[name] = Measured(Fraction(repr(number)), dimension), frozenset([name])
        for name in _in_order(expressions):
            with self._problem_at(f"parameters.{name}"):
                value = self._value(self.given[name].strip(), expressions[name])
                self.known[name] = Measured(value.value, value.dimension)
                self.depends[name] = self._dependencies(expressions[name]) | {name}
                self.trees[name] = self._written_out(expressions[name])
        self.known = {name: self.known[name] for name in self.given if name in self.known}

    @contextmanager
    def _problem_at(self, where: str) -> Iterator[None]:
        """Collect a problem instead of raising it."""
        try:
            yield
        except InputError as problem:
            if not isinstance(problem, _Reported):
                self.problems.append(f"{where}: {problem}")

    def replaced(self, value, location: tuple):
        """The value with its expressions replaced; 1 for a wrong expression, whose problem is collected."""
        if location[-1] in TEXTS and not {*location[:-1]} & {*BY_COORDINATE}:
            return value
        if isinstance(value, dict):
            return {key: self.replaced(entry, (*location, key)) for key, entry in value.items()}
        if isinstance(value, list):
            return [self.replaced(entry, (*location, number)) for number, entry in enumerate(value)]
        if not _is_expression(value):
            return OfParameters(value) if isinstance(value, str) and self._has_only_parameters(value) else value
        with self._problem_at(place(location, self.data)):
            return self._expressed(value.strip(), location)
        return 1.0

    def _has_only_parameters(self, text: str) -> bool:
        names = {*_WORD.findall(text)}
        return bool(names) and names <= self.given.keys()

    def _expressed(self, text: str, location: tuple) -> Expressed:
        expression = read_expression(text[1:], self.given)
        value, names = self._value(text, expression), self._dependencies(expression)
        self.used |= names
        self.places[tuple(part + 1 if isinstance(part, int) else part for part in location)] = names
        return Expressed(in_range(value.value, text), text, self._written_out(expression), value.dimension)

    def _value(self, text: str, expression: Expression) -> Measured:
        for name in expression.names:
            self._check(name, text)
        try:
            value = expression.value(_measured, {**self.known, "pi": Measured(Fraction(math.pi), None, True)})
        except InputError as problem:
            raise InputError(f"found {shown(text)}: {problem}") from None
        in_range(value.value, text)
        return value

    def _written_out(self, expression: Expression) -> Expression:
        """The expression in terms of parameters that are not expressions themselves."""
        result = expression.replaced(self.trees)
        if (size := result.size) > MOST_PARTS:
            raise InputError(f"it has {size} parts with those of its parameters; expected at most {MOST_PARTS}")
        return result

    def _dependencies(self, expression: Expression) -> frozenset[str]:
        return frozenset().union(*(self.depends[name] for name in expression.names if name in self.depends))

    def _check(self, name: str, text: str) -> None:
        if name in self.known or name == "pi":
            return
        if name in self.given:
            raise _Reported  # once, where the parameter stands
        if not self.known:
            raise InputError(f'found {shown(text)}, but there is no parameter "{name}": give it a value in the table [parameters]')
        raise InputError(
            f'found {shown(text)}, but there is no parameter "{name}"{nearest(name, self.known)}; there are {", ".join(self.known)}'
        )


def _measured(number: str) -> Measured:
    """A number of an expression."""
    dimension = getattr(number, "dimension", None)
    return Measured(Fraction(number), dimension, dimension is None)


def _has_expressions(value) -> bool:
    if isinstance(value, (dict, list)):
        return any(map(_has_expressions, value.values() if isinstance(value, dict) else value))
    return _is_expression(value)


def _is_expression(value) -> bool:
    return isinstance(value, str) and value.lstrip().startswith("=")


def _in_order(expressions: dict[str, Expression]) -> tuple[str, ...]:
    """The names of expressions that depend on each other, in order of evaluation."""
    needed = {name: [other for other in tree.names if other in expressions] for name, tree in expressions.items()}
    try:
        return tuple(TopologicalSorter(needed).static_order())
    except CycleError as problem:
        circle = problem.args[1][:-1]
        first = min(range(len(circle)), key=lambda i: list(expressions).index(circle[i]))
        named = " and ".join([*circle[first:], *circle[:first]])
        raise InputError(f"{named}: expressions of each other, in a circle; give one of them a value") from None


def _check_name(name: str) -> None:
    if not (_NAME.fullmatch(name) and name.isidentifier()):
        raise InputError(f"found the name {shown(name)}; expected a letter, then at most 39 letters, digits or _")
    if name in RESERVED:
        raise InputError(f"{RESERVED[name]}; choose another name")
