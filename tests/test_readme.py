"""The README is true and short: its Python runs as printed, and its first two commands are what sets the project up."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
LARGEST = 8_000  # bytes


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


def test_set_up_is_exactly_two_commands():
    commands = blocks("sh")
    assert len(commands) == 2 and all(len(command.splitlines()) == 1 for command in commands)
    assert "mbconstrained run examples/two_masses.toml" in commands[0] and "pytest" in commands[1]


def test_every_file_that_is_named_exists():
    for name in re.findall(r"\]\(([^)#]+)\)", README) + re.findall(r"examples/\w+\.toml", README):
        assert (ROOT / name).exists(), name


def test_it_is_short():
    assert len(README.encode()) <= LARGEST
