"""Matrices from files: all formats give the same numbers, sparse stays sparse, and whatever is no matrix is refused as data."""

import io
import os
import pickle
import random
import zipfile
from pathlib import Path

import numpy as np
import pytest
import scipy.io
import scipy.sparse

from mbconstrained.exchange import matrices
from mbconstrained.exchange.matrices import full_matrix, read_matrix
from mbconstrained.ground.checks import optional_package
from mbconstrained.ground.errors import InputError

op4 = optional_package("pyyeti.nastran.op4", "this test")

MATRIX = np.array([[2.0, -1.0, 0.0], [-1.0, 1e-9, 0.1], [0.0, 1 / 3, 4e20]])
RNG = random.Random(21)

#: Sample files in the installed package, under its BSD licence.
OP4 = Path(op4.__file__).parents[1] / "tests" / "nastran_op4_data"


def test_all_formats_give_the_same_numbers_to_the_last_bit(tmp_path):
    sparse = scipy.sparse.coo_array(MATRIX)
    np.save(tmp_path / "a.npy", MATRIX)
    np.savez(tmp_path / "a.npz", K=MATRIX, M=np.eye(2))
    np.savez_compressed(tmp_path / "one.npz", K=MATRIX)
    for kind in ("csc", "csr", "coo", "dia", "bsr"):
        scipy.sparse.save_npz(tmp_path / f"sparse_{kind}.npz", sparse.asformat(kind))
    scipy.io.mmwrite(tmp_path / "dense.mtx", MATRIX, precision=17)
    scipy.io.mmwrite(tmp_path / "sparse.mtx", sparse, precision=17)
    for version in ("4", "5"):
        scipy.io.savemat(tmp_path / f"a{version}.mat", {"K": MATRIX, "S": sparse.tocsc(), "text": "SI"}, format=version)
    for kind, binary in (("dense", False), ("bigmat", True), ("nonbigmat", False)):  # a process reads each, as all below
        op4.write(str(tmp_path / f"{kind}.op4"), {"k": MATRIX, "m": np.eye(2)}, sparse=kind, binary=binary, digits=16)
    np.savetxt(tmp_path / "a.csv", MATRIX, fmt="%.17g", delimiter=", ", header="stiffness in N/m")
    np.savetxt(tmp_path / "a.txt", MATRIX, fmt="%.17g", delimiter="\t")
    np.savetxt(tmp_path / "b.txt", MATRIX, fmt="%.17g", comments="% ", header="a b c")
    (tmp_path / "comma.csv").write_text((tmp_path / "a.txt").read_text().replace(".", ",").replace("\t", ";"))
    arrays = {"a.npz": "K", "a4.mat": "K", "a5.mat": "K"}
    for path in sorted(tmp_path.iterdir()):
        matrix = read_matrix(path, "k" if path.suffix == ".op4" else arrays.get(path.name))
        is_sparse = path.name.startswith(("sparse", "bigmat", "nonbigmat"))
        assert scipy.sparse.issparse(matrix) == is_sparse, path.name
        assert full_matrix(matrix, path.name).tolist() == MATRIX.tolist(), path.name
    assert read_matrix(tmp_path / "a4.mat", "S").toarray().tolist() == MATRIX.tolist()


def test_a_sparse_matrix_of_any_size_stays_sparse(tmp_path):
    stiffness = scipy.sparse.diags_array([-np.ones(199_999), 2 * np.ones(200_000), -np.ones(199_999)], offsets=[-1, 0, 1])
    scipy.sparse.save_npz(tmp_path / "K.npz", stiffness.tocsr())
    matrix = read_matrix(tmp_path / "K.npz")
    assert matrix.shape == (200_000, 200_000) and (matrix != stiffness).nnz == 0
    with pytest.raises(InputError, match=r"K\.npz: the matrix is 200000 x 200000; at most 5000 rows"):
        full_matrix(matrix, "K.npz")


def test_sample_files_of_pyyeti_hold_one_matrix_in_all_forms():
    """Text and binary of both byte orders, dense, sparse with long and short strings of entries, with numbers of 4 and of 8 bytes."""
    expected = scipy.io.loadmat(OP4 / "r_c_rc.mat")["rmat"]
    tolerances = {"double_bigmat_be": 1e-14, "double_dense_le_i64": 1e-14, "double_nonbigmat_ascii_d": 1e-8}
    tolerances |= {"single_bigmat_le": 1e-6, "single_nonbigmat_be_i64": 1e-6, "single_dense_ascii": 1e-6}
    for name, tolerance in tolerances.items():
        matrix = full_matrix(read_matrix(OP4 / f"{name}.op4", "rmats" if name.startswith("single") else "rmat"), name)
        assert matrix == pytest.approx(expected, rel=tolerance, abs=tolerance), name
    with pytest.raises(InputError, match=r"complex numbers found"):
        read_matrix(OP4 / "r_c_rc.op4", "cmat")


@pytest.mark.parametrize("form", ["dense_binary", "bigmat_ascii", "nonbigmat_binary"])
def test_sample_files_of_pyyeti_of_ten_million_rows_are_not_unpacked(form):
    path = OP4 / f"nas_large_dim_{form}.op4"
    assert read_matrix(path, "matd21").shape == (5, 7)
    with pytest.raises(InputError, match=r"the matrix is 19 x 10000001; at most 5000000 rows"):
        read_matrix(path, "matd")


def npy(kind: str, shape: str, data: bytes = b"") -> bytes:
    header = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}".encode().ljust(117) + b"\n"
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + data


def npz(**members: bytes) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return buffer.getvalue()


def mat(**variables) -> bytes:
    buffer = io.BytesIO()
    scipy.io.savemat(buffer, variables)
    return buffer.getvalue()


def sparse_npz(indices=(0, 1), indptr=(0, 1, 2)) -> bytes:
    buffer = io.BytesIO()
    data = {"data": np.ones(2), "indices": np.array(indices), "indptr": np.array(indptr), "shape": np.array([2, 2])}
    np.savez(buffer, format=np.array(b"csc"), **data)
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
    ("a.xls", b"1 2", None, r"a\.xls: expected a file that ends in \.npz, \.npy, \.mtx, \.mat, \.op4, \.csv"),
    ("a.npy", b"", None, r"the file is empty"),
    ("a.npy", RNG.randbytes(300), None, r"a\.npy: not an \.npy file of numbers"),
    ("a.npy", npy("<f8", "(9000000, 9000000)", b"1234"), None, r"not an \.npy file"),
    ("a.npy", pickle.dumps({"M": 1}), None, r"not an \.npy file of numbers .*never loaded"),
    ("a.mat", RNG.randbytes(1000), None, r"a\.mat: not a MATLAB file"),
    ("a.mat", b"MATLAB 7.3 MAT-file" + bytes(200), None, r"a MATLAB file of version 7\.3; write it in .* save\('a\.mat', '-v7'\)"),
    ("a.mat", mat(M=np.eye(2), K=np.eye(2)), None, r"a\.mat: holds the arrays M, K; give the name of one"),
    ("a.mat", mat(M=np.eye(2), K=np.eye(2)), "k", r"no array k in it; .*it holds M, K"),
    ("a.mat", mat(M="text"), None, r"holds the arrays none"),
    ("a.mat", mat(M=np.eye(200))[:-50], None, r"(not a MATLAB file|cannot be read)"),
    ("a.mat", mat(M=scipy.sparse.csc_array(1j * np.eye(2))), None, r"complex numbers found"),
    ("a.mat", mat(M=scipy.sparse.csc_array([[1.0, np.nan]])), None, r"the entry at \(0, 1\) is nan"),
    ("a.op4", RNG.randbytes(1000), None, r"a\.op4: not a Nastran OUTPUT4 file"),
    ("a.op4", b"words and words\n" * 5, None, r"a\.op4: (not a Nastran OUTPUT4 file|holds the arrays none)"),
    ("a.npz", sparse_npz(indices=[0, 7]), None, r"a\.npz: not a"),
    ("a.npz", sparse_npz(indptr=[0, 5, 2]), None, r"a\.npz: not a"),
    ("a.csv", b"", None, r"a\.csv: the file is empty"),
    ("a.csv", b"# only words\n", None, r"a\.csv: found no line of numbers \(the first one is .# only words.\); expected columns"),
    ("a.csv", b"1,2\n3\n", None, r"a\.csv, line 2: it has another number of columns than the lines before it \(1, not 2\)"),
    ("a.csv", b"1,2\nx,4\n", None, r"a\.csv, line 2: found 'x,4'; expected numbers separated by commas"),
    ("a.csv", b"1;2,5\n3.5;4\n", None, r"a\.csv, line 2: found .*decimals have a point or a comma, not both"),
    ("a.csv", b"1,nan\n3,4\n", None, r"a\.csv, line 1: found an entry that is nan or infinite"),
    ("a.csv", b"1,1e999\n3,4\n", None, r"a\.csv, line 1: found an entry that is nan or infinite"),
    ("a.csv", b"1,2\n\n3,\n", None, r"a\.csv, line 3: "),
    ("a.csv", b"1,2\n3,1_0\n", None, r"a\.csv, line 2: found '3,1_0'; expected numbers"),
    ("a.csv", "1,2\n3,ä".encode("latin-1"), None, r"a\.csv, line 2: found"),
    ("a.csv", b"\0\0\0", None, r"not a text file"),
    ("a.csv", b"1,2\n3,4\n", "M", r"only \.npz, \.mat, \.op4, \.xlsx, \.xlsm files hold named arrays; leave out the name M"),
    ("a.mtx", RNG.randbytes(1000), None, r"a\.mtx: not a Matrix Market file"),
    ("a.mtx", b"%%MatrixMarket matrix array real general\n2 2\n1\n", None, r"not a Matrix Market file .*[Tt]runcated"),
    ("a.mtx", b"%%MatrixMarket matrix array complex general\n1 1\n1 1\n", None, r"complex numbers found"),
    ("a.mtx", b"%%MatrixMarket matrix coordinate real general\n" + b"1000000000 " * 2 + b"0\n", None, r"at most 5000000 rows"),
    ("a.npz", RNG.randbytes(1000), None, r"a\.npz: not an \.npz file of numbers"),
    ("a.npz", pickle.dumps({"M": 1}), None, r"not an \.npz file of numbers"),
    ("a.npz", pickled(), None, r"not an \.npz file of numbers .*Python objects, which are never loaded"),
    ("a.npz", npz(M=b"", K=b""), None, r"holds the arrays M, K; give the name of one"),
    ("a.npz", npz(mass=b"", stiffness=b""), "stifness", r'no array stifness in it; did you mean "stiffness"\?'),
    ("a.npz", npz(M=npy("<f8", "(10, 10000000000000)")), None, r"not an \.npz file"),
    ("a.npz", npz(M=npy("<f8", "(2, 2)", b"1234")), None, r"not an \.npz file"),
    ("a.npz", npz(M=npy("<c16", "(1, 1)", bytes(16))), None, r"complex numbers found"),
    ("a.npz", npz(M=npy("<f8", "(1, 1, 1)", bytes(8))), None, r"expected shape any x any, found 1 x 1 x 1"),
]


@pytest.mark.parametrize(("name", "content", "array", "message"), BAD_FILES, ids=[case[3][:50] for case in BAD_FILES])
def test_what_is_no_matrix_is_refused(tmp_path, monkeypatch, name, content, array, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        read_matrix(tmp_path / name, array)
    assert os.listdir(tmp_path) == [name]


def test_an_array_that_would_unpack_to_too_much_is_not_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr(matrices, "LARGEST_FILE", 10**6)
    np.savez_compressed(tmp_path / "bomb.npz", M=np.zeros((600, 600)))
    assert (tmp_path / "bomb.npz").stat().st_size < 10**4
    with pytest.raises(InputError, match=r"the array M has 2,880,128 bytes; at most 1,000,000 are read"):
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


def test_reading_op4_does_not_change_how_numpy_prints():
    """pyyeti sets NumPy's legacy mode of 1.13 when it is imported."""
    assert repr(np.array([0.0, 6.0])) == "array([0., 6.])"


def test_matrices_of_universal_files_are_refused_with_other_formats(tmp_path):
    (tmp_path / "model.uff").write_text("    -1\n   252\n    -1\n")
    with pytest.raises(InputError, match=r"data set 252.*write them as \.op4, \.mat or \.mtx"):
        read_matrix(tmp_path / "model.uff")
