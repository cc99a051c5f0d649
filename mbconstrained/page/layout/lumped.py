"""A drawing for a lumped model: chains of masses, trains of wheels, and what ties them to each other."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

import numpy as np

from ...checks import names_of
from ...models.elements import GROUND, Element, Gear, Lever, Node, Pulley, Rack
from ...models.elements import Body as ModelBody
from ..drawing import Body, Drawing, Vector
from .chains import Chain
from .coordinates import rows_of
from .joints import groups, joints_of, natural_positions, walk
from .magnification import angle_scale, displacement_scale
from .mates import assembled, stacked
from .piece import Piece
from .ties import PULLEY, Tie, lever_tie, pulley_tie, rack_tie
from .turning import direction_of, turned_pieces
from .wheels import Train

#: Two directions (unit vectors) that differ by less are one but for rounding.
ALIKE = 1e-9

#: Of the elements that are drawn as a sketch.
MOST_NAMED = 3


def lumped_drawing(elements: Iterable[Element], names, values=None, scale=None, turn_scale=None, directions=None) -> Drawing:
    """A drawing of a lumped model that shows what is joined to what; distances are schematic, motion is to scale.

    A body stands at its place in the layout plus its displacement from the state in which all springs and rods have
    their lengths, so that a spring is drawn longer by as much as it is stretched.

    Args:
        elements: of the model, bodies and what joins them.
        names: r coordinate names, the bodies' names.
        values: the motion (r, T) or typical values (r,), by which the magnification is chosen; None for 1.
        scale, turn_scale: the magnification of displacements and of angles, where it shall not be chosen.
        directions: vectors by name, of bodies that move along, or turn about, another axis than usual.

    Raises:
        InputError: repeated names, values of another shape, NaN or infinity.

    >>> from mbconstrained.models.elements import Mass, Spring
    >>> drawing = lumped_drawing([Mass("cart", 10.0), Spring("k", "ground", "cart", 2.0)], ["cart"], [0.01])
    >>> [body.name for body in drawing.bodies]
    ['ground left of cart', 'cart']
    >>> drawing.scale
    70.0
    """
    names = names_of(names, len(names), "drawing, names", "x")
    motion = {} if values is None else dict(zip(names, rows_of(values, len(names))))
    return _Sketch(tuple(elements), motion, scale, turn_scale).drawing(directions or {})


class _Sketch:
    """A model on its way to a drawing; ``motion`` has the typical values (T,) of each coordinate, if any are known."""

    def __init__(self, elements: tuple[Element, ...], motion: dict[str, np.ndarray], scale=None, turn_scale=None):
        self.elements = elements
        bodies = self._all(ModelBody)
        self.turning = [body.name for body in bodies if body.unit == "rad"]
        self.sliding = [body.name for body in bodies if body.unit != "rad"]
        self.massless = frozenset(body.name for body in bodies if isinstance(body, Node))
        self.spots = {body.name: body.position for body in bodies if getattr(body, "position", None) is not None}
        joints = joints_of(elements)
        self.slides = [joint for joint in joints if joint.ends <= {GROUND, *self.sliding}]
        self.twists = [joint for joint in joints if joint.ends <= {GROUND, *self.turning}]
        self.natural = natural_positions(self.sliding, self.slides)
        turns = [motion[name] for name in self.turning if name in motion]
        self.scale = self._scale(motion) if scale is None else scale
        self.turn_scale = angle_scale(turns) if turn_scale is None else turn_scale

    def drawing(self, directions: Mapping[str, Vector]) -> Drawing:
        """Everything in place."""
        meshing = [(gear.start, gear.end) for gear in self._all(Gear)]
        pieces = turned_pieces(self._chains() + self._trains(), directions, meshing)
        home = {name: piece for piece in pieces for name in piece.names}
        ties = list(filter(None, (self._tie(element, home) for element in self.elements)))
        pieces += [tie.piece for tie in ties if tie.piece]
        whole = stacked(assembled(pieces, [mate for tie in ties for mate in tie.mates]))
        links = (*whole.links, *(link for tie in ties for link in tie.links))
        bodies = tuple(self._at_natural_place(body) for body in whole.bodies)
        notes = self._missing({link.name for link in links}), self._askew(bodies)
        return Drawing(bodies, links, self.scale, self.turn_scale, " · ".join(filter(None, notes)))

    def _all(self, kind: type) -> list:
        return [element for element in self.elements if isinstance(element, kind)]

    def _scale(self, motion: dict[str, np.ndarray]) -> float:
        moves = {name: motion[name] - self.natural[name] for name in self.sliding if name in motion}
        pairs = [(joint.start, joint.end) for joint in self.slides]
        pairs += [(end, pulley.over) for pulley in self._all(Pulley) for end in (pulley.start, pulley.end)]
        return displacement_scale(moves, pairs)

    def _chains(self) -> list[Piece]:
        pulleys = self._all(Pulley)
        on_rope = {name for pulley in pulleys for name in (pulley.start, pulley.end)}
        carrying = {pulley.over for pulley in pulleys}
        return [self._chain(group, on_rope, carrying) for group in groups(self.sliding, [j.ends for j in self.slides])]

    def _chain(self, group: list[str], on_rope: set[str], carrying: set[str]) -> Piece:
        """From left to right; on a rope, from the rope down; carrying a pulley, down to it."""
        roped = next(filter(on_rope.__contains__, group), None)
        carrier = next(filter(carrying.__contains__, group), None)
        if roped:
            return Chain(walk(group, self.slides, roped), self.massless, self.slides, wall=False).piece().hanging()
        if carrier:
            return Chain(walk(group, self.slides, carrier)[::-1], self.massless, self.slides).piece().hanging()
        placed = all(name in self.spots for name in group)
        order = sorted(group, key=self.spots.get) if placed else walk(group, self.slides)
        return Chain(order, self.massless, self.slides).piece()

    def _trains(self) -> list[Piece]:
        gears = self._all(Gear)
        pairs = [joint.ends for joint in self.twists] + [frozenset((gear.start, gear.end)) for gear in gears]
        racked = frozenset(rack.gear for rack in self._all(Rack) if rack.radius > 0)
        return [Train(group, self.massless, self.twists, gears, racked).piece() for group in groups(self.turning, pairs)]

    def _tie(self, element: Element, home: dict[str, Piece]) -> Tie | None:
        """What a lever, a rack or a pulley adds; None for anything else, and for a lever between bodies of one chain."""
        if isinstance(element, Pulley):
            return pulley_tie(element, self.scale / (PULLEY * self.turn_scale))
        if isinstance(element, Rack):
            return rack_tie(element, home[element.gear].body(element.gear), home[element.rack].body(element.rack))
        if isinstance(element, Lever) and home[element.start] is not home[element.end]:
            return lever_tie(element, home[element.start], home[element.end])
        return None

    def _at_natural_place(self, body: Body) -> Body:
        """The body with its place for all coordinates zero, from its place in the layout."""
        shift = sum((self.natural[name] * np.array(move) for name, move in body.moves.items()), np.zeros(3))
        return replace(body, rest=tuple(body.rest - self.scale * shift))

    def _askew(self, bodies: Iterable[Body]) -> str:
        """Which elements are drawn longer by something else than they are stretched: their ends go different ways."""
        ways = {body.name: direction_of(body) for body in bodies if body.moves or body.turns}
        joints = (joint for joint in self.slides + self.twists if GROUND not in joint.ends)
        names = [joint.name for joint in joints if not np.allclose(ways[joint.start], ways[joint.end], rtol=0, atol=ALIKE)]
        further = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
        join = "joins" if len(names) == 1 else "join"
        return f"{', '.join(names[:MOST_NAMED])}{further} {join} bodies of different directions: drawn as a sketch" if names else ""

    def _missing(self, drawn: set[str]) -> str:
        """Which rows are not in the picture; gears and racks are, as wheels that touch."""
        others = (element for element in self.elements if not isinstance(element, (ModelBody, Gear, Rack)))
        missing = [element.name for element in others if element.name not in drawn]
        return f"not drawn: {', '.join(missing)}" if missing else ""
