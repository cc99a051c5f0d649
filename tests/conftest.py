"""What all tests share.

Hypothesis draws the same examples on every run. For a search, on a machine that is idle at night:

    python -m pytest --hypothesis-profile=search -m "long or not long" --numprocesses auto

draws 500 new examples for each property and prints how to repeat one that fails.
"""

import os
import sys
from collections import defaultdict

import pytest
from hypothesis import HealthCheck, settings

from tests.page.browser import Browser

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when NumPy is first imported: tests run in several processes
os.environ.setdefault("OMP_NUM_THREADS", "1")

SLOW = [HealthCheck.too_slow, HealthCheck.filter_too_much, HealthCheck.data_too_large]
settings.register_profile("same", derandomize=True, database=None, max_examples=12, deadline=None, suppress_health_check=SLOW)
settings.register_profile("search", max_examples=500, deadline=None, print_blob=True, suppress_health_check=SLOW)
settings.load_profile("same")


#: Of a test with more cases than this the default run takes so many, spread over all of them; the others are long.
CASES = 5


def pytest_collection_modifyitems(items):
    """A property that holds for hundreds of cases is tested with some of them first: ``-m "long or not long"`` tests all."""
    cases = defaultdict(list)
    for item in items:
        if not any(item.iter_markers("long")):
            cases[item.nodeid.partition("[")[0]].append(item)
    for group in cases.values():
        chosen = {round(k * (len(group) - 1) / (CASES - 1)) for k in range(CASES)}
        for number, item in enumerate(group):
            if number not in chosen:
                item.add_marker("long")


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


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    browser = Browser(tmp_path_factory.mktemp("profile"))
    yield browser
    browser.close()


@pytest.fixture(scope="module")
def browser(chromium):
    """One Chromium for all tests, in each file as it was when it started."""
    return chromium.reset()
