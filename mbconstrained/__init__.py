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
from .notices import Notice
from .polynomial import PolynomialMatrix
from .response import Response, solve
from .signals import BohlFunction, ImpulsiveSmooth, harmonic, impulse, power, ramp, step, term, zero
