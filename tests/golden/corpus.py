"""The golden corpus: what every scene of examples/ answers to every command, frozen small.

    python -m tests.golden.corpus            compute all scenes again and write tests/golden/NAME.json
    python -m tests.golden.corpus NAME ...   only these

A column is all numbers of one key, in the order of the answer; of the arrays of npz files each is one. Stored are its size, its
largest modulus and a few values, each with 14 digits. Real and imaginary parts share their largest modulus. Numbers in texts, figures
that estimate rounding errors, and Jordan chains, which are not unique, are left out; texts are compared as sets.

    python -m tests.golden.corpus --compare NAME ...    the largest difference of each command, to see what a change of code does
"""

from __future__ import annotations

import contextlib
import csv
import functools
import io
import json
import re
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from unittest import mock

import numpy as np

PROJECT = Path(__file__).parents[2]
FOLDER = Path(__file__).parent

#: Values that are stored of a column, spread over it, and digits of each.
SAMPLES, DIGITS = 4, 14

#: The arithmetic of OpenBLAS in which the corpus was frozen; SciPy and NumPy have each their own copy.
FROZEN_ON = "Haswell"

#: Commands that answer any scene, or refuse it in their own words.
COMMANDS = (
    ("check",), ("run",), ("modes",), ("frequency",), ("random",), ("shock",), ("sensitivity",), ("campbell",), ("path",), ("formula",)
)  # fmt: skip

#: Commands that write nothing.
WITHOUT_FILES = {"check", "formula", "modes", "sensitivity"}

#: Studies of single scenes.
STUDIES = {
    "gear_tolerances": (("sweep", "--samples", "20"),),
    "arm_workspace": (("sweep",),),
    "tuned_mass_damper_optimum": (("sweep", "--samples", "20"), ("optimise", "--minimise", "response peak")),
    "two_masses": (("compare", "examples/two_masses_position.toml"),),
    "driveline": (("orders",), ("steady",)),
    "spindle": (("orders",),),
    "washing_machine": (("orders",),),
    "quarter_car": (("locus", "--vary", "damper=500..4000 N*s/m:21"),),
}

#: Answers that depend on the load of the machine: the formula of this scene is given up after a time.
LEFT_OUT = {("gear_tolerances", "formula")}

#: Keys of figures that depend on the machine, or estimate rounding errors.
VOLATILE = re.compile(
    r"seconds|memory|peak_memory|totals|estimate|residual|error|evidence|condition|gap|files|written|folder|version|stages|evaluations|reason|finite_|phase",
    re.I,
)

#: Columns that agree to this share of their largest modulus are those of the same arithmetic.
CODE_MOVED = 1e-12

#: Numbers in texts that rounding errors may change.
NUMBER = re.compile(r"[-+]?\d+\.\d+(e[-+]?\d+)?|[-+]?\d+e[-+]?\d+")


def scenes() -> list[str]:
    """Names of all scenes."""
    return sorted(path.stem for path in (PROJECT / "examples").glob("*.toml"))


def answers(scene: str) -> dict:
    """What a scene answers, read once for all commands: by command the exit code, columns of numbers and sets of texts."""
    from mbconstrained.scene.run import scene as module

    given, read = module.read_scene, functools.cache(module.read_scene)
    with mock.patch.object(module, "read_scene", lambda path, *changes: given(path, *changes) if any(changes) else read(path)):
        return {" ".join(command): _answer(scene, command) for command in _commands(scene)}


def _commands(scene: str) -> list[tuple[str, ...]]:
    return [command for command in (*COMMANDS, *STUDIES.get(scene, ())) if (scene, command[0]) not in LEFT_OUT]


def _answer(scene: str, command: tuple[str, ...]) -> dict:
    from mbconstrained.cli import application

    with tempfile.TemporaryDirectory() as folder:
        name, *options = command
        out = [] if name in WITHOUT_FILES else ["--out", folder]
        output = io.StringIO()
        with contextlib.redirect_stdout(output), contextlib.redirect_stderr(io.StringIO()), contextlib.chdir(PROJECT):
            try:
                application()([name, f"examples/{scene}.toml", *options, "--json", *out], prog_name="mbconstrained")
                code = 0
            except SystemExit as end:
                code = end.code
        columns: dict[str, list] = defaultdict(list)
        texts: dict[str, set] = defaultdict(set)
        text = output.getvalue()
        if text.lstrip().startswith("{"):
            _collect(json.loads(text), "", columns, texts)
        _collect_files(Path(folder), columns, texts)
    numbers = {key: _column(values) for key, values in columns.items() if values}
    return {"exit": code, "numbers": numbers, "texts": {key: sorted(found) for key, found in texts.items()}}


def _collect(data, key: str, columns, texts) -> None:
    if VOLATILE.search(key.rpartition(".")[2]):
        return
    if isinstance(data, dict):
        for name, value in data.items():
            _collect(value, f"{key}.{name}" if key else name, columns, texts)
    elif isinstance(data, list):
        for value in data:
            _collect(value, key, columns, texts)
    elif isinstance(data, str):
        texts[key].add(NUMBER.sub("#", data))
    else:
        columns[key].append(np.nan if data is None else float(data))


def _collect_files(folder: Path, columns, texts) -> None:
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        name = path.relative_to(folder).as_posix()
        texts["files"].add(name)
        if path.suffix == ".npz":
            with np.load(path) as arrays:
                for key in arrays.files:
                    array = arrays[key]
                    if array.dtype.kind in "fciub" and not VOLATILE.search(key):
                        columns[f"{name} {key}"] = np.asarray(array, dtype=complex).ravel().view(float).tolist()
        elif path.suffix == ".csv":
            with path.open(newline="") as file:
                texts[f"{name} heads"].update(next(csv.reader(file)))


def _column(values: list) -> dict:
    array = np.array(values, dtype=float)
    finite = np.abs(array[np.isfinite(array)])
    places = np.unique(np.linspace(0, len(array) - 1, min(SAMPLES, len(array))).round().astype(int))
    return {
        "size": len(array),
        "largest": _rounded(finite.max(initial=0.0)),
        "sum": _rounded(array[np.isfinite(array)].sum()),
        "places": places.tolist(),
        "values": [_rounded(value) for value in array[places]],
    }


def _rounded(value: float):
    return float(f"{value:.{DIGITS - 1}e}") if np.isfinite(value) else str(float(value))


def difference(stored: dict, found: dict, key: str) -> float:
    """The largest difference of two columns, relative to the largest modulus; infinite of columns of different shape."""
    one, other = stored[key], found[key]
    if (one["size"], one["places"]) != (other["size"], other["places"]):
        return np.inf
    first, second = (np.array([float(value) for value in column["values"]]) for column in (one, other))
    if not np.array_equal(np.isfinite(first), np.isfinite(second)):
        return np.inf
    pair = {"real": "imaginary", "imaginary": "real"}.get(key.rpartition(".")[2])
    twin = stored.get(f"{key.rpartition('.')[0]}.{pair}", one) if pair else one
    scale = max(one["largest"], other["largest"], twin["largest"]) or 1.0
    return float(np.abs(first - second)[np.isfinite(first)].max(initial=0.0) / scale)


def freeze(scene: str) -> None:
    """Write the answers of a scene."""
    lines = [f"{json.dumps(command)}: {json.dumps(answer, sort_keys=True)}" for command, answer in answers(scene).items()]
    (FOLDER / f"{scene}.json").write_text("{\n" + ",\n".join(lines) + "\n}\n")


def differences(scene: str) -> dict[str, float]:
    """By command and column how far the answers of a scene are from those in the corpus, relative to the largest of their column."""
    stored, now = json.loads((FOLDER / f"{scene}.json").read_text()), answers(scene)
    found: dict[str, float] = {}
    for command in stored.keys() | now.keys():
        one, other = (each.get(command, {"exit": None, "texts": None, "numbers": {}}) for each in (stored, now))
        for part in ("exit", "texts"):
            if one[part] != other[part]:
                found[f"{command}: {part}"] = np.inf
        for key in one["numbers"].keys() | other["numbers"].keys():
            both = key in one["numbers"] and key in other["numbers"]
            found[f"{command}: {key}"] = difference(one["numbers"], other["numbers"], key) if both else np.inf
    return found


def main(names: list[str]) -> None:
    """Freeze the scenes, or compare them with the corpus."""
    compare = "--compare" in names
    for name in [name for name in names if not name.startswith("-")] or scenes():
        if compare:
            large = {key: value for key, value in differences(name).items() if value > CODE_MOVED}
            print(name, large or "as before", flush=True)
        else:
            freeze(name)
            print(name, flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
