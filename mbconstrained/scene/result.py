"""What running a scene gives. Each part is computed when it is first asked for; the plan says which are."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..errors import InputError
from ..notices import Notice
from ..response.estimate import error_estimate
from ..tolerances import TRUST_LIMIT
from .aliasing import aliasing_notices
from .curves import ORDERS, PARTS, Curves, coordinate_curves, energy_curves, output_curves, reaction_curves
from .happenings import with_units
from .plan import Plan
from .result_files import ResultFiles
from .robot_notices import motion_notices

if TYPE_CHECKING:
    from ..exact.formulas import ClosedForm
    from ..jordan.pairs import FinitePair, InfinitePair
    from ..mechanics import MechanicalSystem, Modes
    from ..page.content import Animation
    from ..response import Response
    from .certificate import Certificate
    from .scene import Scene


NOTHING_MOVES = "nothing moves: neither the start nor a force sets anything in motion"


class Result(ResultFiles):
    """The answer to a scene.

    Attributes:
        scene: the scene that was run.
        plan: its stages with the time that each has taken.
        files: what was written, in this order.
    """

    def __init__(self, scene: Scene, plan: Plan, folder: Path | None = None):
        self.scene = scene
        self.plan = plan
        super().__init__(folder)
        self.formula_problem = ""
        self._curves: dict[str, Curves] = {}

    @property
    def system(self) -> MechanicalSystem | None:
        """Mass, damping, stiffness and constraint rows; None where A(s) was given itself."""
        return self.scene.equations.system

    @cached_property
    def times(self) -> np.ndarray:
        """The times asked for, shape (T,), in s."""
        return self.scene.times

    @cached_property
    def finite_pair(self) -> FinitePair:
        """(C, J, B) of the finite zeros."""
        return self.scene.equations.polynomial_matrix.jordan_pairs().finite

    @cached_property
    def infinite_pair(self) -> InfinitePair:
        """(C, J, B) of the zeros at infinity."""
        return self.scene.equations.polynomial_matrix.jordan_pairs().infinite

    @cached_property
    def motion(self) -> Response:
        """x as a function of time, with jumps and impulses; a Motion where there is a mechanical system."""
        return self.scene.equations.solve()

    @property
    def values(self) -> np.ndarray:
        """The coordinates at the times, shape (r, T)."""
        return self.curves("displacement").values

    def curves(self, kind: str) -> Curves:
        """Trajectories of a kind: displacement, velocity, acceleration, reaction, energy or output."""
        if kind not in self._curves:
            self._curves[kind] = self._computed(kind)
        return self._curves[kind]

    def _computed(self, kind: str) -> Curves:
        if kind in ORDERS:
            return coordinate_curves(self.scene.equations, self.motion, self.times, kind)
        if kind == "reaction":
            return reaction_curves(self.scene.equations, self.motion, self.times)
        if kind == "output":
            return output_curves(self.scene.equations, self.times, self.values)
        return energy_curves(self.motion, self.times)

    @property
    def kinds(self) -> list[str]:
        """The kinds of curves that the scene asks for, the coordinates themselves first."""
        output = self.scene.table.output
        plots = [part for kind in output.plots for part in (PARTS[kind] if kind == "phase" else (kind,))]
        asked = ["displacement", *plots, *(["reaction"] if output.reactions else [])]
        rows = self.system is not None and self.system.rows
        told = {"reaction": rows, "output": not self.scene.equations.has_outputs_among_coordinates}
        return [kind for kind in dict.fromkeys(asked) if told.get(kind, True)]

    @cached_property
    def modes(self) -> Modes:
        """The finite zeros of the mechanical system with their meaning."""
        return self.system.modes()

    @property
    def error_estimate(self) -> float:
        """Estimate of max |error| / max |x| over the times."""
        return self.error_estimates["displacement"]

    @cached_property
    def error_estimates(self) -> dict[str, float]:
        """The same for each kind of curve that the scene asks for; energies are made of displacements and velocities,
        outputs of a robot of displacements."""
        kinds = dict.fromkeys(part for kind in self.kinds for part in PARTS.get(kind, (kind,)))
        found = {kind: error_estimate(self.motion, self.times, self._view(kind)) for kind in kinds}
        if "output" in self.kinds and self.scene.equations.control:
            found["output"] = self.scene.equations.control.response.output_error_estimate(self.times)
        return found

    def _view(self, kind: str):
        if kind == "reaction":
            return self.motion.reaction_of
        return lambda response: response.derivative(ORDERS[kind])

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """What is worth knowing, and what makes the answer doubtful."""
        notices = self.motion.notices if self.system else with_units(self.motion, self.scene.equations.coordinates)
        doubts = [(kind, estimate) for kind, estimate in self.error_estimates.items() if not estimate <= TRUST_LIMIT]
        texts = [
            f"the estimated relative error of the {kind} is {estimate:.2g}: the data do not determine it well enough"
            for kind, estimate in doubts
        ]
        robot = motion_notices(self.scene.equations.robot_scene, self.values)
        accuracy = (Notice("accuracy", text, doubtful=True) for text in texts)
        proved = self.certificate.notices if self.certificate else ()
        told = (*self.scene.notices, *self._without_formula(), *self._without_still(), *proved)
        seen = (*self._at_rest(notices), *aliasing_notices(self))
        return (*told, *self.scene.equations.form_notices, *notices, *seen, *robot, *accuracy)

    def _at_rest(self, notices: Iterable[Notice]) -> tuple[Notice, ...]:
        """That nothing moves, as where the start was forgotten."""
        moves = np.ptp(self.values, axis=1).any() or any(notice.kind in ("jump", "impulse") for notice in notices)
        return () if moves else (Notice("at rest", NOTHING_MOVES),)

    def _without_formula(self) -> tuple[Notice, ...]:
        """Why the page has no formula, where one was asked for."""
        output = self.scene.table.output
        if not (output.formula and output.page):
            return ()
        from .formula import too_large

        reason = too_large(self.scene) or self.formula_problem
        return (Notice("left out", f"the formula is left out: {reason}"),) if reason else ()

    def _without_still(self) -> tuple[Notice, ...]:
        """Why there is no still picture, where one was asked for."""
        from .output_decisions import still

        taken, reason = still(self.scene)
        asked = self.scene.table.output.still is not None
        problem = self.still_problem if taken else f"left out: {reason}"
        return (Notice("left out", f"still picture: {problem.removeprefix('still picture: ')}"),) if asked and problem else ()

    @property
    def is_trusted(self) -> bool:
        """False where a notice says that the answer may be wrong."""
        return not any(notice.doubtful for notice in self.notices)

    @cached_property
    def animation(self) -> Animation:
        """The drawing of the model and the motion that moves it."""
        from .drawing import animation_of

        return animation_of(self)

    @cached_property
    def certificate(self) -> Certificate | None:
        """How many digits are proved; None where that is not asked for."""
        if not self.scene.table.output.certify:
            return None
        from .certificate import certificate_of

        return certificate_of(self)

    @cached_property
    def formula(self) -> ClosedForm | None:
        """The formula of each coordinate; None, with a notice, where there is none."""
        from .formula import PAGE_SECONDS, formula_of

        control = self.scene.equations.control
        wanted = None if control and control.form else self.scene.table.output.coordinates  # of a normal form: its states
        try:
            return formula_of(self.scene, coordinates=wanted, seconds=PAGE_SECONDS)
        except InputError as problem:
            self.formula_problem = str(problem)
            return None

    def summary(self) -> str:
        """The answer in words and tables, as it is printed."""
        from .summary import summary

        return summary(self)

    def as_json(self) -> dict:
        """The answer without the curves, as plain data."""
        from .summary import as_json

        return as_json(self)
