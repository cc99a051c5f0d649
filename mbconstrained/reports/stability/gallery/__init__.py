"""The project's own gallery of stiff and extreme systems, by themes; each declares what it is, and one runner checks it."""

from __future__ import annotations

from dataclasses import replace

from ....checks import nearest
from ....errors import InputError
from . import constraints, damping, forces, mass, size, stiffness, structure, time, units
from .properties import PROPERTIES, Facts, broken_promises
from .system import System, Varied

#: The chapters in their order.
THEMES = (
    ("stiffness", stiffness.SYSTEMS),
    ("mass", mass.SYSTEMS),
    ("damping", damping.SYSTEMS),
    ("constraints", constraints.SYSTEMS),
    ("time", time.SYSTEMS),
    ("units and scale", units.SYSTEMS),
    ("structure", structure.SYSTEMS),
    ("forces", forces.SYSTEMS),
    ("size", size.SYSTEMS),
)

GALLERY: tuple[System, ...] = tuple(replace(system, theme=theme) for theme, systems in THEMES for system in systems)


def system(name: str) -> System:
    """The system with this name.

    Raises:
        InputError: there is none; the text names the nearest one.

    >>> system("resonance").parameter
    'detuning of the force'
    """
    found = {one.name: one for one in GALLERY}
    if name not in found:
        raise InputError(f"gallery: there is no system {name!r}{nearest(str(name), found)}; known are {', '.join(found)}")
    return found[name]
