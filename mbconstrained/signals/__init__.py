"""Functions of time with a closed form: Bohl functions, impulsive-smooth functions, and inputs made of them."""

from .bohl import BohlFunction
from .inputs import ImpulsiveSmooth, harmonic, impulse, power, ramp, step, term, zero

__all__ = ["BohlFunction", "ImpulsiveSmooth", "harmonic", "impulse", "power", "ramp", "step", "term", "zero"]
