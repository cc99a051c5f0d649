"""The house: arrows run downwards, files and functions stay small, texts of the package say nothing that they should not."""

from __future__ import annotations

import ast
import re

import pytest

from tests.audits.source import FILES, FLOORS, PACKAGE, imports, part, parts_imported, tree

#: The arrows that run up, late and on purpose: A.structure() and A.jordan_pairs() are methods of A, with exact=True too,
#: x.enclose() and y.expression() are methods of responses.
UPWARDS = {
    ("polynomial/matrix.py", "jordan"),
    ("polynomial/matrix.py", "exact"),
    ("response/response.py", "exact"),
    ("response/transfer/transfer_function.py", "exact"),
}

#: The packages that only some scenes need: each is imported by its own folder alone.
HEAVY = {
    "pinocchio": {"models"},
    "coal": {"models"},
    "meshcat": {"page"},
    "sympy": {"exact", "mechanics"},
    "flint": {"exact"},
    "matplotlib": {"page", "reports"},
    "pydantic": {"scene"},
    "pint": {"scene"},
    "typer": {"cli", "scene", "reports"},
    "rich": {"cli", "scene", "reports"},
}

below_top = [file for file in FILES if file != "__init__.py"]
floor_of = {name: number for number, floor in enumerate(FLOORS) for name in floor}


def test_every_part_stands_on_a_floor():
    assert {part(file) for file in below_top} <= set(floor_of)


@pytest.mark.parametrize("file", below_top)
def test_a_file_imports_its_own_folder_and_floors_below(file):
    mine = part(file)
    above = {name for name in parts_imported(file) if name != mine and floor_of[name] >= max(floor_of[mine], 1)}
    assert above == {name for place, name in UPWARDS if place == file}


@pytest.mark.parametrize("file", below_top)
def test_no_file_goes_through_the_top(file):
    """``from .. import PolynomialMatrix`` would reach everything."""
    through_top = {name for name in imports(file) if name.startswith("mbconstrained.") and name.count(".") == 1}
    assert {name.split(".")[1] for name in through_top} <= set(floor_of)
    assert "mbconstrained" not in imports(file) or through_top


@pytest.mark.parametrize("file", FILES)
def test_heavy_packages_are_imported_by_their_own_folder_only(file):
    used = {name.split(".")[0] for name in imports(file)} & set(HEAVY)
    assert not {package for package in used if part(file) not in HEAVY[package]}


@pytest.mark.parametrize("file", FILES)
def test_robots_are_the_only_place_of_pinocchio(file):
    used = {name.split(".")[0] for name in imports(file)} & {"pinocchio", "coal"}
    assert not used or file.startswith("models/robot/")


def test_the_mathematics_needs_numpy_and_scipy_only():
    allowed = {"numpy", "scipy", "threadpoolctl"}  # the last says how many threads the other two use
    for file in FILES:
        if floor_of.get(part(file), 99) <= floor_of["response"]:
            outside = {name.split(".")[0] for name in imports(file)} - {"mbconstrained", "__future__"}
            assert outside - _standard_library() <= allowed, file


@pytest.mark.parametrize("file", FILES)
def test_nothing_is_ever_evaluated_as_code(file):
    called = {node.func.id for node in ast.walk(tree(file)) if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)}
    assert not called & {"eval", "exec", "compile", "sympify", "__import__"}
    assert not {name.split(".")[0] for name in imports(file)} & {"pickle", "marshal", "shelve"}


@pytest.mark.parametrize("file", FILES)
def test_no_exception_is_swallowed(file):
    """No bare except, and no handler that does nothing but pass."""
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.ExceptHandler):
            assert node.type is not None, f"{file}:{node.lineno} bare except"
            assert not all(isinstance(line, ast.Pass) for line in node.body), f"{file}:{node.lineno} silent except"


@pytest.mark.parametrize("file", [file for file in FILES if floor_of.get(part(file), 99) <= floor_of["response"] and file != "tolerances.py"])
def test_algorithms_have_no_literal_tolerances(file):
    """Small numbers live in tolerances.py, or in a named constant of the module with its reason."""
    named = [node for node in tree(file).body if isinstance(node, (ast.Assign, ast.AnnAssign))]
    constants = {id(leaf) for node in named for leaf in ast.walk(node)}
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.Constant) and isinstance(node.value, float) and id(node) not in constants:
            assert node.value == 0 or abs(node.value) >= 1e-3, f"{file}:{node.lineno} {node.value}"


@pytest.mark.parametrize("file", FILES)
def test_files_stay_small(file):
    assert len((PACKAGE / file).read_text(encoding="utf-8").splitlines()) <= 350


def test_most_files_and_functions_are_short():
    """Nine functions in ten have at most 25 lines without their docstring."""
    lengths = sorted(
        node.end_lineno - node.body[_has_docstring(node)].lineno + 1 if len(node.body) > _has_docstring(node) else 0
        for file in FILES
        for node in ast.walk(tree(file))
        if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef))
    )
    assert lengths[int(0.9 * len(lengths))] <= 25


@pytest.mark.parametrize("file", FILES)
def test_texts_name_no_machine_and_no_bookkeeping(file):
    text = (PACKAGE / file).read_text(encoding="utf-8")
    for word in (r"/(?:home|root|tmp|opt|mnt)/", r"\bTODO\b", r"\bFIXME\b", r"#\d+\b(?![0-9a-fA-F])"):
        for match in re.finditer(word, text):
            line = text[: match.start()].count("\n")
            assert _is_colour(text, match), f"{file}:{line + 1} {match.group()}"


def _is_colour(text, match) -> bool:
    return bool(re.fullmatch(r"#[0-9a-fA-F]{3,8}", text[match.start() :].split('"')[0].split("'")[0].split(";")[0].strip()))


def _has_docstring(node) -> bool:
    return ast.get_docstring(node) is not None


def _standard_library() -> set[str]:
    import sys

    return set(sys.stdlib_module_names)
