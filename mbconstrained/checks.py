"""Checks at the door: turn what users pass into clean arrays, or say what is wrong with it."""

from __future__ import annotations

import difflib
import importlib
from collections import Counter
from collections.abc import Iterable, Sequence
from types import ModuleType

import numpy as np

from .errors import InputError, MissingPackage

#: With what users install the packages for exchange with others: python-control, xarray and pandas.
EXTRA = "mbconstrained[exchange]"


def nearest(word: str, known: Iterable[str]) -> str:
    """The closest known name as a hint to append to a message, or an empty string.

    >>> nearest("stifness", ["stiffness", "damping"])
    '; did you mean "stiffness"?'
    """
    match = difflib.get_close_matches(str(word), [str(k) for k in known], n=1, cutoff=0.6)
    return f'; did you mean "{match[0]}"?' if match else ""


def optional_package(name: str, what_for: str) -> ModuleType:
    """A package that only some users have, imported when it is asked for.

    Raises:
        MissingPackage: it is not installed.

    >>> optional_package("math", "to_numbers").sqrt(4.0)
    2.0
    """
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as problem:
        if problem.name != name.split(".")[0]:
            raise
        raise MissingPackage(f"{what_for} needs the package {problem.name}, which is not installed: pip install '{EXTRA}'") from None


def real_array(value, what: str, *, shape: tuple[int | None, ...] | None = None) -> np.ndarray:
    """A new float64 array of finite real numbers with the given shape (None: any length), or an InputError.

    >>> real_array([[1, 2], [3, 4]], "mass", shape=(2, 2))
    array([[1., 2.],
           [3., 4.]])
    """
    if hasattr(value, "toarray"):  # scipy.sparse
        value = value.toarray()
    try:
        array = np.asarray(value)
    except ValueError:
        raise InputError(f"{what}: the rows have different lengths; give a rectangular array of numbers") from None
    kind = array.dtype.kind
    if kind not in "biuf" and array.size:
        if kind == "c":
            raise InputError(f"{what}: complex numbers found; only real data is accepted")
        raise InputError(f"{what}: found {_sample(array)}; expected numbers")
    array = np.array(array, dtype=float)
    if shape is not None and not _fits(array.shape, shape):
        wanted = " x ".join("any" if n is None else str(n) for n in shape) or "a single number"
        found = " x ".join(map(str, array.shape)) or "a single number"
        raise InputError(f"{what}: expected shape {wanted}, found {found}")
    if not np.isfinite(array).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        found = f"the entry at {place} is {array[place]}; every entry must be" if place else f"found {array}; expected"
        raise InputError(f"{what}: {found} a finite number")
    return array


def real_number(value, what: str, *, positive: bool = False, minimum: float | None = None) -> float:
    """A finite float, optionally > 0 or >= minimum, or an InputError that says which.

    >>> real_number(2, "stiffness", positive=True)
    2.0
    """
    if isinstance(value, (bool, np.bool_)):
        raise InputError(f"{what}: found {value}; expected a number")
    number = float(real_array(value, what, shape=()))
    if positive and not number > 0:
        raise InputError(f"{what}: found {number:g}; expected a number greater than zero")
    if minimum is not None and number < minimum:
        raise InputError(f"{what}: found {number:g}; expected at least {minimum:g}")
    return number


def whole_number(value, what: str, *, minimum: int = 0) -> int:
    """An int >= minimum, or an InputError.

    >>> whole_number(3, "power")
    3
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < minimum:
        raise InputError(f"{what}: found {value!r}; expected a whole number of at least {minimum}")
    return int(value)


def evaluation_times(value) -> np.ndarray:
    """A time (shape ()) or times (T,) at which a function of t >= 0 is asked for, or an InputError.

    >>> evaluation_times([0, 1])
    array([0., 1.])
    """
    times = real_array(value, "time")
    if times.ndim > 1:
        raise InputError(f"time: expected a number or a list of numbers, found an array of shape {times.shape}")
    if times.size and times.min() < 0:
        raise InputError(f"time: found {times.min():g} s; the function is defined for t >= 0 (0 means 0+)")
    return times


def counted(count: int, one: str, several: str | None = None) -> str:
    """How many there are of something.

    >>> counted(1, "row"), counted(0, "row"), counted(2, "entry", "entries")
    ('1 row', '0 rows', '2 entries')
    """
    return f"{count} {one if count == 1 else several or one + 's'}"


def names_of(names, count: int, what: str, prefix: str) -> tuple[str, ...]:
    """A tuple of count distinct names; made from the prefix when none are given."""
    if names is None:
        return tuple(f"{prefix}{i + 1}" for i in range(count))
    if isinstance(names, str):
        raise InputError(f'{what}: found the text "{names}"; expected a list of names')
    names = tuple(map(str, names))
    if len(names) != count:
        raise InputError(f"{what}: {len(names)} names given for {count}; give one each")
    if len(set(names)) == count:
        return names
    repeated = sorted(name for name, count in Counter(names).items() if count > 1)
    raise InputError(f'{what}: the name "{repeated[0]}" is used twice; names must differ')


def constant_zeros(shape: tuple[int, ...]) -> np.ndarray:
    """Zeros that cannot be written to, of which there is one number in memory.

    >>> constant_zeros((2, 3)).any(), constant_zeros((2, 3)).shape
    (np.False_, (2, 3))
    """
    return np.ndarray(shape, float, bytes(8), 0, (0,) * len(shape))


def places_of(chosen: Iterable, names: Sequence[str], what: str) -> list[int]:
    """Where each one chosen, by its name or its number from 0, stands among the names, or an InputError.

    >>> places_of(["b", 0], ["a", "b"], "coordinate")
    [1, 0]
    """
    found = []
    for one in chosen:
        if isinstance(one, str):
            if one not in names:
                raise InputError(f'there is no {what} "{one}"{nearest(one, names)}')
            found.append(names.index(one))
        elif isinstance(one, bool) or not isinstance(one, (int, np.integer)) or not 0 <= one < len(names):
            raise InputError(f"{what}: found {one!r}; expected a name, or a whole number from 0 to {len(names) - 1}")
        else:
            found.append(int(one))
    if not found:
        raise InputError(f"{what}: none was named; give one or several of {', '.join(names[:6])}{', ...' * (len(names) > 6)}")
    return found


def _fits(found: tuple[int, ...], wanted: tuple[int | None, ...]) -> bool:
    return len(found) == len(wanted) and all(w is None or f == w for f, w in zip(found, wanted))


def _sample(array: np.ndarray) -> str:
    first = array.reshape(-1)[:1].tolist()[0]
    text = repr(first)
    if " at 0x" in text:  # where it lies in memory tells nobody what it is
        return f"an object of type {type(first).__name__}"
    return text if len(text) <= 60 else text[:57] + "..."
