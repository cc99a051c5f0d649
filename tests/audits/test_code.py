"""What no file of the package does: run data as code, swallow errors, hide tolerances, speak of machines."""

from __future__ import annotations

import ast
import re
import subprocess

import pytest

from tests.audits.source import FILES, ROOT, expect_none, imports, room, tree

NUMERICAL_ROOMS = {
    "linalg",
    "signals",
    "polynomial",
    "response",
    "frequency",
    "exact",
    "mechanics",
    "control",
    "models",
    "robot",
}

#: Modules with small named constants of their own. The list may only shrink.
OWN_CONSTANTS = {
    "linalg/scaling.py",
    "linalg/tree_modes.py",
    "response/estimate.py",
    "robot/description/urdf.py",
    "robot/statics.py",
    "robot/visualization.py",
    "signals/approximated.py",
}


@pytest.mark.long
def test_nothing_is_evaluated_as_code():
    offenders = []
    for file in FILES:
        offenders += [f"{file} imports {name}" for name in imports(file) if name.split(".")[0] in ("pickle", "marshal", "shelve")]
        for node in ast.walk(tree(file)):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("eval", "exec", "compile", "sympify", "__import__"):
                offenders.append(f"{file}:{node.lineno} {ast.unparse(node.func)}")
    expect_none(offenders, "scenes and models are data")


def test_no_exception_is_swallowed():
    """No bare except, and no handler that does nothing but pass."""
    offenders = [
        f"{file}:{node.lineno}"
        for file in FILES
        for node in ast.walk(tree(file))
        if isinstance(node, ast.ExceptHandler) and (node.type is None or all(isinstance(line, ast.Pass) for line in node.body))
    ]
    expect_none(offenders, "name the exception and answer it")


def test_objects_that_hold_arrays_are_equal_to_themselves_alone():
    """Fields that are arrays have no truth value and no hash: such an object compares and hashes by identity."""
    offenders = []
    for file in FILES:
        for node in ast.walk(tree(file)):
            if not isinstance(node, ast.ClassDef) or not any("frozen=True" in ast.unparse(mark) for mark in node.decorator_list):
                continue
            types = [ast.unparse(line.annotation) for line in node.body if isinstance(line, ast.AnnAssign)]
            holds = any(re.search(r"\bndarray\b|\bMatrix\b|\bNoisy\b", own) for own in types)
            if holds and not any("eq=False" in ast.unparse(mark) for mark in node.decorator_list):
                offenders.append(f"{file}:{node.lineno} {node.name}")
    expect_none(offenders, "add eq=False to the dataclass")


def test_algorithms_have_no_literal_tolerances():
    """Small numbers have a name and a reason in ground/tolerances.py, a few at the top of their own module."""
    offenders = []
    for file in (file for file in FILES if room(file) in NUMERICAL_ROOMS):
        constants = [node for node in tree(file).body if isinstance(node, (ast.Assign, ast.AnnAssign)) and file in OWN_CONSTANTS]
        named = {id(leaf) for node in constants for leaf in ast.walk(node)}
        literals = (node for node in ast.walk(tree(file)) if isinstance(node, ast.Constant) and id(node) not in named)
        small = (node for node in literals if isinstance(node.value, float) and 0 < abs(node.value) < 1e-3)
        offenders += [f"{file}:{node.lineno} {node.value!r}" for node in small]
    expect_none(offenders, "give the number a name and its reason in ground/tolerances.py")


def test_every_constant_is_defined_once():
    """A second definition of a name would silently replace the first."""
    offenders = []
    for file in FILES:
        targets = [
            target
            for line in tree(file).body
            if isinstance(line, ast.Assign)
            for target in (line.targets[0].elts if isinstance(line.targets[0], ast.Tuple) else line.targets)
        ]
        names = [target.id for target in targets if isinstance(target, ast.Name) and target.id.isupper()]
        offenders += [f"{file} {name}" for name in sorted(set(names)) if names.count(name) > 1]
    expect_none(offenders, "two quantities have two names")


def test_texts_name_no_machine_and_no_bookkeeping():
    """In nothing that is committed: paths of one machine, hosts of package registries, notes to oneself."""
    bookkeeping = re.compile(
        r"/(?:home|root|tmp|opt|mnt|work)/|\b(?:TO[D]O|FI[X]ME|XX[X])\b|\bissue \d+|\bpypi[.](?:org|python)|python[h]osted"
    )
    offenders = []
    for path in _committed_texts():
        lines = path.read_text(encoding="utf-8").splitlines()
        offenders += [
            f"{path.relative_to(ROOT)}:{k} {line.strip()[:80]}" for k, line in enumerate(lines, 1) if bookkeeping.search(line)
        ]
    expect_none(offenders, "the project speaks of itself alone")


def test_the_top_level_holds_what_belongs_there():
    """Packages, examples, tests, README, licence and dot files, but no logs of other programs."""
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    tops = {name.split("/")[0] for name in listed.stdout.splitlines()}
    belong = {"LICENSE", "README.md", "pyproject.toml", "mbconstrained", "robots", "tests", "examples"}
    expect_none(sorted(name for name in tops - belong if not name.startswith(".")), "leave it out, or name it in .gitignore")


def _committed_texts():
    suffixes = {".py", ".md", ".toml", ".css", ".html", ".urdf", ""}
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:  # an unpacked archive: everything in it was committed
        tops = ("mbconstrained", "tests", "examples", "robots", ".ci")
        paths = [path for top in tops for path in (ROOT / top).rglob("*")] + [ROOT / "README.md", ROOT / "pyproject.toml"]
    else:
        paths = [ROOT / name for name in listed.stdout.splitlines()]
    return [path for path in paths if path.is_file() and path.suffix in suffixes and "__pycache__" not in path.parts]
