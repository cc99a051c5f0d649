"""Work is broken off when its time is over, wherever it is then."""

import time

import pytest

from mbconstrained.scene.run import plan as module
from mbconstrained.scene.run.plan import OutOfTime, time_limit


class Slow:
    """Takes its time when it goes."""

    def __del__(self):
        time.sleep(0.2)


def test_what_takes_longer_is_broken_off():
    with pytest.raises(OutOfTime), time_limit(0.05):
        time.sleep(30.0)


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # it is lost there: that is what is tested
def test_an_alarm_that_is_lost_in_a_finalizer_is_rung_again(monkeypatch):
    monkeypatch.setattr(module, "AGAIN", 0.1)
    with pytest.raises(OutOfTime), time_limit(0.05):
        Slow()
        time.sleep(30.0)
