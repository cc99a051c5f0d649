"""The command line: what it prints, what it writes, and the exit codes 0, 1, 2, 3 and 130."""

import json
import os
import pty
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from mbconstrained.analyses import ANALYSES
from mbconstrained.analyses.run import RunAnswer
from mbconstrained.ground.notices import Notice

EXAMPLES = Path(__file__).parents[2] / "examples"
TWO_MASSES = str(EXAMPLES / "two_masses.toml")


COMMAND = [sys.executable, "-m", "mbconstrained"]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(EXAMPLES.parent)}


def process(*arguments, **options):
    """The command line in a process of its own."""
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "env": ENVIRONMENT, **options}
    return subprocess.run([*COMMAND, *map(str, arguments)], text=True, timeout=60, **options)


def test_run_writes_three_files_and_says_what_an_engineer_wants_to_know(command, tmp_path):
    code, out, err = command("run", TWO_MASSES)
    assert (code, err) == (0, "")
    folder = tmp_path / "results" / "two_masses"
    assert {path.name for path in folder.iterdir()} == {"two_masses.html", "two_masses.csv", "two_masses.npz"}
    assert (folder / "two_masses.html").stat().st_size <= 1.3e6
    for words in (
        r"^Two masses with a redundant coordinate$",
        r"^  no\.  Hz +damping ratio +meaning$",
        r"^  1 +drift of constraint rows, 2 times$",
        r"^  3 +0\.115166 +0$",
        r"note \(drift\): constraint .face of m1. is at acceleration level",
        r"^Error estimate \d",
        r"results/two_masses/two_masses\.html, two_masses\.csv, two_masses\.npz$",
    ):
        assert re.search(words, out, re.MULTILINE), words
    code, out, err = command("run", TWO_MASSES, "--verbose")
    assert (code, err) == (0, "")
    for words in (
        r"Coordinates: x1 \(m\), q1 \(m\), q2 \(m\); t from 0 to 50 s",
        r"face of m1 +acceleration +0 m/s\^2",
        r"± 0\.723607 i",
        r"error estimate: displacement +\d",
        r"residual +\d",
        r"results/two_masses/two_masses\.html",
    ):
        assert re.search(words, out, re.MULTILINE), words


@pytest.mark.long
def test_json_is_data_and_nothing_else(command, tmp_path):
    code, out, err = command("run", TWO_MASSES, "--json")
    data = json.loads(out)
    assert (code, err) == (0, "")
    assert [mode["kind"] for mode in data["eigenvalues"]] == ["drift", "oscillation", "oscillation"]
    assert data["trusted"] is True and len(data["files"]) == 3
    _, out, _ = command("plan", TWO_MASSES, "--json")
    assert {stage["name"]: stage["taken"] for stage in json.loads(out)["plan"]}["page"] is True
    _, out, _ = command("check", TWO_MASSES, "--json")
    assert json.loads(out)["coordinates"] == ["x1", "q1", "q2"]
    code, out, err = command("check", tmp_path / "no.toml", "--json")
    assert (code, err, json.loads(out)["exit_code"]) == (1, "", 1)


def test_modes_lists_zeros_shares_and_shapes_and_writes_nothing(command, tmp_path):
    code, out, err = command("modes", TWO_MASSES)
    assert (code, err) == (0, "") and list(tmp_path.iterdir()) == []
    for words in (
        r"^  no\.  Hz +damping +kind +eigenvalue \(1/s\) +rad/s +times$",
        r"^  1 +drift +0 +2$",
        r"^  3 +0\.115166 +0 +oscillation +± 0\.723607 i +0\.723607 +1$",
        r"^Mode 3: oscillation at 0\.115166 Hz, undamped$",
        r"^  kinetic energy x1 72\.4 %, q2 72\.4 %, q1 -44\.7 %$",
        r"^  shape +q2 1 m, x1 -0\.618 m, q1 -0\.618 m$",
    ):
        assert re.search(words, out, re.MULTILINE), words


def test_modes_as_json_are_numbers(command):
    code, out, err = command("modes", EXAMPLES / "pulled_joint.toml", "--json")
    (mode,) = json.loads(out)["modes"]
    assert (code, err) == (0, "")
    assert mode["angular_frequency"] == pytest.approx(5.0)
    assert mode["strain_shares"] == pytest.approx({"spring ground-joint": 0.25, "spring joint-load": 0.75})
    assert mode["shape"] == {"real": pytest.approx([0.25, 1.0]), "imaginary": [0.0, 0.0]}


def test_modes_that_cannot_be_trusted_are_printed_and_are_three(command, monkeypatch):
    doubt = Notice("rank", "a rank decision has no clear gap", doubtful=True)
    monkeypatch.setattr("mbconstrained.analyses.modes.pair_notices", lambda pairs: (doubt,))
    code, out, _ = command("modes", TWO_MASSES)
    assert code == 3 and "Mode 2: " in out and "warning (rank): a rank decision has no clear gap" in out


def test_plan_lists_reasons_and_writes_nothing(command, tmp_path):
    code, out, _ = command("plan", TWO_MASSES)
    assert code == 0 and list(tmp_path.iterdir()) == []
    assert re.search(r"taken +constrained form +1 independent row at", out)
    assert re.search(r"left out +infinite pair +A_2 is nonsingular", out)
    assert re.search(r"left out +robot model \(pinocchio\) +no robot in the scene", out)


@pytest.mark.long
def test_plan_with_run_tells_what_each_stage_took_and_leaves_nothing(command, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    code, out, _ = command("plan", TWO_MASSES, "--run")
    assert code == 0 and list(tmp_path.iterdir()) == []
    taken, left_out = out.split("\nLeft out\n")
    for stage in ("read the scene", "units", "finite pair", "CSV", "npz", "page", "all"):
        assert re.search(rf"^  {stage} +\d+\.\d +\d.* %", taken, re.MULTILINE), stage
    assert re.search(r"constrained form +– ", taken)
    assert re.search(r"infinite pair +A_2 is nonsingular", left_out)
    code, out, _ = command("plan", TWO_MASSES, "--run", "--json")
    data = json.loads(out)
    assert code == 0 and data["trusted"] is True and data["totals"]["seconds"] > 0
    stages = {stage["name"]: stage for stage in data["plan"]}
    assert stages["page"]["seconds"] > 0 and stages["energy"]["seconds"] is None


def test_check_solves_and_writes_nothing(command, tmp_path):
    code, out, _ = command("check", TWO_MASSES)
    assert code == 0 and list(tmp_path.iterdir()) == []
    assert out.startswith("two_masses.toml is fine: Two masses with a redundant coordinate\n3 coordinates (x1, q1, q2)")


def test_one_coordinate_is_not_several(command, tmp_path):
    model = '[model]\nkind = "matrices"\nmass = [[1]]\nstiffness = [[1]]\ncoordinates = ["a"]'
    (tmp_path / "one.toml").write_text(f'title = "One"\n{model}\n[time]\nend = 1\n')
    code, out, _ = command("check", "one.toml")
    assert code == 0 and "\n1 coordinate (a), " in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run"], "Missing argument 'SCENE'"),
        (["rnu", TWO_MASSES], "Did you mean 'run'"),
        (["run", TWO_MASSES, "--jsn"], "--json"),
        (["run", TWO_MASSES, "another.toml"], "unexpected extra argument"),
        (["modes", TWO_MASSES, "--out", "folder"], "give --page too"),
    ],
)
def test_a_wrong_command_line_is_two(command, arguments, words):
    code, out, err = command(*arguments)
    assert (code, out) == (2, "") and words in err


@pytest.mark.long
@pytest.mark.parametrize("place", ["taken", "taken/deeper", "x" * 300])
def test_results_that_cannot_be_written_are_two(command, tmp_path, place):
    (tmp_path / "taken").write_text("a file, not a folder")
    code, out, err = command("run", TWO_MASSES, "--out", place)
    assert (code, out) == (2, "")
    assert err.startswith("the results cannot be written: ") and err.count("\n") == 1
    assert (tmp_path / "taken").read_text() == "a file, not a folder"
    code, out, err = command("modes", TWO_MASSES, "--page", "--out", place)
    assert (code, out) == (2, "") and err.startswith("the results cannot be written: ")


@pytest.mark.parametrize("work", ["run", "modes", "check", "plan"])
def test_a_data_file_that_cannot_be_read_is_one_and_about_the_scene(command, tmp_path, work):
    path = tmp_path / "scene.toml"
    path.write_text(f'[model]\nkind = "matrices"\nmass = "{"a" * 300}.csv"\n[time]\nend = 1\n')
    code, out, err = command(work, path)
    assert (code, out) == (1, "")
    assert err.startswith("scene.toml: model.mass: ") and "the file cannot be read (File name too long)" in err


def test_what_the_system_says_while_reading_is_no_writing_error(command, monkeypatch):
    def failing(*_):
        raise OSError(5, "Input/output error")

    monkeypatch.setattr("mbconstrained.scene.run.scene.read_scene", failing)
    code, _, err = command("check", TWO_MASSES)
    assert code == 1 and err.startswith("two_masses.toml: the scene or a file of it cannot be read: ")


@pytest.mark.long
@pytest.mark.parametrize("ending", ["html", "csv", "npz"])
def test_results_are_replaced_together_or_not_at_all(command, tmp_path, ending):
    folder = tmp_path / "out"
    folder.mkdir()
    for other in {"html", "csv", "npz"} - {ending}:
        (folder / f"two_masses.{other}").write_text("earlier")
    (folder / f"two_masses.{ending}").mkdir()
    code, _, err = command("run", TWO_MASSES, "--out", "out")
    assert code == 2 and "Is a directory" in err and f"two_masses.{ending}" in err
    assert len(list(folder.iterdir())) == 3
    assert [file.read_text() for file in folder.iterdir() if file.is_file()] == ["earlier"] * 2


BAD = {
    "misspelt key": ("stiffness = [[2", "stifness = [[2", 'did you mean "stiffness"'),
    "missing data file": ("[[10, 0, 0], [0, 10, 10], [0, 10, 10]]", '"mass.mtx"', "mass.mtx: there is no such file in the folder"),
    "singular pencil": (
        "[0, 10, 10], [0, 10, 10]]     # kg\nstiffness = [[2, 0, 0], [0, 0, 0], [0, 0, 2]]",
        "[0, 0, 0], [0, 0, 0]]\nstiffness = [[2, 0, 0], [0, 0, 0], [0, 0, 0]]",
        "q2",
    ),
    "beyond the numbers": ("[[2, 0, 0]", "[[-2e9, 0, 0]", "beyond the range of float64"),
    "not TOML": (None, "#!/bin/sh\necho hello\n", "not a TOML file"),
}


@pytest.mark.long
@pytest.mark.parametrize("case", BAD)
def test_a_bad_scene_is_one_message_and_one_and_leaves_earlier_output(command, tmp_path, case):
    path = tmp_path / "two_masses.toml"
    good = Path(TWO_MASSES).read_text("utf-8")
    page = tmp_path / "results" / "two_masses" / "two_masses.html"
    page.parent.mkdir(parents=True)
    page.write_text("earlier")
    old, new, words = BAD[case]
    if old is not None:
        assert old in good
    path.write_text(new if old is None else good.replace(old, new))
    code, out, err = command("run", path)
    assert (code, out) == (1, "")
    assert words in err and err.startswith("two_masses.toml: ")
    assert err.count("\n") == 1 or case == "singular pencil"  # with the report on what is free
    assert list(page.parent.iterdir()) == [page] and page.read_text() == "earlier"


@pytest.mark.long
def test_an_answer_that_cannot_be_trusted_is_written_and_is_three(command, monkeypatch, tmp_path):
    doubt = Notice("accuracy", "the data do not determine the answer", doubtful=True)
    monkeypatch.setattr(RunAnswer, "notices", (doubt,))
    code, out, _ = command("run", TWO_MASSES)
    assert code == 3
    assert "warning (accuracy): the data do not determine the answer" in out
    assert (tmp_path / "results" / "two_masses" / "two_masses.html").exists()


@pytest.mark.long
def test_interruption_is_130_without_traceback(command, monkeypatch):
    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("mbconstrained.scene.run.scene.read_scene", interrupted)
    code, _, err = command("run", TWO_MASSES)
    assert code == 130 and "Traceback" not in err


@pytest.mark.long
def test_interrupted_process_leaves_no_half_file(tmp_path):
    path = tmp_path / "long.toml"
    path.write_text(Path(TWO_MASSES).read_text("utf-8").replace("points = 1001", "points = 200000"))
    running = subprocess.Popen(
        [*COMMAND, "run", path, "--out", tmp_path / "out"], stderr=subprocess.PIPE, text=True, env=ENVIRONMENT
    )
    deadline = time.monotonic() + 30
    while not (tmp_path / "out").exists() and running.poll() is None and time.monotonic() < deadline:
        time.sleep(0.01)
    running.send_signal(signal.SIGINT)
    _, err = running.communicate(timeout=60)
    assert "Traceback" not in err
    assert running.returncode in (0, 130)
    assert all(file.name.startswith("long.") for file in (tmp_path / "out").iterdir())


@pytest.mark.long
def test_closed_pipe_is_no_error(tmp_path):
    reading, writing = os.pipe()
    os.close(reading)
    done = process("run", TWO_MASSES, "--out", tmp_path, stdout=writing)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, "")
    assert (tmp_path / "two_masses.html").exists()


@pytest.mark.long
def test_a_terminal_gets_tables_and_no_markup_is_interpreted(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(Path(TWO_MASSES).read_text("utf-8").replace('title = "Two masses', 'title = "[red]Two[/] masses'))
    master, slave = pty.openpty()
    done = process("plan", path, stdout=slave)
    os.close(slave)
    shown = os.read(master, 100_000).decode(errors="ignore")  # what a terminal holds may end within a letter
    os.close(master)
    assert (done.returncode, done.stderr) == (0, "")
    assert "[red]Two[/] masses" in shown and "  taken     constrained form" in shown and max(map(len, shown.splitlines())) <= 80


@pytest.mark.long
def test_hostile_scene_in_a_process_of_its_own(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text('x = "' + "9**" * 300_000 + '"')
    done = process("run", path, cwd=tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith("scene.toml: ") and "Traceback" not in done.stderr and len(done.stderr) < 500
    assert [file.name for file in tmp_path.iterdir()] == ["scene.toml"]


FORMULA = str(EXAMPLES / "two_masses_formula.toml")


@pytest.mark.long
def test_formula_prints_text(command):
    code, out, err = command("formula", FORMULA)
    assert (code, err) == (0, "")
    assert "x1(t) = (2/5 + 12 sqrt(5)/25) cos(w1 t)" in out and "Default values: m = 10 kg, k = 2 N/m." in out


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "says"),
    [("latex", r"\begin{align*}"), ("python", "def x(t, m=10.0, k=2.0):"), ("c", "#include <math.h>"), ("json", '"parameters": {')],
)
def test_formula_prints_other_forms(command, kind, says):
    code, out, err = command("formula", FORMULA, "--as", kind, "--coordinates", "x1, q2")
    assert (code, err) == (0, "") and says in out and "q1" not in out.replace("of q1", "")


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        ((FORMULA, "--coordinates", "q3"), 1, 'there is no coordinate "q3"; there are x1, q1, q2'),
        ((str(EXAMPLES / "pendulum.toml"),), 1, "there is no formula with symbols for a robot"),
        ((FORMULA, "--as", "pascal"), 2, "pascal"),
        ((FORMULA, "--out", "/dev/null/x"), 2, "cannot be written"),
    ],
)
def test_formula_says_what_is_wrong(command, arguments, code, says):
    found, _, err = command("formula", *arguments)
    assert found == code and says in err


@pytest.mark.long
def test_formula_with_an_error_as_json(command):
    code, out, _ = command("formula", str(EXAMPLES / "pendulum.toml"), "--json")
    assert code == 1 and "robot" in json.loads(out)["error"]


@pytest.mark.long
def test_a_formula_does_not_take_the_place_of_its_scene(command, tmp_path):
    scene = tmp_path / "own.toml"
    scene.write_text((EXAMPLES / "two_masses_formula.toml").read_text(encoding="utf-8"), encoding="utf-8")
    link = tmp_path / "link.toml"
    link.symlink_to(scene)
    for out in (scene, link):
        code, _, problem = command("formula", str(scene), "--out", str(out))
        assert code == 1 and "is the scene itself" in problem
    assert "[parameters]" in scene.read_text(encoding="utf-8")


@pytest.mark.long
def test_a_formula_follows_links_and_leaves_devices(command, tmp_path):
    target, link = tmp_path / "target.txt", tmp_path / "link.txt"
    target.write_text("before")
    link.symlink_to(target)
    assert command("formula", str(EXAMPLES / "two_masses_formula.toml"), "--out", str(link))[0] == 0
    assert link.is_symlink() and "x1(t)" in target.read_text(encoding="utf-8")
    assert command("formula", str(EXAMPLES / "two_masses_formula.toml"), "--out", os.devnull)[0] == 0
    assert Path(os.devnull).is_char_device()


@pytest.mark.long
@pytest.mark.parametrize("seconds", ["inf", "1e300", "nan", "0"])
def test_a_limit_of_time_is_a_number_of_seconds(command, seconds):
    assert command("formula", str(EXAMPLES / "two_masses_formula.toml"), "--seconds", seconds)[0] == 2


OSCILLATOR = """
[model]
kind = "lumped"
mass = [{ name = "cart", mass = "2 kg" }]
spring = [{ between = ["ground", "cart"], stiffness = "=k" }]
[parameters]
k = "8 N/m"
[initial]
displacement = { cart = 0.1 }
[time]
end = 1
[output]
animation = false
"""


def two_of_one_name(folder):
    """Scenes of one name in two folders."""
    paths = [folder / name / "cart.toml" for name in ("one", "two")]
    for path in paths:
        path.parent.mkdir()
        path.write_text(OSCILLATOR, encoding="utf-8")
    return paths


def test_results_of_two_scenes_of_one_name_do_not_overwrite_each_other(command, tmp_path):
    one, two = two_of_one_name(tmp_path)
    assert command("run", one)[::2] == (0, "")
    first = (tmp_path / "results" / "cart" / "cart.npz").read_bytes()
    code, out, err = command("run", two)
    assert code == 0 and "results/cart-2" in out
    assert err == f"results/cart has the results of {one}; these are in results/cart-2\n"
    assert (tmp_path / "results" / "cart" / "cart.npz").read_bytes() == first
    assert command("run", one)[::2] == (0, "") and "results/cart-2" in command("modes", two, "--page")[1]
    one.unlink()  # a scene that is there no more owns nothing
    (tmp_path / "results" / "cart-2").rename(tmp_path / "old")
    code, out, err = command("run", two)
    assert (code, err) == (0, "") and "results/cart/cart.html" in out


def test_pages_that_are_replaced_in_a_chosen_folder_are_named(command, tmp_path):
    one, two = two_of_one_name(tmp_path)
    two.write_text(f'title = "Another <cart>"\n{OSCILLATOR}', encoding="utf-8")
    for path in (one, one):
        assert command("run", path, "--out", "both")[::2] == (0, "")
    code, _, err = command("run", two, "--out", "both")
    assert code == 0 and err.startswith('both/cart.html: replaces the page of "') and err.count("\n") == 1
    assert command("run", one, "--out", "both")[2] == 'both/cart.html: replaces the page of "Another <cart>"\n'


@pytest.mark.parametrize("content", ["", "[1]", '{"cart": 3}', "{"])
def test_a_damaged_note_of_owners_is_made_again(command, tmp_path, content):
    one, _ = two_of_one_name(tmp_path)
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / ".scenes.json").write_text(content, encoding="utf-8")
    assert command("run", one)[::2] == (0, "")
    assert json.loads((tmp_path / "results" / ".scenes.json").read_text()) == {"cart": str(one)}


def test_a_run_with_other_values_has_files_of_its_own(command, tmp_path):
    one, _ = two_of_one_name(tmp_path)
    assert command("run", one)[0] == command("run", one, "--set", "k=18 N/m")[0] == 0
    assert command("run", one, "--set", "k=18 N/m", "--set", "title=" + 90 * "x")[0] == 0
    names = {path.name for path in (tmp_path / "results" / "cart").glob("*.npz")}
    assert {"cart.npz", "cart.k=18_N_m.npz"} < names and len(names) == 3 and max(map(len, names)) < 100


def test_the_machine_is_named_with_verbose_only(command, tmp_path):
    one, _ = two_of_one_name(tmp_path)
    arguments = ("sweep", one, "--vary", "k=7..9 N/m:3", "--keep", "frequencies", "--out", "out")
    assert "processor" not in command(*arguments)[1] and "numpy" not in command(*arguments)[1]
    assert "processor" in command(*arguments, "--verbose")[1]
    assert "processor" in (tmp_path / "out" / "cart.sweep.html").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["", *ANALYSES, "plan", "check", "new", "schema"])
def test_no_help_states_two_defaults_of_one_option(command, name):
    code, out, _ = command(*filter(None, [name]), "--help")
    options = re.split(r"\n  (?=-)", out.partition("Options:")[2].partition("Examples:")[0])
    assert code == 0 and len(options) > 1
    for option in options:
        text = " ".join(option.split())
        assert len(re.findall(r"default|left out: ", text)) <= 1, text
        assert "None" not in text and "9223372036854775807" not in text
