"""Validation of arguments: converts them to arrays and numbers, or raises an InputError with what was found and expected."""

from __future__ import annotations

import difflib
import importlib
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from operator import attrgetter
from types import ModuleType

import numpy as np

from .errors import InputError, MissingPackage, UnknownIndex

#: The extra with the packages for data exchange, as it is installed in the folder of a checkout.
EXTRA = ".[exchange]"


#: Remedy where a function of time is passed in place of an input.
OF_FUNCTION = "; an input is made of a function of time by mb.approximated(function, end)"


def nearest(word: str, known: Iterable[str]) -> str:
    """The closest known name as a hint to append to a message, or an empty string; a word of the same letters alone is not near.

    >>> nearest("stifness", ["stiffness", "damping"]), nearest("ratio", ["radii"])
    ('; did you mean "stiffness"?', '')
    """
    word = str(word)
    similar = difflib.get_close_matches(word, [str(k) for k in known], n=3, cutoff=0.6)
    allowed = {one: 1 + sum(max(len(word), len(one)) > length for length in (5, 9)) for one in similar}
    match = next((one for one in similar if _mistakes(word, one) <= allowed[one]), "")
    return f'; did you mean "{match}"?' if match else ""


def check_known(value, known: Iterable[str], what: str) -> None:
    """Refuse what is not one of the known words.

    >>> check_known("linear", ("linear", "steps"), "interpolation")
    """
    words = list(known)
    if not (isinstance(value, str) and value in words):
        raise InputError(f"{what}: found {value!r}; expected one of {', '.join(words)}{nearest(str(value), words)}")


def _mistakes(word: str, other: str) -> int:
    """The number of letters that are added, left out, replaced or exchanged with the next one (Damerau 1964), capitals aside."""
    word, other = word.casefold(), other.casefold()
    before, last = [0] * (len(other) + 1), list(range(len(other) + 1))
    for i, letter in enumerate(word):
        row = [i + 1]
        for j, its in enumerate(other):
            row.append(min(last[j + 1] + 1, row[j] + 1, last[j] + (letter != its)))
            if i and j and (letter, word[i - 1]) == (other[j - 1], its):
                row[-1] = min(row[-1], before[j - 1] + 1)
        before, last = last, row
    return last[-1]


def optional_package(name: str, what_for: str) -> ModuleType:
    """An optional package, imported on demand; NumPy prints as before, whatever the package sets (pyyeti sets a legacy mode).

    >>> optional_package("math", "to_numbers").sqrt(4.0)
    2.0
    """
    options = np.get_printoptions()
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as problem:
        package = name.split(".")[0]
        if problem.name.split(".")[0] != package:
            raise
        raise MissingPackage(
            f"{what_for} needs the package {package}, which is not installed; in the folder of the checkout: pip install '{EXTRA}'"
        ) from None
    finally:
        np.set_printoptions(**options)


def is_sparse(value) -> bool:
    """``scipy.sparse.issparse``, which need not be imported where no matrix can be sparse."""
    if isinstance(value, np.ndarray) or "scipy.sparse" not in sys.modules:
        return False
    return sys.modules["scipy.sparse"].issparse(value)


def real_array(value, what: object, *, shape: tuple[int | None, ...] | None = None) -> np.ndarray:
    """A new float64 array of finite real numbers.

    >>> real_array([[1, 2], [3, 4]], "mass", shape=(2, 2))
    array([[1., 2.],
           [3., 4.]])
    """
    if is_sparse(value):
        value = value.toarray()
    if callable(value):
        own = type(value).__module__.startswith(__package__.partition(".")[0])
        kind_text, advice = (f"an object of type {type(value).__name__}", "") if own else ("a Python function", OF_FUNCTION)
        raise InputError(f"{what}: found {kind_text}; expected numbers{advice}")
    try:
        array = np.asarray(value)
    except ValueError:
        raise InputError(f"{what}: the rows have different lengths; give a rectangular array of numbers") from None
    kind = array.dtype.kind
    if kind not in "biuf" and array.size:
        if kind == "c":
            raise InputError(f"{what}: complex numbers found; only real data is accepted")
        is_quantity = kind == "U" and array.ndim == 0 and str(array)[:1].isdigit()
        advice = " in SI units without quotes; texts with units belong to scene files" if is_quantity else ""
        raise InputError(f"{what}: found {_sample(array)}; expected {'a number' if is_quantity else 'numbers'}{advice}")
    array = np.array(array, dtype=float)
    if shape is not None and not (array.ndim == len(shape) and all(w in (None, n) for n, w in zip(array.shape, shape))):
        wanted = " x ".join("any" if n is None else str(n) for n in shape) or "a single number"
        actual = " x ".join(map(str, array.shape)) or "a single number"
        raise InputError(f"{what}: expected shape {wanted}, found {actual}")
    if not np.isfinite(array).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        problem = f"the entry at {place} is {array[place]}; every entry must be" if place else f"found {array}; expected"
        raise InputError(f"{what}: {problem} a finite number")
    return array


def real_number(value, what: object, *, positive: bool = False, minimum: float | None = None) -> float:
    """A finite float, optionally greater than 0 or at least a minimum; otherwise an InputError.

    >>> real_number(2, "stiffness", positive=True)
    2.0
    """
    if isinstance(value, (bool, np.bool_)):
        raise InputError(f"{what}: found {value}; expected a number")
    is_number = isinstance(value, (int, float)) and -np.inf < value < np.inf
    number = float(value) if is_number else float(real_array(value, what, shape=()))
    if positive and not number > 0:
        raise InputError(f"{what}: found {number:g}; expected a number greater than zero")
    if minimum is not None and number < minimum:
        raise InputError(f"{what}: found {number:g}; expected at least {minimum:g}")
    return number


def whole_number(value, what: str, *, minimum: int = 0) -> int:
    """A whole number of at least a minimum; otherwise an InputError.

    >>> whole_number(3, "power")
    3
    """
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < minimum:
        raise InputError(f"{what}: found {value!r}; expected a whole number of at least {minimum}")
    return int(value)


def evaluation_times(value) -> np.ndarray:
    """A time (shape ()) or times (T,) of a function of t >= 0; otherwise an InputError.

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
    """A count with its noun in the singular or plural.

    >>> counted(1, "row"), counted(0, "row"), counted(2, "entry", "entries")
    ('1 row', '0 rows', '2 entries')
    """
    return f"{count} {one if count == 1 else several or one + 's'}"


def listed(names: Sequence[str], most: int = 3, what: str = "") -> str:
    """The first names; the others are counted.

    >>> listed("abc"), listed("abcdef", 2, " rows")
    ('a, b, c', 'a, b and 4 more rows')
    """
    return ", ".join(names[:most]) + (f" and {len(names) - most} more{what}" if len(names) > most else "")


def names_of(names, count: int, what: str, prefix: str) -> tuple[str, ...]:
    """A tuple of distinct names, numbered from the prefix where none are given.

    >>> names_of(None, 2, "names", "x")
    ('x1', 'x2')
    """
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
    """A read-only array of zeros that needs the memory of one number.

    >>> constant_zeros((2, 3)).any(), constant_zeros((2, 3)).shape
    (np.False_, (2, 3))
    """
    return np.ndarray(shape, float, bytes(8), 0, (0,) * len(shape))


def places_of(chosen: Iterable, names: Sequence[str], what: str) -> list[int]:
    """The indices of items that are chosen by name or by index; an InputError for others.

    >>> places_of(["b", 0], ["a", "b"], "coordinate")
    [1, 0]
    """
    indices = []
    for one in chosen:
        if isinstance(one, str):
            if one not in names:
                raise InputError(f'there is no {what} "{one}"{nearest(one, names) or f"; there are {listed(names, 20)}"}')
            indices.append(names.index(one))
        elif isinstance(one, bool) or not isinstance(one, (int, np.integer)) or not 0 <= one < len(names):
            raise InputError(f"{what}: found {one!r}; expected a name, or a whole number from 0 to {len(names) - 1}")
        else:
            indices.append(int(one))
    if not indices:
        raise InputError(f"{what}: none was named; give one or several of {', '.join(names[:6])}{', ...' * (len(names) > 6)}")
    return indices


def item_of(index, count: int, what: str) -> int:
    """The place in a sequence of so many items, counted from its end where it is negative; otherwise an error.

    >>> item_of(-1, 3, "mode")
    2
    """
    if isinstance(index, bool) or not isinstance(index, (int, np.integer)):
        raise InputError(f"{what}: found {index!r}; expected a whole number or a slice")
    if not -count <= index < count:
        raise UnknownIndex(f"{what}: found {index}; there {'is' if count == 1 else 'are'} {count}, counted from 0")
    return range(count)[index]


def _sample(array: np.ndarray) -> str:
    first = array.reshape(-1)[:1].tolist()[0]
    text = repr(first)
    if " at 0x" in text:  # a memory address has no meaning for users
        return f"an object of type {type(first).__name__}"
    return text if len(text) <= 60 else text[:57] + "..."


def is_table(value) -> bool:
    """Whether values have a leading axis for several motions."""
    try:
        return np.ndim(value) == 2
    except ValueError:  # rows of different lengths, which is an error later
        return False


class ReadOnly(Mapping):
    """An immutable mapping that, unlike ``types.MappingProxyType``, can be pickled.

    >>> ReadOnly({"a": 1})["a"], len(ReadOnly({}))
    (1, 0)
    """

    def __init__(self, entries: Mapping):
        self._entries = dict(entries)

    def __getitem__(self, key):
        return self._entries[key]

    def __iter__(self):
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    keys, values = (property(attrgetter(f"_entries.{name}")) for name in ("keys", "values"))  # Mapping's own look up every name

    def __repr__(self) -> str:
        return repr(self._entries)


class NamedNumbers(ReadOnly):
    """The entries of an array by name; Python's numbers only when they are read.

    >>> NamedNumbers(("a", "b"), np.array([1.0, 2.0]))
    {'a': 1.0, 'b': 2.0}
    """

    def __init__(self, names: Sequence[str], numbers: np.ndarray):
        self._names, self._numbers = names, numbers

    @cached_property
    def _entries(self) -> dict[str, float]:  # type: ignore[override]  # computed at the first reading
        return dict(zip(self._names, self._numbers.tolist()))
