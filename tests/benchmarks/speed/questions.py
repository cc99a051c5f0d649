"""Further questions that are measured beside what a user would take instead, and sizes that must not be a cliff."""

from __future__ import annotations

import itertools
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import scipy.linalg
import scipy.signal
import scipy.sparse
from scipy.sparse.linalg import eigsh, splu

import mbconstrained as mb

ROOT = Path(__file__).resolve().parents[3]

Work = Callable[[], object]


@dataclass(frozen=True)
class Question:
    """A row of the tables.

    Attributes:
        name: in words.
        make: the work of the package, and that of the peer or None; what is made before is not measured.
        peer: what the peer is.
        ratio: at most so many times the peer's time is wanted, or None.
        seconds: at most this time is wanted, s, or None.
        parts: samples of a sweep, by which its time is divided.
    """

    name: str
    make: Callable[[], tuple[Work, Work | None]]
    peer: str = ""
    ratio: float | None = None
    seconds: float | None = None
    parts: int = 1


def chain(count: int, damping: float = 1e-3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, C, K of masses between two walls that are not all alike, with light damping that modes do not separate."""
    masses = 1.0 + 0.2 * np.cos(1.7 * np.arange(count))
    K = 2 * np.eye(count) - np.eye(count, k=1) - np.eye(count, k=-1)
    return np.diag(masses), damping * K + 10 * damping * np.diag(np.arange(count) / count), K


def first_order(M: np.ndarray, C: np.ndarray, K: np.ndarray) -> np.ndarray:
    """The matrix of the states x, x'."""
    n = len(M)
    return np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])


def lumped_chain(count: int) -> mb.LumpedModel:
    """The chain as a user builds it."""
    M, _, _ = chain(count)
    model, names = mb.LumpedModel(), ["ground", *(f"m{i}" for i in range(count)), "ground"]
    for name, mass in zip(names[1:], np.diag(M)):
        model.mass(name, float(mass))
    for left, right in itertools.pairwise(names):
        model.spring(left, right, stiffness=1.0)
        model.damper(left, right, damping=0.01)
    return model


def lumped_run(count: int) -> tuple[Work, Work]:
    """A run from the elements, and lsim from matrices of the same chain."""
    times, start = np.linspace(0.0, 80.0 * (count + 1), 1000), np.sin(np.pi * np.arange(1, count + 1) / (count + 1))
    named = {f"m{i}": float(value) for i, value in enumerate(start)}
    M, _, K = chain(count)

    def lsim():
        system = (first_order(M, 0.01 * K, K), np.zeros((2 * count, 1)), np.eye(count, 2 * count), np.zeros((count, 1)))
        return scipy.signal.lsim(system, None, times, np.concatenate([start, 0 * start]))[1]

    return lambda: lumped_chain(count).assemble().solve(named)(times), lsim


def quantity(name: str) -> tuple[Work, Work]:
    """A quantity of 20 masses at times that are new each time, and the displacement."""
    motion, shift = mb.MechanicalSystem(*chain(20)).solve(np.eye(20)[0]), iter(range(10**9))
    times = np.linspace(0.0, 100.0, 1000)
    return (lambda: getattr(motion, name)(times * (1 - 1e-5 * next(shift)))), (lambda: motion(times * (1 - 1e-5 * next(shift))))


def modes(count: int, damped: bool) -> tuple[Work, Work]:
    """Shapes, residuals and shares of energy of modes, and the decomposition alone."""
    M, C, K = chain(count)

    def ours():
        found = mb.MechanicalSystem(M, C if damped else None, K).modes()
        return found.shapes, found.residuals, found.shares

    return ours, (lambda: np.linalg.eig(first_order(M, C, K))) if damped else (lambda: scipy.linalg.eigh(K, M))


def forced(force: Callable[[], mb.ImpulsiveSmooth]) -> tuple[Work, None]:
    """A run of three masses at 2000 times."""
    times = np.linspace(0.0, 100.0, 2000)
    return lambda: mb.MechanicalSystem(*chain(3, 0.01)).solve(force=force())(times), None


def impulses(count: int) -> mb.ImpulsiveSmooth:
    """One after another on the first mass."""
    one = mb.impulse([1.0, 0.0, 0.0])
    return sum((one.delayed(1.0 + 2.0 * i) for i in range(1, count)), one.delayed(1.0))


def harmonics(count: int) -> mb.ImpulsiveSmooth:
    """Harmonics of a fundamental on the first mass."""
    return sum(
        (mb.harmonic([1.0 / (i + 1), 0.0, 0.0], angular_frequency=0.013 * (i + 1)) for i in range(1, count)),
        mb.harmonic([1.0, 0.0, 0.0], angular_frequency=0.013),
    )


def constraint_rows(count: int) -> tuple[Work, Work]:
    """A run of 2 n coordinates tied in pairs, and a null space with eigh by hand."""
    rows = np.zeros((count, 2 * count))
    rows[np.arange(count), np.arange(count)], rows[np.arange(count), count + np.arange(count)] = 1.0, -1.0
    M, _, K = chain(2 * count)
    start, times = np.tile(np.sin(np.arange(count)), 2), np.linspace(0.0, 50.0, 200)

    def by_hand():
        basis = scipy.linalg.null_space(rows)
        squares, shapes = scipy.linalg.eigh(basis.T @ K @ basis, basis.T @ M @ basis)
        amplitudes = shapes.T @ (basis.T @ (M @ start))
        return basis @ shapes @ (amplitudes[:, None] * np.cos(np.outer(np.sqrt(squares), times)))

    return lambda: mb.MechanicalSystem(M, None, K, [mb.Constraint(rows)]).solve(start)(times), by_hand


def responses(count: int, lines: int, every: int) -> tuple[Work, Work]:
    """A 2 x 2 frequency response of a chain with its estimate, and one sparse factorization for each line (measured at some)."""
    M, C, K = chain(count)
    names, f = ["x1", f"x{count // 2 + 1}"], np.geomspace(1e-3, 0.6, lines)
    sparse, B = [scipy.sparse.csc_array(matrix) for matrix in (M, C, K)], np.eye(count)[:, [0, count // 2]].astype(complex)

    def factorized():
        m, c, k = sparse
        return [splu(scipy.sparse.csc_array(k + 1j * w * c - w * w * m)).solve(B) for w in 2 * np.pi * f[::every]]

    return lambda: mb.MechanicalSystem(M, C, K).frequency_response(f, names, names), factorized


def next_grid() -> tuple[Work, None]:
    """A further grid of a system that has answered before."""
    system, shift = mb.MechanicalSystem(*chain(100)), iter(range(10**9))
    grid = lambda: np.geomspace(1e-3, 3.0, 10_000) * (1 - 1e-5 * next(shift))  # noqa: E731
    system.frequency_response(grid(), ["x1", "x51"], ["x1", "x51"])
    return lambda: system.frequency_response(grid(), ["x1", "x51"], ["x1", "x51"]), None


def all_by_all(count: int = 200, lines: int = 200) -> tuple[Work, Work]:
    """Every coordinate by every force, and an inverse for each line."""
    (M, C, K), f = chain(count), np.geomspace(1e-3, 0.6, lines)
    return (
        lambda: mb.MechanicalSystem(M, C, K).frequency_response(f),
        lambda: [np.linalg.inv(K + 1j * w * C - w * w * M) for w in 2 * np.pi * f],
    )


def random_response(count: int) -> tuple[Work, None]:
    """Root mean square of the last mass on a random base, from the matrices."""
    K = 1e4 * (2 * np.eye(count + 1) - np.eye(count + 1, k=1) - np.eye(count + 1, k=-1))
    K[0, 0] = K[-1, -1] = 1e4
    M = np.diag([0.0] + [1.0] * count)
    density = mb.psd(np.geomspace(1, 1000, 11), 10.0 ** np.array([-2, -1, -1, -2, -1.5, -1, -2, -3, -2, -2, -3]), of="acceleration")

    def ours():
        system = mb.MechanicalSystem(M, 2e-4 * K, K, [mb.Constraint(np.eye(count + 1)[0], names="base")])
        return system.random_response({"base": density}, f"x{count + 1}", "acceleration").rms

    return ours, None


def shock_spectrum() -> tuple[Work, None]:
    """Of a record of 1e5 samples at 100 frequencies."""
    t = np.arange(100_000) / 1e4
    values = 100 * np.random.default_rng(0).standard_normal(len(t)) * np.exp(-t / 3)
    record, f = mb.sampled(t, values[None]), np.geomspace(5, 2000, 100)
    return lambda: mb.shock_response_spectrum(record, f, 0.05), None


def discrete(states: int, samples: int) -> tuple[Work, Work]:
    """A stable system in discrete time under given samples, and scipy.signal.dlsim."""
    A, B, C, u = discrete_matrices(states, samples)
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    system, reference = mb.DiscreteStateSpace(A, B, C), scipy.signal.StateSpace(A, B, C, np.zeros((1, 1)), dt=1.0)
    return lambda: system.solve(input=u).output(np.arange(samples)), lambda: scipy.signal.dlsim(reference, u)


def discretized(states: int, hold: int) -> tuple[Work, Work]:
    """Discretization with a hold of order 0 or 1, and scipy.signal.cont2discrete."""
    *matrices, _ = discrete_matrices(states, 1)
    system, method = (*matrices, np.zeros((1, 1))), ("zoh", "foh")[hold]
    return lambda: mb.StateSpace(*matrices).discretize(0.1, hold), lambda: scipy.signal.cont2discrete(system, 0.1, method)


def discrete_matrices(states: int, samples: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A, B, C and samples of one input."""
    random = np.random.default_rng(0)
    return tuple(random.standard_normal(shape) for shape in ((states, states), (states, 1), (1, states), (samples, 1)))


def exact_structure(chains: bool) -> tuple[Work, Work]:
    """Of a matrix of 40 rows and degree 4, over the rationals and in float64; each time without what an earlier answer has left in it."""
    fresh = partial(mb.PolynomialMatrix, np.random.default_rng(0).standard_normal((5, 40, 40)))
    if chains:
        return lambda: mb.exact.jordan_pairs(fresh()).finite.C, lambda: fresh().jordan_pairs().finite.J
    return lambda: mb.exact.structure(fresh()), lambda: fresh().structure()


def exact_referee(digits: int) -> tuple[Work, Work]:
    """The problems of the referee enclosed to so many digits, and by their numeric solutions."""
    from mbconstrained.exact.enclosure.exact_response import exact_response
    from tests.oracles.referee import NAMES, case

    problems = [case(name) for name in NAMES if not name.startswith("rot_")]

    def given():
        return ((one, mb.PolynomialMatrix(one.coefficients)) for one in problems)

    return (
        lambda: [exact_response(A, one.initial, one.force).enclose(one.times, digits) for one, A in given()],
        lambda: [mb.solve(A, one.initial, one.force)(one.times) for one, A in given()],
    )


def symbolic_example() -> tuple[Work, None]:
    """Example 5.2 of Moysis et al. with symbols: Smith form, both Jordan pairs, response."""
    import sympy

    m, k1, k2, c1, c2 = sympy.symbols("m k1 k2 c1 c2", positive=True)
    K, C = [[k1 + k2, 0, -k2], [0, 0, 0], [-k2, 0, k2]], [[0, 0, 0], [0, c1 + c2, -c2], [0, -c2, c2]]

    def ours():
        A = mb.SymbolicPolynomialMatrix([K, C, sympy.diag(0, 0, m)])
        pairs, x = A.jordan_pairs(), mb.solve_symbolically(A, [[sympy.Rational(2, 3), 1, 2], [0] * 3])
        return A.smith_form(), pairs.finite.B, pairs.infinite.J, pairs.jump_projector, x.expression, x.continuity_conditions

    return ours, None


def campbell() -> tuple[Work, Work]:
    """A Campbell diagram of 42 coordinates at 101 speeds, and numpy.linalg.eigvals at each speed."""
    discs, random, speeds = 21, np.random.default_rng(0), np.linspace(0.0, 3.0, 101)
    shaft = 2 * np.eye(discs) - np.eye(discs, k=1) - np.eye(discs, k=-1)
    K, M = np.kron(shaft, np.diag([1.0, 1.2])), np.diag(np.repeat(random.uniform(0.5, 2.0, discs), 2))
    G = np.kron(np.diag(random.uniform(0.1, 0.4, discs)), [[0.0, 1.0], [-1.0, 0.0]])
    return (
        lambda: mb.MechanicalSystem(M, 0.01 * K, K, gyroscopic=G).campbell(speeds),
        lambda: [np.linalg.eigvals(first_order(M, 0.01 * K + speed * G, K)) for speed in speeds],
    )


def families(count: int = 1000, size: int = 10) -> tuple[Work, Work]:
    """Modes of many chains of 10 masses with scattered data, and numpy.linalg.eig of each."""
    random = np.random.default_rng(0)
    M, C, K = (np.repeat(matrix[None], count, axis=0) for matrix in chain(size))
    K = K * (1 + 0.05 * random.normal(size=(count, 1, 1)))
    return (
        lambda: mb.family(M, C, K).modes().eigenvalues,
        lambda: [np.linalg.eig(first_order(M[i], C[i], K[i])) for i in range(count)],
    )


def sparse_modes(masses: int) -> tuple[Work, Work]:
    """50 modes of a chain with ties and massless joints, and ARPACK by shift and invert on the same constrained pencil."""
    from tests.mechanics.sparse.models import tied_chain

    M, _, K, rows = tied_chain(masses, damped=True)
    whole = scipy.sparse.csc_array(scipy.sparse.block_array([[K, rows.T], [rows, None]]))
    inertia = scipy.sparse.csc_array(scipy.sparse.block_diag([M, scipy.sparse.csc_array((rows.shape[0],) * 2)]))
    return lambda: mb.MechanicalSystem(M, None, K, rows).modes(count=50), lambda: eigsh(whole, 50, inertia, sigma=0.0)


def scene_of(count: int) -> str:
    """The chain as a scene."""
    names = ["ground", *(f"m{i}" for i in range(count)), "ground"]
    parts = ['[model]\nkind = "lumped"\n', *(f'[[model.mass]]\nname = "{name}"\nmass = 1.0\n' for name in names[1:-1])]
    for place, ends in enumerate(itertools.pairwise(names)):
        between = f'between = ["{ends[0]}", "{ends[1]}"]\n'
        parts += [f'[[model.spring]]\nname = "spring {place}"\n{between}stiffness = {1.0 + 0.3 * np.sin(place):.6f}\n']
        parts += [f'[[model.damper]]\nname = "damper {place}"\n{between}damping = 0.01\n']
    return "\n".join([*parts, '[initial.displacement]\nm0 = 0.1\n\n[time]\nend = "100 s"\npoints = 201\n'])


def reading(count: int) -> tuple[Work, None]:
    """``read_scene`` of masses with a spring and a damper each."""
    path = Path(tempfile.mkdtemp()) / "chain.toml"
    path.write_text(scene_of(count), encoding="utf-8")
    return lambda: mb.read_scene(path), None


def whole_scene(count: int) -> tuple[Work, None]:
    """A run of that scene with all its files."""
    folder = Path(tempfile.mkdtemp())
    (folder / "chain.toml").write_text(scene_of(count), encoding="utf-8")
    return lambda: mb.read_scene(folder / "chain.toml").run(folder / "results"), None


def large_model(answer: Callable[[mb.MechanicalSystem], object], sparse: bool = False) -> tuple[Work, None]:
    """A lumped model of 2000 masses, built and answered."""
    return lambda: answer(lumped_chain(2000).assemble(sparse=sparse)), None


def sweep(example: str, samples: int, **table) -> tuple[Work, None]:
    """A sweep of an example with so many samples, without page."""
    scene = mb.read_scene(ROOT / "examples" / f"{example}.toml")
    return lambda: scene.sweep(samples=samples, **table).run(None), None


def process(*words: str) -> Callable[[], tuple[Work, None]]:
    """A whole process; its processor time is that of the children. Compiled modules are kept from the first to the next."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    return lambda: (
        lambda: subprocess.run([sys.executable, *words], check=True, capture_output=True, cwd=ROOT, env=environment),
        None,
    )


def child_seconds() -> float:
    """Processor time of this process and of those that have ended."""
    own, children = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return own.ru_utime + own.ru_stime + children.ru_utime + children.ru_stime


#: Variation of the tuned mass damper.
DAMPER = {"tuning": "uniform(0.9, 1.0)", "zeta": "uniform(0.1, 0.2)"}

START = [0.1, *[0.0] * 1999]
TIMES = np.linspace(0.0, 100.0, 201)


def striking_chain(count: int, end: float) -> tuple[Work, None]:
    """A chain of masses between two stops under a harmonic force, phases and events anew in each run."""
    model = mb.LumpedModel()
    for i in range(count):
        model.mass(f"m{i}", 1.0 + 0.01 * i)
        model.spring(f"m{i - 1}" if i else "ground", f"m{i}", stiffness=100.0 + i)
    model.contact(f"m{count - 1}", "ground", gap=0.01, restitution=0.8)
    model.contact("ground", "m3", gap=0.02, restitution=0.9)
    system, force = model.assemble(), mb.harmonic(20.0 * np.eye(count)[0], angular_frequency=3.0)
    return lambda: system.solve(force=force, end=end), None


QUESTIONS = (
    *(
        Question(f"LumpedModel of {count} masses, elements to values", partial(lumped_run, count), "lsim", ratio=1.5)
        for count in (2, 5, 12, 24, 25)
    ),
    *(
        Question(f"{name} of 20 masses", partial(quantity, name), "displacement", ratio=2.0)
        for name in ("velocity", "acceleration", "energy")
    ),
    *(Question(f"modes, {n} masses, damped", partial(modes, n, True), "numpy.linalg.eig", ratio=1.5) for n in (20, 50)),
    *(Question(f"modes, {n} masses, undamped", partial(modes, n, False), "scipy.linalg.eigh", ratio=2.0) for n in (20, 100)),
    *(Question(f"{n} delayed impulses, 3 masses", partial(forced, partial(impulses, n)), seconds=5e-3) for n in (1, 32, 33)),
    Question("100 harmonics, 3 masses", partial(forced, partial(harmonics, 100)), seconds=0.02),
    Question("300 harmonics, 3 masses", partial(forced, partial(harmonics, 300)), seconds=0.06),
    Question("300 constraint rows", partial(constraint_rows, 300), "null space and eigh", seconds=0.3),
    Question("500 constraint rows", partial(constraint_rows, 500), "null space and eigh", seconds=0.8),
    Question("frequency response, 200 states, 10,000 lines", partial(responses, 100, 10_000, 1), "splu per line", seconds=0.1),
    Question("next grid of 10,000 lines", next_grid, seconds=0.04),
    Question("frequency response, 1000 states, 1000 lines", partial(responses, 500, 1000, 1), "splu per line", ratio=0.5),
    Question("all by all, 200 coordinates, 200 lines", all_by_all, "an inverse per line", ratio=1.0),
    Question("random response, 200 states", partial(random_response, 100), seconds=0.2),
    Question("shock response spectrum, 1e5 samples, 100 frequencies", shock_spectrum, seconds=0.2),
    Question("Campbell diagram, 42 coordinates, 101 speeds", campbell, "eigvals per speed", ratio=1.0),
    Question("modes of 1000 chains of 10 masses", families, "numpy.linalg.eig each", ratio=1.0),
    Question("50 modes of 100,000 sparse masses", partial(sparse_modes, 100_000), "ARPACK", ratio=1.0),
    Question("1000 impacts, 10 masses", partial(striking_chain, 10, 133.4), seconds=1.0),
    Question("100 impacts, 100 masses", partial(striking_chain, 100, 17.8), seconds=1.0),
    Question("read_scene, 300 masses", partial(reading, 300), seconds=0.3),
    Question("read_scene, 1000 masses", partial(reading, 1000), seconds=1.0),
    Question("LumpedModel of 2000 masses: motion", partial(large_model, lambda system: system.solve(START)(TIMES)), seconds=2.0),
    Question(
        "LumpedModel of 2000 masses, sparse: motion in 50 modes",
        partial(large_model, lambda system: system.solve(START)(TIMES), True),
        seconds=2.0,
    ),
    Question(
        "LumpedModel of 2000 masses, sparse: 50 modes", partial(large_model, lambda system: system.modes(), True), seconds=1.0
    ),
    Question("scene of 800 masses with page and files", partial(whole_scene, 800), seconds=5.0),
    Question(
        "sweep, a sample: frequencies",
        partial(sweep, "tuned_mass_damper", 1000, parameters=DAMPER, keep=["frequencies"]),
        seconds=2e-4,
        parts=1000,
    ),
    Question(
        "sweep, a sample: response peaks",
        partial(sweep, "tuned_mass_damper", 200, parameters=DAMPER, keep=["response peaks"]),
        seconds=3e-4,
        parts=200,
    ),
    Question("sweep, a posture of an arm", partial(sweep, "arm_workspace", 1), seconds=0.04, parts=121),
    Question("samples of discrete time: 40 states, 1000", partial(discrete, 40, 1000), "dlsim"),
    Question("samples of discrete time: 4 states, 100,000", partial(discrete, 4, 100_000), "dlsim"),
    *(Question(f"discretization, 40 states, hold {hold}", partial(discretized, 40, hold), "cont2discrete") for hold in (0, 1)),
    Question("exact structure, 40 rows of degree 4", partial(exact_structure, False), "float64"),
    Question("exact chains, 40 rows of degree 4", partial(exact_structure, True), "float64"),
    *(Question(f"referee problems to {digits} digits", partial(exact_referee, digits), "float64") for digits in (15, 100)),
    Question("example 5.2 with symbols", symbolic_example),
    Question("import of MechanicalSystem", process("-c", "from mbconstrained import MechanicalSystem"), seconds=0.4),
    Question("mbconstrained --version", process("-m", "mbconstrained", "--version"), seconds=0.15),
    Question("mbconstrained check", process("-m", "mbconstrained", "check", "examples/two_masses.toml"), seconds=0.6),
    Question(
        "mbconstrained run",
        process("-m", "mbconstrained", "run", "examples/two_masses.toml", "--out", tempfile.mkdtemp()),
        seconds=0.9,
    ),
)
