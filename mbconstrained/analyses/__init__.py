"""Questions to a model, one file each: settings with units and a sentence of help, and a function from the model to an answer.

Read ``base`` (what an analysis declares, what every answer can do), then any of the others. The command, its options, the table of the
scene and all files follow from the declaration. ``run`` is the motion over time, with its tables and plots in ``motion_report``;
``python_models`` gives motions and modes that were computed in Python the same pages.
"""

from __future__ import annotations

from importlib import import_module

#: The analyses by name: the modules that declare them.
ANALYSES = {
    "modes": "modes",
    "frequency": "frequency",
    "random": "random",
    "shock": "shock",
    "sensitivity": "sensitivity",
    "mac": "mac",
    "campbell": "campbell",
    "locus": "locus",
    "path": "path",
    "formula": "formula",
    "compare": "compare",
    "accuracy": "accuracy.accuracy",
    "stability": "stability.stability",
    "sweep": "sweep.sweep",
    "optimise": "sweep.optimisation",
}


def load(name: str):
    """The analysis of this name; its module is imported then."""
    module = import_module(f".{ANALYSES[name]}", __name__)
    return next(one for one in vars(module).values() if getattr(one, "name", None) == name and isinstance(one, type))
