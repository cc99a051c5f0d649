"""Public objects at the prompt and in notebooks: one short line, and tables whose texts are escaped."""

import re
from xml.etree import ElementTree

import numpy as np
import pytest
import scipy.sparse
from hypothesis import given
from hypothesis import strategies as st

import mbconstrained as mb
from mbconstrained.ground.display import TextTable, table_text, wrapped

HOSTILE = '<script>alert(1)</script> & "x"'
SIZE = 60


def chain(sparse=False):
    K = 2 * np.eye(SIZE) - np.eye(SIZE, k=1) - np.eye(SIZE, k=-1)
    return mb.MechanicalSystem(np.eye(SIZE), 0.01 * K, scipy.sparse.csr_array(K) if sparse else K)


def tied():
    tie = mb.Constraint([1.0, -1.0], value=0.5, names=HOSTILE)
    return mb.MechanicalSystem(np.diag([1.0, 3.0]), constraints=[tie], names=[HOSTILE, "b"])


def lumped():
    model = mb.LumpedModel()
    model.mass(HOSTILE, 1.0)
    model.spring("ground", HOSTILE, 2.0)
    return model


OBJECTS = {
    "polynomial matrix": lambda: chain().polynomial_matrix(),
    "structure": lambda: chain().polynomial_matrix().structure(),
    "pairs": lambda: chain().polynomial_matrix().jordan_pairs(),
    "finite pair": lambda: chain().polynomial_matrix().jordan_pairs().finite,
    "infinite pair": lambda: tied().polynomial_matrix().jordan_pairs().infinite,
    "system": tied,
    "sparse system": lambda: chain(sparse=True),
    "constrained form": lambda: tied().constrained_form(),
    "constraint row": lambda: tied().rows[0],
    "energy parts": lambda: chain().energy_parts,
    "modes": lambda: chain().modes(),
    "mode": lambda: chain().modes()[0],
    "sparse modes": lambda: chain(sparse=True).modes(count=4),
    "motion": lambda: tied().solve([1.0, 0.0], force=mb.impulse([1.0, 0.0]).delayed(1.0)),
    "motions": lambda: tied().solve(np.eye(2)),
    "sparse motion": lambda: chain(sparse=True).solve(force={"x3": 1.0}, count=4),
    "response": lambda: mb.solve(
        mb.PolynomialMatrix([np.eye(3), np.eye(3)]), np.ones((1, 3)), mb.impulse([1.0, 0.0, 0.0], order=2)
    ),
    "responses": lambda: mb.solve(mb.PolynomialMatrix([np.eye(3), np.eye(3)]), np.ones((4, 1, 3))),
    "admissibility": lambda: mb.admissible(tied().polynomial_matrix(), np.ones((2, 2))),
    "state space": lambda: mb.StateSpace(-np.eye(4), np.eye(4), np.eye(4)),
    "state space response": lambda: mb.StateSpace(-np.eye(4), np.eye(4), np.eye(4)).solve(np.ones(4)),
    "transfer": lambda: mb.StateSpace(-np.eye(4), np.eye(4), np.eye(4)).transfer(0, 0),
    "normal form": lambda: mb.mechanical_normal_form([[0, 1.0], [-1, -0.1]], [[0], [1.0]]),
    "lumped model": lumped,
    "exact structure": lambda: mb.exact.structure(tied().polynomial_matrix()),
    "exact response": lambda: mb.solve(mb.PolynomialMatrix([np.eye(3), np.eye(3)]), np.ones((1, 3))).exact,
}


@pytest.mark.parametrize("make", OBJECTS.values(), ids=OBJECTS)
def test_a_public_object_prints_as_one_short_line_and_in_a_notebook_with_well_formed_tables(make):
    shown = make()
    line = repr(shown)
    assert len(line) <= 200 and "\n" not in line and "array(" not in line and " at 0x" not in line
    if not hasattr(shown, "_repr_html_"):
        return
    text = shown._repr_html_()
    tree = ElementTree.fromstring(f"<div>{text}</div>")
    assert tree.find("p").text == line and "<script" not in text
    for table in tree.findall("table"):
        widths = {len(row) for row in table.findall("tr")}
        assert len(widths) == 1 and len(table.findall("tr")) > 1


CELLS = st.lists(st.sampled_from(["1.25", "m/s", "±", "i", "words", "of", "a", "long", "0"]), max_size=14).map(" ".join)


@given(rows=st.lists(st.tuples(CELLS, CELLS, CELLS), min_size=1, max_size=4), width=st.integers(30, 120))
def test_a_table_keeps_every_word_and_the_width(rows, width):
    """Blanks that hold a number and its unit together make parts of at most 14 letters; three of them fit on 60."""
    table = TextTable("t", ("A", "B", "C"), rows)
    text = table_text(table, width)
    found = [word for word in text.split()[1:] if word not in ("A", "B", "C", "A:", "B:", "C:")]
    assert sorted(found) == sorted(word for row in rows for cell in row for word in cell.split())
    assert max(map(len, text.splitlines())) <= width
    assert not re.search(r"\d\n|±\n", wrapped("1.25 m/s and ± 0.5 i " * 9, width))
