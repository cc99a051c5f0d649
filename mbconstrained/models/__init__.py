"""Models that assemble into a ``MechanicalSystem``: lumped elements along an axis, and matrices from files.

It imports mechanics and the mathematics below. Read in this order: elements, lumped; matrices on its own.
"""
