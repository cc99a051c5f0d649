"""Construction of the equations from the tables of a scene. Read ``equations`` and ``forces``, then the model of a kind."""
