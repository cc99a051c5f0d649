"""What is printed of results is one short line, whatever is in them."""

import pytest

from tests.exact.symbolic.models import MASSLESS_JOINTS, RIGID_LINK
from tests.exact.symbolic.test_long_coefficients import DAMPED_LINK


@pytest.mark.parametrize("A", [MASSLESS_JOINTS, RIGID_LINK, DAMPED_LINK], ids=["5.2", "rigid link", "damped link"])
def test_they_are_short(A):
    pairs = A.jordan_pairs()
    shown = [pairs, pairs.finite, pairs.rational, pairs.infinite, pairs.laurent, *pairs.chains, *pairs.finite.blocks]
    shown += [*pairs.structure.elementary_divisors, *pairs.infinity]
    for thing in shown:
        text = repr(thing)
        assert text.startswith(type(thing).__name__) and "\n" not in text and "object at" not in text
        assert len(text) <= 300
