"""Systems that change their equations: phases, guards, impacts and the motion through all of them.

Read in this order: flow (one phase over time and the first zeros of its guards), phase (with impacts), switches, sequence,
switched_motion, switched_system, periodic.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeGuard

if TYPE_CHECKING:
    from .switched_motion import SwitchedMotion


def is_switched(motion: object) -> TypeGuard[SwitchedMotion]:
    """Whether a motion has phases; their modules are not imported for the others."""
    return hasattr(type(motion), "phases")
