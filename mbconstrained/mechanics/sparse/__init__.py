"""Backend of ``MechanicalSystem`` for scipy.sparse matrices: the modes of lowest frequency, and the motion in them with a bound.

Two functions serve the room above: ``sparse_modes.sparse_modes`` and ``sparse_motion.sparse_motion``. Read in this order:
sparse_matrices (validation), pencil (elimination of constraint rows), factorization, lanczos, undamped_modes, quadratic_pencil,
damped_modes, sparse_modes; then modal_space, static_correction, sparse_motion. It imports linalg, signals and its own room.
"""
