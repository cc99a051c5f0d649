"""Questions to a model, one file each: settings with units and a sentence of help, and a function from the model to an answer.

Read ``base`` (what an analysis declares, what every answer can do), then any of the others. The command, its options, the table of the
scene and all files follow from the declaration. ``run`` is the motion over time, with its tables and plots in ``motion_report``, ``discrete_run`` that
at samples alone, and ``run_analysis`` chooses between them;
``python_models`` gives motions and modes that were computed in Python the same pages.
"""

from __future__ import annotations

from importlib import import_module

#: The analyses by name: the module that declares each, and its sentence in the list of commands, which needs no import.
ANALYSES = {
    "run": ("run_analysis", "Solve a scene and write its page, CSV and npz."),
    "modes": ("modes", "List the modes of a scene, with shapes and energies."),
    "frequency": ("frequency", "Frequency response: peaks, antiresonances, Bode plots."),
    "random": ("random", "Random vibration: RMS values, spectra, expected largest values."),
    "shock": ("shock", "Peaks under a shock, shock response spectra."),
    "fatigue": ("fatigue", "Cycles by the rainflow method, damage, fatigue damage spectra."),
    "sensitivity": ("sensitivity", "Derivatives of frequencies and damping, sorted by influence."),
    "mac": ("mac", "Which modes of two scenes are the same: modal assurance criterion."),
    "campbell": ("campbell", "Critical speeds, whirl, stability and unbalance of a rotor; interference diagrams."),
    "orders": ("orders", "Response to orders of a speed: torques of a driveline, a run-up."),
    "steady": ("steady", "Steady state: the cycle under harmonic loads, a repeated record, or of a switched model."),
    "locus": ("locus", "Root locus: eigenvalues over a parameter, with break points."),
    "path": ("path", "Frequencies of a robot along a path of one of its points."),
    "formula": ("formula", "The formula of each coordinate, with parameters as symbols."),
    "compare": ("compare", "Run scenes, or one with several values, and overlay their curves."),
    "accuracy": ("accuracy.accuracy", "Error against run time, compared with other tools."),
    "stability": ("stability", "Correct, expected and claimed digits over decades."),
    "sweep": ("sweep.sweep", "Vary parameters: grids, Monte Carlo, statistics, Sobol indices."),
    "optimise": ("sweep.optimisation", "Find the values of parameters that make a figure least or largest."),
}


def load(name: str):
    """The analysis of this name; its module is imported then."""
    module = import_module(f".{ANALYSES[name][0]}", __name__)
    return next(one for one in vars(module).values() if getattr(one, "name", None) == name and isinstance(one, type))
