"""Responses of a scene in addition to its run.

Read ``scene_response`` (page and files of each), ``frequency_data`` (the frequency response), ``frequency_summary`` and ``scene_frequency`` (how it is
printed and shown), then ``scene_random`` and ``scene_shock``.
"""
