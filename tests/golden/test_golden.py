"""Every scene answers every command as it did when the corpus was frozen; see ``corpus``."""

import json

import pytest

from tests.golden.corpus import FOLDER, answers, difference, scenes

#: Numbers agree to this share of the largest of their column, or to so many times the difference between two kernels of OpenBLAS.
TOLERANCE, KERNELS = 1e-12, 20.0


@pytest.mark.parametrize("scene", scenes())
def test_answers_are_those_of_the_corpus(scene):
    stored, found = json.loads((FOLDER / f"{scene}.json").read_text()), answers(scene)
    assert stored.keys() == found.keys()
    for command, answer in stored.items():
        now = found[command]
        assert now["exit"] == answer["exit"], command
        assert now["texts"] == answer["texts"], command
        assert now["numbers"].keys() == answer["numbers"].keys(), command
        for key, column in answer["numbers"].items():
            allowed = max(TOLERANCE, KERNELS * float(column["kernel"]))
            assert difference(column, now["numbers"][key]) <= allowed, f"{command}: {key}"
