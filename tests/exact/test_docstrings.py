"""What the docstrings of the exact engine show is true: its files import sympy or flint, which the audits leave out; so do those of the papers."""

import doctest
import importlib
import pkgutil

import pytest

from mbconstrained import exact

MODULES = [module.name for module in pkgutil.walk_packages(exact.__path__, f"{exact.__name__}.")]
ORACLES = [f"tests.oracles.papers.{name}" for name in ("apostol_kolodner", "corollaries", "matrix_exponentials")]


@pytest.mark.parametrize("name", [*MODULES, *ORACLES])
def test_examples_are_true(name):
    assert doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0


def test_examples_of_internal_functions_are_true():
    assert doctest.testfile("examples.txt", optionflags=doctest.NORMALIZE_WHITESPACE).failed == 0
