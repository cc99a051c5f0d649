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
from .mechanics import Constraint, ElementMatrix, EnergyParts, MechanicalSystem, Modes, Motion
from .models import LumpedModel
from .models.robot import BodySpring, Bushing, FlexibleJoint, LinearizedRobot, Loop, PointMotion, Posture, Robot
from .notices import Notice
from .polynomial import PolynomialMatrix
from .response import Admissibility, Event, Response, admissible, solve
from .scene import read_robot, read_scene
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
    "BodySpring",
    "BohlFunction",
    "Bushing",
    "Constraint",
    "ContradictoryConstraints",
    "ElementMatrix",
    "EnergyParts",
    "Event",
    "FinitePair",
    "FlexibleJoint",
    "IllConditioned",
    "ImpulsiveSmooth",
    "InfinitePair",
    "InputError",
    "JordanPairs",
    "LinearizedRobot",
    "Loop",
    "LumpedModel",
    "MbconstrainedError",
    "MechanicalSystem",
    "Modes",
    "Motion",
    "NotUnique",
    "Notice",
    "Overflow",
    "PointMotion",
    "PolynomialMatrix",
    "Posture",
    "Response",
    "Robot",
    "SceneError",
    "SingularPolynomialMatrix",
    "admissible",
    "approximated",
    "harmonic",
    "impulse",
    "power",
    "pulse",
    "ramp",
    "read_robot",
    "read_scene",
    "sampled",
    "solve",
    "step",
    "term",
    "zero",
]
