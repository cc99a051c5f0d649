"""RMS values of a family of systems under random excitation, from the stacked poles, of some systems one by one.

    E[y^2] = integral from 0 to infinity of H S H^H df

Octaves of the frequency are the panels of all systems. A pole f_k nearer to the middle of a panel than its width has the principal part
2 Re r / (f - f_k), r = R_k S(f_k) H(conj f_k)^H / (2 pi i), whose integral is a logarithm and an arc tangent; what remains is integrated
exactly by Gauss's rule, as in ``frequency.random.spectral_integral``. Nodes are common to all systems.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...frequency.random.random_response import RandomResponse
from ...frequency.random.spectra import KINDS
from ...frequency.random.spectral_matrix import SpectralMatrix
from ...ground.checks import counted
from ...ground.display import Displayed, TextTable, notice_table
from ...ground.notices import Notice, doubts_of
from ...ground.tolerances import EPS, FORM_ROUNDING, LINE_ACCURACY, STACKED_VARIANCE
from .family_modes import one_by_one
from .stacked_poles import TOGETHER
from .stacked_transfer import StackedTransfer
from .system_stack import SystemStack

NODES, WEIGHTS = np.polynomial.legendre.leggauss(16)

#: A pole nearer to the middle of a panel than so many half-widths counts as near (Gauss's rule is exact to 3.7^-32 without it).
NEAR = 2.0


@dataclass(frozen=True, repr=False, eq=False)
class FamilyRandomResponse(Displayed):
    """RMS values of S systems; ``response[3]`` is the ``RandomResponse`` of one.

    Attributes:
        family: the systems.
        rms: shape (S, p); infinite where the variance is.
        error_estimate: error estimate of the RMS values, relative, shape (S, p).
        outputs: names.
        units: units of the outputs.
        alone: places of the systems that were solved one by one.
        excitation: the arguments of ``MechanicalSystem.random_response``.
    """

    family: SystemStack
    rms: np.ndarray
    error_estimate: np.ndarray
    outputs: tuple[str, ...]
    units: tuple[str, ...]
    alone: np.ndarray
    excitation: tuple

    def _summary(self) -> str:
        return f"RMS values of {counted(len(self.family), 'system')}"

    def _tables(self) -> tuple[TextTable, ...]:
        return (notice_table(self.notices),)

    def __len__(self) -> int:
        return len(self.family)

    def __getitem__(self, index: int) -> RandomResponse:
        arguments, options = self.excitation
        return self.family[index].random_response(*arguments, **options)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """Notices on systems that were solved one by one and on inaccurate finite values."""
        worst = self.error_estimate.max(initial=0.0, where=np.isfinite(self.rms))
        return (*one_by_one(self.alone, len(self.family), STACKED_VARIANCE), *doubts_of("RMS values of a system", worst))


def family_random_response(family: SystemStack, excitation, outputs, quantity: str, options: dict) -> FamilyRandomResponse:
    """The RMS values of all systems."""
    arguments = (excitation, outputs, quantity)
    first = family[0].random_response(*arguments, **options)  # checks the arguments
    count, p = len(family), len(first.outputs)
    squares, errors = np.full((count, p), np.nan), np.full((count, p), np.inf)
    spectra = first.spectra
    if not (first.infinite or spectra.longest_delay or options.get("modal_damping") is not None):
        levels = [KINDS[spectrum.of] or 0 for spectrum in spectra.spectra]
        for begin in range(0, count, TOGETHER):
            at = slice(begin, begin + TOGETHER)
            transfer = StackedTransfer.of(family, at, first.harmonic, levels)
            if transfer is not None:
                squares[at], errors[at] = _variances(transfer, spectra)
    served = (errors <= STACKED_VARIANCE * squares).all(axis=1)
    with np.errstate(all="ignore"):
        rms, relative = np.sqrt(squares), errors / (2 * squares) + EPS
    relative[squares == 0] = 0.0
    alone = np.flatnonzero(~served)
    for place in alone.tolist():
        own = first if not place else family[place].random_response(*arguments, **options)
        rms[place], relative[place] = own.rms, own.error_estimate
    return FamilyRandomResponse(family, rms, relative, first.outputs, first.units, alone, (arguments, options))


@dataclass(frozen=True)
class _Panel:
    """Frequencies between two ends; of the tail to infinity the variable is 1/f.

    Attributes:
        lower, upper: in Hz, of the tail in s.
        middle: a frequency in the pieces of the spectra.
        is_tail: whether it reaches infinity.
    """

    lower: float
    upper: float
    middle: float
    is_tail: bool = False

    @property
    def nodes(self) -> tuple[np.ndarray, np.ndarray]:
        """Frequencies and weights of Gauss's rule."""
        half = (self.upper - self.lower) / 2
        own = self.lower + half + half * NODES
        return (1 / own, half * WEIGHTS / own**2) if self.is_tail else (own, half * WEIGHTS)


def _panels(corners: np.ndarray, low: float, high: float) -> Iterator[_Panel]:
    """Between corners, none wider than an octave; the first from 0 ends below all poles, the tail begins beyond them."""
    for a, b in pairwise(corners.tolist()):
        middle = a + 1.0 if np.isinf(b) else (a + b) / 2
        if np.isinf(b):
            b = max(2 * high, 2 * a)
            yield _Panel(0.0, 1 / b, middle, is_tail=True)
        if a == 0:
            first = min(low / 2, b)
            yield _Panel(0.0, first, middle)
            a = first
        if b > a:
            edges = np.geomspace(a, b, int(np.ceil(np.log2(b / a) - FORM_ROUNDING * EPS)) + 1)
            yield from (_Panel(one, two, middle) for one, two in pairwise([a, *edges[1:-1].tolist(), b]))


def _variances(transfer: StackedTransfer, spectra: SpectralMatrix) -> tuple[np.ndarray, np.ndarray]:
    """E[y^2] and estimates of its absolute errors, shape (S, p); infinite where poles on the axis or singular spectra are near."""
    poles = transfer.poles
    present = poles.weights > 0
    count, p = len(poles.values), len(transfer.outputs)
    f = np.where(present, poles.values, np.nan) / 2j / np.pi
    sizes = np.abs(f[present & poles.serve[:, None]])
    damped = poles.serve & np.where(present, poles.values.real < -LINE_ACCURACY * np.abs(poles.values), True).all(axis=1)
    if not sizes.size or not damped.any():
        return np.full((count, p), np.nan), np.full((count, p), np.inf)
    panels = list(_panels(spectra.corners, sizes.min(), sizes.max()))
    middles = np.array([np.nan if one.is_tail else (one.lower + one.upper) / 2 for one in panels])
    halves = np.array([(one.upper - one.lower) / 2 for one in panels])
    for middle in {one.middle for one in panels}:
        others = np.array([one for one in spectra.singularities(middle) if one], dtype=complex)
        if (np.abs(middles[:, None] - others) < NEAR * halves[:, None]).any():
            return np.full((count, p), np.nan), np.full((count, p), np.inf)
    nodes, weights = (np.concatenate(each) for each in zip(*(one.nodes for one in panels)))
    S = np.concatenate([spectra(one.nodes[0], one.middle) for one in panels], axis=2)
    with np.errstate(all="ignore"):
        H, doubt = transfer(2j * np.pi * nodes)
        weighted = np.einsum("ijf,sajf->saif", S, H.conj())
        total = ((H * weighted).sum(axis=2).real * weights).sum(axis=2)
        spread = np.einsum("ijf,sajf->saif", np.abs(S), doubt)
        error = (((2 * np.abs(H) + doubt) * spread).sum(axis=2) * weights).sum(axis=2)
        mirrored = transfer(-np.where(present, poles.values, 1.0).conj())[0]  # H at conj f_k, shape (S, p, m, P)
        residues = transfer.residues() / (2j * np.pi)
        member, pole, panel = np.nonzero(np.abs(f[:, :, None] - middles) < NEAR * halves)
        at = f[member, pole]
        own = np.empty((len(S), len(S), len(at)), dtype=complex)
        for middle in {one.middle for one in panels}:
            chosen = np.array([one.middle == middle for one in panels])[panel]
            own[:, :, chosen] = spectra(at[chosen], middle)
        r = np.einsum("xai,ijx,xaj->xa", residues[member, :, :, pole], own, mirrored[member, :, :, pole].conj())
        lower, upper = (np.array([getattr(one, name) for one in panels])[panel] for name in ("lower", "upper"))
        grid = nodes.reshape(len(panels), -1)[panel] - at.real[:, None]
        share = weights.reshape(len(panels), -1)[panel] / (grid**2 + at.imag[:, None] ** 2)
        height = np.abs(at.imag)
        logarithm = np.log(((upper - at.real) ** 2 + height**2) / ((lower - at.real) ** 2 + height**2)) / 2
        angle = np.arctan2((upper - lower) * height, height**2 + (upper - at.real) * (lower - at.real))
        sums = (share * grid).sum(axis=1), (share * height[:, None]).sum(axis=1)
        turned = np.sign(at.imag)
        np.add.at(
            total, member, 2 * (r.real * (logarithm - sums[0])[:, None] - (r.imag * turned[:, None]) * (angle - sums[1])[:, None])
        )
        sizes = np.abs(r.real) * (np.abs(logarithm) + np.abs(sums[0]))[:, None] + np.abs(r.imag) * (angle + sums[1])[:, None]
        np.add.at(error, member, 2 * FORM_ROUNDING * EPS * sizes)
        own_errors = (2 * poles.shape_errors + poles.value_errors)[member, pole, None]
        own_errors = own_errors + (poles.value_errors * np.abs(poles.values) / np.abs(poles.values.real))[member, pole, None]
        np.add.at(error, member, 2 * own_errors * np.abs(r) * angle[:, None])
    good = damped & np.isfinite(total).all(axis=1) & np.isfinite(error).all(axis=1)
    return np.where(good[:, None], total, np.nan), np.where(good[:, None], error, np.inf)
