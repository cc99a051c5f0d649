"""Data files beside a scene: the same answer as from numbers in it, and none from anywhere else."""

import os

import numpy as np
import pytest
import scipy.io

from mbconstrained.ground.errors import SceneError
from mbconstrained.scene.run.scene import read_scene
from tests.scene.scenes import scene_of

MASS, STIFFNESS = np.diag([2.0, 3.0]), np.array([[5.0, -1.0], [-1.0, 4.0]])
TEXT = """
[model]
kind = "matrices"
mass = {mass}
stiffness = {stiffness}

[initial]
displacement = [1, 0]

[time]
end = 3
"""
INLINE = TEXT.format(mass=MASS.tolist(), stiffness=STIFFNESS.tolist())


@pytest.mark.parametrize(
    ("mass", "stiffness"),
    [
        ('{ file = "plant.npz", array = "M" }', '{ file = "plant.npz", array = "K" }'),
        ('"data/mass.mtx"', '"data/../stiffness.csv"'),
        ("[[2, 0], [0, 3]]", '{ file = "stiffness.csv" }'),
    ],
)
def test_the_answer_is_that_of_the_same_numbers_in_the_scene(tmp_path, mass, stiffness):
    (tmp_path / "data").mkdir()
    np.savez(tmp_path / "plant.npz", M=MASS, K=STIFFNESS)
    scipy.io.mmwrite(tmp_path / "data" / "mass.mtx", MASS)
    np.savetxt(tmp_path / "stiffness.csv", STIFFNESS, delimiter=",")
    result = scene_of(tmp_path, TEXT.format(mass=mass, stiffness=stiffness)).run()
    assert np.array_equal(result.values, scene_of(tmp_path, INLINE).run().values)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("/etc/passwd", r"model\.mass: found \"/etc/passwd\", an absolute path; data files must lie in the folder of the scene"),
        ("../outside.csv", r"model\.mass: found .*, which leads out of the folder; data files must lie"),
        ("inside/../../outside.csv", r"which leads out of the folder"),
        ("link.csv", r"which leads out of the folder"),
        ("folder/outside.csv", r"which leads out of the folder"),
        ("circle.csv", r"model\.mass: .*(leads in a circle; name the file itself|no such file in the folder)"),
        ("a" * 300 + ".csv", r"model\.mass: a{300}\.csv: the file cannot be read \(File name too long\)"),
        ("nothing.csv", r"model\.mass: nothing\.csv: there is no such file in the folder"),
        ("", r"model\.mass: found \"\"; expected the name of a"),
        ("a.xls", r"model\.mass: a\.xls: expected a file that ends in"),
        ("inside", r"expected a file that ends in"),
        ("a\\u0000.csv", r"model\.mass\.file: .*cannot be printed"),
    ],
)
def test_files_from_elsewhere_are_not_read(tmp_path, name, message):
    folder = tmp_path / "scene"
    (folder / "inside").mkdir(parents=True)
    (tmp_path / "outside.csv").write_text("1")
    os.symlink(tmp_path / "outside.csv", folder / "link.csv")
    os.symlink(tmp_path, folder / "folder")
    os.symlink("circle.csv", folder / "circle.csv")
    with pytest.raises(SceneError, match=message):
        scene_of(folder, f'[model]\nkind = "matrices"\nmass = "{name}"\n[time]\nend = 1\n')


def test_the_folder_of_a_linked_scene_is_that_of_the_link(tmp_path):
    for name, size in (("there", 1.0), ("here", 2.0)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "mass.csv").write_text(f"{size},0\n0,3\n")
    scene_of(tmp_path / "there", TEXT.format(mass='"mass.csv"', stiffness=STIFFNESS.tolist()))
    os.symlink(tmp_path / "there" / "scene.toml", tmp_path / "here" / "scene.toml")
    assert read_scene(tmp_path / "here" / "scene.toml").equations.system.mass.tolist() == MASS.tolist()
