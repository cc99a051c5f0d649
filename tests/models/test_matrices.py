"""Matrices from files: three formats give the same numbers, and whatever is no matrix is refused as data."""

import io
import os
import pickle
import random
import zipfile

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from mbconstrained.ground.errors import InputError
from mbconstrained.models.matrices import LARGEST_SIDE, read_matrix

MATRIX = np.array([[2.0, -1.0, 0.0], [-1.0, 1e-9, 0.1], [0.0, 1 / 3, 4e20]])
RNG = random.Random(21)


def test_all_formats_give_the_same_numbers_to_the_last_bit(tmp_path):
    np.savez(tmp_path / "a.npz", K=MATRIX, M=np.eye(2))
    np.savez_compressed(tmp_path / "one.npz", K=MATRIX)
    scipy.io.mmwrite(tmp_path / "dense.mtx", MATRIX, precision=17)
    scipy.io.mmwrite(tmp_path / "sparse.mtx", scipy.sparse.coo_array(MATRIX), precision=17)
    np.savetxt(tmp_path / "a.csv", MATRIX, fmt="%.17g", delimiter=", ", header="stiffness in N/m")
    for name, array in (("a.npz", "K"), ("one.npz", None), ("dense.mtx", None), ("sparse.mtx", None), ("a.csv", None)):
        assert read_matrix(tmp_path / name, array).tolist() == MATRIX.tolist(), name


def test_integer_matrices_become_floats(tmp_path):
    np.savez(tmp_path / "a.npz", M=np.array([[1, 2], [3, 4]], dtype=np.int8))
    (tmp_path / "a.mtx").write_text("%%MatrixMarket matrix coordinate integer symmetric\n2 2 2\n1 1 3\n2 1 -1\n")
    assert read_matrix(tmp_path / "a.npz").dtype == float
    assert read_matrix(tmp_path / "a.mtx").tolist() == [[3.0, -1.0], [-1.0, 0.0]]


def npy(header: bytes, data: bytes = b"") -> bytes:
    header = header.ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + data


def npz(**members: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return buffer.getvalue()


class Armed:
    """Unpickling this would create a file."""

    def __reduce__(self):
        return os.mkdir, ("unpickled",)


def pickled() -> bytes:
    buffer = io.BytesIO()
    np.savez(buffer, M=np.array([[Armed()]], dtype=object))
    return buffer.getvalue()


BAD_FILES = [
    ("a.txt", b"1 2", None, r"a\.txt: expected a file that ends in \.npz, \.mtx, \.csv"),
    ("a.npy", b"", None, r"expected a file that ends in"),
    ("a.csv", b"", None, r"a\.csv: the file is empty"),
    ("a.csv", b"# only words\n", None, r"expected shape any x any"),
    ("a.csv", b"1,2\n3\n", None, r"rows have different lengths"),
    ("a.csv", b"1,2\nx,4\n", None, r"a\.csv, line 2: found 'x,4'; expected numbers separated by commas"),
    ("a.csv", b"1;2\n3;4\n", None, r"line 1: .*separated by commas"),
    ("a.csv", b"1,nan\n3,4\n", None, r"the entry at \(0, 1\) is nan"),
    ("a.csv", b"1,1e999\n3,4\n", None, r"the entry at \(0, 1\) is inf"),
    ("a.csv", "1,2\n3,ä".encode("latin-1"), None, r"not a text file in UTF-8"),
    ("a.csv", b"1,2\n3,4\n", "M", r"only \.npz files hold named arrays; leave out the name M"),
    ("a.mtx", RNG.randbytes(1000), None, r"a\.mtx: not a Matrix Market file"),
    ("a.mtx", b"%%MatrixMarket matrix array real general\n2 2\n1\n", None, r"not a Matrix Market file .*[Tt]runcated"),
    ("a.mtx", b"%%MatrixMarket matrix array complex general\n1 1\n1 1\n", None, r"complex numbers found"),
    ("a.mtx", b"%%MatrixMarket matrix coordinate real general\n1000000000 1000000000 0\n", None, rf"at most {LARGEST_SIDE} rows"),
    ("a.npz", RNG.randbytes(1000), None, r"a\.npz: not an \.npz file of numbers"),
    ("a.npz", pickle.dumps({"M": 1}), None, r"not an \.npz file of numbers"),
    ("a.npz", pickled(), None, r"not an \.npz file of numbers .*allow_pickle=False"),
    ("a.npz", npz(M=b"", K=b""), None, r"holds the arrays M, K; give the name of one"),
    ("a.npz", npz(mass=b"", stiffness=b""), "stifness", r'no array stifness in it; did you mean "stiffness"\?'),
    ("a.npz", npz(M=npy(b"{'descr': '<f8', 'fortran_order': False, 'shape': (10, 10000000000000), }")), None, r"not an \.npz file"),
    ("a.npz", npz(M=npy(b"{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }", b"1234")), None, r"not an \.npz file"),
    (
        "a.npz",
        npz(M=npy(b"{'descr': '<c16', 'fortran_order': False, 'shape': (1, 1), }", bytes(16))),
        None,
        r"complex numbers found",
    ),
    (
        "a.npz",
        npz(M=npy(b"{'descr': '<f8', 'fortran_order': False, 'shape': (1,), }", bytes(8))),
        None,
        r"expected shape any x any, found 1",
    ),
]


@pytest.mark.parametrize(("name", "content", "array", "message"), BAD_FILES, ids=[case[3][:50] for case in BAD_FILES])
def test_what_is_no_matrix_is_refused(tmp_path, monkeypatch, name, content, array, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_matrix(tmp_path / name, array)
    assert os.listdir(tmp_path) == [name]


def test_an_array_that_would_unpack_to_too_much_is_not_unpacked(tmp_path):
    np.savez_compressed(tmp_path / "bomb.npz", M=np.zeros((6000, 6000)))
    assert (tmp_path / "bomb.npz").stat().st_size < 10**6
    with pytest.raises(InputError, match=r"the array M has 288,000,128 bytes; at most 200,000,000 are read"):
        read_matrix(tmp_path / "bomb.npz")


def test_missing_file_names_the_nearest(tmp_path):
    (tmp_path / "stiffness.csv").write_text("1")
    with pytest.raises(InputError, match=r'stifness.csv: there is no such file in the folder; did you mean "stiffness.csv"\?'):
        read_matrix(tmp_path / "stifness.csv")


def test_a_folder_is_no_file(tmp_path):
    (tmp_path / "a.csv").mkdir()
    with pytest.raises(InputError, match="expected a file, found another object"):
        read_matrix(tmp_path / "a.csv")


@pytest.mark.parametrize("name", ["a.csv", "a.mtx", "a.npz"])
def test_a_file_that_may_not_be_read_is_wrong_input(tmp_path, monkeypatch, name):
    def refused(*_, **__):
        raise PermissionError(13, "Permission denied")

    (tmp_path / name).write_text("1")
    monkeypatch.setattr("builtins.open", refused)
    monkeypatch.setattr("io.open", refused)
    with pytest.raises(InputError, match=r"a\.\w+: the file cannot be read \(Permission denied\)"):
        read_matrix(tmp_path / name)


def test_a_name_that_no_file_can_have(tmp_path):
    with pytest.raises(InputError, match=r"a{300}\.csv: the file cannot be read \(File name too long\)"):
        read_matrix(tmp_path / ("a" * 300 + ".csv"))
