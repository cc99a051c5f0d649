"""The energy of switched motions: strain in what acts, none in what does not, and a sum that only friction and impacts reduce."""

import numpy as np
import pytest

import mbconstrained as mb


def test_springs_that_do_not_act_have_no_strain_energy_and_others_that_of_their_stretch():
    model = mb.LumpedModel()
    model.mass("a", 2.0), model.mass("b", 1.0), model.gravity(-3.0)
    model.backlash("a", "b", gap=0.04, stiffness=300.0)
    x = model.assemble().solve(velocity={"a": 0.5}, end=2.0)
    times = np.linspace(0.0, 2.0, 401)
    stretch = np.maximum(np.abs(x(times)[1] - x(times)[0]) - 0.02, 0.0)
    energy = x.energy(times)
    assert np.allclose(energy.strain, 150.0 * stretch**2, atol=1e-13) and energy.strain.max() > 1e-3
    assert (energy.strain[stretch == 0.0] == pytest.approx(0.0, abs=1e-15)) and (stretch == 0.0).any()
    assert np.allclose(energy.static, 3.0 * np.array([2.0, 1.0]) @ x(times), rtol=1e-12, atol=1e-13)
    assert np.allclose(energy.total, energy.total[0], rtol=1e-12)


def test_the_energy_at_events_is_that_of_the_motion_on_both_sides():
    model = mb.LumpedModel()
    model.mass("ball", 1.0), model.gravity(-9.81), model.contact("ground", "ball", restitution=0.8)
    x = model.assemble().solve({"ball": 1.0}, end=2.0)
    for event in x.events:
        before, after = x.energy(np.array([np.nextafter(event.time, 0.0), event.time])).total
        assert (before, after) == pytest.approx((event.energy_before, event.energy_after), rel=1e-12)
        assert before - after == pytest.approx(event.energy_lost, rel=1e-9)
        assert event.energy_lost == pytest.approx((1 - 0.8**2) * event.energy_before, rel=1e-9)
