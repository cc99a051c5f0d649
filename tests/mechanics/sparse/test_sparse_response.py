"""Frequency responses of sparse systems by few modes: errors against a factorization of the whole matrix are below the bounds."""

import mpmath
import numpy as np
import pytest
import scipy.sparse
from scipy.sparse.linalg import splu

import mbconstrained as mb

SIDE = 24
NAMES = [f"x{i + 1}" for i in (199, 288)]


def membrane(damping="proportional", free=False):
    """Unit masses on a square net of unit springs, its edge fixed or free."""
    line = scipy.sparse.diags_array([-np.ones(SIDE - 1), 2 * np.ones(SIDE), -np.ones(SIDE - 1)], offsets=[-1, 0, 1]).tolil()
    if free:
        line[0, 0] = line[-1, -1] = 1.0
    eye = scipy.sparse.eye_array(SIDE)
    K = scipy.sparse.csc_array(scipy.sparse.kron(line, eye) + scipy.sparse.kron(eye, line))
    M = scipy.sparse.csc_array(scipy.sparse.eye_array(SIDE**2))
    dampers = scipy.sparse.diags_array(np.where(np.arange(SIDE**2) % 97 == 5, 0.02, 0.0))
    C = scipy.sparse.csc_array(1e-3 * K + 1e-4 * M if damping == "proportional" else dampers)
    return mb.MechanicalSystem(M, C, K)


def exact(system, frequency, eta=0.0):
    """Receptances by one factorization."""
    w = 2 * np.pi * frequency
    A = scipy.sparse.csc_array(system.stiffness * (1 + 1j * eta) + 1j * w * system.damping - w**2 * system.mass)
    places = [system.names.index(name) for name in NAMES]
    return splu(A).solve(np.eye(system.size)[:, places].astype(complex))[places]


@pytest.mark.parametrize(
    ("damping", "free", "eta"),
    [("proportional", False, 0.0), ("proportional", True, 0.0), ("dampers", False, 0.0), ("proportional", False, 0.02)],
)
def test_errors_are_below_their_bounds(damping, free, eta):
    system = membrane(damping, free)
    top = system.modes(count=20).frequencies_hz[-1]
    frequencies = np.linspace(0.15, 0.85, 9) * top
    H = system.frequency_response(frequencies, NAMES, NAMES, count=20, loss_factor=eta or None)
    for line, f in enumerate(frequencies):
        error = np.abs(H.values[..., line] - exact(system, f, eta)) / np.abs(H.values[..., line])
        assert (error <= 1.01 * H.error_estimate[..., line] + 1e-11).all()  # 1e-11: of the factorization
        assert (H.error_estimate[..., line] <= 50 * error + 1e-7).all()  # and not far from them
    accelerance = system.frequency_response(frequencies, NAMES, NAMES, "accelerance", count=20, loss_factor=eta or None)
    np.testing.assert_allclose(accelerance.values, -((2 * np.pi * frequencies) ** 2) * H.values, rtol=1e-12)
    np.testing.assert_allclose(accelerance.error_estimate, H.error_estimate, rtol=1e-3, atol=1e-11)


def test_more_modes_are_more_accurate_and_peaks_are_those_of_the_modes():
    system = membrane()
    modes = system.modes(count=30)
    few, many = (system.frequency_response([0.05], NAMES, NAMES, count=count) for count in (8, 30))
    assert many.error_estimate.max() < few.error_estimate.max()
    peaks = [peak for peak in many.peaks if peak.output == peak.input == NAMES[0]]
    assert abs(peaks[0].frequency_hz / modes.frequencies_hz[0] - 1) < 1e-3
    lines = system.frequency_response("auto", NAMES[:1], NAMES[:1], count=8).frequencies_hz
    assert lines.max() < system.modes(count=9).frequencies_hz[-1]


def test_ratios_of_modes_are_those_of_the_system_with_modal_damping():
    system = membrane("dampers")
    H = system.frequency_response([0.03, 0.05], NAMES, NAMES, count=20, modal_damping=0.01)
    K, C, M = (matrix.toarray() for matrix in (system.stiffness, system.damping, system.mass))
    modes = system.modes(count=20, damped=False)
    C = C + (modes.shapes * 0.02 * modes.natural_frequencies) @ modes.shapes.T
    whole = mb.MechanicalSystem(M, C, K).frequency_response([0.03, 0.05], NAMES, NAMES)
    assert (np.abs(H.values - whole.values) <= 2 * H.error_estimate * np.abs(H.values) + 1e-9 * np.abs(H.values)).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (dict(inputs=NAMES), "outputs: a response of sparse matrices needs names"),
        (dict(inputs=["x0"], outputs=NAMES), 'inputs: there is no "x0"'),
        (dict(inputs=NAMES, outputs=NAMES, quantity="impedance"), "impedance: not available for sparse matrices"),
        (dict(inputs=NAMES, outputs=NAMES, frequencies_hz=[1.0]), "modes reach .* Hz: increase count"),
        (dict(inputs=NAMES, outputs=NAMES, loss_factor={"k": 0.1}), "loss_factor by springs"),
        (dict(inputs=NAMES, outputs=NAMES, modal_damping=[0.1, 0.2]), "one for each of the 8 modes"),
    ],
)
def test_what_few_modes_do_not_have_is_refused(arguments, message):
    with pytest.raises(mb.InputError, match=message):
        membrane().frequency_response(**{"frequencies_hz": [0.01], "count": 8} | arguments)
    with pytest.raises(mb.InputError, match="leave count out"):
        mb.MechanicalSystem([[1.0]], None, [[1.0]]).frequency_response([0.1], count=3)


def exact_chain(K, M, C, frequency, into, out):
    """The receptance of a chain by elimination with 40 digits, w = 2 pi f exactly."""
    with mpmath.workdps(40):
        w = 2 * mpmath.pi * mpmath.mpf(frequency)
        n, (K, M, C) = K.shape[0], (matrix.tocsr() for matrix in (K, M, C))

        def band(offset):
            k, m, c = (matrix.diagonal(offset).tolist() for matrix in (K, M, C))
            return [mpmath.mpc(a - w**2 * b, w * d) for a, b, d in zip(k, m, c)]

        diagonal, beside, right = band(0), band(1), [mpmath.mpc(i == into) for i in range(n)]
        for i in range(1, n):
            factor = beside[i - 1] / diagonal[i - 1]
            diagonal[i] -= factor * beside[i - 1]
            right[i] -= factor * right[i - 1]
        x = right[-1] / diagonal[-1]
        for i in range(n - 2, out - 1, -1):
            x = (right[i] - beside[i] * x) / diagonal[i]
        return complex(x)


@pytest.mark.parametrize("damping", [0.0, 1e-4, 0.05])
@pytest.mark.parametrize(("n", "spread"), [(100, 1), (120, 3), (90, 6), (450, 1), (420, 3)])
def test_bounds_of_stiff_chains_contain_their_errors(n, spread, damping):
    """Springs over up to twelve orders of magnitude, by one dense decomposition and by Lanczos, line by line and entry by entry."""
    rng = np.random.default_rng(n + spread)
    k = 10.0 ** rng.uniform(-spread, spread, n + 1)
    K = scipy.sparse.csc_array(scipy.sparse.diags_array([-k[1:n], k[:n] + k[1:], -k[1:n]], offsets=[-1, 0, 1]))
    M = scipy.sparse.csc_array(scipy.sparse.diags_array(10.0 ** rng.uniform(-0.5, 0.5, n)))
    C = damping * K
    system = mb.MechanicalSystem(M, C, K)
    into, outs = int(rng.integers(n)), sorted(rng.integers(0, n, 2).tolist())
    top = system.modes(count=8, damped=False).frequencies_hz[-1]
    frequencies = np.array([0.0, *rng.uniform(0, 0.95 * top, 4)])
    H = system.frequency_response(frequencies, [f"x{into + 1}"], [f"x{out + 1}" for out in outs], count=8)
    for place, out in enumerate(outs):
        for line, f in enumerate(frequencies):
            exact = exact_chain(K, M, C, f, into, out)
            assert abs(H.values[place, 0, line] - exact) <= H.error_estimate[place, 0, line] * abs(H.values[place, 0, line])


def test_relative_motions_and_elongations_of_sparse_matrices():
    """The same names as of arrays, and the same values as of arrays with all modes."""
    models = []
    for sparse in (True, False):
        model = mb.LumpedModel()
        for i in range(12):
            model.mass(f"m{i}", 1.0 + 0.1 * i)
        model.spring("ground", "m0", 900.0)
        for i in range(11):
            model.spring(f"m{i}", f"m{i + 1}", 1000.0 + 50 * i, name=f"k{i}")
            model.damper(f"m{i}", f"m{i + 1}", 2.0)
        models.append(model.assemble(sparse=sparse))
    names, lines = ["m3", "m5 - m2", "elongation of k4"], np.linspace(0.1, 3.0, 9)
    reduced, whole = (one.frequency_response(lines, ["m1"], names, count=count) for one, count in zip(models, (12, None)))
    np.testing.assert_allclose(reduced.values, whole.values, rtol=1e-9)
    assert (
        reduced.harmonic.output_quantities
        == whole.harmonic.output_quantities
        == ("receptance", "relative displacement", "elongation")
    )
    rates = [
        one.frequency_response(lines, ["m1"], ["velocity of m5 - m2", "rate of k4"], count=count)
        for one, count in zip(models, (12, None))
    ]
    np.testing.assert_allclose(rates[0].values, rates[1].values, rtol=1e-9)
    with pytest.raises(mb.InputError, match="all of them displacements"):
        models[0].frequency_response(lines, ["m1"], ["m1", "velocity of m2"], count=4)
    with pytest.raises(mb.InputError, match="motions or elongations"):
        models[0].frequency_response(lines, ["m1"], ["force of k4"], count=4)
    with pytest.raises(mb.InputError, match="force on ground is available for models with mass, damping and stiffness as arrays"):
        models[0].frequency_response(lines, ["m1"], ["force on ground"], count=4)
