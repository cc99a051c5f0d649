"""Automatic drawings: chains of masses and trains of wheels of a lumped model, or boxes and discs for coordinates."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from ...ground.coordinate_units import GROUND
from ...models.elements import Body as ModelBody
from ...models.elements import Element, Mass, Node, Pulley, Rack, Relation, with_parts
from .bars import bar_length, bar_pieces, bars_of
from .bodies import Drawing, DrawnBody, DrawnLink
from .chains import Chain, are_storeys, columns, storeys
from .layout import (
    PULLEY,
    DrawnJoint,
    Piece,
    angle_scale,
    direction_of,
    displacement_scale,
    groups,
    joints_of,
    natural_positions,
    stacked,
    tie_of,
    turned_piece,
    walk,
)
from .wheels import Train

#: Two directions (unit vectors) that differ by less are equal within rounding error.
ALIKE = 1e-9

#: Names in the note on elements that are not drawn to scale.
MOST_NAMED = 3

#: Distances from one coordinate to the next, downwards and across, and to the right of all, drawing units.
PITCH, WIDTH, GAP = 0.95, 5.6, 0.8


def lumped_drawing(
    elements: Iterable[Element], names, values=None, scale=None, turn_scale=None, directions=None, stack=None
) -> Drawing:
    """A drawing of a lumped model and its connections; distances are schematic, motion is to scale.

    A body stands at its place in the layout plus its displacement from the state in which all springs and rods have
    their lengths, so that a spring is drawn longer by as much as it is stretched.

    >>> from mbconstrained.models.elements import Mass, Spring
    >>> drawing = lumped_drawing([Mass("cart", 10.0), Spring("ground", "cart", 2.0, name="k")], ["cart"], [0.01])
    >>> [body.name for body in drawing.bodies]
    ['ground left of cart', 'cart']
    >>> drawing.scale
    70.0
    """
    elements, motion = with_parts(elements), {} if values is None else _motion(names, values)
    bodies = [element for element in elements if isinstance(element, ModelBody)]
    gears: list[Any] = [element for element in elements if element.symbol == "gear"]
    pulleys = [element for element in elements if isinstance(element, Pulley)]
    turning = [body.name for body in bodies if body.unit == "rad"]
    sliding = [body.name for body in bodies if body.unit != "rad"]
    joints = joints_of(elements)
    slides = [joint for joint in joints if joint.ends <= {GROUND, *sliding}]
    twists = [joint for joint in joints if joint.ends <= {GROUND, *turning}]
    bars = bars_of(elements)
    natural, length = _natural(sliding, slides, bars), bar_length(bars) if bars else 1.0
    scale = (
        _slide_scale(slides, pulleys, {name: motion[name] for name in sliding if name in motion}, natural)
        if scale is None
        else scale
    )
    lying = {bar.angle for bar in bars if not any(bar.angle in joint.ends for joint in twists)}
    wheels = [name for name in turning if name not in lying]
    if turn_scale is None:
        turn_scale = angle_scale([motion[name] for name in wheels if name in motion]) if wheels or not bars else scale / length

    massless = frozenset(body.name for body in bodies if isinstance(body, Node))
    spots = {body.name: body.position for body in bodies if isinstance(body, Mass) and body.position is not None}
    meshing = [(gear.start, gear.end) for gear in gears]
    racked = frozenset(rack.gear for rack in elements if isinstance(rack, Rack) and rack.radius > 0)
    pieces = bar_pieces(bars, sliding, slides, massless, length, scale / (length * (turn_scale or 1.0)))
    barred = {name for piece in pieces for body in piece.bodies for name in (body.name, *body.moves)}
    rows = groups([name for name in sliding if name not in barred], (joint.ends for joint in slides))
    upright = {tuple(group) for group in rows if stack == "vertical" or (stack is None and are_storeys(group))}
    chains = [
        storeys(walk(group, slides), slides) if tuple(group) in upright else _chain(group, slides, massless, pulleys, spots)
        for group in rows
    ]
    trains = groups(wheels, [*(joint.ends for joint in twists), *meshing])
    chains += [Train(group, massless, twists, gears, racked).piece() for group in trains]
    if directions:
        chains = [turned_piece(piece, directions, meshing) for piece in chains]
    pieces += chains
    home = {name: piece for piece in pieces for name in piece.names}
    ties = [tie_of(element, home, scale / (PULLEY * (turn_scale or 1.0))) for element in elements]
    ties = [tie for tie in ties if tie is not None]
    pieces += [tie.piece for tie in ties if tie.piece]
    whole = stacked(pieces, [mate for tie in ties for mate in tie.mates])
    links = (*whole.links, *(link for tie in ties for link in tie.links))

    drawn = [_at_zero(body, natural, scale) for body in whole.bodies]
    notes = _not_drawn(elements, {link.name for link in links}.union(*(bar.rows for bar in bars))), _askew(drawn, slides + twists)
    return Drawing(tuple(drawn), links, scale, turn_scale, " · ".join(filter(None, notes)))


def _at_zero(body: DrawnBody, natural: dict, scale: float) -> DrawnBody:
    """The body at the position for all coordinates zero, from its position in the layout."""
    shift = sum((natural[name] * np.array(move) for name, move in body.moves.items()), np.zeros(3))
    return replace(body, rest=tuple(body.rest - scale * shift))


def _not_drawn(elements: Iterable[Element], known: set[str]) -> str:
    """A note of the elements without a link; gears and racks are drawn as wheels in contact."""
    others = (element for element in elements if element.symbol not in (None, "gear", "rack") or isinstance(element, Relation))
    missing = ", ".join(element.name for element in others if element.name not in known)
    return f"not drawn: {missing}" * bool(missing)


def _natural(sliding: list[str], slides: list[DrawnJoint], bars) -> dict:
    """Positions in which all springs have their lengths; bars are level where none of their springs is stretched on the average."""
    natural = natural_positions(sliding, slides)
    for bar in bars:
        natural |= dict.fromkeys(bar.places, float(np.mean([natural[point] for point in bar.points or bar.places])))
    return natural


def _slide_scale(slides: list[DrawnJoint], pulleys: list[Pulley], motion: dict, natural: dict) -> float:
    """The magnification of displacements."""
    pairs = [(joint.start, joint.end) for joint in slides]
    pairs += [(end, pulley.over) for pulley in pulleys for end in (pulley.start, pulley.end)]
    return displacement_scale({name: motion[name] - natural[name] for name in natural if name in motion}, pairs)


def _motion(names, values) -> dict[str, np.ndarray]:
    values = np.asarray(values, dtype=float)
    return dict(zip(names, values[:, None] if values.ndim == 1 else values))


def _chain(group: list[str], joints: list[DrawnJoint], massless: frozenset[str], pulleys: list[Pulley], spots) -> Piece:
    """Chain from left to right; on a rope, from the rope downwards; carrying a pulley, down to it."""
    roped = next((name for name in group if any(name in (pulley.start, pulley.end) for pulley in pulleys)), None)
    if roped:
        return Chain(walk(group, joints, roped), massless, joints, wall=False).piece().hanging()
    carrier = next((name for name in group if any(name == pulley.over for pulley in pulleys)), None)
    if carrier:
        return Chain(walk(group, joints, carrier)[::-1], massless, joints).piece().hanging()
    placed = all(name in spots for name in group)
    return Chain(sorted(group, key=spots.get) if placed else walk(group, joints), massless, joints).piece()


def _askew(bodies: list[DrawnBody], joints: list[DrawnJoint]) -> str:
    """A note on elements whose drawn length does not show their elongation: their ends have different directions."""
    directions = {body.name: direction_of(body) for body in bodies if body.moves or body.turns}
    between = [joint for joint in joints if GROUND not in joint.ends]
    names = [joint.name for joint in between if np.abs(directions[joint.start] - directions[joint.end]).max() > ALIKE]
    if not names:
        return ""
    further = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    join = "joins" if len(names) == 1 else "join"
    return f"{', '.join(names[:MOST_NAMED])}{further} {join} bodies of different directions: not drawn to scale"


def coordinate_drawing(names, values=None, units=None, scale=None, turn_scale=None, directions=None, stack=None) -> Drawing:
    """A box on a rail for each displacement, a disc for each angle, one below the other, in several columns when there are many.

    >>> [body.shape for body in coordinate_drawing(["x1", "q"], [0.01, 1.0], ["m", "rad"]).bodies]
    ['rail', 'box', 'disc']
    """
    unit_of = dict(zip(names, ["m"] * len(names) if units is None else units))
    motion, directions = _motion(names, np.zeros(len(names)) if values is None else values), directions or {}
    drawn = [name for name in names if unit_of[name] in ("m", "rad")]
    floors = [name for name in drawn if unit_of[name] == "m" and name not in directions]
    floors = floors if stack == "vertical" or (stack is None and are_storeys(floors)) else []
    building = storeys(floors, columns(floors)) if floors else Piece(())
    usual = [name for name in drawn if name not in directions and name not in floors]
    rows = max(6, math.ceil(1.3 * math.sqrt(len(usual))))
    bodies = []
    for i, name in enumerate(usual):
        bodies += _of_coordinate(name, unit_of[name], (WIDTH * (i // rows), 0.0, -PITCH * (i % rows)))
    left = Piece(tuple(bodies)).corners[1, 0] + GAP if bodies else 0.0
    if floors:
        low, high = building.corners
        bodies += building.shifted((left - low[0], 0.0, 0.0)).bodies
        left += high[0] - low[0] + GAP
    for name in drawn:
        if name in directions:
            own = _of_coordinate(name, unit_of[name], (0.0, 0.0, 0.0))
            links = tuple(DrawnLink("", "rod", own[0].name, body.name) for body in own[1:])  # so that they are turned together
            piece = Piece(turned_piece(Piece(tuple(own), links), {name: directions[name]}).bodies)
            low, high = piece.corners
            bodies += piece.shifted((left - low[0], 0.0, 0.0)).bodies
            left += high[0] - low[0] + GAP
    if scale is None:
        moves = {name: motion[name] for name in names if unit_of[name] == "m"}
        scale = displacement_scale(moves, pairwise((GROUND, *floors)))
    if turn_scale is None:
        turn_scale = angle_scale([motion[name] for name in names if unit_of[name] == "rad"])
    missing = [name for name in names if name not in drawn]
    note = f"not drawn, neither displacement nor angle: {', '.join(missing)}" if missing else ""
    return Drawing(tuple(bodies), building.links, scale, turn_scale, note)


def _of_coordinate(name: str, unit: str, place: tuple[float, float, float]) -> list[DrawnBody]:
    if unit == "rad":
        return [DrawnBody(name, "disc", place, turns={name: (0.0, -1.0, 0.0)}, size=(0.6, 0.2, 0.6))]
    rail = DrawnBody(f"rail of {name}", "rail", (place[0], 0.0, place[2] - 0.24), size=(5.0, 0.3, 0.05))
    return [rail, DrawnBody(name, "box", place, {name: (1.0, 0.0, 0.0)}, size=(0.42, 0.42, 0.42))]
