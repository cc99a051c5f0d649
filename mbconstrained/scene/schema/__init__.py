"""Every table and key of a scene file with its description. Read ``entry_types``, ``scene_schema``, then the tables; ``validation`` turns
the problems of pydantic into sentences, ``editors`` writes JSON Schemas."""
