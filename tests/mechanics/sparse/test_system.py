"""What is refused at the door of a sparse system, in the user's words, and how rows are eliminated."""

import numpy as np
import pytest
import scipy.sparse as sp

import mbconstrained as mb
from mbconstrained.mechanics.sparse.pencil import eliminate, sparse_rows
from tests.mechanics.sparse.models import line

EYE = sp.eye_array(3)


@pytest.mark.parametrize(
    "given, text",
    [
        ({"mass": sp.csr_array([[np.nan]])}, r"entry at \(0, 0\) is nan"),
        ({"mass": sp.csr_array(np.ones((2, 3)))}, "square"),
        ({"mass": sp.csr_array((0, 0))}, "at least one coordinate"),
        ({"mass": 1j * EYE}, "only real"),
        ({"mass": None, "stiffness": EYE}, "needs a mass matrix"),
        ({"mass": EYE, "stiffness": sp.eye_array(4)}, "expected shape 3 x 3, found 4 x 4"),
        ({"mass": EYE, "stiffness": sp.csr_array([[1.0, 2, 0], [0, 1, 0], [0, 0, 1]])}, "x2, x1 and x1, x2 differ by 2"),
        ({"mass": EYE, "names": ["a", "b"]}, "2 names given for 3"),
        ({"mass": EYE, "names": ["a", "b", "a"]}, '"a" is used twice'),
        ({"mass": EYE, "constraints": [mb.Constraint([1, 0])]}, "found 2 entries in a row"),
        ({"mass": EYE, "constraints": [mb.Constraint([1, 0, 0], level="velocity")]}, "position level only"),
        ({"mass": EYE, "constraints": [[1, 0, 0]]}, "expected mb.Constraint"),
        ({"mass": EYE, "constraints": np.eye(3)}, "sparse matrix of rows"),
        ({"mass": EYE, "constraints": [mb.Constraint([1, 0, 0], names="a"), mb.Constraint([0, 1, 0], names="a")]}, "used twice"),
        ({"mass": EYE, "constraints": EYE}, "leave no coordinate free"),
        ({"mass": EYE, "force": [1.0]}, "expected shape 3"),
        ({"mass": EYE, "force": mb.step([1.0])}, "1 row"),
        ({"mass": EYE, "force": {"x4": 1.0}}, 'no coordinate "x4"'),
        ({"mass": EYE, "uncertainty": {"mass": np.eye(3)}}, "uncertainty: not available for sparse matrices"),
        ({"mass": EYE, "energy_parts": mb.EnergyParts({}, {})}, "energy_parts: not available for sparse matrices"),
    ],
)
def test_what_cannot_be_used_is_refused(given, text):
    with pytest.raises(mb.InputError, match=text):
        mb.MechanicalSystem(**given)


@pytest.mark.parametrize(
    "ask, text",
    [
        (lambda s: s.modes(count=0), "at least 1"),
        (lambda s: s.modes(count=2.5), "whole number"),
        (lambda s: s.solve({"crt": 1.0}), 'did you mean "cart"'),
        (lambda s: s.solve([1.0]), "expected shape 3"),
        (lambda s: s.solve([1.0, 0, np.inf]), "finite"),
        (lambda s: s.solve(force=mb.step([1.0])), "1 row"),
        (lambda s: s.solve(force=mb.impulse([1.0, 0, 0])), "Dirac impulses"),
        (lambda s: s.solve()(-1.0), "t >= 0"),
        (lambda s: s.solve([[1.0, 0, 0]]), "several motions: not available for sparse matrices"),
        (lambda s: s.solve(rank_tolerance=1e-8), "rank_tolerance: not available"),
        (lambda s: s.polynomial_matrix(), "constrained_form: not available"),
        (lambda s: s.acceleration([1.0, 0, 0], [0.0, 0, 0]), "acceleration: not available"),
        (lambda s: s.rows, "rows: not available"),
        (lambda s: s.solve().of("carp"), 'did you mean "cart"'),
        (lambda s: s.solve().of(3), "from 0 to 2"),
    ],
)
def test_questions_that_have_no_answer(ask, text):
    with pytest.raises(mb.InputError, match=text):
        ask(mb.MechanicalSystem(EYE, stiffness=line(3), names=["cart", "arm", "tip"]))


@pytest.mark.parametrize("n", [4, 1000])
def test_coordinates_that_nothing_holds(n):
    ones = sp.diags_array(np.append(np.ones(n - 1), 0.0))
    with pytest.raises(mb.SingularPolynomialMatrix, match=f'"x{n}"') as problem:
        mb.MechanicalSystem(ones, stiffness=ones).modes(count=2)
    assert problem.value.coordinates == (n - 1,)


def test_negative_stiffness_without_mass():
    with pytest.raises(mb.InputError, match="negative stiffness"):
        mb.MechanicalSystem(sp.diags_array([1.0, 0.0]), stiffness=sp.diags_array([1.0, -1.0])).modes(count=1)


def test_mass_that_is_negative():
    with pytest.raises(mb.InputError, match="mass"):
        mb.MechanicalSystem(-EYE, stiffness=line(3)).modes(count=1)


def test_values_that_break_a_constraint_are_not_repaired():
    system = mb.MechanicalSystem(EYE, stiffness=line(3), constraints=[mb.Constraint([1, -1, 0], value=0.5, names="gap")])
    with pytest.raises(mb.InputError, match='displacement: constraint "gap" has the value 0.5, the values at 0- give 0;'):
        system.solve()
    with pytest.raises(mb.InputError, match='velocity: constraint "gap" has the value 0, the values at 0- give 1;'):
        system.solve([0.5, 0, 0], [1.0, 0, 0])


def test_unsymmetric_damping_has_modes_but_no_motion():
    G = sp.csr_array([[0, 0.1, 0], [-0.1, 0, 0.0], [0, 0, 0.0]])
    system = mb.MechanicalSystem(EYE, G, line(3))
    expected = mb.MechanicalSystem(np.eye(3), G.toarray(), line(3).toarray()).modes()
    assert np.allclose(system.modes().eigenvalues, [mode.eigenvalue for mode in expected.oscillating], rtol=1e-12)
    with pytest.raises(mb.InputError, match="symmetric"):
        system.solve()


def test_rows_that_say_the_same():
    rows = [mb.Constraint([1.0, -1, 0], names="tie"), mb.Constraint(sp.csr_array([[0.1, -0.1, 0]]), names="again")]
    (notice,) = mb.MechanicalSystem(EYE, stiffness=line(3), constraints=rows).notices
    assert '"again"' in notice.text and '"tie"' in notice.text and notice.kind == "redundant"
    with pytest.raises(mb.ContradictoryConstraints, match='"other" has the value 1, but it follows from "tie"'):
        mb.MechanicalSystem(EYE, constraints=[rows[0], mb.Constraint([2.0, -2, 0], value=1, names="other")])


@pytest.mark.parametrize("seed", range(8))
def test_elimination_gives_the_null_space(seed):
    """A N = 0, A x_held = b, N of full rank with as many columns as A leaves free; rows in chains, reduced by one another."""
    random = np.random.default_rng(seed)
    k, n = 12, 20
    A = np.zeros((k, n))
    for i in range(k):
        A[i, i : i + 3] = random.integers(-3, 4, 3)
    A[-1] = A[0] - 2 * A[3]
    b = A @ random.standard_normal(n)
    found = eliminate(sparse_rows([mb.Constraint(A, value=b)], n))
    N, rank = found.basis.toarray(), np.linalg.matrix_rank(A)
    assert N.shape == (n, n - rank) and np.linalg.matrix_rank(N) == n - rank and len(found.dependent) == k - rank
    assert np.abs(A @ N).max() < 1e-12 * np.abs(N).max() and np.abs(A @ found.offset - b).max() < 1e-12 * np.abs(found.offset).max()


def test_constraints_keep_sparse_rows():
    held = mb.Constraint(sp.csr_array([[1.0, -1, 0]]), value=0.25)
    assert sp.issparse(held.rows) and repr(held) == "Constraint(1 row at position level)"
    small = mb.MechanicalSystem(np.eye(3), constraints=[held])
    assert np.array_equal(small.constraint_matrix, [[1.0, -1, 0]]) and small.rows[0].value == 0.25
    with pytest.raises(mb.InputError, match="finite"):
        mb.Constraint(sp.csr_array([[np.inf, 1.0]]))
