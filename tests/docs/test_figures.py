"""Figures in the documentation are measurements of an engine that is still the same."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]

#: Where the history is: a checkout without one is given its repository by this variable.
HISTORY = Path(os.environ.get("MBCONSTRAINED_HISTORY", ROOT))

#: Rooms whose run times the tables show.
ENGINE = [f"mbconstrained/{room}" for room in ("linalg", "polynomial", "response", "frequency", "mechanics", "models", "signals")]

#: So many commits may change them before they are measured again.
COMMITS = 30


def git(*words: str) -> str:
    return subprocess.run(["git", "-C", str(HISTORY), *words], check=True, capture_output=True, text=True).stdout


@pytest.mark.parametrize("page", ["README.md", "mbconstrained/docs/explanation/accuracy_and_speed.md"])
def test_tables_are_younger_than_the_engine(page):
    (commit,) = re.findall(
        r"^Commit ([0-9a-f]{12}), \d{4}-\d\d-\d\d, one thread of", (ROOT / page).read_text(encoding="utf-8"), re.MULTILINE
    )
    if not (HISTORY / ".git").exists():
        pytest.skip("there is no history: MBCONSTRAINED_HISTORY may name the repository")
    if git("rev-parse", "--is-shallow-repository").strip() == "true":
        pytest.skip("the history is shallow")
    if subprocess.run(["git", "-C", str(HISTORY), "cat-file", "-e", commit], capture_output=True).returncode:
        pytest.skip(f"the history does not contain the commit {commit}")
    later = int(git("rev-list", "--count", f"{commit}..HEAD", "--", *ENGINE))
    assert later <= COMMITS, f"{later} commits changed the engine since; run python tests/benchmarks/tables.py"
