"""Drawings for models that bring none: where bodies stand, and how large their motion is drawn."""

from .coordinates import coordinate_drawing
from .lumped import lumped_drawing
from .robot import parts_of, robot_drawing
