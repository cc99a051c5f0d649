"""Columns of numbers as loggers and spreadsheets write them: the numbers of the file, or a refusal that names the line."""

import datetime
import zipfile

import numpy as np
import openpyxl
import pytest

import mbconstrained as mb
from mbconstrained.exchange import columns
from mbconstrained.exchange.samples import read_samples
from mbconstrained.ground.errors import InputError

MARKS = [  # numbers with marks between thousands, and those that may be both: decided by the others of the file
    ("t;F\n0;1.234,5\n1;12.345\n", [1234.5, 12345.0]),
    ("t;F\n0;1,234.5\n1;12,345\n", [1234.5, 12345.0]),
    ('t,F\n0,"1,234.5"\n1,"-12,345,678.25"\n', [1234.5, -12345678.25]),
    ("t;F\n0;1'234.5\n1;2\n", [1234.5, 2.0]),
    ("t;F\n0;1\u202f234,5\n1;2,25\n", [1234.5, 2.25]),
    ("t;F\n0;12.345\n1;1.234.567\n", [12345.0, 1234567.0]),
    ("t;F\n0;1.234\n1;12.345\n", [1.234, 12.345]),  # nothing tells otherwise: a point begins decimals
]


@pytest.mark.parametrize(("text", "values"), MARKS)
def test_marks_between_thousands(tmp_path, text, values):
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    record = read_samples(tmp_path / "a.csv")
    assert record.values.tolist() == values
    assert len(record.notes) == (values[1] != 12.345)
    assert all("in line" in note and "is read as" in note for note in record.notes)


def test_a_decimal_mark_that_the_file_leaves_open_can_be_given(tmp_path):
    (tmp_path / "a.csv").write_text("t;F\n0;1.234\n1;12.345\n")
    assert read_samples(tmp_path / "a.csv", decimal=",").values.tolist() == [1234.0, 12345.0]
    with pytest.raises(InputError, match=r"""decimal: found 'x'; expected "\." or ",\""""):
        read_samples(tmp_path / "a.csv", decimal="x")


@pytest.mark.parametrize(
    "start, end", [("\ufeff", "\r\n"), ("", "\r\n"), ("", "\r"), ("\ufeff", "\n")], ids=["bom-crlf", "crlf", "cr", "bom"]
)
@pytest.mark.parametrize("encoding", ["utf-8", "utf-16-le"])
def test_byte_order_marks_and_line_ends(tmp_path, start, end, encoding):
    lines = ["time [ms];a (m/s^2)", "0,0;1,5", "500,0;-2,5", ""]
    (tmp_path / "a.txt").write_bytes((start + end.join(lines)).encode(encoding))
    record = mb.read_record(tmp_path / "a.txt")
    assert (record.times.tolist(), record.values.tolist(), record.unit, record.name) == ([0, 0.5], [1.5, -2.5], "m/s^2", "a")


def test_dates_and_times_of_day_are_seconds_after_the_first(tmp_path):
    lines = ("31.12.2024;23:59:59,9;1", "01.01.2025;00:00:00,1;2", "01.01.2025;00:00:01,0;4")
    (tmp_path / "a.csv").write_text("\n".join(("Datum;Zeit;a (m/s^2)", *lines)))
    assert mb.read_record(tmp_path / "a.csv").times.tolist() == [0.0, 0.2, 1.1]
    (tmp_path / "b.csv").write_text("time;a\n23:59:59.5;1\n00:00:00.5;2\n")
    with pytest.raises(InputError, match="a time of day that passes midnight needs its date"):
        mb.read_record(tmp_path / "b.csv")
    (tmp_path / "c.csv").write_text("time;a\n01/02/2024 10:00:00;1\n02/03/2024 10:00:00;2\n")
    with pytest.raises(InputError, match="day and month of the dates are ambiguous"):
        mb.read_record(tmp_path / "c.csv")


def test_a_row_of_units_below_the_names(tmp_path):
    (tmp_path / "a.csv").write_text("Time,Force,Status\nms,kN,-\n0,1,OK\n500,2,OK\n")
    record = mb.read_record(tmp_path / "a.csv", column="Force")
    assert (record.times.tolist(), record.values.tolist(), record.unit) == ([0.0, 0.5], [1000.0, 2000.0], "N")
    with pytest.raises(InputError, match="column 3 holds texts such as 'OK'; expected numbers"):
        mb.read_record(tmp_path / "a.csv", column="Status")


def test_lost_and_repeated_samples_are_reported(tmp_path):
    rows = [(k / 100, k % 7) for k in range(100) if k not in (50, 51, 70)]
    (tmp_path / "a.csv").write_text("\n".join(f"{t},{a}" for t, a in [*rows[:20], rows[19], *rows[20:]]))
    gap, repeated = mb.read_record(tmp_path / "a.csv").notices
    assert "line 52: 2 samples missing after 0.49 s, and 1 gap more: 3 in all; steps are 0.01 s elsewhere" in gap.text
    assert "line 21 repeats the time 0.19 s; the record jumps there" in repeated.text


def test_commas_for_columns_and_decimals_at_once_are_refused(tmp_path):
    (tmp_path / "a.csv").write_text("t,a\n0,0,1,5\n0,1,2,5\n")
    with pytest.raises(InputError, match=r"a\.csv, line 2: found 4 numbers under 2 names; commas that separate columns cannot"):
        mb.read_record(tmp_path / "a.csv")
    assert mb.read_record(tmp_path / "a.csv", header=1, column=4).values.tolist() == [5, 5]  # four columns, as stated


@pytest.fixture
def book(tmp_path):
    one = openpyxl.Workbook()
    rows = (("Logger 7",), ("time", "force (kN)"), (datetime.time(9, 0, 0), 1.5), (datetime.time(9, 0, 1, 250000), 2.5))
    for row in rows:
        one.active.append(row)
    one.active.title = "run 1"
    one.save(tmp_path / "a.xlsx")
    return one


def test_a_sheet_is_read(tmp_path, book):
    record = mb.read_record(tmp_path / "a.xlsx")
    assert (record.times.tolist(), record.values.tolist(), record.name) == ([0.0, 1.25], [1500.0, 2500.0], "force")
    other = book.create_sheet("run 2")
    for row in np.arange(6.0).reshape(3, 2):
        other.append(row.tolist())
    book.save(tmp_path / "a.xlsx")
    assert mb.read_record(tmp_path / "a.xlsx", array="run 2").values.tolist() == [1, 3, 5]
    with pytest.raises(InputError, match="holds the sheets run 1, run 2; give the name of one in array"):
        mb.read_record(tmp_path / "a.xlsx")
    with pytest.raises(InputError, match='no sheet run 3 in it; did you mean "run .".*it holds run 1, run 2'):
        mb.read_record(tmp_path / "a.xlsx", array="run 3")


def test_formulas_are_not_evaluated(tmp_path, book):
    book.active.append(["=1+1", 2.0])
    book.save(tmp_path / "a.xlsx")
    with pytest.raises(InputError, match="times of day in some lines and not in others"):  # no stored value
        mb.read_record(tmp_path / "a.xlsx")


def _changed(path, change):
    """The file with another first sheet."""
    with zipfile.ZipFile(path) as source:
        parts = {name: source.read(name) for name in source.namelist()}
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as target:
        for name, content in parts.items():
            target.writestr(name, change(content) if name == "xl/worksheets/sheet1.xml" else content)


ENTITIES = "".join(f'<!ENTITY l{i} "{f"&l{i - 1};" * 10 if i else "lol"}">' for i in range(10))


@pytest.mark.parametrize(
    ("entity", "reference", "message"),
    [
        (ENTITIES, b"&l9;", "not an Excel file of numbers .*(amplification|entit)"),
        ('<!ENTITY x SYSTEM "file:///etc/hostname">', b"&x;", "not an Excel file of numbers .*undefined entity"),
    ],
    ids=["expansion", "external"],
)
def test_entities_are_refused(tmp_path, book, entity, reference, message):
    _changed(
        tmp_path / "a.xlsx",
        lambda xml: f"<!DOCTYPE x [{entity}]>".encode() + xml.replace(b"<v>1.5</v>", b"<v>" + reference + b"</v>"),
    )
    with pytest.raises(InputError, match=message):
        mb.read_record(tmp_path / "a.xlsx")


def test_zip_bombs_and_other_files_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(columns, "LARGEST_FILE", 2**20)
    path = tmp_path / "a.xlsx"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("xl/worksheets/sheet1.xml", bytes(5 * 2**20))
    with pytest.raises(InputError, match="it unpacks to 5,242,880 bytes; at most 4,194,304 are read"):
        mb.read_record(path)
    for content in (b"no zip", b"PK\x03\x04" + bytes(100)):
        path.write_bytes(content)
        with pytest.raises(InputError, match=r"a\.xlsx: not an Excel file of numbers"):
            mb.read_record(path)
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("a.txt", "a")
    with pytest.raises(InputError, match=r"a\.xlsx: not an Excel file of numbers"):
        mb.read_record(path)
    (tmp_path / "a.xls").write_bytes(b"\xd0\xcf\x11\xe0")
    with pytest.raises(InputError, match=r"a\.xls: \.xls files are not read; save it as \.xlsx or \.csv"):
        mb.read_record(tmp_path / "a.xls")


OPEN_COMMAS = 't,x\n0,"1,500"\n1,"2,500"\n'  # as Excel writes 1500, or 1.5 with a decimal comma

HEADS = [  # names with their units as instruments, Excel and ISO 80000-1 write them
    ('"t\n(ms)","x\r\n(mm)"\n', "utf-8"),
    ('Pipe 5" test\nt (ms),x (mm)\n', "utf-8"),
    ("t (ms),Weg… (mm)\n", "cp1252"),
    ("t / ms,x/mm\n", "utf-8"),
    ("t / (ms),x / (mm)\n", "utf-8"),
    ("t,x\n(ms),(mm)\n", "utf-8"),
]


@pytest.mark.parametrize(("head", "encoding"), HEADS)
def test_units_of_names_in_several_writings(tmp_path, head, encoding):
    (tmp_path / "a.csv").write_bytes((head + "0,1\n500,2\n").encode(encoding))
    record = mb.read_record(tmp_path / "a.csv")
    assert (record.times.tolist(), record.values.tolist(), record.unit) == ([0.0, 0.5], [0.001, 0.002], "m")
    assert not record.notices


def test_a_name_divided_by_another_word_has_no_unit(tmp_path):
    (tmp_path / "a.csv").write_text("t,left/right\n0,1\n1,2\n")
    record = mb.read_record(tmp_path / "a.csv", column="left/right")
    assert (record.values.tolist(), record.unit, record.notices) == ([1.0, 2.0], "", ())


def test_commas_that_may_be_both_in_a_file_with_commas(tmp_path):
    (tmp_path / "a.csv").write_text(OPEN_COMMAS)
    with pytest.raises(InputError, match=r"a\.csv: all commas in its numbers may begin decimals or stand between thousands"):
        mb.read_record(tmp_path / "a.csv")
    assert mb.read_record(tmp_path / "a.csv", decimal=".").values.tolist() == [1500, 2500]
    assert mb.read_record(tmp_path / "a.csv", decimal=",").values.tolist() == [1.5, 2.5]
    (tmp_path / "a.csv").write_text(OPEN_COMMAS.replace("\n0,", '\n"0,5",'))  # the times tell
    assert mb.read_record(tmp_path / "a.csv").values.tolist() == [1.5, 2.5]


@pytest.mark.parametrize("sign", [",", ";", "\t"])
def test_an_empty_last_entry_matters_in_its_own_column_alone(tmp_path, sign):
    (tmp_path / "a.csv").write_text("t,x,y\n0,1,5\n1,2,\n2,3,6\n".replace(",", sign))
    assert mb.read_record(tmp_path / "a.csv", column="x").values.tolist() == [1, 2, 3]
    with pytest.raises(InputError, match=r"a\.csv, line 3: found an entry that is nan"):
        mb.read_record(tmp_path / "a.csv", column="y")


def test_a_first_row_of_a_time_and_nothing_is_no_header(tmp_path):
    (tmp_path / "a.csv").write_text("time,x\n12:00:00,\n12:00:01,2\n")
    with pytest.raises(InputError, match=r"a\.csv, line 2: found '12:00:00,'"):
        mb.read_record(tmp_path / "a.csv")


def test_times_without_seconds_are_not_minutes_with_decimals(tmp_path):
    (tmp_path / "a.csv").write_text("10:00,1\n10:01,2\n")  # with decimal commas 600.1 s and 601.2 s
    for options in ({}, {"step": 0.1}):
        with pytest.raises(InputError, match="found no line of numbers .* write times such as 12:30 with their seconds"):
            mb.read_record(tmp_path / "a.csv", **options)


def test_units_that_a_name_may_mean_are_noted(tmp_path):
    (tmp_path / "a.csv").write_text("t_ms,a (g)\n0,1\n500,2\n")
    record = mb.read_record(tmp_path / "a.csv")
    assert record.times.tolist() == [0, 500] and record.unit == "m/s^2"
    assert [notice.text for notice in record.notices] == [
        'a.csv: the name "t_ms" may mean ms; s is taken: give time_unit = "ms" if it does',
        'a.csv: "g" behind the name of the column is the acceleration of gravity; give unit = "gram" for a mass',
    ]
    assert record.values.tolist() == [9.80665, 19.6133]
    mass = mb.read_record(tmp_path / "a.csv", unit="gram")
    assert (mass.unit, mass.values.tolist()) == ("kg", [0.001, 0.002])
    stated = mb.read_record(tmp_path / "a.csv", time_unit="ms", unit="g")
    assert (stated.times.tolist(), stated.values.tolist(), stated.notices) == ([0, 0.5], [9.80665, 19.6133], ())


def test_a_record_in_the_time_of_a_clock_is_noted(tmp_path):
    (tmp_path / "a.csv").write_text("t,x\n1700000000,1\n1700000001.5,2\n")
    (notice,) = mb.read_record(tmp_path / "a.csv").notices
    assert "it begins at 1700000000 s, which is longer than it lasts" in notice.text
    record = mb.read_record(tmp_path / "a.csv", start="1700000000 s")
    assert record.times.tolist() == [0, 1.5] and not record.notices


@pytest.mark.parametrize("column", [2.0, True, [2]])
def test_a_column_is_a_number_or_a_name(tmp_path, column):
    (tmp_path / "a.csv").write_text("t,x\n0,1\n1,2\n")
    with pytest.raises(InputError, match=r"a\.csv: column: found .*; expected the number or the name of a column"):
        mb.read_record(tmp_path / "a.csv", column=column)
    assert mb.read_record(tmp_path / "a.csv", column=np.int64(2)).values.tolist() == [1, 2]


def test_arrays_of_one_dimension_and_of_none(tmp_path):
    np.save(tmp_path / "a.npy", np.arange(3.0))
    assert mb.read_record(tmp_path / "a.npy", step=0.1).values.tolist() == [0, 1, 2]
    np.save(tmp_path / "a.npy", np.zeros((0, 2)))
    with pytest.raises(InputError, match=r"a\.npy: found no samples in it"):
        mb.read_record(tmp_path / "a.npy")
