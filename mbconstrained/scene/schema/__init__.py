"""Every table and key of a scene file with its description. Read ``entry_types``, which also turns the problems of pydantic into sentences,
``scene_schema``, then the tables."""
