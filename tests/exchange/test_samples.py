"""Records in files: each format gives the numbers that stand in it, and what is wrong is reported with its line."""

import io

import numpy as np
import pytest
import scipy.io
from hypothesis import given, settings
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.exchange.samples import read_samples
from mbconstrained.ground.errors import InputError

G = 9.80665  # m/s^2, standard gravity (CGPM 1901)

PEER_NEW = """PEER NGA STRONG MOTION DATABASE RECORD
Imperial Valley-06, 10/15/1979, El Centro Array #6, 230
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=   7, DT=   .0050 SEC,
   .1000000E-02   -.2000000E-02  .3000000E-02  .4000000E-02  .5000000E-02
  -.6000000E-02   .7000000E-02
"""
PEER_OLD = PEER_NEW.replace("NPTS=   7, DT=   .0050 SEC,", "    7    .0050    NPTS, DT").replace("SERIES", "HISTORY")
PEER_VALUES = G * 1e-3 * np.array([1, -2, 3, 4, 5, -6, 7])

KNET = """Origin Time       2011/03/11 14:46:00
Lat.              38.103
Long.             142.860
Depth. (km)       24
Mag.              9.0
Station Code      MYG004
Station Lat.      38.7292
Station Long.     141.0217
Station Height(m) 40
Record Time       2011/03/11 14:46:36
Sampling Freq(Hz) 100Hz
Duration Time(s)  300
Dir.              N-S
Scale Factor      7845(gal)/8223790
Max. Acc. (gal)   2699.9
Last Correction   2011/03/11 14:46:21
Memo.
   8223790   -8223790        0
    4111895
"""

DYNA = """EVENT_NAME: CENTRAL ITALY
STATION_CODE: AMT
SAMPLING_INTERVAL_S: 0.005000
NDATA: 3
UNITS: cm/s^2
DATE_TIME_FIRST_SAMPLE_YYYYMMDD_HHMMSS: 20160824_013628.000
USER5:
100.0
-200.0
300.5
"""


@pytest.mark.parametrize(
    ("text", "step", "values", "unit"),
    [
        (PEER_NEW, 0.005, PEER_VALUES, "m/s^2"),
        (PEER_OLD, 0.005, PEER_VALUES, "m/s^2"),
        (PEER_NEW.replace("ACCELERATION", "VELOCITY").replace("OF G", "OF CM/S"), 0.005, PEER_VALUES / G / 100, "m/s"),
        (KNET, 0.01, [78.45, -78.45, 0.0, 39.225], "m/s^2"),
        (DYNA, 0.005, [1.0, -2.0, 3.005], "m/s^2"),
    ],
    ids=["PEER", "PEER before NGA", "VT2", "K-NET", "DYNA"],
)
def test_recordings_of_ground_motion_are_in_si(tmp_path, text, step, values, unit):
    (tmp_path / "record.any").write_text(text)
    record = mb.read_record(tmp_path / "record.any")
    assert record.times.tolist() == [step * k for k in range(len(values))]
    assert record.values == pytest.approx(np.array(values), rel=1e-15) and record.unit == unit
    load = mb.read_record(tmp_path / "record.any", factor="-1200 kg") if unit == "m/s^2" else None
    assert load is None or (load.unit == "N" and load.values == pytest.approx(-1200 * np.array(values), rel=1e-15))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (PEER_NEW.replace("  .7000000E-02".strip(), ""), r"the header states 7 samples, the file has 6; it is not complete"),
        (
            PEER_NEW.replace("-.6000000E-02", "-.6x00000E-02"),
            r"a, line 6: found '-\.6x00000E-02   \.7000000E-02'; expected numbers",
        ),
        (PEER_NEW.replace("-.6000000E-02", "nan"), r"a, line 6: found an entry that is nan or infinite"),
        (PEER_NEW.replace("OF G", "OF FURLONG"), r"the header states no known unit"),
        (PEER_NEW.replace(".0050", "0.0"), r"a, line 4: found '0\.0'; expected a positive number"),
        (KNET.replace("7845(gal)/8223790", "none"), r"the header has no readable entry Scale Factor"),
        (KNET.replace("8223790\n", "0\n", 1), r"a, line 14: found '0'; expected a positive number"),
        (DYNA.replace("cm/s^2", "counts"), r"a, line 5: found the unit 'counts'; expected one of cm/s\^2"),
        (DYNA + "400\n", r"the header states 3 samples, the file has 4"),
    ],
)
def test_damaged_recordings_are_refused(tmp_path, text, message):
    (tmp_path / "a").write_text(text)
    with pytest.raises(InputError, match=message):
        mb.read_record(tmp_path / "a")


TIMES, VALUES, OTHER = [0.0, 0.5, 1.25], [1.5, -2.0, 0.001], [7.0, 8.0, 9.0]
TEXTS = {
    "comma": "0,1.5,7\n0.5,-2,8\n1.25,1e-3,9\n",
    "semicolon": "0;1.5;7\n0.5;-2;8\n1.25;1e-3;9\n",
    "decimal comma": "0;1,5;7\n0,5;-2;8\n1,25;1e-3;9\n",
    "tab": "0\t1.5\t7\n0.5\t-2\t8\n1.25\t1e-3\t9\n",
    "tab and decimal comma": "0\t1,5\t7\n0,5\t-2\t8\n1,25\t1e-3\t9\n",
    "blanks": "   0   1.5 7\n 0.5    -2 8\n1.25  1e-3 9\n",
    "blanks and decimal comma": "0 1,5 7\n0,5 -2 8\n1,25 1e-3 9\n",
    "comma and blanks": "0.0 ,  1.5, 7\n0.5 , -2.0, 8\n1.25, 1D-3, 9\n",
    "a separator at the end": "0;1,5;7;\n0,5;-2;8;\n1,25;1e-3;9;\n",
    "quotes": '"0","1.5","7"\n"0.5","-2","8"\n"1.25","1e-3","9"\n',
    "comments": "# one\n% two\n! three\n// four\n\n0,1.5,7\n# five\n0.5,-2,8\n\n1.25,1e-3,9\n\n",
    "Windows lines": "0,1.5,7\r\n0.5,-2,8\r\n1.25,1e-3,9\r\n",
    "rows of separators": "0,1.5,7\n0.5,-2,8\n1.25,1e-3,9\n,,\n,,\n",
}


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_the_separator_and_the_decimal_mark_are_read_from_the_lines(tmp_path, text, encoding):
    (tmp_path / "a.txt").write_bytes(text.encode(encoding))
    record = mb.read_record(tmp_path / "a.txt")
    assert (record.times.tolist(), record.values.tolist(), record.unit) == (TIMES, VALUES, "")
    assert mb.read_record(tmp_path / "a.txt", time=1, column=3).values.tolist() == OTHER


@pytest.mark.parametrize(
    ("header", "column"),
    [
        ("t,force,b", "force"),
        ("# t, force, b", "Force"),
        ("t (s),force (N),b", "force (N)"),
        ("t (s),force (N),b", "force"),
        ("t,force,b\ns,N,mm", "force"),
        ("Logger 7\nserial no., 4711\n3 channels\n\nt,force,b", "force"),
        ('"t (s)","force, left (N)","b"', "force, left"),
    ],
)
def test_columns_have_the_names_of_the_header(tmp_path, header, column):
    (tmp_path / "a.csv").write_text(f"{header}\n{TEXTS['comma']}")
    assert mb.read_record(tmp_path / "a.csv", column=column).values.tolist() == VALUES


def test_older_instruments_write_latin_1(tmp_path):
    (tmp_path / "a.csv").write_bytes("Zeit (s);Größe (m/s²)\n0;1,5\n1;2\n".encode("latin-1"))
    record = mb.read_record(tmp_path / "a.csv", column="größe")
    assert record.values.tolist() == [1.5, 2.0] and record.unit == "m/s^2"


def test_units_of_header_or_argument_become_si(tmp_path):
    (tmp_path / "a.csv").write_text("t (ms),F (kN),s [mm]\n0,1,2\n500,3,4\n")
    record = mb.read_record(tmp_path / "a.csv", column="F")
    assert (record.times.tolist(), record.values.tolist(), record.unit) == ([0, 0.5], [1000, 3000], "N")
    assert mb.read_record(tmp_path / "a.csv", column="s").values == pytest.approx([0.002, 0.004])
    other = mb.read_record(tmp_path / "a.csv", column="F", unit="N", time_unit="s", factor=2, offset="1 N")
    assert (other.times.tolist(), other.values.tolist()) == ([0, 500], [3, 7])
    assert mb.read_record(tmp_path / "a.csv", column="s", factor="2 kN/m").unit == "N"


@pytest.mark.parametrize("ending", ["npy", "npz", "mat", "mtx"])
def test_arrays_are_records(tmp_path, ending):
    table, path = np.column_stack([TIMES, VALUES, OTHER]), tmp_path / f"a.{ending}"
    writers = {
        "npy": lambda: np.save(path, table),
        "npz": lambda: np.savez(path, data=table, other=table[:, 1:]),
        "mat": lambda: scipy.io.savemat(path, {"data": table, "other": table[:, 1:]}),
        "mtx": lambda: scipy.io.mmwrite(path, table),
    }
    writers[ending]()
    name = "data" if ending in ("npz", "mat") else None
    assert mb.read_record(path, array=name, column=3).values.tolist() == OTHER
    if name:
        assert mb.read_record(path, array="other", step=0.5, column=1).values.tolist() == VALUES


@pytest.mark.parametrize("kind", [np.int16, np.int32, np.uint8, np.float32])
def test_wav_has_shares_of_full_scale(tmp_path, kind):
    rng, is_real = np.random.default_rng(1), kind is np.float32
    data = rng.normal(size=(50, 2)).astype(kind) if is_real else rng.integers(*_range(kind), size=(50, 2), dtype=kind)
    scipy.io.wavfile.write(tmp_path / "a.wav", 8000, data)
    record = mb.read_record(tmp_path / "a.wav", column=2, factor="40 N")
    low, high = (0.0, 1.0) if is_real else _range(kind)
    middle, half = (0.0, 1.0) if is_real else ((low + high) / 2, (high - low) / 2)
    assert record.values == pytest.approx(40 * (data[:, 1].astype(float) - middle) / half, rel=1e-15) and record.unit == "N"
    assert record.times.tolist() == (np.arange(50) / 8000).tolist()


def _range(kind) -> tuple[int, int]:
    return np.iinfo(kind).min, np.iinfo(kind).max + 1


WRONG = [
    ("0,1\n1,2\n", {"column": 3}, r"a\.csv: column: found 3; the file has 2 columns"),
    ("0,1\n1,2\n", {"column": "F"}, r'column: found "F", but no header line names its 2 columns; give the number'),
    ("t,force\n0,1\n", {"column": "forse"}, r'there is no column "forse"; did you mean "force"\?; the header has t, force'),
    ("t,F,F\n0,1,2\n", {"column": "F"}, r'the columns 2 and 3 have the name "F"; give the number of one'),
    ("0,1\n1,2\n", {"column": 1}, r"column 1 holds the times; give another one, or step"),
    ("0,1\n1,2\n", {"time": 2}, r"column: give the column of the values, by number or name; the times are in 2"),
    ("0\n1\n", {}, r"found 1 column; expected the times in s in column 1 and the values in column 2, or a step"),
    ("t,F\n", {}, r"a\.csv: found no line of numbers"),
    ("0,x\n1,2\n", {}, r"a\.csv, line 1: found '0,x'; expected numbers"),
    ("t,F\n0,1\n1,\n", {}, r"a\.csv, line 3: it has another number of columns|line 3: found an entry that is nan"),
    ("t,F,G\n0,1,2\n1,,3\n", {}, r"a\.csv, line 3: found an entry that is nan or infinite"),
    ("0;1.5\n1;2,5\n", {}, r"line 2: found '1;2,5'; decimals have a point or a comma, not both in one file"),
    ("0;1.234,5\n1;2.5\n", {}, r"line 2: found '1;2\.5'; decimals have a point or a comma, not both in one file"),
    ("0;1.23,5\n1;2\n", {}, r"a\.csv, line 1: found '0;1\.23,5'; expected numbers"),
    ("0,1\n2,1\n1,1\n", {}, r"a\.csv, line 3: 2 s is followed by 1 s; times must ascend"),
    ("t (ms),F\n0,1\n2,1\n1,1\n", {}, r"a\.csv, line 4: 2 ms is followed by 1 ms; times must ascend"),
    ("0,1\n1,2\n", {"step": 0.1, "time": 1}, r"found step and time; give the step between samples, or the column"),
    ("0,1\n1,2\n", {"step": 0}, r"step: found 0; expected a number greater than zero"),
    ("0,1\n1,2\n", {"header": 9}, r"header: found 9; the file has 2 lines"),
    ("0,1\n1,2\n", {"array": "F"}, r"only files of arrays hold named arrays; leave out array"),
    ("0,1\n1,2\n", {"unit": "parsnip"}, r'unit: found "parsnip", but there is no unit "parsnip"'),
    ("t (s),F\n0,1\n", {"time_unit": "kg"}, r'the unit of the time is "kg"; expected one such as s; give time_unit'),
    ("t,F\n0,1\n", {"factor": "2 kg"}, r'factor: found "2 kg", but the unit of the record is unknown; give unit as well'),
    ("t,F (N)\n0,1\n", {"offset": "2 m"}, r'offset: found "2 m", a length; expected a quantity in N'),
    ("", {}, r"a\.csv: the file is empty"),
    ("\0\0\0\0", {}, r"a\.csv: not a text file"),
]


@pytest.mark.parametrize(("text", "arguments", "message"), WRONG, ids=[case[2][:40] for case in WRONG])
def test_mistakes_are_reported_with_their_place(tmp_path, text, arguments, message):
    (tmp_path / "a.csv").write_text(text)
    with pytest.raises(InputError, match=message):
        mb.read_record(tmp_path / "a.csv", **arguments)


@pytest.mark.parametrize(
    ("name", "content", "arguments", "message"),
    [
        ("a.wav", b"RIFF" + bytes(40), {}, r"a\.wav: not a WAV file of samples"),
        ("a.wav", b"no sound", {}, r"a\.wav: not a WAV file of samples"),
        ("a.wav", b"RIFF\x24\0\0\0WAVEfmt \x10\0\0\0" + bytes(16), {}, r"a\.wav: not a WAV file of samples"),
        ("a.wav", b"x", {"step": 1.0}, r"a\.wav: the file has its own times; leave out step"),
        ("a.npy", b"\x93NUMPY", {}, r"a\.npy: not an \.npy file"),
    ],
)
def test_hostile_files_are_wrong_input(tmp_path, name, content, arguments, message):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError, match=message):
        mb.read_record(tmp_path / name, **arguments)


finite = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e90, max_value=1e90).filter(lambda x: not 0 < abs(x) < 1e-90)


@settings(max_examples=60, deadline=None)
@given(
    rows=st.lists(st.tuples(finite, finite), min_size=1, max_size=8),
    separator=st.sampled_from([",", ";", "\t", " ", ", "]),
    comma=st.booleans(),
    words=st.sampled_from(["", "a b c\n", "# note\n", "time%sforce\n"]),
)
def test_what_is_written_is_read_to_the_last_bit(tmp_path_factory, rows, separator, comma, words):
    """Property: any table of numbers in any of the styles comes back."""
    rows = sorted(rows)
    text = "".join(f"{t!r}{separator}{v!r}\n" for t, v in rows)
    if comma and "," not in separator:
        text = text.replace(".", ",")
    path = tmp_path_factory.getbasetemp() / "property.txt"
    path.write_text((words % separator if "%" in words else words) + text)
    record = read_samples(path)
    assert np.column_stack([record.times, record.values]).tolist() == [list(row) for row in rows]


@settings(max_examples=150, deadline=None)
@given(content=st.one_of(st.binary(max_size=200), st.text('0123456789.,;-+eE \t\n#abNPTS=DT\r"', max_size=120).map(str.encode)))
def test_no_content_causes_another_error(tmp_path_factory, content):
    """Property: any bytes are a record, or wrong input."""
    path = tmp_path_factory.getbasetemp() / "fuzz.txt"
    path.write_bytes(content or b"\n")
    try:
        record = mb.read_record(path)
    except InputError as problem:
        assert path.name in str(problem)
    else:
        assert np.isfinite(record.values).all() and (np.diff(record.times) >= 0).all()


@settings(max_examples=15, deadline=None)  # a process reads each
@given(
    cut=st.integers(0, 300),
    at=st.integers(0, 299),
    byte=st.integers(0, 255),
    ending=st.sampled_from(["npy", "npz", "mat", "mtx", "op4", "wav"]),
)
def test_damaged_binary_files_are_wrong_input(tmp_path_factory, cut, at, byte, ending):
    """Property: a byte replaced, or the end missing."""
    content = bytearray(_whole(ending))
    content[at % len(content)] = byte
    path = tmp_path_factory.getbasetemp() / f"damaged.{ending}"
    path.write_bytes(content[: max(len(content) - cut, 1)])
    try:
        record = mb.read_record(path, **({"step": 1.0, "column": 1} if ending != "wav" else {}))
    except InputError as problem:
        assert path.name in str(problem)
    else:
        assert np.isfinite(record.values).all()


def _whole(ending: str) -> bytes:
    buffer, table = io.BytesIO(), np.arange(6.0).reshape(3, 2)
    if ending == "wav":
        scipy.io.wavfile.write(buffer, 100, np.arange(12, dtype=np.int16))
    elif ending == "op4":
        lines = ["       2       3       2       2K       1P,3E23.16", "       1       1       3"]
        lines += ["".join(f"{x:23.16E}" for x in column) for column in table.T[:1]]
        lines += [
            "       2       1       3",
            "".join(f"{x:23.16E}" for x in table[:, 1]),
            "       3       1       1",
            f"{1.0:23.16E}",
        ]
        buffer.write(("\n".join(lines) + "\n").encode())
    else:
        writers = {
            "npy": np.save,
            "npz": np.savez,
            "mtx": scipy.io.mmwrite,
            "mat": lambda file, M: scipy.io.savemat(file, {"M": M}),
        }
        writers[ending](buffer, table)
    return buffer.getvalue()
