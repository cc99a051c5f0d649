"""Poles and residues, transfer functions and their peaks, of S models of one structure in stacks of matrices, with error estimates.

A(s)^-1 = sum of x_k y_k^T / (s - s_k) + Y.

Symmetric models are decoupled without damping by a stacked Cholesky factorization and LAPACK's symmetric eigenproblem; their damped
shapes follow from the modal damping matrix by Jacobi's iteration, each pole from its own row. That takes less than half of the time of
the eigenproblem of all states (Hessenberg and QR), which serves the other models. One Newton step in the given matrices refines each
pole. What is left of the equations, with the rounding errors of its terms, bounds poles and shapes to first and second order.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from ..frequency.extrema import falling_root
from ..frequency.features import BEYOND, EACH_DECADE, FIRST, MOST, RATIO
from ..ground.tolerances import AUTO_DISTANCE, EPS, FORM_ROUNDING, LINE_ACCURACY, PROVED_ACCURACY
from .stacked_equations import StackedEquations

#: Number of models computed together, whose matrices fit into the cache.
TOGETHER = 256

#: Jacobi's iteration of damped shapes ends after so many steps: general eigenvectors take no longer.
JACOBI_STEPS = 24


@dataclass(frozen=True, eq=False)
class StackedPoles:
    """Poles and residues of S models, of complex pairs those above the real axis."""

    values: np.ndarray  # s_k, shape (S, P)
    weights: np.ndarray  # 2 of a complex pair, 1 of a real pole, 0 where a model has fewer, shape (S, P)
    shapes: np.ndarray  # x_k, shape (S, n, P)
    left: np.ndarray  # y_k^T, scaled to the residue x_k y_k^T, shape (S, P, n)
    direct: np.ndarray  # Y, shape (S, n, n)
    # value_errors, shape_errors: estimates relative to |s_k| and to the largest entry of x_k, shape (S, P)
    value_errors: np.ndarray
    shape_errors: np.ndarray
    serve: np.ndarray  # whether a model has the structure and separate poles, shape (S,)

    def of(self, members) -> StackedPoles:
        """The poles of some models, selected by a slice or an array of indices."""
        return StackedPoles(*(getattr(self, each.name)[members] for each in fields(self)))


def in_parts(count: int) -> Iterator[slice]:
    """The places of models that are computed together."""
    return (slice(begin, begin + TOGETHER) for begin in range(0, count, TOGETHER))


def stacked_poles(equations: StackedEquations, M: np.ndarray, C: np.ndarray, K: np.ndarray) -> StackedPoles:
    parts = [dict(vars(_refined(equations.of(at), M[at], C[at], K[at]))) for at in in_parts(len(K))]
    width = max(part["values"].shape[1] for part in parts)
    names = [field.name for field in fields(StackedPoles)]  # each leaves the parts as it is joined, so that memory holds it once
    return StackedPoles(*(np.concatenate([_padded(part.pop(name), name, width) for part in parts]) for name in names))


def _padded(array: np.ndarray, name: str, width: int) -> np.ndarray:
    """An array padded to this number of poles."""
    axis = {"shapes": 2, "direct": None, "serve": None}.get(name, 1)
    if axis is None or array.shape[axis] == width:
        return array
    return np.pad(array, [(0, width - array.shape[axis] if i == axis else 0) for i in range(array.ndim)])


def _symmetric(equations: StackedEquations) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None:
    """Poles and vectors of models in which every mode oscillates; None where a mode does not."""
    M, C, K = equations.M, equations.C, equations.K
    diagonal = M.diagonal(axis1=1, axis2=2)
    if not (diagonal > 0).all():
        return None
    if np.count_nonzero(M) == diagonal.size:
        root = 1 / np.sqrt(diagonal)
        K_unit, C_unit = (matrix * root[:, :, None] * root[:, None, :] for matrix in (K, C))
        back = root[:, :, None] * np.eye(M.shape[1])
    else:
        try:
            back = np.linalg.inv(np.linalg.cholesky(M)).transpose(0, 2, 1)
        except np.linalg.LinAlgError:
            return None
        K_unit, C_unit = (back.transpose(0, 2, 1) @ matrix @ back for matrix in (K, C))
    squares, Q = np.linalg.eigh((K_unit + K_unit.transpose(0, 2, 1)) / 2)
    if not (squares[:, 0] > 0).all():
        return None
    Phi, values, Z = back @ Q, 1j * np.sqrt(squares), None
    if C.any():
        damped = _damped(Q.transpose(0, 2, 1) @ C_unit @ Q, squares)
        if damped is None:
            return None
        values, Z = damped
    X = Phi.astype(complex) if Z is None else Phi @ Z
    return values, np.full(values.shape, 2.0), X, X.transpose(0, 2, 1)


def _damped(D: np.ndarray, squares: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Poles above the real axis and their modal shapes of s^2 + D s + diag(w^2); None where the iteration does not converge."""
    size = D.shape[1]
    damping, places = D.diagonal(axis1=1, axis2=2), np.arange(size)
    coupling = D * (1 - np.eye(size))
    discriminant = squares - damping**2 / 4
    if not (discriminant > 0).all():
        return None
    values = -damping / 2 + 1j * np.sqrt(discriminant)
    Z = np.zeros(D.shape, dtype=complex)
    Z[:, places, places] = 1.0
    if not coupling.any():
        return values, Z
    with np.errstate(all="ignore"):
        for _ in range(JACOBI_STEPS):
            before, load = Z, coupling @ Z
            half = (damping + load[:, places, places]) / 2  # of the own row, with what all others add
            root = 1j * np.sqrt(squares - half * half)
            values = root - half
            s = values[:, None, :]
            Z = -s * load / ((s + damping[:, :, None]) * s + squares[:, :, None])
            Z[:, places, places] = 1.0
            change = np.abs((Z - before).view(float)).max()
            if not change < 1:
                return None
            if change <= FORM_ROUNDING * EPS:
                return values, Z
    return None


def _general(equations: StackedEquations) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Poles and vectors of any models, by the eigenvectors of their generators."""
    G, m = equations.generator, equations.masses
    G[~np.isfinite(G).all(axis=(1, 2))] = 0.0
    values, vectors = np.linalg.eig(G)
    values, vectors = values.astype(complex), vectors.astype(complex)
    size, right = equations.K.shape[1], np.broadcast_to(np.eye(equations.K.shape[1]), equations.K.shape)
    rates = np.zeros((len(G), size + m, size), dtype=complex)
    rates[:, m:] = equations.accelerations(right)
    try:
        left = np.linalg.solve(vectors, rates)
    except np.linalg.LinAlgError:  # of a defective model; it does not serve, as its poles are not separate
        units = np.eye(size + m)
        regular = np.linalg.svd(vectors, compute_uv=False)[:, -1] > EPS
        left = np.linalg.solve(np.where(regular[:, None, None], vectors, units), rates)
    order = np.argsort(values.imag < 0, axis=1, kind="stable")[:, : int((values.imag >= 0).sum(axis=1).max(initial=0))]
    chosen = np.take_along_axis(values, order, axis=1)
    weights = np.where(chosen.imag > 0, 2.0, np.where(chosen.imag == 0, 1.0, 0.0))
    X = np.take_along_axis(vectors, order[:, None, :], axis=2)
    return chosen, weights, np.concatenate([X[:, :m], X[:, 2 * m :]], axis=1), np.take_along_axis(left, order[:, :, None], axis=1)


def _refined(equations: StackedEquations, M: np.ndarray, C: np.ndarray, K: np.ndarray) -> StackedPoles:
    """The poles after a Newton step with their error estimates, shapes and left vectors in the coordinates x."""
    s, weights, X, rows = (_symmetric(equations) if equations.is_symmetric else None) or _general(equations)
    with np.errstate(all="ignore"):
        slope = _forms(rows, X, 2 * s, equations.M) + _forms(rows, X, 1.0, equations.C)
        rows = rows / slope[:, :, None]
        right, left = equations.T @ X, rows @ equations.L
        s = s - _step(_residual(left, right, s, M, C, K), weights)
        value_errors, shape_errors = _errors(equations, s, weights, X, rows, (left, right, M, C, K))
        doubtful = (value_errors > PROVED_ACCURACY).any(axis=1) & equations.serve
        if doubtful.any():  # in more digits, where terms cancel
            at = np.flatnonzero(doubtful)
            exact = [np.asarray(one[at], np.clongdouble) for one in (left, right, s)]
            real = [np.asarray(one[at], np.longdouble) for one in (M, C, K)]
            s[at] -= _step(_residual(*exact, *real).astype(complex), weights[at])
            unit = FORM_ROUNDING * float(np.finfo(np.longdouble).eps) / EPS
            given = (left[at], right[at], M[at], C[at], K[at])
            value_errors[at], shape_errors[at] = _errors(equations.of(at), s[at], weights[at], X[at], rows[at], given, unit)
    serve = equations.serve & (np.isfinite(value_errors) & np.isfinite(shape_errors)).all(axis=1)
    return StackedPoles(s, weights, right, left, equations.Y, value_errors, shape_errors, serve)


def _step(residual: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Newton step of the poles; real for real poles."""
    return np.where(weights == 2, residual, np.where(weights == 1, residual.real, 0.0))


def _forms(rows, X, factor, matrix) -> np.ndarray:
    """factor * y_k^T A x_k, shape (S, P)."""
    return factor * (rows * (matrix @ X).transpose(0, 2, 1)).sum(axis=2)


def _residual(rows, X, s, M, C, K) -> np.ndarray:
    """y_k^T (M s_k^2 + C s_k + K) x_k, shape (S, P)."""
    return (_forms(rows, X, 1.0, M) * s + _forms(rows, X, 1.0, C)) * s + _forms(rows, X, 1.0, K)


def _errors(equations, s, weights, X, rows, given, unit: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Errors of poles and shapes: rounding errors of the forms, and residuals in the direction of all other modes.

    An error c_j x_j of x_k has c_j = y_j^T A(s_k) x_k / (s_k - s_j) to first order, and the same holds of y_k; the product of both
    changes s_k. A pole has the rounding errors of y_k^T A(s_k) x_k in the given matrices, in units of EPS.
    """
    moduli, size, rows_size = np.abs(s)[:, None, :], np.abs(X), np.abs(rows)
    own = equations.M, equations.C, equations.K
    of_right, of_left = (
        np.abs(_applied(s[:, None, :], *matrices)) + FORM_ROUNDING * EPS * _applied(moduli, *map(np.abs, matrices))
        for matrices in ((*own, X), [one.transpose(0, 2, 1) for one in (*own, rows)])
    )
    gaps = np.abs(s[:, :, None] - s[:, None, :])  # of j and k
    mirrored = np.abs(s[:, :, None].conj() - s[:, None, :])
    present, places = weights > 0, np.arange(s.shape[1])
    near = np.where(present[:, :, None], 1 / gaps, 0.0) + np.where((weights == 2)[:, :, None], 1 / mirrored, 0.0)
    near[:, places, places] = np.where(weights == 2, 1 / mirrored[:, places, places], 0.0)
    across = (rows_size @ of_right) * near  # c_j of x_k, at (j, k)
    back = (size.transpose(0, 2, 1) @ of_left) * near
    left, right, M, C, K = given
    terms = (np.abs(left) * _applied(moduli, *map(np.abs, (M, C, K, right))).transpose(0, 2, 1)).sum(axis=2)
    rounding = FORM_ROUNDING * EPS * unit * terms
    cross = (across * back / np.where(near > 0, near, 1.0)).sum(axis=1)
    value_errors = (rounding + cross) / np.maximum(moduli[:, 0], np.finfo(float).tiny) + EPS
    shape_errors = (size @ across).max(axis=1) / size.max(axis=1)
    absent = ~present
    value_errors[absent], shape_errors[absent] = 0.0, 0.0
    return value_errors, shape_errors


def _applied(s, M, C, K, X) -> np.ndarray:
    """(M s_k^2 + C s_k + K) x_k, shape (S, n, P), for s of shape (S, 1, P)."""
    return (M @ X * s + C @ X) * s + K @ X


# Transfer functions of S models of one structure, from their poles and residues: H(s) = s^p C (s I - J)^-1 B and polynomial parts.
#
# Forces f and prescribed motions b of constraint rows are inputs. x = G^T b + A(s)^-1 (f - (M s^2 + C s + K) G^T b), A(s)^-1 the sum of
# residues over s - s_k and the part of massless coordinates.


@dataclass(frozen=True, eq=False)
class StackedTransfer:
    """H(s) of S models, from m inputs to p outputs."""

    poles: StackedPoles  # poles of the models
    outputs: np.ndarray  # shape (p, n)
    motions: np.ndarray  # of the coordinates by prescribed motions alone, shape (n, m)
    loads: tuple[np.ndarray, ...]  # coefficients of 1, s, s^2 in what acts on the coordinates, each of shape (S, n, m)
    order: int  # p in s^p
    levels: np.ndarray  # l in s^-l of each input: that of its prescribed derivative, shape (m,)

    def __call__(self, s: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """H and estimates of its absolute errors, shape (S, p, m, F)."""
        poles = self.poles
        s = np.atleast_2d(s)[:, None, :]
        values, pairs = poles.values[:, :, None], (poles.weights == 2)[:, :, None]
        with np.errstate(all="ignore"):
            each = np.where(poles.weights[:, :, None] > 0, 1 / (s - values), 0.0)
            mirrored = np.where(pairs, 1 / (s - values.conj()), 0.0)
            sizes = np.abs(each) + np.abs(mirrored)
            doubt = (2 * poles.shape_errors + FORM_ROUNDING * EPS)[:, :, None] * sizes
            doubt += (poles.value_errors * np.abs(poles.values))[:, :, None] * sizes**2
            total: Any = (self.outputs @ self.motions)[:, :, None]
            error: Any = 0.0
            powers = s[:, :, None]
            for power, (residues, bound, direct) in enumerate(self.terms()):
                shape = (len(values), -1, residues.shape[3])
                part = residues.reshape(shape) @ each + residues.conj().reshape(shape) @ mirrored
                total = total + (part.reshape(*residues.shape[:3], -1) + direct[..., None]) * powers**power
                error = error + (bound.reshape(shape) @ doubt).reshape(*residues.shape[:3], -1) * np.abs(powers) ** power
            factor = powers ** (self.order - self.levels[:, None])
        return total * factor, error * np.abs(factor)

    def residues(self) -> np.ndarray:
        """The residues of H at the poles, shape (S, p, m, P)."""
        s = self.poles.values[:, None, None, :]
        total = sum(residues * s**power for power, (residues, _, _) in enumerate(self.terms()))
        return total * s ** (self.order - self.levels[:, None])

    def terms(self):
        """For each power of s: residues, a bound of their size by the largest entries of the shapes, and the part without poles."""
        poles = self.poles
        X = self.outputs @ poles.shapes
        largest = np.abs(self.outputs).sum(axis=1)[:, None] * np.abs(poles.shapes).max(axis=1, keepdims=True)
        for load in self.loads:
            rows = (poles.left @ load).transpose(0, 2, 1)[:, None]  # (S, 1, m, P)
            yield X[:, :, None, :] * rows, largest[:, :, None, :] * np.abs(rows), self.outputs @ poles.direct @ load


# The largest responses |H(i w)| in a range of frequencies.
#
# Each model has lines of its own, as dense about its poles as those of a single response (``frequency.features``); where d log|H| / dw
# changes its sign between two of them, the peak is refined to rounding error, all peaks at once.


@dataclass(frozen=True, eq=False)
class LargestResponses:
    """The largest |H| of each entry with its frequency in Hz, shape (S, p, m) each; NaN where there is none."""

    amplitudes: np.ndarray
    frequencies_hz: np.ndarray
    serve: np.ndarray  # models whose values are as accurate as those of a single response, shape (S,)


def largest_responses(transfer: StackedTransfer, limits: tuple[float, float], ends: Sequence[float]) -> LargestResponses:
    """The largest |H| at peaks between limits in Hz, 0 and infinite where the range is open, and at given ends of the range."""
    poles, given = transfer.poles, 2 * np.pi * np.array(ends, dtype=float)
    present = poles.weights > 0
    damped = np.where(present, poles.values.real < -LINE_ACCURACY * np.abs(poles.values), True).all(axis=1)
    serve = poles.serve & damped
    present = present & serve[:, None]
    sums, shape = _Sums.of(transfer, present), (len(serve), len(transfer.outputs), transfer.motions.shape[1])
    with np.errstate(all="ignore"):
        omega = _lines(np.where(present, poles.values, -1.0), 2 * np.pi * limits[0], 2 * np.pi * limits[1])
        slopes = sums.slopes(omega)
        model, entry, at = np.nonzero((slopes[..., :-1] > 0) & (slopes[..., 1:] <= 0))
        own = sums.of_entries(model, entry)
        brackets = (omega[model, at], omega[model, at + 1], slopes[model, entry, at], slopes[model, entry, at + 1])
        peaks = falling_root(lambda w: own.slopes(w[:, None])[:, 0, 0], *brackets)
        rank = np.arange(len(model)) - np.searchsorted(model, model)
        count = int(rank.max(initial=-1)) + 1
        places = np.hstack([np.repeat(omega[:, :1], count, axis=1), np.broadcast_to(given, (len(omega), len(given)))])
        places[model, rank] = peaks
        values, errors = (each.reshape(len(omega), -1, places.shape[1]) for each in transfer(1j * places))
        sizes, w = np.abs(values), places[:, None, :]
        errors = errors + EPS * np.where(w > 0, sizes * np.abs(w * sums.slopes(places)), 0.0)  # w has a rounding error
        chosen = np.zeros(sizes.shape, dtype=bool)
        chosen[model, entry, rank], chosen[..., count:] = True, True
        sizes = np.where(chosen, sizes, -np.inf)
        best = sizes.argmax(axis=2)[..., None] if places.shape[1] else np.zeros((*sizes.shape[:2], 0), dtype=int)
        largest, where = np.take_along_axis(sizes, best, axis=2), np.take_along_axis(np.broadcast_to(w, sizes.shape), best, axis=2)
        serve = serve & (~chosen | (errors <= LINE_ACCURACY * largest)).all(axis=(1, 2))
    some = chosen.any(axis=2)
    amplitudes, frequencies = (np.full(sizes.shape[:2], np.nan) for _ in range(2))
    amplitudes[some], frequencies[some] = largest[some, 0], where[some, 0] / (2 * np.pi)
    return LargestResponses(amplitudes.reshape(shape), frequencies.reshape(shape), serve)


def _lines(values: np.ndarray, low: float, high: float) -> np.ndarray:
    """Ascending angular frequencies of each model in a range, from a decade below all poles to a decade above where it is open, (S, L)."""
    moduli, w = np.abs(values), values.imag
    low = low or float(moduli.min(initial=1.0)) / BEYOND
    high = max(low, high if np.isfinite(high) else float(moduli.max(initial=1.0)) * BEYOND)
    common = np.geomspace(low, high, int(EACH_DECADE * np.log10(high / low)) + 2)
    scale = np.maximum(np.abs(values.real), AUTO_DISTANCE * w)
    reach = np.log((w / scale).max(initial=RATIO) / FIRST) / np.log(RATIO)
    offsets = np.multiply.outer(scale, FIRST * RATIO ** np.arange(min(MOST, int(reach) + 1)))
    near = np.concatenate([w[..., None] - offsets, w[..., None], w[..., None] + offsets], axis=2).reshape(len(values), -1)
    return np.sort(np.hstack([np.broadcast_to(common, (len(values), len(common))), np.clip(near, low, high)]), axis=1)


@dataclass(frozen=True, eq=False)
class _Sums:
    """E entries of H of N models: s^power times the sum over k of s^k times residues over s - s_k and a constant."""

    values: np.ndarray  # s_k and their conjugates, shape (N, P)
    parts: tuple[tuple[np.ndarray, np.ndarray], ...]  # residues and constant for each k, shapes (N, E, P) and (N, E)
    powers: np.ndarray  # shape (N, E)

    @classmethod
    def of(cls, transfer: StackedTransfer, present: np.ndarray) -> _Sums:
        poles, parts = transfer.poles, []
        counted = np.concatenate([present, present & (poles.weights == 2)], axis=1)[:, None]
        values = np.where(present, poles.values, -1.0)
        for k, (residues, _, constant) in enumerate(transfer.terms()):
            R = residues.reshape(len(present), -1, residues.shape[3])
            D = (constant + transfer.outputs @ transfer.motions if not k else constant).reshape(len(present), -1)
            parts.append((np.where(counted, np.concatenate([R, R.conj()], axis=2), 0.0), D))
        powers = np.broadcast_to(
            transfer.order - transfer.levels, (*present.shape[:1], len(transfer.outputs), len(transfer.levels))
        )
        return cls(np.concatenate([values, values.conj()], axis=1), tuple(parts), powers.reshape(len(present), -1))

    def of_entries(self, model: np.ndarray, entry: np.ndarray) -> _Sums:
        """Some entries, each as a model with one."""
        parts = tuple((R[model, entry][:, None], D[model, entry][:, None]) for R, D in self.parts)
        return _Sums(self.values[model], parts, self.powers[model, entry][:, None])

    def slopes(self, omega: np.ndarray) -> np.ndarray:
        """d log|H| / dw at angular frequencies of each model, shape (N, F) -> (N, E, F)."""
        s = 1j * omega[:, None, :]
        each = 1 / (s - self.values[:, :, None])
        total, rate, squares = 0.0, 0.0, each * each
        for k, (residues, constant) in enumerate(self.parts):
            part = residues @ each + constant[..., None]
            total = total + part * s**k
            rate = rate - residues @ squares * s**k + (k * part * s ** (k - 1) if k else 0.0)
        return np.real(1j * (rate / total + self.powers[..., None] / s))
