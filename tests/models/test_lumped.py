"""LumpedModel: assembly, factors, names, and errors in the words of who builds a model."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained import InputError
from mbconstrained.models.elements import Spring
from mbconstrained.models.lumped import LumpedModel, element_parameters


def cart_and_hook():
    model = LumpedModel()
    model.mass("cart", 10.0)
    model.node("joint")
    model.mass("hook", 2.0)
    model.spring("ground", "cart", stiffness=2.0, rest_length=0.2)
    model.spring("cart", "joint", stiffness=5.0, rest_length=0.4)
    model.damper("joint", "hook", damping=3.0)
    return model


def test_assembled_matrices_by_hand():
    system = cart_and_hook().assemble()
    assert system.names == ("cart", "joint", "hook")
    assert system.mass.tolist() == [[10, 0, 0], [0, 0, 0], [0, 0, 2]]
    assert system.stiffness.tolist() == [[7, -5, 0], [-5, 5, 0], [0, 0, 0]]
    assert system.damping.tolist() == [[0, 0, 0], [0, 3, -3], [0, -3, 3]]
    assert system.static_force.tolist() == pytest.approx([2 * 0.2 - 5 * 0.4, 5 * 0.4, 0])


def test_names_are_made_where_none_are_given():
    model = LumpedModel()
    model.mass("a", 1)
    model.mass("b", 1)
    assert [model.spring("a", "b", 1).name for _ in range(3)] == ["spring a-b", "spring a-b 2", "spring a-b 3"]
    assert model.spring("a", "b", 1, name="main spring").name == "main spring"
    assert model.constrain({"a": 1}).name == "constraint 1"
    assert model.constrain({"b": 1}).name == "constraint 2"


def test_rows_of_ties_by_hand():
    model = LumpedModel()
    for name in ("a", "b", "c"):
        model.mass(name, 1)
    for name in ("p", "q"):
        model.inertia(name, 1)
    model.rigid_tie("a", "b", distance=0.5, name="tie")
    model.lever("a", "c", start_arm=1.0, end_arm=2.0, name="lever")
    model.gear("p", "q", start_radius=0.1, end_radius=0.2, name="gear")
    model.rack("p", "b", radius=0.25, name="rack")
    model.constrain({"a": 2, "q": -1}, value=0.1, level="velocity", name="relation")
    constraints = {constraint.names[0]: constraint for constraint in model.assemble().constraints}
    expected = {
        "tie": ([-1, 1, 0, 0, 0], 0.5, "position"),
        "lever": ([1, 0, 0.5, 0, 0], 0.0, "position"),
        "gear": ([0, 0, 0, 1, 2], 0.0, "position"),
        "rack": ([0, 1, 0, -0.25, 0], 0.0, "position"),
        "relation": ([2, 0, 0, 0, -1], 0.1, "velocity"),
    }
    found = {name: (c.rows[0].tolist(), c.values[0], c.level) for name, c in constraints.items()}
    assert found == expected
    units = {row.name: row.unit for row in model.assemble().rows}
    assert units == {"tie": "m", "lever": "m", "gear": "rad", "rack": "m", "relation": "m"}


def test_rows_of_pulleys_by_hand():
    model = LumpedModel()
    for name in ("a", "b", "block"):
        model.mass(name, 1)
    model.pulley("a", "b", over="block", length=3.0)
    model.pulley("ground", "a", over="block", length=-2.0)
    rows = [(c.rows[0].tolist(), c.values[0]) for c in model.assemble().constraints]
    assert rows == [([1, 1, -2], -3.0), ([1, 0, -2], 2.0)]


def test_forces_add_up_and_act_on_their_body():
    model = cart_and_hook()
    model.force("hook", mb.step([2.0]))
    model.force("hook", mb.ramp([1.0]) + mb.impulse([4.0]))
    model.force("cart", mb.harmonic([3.0], angular_frequency=2.0))
    excitation = model.assemble().excitation
    assert excitation(0.5).tolist() == pytest.approx([3 * np.cos(1.0), 0, 2.5])
    assert excitation.impulses[0].tolist() == [0, 0, 4.0]
    assert cart_and_hook().assemble().excitation is None


def test_redundant_ties_are_told_and_contradictory_ones_refused():
    model = LumpedModel()
    for name in ("a", "b", "c"):
        model.mass(name, 1)
    model.rigid_tie("a", "b", 1.0)
    model.rigid_tie("b", "c", 2.0)
    model.rigid_tie("a", "c", 3.0)
    (notice,) = model.assemble().notices
    assert '"rigid tie a-c"' in notice.text
    model.rigid_tie("a", "c", 3.5)
    with pytest.raises(mb.ContradictoryConstraints, match='"rigid tie a-c 2" .position level. has the value 3.5 m, .* value 3 m'):
        model.assemble()


def built(method, *arguments, **named):
    def act(model):
        return getattr(model, method)(*arguments, **named)

    return act


@pytest.mark.parametrize(
    "act, message",
    [
        (built("spring", "cart", "hok", 1.0), 'spring "spring cart-hok": there is no body "hok"; did you mean "hook"'),
        (built("spring", "grond", "cart", 1.0), 'there is no body "grond"; did you mean "ground"'),
        (built("damper", "cart", "cart", 1.0), 'damper "damper cart-cart": two of its ends are on the same body'),
        (built("rigid_tie", "ground", "ground"), "two of its ends are on the same body"),
        (built("pulley", "cart", "hook", over="hook"), 'pulley "pulley cart-hook": two of its ends are on the same body'),
        (built("spring", "ground", "cart", -2.0), "stiffness: found -2; expected a number greater than zero"),
        (built("spring", "ground", "cart", 0.0), "stiffness: found 0; expected a number greater than zero"),
        (built("spring", "ground", "cart", float("nan")), "stiffness: .* a finite number"),
        (
            built("spring", "ground", "cart", "3 kg"),
            'spring "spring ground-cart": stiffness: found "3 kg", a mass; expected a stiffness',
        ),
        (built("spring", "ground", "cart", "3"), 'stiffness: found "3"; expected a stiffness.*; write its unit too'),
        (built("spring", "ground", "cart", "3 kn/m"), 'stiffness: .*there is no unit "kn"; did you mean "kN"'),
        (built("rigid_tie", "ground", "cart", "3 deg"), 'distance: found "3 deg", an angle; expected a length'),
        (built("constrain", {"cart": 1, "hook": "2 m"}), 'constraint "constraint 1": hook: found "2 m"; expected a factor in 1'),
        (built("gravity", "9.81 kg"), 'gravity: found "9.81 kg", a mass; expected an acceleration'),
        (built("spring", "ground", "cart", 1.0, rest_length=float("inf")), "rest length: .* a finite number"),
        (built("damper", "ground", "cart", -1.0), "damping: found -1; expected at least 0"),
        (built("mass", "ball", 0.0), 'mass "ball": found no mass; a point without mass is a node'),
        (built("inertia", "wheel", 0), 'inertia "wheel": found no inertia; a point without inertia is a rotational node'),
        (built("mass", "ball", -1.0), 'mass "ball": mass: found -1; expected a number greater than zero'),
        (built("mass", "cart", 1.0), 'mass: the name "cart" is already in use .mass.; names must differ'),
        (built("node", "spring ground-cart"), 'node: the name "spring ground-cart" is already in use .spring.'),
        (built("mass", "ground", 1.0), 'the name "ground" is that of the fixed body'),
        (built("mass", "  ", 1.0), "mass: found the name '  '; expected a text"),
        (built("mass", 7, 1.0), "mass: found the name 7; expected a text"),
        (built("spring", "shaft", "cart", 1.0), '"shaft" turns .rad., but a spring needs a body that moves along the axis .m.'),
        (
            built("torsion_spring", "ground", "cart", 1.0),
            '"cart" moves along the axis .m., but a torsion spring needs a body that turns .rad.',
        ),
        (built("rigid_tie", "shaft", "cart"), "one end moves along the axis .m., the other turns .rad.; use a rack"),
        (built("rack", "cart", "shaft", 0.1), 'gear is what turns, here "shaft", and rack what moves, "cart"; they are swapped'),
        (built("rack", "cart", "hook", 0.1), '"cart" moves along the axis .m., but a rack needs a body that turns'),
        (built("gear", "shaft", "wheel", 0.0, 0.1), "start radius: found 0; expected a number greater than zero"),
        (built("gear", "shaft", "wheel", 0.1), "expected both radii, both numbers of teeth, or the ratio of their speeds"),
        (built("gear", "shaft", "wheel", 0.1, 0.2, ratio=2.0), "expected both radii, both numbers of teeth, or the ratio"),
        (built("spring", "ground", "shaft", 3.0), "for bodies that turn there is torsion_spring"),
        (built("gear", "cart", "hook", 0.1, 0.1), '"cart" moves along the axis .m., but a gear needs a body that turns .rad.'),
        (built("lever", "cart", "hook", 1.0, 0.0), "end arm: found 0; expected a length that is not zero"),
        (built("rack", "shaft", "cart", 0.0), "radius: found 0; expected a length that is not zero"),
        (built("pulley", "cart", "hook", length=0.0), "length: found 0; expected a length that is not zero"),
        (built("constrain", {"cart": 1, "hooc": 1}), 'constraint "constraint 1": there is no body "hooc"; did you mean "hook"'),
        (built("constrain", {}), 'constraint "constraint 1": expected factors by coordinate, such as'),
        (built("constrain", {"cart": 1}, level="place"), "found the level 'place'; expected one of position, velocity"),
        (built("constrain", {"cart": float("nan")}), "factor of cart: .* a finite number"),
        (built("gravity", float("nan")), "gravity: .* a finite number"),
        (built("force", "hok", mb.step([1.0])), 'force: there is no body "hok"; did you mean "hook"'),
        (built("force", "ground", mb.step([1.0])), 'force: found "ground", which does not move'),
        (built("force", "cart", mb.step([1.0, 2.0])), "force of cart: found 2 rows; expected one, as of mb.step"),
        (built("force", "cart", np.sin), "force of cart: found a Python function; .* mb.approximated"),
    ],
)
def test_errors_name_what_is_wrong(act, message):
    model = cart_and_hook()
    model.inertia("shaft", 1.0)
    elements = model.elements
    with pytest.raises(InputError, match=message):
        act(model)
    assert model.elements == elements  # nothing half added


def test_texts_with_units_are_the_numbers_in_si():
    model, same = LumpedModel(), LumpedModel()
    model.mass("a", "2 kg"), same.mass("a", 2)
    model.inertia("wheel", "3 g*m^2"), same.inertia("wheel", 0.003)
    (
        model.rigid_bar("bar", "1 t", inertia="5 kg*m^2", points={"end": "20 cm"}),
        same.rigid_bar("bar", 1e3, inertia=5, points={"end": 0.2}),
    )
    model.spring("ground", "a", "3 N/mm", rest_length="5 mm"), same.spring("ground", "a", 3e3, rest_length=0.005)
    model.torsion_damper("ground", "wheel", "2 N*m*s/rad"), same.torsion_damper("ground", "wheel", 2)
    model.rigid_tie("a", "end", "30 mm"), same.rigid_tie("a", "end", 0.03)
    model.constrain({"a": 1, "wheel": "0.5 m"}, "2 mm"), same.constrain({"a": 1, "wheel": 0.5}, 0.002)
    model.rotor("disc", "4 kg"), same.rotor("disc", 4)
    model.bearing("ground", "disc", ["1 N/mm", "2 N/mm"]), same.bearing("ground", "disc", [1e3, 2e3])
    model.unbalance("disc", "20 kg*m", angle="90 deg"), same.unbalance("disc", 20, angle=np.pi / 2)
    model.gravity("-1 gn"), same.gravity(-9.80665)
    assert model.elements == same.elements and model.gravity_along == same.gravity_along
    assert np.array_equal(model.assemble().stiffness, same.assemble().stiffness)


def test_a_model_without_bodies():
    with pytest.raises(InputError, match="the model has no body; add a mass, an inertia or a node"):
        LumpedModel().assemble()


def test_massless_bodies_alone_are_a_model():
    model = LumpedModel()
    model.node("joint")
    model.spring("ground", "joint", stiffness=4.0)
    model.damper("ground", "joint", damping=2.0)
    assert np.isclose(model.assemble().solve([1.0])(0.5)[0], np.exp(-1.0))


@st.composite
def networks(draw):
    model = LumpedModel()
    count = draw(st.integers(1, 5))
    for i in range(count):
        if draw(st.booleans()):
            model.mass(f"m{i}", draw(st.floats(1e-3, 1e3)))
        else:
            model.node(f"m{i}")
    names = ["ground", *model.coordinates]
    pairs = st.tuples(st.sampled_from(names), st.sampled_from(names)).filter(lambda pair: pair[0] != pair[1])
    for start, end in draw(st.lists(pairs, max_size=8)):
        if draw(st.booleans()):
            model.spring(start, end, draw(st.floats(1e-3, 1e6)), rest_length=draw(st.floats(-1, 1)))
        else:
            model.damper(start, end, draw(st.floats(1e-3, 1e6)))
    return model


@given(networks())
def test_matrices_are_their_factors(model):
    system, factors = model.assemble(), model.incidence()
    for matrix, branches in ((system.stiffness, factors.springs), (system.damping, factors.dampers)):
        B = branches.incidence
        assert set(np.unique(B)) <= {-1.0, 0.0, 1.0}
        assert (branches.constants > 0).all()
        assert np.array_equal(matrix, matrix.T)
        assert np.allclose(matrix, B.T @ np.diag(branches.constants) @ B, rtol=1e-14, atol=1e-14 * np.abs(matrix).max(initial=0))
    assert np.array_equal(system.mass, np.diag(factors.masses))
    assert len(factors.springs.names) + len(factors.dampers.names) + len(model.coordinates) == len(model.elements)


@given(networks(), st.data())
def test_forces_of_the_system_are_those_of_its_elements(model, data):
    system = model.assemble()
    x = np.array([data.draw(st.floats(-2, 2)) for _ in model.coordinates])
    expected = np.zeros(len(x))
    place = {name: i for i, name in enumerate(model.coordinates)}
    for element in model.elements:
        if isinstance(element, Spring):
            position = {"ground": 0.0, **{name: x[i] for name, i in place.items()}}
            pull = element.stiffness * (position[element.end] - position[element.start] - element.rest_length)
            for name, sign in ((element.end, -1), (element.start, 1)):
                if name in place:
                    expected[place[name]] += sign * pull
    found = system.static_force - system.stiffness @ x
    size = np.abs(system.stiffness).max(initial=0) * 4 + np.abs(system.static_force).max(initial=0)
    assert np.allclose(found, expected, rtol=0, atol=1e-13 * size + 1e-300)


def test_a_long_chain_has_the_matrix_of_its_neighbours():
    """Of n equal springs: 2 k on the diagonal but k at the free end, -k next to it."""
    count, model = 600, LumpedModel()
    for number in range(count):
        model.mass(f"m{number}", 1.0)
        model.spring(f"m{number - 1}" if number else "ground", f"m{number}", stiffness=3.0)
    system, expected = model.assemble(), 3.0 * (2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1))
    expected[-1, -1] = 3.0
    assert np.array_equal(system.stiffness, expected)
    model.mass("later", 1.0)
    assert "later" not in system.origin.units and "later" in model.units


def long_chain(count):
    model = LumpedModel()
    for i in range(count):
        model.mass(f"m{i}", 1.0 + i / count)
        model.spring(f"m{i - 1}" if i else "ground", f"m{i}", 1000.0 + i, rest_length=0.1)
    model.damper("ground", "m0", 3.0)
    return model


def test_sparse_assembly_has_the_same_equations():
    model = long_chain(60)
    model.rigid_tie("m3", "m9")
    dense, sparse = model.assemble(), model.assemble(sparse=True)
    for name in ("mass", "damping", "stiffness"):
        assert np.allclose(getattr(sparse, name).toarray(), getattr(dense, name), rtol=1e-15)
    assert np.allclose(sparse.static_force, dense.static_force)
    assert np.allclose(
        sparse.modes(5, damped=False).natural_frequencies, dense.modes(5, damped=False).natural_frequencies, rtol=1e-9
    )


def test_rotors_have_no_sparse_matrices():
    model = LumpedModel()
    model.rotor("disc", 2.0), model.bearing("ground", "disc", stiffness=200.0)
    with pytest.raises(InputError, match="rotors"):
        model.assemble(sparse=True)


NUMBERS = st.floats(0.1, 10.0)


def vehicle() -> mb.LumpedModel:
    model = mb.LumpedModel()
    model.rigid_bar("body", 3.0, inertia=2.0, points={"rear": -1.5, "front": 1.25})
    return model


def test_coordinates_units_and_rows():
    model = vehicle()
    assert model.units == {"body": "m", "body angle": "rad", "rear": "m", "front": "m"}
    system = model.assemble()
    assert np.array_equal(system.mass, np.diag([3.0, 2.0, 0.0, 0.0]))
    assert np.array_equal(system.constraint_matrix, [[-1, 1.5, 1, 0], [-1, -1.25, 0, 1]])
    assert [row.name for row in system.rows] == ["rear on body", "front on body"]
    assert len(model.elements) == 1 and repr(model) == "LumpedModel(1 rigid bar)"


@given(mass=NUMBERS, inertia=NUMBERS, stiffness=st.tuples(NUMBERS, NUMBERS), distances=st.tuples(NUMBERS, NUMBERS))
def test_frequencies_of_two_equations_by_hand(mass, inertia, stiffness, distances):
    """A bar on two springs at -a and b: det([k1 + k2, b k2 - a k1; b k2 - a k1, a^2 k1 + b^2 k2] - w^2 diag(m, J)) = 0."""
    (k1, k2), (a, b) = stiffness, distances
    model = mb.LumpedModel()
    model.rigid_bar("bar", mass, inertia=inertia, points={"left": -a, "right": b})
    model.spring("ground", "left", k1), model.spring("ground", "right", k2)
    K = np.array([[k1 + k2, b * k2 - a * k1], [b * k2 - a * k1, a * a * k1 + b * b * k2]])
    scale = np.diag([mass**-0.5, inertia**-0.5])
    expected = np.linalg.eigvalsh(scale @ K @ scale)  # its relative errors grow with the ratio of the two
    assert model.assemble().modes().natural_frequencies ** 2 == pytest.approx(expected, abs=1e-12 * expected[-1])


def test_gravity_acts_on_its_mass():
    model = vehicle()
    model.gravity(-10.0)
    assert model.assemble().static_force.tolist() == [-30.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"points": {}}, 'rigid bar "b": points: expected distances by name'),
        ({"points": {"p": "1"}}, 'rigid bar "b": distance of "p"'),
        ({"points": {"ground": 1.0}}, 'rigid bar: the name "ground" is that of the fixed body'),
        ({"points": {"b": 1.0}}, 'its name and those of its points must differ; found "b" twice'),
        ({"points": {"m": 1.0}}, 'rigid bar: the name "m" is already in use \\(mass\\)'),
        ({"inertia": 0.0}, 'rigid bar "b": inertia: found 0'),
    ],
)
def test_what_is_wrong_is_reported_and_nothing_is_added(fields, message):
    model = mb.LumpedModel()
    model.mass("m", 1.0)
    with pytest.raises(mb.InputError, match=message):
        model.rigid_bar("b", 1.0, **{"inertia": 1.0, "points": {"p": 1.0}} | fields)
    assert model.coordinates == ("m",)
    model.rigid_bar("b", 1.0, inertia=1.0, points={"p": 1.0})
    with pytest.raises(mb.InputError, match='mass: the name "p" is already in use \\(node\\)'):
        model.mass("p", 1.0)


@pytest.mark.parametrize("internal", [False, True])
def test_a_gear_by_the_ratio_of_its_speeds(internal):
    """Hand: the motor turns 97 times for each turn of the load, which adds 97^2 of its inertia to that of the load."""
    model = mb.LumpedModel()
    model.inertia("motor", 0.1)
    model.inertia("load", 10.0)
    gear = model.gear("motor", "load", ratio=97.0, internal=internal)
    model.torsion_spring("ground", "load", 3.0)
    assert gear.row == {"motor": 1.0, "load": -97.0 if internal else 97.0}
    frequency = model.assemble().modes().natural_frequencies[0]
    assert frequency == pytest.approx(np.sqrt(3.0 / (10.0 + 0.1 * 97.0**2)), rel=1e-12)
    assert "gear motor-load.ratio" in [parameter.name for parameter in element_parameters(model)]
