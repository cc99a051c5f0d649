"""Existence of the variance of an output: poles on the axis, unstable poles, direct paths of white noise, slow decay.

The integral of f^k G(f) exists at infinity where the exponent of f is below -1, and at a pole on the axis where the spectrum vanishes fast enough.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from ...ground.display import number_text
from ...ground.tolerances import CLUSTER_SAFETY, EPS, NOISE_SAFETY
from ...linalg.precise import relative_degrees
from .spectral_matrix import SpectralMatrix
from .transfer import RefinedPole, SpectralTransfer

#: The exponent of a spectrum at zero frequency is measured at this share of the frequencies over which it changes.
NEXT_TO_ZERO = 1e-2


@dataclass(frozen=True, eq=False)
class Existence:
    """Reasons why integrals of f^k G(f) are infinite.

    Attributes:
        reasons: for each power k and output a sentence, "" where the integral is finite, shape (K, p).
        white_part: the one-sided intensity per Hz of the white part of each output, shape (p,); infinite where it is rougher than white noise.
    """

    reasons: np.ndarray
    white_part: np.ndarray


def existence(transfer: SpectralTransfer, spectra: SpectralMatrix, powers: tuple[int, ...], units: tuple[str, ...]) -> Existence:
    """Existence of the spectral integrals."""
    p = len(transfer.harmonic.outputs)
    reasons = np.full((len(powers), p), "", dtype=object)
    has_structural_damping = transfer.harmonic.imaginary is not None  # then H holds for f > 0 and has no stable poles below
    for pole in transfer.poles:
        if has_structural_damping and pole.value.imag < 0:
            continue
        for output in np.flatnonzero(pole.residues.any(axis=(0, 2))).tolist():
            for row, power in enumerate(powers):
                reasons[row, output] = reasons[row, output] or _at_pole(pole, output, spectra, power)
    white = np.zeros(p)
    corners = spectra.corners
    if len(corners) and np.isinf(corners[-1]):
        exponents, white = _growth(transfer, spectra, corners[-2] + 1.0)
        for row, power in enumerate(powers):
            for output in np.flatnonzero(exponents + power >= -1).tolist():
                if not reasons[row, output]:
                    intensity = (
                        f"; its intensity is {number_text(white[output])} ({units[output]})^2/Hz"
                        if np.isfinite(white[output])
                        else ""
                    )
                    reasons[row, output] = (
                        f"white noise reaches it directly{intensity}"
                        if exponents[output] == 0 and not power
                        else f"its spectrum{' times f^' + str(power) if power else ''} falls no faster than f^{exponents[output] + power:g}"
                    )
    return Existence(reasons, white)


def _at_pole(pole: RefinedPole, output: int, spectra: SpectralMatrix, power: int) -> str:
    """The reason for which a pole makes the integral infinite, or ""."""
    f0 = abs(pole.value.imag) / (2 * np.pi)
    if pole.value.real > 0 and not pole.on_axis:
        reached = pole.residues[:, output, [piece for piece in range(len(spectra.spectra)) if spectra.spectra[piece].pieces]]
        return f"the motion with the eigenvalue {pole.value:.4g} 1/s is unstable and grows" if reached.any() else ""
    if not pole.on_axis:
        return ""
    for a, b in itertools.pairwise(spectra.corners):
        if not a <= f0 <= b:
            continue
        middle = a + 1.0 if np.isinf(b) else (a + b) / 2
        for j in range(pole.order - 1, -1, -1):
            rise = _rise(spectra, middle, pole.residues[j][output], f0) + (0 if f0 else power)
            if rise - 2 * (j + 1) <= -1:
                kind = "a rigid-body motion" if not f0 else "an undamped motion"
                return f"{kind} of {number_text(f0)} Hz has no damping and its excitation does not vanish there"
    return ""


def _rise(spectra: SpectralMatrix, middle: float, R: np.ndarray, f0: float) -> float:
    """The exponent of |f - f0| of R S R^H at a pole on the axis, infinite where it vanishes; for f0 = 0 from next to it."""

    def reached(f: float) -> float:
        S = spectra(np.array([f + 0j]), middle)[..., 0]
        value, size = (R @ S @ R.conj()).real, np.abs(R) @ np.abs(S) @ np.abs(R)
        return value if value > CLUSTER_SAFETY * EPS * size else 0.0

    if f0:
        return 0.0 if reached(f0) else np.inf
    lengths = [1.0, *(1 / abs(one) for one in spectra.singularities(middle) if one), 2 * np.pi * spectra.longest_delay]
    lengths.append(1 / spectra.corners[spectra.corners > 0][0])
    f = NEXT_TO_ZERO / max(lengths)
    one, two = reached(f), reached(2 * f)
    return float(np.round(np.log2(two / one))) if one else np.inf


def _growth(transfer: SpectralTransfer, spectra: SpectralMatrix, middle: float) -> tuple[np.ndarray, np.ndarray]:
    """The exponent of f of the spectrum of each output towards infinity, and the intensity of its white part, both of shape (p,)."""
    harmonic = transfer.harmonic
    slopes, D = spectra.slopes(middle), transfer.polynomial
    p = len(harmonic.outputs)
    exponents, white = np.full(p, -np.inf), np.zeros(p)
    S = spectra(np.array([middle + 0j]), middle)[..., 0]
    decays = _decays(transfer)
    for output in range(p):
        for entry, slope in enumerate(slopes):
            if np.isfinite(slope):
                exponents[output] = max(exponents[output], slope - 2 * decays[output, entry])
        if exponents[output] == 0:
            flat = [entry for entry, slope in enumerate(slopes) if slope == 0]
            if len(D) and flat:
                row = D[0, output, flat]
                white[output] = (row @ S[np.ix_(flat, flat)] @ row.conj()).real
        elif exponents[output] > 0:
            white[output] = np.inf
    return exponents, white


def _decays(transfer: SpectralTransfer) -> np.ndarray:
    """The relative degrees: H ~ s^-decay towards infinity, shape (p, m), infinite where H is zero."""
    harmonic = transfer.harmonic
    degrees = relative_degrees(harmonic.coefficients, harmonic.inputs, harmonic.outputs)
    if degrees is not None:
        return degrees - harmonic.power
    decays, D = _numerical_decays(transfer), transfer.polynomial
    for k in range(len(D)):
        decays[D[k] != 0] = -k
    return decays


def _numerical_decays(transfer: SpectralTransfer) -> np.ndarray:
    """The relative degrees of large models, from C J^k B without rounding errors."""
    form = transfer.harmonic.form
    C, B = np.abs(form.outputs @ form.pairs.finite.C), np.abs(form.pairs.finite.B @ form.inputs)
    right, right_size = form.pairs.finite.B @ form.inputs, B
    result = np.full((len(C), B.shape[1]), np.inf)
    J = form.pairs.finite.J
    for index in range(len(J) + 1):
        values, noise = form.outputs @ form.pairs.finite.C @ right, NOISE_SAFETY * EPS * max(len(J), 1) * C @ right_size
        if index >= form.power:
            first = (np.abs(values) > noise) & np.isinf(result)
            result[first] = index + 1 - form.power
        right, right_size = J @ right, np.abs(J) @ right_size
        if np.isfinite(result).all():
            break
    return result
