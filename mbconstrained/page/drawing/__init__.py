"""Drawings as pure data: solids, bodies and links, paths, and their layout for lumped models, coordinates and robots."""
