"""Damaged files, some of which crash or hang the readers of SciPy and pyYeti: an InputError each, or a right answer."""

from pathlib import Path

import numpy as np
import pytest
import scipy.io

import mbconstrained as mb
from mbconstrained.exchange import matrices
from mbconstrained.exchange.matrices import read_matrix
from mbconstrained.exchange.samples import read_samples
from mbconstrained.exchange.trajectories import Curves
from mbconstrained.exchange.universal import Geometry, write_functions
from mbconstrained.ground import files

DAMAGED = Path(__file__).with_name("damaged")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("segfault.mtx", "segfault.mtx: not a Matrix Market file"),
        ("crash_36.mat", "crash_36.mat: "),
        ("rerr_1_22.wav", "rerr_1_22.wav: found no samples in it"),
        ("hang.op4", "hang.op4: not a Nastran OUTPUT4 file .it cannot be read within"),
    ],
)
def test_damaged_files_are_refused(name, message, monkeypatch):
    monkeypatch.setattr(files, "LONGEST_READING", 5)
    with pytest.raises(mb.InputError, match=message):
        (read_samples if name.endswith("wav") else read_matrix)(DAMAGED / name)


@pytest.mark.parametrize("name", ["K", "S"])
def test_arrays_of_a_damaged_file_are_read_or_refused(name):
    """SciPy's reader crashes now and then on this file."""
    try:
        matrix = read_matrix(DAMAGED / "crash_36.mat", name)
    except mb.InputError as problem:
        assert "crash_36.mat: not a MATLAB file of numbers" in str(problem)
    else:
        assert np.isfinite(matrix.data if hasattr(matrix, "tocsc") else matrix).all()


def test_the_side_of_a_dense_matrix_is_limited(tmp_path):
    """Sparse files have at most LARGEST_FILE bytes, and their matrices as many entries; a dense one is limited as an array is."""
    side = matrices.LARGEST_SIDE + 1
    column = np.zeros((side, 1))
    scipy.io.mmwrite(tmp_path / "dense.mtx", column)
    with pytest.raises(mb.InputError, match=f"dense.mtx: the matrix is {side} x 1; at most 5000 rows and columns are read"):
        read_matrix(tmp_path / "dense.mtx")
    scipy.io.mmwrite(tmp_path / "sparse.mtx", scipy.sparse.coo_array(column))
    assert read_matrix(tmp_path / "sparse.mtx").shape == (side, 1)


def test_a_function_that_states_billions_of_values_is_refused(tmp_path):
    """pyuff makes as many abscissas as data set 58 states, 16 GB of them, before it looks for values."""
    pytest.importorskip("pyuff")
    path = tmp_path / "large.uff"
    times = np.linspace(0.0, 1.0, 5)
    write_functions(path, times, [Curves("displacement", ("x",), ("x",), ("m",), times[None])], Geometry(), "t", binary=False)
    text = path.read_text()
    ordinates = next(line for line in text.splitlines() if line.split()[:2] == ["4", "5"])
    path.write_text(text.replace(ordinates, f"{4:10}{2_000_000_000:10}{1:10}" + ordinates[30:]))
    with pytest.raises(mb.InputError, match="large.uff: (not a universal file|the function)"):
        read_samples(path)


@pytest.mark.long
@pytest.mark.parametrize("suffix", [".mtx", ".mat"])
def test_mutated_files_are_read_or_refused(tmp_path, suffix):
    rng = np.random.default_rng(5)
    path = tmp_path / f"m{suffix}"
    if suffix == ".mtx":
        scipy.io.mmwrite(path, scipy.sparse.coo_array(rng.random((4, 4))))
    else:
        scipy.io.savemat(path, {"K": rng.random((4, 4))})
    whole = path.read_bytes()
    for _ in range(20):
        data = bytearray(whole)
        for place in rng.integers(len(data), size=int(rng.integers(1, 4))):
            data[place] = int(rng.integers(256))
        path.write_bytes(bytes(data))
        try:
            assert np.isfinite(matrices.full_matrix(read_matrix(path), "m")).all()
        except mb.InputError:
            continue
