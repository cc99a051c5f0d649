"""The median and the quartiles of repeats; nothing here depends on how fast the machine is."""

import gc

import pytest

from mbconstrained.analyses.timing import Timing, duration, without_garbage_collection


def test_median_and_quartiles():
    timing = Timing((4.0, 1.0, 2.0, 3.0, 100.0))
    assert timing.median == 3.0 and timing.quartiles == (2.0, 4.0)
    assert timing.to_dict() == {"median": 3.0, "lower_quartile": 2.0, "upper_quartile": 4.0, "repeats": 5}
    assert Timing((2.0,)).quartiles == (2.0, 2.0)


def test_a_sum_is_taken_repeat_by_repeat():
    """Medians do not add up: those of (1, 9, 5) and (5, 1, 3) are 5 and 3, that of the sums 6, 10, 8 is 8."""
    assert (Timing((1.0, 9.0, 5.0)) + Timing((5.0, 1.0, 3.0))).median == 8.0


@pytest.mark.parametrize("enabled", [True, False])
def test_garbage_collection_is_as_it_was(enabled):
    was = gc.isenabled()
    (gc.enable if enabled else gc.disable)()
    try:
        with pytest.raises(LookupError), without_garbage_collection():
            assert not gc.isenabled()
            raise LookupError
        assert gc.isenabled() == enabled
    finally:
        (gc.enable if was else gc.disable)()


@pytest.mark.parametrize(
    "seconds, text", [(3e-9, "3 ns"), (1e-3, "1 ms"), (0.9999, "1 s"), (0.00099949, "999 µs"), (1.0, "1 s"), (75.0, "75 s")]
)
def test_durations_read_well(seconds, text):
    assert duration(seconds) == text
