"""Derivatives of modes against differences with 80 digits; of motions and responses against differences of closed forms and formulas."""

import mpmath
import numpy as np
import pytest

import mbconstrained as mb

STEP = mpmath.mpf(10) ** -25


def machine(exact=float, **changed):
    """A gear train that drives a rack against a sprung mass, its numbers by name; ``exact`` makes the numbers of the matrices."""
    p = {key: exact(value) for key, value in NUMBERS.items()} | changed
    zero = exact(0)
    M = np.diag([p["a"], p["b"], p["wheel 1"], p["wheel 2"]])
    spring, tie = np.array([[1, -1], [-1, 1]]), np.zeros((4, 4), dtype=int)
    pair, wall, twist = tie.copy(), tie.copy(), tie.copy()
    pair[:2, :2], wall[0, 0], twist[2, 2] = spring, 1, 1
    K = wall * p["k1"] + pair * p["k2"] + twist * p["kt"]
    C = pair * p["c"]
    rows = [[zero, zero, exact(1), p["gear.end_radius"] / p["gear.start_radius"]], [zero, exact(1), zero, -p["rack.radius"]]]
    return M, C, K, np.array(rows)


NUMBERS = {
    "a": 2.0,
    "b": 3.0,
    "wheel 1": 0.5,
    "wheel 2": 0.75,
    "k1": 100.0,
    "k2": 50.0,
    "c": 1.5,
    "kt": 30.0,
    "gear.start_radius": 0.125,
    "gear.end_radius": 0.25,
    "rack.radius": 0.375,
}


@pytest.fixture(scope="module")
def model():
    m = mb.LumpedModel()
    for name in ("a", "b"):
        m.mass(name, NUMBERS[name])
    for name in ("wheel 1", "wheel 2"):
        m.inertia(name, NUMBERS[name])
    m.spring("ground", "a", NUMBERS["k1"], name="k1", rest_length=0.2)
    m.spring("a", "b", NUMBERS["k2"], name="k2")
    m.damper("a", "b", NUMBERS["c"], name="c")
    m.torsion_spring("ground", "wheel 1", NUMBERS["kt"], name="kt")
    m.gear("wheel 1", "wheel 2", NUMBERS["gear.start_radius"], NUMBERS["gear.end_radius"], name="gear")
    m.rack("wheel 2", "b", NUMBERS["rack.radius"], name="rack")
    return m


def precise_mode(matrices, value, shape, place):
    """s and u of L(s) (u, lambda) = 0 by Newton's method with 80 digits, u[place] = 1."""
    M, C, K, A = (mpmath.matrix(matrix.tolist()) for matrix in matrices)
    n, k = M.rows, A.rows
    s, x = mpmath.mpc(value), mpmath.matrix([mpmath.mpc(v) for v in shape] + [mpmath.mpc(0)] * k)
    for _ in range(9):
        P, D = M * s * s + C * s + K, M * s * 2 + C
        L, right = mpmath.zeros(n + k + 1), mpmath.zeros(n + k + 1, 1)
        L[:n, :n], L[:n, n : n + k], L[n : n + k, :n] = P, -A.T, A
        border = D * x[:n]
        for i in range(n):
            L[i, n + k] = border[i]
        L[n + k, place] = 1
        residual = L[: n + k, : n + k] * x
        for i in range(n + k):
            right[i] = -residual[i]
        step = mpmath.lu_solve(L, right)
        x, s = x + step[: n + k], s + step[n + k]
    return s, x[:n]


@pytest.mark.parametrize("name", NUMBERS)
def test_eigenvalues_and_shapes_of_a_constrained_machine(model, name):
    """To 1e-10 of central differences with 80 digits, by every mass, spring, damper, radius."""
    system = model.assemble()
    d = system.sensitivities([name])
    shapes = d.shapes(name)
    with mpmath.workdps(80):
        for number, mode in enumerate(system.modes().oscillating):
            u = mode.shapes[:, 0]
            place = int(np.abs(u).argmax())
            ends = [
                precise_mode(machine(mpmath.mpf, **{name: mpmath.mpf(NUMBERS[name]) + sign * STEP}), mode.eigenvalue, u, place)
                for sign in (1, -1)
            ]
            slope = complex((ends[0][0] - ends[1][0]) / (2 * STEP))
            assert abs(d.eigenvalues[0, number] - slope) <= 1e-12 * max(abs(slope), 1e-3)
            turning = np.array([complex(z) for z in (ends[0][1] - ends[1][1]) / (2 * STEP)])
            np.testing.assert_allclose(shapes[:, number], turning, rtol=1e-10, atol=1e-12 * np.abs(turning).max())


@pytest.mark.parametrize("gap", [1e-2, 1e-4, 1e-6, 1e-8])
def test_close_eigenvalues(gap):
    """Two nearly equal oscillators, coupled by less than they differ: shapes turn fast, derivatives keep their digits."""
    M, C = np.eye(2), np.zeros((2, 2))
    K = np.array([[4.0, gap / 4], [gap / 4, 4.0 + gap]])
    slope = np.array([[0.0, 1.0], [1.0, 0.0]])
    d = mb.MechanicalSystem(M, C, K).sensitivities([mb.Parameter("coupling", gap / 4, stiffness=slope)])
    with mpmath.workdps(80):
        difference = mpmath.mpf(K[1, 1]) - 4
        root = mpmath.sqrt(difference**2 + 4 * mpmath.mpf(K[0, 1]) ** 2)
        for number, sign in enumerate((-1, 1)):
            w = mpmath.sqrt(4 + (difference + sign * root) / 2)
            expected = float(sign * 2 * mpmath.mpf(K[0, 1]) / root / (2 * w))
            assert abs(d.natural_frequencies[0, number] - expected) <= 1e-10 * abs(expected)


def test_semisimple_eigenvalues():
    """Of two equal oscillators w^2 = 4 the derivatives are the eigenvalues of the change, over 2 w."""
    change = np.array([[1.0, 2.0], [2.0, -3.0]])
    d = mb.MechanicalSystem(np.eye(2), stiffness=4 * np.eye(2)).sensitivities([mb.Parameter("p", 1.0, stiffness=change)])
    np.testing.assert_allclose(np.sort(d.natural_frequencies[0]), np.linalg.eigvalsh(change) / 4, rtol=1e-14)
    assert not d.eigenvalues.real.any()  # undamped modes stay so
    with pytest.raises(mb.InputError, match="multiple"):
        d.shapes("p")


def test_a_massless_coordinate():
    """A spring and a damper in series: (s + k / c) of the joint; M is singular."""
    system = mb.MechanicalSystem(np.diag([2.0, 0.0]), [[0.0, 0.0], [0.0, 3.0]], [[5.0, -5.0], [-5.0, 5.0]])
    d = system.sensitivities(["damping[x2, x2]"])
    for number, s in enumerate(system.modes().eigenvalues):  # 2 s^2 (3 s + 5) + 15 s = 0
        expected = -(2 * s**3 + 5 * s) / (18 * s**2 + 20 * s + 15)
        assert abs(d.eigenvalues[0, number] - expected) <= 1e-12 * abs(s)


TIMES = np.linspace(0.0, 6.0, 25)


def central_slope(function, p, h=0.02, weights=(4 / 5, -1 / 5, 4 / 105, -1 / 280)):
    """The derivative by central differences, of order 8 by default."""
    return sum(w * (function(p + i * h) - function(p - i * h)) / h for i, w in enumerate(weights, 1))


def damped(k, m2=1.5, base=None):
    """Two masses; the second hangs on the first by k, the first on a moving base if there is one."""
    return mb.MechanicalSystem(
        np.diag([2.0, m2, 0.0]),
        0.1 * np.array([[2.0, -1, -1], [-1, 1, 0], [-1, 0, 1]]),
        np.array([[9 + k, -k, -9], [-k, k, 0], [-9, 0, 9.0]]),
        [mb.Constraint([0, 0, 1], value=0.0 if base is None else base, names="base")],
    )


PAIR = np.array([[1.0, -1, 0], [-1, 1, 0], [0, 0, 0]])


@pytest.mark.parametrize("of", ["displacement", "velocity", "acceleration", "reaction"])
def test_motions(of):
    """A start, a force that steps later, a base that moves: differences of closed-form motions agree."""
    base, force = mb.harmonic([0.1], angular_frequency=1.3), mb.step([0.0, 2.0, 0.0]).delayed(1.0)
    start = {"displacement": [0.1, 0.3, 0.1], "velocity": [0.0, 1.0, 0.0], "force": force}

    def values(k):
        return getattr(damped(k, base=base).solve(**start), of)(TIMES)

    d = damped(4.0, base=base).sensitivities([mb.Parameter("k", 4.0, stiffness=PAIR)])
    motion = d.motion("k", **start)
    found = getattr(motion, of)(TIMES)
    expected = central_slope(values, 4.0)
    own = found[:3] if of != "reaction" else found[1:]
    derived = found[3:] if of != "reaction" else found[:1]
    np.testing.assert_allclose(own, values(4.0), atol=1e-11 * np.abs(own).max())
    np.testing.assert_allclose(derived, expected, atol=2e-10 * np.abs(expected).max())


def test_frequency_responses():
    """dH/dk = -H(:, 1 - 2) H(1 - 2, :): the formula of one spring, of forces, reactions and prescribed motions."""
    f, system = np.linspace(0.05, 1.0, 40), damped(4.0)
    d = system.sensitivities([mb.Parameter("k", 4.0, stiffness=PAIR)])
    H = system.frequency_response(f, ["x1", "x2"], ["x1", "x2"]).values
    along = H[:, 0] - H[:, 1]
    expected = -along[:, None] * along[None]
    found = d.frequency_response("k", f, ["x1", "x2"], ["x1", "x2"])
    np.testing.assert_allclose(found.values, expected, rtol=1e-10, atol=1e-12 * np.abs(expected).max())
    for quantity, inputs, outputs in (("transmissibility", "base", "x2"), ("reaction", "x1", "base"), ("accelerance", "x1", "x2")):
        difference = central_slope(lambda k, q=quantity, i=inputs, o=outputs: damped(k).frequency_response(f, i, o, q).values, 4.0)
        values = d.frequency_response("k", f, inputs, outputs, quantity=quantity).values
        np.testing.assert_allclose(values, difference, atol=1e-8 * np.abs(difference).max())


def test_rms_values():
    """White noise on an oscillator: RMS = sqrt(G / (4 c k)), by c, k and m."""
    d = mb.MechanicalSystem([[3.0]], [[0.5]], [[2.0]]).sensitivities()
    rms = (4.0 / (4 * 0.5 * 2.0)) ** 0.5
    expected = {"stiffness[x1, x1]": -rms / 4, "damping[x1, x1]": -rms, "mass[x1, x1]": 0.0}
    for name, value in expected.items():
        assert abs(d.rms(name, {"x1": mb.white_noise(4.0)}).item() - value) < 1e-12


def test_rms_of_reactions_under_a_random_base():
    excitation = {"base": mb.psd([0.1, 5.0], [0.2, 0.2], of="acceleration")}
    d = damped(4.0).sensitivities([mb.Parameter("k", 4.0, stiffness=PAIR)])
    for quantity, names in (("acceleration", ["x1", "x2"]), ("reaction", ["base"])):
        expected = central_slope(
            lambda k, q=quantity, n=names: damped(k).random_response(excitation, n, q).rms, 4.0, 4e-3, (2 / 3, -1 / 12)
        )
        np.testing.assert_allclose(d.rms("k", excitation, names, quantity), expected, rtol=1e-8)


def test_static_forces_and_rest_lengths(model):
    """A rest length moves the equilibrium: after long the derivative of the damped motion is that of K x = f."""
    m = mb.LumpedModel()
    m.mass("a", 1.0)
    m.gravity(-9.81)
    m.spring("ground", "a", 50.0, name="k", rest_length=0.5)
    m.damper("ground", "a", 8.0, name="c")
    d = m.assemble().sensitivities()
    x = 0.5 - 9.81 / 50
    at_rest = {name: d.motion(name, displacement=[x])(20.0)[1] for name in ("k", "k.rest_length", "a")}
    np.testing.assert_allclose([at_rest["k"], at_rest["k.rest_length"], at_rest["a"]], [9.81 / 2500, 1.0, -9.81 / 50], atol=1e-9)


def test_rayleigh_damping_and_speeds():
    """C follows M and K; the speed of a rotor is a parameter of the rotor at this speed: w = sqrt(k + (p W / 2)^2) +- p W / 2."""
    system = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]]).with_rayleigh_damping(0.2, 0.1)
    d = system.sensitivities(["stiffness[x1, x1]"])  # zeta = a / (2 w) + b w / 2
    np.testing.assert_allclose(d.damping_ratios, [[(-0.2 / 8 + 0.1 / 2) * 0.25]], rtol=1e-12)
    disc = mb.MechanicalSystem(np.eye(2), stiffness=4 * np.eye(2), gyroscopic=[[0.0, 1.5], [-1.5, 0.0]])
    d = disc.at_speed(2.0).sensitivities(["speed"])
    half = 0.75 * (0.75 * 2.0) / np.hypot(2.0, 0.75 * 2.0)
    np.testing.assert_allclose(d.natural_frequencies, [[half - 0.75, half + 0.75]], rtol=1e-12)


def test_wrong_arguments():
    import scipy.sparse

    system = mb.MechanicalSystem([[1.0]], stiffness=[[4.0]])
    with pytest.raises(mb.InputError, match="there is no parameter"):
        system.sensitivities(["stiffness[x1, x2]"])
    with pytest.raises(mb.InputError, match="modal damping"):
        system.with_modal_damping(0.05).sensitivities()
    with pytest.raises(mb.InputError, match="sparse"):
        mb.MechanicalSystem(scipy.sparse.eye_array(3), stiffness=scipy.sparse.eye_array(3)).sensitivities()
    with pytest.raises(mb.InputError, match="change near"):
        mb.Parameter.of_function("n", 2.0, lambda p: mb.MechanicalSystem(np.eye(1 + (p > 2.0))))


# Estimated errors against true ones: never less than a tenth of them, and no alarm where the digits are right.

EPS = np.finfo(float).eps


def constrained(seed):
    """Matrices with a row and their changes, random; units of very different sizes in every third."""
    random = np.random.default_rng(seed)
    n = 3 + seed % 2
    units = 10 ** random.uniform(-3, 3, n) if seed % 3 == 0 else np.ones(n)

    def definite():
        root = random.standard_normal((n, n))
        return root @ root.T * np.outer(units, units)

    M, C, K = definite(), 0.1 * definite() * (seed % 4 > 0), 10 ** random.uniform(0, 6) * definite()
    if seed % 5 == 0:
        K = K + random.standard_normal((n, n))
    given = M, C, K, random.standard_normal((1, n))
    slopes = (*random.standard_normal((3, n, n)), random.standard_normal((1, n)) * (seed % 2))
    return given, slopes


@pytest.mark.parametrize("seed", range(10))
def test_simple_eigenvalues(seed):
    """Of constrained systems, differences with 80 digits of the given numbers."""
    given, slopes = constrained(seed)
    system = mb.MechanicalSystem(*given[:3], [mb.Constraint(given[3][0], names="row")])
    parameter = mb.Parameter("p", 1.0, slopes[2], slopes[1], slopes[0], rows={"row": (slopes[3][0], 0.0)})
    d = system.sensitivities([parameter])
    assert EPS <= d.error_estimate < 1e-12
    with mpmath.workdps(80):

        def changed(sign):
            exact = np.vectorize(mpmath.mpf, otypes=[object])
            return [exact(matrix) + sign * STEP * exact(slope) for matrix, slope in zip(given, slopes)]

        places = np.cumsum([0] + [mode.multiplicity for mode in d.modes])
        for place, mode in zip(places, d.modes):
            if mode.multiplicity > 1:
                continue
            u = mode.shapes[:, 0]
            above, below = (precise_mode(changed(sign), mode.eigenvalue, u, int(np.abs(u).argmax()))[0] for sign in (1, -1))
            slope = complex((above - below) / (2 * STEP))
            error = abs(d.eigenvalues[0, place] - slope)
            assert error <= min(10 * d.errors[0, place], 1e-10 * abs(slope))


@pytest.mark.parametrize("gap", [1e-2, 1e-5, 1e-8, 1e-11, 1e-13])
def test_nearly_defective_eigenvalues(gap):
    """[4, 1; gap, 4]: w^2 = 4 +- sqrt(gap), dw/dgap = +- 1 / (4 w sqrt(gap)); or a splitting near the multiple eigenvalue."""
    system = mb.MechanicalSystem(np.eye(2), stiffness=[[4.0, 1.0], [gap, 4.0]])
    d = system.sensitivities([mb.Parameter("gap", gap, stiffness=np.array([[0.0, 0.0], [1.0, 0.0]]))])
    if d.defective:
        assert gap < 1e-10
        assert not d.defective[0].splitting.is_exact
        return
    with mpmath.workdps(60):
        root = mpmath.sqrt(mpmath.mpf(gap))
        for number, sign in enumerate((-1, 1)):
            slope = float(sign / (4 * mpmath.sqrt(4 + sign * root) * root))
            place = int(np.argmin(np.abs(d.modes.eigenvalues - 1j * float(mpmath.sqrt(4 + sign * root)))))
            error = abs(d.natural_frequencies[0, number] - slope)
            assert error <= 10 * d.errors[0, place]
            assert error <= 1e-10 * abs(slope)


@pytest.mark.parametrize("seed", range(6))
def test_errors_of_semisimple_eigenvalues(seed):
    """T diag T^-1 with a unimodular T of whole numbers: the derivatives are those of the diagonal, over 2 s."""
    random = np.random.default_rng(seed)
    T = np.eye(4) + np.tril(random.integers(-3, 4, (4, 4)), -1)
    K, change = (T @ np.diag(values) @ np.round(np.linalg.inv(T)) for values in ([4.0, 4.0, 4.0, 9.0], [1.0, -2.0, 5.0, 3.0]))
    d = mb.MechanicalSystem(np.eye(4), stiffness=K).sensitivities([mb.Parameter("p", 1.0, stiffness=change)])
    found, expected = np.sort(d.natural_frequencies[0]), np.sort([1 / 4, -2 / 4, 5 / 4, 3 / 6])
    assert np.abs(found - expected).max() <= 10 * d.errors.max()
    assert d.error_estimate < 1e-10


@pytest.mark.parametrize("noise", [0.0, 1e-13, 1e-9, 1e-6])
@pytest.mark.parametrize("rate", [0.1, 1.0, 3.0, 10.0])
def test_functions(rate, noise):
    """k = e^(rate p) at p = 1, computed to a relative noise, as by an iteration: w = e^(rate p / 2), dw/dp = rate w / 2."""

    def build(p):
        error = np.sin(1e9 * p) if noise else 0.0  # of another sign at each step
        return mb.MechanicalSystem([[1.0]], stiffness=[[np.exp(rate * p) * (1 + noise * error)]])

    system = mb.MechanicalSystem([[1.0]], stiffness=[[np.exp(rate)]])
    d = system.sensitivities([mb.Parameter.of_function("p", 1.0, build)])
    slope = rate * np.exp(rate / 2) / 2
    error = abs(d.natural_frequencies[0, 0] / slope - 1)
    assert error <= 10 * d.error_estimate
    assert d.error_estimate <= 1e4 * noise + 5e-11 * max(1.0, rate**6)
    assert d.errors.all()


def test_functions_with_rayleigh_damping():
    """C = a M + b K has the errors of both."""
    p = mb.Parameter.of_function("p", 1.0, lambda p: mb.MechanicalSystem([[p]], stiffness=[[np.exp(p)]]))
    damped = p.with_damping(2.0, 3.0)
    np.testing.assert_allclose(damped.error.damping, 2.0 * p.error.mass + 3.0 * p.error.stiffness)
    assert mb.Parameter("q", 1.0).with_damping(1.0, 1.0).error is None


def test_what_moves_nothing():
    """A rest length has no derivative, and does not spoil the estimate of others."""
    model = mb.LumpedModel()
    model.mass("cart", 2.0)
    model.spring("ground", "cart", 8.0, name="mount")
    d = model.assemble().sensitivities()
    assert not d.errors[d.names.index("mount.rest_length")].any()
    assert d.error_estimate < 10 * EPS
