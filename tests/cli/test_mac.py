"""The modal assurance criterion against SciPy's eigenvectors of the matrices, and what its command does."""

import json

import numpy as np
import pytest
from scipy.linalg import eigh

import mbconstrained as mb
from mbconstrained.analyses.mac import ModalAssurance
from tests.scene.scenes import EXAMPLES

CHAIN = """
[model]
kind = "matrices"
coordinates = ["a", "b", "c"]
mass = [[1, 0, 0], [0, 2, 0], [0, 0, 1]]
stiffness = [[{k}, -4, 0], [-4, 9, -5], [0, -5, 5]]
[time]
end = "1 s"
"""


def scenes(tmp_path, *stiffnesses):
    paths = [tmp_path / f"chain{i}.toml" for i in range(len(stiffnesses))]
    for path, k in zip(paths, stiffnesses):
        path.write_text(CHAIN.replace("{k}", str(k)))
    return paths


def test_the_criterion_is_that_of_the_eigenvectors(tmp_path):
    first, second = scenes(tmp_path, 4, 40)
    answer = ModalAssurance.answer(mb.read_scene(first), other=str(second))
    M = np.diag([1.0, 2.0, 1.0])
    K = np.array([[4.0, -4, 0], [-4, 9, -5], [0, -5, 5]])
    (_, A), (_, B) = eigh(K, M), eigh(K + np.diag([36.0, 0, 0]), M)
    A, B = (vectors / np.linalg.norm(vectors, axis=0) for vectors in (A, B))
    expected = (A.T @ B) ** 2
    found = answer.arrays()["mac"]
    assert found == pytest.approx(expected[-found.shape[0] :, -found.shape[1] :], abs=1e-12)


def test_a_scene_has_the_modes_of_itself_and_a_changed_mode_is_named(tmp_path):
    first, second = scenes(tmp_path, 5, 500)
    same = ModalAssurance.answer(mb.read_scene(first), other=str(first))
    assert np.diag(same.arrays()["mac"]) == pytest.approx(1.0) and not same.notices
    changed = ModalAssurance.answer(mb.read_scene(first), other=str(second))
    assert any("no mode of chain1 has the shape of mode" in notice.text for notice in changed.notices)


def test_the_command_has_all_that_answers_have(command, tmp_path):
    first, second = map(str, scenes(tmp_path, 5, 6))
    code, out, _ = command("mac", first, "--other", second, "--json", "--plots", "--out", str(tmp_path / "out"))
    data = json.loads(out)
    assert code == 0 and len(data["pairs"]) == 3
    assert {path.rsplit(".", 1)[-1] for path in data["files"]} == {"html", "csv", "npz", "svg", "png"}
    assert command("mac", first)[0] == 1
    assert "no coordinate in common" in command("mac", first, "--other", str(EXAMPLES / "three_storeys.toml"))[2]
