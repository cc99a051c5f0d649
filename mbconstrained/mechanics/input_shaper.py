"""Input shapers: a few impulses by which any input is convolved, so that it leaves modes at rest when it ends."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, get_args

import numpy as np

from ..ground.checks import counted, nearest, real_array, real_number
from ..ground.display import Displayed, TextTable
from ..ground.errors import InputError
from ..ground.tolerances import noise_of
from ..signals.impulsive import ImpulsiveSmooth
from .modes import Mode, Modes

Kind = Literal["ZV", "ZVD", "EI"]

#: The vibration that EI leaves at the frequency of the mode, as a part of that of an input that is not shaped.
DEFAULT_VIBRATION_LIMIT = 0.05

#: Impulses of a shaper: a factor of 2 or 3 for each mode.
MOST_IMPULSES = 1000


class ShapedMode(NamedTuple):
    """A mode at which a shaper is aimed."""

    frequency_hz: float  # |s| / (2 pi), undamped
    damping: float  # -Re s / |s|


@dataclass(frozen=True, repr=False, eq=False)
class InputShaper(Displayed):
    """The impulses A_i at t_i, of sum 1: a shaped input sum over i of A_i f(t - t_i) ends where f ends, delayed by the last t_i.

    Attributes:
        times: t_i in s, ascending, the first is 0, shape (k,).
        amplitudes: A_i, shape (k,).
        kind: "ZV", "ZVD" or "EI".
        modes: the modes at which it is aimed.
    """

    times: np.ndarray
    amplitudes: np.ndarray
    kind: Kind
    modes: tuple[ShapedMode, ...] = field(default=())

    def _summary(self) -> str:
        return f"{self.kind}, {counted(len(self.times), 'impulse')}, {self.duration:.6g} s"

    def _tables(self) -> tuple[TextTable, ...]:
        rows = ((f"{time:.6g}", f"{amplitude:.6g}") for time, amplitude in zip(self.times, self.amplitudes))
        return (TextTable("Impulses", ("t (s)", "amplitude"), tuple(rows)),)

    @property
    def duration(self) -> float:
        """The last t_i in s, by which the input becomes longer."""
        return float(self.times[-1])

    def shape(self, signal: ImpulsiveSmooth) -> ImpulsiveSmooth:
        """Return the shaped input: the sum of the delayed copies A_i f(t - t_i).

        Args:
            signal: f, any input of the package.

        Returns:
            An ``ImpulsiveSmooth`` with as many rows.

        Raises:
            InputError: something that is no input.

        >>> from mbconstrained import input_shaper, step
        >>> input_shaper((1.0, 0.0), kind="ZV").shape(step(2.0))([0.25, 0.75])
        array([[1., 2.]])
        """
        if not isinstance(signal, ImpulsiveSmooth):
            raise InputError(f"signal: found {type(signal).__name__}; expected an input, such as mb.step(5.0)")
        copies = [float(amplitude) * signal.delayed(float(time)) for time, amplitude in zip(self.times, self.amplitudes)]
        return sum(copies[1:], copies[0])

    def residual(self, frequency_hz, damping: float = 0.0) -> np.ndarray:
        """Return the vibration of a mode after the last impulse, relative to that by one impulse of size 1 at t = 0.

            V = e^{-zeta w t_k} |sum over i of A_i e^{zeta w t_i} e^{i w_d t_i}|,  w_d = w sqrt(1 - zeta^2)

        Args:
            frequency_hz: w / (2 pi) in Hz, a number or shape (F,), at least 0.
            damping: zeta, at least 0 and below 1.

        Returns:
            V without unit, of the shape of frequency_hz.

        Raises:
            InputError: a frequency or a damping ratio out of range.

        >>> from mbconstrained import input_shaper
        >>> input_shaper((1.0, 0.0), kind="EI").residual([1.0, 0.0]).round(12)
        array([0.05, 1.  ])
        """
        frequencies, damping = real_array(frequency_hz, "frequency_hz"), _damping_ratio(damping)
        if (frequencies < 0).any():
            raise InputError("frequency_hz: found a negative number; expected Hz, at least 0")
        eigenvalues = 2 * np.pi * frequencies * complex(-damping, math.sqrt(1 - damping**2))
        copies = np.exp(np.multiply.outer(eigenvalues, self.duration - self.times))
        return np.abs(copies @ self.amplitudes)


def input_shaper(modes, kind: Kind = "ZVD", *, vibration_limit: float | None = None) -> InputShaper:
    """Return the impulses by which an input leaves no vibration of some modes when it ends.

    With K = e^{-zeta pi / sqrt(1 - zeta^2)} and half a damped period T = pi / w_d the impulses at 0, T, 2 T are

        ZV:   [1, K] / (1 + K)                                 no vibration at the frequency of the mode
        ZVD:  [1, 2 K, K^2] / (1 + K)^2                        nor a slope there: errors of the frequency count squared
        EI:   [1 + v, 2 K (1 - v), K^2 (1 + v)] / their sum    a small one there, none at a frequency on either side

    With v = V (1 + K)^2 / (4 K^2 - V (1 - K)^2), EI leaves exactly the part V; v = V without damping. Of several modes, the
    shaper is the convolution of those of each.

    Args:
        modes: ``Modes``, of which the oscillating ones count, one ``Mode``, a list of them, or pairs of frequency_hz (undamped, Hz) and
            damping ratio.
        kind: "ZV", "ZVD" or "EI".
        vibration_limit: V of EI, 0.05 by default, between 0 and 1.

    Returns:
        An ``InputShaper``.

    Raises:
        InputError: another kind, no mode or too many, a mode that does not oscillate or grows, a limit that the damping does not allow.

    Sources: Singer and Seering, J. Dyn. Syst. Meas. Control 112 (1990) 76-82 (ZV, ZVD); Singhose, Derezinski and Singer, "Extra-insensitive
    input shapers for controlling flexible spacecraft", J. Guid. Control Dyn. 19 (1996) 385-391 (EI, without damping).

    >>> shaper = input_shaper((0.5, 0.0))
    >>> shaper.times, shaper.amplitudes
    (array([0., 1., 2.]), array([0.25, 0.5 , 0.25]))
    """
    if not isinstance(kind, str) or kind not in get_args(Kind):
        raise InputError(f"kind: found {kind!r}{nearest(str(kind), get_args(Kind))}; expected one of {', '.join(get_args(Kind))}")
    if vibration_limit is not None and kind != "EI":
        raise InputError(f'vibration_limit: {kind} leaves no vibration at the frequency of the mode; give kind="EI", or no limit')
    limit = real_number(DEFAULT_VIBRATION_LIMIT if vibration_limit is None else vibration_limit, "vibration_limit", minimum=0.0)
    if limit >= 1:
        raise InputError(f"vibration_limit: found {limit:g}; expected a part below 1, such as 0.05 for 5 %")
    aims = _aims(modes)
    count = len(_AMPLITUDES[kind](1.0, limit)) ** len(aims)
    if count > MOST_IMPULSES:
        raise InputError(
            f"modes: {kind} has {count} impulses for {len(aims)} modes, more than {MOST_IMPULSES}; choose those that the input excites most"
        )
    times, amplitudes = np.zeros(1), np.ones(1)
    for frequency_hz, damping in aims:
        root = math.sqrt(1 - damping**2)
        half_period = 0.5 / (frequency_hz * root)
        own = np.array(_AMPLITUDES[kind](math.exp(-math.pi * damping / root), limit))
        times = np.add.outer(times, half_period * np.arange(len(own))).ravel()
        amplitudes = np.multiply.outer(amplitudes, own / own.sum()).ravel()
    times, places = np.unique(times, return_inverse=True)
    return InputShaper(times, np.bincount(places, weights=amplitudes), kind, aims)


def _extra_insensitive(K: float, limit: float) -> tuple[float, ...]:
    allowed = 4 * K**2 - limit * (1 - K) ** 2
    if allowed <= limit * (1 + K) ** 2:
        raise InputError(
            f"vibration_limit: half a period of the mode leaves {K:.3g} of its vibration, too little for three positive impulses with the "
            f"limit {limit:g}; choose a smaller one"
        )
    v = limit * (1 + K) ** 2 / allowed
    return 1 + v, 2 * K * (1 - v), K**2 * (1 + v)


#: Amplitudes by K and the limit, before they are divided by their sum.
_AMPLITUDES: dict[str, Callable[[float, float], tuple[float, ...]]] = {
    "ZV": lambda K, _: (1, K),
    "ZVD": lambda K, _: (1, 2 * K, K**2),
    "EI": _extra_insensitive,
}


def _damping_ratio(value) -> float:
    damping = real_number(value, "damping", minimum=0.0)
    if damping >= 1:
        raise InputError(f"damping: found the ratio {damping:g}; a mode with 1 or more does not oscillate")
    return damping


def _aims(modes) -> tuple[ShapedMode, ...]:
    """Frequencies and damping ratios of the modes."""
    if isinstance(modes, Modes):
        given: Sequence | np.ndarray = modes.oscillating
    elif isinstance(modes, Mode) or (isinstance(modes, Sequence) and len(modes) == 2 and not any(map(_is_several, modes))):
        given = [modes]
    elif isinstance(modes, (Sequence, np.ndarray)) and not isinstance(modes, str):
        given = modes
    else:
        raise InputError(
            f"modes: found {type(modes).__name__}; expected system.modes(), or pairs such as (1.5, 0.02) of Hz and damping ratio"
        )
    if not len(given):
        raise InputError("modes: none of them oscillates; an input shaper needs at least one that does")
    return tuple(_aim(one) for one in given)


def _is_several(value) -> bool:
    return isinstance(value, Mode) or np.ndim(value) > 0


def _aim(mode) -> ShapedMode:
    if isinstance(mode, Mode):
        s = mode.eigenvalue
        if not s.imag:
            raise InputError(
                f"modes: the mode with the eigenvalue {s.real:.6g} 1/s does not oscillate; choose modes(...).oscillating"
            )
        # a real part within rounding error of the eigenvalue is that of an undamped mode
        damping = -s.real / abs(s)
        if -damping > noise_of(1.0):
            raise InputError(f"modes: the mode of {abs(s) / (2 * np.pi):.6g} Hz grows; an input shaper is for modes that decay")
        return ShapedMode(abs(s) / (2 * np.pi), max(0.0, damping))
    if np.ndim(mode) != 1 or len(mode) != 2:
        raise InputError(f"modes: found {mode!r}; expected pairs of frequency_hz and damping ratio, such as (1.5, 0.02)")
    return ShapedMode(real_number(mode[0], "frequency_hz", positive=True), _damping_ratio(mode[1]))
