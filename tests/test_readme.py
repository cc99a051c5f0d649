"""The README is true: its Python runs as printed, and its first two commands are what sets the project up."""

import re
from pathlib import Path

import numpy as np

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.DOTALL | re.MULTILINE)


def test_the_python_blocks_run_in_order_and_say_what_their_comments_say():
    names: dict = {}
    for block in blocks("python"):
        exec(compile(block, "README.md", "exec"), names)  # our own text, not a user's
    motion, x = names["motion"], names["x"]
    assert motion([0.0, 0.5]).shape == (3, 2)
    # two unit masses on a rigid link, the first one 1 m off: lambda = -1/2 delta' (worked by hand in tests/oracles)
    assert len(x.impulses) == 2 and not x.impulses[0].any()
    np.testing.assert_allclose(x.impulses[1], [0, 0, -0.5], atol=1e-15)
    assert names["family"]([0.0, 0.5, 1.0]).shape == (1000, 2, 3)
    assert names["swing"]([1.0, 2.0], of=[500]).shape == (1, 2) and names["modes"].notices == ()


def test_set_up_is_exactly_two_commands():
    commands = blocks("sh")
    assert len(commands) == 2 and all(len(command.splitlines()) == 1 for command in commands)
    assert "mbconstrained run examples/two_masses.toml" in commands[0] and "pytest" in commands[1]


def test_every_file_that_is_named_exists():
    root = Path(__file__).parents[1]
    for name in re.findall(r"\]\(([^)#]+)\)", README) + re.findall(r"examples/\w+\.toml", README):
        assert (root / name).exists(), name
