"""Stiff and soft: springs of very different stiffness, by their elements and assembled into matrices."""

from __future__ import annotations

from ...study_problem import StudyProblem
from .entry import assembled, bodies, chain, decades, declares, family, moving, spaced

#: Displacements and velocities at 0-.
CHAIN_START = ([1.75, 0.0, 0.75, -0.25], [-0.25, 2.0, -0.75, -0.25])
PENALTY_START = ([-1.75, 0.75, -2.0, -0.25], [-0.5, -0.5, -0.5, -1.75])


@family("stiffness", "stiffness ratio", decades(0, 16, 2))
@declares(finite_zeros=8, symmetric=True, stiffness_ratio=lambda ratio: max(ratio, 3.0), growing_zeros=0, infinite_divisors=())
def stiff_chain(ratio: float) -> StudyProblem:
    """Four masses, springs of ratio r, by their elements.

    Modes from 0.4 rad/s to sqrt(r) rad/s move together, and the slow ones need springs that are below the rounding errors of
    the stiff.

    Source: referee case stiff_ratio_1e14, as elements.
    """
    # Springs 1, sqrt(ratio), ratio and 3 N/m, dampers that follow them.
    middle = ratio**0.5
    springs, dampers = chain(1.0, middle, ratio, 3.0), chain(0.1, middle**0.5, middle, 0.2)
    system = bodies([1.0, 2.0, 1.5, 0.5], springs, dampers)
    return moving(system, spaced(1e-3 * ratio**-0.25, 40.0), CHAIN_START)


@family("stiffness", "stiffness ratio", (*decades(0, 14, 2), 1e15, 1e16))
@declares(finite_zeros=8, symmetric=True, infinite_divisors=())
def stiff_chain_assembled(ratio: float) -> StudyProblem:
    """Four masses, springs of ratio r, assembled into matrices.

    The sum r + 3 keeps only the digits of 3 that float64 has left: the soft spring cannot be recovered from the matrices.

    Source: referee case stiff_ratio_1e14.
    """
    problem = stiff_chain(ratio)
    return moving(assembled(problem.system), problem.times, CHAIN_START)


@family("stiffness", "penalty stiffness", (*decades(0, 14, 2), 1e15, 1e16, 1e17), "N/m")
@declares(symmetric=True, finite_zeros=6, infinite_divisors=(1, 1), mass_ratio=2.0)
def penalty_link(stiffness: float) -> StudyProblem:
    """A penalty spring in place of a rigid link, at a joint without mass, assembled.

    The stiffer the penalty the better the model and the worse its matrix; the joint has no inertia, only a zero near -2 k.

    Source: referee case penalty_massless.
    """
    springs = [*chain(3.0, stiffness, 2.0, 1.5)]
    dampers = [(0, 1, 0.1), (2, 3, 0.5), (0, 4, 0.75)]
    system = assembled(bodies([1.0, 0.0, 2.0, 0.0], springs, dampers))
    return moving(system, spaced(0.01, 40.0), PENALTY_START)


@family("stiffness", "penalty stiffness", (*decades(0, 14, 2), 1e15, 1e16, 1e17), "N/m")
@declares(symmetric=True, infinite_divisors=(2,), longest_chain=lambda s: 1 if s < 1e17 else 2)
def penalty_joint(stiffness: float) -> StudyProblem:
    """A mass tied by a penalty spring to a joint without mass, assembled.

    The motion is that of 5 N/m, the sum of what the penalty leaves of 3 and of 2; up to 1e15 N/m it leaves them whole.
    """
    system = assembled(bodies([1.0, 0.0], [(0, 1, 3.0), (1, 2, stiffness), (0, 2, 2.0)]))
    return moving(system, spaced(0.01, 40.0), ([1.0, 1.0], [0.0, 0.0]))


@family("stiffness", "coupling stiffness", (*decades(0, -14, 2), 1e-15, 1e-16), "N/m")
@declares(symmetric=True, undamped=True, finite_zeros=4, longest_chain=1, stiffness_ratio=lambda e: 1 / e)
def weak_coupling(coupling: float) -> StudyProblem:
    """Two equal oscillators, weakly coupled.

    Two pairs of zeros come as near as the coupling, but the energy still crosses over, after pi / coupling seconds.
    """
    system = bodies([1.0, 1.0], [(0, 1, 1.0), (0, 2, 1.0), (1, 2, coupling)])
    return moving(system, spaced(1.0, min(3.0 / coupling, 1e6)), ([1.0, 0.0], [0.0, 0.0]))
