"""Light beside heavy."""

from __future__ import annotations

from ...problem import Problem
from .building import bodies, chain, moving, spaced
from .system import System, Varied, decades

START = ([1.75, 0.0, 0.75], [-0.25, 2.0, -0.75])


def nearly_massless_joint(mass: float) -> Problem:
    """A joint of this mass between two bodies, on springs and dampers."""
    system = bodies([1.0, mass, 0.5], chain(2.0, 3.0, 1.0), chain(0.05, 1e-6, 0.1))
    return moving("A joint that is nearly massless", system, spaced(mass**0.5, 5.0), START)


def light_tip(mass: float) -> Problem:
    """A light mass on a spring at the tip of a heavy one, nothing damped."""
    system = bodies([1.0, mass], chain(1.0, 1.0))
    return moving("A light tip", system, spaced(0.01, 10.0), ([1.0, 0.0], [0.0, 1.0]))


SYSTEMS = (
    System(
        "nearly_massless_joint",
        "A joint of mass m between two bodies, with a damper",
        "Within a time of order m the joint forgets its velocity; the zero that does it lies at -0.1 / m.",
        "referee case near_massless_1e14",
        Varied("mass of the joint", "kg", decades(0, -20, 2)),
        nearly_massless_joint,
        {"symmetric": True, "finite_zeros": 6, "infinite_divisors": (), "mass_ratio": lambda m: 1 / m if m < 1 else 2.0},
    ),
    System(
        "light_tip",
        "A light tip that rings undamped",
        "The tip turns through 10 / sqrt(m) rad: its phase costs as many digits as that number has, and nothing dies out.",
        "made for this gallery",
        Varied("mass of the tip", "kg", decades(0, -14, 2)),
        light_tip,
        {"symmetric": True, "undamped": True, "finite_zeros": 4, "mass_ratio": lambda m: 1 / m},
    ),
)
