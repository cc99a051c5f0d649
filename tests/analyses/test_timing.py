"""The median and the quartiles of repeats; nothing here depends on how fast the machine is."""

import pytest

from mbconstrained.analyses.timing import Timing, duration


def test_median_and_quartiles():
    timing = Timing((4.0, 1.0, 2.0, 3.0, 100.0))
    assert timing.median == 3.0 and timing.quartiles == (2.0, 4.0)
    assert timing.to_dict() == {"median": 3.0, "lower_quartile": 2.0, "upper_quartile": 4.0, "repeats": 5}
    assert Timing((2.0,)).quartiles == (2.0, 2.0)


@pytest.mark.parametrize(
    "seconds, text", [(3e-9, "3 ns"), (1e-3, "1 ms"), (0.9999, "1 s"), (0.00099949, "999 µs"), (1.0, "1 s"), (75.0, "75 s")]
)
def test_durations_read_well(seconds, text):
    assert duration(seconds) == text
