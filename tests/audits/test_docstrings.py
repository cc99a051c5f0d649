"""Every public thing says what it is, and what the docstrings show is true."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect

import pytest

import mbconstrained as mb
from tests.audits.source import FILES, imports, tree
from tests.audits.test_layers import HEAVY

#: Files whose import, or whose examples, need one of the heavy packages: their examples run in their own tests.
light = [file for file in FILES if not {name.split(".")[0] for name in imports(file)} & set(HEAVY)]
modules = [("mbconstrained." + file.removesuffix(".py").replace("/", ".")).removesuffix(".__init__") for file in light if file != "__main__.py"]


def public(nodes, prefix=""):
    """(name, node) of public functions, classes and their public methods."""
    for node in nodes:
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
            yield prefix + node.name, node
            if isinstance(node, ast.ClassDef):
                yield from public(node.body, f"{node.name}.")


@pytest.mark.parametrize("file", FILES)
def test_every_public_thing_has_a_docstring(file):
    assert ast.get_docstring(tree(file)), f"{file} has no docstring"
    missing = [name for name, node in public(tree(file).body) if ast.get_docstring(node) is None and not _is_overload(node)]
    assert missing == []


@pytest.mark.parametrize("file", FILES)
def test_docstrings_begin_with_a_sentence(file):
    for name, node in public(tree(file).body):
        first = (ast.get_docstring(node) or "x.").split("\n\n")[0].strip()
        assert first and first[-1] in ".:;)", f"{file}: {name}: {first!r}"


@pytest.mark.parametrize("name", modules)
def test_examples_in_docstrings_are_true(name):
    result = doctest.testmod(importlib.import_module(name), optionflags=doctest.NORMALIZE_WHITESPACE)
    assert result.failed == 0


def test_public_names_are_documented_functions_and_classes():
    for name, value in vars(mb).items():
        if name.startswith("_") or inspect.ismodule(value) or name == "annotations":
            continue
        assert inspect.isclass(value) or inspect.isfunction(value), name
        assert inspect.getdoc(value), name


def test_the_promised_names_are_there():
    promised = """PolynomialMatrix solve Response BohlFunction ImpulsiveSmooth step ramp power impulse harmonic term zero
    MbconstrainedError InputError SceneError SingularPolynomialMatrix ContradictoryConstraints NotUnique Overflow Notice
    sampled pulse approximated Event Blow admissible Admissibility ElementMatrix MechanicalSystem Constraint LumpedModel read_scene""".split()
    assert [name for name in promised if not hasattr(mb, name)] == []


def _is_overload(node) -> bool:
    return any(isinstance(d, ast.Name) and d.id in ("overload", "setter") for d in getattr(node, "decorator_list", []))
