"""Ceilings that only fall: the lines of each room, circles of imports, and the functions that three reference calls touch.

A number here is lowered when the code has become smaller. Where it must be raised, the commit says what for.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections import defaultdict

import pytest

from tests.audits.source import FILES, MODULES, ROOT, expect_none, room, text, tree

#: Lines of each room, blank ones and docstrings included. Frequency took the enclosures of variances from exact, mechanics the normal form and
#: the descriptor form from control; response, robot and scene the protocols and base classes with which no circle of imports is left; analyses the
#: studies of accuracy, stability and sweeps (7,241 lines in studies, 6,700 here), modes, frequency responses and sensitivities from scene and cli, plots
#: of frequency responses from page and formulas from scene; control and mechanics the formulas of the papers (313 lines of the room papers). Delays
#: (the method of steps, characteristic roots, exact responses, feedback elements) took 1,630 lines, most of them in response and polynomial. Matrices that are not
#: regular (Kronecker form, kernels over the rationals, other numbers of equations than coordinates) took 690 lines, 430 of them in polynomial.
LINES = {
    "__init__": 274,
    "__main__": 8,
    "analyses": 12798,
    "cli": 1076,
    "control": 2480,
    "docs": 498,
    "exact": 6844,
    "exchange": 1871,
    "frequency": 6161,
    "ground": 2500,
    "linalg": 5069,
    "mechanics": 17378,
    "models": 1939,
    "page": 5386,
    "polynomial": 3790,
    "response": 8497,
    "robot": 9346,
    "scene": 11375,
    "signals": 1897,
}

#: So far may a room be below its ceiling before that must be lowered.
SLACK = 0.02

#: Files in the largest circle of imports, those for the type checker alone included: a file alone.
LARGEST_CIRCLE = 1

#: Classes that get a method from a file above them, as "class.method" in the package's __init__.
INJECTED: set[str] = set()

#: Functions of the package that a call touches; bodies of modules and of classes, which imports run, are not functions (their code has no
#: flag CO_OPTIMIZED, 1).
TOUCHED = {
    "run": ("import mbconstrained as mb; scene = mb.read_scene('examples/two_masses.toml'); result = scene.run(None); result.summary()", 585),
    "solve": ("import numpy as np, mbconstrained as mb; x = mb.MechanicalSystem(np.eye(2), stiffness=[[2, -1], [-1, 2]]).solve([1, 0]); x(np.linspace(0, 9, 50))", 215),
    "modes": ("import numpy as np, mbconstrained as mb; mb.MechanicalSystem(np.eye(2), stiffness=[[2, -1], [-1, 2]]).modes().frequencies_hz", 55),
}  # fmt: skip

COUNT = """
import sys
seen = set()
def profile(frame, event, argument):
    code = frame.f_code
    if event == "call" and code.co_flags & 1 and "mbconstrained" in code.co_filename and not code.co_name.startswith("<"):
        seen.add((code.co_filename, code.co_name, code.co_firstlineno))
sys.setprofile(profile)
{call}
sys.setprofile(None)
print(len(seen))
"""


def lines_by_room() -> dict[str, int]:
    lines: dict[str, int] = defaultdict(int)
    for file in FILES:
        lines[room(file)] += text(file).count("\n")
    return dict(lines)


def test_no_room_grows():
    now = lines_by_room()
    assert now.keys() == LINES.keys()
    grown = [f"{name}: {now[name]} lines, ceiling {LINES[name]}" for name in LINES if now[name] > LINES[name]]
    expect_none(grown, "make it smaller, or raise the ceiling and say what for")
    shrunk = [f"{name}: {now[name]} lines, ceiling {LINES[name]}" for name in LINES if now[name] < (1 - SLACK) * LINES[name] - 20]
    expect_none(shrunk, "lower the ceiling")


def largest_circle() -> int:
    """Files in the largest strongly connected part of all imports, by Tarjan's algorithm of SciPy."""
    import numpy as np
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    number = {file: place for place, file in enumerate(FILES)}
    pairs = [(number[file], number[other]) for file in FILES for other in _every_import(file) if other != file]
    rows, columns = np.array(pairs).T
    graph = coo_array((np.ones(len(pairs)), (rows, columns)), shape=(len(FILES),) * 2)
    _, labels = connected_components(graph, connection="strong")
    return int(np.bincount(labels).max())


def _every_import(file: str) -> set[str]:
    folder = ["mbconstrained", *file.split("/")[:-1]]
    found = set()
    for node in ast.walk(tree(file)):
        if isinstance(node, ast.ImportFrom) and node.level:
            origin = ".".join([*folder[: len(folder) - node.level + 1], *([node.module] if node.module else [])])
            found |= {MODULES[name] for name in (origin, *(f"{origin}.{alias.name}" for alias in node.names)) if name in MODULES}
    return {other for other in found if not other.endswith("__init__.py")}


def test_circles_of_imports_do_not_grow():
    assert largest_circle() <= LARGEST_CIRCLE


def test_nothing_more_is_injected_from_above():
    assigned = {
        ast.unparse(target)
        for node in tree("__init__.py").body
        if isinstance(node, ast.Assign)
        for target in node.targets
        if isinstance(target, ast.Attribute)
    }
    assert assigned <= INJECTED


@pytest.mark.parametrize("name", TOUCHED)
def test_reference_calls_touch_no_more_functions(name):
    call, most = TOUCHED[name]
    done = subprocess.run([sys.executable, "-c", COUNT.format(call=call)], cwd=ROOT, capture_output=True, text=True, check=True)
    assert int(done.stdout.split()[-1]) <= most


def test_a_motion_has_few_public_names():
    import mbconstrained as mb

    motion = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]]).solve([1.0])
    assert sum(not name.startswith("_") for name in dir(motion)) <= 40
