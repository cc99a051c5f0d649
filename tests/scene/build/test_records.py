"""Records in scenes: over a distance with a speed, with a delay by the wheelbase, without their baseline, and in other folders."""

import os

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.errors import InputError, SceneError

WHEEL = """
[[model.node]]
name = "road"
[[model.mass]]
name = "body"
mass = "300 kg"
[[model.spring]]
between = ["road", "body"]
stiffness = "20 kN/m"
[[motion]]
coordinate = "road"
{}
[time]
end = "3 s"
points = 301
"""


def scene_of(folder, motion, **options):
    (folder / "scene").mkdir(exist_ok=True)
    path = folder / "scene" / "wheel.toml"
    path.write_text('[model]\nkind = "lumped"\n' + WHEEL.format(motion))
    return mb.read_scene(path, **options)


BUMP = "x (m);height (mm)\r\n0,0;0,0\r\n1,0;50,0\r\n2,0;0,0\r\n"


def test_a_profile_over_a_distance_is_a_record_over_time(tmp_path):
    """The same bump written as times and values: x / speed, and the wheelbase / speed later."""
    moved = (
        scene_of(tmp_path, 'kind = "sampled"\nfile = "bump.csv"\nspeed = "36 km/h"\ndistance = "2.5 m"')
        if _bump(tmp_path)
        else None
    )
    stated = scene_of(tmp_path, 'kind = "sampled"\ntimes = [0, "0.1 s", "0.2 s"]\nvalues = [0, "50 mm", 0]\ndelay = "0.25 s"')
    own = scene_of(
        tmp_path, 'kind = "sampled"\ndistances = [0, "1 m", 2]\nvalues = [0, "50 mm", 0]\nspeed = "10 m/s"\ndistance = "2.5 m"'
    )
    values = [one.run().values for one in (moved, stated, own)]
    assert values[0] == pytest.approx(values[1], abs=1e-15) and values[2] == pytest.approx(values[1], abs=1e-15)
    assert np.abs(values[0]).max() > 0.01


def _bump(folder):
    (folder / "scene").mkdir(exist_ok=True)
    return (folder / "scene" / "bump.csv").write_bytes(BUMP.encode())


def test_other_signals_act_later_along_a_distance(tmp_path):
    scene = scene_of(tmp_path, 'kind = "pulse"\nshape = "half-sine"\nvalue = "5 cm"\nduration = "0.1 s"\nspeed = 10\ndistance = 4')
    times = np.array([0.39, 0.45, 0.51])
    assert scene.run().motion.displacement(times)[0] == pytest.approx([0, 0.05, 0], abs=1e-15)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ('kind = "step"\nvalue = 1\ndistance = 2', "distance: it is passed with a speed; give speed, too"),
        ('kind = "step"\nvalue = 1\nspeed = 2', "speed: there is nothing along a distance"),
        ('kind = "step"\nvalue = 1\nspeed = 0\ndistance = 1', r"motion\[1\]\.speed: "),
        ('kind = "sampled"\ndistances = [0, 1]\nvalues = [0, 1]', "distances and speed belong together"),
        ('kind = "sampled"\ntimes = [0, 1]\ndistances = [0, 1]\nvalues = [0, 1]', "give either times or distances, not both"),
        ('kind = "sampled"\nfile = "bump.csv"', 'the unit of the time is "m"; .*give speed for a record over a distance'),
        ('kind = "sampled"\nfile = "bump.csv"\nspeed = "10 m"', r"motion\[1\]\.speed: "),
        ('kind = "sampled"\nfile = "bump.csv"\nspeed = 10\nbaseline = "linar"', r"motion\[1\]\.baseline: "),
        ('kind = "sampled"\nfile = "bump.csv"\nspeed = 10\nbaseline_fit = "integral"', "baseline_fit: there is no baseline"),
        ('kind = "sampled"\nfile = "bump.csv"\nspeed = 10\nstart = "3 m"', "start, end: found 0.3 s to 0.2 s; expected a part of"),
    ],
)
def test_mistakes_are_reported(tmp_path, entry, message):
    _bump(tmp_path)
    with pytest.raises(SceneError, match=message):
        scene_of(tmp_path, entry)


def test_a_part_of_a_record(tmp_path):
    (tmp_path / "a.csv").write_text("t (s),a (m/s^2)\n-1,0\n0,1\n2,3\n3,3\n")
    record = mb.read_record(tmp_path / "a.csv", start="500 ms", end=2.5)
    assert (record.times.tolist(), record.values.tolist()) == ([0.0, 1.5, 2.0], [1.5, 3.0, 3.0])
    with pytest.raises(InputError, match='it begins at -1 s; give start, e.g. start = "-1 s", which becomes t = 0'):
        mb.read_record(tmp_path / "a.csv").signal


def test_a_baseline_is_removed_and_stated_in_the_result(tmp_path):
    """An accelerometer at rest with an offset of 0.1 m/s^2: uncorrected the ground drifts by 0.45 m in 3 s."""
    (tmp_path / "scene").mkdir()
    (tmp_path / "scene" / "a.csv").write_text("t (s),a (m/s^2)\n" + "\n".join(f"{t / 100},0.1" for t in range(301)))
    entry = 'kind = "sampled"\nlevel = "acceleration"\nfile = "a.csv"\n'
    raw, corrected = (scene_of(tmp_path, entry + more).run() for more in ("", 'baseline = "constant"'))
    assert raw.motion.displacement(3.0)[0] == pytest.approx(0.45, rel=1e-12)
    assert corrected.motion.displacement(3.0)[0] == pytest.approx(0, abs=1e-12)
    (notice,) = (one for one in corrected.notices if one.kind == "record")
    assert "a.csv: a constant baseline of at most 0.1 m/s^2 (1 of the largest value) is removed" in notice.text
    assert "at its end velocity 0.3 m/s, now " in notice.text and "displacement 0.45 m, now " in notice.text
    assert not [one for one in raw.notices if one.kind == "record"]


def test_data_in_another_folder_need_its_name_from_outside_of_the_scene(tmp_path):
    data = tmp_path / "data"
    data.mkdir()
    (data / "bump.csv").write_bytes(BUMP.encode())
    entry = 'kind = "sampled"\nspeed = 10\nfile = "{}"'
    for name in ("../data/bump.csv", data / "bump.csv"):
        with pytest.raises(SceneError, match="to allow another folder give --data-folder DIR, in Python read_scene"):
            scene_of(tmp_path, entry.format(name))
        result = scene_of(tmp_path, entry.format(name), data_folders=[data]).run()
        assert np.abs(result.values).max() > 0.01
    scene_of(tmp_path, entry.format("../data/bump.csv"), data_folders=str(data))  # one folder alone
    (tmp_path / "secret.csv").write_bytes(BUMP.encode())
    os.symlink(tmp_path / "secret.csv", data / "link.csv")
    for name in ("../secret.csv", "../data/link.csv", "../data/../secret.csv"):
        with pytest.raises(SceneError, match="data files must lie in the folder of the scene, or in "):
            scene_of(tmp_path, entry.format(name), data_folders=[data])
    with pytest.raises(InputError, match="data_folders: there is no folder "):
        scene_of(tmp_path, entry.format("../data/bump.csv"), data_folders=[tmp_path / "none"])
