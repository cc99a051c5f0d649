"""What a newcomer tries: it works, or it is answered in the user's words with the nearest name; a raw error of Python is neither."""

from types import SimpleNamespace

import numpy as np
import pytest

import mbconstrained as mb
from mbconstrained.ground.by_name import answering

M, C, K = np.diag([2.0, 1.0]), np.array([[0.3, -0.3], [-0.3, 0.3]]), np.array([[13.0, -5.0], [-5.0, 5.0]])
TIMES = np.linspace(0.0, 1.0, 5)


@pytest.fixture(scope="module")
def w():
    """Objects that a newcomer has in hand."""
    model = mb.LumpedModel()
    _ = model.mass("cart", 2.0), model.mass("load", 1.0), model.spring("ground", "cart", stiffness=8.0)
    _ = model.spring("cart", "load", stiffness=5.0), model.damper("cart", "load", damping=0.3)
    system = model.assemble()
    scene = mb.read_scene("examples/two_masses.toml")
    return SimpleNamespace(
        model=model,
        system=system,
        motion=system.solve({"cart": 1.0}),
        modes=system.modes(),
        H=system.frequency_response(np.linspace(0.0, 2.0, 9)),
        random=system.random_response({"cart": mb.white_noise(1.0)}),
        scene=scene,
        run=scene.run(),
        A=mb.PolynomialMatrix([K, C, M], coordinates=["cart", "load"]),
    )


def matrices(**more):
    return mb.MechanicalSystem(M, C, K, names=["cart", "load"], **more)


FORCE = mb.step([0.0, 5.0])


#: Guesses that work, each with the same in other words.
WORKING = {
    "force by name": (lambda w: w.system.solve(force={"load": mb.step(5)})(TIMES), lambda w: w.system.solve(force=FORCE)(TIMES)),
    "own force by name": (lambda w: matrices(force={"load": mb.step(5)}).solve()(TIMES), lambda w: matrices().solve(force=FORCE)(TIMES)),
    "force of A(s)": (lambda w: mb.solve(w.A, force={"load": mb.step(5)})(TIMES), lambda w: mb.solve(w.A, force=FORCE)(TIMES)),
    "forces of A(s)": (
        lambda w: mb.solve(w.A, force=[{"load": mb.step(5)}, {"load": 0.0}])(TIMES),
        lambda w: [mb.solve(w.A, force=FORCE)(TIMES), np.zeros((2, 5))],
    ),
    "equation by name": (lambda w: mb.solve(w.A, force={"equation 2": 5})(TIMES), lambda w: mb.solve(w.A, force=FORCE)(TIMES)),
    "several motions": (
        lambda w: w.system.solve(force=[{"load": mb.step(5)}])(TIMES)[0],
        lambda w: w.system.solve(force=FORCE)(TIMES),
    ),
    "acceleration": (lambda w: w.system.acceleration([0, 0], [0, 0], {"load": mb.step(5)}), lambda w: np.array([0.0, 5.0])),
    "steady state": (
        lambda w: w.system.steady_state({"load": mb.harmonic(5.0, frequency_hz=1.0)}).displacement_amplitudes,
        lambda w: w.system.steady_state(mb.harmonic([0, 5.0], frequency_hz=1.0)).displacement_amplitudes,
    ),
    "constant force": (lambda w: loaded(5.0).solve()(TIMES), lambda w: loaded(mb.step(5.0)).solve()(TIMES)),
    "input by name": (lambda w: states().solve(input={"u1": mb.step(2.0)})(TIMES), lambda w: states().solve(input=mb.step(2.0))(TIMES)),
    "motion[name]": (lambda w: w.motion["load"](TIMES), lambda w: w.motion(TIMES)[1]),
    "velocity of it": (lambda w: w.motion["load"].derivative()(TIMES), lambda w: w.motion.velocity(TIMES)[1]),
    "displacement": (lambda w: w.motion.displacement(TIMES)["load"], lambda w: w.motion(TIMES)[1]),
    "modes[name]": (lambda w: w.modes["load"], lambda w: w.modes.shapes[1]),
    "shape": (lambda w: w.modes[0].shape["load"], lambda w: w.modes.shapes[1, 0]),
    "last mode": (lambda w: w.modes[-1].shape, lambda w: w.modes.shapes[:, -1]),
    "H[names]": (lambda w: w.H["load", "cart"], lambda w: w.H.values[1, 0]),
    "rms": (lambda w: w.random.rms["load"], lambda w: w.random.rms[1]),
    "psd": (lambda w: w.random.psd([1.0, 2.0])["load"], lambda w: w.random.psd([1.0, 2.0])[1]),
    "scene.system": (lambda w: w.scene.system.mass, lambda w: w.scene.equations.system.mass),
    "run[name]": (lambda w: w.run["q2"], lambda w: w.run.motion(w.scene.times)[2]),
    "stiffness in text": (lambda w: w.model.elements[2].stiffness, lambda w: mb.LumpedModel.spring.kind("a", "b", "8 N/m").stiffness),
}  # fmt: skip


def loaded(force):
    model = mb.LumpedModel()
    _ = model.mass("cart", 2.0), model.spring("ground", "cart", stiffness=8.0), model.force("cart", force)
    return model.assemble()


def states():
    return mb.StateSpace([[0.0, 1.0], [-4.0, -0.2]], [[0.0], [1.0]], [[1.0, 0.0]], [[0.0]])


@pytest.mark.parametrize("name", WORKING)
def test_natural_guesses_work(w, name):
    guess, same = WORKING[name]
    assert np.allclose(guess(w), same(w), rtol=1e-12, atol=1e-14) and np.shape(guess(w)) == np.shape(same(w))


#: Guesses that are answered, with a part of the answer.
ANSWERED = {
    # words of other packages
    "K=": (lambda w: mb.MechanicalSystem(M, K=K), 'there is no argument "K"; did you mean "stiffness"?'),
    "stifness=": (lambda w: mb.MechanicalSystem(M, stifness=K), 'did you mean "stiffness"?'),
    "x0=": (lambda w: w.system.solve(x0=[1, 0]), 'did you mean "displacement"?'),
    "t=": (lambda w: w.system.solve([1, 0], t=TIMES), "a motion is a function of time: solve(...)(times)"),
    "n=": (lambda w: w.system.modes(n=2), 'did you mean "count"?'),
    "input=": (lambda w: w.system.frequency_response([1.0], input="cart"), 'did you mean "inputs"?'),
    "frequency=": (lambda w: mb.harmonic(1.0, frequency=2.0), 'did you mean "frequency_hz"?'),
    "k=": (lambda w: w.model.spring("cart", "load", k=5.0), 'spring: there is no argument "k"; did you mean "stiffness"?'),
    "f=": (lambda w: w.scene.frequency(f=[1, 2]), 'unknown key "f"; known here are inputs, outputs'),
    "phases=": (lambda w: mb.SwitchedSystem(modes={}), 'there is no argument "modes"; it takes phases'),
    # missing arguments, and too many
    "no mass": (lambda w: mb.MechanicalSystem(), "MechanicalSystem: mass is missing"),
    "no stiffness": (lambda w: w.model.spring("cart", "load"), "spring: stiffness is missing; it takes start, end, stiffness"),
    "no vector": (lambda w: mb.step(), "step: vector is missing"),
    "no duration": (lambda w: mb.pulse(1.0), "pulse: duration is missing"),
    "no frequencies": (lambda w: w.random.psd(), "psd: frequencies_hz is missing"),
    "two for harmonic": (lambda w: mb.harmonic(1.0, 2.0), "expected at most 1; by name it takes angular_frequency"),
    "by position": (lambda w: w.scene.frequency([1, 2]), "frequency: found 1 argument without a name"),
    "twice": (lambda w: mb.step(1.0, vector=2.0), '"vector" is given twice'),
    "mb.Scene(path)": (lambda w: mb.Scene("examples/two_masses.toml"), 'it is made by mb.read_scene("FILE.toml")'),
    # texts, numbers, lists and mappings for one another
    "text for a matrix": (lambda w: mb.MechanicalSystem(M, stiffness="K"), "stiffness: found 'K'; expected numbers"),
    "number for a matrix": (lambda w: mb.MechanicalSystem(2.0, stiffness=8.0), "expected a matrix, of one coordinate [[2.0]]"),
    "mapping for a matrix": (lambda w: mb.MechanicalSystem({"cart": 1.0}), "mass: found {'cart': 1.0}; expected numbers"),
    "name for names": (lambda w: mb.MechanicalSystem(M, names="cart"), 'found the text "cart"; expected a list of names'),
    "number for a vector": (lambda w: w.system.solve(1.0), "displacement: expected shape 2, found a single number"),
    "unit": (lambda w: w.system.solve({"cart": "1 mm"}), "expected a number in SI units without quotes"),
    "unknown coordinate": (lambda w: w.system.solve({"cat": 1.0}), 'there is no coordinate "cat"; did you mean "cart"?'),
    "force of one row": (lambda w: w.system.solve(force=mb.step(5.0)), 'or signals by name, such as {"cart": mb.step(5.0)}'),
    "force of two rows": (lambda w: w.system.solve(force={"load": mb.step([1.0, 2.0])}), "2 rows; expected one"),
    "unknown force": (lambda w: w.system.solve(force={"cat": mb.step(5.0)}), 'force: there is no coordinate "cat"'),
    "Python function": (lambda w: w.system.solve(force={"cart": np.sin}), "mb.approximated(function, end)"),
    "mapping in a step": (lambda w: mb.step({"cart": 5}), 'inputs by name are written as force={"cart": mb.step(5.0)}'),
    "constraint by name": (lambda w: mb.Constraint({"cart": 1}), "model.constrain("),
    "list of numbers": (lambda w: w.model.constrain(["cart"]), 'expected factors by coordinate, such as {"cart": 1, "hook": -1}'),
    "signal + number": (lambda w: mb.step(5.0) + 3, "a constant input is mb.step(3)"),
    "number + signal": (lambda w: 3 + mb.step(5.0), "a constant input is mb.step(3)"),
    "time as text": (lambda w: w.motion("1 s"), "time: found '1 s'; expected a number in SI units without quotes"),
    "time before 0": (lambda w: w.motion(-1.0), "the function is defined for t >= 0"),
    "count as text": (lambda w: w.system.modes("all"), "count: found 'all'; expected a whole number"),
    "list of quantities": (lambda w: w.system.frequency_response([1.0], quantity=["mobility"]), "quantity: found ['mobility']"),
    "spectrum as number": (lambda w: w.system.random_response({"cart": 1.0}), "expected mb.psd(...) or mb.white_noise(...)"),
    "parameter as text": (lambda w: w.scene.sweep("k"), "parameters: found 'k'; expected ranges by name"),
    # attributes
    "system.eigenvalues": (lambda w: w.system.eigenvalues, 'did you mean "modes().eigenvalues"?'),
    "system.M": (lambda w: w.system.M, 'did you mean "mass"?'),
    "system.plot": (lambda w: w.system.plot(), "solve(...).plot() draws a motion"),
    "modes.omega": (lambda w: w.modes.omega, 'did you mean "natural_frequencies"?'),
    "modes.plot": (lambda w: w.modes.plot(), 'did you mean "view"?'),
    "mode.frequency": (lambda w: w.modes[0].frequency, 'did you mean "frequency_hz"?'),
    "motion.x": (lambda w: w.motion.x, 'did you mean "displacement"?'),
    "motion.cart": (lambda w: w.motion.cart, 'it is an entry: ["cart"]'),
    "motion.times": (lambda w: w.motion.times, "it is a function of time"),
    "motion.to_csv": (lambda w: w.motion.to_csv("file.csv"), 'did you mean "write"?'),
    "H.phase": (lambda w: w.H.phase, 'did you mean "np.angle(H.values)"?'),
    "random.std": (lambda w: w.random.std, 'did you mean "rms"?'),
    "model.solve": (lambda w: w.model.solve(), 'did you mean "assemble().solve"?'),
    "model.add_mass": (lambda w: w.model.add_mass("a", 1.0), 'did you mean "mass"?'),
    "scene.solve": (lambda w: w.scene.solve(), 'did you mean "run"?'),
    "signal.value": (lambda w: mb.step(1.0).derivate(), 'did you mean "derivative"?'),
    "element.k": (lambda w: w.model.elements[2].k, 'did you mean "stiffness"?'),
    # entries
    "motion[unknown]": (lambda w: w.motion["lod"], 'there is no coordinate "lod"; did you mean "load"?'),
    "motion[0]": (lambda w: w.motion[0], "expected the name of a coordinate: cart, load"),
    "modes[unknown]": (lambda w: w.modes["lod"], 'there is no "lod"; did you mean "load"?'),
    "modes[7]": (lambda w: w.modes[7], "mode: found 7; there are 2, counted from 0"),
    "modes[1.0]": (lambda w: w.modes[1.0], "mode: found 1.0; expected a whole number or a slice"),
    "H[one of two]": (lambda w: w.H["cart"], "expected those of an output and an input"),
    "rms[unknown]": (lambda w: w.random.rms["lod"], 'there is no "lod"; did you mean "load"?; there are cart, load'),
    "random[name]": (lambda w: w.random["cart"], "RandomResponse has no entries"),
    "energy[name]": (lambda w: w.motion.energy(1.0)["kinetic"], "it has an attribute: .kinetic"),
    "run[unknown]": (lambda w: w.run["x9"], 'there is no "x9"; there are x1, q1, q2'),
    # functions
    "mb.solve(scene)": (lambda w: mb.solve(w.scene), "it is solved by its method run"),
    "mb.solve(system)": (lambda w: mb.solve(w.system), "it is solved by its method solve"),
    "mb.show(3)": (lambda w: mb.show(3), "expected a motion, modes, an answer or a scene"),
    "no file": (lambda w: mb.read_scene("nothing.toml"), "nothing.toml: there is no such file"),
    "folder": (lambda w: mb.read_scene("examples"), "this is a directory"),
    "no path": (lambda w: mb.read_scene(None), "path: found None; expected a path as text"),
    "settings as text": (lambda w: mb.read_scene("examples/two_masses.toml", "time.end=3"), 'such as {"time.end": "50 s"}'),
    "no URDF": (lambda w: mb.Robot("nothing.urdf"), "nothing.urdf: there is no such URDF file"),
    "folder as number": (lambda w: w.scene.run(1), "folder: found 1; expected a path as text"),
}  # fmt: skip


@pytest.mark.parametrize("name", ANSWERED)
def test_natural_guesses_are_answered(w, name):
    guess, answer = ANSWERED[name]
    with pytest.raises(mb.MbconstrainedError) as found:
        guess(w)
    assert answer in str(found.value)


@pytest.mark.parametrize(
    "name, meant",
    [("Step", "step"), ("modes", "system.modes()"), ("load", "mb.read_scene"), ("MechanicSystem", "MechanicalSystem")],
)
def test_names_of_the_package_are_answered(name, meant):
    with pytest.raises(AttributeError) as found:
        getattr(mb, name)
    assert str(found.value) == f'mbconstrained has no "{name}"; did you mean "{meant}"?'


def test_an_error_within_a_function_is_not_that_of_its_call():
    @answering
    def outer(value):
        return len(value)

    @answering
    def outermost(value):
        return outer(value, value)

    with pytest.raises(TypeError, match=r"object of type 'int' has no len\(\)"):
        outer(3)
    with pytest.raises(mb.InputError, match="outer: found 2 arguments"):
        outermost(3)


def test_named_arrays_are_arrays(w):
    values = w.motion(TIMES)
    assert type(values * 2) is np.ndarray and type(values["load"]) is np.ndarray and type(values[1]) is np.ndarray
    assert isinstance(w.random.rms[1], float) and np.array_equal(values[["load", "cart"]], values[[1, 0]])
