"""Exact answers: over the rationals, over rational functions of symbols, and as guaranteed intervals of a response.

May import ``polynomial``, ``signals`` and the rooms below them. Nothing heavy is loaded before a function is called.
Read ``engine`` first (root polynomials, chains, blocks and structure over any field), then its two fields, ``rational`` (floats are
the exact numbers that they are, ``kernels`` for what is not regular) and ``symbolic``, then ``enclosure`` (guaranteed digits), and ``closed_form`` with what prints it:
``formula_printers`` (text, LaTeX, MathML) and ``source_code`` (C, Python).

>>> import mbconstrained as mb
>>> A = mb.PolynomialMatrix([[[1, 0], [0, 1]], [[2, 1], [0, 0]], [[1, 0], [0, 0]]])
>>> mb.exact.structure(A).finite_zeros[0].partial_multiplicities
(2,)
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..ground.errors import InputError, SingularPolynomialMatrix
from ..polynomial.polynomial_matrix import PolynomialMatrix

if TYPE_CHECKING:
    from .engine import ExactJordanPairs, ExactStructure
    from .normal_form import ExactNormalForm
    from .symbolic.symbolic_matrix import SymbolicPolynomialMatrix


def structure(A: PolynomialMatrix | SymbolicPolynomialMatrix) -> ExactStructure:
    """The structure of A(s), finite and at infinity, without a rounding error.

    det A(s), the elementary divisors p(s)^k over the field of the entries, the Smith form diag(f_1(s), ..., f_r(s)), the zeros with
    their partial multiplicities and the orders q_1 >= ... >= q_r at infinity (Moysis et al., Eqs. 5-15). Of a ``PolynomialMatrix`` that
    is not regular also minimal bases of both kernels, with Fractions.

    >>> import mbconstrained as mb
    >>> wide = mb.exact.structure(mb.PolynomialMatrix([[[4, -1]], [[0, 0]], [[2, 0]]], ["cart", "force"]))  # 2 x'' + 4 x = force
    >>> wide.right_kernel, wide.right_minimal_indices, wide.rank
    ((PolynomialVector(cart: 1, force: 2 s^2 + 4),), (2,), 1)
    >>> found = mb.exact.structure(mb.PolynomialMatrix([[[2.0]], [[0.0]], [[1.0]]]))
    >>> [str(c) for c in found.determinant], found.finite_zeros[0].value
    (['2', '0', '1'], 1.4142135623730951j)
    """
    try:
        return jordan_pairs(A).structure
    except SingularPolynomialMatrix:
        if not isinstance(A, PolynomialMatrix):
            raise
        from .kernels import kernel_structure

        return kernel_structure(A)


def jordan_pairs(A: PolynomialMatrix | SymbolicPolynomialMatrix) -> ExactJordanPairs:
    """The finite and the infinite Jordan pair of A(s) with true Jordan chains, without a rounding error.

    A(s)^-1 = C (s I - J)^-1 B + C_inf (I - s J_inf)^-1 B_inf (Moysis et al., Theorem 2.8). Each part is computed when it is read.

    >>> import mbconstrained as mb
    >>> pairs = mb.exact.jordan_pairs(mb.PolynomialMatrix([[[1.0]], [[2.0]], [[1.0]]]))
    >>> pairs.finite.J.astype(int).tolist()
    [[-1, 1], [0, -1]]
    """
    if isinstance(A, PolynomialMatrix):
        from .engine import ExactJordanPairs
        from .rational import regular_matrix

        return ExactJordanPairs(regular_matrix(A))
    from .symbolic.symbolic_matrix import SymbolicPolynomialMatrix

    if isinstance(A, SymbolicPolynomialMatrix):
        return A.jordan_pairs()
    raise InputError(f"A: found an object of type {type(A).__name__}; expected a PolynomialMatrix or a SymbolicPolynomialMatrix")


def mechanical_normal_form(A, B, C=None, D=None, descriptor=None) -> ExactNormalForm:
    """The mechanical normal form of F x' = A x + B u, y = C x + D u without a rounding error, for regular and singular F.

    The verdict is that of the exact numbers: of the real eigenvalues only rational ones can violate the condition, since others
    have conjugates of the same multiplicity. The transformation is one of small whole numbers in the extension of B.

    Args:
        A, B, C, D, descriptor: as ``mbconstrained.mechanical_normal_form``; ints, Fractions, or floats, which are the exact numbers that they
            are.

    Returns:
        An ``ExactNormalForm`` of Fractions.

    Raises:
        NoNormalForm: a condition fails, or det(s F - A) = 0 for every s.
        InputError: shapes, entries that are not finite, dependent inputs.

    >>> import mbconstrained as mb
    >>> form = mb.exact.mechanical_normal_form([[1, -2], [3, -2]], [[1], [1]])
    >>> form.state_matrix.astype(int).tolist(), form.transformation.astype(str).tolist()
    ([[0, 1], [-4, -1]], [['-1/2', '1/2'], ['1', '0']])
    """
    from .normal_form import normal_form

    return normal_form(A, B, C, D, descriptor)
