"""Public names have full docstrings, and what any docstring shows is true."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import io
import re

import pytest

import mbconstrained as mb
from tests.audits.source import FILES, expect_none, has_decorator, module_name, public, room, tree
from tests.audits.test_house import LAYER

#: (file, name of a class or function) of the public names of the package: what ``mbconstrained.__all__`` lists.
OFFERED = {
    (inspect.getsourcefile(value).rpartition("mbconstrained/")[2], value.__name__)
    for value in (getattr(mb, name) for name in mb.__all__)
    if inspect.isclass(value) or inspect.isfunction(value)
}

#: Beginnings of docstrings that leave out their noun or their verb.
ELLIPTIC = re.compile(
    r"(?:Of|What|Those|The same|As of|As in|As there|As ``|Who|That|Its|Their|Likewise|How|From|With|Also)\b|As ``"
)


#: The classes of the package by name.
CLASSES = {node.name: node for file in FILES for node in tree(file).body if isinstance(node, ast.ClassDef)}


def documented(file):
    """(name, node, docstring) of the file itself and its public functions and classes."""
    yield "", tree(file), ast.get_docstring(tree(file)) or ""
    for name, node in public(file):
        if not has_decorator(node, "overload", "setter"):
            yield name, node, ast.get_docstring(node) or ""


def is_offered(file, name):
    """Whether a function, a class or a method is reached from the public names; a file itself is."""
    return not name or (file, name.split(".")[0]) in OFFERED


def test_every_public_thing_has_a_docstring_that_begins_with_a_sentence():
    offenders = [
        f"{file} {name}: {docstring.split(chr(10))[0]!r}"
        for file in FILES
        for name, _, docstring in documented(file)
        if (is_offered(file, name) and not docstring) or (docstring and docstring.split("\n\n")[0].rstrip()[-1] not in ".:;)")
    ]
    expect_none(offenders, "write one sentence that says what it is, with its full stop")


def test_no_docstring_begins_with_an_ellipsis():
    offenders = [
        f"{file}:{node.body[0].lineno} {' '.join(docstring.split())[:60]!r}"
        for file in FILES
        for node in ast.walk(tree(file))
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef))
        and ELLIPTIC.match(docstring := ast.get_docstring(node) or "")
    ]
    expect_none(offenders, "begin with the noun or the verb of what it is or does, complete without its neighbour")


def test_public_functions_of_several_arguments_describe_them():
    missing = []
    for file in FILES:
        for name, node, docstring in documented(file):
            if is_offered(file, name) and len(_arguments(node)) > 1:
                sections = ["Args:"] + ["Returns:"] * _returns(node)
                absent = [s for s in sections if s not in docstring and not ("Yields:" in docstring and s == "Returns:")]
                if absent:
                    missing.append(f"{file} {name} lacks {' and '.join(absent)}")
    expect_none(missing, "describe the arguments and the result")


def test_described_arguments_exist():
    offenders = []
    for file in FILES:
        for name, node, docstring in documented(file):
            known = set(_arguments(node)) | set(_fields(node))
            described = _described(docstring)
            if described - known:
                offenders.append(f"{file} {name} describes {', '.join(sorted(described - known))}")
    expect_none(offenders, "describe the arguments that there are")


class _Finder(doctest.DocTestFinder):
    """Finds the examples of decorated functions, too, whose globals are those of the decorator."""

    def _from_module(self, module, object):
        return super()._from_module(module, inspect.unwrap(object))


def test_examples_of_decorated_functions_are_found():
    names = {
        test.name.rpartition(".")[2]
        for test in _Finder().find(importlib.import_module("mbconstrained.signals.inputs"))
        if test.examples
    }
    assert {"step", "ramp", "harmonic", "pulse"} <= names


@pytest.mark.parametrize("place", ["__init__", *(name for name in LAYER if name != "__main__")])
def test_examples_in_docstrings_are_true(place):
    failures = []
    for file in FILES:
        if room(file) == place and not file.endswith(
            "conf.py"
        ):  # Sphinx executes its configuration, with what the extra [docs] brings
            report, runner = io.StringIO(), doctest.DocTestRunner(optionflags=doctest.NORMALIZE_WHITESPACE)
            for test in _Finder().find(importlib.import_module(module_name(file)), module_name(file)):
                runner.run(test, out=report.write)
            if runner.failures:
                failures.append(f"{file}\n{report.getvalue()}")
    expect_none(failures, "the examples must give what they show")


def test_public_names_are_documented_functions_and_classes():
    offenders = [
        name
        for name in mb.__all__
        if not (inspect.isclass(value := getattr(mb, name)) or inspect.isfunction(value) or inspect.ismodule(value))
        or not inspect.getdoc(value)
    ]
    expect_none(offenders, "a public name is a class, a function or a room with a docstring")


def _arguments(node) -> list[str]:
    if not isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)):
        return []
    arguments = node.args
    names = [a.arg for a in (*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs)]
    names += [a.arg for a in (arguments.vararg, arguments.kwarg) if a]
    return [name for name in names if name not in ("self", "cls")]


def _fields(node) -> list[str]:
    """What the constructor of a class takes: the arguments of ``__init__`` and the fields of a dataclass, those of its bases too."""
    if not isinstance(node, ast.ClassDef):
        return []
    inherited = [name for base in node.bases if ast.unparse(base) in CLASSES for name in _fields(CLASSES[ast.unparse(base)])]
    made = [name for part in node.body if getattr(part, "name", "") in ("__init__", "__new__") for name in _arguments(part)]
    return (
        inherited
        + made
        + [part.target.id for part in node.body if isinstance(part, ast.AnnAssign) and isinstance(part.target, ast.Name)]
    )


def _returns(node) -> bool:
    return node.returns is not None and ast.unparse(node.returns) not in ("None", "NoReturn")


def _described(docstring: str) -> set[str]:
    """The names that stand in the section ``Args:``, also several before one colon."""
    section = re.search(r"^Args:\n((?:[ \t]+.*\n?|\n)+)", docstring, re.MULTILINE)
    if not section:
        return set()
    entries = re.findall(r"^ {4}(\*{0,2}\w+(?:, \*{0,2}\w+)*)(?: \([^)]*\))?:", section[1], re.MULTILINE)
    return {name.strip("* ") for entry in entries for name in entry.split(",")}
