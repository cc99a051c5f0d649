"""The Hermitian matrix of spectra of several random inputs: independent, partly coherent, delayed, or with cross spectra."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from ...ground.checks import nearest, real_number
from ...ground.errors import InputError
from ...ground.tolerances import EPS
from .spectra import Spectrum

#: A Hermitian matrix counts as positive semidefinite where no eigenvalue is below this share of the largest one.
INDEFINITE = 1e4 * EPS

#: Frequencies between two corners at which that is tested.
EACH_PIECE = 9


@dataclass(frozen=True, eq=False)
class SpectralMatrix:
    """S(f) with the spectra on the diagonal and S_ij = coherence_ij sqrt(S_i S_j) e^{-i w (delay_i - delay_j)}, or given cross spectra."""

    names: tuple[str, ...]  # names of the m inputs
    spectra: tuple[Spectrum, ...]  # spectra of each
    coherence: np.ndarray  # square roots of the ordinary coherence, symmetric, shape (m, m)
    delays: np.ndarray  # in s, shape (m,)
    cross: Mapping[tuple[int, int], Spectrum] = field(default_factory=dict)  # given entries (i, j) with i < j

    @property
    def corners(self) -> np.ndarray:
        """Corner frequencies of all entries in Hz, ascending; the last may be infinite."""
        return np.unique([corner for spectrum in (*self.spectra, *self.cross.values()) for corner in spectrum.corners])

    @property
    def longest_delay(self) -> float:
        """The largest difference of two delays in s."""
        return max(self.shifts, default=0.0)

    @property
    def coupled(self) -> np.ndarray:
        """Which inputs are coherent or have a cross spectrum, shape (m, m)."""
        coupled = self.coherence != 0
        for i, j in self.cross:
            coupled[i, j] = coupled[j, i] = True
        return coupled

    @property
    def groups(self) -> list[list[int]]:
        """The indices of inputs that depend on each other, directly or indirectly."""
        from scipy.sparse.csgraph import connected_components

        count, label = connected_components(self.coupled, directed=False)
        return [np.flatnonzero(label == number).tolist() for number in range(count)]

    def of_inputs(self, chosen: list[int]) -> SpectralMatrix:
        """The matrix of some of the inputs."""
        at = {i: place for place, i in enumerate(chosen)}
        cross = {(at[i], at[j]): given for (i, j), given in self.cross.items() if i in at and j in at}
        names, spectra = tuple(self.names[i] for i in chosen), tuple(self.spectra[i] for i in chosen)
        return SpectralMatrix(names, spectra, self.coherence[np.ix_(chosen, chosen)], self.delays[chosen], cross)

    @property
    def delayed_pairs(self) -> list[tuple[int, int]]:
        """Coherent inputs (i, j) with different delays, i > j."""
        return [
            (i, j) for i in range(len(self.delays)) for j in range(i) if self.coherence[i, j] and self.delays[i] != self.delays[j]
        ]

    @property
    def shifts(self) -> list[float]:
        """The moduli of the differences of these delays in s."""
        return [abs(self.delays[i] - self.delays[j]) for i, j in self.delayed_pairs]

    def singularities(self, middle: float) -> list[complex]:
        """Frequencies near which the piece at ``middle`` is not analytic."""
        chosen = [spectrum.piece_at(middle) for spectrum in (*self.spectra, *self.cross.values())]
        pairs = ((i, j) for i in range(len(self.spectra)) for j in range(i) if self.coherence[i, j])
        has_roots = any(chosen[i] != chosen[j] for i, j in pairs)
        return [
            one for piece in chosen if piece is not None and (has_roots or not hasattr(piece, "end")) for one in piece.singularities
        ]

    def slopes(self, middle: float) -> np.ndarray:
        """The exponent of f of each spectrum towards infinity, minus infinity where it is zero, shape (m,)."""
        pieces = [spectrum.piece_at(middle) for spectrum in self.spectra]
        return np.array([-np.inf if piece is None else piece.slope for piece in pieces])

    def __call__(self, f: np.ndarray, middle: float) -> np.ndarray:
        """S at real or complex frequencies, continued from the pieces at ``middle``, shape (m, m, F)."""
        f = np.asarray(f)
        pieces = [spectrum.piece_at(middle) for spectrum in self.spectra]
        own = [np.zeros(f.shape, dtype=complex) if piece is None else np.asarray(piece(f), dtype=complex) for piece in pieces]
        m = len(pieces)
        S = np.zeros((m, m, len(f)), dtype=complex)
        for i in range(m):
            S[i, i] = own[i]
            for j in range(i):
                given = self.cross.get((j, i))
                if given is not None:
                    piece = given.piece_at(middle)
                    if piece is not None:
                        S[j, i], S[i, j] = piece(f), np.conj(piece(np.conj(f)))
                elif self.coherence[i, j]:
                    size = own[i] if pieces[i] == pieces[j] else np.sqrt(own[i]) * np.sqrt(own[j])
                    turn = np.exp(-2j * np.pi * f * (self.delays[i] - self.delays[j]))
                    S[i, j], S[j, i] = self.coherence[i, j] * size * turn, self.coherence[i, j] * size / turn
        return S

    def within(self, low: float, high: float) -> SpectralMatrix:
        """The matrix between two frequencies, zero outside."""
        spectra = tuple(spectrum.within(low, high) for spectrum in self.spectra)
        return replace(self, spectra=spectra, cross={key: spectrum.within(low, high) for key, spectrum in self.cross.items()})

    def check(self) -> None:
        """Refuse a matrix that is not positive semidefinite."""
        corners = self.corners
        if not len(corners) or not (self.cross or (self.coherence != np.eye(len(self.names))).any()):
            return
        ends = np.append(corners[:-1], corners[-1] if np.isfinite(corners[-1]) else corners[-2] + 1.0)
        for f in np.unique(np.linspace(ends[:-1], ends[1:], EACH_PIECE)):
            values = np.linalg.eigvalsh(self(np.array([f]), f)[..., 0])
            if values[0] < -INDEFINITE * max(values[-1], np.finfo(float).tiny):
                raise InputError(
                    f"the spectra of {', '.join(self.names)} are not those of one process: at {f:g} Hz their Hermitian matrix has a negative eigenvalue; "
                    "expected |S_ij|^2 <= S_ii S_jj and coherences that fit each other"
                )


def spectral_matrix(excitation: Mapping, coherence=None, delays: Mapping | None = None) -> SpectralMatrix:
    """The spectral matrix of a table of spectra."""
    if not isinstance(excitation, Mapping) or not excitation:
        raise InputError('excitation: expected a table of spectra by the names of inputs, such as {"base": mb.psd(...)}')
    for name, spectrum in excitation.items():
        if not isinstance(spectrum, Spectrum):
            raise InputError(
                f"excitation of {name}: found an object of type {type(spectrum).__name__}; expected mb.psd(...) or mb.white_noise(...)"
            )
        if spectrum.is_complex and not isinstance(name, tuple):
            raise InputError(f"excitation of {name}: found complex values, which only cross spectra of two inputs have")
    names = tuple(name for name in excitation if not isinstance(name, tuple))
    places = {name: place for place, name in enumerate(names)}

    def pair(key) -> tuple[int, int]:
        if not isinstance(key, tuple) or len(key) != 2 or key[0] == key[1]:
            raise InputError(f"found {key!r}; expected a pair of names of different inputs")
        for name in key:
            if name not in places:
                raise InputError(f"{key}: there is no input {name!r}{nearest(str(name), names)}")
        return places[key[0]], places[key[1]]

    if delays is not None and not isinstance(delays, Mapping):
        raise InputError(f"delays: found {delays!r}; expected a table by the names of inputs, such as {{{names[0]!r}: 0.1}}")
    gamma, shift, cross = np.eye(len(names)), np.zeros(len(names)), {}
    for name, value in (delays or {}).items():
        if name not in places:
            raise InputError(f"delays: there is no input {name!r}{nearest(str(name), names)}")
        shift[places[name]] = real_number(value, f"delay of {name}")
    if isinstance(coherence, Mapping):
        for key, value in coherence.items():
            i, j = pair(key)
            gamma[i, j] = gamma[j, i] = _coherence(value, f"coherence of {key[0]} and {key[1]}")
    elif coherence is not None or delays:
        share = 1.0 if coherence is None else _coherence(coherence, "coherence")
        gamma = np.full(gamma.shape, share)
        np.fill_diagonal(gamma, 1.0)
    for key, spectrum in excitation.items():
        if isinstance(key, tuple):
            i, j = pair(key)
            if key[::-1] in excitation:
                raise InputError(
                    f"excitation: the cross spectrum of {key[0]} and {key[1]} is given twice, in both orders; give one"
                )
            if shift[i] != shift[j]:
                raise InputError(
                    f"delays: {key[0]} and {key[1]} have a cross spectrum, which has their delay already; give one of both"
                )
            cross[min(i, j), max(i, j)] = spectrum if i < j else _conjugate(spectrum)
    result = SpectralMatrix(names, tuple(excitation[name] for name in names), gamma, shift, cross)
    result.check()
    return result


def _coherence(value, what: str) -> float:
    number = real_number(value, what, minimum=0.0)
    if number > 1:
        raise InputError(f"{what}: found {number:g}; expected a number from 0 to 1")
    return float(np.sqrt(number))


def _conjugate(spectrum: Spectrum) -> Spectrum:
    pieces = [
        replace(piece, level=np.conj(piece.level), **({"end": np.conj(piece.end)} if hasattr(piece, "end") else {}))
        for piece in spectrum.pieces
    ]
    return Spectrum(tuple(pieces), spectrum.of, spectrum.name)
