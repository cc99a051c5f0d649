"""What the docstrings of the exact engine show is true: its files import sympy or flint, which the audits leave out."""

from __future__ import annotations

import doctest
import importlib
import pkgutil

import pytest

from mbconstrained import exact

MODULES = [module.name for module in pkgutil.walk_packages(exact.__path__, f"{exact.__name__}.")]


@pytest.mark.parametrize("name", MODULES)
def test_examples_are_true(name):
    assert doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0
