"""Rotors at constant speed W, M x'' + (C + W G) x' + (K + W N) x = f: Campbell diagrams, critical speeds, limits of stability.

Sources: Genta, Dynamics of Rotating Systems (2005), chapters 3 and 4; Friswell, Penny, Garvey and Lees, Dynamics of Rotating Machines
(2010), chapter 6.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import pairwise, product
from typing import TypeVar

import numpy as np
import scipy

from ..ground.checks import counted, real_number
from ..ground.display import Displayed, TextTable, number_text
from ..ground.errors import InputError
from ..ground.named_arrays import named_array
from ..ground.threads import short_work
from ..ground.tolerances import EPS, NEWTON_STEP, noise_of
from ..linalg.arrays import block_diag
from ..polynomial.variation import FamilyPart, MatrixFamily, followed, located, refined_values, stability_limits
from .equations import EquationsOfMotion
from .harmonic_sums import complex_amplitudes
from .parameter import Parameter, ascending

# The equations of a rotor at constant speed W, M x'' + (C + W G) x' + (K + W N) x = f, with speed-dependent bearings.

Rotor = TypeVar("Rotor", bound=EquationsOfMotion)


def at_speed(system: Rotor, speed: float) -> Rotor:
    speed = real_number(speed, "speed")
    check_rotor(system)
    check_speeds(system, speed)
    stiffness, damping, mass = system.given
    result, rest = copy(system), (system.stiffness, system.damping)
    now, slope = rotor_matrices(system, speed)
    if (now[0] != rest[0]).any():
        result.stiffness = stiffness = system._matrix(now[0], "stiffness", system.size)
    if (now[1] != rest[1]).any():
        result.damping = damping = system._matrix(now[1], "damping", system.size)
    result.given, result._forms = (stiffness, damping, mass), {}
    result.gyroscopic = result.circulatory = result.unbalance = None
    result.speed_tables = ()
    own = Parameter("speed", speed, stiffness=slope[0], damping=slope[1], unit="rad/s")
    result.parameter_source = partial(_parameters_at_speed, system, own)
    return result


def _parameters_at_speed(system: EquationsOfMotion, speed: Parameter) -> tuple[Parameter, ...]:
    return (*system.parameters(), speed)


def check_rotor(system: EquationsOfMotion) -> None:
    """Raise an InputError unless the system depends on a speed."""
    if not system.turns:
        raise InputError(
            "speed: this system does not depend on a speed of rotation; give MechanicalSystem(..., gyroscopic=G) or circulatory=N, "
            "or a rotor of a lumped model"
        )


def check_speeds(system: EquationsOfMotion, *speeds: float) -> None:
    """Raise an InputError unless the system has dense arrays, and bearings at these speeds."""
    system._refuse_sparse("rotation")
    for table, speed in product(system.speed_tables, speeds):
        low, high = table.speeds[[0, -1]]
        if not low <= speed <= high:
            raise InputError(
                f'speed: found {speed:g} rad/s; the table of the bearing "{table.name}" is from {low:g} to {high:g} rad/s, '
                "and is not continued beyond"
            )


def rotor_matrices(system: EquationsOfMotion, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """K, C and M at a speed, and their derivatives with respect to it, each of shape (3, n, n)."""
    zero = np.zeros((system.size,) * 2)
    slope = np.array([zero if matrix is None else matrix for matrix in (system.circulatory, system.gyroscopic, None)])
    total = np.array([system.stiffness, system.damping, system.mass]) + speed * slope
    for table in system.speed_tables:
        total[:2] += table.at(speed)
        slope[:2] += table.slope(speed)
    return total, slope


def speed_ranges(system: EquationsOfMotion) -> list[tuple[float, float]]:
    """The intervals in which the matrices are linear in the speed: all speeds without tables, else those that all tables cover."""
    if not system.speed_tables:
        return [(0.0, np.inf)]
    low, high = (pick(table.speeds[end] for table in system.speed_tables) for pick, end in ((max, 0), (min, -1)))
    return [(a, b) for a, b in pairwise(_knots(system)) if low <= a and b <= high]


def _knots(system: EquationsOfMotion) -> np.ndarray:
    return np.unique([speed for table in system.speed_tables for speed in table.speeds])


def rotor_family(system: EquationsOfMotion, within: float | None = None) -> tuple[MatrixFamily, np.ndarray]:
    """The equations over the speed, in coordinates that satisfy all constraint rows."""
    check_speeds(system)
    V = system.position_form().null_space
    if not V.shape[1]:
        raise InputError("nothing is free to vibrate: constraint rows and prescribed motions give every coordinate")

    def reduced(matrices: np.ndarray) -> np.ndarray:
        return V.T @ matrices @ V

    if within is not None or not system.speed_tables:
        at = within or 0.0
        now, slope = rotor_matrices(system, at)
        return MatrixFamily.linear(reduced(now - at * slope), reduced(slope)), V
    knots = _knots(system)
    pattern = (np.array([reduced(rotor_matrices(system, knot)[0]) for knot in knots]) != 0).any(axis=(0, 1))
    return MatrixFamily(
        lambda W: reduced(rotor_matrices(system, W)[0]), lambda W: reduced(rotor_matrices(system, W)[1]), pattern, knots
    ), V


@dataclass(frozen=True, repr=False, eq=False)
class CriticalSpeed(Displayed):
    """A speed at which an excitation of the order n is in resonance with a mode.

    Attributes:
        speed: W in rad/s.
        order: n.
        eigenvalue: s with Im s = n W (1/s).
        shape: shape of the mode at this speed, shape (n,), the largest entry 1.
        whirl: see ``Campbell.whirl``.
    """

    speed: float
    order: float
    eigenvalue: complex
    shape: np.ndarray = field(repr=False)
    whirl: float

    @property
    def damping_ratio(self) -> float:
        """-Re s / |s|."""
        return -self.eigenvalue.real / abs(self.eigenvalue) + 0.0

    def _summary(self) -> str:
        return f"{self.speed:.6g} rad/s, order {self.order:g}, {direction(self.whirl)}, damping ratio {self.damping_ratio:.4g}"


@dataclass(frozen=True, repr=False, eq=False)
class Campbell(Displayed):
    """Eigenvalues over the speed of rotation; a column belongs to one mode at all speeds.

    Attributes:
        system: the rotor at rest.
        speeds: W in rad/s, shape (S,).
        eigenvalues: s in 1/s, of complex pairs the one above the real axis, shape (S, m); one for each real one.
        slopes: ds/dW, shape (S, m).
        shapes: shapes of the modes, shape (S, n, m), the largest entry of each 1.
        evaluations: at how many speeds eigenvalues were computed, the given ones included.
    """

    system: EquationsOfMotion
    speeds: np.ndarray
    eigenvalues: np.ndarray
    slopes: np.ndarray = field(repr=False)
    shapes: np.ndarray = field(repr=False)
    evaluations: int

    def _summary(self) -> str:
        return f"{counted(self.eigenvalues.shape[1], 'mode')}, {counted(len(self.speeds), 'speed')}"

    @property
    def natural_frequencies(self) -> np.ndarray:
        """|s| in rad/s, 0 for real eigenvalues, shape (S, m)."""
        return np.where(self.eigenvalues.imag != 0, np.abs(self.eigenvalues), 0.0)

    @property
    def frequencies_hz(self) -> np.ndarray:
        """``natural_frequencies`` / (2 pi)."""
        return self.natural_frequencies / (2 * np.pi)

    @property
    def damped_frequencies(self) -> np.ndarray:
        """Damped frequencies Im s in rad/s, which intersect the lines n W at critical speeds, shape (S, m)."""
        return self.eigenvalues.imag

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s / |s|, 0 for an eigenvalue 0, shape (S, m)."""
        size = np.abs(self.eigenvalues)
        return -self.eigenvalues.real / np.where(size > 0, size, 1.0) + 0.0

    @property
    def stability_margins(self) -> np.ndarray:
        """Smallest -Re s of all modes at each speed (1/s), shape (S,): negative where the motion grows."""
        return -self.eigenvalues.real.max(axis=1, initial=-np.inf) + 0.0

    @cached_property
    def whirl(self) -> np.ndarray:
        """i x^H S x / (|x|^T |S| |x|) between -1 and 1, shape (S, m): the sense in which the rotor whirls, weighted by inertia.

        S is skew-symmetric: the mass between y and z and the diametral inertia between both tilts of the rotors of a lumped model,
        otherwise G. Positive is forward, with the rotation; gyroscopic moments raise its frequency. 0 is motion in a plane.
        """
        return np.array([whirl_of(self.system, shapes) for shapes in self.shapes])

    @property
    def directions(self) -> tuple[str, ...]:
        """Whirl direction of each mode: "forward", "backward", "planar", or "mixed" where it changes with the speed."""
        result = []
        for column in self.whirl.T:
            senses = {direction(value) for value in column} - {"planar"}
            result.append("planar" if not senses else senses.pop() if len(senses) == 1 else "mixed")
        return tuple(result)

    def critical_speeds(self, order: float = 1.0) -> tuple[CriticalSpeed, ...]:
        """Return the critical speeds within the range of speeds, ascending (``MechanicalSystem.critical_speeds``).

        Args:
            order: order n of the excitation.
        """
        low, high = self.speeds[[0, -1]]
        return tuple(point for point in critical_points(self.system, order) if low <= point.speed <= high)

    @cached_property
    def stability_limits(self) -> tuple[float, ...]:
        """The speeds at which the real part of an eigenvalue changes its sign (rad/s), by Newton's method on its branch."""
        return stability_limits(rotor_family(self.system)[0], self.speeds, self.eigenvalues)

    def table(self) -> list[dict[str, str]]:
        """A row of texts for each mode: direction of whirl, frequency in Hz at the first and last speed, least damping ratio."""
        first, last = self.frequencies_hz[[0, -1]]
        least = self.damping_ratios.min(axis=0)
        keys = ("direction", f"Hz at {self.speeds[0]:g} rad/s", f"Hz at {self.speeds[-1]:g} rad/s", "least damping ratio")
        texts = (map(number_text, values) for values in (first, last, least))
        return [dict(zip(keys, row)) for row in zip(self.directions, *texts)]

    def _tables(self) -> tuple[TextTable, ...]:
        rows = self.table()
        columns = tuple(rows[0]) if rows else ("direction",)
        modes = TextTable("Modes over the speed", columns, tuple(tuple(row.values()) for row in rows))
        critical = tuple(
            (number_text(one.speed), number_text(one.speed * 30 / np.pi), direction(one.whirl), number_text(one.damping_ratio))
            for one in self.critical_speeds()
        )
        return modes, TextTable("Critical speeds of order 1", ("rad/s", "rev/min", "direction", "damping ratio"), critical)


def direction(whirl: float) -> str:
    """Name of the whirl direction for a value of ``Campbell.whirl``."""
    return "planar" if abs(whirl) <= EPS**0.5 else "forward" if whirl > 0 else "backward"


def whirl_of(system: EquationsOfMotion, shapes: np.ndarray) -> np.ndarray:
    """Whirl of shapes, as defined in ``Campbell.whirl``."""
    form_matrix = system.gyroscopic if system.whirl_matrix is None else system.whirl_matrix
    if form_matrix is None:
        return np.zeros(shapes.shape[1])
    S, size = (form_matrix - form_matrix.T) / 2, np.abs(shapes)
    form = (1j * (shapes.conj() * (S @ shapes)).sum(axis=0)).real
    scale = (size * (np.abs(S) @ size)).sum(axis=0)
    total = np.abs(S).sum() * size.max(axis=0, initial=0.0) ** 2
    return np.where(scale > EPS * total, form / np.where(scale > 0, scale, 1.0), 0.0)


def campbell(system: EquationsOfMotion, speeds) -> Campbell:
    speeds = ascending(speeds, "speeds", ", in rad/s, e.g. numpy.linspace(0, 1000, 101)")
    check_speeds(system, *speeds[[0, -1]])
    family, V = rotor_family(system)
    with short_work(2 * system.size):
        branches = followed(family, speeds)
    values = branches.values
    limit = noise_of(np.abs(values).max(axis=1, keepdims=True, initial=0.0), system.size)
    values = np.where(np.abs(values) <= limit, 0.0, values)
    upper = values.imag.sum(axis=0)
    shown = (upper > 0) | ((upper == 0) & values.any(axis=0))
    shown |= ((values.imag == 0) & (values.real != 0)).any(axis=0)  # of a pair that has been real both are listed
    order = np.flatnonzero(shown)
    first, last = values[[0, -1]][:, order]
    order = order[np.lexsort([last.imag, np.round(np.abs(first) / limit.max()), first.imag == 0])]
    shapes = V @ branches.shapes[:, :, order]
    largest = np.take_along_axis(shapes, np.abs(shapes).argmax(axis=1)[:, None], axis=1)
    shapes = shapes / np.where(largest == 0, 1.0, largest)
    return Campbell(system, speeds, values[:, order], branches.slopes[:, order], shapes, branches.evaluations)


# Critical speeds.


def critical_points(system: EquationsOfMotion, order: float = 1.0) -> list[CriticalSpeed]:
    """Critical speeds as defined in ``MechanicalSystem.critical_speeds``, each with its mode, ascending."""
    order = real_number(order, "order", minimum=0.0)
    if not order:
        raise InputError("order: found 0; expected a positive number, 1 for unbalance")
    check_speeds(system)
    points = []
    with short_work(2 * system.size):
        for number, (low, high) in enumerate(speed_ranges(system)):
            least = low + noise_of(low) * (number > 0)  # a critical speed at a knot of a table is that of the interval below
            candidates = _points_within(system, order, low if system.speed_tables else None)
            points += [point for point in candidates if least < point.speed <= high + noise_of(high)]
    return sorted(points, key=lambda point: point.speed)


def critical_points_by_order(system: EquationsOfMotion, orders: Sequence[float]) -> list[CriticalSpeed]:
    """Critical speeds of several orders, by order; where nothing depends on the speed, they are those of order 1 divided by n."""
    if system.turns:
        return [point for order in orders for point in critical_points(system, order)]
    first = critical_points(system)
    return [replace(point, speed=point.speed / order, order=order) for order in orders for point in first]


def _points_within(system: EquationsOfMotion, order: float, within: float | None) -> list[CriticalSpeed]:
    """The critical speeds of equations that are linear in the speed, within an interval of speeds."""
    family, V = rotor_family(system, within)
    points = []
    for places in family.parts:
        part = FamilyPart(family, places, np.array([0.0, 1.0]))
        base, slope = part.block(family.at(0.0)), part.block(family.slope(0.0))
        coefficients = [base[0], base[1] + slope[0] / (1j * order), base[2] + slope[1] / (1j * order)]
        is_lossless = not coefficients[1].any() and part.is_conservative
        pairs = _undamped_points(coefficients, part) if is_lossless else _damped_points(coefficients, part, order)
        for value, x in pairs:
            shape = V[:, places] @ x
            shape = shape / shape[np.abs(shape).argmax()]
            speed = value.imag / order
            points.append(CriticalSpeed(speed, order, value, shape, float(whirl_of(system, shape[:, None])[0])))
    return points


def _undamped_points(coefficients, part: FamilyPart) -> list[tuple[complex, np.ndarray]]:
    """s = i w and x of K x = w^2 (M - i G / n) x, Hermitian, by 1 / w^2 in undamped modes, free motions eliminated."""
    K, _, B = coefficients
    basis, stiffness = part.basis, part.stiffness
    turned = basis.T @ B @ basis
    turned = (turned + turned.conj().T) / 2
    elastic, free = stiffness > 0, stiffness == 0
    rates = np.sqrt(stiffness[elastic])
    inner, cross = turned[np.ix_(elastic, elastic)], turned[np.ix_(free, elastic)]
    follow = -np.linalg.solve(turned[np.ix_(free, free)], cross) if free.any() else cross
    inner = (inner + cross.conj().T @ follow) / np.multiply.outer(rates, rates)
    inverse_squares, vectors = np.linalg.eigh(inner)
    kept = inverse_squares > noise_of(float(np.abs(inverse_squares).max(initial=0.0)), len(rates))
    eta = np.zeros((len(stiffness), int(kept.sum())), dtype=complex)
    eta[elastic] = vectors[:, kept] / rates[:, None]
    eta[free] = follow @ eta[elastic]
    x = basis @ eta
    values = refined_values([K, np.zeros_like(K), B], 1j / np.sqrt(inverse_squares[kept]), x, x.conj().T)
    return [(complex(0.0, value.imag), shape) for value, shape in zip(values, x.T)]


def _damped_points(coefficients, part: FamilyPart, order: float) -> list[tuple[complex, np.ndarray]]:
    """s and x with Im s = n W, from the eigenvalues of the polynomial eigenproblem as starts."""
    K, D, B = coefficients
    n, zero = len(K), np.zeros_like(K)
    rate = np.sqrt(np.abs(K).max() / (np.abs(B).max() or 1.0)) or 1.0
    left = np.block([[zero, np.eye(n)], [-K / rate**2, -D / rate]])
    right = block_diag(np.eye(n), B)
    alpha, beta = scipy.linalg.eigvals(left, right, homogeneous_eigvals=True)
    starts = np.array([rate * a / b for a, b in zip(alpha, beta) if abs(b) > EPS * abs(a)])
    located_points: list[tuple[float, complex, np.ndarray]] = []
    noise = noise_of(float(np.abs(starts).max(initial=0.0)), n)
    for start in starts[starts.imag > noise]:
        point = located(part, start.imag / order, start, lambda s, speed: s.imag - order * speed, lambda slope: slope.imag - order)
        if point is None or not point[0] * order > noise:
            continue
        speed, value, x = point
        near = (abs(speed - W) <= NEWTON_STEP * speed and abs(value - s) <= NEWTON_STEP * abs(value) for W, s, _ in located_points)
        if not any(near):
            located_points.append((speed, complex(value.real, order * speed), x))
    return [(value, x) for _, value, x in located_points]


# Steady states of a rotor under unbalance over the speed, with their peaks.
#
# At each constant speed W the force W^2 Re(u e^{i n W t}) has the steady state Re(x e^{i n W t}),
#
#     (K(W) + i n W C(W) - n^2 W^2 M) x = W^2 u.
#
# A peak is a zero of d|x_j|^2 / dW, in closed form from x' = A^-1 (2 W u - A' x), by bisection and interpolation (Brent). Source: Friswell,
# Penny, Garvey and Lees, Dynamics of Rotating Machines (2010), chapter 6.

#: Half bandwidths of a resonance at which peaks are searched, besides the given speeds.
NEAR_RESONANCE = np.array([-4.0, -2.0, -1.0, -0.5, 0.0, 0.5, 1.0, 2.0, 4.0])

#: Distances from an undamped critical speed, as parts of it.
NEAR_POLE = np.array([-0.02, -0.002, 0.002, 0.02])


@dataclass(frozen=True)
class UnbalancePeak:
    """A speed at which the amplitude of a coordinate has a maximum.

    Attributes:
        coordinate: its name.
        speed: W in rad/s.
        amplitude: in m or rad; infinite at an undamped resonance, where no steady state exists.
        unit: unit of the amplitude.
    """

    coordinate: str
    speed: float
    amplitude: float
    unit: str


@dataclass(frozen=True, repr=False, eq=False)
class UnbalanceResponse(Displayed):
    """Steady states over the speed.

    Attributes:
        system: the rotor at rest.
        order: n of the frequency n W; 1 for unbalance.
        speeds: W in rad/s, shape (S,).
        values: x complex, in m or rad, shape (S, n); infinite at an undamped resonance.
        peaks: peaks of all coordinates between the first and the last speed, by coordinate, ascending.
    """

    system: EquationsOfMotion
    order: float
    speeds: np.ndarray
    values: np.ndarray
    peaks: tuple[UnbalancePeak, ...] = field(repr=False)

    def _summary(self) -> str:
        return f"{counted(len(self.speeds), 'speed')}, {counted(len(self.peaks), 'peak')}"

    @property
    def amplitudes(self) -> np.ndarray:
        """|x| in m or rad, shape (S, n)."""
        return named_array(np.abs(self.values), (), self.system.names)

    def _tables(self) -> tuple[TextTable, ...]:
        rows = (
            (one.coordinate, number_text(one.speed), number_text(one.speed * 30 / np.pi), f"{one.amplitude:.6g} {one.unit}")
            for one in self.peaks
        )
        return (TextTable("Peaks of the unbalance response", ("coordinate", "rad/s", "rev/min", "amplitude"), tuple(rows)),)


def unbalance_response(system: EquationsOfMotion, speeds, unbalance=None, order: float = 1.0) -> UnbalanceResponse:
    order, wanted = real_number(order, "order", positive=True), ", at least 0, in rad/s"
    speeds = ascending(speeds, "speeds", wanted)
    if speeds[0] < 0:
        raise InputError(f"speeds: found {speeds[0]:g}; expected two or more, ascending{wanted}")
    check_speeds(system, *speeds[[0, -1]])
    steady = SteadyStates(system, _unbalance(system, unbalance), order)
    with short_work(2 * system.size):
        critical = critical_points(system, order)
        values = np.array([steady.at(speed)[0] for speed in speeds.tolist()])
        return UnbalanceResponse(system, order, speeds, values, tuple(_peaks(steady, speeds, critical)))


def _unbalance(system: EquationsOfMotion, given) -> np.ndarray:
    if given is None:
        if system.unbalance is None:
            raise InputError("unbalance: the system has none; give it in kg m, complex, one number for each coordinate or by name")
        return system.unbalance
    return complex_amplitudes(system, given, "unbalance")


class SteadyStates:
    """The steady state of a rotor under an unbalance u, shape (n,), of an order n at any speed."""

    def __init__(self, system: EquationsOfMotion, unbalance: np.ndarray, order: float):
        self.system, self.order = system, order
        self.family, self.basis = rotor_family(system)
        self.load = self.basis.T @ unbalance

    def at(self, speed: float) -> tuple[np.ndarray, np.ndarray]:
        """x and dx/dW, each of shape (n,); infinite where no steady state exists."""
        s, (K, C, M), (K1, C1, _) = 1j * self.order * speed, self.family.at(speed), self.family.slope(speed)
        A, slope = K + s * C + s * s * M, K1 + s * C1 + 1j * self.order * (C + 2 * s * M)
        try:
            x = np.linalg.solve(A, speed**2 * self.load)
            return self.basis @ x, self.basis @ np.linalg.solve(A, 2 * speed * self.load - slope @ x)
        except np.linalg.LinAlgError:
            if not speed:
                raise InputError("speeds: at 0 rad/s the position of a free rotor is not determined; begin above 0") from None
            return (np.full(len(self.basis), np.inf, dtype=complex),) * 2

    def growth(self, speed: float) -> np.ndarray:
        """d|x|^2 / dW / 2 of each coordinate, 0 where no steady state exists, shape (n,)."""
        x, slope = self.at(speed)
        return (x.conj() * slope).real if np.isfinite(x).all() else np.zeros(len(x))


def with_resonances(speeds: np.ndarray, critical: Sequence[CriticalSpeed]) -> np.ndarray:
    """The speeds, with further ones near critical speeds, where amplitudes change fast."""
    near = [one.speed * (1 + (one.damping_ratio * NEAR_RESONANCE if _is_damped(one) else NEAR_POLE)) for one in critical]
    places = np.unique(np.concatenate([speeds, *near]))
    return places[(places > 0) & (places >= speeds[0]) & (places <= speeds[-1])]


def _is_damped(point: CriticalSpeed) -> bool:
    return abs(point.damping_ratio) > EPS**0.5


def _peaks(steady: SteadyStates, speeds: np.ndarray, critical: list[CriticalSpeed]):
    """The maxima between speeds, and near critical speeds at which the amplitude first grows and then falls."""
    from scipy.optimize import brentq

    system, poles = steady.system, [point.speed for point in critical if not _is_damped(point)]
    places = with_resonances(speeds, critical)
    for pole in poles:
        places = places[np.abs(places - pole) > NEWTON_STEP * pole]
    growth = np.array([steady.growth(place) for place in places.tolist()])
    for j, (name, unit) in enumerate(system.units.items()):
        for (a, low), (b, high) in pairwise(zip(places.tolist(), growth[:, j])):
            if not (low > 0 > high):
                continue
            speed = float(brentq(lambda W, j=j: steady.growth(W)[j], a, b, xtol=4 * EPS * b, rtol=4 * EPS))
            infinite = any(abs(speed - pole) <= NEWTON_STEP * pole for pole in poles)
            yield UnbalancePeak(name, speed, np.inf if infinite else float(np.abs(steady.at(speed)[0][j])), unit)
