"""The package's files as the audits see them: texts and syntax trees; nothing is imported."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "mbconstrained"
FILES = sorted(path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py"))
Function = ast.FunctionDef | ast.AsyncFunctionDef


@cache
def text(file: str) -> str:
    return (PACKAGE / file).read_text(encoding="utf-8")


@cache
def tree(file: str) -> ast.Module:
    return ast.parse(text(file), filename=file)


def module_name(file: str) -> str:
    """``linalg/rank.py`` -> ``mbconstrained.linalg.rank``; a room's ``__init__.py`` has the name of the room."""
    return ".".join(["mbconstrained", *file.removesuffix(".py").split("/")]).removesuffix(".__init__")


MODULES = {module_name(file): file for file in FILES}


def room(file: str) -> str:
    """The folder at the top of the package that a file belongs to; a file at the top is its own room."""
    return file.split("/")[0].removesuffix(".py")


def import_statements(file: str) -> Iterator[ast.Import | ast.ImportFrom]:
    """All imports of a file that run: at the top, late in functions, but not those under ``if TYPE_CHECKING``."""
    waiting: list[ast.AST] = [tree(file)]
    while waiting:
        node = waiting.pop()
        if isinstance(node, (ast.Import, ast.ImportFrom)):
            yield node
        elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            waiting.extend(node.orelse)
        else:
            waiting.extend(ast.iter_child_nodes(node))


@cache
def imports(file: str) -> frozenset[str]:
    """Dotted names of all modules that a file imports, those of the package from its root, each name its deepest module."""
    folder = ["mbconstrained", *file.split("/")[:-1]]
    names = set()
    for node in import_statements(file):
        if isinstance(node, ast.Import):
            names.update(alias.name for alias in node.names)
        else:
            base = folder[: len(folder) - node.level + 1] if node.level else []
            origin = ".".join([*base, *([node.module] if node.module else [])])
            names.update(f"{origin}.{a.name}" if f"{origin}.{a.name}" in MODULES else origin for a in node.names)
    return frozenset(names)


@cache
def functions(file: str) -> tuple[Function, ...]:
    return tuple(node for node in ast.walk(tree(file)) if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)))


def public(file: str) -> Iterator[tuple[str, Function | ast.ClassDef]]:
    """(name, node) of the public functions, classes and their public methods of a file."""

    def visit(body: list[ast.stmt], prefix: str) -> Iterator[tuple[str, Function | ast.ClassDef]]:
        for node in body:
            if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
                yield prefix + node.name, node
                if isinstance(node, ast.ClassDef):
                    yield from visit(node.body, f"{node.name}.")

    return visit(tree(file).body, "")


def has_decorator(node: Function | ast.ClassDef, *names: str) -> bool:
    """Whether a decorator's last name (``overload``, ``x.setter``, ``typing.overload``) is one of these."""
    return any(ast.unparse(decorator).split("(")[0].split(".")[-1] in names for decorator in node.decorator_list)


def expect_none(offenders, advice: str) -> None:
    """Fail with one line for each offender and what to do about it."""
    lines = [str(offender) for offender in offenders]
    assert not lines, f"{advice} ({len(lines)}):\n" + "\n".join(lines)
