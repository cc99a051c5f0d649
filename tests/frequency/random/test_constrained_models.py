"""Random constrained models with massless nodes and redundant rows against certified quadrature and exact arithmetic."""

import numpy as np
import pytest
from flint import acb, acb_poly, arb, ctx, fmpq, fmpq_mat, fmpq_poly

import mbconstrained as mb

#: Beyond this frequency in Hz, above all poles, integrals are over its inverse.
FAR = 64

QUANTITIES = ("displacement", "velocity", "acceleration")


def some(count, several=40):
    """Seeds, those beyond the first in the long run alone."""
    return [*range(count), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(count, several))]


def transfer_function(system, B, C):
    """Numerator and denominator of C A(s)^-1 B by exact determinants at whole numbers s, interpolated."""
    rows, n = system.constraint_matrix, system.size
    size = n + len(rows)
    degree, values = 2 * size, {"above": [], "below": []}
    for s in range(degree + 1):
        P = np.zeros((size, size), dtype=object) + fmpq(0)
        for power, matrix in enumerate((system.stiffness, system.damping, system.mass)):
            P[:n, :n] += np.vectorize(exact, otypes=[object])(matrix) * fmpq(s) ** power
        P[:n, n:], P[n:, :n] = np.vectorize(exact, otypes=[object])(rows.T), np.vectorize(exact, otypes=[object])(rows)
        bordered = np.zeros((size + 1, size + 1), dtype=object) + fmpq(0)
        bordered[:size, :size] = P
        bordered[:n, size], bordered[size, :n] = np.vectorize(exact, otypes=[object])(-B), np.vectorize(exact, otypes=[object])(C)
        values["below"].append(fmpq_mat(P.tolist()).det())
        values["above"].append(fmpq_mat(bordered.tolist()).det())
    V = fmpq_mat([[fmpq(s) ** k for k in range(degree + 1)] for s in range(degree + 1)])
    return [fmpq_poly(V.solve(fmpq_mat([[value] for value in values[key]])).entries()) for key in ("above", "below")]


def exact(value):
    return fmpq(*float(value).as_integer_ratio())


def certified(system, B, C, power, low, high, density):
    """The integral of |C A(s)^-1 B|^2 |s|^(2 power) density(f) df by python-flint's certified quadrature, at 40 digits."""
    above, below = transfer_function(system, B, C)
    with ctx.workdps(40):
        above, below = acb_poly(above), acb_poly(below)

        def integrand(f, _):
            s = acb(0, 2) * acb.pi() * f
            return above(s) * above(-s) / (below(s) * below(-s)) * (-s * s) ** power * density(f)

        return float(acb.integral(integrand, acb(low), acb(high), rel_tol=arb(10) ** -20, eval_limit=10**6).real)


def constrained_model(rng, n=5):
    """A chain with a massless node, redundant rows and random data; the first coordinate is fixed by two equal rows."""
    K = np.zeros((n, n))
    for i in range(n - 1):
        a = np.eye(n)[i] - np.eye(n)[i + 1]
        K += rng.uniform(50, 200) * np.outer(a, a)
    mass = rng.uniform(0.5, 2, n)
    mass[2] = 0.0
    rigid = np.eye(n)[3] - 2 * np.eye(n)[4]
    return mb.MechanicalSystem(
        np.diag(mass), 10 ** rng.uniform(-6, -2) * K, K, [mb.Constraint([np.eye(n)[0], 2 * np.eye(n)[0]]), mb.Constraint(rigid)]
    )


@pytest.mark.parametrize("seed", some(4, 16))
def test_constrained_models_against_certified_quadrature(seed):
    """Massless nodes, redundant rows: three slopes of a spectrum, displacement and acceleration."""
    rng = np.random.default_rng(seed)
    system = constrained_model(rng)
    slope = rng.uniform(-4, 4)
    corners = np.sort(rng.uniform(0.2, 8.0, 2))
    spectrum = mb.psd(corners, [1.0, (corners[1] / corners[0]) ** slope])
    output = int(rng.integers(1, 5))

    def density(f):
        return (f / acb(float(corners[0]))) ** acb(float(spectrum.pieces[0].exponent))

    for quantity, power in (("displacement", 0), ("acceleration", 2)):
        R = system.random_response({"x4": spectrum}, f"x{output + 1}", quantity)
        with ctx.workdps(40):
            integral = certified(system, np.eye(5)[3], np.eye(5)[output], power, float(corners[0]), float(corners[1]), density)
        assert np.isclose(R.covariance.item(), integral, rtol=1e-11)
        assert abs(R.covariance.item() / integral - 1) < 10 * R.error_estimate[0]


def random_model(rng):
    """Three to six nodes in a chain or ring, of which some are massless; none, some or all springs with dampers; free, held or tied by doubled rows.

    Data are sums of powers of two and small whole numbers, so that rigid bodies and undamped motions are those of the exact model.
    """
    n = int(rng.integers(3, 7))
    K, C, mass = np.zeros((n, n)), np.zeros((n, n)), rng.integers(1, 3, n).astype(float)
    mass[rng.random(n) < 0.25] = 0.0
    share = rng.choice([0.0, 0.5, 1.0])
    for i, j in [(i, i + 1) for i in range(n - 1)] + [(0, n - 1)] * (rng.random() < 0.3):
        a = np.eye(n)[i] - np.eye(n)[j]
        K += rng.choice([100.0, 200.0, 300.0]) * np.outer(a, a)
        C += 2.0 ** rng.integers(-12, 2) * (rng.random() < share) * np.outer(a, a)
    if rng.random() < 0.6:
        K[-1, -1] += 150.0
        C[-1, -1] += 0.25 * (rng.random() < share)
    held, tie = np.eye(n)[0], np.eye(n)[1] - 2 * np.eye(n)[2]
    rows = [held, 2 * held] * (rng.random() < 0.6) + [tie, 3 * tie] * (rng.random() < 0.5)
    return mb.MechanicalSystem(np.diag(mass), C, K, [mb.Constraint(row) for row in rows])


def frequencies_on_axis(below):
    """In Hz, of the roots of a polynomial on the imaginary axis: those that its even and its odd part have in common, and 0."""
    common = fmpq_poly(below.coeffs()[::2]).gcd(fmpq_poly(below.coeffs()[1::2]))
    squares = [complex(root) for root, _ in common.complex_roots()] if common.degree() > 0 else []
    return [0.0] * (below[0] == 0) + [abs(one.real) ** 0.5 / (2 * np.pi) for one in squares if abs(one.imag) < 1e-12 >= one.real]


def certified_power(above, below, low, high):
    """The integral of |above / below|^2 over f by python-flint; beyond FAR of u^-2 |...|^2 over u = 1/f, with u^-2 divided out."""
    turn, degree = acb(0, 2) * acb.pi(), below.degree()
    N, D = acb_poly(above), acb_poly(below)

    def inner(f, _):
        s = turn * f
        return N(s) * N(-s) / (D(s) * D(-s))

    def reversed_at(p, sign):
        return acb_poly([acb(p[degree - k]) * (sign * turn) ** (degree - k) for k in range(degree + 1)])

    options = {"rel_tol": arb(10) ** -20, "eval_limit": 10**6}
    total = acb.integral(inner, acb(low), acb(min(high, FAR)), **options)
    if np.isinf(high):
        top, bottom = (reversed_at(p, 1) * reversed_at(p, -1) for p in (above, below))
        top = acb_poly([top[k + 2] for k in range(top.degree() - 1)])
        total += acb.integral(lambda u, _: top(u) / bottom(u), acb(0), 1 / acb(FAR), **options)
    return float(total.real)


@pytest.mark.parametrize("seed", some(12))
def test_variances_of_random_models(seed):
    """RMS to 1e-11 and within ten estimates of certified quadrature of |H|^2; what exact arithmetic finds infinite is infinite, and nothing else is."""
    rng = np.random.default_rng(seed)
    system = random_model(rng)
    n = system.size
    (i, j), other, power = rng.integers(0, n, 2).tolist(), int(rng.integers(0, n)), int(rng.integers(0, 3))
    is_relative = rng.random() < 0.3 and other != j
    low, high = [(0.0, np.inf), (0.25, 4.0), (0.0, 2.0)][rng.integers(0, 3)]
    spectrum = mb.white_noise(1.0) if np.isinf(high) else mb.psd([low, high], [1.0], interpolation="steps")
    relative_to = f"x{other + 1}" if is_relative else None
    R = system.random_response({f"x{i + 1}": spectrum}, f"x{j + 1}", QUANTITIES[power], relative_to=relative_to)
    with ctx.workdps(50):
        above, below = transfer_function(system, np.eye(n)[i], np.eye(n)[j] - is_relative * np.eye(n)[other])
        above = above * fmpq_poly([0] * power + [1])
        common = above.gcd(below)
        above, below = above // common, below // common
        is_infinite = above != 0 and (
            any(low <= f <= high for f in frequencies_on_axis(below)) or (np.isinf(high) and above.degree() >= below.degree())
        )
        assert bool(R.infinite) == np.isinf(R.rms[0]) == is_infinite
        if above == 0:
            assert R.rms[0] == 0.0
        elif not is_infinite:
            error = abs(R.rms[0] / certified_power(above, below, low, high) ** 0.5 - 1)
            assert error < min(1e-11, 10 * R.error_estimate[0] + 1e-15)
