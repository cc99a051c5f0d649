"""Mechanical systems M x'' + C x' + K x = f with constraint rows: constrained form, modes, motions, reactions, energy.

It imports the mathematics below (ground to papers) and no model, robot or scene. Read in this order: constraints,
element_matrix, constrained_form, system; then motion, motions, reaction, energy, modes, mode_computation; ``sparse`` is the backend for large
sparse matrices.
"""
