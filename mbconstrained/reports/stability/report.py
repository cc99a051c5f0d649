"""How many digits are right where it is hard: the gallery's systems, or a scene that is turned over decades."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...checks import counted
from ..machine import machine
from .knobs import knobs_of
from .sweeps import Sweep, points_of

if TYPE_CHECKING:
    from ...scene import Scene
    from .gallery import System
    from .point import Point

#: What a scene has is turned from 10^-DECADES to 10^DECADES times what it is, so many decades at a step.
DECADES, STEP = 8, 2

#: An answer is called short of what the data allow when it has so many digits fewer.
SHORT = 0.5

Tell = Callable[[str], None]


@dataclass(frozen=True)
class StabilityReport:
    """What was found.

    Attributes:
        title: of the scene, or of the gallery.
        sweeps: one for each system of the gallery, or for each thing that was turned.
        machine: on what it was made.
        of_scene: whether a scene was turned.
    """

    title: str
    sweeps: tuple[Sweep, ...]
    machine: dict[str, str]
    of_scene: bool

    def count(self, verdict: str) -> int:
        """How many points have a verdict: right, told, refused, not judged or wrong."""
        return sum(sweep.count(verdict) for sweep in self.sweeps)

    @property
    def is_trusted(self) -> bool:
        """Whether no answer was wrong without a warning."""
        return not self.count("wrong")

    @property
    def verdict(self) -> tuple[str, ...]:
        """The outcome in sentences."""
        return (self._trust(), self._counts(), *self._extremes(), *self._promises())

    def _trust(self) -> str:
        judged, wrong = sum(len(sweep.answers) for sweep in self.sweeps), self.count("wrong")
        if not judged:
            return "Nothing was held against exact arithmetic: no answer is known to be right or wrong."
        held = f"{counted(judged, 'answer')} held against exact arithmetic"
        return f"{wrong or 'None'} of {held} {'are' if wrong > 1 else 'is'} wrong without a warning."

    def _counts(self) -> str:
        told = [f"{counted(self.count('right'), 'answer')} had the digits that the estimate claims"]
        others = {"told": "came with a warning", "refused": "refused with a reason", "not judged": "not judged by exact arithmetic"}
        told += [f"{self.count(verdict)} {text}" for verdict, text in others.items() if self.count(verdict)]
        return f"{', '.join(told)}."

    def _extremes(self) -> tuple[str, ...]:
        """The least digits without a warning, and where fewer are right than the data allow."""
        silent = [(sweep, point) for sweep in self.sweeps for point in sweep.answers if point.verdict == "right"]
        if not silent:
            return ()
        sweep, least = min(silent, key=lambda found: found[1].right)
        sentences = [f"Fewest digits without a warning: {_digits(sweep, least)}."]
        known = [(sweep, point) for sweep, point in silent if not math.isnan(point.expected)]
        sweep, short = max(known, key=lambda found: found[1].expected - found[1].right, default=(sweep, least))
        if short.expected - short.right > SHORT:
            sentences.append(f"Furthest below what the data allow: {_digits(sweep, short)}.")
        return tuple(sentences)

    def _promises(self) -> tuple[str, ...]:
        """Whether the systems of the gallery are what they declare to be."""
        broken = [promise for sweep in self.sweeps for promise in sweep.broken]
        if broken:
            return (f"Not as declared: {'; '.join(broken)}.",)
        return () if self.of_scene else ("What the systems declare of themselves holds, by exact arithmetic.",)

    def as_json(self) -> dict:
        """Everything as plain data."""
        counts = {verdict: self.count(verdict) for verdict in ("right", "told", "refused", "not judged", "wrong")}
        return {
            "title": self.title,
            "trusted": self.is_trusted,
            "verdict": list(self.verdict),
            "counts": counts,
            "machine": self.machine,
            "sweeps": [sweep.as_json() for sweep in self.sweeps],
        }


def gallery_report(systems: Sequence[System] = (), tell: Tell = lambda text: None) -> StabilityReport:
    """Run the gallery of stiff and extreme systems.

    Args:
        systems: some of them; all when not given.
        tell: is told what is being solved.
    """
    if not systems:
        from .gallery import GALLERY as systems
    sweeps = [_of_system(system, tell) for system in systems]
    return StabilityReport("Gallery of stiff and extreme systems", tuple(sweeps), machine(), of_scene=False)


def _of_system(system: System, tell: Tell) -> Sweep:
    from .gallery import broken_promises

    points = points_of(system.build, system.values, lambda text: tell(f"{system.title}: {text}"))
    broken = [promise for value in system.values for promise in broken_promises(system, value)]
    return Sweep(system.name, system.title, system.theme, system.hard, system.source, system.parameter, points, tuple(broken))


def scene_report(scene: Scene, decades: int = DECADES, step: int = STEP, tell: Tell = lambda text: None) -> StabilityReport:
    """Turn what a scene is made of, and its horizon, over decades.

    Args:
        decades: from 10^-decades to 10^decades times what it is.
        step: so many decades at a step, up and down from 1; the last one may be shorter.
        tell: is told what is being solved.
    """
    up = [*range(step, decades, step), decades]
    factors = [float(f"1e{exponent}") for exponent in (*(-power for power in reversed(up)), 0, *up)]
    sweeps = []
    for knob in knobs_of(scene):
        points = points_of(knob.turned, factors, lambda text, knob=knob: tell(f"{knob.name} times {text}"))
        sweeps.append(Sweep(knob.name, knob.name, "", "", "", f"factor on {knob.name}", points))
    return StabilityReport(scene.heading, tuple(sweeps), machine(), of_scene=True)


def _digits(sweep: Sweep, point: Point) -> str:
    """Where it is and what its digits are."""
    expected = "" if math.isnan(point.expected) else f", {point.expected:.1f} allowed by the data"
    return f"{point.right:.1f} right, {point.claimed:.1f} claimed{expected} ({sweep.title}, {sweep.told_parameter(point)})"
