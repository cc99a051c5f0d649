"""Numbers that tell how far a result can be trusted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..linalg.staircase import GENERIC

if TYPE_CHECKING:
    from .pairs import JordanPairs


@dataclass(frozen=True)
class Evidence:
    """One measured number with its meaning.

    Attributes:
        name: a short name.
        value: the number.
        text: what it says, in a sentence.
    """

    name: str
    value: float
    text: str


def pair_evidence(pairs: JordanPairs) -> tuple[Evidence, ...]:
    """Residual of the finite pair, condition of the decouplings, and the gap of the rank decisions."""
    form = pairs.form
    kept = min((decision.smallest_kept for decision in form.decisions), default=np.inf)
    dropped = max((decision.largest_dropped for decision in form.decisions), default=0.0)
    return (
        Evidence("residual", inverse_residual(pairs), "largest relative residual of A(s) times the inverse made from both pairs"),
        Evidence("decoupling", pairs.finite.coupling, "largest entry of the transformation that separates the zeros"),
        Evidence("rank gap", float(kept), "smallest value kept in a rank decision, in units of the rounding noise"),
        Evidence("rank remainder", float(dropped), "largest value dropped in a rank decision, in units of the rounding noise"),
    )


def inverse_residual(pairs: JordanPairs) -> float:
    """max over test points s and rows of |A(s) X(s) - I| / (|A(s)| |X|(s)), X(s) = A(s)^-1 from the pairs (Theorem 2.8).

    |X| is the sum of what the finite zeros and the infinite part contribute to X, without regard to sign.
    """
    form = pairs.form
    companion = form.companion
    if not companion.size:
        return 0.0
    worst = 0.0
    for s in GENERIC:  # at round numbers poles may lie exactly
        A = sum(matrix * s**power for power, matrix in enumerate(companion.coefficients))
        finite, N = np.linalg.solve(s * np.eye(len(form.T)) - form.T, form.B), form.nilpotent.data
        infinite = np.linalg.solve(np.eye(len(N)) - s * N, form.B2.data)
        inverse = form.C @ finite - form.C2.data @ infinite
        parts = np.abs(form.C) @ np.abs(finite) + np.abs(form.C2.data) @ np.abs(infinite)
        size = (np.abs(A) @ parts).max(axis=1)
        worst = max(worst, float((np.abs(A @ inverse - np.eye(companion.size)).max(axis=1) / size).max()))
    return worst
