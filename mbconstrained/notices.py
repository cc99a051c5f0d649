"""What a result says about itself: jumps, impulses, redundant rows, drift, doubtful decisions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Kind = Literal[
    "jump", "impulse", "redundant", "drift", "rigid body", "unstable", "rank", "accuracy", "offset",
    "left out", "unsymmetric", "far", "large motion", "set", "at rest", "aliased",
]  # fmt: skip


@dataclass(frozen=True)
class Notice:
    """One plain sentence that a result carries with it.

    Attributes:
        kind: what it is about.
        text: the sentence, with names and units.
        doubtful: True where the answer itself may be wrong (a rank decision without a clear gap, an
            ill-conditioned answer); False for physics that is merely worth knowing.
    """

    kind: Kind
    text: str
    doubtful: bool = False

    def __str__(self) -> str:
        return f"{'warning' if self.doubtful else 'note'} ({self.kind}): {self.text}"
