"""Responses as tables of xarray and pandas."""

import sys

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.control.state_space import StateSpace

TIMES = [0.0, 0.5, 2.0]
# 2 q'' + 8 q = 0: q = 0.1 cos 2 t
MOTION = mb.MechanicalSystem([[2.0]], stiffness=[[8.0]], names=["cart"], units={"cart": "rad"}).solve([0.1])
# lambda of a rigid link, 1 m torn apart: -1/2 delta' (by hand)
LINK = mb.solve(
    mb.PolynomialMatrix([[[1, 0, -1], [0, 0, 1], [1, -1, 0]], np.zeros((3, 3)), np.diag([1.0, 1, 0])], ["q1", "q2", "force"]),
    [[1, 0, 0], [0, 0, 0]],
)
LAG = StateSpace([[-2.0]], [[2.0]], [[3.0]], [[1.0]], units={"y1": "V"}).solve(
    input=mb.step([1.0]) + mb.pulse([1.0], start=1.0, duration=1.0)
)


def test_an_array_with_names_units_and_times():
    pytest.importorskip("xarray")
    found = MOTION.to_xarray(TIMES)
    assert found.dims == ("time", "coordinate") and found.shape == (3, 1)
    assert found.coords["time"].values.tolist() == TIMES and found.coords["time"].attrs["units"] == "s"
    assert found.coords["coordinate"].values.tolist() == ["cart"] and found.coords["unit"].values.tolist() == ["rad"]
    assert found.attrs["units"] == "rad"
    assert found.sel(coordinate="cart").values == pytest.approx(0.1 * np.cos(2 * np.array(TIMES)))
    assert found.attrs["jump_0"].tolist() == [0.0] and found.attrs["jump_1"].tolist() == [0.0]


def test_jumps_and_impulses_are_attributes():
    pytest.importorskip("xarray")
    found = LINK.to_xarray(TIMES)
    assert found.attrs["impulse_1"] == pytest.approx([0, 0, -0.5], abs=1e-15)
    assert found.attrs["jump_0"] == pytest.approx([-0.5, 0.5, 0.25], abs=1e-15)
    assert "units" not in found.attrs and "unit" not in found.coords  # they are not known


def test_a_frame_with_names_and_attributes():
    pandas = pytest.importorskip("pandas")
    found = LAG.to_pandas(TIMES)
    assert isinstance(found, pandas.DataFrame)
    assert found.index.name == "time" and found.index.tolist() == TIMES and found.columns.tolist() == ["x1", "y1"]
    assert np.array_equal(found["y1"].to_numpy(), LAG.output(TIMES)[0])
    assert found.attrs["units"] == {"time": "s", "x1": "1", "y1": "V"}
    assert found.attrs["jump_0"] == {"x1": 0.0, "y1": 1.0} and found.attrs["event_times"] == [1.0, 2.0]
    assert LINK.to_pandas(TIMES).attrs["impulse_1"] == pytest.approx({"q1": 0, "q2": 0, "force": -0.5}, abs=1e-15)


@pytest.mark.parametrize("method", ["to_xarray", "to_pandas"])
@pytest.mark.parametrize(
    ("times", "message"), [(1.0, "times: found one number"), ([[1.0]], "times: found a table"), ([-1.0], "found -1 s")]
)
def test_times_are_checked(method, times, message):
    pytest.importorskip(method[3:])
    with pytest.raises(mb.InputError, match=message):
        getattr(MOTION, method)(times)


@pytest.mark.parametrize("package", ["xarray", "pandas"])
def test_a_missing_package_is_named(monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(mb.MbconstrainedError, match=f"to_{package} needs the package {package}, which is not installed"):
        getattr(MOTION, f"to_{package}")(TIMES)
