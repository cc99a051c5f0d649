"""Names that users look up: attributes of public objects and arguments of functions."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from .errors import InputError, UnknownAttribute, WrongCall

#: Words of textbooks and of other packages for names of this one, the first of which that exists is proposed.
SYNONYMS = {
    **dict.fromkeys(("C", "c", "D"), ("damping",)),
    **dict.fromkeys(("F", "f", "load", "loads", "u"), ("force", "frequencies_hz", "input")),
    **dict.fromkeys(("K", "k"), ("stiffness",)),
    **dict.fromkeys(("M", "m"), ("mass",)),
    **dict.fromkeys(("a", "accelerations"), ("acceleration",)),
    **dict.fromkeys(("eigenvectors", "mode_shapes", "vectors"), ("shapes",)),
    **dict.fromkeys(("freq", "frequency", "frequencies", "freqs"), ("frequency_hz", "frequencies_hz", "natural_frequencies")),
    **dict.fromkeys(("initial", "position", "positions", "q", "q0", "x", "x0", "y"), ("displacement", "initial", "values")),
    **dict.fromkeys(("omega", "w", "wn"), ("natural_frequencies", "natural_frequency", "angular_frequency", "angular_frequencies")),
    **dict.fromkeys(("sigma", "std"), ("rms",)),
    **dict.fromkeys(("t", "time"), ("times",)),
    **dict.fromkeys(("v", "v0", "velocities"), ("velocity",)),
    **dict.fromkeys(("damping", "zeta", "xi"), ("damping_ratio", "damping_ratios")),
    **dict.fromkeys(("H", "response"), ("values",)),
    "Q": ("quality_factor",),
    **dict.fromkeys(("amplitude", "amplitudes", "value"), ("displacement_amplitudes", "vector")),
    **dict.fromkeys(("n", "num", "number"), ("count",)),
    **dict.fromkeys(("coordinates", "labels"), ("names",)),
    **dict.fromkeys(("unit",), ("units",)),
    **dict.fromkeys(("draw", "figure", "plot", "show"), ("plot", "view")),
    **dict.fromkeys(("export", "save", "to_csv", "to_file"), ("write", "write_page")),
}


def proposed(word: str, known: Iterable[str], instead: Mapping[str, str] | None = None) -> str:
    """The name that was meant, or a remark, as a hint to append to a message, or an empty string.

    >>> proposed("K", ["mass", "stiffness"]), proposed("t", [], {"t": "call it with times"})
    ('; did you mean "stiffness"?', '; call it with times')
    """
    from .checks import nearest

    known = list(known)
    meant = (instead or {}).get(word) or next((name for name in SYNONYMS.get(word, ()) if name in known), "")
    if not meant:
        return nearest(word, known)
    return f"; {meant}" if " " in meant else f'; did you mean "{meant}"?'


class Public:
    """A public object, whose unknown attributes are answered with the nearest name.

    A subclass may list expressions for attributes that are expected of it, or remarks, in ``_instead``, and the function that makes
    its objects in ``_factory``. If it has entries, their names are its ``names``, or ``_entries``.

    >>> class Spring(Public):
    ...     stiffness = 3.0
    >>> Spring().stifness
    Traceback (most recent call last):
    mbconstrained.ground.errors.UnknownAttribute: Spring has no attribute "stifness"; did you mean "stiffness"?
    >>> hasattr(Spring(), "k")
    False
    """

    _instead: ClassVar[Mapping[str, str]] = {}
    _factory: ClassVar[str] = ""

    if not TYPE_CHECKING:  # for type checkers an unknown attribute is an error

        def __getattr__(self, name: str):
            if hasattr(type(self), name):  # a property, in which another attribute was missing
                return object.__getattribute__(self, name)
            if name.startswith("_"):
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            raise UnknownAttribute(name, self._lacks)

    def _lacks(self, name: str) -> str:
        """The message on an attribute that does not exist."""
        from .checks import listed

        known = [own for own in dir(self) if not own.startswith("_")]
        has_entries = type(self).__getitem__ is not Public.__getitem__
        is_entry = has_entries and name in self._entries()
        hint = f'; it is an entry: ["{name}"]' if is_entry else proposed(name, known, self._instead)
        return f'{type(self).__name__} has no attribute "{name}"{hint or f"; there are {listed(known, 20)}"}'

    def _entries(self) -> Iterable[str]:
        return getattr(self, "names", ())

    def __getitem__(self, key) -> Any:
        from .checks import listed

        is_attribute = isinstance(key, str) and key.isidentifier() and hasattr(self, key)
        known = listed([own for own in dir(self) if not own.startswith("_")], 20)
        there = f"it has an attribute: .{key}" if is_attribute else f"its attributes are {known}"
        raise InputError(f"[{key!r}]: {type(self).__name__} has no entries; {there}")


Called = TypeVar("Called", bound=Callable)


def answering(called: Called) -> Called:
    """A function, or a class with its methods, whose calls with wrong arguments are answered with the nearest name.

    >>> @answering
    ... def spring(stiffness): return stiffness
    >>> spring(k=3.0)
    Traceback (most recent call last):
    mbconstrained.ground.errors.WrongCall: spring: there is no argument "k"; did you mean "stiffness"?
    """
    if isinstance(called, type):
        for name, function in list(vars(called).items()):
            if inspect.isfunction(function) and (name == "__init__" or not name.startswith("_")):
                setattr(called, name, answering(function))
        return called

    @wraps(called)
    def call(*args, **kwargs):
        try:
            return called(*args, **kwargs)
        except TypeError as problem:
            if problem.__traceback__.tb_next is not None:  # from within the function
                raise
            raise wrong_call(called, args, kwargs) from None

    return call  # type: ignore[return-value]  # it takes and returns what the function does


def wrong_call(function: Callable, args: tuple, kwargs: Mapping[str, Any], name: str = "") -> WrongCall:
    """The error of a call whose arguments are not those of the function."""
    from .checks import counted, listed

    parameters = list(inspect.signature(function).parameters.values())
    owner = args[0] if parameters and parameters[0].name == "self" else None
    if owner is not None:
        parameters, args = parameters[1:], args[1:]
    name = name or (type(owner).__name__ if function.__name__ == "__init__" else function.__name__)
    by_position = [one.name for one in parameters if one.kind is not one.KEYWORD_ONLY]
    missing = [one.name for one in parameters if one.default is one.empty and one.name not in {*by_position[: len(args)], *kwargs}]
    known = [one.name for one in parameters]
    unknown = [word for word in kwargs if word not in known]
    if factory := getattr(owner, "_factory", "") if function.__name__ == "__init__" else "":
        return WrongCall(f"{name}: it is made by {factory}")
    if unknown:
        takes = f"; it takes {listed(known, 20)}" if known else "; it takes none"
        return WrongCall(
            f'{name}: there is no argument "{unknown[0]}"{proposed(unknown[0], known, getattr(owner, "_instead", None)) or takes}'
        )
    if len(args) > len(by_position):
        by_name = [word for word in known if word not in by_position]
        further = f"; by name it takes {listed(by_name, 20)}" if by_name else ""
        return WrongCall(
            f"{name}: found {counted(len(args), 'argument')} without a name; expected at most {len(by_position)}{further}"
        )
    if twice := [word for word in by_position[: len(args)] if word in kwargs]:
        return WrongCall(f'{name}: "{twice[0]}" is given twice, without and with its name')
    return WrongCall(
        f"{name}: {' and '.join(missing)} {'is' if len(missing) == 1 else 'are'} missing; it takes {listed(known, 20)}"
    )
