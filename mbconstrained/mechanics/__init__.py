"""Mechanical systems M x'' + C x' + K x = f with constraint rows: constrained form, modes, motions, reactions, energy.

It imports control and the mathematics below (ground to papers), and no model, robot or scene. Read in this order: constraints,
element_matrix, constrained_form, equations; then motion, motions, reaction, energy, modes, mode_computation, channels,
descriptor_form, system; ``normal_form`` at last. ``sparse`` is the backend for large sparse matrices.
"""
