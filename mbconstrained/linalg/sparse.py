"""Sparse systems of equations that are mostly diagonal."""

from __future__ import annotations

import numpy as np
import scipy.sparse
from scipy.sparse import csr_array


def solved(matrix: csr_array, right: csr_array | np.ndarray) -> csr_array | np.ndarray:
    """matrix^-1 @ right, sparse or not as that is; where the matrix is diagonal by division."""
    diagonal, sparse = matrix.diagonal(), scipy.sparse.issparse(right)
    if matrix.nnz == np.count_nonzero(diagonal) == matrix.shape[0]:
        return csr_array(right.multiply(1 / diagonal[:, None])) if sparse else right / diagonal[:, None]
    found = np.linalg.solve(matrix.toarray(), right.toarray() if sparse else right)
    return csr_array(found) if sparse else found
