"""Responses with symbols: transforms, modes, impulses, jumps, and the conditions under which there are none."""
