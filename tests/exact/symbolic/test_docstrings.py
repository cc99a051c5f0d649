"""What the docstrings of the symbolic engine show is true."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

from mbconstrained.exact import symbolic

MODULES = [symbolic.__name__, *(f"{symbolic.__name__}.{module.name}" for module in pkgutil.iter_modules(symbolic.__path__))]


@pytest.mark.parametrize("name", MODULES)
def test_examples_are_true(name):
    assert doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0
