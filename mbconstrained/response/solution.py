"""An answer read off the Jordan pairs of A(s), and what it says of itself."""

from __future__ import annotations

from dataclasses import dataclass

from ..jordan.evidence import Evidence
from ..jordan.pairs import JordanPairs
from ..notices import Notice
from ..signals.bohl import BohlFunction


@dataclass(frozen=True)
class PairSolution:
    """x for t > 0 from the pairs.

    Attributes:
        pairs: the Jordan pairs.
        function: the regular part.
        coupling: the largest entry of the transformation that separated the zeros.
    """

    pairs: JordanPairs
    function: BohlFunction
    coupling: float

    @property
    def rank_tolerance(self) -> float | None:
        """The one asked for."""
        return self.pairs.rank_tolerance

    @property
    def structure_is_clear(self) -> bool:
        """Whether no rank decision was doubtful."""
        return all(decision.clear for decision in self.pairs.form.decisions)

    @property
    def is_precise(self) -> bool:
        """Whether it was computed with more digits than float64."""
        return self.pairs.form.companion.is_precise

    @property
    def written(self) -> JordanPairs | None:
        """The pairs of the data as they are written, where some of them counted as zero at s = 0."""
        return self.pairs.as_written

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """Residuals, conditions and gaps of the pairs."""
        return self.pairs.evidence

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Growth and doubtful decisions."""
        from .notices import pair_notices

        return pair_notices(self.pairs)
