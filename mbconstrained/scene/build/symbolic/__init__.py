"""The tables of a scene with symbols: exact and named parameters (``symbolic_scene``), derivatives with respect to them (``scene_parameters``)."""
