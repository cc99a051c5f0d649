"""Exact answers with symbols: masses, stiffnesses and dampings that are positive and otherwise free.

Read ``symbolic_matrix`` (A(s), its adjugate and determinant, root polynomials), ``symbolic_ring`` and
``symbolic_pairs`` (zeros in radicals, Jordan blocks, assumptions), then ``response``; ``field`` has the arithmetic below them.
"""
