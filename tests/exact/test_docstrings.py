"""Examples in docstrings of the exact engine are true: its files import sympy or flint, which the audits leave out."""

import doctest
import importlib
import pkgutil

import pytest

from mbconstrained import exact

MODULES = [module.name for module in pkgutil.walk_packages(exact.__path__, f"{exact.__name__}.")]


@pytest.mark.parametrize("name", MODULES)
def test_examples_are_true(name):
    assert doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0


def test_examples_of_internal_functions_are_true():
    assert doctest.testfile("examples.txt", optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0
