"""Interface of reports, pages and pictures to the answer to a scene."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from ...exchange.trajectories import Curves
from ...ground.display import TextTable
from ...ground.notices import Notice
from .plan import Plan
from .report.jumps import ReportedImpulse, ReportedJump
from .scene_data import SceneData

if TYPE_CHECKING:
    from ...frequency.shock.extrema import Extrema
    from ...mechanics.modes import Modes
    from ...mechanics.system import MechanicalSystem
    from ...page.animation.animation import Animation
    from ...page.content import Formulas, RecordResponse, TimeFunctions
    from ...polynomial.jordan_pairs import FinitePair, InfinitePair
    from ...response.events import Event
    from ...robot.linearization.linear_range import LinearRange
    from ...signals.impulsive import ImpulsiveLoad


class SceneAnswer(Protocol):
    """The answer to a scene, its attributes as of ``Result``."""

    scene: SceneData
    system: MechanicalSystem | None
    plan: Plan
    files: list[Path]

    @property
    def times(self) -> np.ndarray: ...

    @property
    def motion(self) -> Any: ...

    @property
    def values(self) -> np.ndarray: ...

    @property
    def kinds(self) -> list[str]: ...

    @property
    def finite_pair(self) -> FinitePair: ...

    @property
    def infinite_pair(self) -> InfinitePair: ...

    @property
    def record_response(self) -> RecordResponse | None: ...

    @property
    def jumps(self) -> list[ReportedJump]: ...

    @property
    def impulses(self) -> list[ReportedImpulse]: ...

    @property
    def later(self) -> Sequence[Event | ImpulsiveLoad]: ...

    @property
    def modes(self) -> Modes: ...

    @property
    def error_estimate(self) -> float: ...

    @property
    def error_estimates(self) -> dict[str, float]: ...

    @property
    def linear_range(self) -> LinearRange | None: ...

    @property
    def peak_tables(self) -> tuple[TextTable, ...]: ...

    @property
    def certificate(self) -> Any: ...

    @property
    def formulas(self) -> Formulas | None: ...

    @property
    def animation(self) -> Animation: ...

    @property
    def tables(self) -> tuple[TextTable, ...]: ...

    @property
    def table_notices(self) -> tuple[Notice, ...]: ...

    @property
    def notices(self) -> tuple[Notice, ...]: ...

    @property
    def is_trusted(self) -> bool: ...

    def curves(self, kind: str) -> Curves: ...

    def shown_curves(self, kind: str) -> Curves: ...

    def extrema(self, kind: str) -> Extrema: ...

    def time_functions(self, kind: str) -> TimeFunctions: ...
