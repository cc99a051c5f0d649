"""Comparison of masses, forces, stiffness, damping and loops of a robot from an MJCF file with those of MuJoCo at a posture."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence

import numpy as np

from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import (
    DIFFERENCED,
    EPS,
    LOOPS_CLOSED_AS_ROUNDED,
    MUJOCO_RATE,
    MUJOCO_STEP,
    NOISE_SAFETY,
    SAME_AS_MUJOCO,
)
from ..posture import Posture
from ..posture_search import attached_load
from ..robot_model import RobotModel
from ..statics.balance import Balance
from .mjcf import MOST_NAMED, quaternion_places, quiet, read_mjcf


def compared_with_mujoco(robot: RobotModel, posture: Posture) -> tuple[Notice, ...]:
    """Compare the robot of the file, without additions, with MuJoCo at the joint values of a posture."""
    source = read_mjcf(robot.source.path, False, robot.package_dirs)
    if source.compiled is None or not source.model.nv:
        return ()
    bare = type(robot)(source)
    values = {**posture.joints, **robot.locked}
    q = bare.tangent.configuration({name: values[name] for name in bare.joints if name in values})
    ours = Balance(bare.tree, attached_load(bare, q, {}), q)
    twin = _Twin(bare, q)
    scale = EPS * max(float(np.abs(part).max(initial=0.0)) for part in ours.forces)
    own_stiffness = np.sum(ours.stiffnesses, axis=0) + np.diag(bare.position_gains)
    branches = bare.tree.moves_axis | bare.tree.moves_axis.T  # elsewhere MuJoCo has no masses, also not of tendons
    dampers = [*(item.damping for item in ours.elastic), *(item.damping for item in ours.tendons)]
    for what, own, other, tolerance, noise in (
        ("mass", ours.mass * branches, twin.mass() * branches, SAME_AS_MUJOCO, 0.0),
        ("force", ours.force[:, None], twin.force(q)[:, None], SAME_AS_MUJOCO, scale + EPS * np.abs(own_stiffness).max()),
        ("stiffness", own_stiffness, twin.stiffness(), DIFFERENCED, scale / MUJOCO_STEP),
        (
            "damping",
            np.diag(bare.joint_damping) + sum(dampers, 0.0 * ours.mass),
            twin.damping(),
            DIFFERENCED,
            scale / MUJOCO_RATE,
        ),
    ):
        _agree(what, own, other, bare.coordinates, tolerance, NOISE_SAFETY * noise)
    twin.compare_loops(ours)
    return twin.contacts()


def _agree(what: str, ours: np.ndarray, theirs: np.ndarray, names: Sequence[str], tolerance: float, noise: float) -> None:
    """Raise an error where an entry differs by more than the tolerance times the scale of its row and column."""
    size = np.maximum(np.abs(ours), np.abs(theirs))
    excess = np.abs(ours - theirs) - tolerance * np.sqrt(np.outer(size.max(axis=1), size.max(axis=0))) - noise
    if excess.max(initial=0.0) > 0:
        i, j = np.unravel_index(excess.argmax(), excess.shape)
        of = f'"{names[i]}"' + (f' by "{names[j]}"' if i != j and len(ours) == len(ours.T) else "")
        raise InputError(f"mjcf: the {what} of {of} is {ours[i, j]:.9g} here and {theirs[i, j]:.9g} in MuJoCo{_ADVICE}")


_ADVICE = ": something in the file is not read as MuJoCo reads it; please report it with the file"


class _Twin:
    """The compiled model in the coordinates of a robot, without contacts, limits, dry friction and clamped forces."""

    def __init__(self, robot: RobotModel, q: np.ndarray):
        import mujoco

        self.robot, self.q, self._mujoco = robot, q, mujoco
        self.model = copy.copy(robot.source.compiled)
        flags, self._touching = mujoco.mjtDisableBit, int(self.model.opt.disableflags)
        self.model.opt.disableflags |= int(flags.mjDSBL_CONTACT | flags.mjDSBL_LIMIT | flags.mjDSBL_FRICTIONLOSS)
        self.model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
        for name in ("actuator_forcelimited", "jnt_actfrclimited", "tendon_actfrclimited"):
            getattr(self.model, name, np.zeros(0))[:] = 0
        self.data = mujoco.MjData(self.model)
        self._places = quaternion_places(self.model)
        self._move(q)
        self.model.actuator_biasprm[:, 0] -= np.array(self.data.actuator_force)[: len(self.model.actuator_biasprm)]  # none at rest

    def _move(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        """Set configuration and rates, and compute all forces.

        Returns the map from the rates of the robot to those of MuJoCo, whose free joints move along the axes of the ground.
        """
        import pinocchio

        qpos, rates = np.empty(self.model.nq), np.eye(self.model.nv)
        qpos[self._places] = q
        for joint in list(self.robot.model.joints)[1:]:
            if joint.nv == 6:
                turn = pinocchio.Quaternion(q[joint.idx_q + 3 : joint.idx_q + 7]).toRotationMatrix()
                rates[joint.idx_v : joint.idx_v + 3, joint.idx_v : joint.idx_v + 3] = turn
        self.data.qpos[:], self.data.qvel[:] = qpos, 0.0 if v is None else rates @ v
        with quiet():
            for stage in (self._mujoco.mj_fwdPosition, self._mujoco.mj_fwdVelocity, self._mujoco.mj_fwdActuation):
                stage(self.model, self.data)
        return rates

    def mass(self) -> np.ndarray:
        """M, shape (nv, nv)."""
        rates, M = self._move(self.q), np.zeros((self.model.nv, self.model.nv))
        for column, unit in zip(M, np.eye(self.model.nv)):
            self._mujoco.mj_mulM(self.model, self.data, column, unit)
        return rates.T @ M @ rates

    def force(self, q: np.ndarray, v: np.ndarray | None = None) -> np.ndarray:
        """The forces on the left of the equations, shape (nv,)."""
        return self._move(q, v).T @ (self.data.qfrc_bias - self.data.qfrc_passive - self.data.qfrc_actuator)

    def stiffness(self) -> np.ndarray:
        """K, shape (nv, nv)."""
        return self._differenced(lambda step: self.force(self.robot.tree.moved(self.q, step)), MUJOCO_STEP)

    def damping(self) -> np.ndarray:
        """C, shape (nv, nv); the part c v |v| of polynomials is odd, its slope of first order in the step."""
        coarse, fine = (self._differenced(lambda rate: self.force(self.q, rate), step) for step in (MUJOCO_RATE, MUJOCO_RATE / 2))
        return 2 * fine - coarse

    def _differenced(self, force: Callable[[np.ndarray], np.ndarray], h: float) -> np.ndarray:
        """The derivative by central differences of fourth order, column by column."""
        units = np.eye(self.model.nv) * h
        columns = [(8 * (force(u) - force(-u)) - (force(2 * u) - force(-2 * u))) / (12 * h) for u in units]
        return np.array(columns).T

    def compare_loops(self, ours: Balance) -> None:
        """Raise an error where the equality rows of MuJoCo and the loops of the robot span different spaces, or are open."""
        rates, lengths = self._move(self.q), ours.load.lengths
        theirs = self.data.efc_J.reshape(-1, self.model.nv)[: self.data.ne] @ rates * lengths
        for what, rows, others in (("here", theirs, ours.scaled_jacobian), ("in MuJoCo", ours.scaled_jacobian, theirs)):
            left = rows - rows @ np.linalg.pinv(others, rcond=EPS * max(1, len(others))) @ others if len(others) else rows
            if np.abs(left).max(initial=0.0) > DIFFERENCED * max(np.abs(rows).max(initial=0.0), DIFFERENCED * ours.load.size):
                name = self.robot.coordinates[int(np.unravel_index(np.abs(left).argmax(), left.shape)[1])]
                raise InputError(f'mjcf: equalities leave another motion of "{name}" {what}{_ADVICE}')
        gap, own = np.abs(self.data.efc_pos[: self.data.ne]).max(initial=0.0), np.abs(ours.gaps).max(initial=0.0)
        if gap > 10 * own + LOOPS_CLOSED_AS_ROUNDED * max(1.0, ours.load.size):
            raise InputError(f"mjcf: equalities are open by {gap:.3g} in MuJoCo and by {own:.3g} (m, rad) here{_ADVICE}")

    def contacts(self) -> tuple[Notice, ...]:
        """A note on contacts between bodies, which the equations do not contain."""
        self.model.opt.disableflags = self._touching
        self._move(self.q)
        links, geoms = self.robot.source.links, self.model.geom_bodyid
        touching = (contact.geom for contact in self.data.contact[: self.data.ncon] if contact.dist < 0)
        pairs = dict.fromkeys(" and ".join(links[geoms[geom]] for geom in pair) for pair in touching if min(pair) >= 0)
        if not pairs:
            return ()
        more = f" and {len(pairs) - MOST_NAMED} more pairs" if len(pairs) > MOST_NAMED else ""
        text = f"contacts are not in the equations: at the posture {', '.join(list(pairs)[:MOST_NAMED])}{more} touch; give feet as loops or bushings"
        return (Notice(NoticeKind.OMITTED, f"mjcf: {text}"),)
