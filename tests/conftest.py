"""One hypothesis profile for all tests: the same examples on every run, no time limit for a single one.

The tests run in several processes at once, each of which gets one thread for its linear algebra.
"""

import os
import sys

import pytest
from hypothesis import HealthCheck, settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when NumPy is first imported
os.environ.setdefault("OMP_NUM_THREADS", "1")

settings.register_profile(
    "reproducible",
    deadline=None,
    derandomize=True,
    database=None,
    max_examples=24,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much],
)
settings.load_profile("reproducible")


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """Run the command line in this process, in a folder of its own: (exit code, output, error output)."""
    from mbconstrained import cli  # after the number of threads is set

    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["mbconstrained", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            cli.main()
        return left.value.code, *capsys.readouterr()

    return run
