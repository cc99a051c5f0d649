"""Events: forces that start, stop, change or have an impulse after t = 0, against restarts, closed forms and other solvers."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest
import scipy.signal

import mbconstrained as mb

RNG = np.random.default_rng(3)
FREE_BODY = mb.PolynomialMatrix([[[0.0]], [[0.0]], [[1.0]]])
TIMES = np.linspace(0, 10, 10_001)
RECORD = RNG.normal(size=10_001).cumsum() / 10

#: Two unit masses, a spring on the first, a rigid link of given length with its multiplier: index 3.
LINK = mb.PolynomialMatrix([[[1, 0, -1], [0, 0, 1], [1, -1, 0]], [[0] * 3] * 3, [[1, 0, 0], [0, 1, 0], [0, 0, 0]]])


def scalar(*coefficients) -> mb.PolynomialMatrix:
    return mb.PolynomialMatrix([[[float(c)]] for c in coefficients])


def left_limit(x, event) -> np.ndarray:
    """x^(i)(t-), i < q."""
    return np.array([x.derivative(order)(event.time) - jump for order, jump in enumerate(event.jump)])


RESTARTED = {
    "regular": (scalar(4.0, 0.4, 1.0), 1),
    "unstable": (scalar(-1.0, 0.0, 1.0), 1),
    "a node without mass": (mb.PolynomialMatrix([[[4.0, -1], [-1, 1]], np.zeros((2, 2)), np.diag([0.0, 1.0])]), 2),
    "index 3": (LINK, 3),
}


@pytest.mark.parametrize("name", RESTARTED)
def test_a_new_solution_from_the_left_limits_goes_on_alike(name):
    """What comes after an event depends on the values just before it and on the force from then on alone."""
    A, size = RESTARTED[name]
    one, two, three = RNG.normal(size=(3, size))
    late = mb.harmonic(two, angular_frequency=2.0) + mb.impulse(three)
    x = mb.solve(A, RNG.normal(size=(2, size)), mb.ramp(one) + late.delayed(1.5))
    (event,) = x.events
    after = mb.solve(A, left_limit(x, event), mb.ramp(one) + mb.step(1.5 * one) + late)
    scale = np.abs(after([0.0, 0.5, 3.0])).max()
    assert event.time == 1.5
    assert after([0.0, 0.5, 3.0]) == pytest.approx(x([1.5, 2.0, 4.5]), abs=1e-12 * scale)
    assert after.derivative()([0.0, 0.5]) == pytest.approx(x.derivative()([1.5, 2.0]), abs=1e-11 * scale)
    assert event.jump == pytest.approx(after.jump, rel=1e-11, abs=1e-12)
    assert len(event.impulses) == len(after.impulses)
    for found, known in zip(event.impulses, after.impulses):
        assert found == pytest.approx(known, rel=1e-11, abs=1e-12)


def test_kinks_and_jumps_of_the_length_of_a_link():
    """x1 - x2 = f, x1'' + x1 = m, x2'' = -m: 2 x1'' + x1 = f'', so a kink s gives x1' the jump s/2, m = x1'' + x1."""
    f = mb.sampled([0, 1, 2, 2, 3], [[0] * 5, [0] * 5, [0, 0, 2, 5, 5]])
    x = mb.solve(LINK, force=f)
    half = Fraction(1, 2)
    known = {  # jump of f, change of its slope
        1.0: (Fraction(0), Fraction(2)),
        2.0: (Fraction(3), Fraction(-2)),
        3.0: (Fraction(-5), Fraction(0)),
    }
    assert [event.time for event in x.events] == list(known)
    for event in x.events:
        jump, kink = known[event.time]
        # The transform of the jump and of the kink alone: x1 = (jump s + kink)/(2 s^2 + 1) and m = (s^2 + 1) x1.
        assert event.jump[0] == pytest.approx([float(v) for v in (half * jump, -half * jump, half * half * jump)], rel=1e-14, abs=0)
        assert event.jump[1] == pytest.approx([float(v) for v in (half * kink, -half * kink, half * half * kink)], rel=1e-14, abs=0)
        impulses = np.array(event.impulses)
        assert not impulses[:, :2].any()
        assert impulses[:, 2] == pytest.approx(
            [float(v) for v in ([half * kink, half * jump] if jump else [half * kink])], rel=1e-14, abs=0
        )


@pytest.mark.parametrize("end", [1e1, 1e3, 1e6])
def test_a_short_pulse_on_a_free_body_is_remembered_to_the_last_digits(end):
    """x = h (t - 1 - h/2) after a unit pulse of length h at t = 1: no difference of two growing parabolas."""
    h = 2.0**-10
    x = mb.solve(FREE_BODY, force=mb.pulse([1.0], start=1.0, duration=h))
    assert x(end)[0] == pytest.approx(h * (end - 1 - h / 2), rel=1e-14, abs=0)
    assert x.derivative()(end)[0] == pytest.approx(h, rel=1e-14, abs=0)
    assert x.derivative(2)(end)[0] == 0.0


def test_growth_begins_when_the_force_does():
    """x' = x + pulse: nothing before, then (1 - e^-h) e^(t - t0); far growth is told."""
    x = mb.solve(scalar(-1.0, 1.0), force=mb.pulse([1.0], start=2000.0, duration=1.0))
    assert not x([0.0, 1999.0]).any()
    assert x(2030.0)[0] == pytest.approx((1 - np.exp(-1.0)) * np.exp(30.0), rel=1e-13)
    with pytest.raises(mb.Overflow, match="t = 3000 s"):
        x(3000.0)


def test_delayed_resonance():
    """x'' + 9 x = cos 3 (t - 2) from rest: x = d sin(3 d)/6."""
    x = mb.solve(scalar(9.0, 0.0, 1.0), force=mb.harmonic([1.0], angular_frequency=3.0).delayed(2.0))
    d = np.array([0.0, 0.1, 5.0, 100.0])
    assert x(2 + d)[0] == pytest.approx(d * np.sin(3 * d) / 6, rel=1e-11, abs=1e-14)


@pytest.mark.parametrize("coefficients", [(4.0, 0.1, 1.0), (0.0, 0.0, 1.0), (4.0, 0.0, 1.0), (100.0, 20.0, 1.0), (-1.0, 0.0, 1.0)])
def test_ten_thousand_samples_agree_with_lsim(coefficients):
    x = mb.solve(scalar(*coefficients), force=mb.sampled(TIMES, RECORD[None]))
    _, known, _ = scipy.signal.lsim(([1.0], coefficients[::-1]), RECORD, TIMES)
    assert np.abs(x(TIMES)[0] - known).max() <= 1e-11 * np.abs(known).max()


def test_ten_thousand_samples_on_a_free_body_are_exact():
    """Position and velocity by the same recursion in rational numbers."""
    x = mb.solve(FREE_BODY, force=mb.sampled(TIMES, RECORD[None]))
    place = velocity = Fraction(0)
    scale = 10**40  # rationals rounded to forty digits, so that they stay short
    for h, a, b in zip(np.diff([Fraction(t) for t in TIMES]), map(Fraction, RECORD), map(Fraction, RECORD[1:])):
        place += velocity * h + h * h * (2 * a + b) / 6
        velocity += h * (a + b) / 2
        place, velocity = Fraction(round(place * scale), scale), Fraction(round(velocity * scale), scale)
    assert float(Fraction(x(10.0)[0]) / place - 1) == pytest.approx(0, abs=1e-13)
    assert float(Fraction(x.derivative()(10.0)[0]) / velocity - 1) == pytest.approx(0, abs=1e-13)


@pytest.mark.parametrize("rate", [1e-6, 1.0, 1e3, 1e8])
def test_a_record_on_stiff_and_slow_systems(rate):
    """x' + a x = f with forty digits, piece by piece."""
    times, values = TIMES[:200], RECORD[:200]
    x = mb.solve(scalar(rate, 1.0), force=mb.sampled(times, values[None]))
    with mpmath.workdps(40):
        a, states = mpmath.mpf(rate), [mpmath.mpf(0)]
        for t, u, f, g in zip(times, times[1:], values, values[1:]):
            h = mpmath.mpf(u) - mpmath.mpf(t)
            slope, decay = (mpmath.mpf(g) - mpmath.mpf(f)) / h, mpmath.exp(-a * h)
            states.append(decay * states[-1] + f * (1 - decay) / a + slope * (h / a - (1 - decay) / a**2))
        known = np.array([float(state) for state in states])
    assert np.abs(x(times)[0][:-1] - known[:-1]).max() <= 1e-12 * np.abs(known).max()


def test_a_hundred_pulses_of_one_vector_cost_one_channel():
    f = sum(mb.pulse([1.0, 2.0], start=k, duration=0.5) for k in range(100))
    x = mb.solve(mb.PolynomialMatrix([np.diag([4.0, 9.0]), np.zeros((2, 2)), np.eye(2)]), force=f)
    alone = mb.solve(scalar(4.0, 0.0, 1.0), force=mb.step([1.0]))
    t = np.linspace(0, 120, 50)
    known = sum(alone(np.maximum(t - k, 0)) - alone(np.maximum(t - k - 0.5, 0)) for k in range(100))
    assert len(x.function.blocks) <= 2 + 2 + 2  # the force twice, for its first moments and after them, and coupled to each mass
    assert x(t)[0] == pytest.approx(known[0], abs=1e-11)


def test_the_largest_and_smallest_forces_pass():
    for size in (1e300, 1e-300):
        x = mb.solve(LINK, force=mb.sampled([1.0, 2.0], [[0.0] * 2, [0.0] * 2, [size, 2 * size]]))
        assert x.events[0].jump[0, 0] / size == pytest.approx(0.5, rel=1e-13)
        assert x.events[0].impulses[1][2] / size == pytest.approx(0.5, rel=1e-13)


def test_jumps_beyond_float64_are_told():
    with pytest.raises(mb.Overflow, match="after t = 0 grow beyond the range"):
        mb.solve(mb.PolynomialMatrix([[[1e-200]], [[0.0]]]), force=mb.step([1e200]).delayed(1.0))


def test_the_error_estimate_sees_the_events():
    x = mb.solve(LINK, force=mb.sampled(TIMES[:200], np.vstack([RECORD[:200] * 0, RECORD[:200], RECORD[:200]])))
    assert 1e-16 < x.error_estimate(np.linspace(0, 3, 50)) < 1e-9


def test_notices_tell_the_first_events_and_count_the_others():
    x = mb.solve(LINK, force=mb.sampled([0, 1, 2], [[0] * 3, [0] * 3, [0, 0, 2.0]]))
    texts = [notice.text for notice in x.notices if notice.kind in ("jump", "impulse")]
    assert texts[0] == "x1: its velocity jumps at t = 1 s from 0 to 1"
    assert "x3: a Dirac impulse at t = 1 s of size 1" in texts
    many = mb.solve(LINK, force=mb.sampled(TIMES, np.vstack([RECORD * 0, RECORD * 0, RECORD])))
    later = [notice.text for notice in many.notices if notice.kind in ("jump", "impulse") and "t = 0 from" not in notice.text]
    assert len(later) < 12
    count = sum(np.count_nonzero(event.jump) for event in many.events)
    assert any(
        f"after t = 0 there are {count} jumps and " in text and f" at {len(many.events)} times from t = 0.001 s" in text
        for text in later
    )


@pytest.mark.parametrize("delay", [1e-9, 0.125, 1.0, 64.0])
@pytest.mark.parametrize(
    "coefficients", [(4.0, 0.1, 1.0), (0.0, 0.0, 1.0), (1e-6, 1e-4, 1.0), (1e8, 1e8, 1.0), (9.0, 0.0, 1.0), (1.0, 2.0, 1.0)]
)
def test_a_delayed_force_gives_the_delayed_response(coefficients, delay):
    """For long times too, near and in resonance, and where the delay is short relative to everything else.

    Half a unit in the last place of t turns the harmonic by 3 t eps / 2: at t = 1e5 s that is 3e-11.
    """
    A = scalar(*coefficients)
    force = mb.term([1.0], power=1, rate=-0.5, angular_frequency=2.0) + mb.harmonic([2.0], angular_frequency=3.0) + mb.step([1.0])
    x, late = mb.solve(A, force=force), mb.solve(A, force=force.delayed(delay))
    since = np.array([0.0, 0.5, 3.0, 40.0, 1e3, 1e5])
    times = since + delay
    exact = times - delay  # the times that float64 has since the delay
    known = x(exact)
    phase = 3.0 * np.finfo(float).eps * times
    assert (np.abs(late(times) - known) <= (1e-11 + 2 * phase) * np.abs(known).max()).all()
    assert np.abs(late(times[:3]) - known[:, :3]).max() <= 1e-12 * max(np.abs(known[:, :3]).max(), 1e-3 * np.abs(known).max())


def test_kinks_of_a_record_are_one_sentence():
    """A prescribed displacement that is linear between its samples: its slope changes 5 times, its value jumps once, at the end."""
    model = mb.LumpedModel()
    model.node("road")
    model.mass("car", 1.0)
    model.spring("road", "car", 10.0)
    model.prescribe("road", mb.sampled(np.arange(11.0), [np.append(0.0, np.arange(10.0) % 3 + 1)]))
    motion = model.assemble().solve()
    kinds = [notice.kind for notice in motion.notices]
    assert [event.time for event in motion.events] == [3.0, 4.0, 6.0, 7.0, 9.0, 10.0] and len(motion._kinks) == 5
    assert kinds.count("kink") == 1 and all("t = 10 s" in n.text or "t = 0" in n.text for n in motion.notices if n.kind == "jump")
    (kink,) = (notice.text for notice in motion.notices if notice.kind == "kink")
    assert "at 5 times from t = 3 s to t = 9 s" in kink and "velocity of road by 3 m/s" in kink
