"""How much memory a large motion takes beside its values, counted in matrices of its states in a process of its own."""

import json
import subprocess
import sys

import pytest

#: Everything is called once with a smaller model before: what libraries keep is not counted.
SCRIPT = """
import json, tracemalloc
import numpy as np
import mbconstrained as mb

def system(count, reach, damped):
    random, stiffness, damping = np.random.default_rng(0), np.eye(count), np.zeros((count, count))
    for step in reach:
        for one in range(count - step):
            ends = np.ix_([one, one + step], [one, one + step])
            stiffness[ends] += random.uniform(1, 2) * np.array([[1, -1], [-1, 1]])
            damping[ends] += damped * random.uniform(0, 0.02) * np.array([[1, -1], [-1, 1]])
    return mb.MechanicalSystem(np.diag(random.uniform(1, 2, count)), damping, stiffness)

def peaks(count, times):
    given = system(count, {reach}, {damped})
    reduction = given.polynomial_matrix().reduction
    tracemalloc.start()
    before, found = tracemalloc.get_traced_memory()[0], []
    for shorter, evaluations in ((1.0, "once"), (0.99, "many")):
        motion = given.solve(np.eye(count)[0], evaluations=evaluations)
        tracemalloc.reset_peak()
        values = motion(shorter * times)
        most = tracemalloc.get_traced_memory()[1] - before - values.nbytes
        found.append([most / (8 * reduction.state_count**2), "decoupled" in vars(reduction)])
        del values
    tracemalloc.stop()
    return found

times = np.linspace(0.0, {end}, 1000)
peaks(60, times)
print(json.dumps(peaks(300, times)))
"""


def peaks(reach: tuple[int, ...], damped: bool, end: float = 200.0) -> list[tuple[float, bool]]:
    """Of one run, and of one with the modes: memory beyond the values, and whether modes were known after it."""
    script = SCRIPT.format(reach=reach, damped=float(damped), end=end)
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    return [tuple(pair) for pair in json.loads(done.stdout)]


@pytest.mark.parametrize("reach, damped", [((1,), True), ((1, 7), False)])
def test_modes_of_a_chain_and_without_damping_take_less_than_three_matrices(reach, damped):
    """Half of the vectors' entries are kept, and what makes the rows; the rest is made when it is used."""
    found = peaks(reach, damped, end=2e4)
    assert found[-1][1]
    assert max(matrices for matrices, _ in found) <= 2.5


@pytest.mark.long
def test_powers_take_eight_matrices_and_modes_three():
    """Eight for SciPy's exponential; vectors and their inverse, with what makes the rows of them."""
    (powers, by_modes), (modes, _) = peaks((1, 7), True)
    assert not by_modes
    assert powers <= 8.0 and modes <= 3.0
