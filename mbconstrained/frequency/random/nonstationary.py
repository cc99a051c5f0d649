"""Covariance over time and sample paths: white noise through C e^{J t} B exactly, tabulated spectra by their harmonics.

    P(t) = e^{J t} P_0 e^{J^T t} + integral of e^{J (t - s)} B (G/2) B^T e^{J^T (t - s)} m(s) ds

Over a short step the integral is a sum over the nodes of Gauss's rule, P = L L^T with columns e^{J s} B sqrt(weight); steps are doubled,
P(2 h) = P(h) + e^{J h} P(h) e^{J^T h}, as triangular factors of [L, e^{J h} L]: variances are sums of squares, whatever the multiplicities, and a small
one next to a large one loses half as many digits as in P itself. What is doubtful in small models is computed exactly (``exact.enclosure``).
"""

from __future__ import annotations

import copy

import numpy as np

from ...ground.checks import evaluation_times, real_array
from ...ground.errors import InputError
from ...ground.tolerances import EPS, FORM_ROUNDING, PROVED_ACCURACY
from .spectra import INDEFINITE, PowerLaw, Rational, SpectralMatrix
from .spectral_integral import NODES, TURN, WEIGHTS, SpectralTransfer, _Integration

#: Harmonics that are added at once, times the number of times.
CHUNK = 1 << 22

#: Steps between samples that differ by so many rounding errors of the last time are equal.
EQUAL_STEPS = 8.0

#: Number of terms of the exponential series over a short step.
TERMS = 18

#: Models are moved by so many rounding errors, with so many patterns of signs.
MOVED, TRIALS = 8.0, 4

#: Covariances are computed exactly where the number of times and the cube of that of the states have at most this product: 2 s.
MOST_PROVED_WORK = 150_000

#: Time constants after which a process is stationary: e^-40 is below rounding errors.
DECAY = 40.0


class MarkovModel:
    """y = C z, z' = J z + B w with white noise w of intensity 1: the finite poles of H and of the filters of its inputs."""

    def __init__(self, transfer: SpectralTransfer, spectra: SpectralMatrix):
        """Create the model for independent or partly coherent inputs that are white or filtered noise."""
        if spectra.longest_delay or spectra.cross:
            raise InputError("white or filtered noise without delays and cross spectra is expected here")
        form, m = transfer.harmonic.form, len(spectra.names)
        J, B, C = form.pairs.finite.J, form.pairs.finite.B @ form.inputs, form.outputs @ form.pairs.finite.C
        C = C @ np.linalg.matrix_power(J, form.power)
        filters = [_filter(spectrum, name) for name, spectrum in zip(spectra.names, spectra.spectra)]
        if (
            any(D for *_, D in filters)
            and len(form.polynomial)
            and any((form.polynomial[..., i]).any() for i, f in enumerate(filters) if f[3])
        ):
            raise InputError("an output is reached by white noise directly; its variance is infinite at all times")
        if len(form.polynomial) and any(len(F[0]) for F in filters):
            raise InputError("an output with a direct path of filtered noise is not covered; use displacements or velocities")
        sizes = [len(F[0]) for F in filters]
        N, extra = len(J), sum(sizes)
        self.J, self.B, self.C = np.zeros((N + extra,) * 2), np.zeros((N + extra, m)), np.hstack([C, np.zeros((len(C), extra))])
        self.J[:N, :N], at = J, N
        for i, (a, b, c, d) in enumerate(filters):
            own = slice(at, at + len(a))
            self.J[own, own], self.B[own, i] = a, b
            self.J[:N, own], self.B[:N, i] = np.outer(B[:, i], c), B[:, i] * d
            at += len(a)
        self.roots = self.B @ _root(spectra.coherence) / np.sqrt(2)
        self.states = N
        self.transfer = transfer

    def initial(self, covariance) -> np.ndarray:
        """P_0 of the covariance of displacements and velocities, z_0 = sum over k of (sum over j > k of J^(j-1-k) B A_j) x^(k)."""
        P = np.zeros_like(self.J)
        if covariance is None:
            return P
        pairs, coefficients = self.transfer.harmonic.form.pairs.finite, self.transfer.harmonic.A.coefficients
        given = np.asarray(covariance)
        n = len(given) // 2 if given.ndim == 2 else 0
        given = real_array(covariance, "initial_covariance", shape=(2 * n, 2 * n))
        if 2 * n > 2 * coefficients.shape[1] or np.linalg.eigvalsh((given + given.T) / 2).min(initial=0.0) < -INDEFINITE * np.abs(
            given
        ).max(initial=1.0):
            raise InputError("initial_covariance: expected a positive semidefinite matrix of the displacements and velocities")
        rows = []
        for k in range(2):
            terms = [
                np.linalg.matrix_power(pairs.J, j - 1 - k) @ pairs.B @ coefficients[j][:, :n]
                for j in range(k + 1, len(coefficients))
            ]
            rows.append(sum(terms, np.zeros((len(pairs.J), n))))
        T = np.hstack(rows)
        P[: self.states, : self.states] = T @ given @ T.T
        return P

    def moved(self, trial: int) -> MarkovModel:
        """The model perturbed by rounding errors: those of a decomposition relative to norms, and for J those of repeated squaring."""
        generator, other = np.random.default_rng(trial), copy.copy(self)
        for name in ("J", "roots", "C"):
            matrix = getattr(self, name)
            size = np.linalg.norm(matrix, 1) if name == "J" else np.abs(matrix).max(initial=0.0)
            setattr(other, name, matrix + MOVED * EPS * size * generator.choice([-1.0, 1.0], matrix.shape))
        return other

    def step(self, time: float, rate: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
        """e^{J t}, and L with L L^T = integral of e^{J (t - s)} Q e^{J^T (t - s)} e^{-rate s} ds from 0 to t, Q = B (G/2) B^T."""
        size = (np.linalg.norm(self.J, 1) + abs(rate)) * time
        doublings = max(0, int(np.ceil(np.log2(size))) + 1) if size > 0.5 else 0
        h = time / 2**doublings
        since = h * (1 + NODES) / 2
        columns, E = np.multiply.outer(np.ones(len(NODES)), self.roots), np.eye(len(self.J))
        term, power = self.roots, E
        for k in range(1, TERMS):  # |J| h is at most 1/2
            term, power = self.J @ term / k, self.J @ power * (h / k)
            columns, E = columns + np.multiply.outer(since**k, term), E + power
        columns = np.sqrt(h / 2 * WEIGHTS * np.exp(-rate * (h - since)))[:, None, None] * columns
        L = _triangular(np.hstack(list(columns)))
        for _ in range(doublings):
            L = _triangular(np.hstack([np.exp(-rate * h / 2) * L, E @ L]))
            E, h = E @ E, 2 * h
        return E, L


def _triangular(factor: np.ndarray) -> np.ndarray:
    """L with L L^T = F F^T, no wider than high."""
    return np.asarray(np.linalg.qr(factor.T, mode="r")).T


def _filter(spectrum, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray, float]:
    """A, b, c, d of the filter that shapes the spectrum from white noise of intensity 1."""
    none = np.zeros((0, 0)), np.zeros(0), np.zeros(0)
    if not spectrum.pieces:
        return *none, 0.0
    (piece, *others) = spectrum.pieces
    if others or not np.isinf(piece.upper) or not isinstance(piece, (Rational, PowerLaw)):
        raise InputError(
            f"excitation of {name}: it has corner frequencies; white or filtered noise (mb.white_noise, mb.rational_spectrum) is expected here"
        )
    if isinstance(piece, PowerLaw):
        return *none, float(np.sqrt(piece.level.real))
    root, below = np.sqrt(piece.intensity), np.array(piece.denominator)
    above = np.pad(np.array(piece.numerator), (len(below) - len(piece.numerator), 0)) / below[0]
    below = below / below[0]
    n = len(below) - 1
    A = np.eye(n, k=1)
    A[-1:] = -below[:0:-1]
    d = above[0]
    c = above[:0:-1] - d * below[:0:-1]
    b = np.zeros(n)
    b[-1:] = 1.0
    return A, b * root, c, d * root


def covariance_over_time(
    transfer: SpectralTransfer, spectra: SpectralMatrix, times, initial_covariance=None, modulation=None
) -> tuple[np.ndarray, np.ndarray]:
    """E[y y^T] after the noise is switched on; the arguments are those of ``RandomResponse.covariance_over_time``."""
    times = np.atleast_1d(evaluation_times(times))
    model = MarkovModel(transfer, spectra)
    terms = real_array([(1.0, 0.0)] if modulation is None else modulation, "modulation", shape=(None, 2))
    start = model.initial(initial_covariance)
    values = _covariances(model, times, start, terms)
    trials = [_covariances(model.moved(trial), times, start, terms) for trial in range(TRIALS)]
    errors = FORM_ROUNDING * (sum(np.abs(values - trial) for trial in trials) + EPS * np.abs(values))
    scales = _scales(values)
    doubtful = np.flatnonzero((errors > PROVED_ACCURACY * scales).any(axis=(1, 2)))
    if 0 < len(doubtful) * max(len(model.J), 1) ** 3 <= MOST_PROVED_WORK and transfer.harmonic.imaginary is None:
        from .variance_enclosure import covariances_over_time

        exact = covariances_over_time(transfer.harmonic, spectra, times[doubtful], initial_covariance, terms)
        if exact is not None:
            values[doubtful], errors[doubtful] = exact
            scales = _scales(values)
    variances, doubts = values.diagonal(axis1=1, axis2=2), errors.diagonal(axis1=1, axis2=2)
    lost = (doubts > 0) & (doubts >= np.abs(variances))
    with np.errstate(all="ignore"):
        relative = np.where(errors > 0, errors / scales, 0.0)
    return values, np.where(lost[:, :, None] | lost[:, None, :], np.inf, relative)


def _scales(values: np.ndarray) -> np.ndarray:
    sizes = np.sqrt(np.abs(values.diagonal(axis1=1, axis2=2)))
    return sizes[:, :, None] * sizes[:, None, :]


def _covariances(model: MarkovModel, times: np.ndarray, start: np.ndarray, terms: np.ndarray) -> np.ndarray:
    result = np.zeros((len(times), len(model.C), len(model.C)))
    for place, time in enumerate(times):
        for number, (factor, rate) in enumerate(terms):
            E, L = model.step(time, rate)
            root = model.C @ L
            result[place] += factor * (root @ root.T)
            if number == 0 and start.any():
                result[place] += model.C @ E @ start @ E.T @ model.C.T
    return result


def sample(transfer: SpectralTransfer, spectra: SpectralMatrix, times, seed=None) -> np.ndarray:
    """A stationary Gaussian path, y(t) = Re sum over nodes of sqrt(weight) H L xi e^{2 pi i f t}, G = L L^H, xi complex normal.

    Panels are so short that Gauss's rule integrates G(f) e^{2 pi i f t} to rounding error up to the longest difference of two times.
    """
    times = np.atleast_1d(real_array(times, "times"))
    try:
        generator = np.random.default_rng(seed)
    except (TypeError, ValueError):
        raise InputError(f"seed: found {seed!r}; expected a whole number of at least 0, or None") from None
    if len(spectra.corners) and np.isinf(spectra.corners[-1]):
        return _markov_path(transfer, spectra, times, generator)
    work = _Integration(transfer, spectra, 0, None)
    work.others = np.array([pole.frequency for pole in work.poles], dtype=complex)
    panels = work._resolved(work._octaves())
    span = float(np.ptp(times)) if len(times) else 0.0
    for _ in range(60):
        wide = 2 * np.pi * (panels.upper - panels.lower) * span > 4 * TURN
        if not wide.any():
            break
        panels = panels.only(~wide).joined(panels.halves(wide))
    f, H = panels.nodes.ravel(), work._values(panels)[0]
    p, m = H.shape[:2]
    H, S = H.reshape(p, m, -1), work._spectra_at(panels).reshape(m, m, -1)
    root = np.moveaxis(_root(np.moveaxis(S, 2, 0)), 0, 2)
    noise = generator.standard_normal((m, len(f))) + 1j * generator.standard_normal((m, len(f)))
    amplitudes = np.einsum("aif,ijf,jf->af", H, root, noise) * np.sqrt(panels.weights.ravel())
    result, count = np.zeros((p, len(times))), max(1, CHUNK // max(len(times), 1))
    for start in range(0, len(f), count):
        own = slice(start, start + count)
        result += (amplitudes[:, own] @ np.exp(2j * np.pi * np.multiply.outer(f[own], times - times[:1]))).real
    return result


def _markov_path(transfer, spectra, times, generator) -> np.ndarray:
    """Steps z -> e^{J h} z + w with the covariance of w over the step, from the stationary distribution."""
    model = MarkovModel(transfer, spectra)
    order = np.argsort(times, kind="stable")
    poles = np.append([pole.value for pole in transfer.poles], np.linalg.eigvals(model.J[model.states :, model.states :]))
    slowest = -poles.real.max(initial=-np.inf)
    if slowest <= 0:
        raise InputError(
            "sample: a motion without damping, which the noise does not reach, has no stationary path; leave out its outputs"
        )
    L = model.step(DECAY / slowest if np.isfinite(slowest) else DECAY)[1]
    z = _normal(L @ L.T, generator)
    result, now, known = np.empty((len(model.C), len(times))), None, {}
    last_place = EQUAL_STEPS * EPS * np.abs(times).max(initial=0.0)
    for place in order:
        h = 0.0 if now is None else times[place] - now
        if h > 0:
            key = round(h / last_place)  # steps that differ by rounding errors of the times are one
            if key not in known:
                E, L = model.step(h)
                known[key] = E, L @ L.T
            E, Q = known[key]
            z = E @ z + _normal(Q, generator)
        now = times[place]
        result[:, place] = model.C @ z
    return result


def _normal(covariance: np.ndarray, generator) -> np.ndarray:
    """A normal vector of this covariance."""
    scale = np.sqrt(np.maximum(covariance.diagonal(), 0.0))
    safe = np.where(scale > 0, scale, 1.0)
    return scale * (_root(covariance / safe[:, None] / safe) @ generator.standard_normal(len(scale)))


def _root(matrices: np.ndarray) -> np.ndarray:
    """Hermitian square roots of semidefinite matrices, which depend continuously on rounding errors, as a sample path then does."""
    values, vectors = np.linalg.eigh(matrices)
    return (vectors * np.sqrt(np.maximum(values, 0.0))[..., None, :]) @ np.conj(np.swapaxes(vectors, -1, -2))
