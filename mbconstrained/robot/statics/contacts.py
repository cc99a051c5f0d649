"""What feet on the ground can carry at rest: forces within friction cones, centres of pressure within soles.

Where statics leaves open how feet share the load, it is only reported that a foot slips if no share keeps all of them in place.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ...ground.coordinate_units import GROUND
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import CONE_TOLERANCE
from ..connections import Support
from ..mechanism import Attached
from .balance import Balance
from .equilibrium import Equilibrium

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
    contacts = list(_contacts(state))
    rigid = [contact for contact in contacts if contact.places is not None]
    wrong = [notice for contact in rigid for notice in _outside(contact, contact.wrench @ state.multipliers[contact.places])]
    if wrong and not _another_share(state, free, rigid):
        yield from wrong
    for contact in contacts:
        if contact.places is None:
            yield from _outside(contact, contact.wrench[:, 0])


def _contacts(state: Equilibrium) -> Iterator[Contact]:
    balance, start = state.balance, 0
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


def _outside(contact: Contact, wrench: np.ndarray) -> Iterator[Notice]:
    foot, force = contact.support, wrench[:3]
    along = float(force @ contact.normal)
    across = float(np.linalg.norm(force - along * contact.normal))
    largest = np.linalg.norm(force) * CONE_TOLERANCE
    if along < -largest:
        yield _notice(f"{foot.label}: the ground would have to pull by {-along:.4g} N; the foot lifts off")
    elif across > foot.friction * max(along, 0.0) + largest:
        text = f"{foot.label}: the foot slips: it needs {across:.4g} N along the ground with {along:.4g} N across it"
        needed = f", a coefficient of friction of {across / along:.3g}" if along > largest else ""
        yield _notice(f"{text}{needed}; found {foot.friction:g}")
    elif foot.patch is not None and along > largest:
        for axis, extent, moment in zip("xy", foot.patch, (wrench[4], wrench[3])):
            if abs(moment) > (1 + CONE_TOLERANCE) * along * extent / 2:
                place = f"{abs(moment) / along:.3g} m along {axis} from its point, and the sole ends at {extent / 2:.3g} m"
                yield _notice(f"{foot.label}: the foot tips over: the centre of pressure would be {place}")


def _notice(text: str) -> Notice:
    return Notice(NoticeKind.STATIC_LOAD, text)


def _another_share(state: Equilibrium, free: np.ndarray, contacts: list[Contact]) -> bool:
    """Whether other multipliers balance the free coordinates with all feet in place, a linear program."""
    balance, count = state.balance, len(state.multipliers)
    if state.rows.rank == count:
        return False
    from scipy.optimize import linprog

    lengths, scale = balance.load.lengths[free], 1 / balance.load.row_lengths
    J = (balance.scaled_jacobian[:, free]).T
    force = balance.force[free] * lengths
    size = np.abs(force).max(initial=0.0) or 1.0
    kept = np.vstack([contact.rows() @ np.eye(count)[contact.places] * scale for contact in contacts])
    answer = linprog(np.zeros(count), -kept, np.zeros(len(kept)), J, force / size, bounds=(None, None))
    return bool(answer.status == 0)
