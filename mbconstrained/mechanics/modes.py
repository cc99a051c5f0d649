"""The modes of a mechanical system: each eigenvalue with its shapes and its meaning for the machine, and tables of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice
from pathlib import Path
from typing import Literal

import numpy as np

from ..exchange.trajectories import write_arrays
from ..exchange.universal import UNIVERSAL, Geometry, write_modes
from ..ground.checks import counted, whole_number
from ..ground.coordinate_units import coordinate_units
from ..ground.display import Presented, TextTable
from ..ground.errors import InputError
from ..ground.files import replacing
from ..linalg.arrays import kept
from ..polynomial.polynomial_matrix import PolynomialMatrix
from .energy import EnergyParts, EnergyShares
from .equations import EquationsOfMotion

Kind = Literal["oscillation", "decay", "growth", "rigid body", "drift", "offset"]

#: Kinds of modes that are no motion of a structure, which universal files leave out.
STILL = ("drift", "offset", "decay")


@dataclass(frozen=True, eq=False)
class Mode:
    """A finite eigenvalue of a mechanical system (of a complex pair the one above the real axis) with its shapes and meaning.

    A(s) u = 0 with the eigenvalue s and a shape u; the free motion of the mode is Re(u e^{s t}).

    Attributes:
        kind: "oscillation", "decay", "growth", "rigid body", "drift" or "offset".
        eigenvalue: s in 1/s.
        multiplicity: multiplicity of s as a root of det A(s).
        shapes: the independent shapes, one a column, shape (n, g), the largest entry of each 1; none for drift.
        system: to which it belongs, for its energies; None where these are unknown.
    """

    kind: Kind
    eigenvalue: complex
    multiplicity: int
    shapes: np.ndarray = field(repr=False)
    system: EquationsOfMotion | None = field(default=None, repr=False, compare=False)

    @property
    def energy_parts(self) -> EnergyParts | None:
        """M and K as sums of named parts; None where the energies are unknown."""
        return None if self.system is None else self.system.energy_parts

    @property
    def natural_frequency(self) -> float:
        """|s| in rad/s of an oscillation, the frequency without its damping; 0 for a real eigenvalue."""
        return abs(self.eigenvalue) if self.eigenvalue.imag else 0.0

    @property
    def frequency_hz(self) -> float:
        """|s| / (2 pi) in Hz; 0 for a real eigenvalue."""
        return self.natural_frequency / (2 * np.pi)

    @property
    def damping_ratio(self) -> float:
        """-Re s / |s|; 0 for an eigenvalue 0."""
        return -self.eigenvalue.real / abs(self.eigenvalue) if self.eigenvalue.real else 0.0

    @cached_property
    def shares(self) -> tuple[EnergyShares, ...]:
        """Shares of the kinetic and strain energy of each shape by part of the machine (``EnergyParts``).

        An offset has no kinetic energy, a rigid-body motion no strain energy: these shares are None.

        >>> from mbconstrained import LumpedModel
        >>> model = LumpedModel()
        >>> _ = model.mass("cart", 3.0), model.mass("load", 1.0)
        >>> _ = model.spring("ground", "cart", 3.0, name="wall"), model.spring("cart", "load", 1.0, name="coupling")
        >>> {name: round(share, 3) for name, share in model.assemble().modes().oscillating[0].shares[0].strain.items()}
        {'wall': 0.639, 'coupling': 0.361}
        """
        return _shares((self,))[0]

    @property
    def text(self) -> str:
        """The kind of the mode in one line, with frequency and damping ratio or time constant."""
        if self.kind == "drift":
            return "drift of constraint rows at velocity or acceleration level, no motion of the bodies"
        if self.kind == "rigid body":
            return "rigid-body motion: unconstrained, without restoring force"
        if self.kind == "offset":
            return "offset: a displacement without restoring force"
        if not self.eigenvalue.imag:
            return f"{self.kind}, time constant {1 / abs(self.eigenvalue.real):.6g} s"
        kind = "growing oscillation" if self.kind == "growth" else "oscillation"
        damped = f", damping ratio {self.damping_ratio:.4g}" if self.damping_ratio else ", undamped"
        return f"{kind} at {self.frequency_hz:.6g} Hz{damped}"


@dataclass(frozen=True, repr=False, eq=False)
class Modes(Presented, Sequence):
    """The modes of a mechanical system: a sequence of ``Mode``, ascending by |s|, with tables.

    Attributes:
        modes: one ``Mode`` for each finite eigenvalue; an eigenvalue 0 is split into rigid body, offset and drift.
        names: names of the coordinates, in the order of the rows of the shapes.
        polynomial_matrix: A(s) with A(s) u = 0 for each eigenvalue s and shape u; None where it is not known.
        system: system of arrays, that has these modes; None where it is not known.
    """

    modes: tuple[Mode, ...]
    names: tuple[str, ...]
    polynomial_matrix: PolynomialMatrix | None = field(default=None, repr=False, kw_only=True)
    system: EquationsOfMotion | None = field(default=None, repr=False, compare=False, kw_only=True)

    def __len__(self) -> int:
        return len(self.modes)

    def __getitem__(self, index):
        """A ``Mode``; for a slice ``Modes``."""
        return replace(self, modes=self.modes[index]) if isinstance(index, slice) else self.modes[index]

    def _summary(self) -> str:
        hz = self.frequencies_hz
        band = f": {hz[0]:.4g} Hz" + (f" to {hz[-1]:.4g} Hz" if len(hz) > 1 else "") if len(hz) else ""
        return f"{counted(len(self), 'mode')} of {counted(len(self.names), 'coordinate')}{band}"

    def _tables(self) -> tuple[TextTable, ...]:
        columns = ("kind", "frequency (Hz)", "damping ratio")
        rows = ((str(number), *(row[column] for column in columns)) for number, row in enumerate(self.table(), 1))
        return (TextTable("Modes", ("no.", *columns), tuple(rows)),)

    @property
    def oscillating(self) -> tuple[Mode, ...]:
        """The oscillating modes, with complex eigenvalues, ascending by natural frequency; growing ones included."""
        return tuple(mode for mode in self.modes if mode.eigenvalue.imag)

    @property
    def eigenvalues(self) -> np.ndarray:
        """Finite eigenvalues in 1/s, one of each complex pair (above the real axis), repeated by multiplicity."""
        return np.array([mode.eigenvalue for mode in self.modes for _ in range(mode.multiplicity)], dtype=complex)

    @property
    def natural_frequencies(self) -> np.ndarray:
        """|s| of the oscillating modes in rad/s, ascending, repeated by multiplicity."""
        return np.array([mode.natural_frequency for mode in self.oscillating for _ in range(mode.multiplicity)])

    @property
    def frequencies_hz(self) -> np.ndarray:
        """``natural_frequencies`` / (2 pi), in Hz."""
        return self.natural_frequencies / (2 * np.pi)

    @property
    def damping_ratios(self) -> np.ndarray:
        """-Re s / |s| of the oscillating modes."""
        return np.array([mode.damping_ratio for mode in self.oscillating for _ in range(mode.multiplicity)])

    @property
    def shapes(self) -> np.ndarray:
        """Shapes of the oscillating modes, shape (n, m); real where all are. A defective eigenvalue repeats its last."""
        columns = [mode.shapes[:, min(i, mode.shapes.shape[1] - 1)] for mode in self.oscillating for i in range(mode.multiplicity)]
        return np.array(columns).T if columns else np.zeros((len(self.names), 0))

    @cached_property
    def shares(self) -> tuple[tuple[EnergyShares, ...], ...]:
        """Energy shares of each mode (``Mode.shares``)."""
        return _shares(self.modes)

    @cached_property
    def residuals(self) -> np.ndarray:
        """|A(s) u| of each mode, relative to the sizes of its terms, the largest of its shapes, shape (m,)."""
        A, counts = self.polynomial_matrix, [mode.shapes.shape[1] for mode in self.modes]
        if A is None or not sum(counts):
            return np.zeros(len(counts))
        s, u = np.repeat([mode.eigenvalue for mode in self.modes], counts), np.hstack([mode.shapes for mode in self.modes])
        powers = [(k, kept(matrix)) for k, matrix in enumerate(A.coefficients) if matrix.any()]
        left = sum(s**k * (matrix @ u) for k, matrix in powers)
        terms = sum(np.abs(s) ** k * (abs(matrix) @ np.abs(u)) for k, matrix in powers)
        sizes = np.linalg.norm(terms, axis=0)
        relative = np.linalg.norm(left, axis=0) / np.where(sizes > 0, sizes, 1.0)
        return np.array([own.max(initial=0.0) for own in np.split(relative, np.cumsum(counts)[:-1])])

    def lowest(self, count: int) -> Modes:
        """Return the first modes, whose multiplicities add up to ``count``; a complex pair counts once.

        Raises:
            InputError: a count below one.
        """
        before = np.cumsum([0, *(mode.multiplicity for mode in self.modes)])
        return self[: np.searchsorted(before, whole_number(count, "count", minimum=1))]

    @property
    def drift(self) -> int:
        """Number of zero eigenvalues caused by rows at velocity (1 each) and acceleration level (2 each)."""
        return sum(mode.multiplicity for mode in self.modes if mode.kind == "drift")

    def table(self) -> list[dict[str, str]]:
        """A row of texts per mode: kind, frequency in Hz, damping ratio, eigenvalue, frequency in rad/s, multiplicity, meaning."""
        return [_table_row(mode) for mode in self.modes]

    def arrays(self) -> dict[str, np.ndarray]:
        """eigenvalues, natural_frequencies, frequencies_hz, damping_ratios, shapes (of the oscillating modes) and names, as arrays."""
        keys = ("eigenvalues", "natural_frequencies", "frequencies_hz", "damping_ratios", "shapes")
        return {**{key: np.asarray(getattr(self, key)) for key in keys}, "names": np.array(self.names)}

    def write(self, path: str | Path, *, units: Mapping[str, str] | None = None, geometry: Geometry | None = None) -> Path:
        """Write the modes: as arrays in .npz or .mat, or as universal file (.uff, .unv: data sets 151, 164, 15, 82 and 55).

        A universal file has every shape of the oscillating and rigid-body modes: a normal mode with frequency and damping ratio where
        the shape is real, otherwise a complex eigenvalue. Its numbers have the 6 digits of the format; the eigenvalue stands with all
        its digits in the fourth line of identification.

        Args:
            path: path of the file.
            units: units of the coordinates by name, "m" or "rad", as ``system.units``; "m" by default.
            geometry: nodes, directions and points of the coordinates in a universal file.

        Returns:
            The path.

        Raises:
            InputError: another ending; complex shapes of angles, which data set 55 has no place for.
            MissingPackage: pyuff for universal files.
        """
        path = Path(path)
        ending = path.suffix.lower()
        if ending not in (".npz", ".mat", *UNIVERSAL):
            raise InputError(f"{path.name}: expected a file that ends in .npz, .mat, {', '.join(UNIVERSAL)}")
        path.parent.mkdir(parents=True, exist_ok=True)
        with replacing(path) as place:
            if ending not in UNIVERSAL:
                write_arrays(place, self.arrays(), ending)
                return path
            each = list(coordinate_units(units, self.names).values())
            modes = [(mode.eigenvalue, shape) for mode in self.modes if mode.kind not in STILL for shape in mode.shapes.T]
            write_modes(place, modes, self.names, each, geometry or Geometry(), path.stem)
        return path


def _shares(modes: Sequence[Mode]) -> tuple[tuple[EnergyShares, ...], ...]:
    """Energy shares of the shapes of each mode of one system."""
    parts, counts = (modes[0].energy_parts if modes else None), [mode.shapes.shape[1] for mode in modes]
    if parts is None or not sum(counts):
        return ((),) * len(modes)
    values = np.repeat([mode.eigenvalue for mode in modes], counts)
    each = iter(parts.shares_of(np.hstack([mode.shapes for mode in modes]), values))
    result = [tuple(islice(each, count)) for count in counts]
    return tuple(
        tuple(replace(one, kinetic=None) for one in own) if mode.kind == "offset" else own for mode, own in zip(modes, result)
    )


def _table_row(mode: Mode) -> dict[str, str]:
    oscillating, (real, imaginary) = bool(mode.eigenvalue.imag), (mode.eigenvalue.real, mode.eigenvalue.imag)
    growth = f"{real:.6g} " if real else ""
    return {
        "kind": mode.kind,
        "frequency (Hz)": f"{mode.frequency_hz:.6g}" if oscillating else "",
        "damping ratio": f"{mode.damping_ratio:.4g}" if oscillating else "",
        "eigenvalue (1/s)": f"{growth}± {imaginary:.6g} i" if oscillating else f"{real:.6g}",
        "natural frequency (rad/s)": f"{mode.natural_frequency:.6g}" if oscillating else "",
        "multiplicity": str(mode.multiplicity),
        "meaning": mode.text,
    }
