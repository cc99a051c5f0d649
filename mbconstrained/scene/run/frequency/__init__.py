"""Responses of a scene in addition to its run.

Read ``scene_response`` (page and files of each), ``scene_frequency`` (the frequency response), ``frequency_summary`` and ``response_page`` (how it is
printed and shown), then ``scene_random`` and ``scene_shock``.
"""
