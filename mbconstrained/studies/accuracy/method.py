"""A method of the accuracy study: it computes x at the times of a problem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..study_problem import StudyProblem

Evaluate = Callable[[], np.ndarray]


class Failure(Exception):
    """A method cannot solve a problem; the text is the reason."""


@dataclass(frozen=True)
class MethodSetting:
    """Setting of a method, such as a tolerance.

    Attributes:
        label: a text such as "rtol 1e-06"; empty for a method without settings.
        value: argument of the method; None for a method without settings.
    """

    label: str = ""
    value: float | None = None


def tolerances(*digits: int) -> tuple[MethodSetting, ...]:
    """Relative tolerances of 10^-digits."""
    return tuple(MethodSetting(f"rtol {10.0**-count:.0e}", 10.0**-count) for count in digits)


@dataclass(frozen=True)
class ComparedMethod:
    """Method with its settings.

    Attributes:
        name: name, such as "solve_ivp DOP853".
        prepare: the set-up for a problem with the value of a setting; returns a function that evaluates x at the times, (r, T).
        settings: settings from coarse to fine.
        refusal: the reason why it does not apply to a problem; empty where it does.
        concerns: whether it is listed for such a problem.
        is_ours: whether it is a method of this package.
        matters: whether the value of a setting has an effect on a problem; otherwise it is not run.
        library: the module that it uses; loaded before run times are measured.
    """

    name: str
    prepare: Callable[[StudyProblem, float | None], Evaluate]
    settings: tuple[MethodSetting, ...] = (MethodSetting(),)
    refusal: Callable[[StudyProblem], str] = lambda problem: ""
    concerns: Callable[[StudyProblem], bool] = lambda problem: True
    is_ours: bool = False
    matters: Callable[[StudyProblem, float | None], bool] = lambda problem, value: True
    library: str = ""

    def settings_for(self, problem: StudyProblem) -> tuple[MethodSetting, ...]:
        """The settings with an effect on a problem; at least the coarsest."""
        some = () if self.refusal(problem) else (setting for setting in self.settings if self.matters(problem, setting.value))
        return tuple(some) or self.settings[:1]
