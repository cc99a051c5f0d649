"""Points of a sweep with given digits."""

from __future__ import annotations

from mbconstrained.analyses.stability.point import Point
from mbconstrained.analyses.stability.stability import ScalingSweep
from mbconstrained.ground.tolerances import EPS


def point(parameter, right=15.0, expected=15.5, claimed=14.0, **more) -> Point:
    """A point whose errors give these digits."""
    error, condition, estimate = (None if digits is None else 10.0**-digits for digits in (right, expected, claimed))
    return Point(parameter, error, estimate, condition and condition / EPS, **more)


def sweep(
    title: str, *points: Point, parameter: str = "stiffness ratio", name: str = "", theme: str = "stiffness", broken=()
) -> ScalingSweep:
    """Points under a title."""
    return ScalingSweep(name or title, title, theme, "it is stiff", "made for this gallery", parameter, points, broken)
