"""Shock response spectra against closed forms with 30 digits, other paths through the package, and limits that are known."""

import itertools

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.frequency import shock_spectrum
from mbconstrained.frequency.shock_spectrum import Oscillator, ShockRecord

QUANTITIES = ("absolute acceleration", "relative displacement", "relative velocity")
PARTS = ("primary_positive", "primary_negative", "residual_positive", "residual_negative")


def half_sine(duration):
    wave = mb.harmonic([1.0], angular_frequency=np.pi / duration, phase=-np.pi / 2)
    return wave + wave.delayed(duration)


def exact_half_sine(f, duration, z):
    """The maximax of the absolute acceleration with 30 digits: y'' + 2 z w y' + w^2 y = sin(pi t / T) solved by hand, all extrema by bisection."""
    with mpmath.workdps(30):
        T, z = mpmath.mpf(duration), mpmath.mpf(z)
        w = 2 * mpmath.pi * mpmath.mpf(f)
        wd, P = w * mpmath.sqrt(1 - z * z), mpmath.pi / T
        size = (w * w - P * P) ** 2 + (2 * z * w * P) ** 2
        a, b = (w * w - P * P) / size, -2 * z * w * P / size
        c, e = -b, (-a * P - z * w * b) / wd

        def free(c, e, t):
            decay = mpmath.exp(-z * w * t)
            y = decay * (c * mpmath.cos(wd * t) + e * mpmath.sin(wd * t))
            return y, -z * w * y + wd * decay * (e * mpmath.cos(wd * t) - c * mpmath.sin(wd * t))

        def state(t):
            y, v = free(c, e, t)
            return y + a * mpmath.sin(P * t) + b * mpmath.cos(P * t), v + P * (a * mpmath.cos(P * t) - b * mpmath.sin(P * t))

        def peak(state, load, end):
            def slope(t):
                y, v = state(t)
                return w * w * v + 2 * z * w * (load(t) - 2 * z * w * v - w * w * y)

            count = 400
            times, best = [end * k / count for k in range(count + 1)], mpmath.mpf(0)
            for low, high in itertools.pairwise(times):
                if slope(low) * slope(high) < 0:
                    for _ in range(70):
                        middle = (low + high) / 2
                        low, high = (middle, high) if slope(low) * slope(middle) > 0 else (low, middle)
                y, v = state(low)
                best = max(best, abs(w * w * y + 2 * z * w * v))
            return best

        y, v = state(T)
        after = lambda t: free(y, (v + z * w * y) / wd, t)  # noqa: E731
        return float(max(peak(state, lambda t: mpmath.sin(P * t), T), peak(after, lambda t: 0, 2 * mpmath.pi / wd)))


@pytest.mark.parametrize("f", [10.0, 102.95755673125127, 526.646239348428])
def test_half_sine(f):
    """11 ms, Q = 10, as in the test standards: to rounding errors. The largest peak without damping is in the docstring."""
    spectrum = mb.shock_response_spectrum(half_sine(0.011), [f], quality_factor=10.0)
    assert np.isclose(spectrum.maximax[0], exact_half_sine(f, 0.011, 0.05), rtol=1e-13)


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize(
    "damping_ratio", [0.0, 0.05, 1.0, 50.0, *(pytest.param(z, marks=pytest.mark.long) for z in (1e-8, 0.999, 1.001))]
)
def test_records_by_recursion_and_by_closed_form(quantity, damping_ratio):
    """The digital filters with interior extrema, and the package's solution of the same polygon, are two algorithms."""
    times, values = np.array([0.0, 0.1, 0.25, 0.3, 0.7]), np.array([[0.0, 1.0, -0.5, 2.0, 0.0]])
    record = mb.sampled(times, values)
    f = [0.01, 0.3, 100.0]
    one = mb.shock_response_spectrum(record, f, damping_ratio, quantity)
    other = mb.shock_response_spectrum(record + mb.sampled(times, 0 * values), f, damping_ratio, quantity)
    for part in PARTS:
        assert (np.abs(getattr(one, part) - getattr(other, part)) <= 2e-12 * other.maximax).all()
    assert (one.maximax == np.maximum(one.positive, one.negative)).all()
    assert (one.maximax == np.maximum(one.primary, one.residual)).all()


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=12), st.floats(-2, 2), st.floats(-3, 1))
@settings(max_examples=30)
def test_no_sample_is_above_the_extrema(values, log_frequency, log_damping):
    """Whatever the record, frequency and damping: 2,000 samples of each interval stay within the extrema, and one comes near."""
    values = np.array(values)
    times = np.cumsum(np.linspace(0.2, 1.0, len(values)))
    o = Oscillator(2 * np.pi * 10**log_frequency, 10**log_damping)
    output = (o.w**2, 2 * o.zeta * o.w)
    record = ShockRecord(times, values)
    high, low, *_ = o.peaks(record, output)
    y, v = o.states(record)
    slopes, h = np.diff(values) / np.diff(times), np.diff(times)
    tau = np.linspace(0, 1, 2001) * h[:, None]
    position, rate = o.inside(*(one[:, None] for one in (y[:-1], v[:-1], values[:-1], slopes)), tau)
    inside = output[0] * position + output[1] * rate
    size = np.abs(inside).max()
    assert high >= inside.max() - 1e-9 * size
    assert low <= inside.min() + 1e-9 * size
    assert high <= max(inside.max(), 0) + 1e-3 * size
    assert low >= min(inside.min(), 0) - 1e-3 * size


@pytest.mark.parametrize("damping_ratio", [0.0, 0.05, 0.34, 0.36, 0.999, 1.0, 1 + 1e-10, 1.5, 50.0])
def test_steps_of_many_radians(damping_ratio):
    """The exponentials of (y, u, a, a') with 60 digits, from fractions of a radian to 1e4."""
    oscillator = Oscillator(300.0, damping_ratio)
    h = np.array([1e-3, 0.03, 0.0657, 0.0734, 0.34, 1.4, 40.0])
    units = 300.0 ** np.arange(4)
    for own, step in zip(oscillator.steps(h), h):
        with mpmath.workdps(60):
            l1, l2 = map(mpmath.mpmathify, oscillator.roots)
            J = mpmath.matrix([[l2, 1, 0, 0], [0, l1, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
            exact = np.array(mpmath.expm(J * mpmath.mpf(step)).tolist()).astype(complex)
        error = np.abs(own - exact) * units[:, None] / units
        assert (error[:2].max(axis=1) <= 1e-13 * (1 + 300.0 * step) * np.abs(exact * units[:, None] / units)[:2].max(axis=1)).all()


@pytest.mark.parametrize("damping_ratio", [0.0, 0.05, 0.34, 0.5, 1.0, 5.0])
def test_long_intervals_are_searched_at_their_ends(damping_ratio):
    """A record with a thousand radians between samples has the peaks of the same polygon with samples at every tenth of a radian."""
    times, values = np.array([0.0, 1.0, 1.7, 3.0]), np.array([0.0, 1.0, -0.5, 0.3])
    fine = np.union1d(times, np.linspace(0.0, 3.0, 30001))
    for quantity in QUANTITIES:
        one = mb.shock_response_spectrum(mb.sampled(times, values[None]), [160.0], damping_ratio, quantity)
        other = mb.shock_response_spectrum(mb.sampled(fine, np.interp(fine, times, values)[None]), [160.0], damping_ratio, quantity)
        for part in PARTS:
            assert np.isclose(getattr(one, part), getattr(other, part), rtol=1e-9, atol=1e-10 * other.maximax[0])


def test_limits():
    """A stiff oscillator follows the base, undamped too, a soft one stays; an uneven record is that polygon; Q = 1 / (2 zeta)."""
    times, values = np.array([0.0, 0.3, 0.35, 1.0]), np.array([[0.0, 1.0, -2.0, 0.0]])
    record = mb.sampled(times, values)
    for damping_ratio in (0.0, 0.05):
        assert np.allclose(mb.shock_response_spectrum(record, [1e7, 1e12], damping_ratio).maximax, 2.0, rtol=1e-6)
    soft = mb.shock_response_spectrum(record, [1e-4], 0.05, "relative displacement")
    t = np.linspace(0, 1, 20001)
    velocity = np.cumsum(np.interp(t, times, values[0])) * t[1]
    assert np.isclose(soft.primary[0], np.abs(np.cumsum(velocity) * t[1]).max(), rtol=1e-3)  # the base moves below the mass at rest
    fine = np.union1d(times, np.linspace(0, 1, 41))
    divided = mb.shock_response_spectrum(mb.sampled(fine, np.interp(fine, times, values[0])), [2.0, 7.0])
    assert np.allclose(divided.maximax, mb.shock_response_spectrum(record, [2.0, 7.0]).maximax, rtol=1e-12)
    quality = mb.shock_response_spectrum(record, [2.0], quality_factor=10.0)
    assert quality.maximax == mb.shock_response_spectrum(record, [2.0], 0.05).maximax


def test_interpolation_of_records_is_reported():
    """A band-limited reading of a coarse sine has its peak; both readings say which they are."""
    times = np.arange(64) * 0.01
    values = np.sin(2 * np.pi * 20.0 * times) * np.hanning(64)
    linear = mb.shock_response_spectrum(mb.sampled(times, values), [20.0])
    smooth = mb.shock_response_spectrum(mb.sampled(times, values), [20.0], interpolation="band-limited")
    fine = np.arange(64 * 16) * 0.01 / 16
    truth = mb.shock_response_spectrum(
        mb.sampled(fine, np.sin(2 * np.pi * 20.0 * fine) * np.interp(fine, times, np.hanning(64))), [20.0]
    )
    assert "linear" in linear.notices[0].text
    assert "band-limited" in smooth.notices[0].text
    assert abs(smooth.maximax - truth.maximax)[0] < 0.2 * abs(linear.maximax - truth.maximax)[0]


def test_table_of_xarray():
    """All five spectra over the frequency."""
    pytest.importorskip("xarray")
    spectrum = mb.shock_response_spectrum(half_sine(0.011), [10.0, 100.0])
    table = spectrum.to_xarray()
    assert (table.sel(part="residual").values == spectrum.residual).all()
    assert table.attrs == {"units": "m/s^2", "damping_ratio": 0.05}


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((mb.step([1.0]), [1.0]), "does not end"),
        ((mb.pulse([1.0, 2.0], duration=1.0), [1.0]), "one row"),
        ((mb.pulse([1.0], duration=1.0), [0.0]), "positive"),
        ((mb.pulse([1.0], duration=1.0), [np.nan]), "finite"),
        ((mb.pulse([1.0], duration=1.0), [1.0], -0.1), "at least 0"),
        ((mb.pulse([1.0], duration=1.0), [1.0], 0.1, "accel"), "expected one of"),
        (([0.0, 1.0], [1.0]), "mb.sampled"),
    ],
)
def test_bad_input(arguments, message):
    """Each mistake has a message with what to do."""
    with pytest.raises(mb.InputError, match=message):
        mb.shock_response_spectrum(*arguments)


@pytest.mark.parametrize("offset", [0.0, 1e-15, -1e-12, 1e-9, -1e-6, 1e-3, 0.004])
@pytest.mark.parametrize("w", [6.56751166056137, 8.815185692875364, 7.338787152316622])
def test_exponentials_next_to_critical_damping(w, offset):
    """SciPy's expm of a triangle whose diagonal differs by one unit in the last place is 4 % off; with 60 digits."""
    oscillator = Oscillator(w, 1.0 + offset)
    for step in (1e-4, 0.05, 0.1077, 0.7763, 1.9):
        with mpmath.workdps(60):
            z = mpmath.mpf(1.0 + offset)
            J = mpmath.matrix([[0, 1, 0, 0], [-(mpmath.mpf(w) ** 2), -2 * z * mpmath.mpf(w), 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
            exact = np.array(mpmath.expm(J * mpmath.mpf(step)).tolist()).astype(float)
        change = np.eye(4, dtype=complex)
        change[1, 0] = -oscillator.roots[1]
        own = (2 * np.eye(4) - change) @ oscillator.steps(np.array([step]))[0] @ change
        units = w ** np.arange(4.0)
        assert np.abs((own - exact) / units[:, None] * units).max() <= 1e-13 * (1 + w * step)


def exact_extrema(t, a, w, z, output):
    """Extrema of c_0 y + c_1 y' of a record with 40 digits: states by exponentials, dense samples, then bisection of the rate."""
    with mpmath.workdps(40):
        w, z, (c0, c1) = mpmath.mpf(w), mpmath.mpf(z), map(mpmath.mpf, output)
        J = mpmath.matrix([[0, 1, 0, 0], [-(w**2), -2 * z * w, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0]])
        state, best = mpmath.matrix([0, 0]), [mpmath.mpf(0), mpmath.mpf(0)]
        for k in range(len(t) - 1):
            h = mpmath.mpf(float(t[k + 1])) - mpmath.mpf(float(t[k]))
            if not h:
                continue
            start = mpmath.matrix([*state[:2], a[k], (mpmath.mpf(float(a[k + 1])) - mpmath.mpf(float(a[k]))) / h])
            count = 20 + int(8 * w * h * (1 + 2 * z))
            step, state, states = mpmath.expm(J * h / count), start, [start]
            for _ in range(count):
                state = step * state
                states.append(state)

            def both(s):
                return c0 * s[0] + c1 * s[1], c0 * s[1] + c1 * (s[2] - 2 * z * w * s[1] - w**2 * s[0])

            for one, other in itertools.pairwise(states):
                for value in (both(one)[0], both(other)[0]):
                    best = [max(best[0], value), max(best[1], -value)]
                reach = abs(both(one)[1]) * h / count  # beyond the values at both ends, as r'' has one sign in so short a step
                highest, lowest = (pick(both(one)[0], both(other)[0]) for pick in (max, min))
                if both(one)[1] * both(other)[1] < 0 and (highest + 2 * reach > best[0] or 2 * reach - lowest > best[1]):
                    size, left = h / count, one
                    for _ in range(25):
                        size = size / 2
                        middle = mpmath.expm(J * size) * left
                        left = middle if both(middle)[1] * both(one)[1] > 0 else left
                    best = [max(best[0], both(left)[0]), max(best[1], -both(left)[0])]
        return tuple(map(float, best))


@pytest.mark.parametrize(
    ("times", "values", "f", "damping_ratio"),
    [
        ([0.0, 1.0, 2.0], [1.0, -6.0, -6.0], 0.01, 0.0),  # -0.013604785 within the first second, from rest and back
        (np.arange(7.0), [1.0, -6.0, -6.0, -2.0, -7.0, -1.0, 2.0], 0.01295, 0.0),
        (np.arange(5.0), [0.16888, -0.93228, 0.8408, -0.68999, -0.16779], 0.0207, 3.0),
    ],
)
def test_a_peak_between_two_samples_of_a_slow_oscillator(times, values, f, damping_ratio):
    """The oscillator starts at rest and turns within one interval: neither end shows it."""
    own = mb.shock_response_spectrum(mb.sampled(times, [values]), [f], damping_ratio, "relative displacement")
    high, low = exact_extrema(times, values, 2 * np.pi * f, damping_ratio, (-1, 0))
    assert np.allclose([own.primary_positive[0], own.primary_negative[0]], [high, low], rtol=1e-11)


@pytest.mark.parametrize("seed", range(16))
def test_peaks_of_records_against_forty_digits(seed):
    """Even and uneven records, with jumps; slow and fast oscillators, damping 0 to 10; the maximum and the minimum each to its own digits."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 9))
    times = np.arange(float(count)) if seed % 2 else np.cumsum(rng.uniform(0.05, 1.0, count))
    if seed % 4 > 1:
        times = np.repeat(times, 2)
    values, f = rng.normal(size=len(times)), 10 ** rng.uniform(-3, 0.3)
    damping_ratio, quantity = rng.choice([0.0, 1e-3, 0.05, 0.3, 0.36, 0.7, 0.999, 1.0, 1.0001, 3.0, 10.0]), QUANTITIES[seed % 3]
    own = mb.shock_response_spectrum(mb.sampled(times, [values]), [f], damping_ratio, quantity)
    w = 2 * np.pi * f
    output = {QUANTITIES[0]: (w**2, 2 * damping_ratio * w), QUANTITIES[1]: (-1, 0), QUANTITIES[2]: (0, -1)}[quantity]
    high, low = exact_extrema(times, values, w, damping_ratio, output)
    for value, exact in ((own.primary_positive[0], high), (own.primary_negative[0], low)):
        assert abs(value - exact) <= 1e-11 * exact + 1e-14 * max(high, low)


@pytest.mark.parametrize("damping_ratio", [0.0, 0.05, 0.7, 1.0, 3.0])
@pytest.mark.parametrize("is_even", [True, False])
def test_many_oscillators_have_the_peaks_of_each(monkeypatch, is_even, damping_ratio):
    """Searched together or in turns, from a fraction of a radian between samples to hundreds of radians."""
    rng = np.random.default_rng(7)
    times = np.arange(200.0) if is_even else np.cumsum(rng.uniform(0.0, 2.0, 200).round(1))
    record, f = mb.sampled(times, rng.normal(size=(1, 200))), np.geomspace(1e-3, 60.0, 40)
    for quantity in QUANTITIES:
        each = [mb.shock_response_spectrum(record, [one], damping_ratio, quantity) for one in f]
        for together in (1, 1 << 17):
            monkeypatch.setattr(shock_spectrum, "ALL_TOGETHER", together)
            whole = mb.shock_response_spectrum(record, f, damping_ratio, quantity)
            for part in PARTS:
                own = np.array([getattr(one, part)[0] for one in each])
                assert (np.abs(getattr(whole, part) - own) <= 1e-13 * whole.maximax).all()
