"""Arrays whose entries have names."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from .checks import listed, nearest
from .errors import InputError


class NamedArray(np.ndarray):
    """An array with names along its leading axes: ``values["cart"]``, ``values["cart", "base"]``, ``values[["cart", "load"]]``.

    In everything else it is the array of its numbers; parts of it and results of arithmetic are arrays without names.

    Attributes:
        names: those along the first axis, the second ...; an empty tuple for an axis without names.

    >>> rms = named_array([1.5, 2.5], ("cart", "load"))
    >>> rms["load"], rms[0], 2 * rms, rms.names
    (np.float64(2.5), np.float64(1.5), array([3., 5.]), (('cart', 'load'),))
    >>> rms["lod"]
    Traceback (most recent call last):
    mbconstrained.ground.errors.InputError: there is no "lod"; did you mean "load"?; there are cart, load
    """

    names: tuple[tuple[str, ...], ...] = ()

    def __getitem__(self, key) -> Any:
        if isinstance(key, (str, list)):  # along the first axis with names
            key = (*(slice(None) for _ in itertools.takewhile(lambda own: not own, self.names)), key)
        if isinstance(key, tuple):
            key = tuple(self._places(axis, one) if isinstance(one, (str, list)) else one for axis, one in enumerate(key))
        return self.view(np.ndarray)[key]

    def _places(self, axis: int, key):
        """The index of a name along an axis, or those of a list; numbers unchanged."""
        if isinstance(key, list):
            return [self._places(axis, one) for one in key]
        if not isinstance(key, str):
            return key
        known = self.names[axis] if axis < len(self.names) else ()
        if key not in known:
            there = f"there are {listed(known, 12)}" if known else f"these numbers have no names along axis {axis}"
            raise InputError(f'there is no "{key}"{nearest(key, known)}; {there}')
        return known.index(key)

    def __array_wrap__(self, array, context=None, return_scalar=False):
        return array[()] if return_scalar else array

    def __reduce__(self):
        return named_array, (self.view(np.ndarray), *self.names)

    def __repr__(self) -> str:
        return repr(self.view(np.ndarray))


def named_array(values, *names: tuple[str, ...]) -> NamedArray:
    """The values with the names along their leading axes."""
    array = np.asarray(values).view(NamedArray)
    array.names = names
    return array
