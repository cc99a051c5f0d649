"""Models with symmetric mass and stiffness: their undamped modes, and damped ones in the coordinates of these.

Read ``symmetric_modes`` first; ``mode_refinement`` gives undamped modes whose rates span many orders of magnitude their digits.
"""
