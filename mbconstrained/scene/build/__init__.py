"""From the tables of a scene to its equations. Read ``equations`` and ``forces``, then the model of a kind."""
