"""The README is true and short: its Python runs as printed, its first commands set the project up, and each command of it runs."""

import re
import shlex
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
LARGEST = 10_200  # bytes


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.DOTALL | re.MULTILINE)


def test_the_python_block_runs_and_has_the_shapes_of_its_comments():
    names: dict = {}
    (block,) = blocks("python")
    exec(compile(block, "README.md", "exec"), names)  # our own text, not a user's
    motion = names["motion"]
    assert motion([0.0, 0.5, 1000.0]).shape == (3, 3)
    assert motion.notices[0].text in block and len(motion.notices) == 1
    assert motion.error_estimate([0.0, 0.5, 1000.0]) < 1e-12


def test_set_up_activates_its_environment_before_the_first_command():
    set_up, tests = blocks("sh")
    assert set_up.splitlines() == [
        "python3 -m venv .venv",
        ". .venv/bin/activate",
        "pip install .",
        "mbconstrained run examples/quarter_car.toml",
    ]
    assert tests.splitlines()[:2] == [". .venv/bin/activate", "pip install '.[test]'"] and "python -m pytest" in tests


@pytest.mark.long
@pytest.mark.parametrize("line", sorted(set(re.findall(r"`mbconstrained (\w+ examples/[^`]+)`", README))))
def test_each_command_runs(line, command, tmp_path):
    for name in ("examples", "robots"):
        (tmp_path / name).symlink_to(ROOT / name)
    code, printed, errors = command(*shlex.split(line), *(["--samples", "16"] if line.startswith("sweep") else []))
    assert code == 0, errors
    assert list(tmp_path.glob("results/*/*.html")) or (line.startswith("modes ") and "Mode 1:" in printed)


def test_every_file_that_is_named_exists():
    for name in re.findall(r"\]\(([^)#]+)\)", README) + re.findall(r"examples/\w+\.toml", README):
        assert (ROOT / name).exists(), name


def test_it_is_short():
    assert len(README.encode()) <= LARGEST
