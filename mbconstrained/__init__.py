"""Closed-form motion of constrained multibody models. The public names, nothing else; heavy things late."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from .control.matrix_fraction import matrix_fraction_response
from .control.state_space import StateSpace, StateSpaceResponse
from .control.transfer_function import TransferFunctionResponse, transfer_function_response
from .ground.display import Presented, Studied
from .ground.errors import (
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
from .ground.notices import Notice, NoticeKind
from .mechanics.constraints import Constraint
from .mechanics.element_matrix import ElementMatrix
from .mechanics.energy import EnergyParts
from .mechanics.modes import Modes
from .mechanics.motion import Motion
from .mechanics.normal_form import NormalForm, mechanical_normal_form
from .mechanics.system import MechanicalSystem
from .models.lumped import LumpedModel
from .polynomial.jordan_pairs import FinitePair, InfinitePair, JordanPairs
from .polynomial.polynomial_matrix import PolynomialMatrix
from .response.admissible import Admissibility, admissible
from .response.events import Event
from .response.response import Response
from .response.solve import solve
from .signals.approximated import Approximation, approximated
from .signals.bohl import BohlFunction
from .signals.impulsive import ImpulsiveLoad, ImpulsiveSmooth
from .signals.inputs import harmonic, impulse, power, pulse, ramp, sampled, step, term, zero

if TYPE_CHECKING:
    from . import exact

#: Names of what most do without, imported when they are first asked for: exact answers bring sympy or python-flint, robots
#: their own half of the models.
_LATE = {
    "Enclosure": "exact.enclosure.intervals",
    "ExactResponse": "exact.enclosure.exact_response",
    "SymbolicPolynomialMatrix": "exact.symbolic.symbolic_matrix",
    "SymbolicResponse": "exact.symbolic.response.symbolic_response",
    "frequency_response": "frequency.frequency_response",
    "solve_symbolically": "exact.symbolic.response.symbolic_response",
    "BodySpring": "robot.connections",
    "Bushing": "robot.connections",
    "FlexibleJoint": "robot.flexible_joint",
    "JointGear": "robot.tangent",
    "Payload": "robot.description.urdf",
    "Motor": "robot.flexible_joint",
    "FrequencyResponse": "frequency.frequency_response",
    "RandomResponse": "frequency.random.random_response",
    "Spectrum": "frequency.random.spectra",
    "dryden": "frequency.random.spectra",
    "kanai_tajimi": "frequency.random.spectra",
    "octave_bands": "frequency.random.random_response",
    "psd": "frequency.random.spectra",
    "ShockResponseSpectrum": "frequency.shock.response_spectrum",
    "shock_response_spectrum": "frequency.shock.response_spectrum",
    "rational_spectrum": "frequency.random.spectra",
    "road_profile": "frequency.random.spectra",
    "white_noise": "frequency.random.spectra",
    "LinearizedRobot": "robot.linearized",
    "Loop": "robot.connections",
    "Motions": "mechanics.motions",
    "Family": "mechanics.family",
    "family": "mechanics.family",
    "Parameter": "mechanics.parameter",
    "Sensitivities": "mechanics.sensitivities",
    "PointMotion": "robot.connections",
    "Posture": "robot.statics",
    "Responses": "response.solve",
    "Campbell": "mechanics.rotating",
    "CriticalSpeed": "mechanics.rotating",
    "SteadyState": "mechanics.harmonic_response",
    "Robot": "robot.robot",
    "Geometry": "exchange.universal",
    "Record": "scene.build.data_files",
    "Optimum": "analyses.sweep.optimisation",
    "Sweep": "analyses.sweep.sweep",
    "SweepResult": "analyses.sweep.sweep",
    "linspace": "scene.quantities.variations",
    "read_matrix": "exchange.matrices",
    "read_record": "scene.build.data_files",
    "read_robot": "scene.build.robot_file",
    "read_scene": "scene.run.scene",
    "show": "analyses.python_models",
}


def _presentation():
    return import_module(".analyses.python_models", __name__)


def _studies(name: str):
    return import_module(".analyses.run" if name == "run" else f".analyses.sweep.{name}", __name__)


Presented.presentation = staticmethod(_presentation)
Studied.studies = staticmethod(_studies)


def __getattr__(name: str):
    if name == "__version__":
        return import_module("importlib.metadata").version("mbconstrained")
    if name == "exact":
        return import_module(".exact", __name__)
    if name not in _LATE:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f".{_LATE[name]}", __name__), name)


def __dir__() -> list[str]:
    return sorted({*globals(), *_LATE, "exact", "__version__"})


__all__ = [
    "Admissibility",
    "Approximation",
    "BodySpring",
    "BohlFunction",
    "Bushing",
    "Campbell",
    "Constraint",
    "ContradictoryConstraints",
    "CriticalSpeed",
    "ElementMatrix",
    "Enclosure",
    "EnergyParts",
    "Event",
    "ExactResponse",
    "Family",
    "FinitePair",
    "FlexibleJoint",
    "FrequencyResponse",
    "Geometry",
    "IllConditioned",
    "ImpulsiveLoad",
    "ImpulsiveSmooth",
    "InfinitePair",
    "InputError",
    "JointGear",
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
    "Motor",
    "NoNormalForm",
    "NormalForm",
    "NotUnique",
    "Notice",
    "NoticeKind",
    "Optimum",
    "Overflow",
    "Parameter",
    "Payload",
    "PointMotion",
    "PolynomialMatrix",
    "Posture",
    "RandomResponse",
    "Record",
    "Response",
    "Responses",
    "Robot",
    "SceneError",
    "Sensitivities",
    "ShockResponseSpectrum",
    "SingularPolynomialMatrix",
    "Spectrum",
    "StateSpace",
    "StateSpaceResponse",
    "SteadyState",
    "Sweep",
    "SweepResult",
    "SymbolicPolynomialMatrix",
    "SymbolicResponse",
    "TransferFunctionResponse",
    "admissible",
    "approximated",
    "dryden",
    "exact",
    "family",
    "frequency_response",
    "harmonic",
    "impulse",
    "kanai_tajimi",
    "linspace",
    "matrix_fraction_response",
    "mechanical_normal_form",
    "octave_bands",
    "power",
    "psd",
    "pulse",
    "ramp",
    "rational_spectrum",
    "read_matrix",
    "read_record",
    "read_robot",
    "read_scene",
    "road_profile",
    "sampled",
    "shock_response_spectrum",
    "show",
    "solve",
    "solve_symbolically",
    "step",
    "term",
    "transfer_function_response",
    "white_noise",
    "zero",
]
