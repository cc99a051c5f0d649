"""Forces at resonance and slow forces on stiff systems; very long and very short times."""

from __future__ import annotations

import numpy as np

from ....signals.inputs import ramp, step, term
from ...study_problem import StudyProblem
from .entry import bodies, decades, declares, equations, family, moving, spaced

#: rad/s, of the double zero of ``resonance``.
NATURAL = 3.0


@family("forces", "detuning of the force", (*decades(-1, -15), 0.0))
@declares(finite_zeros=4, longest_chain=2, undamped=True)
def resonance(detuning: float) -> StudyProblem:
    """Resonance approached at a double zero.

    Near resonance the answer is the difference of two large oscillations; at resonance a chain of length 3 with the force.

    Source: referee case resonance_double.
    """
    # Two oscillators one after the other, both at 3 rad/s, under a sine near it: x grows like t^2.
    coefficients = [[[18.0, -9.0], [-47.0, 28.0]], np.zeros((2, 2)), [[2.0, -1.0], [-5.0, 3.0]]]
    force = term([1.0, 1.0], angular_frequency=NATURAL * (1 + detuning), phase=-np.pi / 2)
    return equations(coefficients, [[1.0, 1.0], [0.0, 2.0]], spaced(0.05, 60.0), force)


@family("forces", "stiffness ratio", decades(0, 16, 2))
@declares(finite_zeros=4, symmetric=True, stiffness_ratio=lambda ratio: ratio, growing_zeros=0, jumps=False)
def ramp_on_stiff_pair(ratio: float) -> StudyProblem:
    """A ramp on a stiff pair.

    The stretch of the stiff spring is 1 / r of the motion, and its ringing is sqrt(r) times as fast.
    """
    system = bodies([1.0, 2.0], [(0, 1, 1.0), (1, 2, ratio)], [(1, 2, 0.1 * ratio**0.5)])
    return moving(system, spaced(0.1, 100.0), ([0.0, 0.0], [1.0, 1.0]), ramp([0.5, 1.0]))


@family("forces", "stiffness of the mount", decades(0, -16, 2), "1/s^2")
@declares(finite_zeros=4, undamped=True, growing_zeros=0, zeros_at_0=0)
def soft_mount(stiffness: float) -> StudyProblem:
    """A load on a soft mount.

    The load's answer is the difference of a large static deflection and a slow oscillation, until they separate.
    """
    # (s^2 + k) (s^2 + 4) x = a step: a slow and an ordinary mode under a constant load.
    coefficients = [4 * stiffness, 0.0, 4 + stiffness, 0.0, 1.0]
    return equations([[[c]] for c in coefficients], [0.0] * 4, np.linspace(0.0, 5.0, 11), step([1.0]))


@family("forces", "stiffness of the mounts", decades(0, -12, 2), "1/s^2")
@declares(finite_zeros=6, zeros_at_0=0)
def slow_pair(stiffness: float) -> StudyProblem:
    """Two slow modes and an ordinary one.

    The two slow motions cancel but for a small remainder until they separate, long after the times asked for.
    """
    # (s^2 + k) (s^2 + 2 k) (s^2 + 4) x = a step: two slow modes and an ordinary one.
    k = stiffness
    coefficients = [8 * k**2, 0.0, 2 * k**2 + 12 * k, 0.0, 4 + 3 * k, 0.0, 1.0]
    return equations([[[c]] for c in coefficients], [0.0] * 6, np.linspace(0.0, 5.0, 11), step([1.0]))


@family("forces", "rate r", decades(0, 16, 2), "1/s")
@declares(finite_zeros=1, growing_zeros=0, zeros_at_0=0, jumps=False)
def prothero_robinson(rate: float) -> StudyProblem:
    """A smooth motion and a fast decay.

    The answer is cos t at any rate; steps that are long relative to 1 / r lose the order of most methods.

    Source: Prothero and Robinson, Math. Comp. 28 (1974) 145-162.
    """
    # x' = -r (x - cos t) - sin t from x = 1, whose answer is cos t at any rate r.
    force = term([rate], angular_frequency=1.0) + term([-1.0], angular_frequency=1.0, phase=-np.pi / 2)
    return equations([[[rate]], [[1.0]]], [1.0], spaced(0.01, 100.0), force)


@family("time", "end", (*decades(1, 6), 5e6, 1e8, 1e10), "s")
@declares(finite_zeros=4, undamped=True, symmetric=True, longest_chain=1)
def long_horizon(end: float) -> StudyProblem:
    """Undamped, to a million periods.

    An error of eps in a frequency is an error of eps w t in the phase: with the horizon all lose digits, and should say so.

    Source: referee case long_1e6.
    """
    # Two undamped oscillators up to a million periods.
    coefficients = [[[3.0, -1.0], [-1.0, 2.5]], np.zeros((2, 2)), np.diag([1.0, 1.25])]
    return equations(coefficients, [[1.0, 0.5], [0.0, -1.0]], spaced(1.0, end))


@family("time", "end", decades(0, 8), "s")
@declares(finite_zeros=14, zeros_at_0=2, longest_chain=2, symmetric=True, growing_zeros=0)
def free_chain(end: float) -> StudyProblem:
    """An unconstrained chain under a constant force.

    A double zero at 0 with one chain: x grows like t^2, and a zero at 1e-9 instead would oscillate.

    Source: referee case rigid7.
    """
    springs = [(body, body + 1, 4.0 + body) for body in range(1, 7)]
    dampers = [(body, body + 1, 0.125) for body in range(1, 7)]
    system = bodies([1.0, 1.5, 2.0, 1.0, 1.5, 2.0, 1.0], springs, dampers)
    start = ([0.5, 2.0, -2.0, 0.0, -1.0, -0.5, 0.0], [-1.5, -0.75, 0.75, 0.75, 0.25, -1.0, 0.5])
    return moving(system, spaced(0.1, end), start, step([0.5, 0, 0, 0, 0, 0, 0]))


@family("time", "end", (2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 250.0), "s")
@declares(finite_zeros=6, growing_zeros=1, symmetric=True)
def unstable_growth(end: float) -> StudyProblem:
    """Growth up to e^300 and beyond the range of float64.

    What grows hides all else; beyond 1e308 there is no answer, which is to be said.

    Source: referee case unstable300.
    """
    springs = [(0, 1, 4.0), (1, 2, 3.0), (2, 3, 2.0), (0, 3, -12.0)]
    dampers = [(0, 1, 0.5), (2, 3, 0.25)]
    system = bodies([1.0, 1.0, 1.0], springs, dampers)
    return moving(system, np.linspace(1.0, end, 10), ([1.0, -1.0, 0.5], [0.0, 0.0, 1.0]))


@family("time", "end", decades(1, -10), "s")
@declares(finite_zeros=6, undamped=True, jumps=False, impulses=0)
def first_moments(end: float) -> StudyProblem:
    """The first moments after rest.

    Sums over modes cancel to t^7: at t = 1e-4 all 16 digits of each term, and 12 more.

    Source: made for this gallery: the closed form of Hauksdottir and Sigurdsson, section 5, at small t.
    """
    # The last of three masses in a row, from rest, while a ramp pulls at the first: (s^6 + 5 s^4 + 6 s^2 + 1) x = 1 / s^2.
    coefficients = [[[value]] for value in (1.0, 0.0, 6.0, 0.0, 5.0, 0.0, 1.0)]
    return equations(coefficients, np.zeros((6, 1)), spaced(end / 10, end), ramp([1.0]))
