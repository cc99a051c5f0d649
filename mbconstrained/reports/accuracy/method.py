"""A method that is measured: something that gives x at the times of a problem."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module

import numpy as np

from ..problem import Problem

Evaluate = Callable[[], np.ndarray]


class Failure(Exception):
    """A method does not get through, and knows why, in plain words."""


@dataclass(frozen=True)
class Setting:
    """One choice of what a method lets its user choose.

    Attributes:
        label: such as "rtol 1e-06"; empty where there is nothing to choose.
        value: what the method is given; None where there is nothing to choose.
    """

    label: str = ""
    value: float | None = None


def _applies(problem: Problem) -> str:
    return ""


def _always(problem: Problem, value: float | None = None) -> bool:
    return True


@dataclass(frozen=True)
class Method:
    """One method with its settings.

    Attributes:
        name: such as "solve_ivp DOP853".
        settings: from coarse to fine.
        prepare: the set-up for a problem with the value of a setting; what it returns evaluates x at the times, shape (r, T).
        refusal: why it does not apply to a problem; an empty text where it does.
        concerns: whether it is meant for such a problem at all; where it is not, nothing is said of it.
        is_ours: whether it is a closed form of this package.
        matters: whether the value of a setting changes anything for a problem; those that do not are not run.
        library: the module that it calls; loaded before any time is taken.
    """

    name: str
    settings: tuple[Setting, ...]
    prepare: Callable[[Problem, float | None], Evaluate]
    refusal: Callable[[Problem], str] = _applies
    concerns: Callable[[Problem], bool] = _always
    is_ours: bool = False
    matters: Callable[[Problem, float | None], bool] = _always
    library: str = ""

    def load(self) -> None:
        """Load the library: the first to call it would have that in its time."""
        if self.library:
            import_module(self.library)

    def settings_for(self, problem: Problem) -> tuple[Setting, ...]:
        """The settings that change something for a problem; one at least, the coarsest, also where the method is refused."""
        if self.refusal(problem):
            return self.settings[:1]
        return tuple(setting for setting in self.settings if self.matters(problem, setting.value)) or self.settings[:1]
