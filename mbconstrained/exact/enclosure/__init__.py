"""Guaranteed values: intervals of any width that contain the response, the data being the exact numbers that they are."""
