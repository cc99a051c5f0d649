"""Exact answers with symbols: masses, stiffnesses and dampings that are positive and otherwise free.

``fields`` has the arithmetic, ``radicals`` zeros in radicals, ``symbolic_matrix`` A(s) and its Jordan pairs, ``symbolic_response`` motions.
"""
