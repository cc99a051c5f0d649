"""The solution by the Jordan pairs of A(s): its function of time, evidence and notices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...ground.notices import Evidence, Notice
from ...ground.tolerances import CLEAR_KEPT
from ...linalg.blocks import block_diagonalize
from ...polynomial.decoupling import WeierstrassForm
from ...polynomial.jordan_pairs import JordanPairs
from ...signals.bohl import BohlFunction
from ...signals.impulsive import ImpulsiveSmooth
from ..choose import Method
from ..events import Event, KnotJumps, Start, knot_jumps, start_of
from ..forcing import driven_form
from ..problem import Problem
from ..response_notices import modal_sums, pair_notices
from .finite_motion import FinitePart, driven_motion
from .series import with_series
from .taylor import taylor_series


@dataclass(frozen=True, eq=False)
class PairSolution:
    """x from the pairs.

    Attributes:
        method: the Jordan pairs, chosen with a reason.
        pairs: the pairs themselves.
        function: the regular part.
        coupling: the largest entry of the transformation that separates the zeros.
        jump: x^(i)(0+) - x^(i)(0-), shape (q, r).
        impulses: arrays (r,); the k-th multiplies the k-th derivative of Dirac's delta at t = 0.
        events: jumps and impulses after t = 0.
    """

    method: Method
    pairs: JordanPairs
    function: BohlFunction
    coupling: float
    jump: np.ndarray
    impulses: tuple[np.ndarray, ...]
    events: tuple[Event, ...]

    @classmethod
    def of(cls, problem: Problem, method: Method, pairs: JordanPairs) -> PairSolution:
        """The solution of a problem from its pairs.

        Args:
            problem: A(d/dt) x = f with values at 0-.
            method: the Jordan pairs, with the reason.
            pairs: Jordan pairs of A(s).

        Returns:
            A ``PairSolution``.
        """
        form, initial, force = pairs.form, problem.initial, problem.force
        start, later = start_of(form, initial, force), knot_jumps(form, force, len(initial))
        function, coupling = _regular_part(form, start, force, later)
        function = with_series(function, taylor_series(form, initial, start.jump, force))
        return cls(method, pairs, function, coupling, start.jump, start.impulses, later.events)

    def sums(self, count: int, times: np.ndarray | None = None) -> tuple[np.ndarray, list[np.ndarray], np.ndarray, float]:
        """Rows and states whose products are the derivatives, as ``response_notices.modal_sums``.

        Args:
            count: number of derivatives.
            times: times in place of the default ones, shape (T,).

        Returns:
            Times, rows, states and the rate of the fastest motion.
        """
        return modal_sums(self.function, count, times)

    @property
    def is_precise(self) -> bool:
        """Whether the solution was computed with more digits than float64."""
        return self.pairs.form.companion.is_precise

    @property
    def has_clear_ranks(self) -> bool:
        """Whether no rank decision was doubtful."""
        return all(decision.clear for decision in self.pairs.form.decisions)

    @property
    def dropped_near_bound(self) -> bool:
        """Whether the only doubtful rank decisions are those with dropped entries near their bounds."""
        doubtful = [decision for decision in self.pairs.form.decisions if not decision.clear]
        return bool(doubtful) and all(decision.smallest_kept >= CLEAR_KEPT for decision in doubtful)

    @property
    def as_written(self) -> JordanPairs | None:
        """The pairs of the given data, without entries set to zero at s = 0."""
        return self.pairs.as_written

    @property
    def finite_count(self) -> int:
        """The number of finite zeros of A(s)."""
        return self.pairs.structure.finite_count

    @property
    def evidence(self) -> tuple[Evidence, ...]:
        """Residuals, conditions and gaps of the pairs."""
        with np.errstate(all="ignore"):
            return self.pairs.evidence

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Growth and doubtful decisions."""
        with np.errstate(all="ignore"):
            return pair_notices(self.pairs)


def _regular_part(form: WeierstrassForm, start: Start, force: ImpulsiveSmooth, later: KnotJumps) -> tuple[BohlFunction, float]:
    """x(t) for t > 0 in the user's units and the largest decoupling entry."""
    free, driven, scaling = block_diagonalize(form.T), driven_form(form, force), form.companion.scaling
    return driven_motion(FinitePart(free, form.C, driven, start.finite, later.finite, scaling.time, scaling.columns), force)[:2]
