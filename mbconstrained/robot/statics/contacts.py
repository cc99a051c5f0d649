"""What feet on the ground can carry at rest and in motion: forces within friction cones, centres of pressure within soles.

Where statics leaves open how feet share the load, it is only reported that a foot slips if no share keeps all of them in place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...ground.coordinate_units import GROUND
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import CONE_TOLERANCE
from ..connections import Support
from ..mechanism import Attached
from .balance import Balance
from .equilibrium import Equilibrium, rows_of

#: Sides of the pyramid inside a friction cone.
SIDES = 16


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
        """The same from a wrench on body2 in the directions of the ground, both of shape (6, T)."""
        on_foot = wrench if self.support.body1 == GROUND else -wrench
        return np.vstack([on_foot[:3], self.frame.T @ on_foot[3:]])

    @property
    def normal(self) -> np.ndarray:
        """The unit normal on the foot, in the directions of the ground."""
        return np.array(self.support.normal) / np.linalg.norm(self.support.normal)

    def rows(self) -> np.ndarray:
        """What may not be negative, for units of the multipliers: the pyramid inside the cone, and the edges of the sole."""
        across = np.linalg.svd(self.normal[None])[2][1:]
        angles = np.arange(SIDES) * 2 * np.pi / SIDES
        sides = np.column_stack([np.cos(angles), np.sin(angles)]) @ across
        friction = (self.support.friction or 0.0) * np.cos(np.pi / SIDES)
        force, rows = self.wrench[:3], [(friction * self.normal - sides) @ self.wrench[:3], (self.normal @ self.wrench[:3])[None]]
        if self.support.patch is not None:
            # the centre of pressure is at (-T_y, T_x) / F_z of the frame, whose z is along the normal or against it
            down = self.frame[:, 2] @ self.normal < 0
            for extent, moment in zip(self.support.patch, (self.wrench[4], self.wrench[3])):
                half = extent / 2 * (self.normal @ force)
                rows += (
                    [(half + moment)[None], (half - moment)[None]] if not down else [(half - moment)[None], (half + moment)[None]]
                )
        return np.vstack(rows)


def contact_notices(state: Equilibrium, free: np.ndarray) -> Iterator[Notice]:
    """Notices on feet whose force at rest pulls or leaves the friction cone, or whose centre of pressure leaves the sole.

    Args:
        state: of the robot at rest.
        free: which coordinates are not kept in place, shape (nv,).

    Yields:
        One for each foot; none where another share of the load keeps all feet in place.
    """
    feet = [(contact, contact.at_rest(state.multipliers)) for contact in _contacts(state.balance)]
    exceeded = _exceeded(state.balance, free, state.multipliers[:, None], feet, np.zeros(1), CONE_TOLERANCE)
    yield from (Notice(NoticeKind.STATIC_LOAD, text) for _, text in exceeded)


def moving_contact_notices(
    balance: Balance,
    free: np.ndarray,
    multipliers: np.ndarray,
    times: np.ndarray,
    wrenches: Mapping[str, np.ndarray],
    error: float,
) -> Iterator[Notice]:
    """The same of feet during a small motion, each with the time of the worst value; feet that leave their limits at rest are left out.

    Args:
        balance: at rest.
        free: which coordinates are not kept in place at rest, shape (nv,).
        multipliers: of all rows, at rest, then during the motion, shape (m, 1 + T).
        times: shape (T,), in s.
        wrenches: by name of a foot the force and torque on body2 in the directions of the ground, at rest, then during the
            motion, shape (6, 1 + T).
        error: of the forces, relative to the largest.

    Yields:
        At most one for each foot and each limit.
    """
    rest, motion = slice(0, 1), slice(1, None)
    feet = [(contact, contact.of(wrenches[contact.support.name])) for contact in _contacts(balance)]
    at_rest = _exceeded(balance, free, multipliers[:, rest], [(foot, w[:, rest]) for foot, w in feet], np.zeros(1), CONE_TOLERANCE)
    wrong = {foot for foot, _ in at_rest}
    moving = [(foot, w[:, motion]) for foot, w in feet if foot not in wrong]
    for _, text in _exceeded(balance, free, multipliers[:, motion], moving, times, max(error, CONE_TOLERANCE)):
        yield Notice(NoticeKind.LARGE_MOTION, f"{text}; the equations keep it in place")


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
    """From the wrench on body2 in the frame on body1."""
    frame = balance.kinematics.frame(item.first)[0]
    on_foot = wrench * (1.0 if item.connection.body1 == GROUND else -1.0)
    return Contact(item.connection, places, np.vstack([frame @ on_foot[:3], on_foot[3:]]), frame)


def _exceeded(
    balance: Balance,
    free: np.ndarray,
    multipliers: np.ndarray,
    feet: Sequence[tuple[Contact, np.ndarray]],
    times: np.ndarray,
    tolerance: float,
) -> list[tuple[Contact, str]]:
    """Feet outside of their limits, but for those of loops at a time at which another share of the load keeps all of them inside."""
    rigid = [contact for contact, _ in feet if contact.places is not None]
    limits = [(contact, *worst) for contact, wrench in feet for worst in _outside(contact, wrench, times, tolerance)]
    shared = {
        place: _another_share(balance, free, multipliers[:, place], rigid)
        for place in {place for contact, place, _ in limits if contact.places is not None}
    }
    return [(contact, text) for contact, place, text in limits if contact.places is None or not shared[place]]


def _outside(contact: Contact, wrench: np.ndarray, times: np.ndarray, tolerance: float) -> Iterator[tuple[int, str]]:
    """Where a foot pulls, slips before that, or tips over before both: the place of the worst time, and a sentence."""
    foot, force = contact.support, wrench[:3]
    along = contact.normal @ force
    across = np.linalg.norm(force - np.outer(contact.normal, along), axis=0)
    largest = np.linalg.norm(force, axis=0).max() * tolerance
    left = np.arange(len(along))  # the times before the foot leaves another limit
    worst = int(along.argmin())
    if along[worst] < -largest:
        when, left = _when(times, worst, along < -largest), left[: int(np.argmax(along < -largest))]
        yield worst, f"{foot.label}: the ground would have to pull by {-along[worst]:.4g} N{when}; the foot lifts off"
    excess = across - foot.friction * np.maximum(along, 0.0)
    if len(left) and excess[left].max() > largest:
        worst = int(left[excess[left].argmax()])
        when, left = _when(times, worst, excess > largest), left[: int(np.argmax(excess[left] > largest))]
        sizes = f"{across[worst]:.4g} N along the ground with {along[worst]:.4g} N across it{when}"
        needed = f", a coefficient of friction of {across[worst] / along[worst]:.3g}" if along[worst] > largest else ""
        yield worst, f"{foot.label}: the foot slips: it needs {sizes}{needed}; found {foot.friction:g}"
    left = left[along[left] > largest]
    for axis, extent, moment in zip("xy", foot.patch or (), (wrench[4], wrench[3])):
        arm = np.abs(moment[left]) / along[left]
        if len(left) and arm.max() > (1 + tolerance) * extent / 2:
            worst = int(left[arm.argmax()])
            when = _when(times, worst, np.abs(moment) > (1 + tolerance) * along * extent / 2)
            place = f"{arm.max():.3g} m along {axis} from its point{when}, and the sole ends at {extent / 2:.3g} m"
            yield worst, f"{foot.label}: the foot tips over: the centre of pressure would be {place}"


def _when(times: np.ndarray, worst: int, outside: np.ndarray) -> str:
    """Nothing at rest, a single time."""
    if len(times) == 1:
        return ""
    first = int(np.argmax(outside))
    since = f", and first at {times[first]:.4g} s" if first < worst else ""
    return f" at t = {times[worst]:.4g} s{since}"


def _another_share(balance: Balance, free: np.ndarray, multipliers: np.ndarray, contacts: list[Contact]) -> bool:
    """Whether other multipliers load the free coordinates alike with all feet in place, a linear program."""
    count = len(multipliers)
    J = balance.scaled_jacobian[:, free].T
    if rows_of(J.T).rank == count:
        return False
    from scipy.optimize import linprog

    scale = 1 / balance.load.row_lengths
    force = J @ (multipliers * balance.load.row_lengths)
    size = np.abs(force).max(initial=0.0) or 1.0
    kept = np.vstack([contact.rows() @ np.eye(count)[contact.places] * scale for contact in contacts])
    answer = linprog(np.zeros(count), -kept, np.zeros(len(kept)), J, force / size, bounds=(None, None))
    return bool(answer.status == 0)
