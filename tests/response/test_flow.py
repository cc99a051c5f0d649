"""Functions of a large linear system: evaluated by powers, by modes or by a series, always the same function."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.response.flow import EARLY
from mbconstrained.response.methods.reduced_solution import FlowFunction

from .plain_models import difference, fitting_start, plain_system

EVEN = np.linspace(0.0, 30.0, 200)
UNEVEN = np.array([0.0, 1e-3, 0.2, 3.0, 17.0, 30.0])


def function() -> FlowFunction:
    """Of a new model each time: nothing is decoupled yet."""
    system = plain_system("chain", static=2, damped=2, damping="some")
    F = np.random.default_rng(1).normal(size=(2, 36))
    return system.solve(*fitting_start(system), mb.step(F[0]) + mb.harmonic(F[1], angular_frequency=0.7)).function


def is_decoupled(found: FlowFunction) -> bool:
    return "decoupled" in vars(found.flow.reduction)


def test_even_times_are_stepped_and_others_are_not():
    stepped, modal = function(), function()
    first = stepped(EVEN)
    assert not is_decoupled(stepped)
    other = modal(EVEN + np.where(np.arange(200) == 100, 1e-3, 0.0))
    assert is_decoupled(modal)
    assert difference(np.delete(first, 100, axis=1), np.delete(other, 100, axis=1)) <= 1e-12


def test_sums_multiples_and_maps():
    found, matrix = function(), np.random.default_rng(2).normal(size=(3, 36))
    values = found(UNEVEN)
    for made, expected in (
        (found.mapped(matrix), matrix @ values),
        (2.5 * found, 2.5 * values),
        (-found, -values),
        (found + found.derivative(), values + found.derivative()(UNEVEN)),
        (found - found.mapped(np.eye(36)), 0 * values),
    ):
        assert np.abs(made(UNEVEN) - expected).max() <= 1e-12 * np.abs(values).max()
    assert isinstance(found.mapped(matrix) * 2.0, FlowFunction)


@pytest.mark.parametrize("part", [0.5, 0.999, 1.001, 2.0])
def test_the_series_of_the_start_meets_the_modes(part):
    found = function()
    time = part * EARLY / found.flow.modal_rate
    assert difference(found(time), found.modal(time)) <= 1e-12


@pytest.mark.parametrize("end", [1e-300, 1e-12, 1e6, 1e12])
def test_steps_of_any_size_are_finite(end):
    found = function()(np.linspace(0.0, end, 100))
    assert np.isfinite(found).all()
