"""The report: ratios to the fastest peer of equal or smaller error, whether they are as small as wanted, tables and data."""

from collections.abc import Callable
from dataclasses import dataclass

from mbconstrained.analyses.accuracy.accuracy import ratio as shown_ratio
from mbconstrained.analyses.timing import Timing, duration
from tests.benchmarks.speed.growth import Grown, exponent
from tests.benchmarks.speed.measure import Measured
from tests.benchmarks.speed.workloads import Workload

#: A peer counts as equally right up to this many times our error, which is one digit: rounding alone moves errors by a few.
EQUAL = 10.0

NOTHING = "–"


@dataclass(frozen=True)
class Row:
    """A workload that was measured; the first of all methods is the package."""

    workload: Workload
    methods: tuple[Measured, ...]

    @property
    def is_whole(self) -> bool:
        """Whether no other row shows the same methods beside more peers."""
        return not self.workload.target.beside

    @property
    def ours(self) -> Measured:
        """The package."""
        return self.methods[0]

    def rival(self, part: str) -> Measured | None:
        """The fastest peer with an error like ours or smaller, by one_run or further; None if there is none."""
        if self.ours.failure:
            return None
        return min(self._as_right(), key=lambda peer: getattr(peer, part).median, default=None)

    def _as_right(self) -> list[Measured]:
        """Peers with an error like ours, or with the one that is wanted: DOP853 comes no closer than that."""
        meant = [peer for peer in self.methods[1:] if not peer.failure and peer.name.startswith(self.workload.target.beside)]
        allowed = max(EQUAL * self.ours.error, self.workload.target.error or 0.0)
        return [peer for peer in meant if peer.error <= allowed]

    def ratio(self, part: str) -> float | None:
        """Our time over the rival's."""
        rival = self.rival(part)
        return None if rival is None else getattr(self.ours, part).median / getattr(rival, part).median

    def is_met(self, part: str, name: str = "") -> bool | None:
        """Whether the ratio to the rival, or a named peer, is as small as wanted; None where nothing is wanted or comparable."""
        wanted, found = getattr(self.workload.target, part), self.beside(name, part) if name else self.ratio(part)
        if wanted is None or (self.ours.failure and not wanted):
            return None
        return False if self.ours.failure else None if found is None else found <= wanted

    @property
    def is_right(self) -> bool | None:
        """Whether the error is as small as wanted, or no larger than lsim's where that can be told and nothing is wanted."""
        if self.ours.failure:
            return None
        if self.workload.target.error is not None:
            return self.ours.error <= self.workload.target.error
        lsim = self.error_of("lsim")
        return None if lsim is None else self.ours.error <= lsim

    def beside(self, name: str, part: str) -> float | None:
        """Our time over that of a peer; None where one of them did not run or it is not as right."""
        peer = None if self.ours.failure else next((peer for peer in self._as_right() if peer.name == name), None)
        return None if peer is None else getattr(self.ours, part).median / getattr(peer, part).median

    def error_of(self, name: str) -> float | None:
        """Of a peer; None where it did not run."""
        return next((peer.error for peer in self.methods if peer.name == name and not peer.failure), None)

    def as_json(self) -> dict:
        """As plain data."""
        target = self.workload.target
        ratios = {part: self._judged(part, getattr(target, part)) for part in PARTS}
        return {
            "key": self.workload.key,
            "name": self.workload.name,
            "coordinates": self.workload.coordinates,
            "states": self.workload.states,
            "ratios": ratios,
            "right": self.is_right,
            "methods": [method.as_json() for method in self.methods],
        }

    def _judged(self, part: str, wanted: float | None) -> dict:
        beside = {"ratio_to_lsim": self.beside("lsim", part), "met_beside_lsim": self.is_met(part, "lsim")}
        return {"ratio": self.ratio(part), "wanted": wanted, "met": self.is_met(part)} | beside


PARTS = ("one_run", "further")


def ratio_table(rows: list[Row]) -> str:
    """Markdown: times, one row for each workload."""
    head = ["", "workload", "states"]
    for part in ("one run", "further"):
        head += [part, "fastest peer", "ratio to it", "to lsim", "wanted"]
    return markdown(head, [_ratio_row(row) for row in rows])


def _ratio_row(row: Row) -> list[str]:
    plain = [row.workload.key, row.workload.name, str(row.workload.states)]
    if row.ours.failure:
        return [*plain, row.ours.failure, *[NOTHING] * 9]
    return [*plain, *(cell for part in PARTS for cell in _ratio_cells(row, part))]


def _ratio_cells(row: Row, part: str) -> list[str]:
    rival, wanted = row.rival(part), getattr(row.workload.target, part)
    peer = NOTHING if rival is None else f"{rival.name} {duration(getattr(rival, part).median)}"
    ratio = _told(row.ratio(part), shown_ratio)
    to_lsim, signs = _told(row.beside("lsim", part), shown_ratio), [row.is_met(part)]
    signs += [row.is_met(part, "lsim")] if to_lsim != NOTHING else []
    return [duration(getattr(row.ours, part).median), peer, ratio, to_lsim, _wanted(wanted, *signs)]


def error_table(rows: list[Row]) -> str:
    """Markdown: errors, one row for each workload."""
    head = ["", "workload", "error", "wanted", "lsim's", "no larger than lsim's", "fastest peer's", "smallest of all peers"]
    return markdown(head, [_error_row(row) for row in rows])


def _error_row(row: Row) -> list[str]:
    plain = [row.workload.key, row.workload.name]
    if row.ours.failure:
        return [*plain, *[NOTHING] * 6]
    ours, lsim, rival, wanted = row.ours.error, row.error_of("lsim"), row.rival("one_run"), row.workload.target.error
    smallest = min((peer.error for peer in row.methods[1:] if not peer.failure), default=None)
    cells = [_error(ours), _wanted(wanted, wanted and ours <= wanted), _error(lsim), _sign(None if lsim is None else ours <= lsim)]
    return [*plain, *cells, _error(rival and rival.error), _error(smallest)]


def _told(value: float | None, shown: Callable[[float], str]) -> str:
    return NOTHING if value is None else shown(value)


def _error(value: float | None) -> str:
    return _told(value, "{:.1e}".format)


def _wanted(wanted: float | None, *met: bool | None) -> str:
    """With a sign for the fastest peer, and one for lsim where that is known."""
    return NOTHING if wanted is None else " ".join([f"≤ {wanted:g}", *filter(None, map(_sign, met))])


def _sign(met: bool | None) -> str:
    return {True: "✓", False: "✗", None: ""}[met]


def method_table(row: Row) -> str:
    """Markdown: every method of a workload, with the spread of its times."""
    head = [
        "method",
        "set-up",
        "evaluation",
        "one run (quartiles)",
        "warming up",
        "further (quartiles)",
        "error",
        "threads",
        "runs",
    ]
    return markdown(head, [_method_row(method) for method in row.methods])


def _method_row(method: Measured) -> list[str]:
    if method.failure:
        return [method.name, method.failure, *[NOTHING] * 7]
    plain = [duration(part.median) for part in (method.set_up, method.evaluation)]
    times = [spread(method.one_run), duration(method.warming.median), spread(method.further)]
    return [
        method.name,
        *plain,
        *times,
        f"{method.error:.1e}",
        str(method.threads or "own choice"),
        str(len(method.one_run.seconds)),
    ]


def spread(timing: Timing) -> str:
    """Median and quartiles."""
    low, high = timing.quartiles
    return f"{duration(timing.median)} ({duration(low)} … {duration(high)})"


def growth_table(found: list[Grown]) -> str:
    """Markdown: time and memory by size."""
    head = ["n", "states", "one run", "further", "memory", "of it the answer", "rest, in matrices of the states squared"]
    rows = [_growth_row(one) for one in found]
    return markdown(head, rows)


def growth_sentence(found: list[Grown]) -> str:
    """The exponents in words."""
    ran = [one for one in found if not one.failure]
    states = [one.states for one in ran]
    fits = {name: exponent(states, [getattr(one, name) for one in ran]) for name in ("seconds", "further", "memory")}
    told = [f"{name} {NOTHING if fits[key] is None else f'{fits[key]:.1f}'}" for key, name in EXPONENTS.items()]
    return f"Fitted exponents over the largest sizes, in the number of states: {', '.join(told)}."


#: Of what growth is told.
EXPONENTS = {"seconds": "one run", "further": "further evaluation", "memory": "memory"}


def _growth_row(one: Grown) -> list[str]:
    if one.failure:
        return [str(one.count), str(one.states), one.failure, *[NOTHING] * 4]
    memory = [f"{size / 2**20:.3g} MiB" for size in (one.memory, one.answer)]
    return [str(one.count), str(one.states), duration(one.seconds), duration(one.further), *memory, f"{one.matrices:.1f}"]


def markdown(head: list[str], rows: list[list[str]]) -> str:
    """A table.

    >>> print(markdown(["a", "b"], [["1", "2"]]))
    | a | b |
    |---|---|
    | 1 | 2 |
    """
    lines = [head, *rows]
    shown = [f"| {' | '.join(line)} |" for line in lines]
    return "\n".join([shown[0], "|" + "---|" * len(head), *shown[1:]])
