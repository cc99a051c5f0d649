"""Light and heavy masses, critical and heavy damping, gyroscopic forces, and many bodies."""

from __future__ import annotations

import numpy as np

from ....signals.inputs import harmonic
from ...study_problem import StudyProblem
from .entry import bodies, chain, decades, declares, equations, family, moving, spaced

START = ([1.75, 0.0, 0.75], [-0.25, 2.0, -0.75])


@family("mass", "mass of the joint", decades(0, -20, 2), "kg")
@declares(symmetric=True, finite_zeros=6, infinite_divisors=(), mass_ratio=lambda m: 1 / m if m < 1 else 2.0)
def nearly_massless_joint(mass: float) -> StudyProblem:
    """A joint of mass m between two bodies, with a damper.

    Within a time of order m the joint forgets its velocity; the zero that does it lies at -0.1 / m.

    Source: referee case near_massless_1e14.
    """
    system = bodies([1.0, mass, 0.5], chain(2.0, 3.0, 1.0), chain(0.05, 1e-6, 0.1))
    return moving(system, spaced(mass**0.5, 5.0), START)


@family("mass", "mass of the tip", decades(0, -14, 2), "kg")
@declares(symmetric=True, undamped=True, finite_zeros=4, mass_ratio=lambda m: 1 / m)
def light_tip(mass: float) -> StudyProblem:
    """A light tip that rings undamped.

    The tip turns through 10 / sqrt(m) rad: its phase costs as many digits as that number has, and nothing dies out.
    """
    system = bodies([1.0, mass], chain(1.0, 1.0))
    return moving(system, spaced(0.01, 10.0), ([1.0, 0.0], [0.0, 1.0]))


@family("damping", "damping ratio", (0.0, 1e-6, 1e-3, 0.5, 1.0, 2.0, 1e2, 1e4, 1e6, 1e8))
@declares(finite_zeros=2, longest_chain=lambda ratio: 2 if ratio == 1 else 1, undamped=lambda ratio: ratio == 0)
def damping_ratio(ratio: float) -> StudyProblem:
    """An oscillator from undamped to overdamped.

    At ratio 1 the two zeros are one with a chain of length 2: formulas that divide by their difference divide by zero.

    Source: referee case crit_exact.
    """
    # x'' + 4 ratio x' + 4 x = 0.
    return equations([[[4.0]], [[4.0 * ratio]], [[1.0]]], [[1.0], [-3.0]], spaced(0.01, 12.0))


@family("damping", "distance from critical", (1e-2, 1e-4, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12, 1e-14, 1e-15, 0.0))
@declares(finite_zeros=4, growing_zeros=0, longest_chain=lambda distance: 1 if distance else 2)
def near_critical(distance: float) -> StudyProblem:
    """Two coupled oscillators at critical damping minus d.

    Four zeros lie 2 sqrt(2 d) from -2, in four directions: far enough to be two in float64, and too near to be decoupled.

    Source: referee case crit_near_1e9.
    """
    # s^2 + 4 (1 + d) s + 4 and s^2 + 4 (1 - d) s + 4, mixed by matrices of whole numbers with determinant 1.
    one, two = 4.0 * (1 + distance), 4.0 * (1 - distance)
    damping = [[one - two, one], [one - 2 * two, one]]
    return equations([[[0, 4], [-4, 4]], damping, [[0, 1], [-1, 1]]], [[1.0, -2.0], [0.5, 3.0]], spaced(0.01, 12.0))


@family("damping", "damping", (3.0, *decades(1, 10)), "N s/m")
@declares(finite_zeros=2, longest_chain=1, symmetric=True, decades=lambda c: round(2 * np.log10(c)) if c > 3 else 1)
def heavy_damper(damping: float) -> StudyProblem:
    """A heavy damper against a soft spring.

    Zeros at -c and -1/c are c^2 apart; the soft one is what is left of a difference of two numbers near c.

    Source: referee case rot_overdamped_1e8, not rotated.
    """
    # x'' + c x' + x = 0, from the first moments of the fast zero to long after the slow one.
    return equations([[[1.0]], [[damping]], [[1.0]]], [[1.0], [1.0]], spaced(1 / damping, 5 * damping))


@family("damping", "rate of turn", decades(-4, 6), "rad/s")
@declares(finite_zeros=4, symmetric=False, growing_zeros=0)
def gyroscope(rate: float) -> StudyProblem:
    """A rotating vibratory gyroscope.

    The damping matrix is not symmetric, and 2 s are 2e4 turns under a force at the first mode.

    Source: referee case mems_gyro.
    """
    mass, coriolis = 1e-9, 2e-9 * rate
    stiffness = np.diag([mass * 60000.0**2, mass * 62000.0**2])
    damping = [[1e-8, -coriolis], [coriolis, 1e-8]]
    force = harmonic([1e-7, 0.0], angular_frequency=60000.0)
    coefficients = [stiffness, damping, mass * np.eye(2)]
    return equations(coefficients, [[1e-6, 0.0], [0.0, 1e-3]], spaced(1e-6, 2.0), force)


@family("size", "masses", (2.0, 3.0, 5.0, 8.0, 12.0, 20.0, 40.0))
@declares(finite_zeros=lambda n: 2 * int(n), symmetric=True, mass_ratio=1.0, jumps=False, impulses=0)
def chain_of_masses(count: float) -> StudyProblem:
    """Chains of 2 to 40 masses.

    Errors must not grow with the size faster than the size.
    """
    n = int(count)
    system = bodies([1.0] * n, chain(*[1.0] * n), [(0, 1, 0.25)])
    return moving(system, spaced(0.1, 100.0, 6), (np.eye(n)[-1], np.zeros(n)))
