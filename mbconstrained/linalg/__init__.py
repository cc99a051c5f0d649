"""Arrays in, arrays out: scaling, rank decisions, the staircase of a pencil, block diagonal forms, exponentials, more digits.

May import ``ground`` alone; flint is imported late, by ``precise``. Read in this order:

* ``arrays``, ``division``, ``scaling``: dense and sparse matrices behind one set of operations, solutions, products with twice the
  digits, scale factors;
* ``rank``: matrices with their rounding errors, elimination, and rank decisions with their evidence;
* ``staircase``, ``triangular``: a pencil s E - F split into its finite and infinite part, and the finite one as s I - T;
* ``blocks``, ``symmetric``, ``elimination`` and ``tree_modes``: matrices decoupled by Schur forms, by eigenvectors, by undamped modes
  and by their topology;
* ``exponential``, ``recursion``: e^{J t} v at many times, and from time to time;
* ``precise``: what float64 cannot tell.
"""
