"""Functions of time with a closed form: Bohl functions, impulsive-smooth functions, and inputs made of them."""

from .approximated import Approximation, approximated
from .bohl import BohlFunction
from .impulsive import Blow, ImpulsiveSmooth
from .inputs import harmonic, impulse, power, ramp, step, term, zero
from .records import pulse, sampled
from .restarts import Restarts

__all__ = [
    "Approximation",
    "Blow",
    "BohlFunction",
    "ImpulsiveSmooth",
    "Restarts",
    "approximated",
    "harmonic",
    "impulse",
    "power",
    "pulse",
    "ramp",
    "sampled",
    "step",
    "term",
    "zero",
]
