"""Rotors of a lumped model, in two planes across the shaft: rigid rotors, bearings with cross coupling, unbalance.

What is called "disc" has the displacements "disc y" and "disc z"; the shaft turns from y to z. Positions along the shaft are distances
from the centre of mass.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar

import numpy as np

from ..ground.checks import counted, real_array
from ..ground.errors import InputError, named
from ..ground.quantities import quantity
from ..ground.tolerances import noise_of
from ..ground.units import GROUND
from ..mechanics.element_matrix import ElementMatrix, SpeedTable, unbalance_of
from .elements import Damper, Element, Joins, Mass, Numeric, Real, RigidBar, Spring, fields_of, unchecked, with_parts

#: A number for both planes y and z, two of them, a matrix (2, 2), or a list of these with one for each speed of a table.
PlaneValues = Any

#: The planes through the shaft, in the order in which it turns.
PLANES = ("y", "z")


def in_planes(name: str) -> tuple[str, str]:
    """The displacements of a point in both planes, as "disc y" and "disc z"; the ground has none."""
    y, z = (GROUND if name == GROUND else f"{name} {plane}" for plane in PLANES)
    return y, z


@dataclass(frozen=True)
class Rotor(Element):
    """A rigid rotor at a constant speed W: a rigid bar in each plane, coupled by gyroscopic moments.

    With the tilts a in the plane y and b in z

        J_d a'' + W J_p b' = sum of moments,  J_d b'' - W J_p a' = sum of moments.

    Its coordinates are "NAME y" and "NAME z" and, where it has moments of inertia, "NAME y angle" and "NAME z angle" and those of its
    points, "POINT y" and "POINT z" (``RigidBar``). Gravity acts along z.

    Example:
        A disc on springs whirls with the frequencies of k - w^2 J_d +- w W J_p = 0.

        >>> from mbconstrained import LumpedModel
        >>> model = LumpedModel()
        >>> _ = model.rotor("disc", 2.0, diametral_inertia=1.0, polar_inertia=1.5, points={"left": -1.0, "right": 1.0})
        >>> for point in ("left", "right"):
        ...     _ = model.bearing("ground", point, stiffness=2.0)
        >>> model.assemble().critical_speeds().round(9).tolist()  # sqrt(4 / 2) twice, sqrt(4 / (1 + 1.5))
        [1.264911064, 1.414213562, 1.414213562]
    """

    name: Annotated[str, 'Its centre of mass has the coordinates "NAME y", "NAME z", its tilts "NAME y angle", "NAME z angle".'] = (
        field()
    )
    mass: Annotated[Real, Numeric("kg", "Its mass.", "positive")]
    diametral_inertia: Annotated[
        Real, Numeric("kg*m^2", "J_d about an axis across the shaft; left out: a mass that does not tilt.", "positive")
    ] = None
    polar_inertia: Annotated[
        Real, Numeric("kg*m^2", "J_p about the shaft, at most twice the diametral one.", "nonnegative", varied=False)
    ] = 0.0
    points: Annotated[
        Mapping[str, Real],
        Numeric("m", 'Points with their distances from the centre of mass along the shaft; each has "POINT y" and "POINT z".'),
    ] = field(default_factory=dict)

    has_coordinates = True

    def __post_init__(self):
        super().__post_init__()
        if self.diametral_inertia is None and (self.polar_inertia or self.points):
            what = "a polar inertia" if self.polar_inertia else "points"
            raise InputError(f"{self.label}: found {what} without a diametral inertia; give it, or leave both out")
        if self.diametral_inertia is not None and self.polar_inertia > 2 * self.diametral_inertia * (1 + noise_of(1.0)):
            raise InputError(
                f"{self.label}: polar inertia {self.polar_inertia:g} kg m^2 is more than twice the diametral one, "
                f"{self.diametral_inertia:g} kg m^2, which no body has; are they swapped?"
            )
        if not isinstance(self.points, Mapping):
            raise InputError(f'{self.label}: points: expected distances by name, such as {{"left": -0.2, "right": 0.3}}')
        object.__setattr__(self, "points", self._numbers("points", 'distance of "{}"'))

    @property
    def weighing(self) -> Mapping[str, float]:  # type: ignore[override]  # constant in other classes
        """Mass of the rotor, along z."""
        return {in_planes(self.name)[1]: self.mass}

    @property
    def parts(self) -> tuple[Element, ...]:  # type: ignore[override]
        """The masses or bars in both planes, with their own parts."""
        if self.diametral_inertia is None:
            return tuple(unchecked(Mass, name=name, mass=self.mass) for name in in_planes(self.name))
        planes = zip(in_planes(self.name), PLANES)
        points = [{f"{point} {plane}": value for point, value in self.points.items()} for plane in PLANES]
        bars = (
            unchecked(RigidBar, name=name, mass=self.mass, inertia=self.diametral_inertia, points=own)
            for (name, _), own in zip(planes, points)
        )
        return with_parts(bars)

    @property
    def tilts(self) -> tuple[str, str]:
        """Names of its angles in both planes, where it tilts."""
        y, z = (f"{name} angle" for name in in_planes(self.name))
        return y, z


@dataclass(frozen=True)
class Bearing(Element):
    """A bearing, seal or shaft between two points: the force -K r - C r' on the end, r = (y, z) the displacements relative to the start."""

    start: Annotated[str, Joins('A rotor, a point of it, or "ground".', None)]
    end: Annotated[str, Joins("The other one.", None)]
    stiffness: Annotated[
        PlaneValues,
        Numeric("N/m", "K: one stiffness, [K_yy, K_zz], or [[K_yy, K_yz], [K_zy, K_zz]], not necessarily symmetric (oil films)."),
    ] = 0.0
    damping: Annotated[PlaneValues, Numeric("N*s/m", "C, likewise.")] = 0.0
    speeds: Annotated[
        Sequence[Real] | None,
        Numeric("rad/s", "Speeds of a table, ascending; stiffness and damping then have an entry for each, linear in between."),
    ] = None

    spellings: ClassVar = {"between": ("start", "end")}
    end_count = 3

    def __post_init__(self):
        super().__post_init__()
        for name in ("stiffness", "damping", "speeds"):
            with named(f"{self.label}: {name}"):
                object.__setattr__(self, name, in_si(getattr(self, name), fields_of(Bearing).entries[name].about.unit))
        if self.speeds is not None:
            speeds = real_array(self.speeds, f"{self.label}: speeds", shape=(None,))
            if len(speeds) < 2 or not (np.diff(speeds) > 0).all():
                shown = ", ".join(f"{speed:g}" for speed in speeds[:6])
                raise InputError(f"{self.label}: speeds: found {shown}; expected two or more, ascending, in rad/s")
        if not (self.matrices("stiffness").any() or self.matrices("damping").any()):
            raise InputError(f"{self.label}: found neither stiffness nor damping; give at least one of them")

    @property
    def ends(self) -> dict[str, str | None]:
        """The displacements of both ends in both planes; "ground" has none."""
        return {name: None if name == GROUND else "m" for end in (self.start, self.end) for name in in_planes(end)}

    def matrices(self, what: str) -> np.ndarray:
        """Stiffness or damping matrices, one for each speed of a table, else a single one, shape (S, 2, 2)."""
        value, what = getattr(self, what), f"{self.label}: {what}"
        if self.speeds is None:
            return _matrix(value, what)[None]
        if isinstance(value, (int, float)) and not value:
            return np.zeros((len(self.speeds), 2, 2))
        if not isinstance(value, (Sequence, np.ndarray)) or len(value) != len(self.speeds):
            entries = counted(len(value), "entry", "entries") if isinstance(value, (Sequence, np.ndarray)) else f"{value!r}"
            raise InputError(f"{what}: found {entries}; expected {len(self.speeds)}, one for each of the speeds")
        return np.array([_matrix(entry, f"{what} at {speed:g} rad/s") for speed, entry in zip(self.speeds, value)])

    @property
    def parts(self) -> tuple[Element, ...]:  # type: ignore[override]
        """Springs and dampers in both planes; for a table those of its first speed."""
        parts = []
        for kind, what in ((Spring, "stiffness"), (Damper, "damping")):
            values = np.diag(self.matrices(what)[0]).tolist()
            for plane, value, start, end in zip(PLANES, values, in_planes(self.start), in_planes(self.end)):
                if value > 0:
                    parts.append(unchecked(kind, name=f"{self.name} {what} {plane}", start=start, end=end, **{what: value}))
        return tuple(parts)

    def coupling(self, what: str) -> np.ndarray:
        """The part of ``matrices`` that springs or dampers do not represent, shape (S, 2, 2)."""
        matrices = self.matrices(what)
        return matrices - np.diag(np.maximum(np.diag(matrices[0]), 0.0))


def in_si(value, unit: str):
    """Numbers in SI in place of texts with a unit, in lists too."""
    if isinstance(value, (list, tuple)):
        return [in_si(entry, unit) for entry in value]
    return quantity(value, unit) if isinstance(value, str) else value


def _matrix(value, what: str) -> np.ndarray:
    entries = real_array(value, what)
    if entries.shape not in ((), (2,), (2, 2)):
        raise InputError(f"{what}: expected a number, two of the planes y and z, or two rows of two numbers")
    return entries if entries.ndim == 2 else np.diag(np.broadcast_to(entries, 2))


@dataclass(frozen=True)
class Unbalance(Element):
    """An eccentric mass: the force moment W^2 (cos(W t + angle), sin(W t + angle)) in y and z."""

    on: Annotated[str, Joins("The rotor, or a point of it.", None)]
    moment: Annotated[Real, Numeric("kg*m", "Mass times eccentricity.", "nonnegative", varied=False)]
    angle: Annotated[Real, Numeric("rad", "From y towards z at t = 0.", varied=False)] = 0.0

    end_count = 2

    @property
    def ends(self) -> dict[str, str | None]:
        """Both displacements of its point; "ground" is not allowed."""
        if self.on == GROUND:
            raise InputError(f'{self.label}: "ground" does not turn; name a rotor or a point of one')
        return dict.fromkeys(in_planes(self.on), "m")


@dataclass(frozen=True, eq=False)
class RotorTerms:
    """Contributions of rotors, bearings and unbalance to the equations of a model with n coordinates."""

    gyroscopic: np.ndarray  # G, shape (n, n)
    whirl: np.ndarray  # masses between y and z, diametral inertias between the tilts, skew-symmetric, shape (n, n)
    stiffness: np.ndarray  # the parts that springs and dampers do not represent, shape (n, n)
    damping: np.ndarray
    tables: tuple[SpeedTable, ...]  # bearings whose coefficients change with the speed
    unbalance: np.ndarray  # u of the force W^2 Re(u e^{i W t}), complex, in kg m, shape (n,)

    def added_to(self, elements: ElementMatrix, what: str) -> ElementMatrix | np.ndarray:
        """The matrix of springs or dampers plus ``stiffness`` or ``damping``."""
        further = getattr(self, what)
        return elements.matrix + further if further.any() else elements


def rotor_terms(elements: Sequence[Element], names: Sequence[str]) -> RotorTerms | None:
    own = [element for element in elements if isinstance(element, (Rotor, Bearing, Unbalance))]
    if not own:
        return None
    place = {name: i for i, name in enumerate(names)}
    n = len(names)
    G, S, K, C = np.zeros((4, n, n))
    u = np.zeros(n, dtype=complex)
    tables = []
    for one in own:
        if isinstance(one, Rotor):
            S += one.mass * _turn(in_planes(one.name), place)
            if one.diametral_inertia is not None:
                tilt = _turn(one.tilts, place)
                S, G = S + one.diametral_inertia * tilt, G + one.polar_inertia * tilt
        elif isinstance(one, Bearing):
            stiffness, damping = (_spread(one, one.coupling(what), place) for what in ("stiffness", "damping"))
            K, C = K + stiffness[0], C + damping[0]
            if one.speeds is not None:
                tables.append(SpeedTable(one.name, np.array(one.speeds), stiffness - stiffness[0], damping - damping[0]))
        elif isinstance(one, Unbalance):
            y, z = (place[name] for name in in_planes(one.on))
            u += unbalance_of(y, z, one.moment, one.angle, n)
    return RotorTerms(G, S, K, C, tuple(tables), u)


def _turn(planes: tuple[str, str], place: Mapping[str, int]) -> np.ndarray:
    """1 in the row of the first plane and the column of the second, -1 in the other, shape (n, n)."""
    turn = np.zeros((len(place),) * 2)
    y, z = (place[name] for name in planes)
    turn[y, z], turn[z, y] = 1.0, -1.0
    return turn


def _spread(bearing: Bearing, matrices: np.ndarray, place: Mapping[str, int]) -> np.ndarray:
    """B^T k B of matrices k of relative displacements, shape (S, n, n)."""
    B = np.zeros((2, len(place)))
    for names, sign in ((in_planes(bearing.start), -1.0), (in_planes(bearing.end), 1.0)):
        for row, name in zip(B, names):
            if name != GROUND:
                row[place[name]] = sign
    return B.T @ matrices @ B
