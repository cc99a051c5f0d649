"""Guaranteed intervals of any width that contain the response to exact data."""
