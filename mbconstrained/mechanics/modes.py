"""The modes of a mechanical system: each eigenvalue with its shapes and its meaning for the machine, and tables of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import islice, pairwise
from pathlib import Path
from typing import ClassVar, Literal, NamedTuple

import numpy as np
import scipy

from ..exchange.trajectories import write_arrays
from ..exchange.universal import UNIVERSAL, Geometry, write_modes
from ..ground.by_name import Public
from ..ground.checks import counted, item_of, whole_number
from ..ground.display import Presented, TextTable, notice_table
from ..ground.errors import InputError
from ..ground.files import replacing
from ..ground.named_arrays import named_array
from ..ground.notices import Notice, NoticeKind
from ..ground.threads import short_work
from ..ground.tolerances import (
    DECOUPLING_LIMIT,
    DIVISOR_CONDITION,
    EPS,
    NOISE_SAFETY,
    STIFFNESS_CONDITION,
    noise_of,
    rounding_radius,
)
from ..ground.units import coordinate_units
from ..linalg.arrays import block_diag, full, kept, lapack, product
from ..linalg.blocks import block_slices
from ..linalg.division import definite_condition, is_symmetric, solved
from ..linalg.exponential import BlockGroups
from ..linalg.precise import floats, is_precise, is_worthwhile, precise_arithmetic
from ..linalg.rank import null_columns
from ..linalg.symmetric import undamped_shapes
from ..polynomial.decoupling import known_coefficient
from ..polynomial.polynomial_matrix import PolynomialMatrix
from ..polynomial.reduced_equations import NotReducible, Reduction
from ..response.choose import serving_reduction
from ..signals.inputs import zero
from .energy import EnergyParts, EnergyShares
from .equations import EquationsOfMotion

Kind = Literal["oscillation", "decay", "growth", "rigid body", "drift", "offset"]

#: Kinds of modes that are no motion of a structure, which universal files leave out.
STILL = ("drift", "offset", "decay")


@dataclass(frozen=True, eq=False)
class Mode(Public):
    """A finite eigenvalue of a mechanical system (of a complex pair the one above the real axis) with its shapes and meaning.

    A(s) u = 0 with the eigenvalue s and a shape u; the free motion of the mode is Re(u e^{s t}).

    Attributes:
        kind: "oscillation", "decay", "growth", "rigid body", "drift" or "offset".
        eigenvalue: s in 1/s.
        multiplicity: multiplicity of s as a root of det A(s).
        shapes: the independent shapes, one a column, shape (n, g), the largest entry of each 1; none for drift. Of ``Modes`` with the
            names of the coordinates, ``mode.shapes["cart"]``.
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

    _instead: ClassVar = {"frequency": "frequency_hz", "damping": "damping_ratio", "period": "1 / frequency_hz"}

    @property
    def shape(self) -> np.ndarray:
        """The only shape, (n,), with the names of the coordinates: ``mode.shape["cart"]``.

        Raises:
            InputError: none or several shapes, which ``shapes`` has.
        """
        if (count := self.shapes.shape[1]) != 1:
            raise InputError(f"shape: this mode has {counted(count, 'shape')} ({self.text}); they are the columns of shapes")
        return named_array(self.shapes[:, 0], *getattr(self.shapes, "names", ()))

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
        return Modes((self,), ("",) * len(self.shapes)).shares[0]

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

    Modes of sparse matrices are those of lowest frequency, whose shapes satisfy the constraints: real with X^T M X = I without damping, else
    complex with x^T (2 s M + C) x = 2 i |Im s|. They have attributes with the evidence of their search, from ``vectors`` on, which modes
    of arrays and slices do not have (None).

    Attributes:
        modes: one ``Mode`` for each finite eigenvalue; an eigenvalue 0 is split into rigid body, offset and drift.
        names: names of the coordinates, in the order of the rows of the shapes.
        polynomial_matrix: A(s) with A(s) u = 0 for each eigenvalue s and shape u; None where it is not known.
        system: system of arrays, that has these modes; None where it is not known.
        vectors: the shapes of all modes, one a column, shape (n, m).
        bounds: the part of the residuals that rounding errors and the stopping rule explain, in the same measure, shape (m,).
        orthogonality: the largest entry of X^T M X - I; of damped modes that of the corresponding bilinear form.
        counted_below: the frequency in rad/s below which Sylvester's law of inertia counted the undamped modes; None where it
            could not.
        none_missed: whether the count agrees with the modes below that frequency.
        complete: whether the system has no other finite undamped modes.
        notices: modes that may be missing, residuals beyond their bound, redundant rows.
    """

    modes: tuple[Mode, ...]
    names: tuple[str, ...]
    polynomial_matrix: PolynomialMatrix | None = field(default=None, repr=False, kw_only=True)
    system: EquationsOfMotion | None = field(default=None, repr=False, compare=False, kw_only=True)
    vectors: np.ndarray | None = field(default=None, kw_only=True)
    _residuals: np.ndarray | None = field(default=None, kw_only=True)
    bounds: np.ndarray | None = field(default=None, kw_only=True)
    orthogonality: float | None = field(default=None, kw_only=True)
    counted_below: float | None = field(default=None, kw_only=True)
    none_missed: bool | None = field(default=None, kw_only=True)
    complete: bool | None = field(default=None, kw_only=True)
    notices: tuple[Notice, ...] = field(default=(), kw_only=True)

    _instead: ClassVar = {
        "damping": "damping_ratios",
        "frequencies": "frequencies_hz",
        **dict.fromkeys(
            ("MAC", "mac"), 'the modes of two scenes are compared by mb.read_scene("FILE.toml").mac(other="OTHER.toml")'
        ),
    }

    def __len__(self) -> int:
        return len(self.modes)

    def __getitem__(self, index):
        """A ``Mode``; for a slice ``Modes``; for the name of a coordinate its part of the shapes of the oscillating modes, shape (m,).

        Raises:
            InputError: an unknown name, a number beyond the last mode.

        >>> from mbconstrained import MechanicalSystem
        >>> modes = MechanicalSystem([[1.0, 0], [0, 1.0]], stiffness=[[2.0, -1], [-1, 2.0]], names=["cart", "load"]).modes()
        >>> bool(np.isclose(abs(modes["cart"][0]), abs(modes["load"][0])))
        True
        """
        if isinstance(index, (str, list)):
            return self.shapes[index]
        if not isinstance(index, slice):
            return self.modes[item_of(index, len(self), "mode")]
        return Modes(self.modes[index], self.names, polynomial_matrix=self.polynomial_matrix, system=self.system)

    def _summary(self) -> str:
        hz = self.frequencies_hz
        band = f": {hz[0]:.4g} Hz" + (f" to {hz[-1]:.4g} Hz" if len(hz) > 1 else "") if len(hz) else ""
        count = "" if self.none_missed is None else ", none missed" if self.none_missed else ", not counted"
        return f"{counted(len(self), 'mode')} of {counted(len(self.names), 'coordinate')}{band}{count}"

    def _tables(self) -> tuple[TextTable, ...]:
        columns = ("kind", "frequency (Hz)", "damping ratio")
        rows = ((str(number), *(row[column] for column in columns)) for number, row in enumerate(self.table(), 1))
        return TextTable("Modes", ("no.", *columns), tuple(rows)), *(
            (notice_table(self.notices),) if self.bounds is not None else ()
        )

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
        _, values, shapes = self._columns
        counts = [(mode.shapes.shape[1] - 1, mode.multiplicity) for mode in self.oscillating]
        repeats = [n for before, multiplicity in counts for n in (*(1,) * before, multiplicity - before)]
        columns = shapes[:, values.imag != 0].repeat(repeats, axis=1)
        return named_array(columns if columns.dtype.kind == "c" and columns.imag.any() else columns.real, self.names)

    @cached_property
    def shares(self) -> tuple[tuple[EnergyShares, ...], ...]:
        """Energy shares of each mode (``Mode.shares``)."""
        parts, (places, values, shapes) = self.modes[0].energy_parts if self.modes else None, self._columns
        if parts is None or not len(places):
            return ((),) * len(self.modes)
        each = iter(parts._shares_of(shapes, values))
        result = [tuple(islice(each, mode.shapes.shape[1])) for mode in self.modes]
        for place, mode in enumerate(self.modes):
            if mode.kind == "offset":
                result[place] = tuple(replace(one, kinetic=None) for one in result[place])
        return tuple(result)

    @cached_property
    def residuals(self) -> np.ndarray:
        """|A(s) u| of each mode without constraint forces, relative to the sizes of its terms, the largest of its shapes, shape (m,)."""
        if self._residuals is not None:
            return self._residuals
        result, (places, s, u) = np.zeros(len(self.modes)), self._columns
        if self.polynomial_matrix is None or not len(places):
            return result
        left, size = np.zeros(u.shape), np.abs(u)
        terms = np.zeros(u.shape)
        for k, matrix in enumerate(self.polynomial_matrix.coefficients):
            if matrix.any():
                power, (forces, sizes) = s**k, product(kept(matrix), u, size)
                left = left + (power if power.imag.any() else power.real) * forces  # of undamped modes all is real
                terms = terms + np.abs(power) * sizes
        left, terms = np.sqrt((left * left.conj()).real.sum(axis=0)), np.sqrt((terms**2).sum(axis=0))
        np.maximum.at(result, places, left / np.where(terms > 0, terms, 1.0))
        return result

    @cached_property
    def _columns(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The mode of each shape and its eigenvalue, shape (g,), and the shapes, shape (n, g)."""
        places = np.repeat(np.arange(len(self.modes)), [mode.shapes.shape[1] for mode in self.modes])
        shapes = np.concatenate([np.zeros((len(self.names), 0)), *[mode.shapes for mode in self.modes]], axis=1)
        return places, np.array([mode.eigenvalue for mode in self.modes], dtype=complex)[places], shapes

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
        """A row of texts per mode: kind, frequency in Hz, damping ratio, eigenvalue, frequency in rad/s, multiplicity, meaning.

        Of sparse matrices also the residual.
        """
        residuals = [{}] * len(self) if self.bounds is None else [{"residual": f"{one:.2g}"} for one in self.residuals]
        rows = []
        for mode, residual in zip(self.modes, residuals):
            real, imaginary = mode.eigenvalue.real, mode.eigenvalue.imag
            growth = f"{real:.6g} " if real else ""
            rows.append(
                {
                    "kind": mode.kind,
                    "frequency (Hz)": f"{mode.frequency_hz:.6g}" if imaginary else "",
                    "damping ratio": f"{mode.damping_ratio:.4g}" if imaginary else "",
                    "eigenvalue (1/s)": f"{growth}± {imaginary:.6g} i" if imaginary else f"{real:.6g}",
                    "natural frequency (rad/s)": f"{mode.natural_frequency:.6g}" if imaginary else "",
                    "multiplicity": str(mode.multiplicity),
                    "meaning": mode.text,
                    **residual,
                }
            )
        return rows

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


# The modes of a mechanical system: eigenvalues and shapes by LAPACK where equations reduce to a regular matrix, else by Jordan pairs.
#
# A row at acceleration or velocity level is the row at position level with a factor s^2 or s,
# det [V^T P(s); A s^level] = s^(sum of levels) det [V^T P(s); A]: those eigenvalues 0 are the drift of the constraints and
# no motion of the bodies. All others are therefore computed from the form with every row at position level. There an eigenvalue 0
# with an elementary divisor s^2 (or higher) is a rigid-body motion, of which displacement and velocity are free; one with the
# divisor s is an offset, a displacement without restoring force.


def modes_of(system: EquationsOfMotion) -> Modes:
    """The modes of the constrained form: by the reduced equations, which motions share, else by the Jordan pairs."""
    A = system.position_form().polynomial_matrix
    with short_work(2 * system.size):
        definite = _is_definite(A)
        try:
            moving, resting = _by_reduction(A, definite)
        except NotReducible:
            moving, resting = _by_pairs(A)
        conservation = conservation_of(system, definite)
    if drift := sum(row.order for row in system.rows):
        resting.append(Mode("drift", 0j, drift, np.zeros((system.size, 0))))
    names = system.names
    modes = [replace(mode, shapes=named_array(mode.shapes, names), system=system) for mode in resting]
    for value, multiplicity, shapes, precise in moving:
        value = cleaned(value, multiplicity, conservation, precise)
        modes.append(Mode(kind_of(value), value, multiplicity, named_array(shapes, names), system))
    return Modes(tuple(modes), names, polynomial_matrix=A, system=system)


#: With at most so many entries in a row, forms of a matrix are sums over differences of coordinates.
FEW_DIFFERENCES = 4

#: Eigenvalue, multiplicity, shapes, and whether the eigenvalue is that of a precise computation.
Moving = tuple[complex, int, np.ndarray, bool]


def _is_definite(A: PolynomialMatrix) -> bool:
    """Whether M, C and K are symmetric, M and K positive definite and well-conditioned: the equations are their own reduction."""
    if A.degree != 2 or any(factors is not None for factors in A.factors) or A.is_uncertain:
        return False
    K, C, M = A.coefficients
    if (A.coefficients != A.coefficients.transpose(0, 2, 1)).any() and not (
        is_symmetric(M) and is_symmetric(C) and is_symmetric(K)
    ):
        return False
    return definite_condition(M) <= DIVISOR_CONDITION and definite_condition(K) <= STIFFNESS_CONDITION


def _by_reduction(A: PolynomialMatrix, definite: bool) -> tuple[list[Moving], list[Mode]]:
    """The modes from the decoupled first-order equations: those that move, and those of eigenvalue 0."""
    large = A.large_reduction if A.coefficients[1].any() else None
    if large is not None and large.topology is not None and not large.topology_failed:
        pass  # by the sparse topology of a large damped model: of fewer operations, and shared with motions
    elif definite:
        K, C, M = A.coefficients
        if symmetric := _symmetric_modes(M, C, K):
            return _grouped(*symmetric), []
    elif isinstance(own := A.reduction, Reduction) and len(own.second) and not len(own.first) and own.conserved is None:
        symmetric = _symmetric_modes(*map(full, (own.M, own.C, own.K))) if own.is_finite and own.is_reciprocal else None
        if symmetric:
            return _grouped(symmetric[0], own.V @ symmetric[1]), []
    reduction = serving_reduction(A, zero(A.size))
    parts = reduction.decoupled
    groups, outputs = BlockGroups.of(parts.blocks), parts.modal_output(reduction.output)
    if groups.larger:
        raise NotReducible("eigenvalues form a cluster")
    a, b, c, d = groups.pairs.reshape(-1, 4).T
    half, square = (a + d) / 2, ((a - d) / 2) ** 2 + b * c
    if (np.sqrt(np.abs(square)) <= rounding_radius(2) * np.abs(half))[half != 0].any():
        raise NotReducible("an eigenvalue is double to rounding errors")
    root = np.sqrt(square.astype(complex))
    larger = np.where(square < 0, half + root, half + np.copysign(root.real, half))
    smaller = np.where(square < 0, 0, (a * d - b * c) / np.where(larger == 0, 1, larger))
    real = square >= 0  # of the others, the conjugates are left out
    values = np.concatenate([groups.rates, larger, smaller[real]])
    vectors = [outputs[:, groups.first] * b + outputs[:, groups.first + 1] * (s - a) for s in (larger, smaller)]
    shapes = np.hstack([outputs[:, groups.single], vectors[0], vectors[1][:, real]])
    computed = values
    if reduction.freed is not None:  # what the rounding errors of K support has the eigenvalue 0
        values = np.where(np.abs(values) ** 2 <= EPS * np.abs(values).max() ** 2, 0.0, values)
    moving = values != 0
    count = int((~moving).sum() + (~moving & (computed.imag > 0)).sum())  # of a complex pair one is listed
    return _grouped(values[moving], shapes[:, moving]), [*_at_rest(A, count)]


def _symmetric_modes(M: np.ndarray, C: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Eigenvalues and shapes where M, C and K are symmetric, M and K regular: LAPACK's, refined; None where that does not serve.

    The shape x is its own left vector then, and s a root of x^T (M s^2 + C s + K) x, wrong by the square of the error of x
    (Lancaster 1961). Where x^T (2 M s + C) x is small next to its terms, the eigenvalue is nearly double.
    """
    damped = C.any()
    with np.errstate(over="ignore", invalid="ignore"):
        values, X = _damped_modes(M, C, K) if damped else (None, undamped_shapes(M, K))
    if X is None:
        return None
    inertia, stiffness = _forms(M, X), _forms(K, X)
    if damped:
        size, moduli = np.abs(X), np.abs(values)
        slope = 2 * values * inertia + (damping := _forms(C, X))
        terms = (size * (np.abs(M) @ (2 * moduli * size) + np.abs(C) @ size)).sum(axis=0)
        if not (terms <= DECOUPLING_LIMIT * np.abs(slope)).all():
            return None
        change = -((values * inertia + damping) * values + stiffness) / slope
        values = np.where(np.abs(change) <= EPS**0.5 * moduli, values + change, values)
    else:
        values = np.sqrt((-stiffness / inertia).astype(complex))
        if (real := values.imag == 0).any():
            values, X = np.concatenate([values, -values[real]]), np.hstack([X, X[:, real]])
    moduli = np.abs(values)
    if not (np.isfinite(moduli).all() and moduli.all()) or is_worthwhile(moduli.max() / moduli.min(), len(M) * 2):
        return None
    return values, X


def _damped_modes(M: np.ndarray, C: np.ndarray, K: np.ndarray) -> tuple[np.ndarray, np.ndarray] | tuple[None, None]:
    """Eigenvalues on or above the real axis, and shapes, from the states (x, x'), which LAPACK balances; None where that fails."""
    n = len(M)
    S = np.eye(2 * n, k=-n).T  # by columns, as LAPACK has it
    S[n:] = -solved(M, np.concatenate([K, C], axis=1))
    if not np.isfinite(S).all():
        return None, None
    room = int(lapack.dgeev_lwork(2 * n, compute_vl=0)[0])
    real, imaginary, _, vectors, failed = lapack.dgeev(S, compute_vl=0, lwork=room, overwrite_a=1)
    if failed:
        return None, None
    upper = (imaginary >= 0).nonzero()[0]
    X, pair = vectors[:n, upper].astype(complex), imaginary[upper] > 0
    X.imag[:, pair] = vectors[:n, upper[pair] + 1]
    return real[upper] + 1j * imaginary[upper], X


def _forms(matrix: np.ndarray, X: np.ndarray) -> np.ndarray:
    """x^T A x for each column; of a sparse A by differences of coordinates, in which nothing of a slow motion cancels."""
    if np.count_nonzero(matrix) > (2 * FEW_DIFFERENCES + 1) * len(matrix):
        return np.einsum("ij,ij->j", X, matrix @ X)
    row, column = matrix.nonzero()
    upper, values, sums = row < column, matrix[row, column], np.zeros(len(matrix), dtype=np.longdouble)
    if not upper.any():
        return matrix.diagonal() @ X**2
    np.add.at(sums, row, values)
    return sums.astype(float) @ X**2 - values[upper] @ (X[row[upper]] - X[column[upper]]) ** 2


def _grouped(values: np.ndarray, shapes: np.ndarray) -> list[Moving]:
    """Eigenvalues with their multiplicities, ascending, and their shapes."""
    order, ends = _equal(values)
    values, shapes, begin, result = values[order], _normalized(shapes[:, order]), 0, []
    numbers, parts, real = values.tolist(), shapes, [True] * len(order)
    if shapes.dtype.kind == "c":
        real, parts = (np.abs(shapes.imag).max(axis=0, initial=0.0) <= noise_of(1.0, len(shapes))).tolist(), shapes.real.copy()
    for end in ends:
        value = numbers[begin] if end == begin + 1 else complex(values[begin:end].mean())
        result.append((value, end - begin, (parts if all(real[begin:end]) else shapes)[:, begin:end], False))
        begin = end
    return result


def _equal(values: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """An order of eigenvalues, ascending by modulus, then real part, and the ends of groups equal to rounding errors."""
    moduli = np.abs(values)
    order = moduli.argsort(kind="stable")
    moduli = moduli[order]
    ends = [*((moduli[1:] - moduli[:-1] > rounding_radius(2) * moduli[1:]).nonzero()[0] + 1).tolist(), *[len(order)][: len(order)]]
    if len(ends) == len(order):
        return order, ends
    result: list[int] = []
    for begin, end in pairwise([0, *ends]):
        if end > begin + 1:
            ring = order[begin:end]
            parts = np.round(values[ring].real / (rounding_radius(2) * moduli[end - 1]))
            order[begin:end] = ring = ring[np.lexsort([values[ring].imag, parts])]
            differ = np.abs(np.diff(values[ring])) > rounding_radius(1) * moduli[end - 1]
            result += (begin + 1 + np.flatnonzero(differ)).tolist()
        result.append(end)
    return order, result


def _by_pairs(A: PolynomialMatrix) -> tuple[list[Moving], list[Mode]]:
    """Moving modes and modes of eigenvalue 0 from the finite Jordan pair: shapes C v with the eigenvectors v of J.

    A(s) C (s I - J)^-1 B = I, so that A(s) C v = 0 where J v = s v. A(s) itself is never formed: next to stiff parts it has
    lost the digits of soft ones.
    """
    pair, moving = A.jordan_pairs().finite, []
    columns, precise = block_slices(pair.blocks), pair.form.companion.is_precise
    owner = np.repeat(np.arange(len(pair.blocks)), [len(block) for block in pair.blocks])
    values = np.concatenate([np.linalg.eigvals(block) for block in pair.blocks] or [np.zeros(0)])
    for place in (one for one in pair.zeros if one.value):
        chosen = np.unique(owner[np.argsort(np.abs(values - place.value), kind="stable")[: place.multiplicity]])
        J = block_diag(*(pair.blocks[i] for i in chosen))
        C = np.hstack([pair.C[:, columns[i]] for i in chosen])
        value = place.value if place.value.imag else place.value.real
        vectors = scipy.linalg.svd(J - value * np.eye(len(J)))[2].conj().T[:, len(J) - len(place.partial_multiplicities) :]
        moving.append((complex(place.value), place.multiplicity, _real(_normalized(C @ vectors)), precise))
    return moving, [mode for one in pair.zeros if not one.value for mode in _at_rest(A, one.multiplicity)]


def _at_rest(A: PolynomialMatrix, count: int) -> Iterator[Mode]:
    """The modes of eigenvalue 0 of this multiplicity with every row at position level, distinguished by their divisors."""
    if not count:
        return
    free, staying = rest_shapes(A)
    if bodies := count - staying.shape[1]:
        yield Mode("rigid body", 0j, bodies, free)
    if staying.shape[1]:
        yield Mode("offset", 0j, staying.shape[1], staying)


def kind_of(value: complex, resting: bool = False, noise: float = 0.0) -> Kind:
    """The kind of a mode with an eigenvalue, whose relative rounding error is noise; resting: that of a rigid body where it is 0."""
    if not value:
        return "rigid body" if resting else "offset"
    if value.real > noise * abs(value):
        return "growth"
    return "oscillation" if value.imag else "decay"


def cleaned(value: complex, multiplicity: int, conservation: Conservation, precise: bool = False) -> complex:
    """A computed eigenvalue without the parts that symmetry and signs of M, C and K exclude; a precise simple one is kept."""
    if conservation.passive and (conservation.lossless or value.real > 0):
        return complex(0.0, value.imag)
    if conservation.lossless:
        return complex(0.0, value.imag) if abs(value.imag) > abs(value.real) else complex(value.real)
    if precise and multiplicity == 1:
        return value
    # slower growth may be rounding error, which moves a defective eigenvalue farther than a simple one
    limit = rounding_radius(multiplicity) if value.real > 0 else NOISE_SAFETY * EPS
    return complex(value.real if abs(value.real) > limit * abs(value) else 0.0, value.imag)


def rest_shapes(A: PolynomialMatrix) -> tuple[np.ndarray, np.ndarray]:
    """The null space of A(0), where no force acts, as rigid body shapes and offset shapes, one a column.

    A shape u can also move on at constant velocity, and so begins a chain of the zero at 0, where A_1 u is balanced
    by some displacement: where w^T A_1 u = 0 for every w with w^T A_0 = 0. The others are offsets.
    """
    A_0, A_1 = known_coefficient(A, 0), known_coefficient(A, 1)
    with precise_arithmetic() if is_precise(A_0.data) or is_precise(A_1.data) else nullcontext():
        right, left = null_columns(A_0).null.T, null_columns(A_0.T).null.T
        moving = null_columns(left.T @ A_1 @ right).null.T
        staying = null_columns(moving.T).null.T
        free, offsets = (_real(_normalized(floats((right @ shapes).data))) for shapes in (moving, staying))
        return free, offsets


def _normalized(shapes: np.ndarray) -> np.ndarray:
    """Columns divided by their largest entries."""
    largest = np.abs(shapes).argmax(axis=0)
    return shapes / shapes[largest, range(shapes.shape[1])]


def _real(shapes: np.ndarray) -> np.ndarray:
    """Real where the imaginary parts are rounding errors."""
    return shapes.real if np.abs(shapes.imag).max(initial=0.0) <= noise_of(1.0, len(shapes)) else shapes


# Energy conservation from the symmetry and signs of M, C and K alone, independent of rounding in computed eigenvalues.


#: Up to this size the definiteness of nearly singular matrices is decided in extended precision, which takes 50 ms then.
EXTENDED_SIZE = 200


class Conservation(NamedTuple):
    """Two facts about a system."""

    # M, K and the symmetric part of C are positive semidefinite, M and K symmetric: energy cannot grow, no zero lies in the right
    # half plane
    passive: bool
    # every zero lies on the real or on the imaginary axis, because energy is kept: passive with a skew-symmetric (gyroscopic) C, or
    # no C at all with M, K symmetric and M positive semidefinite
    lossless: bool


def conservation_of(system: EquationsOfMotion, definite: bool = False) -> Conservation:
    """Conservation of energy and momentum from the matrices; constraint rows at rest change neither."""
    M, C, K = system.mass, system.damping, system.stiffness
    damped = C.any()
    conservative = definite or (is_symmetric(M) and is_symmetric(K) and _positive(M))
    passive = conservative and (definite or _positive(K)) and (not damped or _positive(C + C.T))
    lossless = conservative and (not damped or (passive and not (C + C.T).any()))
    return Conservation(passive, lossless)


def _positive(matrix: np.ndarray) -> bool:
    """Positive semidefinite to within the rounding errors of its entries, each coordinate in units in which it counts as the others."""
    size = np.sqrt(np.abs(matrix.diagonal()))
    size[size == 0] = 1.0
    matrix = matrix / size / size[:, None]
    sums = np.abs(matrix).sum(axis=0)
    noise, shifted = noise_of(float(sums.max()), len(matrix)), matrix.copy()
    shifted.reshape(-1)[:: len(matrix) + 1] -= noise
    if not lapack.dpotrf(shifted, clean=0)[1]:
        return True
    lowest = np.linalg.eigvalsh(matrix)[0]
    if lowest < -noise or len(matrix) > EXTENDED_SIZE:
        return bool(lowest >= -noise)
    work = matrix.astype(np.longdouble) + np.diag(EPS * sums)
    for k in range(len(work)):  # Cholesky's factorization in more digits than the entries have
        if work[k, k] < 0:
            return False
        if work[k, k]:
            work[k + 1 :, k + 1 :] -= np.outer(work[k + 1 :, k], work[k + 1 :, k] / work[k, k])
    return True


def modes_with_delays(system: EquationsOfMotion, count: int) -> Modes:
    """The rightmost of the infinitely many modes of a system with delays, ascending by modulus."""
    from ..polynomial.characteristic_roots import rightmost_roots

    roots = rightmost_roots(system.undelayed_form().polynomial_matrix, system.delayed_equations(), count)
    order = np.argsort(np.abs(roots.eigenvalues), kind="stable")
    modes = tuple(
        Mode(kind_of(value), value, 1, named_array(shape[:, None], system.names), system)
        for value, shape in zip(roots.eigenvalues[order].tolist(), roots.shapes.T[order])
    )
    text = f"delays make infinitely many modes; these are the {len(modes)} rightmost ones"
    return Modes(modes, system.names, system=system, notices=(Notice(NoticeKind.OMITTED, text), *roots.notices))
