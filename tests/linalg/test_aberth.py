"""All zeros of a polynomial at once against its roots."""

from __future__ import annotations

import numpy as np
import pytest

from mbconstrained.linalg.tree_modes import zeros_near

ROOTS = {
    "real ones": [-1.0, -2.0, -5.0, 3.0],
    "pairs": [-1 + 2j, -1 - 2j, 0.5 + 1j, 0.5 - 1j],
    "both": [-1 + 2j, -1 - 2j, -4.0, -0.1],
    "near the axis": [-1 + 1e-4j, -1 - 1e-4j, -3.0, -7.0],
}


@pytest.mark.parametrize("roots", ROOTS.values(), ids=ROOTS)
@pytest.mark.parametrize("start", ROOTS.values(), ids=ROOTS)
def test_pairs_become_real_zeros_and_real_zeros_pairs(roots, start):
    p = np.polynomial.Polynomial.fromroots(roots)
    p = np.polynomial.Polynomial(p.coef.real)
    found = zeros_near(lambda s: p.deriv()(s) / p(s), 1.1 * np.array(start, dtype=complex), 1e-10)
    assert len(found.all) == len(roots)
    assert np.abs(np.sort_complex(found.all) - np.sort_complex(np.array(roots, dtype=complex))).max() <= 1e-6
    assert len(found.real) == np.count_nonzero(np.imag(roots) == 0)
    assert (found.upper.imag > 0).all()


def test_what_does_not_settle_is_none():
    random = np.random.default_rng(0)
    assert zeros_near(lambda s: random.normal(size=len(s)) + 0j, np.array([1.0 + 1j, 1.0 - 1j, 2.0]), 1e-10) is None
