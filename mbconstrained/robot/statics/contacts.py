"""Limits of feet on the ground at rest and in motion: forces within friction cones, centres of pressure within soles.

Where statics leaves open how feet share the load, it is only reported that a foot slips if no share keeps all of them in place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import CONE_TOLERANCE
from ..connections import Support
from ..mechanism import Attached
from .balance import Balance
from .equilibrium import Equilibrium, rows_of

#: Sides of the pyramid inside a friction cone: it lacks 0.1 % of the friction.
SIDES = 64

#: Most times at which all shares of the load are tried.
MOST_TRIED = 400

#: Text for a foot that exceeds a limit.
LIFTS, SLIPS, TIPS = "lifts off", "slips", "tips over"
PLURALS = {LIFTS: "lift off", SLIPS: "slip", TIPS: "tip over"}


@dataclass(frozen=True, eq=False)
class Contact:
    """A foot at rest.

    Attributes:
        support: a loop or bushing with friction.
        places: of its multipliers among all; none of a bushing, whose force the posture determines.
        wrench: force in the directions of the ground and torque along x, y, z of the frame on body1, on the foot, for units of its
            multipliers, shape (6, k); of a bushing the force and torque at rest, shape (6, 1).
        frame: directions of the frame on body1, shape (3, 3).
    """

    support: Support
    places: slice | None
    wrench: np.ndarray
    frame: np.ndarray

    def at_rest(self, multipliers: np.ndarray) -> np.ndarray:
        """The force in the directions of the ground and the torque in those of the frame, shape (6, 1)."""
        return self.wrench if self.places is None else (self.wrench @ multipliers[self.places])[:, None]

    def of(self, wrench: np.ndarray) -> np.ndarray:
        """Contact force from a wrench on body2 in the directions of the ground, both of shape (6, T)."""
        on_foot = self.support.on_foot(wrench)
        return np.vstack([on_foot[:3], self.frame.T @ on_foot[3:]])

    def rows(self) -> dict[str, np.ndarray]:
        """Nonnegative quantities by limit, per unit of the multipliers: normal force (N), distances from the sides of the pyramid
        inside the cone (N), moments about the edges of the sole (N m).
        """
        normal = self.support.unit_normal
        across = np.linalg.svd(normal[None])[2][1:]
        angles = np.arange(SIDES) * 2 * np.pi / SIDES
        sides = np.column_stack([np.cos(angles), np.sin(angles)]) @ across
        friction = (self.support.friction or 0.0) * np.cos(np.pi / SIDES)
        force, edges = self.wrench[:3], [np.zeros((0, self.wrench.shape[1]))]
        for extent, moment in zip(self.support.patch or (), (self.wrench[4], self.wrench[3])):
            half = extent / 2 * (normal @ force)
            edges.append(np.vstack([half + moment, half - moment]))
        return {LIFTS: (normal @ force)[None], SLIPS: (friction * normal - sides) @ force, TIPS: np.vstack(edges)}


@dataclass(frozen=True, eq=False)
class Exceeded:
    """Feet that exceed one of their limits.

    Attributes:
        contacts: one foot; several where it is open how they share the load, of which some are outside with every share.
        limit: LIFTS, SLIPS or TIPS.
        worst, first: places of the worst time and of the first one.
        excess: excess over the limit, comparable between feet.
        text: the worst value.
    """

    contacts: tuple[Contact, ...]
    limit: str
    worst: int
    first: int
    excess: float
    text: str


def contact_notices(state: Equilibrium, free: np.ndarray) -> Iterator[Notice]:
    """Notices on feet whose force at rest is tensile or leaves the friction cone, or whose centre of pressure leaves the sole."""
    feet = [(contact, contact.at_rest(state.multipliers)) for contact in _contacts(state.balance)]
    exceeded = _exceeded(state.balance, free, state.multipliers[:, None], feet, CONE_TOLERANCE)
    yield from (Notice(NoticeKind.STATIC_LOAD, text) for text in _sentences(exceeded))


def limit_values(balance: Balance, wrenches: Mapping[str, np.ndarray], sizes: Mapping[str, float], tolerance: float) -> np.ndarray:
    """Excess of feet over their limits beyond a tolerance, positive outside; by foot, the limits in their order."""
    rows = []
    for contact in _contacts(balance):
        name = contact.support.name
        limits = _limits(contact, contact.of(wrenches[name]), tolerance, sizes[name])
        rows += [limit.excess - limit.least for limit in limits]
    return np.array(rows).reshape(len(rows), -1)


def moving_contact_notices(
    balance: Balance,
    free: np.ndarray,
    multipliers: np.ndarray,
    times: np.ndarray,
    wrenches: Mapping[str, np.ndarray],
    error: float,
) -> Iterator[Notice]:
    """Notices on feet during a small motion, with the times of the worst value and of the first, except feet that exceed their
    limits at rest.
    """
    rest, motion = slice(0, 1), slice(1, None)
    feet = [(contact, contact.of(wrenches[contact.support.name])) for contact in _contacts(balance)]
    at_rest = _exceeded(balance, free, multipliers[:, rest], [(foot, w[:, rest]) for foot, w in feet], CONE_TOLERANCE)
    wrong = {contact for one in at_rest for contact in one.contacts}
    moving = [(foot, w[:, motion]) for foot, w in feet if foot not in wrong]
    for text in _sentences(_exceeded(balance, free, multipliers[:, motion], moving, max(error, CONE_TOLERANCE)), times):
        yield Notice(NoticeKind.LARGE_MOTION, f"{text}; the equations keep feet in place")


def _contacts(balance: Balance) -> Iterator[Contact]:
    start = 0
    for item, G in zip(balance.load.loops, balance.gradients):
        places, start = slice(start, start + len(G)), start + len(G)
        if item.connection.friction is not None:
            yield _contact(balance, item, places, G.T)
    for item, spring in zip(balance.load.springs, balance.elastic):
        if isinstance(item.connection, Support) and item.connection.friction is not None:
            yield _contact(balance, item, None, spring.wrench[:, None])


def _contact(balance: Balance, item: Attached, places: slice | None, wrench: np.ndarray) -> Contact:
    """The contact of a wrench on body2 in the frame on body1."""
    frame = balance.kinematics.frame(item.first)[0]
    on_foot = item.connection.on_foot(wrench)
    return Contact(item.connection, places, np.vstack([frame @ on_foot[:3], on_foot[3:]]), frame)


def _exceeded(
    balance: Balance,
    free: np.ndarray,
    multipliers: np.ndarray,
    feet: Sequence[tuple[Contact, np.ndarray]],
    tolerance: float,
) -> list[Exceeded]:
    """Feet that exceed their limits; where the load sharing of loops is undetermined, only if every share exceeds them."""
    J = balance.scaled_jacobian[:, free].T
    is_open = rows_of(J.T).rank < len(multipliers)
    exceeded, together = [], []
    for contact, wrench in feet:
        limits = _limits(contact, wrench, tolerance)
        if is_open and contact.places is not None:
            together.append((contact, limits))
        else:
            exceeded += _outside(contact, limits)
    outside = np.any([limit.outside for _, limits in together for limit in limits], axis=0)
    places = np.flatnonzero(outside).tolist() if together else []
    if len(places) > MOST_TRIED:  # with the first and the worst of each limit
        ends = [int(np.where(one.outside, one.excess, -np.inf).argmax()) for _, own in together for one in own if one.outside.any()]
        places = sorted({places[0], *ends, *places[:: len(places) // MOST_TRIED]})
    return exceeded + _of_every_share(balance, J, multipliers, tuple(contact for contact, _ in together), places, tolerance)


def _outside(contact: Contact, limits: Sequence[Limit]) -> Iterator[Exceeded]:
    """Events in which a foot lifts off, or before that slips, or tips over: either may be first, and both may occur."""
    before = len(limits[0].excess)
    for limit in limits:
        outside = limit.outside & (np.arange(len(limit.outside)) < before)
        if outside.any():
            worst, first = int(np.where(outside, limit.excess, -np.inf).argmax()), int(outside.argmax())
            yield Exceeded((contact,), limit.name, worst, first, float(limit.excess[worst]), limit.text(worst))
            before = first if limit.name == LIFTS else before


@dataclass(frozen=True, eq=False)
class Limit:
    """Excess of a foot over a limit as a function of time, with the threshold and a sentence on the value at an index."""

    name: str
    excess: np.ndarray
    least: float
    text: Callable[[int], str]

    @property
    def outside(self) -> np.ndarray:
        """Which times exceed the limit, shape (T,)."""
        return self.excess > self.least


def _limits(contact: Contact, wrench: np.ndarray, tolerance: float, size: float | None = None) -> list[Limit]:
    """Tensile normal force (N), tangential force beyond friction (N), position of the centre of pressure relative to the sole.

    The tolerance is relative to the size, by default the largest force.
    """
    foot, force = contact.support, wrench[:3]
    along, across = foot.parts(force)
    least = float(np.linalg.norm(force, axis=0).max() if size is None else size) * tolerance
    excess, pressed = across - foot.friction * np.maximum(along, 0.0), along > least
    arms = np.where(pressed, np.abs(wrench[[4, 3]]) / np.where(pressed, along, 1.0), 0.0)
    halves = np.array(foot.patch if foot.patch is not None else (np.inf, np.inf)) / 2
    shares = arms / halves[:, None]

    def friction(place: int) -> str:
        needed = f", a coefficient of friction of {across[place] / along[place]:.3g}" if pressed[place] else ""
        sizes = f"{across[place]:.4g} N along the ground at a normal force of {along[place]:.4g} N"
        return f"it needs {sizes}{needed}; found {foot.friction:g}"

    def pressure(place: int) -> str:
        axis = int(shares[:, place].argmax())
        at = f"{arms[axis, place]:.3g} m along {'xy'[axis]} from its point"
        return f"the centre of pressure would be {at}, and the sole ends at {halves[axis]:.3g} m"

    return [
        Limit(LIFTS, -along, least, lambda place: f"the ground would have to pull by {-along[place]:.4g} N"),
        Limit(SLIPS, excess, least, friction),
        Limit(TIPS, shares.max(axis=0), 1 + tolerance, pressure),
    ]


def _sentences(exceeded: Sequence[Exceeded], times: np.ndarray | None = None) -> Iterator[str]:
    """One sentence for each limit: the foot with the largest excess, and the number of others; with times in s for a motion."""
    for limit in (LIFTS, SLIPS, TIPS):
        outside = [one for one in exceeded if one.limit == limit]
        if not outside:
            continue
        worst, first = max(outside, key=lambda one: one.excess), min(one.first for one in outside)
        since = f", first at {times[first]:.4g} s" if times is not None and first < worst.worst else ""
        label = worst.contacts[0].support.label
        if len(worst.contacts) > 1:
            what = f"whatever share of the load they take, feet {PLURALS[limit]}{since}"
        elif len(outside) > 1:
            what = f"{len(outside)} feet {PLURALS[limit]}{since}; most of all {label}"
        else:
            what = f"{label}: the foot {limit}{since}"
        when = "" if times is None else f"at t = {times[worst.worst]:.4g} s "
        yield f"{what}: {when}{worst.text}"


#: The least excess with every share, as text by limit.
_LACKING = {
    LIFTS: "the ground would have to pull at one of them by {:.4g} N at least",
    SLIPS: "one of them lacks {:.4g} N of friction at least",
    TIPS: "one of them lacks {:.4g} N m at the edge of its sole at least",
}


def _of_every_share(
    balance: Balance, J: np.ndarray, multipliers: np.ndarray, contacts: tuple[Contact, ...], places: Sequence[int], tolerance: float
) -> list[Exceeded]:
    """Limits that feet exceed for all multipliers with the same load on the free coordinates, J^T lambda = force.

    A linear program for each limit: least z >= 0 with rows @ lambda + z >= 0, those of the limits before it that are kept without z. None
    is of use after one in which feet lift off.
    """
    if not len(places):
        return []
    from scipy.optimize import linprog

    count, lengths = len(multipliers), balance.load.row_lengths
    rows = [contact.rows() for contact in contacts]
    kept = {
        limit: np.vstack([own[limit] @ np.eye(count)[contact.places] / lengths for own, contact in zip(rows, contacts)])
        for limit in (LIFTS, SLIPS, TIPS)
    }
    least, lacking = np.append(np.zeros(count), 1.0), {}
    for place in places:
        force = J @ (multipliers[:, place] * lengths)
        size = np.abs(force).max(initial=0.0) or 1.0
        hard = np.zeros((0, count + 1))
        for limit, own in kept.items():
            slack = np.vstack([hard, np.column_stack([-own, -np.ones(len(own))])])
            bounds = [(None, None)] * count + [(0, None)]
            answer = linprog(least, slack, np.zeros(len(slack)), np.column_stack([J, np.zeros(len(J))]), force / size, bounds)
            if answer.status == 0 and answer.fun > tolerance:
                lacking.setdefault(limit, {})[int(place)] = answer.fun * size
                if limit == LIFTS:
                    break
                continue
            hard = np.vstack([hard, np.column_stack([-own, np.zeros(len(own))])])
    return [
        Exceeded(contacts, limit, worst, min(own), own[worst], _LACKING[limit].format(own[worst]))
        for limit, own in lacking.items()
        for worst in [max(own, key=own.__getitem__)]
    ]
