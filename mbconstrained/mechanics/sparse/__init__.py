"""Backend of ``MechanicalSystem`` for scipy.sparse matrices: the modes of lowest frequency, and the motion in them with a bound.

Read in this order: pencil (validation, elimination of constraint rows, factors), undamped_modes, sparse_modes, sparse_motion, sparse_response.
"""
