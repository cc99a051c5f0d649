"""Polynomial matrices A(s) = A_0 + A_1 s + ... + A_q s^q: structure, finite and infinite Jordan pairs, reductions to first order.

May import ``ground``, ``linalg`` and ``signals``. ``polynomial_matrix`` stands at the top and imports the rest, which takes A(s) as
an argument. Read in this order: ``coefficients``, ``polynomial_matrix``; ``decoupling`` (the scaled pencil and its Weierstrass form),
``structure`` (multiplicities, kernels), ``jordan_pairs``, ``kronecker_form`` (of what is not regular); for equations that need no pencil ``direct_reduction`` and ``reduced_equations``;
eigenvalues over a parameter are in ``variation``.
"""
