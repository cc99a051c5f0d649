"""What a lumped model is made of: plain records, each with its equation. "ground" is the body that stays at 0."""

from .bodies import Body, Inertia, Mass, Node
from .element import GROUND, Element
from .links import Damper, Link, Spring, TorsionDamper, TorsionSpring
from .ties import Gear, Lever, Pulley, Rack, Relation, RigidTie, Tie

__all__ = [
    "GROUND",
    "Body",
    "Damper",
    "Element",
    "Gear",
    "Inertia",
    "Lever",
    "Link",
    "Mass",
    "Node",
    "Pulley",
    "Rack",
    "Relation",
    "RigidTie",
    "Spring",
    "Tie",
    "TorsionDamper",
    "TorsionSpring",
]
