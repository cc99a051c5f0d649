"""MJCF files, compiled by MuJoCo: the pinocchio model, loops, gears, springs, motors, states and shapes of the compiled arrays.

The XML is only checked and put together: included files, places of files, missing meshes. MuJoCo compiles it in a process of its own,
since it has no limits of time and memory. Bodies, joints, forces and equalities are then those of ``MjModel``; ``mujoco_check`` compares
masses, stiffness, damping and loops with MuJoCo's own at a posture.
"""

from __future__ import annotations

import copy
import json
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import numpy as np

from ...ground.checks import counted, listed
from ...ground.errors import InputError
from ...ground.files import isolated
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import LOOPS_CLOSED_AS_ROUNDED
from ...ground.units import GROUND
from ..connections import Bushing, Loop, Segment, Tendon
from ..flexible_joint import Motor
from ..kinematics import MOST_COORDINATES
from ..tangent import JointGear
from .urdf import LARGEST, RENAMED_GROUND, ModelFile, angles_of, read_urdf, short, xml_element

#: Files that include others, elements in elements, and models in models, at most so deep.
DEEPEST_INCLUDE, DEEPEST_ELEMENT, DEEPEST_MODEL = 5, 300, 5

#: Files that make a folder a package, looked for so many folders up.
_PACKAGE_FILES, DEEPEST_PACKAGE = ("package.xml", "__init__.py", "pyproject.toml", ".git"), 6

#: Time (s) and memory (bytes) that MuJoCo may take to compile a model.
LONGEST_COMPILATION, LARGEST_MEMORY = 30, 4 * 2**30

_NO_MEMORY = f"it needs more than {LARGEST_MEMORY / 2**30:g} GB of memory, or is damaged"

#: Groups of actuators that can be disabled.
_GROUPS = 31

#: Most names in a notice.
MOST_NAMED = 4

#: Size of the tetrahedra that stand for missing meshes; what depends on them shows in two compilations.
_PLACEHOLDERS = (1.0, 2.0)


def _compile(texts: dict[str, str], most: int) -> None:
    """Compile "main.xml", run it once, and save the model: executed in a separate process."""
    import mujoco

    for name, text in texts.items():
        with open(name, "w", encoding="utf-8") as file:
            file.write(text)
    model = mujoco.MjModel.from_xml_path("main.xml")
    if model.nv <= most:
        mujoco.mj_fwdPosition(model, mujoco.MjData(model))
    mujoco.mj_saveModel(model, "model.mjb", None)


def is_mjcf(source) -> bool:
    """Whether this is the path of an MJCF file."""
    if not isinstance(source, (str, Path)) or Path(str(source)[:4096]).suffix.lower() not in (".xml", ".mjcf"):
        return False
    return re.search(r"<mujoco\b", read_urdf(source, "MJCF")[0]) is not None


def read_mjcf(path: str | Path, free_base: bool, package_dirs: tuple[str | Path, ...] = ()) -> ModelFile:
    """The content of an MJCF file."""
    path = Path(path)
    files = _MjcfFiles(path, tuple(Path(folder).resolve() for folder in package_dirs))
    compiled, *more = (_compiled(*files.texts(size)) for size in (_PLACEHOLDERS if files.missing else _PLACEHOLDERS[:1]))
    undrawn: frozenset[int] = frozenset()
    if more:
        (other,) = more
        changed = [
            name
            for body, name in enumerate(_names(compiled, "body", compiled.nbody))
            for own in ("body_mass", "body_inertia", "body_ipos")
            if not np.array_equal(getattr(compiled, own)[body], getattr(other, own)[body])
        ]
        if changed:
            raise InputError(
                f'mjcf: the mass of the body "{short(changed[0])}" is that of a mesh whose file is missing ({files.missing[0]}); give '
                "the file, or an <inertial> of the body"
            )
        undrawn = frozenset(np.flatnonzero((compiled.geom_size != other.geom_size).any(axis=1)).tolist())
    return _Reader(copy.copy(compiled), free_base).model_file(path, files.missing, undrawn)


def _package(folder: Path) -> Path:
    """The folder from which a file may name others: the package that it lies in, else the folder above its own.

    A home directory or the root of a file system is none, and neither is what lies above it.
    """
    above = [folder, *folder.parents][: DEEPEST_PACKAGE + 1]
    inside = above[: next((n for n, one in enumerate(above) if one in (Path.home(), Path(one.anchor))), len(above))]
    if not inside:
        return folder
    package = next((one for one in inside if any((one / name).exists() for name in _PACKAGE_FILES)), inside[:2][-1])
    while package.parent in inside and (package.parent / "__init__.py").exists():
        package = package.parent
    return package


class _MjcfFiles:
    """The texts of an MJCF file with its includes, with validated names of files; ``missing`` names absent meshes."""

    def __init__(self, path: Path, package_dirs: tuple[Path, ...]):
        self._roots = (_package(path.parent.resolve()), *package_dirs)
        self.missing: list[str] = []
        self._read: dict[str, int] = {}
        self._models: dict[str, Element] = {}
        self._meshes: list[Element] = []
        self._main = self._checked(path, 0)

    def texts(self, size: float) -> tuple[str, tuple]:
        """The files of MuJoCo as JSON with placeholders of a size for missing meshes, and the times of the files read."""
        for mesh in self._meshes:
            mesh.set("vertex", f"0 0 0 {size} 0 0 0 {size} 0 0 0 {size}")
        elements = {"main.xml": self._main, **self._models}
        for root in elements.values():
            ElementTree.indent(root)  # an element on each line, which messages of MuJoCo number
        return json.dumps({name: ElementTree.tostring(root, "unicode") for name, root in elements.items()}), tuple(
            self._read.items()
        )

    def _checked(self, path: Path, depth: int) -> Element:
        """A model whose files have absolute paths; textures and skins, which are not drawn, are removed."""
        if depth > DEEPEST_MODEL:
            raise InputError(f"mjcf: models contain each other more than {DEEPEST_MODEL} deep")
        folder = path.parent.resolve()
        root = self._expanded(path, folder, 0)
        compiler: dict[str, str] = {}
        for element in root.findall("compiler"):
            compiler |= element.attrib
            for key in ("meshdir", "assetdir", "texturedir", "strippath"):
                element.attrib.pop(key, None)
        meshes = Path(compiler.get("meshdir", compiler.get("assetdir", "")))
        for parent in list(root.iter()):
            parent.attrib.pop("texture", None)
            for child in list(parent):
                if child.tag in ("texture", "layer", "skin"):
                    self._place(child, [folder], child.get("file", "")) if child.get("file") else None
                    parent.remove(child)
                elif (name := child.get("file")) is not None and child.tag == "model":
                    own = f"model{len(self._models)}.xml"
                    self._models[own] = Element("mujoco")
                    place = self._place(child, [folder], name)
                    if not place.is_file():
                        raise InputError(f"mjcf: there is no model file {short(name)!a}")
                    child.set("name", child.get("name", place.stem))
                    self._models[own] = self._checked(place, depth + 1)
                    child.set("file", own)
                elif name is not None:
                    name = re.split(r"[/\\]", name)[-1] if compiler.get("strippath") == "true" else name
                    place = self._place(child, [folder / meshes], name)
                    if place.is_file():
                        child.set("file", str(place))
                        self._read[str(place)] = place.stat().st_mtime_ns
                    elif child.tag == "mesh":
                        self.missing.append(name)
                        kept = child.get("name", Path(name.replace("\\", "/")).stem)
                        child.clear()
                        child.set("name", kept)
                        self._meshes.append(child)
        return root

    def _expanded(self, path: Path, folder: Path, depth: int) -> Element:
        """The root element with the content of included files."""
        root = xml_element(read_urdf(path, "MJCF")[0], "mjcf")
        level: list[Element] = [root]
        for _ in range(DEEPEST_ELEMENT):
            level = [child for element in level for child in element]
        if level:
            raise InputError(f"mjcf: {path.name}: elements contain each other more than {DEEPEST_ELEMENT} deep")
        for parent in list(root.iter()):
            for child in parent.findall("include"):
                if depth >= DEEPEST_INCLUDE:
                    raise InputError(f"mjcf: files include each other more than {DEEPEST_INCLUDE} deep")
                place = self._place(child, [folder, path.parent.resolve()], child.get("file", ""))
                at = list(parent).index(child)
                parent[at : at + 1] = list(self._expanded(place, folder, depth + 1))
        return root

    def _place(self, element: Element, folders: list[Path], name: str) -> Path:
        """The path of a file, the first one that exists."""
        if "\0" in name:
            raise InputError(f"mjcf: found the file name {short(name)!a} of <{element.tag}>")
        places = [(folder / name.replace("\\", "/")).resolve() for folder in folders]
        place = next((place for place in places if place.is_file()), places[0])
        if not any(place.is_relative_to(root) for root in self._roots):
            raise InputError(
                f"mjcf: the file {short(name)!a} of <{element.tag}> lies outside of the folder of the MJCF, the one above it "
                "and its package; name its folder in package_dirs"
            )
        return place


@lru_cache(maxsize=8)
def _compiled(texts: str, _times: tuple):
    """The ``MjModel`` of files."""
    try:
        import mujoco
    except ImportError:
        raise InputError(
            "mjcf: MJCF files are compiled by MuJoCo, which is not installed: pip install 'mbconstrained[mjcf]'"
        ) from None
    with isolated(_compile, LONGEST_COMPILATION, LARGEST_MEMORY, texts=json.loads(texts), most=MOST_COORDINATES) as outcome:
        if outcome.code is None:
            raise InputError(f"mjcf: MuJoCo does not compile this model within {LONGEST_COMPILATION} s")
        if outcome.problem:
            text = outcome.problem.replace("Caught an unknown exception!", _NO_MEMORY)
            raise InputError(f"mjcf: MuJoCo {mujoco.__version__} cannot read it ({_reason(text, json.loads(texts))})")
        model = outcome.folder / "model.mjb"
        if not model.is_file():
            raise InputError(f"mjcf: MuJoCo ends on this model with code {outcome.code}: {_NO_MEMORY}")
        compiled = mujoco.MjModel.from_binary_path(str(model))
    if compiled.nv > MOST_COORDINATES:
        raise InputError(f"mjcf: found {compiled.nv:,} degrees of freedom; at most {MOST_COORDINATES:,} are read")
    return compiled


@contextmanager
def quiet():
    """Suppress the warnings that MuJoCo writes to the terminal and to a file."""
    import mujoco

    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)


def _reason(text: str, files: Mapping[str, str]) -> str:
    """A message of MuJoCo on one line, with the element in place of the line of the text given to MuJoCo."""
    place = re.search(r",? ?(?:id \d+, )?line (\d+)", text)
    if place is None:
        return " ".join(text.split())[:300] or "unknown"
    lines, number = files["main.xml"].splitlines(), int(place[1])
    element = f" at {short(lines[number - 1].strip())}" if len(files) == 1 and 0 < number <= len(lines) else ""
    return " ".join(text.replace(place[0], "").split())[:300] + element


def _names(model, kind: str, count: int) -> list[str]:
    """Names of bodies, joints, ..., empty where there are none."""
    starts = getattr(model, f"name_{kind}adr")[:count]
    return [model.names[start : model.names.index(b"\0", start)].decode("utf-8", "replace") for start in starts]


def _flag(model, name: str) -> bool:
    """Whether a flag of <option> disables something; MuJoCo before 3.5 had one for springs and dampers."""
    import mujoco

    flags = mujoco.mjtDisableBit
    bit = getattr(flags, f"mjDSBL_{name}", None)
    if bit is None and name in ("SPRING", "DAMPER"):
        bit = flags.mjDSBL_PASSIVE
    return bit is not None and bool(model.opt.disableflags & bit)


def _rows(model, name: str, count: int) -> np.ndarray:
    """An array with one row for each element, shape (count, k); zeros where a version of MuJoCo does not have it."""
    values = np.array(getattr(model, name, np.zeros(count)), dtype=float)
    return values.reshape(count, values.size // count if count else 1)


def _polynomials(model, name: str, count: int) -> np.ndarray:
    """Coefficients of the first and of higher powers, which are in one array or in two."""
    return np.hstack([_rows(model, name, count), _rows(model, f"{name}poly", count)])


class _Reader:
    """The arrays of a compiled model, read in their order.

    Attributes:
        mj: the ``MjModel``, in which what is left out with a warning is switched off.
        free_base: whether a base without a free joint gets one.
        places: by body the number of its joint, and its placement there.
        left_out: constructs that act on the motion and are not read.
        notes: other notices.
        control: tendons that stand for springs of joints and for gains.
        comparable: whether MuJoCo has the same forces.
    """

    def __init__(self, mj, free_base: bool):
        self.mj, self.free_base, self.comparable = mj, free_base, True
        self.places: list[tuple[int, Any]] = []
        self.left_out: list[str] = []
        self.notes: list[str] = []
        self.control: list[Tendon] = []

    def model_file(self, path: Path, missing: list[str], undrawn: frozenset[int]) -> ModelFile:
        """The description with all parts that were read."""
        mj = self.mj
        if mj.nbody == 1 or not (mj.nv or self.free_base):
            what = "body" if mj.nbody == 1 else "joint that moves"
            raise InputError(f"mjcf: found no {what} in {path.name}; expected a model of bodies with joints")
        self._name_all()
        self._check_numbers()
        links = self.bodies
        self.file = file = ModelFile("MJCF", model=self._tree(), path=path, drawn=mj, links=links, undrawn=undrawn)
        self._joint_springs()
        self._equalities()
        self._actuators()
        file.tendons = [*self._tendons(), *self.control]
        self._others()
        file.gravity = [0.0, 0.0, 0.0] if _flag(mj, "GRAVITY") else mj.opt.gravity.tolist()
        file.lift = {links[i]: (mj.body_ipos[i].tolist(), float(mj.body_gravcomp[i] * mj.body_mass[i])) for i in self._lifted()}
        file.states = dict(self._states())
        file.compiled = mj if self.comparable else None
        if missing:
            self.notes.append(f"{counted(len(missing), 'mesh', 'meshes')} not drawn: there is no file {short(missing[0])!a}")
        doubts = [
            f'the inertia of the tendon "{short(tendon.name)}" couples branches of the tree; MuJoCo leaves this out of its mass matrix'
            for tendon in file.tendons
            if tendon.inertia and not _on_one_branch(file.model, tendon)
        ]
        doubts += [f"not read: {text}" for text in self.left_out]
        file.remarks = [Notice(NoticeKind.OMITTED, f"mjcf: {text}", doubtful=True) for text in doubts]
        file.remarks += [Notice(NoticeKind.OMITTED, f"mjcf: {text}") for text in self.notes]
        return file

    def _name_all(self) -> None:
        """Distinct names of bodies and joints, also where the file has none."""
        mj = self.mj
        self.bodies, used = [], {GROUND, "universe"}
        for number, name in enumerate(_names(mj, "body", mj.nbody)):
            name = RENAMED_GROUND if name == GROUND else name or f"body {number}"
            self.bodies.append(_distinct(name, used))
        self.joints, used = [], {"universe", "root_joint"}
        given = _names(mj, "jnt", mj.njnt)
        used |= set(given)
        for number, name in enumerate(given):
            self.joints.append(name or _distinct(f"{self.bodies[mj.jnt_bodyid[number]]} joint", used))

    def _check_numbers(self) -> None:
        """Raise an InputError where mechanical constants are not finite, or their squares may not be."""
        mj, names = self.mj, {"body": self.bodies, "jnt": self.joints}
        kinds = (*names, "tendon", "actuator", "site", "eq", "dof")
        arrays = [name for name in dir(mj) if name.split("_")[0] in kinds and not name.endswith(("_user", "invweight0", "acc0"))]
        for name in (*arrays, "qpos0", "qpos_spring", "key_qpos"):
            values = getattr(mj, name)
            if isinstance(values, np.ndarray) and values.dtype == float and (wrong := ~(np.abs(values) <= LARGEST)).any():
                place, known = np.argwhere(wrong)[0], names.get(name.split("_")[0], [])
                of = f' of "{short(known[place[0]])}"' if place[0] < len(known) else ""
                raise InputError(f"mjcf: {name}{of}: found {values[tuple(place)]:g}; expected a number of a size below {LARGEST:g}")

    def _tree(self):
        """The pinocchio model; joints are at the values of MuJoCo, so that one with a ref is turned back by it."""
        import pinocchio

        mj, kinds = self.mj, _kinds("mjtJoint")
        model = pinocchio.Model()
        model.name = mj.names[: mj.names.index(b"\0")].decode("utf-8", "replace") or "robot"
        root = 0
        if self.free_base and not (mj.njnt and kinds[mj.jnt_type[0]] == "FREE" and mj.jnt_bodyid[0] == 1):
            root = model.addJoint(0, pinocchio.JointModelFreeFlyer(), pinocchio.SE3.Identity(), "root_joint")
            model.addJointFrame(root, 0)
        self.added_base = bool(root)
        friction = mj.dof_frictionloss * (not (_flag(mj, "FRICTIONLOSS") or _flag(mj, "CONSTRAINT")))
        limited = mj.jnt_limited * (not (_flag(mj, "LIMIT") or _flag(mj, "CONSTRAINT")))
        self.places = [(root, pinocchio.SE3.Identity())]
        self.behind: list[str] = []  # the links of the joints, of which only the last of a body has that body
        damping, armature = _rows(mj, "dof_damping", mj.nv)[:, 0].copy(), np.array(mj.dof_armature)
        own_armature, own_damping = self._of_actuators("jnt", mj.njnt)
        np.add.at(armature, mj.jnt_dofadr, own_armature)
        np.add.at(damping, mj.jnt_dofadr, own_damping)
        damping = damping * (not _flag(mj, "DAMPER"))
        if root or any(geom_kind(self.mj, int(geom)) not in _UNDRAWN for geom in np.flatnonzero(self.mj.geom_bodyid == 0)):
            _add_link(model, self.bodies[0], root, pinocchio.SE3.Identity())
        for body in range(1, mj.nbody):
            joint, place = self.places[mj.body_parentid[body]]
            place = place * pose(mj.body_pos[body], mj.body_quat[body])
            first = int(mj.body_jntadr[body])
            for number in range(first, first + int(mj.body_jntnum[body])):
                kind, axis = kinds[mj.jnt_type[number]], np.array(mj.jnt_axis[number])
                anchor = pinocchio.SE3(np.eye(3), np.array(mj.jnt_pos[number]))
                before = pinocchio.SE3.Identity()
                if kind == "FREE":
                    joint, place, anchor, new = 0, pinocchio.SE3.Identity(), before, pinocchio.JointModelFreeFlyer()
                elif kind == "BALL":
                    new = pinocchio.JointModelSpherical()
                elif kind == "HINGE":
                    new = pinocchio.JointModelRevoluteUnaligned(axis)
                    before = pinocchio.SE3(pinocchio.exp3(-mj.qpos0[mj.jnt_qposadr[number]] * axis), np.zeros(3))
                else:
                    new = pinocchio.JointModelPrismaticUnaligned(axis)
                    before = pinocchio.SE3(np.eye(3), -mj.qpos0[mj.jnt_qposadr[number]] * axis)
                joint = model.addJoint(joint, new, place * anchor * before, self.joints[number])
                model.addJointFrame(joint, 0)
                place = anchor.inverse()
                added, at = model.joints[joint], int(mj.jnt_dofadr[number])
                for own, theirs in ((model.armature, armature), (model.friction, friction), (model.damping, damping)):
                    own[added.idx_v : added.idx_v + added.nv] = theirs[at : at + added.nv]
                if added.nv == 1:
                    limits = mj.jnt_range[number] * bool(limited[number])
                    model.lowerPositionLimit[added.idx_q], model.upperPositionLimit[added.idx_q] = limits
                last = number == first + mj.body_jntnum[body] - 1
                name = self.bodies[body] if last else f"{self.bodies[body]} ({self.joints[number]})"
                self.behind.append(name)
                if not last:
                    _add_link(model, name, joint, place)
            self.places.append((joint, place))
            moments = pinocchio.SE3(_rotation(mj.body_iquat[body]), np.array(mj.body_ipos[body]))
            inertia = pinocchio.Inertia(float(mj.body_mass[body]), np.zeros(3), np.diag(mj.body_inertia[body]))
            model.appendBodyToJoint(joint, place.act(moments.act(inertia)), pinocchio.SE3.Identity())
            _add_link(model, self.bodies[body], joint, place)
        return model

    def _of_actuators(self, kind: str, count: int) -> tuple[np.ndarray, np.ndarray]:
        """Inertias and dampings of actuators at joints or tendons, behind their gears."""
        mj, values = self.mj, np.zeros((2, count))
        for place, actuator in enumerate(getattr(mj, f"{kind}_actuatorid", ())):
            if actuator >= 0:
                damping = _rows(mj, "actuator_damping", len(mj.actuator_trntype))[actuator, 0]
                square = mj.actuator_gear[mj.actuator_outadr[actuator]][0] ** 2
                values[:, place] = square * mj.actuator_armature[actuator], square * damping
        return values[0], values[1]

    def _each_joint(self) -> Iterator[tuple[int, str, str]]:
        kinds = _kinds("mjtJoint")
        return ((number, kinds[self.mj.jnt_type[number]], name) for number, name in enumerate(self.joints))

    def _joint_springs(self) -> None:
        """Springs of joints with one degree of freedom, and bushings of ball and free joints; polynomials are tendons."""
        mj = self.mj
        constants = _polynomials(mj, "jnt_stiffness", mj.njnt)
        if _flag(mj, "SPRING"):
            return
        for number, kind, name in self._each_joint():
            k, at = float(constants[number, 0]), int(mj.jnt_qposadr[number])
            reference = np.array(mj.qpos_spring[at : at + 7])
            if kind in ("HINGE", "SLIDE"):
                if constants[number, 1:].any():
                    powers = tuple(constants[number].tolist())
                    self.control.append(Tendon(f"spring of {name}", {name: 1.0}, stiffness=powers, rest=(reference[0],) * 2))
                else:
                    self.file.add_spring(name, k, float(reference[0]))
                continue
            if constants[number, 1:].any():
                self.left_out.append(f'the stiffness polynomial of the joint "{name}"')
                self.comparable = False
            if k:
                self.file.springs.append(self._bushing(number, kind, name, k, reference))

    def _bushing(self, number: int, kind: str, name: str, k: float, reference: np.ndarray) -> Bushing:
        """The spring of a ball joint, U = k |log R|^2 / 2, and of a free one, between the links before and behind it."""
        mj = self.mj
        body = int(mj.jnt_bodyid[number])
        same = number > mj.body_jntadr[body]
        anchor = np.array(mj.jnt_pos[number]) * (kind == "BALL")
        quaternion = reference[3:7] if kind == "FREE" else reference[:4]
        if kind == "FREE":
            before, placement = 0, pose(reference[:3], quaternion)
        else:
            own = pose(anchor, quaternion)
            before = int(mj.body_parentid[body])
            placement = own if same else pose(mj.body_pos[body], mj.body_quat[body]) * own
        first = self.behind[number - 1] if same else self._body(before)
        turning = (k,) * 3
        along = turning if kind == "FREE" else (0.0,) * 3
        ends = (first, placement.translation.tolist(), self.behind[number], anchor.tolist())
        turn = angles_of(placement.rotation)
        return Bushing(*ends, rotation1=turn, turning_stiffness=turning, stiffness=along, name=f"spring of {name}")

    def _body(self, number: int) -> str:
        return self.bodies[number] if number or self.added_base else GROUND

    def _equalities(self) -> None:
        """Loops of connect and weld; couplings of joints and tendons are gears."""
        mj, kinds = self.mj, _kinds("mjtEq")
        if _flag(mj, "EQUALITY") or _flag(mj, "CONSTRAINT"):
            return
        for number, name in enumerate(_names(mj, "eq", mj.neq)):
            kind, data = kinds[mj.eq_type[number]], np.array(mj.eq_data[number])
            first, second = int(mj.eq_obj1id[number]), int(mj.eq_obj2id[number])
            if not mj.eq_active0[number]:
                continue
            count = len(self.left_out)
            if kind in ("CONNECT", "WELD"):
                self._loop(number, kind, data, first, second, name)
            elif kind == "JOINT":
                row = {self.joints[first]: 1.0}
                if second >= 0:
                    row[self.joints[second]] = -data[1]
                zero = self._value0(first) - (data[1] * self._value0(second) if second >= 0 else 0.0)
                self._gear(row, zero + data[0], data[2:5] * (second >= 0), f'the coupling of the joint "{self.joints[first]}"')
            elif kind == "TENDON":
                self._tendon_coupling(first, second, data, name)
            else:
                self.left_out.append(f'<equality> {kind.lower()} "{name}"')
            if len(self.left_out) > count:
                mj.eq_active0[number] = False

    def _value0(self, joint: int) -> float:
        return float(self.mj.qpos0[self.mj.jnt_qposadr[joint]])

    def _loop(self, number: int, kind: str, data: np.ndarray, first: int, second: int, name: str) -> None:
        """Loop with the anchors that MuJoCo has computed, in body1 and body2."""
        import mujoco
        import pinocchio

        mj = self.mj
        points, frames = [data[:3], data[3:6]], [np.eye(3), np.eye(3)]
        if mj.eq_objtype[number] == mujoco.mjtObj.mjOBJ_SITE:
            points = [np.array(mj.site_pos[site]) for site in (first, second)]
            frames = [_rotation(mj.site_quat[site]) for site in (first, second)]
            first, second = (int(mj.site_bodyid[site]) for site in (first, second))
        elif kind == "WELD":
            points, frames = [data[3:6], data[:3]], [_rotation(data[6:10]), np.eye(3)]
        if self.places[first][0] == self.places[second][0]:  # one rigid body, in which a closed loop is without effect
            one, other = (self.places[body][1] * pinocchio.SE3(*end) for body, *end in zip((first, second), frames, points))
            gap = one.inverse() * other
            turn = float(np.linalg.norm(pinocchio.log3(gap.rotation))) * bool(kind == "WELD" and data[10])
            if max(float(np.linalg.norm(gap.translation)), turn) > LOOPS_CLOSED_AS_ROUNDED:
                what = f'the equality "{short(name)}"' if name else f"equality {number + 1}"
                bodies = " and ".join(f'"{short(self._body(body))}"' for body in (first, second))
                raise InputError(
                    f"mjcf: {what} joins {bodies}, between which there is no joint, where they are apart: it is never closed; take "
                    'it out, or set active="false"'
                )
            mj.eq_active0[number] = False
            return
        ends = (self._body(first), points[0].tolist(), self._body(second), points[1].tolist())
        turns: dict[str, Any] = {}
        if kind == "WELD" and data[10]:
            turns = {"kind": "rigid", "rotation1": angles_of(frames[0]), "rotation2": angles_of(frames[1])}
        self.file.loops.append(Loop(*ends, **turns, name=name or None))

    def _gear(self, row: Mapping[str, float], value: float, higher, what: str) -> None:
        """The row sum(c q) = value as a gear between two joints; a joint that keeps its value is one with a ratio of 0."""
        joints = [joint for joint, factor in row.items() if factor]
        followers = {gear.joint for gear in self.file.gears}
        if np.any(higher):
            self.left_out.append(f"{what}, which is not linear")
            return
        if len(joints) == 1:
            single = {name for _, kind, name in self._each_joint() if kind in ("HINGE", "SLIDE")}
            others = [name for name in self.joints if name in single - {joints[0]} - followers]
            if others and joints[0] not in followers:
                self.file.gears.append(JointGear(joints[0], others[0], 0.0, value / row[joints[0]]))
                return
        if len(joints) == 2:
            for a, b in (joints, joints[::-1]):
                if a not in followers:
                    self.file.gears.append(JointGear(a, b, -row[b] / row[a], value / row[a]))
                    return
        self.left_out.append(what)

    def _tendon_coupling(self, first: int, second: int, data: np.ndarray, name: str) -> None:
        mj, row = self.mj, {}
        value = data[0] + mj.tendon_length0[first] - (data[1] * mj.tendon_length0[second] if second >= 0 else 0.0)
        what = f'<equality> tendon "{name}"'
        for tendon, factor in ((first, 1.0), (second, -data[1])):
            if tendon >= 0:
                own = self._path(tendon)
                if own is None or own[1]:
                    self.left_out.append(f"{what} of a spatial tendon")
                    return
                for joint, coefficient in own[0].items():
                    row[joint] = row.get(joint, 0.0) + factor * coefficient
        self._gear(row, value, data[2:5] * (second >= 0), f"{what} of {len(row)} joints")

    def _path(self, tendon: int) -> tuple[dict[str, float], tuple[Segment, ...]] | None:
        """Coefficients of joints, or segments between sites with one over the divisor of their pulley; None around a geom."""
        mj, kinds = self.mj, _kinds("mjtWrap")
        joints, segments, before, factor = {}, [], None, 1.0
        for at in range(int(mj.tendon_adr[tendon]), int(mj.tendon_adr[tendon] + mj.tendon_num[tendon])):
            kind, number = kinds[mj.wrap_type[at]], int(mj.wrap_objid[at])
            if kind == "JOINT":
                joints[self.joints[number]] = float(mj.wrap_prm[at])
            elif kind == "PULLEY":
                before, factor = None, 1.0 / float(mj.wrap_prm[at])
            elif kind == "SITE":
                end = (self._body(int(mj.site_bodyid[number])), tuple(mj.site_pos[number].tolist()))
                if before is not None:
                    segments.append(Segment(*before, *end, factor))
                before = end
            else:
                return None
        return joints, tuple(segments)

    def _tendons(self) -> Iterator[Tendon]:
        """Springs, dampers and inertias along tendons."""
        mj = self.mj
        constants = _polynomials(mj, "tendon_stiffness", mj.ntendon) * (not _flag(mj, "SPRING"))
        own = self._of_actuators("tendon", mj.ntendon)
        armature, damping = (_rows(mj, f"tendon_{key}", mj.ntendon)[:, 0] + more for key, more in zip(("armature", "damping"), own))
        for number, name in enumerate(self._tendon_names()):
            c = float(damping[number]) * (not _flag(mj, "DAMPER"))
            if mj.tendon_frictionloss[number]:
                self.notes.append(f'dry friction of the tendon "{name}" is left out: it is not linear')
            if not (constants[number].any() or c or armature[number]):
                continue
            path = self._path(number)
            if path is None:
                raise InputError(
                    f'mjcf: the tendon "{short(name)}" with stiffness, damping or inertia is wrapped around a geom, which is not read; '
                    "let it pass through sites alone"
                )
            springs: dict[str, Any] = {
                "stiffness": tuple(constants[number].tolist()),
                "rest": tuple(mj.tendon_lengthspring[number].tolist()),
            }
            yield Tendon(name, *path, **springs, damping=c, inertia=float(armature[number]))

    def _tendon_names(self) -> list[str]:
        return [name or f"tendon {number}" for number, name in enumerate(_names(self.mj, "tendon", self.mj.ntendon))]

    def _actuators(self) -> None:
        """Gains of position and velocity by joint; those along tendons, and those below zero, are tendons that rest at the guess."""
        mj, gains, idle = self.mj, {}, []
        if _flag(mj, "ACTUATION"):
            return
        for number, name in enumerate(_names(mj, "actuator", len(mj.actuator_trntype))):
            name, group = name or f"actuator {number}", int(mj.actuator_group[number])
            if 0 <= group < _GROUPS and mj.opt.disableactuator >> group & 1:
                continue
            if reason := self._strange_actuator(number):
                self.left_out.append(f'{reason} of the actuator "{name}"')
                mj.actuator_biasprm[number], mj.actuator_gainprm[number] = 0.0, 0.0
                mj.actuator_biastype[number] = mj.actuator_gaintype[number] = 0
                continue
            at = int(mj.actuator_outadr[number]) if hasattr(mj, "actuator_outadr") else number
            p, d = (float(value * mj.actuator_gear[at][0] ** 2) for value in self._feedback(number))
            if not (p or d):
                idle.append(name)
                continue
            to = int(mj.actuator_trnid[number][0])
            if self._target(number) != "TENDON":
                before = gains.get(self.joints[to], (0.0, 0.0))
                gains[self.joints[to]] = (before[0] + p, before[1] + d)
            else:
                self.control.append(Tendon(name, *self._path(to), stiffness=(p,), rest=None, damping=d))
        if idle:
            self.notes.append(f"actuators without feedback exert no force: {_some(idle)}")
        for joint, (p, d) in gains.items():
            if min(p, d) < 0:
                self.control.append(Tendon(f"control of {joint}", {joint: 1.0}, stiffness=(p,), rest=None, damping=d))
            else:
                self.file.motors[joint] = Motor(position_gain=p, velocity_gain=d)

    def _target(self, number: int) -> str:
        return _kinds("mjtTrn")[self.mj.actuator_trntype[number]]

    def _feedback(self, number: int) -> np.ndarray:
        """Gains of position and velocity at the actuator."""
        is_affine = _kinds("mjtBias")[self.mj.actuator_biastype[number]] == "AFFINE"
        return -self.mj.actuator_biasprm[number][1:3] * is_affine

    def _strange_actuator(self, number: int) -> str:
        """Unread settings of an actuator with stiffness or damping; empty without any."""
        mj = self.mj
        bias = _kinds("mjtBias")[mj.actuator_biastype[number]]
        gain = _kinds("mjtGain")[mj.actuator_gaintype[number]]
        if mj.actuator_plugin[number] >= 0:
            return "the plugin"
        if bias not in ("NONE", "AFFINE") or gain not in ("FIXED", "AFFINE"):
            return f"the kind {(gain if gain not in ('FIXED', 'AFFINE') else bias).lower()}"
        if not self._feedback(number).any():
            return ""
        target, to = self._target(number), int(mj.actuator_trnid[number][0])
        if target in ("JOINT", "JOINTINPARENT"):
            kind = _kinds("mjtJoint")[mj.jnt_type[to]]
            return "" if kind in ("HINGE", "SLIDE") else f"the gains at a {kind.lower()} joint"
        if target == "TENDON":
            return "" if self._path(to) is not None else "the gains along a tendon around a geom"
        return f"the gains by {target.lower()}"

    def _lifted(self) -> list[int]:
        """Bodies whose weight is compensated."""
        compensated = np.any(self.mj.body_gravcomp) and np.any(getattr(self.mj, "jnt_actgravcomp", False))
        if compensated and (_flag(self.mj, "ACTUATION") or not len(self.mj.actuator_trntype)):
            self.left_out.append("compensation of gravity by actuators that are not there or disabled")
            self.comparable = False
        off = _flag(self.mj, "GRAVITY") or (_flag(self.mj, "SPRING") and _flag(self.mj, "DAMPER"))
        moving = (joint for joint, _ in self.places)
        return [] if off else [i for i, joint in enumerate(moving) if joint and self.mj.body_gravcomp[i] * self.mj.body_mass[i]]

    def _states(self) -> Iterator[tuple[str, np.ndarray]]:
        """Key frames, and the configuration of the file as "reference", without the coordinates of a base that was added."""
        mj = self.mj
        yield "reference", self.configuration(mj.qpos0)
        for number, name in enumerate(_names(mj, "key", mj.nkey)):
            yield name or f"key {number}", self.configuration(mj.key_qpos[number])

    def configuration(self, qpos: np.ndarray) -> np.ndarray:
        """q of pinocchio, whose quaternions are x, y, z, w."""
        q = [np.array([0, 0, 0, 0, 0, 0, 1.0])] if self.added_base else []
        return np.concatenate([*q, np.array(qpos)[quaternion_places(self.mj)]])

    def _others(self) -> None:
        """Notices on the other parts of the model that have stiffness, mass or coupling."""
        mj, left, notes = self.mj, self.left_out, self.notes
        plugins = np.flatnonzero(np.array(mj.body_plugin) >= 0)
        left += [f"the plugin of {_some([self.bodies[body] for body in plugins])}"] * bool(len(plugins))
        left += [f"the elasticity of the flex {_some(_names(mj, 'flex', mj.nflex))}"] * bool(mj.nflex)
        self.comparable &= not (len(plugins) or mj.nflex)
        passive = not (_flag(mj, "SPRING") and _flag(mj, "DAMPER"))
        if mj.opt.viscosity and passive:
            left.append(f"the viscosity {mj.opt.viscosity:g} Pa s of the medium, which damps")
        if mj.opt.density and passive:
            adds_mass = bool(_rows(mj, "geom_fluid", mj.ngeom)[:, 0].any())
            effect = "added masses" if adds_mass else "the drag of its wind" if np.any(mj.opt.wind) else "its drag is not linear"
            doubtful = adds_mass or np.any(mj.opt.wind)
            (left if doubtful else notes).append(f"the density {mj.opt.density:g} kg/m^3 of the medium: {effect}")
        mj.opt.density = mj.opt.viscosity = 0.0
        if mj.nmocap:
            notes.append(f"{mj.nmocap} mocap {'bodies rest' if mj.nmocap > 1 else 'body rests'} where the file has them")
        yields = [name for name, limit in zip(self.joints, _rows(mj, "jnt_springyield", mj.njnt)) if limit]
        yields += [n for n, limit in zip(self._tendon_names(), _rows(mj, "tendon_springyield", mj.ntendon)) if limit]
        if yields:
            notes.append(f"springs that yield are linear here: {_some(yields)}")
        limited = [name for name, limit in zip(self._tendon_names(), mj.tendon_limited) if limit]
        if limited:
            notes.append(f"limits of tendons are not in the equations: {_some(limited)}")
        curved = np.flatnonzero(_polynomials(mj, "dof_damping", mj.nv)[:, 1:].any(axis=1))
        if len(curved):
            notes.append(
                f"of polynomial damping the linear part is read: {_some(dict.fromkeys(self.joints[mj.dof_jntid[dof]] for dof in curved))}"
            )


#: Geoms that are not drawn: planes without end and height fields.
_UNDRAWN = ("PLANE", "HFIELD")


def _on_one_branch(model, tendon: Tendon) -> bool:
    """Whether all joints that change the length of a tendon move the same body."""
    frames = {str(frame.name): int(frame.parentJoint) for frame in model.frames}
    moving = {int(model.getJointId(name)) for name in tendon.joints}
    for line in tendon.segments:
        ends = [set(model.supports[frames.get(body, 0)]) for body in (line.body1, line.body2)]
        moving |= ends[0] ^ ends[1]
    return any(moving <= set(support) for support in model.supports)


def geom_kind(mj, geom: int) -> str:
    """BOX, SPHERE, ..., PLANE."""
    return _kinds("mjtGeom")[mj.geom_type[geom]]


def quaternion_places(mj) -> np.ndarray:
    """The places in qpos, which has quaternions w, x, y, z, of the numbers of pinocchio's q."""
    places, kinds = np.arange(mj.nq), _kinds("mjtJoint")
    for number, at in enumerate(mj.jnt_qposadr):
        if kinds[mj.jnt_type[number]] in ("FREE", "BALL"):
            start = at + 3 * (kinds[mj.jnt_type[number]] == "FREE")
            places[start : start + 4] = start + np.array([1, 2, 3, 0])
    return places


@lru_cache
def _kinds(enum: str) -> dict[int, str]:
    """Names of the members of an enumeration of MuJoCo by number, without their common prefix, such as mjJNT_."""
    import mujoco

    return {int(member): name.partition("_")[2] for name, member in getattr(mujoco, enum).__members__.items()}


def _distinct(name: str, used: set[str]) -> str:
    """The name, with a number where it is used already."""
    candidates = (name, *(f"{name} {number}" for number in range(2, len(used) + 3)))
    chosen = next(candidate for candidate in candidates if candidate not in used)
    used.add(chosen)
    return chosen


def _some(names) -> str:
    return listed([short(name) for name in names], MOST_NAMED)


def _add_link(model, name: str, joint: int, place) -> None:
    import pinocchio

    model.addFrame(pinocchio.Frame(name, joint, 0, place, pinocchio.FrameType.BODY), False)


def _rotation(quaternion) -> np.ndarray:
    import pinocchio

    w, x, y, z = (float(part) for part in quaternion)
    return pinocchio.Quaternion(w, x, y, z).normalized().toRotationMatrix()


def pose(position, quaternion):
    """The placement of a position and a quaternion w, x, y, z."""
    import pinocchio

    return pinocchio.SE3(_rotation(quaternion), np.array(position, dtype=float))
