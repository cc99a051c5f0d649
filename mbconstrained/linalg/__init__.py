"""Arrays in, arrays out: scaling, rank decisions, the staircase of a pencil, block diagonal forms, exponentials, more digits.

May import ``ground`` alone; flint is imported late, by ``precise``. Read in this order:

* ``arrays``, ``division``, ``scaling``, ``accurate_products``: dense and sparse matrices behind one set of operations, solutions, scale
  factors, products with twice the digits;
* ``rounding``, ``rank``: matrices with their rounding errors, elimination, and rank decisions with their evidence;
* ``staircase``, ``triangular``: a pencil s E - F split into its finite and infinite part, and the finite one as s I - T;
* ``blocks``, ``eigen``, ``symmetric``, ``tree_modes``: matrices decoupled by Schur forms, by eigenvectors, by undamped modes and by
  their topology;
* ``exponential``: e^{J t} v at many times;
* ``precise``, ``precise_blocks``: what float64 cannot tell.
"""
