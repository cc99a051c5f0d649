"""Values entry by entry against 50 digits; poles, residues and polynomial part against exact pairs; what a pole on a line gives."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.frequency.frequency_response import SUM_LINES
from mbconstrained.ground.errors import InputError
from tests.frequency.references import chain_solved, relative_error, solved


def chain(n, mass=10.0, stiffness=1e5, damping=50.0):
    """Masses in a row between two walls."""
    T = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    return mb.MechanicalSystem(mass * np.eye(n), damping * T, stiffness * T)


@pytest.mark.parametrize("n", [10, 50, 200])
def test_every_entry_of_a_chain_has_its_digits_in_the_stop_band_too(n):
    """The last mass answers the first above all frequencies with 1e-6 at 10 masses and 1e-300 at 200: no sum of modes has it."""
    system = chain(n)
    frequencies = [0.0, 3.0, 30.0, 33.0, 60.0, 200.0 if n < 200 else 70.0]
    H = system.frequency_response(frequencies, ["x1"], ["x1", f"x{n}"])
    coefficients = (system.stiffness, system.damping, system.mass)
    for line, f in enumerate(frequencies):
        exact = chain_solved(coefficients, f, 0)
        for row, place in enumerate((0, n - 1)):
            error = relative_error(H.values[row, 0, line], exact[place])
            assert error <= max(H.error_estimate[row, 0, line], 2e-16)
            assert H.error_estimate[row, 0, line] <= 1e-10


def beam(elements, damping=1e-5):
    """A cantilever of Euler-Bernoulli elements of unit length, with consistent masses and damping by stiffness: fronts of two."""
    K = np.array([[12.0, 6, -12, 6], [6, 4, -6, 2], [-12, -6, 12, -6], [6, 2, -6, 4]])
    M = np.array([[156.0, 22, 54, -13], [22, 4, 13, -3], [54, 13, 156, -22], [-13, -3, -22, 4]]) / 420
    size = 2 * elements + 2
    stiffness, mass = np.zeros((2, size, size))
    for at in range(0, size - 2, 2):
        stiffness[at : at + 4, at : at + 4] += K
        mass[at : at + 4, at : at + 4] += M
    return mass[2:, 2:], damping * stiffness[2:, 2:], stiffness[2:, 2:]


@pytest.mark.parametrize("turning", [0.0, 0.3])
def test_estimates_of_a_beam_bound_its_errors(turning):
    """Mass and stiffness cancel in its entries; with gyroscopic moments the matrices are not symmetric."""
    M, C, K = beam(20)
    n = len(M)
    C = C + turning * (np.diag(np.ones(n - 2), 2) - np.diag(np.ones(n - 2), -2))
    frequencies = np.geomspace(1e-4, 1.0, 12)
    system = mb.MechanicalSystem(M, C, K)
    H = system.frequency_response(frequencies, ["x1", "x39"], ["x39", "x2"])
    assert H.harmonic.solver.is_sparse(2 * np.pi * frequencies)
    for line, f in enumerate(frequencies):
        exact = solved((K, C, M), f, np.eye(n)[:, [0, 38]])[[38, 1]]
        for place in np.ndindex(2, 2):
            error = relative_error(H.values[(*place, line)], exact[place])
            assert error <= max(H.error_estimate[(*place, line)], 2e-16)
            assert H.error_estimate[(*place, line)] <= 1e-10


def random_constrained(seed):
    """Whole numbers; singular M, constraint rows at position level with reactions: an index 3 system."""
    random = np.random.default_rng(seed)
    n, k = 6, int(random.integers(1, 3))
    J, D = random.integers(-2, 3, (n, 4)), random.integers(-1, 2, (n, n))
    K = random.integers(-3, 4, (n, n))
    rows = random.integers(-2, 3, (k, n))
    return mb.MechanicalSystem(
        J @ J.T, D @ D.T, K @ K.T + np.eye(n), [mb.Constraint(row, names=f"row {i}") for i, row in enumerate(rows)]
    )


def saddle_point(system):
    """Coefficients of [P(s), -A^T; A, 0]."""
    k, A = len(system.rows), system.constraint_matrix
    coefficients = [np.pad(matrix, ((0, k), (0, k))) for matrix in (system.stiffness, system.damping, system.mass)]
    coefficients[0][: system.size, system.size :], coefficients[0][system.size :, : system.size] = -A.T, A
    return coefficients


@pytest.mark.parametrize("seed", [*range(8), *(pytest.param(seed, marks=pytest.mark.long) for seed in range(8, 20))])
def test_motions_and_reactions_of_constrained_models_with_singular_mass(seed):
    system = random_constrained(seed)
    n, rows = system.size, [row.name for row in system.rows]
    inputs = ["x1", rows[0]]
    coefficients = saddle_point(system)
    unit = np.eye(len(coefficients[0]))
    B = unit[:, [0, n]]
    A = mb.PolynomialMatrix(coefficients)
    exact = mb.exact.jordan_pairs(A)
    frequencies = [0.05, 0.3, 2.0]
    motions = system.frequency_response(frequencies, inputs)
    reactions = system.frequency_response(frequencies, inputs, quantity="reaction")
    for line, f in enumerate(frequencies):
        X = solved(coefficients, f, B)
        got = np.vstack([motions.values[..., line], reactions.values[..., line]])
        for value, reference in zip(got.ravel(), X.ravel()):
            assert (abs(reference) > 1e-30 and relative_error(value, reference) <= 1e-11) or value == reference
    for response, place in ((motions, slice(0, n)), (reactions, slice(n, None))):
        D = [np.array(exact.laurent(k), dtype=float)[place] @ B for k in range(4)]
        for k, reference in enumerate(D):
            own = response.polynomial[k] if k < len(response.polynomial) else np.zeros_like(reference)
            np.testing.assert_allclose(own, reference, rtol=1e-11, atol=1e-11 * np.abs(D).max())


def test_poles_residues_and_polynomial_part_add_up_to_the_values():
    system = random_constrained(3)
    for quantity in ("receptance", "mobility", "accelerance"):
        H = system.frequency_response([0.01, 0.2, 1.0], ["x1", "x2"], quantity=quantity)
        s = 2j * np.pi * H.frequencies_hz
        total = sum(D[..., None] * s**k for k, D in enumerate(H.polynomial))
        for pole, residues in zip(H.poles, H.residues):
            total = total + sum(R[..., None] / (s - pole) ** (j + 1) for j, R in enumerate(residues))
        assert np.abs(total - H.values).max() <= 1e-11 * np.abs(H.values).max()


def test_defective_poles_have_residues_of_higher_order():
    H = mb.frequency_response(mb.PolynomialMatrix([[[1.0]], [[2.0]], [[1.0]]]), [0.1])  # 1 / (s + 1)^2
    np.testing.assert_allclose(H.poles, [-1.0], rtol=1e-7)
    np.testing.assert_allclose(H.residues[0].ravel(), [0.0, 1.0], atol=1e-12)


def test_a_free_body_has_its_inverse_mass_at_0_hz_and_a_finite_part():
    free = mb.MechanicalSystem(np.diag([1.0, 2.0]), None, [[3.0, -3.0], [-3.0, 3.0]], names=["a", "b"])
    H = free.frequency_response([0.0, 0.1], ["a"])
    np.testing.assert_allclose(H.rigid_body, [[1 / 3], [1 / 3]], rtol=1e-14)
    assert [one.pole.order for one in H.poles_on_lines] == [2]
    assert np.isinf(H.error_estimate[..., 0]).all()
    # (s^2 + 1.5) / (s^2 (s^2 + 4.5)) = 1/3 / s^2 + 2/3 / (s^2 + 4.5)
    np.testing.assert_allclose(H.values[0, 0, 0], 2 / 3 / 4.5, rtol=1e-14)
    assert "pole of order 2" in H.notices[0].text
    accelerance = free.frequency_response([0.0], ["a"], quantity="accelerance")
    np.testing.assert_allclose(accelerance.values[..., 0], [[1 / 3], [1 / 3]], rtol=1e-14)  # no pole there
    assert not accelerance.notices


def test_at_an_undamped_resonance_the_answer_is_its_pole_and_residue():
    spring = mb.MechanicalSystem([[2.0]], None, [[8.0]])
    H = spring.frequency_response([1 / np.pi, 0.1])
    (one,) = H.poles_on_lines
    assert one.line == 0 and abs(one.pole.value - 2j) <= 1e-15
    np.testing.assert_allclose(one.pole.residues[0], [[1 / 8j]], rtol=1e-14)  # 1/(2 (s - 2i)(s + 2i))
    assert np.isfinite(H.values).all() and H.values.all()
    np.testing.assert_allclose(H.values[0, 0, 0], 1 / 32, rtol=1e-12)  # the other term, (-1/8i) / 4i


def test_an_unobservable_pole_on_a_line_is_none():
    pair = mb.MechanicalSystem(np.eye(2), np.diag([0.0, 0.1]), np.diag([4.0, 9.0]), names=["a", "b"])
    H = pair.frequency_response([1 / np.pi], ["b"], ["b"])
    assert not H.poles_on_lines and H.error_estimate[0, 0, 0] <= 1e-10
    np.testing.assert_allclose(H.values[0, 0, 0], 1 / (9 - 4 + 0.2j), rtol=1e-13)


def test_the_sum_of_modes_is_used_where_it_has_the_digits_and_solutions_elsewhere():
    """A full matrix at many lines: entries far below the largest still have 1e-10, or an estimate that covers their error."""
    random = np.random.default_rng(5)
    Q, n = np.linalg.qr(random.standard_normal((14, 14)))[0], 14
    K = Q @ np.diag(np.geomspace(1.0, 1e3, n)) @ Q.T
    system = mb.MechanicalSystem(np.eye(n), 1e-3 * (K + K.T) / 2, (K + K.T) / 2)
    frequencies = np.geomspace(0.01, 300.0, SUM_LINES + 80)
    H = system.frequency_response(frequencies, ["x1", "x2"], ["x3", "x1"])
    few = system.frequency_response(frequencies[::37], ["x1", "x2"], ["x3", "x1"])
    assert (
        np.abs(H.values[..., ::37] - few.values) <= (H.error_estimate[..., ::37] + few.error_estimate) * np.abs(few.values)
    ).all()
    for line in (0, 200, len(frequencies) - 1):
        X = solved((system.stiffness, system.damping, system.mass), frequencies[line], np.eye(n)[:, :2])
        for i, place in enumerate((2, 0)):
            for j in range(2):
                assert relative_error(H.values[i, j, line], X[place, j]) <= min(H.error_estimate[i, j, line], 1e-10)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(0.01, 20.0))
def test_reciprocity_and_passivity(seed, frequency):
    """H is symmetric for symmetric M, C, K, and the power that forces put in is never negative: Re of mobilities is semidefinite."""
    random = np.random.default_rng(seed)
    parts = [random.standard_normal((4, 4)) for _ in range(3)]
    M, C, K = (part @ part.T + 0.1 * np.eye(4) for part in parts)
    H = mb.MechanicalSystem(M, C, K).frequency_response([frequency], quantity="mobility")
    value = H.values[..., 0]
    size = np.abs(value).max()
    assert np.abs(value - value.T).max() <= 1e-9 * size
    assert np.linalg.eigvalsh((value.real + value.real.T) / 2).min() >= -1e-9 * size


def test_enclosures_contain_the_values_of_50_digits():
    system = random_constrained(1)
    f, inputs = 0.3, ["x1"]
    H = system.frequency_response([f], inputs, ["x2"])
    box = H.enclose(f, digits=20)
    exact = solved(saddle_point(system), f, np.eye(len(saddle_point(system)[0]))[:, :1])[1, 0]
    for bounds, part in zip(zip(box.lower[:, 0], box.upper[:, 0]), (exact.real, exact.imag)):
        with mp.workdps(50):
            assert mp.mpf(bounds[0]) <= part <= mp.mpf(bounds[1])
    with pytest.raises(mb.InputError, match="pole"):
        mb.MechanicalSystem([[1.0]]).frequency_response([1.0]).enclose(0.0)


def test_deflection_shapes_have_all_coordinates():
    system = random_constrained(2)
    H = system.frequency_response([0.4], ["x2"], ["x3"])
    shape = H.deflection_shape(0.4)
    expected = solved(saddle_point(system), 0.4, np.eye(len(shape))[:, 1:2])[:, 0]
    rows = [row.name for row in system.rows]
    assert list(shape) == [*system.names, *rows]
    for name, value, reference in zip(shape, shape.values(), expected):
        assert relative_error(value * (-1 if name in rows else 1), reference) <= 1e-10
    with pytest.raises(mb.InputError, match="pole on the axis"):
        mb.MechanicalSystem([[1.0]]).frequency_response([1.0]).deflection_shape(0.0)


def test_transfer_functions_and_state_spaces():
    y = mb.transfer_function_response([1, 0, 0, 1], [1, 0.1, 4])
    H = y.frequency_response([0.1, 0.2])
    s = 2j * np.pi * H.frequencies_hz
    np.testing.assert_allclose(H.values[0, 0], (s**3 + 1) / (s**2 + 0.1 * s + 4), rtol=1e-13)
    np.testing.assert_allclose(H.polynomial.ravel(), [-0.1, 1.0], rtol=1e-13)  # s - 0.1 + ...
    descriptor = mb.StateSpace(
        [[-1.0, 0.0], [0.0, 1.0]], [[1.0], [1.0]], [[1.0, 1.0]], [[2.0]], descriptor=[[1.0, 0.0], [0.0, 0.0]], outputs=["y"]
    )
    G = descriptor.frequency_response([0.0, 0.3], outputs=["y"])
    s = 2j * np.pi * G.frequencies_hz
    np.testing.assert_allclose(G.values[0, 0], 1 / (s + 1) + 1.0, rtol=1e-14)  # 1/(s + 1) - 1 + 2
    np.testing.assert_allclose(G.polynomial.ravel(), [1.0], rtol=1e-14)


def test_an_input_that_reaches_nothing_is_reported():
    apart = mb.MechanicalSystem(np.eye(2), None, np.eye(2), names=["a", "b"])
    assert "reaches none" in apart.frequency_response([0.1], ["a"], ["b"]).notices[0].text


def test_lines_in_any_order_and_repeated_have_the_same_bits_and_the_ends_of_float64_are_errors():
    system = chain(4)
    ordered, mixed = (system.frequency_response(f, ["x1"]) for f in ([0.0, 0.3, 2.0], [2.0, 0.3, 0.3, 0.0]))
    assert (mixed.values == ordered.values[..., [2, 1, 1, 0]]).all()
    assert system.frequency_response([]).values.shape == (4, 4, 0)
    small = system.frequency_response([1e-300, 5e-324], ["x1"])
    np.testing.assert_allclose(small.values[..., 0], system.frequency_response([0.0], ["x1"]).values[..., 0], rtol=1e-14)
    far = system.frequency_response([1e60], ["x1"], ["x1"])
    np.testing.assert_allclose(far.values.item(), -1 / system.mass[0, 0] / (2 * np.pi * 1e60) ** 2, rtol=1e-10)
    for value in (1e150, 1e300, 1.7e308):
        with pytest.raises(mb.InputError, match="leave the range of float64, expected at most"):
            system.frequency_response([value])


def test_masses_of_1e_14_and_spreads_of_28_orders_keep_their_digits():
    for mass, damping, stiffness, f in (
        ([1.0, 1e-14], np.diag([0.1, 0.1]), [[5.0, -3.0], [-3.0, 3.0]], 0.3),
        ([1.0, 1e-14], np.zeros((2, 2)), [[5.0, -3.0], [-3.0, 3.0]], 1e6),
        ([1e10, 1e-10], np.zeros((2, 2)), [[1.0, -1e-3], [-1e-3, 1e14]], 0.1),
    ):
        system = mb.MechanicalSystem(np.diag(mass), damping, stiffness)
        H = system.frequency_response([f], ["x1"])
        exact = solved((system.stiffness, system.damping, system.mass), f, np.eye(2)[:, :1])
        for i in range(2):
            assert relative_error(H.values[i, 0, 0], exact[i, 0]) <= max(H.error_estimate[i, 0, 0], 4e-16) <= 1e-11


@pytest.mark.parametrize(
    "frequencies, message",
    [([-1.0], "found -1 Hz"), ([np.nan], "finite"), ([np.inf], "finite"), ("all", '"auto"'), ([[1.0]], "list of numbers")],
)
def test_bad_frequencies_are_refused(frequencies, message):
    with pytest.raises(mb.InputError, match=message):
        mb.MechanicalSystem([[1.0]], None, [[1.0]]).frequency_response(frequencies)


def test_tables_and_files(tmp_path):
    H = chain(3).frequency_response([1.0, 2.0], ["x1"], ["x2", "x3"])
    array, frame = H.to_xarray(), H.to_pandas()
    assert array.sel(output="x3", input="x1").values.tolist() == H.values[1, 0].tolist() == frame["x3", "x1"].tolist()
    stored = np.load(H.write(tmp_path / "H.npz"), allow_pickle=False)
    assert (stored["values"] == H.values).all() and stored["units"].tolist() == [["m/N"], ["m/N"]]
    lines = H.write(tmp_path / "H.csv").read_text().splitlines()
    assert lines[0].split(",")[3] == "real x3/x1 (m/N)" and float(lines[1].split(",")[3]) == H.values[1, 0, 0].real
    with pytest.raises(mb.InputError, match="ending"):
        H.write(tmp_path / "H.txt")


def test_plots_have_an_axes_for_each_curve():
    H = chain(3).frequency_response([1.0, 2.0, 3.0], ["x1"], ["x2", "x3"])
    assert [len(H.plot(kind).axes) for kind in ("bode", "nyquist", "parts")] == [4, 2, 4]
    with pytest.raises(mb.InputError, match="bode"):
        H.plot("polar")


def response(**options):
    system = mb.MechanicalSystem(np.diag([1.0, 2.0]), 0.1 * np.eye(2), [[5.0, -4.0], [-4.0, 4.0]], names=["a", "b"])
    return system.frequency_response("auto", **options)


def test_a_matrix_of_bode_plots_with_marked_peaks_in_the_units_that_are_chosen():
    H = response()
    figure = H.plot(amplitude="dB", axis="rpm", unwrapped=False)
    axes = np.array(figure.axes).reshape(4, 2)
    size, phase = axes[0, 1], axes[1, 1]
    assert (size.get_title(), size.get_ylabel(), phase.get_xlabel()) == ("a / b", "receptance (dB re 1 m/N)", "frequency (rev/min)")
    x, y = size.lines[0].get_data()
    assert np.allclose(x, 60 * H.frequencies_hz) and np.allclose(y, 20 * np.log10(np.abs(H.values[0, 1])))
    assert np.abs(phase.lines[0].get_ydata()).max() <= 180
    peaks = [peak for peak in H.peaks if (peak.output, peak.input) == ("a", "b")]
    assert sorted(text.get_text() for text in size.texts) == sorted(f"{60 * peak.frequency_hz:.4g} rev/min" for peak in peaks)


def test_transmissibility_has_a_line_at_one():
    row = mb.Constraint([1.0, 0.0], names="base")
    system = mb.MechanicalSystem(np.diag([0.0, 1.0]), None, [[4.0, -4.0], [-4.0, 4.0]], [row])
    size, _ = system.frequency_response([0.1, 1.0], "base", "x2", quantity="transmissibility").plot().axes
    assert list(size.lines[1].get_ydata()) == [1.0, 1.0] and size.get_ylabel() == "transmissibility"


@pytest.mark.parametrize("wrong", [{"kind": "bodé"}, {"axis": "kHz"}, {"amplitude": "db"}])
def test_unknown_kinds_axes_and_amplitudes_are_refused(wrong):
    with pytest.raises(InputError, match=f"{next(iter(wrong))}: found"):
        response().plot(**wrong)
