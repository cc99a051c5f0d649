"""Speed beside what one would use instead: ratios to the fastest peer of equal or smaller error, in one process, in turns.

    python tests/benchmarks/speed.py                       # all: half an hour
    python tests/benchmarks/speed.py --quick               # small models, few repeats: a minute
    python tests/benchmarks/speed.py --only W1 "n = 100"   # workloads by key or part of the name; also: growth
    python tests/benchmarks/speed.py --json FILE --out DIR # data; tables and picture (speed.md, speed.png) into a folder
    python tests/benchmarks/speed.py --page FILE           # the tables into a page, between its two marks

Each workload is a model as a user gives it; peers get its reduced equations for nothing. One run is model, solution and values
at all times; a further evaluation is at other times of the same model and start. Errors are against references in ball
arithmetic or long doubles, which take some minutes. A run that takes longer than the limit is broken off, and larger ones of its
kind are not tried.
"""

import argparse
import json
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [] if str(ROOT) in sys.path else [str(ROOT)]

from tests.benchmarks.speed.command import run, with_tables
from tests.benchmarks.speed.growth import grow


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=[], help="keys or parts of names of workloads; growth")
    parser.add_argument("--json", type=Path, help="where the data go")
    parser.add_argument("--out", type=Path, help="folder for tables and picture")
    parser.add_argument("--page", type=Path, help="file whose marked part becomes the tables")
    parser.add_argument("--quick", action="store_true", help="up to 250 states, few repeats")
    parser.add_argument("--limit", type=float, default=60.0, help="s that a single run may take")
    parser.add_argument("--grow", type=int, help=argparse.SUPPRESS)
    chosen = parser.parse_args()
    if chosen.grow:
        return grow(chosen.grow)
    check_places(chosen.json, chosen.page)
    report = run(chosen.only, chosen.quick, chosen.limit, say)
    print(report.text)
    if chosen.json:
        chosen.json.write_text(json.dumps(report.as_json(), indent=2, allow_nan=False) + "\n", encoding="utf-8")
    if chosen.out:
        report.write(chosen.out)
    if chosen.page:
        report.put_into(chosen.page)


def check_places(data: Path | None, page: Path | None) -> None:
    """What cannot be written is found out before half an hour of measuring, not after."""
    if data:
        data.parent.mkdir(parents=True, exist_ok=True)
    if page:
        with_tables(page.read_text(encoding="utf-8"), "")


def say(text: str) -> None:
    """What was found so far."""
    print(text, file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
