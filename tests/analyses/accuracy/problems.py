"""Problems with every kind of force, for the methods that are compared."""

from pathlib import Path

import numpy as np

import mbconstrained as mb
from mbconstrained.analyses.study_problem import StudyProblem, mechanical_problem

SWITCHES = ("[[model.contact]]", "[[model.backlash]]", "[[model.clutch]]", "[[model.dry_friction]]")

#: All scenes but those with delays, whose equations are no finite system of first order, and with switches, which have several.
EXAMPLES = sorted(
    path.name
    for path in (Path(__file__).parents[3] / "examples").glob("*.toml")
    if not any(table in path.read_text(encoding="utf-8") for table in ("delayed_feedback", *SWITCHES))
)

TIMES = np.linspace(0.0, 4.0, 81)

#: On the second of three masses.
V = np.array([0.0, 2.0, 0.0])

#: Knots on the times, between them, and Dirac impulses at 0 and later.
FORCES = {
    "none": None,
    "step": mb.step(V),
    "ramp": mb.ramp(V),
    "harmonic": mb.harmonic(V, angular_frequency=3.0, phase=0.4),
    "t^2 e^(a t) cos": mb.term(V, power=2, rate=-0.7, angular_frequency=2.0, phase=1.0),
    "at a zero of the system": mb.harmonic(V, angular_frequency=1.0) + mb.term(V, power=1, rate=-0.5),
    "record": mb.sampled([0.0, 0.5, 1.0, 1.7, 3.0], np.outer(V, [1.0, -2.0, 3.0, 0.5, 0.0])),
    "pulse": mb.pulse(V, start=0.5, duration=1.25),
    "pulse between times": mb.pulse(V, start=0.52, duration=1.111),
    "impulse at 0": mb.impulse(V),
    "delayed impulse": mb.impulse(V).delayed(1.5),
    "delayed derivative of an impulse": (mb.impulse(0.1 * V, order=1) + mb.step(V)).delayed(0.77),
    "two forces": mb.harmonic(V, angular_frequency=3.0) + mb.ramp([1.0, 0.0, -1e-3]) + mb.step([0.0, 0.0, 5.0]).delayed(2.0),
}


def chain(constraints=(), mass=(1.0, 2.0, 3.0), damping: float = 0.3) -> mb.MechanicalSystem:
    """Three masses, springs between them and to the ground, the first damped."""
    stiffness = np.array([[6.0, -2.0, 0.0], [-2.0, 5.0, -3.0], [0.0, -3.0, 7.0]])
    return mb.MechanicalSystem(np.diag(mass), np.diag([damping, 0.0, 0.1]), stiffness, constraints)


#: The difference of two coordinates, held at a value.
TIE = mb.Constraint([1.0, -1.0, 0.0], value=0.25)

_EXACT: dict[tuple, np.ndarray] = {}

SYSTEMS = {
    "regular mass": (chain(), [0.3, 0.0, -0.2], [0.0, 1.0, 0.0]),
    "massless and damped": (chain(mass=(0.0, 2.0, 3.0)), [0.3, 0.0, -0.2], [0.0, 1.0, 0.0]),
    "tied": (chain([TIE]), [0.25, 0.0, -0.2], [1.0, 1.0, 0.0]),
    "tied, inconsistent start": (chain([TIE]), [0.3, 0.1, 0.0], [0.5, -0.5, 0.0]),
    "tied at velocity level": (
        chain([mb.Constraint([1.0, -1.0, 0.0], level="velocity", value=0.1)]),
        [0.3, 0.1, 0.0],
        [1.0, 0.9, 0.0],
    ),
    "tied at acceleration level": (
        chain([mb.Constraint([1.0, -1.0, 0.0], level="acceleration", value=0.2)]),
        [0.3, 0.1, 0.0],
        [1.0, 0.5, 0.0],
    ),
}


def problem(system: str, force: str, times=TIMES) -> StudyProblem:
    """One of the systems under one of the forces."""
    equations, displacement, velocity = SYSTEMS[system]
    return mechanical_problem(f"{system}, {force}", equations, times, displacement, velocity, FORCES[force])


def exact(found: StudyProblem, step: int) -> np.ndarray:
    """x at every so many of the times by rational and ball arithmetic, rounded once; found once for the same title and times."""
    key = found.title, found.times.tobytes(), step
    if key not in _EXACT:
        _EXACT[key] = found.solve().enclose(found.times[::step], digits=17).lower.astype(float)
    return _EXACT[key]


def error(found: StudyProblem, values: np.ndarray, step: int = 16) -> float:
    """max |error| / max |x|, at every so many of the times."""
    truth, places = exact(found, step), slice(None, None, step)
    return float(np.abs(values[:, places] - truth).max() / np.abs(truth).max())


def answer(method, found: StudyProblem, value=None) -> np.ndarray:
    """What a method gives with one of its settings."""
    return method.prepare(found, value)()
