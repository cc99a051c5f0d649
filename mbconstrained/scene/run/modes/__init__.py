"""The modes of a scene. Read ``scene_modes``, then ``mode_summary`` for text and ``mode_pages`` for the page."""
