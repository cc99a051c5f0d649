"""Random mechanisms as SDF and as URDF files, with their M and K from products of exponentials: no file is read for these."""

from dataclasses import dataclass, field

import numpy as np
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

#: Coordinates of each kind of joint: suffix of the name, whether it slides.
COORDINATES = {
    "revolute": [("", False)],
    "prismatic": [("", True)],
    "universal": [(" axis", False), (" axis2", False)],
    "screw": [("", False), (" slide", True)],
    "ball": [(" rx", False), (" ry", False), (" rz", False)],
    "floating": [(f" {axis}", True) for axis in "xyz"] + [(f" r{axis}", False) for axis in "xyz"],
    "planar": [(" x", True), (" y", True), (" rz", False)],
    "fixed": [],
}


@dataclass
class Body:
    name: str
    X: np.ndarray
    mass: float
    centre: np.ndarray
    moments: np.ndarray


@dataclass
class Joint:
    name: str
    kind: str
    parent: int
    child: int
    X: np.ndarray
    axes: list = field(default_factory=list)
    damping: float = 0.0
    stiffness: float = 0.0
    rest: float = 0.0
    pitch: float = 0.0
    armature: float = 0.0
    mimic: tuple | None = None


def cross(v):
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0.0]])


def inverse(X):
    result = np.eye(4)
    result[:3, :3], result[:3, 3] = X[:3, :3].T, -X[:3, :3].T @ X[:3, 3]
    return result


def random_pose(rng, size=0.5):
    X = np.eye(4)
    X[:3, :3], X[:3, 3] = Rotation.random(random_state=rng).as_matrix(), rng.uniform(-size, size, 3)
    if rng.random() < 0.3:
        X[:3, :3] = Rotation.from_euler("xyz", rng.integers(-2, 3, 3) * [np.pi / 2, 0, np.pi / 2]).as_matrix()
    if rng.random() < 0.1:
        X = np.eye(4)
    return X


class Mechanism:
    """Bodies, joints of a tree, and joints that close loops where all are at 0."""

    def __init__(self, rng, kinds, loops=0):
        self._draw(rng, kinds, loops)
        while not self.moves:
            self._draw(rng, kinds, loops)

    def _draw(self, rng, kinds, loops):
        count = int(rng.integers(2, 7))
        self.bodies, self.joints, self.loops = [], [], []
        for number in range(count):
            moments = rng.uniform(0.01, 0.02, 3)
            self.bodies.append(Body(f"b{number}", random_pose(rng), rng.uniform(0.5, 2), random_pose(rng, 0.2), moments))
        for number in range(count):
            parent = int(rng.integers(-1 if number == 0 or rng.random() < 0.2 else 0, max(number, 1))) if number else -1
            kind = str(rng.choice(kinds))
            self.joints.append(self._joint(rng, f"j{number}", kind, parent, number))
        if all(joint.kind == "fixed" for joint in self.joints):
            self.joints[-1] = self._joint(rng, self.joints[-1].name, "revolute", self.joints[-1].parent, count - 1)
        while len(self.loops) < loops:
            first, second = sorted(rng.choice(range(-1, count), 2, replace=False))
            kind = str(rng.choice(["revolute", "prismatic", "ball", "universal"]))
            joint = self._joint(rng, f"loop{len(self.loops)}", kind, int(first), int(second))
            joint.stiffness = joint.damping = joint.rest = 0.0
            self.loops.append(joint)
        for joint in self.joints if loops else ():
            joint.rest = 0.0
        self.gravity = np.zeros(3) if loops else np.array([0, 0, -9.81])

    @staticmethod
    def _joint(rng, name, kind, parent, child):
        axes = []
        if kind in ("revolute", "prismatic", "screw", "universal"):
            axes = [Rotation.random(random_state=rng).apply([0, 0, 1.0])]
            if rng.random() < 0.4:
                axes = [np.eye(3)[rng.integers(3)] * rng.choice([-1.0, 1.0])]
        if kind == "universal":
            other = np.cross(axes[0], rng.standard_normal(3))
            axes.append(other / np.linalg.norm(other))
        joint = Joint(name, kind, parent, child, random_pose(rng), axes)
        if kind in ("revolute", "prismatic", "screw"):
            joint.damping, joint.stiffness, joint.rest = (
                rng.uniform(0, 2),
                rng.uniform(1, 50) * (rng.random() < 0.7),
                rng.uniform(-1, 1),
            )
        joint.pitch = rng.uniform(-0.3, 0.3) if kind == "screw" else 0.0
        return joint

    @property
    def moves(self):
        """Whether the loops leave a motion where all joints are at 0."""
        rows = self.rows(np.zeros(len(self.coordinates)))
        return len(self.coordinates) > (np.linalg.matrix_rank(rows) if len(rows) else 0)

    @property
    def coordinates(self):
        return [f"{joint.name}{suffix}" for joint in self.joints for suffix, _ in COORDINATES[joint.kind]]

    def twists(self, joint):
        """The twists (v; w) of a joint where all are at 0, in the directions of the ground."""
        R, p = joint.X[:3, :3], joint.X[:3, 3]
        directions = joint.axes * 2 if joint.kind == "screw" else joint.axes
        if joint.kind in ("ball", "floating"):
            directions = [*np.eye(3)] * (2 if joint.kind == "floating" else 1)
        if joint.kind == "planar":
            directions = np.eye(3)
        result = []
        for direction, (_, slides) in zip(directions, COORDINATES[joint.kind]):
            a = R @ direction
            result.append(np.concatenate([a, np.zeros(3)]) if slides else np.concatenate([np.cross(p, a), a]))
        return result

    def poses(self, q):
        """Displacement (4, 4) of each body from its place at 0, and its columns (6, n)."""
        displaced, columns, place = {-1: np.eye(4)}, {-1: np.zeros((6, len(q)))}, 0
        for joint in self.joints:  # a parent comes before its children
            G, own = displaced[joint.parent], columns[joint.parent].copy()
            for twist in self.twists(joint):
                R, p = G[:3, :3], G[:3, 3]
                w = R @ twist[3:]
                own[:, place] = np.concatenate([R @ twist[:3] + np.cross(p, w), w])
                matrix = np.zeros((4, 4))
                matrix[:3, :3], matrix[:3, 3] = cross(twist[3:]), twist[:3]
                G = G @ expm(matrix * q[place])
                place += 1
            displaced[joint.child], columns[joint.child] = G, own
        return displaced, columns

    def mass(self, q):
        displaced, columns = self.poses(q)
        M = np.zeros((len(q),) * 2)
        for number, body in enumerate(self.bodies):
            X = displaced[number] @ body.X @ body.centre
            S = columns[number]
            v = S[:3] - np.cross(X[:3, 3], S[3:], axisb=0, axisc=0) if len(q) else S[:3]
            w = X[:3, :3].T @ S[3:]
            M += body.mass * v.T @ v + w.T @ (body.moments[:, None] * w)
        return M + np.diag([joint.armature for joint in self.joints for _ in COORDINATES[joint.kind]])

    def forces(self, q):
        """Weights and springs, on the left of the equations."""
        displaced, columns = self.poses(q)
        g = np.zeros(len(q))
        for number, body in enumerate(self.bodies):
            centre = (displaced[number] @ body.X @ body.centre)[:3, 3]
            S = columns[number]
            g -= body.mass * self.gravity @ (S[:3] + np.cross(S[3:], centre, axisa=0, axisc=0))
        return g + self.springs * (q - self.rests)

    def _by_coordinate(self, key):
        values = []
        for joint in self.joints:
            own = len(COORDINATES[joint.kind])
            values += [getattr(joint, key) if not place else 0.0 for place in range(own)]
        return np.array(values)

    springs = property(lambda self: self._by_coordinate("stiffness"))
    rests = property(lambda self: self._by_coordinate("rest"))
    dampers = property(lambda self: self._by_coordinate("damping"))

    def stiffness(self, q, step=1e-5):
        return np.array([(self.forces(q + d) - self.forces(q - d)) / (2 * step) for d in np.eye(len(q)) * step]).T

    def rows(self, q):
        """The constraint rows of loops and screws where all joints are at 0."""
        _, columns = self.poses(q)
        rows = []
        for loop in self.loops:
            relative = columns[loop.child] - columns[loop.parent]
            R, p = loop.X[:3, :3], loop.X[:3, 3]
            v, w = R.T @ (relative[:3] + np.cross(relative[3:], p, axisa=0, axisc=0)), R.T @ relative[3:]
            across = np.linalg.svd(np.array(loop.axes[:1] or [[0, 0, 1.0]]))[2][1:]
            if loop.kind == "universal":
                rows += [*v, np.cross(loop.axes[0], loop.axes[1]) @ w]
            elif loop.kind == "prismatic":
                rows += [*(across @ v), *w]
            else:
                rows += [*v, *(across @ w if loop.kind == "revolute" else [])]
        names = self.coordinates
        for joint in self.joints:
            if joint.kind == "screw":
                row = np.zeros(len(names))
                row[names.index(f"{joint.name} slide")], row[names.index(joint.name)] = 1.0, -joint.pitch
                rows.append(row)
            if joint.mimic is not None:
                row = np.zeros(len(names))
                row[names.index(joint.name)], row[names.index(joint.mimic[0])] = 1.0, -joint.mimic[1]
                rows.append(row)
        return np.array(rows).reshape(-1, len(names))


def angles(X):
    """Roll, pitch, yaw, also where they are not unique."""
    R = X[:3, :3]
    pitch = np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0]))
    yaw = np.arctan2(R[1, 0], R[0, 0])
    c, s = np.cos(yaw), np.sin(yaw)
    return np.array([np.arctan2(s * R[0, 2] - c * R[1, 2], c * R[1, 1] - s * R[0, 1]), pitch, yaw])


def numbers_of(values):
    return " ".join(repr(float(value)) for value in np.ravel(values))


def origin(X):
    return f'<origin xyz="{numbers_of(X[:3, 3])}" rpy="{numbers_of(angles(X))}"/>'


class SdfWriter:
    """The mechanism as an SDF, each pose relative to a random frame, in a random notation.

    Old versions (1.4, 1.5) have poses without frames, and axes in the frame of the model.
    """

    def __init__(self, mechanism, rng, folder=None):
        self.mechanism, self.rng, self.folder = mechanism, rng, folder
        self.version = str(rng.choice(["1.4", "1.5", "1.7", "1.9", "1.10"]))
        self.old = self.version in ("1.4", "1.5")
        self.model = random_pose(rng)
        self.frames = {"__model__": self.model}
        self.nested = {}

    def pose(self, X, usual=None, attributes=""):
        """<pose> of a frame at X; usual is the placement of the frame it is relative to where none is named."""
        rng, base = self.rng, usual
        if not self.old and (usual is None or rng.random() < 0.5):
            name = str(rng.choice(list(self.frames)))
            base, attributes = self.frames[name], f' relative_to="{name}"'
        local = inverse(base) @ X
        rotation, xyz = Rotation.from_matrix(local[:3, :3]), numbers_of(local[:3, 3])
        form = int(rng.integers(3)) if not self.old and self.version != "1.7" else 0
        if form == 1:
            return (
                f'<pose{attributes} rotation_format="quat_xyzw">{xyz} {numbers_of(rotation.as_quat() * rng.uniform(0.5, 2))}</pose>'
            )
        if form == 2:
            return f'<pose{attributes} degrees="true">{xyz} {numbers_of(np.degrees(angles(local)))}</pose>'
        return f"<pose{attributes}>{xyz} {numbers_of(angles(local))}</pose>"

    def link(self, body, name, usual, alone=False):
        frames, old = self.frames, self.old
        self.old = old or alone  # a link of a nested model knows no frame of the outer one
        pose = self.pose(body.X, usual)
        inner = self.pose(body.centre, np.eye(4)) if self.old else self.plain_pose(body.centre)
        self.frames, self.old = frames, old
        moments = "".join(f"<i{axis * 2}>{value!r}</i{axis * 2}>" for axis, value in zip("xyz", body.moments.tolist()))
        mass = f"<inertial>{inner}<mass>{body.mass!r}</mass><inertia>{moments}</inertia></inertial>"
        return f'<link name="{name}">{pose}{mass}</link>'

    def plain_pose(self, X):
        return f"<pose>{numbers_of(X[:3, 3])} {numbers_of(angles(X))}</pose>"

    def body_name(self, number):
        return "world" if number < 0 else self.nested.get(number, self.mechanism.bodies[number].name)

    def joint(self, joint):
        rng, child = self.rng, self.mechanism.bodies[joint.child]
        parts = [f"<parent>{self.body_name(joint.parent)}</parent><child>{self.body_name(joint.child)}</child>"]
        parts.append(self.pose(joint.X, child.X))
        for tag, direction in zip(("axis", "axis2"), joint.axes):
            own, more, attributes = direction, "", ""
            if self.version == "1.4" or (self.version == "1.5" and rng.random() < 0.5):
                own = self.model[:3, :3].T @ joint.X[:3, :3] @ direction
                more = "<use_parent_model_frame>1</use_parent_model_frame>" if self.version == "1.5" else ""
            elif not self.old and rng.random() < 0.5:
                name = str(rng.choice(list(self.frames)))
                own, attributes = self.frames[name][:3, :3].T @ joint.X[:3, :3] @ direction, f' expressed_in="{name}"'
            springs = f"<spring_stiffness>{joint.stiffness!r}</spring_stiffness><spring_reference>{joint.rest!r}</spring_reference>"
            more += f"<dynamics><damping>{joint.damping!r}</damping>{springs}</dynamics>"
            parts.append(f"<{tag}><xyz{attributes}>{numbers_of(own * rng.uniform(0.5, 3))}</xyz>{more}</{tag}>")
        if joint.kind == "screw":
            turn = 2 * np.pi * joint.pitch
            old = rng.random() < 0.5
            parts.append(
                f"<thread_pitch>{-1 / joint.pitch!r}</thread_pitch>"
                if old
                else f"<screw_thread_pitch>{turn!r}</screw_thread_pitch>"
            )
        kind = "revolute2" if joint.kind == "universal" and joint.name.startswith("j") and rng.random() < 0.5 else joint.kind
        return f'<joint name="{joint.name}" type="{kind}">{"".join(parts)}</joint>'

    def text(self):
        rng, parts = self.rng, []
        for number, body in enumerate(self.mechanism.bodies):
            if self.old or rng.random() < 0.6:
                parts.append(self.link(body, body.name, self.model))
                self.frames[body.name] = body.X
            else:
                parts.append(self.nested_model(number, body))
            if not self.old and rng.random() < 0.4:
                name, X = f"f{number}", random_pose(rng)
                attached = str(rng.choice(list(self.frames)))
                parts.append(f'<frame name="{name}" attached_to="{attached}">{self.pose(X, self.frames[attached])}</frame>')
                self.frames[name] = X
        joints = [*self.mechanism.joints, *self.mechanism.loops]
        joints = [joint for joint in joints if joint.kind != "floating"]
        parts += [self.joint(joint) for joint in rng.permutation(np.array(joints, dtype=object))]
        if not self.old:
            rng.shuffle(parts)
        inner = f'<model name="m">{self.plain_pose(self.model)}{"".join(parts)}</model>'
        return f'<sdf version="{self.version}">{inner}</sdf>'

    def nested_model(self, number, body):
        """A model in the model, or in a file of its own, with a frame of its own in which the pose is given."""
        rng, name, X = self.rng, f"n{number}", random_pose(self.rng)
        self.nested[number] = f"{name}::{body.name}"
        link = self.link(body, body.name, X, alone=True)
        placed, frame, attributes = X, "", ""
        if rng.random() < 0.5:
            placed = random_pose(rng)
            frame = f'<frame name="grip">{self.plain_pose(inverse(X) @ placed)}</frame>'
            attributes = ' placement_frame="grip"'
        pose = self.pose(placed, self.model)
        if self.folder is None or rng.random() < 0.5:
            model = f'<model name="{name}"{attributes}>{pose}{link}{frame}</model>'
        else:
            (self.folder / f"part{number}").mkdir()
            file = f'<sdf version="{self.version}"><model name="part"{attributes}>{self.plain_pose(random_pose(rng))}{link}{frame}</model></sdf>'
            (self.folder / f"part{number}" / "model.sdf").write_text(file)
            uri = str(rng.choice([f"model://part{number}", f"part{number}", f"part{number}/model.sdf", f"file://part{number}"]))
            model = f"<include><uri>{uri}</uri><name>{name}</name>{pose}</include>"
        self.frames[self.nested[number]] = body.X
        return model


class UrdfWriter:
    """The mechanism as a URDF, the frames of its links at their joints, with tags of Drake and Gazebo.

    Principal moments stand in axes that are turned twice, by the tensor and by the origin; mimic joints, rotors and springs of
    Gazebo are drawn here and entered in the mechanism.
    """

    def __init__(self, mechanism, rng, extended=True):
        self.mechanism, self.rng, self.extended = mechanism, rng, extended

    def text(self):
        tree = {joint.child: joint for joint in self.mechanism.joints}
        links = [self.link(body, tree[number]) for number, body in enumerate(self.mechanism.bodies)]
        parts = ['<link name="root"/>', *links, *(self.joint(joint) for joint in self.mechanism.joints)]
        self.rng.shuffle(parts)
        return f'<robot name="m" xmlns:drake="http://drake.mit.edu">{"".join(parts)}</robot>'

    def link(self, body, joint):
        centre, own = inverse(joint.X) @ body.X @ body.centre, np.eye(4)
        own[:3, :3] = Rotation.random(random_state=self.rng).as_matrix()
        R = own[:3, :3].T
        tensor = R @ np.diag(body.moments) @ R.T
        keys = ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        moments = " ".join(f'{key}="{value!r}"' for key, value in zip(keys, tensor[np.triu_indices(3)].tolist()))
        inertial = f'{origin(centre @ own)}<mass value="{body.mass!r}"/><inertia {moments}/>'
        return f'<link name="{body.name}"><inertial>{inertial}</inertial></link>'

    def joint(self, joint):
        rng, bodies = self.rng, self.mechanism.bodies
        above = {other.child: other.X for other in self.mechanism.joints}
        parent = "root" if joint.parent < 0 else bodies[joint.parent].name
        place = inverse(above.get(joint.parent, np.eye(4))) @ joint.X
        parts = [f'{origin(place)}<parent link="{parent}"/><child link="{bodies[joint.child].name}"/>']
        tag = "drake:joint" if joint.kind in ("universal", "ball", "screw") else "joint"
        if joint.kind == "planar" and rng.random() < 0.5:
            tag = "drake:joint"
        elif joint.kind == "planar":
            parts.append('<axis xyz="0 0 1"/>')
        if joint.kind in ("revolute", "prismatic", "screw"):
            parts.append(f'<axis xyz="{numbers_of(joint.axes[0] * rng.uniform(0.5, 3))}"/>')
            parts.append(f'<dynamics damping="{joint.damping!r}"/>')
        if joint.kind == "screw" or not self.extended:
            joint.stiffness = 0.0  # Gazebo's springs of a URDF are those of ordinary joints
        if joint.kind == "screw":
            parts.append(f'<drake:screw_thread_pitch value="{2 * np.pi * joint.pitch!r}"/>')
        kind, more = joint.kind, ""
        if kind == "revolute" and rng.random() < 0.5:
            kind = "continuous"
        elif kind in ("revolute", "prismatic"):
            parts.append('<limit lower="-9" upper="9" effort="1" velocity="1"/>')
        if self.extended and joint.kind in ("revolute", "prismatic"):
            more = self.extensions(joint, parts)
        return f'<{tag} name="{joint.name}" type="{kind}">{"".join(parts)}</{tag}>{more}'

    def extensions(self, joint, parts):
        """Tags in the joint, which are added to its parts, and beside it."""
        rng, more = self.rng, ""
        leaders = [other for other in self.mechanism.joints if other.kind in ("revolute", "prismatic") and other is not joint]
        leaders = [other for other in leaders if other.mimic is None]
        if leaders and not self.is_leader(joint) and rng.random() < 0.3:
            leader, ratio, offset = leaders[rng.integers(len(leaders))].name, rng.uniform(-2, 2), rng.uniform(-0.2, 0.2)
            joint.mimic = leader, ratio, offset
            parts.append(f'<mimic joint="{leader}" multiplier="{ratio!r}" offset="{offset!r}"/>')
        if rng.random() < 0.5:
            inertia, ratio = rng.uniform(0, 1e-4), rng.uniform(-100, 100)
            joint.armature = inertia * ratio**2
            rotor = f'<drake:rotor_inertia value="{inertia!r}"/><drake:gear_ratio value="{ratio!r}"/>'
            more += f'<transmission><joint name="{joint.name}"/><actuator name="a">{rotor}</actuator></transmission>'
        if joint.stiffness:
            spring = f"<springStiffness>{joint.stiffness!r}</springStiffness><springReference>{joint.rest!r}</springReference>"
            more += f'<gazebo reference="{joint.name}">{spring}</gazebo>'
        return more

    def is_leader(self, joint):
        return any(other.mimic is not None and other.mimic[0] == joint.name for other in self.mechanism.joints)
