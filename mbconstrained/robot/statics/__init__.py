"""Forces and stiffness of a robot at rest (``balance``), Newton's method (``equilibrium``), the rank of its loops (``regularity``)
and what its feet on the ground can carry (``contacts``)."""
