"""Importing the package is light: what a scene does not need is not loaded."""

from __future__ import annotations

import subprocess
import sys

import pytest

HEAVY = ["pinocchio", "coal", "meshcat", "sympy", "flint", "matplotlib", "pydantic", "pint", "typer", "rich", "control", "xarray", "pandas"]


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
    assert "numpy" in loaded
    assert not loaded & set(HEAVY)


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
