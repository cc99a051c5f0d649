"""Exact answers over the rationals: floats count as exact numbers, and nothing is rounded.

Read ``rational_matrix`` (determinant and minors by interpolation, root polynomials), ``rational_ring`` (the
polynomials as the core takes them); ``flint_numbers`` has conversions and roots.
"""
