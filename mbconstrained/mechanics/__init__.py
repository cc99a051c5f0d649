"""Mechanical systems M x'' + C x' + K x = f with constraint rows: constrained form, modes, motions, reactions, energy.

It imports control and the mathematics below (ground to frequency), and no model, robot or scene. Read in this order: element_matrix,
constraints, energy, parameter, equations; channels, motion, motions, modes; harmonic_response, random_excitation, peaks,
rotating, root_locus, sensitivities; descriptor_form, system. Then family with its stacks of matrices, and normal_form. ``sparse`` is the
backend for large sparse matrices.
"""
