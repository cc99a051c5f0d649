"""Closed-form motion of constrained multibody models: the public names, each imported when it is first used."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from . import exact as exact
    from .analyses.base import Answer as Answer
    from .analyses.python_models import show as show
    from .analyses.sweep.optimisation import Optimum as Optimum
    from .analyses.sweep.sweep import Sweep as Sweep
    from .analyses.sweep.sweep import SweepResult as SweepResult
    from .control.discrete_time import DiscreteFrequencyResponse as DiscreteFrequencyResponse
    from .control.discrete_time import DiscreteStateSpace as DiscreteStateSpace
    from .control.discrete_time import DiscreteStateSpaceResponse as DiscreteStateSpaceResponse
    from .control.discrete_time import DiscreteTransferResponse as DiscreteTransferResponse
    from .control.discrete_time import discrete_transfer_function_response as discrete_transfer_function_response
    from .control.rational import matrix_fraction_response as matrix_fraction_response
    from .control.state_space import StateSpace as StateSpace
    from .control.state_space import StateSpaceResponse as StateSpaceResponse
    from .control.transfer_function import TransferFunctionResponse as TransferFunctionResponse
    from .control.transfer_function import transfer_function_response as transfer_function_response
    from .exact.enclosure.exact_response import ExactResponse as ExactResponse
    from .exact.enclosure.intervals import Enclosure as Enclosure
    from .exact.symbolic.symbolic_matrix import SymbolicPolynomialMatrix as SymbolicPolynomialMatrix
    from .exact.symbolic.symbolic_response import SymbolicResponse as SymbolicResponse
    from .exact.symbolic.symbolic_response import solve_symbolically as solve_symbolically
    from .exchange.matrices import read_matrix as read_matrix
    from .exchange.universal import Geometry as Geometry
    from .frequency.fatigue import CycleCount as CycleCount
    from .frequency.fatigue import FatigueDamageSpectrum as FatigueDamageSpectrum
    from .frequency.fatigue import fatigue_damage_spectrum as fatigue_damage_spectrum
    from .frequency.fatigue import rainflow as rainflow
    from .frequency.frequency_response import FrequencyResponse as FrequencyResponse
    from .frequency.frequency_response import frequency_response as frequency_response
    from .frequency.random.random_response import RandomResponse as RandomResponse
    from .frequency.random.random_response import octave_bands as octave_bands
    from .frequency.random.spectra import Spectrum as Spectrum
    from .frequency.random.spectra import dryden as dryden
    from .frequency.random.spectra import kanai_tajimi as kanai_tajimi
    from .frequency.random.spectra import psd as psd
    from .frequency.random.spectra import rational_spectrum as rational_spectrum
    from .frequency.random.spectra import road_profile as road_profile
    from .frequency.random.spectra import white_noise as white_noise
    from .frequency.shock_spectrum import ShockResponseSpectrum as ShockResponseSpectrum
    from .frequency.shock_spectrum import shock_response_spectrum as shock_response_spectrum
    from .ground.errors import ContradictoryConstraints as ContradictoryConstraints
    from .ground.errors import IllConditioned as IllConditioned
    from .ground.errors import InputError as InputError
    from .ground.errors import MbconstrainedError as MbconstrainedError
    from .ground.errors import MissingPackage as MissingPackage
    from .ground.errors import NoNormalForm as NoNormalForm
    from .ground.errors import NotSolvable as NotSolvable
    from .ground.errors import NotUnique as NotUnique
    from .ground.errors import Overflow as Overflow
    from .ground.errors import SceneError as SceneError
    from .ground.errors import SingularPolynomialMatrix as SingularPolynomialMatrix
    from .ground.notices import Notice as Notice
    from .ground.notices import NoticeKind as NoticeKind
    from .mechanics.boundary import BoundaryMotion as BoundaryMotion
    from .mechanics.boundary import BoundaryResponse as BoundaryResponse
    from .mechanics.boundary import boundary_solve as boundary_solve
    from .mechanics.constraints import Constraint as Constraint
    from .mechanics.element_matrix import ElementMatrix as ElementMatrix
    from .mechanics.energy import EnergyParts as EnergyParts
    from .mechanics.family import Family as Family
    from .mechanics.family import family as family
    from .mechanics.harmonic_response import SteadyState as SteadyState
    from .mechanics.input_shaper import InputShaper as InputShaper
    from .mechanics.input_shaper import input_shaper as input_shaper
    from .mechanics.least_energy import LeastEnergyInput as LeastEnergyInput
    from .mechanics.least_energy import least_energy_input as least_energy_input
    from .mechanics.modes import Modes as Modes
    from .mechanics.motion import Motion as Motion
    from .mechanics.motions import Motions as Motions
    from .mechanics.normal_form import NormalForm as NormalForm
    from .mechanics.normal_form import mechanical_normal_form as mechanical_normal_form
    from .mechanics.parameter import Parameter as Parameter
    from .mechanics.peaks import cycles as cycles
    from .mechanics.rotating import Campbell as Campbell
    from .mechanics.rotating import CriticalSpeed as CriticalSpeed
    from .mechanics.sensitivities import Sensitivities as Sensitivities
    from .mechanics.switched.frequency_curve import Bifurcation as Bifurcation
    from .mechanics.switched.frequency_curve import FrequencyCurve as FrequencyCurve
    from .mechanics.switched.periodic import PeriodicMotion as PeriodicMotion
    from .mechanics.switched.switched_motion import SwitchedMotion as SwitchedMotion
    from .mechanics.switched.switched_motion import SwitchEvent as SwitchEvent
    from .mechanics.switched.switched_system import SwitchedSystem as SwitchedSystem
    from .mechanics.switched.switches import Transition as Transition
    from .mechanics.system import MechanicalSystem as MechanicalSystem
    from .models.lumped import LumpedModel as LumpedModel
    from .polynomial.characteristic_roots import CharacteristicRoots as CharacteristicRoots
    from .polynomial.characteristic_roots import characteristic_roots as characteristic_roots
    from .polynomial.jordan_pairs import FinitePair as FinitePair
    from .polynomial.jordan_pairs import InfinitePair as InfinitePair
    from .polynomial.jordan_pairs import JordanPairs as JordanPairs
    from .polynomial.polynomial_matrix import PolynomialMatrix as PolynomialMatrix
    from .polynomial.structure import PolynomialVector as PolynomialVector
    from .response.admissible import Admissibility as Admissibility
    from .response.admissible import admissible as admissible
    from .response.discrete import DiscreteResponse as DiscreteResponse
    from .response.discrete import solve_discrete as solve_discrete
    from .response.events import Event as Event
    from .response.response import Response as Response
    from .response.solvability import Condition as Condition
    from .response.solvability import Solvability as Solvability
    from .response.solvability import solvability as solvability
    from .response.solve import Responses as Responses
    from .response.solve import solve as solve
    from .robot.connections import BodySpring as BodySpring
    from .robot.connections import Bushing as Bushing
    from .robot.connections import Loop as Loop
    from .robot.connections import PointMotion as PointMotion
    from .robot.description.urdf import Payload as Payload
    from .robot.flexible_joint import FlexibleJoint as FlexibleJoint
    from .robot.flexible_joint import Motor as Motor
    from .robot.linearized import LinearizedRobot as LinearizedRobot
    from .robot.robot import Robot as Robot
    from .robot.statics import Posture as Posture
    from .robot.switching import ClosingLoop as ClosingLoop
    from .robot.switching import JointStop as JointStop
    from .robot.switching import LiftingFoot as LiftingFoot
    from .robot.switching import PointContact as PointContact
    from .robot.tangent import JointGear as JointGear
    from .scene.build.data_files import Record as Record
    from .scene.build.data_files import read_record as read_record
    from .scene.build.robot_file import read_robot as read_robot
    from .scene.run.scene import Scene as Scene
    from .scene.run.scene import read_scene as read_scene
    from .scene.variations import linspace as linspace
    from .signals.approximated import Approximation as Approximation
    from .signals.approximated import approximated as approximated
    from .signals.bohl import BohlFunction as BohlFunction
    from .signals.impulsive import ImpulsiveLoad as ImpulsiveLoad
    from .signals.impulsive import ImpulsiveSmooth as ImpulsiveSmooth
    from .signals.inputs import harmonic as harmonic
    from .signals.inputs import impulse as impulse
    from .signals.inputs import power as power
    from .signals.inputs import pulse as pulse
    from .signals.inputs import ramp as ramp
    from .signals.inputs import sampled as sampled
    from .signals.inputs import step as step
    from .signals.inputs import term as term
    from .signals.inputs import zero as zero
    from .signals.sequences import GeometricSequence as GeometricSequence
    from .signals.sequences import geometric as geometric

#: The public names by the files that define them; the imports above are those of type checkers.
_NAMES = {
    "analyses.base": "Answer",
    "analyses.python_models": "show",
    "analyses.sweep.optimisation": "Optimum",
    "analyses.sweep.sweep": "Sweep SweepResult",
    "control.discrete_time": (
        "DiscreteFrequencyResponse DiscreteStateSpace DiscreteStateSpaceResponse DiscreteTransferResponse "
        "discrete_transfer_function_response"
    ),
    "control.rational": "matrix_fraction_response",
    "control.state_space": "StateSpace StateSpaceResponse",
    "control.transfer_function": "TransferFunctionResponse transfer_function_response",
    "exact.enclosure.exact_response": "ExactResponse",
    "exact.enclosure.intervals": "Enclosure",
    "exact.symbolic.symbolic_response": "SymbolicResponse solve_symbolically",
    "exact.symbolic.symbolic_matrix": "SymbolicPolynomialMatrix",
    "exchange.matrices": "read_matrix",
    "exchange.universal": "Geometry",
    "frequency.fatigue": "CycleCount FatigueDamageSpectrum fatigue_damage_spectrum rainflow",
    "frequency.frequency_response": "FrequencyResponse frequency_response",
    "frequency.random.random_response": "RandomResponse octave_bands",
    "frequency.random.spectra": "Spectrum dryden kanai_tajimi psd rational_spectrum road_profile white_noise",
    "frequency.shock_spectrum": "ShockResponseSpectrum shock_response_spectrum",
    "ground.errors": "ContradictoryConstraints IllConditioned InputError MbconstrainedError MissingPackage NoNormalForm NotSolvable NotUnique Overflow SceneError SingularPolynomialMatrix",
    "ground.notices": "Notice NoticeKind",
    "mechanics.boundary": "BoundaryMotion BoundaryResponse boundary_solve",
    "mechanics.constraints": "Constraint",
    "mechanics.element_matrix": "ElementMatrix",
    "mechanics.energy": "EnergyParts",
    "mechanics.family": "Family family",
    "mechanics.harmonic_response": "SteadyState",
    "mechanics.input_shaper": "InputShaper input_shaper",
    "mechanics.least_energy": "LeastEnergyInput least_energy_input",
    "mechanics.modes": "Modes",
    "mechanics.motion": "Motion",
    "mechanics.motions": "Motions",
    "mechanics.peaks": "cycles",
    "mechanics.normal_form": "NormalForm mechanical_normal_form",
    "mechanics.parameter": "Parameter",
    "mechanics.rotating": "Campbell CriticalSpeed",
    "mechanics.sensitivities": "Sensitivities",
    "mechanics.switched.frequency_curve": "Bifurcation FrequencyCurve",
    "mechanics.switched.periodic": "PeriodicMotion",
    "mechanics.switched.switched_motion": "SwitchEvent SwitchedMotion",
    "mechanics.switched.switched_system": "SwitchedSystem",
    "mechanics.switched.switches": "Transition",
    "mechanics.system": "MechanicalSystem",
    "models.lumped": "LumpedModel",
    "polynomial.characteristic_roots": "CharacteristicRoots characteristic_roots",
    "polynomial.jordan_pairs": "FinitePair InfinitePair JordanPairs",
    "polynomial.polynomial_matrix": "PolynomialMatrix",
    "polynomial.structure": "PolynomialVector",
    "response.admissible": "Admissibility admissible",
    "response.discrete": "DiscreteResponse solve_discrete",
    "response.events": "Event",
    "response.response": "Response",
    "response.solvability": "Condition Solvability solvability",
    "response.solve": "Responses solve",
    "robot.connections": "BodySpring Bushing Loop PointMotion",
    "robot.description.urdf": "Payload",
    "robot.flexible_joint": "FlexibleJoint Motor",
    "robot.linearized": "LinearizedRobot",
    "robot.robot": "Robot",
    "robot.statics": "Posture",
    "robot.switching": "ClosingLoop JointStop LiftingFoot PointContact",
    "robot.tangent": "JointGear",
    "scene.build.data_files": "Record read_record",
    "scene.build.robot_file": "read_robot",
    "scene.variations": "linspace",
    "scene.run.scene": "Scene read_scene",
    "signals.approximated": "Approximation approximated",
    "signals.bohl": "BohlFunction",
    "signals.impulsive": "ImpulsiveLoad ImpulsiveSmooth",
    "signals.inputs": "harmonic impulse power pulse ramp sampled step term zero",
    "signals.sequences": "GeometricSequence geometric",
}
_FILES = {name: file for file, names in _NAMES.items() for name in names.split()}

__all__ = ["exact", *_FILES]  # noqa: PLE0604  (names of the table)
__all__.sort()


#: Functions of other packages, and methods, that are expected of this module.
_INSTEAD = {
    "TransferFunction": "mb.StateSpace.from_transfer_function",
    "bode": "system.frequency_response(...).plot()",
    "eig": "system.modes()",
    "frf": "system.frequency_response(...)",
    "load": "mb.read_scene",
    "load_scene": "mb.read_scene",
    "mac": 'mb.read_scene("FILE.toml").mac(other="OTHER.toml")',
    "modes": "system.modes()",
    "plot": "motion.plot()",
    "random_response": "system.random_response(...)",
    "run": 'mb.read_scene("FILE.toml").run()',
    "simulate": "system.solve(...)",
    "sine": "mb.harmonic",
    "srs": "mb.shock_response_spectrum",
    "sweep": "scene.sweep(...)",
}


class _UnknownName(AttributeError):
    """A name that does not exist; the text is made when it is read, since imports of rooms ask for their names here first."""

    def __str__(self) -> str:
        from .ground.by_name import proposed

        return f'mbconstrained has no "{self.args[0]}"{proposed(self.args[0], __all__, _INSTEAD)}'


def __getattr__(name: str):
    if name == "__version__":
        return import_module("importlib.metadata").version("mbconstrained")
    if name == "exact":
        return import_module(".exact", __name__)
    if name not in _FILES:
        raise _UnknownName(name)
    globals()[name] = value = getattr(import_module(f".{_FILES[name]}", __name__), name)
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
