"""Small next to large: weak couplings, a small force next to a large one, nearly free bodies, late and short pulses.

Each is asked at times at which the small quantity decides the answer: after the strong part has decayed, or after long growth.
"""

from __future__ import annotations

import numpy as np

from ....mechanics.constraints import Constraint
from ....mechanics.system import MechanicalSystem
from ....signals.inputs import pulse, step
from ...study_problem import StudyProblem
from .entry import decades, declares, equations, family, moving


def _two_groups(power: int, coupling: float) -> StudyProblem:
    """Three damped and three undamped bodies, coupled by one pair of entries of K, C or M (power 0, 1, 2)."""
    stiffness = (
        np.diag([2.0, 3.0, 2.5, 1.5, 2.0, 3.5]) - np.diag([1.0, 0.5, 0.0, 0.75, 1.0], 1) - np.diag([1.0, 0.5, 0.0, 0.75, 1.0], -1)
    )
    coefficients = [stiffness, np.diag([1.0, 1.5, 1.25, 0.0, 0.0, 0.0]), np.diag([1.0, 2.0, 1.5, 1.0, 2.0, 0.5])]
    coefficients[power][2, 3] += coupling
    coefficients[power][3, 2] += coupling
    return equations(coefficients, [[1.0, -0.5, 0.25, 0.0, 0.0, 0.0], np.zeros(6)], [200.0])


@family("small next to large", "coupling stiffness", decades(-3, -18, 3), "N/m")
@declares(finite_zeros=4, symmetric=True, growing_zeros=0)
def decayed_partner(coupling: float) -> StudyProblem:
    """Two equal oscillators, one of them damped, weakly coupled by a spring.

    The damped one starts. Once it has come to rest, all that is left is the motion of the other, as small as the coupling.
    """
    stiffness = [[1.0 + coupling, -coupling], [-coupling, 1.0 + coupling]]
    return equations([stiffness, np.diag([1.0, 0.0]), np.eye(2)], [[1.0, 0.0], [0.0, 0.0]], [100.0])


@family("small next to large", "coupling stiffness", decades(-4, -19, 3), "N/m")
@declares(finite_zeros=12, symmetric=True)
def groups_coupled_by_stiffness(coupling: float) -> StudyProblem:
    """Two groups of bodies, one of them damped, weakly coupled by a spring.

    The eigenvalues of the groups are well separated, so that all of the coupling's effect is in small entries of the shapes.
    """
    return _two_groups(0, coupling)


@family("small next to large", "coupling damping", decades(-4, -19, 3), "N s/m")
@declares(finite_zeros=12, symmetric=True)
def groups_coupled_by_damping(coupling: float) -> StudyProblem:
    """Two groups of bodies, one of them damped, weakly coupled by a damper.

    The same with an entry of the damping matrix.
    """
    return _two_groups(1, coupling)


@family("small next to large", "coupling mass", decades(-4, -19, 3), "kg")
@declares(finite_zeros=12, symmetric=True)
def groups_coupled_by_mass(coupling: float) -> StudyProblem:
    """Two groups of bodies, one of them damped, weakly coupled by a mass.

    The same with an entry of the mass matrix, which a solution with the mass matrix may lose.
    """
    return _two_groups(2, coupling)


@family("small next to large", "entry", decades(-2, -22, 4), "N/m")
@declares(finite_zeros=4, growing_zeros=1, symmetric=False)
def growth_through_a_tiny_entry(entry: float) -> StudyProblem:
    """A part that grows, driven through a tiny entry by one that does not.

    Growth by e^60 makes the only motion of the second body; without the entry it rests.
    """
    return equations([[[4.0, 0.0], [entry, -1.0]], np.zeros((2, 2)), np.eye(2)], [[1.0, 0.0], [0.0, 0.0]], [60.0])


@family("small next to large", "force", decades(0, -20, 4), "N")
@declares(finite_zeros=4, growing_zeros=1, symmetric=True)
def small_force(force: float) -> StudyProblem:
    """A small force on a part that grows, next to a force of 1 N on one that does not.

    Relative to the large force the small one may be a rounding error; the rows have nothing in common.
    """
    coefficients = [np.diag([4.0, -1.0]), np.zeros((2, 2)), np.eye(2)]
    return equations(coefficients, np.zeros((2, 2)), [60.0], step([1.0, force]))


@family("small next to large", "input", decades(0, -20, 4))
@declares(finite_zeros=2, growing_zeros=1)
def small_input(size: float) -> StudyProblem:
    """A small input of a state that grows, next to one of 1 of a state that decays.

    The same for equations of first order.
    """
    return equations([np.diag([1.0, -1.0]), np.eye(2)], np.zeros((1, 2)), [60.0], step([1.0, size]))


def _free_chain(count: int, ground: np.ndarray) -> StudyProblem:
    stiffness = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    stiffness[0, 0] = stiffness[-1, -1] = 1.0
    start = np.ones(count), np.zeros(count)
    return moving(MechanicalSystem(np.eye(count), stiffness=stiffness + np.diag(ground)), [1e7], start)


@family("small next to large", "power of two of the ground springs", tuple(map(float, range(-17, -62, -10))))
@declares(finite_zeros=24, undamped=True, symmetric=True)
def nearly_free_chain(power: float) -> StudyProblem:
    """Twelve masses, each on a very soft spring to the ground, after 1e7 s.

    The whole chain swings as one body; as a rigid-body motion it would stay where it is.
    """
    return _free_chain(12, np.full(12, 2.0**power))


@family("small next to large", "stiffness to the ground", decades(-10, -15), "N/m")
@declares(finite_zeros=24, undamped=True, symmetric=True)
def chain_grounded_at_one_end(stiffness: float) -> StudyProblem:
    """Twelve masses, the first on a very soft spring to the ground, after 1e7 s.

    The stiffness of the ground is known to the rounding error of 1 plus it.
    """
    return _free_chain(12, stiffness * np.eye(12)[0])


@family("small next to large", "softness", (1e-9, 1e-11, 1e-13, 2.1e-14, 1.4e-14, 7e-15, 1e-15), "N/m")
@declares(symmetric=True, jumps=False)
def link_over_a_spring(softness: float) -> StudyProblem:
    """A rigid link in parallel to a stiff spring, after 1e7 s.

    What is left of the stiffness in the direction of the motion is the rounded sum of its entries.
    """
    constraints = [Constraint([1.0, -1.0], level="position")]
    system = MechanicalSystem(np.eye(2), stiffness=[[1 + softness, -1.0], [-1.0, 1.0]], constraints=constraints)
    return moving(system, [1e7], ([1.0, 1.0], [0.0, 0.0]))


@family("small next to large", "duration", decades(-1, -13, 2), "s")
@declares(finite_zeros=4, symmetric=True, jumps=False)
def late_short_pulse(duration: float) -> StudyProblem:
    """A pulse of given impulse after 1000 s, of decreasing duration.

    Its duration is not the difference of its two times, which are rounded.
    """
    force = pulse([0.0, 1.0 / duration], start=1000.0, duration=duration)
    system = MechanicalSystem(np.eye(2), [[0.01, 0.0], [0.0, 0.02]], [[3.0, -1.0], [-1.0, 2.0]])
    return moving(system, [1000.5, 1003.0, 1010.0], np.zeros((2, 2)), force)


@family("small next to large", "elements", (2.0, 4.0, 8.0, 12.0, 16.0))
@declares(finite_zeros=lambda n: 4 * int(n), growing_zeros=0, symmetric=True)
def clamped_beam(elements: float) -> StudyProblem:
    """A clamped beam with Rayleigh damping, of increasing refinement.

    The fastest modes are overdamped and 1e5 times as fast as the slowest, which is all that is seen.
    """
    n, length = int(elements), 1.0 / elements
    stiffness, mass = np.zeros((2, 2 * n + 2, 2 * n + 2))
    a, b = 6.0 / length, 12.0 / length**2
    element = np.array([[b, a, -b, a], [a, 4.0, -a, 2.0], [-b, -a, b, -a], [a, 2.0, -a, 4.0]]) / length
    inertia = np.array([[156, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) * length / 420
    scale = np.array([1.0, length, 1.0, length])
    for first in range(0, 2 * n, 2):
        stiffness[first : first + 4, first : first + 4] += element
        mass[first : first + 4, first : first + 4] += inertia * np.outer(scale, scale)
    stiffness, mass = stiffness[2:, 2:], mass[2:, 2:]
    system = MechanicalSystem(mass, 1e-3 * stiffness + 0.1 * mass, stiffness)
    return moving(system, [1.0, 3.0], (np.zeros(2 * n), np.zeros(2 * n)), step(np.eye(2 * n)[-2]))


@family("size", "coordinates", (2.0, 4.0, 8.0, 12.0, 16.0, 24.0))
@declares(finite_zeros=lambda n: 2 * int(n), growing_zeros=0, symmetric=True, infinite_divisors=())
def dense_damped(count: float) -> StudyProblem:
    """Dense symmetric matrices, not proportionally damped, at even times.

    Powers of one exponential take the place of modes; their errors grow with the number of steps.
    """
    n = int(count)
    factors = np.random.default_rng(n).standard_normal((2, n, n))
    damping, stiffness = (factor @ factor.T / n for factor in factors)
    system = MechanicalSystem(np.eye(n), 0.05 * damping, stiffness + np.eye(n))
    return moving(system, np.linspace(0.0, 20.0, 41), (np.eye(n)[0], np.zeros(n)))
