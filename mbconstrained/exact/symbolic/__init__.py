"""Exact answers with symbols: masses, stiffnesses and dampings that are positive and otherwise free.

``field.fields`` has the arithmetic, ``symbolic_pairs`` zeros in radicals and Jordan blocks, ``symbolic_matrix`` A(s), ``response`` motions.
"""
