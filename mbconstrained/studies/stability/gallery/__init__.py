"""The gallery of stiff and extreme systems, by themes; each declares its properties, which exact arithmetic checks."""

from __future__ import annotations

from ....ground.checks import nearest
from ....ground.errors import InputError
from . import constraints_gallery, forces_gallery, inertia_gallery, stiffness_gallery, structure_gallery, weak_gallery
from .entry import SYSTEMS, System

#: The chapters in their order.
THEMES = (
    "stiffness",
    "mass",
    "damping",
    "constraints",
    "time",
    "units and scale",
    "structure",
    "forces",
    "size",
    "small next to large",
)

GALLERY: tuple[System, ...] = tuple(sorted(SYSTEMS, key=lambda one: THEMES.index(one.theme)))


def system(name: str) -> System:
    """The system with this name.

    >>> system("resonance").parameter
    'detuning of the force'
    """
    systems = {one.name: one for one in GALLERY}
    if name not in systems:
        raise InputError(f"gallery: there is no system {name!r}{nearest(str(name), systems)}; known are {', '.join(systems)}")
    return systems[name]
