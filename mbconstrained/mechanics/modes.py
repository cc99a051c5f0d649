"""The finite zeros of a mechanical system, each with what it means for the machine.

A row held at acceleration or velocity level puts a factor s^2 or s before the same row at position level,
det [V^T P(s); A s^level] = s^(sum of levels) det [V^T P(s); A]: those zeros at 0 are the drift of the constraints and
no motion of the bodies. All others are therefore read off the form with every row at position level. There a
zero at 0 is a rigid body motion where an elementary divisor s^2 (or higher) belongs to it, displacement and
velocity both left alone, and an offset where the divisor is s: a displacement that nothing pulls back.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Literal

import numpy as np

from ..checks import whole_number
from ..polynomial.matrix import PolynomialMatrix
from ..polynomial.structure import FiniteZero
from ..tolerances import EPS, NOISE_SAFETY, rounding_radius
from .conservation import Conservation, conservation_of
from .energy_parts import EnergyParts, EnergyShares
from .shapes import mode_shapes, rest_shapes

if TYPE_CHECKING:
    from .system import MechanicalSystem

Kind = Literal["oscillation", "decay", "growth", "rigid body", "drift", "offset"]


@dataclass(frozen=True)
class Mode:
    """A finite zero of A(s) (of a complex pair the one above the real axis) and its meaning.

    Attributes:
        kind: "oscillation", "decay", "growth", "rigid body", "drift" or "offset".
        value: the zero in 1/s.
        multiplicity: how often it is a root of det A(s); each of the two, for a pair.
        shapes: the independent shapes, one a column, shape (n, g), the largest entry of each 1; none for drift.
        energy_parts: of the system; None where nothing is known of energies.
    """

    kind: Kind
    value: complex
    multiplicity: int
    shapes: np.ndarray
    energy_parts: EnergyParts | None = field(default=None, repr=False, compare=False)

    @property
    def angular_frequency(self) -> float:
        """|s| in rad/s for a zero with an imaginary part, otherwise 0: the frequency without its damping."""
        return abs(self.value) if self.value.imag else 0.0

    @property
    def frequency_hz(self) -> float:
        """The same in Hz."""
        return self.angular_frequency / (2 * np.pi)

    @property
    def damping_ratio(self) -> float:
        """-Re s / |s|; 0 for a zero at 0."""
        return -self.value.real / abs(self.value) if self.value.real else 0.0

    @cached_property
    def shares(self) -> tuple[EnergyShares, ...]:
        """For each shape the shares of its kinetic and strain energy by part of the machine (``EnergyParts``).

        What rests has no kinetic energy (an offset), what moves as a rigid body no strain energy: its shares are None.

        >>> from mbconstrained.models import LumpedModel
        >>> model = LumpedModel()
        >>> _ = model.mass("cart", 3.0), model.mass("load", 1.0)
        >>> _ = model.spring("ground", "cart", 3.0, name="wall"), model.spring("cart", "load", 1.0, name="coupling")
        >>> {name: round(share, 3) for name, share in model.assemble().modes().oscillating[0].shares[0].strain.items()}
        {'wall': 0.651, 'coupling': 0.349}
        """
        if self.energy_parts is None:
            return ()
        found = (self.energy_parts.shares(shape, self.value) for shape in self.shapes.T)
        return tuple(replace(shares, kinetic=None) if self.kind == "offset" else shares for shares in found)

    @property
    def text(self) -> str:
        """One line on what it is."""
        return _text(self)


@dataclass(frozen=True)
class Modes:
    """All finite zeros of a system, ascending by modulus.

    Attributes:
        zeros: the labelled zeros; what lies at 0 is told apart into rigid body, offset and drift.
        names: of the coordinates, in the order of the rows of the shapes.
    """

    zeros: tuple[Mode, ...]
    names: tuple[str, ...]

    @property
    def oscillating(self) -> tuple[Mode, ...]:
        """Those with an imaginary part, ascending by angular frequency, growing ones too."""
        return tuple(mode for mode in self.zeros if mode.value.imag)

    @property
    def angular_frequencies(self) -> np.ndarray:
        """|s| of the oscillating zeros in rad/s, ascending, each as often as its multiplicity."""
        return np.array([mode.angular_frequency for mode in self.oscillating for _ in range(mode.multiplicity)])

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s / |s| of the same zeros."""
        return np.array([mode.damping_ratio for mode in self.oscillating for _ in range(mode.multiplicity)])

    @property
    def shapes(self) -> np.ndarray:
        """A shape for each of the same zeros, shape (n, m); real where all are. A defective zero repeats its last."""
        columns = [
            mode.shapes[:, min(i, mode.shapes.shape[1] - 1)] for mode in self.oscillating for i in range(mode.multiplicity)
        ]
        return np.array(columns).T if columns else np.zeros((len(self.names), 0))

    def lowest(self, count: int) -> Modes:
        """The first zeros, as many as make ``count`` with their multiplicities; a pair counts once.

        Raises:
            InputError: a count below one.
        """
        before = np.cumsum([0, *(mode.multiplicity for mode in self.zeros)])
        return replace(self, zeros=self.zeros[: np.searchsorted(before, whole_number(count, "count", minimum=1))])

    @property
    def drift(self) -> int:
        """How many zeros at 0 the rows at velocity (1 each) and acceleration level (2 each) add."""
        return sum(mode.multiplicity for mode in self.zeros if mode.kind == "drift")

    def table(self) -> list[dict[str, str]]:
        """One row of text per zero: kind, zero, frequency in Hz and rad/s, damping ratio, multiplicity, meaning."""
        return [_table_row(mode) for mode in self.zeros]


def modes_of(system: MechanicalSystem) -> Modes:
    """The finite zeros of the constrained form, labelled.

    Raises:
        SingularPolynomialMatrix: the motion is not determined.
    """
    A = system.position_form().polynomial_matrix
    conservation, pair = conservation_of(system), A.jordan_pairs().finite
    resting, moving = [], []
    for zero in pair.zeros:
        if zero.value:
            value = cleaned(complex(zero.value), zero.multiplicity, conservation, pair.form.companion.is_precise)
            moving.append(Mode(_kind(value), value, zero.multiplicity, mode_shapes(pair, zero)))
        else:
            resting.extend(_at_rest(A, zero))
    found = (*resting, *_drift(system), *moving)
    return Modes(tuple(replace(mode, energy_parts=system.energy_parts) for mode in found), system.names)


def _at_rest(A: PolynomialMatrix, zero: FiniteZero):
    """The zeros at 0 with every row at position level, told apart by their elementary divisors."""
    bodies = sum(degree for degree in zero.partial_multiplicities if degree > 1)
    offsets = zero.partial_multiplicities.count(1)
    free, staying = rest_shapes(A)
    if bodies:
        yield Mode("rigid body", 0j, bodies, free)
    if offsets:
        yield Mode("offset", 0j, offsets, staying)


def _drift(system: MechanicalSystem):
    count = sum(row.order for row in system.rows)
    if count:
        yield Mode("drift", 0j, count, np.zeros((system.size, 0)))


def _kind(value: complex) -> Kind:
    if not value:
        return "offset"
    if value.real > 0:
        return "growth"
    return "oscillation" if value.imag else "decay"


def cleaned(value: complex, multiplicity: int, conservation: Conservation, is_precise: bool = False) -> complex:
    """Take out of a computed zero what the symmetry and signs of M, C and K rule out; a precise simple one keeps its real part."""
    if conservation.passive and (conservation.lossless or value.real > 0):
        return complex(0.0, value.imag)
    if conservation.lossless:
        return complex(0.0, value.imag) if abs(value.imag) > abs(value.real) else complex(value.real)
    if is_precise and multiplicity == 1:
        return value
    # growth slower than this cannot be told from rounding, which moves a defective zero further than a simple one
    limit = rounding_radius(multiplicity) if value.real > 0 else NOISE_SAFETY * EPS
    return complex(value.real if abs(value.real) > limit * abs(value) else 0.0, value.imag)


def _table_row(mode: Mode) -> dict[str, str]:
    oscillating = bool(mode.value.imag)
    return {
        "kind": mode.kind,
        "zero (1/s)": _complex_text(mode.value),
        "frequency (Hz)": f"{mode.frequency_hz:.6g}" if oscillating else "",
        "angular frequency (rad/s)": f"{mode.angular_frequency:.6g}" if oscillating else "",
        "damping ratio": f"{mode.damping_ratio:.4g}" if oscillating else "",
        "multiplicity": str(mode.multiplicity),
        "meaning": mode.text,
    }


def _complex_text(value: complex) -> str:
    if not value.imag:
        return f"{value.real:.6g}"
    real = f"{value.real:.6g} " if value.real else ""
    return f"{real}± {value.imag:.6g} i"


def _text(mode: Mode) -> str:
    if mode.kind == "drift":
        return "drift of constraint rows held below position level, no motion of the bodies"
    if mode.kind == "rigid body":
        return "rigid body motion: neither its displacement nor its velocity is held back"
    if mode.kind == "offset":
        return "offset: a displacement that nothing pulls back"
    if not mode.value.imag:
        return f"{mode.kind}, time constant {1 / abs(mode.value.real):.6g} s"
    what = "growing oscillation" if mode.kind == "growth" else "oscillation"
    damped = f", damping ratio {mode.damping_ratio:.4g}" if mode.damping_ratio else ", undamped"
    return f"{what} at {mode.frequency_hz:.6g} Hz{damped}"
