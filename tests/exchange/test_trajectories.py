"""Results in the files of other programs: what is written is read again to the last bit."""

import sys

import numpy as np
import pytest
import pyuff
import scipy.io
import xarray

import mbconstrained as mb
from mbconstrained.ground.errors import InputError, MissingPackage
from tests.scene.scenes import MATRICES, OSCILLATOR, scene_of

TIMES = np.linspace(0, 2, 23)


@pytest.fixture(scope="module")
def motion():
    """Two coordinates of different units with a tie whose start is inconsistent, and a pulse: jumps, impulses and events."""
    tie = mb.Constraint([1.0, -0.5], names="tie")
    names, units = ["cart", "Größe; 2"], {"Größe; 2": "rad"}
    system = mb.MechanicalSystem(np.diag([2.0, 1.0]), stiffness=[[5, -2], [-2, 4]], constraints=[tie], names=names, units=units)
    return system.solve([0.1, 0.0], force=mb.pulse([1.0, 0.0], start=0.5, duration=1 / 3) + mb.impulse([1.0, 0.0]).delayed(0.75))


KINDS = ("displacement", "velocity", "acceleration", "reaction")


def values_of(motion) -> dict[str, np.ndarray]:
    return {kind: getattr(motion, kind)(TIMES) for kind in KINDS}


@pytest.mark.parametrize("excel", [False, True])
def test_csv_comes_back(tmp_path, motion, excel):
    path = motion.write(tmp_path / "deep" / "run.csv", TIMES, KINDS, excel=excel)
    heads = ["cart displacement (m)", "Größe; 2 angle (rad)", "cart velocity (m/s)", "tie reaction (N)"]
    expected = values_of(motion)
    rows = [expected["displacement"][0], expected["displacement"][1], expected["velocity"][0], expected["reaction"][0]]
    for head, row in zip(heads, rows):
        record = mb.read_record(path, column=head)
        assert record.times.tolist() == TIMES.tolist() and record.values.tolist() == row.tolist(), head
    text = path.read_bytes()
    assert text.startswith("\ufefftime (s);".encode() if excel else b"time (s),") and (b"0,1" in text) == excel


def test_arrays_come_back(tmp_path, motion):
    with np.load(motion.write(tmp_path / "run.npz", TIMES, KINDS), allow_pickle=False) as arrays:
        found = dict(arrays)
    matlab = scipy.io.loadmat(motion.write(tmp_path / "run.mat", TIMES, KINDS))
    for kind, values in values_of(motion).items():
        assert np.array_equal(found[kind], values) and np.array_equal(matlab[kind], values)
    assert found["displacement_units"].tolist() == ["m", "rad"] and found["reaction_names"].tolist() == ["tie"]
    assert [str(cell[0]) for cell in matlab["displacement_names"].ravel()] == ["cart", "Größe; 2"]
    assert np.array_equal(found["jump"], motion.jump) and np.array_equal(matlab["jump"], motion.jump)
    assert found["event_times"].tolist() == [event.time for event in motion.events] == [0.75]
    assert np.array_equal(found["event_jumps"][0], motion.events[0].jump)


@pytest.mark.parametrize("ending", ["nc", "zarr"])
def test_xarray_reads_them(tmp_path, motion, ending):
    for kinds in (KINDS[:1], KINDS):  # the second replaces the first
        path = motion.write(tmp_path / f"run.{ending}", TIMES, kinds)
    with xarray.open_dataset(path, engine="scipy" if ending == "nc" else "zarr") as data:
        for kind, values in values_of(motion).items():
            assert np.array_equal(data[kind].values, values.T)
        assert data["velocity_unit"].values.tolist() == ["m/s", "rad/s"]
        assert data["velocity"].sel(velocity_name="cart").dims == ("time",)
        assert np.array_equal(data["jump"].values, motion.jump) and data["time"].attrs["units"] == "s"
    assert [place.name for place in tmp_path.iterdir()] == [path.name]


def test_universal_files_keep_every_bit(tmp_path, motion):
    geometry = mb.Geometry({"cart": (1, "X"), "Größe; 2": (1, "RZ")}, points={1: (0, 0, 0)})
    path = motion.write(tmp_path / "run.uff", TIMES, KINDS, geometry=geometry)
    expected = [row for values in values_of(motion).values() for row in values]
    functions = pyuff.UFF(str(path)).read_sets()[3:]
    assert len(functions) == len(expected) == 7
    for function, row in zip(functions, expected):
        assert np.array_equal(function["data"], row) and np.array_equal(function["x"], TIMES)
    assert mb.read_record(path, column="cart displacement").values.tolist() == expected[0].tolist()
    text = motion.write(tmp_path / "text.uff", TIMES, binary=False)
    assert mb.read_record(text, column=1).values == pytest.approx(expected[0], rel=1e-11, abs=1e-300)


@pytest.mark.parametrize(
    ("name", "arguments", "message"),
    [
        ("a.xls", {}, r"a\.xls: expected a file that ends in \.csv, \.npz, \.mat, \.nc, \.zarr, \.uff"),
        ("a.npz", {"excel": True}, r"a\.npz: excel is an option of \.csv files"),
        ("a.csv", {"binary": False}, r"a\.csv: geometry and binary are options of universal files"),
        ("a.csv", {"kinds": ["velocty"]}, r"kinds: found 'velocty'; did you mean \"velocity\"\?; expected some of displacement"),
        ("a.csv", {"times": 1.0}, r"times: found one number; expected a list of numbers"),
        ("a.csv", {"times": [-1.0]}, r"time: found -1 s"),
        ("a.uff", {"times": [1.0]}, r"times: found one; a function of a universal file needs at least two"),
    ],
)
def test_mistakes_write_nothing(tmp_path, motion, name, arguments, message):
    with pytest.raises(InputError, match=message):
        motion.write(tmp_path / name, **{"times": TIMES, **arguments})
    assert not list(tmp_path.iterdir())


def test_a_folder_that_is_no_store_is_not_replaced(tmp_path, motion):
    (tmp_path / "run.zarr").mkdir()
    (tmp_path / "run.zarr" / "thesis.txt").write_text("only copy")
    with pytest.raises(IsADirectoryError):
        motion.write(tmp_path / "run.zarr", TIMES)
    assert (tmp_path / "run.zarr" / "thesis.txt").read_text() == "only copy"


@pytest.mark.parametrize(("package", "file"), [("pyuff", "a.uff"), ("xarray", "a.nc"), ("zarr", "a.zarr"), ("pyyeti", "")])
def test_a_missing_package_is_named_with_its_extra(tmp_path, motion, monkeypatch, package, file):
    for name in [name for name in sys.modules if name.startswith(f"{package}.")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, package, None)
    (tmp_path / "m.op4").write_text("1")
    with pytest.raises(MissingPackage, match=rf"needs the package {package}.*pip install '\.\[exchange\]'"):
        motion.write(tmp_path / file, TIMES) if file else mb.read_matrix(tmp_path / "m.op4")


def test_modes_are_written(tmp_path):
    system = mb.MechanicalSystem(
        np.diag([2.0, 1.0, 1.0]), [[0.2, 0, 0], [0, 0, 0], [0, 0, 0]], [[5, -2, 0], [-2, 4, -2], [0, -2, 2]]
    )
    modes = system.modes()
    with np.load(modes.write(tmp_path / "modes.npz"), allow_pickle=False) as arrays:
        assert np.array_equal(arrays["shapes"], modes.shapes) and np.array_equal(arrays["eigenvalues"], modes.eigenvalues)
    assert np.array_equal(scipy.io.loadmat(modes.write(tmp_path / "modes.mat"))["damping_ratios"][0], modes.damping_ratios)
    datasets = pyuff.UFF(str(modes.write(tmp_path / "modes.uff"))).read_sets()
    assert [dataset["type"] for dataset in datasets] == [151, 164, 55, 55, 55]
    for dataset, mode in zip(datasets[2:], modes):
        assert complex(dataset["id4"].split()[1]) == mode.eigenvalue
        assert dataset["r1"] == pytest.approx(mode.shapes[:, 0], rel=1e-5, abs=1e-12)
    with pytest.raises(InputError, match=r"modes\.csv: expected a file that ends in \.npz, \.mat, \.uff"):
        modes.write(tmp_path / "modes.csv")


def test_a_scene_writes_the_formats_that_it_requests(tmp_path):
    text = OSCILLATOR + '[output]\nplots = ["velocity"]\npage = false\nformats = ["excel", "mat", "netcdf", "zarr", "uff"]\n'
    result = scene_of(tmp_path, text).run(tmp_path / "out")
    names = ["scene.csv", "scene.excel.csv", "scene.mat", "scene.nc", "scene.npz", "scene.uff", "scene.zarr"]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == names
    assert {path.name for path in result.files} == set(names)
    expected = result.curves("velocity").values
    assert np.array_equal(scipy.io.loadmat(tmp_path / "out" / "scene.mat")["velocity"], expected)
    with xarray.open_dataset(tmp_path / "out" / "scene.zarr", engine="zarr") as data:
        assert np.array_equal(data["velocity"].values, expected.T) and data["finite_J"].shape == (2, 2)
    for name in ("scene.csv", "scene.excel.csv", "scene.uff"):
        column = "cart velocity" if name != "scene.uff" else 2
        assert mb.read_record(tmp_path / "out" / name, column=column).values.tolist() == expected[0].tolist(), name


def test_of_one_file_that_fails_all_are_left_as_they_were(tmp_path, monkeypatch):
    scene = scene_of(tmp_path, MATRICES + '[output]\nformats = ["zarr", "uff"]\npage = false\n')
    scene.run(tmp_path / "out")
    before = {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")}
    monkeypatch.setitem(sys.modules, "pyuff", None)
    with pytest.raises(MissingPackage):
        scene.run(tmp_path / "out")
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "out").rglob("*")} == before
