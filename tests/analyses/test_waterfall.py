"""Lines of a waterfall: what those before them hide is not drawn."""

import numpy as np

from mbconstrained.analyses.campbell import _spectra


def test_a_peak_hides_the_lines_behind_it():
    """A peak of 3 at 5 on the first line; the second line, 1 above, is visible where the triangle is below it."""
    x, y = _spectra(np.array([0.0, 1.0]), np.array([[5.0, 8.0]]), np.array([[3.0, 0.0]]), 1.0, 10.0)
    parts = np.split(np.arange(len(x)), np.flatnonzero(np.isnan(y)))
    lines = [part[~np.isnan(y[part])] for part in parts]
    first, left, right = (line for line in lines if len(line))
    assert np.interp([0, 4, 4.5, 5, 6, 10], x[first], y[first]).tolist() == [0, 0, 1.5, 3, 0, 0]
    assert (y[left] == 1).all() and (y[right] == 1).all()
    assert (
        x[left][0] == 0 and abs(x[left][-1] - (4 + 1 / 3)) < 0.01 and abs(x[right][0] - (6 - 1 / 3)) < 0.01 and x[right][-1] == 10
    )
    assert len(x) < 20  # corners alone
