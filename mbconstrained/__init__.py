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
from .mechanics import Constraint, ElementMatrix, MechanicalSystem, Modes, Motion
from .models import LumpedModel
from .notices import Notice
from .polynomial import PolynomialMatrix
from .response import Admissibility, Event, Response, admissible, solve
from .scene import read_scene
from .signals import (
    Approximation,
    Blow,
    BohlFunction,
    ImpulsiveSmooth,
    approximated,
    harmonic,
    impulse,
    power,
    pulse,
    ramp,
    sampled,
    step,
    term,
    zero,
)

__all__ = [
    "Admissibility",
    "Approximation",
    "Blow",
    "BohlFunction",
    "Constraint",
    "ContradictoryConstraints",
    "ElementMatrix",
    "Event",
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
    "approximated",
    "harmonic",
    "impulse",
    "power",
    "pulse",
    "ramp",
    "read_scene",
    "sampled",
    "solve",
    "step",
    "term",
    "zero",
]
