"""Universal files: written and read again, read by pyuff itself, and with units of other systems."""

import re

import numpy as np
import pytest
import pyuff

import mbconstrained as mb
from mbconstrained.exchange.trajectories import Curves
from mbconstrained.exchange.universal import Geometry, write_functions, write_modes
from mbconstrained.ground.errors import InputError

TIMES = np.array([0.0, 1 / 3, 0.7, 1.1])
CURVES = [
    Curves(
        "displacement", ("cart", "pendulum"), ("displacement", "angle"), ("m", "rad"), np.array([[1 / 3, 2, 3, 4], [5, 6, 7, 1e-9]])
    ),
    Curves("acceleration", ("cart",), ("acceleration",), ("m/s^2",), np.array([[9.0, 8.0, 7.0, 1 / 7]])),
]
GEOMETRY = Geometry({"cart": (7, "-X"), "pendulum": (7, "RZ")}, points={7: (0, 0, 0), 8: (1 / 8, 0, 0)}, lines=[[7, 8]])


@pytest.fixture(params=[True, False], ids=["binary", "text"])
def written(tmp_path, request):
    path = tmp_path / "run.uff"
    write_functions(path, TIMES, CURVES, GEOMETRY, "cart and pendulum", binary=request.param)
    return path, request.param


def test_functions_come_back(written):
    path, binary = written
    for name, unit, values in (
        ("cart displacement", "m", CURVES[0].values[0]),
        ("pendulum displacement", "rad", CURVES[0].values[1]),
    ):
        record = mb.read_record(path, column=name)
        assert record.unit == unit and record.name == name
        assert record.values.tolist() == values.tolist() if binary else record.values == pytest.approx(values, rel=1e-11)
        assert record.times.tolist() == TIMES.tolist() if binary else record.times == pytest.approx(TIMES, rel=1e-5)
    assert mb.read_record(path, column=3).unit == "m/s^2"


def test_header_and_units_come_first_and_geometry_follows(written):
    datasets = pyuff.UFF(str(written[0])).read_sets()
    assert [dataset["type"] for dataset in datasets] == [151, 164, 15, 82, 58, 58, 58]
    assert (datasets[1]["units_code"], datasets[1]["length"], datasets[1]["force"]) == (1, 1.0, 1.0)
    assert datasets[2]["node_nums"] == [7, 8] and datasets[2]["x"] == [0, 0.125] and datasets[3]["nodes"].tolist() == [7, 8]
    assert [(dataset["rsp_node"], dataset["rsp_dir"], dataset["ordinate_spec_data_type"]) for dataset in datasets[4:]] == [
        (7, -1, 8),
        (7, 6, 8),
        (7, -1, 12),
    ]


def test_modes_have_shapes_frequency_and_damping(tmp_path):
    modes = [(2j, np.array([1.0, -0.5])), (-0.1 + 3j, np.array([1.0, 0.25]))]
    write_modes(tmp_path / "modes.uff", modes, ("a", "b"), ("m", "rad"), Geometry(), "pair")
    first, second = pyuff.UFF(str(tmp_path / "modes.uff")).read_sets()[2:]
    assert first["analysis_type"] == 2 and first["freq"] == pytest.approx(1 / np.pi, rel=1e-5) and first["modal_damp_vis"] == 0
    assert second["modal_damp_vis"] == pytest.approx(0.1 / abs(-0.1 + 3j), rel=1e-5)
    assert (first["node_nums"].tolist(), first["r1"].tolist(), first["r4"].tolist()) == ([1, 2], [1, 0], [0, -0.5])
    assert second["id4"].strip() == "eigenvalue (-0.1+3j) 1/s"
    complex_modes = [(-0.1 + 3j, np.array([1.0, 0.5j]))]
    write_modes(tmp_path / "modes.uff", complex_modes, ("a", "b"), ("m", "m"), Geometry(), "pair")
    (mode,) = pyuff.UFF(str(tmp_path / "modes.uff")).read_sets()[2:]
    assert mode["analysis_type"] == 3 and mode["eig"] == -0.1 + 3j and mode["r1"].tolist() == [1, 0.5j]
    with pytest.raises(InputError, match="complex shapes of translations only"):
        write_modes(tmp_path / "other.uff", complex_modes, ("a", "b"), ("m", "rad"), Geometry(), "pair")


def dataset(**changes) -> dict:
    """As instruments write it: even steps, single functions."""
    base = {
        "type": 58, "func_type": 1, "id1": "force", "rsp_node": 1, "rsp_dir": 3, "ref_node": 0, "ref_dir": 0, "x": np.arange(4) / 4,
        "data": np.array([0.0, 1.0, 2.0, 4.0]), "abscissa_spacing": 1, "ordinate_spec_data_type": 13, "orddenom_spec_data_type": 0,
    }  # fmt: skip
    return base | changes


def test_units_of_other_systems_become_si(tmp_path):
    inch = {
        "type": 164,
        "units_code": 7,
        "length": 39.37007874015748,
        "force": 0.224808943099710,
        "temp": 1.8,
        "temp_offset": 459.67,
    }
    file = pyuff.UFF(str(tmp_path / "a.unv"))
    file.write_sets([inch, dataset(), dataset(ordinate_spec_data_type=12, id1="a"), dataset(rsp_dir=-4, id1="torque")], "overwrite")
    force, acceleration, torque = (mb.read_record(tmp_path / "a.unv", column=k) for k in (1, 2, 3))
    pound, inches = 4.4482216152605, 0.0254  # N, m: exact by definition
    assert force.unit == "N" and force.values == pytest.approx(pound * np.array([0, 1, 2, 4]), rel=1e-12)
    assert acceleration.unit == "m/s^2" and acceleration.values == pytest.approx(inches * np.array([0, 1, 2, 4]), rel=1e-12)
    assert torque.unit == "N*m" and torque.values == pytest.approx(pound * inches * np.array([0, 1, 2, 4]), rel=1e-12)
    assert force.times.tolist() == [0, 0.25, 0.5, 0.75]


MILLIMETRES = {"type": 164, "units_code": 5, "length": 1000.0, "force": 1.0, "temp": 1.0, "temp_offset": 273.15}


@pytest.mark.parametrize(
    ("datasets", "unit", "last", "note"),
    [
        ([dataset(ordinate_axis_units_lab="N")], "N", 4.0, ""),
        ([dataset(ordinate_axis_units_lab="kN")], "N", 4.0, 'labelled "kN", but N is its unit by data set 164'),
        ([dataset(ordinate_spec_data_type=12, ordinate_axis_units_lab="g")], "m/s^2", 4.0, 'labelled "g", but m/s.2 is'),
        ([MILLIMETRES, dataset(ordinate_spec_data_type=12, ordinate_axis_units_lab="mm/s^2")], "m/s^2", 0.004, ""),
        ([MILLIMETRES, dataset(ordinate_spec_data_type=12, ordinate_axis_units_lab="m/s^2")], "m/s^2", 0.004, "but 0.001 m/s.2 is"),
        ([dataset(ordinate_spec_data_type=0, ordinate_axis_units_lab="mm")], "m", 0.004, ""),  # of no stated kind: its label
        ([dataset(ordinate_spec_data_type=1, ordinate_axis_units_lab="counts")], "", 4.0, '"counts" .* is no known unit'),
    ],
)
def test_labels_of_axes(tmp_path, datasets, unit, last, note):
    pyuff.UFF(str(tmp_path / "a.unv")).write_sets(datasets, "overwrite")
    record = mb.read_record(tmp_path / "a.unv")
    assert record.unit == unit and record.values[-1] == pytest.approx(last, rel=1e-12)
    assert len(record.notices) == bool(note) and all(re.search(note, notice.text) for notice in record.notices)


def test_a_unit_can_be_given_where_the_file_states_no_kind(tmp_path):
    pyuff.UFF(str(tmp_path / "a.unv")).write_sets([dataset(ordinate_spec_data_type=1)], "overwrite")
    assert mb.read_record(tmp_path / "a.unv", unit="kN").values.tolist() == [0, 1000, 2000, 4000]


@pytest.mark.parametrize(
    ("datasets", "arguments", "message"),
    [
        (
            [dataset(), dataset(id1="b")],
            {},
            r"a\.uff: column: the file has 2 functions; give the number or name of one: 1 force, 2 b",
        ),
        ([dataset()], {"column": 2}, r"column: found 2; the file has 1 functions"),
        ([dataset()], {"column": 1.0}, r"column: found 1\.0; expected the number or the name of a function"),
        ([dataset()], {"column": "forse"}, r'there is no function of the name "forse"; did you mean "force"'),
        ([dataset(), dataset()], {"column": "force"}, r'several functions have the name "force"'),
        ([dataset(func_type=4)], {}, r"found no function of time"),
        ([dataset(data=np.array([1j, 0, 0, 0]))], {}, r'the function "force" is complex'),
        ([dataset(x=np.array([0.0, 2, 1, 3]), abscissa_spacing=0)], {}, r"row 3: 2 s is followed by 1 s; times must ascend"),
        ([dataset()], {"unit": "kN"}, r"its format fixes the units \(N, s\); leave out unit"),
    ],
)
def test_other_functions_are_refused(tmp_path, datasets, arguments, message):
    pyuff.UFF(str(tmp_path / "a.uff")).write_sets(datasets, "overwrite")
    with pytest.raises(InputError, match=message):
        mb.read_record(tmp_path / "a.uff", **arguments)


@pytest.mark.parametrize("content", [b"x", b"    -1\n    58\n    -1\n", b"    -1\n", bytes(500)])
def test_what_is_no_universal_file_is_refused(tmp_path, content):
    (tmp_path / "a.uff").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.uff: not a universal file that can be read"):
        mb.read_record(tmp_path / "a.uff")


def test_a_value_that_is_no_number_is_refused(tmp_path):
    pyuff.UFF(str(tmp_path / "a.uff")).write_sets([dataset()], "overwrite")
    text = (tmp_path / "a.uff").read_text()
    (tmp_path / "a.uff").write_text(text.replace("4.00000000000e+00", "              nan"))
    with pytest.raises(InputError, match='the function "force" has a value that is nan or infinite'):
        mb.read_record(tmp_path / "a.uff")


def test_a_file_that_ends_early_is_refused(tmp_path):
    write_functions(tmp_path / "a.uff", TIMES, CURVES, Geometry(), "x", binary=False)
    text = (tmp_path / "a.uff").read_text().splitlines(keepends=True)
    (tmp_path / "a.uff").write_text("".join(text[:-3] + text[-1:]))
    with pytest.raises(InputError, match=r"has \d values of the 4 that it states"):
        mb.read_record(tmp_path / "a.uff", column=3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"places": {"a": (1, "W")}}, r"places: found \(1, 'W'\) of a; expected a node and a direction"),
        ({"places": {"a": (0, "X")}}, r"found the node 0; nodes are whole numbers from 1"),
        ({"points": {1: (0, 0)}}, r"points: found \(0, 0\) of the node 1; expected x, y, z in m"),
        ({"points": {1: (0, 0, 0)}, "lines": [[1, 2]]}, r"lines: the node 2 has no point; give it in points"),
    ],
)
def test_wrong_geometry_is_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        mb.Geometry(**arguments)


def test_frequency_responses_are_read_by_pyuff(tmp_path):
    """Complex values bit by bit, frequencies, units, and the nodes and directions of output and input."""
    system = mb.MechanicalSystem(
        np.diag([1.0, 2.0]), 0.1 * np.eye(2), [[3.0, -1.0], [-1.0, 2.0]], names=["cart", "pendulum"], units=["m", "rad"]
    )
    H = system.frequency_response([0.1, 0.3, 0.35], inputs=["cart"], quantity="accelerance")
    H.write(tmp_path / "H.uff", GEOMETRY)
    datasets = pyuff.UFF(str(tmp_path / "H.uff")).read_sets()
    assert [dataset["type"] for dataset in datasets] == [151, 164, 15, 82, 58, 58]
    for dataset, values, kind in zip(datasets[4:], H.values[:, 0], ((7, -1), (7, 6))):
        assert dataset["func_type"] == 4 and dataset["abscissa_spec_data_type"] == 18
        assert (dataset["rsp_node"], dataset["rsp_dir"]) == kind and (dataset["ref_node"], dataset["ref_dir"]) == (7, -1)
        assert dataset["data"].tolist() == values.tolist() and dataset["x"].tolist() == [0.1, 0.3, 0.35]
    assert [dataset["ordinate_spec_data_type"] for dataset in datasets[4:]] == [12, 12]
    assert {dataset["orddenom_spec_data_type"] for dataset in datasets[4:]} == {13}
    with pytest.raises(InputError, match="ending"):
        H.write(tmp_path / "H.xyz")
    with pytest.raises(InputError, match="at least two"):
        H([1.0]).write(tmp_path / "one.uff")
