"""Random inputs transformed to independent ones: coherent inputs of one shape are combined, filters become equations.

Inputs whose spectra are proportional and whose coherences are real have S = G(f) L L^T: B L replaces B, and terms
that cancel are exactly zero. Filtered noise u = n(s) q, d(s) q = w has a white input w in the equations

    [[A(s), -b n(s)], [0, d(s)]],

so that zeros of the filter at poles of the system, and poles of the filter, are treated as all others.
"""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import scipy.linalg

from ...polynomial.polynomial_matrix import PolynomialMatrix
from ..harmonic import Harmonic
from .spectra import Spectrum
from .spectral_matrix import INDEFINITE, SpectralMatrix
from .spectrum_pieces import PowerLaw, Rational


def independent_inputs(harmonic: Harmonic, spectra: SpectralMatrix) -> tuple[Harmonic, SpectralMatrix]:
    """An equivalent process whose inputs are as independent and as white as possible."""
    m = len(spectra.names)
    ratios = np.array([[one.ratio(other) for other in spectra.spectra] for one in spectra.spectra]).reshape(m, m)
    coupled = spectra.coherence != 0
    for i, j in spectra.cross:
        coupled[i, j] = coupled[j, i] = True
    if (np.isnan(ratios) & coupled).any():
        return harmonic, spectra
    if not spectra.longest_delay:
        harmonic, spectra = _combined(harmonic, spectra, ratios)
    return _with_filters(harmonic, spectra)


def _combined(harmonic: Harmonic, spectra: SpectralMatrix, ratios: np.ndarray):
    """Equations with B L for each group of coupled inputs; inputs with a cross spectrum of another shape or a complex one are kept."""
    share = spectra.coherence.copy()
    for (i, j), given in spectra.cross.items():
        own = spectra.spectra[i].ratio(given)
        if np.isnan(own) or own.imag or not own:
            return harmonic, spectra
        share[i, j] = share[j, i] = own.real / np.sqrt(ratios[i, j].real)
    columns, chosen = [], []
    for group in spectra.groups:
        first = group[0]
        size = np.sqrt(ratios[first, group].real)
        factor = _root(share[np.ix_(group, group)]) * size[:, None]
        columns.append(harmonic.inputs[:, group] @ factor)
        chosen += [(spectra.names[first], spectra.spectra[first])] * factor.shape[1]
    names, pieces = tuple(name for name, _ in chosen), tuple(spectrum for _, spectrum in chosen)
    inputs = np.hstack(columns) if columns else harmonic.inputs[:, :0]
    count = len(names)
    return replace(harmonic, inputs=inputs, input_names=names), SpectralMatrix(names, pieces, np.eye(count), np.zeros(count))


def _root(matrix: np.ndarray) -> np.ndarray:
    """L with L L^T = matrix, positive semidefinite, with as many columns as its rank: exact for independent and for fully coherent inputs."""
    if (matrix == np.diag(matrix.diagonal())).all():
        return np.diag(np.sqrt(matrix.diagonal()))
    factor, pivots, rank, _ = scipy.linalg.lapack.dpstrf(matrix, lower=1, tol=INDEFINITE * matrix.max())
    result = np.zeros_like(matrix)
    result[pivots - 1] = np.tril(factor)
    return result[:, :rank]


def _with_filters(harmonic: Harmonic, spectra: SpectralMatrix) -> tuple[Harmonic, SpectralMatrix]:
    """Equations with the filters as additional unknowns and white noise as input."""
    filtered = [(i, one.pieces[0]) for i, one in enumerate(spectra.spectra) if one.pieces and isinstance(one.pieces[0], Rational)]
    if not filtered:
        return harmonic, spectra
    A, r, extra = harmonic.A.coefficients, harmonic.A.size, len(filtered)
    degree = max(len(A), *(len(part) for _, piece in filtered for part in (piece.numerator, piece.denominator)))
    coefficients, imaginary = np.zeros((degree, r + extra, r + extra)), harmonic.imaginary
    coefficients[: len(A), :r, :r] = A
    inputs, white = np.pad(harmonic.inputs, ((0, extra), (0, 0))), list(spectra.spectra)
    for place, (i, piece) in enumerate(filtered, start=r):
        for k, (above, below) in enumerate(itertools.zip_longest(piece.numerator[::-1], piece.denominator[::-1], fillvalue=0.0)):
            coefficients[k, :r, place] = -above * harmonic.inputs[:, i]
            coefficients[k, place, place] = below
        inputs[:, i] = np.eye(r + extra)[place]
        white[i] = Spectrum((PowerLaw(0.0, np.inf, piece.intensity),), spectra.spectra[i].of, "white noise")
    sizes = harmonic.sizes
    if sizes is not None:
        own = np.abs(coefficients)
        own[: len(sizes), :r, :r] = sizes
        sizes = own
    if imaginary is not None:
        imaginary = np.pad(imaginary, (0, extra))
    outputs = np.pad(harmonic.outputs, ((0, 0), (0, extra)))
    extended = replace(harmonic, A=PolynomialMatrix(coefficients), inputs=inputs, outputs=outputs, imaginary=imaginary, sizes=sizes)
    return extended, replace(spectra, spectra=tuple(white))
