"""Stiff beside soft: springs of very different stiffness, by their elements and assembled into matrices."""

from __future__ import annotations

from ...problem import Problem
from .building import assembled, bodies, chain, moving, spaced
from .system import System, Varied, decades

#: Displacements and velocities at 0-.
CHAIN_START = ([1.75, 0.0, 0.75, -0.25], [-0.25, 2.0, -0.75, -0.25])
PENALTY_START = ([-1.75, 0.75, -2.0, -0.25], [-0.5, -0.5, -0.5, -1.75])


def stiff_chain(ratio: float) -> Problem:
    """Springs 1, sqrt(ratio), ratio and 3 N/m, dampers that follow them."""
    middle = ratio**0.5
    springs, dampers = chain(1.0, middle, ratio, 3.0), chain(0.1, middle**0.5, middle, 0.2)
    system = bodies([1.0, 2.0, 1.5, 0.5], springs, dampers)
    return moving("Chain of four masses", system, spaced(1e-3 * ratio**-0.25, 40.0), CHAIN_START)


def stiff_chain_assembled(ratio: float) -> Problem:
    """The same from matrices, in which a spring of 3 N/m beside one of 1e16 N/m is rounded away."""
    problem = stiff_chain(ratio)
    return moving(problem.title, assembled(problem.system), problem.times, CHAIN_START)


def penalty_link(stiffness: float) -> Problem:
    """A penalty spring where a rigid link is meant, to a joint without mass."""
    springs = [*chain(3.0, stiffness, 2.0, 1.5)]
    dampers = [(0, 1, 0.1), (2, 3, 0.5), (0, 4, 0.75)]
    system = assembled(bodies([1.0, 0.0, 2.0, 0.0], springs, dampers))
    return moving("A penalty spring for a rigid link", system, spaced(0.01, 40.0), PENALTY_START)


def penalty_joint(stiffness: float) -> Problem:
    """The smallest of its kind: a mass on a spring, tied by a penalty to a joint without mass on another."""
    system = assembled(bodies([1.0, 0.0], [(0, 1, 3.0), (1, 2, stiffness), (0, 2, 2.0)]))
    return moving("A mass and a joint", system, spaced(0.01, 40.0), ([1.0, 1.0], [0.0, 0.0]))


def weak_coupling(coupling: float) -> Problem:
    """Two equal oscillators, seen over half a beat, or as much of it as there is in 1e6 s."""
    system = bodies([1.0, 1.0], [(0, 1, 1.0), (0, 2, 1.0), (1, 2, coupling)])
    return moving("Two equal oscillators", system, spaced(1.0, min(3.0 / coupling, 1e6)), ([1.0, 0.0], [0.0, 0.0]))


def _spread(ratio: float) -> float:
    """Of the springs of ``stiff_chain``: the softest is 1, the stiffest the ratio or 3."""
    return max(ratio, 3.0)


SYSTEMS = (
    System(
        "stiff_chain",
        "Four masses, springs of ratio r, by their elements",
        "Modes from 0.4 rad/s to sqrt(r) rad/s move together, and the slow ones need springs that are below the rounding of the stiff.",
        "referee case stiff_ratio_1e14, as elements",
        Varied("stiffness ratio", "", decades(0, 16, 2)),
        stiff_chain,
        {"finite_zeros": 8, "symmetric": True, "stiffness_ratio": _spread, "growing_zeros": 0, "infinite_divisors": ()},
    ),
    System(
        "stiff_chain_assembled",
        "The same assembled into matrices",
        "The sum r + 3 keeps only the digits of 3 that float64 has left: from the matrices nobody can tell what the soft spring was.",
        "referee case stiff_ratio_1e14",
        Varied("stiffness ratio", "", (*decades(0, 14, 2), 1e15, 1e16)),
        stiff_chain_assembled,
        {"finite_zeros": 8, "symmetric": True, "infinite_divisors": ()},
    ),
    System(
        "penalty_link",
        "A penalty spring in place of a rigid link, at a joint without mass, assembled",
        "The stiffer the penalty the better the model and the worse its matrix; the joint has no inertia, only a zero near -2 k.",
        "referee case penalty_massless",
        Varied("penalty stiffness", "N/m", (*decades(0, 14, 2), 1e15, 1e16, 1e17)),
        penalty_link,
        {"symmetric": True, "finite_zeros": 6, "infinite_divisors": (1, 1), "mass_ratio": 2.0},
    ),
    System(
        "penalty_joint",
        "A mass tied by a penalty spring to a joint without mass, assembled",
        "The motion is that of 5 N/m, the sum of what the penalty leaves of 3 and of 2; up to 1e15 N/m it leaves them whole.",
        "made for this gallery",
        Varied("penalty stiffness", "N/m", (*decades(0, 14, 2), 1e15, 1e16, 1e17)),
        penalty_joint,
        {"symmetric": True, "infinite_divisors": (2,), "longest_chain": lambda s: 1 if s < 1e17 else 2},
    ),
    System(
        "weak_coupling",
        "Two equal oscillators, weakly coupled",
        "Two pairs of zeros come as near as the coupling, but the energy still crosses over, after pi / coupling seconds.",
        "made for this gallery",
        Varied("coupling stiffness", "N/m", (*decades(0, -14, 2), 1e-15, 1e-16)),
        weak_coupling,
        {"symmetric": True, "undamped": True, "finite_zeros": 4, "longest_chain": 1, "stiffness_ratio": lambda e: 1 / e},
    ),
)  # fmt: skip
