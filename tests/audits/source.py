"""The package's files as the audits see them: syntax trees, nothing is imported."""

from __future__ import annotations

import ast
from functools import lru_cache
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "mbconstrained"
FILES = sorted(path.relative_to(PACKAGE).as_posix() for path in PACKAGE.rglob("*.py"))

#: The floors, lowest first. A file imports its own folder and floors below; parts on one floor do not import each other,
#: except on the ground.
FLOORS = (
    {"errors", "tolerances", "checks", "notices", "replacing"},
    {"linalg"},
    {"signals"},
    {"polynomial"},
    {"jordan"},
    {"response"},
    {"exact"},
    {"mechanics"},
    {"models"},
    {"page"},
    {"scene"},
    {"reports"},
    {"cli", "__main__"},
)


@lru_cache(maxsize=None)
def tree(file: str) -> ast.Module:
    """The syntax tree of a file of the package."""
    return ast.parse((PACKAGE / file).read_text(encoding="utf-8"), filename=file)


def part(file: str) -> str:
    """The folder or ground-floor module that a file belongs to."""
    return file.split("/")[0].removesuffix(".py")


def imports(file: str) -> set[str]:
    """Dotted names of all modules that a file imports anywhere in it, those of the package written from its root."""
    found: set[str] = set()
    folder = ["mbconstrained", *file.split("/")[:-1]]
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.Import):
            found.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = folder[: len(folder) - node.level + 1] if node.level else []
            module = ".".join([*base, *([node.module] if node.module else [])])
            found.add(module)
            found.update(f"{module}.{alias.name}" for alias in node.names)
    return found


def parts_imported(file: str) -> set[str]:
    """The parts of the package that a file imports."""
    inside = [name.split(".") for name in imports(file) if name.startswith("mbconstrained.")]
    return {name[1] for name in inside} & set.union(*FLOORS)
