"""What all tests share.

Hypothesis draws the same examples on every run. For a search, on a machine that is idle at night:

    python -m pytest --hypothesis-profile=search -m "long or not long" --numprocesses auto

draws 500 new examples for each property and prints how to repeat one that fails.
"""

import os
import sys

import pytest
from hypothesis import HealthCheck, settings

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when NumPy is first imported: tests run in several processes
os.environ.setdefault("OMP_NUM_THREADS", "1")

SLOW = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large]
settings.register_profile("same", derandomize=True, database=None, max_examples=24, deadline=None, suppress_health_check=SLOW)
settings.register_profile("search", max_examples=500, deadline=None, print_blob=True, suppress_health_check=SLOW)
settings.load_profile("same")


@pytest.fixture
def command(monkeypatch, capsys, tmp_path):
    """Run the command line in this process, in a folder of its own: (exit code, output, error output)."""
    from mbconstrained import cli

    monkeypatch.chdir(tmp_path)

    def run(*arguments):
        monkeypatch.setattr(sys, "argv", ["mbconstrained", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            cli.main()
        return left.value.code, *capsys.readouterr()

    return run
