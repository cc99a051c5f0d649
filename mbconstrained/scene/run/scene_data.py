"""Data of a scene: its tables and equations, with notices, before anything is solved."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np
from pydantic import BaseModel

from ...ground.checks import counted, listed
from ...ground.display import Pictured
from ...ground.errors import InputError
from ...ground.notices import Notice, NoticeKind
from ...ground.tolerances import EPS, noise_of
from ...mechanics.element_matrix import ElementMatrix
from ...response.choose import Method, Request, choose
from ...response.problem import Problem
from ..build.model import End, Equations
from ..build.switched import never_notices, refuse_with_switches
from ..file import SceneFolder, SceneName, Setting, file_part
from ..parameters import Parameters
from .plan import Cost

if TYPE_CHECKING:
    from ...mechanics.parameter import Parameter
    from ...mechanics.system import MechanicalSystem


#: Entries of [output] of a scene that writes nothing.
UNWRITTEN: dict[str, Any] = {"page": False, "csv": False, "npz": False, "plot_images": False, "still": None}


@dataclass(frozen=True, repr=False)
class SceneData(Pictured):
    """Data of a ``Scene``, without the answers to questions about it; its attributes.

    Attributes:
        plan, named_parameters: as of ``Scene``.
        phase_notices: the phase that the equations are those of, where the model switches.
        data_folders: folders besides its own from which data files may be read.
    """

    plan: ClassVar[Callable[..., Any]]
    named_parameters: ClassVar[Callable[..., Iterator[Parameter]]]

    path: Path
    table: Any  # SceneTable: pydantic is imported late
    equations: Equations
    unit_texts: int
    costs: dict[str, Cost]
    parameters: Parameters = Parameters()
    settings: tuple[Setting, ...] = ()
    file_name: SceneName = SceneName("")
    phase_notices: tuple[Notice, ...] = ()
    data_folders: tuple[Path, ...] = ()

    def _summary(self) -> str:
        return f"{self.name}: {self.title}" if self.title else self.name

    @property
    def name(self) -> str:
        """Name of the file without its ending, with the values set from outside; results are named after it."""
        return ".".join([self.path.stem, *([file_part(self.settings)] if self.settings else [])])

    @property
    def folder(self) -> SceneFolder:
        """Where its data files are."""
        return SceneFolder(self.path.parent, self.data_folders)

    @property
    def files_read(self) -> frozenset[Path]:
        """Resolved paths of the scene and of its data files."""
        files, values = {self.path.resolve()}, [self.table.model, self.table.force, self.table.motion, self.table.random]
        while values:
            value = values.pop()
            if isinstance(value, list):
                values += value
            elif isinstance(value, BaseModel):
                values += vars(value).values()
                if isinstance(name := getattr(value, "file", None), str):
                    files.add((self.path.parent / name).resolve())
        return frozenset(files)

    @property
    def times(self) -> np.ndarray:
        """The times of the scene, shape (T,), in s."""
        return self.table.time.times

    @property
    def title(self) -> str:
        """Title in the file, by default the name."""
        return self.table.title or self.path.stem

    @property
    def heading(self) -> str:
        """Title with the values set from outside."""
        overrides = ", ".join(map(str, self.settings))
        return f"{self.title}, with {overrides}" if overrides else self.title

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Notices before a run: overrides, unused parameters, unconstrained bodies."""
        fixed = self.equations.system is not None and self.equations.switching is None
        kind = self.table.model.kind
        has_elements = fixed and kind in ("lumped", "matrices")
        free = free_motion_notices(self.equations.system) if has_elements else ()
        given = (
            *self.parameters.notices,
            *(_late_loads(self.table) if self.table.force else ()),
            *(never_notices(self.equations.switching) if self.equations.switching else ()),
            *(notice for end in self.equations.ends for notice in (*_late_end(end, self.table.time), *end.notices)),
            *(self.equations.solvability.notices if self.equations.solvability else ()),
            *(_matrix_notices(self.equations.system) if kind == "matrices" else _assumed_lengths(self.table.model)),
        )
        missing = self.equations.mesh_notices if self.table.output.page and self.table.output.animation else ()
        return (*self.phase_notices, *(setting.notice for setting in self.settings), *given, *free, *missing)

    @cached_property
    def method(self) -> Method:
        """The method that gives the response at the times of the scene."""
        if self.equations.switching is not None:
            return self.equations.switching.begin.method
        return choose(self.problem, Request(times=self.table.time.times))

    @cached_property
    def problem(self) -> Problem:
        """A(d/dt) x = f with the values at 0-."""
        equations = self.equations
        system = equations.system
        delayed = system.delayed_equations() if system is not None and system.delayed else ()
        return Problem(equations.polynomial_matrix, equations.initial, equations.right_hand_side, delayed=delayed)

    def certified(self) -> Self:
        """The scene with certify = true, unless it states what to certify."""
        output = self.table.output
        certified = self.with_output(certify=output.certify or output.coordinates or True)
        if self.equations.switching is not None:
            refuse_with_switches(certified.table, (), self.file_name)
        return certified

    def in_phase(self) -> Self:
        """The scene with the equations of one phase alone, as linear analyses take it."""
        if (switching := self.equations.switching) is None:
            return self
        return replace(self, equations=replace(self.equations, switching=None), phase_notices=(switching.notice,))

    def with_still(self, time: float) -> Self:
        """The scene with a still picture of its model at a time within the run, in s."""
        start, end = self.table.time.start, self.table.time.end
        if not start <= time <= end:
            raise InputError(f"still picture: found {time:g} s; expected a time from {start:g} to {end:g} s, where the scene ends")
        return self.with_output(still=float(time))

    def with_output(self, **changes) -> Self:
        """The scene with other entries of [output]."""
        output = self.table.output.model_copy(update=changes)
        return replace(self, table=self.table.model_copy(update={"output": output}))


def _late_loads(table) -> Iterator[Notice]:
    """A notice for each force that begins after the last time."""
    for number, load in enumerate(table.force, 1):
        first = getattr(load, "start", 0.0) if load.kind == "pulse" else 0.0
        times = getattr(load, "times", None)
        begin = load.later + (times[0] if times else first)
        if table.time.is_given and begin > table.time.end:
            text = f"it begins at {begin:g} s, after the last time, {table.time.end:g} s, and has no effect before"
            yield Notice(NoticeKind.OMITTED, f'force[{number}] on "{load.title}": {text}')


def _late_end(end: End, time) -> Iterator[Notice]:
    """A notice where the times do not reach the end."""
    if time.is_given and end.duration > time.end:
        text = f"{end.key}: T is {end.duration:g} s, after the last time, {time.end:g} s, and is not shown"
        yield Notice(NoticeKind.OMITTED, text)


#: Elements that a notice lists.
MOST_NAMED = 5


def _assumed_lengths(model) -> Iterator[Notice]:
    """Springs without a rest length next to some that have one: coordinates are positions, and these springs contract to 0."""
    for key, entry, unit in (("spring", "rest_length", "m"), ("torsion_spring", "rest_angle", "rad")):
        springs = list(enumerate(getattr(model, key, ()), 1))
        if not any(getattr(spring, entry) for _, spring in springs):
            continue
        without = [spring.name or f"{key}[{number}]" for number, spring in springs if entry not in spring.model_fields_set]
        if without:
            text = f"no {entry} is given, while others have one: 0 {unit} is taken"
            yield Notice(NoticeKind.OMITTED, f"{listed(without, MOST_NAMED)}: {text}")


def _matrix_notices(system: MechanicalSystem | None) -> Iterator[Notice]:
    """Notices on matrices that differ from those of a passive structure: unsymmetric, or M with a negative eigenvalue."""
    if system is None or system.is_sparse:
        return
    for name in ("mass", "stiffness"):
        yield from system.unsymmetric(name)
    M = (system.mass + system.mass.T) / 2
    sizes = np.sqrt(np.abs(np.diag(M)))
    scaled = M / np.outer(np.where(sizes > 0, sizes, 1.0), np.where(sizes > 0, sizes, 1.0))
    least = float(np.linalg.eigvalsh(scaled)[0])
    if least < -noise_of(np.abs(scaled).max(), len(M)):
        text = "the mass matrix is not positive semidefinite: some motion has a negative kinetic energy, which is impossible for a passive structure"
        yield Notice(NoticeKind.UNSTABLE, text)


# Rigid-body modes from the elements: coordinates that no spring, damper or constraint row restrains.

#: Beyond this ratio of its entries a matrix may have lost a soft spring, so that nothing is said of what it holds.
WIDEST_MATRIX = EPS**-0.5
MOST_NAMES = 8
LARGEST_LISTED = 200  # coordinates: larger models show rigid-body modes in their eigenvalues, which a run computes


def free_motion_notices(system: MechanicalSystem) -> tuple[Notice, ...]:
    """Notices on unconstrained groups of coordinates that move together: the rigid-body modes visible in the elements.

    None for large models, and none where a matrix may have lost digits.

    >>> from mbconstrained import LumpedModel
    >>> model = LumpedModel()
    >>> _ = model.mass("cart", 3.0), model.mass("load", 1.0), model.spring("cart", "load", 1.0)
    >>> print(free_motion_notices(model.assemble())[0].text)
    cart and load: unconstrained; they can move freely together, a rigid-body mode
    """
    if system.size > LARGEST_LISTED:
        return ()
    stiffness, damping, _ = system.given
    rows_of_elements = [_directions(stiffness), _directions(damping), system.constraint_matrix]
    if any(rows is None for rows in rows_of_elements):
        return ()
    rows = np.vstack(rows_of_elements)
    _, sizes, right = np.linalg.svd(rows, full_matrices=True)
    null = right[int((sizes > noise_of(sizes.max(initial=0.0), max(rows.shape))).sum()) :]
    if not len(null):
        return ()
    free = null.T @ null  # the orthogonal projection onto the null space of the rows
    groups = ((group, round(float(free[group, group].sum()))) for group in _groups(free))  # the trace of a projection is its rank
    return tuple(_free_notice([system.names[i] for i in group], count) for group, count in groups)


def _directions(given: np.ndarray | ElementMatrix) -> np.ndarray | None:
    """Directions of elements or matrix rows, each of unit size; None where digits are lost."""
    if isinstance(given, ElementMatrix):
        rows = given.directions[given.constants != 0]
    else:
        sizes = np.abs(given[given != 0])
        if sizes.size and sizes.max() > WIDEST_MATRIX * sizes.min():
            return None
        rows = given
    lengths = np.abs(rows).max(axis=1, initial=0.0)
    return rows[lengths > 0] / lengths[lengths > 0, None]


def _groups(free: np.ndarray) -> list[np.ndarray]:
    """Coordinates that move together."""
    from scipy.sparse.csgraph import connected_components

    moving = np.abs(free) > EPS**0.5
    _, labels = connected_components(moving, directed=False)
    groups = [np.flatnonzero(labels == label) for label in dict.fromkeys(labels)]
    return [group for group in groups if moving[group[0], group[0]]]


def _free_notice(names: list[str], count: int) -> Notice:
    shown = names if len(names) <= MOST_NAMES else [*names[: MOST_NAMES - 1], f"{len(names) - MOST_NAMES + 1} more"]
    listed = " and ".join(filter(None, [", ".join(shown[:-1]), shown[-1]]))
    who = "it can move freely" if len(names) == 1 else "they can move freely together"
    what = "a rigid-body mode" if count == 1 else counted(count, "rigid-body mode")
    return Notice(NoticeKind.RIGID_BODY, f"{listed}: unconstrained; {who}, {what}")
