"""The number of threads is limited within, and as it was afterwards."""

from pathlib import Path

import numpy
import pytest
import scipy.linalg
from threadpoolctl import threadpool_info, threadpool_limits

from mbconstrained.ground.threads import SMALL, one_thread


def counts() -> list[int]:
    """Of the libraries of NumPy and SciPy; a package that another test has imported may have brought a third."""
    ours = {str(Path(package.__file__).parent.with_suffix(".libs")) for package in (numpy, scipy)}
    libraries = [library for library in threadpool_info() if library["user_api"] == "blas"]
    bundled = [library for library in libraries if str(Path(library["filepath"]).parent) in ours]
    return [library["num_threads"] for library in bundled or libraries]  # a system's own library serves both


@pytest.mark.parametrize("threads", [1, 2])
def test_one_thread_within_and_the_users_setting_afterwards(threads):
    with threadpool_limits(threads, user_api="blas"):
        before = counts()
        with one_thread(SMALL):
            assert set(counts()) == {1}
        assert counts() == before


def test_it_is_restored_after_an_error_and_small_problems_are_left_alone():
    with threadpool_limits(2, user_api="blas"):
        before = counts()
        with pytest.raises(ZeroDivisionError), one_thread(SMALL):
            raise ZeroDivisionError
        assert counts() == before
        with one_thread(SMALL - 1):
            assert counts() == before
