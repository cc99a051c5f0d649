"""Steady states of a rotor under unbalance over the speed, with their peaks.

At each constant speed W the force W^2 Re(u e^{i n W t}) has the steady state Re(x e^{i n W t}),

    (K(W) + i n W C(W) - n^2 W^2 M) x = W^2 u.

A peak is a zero of d|x_j|^2 / dW, in closed form from x' = A^-1 (2 W u - A' x), by bisection and interpolation (Brent). Source: Friswell,
Penny, Garvey and Lees, Dynamics of Rotating Machines (2010), chapter 6.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from ...ground.checks import counted, nearest, real_array, real_number
from ...ground.display import Displayed, TextTable, number_text
from ...ground.errors import InputError
from ...ground.threads import short_work
from ...ground.tolerances import EPS, NEWTON_STEP
from ..equations import EquationsOfMotion
from .rotating import CriticalSpeed, critical_points
from .rotor_equations import check_rotor, rotor_family

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
        return np.abs(self.values)

    def _tables(self) -> tuple[TextTable, ...]:
        return (peak_table(self.peaks),)


def peak_table(peaks, title: str = "Peaks of the unbalance response") -> TextTable:
    """A row for each peak."""
    rows = (
        (one.coordinate, number_text(one.speed), number_text(one.speed * 30 / np.pi), f"{one.amplitude:.6g} {one.unit}")
        for one in peaks
    )
    return TextTable(title, ("coordinate", "rad/s", "rev/min", "amplitude"), tuple(rows))


def unbalance_response(system: EquationsOfMotion, speeds, unbalance=None, order: float = 1.0) -> UnbalanceResponse:
    """The steady states over the speed."""
    speeds = real_array(speeds, "speeds", shape=(None,))
    order = real_number(order, "order", positive=True)
    if len(speeds) < 2 or not (np.diff(speeds) > 0).all() or speeds[0] < 0:
        raise InputError(f"speeds: found {len(speeds)} values; expected two or more, ascending, at least 0, in rad/s")
    check_rotor(system, *speeds[[0, -1]])
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
    if isinstance(given, Mapping):
        for name in given:
            if name not in system.names:
                raise InputError(f'unbalance: there is no coordinate "{name}"{nearest(name, system.names)}')
        given = [given.get(name, 0.0) for name in system.names]
    values = np.asarray(given)
    parts = (real_array(part, "unbalance", shape=(system.size,)) for part in (values.real, values.imag))
    real, imaginary = parts
    return real + 1j * imaginary


class SteadyStates:
    """The steady state at any speed.

    Args:
        system: the rotor at rest.
        unbalance: u, shape (n,).
        order: n.
    """

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
    for j, (name, unit) in enumerate(zip(system.names, (system.units[name] for name in system.names))):
        for (a, low), (b, high) in pairwise(zip(places.tolist(), growth[:, j])):
            if not (low > 0 > high):
                continue
            speed = float(brentq(lambda W, j=j: steady.growth(W)[j], a, b, xtol=4 * EPS * b, rtol=4 * EPS))
            infinite = any(abs(speed - pole) <= NEWTON_STEP * pole for pole in poles)
            yield UnbalancePeak(name, speed, np.inf if infinite else float(np.abs(steady.at(speed)[0][j])), unit)
