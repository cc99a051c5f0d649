"""The [parameters] of a scene: quantities with names, and the texts "=…" elsewhere in the scene that use them."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from fractions import Fraction

from ..checks import nearest
from ..errors import InputError, SceneError
from ..notices import Notice
from .dimensions import Dimension, unit_of
from .expressed import Expressed
from .expressions import read_expression
from .measured import Measured
from .problems import place, together
from .units import any_quantity, in_range, shown

MOST_PARAMETERS = 200
TEXTS = ("title", "source", "note", "name", "file", "array")  # keys of texts, which no number can stand for
BY_COORDINATE = ("displacement", "velocity", "rows", "moves", "turns")  # tables whose keys are names that somebody chose
RESERVED = {"t": "t is the time", "pi": "pi is the number 3.14159…", "π": "π is the number 3.14159…"}
_NAME = re.compile(r"[^\W\d_]\w{0,39}")
_PI = {"pi": Measured(Fraction(math.pi), None, True)}


@dataclass(frozen=True)
class Parameters:
    """The parameters of a scene.

    Attributes:
        values: in SI, by name, in the order of the file.
        dimensions: kinds of quantity by name; None for plain numbers, which may be anything in SI.
        unused: the names of those that stand in no expression.
    """

    values: dict[str, float] = field(default_factory=dict)
    dimensions: dict[str, Dimension | None] = field(default_factory=dict)
    unused: tuple[str, ...] = ()

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
    values = {name: float(value.value) for name, value in work.known.items()}
    unused = tuple(name for name in values if name not in work.used)
    return found, Parameters(values, {name: value.dimension for name, value in work.known.items()}, unused)


class _Substitution:
    """What is known of the parameters while the tables are gone through."""

    def __init__(self, data: dict):
        self.data = data
        self.problems: list[str] = []
        self.used: set[str] = set()
        self.known: dict[str, Measured] = {}
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
            try:
                self.known[name] = _parameter(name, value)
            except InputError as problem:
                self.problems.append(f"parameters.{name}: {problem}" if name.isprintable() else f"parameters: {problem}")

    def replaced(self, value, location: tuple):
        """The value with its expressions replaced."""
        if location[-1] in TEXTS and not {*location[:-1]} & {*BY_COORDINATE}:
            return value
        if isinstance(value, dict):
            return {key: self.replaced(entry, (*location, key)) for key, entry in value.items()}
        if isinstance(value, list):
            return [self.replaced(entry, (*location, number)) for number, entry in enumerate(value)]
        if not isinstance(value, str) or not value.lstrip().startswith("="):
            return value
        try:
            return self._expressed(value.strip())
        except InputError as problem:
            self.problems.append(f"{place(location, self.data)}: {problem}")
            return 1.0

    def _expressed(self, text: str) -> Expressed:
        tree = read_expression(text[1:])
        for name in tree.names():
            self._check(name, text)
        self.used.update(tree.names())
        try:
            found = tree.value(Measured.written, {**self.known, **_PI})
        except InputError as problem:
            raise InputError(f"found {shown(text)}: {problem}") from None
        return Expressed(in_range(found.value, text), text, tree, found.dimension)

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


def _parameter(name: str, value) -> Measured:
    if not (_NAME.fullmatch(name) and name.isidentifier()):
        raise InputError(f"found the name {shown(name)}; expected a letter, then at most 39 letters, digits or _")
    if name in RESERVED:
        raise InputError(f"{RESERVED[name]}; choose another name")
    if isinstance(value, str) and value.lstrip().startswith("="):
        raise InputError(f'found {shown(value)}; a parameter is a plain quantity, e.g. 2.0 or "10 kg"')
    number, dimension = any_quantity(value)
    return Measured(Fraction(repr(number)), dimension)
