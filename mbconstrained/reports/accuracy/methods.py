"""All methods that are measured, ours first."""

from __future__ import annotations

from . import closed_form, expm_steps, ida, linear_simulation, solve_ivp
from .method import Method

METHODS: tuple[Method, ...] = (
    *closed_form.METHODS,
    expm_steps.METHOD,
    expm_steps.EACH,
    linear_simulation.LSIM,
    linear_simulation.FORCED_RESPONSE,
    *solve_ivp.METHODS,
    *ida.METHODS,
)
