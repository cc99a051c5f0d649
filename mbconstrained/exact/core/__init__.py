"""The algebra of A(s) over a field, written once for the rationals and for rational functions of symbols.

``ring`` has power series and series at infinity; ``jordan_blocks`` has root polynomials, Jordan chains and the blocks (C, J, B) that
are read from them, ``exact_pairs`` the structure and both pairs. Imports neither flint nor sympy.
"""
