"""[[motion]] tables: supports that move, with units and levels, and what is wrong with them."""

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.errors import SceneError
from tests.scene.scenes import scene_of

CAR = """
[model]
kind = "lumped"
node = [{ name = "left" }, { name = "right" }]
mass = [{ name = "car", mass = "2 kg" }]
spring = [{ between = ["left", "car"], stiffness = "8 N/m" }]
damper = [{ between = ["right", "car"], damping = "0.5 N*s/m" }]
[time]
end = "4 s"
points = 9
"""
SINE = (
    '[[motion]]\nfactors = { left = 1, right = 0.5 }\nkind = "harmonic"\nvalue = "10 mm"\nfrequency = "1 Hz"\nphase = "-90 deg"\n'
)


def test_supports_move_by_multiples_of_one_signal(tmp_path):
    scene = scene_of(tmp_path, CAR + SINE)
    system, result = scene.equations.system, scene.run()
    assert [row.name for row in system.rows] == ["motion of left", "motion of right"]
    ground = 0.01 * np.sin(2 * np.pi * result.times)
    assert np.abs(result.values[:2] - [ground, 0.5 * ground]).max() <= 1e-16


@pytest.mark.parametrize(
    "level, value, order",
    [("position", "1 cm", 0), ("velocity", "36 km/h", 1), ("acceleration", "2 m/s^2", 2), ("acceleration", "0.3 g", 3)],
)
def test_the_unit_of_the_value_is_that_of_the_level(tmp_path, level, value, order):
    entry = f'[[motion]]\ncoordinate = "left"\nkind = "step"\nvalue = "{value}"\nlevel = "{level}"\nname = "road"\n'
    other = '[[motion]]\ncoordinate = "right"\nkind = "step"\nvalue = 0\n'
    motion = scene_of(tmp_path, CAR + entry + other).equations.solve()
    expected = {0: 0.01, 1: 10.0, 2: 2.0, 3: 0.3 * 9.80665}[order]
    assert motion.derivative(min(order, 2))(1.0)[0] == pytest.approx(expected, rel=1e-15)
    assert {row.name for row in motion.system.rows} == {"road", "motion of right"}


def test_a_motion_without_a_kind_is_a_support_at_rest(tmp_path):
    rest = "".join(f'[[motion]]\ncoordinate = "{name}"\n' for name in ("left", "right"))
    still = "[initial]\ndisplacement = { car = 0.1 }\n"
    motion = scene_of(tmp_path, CAR + rest + still).equations.solve()
    assert not motion([0.0, 1.0, 3.0])[:2].any()
    assert motion(1.0)[2] == pytest.approx(mb.MechanicalSystem([[2.0]], [[0.5]], [[8.0]]).solve([0.1])(1.0)[0], rel=1e-13)
    with pytest.raises(SceneError, match=r'found "3 m/s\^2", an acceleration; .*; with level = "acceleration" it fits$'):
        scene_of(tmp_path, CAR + rest + 'value = "3 m/s^2"\n')


def test_a_record_of_a_file_moves_the_support(tmp_path):
    (tmp_path / "road.csv").write_text("0,0\n1,0.1\n2,0\n", encoding="utf-8")
    entry = '[[motion]]\nfactors = { left = 1, right = 1 }\nkind = "sampled"\nfile = "road.csv"\n'
    motion = scene_of(tmp_path, CAR + entry).equations.solve()
    assert motion([0.5, 1.0, 3.0])[0].tolist() == pytest.approx([0.05, 0.1, 0.0], abs=1e-16)


def test_a_record_in_g_is_an_acceleration(tmp_path):
    (tmp_path / "quake.csv").write_text("0,0\n1,0.1\n2,0\n", encoding="utf-8")
    entry = (
        '[[motion]]\nfactors = { left = 1, right = 1 }\nkind = "sampled"\nfile = "quake.csv"\nunit = "g"\nlevel = "acceleration"\n'
    )
    motion = scene_of(tmp_path, CAR + entry).equations.solve()
    assert motion.acceleration(0.5)[0] == pytest.approx(0.05 * 9.80665, rel=1e-14)


@pytest.mark.parametrize(
    "entry, texts",
    [
        ('coordinate = "lift"\nkind = "step"\nvalue = 1', ['motion[1]: there is no coordinate "lift"; did you mean "left"?']),
        ('coordinate = "left"\nkind = "step"\nvalue = "1 N"', ['motion[1]: value: found "1 N", a force; expected a length']),
        ('kind = "step"\nvalue = 1', ["give either coordinate or factors"]),
        ('coordinate = "left"\nfactors = { left = 1 }\nkind = "step"\nvalue = 1', ["give either coordinate or factors"]),
        ('coordinate = "left"\nkind = "step"\nvalue = 1\nlevel = "speed"', ["level", "speed", "velocity"]),
        (
            'coordinate = "left"\nkind = "step"\nvalue = 1\n[[motion]]\ncoordinate = "left"\nkind = "step"\nvalue = 2\nname = "b"',
            ['"b"', '"motion of left"', "make the motions agree"],
        ),
    ],
)
def test_what_is_wrong_is_reported_with_its_place(tmp_path, entry, texts):
    with pytest.raises(SceneError) as error:
        scene_of(tmp_path, CAR + f"[[motion]]\n{entry}\n")
    assert all(text in str(error.value) for text in texts), str(error.value)


def test_a_formula_of_a_prescribed_motion_is_refused_with_its_reason(tmp_path):
    scene = scene_of(tmp_path, CAR + SINE + "[output]\nformula = true\n")
    assert any(
        "no formula with symbols for a model with prescribed motions" in notice.text
        for notice in scene.run(tmp_path / "out").notices
    )
