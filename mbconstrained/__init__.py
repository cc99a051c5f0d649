"""Closed-form motion of constrained multibody models. The public names, nothing else; heavy things late."""

from __future__ import annotations

from .errors import (
    ContradictoryConstraints,
    IllConditioned,
    InputError,
    MbconstrainedError,
    NotUnique,
    Overflow,
    SceneError,
    SingularPolynomialMatrix,
)
from .jordan import FinitePair, InfinitePair, JordanPairs
from .mechanics import Constraint, MechanicalSystem, Modes, Motion
from .models import LumpedModel
from .notices import Notice
from .polynomial import PolynomialMatrix
from .response import Admissibility, Response, admissible, solve
from .scene import read_scene
from .signals import BohlFunction, ImpulsiveSmooth, harmonic, impulse, power, ramp, step, term, zero

__all__ = [
    "Admissibility",
    "BohlFunction",
    "Constraint",
    "ContradictoryConstraints",
    "FinitePair",
    "IllConditioned",
    "ImpulsiveSmooth",
    "InfinitePair",
    "InputError",
    "JordanPairs",
    "LumpedModel",
    "MbconstrainedError",
    "MechanicalSystem",
    "Modes",
    "Motion",
    "NotUnique",
    "Notice",
    "Overflow",
    "PolynomialMatrix",
    "Response",
    "SceneError",
    "SingularPolynomialMatrix",
    "admissible",
    "harmonic",
    "impulse",
    "power",
    "ramp",
    "read_scene",
    "solve",
    "step",
    "term",
    "zero",
]
