"""The drawing of a scene in motion. Read ``scene_drawing`` or ``robot_drawing``, then ``result_animation``, then ``arrows``."""
