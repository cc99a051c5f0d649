"""Every scene answers every command as it did when the corpus was frozen; see ``corpus``."""

import pytest

from tests.golden.corpus import differences, scenes

#: Other processors round otherwise, and some answers are ill-conditioned: what moves code is compared to 1e-12, by the corpus itself.
PROCESSORS = 1e-6


@pytest.mark.parametrize("scene", scenes())
def test_answers_are_those_of_the_corpus(scene):
    different = {key: value for key, value in differences(scene).items() if value > PROCESSORS}
    assert not different
