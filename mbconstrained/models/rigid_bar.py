"""A rigid bar of a lumped model: a body of two coordinates, with its elements."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields

from ..ground.checks import ReadOnly, real_number
from ..ground.errors import InputError
from .elements import Element, Inertia, Mass, Node, Relation


@dataclass(frozen=True)
class RigidBar(Mass):
    """A rigid bar that is displaced across its length and turns by a small angle, m x'' = sum of forces, J q'' = sum of moments.

    Its coordinates are the displacement of its centre of mass, named as the bar, its angle, "NAME angle", and the displacement
    of each of its points, named as the point, which springs, dampers and ties are attached to. For each point there is a
    constraint row x_point - x - distance q = 0; its multiplier is the force on the point.

    Its mass is m > 0, in kg.

    Args:
        inertia: J > 0 about the centre of mass, in kg m^2.
        points: by name the distances from the centre of mass along the bar, in m; of either sign.

    Example:
        Bounce and pitch of a vehicle on two equal springs at equal distances are independent: w^2 = 2 k/m and 2 k d^2/J.

        >>> from mbconstrained import LumpedModel
        >>> model = LumpedModel()
        >>> _ = model.rigid_bar("body", 2.0, inertia=1.0, points={"rear": -1.0, "front": 1.0})
        >>> _ = model.spring("ground", "front", 4.0), model.spring("ground", "rear", 4.0)
        >>> model.assemble().modes().natural_frequencies.round(9).tolist()
        [2.0, 2.828427125]
    """

    inertia: float = field(kw_only=True)
    points: Mapping[str, float] = field(kw_only=True)

    positive = ("mass", "inertia")
    constant = property(lambda self: self.mass)

    def __post_init__(self):
        if not isinstance(self.points, Mapping) or not self.points:
            raise InputError(f'{self.label}: points: expected distances by name, such as {{"rear": -1.5, "front": 1.2}}')
        for point in self.points:
            if not isinstance(point, str) or not point.strip():
                raise InputError(f"{self.label}: points: found the name {point!r}; expected a text")
        distances = {point: real_number(value, f'{self.label}: distance of "{point}"') for point, value in self.points.items()}
        object.__setattr__(self, "points", ReadOnly(distances))
        Element.__post_init__(self)

    @property
    def angle(self) -> str:
        """Name of the coordinate of its angle."""
        return f"{self.name} angle"

    @property
    def parts(self) -> tuple[Element, ...]:
        """The inertia of its angle, a node for each point, and the rows of the points."""
        rows = (
            unchecked(Relation, name=f"{point} on {self.name}", coefficients={point: 1.0, self.name: -1.0, self.angle: -distance})
            for point, distance in self.points.items()
        )
        nodes = (unchecked(Node, name=point) for point in self.points)
        return (unchecked(Inertia, name=self.angle, inertia=self.inertia), *nodes, *rows)


def unchecked(kind: type, **values) -> Element:
    """An element without validation of its constants, which another element has checked; in formulas they are expressions."""
    element = object.__new__(kind)
    for each in fields(kind):
        object.__setattr__(element, each.name, values.get(each.name, each.default))
    return element


def with_parts(elements: Iterable[Element]) -> tuple[Element, ...]:
    """The elements, each followed by its parts."""
    return tuple(one for element in elements for one in (element, *element.parts))
