"""SDF files as descriptions <robot>: models, included ones too, become links and joints of a tree, and loops.

Names are those of the SDF, "model::link" in nested models. Poses are resolved where all joints are at 0.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, SubElement

import numpy as np

from ...ground.checks import nearest
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.units import GROUND
from ..tangent import BASE, JointGear
from .extensions import (
    WORLD,
    Joint,
    acts,
    add_joint,
    add_loop,
    amount,
    is_true,
    leave_out_repeated,
    leave_out_unknown,
    local_name,
    pose_of,
    read_drake,
    read_joint,
    read_motor,
    read_urdf_file,
    text_of,
)
from .mjcf import is_mjcf, read_mjcf
from .urdf import (
    DOWNWARDS,
    MOMENTS,
    MOST_LINKS,
    RENAMED_GROUND,
    ModelFile,
    add_origin,
    is_model,
    number,
    numbers,
    placement,
    read_urdf,
    short,
    xml_element,
)

#: Endings of SDF files; one that ends in .xml is looked into.
ENDINGS = (".sdf", ".world", ".model")

#: Models in models, and files that include others, at most so deep.
DEEPEST = 12

#: The gravity of a world that gives none, by the format (m/s^2).
USUAL_GRAVITY = "0 0 -9.8"

#: The first version with elements <pose>; its root is <gazebo>.
_FIRST = (1, 2)

#: The last version that is known.
_LAST = (1, 12)

#: Versions of the format that name the axes of joints in the frame of the model are older.
_AXES_IN_JOINT = (1, 5)

#: Since this version joints are frames, with names that no link has.
_NAMES_DIFFER = (1, 7)

#: The names of the frame of a model itself.
_OWN = ("", "__model__")


def is_sdf(source) -> bool:
    """Whether this is the path or the text of an SDF."""
    if not isinstance(source, (str, Path)):
        return False
    ending = Path(str(source)[:4096]).suffix.lower()
    if not (isinstance(source, str) and "<" in source) and ending != ".xml":
        return ending in ENDINGS
    text = read_urdf(source, "SDF")[0]
    return re.search(r"<sdf\b", text) is not None and re.search(r"<(mujoco|robot)\b", text) is None


def read_description(source, base: str = "fixed", package_dirs: tuple[Path, ...] = ()) -> ModelFile:
    """The content of a URDF, SDF or MJCF file, or of a pinocchio model; ``base`` is that of ``Robot``."""
    if isinstance(source, ModelFile):
        return source
    if is_mjcf(source):
        return read_mjcf(source, base != "fixed", package_dirs)
    if is_model(source):
        return ModelFile(model=source, gravity=source.gravity.linear.tolist())
    return read_sdf(source, base, package_dirs) if is_sdf(source) else read_urdf_file(source)


def read_sdf(source: str | Path, base: str = "fixed", package_dirs: tuple[Path, ...] = ()) -> ModelFile:
    """The content of an SDF file: one model, or a world of models."""
    text, folder = read_urdf(source, "SDF")
    root = _root(text)
    content = ModelFile("SDF", folder=folder)
    reader = _SdfReader(content, folder, package_dirs)
    worlds = root.findall("world")
    if len(worlds) > 1:
        raise InputError(f"sdf: found {len(worlds)} worlds; expected one")
    if worlds and (root.find("model") is not None or root.find("include") is not None):
        raise InputError("sdf: found a world and models outside of it; expected all of them in the world")
    if _version(root) > _LAST:
        text = f"its version is later than {'.'.join(map(str, _LAST))}, the last that is known; what it changes is not read"
        content.remarks.append(Notice(NoticeKind.OMITTED, f"SDF: {text}", doubtful=True))
    models = worlds[0] if worlds else root
    if not worlds and len(models.findall("model")) == 1:
        scope = _Scope(reader, models.findall("model")[0], None, "", _version(root), folder)
    else:
        scope = _Scope(reader, models, None, "", _version(root), folder, is_world=True)
    gravity = text_of(worlds[0], "gravity", USUAL_GRAVITY) if worlds else " ".join(map(repr, DOWNWARDS))
    content.description = Element("robot", name=(scope.element.get("name") or "robot"))
    _Assembly(content.description, scope, content).build(base)
    content.gravity = numbers(gravity, 3, "sdf, gravity")
    return content


def _root(text: str, where: str = "sdf") -> Element:
    root = xml_element(re.sub(r"<\?xml[^>]*\?>", "", text, count=1), where)  # Gazebo accepts comments before the declaration
    if root.tag != "sdf" and not (root.tag == "gazebo" and _version(root) >= _FIRST):
        old = f' version="{short(root.get("version"))}"' if root.tag == "gazebo" else ""
        raise InputError(
            f"{where}: found <{short(root.tag)}{old}>; expected <sdf>, of version {'.'.join(map(str, _FIRST))} or later"
        )
    if not re.match(r"\d", given := root.get("version", "0")):
        raise InputError(f'{where}: found the version "{short(given)}"; expected two numbers, such as 1.9')
    return root


def _version(root: Element) -> tuple[int, int]:
    """Numbers of the version: 1.10 is later than 1.9."""
    match = re.match(r"(\d{1,9})(?:\.(\d{1,9}))?", root.get("version", ""))
    return (int(match[1]), int(match[2] or 0)) if match else _AXES_IN_JOINT


class _SdfReader:
    """Finds included models."""

    def __init__(self, content: ModelFile, folder: Path | None, package_dirs: tuple[Path, ...]):
        self.content, self.folder, self.package_dirs = content, folder, package_dirs
        self.links = self.models = 0

    def included(self, uri: str, folder: Path | None) -> Path:
        """The file of a model by its URI."""
        where = f"sdf, include {short(uri)!a}"
        kind, _, rest = uri.rpartition("://")
        if kind not in ("", "model", "file", "package") or "\0" in rest or not rest.strip("/."):
            raise InputError(f"{where}: only local files are read; give the model as a file and its folder in package_dirs")
        home = [] if self.folder is None else [self.folder]
        roots = [place.resolve() for place in (*([] if folder is None else [folder]), *home, *self.package_dirs)]
        places = [(root / rest.lstrip("/") if kind else root / rest).resolve() for root in roots]
        first, _, beyond = rest.strip("/").partition("/")
        places += [(above / beyond).resolve() for root in roots for above in (root, *root.parents) if above.name == first]
        named = [above for root in roots for above in (root, *root.parents) if above.name == first]
        for place in places:
            if not any(place.is_relative_to(root) for root in (*roots, *named)):
                continue
            if (file := _model_file(place)) is not None:
                return file
        raise InputError(
            f"{where}: there is no such model in the folder of the file or in package_dirs; name the folder that holds it there"
        )


def _model_file(place: Path) -> Path | None:
    """The SDF of a model by its file or folder."""
    if place.is_file():
        return place
    if not place.is_dir():
        return None
    configuration = place / "model.config"
    if configuration.is_file():
        root = xml_element(read_urdf(configuration, "config")[0], "config")
        named = sorted((_version(entry), (entry.text or "").strip()) for entry in root.findall("sdf"))
        for _, name in reversed(named):
            file = (place / name).resolve()
            if file.is_relative_to(place) and file.is_file():
                return file
    return next((file for file in (place / "model.sdf",) if file.is_file()), None)


class _Scope:
    """The frames of a model or a world, by their local names.

    Attributes:
        element: <model> or <world>.
        prefix: of the names of its links.
        links, joints: elements by their full names.
        children: nested models by name.
        shapes_at: the folder that relative names of its meshes start from.
    """

    def __init__(
        self,
        reader: _SdfReader,
        element: Element,
        parent: _Scope | None,
        prefix: str,
        version: tuple[int, int],
        folder: Path | None,
        *,
        include: Element | None = None,
        is_world: bool = False,
        depth: int = 0,
    ):
        if depth > DEEPEST:
            raise InputError(f"sdf: models contain each other more than {DEEPEST} deep")
        self.reader, self.element, self.parent, self.prefix, self.version = reader, element, parent, prefix, version
        self.folder, self.include, self.is_world, self.depth = folder, include, is_world, depth
        self.where = "sdf" if is_world else f'sdf, model "{short(prefix.removesuffix("::") or element.get("name"))}"'
        self.children: dict[str, _Scope] = {}
        self.merged: list[_Scope] = []
        self._frames: dict[str, Element] = {}
        self._places: dict[str, Any] = {}
        self._bodies: dict[str, str] = {}
        self._absolute: Any = None
        for child in (*element.findall("link"), *element.findall("frame")):
            self._add(child.get("name", ""), child)
        reader.links += len(element.findall("link"))
        reader.models += 1
        if max(reader.links, reader.models) > MOST_LINKS:
            raise InputError(f"sdf: found more than {MOST_LINKS:,} links or models; at most as many are read")
        for child in element.findall("model"):
            name = child.get("name", "")
            self._add(name, child)
            self.children[name] = _Scope(reader, child, self, f"{prefix}{name}::", version, folder, depth=depth + 1)
        for child in element.findall("include"):
            self._include(child)
        for child in element.findall("joint"):
            if version >= _NAMES_DIFFER or child.get("name") not in (WORLD, *self._frames):
                self._add(child.get("name", ""), child)

    @property
    def is_static(self) -> bool:
        """Whether the model does not move."""
        given = "" if self.include is None else text_of(self.include, "static")
        own = is_true(given or text_of(self.element, "static"))
        return own or (self.parent is not None and not self.parent.is_world and self.parent.is_static)

    def _add(self, name: str, element: Element) -> None:
        if not name or name != name.strip() or name in self._frames or name in (*_OWN, WORLD):
            why = "twice" if name in self._frames else "as a name"
            raise InputError(f'{self.where}: found "{short(name)}" {why}; links, joints, frames and models have distinct names')
        self._frames[name] = element

    def _include(self, element: Element) -> None:
        uri = text_of(element, "uri")
        file = self.reader.included(uri, self.folder)
        root = _root(read_urdf(file, "SDF")[0], f"{self.where}, include {short(uri)!a}")
        models = root.findall("model")
        if not models and root.find("light") is not None:
            return
        if len(models) != 1:
            raise InputError(f"{self.where}, include: {file.name} has {len(models)} models; expected one")
        name = text_of(element, "name") or models[0].get("name", "")
        merges = is_true(element.get("merge", ""))
        if merges:
            name = f"merged {len(self.merged) + 1}"
        self._add(name, element)
        prefix = self.prefix if merges else f"{self.prefix}{name}::"
        options: dict[str, Any] = {"include": element, "depth": self.depth + 1}
        child = _Scope(self.reader, models[0], self, prefix, _version(root), file.parent, **options)
        self.children[name] = child
        if merges:
            self.merged.append(child)
        of, known = f' of the included "{short(name)}"', "uri name pose placement_frame static"
        leave_out_unknown(element, known, of, self.reader.content, lambda part: part.tag != "plugin")

    def _scope_of(self, name: str) -> tuple[_Scope, str] | None:
        """The nested model of a name with ::, or of one of a merged model, and the name in it."""
        first, _, rest = name.partition("::")
        if rest and first in self.children:
            return self.children[first], rest
        if name not in self._frames:
            for child in self.merged:
                if name in child._frames or child._scope_of(name) is not None:
                    return child, name
        return None

    def _unknown(self, name: str, where: str) -> InputError:
        return InputError(f'{where}: there is no frame "{short(name)}"{nearest(name, self._frames)}')

    def local(self, name: str, where: str):
        """The SE3 of a frame relative to that of the model."""
        import pinocchio

        path: list[str] = []
        while name not in self._places and name not in _OWN:
            if name == WORLD:
                self._places[name] = pinocchio.SE3.Identity() if self.is_world else self.absolute.inverse()
                break
            if name in path:
                names = " -> ".join(short(part) for part in (*path, name))
                raise InputError(f"{self.where}: frames are relative to each other in a circle: {names}")
            path.append(name)
            name = self._base(name, where)
        place = pinocchio.SE3.Identity() if name in _OWN else self._places[name]
        for part in reversed(path):
            place = self._places[part] = place * self._step(part, where)
        return place

    def _base(self, name: str, where: str) -> str:
        """The frame in which another one is given."""
        if (nested := self._scope_of(name)) is not None:
            return next(key for key, child in self.children.items() if child is nested[0])
        if name not in self._frames:
            raise self._unknown(name, where)
        element = self._frames[name]
        _, base = pose_of(element, f'{self.where}, <{element.tag}> "{short(name)}"')
        if base:
            return base
        if element.tag == "joint":
            return text_of(element, "child")
        return element.get("attached_to", "") if element.tag == "frame" else ""

    def _step(self, name: str, where: str):
        """The SE3 of a frame in its base frame."""
        if (nested := self._scope_of(name)) is not None:
            child, rest = nested
            return child.local(rest, where)
        element = self._frames[name]
        pose = self.children[name].pose() if name in self.children else None
        return pose_of(element, f'{self.where}, <{element.tag}> "{short(name)}"')[0] if pose is None else pose

    def pose(self):
        """The SE3 of the frame of the model in the base frame of its pose."""
        given = self.include is not None and self.include.find("pose") is not None
        place, _ = pose_of(self.include if given and self.include is not None else self.element, self.where)
        frame = self.element.get("placement_frame", "")
        if self.include is not None and (given or self.include.find("placement_frame") is not None):
            frame = text_of(self.include, "placement_frame") or frame
        return place * self.local(frame, self.where).inverse() if frame else place

    @property
    def absolute(self):
        """The SE3 of the model in space."""
        import pinocchio

        if self._absolute is None:
            if self.is_world:
                self._absolute = pinocchio.SE3.Identity()
            elif self.parent is None:
                self._absolute = self.pose()
            else:
                name = next(key for key, child in self.parent.children.items() if child is self)
                self._absolute = self.parent.absolute * self.parent.local(name, self.where)
        return self._absolute

    def place(self, name: str, where: str):
        """The SE3 of a frame in space."""
        return self.absolute * self.local(name, where)

    def body(self, name: str, where: str) -> str:
        """The full name of the link that a frame is fixed in."""
        passed: dict[str, None] = {}
        while name not in self._bodies:
            if name in passed:
                names = " -> ".join(map(short, (*passed, name)))
                raise InputError(f"{self.where}: frames are attached to each other in a circle: {names}")
            passed[name] = None
            following = self._attached_to(name, where)
            if following is None:
                break
            name = following
        body = self._bodies.get(name) or self._own_body(name, where)
        self._bodies |= dict.fromkeys(passed, body)
        return body

    def _attached_to(self, name: str, where: str) -> str | None:
        """The frame of this model that a frame is attached to; none where it belongs to a body."""
        if name in _OWN:
            return self.element.get("canonical_link") or None
        if name == WORLD or self._scope_of(name) is not None or name in self.children:
            return None
        if name not in self._frames:
            raise self._unknown(name, where)
        element = self._frames[name]
        if element.tag == "link":
            return None
        return text_of(element, "child") if element.tag == "joint" else element.get("attached_to", "")

    def _own_body(self, name: str, where: str) -> str:
        """The full name of the link of a frame that is attached to no other frame of this model."""
        if name == WORLD or (self.is_world and name in _OWN):
            return WORLD
        if (nested := self._scope_of(name)) is not None:
            return nested[0].body(nested[1], where)
        if name in self.children:
            return self.children[name].body("", where)
        if name in _OWN:
            if (link := self.element.find("link")) is None:
                for child in self.children.values():
                    return child.body("", where)
                raise InputError(f"{self.where}: found no <link>; a model needs one")
            name = str(link.get("name"))
        return body_name(f"{self.prefix}{name}")

    def check_frames(self) -> None:
        """Raise an InputError where a frame or the canonical link refers to a name that does not exist."""
        if not self.is_world and self.element.get("canonical_link"):
            self.body("", self.where)
        for frame in self.element.findall("frame"):
            name = frame.get("name", "")
            where = f'{self.where}, <frame> "{short(name)}"'
            self.body(name, where)
            self.local(name, where)

    def all(self) -> Iterator[_Scope]:
        """This scope and all nested ones."""
        yield self
        for child in self.children.values():
            yield from child.all()


def body_name(name: str) -> str:
    """Full name of a link."""
    return RENAMED_GROUND if name == GROUND else name


class _Assembly:
    """The tree of all bodies of an SDF."""

    def __init__(self, robot: Element, scope: _Scope, content: ModelFile):
        self.robot, self.scope, self.content = robot, scope, content
        self.places: dict[str, Any] = {WORLD: placement((0, 0, 0))}
        self.joints: list[Joint] = []

    def build(self, base: str) -> None:
        """Links, joints of a spanning tree, loops and gears."""
        bodies: dict[str, tuple[_Scope, Element]] = {}
        for scope in self.scope.all():
            scope.check_frames()
            _leave_out(scope.element, scope, self.content)
            for link in scope.element.findall("link"):
                name = body_name(f"{scope.prefix}{link.get('name')}")
                if name in bodies:
                    raise InputError(f'{scope.where}: two links are named "{short(name)}"; names must differ')
                bodies[name] = scope, link
                self.places[name] = scope.place(str(link.get("name")), scope.where)
                if scope.is_static:
                    self.joints.append(Joint(f"{name} is static", "fixed", WORLD, name, self.places[name]))
        if not bodies:
            raise InputError("sdf: found no <link>; a robot needs at least one")
        motors: list[tuple[Joint, Element]] = []
        for scope in self.scope.all():
            for element in scope.element.findall("joint"):
                if not scope.is_static:
                    joint = read_joint(element, scope, self.content, scope.version, scope.prefix)
                    self.joints.append(joint)
                    motors.append((joint, element))
            read_drake(scope.element, lambda name, where, scope=scope: self._anchor(scope, name, where), self.content)
        gearboxes = [joint for joint in self.joints if joint.kind == "gearbox"]
        self.joints = [joint for joint in self.joints if joint.kind != "gearbox"]
        twice = [name for name, count in Counter(joint.name for joint in self.joints).items() if count > 1]
        if twice:
            raise InputError(f'sdf: two joints are named "{short(twice[0])}"; names must differ')
        self._name_leaders()
        self._add_tree(bodies, base, {item[0].name for gear in gearboxes for item in self._of_gear(gear) if item is not None})
        kinds = {element.get("name"): element.get("type") for element in self.robot.findall("joint")}
        for joint, element in motors:
            if kinds.get(joint.name) in ("revolute", "prismatic"):
                read_motor(joint.name, [element], self.content)
            elif kinds.get(joint.name) != "fixed" and any(local_name(part) == "rotor_inertia" for part in element.iter()):
                self.content.leave_out(f'rotor of the joint "{short(joint.name)}", which is no hinge or slide of the tree', True)
        for gear in gearboxes:
            self._add_gear(gear)

    def _name_leaders(self) -> None:
        """Name the coordinates of leaders: a leader with two axes has two."""
        joints = {joint.name: joint for joint in self.joints}
        for joint in self.joints:
            for axis in joint.axes:
                if axis.mimic is None:
                    continue
                (leader, ratio, offset), where = axis.mimic, f'sdf, joint "{short(joint.name)}", mimic'
                if leader not in joints:
                    raise InputError(f'{where}: there is no joint "{short(leader)}"{nearest(leader, joints)}')
                if joints[leader].kind == "universal":
                    axis.mimic = f"{leader} {axis.leader_axis}", ratio, offset

    def _anchor(self, scope: _Scope, name: str, where: str) -> tuple[str, Any]:
        body = scope.body(name, where)
        return (GROUND if body == WORLD else body), self.places[body].inverse() * scope.place(name, where)

    def _add_tree(self, bodies: Mapping[str, tuple[_Scope, Element]], base: str, geared: set[str]) -> None:
        """Joints of a spanning tree: fixed joints, those without an equivalent loop, those with springs, then others in order."""
        leaders = {axis.mimic[0] for joint in self.joints for axis in joint.axes if axis.mimic is not None}
        leaders |= {name.rpartition(" ")[0] for name in leaders}  # joints with two axes
        followers = {joint.name for joint in self.joints if any(axis.mimic for axis in joint.axes)}
        kept = geared | leaders | followers

        def order(joint: Joint) -> int:
            return 0 if joint.kind == "fixed" else 1 if not joint.closes or joint.name in kept else 2 if joint.has_springs else 3

        group = {name: name for name in (WORLD, *bodies)}

        def first_of(name: str) -> str:
            while group[name] != name:
                group[name] = name = group[group[name]]
            return name

        tree, cut = [], []
        for joint in sorted(self.joints, key=order):
            ends = first_of(joint.parent), first_of(joint.child)
            (tree if ends[0] != ends[1] else cut).append(joint)
            group[ends[1]] = ends[0]
        children = {joint.child for joint in tree}
        free: list[str] = []
        for name in (*(name for name in bodies if name not in children), *bodies):
            if first_of(name) != first_of(WORLD):
                free.append(name)
                group[first_of(name)] = first_of(WORLD)
        self._check_base(base, free, len(free) == 1 and len({first_of(name) for name in bodies}) == 1, tree)
        if base == "moving" and free:
            roots = free
        else:
            roots = [WORLD]
            SubElement(self.robot, "link", name=WORLD)
            for name in free:
                own = BASE if len(free) == 1 else f"{name} {BASE}"
                tree.append(Joint(own, "floating", WORLD, name, self.places[name]))
        for name, (scope, link) in bodies.items():
            _add_link(self.robot, name, scope, link, self.content)
        self._add_joints(tree, roots)
        for joint in cut:
            if joint.kind == "fixed" and joint.parent == joint.child:
                continue
            add_loop(joint, self.places, self.content)

    def _check_base(self, base: str, free: list[str], is_alone: bool, tree: list[Joint]) -> None:
        attached = any(WORLD in (joint.parent, joint.child) for joint in tree)
        if free and base == "fixed":
            names = ", ".join(f'"{short(name)}"' for name in free[:3]) + (f" and {len(free) - 3} more" if len(free) > 3 else "")
            text = f"nothing joins {names} to the world, so that the base is free"
            advice = "" if len(free) > 1 or attached else '; base = "moving" keeps it at rest'
            self.content.remarks.append(Notice(NoticeKind.OVERRIDE, f"SDF: {text}{advice}"))
        if base == "free" and not free:
            raise InputError('base: found "free", but the SDF joins the robot to the world; leave it out')
        if base == "moving" and free and (len(free) > 1 or attached):
            raise InputError('base: found "moving"; expected an SDF of one robot that nothing, or all, joins to the world')

    def _add_joints(self, tree: list[Joint], roots: list[str]) -> None:
        """Joints from the root on; those towards it are reversed."""
        around: dict[str, list[Joint]] = {}
        for joint in tree:
            around.setdefault(joint.parent, []).append(joint)
            around.setdefault(joint.child, []).append(joint)
        passed, waiting = set(roots), list(roots)
        for body in waiting:
            for joint in around.get(body, ()):
                other = joint.child if joint.parent == body else joint.parent
                if other not in passed:
                    passed.add(other)
                    waiting.append(other)
                    add_joint(self.robot, joint if joint.parent == body else joint.reversed(), self.places, self.content)

    def _of_gear(self, gear: Joint) -> list[tuple[Joint, float] | None]:
        """The joints of a gearbox with the sign of their coordinates for a turn of the body about the axis of the gearbox."""
        results: list[tuple[Joint, float] | None] = []
        for body, axis in zip((gear.parent, gear.child), gear.axes):
            own = [
                joint for joint in self.joints if joint.kind == "revolute" and {joint.parent, joint.child} == {body, gear.reference}
            ]
            if len(own) != 1:
                results.append(None)
                continue
            along = (own[0].place.rotation @ own[0].axes[0].direction) @ (gear.place.rotation @ axis.direction)
            results.append((own[0], float(np.sign(along)) * (1.0 if own[0].child == body else -1.0)))
        return results

    def _add_gear(self, gear: Joint) -> None:
        first, second = self._of_gear(gear)
        if first is None or second is None or not first[1] * second[1]:
            part = f'the gearbox "{short(gear.name)}", whose parent and child have no joints with its reference body'
            self.content.leave_out(part, True)
        else:
            ratio = -gear.ratio * first[1] * second[1]
            self.content.gears.append(JointGear(second[0].name, first[0].name, ratio))


def _add_link(robot: Element, name: str, scope: _Scope, link: Element, content: ModelFile) -> None:
    """A link with its mass and shapes."""
    where, element = f'sdf, link "{short(name)}"', SubElement(robot, "link", name=name)
    if not scope.is_static:
        _add_inertial(element, link, where, name, content)
    own = scope.place(str(link.get("name")), where)
    for tag in ("visual", "collision"):
        for shape in link.findall(tag):
            _add_shape(element, shape, tag, scope, own, where, content)


def _add_inertial(element: Element, link: Element, where: str, name: str, content: ModelFile) -> None:
    inertial = link.find("inertial")
    if inertial is not None and is_true(inertial.get("auto", "")):
        raise InputError(f"{where}: its inertia is to be computed from its shapes (auto); give mass and inertia")
    result = SubElement(element, "inertial")
    place = placement((0, 0, 0)) if inertial is None else pose_of(inertial, f"{where}, inertial")[0]
    mass = number(text_of(inertial, "mass", "1"), f"{where}, mass", minimum=0.0)
    inertia = None if inertial is None else inertial.find("inertia")
    if inertial is None or inertial.find("mass") is None or inertia is None:
        content.usual.append(f'"{short(name)}"')
    add_origin(result, place)
    SubElement(result, "mass", value=repr(mass))
    usual = {key: "1" if key in ("ixx", "iyy", "izz") else "0" for key in MOMENTS}
    moments = {key: repr(number(text_of(inertia, key, usual[key]), f"{where}, inertia, {key}")) for key in MOMENTS}
    SubElement(result, "inertia", moments)
    leave_out_unknown(
        () if inertial is None else inertial, "pose mass inertia frame density", f' of the mass of "{short(name)}"', content
    )


#: Shapes of an SDF that are those of a URDF, with their sizes.
_SHAPES = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",), "capsule": ("radius", "length")}


def _add_shape(link: Element, shape: Element, tag: str, scope: _Scope, own, where: str, content: ModelFile) -> None:
    """A visual or collision shape."""
    geometry = shape.find("geometry")
    kind = next((part for part in ([] if geometry is None else geometry) if part.tag in (*_SHAPES, "mesh")), None)
    if kind is None:
        others = [part.tag for part in ([] if geometry is None else geometry) if part.tag not in ("plane", "empty")]
        if others and tag == "visual":
            content.leave_out(f'the shape <{short(others[0])}> of "{short(link.get("name"))}", which is not drawn', False)
        return
    pose, base = pose_of(shape, f"{where}, {tag}")
    place = own.inverse() * scope.place(base, f"{where}, {tag}") * pose if base else pose
    result = SubElement(link, tag)
    add_origin(result, place)
    target = SubElement(result, "geometry")
    if kind.tag == "mesh":
        uri = text_of(kind, "uri") or text_of(kind, "filename")
        if "://" not in uri and scope.folder is not None and scope.folder != scope.reader.folder:  # of an included model
            uri = str(scope.folder / uri)
        SubElement(
            target, "mesh", {"filename": uri} | ({"scale": text_of(kind, "scale")} if kind.find("scale") is not None else {})
        )
    else:
        SubElement(target, kind.tag, {key: text_of(kind, key) for key in _SHAPES[kind.tag]})
    color = text_of(shape.find("material"), "diffuse") or text_of(shape.find("material"), "ambient")
    if len(color.split()) in (3, 4):
        SubElement(SubElement(result, "material"), "color", rgba=f"{color} 1" if len(color.split()) == 3 else color)


#: Children of <model>, <world> and <link> that are read or have no effect on the motion.
_KNOWN = {
    "model": "link joint frame pose static model include self_collide allow_auto_disable",
    "world": "link joint frame pose model include gravity physics scene light gui magnetic_field atmosphere spherical_coordinates state "
    "audio road population",
    "link": "pose inertial visual collision self_collide sensor light must_be_base_link projector particle_emitter audio_sink "
    "audio_source battery",
}


def _leave_out(element: Element, scope: _Scope, content: ModelFile) -> None:
    """Note the omitted parts of a model or world and of its links."""
    static = scope.is_static

    def may_act(child: Element) -> bool:
        return bool(acts(child) or amount(child.text or ""))

    for child in element:
        if "}" in child.tag or ":" in child.tag:
            continue
        if child.tag == "plugin":
            content.leave_out(f"plugin {short(child.get('name') or child.get('filename') or '')}", bool(acts(child) and not static))
        elif child.tag in ("enable_wind", "wind"):
            if amount(child.text or "") or amount(text_of(child, "linear_velocity")):
                content.leave_out(f"<{child.tag}>", False)
        else:
            kind, place = ("world", "the world") if scope.is_world else ("model", scope.where.removeprefix("sdf, "))
            leave_out_unknown([child], _KNOWN[kind], f" of {place}", content, may_act)
        if child.tag == "state" and any(amount(part.text or "") for part in child.iterfind("model//*")):
            content.leave_out("<state> of the world", True)
    for link in () if static else element.findall("link"):
        name = short(f"{scope.prefix}{link.get('name')}")
        for child in link:
            text = (child.text or "").strip()
            if child.tag == "gravity":
                if not is_true(text or "1"):
                    content.leave_out(f'<gravity> {text} of "{name}"', True)
            elif child.tag == "kinematic":
                if is_true(text):
                    content.leave_out(f'<kinematic> of "{name}"', True)
            elif child.tag == "velocity_decay":
                if any(amount(part.text or "") for part in child):
                    content.leave_out(f'<velocity_decay> of "{name}"', True)
            elif child.tag == "enable_wind":
                if is_true(text):
                    content.leave_out(f'<enable_wind> of "{name}"', False)
            else:
                leave_out_unknown([child], _KNOWN["link"], f' of "{name}"', content, may_act)
        leave_out_repeated(link, f'the link "{name}"', content)
