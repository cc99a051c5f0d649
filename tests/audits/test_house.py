"""The house: imports run down the rooms, and heavy packages stay in theirs."""

from __future__ import annotations

import ast
import importlib
from collections import defaultdict
from graphlib import CycleError, TopologicalSorter

import mbconstrained as mb
from tests.audits.source import FILES, MODULES, expect_none, imports, room, tree

#: The rooms, lowest first. A file imports its own room and lower rooms.
LAYERS = (
    *("ground", "exchange", "linalg", "signals", "polynomial", "exact", "response", "frequency"),  # arrays in, arrays out
    *("control", "mechanics", "models", "robot"),
    *("page", "scene", "analyses", "cli", "docs", "__main__"),
)
LAYER = {name: number for number, name in enumerate(LAYERS)}

#: A run answers the questions of the tables of a scene, too: these files stand with the analyses.
WITH_ANALYSES = ("scene/run/", "scene/python_models.py")

#: Packages that only some scenes need, and the rooms that may import them.
HEAVY = {
    "pinocchio": {"robot"},
    "coal": {"robot"},
    "collada": {"robot"},
    "trimesh": {"robot"},
    "mujoco": {"robot"},
    "meshcat": {"page"},
    "sympy": {"exact"},
    "flint": {"exact", "frequency", "linalg"},
    "matplotlib": {"frequency", "page", "analyses"},
    "pydantic": {"scene", "analyses"},
    "typer": {"cli", "docs"},
    "rich": {"cli"},
}

below_top = [file for file in FILES if file != "__init__.py"]


def inner_imports(file):
    """The files of the package that a file imports."""
    return {MODULES[name] for name in imports(file) if name in MODULES} - {file}


def level(file):
    """The number of the layer of a file."""
    return LAYER["analyses" if file.startswith(WITH_ANALYSES) else room(file)]


def is_below(other, file):
    """Whether a file may import another one; the documentation alone reads the list of public names."""
    if other == "__init__.py":
        return room(file) == "docs"
    return room(other) == room(file) or level(other) < level(file) or level(other) == level(file) == LAYER["analyses"]


def test_imports_run_down_the_layers():
    """Late imports count; those for the type checker alone do not."""
    assert {room(file) for file in below_top} <= set(LAYER)
    upward = [f"{file} imports {other}" for file in below_top for other in sorted(inner_imports(file)) if not is_below(other, file)]
    expect_none(upward, "move the function down, or hand its result in")


def test_there_is_no_import_circle():
    circles, graph = [], {file: inner_imports(file) for file in below_top}
    while True:
        try:
            TopologicalSorter(graph).prepare()
        except CycleError as error:
            circle = error.args[1][::-1]
            circles.append(" imports ".join(circle))
            graph[circle[0]] = graph[circle[0]] - {circle[1]}  # without this import the next circle shows
        else:
            break
    expect_none(circles, "break the circle: what both need belongs into a lower file")


def test_heavy_packages_stay_in_their_rooms():
    outside = [
        f"{file} imports {package}"
        for file in FILES
        for package in sorted({name.split(".")[0] for name in imports(file)} & set(HEAVY))
        if room(file) not in HEAVY[package]
    ]
    expect_none(outside, "only its own room knows a heavy package")


def test_a_class_name_stands_once():
    places = defaultdict(list)
    for file in FILES:
        for node in tree(file).body:
            if isinstance(node, ast.ClassDef):
                places[node.name].append(file)
    expect_none(
        [f"{name}: {', '.join(files)}" for name, files in places.items() if len(files) > 1], "give each class a name of its own"
    )


def test_every_list_of_names_resolves():
    """``from mbconstrained.room import *`` works everywhere, and type checkers see the public names that there are."""
    missing = []
    for name in MODULES:
        if MODULES[name].endswith("__init__.py"):
            module = importlib.import_module(name)
            missing += [f"{name}.{listed}" for listed in getattr(module, "__all__", ()) if not hasattr(module, listed)]
    expect_none(missing, "list what there is")
    late = next(node for node in tree("__init__.py").body if isinstance(node, ast.If))
    for_checkers = {(alias.name, node.module or "") for node in late.body for alias in node.names if alias.asname == alias.name}
    assert for_checkers == {*mb._FILES.items(), ("exact", "")}
