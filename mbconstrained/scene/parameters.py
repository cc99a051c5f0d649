"""The [parameters] of a scene: quantities with names, and the texts "=…" elsewhere in the scene that use them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from fractions import Fraction
from graphlib import CycleError, TopologicalSorter

from ..checks import nearest
from ..errors import InputError, SceneError
from ..notices import Notice
from .dimensions import Dimension, unit_of
from .expressed import Expressed
from .expressions import Expression, read_expression
from .measured import Measured
from .origins import Place
from .problems import place, together
from .units import any_quantity, in_range, shown

MOST_PARAMETERS = 200
MOST_PARTS = 300  # of an expression in which parameters that are expressions are written out
TEXTS = ("title", "source", "note", "name", "file", "array")  # keys of texts, which no number can stand for
BY_COORDINATE = ("displacement", "velocity", "rows", "moves", "turns")  # tables whose keys are names that somebody chose
RESERVED = {"t": "t is the time", "pi": "pi is the number 3.14159…", "π": "π is the number 3.14159…"}
_NAME = re.compile(r"[^\W\d_]\w{0,39}")
_PI = {"pi": Measured(Fraction(math.pi), None, True)}


@dataclass(frozen=True)
class Parameters:
    """The parameters of a scene.

    Attributes:
        values: in SI, by name, in the order of the file; those that are expressions of others are written out everywhere.
        dimensions: kinds of quantity by name; None for plain numbers, which may be anything in SI.
        unused: the names of those that stand in no expression.
        places: of the expressions, with the names of the parameters in them and in those.
    """

    values: dict[str, float] = field(default_factory=dict)
    dimensions: dict[str, Dimension | None] = field(default_factory=dict)
    unused: tuple[str, ...] = ()
    places: dict[Place, frozenset[str]] = field(default_factory=dict)

    @property
    def units(self) -> dict[str, str]:
        """SI units by name, an empty text where it is not known."""
        return {name: "" if kind is None else unit_of(kind) for name, kind in self.dimensions.items()}

    @property
    def notices(self) -> tuple[Notice, ...]:
        """One notice for each parameter that is not used."""
        text = 'the parameter "{}" is used nowhere in the scene; write "={}" where it belongs, or leave it out'
        return tuple(Notice("left out", text.format(name, name)) for name in self.unused)


def with_parameters(data: dict, file_name: str) -> tuple[dict, Parameters]:
    """The tables of a scene with every text "=…" replaced by its value, which remembers the expression.

    Raises:
        SceneError: with one line for every parameter or expression that is wrong.
    """
    work = _Substitution(data)
    found = {key: value if key == "parameters" else work.replaced(value, (key,)) for key, value in data.items()}
    if work.problems:
        raise SceneError(together(file_name, work.problems))
    symbols = {name: value for name, value in work.known.items() if name not in work.expressions}
    values = {name: float(value.value) for name, value in symbols.items()}
    unused = tuple(name for name in work.known if name not in work.used)
    return found, Parameters(values, {name: value.dimension for name, value in symbols.items()}, unused, work.places)


class _Substitution:
    """What is known of the parameters while the tables are gone through."""

    def __init__(self, data: dict):
        self.data = data
        self.problems: list[str] = []
        self.used: set[str] = set()
        self.places: dict[Place, frozenset[str]] = {}
        self.known: dict[str, Measured] = {}
        self.expressions: dict[str, Expression] = {}  # of the parameters that are expressions of others
        self.trees: dict[str, Expression] = {}  # the same, written out in those that are not
        self.given: dict = {}
        try:
            self._read_all(data.get("parameters", {}))
        except InputError as problem:
            self.problems.append(f"parameters: {problem}")

    def _read_all(self, given) -> None:
        if not isinstance(given, dict):
            raise InputError(f'found {shown(given)}; expected names with quantities, e.g. m = "10 kg"')
        self.given = given
        if len(self.given) > MOST_PARAMETERS:
            raise InputError(f"found {len(self.given)} parameters; expected at most {MOST_PARAMETERS}")
        for name, value in self.given.items():
            with self._telling(f"parameters.{name}" if name.isprintable() else "parameters"):
                _check_name(name)
                if _is_expression(value):
                    self.expressions[name] = read_expression(value.strip()[1:])
                else:
                    self.known[name] = _plain(value)
        for name in _in_order(self.expressions):
            with self._telling(f"parameters.{name}"):
                found = self._value(self.given[name].strip(), self.expressions[name])
                self.known[name] = Measured(found.value, found.dimension)
                self.trees[name] = self._written_out(self.expressions[name])
        self.known = {name: self.known[name] for name in self.given if name in self.known}

    @contextmanager
    def _telling(self, where: str) -> Iterator[None]:
        """Keep what is wrong, to be told together with everything else that is."""
        try:
            yield
        except InputError as problem:
            self.problems.append(f"{where}: {problem}")

    def replaced(self, value, location: tuple):
        """The value with its expressions replaced."""
        if location[-1] in TEXTS and not {*location[:-1]} & {*BY_COORDINATE}:
            return value
        if isinstance(value, dict):
            return {key: self.replaced(entry, (*location, key)) for key, entry in value.items()}
        if isinstance(value, list):
            return [self.replaced(entry, (*location, number)) for number, entry in enumerate(value)]
        if not _is_expression(value):
            return value
        found: float = 1.0  # where it is wrong, so that the rest is read all the same
        with self._telling(place(location, self.data)):
            found = self._expressed(value.strip(), location)
        return found

    def _expressed(self, text: str, location: tuple) -> Expressed:
        tree = read_expression(text[1:])
        found = self._value(text, tree)
        self._use(tree, location)
        return Expressed(in_range(found.value, text), text, self._written_out(tree), found.dimension)

    def _value(self, text: str, tree: Expression) -> Measured:
        for name in tree.names():
            self._check(name, text)
        try:
            found = tree.value(Measured.written, {**self.known, **_PI})
        except InputError as problem:
            raise InputError(f"found {shown(text)}: {problem}") from None
        in_range(found.value, text)
        return found

    def _written_out(self, tree: Expression) -> Expression:
        """The expression in the parameters that are none themselves."""
        found = tree.replaced(self.trees)
        if found.size > MOST_PARTS:
            raise InputError(f"it has {found.size} parts with those of its parameters; expected at most {MOST_PARTS}")
        return found

    def _use(self, tree: Expression, location: tuple) -> None:
        """Remember which parameters stand in an expression, and which in those."""
        found = new = {*tree.names()} & self.known.keys()
        while new:
            inner = {name for each in new & self.expressions.keys() for name in self.expressions[each].names()}
            new = inner & self.known.keys() - found
            found = found | new
        self.used |= found
        self.places[tuple(part + 1 if isinstance(part, int) else part for part in location)] = frozenset(found)

    def _check(self, name: str, text: str) -> None:
        if name in self.known or name in _PI:
            return
        if name in self.given:  # it is wrong itself, which is told
            raise InputError(f'found {shown(text)}, but the parameter "{name}" is wrong')
        if not self.known:
            raise InputError(f'found {shown(text)}, but there is no parameter "{name}": give it a value in the table [parameters]')
        raise InputError(
            f'found {shown(text)}, but there is no parameter "{name}"{nearest(name, self.known)}; there are {", ".join(self.known)}'
        )


def _is_expression(value) -> bool:
    return isinstance(value, str) and value.lstrip().startswith("=")


def _in_order(expressions: dict[str, Expression]) -> tuple[str, ...]:
    """The names of expressions of each other, those that others need first."""
    needed = {name: [other for other in dict.fromkeys(tree.names()) if other in expressions] for name, tree in expressions.items()}
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


def _plain(value) -> Measured:
    number, dimension = any_quantity(value)
    return Measured(Fraction(repr(number)), dimension)
