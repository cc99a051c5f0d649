"""Many models of one structure at once: stacked equations, their poles and propagators, then the family that users call.

Read ``stacked_equations`` (structure decided once), ``stacked_poles`` (eigenvalues with error estimates), ``stacked_transfer``,
``stacked_motion``, ``system_stack``, then ``family``, whose questions are answered in a file each.
"""
