"""All that was asked for, one after another, and what becomes of it: text, data, picture, a part of a page of the documentation."""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from mbconstrained.analyses.timing import SMALL, machine
from mbconstrained.ground.files import replacing
from tests.benchmarks.speed import growth
from tests.benchmarks.speed.growth import Grown, grown
from tests.benchmarks.speed.measure import Effort, Measured, measured
from tests.benchmarks.speed.peers import PEERS, Method
from tests.benchmarks.speed.picture import picture_of
from tests.benchmarks.speed.report import Row, error_table, growth_sentence, growth_table, method_table, ratio_table
from tests.benchmarks.speed.workloads import WORKLOADS, Workload

#: Between these marks a file has the tables.
BEGIN, END = "<!-- speed: begin -->", "<!-- speed: end -->"

#: Time of a dense method grows at most about as this power of the number of states, once it takes so long, in s.
POWER, GROWS = 3, 1.0

#: Masses that are measured when it has to be quick.
QUICK = 100

#: What is measured besides workloads, as it is asked for.
OTHERS = (GROWTH,) = ("growth",)

#: A process that is measured makes so many runs at most, of which each may take the limit.
RUNS = 5

Tell = Callable[[str], None]


@dataclass(frozen=True)
class Report:
    """All that was measured."""

    rows: list[Row]
    growth: list[Grown]

    @property
    def summary(self) -> str:
        """For the documentation: ratios, errors, and growth in a sentence."""
        parts = [ratio_table(self.rows), error_table(self.rows)] if self.rows else []
        parts += [growth_sentence(self.growth)] if self.growth else []
        return "\n\n".join([*parts, f"Measured on {_machine()}."])

    @property
    def text(self) -> str:
        """The summary, growth, and every method of every workload."""
        each = [f"### {row.workload.key} {row.workload.name}\n\n{method_table(row)}" for row in self.rows if row.is_whole]
        return "\n\n".join([self.summary, *([growth_table(self.growth)] if self.growth else []), *each])

    def as_json(self) -> dict:
        """As plain data."""
        return {
            "machine": machine(),
            "workloads": [row.as_json() for row in self.rows],
            "growth": [one.as_json() for one in self.growth],
            "exponents": growth_sentence(self.growth) if self.growth else "",
        }

    def write(self, folder: Path) -> None:
        """speed.md and speed.png."""
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(folder / "speed.md") as beside:
            beside.write_text(f"# Speed\n\n{self.text}\n", encoding="utf-8")
        picture_of(self.rows).png(folder / "speed.png")

    def put_into(self, file: Path) -> None:
        """The summary between the two marks of a file."""
        text = with_tables(file.read_text(encoding="utf-8"), self.summary)
        with replacing(file) as beside:
            beside.write_text(text, encoding="utf-8")


def _machine() -> str:
    found = machine()
    return f"{found['processor']}, {found['cores']} cores, {found['system']}, {found['packages']}"


def with_tables(text: str, tables: str) -> str:
    """A text whose part between the marks is the tables.

    Raises:
        ValueError: it has no such part, or several.

    >>> with_tables(f"before {BEGIN} old {END} after", "new").splitlines()
    ['before <!-- speed: begin -->', '', 'new', '', '<!-- speed: end --> after']
    """
    found, count = re.subn(f"{BEGIN}.*?{END}", lambda _: f"{BEGIN}\n\n{tables}\n\n{END}", text, flags=re.DOTALL)
    if count != 1:
        raise ValueError(f"found {count} parts between {BEGIN} and {END}; expected one")
    return found


def run(only: list[str], quick: bool, limit: float, tell: Tell = lambda text: None) -> Report:
    """Measure what is asked for.

    Args:
        only: keys or parts of names; all when empty.
        quick: small models and few repeats.
        limit: of a single run, s.
        tell: hears what was found so far.
    """
    effort = Effort(3, 2, 0.5, limit=limit) if quick else Effort(limit=limit)
    rows = _rows([one for one in WORKLOADS if is_asked(one, only) and (one.states <= SMALL or not quick)], effort, tell)
    largest = QUICK if quick else math.inf
    sizes = [count for count in growth.SIZES if count <= largest] if not only or GROWTH in only else []
    grew = []
    for count in sizes:
        grew.append(grown(count, RUNS * limit))
        tell(growth_table(grew[-1:]).splitlines()[2])
    return Report(rows, grew)


def is_asked(workload: Workload, only: list[str]) -> bool:
    """Whether a workload is among those asked for by key or whole words of the name; all are when nothing is."""
    wanted = [part for part in only if part not in OTHERS]
    return not only or any(part == workload.key or re.search(rf"\b{re.escape(part)}\b", workload.name) for part in wanted)


def _rows(workloads: list[Workload], effort: Effort, tell: Tell) -> list[Row]:
    """Each workload, by ascending size; methods that were slow are not tried where they would be much slower."""
    rows: list[Row] = []
    known: dict[tuple[str, str], tuple[int, float]] = {}
    for workload in workloads:
        refusal = _Refusal(workload, known, effort.limit)
        found = measured(workload.make(), workload.states, PEERS, effort, refusal)
        refusal.remember(found)
        rows += rows_of(workload, tuple(found))
        tell(ratio_table(rows[-1:]).splitlines()[-1])
    return rows


def rows_of(workload: Workload, found: tuple[Measured, ...]) -> list[Row]:
    """One row; where only some peers are meant a second one beside all of them."""
    row = Row(workload, found)
    if not workload.target.beside:
        return [row]
    named, all_peers = f"{workload.name}, {workload.target.beside}", f"{workload.name}, all peers"
    target = replace(workload.target, one_run=None, further=None, beside="")
    return [Row(replace(workload, name=named), found), Row(replace(workload, name=all_peers, target=target), found)]


@dataclass(frozen=True)
class _Refusal:
    """Tells of a method why it is not tried on a workload."""

    workload: Workload
    known: dict[tuple[str, str], tuple[int, float]]
    limit: float

    @property
    def _family(self) -> str:
        return self.workload.family or self.workload.name

    def __call__(self, method: Method) -> str:
        states, seconds = self.known.get((self._family, method.name), (self.workload.states, 0.0))
        expected = seconds * (self.workload.states / states) ** POWER if seconds > GROWS else seconds
        return f"not run: about {expected:.0f} s expected, over {self.limit:g} s" if expected > 3 * self.limit else ""

    def remember(self, found: list[Measured]) -> None:
        """For larger ones of its kind; what was broken off took the limit at least."""
        for method in found:
            seconds = method.one_run.median if not method.failure else self.limit if "limit" in method.failure else 0.0
            self.known[self._family, method.name] = self.workload.states, seconds
