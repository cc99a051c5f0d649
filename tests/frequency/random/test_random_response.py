"""Random responses against certified integrals, closed formulas of textbooks, and published values."""

import numpy as np
import pytest
from flint import acb, arb, ctx
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.ground.tolerances import EPS


def oscillator(damping_ratio, w=20.0, mass=2.0):
    return mb.MechanicalSystem([[mass]], [[2 * damping_ratio * w * mass]], [[w**2 * mass]])


def base_excited(damping_ratio, w=20.0):
    c, k = 2 * damping_ratio * w, w**2
    return mb.MechanicalSystem(np.diag([1.0, 0.0]), [[c, -c], [-c, c]], [[k, -k], [-k, k]], [mb.Constraint([0, 1], names="base")])


@pytest.mark.parametrize("damping_ratio", [1e-14, 1e-9, 1e-4, 0.05, 0.7, 1 - 1e-9, 1.0, 1 + 1e-9, 10.0])
def test_one_mass_under_white_noise(damping_ratio):
    """E[x^2] = G / (4 c k), E[v^2] = G / (4 c m); the acceleration is infinite (Crandall and Mark, Random Vibration, 1963, section 2.2)."""
    system, G = oscillator(damping_ratio), 3.0
    (m,), (c,), (k,) = system.mass[0], system.damping[0], system.stiffness[0]
    x = system.random_response({"x1": mb.white_noise(G)})
    v = system.random_response({"x1": mb.white_noise(G)}, quantity="velocity")
    a = system.random_response({"x1": mb.white_noise(G)}, quantity="acceleration")
    assert np.isclose(x.covariance.item(), G / (4 * c * k), rtol=1e-12)
    assert np.isclose(v.covariance.item(), G / (4 * c * m), rtol=1e-12)
    assert x.error_estimate[0] < 1e-11
    assert np.isinf(a.rms).all()
    assert "directly" in a.infinite["x1"]
    assert np.isclose(a.white_part[0], G / m**2)
    assert np.isclose(x.crossing_rate()[0], np.sqrt(k / m) / (2 * np.pi), rtol=1e-12)


@given(st.floats(-14, 1), st.floats(-3, 3))
def test_absolute_acceleration_on_a_white_base(exponent, size):
    """E[a^2] = pi f_n W (1 + 4 z^2) / (4 z), relative displacement W / (8 z w^3) (Crandall and Mark 1963)."""
    z, w = 10.0**exponent, 10.0**size
    system, W = base_excited(z, w), mb.white_noise(0.3, of="acceleration")
    absolute = system.random_response({"base": W}, "x1", "acceleration")
    relative = system.random_response({"base": W}, "x1", relative_to="base")
    assert np.isclose(absolute.covariance.item(), w / 2 * 0.3 * (1 + 4 * z**2) / (4 * z), rtol=1e-12)
    assert np.isclose(relative.covariance.item(), 0.3 / (8 * z * w**3), rtol=1e-12)


def test_published_two_masses_on_a_base():
    """ANSYS Verification Manual VM68 (Vierck): 9.059 g and 10.63 g; both with 16 digits by certified integration of the sums of two modes."""
    k1, k2 = 42832.0, 32416.0
    K = np.array([[k1 + k2, -k2, -k1], [-k2, k2, 0.0], [-k1, 0.0, k1]])
    system = mb.MechanicalSystem(
        np.diag([0.5, 1.0, 0.0]), None, K, [mb.Constraint([0, 0, 1], names="base")], names=["m1", "m2", "floor"]
    )
    spectrum = mb.psd([10, 100], [0.1, 0.1], of="acceleration", unit="g^2/Hz")
    R = system.random_response({"base": spectrum}, ["m1", "m2"], "acceleration", relative_to="base", modal_damping=0.02)
    exact = [modal_rms(place) for place in range(2)]
    assert exact == pytest.approx([9.058711093627037, 10.633260114112232], rel=1e-13)
    assert np.allclose(exact, [9.059, 10.63], rtol=4e-4)  # as printed in the manual
    assert np.allclose(R.rms / 9.80665, exact, rtol=1e-13)
    assert R.units == ("m/s^2", "m/s^2")


def modal_rms(place):
    """Of mass 1 or 2 of VM68, in g: w^2 sum over modes of u_i (u_i^T M 1) / (w_i^2 - w^2 + 2 i z w_i w), 10 to 100 Hz, by python-flint.

    M = diag(1/2, 1) and K = [[k1 + k2, -k2], [-k2, k2]]: w_i^2 are the roots of l^2 - b l + c, and u_i ~ (k2 - l, k2).
    """
    k1, k2 = arb(42832), arb(32416)
    with ctx.workdps(40):
        b, c = 2 * (k1 + k2) + k2, 2 * k1 * k2
        modes = []
        for sign in (-1, 1):
            square = (b + sign * (b * b - 4 * c).sqrt()) / 2
            u = k2 - square, k2
            mass = u[0] * u[0] / 2 + u[1] * u[1]
            modes.append((square.sqrt(), u[place] * (u[0] / 2 + u[1]) / mass))

        def integrand(f, _):
            w = 2 * acb.pi() * f
            one, other = (sum(share / (wi * wi - w * w + s * acb(0, "0.04") * wi * w) for wi, share in modes) for s in (1, -1))
            return one * other * w**4 / 10

        return float(acb.integral(integrand, acb(10), acb(100), rel_tol=arb(10) ** -20, eval_limit=10**6).real.sqrt())


def test_a_spectrum_next_to_an_undamped_resonance_is_finite():
    """The integral of 1 / (w_n^2 - w^2)^2 has an elementary antiderivative; a spectrum with the resonance is infinite."""
    system, wn = mb.MechanicalSystem([[1.0]], None, [[4.0]]), 2.0

    def antiderivative(w):
        return w / (2 * wn**2 * (wn**2 - w**2)) + np.arctanh(min(w, wn**2 / w) / wn) / (2 * wn**3)

    for low, high in ((0.1, 0.3), (0.32, 1.0)):
        R = system.random_response({"x1": mb.psd([low, high], [1.0, 1.0])})
        expected = (antiderivative(2 * np.pi * high) - antiderivative(2 * np.pi * low)) / (2 * np.pi)
        assert np.isclose(R.covariance.item(), expected, rtol=1e-10)
    assert "no damping" in system.random_response({"x1": mb.psd([0.1, 1.0], [1.0, 1.0])}).infinite["x1"]


def test_what_is_infinite_and_what_is_not():
    """Rigid bodies, reactions of massless joints, moments: nothing finite is called infinite, nothing infinite has a number."""
    ties = [[1.0, -1.0], [-1.0, 1.0]]
    free = mb.MechanicalSystem(np.eye(2), np.multiply(0.1, ties), ties)
    white = {"x1": mb.white_noise(1.0)}
    assert set(free.random_response(white).infinite) == {"x1", "x2"}
    assert not free.random_response(white, "x1", relative_to="x2").infinite
    assert set(free.random_response(white, quantity="acceleration").infinite) == {"x1"}
    assert not free.random_response({"x1": mb.psd([0.1, 1.0], [1.0, 1.0])}).infinite
    held = base_excited(0.1)
    reaction = held.random_response({"x1": mb.white_noise(1.0)}, quantity="reaction")
    assert np.isinf(reaction.rms).all() == ("base" in reaction.infinite)
    one = oscillator(0.1).random_response({"x1": mb.white_noise(1.0)})
    assert np.isfinite([one.moment(k)[0] for k in range(3)]).all()
    assert np.isinf([one.moment(k)[0] for k in (3, 4)]).all()
    unstable = mb.MechanicalSystem([[1.0]], [[-0.1]], [[1.0]]).random_response({"x1": mb.psd([0.1, 1.0], [1.0, 1.0])})
    assert "unstable" in unstable.infinite["x1"]
    massless = mb.MechanicalSystem(np.diag([1.0, 0.0]), np.diag([0.1, 0.0]), [[2.0, -1.0], [-1.0, 1.0]])
    assert set(massless.random_response({"x2": mb.white_noise(1.0)}).infinite) == {"x2"}  # the joint follows the force at once


def test_coherent_inputs_with_a_delay():
    """The sum of u(t) and u(t - tau): 2 integral of G (1 + cos w tau) df, through two stiffnesses without mass."""
    system = mb.MechanicalSystem(np.zeros((1, 1)), None, [[1.0]]).random_response
    pair = mb.MechanicalSystem(np.zeros((3, 3)), None, np.array([[1.0, 0, 0], [0, 1.0, 0], [-1.0, -1.0, 1.0]]))
    f = mb.psd([0.5, 4.0], [2.0, 2.0])
    R = pair.random_response({"x1": f, "x2": f}, "x3", delays={"x1": 0.0, "x2": 0.3})
    turn = lambda f: f + np.sin(2 * np.pi * f * 0.3) / (2 * np.pi * 0.3)  # noqa: E731
    assert np.isclose(R.covariance.item(), 2 * 2.0 * (turn(4.0) - turn(0.5)), rtol=1e-13)
    independent = pair.random_response({"x1": f, "x2": f}, "x3")
    half = pair.random_response({"x1": f, "x2": f}, "x3", coherence=0.25)
    single = system({"x1": f}).covariance.item()
    assert np.isclose(independent.covariance.item(), 2 * single)
    assert np.isclose(half.covariance.item(), (2 + 2 * 0.5) * single)


def test_filtered_noise_is_the_cascade():
    """A filter 1 / (1 + T s) before an oscillator: the variance is that of the chain of both, solved as a descriptor system."""
    T, w, z = 0.4, 3.0, 0.02
    spectrum = mb.rational_spectrum(2.0, [1.0], [T, 1.0])
    R = oscillator(z, w, 1.0).random_response({"x1": spectrum})
    # Lyapunov's equation of (x, v, q), q the filtered noise.
    A = np.array([[0, 1, 0], [-(w**2), -2 * z * w, 1], [0, 0, -1 / T]])
    B = np.array([[0], [0], [1 / T]])
    P = np.linalg.solve(np.kron(np.eye(3), A) + np.kron(A, np.eye(3)), -(B @ B.T).ravel()).reshape(3, 3)
    assert np.isclose(R.covariance.item(), P[0, 0] * 2.0 / 2, rtol=1e-12)
    later = R.covariance_over_time([1e4])
    assert np.isclose(later.item(), R.covariance.item(), rtol=1e-10)


def test_statistics():
    """Rice's rates of a narrow band; Dirlik's formula tends to the narrow band one; the largest value of many cycles."""
    narrow = oscillator(1e-3).random_response({"x1": mb.psd([1.0, 10.0], [1.0, 1.0])})
    assert 0.95 < narrow.irregularity[0] < 1
    assert np.isclose(narrow.crossing_rate()[0], 20 / (2 * np.pi), rtol=1e-2)
    rms = narrow.rms[0]
    damage = [narrow.damage_rate(4.0, 10 * rms, method)[0] for method in ("dirlik", "narrow-band")]
    assert np.isclose(*damage, rtol=0.2)
    assert 3 * rms < narrow.expected_maximum(600.0)[0] < 5 * rms
    assert np.isclose(narrow.crossing_rate(rms)[0], narrow.crossing_rate()[0] * np.exp(-0.5))
    with pytest.raises(mb.InputError, match="periods"):
        narrow.expected_maximum(0.01)


def test_covariance_over_time():
    """A free mass: G t^3 / 6; an oscillator from rest (Caughey and Stumpf, Journal of Applied Mechanics 28, 1961, equation 9)."""
    mass = mb.MechanicalSystem([[1.0]]).random_response({"x1": mb.white_noise(2.0)})
    assert np.isclose(mass.covariance_over_time([2.0]).item(), 2.0**3 / 3, rtol=1e-14)
    z, w, t, G = 0.05, 3.0, 0.8, 1.5
    R = oscillator(z, w, 1.0).random_response({"x1": mb.white_noise(G)})
    wd = w * np.sqrt(1 - z**2)
    decay = np.exp(-2 * z * w * t)
    bracket = 1 - decay / wd**2 * (wd**2 + 2 * (z * w * np.sin(wd * t)) ** 2 + z * w * wd * np.sin(2 * wd * t))
    assert np.isclose(R.covariance_over_time([t]).item(), G / (8 * z * w**3) * bracket, rtol=1e-12)
    start = R.covariance_over_time([0.0, 1.0], initial_covariance=np.diag([4.0, 0.0]))
    assert np.isclose(start[0].item(), 4.0)
    fading = R.covariance_over_time([50.0], modulation=[(1.0, 0.5)])
    assert fading.item() < 1e-3 * R.covariance.item()


@pytest.mark.parametrize("spectrum", [mb.white_noise(1.0), mb.psd([0.1, 5.0], [2.0, 0.5])])
def test_sample_paths_have_the_covariance(spectrum):
    """Of 400 paths at three times, within five standard deviations; a seed repeats its path."""
    R = oscillator(0.1).random_response({"x1": spectrum})
    paths = np.array([R.sample([0.0, 0.1, 7.0], seed)[0] for seed in range(400)])
    deviation = np.sqrt(2 / 400) * R.covariance.item()
    assert (np.abs((paths**2).mean(axis=0) - R.covariance.item()) < 5 * deviation).all()
    assert (R.sample([0.0, 1.0], 3) == R.sample([0.0, 1.0], 3)).all()


def test_spectra_of_outputs():
    """G_y = |H|^2 G, zero beyond the table; their integral is the covariance."""
    R = oscillator(0.3).random_response({"x1": mb.psd([1.0, 4.0], [1.0, 3.0], interpolation="linear")})
    H = oscillator(0.3).frequency_response([2.0]).values.item()
    assert np.isclose(R.psd([2.0]).item(), abs(H) ** 2 * (1 + 2 / 3))
    assert R.psd([0.5, 4.5]).tolist() == [[0.0, 0.0]]
    ends = [abs(oscillator(0.3).frequency_response([one]).values.item()) ** 2 * G for one, G in ((1.0, 1.0), (4.0, 3.0))]
    assert np.allclose(R.psd([1.0, 4.0]), ends)  # a table holds at both of its ends
    f = np.linspace(1.0, 4.0, 20001)
    assert np.isclose(np.trapezoid(R.psd(f)[0], f), R.covariance.item(), rtol=1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: mb.psd([1, 2], [1, -1]), "not negative"),
        (lambda: mb.psd([2, 1], [1, 1]), "ascending"),
        (lambda: mb.psd([1, 1], [1, 1]), "ascending"),
        (lambda: mb.psd([1, 2], [1]), "values"),
        (lambda: mb.psd([1], [1]), "at least two"),
        (lambda: mb.psd([1, 2], [1, 1], interpolation="steps"), "one for each band"),
        (lambda: mb.psd([1, 2], [1, 1], of="displacement", unit="m^2/s^2/Hz"), "mm\\^2/Hz"),
        (lambda: mb.psd([0, 2], [1, 1]), "0 Hz"),
        (lambda: mb.psd([1, 2], [1, np.nan]), "finite"),
        (lambda: mb.psd([1, 2], [1, 1], of="acceleration", unit="g"), "squared per Hz"),
        (lambda: mb.psd([1, 2], [1, 1], of="acceleration", unit="N^2/Hz"), "g\\^2/Hz"),
        (lambda: mb.psd([1, 2], [1, 1], of="acceleratoin"), "acceleration"),
        (lambda: mb.rational_spectrum(1.0, [1], [1, -1]), "root"),
        (lambda: oscillator(0.1).random_response({"x": mb.white_noise(1.0)}), "x1"),
        (lambda: oscillator(0.1).random_response({}), "expected a table"),
        (lambda: oscillator(0.1).random_response({"x1": 3.0}), "mb.psd"),
        (lambda: oscillator(0.1).random_response({"x1": mb.white_noise(1.0, of="acceleration")}), "nothing prescribes its motion"),
        (lambda: base_excited(0.1).random_response({"base": mb.white_noise(1.0)}), "prescribed motion"),
        (lambda: base_excited(0.1).random_response({"base": mb.white_noise(1.0, of="velocity")}, "bas"), 'mean "base"'),
        (lambda: oscillator(0.1).random_response({"x1": mb.white_noise(1.0)}, quantity="speed"), "displacement"),
        (lambda: oscillator(0.1).random_response({"x1": mb.white_noise(1.0)}, delays=[1.0]), "table"),
        (lambda: oscillator(0.1).random_response({"x1": mb.white_noise(1.0)}).crossing_rate("a"), "level"),
        (lambda: oscillator(0.1).random_response({"x1": mb.white_noise(1.0)}).rms_in_bands([2.0, 1.0]), "ascending"),
        (lambda: mb.octave_bands(2.0, 1.0), "more than low"),
        (lambda: oscillator(0.1).random_response({"x1": mb.white_noise(1.0)}, coherence=2.0), "from 0 to 1"),
    ],
)
def test_bad_input(make, message):
    """Each mistake has a message with what to do."""
    with pytest.raises(mb.InputError, match=message):
        make()


def test_values_in_bands():
    """RMS values of octaves add up to the whole; an output of infinite variance has finite parts, its spectrum integrated by trapezoids."""
    R = oscillator(0.05).random_response({"x1": mb.psd([1.0, 40.0], [1.0, 3.0])})
    octaves = mb.octave_bands(1.0, 40.0)
    assert octaves[0] <= 1.0 < octaves[1] and octaves[-2] < 40.0 <= octaves[-1]
    assert np.isclose(np.square(R.rms_in_bands(octaves)).sum(), R.covariance.item(), rtol=1e-13)
    rough = oscillator(0.3).random_response({"x1": mb.white_noise(2.0)}, quantity="acceleration")
    f = np.linspace(0.0, 3.0, 20001)
    parts = rough.cumulative_rms([1.0, 3.0])
    assert np.isclose(parts[0, 1], np.sqrt(np.trapezoid(rough.psd(f)[0], f)), rtol=1e-6)
    assert np.isinf(rough.rms_in_bands([0.0, 3.0, np.inf])).tolist() == [[False, True]]
    undamped = mb.MechanicalSystem([[1.0]], None, [[4.0]]).random_response({"x1": mb.white_noise(2.0)})
    assert np.isinf(undamped.rms_in_bands([0.0, 0.2, 0.4, 1.0])).tolist() == [[False, True, False]]


def test_tables_of_xarray():
    """Spectra with their frequencies, units and RMS values."""
    pytest.importorskip("xarray")
    R = oscillator(0.3).random_response({"x1": mb.white_noise(2.0)})
    table = R.to_xarray([1.0, 2.0])
    assert (table.values == R.psd([1.0, 2.0])).all()
    assert table.rms.item() == R.rms[0]
    assert table.unit.item() == "m^2/Hz"


def test_one_output_of_several():
    """A response of some outputs is that of the whole, and has a path although another one has none."""
    R = oscillator(0.1).random_response({"x1": mb.psd([0.1, 5.0], [2.0, 0.5])})
    assert (R.only("x1").sample([0.0, 1.0], 3) == R.sample([0.0, 1.0], 3)).all()
    with pytest.raises(mb.InputError, match="x1"):
        R.only("x")


def test_a_path_at_even_times_is_that_of_uneven_rounding():
    """Times that differ by rounding errors have one step, the path goes on from time to time whatever their order."""
    R = oscillator(0.1).random_response({"x1": mb.white_noise(1.0)})
    times = np.linspace(0.0, 7.0, 50)
    assert np.allclose(R.sample(times, 1), R.sample(times * (1 + 1e-15), 1), rtol=1e-9)
    free = mb.MechanicalSystem(np.eye(2), np.diag([0.1, 0.0]), np.eye(2)).random_response({"x1": mb.white_noise(1.0)}, "x1")
    path = free.sample(np.arange(0.0, 20000.0, 7.0), 1)  # the other mass has no damping and stays at rest
    assert np.isclose(np.std(path), free.rms[0], rtol=0.15)


@pytest.mark.parametrize(
    ("of", "unit", "factor"),
    [
        ("acceleration", "m^2/s^3", 1.0),
        ("acceleration", "mm^2/s^4/Hz", 1e-6),
        ("acceleration", "g**2/Hz", 9.80665**2),
        ("velocity", "mm^2/s", 1e-6),
        ("velocity", "m^2/s^2/Hz", 1.0),
        ("displacement", "cm^2 s", 1e-4),
        ("force", "(N*m)^2/Hz", 1.0),
        ("force", "kN^2*s", 1e6),
    ],
)
def test_units_of_densities(of, unit, factor):
    """One density has several names."""
    assert np.isclose(mb.psd([1.0, 2.0], [1.0, 1.0], of=of, unit=unit)(1.5), factor, rtol=4 * EPS)


def test_two_sided_densities_per_radian():
    """S per rad/s is G = 4 pi S."""
    two_sided = mb.psd([1.0, 2.0], [1.0, 1.0], unit="N^2 s/rad")
    assert np.isclose(two_sided(1.5), 4 * np.pi, rtol=4 * EPS)
