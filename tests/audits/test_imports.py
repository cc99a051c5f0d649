"""Importing the package is light: what a scene does not need is not loaded."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"

HEAVY = [
    "pinocchio",
    "coal",
    "collada",
    "trimesh",
    "mujoco",
    "meshcat",
    "sympy",
    "flint",
    "matplotlib",
    "pydantic",
    "typer",
    "rich",
    "control",
    "xarray",
    "pandas",
]


def loaded_by(statement: str) -> set[str]:
    """Top-level names of all modules in memory after a statement in a fresh interpreter."""
    script = f"import sys\n{statement}\nprint(' '.join({{name.split('.')[0] for name in sys.modules}}))"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return set(done.stdout.split())


@pytest.mark.parametrize(
    "statement",
    [
        "import mbconstrained",
        "import mbconstrained as mb; mb.solve(mb.PolynomialMatrix([[[1.0]], [[1.0]]]), [[1.0]])(1.0)",
    ],
    ids=["import", "solve"],
)
def test_the_mathematics_loads_nothing_heavy(statement):
    loaded = loaded_by(statement)
    assert ("numpy" in loaded) == ("solve" in statement)
    assert not loaded & set(HEAVY)


@pytest.mark.parametrize("options", [["--help"], ["run", "--help"]])
def test_help_loads_no_mathematics(options):
    statement = f"from mbconstrained import cli; sys.argv = ['mbconstrained', *{options}]; import io; out, sys.stdout = sys.stdout, io.StringIO()"
    loaded = loaded_by(f"{statement}\ntry: cli.main()\nexcept SystemExit as left: assert not left.code\nsys.stdout = out")
    assert not loaded & {"numpy", "scipy", "flint", "rich"}


def test_importing_leaves_out_the_parts_of_scipy_that_few_need():
    script = "import mbconstrained, sys; print(*[name for name in ('scipy.optimize', 'scipy.signal') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_importing_has_no_side_effect_on_numpy():
    """Error handling, print options and the random state are the user's."""
    script = (
        "import numpy as np; before = (np.geterr(), np.get_printoptions()); state = np.random.get_state()[1].tolist(); "
        "import mbconstrained; assert before == (np.geterr(), np.get_printoptions()); "
        "assert state == np.random.get_state()[1].tolist()"
    )
    subprocess.run([sys.executable, "-c", script], check=True, capture_output=True)


@pytest.mark.long
@pytest.mark.parametrize(
    ("command", "scene", "needed"),
    [
        ("check", "", {"pydantic", "typer"}),
        ("plan", "", {"pydantic", "typer"}),
        ("check", "two_masses", {"pydantic", "typer"}),
        ("plan", "two_masses_formula", {"pydantic", "typer"}),
        ("check", "pendulum", {"pydantic", "typer", "pinocchio", "coal"}),
        ("plan", "pendulum", {"pydantic", "typer", "pinocchio", "coal"}),
    ],
)
def test_check_and_plan_load_what_reading_the_scene_needs(tmp_path, command, scene, needed):
    """No page, no symbols, no proofs, no plots; rich only in a terminal."""
    path = EXAMPLES / f"{scene}.toml" if scene else tmp_path / "plain.toml"
    if not scene:
        path.write_text('[model]\nkind = "matrices"\nmass = [[1]]\nstiffness = [[1]]\n[time]\nend = 1\n', encoding="utf-8")
    run = f"from mbconstrained import cli; sys.argv = ['mbconstrained', {command!r}, {str(path)!r}]"
    silent = "import io\nout, sys.stdout = sys.stdout, io.StringIO()"
    left = "try: cli.main()\nexcept SystemExit as left: assert not left.code\nsys.stdout = out"
    assert loaded_by(f"{run}\n{silent}\n{left}") & set(HEAVY) == needed


@pytest.mark.parametrize(
    "options",
    [["check", "two_masses"], ["check", "chatter"], ["check", "sampled_quarter_car"], ["run", "two_masses"]],
    ids=" ".join,
)
def test_scenes_without_modes_robots_or_sparse_matrices_load_no_linear_algebra_of_scipy(tmp_path, options):
    """Its import takes longer than such a run."""
    command, scene = options
    arguments = [command, str(EXAMPLES / f"{scene}.toml"), *(["--out", str(tmp_path)] if command == "run" else [])]
    script = (
        f"import sys; from mbconstrained import cli; sys.argv = ['mbconstrained', *{arguments}]\n"
        "try: cli.main()\nexcept SystemExit as left: assert not left.code\nprint('scipy.linalg' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("False\n")


def test_importing_leaves_out_robots_pages_exact_answers_and_reports():
    parts = ("robot", "page", "exact", "analyses", "scene.schema")
    script = f"import mbconstrained, sys; print(*[part for part in {parts} if 'mbconstrained.' + part in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_the_types_and_the_licences_of_the_viewer_are_shipped():
    """Checkers of users' own code read the annotations of a package that has py.typed; pages contain the viewer, so its licences go with the package."""
    from mbconstrained.page.html import viewer_licences

    root = EXAMPLES.parent
    project = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))
    assert (root / "mbconstrained" / "py.typed").is_file()
    *_, file = project["project"]["license-files"]
    assert (root / file).read_text(encoding="utf-8").strip() == viewer_licences().strip()
    assert {"/examples", "/robots", "/tests", "/mbconstrained"} <= set(
        project["tool"]["hatch"]["build"]["targets"]["sdist"]["include"]
    )
