"""Models that assemble into a ``MechanicalSystem``: lumped elements along an axis.

It imports mechanics and the mathematics below. Read in this order: elements, rotor, lumped.
"""
