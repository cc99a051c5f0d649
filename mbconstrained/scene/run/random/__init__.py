"""Random vibration of a scene."""
