"""Exact answers with symbols: masses, stiffnesses and dampings that are positive and otherwise free.

``fields`` has the arithmetic, ``symbolic_pairs`` zeros in radicals and Jordan blocks, ``symbolic_matrix`` A(s), ``inverse_transform`` and
``symbolic_response`` motions.
"""
