"""All referee cases whose float data are the problem itself: every value of 30 digits lies between the bounds.

The cases of the family "rounded" belong to unrounded matrices: the response of their float data is another one, and where
the difference decides a rank it is told.
"""

from fractions import Fraction

import numpy as np
import pytest

import mbconstrained as mb
from tests.oracles.referee import NAMES, answer, case

EXACT = [name for name in NAMES if not name.startswith("rot_")]


def exact(strings) -> np.ndarray:
    return np.vectorize(Fraction, otypes=[object])(np.asarray(strings, dtype=object))


@pytest.mark.parametrize("name", EXACT)
@pytest.mark.parametrize("digits", [15, 25])
def test_every_value_of_thirty_digits_lies_between_the_bounds(name, digits):
    given, x = case(name), answer(name)
    box = x.enclose(given.times, digits)
    values = np.array(given.record["x_reg"], dtype=object).reshape(len(given.times), -1).T
    assert not box.notices
    assert box.contains(values)
    low, high = exact(box.lower), exact(box.upper)
    assert all(h - l <= max(abs(h), abs(l)) / 10**digits for l, h in zip(low.ravel(), high.ravel()))


@pytest.mark.parametrize("name", EXACT)
def test_impulses_are_exact(name):
    given, x = case(name), answer(name)
    found = x.exact.impulses
    assert len(found) == max([order + 1 for order, vector in given.impulses.items() if vector.any()], default=0)
    for order, impulse in enumerate(found):
        printed = next((item["vec"] for item in given.record["impulses"] if item["order"] == order), [0] * len(impulse))
        for ours, theirs in zip(impulse, map(Fraction, printed)):  # printed with 30 digits
            assert abs(ours - theirs) <= abs(ours) * Fraction(1, 10**28)


@pytest.mark.parametrize("name", [name for name in NAMES if name.startswith("rot_")])
def test_rounded_data_are_enclosed_as_they_are_or_told_to_have_another_structure(name):
    """Where the structure is the same, float data are a perturbation of the size of eps: the answer lies within the fair bar."""
    given, x = case(name), answer(name)
    if x.exact.matrix.determinant.degree() == given.record["n"]:
        box = x.enclose(given.times)
        assert not box.notices
        assert box.error_bounds(given.values).max() <= given.fair_bar * given.scale
    else:
        try:
            box = x.enclose(given.times)
        except mb.Overflow as problem:
            assert "right half plane" in str(problem)
        else:
            assert "finite zeros" in box.notices[0].text and box.notices[0].doubtful
