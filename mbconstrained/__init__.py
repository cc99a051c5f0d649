"""Closed-form motion of constrained multibody models. The public names, nothing else; heavy things late."""

from __future__ import annotations

from importlib import import_module

from .errors import (
    ContradictoryConstraints,
    IllConditioned,
    InputError,
    MbconstrainedError,
    MissingPackage,
    NoNormalForm,
    NotUnique,
    Overflow,
    SceneError,
    SingularPolynomialMatrix,
)
from .jordan import FinitePair, InfinitePair, JordanPairs
from .mechanics import Constraint, ElementMatrix, EnergyParts, MechanicalSystem, Modes, Motion, NormalForm, mechanical_normal_form
from .models import LumpedModel, StateSpace, StateSpaceResponse
from .notices import Notice
from .polynomial import PolynomialMatrix
from .response import (
    Admissibility,
    Event,
    Response,
    TransferFunctionResponse,
    admissible,
    matrix_fraction_response,
    solve,
    transfer_function_response,
)
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

#: Names of what most do without, imported when they are first asked for: exact answers bring sympy or python-flint, robots
#: their own half of the models.
_LATE = {
    "Enclosure": "exact.enclosure",
    "ExactResponse": "exact.enclosure",
    "SymbolicPolynomialMatrix": "exact.symbolic",
    "SymbolicResponse": "exact.symbolic",
    "solve_symbolically": "exact.symbolic",
    "BodySpring": "models.robot",
    "Bushing": "models.robot",
    "FlexibleJoint": "models.robot",
    "LinearizedRobot": "models.robot",
    "Loop": "models.robot",
    "Motions": "mechanics.motions",
    "PointMotion": "models.robot",
    "Posture": "models.robot",
    "Responses": "response.many",
    "Robot": "models.robot",
    "SparseSystem": "mechanics.sparse",
}


def __getattr__(name: str):
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_LATE[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_LATE})


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
    "Enclosure",
    "EnergyParts",
    "Event",
    "ExactResponse",
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
    "MissingPackage",
    "Modes",
    "Motion",
    "Motions",
    "NoNormalForm",
    "NormalForm",
    "NotUnique",
    "Notice",
    "Overflow",
    "PointMotion",
    "PolynomialMatrix",
    "Posture",
    "Response",
    "Responses",
    "Robot",
    "SceneError",
    "SingularPolynomialMatrix",
    "SparseSystem",
    "StateSpace",
    "StateSpaceResponse",
    "SymbolicPolynomialMatrix",
    "SymbolicResponse",
    "TransferFunctionResponse",
    "admissible",
    "approximated",
    "harmonic",
    "impulse",
    "matrix_fraction_response",
    "power",
    "pulse",
    "ramp",
    "read_robot",
    "read_scene",
    "sampled",
    "solve",
    "solve_symbolically",
    "step",
    "term",
    "transfer_function_response",
    "zero",
]
