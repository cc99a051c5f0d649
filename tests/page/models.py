"""Models with every kind of element, drawn by the layout, for several tests."""

import numpy as np

from mbconstrained.models.lumped import LumpedModel
from mbconstrained.page.animation import Animation
from mbconstrained.page.automatic_drawing import coordinate_drawing, lumped_drawing


def gallery() -> dict[str, Animation]:
    """Models with every kind of element, moving."""
    times = np.linspace(0, 10, 101)
    animations = {}
    for model in (_series(), _gears(), _ropes(), _machines()):
        names = model.coordinates
        values = np.array([np.sin((1 + 0.1 * i) * times) for i in range(len(names))])
        animations[model.title] = Animation(lumped_drawing(model.elements, names, values), names, times, values)
    names, values = tuple(f"q{i}" for i in range(9)), np.array([np.cos((1 + i) * times) for i in range(9)])
    animations["coordinates"] = Animation(coordinate_drawing(names, values), names, times, values)
    return animations


def _series() -> LumpedModel:
    """Massless joints in series with a mass, a link past a body, a tie in the middle, a rod."""
    model = _model("series")
    for name in ("a", "b", "c"):
        model.mass(name, 1.0)
    model.node("joint")
    model.spring("ground", "joint", 1.0)
    model.damper("joint", "a", 1.0)
    model.spring("a", "b", 1.0)
    model.rigid_tie("b", "c")
    model.spring("a", "c", 1.0)
    model.damper("ground", "a", 1.0)
    model.spring("c", "ground", 1.0)
    return model


def _gears() -> LumpedModel:
    """Two shafts in mesh, an inner toothing, a spiral, a brake, a torsion damper and a rack."""
    model = _model("gears")
    for name in ("motor", "wheel", "load", "ring"):
        model.inertia(name, 1.0)
    model.node("pinion", rotational=True)
    model.mass("slide", 1.0)
    model.torsion_spring("ground", "motor", 1.0)
    model.torsion_spring("motor", "pinion", 1.0)
    model.torsion_damper("motor", "pinion", 1.0)
    model.gear("pinion", "wheel", 20, 60)
    model.torsion_spring("wheel", "load", 1.0)
    model.torsion_spring("ground", "load", 1.0)
    model.torsion_damper("ground", "load", 1.0)
    model.gear("wheel", "ring", 60, 90, internal=True)
    model.rack("ring", "slide", 0.1)
    return model


def _ropes() -> LumpedModel:
    """A rope over a fixed pulley, another over a pulley that hangs on a spring."""
    model = _model("ropes")
    for name in ("a", "b", "c", "d", "carrier"):
        model.mass(name, 1.0)
    model.pulley("a", "b")
    model.spring("ground", "carrier", 1.0)
    model.pulley("c", "d", over="carrier")
    return model


def _machines() -> LumpedModel:
    """A lever between two chains, and a row that no link can show."""
    model = _model("machines")
    for name in ("a", "b", "c"):
        model.mass(name, 1.0)
    model.lever("a", "b", 2.0, 1.0)
    model.spring("ground", "a", 1.0)
    model.spring("b", "c", 1.0)
    model.constrain({"a": 1, "b": 2, "c": 3}, name="sum")
    return model


def _model(title: str) -> LumpedModel:
    model = LumpedModel()
    model.title = title
    return model
