"""A scene that runs in a process of its own: which functions of the package were called, and what was imported."""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]


@dataclass(frozen=True)
class Watched:
    """What happened.

    Attributes:
        taken: names of the stages that the plan lists as taken.
        called: functions of the package as "scene/run/result.py:Result.curves"; where one has an argument ``kind``, also with its
            value in brackets.
        loaded: all modules in memory at the end.
    """

    taken: frozenset[str]
    called: frozenset[str]
    loaded: frozenset[str]


def watched(scene: Path, folder: Path) -> Watched:
    """Read, plan and run a scene, write its files, and tell its summary as text and data."""
    command = [sys.executable, "-c", "from tests.scene.watched import main; main()", str(scene), str(folder)]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return Watched(**{key: frozenset(names) for key, names in json.loads(done.stdout).items()})


def main() -> None:
    """In the other process."""
    called: set[str] = set()
    sys.setprofile(lambda frame, event, _: event == "call" and called.update(_names(frame)))
    from mbconstrained.scene.run.scene import read_scene

    scene = read_scene(sys.argv[1])
    result = scene.run(sys.argv[2])
    result.summary(), result.to_dict()
    sys.setprofile(None)
    taken = [stage.name for stage in result.plan.needed]
    print(json.dumps({"taken": taken, "called": sorted(called), "loaded": sorted(sys.modules)}))


def _names(frame):
    _, package, file = frame.f_code.co_filename.rpartition(f"{ROOT.name}{os.sep}mbconstrained{os.sep}")
    if package:
        name = f"{Path(file).as_posix()}:{frame.f_code.co_qualname}"
        yield name
        if isinstance(kind := frame.f_locals.get("kind"), str):
            yield f"{name}({kind})"
