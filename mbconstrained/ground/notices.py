"""Notices: what a result reports about itself, such as jumps, impulses, redundant rows and doubtful decisions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum
from itertools import chain

from .tolerances import TRUST_LIMIT


class NoticeKind(StrEnum):
    """The subject of a notice, printed in brackets before its text.

    Attributes:
        meaning: subject of a notice of this kind.

    >>> NoticeKind.RANK == "rank", NoticeKind("rank").meaning
    (True, 'a numerical rank decision and what it decided')
    """

    meaning: str

    def __new__(cls, value: str, meaning: str):
        """A member that prints as its value."""
        member = str.__new__(cls, value)
        member._value_, member.meaning = value, meaning
        return member

    JUMP = "jump", "a value differs just before and just after a time, because the values at 0- are inconsistent or a load jumps"
    KINK = "kink", "the excitation is continuous but its slope is not, so that rates that follow it jump"
    IMPULSE = "impulse", "a value or a reaction contains Dirac's delta or one of its derivatives"
    REDUNDANT = "redundant", "a constraint row follows from others; the equations leave it out"
    FREE = "free", "a coordinate that the equations leave free, and its motion"
    DRIFT = "drift", "a constraint at velocity or acceleration level, of which no equation corrects the position"
    RIGID_BODY = "rigid body", "an unconstrained motion, and the force or constraint that would remove it"
    UNSTABLE = "unstable", "an eigenvalue with a positive real part"
    RANK = "rank", "a numerical rank decision and what it decided"
    ACCURACY = "accuracy", "how accurate the values are, and what limits them"
    STATIC_LOAD = "static load", "constant forces of rest lengths and weights that act from t = 0 on"
    RECORD = "record", "how a record in a file was read, what is missing in it, and what was corrected"
    OMITTED = "omitted", "a part of the input or of the requested output that was left out"
    UNSYMMETRIC = "unsymmetric", "a matrix that is unsymmetric, and the load that causes it"
    DISTANT_POSTURE = "distant posture", "an equilibrium of a robot far from the guess"
    LARGE_MOTION = "large motion", "a motion beyond the range in which the linear equations represent the model"
    OVERRIDE = "override", "a value of the scene file that the command line replaced"
    DAMPING = "damping", "which velocity mass-proportional damping acts on"
    SWITCH = "switch", "the equations change: a contact, a connection or a friction force takes another state"
    AT_REST = "at rest", "nothing moves in the given time"
    ALIASING = "aliasing", "the fastest motion is too fast for the times of the output"


@dataclass(frozen=True)
class Notice:
    """Notice: a sentence about a result.

    Attributes:
        kind: its subject.
        text: the sentence, with names and units.
        doubtful: True where the answer itself may be wrong (a rank decision without a clear gap, an
            ill-conditioned answer); False for physics that is merely worth knowing.

    >>> print(Notice(NoticeKind.JUMP, "cart: its velocity jumps at t = 0 by 2 m/s"))
    note (jump): cart: its velocity jumps at t = 0 by 2 m/s
    """

    kind: NoticeKind
    text: str
    doubtful: bool = False

    def __str__(self) -> str:
        return f"{'warning' if self.doubtful else 'note'} ({self.kind}): {self.text}"

    def to_dict(self) -> dict:
        """The notice as plain data."""
        return {"kind": self.kind, "text": self.text, "doubtful": self.doubtful}


def distinct(*sources: Iterable[Notice]) -> tuple[Notice, ...]:
    """Notices of several sources, which may know the same: each once, in their order.

    >>> notice = Notice(NoticeKind.AT_REST, "nothing moves")
    >>> len(distinct([notice], [notice]))
    1
    """
    return tuple(dict.fromkeys(chain(*sources)))


def doubts_of(what: str, estimate: float) -> tuple[Notice, ...]:
    """The notice of an unreliable answer; none for a reliable one.

    >>> doubts_of("the displacement", 1e-9)
    ()
    >>> print(*doubts_of("the displacement", 0.25))
    warning (accuracy): the estimated relative error of the displacement is 0.25: the data do not determine it well enough
    """
    if estimate <= TRUST_LIMIT:
        return ()
    text = f"the estimated relative error of {what} is {estimate:.2g}: the data do not determine it well enough"
    if not estimate < 1:
        text = f"no digit of {what} is sure: the estimated error is as large as the values"
    return (Notice(NoticeKind.ACCURACY, text, doubtful=True),)


@dataclass(frozen=True)
class Evidence:
    """A measured number with its meaning."""

    name: str  # a short name
    value: float  # the number
    text: str  # its meaning, in a sentence
