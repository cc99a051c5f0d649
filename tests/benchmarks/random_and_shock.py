"""Random responses after their poles, and shock response spectra next to pyyeti's at equal error: processor times and ratios in one run.

    python tests/benchmarks/random_and_shock.py

Chains of 10 and 100 masses on a random base, a table of ten segments. The record of 1e5 samples is read as straight lines by both; pyyeti finds its
peaks among samples, and is given more of them on the straight lines: of each frequency the smallest of some numbers with an error of at most
1e-6 of the true peak counts; and its own default. It is run at some of the frequencies, its times multiplied.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [] if str(ROOT) in sys.path else [str(ROOT)]

import mbconstrained as mb  # noqa: E402

#: Wanted: states and processor time in s of a variance after the poles; of a spectrum of 1e5 samples at 100 frequencies.
WANTED, WANTED_SPECTRUM, EQUAL = {20: 5e-3, 200: 0.3}, 2.0, 1e-6

POINTS_OF_CYCLE = (12, 200, 800, 3200, 12800)


def timed(function, repeats=5, prepare=lambda: None):
    """The best processor time of some runs, and the last result; what is prepared for each is not counted."""
    best, result = np.inf, None
    for _ in range(repeats):
        given = prepare()
        begin = time.process_time()
        result = function(given)
        best = min(best, time.process_time() - begin)
    return best, result


def chain(count):
    """Unit masses on a moving base."""
    K = 1e4 * (2 * np.eye(count + 1) - np.eye(count + 1, k=1) - np.eye(count + 1, k=-1))
    K[0, 0] = K[-1, -1] = 1e4
    M = np.diag([0.0] + [1.0] * count)
    return mb.MechanicalSystem(M, 2e-4 * K, K, [mb.Constraint(np.eye(count + 1)[0], names="base")])


def by_quadrature(system, f, G):
    """The variance of the last acceleration by Gauss's rule on panels that are graded towards the resonances, of the undamped modes with their damping."""
    squares, U = np.linalg.eigh(system.stiffness[1:, 1:])
    w, gamma = np.sqrt(squares), U.sum(axis=0) * U[-1]
    own = w / (2 * np.pi)
    graded = [at + sign * at * 2.0 ** -np.arange(1, 24) for at in own for sign in (-1, 1)]
    edges = np.unique([*f, *own, *np.concatenate(graded)])
    edges = edges[(edges >= f[0]) & (edges <= f[-1])]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    half = np.diff(edges)[:, None] / 2
    total = 0.0
    for x, weight in zip(edges[:-1, None] + half * (1 + nodes), half * weights):
        s = 2 * np.pi * x[:, None]
        H = 1 + (gamma * s**2 / (w**2 - s**2 + 2e-4j * w**2 * s)).sum(axis=1)
        total += weight @ (np.abs(H) ** 2 * np.exp(np.interp(np.log(x), np.log(f), np.log(G))))
    return total


def variances():
    """One line for each size: the last mass alone, and all of them relative to the base."""
    f, exponents = np.geomspace(1, 1000, 11), [-2, -1, -1, -2, -1.5, -1, -2, -3, -2, -2, -3]
    G = 10.0 ** np.array(exponents)
    table = mb.psd(f, G, of="acceleration")
    for states, wanted in WANTED.items():
        system, count = chain(states // 2), states // 2

        def with_poles(outputs, relative_to=None, system=system):
            response = system.random_response({"base": table}, outputs, "acceleration", relative_to=relative_to)
            response.harmonic.form.poles
            _ = response.infinite  # refines them
            return response

        last, R = timed(lambda R: (R.rms, R)[1], prepare=lambda: with_poles(f"x{count + 1}"))
        every, _ = timed(lambda R: R.rms, prepare=lambda: with_poles(None, "base"))
        poles, _ = timed(lambda _: with_poles(f"x{count + 1}"), 2)
        error = abs(R.covariance.item() / by_quadrature(system, f, G) - 1)
        print(
            f"{states} states, 10 segments: {1e3 * last:.1f} ms of one output, {1e3 * every:.1f} ms of {count + 1}; wanted {1e3 * wanted:g} ms; poles before {1e3 * poles:.0f} ms"
        )
        print(f"  from graded quadrature {error:.1e}, estimate {R.error_estimate[0]:.1e}")


def spectra():
    """This package and pyyeti."""
    from pyyeti import srs

    rate, count = 1e4, 100_000
    t = np.arange(count) / rate
    values = 100 * np.random.default_rng(0).standard_normal(count) * np.exp(-t / 3)
    values[0] = 0.0  # pyyeti takes a jump at the start for a ramp
    f, record = np.geomspace(5, 2000, 100), mb.sampled(t, values[None])
    own, S = timed(lambda _: mb.shock_response_spectrum(record, f, 0.05), 3)
    print(f"shock response spectrum, 1e5 samples, 100 frequencies: {own:.2f} s; wanted {WANTED_SPECTRUM:g} s")

    def peer(frequency, points):
        factor = max(1, int(np.ceil(points * frequency / rate)))
        fine = np.interp(np.arange(factor * (count - 1) + 1) / (factor * rate), t, values)
        return srs.srs(fine, factor * rate, [frequency], 10, rolloff="none", parallel="no")[0]

    default, P = timed(lambda _: srs.srs(values, rate, f, 10, parallel="no"), 1)
    print(
        f"  pyyeti at its default: {default:.2f} s, error {np.abs(P / S.primary - 1).max():.1e} (it reads the record as band-limited)"
    )
    total, chosen, errors = 0.0, f[4::20], []
    for place, one in enumerate(chosen):
        for points in POINTS_OF_CYCLE:
            seconds, P = timed(lambda _: peer(one, points), 1)
            error = abs(P / S.primary[4 + 20 * place] - 1)
            if error <= EQUAL:
                break
        total += seconds
        errors.append(error)
        print(f"    {one:.0f} Hz: {points} samples of a cycle, {seconds:.2f} s, error {error:.1e}")
    total *= len(f) / len(chosen)
    print(f"  pyyeti with samples added for {EQUAL:g}: {total:.1f} s; ratio {own / total:.3f}, worst error {max(errors):.1e}")


if __name__ == "__main__":
    variances()
    spectra()
